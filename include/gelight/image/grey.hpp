#pragma once

#include <cstdint>

#include "gelight/concepts/image.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// The luma 0.299 R + 0.587 G + 0.114 B of every pixel (ITU-R BT.601), rounded to 8 bits.
template <ImageOf<Rgb8> I>
[[nodiscard]] Image<std::uint8_t> grey(const I& image) {
  Image<std::uint8_t> result(static_cast<Index>(ImageTraits<I>::width(image)),
                             static_cast<Index>(ImageTraits<I>::height(image)));
  for (Index y = 0; y < result.height(); ++y) {
    for (Index x = 0; x < result.width(); ++x) {
      const Rgb8 rgb = ImageTraits<I>::pixel(image, x, y);
      // The weights in units of 2^-15.
      const int luma = 9798 * rgb[0] + 19235 * rgb[1] + 3735 * rgb[2];
      result(x, y) = static_cast<std::uint8_t>((luma + (1 << 14)) >> 15);
    }
  }
  return result;
}

}  // namespace gelight
