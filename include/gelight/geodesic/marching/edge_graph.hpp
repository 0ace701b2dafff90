#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/bits.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/marching/face_list.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The vertices of a mesh and who their neighbours are, in 82 bytes a vertex, with the faces and
/// positions that points need: what Surface is for methods that go along edges only. A mesh too.
///
/// The length of an edge is measured when it is asked for. Most are not: a number that it is no
/// less than, one byte, tells that the way along it is no shorter than one that is known.
template <std::floating_point Real>
class EdgeGraph : public FaceList<Real> {
  using Faces = FaceList<Real>;

 public:
  using Faces::length, Faces::squared_length, Faces::vertex_count;

  /// Of a mesh as `read_mesh` reads it, in O(vertices + faces); at no time takes more than a few
  /// bytes a vertex besides what it keeps. Throws InvalidInput as Surface does.
  explicit EdgeGraph(MeshArrays<Real> mesh, const CancelHook& cancelled) : Faces(std::move(mesh)) {
    if (!(link(cancelled) && measure())) this->refuse_faces();
  }

  /// As Surface has it.
  template <std::floating_point U>
  void require_point(const SurfacePoint<U>& point) const {
    require_point_of(vertex_count(), this->face_count(), point,
                     [&](Index a, Index b) { return are_joined(a, b); });
  }

  /// The sum of the lengths of all edges.
  [[nodiscard]] Real total_length() const {
    Real sum = 0;
    for_each_edge([&](Index a, Index b) { sum += length(a, b); });
    return sum;
  }

  /// About the length that a tenth of the edges fall short of.
  [[nodiscard]] Real short_length() const { return short_length_; }

  /// Calls `reach(neighbour, distance)` for those that the vertex, itself at distance d, makes
  /// nearer than `distance` tells.
  [[gnu::always_inline]] void for_each_nearer(Index vertex, Real d, Slice<const Real> distance,
                                              auto&& reach) const {
    const Index end = begin_[vertex + 1];
    for (Index i = begin_[vertex]; i < end; ++i) {
      const Index neighbour = neighbours_[i];
      const Real known = distance[neighbour];
      if (d + least_[classes_[i]] >= known) continue;
      const Real way = d + length(vertex, neighbour);
      if (way < known) reach(neighbour, way);
    }
  }

  /// Takes a vertex from the queue, and has the memory fetched that those after it will ask for.
  template <class Queue>
  [[nodiscard, gnu::always_inline]] std::pair<Index, Real> pop_and_prefetch(
      Queue& queue, Slice<const Real> distance) const {
    constexpr unsigned long_before = 6, before = 3, just_before = 1;
    constexpr std::size_t typical_neighbours = 7;
    const auto popped = queue.pop();
    if (const Index w = queue.next_or(-1, long_before); w >= 0) {
      prefetch(begin_.data() + w, sizeof(Index));
    }
    if (const Index w = queue.next_or(-1, before); w >= 0) {
      prefetch(neighbours_.data() + begin_[w], typical_neighbours * sizeof(Index));
      prefetch(classes_.data() + begin_[w], typical_neighbours);
      prefetch(positions_.data() + w, sizeof(Vec3<Real>));
    }
    if (const Index w = queue.next_or(-1, just_before); w >= 0) {
      const Index end = begin_[w + 1];
      for (Index i = begin_[w]; i < end; ++i) {
        prefetch(distance.data() + neighbours_[i], sizeof(Real));
        prefetch(positions_.data() + neighbours_[i], sizeof(Vec3<Real>));
      }
    }
    return popped;
  }

 private:
  using Faces::positions_, Faces::vertices_;
  using Mesh = Surface<Real>;

  // Lengths are told apart by the exponent and two binary digits of their squares; those below the
  // 255 largest such classes, 2^-32 of the longest, are in one.
  static constexpr int class_shift = 50, class_count = 256;
  static std::int64_t class_of(Real squared_length) {
    return static_cast<std::int64_t>(bit_cast<std::uint64_t>(double{squared_length}) >>
                                     class_shift);
  }

  // The last face that was found between a vertex and another: its third corner.
  struct Latest {
    Index vertex = -1, apex = -1;
  };

