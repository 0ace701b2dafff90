// Why there is no CHOLMOD behind the heat method: its supernodal factorisation of the two matrices,
// ordered once, beside our own. (With the distribution's reference BLAS; an optimised one brings it
// nearer.) A wrong factor is an error.

#include <benchmark/benchmark.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/shapes.hpp"

namespace {

using namespace gelight;
using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;

// Argument 0: a membrane of 14,000 vertices, else the icosphere of this level.
Surface<double> surface_of(const benchmark::State& state) {
  if (state.range(0) == 0) return Surface<double>(membrane<double>(0.01146, 0.0455, 0.00052));
  return Surface<double>(icosphere<double>(static_cast<int>(state.range(0))));
}

Sparse sparse(const detail::SymmetricMatrix<double>& matrix) {
  const auto& pattern = *matrix.pattern;
  return Eigen::Map<const Sparse>(pattern.size(), pattern.size(), pattern.entry_count(),
                                  pattern.begins(), pattern.rows(), matrix.values.data());
}

void own(benchmark::State& state) {
  const auto surface = surface_of(state);
  for (auto _ : state) {
    const detail::HeatSystem system(surface, 1, false);
    benchmark::DoNotOptimize(&system.heat_factor());
    benchmark::DoNotOptimize(&system.poisson_factor());
  }
  state.counters["vertices"] = surface.vertex_count();
}
BENCHMARK(own)->Arg(0)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

void cholmod(benchmark::State& state) {
  const auto surface = surface_of(state);
  const detail::HeatSystem system(surface, 1, false);
  const Sparse matrix = sparse(system.heat);
  Eigen::CholmodSupernodalLLT<Sparse, Eigen::Lower> factor;
  for (auto _ : state) {
    factor.analyzePattern(matrix);
    factor.factorize(matrix);
    factor.factorize(matrix);  // the second matrix has the same pattern and costs the same
  }
  detail::Array<double> load(static_cast<std::size_t>(surface.vertex_count()), 0);
  load[0] = 1;
  const auto expected = system.heat_factor().solve(load);
  const Eigen::VectorXd found = factor.solve(Eigen::VectorXd::Unit(surface.vertex_count(), 0));
  double off = 0;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    off = std::max(off, std::abs(found[v] - expected[v]) / expected[0]);
  }
  if (!(off < 1e-12)) state.SkipWithError("the factors disagree");
}
BENCHMARK(cholmod)->Arg(0)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

}  // namespace
