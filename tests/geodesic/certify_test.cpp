#include "gelight/geodesic/certify.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"

using namespace gelight;
using test::Random;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// What a caller might bring: good distances, bad ones, and no distances at all.
std::vector<std::vector<double>> potentials(const Mesh<double>& mesh,
                                            std::span<const Source<double>> sources,
                                            const std::vector<double>& exact, Random& random) {
  std::vector<std::vector<double>> all{
      exact, FastMarchingSolver(mesh).distance(sources), DijkstraSolver(mesh).distance(sources),
      std::vector<double>(exact.size(), 0.0), std::vector<double>(exact.size(), infinite)};
  const double top = *std::max_element(exact.begin(), exact.end());
  std::vector<double> noise = exact, anything, twice = exact;
  for (double& d : noise) d *= 1 + test::uniform(random, -0.1, 0.1);
  for (double& d : twice) d *= 2;
  for (std::size_t v = 0; v < exact.size(); ++v) {
    anything.push_back(test::uniform(random, -1, 1) * (std::isfinite(top) ? top : 1));
  }
  all.insert(all.end(), {noise, anything, twice});
  return all;
}

// `rounding` is that of the exact solver, as a share: about 1e-15, times the aspect of needles.
void check_bounds(const DistanceBounds<double>& bounds, const std::vector<double>& exact,
                  double rounding) {
  for (std::size_t v = 0; v < exact.size(); ++v) {
    CAPTURE(v);
    if (std::isinf(exact[v])) {
      CHECK(bounds.lower[v] == infinite);
      CHECK(bounds.upper[v] == infinite);
      continue;
    }
    const double room = rounding * std::abs(exact[v]);
    CHECK(bounds.lower[v] <= exact[v] + room);
    CHECK(bounds.upper[v] >= exact[v] - room);
    CHECK(bounds.upper[v] < infinite);
  }
}

void check(const Mesh<double>& mesh, const std::vector<Source<double>>& sources, Random& random,
           double rounding = 0) {
  const std::span<const Source<double>> span(sources);
  const auto exact = ExactSolver(mesh).distance(span);
  const Certifier certifier(mesh);
  for (const auto& potential : potentials(mesh, sources, exact, random)) {
    check_bounds(certifier.bounds(span, potential), exact, rounding);
  }
}

std::vector<Source<double>> at_vertex(Index v) { return {{vertex_point<double>(v), 0}}; }

// Mean gap between the bounds, as a share of the exact distance.
double gap(const Mesh<double>& mesh, const DistanceBounds<double>& bounds, Index source) {
  const auto exact = ExactSolver(mesh).distance(source);
  double sum = 0;
  for (std::size_t v = 0; v < exact.size(); ++v) {
    if (exact[v] > 0) sum += (bounds.upper[v] - bounds.lower[v]) / exact[v];
  }
  return sum / static_cast<double>(exact.size());
}

}  // namespace

TEST_CASE("small meshes of every kind, sources anywhere, potentials good and bad") {
  Random random(7);
  for (int kind = 0; kind < 100; ++kind) {
    CAPTURE(kind);
    const auto mesh = test::small_random_mesh(kind, random);
    std::vector<Source<double>> sources;
    for (Index i = test::uniform_index(random, 3); i >= 0; --i) {
      sources.push_back(
          {test::random_point(mesh, random), kind % 3 == 0 ? test::uniform(random, -1, 1) : 0.0});
    }
    check(mesh, sources, random, kind % 10 == 4 ? 1e-13 : 1e-14);
  }
}

TEST_CASE("sheets, cones, saddles, boxes, corners and slits") {
  Random random(3);
  for (const Index n : {4, 9, 20}) {
    check(test::random_grid(n, random), at_vertex(0), random);
    check(test::jittered_grid(n, 0.2, random), at_vertex(n / 2), random);
    check(test::slit_sheet(2 * (n / 2), random), at_vertex(n / 3), random);
    check(test::sheet_with_hole(n, random,
                                [&](double x, double y) { return 2 * x > n && 2 * y > n; }),
          at_vertex(n), random);
  }
  const std::vector<double> radii{0.3, 0.8, 1, 2};
  for (const double angle : {1.0, 3.0, 5.0, 8.0, 11.0}) {
    check(test::cone(angle, 12, radii), at_vertex(20), random);
    check(test::cone(angle, 12, radii), at_vertex(0), random);
  }
  check(box<double>(1, 2, 3), at_vertex(0), random);
  check(icosphere<double>(4), at_vertex(17), random);
  check(torus<double>(2, 0.7, 30, 20), at_vertex(5), random);
}

