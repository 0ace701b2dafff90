#pragma once

// What the programs of the speed-against-accuracy charts share: meshes, what is true on them, the
// heap's peak, and errors.

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/planning/mesh_statistics.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "run.hpp"
#include "spheres.hpp"
#include "timing.hpp"

namespace pareto {

using namespace gelight;
using bench::median, bench::run, bench::seconds;

// --- the heap ------------------------------------------------------------------------------------

struct Heap {
  static inline std::atomic<std::ptrdiff_t> now = 0, peak = 0;

  static void* take(std::size_t size) {
    void* p = std::malloc(std::max<std::size_t>(size, 1));
    if (p == nullptr) throw std::bad_alloc();
    now += static_cast<std::ptrdiff_t>(malloc_usable_size(p));
    if (now > peak) peak = now.load();
    return p;
  }
  static void give(void* p) {
    now -= static_cast<std::ptrdiff_t>(malloc_usable_size(p));
    std::free(p);
  }
};

/// Memory is not given back to the system, so that the cost of its pages, which changes with what
/// else the machine does, is paid once and not in every figure.
inline const bool keeps_memory = mallopt(M_MMAP_THRESHOLD, 1 << 30) == 1 &&
                                 mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max()) == 1;

/// The most that is allocated beyond what was when it was made, in megabytes.
class PeakMemory {
 public:
  PeakMemory() : start_(Heap::now) { Heap::peak = start_; }
  [[nodiscard]] double megabytes() const { return 1e-6 * static_cast<double>(Heap::peak - start_); }

 private:
  std::ptrdiff_t start_;
};

// --- meshes --------------------------------------------------------------------------------------

/// A mesh, its exact distances from `sources`, and those of the smooth surface where known.
struct Case {
  std::string name;
  Mesh<double> mesh;
  std::array<Index, 3> sources{130, 7, 5000};  // on small meshes what these are modulo their size
  std::vector<std::vector<double>> exact, smooth;
  double floor = 0;  // 0.10 (kappa h)^2: what the mesh itself is off the smooth surface, on average
  bool is_known = true;  // how far methods are off on it

  Case(std::string case_name, Mesh<double> case_mesh, bool is_sphere = false, bool is_smooth = true)
      : name(std::move(case_name)), mesh(std::move(case_mesh)) {
    const Surface<double> surface(mesh);
    for (Index& s : sources) s %= surface.vertex_count();
    const double turn = detail::MeshStatistics<double>(surface).turn;
    if (is_smooth) floor = 0.3 * turn * turn;
    const ExactSolver<double> solver(surface);
    for (const Index s : sources) {
      exact.push_back(solver.distance(s));
      if (is_sphere) smooth.push_back(great_circle(surface, s));
    }
  }

  static std::vector<double> great_circle(const Surface<double>& surface, Index source) {
    std::vector<double> truth;
    const Vec3<double> s = surface.position(source);
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      const Vec3<double> p = surface.position(v);
      truth.push_back(v == source ? 0 : std::atan2(s.cross(p).norm(), s.dot(p)));
    }
    return truth;
  }
};

inline Mesh<double> saddle(Index n) {
  auto mesh = grid<double>(n, n);
  for (auto& p : mesh.positions) {
    p[2] = 0.5 * ((p[0] - 0.5) * (p[0] - 0.5) - (p[1] - 0.5) * (p[1] - 0.5));
  }
  return mesh;
}

/// Edges that differ a thousandfold, on a wavy sheet.
inline Mesh<double> graded(Index n) {
  auto mesh = grid<double>(n, n);
  for (auto& p : mesh.positions) {
    p = {std::pow(1e3, p[0] - 1), std::pow(1e3, p[1] - 1), 0};
    p[2] = 0.1 * std::sin(4 * p[0]) * std::cos(3 * p[1]);
  }
  return mesh;
}

/// Some 10,000 vertices each.
inline std::vector<Case> procedural_cases() {
  std::vector<Case> cases;
  cases.emplace_back("sphere", icosphere<double>(5), true);
  cases.emplace_back("membrane", membrane<double>(0.01146, 0.0455, 0.00062));
  cases.emplace_back("saddle", saddle(100));
  cases.emplace_back("noisy", bench::noisy_sphere(5), false, false);
  cases.emplace_back("needles", bench::needle_sphere(400, 25), true);
  cases.emplace_back("graded", graded(100));
  return cases;
}

