#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "stress/kept_meshes.hpp"
#include "support/hard_meshes.hpp"
#include "support/scan_meshes.hpp"

// Requests of a planner, at random: any mesh, tolerance, norm, promise, source and start distance.

namespace gelight::test {

namespace requests {

inline double power_of_ten(Random& random, double low, double high) {
  return std::pow(10, uniform(random, low, high));
}

/// An open tube of `around` x `along` cells, each cut along a random diagonal.
inline Mesh<double> tube(Index around, Index along, double length, Random& random) {
  Mesh<double> mesh;
  for (Index j = 0; j <= along; ++j) {
    for (Index i = 0; i < around; ++i) {
      const double a = 2 * std::numbers::pi * i / around;
      mesh.positions.push_back({std::cos(a), std::sin(a), length * j / along});
    }
  }
  for (Index j = 0; j < along; ++j) {
    for (Index i = 0; i < around; ++i) {
      const Index a = j * around + i, b = j * around + (i + 1) % around;
      const Index c = a + around, d = b + around;
      if (uniform(random, 0, 1) < 0.5) {
        mesh.faces.insert(mesh.faces.end(), {{a, b, d}, {a, d, c}});
      } else {
        mesh.faces.insert(mesh.faces.end(), {{a, b, c}, {b, d, c}});
      }
    }
  }
  return mesh;
}

/// A sheet of cells of 0.05 with random heights up to `most`.
inline Mesh<double> rough_sheet(Index n, double most, Random& random) {
  Mesh<double> mesh = grid<double>(n, n, 0.05 * n, 0.05 * n);
  for (auto& p : mesh.positions) p[2] = uniform(random, 0, most);
  return mesh;
}

inline Mesh<double> wavy(Mesh<double> mesh, Random& random) {
  const double size = uniform(random, 0, 0.2), waves = uniform(random, 1, 8);
  for (auto& [x, y, z] : mesh.positions) {
    const double r = 1 + size * std::sin(waves * x + 1) * std::cos(waves * y);
    x *= r, y *= r, z = z * r + size * std::sin(waves * x + y);
  }
  return mesh;
}

inline Mesh<double> graded(Index n, double ratio, Random& random) {
  Mesh<double> mesh = grid<double>(n, n);
  const double height = uniform(random, 0, 0.3);
  for (auto& p : mesh.positions) {
    p = {std::pow(ratio, p[0] - 1), std::pow(ratio, p[1] - 1), height * std::sin(4 * p[0] + p[1])};
  }
  return mesh;
}

constexpr Index kinds = 16;
inline const std::array<const char*, kinds> kind_names{"sphere",
                                                       "noisy sphere",
                                                       "stretched sphere",
                                                       "long triangles",
                                                       "rough sheet",
                                                       "scan",
                                                       "kept",
                                                       "small",
                                                       "flat",
                                                       "stretched flat",
                                                       "terrain",
                                                       "torus",
                                                       "cone, saddle",
                                                       "membrane",
                                                       "graded",
                                                       "parts, holes, slit"};

inline Mesh<double> mesh_of(Index kind, Random& random) {
  const auto size = [&](Index low, Index high) { return low + uniform_index(random, high - low); };
  switch (kind) {
    case 0:
      return wavy(icosphere<double>(size(2, 5)), random);
    case 1:
      return scans::noisy(wavy(icosphere<double>(size(2, 5)), random), uniform(random, 0, 0.6),
                          random);
    case 2:
      return scans::stretched(wavy(icosphere<double>(size(2, 5)), random),
                              power_of_ten(random, 0, 2));
    case 3:
      return tube(size(6, 60), size(1, 30), power_of_ten(random, -1, 3), random);
    case 4:
      return rough_sheet(size(6, 45), uniform(random, 0, 0.5), random);
    case 5: {
      static const std::vector<NamedMesh> few = scan_meshes(3), many = scan_meshes(4);
      const auto& all = uniform(random, 0, 1) < 0.7 ? few : many;
      return all[static_cast<std::size_t>(uniform_index(random, static_cast<Index>(all.size())))]
          .mesh;
    }
    case 6: {
      static const auto kept = stress::kept_meshes();
      return kept[static_cast<std::size_t>(uniform_index(random, static_cast<Index>(kept.size())))]
          .second;
    }
    case 7:
      return small_random_mesh(uniform_index(random, 10), random);
    case 8:
      return jittered_grid(size(4, 45), uniform(random, 0, 0.2), random);
    case 9:
      return scans::stretched(jittered_grid(size(4, 45), 0.2, random), power_of_ten(random, 0, 4));
    case 10:
      return scans::with_slivers(scans::terrain(size(8, 40), random),
                                 static_cast<std::size_t>(size(2, 20)), random);
    case 11:
      return scans::noisy(torus<double>(2, uniform(random, 0.3, 1.5), size(8, 60), size(6, 30)),
                          uniform(random, 0, 0.2), random);
    case 12: {
      std::vector<double> radii;
      for (Index k = 1 + size(1, 30); k > 0; --k) radii.push_back(1.0 / k);
      return cone(uniform(random, 1, 10), 2 * size(3, 20), radii);
    }
    case 13:
      return membrane<double>(0.01146, 0.0455, uniform(random, 0.0014, 0.006));
    case 14:
      return graded(size(8, 40), power_of_ten(random, 0, 4), random);
    default: {
      const Index n = 2 * size(4, 20);
      if (uniform(random, 0, 1) < 0.3) return slit_sheet(n, random);
      const auto hole = [&](double x, double y) { return x > n / 2 && y > n / 3.0; };
      const std::array<Mesh<double>, 2> parts{sheet_with_hole(n, random, hole),
                                              wavy(icosphere<double>(size(1, 4)), random)};
      return joined<double>(parts);
    }
  }
}

}  // namespace requests

/// A request, the mesh that it is for and where distances shall count from.
struct RandomRequest {
  std::string kind;
  Mesh<double> mesh;
  std::vector<Source<double>> sources;
  PlanRequest request;
};

/// The error of distances against exact ones of vertices that matter, as shares of the way from
/// the least start distance; beyond all bounds where they do not agree on what is out of reach.
template <std::floating_point T>
double true_error(const std::vector<T>& distances, double start, const std::vector<double>& ways,
                  const PlanRequest& request) {
  double sum = 0, largest = 0, count = 0;
  const auto add = [&](std::size_t v) {
    const double off = std::abs(double{distances[v]} - start - ways[v]) / ways[v];
    if (std::isinf(ways[v]) != std::isinf(distances[v])) {
      sum = largest = std::numeric_limits<double>::infinity();
    } else if (ways[v] > 0 && !std::isinf(ways[v])) {
      sum += off;
      largest = std::max(largest, off);
      ++count;
    }
  };
  for (const Index v : request.targets) add(static_cast<std::size_t>(v));
  for (std::size_t v = 0; request.targets.empty() && v < ways.size(); ++v) add(v);
  return request.norm == ErrorNorm::mean ? sum / std::max(1.0, count) : largest;
}

/// Always the same one for a number.
inline RandomRequest random_request(std::uint64_t number) {
  using namespace requests;
  Random random(number);
  RandomRequest out;
  const Index kind = uniform_index(random, kinds);
  out.kind = kind_names[static_cast<std::size_t>(kind)];
  do {
    out.mesh = mesh_of(kind, random);
  } while (out.mesh.faces.empty() || !check(out.mesh).is_accepted());
  const double scale = uniform(random, 0, 1) < 0.2 ? power_of_ten(random, -6, 6) : 1;
  double shift = 0;
  if (uniform(random, 0, 1) < 0.1) shift = scale * power_of_ten(random, 0, 4);
  for (auto& p : out.mesh.positions) {
    for (double& x : p) x = scale * x + shift;
  }
  // One source mostly, mostly a vertex; start distances from a share of an edge to a million.
  const Index sources = uniform(random, 0, 1) < 0.6 ? 1 : 2 + uniform_index(random, 4);
  const bool has_starts = uniform(random, 0, 1) < 0.4;
  const double edge = scans::mean_edge(out.mesh);
  const double start = has_starts ? edge * power_of_ten(random, -1, 6) : 0;
  const bool are_spread = uniform(random, 0, 1) < 0.5;
  for (Index i = 0; i < sources; ++i) {
    const Index f = uniform_index(random, static_cast<Index>(out.mesh.faces.size()));
    auto point = vertex_point<double>(out.mesh.faces[static_cast<std::size_t>(f)][0]);
    if (uniform(random, 0, 1) < 0.5) point = random_point(out.mesh, random);
    if (uniform(random, 0, 1) < 0.1) {
      const double t = power_of_ten(random, -15, -3);
      point = face_point<double>(f, {1 - t, t / 2, t / 2});
    }
    const double sign = uniform(random, -1, 1);
    const double from = are_spread ? sign * start : (sign > 0 ? start : -start);
    out.sources.push_back({point, from});
  }
  if (!are_spread) {
    for (auto& source : out.sources) {
      source.distance = out.sources[0].distance + edge * uniform(random, 0, 5);
    }
  }
  if (!has_starts) {
    for (auto& source : out.sources) source.distance = 0;
  }

  out.request.tolerance = power_of_ten(random, -6, -0.5);
  if (uniform(random, 0, 1) < 0.2) out.request.tolerance = power_of_ten(random, -12, -6);
  if (uniform(random, 0, 1) < 0.3) out.request.tolerance = uniform(random, 0.005, 0.15);
  out.request.norm = uniform(random, 0, 1) < 0.6 ? ErrorNorm::mean : ErrorNorm::max;
  const double promise = uniform(random, 0, 1);
  out.request.assurance = promise < 0.45  ? Assurance::expected
                          : promise < 0.8 ? Assurance::sampled
                                          : Assurance::certified;
  if (out.request.assurance == Assurance::certified && uniform(random, 0, 1) < 0.6) {
    out.request.tolerance = power_of_ten(random, -2, 0);  // what bounds can prove
  }
  if (uniform(random, 0, 1) < 0.2) {
    for (Index k = 1 + uniform_index(random, 30); k > 0; --k) {
      const Index v = uniform_index(random, static_cast<Index>(out.mesh.positions.size()));
      out.request.targets.push_back(v);
    }
  }
  // Where it is hardest to tell: about what fast marching just keeps, or just does not.
  if (uniform(random, 0, 1) < 0.1) {
    detail::Sources ways(out.sources.begin(), out.sources.end());
    (void)detail::move_to_zero(Surface(out.mesh), ways);
    const std::span<const Source<double>> from(ways);
    const double error = true_error(FastMarchingSolver(out.mesh).distance(from), 0,
                                    ExactSolver(out.mesh).distance(from), out.request);
    if (error > 1e-12 && error < 10)
      out.request.tolerance = error * power_of_ten(random, -0.5, 0.3);
  }
  return out;
}

/// A request in one precision or the other, answered, and judged by exact distances.
template <std::floating_point T>
struct Verdict {
  PlannedDistances<T> answer;
  double error = 0;  ///< In the norm asked for, in truth.
};

template <std::floating_point T>
Verdict<T> answered(const RandomRequest& asked) {
  Mesh<T> mesh;
  for (const auto& [x, y, z] : asked.mesh.positions) {
    mesh.positions.push_back({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
  }
  mesh.faces = asked.mesh.faces;
  std::vector<Source<T>> sources;
  detail::Sources ways;  // without the least start distance
  double start = std::numeric_limits<double>::infinity();
  for (const auto& source : asked.sources) {
    SurfacePoint<T> point = source.point.cast<T>();
    const T sum = point.weights[0] + point.weights[1] + point.weights[2];
    for (T& w : point.weights) w /= sum;
    sources.push_back({point, static_cast<T>(source.distance)});
    ways.push_back({point.template cast<double>(), double{sources.back().distance}});
    start = std::min(start, ways.back().distance);
  }
  for (auto& source : ways) source.distance -= start;
  Verdict<T> verdict;
  verdict.answer = DistancePlanner(mesh, asked.request).solve(std::span<const Source<T>>(sources));
  const auto exact =
      ExactSolver(Surface<double>(mesh)).distance(std::span<const Source<double>>(ways));
  verdict.error = true_error(verdict.answer.distance, start, exact, asked.request);
  return verdict;
}

}  // namespace gelight::test
