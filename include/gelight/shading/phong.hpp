#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// The specular term of Phong's equation. `gated` is (max(0, R.V))^shininess where N.L > 0 and
/// nothing elsewhere; `unclamped` is (R.V)^shininess everywhere, as the GelTip authors' code has
/// it: an even shininess then lights surfaces that face away from the light.
enum class Specular : std::uint8_t { gated, unclamped };

/// A light that shines on every pixel of a sensor's membrane.
template <std::floating_point T>
struct Light {
  /// The direction in which the light travels when it arrives: unit length, or shorter where it is
  /// dimmer; zero where the pixel is not lit.
  Image<Vec3<T>> direction;
  std::array<T, 3> rgb{1, 1, 1};  ///< colour and intensity, in shares of full light, 0 to 1
  T diffuse = T(0.5);             ///< Phong's k_d
  T specular = T(0.1);            ///< Phong's k_s
  T shininess = 100;              ///< Phong's exponent
};

/// Phong's equation for one light at one point: diffuse N.L + specular (R.V)^shininess, with R the
/// direction to the light mirrored at the normal. The three directions point away from the surface
/// and have unit length. (Phong, Illumination for computer generated pictures, 1975,
/// doi:10.1145/360825.360839)
template <std::floating_point T>
[[nodiscard]] T phong(const Vec3<T>& normal, const Vec3<T>& to_light, const Vec3<T>& to_eye,
                      T diffuse, T specular, T shininess, Specular form = Specular::gated) {
  const T facing = std::max(T(0), dot(normal, to_light));
  const T mirrored = 2 * facing * dot(normal, to_eye) - dot(to_light, to_eye);
  if (form == Specular::unclamped) {
    return diffuse * facing + specular * std::pow(mirrored, shininess);
  }
  if (!(facing > 0)) return 0;
  return diffuse * facing + specular * std::pow(std::max(T(0), mirrored), shininess);
}

}  // namespace gelight
