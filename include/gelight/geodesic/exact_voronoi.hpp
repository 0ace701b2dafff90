#pragma once

#include <array>
#include <concepts>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"

namespace gelight {

/// A line between the cells of two sources: its points are as far from the one as from the other.
template <std::floating_point T>
struct VoronoiEdge {
  /// The sources' numbers in the solve, the lesser first; that one's cell lies to the left, as seen
  /// from the side from which the faces' vertices are counter-clockwise.
  std::array<Index, 2> sources{-1, -1};
  Path<T> points;          ///< On it; of a closed one the first is the last.
  bool is_closed = false;  ///< Whether it is a ring, which ends nowhere.
};

/// How `exact_voronoi_edges` draws its lines.
template <std::floating_point T>
struct VoronoiEdgeOptions {
  /// How far the straight pieces between points may leave the line, about, as a share of the
  /// longest side of their face.
  T deviation = T(1e-3);
  /// Asked now and then; when it answers true, Cancelled is thrown.
  CancelHook cancelled{};
};

/// The lines between the cells of an exact field's sources, inside of faces: true branches of
/// hyperbolas, straight where sources start alike, as polylines whose points lie on them to
/// rounding of the distances. Cells are bounded by them and by the mesh's border.
///
/// A line ends at a border, where three cells meet, where orientation changes, at an edge of three
/// faces or more, and at faces without area. Lines that close inside of one face are found too.
/// What is missed: lines shorter than 1e-11 of the mesh's size; cells that are nearer by less than
/// 1e-12 of it; and where more than a line is as near to two sources, as behind a saddle that both
/// reach at once, one of them has it all and what bounds it there.
///
/// Throws InvalidInput for a field that has not kept all windows (ExactOptions::keep_windows), one
/// of segments, one that was solved up to a greatest distance or for targets, and a deviation that
/// is not positive; Cancelled where the hook says so. Linear in the windows of faces that one cell
/// holds; in each of the others all pairs of windows are looked at.
///
/// Y.-J. Liu, Z.-Q. Chen, K. Tang, "Construction of iso-contours, bisectors, and Voronoi diagrams
/// on triangulated surfaces", 2011, doi:10.1109/TPAMI.2010.221.
template <std::floating_point T>
[[nodiscard]] std::vector<VoronoiEdge<T>> exact_voronoi_edges(
    const ExactField<T>& field, const VoronoiEdgeOptions<T>& options = {});

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/exact_voronoi/body.hpp"
#endif
