#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// What a mesh shows at a glance of how methods will fare on it.
struct MeshStatistics {
  double mean_edge = 0;   ///< Mean length of the half-edges.
  double turn = 0;        ///< Root mean square angle between neighbouring faces, in radians.
  double aspect = 1;      ///< Mean over the faces of longest edge over height on it, capped.
  bool is_flat = false;   ///< All faces lie in one plane, or in planes of parts.
  bool is_convex = true;  ///< All inner vertices have a positive angle defect.

  explicit MeshStatistics(const Surface<double>& surface) {
    const Index faces = surface.face_count();
    Array<Vec3<double>> normals;
    normals.reserve(static_cast<std::size_t>(faces));
    double sum = 0;
    for (Index h = 0; h < 3 * faces; h += 3) {
      const Vec3<double> a = vector(surface, h), b = vector(surface, h + 1);
      const Vec3<double> normal = a.cross(b);
      const double longest =
          std::max({surface.length(h), surface.length(h + 1), surface.length(h + 2)});
      sum += std::min(largest_aspect, longest * longest / normal.norm());
      normals.push_back(normal.stableNormalized());
      mean_edge +=
          (surface.length(h) + surface.length(h + 1) + surface.length(h + 2)) / (3 * faces);
    }
    aspect = sum / faces;
    measure_turn(surface, normals);
    measure_defects(surface);
  }

 private:
  static constexpr double largest_aspect = 1e8;
  static constexpr double flat_angle = 1e-9;

  static Vec3<double> vector(const Surface<double>& surface, Index h) {
    return surface.position(surface.tip(h)) - surface.position(surface.origin(h));
  }

  // Faces that disagree in orientation turn as if they agreed.
  void measure_turn(const Surface<double>& surface, const Array<Vec3<double>>& normals) {
    double sum = 0;
    Index count = 0;
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      const Index t = surface.twin(h);
      if (t <= h || !surface.is_manifold(h)) continue;
      const Vec3<double>& a = normals[Surface<double>::face_of(h)];
      const double sign = surface.origin(t) == surface.origin(h) ? -1 : 1;
      const Vec3<double> b = sign * normals[Surface<double>::face_of(t)];
      const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
      sum += angle * angle;
      ++count;
    }
    turn = std::sqrt(sum / std::max(Index{1}, count));
    is_flat = turn < flat_angle;
  }

  void measure_defects(const Surface<double>& surface) {
    const auto count = static_cast<std::size_t>(surface.vertex_count());
    Array<double> defect(count, 2 * std::numbers::pi);
    Array<char> is_inner(count, 1);
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      const Vec3<double> a = vector(surface, h), b = -vector(surface, Surface<double>::previous(h));
      defect[surface.origin(h)] -= std::atan2(a.cross(b).norm(), a.dot(b));
      if (surface.is_manifold(h) && !surface.is_border(h)) continue;
      is_inner[surface.origin(h)] = is_inner[surface.tip(h)] = 0;
    }
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      if (!is_inner[v] || surface.corners(v).empty()) continue;
      if (defect[v] < flat_angle) is_convex = false;
    }
  }
};

}  // namespace gelight::detail
