// Dijkstra, fast marching and virtual sources: time of a query and its error, against the great
// circle on spheres and against exact distances on the GelTip membrane. A wrong answer is an error.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"

namespace {

using namespace gelight;

constexpr Index source = 130;

std::vector<double> great_circle(const Mesh<double>& mesh) {
  const auto at = [&](std::size_t v) {
    return Vec3<double>(mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
  };
  std::vector<double> truth;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    truth.push_back(std::atan2(at(source).cross(at(v)).norm(), at(source).dot(at(v))));
  }
  truth[source] = 0;
  return truth;
}

template <class Solver>
void measure(benchmark::State& state, const Mesh<double>& mesh, const std::vector<double>& truth,
             double largest_mean) {
  const Solver solver(mesh);
  std::vector<double> distance(mesh.positions.size());
  for (auto _ : state) solver.distance_into(distance, source);
  double mean = 0, max = 0;
  for (std::size_t v = 0; v < distance.size(); ++v) {
    if (truth[v] == 0) continue;
    const double error = std::abs(distance[v] / truth[v] - 1);
    mean += error / static_cast<double>(distance.size() - 1);
    max = std::max(max, error);
  }
  state.counters["vertices"] = static_cast<double>(mesh.positions.size());
  state.counters["mean_%"] = 100 * mean;
  state.counters["max_%"] = 100 * max;
  if (!(mean < largest_mean)) state.SkipWithError("the distance is wrong");
}

template <class Solver>
void sphere(benchmark::State& state, double largest_mean) {
  const auto mesh = icosphere<double>(static_cast<int>(state.range(0)));
  measure<Solver>(state, mesh, great_circle(mesh), largest_mean);
}

template <class Solver>
void gel(benchmark::State& state, double largest_mean) {
  const auto mesh = membrane<double>(0.01146, 0.0455, 0.00057);
  measure<Solver>(state, mesh, ExactSolver(mesh).distance(source), largest_mean);
}

void dijkstra(benchmark::State& state) { sphere<DijkstraSolver<double>>(state, 0.1); }
void fast_marching(benchmark::State& state) { sphere<FastMarchingSolver<double>>(state, 2e-3); }
void virtual_source(benchmark::State& state) { sphere<VirtualSourceSolver<double>>(state, 2e-4); }
void dijkstra_gel(benchmark::State& state) { gel<DijkstraSolver<double>>(state, 0.2); }
void fast_marching_gel(benchmark::State& state) { gel<FastMarchingSolver<double>>(state, 2e-3); }
void virtual_source_gel(benchmark::State& state) { gel<VirtualSourceSolver<double>>(state, 4e-3); }

BENCHMARK(dijkstra)->DenseRange(5, 8)->Unit(benchmark::kMillisecond);
BENCHMARK(fast_marching)->DenseRange(5, 8)->Unit(benchmark::kMillisecond);
BENCHMARK(virtual_source)->DenseRange(5, 8)->Unit(benchmark::kMillisecond);
BENCHMARK(dijkstra_gel)->Unit(benchmark::kMillisecond);
BENCHMARK(fast_marching_gel)->Unit(benchmark::kMillisecond);
BENCHMARK(virtual_source_gel)->Unit(benchmark::kMillisecond);

}  // namespace
