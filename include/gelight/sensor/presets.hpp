#pragma once

#include <cmath>
#include <concepts>
#include <numbers>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// A sensor as somebody built it, in metres and in the frame of its camera.
template <std::floating_point T>
struct SensorPreset {
  Mesh<T> membrane;                   ///< at rest
  Camera<T> camera;                   ///< inside it
  std::vector<SurfacePoint<T>> leds;  ///< where on the membrane light enters
};

/// The GelTip (Gomes, Paoletti, Luo, Simulation of Curved GelSight Sensors for Sim2Real Learning):
/// a finger of 11.46 mm radius and 45.5 mm length, a camera in the middle of its open end that
/// looks at the tip with 90 degrees from top to bottom, and three LEDs at vertices of the rim, a
/// third of a turn apart to half an edge, the first next to the x axis. Throws InvalidInput for a
/// size that is not positive and as `membrane` does for the mesh's edge length.
template <std::floating_point T>
[[nodiscard]] SensorPreset<T> geltip(Index width = 640, Index height = 480,
                                     T edge_length = T(0.001)) {
  constexpr T radius = T(0.01146), length = T(0.0455);
  SensorPreset<T> sensor{membrane<T>(radius, length, edge_length),
                         Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 2, width, height),
                         {}};
  const Surface<T> surface(sensor.membrane);
  for (int k = 0; k < 3; ++k) {
    const T angle = 2 * std::numbers::pi_v<T> / 3 * static_cast<T>(k);
    const Vec3<T> led(radius * std::cos(angle), radius * std::sin(angle), 0);
    sensor.leds.push_back(vertex_point<T>(nearest_vertex<T>(surface, led)));
  }
  return sensor;
}

}  // namespace gelight
