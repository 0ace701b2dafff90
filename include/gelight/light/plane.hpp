#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
namespace detail {

/// The curves in which the planes through an LED that hold a given normal cut a surface.
///
/// Coordinates are the LED's: x and y in its tangent plane, z along the normal. A plane is named by
/// its turn about the normal, from 0 to pi. A vertex counts as above the plane or below it, never
/// on it, so that every face that a curve enters it also leaves, whatever vertices and edges the
/// plane meets. As the plane turns, the curve runs through the same faces until the plane meets one
/// of their vertices; up to then its crossings alone are found anew, all at once.
template <std::floating_point T>
class PlaneCut {
 public:
  PlaneCut(const Surface<T>& surface, const SurfacePoint<T>& led, const Vec3<T>& normal)
      : surface_(surface), led_(surface.position(led)), led_faces_(faces_at(surface, led)) {
    const Vec3<T> z = direction_of(normal);
    const Vec3<T> aside = std::abs(z[0]) < T(0.5) ? Vec3<T>::UnitX() : Vec3<T>::UnitY();
    const Vec3<T> x = direction_of(cross(z, aside));
    axes_ << x, cross(z, x), z;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      places_.push_back(local(surface.position(v)));
      const Vec3<T>& p = places_.back();
      turns_.push_back(turn_of(p));
      is_ahead_.push_back(p[1] > 0 || (p[1] == 0 && p[0] > 0) ? 1 : 0);
    }
  }

  [[nodiscard]] Vec3<T> local(const Vec3<T>& p) const { return axes_.transpose() * (p - led_); }

  /// The turn of the plane that holds a point, from 0 to pi; NaN on the normal, where all planes do.
  [[nodiscard]] static T turn_of(const Vec3<T>& p) {
    if (p[1] == 0) return p[0] == 0 ? std::numeric_limits<T>::quiet_NaN() : T(0);
    const T turn = std::atan2(p[1], p[0]);
    return turn < 0 ? turn + std::numbers::pi_v<T> : turn;
  }

  /// The direction in which the shorter of the arcs from the LED arrives at a point, or zero. Quick
  /// where the plane has turned little since the last point.
  [[nodiscard]] Vec3<T> arrive(const SurfacePoint<T>& point) {
    const Vec3<T> target = local(surface_.position(point));
    const Array<Index> target_faces = faces_at(surface_, point);
    for (const Index f : led_faces_) {
      if (holds(target_faces, f)) return direction_of<T>(axes_ * target);
    }
    const T turn = turn_of(target);
    if (std::isnan(turn)) return Vec3<T>::Zero();
    if (!(valid_from_ < turn && turn <= valid_to_)) follow(turn);
    const Vec2<T> trace(std::cos(turn), std::sin(turn));
    const Vec2<T> end(trace.dot(target.template head<2>()), target[2]);
    Arrival best;
    for (const Arc& arc : arcs_) {
      const Index entry = first_entry(arc, target_faces);
      if (entry < 0) continue;
      const Arrival arrival = arrive_by(arc, entry, trace, end);
      if (arrival.length < best.length) best = arrival;
    }
    const Vec3<T> direction(best.direction[0] * trace[0], best.direction[0] * trace[1],
                            best.direction[1]);
    return direction_of<T>(axes_ * direction);
  }

 private:
  /// One way out of the LED: the half-edges that the curve crosses, one after the other.
  struct Arc {
    Array<Index> crossed;
    Array<Index> passed;  // of each face: at which of `crossed` the curve enters it, or -1
    Eigen::Array<T, Eigen::Dynamic, 6> ends;  // of each of `crossed`: x y z, x y z
  };
  struct Arrival {
    T length = unreachable<T>;
    Vec2<T> direction = Vec2<T>::Zero();  // in the plane: along its trace, along the normal
  };

  static bool holds(const Array<Index>& faces, Index f) {
    return std::find(faces.begin(), faces.end(), f) != faces.end();
  }

  /// Which crossing is the first into one of several faces, or -1.
  [[nodiscard]] static Index first_entry(const Arc& arc, const Array<Index>& faces) {
    Index first = -1;
    for (const Index f : faces) {
      const Index entry = arc.passed[f];
      if (entry >= 0 && (first < 0 || entry < first)) first = entry;
    }
    return first;
  }

  /// Finds the arcs of the plane with this turn, and between which turns they cross the same edges.
  void follow(T turn) {
    valid_from_ = -unreachable<T>;
    valid_to_ = unreachable<T>;
    // By comparing turns alone, so that the arcs and the span of turns they hold for agree.
    const auto is_above = [&](Index v) { return (turns_[v] < turn) != (is_ahead_[v] != 0); };
    std::size_t count = 0;
    for (const Index f : led_faces_) {
      for (const Index h : {3 * f, 3 * f + 1, 3 * f + 2}) {
        limit(surface_.origin(h), turn);
        if (is_above(surface_.origin(h)) == is_above(surface_.tip(h)) || is_inside(h)) continue;
        if (count == arcs_.size()) arcs_.emplace_back();
        run(arcs_[count++], h, turn, is_above);
      }
    }
    arcs_.resize(count);
  }

  /// A vertex on the curve's way: the curve changes its way when the plane meets it.
  void limit(Index v, T turn) {
    if (turns_[v] < turn) valid_from_ = std::max(valid_from_, turns_[v]);
    if (turns_[v] >= turn) valid_to_ = std::min(valid_to_, turns_[v]);
  }

