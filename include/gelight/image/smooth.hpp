#pragma once

#include <algorithm>
#include <array>
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

// How the gel of published sensors bulges around what is pressed into it.
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
  std::vector<T> padded(static_cast<std::size_t>(width + taps));
  for (Index y = 0; y < height; ++y) {
    for (Index x = -anchor; x < width + taps - 1 - anchor; ++x) {
      const Index from = detail::inside(x, width, border);
      padded[static_cast<std::size_t>(x + anchor)] =
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

/// The depth of an elastic membrane that something is pressed into: min(depth, rest - G(rest -
/// depth)), with a Gaussian G cut off beyond `radius` pixels and the image reflected without
/// repeating its edge. Depths in one unit, of the size of `rest`; what lies deeper than `rest` does
/// not touch it.
///
/// Throws InvalidInput for images of different sizes, and as gaussian_weights does. (Gomes,
/// Paoletti, Luo, Simulation of Curved GelSight Sensors for Sim2Real Learning)
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> elastic_depth(const D& depth, const R& rest, double sigma = 5,
                                              Index radius = 20) {
  using T = PixelOf<R>;
  const Index width = static_cast<Index>(ImageTraits<R>::width(rest));
  const Index height = static_cast<Index>(ImageTraits<R>::height(rest));
  detail::require_same_size(depth, rest, "the depth image", "the rest depth image");
  Image<T> protrusion(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T p =
          ImageTraits<R>::pixel(rest, x, y) - static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      protrusion(x, y) = std::max(T(0), p);
    }
  }
  Image<T> result = gaussian(protrusion, sigma, radius);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T at_rest = ImageTraits<R>::pixel(rest, x, y);
      const T contact = std::min(at_rest, static_cast<T>(ImageTraits<D>::pixel(depth, x, y)));
      result(x, y) = std::min(contact, at_rest - result(x, y));
    }
  }
  return result;
}

namespace detail {

/// The kernel that SciPy's Gaussian filter makes of a unit pulse in the middle of `size` numbers:
/// cut off at 4 sigma, and what leaves the array reflected back into it.
[[nodiscard]] inline std::vector<double> filtered_pulse(double sigma, Index size) {
  const Index radius = static_cast<Index>(4 * sigma + 0.5);
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

template <class T>
[[nodiscard]] T largest(const Image<T>& image) {
  return image.pixels().empty() ? T(0)
                                : *std::max_element(image.pixels().begin(), image.pixels().end());
}

/// The larger of the protrusion and its blurred self, scaled to the same height.
[[nodiscard]] inline Image<double> spread_round(const Image<double>& spread,
                                                const Image<double>& protrusion,
                                                const std::vector<double>& kernel) {
  const auto anchor = static_cast<Index>(kernel.size() / 2);
  Image<double> next = correlate<double>(spread, kernel, anchor);
  const double highest = largest(next);
  const double scale = highest > 0 ? largest(protrusion) / highest : 0;
  for (std::size_t i = 0; i < next.pixels().size(); ++i) {
    next.pixels()[i] = std::max(scale * next.pixels()[i], protrusion.pixels()[i]);
  }
  return next;
}

}  // namespace detail

/// The membrane of the flat GelSight simulator that the GelTip's came from: twice a narrow spread
/// of the protrusion less a wide one, so that the gel sinks around the contact before it rises.
///
/// Depths in one unit, the gel's surface flat at `rest`. Without contact the membrane is at rest.
/// (Gomes, Wilson, Luo, GelSight Simulation for Sim2Real Learning, 2019; the kernels of 21 and 52
/// pixels are those of its published code.) About 740 multiply-adds a pixel.
template <ImageOf<double> I>
[[nodiscard]] Image<double> gelsight_flat_depth(const I& depth, double rest = 0.030) {
  const Index width = static_cast<Index>(ImageTraits<I>::width(depth));
  const Index height = static_cast<Index>(ImageTraits<I>::height(depth));
  Image<double> protrusion(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      protrusion(x, y) = rest - static_cast<double>(ImageTraits<I>::pixel(depth, x, y));
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
/// Depths in one unit; `depth` and `rest` of one size. Throws InvalidInput for images of different
/// sizes and as gaussian does. (Si, Yuan, Taxim: An Example-based Simulation Model for GelSight
/// Tactile Sensors, 2022, doi:10.1109/LRA.2022.3142412)
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> taxim_depth(const D& depth, const R& rest,
                                            std::span<const double> sigmas) {
  using T = PixelOf<R>;
  detail::require_same_size(depth, rest, "the depth image", "the rest depth image");
  const Index width = static_cast<Index>(ImageTraits<R>::width(rest));
  const Index height = static_cast<Index>(ImageTraits<R>::height(rest));
  Image<T> protrusion(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T p =
          ImageTraits<R>::pixel(rest, x, y) - static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      protrusion(x, y) = std::max(T(0), p);
    }
  }
  Image<T> gel = protrusion;
  for (const double sigma : sigmas) {
    gel = gaussian(gel, sigma);
    for (std::size_t i = 0; i < gel.pixels().size(); ++i) {
      if (protrusion.pixels()[i] > 0) gel.pixels()[i] = protrusion.pixels()[i];
    }
  }
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) gel(x, y) = ImageTraits<R>::pixel(rest, x, y) - gel(x, y);
  }
  return gel;
}

/// The mean of the known pixels around each pixel, weighted by a Gaussian (normalised convolution).
/// Pixels that are NaN or infinite are not known, and stay NaN. Where all are known it is
/// `gaussian`. Throws as gaussian_weights does. (Knutsson, Westin, Normalized and differential
/// convolution, 1993, doi:10.1109/CVPR.1993.341081)
template <ImageLike I>
requires std::floating_point<PixelOf<I>>
[[nodiscard]] Image<PixelOf<I>> gaussian_of_known(const I& image, double sigma, Index radius,
                                                  Border border = Border::reflect101) {
  using T = PixelOf<I>;
  const Index width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index height = static_cast<Index>(ImageTraits<I>::height(image));
  Image<T> values(width, height), missing(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const T value = ImageTraits<I>::pixel(image, x, y);
      const bool known = std::isfinite(value);
      values(x, y) = known ? value : T(0);
      missing(x, y) = known ? T(0) : T(1);
    }
  }
  Image<T> mean = gaussian(values, sigma, radius, border);
  // The share that is missing, not the one that is there: it is exactly 0 where all is known.
  const Image<T> lack = gaussian(missing, sigma, radius, border);
  for (std::size_t i = 0; i < mean.pixels().size(); ++i) {
    if (missing.pixels()[i] != 0) mean.pixels()[i] = std::numeric_limits<T>::quiet_NaN();
    if (lack.pixels()[i] > 0) mean.pixels()[i] /= 1 - lack.pixels()[i];
  }
  return mean;
}

}  // namespace gelight
