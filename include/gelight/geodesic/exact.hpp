#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/detail/planar_faces.hpp"
#include "gelight/geodesic/detail/trace.hpp"
#include "gelight/geodesic/detail/window_propagation.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// What a solver throws when its caller's `cancelled` hook says so.
class Cancelled : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <std::floating_point T>
struct ExactOptions {
  /// Distances beyond this one are not computed; they are reported as +infinity. In the unit of the
  /// positions, counted as the result is: including the sources' start distances.
  T max_distance = unreachable<T>;
  /// Where not empty, distances beyond that of the farthest target are not computed; they are
  /// reported as +infinity.
  std::vector<SurfacePoint<T>> targets{};
  /// Asked now and then while solving; when it answers true, the solver throws Cancelled.
  std::function<bool()> cancelled{};
  /// Keeps all windows, about 56 bytes each and some dozens per edge, so that a query at a point
  /// that is no vertex looks only at its own face. Without, such a query searches its way back to
  /// the source; the answer is the same.
  bool keep_windows = false;
};

/// One way in which a point is reached.
template <std::floating_point T>
struct ExactArrival {
  T distance;         ///< Length of the path, with the source's start distance.
  Vec3<T> direction;  ///< Unit tangent in the direction of travel; zero at a source.
};

/// Exact geodesic distances from the sources of one solve, with paths and directions of arrival, at
/// the vertices and anywhere between them. Made by ExactSolver::solve. Queries are const and safe
/// from several threads.
template <std::floating_point T>
class ExactField {
 public:
  /// Distance of each vertex, +infinity where no path leads.
  [[nodiscard]] std::vector<T> distances() const {
    std::vector<T> out;
    out.reserve(distances_.size());
    for (const double d : distances_) out.push_back(static_cast<T>(d + offset_));
    return out;
  }

  /// Distance of a vertex, in constant time.
  [[nodiscard]] T distance(Index vertex) const {
    surface_.require_vertex(vertex);
    return static_cast<T>(distances_[vertex] + offset_);
  }
  [[nodiscard]] T distance(const SurfacePoint<T>& point) const {
    return static_cast<T>(nearest(point).distance + offset_);
  }

  /// The shortest path from the source to a point; its length and the source's start distance are
  /// the point's distance. Empty where no path leads, the point alone at a source. Of several
  /// shortest paths one is returned.
  [[nodiscard]] Path<T> path(Index vertex) const { return path(vertex_point<T>(vertex)); }
  [[nodiscard]] Path<T> path(const SurfacePoint<T>& point) const {
    const std::vector<Point> back = trace(point);
    Path<T> out;
    out.reserve(back.size());
    for (auto p = back.rbegin(); p != back.rend(); ++p) out.push_back(p->template cast<T>());
    return out;
  }

  /// The unit tangent in which the shortest path travels on arrival. Zero at a source and where no
  /// path leads. Of several shortest paths one is taken; `arrivals` gives all.
  [[nodiscard]] Vec3<T> direction(Index vertex) const { return direction(vertex_point<T>(vertex)); }
  [[nodiscard]] Vec3<T> direction(const SurfacePoint<T>& point) const {
    return direction_of(nearest(point)).template cast<T>();
  }

 private:
  template <std::floating_point>
  friend class ExactSolver;
  using Mesh = Surface<double>;
  using Point = SurfacePoint<double>;

  // The end of a path: from a vertex of the face, or straight from an image across `last.entry`.
  struct End {
    double distance = unreachable<double>;
    Point point;
    detail::Arrival last;   // or how it comes
    Vec2<double> at{0, 0};  // the point in last.entry's frame
  };

  explicit ExactField(const Mesh& surface) : surface_(surface) {}

  [[nodiscard]] End nearest(const SurfacePoint<T>& point) const {
    surface_.require_point(point);
    const Point p = snapped(point.template cast<double>());
    return p.kind == Point::Kind::vertex ? at_vertex(p) : at_point(p);
  }

