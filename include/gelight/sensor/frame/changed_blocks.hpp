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
#include "gelight/sensor/rows/near_blocks.hpp"
#include "gelight/sensor/rows/row_runs.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight::detail {

/// The blocks of an image that may look otherwise than in the last one.
class ChangedBlocks {
 public:
  /// `reach` is how many rows and columns away, at most, a depth changes what is seen.
  ChangedBlocks(Index width, Index height, Index reach)
      : width_(width),
        height_(height),
        near_(width, height, reach),
        needed_(static_cast<std::size_t>(height)),
        columns_(static_cast<std::size_t>(block_count(width))),
        marks_(columns_.size()) {
    runs_.reserve(columns_.size());
  }

  /// Compares `image` with `last`, number by number, and makes `last` the same; whether anything
  /// differs. `buffer` has room for a row.
  template <std::floating_point T, ImageOf<T> D>
  bool update(Image<T>& last, const D& image, T* buffer) {
    near_.reset(false);
    bool any = false;
    const auto row_bytes = static_cast<std::size_t>(width_) * sizeof(T);
    for (Index y = 0; y < height_; ++y) {
      const T* const row = row_of(image, y, buffer, width_);
      if (std::memcmp(last.row(y), row, row_bytes) == 0) continue;
      add_row(last.row(y), row, y);
      std::copy_n(row, width_, last.row(y));
      any = true;
    }
    if (any) gather();
    return any;
  }

  /// Whether anything of row y may look otherwise, and which blocks.
  ///@{
  [[nodiscard]] bool any(Index y) const { return near_.any(y); }
  [[nodiscard]] const char* row(Index y) const { return near_.row(y); }
  ///@}

  /// Whether the depths of row y count for any of them.
  [[nodiscard]] bool is_needed(Index y) const { return needed_[y] != 0; }
  /// The blocks of any row, and those beside them.
  [[nodiscard]] const char* columns() const { return columns_.data(); }
  /// Where all of them lie, with a row more above and below and a block on either side.
  [[nodiscard]] const Window& window() const { return window_; }

  /// Marks the blocks of rows `first` to `last`, and those beside them.
  void mark_beside(Array<char>& beside, Index first, Index last) {
    std::fill(marks_.begin(), marks_.end(), char{0});
    for (Index y = std::max(Index{0}, first); y <= std::min(height_ - 1, last); ++y) {
      if (near_.any(y)) add_marks(marks_.data(), near_.row(y), std::ssize(marks_));
    }
    std::fill(beside.begin(), beside.end(), char{0});
    mark_around(beside.data(), marks_.data(), std::ssize(marks_));
  }

 private:
  // Marks what is near to the pixels of row y that differ.
  template <class T>
  void add_row(const T* before, const T* row, Index y) {
    const auto differ = [&](Index begin, Index count) {
      return std::memcmp(before + begin, row + begin,
                         static_cast<std::size_t>(count) * sizeof(T)) != 0;
    };
    for (Index b = 0; b < std::ssize(marks_); ++b) {
      const Index begin = b * block_size;
      marks_[b] = differ(begin, std::min(block_size, width_ - begin));
    }
    gather_runs(runs_, marks_.data(), width_);
    for (const Run& run : runs_) {
      Index first = run.begin, end = run.end;
      while (!differ(first, 1)) ++first;
      while (!differ(end - 1, 1)) --end;
      near_.add(y, first, end - 1, marks_.data());
    }
  }

  // What follows from the blocks of all rows.
  void gather() {
    const Index reach = near_.reach();
    Index next = 0, top = height_, bottom = 0;
    std::fill(needed_.begin(), needed_.end(), char{0});
    std::fill(marks_.begin(), marks_.end(), char{0});
    for (Index y = 0; y < height_; ++y) {
      if (!near_.any(y)) continue;
      add_marks(marks_.data(), near_.row(y), std::ssize(marks_));
      for (next = std::max(next, y - reach); next < std::min(height_, y + reach + 1); ++next) {
        needed_[next] = 1;
      }
      top = std::min(top, y);
      bottom = y + 1;
    }
    std::fill(columns_.begin(), columns_.end(), char{0});
    mark_around(columns_.data(), marks_.data(), std::ssize(marks_));
    const auto marked = [](char mark) { return mark != 0; };
    const auto left = std::find_if(columns_.begin(), columns_.end(), marked) - columns_.begin();
    auto right = std::ssize(columns_);
    while (columns_[right - 1] == 0) --right;
    window_ = {static_cast<Index>(left) * block_size, std::max(Index{0}, top - 1),
               std::min(width_, static_cast<Index>(right) * block_size),
               std::min(height_, bottom + 1)};
  }

  Index width_, height_;
  NearBlocks near_;
  Window window_;
  Array<char> needed_;           // of each row
  Array<char> columns_, marks_;  // of each block of a row
  Array<Run> runs_;
};

}  // namespace gelight::detail
