#pragma once

#include <concepts>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/geodesic/isoline/isoline_tracer.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

template <std::floating_point T>
auto isolines(const Surface<T>& surface, std::type_identity_t<std::span<const T>> values,
              std::type_identity_t<T> level) -> std::vector<Isoline<T>> {
  return detail::IsolineTracer<T>(surface, values, level).lines();
}

template <std::floating_point T>
auto area_below(const Surface<T>& surface, std::type_identity_t<std::span<const T>> values,
                std::type_identity_t<T> level) -> T {
  return detail::IsolineTracer<T>(surface, values, level).area_below();
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template std::vector<Isoline<float>> isolines(const Surface<float>&, std::span<const float>, float);
template float area_below(const Surface<float>&, std::span<const float>, float);
template std::vector<Isoline<double>> isolines(const Surface<double>&, std::span<const double>,
                                               double);
template double area_below(const Surface<double>&, std::span<const double>, double);
}  // namespace gelight
#endif
