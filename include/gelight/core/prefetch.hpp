#pragma once

#include <cstddef>
#include <cstdint>

namespace gelight::detail {

/// Has the processor begin to fetch what lies there, where the compiler has a word for it. (Always
/// inlined: GCC 12 leaves out calls of a function that does nothing but fetch.)
[[gnu::always_inline]] inline void prefetch([[maybe_unused]] const void* begin,
                                            [[maybe_unused]] std::size_t bytes) {
#if defined(__GNUC__)
  constexpr std::size_t line = 64;
  for (std::size_t at = 0; at < bytes; at += line) {
    __builtin_prefetch(static_cast<const char*>(begin) + at);
  }
#endif
}

}  // namespace gelight::detail
