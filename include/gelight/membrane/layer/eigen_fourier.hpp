#pragma once

#include <algorithm>
#include <complex>
#include <memory>
#include <unsupported/Eigen/FFT>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/membrane/fourier.hpp"

namespace gelight::detail {

/// Eigen's one-dimensional transforms along the rows that hold the image, then down the columns,
/// which lie packed.
class EigenTransform : public PaddedTransform {
 public:
  explicit EigenTransform(const PaddedSize& size)
      : size_(size),
        columns_(size.period_x / 2 + 1),
        row_(static_cast<std::size_t>(size.period_x)),
        row_spectrum_(static_cast<std::size_t>(columns_)),
        half_way_(this->EigenTransform::size()) {
    fft_.SetFlag(Fft::HalfSpectrum);
    fft_.SetFlag(Fft::Unscaled);
  }

  [[nodiscard]] std::size_t size() const override {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(size_.period_y);
  }

  void forward(std::complex<double>* spectrum, const double* image) override {
    std::fill(row_.begin(), row_.end(), 0.0);
    for (Index y = 0; y < size_.height; ++y) {
      std::copy_n(image + std::ptrdiff_t{y} * size_.width, size_.width, row_.data());
      fft_.fwd(row_spectrum_.data(), row_.data(), size_.period_x);
      for (Index k = 0; k < columns_; ++k) column(k)[y] = row_spectrum_[k];
    }
    for (Index k = 0; k < columns_; ++k) {
      std::fill(column(k) + size_.height, column(k) + size_.period_y, 0.0);
      fft_.fwd(spectrum + std::ptrdiff_t{k} * size_.period_y, column(k), size_.period_y);
    }
  }

  void inverse(double* image, std::complex<double>* spectrum) override {
    for (Index k = 0; k < columns_; ++k) {
      fft_.inv(column(k), spectrum + std::ptrdiff_t{k} * size_.period_y, size_.period_y);
    }
    for (Index y = 0; y < size_.height; ++y) {
      for (Index k = 0; k < columns_; ++k) row_spectrum_[k] = column(k)[y];
      fft_.inv(row_.data(), row_spectrum_.data(), size_.period_x);
      std::copy_n(row_.data(), size_.width, image + std::ptrdiff_t{y} * size_.width);
    }
  }

 private:
  using Fft = Eigen::FFT<double>;

  [[nodiscard]] std::complex<double>* column(Index k) {
    return &half_way_[std::ptrdiff_t{k} * size_.period_y];
  }

  PaddedSize size_;
  Index columns_;
  Fft fft_;
  Array<double> row_;
  Array<std::complex<double>> row_spectrum_, half_way_;
};

[[nodiscard]] inline std::unique_ptr<PaddedTransform> eigen_backend(const PaddedSize& size) {
  return std::make_unique<EigenTransform>(size);
}

}  // namespace gelight::detail
