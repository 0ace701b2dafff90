#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/relative_error.hpp"
#include "support/scan_meshes.hpp"

// What fast marching and virtual sources must both hold.

namespace gelight::test {

inline Vec3<double> at(const Mesh<double>& mesh, std::size_t v) {
  return {mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]};
}

template <class Solver>
Error sphere_error(int level, Index source) {
  const auto mesh = icosphere<double>(level);
  const auto d = Solver(mesh).distance(source);
  const auto s = at(mesh, static_cast<std::size_t>(source));
  return error_of(d, [&](std::size_t v) {
    const auto p = at(mesh, v);
    return v == static_cast<std::size_t>(source) ? 0 : std::atan2(s.cross(p).norm(), s.dot(p));
  });
}

// A sheet whose inner vertices are moved and whose diagonals run either way, at random.
inline Mesh<double> random_sheet(Index n) {
  auto mesh = grid<double>(n, n);
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> jitter(-0.2 / n, 0.2 / n);
  for (auto& p : mesh.positions) {
    const bool inner = p[0] > 1e-9 && p[0] < 1 - 1e-9 && p[1] > 1e-9 && p[1] < 1 - 1e-9;
    if (inner) p = {p[0] + jitter(engine), p[1] + jitter(engine), 0};
  }
  for (std::size_t f = 0; f < mesh.faces.size(); f += 2) {
    const auto [a, b, c] = mesh.faces[f];
    const Index d = mesh.faces[f + 1][2];
    if (engine() % 2 == 0) continue;
    mesh.faces[f] = {a, b, d};
    mesh.faces[f + 1] = {b, c, d};
  }
  return mesh;
}

// No two ways on it are equally long, which rounding would choose between.
inline Mesh<double> uneven_sphere() {
  auto mesh = icosphere<double>(3);
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> jitter(0.97, 1.03);
  for (auto& p : mesh.positions) p[engine() % 3] *= jitter(engine);
  return mesh;
}

/// Mean and largest relative difference from the exact polyhedral distance.
template <class Solver>
Error polyhedral_error(const Mesh<double>& mesh, std::span<const Source<double>> sources) {
  const auto exact = ExactSolver(mesh).distance(sources);
  const auto d = Solver(mesh).distance(sources);
  return error_of(d, [&](std::size_t v) { return std::isfinite(exact[v]) ? exact[v] : 0; });
}

/// On icospheres of 642 to 40,962 vertices: the order at which the mean error falls at least, and
/// what the last one's errors are below.
template <class Solver>
void check_spheres(double order, const Error& bounds) {
  Error first, last;
  for (const int level : {3, 4, 5, 6}) {
    last = sphere_error<Solver>(level, 130);
    MESSAGE("level " << level << ": mean " << last.mean << ", max " << last.max);
    if (level == 3) first = last;
  }
  CHECK(std::log2(first.mean / last.mean) / 3 > order);
  CHECK(last.mean < bounds.mean);
  CHECK(last.max < bounds.max);
}

/// On spheres of thin and obtuse triangles: near the exact polyhedral distance.
template <class Solver>
void check_stretched_spheres() {
  for (const double stretch : {5.0, 20.0}) {
    auto mesh = icosphere<double>(4);
    for (auto& p : mesh.positions) p[2] *= stretch;
    const std::vector<Source<double>> sources{{vertex_point<double>(100), 0}};
    const auto error = polyhedral_error<Solver>(mesh, sources);
    MESSAGE("stretched x" << stretch << ": mean " << error.mean << ", max " << error.max);
    CHECK(error.mean < 2e-3);
    CHECK(error.max < 0.02);
  }
}

// Three quarters of a square; the corner of the border is at (1, 1).
inline Mesh<double> bent_sheet(Index n) {
  auto mesh = grid<double>(n, n, 2.0, 2.0);
  std::erase_if(mesh.faces, [&](const auto& f) {
    const Vec3<double> middle =
        (at(mesh, static_cast<std::size_t>(f[0])) + at(mesh, static_cast<std::size_t>(f[1])) +
         at(mesh, static_cast<std::size_t>(f[2]))) /
        3;
    return middle[0] > 1 && middle[1] > 1;
  });
  return mesh;
}

