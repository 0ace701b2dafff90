#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <span>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
namespace detail {

/// Follows the curve in which a plane through the LED cuts the surface, from face to face.
///
/// A vertex counts as above the plane or below it, never on it, so that every face that the curve
/// enters it also leaves, whatever vertices and edges the plane meets.
template <std::floating_point T>
class PlaneWalk {
 public:
  PlaneWalk(const Surface<T>& surface, const SurfacePoint<T>& led)
      : surface_(surface), led_(surface.position(led)), led_faces_(faces_at(surface, led)) {
    Vec3<T> normal = Vec3<T>::Zero();
    for (const Index f : led_faces_) normal += face_normal(surface, f);
    normal_ = direction_of(normal);
  }

  /// The direction in which the shorter of the two arcs from the LED arrives at a point, or zero.
  [[nodiscard]] Vec3<T> arrive(const SurfacePoint<T>& point) const {
    const Vec3<T> target = surface_.position(point);
    const Array<Index> target_faces = faces_at(surface_, point);
    for (const Index f : led_faces_) {
      if (holds(target_faces, f)) return direction_of<T>(target - led_);
    }
    const Vec3<T> plane = cross<T>(normal_, target - led_);
    Arc best;
    for (const Index f : led_faces_) {
      for (const Index h : {3 * f, 3 * f + 1, 3 * f + 2}) {
        if (!starts_through(h, plane)) continue;
        const Arc arc = walk(h, plane, target, target_faces);
        if (arc.length < best.length) best = arc;
      }
    }
    return best.arrival;
  }

 private:
  struct Arc {
    T length = std::numeric_limits<T>::infinity();
    Vec3<T> arrival = Vec3<T>::Zero();
  };

  static bool holds(const Array<Index>& faces, Index f) {
    return std::find(faces.begin(), faces.end(), f) != faces.end();
  }

  [[nodiscard]] T height(Index v, const Vec3<T>& plane) const {
    return plane.dot(surface_.position(v) - led_);
  }
  [[nodiscard]] bool crosses(Index h, const Vec3<T>& plane) const {
    return (height(surface_.origin(h), plane) >= 0) != (height(surface_.tip(h), plane) >= 0);
  }
  /// Where the plane meets the edge of a half-edge that crosses it.
  [[nodiscard]] Vec3<T> crossing(Index h, const Vec3<T>& plane) const {
    const Vec3<T>& a = surface_.position(surface_.origin(h));
    const Vec3<T>& b = surface_.position(surface_.tip(h));
    const T height_a = height(surface_.origin(h), plane), height_b = height(surface_.tip(h), plane);
    return a + height_a / (height_a - height_b) * (b - a);
  }
  /// Whether an arc leaves the LED's faces through h: not across a side that they share.
  [[nodiscard]] bool starts_through(Index h, const Vec3<T>& plane) const {
    if (!crosses(h, plane)) return false;
    for (Index t = surface_.twin(h); t != h; t = surface_.twin(t)) {
      if (holds(led_faces_, Surface<T>::face_of(t))) return false;
    }
    return true;
  }

  /// Follows the curve out of half-edge h until it enters a face of the target. It ends without
  /// arriving on a border, where more than two faces meet, and back at the LED.
  [[nodiscard]] Arc walk(Index h, const Vec3<T>& plane, const Vec3<T>& target,
                         const Array<Index>& target_faces) const {
    Vec3<T> entry = crossing(h, plane);
    T length = (entry - led_).norm();
    while (!surface_.is_border(h) && surface_.is_manifold(h)) {
      h = surface_.twin(h);
      const Index face = Surface<T>::face_of(h);
      if (holds(led_faces_, face)) break;
      const bool through_next = crosses(Surface<T>::next(h), plane);
      h = through_next ? Surface<T>::next(h) : Surface<T>::previous(h);
      const Vec3<T> exit = crossing(h, plane);
      if (holds(target_faces, face)) {
        // The target may lie on the side where the curve enters: the whole cut is the longer lever.
        const Vec3<T> along = exit - entry, to_target = target - entry;
        const bool lever = along.squaredNorm() > to_target.squaredNorm();
        return {length + to_target.norm(), direction_of<T>(lever ? along : to_target)};
      }
      length += (exit - entry).norm();
      entry = exit;
    }
    return {};
  }

  const Surface<T>& surface_;
  Vec3<T> led_;
  Array<Index> led_faces_;
  Vec3<T> normal_;
};

}  // namespace detail

/// Light that stays in a plane: the surface is cut by the plane through the LED, the point and the
/// surface normal at the LED, and the light arrives along the shorter arc of the cut (Gomes,
/// Paoletti, Luo, "Simulation of Curved GelSight Sensors for Sim2Real Learning").
///
/// Zero where the point lies above the LED along its normal, or both arcs end at a border. Throws
/// InvalidInput for a point that is not of the surface. Cost: O(faces that the arcs cross) a point.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        std::span<const SurfacePoint<T>> points) {
  const detail::PlaneWalk<T> walk(surface, led);
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) field.push_back(walk.arrive(point));
  return field;
}

}  // namespace gelight
