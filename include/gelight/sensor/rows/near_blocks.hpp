#pragma once

#include <algorithm>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/rows/row_runs.hpp"

namespace gelight::detail {

/// The blocks of an image that lie near to some of its pixels: no more than so many rows and
/// columns away.
class NearBlocks {
 public:
  NearBlocks() = default;
  NearBlocks(Index width, Index height, Index reach)
      : width_(width),
        height_(height),
        reach_(reach),
        newest_(static_cast<std::size_t>(block_count(width))),
        marks_(newest_.size() * static_cast<std::size_t>(height)),
        is_near_(static_cast<std::size_t>(height)) {}

  [[nodiscard]] Index reach() const { return reach_; }

  /// Whether any block of row y is near, and which of them are.
  ///@{
  [[nodiscard]] bool any(Index y) const { return is_near_[y] != 0; }
  [[nodiscard]] const char* row(Index y) const {
    return marks_.data() + std::ptrdiff_t{y} * block_count(width_);
  }
  ///@}

  /// Forgets all pixels; `everything` has all blocks be near.
  void reset(bool everything) {
    std::fill(newest_.begin(), newest_.end(), -reach_ - 1);
    std::fill(marks_.begin(), marks_.end(), static_cast<char>(everything));
    std::fill(is_near_.begin(), is_near_.end(), static_cast<char>(everything));
  }

  /// Adds pixels `first` to `last` of row y, which come row after row, and marks the blocks of
  /// that row that are near to them in `marks`.
  void add(Index y, Index first, Index last, char* marks) {
    const Index begin = std::max(Index{0}, first - reach_) / block_size;
    const Index end = std::min(width_ - 1, last + reach_) / block_size + 1;
    std::fill(marks + begin, marks + end, char{1});
    for (Index block = begin; block < end; ++block) mark_column(block, y);
  }

 private:
  // Marks a block in the rows near to row y, but for those that were near to an older one.
  void mark_column(Index block, Index y) {
    const Index first = std::max({Index{0}, y - reach_, newest_[block] + reach_ + 1});
    const Index last = std::min(height_ - 1, y + reach_);
    for (Index row = first; row <= last; ++row) {
      marks_[std::ptrdiff_t{row} * block_count(width_) + block] = 1;
      is_near_[row] = 1;
    }
    newest_[block] = y;
  }

  Index width_ = 0, height_ = 0, reach_ = 0;
  Array<Index> newest_;  // of each block: the last row whose pixels are near to it
  Array<char> marks_;    // of each block of each row
  Array<char> is_near_;  // of each row
};

}  // namespace gelight::detail
