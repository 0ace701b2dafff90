#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/views/image_view.hpp"

// Gaussians whose cost per pixel does not grow with sigma. `gaussian` is exact, and faster below a
// sigma of about 5.
//
// Their errors are those of the worst image there can be, as shares of its range: half the sum of
// the absolute differences of the two impulse responses in the plane, over sigmas from 2 to 30,
// where they are largest below 4. Rounding comes on top, and where a border is normalised there is
// more in the corners.
namespace gelight {
namespace detail {

/// Applies a filter down the columns of an image and then along its rows. `filter` takes an image
/// with `pad` rows of border on top and at the bottom, and gives back as many rows without them.
template <ImageLike I, class Filter>
[[nodiscard]] Image<ImagePixel<I>> filter_both_ways(const I& image, Index pad, Border border,
                                                    const Filter& filter) {
  using T = ImagePixel<I>;
  const auto padded = [&](const auto& view) {
    using View = std::remove_cvref_t<decltype(view)>;
    const Index width = static_cast<Index>(ImageTraits<View>::width(view));
    const Index height = static_cast<Index>(ImageTraits<View>::height(view));
    Image<T> result(width, height + 2 * pad);
    for (Index y = -pad; y < height + pad; ++y) {
      const Index from = inside(y, height, border);
      if (from < 0) continue;
      for (Index x = 0; x < width; ++x) {
        result(x, y + pad) = ImageTraits<View>::pixel(view, x, from);
      }
    }
    return result;
  };
  const Index width = static_cast<Index>(ImageTraits<I>::width(image));
  const Index height = static_cast<Index>(ImageTraits<I>::height(image));
  Image<T> result(width, height);
  if (width == 0 || height == 0) return result;
  const Image<T> down = filter(padded(image));
  const Image<T> both = filter(padded(down.view().transposed()));
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) result(x, y) = both(y, x);
  }
  if (border == Border::normalised) {
    const Image<T> across = filter(padded(Image<T>(1, width, T(1))));
    const Image<T> along = filter(padded(Image<T>(1, height, T(1))));
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) result(x, y) /= across(0, x) * along(0, y);
    }
  }
  return result;
}

// More than any image is wide; the margins, of some sigmas, are made in memory.
inline constexpr double largest_sigma = 1e5;

inline void require_sigma(double sigma, double least) {
  require(sigma >= least && sigma <= largest_sigma, "sigma ", sigma, " is not between ", least,
          " and ", largest_sigma);
}

/// One pole of a recursive filter: state = in + pole state, and out += weight's share of it.
struct Pole {
  std::complex<double> pole, weight;
};

/// A row of complex states.
template <class T>
struct StateRow {
  std::vector<T> real, imaginary;
};

/// state = in + pole state.
template <class T>
void advance_row(T* __restrict real, T* __restrict imaginary, const T* in, const Pole& p,
                 std::ptrdiff_t count) {
  const T a = static_cast<T>(p.pole.real()), b = static_cast<T>(p.pole.imag());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T r = real[i];
    real[i] = in[i] + a * r - b * imaginary[i];
    imaginary[i] = a * imaginary[i] + b * r;
  }
}

/// out += Re(weight state).
template <class T>
void add_state_row(T* __restrict out, const T* real, const T* imaginary,
                   const std::complex<double>& weight, std::ptrdiff_t count) {
  const T a = static_cast<T>(weight.real()), b = static_cast<T>(weight.imag());
  for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += a * real[i] - b * imaginary[i];
}

/// Deriche's fourth-order approximation: two damped cosines on each side.
[[nodiscard]] inline std::array<Pole, 2> deriche_poles(double sigma) {
  using Complex = std::complex<double>;
  std::array<Pole, 2> poles{Pole{std::exp(-Complex(1.7831906544515104, 0.6318113174569493) / sigma),
                                 Complex(1.6797292232361107, 3.7348298269103580)},
                            Pole{std::exp(-Complex(1.7228297663338028, 1.9969276832487770) / sigma),
                                 Complex(-0.6802783501806897, -0.2598300478959625)}};
  double gain = 0;
  for (const Pole& p : poles) gain += std::real(p.weight * (1.0 + p.pole) / (1.0 - p.pole));
  for (Pole& p : poles) p.weight /= gain;
  return poles;
}

