#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/types.hpp"

namespace gelight {

/// A mesh that owns its vertices' positions and its faces' vertices, and nothing else.
template <std::floating_point T>
struct Mesh {
  std::vector<std::array<T, 3>> positions;  ///< of each vertex
  std::vector<std::array<Index, 3>> faces;  ///< the vertices of each face

  /// What makes it a TriangleMesh.
  ///@{
  using Scalar = T;
  [[nodiscard]] std::size_t vertex_count() const { return positions.size(); }
  [[nodiscard]] std::size_t face_count() const { return faces.size(); }
  [[nodiscard]] const std::array<T, 3>& position(Index vertex) const {
    return positions[static_cast<std::size_t>(vertex)];
  }
  [[nodiscard]] const std::array<Index, 3>& face(Index face) const {
    return faces[static_cast<std::size_t>(face)];
  }
  ///@}
};

/// A mesh over the caller's own arrays, which must outlive it. Temporaries live to the end of the
/// expression: `ExactSolver(MeshView<double>(positions(), faces()))` is right, as solvers copy what
/// they need, but a view that is kept as a variable has to be made of what is kept, too; the
/// compiler does not tell.
template <std::floating_point T>
class MeshView {
 public:
  /// Positions of the vertices, and the vertices of each face.
  MeshView(std::span<const std::array<T, 3>> positions, std::span<const std::array<Index, 3>> faces)
      : positions_(positions), faces_(faces) {}
  /// All of a mesh.
  MeshView(const Mesh<T>& mesh) : positions_(mesh.positions), faces_(mesh.faces) {}

  /// What makes it a TriangleMesh.
  ///@{
  using Scalar = T;
  [[nodiscard]] std::size_t vertex_count() const { return positions_.size(); }
  [[nodiscard]] std::size_t face_count() const { return faces_.size(); }
  [[nodiscard]] const std::array<T, 3>& position(Index vertex) const {
    return positions_[static_cast<std::size_t>(vertex)];
  }
  [[nodiscard]] const std::array<Index, 3>& face(Index face) const {
    return faces_[static_cast<std::size_t>(face)];
  }
  ///@}

 private:
  std::span<const std::array<T, 3>> positions_;
  std::span<const std::array<Index, 3>> faces_;
};

}  // namespace gelight
