#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Modified Bessel functions K0 and K1 times exp(x), x > 0, by the trapezoidal rule on
/// K_n(x) = integral over t >= 0 of exp(-x cosh t) cosh(n t), which converges geometrically.
struct ScaledBessel {
  double k0, k1;
};
[[nodiscard]] inline ScaledBessel scaled_bessel_k(double x) {
  constexpr double step = 0.1;
  ScaledBessel sum{0.5, 0.5};
  for (int i = 1; i < 400; ++i) {
    const double c = std::cosh(step * i), w = std::exp(-x * (c - 1));
    sum.k0 += w;
    sum.k1 += w * c;
    if (w * c < 1e-17 * sum.k1) break;
  }
  return {step * sum.k0, step * sum.k1};
}

/// The longest bulge, in pixels: more than any image is wide.
inline constexpr double longest_bulge = 1e4;

/// The slope of a ball at the circle in which it touches the gel. Throws InvalidInput for a circle
/// that is none of the ball's.
[[nodiscard]] inline double slope_at_rim(double contact_radius, double ball_radius) {
  require(contact_radius >= 0 && contact_radius < ball_radius && std::isfinite(ball_radius),
          "a ball of radius ", ball_radius, " touches in a circle of radius ", contact_radius);
  // The difference of their squares, which is not zero.
  return contact_radius /
         std::sqrt((ball_radius - contact_radius) * (ball_radius + contact_radius));
}
inline void require_bulge(double length) {
  require(length >= 0 && length <= longest_bulge, "a bulge of ", length, " pixels, not from 0 to ",
          longest_bulge);
}

/// The gel's surface about a rigid ball that touches it in a circle: inside of it the ball, outside
/// a membrane under tension on an elastic foundation, whose slope goes on at the rim and decays as
/// the Bessel function K1 over a length (pixels; 0: flat). All in pixels. Made for points no
/// farther from the circle's centre than `farthest`, in time in proportion to that. Throws
/// InvalidInput for a circle that is none of the ball's, and a length that is negative or above
/// longest_bulge.
class BallSurface {
 public:
  BallSurface(double contact_radius, double ball_radius, double length, double farthest)
      : contact_(contact_radius), ball_(ball_radius) {
    const double rim = slope_at_rim(contact_, ball_);
    require_bulge(length);
    if (length == 0) return;
    const double at_rim = scaled_bessel_k(contact_ / length).k1;
    // Until a slope of a thousandth is left: after a steep rim and over a long bulge that is far
    // beyond any image.
    const double last = (farthest - contact_) * per_pixel + 2;
    for (int i = 0; i <= last; ++i) {
      const double out = i / per_pixel, t = (contact_ + out) / length;
      const double slope = rim * scaled_bessel_k(t).k1 / at_rim * std::exp(-out / length);
      tilt_.push_back(slope / std::sqrt(1 + slope * slope));
      if (!(slope >= 1e-3)) break;
    }
  }

  /// Where the surface is flat again, from the circle's centre, or farther than it is made for.
  [[nodiscard]] double reach() const {
    return contact_ + static_cast<double>(tilt_.size()) / per_pixel;
  }

  /// The normal's coordinates along the image, so far from the circle's centre.
  [[nodiscard]] Vec2<double> normal(double dx, double dy) const {
    const double r = std::sqrt(dx * dx + dy * dy);
    if (r <= contact_) return {dx / ball_, dy / ball_};
    const double at = (r - contact_) * per_pixel;
    if (!(at + 1 < static_cast<double>(tilt_.size()))) return {0, 0};  // too far for an index, too
    const auto i = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(i);
    const double tilt = (1 - share) * tilt_[i] + share * tilt_[i + 1];
    return {tilt * dx / r, tilt * dy / r};
  }

 private:
  static constexpr double per_pixel = 2;
  double contact_, ball_;
  std::vector<double> tilt_;  // the normal's coordinate away from the centre, from the rim outwards
};

}  // namespace gelight::detail
