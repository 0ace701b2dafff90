#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// A polyline on a surface; each piece lies in one face or along one edge.
template <std::floating_point T>
using Path = std::vector<SurfacePoint<T>>;

namespace detail {

/// A point that is of the surface, in the surface's precision.
template <std::floating_point T, std::floating_point P = T>
[[nodiscard]] SurfacePoint<T> point_of(const Surface<T>& surface, const SurfacePoint<P>& point) {
  surface.require_point(point);
  if constexpr (std::same_as<P, T>) {
    return point;
  } else {
    return point.template cast<T>();
  }
}

}  // namespace detail

/// The positions of a path's points. (Here and below the path may be of another precision than the
/// surface, as those of solvers are that work in double on a mesh of floats.) Throws InvalidInput
/// for a point that is not of the surface.
template <std::floating_point T, std::floating_point P = T>
[[nodiscard]] std::vector<Vec3<T>> positions(const Surface<T>& surface, const Path<P>& path) {
  std::vector<Vec3<T>> out;
  out.reserve(path.size());
  for (const auto& point : path) out.push_back(surface.position(detail::point_of(surface, point)));
  return out;
}

/// Length of a path, in the unit and precision of the positions; 0 for fewer than two points.
/// Throws InvalidInput for a point that is not of the surface, and for a length that T cannot hold.
template <std::floating_point T, std::floating_point P = T>
[[nodiscard]] T length(const Surface<T>& surface, const Path<P>& path) {
  if (path.size() == 1) surface.require_point(path[0]);
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const auto from = detail::point_of(surface, path[i - 1]);
    const auto to = detail::point_of(surface, path[i]);
    sum += static_cast<double>(detail::stable_norm(surface.difference(from, to)));
  }
  detail::require(sum <= detail::largest_number<T>, "the path is ", sum,
                  " long, more than its type can hold");
  return static_cast<T>(sum);
}

/// A face that holds each piece of a path: one fewer than it has points. Of several, where a piece
/// runs along an edge, the least. Throws InvalidInput for a point that is not of the surface, and
/// two in a row that no face holds.
template <std::floating_point T, std::floating_point P = T>
[[nodiscard]] std::vector<Index> faces_along(const Surface<T>& surface, const Path<P>& path) {
  for (const auto& point : path) surface.require_point(point);
  std::vector<Index> out;
  for (std::size_t i = 1; i < path.size(); ++i) {
    Index least = surface.face_count();
    const auto from = detail::point_of(surface, path[i - 1]);
    const auto to = detail::point_of(surface, path[i]);
    detail::for_each_face_at(surface, from, [&](Index f) {
      detail::for_each_face_at(surface, to, [&](Index g) {
        if (f == g) least = std::min(least, f);
      });
    });
    detail::require(least < surface.face_count(), "no face holds both point ", i - 1,
                    " of the path and the next");
    out.push_back(least);
  }
  return out;
}

}  // namespace gelight
