#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/engine.hpp"
#include "gelight/geodesic/exact/path_backtrace.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/search_back.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/smooth/curved_faces.hpp"
#include "gelight/geodesic/smooth/fans.hpp"
#include "gelight/geodesic/smooth/fitted_normals.hpp"
#include "gelight/geodesic/smooth/lifted_path.hpp"
#include "gelight/geodesic/smooth/path_marks.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What a SmoothDistanceSolver works in.
template <std::floating_point T>
class SmoothEngine {
  using Real = typename WorkingPrecision<T>::Real;
  using Fans = detail::Fans<Real>;
  using Faces = CurvedFaces<Real>;
  using Lift = LiftedPath<Real>;
  using Marks = PathMarks<Real>;
  using Lifted = LiftedLength<Real>;
  using Solution = WindowSolution<Real>;

 public:
  SmoothEngine(const Surface<Real>& surface, std::span<const std::array<T, 3>> normals,
               bool has_normals, SmoothOptions<T> options)
      : options_(std::move(options)), exact_(surface) {
    require(options_.crease_angle > 0 && options_.crease_angle < std::numbers::pi_v<T>,
            "the crease angle is ", options_.crease_angle, ", not between 0 and pi");
    require(options_.most_roughness >= 0, "the greatest roughness is ", options_.most_roughness);
    const Fans fans(surface, static_cast<Real>(options_.crease_angle), options_.creases);
    if (has_normals) require_normals(fans, normals);
    Array<Vec3<Real>> of_fans;
    of_fans.reserve(static_cast<std::size_t>(fans.count()));
    FittedNormals<Real> fitted(fans);
    for (Index fan = 0; fan < fans.count(); ++fan) {
      const Index v = fans.vertex(fan);
      const bool is_given = has_normals && fans.corners(fan).size() == surface.corners(v).size();
      of_fans.push_back(is_given ? normal_of(normals, v) : fitted.normal(fan));
      if (fan % 256 == 0) {
        options_.cancelled.check(static_cast<double>(fan) / fans.count(),
                                 "the smooth solver's set-up");
      }
    }
    faces_ = std::make_shared<const Faces>(fans, of_fans);
  }

  /// The mesh.
  [[nodiscard]] const Surface<double>& surface() const { return exact_.surface(); }

  [[nodiscard]] Vec3<T> position(const SurfacePoint<T>& point) const {
    surface().require_point(point);
    const auto p = simplified(surface(), point.template cast<Real>());
    using Kind = typename SurfacePoint<Real>::Kind;
    const Vec3<Real> origin(0, 0, 0);
    if (p.kind == Kind::face)
      return faces_->in_face(p.element[0], p.weights, origin).template cast<T>();
    if (p.kind == Kind::vertex) return cast<T>(surface().position(p.element[0]));
    Index h = surface().find_halfedge(p.element[0], p.element[1]);
    const Real t = p.weights[surface().origin(h) == p.element[0] ? 1 : 0];
    return cast<T>(faces_->on_edge(h, t, origin).place);
  }

  [[nodiscard]] std::vector<Vec3<T>> normals(Index vertex) const {
    surface().require_vertex(vertex);
    std::vector<Index> fans;
    std::vector<Vec3<T>> out;
    for (const Index h : surface().corners(vertex)) {
      const Index fan = faces_->fans().at(h);
      if (std::find(fans.begin(), fans.end(), fan) != fans.end()) continue;
      fans.push_back(fan);
      out.push_back(cast<T>(faces_->normal(h)));
    }
    return out;
  }

  [[nodiscard]] SmoothPath<T> path(const SmoothDistances<T>& distances,
                                   const SurfacePoint<T>& point) const {
    surface().require_point(point);
    require_same_mesh(surface(), solution_of(distances.mesh).surface, "the distances were");
    const auto on_mesh = distances.mesh.path(point.template cast<Real>());
    SmoothPath<T> out;
    for (const auto& p : on_mesh) out.on_mesh.push_back(p.template cast<T>());
    if (on_mesh.size() < 2) {
      if (!on_mesh.empty()) out.positions.push_back(position(point));
      return out;
    }
    Lift lift(*faces_);
    const Lifted found = lift.measure(on_mesh);
    out.trust = trust(found);
    const bool is_rough = out.trust == SmoothTrust::rough;
    out.length = distance_as<T>(is_rough ? lift.on_mesh() : found.shortest(), "a point");
    out.direction = cast<T>(found.direction);
    if (is_rough) {
      for (const auto& p : on_mesh) out.positions.push_back(cast<T>(surface().position(p)));
    } else {
      for (const auto& p : lift.places()) out.positions.push_back(cast<T>(p));
    }
    return out;
  }

