#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <type_traits>

#include "gelight/core/error.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
namespace detail {

template <std::floating_point T>
void require_finite_position(const Vec3<T>& position) {
  require(detail::is_finite(position), "the position (", position[0], ", ", position[1], ", ",
          position[2], ") is not finite");
  require(static_cast<double>(detail::largest_part(position)) <= largest_coordinate,
          "the position (", position[0], ", ", position[1], ", ", position[2],
          ") is too far out: products of lengths would overflow");
}

template <std::floating_point Real, std::floating_point T>
[[nodiscard]] Vec3<Real> from_position(const Surface<T>& surface, Index vertex,
                                       const Vec3<T>& position) {
  return cast<Real>(surface.position(vertex)) - cast<Real>(position);
}

/// Where a triangle is nearest to the origin: shares of its corners, which sum to 1 however far it
/// is. (A template only so that it costs nothing to include.)
template <std::floating_point Real>
[[nodiscard]] std::array<Real, 3> nearest_weights(const std::array<Vec3<Real>, 3>& corners) {
  const Vec3<Real> u = corners[1] - corners[0], v = corners[2] - corners[0];
  const Real size = std::max(stable_norm(u), stable_norm(v));
  const Vec3<Real> b = u / (size > 0 ? size : 1), c = v / (size > 0 ? size : 1);
  const Vec3<Real> normal = cross(b, c);
  const Real area = squared_norm(normal);
  if (area > 0) {
    // The origin, from the first corner and in the plane, where it is no farther than it has to be.
    const Vec3<Real> up = normal / std::sqrt(area), to = -corners[0] / size;
    const Vec3<Real> p = to - dot(to, up) * up;
    const Real second = dot(normal, cross(p, c)) / area, third = dot(normal, cross(b, p)) / area;
    const Real first = 1 - second - third;
    if (first >= 0 && second >= 0 && third >= 0) return {first, second, third};
  }
  // Not over the triangle, or it has no area: then it is one of the sides.
  std::array<Real, 3> best{};
  Real least = unreachable<Real>;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3<Real>&from = corners[k], &to = corners[(k + 1) % 3];
    const Real length = squared_norm(to - from);
    const Real t = length > 0 ? std::clamp(dot(from, from - to) / length, Real(0), Real(1)) : 0;
    const Real distance = squared_norm(from + t * (to - from));
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
/// position that is not finite or beyond 1e75. Cost: O(vertices).
template <std::floating_point T>
[[nodiscard]] Index nearest_vertex(const Surface<T>& surface,
                                   const std::type_identity_t<Vec3<T>>& position) {
  detail::require_finite_position(position);
  using Real = std::common_type_t<T, double>;
  Index nearest = 0;
  Real least = unreachable<Real>;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const Real distance = squared_norm(detail::from_position<Real>(surface, v, position));
    if (distance < least) nearest = v;
    least = std::min(least, distance);
  }
  return nearest;
}

/// The point of the surface nearest to a position in space, in the first face of several. Throws
/// InvalidInput for a position that is not finite or beyond 1e75. Cost: O(faces).
template <std::floating_point T>
[[nodiscard]] SurfacePoint<T> nearest_point(const Surface<T>& surface,
                                            const std::type_identity_t<Vec3<T>>& position) {
  detail::require_finite_position(position);
  using Real = std::common_type_t<T, double>;
  SurfacePoint<T> nearest;
  Real least = unreachable<Real>;
  for (Index f = 0; f < surface.face_count(); ++f) {
    std::array<Vec3<Real>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = detail::from_position<Real>(surface, surface.face(f)[k], position);
    }
    const std::array<Real, 3> w = detail::nearest_weights(corners);
    const Real distance = squared_norm(w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2]);
    if (!(distance < least)) continue;
    least = distance;
    nearest = face_point<T>(f, {static_cast<T>(w[0]), static_cast<T>(w[1]), static_cast<T>(w[2])});
  }
  return nearest;
}

}  // namespace gelight
