#include "gelight/geodesic/heat.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"
#include "support/relative_error.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Error;
using test::error_of;

static_assert(gelight::DistanceSolver<HeatSolver<float>, float>);
static_assert(gelight::DistanceSolver<HeatSolver<double>, double>);

namespace {

Vec3<double> at(const Mesh<double>& mesh, std::size_t v) {
  return {mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]};
}

// (Nothing from a point to itself, which a cross product is not where the compiler fuses.)
double arc(const Vec3<double>& a, const Vec3<double>& b) {
  return 2 * std::atan2((a - b).norm(), (a + b).norm());
}

Error sphere_error(int level, Index source, const HeatOptions& options = {}) {
  const auto mesh = icosphere<double>(level);
  const auto d = HeatSolver(mesh, options).distance(source);
  const auto s = at(mesh, static_cast<std::size_t>(source));
  return error_of(d, [&](std::size_t v) { return arc(s, at(mesh, v)); });
}

Mesh<double> scaled(Mesh<double> mesh, double s) {
  for (auto& p : mesh.positions) p = {s * p[0], s * p[1], s * p[2]};
  return mesh;
}

// A flat disc of radius 1 in this many rings, vertex 0 in the middle.
Mesh<double> disc(int rings) {
  std::vector<ProfilePoint<double>> profile{{0, 0}};
  for (int i = 1; i <= rings; ++i) profile.push_back({1.0 * i / rings, 0});
  return revolve<double>(profile, 1.0 / rings);
}

Mesh<double> parts_and_a_stray() {
  const std::vector<Mesh<double>> parts{icosphere<double>(2), grid<double>(8, 8)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({9, 9, 9});
  return mesh;
}

}  // namespace

TEST_CASE("spheres: what the options buy, at each level") {
  const HeatOptions plain{.exact_radius = 0};
  const HeatOptions refined{.refinements = 1};
  double before = 0;
  for (const int level : {3, 4, 5}) {
    const Error heat = sphere_error(level, 12, plain);
    const Error error = sphere_error(level, 12);
    const Error better = sphere_error(level, 12, refined);
    MESSAGE("level " << level << ", mean and max: plain heat " << heat.mean << " " << heat.max
                     << ", by default " << error.mean << " " << error.max << ", refined "
                     << better.mean << " " << better.max);
    CHECK(heat.max < 0.16);  // beside the source, at every level
    if (before > 0) CHECK(std::log2(before / heat.mean) > 0.4);
    before = heat.mean;
    CHECK(error.mean < 0.005);
    CHECK(error.max < 0.012);
    CHECK(better.mean < 0.003);
    CHECK(better.max < 0.012);
  }
}

TEST_CASE("one triangle and two are exact") {
  const Mesh<double> one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const Mesh<double> two{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 3}, {1, 2, 3}}};
  CHECK(HeatSolver(one).distance(1)[2] == gelight::test::approx(std::sqrt(2.0)).epsilon(1e-14));
  CHECK(HeatSolver(two).distance(0)[2] == gelight::test::approx(std::sqrt(2.0)).epsilon(1e-14));
}

TEST_CASE("needles: the intrinsic Delaunay triangulation brings the error down") {
  for (const double stretch : {10.0, 100.0}) {
    auto mesh = disc(15);
    for (auto& p : mesh.positions) p[0] *= stretch;
    const Index source = 0;
    const auto truth = [&](std::size_t v) { return (at(mesh, v) - at(mesh, 0)).norm(); };
    const HeatOptions heat{.exact_radius = 0, .intrinsic_delaunay = false};
    const HeatOptions flipped{.exact_radius = 0};
    const HeatOptions both{};
    const Error plain = error_of(HeatSolver(mesh, heat).distance(source), truth);
    const Error delaunay = error_of(HeatSolver(mesh, flipped).distance(source), truth);
    const Error full = error_of(HeatSolver(mesh, both).distance(source), truth);
    MESSAGE("stretched x" << stretch << ", mean and max: plain " << plain.mean << " " << plain.max
                          << ", Delaunay " << delaunay.mean << " " << delaunay.max
                          << ", and exact near " << full.mean << " " << full.max);
    CHECK(delaunay.mean < plain.mean / 2);
    CHECK(full.max < plain.max / 2);
  }
}