/// Distances of the bent sheet from (2, 0): the error behind the corner by the law of sight.
template <class Solver>
Error corner_error(Index n) {
  const auto mesh = bent_sheet(n);
  const Vec3<double> from(2, 0, 0), corner(1, 1, 0);
  const auto d = Solver(mesh).distance(n);
  CHECK(d.back() == unreachable<double>);
  return error_of(d, [&](std::size_t v) -> double {
    const Vec3<double> p = at(mesh, v);
    if (d[v] == unreachable<double>) return 0;
    const bool sees = p.x() > 1 || (corner - from).cross(p - from).z() >= 0;
    return sees ? (p - from).norm() : (corner - from).norm() + (p - corner).norm();
  });
}

// Start distances that are all less by a number: distances that are less by it. Repeated sources
// change nothing.
template <class Solver>
void check_equal_sources() {
  Random random(3);
  const Solver solver(jittered_grid(16, 0.2, random));
  std::vector<Source<double>> sources{
      {vertex_point<double>(3), 5}, {vertex_point<double>(150), 2}, {vertex_point<double>(260), 4}};
  const auto d = solver.distance(std::span<const Source<double>>(sources));
  auto twice = sources;
  twice.insert(twice.end(), sources.begin(), sources.end());
  CHECK(solver.distance(std::span<const Source<double>>(twice)) == d);
  for (auto& source : sources) source.distance -= 10;
  const auto shifted = solver.distance(std::span<const Source<double>>(sources));
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::abs(shifted[v] + 10 - d[v]) < 1e-12);
}

/// All border vertices, or points of the border too, of a jittered sheet.
inline std::vector<Source<double>> border_sources(const Mesh<double>& mesh, int per_edge) {
  const Surface<double> surface(mesh);
  std::vector<Source<double>> sources;
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    if (!surface.is_border(h)) continue;
    sources.push_back({vertex_point<double>(surface.origin(h)), 0});
    for (int i = 1; i < per_edge; ++i) {
      const double t = i / static_cast<double>(per_edge);
      sources.push_back({edge_point<double>(surface.origin(h), surface.tip(h), t), 0});
    }
  }
  return sources;
}

// Flat sheets: straight lines, from any kind of point.
template <class Solver>
void check_flat_sheets() {
  const auto mesh = random_sheet(30);
  const Solver solver(mesh);
  for (const auto& point :
       {vertex_point<double>(0), vertex_point<double>(480), edge_point<double>(480, 481, 0.3),
        face_point<double>(700, {0.2, 0.3, 0.5})}) {
    const std::vector<Source<double>> sources{{point, 0}};
    const auto s = Surface(mesh).position(point);
    const auto d = solver.distance(sources);
    for (std::size_t v = 0; v < d.size(); ++v) {
      CHECK(std::abs(d[v] - (at(mesh, v) - s).norm()) < 2e-4 * d[v] + 1e-14);
    }
  }
}

// Parts, strays, fins, bow-ties, flat faces and flipped ones.
template <class Solver>
void check_topology() {
  const std::vector<Mesh<double>> parts{icosphere<double>(2), grid<double>(4, 4)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({9, 9, 9});
  const auto d = Solver(mesh).distance(7);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::isfinite(d[v]) == (v < 162));

  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 5, 2}}};
  const auto across = Solver(fin).distance(4);
  CHECK(across[2] == gelight::test::approx(2));
  CHECK(across[3] == gelight::test::approx(2));
  CHECK(across[1] == gelight::test::approx(across[5]));
  const Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  CHECK(Solver(bow).distance(1)[3] == gelight::test::approx(2));

  auto flipped = uneven_sphere();
  const auto expected = Solver(flipped).distance(0);
  for (std::size_t f = 0; f < flipped.faces.size(); f += 2) {
    std::swap(flipped.faces[f][0], flipped.faces[f][1]);
  }
  const auto same = Solver(flipped).distance(0);
  for (std::size_t v = 0; v < same.size(); ++v) {
    CHECK(same[v] == gelight::test::approx(expected[v]).epsilon(1e-4));
  }
}

