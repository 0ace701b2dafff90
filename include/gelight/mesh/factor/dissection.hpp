#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

namespace gelight::detail {

/// An order in which to eliminate the unknowns of a sparse matrix over points in space, and what
/// elimination fills: nested dissection (George 1973, doi:10.1137/0710032) by planes.
///
/// The points are halved at their median again and again, or where that joins many of them, in
/// whichever way joins few; the vertices that join the halves come after both. Each separator, and
/// each small part left at the end, is a node of a binary tree and is eliminated as one dense
/// block. Made in O(n log n); serves every matrix of the pattern.
template <std::floating_point Real>
class Dissection {
 public:
  static constexpr Index columns_together = 4;

  /// Its unknowns are those at positions [begin, end) of the order; its block also has the rows at
  /// the later positions rows()[rows_begin, rows_end).
  struct Node {
    Index begin = 0, end = 0;
    std::ptrdiff_t rows_begin = 0, rows_end = 0;
    std::array<Index, 2> children{-1, -1};
    Index parent = -1;
    std::ptrdiff_t values = 0;  // where its columns begin in the factor's values
    std::ptrdiff_t update = 0;  // where what it changes in its parent waits

    [[nodiscard]] Index own() const { return end - begin; }
    [[nodiscard]] Index border() const { return static_cast<Index>(rows_end - rows_begin); }
    [[nodiscard]] Index height() const { return own() + border(); }
    /// Of its block, and of what of it the factor keeps: a few columns together, each from the
    /// diagonal of the first of them on down.
    ///@{
    [[nodiscard]] std::ptrdiff_t block_size() const { return std::ptrdiff_t{own()} * height(); }
    [[nodiscard]] std::ptrdiff_t value_count() const {
      std::ptrdiff_t count = 0;
      for (Index k = 0; k < own(); k += columns_together) {
        count += std::ptrdiff_t{std::min(columns_together, own() - k)} * (height() - k);
      }
      return count;
    }
    ///@}
    /// About what its elimination costs.
    [[nodiscard]] double work() const { return own() * (1.0 + height()) * height(); }
  };

  /// Where an entry off the matrix' diagonal goes in its column of its node's block.
  struct Placement {
    Index entry;  // or ~entry: the factor has it as column, row
    Index row;

    [[nodiscard]] bool is_transposed() const { return entry < 0; }
    [[nodiscard]] Index number() const { return entry < 0 ? ~entry : entry; }
  };

  Dissection(const SymmetricPattern<Real>& pattern, std::span<const Vec3<Real>> points,
             const CancelHook& cancelled = {})
      : points_(points), cancelled_(cancelled) {
    find_neighbours(pattern);
    const auto count = static_cast<std::size_t>(pattern.size());
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
    side_.assign(count, -1);
    keys_.resize(count);
    Index placed = 0;
    split(0, pattern.size(), placed);
    position_.resize(count);
    for (Index p = 0; p < pattern.size(); ++p) position_[order_[p]] = p;
    find_rows();
    rows_ = Array<Index>(rows_.begin(), rows_.end());  // without the room for more
    relate_rows(pattern);
    place_updates();
    neighbour_begin_ = {};
    neighbours_ = {};
    side_ = {};
    keys_ = {};
    position_ = {};
    points_ = {};
    cancelled_ = {};
  }

  [[nodiscard]] Index size() const { return static_cast<Index>(order_.size()); }
  /// Children come before their parents.
  [[nodiscard]] const Array<Node>& nodes() const { return nodes_; }
  [[nodiscard]] const Array<Index>& rows() const { return rows_; }
  /// For each of rows(): its row in the block of the node's parent.
  [[nodiscard]] const Array<Index>& rows_in_parent() const { return rows_in_parent_; }
  /// Those of the column at a position of the order.
  [[nodiscard]] std::span<const Placement> placements(Index position) const {
    const Placement* const all = placements_.data();
    return {all + placements_begin_[position], all + placements_begin_[position + 1]};
  }
  /// The unknown at each position.
  [[nodiscard]] const Array<Index>& order() const { return order_; }
  /// Number of values of the factor, and room for those that wait to be added to parents.
  [[nodiscard]] std::ptrdiff_t value_count() const { return value_count_; }
  [[nodiscard]] std::ptrdiff_t stack_size() const { return stack_size_; }
  [[nodiscard]] Index largest_height() const { return largest_height_; }
  [[nodiscard]] std::ptrdiff_t largest_block() const { return largest_block_; }

