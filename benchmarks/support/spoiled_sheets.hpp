#pragma once

// Four ways to spoil the same sheet of 40 x 40 cells, and the error of a method's distances on it.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"

namespace gelight::bench {

using Sheet = Mesh<double>;
inline constexpr Index cells = 40;
inline constexpr Index source = cells / 2 * (cells + 1) + cells / 2;

/// A square sheet whose inner vertices are moved by up to 0.2 of a cell, so that nothing ties.
inline Sheet sheet() {
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

inline Sheet stretched(double aspect) {
  auto mesh = sheet();
  for (auto& p : mesh.positions) p[0] *= aspect;
  return mesh;
}

/// Slanted, so that half the angles come near to pi.
inline Sheet sheared(double slope) {
  auto mesh = sheet();
  for (auto& p : mesh.positions) p[0] += slope * p[1];
  return mesh;
}

/// Columns whose widths grow evenly to `ratio` times the first.
inline Sheet graded(double ratio) {
  auto mesh = sheet();
  const double rate = std::log(ratio) / cells;
  for (auto& p : mesh.positions) p[0] = rate > 0 ? std::expm1(rate * p[0]) / rate : p[0];
  return mesh;
}

/// Heights at random, in cells.
inline Sheet rough(double height) {
  auto mesh = sheet();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> offset(-height, height);
  for (auto& p : mesh.positions) p[2] += offset(random);
  return mesh;
}

inline std::vector<double> straight(const Sheet& mesh) {
  const auto& s = mesh.position(source);
  std::vector<double> out;
  for (const auto& p : mesh.positions) {
    out.push_back(std::hypot(p[0] - s[0], p[1] - s[1], p[2] - s[2]));
  }
  return out;
}

/// A way to spoil the sheet, how far it is driven, and what is true there: flat sheets are
/// measured against straight lines, rough ones against the exact solver.
struct Spoiling {
  std::string name;
  Sheet (*make)(double);
  std::vector<double> degrees;
  bool is_flat;
};
inline const std::vector<Spoiling> spoilings{
    {"aspect", stretched, {1, 10, 100, 1e3, 1e4, 1e5, 1e6}, true},
    {"obtuse", sheared, {0, 1, 3, 10, 30, 100, 300, 1000}, true},
    {"graded", graded, {1, 10, 100, 1e3, 1e4, 1e5, 1e6}, true},
    {"rough", rough, {0.03, 0.1, 0.3, 1, 3, 10}, false}};

inline std::string name_of(const Spoiling& spoiling, const std::string& method, double degree) {
  return "stability/" + spoiling.name + "/" + method + "/" + std::to_string(degree);
}

/// Runs `distance(mesh)` and counts `degree`, and `mean` and `most` of the relative errors where
/// all distances are finite; returns whether they are.
template <class Distance>
bool measure_on(benchmark::State& state, const Spoiling& spoiling, double degree,
                const Distance& distance) {
  const Sheet mesh = spoiling.make(degree);
  const auto truth = spoiling.is_flat ? straight(mesh) : ExactSolver(mesh).distance(source);
  std::vector<double> found;
  for (auto _ : state) found = distance(mesh);
  double sum = 0, most = 0;
  bool is_finite = true;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    is_finite = is_finite && std::isfinite(found[v]);
    if (truth[v] == 0) continue;
    const double off = std::fabs(found[v] - truth[v]) / truth[v];
    sum += off;
    most = std::max(most, off);
  }
  state.counters["degree"] = degree;
  if (!is_finite) return false;
  state.counters["mean"] = sum / static_cast<double>(truth.size() - 1);
  state.counters["most"] = most;
  return true;
}

}  // namespace gelight::bench
