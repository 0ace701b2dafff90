#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/smooth/fans.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// The smooth surface over a mesh, as its vertices and normals tell: a cubic curve over each edge,
/// a normal at each of its points, and the curvature of each face (after A. Vlachos, J. Peters,
/// C. Boyd, J. L. Mitchell, "Curved PN triangles", 2001, doi:10.1145/364338.364387).
template <std::floating_point Real>
class CurvedFaces {
 public:
  using Mesh = Surface<Real>;

  /// From a unit normal of each fan; a zero one makes all edges there straight.
  CurvedFaces(const Fans<Real>& fans, const Array<Vec3<Real>>& normals)
      : fans_(fans), normals_(normals) {
    find_curves();
    find_curvatures();
  }

  [[nodiscard]] const Mesh& surface() const { return fans_.surface(); }
  [[nodiscard]] const Fans<Real>& fans() const { return fans_; }

  /// Unit normal at the origin of a half-edge, as its face has it.
  [[nodiscard]] const Vec3<Real>& normal(Index h) const { return normals_[fans_.at(h)]; }
  /// Unit normal of a fan.
  [[nodiscard]] const Vec3<Real>& fan_normal(Index fan) const { return normals_[fan]; }
  /// Gaussian curvature of a face, as its corners' normals turn.
  [[nodiscard]] Real curvature(Index f) const { return curvatures_[f]; }

  /// Mean square by which normals turn along an edge, in radians.
  [[nodiscard]] Real mean_turn() const { return mean_turn_; }

  /// The cubic over an edge by its ends and its derivatives there; and the fans of its ends, where
  /// they are the same on both sides: -1 at a crease. All of it is one line of a cache.
  struct alignas(64) Curve {
    Vec3<Real> leaving, arriving;
    Index from, to, from_fan, to_fan;
  };
  [[nodiscard]] const Curve& curve(Index h) const { return curves_[curve_of_[h]]; }

  /// A point of an edge's curve, and the derivative by the share of the way.
  struct CurvePoint {
    Vec3<Real> place, derivative;
  };

  /// At a share of the way along half-edge h, from its origin. Places are as seen from `from`: of
  /// differences between vertices near it nothing is lost where the mesh is far from the origin.
  [[nodiscard]] CurvePoint on_edge(Index h, Real t, const Vec3<Real>& from) const {
    const Curve& curve = curves_[curve_of_[h]];
    const Mesh& surface = fans_.surface();
    const bool is_along = surface.origin(h) == curve.from;
    const Real s = is_along ? t : 1 - t, r = 1 - s;
    const Vec3<Real> begin = surface.position(curve.from) - from;
    const Vec3<Real> way = surface.position(curve.to) - surface.position(curve.from);
    const Vec3<Real> derivative =
        6 * s * r * way + r * (r - 2 * s) * curve.leaving + s * (s - 2 * r) * curve.arriving;
    return {begin + s * s * (3 - 2 * s) * way + s * r * (r * curve.leaving - s * curve.arriving),
            is_along ? derivative : Vec3<Real>(-derivative)};
  }

  /// The normal of h's face at a point of h.
  [[nodiscard]] Vec3<Real> normal_on_edge(Index h, Real t, const Vec3<Real>& derivative) const {
    const Vec3<Real> mean = (1 - t) * normal(h) + t * normal(Mesh::next(h));
    const Real square = squared_norm(derivative);
    if (!(square > 0)) return stable_unit(mean);
    return stable_unit(Vec3<Real>(mean - dot(mean, derivative) / square * derivative));
  }