  /// Whether h is a side that the LED's faces share.
  [[nodiscard]] bool is_inside(Index h) const {
    for (Index t = surface_.twin(h); t != h; t = surface_.twin(t)) {
      if (holds(led_faces_, Surface<T>::face_of(t))) return true;
    }
    return false;
  }

  /// Follows an arc out of the LED's faces through h. It ends on a border, where more than two
  /// faces meet, and back at the LED.
  void run(Arc& arc, Index h, T turn, const auto& is_above) {
    if (arc.passed.empty()) arc.passed.assign(static_cast<std::size_t>(surface_.face_count()), -1);
    for (const Index crossed : arc.crossed) arc.passed[Surface<T>::face_of(crossed)] = -1;
    arc.crossed.assign(1, h);
    while (true) {
      const Index in = surface_.twin(h);
      if (in == h || !surface_.is_manifold(in)) break;
      if (holds(led_faces_, Surface<T>::face_of(in))) break;
      const Index apex = surface_.apex(in);
      limit(apex, turn);
      h = is_above(apex) == is_above(surface_.origin(in)) ? Surface<T>::next(in)
                                                          : Surface<T>::previous(in);
      arc.passed[Surface<T>::face_of(h)] = static_cast<Index>(arc.crossed.size()) - 1;
      arc.crossed.push_back(h);
    }
    arc.ends.resize(static_cast<Eigen::Index>(arc.crossed.size()), 6);
    for (Eigen::Index k = 0; k < arc.ends.rows(); ++k) {
      arc.ends.row(k) << places_[surface_.origin(arc.crossed[k])].transpose().array(),
          places_[surface_.tip(arc.crossed[k])].transpose().array();
    }
  }

  /// The arc's arrival at a point, given in the plane, of the face behind crossing `entry`.
  [[nodiscard]] Arrival arrive_by(const Arc& arc, Index entry, const Vec2<T>& trace,
                                  const Vec2<T>& end) {
    const Eigen::Index count = entry + 2;  // the last crossing is where the curve would leave
    const auto x0 = arc.ends.col(0).head(count), x1 = arc.ends.col(3).head(count);
    const auto y0 = arc.ends.col(1).head(count), y1 = arc.ends.col(4).head(count);
    const auto z0 = arc.ends.col(2).head(count), z1 = arc.ends.col(5).head(count);
    // Both ends may lie in the plane but for rounding: then any share in [0, 1] is right.
    constexpr T tiny = std::numeric_limits<T>::min();
    share_ = (trace[0] * y0 - trace[1] * x0).abs() + tiny;
    share_ /= share_ + (trace[0] * y1 - trace[1] * x1).abs() + tiny;
    along_ = trace[0] * (x0 + share_ * (x1 - x0)) + trace[1] * (y0 + share_ * (y1 - y0));
    height_ = z0 + share_ * (z1 - z0);
    const Vec2<T> in(along_[entry], height_[entry]), out(along_[entry + 1], height_[entry + 1]);
    const T length = std::hypot(along_[0], height_[0]) + (end - in).norm() +
                     ((along_.segment(1, entry) - along_.head(entry)).square() +
                      (height_.segment(1, entry) - height_.head(entry)).square())
                         .sqrt()
                         .sum();
    // The point may lie where the curve enters its face: the whole cut is the longer lever.
    const bool lever = (out - in).squaredNorm() > (end - in).squaredNorm();
    return {length, lever ? Vec2<T>(out - in) : Vec2<T>(end - in)};
  }

  const Surface<T>& surface_;
  Vec3<T> led_;
  Array<Index> led_faces_;
  Eigen::Matrix<T, 3, 3> axes_;
  Array<Vec3<T>> places_;  // of each vertex, in the LED's coordinates
  Array<T> turns_;         // of each vertex, the plane that holds it
  Array<char> is_ahead_;   // of each vertex: whether the plane meets it with its forward half
  std::vector<Arc> arcs_;
  T valid_from_ = 1, valid_to_ = 0;  // between which turns the arcs stay as they are
  Eigen::Array<T, Eigen::Dynamic, 1> share_, along_, height_;  // of the crossings; scratch
};

}  // namespace detail

/// Light that stays in a plane: the surface is cut by the plane through the LED, the point and the
/// normal at the LED, and the light arrives along the shorter arc of the cut (Gomes, Paoletti, Luo,
/// "Simulation of Curved GelSight Sensors for Sim2Real Learning").
///
/// Zero where the point lies above the LED along the normal, or both arcs end at a border. Throws
/// InvalidInput for a point that is not of the surface and a normal that is zero or not finite.
/// Cost: O(faces that the arcs cross) a point, and sorting the points.
template <std::floating_point T>
[[nodiscard]] LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                                        const Vec3<T>& normal,
                                        std::span<const SurfacePoint<T>> points) {
  detail::require(normal.allFinite() && !normal.isZero(0), "the normal at the LED is (", normal[0],
                  ", ", normal[1], ", ", normal[2], ")");
  detail::PlaneCut<T> cut(surface, led, normal);
  std::vector<std::pair<T, std::size_t>> by_turn;
  by_turn.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const T turn = cut.turn_of(cut.local(surface.position(points[i])));
    by_turn.emplace_back(std::isnan(turn) ? 0 : turn, i);
  }
  std::sort(by_turn.begin(), by_turn.end());
  LightField<T> field(points.size());
  for (const auto& [turn, i] : by_turn) field[i] = cut.arrive(points[i]);
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
