#pragma once

#include <concepts>
#include <memory>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

namespace detail {
template <std::floating_point Real>
class VirtualSourceEngine;
}  // namespace detail

struct VirtualSourceOptions {
  /// Asked in set-up and in every query, by the thread that called; not by two at once if the
  /// callable is not made for it.
  CancelHook cancelled = {};
};

/// Distance by virtual sources (after Trettner, Bommes, Kobbelt 2021, doi:10.1111/cgf.14371): each
/// vertex keeps one image of a source, its distance and its direction among the faces round the
/// vertex laid flat, and hands it on to the vertices it shows in the faces around.
///
/// Label-correcting: a vertex hands on its image again when it gets a better one, so obtuse and
/// thin triangles cost no accuracy; of two ways equally long it keeps the straighter. Where a
/// saddle or a corner of the border hides an image from one end of an edge, a way over the edge is
/// longer than from the image by the square of how near it passes to that end. Convex flat sheets
/// are exact but for rounding in nearly all places (no vertex of 60 random grids, of triangles thin
/// or slanted by up to 10,000, was off by 1e-10 mean edges). Where a triangle's height is next to
/// nothing beside its longest side, bends are lost in rounding, and single vertices behind it may
/// be off by several edges. What lies behind a single corner of the border is exact in nearly all
/// places, also on edges of three faces; round several corners and holes of slanted sheets, single
/// vertices may be as far off, to both sides. Never below the straight line through space.
/// Waves of different sources pass through each other for two mean edges, 64 at a vertex at most:
/// the answer to many sources is that of the nearest alone, within a twentieth of the mean edge on
/// 171 of 174 trials (2, 5 and 50 random points, with start distances and without, on grids,
/// icospheres, scan-like meshes and needles; 0.083 edges where it was most; single vertices of
/// triangulations at random, with triangles of every thinness, were off by several edges).
///
/// Error, mean and largest: icospheres of 642 to 655,362 vertices 0.17 % and 0.33 % to 0.0001 % and
/// 0.011 %, falling with order 2; against exact distances on 24 rough, creased, bordered and thin
/// meshes of about 2,600 vertices the mean is 0.071 % on the median mesh, 0.24 % on the worst (fast
/// marching: 0.24 % and 0.61 %, and more on each of them), 4.6 % at a vertex
/// (benchmarks/claims.cpp). A query from one source takes about linear time, two and a half times
/// that of fast marching; several cost more where triangles are thin, and far more side by side, as
/// on a curve: there ExactSolver is quicker, from points as from the curve's Segments.
template <std::floating_point T>
class VirtualSourceSolver : public detail::DistanceQueries<VirtualSourceSolver<T>, T> {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does.
  template <TriangleMesh M>
  explicit VirtualSourceSolver(const M& mesh, const VirtualSourceOptions& options = {})
      : engine_(new_engine(Surface<Real>(mesh, options.cancelled.part(0, 0)), options)) {}

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<Real>& surface() const;

 private:
  friend class detail::DistanceQueries<VirtualSourceSolver<T>, T>;
  using Engine = detail::VirtualSourceEngine<Real>;

  [[nodiscard]] static std::shared_ptr<const Engine> new_engine(
      Surface<Real> surface, const VirtualSourceOptions& options);
  void solve_vertices(detail::DistanceQuery<double>& query) const;

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit VirtualSourceSolver(const M&) -> VirtualSourceSolver<MeshScalar<M>>;
template <TriangleMesh M>
VirtualSourceSolver(const M&, const VirtualSourceOptions&) -> VirtualSourceSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<VirtualSourceSolver<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<VirtualSourceSolver<double>, double>;
}  // namespace gelight
#endif
#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/virtual_source/body.hpp"
#endif
