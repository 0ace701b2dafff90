#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/leaving_segment.hpp"
#include "gelight/geodesic/exact/path_backtrace.hpp"
#include "gelight/geodesic/exact/path_directions.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/search_back.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What an ExactField answers, from what its solve found.
template <std::floating_point T>
class ExactQueries {
  using Real = typename WorkingPrecision<T>::Real;
  using Point = SurfacePoint<Real>;
  using Solution = WindowSolution<Real>;
  using Query = PointQuery<Real>;
  using Search = SearchBack<Real>;
  using Backtrace = PathBacktrace<Real>;
  using Directions = PathDirections<Real>;
  using End = PathEnd<Real>;

 public:
  explicit ExactQueries(const Solution& solution) : solution_(solution) {}

  [[nodiscard]] std::vector<T> distances() const;
  [[nodiscard]] T distance(Index vertex) const {
    solution_.surface.require_vertex(vertex);
    return distance_of_vertex(vertex);
  }
  [[nodiscard]] T distance(const SurfacePoint<T>& point) const;
  [[nodiscard]] Path<T> path(const SurfacePoint<T>& point) const;
  [[nodiscard]] Vec3<T> direction(const SurfacePoint<T>& point) const;
  [[nodiscard]] std::vector<ExactArrival<T>> arrivals(const SurfacePoint<T>& point,
                                                      T relative_tolerance) const;
  [[nodiscard]] ExactDeparture<T> departure(const SurfacePoint<T>& point) const;

 private:
  static constexpr Real same_direction = 1e-6;

  [[nodiscard]] T distance_of_vertex(Index v) const {
    return distance_as<T>(solution_.distances[v] + solution_.starts.at(v), "vertex ", v);
  }
  [[nodiscard]] T distance_of(const End& end) const {
    const Index corner = Query(solution_).corner_of(end.point);
    return distance_as<T>(end.distance + solution_.starts.at(corner), "a point at vertex ", corner);
  }

  [[nodiscard]] Point checked(const SurfacePoint<T>& point) const {
    solution_.surface.require_point(point);
    return simplified(solution_.surface, point.template cast<Real>());
  }

  // The nearest end at a point: by what the solution knows, and what a search adds to it.
  [[nodiscard]] End nearest(const Point& p) const {
    const Query query(solution_);
    if (p.kind == Point::Kind::vertex) return query.at_vertex(p.element[0]);
    End best = query.known(p);
    if (!query.has_windows(p)) Search(solution_).shorten(best);
    return query.within_bound(std::move(best));
  }

  // All ends at a point within a limit.
  [[nodiscard]] std::vector<End> ends_at(const Point& p, Real limit) const {
    const Query query(solution_);
    return query.has_windows(p) ? query.ends_at(p, limit) : Search(solution_).ends_at(p, limit);
  }

  // The way from an end back to its source.
  [[nodiscard]] Array<Point> trace(const End& end) const {
    const Backtrace backtrace(solution_);
    return backtrace.back(end, [&] {
      return solution_.keeps_all_windows() ? backtrace.by_windows(end)
                                           : Search(solution_).back(end);
    });
  }
  [[nodiscard]] Vec3<Real> direction_of(const End& end) const {
    return Directions(solution_).direction_of(end, [&](const End& e) { return trace(e); });
  }

  [[nodiscard]] std::vector<ExactArrival<T>> distinct(const End& shortest,
                                                      const std::vector<End>& others) const;

  const Solution& solution_;
};

template <std::floating_point T>
auto ExactQueries<T>::distances() const -> std::vector<T> {
  std::vector<T> out;
  const Index count = solution_.surface.vertex_count();
  out.reserve(static_cast<std::size_t>(count));
  for (Index v = 0; v < count; ++v) out.push_back(distance_of_vertex(v));
  return out;
}

template <std::floating_point T>
auto ExactQueries<T>::distance(const SurfacePoint<T>& point) const -> T {
  return distance_of(nearest(checked(point)));
}

template <std::floating_point T>
auto ExactQueries<T>::path(const SurfacePoint<T>& point) const -> Path<T> {
  const Array<Point> back = trace(nearest(checked(point)));
  Path<T> out;
  out.reserve(back.size());
  for (std::size_t i = back.size(); i-- > 0;) out.push_back(back[i].template cast<T>());
  return out;
}

template <std::floating_point T>
auto ExactQueries<T>::direction(const SurfacePoint<T>& point) const -> Vec3<T> {
  return cast<T>(direction_of(nearest(checked(point))));
}

template <std::floating_point T>
auto ExactQueries<T>::arrivals(const SurfacePoint<T>& point, T relative_tolerance) const
    -> std::vector<ExactArrival<T>> {
  require(relative_tolerance >= 0, "a relative tolerance of ", relative_tolerance);
  const Point p = checked(point);
  const End shortest = nearest(p);
  if (!(shortest.distance < unreachable<Real>)) return {};
  const Real limit = shortest.distance * (1 + static_cast<Real>(relative_tolerance));
  std::vector<End> ends = ends_at(p, limit);
  if (!solution_.fronts.empty()) {
    const LeavingSegment<Real> leaving(solution_);
    std::erase_if(ends, [&](const End& end) {
      Array<Point> path = Backtrace(solution_).along_line(end);
      std::reverse(path.begin(), path.end());
      return leaving.is_oblique(path);
    });
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const End& a, const End& b) { return a.distance < b.distance; });
  return distinct(shortest, ends);
}

template <std::floating_point T>
auto ExactQueries<T>::departure(const SurfacePoint<T>& point) const -> ExactDeparture<T> {
  using Kind = typename SurfacePoint<T>::Kind;
  Array<Point> path = trace(nearest(checked(point)));
  require(path.size() > 1, "no direction leads from a source to the point ",
          point.kind == Kind::face   ? "on face "
          : point.kind == Kind::edge ? "on an edge at vertex "
                                     : "at vertex ",
          point.element[0]);
  std::reverse(path.begin(), path.end());
  const auto way = Directions(solution_).departure(path);
  return {cast<T>(way.direction), way.halfedge, static_cast<T>(way.angle)};
}

// A shortest path, and of others that are lines those of another direction than those before.
// (Searched ones are lines.)
template <std::floating_point T>
auto ExactQueries<T>::distinct(const End& shortest, const std::vector<End>& others) const
    -> std::vector<ExactArrival<T>> {
  using namespace arithmetic;
  const Directions directions(solution_);
  const Backtrace backtrace(solution_);
  std::vector<ExactArrival<T>> out;
  std::vector<Vec3<Real>> known;
  const auto add = [&](const End& end, const Vec3<Real>& direction) {
    known.push_back(direction);
    const Point from =
        directions.beginning(end, [&](const End& e) { return backtrace.along_line(e); });
    out.push_back({distance_of(end), cast<T>(direction), from.template cast<T>()});
  };
  add(shortest, direction_of(shortest));
  for (const End& end : others) {
    const Vec3<Real> direction = direction_of(end);
    const bool is_known = std::any_of(known.begin(), known.end(), [&](const Vec3<Real>& d) {
      return stable_norm(d - direction) < same_direction;
    });
    if (is_known || (end.back.empty() && !backtrace.is_line(end))) continue;
    add(end, direction);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.distance < b.distance; });
  return out;
}

}  // namespace gelight::detail
