#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/path_backtrace.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/search_back.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/smooth/curved_faces.hpp"
#include "gelight/geodesic/smooth/fans.hpp"
#include "gelight/geodesic/smooth/fitted_normals.hpp"
#include "gelight/geodesic/smooth/lifted_path.hpp"
#include "gelight/geodesic/smooth/path_marks.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
struct SmoothOptions {
  /// Edges at which the mesh turns by more than this are creases, across which nothing is smoothed.
  /// In radians.
  T crease_angle = T(0.7);
  /// Further creases, as pairs of vertices.
  std::vector<std::array<Index, 2>> creases{};
  /// Where the surface along a path is less smooth than this, distances on the mesh are taken. It
  /// is the mean square of how unevenly normals turn along the path, over that of how they turn: 0
  /// on a smooth surface of fine faces, about 1 on noise.
  T most_roughness = T(0.3);
  /// Asked now and then while solving; when it answers true, Cancelled is thrown.
  CancelHook cancelled{};
};

/// What a distance on the smooth surface is worth.
enum class SmoothTrust : unsigned char {
  smooth,  ///< The length of the straightest path there.
  /// The length of a path there, with which another competes: on the cut locus, where fronts meet,
  /// that which is shorter on the mesh may be the longer one, and about a focal point none is
  /// straightest. An upper bound, but for what smooth distances are off.
  bound,
  rough  ///< The distance on the mesh: a path over it runs along no smooth surface.
};

/// Distances on the smooth surface that a mesh stands for.
template <std::floating_point T>
struct SmoothDistances {
  std::vector<T> distance;  ///< Of each vertex, +infinity where no path leads.
  std::vector<Vec3<T>>
      direction;  ///< Unit tangent in which the path arrives; zero where none does.
  std::vector<SmoothTrust> trust;  ///< Of each vertex.
  ExactField<double> mesh;         ///< The distances on the mesh that they are made of.
};

/// A path on the smooth surface; where trust is rough, on the mesh. Its length and the source's
/// start distance sum to the distance.
///
/// The length is that of the straightest path beside the one on the mesh, which may pass a vertex
/// on its other side. Positions are where that path crosses the edges that the one on the mesh
/// does, or those edges drawn out by a quarter; where their order along the path would be reversed
/// they are one point. Straight lines between them cut the arcs: on ellipsoids of 162 to 2,562
/// vertices with axes of 1 to 0.3, normals given, they were shorter than the length by 0.2 to 0.004
/// % on average, longer by 0.6 % at most, 4 % in one path; positions were off the surface by 2e-3
/// to 1e-4.
template <std::floating_point T>
struct SmoothPath {
  std::vector<Vec3<T>> positions;  ///< About where it runs, beginning at the source.
  Path<T> on_mesh;  ///< The shortest path on the mesh, above which it was begun: as many points.
  T length = 0;     ///< On the smooth surface, an arc between every two positions.
  Vec3<T> direction{0, 0, 0};               ///< Unit tangent on arrival.
  SmoothTrust trust = SmoothTrust::smooth;  ///< What the length is worth.
};

