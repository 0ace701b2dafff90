#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/transport/vector_heat.hpp"

namespace gelight {
namespace detail {

/// What points have of values at the vertices: the mean by barycentric coordinates.
template <std::floating_point T, class Value>
[[nodiscard]] Value mean_at(const Surface<double>& surface, std::span<const Value> at_vertices,
                            const SurfacePoint<T>& point) {
  using Kind = typename SurfacePoint<T>::Kind;
  const auto at = [&](Index v) { return at_vertices[static_cast<std::size_t>(v)]; };
  const auto [a, b] = point.element;
  const auto& w = point.weights;
  if (point.kind == Kind::vertex) return at(a);
  if (point.kind == Kind::edge) return w[0] * at(a) + w[1] * at(b);
  const auto v = surface.face(a);
  return w[0] * at(v[0]) + w[1] * at(v[1]) + w[2] * at(v[2]);
}

/// Directions between vertices: their mean, laid into the face, not of unit length.
template <std::floating_point T>
[[nodiscard]] LightField<T> means(const Surface<double>& surface,
                                  const std::vector<Vec3<T>>& at_vertices,
                                  std::span<const SurfacePoint<T>> points,
                                  const CancelHook& cancelled) {
  LightField<T> field;
  field.reserve(points.size());
  Index face = -1;  // of the last point inside one: pixels in a row often share it
  Vec3<T> normal = Vec3<T>(0, 0, 0);
  for (const auto& point : points) {
    surface.require_point(point);
    Vec3<T> mean = mean_at(surface, std::span<const Vec3<T>>(at_vertices), point);
    if (point.kind == SurfacePoint<T>::Kind::face) {
      if (point.element[0] != face) {
        face = point.element[0];
        normal = cast<T>(direction_of(face_normal(surface, face)));
      }
      mean -= dot(mean, normal) * normal;
    }
    field.push_back(mean);
    check_points(cancelled, field.size(), points.size(), "the transport field");
  }
  return field;
}

/// Those of unit length; zero where they cancel.
template <std::floating_point T>
[[nodiscard]] LightField<T> interpolate(const Surface<double>& surface,
                                        const std::vector<Vec3<T>>& at_vertices,
                                        std::span<const SurfacePoint<T>> points,
                                        const CancelHook& cancelled) {
  LightField<T> field = means(surface, at_vertices, points, cancelled);
  for (Vec3<T>& direction : field) direction = direction_of(direction);
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
                                            const std::type_identity_t<Vec3<T>>& emission,
                                            PointSpan<T> points, const CancelHook& cancelled = {}) {
  cancelled.check(0, "the transport field");
  return detail::interpolate(solver.surface(), solver.transport(led, emission), points,
                             cancelled.part(0.5, 1));
}

/// Light that leaves the LED in all directions of its tangent plane, each carried along: the radial
/// direction of the LED's log map, on a border less exact (VectorHeatSolver::radial).
/// `geodesic_field` has the same directions exactly. Otherwise as `transport_field`.
template <std::floating_point T>
[[nodiscard]] LightField<T> radial_transport_field(const VectorHeatSolver<T>& solver, Index led,
                                                   PointSpan<T> points,
                                                   const CancelHook& cancelled = {}) {
  cancelled.check(0, "the transport field");
  return detail::interpolate(solver.surface(), solver.radial(led), points, cancelled.part(0.5, 1));
}

/// The light of an LED of several points, each with its own direction of emission, blended between
/// them; otherwise as `transport_field`. Directions alone count, not lengths.
template <std::floating_point T>
[[nodiscard]] LightField<T> transport_field(
    const VectorHeatSolver<T>& solver, std::type_identity_t<std::span<const VectorSource<T>>> led,
    PointSpan<T> points, const CancelHook& cancelled = {}) {
  cancelled.check(0, "the transport field");
  return detail::interpolate(solver.surface(), solver.transport(led), points,
                             cancelled.part(0.5, 1));
}

/// A field known at the vertices, as `VectorHeatSolver` gives it, at points between them: with the
/// distances of the vertices (from any solver) interpolated, and the points told apart where the
/// directions at the corners of their face part so far that their mean is shorter than half: the
/// cut locus of a field that has one, within an edge. Throws InvalidInput unless there is a
/// direction and a distance for each vertex, and for a direction that is not finite and a distance
/// that is negative or not a number.
template <std::floating_point T>
[[nodiscard]] LightRays<T> rays_between_vertices(const Surface<double>& surface,
                                                 const std::vector<Vec3<T>>& at_vertices,
                                                 std::type_identity_t<std::span<const T>> distances,
                                                 PointSpan<T> points,
                                                 const CancelHook& cancelled = {}) {
  const auto vertices = static_cast<std::size_t>(surface.vertex_count());
  detail::require(at_vertices.size() == vertices && distances.size() == vertices, "there are ",
                  at_vertices.size(), " directions and ", distances.size(), " distances for ",
                  vertices, " vertices");
  detail::require_finite(at_vertices, "direction");
  for (std::size_t v = 0; v < vertices; ++v) {
    detail::require(distances[v] >= 0, "distance ", v, " is ", distances[v]);
  }
  LightField<T> units;
  units.reserve(vertices);
  for (const Vec3<T>& direction : at_vertices) units.push_back(detail::direction_of(direction));
  const LightField<T> field = detail::means(surface, units, points, cancelled);
  LightRays<T> rays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const T distance = detail::mean_at(surface, distances, points[i]);
    const T agreement = norm(field[i]);
    const Lighting how = !(distance < unreachable<T>)      ? Lighting::dark
                         : agreement == 0 && distance == 0 ? Lighting::at_led
                         : agreement < T(0.5)              ? Lighting::ambiguous
                                                           : Lighting::lit;
    const bool is_dark = how == Lighting::dark;
    rays.add(is_dark ? Vec3<T>(0, 0, 0) : detail::direction_of(field[i]),
             is_dark ? unreachable<T> : distance, how);
  }
  return rays;
}

}  // namespace gelight
