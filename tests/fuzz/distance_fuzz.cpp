#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "fuzz/bytes.hpp"
#include "gelight/core/error.hpp"
#include "stress/stress.hpp"

// Every distance solver on any small mesh: it refuses or answers within its invariants.

using namespace gelight;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const auto choice = bytes.take<std::uint8_t>();
  stress::Problem problem{"", fuzz::take_mesh(bytes, 16, 24), {}};
  const auto count = static_cast<Index>(problem.mesh.positions.size());
  for (int s = 0; s <= choice % 3; ++s) {
    SurfacePoint<double> point = vertex_point<double>(bytes.below(count));
    const double t = bytes.take<std::uint8_t>() / 255.0;
    if (choice & 64) point = edge_point(bytes.below(count), bytes.below(count), t);
    if (choice & 128) point = face_point<double>(bytes.below(24), {t, 1 - t, 0});
    problem.sources.push_back({point, static_cast<double>(bytes.take<std::uint8_t>()) / 64});
  }
  const auto& method = stress::methods()[choice / 3 % stress::methods().size()];
  const bool is_float = (choice & 32) != 0;
  const auto precision = is_float ? stress::Precision::in_float : stress::Precision::in_double;
  try {
    const auto distance = method.make(problem.mesh, precision)->distance(problem.sources);
    // Of lengths near the ends of the range squares overflow or vanish.
    double largest = 0, smallest = std::numeric_limits<double>::infinity();
    for (const auto& p : problem.mesh.positions) {
      for (const double x : p) {
        largest = std::max(largest, std::fabs(x));
        if (x != 0) smallest = std::min(smallest, std::fabs(x));
      }
    }
    if (!(largest < (is_float ? 1e15 : 1e100) && smallest > (is_float ? 1e-15 : 1e-100))) return 0;
    stress::Findings findings;
    stress::check_invariants(method, problem, distance, precision, findings);
    fuzz::expect(findings.faults().empty(),
                 method.name + ": " + (findings.faults().empty() ? "" : findings.faults()[0]));
  } catch (const InvalidInput&) {
    // A refusal, by name.
  }
  return 0;
}
