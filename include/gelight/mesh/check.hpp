#pragma once

#include <concepts>
#include <iosfwd>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/repair/copied.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// How many there are of something, and the first of them in ascending order.
struct Finding {
  Index count = 0;             ///< how many
  std::vector<Index> first{};  ///< as many as CheckOptions list
};

struct CheckOptions {
  /// How many indices a Finding names at most.
  Index listed = 8;
  /// A face counts as degenerate if its height is at most this share of its longest edge.
  double flat = 1e-12;
};

/// What is unusual about a mesh. Made by `check`.
struct MeshReport {
  Index vertices = 0;  ///< how many the mesh has
  Index faces = 0;     ///< how many the mesh has

  // Refused by Surface, and so by every solver.
  Finding not_finite;         ///< vertices with a coordinate that is not finite
  Finding too_far;            ///< vertices with a coordinate beyond 1e75
  bool is_too_small = false;  ///< whether no edge is as long as 1e-75, though some have length
  Finding out_of_range;       ///< faces with an index that is no vertex
  Finding repeated_vertices;  ///< faces with a vertex twice
  Finding repeated_faces;     ///< faces with the three vertices of an earlier one
  Finding too_long;           ///< faces with an edge longer than the coordinates' type holds

  // Refused where vectors are carried, by name; distances take them.
  Finding nonmanifold_edges;  ///< first vertices of edges with more than two faces
  Finding misoriented_edges;  ///< first vertices of edges whose two faces are oriented against each
                              ///< other

  // Taken by every solver, but perhaps not what was meant.
  Finding degenerate_faces;      ///< faces of (almost) no area, also with edges of no length
  Finding zero_edges;            ///< first vertices of edges of no length
  Finding duplicate_vertices;    ///< vertices at the position of an earlier one: a seam, uncrossed
  Finding unused_vertices;       ///< vertices in no face: infinitely far
  Finding nonmanifold_vertices;  ///< vertices whose faces form more than one fan
  Finding border_edges;          ///< first vertices of edges with one face
  Index components = 0;          ///< parts with no path between them, unused vertices not counted

  /// Whether a Surface, and so every distance solver, can be made of it.
  [[nodiscard]] bool is_accepted() const {
    return vertices > 0 && faces > 0 && not_finite.count == 0 && too_far.count == 0 &&
           !is_too_small && out_of_range.count == 0 && repeated_vertices.count == 0 &&
           repeated_faces.count == 0 && too_long.count == 0;
  }
  /// Whether VectorHeatSolver takes it too.
  [[nodiscard]] bool is_oriented() const {
    return is_accepted() && nonmanifold_edges.count == 0 && misoriented_edges.count == 0;
  }
};

namespace detail {
template <std::floating_point T>
auto checked_mesh(const Mesh<T>& mesh, const CheckOptions& options, const CancelHook& cancelled)
    -> MeshReport;
}  // namespace detail

/// Tells everything about a mesh that a solver refuses or that may not be what was meant, in one
/// pass, with counts and the first indices; changes nothing and takes any mesh.
///
/// Faces that Surface refuses are left out of what concerns edges, fans and components. The hook is
/// asked between the steps. Throws InvalidInput for options that are negative or not finite. Cost:
/// O(vertices + faces log faces).
template <TriangleMesh M>
[[nodiscard]] MeshReport check(const M& mesh, const CheckOptions& options = {},
                               const CancelHook& cancelled = {}) {
  return detail::checked_mesh(detail::copied(mesh), options, cancelled);
}

/// One line for each finding, such as "2 faces with a vertex twice: 4, 9 (refused)".
GELIGHT_INLINE std::ostream& operator<<(std::ostream& out, const MeshReport& report);

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/mesh/check/body.hpp"
#endif
