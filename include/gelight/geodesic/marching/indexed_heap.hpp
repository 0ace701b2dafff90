#pragma once

#include <concepts>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// A 4-ary heap of numbers 0 to n-1, each at most once, ordered by a key and then by the number, so
/// that equal keys cannot be confused.
template <std::floating_point Real>
class IndexedHeap {
 public:
  /// Empties the heap and makes room for the numbers below `count`.
  void reset(Index count) {
    items_.clear();
    place_.assign(static_cast<std::size_t>(count), absent);
  }

  [[nodiscard]] bool empty() const { return items_.empty(); }

  /// Inserts a number, or moves it to a smaller key.
  void push(Index number, Real key) {
    Index hole = place_[number];
    if (hole == absent) {
      hole = static_cast<Index>(items_.size());
      items_.push_back({});
    }
    sift_up(hole, {key, number});
  }

  /// The number with the smallest key.
  [[nodiscard]] Index top() const { return items_[0].number; }

  /// Removes the number with the smallest key and returns it.
  Index pop() {
    const Index top = items_[0].number;
    place_[top] = absent;
    const Item last = items_.back();
    items_.pop_back();
    if (!items_.empty()) sift_down(last);
    return top;
  }

 private:
  static constexpr Index absent = -1;
  static constexpr Index arity = 4;

  struct Item {
    Real key;
    Index number;
    [[nodiscard]] bool before(const Item& other) const {
      return key < other.key || (key == other.key && number < other.number);
    }
  };

  void sift_up(Index hole, const Item& item) {
    while (hole > 0) {
      const Index parent = (hole - 1) / arity;
      if (!item.before(items_[parent])) break;
      put(hole, items_[parent]);
      hole = parent;
    }
    put(hole, item);
  }

  void sift_down(const Item& item) {
    const auto count = static_cast<Index>(items_.size());
    Index hole = 0;
    for (;;) {
      const Index first = arity * hole + 1;
      if (first >= count) break;
      const Index last = first + arity < count ? first + arity : count;
      Index least = first;
      for (Index child = first + 1; child < last; ++child) {
        if (items_[child].before(items_[least])) least = child;
      }
      if (!items_[least].before(item)) break;
      put(hole, items_[least]);
      hole = least;
    }
    put(hole, item);
  }

  void put(Index hole, const Item& item) {
    items_[hole] = item;
    place_[item.number] = hole;
  }

  Array<Item> items_;
  Array<Index> place_;  // of each number, or absent
};

}  // namespace gelight::detail
