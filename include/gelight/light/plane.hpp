#pragma once

#include <concepts>
#include <type_traits>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
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
                                        const CancelHook& cancelled = {});

namespace detail {

/// The mean normal of the faces at a point, by area, of any length.
template <std::floating_point T>
[[nodiscard]] Vec3<T> mean_normal(const Surface<T>& surface, const SurfacePoint<T>& point);

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
                                      const CancelHook& cancelled = {});

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/light/plane/body.hpp"
#endif
