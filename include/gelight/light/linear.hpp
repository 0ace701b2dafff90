#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>

#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {

/// Throws InvalidInput where the way from the LED to a position is longer than any number.
template <std::floating_point T>
void require_near_led(T length, const Vec3<T>& p, std::size_t i) {
  require(std::isfinite(length), "position ", i, " is (", p[0], ", ", p[1], ", ", p[2],
          "), so far from the LED that its distance is beyond all numbers");
}

}  // namespace detail

/// Light that travels straight through space from the LED, whatever stands between, to positions
/// anywhere; zero at the LED. Throws InvalidInput for an LED or a position that is not finite, and
/// for one so far from the other that T has no number for it. Cost: O(positions).
template <std::floating_point T>
[[nodiscard]] LightField<T> linear_field(const Vec3<T>& led,
                                         std::type_identity_t<std::span<const Vec3<T>>> positions,
                                         const CancelHook& cancelled = {}) {
  using namespace detail::arithmetic;
  detail::require_finite(std::span(&led, 1), "the LED's point");
  detail::require_finite(positions, "position");
  LightField<T> field;
  field.reserve(positions.size());
  for (const Vec3<T>& p : positions) {
    const Vec3<T> way = p - led;
    detail::require_near_led(detail::largest_part(way), p, field.size());
    field.push_back(detail::direction_of(way));
    detail::check_points(cancelled, field.size(), positions.size(), "the linear field");
  }
  return field;
}

/// The same from an LED of several points, each position lit by the nearest, with distances; the
/// first of several nearest is taken where they tie. Throws InvalidInput for no LED, and
/// for a point of it or a position that is not finite, or so far from all points that T has no
/// number for it. Cost: O(positions x points of the LED).
template <std::floating_point T>
[[nodiscard]] LightRays<T> linear_rays(std::span<const Vec3<T>> led,
                                       std::span<const Vec3<T>> positions,
                                       const CancelHook& cancelled = {}) {
  using namespace detail::arithmetic;
  detail::require(!led.empty(), "the LED has no point");
  detail::require_finite(led, "the LED's point");
  detail::require_finite(positions, "position");
  LightRays<T> rays;
  for (const Vec3<T>& p : positions) {
    Vec3<T> way = p - led[0];
    T least = detail::stable_norm(way), next = unreachable<T>;
    for (const Vec3<T>& point : led.subspan(1)) {
      const Vec3<T> other = p - point;
      if (other == way) continue;  // the same point again, as of a closed line, is no tie
      const T distance = detail::stable_norm(other);
      next = std::min(next, std::max(least, distance));
      if (distance < least) way = other;
      least = std::min(least, distance);
    }
    detail::require_near_led(least, p, rays.distance.size());
    const Lighting how = least == 0      ? Lighting::at_led
                         : next == least ? Lighting::ambiguous
                                         : Lighting::lit;
    rays.add(detail::direction_of(way), least, how);
    detail::check_points(cancelled, rays.distance.size(), positions.size(), "the linear field");
  }
  return rays;
}

/// The light of one point to points of a surface. Throws InvalidInput for a point that is not of
/// the surface.
template <std::floating_point T>
[[nodiscard]] LightField<T> linear_field(const Surface<T>& surface, const Vec3<T>& led,
                                         PointSpan<T> points, const CancelHook& cancelled = {}) {
  LightField<T> positions;
  positions.reserve(points.size());
  for (const auto& point : points) positions.push_back(surface.position(point));
  return linear_field<T>(led, positions, cancelled);
}

}  // namespace gelight
