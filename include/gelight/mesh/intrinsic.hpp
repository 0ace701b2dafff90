#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// A triangulation that knows its edges' lengths but no positions. Half-edges are numbered as in
/// Surface; two vertices may share more than one edge.
template <std::floating_point Real>
struct IntrinsicTriangulation {
  Index vertex_count = 0;        ///< of the surface, whether or not they are in a face
  detail::Array<Index> origins;  ///< of each half-edge: the vertex it starts from
  detail::Array<Index> twins;    ///< of each half-edge: the one across, -1 where there is no flip
  detail::Array<Real> lengths;   ///< of each half-edge

  /// Three half-edges are a face.
  [[nodiscard]] Index face_count() const { return static_cast<Index>(origins.size() / 3); }
};

/// A face laid out in the plane: its first vertex at (0, 0), its second at (x1, 0), its third at
/// (x2, y2), y2 > 0.
struct PlanarFace {
  double x1 = 0;  ///< of the second vertex
  double x2 = 0;  ///< of the third vertex
  double y2 = 0;  ///< of the third vertex
};

namespace detail {

/// Mean length of a surface's edges, each counted once.
template <std::floating_point Real>
Real mean_edge_length(const Surface<Real>& surface) {
  Real sum = 0;
  Index count = 0;
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    if (surface.twin(h) > h) continue;  // another half-edge of the edge is its last
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
/// Throws InvalidInput for a unit that is not positive or not finite.
template <std::floating_point Real>
[[nodiscard]] IntrinsicTriangulation<Real> intrinsic_triangulation(const Surface<Real>& surface,
                                                                   double unit = 1) {
  detail::require(unit > 0 && std::isfinite(unit), "the unit of lengths is ", unit,
                  ", not a positive number");
  IntrinsicTriangulation<Real> result;
  result.vertex_count = surface.vertex_count();
  result.origins.resize_for_writes(static_cast<std::size_t>(surface.halfedge_count()));
  result.twins.resize_for_writes(result.origins.size());
  result.lengths.resize_for_writes(result.origins.size());
  for (Index h = 0; h < surface.halfedge_count(); h += 3) {
    const auto in_units = [&](Index g) { return static_cast<double>(surface.length(g)) / unit; };
    const auto lengths = detail::mollified({in_units(h), in_units(h + 1), in_units(h + 2)}, 1);
    for (Index k = 0; k < 3; ++k) {
      const Index twin = surface.twin(h + k);
      const bool is_inner = twin != h + k && surface.is_manifold(h + k) &&
                            surface.origin(twin) != surface.origin(h + k);
      result.origins[h + k] = surface.origin(h + k);
      result.twins[h + k] = is_inner ? twin : -1;
      result.lengths[h + k] = lengths[static_cast<std::size_t>(k)];
    }
  }
  return result;
}

/// Each face laid out in the plane.
template <std::floating_point Real>
[[nodiscard]] detail::Array<PlanarFace> planar_faces(const IntrinsicTriangulation<Real>& mesh) {
  detail::Array<PlanarFace> faces;
  faces.resize_for_writes(static_cast<std::size_t>(mesh.face_count()));
  for (Index f = 0; f < mesh.face_count(); ++f) {
    const Real* l = mesh.lengths.data() + 3 * std::ptrdiff_t{f};
    faces[f] = detail::laid_out(
        {static_cast<double>(l[0]), static_cast<double>(l[1]), static_cast<double>(l[2])});
  }
  return faces;
}

namespace detail {

/// Lengthens all edges alike until in every face two outrun the third by a share of the mean edge
/// length (Sharp and Crane 2020): faces that share an edge go on agreeing about it. Where no edge
/// has a length, all get 1.
template <std::floating_point Real>
void mollify_together(IntrinsicTriangulation<Real>& mesh) {
  constexpr double share = 1e-5;
  Real sum = 0;
  for (const Real length : mesh.lengths) sum += length;
  const Real least = share * sum / static_cast<Real>(mesh.lengths.size());
  Real missing = 0;
  for (Index f = 0; f < mesh.face_count(); ++f) {
    const Real* l = mesh.lengths.data() + 3 * std::ptrdiff_t{f};
    const Real slack = l[0] + l[1] + l[2] - 2 * std::max({l[0], l[1], l[2]});
    missing = std::max(missing, least - slack);
  }
  if (!(sum > 0)) missing = 1;
  for (Real& length : mesh.lengths) length += missing;
}

/// The length that half-edge h's edge has once it joins the vertices across it; negative unless
/// the edge is to be flipped: the angles opposite sum to more than pi.
template <std::floating_point Real>
inline Real flipped_length(const IntrinsicTriangulation<Real>& mesh, Index h) {
  const auto next = [](Index g) { return g % 3 == 2 ? g - 2 : g + 1; };
  const auto face_from = [&](Index g) {
    const auto length = [&](Index k) { return static_cast<double>(mesh.lengths[k]); };
    return laid_out({length(g), length(next(g)), length(next(next(g)))});
  };
  const PlanarFace left = face_from(h), right = face_from(mesh.twins[h]);
  if (!(left.y2 > 0 && right.y2 > 0)) return -1;
  // Cotangents of the angles at the two vertices across; round-off does not make an edge flip.
  const auto cotangent = [](const PlanarFace& f) {
    return (f.y2 - f.x2 * (f.x1 - f.x2) / f.y2) / f.x1;
  };
  const Real a = cotangent(left), b = cotangent(right);
  constexpr double tolerance = 1e-10;
  if (!(a + b < -tolerance * (1 + std::abs(a) + std::abs(b)))) return -1;
  const Real along = left.x2 - (right.x1 - right.x2);
  return std::hypot(along, left.y2 + right.y2);
}

template <std::floating_point Real>
inline void flip(IntrinsicTriangulation<Real>& mesh, Index h, Real length) {
  const auto next = [](Index g) { return g % 3 == 2 ? g - 2 : g + 1; };
  const Index t = mesh.twins[h];
  const Index left = h - h % 3, right = t - t % 3;
  // The four sides in the order in which the new faces take them up.
  const std::array<Index, 4> from{next(next(h)), next(t), next(next(t)), next(h)};
  const std::array<Index, 4> to{left + 1, left + 2, right + 1, right + 2};
  std::array<Index, 4> origins, twins;
  std::array<Real, 4> lengths;
  for (std::size_t k = 0; k < 4; ++k) {
    origins[k] = mesh.origins[from[k]];
    lengths[k] = mesh.lengths[from[k]];
    const auto side = std::find(from.begin(), from.end(), mesh.twins[from[k]]);
    twins[k] = side == from.end() ? mesh.twins[from[k]]
                                  : to[static_cast<std::size_t>(side - from.begin())];
  }
  for (std::size_t k = 0; k < 4; ++k) {
    mesh.origins[to[k]] = origins[k];
    mesh.lengths[to[k]] = lengths[k];
    mesh.twins[to[k]] = twins[k];
    if (twins[k] >= 0) mesh.twins[twins[k]] = to[k];
  }
  mesh.origins[left] = origins[2];
  mesh.origins[right] = origins[0];
  mesh.twins[left] = right;
  mesh.twins[right] = left;
  mesh.lengths[left] = mesh.lengths[right] = length;
}

/// A surface's own triangulation with lengths in units of `unit`; where some face has (almost) no
/// area, all edges are longer by the same small amount.
template <std::floating_point Real>
[[nodiscard]] IntrinsicTriangulation<Real> mollified_triangulation(const Surface<Real>& surface,
                                                                   double unit) {
  auto mesh = intrinsic_triangulation(surface, unit);
  for (Index h = 0; h < surface.halfedge_count(); ++h) mesh.lengths[h] = surface.length(h) / unit;
  mollify_together(mesh);
  return mesh;
}

/// Calls `flip_edge(h, new length)`, which is to flip that edge, until the angles opposite each
/// edge sum to at most pi, at most 1000 times for each. The hook hears of the edges not looked at
/// yet: those that flips have brought back are not foreseen.
template <std::floating_point Real>
void flip_to_delaunay(IntrinsicTriangulation<Real>& mesh, auto&& flip_edge,
                      const CancelHook& cancelled = {}) {
  constexpr std::ptrdiff_t flip_limit = 1000, edges_between = 1 << 14;
  Array<Index> pending;
  for (Index h = 0; h < static_cast<Index>(mesh.twins.size()); ++h) {
    if (h < mesh.twins[h]) pending.push_back(h);
  }
  auto flips_left = flip_limit * static_cast<std::ptrdiff_t>(pending.size());
  const std::size_t all = pending.size();
  std::size_t least = all;
  for (std::ptrdiff_t seen = 0; !pending.empty() && flips_left > 0; ++seen) {
    least = std::min(least, pending.size());
    if (seen % edges_between == 0) {
      cancelled.check(1 - static_cast<double>(least) / static_cast<double>(all),
                      "flipping edges to Delaunay");
    }
    const Index h = pending.back();
    pending.pop_back();
    if (mesh.twins[h] < 0 || mesh.twins[h] / 3 == h / 3) continue;
    const Real length = flipped_length(mesh, h);
    if (length < 0) continue;
    const Index left = h - h % 3, right = mesh.twins[h] - mesh.twins[h] % 3;
    flip_edge(h, length);
    --flips_left;
    for (const Index side : {left + 1, left + 2, right + 1, right + 2}) pending.push_back(side);
  }
}

}  // namespace detail

/// Flips edges, on lengths alone, until the angles opposite each sum to at most pi: the intrinsic
/// Delaunay triangulation of the same surface (Sharp and Crane 2020, doi:10.1111/cgf.14069).
///
/// Where some face has (almost) no area, all edges are first lengthened by the same small amount.
/// Edges of one face, or of more than two, or of two faces oriented against each other stay. Ends
/// after at most 1000 flips for each edge, sooner on any mesh met so far. Asks the hook meanwhile.
/// Throws InvalidInput for a unit that is not positive or not finite.
template <std::floating_point Real>
[[nodiscard]] IntrinsicTriangulation<Real> intrinsic_delaunay(const Surface<Real>& surface,
                                                              double unit = 1,
                                                              const CancelHook& cancelled = {}) {
  auto mesh = detail::mollified_triangulation(surface, unit);
  detail::flip_to_delaunay(
      mesh, [&](Index h, Real length) { detail::flip(mesh, h, length); }, cancelled);
  return mesh;
}

}  // namespace gelight
