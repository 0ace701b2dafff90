#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/marching/indexed_heap.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Upper bounds of the distance: a fast march that crosses only edges on which it has proved its
/// own interpolation to be one.
///
/// Between the values f(u), f(w) at its ends an edge of length l carries F(x)^2 = (1-s) f(u)^2 +
/// s f(w)^2 - s (1-s) l^2, the distance from a point of the plane. In a face these three functions
/// are the edges of one F^2 = |x - c|^2 + k. Where k <= 0, F falls by at least the length of any
/// straight line towards c; so where the edges by which those lines leave the face are proved,
/// d <= F on the others too. A vertex is raised a little where that makes k <= 0.
template <std::floating_point Real>
class UpperMarch {
 public:
  UpperMarch(const Surface<Real>& surface, const PlanarFaces<Real>& faces)
      : surface_(surface), faces_(faces) {}

  /// An upper bound of each vertex' distance, +infinity where no path leads. Rounding is on the
  /// safe side. Start distances are not negative. Throws Cancelled where the hook says so.
  [[nodiscard]] Array<Real> operator()(const Array<Source<Real>>& sources,
                                       const CancelHook& cancelled = {}) {
    const auto count = static_cast<std::size_t>(surface_.vertex_count());
    bound_.assign(count, unreachable<double>);
    settled_.assign(count, 0);
    proved_.assign(static_cast<std::size_t>(surface_.halfedge_count()), 0);
    heap_.reset(surface_.vertex_count());
    source_edges_.clear();
    for (const auto& source : sources) {
      add_source(simplified(surface_, source.point), source.distance);
    }
    for (Index settled = 0; !heap_.empty(); ++settled) {
      if (settled % settled_between_polls == 0) {
        cancelled.check(static_cast<double>(settled) / surface_.vertex_count(), "the upper bounds");
      }
      settle(heap_.pop());
    }
    return std::move(bound_);
  }

 private:
  using Mesh = Surface<Real>;
  static constexpr Index settled_between_polls = 1024;
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  // Room for the rounding of a few operations.
  static constexpr double above_zero = 16 * epsilon, above = 1 + above_zero;
  // A vertex is raised by at most this share of a face's height to prove its edges; measured.
  static constexpr double largest_raise = 0.05;

  void reach(Index v, double d) {
    if (settled_[v] || !(d < bound_[v])) return;
    bound_[v] = d;
    heap_.push(v, d);
  }

  // A source inside a face or on an edge: where both ends of an edge of the face have their values
  // from there, the edge has too.
  struct SourceEdge {
    Index halfedge;
    double at_origin, at_tip;
  };

