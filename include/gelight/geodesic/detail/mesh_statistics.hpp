#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// What a mesh shows at a glance of how methods will fare on it: means over some thousand faces and
/// vertices, spread over all.
struct MeshStatistics {
  double mean_edge = 0;    ///< Mean length of the faces' sides.
  double aspect = 1;       ///< Mean over faces of longest edge over height on it, capped.
  double turn = 0;         ///< Root mean square angle between neighbouring faces, in radians.
  double bend = 0;         ///< Mean square root of the angle defect's size at inner vertices.
  bool is_flat = false;    ///< Neighbouring faces lie in one plane.
  bool is_convex = false;  ///< Angle defects at inner vertices are positive.

  explicit MeshStatistics(const Surface<double>& surface) {
    look_at_faces(surface);
    look_at_vertices(surface);
  }

 private:
  static constexpr Index samples = 2000;
  static constexpr double largest_aspect = 1e8;
  static constexpr double flat_angle = 1e-9;

  static Vec3<double> vector(const Surface<double>& surface, Index h) {
    return surface.position(surface.tip(h)) - surface.position(surface.origin(h));
  }
  static Vec3<double> normal(const Surface<double>& surface, Index f) {
    return cross(vector(surface, 3 * f), vector(surface, 3 * f + 1));
  }
  static double angle(const Vec3<double>& a, const Vec3<double>& b) {
    return std::atan2(cross(a, b).norm(), a.dot(b));
  }

  void look_at_faces(const Surface<double>& surface) {
    const Index stride = 1 + surface.face_count() / samples;
    double aspects = 0, lengths = 0, turns = 0;
    Index faces = 0, edges = 0;
    for (Index f = 0; f < surface.face_count(); f += stride, ++faces) {
      const Vec3<double> here = normal(surface, f);
      double longest = 0;
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        lengths += surface.length(h) / 3;
        longest = std::max(longest, surface.length(h));
        const Index t = surface.twin(h);
        if (surface.is_border(h) || !surface.is_manifold(h)) continue;
        // Faces that disagree in orientation turn as if they agreed.
        const double sign = surface.origin(t) == surface.origin(h) ? -1 : 1;
        const double turned = angle(here, sign * normal(surface, Surface<double>::face_of(t)));
        turns += turned * turned;
        ++edges;
      }
      aspects += std::min(largest_aspect, longest * longest / here.norm());
    }
    mean_edge = lengths / faces;
    aspect = aspects / faces;
    turn = std::sqrt(turns / std::max(Index{1}, edges));
    is_flat = turn < flat_angle;
  }

  void look_at_vertices(const Surface<double>& surface) {
    const Index stride = 1 + surface.vertex_count() / samples;
    double sum = 0;
    Index count = 0, convex = 0;
    for (Index v = 0; v < surface.vertex_count(); v += stride) {
      double defect = 2 * std::numbers::pi;
      bool is_inner = !surface.corners(v).empty();
      for (const Index h : surface.corners(v)) {
        const Index back = Surface<double>::previous(h);
        defect -= angle(vector(surface, h), -vector(surface, back));
        for (const Index side : {h, back}) {
          is_inner = is_inner && surface.is_manifold(side) && !surface.is_border(side);
        }
      }
      if (!is_inner) continue;
      sum += std::sqrt(std::abs(defect));
      convex += defect > flat_angle;
      ++count;
    }
    bend = sum / std::max(Index{1}, count);
    is_convex = count > 0 && convex == count;
  }
};

}  // namespace gelight::detail
