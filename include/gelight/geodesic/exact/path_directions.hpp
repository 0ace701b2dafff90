#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/past_vertex.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/window_filters.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// In which directions the paths of a solution arrive and leave. `trace(end)` is the polyline from
/// an end back to its source, asked for only where the end itself does not tell.
template <std::floating_point Real>
class PathDirections {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using End = PathEnd<Real>;

  explicit PathDirections(const WindowSolution<Real>& solution) : solution_(solution) {}

  /// The direction of travel at an end; zero where there is none. Next to a corner the way by it is
  /// as short as the straight line past it, but for rounding, and over no length there is no
  /// direction: there the path tells it.
  [[nodiscard]] Vec3<Real> direction_of(const End& end, const auto& trace) const {
    if (end.back.size() > 1) return -first_direction(end.back).direction;
    if (end.last.entry == Arrival::none) return Vec3<Real>(0, 0, 0);
    Vec3<Real> direction = last_direction(end);
    const bool is_past = end.last.entry == Arrival::from_vertex &&
                         !solution_.is_source(end.last.origin) &&
                         is_next_to(end.point, end.last.origin);
    if (!is_past && !direction.isZero(0)) return direction;
    const Array<Point> back = trace(end);
    return back.size() > 1 ? Vec3<Real>(-first_direction(back).direction) : direction;
  }

  /// Where the last straight line to an end begins.
  [[nodiscard]] Point beginning(const End& end, const auto& trace) const {
    if (!end.back.empty()) return first_bend(end.back);
    if (end.last.entry == Arrival::none) return end.point;
    const Arrival last = last_bend(end.last);
    if (last.entry == Arrival::from_vertex) return vertex_point<Real>(last.origin);
    if (last.entry == Arrival::from_source) return solution_.source_point(last.origin);
    Index origin = last.origin;
    while (solution_.origins[origin].kind == Origin::Kind::crossing) {
      origin = solution_.origins[origin].previous;
    }
    const Origin& o = solution_.origins[origin];
    if (o.kind == Origin::Kind::front) return first_bend(trace(end));
    return o.kind == Origin::Kind::vertex ? vertex_point<Real>(o.index)
                                          : solution_.source_point(o.index);
  }

  struct Departure {
    Vec3<Real> direction{0, 0, 0};
    Index halfedge = 0;  // of the face into which the path goes
    Real angle = 0;      // from that half-edge
  };
  /// How a path leaves, given from its source.
  [[nodiscard]] Departure departure(const Array<Point>& path) const {
    Departure out;
    const Way way = first_direction(path);
    out.direction = way.direction;
    for_each_place(solution_.surface, path[0], [&](Index f, const Weights& weights) {
      if (way.face >= 0 && f != way.face) return;
      const auto in_face = face_point<Real>(f, {1.0 / 3, 1.0 / 3, 1.0 / 3});
      if (way.face < 0 && !share_face(solution_.surface, path[1], in_face)) return;
      Index h = 3 * f;
      while (path[0].kind != Point::Kind::face && !starts_at(h, weights)) ++h;
      out.halfedge = h;
      out.angle = angle_from(solution_.surface, h, way.direction);
    });
    return out;
  }

 private:
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;
  using PastVertex = detail::PastVertex<Real>;
  using Way = detail::Way<Real>;
  using Weights = std::array<Real, 3>;

  // The direction of the last piece of the way to an end.
  [[nodiscard]] Vec3<Real> last_direction(const End& end) const {
    if (end.last.entry == Arrival::from_vertex) {
      return unit_way(solution_.surface, vertex_point<Real>(end.last.origin), end.point);
    }
    if (end.last.entry == Arrival::from_source) {
      return unit_way(solution_.surface, solution_.source_point(end.last.origin), end.point);
    }
    return unit_way(solution_.surface, *solution_.faces, end.last.entry,
                    line_start(end.last, end.at), end.at);
  }

  // Whether a point that is no vertex lies so near to a corner of its faces that its place is lost
  // in the frames of their sides.
  [[nodiscard]] bool is_next_to(const Point& p, Index vertex) const {
    if (p.kind == Point::Kind::vertex) return false;
    return straight(solution_.surface, vertex_point<Real>(vertex), p) <= nearby(p);
  }

  [[nodiscard]] Real nearby(const Point& p) const {
    return next_to_vertex * longest_side_at(solution_.surface, p);
  }

  // The corner that a point is next to, or -1.
  [[nodiscard]] Index vertex_next_to(const Point& p) const {
    if (p.kind == Point::Kind::vertex) return -1;
    const auto k = static_cast<std::size_t>(std::max_element(p.weights.begin(), p.weights.end()) -
                                            p.weights.begin());
    const Index v =
        p.kind == Point::Kind::face ? solution_.surface.face(p.element[0])[k] : p.element[k];
    return is_next_to(p, v) ? v : -1;
  }

