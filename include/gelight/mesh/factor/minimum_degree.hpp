#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

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
class MinimumDegree {
 public:
  /// Which unknowns it eliminates; those kept for later count as neighbours, those left out do not.
  enum class Role : char { eliminated, later, left_out };

  MinimumDegree(const Neighbours& neighbours, Array<Role> roles, const CancelHook& cancelled)
      : roles_(std::move(roles)) {
    set_up(neighbours);
    const Index whole = to_eliminate_;
    for (Index step = 0; to_eliminate_ > 0; ++step) {
      if (step % steps_between_polls == 0) {
        cancelled.check(1 - static_cast<double>(to_eliminate_) / whole, "ordering a matrix");
      }
      eliminate(take_least());
    }
  }

  /// The groups of unknowns that go together, in order, each by its first unknown.
  [[nodiscard]] const Array<Index>& groups() const { return groups_; }
  /// The next unknown of a group, or -1.
  [[nodiscard]] Index next(Index unknown) const { return next_in_group_[unknown]; }

 private:
  static constexpr Index steps_between_polls = 256;

  struct List {
    Index begin = 0, size = 0;
    Index elements = 0;  // how many of an unknown's list are elements
  };

  void set_up(const Neighbours& neighbours) {
    const auto count = static_cast<std::size_t>(neighbours.size());
    lists_.resize(count);
    weight_.assign(count, 1);
    degree_.assign(count, 0);
    outside_.assign(count, 0);
    marks_.assign(count, 0);
    first_of_degree_.assign(count + 1, -1);
    before_.assign(count, -1);
    after_.assign(count, -1);
    next_in_group_.assign(count, -1);
    last_in_group_.resize(count);
    left_ = 0;
    for (Index v = 0; v < neighbours.size(); ++v) {
      last_in_group_[v] = v;
      lists_[v].begin = static_cast<Index>(entries_.size());
      if (roles_[v] == Role::left_out) {
        weight_[v] = 0;
        continue;
      }
      ++left_;
      for (const auto& n : neighbours.of(v)) {
        const Role other = roles_[n.unknown];
        // Between two that are kept for later nobody looks.
        if (other == Role::left_out || (other == Role::later && roles_[v] == Role::later)) continue;
        entries_.push_back(n.unknown);
      }
      lists_[v].size = degree_[v] = static_cast<Index>(entries_.size()) - lists_[v].begin;
      if (roles_[v] != Role::eliminated) continue;
      ++to_eliminate_;
      put_by_degree(v);
    }
  }

  // Unknowns of a degree are in a doubly linked list.
  ///@{
  void put_by_degree(Index v) {
    Index& first = first_of_degree_[degree_[v]];
    before_[v] = -1;
    after_[v] = first;
    if (first >= 0) before_[first] = v;
    first = v;
    least_ = std::min(least_, degree_[v]);
  }
  void take_from_degree(Index v) {
    if (before_[v] >= 0) {
      after_[before_[v]] = after_[v];
    } else {
      first_of_degree_[degree_[v]] = after_[v];
    }
    if (after_[v] >= 0) before_[after_[v]] = before_[v];
  }
  Index take_least() {
    while (first_of_degree_[least_] < 0) ++least_;
    const Index v = first_of_degree_[least_];
    take_from_degree(v);
    return v;
  }
  ///@}

  [[nodiscard]] bool is_later(Index v) const { return roles_[v] == Role::later; }
  [[nodiscard]] std::span<Index> members(Index element) {
    return {entries_.data() + lists_[element].begin,
            static_cast<std::size_t>(lists_[element].size)};
  }

  void eliminate(Index pivot) {
    make_element(pivot);
    measure_outside(pivot);
    candidates_.clear();
    for (const Index v : members(pivot)) shorten_list(v, pivot);
    largest_ = std::max(largest_, degree_[pivot]);
    stamp_ += largest_;
    merge_alike();
    groups_.push_back(pivot);
    settle(pivot);
  }

