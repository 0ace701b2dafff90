#pragma once

#include <concepts>
#include <memory>
#include <utility>

#include "gelight/core/compiled.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/marching/virtual_source_engine.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
auto VirtualSourceSolver<T>::new_engine(Surface<Real> surface, const VirtualSourceOptions& options)
    -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(std::move(surface), options);
}

template <std::floating_point T>
auto VirtualSourceSolver<T>::surface() const -> const Surface<Real>& {
  return engine_->surface();
}

template <std::floating_point T>
auto VirtualSourceSolver<T>::solve_vertices(detail::DistanceQuery<double>& query) const -> void {
  engine_->solve_vertices(query);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class VirtualSourceSolver<float>;
template class VirtualSourceSolver<double>;
}  // namespace gelight
#endif