  /// A point over a face, as seen from `from`: the cubic triangle with these curves for sides.
  [[nodiscard]] Vec3<Real> in_face(Index f, const std::array<Real, 3>& w,
                                   const Vec3<Real>& from) const {
    const Mesh& surface = fans_.surface();
    Vec3<Real> place(0, 0, 0), sides(0, 0, 0), corners(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index h = 3 * f + static_cast<Index>(k);
      const Real a = w[k], b = w[(k + 1) % 3];
      const Vec3<Real> p = surface.position(surface.origin(h)) - from,
                       q = surface.position(surface.tip(h)) - from;
      const Curve& curve = curves_[curve_of_[h]];
      const bool is_along = surface.origin(h) == curve.from;
      const Vec3<Real> near_p =
          is_along ? Vec3<Real>(p + curve.leaving / 3) : Vec3<Real>(p - curve.arriving / 3);
      const Vec3<Real> near_q =
          is_along ? Vec3<Real>(q - curve.arriving / 3) : Vec3<Real>(q + curve.leaving / 3);
      place += a * a * a * p + 3 * a * b * (a * near_p + b * near_q);
      sides += (near_p + near_q) / 6;
      corners += p / 3;
    }
    return place + 6 * w[0] * w[1] * w[2] * (sides + (sides - corners) / 2);
  }
  [[nodiscard]] Vec3<Real> normal_in_face(Index f, const std::array<Real, 3>& w) const {
    return stable_unit(
        Vec3<Real>(w[0] * normal(3 * f) + w[1] * normal(3 * f + 1) + w[2] * normal(3 * f + 2)));
  }

 private:
  void find_curves() {
    const Mesh& surface = fans_.surface();
    curve_of_.assign(static_cast<std::size_t>(surface.halfedge_count()), -1);
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      if (curve_of_[h] >= 0) continue;
      const Vec3<Real> way = surface.position(surface.tip(h)) - surface.position(surface.origin(h));
      Index g = h;
      do {
        curve_of_[g] = static_cast<Index>(curves_.size());
        g = surface.twin(g);
      } while (g != h);
      const bool is_sharp = fans_.is_sharp(h);
      curves_.push_back({tangent(h, way, surface.origin(h)), tangent(h, way, surface.tip(h)),
                         surface.origin(h), surface.tip(h), is_sharp ? -1 : fans_.at(h),
                         is_sharp ? -1 : fans_.at(Mesh::next(h))});
    }
  }

  // The derivative of an edge's curve at one of its ends: along the tangent plane, or along the
  // line in which the planes of both sides of a crease meet. It is as long as makes the curve's
  // middle that of a circle.
  [[nodiscard]] Vec3<Real> tangent(Index h, const Vec3<Real>& way, Index end) const {
    const Mesh& surface = fans_.surface();
    const Index t = surface.twin(h);
    const Vec3<Real> m = normal_at(h, end);
    const Vec3<Real> other = t != h && surface.twin(t) == h ? normal_at(t, end) : m;
    if (t != h && surface.twin(t) != h) return way;
    const Vec3<Real> ridge = cross(m, other);
    constexpr Real least_ridge = 0.05;
    const bool is_ridge = fans_.is_sharp(h) && norm(ridge) > least_ridge;
    const Vec3<Real> along = is_ridge ? Vec3<Real>(ridge * (dot(ridge, way) / squared_norm(ridge)))
                                      : Vec3<Real>(way - dot(way, m) * m);
    const Real length = stable_norm(way), projected = stable_norm(along);
    // A plane across the edge tells nothing of it.
    if (!(2 * projected > length)) return way;
    return along * (2 * length / (projected * (1 + projected / length)));
  }
  [[nodiscard]] const Vec3<Real>& normal_at(Index h, Index end) const {
    return normal(fans_.surface().origin(h) == end ? h : Mesh::next(h));
  }

  void find_curvatures() {
    const Mesh& surface = fans_.surface();
    curvatures_.reserve(static_cast<std::size_t>(surface.face_count()));
    for (Index h = 0; h < surface.halfedge_count(); h += 3) {
      const Vec3<Real> a = surface.position(surface.tip(h)) - surface.position(surface.origin(h));
      const Vec3<Real> b = surface.position(surface.apex(h)) - surface.position(surface.origin(h));
      const Vec3<Real> area = cross(a, b);
      const Vec3<Real> turn = cross<Real>(normal(h + 1) - normal(h), normal(h + 2) - normal(h));
      const Real square = squared_norm(area);
      curvatures_.push_back(square > 0 ? dot(area, turn) / square : 0);
      for (Index g = h; g < h + 3; ++g) {
        mean_turn_ += squared_norm(normal(Mesh::next(g)) - normal(g)) / surface.halfedge_count();
      }
    }
  }

  Fans<Real> fans_;
  Array<Vec3<Real>> normals_;  // of each fan
  Array<Index> curve_of_;      // of each half-edge
  Array<Curve> curves_;
  Array<Real> curvatures_;  // of each face
  Real mean_turn_ = 0;
};

}  // namespace gelight::detail
