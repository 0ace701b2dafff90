#include "gelight/geodesic/heat.hpp"
#include "stress/query.hpp"

namespace gelight::stress {

std::vector<Method> heat_methods() {
  return {{"heat", maker<HeatSolver>(), false, false, 1e-12, unreachable<double>},
          {"heat, intrinsic Delaunay", maker<HeatSolver>(HeatOptions{.intrinsic_delaunay = true}),
           false, false, 1e-12, unreachable<double>}};
}

}  // namespace gelight::stress
