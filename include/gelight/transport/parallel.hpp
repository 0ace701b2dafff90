#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <concepts>
#include <cstddef>
#include <numbers>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/transport/tangent_planes.hpp"

namespace gelight {

/// Carries tangent vectors along paths, parallel to themselves: exact on the polyhedron, where that
/// means unfolding each edge that the path crosses.
///
/// At a point of an edge or a face the tangent plane is that of the (mean) face normal; at a vertex
/// it is that of `TangentFrames`, in which the angles round the vertex are scaled to sum to 2 pi. A
/// path through a vertex so shares the vertex' angle defect between its two sides.
template <std::floating_point T>
class ParallelTransport {
 public:
  /// Throws InvalidInput as Surface does, for faces that are not oriented alike (a Moebius strip
  /// cannot be) and for edges of more than two faces. Cost: O(faces).
  template <TriangleMesh M>
  explicit ParallelTransport(const M& mesh) : planes_(Surface<double>(mesh)) {}

  /// The surface that the vectors are carried over.
  [[nodiscard]] const Surface<double>& surface() const { return planes_.surface(); }

  /// Two unit vectors, x and y, that span the tangent plane at a point; x cross y is the normal.
  /// Throws InvalidInput for a point that is not of the surface, or at a vertex without faces.
  [[nodiscard]] std::array<Vec3<T>, 2> tangent_basis(const SurfacePoint<T>& point) const {
    const TangentBasis<double> basis = planes_.basis(checked(point));
    return {cast<T>(basis.x), cast<T>(basis.y)};
  }

  /// The vector at the end of a path that is parallel to a vector at its start, of which the part
  /// in the tangent plane counts. The path may run along a border. Throws InvalidInput for a path
  /// without points, with a point that is not of the surface, or with two points in a row that no
  /// face holds; and for a vector that is not finite, or whose part there is longer than T's
  /// largest number. Cost: O(1) a piece, O(valence) at vertices.
  [[nodiscard]] Vec3<T> along(const Path<T>& path, const Vec3<T>& vector) const {
    detail::require(detail::is_finite(vector), "the vector (", vector[0], ", ", vector[1], ", ",
                    vector[2], ") is not finite");
    const std::complex<double> turn = std::polar(1.0, turn_along(path));
    const auto start = planes_.basis(checked(path.front())).project(cast<double>(vector));
    const double length = std::abs(start);
    detail::require(length <= detail::largest_number<T>, "the vector (", vector[0], ", ", vector[1],
                    ", ", vector[2], ") is ", length, " long, longer than one of its parts can be");
    return cast<T>(planes_.basis(checked(path.back())).embed(turn * start));
  }

  /// The angle from a vector to itself carried once round a closed path, in radians, from -pi to
  /// pi: the sum of the angle defects that lie to the left of the path. Throws InvalidInput as
  /// `along` does, and for a path that does not end where it starts.
  [[nodiscard]] T holonomy(const Path<T>& path) const {
    const double turn = turn_along(path);
    detail::require(checked(path.front()) == checked(path.back()), "the path of ", path.size(),
                    " points does not end where it starts");
    return static_cast<T>(std::remainder(turn, 2 * std::numbers::pi));
  }

 private:
  using Point = SurfacePoint<double>;

  [[nodiscard]] Point checked(const SurfacePoint<T>& point) const {
    surface().require_point(point);
    const Point p = detail::simplified(surface(), point.template cast<double>());
    if (p.kind == Point::Kind::vertex) {
      detail::require(!surface().corners(p.element[0]).empty(), "vertex ", p.element[0],
                      " is in no face, it has no tangent plane");
    }
    return p;
  }

  // From the basis at the start to the basis at the end, between which the vector stays parallel.
  [[nodiscard]] double turn_along(const Path<T>& path) const {
    detail::require(!path.empty(), "the path has no points");
    double turn = 0;
    Point from = checked(path[0]);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Point to = checked(path[i]);
      if (to == from) continue;
      const Index face = detail::shared_face(surface(), from, to);
      detail::require(face >= 0, "no face holds both points ", i - 1, " and ", i, " of the path");
      turn += planes_.leg(from, to, face).turn;
      from = to;
    }
    return turn;
  }

  detail::TangentPlanes<double> planes_;
};

template <TriangleMesh M>
explicit ParallelTransport(const M&) -> ParallelTransport<MeshScalar<M>>;

}  // namespace gelight