TEST_CASE("a strip far longer than heat reaches in doubles") {
  for (const Index n : {300, 1000, 10000}) {
    const auto mesh = grid<double>(n, 1, n, 1);
    const auto d = HeatSolver(mesh).distance(0);
    const auto last = static_cast<std::size_t>(n);
    CHECK(d[last] == gelight::test::approx(n).epsilon(1e-3));
    for (std::size_t x = 10; x < last; ++x) {
      CHECK(d[x + 1] > d[x]);  // no face of zero gradient
      CHECK(d[x] == gelight::test::approx(static_cast<double>(x)).epsilon(0.02));
    }
  }
}

TEST_CASE("parts without a source and stray vertices are infinite, each part stands alone") {
  const auto mesh = parts_and_a_stray();
  const HeatSolver solver(mesh);
  const auto sphere = HeatSolver(icosphere<double>(2));
  const auto d = solver.distance(3);
  CHECK(d[3] == 0);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::isfinite(d[v]) == (v < 162));
  const auto stray = static_cast<Index>(mesh.positions.size()) - 1;
  const auto from_stray = solver.distance(stray);
  for (Index v = 0; v < stray; ++v)
    CHECK(from_stray[static_cast<std::size_t>(v)] == unreachable<double>);
  CHECK(from_stray.back() == 0);

  // A source in each part gives each part its own answer.
  const auto sheet = solver.distance(162);
  const auto both = solver.distance(std::vector<Index>{3, 162});
  for (std::size_t v = 0; v + 1 < d.size(); ++v) {
    CHECK(both[v] == gelight::test::approx(v < 162 ? d[v] : sheet[v]).epsilon(1e-9));
  }
}

TEST_CASE("the scale of the mesh is the scale of the answer") {
  const auto mesh = icosphere<double>(3);
  const auto expected = HeatSolver(mesh).distance(0);
  for (const double s : {1e-20, 1e-6, 1e6}) {
    const auto d = HeatSolver(scaled(mesh, s)).distance(0);
    for (std::size_t v = 0; v < d.size(); ++v) {
      CHECK(d[v] / s == gelight::test::approx(expected[v]).epsilon(1e-12));
    }
  }
}

TEST_CASE("turned, moved, renumbered and flipped: the same distances") {
  const auto mesh = torus(2.0, 0.7, 30, 14);
  const auto expected = HeatSolver(mesh).distance(0);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vec3<double>(1, 2, 3).normalized()).toRotationMatrix();
  const auto moved = HeatSolver(placed(mesh, turn, Vec3<double>(3, -4, 5))).distance(0);
  auto flipped = mesh;
  for (std::size_t f = 0; f < mesh.faces.size(); f += 3) {
    std::swap(flipped.faces[f][0], flipped.faces[f][2]);
  }
  const auto other = HeatSolver(flipped).distance(0);
  auto renumbered = mesh;
  const auto count = static_cast<Index>(mesh.positions.size());
  for (auto& p : renumbered.faces) p = {count - 1 - p[1], count - 1 - p[2], count - 1 - p[0]};
  std::reverse(renumbered.positions.begin(), renumbered.positions.end());
  const auto reversed = HeatSolver(renumbered).distance(count - 1);
  for (std::size_t v = 0; v < expected.size(); ++v) {
    CHECK(moved[v] == gelight::test::approx(expected[v]).epsilon(1e-10));
    CHECK(other[v] == gelight::test::approx(expected[v]).epsilon(1e-10));
    CHECK(reversed[expected.size() - 1 - v] == gelight::test::approx(expected[v]).epsilon(1e-10));
  }
}

TEST_CASE("far from the origin nothing is lost but what the positions have lost") {
  auto mesh = grid<double>(20, 20);
  const auto expected = HeatSolver(mesh).distance(0);
  for (auto& p : mesh.positions) p[0] += 1e6;
  const auto d = HeatSolver(mesh).distance(0);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::abs(d[v] - expected[v]) < 1e-8);
}

TEST_CASE("sources on edges and in faces") {
  const auto mesh = grid<double>(40, 40);
  const HeatSolver solver(mesh);
  const auto check = [&](const SurfacePoint<double>& point) {
    const std::vector<Source<double>> sources{{point, 0}};
    const auto d = solver.distance(sources);
    const Vec3<double> s = Surface(mesh).position(point);
    const Error error = error_of(d, [&](std::size_t v) { return (at(mesh, v) - s).norm(); });
    MESSAGE("mean " << error.mean << ", max " << error.max);
    CHECK(error.mean < 0.03);
    CHECK(error.max < 0.35);
  };
  check(edge_point<double>(20 * 41 + 20, 20 * 41 + 21, 0.3));
  check(face_point<double>(20 * 80 + 41, {0.2, 0.3, 0.5}));
  const std::vector<Source<double>> corner{{face_point<double>(0, {1, 0, 0}), 0}};
  CHECK(solver.distance(corner) == solver.distance(0));
}

