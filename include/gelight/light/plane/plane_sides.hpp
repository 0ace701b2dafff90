#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/plane/plane_cut.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// On which way round the LED the shorter arc comes to each face, for faces where it is the same
/// for all points: known from the cuts by a fan of planes, so that a point need not be cut for.
///
/// The sides are told apart by the direction in which the arc crosses the face: along, or against,
/// the face's normal x the direction in which the point goes as the plane turns. As the plane
/// turns, the arcs change little by little, except where it passes a saddle of the turn; where the
/// sides meet, and at faces that the plane of a saddle cuts, the side is not told.
template <std::floating_point T>
class PlaneSides {
 public:
  enum class Side : signed char { unknown, along, against, mixed };

  PlaneSides(const Surface<T>& surface, PlaneCut<T>& cut, const CancelHook& cancelled)
      : surface_(surface), cut_(cut) {
    const auto faces = static_cast<std::size_t>(surface.face_count());
    sides_.assign(faces, Side::unknown);
    normals_.reserve(faces);
    for (Index f = 0; f < surface.face_count(); ++f) normals_.push_back(normal(f));
    if (!is_oriented()) {
      sides_.assign(faces, Side::mixed);
      return;
    }
    // A curve crosses some 5 sqrt(faces) of them: then a face is cut some 20 times.
    planes_ = static_cast<Index>(4 * std::sqrt(static_cast<double>(faces)));
    cuts_.assign(faces, 0);
    for (Index j = 0; j < planes_; ++j) {
      cancelled.check(static_cast<double>(j) / planes_, "the plane field");
      mark_by_plane(static_cast<T>(2 * j + 1) / planes_t());
    }
    find_saddles();
    for (Index f = 0; f < surface.face_count(); ++f) {
      if (!is_told_by_cuts(f)) sides_[f] = Side::mixed;
    }
    spread();
    mix_where_sides_meet();
  }

  [[nodiscard]] Side side(Index face) const { return sides_[face]; }

  /// The direction in which light crosses a face at a place of it, in the LED's coordinates.
  [[nodiscard]] Vec3<T> direction(Index face, const Vec3<T>& place) const {
    const Vec3<T> along = along_at(face, place);
    return direction_of<T>(sides_[face] == Side::along ? along : Vec3<T>(-along));
  }

  [[nodiscard]] Vec3<T> along_at(Index face, const Vec3<T>& place) const {
    const Vec3<T>& n = normals_[face];
    return {-n[2] * place[0], -n[2] * place[1], n[0] * place[0] + n[1] * place[1]};
  }

 private:
  [[nodiscard]] T planes_t() const { return static_cast<T>(planes_); }

  [[nodiscard]] Vec3<T> normal(Index f) const {
    const auto [a, b, c] = surface_.face(f);
    return cross<T>(cut_.place(b) - cut_.place(a), cut_.place(c) - cut_.place(a));
  }