/// A quad grid over u and v from 0 to 1, bent; `position(u, v)`.
template <class Position>
Mesh<double> sheet(Index n, const Position& position) {
  auto mesh = grid<double>(n, n);
  for (auto& p : mesh.positions) p = position(p[0], p[1]);
  return mesh;
}

/// Meshes that no figure of the planner was chosen on.
inline std::vector<Case> unseen_cases() {
  constexpr double pi = std::numbers::pi;
  std::vector<Case> cases;
  cases.emplace_back("hourglass", sheet(100, [](double u, double v) -> std::array<double, 3> {
                       const double z = 2 * v - 1, r = 0.3 + 0.5 * z * z, a = 1.8 * pi * u;
                       return {r * std::cos(a), r * std::sin(a), z};
                     }));
  cases.emplace_back("helicoid", sheet(100, [](double u, double v) -> std::array<double, 3> {
                       const double r = 2 * u - 1, a = 1.5 * pi * v;
                       return {r * std::cos(a), r * std::sin(a), 0.3 * a};
                     }));
  auto bumpy = icosphere<double>(5);
  for (auto& [x, y, z] : bumpy.positions) {
    const double r = 1 + 0.1 * std::sin(5 * x) * std::sin(4 * y + 1) * std::cos(6 * z);
    x *= r, y *= r, z *= r;
  }
  cases.emplace_back("bumpy", std::move(bumpy));
  auto terrain = sheet(100, [](double u, double v) -> std::array<double, 3> {
    return {u, v, 0.1 * std::sin(7 * u) * std::cos(5 * v) + 0.03 * std::sin(20 * u + 15 * v)};
  });
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset(-0.0025, 0.0025);
  for (auto& p : terrain.positions) p[0] += offset(random), p[1] += offset(random);
  cases.emplace_back("terrain", std::move(terrain));
  return cases;
}

// --- errors --------------------------------------------------------------------------------------

/// Mean, 99th percentile and maximum, as counters.
inline void report_spread(benchmark::State& state, const std::string& prefix,
                          std::vector<double> values) {
  const auto at = values.begin() + std::ssize(values) * 99 / 100;
  std::nth_element(values.begin(), at, values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  state.counters[prefix + "mean"] = sum / static_cast<double>(values.size());
  state.counters[prefix + "p99"] = *at;
  state.counters[prefix + "max"] = *std::max_element(at, values.end());
}

/// Relative errors of one or more answers.
class Errors {
 public:
  void add(const std::vector<double>& distances, const std::vector<double>& truth) {
    for (std::size_t v = 0; v < truth.size(); ++v) {
      if (!(truth[v] > 0) || std::isinf(truth[v])) continue;
      const double share = distances[v] / truth[v];
      values_.push_back(std::abs(share - 1));
      least_share_ = std::min(least_share_, share);
    }
  }
  /// Lengths of paths never are, but for rounding.
  [[nodiscard]] bool has_too_short() const { return least_share_ < 1 - 1e-9; }
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (const double e : values_) sum += e;
    return sum / static_cast<double>(std::max<std::size_t>(1, values_.size()));
  }
  void report(benchmark::State& state, const std::string& prefix) const {
    if (!values_.empty()) report_spread(state, prefix, values_);
  }

 private:
  std::vector<double> values_;
  double least_share_ = std::numeric_limits<double>::infinity();
};

}  // namespace pareto

void* operator new(std::size_t size) { return pareto::Heap::take(size); }
void* operator new[](std::size_t size) { return pareto::Heap::take(size); }
void operator delete(void* p) noexcept { pareto::Heap::give(p); }
void operator delete[](void* p) noexcept { pareto::Heap::give(p); }
void operator delete(void* p, std::size_t) noexcept { pareto::Heap::give(p); }
void operator delete[](void* p, std::size_t) noexcept { pareto::Heap::give(p); }
