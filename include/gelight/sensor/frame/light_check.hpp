#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/shading/phong.hpp"

namespace gelight::detail {

/// More, in shares of full light, would be infinite in grey levels: and black, times that, is no
/// number.
template <std::floating_point T>
inline constexpr double most_light = double{std::numeric_limits<T>::max()} / 512;

template <class T>
void require_light(const Light<T>& light, const Camera<T>& camera, Specular form, bool any_length,
                   const std::string& name) {
  const auto finite = [](T value) { return std::isfinite(value); };
  const auto require_coefficient = [&](T value, const char* which) {
    require(finite(value), name, " has ", which, ' ', value, ", which is not finite");
    require(std::abs(double{value}) <= most_light<T>, name, " has coefficient ", value,
            ", which is more than the images' type can hold");
  };
  constexpr T most = T(1 + beyond_full_light);
  require_camera_size(light.direction, camera, ("the direction image of " + name).c_str());
  require_coefficient(light.diffuse, "diffuse coefficient");
  require_coefficient(light.specular, "specular coefficient");
  for (const T share : light.rgb) {
    require(share >= 0 && share <= most, name, " has colour (", light.rgb[0], ", ", light.rgb[1],
            ", ", light.rgb[2], "), which is not in shares of full light from 0 to 1");
  }
  require(finite(light.shininess) && light.shininess >= 0, name, " has shininess ", light.shininess,
          ", which is negative or not finite");
  require(form == Specular::gated || light.shininess == std::floor(light.shininess), name,
          " has shininess ", light.shininess,
          ", which the unclamped specular term needs to be an integer");
  for (Index y = 0; y < light.direction.height(); ++y) {
    for (Index x = 0; x < light.direction.width(); ++x) {
      const Vec3<T>& d = light.direction(x, y);
      require(is_finite(d), name, " has direction (", d.x(), ", ", d.y(), ", ", d.z(),
              ") at pixel (", x, ", ", y, "), which is not finite");
      require(any_length || squared_norm(d) <= most * most, name, " has direction (", d.x(), ", ",
              d.y(), ", ", d.z(), ") at pixel (", x, ", ", y, "), which is longer than 1");
    }
  }
}

/// Throws InvalidInput for lights of another size than the camera's image, with numbers that are
/// not finite or too large for the images' type, a colour beyond full light, directions longer than
/// 1 (unless they may have any length), or a shininess that the form of the specular term does not
/// know.
template <class T>
void require_lights(const std::vector<Light<T>>& lights, const Camera<T>& camera, Specular form,
                    bool any_length = false) {
  for (std::size_t k = 0; k < lights.size(); ++k) {
    require_light(lights[k], camera, form, any_length, "light " + std::to_string(k));
  }
}

}  // namespace gelight::detail
