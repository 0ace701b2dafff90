#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/neighbours.hpp"

namespace gelight::detail {

/// An order in which elimination fills little: the unknown that fewest others depend on first, by
/// approximate degrees in a quotient graph (Amestoy, Davis, Duff 1996,
/// doi:10.1137/S0895479894278952). Unknowns with the same neighbours go together.
///
/// What is eliminated becomes an element: the list of unknowns that it joins. An unknown's own list
/// has first the elements that it is in, then its neighbours that no element joins it to.
///
/// An unknown is known by its position in a given order. Parts of it are eliminated one after the
/// other, so that memory stays near; what is in no part comes later and counts as a neighbour, but
/// from `hubs_begin` on it does not.
class MinimumDegree {
 public:
  MinimumDegree(const Neighbours& neighbours, const Array<Index>& order, const Array<Range>& parts,
                Index hubs_begin, const CancelHook& cancelled)
      : unknowns_(order.size()), left_(hubs_begin) {
    for (const Range& part : parts) {
      for (Index v = part.begin; v < part.end; ++v) unknowns_[v].is_later = false;
    }
    set_up(neighbours, order, hubs_begin);
    Index step = 0;
    for (const Range& part : parts) {
      for (Index v = part.begin; v < part.end; ++v) put_by_degree(v);
      to_eliminate_ = part.end - part.begin;
      while (to_eliminate_ > 0) {
        if (step++ % steps_between_polls == 0) {
          cancelled.check(1 - static_cast<double>(left_) / hubs_begin, "ordering a matrix");
        }
        eliminate(take_least());
      }
      least_ = 0;
    }
  }

  /// The groups of unknowns that go together, in order, each by its first unknown.
  [[nodiscard]] const Array<Index>& groups() const { return groups_; }
  /// The next unknown of a group, or -1.
  [[nodiscard]] Index next(Index unknown) const { return next_in_group_[unknown]; }

 private:
  static constexpr Index steps_between_polls = 256;
  // About what matrices of surfaces take, elements included; others have room made as they need it.
  static constexpr std::size_t entries_each = 12;

  struct List {
    Index begin = 0, size = 0;
    Index elements = 0;  // how many of an unknown's list are elements
  };

  // An unknown, or the element that it became. (All in one place: they are asked for in no order.)
  struct Unknown {
    List list;
    Index weight = 1;  // how many go together as one, 0 of the others of these
    Index degree = 0;  // at most how many depend on it; of an element, its members' weight
    Index before = -1, after = -1;  // among those of its degree
    bool is_later = true;
    std::ptrdiff_t outside = 0;  // of an element
  };

  void set_up(const Neighbours& neighbours, const Array<Index>& order, Index hubs_begin) {
    const std::size_t count = order.size();
    marks_.assign(count, 0);
    first_of_degree_.assign(count + 1, -1);
    next_in_group_.assign(count, -1);
    last_in_group_.resize_for_writes(count);
    Array<Index> position;
    position.resize_for_writes(count);
    for (Index v = 0; v < std::ssize(order); ++v) position[order[v]] = last_in_group_[v] = v;
    entries_.reserve_for_all(entries_each * count);
    for (Index v = 0; v < hubs_begin; ++v) {
      Unknown& unknown = unknowns_[v];
      unknown.list.begin = static_cast<Index>(entries_.size());
      for (const auto& n : neighbours.of(order[v])) {
        const Index other = position[n.unknown];
        // Between two that are kept for later nobody looks.
        if (other >= hubs_begin || (unknown.is_later && unknowns_[other].is_later)) continue;
        entries_.push_back(other);
      }
      unknown.list.size = unknown.degree = static_cast<Index>(entries_.size()) - unknown.list.begin;
    }
  }

