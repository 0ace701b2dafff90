#include "gelight/image/fast_gaussian.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

using namespace gelight;

namespace {

constexpr std::array borders{Border::reflect101, Border::reflect, Border::replicate, Border::zero,
                             Border::normalised};

// Edges, dots and noise between 0 and 1.
Image<double> scene(Index width, Index height) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  Image<double> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      image(x, y) = x < width / 3 ? uniform(random) : (x / 20 + y / 15) % 2;
    }
  }
  return image;
}

Image<double> exact(const Image<double>& image, double sigma, Border border) {
  return gaussian(image, sigma, static_cast<Index>(std::ceil(9 * sigma)), border);
}

double worst_difference(const Image<double>& a, const Image<double>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    worst = std::max(worst, std::abs(a.pixels()[i] - b.pixels()[i]));
  }
  return worst;
}

}  // namespace

TEST_CASE("the error against the exact Gaussian is what is said, for any sigma and border") {
  const auto image = scene(150, 110);
  for (const Border border : borders) {
    for (const double sigma : {2.0, 3.3, 5.0, 9.0, 20.0}) {
      CAPTURE(sigma);
      CAPTURE(static_cast<int>(border));
      const auto truth = exact(image, sigma, border);
      const double recursive = worst_difference(gaussian_recursive(image, sigma, border), truth);
      const double three = worst_difference(gaussian_boxes(image, sigma, 3, border), truth);
      const double five = worst_difference(gaussian_boxes(image, sigma, 5, border), truth);
      const double pyramid = worst_difference(gaussian_pyramid(image, sigma, border), truth);
      CHECK(recursive < 3.5e-4);
      CHECK(three < 3e-2);
      CHECK(five < 2e-2);
      CHECK(pyramid < 1e-4);
    }
  }
}

TEST_CASE("a constant stays constant, and small images of any shape are smoothed") {
  for (const auto& [width, height] :
       {std::array{1, 1}, std::array{1, 9}, std::array{8, 1}, std::array{5, 4}}) {
    const Image<double> image(width, height, 3.0);
    for (const Border border :
         {Border::reflect101, Border::reflect, Border::replicate, Border::normalised}) {
      for (const auto& smooth :
           {gaussian_recursive(image, 4, border), gaussian_boxes(image, 4, 3, border),
            gaussian_pyramid(image, 4, border)}) {
        CHECK(worst_difference(smooth, image) < 1e-12);
      }
    }
  }
  CHECK(gaussian_recursive(Image<float>(), 2).width() == 0);
  CHECK(gaussian_boxes(Image<float>(0, 3), 2).height() == 3);
  CHECK(gaussian_pyramid(Image<float>(3, 0), 2).width() == 3);
}

TEST_CASE("boxes have the Gaussian's variance exactly") {
  Image<double> pulse(101, 1);
  pulse(50, 0) = 1;
  for (const double sigma : {0.3, 1.0, 4.2, 7.0}) {
    for (const int passes : {1, 3, 4}) {
      const auto spread = gaussian_boxes(pulse, sigma, passes, Border::replicate);
      double sum = 0, variance = 0;
      for (Index x = 0; x < 101; ++x) {
        sum += spread(x, 0);
        variance += spread(x, 0) * (x - 50) * (x - 50);
      }
      CHECK(sum == doctest::Approx(1).epsilon(1e-12));
      CHECK(variance == doctest::Approx(sigma * sigma).epsilon(1e-10));
    }
  }
}

TEST_CASE("a sigma that cannot be is refused") {
  const Image<double> image(4, 4);
  for (const double bad :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS((void)gaussian_recursive(image, bad), InvalidInput);
    CHECK_THROWS_AS((void)gaussian_boxes(image, bad), InvalidInput);
    CHECK_THROWS_AS((void)gaussian_pyramid(image, bad), InvalidInput);
  }
  CHECK_THROWS_AS((void)gaussian_recursive(image, 0.4), InvalidInput);
  CHECK_THROWS_AS((void)gaussian_boxes(image, 1, 0), InvalidInput);
}
