#pragma once

#include <concepts>
#include <memory>
#include <utility>

#include "gelight/core/compiled.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/marching/dijkstra_engine.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
auto DijkstraSolver<T>::new_engine(detail::MeshArrays<Real> mesh, const Surface<Real>* surface,
                                   const DijkstraOptions& options)
    -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(std::move(mesh), surface, options);
}

template <std::floating_point T>
auto DijkstraSolver<T>::new_engine(const Surface<Real>& surface, const DijkstraOptions& options)
    -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(surface, options);
}

template <std::floating_point T>
auto DijkstraSolver<T>::surface() const -> const Surface<Real>& {
  return engine_->surface();
}

template <std::floating_point T>
auto DijkstraSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query) const -> void {
  engine_->solve_vertices(query);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class DijkstraSolver<float>;
template class DijkstraSolver<double>;
}  // namespace gelight
#endif
