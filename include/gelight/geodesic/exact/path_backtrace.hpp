#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/line_backtrace.hpp"
#include "gelight/geodesic/exact/past_vertex.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/window_backtrace.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// From the end of a path back to its source, as a polyline: by the straight lines that vertices
/// remember, and where those lose their way, by windows.
template <std::floating_point Real>
class PathBacktrace {
 public:
  using Point = SurfacePoint<Real>;
  using End = PathEnd<Real>;

  explicit PathBacktrace(const WindowSolution<Real>& solution) : solution_(solution) {}

  /// The points from an end to its source; none where no path leads. Where faces are so thin that
  /// the straight line of a vertex's last piece loses its way to rounding, the path is not as long
  /// as the distance, and `again()` is to find another.
  [[nodiscard]] Array<Point> back(const End& end, const auto& again) const {
    if (!end.back.empty()) return end.back;
    if (!(end.distance < unreachable<Real>)) return {};
    const Real most = most_path_error * end.distance + front_error * solution_.size;
    Array<Point> path = by_lines(end);
    Real error = path_error(path, end.distance);
    const auto take_better = [&](Array<Point> other) {
      const Real other_error = path_error(other, end.distance);
      if (!(other_error < error)) return;
      path = std::move(other);
      error = other_error;
    };
    if (error > most && !solution_.fronts.empty()) take_better(by_corner(end));
    if (error > most) take_better(again());
    return path;
  }

  /// The same where all windows were kept.
  [[nodiscard]] Array<Point> back(const End& end) const {
    return back(end, [&] { return by_windows(end); });
  }
  /// By either way alone; and along the line by which the end is reached, also where a vertex
  /// beside it is nearer by another.
  ///@{
  [[nodiscard]] Array<Point> by_lines(const End& end) const {
    PointTrail<Real> trail(solution_.surface, end.point);
    LineBacktrace<Real>(solution_).back(end.at, end.last, trail);
    return std::move(trail).points();
  }
  [[nodiscard]] Array<Point> along_line(const End& end) const {
    if (!end.back.empty()) return end.back;
    PointTrail<Real> trail(solution_.surface, end.point);
    LineBacktrace<Real>(solution_).along_line(end.at, end.last, trail);
    return std::move(trail).points();
  }
  [[nodiscard]] Array<Point> by_windows(const End& end) const {
    return WindowBacktrace<Real>(solution_).back(end.point, end.distance);
  }
  ///@}

  /// Whether an end is reached along a line as long as it is far; and so is each vertex where that
  /// begins, and those before it, none of which has a short cut beside it.
  [[nodiscard]] bool is_line(const End& end) const {
    const Array<Point> path = along_line(end);
    const PointQuery<Real> query(solution_);
    for (std::size_t i = 1; i < path.size(); ++i) {
      if (path[i].kind != Point::Kind::vertex) continue;
      if (!query.is_straight(query.at_vertex(path[i].element[0]))) return false;
      if (i + 1 < path.size() && has_short_cut(path[i - 1], path[i], path[i + 1])) return false;
    }
    return path_error(path, end.distance) <=
           most_line_error * end.distance + front_error * solution_.size;
  }

  /// Whether a way from one point over a vertex to another turns by less than a half circle there;
  /// not where one lies next to it.
  [[nodiscard]] bool has_short_cut(const Point& from, const Point& vertex, const Point& to) const {
    const auto& surface = solution_.surface;
    const Real near = next_to_vertex * longest_side_at(surface, vertex);
    if (straight(surface, from, vertex) <= near || straight(surface, vertex, to) <= near) {
      return false;
    }
    using Past = PastVertex<Real>;
    const Past past(surface, *solution_.faces, vertex.element[0]);
    const auto places = [&](const Point& p) {
      Array<typename Past::Place> out;
      for_each_place(surface, p, [&](Index f, const std::array<Real, 3>& shares) {
        if (holds(surface, f, vertex)) out.push_back(past.place(f, shares));
      });
      return out;
    };
    const auto begin = places(from), end = places(to);
    return std::any_of(end.begin(), end.end(), [&](const auto& place) {
      return past.angle(begin, place) < std::numbers::pi - half_circle_rounding;
    });
  }

  /// Writes down the way from a vertex back to its source; nothing where none leads. It is not told
  /// whether it lost its way: `is_shortest` does.
  void follow(Index vertex, auto& trail) const {
    trail.clear();
    const End end = PointQuery<Real>(solution_).at_vertex(vertex);
    if (!(end.distance < unreachable<Real>)) return;
    trail.to_vertex(vertex);
    LineBacktrace<Real>(solution_).back(end.at, end.last, trail);
  }
  /// Whether a way of some length from a source to a vertex is as long as the shortest one.
  [[nodiscard]] bool is_shortest(const Point& source, Real length, Index vertex) const {
    const Real distance = solution_.distances[vertex];
    return std::fabs(solution_.start_at(source) + length - distance) <= most_path_error * distance;
  }

 private:
  // Paths of plain meshes and needles are as long as their distances to 1e-14, relative.
  static constexpr Real most_path_error = 1e-13;
  // What lines are that pass others' windows within rounding.
  static constexpr Real most_line_error = 1e-12;
  // Half circles round vertices are known to this, in radians; lines less far apart count as one.
  static constexpr Real half_circle_rounding = 1e-6;
  // Those from segments are so but for this share of the mesh's size.
  static constexpr Real front_error = 8e-9;

  // By the other corner of the point's faces that is the shortest way: what loses its way round one
  // is next to it.
  [[nodiscard]] Array<Point> by_corner(const End& end) const {
    const auto& surface = solution_.surface;
    Array<Point> path{end.point};
    Real least = unreachable<Real>;
    Index corner = -1;
    for_each_face_at(surface, end.point, [&](Index f) {
      for (const Index v : surface.face(f)) {
        if (end.point == vertex_point<Real>(v)) continue;
        const Real way = solution_.distances[v] + straight_distance(surface, end.point, v);
        if (!(way < least)) continue;
        least = way;
        corner = v;
      }
    });
    if (corner < 0) return {};
    const Array<Point> rest = by_lines(PointQuery<Real>(solution_).at_vertex(corner));
    path.append(rest.begin(), rest.end());
    return path;
  }

  // By how much a path to a source is longer or shorter than a distance.
  [[nodiscard]] Real path_error(const Array<Point>& path, Real distance) const {
    if (path.empty()) return unreachable<Real>;
    Real sum = solution_.start_at(path.back());
    for (std::size_t i = 1; i < path.size(); ++i) {
      sum += straight(solution_.surface, path[i - 1], path[i]);
    }
    return std::fabs(sum - distance);
  }

  const WindowSolution<Real>& solution_;
};

}  // namespace gelight::detail