 private:
  static constexpr Index leaf_size = 12;

  /// An unknown that an entry of the matrix joins to another.
  struct Neighbour {
    Index unknown, entry;
  };

  void find_neighbours(const SymmetricPattern<Real>& pattern) {
    neighbour_begin_.assign(static_cast<std::size_t>(pattern.size()) + 1, 0);
    const auto for_each_pair = [&](auto&& visit) {
      for (Index j = 0; j < pattern.size(); ++j) {
        for (Index e = pattern.begin(j) + 1; e < pattern.begin(j + 1); ++e)
          visit(pattern.row(e), j, e);
      }
    };
    for_each_pair([&](Index i, Index j, Index) {
      ++neighbour_begin_[i + 1];
      ++neighbour_begin_[j + 1];
    });
    std::partial_sum(neighbour_begin_.begin(), neighbour_begin_.end(), neighbour_begin_.begin());
    neighbours_.resize(static_cast<std::size_t>(neighbour_begin_.back()));
    Array<Index> fill(neighbour_begin_.begin(), neighbour_begin_.end() - 1);
    for_each_pair([&](Index i, Index j, Index e) {
      neighbours_[fill[i]++] = {j, e};
      neighbours_[fill[j]++] = {i, e};
    });
  }

  // Orders the unknowns order_[begin, end) among themselves; returns the node of the last ones.
  Index split(Index begin, Index end, Index& stamp) {
    if (end - begin <= leaf_size) return add_node(begin, end, {-1, -1});
    cancelled_.check(static_cast<double>(begin) / static_cast<double>(order_.size()),
                     "ordering a matrix");
    const Halves halves = halve(begin, end, stamp);
    const Index middle = middle_of(begin, end);
    const auto first = order_.begin();
    // The separator is made of those vertices of one half that have a neighbour in the other.
    if (halves.low_cut < halves.high_cut) {
      const auto cut = std::partition(first + begin, first + middle,
                                      [&](Index v) { return !touches(v, halves.high); });
      std::rotate(cut, first + middle, first + end);
      const auto inner = static_cast<Index>(cut - first);
      return join(begin, inner, end - halves.low_cut, end, stamp);
    }
    const auto cut = std::partition(first + middle, first + end,
                                    [&](Index v) { return !touches(v, halves.low); });
    return join(begin, middle, static_cast<Index>(cut - first), end, stamp);
  }

  /// Two halves by the marks of their unknowns, and how many of each touch the other.
  struct Halves {
    Index low = 0, high = 0;
    Index low_cut = 0, high_cut = 0;

    [[nodiscard]] Index separator() const { return std::min(low_cut, high_cut); }
  };
  static constexpr Index by_steps = 3;  // a way to halve, beside the axes

  [[nodiscard]] static Index middle_of(Index begin, Index end) { return begin + (end - begin) / 2; }

  // Halves a part along its widest axis, or, where that cuts more than surfaces need, in the way
  // that cuts least: points may lie far denser along one axis than along another, or all at one
  // place.
  Halves halve(Index begin, Index end, Index& stamp) {
    const double enough = 4 * std::sqrt(static_cast<double>(end - begin));
    const Index widest = widest_axis(begin, end);
    const Halves along = halve_in(widest, begin, end, stamp);
    if (along.separator() <= enough) return along;
    Index best = widest, least = along.separator();
    for (const Index way : {0, 1, 2, by_steps}) {
      if (way == widest) continue;
      const Halves found = halve_in(way, begin, end, stamp);
      if (found.separator() >= least) continue;
      best = way;
      least = found.separator();
    }
    return halve_in(best, begin, end, stamp);
  }

