#pragma once

#include <concepts>
#include <limits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A depth image that is not known (NaN) beyond a circle, as where a round window ends. Centre and
/// radius in pixels; pixels whose centres lie on the circle are kept. Throws InvalidInput for a
/// radius that is negative or NaN.
template <ImageLike I>
requires std::floating_point<PixelOf<I>>
[[nodiscard]] Image<PixelOf<I>> circular_mask(const I& depth, double cx, double cy, double radius) {
  detail::require(radius >= 0, "radius ", radius, " is negative");
  using T = PixelOf<I>;
  Image<T> masked(static_cast<Index>(ImageTraits<I>::width(depth)),
                  static_cast<Index>(ImageTraits<I>::height(depth)));
  for (Index y = 0; y < masked.height(); ++y) {
    for (Index x = 0; x < masked.width(); ++x) {
      const double dx = x - cx, dy = y - cy;
      masked(x, y) = dx * dx + dy * dy <= radius * radius ? ImageTraits<I>::pixel(depth, x, y)
                                                          : std::numeric_limits<T>::quiet_NaN();
    }
  }
  return masked;
}

}  // namespace gelight
