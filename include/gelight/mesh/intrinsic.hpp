#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// A triangulation that knows its edges' lengths but no positions. Half-edges are numbered as in
/// Surface; two vertices may share more than one edge.
struct IntrinsicTriangulation {
  Index vertex_count = 0;
  detail::Array<Index> origins;   // of each half-edge: the vertex it starts from
  detail::Array<double> lengths;  // of each half-edge

  [[nodiscard]] Index face_count() const { return static_cast<Index>(origins.size() / 3); }
};

/// A face laid out in the plane: its first vertex at (0, 0), its second at (x1, 0), its third at
/// (x2, y2), y2 > 0.
struct PlanarFace {
  double x1 = 0, x2 = 0, y2 = 0;
};

namespace detail {

/// Mean length of a surface's edges, each counted once.
inline double mean_edge_length(const Surface<double>& surface) {
  double sum = 0;
  Index count = 0;
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    bool is_first = true;
    for (Index t = surface.twin(h); t != h; t = surface.twin(t)) is_first = is_first && h < t;
    if (!is_first) continue;
    sum += surface.length(h);
    ++count;
  }
  return sum / count;
}

/// By how much, in shares of its longest edge, two edges of a face must outrun the third. Faces
/// thinner than that (height below about 1e-4 of the base for a cap) have all edges lengthened.
inline constexpr double least_slack = 1e-8;

/// Edge lengths of a triangle whose area is not zero: the given ones, each a little longer where
/// they do not make one (Sharp and Crane 2020, doi:10.1111/cgf.14069, for each face alone, so that
/// sound faces keep their lengths). A face that is a point gets edges of `unit`.
inline std::array<double, 3> mollified(std::array<double, 3> l, double unit) {
  const double longest = std::max({l[0], l[1], l[2]});
  const double slack = l[0] + l[1] + l[2] - 2 * longest;
  const double missing = longest > 0 ? least_slack * longest - slack : unit;
  if (missing > 0) {
    for (double& length : l) length += missing;
  }
  return l;
}

/// The area of a triangle by Kahan's stable form of Heron's formula.
inline double triangle_area(const std::array<double, 3>& l) {
  const double a = std::max({l[0], l[1], l[2]});
  const double c = std::min({l[0], l[1], l[2]});
  const double b = std::max(std::min(l[0], l[1]), std::min(std::max(l[0], l[1]), l[2]));
  return std::sqrt(std::max(0.0, (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)))) /
         4;
}

/// The triangle with edges 0-1, 1-2 and 2-0 of these lengths.
inline PlanarFace laid_out(const std::array<double, 3>& l) {
  return {l[0], (l[0] * l[0] + (l[2] - l[1]) * (l[2] + l[1])) / (2 * l[0]),
          2 * triangle_area(l) / l[0]};
}

}  // namespace detail

/// A surface's own triangulation with lengths in units of `unit`, faces of no area mollified.
[[nodiscard]] inline IntrinsicTriangulation intrinsic_triangulation(const Surface<double>& surface,
                                                                    double unit = 1) {
  IntrinsicTriangulation result;
  result.vertex_count = surface.vertex_count();
  result.origins.resize(static_cast<std::size_t>(surface.halfedge_count()));
  result.lengths.resize(result.origins.size());
  for (Index h = 0; h < surface.halfedge_count(); h += 3) {
    const auto lengths = detail::mollified(
        {surface.length(h) / unit, surface.length(h + 1) / unit, surface.length(h + 2) / unit}, 1);
    for (Index k = 0; k < 3; ++k) {
      result.origins[h + k] = surface.origin(h + k);
      result.lengths[h + k] = lengths[static_cast<std::size_t>(k)];
    }
  }
  return result;
}

/// Each face laid out in the plane.
[[nodiscard]] inline detail::Array<PlanarFace> planar_faces(const IntrinsicTriangulation& mesh) {
  detail::Array<PlanarFace> faces(static_cast<std::size_t>(mesh.face_count()));
  for (Index f = 0; f < mesh.face_count(); ++f) {
    const double* l = mesh.lengths.data() + 3 * std::ptrdiff_t{f};
    faces[f] = detail::laid_out({l[0], l[1], l[2]});
  }
  return faces;
}

}  // namespace gelight
