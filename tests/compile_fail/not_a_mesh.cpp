// expect: NotAMesh.*(TriangleMesh|MeshScalar)
#include "gelight/geodesic/exact.hpp"

struct NotAMesh {};

int main() { gelight::ExactSolver solver(NotAMesh{}); }
