#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// A queue of vertices in about the order of their distances: those within one width of each other
/// come out in any order. For solvers that correct what they did too early, that is enough, and an
/// insertion costs as much as appending to an array.
class BucketQueue {
 public:
  /// Keys are not negative; one pushed is not more than `reach` above the last one popped.
  BucketQueue(double width, double reach)
      : scale_(1 / width), buckets_(static_cast<std::size_t>(reach / width) + 2) {}

  void push(Index vertex, double key) {
    const auto number = std::max(static_cast<std::size_t>(key * scale_), front_);
    buckets_[number % buckets_.size()].emplace_back(vertex, key);
    ++count_;
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }

  /// A vertex and the key it was pushed with, which may have been bettered since.
  std::pair<Index, double> pop() {
    while (buckets_[front_ % buckets_.size()].empty()) ++front_;
    auto& bucket = buckets_[front_ % buckets_.size()];
    const auto entry = bucket.back();
    bucket.pop_back();
    --count_;
    return entry;
  }

 private:
  double scale_;
  std::size_t front_ = 0;  // number of the bucket in turn, counted without wrapping round
  std::size_t count_ = 0;
  std::vector<std::vector<std::pair<Index, double>>> buckets_;
};

}  // namespace gelight::detail
