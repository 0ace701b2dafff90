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
#include <map>
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

/// One way to compute distances: a method, one setting of its dial, and when it is wrong: where its
/// mean error on any of the procedural meshes is beyond a limit, or where distances that are
/// lengths of paths are too short.
struct Dial {
  std::string method, setting;
  double wrong_beyond;
  std::function<Query(const Mesh<double>&)> make;
  std::function<void(benchmark::State&, const Mesh<double>&)> count = {};
  bool measures_paths = false;
};

template <class Solver>
Query query_of(Solver made) {
  auto solver = std::make_shared<const Solver>(std::move(made));
  return [solver](Index source) { return solver->distance(source); };
}

Dial dijkstra(Index steiner_points, double wrong_beyond) {
  return {"Dijkstra",
          "steiner " + std::to_string(steiner_points),
          wrong_beyond,
          [=](const Mesh<double>& mesh) {
            return query_of(DijkstraSolver(mesh, {.steiner_points = steiner_points}));
          },
          {},
          true};
}

Dial resets(int radius) {
  return {"exact with resets",
          "radius " + std::to_string(radius),
          0.01,
          [=](const Mesh<double>& mesh) {
            return query_of(ExactSolver(mesh, {.reset_radius = double(radius)}));
          },
          {},
          true};
}