/// Geodesic distance on the smooth surface of which a mesh has the vertices.
///
/// The shortest paths of the mesh are found exactly, lifted to a surface that is curved over each
/// edge as the normals at its ends say, moved sideways until they are straight there (one Newton
/// step), and measured. What is left of the mesh's error is by the fourth power of edge times
/// curvature where normals are given, by the third or so where they are fitted to the vertices.
///
/// Creases and borders stay sharp; the curve of a crease is smooth where both its sides are. Where
/// a mesh is noisy, so that normals do not turn evenly along a path, the distance on the mesh is
/// returned, and `trust` says so. A point of an edge or face means the point of the smooth surface
/// over it, which `position` tells.
///
/// Construction is linear in the mesh. A solve takes an exact one and a step for each face that
/// each vertex's path crosses: 4.4 to 7 times the exact one's time on 10,242 vertices of a sphere
/// and of needles, as benchmarks/pareto_benchmark.cpp prints, and more on larger meshes, whose
/// paths cross more faces. Queries are const and safe from several threads.
///
/// Distances that are not exact are no shorter way to the same: it is the paths that take the time.
/// On smooth meshes of 2,562 to 10,368 vertices, paths to which those of fast marching or virtual
/// sources lead were off by 2 to 2,500 times as much; (4 d1 - d0) / 3, d1 on the mesh with each
/// face split in four, was off by 0.03 to 0.12 % from fast marching, 0.002 to 0.01 % from virtual
/// sources. VirtualSourceSolver by itself takes a hundredth of the time, and is off by half to five
/// sixths of what exact distances on the mesh are. benchmarks/claims.cpp prints these errors.
template <std::floating_point T>
class SmoothDistanceSolver : public detail::DistanceQueries<SmoothDistanceSolver<T>, T> {
 public:
  /// With normals fitted to the vertices around each. Throws InvalidInput as Surface does, for a
  /// crease angle that is not between 0 and pi, a crease that is no edge.
  explicit SmoothDistanceSolver(const TriangleMesh auto& mesh, SmoothOptions<T> options = {})
      : SmoothDistanceSolver(Surface<Real>(mesh, options.cancelled.part(0, 0)),
                             std::span<const std::array<T, 3>>(), false, options) {}

  /// With the surface's unit normals at the vertices, all on one side of it. At creases, where a
  /// vertex has several, they are fitted. Throws InvalidInput besides for normals that are not as
  /// many as vertices, not unit by more than 0.005, or against the faces where most are along them.
  SmoothDistanceSolver(const TriangleMesh auto& mesh, std::span<const std::array<T, 3>> normals,
                       SmoothOptions<T> options = {})
      : SmoothDistanceSolver(Surface<Real>(mesh, options.cancelled.part(0, 0)), normals, true,
                             options) {}

  /// The mesh.
  [[nodiscard]] const Surface<double>& surface() const { return exact_.surface(); }

  /// The point of the smooth surface over a point of the mesh. Throws InvalidInput for a point that
  /// is not of the mesh.
  [[nodiscard]] Vec3<T> position(const SurfacePoint<T>& point) const {
    surface().require_point(point);
    const auto p = detail::simplified(surface(), point.template cast<Real>());
    using Kind = typename SurfacePoint<Real>::Kind;
    const Vec3<Real> origin(0, 0, 0);
    if (p.kind == Kind::face)
      return faces_->in_face(p.element[0], p.weights, origin).template cast<T>();
    if (p.kind == Kind::vertex) return cast<T>(surface().position(p.element[0]));
    Index h = surface().find_halfedge(p.element[0], p.element[1]);
    const Real t = p.weights[surface().origin(h) == p.element[0] ? 1 : 0];
    return cast<T>(faces_->on_edge(h, t, origin).place);
  }

  /// The unit normals at a vertex: one, and more where creases meet.
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

  /// Solves from a vertex, several, or points with start distances. Throws InvalidInput as every
  /// solver does, Cancelled where the options' hook says so.
  ///@{
  [[nodiscard]] SmoothDistances<T> solve(Index vertex) const {
    return solve(std::span<const Index>(&vertex, 1));
  }
  [[nodiscard]] SmoothDistances<T> solve(std::initializer_list<Index> vertices) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  [[nodiscard]] SmoothDistances<T> solve(const Source<T>& source) const {
    return solve(std::span<const Source<T>>(&source, 1));
  }
  [[nodiscard]] SmoothDistances<T> solve(std::span<const Index> vertices) const {
    return solve_checked(detail::checked_sources(surface(), vertices));
  }
  [[nodiscard]] SmoothDistances<T> solve(std::span<const Source<T>> sources) const {
    return solve_checked(detail::checked_sources(surface(), sources));
  }
  ///@}

  /// The path on the smooth surface from the source to a point; empty where none leads. Throws
  /// InvalidInput for a point that is not of the mesh. The distances are those of this solver.
  ///@{
  [[nodiscard]] SmoothPath<T> path(const SmoothDistances<T>& distances, Index vertex) const {
    return path(distances, vertex_point<T>(vertex));
  }
  [[nodiscard]] SmoothPath<T> path(const SmoothDistances<T>& distances,
                                   const SurfacePoint<T>& point) const {
    surface().require_point(point);
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
    out.length = detail::distance_as<T>(is_rough ? lift.on_mesh() : found.shortest(), "a point");
    out.direction = cast<T>(found.direction);
    if (is_rough) {
      for (const auto& p : on_mesh) out.positions.push_back(cast<T>(surface().position(p)));
    } else {
      for (const auto& p : lift.places()) out.positions.push_back(cast<T>(p));
    }
    return out;
  }
  ///@}

