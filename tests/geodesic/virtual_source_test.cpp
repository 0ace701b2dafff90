#include "gelight/geodesic/virtual_source.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"

using namespace gelight;

namespace {

using Solver = VirtualSourceSolver<double>;

struct Error {
  double mean = 0, max = 0;
};

Vec3<double> at(const Mesh<double>& mesh, std::size_t v) {
  return {mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]};
}

Error error_of(const std::vector<double>& d, auto&& truth) {
  Error error;
  double count = 0;
  for (std::size_t v = 0; v < d.size(); ++v) {
    const double t = truth(v);
    if (t == 0) continue;
    const double off = std::abs(d[v] - t) / t;
    error.mean += off;
    error.max = std::max(error.max, off);
    ++count;
  }
  error.mean /= count;
  return error;
}

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
Mesh<double> random_sheet(Index n) {
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
Mesh<double> uneven_sphere() {
  auto mesh = icosphere<double>(3);
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> jitter(0.97, 1.03);
  for (auto& p : mesh.positions) p[engine() % 3] *= jitter(engine);
  return mesh;
}

}  // namespace

TEST_CASE("flat sheets: straight lines, from any kind of point") {
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

TEST_CASE("spheres: mean and largest error, and the order at which they fall") {
  Error before;
  for (const int level : {3, 4, 5, 6}) {
    const Error error = sphere_error(level, 130);
    MESSAGE("level " << level << ": mean " << error.mean << ", max " << error.max);
    if (before.mean > 0) {
      CHECK(std::log2(before.mean / error.mean) > 0.5);
    }
    before = error;
  }
  CHECK(before.mean < 2e-4);
  CHECK(before.max < 0.006);
}

TEST_CASE("thin and obtuse triangles: near the exact polyhedral distance") {
  for (const double stretch : {5.0, 20.0}) {
    auto mesh = icosphere<double>(4);
    for (auto& p : mesh.positions) p[2] *= stretch;
    const auto exact = ExactSolver(mesh).distance(100);
    const Error error =
        error_of(Solver(mesh).distance(100), [&](std::size_t v) { return exact[v]; });
    MESSAGE("stretched x" << stretch << ": mean " << error.mean << ", max " << error.max);
    CHECK(error.mean < 2e-3);
    CHECK(error.max < 0.05);
  }
}

TEST_CASE("a path bends round a corner of the border") {
  // Three quarters of a square; from one arm to the other round (1, 1).
  const Index n = 20;
  auto mesh = grid<double>(n, n, 2.0, 2.0);
  std::erase_if(mesh.faces, [&](const auto& f) {
    const Vec3<double> middle =
        (at(mesh, static_cast<std::size_t>(f[0])) + at(mesh, static_cast<std::size_t>(f[1])) +
         at(mesh, static_cast<std::size_t>(f[2]))) /
        3;
    return middle[0] > 1 && middle[1] > 1;
  });
  const auto d = Solver(mesh).distance(n);                 // at (2, 0)
  const auto far = static_cast<std::size_t>(n * (n + 1));  // at (0, 2)
  CHECK(d[far] == doctest::Approx(2 * std::sqrt(2.0)).epsilon(2e-3));
  CHECK(d.back() == unreachable<double>);
}

TEST_CASE("several sources, repeated sources, start distances of either sign") {
  const auto mesh = icosphere<double>(4);
  const Solver solver(mesh);
  const auto a = solver.distance(3), b = solver.distance(700);
  const auto both = solver.distance(std::vector<Index>{3, 700, 3});
  CHECK(both == solver.distance(std::vector<Index>{700, 3}));
  const std::vector<Source<double>> sources{{vertex_point<double>(3), 0.5},
                                            {vertex_point<double>(700), -0.25}};
  const auto started = solver.distance(sources);
  for (std::size_t v = 0; v < both.size(); ++v) {
    CHECK(std::abs(both[v] - std::min(a[v], b[v])) < 0.02);
    CHECK(std::abs(started[v] - std::min(a[v] + 0.5, b[v] - 0.25)) < 0.05);
  }
}

TEST_CASE("parts, strays, fins, bow-ties, flat faces and flipped ones") {
  const std::vector<Mesh<double>> parts{icosphere<double>(2), grid<double>(4, 4)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({9, 9, 9});
  const auto d = Solver(mesh).distance(7);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::isfinite(d[v]) == (v < 162));

  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 5, 2}}};
  const auto across = Solver(fin).distance(4);
  CHECK(across[2] == doctest::Approx(2));
  CHECK(across[3] == doctest::Approx(2));
  CHECK(across[1] == doctest::Approx(across[5]));
  const Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  CHECK(Solver(bow).distance(1)[3] == doctest::Approx(2));

  auto flipped = uneven_sphere();
  const auto expected = Solver(flipped).distance(0);
  for (std::size_t f = 0; f < flipped.faces.size(); f += 2) {
    std::swap(flipped.faces[f][0], flipped.faces[f][1]);
  }
  const auto same = Solver(flipped).distance(0);
  for (std::size_t v = 0; v < same.size(); ++v) {
    CHECK(same[v] == doctest::Approx(expected[v]).epsilon(1e-4));
  }
}

TEST_CASE("scales with the mesh, at any distance from the origin") {
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
}

TEST_CASE("never longer than along edges; a query leaves no trace") {
  const auto mesh = membrane<double>(1, 3, 0.2);
  const Solver solver(mesh);
  const auto d = solver.distance(11), edges = DijkstraSolver(mesh).distance(11);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(d[v] <= edges[v] * (1 + 2e-5));
  (void)solver.distance(3);
  CHECK(solver.distance(11) == d);
  CHECK_THROWS_AS((void)solver.distance(-1), InvalidInput);
}

TEST_CASE("a fan of 10,000 spokes") {
  const Index spokes = 10000;
  Mesh<double> fan{{{0, 0, 0}}, {}};
  for (Index k = 0; k < spokes; ++k) {
    const double a = 2 * std::acos(-1.0) * k / spokes;
    fan.positions.push_back({std::cos(a), std::sin(a), 0});
    fan.faces.push_back({0, 1 + k, 1 + (k + 1) % spokes});
  }
  const auto d = Solver(fan).distance(0);
  for (std::size_t v = 1; v < d.size(); ++v) CHECK(d[v] == doctest::Approx(1));
  CHECK(Solver(fan).distance(1)[1 + spokes / 2] == doctest::Approx(2));
}
