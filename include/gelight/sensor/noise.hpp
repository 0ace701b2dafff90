#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// A well-mixed number for each number (Steele, Lea, Flood, Fast splittable pseudorandom number
/// generators, 2014, doi:10.1145/2660193.2660195).
[[nodiscard]] inline std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

/// A number of the standard normal distribution for each key, by Box and Muller's transform.
[[nodiscard]] inline double normal_deviate(std::uint64_t key) {
  const std::uint64_t bits = scramble(key);
  const double u = (static_cast<double>(bits >> 32) + 0.5) * 0x1p-32;
  const double v = static_cast<double>(bits & 0xffffffff) * 0x1p-32;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

}  // namespace detail

/// Adds the camera's noise to an image: to each channel of each pixel a normal deviate of standard
/// deviation `sigma` grey levels, rounded and clamped to 8 bits.
///
/// It depends on nothing but seed, frame and pixel, so that it is the same on every machine whose
/// logarithm and cosine are, in any order of frames. Throws InvalidInput for a sigma that is
/// negative or not finite. Some 50 ns a pixel.
inline void add_noise(ImageView<Rgb8> image, double sigma, std::uint64_t seed,
                      std::uint64_t frame = 0) {
  detail::require(std::isfinite(sigma) && sigma >= 0, "sigma ", sigma,
                  " is negative or not finite");
  const std::uint64_t stream = detail::scramble(detail::scramble(seed) ^ frame);
  std::uint64_t key = 0;
  for (Index y = 0; y < image.height(); ++y) {
    for (Index x = 0; x < image.width(); ++x) {
      for (std::uint8_t& channel : image(x, y)) {
        const double level = std::round(channel + sigma * detail::normal_deviate(stream + key++));
        channel = static_cast<std::uint8_t>(level < 0 ? 0 : level > 255 ? 255 : level);
      }
    }
  }
}

}  // namespace gelight
