// What heat is off, on spheres and on rough meshes as scanners make them, and whether `solve` says
// so: the figures of the docstrings of HeatSolver and VectorHeatSolver. Argument 0 is the meshes
// (icospheres of levels 3 to 5, scan_meshes(4)), argument 1 the options. The truth is the exact
// solver, whose paths carry the vectors; on spheres it is off itself by less than 0.3 %.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/log_map.hpp"
#include "gelight/transport/parallel.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/scan_meshes.hpp"

namespace {

using namespace gelight;

std::vector<Mesh<double>> meshes(std::int64_t kind) {
  if (kind == 0) return {icosphere<double>(3), icosphere<double>(4), icosphere<double>(5)};
  std::vector<Mesh<double>> all;
  for (auto& [name, mesh] : test::scan_meshes(4)) all.push_back(std::move(mesh));
  return all;
}

HeatOptions options(std::int64_t choice) {
  if (choice == 1) return {.refinements = 1};
  if (choice == 2) return {.intrinsic_delaunay = false};
  if (choice == 3) return {.exact_radius = 0};
  return {};
}

struct Mean {
  double sum = 0, most = 0, count = 0;
  void add(double x) {
    sum += x;
    most = std::max(most, x);
    ++count;
  }
  [[nodiscard]] double value() const { return sum / count; }
};

void heat_error(benchmark::State& state) {
  Mean answers, vertices;
  double off = 0, silent = 0, good = 0, flagged = 0;
  test::Random random(4);
  for (auto _ : state) {
    for (const auto& mesh : meshes(state.range(0))) {
      const ExactSolver exact(mesh);
      const HeatSolver solver(mesh, options(state.range(1)));
      for (int i = 0; i < 30; ++i) {
        const Index source = test::uniform_index(random, static_cast<Index>(mesh.positions.size()));
        const auto truth = exact.distance(source);
        const auto found = solver.solve(source);
        Mean mean;
        for (std::size_t v = 0; v < truth.size(); ++v) {
          if (!(truth[v] > 0 && truth[v] < unreachable<double>)) continue;
          mean.add(std::abs(found.distance[v] / truth[v] - 1));
        }
        answers.add(mean.value());
        vertices.add(mean.most);
        off += mean.value() > 0.1;
        silent += mean.value() > 0.1 && found.is_reliable;
        good += mean.value() < 0.05;
        flagged += mean.value() < 0.05 && !found.is_reliable;
      }
    }
  }
  state.counters["mean_%"] = 100 * answers.value();
  state.counters["worst_mean_%"] = 100 * answers.most;
  state.counters["max_%"] = 100 * vertices.most;
  state.counters["off"] = off;
  state.counters["silent"] = silent;
  state.counters["good"] = good;
  state.counters["flagged"] = flagged;
  if (silent > 0) state.SkipWithError("an answer is off in silence");
}
BENCHMARK(heat_error)
    ->ArgsProduct({{0, 1}, {0, 1, 2, 3}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

// The same of 2 to 8 vertices at once, one of them of a border where there is one.
void heat_of_several_error(benchmark::State& state) {
  Mean answers, vertices;
  double off = 0, silent = 0;
  test::Random random(5);
  for (auto _ : state) {
    for (const auto& mesh : meshes(state.range(0))) {
      const ExactSolver exact(mesh);
      const HeatSolver solver(mesh, options(state.range(1)));
      const Surface<double>& surface = exact.surface();
      std::vector<Index> border;
      for (Index h = 0; h < surface.halfedge_count(); ++h) {
        if (surface.is_border(h)) border.push_back(surface.origin(h));
      }
      for (int i = 0; i < 30; ++i) {
        std::vector<Index> sources(static_cast<std::size_t>(2 + i % 7));
        for (Index& s : sources) s = test::uniform_index(random, surface.vertex_count());
        if (!border.empty()) {
          sources[0] = border[static_cast<std::size_t>(
              test::uniform_index(random, static_cast<Index>(border.size())))];
        }
        const auto truth = exact.distance(sources);
        const auto found = solver.solve(sources);
        Mean mean;
        for (std::size_t v = 0; v < truth.size(); ++v) {
          if (!(truth[v] > 0 && truth[v] < unreachable<double>)) continue;
          mean.add(std::abs(found.distance[v] / truth[v] - 1));
        }
        answers.add(mean.value());
        vertices.add(mean.most);
        off += mean.value() > 0.1;
        silent += mean.value() > 0.1 && found.is_reliable;
      }
    }
  }
  state.counters["mean_%"] = 100 * answers.value();
  state.counters["worst_mean_%"] = 100 * answers.most;
  state.counters["max_%"] = 100 * vertices.most;
  state.counters["off"] = off;
  state.counters["silent"] = silent;
}
BENCHMARK(heat_of_several_error)
    ->ArgsProduct({{0, 1}, {0, 1}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void vector_heat_error(benchmark::State& state) {
  Mean radius, direction, transport;
  double off = 0, silent = 0, good = 0, flagged = 0;
  const auto judge = [&](double error, bool is_reliable) {
    off += error > 0.1;
    silent += error > 0.1 && is_reliable;
    good += error < 0.05;
    flagged += error < 0.05 && !is_reliable;
  };
  test::Random random(4);
  for (auto _ : state) {
    for (const auto& mesh : meshes(state.range(0))) {
      const ExactLogMapSolver exact(mesh);
      const ParallelTransport<double> along(mesh);
      const VectorHeatSolver solver(mesh, {.intrinsic_delaunay = state.range(1) == 0});
      for (int i = 0; i < 3; ++i) {
        const Index source = test::uniform_index(random, static_cast<Index>(mesh.positions.size()));
        const auto truth = exact.solve(source);
        const Vec3<double> x = truth.tangent_basis()[0];
        const auto map = solver.solve_log_map(source);
        const auto carried = solver.solve(source, x);
        Mean off_map, off_carried;
        for (std::size_t v = 0; v < mesh.positions.size(); v += 7) {
          const Vec2<double> at = truth(static_cast<Index>(v)), found = map.coordinates[v];
          if (!(at.norm() > 0 && at.norm() < unreachable<double>)) continue;
          radius.add(std::abs(found.norm() / at.norm() - 1));
          const auto turn = std::complex(found[0], found[1]) / std::complex(at[0], at[1]);
          direction.add(std::abs(std::arg(turn)) * 180 / std::numbers::pi);
          off_map.add(std::min(2.0, (found - at).norm() / at.norm()));
          auto path = truth.field().path(static_cast<Index>(v));
          if (!(path.front() == vertex_point<double>(source)))
            std::reverse(path.begin(), path.end());
          const double off_by = (carried.vectors[v] - along.along(path, x)).norm();
          off_carried.add(off_by);
          transport.add(2 * std::asin(std::min(1.0, off_by / 2)) * 180 / std::numbers::pi);
        }
        judge(off_map.value(), map.is_reliable);
        judge(off_carried.value(), carried.is_reliable);
      }
    }
  }
  state.counters["radius_%"] = 100 * radius.value();
  state.counters["direction_degrees"] = direction.value();
  state.counters["transport_degrees"] = transport.value();
  state.counters["off"] = off;
  state.counters["silent"] = silent;
  state.counters["good"] = good;
  state.counters["flagged"] = flagged;
}
// Argument 1: the intrinsic Delaunay triangulation, the mesh's own triangles.
BENCHMARK(vector_heat_error)
    ->ArgsProduct({{0, 1}, {0, 1}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
