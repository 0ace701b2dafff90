#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// A queue of vertices in about the order of their distances: those within a third of an edge of
/// each other come out in any order, and one pushed far ahead may come out early. For solvers that
/// correct what they did too early that is enough, and a push costs no more than an array's.
class BucketQueue {
 public:
  /// Empties the queue. Keys are not negative; `mean_edge` is about what a vertex adds to the
  /// distance of the last.
  void reset(double mean_edge) {
    scale_ = mean_edge > 0 ? buckets_per_edge / mean_edge : 1;
    front_ = count_ = 0;
    buckets_.resize(bucket_count);
    for (auto& bucket : buckets_) bucket.clear();
  }

  void push(Index vertex, double key) {
    const auto number = static_cast<std::size_t>(std::min(key * scale_, largest_number));
    buckets_[std::max(number, front_) % bucket_count].emplace_back(vertex, key);
    ++count_;
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }

  /// A vertex and the key it was pushed with, which may have been bettered since.
  std::pair<Index, double> pop() {
    while (buckets_[front_ % bucket_count].empty()) ++front_;
    auto& bucket = buckets_[front_ % bucket_count];
    const auto entry = bucket.back();
    bucket.pop_back();
    --count_;
    return entry;
  }

 private:
  static constexpr double buckets_per_edge = 3;
  static constexpr std::size_t bucket_count = 256;  // the buckets in use form a ring
  static constexpr double largest_number = 1e15;

  double scale_ = 1;
  std::size_t front_ = 0;  // number of the bucket in turn, counted without wrapping round
  std::size_t count_ = 0;
  std::vector<std::vector<std::pair<Index, double>>> buckets_;
};

}  // namespace gelight::detail