TEST_CASE("several sources, repeated sources, start distances") {
  const auto mesh = icosphere<double>(4);
  const HeatSolver solver(mesh);
  const auto a = solver.distance(3), b = solver.distance(700);
  const auto both = solver.distance(std::vector<Index>{3, 700});
  double worst = 0;
  for (std::size_t v = 0; v < both.size(); ++v) {
    worst = std::max(worst, std::abs(both[v] - std::min(a[v], b[v])));
  }
  MESSAGE("off the smaller of the single answers by " << worst);
  CHECK(worst < 0.07);  // an edge length
  CHECK(solver.distance(std::vector<Index>{700, 3, 700, 3, 3}) == both);

  const std::vector<Source<double>> started{{vertex_point<double>(3), 0.5},
                                            {vertex_point<double>(700), -0.25}};
  const auto d = solver.distance(started);
  for (std::size_t v = 0; v < d.size(); ++v) {
    CHECK(d[v] == gelight::test::approx(std::min(a[v] + 0.5, b[v] - 0.25)).epsilon(1e-12));
  }
}

TEST_CASE("a source at a border or a corner and one inside: fronts meet halfway") {
  for (const Index k : {1, 2}) {
    const Index nx = 40 * k, ny = 30 * k;
    const auto mesh = grid<double>(nx, ny, 4, 3);
    const HeatSolver solver(mesh);
    const auto vertex = [&](double x, double y) {
      return static_cast<Index>(std::lround(10 * k * y)) * (nx + 1) +
             static_cast<Index>(std::lround(10 * k * x));
    };
    for (const auto& sources : std::vector<std::vector<Index>>{{vertex(2, 0), vertex(2, 2)},
                                                               {vertex(0, 0), vertex(2, 1.5)},
                                                               {vertex(4, 3), vertex(1, 1.5)},
                                                               {vertex(0, 1), vertex(3, 2)}}) {
      const auto d = solver.distance(sources);
      const Error error = error_of(d, [&](std::size_t v) {
        double nearest = 1e300;
        for (const Index s : sources) {
          nearest = std::min(nearest, (at(mesh, v) - at(mesh, static_cast<std::size_t>(s))).norm());
        }
        return nearest;
      });
      // Much as of one source alone; with as much heat at a border as inside, twice that.
      CHECK(error.mean < (k == 1 ? 0.02 : 0.015));
    }
  }
}

TEST_CASE("a whole side as the source") {
  const Index n = 40;
  const auto mesh = grid<double>(n, n);
  std::vector<Index> side;
  for (Index y = 0; y <= n; ++y) side.push_back(y * (n + 1));
  const auto d = HeatSolver(mesh).distance(side);
  const Error error = error_of(d, [&](std::size_t v) { return mesh.positions[v][0]; });
  MESSAGE("mean " << error.mean << ", max " << error.max);
  CHECK(error.mean < 0.01);
  for (std::size_t v = 0; v < d.size(); ++v) CHECK(std::abs(d[v] - mesh.positions[v][0]) < 0.5 / n);
}

TEST_CASE("how each border rule bends the isolines, by distance from the border") {
  const auto mesh = disc(30);
  Index source = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto off = [&](std::size_t i) { return (at(mesh, i) - Vec3<double>(0.5, 0, 0)).norm(); };
    if (off(v) < off(static_cast<std::size_t>(source))) source = static_cast<Index>(v);
  }
  std::array<double, 3> at_border{}, inside{};
  for (const auto boundary :
       {HeatBoundary::neumann, HeatBoundary::dirichlet, HeatBoundary::averaged}) {
    const auto rule = static_cast<std::size_t>(boundary);
    const auto d = HeatSolver(mesh, {.boundary = boundary}).distance(source);
    for (std::size_t v = 0; v < d.size(); ++v) {
      const auto p = at(mesh, v);
      const double off = std::abs(d[v] - (p - at(mesh, static_cast<std::size_t>(source))).norm());
      double& worst = p.norm() > 1 - 2.5 / 30 ? at_border[rule] : inside[rule];
      worst = std::max(worst, off);
    }
    MESSAGE("rule " << rule << ": largest error " << at_border[rule] << " on the outer two rings, "
                    << inside[rule] << " inside");
    CHECK(at_border[rule] < 0.05);
    CHECK(inside[rule] < 0.04);
  }
  CHECK(at_border[2] < std::max(at_border[0], at_border[1]));
}

