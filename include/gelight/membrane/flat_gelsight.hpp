#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numeric>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/membrane/contact.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// A kernel along rows and columns: pixel i of the result is the sum of weights[j] times pixel
/// i + j - size / 2.
template <class Real>
struct PulseKernel {
  /// What SciPy's Gaussian filter makes of a unit pulse in the middle of `size` numbers: cut off at
  /// 4 sigma, and what leaves the array reflected back into it.
  PulseKernel(Real sigma, Index size) : weights(static_cast<std::size_t>(size)) {
    const Index radius = static_cast<Index>(std::floor(4 * sigma + 0.5));
    const auto gaussian = gaussian_weights<Real>(sigma, radius);
    for (Index i = 0; i < size; ++i) {
      for (Index k = -radius; k <= radius; ++k) {
        if (inside(i + k, size, Border::reflect) != size / 2) continue;
        weights[static_cast<std::size_t>(i)] += gaussian[static_cast<std::size_t>(std::abs(k))];
      }
    }
    sum = std::accumulate(weights.begin(), weights.end(), Real(0));
  }

  std::vector<Real> weights;
  Real sum = 0;
};

/// The larger of a protrusion and its blurred self, scaled to the same height, again and again.
template <class Real>
class SpreadRounds {
 public:
  SpreadRounds(Index width, Index height)
      : protrusion_(width, height),
        spread_(protrusion_),
        rows_(protrusion_),
        next_(protrusion_),
        lack_(protrusion_),
        padded_(static_cast<std::size_t>(width + most_taps)) {}

  /// Begins with a protrusion, NaN where it is not known.
  template <class At>
  void start(const At& protrusion) {
    highest_ = 0;
    any_missing_ = false;
    for (Index y = 0; y < spread_.height(); ++y) {
      for (Index x = 0; x < spread_.width(); ++x) {
        const Real value = protrusion(x, y);
        protrusion_(x, y) = value;
        if (value > highest_) highest_ = value;
        any_missing_ = any_missing_ || std::isnan(value);
      }
    }
    spread_ = protrusion_;
  }

  /// One more round. What is not known stays so, and is left out of the blur.
  void spread(const PulseKernel<Real>& kernel) {
    const auto known = [&](std::size_t i) {
      return std::isnan(spread_.pixels()[i]) ? 0 : spread_.pixels()[i];
    };
    correlate_into(next_, known, kernel);
    if (any_missing_) {
      const Real share = 1 / (kernel.sum * kernel.sum);
      correlate_into(
          lack_, [&](std::size_t i) { return std::isnan(spread_.pixels()[i]) ? share : 0; },
          kernel);
    }
    Real highest = 0;
    for (std::size_t i = 0; i < next_.pixels().size(); ++i) {
      if (std::isnan(protrusion_.pixels()[i])) continue;
      if (any_missing_) next_.pixels()[i] /= 1 - lack_.pixels()[i];
      highest = std::max(highest, next_.pixels()[i]);
    }
    const Real scale = highest > 0 ? highest_ / highest : 0;
    for (std::size_t i = 0; i < next_.pixels().size(); ++i) {
      const Real own = protrusion_.pixels()[i];
      spread_.pixels()[i] = std::isnan(own) ? own : std::max(scale * next_.pixels()[i], own);
    }
  }

  /// What the rounds have made of it.
  [[nodiscard]] const Image<Real>& result() const { return spread_; }

 private:
  template <class At>
  void correlate_into(Image<Real>& out, const At& at, const PulseKernel<Real>& kernel) {
    const Index width = rows_.width(), height = rows_.height();
    const Index taps = static_cast<Index>(kernel.weights.size()), anchor = taps / 2;
    for (Index y = 0; y < height; ++y) {
      const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      for (Index i = 0; i < width + taps - 1; ++i) {
        const Index from = inside(i - anchor, width, Border::reflect101);
        padded_[static_cast<std::size_t>(i)] = at(first + static_cast<std::size_t>(from));
      }
      sum_rows(rows_.row(y), kernel, [&](Index j) { return padded_.data() + j; });
    }
    for (Index y = 0; y < height; ++y) {
      sum_rows(out.row(y), kernel, [&](Index j) {
        return std::as_const(rows_).row(inside(y + j - anchor, height, Border::reflect101));
      });
    }
  }

  template <class Row>
  void sum_rows(Real* out, const PulseKernel<Real>& kernel, const Row& row) const {
    const Index width = rows_.width();
    std::fill_n(out, width, Real(0));
    vectorised([&] {
      for (std::size_t j = 0; j < kernel.weights.size(); ++j) {
        add_scaled(out, row(static_cast<Index>(j)), kernel.weights[j], width);
      }
    });
  }

  static constexpr Index most_taps = 52;

  Image<Real> protrusion_, spread_, rows_, next_, lack_;
  std::vector<Real> padded_;
  Real highest_ = 0;
  bool any_missing_ = false;
};

}  // namespace detail

/// The membrane of the flat GelSight simulator that the GelTip's came from: twice a narrow spread
/// of the protrusion less a wide one, so that the gel sinks around the contact before it rises. It
/// is scaled to the height of what is pressed in, so that it depends on the whole image; NaN where
/// a depth is not known. (Gomes, Wilson, Luo, GelSight Simulation for Sim2Real Learning, 2019; the
/// kernels of 21 and 52 pixels are those of its published code.) Works in double; some 740
/// multiply-adds a pixel of the image.
template <std::floating_point T>
class FlatGelSightMembrane {
 public:
  /// The memory that `press_into` works in.
  struct Workspace {
    detail::SpreadRounds<double> narrow;  ///< of the object
    detail::SpreadRounds<double> wide;    ///< of the object
  };

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const { return whole_image; }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    return {{width, height}, {width, height}};
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    if (press.window.is_empty()) return;
    const auto protrusion = [&](Index x, Index y) {
      return static_cast<double>(detail::protrusion(press.depth(x, y), press.rest(x, y)));
    };
    work.narrow.start(protrusion);
    work.wide.start(protrusion);
    for (int round = 0; round < 3; ++round) work.narrow.spread(narrow_);
    for (int round = 0; round < 3; ++round) work.wide.spread(wide_);
    for (int round = 0; round < 3; ++round) work.wide.spread(narrow_);
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        const double sunk = 2 * work.narrow.result()(x, y) - work.wide.result()(x, y);
        surface(x, y) = static_cast<T>(double{press.rest(x, y)} - sunk);
      }
    }
  }
  ///@}

 private:
  detail::PulseKernel<double> narrow_{7, 21}, wide_{9, 52};
};

}  // namespace gelight
