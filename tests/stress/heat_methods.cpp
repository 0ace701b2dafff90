#include "gelight/geodesic/heat.hpp"
#include "stress/query.hpp"

namespace gelight::stress {

std::vector<Method> heat_methods() {
  return {{"heat", maker<HeatSolver>(), false, false},
          {"heat, intrinsic Delaunay", maker<HeatSolver>(HeatOptions{.intrinsic_delaunay = true}),
           false, false}};
}

}  // namespace gelight::stress