  [[nodiscard]] bool is_oriented() const {
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      const Index t = surface_.twin(h);
      if (t != h && surface_.is_manifold(h) && surface_.origin(t) == surface_.origin(h)) {
        return false;
      }
    }
    return true;
  }

  void mark_by_plane(T turn) {
    cut_.cut(turn, normalized(turn < 1 ? Vec2<T>(1 - turn, turn) : Vec2<T>(1 - turn, 2 - turn)));
    // Of each face: by which arc it is entered where, for two arcs.
    entered_.resize(sides_.size(), {-1, -1});
    const auto& arcs = cut_.arcs();
    if (arcs.size() > 2) return;
    for (std::size_t a = 0; a < arcs.size(); ++a) {
      for_each_face(arcs[a], [&](Index f, Index k) { entered_[f][a] = k; });
    }
    for (std::size_t a = 0; a < arcs.size(); ++a) {
      for_each_face(arcs[a], [&](Index f, Index k) {
        const Index other = entered_[f][1 - a];
        const auto& own = arcs[a].lengths;
        if (other >= 0) {
          const auto& others = arcs[1 - a].lengths;
          if (others[other + 1] < own[k]) return;
          if (!(own[k + 1] < others[other])) return mark(f, Side::mixed);
        }
        const Vec3<T> middle = (arcs[a].places[k] + arcs[a].places[k + 1]) / 2;
        const Vec3<T> travel = arcs[a].places[k + 1] - arcs[a].places[k];
        const T sign = dot(along_at(f, middle), travel);
        mark(f, sign > 0 ? Side::along : sign < 0 ? Side::against : Side::mixed);
      });
    }
    for (const auto& arc : arcs) {
      for_each_face(arc, [&](Index f, Index) { entered_[f] = {-1, -1}; });
    }
  }

  static void for_each_face(const typename PlaneCut<T>::Arc& arc, auto&& visit) {
    for (Index k = 0; k + 1 < std::ssize(arc.crossed); ++k) {
      visit(Surface<T>::face_of(arc.crossed[k + 1]), k);
    }
  }

  void mark(Index f, Side side) {
    ++cuts_[f];
    sides_[f] = sides_[f] == Side::unknown || sides_[f] == side ? side : Side::mixed;
  }

  /// Vertices where the curve parts or joins as the plane turns: more than two sides of their
  /// faces are cut by the vertex' plane.
  void find_saddles() {
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (std::isnan(cut_.angle(v))) continue;
      Index changes = 0, regular = 2;
      for (const Index h : surface_.corners(v)) {
        changes += is_above(surface_.tip(h), v) != is_above(surface_.apex(h), v);
        for (const Index side : {h, Surface<T>::previous(h)}) {
          if (surface_.is_border(side) || !surface_.is_manifold(side)) regular = 1;
        }
      }
      if (changes > regular) saddles_.push_back(PlaneCut<T>::turn_of(cut_.angle(v)));
    }
    std::sort(saddles_.begin(), saddles_.end());
  }

  // Of two vertices in one plane the one with the lower number is passed first.
  [[nodiscard]] bool is_above(Index w, Index v) const {
    const T turn_w = PlaneCut<T>::turn_of(cut_.angle(w)),
            turn_v = PlaneCut<T>::turn_of(cut_.angle(v));
    const bool passed = turn_w < turn_v || (turn_w == turn_v && w < v);
    return passed != (cut_.angle(w) < 2);
  }

  /// Whether the curve from the LED ran through a face in each plane of the fan that cuts it, and
  /// no saddle's plane does.
  [[nodiscard]] bool is_told_by_cuts(Index f) const {
    if (sides_[f] == Side::mixed || cut_.is_led_face(f)) return false;
    const auto vertices = surface_.face(f);
    const T first = cut_.angle(vertices[0]);
    std::array<T, 3> angles{first, first, first};
    T round = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      T step = cut_.angle(vertices[(k + 1) % 3]) - cut_.angle(vertices[k]);
      if (std::isnan(step) || std::abs(step) == 2) return false;
      if (step > 2) step -= 4;
      if (step < -2) step += 4;
      round += step;
      if (k < 2) angles[k + 1] = angles[k] + step;
    }
    if (std::abs(round) > 1) return false;  // the normal goes through the face
    const auto [least, most] = std::minmax({angles[0], angles[1], angles[2]});
    const auto planes_before = [&](T angle) { return std::floor((angle * planes_t() - 1) / 2); };
    if (static_cast<T>(cuts_[f]) < planes_before(most) - planes_before(least)) return false;
    for (int half_turns = -2; half_turns < 4; ++half_turns) {
      const T from = least - T(2 * half_turns);
      const auto saddle = std::lower_bound(saddles_.begin(), saddles_.end(), from);
      if (saddle != saddles_.end() && *saddle <= from + (most - least)) return false;
    }
    return true;
  }

  /// Gives faces between the planes the side of their neighbours.
  void spread() {
    Array<Index> known;
    for (Index f = 0; f < surface_.face_count(); ++f) {
      if (is_told(f)) known.push_back(f);
    }
    while (!known.empty()) {
      const Index f = known.back();
      known.pop_back();
      for_each_neighbour(f, [&](Index g) {
        if (sides_[g] != Side::unknown) return;
        sides_[g] = sides_[f];
        known.push_back(g);
      });
    }
  }

  [[nodiscard]] bool is_told(Index f) const {
    return sides_[f] == Side::along || sides_[f] == Side::against;
  }

  /// Faces beside such of another side, and those around them.
  void mix_where_sides_meet() {
    for (int ring = 0; ring < 2; ++ring) {
      Array<Index> meeting;
      for (Index f = 0; f < surface_.face_count(); ++f) {
        if (!is_told(f)) continue;
        bool meets = false;
        for_each_neighbour(f, [&](Index g) { meets |= sides_[g] != sides_[f]; });
        if (meets) meeting.push_back(f);
      }
      for (const Index f : meeting) sides_[f] = Side::mixed;
    }
  }

  void for_each_neighbour(Index f, auto&& visit) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      if (!surface_.is_border(h) && surface_.is_manifold(h)) {
        visit(Surface<T>::face_of(surface_.twin(h)));
      }
    }
  }

  const Surface<T>& surface_;
  PlaneCut<T>& cut_;
  Index planes_ = 0;
  Array<Side> sides_;       // of each face
  Array<Vec3<T>> normals_;  // of each face, in the LED's coordinates, not of unit length
  Array<Index> cuts_;       // of each face: how many planes of the fan cut it on the LED's curve
  Array<T> saddles_;        // their turns
  Array<std::array<Index, 2>> entered_;
};

}  // namespace gelight::detail
