#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#if defined(__AVX__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace gelight::detail {

/// Four numbers that are worked on at once, in the processor's registers where those are known.
/// (Array expressions do the same, and take a second to compile; compilers' own vector types are
/// slow where the processor has no registers of four numbers.) `min` and `max` are those of the
/// standard library, of numbers that are none, too. `less` has a bit for each number, the lowest
/// for the first; `if_less` takes each number from one or the other as a < b or not.
class Lane {
 public:
  static constexpr std::ptrdiff_t size = 4;

  friend Lane abs(Lane a) { return max(a, 0.0 - a); }

#if defined(__AVX__)
  Lane(double x) : all_(_mm256_set1_pd(x)) {}
  Lane(double a, double b, double c, double d) : all_(_mm256_setr_pd(a, b, c, d)) {}
  static Lane load(const double* x) { return Lane(_mm256_loadu_pd(x)); }
  void store(double* x) const { _mm256_storeu_pd(x, all_); }

  friend Lane operator+(Lane a, Lane b) { return Lane(_mm256_add_pd(a.all_, b.all_)); }
  friend Lane operator-(Lane a, Lane b) { return Lane(_mm256_sub_pd(a.all_, b.all_)); }
  friend Lane operator*(Lane a, Lane b) { return Lane(_mm256_mul_pd(a.all_, b.all_)); }
  friend Lane operator/(Lane a, Lane b) { return Lane(_mm256_div_pd(a.all_, b.all_)); }
  friend Lane min(Lane a, Lane b) { return Lane(_mm256_min_pd(b.all_, a.all_)); }
  friend Lane max(Lane a, Lane b) { return Lane(_mm256_max_pd(b.all_, a.all_)); }
  friend Lane sqrt(Lane a) { return Lane(_mm256_sqrt_pd(a.all_)); }
  friend unsigned less(Lane a, Lane b) {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(a.all_, b.all_, _CMP_LT_OQ)));
  }
  friend Lane if_less(Lane a, Lane b, Lane then, Lane otherwise) {
    return Lane(
        _mm256_blendv_pd(otherwise.all_, then.all_, _mm256_cmp_pd(a.all_, b.all_, _CMP_LT_OQ)));
  }

 private:
  explicit Lane(__m256d all) : all_(all) {}
  __m256d all_;
#elif defined(__SSE2__)
  Lane(double x) : low_(_mm_set1_pd(x)), high_(low_) {}
  Lane(double a, double b, double c, double d)
      : low_(_mm_setr_pd(a, b)), high_(_mm_setr_pd(c, d)) {}
  static Lane load(const double* x) { return {_mm_loadu_pd(x), _mm_loadu_pd(x + 2)}; }
  void store(double* x) const {
    _mm_storeu_pd(x, low_);
    _mm_storeu_pd(x + 2, high_);
  }

  friend Lane operator+(Lane a, Lane b) {
    return {_mm_add_pd(a.low_, b.low_), _mm_add_pd(a.high_, b.high_)};
  }
  friend Lane operator-(Lane a, Lane b) {
    return {_mm_sub_pd(a.low_, b.low_), _mm_sub_pd(a.high_, b.high_)};
  }
  friend Lane operator*(Lane a, Lane b) {
    return {_mm_mul_pd(a.low_, b.low_), _mm_mul_pd(a.high_, b.high_)};
  }
  friend Lane operator/(Lane a, Lane b) {
    return {_mm_div_pd(a.low_, b.low_), _mm_div_pd(a.high_, b.high_)};
  }
  friend Lane min(Lane a, Lane b) {
    return {_mm_min_pd(b.low_, a.low_), _mm_min_pd(b.high_, a.high_)};
  }
  friend Lane max(Lane a, Lane b) {
    return {_mm_max_pd(b.low_, a.low_), _mm_max_pd(b.high_, a.high_)};
  }
  friend Lane sqrt(Lane a) { return {_mm_sqrt_pd(a.low_), _mm_sqrt_pd(a.high_)}; }
  friend unsigned less(Lane a, Lane b) {
    return static_cast<unsigned>(_mm_movemask_pd(_mm_cmplt_pd(a.low_, b.low_)) |
                                 _mm_movemask_pd(_mm_cmplt_pd(a.high_, b.high_)) << 2);
  }
  friend Lane if_less(Lane a, Lane b, Lane then, Lane otherwise) {
    return {chosen(_mm_cmplt_pd(a.low_, b.low_), then.low_, otherwise.low_),
            chosen(_mm_cmplt_pd(a.high_, b.high_), then.high_, otherwise.high_)};
  }

 private:
  static __m128d chosen(__m128d mask, __m128d then, __m128d otherwise) {
    return _mm_or_pd(_mm_and_pd(mask, then), _mm_andnot_pd(mask, otherwise));
  }
  Lane(__m128d low, __m128d high) : low_(low), high_(high) {}
  __m128d low_, high_;
#else
  Lane(double x) : all_{x, x, x, x} {}
  Lane(double a, double b, double c, double d) : all_{a, b, c, d} {}
  static Lane load(const double* x) {
    Lane out(0);
    std::copy_n(x, size, out.all_);
    return out;
  }
  void store(double* x) const { std::copy_n(all_, size, x); }

  friend Lane operator+(Lane a, Lane b) {
    return each(a, b, [](double x, double y) { return x + y; });
  }
  friend Lane operator-(Lane a, Lane b) {
    return each(a, b, [](double x, double y) { return x - y; });
  }
  friend Lane operator*(Lane a, Lane b) {
    return each(a, b, [](double x, double y) { return x * y; });
  }
  friend Lane operator/(Lane a, Lane b) {
    return each(a, b, [](double x, double y) { return x / y; });
  }
  friend Lane min(Lane a, Lane b) {
    return each(a, b, [](double x, double y) { return y < x ? y : x; });
  }
  friend Lane max(Lane a, Lane b) {
    return each(a, b, [](double x, double y) { return x < y ? y : x; });
  }
  friend Lane sqrt(Lane a) {
    return each(a, a, [](double x, double) { return std::sqrt(x); });
  }
  friend unsigned less(const Lane& a, const Lane& b) {
    unsigned bits = 0;
    for (std::ptrdiff_t i = 0; i < size; ++i) bits |= (a.all_[i] < b.all_[i] ? 1U : 0U) << i;
    return bits;
  }
  friend Lane if_less(const Lane& a, const Lane& b, Lane then, const Lane& otherwise) {
    for (std::ptrdiff_t i = 0; i < size; ++i) {
      if (!(a.all_[i] < b.all_[i])) then.all_[i] = otherwise.all_[i];
    }
    return then;
  }

 private:
  static Lane each(Lane a, const Lane& b, const auto& apply) {
    for (std::ptrdiff_t i = 0; i < size; ++i) a.all_[i] = apply(a.all_[i], b.all_[i]);
    return a;
  }
  double all_[size];
#endif
};

/// A bit for each of a lane's numbers, of which so many count.
[[nodiscard]] inline unsigned first_bits(std::ptrdiff_t count) {
  return (1U << std::min(count, Lane::size)) - 1;
}

}  // namespace gelight::detail
