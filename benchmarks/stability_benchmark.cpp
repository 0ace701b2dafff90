// Where each distance solver breaks: error against the shape of the triangles, four ways to spoil
// the same sheet of 40 x 40 cells. Charted by plot/charts.py.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"

namespace {

using namespace gelight;
using Sheet = Mesh<double>;
constexpr Index cells = 40;
constexpr Index source = cells / 2 * (cells + 1) + cells / 2;

/// A square sheet whose inner vertices are moved by up to 0.2 of a cell, so that nothing ties.
Sheet sheet() {
  auto mesh = grid<double>(cells, cells, cells, cells);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> offset(-0.2, 0.2);
  for (auto& [x, y, z] : mesh.positions) {
    const bool is_inner = x > 0 && y > 0 && x < cells && y < cells;
    if (!is_inner) continue;
    x += offset(random);
    y += offset(random);
  }
  return mesh;
}

Sheet stretched(double aspect) {
  auto mesh = sheet();
  for (auto& p : mesh.positions) p[0] *= aspect;
  return mesh;
}

/// Slanted, so that half the angles come near to pi.
Sheet sheared(double slope) {
  auto mesh = sheet();
  for (auto& p : mesh.positions) p[0] += slope * p[1];
  return mesh;
}

/// Columns whose widths grow evenly to `ratio` times the first.
Sheet graded(double ratio) {
  auto mesh = sheet();
  const double rate = std::log(ratio) / cells;
  for (auto& p : mesh.positions) p[0] = rate > 0 ? std::expm1(rate * p[0]) / rate : p[0];
  return mesh;
}

/// Heights at random, in cells.
Sheet rough(double height) {
  auto mesh = sheet();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> offset(-height, height);
  for (auto& p : mesh.positions) p[2] += offset(random);
  return mesh;
}

std::vector<double> straight(const Sheet& mesh) {
  const auto& s = mesh.position(source);
  std::vector<double> out;
  for (const auto& p : mesh.positions) {
    out.push_back(std::hypot(p[0] - s[0], p[1] - s[1], p[2] - s[2]));
  }
  return out;
}

struct Method {
  std::string name;
  std::function<std::vector<double>(const Sheet&)> distance;
};
const std::vector<Method> methods{
    {"Dijkstra", [](const Sheet& m) { return DijkstraSolver(m).distance(source); }},
    {"fast marching", [](const Sheet& m) { return FastMarchingSolver(m).distance(source); }},
    {"virtual source", [](const Sheet& m) { return VirtualSourceSolver(m).distance(source); }},
    {"heat", [](const Sheet& m) { return HeatSolver(m).distance(source); }},
    {"heat, intrinsic Delaunay",
     [](const Sheet& m) {
       return HeatSolver(m, HeatOptions{.intrinsic_delaunay = true}).distance(source);
     }},
    {"exact", [](const Sheet& m) { return ExactSolver(m).distance(source); }}};

/// A way to spoil the sheet, how far it is driven, and what is true there: flat sheets are
/// measured against straight lines, rough ones against the exact solver.
struct Spoiling {
  std::string name;
  Sheet (*make)(double);
  std::vector<double> degrees;
  bool is_flat;
};
const std::vector<Spoiling> spoilings{{"aspect", stretched, {1, 10, 100, 1e3, 1e4, 1e5, 1e6}, true},
                                      {"obtuse", sheared, {0, 1, 3, 10, 30, 100, 300, 1000}, true},
                                      {"graded", graded, {1, 10, 100, 1e3, 1e4, 1e5, 1e6}, true},
                                      {"rough", rough, {0.03, 0.1, 0.3, 1, 3, 10}, false}};

void measure(benchmark::State& state, const Method& method, const Spoiling& spoiling,
             double degree) {
  const Sheet mesh = spoiling.make(degree);
  const auto truth = spoiling.is_flat ? straight(mesh) : ExactSolver(mesh).distance(source);
  std::vector<double> distance;
  for (auto _ : state) distance = method.distance(mesh);
  double sum = 0, most = 0;
  bool is_finite = true;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    is_finite = is_finite && std::isfinite(distance[v]);
    if (truth[v] == 0) continue;
    const double off = std::fabs(distance[v] - truth[v]) / truth[v];
    sum += off;
    most = std::max(most, off);
  }
  state.counters["degree"] = degree;
  state.counters["mean"] = sum / static_cast<double>(truth.size() - 1);
  state.counters["most"] = most;
  if (!is_finite) state.SkipWithError("a distance that is not finite");
  // Rounding, times the aspect ratio of the triangles.
  if (method.name == "exact" && most > 1e-14 * std::max(10.0, degree)) {
    state.SkipWithError("the exact distance is not exact");
  }
}

const bool registered = [] {
  for (const Spoiling& spoiling : spoilings) {
    for (const Method& method : methods) {
      if (!spoiling.is_flat && method.name == "exact") continue;
      for (const double degree : spoiling.degrees) {
        const std::string name =
            "stability/" + spoiling.name + "/" + method.name + "/" + std::to_string(degree);
        benchmark::RegisterBenchmark(name.c_str(), [&spoiling, &method, degree](auto& state) {
          measure(state, method, spoiling, degree);
        })->Unit(benchmark::kMillisecond);
      }
    }
  }
#if defined(__clang__)
  benchmark::AddCustomContext("compiler", "clang++ " __clang_version__);
#else
  benchmark::AddCustomContext("compiler", "g++ " __VERSION__);
#endif
  benchmark::AddCustomContext("flags", GELIGHT_FLAGS);
  return true;
}();

}  // namespace
