#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/marching/bucket_queue.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// The vertices of a surface and some points on each of its edges, evenly spaced; straight lines
/// join those of one face (Lanthier, Maheshwari, Sack 2001, doi:10.1007/s00453-001-0027-5). Lines
/// are not stored: each is measured in its face when a path tries it.
template <std::floating_point Real>
class SteinerGraph {
 public:
  /// Nodes are the vertices, then `per_edge` points of each edge, from its first half-edge's
  /// origin on.
  SteinerGraph(const Surface<Real>& surface, Index per_edge)
      : surface_(surface), faces_(surface), per_edge_(per_edge) {
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      if (is_first(h)) halfedges_.push_back(h);
    }
    const std::ptrdiff_t nodes =
        surface.vertex_count() + std::ptrdiff_t{edge_count()} * std::ptrdiff_t{per_edge};
    require(nodes <= std::numeric_limits<Index>::max(), per_edge, " points on each of ",
            edge_count(), " edges are too many for 32 bits");
    node_count_ = static_cast<Index>(nodes);
    number_points();
    spacing_ = short_edge_length(surface) / (per_edge + 1);
  }

  /// Distance along the graph of every vertex from the sources. Start distances are not negative.
  [[nodiscard]] Array<Real> distance(const Array<Source<Real>>& sources) const {
    Array<Real> out(static_cast<std::size_t>(surface_.vertex_count()));
    distance_into(std::span<Real>(out), sources);
    return out;
  }
  void distance_into(Slice<Real> out, const Array<Source<Real>>& sources,
                     const CancelHook& cancelled = {}) const {
    const typename Pool<Front>::Borrowed borrowed(*pool_);
    Front& front = *borrowed;
    front.nodes.assign(static_cast<std::size_t>(node_count_), {});
    front.queue.reset(spacing_);
    for (const auto& source : sources) start(source, front);
    PeriodicCheck progress(cancelled, node_count_, "a query of the Steiner graph");
    while (!front.queue.empty()) {
      const auto [node, d] = front.queue.pop();
      if (d > front.nodes[node].distance) continue;  // reached on a shorter way since
      progress.step();
      if (node < surface_.vertex_count()) {
        leave_vertex(node, front);
      } else {
        leave_edge(node, front);
      }
    }
    for (Index v = 0; v < surface_.vertex_count(); ++v) out[v] = front.nodes[v].distance;
  }

 private:
  using Mesh = Surface<Real>;

  struct Node {
    Real distance = unreachable<Real>;
    Index face = -1;  // through which it was reached, or -1 where along an edge
  };

  struct Front {
    Array<Node> nodes;
    BucketQueue<Real> queue;

    void reach(Index node, Real d, Index face) {
      if (!(d < nodes[node].distance)) return;
      nodes[node] = {d, face};
      queue.push(node, d);
    }
  };

  [[nodiscard]] Index edge_count() const { return static_cast<Index>(halfedges_.size()); }

  [[nodiscard]] bool is_first(Index h) const {
    bool first = true;
    for (Index t = surface_.twin(h); t != h; t = surface_.twin(t)) first = first && h < t;
    return first;
  }

  void number_points() {
    points_.resize(static_cast<std::size_t>(surface_.halfedge_count()));
    Index begin = surface_.vertex_count();
    for (const Index first : halfedges_) {
      Index h = first;
      do {
        const bool forward = surface_.origin(h) == surface_.origin(first);
        points_[h] = forward ? begin : ~(begin + per_edge_ - 1);
        h = surface_.twin(h);
      } while (h != first);
      begin += per_edge_;
    }
  }

  // The node at place i of half-edge h, counted from h's origin; places -1 and per_edge are its
  // ends.
  [[nodiscard]] Index node_on(Index h, Index i) const {
    if (i < 0) return surface_.origin(h);
    if (i == per_edge_) return surface_.tip(h);
    const Index begin = points_[h];
    return begin >= 0 ? begin + i : ~begin - i;
  }

  [[nodiscard]] Real share(Index i) const { return (i + 1.0) / (per_edge_ + 1.0); }

  void start(const Source<Real>& source, Front& front) const {
    const auto point = simplified(surface_, source.point);
    if (point.kind == SurfacePoint<Real>::Kind::vertex) {
      return front.reach(point.element[0], source.distance, -1);
    }
    const Vec3<Real> at = surface_.position(point);
    for_each_face_at(surface_, point, [&](Index f) {
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Vec3<Real> origin = surface_.position(surface_.origin(h)) - at;
        const Vec3<Real> tip = surface_.position(surface_.tip(h)) - at;
        front.reach(surface_.origin(h), source.distance + stable_norm(origin), f);
        for (Index i = 0; i < per_edge_; ++i) {
          const Real gap = stable_norm(origin + share(i) * (tip - origin));
          front.reach(node_on(h, i), source.distance + gap, f);
        }
      }
    });
  }

  // A way that came through a face does not turn back into it: a straight line there is shorter.
  void leave_vertex(Index v, Front& front) const {
    const Node from = front.nodes[v];
    for (const Index h : surface_.corners(v)) {
      const Index in = Mesh::previous(h);
      front.reach(node_on(h, 0), from.distance + surface_.length(h) * share(0), -1);
      front.reach(node_on(in, per_edge_ - 1), from.distance + surface_.length(in) * share(0), -1);
      if (Mesh::face_of(h) == from.face) continue;
      const Vec2<Real> tip(surface_.length(h), 0);
      reach_side(Mesh::next(h), from.distance, tip, faces_.apex(h) - tip, front);
    }
  }

  void leave_edge(Index node, Front& front) const {
    const Node from = front.nodes[node];
    const Index number = node - surface_.vertex_count();
    const Index first = halfedges_[number / per_edge_];
    const Index place = number % per_edge_;
    const Real gap = surface_.length(first) * share(0);
    front.reach(node_on(first, place - 1), from.distance + gap, -1);
    front.reach(node_on(first, place + 1), from.distance + gap, -1);
    Index h = first;
    do {
      const Real t = points_[h] >= 0 ? share(place) : 1 - share(place);
      if (Mesh::face_of(h) != from.face) cross(h, t, from.distance, front);
      h = surface_.twin(h);
    } while (h != first);
  }

  // From the point at (1 - t) origin + t tip of half-edge h to the other two sides of its face.
  void cross(Index h, Real t, Real d, Front& front) const {
    const Vec2<Real> tip((1 - t) * surface_.length(h), 0);
    const Vec2<Real> origin(-t * surface_.length(h), 0);
    const Vec2<Real> apex = faces_.apex(h) + origin;
    front.reach(surface_.apex(h), d + length(apex), Mesh::face_of(h));
    reach_side(Mesh::next(h), d, tip, apex - tip, front);
    reach_side(Mesh::previous(h), d, apex, origin - apex, front);
  }

  // The points of half-edge h, which runs from `begin` along `way`, from a node at (0, 0).
  void reach_side(Index h, Real d, const Vec2<Real>& begin, const Vec2<Real>& way,
                  Front& front) const {
    for (Index i = 0; i < per_edge_; ++i) {
      front.reach(node_on(h, i), d + length(begin + share(i) * way), Mesh::face_of(h));
    }
  }

  static Real length(const Vec2<Real>& v) { return std::sqrt(v.x() * v.x() + v.y() * v.y()); }

  Surface<Real> surface_;
  PlanarFaces<Real> faces_;
  Index per_edge_;
  Index node_count_ = 0;
  Real spacing_ = 0;
  Array<Index> halfedges_;  // of each edge: the first
  // Of each half-edge: the node of its first point, from where they are counted up, or ~node, from
  // where they are counted down.
  Array<Index> points_;
  std::shared_ptr<Pool<Front>> pool_ = std::make_shared<Pool<Front>>();
};

}  // namespace gelight::detail
