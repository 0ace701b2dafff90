// Speed against accuracy: every distance solver with its dials on meshes of every kind, time and
// error from the same runs. A wrong answer is an error.
//
// pareto_benchmark [--mesh=FILE] [--quick] adds a mesh of the user's, FILE, which is read by
// OpenMesh; --quick: less patience with the planner. Counters:
// setup_s, first_s (the first query, which makes what is made late), the time itself: a further
// query; mean, p99, max: relative error against the exact polyhedral distance; smooth_*: against
// the great circle, of which the smooth solver knows more than the mesh does; floor: 0.10 (kappa
// h)^2 of the mesh; peak_MB: beyond the mesh; windows: of an exact solve; fill: numbers in a heat
// solver's two factors; iterations: its refinements.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/heat_engine.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/planning/target_search.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "support/pareto.hpp"

#if __has_include(<OpenMesh/Core/IO/MeshIO.hh>)
#include "../examples/support/mesh_file.hpp"
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
  std::function<void(benchmark::State&, const Case&)> count = {};
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
          [=](benchmark::State& state, const Case& on) {
            const HeatSolver solver(on.mesh, options);
            state.counters["fill"] =
                2.0 * static_cast<double>(solver.system()->dissection()->value_count());
            state.counters["iterations"] = static_cast<double>(options.refinements);
          }};
}

void count_windows(benchmark::State& state, const Case& on) {
  const Surface<double> surface(on.mesh);
  const gelight::detail::PlanarFaces<double> faces(surface);
  gelight::detail::WindowPropagation<double> propagation;
  propagation.run(surface, faces, {{vertex_point<double>(on.sources[0]), 0}}, {});
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
  all.push_back(heat("own triangles", {.intrinsic_delaunay = false}));
  for (const int radius : {2, 8, 32}) all.push_back(resets(radius));
  all.push_back({"exact", "default", 1e-12,
                 [](const Mesh<double>& mesh) { return query_of(ExactSolver(mesh)); },
                 count_windows});
  return all;
}

/// Distances on the smooth surface, where that is known: normals fitted to the mesh, and given.
std::vector<Dial> smooth_dials() {
  const auto given = [](const Mesh<double>& sphere) {
    return query_of(SmoothDistanceSolver<double>(sphere, sphere.positions));
  };
  const auto fitted = [](const Mesh<double>& sphere) {
    return query_of(SmoothDistanceSolver<double>(sphere));
  };
  return {{"smooth", "normals from the mesh", 0.02, fitted},
          {"smooth", "normals given", 0.02, given}};
}

std::string in_digits(double number) {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%.3g", number);
  return digits.data();
}