TEST_CASE("degenerate faces leave finite answers that are about right") {
  // A square sheet; then one edge gets a vertex on it with a face of no area, and a zero edge.
  auto mesh = grid<double>(10, 10);
  const auto plain = HeatSolver(mesh).distance(0);
  const auto count = static_cast<Index>(mesh.positions.size());

  auto cap = mesh;  // face 0 is (0, 1, 12): a vertex on its edge 1-12, seen from face 0 only
  cap.positions.push_back({0.1, 0.05, 0});
  cap.faces[0] = {0, 1, count};
  cap.faces.push_back({0, count, 12});
  cap.faces.push_back({count, 1, 12});
  const auto d = HeatSolver(cap).distance(0);
  for (std::size_t v = 0; v < plain.size(); ++v) {
    CHECK(std::isfinite(d[v]));
    CHECK(std::abs(d[v] - plain[v]) < 0.02);
  }

  auto doubled = mesh;  // vertex 60 twice at one place, with faces of no area between
  doubled.positions.push_back(mesh.positions[60]);
  Index neighbour = -1;
  for (auto& face : doubled.faces) {
    for (auto& v : face) {
      if (v != 60 || neighbour >= 0) continue;
      v = count;
      neighbour = face[0] == count ? face[1] : face[0];
    }
  }
  doubled.faces.push_back({60, count, neighbour});
  const auto e = HeatSolver(doubled).distance(0);
  for (const double x : e) CHECK(std::isfinite(x));
  CHECK(std::abs(e[60] - e.back()) < 1e-3);
}

TEST_CASE("three faces on an edge, bow-ties, single triangles") {
  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  for (const double x : HeatSolver(fin).distance(2)) CHECK(std::isfinite(x));
  const Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  for (const double x : HeatSolver(bow).distance(1)) CHECK(std::isfinite(x));
  const Mesh<double> point{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}};
  for (const double x : HeatSolver(point).distance(1)) CHECK(x == 0);
}

TEST_CASE("queries leave no trace and may run at once") {
  const auto mesh = icosphere<double>(3);
  const HeatSolver solver(mesh);
  const auto expected = solver.distance(5);
  (void)solver.distance(77);
  CHECK(solver.distance(5) == expected);
  CHECK(HeatSolver(mesh).distance(5) == expected);
  std::vector<std::vector<double>> results(4);
  {
    std::vector<std::jthread> threads;
    for (auto& result : results) threads.emplace_back([&] { result = solver.distance(5); });
  }
  for (const auto& result : results) CHECK(result == expected);
}

TEST_CASE("flags: none on good meshes") {
  const std::array<Mesh<double>, 4> meshes{icosphere<double>(3), grid<double>(20, 20),
                                           torus(2.0, 0.7, 30, 14), disc(15)};
  for (const auto& mesh : meshes) {
    const HeatSolver solver(mesh);
    const auto result = solver.solve(7);
    CHECK(result.distance == solver.distance(7));
    CHECK_FALSE(result.is_too_coarse);
    CHECK_FALSE(result.is_too_far);
    CHECK(result.residual > 0);
    CHECK(result.residual < 0.13);
  }
  // The same in two parts, from sources that start late.
  const std::vector<Mesh<double>> meshes_of_parts{icosphere<double>(2), grid<double>(8, 8, 3, 3)};
  const HeatSolver solver(joined<double>(meshes_of_parts));
  const std::vector<Source<double>> sources{{vertex_point<double>(3), 0.5},
                                            {vertex_point<double>(200), -0.25}};
  const auto result = solver.solve(sources);
  CHECK(result.distance == solver.distance(sources));
  CHECK_FALSE(result.is_too_coarse);
  CHECK_FALSE(result.is_too_far);
}

