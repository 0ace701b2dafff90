#pragma once

#include <concepts>
#include <memory>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/engine.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/shortest_path.hpp"
#include "gelight/geodesic/shortest_path/edge_search.hpp"
#include "gelight/geodesic/shortest_path/straightener.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
auto PathSolver<T>::straight_path(const SurfacePoint<T>& from, const SurfacePoint<T>& to) const
    -> Path<T> {
  return cast(straight(checked(from), checked(to)));
}

template <std::floating_point T>
auto PathSolver<T>::new_pool() -> std::shared_ptr<Pool> {
  return std::make_shared<Pool>();
}

template <std::floating_point T>
auto PathSolver<T>::checked(const SurfacePoint<T>& point) const -> Point {
  surface().require_point(point);
  return detail::simplified(surface(), point.template cast<Real>());
}

template <std::floating_point T>
auto PathSolver<T>::cast(const std::vector<Point>& path) -> Path<T> {
  Path<T> out;
  out.reserve(path.size());
  for (const Point& p : path) out.push_back(p.template cast<T>());
  return out;
}

template <std::floating_point T>
auto PathSolver<T>::straight(const Point& from, const Point& to) const -> std::vector<Point> {
  if (from == to) return {from};
  if (detail::share_face(surface(), from, to)) return {from, to};
  std::vector<Point> path;
  {
    const typename Pool::Borrowed search(*searches_);
    path = (*search).path(surface(), from, to, cancelled_);
  }
  return path.size() < 3 ? path : taut(path);
}

template <std::floating_point T>
auto PathSolver<T>::taut(const std::vector<Point>& path) const -> std::vector<Point> {
  std::vector<Point> out =
      detail::Straightener<Real>(surface(), exact_.engine_->faces())(path, cancelled_);
  // Over faces without area it may be led astray.
  const Real before = length(surface(), path);
  return length(surface(), out) <= before * (1 + rounding) ? out : path;
}

template <std::floating_point T>
auto PathSolver<T>::shortest_path(const SurfacePoint<T>& from, const SurfacePoint<T>& to) const
    -> Path<T> {
  const Point a = checked(from), b = checked(to);
  const std::vector<Point> straight_one = straight(a, b);
  if (straight_one.size() < 3) return cast(straight_one);
  const Real longest = length(surface(), straight_one);
  const std::vector<Point> path = exact_.engine_->path_within(a, b, longest * (1 + slack));
  // Where faces are so thin that the search loses its way, the straight path stays.
  const bool is_found = !path.empty() && length(surface(), path) <= longest;
  return cast(is_found ? path : straight_one);
}

template <std::floating_point T>
auto PathSolver<T>::straightened(const Path<T>& path) const -> Path<T> {
  detail::require(!path.empty(), "the path has no points");
  std::vector<Point> points;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Point point = checked(path[i]);
    if (!points.empty() && points.back() == point) continue;
    detail::require(points.empty() || detail::share_face(surface(), points.back(), point),
                    "no face holds point ", i - 1, " of the path and the next");
    points.push_back(point);
  }
  return cast(taut(points));
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class PathSolver<float>;
template class PathSolver<double>;
}  // namespace gelight
#endif
