#pragma once

#include <concepts>
#include <initializer_list>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// A flat sheet over [0, width] x [0, height], with columns x rows cells of two triangles.
/// Throws InvalidInput for no cells, more vertices than can be counted, or a size that is not
/// positive and finite.
template <std::floating_point T>
[[nodiscard]] Mesh<T> grid(Index columns, Index rows, T width = 1, T height = 1);

/// A sphere about the origin: an icosahedron whose faces are split into four `level` times, which
/// makes 10 4^level + 2 vertices. Throws InvalidInput for a level outside 0 to 12 or a radius that
/// is not positive and finite.
template <std::floating_point T>
[[nodiscard]] Mesh<T> icosphere(int level, T radius = 1);
/// Not with the radius first: it would be taken for a level.
template <std::floating_point T>
Mesh<T> icosphere(std::floating_point auto level, T radius = 1) = delete;

/// An axis-aligned box about the origin, of 8 vertices and 12 faces, with these edge lengths.
/// Throws InvalidInput for one that is not positive and finite.
template <std::floating_point T>
[[nodiscard]] Mesh<T> box(T x, T y, T z);

/// A point of the outline that `revolve` turns about the z axis: distance from the axis, height.
template <std::floating_point T>
struct ProfilePoint {
  T radius = 0;  ///< distance from the axis
  T z = 0;       ///< height
};

/// The surface that an outline sweeps when it turns about the z axis, with triangles as equilateral
/// as its points allow: each point becomes a ring of vertices about `edge_length` apart, or a
/// single vertex on the axis. An outline that runs upwards on the outside has its normals outwards.
///
/// Throws InvalidInput for fewer than two points, a negative radius, a number that is not finite,
/// two neighbours on the axis, or an edge length that is not positive or makes more vertices than
/// can be counted. Cost is linear in the vertices made.
template <std::floating_point T>
[[nodiscard]] Mesh<T> revolve(std::span<const ProfilePoint<T>> profile, T edge_length);

/// The membrane of a fingertip sensor: an open cylinder about the z axis from z = 0, closed by a
/// hemisphere whose tip is at z = length. The defaults are the GelTip's (Gomes, Paoletti, Luo), in
/// metres. Throws InvalidInput unless 0 < edge_length <= radius <= length < infinity, for a radius
/// so large that a quarter of a circle is not finite, and where that makes more vertices than can
/// be counted.
template <std::floating_point T>
[[nodiscard]] Mesh<T> membrane(T radius = T(0.01146), T length = T(0.0455),
                               T edge_length = T(0.001));

/// A ring about the z axis. Throws InvalidInput unless 0 < minor_radius < major_radius and their
/// sum is finite, and for fewer than 3 vertices in a direction or more in all than can be counted.
template <std::floating_point T>
[[nodiscard]] Mesh<T> torus(T major_radius, T minor_radius, Index around, Index across);

/// A copy of a mesh turned by a rotation, then moved. Throws InvalidInput for a number of these
/// that is not finite.
template <std::floating_point T>
[[nodiscard]] Mesh<T> placed(Mesh<T> mesh,
                             const std::type_identity_t<Eigen::Matrix<T, 3, 3>>& rotation,
                             const std::type_identity_t<Vec3<T>>& translation);

/// Several meshes as one, in the order given, sharing nothing. Throws InvalidInput for a face with
/// an index out of range, which would be a vertex of another part, and for more vertices than can
/// be counted.
///@{
template <std::floating_point T>
[[nodiscard]] Mesh<T> joined(std::span<const Mesh<T>> parts);
template <std::floating_point T>
[[nodiscard]] Mesh<T> joined(const std::vector<Mesh<T>>& parts) {
  return joined(std::span<const Mesh<T>>(parts.data(), parts.size()));
}
template <std::floating_point T>
[[nodiscard]] Mesh<T> joined(std::initializer_list<Mesh<T>> parts) {
  return joined(std::span<const Mesh<T>>(parts.begin(), parts.size()));
}
///@}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/mesh/shapes/body.hpp"
#endif
