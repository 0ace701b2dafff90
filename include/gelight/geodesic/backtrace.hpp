#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/backtrace/funnel.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Paths back to the sources through approximate distances. Each step crosses a face to where these
/// say that the rest is shortest, the wave a circle about the place that has the distances of an
/// edge's ends. A way that is off by little is longer by the square of that only, so that such
/// paths' lengths are much nearer to the exact distances than what led them there.
template <std::floating_point Real>
class Backtrace {
 public:
  using Mesh = Surface<Real>;

  /// Keeps a reference to the surface, and paths where that is asked.
  Backtrace(const Mesh& surface, Array<Source<Real>> sources, std::span<const Real> distances,
            bool keeps_path = false)
      : surface_(surface),
        sources_(std::move(sources)),
        is_near_(distances.size(), 0),
        keeps_path_(keeps_path) {
    starts_ = move_to_zero(surface_, sources_);
    distances_.reserve(distances.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      distances_.push_back(std::max(0.0, distances[static_cast<std::size_t>(v)] - starts_.at(v)));
    }
    for (auto& source : sources_) {
      source.point = simplified(surface_, source.point);
      for_each_vertex_near(surface_, source.point, [&](Index v, double) { is_near_[v] = 1; });
    }
    // Those at vertices are met there.
    const auto is_vertex = [](const auto& source) {
      return source.point.kind == SurfacePoint<Real>::Kind::vertex;
    };
    sources_.keep_until(std::remove_if(sources_.begin(), sources_.end(), is_vertex));
  }

  /// A path's length and its source's start distance: as walked, and pulled taut between the
  /// vertices that it passes. Infinite where no way on was found.
  struct Length {
    double walked = unreachable<double>, taut = unreachable<double>;
  };
  [[nodiscard]] Length from(Index vertex) {
    const Way way = walk(vertex);
    return way.has_arrived ? way.length : Length{};
  }

  /// A path as far as a way on was found, and what the distances say is left where it ended.
  struct Way {
    Length length;
    double left = 0;
    bool has_arrived = false;
  };
  [[nodiscard]] Way walk(Index vertex) {
    path_.clear();
    if (keeps_path_) path_.push_back(vertex_point<Real>(vertex));
    Length sum{starts_.at(vertex), starts_.at(vertex)};
    at_vertex_ = vertex;
    rest_ = distances_[vertex];
    Index ways_up = most_ways_up;
    for (Index steps = surface_.face_count(); steps > 0 && !has_arrived(); --steps) {
      Step step = best_step();
      const double left = rest_;
      if (!step.leads_on() && ways_up-- > 0) {
        rest_ = unreachable<double>;
        step = best_step();
      }
      if (!step.leads_on()) return {sum, left, false};
      sum.walked += step.piece;
      sum.taut += follow(step);
    }
    if (!has_arrived()) return {sum, rest_, false};
    return {{sum.walked + rest_, sum.taut + rest_}, 0, true};
  }

  /// The taut path of the last walk, from the vertex to where it arrived: at a source, or at a
  /// vertex of a face that holds one.
  [[nodiscard]] const std::vector<SurfacePoint<Real>>& path() const { return path_; }

 private:
  // An edge on the way. In its frame its left end is at (0, 0), its right end at (length, 0), and
  // the way goes up.
  struct Portal {
    Index halfedge = -1, left = -1, right = -1;
  };
  static constexpr Index at_source = -2, at_portal = -1;

  struct Step {
    double piece = unreachable<double>, rest = 0;
    Index vertex = at_portal;
    Portal portal{};    // that it leads to
    Index source = -1;  // that it leads to
    double x = 0;       // where on it
    Vec2<Real> apex;    // what lies across the face, or the end of the way, in the last portal's
                        // frame; from a vertex: the vertex, in the next one's
    [[nodiscard]] double total() const { return piece + rest; }
    [[nodiscard]] bool leads_on() const { return piece < unreachable<double>; }
  };

