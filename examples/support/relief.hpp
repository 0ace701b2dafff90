#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"
#include "scale.hpp"

// Images of depths and of normals, as colours.

/// Depths as twelve bands of colour, from dark where near to light where far.
inline gelight::Image<gelight::Rgb8> depth_bands(const gelight::Image<double>& depth,
                                                 double nearest, double farthest) {
  gelight::Image<gelight::Rgb8> picture(depth.width(), depth.height());
  for (std::size_t i = 0; i < picture.pixels().size(); ++i) {
    const double share = (depth.pixels()[i] - nearest) / (farthest - nearest);
    const Colour colour = band_colour(std::floor(12 * share) / 12);
    const auto level = [](double x) { return static_cast<std::uint8_t>(255 * x); };
    picture.pixels()[i] = {level(colour.red), level(colour.green), level(colour.blue)};
  }
  return picture;
}

/// Normals as colours: red to the right, green downwards, grey where they face the camera;
/// `contrast` times as strong as they tilt.
inline gelight::Image<gelight::Rgb8> normal_colours(
    const gelight::Image<gelight::Vec3<double>>& normals, double contrast) {
  gelight::Image<gelight::Rgb8> picture(normals.width(), normals.height());
  for (std::size_t i = 0; i < picture.pixels().size(); ++i) {
    const gelight::Vec3<double>& n = normals.pixels()[i];
    const auto level = [&](double x) {
      return static_cast<std::uint8_t>(std::clamp(128 + 127 * contrast * x, 0.0, 255.0));
    };
    picture.pixels()[i] = {level(n[0]), level(n[1]), level(-0.5 * (n[0] + n[1]))};
  }
  return picture;
}