 private:
  friend class detail::DistanceQueries<SmoothDistanceSolver<T>, T>;
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Fans = detail::Fans<Real>;
  using Faces = detail::CurvedFaces<Real>;
  using Lift = detail::LiftedPath<Real>;
  using Marks = detail::PathMarks<Real>;
  using Lifted = detail::LiftedLength<Real>;
  using Solution = detail::WindowSolution<Real>;

  SmoothDistanceSolver(const Surface<Real>& surface, std::span<const std::array<T, 3>> normals,
                       bool has_normals, SmoothOptions<T> options)
      : options_(std::move(options)), exact_(surface) {
    detail::require(options_.crease_angle > 0 && options_.crease_angle < std::numbers::pi_v<T>,
                    "the crease angle is ", options_.crease_angle, ", not between 0 and pi");
    detail::require(options_.most_roughness >= 0, "the greatest roughness is ",
                    options_.most_roughness);
    const Fans fans(surface, Real{options_.crease_angle}, options_.creases);
    if (has_normals) require_normals(fans, normals);
    detail::Array<Vec3<Real>> of_fans;
    of_fans.reserve(static_cast<std::size_t>(fans.count()));
    detail::FittedNormals<Real> fitted(fans);
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

  static Vec3<Real> normal_of(std::span<const std::array<T, 3>> normals, Index vertex) {
    const auto& [x, y, z] = normals[static_cast<std::size_t>(vertex)];
    return detail::stable_unit(Vec3<Real>(Real{x}, Real{y}, Real{z}));
  }

  static void require_normals(const Fans& fans, std::span<const std::array<T, 3>> normals) {
    const Surface<Real>& surface = fans.surface();
    detail::require(normals.size() == static_cast<std::size_t>(surface.vertex_count()),
                    "there are ", normals.size(), " normals, the mesh has ", surface.vertex_count(),
                    " vertices");
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      const auto& [x, y, z] = normals[static_cast<std::size_t>(v)];
      const T length = detail::stable_norm(Vec3<T>(x, y, z));
      detail::require(std::abs(length - 1) <= T(detail::beyond_full_light), "the normal (", x, ", ",
                      y, ", ", z, ") of vertex ", v, " is not unit");
    }
    // A normal tells the surface's side as its faces do, or all do the opposite.
    std::ptrdiff_t along = 0;
    detail::Array<Index> against[2];
    for (Index fan = 0; fan < fans.count(); ++fan) {
      if (fans.corners(fan).size() != surface.corners(fans.vertex(fan)).size()) continue;
      const Real cosine = dot(fans.mean_normal(fan), normal_of(normals, fans.vertex(fan)));
      along += cosine > 0 ? 1 : cosine < 0 ? -1 : 0;
      if (cosine != 0) against[cosine > 0].push_back(fans.vertex(fan));
    }
    const auto& odd = against[along < 0];
    detail::require(odd.empty(), "the normal of vertex ", odd.empty() ? 0 : odd[0],
                    " points to the other side of its faces than those of most vertices");
  }

  [[nodiscard]] SmoothTrust trust(const Lifted& found) const {
    if (!(found.roughness <= Real{options_.most_roughness})) return SmoothTrust::rough;
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
    detail::Array<End> ends;  // of each vertex
    detail::Array<char> is_done;
  };
  using Pool = detail::Pool<std::optional<Memory>>;
  using Borrowed = typename Pool::Borrowed;

  [[nodiscard]] Memory& memory(const Borrowed& borrowed) const {
    auto& held = *borrowed;
    if (!held) held.emplace(faces_, exact_.empty_solution({}));
    return *held;
  }

