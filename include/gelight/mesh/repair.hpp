#pragma once

#include <concepts>
#include <optional>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/repair/copied.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// What `repair` does; by default nothing.
struct RepairOptions {
  /// Drops faces that Surface refuses: with an index out of range, a vertex that is not finite, too
  /// far out or twice, an edge longer than the coordinates' type holds, or the three vertices of an
  /// earlier face.
  bool drop_unusable_faces = false;
  /// Where given, each vertex at most this far from an earlier one becomes that one, in the unit of
  /// the positions (0: only vertices at the same place). Faces that collapse or become equal by
  /// this are dropped.
  std::optional<double> weld_distance{};
  /// Drops faces whose height is at most `flat` times their longest edge. The area stays, but where
  /// such a face was all that joined two others, they part.
  bool drop_degenerate_faces = false;
  double flat = 1e-12;  ///< see drop_degenerate_faces
  /// Turns faces so that those that meet in an edge of two faces agree with the first of their part
  /// wherever the surface has an orientation.
  bool orient = false;
  /// Gives each fan of a vertex its own copy, so that paths no longer pass through the vertex.
  /// Copies are numbered behind all vertices, with order_in_space beside the vertex they are of.
  /// Edges of more than two faces part too, unless their faces join again around both ends.
  bool split_vertices = false;
  /// Drops vertices in no face, also those that are not finite.
  bool drop_unused_vertices = false;
  /// Numbers vertices and faces along a curve that fills space, so that what lies side by side does
  /// so in memory, too: solvers take less time on large meshes that came in no such order.
  bool order_in_space = false;
};

/// A repaired mesh, and what was done to it.
template <std::floating_point T>
struct Repaired {
  Mesh<T> mesh;                    ///< as repaired
  Index welded_vertices = 0;       ///< vertices that became an earlier one
  Index dropped_faces = 0;         ///< unusable, equal, collapsed or degenerate
  Index turned_faces = 0;          ///< to agree with their neighbours
  Index added_vertices = 0;        ///< copies made by splitting
  Index dropped_vertices = 0;      ///< in no face
  std::vector<Index> vertex_of{};  ///< of each vertex of `mesh`: which it was
  std::vector<Index> face_of{};    ///< of each face of `mesh`: which it was
};

namespace detail {
template <std::floating_point T>
auto repaired(Mesh<T> mesh, const RepairOptions& options, const CancelHook& cancelled)
    -> Repaired<T>;
}  // namespace detail

/// Copies a mesh and mends what the options name, in the order in which they stand there, but that
/// vertices of a welded mesh are split last; tells what it did. The mesh itself stays as it is, and
/// nothing is mended that was not asked for. The hook is asked between the steps.
///
/// Repaired again with the same options the result stays as it is, to the last bit. Of a welded one
/// that takes both drop_unusable_faces and drop_unused_vertices: with split_vertices, since copies
/// are welded and made anew; at a weld distance above 0 with order_in_space or
/// drop_unused_vertices, since a vertex that was welded, which unusable faces keep, may come to
/// stand first.
///
/// Throws InvalidInput for a weld distance or a flatness that is negative or not finite. Cost:
/// O(vertices + faces log faces); to order in space, O(vertices log vertices) too.
template <TriangleMesh M>
[[nodiscard]] Repaired<MeshScalar<M>> repair(const M& mesh, const RepairOptions& options,
                                             const CancelHook& cancelled = {}) {
  return detail::repaired(detail::copied(mesh), options, cancelled);
}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/mesh/repair/body.hpp"
#endif
