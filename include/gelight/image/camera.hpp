#pragma once

#include <cmath>
#include <concepts>
#include <numbers>
#include <type_traits>
#include <utility>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A pinhole camera: x to the right, y down, z forward; depth is z, not the length of the ray.
/// The centre of pixel (u, v) is at (u, v), so the middle of the image is ((width - 1) / 2, ...).
template <std::floating_point T>
struct Camera {
  T fx = 0;          ///< focal length across, in pixels
  T fy = 0;          ///< focal length down, in pixels
  T cx = 0;          ///< column where the optical axis meets the image
  T cy = 0;          ///< row where the optical axis meets the image
  Index width = 0;   ///< of the image, in pixels
  Index height = 0;  ///< of the image, in pixels

  /// A camera with square pixels that looks through the middle of the image; the angle between its
  /// top and bottom edges is in radians. Throws InvalidInput for an angle outside (0, pi) and for a
  /// size that is not positive.
  [[nodiscard]] static Camera from_vertical_fov(std::type_identity_t<T> fov, Index width,
                                                Index height) {
    detail::require(fov > 0 && fov < std::numbers::pi_v<T>, "a field of view of ", fov,
                    " radians is not between 0 and pi");
    const T f = static_cast<T>(height) / (2 * std::tan(fov / 2));
    const Camera camera{f,     f,     static_cast<T>(width - 1) / 2, static_cast<T>(height - 1) / 2,
                        width, height};
    camera.require_valid();
    return camera;
  }

  /// The point of depth 1 that pixel (u, v) sees.
  [[nodiscard]] Vec3<T> ray(T u, T v) const { return {(u - cx) / fx, (v - cy) / fy, 1}; }

  /// The point that pixel (u, v) sees at a depth, in the unit of the depth.
  [[nodiscard]] Vec3<T> unproject(T u, T v, T depth) const {
    using namespace detail::arithmetic;
    return depth * ray(u, v);
  }

  /// The pixel where a point with z > 0 appears.
  [[nodiscard]] Vec2<T> project(const Vec3<T>& point) const {
    return {fx * point.x() / point.z() + cx, fy * point.y() / point.z() + cy};
  }

  /// The same camera in another floating-point type.
  template <std::floating_point U>
  [[nodiscard]] Camera<U> cast() const {
    return {static_cast<U>(fx),
            static_cast<U>(fy),
            static_cast<U>(cx),
            static_cast<U>(cy),
            width,
            height};
  }

  /// Throws InvalidInput for a size that is not positive, a focal length that is not positive and
  /// finite, or a centre that is not finite or so many focal lengths off that a pixel's ray is not.
  void require_valid() const {
    detail::require(width > 0 && height > 0, "the camera's image size ", width, " x ", height,
                    " is not positive");
    detail::require(fx > 0 && fy > 0 && std::isfinite(fx) && std::isfinite(fy),
                    "the camera's focal lengths (", fx, ", ", fy, ") are not positive and finite");
    detail::require(std::isfinite(cx) && std::isfinite(cy), "the camera's centre (", cx, ", ", cy,
                    ") is not finite");
    // Each coordinate of a ray is largest on the first or the last column or row.
    for (const auto& [u, v] : {std::pair{Index{0}, Index{0}}, {width - 1, height - 1}}) {
      const Vec3<T> seen = ray(static_cast<T>(u), static_cast<T>(v));
      detail::require(detail::is_finite(seen), "the camera's ray through pixel (", u, ", ", v,
                      ") is (", seen.x(), ", ", seen.y(), ", 1), not finite");
    }
  }
};

namespace detail {

/// Throws InvalidInput unless an image has the camera's size; `what` names the image.
template <ImageLike I, std::floating_point T>
void require_camera_size(const I& image, const Camera<T>& camera, const char* what) {
  const auto width = ImageTraits<I>::width(image);
  const auto height = ImageTraits<I>::height(image);
  require(width == camera.width && height == camera.height, what, " is ", width, " x ", height,
          " pixels, the camera's image ", camera.width, " x ", camera.height);
}

}  // namespace detail

/// The point that each pixel sees, in the unit of the depth; NaN where none is seen (image/mask.hpp
/// tells what depths mean). Throws InvalidInput for a camera that is not valid or a depth image of
/// another size.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] Image<Vec3<T>> unproject(const I& depth, const Camera<T>& camera) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  Image<Vec3<T>> points(camera.width, camera.height);
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) {
      const T z = static_cast<T>(ImageTraits<I>::pixel(depth, x, y));
      points(x, y) =
          camera.unproject(static_cast<T>(x), static_cast<T>(y), detail::surface_or_nan(z));
    }
  }
  return points;
}

}  // namespace gelight