  // A point of the faces at a vertex, as each of them sees it.
  [[nodiscard]] Array<typename PastVertex::Place> places_at(Index vertex, const Point& p) const {
    const PastVertex past(solution_.surface, *solution_.faces, vertex);
    Array<typename PastVertex::Place> places;
    for_each_place(solution_.surface, p, [&](Index f, const Weights& weights) {
      if (has_corner(f, vertex)) places.push_back(past.place(f, weights));
    });
    return places;
  }
  [[nodiscard]] bool has_corner(Index f, Index vertex) const {
    const auto corners = solution_.surface.face(f);
    return std::find(corners.begin(), corners.end(), vertex) != corners.end();
  }

  // The direction in which a path begins. Its first points may lie so near that they do not tell:
  // then it is that of the straight line to the first that does, past the vertex or over the edge
  // that lies between. The face is told where that is so.
  [[nodiscard]] Way first_direction(const Array<Point>& path) const {
    const Point& p = path[0];
    const Real near = nearby(p);
    std::size_t k = 1;
    while (k + 1 < path.size() && straight(solution_.surface, p, path[k]) <= near) ++k;
    if (k == 1) return {unit_way(solution_.surface, p, path[1])};
    const Index v = vertex_next_to(p);
    Way way;
    if (v >= 0) {
      way = way_past(v, path[k - 1], path[k], p);
    } else if (k == 2 && p.kind == Point::Kind::face && path[1].kind == Point::Kind::edge) {
      way = way_over(path[1], path[2], p);
    }
    if (!way.direction.isZero(0)) return way;
    const bool tells = straight(solution_.surface, p, path[1]) > next_to_vertex * near;
    return {unit_way(solution_.surface, p, path[tells ? 1 : k])};
  }

  // From a point past a vertex to the end of a piece of a path that begins at the vertex or next to
  // it; zero where the piece is not in a face of the vertex.
  [[nodiscard]] Way way_past(Index vertex, const Point& begin, const Point& end,
                             const Point& p) const {
    const PastVertex past(solution_.surface, *solution_.faces, vertex);
    Way way;
    for_each_place(solution_.surface, end, [&](Index f, const Weights& weights) {
      const auto in_face = face_point<Real>(f, {1.0 / 3, 1.0 / 3, 1.0 / 3});
      if (way.face >= 0 || !has_corner(f, vertex) || !share_face(solution_.surface, begin, in_face))
        return;
      way = past.way(places_at(vertex, p), past.place(f, weights));
    });
    return way;
  }

  // From a point inside a face straight over a point of one of its edges to one in the face beyond.
  [[nodiscard]] Way way_over(const Point& edge, const Point& end, const Point& p) const {
    const Index f = p.element[0];
    Index h = 3 * f;
    for (Index side = 3 * f; side < 3 * f + 3; ++side) {
      const Index a = solution_.surface.origin(side), b = solution_.surface.tip(side);
      if (std::minmax(a, b) == std::minmax(edge.element[0], edge.element[1])) h = side;
    }
    Way way;
    if (is_thin(solution_.surface, *solution_.faces, h)) return way;
    for_each_place(solution_.surface, end, [&](Index g, const Weights& weights) {
      for (Index across = solution_.surface.twin(h); across != h;
           across = solution_.surface.twin(across)) {
        if (Mesh::face_of(across) != g || way.face >= 0) continue;
        Vec2<Real> to = solution_.faces->place(solution_.surface, across, weights);
        if (solution_.surface.origin(across) != solution_.surface.origin(h))
          to.x() = solution_.surface.length(h) - to.x();
        way = {unit_way(solution_.surface, *solution_.faces, h,
                        solution_.faces->place(solution_.surface, h, p.weights), {to.x(), -to.y()}),
               f};
      }
    });
    return way;
  }

  // Where the last straight line to a place begins, in the frame of the half-edge it crosses. A
  // bend that lengthens it by rounding only is rounding of a window's end.
  static Vec2<Real> line_start(const Arrival& last, const Vec2<Real>& at) {
    if (last.is_straight()) return last.image;
    const Vec2<Real> bend(last.bend, 0);
    const Real length = norm(last.image - bend) + norm(bend - at);
    const Real straight = norm(last.image - at);
    return length - straight > rounding * length ? bend : last.image;
  }

  // The arrival by a vertex where the path cannot bend goes on with the arrival there.
  [[nodiscard]] Arrival last_bend(Arrival last) const {
    while (last.entry == Arrival::from_vertex && !solution_.bends_anywhere &&
           !solution_.begins_lines(last.origin)) {
      last = solution_.arrivals[last.origin];
    }
    return last;
  }

  [[nodiscard]] Point first_bend(const Array<Point>& back) const {
    const auto bends = [&](const Point& p) {
      return p.kind == Point::Kind::vertex && solution_.begins_lines(p.element[0]);
    };
    const auto bend = std::find_if(back.begin() + 1, back.end(), bends);
    return bend == back.end() ? back.back() : *bend;
  }

  // Whether a half-edge starts at a source vertex or lies on a source's edge.
  static bool starts_at(Index h, const Weights& weights) {
    const auto k = static_cast<std::size_t>(h % 3);
    return weights[k] > 0 && weights[(k + 2) % 3] == 0;
  }

  const WindowSolution<Real>& solution_;
};

}  // namespace gelight::detail