template <class T>
[[nodiscard]] Image<T> deriche_down(const Image<T>& padded, const std::array<Pole, 2>& poles,
                                    Index pad) {
  const Index width = padded.width(), height = padded.height() - 2 * pad;
  Image<T> result(width, height);
  const auto size = static_cast<std::size_t>(width);
  for (const Pole& p : poles) {
    StateRow<T> state;
    // As if the outermost row went on for ever.
    const auto settle = [&](const T* row) {
      const std::complex<double> steady = 1.0 / (1.0 - p.pole);
      state.real.assign(row, row + width);
      state.imaginary.assign(row, row + width);
      for (std::size_t i = 0; i < size; ++i) {
        state.real[i] *= static_cast<T>(steady.real());
        state.imaginary[i] *= static_cast<T>(steady.imag());
      }
    };
    settle(padded.row(0));
    for (Index y = 0; y < height + pad; ++y) {
      advance_row(state.real.data(), state.imaginary.data(), padded.row(y), p, width);
      if (y < pad) continue;
      add_state_row(result.row(y - pad), state.real.data(), state.imaginary.data(), p.weight,
                    width);
    }
    settle(padded.row(padded.height() - 1));
    for (Index y = padded.height() - 1; y >= pad; --y) {
      if (y < height + pad) {
        // The row itself has been counted on the way down.
        add_state_row(result.row(y - pad), state.real.data(), state.imaginary.data(),
                      p.weight * p.pole, width);
      }
      advance_row(state.real.data(), state.imaginary.data(), padded.row(y), p, width);
    }
  }
  return result;
}

/// A box of 2 radius + 1 ones with a fraction on either end, scaled to sum 1.
struct ExtendedBox {
  Index radius;
  double inner, outer;
};

/// The box whose variance is sigma^2 / passes.
[[nodiscard]] inline ExtendedBox extended_box(double sigma, int passes) {
  const double variance = sigma * sigma / passes;
  const auto r = static_cast<Index>((std::sqrt(12 * variance + 1) - 1) / 2);
  const double fraction =
      (2.0 * r + 1) * (r * (r + 1.0) - 3 * variance) / (6 * (variance - (r + 1.0) * (r + 1.0)));
  const double inner = 1 / (2 * fraction + 2 * r + 1);
  return {r, inner, fraction * inner};
}

/// out = inner sum + outer (first + last), then the sum moves on: it gains `last`, loses `leaving`.
template <class T>
void slide_row(T* __restrict out, double* __restrict sum, const T* first, const T* last,
               const T* leaving, const ExtendedBox& box, std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double ends = double{first[i]} + double{last[i]};
    out[i] = static_cast<T>(box.inner * sum[i] + box.outer * ends);
    sum[i] += double{last[i]} - double{leaving[i]};
  }
}

/// The sums that box_down moves on, each anew: of what is not finite nothing can be taken away.
template <class T>
[[nodiscard]] Image<T> summed_box_down(const Image<T>& padded, const ExtendedBox& box) {
  const Index reach = box.radius + 1, width = padded.width(), height = padded.height() - 2 * reach;
  Image<T> result(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      double sum = 0;
      for (Index k = 1; k < 2 * reach; ++k) sum += double{padded(x, y + k)};
      const double ends = double{padded(x, y)} + double{padded(x, y + 2 * reach)};
      result(x, y) = static_cast<T>(box.inner * sum + (box.outer > 0 ? box.outer * ends : 0));
    }
  }
  return result;
}

