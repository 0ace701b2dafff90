#include "gelight/image/fast_gaussian.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "support/approx.hpp"

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

using Numbers = std::vector<double>;

// The weights of the pixels of a column of n in the smoothed pixel `at`, of a filter that is the
// same everywhere.
Numbers impulse_response(Index n, Index at, const auto& filter) {
  Image<double> pulse(1, n);
  pulse(0, at) = 1;
  return filter(pulse).pixels();
}

Numbers gaussian_response(double sigma, Index n, Index at) {
  Numbers weights;
  double sum = 0;
  for (Index y = 0; y < n; ++y) {
    weights.push_back(std::exp(-0.5 * (y - at) * (y - at) / (sigma * sigma)));
    sum += weights.back();
  }
  for (double& w : weights) w /= sum;
  return weights;
}

// How far a filter with weights a and b down and across can be from the Gaussian, with g and h, on
// an image with pixels from 0 to 1.
double bound(const Numbers& a, const Numbers& b, const Numbers& g, const Numbers& h) {
  double more = 0, less = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      const double off = a[i] * b[j] - g[i] * h[j];
      (off > 0 ? more : less) += std::abs(off);
    }
  }
  return std::max(more, less);
}

double bound_of(double sigma, const auto& filter) {
  const Index n = 2 * static_cast<Index>(std::ceil(7 * sigma)) + 1;
  const auto a = impulse_response(n, n / 2, filter), g = gaussian_response(sigma, n, n / 2);
  return bound(a, a, g, g);
}

// A pyramid is not the same everywhere: its weights come back after as many pixels as it has
// shrunk by.
double bound_of_pyramid(double sigma) {
  const Index n = 2 * static_cast<Index>(std::ceil(7 * sigma)) + 1;
  const auto period = std::size_t{1} << detail::Pyramid(sigma).levels;
  std::vector<Numbers> rows(period), truth;
  const auto first = n / 2 - static_cast<Index>(period / 2);
  for (Index x = 0; x < n; ++x) {
    const auto seen = impulse_response(
        n, x, [&](const auto& pulse) { return gaussian_pyramid(pulse, sigma, Border::replicate); });
    for (std::size_t k = 0; k < period; ++k) {
      rows[k].push_back(seen[static_cast<std::size_t>(first) + k]);
    }
  }
  for (std::size_t k = 0; k < period; ++k) {
    truth.push_back(gaussian_response(sigma, n, first + static_cast<Index>(k)));
  }
  double worst = 0;
  for (std::size_t k = 0; k < period; ++k) {
    for (std::size_t l = k; l < period; ++l) {
      worst = std::max(worst, bound(rows[k], rows[l], truth[k], truth[l]));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the errors that are said are those of the worst image, over all sigmas") {
  // At the second and third a pyramid becomes a level higher.
  Numbers sigmas{2, std::sqrt(8.5), std::sqrt(38.5), 12, 20};
  for (double sigma = 2.05; sigma < 8; sigma *= 1.03) sigmas.push_back(sigma);
  double recursive = 0, three = 0, five = 0, pyramid = 0;
  for (const double sigma : sigmas) {
    CAPTURE(sigma);
    recursive = std::max(recursive, bound_of(sigma, [&](const auto& pulse) {
                           return gaussian_recursive(pulse, sigma, Border::replicate);
                         }));
    three = std::max(three, bound_of(sigma, [&](const auto& pulse) {
                       return gaussian_boxes(pulse, sigma, 3, Border::replicate);
                     }));
    five = std::max(five, bound_of(sigma, [&](const auto& pulse) {
                      return gaussian_boxes(pulse, sigma, 5, Border::replicate);
                    }));
    const double here = bound_of_pyramid(sigma);
    pyramid = std::max(pyramid, here);
    if (sigma >= 6) CHECK(here < 1e-4);
  }
  CHECK(recursive < 5.5e-4);
  CHECK(recursive > 0.9 * 5.5e-4);
  CHECK(three < 0.043);
  CHECK(three > 0.9 * 0.043);
  CHECK(five < 0.024);
  CHECK(five > 0.9 * 0.024);
  CHECK(pyramid < 3.1e-4);
  CHECK(pyramid > 0.9 * 3.1e-4);
}

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
      CHECK(recursive < 5.5e-4);
      CHECK(three < 4.3e-2);
      CHECK(five < 2.4e-2);
      CHECK(pyramid < 3.1e-4);
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
      CHECK(sum == gelight::test::approx(1).epsilon(1e-12));
      CHECK(variance == gelight::test::approx(sigma * sigma).epsilon(1e-10));
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
  // More than can be counted, or kept.
  for (const int passes : {1 << 28, std::numeric_limits<int>::max()}) {
    CHECK_THROWS_AS((void)gaussian_boxes(image, 1, passes), InvalidInput);
  }
  CHECK(gaussian_radius(1e300, std::numeric_limits<Index>::max(), 1) ==
        std::numeric_limits<Index>::max());
}
