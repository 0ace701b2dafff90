// Exact solves: time, windows and what each one costs, peak error. A wrong answer is an error.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/spheres.hpp"

namespace {

using namespace gelight;

Mesh<double> sphere(int level) { return icosphere<double>(level); }

/// A sphere of 38,002 vertices on so many meridians, with needles about the poles.
Mesh<double> needles(int meridians) { return bench::needle_sphere(meridians, 38000 / meridians); }

/// The GelTip membrane, of about 14,000 vertices when edges are 0.57 mm.
Mesh<double> gel(int) { return membrane<double>(0.01146, 0.0455, 0.00057); }

/// A flat sheet: every angle is exactly flat.
Mesh<double> sheet(int n) { return grid<double>(n, n); }

// By how much going there and going back differ, relative; or the error where it is known.
double error_of(const Mesh<double>& mesh, const ExactSolver<double>& solver,
                const std::vector<double>& d, bool is_flat) {
  const auto far = static_cast<Index>(d.size() / 2);
  const double there = d[static_cast<std::size_t>(far)];
  if (is_flat) {
    const auto& p = mesh.positions[static_cast<std::size_t>(far)];
    return std::fabs(there / std::hypot(p[0], p[1]) - 1);
  }
  return std::fabs(solver.distance(far)[0] / there - 1);
}

void solve(benchmark::State& state, Mesh<double> (*make)(int)) {
  const Mesh<double> mesh = make(static_cast<int>(state.range(0)));
  const Surface<double> surface(mesh);
  const detail::PlanarFaces<double> faces(surface);
  const detail::Sources sources{{vertex_point<double>(0), 0}};
  detail::WindowPropagation<double> propagation;
  for (auto _ : state) propagation.run(surface, faces, sources, {});
  const ExactSolver solver(mesh);
  const double error = error_of(mesh, solver, solver.distance(0), make == sheet);
  if (!(error < 1e-11)) state.SkipWithError("wrong distance");
  const auto& counts = propagation.counts;
  state.counters["vertices"] = static_cast<double>(mesh.positions.size());
  state.counters["error"] = error;
  state.counters["created"] = static_cast<double>(counts.created);
  state.counters["propagated"] = static_cast<double>(counts.propagated);
  state.counters["lists"] = static_cast<double>(counts.lists);
  state.counters["s_per_window"] = benchmark::Counter(
      static_cast<double>(counts.created),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(solve, sphere, sphere)->Arg(5)->Arg(6)->Arg(7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, rough, bench::noisy_sphere)->Arg(5)->Arg(6)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, needles, needles)->Arg(380)->Arg(1900)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, membrane, gel)->Arg(0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(solve, sheet, sheet)->Arg(200)->Unit(benchmark::kMillisecond);

// The direction of arrival at many points inside faces, from mesh to directions: a light field of
// one LED. With windows kept in the targets' faces, or in all.
void directions(benchmark::State& state) {
  const Mesh<double> mesh = gel(0);
  std::mt19937 random(2);
  std::uniform_int_distribution<Index> face(0, static_cast<Index>(mesh.faces.size()) - 1);
  ExactOptions<double> options;
  options.keep_windows = state.range(1) != 0;
  std::vector<SurfacePoint<double>> points;
  for (int i = 0; i < state.range(0); ++i) {
    points.push_back(face_point<double>(face(random), {0.2, 0.3, 0.5}));
  }
  if (!options.keep_windows) options.targets = points;
  Vec3<double> sum(0, 0, 0);
  for (auto _ : state) {
    const auto field = ExactSolver(mesh).solve(Index{0}, options);
    for (const auto& point : points) sum += field.direction(point);
  }
  benchmark::DoNotOptimize(sum);
  const auto field = ExactSolver(mesh).solve(Index{0}, options);
  double error = 0;
  const Surface surface(mesh);
  for (const auto& point : points) {
    error =
        std::max(error, std::fabs(length(surface, field.path(point)) / field.distance(point) - 1));
  }
  state.counters["error"] = error;
  if (!(error < 1e-12)) state.SkipWithError("a path is not as long as its distance");
}
BENCHMARK(directions)
    ->ArgNames({"points", "all_windows"})
    ->Args({11288, 0})
    ->Args({11288, 1})
    ->Args({200000, 1})
    ->Unit(benchmark::kMillisecond);

// Several sources at once, each on a thread of its own.
void threads(benchmark::State& state) {
  const ExactSolver solver(sphere(5));
  const auto count = static_cast<Index>(state.range(0));
  std::vector<std::vector<double>> out(static_cast<std::size_t>(count));
  for (auto _ : state) {
    std::vector<std::thread> running;
    for (Index i = 0; i < count; ++i) {
      running.emplace_back([&, i] { out[static_cast<std::size_t>(i)] = solver.distance(100 * i); });
    }
    for (auto& thread : running) thread.join();
  }
  for (Index i = 0; i < count; ++i) {
    if (out[static_cast<std::size_t>(i)] != solver.distance(100 * i))
      state.SkipWithError("differs");
  }
  state.counters["error"] = 0;
  state.counters["solves"] =
      benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(threads)->Arg(1)->Arg(2)->Arg(4)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
