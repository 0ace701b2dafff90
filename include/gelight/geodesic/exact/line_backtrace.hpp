#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The points of a path, as it is followed back. (What a path can be written down in has these four
/// functions.)
template <std::floating_point Real>
class PointTrail {
 public:
  using Point = SurfacePoint<Real>;

  PointTrail(const Surface<Real>& surface, const Point& from) : surface_(surface), points_{from} {}

  void to_vertex(Index vertex) { append(vertex_point<Real>(vertex)); }
  /// Over a share of half-edge h, into the face of `across`: another half-edge of that edge, or
  /// the same one where the path goes on along it.
  void over_edge(Index h, [[maybe_unused]] Index across, Real share) {
    append(edge_point<Real>(surface_.origin(h), surface_.tip(h), share));
  }
  void to_source(const Point& point) { append(point); }
  [[nodiscard]] bool has(Index vertex) const {
    return std::find(points_.begin(), points_.end(), vertex_point<Real>(vertex)) != points_.end();
  }

  [[nodiscard]] Array<Point> points() && { return std::move(points_); }

 private:
  void append(const Point& point) {
    if (!(points_.back() == point)) points_.push_back(point);
  }

  const Surface<Real>& surface_;
  Array<Point> points_;
};

/// Follows shortest paths back to their sources, from what the vertices remember.
template <std::floating_point Real>
class LineBacktrace {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;

  explicit LineBacktrace(const WindowSolution<Real>& solution) : solution_(solution) {}

  /// Writes down the path to the source from a point at `at` in the frame of half-edge `last.entry`
  /// (where there is one).
  void back(const Vec2<Real>& at, const Arrival& last, auto& trail) const {
    from_vertex(last_piece(at, last, unreachable<Real>, trail), trail);
  }

  /// The same along the line that an arrival tells, whatever vertices beside it are nearer by.
  void along_line(const Vec2<Real>& at, const Arrival& last, auto& trail) const {
    from_vertex(last_piece<Along::line>(at, last, unreachable<Real>, trail), trail);
  }

  /// The same from a vertex, or from none: -1.
  void from_vertex(Index vertex, auto& trail) const {
    // Every vertex on the way is nearer than the one before, or by rounding they would be endless.
    for (Index left = solution_.surface.vertex_count(); vertex >= 0 && left > 0; --left) {
      trail.to_vertex(vertex);
      const Arrival& last = solution_.arrivals[vertex];
      const Vec2<Real> at = last.entry < 0 ? Vec2<Real>(0, 0) : solution_.faces->apex(last.entry);
      const Index next = last_piece(at, last, solution_.distances[vertex], trail);
      if (next == vertex) break;
      vertex = next;
    }
  }

 private:
  static constexpr Index arrived = -1;
  // A vertex beside the path is on it when the way by it is longer by rounding of the whole only.
  static constexpr Real rounding = 16 * std::numeric_limits<Real>::epsilon();

  // Whether a line is left for a shorter way by a vertex beside it.
  enum class Along { shortest, line };

  // Goes back over one straight piece, from a place at a distance; returns the vertex where it
  // begins, or `arrived`.
  template <Along along = Along::shortest>
  Index last_piece(const Vec2<Real>& at, const Arrival& last, Real distance, auto& trail) const {
    if (last.entry == Arrival::from_vertex) return last.origin;
    if (last.entry == Arrival::from_source) return reach_source(last.origin, trail);
    // By rounding the way may lead by a vertex beyond the last distance that was computed.
    if (last.entry == Arrival::none) return arrived;
    return cross_faces<along>(at, last, distance, trail);
  }

  Index reach_source(Index source, auto& trail) const {
    trail.to_source(solution_.source_point(source));
    return arrived;
  }

  // To where the line from `at` to the image meets a segment in h's face.
  Index reach_front(Index number, Index h, const Vec2<Real>& at, const Vec2<Real>& image,
                    auto& trail) const {
    const SegmentFront<Real>& front = solution_.fronts[static_cast<std::size_t>(number)];
    const Vec2<Real> a = solution_.faces->place(solution_.surface, h, front.begin);
    const Vec2<Real> along = solution_.faces->place(solution_.surface, h, front.end) - a;
    const Vec2<Real> line = stable_unit(image - at), from = at - a;
    const Real t =
        (from.x() * line.y() - from.y() * line.x()) / (along.x() * line.y() - along.y() * line.x());
    trail.to_source(simplified(solution_.surface,
                               face_point(front.face, front.at(std::clamp(t, Real(0), Real(1))))));
    return arrived;
  }

