// CGAL's exact and heat distances on the meshes of pareto_benchmark, measured the same way, for the
// same charts.

#include <functional>
#include <memory>

#include "support/cgal_distances.hpp"
#include "support/pareto.hpp"

namespace {

using namespace pareto;
using namespace bench::cgal;

// Where every query begins anew, the first, timed already, is as good as a further one.
template <class Make>
void measure(benchmark::State& state, const Case& on, double wrong_beyond, bool begins_anew,
             const Make& make) {
  CgalMesh mesh = to_cgal(on.mesh);
  const PeakMemory memory;
  std::function<Distances(Index)> query;
  const double setup = seconds([&] { query = make(mesh); });
  Distances distances;
  const double first = seconds([&] { distances = query(on.sources[0]); });
  std::vector<double> times;
  Errors errors, smooth;
  for (auto _ : state) {
    const std::size_t which = times.size() % on.sources.size();
    const bool is_timed = begins_anew && times.empty();
    times.push_back(is_timed ? first : seconds([&] { distances = query(on.sources[which]); }));
    state.SetIterationTime(times.back());
    if (times.size() > on.sources.size()) continue;
    errors.add(distances, on.exact[which]);
    if (!on.smooth.empty()) smooth.add(distances, on.smooth[which]);
  }
  state.counters["peak_MB"] = memory.megabytes();
  state.counters["vertices"] = static_cast<double>(on.mesh.positions.size());
  state.counters["setup_s"] = setup;
  state.counters["first_s"] = first;
  state.counters["median_s"] = median(times);
  state.counters["floor"] = on.floor;
  errors.report(state, "");
  smooth.report(state, "smooth_");
  if (!(errors.mean() <= wrong_beyond)) state.SkipWithError("the distances are wrong");
}

void measure_exact(benchmark::State& state, const Case& on) {
  measure(state, on, 1e-9, true, [](CgalMesh& mesh) {
    auto paths = std::make_shared<ShortestPath>(mesh);
    return [&mesh, paths](Index source) { return exact_distances(mesh, *paths, source); };
  });
}

void measure_heat(benchmark::State& state, const Case& on) {
  measure(state, on, 1.0, false, [](CgalMesh& mesh) {
    auto heat = std::make_shared<Heat>(mesh);
    const auto map = mesh.add_property_map<Vertex, double>("v:distance", 0).first;
    return [&mesh, heat, map](Index source) { return heat_distances(mesh, map, *heat, source); };
  });
}

}  // namespace

int main(int argc, char** argv) try {
  static const std::vector<Case> cases = procedural_cases();
  using benchmark::RegisterBenchmark;
  for (const Case& on : cases) {
    RegisterBenchmark(("distance/" + on.name + "/CGAL exact/5.5").c_str(),
                      [&](benchmark::State& state) { measure_exact(state, on); })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
    RegisterBenchmark(("distance/" + on.name + "/CGAL heat/5.5").c_str(),
                      [&](benchmark::State& state) { measure_heat(state, on); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
  return run(argc, argv);
} catch (...) {
  return told();
}
