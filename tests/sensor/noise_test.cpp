#include "gelight/sensor/noise.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace gelight;

namespace {

Image<Rgb8> noisy(std::uint8_t level, double sigma, std::uint64_t seed, std::uint64_t frame = 0) {
  Image<Rgb8> image(200, 150, {level, level, level});
  add_noise(image, sigma, seed, frame);
  return image;
}

}  // namespace

TEST_CASE("noise has the mean, deviation and independence that it should") {
  const auto image = noisy(128, 6, 11);
  const double count = 200 * 150 * 3;
  double sum = 0, squares = 0, beside = 0, beyond_two = 0;
  for (Index y = 0; y < 150; ++y) {
    for (Index x = 0; x < 200; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double d = image(x, y)[c] - 128.0;
        sum += d;
        squares += d * d;
        beyond_two += std::abs(d) > 12.5;
        if (x > 0) beside += d * (image(x - 1, y)[c] - 128.0);
      }
    }
  }
  const double variance = 36 + 1 / 12.0;  // rounding adds a twelfth
  CHECK(std::abs(sum / count) < 4 * 6 / std::sqrt(count));
  CHECK(std::abs(squares / count / variance - 1) < 4 * std::sqrt(2 / count));
  CHECK(std::abs(beside / count / variance) < 4 / std::sqrt(count));
  const double expected = std::erfc(12.5 / 6 / std::sqrt(2.0));
  CHECK(std::abs(beyond_two / count - expected) < 4 * std::sqrt(expected / count));
}

TEST_CASE("the same seed and frame give the same noise, others another") {
  CHECK(noisy(128, 6, 1, 2) == noisy(128, 6, 1, 2));
  CHECK(noisy(128, 6, 1, 2) != noisy(128, 6, 1, 3));
  CHECK(noisy(128, 6, 1, 2) != noisy(128, 6, 2, 2));
}

TEST_CASE("no noise, noise at the ends of the scale, and a sigma that cannot be") {
  CHECK(noisy(77, 0, 5) == Image<Rgb8>(200, 150, {77, 77, 77}));
  int black = 0;
  for (const Rgb8& p : noisy(0, 50, 5).pixels()) black += p[0] == 0;
  int white = 0;
  for (const Rgb8& p : noisy(255, 50, 6).pixels()) white += p[0] == 255;
  // Half of the deviates, and those that round to none.
  CHECK(std::abs(black / 30000.0 - 0.504) < 0.012);
  CHECK(std::abs(white / 30000.0 - 0.504) < 0.012);
  CHECK_THROWS_AS(noisy(0, -1, 5), InvalidInput);
  CHECK_THROWS_AS(noisy(0, std::numeric_limits<double>::quiet_NaN(), 5), InvalidInput);
}
