#pragma once

#include <array>
#include <concepts>
#include <cstdint>

#include "gelight/core/types.hpp"

namespace gelight {

/// A point of a surface: at a vertex, on an edge or inside a face. Made by vertex_point, edge_point
/// and face_point; a solver that is given one checks it against its mesh.
template <std::floating_point T>
struct SurfacePoint {
  /// What the point lies on.
  enum class Kind : std::uint8_t { vertex, edge, face };

  Kind kind = Kind::vertex;  ///< what the point lies on
  /// The vertex, the edge's two vertices, or the face; the rest is -1.
  std::array<Index, 2> element{-1, -1};
  /// Shares of the vertex, of the edge's vertices, or of the face's; they sum to 1.
  std::array<T, 3> weights{1, 0, 0};

  /// Whether element and weights are equal; a vertex has many names as a point of faces.
  friend bool operator==(const SurfacePoint&, const SurfacePoint&) = default;

  /// The same point in another precision, its weights summing to 1 again.
  template <std::floating_point U>
  [[nodiscard]] SurfacePoint<U> cast() const {
    const std::array<U, 3> w{static_cast<U>(weights[0]), static_cast<U>(weights[1]),
                             static_cast<U>(weights[2])};
    const U sum = w[0] + w[1] + w[2];
    return {static_cast<typename SurfacePoint<U>::Kind>(kind),
            element,
            {w[0] / sum, w[1] / sum, w[2] / sum}};
  }
};

/// A vertex as a point.
template <std::floating_point T>
[[nodiscard]] SurfacePoint<T> vertex_point(Index vertex) {
  return {SurfacePoint<T>::Kind::vertex, {vertex, -1}, {1, 0, 0}};
}

/// The point (1 - t) v0 + t v1 of the edge between two vertices, 0 <= t <= 1.
template <std::floating_point T>
[[nodiscard]] SurfacePoint<T> edge_point(Index v0, Index v1, T t) {
  return {SurfacePoint<T>::Kind::edge, {v0, v1}, {1 - t, t, 0}};
}

/// The point of a face with these barycentric coordinates, which are not negative and sum to 1.
template <std::floating_point T>
[[nodiscard]] SurfacePoint<T> face_point(Index face, const std::array<T, 3>& barycentric) {
  return {SurfacePoint<T>::Kind::face, {face, -1}, barycentric};
}

/// Where a distance starts, and the distance it starts with (in the unit of the positions).
template <std::floating_point T>
struct Source {
  SurfacePoint<T> point;  ///< where
  T distance = 0;         ///< with how much
};

namespace detail {
/// What stands for a point, with a start distance or without.
template <class Place, class T>
concept PointOf = std::same_as<Place, Source<T>> || std::same_as<Place, SurfacePoint<T>>;
}  // namespace detail

}  // namespace gelight
