#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <limits>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/lane.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_crossing.hpp"
#include "gelight/geodesic/exact/window_filters.hpp"
#include "gelight/geodesic/exact/window_list.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The end of a path at a point: its last straight piece, or all of it where a search found it.
template <std::floating_point Real>
struct PathEnd {
  Real distance = unreachable<Real>;
  SurfacePoint<Real> point;
  Arrival<Real> last;
  Vec2<Real> at{0, 0};               // the point in last.entry's frame
  Array<SurfacePoint<Real>> back{};  // from the point to the source, or to a bend at least
};

/// What a solution knows of the shortest way to a point, without searching: by the windows that
/// were kept, and from the corners of the point's faces and the sources there.
template <std::floating_point Real>
class PointQuery {
 public:
  using Point = SurfacePoint<Real>;
  using Arrival = detail::Arrival<Real>;
  using End = PathEnd<Real>;

  explicit PointQuery(const WindowSolution<Real>& solution) : solution_(solution) {}

  /// Whether windows of all faces that hold a point were kept, so that nothing is left to search.
  [[nodiscard]] bool has_windows(const Point& p) const {
    bool all = true;
    for_each_place(solution_.surface, p,
                   [&](Index f, const Weights&) { all &= solution_.keeps_windows(f); });
    return all;
  }

  /// The nearest end that is known; unreachable where it is beyond what was computed.
  [[nodiscard]] End nearest(const Point& p) const { return within_bound(known(p)); }

  /// The same, also where a search may bring a shorter one.
  [[nodiscard]] End known(const Point& p) const {
    if (p.kind == Point::Kind::vertex) return at_vertex(p.element[0]);
    End best{unreachable<Real>, p, {}};
    for_each_end(p, best.distance, [&](Real distance, const Arrival& last, const Vec2<Real>& at) {
      if (!(distance < best.distance)) return;
      // (Copies that are moved in: to assign is one of Eigen's expressions.)
      best.distance = distance;
      best.last = Arrival(last);
      best.at = Vec2<Real>(at);
    });
    from_fronts(p, best);
    return best;
  }

  [[nodiscard]] End within_bound(End end) const {
    const Point& p = end.point;
    if (p.kind == Point::Kind::vertex || end.distance <= solution_.bound_at(corner_of(p)))
      return end;
    return {unreachable<Real>, p, {}};
  }

  [[nodiscard]] End at_vertex(Index v) const {
    End end{solution_.distances[v], vertex_point<Real>(v), solution_.arrivals[v]};
    if (end.last.entry >= 0) end.at = solution_.faces->apex(end.last.entry);
    return end;
  }

  /// Straight ends within a limit: by windows through which the line to the point goes, from
  /// vertices of the point's faces where paths begin or bend, and from segments there. Lines
  /// through windows are as long as they are straight, also those that pass a window's end but for
  /// little; whether they lead to where they begin is for the caller to see.
  [[nodiscard]] Array<End> ends_at(const Point& p, Real limit) const {
    Array<End> ends;
    if (p.kind == Point::Kind::vertex && solution_.distances[p.element[0]] <= limit) {
      End end = at_vertex(p.element[0]);
      if (is_straight(end)) ends.push_back(std::move(end));
    }
    for_each_end(p, limit, [&](Real distance, const Arrival& last, const Vec2<Real>& at) {
      if (!(distance <= limit)) return;
      if (last.entry == Arrival::from_vertex && !solution_.begins_lines(last.origin)) return;
      if (p.kind == Point::Kind::vertex && last.entry == Arrival::from_vertex &&
          last.origin == p.element[0]) {
        return;
      }
      if (last.entry >= 0)
        distance = solution_.origins[last.origin].start + norm(Vec2<Real>(last.image - at));
      ends.push_back({distance, p, last, at});
    });
    for_each_front(p, [&](Real distance, const Point& foot) {
      if (distance <= limit) ends.push_back(from_foot(p, distance, foot));
    });
    return ends;
  }

  /// Whether the last piece of the way to a vertex is one line, but for rounding.
  [[nodiscard]] static bool is_straight(const End& end) {
    const Arrival& last = end.last;
    if (last.is_straight()) return true;
    const Vec2<Real> bend(last.bend, 0);
    const Real length = norm(Vec2<Real>(last.image - bend)) + norm(Vec2<Real>(bend - end.at));
    return length - norm(Vec2<Real>(last.image - end.at)) <= straight_rounding * length;
  }

  /// One of the vertices by which a point is given.
  [[nodiscard]] Index corner_of(const Point& p) const {
    return p.kind == Point::Kind::face ? solution_.surface.face(p.element[0])[0] : p.element[0];
  }

 private:
  using Weights = std::array<Real, 3>;
  // By how much longer than a line a way is that is one but for rounding.
  static constexpr Real straight_rounding = 1e-13;

