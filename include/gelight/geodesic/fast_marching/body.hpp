#pragma once

#include <concepts>
#include <memory>
#include <utility>

#include "gelight/core/compiled.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/marching/fast_marching_engine.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
auto FastMarchingSolver<T>::new_engine(detail::MeshArrays<Real> mesh, const Surface<Real>* surface,
                                       const FastMarchingOptions& options)
    -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(std::move(mesh), surface, options);
}

template <std::floating_point T>
auto FastMarchingSolver<T>::surface() const -> const Surface<Real>& {
  return engine_->surface();
}

template <std::floating_point T>
auto FastMarchingSolver<T>::solve_vertices(detail::DistanceQuery<double>& query) const -> void {
  engine_->solve_vertices(query);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class FastMarchingSolver<float>;
template class FastMarchingSolver<double>;
}  // namespace gelight
#endif
