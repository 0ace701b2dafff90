#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/normal_rows.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// What the outermost pixels of an image have for a normal, where a 3 x 3 window lacks neighbours:
/// none (a zero vector), or that of the depth extrapolated linearly by one pixel, to no less than
/// half of the outermost depth.
enum class BorderNormals : std::uint8_t { none, extrapolated };

namespace detail {

template <std::floating_point T>
[[nodiscard]] std::vector<T> ray_columns(const Camera<T>& camera) {
  std::vector<T> columns;
  columns.reserve(static_cast<std::size_t>(camera.width));
  for (Index x = 0; x < camera.width; ++x) columns.push_back(camera.ray(static_cast<T>(x), 0).x());
  return columns;
}

}  // namespace detail

/// The unit normal of the surface at every pixel of a depth image, towards the camera: the cross
/// product of the point cloud's 3 x 3 Sobel derivatives.
///
/// Zero where no surface is seen at a pixel of the 3 x 3 window (image/mask.hpp tells what depths
/// mean), and on the outermost pixels unless they are extrapolated. Depths may be of any size: only
/// their proportions count. Throws InvalidInput for a camera that is not valid or a depth image of
/// another size. About 60 floating-point operations a pixel, more where their squares leave the
/// range of T.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] Image<Vec3<T>> sobel_normals(const I& depth, const Camera<T>& camera,
                                           BorderNormals border = BorderNormals::none) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  const Index width = camera.width, height = camera.height;
  const std::ptrdiff_t stride = width + 2;
  detail::Array<T> padded(static_cast<std::size_t>(stride * (height + 2)));
  const auto row = [&](Index y) { return padded.data() + (y + 1) * stride + 1; };
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      row(y)[x] = detail::surface_or_nan(static_cast<T>(ImageTraits<I>::pixel(depth, x, y)));
    }
    detail::extrapolate_ends(row(y), width);
  }
  const Index last = height - 1;
  detail::extrapolate_row(row(-1), row(0), row(std::min(1, last)), width);
  detail::extrapolate_row(row(height), row(last), row(std::max(0, last - 1)), width);

  const auto window = [&](Index x, Index y) {
    std::array<T, 9> depths;
    for (Index i = 0; i < 9; ++i)
      depths[static_cast<std::size_t>(i)] = row(y + i / 3 - 1)[x + i % 3 - 1];
    return depths;
  };
  Image<Vec3<T>> normals(width, height, Vec3<T>(0, 0, 0));
  const std::vector<T> columns = detail::ray_columns(camera);
  detail::Array<T> planes(static_cast<std::size_t>(5 * width));
  T* const p = planes.data();
  const detail::VectorRow<T> n{p, p + width, p + 2 * width};
  const Index rim = border == BorderNormals::none ? 1 : 0;
  for (Index y = rim; y < height - rim; ++y) {
    const detail::RayRow<T> ray{columns.data(), nullptr, camera.ray(0, static_cast<T>(y)).y()};
    detail::sobel_product_row(n.x, n.y, n.z, p + 3 * width, p + 4 * width, row(y - 1), row(y),
                              row(y + 1), camera.fx, camera.fy, width);
    detail::unit_normal_row(n.x, n.y, n.z, ray, width);
    for (Index x = rim; x < width - rim; ++x) {
      const Vec3<T> normal(n.x[x], n.y[x], n.z[x]);
      // The pixel's own depth does not enter its derivatives.
      const bool is_unit = std::abs(squared_norm(normal) - 1) <= T(detail::unit_by_inverse_sqrt);
      if (is_unit && std::isfinite(row(y)[x])) {
        normals(x, y) = normal;
      } else if (std::isfinite(row(y)[x])) {
        normals(x, y) = detail::sobel_normal(window(x, y), camera.fx, camera.fy,
                                             columns[static_cast<std::size_t>(x)], ray.v);
      }
    }
  }
  return normals;
}

/// The unit normal of the surface at every pixel from central differences of its four neighbours'
/// points, towards the camera: sharper than `sobel_normals`, and more shaken by noise.
///
/// Zero on the outermost pixels and where no surface is seen at one of the five. Throws
/// InvalidInput as sobel_normals does.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] Image<Vec3<T>> central_normals(const I& depth, const Camera<T>& camera) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  Image<Vec3<T>> normals(camera.width, camera.height);
  for (Index y = 1; y < camera.height - 1; ++y) {
    for (Index x = 1; x < camera.width - 1; ++x) {
      const auto z = [&](Index dx, Index dy) {
        const T depth_there = static_cast<T>(ImageTraits<I>::pixel(depth, x + dx, y + dy));
        return detail::surface_or_nan(depth_there);
      };
      // The product of the two differences, each a multiple of the ray and of one axis, over the
      // product of the two sums, which is positive: so that depths of any size do.
      const Vec3<T> ray = camera.ray(static_cast<T>(x), static_cast<T>(y));
      const T across = (z(1, 0) - z(-1, 0)) / (z(1, 0) + z(-1, 0));
      const T down = (z(0, 1) - z(0, -1)) / (z(0, 1) + z(0, -1));
      const T nx = camera.fx * across, ny = camera.fy * down;
      const Vec3<T> n(nx, ny, -1 - ray.x() * nx - ray.y() * ny);
      if (detail::is_finite(n) && std::isfinite(z(0, 0))) normals(x, y) = detail::stable_unit(n);
    }
  }
  return normals;
}

}  // namespace gelight
