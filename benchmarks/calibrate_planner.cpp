// Measures what the planner's methods cost on this machine and writes the header that it reads:
//   calibrate_planner include/gelight/geodesic/planning/measured_costs.hpp "one core of an AMD
//   EPYC"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>

#include "../examples/support/plain_words.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/measured_plan_costs.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "support/pareto.hpp"

namespace {

using namespace gelight;

/// To two digits, as a number that can be read.
double rounded(double value) {
  if (value == 0) return 0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - 1);
  return std::round(value / unit) * unit;
}

/// Bytes a vertex at the peak of a method's set-up and one query.
template <class Make>
double bytes(const Surface<double>& surface, Make make) {
  const pareto::PeakMemory peak;
  const auto solver = make(surface);
  if (!(solver.distance(Index{0})[0] == 0)) throw std::runtime_error("a source is not at 0");
  return 1e6 * peak.megabytes() / surface.vertex_count();
}

void measure_bytes(PlanCosts& costs) {
  const Surface<double> surface(icosphere<double>(5));
  costs.dijkstra.bytes = bytes(surface, [](const auto& s) { return DijkstraSolver<double>(s); });
  costs.virtual_source.bytes =
      bytes(surface, [](const auto& s) { return VirtualSourceSolver<double>(s); });
  costs.fast_marching.bytes =
      bytes(surface, [](const auto& s) { return FastMarchingSolver<double>(s); });
  costs.exact.bytes = bytes(surface, [](const auto& s) { return ExactSolver<double>(s); });
  const auto distances = FastMarchingSolver<double>(surface).distance(Index{0});
  const pareto::PeakMemory peak;
  const Certifier<double> certifier(surface);
  const auto bounds = certifier.bounds(Index{0}, distances);
  costs.certificate.bytes = 1e6 * peak.megabytes() / static_cast<double>(bounds.lower.size());
}

std::string header(const PlanCosts& costs, const std::string& machine) {
  std::ostringstream out;
  const auto line = [&](const char* name, const MethodCost& cost) {
    out << "    ." << name << " = {" << rounded(cost.setup_ns) << ", " << rounded(cost.query_ns)
        << ", " << std::round(cost.growth * 100) / 100 << ", " << rounded(cost.bytes) << "},\n";
  };
  out << "#pragma once\n\n// Written by benchmarks/calibrate_planner, on " << machine
      << ".\n\n#include \"gelight/geodesic/plan_costs.hpp\"\n\nnamespace gelight::detail {\n\n"
         "inline constexpr PlanCosts measured_costs{\n";
  line("dijkstra", costs.dijkstra);
  line("virtual_source", costs.virtual_source);
  line("fast_marching", costs.fast_marching);
  line("exact", costs.exact);
  line("certificate", costs.certificate);
  line("paths", costs.paths);
  out << "    .sample_share = " << rounded(costs.sample_share)
      << ",\n};\n\n}  // namespace gelight::detail\n";
  return out.str();
}

}  // namespace

int main(int argc, char** argv) try {
  const std::span<char*> arguments(argv, static_cast<std::size_t>(argc));
  if (argc != 3) {
    std::cerr << "usage: " << arguments[0] << " HEADER MACHINE\n";
    return 2;
  }
  require_writable(arguments[1]);
  PlanCosts costs = measured_plan_costs();
  measure_bytes(costs);
  std::ofstream(arguments[1]) << header(costs, arguments[2]);
} catch (...) {
  return told();
}
