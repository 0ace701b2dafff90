#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>

#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The point named by the smallest element that holds it, but for rounding. A point all of whose
/// weight is a vertex', but shares that count as none (share_rounding), is that vertex. Of what is
/// left to the other two corners of a face a share as small counts as none too: then the point lies
/// on an edge. So its direction from the vertex stays, however near it is. Equal points become
/// equal in name. The one rule by which sources, queries and paths are at a vertex or on an edge.
template <class Mesh, std::floating_point T>
[[nodiscard]] SurfacePoint<T> simplified(const Mesh& mesh, const SurfacePoint<T>& point) {
  using Kind = typename SurfacePoint<T>::Kind;
  if (point.kind == Kind::vertex) return point;
  std::array<Index, 3> vertices{point.element[0], point.element[1], -1};
  if (point.kind == Kind::face) vertices = mesh.face(point.element[0]);
  const auto& w = point.weights;
  const auto main = static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin());
  const std::size_t a = (main + 1) % 3, b = (main + 2) % 3;
  const T others = w[a] + w[b];
  if (others <= share_rounding<T>) return vertex_point<T>(vertices[main]);
  if (std::min(w[a], w[b]) > share_rounding<T> * others) return point;
  const std::size_t other = w[a] > w[b] ? a : b;
  const bool in_order = vertices[main] < vertices[other];
  const std::size_t low = in_order ? main : other, high = in_order ? other : main;
  return {Kind::edge, {vertices[low], vertices[high]}, {w[low], w[high], 0}};
}

}  // namespace gelight::detail
