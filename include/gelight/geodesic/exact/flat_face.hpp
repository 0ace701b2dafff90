#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Twice the area of the triangle between two vectors of a plane, positive where b lies to the left
/// of a.
template <std::floating_point Real>
[[nodiscard]] Real cross_of(const Vec2<Real>& a, const Vec2<Real>& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The points p of a plane with normal . p >= offset.
template <std::floating_point Real>
struct HalfPlane {
  Vec2<Real> normal{0, 0};
  Real offset = 0;
  [[nodiscard]] Real height(const Vec2<Real>& p) const { return dot(normal, p) - offset; }
};

/// What lies beside the line from one place by another.
///@{
template <std::floating_point Real>
[[nodiscard]] HalfPlane<Real> left_of(const Vec2<Real>& from, const Vec2<Real>& by) {
  const Vec2<Real> way = stable_unit(by - from), normal(-way.y(), way.x());
  return {normal, dot(normal, by)};
}
template <std::floating_point Real>
[[nodiscard]] HalfPlane<Real> right_of(const Vec2<Real>& from, const Vec2<Real>& by) {
  const HalfPlane<Real> left = left_of(from, by);
  return {-left.normal, -left.offset};
}
///@}

/// One face laid flat: its first half-edge begins at (0, 0) and lies along x.
template <std::floating_point Real>
struct FlatFace {
  Index face = -1;
  std::array<Vec2<Real>, 3> corners, ways;  // the directions of the sides
  std::array<HalfPlane<Real>, 3> sides;     // what lies inside of each

  FlatFace() = default;
  FlatFace(const Surface<Real>& surface, const PlanarFaces<Real>& faces, Index f) : face(f) {
    corners = {Vec2<Real>(0, 0), Vec2<Real>(surface.length(3 * f), 0), faces.apex(3 * f)};
    for (std::size_t k = 0; k < 3; ++k) {
      ways[k] = stable_unit(corners[(k + 1) % 3] - corners[k]);
      sides[k] = left_of(corners[k], corners[(k + 1) % 3]);
    }
  }

  /// A place of half-edge h's frame.
  [[nodiscard]] Vec2<Real> from_frame(Index h, const Vec2<Real>& p) const {
    const auto k = static_cast<std::size_t>(h % 3);
    return corners[k] + p.x() * ways[k] + p.y() * sides[k].normal;
  }
  /// The place with these shares of the corners.
  [[nodiscard]] Vec2<Real> place(const std::array<Real, 3>& shares) const {
    return shares[0] * corners[0] + shares[1] * corners[1] + shares[2] * corners[2];
  }
  [[nodiscard]] bool contains(const Vec2<Real>& p) const {
    return std::all_of(sides.begin(), sides.end(),
                       [&](const HalfPlane<Real>& side) { return side.height(p) >= 0; });
  }
  [[nodiscard]] Vec3<Real> in_space(const Surface<Real>& surface, const Vec2<Real>& p) const {
    const Index h = 3 * face;
    const Vec3<Real>& o = surface.position(surface.origin(h));
    const Vec3<Real> x = stable_unit(surface.position(surface.tip(h)) - o);
    const Vec3<Real> to_apex = surface.position(surface.apex(h)) - o;
    const Vec3<Real> y = stable_unit(to_apex - dot(x, to_apex) * x);
    return o + p.x() * x + p.y() * y;
  }
};

}  // namespace gelight::detail
