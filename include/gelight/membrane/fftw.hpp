#pragma once

#include <fftw3.h>

#include <algorithm>
#include <complex>
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <type_traits>

#include "gelight/core/types.hpp"
#include "gelight/membrane/fourier.hpp"

// Opt-in: needs FFTW 3 (doi:10.1109/JPROC.2004.840301), and linking with it (-lfftw3).

namespace gelight {

namespace detail {

/// FFTW makes and ends plans for one thread at a time.
[[nodiscard]] inline std::mutex& fftw_planner() {
  static std::mutex planner;
  return planner;
}

struct FftwDeleter {
  void operator()(void* memory) const { fftw_free(memory); }
  void operator()(fftw_plan plan) const {
    const std::lock_guard lock(fftw_planner());
    fftw_destroy_plan(plan);
  }
};
using FftwPlan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, FftwDeleter>;

/// FFTW's transforms along the rows that hold the image, then down all columns. Those are written
/// packed, one after the other: FFTW is three times as fast at that as in place.
class FftwTransform : public PaddedTransform {
 public:
  explicit FftwTransform(const PaddedSize& size)
      : size_(size),
        columns_(size.period_x / 2 + 1),
        rows_(fftw_alloc_real(static_cast<std::size_t>(size.period_x) *
                              static_cast<std::size_t>(std::max(size.height, 1)))),
        half_way_(fftw_alloc_complex(this->FftwTransform::size())) {
    if (!rows_ || !half_way_) throw std::bad_alloc();
  }

  [[nodiscard]] std::size_t size() const override {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(size_.period_y);
  }

  void forward(std::complex<double>* spectrum, const double* image) override {
    for (std::ptrdiff_t y = 0; y < size_.height; ++y) {
      double* const row = rows_.get() + y * size_.period_x;
      std::copy_n(image + y * size_.width, size_.width, row);
      std::fill(row + size_.width, row + size_.period_x, 0.0);
    }
    auto* const to = reinterpret_cast<fftw_complex*>(spectrum);
    if (!rows_forward_) plan_forward(to);
    fftw_execute(rows_forward_.get());
    auto* const coefficients = reinterpret_cast<std::complex<double>*>(half_way_.get());
    std::fill(coefficients + std::ptrdiff_t{size_.height} * columns_, coefficients + size(), 0.0);
    fftw_execute_dft(columns_forward_.get(), half_way_.get(), to);
  }

  void inverse(double* image, std::complex<double>* spectrum) override {
    auto* const from = reinterpret_cast<fftw_complex*>(spectrum);
    if (!rows_inverse_) plan_inverse(from);
    fftw_execute_dft(columns_inverse_.get(), from, half_way_.get());
    fftw_execute(rows_inverse_.get());
    for (std::ptrdiff_t y = 0; y < size_.height; ++y) {
      std::copy_n(rows_.get() + y * size_.period_x, size_.width, image + y * size_.width);
    }
  }

 private:
  // FFTW_ESTIMATE leaves the arrays as they are. A plan holds for all arrays as well aligned as
  // those it is made for; FFTW asks for no more than operator new gives.
  static constexpr unsigned how = FFTW_ESTIMATE;
  static_assert(__STDCPP_DEFAULT_NEW_ALIGNMENT__ >= 16);

  void plan_forward(fftw_complex* spectrum) {
    const std::lock_guard lock(fftw_planner());
    const int across[] = {size_.period_x}, down[] = {size_.period_y};
    rows_forward_.reset(fftw_plan_many_dft_r2c(1, across, size_.height, rows_.get(), nullptr, 1,
                                               size_.period_x, half_way_.get(), nullptr, 1,
                                               columns_, how));
    columns_forward_.reset(fftw_plan_many_dft(1, down, columns_, half_way_.get(), nullptr, columns_,
                                              1, spectrum, nullptr, 1, size_.period_y, FFTW_FORWARD,
                                              how));
  }

  void plan_inverse(fftw_complex* spectrum) {
    const std::lock_guard lock(fftw_planner());
    const int across[] = {size_.period_x}, down[] = {size_.period_y};
    rows_inverse_.reset(fftw_plan_many_dft_c2r(1, across, size_.height, half_way_.get(), nullptr, 1,
                                               columns_, rows_.get(), nullptr, 1, size_.period_x,
                                               how));
    columns_inverse_.reset(fftw_plan_many_dft(1, down, columns_, spectrum, nullptr, 1,
                                              size_.period_y, half_way_.get(), nullptr, columns_, 1,
                                              FFTW_BACKWARD, how));
  }

  PaddedSize size_;
  Index columns_;
  std::unique_ptr<double[], FftwDeleter> rows_;
  std::unique_ptr<fftw_complex[], FftwDeleter> half_way_;
  FftwPlan rows_forward_, rows_inverse_, columns_forward_, columns_inverse_;
};

}  // namespace detail

/// FFTW's transforms as an elastic layer's backend:
/// `ElasticLayer layer(camera, rest, gel, {.fourier = fftw_backend});`. The same answers to
/// rounding. Throws std::bad_alloc where memory runs out.
[[nodiscard]] inline std::unique_ptr<PaddedTransform> fftw_backend(const PaddedSize& size) {
  return std::make_unique<detail::FftwTransform>(size);
}

}  // namespace gelight
