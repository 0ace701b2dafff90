#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/shading/phong.hpp"

namespace gelight::detail {

template <class T>
void require_light(const Light<T>& light, const Camera<T>& camera, Specular form,
                   const std::string& name) {
  const auto finite = [](T value) { return std::isfinite(value); };
  require_camera_size(light.direction, camera, ("the direction image of " + name).c_str());
  require(std::all_of(light.rgb.begin(), light.rgb.end(), finite) && finite(light.diffuse) &&
              finite(light.specular),
          name, " has a colour or coefficient that is not finite");
  require(finite(light.shininess) && light.shininess >= 0, name, " has shininess ", light.shininess,
          ", which is negative or not finite");
  require(form == Specular::gated || light.shininess == std::floor(light.shininess), name,
          " has shininess ", light.shininess,
          ", which the unclamped specular term needs to be an integer");
  for (Index y = 0; y < light.direction.height(); ++y) {
    for (Index x = 0; x < light.direction.width(); ++x) {
      const Vec3<T>& d = light.direction(x, y);
      require(d.allFinite(), name, " has direction (", d.x(), ", ", d.y(), ", ", d.z(),
              ") at pixel (", x, ", ", y, "), which is not finite");
    }
  }
}

/// Throws InvalidInput for lights of another size than the camera's image, with numbers that are
/// not finite, or with a shininess that the form of the specular term does not know.
template <class T>
void require_lights(const std::vector<Light<T>>& lights, const Camera<T>& camera, Specular form) {
  for (std::size_t k = 0; k < lights.size(); ++k) {
    require_light(lights[k], camera, form, "light " + std::to_string(k));
  }
}

}  // namespace gelight::detail
