#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// What a filter sees beyond the image's edge, for pixels a b c d from the edge inwards:
/// `reflect101` is d c b | a b c d, `reflect` is c b a | a b c d, `replicate` is a a a | a b c d,
/// `zero` is 0 0 0 | a b c d; `normalised`, for smoothing only, is nothing: the weights of the
/// pixels that are there are scaled to sum 1.
enum class Border : std::uint8_t { reflect101, reflect, replicate, zero, normalised };

namespace detail {

/// The pixel inside [0, size) that stands for pixel i, or -1 where there is none.
[[nodiscard]] inline Index inside(Index i, Index size, Border border) {
  if (i >= 0 && i < size) return i;
  if (border == Border::zero || border == Border::normalised) return -1;
  if (border == Border::replicate || size == 1) return std::clamp(i, Index{0}, size - 1);
  const Index once = border == Border::reflect101 ? size - 1 : size;
  const Index wrapped = ((i % (2 * once)) + 2 * once) % (2 * once);
  if (border == Border::reflect101) return wrapped <= once ? wrapped : 2 * once - wrapped;
  return wrapped < once ? wrapped : 2 * once - 1 - wrapped;
}

/// How a pixel is taken apart into numbers of one type: itself, or a vector's coefficients.
template <class P>
struct PixelParts {
  using Scalar = P;
  static constexpr Index count = 1;
};
template <class S, int N>
struct PixelParts<Eigen::Matrix<S, N, 1>> {
  static_assert(N > 0);
  using Scalar = S;
  static constexpr Index count = N;
};

/// Pixels that a filter can weigh: floating-point numbers, or vectors of them.
template <class P>
concept FilterPixel = std::floating_point<typename PixelParts<P>::Scalar>;

/// out[i] += scale row[i]
template <class T>
void add_scaled(T* __restrict out, const T* row, T scale, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += scale * row[i];
}

/// out[i] = w[0] taps[0][i] + the sum over k of w[k] (taps[-k][i] + taps[k][i]), 1 <= k <= radius.
/// Five pairs at a time, so that the sums stay in registers and the loop is vectorised.
template <class T>
void symmetric_sum(T* __restrict out, const T* const* taps, const T* w, Index radius,
                   std::ptrdiff_t count) {
  const T* const middle = taps[0];
  const T w0 = w[0];
  for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = w0 * middle[i];
  Index k = 1;
  for (; k + 4 <= radius; k += 5) {
    const T *const a1 = taps[-k], *const b1 = taps[k];
    const T *const a2 = taps[-k - 1], *const b2 = taps[k + 1];
    const T *const a3 = taps[-k - 2], *const b3 = taps[k + 2];
    const T *const a4 = taps[-k - 3], *const b4 = taps[k + 3];
    const T *const a5 = taps[-k - 4], *const b5 = taps[k + 4];
    const T w1 = w[k], w2 = w[k + 1], w3 = w[k + 2], w4 = w[k + 3], w5 = w[k + 4];
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      out[i] += w1 * (a1[i] + b1[i]) + w2 * (a2[i] + b2[i]) + w3 * (a3[i] + b3[i]) +
                w4 * (a4[i] + b4[i]) + w5 * (a5[i] + b5[i]);
    }
  }
  for (; k <= radius; ++k) {
    const T *const a = taps[-k], *const b = taps[k];
    const T wk = w[k];
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += wk * (a[i] + b[i]);
  }
}

/// How many columns symmetric_sums works on at once.
inline constexpr Index column_step = 32;

/// The sums down two neighbouring columns' worth of rows: first[i] is that of `middle`, with the
/// rows k strides above and below it weighted by w[k], and second[i] that of the row after it. They
/// are kept in registers while the rows go by. Works in steps of column_step: up to so many more
/// numbers are read and written than `count`.
template <class T>
void symmetric_sums(T* __restrict first, T* __restrict second, const T* middle,
                    std::ptrdiff_t stride, const T* w, Index radius, std::ptrdiff_t count) {
  for (std::ptrdiff_t x = 0; x < count; x += column_step) {
    T a[column_step], b[column_step];
    for (Index i = 0; i < column_step; ++i) a[i] = w[0] * middle[x + i];
    for (Index i = 0; i < column_step; ++i) b[i] = w[0] * middle[x + stride + i];
    for (Index k = 1; k <= radius; ++k) {
      const T wk = w[k];
      const T *const up = middle + x - k * stride, *const down = middle + x + k * stride;
      for (Index i = 0; i < column_step; ++i) a[i] += wk * (up[i] + down[i]);
      for (Index i = 0; i < column_step; ++i) b[i] += wk * (up[stride + i] + down[stride + i]);
    }
    for (Index i = 0; i < column_step; ++i) first[x + i] = a[i];
    for (Index i = 0; i < column_step; ++i) second[x + i] = b[i];
  }
}

}  // namespace detail

