// How gelight came in, one door of it can tell.

#include <cstdio>
#include <gelight/geodesic/fast_marching.hpp>
#include <gelight/mesh/shapes.hpp>

int main() {
  // On a flat sheet the shortest path from corner to corner is the straight line.
  const gelight::FastMarchingSolver solver(gelight::grid<double>(8, 6, 4, 3));
  std::printf("across a sheet of 4 x 3: %.9f\n", solver.distance(gelight::Index{0}).back());
}
