#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/views/image_view.hpp"

// How the gel of published sensors bulges around what is pressed into it.
namespace gelight {

namespace detail {

template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> protrusion(const D& depth, const R& rest) {
  using T = PixelOf<R>;
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
/// Paoletti, Luo, Simulation of Curved GelSight Sensors for Sim2Real Learning)
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> elastic_depth(const D& depth, const R& rest, double sigma = 5,
                                              Index radius = 20) {
  using T = PixelOf<R>;
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

namespace detail {

/// The kernel that SciPy's Gaussian filter makes of a unit pulse in the middle of `size` numbers:
/// cut off at 4 sigma, and what leaves the array reflected back into it.
[[nodiscard]] inline std::vector<double> filtered_pulse(double sigma, Index size) {
  const Index radius = static_cast<Index>(std::floor(4 * sigma + 0.5));
  const auto weights = gaussian_weights<double>(sigma, radius);
  std::vector<double> kernel(static_cast<std::size_t>(size));
  for (Index i = 0; i < size; ++i) {
    for (Index k = -radius; k <= radius; ++k) {
      if (inside(i + k, size, Border::reflect) != size / 2) continue;
      kernel[static_cast<std::size_t>(i)] += weights[static_cast<std::size_t>(std::abs(k))];
    }
  }
  return kernel;
}

/// The largest number, 0 where none is above.
[[nodiscard]] inline double largest(const Image<double>& image) {
  double most = 0;
  for (const double value : image.pixels()) most = value > most ? value : most;
  return most;
}

/// The larger of the protrusion and its blurred self, scaled to the same height; NaN where the
/// protrusion is, which the blur leaves out.
[[nodiscard]] inline Image<double> spread_round(const Image<double>& spread,
                                                const Image<double>& protrusion,
                                                const std::vector<double>& kernel) {
  const auto anchor = static_cast<Index>(kernel.size() / 2);
  const double sum = std::accumulate(kernel.begin(), kernel.end(), 0.0);
  Image<double> known = spread, missing(spread.width(), spread.height());
  bool any_missing = false;
  for (std::size_t i = 0; i < known.pixels().size(); ++i) {
    if (!std::isnan(known.pixels()[i])) continue;
    known.pixels()[i] = 0;
    missing.pixels()[i] = 1 / (sum * sum);
    any_missing = true;
  }
  Image<double> next = correlate<double>(known, kernel, anchor);
  if (any_missing) {
    const Image<double> lack = correlate<double>(missing, kernel, anchor);
    for (std::size_t i = 0; i < next.pixels().size(); ++i) {
      if (missing.pixels()[i] == 0) next.pixels()[i] /= 1 - lack.pixels()[i];
    }
  }
  double highest = 0;
  for (std::size_t i = 0; i < next.pixels().size(); ++i) {
    if (missing.pixels()[i] == 0) highest = std::max(highest, next.pixels()[i]);
  }
  const double scale = highest > 0 ? largest(protrusion) / highest : 0;
  for (std::size_t i = 0; i < next.pixels().size(); ++i) {
    const double own = protrusion.pixels()[i];
    next.pixels()[i] = std::isnan(own) ? own : std::max(scale * next.pixels()[i], own);
  }
  return next;
}

}  // namespace detail

/// The membrane of the flat GelSight simulator that the GelTip's came from: twice a narrow spread
/// of the protrusion less a wide one, so that the gel sinks around the contact before it rises.
///
/// Depths in one unit, the gel's surface flat at `rest`. What lies deeper does not touch it, and
/// without contact the membrane is at rest. Depths mean what image/mask.hpp says: where one is not
/// known the membrane is NaN, and spreads from the others. Throws InvalidInput for a rest depth
/// that is not positive and finite. (Gomes, Wilson, Luo, GelSight Simulation for Sim2Real Learning,
/// 2019; the kernels of 21 and 52 pixels are those of its published code.) About 740 multiply-adds
/// a pixel.
template <ImageOf<double> I>
[[nodiscard]] Image<double> gelsight_flat_depth(const I& depth, double rest = 0.030) {
  detail::require(detail::is_depth(rest), "rest depth ", rest, " is not positive and finite");
  const Index width = static_cast<Index>(ImageTraits<I>::width(depth));
  const Index height = static_cast<Index>(ImageTraits<I>::height(depth));
  Image<double> protrusion(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      protrusion(x, y) =
          detail::protrusion<double>(static_cast<double>(ImageTraits<I>::pixel(depth, x, y)), rest);
    }
  }
  const auto narrow_kernel = detail::filtered_pulse(7, 21);
  const auto wide_kernel = detail::filtered_pulse(9, 52);
  Image<double> narrow = protrusion, wide = protrusion;
  for (int round = 0; round < 3; ++round) {
    narrow = detail::spread_round(narrow, protrusion, narrow_kernel);
    wide = detail::spread_round(wide, protrusion, wide_kernel);
  }
  for (int round = 0; round < 3; ++round) {
    wide = detail::spread_round(wide, protrusion, narrow_kernel);
  }
  Image<double> membrane(width, height);
  for (std::size_t i = 0; i < membrane.pixels().size(); ++i) {
    membrane.pixels()[i] = rest - (2 * narrow.pixels()[i] - wide.pixels()[i]);
  }
  return membrane;
}

/// The membrane of Taxim: the protrusion blurred by ever narrower Gaussians, and put back after
/// each wherever the object is. `sigmas` are in pixels, applied in their order, cut off at 4 sigma.
///
/// Depths in one unit; `depth` and `rest` of one size. Depths mean what image/mask.hpp says: where
/// one is not known, or there is no membrane at rest, the result is NaN, and the others are blurred
/// without it. Throws InvalidInput for images of different
/// sizes and as gaussian does. (Si, Yuan, Taxim: An Example-based Simulation Model for GelSight
/// Tactile Sensors, 2022, doi:10.1109/LRA.2022.3142412)
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> taxim_depth(const D& depth, const R& rest,
                                            std::span<const double> sigmas) {
  using T = PixelOf<R>;
  const Image<T> protrusion = detail::protrusion(depth, rest);
  Image<T> gel = protrusion;
  for (const double sigma : sigmas) {
    gel = gaussian_of_known(gel, sigma, gaussian_radius(sigma, gel.width(), gel.height()));
    for (std::size_t i = 0; i < gel.pixels().size(); ++i) {
      if (protrusion.pixels()[i] > 0) gel.pixels()[i] = protrusion.pixels()[i];
    }
  }
  for (Index y = 0; y < gel.height(); ++y) {
    for (Index x = 0; x < gel.width(); ++x)
      gel(x, y) = ImageTraits<R>::pixel(rest, x, y) - gel(x, y);
  }
  return gel;
}

}  // namespace gelight
