#pragma once

#include <concepts>
#include <memory>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {
template <std::floating_point Real>
class EdgeSearch;
}  // namespace detail

/// Paths between pairs of points, without distances of the whole mesh.
///
/// Constructed once from a mesh, in O(vertices + faces log valence); queries are const and safe
/// from several threads, and take time for the part of the mesh that they look at alone. Paths are
/// those of `ExactField::path`: the point at which they begin, each point where they cross an edge
/// or meet a vertex, with its shares, and their end; empty where no path leads. `faces_along` tells
/// the face of each piece, `length` the length.
///
/// Between vertices of an icosphere a tenth of its greatest distance apart a shortest path takes
/// 1/150 of the instructions of a whole exact solve at 2,562 vertices and 1/400 at 10,242; on a
/// mesh like a scanner's, of 2,600 vertices, 1/120. A straight path takes a little more than half
/// of that.
template <std::floating_point T>
class PathSolver {
 public:
  /// Throws InvalidInput as Surface does. The hook is asked now and then by every query, which
  /// throws Cancelled where it says so.
  explicit PathSolver(const TriangleMesh auto& mesh, CancelHook cancelled = {})
      : cancelled_(std::move(cancelled)), exact_(mesh, options_with(cancelled_)) {}

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return exact_.surface(); }

  /// The shortest path between two points, exact as ExactSolver is. The length of a straight path
  /// bounds the search: windows are propagated only where the way to them and straight on to the
  /// end through space is no longer. Of several shortest paths one is returned. Throws InvalidInput
  /// for a point that is not of the surface.
  ///@{
  [[nodiscard]] Path<T> shortest_path(Index from, Index to) const {
    return shortest_path(vertex_point<T>(from), vertex_point<T>(to));
  }
  [[nodiscard]] Path<T> shortest_path(const SurfacePoint<T>& from, const SurfacePoint<T>& to) const;
  ///@}

  /// A locally shortest path between two points: the shortest one along edges, straightened. The
  /// cheap door: no path near it is shorter, another way round a hill may be. On 24 meshes like a
  /// scanner's it is 0 to 1.3 % longer than the shortest on average, 19 % at most. Throws
  /// InvalidInput for a point that is not of the surface.
  ///@{
  [[nodiscard]] Path<T> straight_path(Index from, Index to) const {
    return straight_path(vertex_point<T>(from), vertex_point<T>(to));
  }
  [[nodiscard]] Path<T> straight_path(const SurfacePoint<T>& from, const SurfacePoint<T>& to) const;
  ///@}

  /// A path made locally shortest, between its own ends: straight over faces and edges, with at
  /// least pi on either side of each vertex where it bends, but for some 1e-8. It is never longer
  /// than before, and keeps to the side of holes and handles on which it was. Where edges have no
  /// length or faces no area it may stay bent. Throws InvalidInput for a path of no point, points
  /// that are not of the surface, and two in a row that no face holds.
  ///
  /// The idea is that of N. Sharp, K. Crane, "You can find geodesic paths in triangle meshes by
  /// just flipping edges", 2020, doi:10.1145/3414685.3417839; here the path is moved and not the
  /// mesh.
  [[nodiscard]] Path<T> straightened(const Path<T>& path) const;

 private:
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Point = SurfacePoint<Real>;
  using Search = detail::EdgeSearch<Real>;
  using Pool = detail::Pool<Search>;

  // A straight path is longer by rounding than the length that the search finds for it; and the
  // search is hardly wider for that.
  static constexpr Real slack = 1e-9;
  // A path that was straight before is longer by no more than this.
  static constexpr Real rounding = 1e-12;

  static ExactOptions<T> options_with(const CancelHook& cancelled) {
    ExactOptions<T> options;
    options.cancelled = cancelled;
    return options;
  }

  [[nodiscard]] static std::shared_ptr<Pool> new_pool();
  [[nodiscard]] Point checked(const SurfacePoint<T>& point) const;
  [[nodiscard]] static Path<T> cast(const std::vector<Point>& path);
  [[nodiscard]] std::vector<Point> straight(const Point& from, const Point& to) const;
  [[nodiscard]] std::vector<Point> taut(const std::vector<Point>& path) const;

  CancelHook cancelled_;
  ExactSolver<T> exact_;
  std::shared_ptr<Pool> searches_ = new_pool();
};

template <TriangleMesh M>
explicit PathSolver(const M&) -> PathSolver<MeshScalar<M>>;
template <TriangleMesh M>
PathSolver(const M&, CancelHook) -> PathSolver<MeshScalar<M>>;

/// The shortest path between two points or vertices of a mesh, by PathSolver, which is the better
/// choice for more than one pair: most of the time goes into setting it up. Throws InvalidInput as
/// it does.
///@{
template <TriangleMesh M>
[[nodiscard]] Path<MeshScalar<M>> shortest_path(const M& mesh,
                                                const SurfacePoint<MeshScalar<M>>& from,
                                                const SurfacePoint<MeshScalar<M>>& to,
                                                const CancelHook& cancelled = {}) {
  return PathSolver(mesh, cancelled).shortest_path(from, to);
}
template <TriangleMesh M>
[[nodiscard]] Path<MeshScalar<M>> shortest_path(const M& mesh, Index from, Index to,
                                                const CancelHook& cancelled = {}) {
  return PathSolver(mesh, cancelled).shortest_path(from, to);
}
///@}

/// A path made locally shortest, by PathSolver. Throws InvalidInput as it does.
template <TriangleMesh M>
[[nodiscard]] Path<MeshScalar<M>> straighten_path(const M& mesh, const Path<MeshScalar<M>>& path,
                                                  const CancelHook& cancelled = {}) {
  return PathSolver(mesh, cancelled).straightened(path);
}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/shortest_path/body.hpp"
#endif
