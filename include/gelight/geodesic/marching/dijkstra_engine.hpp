#pragma once

#include <concepts>
#include <iterator>
#include <memory>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/marching/bucket_queue.hpp"
#include "gelight/geodesic/marching/edge_graph.hpp"
#include "gelight/geodesic/marching/steiner_graph.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// What DijkstraSolver works with: a graph of the edges, or one with Steiner points.
template <std::floating_point Real>
class DijkstraEngine {
 public:
  /// Throws InvalidInput as Surface does. `surface` is that of the mesh, where there is one.
  DijkstraEngine(MeshArrays<Real> mesh, const Surface<Real>* surface,
                 const DijkstraOptions& options)
      : cancelled_(options.cancelled),
        graph_(std::make_unique<Graph>(std::move(mesh), cancelled_.part(0, 0))) {
    if (surface != nullptr) (void)surface_.get([&] { return *surface; });
    require(options.steiner_points >= 0, "the number of Steiner points is ", options.steiner_points,
            ", less than 0");
  }
  /// With Steiner points. Throws InvalidInput for too many.
  DijkstraEngine(const Surface<Real>& surface, const DijkstraOptions& options)
      : cancelled_(options.cancelled),
        steiner_graph_(std::make_unique<SteinerGraph<Real>>(surface, options.steiner_points)) {
    (void)surface_.get([&] { return surface; });
  }

  [[nodiscard]] const Surface<Real>& surface() const {
    return surface_.get([&] { return Surface<Real>(*graph_); });
  }
  [[nodiscard]] auto of_mesh(const auto& ask) const {
    return graph_ != nullptr ? ask(*graph_) : ask(surface());
  }

  void solve_vertices(DistanceQuery<Real>& query) const {
    auto& [sources, starts, distance] = query;
    of_mesh([&](const auto& mesh) { query.starts.move_to_zero(mesh, query.sources); });
    if (graph_ != nullptr) {
      solve_along_edges(sources, distance);
    } else {
      steiner_graph_->distance_into(distance, sources, cancelled_);
    }
    if (starts.common == 0 && starts.of_vertex.empty()) return;
    for (Index v = 0; v < std::ssize(distance); ++v) distance[v] += starts.at(v);
  }

 private:
  using Graph = EdgeGraph<Real>;
  using Queue = BucketQueue<Real>;

  void solve_along_edges(const Array<Source<Real>>& sources, Slice<Real> distance) const {
    const typename Pool<Queue>::Borrowed borrowed(queues_);
    Queue& queue = *borrowed;
    queue.reset(graph_->short_length());
    const auto reach = [&](Index v, Real d) {
      distance[v] = d;
      queue.push(v, d);
    };
    for (const auto& source : sources) {
      const auto point = simplified(*graph_, source.point);
      graph_->for_each_vertex_near(point, [&](Index v, Real way) {
        if (source.distance + way < distance[v]) reach(v, source.distance + way);
      });
    }
    PeriodicCheck progress(cancelled_, graph_->vertex_count(), "a query of Dijkstra's method");
    while (!queue.empty()) {
      const auto [v, d] = graph_->pop_and_prefetch(queue, distance);
      if (d > distance[v]) continue;  // reached on a shorter way since it was queued
      progress.step();
      graph_->for_each_nearer(v, d, distance, reach);
    }
  }

  CancelHook cancelled_;
  std::unique_ptr<const Graph> graph_;  // where there are no Steiner points
  std::unique_ptr<const SteinerGraph<Real>> steiner_graph_;
  Lazy<Surface<Real>> surface_;
  mutable Pool<Queue> queues_;
};

}  // namespace gelight::detail
