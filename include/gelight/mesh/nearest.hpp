#pragma once

#include <algorithm>
#include <array>
#include <concepts>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
namespace detail {

template <std::floating_point T>
void require_finite_position(const Vec3<T>& position) {
  require(position.allFinite(), "the position (", position[0], ", ", position[1], ", ", position[2],
          ") is not finite");
}

/// Where a triangle is nearest to the origin: shares of its corners.
template <std::floating_point T>
[[nodiscard]] std::array<T, 3> nearest_weights(const std::array<Vec3<T>, 3>& corners) {
  const Vec3<T> normal = cross<T>(corners[1] - corners[0], corners[2] - corners[0]);
  const T area = normal.squaredNorm();
  std::array<T, 3> weights;
  for (std::size_t k = 0; k < 3; ++k) {
    weights[k] = normal.dot(cross(corners[(k + 1) % 3], corners[(k + 2) % 3])) / area;
  }
  if (area > 0 && *std::min_element(weights.begin(), weights.end()) >= 0) return weights;
  // Not over the triangle, or it has no area: then it is one of the sides.
  std::array<T, 3> best{};
  T least = unreachable<T>;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3<T>&a = corners[k], &b = corners[(k + 1) % 3];
    const T length = (b - a).squaredNorm();
    const T t = length > 0 ? std::clamp(a.dot(a - b) / length, T(0), T(1)) : T(0);
    const T distance = (a + t * (b - a)).squaredNorm();
    if (!(distance < least)) continue;
    least = distance;
    best = {};
    best[k] = 1 - t;
    best[(k + 1) % 3] = t;
  }
  return best;
}

}  // namespace detail

/// The vertex nearest to a position in space, the first of several. Throws InvalidInput for a
/// position that is not finite. Cost: O(vertices).
template <std::floating_point T>
[[nodiscard]] Index nearest_vertex(const Surface<T>& surface, const Vec3<T>& position) {
  detail::require_finite_position(position);
  Index nearest = 0;
  for (Index v = 1; v < surface.vertex_count(); ++v) {
    const T distance = (surface.position(v) - position).squaredNorm();
    if (distance < (surface.position(nearest) - position).squaredNorm()) nearest = v;
  }
  return nearest;
}

/// The point of the surface nearest to a position in space, in the first face of several. Throws
/// InvalidInput for a position that is not finite. Cost: O(faces).
template <std::floating_point T>
[[nodiscard]] SurfacePoint<T> nearest_point(const Surface<T>& surface, const Vec3<T>& position) {
  detail::require_finite_position(position);
  SurfacePoint<T> nearest;
  T least = unreachable<T>;
  for (Index f = 0; f < surface.face_count(); ++f) {
    std::array<Vec3<T>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = surface.position(surface.face(f)[k]) - position;
    }
    const std::array<T, 3> w = detail::nearest_weights(corners);
    const T distance = (w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2]).squaredNorm();
    if (!(distance < least)) continue;
    least = distance;
    nearest = face_point(f, w);
  }
  return nearest;
}

}  // namespace gelight
