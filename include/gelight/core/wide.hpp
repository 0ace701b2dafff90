#pragma once

#include <cstring>
#include <type_traits>
#include <utility>

// Loops over rows of pixels, compiled so that they are vectorised, for the processor's wider
// registers where it has them: `vectorised([&] { ... })` runs its work in a copy that is compiled
// with all that it calls for AVX-512 (by GCC), for AVX2, or in a plain one, as the processor is.
// Fused multiply-adds are left out: they round differently, and the same program shall give the
// same numbers on every processor. AVX-512 has them built in, and only GCC lets a function do
// without. Elsewhere than with GCC or Clang on x86-64 there is nothing to choose.
//
// At -O2, which is what most people build with, GCC's cost model (`very-cheap` since version 12, no
// vectorisation at all before) leaves nearly every one of these loops as it stands, which makes
// frames five times slower; so they ask for what -O3 does. Clang does so by itself.
#if defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__)
#define GELIGHT_ROWS __attribute__((flatten, optimize("tree-vectorize", "vect-cost-model=dynamic")))
#elif defined(__GNUC__)
#define GELIGHT_ROWS __attribute__((flatten))
#else
#define GELIGHT_ROWS
#endif
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__AVX2__)
#define GELIGHT_CHOOSES_REGISTERS
#endif
#if defined(GELIGHT_CHOOSES_REGISTERS) && !defined(__clang__) && defined(__OPTIMIZE__)
#define GELIGHT_CHOOSES_AVX512
#endif
#if defined(GELIGHT_CHOOSES_AVX512) || (defined(__AVX512F__) && defined(__AVX512VL__) && \
                                        defined(__AVX512BW__) && defined(__AVX512DQ__))
#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)  // before GCC 12 there is no word for halves
#define GELIGHT_HAS_EIGHT_LANES
#endif
#endif
#endif

namespace gelight::detail {

#if defined(GELIGHT_CHOOSES_REGISTERS)
template <class Work>
GELIGHT_ROWS __attribute__((target("avx2"))) auto run_wide(const Work& work) {
  return work();
}
#endif

#if defined(GELIGHT_CHOOSES_AVX512)
template <class Work>
__attribute__((flatten, target("avx512f,avx512vl,avx512bw,avx512dq"),
               optimize("tree-vectorize", "vect-cost-model=dynamic", "fp-contract=off"))) auto
run_widest(const Work& work) {
  return work();
}
[[nodiscard]] inline bool has_avx512() {
  return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
         __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512dq") != 0;
}
#endif

template <class Work>
GELIGHT_ROWS auto run_plain(const Work& work) {
  return work();
}

/// Does `work()`, loops over some rows of pixels; returns what it returns.
template <class Work>
auto vectorised(const Work& work) {
#if defined(GELIGHT_CHOOSES_AVX512)
  if (has_avx512()) return run_widest(work);
#endif
#if defined(GELIGHT_CHOOSES_REGISTERS)
  if (__builtin_cpu_supports("avx2") != 0) return run_wide(work);
#endif
  return run_plain(work);
}

/// Whether to work with several numbers of double precision at a time, in lanes: on x86-64 where
/// registers hold four. (In halves of four, drawing takes longer than number by number.)
[[nodiscard]] inline bool works_in_lanes() {
#if defined(GELIGHT_CHOOSES_REGISTERS)
  return __builtin_cpu_supports("avx2") != 0;
#elif defined(__GNUC__)
  return true;
#else
  return false;
#endif
}

/// As `vectorised` where there are lanes, for work with four numbers at a time, for which the
/// widest registers are of no use.
template <class Work>
auto vectorised_by_four(const Work& work) {
#if defined(GELIGHT_CHOOSES_REGISTERS)
  return run_wide(work);
#else
  return run_plain(work);
#endif
}

/// How many numbers of double precision a register holds, of the processor that is compiled for.
#if defined(__AVX512F__)
inline constexpr int register_width = 8;
#elif defined(__AVX__)
inline constexpr int register_width = 4;
#else
inline constexpr int register_width = 2;
#endif

/// As `vectorised`, for work that is told, by a constant, how many such numbers a register holds:
/// eight, four or two.
template <class Work>
auto vectorised_by_register(const Work& work) {
#if defined(GELIGHT_CHOOSES_AVX512)
  if (has_avx512()) return run_widest([&work] { return work(std::integral_constant<int, 8>()); });
#endif
#if defined(GELIGHT_CHOOSES_REGISTERS)
  if (__builtin_cpu_supports("avx2") != 0) {
    return run_wide([&work] { return work(std::integral_constant<int, 4>()); });
  }
#endif
  return run_plain([&work] { return work(std::integral_constant<int, register_width>()); });
}

/// The same for work that is told how many numbers to compute at a time, by a constant: eight where
/// registers hold them, and else four.
template <class Work>
auto vectorised_in_lanes(const Work& work) {
#if defined(GELIGHT_CHOOSES_AVX512) && defined(GELIGHT_HAS_EIGHT_LANES)
  if (has_avx512()) return run_widest([&work] { return work(std::integral_constant<int, 8>()); });
#elif defined(GELIGHT_HAS_EIGHT_LANES)
  return run_plain([&work] { return work(std::integral_constant<int, 8>()); });
#endif
  return vectorised_by_four([&work] { return work(std::integral_constant<int, 4>()); });
}

/// Takes numbers that lie one after the other into one of the compilers' types for several, which a
/// register holds, or puts them there.
///@{
#if defined(__GNUC__)
template <class Some>
struct InMemory {
  using Number = std::remove_cvref_t<decltype(std::declval<Some>()[0])>;
  // (A copy of bytes goes by halves of the register, which what was just stored is not ready for.)
  using type [[gnu::vector_size(sizeof(Some)), gnu::aligned(alignof(Number)), gnu::may_alias]] =
      Number;
};
template <class Some>
[[gnu::always_inline]] inline void load(Some& into, const void* from) {
  into = *static_cast<const typename InMemory<Some>::type*>(from);
}
template <class Some>
[[gnu::always_inline]] inline void store(const Some& from, void* into) {
  *static_cast<typename InMemory<Some>::type*>(into) = from;
}
#else
template <class Some>
void load(Some& into, const void* from) {
  std::memcpy(&into, from, sizeof into);
}
template <class Some>
void store(const Some& from, void* into) {
  std::memcpy(into, &from, sizeof from);
}
#endif
///@}

}  // namespace gelight::detail
