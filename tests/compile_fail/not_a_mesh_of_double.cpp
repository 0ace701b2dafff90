// expect: TriangleMesh
#include "gelight/geodesic/heat.hpp"

struct NotAMesh {};

int main() { gelight::HeatSolver<double> solver(NotAMesh{}); }
