#pragma once

#include <concepts>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// A line along which values of the vertices, linear between them, are the same.
template <std::floating_point T>
struct Isoline {
  Path<T> points;          ///< On the edges that it crosses; of a closed one the first is the last.
  bool is_closed = false;  ///< Whether it ends where it begins, rather than at a border.
};

/// The lines on which a value of the vertices, linear over each face, equals a level, as polylines
/// with lower values to their left. For distances these are the points at one distance, a curve's
/// offset; with edges of h they are off by about h^2 / (8 distance).
///
/// A line ends at a border, an edge of three faces or more, an edge where orientation changes and
/// where values are infinite. Vertices at the level count as above it. `values` has a value for
/// each vertex. Throws InvalidInput for another number of them, NaN, and a level that is not
/// finite. Linear in the faces.
///@{
template <std::floating_point T>
[[nodiscard]] std::vector<Isoline<T>> isolines(const Surface<T>& surface,
                                               std::type_identity_t<std::span<const T>> values,
                                               std::type_identity_t<T> level);
/// Of a float mesh's values on its solver's surface, which is of doubles.
template <std::same_as<double> T>
[[nodiscard]] std::vector<Isoline<T>> isolines(const Surface<T>& surface,
                                               std::span<const float> values,
                                               std::type_identity_t<T> level) {
  return isolines(surface, std::vector<T>(values.begin(), values.end()), level);
}
///@}

/// The area on which a value of the vertices, linear over each face, is below a level: that which
/// its isolines enclose. Faces with an infinite value are left out. Throws as `isolines` does, and
/// InvalidInput for an area that T cannot hold.
///@{
template <std::floating_point T>
[[nodiscard]] T area_below(const Surface<T>& surface,
                           std::type_identity_t<std::span<const T>> values,
                           std::type_identity_t<T> level);
template <std::same_as<double> T>
[[nodiscard]] T area_below(const Surface<T>& surface, std::span<const float> values,
                           std::type_identity_t<T> level) {
  return area_below(surface, std::vector<T>(values.begin(), values.end()), level);
}
///@}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/isoline/body.hpp"
#endif