  // Goes back straight through faces; returns the vertex at which the straight line ends. It is
  // nearer to the source, or at the place of the last one and new, or in needles and on edges of no
  // length the way could go in a circle.
  template <Along along>
  Index cross_faces(const Vec2<Real>& from, const Arrival& last, Real distance, auto& trail) const {
    Line line{last.entry, from, last.image, last.bend};
    if (line.bend < 0)
      line.bend = crossing(from, last.image, solution_.surface.length(line.halfedge));
    Index origin = last.origin, end = vertex_of(origin);
    const Real start = solution_.origins[origin].start;
    const Real tie = rounding * (start + norm(from - last.image));
    // A shortest path crosses a face once; by rounding it may go round the tip of a needle.
    for (Index left = solution_.surface.face_count(); left > 0; --left) {
      const Index h = line.halfedge;
      const Real length = solution_.surface.length(h), x = line.bend;
      if (length == 0) return nearer_end(h, 0, distance);
      const bool near_origin = 2 * x < length;
      const Index beside = near_origin ? solution_.surface.origin(h) : solution_.surface.tip(h);
      const Real gap = near_origin ? x : length - x, to_beside = solution_.distances[beside];
      const Real rest = start + norm(Vec2<Real>(x, 0) - line.image);
      const bool is_on_line = along == Along::shortest || to_beside + gap >= rest - tie;
      if (is_on_line && to_beside + gap <= rest + tie) {
        if (to_beside < distance || (to_beside == distance && !trail.has(beside))) return beside;
      }

      Index across = solution_.surface.twin(h);
      if (solution_.origins[origin].kind == Origin::Kind::crossing &&
          !solution_.surface.is_manifold(h)) {
        across = solution_.origins[origin].index;
        origin = solution_.origins[origin].previous;
        end = vertex_of(origin);
      }
      trail.over_edge(h, across, x / length);
      if (across == h) return nearer_end(h, x, distance);
      if (solution_.surface.origin(across) != solution_.surface.origin(h)) {
        line.at = {length - x, 0};
        line.image = {length - line.image.x(), -line.image.y()};
      } else {
        line.at = {x, 0};
        line.image = {line.image.x(), -line.image.y()};
      }
      if (end >= 0 ? has_corner(across, end) : is_in_face(origin, across)) {
        const Origin& o = solution_.origins[origin];
        if (o.kind == Origin::Kind::front) {
          return reach_front(o.index, across, line.at, line.image, trail);
        }
        return o.kind == Origin::Kind::vertex ? o.index : reach_source(o.index, trail);
      }
      line = step(across, line.at, line.image);
    }
    return arrived;
  }

  static Real crossing(const Vec2<Real>& at, const Vec2<Real>& image, Real length) {
    const Real height = at.y() - image.y();
    if (!(height > 0)) return std::clamp(at.x(), 0.0, length);
    return std::clamp(image.x() + (at.x() - image.x()) * (-image.y() / height), 0.0, length);
  }

  // A straight line to the image, from a place in the face of a half-edge by which it leaves it.
  struct Line {
    Index halfedge;
    Vec2<Real> at, image;  // in its frame
    Real bend;             // where the way from one to the other crosses it
  };

  // The line from `at` beyond half-edge h to the image beyond h's face, as it leaves the face.
  [[nodiscard]] Line step(Index h, const Vec2<Real>& at, const Vec2<Real>& image) const {
    const Vec2<Real>& apex = solution_.faces->apex(h);
    const Real across =
        (image.x() - at.x()) * (apex.y() - at.y()) - (image.y() - at.y()) * (apex.x() - at.x());
    const Line line = over(h, across > 0, at, image);
    return is_straight(line) ? line : shorter(h, line, at, image);
  }

  // Where the image lies on a side, or the line runs along one, its direction is rounding.
  [[nodiscard]] Line shorter(Index h, const Line& line, const Vec2<Real>& at,
                             const Vec2<Real>& image) const {
    const Line other = over(h, line.halfedge == Mesh::previous(h), at, image);
    const Real by_line = way(line), by_other = way(other);
    const bool misses = by_other + rounding * (by_other + solution_.surface.length(h)) < by_line;
    return misses ? other : line;
  }

