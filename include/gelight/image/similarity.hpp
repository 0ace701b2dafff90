#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <type_traits>

#include "gelight/concepts/image.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// How far two 8-bit images lie apart. A pixel's difference is that of its worst channel.
struct LevelDifference {
  std::array<std::int64_t, 256> pixels{};  ///< how many pixels differ by so many levels
  int worst = 0;                           ///< levels
  double mean = 0;                         ///< over all pixels

  /// How many pixels differ by more than so many levels.
  [[nodiscard]] std::int64_t beyond(int levels) const {
    std::int64_t count = 0;
    for (int d = 255; d >= 0 && d > levels; --d) count += pixels[static_cast<std::size_t>(d)];
    return count;
  }
};

/// Counts by how many grey levels two images differ. Throws InvalidInput for different sizes.
template <ImageOf<Rgb8> A, ImageOf<Rgb8> B>
[[nodiscard]] LevelDifference level_difference(const A& a, const B& b) {
  detail::require_same_size(a, b, "one image", "the other");
  LevelDifference result;
  const Index width = static_cast<Index>(ImageTraits<A>::width(a));
  const Index height = static_cast<Index>(ImageTraits<A>::height(a));
  double sum = 0;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const Rgb8 p = ImageTraits<A>::pixel(a, x, y), q = ImageTraits<B>::pixel(b, x, y);
      int off = 0;
      for (std::size_t c = 0; c < 3; ++c) off = std::max(off, std::abs(p[c] - q[c]));
      ++result.pixels[static_cast<std::size_t>(off)];
      result.worst = std::max(result.worst, off);
      sum += off;
    }
  }
  if (width > 0 && height > 0) result.mean = sum / width / height;
  return result;
}

/// The peak signal-to-noise ratio of two 8-bit images in decibels, over all channels; infinite
/// where they are equal. Throws InvalidInput for different sizes.
template <ImageOf<Rgb8> A, ImageOf<Rgb8> B>
[[nodiscard]] double psnr(const A& a, const B& b) {
  detail::require_same_size(a, b, "one image", "the other");
  const Index width = static_cast<Index>(ImageTraits<A>::width(a));
  const Index height = static_cast<Index>(ImageTraits<A>::height(a));
  double squares = 0;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const Rgb8 p = ImageTraits<A>::pixel(a, x, y), q = ImageTraits<B>::pixel(b, x, y);
      for (std::size_t c = 0; c < 3; ++c) squares += (p[c] - q[c]) * (p[c] - q[c]);
    }
  }
  if (squares == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255 * 3 * width * height / squares);
}

/// The mean structural similarity of two 8-bit images, averaged over the channels: 1 where they are
/// equal. Window: a Gaussian of sigma 1.5 cut off at 5 pixels, K1 = 0.01, K2 = 0.03; images that
/// are smaller are reflected. Throws InvalidInput for different sizes and for images without
/// pixels. (Wang, Bovik, Sheikh, Simoncelli, Image quality assessment, 2004,
/// doi:10.1109/TIP.2003.819861)
template <ImageOf<Rgb8> A, ImageOf<Rgb8> B>
[[nodiscard]] double ssim(const A& a, const B& b) {
  detail::require_same_size(a, b, "one image", "the other");
  const Index width = static_cast<Index>(ImageTraits<A>::width(a));
  const Index height = static_cast<Index>(ImageTraits<A>::height(a));
  detail::require(width > 0 && height > 0, "images of ", width, " x ", height,
                  " pixels have no similarity");
  // p, q, p^2, q^2, pq (as a type that costs nothing to include).
  using Five = Eigen::Matrix<std::enable_if_t<ImageOf<A, Rgb8>, double>, 5, 1>;
  constexpr double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    Image<Five> products(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double p = Rgb8(ImageTraits<A>::pixel(a, x, y))[c];
        const double q = Rgb8(ImageTraits<B>::pixel(b, x, y))[c];
        products(x, y) << p, q, p * p, q * q, p * q;
      }
    }
    for (const Five& m : gaussian(products, 1.5, 5).pixels()) {
      const double variances = m[2] - m[0] * m[0] + m[3] - m[1] * m[1];
      const double covariance = m[4] - m[0] * m[1];
      sum += (2 * m[0] * m[1] + c1) * (2 * covariance + c2) /
             ((m[0] * m[0] + m[1] * m[1] + c1) * (variances + c2));
    }
  }
  return sum / (3.0 * width * height);
}

}  // namespace gelight