/// Half of a Gaussian's weights, from the middle outwards, cut off beyond `radius` and scaled so
/// that the whole kernel, both sides, sums to 1. A sigma of 0 is the identity.
/// Throws InvalidInput for a sigma that is negative or not finite, and for a radius that is
/// negative or beyond 2^26 pixels.
template <std::floating_point T>
[[nodiscard]] std::vector<T> gaussian_weights(double sigma, Index radius) {
  detail::require(std::isfinite(sigma) && sigma >= 0, "sigma ", sigma,
                  " is negative or not finite");
  detail::require(radius >= 0, "radius ", radius, " is negative");
  detail::require(radius <= 1 << 26, "radius ", radius, " is beyond 2^26 pixels");
  std::vector<double> exact{1};
  double sum = 1;
  for (Index k = 1; k <= radius; ++k) {
    const double d = k / sigma;  // infinite where sigma is 0 or tiny: exp(-inf) = 0
    exact.push_back(std::exp(-0.5 * d * d));
    sum += 2 * exact.back();
  }
  std::vector<T> weights;
  weights.reserve(exact.size());
  for (const double e : exact) weights.push_back(static_cast<T>(e / sum));
  return weights;
}

/// How far out a Gaussian is summed when no radius is given: 4 sigma (beyond lies 6e-5 of its
/// weight), but no further than four times the image's longer side, where it is flat.
[[nodiscard]] inline Index gaussian_radius(double sigma, Index width, Index height) {
  detail::require(std::isfinite(sigma) && sigma >= 0, "sigma ", sigma,
                  " is negative or not finite");
  const double side = 4.0 * std::max({width, height, Index{1}});
  const double most = std::min(side, double{std::numeric_limits<Index>::max()});
  return static_cast<Index>(std::min(std::ceil(4 * sigma), most));
}

namespace detail {

/// For each of `size` pixels in a row: the share of a symmetric kernel, given from its middle
/// outwards, that lies on pixels of the row.
template <class T>
[[nodiscard]] std::vector<T> share_inside(const std::vector<T>& weights, Index size) {
  const Index radius = static_cast<Index>(weights.size()) - 1;
  std::vector<T> shares;
  for (Index x = 0; x < size; ++x) {
    double share = 0;
    for (Index from = std::max(Index{0}, x - radius); from <= std::min(size - 1, x + radius);
         ++from) {
      share += double{weights[static_cast<std::size_t>(std::abs(from - x))]};
    }
    shares.push_back(static_cast<T>(share));
  }
  return shares;
}

/// Convolves an image along its rows and then its columns with a symmetric kernel, given from its
/// middle outwards.
template <ImageLike I, class T>
[[nodiscard]] Image<ImagePixel<I>> convolve_symmetric(const I& image, const std::vector<T>& weights,
                                                      Border border) {
  using P = ImagePixel<I>;
  Index radius = static_cast<Index>(weights.size()) - 1;
  // What has no weight does not count, even where it is no number.
  while (radius > 0 && weights[static_cast<std::size_t>(radius)] == 0) --radius;
  constexpr Index parts = PixelParts<P>::count;
  const Index width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index height = static_cast<Index>(ImageTraits<I>::height(image));
  Image<P> rows(width, height), result(width, height);
  if (width == 0 || height == 0) return result;

  Array<P> padded(static_cast<std::size_t>(width + 2 * radius));
  std::vector<const T*> taps(static_cast<std::size_t>(2 * radius + 1));
  const T** const middle = taps.data() + radius;
  const auto numbers = [](auto* pixels) {
    using N =
        std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(pixels)>>, const T, T>;
    return reinterpret_cast<N*>(pixels);
  };
  const P zero = zero_pixel<P>();
  for (Index y = 0; y < height; ++y) {
    for (Index x = -radius; x < width + radius; ++x) {
      const Index from = inside(x, width, border);
      padded[x + radius] = from < 0 ? zero : P(ImageTraits<I>::pixel(image, from, y));
    }
    for (Index k = -radius; k <= radius; ++k) middle[k] = numbers(&padded[radius + k]);
    symmetric_sum(numbers(rows.row(y)), middle, weights.data(), radius,
                  std::ptrdiff_t{parts} * width);
  }
  const std::vector<P> empty(static_cast<std::size_t>(width), zero);
  for (Index y = 0; y < height; ++y) {
    for (Index k = -radius; k <= radius; ++k) {
      const Index from = inside(y + k, height, border);
      middle[k] = numbers(from < 0 ? empty.data() : std::as_const(rows).row(from));
    }
    symmetric_sum(numbers(result.row(y)), middle, weights.data(), radius,
                  std::ptrdiff_t{parts} * width);
  }
  if (border == Border::normalised) {
    const auto across = share_inside(weights, width), down = share_inside(weights, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        result(x, y) /= across[static_cast<std::size_t>(x)] * down[static_cast<std::size_t>(y)];
      }
    }
  }
  return result;
}

}  // namespace detail

