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
class FastMarchingEngine;
}  // namespace detail

struct FastMarchingOptions {
  /// Asked in set-up and in every query, by the thread that called; not by two at once if the
  /// callable is not made for it.
  CancelHook cancelled = {};
};

/// Distance by a front that marches over the vertices (Kimmel and Sethian 1998,
/// doi:10.1073/pnas.95.15.8431), its wave in each face a circle about the point that has the right
/// distances from the ends of the edge it came through, rather than a line.
///
/// A vertex that was passed too early, as happens in obtuse triangles, is reached again when a
/// shorter way to it shows, so no triangle needs splitting. Where two fronts of one source meet, a
/// distance can be too small. Fronts of different sources pass through each other for two mean
/// edges, 64 at a vertex at most: the answer to many sources is that of the nearest alone, within a
/// twentieth of the mean edge on 172 of 174 trials (2, 5 and 50 random points, with start distances
/// and without, on grids, icospheres, scan-like meshes and needles; 0.36 edges where it was most;
/// single vertices of triangulations at random, with triangles of every thinness, were off by
/// several edges).
///
/// Error, mean and largest: icospheres of 642 to 655,362 vertices 0.62 % and 2.4 % to 0.015 % and
/// 0.12 %, falling with order 1.1; against exact distances on the GelTip membrane 0.029 % and
/// 0.59 %, on meshes like a scanner's 0.24 % (the median of 24; 0.61 % on the worst) and 6.9 %
/// (benchmarks/claims.cpp); on flat sheets 0.02 % and 0.09 %. Behind a corner of the border it
/// falls with order one half: 0.33 % and 2.1 % in a bent strip of 10 cells, 0.09 % and 0.7 % in one
/// of 80.
///
/// No bound holds where a way that has bent round a corner of the border, or at a saddle, goes on
/// through long triangles that it passes at one end: the wave at an edge's other end came another
/// way, and no circle has both distances. Flat fans of 5 to 64 spokes whose ends lie unevenly are
/// off by 15 % on average and 83 % at a vertex on the worst of 80 fields, stretched 10 times by
/// 23 % and threefold, 1,000 times by 23 % and fivefold (benchmarks/claims.cpp); even ones of
/// 10,000 spokes by 0.009 % and 0.07 % (tests/README.md). VirtualSourceSolver is off there too: by
/// 5.7 % and 32 %, 19 % and 79 %, 22 % and twofold; ExactSolver is right. Rounding of the distances
/// of a short edge's ends turns the wave through it, the more the farther it has come: on flat
/// sheets distances were below the straight line by up to 2e-13 of it, on those stretched 100 times
/// by 4e-11, 10,000 times by 2e-7. A query from one source takes about linear time, two to four
/// times that where triangles are thin; many side by side, as on a curve, take far more: there
/// ExactSolver is quicker, from points as from the curve's Segments. Less than 400 bytes a vertex
/// are taken from the mesh to the first answer (distance_into_memory_test), the first source on an
/// edge takes 28 more.
template <std::floating_point T>
class FastMarchingSolver : public detail::DistanceQueries<FastMarchingSolver<T>, T> {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does.
  template <TriangleMesh M>
  explicit FastMarchingSolver(const M& mesh, const FastMarchingOptions& options = {})
      : engine_(new_engine(detail::read_mesh<Real>(mesh, options.cancelled.part(0, 0)),
                           detail::as_surface<Real>(mesh), options)) {}

  /// The surface that the solver works on: made when it is first asked for, 148 bytes a vertex, but
  /// where the solver was made of one. Queries do without.
  [[nodiscard]] const Surface<Real>& surface() const;

 private:
  friend class detail::DistanceQueries<FastMarchingSolver<T>, T>;
  using Engine = detail::FastMarchingEngine<Real>;

  [[nodiscard]] static std::shared_ptr<const Engine> new_engine(detail::MeshArrays<Real> mesh,
                                                                const Surface<Real>* surface,
                                                                const FastMarchingOptions& options);
  [[nodiscard]] auto of_mesh(const auto& ask) const { return ask(engine_->faces()); }
  void solve_vertices(detail::DistanceQuery<double>& query) const;

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit FastMarchingSolver(const M&) -> FastMarchingSolver<MeshScalar<M>>;
template <TriangleMesh M>
FastMarchingSolver(const M&, const FastMarchingOptions&) -> FastMarchingSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/fast_marching/body.hpp"
#endif
#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<FastMarchingSolver<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<FastMarchingSolver<double>, double>;
}  // namespace gelight
#endif
