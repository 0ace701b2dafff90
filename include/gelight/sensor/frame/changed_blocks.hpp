#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <iterator>

#include "gelight/concepts/image.hpp"
#include "gelight/concepts/membrane.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// The blocks of an image that differ from the last one.
class ChangedBlocks {
 public:
  ChangedBlocks(Index width, Index height)
      : width_(width),
        height_(height),
        blocks_(block_count(width)),
        marks_(static_cast<std::size_t>(blocks_) * static_cast<std::size_t>(height)),
        has_marks_(static_cast<std::size_t>(height)),
        scratch_(static_cast<std::size_t>(blocks_)) {}

  /// Compares `image` with `last`, number by number, and makes `last` the same; whether anything
  /// differs. `buffer` has room for a row.
  template <std::floating_point T, ImageOf<T> D>
  bool update(Image<T>& last, const D& image, T* buffer) {
    bool any = false;
    window_ = {width_, height_, 0, 0};
    for (Index y = 0; y < height_; ++y) {
      const T* const row = row_of(image, y, buffer, width_);
      T* const before = last.row(y);
      char* const marks = row_marks(y);
      char differs = 0;
      for (Index b = 0; b < blocks_; ++b) {
        const Index begin = b * block_size, count = std::min(block_size, width_ - begin);
        const auto bytes = static_cast<std::size_t>(count) * sizeof(T);
        marks[b] = std::memcmp(before + begin, row + begin, bytes) != 0;
        differs |= marks[b];
        if (marks[b] == 0) continue;
        window_ = {std::min(window_.left, begin), std::min(window_.top, y),
                   std::max(window_.right, begin + count), y + 1};
      }
      has_marks_[static_cast<std::size_t>(y)] = differs;
      if (differs == 0) continue;
      std::copy_n(row, width_, before);
      any = true;
    }
    return any;
  }

  /// Where anything differs: all of it lies in these pixels.
  [[nodiscard]] const Window& window() const { return window_; }

  /// Marks the blocks of rows `first` to `last` that are within so many rows and blocks of one that
  /// differs.
  void mark_near(Array<char>& near, Index first, Index last, Index rows, Index blocks) {
    std::fill(near.begin(), near.end(), char{0});
    for (Index y = std::max(Index{0}, first - rows); y <= std::min(height_ - 1, last + rows); ++y) {
      if (has_marks_[static_cast<std::size_t>(y)] == 0) continue;
      add_marks(near.data(), row_marks(y), blocks_);
    }
    for (Index step = 0; step < std::min(blocks, blocks_); ++step) {
      std::copy(near.begin(), near.end(), scratch_.begin());
      mark_around(near.data(), scratch_.data(), std::ssize(near));
    }
  }

 private:
  [[nodiscard]] char* row_marks(Index y) {
    return marks_.data() + static_cast<std::ptrdiff_t>(y) * blocks_;
  }

  Index width_, height_, blocks_;
  Window window_;
  Array<char> marks_, has_marks_, scratch_;
};

}  // namespace gelight::detail
