#pragma once

#include <concepts>
#include <memory>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/growing_engine.hpp"
#include "gelight/geodesic/voronoi.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
GrowingDistances<T>::GrowingDistances(const ExactSolver<T>& solver)
    : engine_(std::make_shared<detail::GrowingEngine<T>>(solver.surface(), solver.options())) {}

template <std::floating_point T>
auto GrowingDistances<T>::add(const Source<T>& source, const CancelHook& cancelled)
    -> std::vector<Index> {
  return engine_->add(source, cancelled);
}

template <std::floating_point T>
auto GrowingDistances<T>::distance(Index vertex) const -> T {
  return engine_->distance(vertex);
}

template <std::floating_point T>
auto GrowingDistances<T>::surface() const -> const Surface<double>& {
  return engine_->surface();
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class GrowingDistances<float>;
template class GrowingDistances<double>;
}  // namespace gelight
#endif
