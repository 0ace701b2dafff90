#pragma once

#include <concepts>
#include <span>

#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// Light that travels straight through space from the LED, whatever stands between; zero at the
/// LED. Throws InvalidInput for a point that is not of the surface. Cost: O(points).
template <std::floating_point T>
[[nodiscard]] LightField<T> linear_field(const Surface<T>& surface, const Vec3<T>& led,
                                         std::span<const SurfacePoint<T>> points) {
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) {
    field.push_back(detail::direction_of<T>(surface.position(point) - led));
  }
  return field;
}

}  // namespace gelight
