#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

// What a depth means, in every function that takes a depth image:
//
//     positive and finite      a surface is seen there
//     +infinity                nothing is there: what it would touch is as at rest
//     NaN, zero, negative      not known: the pixel stays so, and nothing around it counts it
//
// Of a membrane's own depth at rest, where there is nothing or nothing known is no membrane.
//
// The filters of filter.hpp, smooth.hpp and fast_gaussian.hpp take any numbers, and know nothing of
// this. To them NaN and the infinities are values: each makes what it has weight in NaN or
// infinite, and no other pixel (by gaussian_recursive, which has no end, whole rows and columns).
// `gaussian_of_known` alone leaves them out.
namespace gelight {
namespace detail {

/// Whether a depth is that of a surface.
template <std::floating_point T>
[[nodiscard]] bool is_depth(T z) {
  return z > 0 && z <= std::numeric_limits<T>::max();
}

/// Whether it is known what is there: a surface or nothing.
template <std::floating_point T>
[[nodiscard]] bool is_known(T z) {
  return z > 0;
}

/// The depth of a surface, NaN for what is none.
template <std::floating_point T>
[[nodiscard]] T surface_or_nan(T z) {
  return is_depth(z) ? z : std::numeric_limits<T>::quiet_NaN();
}

}  // namespace detail

/// A depth image that is not known (NaN) beyond a circle, as where a round window ends. Centre and
/// radius in pixels; pixels whose centres lie on the circle are kept. Throws InvalidInput for a
/// radius that is negative or NaN and a centre that is not finite.
template <ImageLike I>
requires std::floating_point<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> circular_mask(const I& depth, double cx, double cy,
                                                 double radius) {
  detail::require(radius >= 0, "radius ", radius, " is negative");
  detail::require(std::isfinite(cx) && std::isfinite(cy), "the circle's centre (", cx, ", ", cy,
                  ") is not finite");
  using T = ImagePixel<I>;
  Image<T> masked(static_cast<Index>(ImageTraits<I>::width(depth)),
                  static_cast<Index>(ImageTraits<I>::height(depth)));
  for (Index y = 0; y < masked.height(); ++y) {
    for (Index x = 0; x < masked.width(); ++x) {
      // By no square, which of a circle far off would be infinite as that of its radius is.
      masked(x, y) = std::hypot(x - cx, y - cy) <= radius ? ImageTraits<I>::pixel(depth, x, y)
                                                          : std::numeric_limits<T>::quiet_NaN();
    }
  }
  return masked;
}

}  // namespace gelight