  // Unknowns of a degree are in a doubly linked list.
  ///@{
  void put_by_degree(Index v) {
    Index& first = first_of_degree_[unknowns_[v].degree];
    unknowns_[v].before = -1;
    unknowns_[v].after = first;
    if (first >= 0) unknowns_[first].before = v;
    first = v;
    least_ = std::min(least_, unknowns_[v].degree);
  }
  void take_from_degree(Index v) {
    if (unknowns_[v].before >= 0) {
      unknowns_[unknowns_[v].before].after = unknowns_[v].after;
    } else {
      first_of_degree_[unknowns_[v].degree] = unknowns_[v].after;
    }
    if (unknowns_[v].after >= 0) unknowns_[unknowns_[v].after].before = unknowns_[v].before;
  }
  Index take_least() {
    while (first_of_degree_[least_] < 0) ++least_;
    const Index v = first_of_degree_[least_];
    take_from_degree(v);
    return v;
  }
  ///@}

  [[nodiscard]] bool is_later(Index v) const { return unknowns_[v].is_later; }
  [[nodiscard]] std::span<Index> members(Index element) {
    return {entries_.data() + unknowns_[element].list.begin,
            static_cast<std::size_t>(unknowns_[element].list.size)};
  }

  void eliminate(Index pivot) {
    make_element(pivot);
    measure_outside(pivot);
    candidates_.clear();
    for (const Index v : members(pivot)) shorten_list(v, pivot);
    largest_ = std::max(largest_, unknowns_[pivot].degree);
    stamp_ += largest_;
    merge_alike();
    groups_.push_back(pivot);
    settle(pivot);
  }

  // Joins the elements of a pivot and its neighbours; weights are negative while they are members.
  void make_element(Index pivot) {
    const List from = unknowns_[pivot].list;
    to_eliminate_ -= unknowns_[pivot].weight;
    left_ -= unknowns_[pivot].weight;
    unknowns_[pivot].weight = 0;
    const auto begin = static_cast<Index>(entries_.size());
    Index total = 0;
    const auto add = [&](Index v) {
      if (unknowns_[v].weight <= 0) return;
      total += unknowns_[v].weight;
      unknowns_[v].weight = -unknowns_[v].weight;
      entries_.push_back(v);
      if (!is_later(v)) take_from_degree(v);
    };
    for (Index k = 0; k < from.size; ++k) {
      const Index other = entries_[from.begin + k];
      if (k >= from.elements) {
        add(other);
        continue;
      }
      if (unknowns_[other].outside < 0) continue;
      const List joined = unknowns_[other].list;
      for (Index m = 0; m < joined.size; ++m) add(entries_[joined.begin + m]);
      unknowns_[other].outside = gone;
    }
    unknowns_[pivot].list = {begin, static_cast<Index>(entries_.size()) - begin, 0};
    unknowns_[pivot].degree = total;
    unknowns_[pivot].outside = 0;
  }

  // For each element that shares members with the new one: stamp_ and the weight of its others.
  void measure_outside(Index pivot) {
    for (const Index v : members(pivot)) {
      const Index* const list = entries_.data() + unknowns_[v].list.begin;
      for (Index k = 0; k < unknowns_[v].list.elements; ++k) {
        std::ptrdiff_t& outside = unknowns_[list[k]].outside;
        if (outside == gone) continue;
        if (outside < stamp_) outside = stamp_ + unknowns_[list[k]].degree;
        outside += unknowns_[v].weight;
      }
    }
  }