Dial heat(const std::string& setting, const HeatOptions& options) {
  return {"heat", setting, 0.1,
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

std::vector<Dial> dials() {
  std::vector<Dial> all;
  all.push_back(dijkstra(0, 0.2));
  for (const Index points : {1, 2, 5}) all.push_back(dijkstra(points, 0.06));
  all.push_back({"fast marching", "default", 0.005,
                 [](const Mesh<double>& mesh) { return query_of(FastMarchingSolver(mesh)); }});
  all.push_back({"virtual source", "default", 0.01,
                 [](const Mesh<double>& mesh) { return query_of(VirtualSourceSolver(mesh)); }});
  all.push_back(heat("default", {}));
  all.push_back(heat("heat alone", {.exact_radius = 0}));
  all.push_back(heat("refined once", {.refinements = 1}));
  all.push_back(heat("intrinsic Delaunay", {.intrinsic_delaunay = true}));
  for (const int radius : {2, 8, 32}) all.push_back(resets(radius));
  all.push_back({"exact", "default", 1e-12,
                 [](const Mesh<double>& mesh) { return query_of(ExactSolver(mesh)); },
                 count_windows});
  return all;
}

void measure(benchmark::State& state, const Case& on, const Dial& dial) {
  const PeakMemory memory;
  Query query;
  Distances distances;
  std::vector<double> setups, firsts, times;
  for (int i = 0; i < 5; ++i) {
    query = nullptr;
    setups.push_back(seconds([&] { query = dial.make(on.mesh); }));
    firsts.push_back(seconds([&] { distances = query(sources[0]); }));
  }
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
  state.counters["setup_s"] = median(setups);
  state.counters["first_s"] = median(firsts);
  state.counters["median_s"] = median(times);
  state.counters["floor"] = on.floor;
  errors.report(state, "");
  smooth.report(state, "smooth_");
  if (dial.count) dial.count(state, on.mesh);
  if (on.is_known && !(errors.mean() <= dial.wrong_beyond)) {
    state.SkipWithError("the distances are wrong");
  }
  if (dial.measures_paths && errors.has_too_short()) state.SkipWithError("a path is too short");
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

/// A method by itself on one mesh: the largest mean error from any of the sources, the largest that
/// a certificate proves, and the time from mesh to answer without and with it.
struct Single {
  const Dial* dial;
  double error = 0, proved = 0, seconds = 0, seconds_proved = 0;
};

double proved_error(const Case& on, Index source, const Distances& distances) {
  return Certifier(on.mesh).bounds(source, distances).error_of(distances).mean;
}

std::vector<Single> singles_on(const Case& on, const std::vector<Dial>& all) {
  std::vector<Single> singles;
  for (const Dial& dial : all) {
    Single single{&dial};
    Query query;
    Distances distances;
    single.seconds = seconds([&] { distances = (query = dial.make(on.mesh))(sources[0]); });
    single.seconds_proved = single.seconds + seconds([&] { proved_error(on, 0, distances); });
    for (std::size_t i = 0; i < sources.size(); ++i) {
      distances = query(sources[i]);
      Errors errors;
      errors.add(distances, on.exact[i]);
      single.error = std::max(single.error, errors.mean());
      single.proved = std::max(single.proved, proved_error(on, sources[i], distances));
    }
    singles.push_back(single);
  }
  return singles;
}

/// The planner with all its checks, from mesh to answer, beside the best single method that gives
/// the same from each source: the cheapest in hindsight, set-up included, and a certificate where
/// one is asked for and reaches the tolerance; else the exact solver, without any check. `ratio` is
/// the planner's time over that, measured in turns.
void plan(benchmark::State& state, const Case& on, const std::vector<Single>& singles,
          double tolerance, bool certified) {
  const auto time_of = [&](const Single& single) {
    return certified && single.dial->method != "exact" ? single.seconds_proved : single.seconds;
  };
  std::vector<const Single*> choices;
  for (const Single& single : singles) {
    const bool is_exact = single.dial->method == "exact";
    const double known = certified && !is_exact ? single.proved : single.error;
    if (known <= tolerance) choices.push_back(&single);
  }
  std::sort(choices.begin(), choices.end(),
            [&](const Single* a, const Single* b) { return time_of(*a) < time_of(*b); });
  choices.resize(std::min<std::size_t>(choices.size(), 3));  // the others are out of the race
  const PlanRequest request{.tolerance = tolerance,
                            .assurance = certified ? Assurance::certified : Assurance::expected};
  std::vector<double> ours;
  std::vector<std::vector<double>> theirs(choices.size());
  PlannedDistances<double> answer;
  for (auto _ : state) {
    ours.push_back(
        seconds([&] { answer = DistancePlanner<double>(on.mesh, request).distance(sources[0]); }));
    state.SetIterationTime(ours.back());
    for (std::size_t i = 0; i < choices.size(); ++i) {
      const Dial& dial = *choices[i]->dial;
      theirs[i].push_back(seconds([&] {
        const Distances distances = dial.make(on.mesh)(sources[0]);
        if (certified && dial.method != "exact") proved_error(on, sources[0], distances);
      }));
    }
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < choices.size(); ++i) {
    if (median(theirs[i]) < median(theirs[best])) best = i;
  }
  std::vector<double> ratios;
  for (std::size_t k = 0; k < ours.size(); ++k) ratios.push_back(ours[k] / theirs[best][k]);
  Errors errors;
  errors.add(answer.distances, on.exact[0]);
  errors.report(state, "");
  state.counters["tolerance"] = tolerance;
  state.counters["best_s"] = median(theirs[best]);
  state.counters["ratio"] = median(ratios);
  state.counters["achieved"] = static_cast<double>(answer.achieved);
  state.SetLabel("chose " + answer.method + ", best " + choices[best]->dial->method);
  const DistancePlanner<double> planner(on.mesh, request);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    Errors of_source;
    of_source.add(planner.distance(sources[i]).distances, on.exact[i]);
    if (!(of_source.mean() <= tolerance)) state.SkipWithError("the tolerance was not kept");
  }
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
  Case own{path.substr(slash == std::string::npos ? 0 : slash + 1), std::move(mesh), false, false};
  own.is_known = false;
  return own;
}
#else
Case read_case(const std::string&) { throw std::runtime_error("reading meshes needs OpenMesh"); }
#endif

}  // namespace

int main(int argc, char** argv) {
  static std::vector<Case> cases = procedural_cases();
  static const std::vector<Dial> all = dials();
  static std::map<std::string, std::vector<Single>> singles;
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
        RegisterBenchmark(name.c_str(),
                          [=, &on](benchmark::State& state) {
                            auto& known = singles[on.name];
                            if (known.empty()) known = singles_on(on, all);
                            plan(state, on, known, tolerance, certified);
                          })
            ->UseManualTime()
            ->Iterations(5)
            ->Unit(kMillisecond);
      }
    }
  }
  return run(argc, argv);
}
