#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"

namespace gelight::detail {

/// The shares of a face's corners that give a point of it: of the face itself, an edge or a vertex.
template <std::floating_point Real>
[[nodiscard]] std::array<Real, 3> shares_in_face(const Surface<Real>& surface,
                                                 const SurfacePoint<Real>& point, Index face) {
  using Kind = typename SurfacePoint<Real>::Kind;
  if (point.kind == Kind::face) return point.weights;
  std::array<Real, 3> shares{0, 0, 0};
  const auto vertices = surface.face(face);
  for (std::size_t k = 0; k < 3; ++k) {
    if (vertices[k] == point.element[0]) shares[k] = point.weights[0];
    if (point.kind == Kind::edge && vertices[k] == point.element[1]) shares[k] = point.weights[1];
  }
  return shares;
}

/// A face that holds both points, or -1.
template <std::floating_point Real>
[[nodiscard]] Index shared_face(const Surface<Real>& surface, const SurfacePoint<Real>& a,
                                const SurfacePoint<Real>& b) {
  Index shared = -1;
  for_each_face_at(surface, a, [&](Index f) {
    for_each_face_at(surface, b, [&](Index g) {
      if (f == g && shared < 0) shared = f;
    });
  });
  return shared;
}

/// The direction from one point of a face to another, as an angle from its first half-edge.
template <std::floating_point Real>
[[nodiscard]] Real direction_in_face(const Surface<Real>& surface, Index face,
                                     const SurfacePoint<Real>& from, const SurfacePoint<Real>& to) {
  const auto a = shares_in_face(surface, from, face);
  const auto b = shares_in_face(surface, to, face);
  const Index h = 3 * face;
  const auto [x1, x2, y2] =
      laid_out(mollified({surface.length(h), surface.length(h + 1), surface.length(h + 2)}, 1));
  return std::atan2((b[2] - a[2]) * y2, (b[1] - a[1]) * x1 + (b[2] - a[2]) * x2);
}

/// The tangent planes of all points of a surface, in which directions are angles: at vertices those
/// of TangentFrames; of a face and on an edge from the (first) half-edge's own direction.
template <std::floating_point Real>
class TangentPlanes {
 public:
  /// Throws InvalidInput as TangentFrames does.
  explicit TangentPlanes(const Surface<Real>& surface, const CancelHook& cancelled = {})
      : surface_(surface), frames_(surface, cancelled) {}

  /// With the angles of other edge lengths, the half-edges being the same.
  TangentPlanes(const Surface<Real>& surface, const IntrinsicTriangulation<Real>& mesh,
                const CancelHook& cancelled)
      : surface_(surface), frames_(surface, mesh, cancelled) {}

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }
  [[nodiscard]] const TangentFrames<Real>& frames() const { return frames_; }

  /// The plane on an edge halves the angle between its faces.
  [[nodiscard]] TangentBasis<Real> basis(const SurfacePoint<Real>& point) const {
    using Kind = typename SurfacePoint<Real>::Kind;
    if (point.kind == Kind::vertex) return frames_.basis(point.element[0]);
    const Index h = first_halfedge(point);
    Vec3<Real> normal = unit_normal(surface_.face_of(h));
    if (point.kind == Kind::edge && !surface_.is_border(h)) {
      normal += unit_normal(surface_.face_of(surface_.twin(h)));
    }
    const Vec3<Real> x = unit_way(surface_.origin(h), surface_.tip(h));
    // A side of no length is laid out at a right angle to the others.
    if (!(squared_norm(x) > 0)) return basis_across(unit_way(surface_.origin(h), surface_.apex(h)));
    Vec3<Real> y = stable_unit(cross(normal, x));
    if (!(squared_norm(y) > 0)) y = unit_orthogonal(x);
    return {x, y};
  }

  /// A direction from a point into a face that holds it, given as an angle from the face's first
  /// half-edge, as an angle in the point's tangent plane.
  [[nodiscard]] Real angle_at(const SurfacePoint<Real>& point, Index face, Real angle) const {
    using Kind = typename SurfacePoint<Real>::Kind;
    if (point.kind == Kind::face) return angle;
    if (point.kind == Kind::edge) {
      const Index h = first_halfedge(point);
      if (surface_.face_of(h) == face) return angle - side_angle(h);
      return angle - side_angle(surface_.twin(h)) + std::numbers::pi_v<Real>;
    }
    Index h = 3 * face;
    while (surface_.origin(h) != point.element[0]) ++h;
    const Real far = frames_.angle_back(surface_.previous(h));
    const Real corner = frames_.corner(h);
    const Real scale = corner > 0 ? (far - frames_.angle(h)) / corner : 1;
    const Real from_middle = angle - side_angle(h) - corner / 2;
    return (frames_.angle(h) + far) / 2 +
           scale * std::remainder(from_middle, 2 * std::numbers::pi_v<Real>);
  }

  /// The direction in which one point of a face sees another, in the first one's tangent plane, and
  /// by how much a vector turns, from basis to basis, that is carried there.
  struct Leg {
    Real direction, turn;
  };
  [[nodiscard]] Leg leg(const SurfacePoint<Real>& from, const SurfacePoint<Real>& to,
                        Index face) const {
    constexpr Real pi = std::numbers::pi_v<Real>;
    const Real angle = direction_in_face(surface_, face, from, to);
    const Real direction = angle_at(from, face, angle);
    // At the far end seen from there: both ways lie in the face.
    return {direction, angle_at(to, face, angle + pi) - pi - direction};
  }

  /// The half-edge from which angles on an edge or in a face are counted.
  [[nodiscard]] Index first_halfedge(const SurfacePoint<Real>& point) const {
    return point.kind == SurfacePoint<Real>::Kind::face
               ? 3 * point.element[0]
               : surface_.find_halfedge(point.element[0], point.element[1]);
  }

  /// The direction of a half-edge, as an angle from the first one of its face.
  [[nodiscard]] Real side_angle(Index h) const {
    const Index first = h - h % 3;
    if (h == first) return 0;
    const Real second = std::numbers::pi_v<Real> - frames_.corner(first + 1);
    return h == first + 1 ? second : second + std::numbers::pi_v<Real> - frames_.corner(first + 2);
  }

 private:
  [[nodiscard]] Vec3<Real> unit_normal(Index f) const {
    const auto [a, b, c] = surface_.face(f);
    const Vec3<Real> ab = surface_.position(b) - surface_.position(a);
    const Vec3<Real> ac = surface_.position(c) - surface_.position(a);
    return stable_unit(cross(stable_unit(ab), stable_unit(ac)));
  }

  [[nodiscard]] Vec3<Real> unit_way(Index from, Index to) const {
    return stable_unit(surface_.position(to) - surface_.position(from));
  }

  // Any plane through a direction, which is y; or any at all, where that is zero.
  [[nodiscard]] static TangentBasis<Real> basis_across(Vec3<Real> y) {
    if (!(squared_norm(y) > 0)) y = Vec3<Real>::UnitY();
    return {unit_orthogonal(y), y};
  }

  Surface<Real> surface_;
  TangentFrames<Real> frames_;
};

}  // namespace gelight::detail
