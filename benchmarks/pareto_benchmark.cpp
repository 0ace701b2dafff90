// Speed against accuracy: every distance solver with its dials on meshes of every kind, time and
// error from the same runs. A wrong answer is an error.
//
// pareto_benchmark [--mesh=FILE] adds a mesh of the user's; FILE is read by OpenMesh. Counters:
// setup_s, first_s (the first query, which makes what is made late), the time itself: a further
// query; mean, p99, max: relative error against the exact polyhedral distance; smooth_*: against
// the great circle; floor: 0.10 (kappa h)^2 of the mesh; peak_MB: beyond the mesh; windows: of an
// exact solve; fill: numbers in a heat solver's two factors; iterations: its refinements.

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>

#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "support/pareto.hpp"

#if __has_include(<OpenMesh/Core/IO/MeshIO.hh>)
#include <OpenMesh/Core/IO/MeshIO.hh>

#include "gelight/views/openmesh.hpp"
#define GELIGHT_READS_MESHES
#endif

namespace {

using namespace pareto;
using Distances = std::vector<double>;
using Query = std::function<Distances(Index)>;

/// One way to compute distances: a method, one setting of its dial, and the mean error beyond which
/// it is wrong on any of the meshes.
struct Dial {
  std::string method, setting;
  double wrong_beyond;
  std::function<Query(const Mesh<double>&)> make;
  std::function<void(benchmark::State&, const Mesh<double>&)> count = {};
};

template <class Solver>
Query query_of(Solver made) {
  auto solver = std::make_shared<const Solver>(std::move(made));
  return [solver](Index source) { return solver->distance(source); };
}

Dial dijkstra(Index steiner_points) {
  return {"Dijkstra", "steiner " + std::to_string(steiner_points), 1.0,
          [=](const Mesh<double>& mesh) {
            return query_of(DijkstraSolver(mesh, {.steiner_points = steiner_points}));
          }};
}

Dial heat(const std::string& setting, const HeatOptions& options) {
  return {"heat", setting, 1.0,
          [=](const Mesh<double>& mesh) { return query_of(HeatSolver(mesh, options)); },
          [=](benchmark::State& state, const Mesh<double>& mesh) {
            const HeatSolver solver(mesh, options);
            state.counters["fill"] =
                2.0 * static_cast<double>(solver.system()->dissection->value_count());
            state.counters["iterations"] = static_cast<double>(options.refinements);
          }};
}

void count_windows(benchmark::State& state, const Mesh<double>& mesh) {
  const Surface<double> surface(mesh);
  const gelight::detail::PlanarFaces faces(surface);
  gelight::detail::WindowPropagation propagation;
  propagation.run(surface, faces, {{vertex_point<double>(sources[0]), 0}}, {});
  state.counters["windows"] = static_cast<double>(propagation.counts.created);
}

Dial planner(double tolerance) {
  char setting[32];
  std::snprintf(setting, sizeof setting, "tolerance %g", tolerance);
  return {"planner", setting, 1.0, [=](const Mesh<double>& mesh) {
            auto made = std::make_shared<const DistancePlanner<double>>(
                mesh, PlanRequest{.tolerance = tolerance, .assurance = Assurance::expected});
            return Query([made](Index source) { return made->distance(source).distances; });
          }};
}

std::vector<Dial> dials() {
  std::vector<Dial> all;
  for (const Index points : {0, 1, 2, 5}) all.push_back(dijkstra(points));
  all.push_back({"fast marching", "default", 0.02,
                 [](const Mesh<double>& mesh) { return query_of(FastMarchingSolver(mesh)); }});
  all.push_back({"virtual source", "default", 0.03,
                 [](const Mesh<double>& mesh) { return query_of(VirtualSourceSolver(mesh)); }});
  all.push_back(heat("default", {}));
  all.push_back(heat("heat alone", {.exact_radius = 0}));
  all.push_back(heat("refined once", {.refinements = 1}));
  all.push_back(heat("intrinsic Delaunay", {.intrinsic_delaunay = true}));
  all.push_back({"exact", "default", 1e-12,
                 [](const Mesh<double>& mesh) { return query_of(ExactSolver(mesh)); },
                 count_windows});
  for (const double tolerance : {0.1, 0.01, 1e-3, 1e-4, 1e-6}) all.push_back(planner(tolerance));
  return all;
}

void measure(benchmark::State& state, const Case& on, const Dial& dial) {
  const PeakMemory memory;
  Query query;
  const double setup = seconds([&] { query = dial.make(on.mesh); });
  Distances distances;
  const double first = seconds([&] { distances = query(sources[0]); });
  std::vector<double> times;
  Errors errors, smooth;
  for (auto _ : state) {
    const std::size_t which = times.size() % sources.size();
    times.push_back(seconds([&] { distances = query(sources[which]); }));
    state.SetIterationTime(times.back());
    if (times.size() > sources.size()) continue;  // the same answers again
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
  if (dial.count) dial.count(state, on.mesh);
  if (!(errors.mean() <= dial.wrong_beyond)) state.SkipWithError("the distances are wrong");
}

// Certified bounds given fast marching: time, and the gap between them as the error.
void certify(benchmark::State& state, const Case& on) {
  const PeakMemory memory;
  std::optional<Certifier<double>> certifier;
  const double setup = seconds([&] { certifier.emplace(on.mesh); });
  const FastMarchingSolver solver(on.mesh);
  std::vector<double> times;
  Errors gap;
  bool holds = true;
  for (auto _ : state) {
    const std::size_t which = times.size() % sources.size();
    const Distances given = solver.distance(sources[which]);
    DistanceBounds<double> bounds;
    times.push_back(seconds([&] { bounds = certifier->bounds(sources[which], given); }));
    state.SetIterationTime(times.back());
    if (times.size() > sources.size()) continue;
    const Distances& exact = on.exact[which];
    Distances ends(exact.size());
    for (std::size_t v = 0; v < exact.size(); ++v) {
      holds &= bounds.lower[v] <= exact[v] && exact[v] <= bounds.upper[v];
      ends[v] = exact[v] + bounds.upper[v] - bounds.lower[v];
    }
    gap.add(ends, exact);
  }
  state.counters["peak_MB"] = memory.megabytes();
  state.counters["vertices"] = static_cast<double>(on.mesh.positions.size());
  state.counters["setup_s"] = setup;
  state.counters["median_s"] = median(times);
  gap.report(state, "");
  if (!holds) state.SkipWithError("a bound is wrong");
}

// The planner with all its checks, from mesh to answer, beside the best single method that gives
// the same: the cheapest, set-up and certificate (where one is asked for and reaches the tolerance)
// included, among those whose true error keeps it. `ratio` is the planner's time over that, in
// turns.
void plan(benchmark::State& state, const Case& on, double tolerance, bool certified) {
  const auto run_planner = [&] {
    const DistancePlanner planner(
        on.mesh, {.tolerance = tolerance,
                  .assurance = certified ? Assurance::certified : Assurance::expected});
    return planner.distance(sources[0]);
  };
  struct Choice {
    Dial dial;
    bool certifies;
  };
  const auto run_single = [&](const Choice& choice) {
    const Distances distances = choice.dial.make(on.mesh)(sources[0]);
    if (!choice.certifies) return true;
    const Certifier certifier(on.mesh);
    return certifier.bounds(sources[0], distances).error_of(distances).mean <= tolerance;
  };
  std::vector<Choice> choices;
  std::vector<double> once;
  for (const Dial& dial : dials()) {
    if (dial.method == "planner") continue;
    Errors errors;
    errors.add(dial.make(on.mesh)(sources[0]), on.exact[0]);
    if (errors.mean() > tolerance) continue;
    // Where no certificate reaches the tolerance, the exact solver's word is what there is.
    const Choice choice{dial, certified && dial.method != "exact"};
    bool keeps = false;
    const double time = seconds([&] { keeps = run_single(choice); });
    if (!keeps) continue;
    choices.push_back(choice);
    once.push_back(time);
  }
  // The slow ones are out of the race.
  const double least = *std::min_element(once.begin(), once.end());
  for (std::size_t i = choices.size(); i-- > 0;) {
    if (once[i] > 3 * least) choices.erase(choices.begin() + static_cast<std::ptrdiff_t>(i));
  }
  std::vector<double> ours;
  std::vector<std::vector<double>> theirs(choices.size());
  PlannedDistances<double> answer;
  for (auto _ : state) {
    ours.push_back(seconds([&] { answer = run_planner(); }));
    state.SetIterationTime(ours.back());
    for (std::size_t i = 0; i < choices.size(); ++i) {
      theirs[i].push_back(seconds([&] { run_single(choices[i]); }));
    }
  }
  double best = std::numeric_limits<double>::infinity();
  std::string best_name;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (median(theirs[i]) < best) best_name = choices[i].dial.method;
    best = std::min(best, median(theirs[i]));
  }
  Errors errors;
  errors.add(answer.distances, on.exact[0]);
  errors.report(state, "");
  state.counters["tolerance"] = tolerance;
  state.counters["best_s"] = best;
  state.counters["ratio"] = median(ours) / best;
  state.counters["achieved"] = static_cast<double>(answer.achieved);
  state.SetLabel("chose " + answer.method + ", best " + best_name);
  if (!(errors.mean() <= tolerance)) state.SkipWithError("the tolerance was not kept");
}

#ifdef GELIGHT_READS_MESHES
Case read_case(const std::string& path) {
  OpenMesh::TriMesh_ArrayKernelT<> read;
  if (!OpenMesh::IO::read_mesh(read, path)) throw std::runtime_error("cannot read " + path);
  Mesh<double> mesh;
  using Traits = MeshTraits<OpenMesh::TriMesh_ArrayKernelT<>>;
  for (Index v = 0; v < static_cast<Index>(read.n_vertices()); ++v) {
    const auto p = Traits::position(read, v);
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (Index f = 0; f < static_cast<Index>(read.n_faces()); ++f) {
    mesh.faces.push_back(Traits::face(read, f));
  }
  const auto slash = path.find_last_of('/');
  return {path.substr(slash == std::string::npos ? 0 : slash + 1), std::move(mesh), false, false};
}
#else
Case read_case(const std::string&) { throw std::runtime_error("reading meshes needs OpenMesh"); }
#endif

}  // namespace

int main(int argc, char** argv) {
  static std::vector<Case> cases = procedural_cases();
  static const std::vector<Dial> all = dials();
  const std::string option = "--mesh=";
  for (int i = 1; i < argc; ++i) {
    if (!std::string(argv[i]).starts_with(option)) continue;
    cases.push_back(read_case(argv[i] + option.size()));
    std::copy(argv + i + 1, argv + argc, argv + i);
    --argc, --i;
  }
  using benchmark::kMillisecond;
  using benchmark::RegisterBenchmark;
  for (const Case& on : cases) {
    for (const Dial& dial : all) {
      const std::string name = "distance/" + on.name + "/" + dial.method + "/" + dial.setting;
      RegisterBenchmark(name.c_str(), [&](benchmark::State& state) { measure(state, on, dial); })
          ->UseManualTime()
          ->Unit(kMillisecond);
    }
    RegisterBenchmark(("certify/" + on.name).c_str(),
                      [&](benchmark::State& state) { certify(state, on); })
        ->UseManualTime()
        ->Unit(kMillisecond);
    for (const double tolerance : {0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6}) {
      for (const bool certified : {false, true}) {
        const std::string name = std::string("plan/") + on.name +
                                 (certified ? "/certified/" : "/expected/") +
                                 std::to_string(tolerance);
        RegisterBenchmark(
            name.c_str(),
            [=, &on](benchmark::State& state) { plan(state, on, tolerance, certified); })
            ->UseManualTime()
            ->Iterations(3)
            ->Unit(kMillisecond);
      }
    }
  }
  return run(argc, argv);
}
