#pragma once

#include <concepts>
#include <span>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// Light that follows the shortest path on the surface from the nearest of several points of an
/// LED: the exact direction in which that path arrives (Gomes, Paoletti, Luo, "Simulation of Curved
/// GelSight Sensors for Sim2Real Learning").
///
/// Zero at the LED and where no path leads; where two shortest paths meet, one of them. Throws
/// InvalidInput for a point that is not of the surface. Cost: one solve, and O(1) a point.
template <std::floating_point T>
[[nodiscard]] LightField<T> geodesic_field(const ExactSolver<T>& solver,
                                           std::span<const Source<T>> led,
                                           std::span<const SurfacePoint<T>> points) {
  const ExactField<T> arrivals = solver.solve(led, {.keep_windows = true});
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) field.push_back(arrivals.direction(point));
  return field;
}

/// The same for an LED that is one point.
template <std::floating_point T>
[[nodiscard]] LightField<T> geodesic_field(const ExactSolver<T>& solver, const SurfacePoint<T>& led,
                                           std::span<const SurfacePoint<T>> points) {
  const Source<T> source{led, 0};
  return geodesic_field(solver, std::span(&source, 1), points);
}

}  // namespace gelight