TEST_CASE("flags and distances of one part are the same whenever another part starts") {
  auto needles = disc(15);
  for (auto& p : needles.positions) p[0] *= 100;
  const std::vector<Mesh<double>> parts{needles, icosphere<double>(3)};
  const auto mesh = joined<double>(parts);
  const auto on_needles = static_cast<Index>(needles.positions.size());
  for (const bool delaunay : {false, true}) {
    const HeatSolver solver(mesh, {.exact_radius = 0, .intrinsic_delaunay = delaunay});
    std::vector<Source<double>> sources{{vertex_point<double>(7), 0},
                                        {vertex_point<double>(on_needles + 7), 0}};
    const auto together = solver.solve(sources);
    if (!delaunay) CHECK(together.is_too_coarse);
    for (const double start : {-1e9, -1e6, -30.0, 1e-3, 30.0, 1e6, 1e9}) {
      for (const std::size_t late : {std::size_t{0}, std::size_t{1}}) {
        CAPTURE(start);
        CAPTURE(late);
        sources[late].distance = start;
        sources[1 - late].distance = 0;
        const auto apart = solver.solve(sources);
        CHECK(apart.error == together.error);
        CHECK(apart.residual == together.residual);
        CHECK(apart.is_too_coarse == together.is_too_coarse);
        double off = 0;
        for (std::size_t v = 0; v < together.distance.size(); ++v) {
          const bool is_late = (static_cast<Index>(v) >= on_needles) == (late == 1);
          const double want = together.distance[v] + (is_late ? start : 0);
          off = std::max(off, std::abs(apart.distance[v] - want));
        }
        CHECK(off == 0);
      }
    }
  }
}

TEST_CASE("flags: a mesh too coarse for heat alone is called so") {
  const Mesh<double> one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const Mesh<double> two{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 3}, {1, 2, 3}}};
  for (const auto& mesh : {one, two}) {
    CHECK(HeatSolver(mesh, {.exact_radius = 0}).solve(0).is_too_coarse);
    // Where all is exact, nothing is left to flag.
    const auto exact = HeatSolver(mesh, {.exact_radius = 4}).solve(0);
    CHECK_FALSE(exact.is_too_coarse);
    CHECK(exact.residual == 0);
  }
  auto needles = disc(15);
  for (auto& p : needles.positions) p[0] *= 100;
  CHECK(
      HeatSolver(needles, {.exact_radius = 0, .intrinsic_delaunay = false}).solve(0).is_too_coarse);
}

TEST_CASE("flags: heat that never arrives") {
  const auto mesh = icosphere<double>(3);
  const auto result = HeatSolver(mesh, {.time_factor = 1e-300}).solve(0);
  CHECK(result.is_too_far);
  CHECK_FALSE(HeatSolver(mesh, {.time_factor = 1e-6}).solve(0).is_too_far);
  // Where no path leads is not too far.
  const auto parts = HeatSolver(parts_and_a_stray()).solve(3);
  CHECK(parts.distance.back() == unreachable<double>);
  CHECK_FALSE(parts.is_too_far);
}

TEST_CASE("bad options and queries are refused") {
  const auto mesh = grid<double>(2, 2);
  CHECK_THROWS_AS(HeatSolver(mesh, {.time_factor = 0}), InvalidInput);
  CHECK_THROWS_AS(HeatSolver(mesh, {.time_factor = std::numeric_limits<double>::quiet_NaN()}),
                  InvalidInput);
  CHECK(test::contains(test::refusal([&] { (void)HeatSolver(mesh, {.time_factor = 1e308}); }),
                       "products with it are not finite"));
  for (const int boundary : {-1, 3, std::numeric_limits<int>::max()}) {
    const gelight::HeatOptions options{.boundary = static_cast<gelight::HeatBoundary>(boundary)};
    CHECK(test::contains(test::refusal([&] { (void)HeatSolver(mesh, options); }),
                         "boundary " + std::to_string(boundary)));
  }
  const HeatSolver solver(mesh);
  CHECK_THROWS_AS((void)solver.distance(9), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance(std::vector<Index>{}), InvalidInput);
  CHECK_THROWS_AS((void)solver.solve(9), InvalidInput);
  CHECK_THROWS_AS((void)solver.solve(std::vector<Index>{}), InvalidInput);
}

TEST_CASE("of several sources, each alone, the one is named that is refused") {
  const HeatSolver solver(grid<double>(2, 2));
  for (std::size_t wrong = 0; wrong < 10; ++wrong) {
    std::vector<gelight::Source<double>> sources(10, {gelight::vertex_point<double>(4), 0});
    sources[wrong].distance = std::numeric_limits<double>::quiet_NaN();
    const auto ask = [&] {
      (void)solver.distance_from_each(std::span<const gelight::Source<double>>(sources));
    };
    CHECK(test::contains(test::refusal(ask), "source " + std::to_string(wrong) + " starts"));
  }
}

