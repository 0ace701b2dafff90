#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <span>

#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/optics/boundary.hpp"

namespace gelight {

/// A Lambertian LED in the rim of a sheet of gel that has air behind it.
template <std::floating_point T>
struct GelLed {
  Vec3<T> place{0, 0, 0};   ///< its middle, within the gel
  Vec3<T> axis{0, 0, 1};    ///< where it shines, of any length
  Vec3<T> normal{1, 0, 0};  ///< of the membrane there, outwards, of any length
  T depth = 0;              ///< of its middle beneath the membrane, in the unit of the positions
  T thickness = 0;          ///< of the gel
  T index = T(1.41);        ///< refractive, of the gel
  T power = 1;              ///< W, or any other unit
};

namespace detail {

/// What is left of straight light when it arrives `d` long at a membrane bent like a circle from
/// its source to there, with this cosine to the normal: all where it stays in the gel, none where
/// it is totally reflected by the gel's inner side, else what crosses the hollow.
template <std::floating_point T>
[[nodiscard]] double left_of_chord(double d, double cosine, const GelLed<T>& led) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double depth = d / 2 * cosine / (1 + sine);  // of the chord's middle beneath the circle
  if (depth < led.thickness) return 1;
  const double radius = d / (2 * cosine);
  // The hollow is no smaller than where the chord just touches it, but for rounding.
  const double hollow = std::max(radius - led.thickness, sine * radius);
  const double inner = hollow > 0 ? sine * radius / hollow : 0;
  if (inner * led.index >= 1) return 0;
  const double passes = 1 - fresnel(std::sqrt(1 - inner * inner), double{led.index}).reflected;
  return passes * passes;
}

/// Radiance times direction, over the solid angle of a small Lambertian source of unit power.
[[nodiscard]] inline Vec3<double> lambert(const Vec3<double>& way, const Vec3<double>& axis) {
  const double square = squared_norm(way);
  if (square == 0) return {0, 0, 0};
  return std::max(0.0, dot(way, axis)) / (std::numbers::pi * square * square) * way;
}

}  // namespace detail

/// Light that goes straight through the gel from an LED in its rim, and once mirrored by the gel's
/// inner side; where a bend of the membrane hides the LED, what crosses the hollow. With direction,
/// tilt out of the membrane and fall-off, in closed form: nothing is fitted.
///
/// Of each point the radiance times the direction of travel, as `TracedLight::vector`, in the LED's
/// power over the unit of the positions squared: not of unit length; the strength is in it. As
/// `Light::direction` takes at most unit vectors, divide by the longest, or by what shall be full
/// light. Exact for small LEDs in flat gel over air beneath a black coating; bends are taken as
/// circles from the LED to the point, and light that the coating reflects is left out.
///
/// Throws InvalidInput for another number of normals than positions, a position that is not finite,
/// a normal that is zero or not finite, and an LED whose vectors are zero or not finite, whose
/// thickness or power is not positive and finite, whose index is not from 0.01 to 100, or whose
/// depth is not within the gel. O(1) a point.
template <std::floating_point T>
[[nodiscard]] LightField<T> gel_field(const GelLed<T>& led, std::span<const Vec3<T>> positions,
                                      std::span<const Vec3<T>> normals,
                                      const CancelHook& cancelled = {}) {
  using namespace detail::arithmetic;
  const auto require_positive = [](T value, const char* what) {
    detail::require(value > 0 && std::isfinite(value), "the gel's LED: ", what, " is ", value);
  };
  require_positive(led.thickness, "thickness");
  detail::require_index(double{led.index}, "the gel's LED");
  require_positive(led.power, "power");
  detail::require(led.depth >= 0 && led.depth <= led.thickness, "an LED at depth ", led.depth,
                  " of a gel ", led.thickness, " thick");
  detail::require(detail::is_finite(led.place), "the LED is at (", led.place[0], ", ", led.place[1],
                  ", ", led.place[2], ")");
  for (const Vec3<T>& v : {led.axis, led.normal}) {
    detail::require(detail::is_finite(v) && !v.isZero(0), "an axis or normal of the LED is (", v[0],
                    ", ", v[1], ", ", v[2], ")");
  }
  detail::require(normals.size() == positions.size(), positions.size(), " points have ",
                  normals.size(), " normals");
  detail::require_finite(positions, "position");
  const Vec3<double> place = cast<double>(led.place);
  const Vec3<double> axis = detail::stable_unit(cast<double>(led.axis));
  const Vec3<double> up = detail::stable_unit(cast<double>(led.normal));
  // The LED as the gel's inner side mirrors it: so far beneath, and shining the other way there.
  const double below = 2 * (double{led.thickness} - double{led.depth});
  const Vec3<double> mirrored_axis = axis - 2 * dot(axis, up) * up;
  LightField<T> field;
  field.reserve(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    detail::require(normals[i].allFinite() && !normals[i].isZero(0), "normal ", i, " is (",
                    normals[i][0], ", ", normals[i][1], ", ", normals[i][2], ")");
    const Vec3<double> normal = detail::stable_unit(cast<double>(normals[i]));
    const Vec3<double> way = cast<double>(positions[i]) - place;
    const Vec3<double> mirrored = way + below * up;
    const double distance = detail::stable_norm(way), longer = detail::stable_norm(mirrored);
    Vec3<double> sum(0, 0, 0);
    const double cosine = dot(way, normal) / distance, slant = dot(mirrored, normal) / longer;
    if (cosine > 0) {
      sum += detail::left_of_chord(distance, cosine, led) * detail::lambert(way, axis);
    }
    // Where the mirror image's chord leaves the gel, the mirror ended before it.
    if (slant > 0 &&
        longer / 2 * slant / (1 + std::sqrt(std::max(0.0, 1 - slant * slant))) < led.thickness) {
      const double at_mirror = std::min(1.0, std::abs(dot(mirrored, up)) / longer);
      sum += detail::fresnel(at_mirror, double{led.index}).reflected *
             detail::lambert(mirrored, mirrored_axis);
    }
    field.push_back(cast<T>(double{led.power} * sum));
    detail::check_points(cancelled, field.size(), positions.size(), "the gel field");
  }
  return field;
}

}  // namespace gelight
