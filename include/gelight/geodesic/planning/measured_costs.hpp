#pragma once

// Written by benchmarks/calibrate_planner, on one core of an AMD EPYC.

#include "gelight/geodesic/plan_costs.hpp"

namespace gelight::detail {

inline constexpr PlanCosts measured_costs{
    .dijkstra = {100, 45, 0.2, 400},
    .virtual_source = {110, 160, 0.05, 450},
    .fast_marching = {160, 95, 0.05, 600},
    .exact = {160, 1400, 0.5, 600},
    .certificate = {160, 650, 0.1, 1100},
    .paths = {0, 50, -0.5, 10},
    .sample_share = 0.1,
};

}  // namespace gelight::detail
