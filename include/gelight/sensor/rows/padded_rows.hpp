#pragma once

#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/sensor/rows/lines.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// An image with a pixel more on each side. Rows begin with a line of the cache.
template <class T>
class PaddedRows {
 public:
  PaddedRows() = default;
  PaddedRows(Index width, Index height)
      : width_(width),
        height_(height),
        numbers_(static_cast<std::size_t>(stride(width) * (height + 2))) {}

  /// From a row to the next: a line, of which they have the last pixel, comes before each, and they
  /// have a pixel behind their last whole block.
  [[nodiscard]] static std::ptrdiff_t stride(Index width) {
    return line_size<T> + whole_lines<T>(whole_blocks(width) + 1);
  }

  /// Pixel (0, y), y from -1 to the height.
  ///@{
  [[nodiscard]] T* row(Index y) { return numbers_.data() + offset(y); }
  [[nodiscard]] const T* row(Index y) const { return numbers_.data() + offset(y); }
  ///@}

  /// The image without what is beside it.
  ///@{
  [[nodiscard]] ImageView<T> view() { return {row(0), width_, height_, stride(width_)}; }
  [[nodiscard]] ImageView<const T> view() const {
    return {row(0), width_, height_, stride(width_)};
  }
  ///@}

 private:
  [[nodiscard]] std::ptrdiff_t offset(Index y) const {
    return stride(width_) * (y + 1) + line_size<T>;
  }

  Index width_ = 0, height_ = 0;
  Lines<T> numbers_;
};

}  // namespace gelight::detail
