#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

// A light field is, for each of a list of surface points, the unit direction in which the light of
// one LED travels there, or zero where it has none: at the LED, where no light arrives, and where
// it arrives from opposite sides.

namespace gelight {

template <std::floating_point T>
using LightField = std::vector<Vec3<T>>;

/// The surface points of all vertices.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> vertex_points(const Surface<T>& surface) {
  std::vector<SurfacePoint<T>> points;
  points.reserve(static_cast<std::size_t>(surface.vertex_count()));
  for (Index v = 0; v < surface.vertex_count(); ++v) points.push_back(vertex_point<T>(v));
  return points;
}

namespace detail {

/// Unit vector, or zero for a vector without direction.
template <class T>
[[nodiscard]] Vec3<T> direction_of(const Vec3<T>& v) {
  const T length = v.stableNorm();
  return length > 0 ? Vec3<T>(v / length) : Vec3<T>::Zero();
}

/// Twice the area of a face times its unit normal.
template <std::floating_point T>
[[nodiscard]] Vec3<T> face_normal(const Surface<T>& surface, Index f) {
  const auto [a, b, c] = surface.face(f);
  const Vec3<T> ab = surface.position(b) - surface.position(a);
  const Vec3<T> ac = surface.position(c) - surface.position(a);
  return cross(ab, ac);
}

/// A point nearer to a side of its face than this share of the face's height is taken to be on it.
template <std::floating_point T>
inline constexpr T faces_at_snap = std::max(T(1e-9), 64 * std::numeric_limits<T>::epsilon());

/// The faces that hold a point. One that is almost on a side of its face also counts for the
/// neighbour, so that rounding cannot lose it between the two.
template <std::floating_point T>
[[nodiscard]] Array<Index> faces_at(const Surface<T>& surface, const SurfacePoint<T>& point) {
  constexpr T snap = faces_at_snap<T>;
  using Kind = typename SurfacePoint<T>::Kind;
  const auto around_vertex = [&](Index v) {
    Array<Index> faces;
    for (const Index h : surface.corners(v)) faces.push_back(Surface<T>::face_of(h));
    return faces;
  };
  const auto around_edge = [&](Index first) {
    Array<Index> faces;
    Index h = first;
    do {
      faces.push_back(Surface<T>::face_of(h));
      h = surface.twin(h);
    } while (h != first);
    return faces;
  };
  const auto [a, b] = point.element;
  const auto& w = point.weights;
  if (point.kind == Kind::vertex) return around_vertex(a);
  if (point.kind == Kind::edge) {
    if (w[0] <= snap) return around_vertex(b);
    if (w[1] <= snap) return around_vertex(a);
    return around_edge(surface.find_halfedge(a, b));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3, previous = (k + 2) % 3;
    if (w[next] <= snap && w[previous] <= snap) return around_vertex(surface.face(a)[k]);
  }
  for (Index k = 0; k < 3; ++k) {
    if (w[static_cast<std::size_t>(k)] <= snap) return around_edge(3 * a + (k + 1) % 3);
  }
  return {a};
}

}  // namespace detail
}  // namespace gelight