  void solve_vertices(detail::DistanceQuery<Real>& query) const {
    const Borrowed borrowed(*pool_);
    Memory& memory = this->memory(borrowed);
    std::swap(memory.solution.sources, query.sources);
    solve_into(memory);
    for (Index v = 0; v < surface().vertex_count(); ++v) {
      query.distance[v] = memory.ends[v].distance;
    }
  }

  [[nodiscard]] SmoothDistances<T> solve_checked(detail::Array<Source<Real>> sources) const {
    const Borrowed borrowed(*pool_);
    Memory& memory = this->memory(borrowed);
    memory.solution.sources = std::move(sources);
    solve_into(memory);
    SmoothDistances<T> out{{}, {}, {}, ExactField<Real>(std::move(memory.solution))};
    memory.solution = exact_.empty_solution({});
    Index v = 0;
    for (const End& end : memory.ends) {
      out.distance.push_back(detail::distance_as<T>(end.distance, "vertex ", v++));
      out.direction.push_back(cast<T>(end.direction));
      out.trust.push_back(end.trust);
    }
    return out;
  }

  // From the solution's sources: how the path of each vertex ends.
  void solve_into(Memory& memory) const {
    ExactOptions<Real> options;
    options.cancelled = options_.cancelled.part(0, 0.3);
    Solution& solution = memory.solution;
    solution.cancelled = options.cancelled;
    exact_.solve_into(solution, options);
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
    const detail::PathBacktrace<Real> backtrace(solution);
    backtrace.follow(v, marks);
    if (marks.size() < 2) return {mesh_distance};
    Lifted found = lift.measure(marks);
    if (!backtrace.is_shortest(marks.point(marks[0]), lift.on_mesh(), v)) {
      found = lift.measure(searched(solution, v));
    }
    const Real on_mesh = lift.on_mesh();
    End end{mesh_distance - on_mesh + found.shortest(), found.direction, trust(found), on_mesh};
    if (end.trust == SmoothTrust::rough) end.distance = mesh_distance;
    return end;
  }

  // The path to a vertex where the arrivals do not tell it.
  [[nodiscard]] static detail::Array<SurfacePoint<Real>> searched(const Solution& solution,
                                                                  Index v) {
    const auto end = detail::PointQuery<Real>(solution).at_vertex(v);
    auto path = detail::PathBacktrace<Real>(solution).back(
        end, [&] { return detail::SearchBack<Real>(solution).back(end); });
    std::reverse(path.begin(), path.end());
    return path;
  }

  // Where paths of neighbours come from different sides, that which is shorter on the mesh may not
  // be so on the smooth surface.
  void mark_cut_locus(detail::Array<End>& ends) const {
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
    using namespace detail::arithmetic;
    constexpr Real most_turn = 3, most_bend = 0.3;
    if (!(a.on_mesh > 0 && b.on_mesh > 0)) return false;
    const Real turn = detail::stable_norm(Vec3<Real>(a.direction - b.direction));
    return turn > most_bend + most_turn * apart / std::min(a.on_mesh, b.on_mesh);
  }

  SmoothOptions<T> options_;
  ExactSolver<Real> exact_;
  std::shared_ptr<const Faces> faces_;
  std::shared_ptr<Pool> pool_ = std::make_shared<Pool>();
};

/// Deduces the type from the mesh.
template <TriangleMesh M>
explicit SmoothDistanceSolver(const M&) -> SmoothDistanceSolver<MeshScalar<M>>;
template <TriangleMesh M>
SmoothDistanceSolver(const M&, SmoothOptions<MeshScalar<M>>) -> SmoothDistanceSolver<MeshScalar<M>>;
template <TriangleMesh M, class Normals>
SmoothDistanceSolver(const M&, const Normals&) -> SmoothDistanceSolver<MeshScalar<M>>;
template <TriangleMesh M, class Normals>
SmoothDistanceSolver(const M&, const Normals&, SmoothOptions<MeshScalar<M>>)
    -> SmoothDistanceSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class SmoothDistanceSolver<float>;
GELIGHT_ONCE template class detail::DistanceQueries<SmoothDistanceSolver<float>, float>;
GELIGHT_ONCE template class SmoothDistanceSolver<double>;
GELIGHT_ONCE template class detail::DistanceQueries<SmoothDistanceSolver<double>, double>;
}  // namespace gelight
#endif
