#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "gelight/sensor/planning/trials.hpp"

namespace gelight::detail {

/// What a chain costs, in operations of half a nanosecond, estimated from how large its parts are:
/// constants fitted to what a GelTip's parts take on one core, within a factor of two.
class SensorCosts {
 public:
  explicit SensorCosts(SensorSizes sizes) : sizes_(std::move(sizes)) {}

  /// For what is computed once and depends on the choice: the light of all LEDs.
  [[nodiscard]] double once(const SensorChoice& choice) const {
    const double points = sizes_.seen / (double(choice.grid) * double(choice.grid));
    const double resized = choice.grid > 1 ? sizes_.width * sizes_.height : 0;
    const LightCost& light = lights[static_cast<std::size_t>(choice.light)];
    const double vertices = sizes_.vertices[choice.mesh];
    return light.once * vertices + sizes_.leds * (light.led * vertices * std::log2(vertices) +
                                                  light.point * points + resizing * resized);
  }

  /// For a frame: what of the image a contact changes is smoothed and shaded.
  [[nodiscard]] double frame(const SensorChoice& choice) const {
    const double all = sizes_.width * sizes_.height;
    const double lanes = choice.is_single ? 2 : 1;
    if (choice.membrane != PlannedMembrane::gaussian) {
      return all * (untouched + shading + led * sizes_.leds) / lanes + gel(choice, lanes);
    }
    double pixels = 0;
    for (const auto& [across, down] : sizes_.contacts) {
      pixels += std::min(sizes_.width, across + 2 * choice.radius + block) *
                std::min(sizes_.height, down + 2.0 * choice.radius);
    }
    pixels /= static_cast<double>(sizes_.contacts.size());
    const double smoothing = choice.radius > 0 ? tap * (4.0 * choice.radius + 2) : 0;
    return (untouched * all + pixels * (smoothing + shading + led * sizes_.leds)) / lanes;
  }

  /// Of a choice's part: for the first three topics once, for the others a frame.
  [[nodiscard]] double of(SensorTopic topic, const SensorChoice& choice) const {
    return topic == SensorTopic::smoothing || topic == SensorTopic::precision ? frame(choice)
                                                                              : once(choice);
  }

 private:
  struct LightCost {
    double once, led, point;  // a vertex; a vertex and LED, times the logarithm; a point and LED
  };
  static constexpr std::array<LightCost, 5> lights{{{0, 0, 190},        // linear
                                                    {0, 0, 430},        // gel
                                                    {0, 150, 110},      // plane
                                                    {17000, 95, 105},   // transport
                                                    {700, 200, 700}}};  // geodesic
  // A pixel; in double, for what follows resizing.
  static constexpr double resizing = 24, untouched = 3.2, tap = 0.5, shading = 28, led = 10;
  static constexpr double block = 64;

  // A pixel of a bulging membrane; the layer's convolutions, each two Fourier transforms, which
  // work in double, of twice the object's box.
  static constexpr double bulge = 26, convolutions = 30, fourier = 3;

  [[nodiscard]] double gel(const SensorChoice& choice, double lanes) const {
    if (choice.membrane == PlannedMembrane::bulging) {
      return bulge * sizes_.width * sizes_.height / lanes;
    }
    double operations = 0;
    for (const auto& [across, down] : sizes_.contacts) {
      const double places = 4 * across * down;
      operations += 2 * convolutions * fourier * places * std::log2(places);
    }
    return operations / static_cast<double>(sizes_.contacts.size());
  }

  SensorSizes sizes_;
};

}  // namespace gelight::detail
