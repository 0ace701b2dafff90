#pragma once

#include <concepts>
#include <span>

#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// Light that travels straight through space from the LED, whatever stands between, to positions
/// anywhere; zero at the LED. Cost: O(positions).
template <std::floating_point T>
[[nodiscard]] LightField<T> linear_field(const Vec3<T>& led, std::span<const Vec3<T>> positions) {
  LightField<T> field;
  field.reserve(positions.size());
  for (const Vec3<T>& p : positions) field.push_back(detail::direction_of<T>(p - led));
  return field;
}

/// The same to points of a surface. Throws InvalidInput for a point that is not of the surface.
template <std::floating_point T>
[[nodiscard]] LightField<T> linear_field(const Surface<T>& surface, const Vec3<T>& led,
                                         std::span<const SurfacePoint<T>> points) {
  LightField<T> positions;
  positions.reserve(points.size());
  for (const auto& point : points) positions.push_back(surface.position(point));
  return linear_field<T>(led, positions);
}

}  // namespace gelight
