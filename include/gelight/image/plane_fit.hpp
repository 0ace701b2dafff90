#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// What is summed up over a window of points: how many there are, their coordinates, and the
/// products of these.
struct Moments {
  std::array<double, 10> sums{};

  Moments() = default;
  explicit Moments(const Vec3<double>& p)
      : sums{1,
             p.x(),
             p.y(),
             p.z(),
             p.x() * p.x(),
             p.x() * p.y(),
             p.x() * p.z(),
             p.y() * p.y(),
             p.y() * p.z(),
             p.z() * p.z()} {}

  void operator+=(const Moments& other) {
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += other.sums[i];
  }
  void operator-=(const Moments& other) {
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] -= other.sums[i];
  }

  /// The unit vector along which the points spread least, or zero where they lie on a line.
  [[nodiscard]] Vec3<double> flattest_direction() const {
    const double n = sums[0];
    if (n < 3) return Vec3<double>::Zero();
    const Vec3<double> mean(sums[1] / n, sums[2] / n, sums[3] / n);
    Eigen::Matrix3d spread;
    spread << sums[4], sums[5], sums[6], sums[5], sums[7], sums[8], sums[6], sums[8], sums[9];
    spread = spread / n - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread / spread.trace());
    const auto& variance = solver.eigenvalues();
    // Of points on a line the share of the second variance is what the sums were rounded by.
    constexpr double negligible = 1e-10;
    if (!(variance[1] > negligible)) return Vec3<double>::Zero();
    return solver.eigenvectors().col(0);
  }
};

}  // namespace detail

/// The normal of the plane that fits the points of a (2 radius + 1)^2 window best, towards the
/// camera: the direction of least variance of their covariance, as in the STS sensor's simulator.
///
/// Zero where the pixel's own depth is not finite, or fewer than three points of the window are, or
/// they lie on a line; other depths that are not finite are left out, as is what lies outside the
/// image. The sums slide along, so that the cost does not depend on the radius. Throws InvalidInput
/// for a camera that is not valid, a depth image of another size and a radius below 1.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] Image<Vec3<T>> plane_fit_normals(const I& depth, const Camera<T>& camera,
                                               Index radius) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  detail::require(radius >= 1, "a window of radius ", radius, " has no neighbours");
  const Index width = camera.width, height = camera.height;
  const Camera<double> eye = camera.template cast<double>();
  const auto moments = [&](Index x, Index y) {
    const auto z = static_cast<double>(ImageTraits<I>::pixel(depth, x, y));
    return std::isfinite(z) ? detail::Moments(eye.unproject(x, y, z)) : detail::Moments();
  };
  std::vector<detail::Moments> columns(static_cast<std::size_t>(width));
  const auto slide_down = [&](Index y, auto&& change) {
    if (y < 0 || y >= height) return;
    for (Index x = 0; x < width; ++x) change(columns[static_cast<std::size_t>(x)], moments(x, y));
  };
  const auto add = [](detail::Moments& sum, const detail::Moments& m) { sum += m; };
  const auto take = [](detail::Moments& sum, const detail::Moments& m) { sum -= m; };

  Image<Vec3<T>> normals(width, height);
  for (Index y = 0; y < radius; ++y) slide_down(y, add);
  for (Index y = 0; y < height; ++y) {
    slide_down(y + radius, add);
    slide_down(y - radius - 1, take);
    detail::Moments window;
    for (Index x = 0; x < std::min(radius, width); ++x)
      window += columns[static_cast<std::size_t>(x)];
    for (Index x = 0; x < width; ++x) {
      if (x + radius < width) window += columns[static_cast<std::size_t>(x + radius)];
      if (x > radius) window -= columns[static_cast<std::size_t>(x - radius - 1)];
      const auto z = static_cast<double>(ImageTraits<I>::pixel(depth, x, y));
      if (!std::isfinite(z)) continue;
      const Vec3<double> n = window.flattest_direction();
      const bool away = n.dot(eye.ray(x, y)) > 0;
      normals(x, y) = (away ? Vec3<double>(-n) : n).template cast<T>();
    }
  }
  return normals;
}

}  // namespace gelight
