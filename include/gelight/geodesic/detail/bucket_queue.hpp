#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// A queue of vertices in about the order of their distances: those within a third of a step of
/// each other come out in any order. For solvers that correct what they did too early that is
/// enough, and a push costs no more than an array's.
class BucketQueue {
 public:
  /// Empties the queue. Keys are not negative; `step` is about what a vertex adds to the distance
  /// of the last.
  void reset(double step) {
    // Finite, so that a key of zero has a number where the step is next to nothing.
    scale_ = step > 0 ? std::min(buckets_per_step / step, std::numeric_limits<double>::max()) : 1;
    front_ = count_ = 0;
    round_end_ = bucket_count;
    later_.clear();
    buckets_.resize(bucket_count);
    for (auto& bucket : buckets_) bucket.clear();
  }

  void push(Index vertex, double key) {
    ++count_;
    put({vertex, key});
  }

  /// Whether entries with these keys come out in any order.
  [[nodiscard]] bool are_together(double one, double other) const {
    return number_of(one) == number_of(other);
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }

  /// The vertex that probably comes out next, or `unknown`.
  [[nodiscard]] Index next_or(Index unknown) const {
    const auto& bucket = buckets_[front_ % bucket_count];
    return bucket.empty() ? unknown : bucket.back().first;
  }

  /// A vertex and the key it was pushed with, which may have been bettered since.
  std::pair<Index, double> pop() {
    while (buckets_[front_ % bucket_count].empty()) {
      if (++front_ == round_end_) start_round();
    }
    auto& bucket = buckets_[front_ % bucket_count];
    const auto entry = bucket.back();
    bucket.pop_back();
    --count_;
    return entry;
  }

 private:
  using Entry = std::pair<Index, double>;
  static constexpr double buckets_per_step = 3;
  static constexpr std::size_t bucket_count = 256;
  static constexpr double largest_number = 1e15;

  [[nodiscard]] std::size_t number_of(double key) const {
    return static_cast<std::size_t>(
        static_cast<std::int64_t>(std::min(key * scale_, largest_number)));
  }

  void put(const Entry& entry) {
    const std::size_t number = std::max(number_of(entry.second), front_);
    if (number < round_end_) {
      buckets_[number % bucket_count].push_back(entry);
    } else {
      later_.push_back(entry);
    }
  }

  // Hands out what was put off, from the nearest on; all buckets are empty.
  void start_round() {
    std::size_t least = static_cast<std::size_t>(largest_number);
    for (const auto& [vertex, key] : later_) least = std::min(least, number_of(key));
    front_ = std::max(front_, least);
    round_end_ = front_ + bucket_count;
    std::vector<Entry> waiting;
    waiting.swap(later_);
    for (const Entry& entry : waiting) put(entry);
  }

  double scale_ = 1;
  std::size_t front_ = 0;                 // number of the bucket in turn
  std::size_t round_end_ = bucket_count;  // those from here on are put off
  std::size_t count_ = 0;
  std::vector<std::vector<Entry>> buckets_;
  std::vector<Entry> later_;
};

}  // namespace gelight::detail
