#pragma once

#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/heat_engine.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "gelight/transport/vector_heat/engine.hpp"

namespace gelight {

template <std::floating_point T>
VectorHeatSolver<T>::VectorHeatSolver(Surface<Real> surface,
                                      std::shared_ptr<const detail::HeatSystem<Real>> system,
                                      const VectorHeatOptions& options)
    : engine_(std::make_shared<const Engine>(std::move(surface), std::move(system), options)) {}

template <std::floating_point T>
VectorHeatSolver<T>::VectorHeatSolver(const HeatSolver<T>& heat, const CancelHook& cancelled)
    : VectorHeatSolver(heat.surface(), heat.system(),
                       {heat.system()->time_factor, heat.system()->is_delaunay, cancelled}) {}

template <std::floating_point T>
auto VectorHeatSolver<T>::surface() const -> const Surface<double>& {
  return engine_->surface();
}

template <std::floating_point T>
auto VectorHeatSolver<T>::tangent_basis(Index vertex) const -> std::array<Vec3<T>, 2> {
  return engine_->tangent_basis(vertex);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::transport(Index vertex, const Vec3<T>& vector) const
    -> std::vector<Vec3<T>> {
  return engine_->transport(vertex, vector);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::transport(std::span<const VectorSource<T>> sources) const
    -> std::vector<Vec3<T>> {
  return engine_->transport(sources);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::solve(Index vertex, const Vec3<T>& vector) const -> TransportResult<T> {
  return engine_->solve(vertex, vector);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::solve(std::span<const VectorSource<T>> sources) const
    -> TransportResult<T> {
  return engine_->solve(sources);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::radial(Index vertex) const -> std::vector<Vec3<T>> {
  return engine_->radial(vertex);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::log_map(Index vertex) const -> std::vector<Vec2<T>> {
  return engine_->log_map(vertex);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::solve_log_map(Index vertex) const -> LogMapResult<T> {
  return engine_->solve_log_map(vertex);
}

template <std::floating_point T>
auto VectorHeatSolver<T>::extend(std::span<const Index> vertices, std::span<const T> values) const
    -> std::vector<T> {
  return engine_->extend(vertices, values);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class VectorHeatSolver<float>;
template class VectorHeatSolver<double>;
}  // namespace gelight
#endif
