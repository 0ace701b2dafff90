#pragma once

#include <algorithm>
#include <complex>
#include <cstddef>
#include <memory>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/membrane/fourier.hpp"

namespace gelight::detail {

/// A rectangle of pixels of an image.
struct Box {
  Index left = 0, top = 0, width = 0, height = 0;

  [[nodiscard]] std::size_t area() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] bool contains(Index x, Index y) const {
    return x >= left && x < left + width && y >= top && y < top + height;
  }
  [[nodiscard]] bool contains(const Box& other) const {
    return contains(other.left, other.top) &&
           contains(other.left + other.width - 1, other.top + other.height - 1);
  }
  /// Of a pixel, counted row after row.
  [[nodiscard]] std::ptrdiff_t place(Index x, Index y) const {
    return std::ptrdiff_t{y - top} * width + (x - left);
  }
  friend bool operator==(const Box&, const Box&) = default;
};

/// The smallest that holds two.
[[nodiscard]] inline Box united(const Box& a, const Box& b) {
  const Index left = std::min(a.left, b.left), top = std::min(a.top, b.top);
  return {left, top, std::max(a.left + a.width, b.left + b.width) - left,
          std::max(a.top + a.height, b.top + b.height) - top};
}

using Spectrum = Array<std::complex<double>>;

/// By hand: the product of std::complex asks for NaN.
[[nodiscard]] inline std::complex<double> product(const std::complex<double>& a,
                                                  const std::complex<double>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// Adds kernel times source times a sign, coefficient by coefficient.
inline void add_product(Spectrum& sum, const Spectrum& kernel, const Spectrum& source,
                        double sign) {
  for (std::size_t i = 0; i < sum.size(); ++i) {
    sum.data()[i] += product(sign * kernel.data()[i], source.data()[i]);
  }
}

/// Convolutions from one box of an image to another by Fourier transform, in a period so long that
/// nothing wraps.
class Convolution {
 public:
  Convolution(FourierBackend backend, const Box& source, const Box& target)
      : source_(source), target_(target) {
    period_x_ = good_period(source.width + target.width - 1);
    period_y_ = good_period(source.height + target.height - 1);
    from_ = backend({source.width, source.height, period_x_, period_y_});
    to_ = source == target ? nullptr : backend({target.width, target.height, period_x_, period_y_});
    full_ = backend({period_x_, period_y_, period_x_, period_y_});
  }

  /// The coefficients of a kernel, a function of a target's place less a source's, in pixels.
  template <class Kernel>
  [[nodiscard]] Spectrum kernel(const Kernel& value) const {
    const Box whole{0, 0, period_x_, period_y_};
    Array<double> image(whole.area());
    const double scale = 1 / static_cast<double>(whole.area());
    // Offsets are counted from that of the two boxes' corners, so that the target begins at 0.
    const Index x0 = target_.left - source_.left, y0 = target_.top - source_.top;
    for (Index y = 1 - source_.height; y < target_.height; ++y) {
      double* const row = &image[std::ptrdiff_t{y < 0 ? y + period_y_ : y} * period_x_];
      for (Index x = 1 - source_.width; x < target_.width; ++x) {
        row[x < 0 ? x + period_x_ : x] = scale * value(x + x0, y + y0);
      }
    }
    return transform(*full_, image.data());
  }

  /// The coefficients of values at the source's pixels, row after row.
  [[nodiscard]] Spectrum transform(const double* source) const { return transform(*from_, source); }

  /// Writes at the target's pixels what one kernel makes of values at the source's.
  void apply(double* target, const double* source, const Spectrum& kernel) {
    work_.resize(from_->size());
    from_->forward(work_.data(), source);
    for (std::size_t i = 0; i < work_.size(); ++i) {
      work_.data()[i] = product(kernel.data()[i], work_.data()[i]);
    }
    restore(target, work_);
  }

  /// No coefficients yet.
  [[nodiscard]] Spectrum zero() const {
    Spectrum none(from_->size());
    return none;
  }

  /// The most by which a kernel makes any source longer, or a little more.
  [[nodiscard]] double gain(const Spectrum& kernel) const {
    double most = 0;
    for (const auto& coefficient : kernel) most = std::max(most, std::abs(coefficient));
    return most * static_cast<double>(period_x_) * static_cast<double>(period_y_);
  }

  /// The values at the target's pixels; uses the coefficients up.
  void restore(double* target, Spectrum& spectrum) const {
    (to_ ? *to_ : *from_).inverse(target, spectrum.data());
  }

 private:
  [[nodiscard]] static Spectrum transform(PaddedTransform& how, const double* image) {
    Spectrum spectrum(how.size());
    how.forward(spectrum.data(), image);
    return spectrum;
  }

  [[nodiscard]] static Index good_period(Index least) {
    for (Index period = (least + 3) / 4 * 4;; period += 4) {
      Index rest = period;
      for (const Index prime : {2, 3, 5}) {
        while (rest % prime == 0) rest /= prime;
      }
      if (rest == 1) return period;
    }
  }

  Box source_, target_;
  Index period_x_ = 0, period_y_ = 0;
  std::unique_ptr<PaddedTransform> from_, to_, full_;
  Spectrum work_;
};

}  // namespace gelight::detail
