#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A circle in an image, in pixels.
struct Circle {
  double x = 0, y = 0;  ///< its centre
  double radius = 0;
};

namespace detail {

/// Where a ball may touch, and whether its rim stands out clearly.
struct CircleProposal {
  Circle circle;
  bool is_sharp = false;
};

/// How much a photograph differs from its background: the sum of the channels' absolute
/// differences, each less its median over the image (the camera's level).
[[nodiscard]] inline Image<double> changed_amount(const Image<Rgb8>& background,
                                                  const Image<Rgb8>& photograph) {
  Image<double> amount(background.width(), background.height());
  const std::size_t count = amount.pixels().size();
  for (std::size_t c = 0; c < 3; ++c) {
    std::array<std::size_t, 511> counts{};
    for (std::size_t i = 0; i < count; ++i) {
      ++counts[static_cast<std::size_t>(255 + photograph.pixels()[i][c] -
                                        background.pixels()[i][c])];
    }
    int median = 0;
    for (std::size_t below = counts[0]; below * 2 < count;
         below += counts[static_cast<std::size_t>(++median)]) {
    }
    for (std::size_t i = 0; i < count; ++i) {
      amount.pixels()[i] +=
          std::abs(255 + photograph.pixels()[i][c] - background.pixels()[i][c] - median);
    }
  }
  return amount;
}

/// The mean amount on a circle, or a negative number where most of it lies outside of the image.
[[nodiscard]] inline double mean_on_circle(const Image<double>& amount, const Circle& circle) {
  constexpr int points = 48;
  double sum = 0;
  int inside = 0;
  for (int k = 0; k < points; ++k) {
    const double angle = 2 * std::numbers::pi * k / points;
    const auto x = static_cast<Index>(std::lround(circle.x + circle.radius * std::cos(angle)));
    const auto y = static_cast<Index>(std::lround(circle.y + circle.radius * std::sin(angle)));
    if (x < 0 || y < 0 || x >= amount.width() || y >= amount.height()) continue;
    sum += amount(x, y);
    ++inside;
  }
  return 2 * inside < points ? -1 : sum / inside;
}

/// How steeply the change falls across a circle.
[[nodiscard]] inline double fall_across(const Image<double>& amount, const Circle& circle) {
  double inner = 0, outer = 0;
  for (const double share : {0.75, 0.85, 0.95}) {
    const double in = mean_on_circle(amount, {circle.x, circle.y, share * circle.radius});
    const double out = mean_on_circle(amount, {circle.x, circle.y, (2.05 - share) * circle.radius});
    if (in < 0 || out < 0) return -1;
    inner += in;
    outer += out;
  }
  return inner - outer;
}

/// Searches for the circle across which the change falls the steepest: coarsely over the image and
/// the radii that the ball allows, then ever finer.
[[nodiscard]] inline CircleProposal propose_circle(const Image<Rgb8>& background,
                                                   const Image<Rgb8>& photograph,
                                                   double ball_radius) {
  const Image<double> amount = changed_amount(background, photograph);
  const double coarse = std::max(1.0, ball_radius / 10);
  CircleProposal best;
  double steepest = 0, sum = 0, squares = 0, tried = 0;
  for (double radius = 0.25 * ball_radius; radius < 0.97 * ball_radius; radius *= 1.12) {
    for (double y = 0; y < amount.height(); y += coarse) {
      for (double x = 0; x < amount.width(); x += coarse) {
        const double fall = fall_across(amount, {x, y, radius});
        sum += fall;
        squares += fall * fall;
        ++tried;
        if (fall <= steepest) continue;
        steepest = fall;
        best.circle = {x, y, radius};
      }
    }
  }
  for (double step = coarse / 2; step > 0.2; step /= 2) {
    for (bool moved = true; moved;) {
      moved = false;
      const Circle from = best.circle;
      for (const Circle& by : {Circle{step, 0, 0}, Circle{-step, 0, 0}, Circle{0, step, 0},
                               Circle{0, -step, 0}, Circle{0, 0, step}, Circle{0, 0, -step}}) {
        const Circle next{from.x + by.x, from.y + by.y,
                          std::min(from.radius + by.radius, 0.97 * ball_radius)};
        const double fall = fall_across(amount, next);
        if (fall <= steepest) continue;
        steepest = fall;
        best.circle = next;
        moved = true;
      }
    }
  }
  const double mean = sum / std::max(1.0, tried);
  const double deviation = std::sqrt(std::max(0.0, squares / std::max(1.0, tried) - mean * mean));
  best.is_sharp = steepest > mean + 6 * deviation;
  return best;
}

}  // namespace detail
}  // namespace gelight
