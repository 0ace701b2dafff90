#include "gelight/image/smooth.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "gelight/image/fast_gaussian.hpp"
#include "support/approx.hpp"
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
      if (std::isfinite(image(x, y)))
        CHECK(mean(x, y) == gelight::test::approx(2.5).epsilon(1e-12));
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

TEST_CASE_TEMPLATE("where little is known it is the mean of that, however wide the Gaussian", T,
                   float, double) {
  std::mt19937 random(9);
  for (const double sigma : {2.0, 20.0, 200.0, 1000.0}) {
    for (const int known : {1, 2, 5, 40}) {
      for (const Border border : {Border::reflect101, Border::replicate, Border::normalised}) {
        constexpr T constant = T(0.037);
        Image<T> image(64, 48, std::numeric_limits<T>::quiet_NaN());
        for (int i = 0; i < known; ++i) {
          image(static_cast<Index>(random() % 64), static_cast<Index>(random() % 48)) = constant;
        }
        const auto mean = gaussian_of_known(image, sigma, static_cast<Index>(2 * sigma), border);
        for (std::size_t i = 0; i < mean.pixels().size(); ++i) {
          if (std::isnan(image.pixels()[i])) continue;
          CHECK(mean.pixels()[i] ==
                gelight::test::approx(constant).epsilon(sizeof(T) == 4 ? 2e-5 : 3e-8));
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("what is no number reaches no further than the filter", T, float, double) {
  std::mt19937 random(2);
  const T inf = std::numeric_limits<T>::infinity();
  for (const T bad : {inf, -inf, std::numeric_limits<T>::quiet_NaN()}) {
    const auto at_x = static_cast<Index>(random() % 60), at_y = static_cast<Index>(random() % 40);
    Image<T> whole(60, 40, T(0.5)), holed = whole;
    holed(at_x, at_y) = bad;
    const auto check = [&](const auto& filter, Index reach) {
      const auto want = filter(whole), got = filter(holed);
      int wrong = 0;
      for (Index y = 0; y < 40; ++y) {
        for (Index x = 0; x < 60; ++x) {
          const bool is_beyond = std::abs(x - at_x) > reach || std::abs(y - at_y) > reach;
          wrong += is_beyond && std::abs(got(x, y) - want(x, y)) > T(1e-6) ? 1 : 0;
          wrong += is_beyond && !std::isfinite(got(x, y)) ? 1 : 0;
        }
      }
      CHECK(wrong == 0);
      CHECK(!std::isfinite(got(at_x, at_y)));
    };
    for (const Index radius : {1, 3, 9}) {
      check([&](const auto& image) { return gaussian(image, 0, radius); }, 0);
      check([&](const auto& image) { return gaussian(image, 1e-5, radius); }, 0);
      check([&](const auto& image) { return gaussian(image, 2, radius); }, radius);
    }
    for (const int passes : {1, 3, 5}) {
      for (const double sigma : {0.5, 1.0, 3.0}) {
        const auto reach = passes * (static_cast<Index>(std::sqrt(3 * sigma * sigma / passes)) + 2);
        check([&](const auto& image) { return gaussian_boxes(image, sigma, passes); }, reach);
      }
    }
  }
}

TEST_CASE("an image without columns or rows is correlated into one") {
  const std::array<double, 3> kernel{1, 2, 1};
  for (const Border border :
       {Border::reflect101, Border::reflect, Border::replicate, Border::zero}) {
    for (const Index rows : {0, 3}) {
      CHECK(correlate<double>(Image<double>(0, rows), kernel, 1, border) == Image<double>(0, rows));
      CHECK(correlate<double>(Image<double>(rows, 0), kernel, 1, border) == Image<double>(rows, 0));
    }
  }
}
