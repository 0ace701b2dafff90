// Where each distance solver breaks: error against the shape of the triangles, four ways to spoil
// the same sheet. Charted by plot/charts.py.

#include <functional>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "support/run.hpp"
#include "support/spoiled_sheets.hpp"

namespace {

using namespace gelight;
using bench::Sheet, bench::source, bench::Spoiling;

struct Method {
  std::string name;
  std::function<std::vector<double>(const Sheet&)> distance;
};
const std::vector<Method> methods{
    {"Dijkstra", [](const Sheet& m) { return DijkstraSolver(m).distance(source); }},
    {"fast marching", [](const Sheet& m) { return FastMarchingSolver(m).distance(source); }},
    {"virtual source", [](const Sheet& m) { return VirtualSourceSolver(m).distance(source); }},
    {"heat",
     [](const Sheet& m) {
       return HeatSolver(m, HeatOptions{.intrinsic_delaunay = false}).distance(source);
     }},
    {"heat, intrinsic Delaunay", [](const Sheet& m) { return HeatSolver(m).distance(source); }},
    {"exact", [](const Sheet& m) { return ExactSolver(m).distance(source); }}};

void measure(benchmark::State& state, const Method& method, const Spoiling& spoiling,
             double degree) {
  if (!measure_on(state, spoiling, degree, method.distance)) {
    state.SkipWithError("a distance that is not finite");
  }
  // Rounding, times the aspect ratio of the triangles.
  if (method.name == "exact" && state.counters["most"] > 1e-14 * std::max(10.0, degree)) {
    state.SkipWithError("the exact distance is not exact");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  for (const Spoiling& spoiling : bench::spoilings) {
    for (const Method& method : methods) {
      if (!spoiling.is_flat && method.name == "exact") continue;
      for (const double degree : spoiling.degrees) {
        benchmark::RegisterBenchmark(
            name_of(spoiling, method.name, degree).c_str(),
            [&spoiling, &method, degree](auto& state) { measure(state, method, spoiling, degree); })
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  return bench::run(argc, argv);
} catch (...) {
  return told();
}
