#pragma once

#include <cstddef>
#include <cstdint>
// clang-format off
#if defined(__linux__)
# include <sys/mman.h>  // the blank keeps it here when the headers are joined into one
#endif
// clang-format on

namespace gelight::detail {

/// Has the system give memory that is about to be written, all of it, in one go: page by page, as
/// they are touched, it takes longer than what is then done there. No more becomes resident than
/// would have anyway.
inline void expect_writes([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  // Where pages are larger the system declines.
  constexpr std::uintptr_t page = 4096, large_page = std::uintptr_t{1} << 21,
                           worth_a_call = 4 * page;
  if (bytes < worth_a_call) return;
  const auto first = reinterpret_cast<std::uintptr_t>(begin);
  const auto advise = [&](std::uintptr_t step, int advice) {
    const std::uintptr_t from = (first + step - 1) / step * step;
    const std::uintptr_t to = (first + bytes) / step * step;
    if (from < to) madvise(static_cast<char*>(begin) + (from - first), to - from, advice);
  };
  advise(large_page, MADV_HUGEPAGE);
#if defined(MADV_POPULATE_WRITE)
  advise(page, MADV_POPULATE_WRITE);
#endif
#endif
}

}  // namespace gelight::detail
