#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
// clang-format off
#if defined(__linux__)
# include <sys/mman.h>  // the blank keeps it here when the headers are joined into one
#endif
// clang-format on

#include "gelight/core/pages.hpp"

namespace gelight::detail {

struct FreeMemory {
  void operator()(void* memory) const { std::free(memory); }
};

/// Values that nobody has written yet.
template <class T>
using LargeArray = std::unique_ptr<T[], FreeMemory>;

/// Room for values that are trivial to make and to end, on large pages where the system has them:
/// on small ones the first touch of a factor's memory took half as long as its arithmetic.
template <class T>
[[nodiscard]] LargeArray<T> large_array(std::ptrdiff_t count) {
  const std::size_t bytes = static_cast<std::size_t>(count) * sizeof(T);
  void* memory = nullptr;
#if defined(__linux__)
  constexpr std::size_t page = std::size_t{1} << 21;
  if (bytes >= page) {
    // What does not fill a large page lies on small ones, or the rest of it would be taken, too.
    if (posix_memalign(&memory, page, bytes) != 0) memory = nullptr;
    if (memory != nullptr) madvise(memory, bytes / page * page, MADV_HUGEPAGE);
  }
#endif
  if (memory == nullptr) {
    memory = std::malloc(bytes);
    if (memory == nullptr) throw std::bad_alloc();
    expect_writes(memory, bytes);
  }
  return LargeArray<T>(static_cast<T*>(memory));
}

}  // namespace gelight::detail
