#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/minimum_degree.hpp"
#include "gelight/mesh/factor/neighbours.hpp"
#include "gelight/mesh/factor/separators.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

namespace gelight::detail {

/// An order in which to eliminate the unknowns of a sparse matrix over points in space, and what
/// elimination fills: separators part large matrices, and within the parts those go first that
/// depend on the fewest others.
///
/// Unknowns that depend on the same others, or on nearly the same, are a node of a tree and are
/// eliminated as one dense block. Made in O(n log n) on surfaces; serves every matrix of the
/// pattern.
template <std::floating_point Real>
class Dissection {
 public:
  static constexpr Index columns_together = 4;

  /// Its unknowns are those at positions [begin, end) of the order; its block also has the rows at
  /// the later positions rows()[rows_begin, rows_end).
  struct Node {
    Index begin = 0, end = 0;
    std::ptrdiff_t rows_begin = 0, rows_end = 0;
    Index parent = -1;
    Index last_child = -1, sibling = -1;  // the sibling before it
    std::ptrdiff_t values = 0;            // where its columns begin in the factor's values
    std::ptrdiff_t update = 0;            // where what it changes in its parent waits

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
             const CancelHook& cancelled = {}) {
    const Neighbours neighbours(pattern);
    {
      Groups groups = grouped(neighbours, points, cancelled);
      find_rows(groups, neighbours);
      merge(groups);
      number_nodes(groups);
    }
    relate_rows(neighbours);
    place_updates();
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
  /// Unknowns that are eliminated together; its parent is the first later group that it changes.
  struct Group {
    Index begin, end;                     // among Groups::unknowns
    std::ptrdiff_t rows_begin, rows_end;  // among Groups::rows
    Index parent = -1;
    Index own = 0;  // with those of the groups that are merged into it
    Index merged_into = -1;

    [[nodiscard]] Index border() const { return static_cast<Index>(rows_end - rows_begin); }
  };
  struct Groups {
    Array<Group> all;  // in an order of elimination
    Array<Index> unknowns;
    Array<Index> group_of;  // of each unknown
    Array<Index> rows;      // unknowns

    void add(Index begin) {
      const auto end = static_cast<Index>(unknowns.size());
      if (begin == end) return;
      for (Index i = begin; i < end; ++i) group_of[unknowns[i]] = static_cast<Index>(all.size());
      all.push_back({begin, end, 0, 0, -1, end - begin, -1});
    }
    void add(std::span<const Index> some) {
      const auto begin = static_cast<Index>(unknowns.size());
      unknowns.append(some.begin(), some.end());
      add(begin);
    }
  };

  static Groups grouped(const Neighbours& neighbours, std::span<const Vec3<Real>> points,
                        const CancelHook& cancelled) {
    const auto count = static_cast<std::size_t>(neighbours.size());
    const Separators<Real> separators(neighbours, points, cancelled.part(0, 0.3));
    const Array<Index>& order = separators.order();
    const MinimumDegree first(neighbours, order, separators.parts(), separators.hubs_begin(),
                              cancelled.part(0.3, 1));
    Groups groups;
    groups.unknowns.reserve(count);
    groups.group_of.resize(count);
    groups.all.reserve_for_all(first.groups().size() + separators.parts().size());
    for (const Index group : first.groups()) {
      const auto begin = static_cast<Index>(groups.unknowns.size());
      for (Index v = group; v >= 0; v = first.next(v)) groups.unknowns.push_back(order[v]);
      groups.add(begin);
    }
    for (Index s = 0; s < separators.count(); ++s) groups.add(separators[s]);
    groups.add(separators.hubs());
    return groups;
  }

  // About what matrices of surfaces take; others have room made as they need it.
  static constexpr std::size_t rows_each = 7;

  // A group's rows: the later neighbours of its own unknowns, and its children's rows but its own.
  static void find_rows(Groups& groups, const Neighbours& neighbours) {
    const auto count = groups.all.size();
    groups.rows.reserve_for_all(rows_each * groups.unknowns.size());
    Array<Index> seen(groups.unknowns.size(), -1), child(count, -1), sibling(count, -1);
    for (Index g = 0; g < static_cast<Index>(count); ++g) {
      Group& group = groups.all[g];
      group.rows_begin = static_cast<std::ptrdiff_t>(groups.rows.size());
      Index parent = static_cast<Index>(count);
      const auto add = [&](Index v) {
        if (groups.group_of[v] <= g || seen[v] == g) return;
        seen[v] = g;
        groups.rows.push_back(v);
        parent = std::min(parent, groups.group_of[v]);
      };
      for (Index i = group.begin; i < group.end; ++i) {
        for (const auto& n : neighbours.of(groups.unknowns[i])) add(n.unknown);
      }
      for (Index c = child[g]; c >= 0; c = sibling[c]) {
        const auto [begin, end] = std::pair(groups.all[c].rows_begin, groups.all[c].rows_end);
        for (auto r = begin; r < end; ++r) add(groups.rows[r]);
      }
      group.rows_end = static_cast<std::ptrdiff_t>(groups.rows.size());
      if (parent == static_cast<Index>(count)) continue;
      group.parent = parent;
      sibling[g] = child[parent];
      child[parent] = g;
    }
  }

  // Merges groups into their parents where the zeros that this fills in cost less than a node.
  static void merge(Groups& groups) {
    for (Group& group : groups.all) {
      if (group.parent < 0) continue;
      Group& parent = groups.all[group.parent];
      const auto zeros =
          std::ptrdiff_t{group.own} * (parent.own + parent.border() - group.border());
      if (zeros > node_cost + row_cost * group.border()) continue;
      group.merged_into = group.parent;
      parent.own += group.own;
    }
  }
  static constexpr std::ptrdiff_t node_cost = 32, row_cost = 2;

  // Puts the groups that are left in an order in which each one's tree is together.
  void number_nodes(Groups& groups) {
    const auto count = static_cast<Index>(groups.all.size());
    Array<Index> whole(groups.all.size());  // the group that each is merged into
    Array<Index> tree_size(groups.all.size(), 0);
    for (Index g = count; g-- > 0;) {
      Group& group = groups.all[g];
      whole[g] = group.merged_into < 0 ? g : whole[group.merged_into];
      if (group.parent >= 0) group.parent = whole[group.parent];
    }
    Index node_count = 0;
    for (Index g = 0; g < count; ++g) {
      if (whole[g] != g) continue;
      ++tree_size[g];
      ++node_count;
      if (groups.all[g].parent >= 0) tree_size[groups.all[g].parent] += tree_size[g];
    }
    // Where the next child's tree, from the last on, ends.
    Array<Index> number(groups.all.size()), end(groups.all.size());
    Index end_of_roots = node_count;
    for (Index g = count; g-- > 0;) {
      if (whole[g] != g) continue;
      const Index parent = groups.all[g].parent;
      Index& place = parent < 0 ? end_of_roots : end[parent];
      end[g] = number[g] = place - 1;
      place -= tree_size[g];
    }
    nodes_.resize(static_cast<std::size_t>(node_count));
    Array<Index> group_of(nodes_.size());
    for (Index g = 0; g < count; ++g) {
      if (whole[g] == g) group_of[number[g]] = g;
    }
    Index position = 0;
    for (Index n = 0; n < node_count; ++n) {
      const Group& group = groups.all[group_of[n]];
      Node& node = nodes_[n];
      node.begin = node.end = position;
      position += group.own;
      if (group.parent < 0) continue;
      node.parent = number[group.parent];
      node.sibling = std::exchange(nodes_[node.parent].last_child, n);
    }
    order_.resize(groups.unknowns.size());
    Array<Index> position_of(order_.size());
    for (Index g = 0; g < count; ++g) {
      Index& next = nodes_[number[whole[g]]].end;
      for (Index i = groups.all[g].begin; i < groups.all[g].end; ++i) {
        order_[next] = groups.unknowns[i];
        position_of[groups.unknowns[i]] = next++;
      }
    }
    put_rows(groups, group_of, position_of);
  }

  void put_rows(const Groups& groups, const Array<Index>& group_of,
                const Array<Index>& position_of) {
    std::ptrdiff_t row_count = 0;
    for (const Index g : group_of) row_count += groups.all[g].border();
    rows_.reserve(static_cast<std::size_t>(row_count));
    for (std::ptrdiff_t n = 0; n < std::ssize(nodes_); ++n) {
      Node& node = nodes_[n];
      const Group& group = groups.all[group_of[n]];
      node.rows_begin = static_cast<std::ptrdiff_t>(rows_.size());
      for (auto r = group.rows_begin; r < group.rows_end; ++r) {
        rows_.push_back(position_of[groups.rows[r]]);
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
  void relate_rows(const Neighbours& neighbours) {
    Array<Index> row_of(order_.size()), position_of(order_.size());
    for (Index p = 0; p < size(); ++p) position_of[order_[p]] = p;
    rows_in_parent_.resize_for_writes(rows_.size());
    placements_begin_.reserve(order_.size() + 1);
    placements_.reserve(neighbours.pair_count());
    for (Node& node : nodes_) {
      for (Index p = node.begin; p < node.end; ++p) row_of[p] = p - node.begin;
      for (Index r = 0; r < node.border(); ++r) row_of[rows_[node.rows_begin + r]] = node.own() + r;
      for (Index c = node.last_child; c >= 0; c = nodes_[c].sibling) {
        for (auto r = nodes_[c].rows_begin; r < nodes_[c].rows_end; ++r) {
          rows_in_parent_[r] = row_of[rows_[r]];
        }
      }
      for (Index p = node.begin; p < node.end; ++p) {
        const Index v = order_[p];
        placements_begin_.push_back(static_cast<Index>(placements_.size()));
        for (const auto& [w, entry] : neighbours.of(v)) {
          if (position_of[w] > p) {
            placements_.push_back({w < v ? ~entry : entry, row_of[position_of[w]]});
          }
        }
      }
    }
    placements_begin_.push_back(static_cast<Index>(placements_.size()));
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
      for (Index c = nodes_[n].last_child; c >= 0; c = nodes_[c].sibling) {
        top[stack[c]] -= size(nodes_[c]);
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

  Array<Index> order_;
  Array<Node> nodes_;
  Array<Index> rows_, rows_in_parent_;
  Array<Placement> placements_;
  Array<Index> placements_begin_;  // of each position and one more
  std::ptrdiff_t value_count_ = 0, stack_size_ = 0, largest_block_ = 0;
  Index largest_height_ = 0;
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::Dissection<double>;
}  // namespace gelight
#endif
