#pragma once

#include <concepts>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/engine.hpp"
#include "gelight/geodesic/exact/queries.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
auto ExactField<T>::distances() const -> std::vector<T> {
  return Queries(*solution_).distances();
}

template <std::floating_point T>
auto ExactField<T>::distance(Index vertex) const -> T {
  return Queries(*solution_).distance(vertex);
}

template <std::floating_point T>
auto ExactField<T>::distance(const SurfacePoint<T>& point) const -> T {
  return Queries(*solution_).distance(point);
}

template <std::floating_point T>
auto ExactField<T>::path(const SurfacePoint<T>& point) const -> Path<T> {
  return Queries(*solution_).path(point);
}

template <std::floating_point T>
auto ExactField<T>::direction(const SurfacePoint<T>& point) const -> Vec3<T> {
  return Queries(*solution_).direction(point);
}

template <std::floating_point T>
auto ExactField<T>::arrivals(const SurfacePoint<T>& point, T relative_tolerance) const
    -> std::vector<ExactArrival<T>> {
  return Queries(*solution_).arrivals(point, relative_tolerance);
}

template <std::floating_point T>
auto ExactField<T>::departure(const SurfacePoint<T>& point) const -> ExactDeparture<T> {
  return Queries(*solution_).departure(point);
}

template <std::floating_point T>
auto ExactSolver<T>::new_engine(Surface<double> surface, const ExactOptions<T>& options)
    -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(std::move(surface), options);
}

template <std::floating_point T>
auto ExactSolver<T>::surface() const -> const Surface<double>& {
  return engine_->surface();
}

template <std::floating_point T>
auto ExactSolver<T>::options() const -> const ExactOptions<T>& {
  return engine_->options();
}

template <std::floating_point T>
auto ExactSolver<T>::solve(std::span<const Index> vertices, const ExactOptions<T>& options) const
    -> ExactField<T> {
  return ExactField<T>(
      engine_->solve_checked(detail::checked_sources(surface(), vertices), options));
}

template <std::floating_point T>
auto ExactSolver<T>::solve(std::span<const Source<T>> sources, const ExactOptions<T>& options) const
    -> ExactField<T> {
  return ExactField<T>(
      engine_->solve_checked(detail::checked_sources(surface(), sources), options));
}

template <std::floating_point T>
auto ExactSolver<T>::solve(std::span<const SurfacePoint<T>> points,
                           const ExactOptions<T>& options) const -> ExactField<T> {
  return ExactField<T>(engine_->solve_checked(detail::checked_sources(surface(), points), options));
}

template <std::floating_point T>
auto ExactSolver<T>::solve(std::span<const Segment<T>> segments,
                           const ExactOptions<T>& options) const -> ExactField<T> {
  const auto curves = engine_->curves_of(segments);
  // Queries at points that are no vertices cannot search back to a line.
  ExactOptions<T> with_windows = options;
  with_windows.keep_windows = true;
  return ExactField<T>(engine_->solve_checked(curves.sources, with_windows, curves.fronts));
}

template <std::floating_point T>
auto ExactSolver<T>::distance(std::span<const Segment<T>> segments) const -> std::vector<T> {
  const auto curves = engine_->curves_of(segments);
  return ExactField<T>(engine_->solve_checked(curves.sources, options(), curves.fronts))
      .distances();
}

template <std::floating_point T>
void ExactSolver<T>::distance_into(std::span<T> out, std::span<const Source<T>> sources,
                                   const ExactOptions<T>& options) const {
  engine_->require_options(options);
  this->put_distances(out, sources, [&](auto& query) { engine_->solve_vertices(query, options); });
}

template <std::floating_point T>
void ExactSolver<T>::solve_vertices(detail::DistanceQuery<double>& query) const {
  engine_->solve_vertices(query);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class ExactSolver<float>;
template class ExactField<float>;
template class ExactSolver<double>;
template class ExactField<double>;
}  // namespace gelight
#endif
