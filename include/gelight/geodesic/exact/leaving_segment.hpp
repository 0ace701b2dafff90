#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/past_vertex.hpp"
#include "gelight/geodesic/exact/path_directions.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// At which angle paths leave the segments of a solution. Those points of segments that are its
/// sources send lines in all directions, of which only the ones at no less than a right angle are
/// locally shortest.
template <std::floating_point Real>
class LeavingSegment {
 public:
  using Point = SurfacePoint<Real>;

  explicit LeavingSegment(const WindowSolution<Real>& solution) : solution_(solution) {}

  /// Whether a path, given from its source, is longer than one from farther along a segment on
  /// which that lies.
  [[nodiscard]] bool is_oblique(const Array<Point>& path) const {
    if (path.size() < 2) return false;
    const auto way = PathDirections<Real>(solution_).departure(path);
    const Real start = solution_.start_at(path[0]);
    for (const auto& front : solution_.fronts) {
      if (front.start > start || !solution_.lies_on(front, path[0])) continue;
      if (is_acute(path[0], face_point(front.face, front.begin), way)) return true;
      if (is_acute(path[0], face_point(front.face, front.end), way)) return true;
    }
    return false;
  }

 private:
  using Mesh = Surface<Real>;
  using PastVertex = detail::PastVertex<Real>;
  using Departure = typename PathDirections<Real>::Departure;
  // Points less than this apart, as a share of the faces there, are one.
  static constexpr Real same_place = 64 * std::numeric_limits<Real>::epsilon();
  // Right angles are known to this, in radians; lines less far apart count as one.
  static constexpr Real right_angle = 1e-6;

  // Whether a way leaves a point at less than a right angle to the line to another inside a face.
  [[nodiscard]] bool is_acute(const Point& p, const Point& to, const Departure& way) const {
    if (straight(surface_, p, to) <= same_place * longest_side_at(surface_, p)) return false;
    const Vec3<Real> line = unit_way(surface_, p, to);
    const Index face = Mesh::face_of(way.halfedge);
    if (p.kind == Point::Kind::face || face == to.element[0])
      return dot(line, way.direction) > right_angle;
    if (p.kind == Point::Kind::edge) return cosine_over(p, line, way.direction) > right_angle;
    const PastVertex past(surface_, *solution_.faces, p.element[0]);
    const typename PastVertex::Place there = past.place(to.element[0], to.weights),
                                     here{way.halfedge, {std::cos(way.angle), std::sin(way.angle)}};
    return past.angle({there}, here) < std::numbers::pi / 2 - right_angle;
  }

  // Of the angle between unit vectors in two faces at the edge of a point, laid flat.
  [[nodiscard]] Real cosine_over(const Point& p, const Vec3<Real>& a, const Vec3<Real>& b) const {
    const Vec3<Real> edge =
        unit_way(surface_, vertex_point<Real>(p.element[0]), vertex_point<Real>(p.element[1]));
    return dot(a, edge) * dot(b, edge) - norm(cross<Real>(a, edge)) * norm(cross<Real>(b, edge));
  }

  const WindowSolution<Real>& solution_;
  const Surface<Real>& surface_ = solution_.surface;
};

}  // namespace gelight::detail