// Scales with the mesh, at any distance from the origin.
template <class Solver>
void check_scales() {
  const auto mesh = uneven_sphere();
  const auto expected = Solver(mesh).distance(0);
  for (const double s : {1e-20, 1e-6, 1e6}) {
    auto scaled = mesh;
    for (auto& p : scaled.positions) p = {s * p[0], s * p[1], s * p[2]};
    const auto d = Solver(scaled).distance(0);
    for (std::size_t v = 0; v < d.size(); ++v) {
      CHECK(std::abs(d[v] / s - expected[v]) <= 1e-13 * expected[v]);
    }
  }
  auto sheet = grid<double>(16, 16, 16.0, 16.0);  // positions that 1e6 leaves exact
  const auto near = Solver(sheet).distance(5);
  for (auto& p : sheet.positions) p[1] -= 1e6;
  const auto far = Solver(sheet).distance(5);
  for (std::size_t v = 0; v < far.size(); ++v) CHECK(std::abs(far[v] - near[v]) < 1e-8);
  // Most edges 1e20 times shorter than the last way, whose end is seen by way of the far only.
  auto tiny = grid<double>(10, 10, 1e-20, 1e-20);
  const auto first = static_cast<Index>(tiny.positions.size());
  tiny.positions.insert(tiny.positions.end(), {{1, 0, 0}, {2, 1, 0}, {3, 0, 0}});
  tiny.faces.insert(tiny.faces.end(), {{10, first, 21}, {first, first + 1, 21}});
  tiny.faces.push_back({first, first + 2, first + 1});
  CHECK(Solver(tiny).distance(0).back() == gelight::test::approx(3));
}

// Never longer than along edges; a query leaves no trace.
template <class Solver>
void check_bounds_and_traces() {
  const auto mesh = membrane<double>(1, 3, 0.2);
  const Solver solver(mesh);
  const auto d = solver.distance(11), edges = DijkstraSolver(mesh).distance(11);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(d[v] <= edges[v] * (1 + 2e-5));
  (void)solver.distance(3);
  CHECK(solver.distance(11) == d);
  CHECK_THROWS_AS((void)solver.distance(-1), InvalidInput);
}

// A fan of 10,000 spokes.
template <class Solver>
void check_fan() {
  const Index spokes = 10000;
  Mesh<double> fan{{{0, 0, 0}}, {}};
  for (Index k = 0; k < spokes; ++k) {
    const double a = 2 * std::acos(-1.0) * k / spokes;
    fan.positions.push_back({std::cos(a), std::sin(a), 0});
    fan.faces.push_back({0, 1 + k, 1 + (k + 1) % spokes});
  }
  const auto d = Solver(fan).distance(0);
  for (std::size_t v = 1; v < d.size(); ++v) CHECK(d[v] == gelight::test::approx(1));
  CHECK(Solver(fan).distance(1)[1 + spokes / 2] == gelight::test::approx(2));
}

/// Sheets, needles, balls and scan-like meshes.
inline std::vector<NamedMesh> many_meshes() {
  Random random(5);
  auto meshes = scan_meshes(3);
  meshes.push_back({"regular grid", grid<double>(40, 40, 40.0, 40.0)});
  meshes.push_back({"jittered grid", jittered_grid(40, 0.2, random)});
  meshes.push_back({"needles", scans::stretched(jittered_grid(30, 0.2, random), 100)});
  meshes.push_back({"icosphere", icosphere<double>(3)});
  auto sheared = jittered_grid(30, 0.2, random);
  for (auto& p : sheared.positions) p[0] += 8 * p[1];
  meshes.push_back({"sheared sheet", sheared});
  return meshes;
}

struct Excess {
  double largest = 0;
  int trials = 0, beyond_a_twentieth = 0;
};

