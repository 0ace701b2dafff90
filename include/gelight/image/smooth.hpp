#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// Correlates an image with a kernel along its rows and then its columns: each pixel becomes the
/// sum of kernel[j] times the pixel j - anchor away. Throws InvalidInput for an anchor outside the
/// kernel and for a normalised border. 2 kernel.size() multiply-adds a pixel.
template <std::floating_point T, ImageOf<T> I>
[[nodiscard]] Image<T> correlate(const I& image, std::span<const T> kernel, Index anchor,
                                 Border border = Border::reflect101) {
  const Index taps = static_cast<Index>(kernel.size());
  detail::require(anchor >= 0 && anchor < taps, "anchor ", anchor, " is not in a kernel of ", taps,
                  " numbers");
  detail::require(border != Border::normalised, "correlation has no normalised border");
  const Index width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index height = static_cast<Index>(ImageTraits<I>::height(image));
  Image<T> rows(width, height), result(width, height);
  if (width == 0) return result;
  std::vector<T> padded(static_cast<std::size_t>(width + taps));
  for (Index y = 0; y < height; ++y) {
    for (Index x = -anchor; x < width + taps - 1 - anchor; ++x) {
      const Index from = detail::inside(x, width, border);
      padded[static_cast<std::size_t>(std::ptrdiff_t{x} + anchor)] =
          from < 0 ? T(0) : static_cast<T>(ImageTraits<I>::pixel(image, from, y));
    }
    for (Index j = 0; j < taps; ++j) {
      detail::add_scaled(rows.row(y), padded.data() + j, kernel[static_cast<std::size_t>(j)],
                         width);
    }
  }
  for (Index y = 0; y < height; ++y) {
    for (Index j = 0; j < taps; ++j) {
      const Index from = detail::inside(y + j - anchor, height, border);
      if (from < 0) continue;
      detail::add_scaled(result.row(y), std::as_const(rows).row(from),
                         kernel[static_cast<std::size_t>(j)], width);
    }
  }
  return result;
}

/// The mean of the known pixels around each pixel, weighted by a Gaussian (normalised convolution).
/// Pixels that are NaN or infinite are left out, and stay what they are. Where there are none it is
/// `gaussian`. Numbers of either sign count: of a depth image make NaN what is not known, see
/// image/mask.hpp. Throws as gaussian_weights does. (Knutsson, Westin, Normalized and differential
/// convolution, 1993, doi:10.1109/CVPR.1993.341081)
template <ImageLike I>
requires std::floating_point<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> gaussian_of_known(const I& image, double sigma, Index radius,
                                                     Border border = Border::reflect101) {
  using T = ImagePixel<I>;
  const Index width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index height = static_cast<Index>(ImageTraits<I>::height(image));
  Image<T> values(width, height);
  // In double: of 1 less the share that is missing little may be left.
  Image<double> missing(width, height);
  bool any_missing = false;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T value = ImageTraits<I>::pixel(image, x, y);
      const bool known = std::isfinite(value);
      values(x, y) = known ? value : T(0);
      missing(x, y) = known ? 0 : 1;
      any_missing = any_missing || !known;
    }
  }
  Image<T> mean = gaussian(values, sigma, radius, border);
  if (!any_missing) return mean;
  // The share that is missing, not the one that is there: it is exactly 0 where all is known.
  const Image<double> lack = gaussian(missing, sigma, radius, border);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if (lack(x, y) > 0) mean(x, y) = static_cast<T>(double{mean(x, y)} / (1 - lack(x, y)));
      if (missing(x, y) != 0) mean(x, y) = ImageTraits<I>::pixel(image, x, y);
    }
  }
  return mean;
}

}  // namespace gelight
