#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gelight/core/array.hpp"
#include "gelight/core/bits.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The length that a tenth of the edges fall short of that have one: about what a vertex adds to
/// the distance of the last, on a mesh of edges long and short too. All lengths are shown to it
/// twice.
template <std::floating_point T>
class ShortLength {
 public:
  /// The first time.
  void count(T length) {
    if (!(length > 0)) return;
    if (all_ == 0) first_class_ = class_of(length) - class_count / 2;
    ++counts_[place_of(length)];
    ++all_;
  }

  /// The second time, in any order, but for those that are not sought.
  ///@{
  [[nodiscard]] bool seeks(T length) {
    if (lengths_.capacity() == 0) choose();
    return length > 0 && place_of(length) == wanted_;
  }
  void collect(T length) {
    if (seeks(length)) lengths_.push_back(length);
  }
  ///@}

  /// What was sought, 0 where no edge has a length.
  [[nodiscard]] T length() {
    if (all_ == 0) return 0;
    std::nth_element(lengths_.begin(), lengths_.begin() + rank_, lengths_.end());
    return lengths_[rank_];
  }

 private:
  // Lengths are counted by their exponent and four binary digits, those much longer or shorter than
  // the first together with the next, and sorted within one such class.
  static constexpr std::ptrdiff_t class_count = 1024;

  static std::ptrdiff_t class_of(T length) {
    return static_cast<std::ptrdiff_t>(bit_cast<std::uint64_t>(double{length}) >> 48);
  }
  [[nodiscard]] std::size_t place_of(T length) const {
    return static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(class_of(length) - first_class_, 0, class_count - 1));
  }
  void choose() {
    rank_ = all_ / 10;
    if (all_ > 0) {
      for (; rank_ >= counts_[wanted_]; ++wanted_) rank_ -= counts_[wanted_];
    }
    lengths_.reserve(static_cast<std::size_t>(counts_[wanted_]) + 1);
  }

  std::array<Index, class_count> counts_{};
  std::ptrdiff_t first_class_ = 0;
  Index all_ = 0, rank_ = 0;
  std::size_t wanted_ = 0;
  Array<T> lengths_;
};

/// The same of a surface.
template <std::floating_point T>
T short_edge_length(const Surface<T>& surface) {
  ShortLength<T> sought;
  for (Index h = 0; h < surface.halfedge_count(); ++h) sought.count(surface.length(h));
  for (Index h = 0; h < surface.halfedge_count(); ++h) sought.collect(surface.length(h));
  return sought.length();
}

/// Calls `visit(face, shares)` for each face that holds the point, with the point's shares of its
/// corners.
template <std::floating_point T>
inline void for_each_place(const Surface<T>& surface, const SurfacePoint<T>& point, auto&& visit) {
  using Kind = typename SurfacePoint<T>::Kind;
  const auto shares = [](Index h, T at_origin, T at_tip) {
    std::array<T, 3> weights{0, 0, 0};
    weights[static_cast<std::size_t>(h % 3)] = at_origin;
    weights[static_cast<std::size_t>((h + 1) % 3)] = at_tip;
    return weights;
  };
  const auto& w = point.weights;
  if (point.kind == Kind::face) return visit(point.element[0], w);
  if (point.kind == Kind::vertex) {
    for (const Index h : surface.corners(point.element[0]))
      visit(surface.face_of(h), shares(h, 1, 0));
    return;
  }
  const Index first = surface.find_halfedge(point.element[0], point.element[1]);
  Index h = first;
  do {
    const bool same = surface.origin(h) == point.element[0];
    visit(surface.face_of(h), shares(h, w[same ? 0 : 1], w[same ? 1 : 0]));
    h = surface.twin(h);
  } while (h != first);
}

/// Calls `visit(face)` for each face that holds the point.
template <std::floating_point T>
inline void for_each_face_at(const Surface<T>& surface, const SurfacePoint<T>& point,
                             auto&& visit) {
  for_each_place(surface, point, [&](Index f, const std::array<T, 3>&) { visit(f); });
}

/// Whether a face holds a point.
template <std::floating_point T>
[[nodiscard]] bool holds(const Surface<T>& surface, Index face, const SurfacePoint<T>& point) {
  using Kind = typename SurfacePoint<T>::Kind;
  const auto [a, b] = point.element;
  if (point.kind == Kind::face) return face == a;
  bool has_a = false, has_b = point.kind == Kind::vertex;
  for (const Index v : surface.face(face)) {
    has_a |= v == a;
    has_b |= v == b;
  }
  return has_a & has_b;
}

/// Whether a face holds both points.
template <std::floating_point T>
[[nodiscard]] bool share_face(const Surface<T>& surface, const SurfacePoint<T>& p,
                              const SurfacePoint<T>& q) {
  bool shared = false;
  for_each_face_at(surface, p, [&](Index f) { shared |= holds(surface, f, q); });
  return shared;
}

/// The longest side of the faces that hold a point.
template <std::floating_point T>
[[nodiscard]] T longest_side_at(const Surface<T>& surface, const SurfacePoint<T>& point) {
  T longest = 0;
  for_each_face_at(surface, point, [&](Index f) {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) longest = std::max(longest, surface.length(h));
  });
  return longest;
}

/// Length of the straight line from a point to a vertex of a face that holds both.
template <std::floating_point T>
T straight_distance(const Surface<T>& surface, const SurfacePoint<T>& point, Index vertex) {
  return stable_norm(surface.difference(vertex_point<T>(vertex), point));
}

/// Calls `visit(vertex, distance)` for the vertices that a point reaches by a straight line: itself
/// if it is a vertex, else those of the faces that hold it, some perhaps twice.
template <std::floating_point T>
inline void for_each_vertex_near(const Surface<T>& surface, const SurfacePoint<T>& point,
                                 auto&& visit) {
  if (point.kind == SurfacePoint<T>::Kind::vertex) return visit(point.element[0], T(0));
  for_each_face_at(surface, point, [&](Index f) {
    for (const Index v : surface.face(f)) visit(v, straight_distance(surface, point, v));
  });
}

}  // namespace gelight::detail
