#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// Of a share of a kernel that lies on known pixels: where 1 less the share that is missing has
/// lost more than ten bits.
template <std::floating_point T>
[[nodiscard]] bool is_hardly_known(T missing) {
  return 1 - missing < T(0x1p-10);
}

/// The mean of the numbers around a pixel, weighted by a symmetric kernel, given from its middle
/// outwards, along rows and columns; NaN does not count. Beyond its edge the image is reflected. By
/// the sum of the weights that count, however small: so it takes their square of operations.
/// Without a value where none of the nearest eight pixels is known, whose normals alone would show
/// it.
template <std::floating_point T, class Value>
[[nodiscard]] std::optional<T> mean_beside_known(const Value& value, Index x, Index y, Index width,
                                                 Index height, const std::vector<T>& weights) {
  const auto at = [&](Index i, Index j) {
    return double{
        value(inside(x + i, width, Border::reflect101), inside(y + j, height, Border::reflect101))};
  };
  const auto sum_within = [&](Index reach) {
    std::pair<double, double> sums{0, 0};
    for (Index j = -reach; j <= reach; ++j) {
      for (Index i = -reach; i <= reach; ++i) {
        const double number = at(i, j);
        if (std::isnan(number)) continue;
        const double weight = double{weights[static_cast<std::size_t>(std::abs(i))]} *
                              double{weights[static_cast<std::size_t>(std::abs(j))]};
        sums.first += weight * number;
        sums.second += weight;
      }
    }
    return sums;
  };
  const Index radius = static_cast<Index>(weights.size()) - 1;
  if (!(sum_within(std::min(Index{1}, radius)).second > 0)) return std::nullopt;
  const auto [sum, share] = sum_within(radius);
  return static_cast<T>(sum / share);
}

/// The memory to smooth images of one size in, with kernels up to some radius.
template <std::floating_point T>
class Smoother {
 public:
  Smoother() = default;
  Smoother(Index width, Index height, Index most_radius)
      : across_(width, height),
        missing_(width, height),
        padded_(static_cast<std::size_t>(width + 2 * most_radius)),
        lack_(padded_.size()),
        taps_(static_cast<std::size_t>(2 * most_radius + 1)),
        smoothed_(static_cast<std::size_t>(width)) {}

  /// In a window of `out`, the means of the numbers around each pixel of `in`, weighted by a
  /// symmetric kernel given from its middle outwards; what is NaN does not count, and the mean of
  /// nothing is 0. Beyond its edge the image is reflected without repeating it. Of `in`, no pixel
  /// farther from the window than the kernel reaches is read.
  void mean_into(ImageView<T> out, ImageView<const T> in, const Window& window,
                 const std::vector<T>& weights) {
    const Index width = across_.width(), height = across_.height();
    const Index radius = static_cast<Index>(weights.size()) - 1;
    const Window needed = window.grown(radius, width, height);
    bool any_missing = false;
    for (Index y = needed.top; y < needed.bottom; ++y) {
      any_missing = smooth_along(in, y, window, weights) || any_missing;
    }
    for (Index y = window.top; y < window.bottom; ++y) {
      T* const row = out.row(y) + window.left;
      smooth_down(row, across_, y, window, weights);
      if (!any_missing) continue;
      // The share that is missing, not the one that is there: it is exactly 0 where all is known.
      T* const lack = smoothed_.data();
      smooth_down(lack, missing_, y, window, weights);
      for (Index i = 0; i < window.right - window.left; ++i) {
        if (!(lack[i] > 0)) continue;
        row[i] = lack[i] < 1 ? row[i] / (1 - lack[i]) : 0;
        if (!is_hardly_known(lack[i])) continue;
        row[i] = mean_beside_known(in, window.left + i, y, width, height, weights).value_or(row[i]);
      }
    }
  }

 private:
  // Whether a number of the row is missing.
  bool smooth_along(ImageView<const T> in, Index y, const Window& window,
                    const std::vector<T>& weights) {
    const Index radius = static_cast<Index>(weights.size()) - 1;
    const Index count = window.right - window.left;
    bool all_zero = true, any_missing = false;
    for (Index i = 0; i < count + 2 * radius; ++i) {
      const Index x = inside(window.left - radius + i, across_.width(), Border::reflect101);
      const T value = in(x, y);
      const auto at = static_cast<std::size_t>(i);
      const bool known = !std::isnan(value);
      padded_[at] = known ? value : 0;
      lack_[at] = known ? 0 : 1;
      all_zero = all_zero && padded_[at] == 0;
      any_missing = any_missing || !known;
    }
    sum_along(across_.row(y) + window.left, padded_, all_zero, count, weights);
    sum_along(missing_.row(y) + window.left, lack_, !any_missing, count, weights);
    return any_missing;
  }

  void sum_along(T* out, const std::vector<T>& padded, bool all_zero, Index count,
                 const std::vector<T>& weights) {
    if (all_zero) {
      std::fill_n(out, count, T(0));
      return;
    }
    const Index radius = static_cast<Index>(weights.size()) - 1;
    for (Index k = 0; k <= 2 * radius; ++k) {
      taps_[static_cast<std::size_t>(k)] = padded.data() + k;
    }
    vectorised([&] { symmetric_sum(out, taps_.data() + radius, weights.data(), radius, count); });
  }

  void smooth_down(T* out, const Image<T>& rows, Index y, const Window& window,
                   const std::vector<T>& weights) {
    const Index radius = static_cast<Index>(weights.size()) - 1;
    const T** const middle = taps_.data() + radius;
    for (Index k = -radius; k <= radius; ++k) {
      middle[k] = rows.row(inside(y + k, rows.height(), Border::reflect101)) + window.left;
    }
    vectorised(
        [&] { symmetric_sum(out, middle, weights.data(), radius, window.right - window.left); });
  }

  Image<T> across_, missing_;
  std::vector<T> padded_, lack_;
  std::vector<const T*> taps_;
  std::vector<T> smoothed_;
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::Smoother<float>;
GELIGHT_ONCE template class detail::Smoother<double>;
}  // namespace gelight
#endif
