// The heat method: set-up, beside Eigen's own factorisation of the same two matrices, and queries
// with the error each option leaves. A wrong answer is an error.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "gelight/geodesic/distance_rows.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/heat_engine.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/timing.hpp"

namespace {

using namespace gelight;

void heat_setup(benchmark::State& state) {
  const auto mesh = icosphere<double>(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(HeatSolver(mesh));
  state.counters["vertices"] = static_cast<double>(mesh.positions.size());
}
BENCHMARK(heat_setup)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

// What the two factorisations alone cost in Eigen, which orders by minimum degree.
void heat_setup_eigen(benchmark::State& state) {
  const Surface surface(icosphere<double>(static_cast<int>(state.range(0))));
  const detail::HeatSystem<double> system(surface, 1, false);
  using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;
  const auto& pattern = *system.pattern;
  const Sparse matrix =
      Eigen::Map<const Sparse>(pattern.size(), pattern.size(), pattern.entry_count(),
                               pattern.begins(), pattern.rows(), system.heat.values.data());
  for (auto _ : state) {
    for (int i = 0; i < 2; ++i) {
      const Eigen::SimplicialLDLT<Sparse> factor(matrix);
      benchmark::DoNotOptimize(&factor);
    }
  }
}
BENCHMARK(heat_setup_eigen)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

// Argument 1 chooses the options: heat alone, the default, one refinement.
void heat_query(benchmark::State& state) {
  const auto mesh = icosphere<double>(static_cast<int>(state.range(0)));
  HeatOptions options;
  if (state.range(1) == 0) options.exact_radius = 0;
  if (state.range(1) == 2) options.refinements = 1;
  const HeatSolver solver(mesh, options);
  const Index source = 130;
  std::vector<double> distance(mesh.positions.size());
  for (auto _ : state) solver.distance_into(distance, source);

  const auto at = [&](std::size_t v) {
    return Vec3<double>(mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
  };
  const Vec3<double> s = at(source);
  double mean = 0, max = 0;
  for (std::size_t v = 0; v < distance.size(); ++v) {
    if (v == static_cast<std::size_t>(source)) continue;
    const double truth = std::atan2(s.cross(at(v)).norm(), s.dot(at(v)));
    const double error = std::abs(distance[v] / truth - 1);
    mean += error / static_cast<double>(distance.size() - 1);
    max = std::max(max, error);
  }
  state.counters["mean_%"] = 100 * mean;
  state.counters["max_%"] = 100 * max;
  if (mean > 0.02 || max > 0.2) state.SkipWithError("the distance is wrong");
}
BENCHMARK(heat_query)->ArgsProduct({{5, 6, 7}, {0, 1, 2}})->Unit(benchmark::kMillisecond);

// Rows of distances from 32 sources, how many times faster than a query each: on one thread, where
// several sources read the factors once (not where the compiler may fuse multiplications with
// additions), and two threads to one. Argument 0: the GelTip's membrane, finely meshed; 1: a
// sphere.
void heat_rows(benchmark::State& state) {
  const auto mesh =
      state.range(0) == 0 ? membrane<double>(0.01146, 0.0455, 0.0004) : icosphere<double>(6);
  const HeatSolver solver(mesh);
  std::vector<Index> sources;
  for (std::size_t k = 1; k <= 32; ++k) {
    sources.push_back(static_cast<Index>(k * 104729 % mesh.positions.size()));
  }
  const auto rows = [&](unsigned threads) {
    return distance_matrix(solver, std::span<const Index>(sources), {.threads = threads});
  };
  std::vector<double> alone, one, two;
  for (auto _ : state) {
    std::vector<double> expected, found;
    alone.push_back(bench::seconds([&] {
      for (const Index source : sources) {
        const auto distance = solver.distance(source);
        expected.insert(expected.end(), distance.begin(), distance.end());
      }
    }));
    one.push_back(bench::seconds([&] { found = rows(1); }));
    if (found != expected) return state.SkipWithError("rows differ from single answers");
    two.push_back(bench::seconds([&] { found = rows(2); }));
    if (found != expected) return state.SkipWithError("rows differ from single answers");
    state.SetIterationTime(one.back());
  }
  state.counters["vertices"] = static_cast<double>(mesh.positions.size());
  state.counters["times_faster"] = bench::median(alone) / bench::median(one);
  state.counters["by_two_threads"] = bench::median(one) / bench::median(two);
}
BENCHMARK(heat_rows)->DenseRange(0, 1)->UseManualTime()->MinTime(1)->Unit(benchmark::kMillisecond);

}  // namespace
