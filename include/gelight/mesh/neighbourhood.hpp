#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gelight/core/bits.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// About the length that a tenth of the edges fall short of that have one, and no more than it:
/// what a vertex adds to the distance of the last, on a mesh of edges long and short too.
class ShortLength {
 public:
  /// All are to be counted, in any order.
  void count(double length) {
    if (!(length > 0)) return;
    ++counts_[static_cast<std::size_t>(class_of(length) - first_class)];
    ++all_;
  }

  /// What was sought, to four binary digits; 0 where no edge has a length.
  [[nodiscard]] double length() const {
    if (all_ == 0) return 0;
    std::uint64_t found = first_class;
    Index rank = all_ / 10;
    for (const Index count : counts_) {
      if (rank < count) break;
      rank -= count;
      ++found;
    }
    return bit_cast<double>(found << class_shift);
  }

 private:
  // Lengths are told apart by their exponent and four binary digits.
  static constexpr int class_shift = 48;
  static constexpr auto class_of = [](double length) {
    return bit_cast<std::uint64_t>(length) >> class_shift;
  };
  static constexpr std::uint64_t first_class = class_of(shortest_length),
                                 last_class = class_of(4 * largest_coordinate);

  std::array<Index, last_class - first_class + 1> counts_{};
  Index all_ = 0;
};

/// The same of a surface.
template <std::floating_point T>
double short_edge_length(const Surface<T>& surface) {
  ShortLength sought;
  for (Index h = 0; h < surface.halfedge_count(); ++h) sought.count(surface.length(h));
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

/// Whether a face holds both points.
template <std::floating_point T>
[[nodiscard]] bool share_face(const Surface<T>& surface, const SurfacePoint<T>& p,
                              const SurfacePoint<T>& q) {
  bool shared = false;
  for_each_face_at(surface, p, [&](Index f) {
    for_each_face_at(surface, q, [&](Index g) { shared |= f == g; });
  });
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
