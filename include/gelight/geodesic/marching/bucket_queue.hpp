#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// A queue of vertices in about the order of their distances: those within a third of a step of
/// each other come out in any order. For solvers that correct what they did too early that is
/// enough, and a push costs no more than an array's. What comes in with a distance that the queue
/// has passed comes out first, the nearest before others: in any other order vertices may correct
/// each other over and over.
template <std::floating_point Real>
class BucketQueue {
 public:
  /// Empties the queue. Keys are not negative; `step` is about what a vertex adds to the distance
  /// of the last.
  void reset(Real step) {
    // Finite, so that a key of zero has a number where the step is next to nothing.
    scale_ = step > 0 ? std::min(buckets_per_step / step, std::numeric_limits<Real>::max()) : 1;
    front_ = count_ = 0;
    round_end_ = bucket_count;
    later_.clear();
    passed_.clear();
    newest_.fill(none);
    entries_.clear();
    below_.clear();
    free_ = none;
  }

  void push(Index vertex, Real key) {
    ++count_;
    put({vertex, key});
  }

  /// Whether entries with these keys come out in any order. None has an infinite key.
  [[nodiscard]] bool are_together(Real one, Real other) const {
    return number_of(one) == number_of(other) && std::max(one, other) < unreachable<Real>;
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }

  /// The vertex that probably comes out next, or after `ahead` others, a few, or `unknown`.
  [[nodiscard]] Index next_or(Index unknown, std::uint32_t ahead = 0) const {
    if (!passed_.empty()) return passed_.size() > ahead ? passed_[ahead].first : unknown;
    const Place newest = this->newest(front_);
    if (newest == none) return unknown;
    if (newest % piece >= ahead) return entries_[newest - ahead].first;
    const Place below = below_[newest / piece];
    return below == none ? unknown : entries_[below + newest % piece + 1 - ahead].first;
  }

  /// A vertex and the key it was pushed with, which may have been bettered since.
  std::pair<Index, Real> pop() {
    --count_;
    while (passed_.empty() && newest(front_) == none) {
      if (++front_ == round_end_) start_round();
    }
    if (!passed_.empty()) {
      std::pop_heap(passed_.begin(), passed_.end(), is_farther);
      const Entry entry = passed_.back();
      passed_.pop_back();
      return entry;
    }
    Place& newest = this->newest(front_);
    const Entry entry = entries_[newest];
    newest = newest % piece > 0 ? newest - 1 : give_back(newest / piece);
    return entry;
  }

 private:
  using Entry = std::pair<Index, Real>;
  using Place = std::uint32_t;
  static constexpr Real buckets_per_step = 3;
  using Number = std::uint64_t;  // of a bucket, also where a size has 32 bits
  static constexpr std::size_t bucket_count = 256;
  static constexpr Place piece = 16, none = ~Place{0};
  // Keys beyond so many buckets have no order by those: they come out the nearest first.
  static constexpr Number last_number = 1'000'000'000'000'000;

  // The newest entry of a bucket.
  [[nodiscard]] Place& newest(Number number) {
    return newest_[static_cast<std::size_t>(number % bucket_count)];
  }
  [[nodiscard]] Place newest(Number number) const {
    return newest_[static_cast<std::size_t>(number % bucket_count)];
  }

  [[nodiscard]] Number number_of(Real key) const {
    return static_cast<Number>(
        static_cast<std::int64_t>(std::min(key * scale_, Real{last_number})));
  }

  static bool is_farther(const Entry& a, const Entry& b) { return a.second > b.second; }

  void put(const Entry& entry) {
    const Number number = number_of(entry.second);
    if (number < front_ || front_ == last_number) {
      passed_.push_back(entry);
      std::push_heap(passed_.begin(), passed_.end(), is_farther);
    } else if (number < round_end_) {
      Place& newest = this->newest(number);
      newest = newest % piece < piece - 1 ? newest + 1 : take_piece(newest);
      entries_[newest] = entry;
    } else {
      later_.push_back(entry);
      std::push_heap(later_.begin(), later_.end(), is_farther);
    }
  }

  // The first place of a piece, which lies on `below` in its bucket.
  [[gnu::noinline]] Place take_piece(Place below) {
    Place number = free_;
    if (number != none) {
      free_ = below_[number];
      below_[number] = below;
    } else {
      number = static_cast<Place>(below_.size());
      below_.push_back(below);
      entries_.resize(below_.size() * piece);
    }
    return number * piece;
  }
  Place give_back(Place number) {
    return std::exchange(below_[number], std::exchange(free_, number));
  }

  // Hands out what was put off, from the nearest on, as far as the round goes; all buckets are
  // empty. What is farther stays: of edges of very different lengths a round serves few.
  void start_round() {
    front_ = std::max(front_, number_of(later_.front().second));
    round_end_ = front_ < last_number ? std::min(front_ + bucket_count, last_number)
                                      : last_number + 1;  // never reached
    while (!later_.empty() && number_of(later_.front().second) < round_end_) {
      std::pop_heap(later_.begin(), later_.end(), is_farther);
      put(later_.back());
      later_.pop_back();
    }
  }

  Real scale_ = 1;
  Number front_ = 0;                 // number of the bucket in turn
  Number round_end_ = bucket_count;  // those from here on are put off
  std::size_t count_ = 0;
  // Buckets are stacks in pieces of one memory, which go from one to another as they become free.
  std::array<Place, bucket_count> newest_;  // of each bucket: the place of its newest entry
  Array<Entry> entries_;                    // `piece` of them a piece
  Array<Place> below_;  // of each piece: the newest entry before its own, or the next free piece
  Place free_ = none;
  Array<Entry> later_, passed_;  // heaps
};

}  // namespace gelight::detail