  // A point with a share of exactly zero lies on an edge or a vertex.
  static Point snap(const Mesh& surface, const Point& p) {
    if (p.kind == Point::Kind::vertex) return p;
    const bool on_face = p.kind == Point::Kind::face;
    const std::array<Index, 3> v =
        on_face ? surface.face(p.element[0]) : std::array<Index, 3>{p.element[0], p.element[1], -1};
    std::vector<int> used;
    for (int k = 0; k < (on_face ? 3 : 2); ++k) {
      if (p.weights[static_cast<std::size_t>(k)] > 0) used.push_back(k);
    }
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    if (used.size() == 1) return vertex_point<double>(v[at(used[0])]);
    if (used.size() == 2 && on_face) {
      return edge_point<double>(v[at(used[0])], v[at(used[1])], p.weights[at(used[1])]);
    }
    return p;
  }
  Point snapped(const Point& p) const { return snap(surface_, p); }

  [[nodiscard]] End at_vertex(const Point& p) const {
    const Index v = p.element[0];
    End end{distances_[v], p, arrivals_[v], {0, 0}};
    if (end.last.entry >= 0) end.at = faces_->apex(end.last.entry);
    return end;
  }

  [[nodiscard]] End at_point(const Point& p) const {
    End best;
    best.point = p;
    for_each_face(p, [&](Index f, const std::array<double, 3>& weights) {
      from_corners(p, f, best);
      if (keeps_windows_) through_windows(f, weights, best);
    });
    from_sources(p, best);
    return best;
  }

  // Calls visit(face, barycentric coordinates of p in it) for each face that holds p.
  void for_each_face(const Point& p, const auto& visit) const {
    if (p.kind == Point::Kind::face) return visit(p.element[0], p.weights);
    const Index first = surface_.find_halfedge(p.element[0], p.element[1]);
    Index h = first;
    do {
      const bool same = surface_.origin(h) == p.element[0];
      std::array<double, 3> weights{0, 0, 0};
      weights[static_cast<std::size_t>(h % 3)] = p.weights[same ? 0 : 1];
      weights[static_cast<std::size_t>((h + 1) % 3)] = p.weights[same ? 1 : 0];
      visit(Mesh::face_of(h), weights);
      h = surface_.twin(h);
    } while (h != first);
  }

  void from_corners(const Point& p, Index f, End& best) const {
    const Vec3<double> position = surface_.position(p);
    for (const Index v : surface_.face(f)) {
      const Vec3<double> way = position - surface_.position(v);
      const double d = distances_[v] + way.stableNorm();
      if (d < best.distance) {
        best.distance = d;
        best.last = {{0, 0}, detail::Arrival::from_vertex, v};
      }
    }
  }

