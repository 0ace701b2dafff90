#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
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

/// A sensor as one was built.
struct BuiltSensor {
  std::size_t kind;  ///< of the scene's
  double smoothing;  ///< pixels
  gelight::TactileRenderer<float> renderer;
};

/// The sensor of this number: what differs depends on the seed and the number alone.
[[nodiscard]] inline BuiltSensor built_sensor(const Scene& scene,
                                              const std::vector<LitSensor>& kinds,
                                              std::uint64_t number) {
  const Draws draws(scene.seed, Draws::Of::sensor, number);
  const auto kind = static_cast<std::size_t>(draws.uniforms(Drawn::sensor)[0] *
                                             static_cast<double>(kinds.size()));
  const SensorRange& range = scene.sensors[kind];
  const LitSensor& lit = kinds[kind];
  const auto drawn = [&](const Distribution& spread, Drawn what) {
    return spread.draw(draws, what);
  };
  gelight::SensorPreset<float> preset{.membrane = lit.preset.membrane,
                                      .camera = lit.preset.camera,
                                      .leds = lit.preset.leds,
                                      .colours = lit.preset.colours,
                                      .coating = lit.preset.coating,
                                      .falloff = lit.preset.falloff};
  std::vector<gelight::Light<float>> lights;
  for (std::size_t k = 0; k < preset.leds.size(); ++k) {
    const auto which = static_cast<Drawn>(static_cast<std::uint32_t>(Drawn::brightness) + k);
    const auto share = static_cast<float>(drawn(range.brightness, which));
    for (float& channel : preset.colours[k]) channel *= share;
    lights.push_back({.direction = lit.directions[k],
                      .rgb = preset.colours[k],
                      .diffuse = static_cast<float>(drawn(range.diffuse, Drawn::diffuse)),
                      .specular = static_cast<float>(drawn(range.specular, Drawn::specular)),
                      .shininess = static_cast<float>(drawn(range.shininess, Drawn::shininess))});
  }
  gelight::TactileOptions options;
  options.smoothing_sigma = drawn(range.smoothing, Drawn::smoothing);
  options.smoothing_radius = static_cast<Index>(std::ceil(4 * options.smoothing_sigma));
  options.ambient = drawn(range.ambient, Drawn::ambient);
  options.rectify = lit.is_tangent;
  return {kind, options.smoothing_sigma,
          gelight::TactileRenderer<float>(preset.camera, lit.rest.depth, lights,
                                          gelight::coating_light(preset, lit.rest), options)};
}
