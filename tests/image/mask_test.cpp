#include "gelight/image/mask.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace gelight;

TEST_CASE("a circle keeps what lies in it, its own pixels included") {
  const auto masked = circular_mask(Image<float>(9, 7, 2.f), 4, 3, 2);
  int known = 0;
  for (Index y = 0; y < 7; ++y) {
    for (Index x = 0; x < 9; ++x) {
      const bool inside = (x - 4) * (x - 4) + (y - 3) * (y - 3) <= 4;
      CHECK(std::isnan(masked(x, y)) == !inside);
      known += inside;
    }
  }
  CHECK(known == 13);
  CHECK(masked(6, 3) == 2);
  // Whose squares are infinite, or zero.
  CHECK(std::isnan(circular_mask(Image<float>(1, 1), 1e300, 0, 1e200)(0, 0)));
  CHECK(std::isnan(circular_mask(Image<float>(1, 1), 0, 1e-180, 1e-200)(0, 0)));
  CHECK(circular_mask(Image<float>(1, 1), 1e200, 0, 1e300)(0, 0) == 0);
  CHECK_THROWS_AS((void)circular_mask(Image<float>(2, 2), 0, 0, -1), InvalidInput);
  CHECK_THROWS_AS(
      (void)circular_mask(Image<float>(2, 2), 0, 0, std::numeric_limits<double>::quiet_NaN()),
      InvalidInput);
  for (const double off : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL}) {
    CHECK_THROWS_AS((void)circular_mask(Image<float>(2, 2), off, 0, 1), InvalidInput);
    CHECK_THROWS_AS((void)circular_mask(Image<float>(2, 2), 0, off, 1), InvalidInput);
  }
}
