#pragma once

#include <cmath>
#include <concepts>
#include <type_traits>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {
template <std::floating_point T>
auto traced_on(const Surface<T>& surface, const SurfacePoint<T>& point, const Vec3<T>& direction,
               T length, const CancelHook& cancelled) -> Path<T>;
}  // namespace detail

/// The straightest geodesic from a point in a direction for a length: straight in every face and
/// over every edge, with equal angles on both sides at a vertex. The exponential map.
///
/// The direction is a vector in space of any length. In a face its part in the plane counts. At an
/// edge and at a vertex one that lies in the plane of a face there, and points into it, leaves
/// there (as `ExactField::departure` tells); any other is one of the tangent plane: on an edge that
/// which halves the angle of the two faces, at a vertex that of TangentFrames, whose angles sum to
/// 2 pi. So it undoes ExactLogMap.
///
/// It ends before its length at a border, at an edge of three faces or more, and round a needle's
/// tip where it comes no farther. At a vertex of a border it goes on where one side leaves half a
/// turn: along a straight border, past a re-entrant corner. It stays in the fan by which it reaches
/// a vertex; faces oriented against each other are of two fans there. Edges of no length are
/// points: what meets around both ends is met as at one vertex, and the path has both.
///
/// Returns the point, each point where the path crosses an edge or meets a vertex, and its end.
/// Throws InvalidInput for a point that is not of the surface, a direction that is zero, not finite
/// or at a right angle to the surface, one in the plane of no face where there is no tangent plane,
/// which is at an edge of three faces, a vertex of several fans and where normals cancel, a point
/// in a face of no area but for rounding, a length that is negative or not finite; Cancelled where
/// the hook says so. Constant time for each face crossed.
///
/// K. Polthier, M. Schmies, "Straightest geodesics on polyhedral surfaces", 1998,
/// doi:10.1007/978-3-662-03567-2_11.
///@{
template <TriangleMesh M>
[[nodiscard]] Path<MeshScalar<M>> trace_geodesic(const M& mesh,
                                                 const SurfacePoint<MeshScalar<M>>& point,
                                                 const Vec3<MeshScalar<M>>& direction,
                                                 MeshScalar<M> length,
                                                 const CancelHook& cancelled = {}) {
  return detail::traced_on(Surface<MeshScalar<M>>(mesh), point, direction, length, cancelled);
}
/// From a point in another precision: of a float mesh on its solver's surface, which is of doubles.
/// A length beyond the numbers of the mesh is refused, too.
template <TriangleMesh M, std::floating_point T>
requires(!std::same_as<T, MeshScalar<M>>)
    [[nodiscard]] Path<T> trace_geodesic(const M& mesh, const SurfacePoint<T>& point,
                                         const std::type_identity_t<Vec3<T>>& direction,
                                         std::type_identity_t<T> length,
                                         const CancelHook& cancelled = {}) {
  using Real = MeshScalar<M>;
  const auto shorter = static_cast<Real>(length);
  detail::require(std::isfinite(shorter) == std::isfinite(length), "the length ", length,
                  " is beyond the numbers of the mesh");
  // Of any length: the mesh's type may hold no such number.
  const Vec3<T> way = detail::is_finite(direction) ? detail::scaled(direction).first : direction;
  const Path<Real> path = trace_geodesic(mesh, detail::point_of(Surface<Real>(mesh), point),
                                         cast<Real>(way), shorter, cancelled);
  Path<T> out;
  for (const SurfacePoint<Real>& p : path) out.push_back(p.template cast<T>());
  return out;
}
///@}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/trace/body.hpp"
#endif
