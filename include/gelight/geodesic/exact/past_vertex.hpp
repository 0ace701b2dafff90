#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// A direction in space, and the face along which it goes, or -1.
template <std::floating_point Real>
struct Way {
  Vec3<Real> direction{0, 0, 0};
  Index face = -1;
};

/// Straight lines from places next to a vertex, past it. There places differ from the vertex by
/// less than they are rounded by in the frames of the faces' other sides; here all counts from the
/// vertex.
template <std::floating_point Real>
class PastVertex {
 public:
  using Mesh = Surface<Real>;

  PastVertex(const Mesh& surface, const PlanarFaces<Real>& faces, Index vertex)
      : surface_(surface), faces_(faces), vertex_(vertex) {}

  /// A place in the face of a half-edge that starts at the vertex, in that one's frame; and the
  /// half-edge of the face at the vertex that it lies on, or -1.
  struct Place {
    Index corner = -1;
    Vec2<Real> at{0, 0};
    Index side = -1;
  };

  /// The place in a face at the vertex that has these shares of the face's corners.
  [[nodiscard]] Place place(Index face, const std::array<Real, 3>& shares) const {
    Index h = 3 * face;
    while (surface_.origin(h) != vertex_) ++h;
    const Real at_tip = shares[static_cast<std::size_t>((h + 1) % 3)];
    const Real at_apex = shares[static_cast<std::size_t>((h + 2) % 3)];
    const Index side = at_apex == 0 ? h : at_tip == 0 ? Mesh::previous(h) : -1;
    return {h, faces_.place(surface_, h, shares), side};
  }

  /// The direction, at a place given as each of its faces sees it, of the straight line from there
  /// to another place; of the line to the vertex, where that is shorter. Zero for a line over a
  /// face without area, which has no such direction.
  [[nodiscard]] Way<Real> way(const Array<Place>& from, const Place& to) const {
    const Turn turn = least_turn(from, to);
    const Index corner = turn.from.corner;
    Vec2<Real> end(0, 0);
    if (turn.angle < std::numbers::pi) {
      if (is_thin(surface_, faces_, corner)) return {};
      const Real angle = angle_of(turn.from.at) + turn.sign * turn.angle;
      end = norm(to.at) * Vec2<Real>(std::cos(angle), std::sin(angle));
    }
    return {unit_way(surface_, faces_, corner, turn.from.at, end), Mesh::face_of(corner)};
  }

  /// The angle at the vertex between a place, given as each of its faces sees it, and another; as
  /// far as it is less than pi.
  [[nodiscard]] Real angle(const Array<Place>& from, const Place& to) const {
    return least_turn(from, to).angle;
  }

 private:
  // From one place to another round the vertex: where it begins, and how far it turns to one side.
  struct Turn {
    Real angle = unreachable<Real>;
    Place from;
    Real sign = 1;
  };

  // How far it is to an edge at the vertex, which is reached in the face of half-edge `side`.
  struct Spoke {
    Turn turn;
    Index side;
  };
  static bool is_farther(const Spoke& a, const Spoke& b) { return a.turn.angle > b.turn.angle; }

  static Real angle_of(const Vec2<Real>& at) { return std::atan2(at.y(), at.x()); }

  // Goes from edge to edge, the nearest first. It is enough to go as far as pi.
  [[nodiscard]] Turn least_turn(const Array<Place>& from, const Place& to) const {
    const Real target = angle_of(to.at);
    Turn best;
    best.from = from.front();
    Array<Spoke> heap;
    Array<Index> passed;
    const auto push = [&](Real angle, const Turn& turn, Index side) {
      heap.push_back({{angle, turn.from, turn.sign}, side});
      std::push_heap(heap.begin(), heap.end(), is_farther);
    };
    const auto meet = [&](Real angle, const Turn& turn) {
      if (angle < best.angle) best = {angle, turn.from, turn.sign};
    };
    for (const Place& place : from) {
      const Index corner = place.corner;
      const Real angle = angle_of(place.at), opening = faces_.angle(corner);
      if (corner == to.corner)
        meet(std::fabs(target - angle), {0, place, target < angle ? -1.0 : 1.0});
      // From a place on an edge the turn goes into each of the faces there.
      const Index across = Mesh::previous(corner);
      if (place.side != corner) push(angle, {0, place, -1}, corner);
      if (place.side != across) push(opening - angle, {0, place, 1}, across);
    }
    while (!heap.empty()) {
      std::pop_heap(heap.begin(), heap.end(), is_farther);
      const auto [turn, side] = heap.back();
      heap.pop_back();
      if (turn.angle >= std::min<Real>(best.angle, std::numbers::pi)) break;
      if (std::find(passed.begin(), passed.end(), side) != passed.end()) continue;
      passed.push_back(side);
      for (Index h = surface_.twin(side); h != side; h = surface_.twin(h)) {
        passed.push_back(h);
        const bool is_out = surface_.origin(h) == vertex_;
        const Index corner = is_out ? h : Mesh::next(h);
        const Real opening = faces_.angle(corner);
        if (corner == to.corner) meet(turn.angle + (is_out ? target : opening - target), turn);
        push(turn.angle + opening, turn, is_out ? Mesh::previous(corner) : corner);
      }
    }
    return best;
  }

  const Mesh& surface_;
  const PlanarFaces<Real>& faces_;
  Index vertex_;
};

}  // namespace gelight::detail
