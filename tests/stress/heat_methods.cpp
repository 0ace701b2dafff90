#include "gelight/geodesic/heat.hpp"
#include "stress/query.hpp"

namespace gelight::stress {

std::vector<Method> heat_methods() {
  return {{"heat", maker<HeatSolver>(HeatOptions{.intrinsic_delaunay = false}), false, false},
          {"heat, intrinsic Delaunay", maker<HeatSolver>(), false, false}};
}

}  // namespace gelight::stress
