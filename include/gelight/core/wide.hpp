#pragma once

// Code for the processor's wider registers, chosen when it runs. A function marked GELIGHT_WIDE is
// compiled with all that it calls for AVX2; it may be called where has_wide_registers() says so.
// Fused multiply-adds are left out: they round differently, and the same program shall give the
// same numbers on every processor. Elsewhere than with GCC or Clang on x86-64 there is nothing to
// choose.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__AVX2__)
#define GELIGHT_WIDE __attribute__((target("avx2"), flatten))
#else
#define GELIGHT_WIDE
#endif

namespace gelight::detail {

[[nodiscard]] inline bool has_wide_registers() {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__AVX2__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

}  // namespace gelight::detail