  // By the side of h's face after h, or that before it. Either is as far from its own apex as the
  // side at which that lies is long, so that its direction takes no root; and the one is chosen
  // without a branch, which would be guessed wrong every other time.
  [[nodiscard, gnu::always_inline]] Line over(Index h, bool after, const Vec2<Real>& at,
                                              const Vec2<Real>& image) const {
    const Index next = Mesh::next(h), previous = Mesh::previous(h);
    const Index side = after ? next : previous;
    const Real length = solution_.surface.length(side);
    if (length == 0) return {side, at, image, 0};
    const Vec2<Real>& apex = solution_.faces->apex(after ? next : h);
    const Real reach = solution_.surface.length(after ? h : previous);
    const Vec2<Real> along(-apex.x() / reach, (after ? apex.y() : -apex.y()) / reach);
    const Vec2<Real> from(after ? reach : apex.x(), after ? 0 : apex.y());
    const auto turned = [&](const Vec2<Real>& p) -> Vec2<Real> {
      const Real x = p.x() - from.x(), y = p.y() - from.y();
      return {along.x() * x + along.y() * y, along.x() * y - along.y() * x};
    };
    const Vec2<Real> to = turned(at), beyond = turned(image);
    return {side, to, beyond, crossing(to, beyond, length)};
  }

  // Whether it crosses the half-edge between its ends: no way is shorter.
  [[nodiscard]] bool is_straight(const Line& line) const {
    return line.bend > 0 && line.bend < solution_.surface.length(line.halfedge) &&
           line.at.y() > 0 && line.image.y() < 0;
  }
  [[nodiscard]] Real way(const Line& line) const {
    if (solution_.surface.length(line.halfedge) == 0) return unreachable<Real>;
    const Vec2<Real> bend(line.bend, 0);
    return norm(line.at - bend) + norm(bend - line.image);
  }

  // The end of h by which a point x along it is reached, if it is not farther than `distance`.
  [[nodiscard]] Index nearer_end(Index h, Real x, Real distance) const {
    const Real by_origin = solution_.distances[solution_.surface.origin(h)] + x;
    const Real by_tip =
        solution_.distances[solution_.surface.tip(h)] + solution_.surface.length(h) - x;
    const Index end = by_origin < by_tip ? solution_.surface.origin(h) : solution_.surface.tip(h);
    const Index other = by_origin < by_tip ? solution_.surface.tip(h) : solution_.surface.origin(h);
    if (solution_.distances[end] < distance) return end;
    if (solution_.distances[other] < distance) return other;
    // Vertices at one place are equally far; the way to one of them may lead by another.
    return solution_.distances[end] <= distance ? end : arrived;
  }

  // The vertex at which lines from an origin begin, or -1.
  [[nodiscard]] Index vertex_of(Index origin) const {
    const Origin& o = solution_.origins[origin];
    if (o.kind == Origin::Kind::vertex) return o.index;
    if (o.kind != Origin::Kind::source) return -1;
    const Point& point = solution_.source_point(o.index);
    return point.kind == Point::Kind::vertex ? point.element[0] : -1;
  }

  [[nodiscard]] bool has_corner(Index h, Index vertex) const {
    const auto [a, b, c] = solution_.surface.face(Mesh::face_of(h));
    return a == vertex || b == vertex || c == vertex;
  }

  // Whether an origin that is no vertex lies in h's face.
  [[nodiscard]] bool is_in_face(Index origin, Index h) const {
    const Origin& o = solution_.origins[origin];
    if (o.kind == Origin::Kind::crossing) return false;
    if (o.kind == Origin::Kind::front) {
      return solution_.fronts[static_cast<std::size_t>(o.index)].face == Mesh::face_of(h);
    }
    const Point& point = solution_.source_point(o.index);
    const auto [a, b] = point.element;
    if (point.kind == Point::Kind::edge) return has_corner(h, a) && has_corner(h, b);
    return Mesh::face_of(h) == a;
  }

  const WindowSolution<Real>& solution_;
};

}  // namespace gelight::detail
