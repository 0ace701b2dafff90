#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <memory>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

// The operators of linear finite elements on a triangulation, in the plane of each face.

namespace gelight {

/// Half the cotangents of the angles opposite a face's three edges: its share of the edges'
/// weights.
[[nodiscard]] inline std::array<double, 3> half_cotangents(const PlanarFace& face) {
  const auto& [x1, x2, y2] = face;
  const double scale = 1 / (2 * x1 * y2);
  return {scale * (y2 * y2 - x2 * (x1 - x2)), scale * x1 * x2, scale * x1 * (x1 - x2)};
}

namespace detail {

/// The two matrices below, of faces that are laid out already.
///@{
template <std::floating_point Real>
[[nodiscard]] SymmetricMatrix<Real> cotan_laplacian(
    const Array<PlanarFace>& faces, const Array<Index>& origins,
    const std::shared_ptr<const SymmetricPattern<Real>>& pattern) {
  SymmetricMatrix<Real> matrix{pattern, {}};
  auto& values = matrix.values;
  values.assign(static_cast<std::size_t>(pattern->entry_count()), 0);
  for (Index f = 0; f < static_cast<Index>(faces.size()); ++f) {
    const auto weights = half_cotangents(faces[f]);
    for (Index k = 0; k < 3; ++k) {
      const Real weight = weights[static_cast<std::size_t>(k)];
      const Index from = origins[3 * f + k], to = origins[3 * f + (k + 1) % 3];
      if (from == to) continue;  // a loop carries no difference
      values[pattern->entry(3 * f + k)] -= weight;
      values[pattern->diagonal(from)] += weight;
      values[pattern->diagonal(to)] += weight;
    }
  }
  return matrix;
}
template <std::floating_point Real>
[[nodiscard]] Array<Real> vertex_areas(const Array<PlanarFace>& faces, const Array<Index>& origins,
                                       Index vertex_count) {
  Array<Real> areas(static_cast<std::size_t>(vertex_count), 0);
  for (Index f = 0; f < static_cast<Index>(faces.size()); ++f) {
    for (Index k = 0; k < 3; ++k) areas[origins[3 * f + k]] += faces[f].x1 * faces[f].y2 / 6;
  }
  return areas;
}
///@}

}  // namespace detail

/// The cotan Laplacian, positive semidefinite: (L u)(i) = sum over edges ij of
/// (cot a + cot b)/2 (u(i) - u(j)). Any number of faces may share an edge.
template <std::floating_point Real>
[[nodiscard]] SymmetricMatrix<Real> cotan_laplacian(
    const IntrinsicTriangulation<Real>& mesh,
    const std::shared_ptr<const SymmetricPattern<double>>& pattern) {
  return detail::cotan_laplacian<Real>(planar_faces(mesh), mesh.origins, pattern);
}

/// A third of the area of each vertex's faces: the lumped mass matrix's diagonal.
template <std::floating_point Real>
[[nodiscard]] detail::Array<Real> vertex_areas(const IntrinsicTriangulation<Real>& mesh) {
  return detail::vertex_areas<Real>(planar_faces(mesh), mesh.origins, mesh.vertex_count);
}

/// Twice the face's area times the gradient of the linear function with these values at its
/// vertices, in the face's plane.
template <std::floating_point Real = double>
[[nodiscard]] inline Vec2<Real> scaled_gradient(const PlanarFace& face,
                                                const std::array<Real, 3>& u) {
  const Real du1 = u[1] - u[0], du2 = u[2] - u[0];
  return {face.y2 * du1, face.x1 * du2 - face.x2 * du1};
}

/// The face's share of the integrated divergence at its three vertices: the integral of the
/// hat functions' gradients times a field constant on the face.
template <std::floating_point Real>
[[nodiscard]] inline std::array<Real, 3> integrated_divergence(const PlanarFace& face,
                                                               const Vec2<Real>& field) {
  const Real at1 = (face.y2 * field[0] - face.x2 * field[1]) / 2;
  const Real at2 = face.x1 * field[1] / 2;
  return {-at1 - at2, at1, at2};
}

/// For each vertex the smallest vertex that faces join it to: one number per connected part.
template <std::floating_point Real>
[[nodiscard]] detail::Array<Index> component_of_vertices(const IntrinsicTriangulation<Real>& mesh) {
  return detail::component_of_vertices(mesh.vertex_count, mesh.origins);
}

}  // namespace gelight
