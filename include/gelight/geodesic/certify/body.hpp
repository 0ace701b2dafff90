#pragma once

#include <concepts>
#include <memory>
#include <span>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/certifier_engine.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
auto Certifier<T>::new_engine(const Surface<double>& surface) -> std::shared_ptr<const Engine> {
  return std::make_shared<const Engine>(surface);
}

template <std::floating_point T>
auto Certifier<T>::bounds(std::span<const Index> vertices, std::span<const T> distances,
                          const CancelHook& cancelled) const -> DistanceBounds<T> {
  return engine_->bounds_of(detail::checked_sources(engine_->surface(), vertices), distances,
                            cancelled);
}

template <std::floating_point T>
auto Certifier<T>::bounds(std::span<const Source<T>> sources, std::span<const T> distances,
                          const CancelHook& cancelled) const -> DistanceBounds<T> {
  return engine_->bounds_of(detail::checked_sources(engine_->surface(), sources), distances,
                            cancelled);
}

template <std::floating_point T>
auto Certifier<T>::bounds(std::span<const SurfacePoint<T>> points, std::span<const T> distances,
                          const CancelHook& cancelled) const -> DistanceBounds<T> {
  return engine_->bounds_of(detail::checked_sources(engine_->surface(), points), distances,
                            cancelled);
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class Certifier<float>;
template class Certifier<double>;
}  // namespace gelight
#endif
