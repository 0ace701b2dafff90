// expect: floating_point
#include "gelight/mesh/surface.hpp"

struct Integers {
  using Scalar = int;
  int vertex_count() const { return 3; }
  int face_count() const { return 1; }
  std::array<int, 3> position(gelight::Index) const { return {}; }
  std::array<gelight::Index, 3> face(gelight::Index) const { return {0, 1, 2}; }
};

int main() { gelight::Surface<double> surface(Integers{}); }