/// Convolves an image with a Gaussian cut off beyond `radius` pixels, rows and columns in turn.
///
/// Pixels are floating-point numbers or vectors of them; the result has the same size. What is not
/// finite spreads as far as it has weight (see image/mask.hpp). Exact but for rounding; 4 radius +
/// 2 multiply-adds a pixel. Throws as gaussian_weights does.
template <ImageLike I>
requires detail::FilterPixel<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> gaussian(const I& image, double sigma, Index radius,
                                            Border border = Border::reflect101) {
  using T = typename detail::PixelParts<ImagePixel<I>>::Scalar;
  return detail::convolve_symmetric(image, gaussian_weights<T>(sigma, radius), border);
}

/// The same, out to `gaussian_radius`.
template <ImageLike I>
requires detail::FilterPixel<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> gaussian(const I& image, double sigma) {
  return gaussian(image, sigma,
                  gaussian_radius(sigma, static_cast<Index>(ImageTraits<I>::width(image)),
                                  static_cast<Index>(ImageTraits<I>::height(image))));
}

namespace detail {

/// The pixels from (left, top) on, as many as `result` has, of an image resized to width x height.
template <ImageLike I>
void resize_into(Image<ImagePixel<I>>& result, const I& image, Index width, Index height,
                 Index left, Index top) {
  using P = ImagePixel<I>;
  using T = typename PixelParts<P>::Scalar;
  struct Between {
    Index low, high;
    T share;  // of high
  };
  const Index in_width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index in_height = static_cast<Index>(ImageTraits<I>::height(image));
  const auto sample = [](Index i, Index out, Index in) -> Between {
    const double at = std::clamp((i + 0.5) * in / out - 0.5, 0.0, in - 1.0);
    const Index low = static_cast<Index>(at);
    return {low, std::min(low + 1, in - 1), static_cast<T>(at - low)};
  };
  std::vector<Between> columns;
  columns.reserve(static_cast<std::size_t>(result.width()));
  for (Index x = 0; x < result.width(); ++x) columns.push_back(sample(left + x, width, in_width));
  for (Index y = 0; y < result.height(); ++y) {
    const Between row = sample(top + y, height, in_height);
    P* out = result.row(y);
    for (const Between& c : columns) {
      // What has no share does not count, even where it is no number.
      const auto mix = [](auto share, const P& low, const P& high) -> P {
        if (share == 0) return low;
        return (1 - share) * low + share * high;
      };
      const auto across = [&](Index from) -> P {
        return mix(c.share, ImageTraits<I>::pixel(image, c.low, from),
                   ImageTraits<I>::pixel(image, c.high, from));
      };
      *out++ = mix(row.share, across(row.low), across(row.high));
    }
  }
}

}  // namespace detail

/// Resizes an image by bilinear interpolation between pixel centres; beyond the outermost centres
/// it is constant. Making an image much smaller skips pixels: blur it first.
///
/// Pixels are floating-point numbers or vectors of them. Throws InvalidInput for a negative size,
/// and for an empty image where the result is not.
template <ImageLike I>
requires detail::FilterPixel<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> resize_bilinear(const I& image, Index width, Index height) {
  Image<ImagePixel<I>> result(width, height);
  if (width == 0 || height == 0) return result;
  const Index in_width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index in_height = static_cast<Index>(ImageTraits<I>::height(image));
  detail::require(in_width > 0 && in_height > 0, "an image of ", in_width, " x ", in_height,
                  " pixels cannot be resized to ", width, " x ", height);
  detail::resize_into(result, image, width, height, 0, 0);
  return result;
}

/// The 3 x 3 Sobel derivatives of an image in x and y: 8 times the slope per pixel.
template <class P>
struct Gradient {
  Image<P> x;  ///< across
  Image<P> y;  ///< down
};

/// Convolves an image with the two 3 x 3 Sobel kernels ([1 2 1] across, [-1 0 1] along).
/// Pixels are floating-point numbers or vectors of them. Throws InvalidInput for a normalised
/// border.
template <ImageLike I>
requires detail::FilterPixel<ImagePixel<I>>
[[nodiscard]] Gradient<ImagePixel<I>> sobel(const I& image, Border border = Border::reflect101) {
  using P = ImagePixel<I>;
  using T = typename detail::PixelParts<P>::Scalar;
  const Index width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index height = static_cast<Index>(ImageTraits<I>::height(image));
  detail::require(border != Border::normalised, "derivatives have no normalised border");
  const P zero = detail::zero_pixel<P>();
  Gradient<P> gradient{Image<P>(width, height), Image<P>(width, height)};
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const auto at = [&](Index dx, Index dy) -> P {
        const Index from_x = detail::inside(x + dx, width, border);
        const Index from_y = detail::inside(y + dy, height, border);
        return from_x < 0 || from_y < 0 ? zero : P(ImageTraits<I>::pixel(image, from_x, from_y));
      };
      const P a = at(-1, -1), b = at(0, -1), c = at(1, -1), d = at(-1, 0), f = at(1, 0),
              g = at(-1, 1), h = at(0, 1), i = at(1, 1);
      gradient.x(x, y) = (c - a) + T(2) * (f - d) + (i - g);
      gradient.y(x, y) = (g - a) + T(2) * (h - b) + (i - c);
    }
  }
  return gradient;
}

}  // namespace gelight