template <class T>
[[nodiscard]] Image<T> box_down(const Image<T>& padded, const ExtendedBox& box) {
  const auto& pixels = padded.pixels();
  if (!std::all_of(pixels.begin(), pixels.end(), [](T value) { return std::isfinite(value); })) {
    return summed_box_down(padded, box);
  }
  const Index reach = box.radius + 1, width = padded.width(), height = padded.height() - 2 * reach;
  Image<T> result(width, height);
  std::vector<double> sum(static_cast<std::size_t>(width));
  for (Index y = 1; y < 2 * reach; ++y) {
    for (Index x = 0; x < width; ++x) sum[static_cast<std::size_t>(x)] += double{padded(x, y)};
  }
  for (Index y = 0; y < height; ++y) {
    slide_row(result.row(y), sum.data(), padded.row(y), padded.row(y + 2 * reach),
              padded.row(y + 1), box, width);
  }
  return result;
}

/// Every other row, each a sum of the rows around it; the first is at row `start`.
template <class T>
[[nodiscard]] Image<T> halve_down(const Image<T>& image, const std::vector<T>& weights) {
  const Index radius = static_cast<Index>(weights.size()) - 1, height = (image.height() + 1) / 2;
  Image<T> result(image.width(), height);
  for (Index y = 0; y < height; ++y) {
    for (Index k = -radius; k <= radius; ++k) {
      const Index from = inside(2 * y + k, image.height(), Border::replicate);
      add_scaled(result.row(y), image.row(from), weights[static_cast<std::size_t>(std::abs(k))],
                 image.width());
    }
  }
  return result;
}

/// Undoes halve_down but for the smoothing, to `height` rows.
template <class T>
[[nodiscard]] Image<T> double_down(const Image<T>& image, const std::vector<T>& weights,
                                   Index height) {
  const Index radius = static_cast<Index>(weights.size()) - 1;
  std::array<T, 2> share{};  // of the even rows' weights and of the odd rows'
  for (Index k = -radius; k <= radius; ++k) {
    share[static_cast<std::size_t>(std::abs(k) % 2)] +=
        weights[static_cast<std::size_t>(std::abs(k))];
  }
  Image<T> result(image.width(), height);
  for (Index y = 0; y < height; ++y) {
    for (Index k = -radius; k <= radius; ++k) {
      if ((y + k) % 2 != 0) continue;
      const Index from = inside((y + k) / 2, image.height(), Border::replicate);
      const auto i = static_cast<std::size_t>(std::abs(k));
      add_scaled(result.row(y), image.row(from), weights[i] / share[i % 2], image.width());
    }
  }
  return result;
}

template <class T>
[[nodiscard]] Image<T> smooth_down(const Image<T>& image, const std::vector<T>& weights) {
  const Index radius = static_cast<Index>(weights.size()) - 1;
  Image<T> result(image.width(), image.height());
  for (Index y = 0; y < image.height(); ++y) {
    for (Index k = -radius; k <= radius; ++k) {
      const Index from = inside(y + k, image.height(), Border::replicate);
      add_scaled(result.row(y), image.row(from), weights[static_cast<std::size_t>(std::abs(k))],
                 image.width());
    }
  }
  return result;
}

/// How often an image is halved, and how much smoothing is left for the smallest one. Each halving
/// and doubling smooths by `step`, at which what folds over is below 2e-5 of its height.
struct Pyramid {
  static constexpr double step = 1.5;
  int levels = 0;
  double coarse_sigma;

  explicit Pyramid(double sigma) : coarse_sigma(sigma) {
    double variance = sigma * sigma;
    // What is left after a level, in pixels of the next.
    while ((variance - 2 * step * step) / 4 >= 1) {
      variance = (variance - 2 * step * step) / 4;
      ++levels;
    }
    coarse_sigma = std::sqrt(variance);
  }
};

template <class T>
[[nodiscard]] Image<T> pyramid_down(const Image<T>& image, const Pyramid& pyramid) {
  const auto step = gaussian_weights<T>(Pyramid::step, 6);
  std::vector<Image<T>> levels{image};
  for (int k = 0; k < pyramid.levels; ++k) levels.push_back(halve_down(levels.back(), step));
  const auto radius = static_cast<Index>(std::ceil(5 * pyramid.coarse_sigma));
  Image<T> smooth = smooth_down(levels.back(), gaussian_weights<T>(pyramid.coarse_sigma, radius));
  for (int k = pyramid.levels; k-- > 0;) {
    smooth = double_down(smooth, step, levels[static_cast<std::size_t>(k)].height());
  }
  return smooth;
}

