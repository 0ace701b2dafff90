#pragma once

#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {

/// What the solver is to keep for queries at some points. To stop at the farthest takes time for
/// each of them, so that with more points than faces all windows are had sooner.
template <std::floating_point T>
[[nodiscard]] ExactOptions<T> options_for(const ExactSolver<T>& solver,
                                          std::span<const SurfacePoint<T>> points,
                                          const CancelHook& cancelled) {
  ExactOptions<T> options;
  options.cancelled = cancelled.part(0, 0.5);
  if (points.size() > static_cast<std::size_t>(solver.surface().face_count())) {
    options.keep_windows = true;
  } else {
    options.targets.assign(points.begin(), points.end());
  }
  return options;
}

}  // namespace detail

/// Light that follows the shortest path on the surface from the nearest of several points of an
/// LED: the exact direction in which that path arrives (Gomes, Paoletti, Luo 2023,
/// doi:10.15607/RSS.2023.XIX.035).
///
/// Zero at the LED and where no path leads; where two shortest paths meet, one of them
/// (`geodesic_rays` tells where). Throws InvalidInput for a point that is not of the surface. Cost:
/// one solve, and O(windows of its face) a point. To take directions at the vertices and
/// interpolate them inside the faces is 0.8 degrees off (mean) on the GelTip membrane, and wrong in
/// the faces at the LED and on the cut locus.
template <std::floating_point T>
[[nodiscard]] LightField<T> geodesic_field(const ExactSolver<T>& solver,
                                           std::type_identity_t<std::span<const Source<T>>> led,
                                           PointSpan<T> points, const CancelHook& cancelled = {}) {
  const ExactField<T> arrivals = solver.solve(led, detail::options_for(solver, points, cancelled));
  LightField<T> field;
  field.reserve(points.size());
  const CancelHook of_points = cancelled.part(0.5, 1);
  for (const auto& point : points) {
    field.push_back(arrivals.direction(point));
    detail::check_points(of_points, field.size(), points.size(), "the geodesic field");
  }
  return field;
}

/// The same for an LED that is one point.
template <std::floating_point T>
[[nodiscard]] LightField<T> geodesic_field(const ExactSolver<T>& solver, const SurfacePoint<T>& led,
                                           PointSpan<T> points, const CancelHook& cancelled = {}) {
  const Source<T> source{led, 0};
  return geodesic_field(solver, std::span(&source, 1), points, cancelled);
}

/// The same with distances, and with the points told apart where paths of different directions
/// differ in length by less than a share `tie` of it.
template <std::floating_point T>
[[nodiscard]] LightRays<T> geodesic_rays(const ExactSolver<T>& solver,
                                         std::type_identity_t<std::span<const Source<T>>> led,
                                         PointSpan<T> points, std::type_identity_t<T> tie = T(1e-6),
                                         const CancelHook& cancelled = {}) {
  detail::require(tie >= 0, "a tie of ", tie);
  const ExactField<T> field = solver.solve(led, detail::options_for(solver, points, cancelled));
  const CancelHook of_points = cancelled.part(0.5, 1);
  LightRays<T> rays;
  for (const auto& point : points) {
    const auto arrivals = field.arrivals(point, tie);
    if (arrivals.empty()) {
      rays.add(Vec3<T>(0, 0, 0), unreachable<T>, Lighting::dark);
    } else if (arrivals[0].direction.isZero(0)) {
      rays.add(Vec3<T>(0, 0, 0), arrivals[0].distance, Lighting::at_led);
    } else {
      rays.add(arrivals[0].direction, arrivals[0].distance,
               arrivals.size() > 1 ? Lighting::ambiguous : Lighting::lit);
    }
    detail::check_points(of_points, rays.distance.size(), points.size(), "the geodesic field");
  }
  return rays;
}

/// The same for an LED that is one point.
template <std::floating_point T>
[[nodiscard]] LightRays<T> geodesic_rays(const ExactSolver<T>& solver, const SurfacePoint<T>& led,
                                         PointSpan<T> points, std::type_identity_t<T> tie = T(1e-6),
                                         const CancelHook& cancelled = {}) {
  const Source<T> source{led, 0};
  return geodesic_rays(solver, std::span(&source, 1), points, tie, cancelled);
}

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template LightField<float> geodesic_field<float>(const ExactSolver<float>&,
                                                              const SurfacePoint<float>&,
                                                              std::span<const SurfacePoint<float>>,
                                                              const CancelHook&);
GELIGHT_ONCE template LightField<float> geodesic_field<float>(const ExactSolver<float>&,
                                                              std::span<const Source<float>>,
                                                              std::span<const SurfacePoint<float>>,
                                                              const CancelHook&);
GELIGHT_ONCE template LightField<double> geodesic_field<double>(
    const ExactSolver<double>&, const SurfacePoint<double>&, std::span<const SurfacePoint<double>>,
    const CancelHook&);
GELIGHT_ONCE template LightField<double> geodesic_field<double>(
    const ExactSolver<double>&, std::span<const Source<double>>,
    std::span<const SurfacePoint<double>>, const CancelHook&);
}  // namespace gelight
#endif
