#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/bits.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The vertices of a mesh and who their neighbours are, in 82 bytes a vertex, with the faces and
/// positions that points need: what Surface is for methods that go along edges only. A mesh too.
///
/// The length of an edge is measured when it is asked for. Most are not: a number that it is no
/// less than, one byte, tells that the way along it is no shorter than one that is known.
template <std::floating_point Real>
class EdgeGraph {
 public:
  using Scalar = Real;

  /// Copies what it needs of any mesh, in O(vertices + faces), and at no time takes more than a few
  /// bytes a vertex besides what it keeps. Throws InvalidInput as Surface does.
  template <TriangleMesh M>
  explicit EdgeGraph(const M& mesh, const CancelHook& cancelled = {}) {
    const bool is_sound = read_positions(mesh, cancelled) && read_faces(mesh, cancelled) &&
                          link(cancelled) && measure();
    if (!is_sound) refuse_mesh(mesh);
  }

  /// The parts of the mesh, numbered as they were there.
  ///@{
  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(positions_.size()); }
  [[nodiscard]] Index face_count() const { return static_cast<Index>(vertices_.size() / 3); }
  [[nodiscard]] const Vec3<Real>& position(Index vertex) const { return positions_[vertex]; }
  [[nodiscard]] std::array<Index, 3> face(Index f) const {
    const Index* v = vertices_.data() + 3 * std::ptrdiff_t{f};
    return {v[0], v[1], v[2]};
  }
  ///@}

  /// As Surface has them.
  ///@{
  [[nodiscard]] const Array<Index>& components() const {
    return components_.get([&] { return component_of_vertices(vertex_count(), vertices_); });
  }
  void require_vertex(Index vertex) const { require_vertex_of(vertex_count(), vertex); }
  template <std::floating_point U>
  void require_point(const SurfacePoint<U>& point) const {
    require_point_of(vertex_count(), face_count(), point,
                     [&](Index a, Index b) { return are_joined(a, b); });
  }
  ///@}

  /// Length of the edge between two vertices.
  [[nodiscard]] Real length(Index a, Index b) const { return root(squared_length(a, b)); }

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

  /// Calls `visit(vertex, distance)` for the vertices that a point reaches by a straight line:
  /// itself if it is a vertex, else those of the faces that hold it, some perhaps twice.
  void for_each_vertex_near(const SurfacePoint<Real>& point, auto&& visit) const {
    using Kind = typename SurfacePoint<Real>::Kind;
    const Index a = point.element[0], b = point.element[1];
    if (point.kind == Kind::vertex) return visit(a, Real(0));
    const auto visit_face = [&](Index f, const std::array<Index, 3>& corners) {
      for (const Index v : face(f)) visit(v, straight_distance(corners, point.weights, v));
    };
    if (point.kind == Kind::face) return visit_face(a, face(a));
    for (const Index h : corners_at(a)) {
      const Index next = Mesh::next(h), previous = Mesh::previous(h);
      if (vertices_[next] == b || vertices_[previous] == b) visit_face(h / 3, {a, b, -1});
    }
  }

 private:
  using Mesh = Surface<Real>;

  // Lengths are told apart by the exponent and two binary digits of their squares; those below the
  // 255 largest such classes, 2^-32 of the longest, are in one.
  static constexpr int class_shift = 50, class_count = 256;
  static std::int64_t class_of(Real squared_length) {
    return static_cast<std::int64_t>(bit_cast<std::uint64_t>(double{squared_length}) >>
                                     class_shift);
  }

  // What Surface measures: a square vanishes or rounds for lengths only that count as none.
  static Real root(Real squared_length) {
    const Real length = std::sqrt(squared_length);
    return length < shortest_length ? Real(0) : length;
  }

  template <TriangleMesh M>
  [[nodiscard]] bool read_positions(const M& mesh, const CancelHook& cancelled) {
    const auto count = MeshTraits<M>::vertex_count(mesh);
    if (!is_count(count, 1)) return false;
    positions_.resize(static_cast<std::size_t>(count));
    PeriodicCheck progress(cancelled, static_cast<Index>(count), reading_mesh);
    for (Index v = 0; v < vertex_count(); ++v) {
      const auto& p = MeshTraits<M>::position(mesh, v);
      const Vec3<Real> q(static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2]));
      for (int k = 0; k < 3; ++k) {
        if (!(std::fabs(q[k]) <= largest_coordinate)) return false;
      }
      positions_[v] = q;
      progress.step();
    }
    return true;
  }

  template <TriangleMesh M>
  [[nodiscard]] bool read_faces(const M& mesh, const CancelHook& cancelled) {
    const auto count = MeshTraits<M>::face_count(mesh);
    if (!is_count(count, 3)) return false;
    vertices_.resize(3 * static_cast<std::size_t>(count));
    Index* to = vertices_.data();
    PeriodicCheck progress(cancelled, static_cast<Index>(count), reading_mesh);
    for (Index f = 0; f < face_count(); ++f, to += 3) {
      const std::array<Index, 3> face = MeshTraits<M>::face(mesh, f);
      const auto [a, b, c] = face;
      if (std::min({a, b, c}) < 0 || std::max({a, b, c}) >= vertex_count()) return false;
      if (a == b || b == c || c == a) return false;
      to[0] = a;
      to[1] = b;
      to[2] = c;
      progress.step();
    }
    return true;
  }

  static bool is_count(std::integral auto count, Index per) {
    return count > 0 && std::cmp_less_equal(count, std::numeric_limits<Index>::max() / per);
  }

  // Surface says what is wrong with the mesh.
  template <TriangleMesh M>
  [[noreturn, gnu::cold, gnu::noinline]] static void refuse_mesh(const M& mesh) {
    (void)Mesh(mesh);
    refuse({"the mesh was another one when it was read again"});
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
    neighbours_.resize(vertices_.size() + room);
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
      if (any_twins || (any_crowded && has_twins(corners))) return false;
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

  // Whether two of a vertex' faces have the same other vertices.
  [[nodiscard, gnu::cold, gnu::noinline]] bool has_twins(Slice<const Index> corners) const {
    Array<std::pair<Index, Index>> others;
    for (const Index h : corners) {
      others.push_back(std::minmax(vertices_[Mesh::next(h)], vertices_[Mesh::previous(h)]));
    }
    std::sort(others.begin(), others.end());
    return std::adjacent_find(others.begin(), others.end()) != others.end();
  }

  // False where edges have a length, but none that counts as one.
  [[nodiscard]] bool measure() {
    Real most = 0;
    for_each_edge([&](Index a, Index b) { most = std::max(most, squared_length(a, b)); });
    if (root(most) == 0) {
      bool any_apart = false;
      for_each_edge([&](Index a, Index b) { any_apart |= positions_[a] != positions_[b]; });
      if (any_apart) return false;
    }
    const std::int64_t below = class_of(most) - (class_count - 1);
    for (std::int64_t c = std::max<std::int64_t>(1, -below); c < class_count; ++c) {
      const auto bits = static_cast<std::uint64_t>(below + c) << class_shift;
      least_[static_cast<std::size_t>(c)] = root(static_cast<Real>(bit_cast<double>(bits)));
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

  [[nodiscard]] Real squared_length(Index a, Index b) const {
    return sum_of_squares(positions_[b] - positions_[a]);
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

  // From a vertex to the point with these shares of the corners of a face or an edge: as Surface
  // tells the difference, to the last bit.
  [[nodiscard]] Real straight_distance(const std::array<Index, 3>& corners,
                                       const std::array<Real, 3>& shares, Index vertex) const {
    Vec3<Real> way(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      if (corners[k] < 0 || corners[k] == vertex) continue;
      way += shares[k] * (positions_[corners[k]] - positions_[vertex]);
    }
    return stable_norm(way);
  }

  // Half-edges, numbered as Surface's are, grouped by their origins.
  struct Corners {
    Array<Index> halfedges, begin;
  };
  [[nodiscard]] Slice<const Index> corners_at(Index vertex) const {
    const Corners& corners = corners_.get([&] {
      Corners made{Array<Index>(vertices_.size()), {}};
      made.begin = group_corners(vertex_count(), vertices_, made.halfedges.data());
      return made;
    });
    const Index begin = corners.begin[vertex], end = corners.begin[vertex + 1];
    return {corners.halfedges.data() + begin, static_cast<std::size_t>(end - begin)};
  }

  Array<Vec3<Real>> positions_;
  Array<Index> vertices_;  // of each face: three
  Array<Index> begin_;     // of each vertex, and one more: where its neighbours begin
  Array<Index> neighbours_;
  Array<std::uint8_t> classes_;            // of each neighbour: that of the edge's length
  std::array<Real, class_count> least_{};  // of each class: no more than any length of it
  Real short_length_ = 0;
  Lazy<Array<Index>> components_;
  Lazy<Corners> corners_;  // for points on edges
};

/// A number no less than the length of any shortest path.
template <std::floating_point Real>
[[nodiscard]] Real longest_way(const EdgeGraph<Real>& graph) {
  return 4 * graph.total_length();  // as of a surface none of whose edges is a border
}

}  // namespace gelight::detail
