#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/transport/vector_heat.hpp"

namespace gelight {
namespace detail {

/// Directions between vertices: the mean of the face's three by barycentric coordinates, laid into
/// the face. Zero where they cancel.
template <std::floating_point T>
[[nodiscard]] LightField<T> interpolate(const Surface<double>& surface,
                                        const std::vector<Vec3<T>>& at_vertices,
                                        std::span<const SurfacePoint<T>> points) {
  using Kind = typename SurfacePoint<T>::Kind;
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) {
    surface.require_point(point);
    const auto at = [&](Index v) { return at_vertices[static_cast<std::size_t>(v)]; };
    const auto [a, b] = point.element;
    const auto& w = point.weights;
    Vec3<T> mean = Vec3<T>::Zero();
    if (point.kind == Kind::vertex) mean = at(a);
    if (point.kind == Kind::edge) mean = w[0] * at(a) + w[1] * at(b);
    if (point.kind == Kind::face) {
      const auto v = surface.face(a);
      mean = w[0] * at(v[0]) + w[1] * at(v[1]) + w[2] * at(v[2]);
      const Vec3<T> normal = direction_of(face_normal(surface, a)).template cast<T>();
      mean -= mean.dot(normal) * normal;
    }
    field.push_back(direction_of(mean));
  }
  return field;
}

}  // namespace detail

/// Light that keeps its direction as far as the surface lets it: the direction of emission at the
/// LED, carried over the surface by parallel transport along shortest paths, by the vector heat
/// method (Sharp, Soliman, Crane 2019, doi:10.1145/3243651).
///
/// `emission` is laid into the tangent plane of the LED's vertex. Zero where no path leads. Throws
/// InvalidInput as VectorHeatSolver::transport does. Cost: one solve, and O(1) a point.
template <std::floating_point T>
[[nodiscard]] LightField<T> transport_field(const VectorHeatSolver<T>& solver, Index led,
                                            const Vec3<T>& emission,
                                            std::span<const SurfacePoint<T>> points) {
  return detail::interpolate(solver.surface(), solver.transport(led, emission), points);
}

/// Light that leaves the LED in all directions of its tangent plane, each carried along: the radial
/// direction of the LED's log map. Otherwise as `transport_field`.
template <std::floating_point T>
[[nodiscard]] LightField<T> radial_transport_field(const VectorHeatSolver<T>& solver, Index led,
                                                   std::span<const SurfacePoint<T>> points) {
  return detail::interpolate(solver.surface(), solver.radial(led), points);
}

}  // namespace gelight
