#pragma once

#include <algorithm>
#include <concepts>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/views/image_view.hpp"

// The GelTip's membrane as one function of whole images, of any type.
namespace gelight {

namespace detail {

template <ImageLike D, ImageLike R>
[[nodiscard]] Image<ImagePixel<R>> protrusion(const D& depth, const R& rest) {
  using T = ImagePixel<R>;
  require_same_size(depth, rest, "the depth image", "the rest depth image");
  Image<T> out(static_cast<Index>(ImageTraits<R>::width(rest)),
               static_cast<Index>(ImageTraits<R>::height(rest)));
  for (Index y = 0; y < out.height(); ++y) {
    for (Index x = 0; x < out.width(); ++x) {
      out(x, y) = protrusion<T>(static_cast<T>(ImageTraits<D>::pixel(depth, x, y)),
                                ImageTraits<R>::pixel(rest, x, y));
    }
  }
  return out;
}

}  // namespace detail

/// The depth of an elastic membrane that something is pressed into: min(depth, rest - G(rest -
/// depth)), with a Gaussian G cut off beyond `radius` pixels and the image reflected without
/// repeating its edge. Depths in one unit, of the size of `rest`; what lies deeper than `rest` does
/// not touch it. Depths mean what image/mask.hpp says: where one is not known, or there is no
/// membrane at rest, the result is NaN, and the Gaussian averages over the others.
///
/// Throws InvalidInput for images of different sizes, and as gaussian_weights does. (Gomes,
/// Paoletti, Luo 2023, doi:10.15607/RSS.2023.XIX.035)
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<ImagePixel<R>> elastic_depth(const D& depth, const R& rest, double sigma = 5,
                                                 Index radius = 20) {
  using T = ImagePixel<R>;
  Image<T> result = gaussian_of_known(detail::protrusion(depth, rest), sigma, radius);
  for (Index y = 0; y < result.height(); ++y) {
    for (Index x = 0; x < result.width(); ++x) {
      const T at_rest = ImageTraits<R>::pixel(rest, x, y);
      const T contact = std::min(at_rest, static_cast<T>(ImageTraits<D>::pixel(depth, x, y)));
      const T bulged = at_rest - result(x, y);
      result(x, y) = contact < bulged ? contact : bulged;  // NaN, where that is
    }
  }
  return result;
}

}  // namespace gelight
