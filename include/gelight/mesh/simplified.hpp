#pragma once

#include <array>
#include <concepts>
#include <cstddef>

#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The point named by the smallest element that holds it, but for rounding: a point of an edge or a
/// face is the vertex that has all of its weight but shares that count as none (share_rounding), a
/// point of a face lies on the edge that has. Equal points become equal in name too. The one rule
/// by which sources, queries and paths are at a vertex or on an edge.
template <std::floating_point T>
[[nodiscard]] SurfacePoint<T> simplified(const Surface<T>& surface, const SurfacePoint<T>& point) {
  using Kind = typename SurfacePoint<T>::Kind;
  if (point.kind == Kind::vertex) return point;
  std::array<Index, 3> vertices{point.element[0], point.element[1], -1};
  if (point.kind == Kind::face) vertices = surface.face(point.element[0]);
  std::array<Index, 3> used{};
  std::array<T, 3> weights{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(point.weights[k] > share_rounding<T>)) continue;
    used[count] = vertices[k];
    weights[count++] = point.weights[k];
  }
  if (count == 3) return point;
  if (count == 1) return vertex_point<T>(used[0]);
  const std::size_t low = used[0] < used[1] ? 0 : 1;
  return {Kind::edge, {used[low], used[1 - low]}, {weights[low], weights[1 - low], 0}};
}

}  // namespace gelight::detail