TEST_CASE("needles, caps and zero-length edges") {
  Random random(5);
  for (const double stretch : {1e2, 1e4, 1e6}) {
    CAPTURE(stretch);
    auto mesh = grid<double>(12, 12);
    for (auto& p : mesh.positions) p[0] *= stretch;
    check(mesh, at_vertex(30), random, 1e-15 * stretch);
    auto sphere = icosphere<double>(3);
    for (auto& p : sphere.positions) p[2] *= stretch;
    check(sphere, at_vertex(30), random, 1e-15 * stretch);
  }
  // A vertex on the middle of an edge of the face beside it, and two vertices at one place.
  auto capped = grid<double>(6, 6);
  const auto [a, b, c] = capped.faces[30];
  const auto pa = capped.positions[static_cast<std::size_t>(a)];
  const auto pb = capped.positions[static_cast<std::size_t>(b)];
  const auto middle = static_cast<Index>(capped.positions.size());
  capped.positions.push_back({(pa[0] + pb[0]) / 2, (pa[1] + pb[1]) / 2, 0});
  capped.faces[30] = {a, middle, c};
  capped.faces.push_back({middle, b, c});
  capped.faces.push_back({a, b, middle});
  check(capped, at_vertex(3), random, 1e-15);
  check(capped, at_vertex(middle), random, 1e-15);
  const Mesh<double> doubled{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-1, 0, 0}},
                             {{0, 1, 2}, {0, 2, 3}, {3, 2, 4}}};
  for (const Index v : {0, 1, 3, 4}) check(doubled, at_vertex(v), random, 1e-15);
}

TEST_CASE("parts, strays, fins, bow-ties and flipped faces") {
  Random random(11);
  const std::vector<Mesh<double>> parts{icosphere<double>(2), grid<double>(4, 4)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({9, 9, 9});
  check(mesh, at_vertex(7), random);
  check(mesh, at_vertex(170), random);
  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 5, 2}}};
  for (const Index v : {0, 2, 4, 5}) check(fin, at_vertex(v), random, 1e-15);
  const Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  check(bow, at_vertex(1), random);
  auto flipped = icosphere<double>(3);
  for (std::size_t f = 0; f < flipped.faces.size(); f += 2) {
    std::swap(flipped.faces[f][0], flipped.faces[f][1]);
  }
  check(flipped, at_vertex(0), random);
}

TEST_CASE(
    "one and two triangles, long strips, a fan of many spokes, edges of very different length") {
  Random random(2);
  const Mesh<double> one{{{0, 0, 0}, {1, 0, 0}, {0.2, 0.7, 0}}, {{0, 1, 2}}};
  check(one, {{face_point<double>(0, {0.2, 0.3, 0.5}), 0}}, random, 1e-15);
  check(one, at_vertex(1), random);
  check(grid<double>(300, 1, 300.0, 1.0), at_vertex(0), random);
  Mesh<double> fan{{{0, 0, 0}}, {}};
  const Index spokes = 3000;
  for (Index k = 0; k < spokes; ++k) {
    const double angle = 2 * std::acos(-1.0) * k / spokes;
    fan.positions.push_back({std::cos(angle), std::sin(angle), 0});
    fan.faces.push_back({0, 1 + k, 1 + (k + 1) % spokes});
  }
  check(fan, at_vertex(1), random, 1e-13);
  check(fan, at_vertex(0), random);
  auto graded = grid<double>(40, 40);
  for (auto& p : graded.positions) p = {std::pow(1e4, p[0]), std::pow(1e4, p[1]), 0};
  check(graded, at_vertex(0), random, 1e-13);
  check(graded, at_vertex(900), random, 1e-13);
}

TEST_CASE("sources in faces and on edges, several, a whole border, with start distances") {
  Random random(4);
  const auto mesh = icosphere<double>(3);
  check(mesh, {{edge_point<double>(mesh.faces[9][0], mesh.faces[9][1], 0.3), 0}}, random, 1e-15);
  check(mesh, {{face_point<double>(70, {0.1, 0.1, 0.8}), 2}, {vertex_point<double>(9), 1.5}},
        random, 1e-15);
  check(mesh, {{vertex_point<double>(9), -3}, {vertex_point<double>(200), -2.5}}, random, 1e-15);
  std::vector<Source<double>> border;
  const auto sheet = test::jittered_grid(15, 0.2, random);
  for (Index k = 0; k <= 15; ++k) border.push_back({vertex_point<double>(k), 0});
  check(sheet, border, random, 1e-15);
}