  // Joins the elements of a pivot and its neighbours; weights are negative while they are members.
  void make_element(Index pivot) {
    const List from = lists_[pivot];
    to_eliminate_ -= weight_[pivot];
    left_ -= weight_[pivot];
    weight_[pivot] = 0;
    const auto begin = static_cast<Index>(entries_.size());
    Index total = 0;
    const auto add = [&](Index v) {
      if (weight_[v] <= 0) return;
      total += weight_[v];
      weight_[v] = -weight_[v];
      entries_.push_back(v);
      if (!is_later(v)) take_from_degree(v);
    };
    for (Index k = 0; k < from.size; ++k) {
      const Index other = entries_[from.begin + k];
      if (k >= from.elements) {
        add(other);
        continue;
      }
      if (outside_[other] < 0) continue;
      const List joined = lists_[other];
      for (Index m = 0; m < joined.size; ++m) add(entries_[joined.begin + m]);
      outside_[other] = gone;
    }
    lists_[pivot] = {begin, static_cast<Index>(entries_.size()) - begin, 0};
    degree_[pivot] = total;
    outside_[pivot] = 0;
  }

  // For each element that shares members with the new one: stamp_ and the weight of its others.
  void measure_outside(Index pivot) {
    for (const Index v : members(pivot)) {
      const Index* const list = entries_.data() + lists_[v].begin;
      for (Index k = 0; k < lists_[v].elements; ++k) {
        std::ptrdiff_t& outside = outside_[list[k]];
        if (outside == gone) continue;
        if (outside < stamp_) outside = stamp_ + degree_[list[k]];
        outside += weight_[v];
      }
    }
  }

  // Puts the new element in a member's list in place of what it makes superfluous there. What
  // depends on nothing else is eliminated at once.
  void shorten_list(Index v, Index pivot) {
    List& list = lists_[v];
    Index* const entries = entries_.data() + list.begin;
    Index degree = 0, kept = 0;
    std::size_t hash = 0;
    for (Index k = 0; k < list.elements; ++k) {
      const Index element = entries[k];
      if (outside_[element] == gone) continue;
      const auto outside = static_cast<Index>(outside_[element] - stamp_);
      if (outside == 0) {
        outside_[element] = gone;  // the new one has all its members
        continue;
      }
      degree += outside;
      hash += static_cast<std::size_t>(element);
      entries[kept++] = element;
    }
    const Index elements = kept;
    for (Index k = list.elements; k < list.size; ++k) {
      const Index other = entries[k];
      if (weight_[other] <= 0) continue;
      degree += weight_[other];
      hash += static_cast<std::size_t>(other);
      entries[kept++] = other;
    }
    if (kept == 0 && !is_later(v)) {
      degree_[pivot] += weight_[v];
      left_ += weight_[v];
      to_eliminate_ += weight_[v];
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
    degree_[v] = std::min(degree_[v], degree);
    candidates_.push_back({hash, v});
  }

  void join_group(Index group, Index v) {
    weight_[v] = 0;
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
        if (weight_[v] == 0) break;
        if (weight_[other->unknown] == 0) continue;
        if (!is_marked) mark_list(v);
        is_marked = true;
        if (!is_like_marked(lists_[other->unknown], lists_[v])) continue;
        weight_[v] += weight_[other->unknown];
        join_group(v, other->unknown);
      }
    }
  }
  void mark_list(Index v) {
    const Index* const entries = entries_.data() + lists_[v].begin;
    ++mark_;
    for (Index k = 1; k < lists_[v].size; ++k) marks_[entries[k]] = mark_;
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
      if (weight_[v] == 0) continue;
      weight_[v] = -weight_[v];
      all[static_cast<std::size_t>(kept++)] = v;
      if (is_later(v)) continue;
      const Index others = degree_[v] + degree_[pivot] - weight_[v];
      degree_[v] = std::min(others, left_ - weight_[v]);
      put_by_degree(v);
    }
    lists_[pivot].size = kept;
    entries_.keep_until(all.data() + kept);
  }

  static constexpr std::ptrdiff_t gone = -1;

  struct Candidate {
    std::size_t hash;
    Index unknown;
  };

  Array<Role> roles_;
  Array<Index> entries_;  // of all lists
  Array<List> lists_;     // of each unknown, or of the element that it became
  Array<Index> weight_;   // how many unknowns go together as one, 0 of the others
  Array<Index> degree_;   // at most how many depend on it; of an element, its members' weight
  Array<std::ptrdiff_t> outside_;  // of each element
  std::ptrdiff_t stamp_ = 1;
  Array<std::ptrdiff_t> marks_;  // of what is in the list that is compared with others
  std::ptrdiff_t mark_ = 0;
  Array<Candidate> candidates_;
  Array<Index> first_of_degree_, before_, after_;
  Array<Index> next_in_group_, last_in_group_;
  Array<Index> groups_;
  Index least_ = 0, largest_ = 0;
  Index left_ = 0, to_eliminate_ = 0;  // unknowns, with those kept for later and without
};

}  // namespace gelight::detail
