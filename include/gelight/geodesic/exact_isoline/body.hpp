#pragma once

#include <concepts>
#include <type_traits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact_isoline.hpp"
#include "gelight/geodesic/exact_isoline/arc_tracer.hpp"

namespace gelight {

template <std::floating_point T>
auto exact_isolines(const ExactField<T>& field, std::type_identity_t<T> level,
                    const CancelHook& cancelled) -> std::vector<ExactIsoline<T>> {
  return detail::ArcTracer<T>(field, level, cancelled).lines();
}

template <std::floating_point T>
auto area_within(const ExactField<T>& field, std::type_identity_t<T> level,
                 const CancelHook& cancelled) -> T {
  return detail::ArcTracer<T>(field, level, cancelled).area();
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template std::vector<ExactIsoline<float>> exact_isolines(const ExactField<float>&, float,
                                                         const CancelHook&);
template float area_within(const ExactField<float>&, float, const CancelHook&);
template std::vector<ExactIsoline<double>> exact_isolines(const ExactField<double>&, double,
                                                          const CancelHook&);
template double area_within(const ExactField<double>&, double, const CancelHook&);
}  // namespace gelight
#endif