TEST_CASE("at any scale and far from the origin") {
  Random random(6);
  for (const double scale : {1e-20, 1e-6, 1e6}) {
    auto mesh = icosphere<double>(3);
    for (auto& p : mesh.positions) p = {scale * p[0], scale * p[1], scale * p[2]};
    check(mesh, at_vertex(3), random);
  }
  auto sheet = grid<double>(16, 16, 16.0, 16.0);
  for (auto& p : sheet.positions) p[1] -= 1e8;
  check(sheet, at_vertex(5), random);
}

TEST_CASE("in single precision") {
  const auto mesh = icosphere<double>(3);
  Mesh<float> single{{}, mesh.faces};
  for (const auto& [x, y, z] : mesh.positions) {
    single.positions.push_back(
        {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  }
  Mesh<double> same{{}, mesh.faces};
  for (const auto& [x, y, z] : single.positions) same.positions.push_back({x, y, z});
  const auto exact = ExactSolver(same).distance(5);
  const auto distances = FastMarchingSolver(single).distance(5);
  const auto bounds = Certifier(single).bounds(5, distances);
  for (std::size_t v = 0; v < exact.size(); ++v) {
    CHECK(double{bounds.lower[v]} <= exact[v]);
    CHECK(double{bounds.upper[v]} >= exact[v]);
  }
}

TEST_CASE("tight: exact on sheets, well under a percent on smooth surfaces") {
  const auto sheet = grid<double>(40, 40);
  const auto on_sheet = Certifier(sheet).bounds(7, VirtualSourceSolver(sheet).distance(7));
  CHECK(gap(sheet, on_sheet, 7) < 1e-7);
  const auto gel = membrane<double>(0.01146, 0.0455, 0.001);
  CHECK(gap(gel, Certifier(gel).bounds(130, FastMarchingSolver(gel).distance(130)), 130) < 2e-3);
  const auto sphere = icosphere<double>(5);
  CHECK(gap(sphere, Certifier(sphere).bounds(3, FastMarchingSolver(sphere).distance(3)), 3) < 8e-3);
}

TEST_CASE("one bad sliver loosens the bounds but little") {
  auto mesh = grid<double>(40, 40);
  const auto clean = gap(mesh, Certifier(mesh).bounds(0, ExactSolver(mesh).distance(0)), 0);
  for (const double height : {1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
    auto sliver = mesh;  // one face gets a cap of this height at an edge
    const auto [a, b, c] = sliver.faces[1000];
    const auto& pa = sliver.positions[static_cast<std::size_t>(a)];
    const auto& pb = sliver.positions[static_cast<std::size_t>(b)];
    const auto middle = static_cast<Index>(sliver.positions.size());
    sliver.positions.push_back({(pa[0] + pb[0]) / 2, (pa[1] + pb[1]) / 2 + height, 0});
    sliver.faces[1000] = {a, middle, c};
    sliver.faces.push_back({middle, b, c});
    sliver.faces.push_back({a, b, middle});
    auto distances = ExactSolver(sliver).distance(0);
    distances[static_cast<std::size_t>(middle)] *= 1 + 1e-6;  // nobody's distances are exact
    const double loose = gap(sliver, Certifier(sliver).bounds(0, distances), 0);
    MESSAGE("height " << height << ": mean gap " << loose << ", without " << clean);
    CHECK(loose < clean + 3e-4);  // divided by the largest gradient: 1 to infinite
  }
}

TEST_CASE("the largest error that distances can have") {
  const DistanceBounds<double> bounds{{0, 0.9, 2, infinite}, {0, 1, 2, infinite}};
  const std::vector<double> good{0, 0.95, 2, infinite};
  CHECK(bounds.error_of(good).max == gelight::test::approx(0.95 / 0.9 - 1));
  CHECK(bounds.error_of(std::vector<double>{0.1, 0.95, 2, infinite}).max == infinite);
  CHECK(bounds.error_of(std::vector<double>{0, 0.95, 2, 7}).max == infinite);
  CHECK(bounds.error_of(std::vector<double>{0, infinite, 2, infinite}).max == infinite);
  CHECK_THROWS_AS((void)bounds.error_of(std::vector<double>{0}), InvalidInput);
  auto uneven = bounds;
  uneven.lower.pop_back();
  CHECK_THROWS_AS((void)uneven.error_of(good), InvalidInput);
}

TEST_CASE("what cannot be used is refused") {
  const auto mesh = grid<double>(2, 2);
  const Certifier certifier(mesh);
  std::vector<double> distances(9, 1.0);
  CHECK_THROWS_AS((void)certifier.bounds(9, distances), InvalidInput);
  CHECK_THROWS_AS((void)certifier.bounds(0, std::vector<double>(8, 1.0)), InvalidInput);
  distances[4] = std::nan("");
  CHECK_THROWS_WITH_AS((void)certifier.bounds(0, distances), doctest::Contains("vertex 4"),
                       InvalidInput);
}
