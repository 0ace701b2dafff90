#pragma once

#include <type_traits>

namespace gelight::detail {

/// The bits of a number read as another type of the same size: std::bit_cast, which not every
/// standard library has that comes with a compiler for C++20 (Emscripten's has none), by what that
/// is made of.
template <class To, class From>
requires(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To> &&
         std::is_trivially_copyable_v<From>) [[nodiscard]] constexpr To bit_cast(const From& from) {
  return __builtin_bit_cast(To, from);
}

}  // namespace gelight::detail
