#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/views/image_view.hpp"

// How the gel of published sensors bulges around what is pressed into it.
namespace gelight {

namespace detail {

/// How far an object stands out of the surface at rest, 0 where it does not touch it.
template <ImageLike D, ImageLike R>
[[nodiscard]] Image<PixelOf<R>> protrusion(const D& depth, const R& rest) {
  using T = PixelOf<R>;
  require_same_size(depth, rest, "the depth image", "the rest depth image");
  Image<T> out(static_cast<Index>(ImageTraits<R>::width(rest)),
               static_cast<Index>(ImageTraits<R>::height(rest)));
  for (Index y = 0; y < out.height(); ++y) {
    for (Index x = 0; x < out.width(); ++x) {
      const T p =
          ImageTraits<R>::pixel(rest, x, y) - static_cast<T>(ImageTraits<D>::pixel(depth, x, y));
      out(x, y) = std::max(T(0), p);
    }
  }
  return out;
}

}  // namespace detail

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
  Image<T> result = gaussian(detail::protrusion(depth, rest), sigma, radius);
  for (Index y = 0; y < result.height(); ++y) {
    for (Index x = 0; x < result.width(); ++x) {
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
  const Image<T> protrusion = detail::protrusion(depth, rest);
  Image<T> gel = protrusion;
  for (const double sigma : sigmas) {
    gel = gaussian(gel, sigma);
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
