#pragma once

#include <concepts>
#include <cstddef>
#include <numeric>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

namespace gelight::detail {

/// Positions [begin, end) of an order.
struct Range {
  Index begin, end;
};

/// For each unknown of a symmetric matrix, those that an entry joins to it, and the entry.
class Neighbours {
 public:
  struct Neighbour {
    Index unknown, entry;
  };

  template <std::floating_point Real>
  explicit Neighbours(const SymmetricPattern<Real>& pattern)
      : begin_(static_cast<std::size_t>(pattern.size()) + 1, 0) {
    const auto for_each_pair = [&](auto&& visit) {
      for (Index j = 0; j < pattern.size(); ++j) {
        for (Index e = pattern.begin(j) + 1; e < pattern.begin(j + 1); ++e) {
          visit(pattern.row(e), j, e);
        }
      }
    };
    for_each_pair([&](Index i, Index j, Index) {
      ++begin_[i + 1];
      ++begin_[j + 1];
    });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    all_.resize_for_writes(static_cast<std::size_t>(begin_.back()));
    Array<Index> fill(begin_.begin(), begin_.end() - 1);
    for_each_pair([&](Index i, Index j, Index e) {
      all_[fill[i]++] = {j, e};
      all_[fill[j]++] = {i, e};
    });
  }

  /// How many unknowns there are.
  [[nodiscard]] Index size() const { return static_cast<Index>(begin_.size()) - 1; }
  /// How many pairs are neighbours.
  [[nodiscard]] std::size_t pair_count() const { return all_.size() / 2; }
  [[nodiscard]] std::span<const Neighbour> of(Index unknown) const {
    return {all_.data() + begin_[unknown], all_.data() + begin_[unknown + 1]};
  }

 private:
  Array<Index> begin_;  // of each unknown and one more
  Array<Neighbour> all_;
};

}  // namespace gelight::detail
