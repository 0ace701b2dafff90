#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/neighbours.hpp"

namespace gelight::detail {

/// Sets of unknowns that part a sparse matrix over points in space into small pieces: nested
/// dissection (George 1973, doi:10.1137/0710032) by planes, each put where it cuts few, or where
/// planes cut many, by steps from neighbour to neighbour. O(n log n).
template <std::floating_point Real>
class Separators {
 public:
  Separators(const Neighbours& neighbours, std::span<const Vec3<Real>> points,
             const CancelHook& cancelled)
      : neighbours_(neighbours), points_(points), cancelled_(cancelled) {
    const auto count = static_cast<std::size_t>(neighbours.size());
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
    rank_.assign(count, -1);
    met_.resize(count);
    const double most = 16 + 10 * std::sqrt(static_cast<double>(count));
    const Index* const hubs = std::stable_partition(order_.begin(), order_.end(), [&](Index v) {
      return static_cast<double>(neighbours.of(v).size()) <= most;
    });
    hubs_begin_ = static_cast<Index>(hubs - order_.begin());
    split(0, hubs_begin_);
  }

  /// All unknowns: those of parts and sets, in an order of elimination, and then the hubs.
  [[nodiscard]] const Array<Index>& order() const { return order_; }
  /// Where in the order what the sets part from each other is.
  [[nodiscard]] const Array<Range>& parts() const { return parts_; }
  /// A set's unknowns part others of earlier sets, or of none.
  ///@{
  [[nodiscard]] Index count() const { return static_cast<Index>(sets_.size()); }
  [[nodiscard]] std::span<const Index> operator[](Index set) const {
    return {order_.data() + sets_[set].begin, order_.data() + sets_[set].end};
  }
  ///@}
  /// Unknowns with so many neighbours that no step may go through all of them; in no set.
  [[nodiscard]] std::span<const Index> hubs() const {
    return {order_.data() + hubs_begin_, order_.data() + order_.size()};
  }
  [[nodiscard]] Index hubs_begin() const { return hubs_begin_; }

 private:
  static constexpr Index largest_part = 12800;
  static constexpr Index most_steps = 300;  // from a part's first unknown
  static constexpr Index slices = 512;      // across an axis
  static constexpr Index by_steps = 3;      // a way to rank unknowns, beside the axes

  /// Between unknowns of ranks less than one, and others: of those that have a neighbour on the
  /// other side, the low ones or the high ones.
  struct Cut {
    Index way = 0, rank = 0;
    bool takes_low = false;
    Index size = std::numeric_limits<Index>::max();
    double badness = std::numeric_limits<double>::infinity();
  };

  void split(Index begin, Index end) {
    if (end - begin <= largest_part && !is_long(begin, end)) {
      parts_.push_back({begin, end});
      return;
    }
    cancelled_.check(static_cast<double>(begin) / static_cast<double>(order_.size()),
                     "ordering a matrix");
    Cut cut;
    for (Index axis = 0; axis < 3; ++axis) take_better(cut, axis, begin, end);
    const double enough = 4 * std::sqrt(static_cast<double>(end - begin));
    if (cut.size > enough) take_better(cut, by_steps, begin, end);
    rank(cut.way, begin, end);
    const auto low_end = std::partition(order_.begin() + begin, order_.begin() + end,
                                        [&](Index v) { return rank_[v] < cut.rank; });
    // Those that part the others come after them.
    Index* middle = low_end;
    Index* separator = order_.begin() + end;
    if (cut.takes_low) {
      middle = std::partition(order_.begin() + begin, low_end,
                              [&](Index v) { return highest_rank(v) < cut.rank; });
      separator = std::rotate(middle, low_end, separator);
    } else {
      separator =
          std::partition(low_end, separator, [&](Index v) { return lowest_rank(v) >= cut.rank; });
    }
    for (Index i = begin; i < end; ++i) rank_[order_[i]] = -1;
    const auto first = static_cast<Index>(middle - order_.begin());
    const auto second = static_cast<Index>(separator - order_.begin());
    split(begin, first);
    split(first, second);
    if (second < end) sets_.push_back({second, end});
  }

  // Whether it is far from one end to the other. What joins unknowns so far apart in the factor of
  // a heat flow, which falls by a factor of about e with each step, would vanish.
  bool is_long(Index begin, Index end) {
    if (end - begin <= most_steps) return false;
    const bool result = rank_by_steps(order_[begin], begin, end) > most_steps;
    for (Index i = begin; i < end; ++i) rank_[order_[i]] = -1;
    return result;
  }

  void take_better(Cut& best, Index way, Index begin, Index end) {
    const Cut found = best_cut(way, begin, end);
    if (found.badness < best.badness) best = found;
  }

