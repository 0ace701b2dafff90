#pragma once

#include <concepts>
#include <iterator>
#include <memory>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/marching/bucket_queue.hpp"
#include "gelight/geodesic/marching/edge_graph.hpp"
#include "gelight/geodesic/marching/steiner_graph.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

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
 public:
  /// Throws InvalidInput as Surface does, and for a number of Steiner points that is negative or
  /// makes more nodes than an Index counts.
  template <TriangleMesh M>
  explicit DijkstraSolver(const M& mesh, const DijkstraOptions& options = {})
      : cancelled_(options.cancelled) {
    if (options.steiner_points > 0) {
      steiner_graph_ = std::make_shared<const detail::SteinerGraph<Real>>(surface_of(mesh, options),
                                                                          options.steiner_points);
    } else {
      graph_ = std::make_shared<const Graph>(mesh, options.cancelled.part(0, 0));
      if constexpr (std::same_as<M, Surface<Real>>) (void)surface_of(mesh, options);
    }
    detail::require(options.steiner_points >= 0, "the number of Steiner points is ",
                    options.steiner_points, ", less than 0");
  }

  /// The surface that the solver works on. Without Steiner points it is made when it is first asked
  /// for, 148 bytes a vertex, but where the solver was made of one: queries do without.
  [[nodiscard]] const Surface<double>& surface() const {
    return surface_->get([&] { return Surface<Real>(*graph_); });
  }

 private:
  friend class detail::DistanceQueries<DijkstraSolver<T>, T>;
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Graph = detail::EdgeGraph<Real>;
  using Queue = detail::BucketQueue<Real>;

  template <TriangleMesh M>
  [[nodiscard]] const Surface<Real>& surface_of(const M& mesh,
                                                const DijkstraOptions& options) const {
    return surface_->get([&] { return Surface<Real>(mesh, options.cancelled.part(0, 0)); });
  }

  [[nodiscard]] auto of_mesh(const auto& ask) const {
    return graph_ ? ask(*graph_) : ask(surface());
  }

  void solve_vertices(detail::DistanceQuery<Real>& query) const;

  void solve_along_edges(const detail::Array<Source<Real>>& sources,
                         detail::Slice<Real> distance) const {
    const typename detail::Pool<Queue>::Borrowed borrowed(*queues_);
    Queue& queue = *borrowed;
    queue.reset(graph_->short_length());
    const auto reach = [&](Index v, Real d) {
      distance[v] = d;
      queue.push(v, d);
    };
    for (const auto& source : sources) {
      const auto point = detail::simplified(*graph_, source.point);
      graph_->for_each_vertex_near(point, [&](Index v, Real way) {
        if (source.distance + way < distance[v]) reach(v, source.distance + way);
      });
    }
    detail::PeriodicCheck progress(cancelled_, graph_->vertex_count(),
                                   "a query of Dijkstra's method");
    while (!queue.empty()) {
      const auto [v, d] = graph_->pop_and_prefetch(queue, distance);
      if (d > distance[v]) continue;  // reached on a shorter way since it was queued
      progress.step();
      graph_->for_each_nearer(v, d, distance, reach);
    }
  }

  CancelHook cancelled_;
  std::shared_ptr<const Graph> graph_;  // where there are no Steiner points
  std::shared_ptr<const detail::SteinerGraph<Real>> steiner_graph_;
  std::shared_ptr<const detail::Lazy<Surface<Real>>> surface_ =
      std::make_shared<detail::Lazy<Surface<Real>>>();
  std::shared_ptr<detail::Pool<Queue>> queues_ = std::make_shared<detail::Pool<Queue>>();
};

template <std::floating_point T>
void DijkstraSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query) const {
  auto& [sources, starts, distance] = query;
  of_mesh([&](const auto& mesh) { query.starts.move_to_zero(mesh, query.sources); });
  if (graph_) {
    solve_along_edges(sources, distance);
  } else {
    steiner_graph_->distance_into(distance, sources, cancelled_);
  }
  if (starts.common == 0 && starts.of_vertex.empty()) return;
  for (Index v = 0; v < std::ssize(distance); ++v) distance[v] += starts.at(v);
}

template <TriangleMesh M>
explicit DijkstraSolver(const M&) -> DijkstraSolver<MeshScalar<M>>;
template <TriangleMesh M>
DijkstraSolver(const M&, const DijkstraOptions&) -> DijkstraSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class DijkstraSolver<float>;
GELIGHT_ONCE template class detail::DistanceQueries<DijkstraSolver<float>, float>;
GELIGHT_ONCE template class DijkstraSolver<double>;
GELIGHT_ONCE template class detail::DistanceQueries<DijkstraSolver<double>, double>;
}  // namespace gelight
#endif
