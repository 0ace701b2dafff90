#include "gelight/geodesic/exact.hpp"
#include "stress/query.hpp"

namespace gelight::stress {

std::vector<Method> exact_methods() { return {{"exact", maker<ExactSolver>(), true, true, 1e-9}}; }

}  // namespace gelight::stress
