#pragma once

// Written by benchmarks/calibrate_planner, on one core of an Intel Xeon.

#include "gelight/geodesic/plan_costs.hpp"

namespace gelight::detail {

inline constexpr PlanCosts measured_costs{
    .dijkstra = {82, 81, 0.14, 150},
    .virtual_source = {1200, 560, 0.13, 1100},
    .fast_marching = {240, 210, 0.02, 310},
    .exact = {400, 3800, 0.28, 300},
    .certificate = {0, 1400, 0.16, 140},
    .paths = {0, 83, -0.56, 10},
    .sample_share = 0.005,
};

}  // namespace gelight::detail
