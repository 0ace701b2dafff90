#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/simplified.hpp"

namespace gelight::detail {

/// The waves of several sources at the vertices of a mesh, a node each. A node tells its `distance`
/// (infinite at first), its `wave` (the number of its source) and the `next` of the same vertex,
/// both -1 where there is none; and whether the wave `leads` on from there. The first
/// `vertex_count` nodes are the vertices' first ones.
template <class Node>
struct Waves {
  // A wave is handed on where it is late by this many mean edges at most: a line that crosses an
  // edge in front of the place where waves meet has ends behind it by up to two of their edges.
  static constexpr double most_delay_in_edges = 2;
  // And by so many from one vertex, the nearest: of sources side by side, as on a curve, all are
  // late by little, the more of them the farther away. (From curves of four sources an edge fast
  // marching's answer is up to 0.024 edges beyond that of the nearest source alone, as without this
  // limit; with half of it it is up to 0.09.)
  static constexpr int most_leading = 64;

  Array<Node> nodes;
  Array<Index> owner;  // vertex of each node after the first ones

  void reset(Index vertex_count) {
    nodes.assign(static_cast<std::size_t>(vertex_count), {});
    owner.clear();
    table_.clear();
  }

  /// Keeps references to nodes good while no more than `count` are made.
  void reserve_more(Index count) {
    const std::size_t needed = nodes.size() + static_cast<std::size_t>(count);
    if (needed > nodes.capacity()) nodes.reserve(std::max(needed, 2 * nodes.capacity()));
  }

  [[nodiscard]] Index vertex_of(Index node) const {
    const auto later = static_cast<std::ptrdiff_t>(node) - (std::ssize(nodes) - std::ssize(owner));
    return later < 0 ? node : owner[later];
  }

  /// Whichever wave it is of.
  [[nodiscard]] double best(Index v) const {
    double least = nodes[v].distance;
    for (Index n = nodes[v].next; n >= 0; n = nodes[n].next) {
      least = std::min(least, nodes[n].distance);
    }
    return least;
  }

  /// Whether the wave of a node of a vertex, whose turn it is, leads on from there.
  [[nodiscard]] bool may_lead(Index v, Index node, double most_delay) const {
    const double distance = nodes[node].distance;
    double least = distance;
    int nearer = 0;
    for (Index n = v; n >= 0; n = nodes[n].next) {
      if (!(nodes[n].distance < distance)) continue;
      least = std::min(least, nodes[n].distance);
      if (nodes[n].leads) ++nearer;
    }
    return nearer < most_leading && distance <= least + most_delay;
  }

  /// Whether no other wave has been at a vertex.
  [[nodiscard]] bool is_alone(Index v, Index wave) const {
    return nodes[v].next < 0 && (nodes[v].wave == wave || nodes[v].wave < 0);
  }

  /// Whether no other wave has been where a node is, nor at the other ends of its spokes.
  template <class Spoke>
  [[nodiscard]] bool is_alone_round(Index node, const Array<Index>& begin,
                                    const Array<Spoke>& spokes) const {
    const Index wave = nodes[node].wave;
    if (node >= std::ssize(nodes) - std::ssize(owner) || !is_alone(node, wave)) return false;
    for (Index s = begin[node]; s < begin[node + 1]; ++s) {
      if (!is_alone(spokes[s].end, wave)) return false;
    }
    return true;
  }

  /// The node that a wave has at a vertex, or may have if no other has been there, or -1.
  [[nodiscard]] Index find(Index v, Index wave) const {
    return is_alone(v, wave) ? v : find_among(v, wave);
  }

  /// The same, and a new one where it has none, if it is the first there or `may_be_late`.
  [[nodiscard]] Index place_for(Index v, double distance, Index wave, bool may_be_late) {
    if (is_alone(v, wave)) return v;
    return place_among(v, distance, wave, may_be_late);
  }

 private:
  [[nodiscard, gnu::noinline]] Index find_among(Index v, Index wave) const {
    if (nodes[v].wave == wave) return v;
    if (nodes[v].next < 0) return -1;
    for (std::size_t slot = first_slot(v, wave);; slot = after(slot)) {
      const Index n = table_[slot];
      if (n < 0 || (nodes[n].wave == wave && vertex_of(n) == v)) return n;
    }
  }

  [[nodiscard, gnu::noinline]] Index place_among(Index v, double distance, Index wave,
                                                 bool may_be_late) {
    if (!(distance < unreachable<double>) || (!may_be_late && !(distance < best(v)))) return -1;
    const Index known = find_among(v, wave);
    if (known >= 0) return known;
    const auto n = static_cast<Index>(nodes.size());
    nodes.push_back({});
    owner.push_back(v);
    nodes[n].wave = wave;
    nodes[n].next = std::exchange(nodes[v].next, n);
    if (2 * owner.size() > table_.size()) {
      enter_all();
    } else {
      enter(n);
    }
    return n;
  }

  // Where the nodes after the first ones are, by vertex and wave: each in the first slot from its
  // own on that was free. (Walks along lists would be long where sources lie side by side.)
  [[nodiscard]] std::size_t first_slot(Index v, Index wave) const {
    const auto mixed = static_cast<std::uint64_t>(v) * 0x9E3779B97F4A7C15U +
                       static_cast<std::uint64_t>(wave) * 0xC2B2AE3D27D4EB4FU;
    return static_cast<std::size_t>(mixed >> 32) & (table_.size() - 1);
  }
  [[nodiscard]] std::size_t after(std::size_t slot) const {
    return (slot + 1) & (table_.size() - 1);
  }
  void enter(Index n) {
    std::size_t slot = first_slot(vertex_of(n), nodes[n].wave);
    while (table_[slot] >= 0) slot = after(slot);
    table_[slot] = n;
  }
  void enter_all() {
    table_.assign(std::max(least_slots, 2 * table_.size()), -1);
    const std::size_t first = nodes.size() - owner.size();
    for (std::size_t n = first; n < nodes.size(); ++n) enter(static_cast<Index>(n));
  }

  static constexpr std::size_t least_slots = 64;  // a power of two, as all sizes of the table
  Array<Index> table_;
};

/// A source that was named before starts no wave of its own, nor does one that starts later there.
template <class Mesh, std::floating_point Real>
void keep_different(const Mesh& mesh, Array<Source<Real>>& sources) {
  const auto less = [](const Source<Real>& a, const Source<Real>& b) {
    return std::tie(a.point.kind, a.point.element, a.point.weights, a.distance) <
           std::tie(b.point.kind, b.point.element, b.point.weights, b.distance);
  };
  for (auto& source : sources) source.point = simplified(mesh, source.point);
  std::make_heap(sources.begin(), sources.end(), less);
  std::sort_heap(sources.begin(), sources.end(), less);  // less to compile than std::sort
  const auto same = [](const auto& a, const auto& b) { return a.point == b.point; };
  sources.keep_until(std::unique(sources.begin(), sources.end(), same));
}

}  // namespace gelight::detail