  void add_source(const SurfacePoint<Real>& point, double start) {
    for_each_vertex_near(surface_, point,
                         [&](Index v, double d) { reach(v, (start + d) * above); });
    if (point.kind == SurfacePoint<Real>::Kind::vertex) return;
    for_each_face_at(surface_, point, [&](Index f) {
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const double at_origin = start + straight_distance(surface_, point, surface_.origin(h));
        const double at_tip = start + straight_distance(surface_, point, surface_.tip(h));
        source_edges_.push_back({h, at_origin * above, at_tip * above});
      }
    });
  }

  void settle(Index v) {
    settled_[v] = 1;
    prove_at_sources(v);
    for (const Index h : surface_.corners(v)) {
      prove_along(h, surface_.tip(h), v);
      prove_along(Mesh::previous(h), surface_.apex(h), v);
    }
    for (const Index h : surface_.corners(v)) pending_.push_back(Mesh::face_of(h));
    while (!pending_.empty()) {
      Index h = 3 * pending_.back();
      pending_.pop_back();
      const Index last = h + 2;
      while (h < last && surface_.origin(h) != v) ++h;
      prove_face(h, surface_.origin(h) == v);
    }
    for (const Index h : marching_) reach(surface_.apex(h), across(h));
    marching_.clear();
    for (const Index h : surface_.corners(v)) {
      reach(surface_.tip(h), (bound_[v] + surface_.length(h)) * above);
      reach(surface_.apex(h), (bound_[v] + surface_.length(Mesh::previous(h))) * above);
    }
  }

  void prove(Index edge) {
    for (Index h = edge; !proved_[h]; h = surface_.twin(h)) {
      proved_[h] = 1;
      const Index apex = surface_.apex(h);
      if (settled_[apex]) {
        pending_.push_back(Mesh::face_of(h));
      } else {
        marching_.push_back(h);
      }
    }
  }

  void prove_at_sources(Index v) {
    for (const auto& [h, at_origin, at_tip] : source_edges_) {
      const Index a = surface_.origin(h), b = surface_.tip(h);
      if ((a == v || b == v) && settled_[a] && settled_[b] && bound_[a] >= at_origin &&
          bound_[b] >= at_tip) {
        prove(h);
      }
    }
  }

  // An edge whose far end is as far as the way along it.
  void prove_along(Index edge, Index from, Index v) {
    if (settled_[from] && bound_[v] >= (bound_[from] + surface_.length(edge)) * above) prove(edge);
  }

  // Proves what can be of the face at corner h; its vertex may be raised where it was settled last.
  void prove_face(Index h, bool may_raise) {
    const Index base = Mesh::next(h), back = Mesh::previous(h);
    const Index v = surface_.origin(h), a = surface_.origin(base), b = surface_.tip(base);
    if (!settled_[v] || !settled_[a] || !settled_[b]) return;
    if (proved_[h] && proved_[base] && proved_[back]) return;
    const double length = surface_.length(base), fa = bound_[a], fb = bound_[b];
    const Vec2<Real> at = faces_.apex(base);
    if (!(at.y() > 0) || fa + fb < length) return;
    const double t = (length + (fa - fb) * (fa + fb) / length) / 2;
    const double depth = depth_above(t, fa, fb, length);
    const double needed =
        std::hypot(at.x() - t, at.y() + depth) * above + above_zero * (fa + length);
    const double raised = std::max(bound_[v], needed);
    if (raised > bound_[v] + (may_raise ? largest_raise * at.y() : 0)) return;
    if (fa + raised < surface_.length(h) || fb + raised < surface_.length(back)) return;
    // Where the circles' centre lies, and by which edges lines towards it leave the face:
    // by those beyond which it is, or may be for rounding.
    const double fall = (fa - raised) * (fa + raised) + squared_norm(at) - 2 * t * at.x();
    const Vec2<Real> centre(t, fall / (2 * at.y()));
    const double error = 2 * above_zero * (fa + raised + length) * (length + norm(at)) / at.y();
    const double beyond_h = at.x() * centre.y() - at.y() * centre.x();
    const double beyond_back = at.y() * (centre.x() - length) - (at.x() - length) * centre.y();
    const bool by_base = centre.y() <= error;
    const bool by_h = beyond_h >= -error * norm(at);
    const bool by_back = beyond_back >= -error * (norm(at) + length);
    if (!by_base && !by_h && !by_back) return;
    if ((by_base && !proved_[base]) || (by_h && !proved_[h]) || (by_back && !proved_[back])) return;
    bound_[v] = raised;
    for (const Index edge : {base, h, back}) prove(edge);
  }

  // How far behind the edge the point lies, at t along it, that has these distances from its ends;
  // too far rather than too near.
  static double depth_above(double t, double a, double b, double length) {
    const double squared = (a - t) * (a + t) + above_zero * (a * a + b * b + length * length);
    return std::sqrt(std::max(0.0, squared));
  }

  // Distance of the apex by a straight line through a half-edge; any point of it would do.
  [[nodiscard]] double across(Index h) const {
    const double length = surface_.length(h);
    if (!(length > 0)) return unreachable<double>;
    const double a = bound_[surface_.origin(h)], b = bound_[surface_.tip(h)];
    const double t = (length + (a - b) * (a + b) / length) / 2;
    const double depth = depth_above(t, a, b, length);
    const Vec2<Real> at = faces_.apex(h);
    const double share =
        std::clamp((t * at.y() + at.x() * depth) / ((at.y() + depth) * length), 0.0, 1.0);
    if (!(share >= 0)) return unreachable<double>;
    const double squared =
        (1 - share) * a * a + share * b * b - share * (1 - share) * length * length;
    const double to_edge = std::sqrt(std::max(0.0, squared + above_zero * (a * a + b * b)));
    return (to_edge + std::hypot(at.x() - share * length, at.y())) * above;
  }

  const Surface<Real>& surface_;
  const PlanarFaces<Real>& faces_;
  Array<Real> bound_;    // of each vertex
  Array<char> settled_;  // of each vertex
  Array<char> proved_;   // of each half-edge: F is an upper bound on its edge
  Array<SourceEdge> source_edges_;
  IndexedHeap<Real> heap_;
  Array<Index> pending_;   // faces of which more may be proved now
  Array<Index> marching_;  // half-edges just proved, with an apex yet to settle
};

}  // namespace gelight::detail