  void from_sources(const Point& p, End& best) const {
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      if (!share_face(p, sources_[s].point)) continue;
      const Vec3<double> way = surface_.position(p) - surface_.position(sources_[s].point);
      const double d = sources_[s].distance + way.stableNorm();
      if (d > best.distance) continue;
      best.distance = d;
      best.last = {{0, 0}, detail::Arrival::from_source, static_cast<Index>(s)};
    }
  }

  [[nodiscard]] bool share_face(const Point& p, const Point& q) const {
    bool shared = false;
    for_each_face(p, [&](Index f, const auto&) {
      const auto v = surface_.face(f);
      const auto has = [&](Index i) { return std::find(v.begin(), v.end(), i) != v.end(); };
      const auto [a, b] = q.element;
      if (q.kind == Point::Kind::face) shared |= a == f;
      if (q.kind == Point::Kind::edge) shared |= has(a) && has(b);
      if (q.kind == Point::Kind::vertex) shared |= has(a);
    });
    return shared;
  }

  void through_windows(Index f, const std::array<double, 3>& weights, End& best) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      const auto k = static_cast<std::size_t>(h % 3);
      const Vec2<double> at = weights[(k + 1) % 3] * Vec2<double>(surface_.length(h), 0) +
                              weights[(k + 2) % 3] * faces_->apex(h);
      for (Index i = windows_.first[h]; i < windows_.first[h + 1]; ++i) {
        const auto& w = windows_.windows[i];
        const double d = w.start + detail::distance_through(w.begin, w.end, w.x, w.y, at);
        if (d >= best.distance) continue;
        best.distance = d;
        best.last = {{w.x, w.y}, h, w.origin};
        best.at = at;
      }
    }
  }

  [[nodiscard]] Vec3<double> direction_of(const End& end) const {
    using Arrival = detail::Arrival;
    if (end.last.entry == Arrival::none) return Vec3<double>::Zero();
    if (end.last.entry >= 0) return in_space(end.last.entry, end.at - end.last.image);
    const Vec3<double> from = end.last.entry == Arrival::from_vertex
                                  ? surface_.position(end.last.origin)
                                  : surface_.position(source_point(end.last.origin));
    return (surface_.position(end.point) - from).stableNormalized();
  }

  [[nodiscard]] const Point& source_point(Index source) const {
    return sources_[static_cast<std::size_t>(source)].point;
  }

  // A direction of the plane of half-edge h's face.
  [[nodiscard]] Vec3<double> in_space(Index h, const Vec2<double>& direction) const {
    const Vec3<double> o = surface_.position(surface_.origin(h));
    const Vec3<double> x = (surface_.position(surface_.tip(h)) - o).stableNormalized();
    const Vec3<double> to_apex = surface_.position(surface_.apex(h)) - o;
    const Vec3<double> y = (to_apex - x.dot(to_apex) * x).stableNormalized();
    return (direction.x() * x + direction.y() * y).stableNormalized();
  }

  [[nodiscard]] std::vector<Point> trace(const SurfacePoint<T>& point) const {
    const End end = nearest(point);
    if (!(end.distance < unreachable<double>)) return {};
    const detail::Trace tracer(surface_, *faces_, sources_, distances_, arrivals_, origins_);
    return tracer.back(end.point, end.at, end.last);
  }

  Mesh surface_;
  std::shared_ptr<const detail::PlanarFaces> faces_;
  detail::Sources sources_;          // their distances less the offset
  double offset_ = 0;                // the least start distance
  detail::Array<double> distances_;  // of each vertex, less the offset
  detail::Array<detail::Arrival> arrivals_;
  detail::Array<detail::Origin> origins_;
  detail::KeptWindows windows_;
  bool keeps_windows_ = false;
};

/// Exact geodesic distance on a triangle mesh: the length of the shortest path over its faces.
///
/// Constructed once from a mesh, in O(vertices + faces log valence); queries are const and safe
/// from several threads. A mesh may have borders, any genus, several components, edges of three
/// faces or more (paths turn into each of them) and vertices where several fans meet (paths pass
/// through). Memory and time of a solve follow the wavefront: about (vertices)^1.5 windows in all
/// and vertices in memory, unless windows are kept.
///
/// J. S. B. Mitchell, D. M. Mount, C. H. Papadimitriou, "The discrete geodesic problem", 1987,
/// doi:10.1137/0216045; Y. Qin, X. Han, H. Yu, Y. Yu, J. Zhang, "Fast and exact discrete geodesic
/// computation based on triangle-oriented wavefront propagation", 2016,
/// doi:10.1145/2897824.2925930.
template <std::floating_point T>
class ExactSolver : public detail::DistanceQueries<ExactSolver<T>, T> {
 public:
  /// Throws InvalidInput as Surface does, and for options that do not fit the mesh.
  explicit ExactSolver(const TriangleMesh auto& mesh, ExactOptions<T> options = {})
      : surface_(mesh),
        faces_(std::make_shared<const detail::PlanarFaces>(surface_)),
        options_(std::move(options)),
        pool_(std::make_shared<Pool>()) {
    require_options(options_);
  }

  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

