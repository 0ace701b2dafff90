// expect: deleted
#include <cstddef>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"

int main() {
  const gelight::ExactSolver solver(gelight::icosphere<double>(1));
  const std::vector<std::size_t> vertices{0, 5};
  return static_cast<int>(solver.distance(vertices)[3]);
}