void measure(benchmark::State& state, const Case& on, const Dial& dial) {
  const PeakMemory memory;
  Query query;
  Distances distances;
  std::vector<double> setups, firsts, times;
  for (int i = 0; i < 5; ++i) {
    query = nullptr;
    setups.push_back(seconds([&] { query = dial.make(on.mesh); }));
    firsts.push_back(seconds([&] { distances = query(on.sources[0]); }));
  }
  Errors errors, smooth;
  for (auto _ : state) {
    const std::size_t which = times.size() % on.sources.size();
    times.push_back(seconds([&] { distances = query(on.sources[which]); }));
    state.SetIterationTime(times.back());
    if (times.size() > on.sources.size()) continue;  // the same answers again
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
  if (dial.count) dial.count(state, on);
  if (on.is_known && !(errors.mean() <= dial.wrong_beyond)) {
    const std::string words = "the distances are wrong: their mean error is " +
                              in_digits(errors.mean()) + ", the limit " +
                              in_digits(dial.wrong_beyond);
    state.SkipWithError(words.c_str());
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
    const std::size_t which = times.size() % on.sources.size();
    const Distances given = solver.distance(on.sources[which]);
    DistanceBounds<double> bounds;
    times.push_back(seconds([&] { bounds = certifier->bounds(on.sources[which], given); }));
    state.SetIterationTime(times.back());
    if (times.size() > on.sources.size()) continue;
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

// --- the planner ---------------------------------------------------------------------------------

/// How far an answer's error shall be known, and what gives that to a method's distances: nothing;
/// four targets checked exactly; a certificate, or the four targets where the method is exact.
struct Promise {
  const char* name;
  Assurance assurance;
};
constexpr std::array<Promise, 3> promises{{{"expected", Assurance::expected},
                                           {"sampled", Assurance::sampled},
                                           {"certified", Assurance::certified}}};

/// Turns that the planner and the best methods take, and vertices from which these have to keep the
/// tolerance.
struct Patience {
  int turns = 3;
  Index vertices = 12;
};
constexpr Patience little_patience{1, 4};

double sampled_error(const Case& on, Index source, const Distances& distances, double width) {
  const Surface<double> surface(on.mesh);
  const gelight::detail::PlanarFaces<double> faces(surface);
  const gelight::detail::TargetSearch<double> search(
      surface, faces, {{vertex_point<double>(source), 0}}, distances);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto v = (2 * i + 1) * distances.size() / 8;
    sum += std::abs(distances[v] / search.exact(static_cast<Index>(v), distances[v], width) - 1);
  }
  return sum / 4;
}

double proved_error(const Case& on, Index source, const Distances& distances) {
  return Certifier(on.mesh).bounds(source, distances).error_of(distances).mean;
}

/// A method by itself on one mesh: the largest mean error from any of some vertices, first to last,
/// and the largest that a certificate proves.
struct Single {
  const Dial* dial;
  double seconds = 0, error = 0, proved = 0;

  [[nodiscard]] bool is_exact() const { return dial->method == "exact"; }
  [[nodiscard]] bool keeps(double tolerance, Assurance assurance) const {
    return (assurance == Assurance::certified && !is_exact() ? proved : error) <= tolerance;
  }
};

/// Those that answer sooner than the exact solver, and that one; by the time from mesh to answer.
std::vector<Single> singles_on(const Case& on, const std::vector<Dial>& all,
                               const Patience& patience) {
  std::vector<Single> singles;
  double exact_seconds = 0;
  for (const Dial& dial : all) {
    std::vector<double> times;
    for (int i = 0; i < patience.turns; ++i) {
      times.push_back(seconds([&] { (void)dial.make(on.mesh)(on.sources[0]); }));
    }
    singles.push_back({&dial, median(times)});
    if (singles.back().is_exact()) exact_seconds = singles.back().seconds;
  }
  std::erase_if(singles, [&](const Single& s) { return s.seconds > exact_seconds; });
  std::sort(singles.begin(), singles.end(),
            [](const Single& a, const Single& b) { return a.seconds < b.seconds; });
  const auto n = static_cast<Index>(on.mesh.positions.size());
  const ExactSolver<double> exact(on.mesh);
  const Certifier<double> certifier(on.mesh);
  std::vector<Query> queries;
  for (const Single& single : singles) queries.push_back(single.dial->make(on.mesh));
  for (Index i = 0; i < patience.vertices; ++i) {
    const Index source = i * (n - 1) / (patience.vertices - 1);
    const Distances truth = exact.distance(source);
    for (std::size_t k = 0; k < singles.size(); ++k) {
      if (singles[k].is_exact()) continue;
      const Distances distances = queries[k](source);
      Errors errors;
      errors.add(distances, truth);
      singles[k].error = std::max(singles[k].error, errors.mean());
      const auto bounds = certifier.bounds(source, distances);
      singles[k].proved = std::max(singles[k].proved, bounds.error_of(distances).mean);
    }
  }
  return singles;
}

/// The planner with all its checks, from mesh to answer, beside the best single method that gives
/// the same promise, set-up and checks included: in hindsight the cheapest that keeps the tolerance
/// from wherever on the mesh, as the planner has to, and in its own checks. `ratio` is the
/// planner's time over that, measured in turns.
void plan(benchmark::State& state, const Case& on, const std::vector<Single>& singles,
          double tolerance, Assurance assurance) {
  // Answers, and returns the error that the checks find.
  const auto answer_by = [&](const Single& single) {
    const Distances distances = single.dial->make(on.mesh)(on.sources[0]);
    if (assurance == Assurance::expected) return 0.0;
    if (assurance == Assurance::certified && !single.is_exact()) {
      return proved_error(on, on.sources[0], distances);
    }
    const double width = single.is_exact() ? 1e-9 : std::min(0.05, 4 * tolerance);
    return sampled_error(on, on.sources[0], distances, width);
  };
  std::vector<const Single*> choices;
  for (const Single& single : singles) {
    const bool is_in_race =
        choices.size() < 2 || (single.is_exact() && assurance != Assurance::expected);
    if (!is_in_race || !single.keeps(tolerance, assurance)) continue;
    const bool has_to_show = assurance == Assurance::sampled && !single.is_exact();
    if (!has_to_show || answer_by(single) <= tolerance) choices.push_back(&single);
  }
  const PlanRequest request{.tolerance = tolerance, .assurance = assurance};
  std::vector<double> ours;
  std::vector<std::vector<double>> theirs(choices.size());
  PlannedDistances<double> answer;
  for (auto _ : state) {
    ours.push_back(
        seconds([&] { answer = DistancePlanner<double>(on.mesh, request).solve(on.sources[0]); }));
    state.SetIterationTime(ours.back());
    for (std::size_t i = 0; i < choices.size(); ++i) {
      theirs[i].push_back(seconds([&] { benchmark::DoNotOptimize(answer_by(*choices[i])); }));
    }
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < choices.size(); ++i) {
    if (median(theirs[i]) < median(theirs[best])) best = i;
  }
  std::vector<double> ratios;
  for (std::size_t k = 0; k < ours.size(); ++k) ratios.push_back(ours[k] / theirs[best][k]);
  Errors errors;
  errors.add(answer.distance, on.exact[0]);
  errors.report(state, "");
  state.counters["tolerance"] = tolerance;
  state.counters["best_s"] = median(theirs[best]);
  state.counters["best_error"] = choices[best]->error;
  state.counters["ratio"] = median(ratios);
  state.counters["achieved"] = static_cast<double>(answer.achieved);
  const Dial& dial = *choices[best]->dial;
  state.SetLabel("chose " + answer.method + ", best " + dial.method +
                 (dial.setting == "default" ? "" : ", " + dial.setting));
  const DistancePlanner<double> planner(on.mesh, request);
  bool is_kept = errors.mean() <= tolerance;
  for (std::size_t i = 1; i < on.sources.size(); ++i) {
    Errors of_source;
    of_source.add(planner.solve(on.sources[i]).distance, on.exact[i]);
    is_kept &= of_source.mean() <= tolerance;
  }
  if (!is_kept) state.SkipWithError("the tolerance was not kept");
}

#ifdef GELIGHT_READS_MESHES
Case read_case(const std::string& path) {
  const auto slash = path.find_last_of('/');
  Case own{path.substr(slash == std::string::npos ? 0 : slash + 1), mesh_of_file(path), false,
           false};
  own.is_known = false;
  return own;
}
#else
Case read_case(const std::string&) { throw std::runtime_error("reading meshes needs OpenMesh"); }
#endif

}  // namespace

int main(int argc, char** argv) try {
  std::vector<Case> own;
  Patience patience;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i], mesh = "--mesh=";
    const bool is_mesh = argument.starts_with(mesh);
    if (!is_mesh && argument != "--quick") continue;
    if (!is_mesh) patience = little_patience;
    try {
      if (is_mesh) own.push_back(read_case(argument.substr(mesh.size())));
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", argument.c_str(), error.what());
      return 2;
    }
    std::copy(argv + i + 1, argv + argc, argv + i);
    --argc, --i;
  }
  static std::vector<Case> cases = procedural_cases();
  cases.insert(cases.end(), own.begin(), own.end());
  static const std::vector<Dial> all = dials();
  static const std::vector<Case> unseen = unseen_cases();
  static std::map<std::string, std::vector<Single>> singles;
  const auto register_plans = [patience](const Case& on, std::vector<Single>& known) {
    for (const double tolerance : {0.1, 0.01, 1e-3, 1e-4, 1e-6}) {
      for (const Promise& promise : promises) {
        const std::string name =
            "plan/" + on.name + "/" + promise.name + "/" + std::to_string(tolerance);
        benchmark::RegisterBenchmark(name.c_str(),
                                     [=, &on, &known](benchmark::State& state) {
                                       if (known.empty()) known = singles_on(on, all, patience);
                                       plan(state, on, known, tolerance, promise.assurance);
                                     })
            ->UseManualTime()
            ->Iterations(patience.turns)
            ->Unit(benchmark::kMillisecond);
      }
    }
  };
  using benchmark::kMillisecond;
  using benchmark::RegisterBenchmark;
  const auto register_dials = [](const Case& on, const std::vector<Dial>& of) {
    for (const Dial& dial : of) {
      const std::string name = "distance/" + on.name + "/" + dial.method + "/" + dial.setting;
      RegisterBenchmark(name.c_str(), [&](benchmark::State& state) { measure(state, on, dial); })
          ->UseManualTime()
          ->Unit(kMillisecond);
    }
  };
  static const std::vector<Dial> on_smooth = smooth_dials();
  for (const Case& on : cases) {
    register_dials(on, all);
    if (!on.smooth.empty()) register_dials(on, on_smooth);
    RegisterBenchmark(("certify/" + on.name).c_str(),
                      [&](benchmark::State& state) { certify(state, on); })
        ->UseManualTime()
        ->Unit(kMillisecond);
    register_plans(on, singles[on.name]);
  }
  for (const Case& on : unseen) register_plans(on, singles[on.name]);
  return run(argc, argv);
} catch (...) {
  return told();
}
