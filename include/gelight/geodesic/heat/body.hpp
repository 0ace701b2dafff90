#pragma once

#include <concepts>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/heat/engine.hpp"
#include "gelight/geodesic/heat/system.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
HeatSolver<T>::HeatSolver(Surface<Real> surface, const HeatOptions& options,
                          std::shared_ptr<const detail::HeatSystem<Real>> system)
    : engine_(std::make_shared<const Engine>(std::move(surface), options, std::move(system))) {}

template <std::floating_point T>
auto HeatSolver<T>::surface() const -> const Surface<double>& {
  return engine_->surface();
}

template <std::floating_point T>
auto HeatSolver<T>::system() const -> const std::shared_ptr<const detail::HeatSystem<Real>>& {
  return engine_->system();
}

template <std::floating_point T>
auto HeatSolver<T>::solve(std::span<const Index> vertices) const -> HeatResult<T> {
  const auto solution = engine_->solution(detail::checked_sources(surface(), vertices));
  return engine_->template result_of<T>(solution);
}

template <std::floating_point T>
auto HeatSolver<T>::solve(std::span<const Source<T>> sources) const -> HeatResult<T> {
  const auto solution = engine_->solution(detail::checked_sources(surface(), sources));
  return engine_->template result_of<T>(solution);
}

template <std::floating_point T>
auto HeatSolver<T>::solve(std::span<const SurfacePoint<T>> points) const -> HeatResult<T> {
  const auto solution = engine_->solution(detail::checked_sources(surface(), points));
  return engine_->template result_of<T>(solution);
}

template <std::floating_point T>
auto HeatSolver<T>::distance_from_each(std::span<const Index> vertices) const
    -> std::vector<std::vector<T>> {
  return solve_each(vertices);
}

template <std::floating_point T>
auto HeatSolver<T>::distance_from_each(std::span<const Source<T>> sources) const
    -> std::vector<std::vector<T>> {
  return solve_each(sources);
}

template <std::floating_point T>
auto HeatSolver<T>::distance_from_each(std::span<const SurfacePoint<T>> points) const
    -> std::vector<std::vector<T>> {
  return solve_each(points);
}

template <std::floating_point T>
template <class Place>
auto HeatSolver<T>::solve_each(std::span<const Place> places) const -> std::vector<std::vector<T>> {
  std::vector<detail::Sources> queries;
  for (std::size_t i = 0; i < places.size(); ++i) {
    queries.push_back(detail::Sources{detail::checked_source(surface(), places[i], i)});
  }
  std::vector<std::vector<T>> result;
  for (const auto& solution : engine_->solutions(queries)) {
    result.push_back(engine_->template distances_of<T>(solution));
  }
  return result;
}

template <std::floating_point T>
void HeatSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query) const {
  engine_->solve_vertices(query);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class HeatSolver<float>;
template class HeatSolver<double>;
}  // namespace gelight
#endif
