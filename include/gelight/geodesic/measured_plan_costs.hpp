#pragma once

#include <concepts>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/geodesic/plan_costs.hpp"

namespace gelight {
/// What the methods of DistancePlanner cost on the machine that runs it, for PlanRequest::costs:
/// the least processor time of five runs on rough balls of 10,242 and 40,962 vertices, which takes
/// some seconds. To be called while no other thread of the program works. Memory is not measured
/// but is as in the table that benchmarks/calibrate_planner wrote. Throws Cancelled where the hook
/// says so.
template <std::floating_point Real = double>
[[nodiscard]] PlanCosts measured_plan_costs(const CancelHook& cancelled = {});

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/measured_plan_costs/body.hpp"
#endif
