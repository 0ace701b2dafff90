#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Windows on one half-edge, structure of arrays. A window holds the points of the edge with
/// begin <= x <= end that a straight line reaches from the image of its origin at (x, y), y <= 0.
struct WindowList {
  Array<double> begin, end;  // along the half-edge, from its origin
  Array<double> x, y;        // where the origin lies, unfolded into the half-edge's plane
  Array<double> start;       // the distance at the origin
  Array<Index> origin;       // which source or bend of the path the windows come from

  [[nodiscard]] std::ptrdiff_t size() const { return std::ssize(begin); }

  void clear() { resize(0); }

  void resize(std::ptrdiff_t count) {
    const auto n = static_cast<std::size_t>(count);
    for (auto* column : {&begin, &end, &x, &y, &start}) column->resize(n);
    origin.resize(n);
  }

  void push(double b, double e, double px, double py, double s, Index o) {
    begin.push_back(b);
    end.push_back(e);
    x.push_back(px);
    y.push_back(py);
    start.push_back(s);
    origin.push_back(o);
  }

  void copy(std::ptrdiff_t to, const WindowList& from, std::ptrdiff_t i) {
    begin[to] = from.begin[i];
    end[to] = from.end[i];
    x[to] = from.x[i];
    y[to] = from.y[i];
    start[to] = from.start[i];
    origin[to] = from.origin[i];
  }

  void move(std::ptrdiff_t to, std::ptrdiff_t i) {
    if (to != i) copy(to, *this, i);
  }
};

/// The windows that wait on each half-edge, in blocks of fixed size that are used again.
class WindowStore {
 public:
  void reset(Index halfedges) {
    head_.assign(static_cast<std::size_t>(halfedges), none);
    blocks_.clear();
    free_ = none;
  }

  [[nodiscard]] bool empty(Index h) const { return head_[h] == none; }

  /// Adds windows [first, last) of a list to those on a half-edge.
  void add(Index h, const WindowList& list) {
    for (std::ptrdiff_t done = 0; done < list.size();) {
      const auto count = std::min<std::ptrdiff_t>(list.size() - done, Block::capacity);
      const Index b = take();
      Block& block = blocks_[b];
      copy(list, done, count, block);
      block.count = static_cast<Index>(count);
      block.next = head_[h];
      head_[h] = b;
      done += count;
    }
  }

  /// Moves all windows on a half-edge to the end of a list; their starts are not stored.
  void take_all(Index h, WindowList& list) {
    for (Index b = head_[h]; b != none;) {
      Block& block = blocks_[b];
      for (Index i = 0; i < block.count; ++i) {
        list.push(block.begin[at(i)], block.end[at(i)], block.x[at(i)], block.y[at(i)],
                  block.start[at(i)], block.origin[at(i)]);
      }
      const Index next = block.next;
      block.next = free_;
      free_ = b;
      b = next;
    }
    head_[h] = none;
  }

 private:
  static constexpr Index none = -1;

  struct Block {
    static constexpr std::ptrdiff_t capacity = 16;
    std::array<double, capacity> begin, end, x, y, start;
    std::array<Index, capacity> origin;
    Index count, next;
  };

  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

  static void copy(const WindowList& list, std::ptrdiff_t first, std::ptrdiff_t count,
                   Block& block) {
    std::copy_n(&list.begin[first], count, block.begin.begin());
    std::copy_n(&list.end[first], count, block.end.begin());
    std::copy_n(&list.x[first], count, block.x.begin());
    std::copy_n(&list.y[first], count, block.y.begin());
    std::copy_n(&list.start[first], count, block.start.begin());
    std::copy_n(&list.origin[first], count, block.origin.begin());
  }

  Index take() {
    if (free_ == none) {
      blocks_.emplace_back();
      return static_cast<Index>(std::ssize(blocks_) - 1);
    }
    const Index b = free_;
    free_ = blocks_[b].next;
    return b;
  }

  Array<Index> head_;  // of each half-edge: its first block
  Array<Block> blocks_;
  Index free_ = none;
};

}  // namespace gelight::detail
