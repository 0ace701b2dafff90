#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::detail {

/// A rectangular pad across the camera's axis, its middle at `distance`; bent away from the camera
/// with a radius, if that is finite.
template <std::floating_point T>
[[nodiscard]] Mesh<T> pad(T width, T height, T distance, T radius, T edge_length) {
  require(edge_length > 0 && edge_length <= std::min(width, height), "a pad of ", width, " x ",
          height, " with edge length ", edge_length);
  const auto cells = [&](T side) { return static_cast<Index>(std::ceil(side / edge_length)); };
  Mesh<T> mesh = grid<T>(cells(width), cells(height), width, height);
  for (auto& [x, y, z] : mesh.positions) {
    x -= width / 2;
    y -= height / 2;
    const T square = x * x + y * y;
    z = distance;
    if (std::isfinite(radius)) z -= square / (radius + std::sqrt(radius * radius - square));
  }
  return mesh;
}

}  // namespace gelight::detail