  // So often a way may lead on though the rest grows: where fronts meet, distances can be too
  // small.
  static constexpr Index most_ways_up = 4;
  // Nearer to an end of an edge than this share of it, a path leads to that end.
  static constexpr double on_corner = 1e-9;

  [[nodiscard]] bool has_arrived() const {
    return at_vertex_ == at_source || (at_vertex_ >= 0 && is_near_[at_vertex_]);
  }

  // --- one step ----------------------------------------------------------------------------------

  [[nodiscard]] Step best_step() const {
    return at_vertex_ >= 0 ? best_from_vertex() : best_from_portal();
  }

  [[nodiscard]] Step best_from_vertex() const {
    Step best;
    for (const Index h : surface_.corners(at_vertex_)) {
      const Index base = Mesh::next(h), back = Mesh::previous(h);
      consider_vertex(surface_.tip(h), surface_.length(h), {0, 0}, best);
      consider_vertex(surface_.apex(h), surface_.length(back), {0, 0}, best);
      if (!(surface_.length(base) > 0)) continue;
      const Vec2<Real> apex =
          third_corner(surface_.length(base), surface_.length(back), surface_.length(h));
      const Vec2<Real> place(apex.x(), -apex.y());
      consider_portal({base, surface_.apex(h), surface_.tip(h)}, place, place, best);
    }
    return best;
  }

  [[nodiscard]] Step best_from_portal() const {
    const auto [h, left, right] = portal_;
    const double length = surface_.length(h);
    const Vec2<Real> place(x_, 0), tip(length, 0);
    Step best;
    consider_vertex(left, x_, {0, 0}, best);
    consider_vertex(right, length - x_, tip, best);
    for (Index g = surface_.twin(h); g != h; g = surface_.twin(g)) {
      const bool is_along = surface_.origin(g) == left;
      const Index to_right = is_along ? Mesh::next(g) : Mesh::previous(g);
      const Index to_left = is_along ? Mesh::previous(g) : Mesh::next(g);
      const double from_left = surface_.length(to_left), from_right = surface_.length(to_right);
      const Vec2<Real> apex = third_corner(length, from_left, from_right);
      const Index across = surface_.apex(g);
      consider_vertex(across, norm(apex - place), apex, best);
      consider_sources(g, place, best);
      consider_portal({to_left, left, across}, seen_from({0, 0}, apex, from_left, place), apex,
                      best);
      consider_portal({to_right, across, right}, seen_from(apex, tip, from_right, place), apex,
                      best);
    }
    return best;
  }

  // Of a triangle with the others at (0, 0) and (length, 0), by its distances from them.
  static Vec2<Real> third_corner(double length, double from_left, double from_right) {
    const double x = (length + (from_left - from_right) * (from_left + from_right) / length) / 2;
    return {x, std::sqrt(std::max(0.0, (from_left - x) * (from_left + x)))};
  }

  // A place in the frame from `left` to `right`, behind which it lies.
  static Vec2<Real> seen_from(const Vec2<Real>& left, const Vec2<Real>& right, double length,
                              const Vec2<Real>& place) {
    const Vec2<Real> along = (right - left) / length, way = place - left;
    return {dot(along, way), std::min(0.0, along.x() * way.y() - along.y() * way.x())};
  }

  // Only ways on which the rest does not grow, so that they end.
  void consider(const Step& step, Step& best) const {
    if (step.rest <= rest_ && step.total() < best.total()) best = step;
  }
  void consider_vertex(Index v, double piece, const Vec2<Real>& at, Step& best) const {
    consider({piece, distances_[v], v, {}, -1, 0, at}, best);
  }

