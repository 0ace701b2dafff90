#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/models.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/presets.hpp"

namespace gelight {

/// The light models that a planner chooses among.
enum class PlannedLight : std::uint8_t {
  linear,     ///< LinearLight
  gel,        ///< GelLight, as `gel_light` makes it of the sensor, each LED shining inwards
  plane,      ///< PlaneLight
  transport,  ///< TransportLight, every way from the LED
  geodesic    ///< GeodesicLight
};

namespace detail {

/// Whether a model's light runs in the membrane, so that at rest it is tangent to it.
[[nodiscard]] inline bool is_tangent(PlannedLight light) {
  return light != PlannedLight::linear && light != PlannedLight::gel;
}

/// The camera whose pixels are the centres of squares of `grid` x `grid` pixels.
template <std::floating_point T>
[[nodiscard]] Camera<T> coarse_camera(const Camera<T>& camera, Index grid) {
  const auto fewer = [&](Index pixels) { return std::max(Index{1}, (pixels + grid / 2) / grid); };
  const Index width = fewer(camera.width), height = fewer(camera.height);
  const T across = T(width) / T(camera.width), down = T(height) / T(camera.height);
  return {camera.fx * across,
          camera.fy * down,
          (camera.cx + T(0.5)) * across - T(0.5),
          (camera.cy + T(0.5)) * down - T(0.5),
          width,
          height};
}

/// The light of one LED at some points of a membrane, by a model.
class MembraneLights {
 public:
  explicit MembraneLights(const SensorPreset<double>& sensor)
      : sensor_(sensor), surface_(sensor.membrane) {}

  /// Of the sensor's membrane.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

  [[nodiscard]] LightField<double> field(PlannedLight light, std::size_t led,
                                         std::span<const SurfacePoint<double>> points,
                                         const CancelHook& cancelled) const {
    const auto by = [&](const auto& model) {
      return led_field(sensor_, surface_, led, model, points, cancelled);
    };
    switch (light) {
      case PlannedLight::linear:
        return by(LinearLight<double>(surface_));
      case PlannedLight::plane:
        return by(PlaneLight<double>(surface_));
      case PlannedLight::transport:
        return by(transport_.get([&] { return TransportLight<double>(surface_); }));
      case PlannedLight::gel:
        return by(gel_.get([&] { return gel_light(sensor_); }));
      default:
        return by(geodesic_.get([&] { return GeodesicLight<double>(surface_); }));
    }
  }

 private:
  const SensorPreset<double>& sensor_;
  Surface<double> surface_;
  Lazy<GelLight<double>> gel_;
  Lazy<TransportLight<double>> transport_;
  Lazy<GeodesicLight<double>> geodesic_;
};

}  // namespace detail
}  // namespace gelight
