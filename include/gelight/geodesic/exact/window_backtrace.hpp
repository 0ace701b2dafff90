#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/window_crossing.hpp"
#include "gelight/geodesic/exact/window_list.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Follows a shortest path back to its source by asking, at every point of it, which of the kept
/// windows, corners and sources round the point is the nearest way. Each answer is exact by
/// itself, so that no error grows along the path, however thin the faces are; and each step leaves
/// behind all that lies within rounding of the point, so that the path cannot go in a circle where
/// vertices coincide and faces have no area. Slower than LineBacktrace, which needs no windows.
template <std::floating_point Real>
class WindowBacktrace {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;

  /// Of a solution that keeps all its windows.
  explicit WindowBacktrace(const WindowSolution<Real>& solution)
      : solution_(solution), visited_(static_cast<std::size_t>(solution.surface.face_count()), 0) {}

  /// The path from a point at a distance to its source; empty where none is found.
  [[nodiscard]] Array<Point> back(const Point& from, Real distance) {
    distance_ = distance;
    for (rounding_ = least_rounding; rounding_ < most_rounding; rounding_ *= 16) {
      Array<Point> path = attempt(from);
      if (!path.empty()) return path;
    }
    return {};
  }

 private:
  // What is nearer to a point than a share of the faces' size and the distance lies at it. The
  // windows of faces that are as thin as that lead astray: then the share is made larger.
  static constexpr Real least_rounding = 16 * std::numeric_limits<Real>::epsilon();
  static constexpr Real most_rounding = 1e-9;

  [[nodiscard]] Array<Point> attempt(const Point& from) {
    Array<Point> path{from};
    is_crossed_.assign(static_cast<std::size_t>(solution_.surface.face_count()), 0);
    for (Index left = solution_.surface.face_count(); left > 0; --left) {
      const Step step = nearest_from(path.back());
      if (!(step.distance < unreachable<Real>)) return {};
      append(path, step);
      if (step.is_last) return path;
      is_crossed_[Mesh::face_of(places_[step.place].halfedge)] = 1;
    }
    return {};
  }

  // The point, as seen in a face that it lies in but for rounding.
  struct Place {
    Index halfedge;
    Vec2<Real> at;            // in its frame
    std::ptrdiff_t previous;  // the place from which the face was reached, or -1
    Point point;              // over which it was
  };

  struct Step {
    Real distance = unreachable<Real>;  // of the way by `to`
    std::ptrdiff_t place = -1;          // from where
    Point to;
    bool is_last = false;  // at a source
  };

  Step nearest_from(const Point& p) {
    ++turn_;
    places_.clear();
    start_at(p);
    for (std::ptrdiff_t i = 0; i < std::ssize(places_); ++i) spread(i);
    Step best;
    for (std::ptrdiff_t i = 0; i < std::ssize(places_); ++i) {
      // A shortest path crosses a face once.
      if (is_crossed_[Mesh::face_of(places_[i].halfedge)]) continue;
      to_sources(i, best);
      to_corners(i, best);
      to_windows(i, best);
    }
    return best;
  }

  void append(Array<Point>& path, const Step& step) const {
    const std::size_t end = path.size();
    for (std::ptrdiff_t i = step.place; i >= 0; i = places_[i].previous) {
      path.push_back(places_[i].point);
    }
    std::reverse(path.begin() + end, path.end());
    path.push_back(step.to);
    path.keep_until(std::unique(path.begin(), path.end()));
  }

  // --- the faces round a point -------------------------------------------------------------------

  void start_at(const Point& p) {
    const auto& [a, b] = p.element;
    if (p.kind == Point::Kind::vertex) return add_corners(a, -1);
    if (p.kind == Point::Kind::edge)
      return add_edge(solution_.surface.find_halfedge(a, b), a, p, -1);
    const Index h = 3 * a;
    add(h, p.weights[1] * tip(h) + p.weights[2] * solution_.faces->apex(h), -1, p);
  }

  // The faces across all sides, and round all corners, at which a place lies.
  void spread(std::ptrdiff_t i) {
    const Index first = places_[i].halfedge;
    for (const Index h : sides(first)) {
      const Vec2<Real> at = in_frame(i, h);
      const Real length = solution_.surface.length(h), x = std::clamp(at.x(), 0.0, length);
      if (norm(at) <= near(h)) add_corners(solution_.surface.origin(h), i);
      if (length == 0 || !(norm(at - Vec2<Real>(x, 0)) <= near(h))) continue;
      const Index a = solution_.surface.origin(h);
      add_edge(h, a, edge_point<Real>(a, solution_.surface.tip(h), x / length), i);
    }
  }

  void add_corners(Index vertex, std::ptrdiff_t previous) {
    for (const Index out : solution_.surface.corners(vertex)) {
      add(out, {0, 0}, previous, vertex_point<Real>(vertex));
    }
  }

  // The faces at an edge, one of whose half-edges is h, at a point whose first share is `a`'s.
  void add_edge(Index h, Index a, const Point& p, std::ptrdiff_t previous) {
    const Index first = h;
    do {
      const Real share = p.weights[solution_.surface.origin(h) == a ? 1 : 0];
      add(h, share * tip(h), previous, p);
      h = solution_.surface.twin(h);
    } while (h != first);
  }

