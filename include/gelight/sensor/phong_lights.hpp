#pragma once

#include <concepts>
#include <vector>

#include "gelight/sensor/background.hpp"
#include "gelight/shading/phong.hpp"

namespace gelight {

/// The reflectance of Phong: the lights of a sensor over what its camera sees without them.
template <std::floating_point T>
struct PhongLights {
  std::vector<Light<T>> lights;         ///< with images of the camera's size
  Background<T> background = {};        ///< what is seen by ambient light
  double ambient = 0.5;                 ///< the share of it that is seen without any light
  Specular specular = Specular::gated;  ///< the form of Phong's specular term
  /// Make the lights' directions tangent to the membrane at rest, and of unit length. At rest it is
  /// then without any light, but for the unclamped specular term.
  bool rectify = false;
  /// Rectified directions keep their lengths, which are the strength of the light.
  bool keep_strength = false;
};

}  // namespace gelight