  // Gives the unknowns ranks along an axis or by steps; returns how many ranks there are.
  Index rank(Index way, Index begin, Index end) {
    if (way != by_steps) return rank_along(way, begin, end);
    for (Index start : {order_[begin], Index{-1}, Index{-1}}) {
      if (start < 0) start = met_[end - begin - 1];  // from one side to the other
      rank_by_steps(start, begin, end);
    }
    return end - begin;
  }

  Index rank_along(Index axis, Index begin, Index end) {
    const auto at = [&](Index i) { return points_[static_cast<std::size_t>(order_[i])][axis]; };
    Real low = at(begin), high = low;
    for (Index i = begin + 1; i < end; ++i) {
      low = std::min(low, at(i));
      high = std::max(high, at(i));
    }
    const Real width = (high - low) / slices;
    for (Index i = begin; i < end; ++i) {
      const Real slice = width > 0 ? (at(i) - low) / width : 0;
      rank_[order_[i]] = std::min(slices - 1, static_cast<Index>(slice));
    }
    return slices;
  }

  // In the order in which they are met, going from neighbour to neighbour. Returns the most steps.
  Index rank_by_steps(Index start, Index begin, Index end) {
    constexpr Index unmet = std::numeric_limits<Index>::max();
    for (Index i = begin; i < end; ++i) rank_[order_[i]] = unmet;
    Index count = 0, other = begin;
    Index steps = -1, most = 0, next = 0;  // where those begin that are a step farther
    const auto meet = [&](Index v) {
      if (rank_[v] != unmet) return;
      rank_[v] = count;
      met_[count++] = v;
    };
    meet(start);
    for (Index i = 0; i < end - begin; ++i) {
      if (i == count) {  // on with another connected part
        while (rank_[order_[other]] != unmet) ++other;
        meet(order_[other]);
        steps = -1;
        next = i;
      }
      if (i == next) {
        most = std::max(most, ++steps);
        next = count;
      }
      for (const auto& n : neighbours_.of(met_[i])) meet(n.unknown);
    }
    return most;
  }

  [[nodiscard]] Index highest_rank(Index v) const {
    Index highest = -1;
    for (const auto& n : neighbours_.of(v)) highest = std::max(highest, rank_[n.unknown]);
    return highest;
  }
  [[nodiscard]] Index lowest_rank(Index v) const {
    Index lowest = std::numeric_limits<Index>::max();
    for (const auto& n : neighbours_.of(v)) {
      if (rank_[n.unknown] >= 0) lowest = std::min(lowest, rank_[n.unknown]);
    }
    return lowest;
  }

  // The sizes of all cuts by a way's ranks are sums of what each unknown adds: a low one is in the
  // cuts between its rank and its highest neighbour's.
  Cut best_cut(Index way, Index begin, Index end) {
    const Index ranks = rank(way, begin, end);
    const auto room = static_cast<std::size_t>(ranks) + 1;
    below_.assign(room, 0);
    low_.assign(room, 0);
    high_.assign(room, 0);
    for (Index i = begin; i < end; ++i) {
      const Index v = order_[i], own = rank_[v];
      Index highest = own, lowest = own;
      for (const auto& n : neighbours_.of(v)) {
        const Index rank = rank_[n.unknown];
        highest = std::max(highest, rank);
        if (rank >= 0) lowest = std::min(lowest, rank);
      }
      ++below_[own + 1];
      ++low_[own + 1];
      --low_[std::min(highest + 1, ranks)];
      ++high_[lowest + 1];
      --high_[own + 1];
    }
    Cut best;
    const auto size = static_cast<double>(end - begin);
    Index below = 0, low = 0, high = 0;
    for (Index rank = 1; rank < ranks; ++rank) {
      below += below_[rank];
      low += low_[rank];
      high += high_[rank];
      const double share = static_cast<double>(below) / size;
      const double uneven = std::abs(share - 0.5);
      if (uneven > 0.3) continue;
      const Index least = std::min(low, high);
      const double badness = (1.0 + least) * (1 + 8 * uneven * uneven);
      if (badness < best.badness) best = {way, rank, low < high, least, badness};
    }
    return best;
  }

  const Neighbours& neighbours_;
  std::span<const Vec3<Real>> points_;
  const CancelHook& cancelled_;
  Array<Index> order_;
  Array<Index> rank_;                // of those that are being parted, -1 of others
  Array<Index> met_;                 // by steps
  Array<Index> below_, low_, high_;  // changes from the cut before each rank to that at it
  Array<Range> parts_, sets_;
  Index hubs_begin_ = 0;
};

}  // namespace gelight::detail
