#pragma once

#include <concepts>
#include <type_traits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"

namespace gelight {

/// A piece of a circle in the plane of one face, counter-clockwise as seen from the side from which
/// the face's vertices are.
template <std::floating_point T>
struct CircularArc {
  Index face = -1;          ///< in which it lies
  Vec3<T> begin{0, 0, 0};   ///< its ends, in space
  Vec3<T> end{0, 0, 0};     ///< its ends, in space
  Vec3<T> centre{0, 0, 0};  ///< of the circle, in the face's plane: the source laid flat into it
  T radius = 0;             ///< of the circle; infinite where the arc is straight, beside a segment
  T angle = 0;              ///< by which it turns about the centre, in radians, at most 2 pi
  T length = 0;             ///< how long it is
};

/// The points at one distance, as arcs that follow one on another.
template <std::floating_point T>
struct ExactIsoline {
  std::vector<CircularArc<T>> arcs;  ///< each begins where the one before ends
  bool is_closed = false;            ///< whether the first begins where the last ends

  /// How long it is.
  [[nodiscard]] T length() const {
    T sum = 0;
    for (const auto& arc : arcs) sum += arc.length;
    return sum;
  }
};

/// The points at one distance of an exact field: true circular arcs, joined. Of a solve from
/// Segments they are the offset of a curve by the distance, and straight beside its pieces.
///
/// Nearer points lie to the left, as seen from the side from which the faces' vertices are counter-
/// clockwise. A line ends at a border, at an edge of three faces or more, where orientation changes
/// and at faces without area. Arcs shorter than 1e-11 of the mesh's size (1e-8 from segments) are
/// left out, and open lines shorter than 1e-8. Throws InvalidInput for a field that has not kept
/// all windows (ExactOptions::keep_windows; a solve from segments always does), a level that is not
/// finite, and one beyond the distance that was solved for; Cancelled where the hook says so.
/// Linear in the windows of faces that the line does not cross, quadratic in those of each that it
/// may.
template <std::floating_point T>
[[nodiscard]] std::vector<ExactIsoline<T>> exact_isolines(const ExactField<T>& field,
                                                          std::type_identity_t<T> level,
                                                          const CancelHook& cancelled = {});

/// The area that is nearer than a level, which its exact isolines enclose; faces without area count
/// as none. Throws as `exact_isolines` does, and InvalidInput for an area that T cannot hold.
template <std::floating_point T>
[[nodiscard]] T area_within(const ExactField<T>& field, std::type_identity_t<T> level,
                            const CancelHook& cancelled = {});

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/exact_isoline/body.hpp"
#endif