  void solve_vertices(DistanceQuery<Real>& query) const {
    const Borrowed borrowed(*pool_);
    Memory& memory = this->memory(borrowed);
    std::swap(memory.solution.sources, query.sources);
    solve_into(memory);
    for (Index v = 0; v < surface().vertex_count(); ++v) {
      query.distance[v] = memory.ends[v].distance;
    }
  }

  [[nodiscard]] SmoothDistances<T> solve_checked(Array<Source<Real>> sources) const {
    const Borrowed borrowed(*pool_);
    Memory& memory = this->memory(borrowed);
    memory.solution.sources = std::move(sources);
    solve_into(memory);
    SmoothDistances<T> out{
        {}, {}, {}, ExactField<Real>(std::make_shared<const Solution>(std::move(memory.solution)))};
    memory.solution = exact_.engine_->empty_solution({});
    Index v = 0;
    for (const End& end : memory.ends) {
      out.distance.push_back(distance_as<T>(end.distance, "vertex ", v++));
      out.direction.push_back(cast<T>(end.direction));
      out.trust.push_back(end.trust);
    }
    return out;
  }

 private:
  static Vec3<Real> normal_of(std::span<const std::array<T, 3>> normals, Index vertex) {
    const auto& [x, y, z] = normals[static_cast<std::size_t>(vertex)];
    return stable_unit(
        Vec3<Real>(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)));
  }

  static void require_normals(const Fans& fans, std::span<const std::array<T, 3>> normals) {
    const Surface<Real>& surface = fans.surface();
    require(normals.size() == static_cast<std::size_t>(surface.vertex_count()), "there are ",
            normals.size(), " normals, the mesh has ", surface.vertex_count(), " vertices");
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      const auto& [x, y, z] = normals[static_cast<std::size_t>(v)];
      const T length = stable_norm(Vec3<T>(x, y, z));
      require(std::abs(length - 1) <= T(beyond_full_light), "the normal (", x, ", ", y, ", ", z,
              ") of vertex ", v, " is not unit");
    }
    // A normal tells the surface's side as its faces do, or all do the opposite.
    std::ptrdiff_t along = 0;
    Array<Index> against[2];
    for (Index fan = 0; fan < fans.count(); ++fan) {
      if (fans.corners(fan).size() != surface.corners(fans.vertex(fan)).size()) continue;
      const Real cosine = dot(fans.mean_normal(fan), normal_of(normals, fans.vertex(fan)));
      along += cosine > 0 ? 1 : cosine < 0 ? -1 : 0;
      if (cosine != 0) against[cosine > 0].push_back(fans.vertex(fan));
    }
    const auto& odd = against[along < 0];
    require(odd.empty(), "the normal of vertex ", odd.empty() ? 0 : odd[0],
            " points to the other side of its faces than those of most vertices");
  }

  [[nodiscard]] SmoothTrust trust(const Lifted& found) const {
    if (!(found.roughness <= static_cast<Real>(options_.most_roughness))) return SmoothTrust::rough;
    return found.is_least ? SmoothTrust::smooth : SmoothTrust::bound;
  }

  // How a path ends at a vertex.
  struct End {
    Real distance;
    Vec3<Real> direction{0, 0, 0};
    SmoothTrust trust = SmoothTrust::smooth;
    Real on_mesh = 0;  // length of the path there
  };

  // What is used again by later queries.
  struct Memory {
    Memory(std::shared_ptr<const Faces> of, Solution empty)
        : faces(std::move(of)), solution(std::move(empty)), lift(*faces), marks(faces->surface()) {}

    std::shared_ptr<const Faces> faces;
    Solution solution;
    Lift lift;
    Marks marks;
    Array<End> ends;  // of each vertex
    Array<char> is_done;
  };
  using Pool = detail::Pool<std::optional<Memory>>;
  using Borrowed = typename Pool::Borrowed;

  [[nodiscard]] Memory& memory(const Borrowed& borrowed) const {
    auto& held = *borrowed;
    if (!held) held.emplace(faces_, exact_.engine_->empty_solution({}));
    return *held;
  }

  // From the solution's sources: how the path of each vertex ends.
  void solve_into(Memory& memory) const {
    ExactOptions<Real> options;
    options.cancelled = options_.cancelled.part(0, 0.3);
    Solution& solution = memory.solution;
    solution.cancelled = options.cancelled;
    exact_.engine_->solve_into(solution, options);
    const Index count = surface().vertex_count();
    auto& ends = memory.ends;
    auto& is_done = memory.is_done;
    ends.clear();
    for (Index v = 0; v < count; ++v)
      ends.push_back({solution.distances[v] + solution.starts.at(v)});
    // Vertices in the order of the faces, as their neighbours' paths run by the same edges.
    is_done.assign(static_cast<std::size_t>(count), 0);
    Index done = 0;
    for (Index h = 0; h < surface().halfedge_count(); ++h) {
      const Index v = surface().origin(h);
      if (is_done[v]) continue;
      is_done[v] = 1;
      ends[v] = end_of(memory, v);
      if (done++ % 64 == 0) ask(0.3 + 0.6 * done / count);
    }
    mark_cut_locus(ends);
  }

  void ask(double done) const { options_.cancelled.check(done, "the smooth solve"); }

  [[nodiscard]] End end_of(Memory& memory, Index v) const {
    Lift& lift = memory.lift;
    Marks& marks = memory.marks;
    const Solution& solution = memory.solution;
    const Real mesh_distance = memory.ends[v].distance;
    const PathBacktrace<Real> backtrace(solution);
    backtrace.follow(v, marks);
    if (marks.size() < 2) return {mesh_distance};
    Lifted found = lift.measure(marks);
    if (!backtrace.is_shortest(marks.point(marks[0]), lift.on_mesh(), v)) {
      found = lift.measure(searched(solution, v));
    }
    const Real on_mesh = lift.on_mesh();
    // No path is shorter than none, but by rounding.
    const Real distance =
        std::max(mesh_distance - on_mesh + found.shortest(), solution.starts.at(v));
    End end{distance, found.direction, trust(found), on_mesh};
    if (end.trust == SmoothTrust::rough) end.distance = mesh_distance;
    return end;
  }

  // The path to a vertex where the arrivals do not tell it.
  [[nodiscard]] static Array<SurfacePoint<Real>> searched(const Solution& solution, Index v) {
    const auto end = PointQuery<Real>(solution).at_vertex(v);
    auto path = PathBacktrace<Real>(solution).back(
        end, [&] { return SearchBack<Real>(solution).back(end); });
    std::reverse(path.begin(), path.end());
    return path;
  }

  // Where paths of neighbours come from different sides, that which is shorter on the mesh may not
  // be so on the smooth surface.
  void mark_cut_locus(Array<End>& ends) const {
    for (Index h = 0; h < surface().halfedge_count(); ++h) {
      const Index u = surface().origin(h), v = surface().tip(h);
      // Directions turn at creases, too.
      if (!faces_->fans().is_smooth(u) || !faces_->fans().is_smooth(v)) continue;
      End &a = ends[u], &b = ends[v];
      if (!meet(a, b, surface().length(h))) continue;
      for (End* end : {&a, &b}) {
        if (end->trust == SmoothTrust::smooth) end->trust = SmoothTrust::bound;
      }
    }
  }

  // Whether two ends so far apart are of fronts that meet: directions of one turn by about their
  // distance over its radius, and as the surface does.
  static bool meet(const End& a, const End& b, Real apart) {
    using namespace arithmetic;
    constexpr Real most_turn = 3, most_bend = 0.3;
    if (!(a.on_mesh > 0 && b.on_mesh > 0)) return false;
    const Real turn = stable_norm(Vec3<Real>(a.direction - b.direction));
    return turn > most_bend + most_turn * apart / std::min(a.on_mesh, b.on_mesh);
  }

  SmoothOptions<T> options_;
  ExactSolver<Real> exact_;
  std::shared_ptr<const Faces> faces_;
  std::shared_ptr<Pool> pool_ = std::make_shared<Pool>();
};

}  // namespace gelight::detail
