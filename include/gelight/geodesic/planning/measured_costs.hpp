#pragma once

// Written by benchmarks/calibrate_planner, on one core of an Intel Xeon.

#include "gelight/geodesic/plan_costs.hpp"

namespace gelight::detail {

inline constexpr PlanCosts measured_costs{
    .dijkstra = {84, 73, 0.07, 92},
    .virtual_source = {730, 370, 0.17, 1100},
    .fast_marching = {140, 140, 0.13, 340},
    .exact = {190, 2300, 0.32, 290},
    .certificate = {0, 1100, 0.14, 140},
    .paths = {0, 59, -0.15, 10},
    .sample_share = 0.0085,
};

}  // namespace gelight::detail
