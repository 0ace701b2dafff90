#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <span>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/detail/plane_cut.hpp"
#include "gelight/light/detail/plane_sides.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// Light that stays in a plane: the surface is cut by the plane through the LED, the point and the
/// normal at the LED, and the light arrives along the shorter arc of the cut (Gomes, Paoletti, Luo,
/// "Simulation of Curved GelSight Sensors for Sim2Real Learning").
///
/// Zero where the point lies above the LED along the normal, or both arcs end at a border. Throws
/// InvalidInput for a point that is not of the surface and a normal that is zero or not finite.
/// Cost: some 4 sqrt(faces) cuts, each O(faces that it crosses), to know for whole faces which arc
/// is the shorter; O(1) a point inside those, one more cut for a point elsewhere.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        const Vec3<T>& normal,
                                        std::span<const SurfacePoint<T>> points) {
  detail::require(normal.allFinite() && !normal.isZero(0), "the normal at the LED is (", normal[0],
                  ", ", normal[1], ", ", normal[2], ")");
  detail::PlaneCut<T> cut(surface, led, normal);
  const detail::PlaneSides<T> sides(surface, cut);
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) {
    const Vec3<T> place = cut.local(surface.position(point));
    const bool inside = point.kind == SurfacePoint<T>::Kind::face &&
                        *std::min_element(point.weights.begin(), point.weights.end()) > 0;
    using Side = typename detail::PlaneSides<T>::Side;
    const Side side = inside ? sides.side(point.element[0]) : Side::mixed;
    if (side == Side::along || side == Side::against) {
      field.push_back(cut.in_space(sides.direction(point.element[0], place)));
      continue;
    }
    const auto& arrivals = cut.arrive(point, place);
    field.push_back(arrivals.empty() ? Vec3<T>(Vec3<T>::Zero())
                                     : cut.in_space(arrivals[0].direction));
  }
  return field;
}

/// The same with the mean normal of the LED's faces, by area.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        std::span<const SurfacePoint<T>> points) {
  surface.require_point(led);
  Vec3<T> normal = Vec3<T>::Zero();
  for (const Index f : detail::faces_at(surface, led)) normal += detail::face_normal(surface, f);
  return plane_field(surface, led, normal, points);
}

}  // namespace gelight
