#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The curves in which the planes through an LED that hold a given normal cut a surface, one plane
/// at a time.
///
/// Coordinates are the LED's: x and y in its tangent plane, z along the normal; in a unit of the
/// surface's size, so that products of them are numbers. A plane is named by its turn about the
/// normal. A vertex counts as above the plane or below it, never on it, so that every face that a
/// curve enters it also leaves, whatever vertices and edges the plane meets. On which side those
/// count that are in the plane but for rounding matters where they are a border: then light comes
/// along it if it does so by the planes a hair to the one side or the other.
template <std::floating_point T>
class PlaneCut {
 public:
  /// One way out of the LED: the half-edges that the curve crosses, one after the other.
  struct Arc {
    Array<Index> crossed;
    Array<Vec3<T>> places;  // where, in the LED's coordinates
    Array<T> lengths;       // from the LED
  };

  /// How light arrives at a point by an arc, which enters one of the point's faces at `entry`.
  struct Arrival {
    Vec3<T> direction = Vec3<T>(0, 0, 0);  // in the LED's coordinates
    T length = unreachable<T>;             // in the surface's unit
    Index entry = -1;
    const Arc* arc = nullptr;
  };

  PlaneCut(const Surface<T>& surface, const SurfacePoint<T>& led, const Vec3<T>& normal)
      : surface_(surface), led_faces_(faces_at(surface, led)) {
    choose_unit();
    led_ = surface.position(led) / unit_;
    const Vec3<T> z = direction_of(normal);
    const Vec3<T> aside = std::abs(z[0]) < T(0.5) ? Vec3<T>::UnitX() : Vec3<T>::UnitY();
    const Vec3<T> x = direction_of(cross(z, aside));
    axes_ << x, cross(z, x), z;
    const auto vertices = static_cast<std::size_t>(surface.vertex_count());
    places_.reserve(vertices);
    angles_.reserve(vertices);
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      places_.push_back(local(surface.position(v)));
      angles_.push_back(angle_of(places_.back()));
    }
    is_led_face_.assign(static_cast<std::size_t>(surface.face_count()), 0);
    for (const Index f : led_faces_) is_led_face_[f] = 1;
  }

  [[nodiscard]] Vec3<T> local(const Vec3<T>& p) const {
    return axes_.transpose() * (p / unit_ - led_);
  }
  [[nodiscard]] Vec3<T> in_space(const Vec3<T>& direction) const { return axes_ * direction; }
  [[nodiscard]] const Vec3<T>& place(Index vertex) const { return places_[vertex]; }
  [[nodiscard]] T angle(Index vertex) const { return angles_[vertex]; }
  [[nodiscard]] bool is_led_face(Index face) const { return is_led_face_[face] != 0; }
  [[nodiscard]] const std::vector<Arc>& arcs() const { return arcs_; }

  /// Of a point about the normal: from 0 to 4 as its angle grows from 0 to 2 pi, but not in
  /// proportion. NaN on the normal. The plane's turn is this modulo 2.
  [[nodiscard]] static T angle_of(const Vec3<T>& p) {
    const T sum = std::abs(p[0]) + std::abs(p[1]);
    if (sum == 0) return std::numeric_limits<T>::quiet_NaN();
    const T part = std::abs(p[1]) / sum;
    if (p[1] >= 0) return p[0] > 0 || (p[0] == 0 && p[1] > 0) ? part : 2 - part;
    return p[0] < 0 ? 2 + part : 4 - part;
  }
  [[nodiscard]] static T turn_of(T angle) { return angle < 2 ? angle : angle - 2; }

  /// What becomes of vertices in the plane but for rounding.
  enum class InPlane { by_turn, above, below };

  /// Cuts by the plane of a turn and finds its arcs. `trace` is its direction in the tangent plane.
  void cut(T turn, const Vec2<T>& trace, InPlane in_plane = InPlane::by_turn) {
    trace_ = trace;
    in_plane_ = in_plane;
    std::size_t count = 0;
    for (const Index f : led_faces_) {
      for (const Index h : {3 * f, 3 * f + 1, 3 * f + 2}) {
        if (is_above(surface_.origin(h), turn) == is_above(surface_.tip(h), turn)) continue;
        if (is_inside(h)) continue;
        if (count == arcs_.size()) arcs_.emplace_back();
        run(arcs_[count++], h, turn);
      }
    }
    arcs_.resize(count);
  }

  /// The arrivals at a point by the arcs of its own plane, the shortest first; straight in the
  /// LED's faces; none on the normal or where no arc comes. The point's coordinates are the LED's.
  [[nodiscard]] const std::vector<Arrival>& arrive(const SurfacePoint<T>& point,
                                                   const Vec3<T>& place) {
    arrivals_.clear();
    const Array<Index> faces = faces_at(surface_, point);
    if (std::any_of(faces.begin(), faces.end(), [&](Index f) { return is_led_face(f); })) {
      arrivals_.push_back({direction_of(place), unit_ * stable_norm(place), -1, nullptr});
      return arrivals_;
    }
    const T angle = angle_of(place);
    if (std::isnan(angle)) return arrivals_;
    const Vec2<T> trace = stable_unit(place.template head<2>());
    const T turn = turn_of(angle);
    for (const InPlane in_plane : {InPlane::by_turn, InPlane::above, InPlane::below}) {
      cut(turn, trace, in_plane);
      for (const Arc& arc : arcs_) {
        const Index entry = first_entry(arc, faces);
        if (entry >= 0) arrivals_.push_back(arrival_by(arc, entry, place));
      }
      if (!arrivals_.empty() || !touches_border(turn)) break;
    }
    std::stable_sort(arrivals_.begin(), arrivals_.end(),
                     [](const Arrival& a, const Arrival& b) { return a.length < b.length; });
    return arrivals_;
  }

 private:
  // A power of two, by which nothing is rounded.
  void choose_unit() {
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (surface_.corners(v).empty()) continue;  // it is cut nowhere
      farthest_ = std::max(farthest_, largest_part(surface_.position(v)));
    }
    unit_ = std::ldexp(T(1), std::max(std::ilogb(farthest_), std::numeric_limits<T>::min_exponent));
    farthest_ /= unit_;
  }

  // By comparing turns alone, so that it is the same for all faces at a vertex.
  [[nodiscard]] bool is_above(Index v, T turn) const {
    if (in_plane_ != InPlane::by_turn && is_in_plane(v, turn)) return in_plane_ == InPlane::above;
    return (turn_of(angles_[v]) < turn) != (angles_[v] < 2);
  }

  /// Whether a vertex is in a plane but for what rounding moves it, the LED and the plane by.
  [[nodiscard]] bool is_in_plane(Index v, T turn) const {
    const Vec3<T>& p = places_[v];
    const T off = std::abs(turn_of(angles_[v]) - turn);
    const T distance = std::abs(p[0]) + std::abs(p[1]);
    return !(std::min(off, 2 - off) * distance > rounding * (distance + farthest_));
  }

  /// Whether the border is in a plane where its arcs begin or end.
  [[nodiscard]] bool touches_border(T turn) const {
    const auto touches = [&](Index h) {
      return surface_.is_border(h) &&
             (is_in_plane(surface_.origin(h), turn) || is_in_plane(surface_.tip(h), turn));
    };
    for (const Index f : led_faces_) {
      if (touches(3 * f) || touches(3 * f + 1) || touches(3 * f + 2)) return true;
    }
    return std::any_of(arcs_.begin(), arcs_.end(),
                       [&](const Arc& arc) { return touches(arc.crossed.back()); });
  }

  /// Whether h is a side that the LED's faces share.
  [[nodiscard]] bool is_inside(Index h) const {
    for (Index t = surface_.twin(h); t != h; t = surface_.twin(t)) {
      if (is_led_face(Surface<T>::face_of(t))) return true;
    }
    return false;
  }

  /// Follows an arc out of the LED's faces through h. It ends on a border, where more than two
  /// faces meet, and back at the LED.
  void run(Arc& arc, Index h, T turn) const {
    arc.crossed.clear();
    arc.places.clear();
    arc.lengths.clear();
    Vec3<T> last = Vec3<T>(0, 0, 0);
    T length = 0;
    while (true) {
      const Vec3<T> place = crossing(h);
      length += norm(place - last);
      last = place;
      arc.crossed.push_back(h);
      arc.places.push_back(place);
      arc.lengths.push_back(length);
      const Index in = surface_.twin(h);
      if (in == h || !surface_.is_manifold(in) || is_led_face(Surface<T>::face_of(in))) return;
      const bool turns_right =
          is_above(surface_.apex(in), turn) == is_above(surface_.origin(in), turn);
      h = turns_right ? Surface<T>::next(in) : Surface<T>::previous(in);
    }
  }

  /// Where the plane crosses a half-edge. Both its ends may lie in the plane but for rounding: then
  /// any place between them is right.
  [[nodiscard]] Vec3<T> crossing(Index h) const {
    const Vec3<T>& a = places_[surface_.origin(h)];
    const Vec3<T>& b = places_[surface_.tip(h)];
    const T off_a = std::abs(trace_[0] * a[1] - trace_[1] * a[0]);
    const T off_b = std::abs(trace_[0] * b[1] - trace_[1] * b[0]);
    const T sum = off_a + off_b;
    return a + (sum > 0 ? off_a / sum : T(0.5)) * (b - a);
  }

  /// At which crossing an arc first enters one of several faces, or -1.
  [[nodiscard]] static Index first_entry(const Arc& arc, const Array<Index>& faces) {
    for (Index k = 1; k < std::ssize(arc.crossed); ++k) {
      const Index f = Surface<T>::face_of(arc.crossed[k]);
      if (std::find(faces.begin(), faces.end(), f) != faces.end()) return k - 1;
    }
    return -1;
  }

  [[nodiscard]] Arrival arrival_by(const Arc& arc, Index entry, const Vec3<T>& place) const {
    const Vec3<T> to_point = place - arc.places[entry];
    return {direction_by(arc, entry, to_point),
            unit_ * (arc.lengths[entry] + stable_norm(to_point)), entry, &arc};
  }

  /// The direction in which an arc crosses the face that it enters at `entry`.
  [[nodiscard]] Vec3<T> direction_by(const Arc& arc, Index entry, const Vec3<T>& to_point) const {
    const Vec3<T> across = arc.places[entry + 1] - arc.places[entry];
    // The point may lie where the curve enters its face: the whole cut is the longer lever.
    const Vec3<T>& lever = stable_norm(across) > stable_norm(to_point) ? across : to_point;
    const Index in = surface_.twin(arc.crossed[entry]), out = Surface<T>::next(in);
    const Vec3<T> side = place_of_tip(in) - place_of_origin(in);
    const Vec3<T> next = place_of_tip(out) - place_of_origin(out);
    const T longest = std::max(stable_norm(side), stable_norm(next));
    if (stable_norm(lever) > short_cut * longest) return direction_of<T>(lever);
    // Where it cuts but a corner off, rounding turns the cut; the two planes' line it does not.
    const Vec3<T> normal = direction_of<T>(cross<T>(side, next));
    const Vec3<T> along = direction_of<T>(cross<T>(normal, {-trace_[1], trace_[0], 0}));
    if (along.isZero(0)) return direction_of<T>(lever);
    return dot(along, cross<T>(normal, side)) < 0 ? Vec3<T>(-along) : along;
  }

  [[nodiscard]] const Vec3<T>& place_of_origin(Index h) const {
    return places_[surface_.origin(h)];
  }
  [[nodiscard]] const Vec3<T>& place_of_tip(Index h) const { return places_[surface_.tip(h)]; }

  // By this share of the farthest coordinate from the origin, or of the distance from the LED.
  static constexpr T rounding = 16 * std::numeric_limits<T>::epsilon();
  // Shorter beside its face's sides, a cut does not tell its direction.
  static constexpr T short_cut =
      std::max(T(next_to_vertex), 4096 * std::numeric_limits<T>::epsilon());

  const Surface<T>& surface_;
  T unit_ = 1;
  Vec3<T> led_;
  T farthest_ = 0;  // coordinate from the origin
  Array<Index> led_faces_;
  Array<char> is_led_face_;  // of each face
  Eigen::Matrix<T, 3, 3> axes_;
  Array<Vec3<T>> places_;  // of each vertex
  Array<T> angles_;        // of each vertex
  Vec2<T> trace_;
  InPlane in_plane_ = InPlane::by_turn;
  std::vector<Arc> arcs_;
  std::vector<Arrival> arrivals_;
};

}  // namespace gelight::detail