namespace {

// Scan-like meshes, and sheets whose triangles get ever thinner or smaller to one side.
std::vector<test::NamedMesh> rough_meshes() {
  auto all = test::scan_meshes(3);
  test::Random random(7);
  for (const double slope : {2.0, 4.0, 8.0, 16.0}) {
    auto mesh = test::jittered_grid(24, 0.2, random);
    for (auto& p : mesh.positions) p[0] += slope * p[1];
    all.push_back({"sheared", mesh});
  }
  for (const double ratio : {10.0, 100.0, 1000.0}) {
    auto mesh = test::jittered_grid(24, 0.2, random);
    const double rate = std::log(ratio) / 24;
    for (auto& p : mesh.positions) p[0] = std::expm1(rate * p[0]) / rate;
    all.push_back({"graded", mesh});
  }
  for (const double height : {0.3, 1.0, 3.0}) {
    auto mesh = test::jittered_grid(24, 0.2, random);
    for (auto& p : mesh.positions) p[2] += test::uniform(random, -height, height);
    all.push_back({"rough", mesh});
  }
  return all;
}

}  // namespace

TEST_CASE(
    "flags: a mean error of a tenth never passes in silence, small ones seldom raise a flag") {
  int off = 0, silent = 0, good = 0, flagged = 0;
  test::Random random(11);
  for (const auto& named : rough_meshes()) {
    const auto& mesh = named.mesh;
    const ExactSolver exact(mesh);
    for (const bool delaunay : {true, false}) {
      const HeatSolver solver(mesh, {.intrinsic_delaunay = delaunay});
      for (int i = 0; i < 4; ++i) {
        const Index source = test::uniform_index(random, static_cast<Index>(mesh.positions.size()));
        const auto truth = exact.distance(source);
        const auto result = solver.solve(source);
        const double mean = error_of(result.distance, [&](std::size_t v) {
                              return std::isfinite(truth[v]) ? truth[v] : 0;
                            }).mean;
        off += mean > 0.1;
        silent += mean > 0.1 && result.is_reliable;
        good += mean < 0.05;
        flagged += mean < 0.05 && !result.is_reliable;
        if (mean > 0.1) {
          CHECK_MESSAGE(!result.is_reliable,
                        named.name << ": " << mean << ", said " << result.error);
        }
      }
    }
  }
  MESSAGE(off << " of more than a tenth, " << silent << " silent; " << good
              << " of less than a twentieth, " << flagged << " flagged");
  CHECK(off >= 30);
  CHECK(silent == 0);
  CHECK(flagged * 50 <= good);
}

TEST_CASE("thin triangles do no harm by default") {
  test::Random random(3);
  for (const double slope : {2.0, 4.0, 8.0}) {
    auto mesh = test::jittered_grid(30, 0.2, random);
    for (auto& p : mesh.positions) p[0] += slope * p[1];
    const HeatSolver solver(mesh);
    for (const Index source : {0, 480, 700}) {
      const Error error = error_of(solver.distance(source), [&](std::size_t v) {
        return (at(mesh, v) - at(mesh, static_cast<std::size_t>(source))).norm();
      });
      CHECK(error.mean < 0.05);
    }
  }
}

TEST_CASE("a refinement leaves the mean error as it is or lessens it, on rough meshes too") {
  double before = 0, after = 0;
  int worse = 0, meshes = 0;
  for (const auto& [name, mesh] : test::scan_meshes(3)) {
    const ExactSolver exact(mesh);
    const HeatSolver plain(mesh), refined(mesh, {.refinements = 1});
    const auto truth = exact.distance(5);
    const auto of = [&](std::size_t v) { return std::isfinite(truth[v]) ? truth[v] : 0; };
    const double a = error_of(plain.distance(5), of).mean;
    const double b = error_of(refined.distance(5), of).mean;
    before += a;
    after += b;
    worse += b > 1.1 * a;
    ++meshes;
  }
  MESSAGE("mean " << before / meshes << " before, " << after / meshes << " after, worse on "
                  << worse);
  CHECK(after < 0.9 * before);
  CHECK(worse * 8 <= meshes);
}

