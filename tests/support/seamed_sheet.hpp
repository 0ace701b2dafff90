#pragma once

#include <concepts>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::test {

template <std::floating_point T>
bool is_taken(const Mesh<T>& mesh) {
  try {
    Surface surface(mesh);
  } catch (const InvalidInput&) {
    return false;
  }
  return true;
}

inline bool carries_vectors(const Mesh<double>& mesh) {
  try {
    require_oriented(Surface(mesh));
  } catch (const InvalidInput&) {
    return false;
  }
  return true;
}

// Two sheets of 1 x 2 cells side by side, their common side doubled.
inline Mesh<double> seamed_sheet() {
  const std::vector<Mesh<double>> halves{
      grid<double>(1, 2, 1, 2),
      placed<double>(grid<double>(1, 2, 1, 2), Eigen::Matrix3d::Identity(), Vec3<double>(1, 0, 0))};
  return joined<double>(halves);
}

}  // namespace gelight::test