  Halves halve_in(Index way, Index begin, Index end, Index& stamp) {
    const Index middle = middle_of(begin, end);
    if (way == by_steps) {
      order_by_steps(begin, end, order_[begin], stamp);
      order_by_steps(begin, end, order_[end - 1], stamp);  // from one side to the other
    } else {
      order_along(begin, middle, end, way);
    }
    Halves halves{stamp, stamp + 1};
    stamp += 2;
    for (Index i = begin; i < end; ++i) side_[order_[i]] = i < middle ? halves.low : halves.high;
    for (Index i = begin; i < middle; ++i) halves.low_cut += touches(order_[i], halves.high);
    for (Index i = middle; i < end; ++i) halves.high_cut += touches(order_[i], halves.low);
    return halves;
  }

  // Whether an unknown has a neighbour with that mark.
  [[nodiscard]] bool touches(Index v, Index mark) const {
    for (Index n = neighbour_begin_[v]; n < neighbour_begin_[v + 1]; ++n) {
      if (side_[neighbours_[n].unknown] == mark) return true;
    }
    return false;
  }

  // Puts those with the lesser coordinates before `middle`.
  void order_along(Index begin, Index middle, Index end, Index axis) {
    const auto first = keys_.begin() + begin;
    for (Index i = begin; i < end; ++i) keys_[i] = {point(order_[i])[axis], order_[i]};
    std::nth_element(first, keys_.begin() + middle, keys_.begin() + end,
                     [](const Key& a, const Key& b) { return a.coordinate < b.coordinate; });
    for (Index i = begin; i < end; ++i) order_[i] = keys_[i].unknown;
  }

  // Puts them in the order in which they are met, going from neighbour to neighbour.
  void order_by_steps(Index begin, Index end, Index start, Index& stamp) {
    const Index unmet = stamp++, met = stamp++;
    for (Index i = begin; i < end; ++i) side_[order_[i]] = unmet;
    Index count = begin, other = begin;
    const auto meet = [&](Index v) {
      if (side_[v] != unmet) return;
      side_[v] = met;
      keys_[count++].unknown = v;
    };
    meet(start);
    for (Index i = begin; i < end; ++i) {
      if (i == count) {  // on with another connected part
        while (side_[order_[other]] == met) ++other;
        meet(order_[other]);
      }
      const Index v = keys_[i].unknown;
      for (Index n = neighbour_begin_[v]; n < neighbour_begin_[v + 1]; ++n) {
        meet(neighbours_[n].unknown);
      }
    }
    for (Index i = begin; i < end; ++i) order_[i] = keys_[i].unknown;
  }

  Index join(Index begin, Index middle, Index separator, Index end, Index& stamp) {
    const Index left = split(begin, middle, stamp);
    const Index right = split(middle, separator, stamp);
    return add_node(separator, end, {left, right});
  }

  Index add_node(Index begin, Index end, const std::array<Index, 2>& children) {
    const auto number = static_cast<Index>(nodes_.size());
    Node node;
    node.begin = begin;
    node.end = end;
    node.children = children;
    for (const Index c : children) {
      if (c >= 0) nodes_[c].parent = number;
    }
    nodes_.push_back(node);
    return number;
  }

  [[nodiscard]] const Vec3<Real>& point(Index v) const {
    return points_[static_cast<std::size_t>(v)];
  }

  [[nodiscard]] Index widest_axis(Index begin, Index end) const {
    Vec3<Real> low = point(order_[begin]), high = low;
    for (Index i = begin + 1; i < end; ++i) {
      low = low.cwiseMin(point(order_[i]));
      high = high.cwiseMax(point(order_[i]));
    }
    Index axis = 0;
    (high - low).maxCoeff(&axis);
    return axis;
  }

