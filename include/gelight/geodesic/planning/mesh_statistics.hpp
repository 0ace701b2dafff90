#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// What a mesh shows at a glance of how methods will fare on it: means over some hundred faces and
/// vertices, spread over all, and how far its border bends inwards.
template <std::floating_point Real>
struct MeshStatistics {
  Index vertices = 0;    ///< How many there are.
  double mean_edge = 0;  ///< Mean length of the faces' sides.
  double aspect = 1;     ///< Mean over faces of longest edge over height on it, capped.
  double obtuse = 0;     ///< Mean over faces of minus the cosine of an obtuse angle, if any.
  double turn = 0;       ///< Root mean square angle between neighbouring faces, in radians.
  double bend = 0;       ///< Root of the mean size of the angle defect at inner vertices.
  /// Sum of the angle defects' sizes at inner vertices, times the mean edge over the area's root.
  double curvature = 0;
  bool is_flat = false;    ///< Neighbouring faces lie in one plane.
  bool is_convex = false;  ///< Angle defects at inner vertices are positive.
  double corner = 0;  ///< Most by which the border bends inwards, where paths bend; at most pi/2.

  explicit MeshStatistics(const Surface<Real>& surface) : vertices(surface.vertex_count()) {
    look_at_faces(surface);
    look_at_vertices(surface);
    look_at_border(surface);
  }

 private:
  static constexpr Index samples = 300;
  static constexpr double largest_aspect = 1e8;
  static constexpr double flat_angle = 1e-9;
  static constexpr double sharpest = std::numbers::pi / 2;
  static constexpr double smallest_unit = std::numeric_limits<double>::min();

  // Of a half-edge, of unit length, so that no scale overflows; zero where it has no length.
  static Vec3<Real> direction(const Surface<Real>& surface, Index h) {
    const Vec3<Real>&from = surface.position(surface.origin(h)),
          &to = surface.position(surface.tip(h));
    const Vec3<Real> way(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
    return surface.length(h) > 0 ? Vec3<Real>(way / surface.length(h)) : Vec3<Real>(0, 0, 0);
  }
  static Vec3<Real> normal(const Surface<Real>& surface, Index f) {
    return cross(direction(surface, 3 * f), direction(surface, 3 * f + 1));
  }
  static double angle(const Vec3<Real>& a, const Vec3<Real>& b) {
    return std::atan2(norm(cross(a, b)), dot(a, b));
  }
  // Both ways out of a half-edge's origin in its face.
  static std::array<Vec3<Real>, 2> ways_out(const Surface<Real>& surface, Index h) {
    return {direction(surface, h), -direction(surface, Surface<Real>::previous(h))};
  }

  static Index longest_side(const Surface<Real>& surface, Index f) {
    Index h = 3 * f;
    for (Index g = 3 * f + 1; g < 3 * f + 3; ++g) {
      if (surface.length(g) > surface.length(h)) h = g;
    }
    return h;
  }

  void look_at_faces(const Surface<Real>& surface) {
    const Index stride = 1 + surface.face_count() / samples;
    double aspects = 0, lengths = 0, turns = 0, cosines = 0, areas = 0;
    Index faces = 0, edges = 0;
    // Areas in a unit with which they neither overflow nor vanish.
    const double unit = std::max(surface.length(longest_side(surface, 0)), smallest_unit);
    for (Index f = 0; f < surface.face_count(); f += stride, ++faces) {
      for (Index h = 3 * f; h < 3 * f + 3; ++h) lengths += surface.length(h) / 3;
      const Index longest = longest_side(surface, f);
      const auto [a, b] = ways_out(surface, longest);
      const double side = surface.length(longest);
      const double height = surface.length(Surface<Real>::previous(longest)) * norm(cross(a, b));
      aspects += height > 0 ? std::min(largest_aspect, side / height) : largest_aspect;
      areas += side / unit * (height / unit) / 2;
      const auto [c, d] = ways_out(surface, Surface<Real>::previous(longest));
      cosines += std::min(0.0, dot(c, d));
      // One side of each, in turn.
      const Index h = 3 * f + faces % 3, t = surface.twin(h);
      if (surface.is_border(h) || !surface.is_manifold(h)) continue;
      // Faces that disagree in orientation turn as if they agreed.
      const double sign = surface.origin(t) == surface.origin(h) ? -1 : 1;
      const double turned =
          angle(normal(surface, f), sign * normal(surface, Surface<Real>::face_of(t)));
      turns += turned * turned;
      ++edges;
    }
    mean_edge = lengths / faces;
    aspect = aspects / faces;
    obtuse = -cosines / faces;
    size_ = unit * std::sqrt(areas / faces * surface.face_count());
    turn = std::sqrt(turns / std::max(Index{1}, edges));
    is_flat = turn < flat_angle;
  }

  void look_at_vertices(const Surface<Real>& surface) {
    const Index stride = 1 + surface.vertex_count() / samples;
    double defects = 0;
    Index seen = 0, count = 0, convex = 0;
    for (Index v = 0; v < surface.vertex_count(); v += stride) {
      ++seen;
      if (surface.corners(v).empty() || is_at_border(surface, v)) continue;
      const double defect = 2 * std::numbers::pi - angle_sum(surface, v);
      defects += std::abs(defect);
      convex += defect > flat_angle;
      ++count;
    }
    bend = std::sqrt(defects / std::max(Index{1}, count));
    const double total = defects / std::max(Index{1}, seen) * surface.vertex_count();
    curvature = size_ > 0 ? total * (mean_edge / size_) : 0;
    is_convex = count > 0 && convex == count;
  }

  void look_at_border(const Surface<Real>& surface) {
    for (Index h = 0; h < surface.halfedge_count() && corner < sharpest; ++h) {
      if (!surface.is_border(h)) continue;
      const double inwards = angle_sum(surface, surface.origin(h)) - std::numbers::pi;
      corner = std::clamp(inwards, corner, sharpest);
    }
  }

  static double angle_sum(const Surface<Real>& surface, Index v) {
    double sum = 0;
    for (const Index h : surface.corners(v)) {
      const auto [a, b] = ways_out(surface, h);
      sum += angle(a, b);
    }
    return sum;
  }

  static bool is_at_border(const Surface<Real>& surface, Index v) {
    for (const Index h : surface.corners(v)) {
      for (const Index side : {h, Surface<Real>::previous(h)}) {
        if (!surface.is_manifold(side) || surface.is_border(side)) return true;
      }
    }
    return false;
  }

  double size_ = 0;  // the area's root
};

}  // namespace gelight::detail
