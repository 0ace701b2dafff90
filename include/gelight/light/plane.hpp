#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <span>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
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
  PlaneWalk(const Surface<T>& surface, const SurfacePoint<T>& led, const Vec3<T>& normal)
      : surface_(surface),
        led_(surface.position(led)),
        led_faces_(faces_at(surface, led)),
        normal_(normal) {}

  /// The direction in which the shorter of the two arcs from the LED arrives at a point, or zero.
  [[nodiscard]] Vec3<T> arrive(const SurfacePoint<T>& point) const {
    const Vec3<T> target = surface_.position(point);
    const Array<Index> target_faces = faces_at(surface_, point);
    for (const Index f : led_faces_) {
      if (holds(target_faces, f)) return direction_of<T>(target - led_);
    }
    const Vec3<T> plane = cross<T>(normal_, target - led_);
    Array<Arc> arcs = starts(plane);
    // The shorter arc goes ahead, until one has arrived and no other can be shorter.
    Vec3<T> arrival = Vec3<T>::Zero();
    T shortest = ended;
    while (true) {
      const auto arc = std::min_element(
          arcs.begin(), arcs.end(), [](const Arc& a, const Arc& b) { return a.length < b.length; });
      if (arc == arcs.end() || arc->length >= shortest) return arrival;
      const T before = arc->length;
      advance(*arc, plane);
      if (arc->length == ended || !holds(target_faces, Surface<T>::face_of(arc->h))) continue;
      // The target may lie where the curve enters its face: the whole cut is the longer lever.
      const Vec3<T> along = arc->exit - arc->entry, to_target = target - arc->entry;
      if (before + to_target.norm() < shortest) {
        shortest = before + to_target.norm();
        arrival =
            direction_of<T>(along.squaredNorm() > to_target.squaredNorm() ? along : to_target);
      }
      arc->length = ended;
    }
  }

 private:
  static constexpr T ended = std::numeric_limits<T>::infinity();

  /// The end of the curve so far: in the face of h, which it leaves through h.
  struct Arc {
    Index h;
    T above_origin, above_tip;  // heights of h's ends above the plane
    Vec3<T> entry, exit;        // where it enters and leaves the face
    T length;                   // from the LED to `exit`
  };

  static bool holds(const Array<Index>& faces, Index f) {
    return std::find(faces.begin(), faces.end(), f) != faces.end();
  }

  [[nodiscard]] T height(Index v, const Vec3<T>& plane) const {
    return plane.dot(surface_.position(v) - led_);
  }

  /// Where the plane meets the edge that the arc leaves through.
  [[nodiscard]] Vec3<T> crossing(const Arc& arc) const {
    const Vec3<T>& a = surface_.position(surface_.origin(arc.h));
    const Vec3<T>& b = surface_.position(surface_.tip(arc.h));
    return a + arc.above_origin / (arc.above_origin - arc.above_tip) * (b - a);
  }

  /// The arcs that leave the LED's faces, but for sides that these share.
  [[nodiscard]] Array<Arc> starts(const Vec3<T>& plane) const {
    Array<Arc> arcs;
    for (const Index f : led_faces_) {
      for (const Index h : {3 * f, 3 * f + 1, 3 * f + 2}) {
        Arc arc{h, height(surface_.origin(h), plane), height(surface_.tip(h), plane), led_, led_,
                0};
        if ((arc.above_origin >= 0) == (arc.above_tip >= 0) || is_inside(h)) continue;
        arc.exit = crossing(arc);
        arc.length = (arc.exit - led_).norm();
        arcs.push_back(arc);
      }
    }
    return arcs;
  }
  [[nodiscard]] bool is_inside(Index h) const {
    for (Index t = surface_.twin(h); t != h; t = surface_.twin(t)) {
      if (holds(led_faces_, Surface<T>::face_of(t))) return true;
    }
    return false;
  }

  /// Takes an arc through one more face. It ends on a border, where more than two faces meet, and
  /// back at the LED.
  void advance(Arc& arc, const Vec3<T>& plane) const {
    const Index in = surface_.twin(arc.h);
    if (in == arc.h || !surface_.is_manifold(in) || holds(led_faces_, Surface<T>::face_of(in))) {
      arc.length = ended;
      return;
    }
    T above_origin = arc.above_origin, above_tip = arc.above_tip;
    if (surface_.origin(in) != surface_.origin(arc.h)) std::swap(above_origin, above_tip);
    const T above_apex = height(surface_.apex(in), plane);
    if ((above_apex >= 0) == (above_origin >= 0)) {
      arc = {Surface<T>::next(in), above_tip, above_apex, arc.exit, arc.exit, arc.length};
    } else {
      arc = {Surface<T>::previous(in), above_apex, above_origin, arc.exit, arc.exit, arc.length};
    }
    arc.exit = crossing(arc);
    arc.length += (arc.exit - arc.entry).norm();
  }

  const Surface<T>& surface_;
  Vec3<T> led_;
  Array<Index> led_faces_;
  Vec3<T> normal_;
};

}  // namespace detail

/// Light that stays in a plane: the surface is cut by the plane through the LED, the point and the
/// normal at the LED, and the light arrives along the shorter arc of the cut (Gomes, Paoletti, Luo,
/// "Simulation of Curved GelSight Sensors for Sim2Real Learning").
///
/// Zero where the point lies above the LED along the normal, or both arcs end at a border. Throws
/// InvalidInput for a point that is not of the surface and a normal that is zero or not finite.
/// Cost: O(faces that the arcs cross) a point.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        const Vec3<T>& normal,
                                        std::span<const SurfacePoint<T>> points) {
  detail::require(normal.allFinite() && !normal.isZero(0), "the normal at the LED is (", normal[0],
                  ", ", normal[1], ", ", normal[2], ")");
  const detail::PlaneWalk<T> walk(surface, led, detail::direction_of(normal));
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) field.push_back(walk.arrive(point));
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
