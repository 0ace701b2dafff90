#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"

namespace gelight::detail {

/// A membrane's surface comes no nearer to the camera than this share of its rest depth, far beyond
/// what any gel bears. So what a membrane model rounds by stays small beside the depth, and the
/// depths that a normal is made of are no farther apart than normals bear.
inline constexpr double nearest_share = 0x1p-7;

/// A surface's depth that is no nearer; NaN stays.
template <class T>
[[nodiscard]] T not_too_near(T surface, T rest) {
  const T nearest = static_cast<T>(nearest_share) * rest;
  return surface < nearest ? nearest : surface;
}

/// Rest depths of which normals can be computed, and the largest depth of a surface.
template <std::floating_point T>
struct DepthRange {
  T least, most;

  /// With f the focal length, r the longest ray and z a depth, what a normal is made of is no
  /// shorter than 64 z^2 / r, and no longer than 120 f r z^2. Their squares must be numbers.
  explicit DepthRange(const Camera<T>& camera) {
    double longest = 0;
    for (const Index y : {Index{0}, camera.height - 1}) {
      for (const Index x : {Index{0}, camera.width - 1}) {
        const double u = (double{static_cast<T>(x)} - double{camera.cx}) / double{camera.fx};
        const double v = (double{static_cast<T>(y)} - double{camera.cy}) / double{camera.fy};
        longest = std::max(longest, std::hypot(u, v, 1.0));
      }
    }
    const double focal = std::max({1.0, double{camera.fx}, double{camera.fy}});
    const double smallest = std::sqrt(double{std::numeric_limits<T>::min()}),
                 largest = std::sqrt(double{std::numeric_limits<T>::max()});
    least = static_cast<T>(std::sqrt(smallest * longest) / (8 * nearest_share));
    most = static_cast<T>(std::sqrt(largest / (120 * focal * longest)));
  }
};

}  // namespace gelight::detail
