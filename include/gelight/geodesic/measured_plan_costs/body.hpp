#pragma once

#include <concepts>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/geodesic/measured_plan_costs.hpp"
#include "gelight/geodesic/plan_costs.hpp"
#include "gelight/geodesic/planning/cost_measurement.hpp"

namespace gelight {

template <std::floating_point Real>
auto measured_plan_costs(const CancelHook& cancelled) -> PlanCosts {
  return detail::CostMeasurement<Real>(cancelled).all();
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template PlanCosts measured_plan_costs<double>(const CancelHook&);
}  // namespace gelight
#endif
