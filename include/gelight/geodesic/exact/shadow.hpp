#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// What lies behind a vertex for a path that arrives there: the directions that make an angle of pi
/// or more with it on either side. Only there can a shortest path go on from the vertex; elsewhere
/// a short cut leads past it. For vertices with one plain fan of faces.
template <std::floating_point Real>
class Shadow {
 public:
  using Mesh = Surface<Real>;

  /// The limits are moved outwards by an angle `overlap`, so that rounding leaves an overlap rather
  /// than a gap: hardly on the opposite edge of a plain face, and over all of it where a face has
  /// no area.
  Shadow(const Mesh& surface, const PlanarFaces<Real>& faces, Index vertex, Real overlap)
      : surface_(surface), faces_(faces), vertex_(vertex), overlap_(overlap) {}

  /// Calls visit(h, begin, end) for every part in shadow of an edge opposite to the vertex:
  /// half-edge h of a face at the vertex, from one position on it to another. The path comes from
  /// the corner whose half-edge out of the vertex is `corner`, from direction `back` (a unit vector
  /// in the frame of `corner`).
  template <class Visit>
  void cast(Index corner, const Vec2<Real>& back, const Visit& visit) const {
    const Vec2<Real> opening = rotation(corner);
    const Limit left = turn(Mesh::previous(corner), rotated_back(opening, back));
    const Limit right = turn(corner, back);
    if (left.entering >= 0 && sweep(left, right, visit)) return;
    if (right.entering >= 0) (void)sweep(right, left, visit);
  }

 private:
  // Where the shadow begins: the half-edge over which a turn comes into the face, and at which
  // share of the opposite edge, counted from that half-edge. -1 where a border comes first.
  struct Limit {
    Index entering = -1;
    Real share = 0;
  };

  // Rotations are unit complex numbers.
  static Vec2<Real> rotated(const Vec2<Real>& a, const Vec2<Real>& b) {
    return {a.x() * b.x() - a.y() * b.y(), a.x() * b.y() + a.y() * b.x()};
  }
  static Vec2<Real> rotated_back(const Vec2<Real>& a, const Vec2<Real>& b) {
    return {a.x() * b.x() + a.y() * b.y(), a.y() * b.x() - a.x() * b.y()};
  }
  static Real cross(const Vec2<Real>& a, const Vec2<Real>& b) {
    return a.x() * b.y() - a.y() * b.x();
  }

  // The angle of a face at the vertex, given by its half-edge out of the vertex.
  [[nodiscard]] Vec2<Real> rotation(Index corner) const {
    const Vec2<Real>& apex = faces_.apex(corner);
    const Real length = surface_.length(Mesh::previous(corner));
    return {apex.x() / length, apex.y() / length};
  }

  // Of the face of a half-edge at the vertex: the half-edge out of it, and the other half-edge
  // there.
  [[nodiscard]] Index corner_of(Index h) const {
    return surface_.origin(h) == vertex_ ? h : Mesh::next(h);
  }
  [[nodiscard]] Index other_side(Index h) const {
    return surface_.origin(h) == vertex_ ? Mesh::previous(h) : Mesh::next(h);
  }

  // Turns from face to face, at first over half-edge `side`, at which an angle `turned` is behind,
  // until the angle is pi.
  [[nodiscard]] Limit turn(Index side, Vec2<Real> turned) const {
    for (auto faces = std::ssize(surface_.corners(vertex_)); faces > 0; --faces) {
      if (surface_.is_border(side)) return {};
      const Index entering = surface_.twin(side);
      const Vec2<Real> opening = rotation(corner_of(entering));
      const Vec2<Real> rest(-turned.x(), turned.y());  // to the angle pi
      const Real beyond = cross(rest, opening);
      if (rest.y() >= -overlap_ && beyond >= -overlap_) {
        const Real near = surface_.length(entering);
        const Real far = surface_.length(other_side(entering));
        const Real to_near = near * (rest.y() - overlap_), to_far = far * (beyond + overlap_);
        return {entering, to_near > 0 ? to_near / (to_near + to_far) : 0};
      }
      turned = rotated(turned, opening);
      side = other_side(entering);
    }
    return {};
  }

  // Visits from one limit on, to the other one or to the border; returns whether to the other.
  template <class Visit>
  [[nodiscard]] bool sweep(const Limit& from, const Limit& to, const Visit& visit) const {
    Index entering = from.entering;
    Real begin = from.share;
    for (auto faces = std::ssize(surface_.corners(vertex_)); faces > 0; --faces) {
      const bool last = to.entering >= 0 && Mesh::face_of(entering) == Mesh::face_of(to.entering);
      const Real end = last ? 1 - to.share : 1;
      if (begin < end) {
        const Index opposite = Mesh::next(corner_of(entering));
        const Real length = surface_.length(opposite);
        if (surface_.origin(entering) == vertex_) {
          visit(opposite, begin * length, end * length);
        } else {
          visit(opposite, (1 - end) * length, (1 - begin) * length);
        }
      }
      if (last) return true;
      const Index side = other_side(entering);
      if (surface_.is_border(side)) return false;
      entering = surface_.twin(side);
      begin = 0;
    }
    return true;
  }

  const Mesh& surface_;
  const PlanarFaces<Real>& faces_;
  Index vertex_;
  Real overlap_;
};

}  // namespace gelight::detail