  // A node's rows: the later neighbours of its own unknowns, and its children's rows but its own.
  void find_rows() {
    Array<Index> seen(order_.size(), -1);
    for (Index n = 0; n < static_cast<Index>(nodes_.size()); ++n) {
      Node& node = nodes_[n];
      node.rows_begin = static_cast<std::ptrdiff_t>(rows_.size());
      const auto add = [&](Index p) {
        if (p < node.end || seen[p] == n) return;
        seen[p] = n;
        rows_.push_back(p);
      };
      for (Index p = node.begin; p < node.end; ++p) {
        const Index v = order_[p];
        for (Index k = neighbour_begin_[v]; k < neighbour_begin_[v + 1]; ++k) {
          add(position_[neighbours_[k].unknown]);
        }
      }
      for (const Index c : node.children) {
        if (c < 0) continue;
        for (auto r = nodes_[c].rows_begin; r < nodes_[c].rows_end; ++r) add(rows_[r]);
      }
      node.rows_end = static_cast<std::ptrdiff_t>(rows_.size());
      std::sort(rows_.begin() + node.rows_begin, rows_.end());
      largest_height_ = std::max(largest_height_, node.height());
      largest_block_ = std::max(largest_block_, node.block_size());
      node.values = value_count_;
      value_count_ += node.value_count();
    }
  }

  // Where children's rows and the matrix' entries go in each node's block.
  void relate_rows(const SymmetricPattern<Real>& pattern) {
    Array<Index> row_of(order_.size());
    rows_in_parent_.resize(rows_.size());
    placements_.reserve(static_cast<std::size_t>(pattern.entry_count() - pattern.size()));
    placements_begin_.reserve(order_.size() + 1);
    for (Node& node : nodes_) {
      for (Index p = node.begin; p < node.end; ++p) row_of[p] = p - node.begin;
      for (Index r = 0; r < node.border(); ++r) row_of[rows_[node.rows_begin + r]] = node.own() + r;
      for (const Index c : node.children) {
        if (c < 0) continue;
        for (auto r = nodes_[c].rows_begin; r < nodes_[c].rows_end; ++r) {
          rows_in_parent_[r] = row_of[rows_[r]];
        }
      }
      place_entries(node, row_of);
    }
    placements_begin_.push_back(static_cast<Index>(placements_.size()));
  }

  void place_entries(const Node& node, const Array<Index>& row_of) {
    for (Index p = node.begin; p < node.end; ++p) {
      const Index v = order_[p];
      placements_begin_.push_back(static_cast<Index>(placements_.size()));
      for (Index k = neighbour_begin_[v]; k < neighbour_begin_[v + 1]; ++k) {
        const auto& [w, entry] = neighbours_[k];
        if (position_[w] > p) {
          placements_.push_back({w < v ? ~entry : entry, row_of[position_[w]]});
        }
      }
    }
  }

  // Updates lie on two stacks, those of children on the other one than their parent's, which is
  // made while they are read.
  void place_updates() {
    Array<std::size_t> stack(nodes_.size(), 0);
    for (auto n = std::ssize(nodes_) - 1; n >= 0; --n) {
      if (nodes_[n].parent >= 0) stack[n] = 1 - stack[nodes_[n].parent];
    }
    const auto size = [](const Node& node) {
      return std::ptrdiff_t{node.border()} * node.border();
    };
    std::array<std::ptrdiff_t, 2> top{}, room{};
    for (std::ptrdiff_t n = 0; n < std::ssize(nodes_); ++n) {
      for (const Index c : nodes_[n].children) {
        if (c >= 0) top[stack[c]] -= size(nodes_[c]);
      }
      nodes_[n].update = top[stack[n]];
      top[stack[n]] += size(nodes_[n]);
      room[stack[n]] = std::max(room[stack[n]], top[stack[n]]);
    }
    for (std::ptrdiff_t n = 0; n < std::ssize(nodes_); ++n) {
      if (stack[n] == 1) nodes_[n].update += room[0];
    }
    stack_size_ = room[0] + room[1];
  }

  std::span<const Vec3<Real>> points_;
  CancelHook cancelled_;          // while the order is sought
  Array<Index> neighbour_begin_;  // of each unknown and one more, while the order is sought
  Array<Neighbour> neighbours_;
  struct Key {
    Real coordinate;
    Index unknown;
  };
  Array<Key> keys_;  // while the order is sought
  Array<Index> side_;
  Array<Index> order_, position_;
  Array<Node> nodes_;
  Array<Index> rows_, rows_in_parent_;
  Array<Placement> placements_;
  Array<Index> placements_begin_;  // of each position and one more
  std::ptrdiff_t value_count_ = 0, stack_size_ = 0, largest_block_ = 0;
  Index largest_height_ = 0;
};

}  // namespace gelight::detail