  // Puts the new element in a member's list in place of what it makes superfluous there. What
  // depends on nothing else is eliminated at once.
  void shorten_list(Index v, Index pivot) {
    Unknown& member = unknowns_[v];
    List& list = member.list;
    Index* const entries = entries_.data() + list.begin;
    Index degree = 0, kept = 0;
    std::size_t hash = 0;
    for (Index k = 0; k < list.elements; ++k) {
      const Index element = entries[k];
      if (unknowns_[element].outside == gone) continue;
      const auto outside = static_cast<Index>(unknowns_[element].outside - stamp_);
      if (outside == 0) {
        unknowns_[element].outside = gone;  // the new one has all its members
        continue;
      }
      degree += outside;
      hash += static_cast<std::size_t>(element);
      entries[kept++] = element;
    }
    const Index elements = kept;
    for (Index k = list.elements; k < list.size; ++k) {
      const Index other = entries[k];
      if (unknowns_[other].weight <= 0) continue;
      degree += unknowns_[other].weight;
      hash += static_cast<std::size_t>(other);
      entries[kept++] = other;
    }
    if (kept == 0 && !is_later(v)) {
      unknowns_[pivot].degree += unknowns_[v].weight;
      left_ += unknowns_[v].weight;
      to_eliminate_ += unknowns_[v].weight;
      join_group(pivot, v);
      return;
    }
    // It has room: the pivot or an element that the pivot joined was in it.
    entries[kept] = entries[elements];
    entries[elements] = entries[0];
    entries[0] = pivot;
    list.elements = elements + 1;
    list.size = kept + 1;
    if (is_later(v)) return;
    member.degree = std::min(member.degree, degree);
    candidates_.push_back({hash, v});
  }

  void join_group(Index group, Index v) {
    unknowns_[v].weight = 0;
    next_in_group_[last_in_group_[group]] = v;
    last_in_group_[group] = last_in_group_[v];
  }

  // Members with the same lists stay alike to the end.
  void merge_alike() {
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.hash != b.hash ? a.hash < b.hash : a.unknown < b.unknown;
    });
    for (auto first = candidates_.begin(); first != candidates_.end(); ++first) {
      const Index v = first->unknown;
      bool is_marked = false;
      for (auto other = first + 1; other != candidates_.end() && other->hash == first->hash;
           ++other) {
        if (unknowns_[v].weight == 0) break;
        if (unknowns_[other->unknown].weight == 0) continue;
        if (!is_marked) mark_list(v);
        is_marked = true;
        if (!is_like_marked(unknowns_[other->unknown].list, unknowns_[v].list)) continue;
        unknowns_[v].weight += unknowns_[other->unknown].weight;
        join_group(v, other->unknown);
      }
    }
  }
  void mark_list(Index v) {
    const Index* const entries = entries_.data() + unknowns_[v].list.begin;
    ++mark_;
    for (Index k = 1; k < unknowns_[v].list.size; ++k) marks_[entries[k]] = mark_;
  }
  [[nodiscard]] bool is_like_marked(const List& list, const List& marked) const {
    if (list.size != marked.size || list.elements != marked.elements) return false;
    const Index* const entries = entries_.data() + list.begin;
    return std::all_of(entries + 1, entries + list.size,
                       [&](Index entry) { return marks_[entry] == mark_; });
  }

  // Ends the step: members that are left get their degrees.
  void settle(Index pivot) {
    Index kept = 0;
    const auto all = members(pivot);
    for (const Index v : all) {
      if (unknowns_[v].weight == 0) continue;
      unknowns_[v].weight = -unknowns_[v].weight;
      all[static_cast<std::size_t>(kept++)] = v;
      if (is_later(v)) continue;
      const Index others = unknowns_[v].degree + unknowns_[pivot].degree - unknowns_[v].weight;
      unknowns_[v].degree = std::min(others, left_ - unknowns_[v].weight);
      put_by_degree(v);
    }
    unknowns_[pivot].list.size = kept;
    entries_.keep_until(all.data() + kept);
  }

  static constexpr std::ptrdiff_t gone = -1;

  struct Candidate {
    std::size_t hash;
    Index unknown;
  };

  Array<Unknown> unknowns_;
  Array<Index> entries_;  // of all lists
  std::ptrdiff_t stamp_ = 1;
  Array<std::ptrdiff_t> marks_;  // of what is in the list that is compared with others
  std::ptrdiff_t mark_ = 0;
  Array<Candidate> candidates_;
  Array<Index> first_of_degree_;
  Array<Index> next_in_group_, last_in_group_;
  Array<Index> groups_;
  Index least_ = 0, largest_ = 0;
  Index left_;              // unknowns, with those kept for later
  Index to_eliminate_ = 0;  // of a part
};

}  // namespace gelight::detail