  void consider_portal(const Portal& portal, const Vec2<Real>& place, const Vec2<Real>& apex,
                       Step& best) const {
    const double length = surface_.length(portal.halfedge);
    const double a = distances_[portal.left], b = distances_[portal.right];
    if (a + b < length) return;                            // no wave has both
    const Vec2<Real> middle = third_corner(length, a, b);  // of the wave, behind the portal
    if (!(middle.y() > on_corner * length)) return;        // it began on the portal
    const double height = middle.y() - place.y();
    const double crossing = middle.y() * place.x() - place.y() * middle.x();  // height times where
    const double corner = on_corner * length * height;
    if (!(crossing > corner && crossing < length * height - corner)) return;
    const double total = norm(place - middle);
    if (!(total < best.total())) return;
    const double rest = total * (middle.y() / height);
    consider({total - rest, rest, at_portal, portal, -1, crossing / height, apex}, best);
  }

  // Those inside the face of g, or on its edges.
  void consider_sources(Index g, const Vec2<Real>& place, Step& best) const {
    if (!is_near_[portal_.left] || !is_near_[portal_.right] || !is_near_[surface_.apex(g)]) return;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const auto& source = sources_[i];
      bool is_in_face = false;
      for_each_face_at(surface_, source.point,
                       [&](Index f) { is_in_face |= f == Mesh::face_of(g); });
      if (!is_in_face) continue;
      const Vec2<Real> at = third_corner(surface_.length(portal_.halfedge),
                                         straight_distance(surface_, source.point, portal_.left),
                                         straight_distance(surface_, source.point, portal_.right));
      consider({norm(at - place), source.distance, at_source, {}, static_cast<Index>(i), 0, at},
               best);
    }
  }

  // --- following it ------------------------------------------------------------------------------

  // Returns what the path's length grows by once it is pulled taut: nothing before its next vertex.
  [[nodiscard]] double follow(const Step& step) {
    const bool is_at_vertex = at_vertex_ >= 0;
    at_vertex_ = step.vertex;
    rest_ = step.rest;
    if (step.vertex != at_portal) {
      const double length = is_at_vertex ? step.piece : line_.length_to(laid_flat(step.apex));
      if (keeps_path_) keep(step, is_at_vertex);
      return length;
    }
    const double length = surface_.length(step.portal.halfedge);
    if (is_at_vertex) {
      line_.begin(step.apex);
      portals_.clear();
      left_place_ = {0, 0};
      right_place_ = {length, 0};
    } else {
      const Vec2<Real> apex = laid_flat(step.apex);
      (step.portal.left == portal_.left ? right_place_ : left_place_) = apex;
    }
    line_.pass(left_place_, right_place_);
    portals_.push_back(step.portal);
    portal_ = step.portal;
    x_ = step.x;
    return 0;
  }

  void keep(const Step& step, bool is_along_edge) {
    const Array<Real> shares = is_along_edge ? Array<Real>() : line_.crossings();
    for (std::ptrdiff_t i = 0; i < std::ssize(shares); ++i) {
      path_.push_back(edge_point<Real>(portals_[i].left, portals_[i].right, shares[i]));
    }
    path_.push_back(step.source < 0 ? vertex_point<Real>(step.vertex)
                                    : sources_[static_cast<std::size_t>(step.source)].point);
  }

  // From the last portal's frame to the plane in which the faces since the last vertex lie.
  [[nodiscard]] Vec2<Real> laid_flat(const Vec2<Real>& at) const {
    const Vec2<Real> along = (right_place_ - left_place_) / surface_.length(portal_.halfedge);
    return left_place_ + at.x() * along + at.y() * Vec2<Real>(-along.y(), along.x());
  }

  const Mesh& surface_;
  Array<Source<Real>> sources_;
  Starts<Real> starts_;
  Array<Real> distances_;  // of each vertex, less its start
  Array<char> is_near_;    // of each vertex: whether a straight line leads to a source

  Index at_vertex_ = at_portal;          // where the way is, or
  Portal portal_;                        // on which edge,
  double x_ = 0;                         // and where on it
  double rest_ = 0;                      // what the distances say is left
  Funnel<Real> line_;                    // since the last vertex
  Array<Portal> portals_;                // likewise
  Vec2<Real> left_place_, right_place_;  // the portal's ends, laid flat
  bool keeps_path_ = false;
  std::vector<SurfacePoint<Real>> path_;
};

}  // namespace gelight::detail
