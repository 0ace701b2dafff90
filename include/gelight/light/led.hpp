#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/transport/tangent_planes.hpp"

namespace gelight {

/// Points along a path on a surface, its ends among them, at most `spacing` apart: an LED that is a
/// line, for the fields that take several points. Light from the nearest of them, at a distance d
/// from the line, is off by an angle of atan(spacing / (2 d)) at most, and its way longer by
/// spacing^2 / (8 d).
///
/// Throws InvalidInput for a path without points, with points that are not of the surface or two in
/// a row that no face holds, and for a spacing that is not positive or by which there are more
/// points than an Index counts.
template <std::floating_point T = double>
[[nodiscard]] std::vector<SurfacePoint<T>> points_along(const Surface<double>& surface,
                                                        const Path<T>& path,
                                                        std::type_identity_t<T> spacing) {
  detail::require(!path.empty(), "the path has no points");
  detail::require(spacing > 0, "points along a path, ", spacing, " apart");
  for (const auto& point : path) surface.require_point(point);
  std::vector<SurfacePoint<T>> points{path[0]};
  for (std::size_t i = 1; i < path.size(); ++i) {
    const auto from = path[i - 1].template cast<double>(), to = path[i].template cast<double>();
    const double length = detail::stable_norm(surface.position(to) - surface.position(from));
    const double pieces = std::ceil(length / double{spacing});
    detail::require(pieces <= std::numeric_limits<Index>::max(), "points along a path, ", spacing,
                    " apart on a way of ", length, ", are too many");
    const Index face = detail::shared_face(surface, from, to);
    detail::require(face >= 0, "no face holds both points ", i - 1, " and ", i, " of the path");
    const auto a = detail::shares_in_face(surface, from, face);
    const auto b = detail::shares_in_face(surface, to, face);
    for (double k = 1; k < pieces; ++k) {
      const double t = k / pieces;
      const SurfacePoint<double> between = face_point<double>(
          face, {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]});
      points.push_back(between.template cast<T>());
    }
    points.push_back(path[i]);
  }
  return points;
}

/// Points as sources of equal start, for the exact solver.
template <std::floating_point T>
[[nodiscard]] std::vector<Source<T>> as_sources(const std::vector<SurfacePoint<T>>& points) {
  std::vector<Source<T>> sources;
  sources.reserve(points.size());
  for (const auto& point : points) sources.push_back({point, 0});
  return sources;
}

}  // namespace gelight
