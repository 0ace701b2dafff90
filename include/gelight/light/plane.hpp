#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/plane/plane_cut.hpp"
#include "gelight/light/plane/plane_sides.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// Light that stays in a plane: the surface is cut by the plane through the LED, the point and the
/// normal at the LED, and the light arrives along the shorter arc of the cut (Gomes, Paoletti, Luo
/// 2023, doi:10.15607/RSS.2023.XIX.035).
///
/// Zero where the point lies above the LED along the normal, or both arcs end at a border. Where
/// only the shorter arc does, the light comes by the longer one: with an LED on a border and a
/// normal that leans out of the mesh, at other points of the border the wrong way round. Along a
/// border that lies in the plane, but for rounding, light does come.
///
/// At vertices and edges, and nearer to them than 1e-9 of the height of a face (in float 8e-6),
/// light comes in the direction of the face there that it enters first.
///
/// Throws InvalidInput for a point that is not of the surface and a normal that is zero or not
/// finite. Cost: some 4 sqrt(faces) cuts, each O(faces that it crosses), to know for whole faces
/// which arc is the shorter; O(1) a point inside those, one more cut for a point elsewhere, three
/// where none comes and the border is in the plane.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        const Vec3<T>& normal, PointSpan<T> points,
                                        const CancelHook& cancelled = {}) {
  detail::require(detail::is_finite(normal) && !normal.isZero(0), "the normal at the LED is (",
                  normal[0], ", ", normal[1], ", ", normal[2], ")");
  detail::PlaneCut<T> cut(surface, led, normal);
  const detail::PlaneSides<T> sides(surface, cut, cancelled.part(0, 0.5));
  const CancelHook of_points = cancelled.part(0.5, 1);
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) {
    detail::check_points(of_points, field.size(), points.size(), "the plane field");
    const Vec3<T> place = cut.local(surface.position(point));
    // Inside as `faces_at` has it: so light comes by the same face here as in plane_rays.
    const bool is_inside =
        point.kind == SurfacePoint<T>::Kind::face &&
        *std::min_element(point.weights.begin(), point.weights.end()) > detail::faces_at_snap<T>;
    using Side = typename detail::PlaneSides<T>::Side;
    const Side side = is_inside ? sides.side(point.element[0]) : Side::mixed;
    if (side == Side::along || side == Side::against) {
      field.push_back(cut.in_space(sides.direction(point.element[0], place)));
      continue;
    }
    const auto& arrivals = cut.arrive(point, place);
    field.push_back(arrivals.empty() ? Vec3<T>(0, 0, 0) : cut.in_space(arrivals[0].direction));
  }
  of_points.check(1, "the plane field");
  return field;
}

namespace detail {

/// The mean normal of the faces at a point, by area.
template <std::floating_point T>
[[nodiscard]] Vec3<T> mean_normal(const Surface<T>& surface, const SurfacePoint<T>& point) {
  surface.require_point(point);
  Vec3<T> normal = Vec3<T>(0, 0, 0);
  for (const Index f : faces_at(surface, point)) normal += face_normal(surface, f);
  return normal;
}

}  // namespace detail

/// The same with the mean normal of the LED's faces, by area.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        PointSpan<T> points, const CancelHook& cancelled = {}) {
  return plane_field(surface, led, detail::mean_normal(surface, led), points, cancelled);
}

/// The same from the nearest of several points of an LED, each with the mean normal of its faces,
/// with the lengths of the arcs; points whose two shortest differ by less than a share `tie` are
/// told apart. Cost: one cut a point and point of the LED.
template <std::floating_point T>
[[nodiscard]] LightRays<T> plane_rays(const Surface<T>& surface, PointSpan<T> led,
                                      PointSpan<T> points, std::type_identity_t<T> tie = T(1e-6),
                                      const CancelHook& cancelled = {}) {
  detail::require(!led.empty(), "the LED has no point");
  detail::require(tie >= 0, "a tie of ", tie);
  using Cut = detail::PlaneCut<T>;
  std::vector<Vec3<T>> directions(points.size(), Vec3<T>(0, 0, 0));
  std::vector<T> least(points.size(), unreachable<T>), next = least;
  std::size_t done = 0;
  for (const auto& source : led) {
    const Vec3<T> normal = detail::mean_normal(surface, source);
    detail::require(!normal.isZero(0), "the LED's faces have no normal");
    Cut cut(surface, source, normal);
    for (std::size_t i = 0; i < points.size(); ++i) {
      detail::check_points(cancelled, done++, led.size() * points.size(), "the plane field");
      for (const auto& arrival : cut.arrive(points[i], cut.local(surface.position(points[i])))) {
        next[i] = std::min(next[i], std::max(least[i], arrival.length));
        if (!(arrival.length < least[i])) continue;
        least[i] = arrival.length;
        directions[i] = cut.in_space(arrival.direction);
      }
    }
  }
  LightRays<T> rays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Lighting how = !(least[i] < unreachable<T>)      ? Lighting::dark
                         : least[i] == 0                   ? Lighting::at_led
                         : next[i] <= (1 + tie) * least[i] ? Lighting::ambiguous
                                                           : Lighting::lit;
    rays.add(directions[i], least[i], how);
  }
  cancelled.check(1, "the plane field");
  return rays;
}

}  // namespace gelight
