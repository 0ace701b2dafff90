#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "gelight/core/types.hpp"

// Memory that begins with a line of the cache: vectors read from elsewhere lie half of the time on
// two lines, which takes twice as long.
namespace gelight::detail {

inline constexpr std::size_t line_bytes = 64;

/// How many numbers of a type a line of the cache holds.
template <class T>
inline constexpr Index line_size = Index{line_bytes / sizeof(T)};

/// So many numbers, and as many more as fill their last line.
template <class T>
[[nodiscard]] constexpr std::ptrdiff_t whole_lines(Index count) {
  return std::ptrdiff_t{(count + line_size<T> - 1) / line_size<T>} * line_size<T>;
}

/// Gives memory that begins with a line.
template <class T>
struct LineAllocator {
  using value_type = T;

  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>&) {}

  [[nodiscard]] T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{line_bytes}));
  }
  void deallocate(T* memory, std::size_t) {
    ::operator delete (memory, std::align_val_t{line_bytes});
  }

  friend bool operator==(const LineAllocator&, const LineAllocator&) { return true; }
};

template <class T>
using Lines = std::vector<T, LineAllocator<T>>;

}  // namespace gelight::detail
