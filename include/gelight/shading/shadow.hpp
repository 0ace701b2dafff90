#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/views/image_view.hpp"

// What an object takes away of the light inside a sensor, after the GelTip authors' later code.
namespace gelight {

/// The share of the ambient light that the pressed gel loses at every pixel: `strength` where the
/// object is pressed in by `full_depth` or more, less in proportion, none where nothing touches, a
/// depth is not known or there is no membrane (image/mask.hpp tells what depths mean).
///
/// Depths and `full_depth` in one unit. Throws InvalidInput for images of different sizes, a
/// strength outside [0, 1] and a full depth that is not positive.
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> penetration_darkening(const D& depth, const R& rest,
                                                      double strength = 0.15,
                                                      double full_depth = 0.03) {
  using T = PixelOf<R>;
  detail::require_same_size(depth, rest, "the depth image", "the rest depth image");
  detail::require(strength >= 0 && strength <= 1, "darkening ", strength, " is not in [0, 1]");
  detail::require(full_depth > 0, "full depth ", full_depth, " is not positive");
  Image<T> darkening(static_cast<Index>(ImageTraits<R>::width(rest)),
                     static_cast<Index>(ImageTraits<R>::height(rest)));
  const T slope = static_cast<T>(strength / full_depth);
  for (Index y = 0; y < darkening.height(); ++y) {
    for (Index x = 0; x < darkening.width(); ++x) {
      const T z = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      const T at_rest = ImageTraits<R>::pixel(rest, x, y);
      if (detail::is_known(z) && detail::is_depth(at_rest) && at_rest > z)
        darkening(x, y) = std::min(static_cast<T>(strength), slope * (at_rest - z));
    }
  }
  return darkening;
}

/// How a contact's shadow is cast.
struct ContactShadow {
  double contact = 1e-5;  ///< how far an object is pressed in to count, in the unit of the depth
  double sigma = 5;       ///< how soft the shadow is, in pixels
  Index radius = 27;      ///< where the softening is cut off, in pixels
  Index gap = 3;          ///< how far around the object there is none, in pixels
};

namespace detail {

/// Whether any pixel of a (2 radius + 1)^2 window is marked.
[[nodiscard]] inline Image<float> dilate(const Image<float>& marks, Index radius) {
  Image<float> rows = marks, result = marks;
  for (Index y = 0; y < marks.height(); ++y) {
    for (Index x = 0; x < marks.width(); ++x) {
      for (Index k = -radius; k <= radius; ++k) {
        const Index from = x + k;
        if (from >= 0 && from < marks.width()) rows(x, y) = std::max(rows(x, y), marks(from, y));
      }
    }
  }
  for (Index y = 0; y < marks.height(); ++y) {
    for (Index x = 0; x < marks.width(); ++x) {
      for (Index k = -radius; k <= radius; ++k) {
        const Index from = y + k;
        if (from >= 0 && from < marks.height())
          result(x, y) = std::max(result(x, y), rows(x, from));
      }
    }
  }
  return result;
}

}  // namespace detail

/// How much of a membrane's bulge the object hides from a camera inside, from 0 to 1 at every
/// pixel: soft bands along the edges of the contact where it falls off the way that the ray runs.
/// The bulge is to be multiplied by what is left. 0 everywhere where nothing touches.
///
/// Depths in one unit; they mean what image/mask.hpp says, and what is not known does not touch.
/// Throws InvalidInput for images of another size than the camera's, a camera that is not valid,
/// and as gaussian does.
template <std::floating_point T, ImageOf<T> D, ImageOf<T> R>
[[nodiscard]] Image<float> contact_shadow(const D& depth, const R& rest, const Camera<T>& camera,
                                          const ContactShadow& options = {}) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  detail::require_camera_size(rest, camera, "the rest depth image");
  detail::require(options.gap >= 0, "gap ", options.gap, " is negative");
  detail::require(std::isfinite(options.contact), "contact ", options.contact, " is not finite");
  const Index width = camera.width, height = camera.height;
  Image<float> touching(width, height), hidden(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T z = static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      const T at_rest = static_cast<T>(ImageTraits<R>::pixel(rest, x, y));
      const bool is_pressed = at_rest - z > static_cast<T>(options.contact);
      touching(x, y) = is_pressed && detail::is_known(z) && detail::is_depth(at_rest) ? 1 : 0;
    }
  }
  const auto slope = sobel(touching);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const Vec3<T> ray = camera.ray(static_cast<T>(x), static_cast<T>(y));
      const bool along_x = static_cast<T>(slope.x(x, y)) * ray.x() > 0;
      const bool along_y = static_cast<T>(slope.y(x, y)) * ray.y() > 0;
      hidden(x, y) = along_x || along_y ? 1 : 0;
    }
  }
  Image<float> shadow = gaussian(detail::dilate(hidden, 1), options.sigma, options.radius);
  const auto [least, most] = std::minmax_element(shadow.pixels().begin(), shadow.pixels().end());
  const float low = *least, range = *most - *least;
  const auto around = detail::dilate(touching, options.gap);
  for (std::size_t i = 0; i < shadow.pixels().size(); ++i) {
    float& value = shadow.pixels()[i];
    value = range > 0 && around.pixels()[i] == 0 ? (value - low) / range : 0;
  }
  return shadow;
}

}  // namespace gelight
