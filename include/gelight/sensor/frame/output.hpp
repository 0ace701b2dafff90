#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/views/image_view.hpp"

// What renderers write to.
namespace gelight::detail {

/// Throws InvalidInput where the output lies in the memory of an input that has any; `what` names
/// the input.
template <class P, class I>
void require_apart(ImageView<P> out, const I& input, const char* what) {
  const auto check = [&](const auto& view) {
    const auto [first, last] = byte_range(out);
    const auto [input_first, input_last] = byte_range(view);
    require(last <= input_first || input_last <= first, "the output image lies in the memory of ",
            what);
  };
  if constexpr (requires { input.view(); }) {
    check(input.view());
  } else if constexpr (requires { input.row_bytes(); }) {
    check(input);
  }
}

/// Writes a run of row y, of which `packed` holds red, green and blue from the lowest byte up.
inline void write_run(ImageView<Rgb8> out, const std::int32_t* packed, Index y, const Run& run) {
  Index x = run.begin;
  if (std::endian::native == std::endian::little && out.rows_are_packed()) {
    auto* bytes = reinterpret_cast<unsigned char*>(out.row(y) + x);
    const auto put = [&bytes](std::uint32_t word) {
      std::memcpy(bytes, &word, 4);
      bytes += 4;
    };
    const auto pixel = [packed](Index i) { return static_cast<std::uint32_t>(packed[i]); };
    for (; x + 4 <= run.end; x += 4) {  // four pixels are three words
      put(pixel(x) | pixel(x + 1) << 24);
      put(pixel(x + 1) >> 8 | pixel(x + 2) << 16);
      put(pixel(x + 2) >> 16 | pixel(x + 3) << 8);
    }
  }
  for (; x < run.end; ++x) {
    const auto rgb = static_cast<std::uint32_t>(packed[x]);
    out(x, y) = {static_cast<std::uint8_t>(rgb), static_cast<std::uint8_t>(rgb >> 8),
                 static_cast<std::uint8_t>(rgb >> 16)};
  }
}

}  // namespace gelight::detail
