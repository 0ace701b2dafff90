#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/plane_fit_rows.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// The largest depth at which the points that a camera's pixels see have squares that are numbers.
template <std::floating_point T>
[[nodiscard]] double most_fitted(const Camera<T>& camera) {
  const auto eye = camera.template cast<double>();
  double longest = 1;  // of the rays' coordinates
  for (const auto& ray : {eye.ray(0, 0), eye.ray(camera.width - 1, camera.height - 1)}) {
    longest = std::max(longest, largest_part(ray));
  }
  return most_fitted_depth / longest;
}

/// Throws InvalidInput for a surface whose distances' squares leave the range of numbers; `most` is
/// the largest depth at which they do not.
template <class T>
void require_fitted_depth(T z, Index x, Index y, double most) {
  const bool is_in_range = double{z} >= least_fitted_depth && double{z} <= most;
  require(!is_depth(z) || is_in_range, "the depth ", z, " at pixel (", x, ", ", y,
          ") is not between ", least_fitted_depth, " and ", most);
}

template <class T, class I>
void fit_planes(Image<Vec3<T>>& normals, const I& depth, const Camera<T>& camera, Index radius) {
  const Index width = camera.width, height = camera.height;
  PlaneFitRows<T> rows(camera, radius);
  const Index reach = rows.radius();
  // The rows of a window, which is also the one whose normals are asked for.
  Image<T> depths(width, 2 * reach + 1);
  std::vector<T> planes(4 * static_cast<std::size_t>(width));
  T* const p = planes.data();
  const DirectionRow<T> n{p, p + width, p + 2 * width, p + 3 * width};
  rows.start(0, width);
  for (Index y = 0; y < height + reach; ++y) {
    T* const row = depths.row(y % depths.height());
    for (Index x = 0; x < width && y < height; ++x) {
      row[x] = surface_or_nan(static_cast<T>(ImageTraits<I>::pixel(depth, x, y)));
    }
    rows.enter(y < height ? row : nullptr, y);
    if (y < reach) continue;
    const Index middle = y - reach;
    rows.fit(n, middle);
    const T* const own = depths.row(middle % depths.height());
    for (Index x = 0; x < width; ++x) {
      if (std::isfinite(own[x])) normals(x, middle) = {n.x[x], n.y[x], n.z[x]};
    }
  }
}

}  // namespace detail

/// The normal of the plane that fits the points of a (2 radius + 1)^2 window best, towards the
/// camera: the direction of least variance of their covariance, as in the STS sensor's simulator.
///
/// Zero where no surface is seen (image/mask.hpp tells what depths mean), or only at pixels of the
/// window that lie on a line of the image: the plane through these is seen edge-on, and has no side
/// towards the camera. Other pixels without a surface are left out, as is what lies outside the
/// image. Where noise makes the plane of least variance one that is seen edge-on but for half a
/// degree, the normal leaves its direction for one that still faces the camera, so that it is a
/// continuous function of the depths. Works in double whatever T is, on depths of any unit; the
/// cost grows with the logarithm of the radius. Throws InvalidInput for a camera that is not valid,
/// a depth image of another size, a radius below 1 and a depth that is not from 1e-140 to 1e140, or
/// at which a pixel sees a point farther beside the axis than that.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] Image<Vec3<T>> plane_fit_normals(const I& depth, const Camera<T>& camera,
                                               Index radius) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  detail::require(radius >= 1, "a window of radius ", radius, " has no neighbours");
  if constexpr (sizeof(T) > 4) {
    const double most = detail::most_fitted(camera);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        detail::require_fitted_depth(static_cast<T>(ImageTraits<I>::pixel(depth, x, y)), x, y,
                                     most);
      }
    }
  }
  Image<Vec3<T>> normals(camera.width, camera.height);
  detail::vectorised([&] { detail::fit_planes(normals, depth, camera, radius); });
  return normals;
}

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template Image<Vec3<float>> plane_fit_normals<float>(const Image<float>&,
                                                                  const Camera<float>&, Index);
GELIGHT_ONCE template Image<Vec3<double>> plane_fit_normals<double>(const Image<double>&,
                                                                    const Camera<double>&, Index);
}  // namespace gelight
#endif
