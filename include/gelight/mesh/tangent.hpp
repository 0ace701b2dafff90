#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <concepts>
#include <numbers>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// Two unit vectors at right angles in a tangent plane; x cross y is the surface's normal.
template <std::floating_point Real>
struct TangentBasis {
  Vec3<Real> x;  ///< unit
  Vec3<Real> y;  ///< unit, a quarter turn from x towards the left

  /// The unit normal of the plane.
  [[nodiscard]] Vec3<Real> normal() const { return cross(x, y); }
  /// The vector in space of coordinates in the plane, written as a complex number.
  [[nodiscard]] Vec3<Real> embed(std::complex<Real> z) const {
    using namespace detail::arithmetic;
    return z.real() * x + z.imag() * y;
  }
  /// Coordinates of a vector's part in the plane, written as a complex number.
  [[nodiscard]] std::complex<Real> project(const Vec3<Real>& v) const {
    return {dot(v, x), dot(v, y)};
  }
};

/// Throws InvalidInput unless every edge has at most two faces, and those run it in opposite ways:
/// without that, a tangent vector has no left and right.
template <std::floating_point Real>
void require_oriented(const Surface<Real>& surface) {
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    const Index t = surface.twin(h);
    if (t == h) continue;
    detail::require(surface.twin(t) == h, "the edge between vertices ", surface.origin(h), " and ",
                    surface.tip(h), " has more than two faces; vectors need an oriented manifold");
    detail::require(surface.origin(t) != surface.origin(h), "faces ", surface.face_of(h), " and ",
                    surface.face_of(t), " are oriented against each other along vertices ",
                    surface.origin(h), " and ", surface.tip(h),
                    "; vectors need an orientation, the same for all faces that meet");
  }
}

/// A tangent plane at each vertex, in which directions are angles: those of the edges around an
/// inner vertex are scaled to sum to 2 pi, those at a border are as they are, so that a flat sheet
/// stays flat (Knoeppel, Crane, Pinkall, Schroeder 2013, doi:10.1145/2461912.2462005).
///
/// The plane is that of the mean normal, weighted by the faces' angles, and its x that of the first
/// edge that has a length, whatever the triangulation whose angles are scaled. Where no face has an
/// area, or normals cancel, it is one through that edge; where no edge has a length, any. Where
/// the edge is at a right angle to the plane, x is any in that. The angles are turned to fit the
/// edges' own directions best. Each fan of a bow-tie vertex is turned by itself.
template <std::floating_point Real>
class TangentFrames {
 public:
  /// Throws InvalidInput as require_oriented does. Linear in the faces.
  explicit TangentFrames(const Surface<Real>& surface, const CancelHook& cancelled = {})
      : TangentFrames(surface, intrinsic_triangulation(surface), cancelled) {}

