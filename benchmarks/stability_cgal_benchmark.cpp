// CGAL's exact and heat distances on the sheets of stability_benchmark, for the same chart. Where
// one of them throws or answers with what is not finite, its row is without a mean.

#include <exception>

#include "support/cgal_distances.hpp"
#include "support/run.hpp"
#include "support/spoiled_sheets.hpp"

namespace {

using namespace gelight;
using namespace bench::cgal;
using bench::Sheet, bench::source, bench::Spoiling;

Distances exact(const Sheet& sheet) {
  const CgalMesh mesh = to_cgal(sheet);
  ShortestPath paths(mesh);
  return exact_distances(mesh, paths, source);
}

Distances by_heat(const Sheet& sheet) {
  CgalMesh mesh = to_cgal(sheet);
  Heat heat(mesh);
  const auto map = mesh.add_property_map<Vertex, double>("v:distance", 0).first;
  return heat_distances(mesh, map, heat, source);
}

struct Method {
  const char* name;
  Distances (*distance)(const Sheet&);
};
constexpr Method methods[] = {{"CGAL exact", exact}, {"CGAL heat", by_heat}};

void measure(benchmark::State& state, const Method& method, const Spoiling& spoiling,
             double degree) {
  try {
    if (!measure_on(state, spoiling, degree, method.distance)) state.SetLabel("not finite");
  } catch (const std::exception& error) {
    state.SetLabel(error.what());
  }
}

}  // namespace

int main(int argc, char** argv) try {
  for (const Spoiling& spoiling : bench::spoilings) {
    for (const Method& method : methods) {
      for (const double degree : spoiling.degrees) {
        benchmark::RegisterBenchmark(
            name_of(spoiling, method.name, degree).c_str(),
            [&spoiling, &method, degree](auto& state) { measure(state, method, spoiling, degree); })
            ->Iterations(1)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  return bench::run(argc, argv);
} catch (...) {
  return told();
}