  /// Solves from a vertex, from several, or from points with start distances. Throws InvalidInput
  /// for no source, a source that is not of the mesh or starts with a distance that is not finite,
  /// and for options that do not fit the mesh; Cancelled where the hook of the options says so.
  [[nodiscard]] ExactField<T> solve(Index vertex) const { return solve(vertex, options_); }
  [[nodiscard]] ExactField<T> solve(Index vertex, const ExactOptions<T>& options) const {
    return solve(std::span<const Index>(&vertex, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Index> vertices) const {
    return solve(vertices, options_);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Index> vertices,
                                    const ExactOptions<T>& options) const {
    return solve_checked(detail::checked_sources(surface_, vertices), options);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Source<T>> sources) const {
    return solve(sources, options_);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Source<T>> sources,
                                    const ExactOptions<T>& options) const {
    return solve_checked(detail::checked_sources(surface_, sources), options);
  }
  [[nodiscard]] ExactField<T> solve(const SurfacePoint<T>& source) const {
    return solve(source, options_);
  }
  [[nodiscard]] ExactField<T> solve(const SurfacePoint<T>& source,
                                    const ExactOptions<T>& options) const {
    const Source<T> one{source, 0};
    return solve(std::span<const Source<T>>(&one, 1), options);
  }

 private:
  friend class detail::DistanceQueries<ExactSolver<T>, T>;
  using Workspace = detail::WindowPropagation;

  // Memory of earlier solves, one piece for each that ever ran at the same time.
  struct Pool {
    std::mutex mutex;
    std::vector<std::unique_ptr<Workspace>> idle;

    std::unique_ptr<Workspace> take() {
      const std::lock_guard lock(mutex);
      if (idle.empty()) return std::make_unique<Workspace>();
      auto workspace = std::move(idle.back());
      idle.pop_back();
      return workspace;
    }
    void put(std::unique_ptr<Workspace> workspace) {
      const std::lock_guard lock(mutex);
      idle.push_back(std::move(workspace));
    }
  };

  void require_options(const ExactOptions<T>& options) const {
    detail::require(!(options.max_distance != options.max_distance),
                    "the greatest distance is not a number");
    for (const auto& target : options.targets) surface_.require_point(target);
  }

  [[nodiscard]] detail::Array<double> solve_vertices(const detail::Sources& sources) const {
    const ExactField<T> field = solve_checked(sources, options_, false);
    detail::Array<double> out;
    out.reserve(field.distances_.size());
    for (const double d : field.distances_) out.push_back(d + field.offset_);
    return out;
  }

  [[nodiscard]] ExactField<T> solve_checked(detail::Sources sources, const ExactOptions<T>& options,
                                            bool keep_windows = true) const {
    require_options(options);
    ExactField<T> field(surface_);
    field.faces_ = faces_;
    field.offset_ = unreachable<double>;
    for (auto& source : sources) {
      source.point = ExactField<T>::snap(surface_, source.point);
      field.offset_ = std::min(field.offset_, source.distance);
    }
    for (auto& source : sources) source.distance -= field.offset_;
    detail::PropagationLimits limits;
    limits.distance = double{options.max_distance} - field.offset_;
    for (const auto& target : options.targets) {
      const auto p = ExactField<T>::snap(surface_, target.template cast<double>());
      if (p.kind == SurfacePoint<double>::Kind::face) {
        for (const Index v : surface_.face(p.element[0])) limits.target_vertices.push_back(v);
      } else if (p.kind == SurfacePoint<double>::Kind::edge) {
        limits.target_vertices.insert(limits.target_vertices.end(), p.element.begin(),
                                      p.element.end());
      } else {
        limits.target_vertices.push_back(p.element[0]);
      }
    }
    limits.cancelled = options.cancelled;
    limits.keep_windows = keep_windows;
    auto workspace = pool_->take();
    workspace->run(surface_, *faces_, sources, limits);
    if (workspace->was_cancelled) {
      pool_->put(std::move(workspace));
      throw Cancelled("the exact solve was cancelled");
    }
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (!(workspace->distances[v] > workspace->bound())) continue;
      workspace->distances[v] = unreachable<double>;
      workspace->arrivals[v] = {};
    }
    field.distances_ = workspace->distances;
    field.sources_ = std::move(sources);
    field.arrivals_ = workspace->arrivals;
    field.origins_ = workspace->origins;
    field.windows_ = std::move(workspace->kept);
    field.keeps_windows_ = limits.keep_windows;
    pool_->put(std::move(workspace));
    return field;
  }

  Surface<double> surface_;
  std::shared_ptr<const detail::PlanarFaces> faces_;
  ExactOptions<T> options_;
  std::shared_ptr<Pool> pool_;
};

template <TriangleMesh M>
explicit ExactSolver(const M&) -> ExactSolver<MeshScalar<M>>;
template <TriangleMesh M>
ExactSolver(const M&, ExactOptions<MeshScalar<M>>) -> ExactSolver<MeshScalar<M>>;

}  // namespace gelight
