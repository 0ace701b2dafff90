#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/calibration/circle.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// Where a ball may touch, and whether its rim stands out clearly.
struct CircleProposal {
  Circle circle;
  bool is_sharp = false;
};

/// By how much a photograph differs from its background, each channel less its median over the
/// image (the camera's level).
[[nodiscard]] inline Image<std::array<float, 3>> changed_by(const Image<Rgb8>& background,
                                                            const Image<Rgb8>& photograph) {
  Image<std::array<float, 3>> by(background.width(), background.height());
  const std::size_t count = by.pixels().size();
  for (std::size_t c = 0; c < 3; ++c) {
    const auto shifted = [&](std::size_t i) {
      return 255 + photograph.pixels()[i][c] - background.pixels()[i][c];
    };
    std::array<std::size_t, 511> counts{};
    for (std::size_t i = 0; i < count; ++i) ++counts[static_cast<std::size_t>(shifted(i))];
    std::size_t median = 0;
    for (std::size_t below = counts[0]; 2 * below < count; below += counts[++median]) {
    }
    for (std::size_t i = 0; i < count; ++i) {
      by.pixels()[i][c] = static_cast<float>(shifted(i) - static_cast<int>(median));
    }
  }
  return by;
}

/// How much more a disc is odd about its centre than even: what is bright on one side of a ball is
/// dark on the other.
[[nodiscard]] inline double oddness(const Image<std::array<float, 3>>& by, Index x, Index y,
                                    Index radius, Index step) {
  double sum = 0;
  for (Index v = 0; v <= radius; v += step) {
    for (Index u = -radius; u <= radius; u += step) {
      if (u * u + v * v > radius * radius || (v == 0 && u <= 0)) continue;
      if (x + u < 0 || x - u < 0 || x + u >= by.width() || x - u >= by.width()) continue;
      if (y - v < 0 || y + v >= by.height()) continue;
      const auto& one = by(x + u, y + v);
      const auto& other = by(x - u, y - v);
      for (std::size_t c = 0; c < 3; ++c) sum -= double{one[c]} * double{other[c]};
    }
  }
  return sum;
}

/// The mean absolute change on a circle, as far as it lies in the image.
[[nodiscard]] inline double mean_on_circle(const Image<std::array<float, 3>>& by,
                                           const Circle& circle) {
  constexpr int points = 64;
  double sum = 0, inside = 0;
  for (int k = 0; k < points; ++k) {
    const double angle = 2 * std::numbers::pi * k / points;
    const auto x = static_cast<Index>(std::lround(circle.x + circle.radius * std::cos(angle)));
    const auto y = static_cast<Index>(std::lround(circle.y + circle.radius * std::sin(angle)));
    if (x < 0 || y < 0 || x >= by.width() || y >= by.height()) continue;
    for (const float value : by(x, y)) sum += std::abs(double{value});
    ++inside;
  }
  return inside == 0 ? 0 : sum / inside;
}

/// Searches for the centre about which the change is the most odd, coarsely and then pixel by
/// pixel, and for the radius at which the change is on its way from its largest to what it is a
/// ball's radius out: the middle between where it is largest and where it has fallen by half.
[[nodiscard]] inline CircleProposal propose_circle(const Image<Rgb8>& background,
                                                   const Image<Rgb8>& photograph,
                                                   double ball_radius,
                                                   const CancelHook& cancelled) {
  const auto by = changed_by(background, photograph);
  // What lies beyond the image tells nothing.
  const double most_radius = std::hypot(by.width(), by.height());
  const Index reach = std::max(3, static_cast<Index>(std::min(0.8 * ball_radius, most_radius)));
  Index x = 0, y = 0;
  double most = -std::numeric_limits<double>::infinity(), sum = 0, squares = 0, tried = 0;
  const auto attempt = [&](Index u, Index v, Index step) {
    const double odd = oddness(by, u, v, reach, step) * step * step;
    sum += odd;
    squares += odd * odd;
    ++tried;
    if (odd <= most) return;
    most = odd;
    x = u;
    y = v;
  };
  const Index coarse = std::max(1, reach / 10);
  for (Index v = 0; v < by.height(); v += coarse) {
    cancelled.check(0, "the search for a circle");
    for (Index u = 0; u < by.width(); u += coarse) attempt(u, v, coarse);
  }
  const double mean = sum / tried,
               deviation = std::sqrt(std::max(0.0, squares / tried - mean * mean));
  CircleProposal best;
  best.is_sharp = most > mean + 5 * deviation;
  // Around a large ball in ever smaller steps: pixel by pixel at once would be work with the fourth
  // power of its radius.
  const Index sampled = std::max(2, reach / 100);
  for (Index step = coarse, next = 0; next != 1; step = next) {
    next = step > 10 ? step / 4 : 1;
    most = -std::numeric_limits<double>::infinity();
    const Index from_x = x, from_y = y;
    for (Index v = std::max(0, from_y - step); v <= std::min(by.height() - 1, from_y + step);
         v += next) {
      cancelled.check(0, "the search for a circle");
      for (Index u = std::max(0, from_x - step); u <= std::min(by.width() - 1, from_x + step);
           u += next) {
        attempt(u, v, sampled);
      }
    }
  }
  best.circle = {double{1} * x, double{1} * y, 0.25 * ball_radius};
  double largest = 0;
  const double largest_circle = std::min(0.97 * ball_radius, most_radius);
  for (double r = 0.25 * ball_radius; r < largest_circle; r += 0.5) {
    const double here = mean_on_circle(by, {best.circle.x, best.circle.y, r});
    if (here <= largest) continue;
    largest = here;
    best.circle.radius = r;
  }
  double fallen = best.circle.radius;
  while (fallen < largest_circle &&
         mean_on_circle(by, {best.circle.x, best.circle.y, fallen}) > 0.5 * largest) {
    fallen += 0.5;
  }
  best.circle.radius = 0.5 * (best.circle.radius + std::min(fallen, largest_circle));
  return best;
}

}  // namespace gelight::detail
