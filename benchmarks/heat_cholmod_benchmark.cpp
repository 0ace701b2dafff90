// The heat method with our own factors, and with CHOLMOD's for them: set-up and a query. (CHOLMOD
// with the distribution's reference BLAS; an optimised one brings it nearer.) A wrong answer is an
// error.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/cholmod.hpp"
#include "gelight/mesh/shapes.hpp"

namespace {

using namespace gelight;

// Argument 0: a membrane of 14,000 vertices, else the icosphere of this level.
Surface<double> surface_of(const benchmark::State& state) {
  if (state.range(0) == 0) return Surface<double>(membrane<double>(0.01146, 0.0455, 0.00052));
  return Surface<double>(icosphere<double>(static_cast<int>(state.range(0))));
}

void setup(benchmark::State& state, LinearBackend<double> backend) {
  const auto surface = surface_of(state);
  for (auto _ : state) benchmark::DoNotOptimize(HeatSolver(surface, {.backend = backend}));
  state.counters["vertices"] = surface.vertex_count();
}

void query(benchmark::State& state, LinearBackend<double> backend) {
  const auto surface = surface_of(state);
  const HeatSolver solver(surface, {.backend = backend});
  std::vector<double> distance;
  for (auto _ : state) distance = solver.distance(130);
  const auto expected = HeatSolver(surface).distance(130);
  double off = 0, largest = 0;
  for (std::size_t v = 0; v < distance.size(); ++v) {
    off = std::max(off, std::abs(distance[v] - expected[v]));
    largest = std::max(largest, expected[v]);
  }
  if (!(off < 1e-9 * largest)) state.SkipWithError("the distances disagree");
}

BENCHMARK_CAPTURE(setup, own, nullptr)->Arg(0)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, cholmod, cholmod_backend)
    ->Arg(0)
    ->DenseRange(5, 7)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(query, own, nullptr)->Arg(0)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(query, cholmod, cholmod_backend)
    ->Arg(0)
    ->DenseRange(5, 7)
    ->Unit(benchmark::kMillisecond);

}  // namespace