  // Finds the neighbours of each vertex, those of the first written over the corners that are read
  // no more. False where two faces have the same three vertices.
  [[nodiscard]] bool link(const CancelHook& cancelled) {
    // A vertex has as many neighbours as corners, but at a border, where it has one more.
    std::size_t room = vertices_.size() / 64 + 64;
    neighbours_.resize_for_writes(vertices_.size() + room);
    begin_ = group_corners(vertex_count(), vertices_, neighbours_.data() + room);
    Array<Latest> latest(positions_.size());
    Index filled = 0;
    PeriodicCheck progress(cancelled, vertex_count(), reading_mesh);
    for (Index v = 0; v < vertex_count(); ++v) {
      const Index first = std::exchange(begin_[v], filled), last = begin_[v + 1];
      const auto most =
          static_cast<std::size_t>(filled) + 2 * static_cast<std::size_t>(last - first);
      if (most > room + static_cast<std::size_t>(first))
        room = make_room(filled, first, last, room);
      const Slice<const Index> corners(neighbours_.data() + room + first,
                                       static_cast<std::size_t>(last - first));
      bool any_twins = false, any_crowded = false;
      const auto join = [&](Index end, Index apex) {
        Latest& before = latest[end];
        if (before.vertex != v) {
          before = {v, apex};
          neighbours_[filled++] = end;
          return;
        }
        any_twins |= before.apex == apex;
        any_crowded |= before.apex < 0;
        before.apex = -1;
      };
      for (const Index h : corners) {
        const Index tip = vertices_[Mesh::next(h)], apex = vertices_[Mesh::previous(h)];
        join(tip, apex);
        join(apex, tip);
      }
      if (any_twins || (any_crowded && Faces::has_twins(corners))) return false;
      progress.step();
    }
    begin_.back() = filled;
    neighbours_.resize(static_cast<std::size_t>(filled));
    return true;
  }

  // Moves the corners that are still to be read away from the neighbours that were found.
  [[gnu::cold, gnu::noinline]] std::size_t make_room(Index filled, Index first, Index last,
                                                     std::size_t room) {
    const std::size_t more = neighbours_.size() / 8 + 2 * static_cast<std::size_t>(last - first);
    Array<Index> larger(neighbours_.size() + more);
    std::copy_n(neighbours_.begin(), filled, larger.begin());
    std::copy(neighbours_.begin() + room + first, neighbours_.end(),
              larger.begin() + room + more + first);
    neighbours_.swap(larger);
    return room + more;
  }

  // False where edges have a length, but none that counts as one.
  [[nodiscard]] bool measure() {
    Real most = 0;
    for_each_edge([&](Index a, Index b) { most = std::max(most, squared_length(a, b)); });
    if (Faces::root(most) == 0 && this->any_edge_is_long()) return false;
    const std::int64_t below = class_of(most) - (class_count - 1);
    for (std::int64_t c = std::max<std::int64_t>(1, -below); c < class_count; ++c) {
      const auto bits = static_cast<std::uint64_t>(below + c) << class_shift;
      least_[static_cast<std::size_t>(c)] = Faces::root(static_cast<Real>(bit_cast<double>(bits)));
    }
    std::array<Index, class_count> counts{};
    classes_.reserve(neighbours_.size());
    for (Index v = 0; v < vertex_count(); ++v) {
      for (Index i = begin_[v]; i < begin_[v + 1]; ++i) {
        const std::int64_t c = class_of(squared_length(v, neighbours_[i])) - below;
        classes_.push_back(static_cast<std::uint8_t>(std::max<std::int64_t>(c, 0)));
        ++counts[classes_.back()];
      }
    }
    Index rank = (static_cast<Index>(classes_.size()) - counts[0]) / 10;
    std::size_t c = 1;
    for (; c + 1 < class_count && rank >= counts[c]; ++c) rank -= counts[c];
    short_length_ = least_[c];
    return true;
  }

  void for_each_edge(auto&& visit) const {
    for (Index v = 0; v < vertex_count(); ++v) {
      for (Index i = begin_[v]; i < begin_[v + 1]; ++i) {
        if (neighbours_[i] > v) visit(v, neighbours_[i]);
      }
    }
  }

  [[nodiscard]] bool are_joined(Index a, Index b) const {
    const Index* const end = neighbours_.begin() + begin_[a + 1];
    return std::find(neighbours_.begin() + begin_[a], end, b) != end;
  }

  Array<Index> begin_;  // of each vertex, and one more: where its neighbours begin
  Array<Index> neighbours_;
  Array<std::uint8_t> classes_;            // of each neighbour: that of the edge's length
  std::array<Real, class_count> least_{};  // of each class: no more than any length of it
  Real short_length_ = 0;
};

/// A number no less than the length of any shortest path.
template <std::floating_point Real>
[[nodiscard]] Real longest_way(const EdgeGraph<Real>& graph) {
  return 4 * graph.total_length();  // as of a surface none of whose edges is a border
}

}  // namespace gelight::detail