TEST_CASE("systems of another surface are refused, of the same one shared") {
  const Surface small(icosphere<double>(1)), large(icosphere<double>(3));
  auto moved_mesh = icosphere<double>(3);
  moved_mesh.positions[17][1] += 1e-9;
  auto turned_mesh = icosphere<double>(3);
  std::rotate(turned_mesh.faces[9].begin(), turned_mesh.faces[9].begin() + 1,
              turned_mesh.faces[9].end());
  const HeatSolver of_small(small), of_large(large);
  const auto share = [](const Surface<double>& surface, const HeatSolver<double>& other) {
    return HeatSolver<double>(surface, {}, other.system());
  };
  CHECK_THROWS_AS((void)share(large, of_small), InvalidInput);
  CHECK_THROWS_AS((void)share(small, of_large), InvalidInput);
  CHECK_THROWS_AS((void)share(Surface(moved_mesh), of_large), InvalidInput);
  CHECK_THROWS_AS((void)share(Surface(turned_mesh), of_large), InvalidInput);
  CHECK(share(Surface(icosphere<double>(3)), of_large).distance(7) == of_large.distance(7));
}

TEST_CASE("set-up and queries are cancelled wherever asked, and say how far they are") {
  auto mesh = icosphere<double>(4);
  for (auto& p : mesh.positions) p[0] *= 8;  // edges to flip
  int asked = 0, last = -1;
  double told = 0;
  const CancelHook hook([&](double done) {
    CHECK(done >= told);
    CHECK(done <= 1);
    told = done;
    return asked++ == last;
  });
  const HeatOptions options{.boundary = HeatBoundary::averaged, .cancelled = hook};
  const HeatSolver solver(mesh, options);
  const int in_set_up = std::exchange(asked, 0);
  CHECK(in_set_up > 100);
  for (last = 0; last < in_set_up; last += 1 + in_set_up / 20) {
    asked = 0;
    told = 0;
    CHECK_THROWS_AS(HeatSolver(mesh, options), Cancelled);
  }
  last = -1;
  told = 0;
  asked = 0;
  const auto expected = solver.distance(5);
  const int in_query = std::exchange(asked, 0);
  CHECK(in_query > 5);
  CHECK(expected == HeatSolver(mesh).distance(5));
  std::vector<double> out(expected.size(), -3);
  for (last = 0; last < in_query; ++last) {
    asked = 0;
    told = 0;
    CHECK_THROWS_AS(solver.distance_into(out, 5), Cancelled);
    CHECK(std::all_of(out.begin(), out.end(), [](double d) { return d == -3; }));
  }
  last = -1;
  told = 0;
  CHECK(solver.distance(5) == expected);
}

TEST_CASE("a source at a sharp corner is as near as others are") {
  auto mesh = grid<double>(16, 16, 1.0, 1.0);
  for (auto& p : mesh.positions) p[0] += 8 * p[1];
  const std::array<Index, 2> sources{0, 8 * 17 + 8};
  const auto found = HeatSolver(mesh).distance(sources);
  const auto exact = gelight::ExactSolver(mesh).distance(sources);
  double sum = 0;
  for (std::size_t v = 0; v < exact.size(); ++v) {
    if (exact[v] > 0) sum += std::abs(found[v] / exact[v] - 1);
  }
  CHECK(sum / static_cast<double>(exact.size() - 2) < 0.015);
}

TEST_CASE("a distance that float cannot hold is refused, and nothing written") {
  for (const double scale : {1e-60, 1e-39, 1e-30, 1e30, 3e36, 3e38, 1e60}) {
    CAPTURE(scale);
    auto mesh = icosphere<double>(2);
    for (auto& p : mesh.positions) p = {scale * p[0], 1.5 * scale * p[1], scale * p[2]};
    const HeatSolver<float> solver(mesh);
    std::vector<float> out(mesh.positions.size(), -1);
    if (scale > 1e-38 && scale < 1e38) {
      const auto d = HeatSolver(mesh).distance(7);
      solver.distance_into(out, 7);
      CHECK(out == std::vector<float>(d.begin(), d.end()));
      CHECK(solver.solve(7).distance == out);
      continue;
    }
    CHECK_THROWS_AS(solver.distance_into(out, 7), InvalidInput);
    CHECK_THROWS_AS((void)solver.solve(7), InvalidInput);
    CHECK(out == std::vector<float>(out.size(), -1));
  }
}
