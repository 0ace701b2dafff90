#pragma once

#include <concepts>
#include <memory>
#include <span>
#include <utility>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/planning/plan_engine.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
auto DistancePlanner<T>::new_engine(Surface<double> surface, const PlanRequest& request)
    -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(std::move(surface), request);
}

template <std::floating_point T>
auto DistancePlanner<T>::plan() const -> const DistancePlan& {
  return engine_->plan();
}

template <std::floating_point T>
auto DistancePlanner<T>::surface() const -> const Surface<double>& {
  return engine_->surface();
}

template <std::floating_point T>
auto DistancePlanner<T>::solve_vertices(detail::DistanceQuery<double>& query) const -> void {
  engine_->solve_vertices(query);
}

template <std::floating_point T>
auto DistancePlanner<T>::solve(std::span<const Index> vertices) const -> PlannedDistances<T> {
  return engine_->run(detail::checked_sources(surface(), vertices));
}

template <std::floating_point T>
auto DistancePlanner<T>::solve(std::span<const Source<T>> sources) const -> PlannedDistances<T> {
  return engine_->run(detail::checked_sources(surface(), sources));
}

template <std::floating_point T>
auto DistancePlanner<T>::solve(std::span<const SurfacePoint<T>> points) const
    -> PlannedDistances<T> {
  return engine_->run(detail::checked_sources(surface(), points));
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class DistancePlanner<float>;
template class DistancePlanner<double>;
}  // namespace gelight
#endif
