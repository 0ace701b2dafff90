#include "gelight/image/smooth.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "support/dented_depth.hpp"

using namespace gelight;

TEST_CASE("correlation shifts by the anchor, and is the Gaussian with its weights") {
  Image<double> pulse(9, 7);
  pulse(4, 3) = 1;
  const std::array<double, 4> kernel{1, 2, 3, 4};
  const auto image = correlate<double>(pulse, kernel, 1);
  for (Index j = 0; j < 4; ++j) {
    CHECK(image(4 - (j - 1), 3) == 2 * kernel[static_cast<std::size_t>(j)]);
  }
  const auto half = gaussian_weights<double>(1.5, 3);
  const std::array<double, 7> whole{half[3], half[2], half[1], half[0], half[1], half[2], half[3]};
  for (const Border border :
       {Border::reflect101, Border::reflect, Border::replicate, Border::zero}) {
    CHECK(worst_difference(correlate<double>(dent(20, 20, 1), whole, 3, border),
                           gaussian(dent(20, 20, 1), 1.5, 3, border)) < 1e-15);
  }
  CHECK_THROWS_AS((void)correlate<double>(pulse, kernel, 4), InvalidInput);
}

TEST_CASE("a mean of the known pixels: a plane's even part stays, unknown pixels stay unknown") {
  Image<double> image(30, 20, 2.5);
  std::mt19937 random(5);
  for (int i = 0; i < 150; ++i) {
    image(static_cast<Index>(random() % 30), static_cast<Index>(random() % 20)) =
        i % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                   : std::numeric_limits<double>::infinity();
  }
  const auto mean = gaussian_of_known(image, 2, 8);
  for (Index y = 0; y < 20; ++y) {
    for (Index x = 0; x < 30; ++x) {
      CHECK(std::isnan(mean(x, y)) == std::isnan(image(x, y)));
      CHECK(std::isinf(mean(x, y)) == std::isinf(image(x, y)));
      if (std::isfinite(image(x, y))) CHECK(mean(x, y) == doctest::Approx(2.5).epsilon(1e-12));
    }
  }
  const auto whole = dent(30, 20, 0.01);
  CHECK(gaussian_of_known(whole, 2, 8) == gaussian(whole, 2, 8));
  auto holed = whole;
  holed(3, 3) = std::numeric_limits<double>::quiet_NaN();
  const auto smooth = gaussian(whole, 2, 5), around = gaussian_of_known(holed, 2, 5);
  for (Index y = 0; y < 20; ++y) {
    for (Index x = 0; x < 30; ++x) {
      if (x > 8 || y > 8) CHECK(around(x, y) == smooth(x, y));
    }
  }
  const auto lost =
      gaussian_of_known(Image<double>(4, 4, std::numeric_limits<double>::quiet_NaN()), 1, 4);
  for (const double pixel : lost.pixels()) CHECK(std::isnan(pixel));
}
