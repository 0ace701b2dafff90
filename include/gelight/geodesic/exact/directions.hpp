#pragma once

#include <cmath>
#include <concepts>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

// Directions and lengths in space on a surface's faces.

namespace gelight::detail {

/// Straight distance through space between two points.
template <std::floating_point T>
[[nodiscard]] T straight(const Surface<T>& surface, const SurfacePoint<T>& a,
                         const SurfacePoint<T>& b) {
  return stable_norm(surface.difference(a, b));
}

/// The unit vector from one point to another; zero where they are at one place.
template <std::floating_point T>
[[nodiscard]] Vec3<T> unit_way(const Surface<T>& surface, const SurfacePoint<T>& from,
                               const SurfacePoint<T>& to) {
  return stable_unit(surface.difference(from, to));
}

/// The unit vector in space from one point to another of half-edge h's frame in its face; zero
/// where h has no length and so no frame.
template <std::floating_point T>
[[nodiscard]] Vec3<T> unit_way(const Surface<T>& surface, const PlanarFaces<T>& faces, Index h,
                               const Vec2<T>& from, const Vec2<T>& to) {
  using namespace arithmetic;
  if (!(surface.length(h) > 0)) return Vec3<T>(0, 0, 0);
  // As so many times the sides from h's origin. A face without area has its apex on h.
  const Vec2<T>& apex = faces.apex(h);
  const T to_apex = apex.y() > 0 ? (to.y() - from.y()) / apex.y() : 0;
  const T to_tip = (to.x() - from.x() - to_apex * apex.x()) / surface.length(h);
  const Vec3<T>& o = surface.position(surface.origin(h));
  return stable_unit(to_tip * (surface.position(surface.tip(h)) - o) +
                     to_apex * (surface.position(surface.apex(h)) - o));
}

/// The angle from half-edge h to a direction, towards the inside of its face, in radians.
template <std::floating_point T>
[[nodiscard]] T angle_from(const Surface<T>& surface, Index h, const Vec3<T>& direction) {
  const Vec3<T>& o = surface.position(surface.origin(h));
  const Vec3<T> x = surface.position(surface.tip(h)) - o;
  const Vec3<T> up = cross<T>(cross<T>(x, surface.position(surface.apex(h)) - o), x);
  return std::atan2(dot(direction, stable_unit(up)), dot(direction, stable_unit(x)));
}

}  // namespace gelight::detail
