#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"

// Types that hold a number for each of several pixels, with what C++ does with one number done with
// each. GCC and Clang have them for all processors; elsewhere pixels are drawn one by one.
#if defined(__GNUC__)
namespace gelight::detail {

template <class T, Index count>
struct LanesType {
  using type [[gnu::vector_size(count * sizeof(T))]] = T;
};
template <class T, Index count>
using Lanes = typename LanesType<T, count>::type;
template <class T>
using Four = Lanes<T, 4>;

/// Four rows of four numbers become four columns.
[[gnu::always_inline]] inline void transpose(Four<double>& a, Four<double>& b, Four<double>& c,
                                             Four<double>& d) {
#if defined(__clang__) || __GNUC__ >= 12
  const Four<double> ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Four<double> ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four<double> cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Four<double> cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
#else
  const Four<double> row_a = a, row_b = b, row_c = c, row_d = d;
  a = Four<double>{row_a[0], row_b[0], row_c[0], row_d[0]};
  b = Four<double>{row_a[1], row_b[1], row_c[1], row_d[1]};
  c = Four<double>{row_a[2], row_b[2], row_c[2], row_d[2]};
  d = Four<double>{row_a[3], row_b[3], row_c[3], row_d[3]};
#endif
}

#if defined(GELIGHT_HAS_EIGHT_LANES)
template <class T>
using Eight = Lanes<T, 8>;
#endif

/// A bit for each lane in which a comparison holds.
template <class Holds>
[[gnu::always_inline]] inline std::uint64_t bits_of(const Holds& holds) {
  using Whole [[maybe_unused]] = std::remove_cvref_t<decltype(holds[0])>;
#if defined(GELIGHT_HAS_EIGHT_LANES)
  if constexpr (sizeof(Holds) == sizeof(Eight<Whole>)) {
    return bits_of(__builtin_shufflevector(holds, holds, 0, 1, 2, 3)) |
           bits_of(__builtin_shufflevector(holds, holds, 4, 5, 6, 7)) << 4;
  } else
#endif
  {
#if defined(__SSE__)
    const auto signs = __builtin_convertvector(holds, Four<std::int32_t>);
    return static_cast<std::uint64_t>(
        __builtin_ia32_movmskps(reinterpret_cast<Four<float>>(signs)));
#else
    const Four<Whole> bits = holds & Four<Whole>{1, 2, 4, 8};
    return static_cast<std::uint64_t>((bits[0] | bits[2]) | (bits[1] | bits[3]));
#endif
  }
}

/// The lanes' numbers 0, 1, 2 ...
///@{
template <Index count>
struct LaneNumbers;
template <>
struct LaneNumbers<4> {
  static constexpr Four<double> all{0, 1, 2, 3};
};
#if defined(GELIGHT_HAS_EIGHT_LANES)
template <>
struct LaneNumbers<8> {
  static constexpr Eight<double> all{0, 1, 2, 3, 4, 5, 6, 7};
};
#endif
///@}

}  // namespace gelight::detail
#endif
