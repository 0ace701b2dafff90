#include "gelight/geodesic/heat.hpp"
#include "stress/query.hpp"

namespace gelight::stress {

std::vector<Method> heat_methods() {
  return {{"heat", maker<HeatSolver>(), false, false},
          {"heat, the mesh as it is", maker<HeatSolver>(HeatOptions{.intrinsic_delaunay = false}),
           false, false}};
}

}  // namespace gelight::stress