  // Calls visit(distance, last piece, the point in its frame) for the ways through the windows that
  // were kept, from the corners of the point's faces and from sources there; but for some that are
  // longer than a limit, which `visit` may lower.
  template <class Visit>
  void for_each_end(const Point& p, const Real& limit, const Visit& visit) const {
    const auto gap = [&](const Point& from) { return straight(solution_.surface, from, p); };
    for_each_place(solution_.surface, p, [&](Index f, const Weights& weights) {
      if (solution_.keeps_windows(f)) through_windows(f, weights, limit, visit);
      for (const Index v : solution_.surface.face(f)) {
        if (solution_.distances[v] > limit) continue;
        visit(solution_.distances[v] + gap(vertex_point<Real>(v)),
              Arrival{{0, 0}, Arrival::from_vertex, v}, Vec2<Real>(0, 0));
      }
    });
    for (std::size_t s = 0; s < solution_.sources.size(); ++s) {
      const auto& source = solution_.sources[s];
      if (source.point.kind == Point::Kind::vertex) continue;  // a corner, visited above
      if (!share_face(solution_.surface, p, source.point)) continue;
      visit(source.distance + gap(source.point),
            Arrival{{0, 0}, Arrival::from_source, static_cast<Index>(s)}, Vec2<Real>(0, 0));
    }
  }

  // Windows on a side where the point itself lies are left out: such paths arrive in other faces.
  void through_windows(Index f, const Weights& weights, const Real& limit,
                       const auto& visit) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      if (weights[static_cast<std::size_t>((h + 2) % 3)] == 0) continue;
      const Vec2<Real> at = solution_.faces->place(solution_.surface, h, weights);
      const Real x = at.x(), y = at.y(), length = solution_.surface.length(h);
      solution_.windows->for_each(h, [&](const WindowColumns<Real>& w, std::ptrdiff_t count) {
        for (std::ptrdiff_t i = 0; i < count; i += lane_size) {
          unsigned left = crossed(w, i, length, x, y) & first_bits(count - i);
          for (; left != 0; left &= left - 1) {
            const std::ptrdiff_t k = i + std::countr_zero(left);
            const Real start = solution_.origins[w.origin[k]].start;
            if (start > limit) continue;
            visit(start + distance_through(w.begin[k], w.end[k], w.x[k], w.y[k], x, y),
                  Arrival{{w.x[k], w.y[k]}, h, w.origin[k]}, at);
          }
        }
      });
    }
  }

  // A bit for each window of a lane that the line to (x, y) crosses, or almost: a way that bends at
  // a window's end is longer than one beside it. Lines that would miss the side, of this length,
  // are left out, too: those bend at a corner, as the way from there does.
  static unsigned crossed(const WindowColumns<Real>& w, std::ptrdiff_t i, Real length, Real x,
                          Real y) {
    // Of the side, far more than is left between windows; of the way to an image, what rounding
    // makes of where the line crosses.
    constexpr Real beside = 1e-4, far = 64 * std::numeric_limits<Real>::epsilon();
    const Lane from_x = Lane::load(w.x + i), from_y = Lane::load(w.y + i);
    const Lane slack = beside * length + far * (abs(from_x) - from_y);  // y < 0
    const Lane crossing = from_x + (x - from_x) * (from_y / (from_y - y));
    const Lane begin = max(Lane::load(w.begin + i) - slack, -rounding * length);
    const Lane end = min(Lane::load(w.end + i) + slack, length * (1 + rounding));
    return ~(less(crossing, begin) | less(end, crossing));
  }

  void from_fronts(const Point& p, End& best) const {
    for_each_front(p, [&](Real distance, const Point& foot) {
      if (distance < best.distance) best = from_foot(p, distance, foot);
    });
  }

  // Calls visit(distance, from where) for the way straight from the nearest point of each segment
  // in a face of the point.
  void for_each_front(const Point& p, const auto& visit) const {
    for (const auto& front : solution_.fronts) {
      const Point begin = face_point(front.face, front.begin),
                  end = face_point(front.face, front.end);
      if (!share_face(solution_.surface, p, begin)) continue;
      const Vec3<Real> way = solution_.surface.difference(begin, end),
                       to = solution_.surface.difference(begin, p);
      const Real square = squared_norm(way);
      const Real t = square > 0 ? std::clamp(dot(way, to) / square, Real(0), Real(1)) : 0;
      const Point foot = simplified(solution_.surface, face_point(front.face, front.at(t)));
      visit(front.start + straight(solution_.surface, foot, p), foot);
    }
  }

  static End from_foot(const Point& p, Real distance, const Point& foot) {
    End end{distance, p, {}, {0, 0}, {p}};
    if (!(foot == p)) end.back.push_back(foot);
    return end;
  }

  const WindowSolution<Real>& solution_;
};

}  // namespace gelight::detail