  /// With the angles of other edge lengths, the half-edges being the same.
  TangentFrames(const Surface<Real>& surface, const IntrinsicTriangulation<Real>& mesh,
                const CancelHook& cancelled = {})
      : surface_(surface) {
    require_oriented(surface);
    measure_corners(mesh, cancelled.part(0, 0.5));
    const auto halfedges = static_cast<std::size_t>(surface.halfedge_count());
    bases_.resize(static_cast<std::size_t>(surface.vertex_count()));
    angles_.resize(halfedges);
    far_angles_.resize(halfedges);
    const CancelHook later = cancelled.part(0.5, 1);
    detail::PeriodicCheck progress(later, surface.vertex_count(), "the set-up of tangent planes");
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      place(v);
      progress.step();
    }
  }

  /// The plane at a vertex.
  [[nodiscard]] const TangentBasis<Real>& basis(Index vertex) const { return bases_[vertex]; }

  /// Direction of half-edge h in the tangent plane of its origin, and that of the way back in the
  /// plane of its tip: angles from the basis' x, in radians.
  ///@{
  [[nodiscard]] Real angle(Index h) const { return angles_[h]; }
  [[nodiscard]] Real angle_back(Index h) const { return far_angles_[surface_.next(h)]; }
  ///@}

  /// Angle between h and the edge before it in their face.
  [[nodiscard]] Real corner(Index h) const { return corners_[h]; }

  /// What turns a vector at h's origin into the parallel one at its tip.
  [[nodiscard]] std::complex<Real> transport(Index h) const {
    return std::polar(Real(1), angle_back(h) + std::numbers::pi_v<Real> - angle(h));
  }

 private:
  void measure_corners(const IntrinsicTriangulation<Real>& mesh, const CancelHook& cancelled) {
    const auto faces = planar_faces(mesh);
    detail::PeriodicCheck progress(cancelled, surface_.face_count(),
                                   "the set-up of tangent planes");
    corners_.resize(static_cast<std::size_t>(surface_.halfedge_count()));
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto& [x1, x2, y2] = faces[f];
      corners_[3 * f] = std::atan2(y2, x2);
      corners_[3 * f + 1] = std::atan2(y2, x1 - x2);
      corners_[3 * f + 2] = std::atan2(x1 * y2, y2 * y2 - x2 * (x1 - x2));
      progress.step();
    }
  }

  void place(Index v) {
    choose_basis(v);
    for (const Index h : surface_.corners(v)) far_angles_[h] = unvisited;
    for (const Index h : surface_.corners(v)) {
      if (surface_.is_border(h)) walk_fan(v, h, 1);
    }
    for (const Index h : surface_.corners(v)) {
      if (far_angles_[h] != unvisited) continue;
      Real total = 0;
      Index g = h;
      do {
        total += corners_[g];
        g = surface_.twin(surface_.previous(g));
      } while (g != h);
      walk_fan(v, h, 2 * std::numbers::pi_v<Real> / total);
    }
  }

  // Sums the corners from half-edge `first` on, counter-clockwise, then turns them all together.
  void walk_fan(Index v, Index first, Real scale) {
    Real sum = 0;
    std::complex<Real> turn = 0;
    for (Index h = first; h >= 0; h = next_in_fan(h, first)) {
      angles_[h] = sum;
      turn += projected(v, surface_.tip(h)) * std::polar(Real(1), -sum);
      sum += scale * corners_[h];
      far_angles_[h] = sum;
      const Index before = surface_.previous(h);
      if (!surface_.is_border(before)) continue;
      turn += projected(v, surface_.origin(before)) * std::polar(Real(1), -sum);
    }
    const Real offset = turn == std::complex<Real>(0) ? 0 : std::arg(turn);
    for (Index h = first; h >= 0; h = next_in_fan(h, first)) {
      angles_[h] += offset;
      far_angles_[h] += offset;
    }
  }

  // The half-edge after h around its origin, -1 where the fan ends or comes round to its first.
  [[nodiscard]] Index next_in_fan(Index h, Index first) const {
    const Index before = surface_.previous(h);
    if (surface_.is_border(before)) return -1;
    const Index following = surface_.twin(before);
    return following == first ? -1 : following;
  }

  [[nodiscard]] std::complex<Real> projected(Index from, Index to) const {
    using namespace detail::arithmetic;
    return bases_[from].project(surface_.position(to) - surface_.position(from));
  }

  void choose_basis(Index v) {
    using namespace detail::arithmetic;
    Vec3<Real> normal = Vec3<Real>(0, 0, 0), along = Vec3<Real>(0, 0, 0);
    const auto unit_way = [&](Index to) {
      return detail::stable_unit(surface_.position(to) - surface_.position(v));
    };
    for (const Index h : surface_.corners(v)) {
      const Vec3<Real> a = unit_way(surface_.tip(h)), b = unit_way(surface_.apex(h));
      const Vec3<Real> across = cross(a, b);
      const Real sine = norm(across), cosine = dot(a, b);
      const Real counted = cosine < 0 ? std::max(sine, least_sine) : sine;
      if (counted > 0) normal += std::atan2(sine, cosine) / counted * across;
      if (along.isZero(0)) along = a.isZero(0) ? b : a;
    }
    if (along.isZero(0)) along = Vec3<Real>::UnitX();
    if (!(norm(normal) > no_normal)) normal = detail::unit_orthogonal(along);
    normal = detail::stable_unit(normal);
    // Of an edge at a right angle to the plane, as of a face without area, rounding is left.
    const Vec3<Real> flat = along - dot(normal, along) * normal;
    const bool lies_in = norm(flat) > no_normal;
    const Vec3<Real> x = lies_in ? detail::stable_unit(flat) : detail::unit_orthogonal(normal);
    bases_[v] = {x, cross(normal, x)};
  }

  static constexpr Real unvisited = -1e300;
  // A corner of nearly half a turn tells less of its face's plane the smaller its sine is: it
  // counts less below this. What is then left of faces without area is rounding, as where normals
  // cancel.
  static constexpr Real least_sine = 1e-4, no_normal = 1e-8;

  Surface<Real> surface_;
  detail::Array<TangentBasis<Real>> bases_;  // of each vertex
  detail::Array<Real> corners_;              // of each half-edge: the angle at its origin
  detail::Array<Real> angles_;               // of each half-edge, at its origin
  detail::Array<Real> far_angles_;  // of the edge before each half-edge, at the same vertex
};

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class TangentFrames<double>;
}  // namespace gelight
#endif
