#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fuzz/bytes.hpp"
#include "gelight/core/error.hpp"
#include "gelight/transport/vector_heat.hpp"

// Vectors on any small mesh: refused, or carried without becoming longer or something else than
// numbers.

using namespace gelight;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const double x = bytes.take<std::int8_t>(), y = bytes.take<std::int8_t>();
  const double z = bytes.take<std::int8_t>();
  const Index vertex = bytes.below(16);
  const auto mesh = fuzz::take_mesh(bytes, 16, 24);
  // Of lengths near the ends of the range squares overflow or vanish.
  for (const auto& p : mesh.positions) {
    for (const double c : p) {
      if (c != 0 && !(std::fabs(c) < 1e100 && std::fabs(c) > 1e-100)) return 0;
    }
  }
  try {
    const VectorHeatSolver solver(mesh);
    const double length = std::hypot(x, y, z);
    for (const auto& v : solver.transport(vertex, {x, y, z})) {
      fuzz::expect(v.allFinite() && v.norm() <= length * (1 + 1e-6), "a vector has grown");
    }
    for (const auto& v : solver.radial(vertex)) {
      fuzz::expect(v.allFinite() && v.norm() <= 1 + 1e-6, "a direction longer than 1");
    }
    for (const auto& p : solver.log_map(vertex)) {
      fuzz::expect(!std::isnan(p[0]) && !std::isnan(p[1]), "a coordinate is not a number");
    }
  } catch (const InvalidInput&) {
    // A refusal, by name.
  }
  return 0;
}