/// By how many mean edges the answer to sources is beyond the least of the answers to each alone.
template <class Solver>
double excess_of(const Solver& solver, const std::vector<Source<double>>& sources, double edge) {
  const auto d = solver.distance(std::span<const Source<double>>(sources));
  std::vector<double> least(d.size(), unreachable<double>);
  for (const auto& source : sources) {
    const auto alone = solver.distance(std::span<const Source<double>>(&source, 1));
    for (std::size_t v = 0; v < d.size(); ++v) least[v] = std::min(least[v], alone[v]);
  }
  double excess = 0;
  for (std::size_t v = 0; v < d.size(); ++v) {
    CHECK(std::isfinite(d[v]) == std::isfinite(least[v]));
    if (std::isfinite(least[v])) excess = std::max(excess, (d[v] - least[v]) / edge);
  }
  return excess;
}

/// By how many mean edges the answer to several random sources, of start distances of either sign,
/// is beyond the least of the answers to each alone.
template <class Solver>
Excess excess_of_several() {
  Excess all;
  Random random(8);
  for (const auto& [name, mesh] : many_meshes()) {
    const Solver solver(mesh);
    const double edge = scans::mean_edge(mesh);
    for (const int count : {2, 5, 50}) {
      for (const double most : {0.0, 10 * edge}) {
        std::vector<Source<double>> sources;
        for (int i = 0; i < count; ++i) {
          sources.push_back({random_point(mesh, random), uniform(random, -most, most)});
        }
        const double excess = excess_of(solver, sources, edge);
        ++all.trials;
        all.beyond_a_twentieth += excess > 0.05;
        all.largest = std::max(all.largest, excess);
      }
    }
  }
  return all;
}

/// From 64 sources side by side, four an edge, along edges that go on as straight as they can, the
/// answer is within a twentieth of the mean edge of that from the nearest alone.
template <class Solver>
void check_curves() {
  double largest = 0;
  Random random(8);
  const auto meshes = many_meshes();
  for (std::size_t i = 0; i < meshes.size(); i += 3) {
    const auto& mesh = meshes[i].mesh;
    const Solver solver(mesh);
    const Surface<double> surface(mesh);
    const auto way = [&](Index h) -> Vec3<double> {
      return (surface.position(surface.tip(h)) - surface.position(surface.origin(h))).normalized();
    };
    std::vector<Source<double>> sources;
    Index edge = uniform_index(random, surface.halfedge_count());
    for (int k = 0; k < 16; ++k) {
      for (const double share : {0.125, 0.375, 0.625, 0.875}) {
        sources.push_back({edge_point<double>(surface.origin(edge), surface.tip(edge), share), 0});
      }
      const auto outgoing = surface.corners(surface.tip(edge));
      if (outgoing.empty()) break;
      edge = *std::max_element(outgoing.begin(), outgoing.end(), [&](Index a, Index b) {
        return dot(way(a), way(edge)) < dot(way(b), way(edge));
      });
    }
    CAPTURE(meshes[i].name);
    const double excess = excess_of(solver, sources, scans::mean_edge(mesh));
    CHECK(excess < 0.05);
    largest = std::max(largest, excess);
  }
  MESSAGE("beyond the nearest alone by " << largest << " mean edges at most");
}

/// A hook ends a query, which leaves the output and the solver as they were; told how much is done,
/// that never decreases.
template <class Solver, class Options>
void check_cancelling() {
  const auto mesh = icosphere<double>(5);
  bool ends = false;
  double last = 0;
  int asked = 0;
  Options options;
  options.cancelled = [&](double done) {
    ++asked;
    if (!ends) CHECK(done >= last);
    last = done;
    return ends;
  };
  const Solver solver(mesh, options);
  last = 0, asked = 0;
  const auto d = solver.distance(3);
  CHECK(asked > 0);
  CHECK(last <= 1);
  ends = true;
  std::vector<double> out(d.size(), -1);
  CHECK_THROWS_AS(solver.distance_into(out, 3), Cancelled);
  CHECK(out == std::vector<double>(d.size(), -1));
  ends = false, last = 0;
  CHECK(solver.distance(3) == d);
}

}  // namespace gelight::test