template <class T>
[[nodiscard]] Image<T> rows_of(const Image<T>& image, Index first, Index height) {
  Image<T> result(image.width(), height);
  std::copy_n(image.row(first), static_cast<std::ptrdiff_t>(height) * image.width(), result.data());
  return result;
}

}  // namespace detail

/// A Gaussian by Deriche's recursive filter of fourth order, for any sigma from 0.5 up.
///
/// Within 5.5e-4 of the image's range, for a sigma of 2 or more. 40 multiply-adds a pixel. Throws
/// InvalidInput for a sigma that is not from 0.5 to 1e5. (Deriche, Recursively implementing the
/// Gaussian and its derivatives, INRIA research report 1893, 1993)
template <ImageLike I>
requires std::floating_point<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> gaussian_recursive(const I& image, double sigma,
                                                      Border border = Border::reflect101) {
  detail::require_sigma(sigma, 0.5);
  const Index pad = border == Border::replicate ? 0 : static_cast<Index>(std::ceil(6 * sigma));
  const auto poles = detail::deriche_poles(sigma);
  return detail::filter_both_ways(image, pad, border, [&](const auto& padded) {
    return detail::deriche_down(padded, poles, pad);
  });
}

/// A Gaussian as a cascade of boxes with fractional ends, which has exactly its variance.
///
/// Three passes come within 4.3 % of the image's range, five within 2.4 %, for a sigma of 2 or
/// more. 8 additions a pass and pixel, summed in double. Throws InvalidInput for a sigma that is
/// not positive or above 1e5, for less than one pass, and for passes that reach beyond 2^26 pixels
/// together. (Gwosdek, Grewenig, Bruhn, Weickert,
/// Theoretical foundations of Gaussian convolution by extended box filtering, 2011,
/// doi:10.1007/978-3-642-24785-9_38)
template <ImageLike I>
requires std::floating_point<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> gaussian_boxes(const I& image, double sigma, int passes = 3,
                                                  Border border = Border::reflect101) {
  detail::require(sigma > 0, "sigma ", sigma, " is not positive");
  detail::require_sigma(sigma, 0);
  detail::require(passes >= 1, passes, " passes are less than one");
  const auto box = detail::extended_box(sigma, passes);
  const std::int64_t reach = std::int64_t{passes} * (box.radius + 1);
  detail::require(reach <= 1 << 26, passes, " passes reach ", reach, " pixels, beyond 2^26");
  const auto pad = static_cast<Index>(reach);
  return detail::filter_both_ways(image, pad, border, [&](auto padded) {
    for (int pass = 0; pass < passes; ++pass) padded = detail::box_down(padded, box);
    return padded;
  });
}

/// A Gaussian on a pyramid: halved while the smoothing allows it, smoothed there, doubled again.
///
/// Within 3.1e-4 of the image's range, within 1e-4 for a sigma of 6 or more. About 60 multiply-adds
/// a pixel for any sigma. Throws InvalidInput for a sigma that is negative or
/// above 1e5. (Burt, Fast filter transforms for image processing, 1981,
/// doi:10.1016/0146-664X(81)90092-7)
template <ImageLike I>
requires std::floating_point<ImagePixel<I>>
[[nodiscard]] Image<ImagePixel<I>> gaussian_pyramid(const I& image, double sigma,
                                                    Border border = Border::reflect101) {
  detail::require_sigma(sigma, 0);
  const detail::Pyramid pyramid(sigma);
  const Index pad = static_cast<Index>(std::ceil(5 * sigma));
  return detail::filter_both_ways(image, pad, border, [&](const auto& padded) {
    return detail::rows_of(detail::pyramid_down(padded, pyramid), pad, padded.height() - 2 * pad);
  });
}

}  // namespace gelight
