#pragma once

#include <algorithm>
#include <concepts>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/path_backtrace.hpp"
#include "gelight/geodesic/exact/path_directions.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/window_filters.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Finds what comes to a point by windows that were not kept: solves anew from the point to the
/// sources, keeping all windows, through those alone that the distances of the vertices leave room
/// for.
template <std::floating_point Real>
class SearchBack {
 public:
  using Point = SurfacePoint<Real>;
  using End = PathEnd<Real>;

  explicit SearchBack(const WindowSolution<Real>& solution) : solution_(solution) {}

  /// Replaces the best end that is known of by a shorter one.
  void shorten(End& best) const {
    const Point p = best.point;
    const WindowSolution<Real> found = from(p, best.distance);
    for (const auto& source : solution_.sources) {
      const End end = PointQuery<Real>(found).nearest(source.point);
      if (!(end.distance + source.distance < best.distance)) continue;
      best = turned(end, source, p, PathBacktrace<Real>(found).back(end));
    }
  }

  /// All ends at a point within a limit.
  [[nodiscard]] Array<End> ends_at(const Point& p, Real limit) const {
    const WindowSolution<Real> found = from(p, limit);
    Array<End> ends;
    for (const auto& source : solution_.sources) {
      for (const End& end :
           PointQuery<Real>(found).ends_at(source.point, limit - source.distance)) {
        if (!PathBacktrace<Real>(found).is_line(end)) continue;
        ends.push_back(turned(end, source, p, PathBacktrace<Real>(found).along_line(end)));
      }
    }
    add_ends_from_bends(found, p, limit, ends);
    return ends;
  }

  /// The way from an end back to its source.
  [[nodiscard]] Array<Point> back(const End& end) const {
    const Real limit = end.distance * (1 + needle_rounding) +
                       rounding * longest_side_at(solution_.surface, end.point);
    const WindowSolution<Real> found = from(end.point, limit);
    End nearest;
    Real least = unreachable<Real>;
    for (const auto& source : solution_.sources) {
      const End at_source = PointQuery<Real>(found).nearest(source.point);
      if (!(at_source.distance + source.distance < least)) continue;
      least = at_source.distance + source.distance;
      nearest = at_source;
    }
    if (!(least < unreachable<Real>)) return {};
    Array<Point> path = PathBacktrace<Real>(found).by_windows(nearest);
    std::reverse(path.begin(), path.end());
    return path;
  }

 private:
  // By how much distances of the two ways along one path may differ where they are not.
  static constexpr Real needle_rounding = 1e-9;

  // Solves from the point to the sources, leaving out what the known distances of the vertices show
  // to be a detour beyond `limit`.
  [[nodiscard]] WindowSolution<Real> from(const Point& p, Real limit) const {
    PropagationLimits<Real> limits;
    limits.cancelled = solution_.cancelled.part(0, 0);
    limits.memory = solution_.max_memory;
    limits.distance = limit * (1 + rounding);
    limits.keep_windows = true;
    limits.rest.reserve(solution_.distances.size());
    for (Index v = 0; v < solution_.surface.vertex_count(); ++v) {
      limits.rest.push_back(std::min(solution_.distances[v], solution_.bound_at(v)));
    }
    WindowSolution<Real> found{solution_.surface, solution_.faces};
    found.sources = {{p, 0}};
    WindowPropagation<Real> propagation;
    propagation.run(found.surface, *found.faces, found.sources, limits);
    found.adopt(propagation);
    return found;
  }

  // Of ways that bend at the same vertex the one that came back first is known beyond it; so from
  // there, all straight lines that have a length.
  void add_ends_from_bends(const WindowSolution<Real>& found, const Point& p, Real limit,
                           Array<End>& ends) const {
    const Real near = next_to_vertex * longest_side_at(solution_.surface, p);
    for (Index v = 0; v < solution_.surface.vertex_count(); ++v) {
      const Source<Real> bend{vertex_point<Real>(v), solution_.distances[v]};
      if (!(bend.distance + found.distances[v] <= limit) || found.distances[v] <= near) continue;
      if (!solution_.faces->bends_at(v)) continue;
      for (const End& end : PointQuery<Real>(found).ends_at(bend.point, limit - bend.distance)) {
        const Point begin = PathDirections<Real>(found).beginning(
            end, [&](const End& e) { return PathBacktrace<Real>(found).along_line(e); });
        if (!(begin == p) || !PathBacktrace<Real>(found).is_line(end)) continue;
        End way = turned(end, bend, p, PathBacktrace<Real>(found).along_line(end));
        if (!turns_short(way.back, bend.point)) ends.push_back(std::move(way));
      }
    }
  }

  // Whether a path to a bend goes on from there with a short cut beside it.
  [[nodiscard]] bool turns_short(const Array<Point>& path, const Point& bend) const {
    const PathBacktrace<Real> backtrace(solution_);
    const Index v = bend.element[0];
    const Array<Point> rest = backtrace.by_lines(PointQuery<Real>(solution_).at_vertex(v));
    return path.size() > 1 && rest.size() > 1 &&
           backtrace.has_short_cut(path[path.size() - 2], bend, rest[1]);
  }

  // The way to a source or a bend, as found from p, as the way from there to p.
  [[nodiscard]] static End turned(const End& end, const Source<Real>& source, const Point& p,
                                  Array<Point> path) {
    std::reverse(path.begin(), path.end());
    return {end.distance + source.distance, p, {}, {0, 0}, std::move(path)};
  }

  const WindowSolution<Real>& solution_;
};

}  // namespace gelight::detail
