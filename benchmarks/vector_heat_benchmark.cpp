// The vector heat method: set-up with a first transport and log map, later transport and log map,
// with the angle to parallel transport along great circles. A wrong answer is an error.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/vector_heat.hpp"

namespace {

using namespace gelight;

void vector_heat_setup(benchmark::State& state) {
  const auto mesh = icosphere<double>(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const VectorHeatSolver solver(mesh);  // factors when first asked
    benchmark::DoNotOptimize(solver.transport(0, solver.tangent_basis(0)[0]));
    benchmark::DoNotOptimize(solver.log_map(0));
  }
  state.counters["vertices"] = static_cast<double>(mesh.positions.size());
}
BENCHMARK(vector_heat_setup)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

void transport(benchmark::State& state) {
  const auto mesh = icosphere<double>(static_cast<int>(state.range(0)));
  const VectorHeatSolver solver(mesh);
  const auto at = [&](std::size_t v) {
    return Vec3<double>(mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
  };
  const Index source = 130;
  const Vec3<double> pole = at(source);
  const Vec3<double> start = pole.cross(Vec3<double>(0.3, 1, 0.2)).normalized();
  std::vector<Vec3<double>> carried = solver.transport(source, start);
  for (auto _ : state) carried = solver.transport(source, start);
  double mean = 0, max = 0;
  for (std::size_t v = 0; v < carried.size(); ++v) {
    if ((at(v) + pole).norm() < 1e-9) continue;  // any direction is right at the antipode
    const Vec3<double> truth = Eigen::Quaterniond::FromTwoVectors(pole, at(v)) * start;
    const double angle = std::atan2(truth.cross(carried[v]).norm(), truth.dot(carried[v]));
    mean += angle * 180 / std::numbers::pi / static_cast<double>(carried.size());
    max = std::max(max, angle * 180 / std::numbers::pi);
  }
  state.counters["mean_degrees"] = mean;
  state.counters["max_degrees"] = max;
  if (!(mean < 0.5)) state.SkipWithError("the vectors are wrong");
}
BENCHMARK(transport)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

void log_map(benchmark::State& state) {
  const auto mesh = icosphere<double>(static_cast<int>(state.range(0)));
  const VectorHeatSolver solver(mesh);
  std::vector<Vec2<double>> map = solver.log_map(130);
  for (auto _ : state) map = solver.log_map(130);
  double mean = 0;
  const auto& s = mesh.positions[130];
  for (std::size_t v = 0; v < map.size(); ++v) {
    const auto& p = mesh.positions[v];
    const double cosine = s[0] * p[0] + s[1] * p[1] + s[2] * p[2];
    const double truth = v == 130 ? 0 : std::acos(std::clamp(cosine, -1.0, 1.0));
    if (truth > 0) mean += std::abs(map[v].norm() / truth - 1) / static_cast<double>(map.size());
  }
  state.counters["radius_mean_%"] = 100 * mean;
  if (!(mean < 0.02)) state.SkipWithError("the radius is wrong");
}
BENCHMARK(log_map)->DenseRange(5, 7)->Unit(benchmark::kMillisecond);

}  // namespace
