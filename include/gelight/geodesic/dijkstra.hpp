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
class DijkstraEngine;
}  // namespace detail

struct DijkstraOptions {
  /// Points on each edge, evenly spaced, by which paths may cross it; straight lines join those of
  /// one face. With 0, 1, 2, 3, 5 and 8 of them distances are 6.9, 1.5, 1.2, 0.56, 0.23 and 0.15 %
  /// off great circles on average on an icosphere of 10,242 vertices, 23, 4.9, 2.8, 1.4, 0.64 and
  /// 0.36 % at most, at about 1, 20, 40, 70, 150 and 300 times the cost. On meshes like a scanner's
  /// (the median of 24) they are 6.7, 2, 1.4, 0.9, 0.53 and 0.35 % too long on average
  /// (benchmarks/claims.cpp).
  Index steiner_points = 0;
  /// Asked in every query, by the thread that called; not by two at once if the callable is not
  /// made for it.
  CancelHook cancelled = {};
};

/// Length of the shortest path along edges (Dijkstra 1959, doi:10.1007/BF01386390): an upper bound
/// of the geodesic distance that does not converge to it as the mesh is refined, but for more and
/// more Steiner points.
///
/// A source on an edge or in a face reaches the vertices of its faces by straight lines. Start
/// distances may be negative. On icospheres of any level the mean error is 7 to 9 %, the largest 21
/// to 24 %; on 24 meshes like a scanner's 6.7 % (median) to 16 %, up to 150 % at a vertex; on
/// needles more. Set-up and queries take about linear time.
/// Without Steiner points less than 105 bytes a vertex are taken from the mesh to the first answer
/// (distance_into_memory_test); the first source on an edge takes 28 more.
template <std::floating_point T>
class DijkstraSolver : public detail::DistanceQueries<DijkstraSolver<T>, T> {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does, and for a number of Steiner points that is negative or
  /// makes more nodes than an Index counts.
  template <TriangleMesh M>
  explicit DijkstraSolver(const M& mesh, const DijkstraOptions& options = {})
      : engine_(options.steiner_points > 0
                    ? new_engine(Surface<Real>(mesh, options.cancelled.part(0, 0)), options)
                    : new_engine(detail::read_mesh<Real>(mesh, options.cancelled.part(0, 0)),
                                 detail::as_surface<Real>(mesh), options)) {}

  /// The surface that the solver works on. Without Steiner points it is made when it is first asked
  /// for, 148 bytes a vertex, but where the solver was made of one: queries do without.
  [[nodiscard]] const Surface<Real>& surface() const;

 private:
  friend class detail::DistanceQueries<DijkstraSolver<T>, T>;
  using Engine = detail::DijkstraEngine<Real>;

  [[nodiscard]] static std::shared_ptr<const Engine> new_engine(detail::MeshArrays<Real> mesh,
                                                                const Surface<Real>* surface,
                                                                const DijkstraOptions& options);
  [[nodiscard]] static std::shared_ptr<const Engine> new_engine(const Surface<Real>& surface,
                                                                const DijkstraOptions& options);
  [[nodiscard]] auto of_mesh(const auto& ask) const { return engine_->of_mesh(ask); }
  void solve_vertices(detail::DistanceQuery<Real>& query) const;

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit DijkstraSolver(const M&) -> DijkstraSolver<MeshScalar<M>>;
template <TriangleMesh M>
DijkstraSolver(const M&, const DijkstraOptions&) -> DijkstraSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/dijkstra/body.hpp"
#endif
#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<DijkstraSolver<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<DijkstraSolver<double>, double>;
}  // namespace gelight
#endif
