#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "gelight/image/normals.hpp"
#include "gelight/light/models.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/sensor/presets.hpp"
#include "scene.hpp"

// The sensors of a scene: their light, found once for all threads, and those that are built of it,
// which differ in what the scene spreads.

using gelight::Image;
using gelight::Index;
using gelight::Vec3;

/// A kind of sensor, with all that does not depend on what is drawn.
struct LitSensor {
  gelight::SensorPreset<float> preset;
  gelight::Raster<float> rest;
  Image<Vec3<float>> normals;                  ///< at rest, towards the camera
  std::vector<Image<Vec3<float>>> directions;  ///< of each LED's light
  bool is_tangent = true;                      ///< whether the light runs in the membrane
};

[[nodiscard]] inline gelight::SensorPreset<float> preset_of(const SensorRange& range, Index width,
                                                            Index height) {
  const auto edge = static_cast<float>(range.edge);
  if (range.model == "gelsight_mini") return gelight::gelsight_mini(width, height, edge);
  if (range.model == "digit") return gelight::digit(width, height, edge);
  if (range.model == "sts") return gelight::sts(width, height, edge);
  return gelight::geltip(width, height, edge);
}

template <class Model>
void light_up(LitSensor& sensor, const Model& model) {
  const auto points = gelight::pixel_points(sensor.rest);
  const gelight::Surface<float> membrane(sensor.preset.membrane);
  for (std::size_t led = 0; led < sensor.preset.leds.size(); ++led) {
    const auto field = gelight::led_field(sensor.preset, membrane, led, model, points);
    sensor.directions.push_back(gelight::bake(field, sensor.rest));
  }
  sensor.is_tangent = Model::is_tangent;
}

[[nodiscard]] inline LitSensor lit_sensor(const SensorRange& range, Index width, Index height) {
  LitSensor sensor;
  sensor.preset = preset_of(range, width, height);
  const auto& membrane = sensor.preset.membrane;
  sensor.rest = gelight::rasterize(membrane, sensor.preset.camera);
  sensor.normals = gelight::sobel_normals(sensor.rest.depth, sensor.preset.camera);
  if (range.light == "linear") {
    light_up(sensor, gelight::LinearLight(membrane));
  } else if (range.light == "plane") {
    light_up(sensor, gelight::PlaneLight(membrane));
  } else if (range.light == "transport") {
    light_up(sensor, gelight::TransportLight(membrane));
  } else {
    light_up(sensor, gelight::GeodesicLight(membrane));
  }
  return sensor;
}

/// What is drawn of a sensor.
struct DrawnSensor {
  std::size_t kind = 0;            ///< of the scene's
  std::vector<double> brightness;  ///< of each LED
  double ambient = 0, diffuse = 0, specular = 0, shininess = 0;
  double smoothing = 0;  ///< pixels

  bool operator==(const DrawnSensor&) const = default;
};

/// The sensor of this number: it depends on the seed and the number alone.
[[nodiscard]] inline DrawnSensor drawn_sensor(const Scene& scene,
                                              const std::vector<LitSensor>& kinds,
                                              std::uint64_t number) {
  const Draws draws(scene.seed, Draws::Of::sensor, number);
  DrawnSensor sensor;
  sensor.kind = static_cast<std::size_t>(draws.uniforms(Drawn::sensor)[0] *
                                         static_cast<double>(kinds.size()));
  const SensorRange& range = scene.sensors[sensor.kind];
  for (std::size_t k = 0; k < kinds[sensor.kind].preset.leds.size(); ++k) {
    const auto which = static_cast<Drawn>(static_cast<std::uint32_t>(Drawn::brightness) + k);
    sensor.brightness.push_back(range.brightness.draw(draws, which));
  }
  sensor.ambient = range.ambient.draw(draws, Drawn::ambient);
  sensor.diffuse = range.diffuse.draw(draws, Drawn::diffuse);
  sensor.specular = range.specular.draw(draws, Drawn::specular);
  sensor.shininess = range.shininess.draw(draws, Drawn::shininess);
  sensor.smoothing = range.smoothing.draw(draws, Drawn::smoothing);
  return sensor;
}

/// Its numbers in a row: brightness of up to four LEDs (NaN: none), and the others.
[[nodiscard]] inline std::array<double, 9> light_of(const DrawnSensor& sensor) {
  std::array<double, 9> numbers;
  numbers.fill(std::numeric_limits<double>::quiet_NaN());
  std::copy(sensor.brightness.begin(), sensor.brightness.end(), numbers.begin());
  const std::array others{sensor.ambient, sensor.diffuse, sensor.specular, sensor.shininess,
                          sensor.smoothing};
  std::copy(others.begin(), others.end(), numbers.begin() + 4);
  return numbers;
}

/// A sensor as one was built.
struct BuiltSensor {
  DrawnSensor drawn;
  gelight::TactileRenderer<float> renderer;
};

[[nodiscard]] inline BuiltSensor built_sensor(const LitSensor& lit, const DrawnSensor& drawn) {
  gelight::SensorPreset<float> preset{.membrane = lit.preset.membrane,
                                      .camera = lit.preset.camera,
                                      .leds = lit.preset.leds,
                                      .colours = lit.preset.colours,
                                      .coating = lit.preset.coating,
                                      .falloff = lit.preset.falloff};
  std::vector<gelight::Light<float>> lights;
  for (std::size_t k = 0; k < preset.leds.size(); ++k) {
    const auto share = static_cast<float>(drawn.brightness[k]);
    for (float& channel : preset.colours[k]) channel *= share;
    lights.push_back({.direction = lit.directions[k],
                      .rgb = preset.colours[k],
                      .diffuse = static_cast<float>(drawn.diffuse),
                      .specular = static_cast<float>(drawn.specular),
                      .shininess = static_cast<float>(drawn.shininess)});
  }
  gelight::TactileOptions options;
  options.smoothing_sigma = drawn.smoothing;
  options.smoothing_radius = static_cast<Index>(std::ceil(4 * options.smoothing_sigma));
  options.ambient = drawn.ambient;
  options.rectify = lit.is_tangent;
  options.border_normals = gelight::BorderNormals::extrapolated;  // lit up to the image's edge
  return {drawn,
          gelight::TactileRenderer<float>(preset.camera, lit.rest.depth, lights,
                                          gelight::coating_light(preset, lit.rest), options)};
}
