// expect: face\(mesh, i\).*(convertible_to|is_convertible_v)
#include "gelight/mesh/surface.hpp"

struct Quads {
  using Scalar = double;
  int vertex_count() const { return 4; }
  int face_count() const { return 1; }
  std::array<double, 3> position(gelight::Index) const { return {}; }
  std::array<gelight::Index, 4> face(gelight::Index) const { return {0, 1, 2, 3}; }
};

int main() { gelight::Surface<double> surface(Quads{}); }
