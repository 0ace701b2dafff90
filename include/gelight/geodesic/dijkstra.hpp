#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <memory>
#include <utility>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/marching/bucket_queue.hpp"
#include "gelight/geodesic/marching/steiner_graph.hpp"
#include "gelight/mesh/neighbourhood.hpp"
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
template <std::floating_point T>
class DijkstraSolver : public detail::DistanceQueries<DijkstraSolver<T>, T> {
 public:
  /// Throws InvalidInput as Surface does, and for a number of Steiner points that is negative or
  /// makes more nodes than an Index counts.
  template <TriangleMesh M>
  explicit DijkstraSolver(const M& mesh, const DijkstraOptions& options = {})
      : surface_(mesh, options.cancelled.part(0, 0)), cancelled_(options.cancelled) {
    set_up(options);
  }

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

 private:
  friend class detail::DistanceQueries<DijkstraSolver<T>, T>;
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Queue = detail::BucketQueue<Real>;

  void set_up(const DijkstraOptions& options);

  void solve_vertices(detail::DistanceQuery<Real>& query) const;

  // Unaligned, in three quarters of the memory: queries wait for this more than for all else.
  class Edge {
   public:
    Edge(Index tip, Real length) : tip_(tip) { std::memcpy(length_, &length, sizeof length); }
    [[nodiscard]] Index tip() const { return tip_; }
    [[nodiscard]] Real length() const {
      Real length;
      std::memcpy(&length, length_, sizeof length);
      return length;
    }

   private:
    Index tip_;
    char length_[sizeof(Real)];
  };

  void solve_along_edges(detail::DistanceQuery<Real>& query) const {
    detail::Array<Real>& distance = query.distance;
    const typename detail::Pool<Queue>::Borrowed borrowed(*queues_);
    Queue& queue = *borrowed;
    queue.reset(step_);
    const auto relax = [&](Index v, Real d) {
      if (d >= distance[v]) return;
      distance[v] = d;
      queue.push(v, d);
    };
    for (const auto& source : query.sources) {
      const auto point = detail::simplified(surface_, source.point);
      detail::for_each_vertex_near(surface_, point,
                                   [&](Index v, Real d) { relax(v, source.distance + d); });
    }
    detail::PeriodicCheck progress(cancelled_, surface_.vertex_count(),
                                   "a query of Dijkstra's method");
    while (!queue.empty()) {
      const auto [v, d] = queue.pop();
      if (d > distance[v]) continue;  // reached on a shorter way since it was queued
      progress.step();
      for (Index e = begin_[v]; e < begin_[v + 1]; ++e) {
        relax(edges_[e].tip(), d + edges_[e].length());
      }
    }
  }

  // Each edge once at either end, whatever number of faces it has.
  void link() {
    const auto stands_for_edge = [&](Index h) { return surface_.twin(h) <= h; };
    std::size_t count = 0;
    for (Index h = 0; h < surface_.halfedge_count(); ++h) count += 2 * stands_for_edge(h);
    edges_.reserve(count);
    begin_.reserve(static_cast<std::size_t>(surface_.vertex_count()) + 1);
    begin_.push_back(0);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      for (const Index out : surface_.corners(v)) {
        const Index in = surface_.previous(out);
        if (stands_for_edge(out)) edges_.emplace_back(surface_.tip(out), surface_.length(out));
        if (stands_for_edge(in)) edges_.emplace_back(surface_.origin(in), surface_.length(in));
      }
      begin_.push_back(static_cast<Index>(edges_.size()));
    }
    step_ = detail::short_edge_length(surface_);
  }

  Surface<Real> surface_;
  CancelHook cancelled_;
  Real step_ = 0;
  detail::Array<Index> begin_;  // of each vertex, and one more: where its edges begin
  detail::Array<Edge> edges_;
  std::shared_ptr<detail::Pool<Queue>> queues_ = std::make_shared<detail::Pool<Queue>>();
  std::shared_ptr<const detail::SteinerGraph<Real>> graph_;  // where there are Steiner points
};

template <std::floating_point T>
void DijkstraSolver<T>::set_up(const DijkstraOptions& options) {
  detail::require(options.steiner_points >= 0, "the number of Steiner points is ",
                  options.steiner_points, ", less than 0");
  if (options.steiner_points > 0) {
    graph_ = std::make_shared<const detail::SteinerGraph<Real>>(surface_, options.steiner_points);
  } else {
    link();
  }
}

template <std::floating_point T>
void DijkstraSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query) const {
  query.starts.move_to_zero(surface_, query.sources);
  if (graph_) {
    query.distance = graph_->distance(query.sources, cancelled_, std::move(query.distance));
  } else {
    solve_along_edges(query);
  }
  for (Index v = 0; v < surface_.vertex_count(); ++v) query.distance[v] += query.starts.at(v);
}

template <TriangleMesh M>
explicit DijkstraSolver(const M&) -> DijkstraSolver<MeshScalar<M>>;
template <TriangleMesh M>
DijkstraSolver(const M&, const DijkstraOptions&) -> DijkstraSolver<MeshScalar<M>>;

}  // namespace gelight
