#pragma once

#include <cstddef>

#include "gelight/core/array.hpp"
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

template <class T>
using Lines = Array<T, line_bytes>;

}  // namespace gelight::detail