  void add(Index h, const Vec2<Real>& at, std::ptrdiff_t previous, const Point& p) {
    Index& visited = visited_[Mesh::face_of(h)];
    if (visited == turn_) return;
    visited = turn_;
    places_.push_back({h, at, previous, p});
  }

  static std::array<Index, 3> sides(Index h) { return {h, Mesh::next(h), Mesh::previous(h)}; }

  [[nodiscard]] Vec2<Real> tip(Index h) const { return {solution_.surface.length(h), 0}; }

  // A place in the frame of another side of its face.
  [[nodiscard]] Vec2<Real> in_frame(std::ptrdiff_t i, Index h) const {
    const Place& place = places_[i];
    if (h == place.halfedge) return place.at;
    const bool is_next = h == Mesh::next(place.halfedge);
    const Vec2<Real> apex = solution_.faces->apex(place.halfedge);
    const Vec2<Real> origin = is_next ? tip(place.halfedge) : apex;
    const Vec2<Real> from_tip = solution_.faces->apex_from_tip(solution_.surface, place.halfedge);
    const Vec2<Real> along =
        stable_unit(is_next ? Vec2<Real>(-from_tip.x(), from_tip.y()) : Vec2<Real>(-apex));
    Vec2<Real> from = place.at - origin;
    if (solution_.surface.length(h) == 0) return from;
    return {dot(along, from), along.x() * from.y() - along.y() * from.x()};
  }

  // How far rounding reaches at a side.
  [[nodiscard]] Real near(Index h) const {
    return rounding_ *
           (distance_ + solution_.surface.length(h) + solution_.surface.length(Mesh::next(h)));
  }

  // --- the ways on -------------------------------------------------------------------------------

  void consider(Real distance, std::ptrdiff_t place, const Point& to, bool is_last,
                Step& best) const {
    if (distance < best.distance) best = {distance, place, to, is_last};
  }

  // Sources at corners are met there.
  void to_sources(std::ptrdiff_t i, Step& best) const {
    const Index f = Mesh::face_of(places_[i].halfedge);
    for (const auto& source : solution_.sources) {
      if (source.point.kind == Point::Kind::vertex || !is_in(f, source.point)) continue;
      // In the place's own frame: that of a side of no length may be turned against it.
      const Vec2<Real> to = in_frame(source.point, places_[i].halfedge);
      consider(source.distance + norm(to - places_[i].at), i, source.point, true, best);
    }
  }

  [[nodiscard]] bool is_in(Index f, const Point& p) const {
    const auto& [a, b] = p.element;
    if (p.kind == Point::Kind::face) return a == f;
    const auto corners = solution_.surface.face(f);
    const auto has = [&, last = corners.end()](Index v) {
      return std::find(corners.begin(), last, v) != last;
    };
    return has(a) && has(b);
  }

  // A point of an edge of h's face, or inside of it.
  [[nodiscard]] Vec2<Real> in_frame(const Point& p, Index h) const {
    if (p.kind == Point::Kind::face) return solution_.faces->place(solution_.surface, h, p.weights);
    const auto vertices = solution_.surface.face(Mesh::face_of(h));
    std::array<Real, 3> shares{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      if (vertices[k] == p.element[0]) shares[k] = p.weights[0];
      if (vertices[k] == p.element[1]) shares[k] = p.weights[1];
    }
    return solution_.faces->place(solution_.surface, h, shares);
  }

  void to_corners(std::ptrdiff_t i, Step& best) const {
    for (const Index h : sides(places_[i].halfedge)) {
      const Index v = solution_.surface.origin(h);
      const Real gap = norm(in_frame(i, h));
      const bool is_source = solution_.is_source(v);
      if (gap <= near(h) && !is_source) continue;
      consider(solution_.distances[v] + gap, i, vertex_point<Real>(v), is_source, best);
    }
  }

  void to_windows(std::ptrdiff_t i, Step& best) const {
    for (const Index h : sides(places_[i].halfedge)) {
      const Vec2<Real> at = in_frame(i, h);
      const Real length = solution_.surface.length(h);
      solution_.windows->for_each(h, [&](const WindowColumns<Real>& w, std::ptrdiff_t count) {
        for (std::ptrdiff_t k = 0; k < count; ++k) {
          const Real straight = straight_crossing(w.x[k], w.y[k], at.x(), at.y());
          const Real x = std::clamp(straight, w.begin[k], w.end[k]);
          if (norm(at - Vec2<Real>(x, 0)) <= near(h)) continue;
          const Real distance =
              solution_.origins[w.origin[k]].start +
              distance_through(w.begin[k], w.end[k], w.x[k], w.y[k], at.x(), at.y());
          if (!(distance < best.distance)) continue;
          const Real t = std::clamp(x / length, 0.0, 1.0);
          consider(distance, i,
                   edge_point<Real>(solution_.surface.origin(h), solution_.surface.tip(h), t),
                   false, best);
        }
      });
    }
  }

  const WindowSolution<Real>& solution_;
  Real distance_ = 0;  // of the path's beginning
  Real rounding_ = least_rounding;
  Index turn_ = 0;          // counts the points that were looked round
  Array<Index> visited_;    // of each face: the turn at which it was last found
  Array<char> is_crossed_;  // of each face: whether the path crosses it
  Array<Place> places_;     // the point of the path, in all faces that hold it
};

}  // namespace gelight::detail
