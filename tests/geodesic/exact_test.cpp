#include "gelight/geodesic/exact.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"
#include "support/unfolding_oracle.hpp"

using gelight::edge_point;
using gelight::ExactField;
using gelight::ExactOptions;
using gelight::ExactSolver;
using gelight::face_point;
using gelight::Index;
using gelight::InvalidInput;
using gelight::Mesh;
using gelight::Source;
using gelight::Surface;
using gelight::SurfacePoint;
using gelight::Vec3;
using gelight::vertex_point;
using gelight::test::longest_edge;
using gelight::test::Random;
using gelight::test::uniform;
using gelight::test::uniform_index;

static_assert(gelight::DistanceSolver<ExactSolver<float>, float>);
static_assert(gelight::DistanceSolver<ExactSolver<double>, double>);

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Distances from a vertex of a mesh whose vertices lie on a line at these places: in each face one
// may go from edge to edge at a place of both, and so nowhere but at vertices' places, by
// Bellman-Ford.
std::vector<double> distances_on_line(const std::vector<std::array<Index, 3>>& faces,
                                      const std::vector<double>& places, Index source) {
  const std::size_t count = places.size();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return places[a] < places[b]; });
  // Of each edge, at each place in order.
  std::vector<std::vector<double>> known(count * count, std::vector<double>(count, infinity));
  std::vector<double> at(count, infinity);
  at[static_cast<std::size_t>(source)] = 0;
  bool any = true;
  const auto join = [&](double& one, double& other, double way) {
    any = any || one + way < other || other + way < one;
    other = std::min(other, one + way);
    one = std::min(one, other + way);
  };
  while (any) {
    any = false;
    for (const auto& face : faces) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto corner = [&](std::size_t i) { return static_cast<std::size_t>(face[i % 3]); };
        const auto side = [&](std::size_t i) -> std::vector<double>& {
          return known[std::min(corner(i), corner(i + 1)) * count +
                       std::max(corner(i), corner(i + 1))];
        };
        const auto holds = [&](std::size_t i, double x) {
          const auto [low, high] = std::minmax(places[corner(i)], places[corner(i + 1)]);
          return low <= x && x <= high;
        };
        for (std::size_t i = 0; i < count; ++i) {
          const double x = places[order[i]];
          if (!holds(k, x)) continue;
          if (holds(k + 1, x)) join(side(k)[i], side(k + 1)[i], 0);
          if (order[i] == corner(k) || order[i] == corner(k + 1)) join(side(k)[i], at[order[i]], 0);
          if (i + 1 == count) continue;
          const double next = places[order[i + 1]];
          if (holds(k, next)) join(side(k)[i], side(k)[i + 1], next - x);
        }
      }
    }
  }
  return at;
}

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

Vec3<double> position(const Mesh<double>& mesh, Index v) {
  return Vec3<double>(mesh.positions[at(v)].data());
}

Index count(const Mesh<double>& mesh) { return static_cast<Index>(mesh.positions.size()); }

// The largest relative error of the distances from a vertex, where `exact(v)` tells the right one.
template <class Exact>
double worst_error(const Mesh<double>& mesh, Index source, const Exact& exact) {
  const std::vector<double> d = ExactSolver(mesh).distance(source);
  double worst = std::fabs(d[at(source)]);
  for (Index v = 0; v < count(mesh); ++v) {
    const double right = exact(v);
    if (right > 0) worst = std::max(worst, std::fabs(d[at(v)] - right) / right);
  }
  return worst;
}

double worst_euclidean_error(const Mesh<double>& mesh, Index source) {
  return worst_error(mesh, source,
                     [&](Index v) { return (position(mesh, v) - position(mesh, source)).norm(); });
}

// The largest difference, relative to the larger number or a tenth of the largest of all.
double worst_difference(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  double scale = 0;
  for (const double x : b) scale = std::isfinite(x) ? std::max(scale, std::fabs(x)) : scale;
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == b[i]) continue;
    worst = std::max(worst, std::fabs(a[i] - b[i]) / std::max(std::fabs(b[i]), 0.1 * scale));
  }
  return worst;
}

// The largest relative difference between a path's length with its start and the point's distance.
double path_error(const Surface<double>& surface, const ExactField<double>& field,
                  const std::vector<Source<double>>& sources, const SurfacePoint<double>& p) {
  const auto path = field.path(p);
  const double d = field.distance(p);
  if (path.empty()) return std::isfinite(d) ? infinity : 0;
  double start = infinity;
  for (const auto& source : sources) {
    const double gap = (surface.position(source.point) - surface.position(path[0])).norm();
    if (gap < 1e-9) start = std::min(start, source.distance);
  }
  const double reach = start + gelight::length(surface, path);
  return std::fabs(reach - d) / std::max(std::fabs(d), 0.1);
}

struct RandomCase {
  Mesh<double> mesh;
  std::vector<Source<double>> sources;
  Random random;

  explicit RandomCase(int seed) : random(static_cast<std::uint64_t>(seed)) {
    mesh = gelight::test::small_random_mesh(seed, random);
    const Index sources_count = 1 + uniform_index(random, 3);
    for (Index i = 0; i < sources_count; ++i) {
      const double start = i == 0 ? 0 : uniform(random, -0.5, 0.5);
      sources.push_back({gelight::test::random_point(mesh, random), start});
    }
  }

  [[nodiscard]] std::span<const Source<double>> span() const { return sources; }
};

// Brute force and solver on one random mesh: distances, and the lengths of all paths.
double oracle_error(int seed) {
  const RandomCase c(seed);
  gelight::test::UnfoldingOracle oracle(c.mesh);
  const ExactSolver solver(c.mesh);
  const auto field = solver.solve(c.span());
  const std::vector<double> distance = solver.distance(c.span());
  double worst = worst_difference(distance, oracle.distance(c.sources));
  CHECK(distance == field.distances());
  const Surface surface(c.mesh);
  for (Index v = 0; v < count(c.mesh); ++v) {
    worst = std::max(worst, path_error(surface, field, c.sources, vertex_point<double>(v)));
  }
  return worst;
}

// A small mesh on a lattice, so that vertices coincide, edges lie on one line and faces have no
// area; with caps on edges, and often stretched to needles.
Mesh<double> lattice_mesh(Random& random) {
  Mesh<double> mesh = gelight::test::small_random_mesh(uniform_index(random, 10), random);
  const double step = std::array{0.25, 0.5, 1.0}[at(uniform_index(random, 3))];
  for (auto& p : mesh.positions) {
    for (double& x : p) x = std::round(x / step) * step;
  }
  for (Index caps = uniform_index(random, 4); caps > 0; --caps) {
    const auto face = mesh.faces[at(uniform_index(random, static_cast<Index>(mesh.faces.size())))];
    const Vec3<double> a = position(mesh, face[0]), b = position(mesh, face[1]);
    const Vec3<double> cap = a + (uniform(random, 0, 1) < 0.2 ? 0 : 0.5) * (b - a);
    mesh.faces.push_back({face[0], face[1], count(mesh)});
    mesh.positions.push_back({cap[0], cap[1], cap[2]});
  }
  if (uniform(random, 0, 1) < 0.3) {
    for (auto& p : mesh.positions) p[2] *= 300;
  }
  return mesh;
}

struct Mismatch {
  double both_ways = 0, path = 0;
};

// From a vertex to all others: how far the distances there and back differ, and the lengths of the
// paths from the distances, relative to the distances; but for the rounding of coordinates.
Mismatch mismatch(const Mesh<double>& mesh, Index source) {
  const ExactSolver solver(mesh);
  const Surface<double>& surface = solver.surface();
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * longest_edge(surface);
  Mismatch worst;
  for (const bool keep : {true, false}) {
    const auto field = solver.solve(source, {.keep_windows = keep});
    for (Index v = 0; v < count(mesh); ++v) {
      const double d = field.distance(v), back = solver.distance(v)[at(source)];
      if (d == back && !(d < infinity)) continue;
      const auto path = field.path(v);
      REQUIRE(!path.empty());
      REQUIRE(path.front() == vertex_point<double>(source));
      REQUIRE(path.back() == vertex_point<double>(v));
      const double scale = std::max(d, 1e3 * rounding);
      const double off = std::fabs(gelight::length(surface, path) - d);
      worst.both_ways = std::max(worst.both_ways, std::fabs(d - back) / scale);
      worst.path = std::max(worst.path, (off - rounding) / scale);
    }
  }
  return worst;
}

// Needles of the meshes on lattices are up to 1e5 times as long as wide, and rounding grows so.
constexpr double lattice_rounding = 1e-10;

void check_lattice_mesh(std::uint64_t seed) {
  Random random(seed);
  const Mesh<double> mesh = lattice_mesh(random);
  const Index source = uniform_index(random, count(mesh));
  if (!gelight::check(mesh).is_accepted()) return;
  CAPTURE(seed);
  const Mismatch worst = mismatch(mesh, source);
  CHECK(worst.both_ways < lattice_rounding);
  CHECK(worst.path < lattice_rounding);
}

}  // namespace

TEST_CASE("a flat grid with random diagonals, full of ties: Euclidean") {
  Random random(1);
  for (const Index n : {4, 5, 7, 11, 16, 23, 31, 40}) {
    const Mesh<double> mesh = gelight::test::random_grid(n, random);
    CHECK(worst_euclidean_error(mesh, 0) < 1e-14);
    CHECK(worst_euclidean_error(mesh, (n + 1) * (n / 2) + n / 3) < 1e-14);
  }
}

TEST_CASE("a jittered and a graded grid, a long strip: Euclidean") {
  Random random(2);
  CHECK(worst_euclidean_error(gelight::test::jittered_grid(30, 0.2, random), 0) < 1e-14);
  Mesh<double> graded = gelight::test::jittered_grid(24, 0.2, random);
  for (auto& p : graded.positions) {
    for (double& x : p) x = std::pow(1e4, x / 24);
  }
  CHECK(worst_euclidean_error(graded, 0) < 1e-13);
  CHECK(worst_euclidean_error(gelight::grid<double>(10000, 1, 10000, 1), 0) < 1e-12);
}

TEST_CASE("needles: the error grows no faster than the aspect ratio") {
  Random random(3);
  for (const double aspect : {1e2, 1e3, 1e4}) {
    Mesh<double> mesh = gelight::test::jittered_grid(20, 0.2, random);
    for (auto& p : mesh.positions) p[1] *= aspect;
    CHECK(worst_euclidean_error(mesh, 0) < 1e-15 * aspect);
  }
}

TEST_CASE("cones: the law of cosines on the flattened cone, round the apex beyond pi") {
  const std::array<double, 3> radii{0.5, 1, 1.7};
  for (const double angle : {1.0, 3.0, 5.0, 7.0, 9.0, 12.0}) {
    const Index spokes = 24;
    const Mesh<double> mesh = gelight::test::cone(angle, spokes, radii);
    const auto radius = [&](Index v) { return v == 0 ? 0 : radii[at((v - 1) / spokes)]; };
    for (const Index source : {1, 30, 70, 0}) {
      CHECK(worst_error(mesh, source, [&](Index v) {
              const double turn = ((v - 1) % spokes - (source - 1) % spokes) * angle / spokes;
              if (v == 0 || source == 0) return radius(v) + radius(source);
              return gelight::test::cone_distance(angle, radius(source), radius(v), turn);
            }) < 1e-13);
    }
  }
}

TEST_CASE("an open prism: unrolled, the shorter way round") {
  const Index sides = 17, rows = 12;
  const double side = 2 * std::sin(std::numbers::pi / sides);
  Mesh<double> mesh;
  for (Index r = 0; r <= rows; ++r) {
    for (Index j = 0; j < sides; ++j) {
      const double u = 2 * std::numbers::pi * j / sides;
      mesh.positions.push_back({std::cos(u), std::sin(u), 0.3 * r});
      if (r == rows) continue;
      const Index a = r * sides + j, b = r * sides + (j + 1) % sides;
      mesh.faces.push_back({a, b, b + sides});
      mesh.faces.push_back({a, b + sides, a + sides});
    }
  }
  for (const Index source : {0, 5 * sides + 3}) {
    CHECK(worst_error(mesh, source, [&](Index v) {
            const Index turn = std::abs(v % sides - source % sides);
            const double x = side * std::min(turn, sides - turn);
            return std::hypot(x, 0.3 * (v / sides - source / sides));
          }) < 1e-14);
  }
}

TEST_CASE("plane pieces with corners and a slit: the path of sight round the corners") {
  Random random(4);
  const Index n = 20;
  const Vec3<double> corner(n / 2.0, n / 2.0, 0);
  const Mesh<double> slit = gelight::test::slit_sheet(n, random);
  const Index source = (n / 2 + 5) * (n + 1) + 4;
  const Vec3<double> from = position(slit, source);
  CHECK(worst_error(slit, source, [&](Index v) {
          const Vec3<double> to = position(slit, v);
          const double straight = (to - from).norm();
          const bool right =
              to.x() > corner.x() || (to.x() == corner.x() && v >= (n + 1) * (n + 1));
          if (!right) return straight;
          const double y =
              from.y() + (to.y() - from.y()) * (corner.x() - from.x()) / (to.x() - from.x());
          return y <= corner.y() ? straight : (from - corner).norm() + (to - corner).norm();
        }) < 1e-14);

  const Mesh<double> bend = gelight::test::sheet_with_hole(
      n, random, [&](double x, double y) { return x > n / 2.0 && y > n / 2.0; });
  const Index top = n * (n + 1);
  CHECK(worst_error(bend, top, [&](Index v) -> double {
          const Vec3<double> a = position(bend, top), b = position(bend, v);
          if (b.x() > corner.x() && b.y() > corner.y()) return infinity;  // in no face
          const bool sees = b.x() <= corner.x() || (corner - a).cross(b - a).z() <= 0;
          return sees ? (b - a).norm() : (corner - a).norm() + (b - corner).norm();
        }) < 1e-14);
}

TEST_CASE("a box: from corner to corner over the shortest unfolding") {
  for (const auto& [x, y, z] : {std::array{1., 1., 1.}, {1., 2., 3.}, {5., 1., 1.}, {.1, 2., .7}}) {
    const Mesh<double> mesh = gelight::box<double>(x, y, z);
    for (Index source = 0; source < 8; ++source) {
      CHECK(worst_error(mesh, source, [&](Index v) {
              const Vec3<double> d = (position(mesh, v) - position(mesh, source)).cwiseAbs();
              if (d.minCoeff() < 1e-12) return d.norm();
              return std::min({std::hypot(d.x() + d.y(), d.z()), std::hypot(d.x() + d.z(), d.y()),
                               std::hypot(d.y() + d.z(), d.x())});
            }) < 1e-14);
    }
  }
}

TEST_CASE("icospheres: great circles, with order two") {
  double before = 0;
  for (int level = 1; level <= 5; ++level) {
    const Mesh<double> mesh = gelight::icosphere<double>(level);
    const std::vector<double> d = ExactSolver(mesh).distance(0);
    double error = 0;
    for (Index v = 1; v < count(mesh); ++v) {
      const Vec3<double> a = position(mesh, 0), b = position(mesh, v);
      const double circle = std::atan2(a.cross(b).norm(), a.dot(b));
      CHECK(d[at(v)] <= circle);
      error += (circle - d[at(v)]) / circle / (count(mesh) - 1);
    }
    const double edge =
        (position(mesh, mesh.faces[0][0]) - position(mesh, mesh.faces[0][1])).norm();
    CHECK(error < 0.15 * edge * edge);
    if (level > 3) CHECK(std::log2(before / error) > 1.9);
    before = error;
  }
}

TEST_CASE("a fan of many spokes: Euclidean, in time that follows the valence") {
  for (const Index spokes : {100, 10000}) {
    Mesh<double> mesh{{{0, 0, 0}}, {}};
    for (Index j = 0; j < spokes; ++j) {
      const double u = 2 * std::numbers::pi * j / spokes;
      mesh.positions.push_back({std::cos(u), std::sin(u), 0});
      mesh.faces.push_back({0, 1 + j, 1 + (j + 1) % spokes});
    }
    CHECK(worst_euclidean_error(mesh, 0) < 1e-15);
    // Chords of the polygon, whose corners do not bend paths.
    CHECK(worst_euclidean_error(mesh, 1) < 1e-12);
  }
}

TEST_CASE("one and two triangles") {
  Mesh<double> mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}}};
  CHECK(ExactSolver(mesh).distance(0) == std::vector<double>{0, 1, 1, infinity});
  mesh.faces.push_back({1, 3, 2});
  CHECK(ExactSolver(mesh).distance(0)[3] == gelight::test::approx(std::sqrt(2.0)).epsilon(1e-15));
}

TEST_CASE("zero-area faces and zero-length edges") {
  // A square whose diagonal has a vertex in its middle, by two caps without area.
  const Mesh<double> cap{{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, 0}},
                         {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {4, 2, 3}}};
  for (Index source = 0; source < 5; ++source) {
    CHECK(worst_euclidean_error(cap, source) < 1e-15);
  }
  // Caps on caps: all on one line between two faces.
  const Mesh<double> caps{{{0, 0, 0}, {4, 0, 0}, {2, 3, 0}, {2, -3, 0}, {1, 0, 0}, {3, 0, 0}},
                          {{0, 1, 2}, {0, 4, 1}, {4, 5, 1}, {0, 3, 4}, {4, 3, 5}, {5, 3, 1}}};
  for (Index source = 0; source < 6; ++source) {
    CHECK(worst_euclidean_error(caps, source) < 1e-15);
  }
  // The middle column of a grid folded to no width: its vertices are double.
  Random random(5);
  Mesh<double> folded = gelight::test::random_grid(7, random);
  for (auto& p : folded.positions) p[0] -= p[0] > 3 ? 1 : 0;
  for (const Index source : {0, 19, 27, 28, 60}) {
    CHECK(worst_euclidean_error(folded, source) < 1e-14);
    const auto d = ExactSolver(folded).distance(source);
    for (Index row = 0; row < 8; ++row) CHECK(d[at(8 * row + 3)] == d[at(8 * row + 4)]);
  }
}

TEST_CASE("from a face that is a point, or has a side of no length, a direction is a unit vector") {
  const Mesh<double> mesh{{{1, 1, 0}, {0, 1, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 0}, {0, 1, 0}},
                          {{1, 4, 3}, {3, 1, 0}, {5, 1, 3}, {1, 2, 5}}};
  const ExactSolver solver(mesh);
  const auto here = face_point<double>(3, {0.6, 0.3, 0.1}), there = edge_point<double>(1, 4, 0.8);
  CHECK(solver.solve(here).departure(there).direction == Vec3<double>(0, -1, 0));
  CHECK(solver.solve(there).direction(here) == Vec3<double>(0, 1, 0));
}

TEST_CASE("found meshes with coincident vertices and faces without area: alike both ways") {
  const std::vector<Mesh<double>> found{
      // A saddle between two faces without area, both of whose angles are pi.
      {{{1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, 0}, {1, 0, 0}},
       {{0, 1, 2}, {2, 0, 3}, {3, 2, 4}}},
      // A saddle reached over no length, from no direction.
      {{{-1, 0, 0}, {-1, 0, -1}, {-1, 0, 1}, {-1, 0, 0}, {1, -1, 0}, {1, 0, 0}, {0, -1, 1}},
       {{0, 1, 2}, {2, 1, 3}, {4, 5, 6}, {4, 6, 3}, {3, 6, 2}}},
      {{{1.5, 1, 0}, {3.5, 1, .5}, {2, 2, 0}, {2.5, 2.5, 0}, {4.5, 2, 0}, {3, 3, 0}, {2.5, 2.5, 0}},
       {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}, {2, 3, 5}, {3, 4, 5}, {2, 5, 6}}},
      // Seen through a vertex in the middle of an edge of three faces.
      {{{0, 0, 0},
        {1, -.5, 0},
        {1, 1.5, 0},
        {0, .5, 0},
        {2, .5, -.5},
        {2, .5, 0},
        {1.5, 2, 0},
        {0, 1.5, -.5},
        {2, 2, 0},
        {0, 3, 0},
        {.75, 1.25, 0}},
       {{0, 1, 2},
        {0, 2, 3},
        {1, 4, 2},
        {4, 5, 2},
        {3, 2, 6},
        {3, 6, 7},
        {2, 5, 8},
        {2, 8, 6},
        {7, 6, 9},
        {3, 6, 10}}},
      // A saddle behind the tip of needles, round which windows go.
      {{{1, 2, -42600},
        {2, 2, 18450},
        {2, 3, -47250},
        {1, 3, -21000},
        {3, 2, -42150},
        {3.5, 3, 47100},
        {1, 4, 33150},
        {1.5, 4.5, -40050},
        {3, 4, 7650}},
       {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {4, 5, 2}, {3, 2, 6}, {2, 7, 6}, {2, 5, 8}, {2, 8, 7}}},
      // Seen through a point of an edge behind two faces without area.
      {{{1.5, 0, -.5},
        {1.5, 1, 0},
        {1.5, .5, 0},
        {3, .5, -.5},
        {3.5, 1, .5},
        {-.5, 1, 0},
        {0, 2, .5},
        {1.5, 2, 0},
        {1.5, 2, 0},
        {3, 1.5, .5}},
       {{0, 1, 2},
        {0, 3, 1},
        {3, 4, 1},
        {5, 2, 6},
        {2, 7, 6},
        {2, 1, 8},
        {2, 8, 7},
        {1, 4, 9},
        {1, 9, 8}}},
      // An image that rounding puts beside its window on the same edge; a line that ends at the
      // place of a saddle.
      {{{0, 0, .5},
        {1.5, .5, 0},
        {0, 1, 0},
        {1, 1, 0},
        {2, 0, 0},
        {1.5, .5, 0},
        {3, 0, 0},
        {3, 1, 0}},
       {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}, {4, 5, 3}, {4, 6, 7}, {4, 7, 5}}},
      {{{0, 0, .5},
        {1.5, .5, 0},
        {0, 1, 0},
        {1, 1, 0},
        {2, 0, 0},
        {1.5, .5, 0},
        {3, 0, 0},
        {3, 1, 0},
        {2, 2.5, 0},
        {2.5, 2, 0}},
       {{0, 1, 2},
        {1, 3, 2},
        {1, 4, 3},
        {4, 5, 3},
        {4, 6, 7},
        {4, 7, 5},
        {3, 5, 8},
        {5, 7, 9},
        {5, 9, 8}}},
      // Traces that went round the tips of needles, or left them on the wrong side.
      {{{2, 1.5, 45150},
        {3, 2, 82050},
        {3, 3, -98250},
        {2, 3.5, 55350},
        {4, 2, 60900},
        {4, 3, 11550},
        {2, 4.5, -4950},
        {3, 4.5, 37650},
        {3, 3, -98250},
        {1, 2.5, -17400},
        {1.5, 2, 13875}},
       {{0, 1, 2},
        {0, 2, 3},
        {1, 4, 2},
        {4, 5, 2},
        {3, 2, 6},
        {2, 7, 6},
        {2, 5, 7},
        {2, 7, 8},
        {9, 0, 10}}},
      {{{0, 1, 27900},
        {1, 1, 3000},
        {1, 2, 55500},
        {0, 2, -4800},
        {2, 2, -111000},
        {1, 3, 26400},
        {2, 3, 39600},
        {1, 2, 55500}},
       {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {3, 2, 5}, {2, 4, 6}, {2, 6, 5}, {2, 4, 7}}},
      {{{-1, 1, 0},
        {0, 1, 0},
        {0, 0, -300},
        {0, 0, 0},
        {0, 0, -300},
        {1, 0, 0},
        {0, -1, 0},
        {-1, -1, 0},
        {-.5, -1, 0}},
       {{0, 1, 2},
        {0, 2, 3},
        {3, 2, 4},
        {2, 1, 5},
        {6, 7, 4},
        {6, 4, 5},
        {4, 7, 3},
        {5, 4, 2},
        {6, 7, 8}}}};
  for (const auto& mesh : found) {
    CAPTURE(&mesh - found.data());
    for (Index source = 0; source < count(mesh); ++source) {
      const Mismatch worst = mismatch(mesh, source);
      CHECK(worst.both_ways < 1e-11);
      CHECK(worst.path < 1e-11);
    }
  }
}

TEST_CASE("random meshes on lattices: distances alike both ways, paths as long") {
  for (std::uint64_t seed = 0; seed < 400; ++seed) check_lattice_mesh(seed);
}

// Run it with --no-skip; it takes about a minute.
TEST_CASE("random meshes on lattices, the long run" * doctest::skip()) {
  for (std::uint64_t seed = 1000; seed < 21000; ++seed) check_lattice_mesh(seed);
}

TEST_CASE("unused vertices and other components are not reached") {
  const std::array<Mesh<double>, 2> parts{gelight::icosphere<double>(1),
                                          gelight::grid<double>(3, 3)};
  Mesh<double> mesh = gelight::joined<double>(parts);
  mesh.positions.push_back({0, 0, 0});
  const auto field = ExactSolver(mesh).solve(Index{0});
  for (Index v = 42; v < count(mesh); ++v) {
    CHECK(field.distance(v) == infinity);
    CHECK(field.path(v).empty());
    CHECK(field.direction(v).isZero(0));
    CHECK(field.arrivals(v).empty());
  }
  const SurfacePoint<double> far = face_point<double>(80, {0.2, 0.3, 0.5});
  CHECK(field.distance(far) == infinity);
  CHECK(field.path(far).empty());
  CHECK(field.direction(far).isZero(0));
  CHECK_THROWS_AS((void)field.departure(far), InvalidInput);
  std::vector<double> rest = field.distances();
  rest.resize(42);
  CHECK(rest == ExactSolver(parts[0]).distance(0));
}

TEST_CASE("what no path leaves is refused with the place of the point") {
  const auto field = ExactSolver(gelight::grid<double>(1, 1))
                         .solve(Source<double>{gelight::edge_point<double>(1, 0, 0.25), 0});
  const auto refused = [&](const SurfacePoint<double>& point) {
    return gelight::test::refusal([&] { (void)field.departure(point); });
  };
  CHECK(refused(gelight::edge_point<double>(1, 0, 0.25)) ==
        "no direction leads from a source to the point on an edge at vertex 1");
  const auto from_vertex = ExactSolver(gelight::grid<double>(1, 1)).solve(Index{0});
  CHECK(gelight::test::refusal([&] { (void)from_vertex.departure(Index{0}); }) ==
        "no direction leads from a source to the point at vertex 0");
}

TEST_CASE("a fin: paths run up it, and past it") {
  // Three squares of two faces on one edge, all flat when unfolded in pairs.
  const double s = std::sqrt(0.5);
  Mesh<double> mesh{
      {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, 1, 0}, {s, 0, s}, {s, 1, s}},
      {{0, 2, 1}, {2, 3, 1}, {0, 1, 4}, {1, 5, 4}, {0, 1, 6}, {1, 7, 6}}};
  for (int flip = 0; flip < 2; ++flip) {
    const auto d = ExactSolver(mesh).distance(2);
    CHECK(d[4] == gelight::test::approx(2).epsilon(1e-15));
    CHECK(d[6] == gelight::test::approx(2).epsilon(1e-15));
    CHECK(d[5] == gelight::test::approx(std::sqrt(5.0)).epsilon(1e-15));
    CHECK(d[7] == gelight::test::approx(std::sqrt(5.0)).epsilon(1e-15));
    std::swap(mesh.faces[0][1], mesh.faces[0][2]);
    std::swap(mesh.faces[4][1], mesh.faces[4][2]);
  }
}

TEST_CASE("a bow-tie: paths pass through the vertex") {
  const Mesh<double> mesh{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}},
                          {{0, 1, 2}, {0, 3, 4}}};
  const auto field = ExactSolver(mesh).solve(Index{2});
  CHECK(field.distance(4) == gelight::test::approx(2 * std::sqrt(2.0)).epsilon(1e-15));
  CHECK(field.distance(3) == gelight::test::approx(1 + std::sqrt(2.0)).epsilon(1e-15));
  const auto path = field.path(3);
  REQUIRE(path.size() == 3);
  CHECK(path[1] == vertex_point<double>(0));
}

TEST_CASE("brute-force unfolding of random small meshes of ten kinds") {
  double worst = 0;
  for (int seed = 0; seed < 600; ++seed) worst = std::max(worst, oracle_error(seed));
  CHECK(worst < 1e-12);
}

// Run it with --no-skip; it takes about half a minute.
TEST_CASE("brute-force unfolding, the long run" * doctest::skip()) {
  double worst = 0;
  for (int seed = 1000; seed < 31000; ++seed) worst = std::max(worst, oracle_error(seed));
  CHECK(worst < 1e-12);
}

TEST_CASE("points inside faces and on edges: as if a vertex were there") {
  for (int seed = 0; seed < 150; ++seed) {
    RandomCase c(seed);
    const Index f = uniform_index(c.random, static_cast<Index>(c.mesh.faces.size()));
    const double a = uniform(c.random, 0.1, 0.6), b = uniform(c.random, 0.1, 0.3);
    const auto p = face_point<double>(f, {a, b, 1 - a - b});
    const ExactSolver solver(c.mesh);
    const Surface surface(c.mesh);
    const auto kept = solver.solve(c.span(), {.keep_windows = true});
    const auto searched = solver.solve(c.span());

    Mesh<double> split = c.mesh;
    const Vec3<double> position = surface.position(p);
    const auto [v0, v1, v2] = split.faces[at(f)];
    const Index v = count(split);
    split.positions.push_back({position[0], position[1], position[2]});
    split.faces[at(f)] = {v0, v1, v};
    split.faces.push_back({v1, v2, v});
    split.faces.push_back({v2, v0, v});
    std::vector<double> right(c.sources.size());
    double nearest = infinity;
    const auto from_there = ExactSolver(c.mesh).solve(p, {.keep_windows = true});
    for (const auto& source : c.sources) {
      nearest = std::min(nearest, source.distance + from_there.distance(source.point));
    }
    // By symmetry, and from the split mesh where no source lies in the face that is split.
    CHECK(kept.distance(p) == gelight::test::approx(nearest).epsilon(1e-12));
    CHECK(searched.distance(p) == gelight::test::approx(nearest).epsilon(1e-12));
    const bool elsewhere = std::all_of(c.sources.begin(), c.sources.end(), [&](const auto& s) {
      return s.point.kind != SurfacePoint<double>::Kind::face || s.point.element[0] != f;
    });
    if (elsewhere) {
      const auto d = ExactSolver(split).distance(c.span());
      CHECK(kept.distance(p) == gelight::test::approx(d[at(v)]).epsilon(1e-12));
    }
    for (const auto* field : {&kept, &searched}) {
      CHECK(path_error(surface, *field, c.sources, p) < 1e-12);
      const auto on_edge = edge_point<double>(v1, v0, uniform(c.random, 0, 1));
      CHECK(path_error(surface, *field, c.sources, on_edge) < 1e-12);
      CHECK(kept.distance(on_edge) ==
            gelight::test::approx(searched.distance(on_edge)).epsilon(1e-12));
    }
  }
}

TEST_CASE("invariants: bounds by edges, space and Dijkstra; triangle inequality; symmetry") {
  for (int seed = 0; seed < 60; ++seed) {
    const RandomCase c(seed);
    const ExactSolver solver(c.mesh);
    const Surface surface(c.mesh);
    std::vector<std::vector<double>> all;
    for (Index v = 0; v < count(c.mesh); ++v) all.push_back(solver.distance(v));
    double worst = 0;  // by how much an inequality fails, relative
    const auto less = [&](double a, double b) {
      if (b < infinity) worst = std::max(worst, (a - b) / std::max(b, 1e-3));
    };
    for (Index v = 0; v < count(c.mesh); ++v) {
      const auto& d = all[at(v)];
      CHECK(d[at(v)] == 0);
      const auto edges = gelight::DijkstraSolver<double>(c.mesh).distance(v);
      for (Index w = 0; w < count(c.mesh); ++w) {
        less((position(c.mesh, v) - position(c.mesh, w)).norm(), d[at(w)]);
        less(d[at(w)], edges[at(w)]);
        less(d[at(w)], all[at(w)][at(v)]);
        CHECK((d[at(w)] < infinity) == (edges[at(w)] < infinity));
      }
      for (Index h = 0; h < surface.halfedge_count(); ++h) {
        less(d[at(surface.tip(h))], d[at(surface.origin(h))] + surface.length(h));
      }
    }
    for (int i = 0; i < 300; ++i) {
      Random random(static_cast<std::uint64_t>(i));
      const auto a = at(uniform_index(random, count(c.mesh)));
      const auto b = at(uniform_index(random, count(c.mesh)));
      const auto w = at(uniform_index(random, count(c.mesh)));
      less(all[a][b], all[a][w] + all[w][b]);
    }
    CHECK(worst < 1e-12);
  }
}

TEST_CASE("unchanged by turning, renumbering and flipped faces; scales with the mesh") {
  for (int seed = 0; seed < 100; ++seed) {
    RandomCase c(seed);
    const auto d = ExactSolver(c.mesh).distance(Index{0});
    Mesh<double> other = c.mesh;
    for (auto& face : other.faces) {
      if (uniform(c.random, 0, 1) < 0.5) std::swap(face[0], face[2]);
    }
    CHECK(worst_difference(ExactSolver(other).distance(Index{0}), d) < 1e-12);

    std::vector<Index> number(c.mesh.positions.size());
    std::iota(number.begin(), number.end(), 0);
    std::shuffle(number.begin(), number.end(), c.random);
    for (std::size_t v = 0; v < number.size(); ++v) {
      other.positions[at(number[v])] = c.mesh.positions[v];
    }
    other.faces = c.mesh.faces;
    for (auto& face : other.faces)
      face = {number[at(face[1])], number[at(face[2])], number[at(face[0])]};
    std::shuffle(other.faces.begin(), other.faces.end(), c.random);
    const auto shuffled = ExactSolver(other).distance(number[0]);
    std::vector<double> back;
    for (const Index v : number) back.push_back(shuffled[at(v)]);
    CHECK(worst_difference(back, d) < 1e-12);

    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(uniform(c.random, 0, 6), Eigen::Vector3d(1, 2, 3).normalized())
            .toRotationMatrix();
    const auto turned = gelight::placed<double>(c.mesh, turn, Vec3<double>(3, -2, 1));
    CHECK(worst_difference(ExactSolver(turned).distance(Index{0}), d) < 1e-11);

    for (const double scale : {1e-20, 1e-6, 1e6, 1e20}) {
      Mesh<double> scaled = c.mesh;
      for (auto& p : scaled.positions) {
        for (double& x : p) x *= scale;
      }
      auto ds = ExactSolver(scaled).distance(Index{0});
      for (double& x : ds) x /= scale;
      CHECK(worst_difference(ds, d) < 1e-13);
    }
  }
}

TEST_CASE("several sources: the least of each; repeated ones change nothing; starts shift") {
  for (int seed = 0; seed < 100; ++seed) {
    RandomCase c(seed);
    const ExactSolver solver(c.mesh);
    const auto together = solver.distance(c.span());
    std::vector<double> least(together.size(), infinity);
    for (const auto& source : c.sources) {
      const auto alone = solver.distance(std::span(&source, 1));
      for (std::size_t v = 0; v < alone.size(); ++v) least[v] = std::min(least[v], alone[v]);
    }
    CHECK(worst_difference(together, least) < 1e-12);
    auto twice = c.sources;
    twice.insert(twice.end(), c.sources.begin(), c.sources.end());
    CHECK(solver.distance(std::span<const Source<double>>(twice)) == together);
    for (auto& source : twice) source.distance -= 7;
    auto shifted = solver.distance(std::span<const Source<double>>(twice));
    for (double& x : shifted) x += 7;
    CHECK(worst_difference(shifted, together) < 1e-12);
  }
}

TEST_CASE("a whole border as source: the distance from the nearest side") {
  const Index n = 12;
  Random random(6);
  const Mesh<double> mesh = gelight::test::jittered_grid(n, 0.2, random);
  std::vector<Source<double>> border;
  std::vector<Index> border_vertices;
  for (Index v = 0; v < count(mesh); ++v) {
    const auto p = position(mesh, v);
    if (p.x() == 0 || p.y() == 0 || p.x() == n || p.y() == n) border_vertices.push_back(v);
  }
  const auto d = ExactSolver(mesh).distance(std::span<const Index>(border_vertices));
  for (Index v = 0; v < count(mesh); ++v) {
    double right = infinity;
    for (const Index b : border_vertices) {
      right = std::min(right, (position(mesh, v) - position(mesh, b)).norm());
    }
    CHECK(d[at(v)] == gelight::test::approx(right).epsilon(1e-14));
  }
}

TEST_CASE("a source on an edge, inside a face, on the border, on the target's own edge") {
  const Mesh<double> mesh = gelight::grid<double>(4, 4, 4, 4);
  const Surface surface(mesh);
  const ExactSolver solver(mesh);
  const std::array<SurfacePoint<double>, 6> points{
      edge_point<double>(6, 12, 0.25),        edge_point<double>(0, 1, 0.5),
      edge_point<double>(12, 6, 0.75),        face_point<double>(5, {0.2, 0.3, 0.5}),
      face_point<double>(5, {0.0, 0.3, 0.7}), face_point<double>(5, {0.0, 0.0, 1.0})};
  for (const auto& a : points) {
    for (const bool keep : {false, true}) {
      const auto field = solver.solve(a, {.keep_windows = keep});
      for (const auto& b : points) {
        const Vec3<double> way = surface.position(b) - surface.position(a);
        CHECK(field.distance(b) == gelight::test::approx(way.norm()).epsilon(1e-14));
        if (way.norm() == 0) {
          CHECK(field.direction(b).isZero(0));
        } else {
          CHECK((field.direction(b) - way.normalized()).norm() < 1e-13);
        }
      }
      for (Index v = 0; v < count(mesh); ++v) {
        const double right = (position(mesh, v) - surface.position(a)).norm();
        CHECK(field.distance(v) == gelight::test::approx(right).epsilon(1e-14));
      }
    }
  }
}

TEST_CASE("a solver that was used before gives the same bits as a fresh one") {
  Random random(7);
  const Mesh<double> mesh = gelight::test::jittered_grid(20, 0.25, random);
  const ExactSolver used(mesh);
  (void)used.solve(Index{5}, {.keep_windows = true});
  (void)used.distance(Index{200});
  CHECK_THROWS_AS((void)used.solve(Index{3}, {.cancelled = [] { return true; }}),
                  gelight::Cancelled);
  const auto a = used.solve(Index{17}), b = ExactSolver(mesh).solve(Index{17});
  CHECK(a.distances() == b.distances());
  for (Index v = 0; v < count(mesh); ++v) {
    CHECK(a.path(v) == b.path(v));
    CHECK(a.direction(v) == b.direction(v));
  }
}

TEST_CASE("cancelling: asked all along, and over at the first yes") {
  const Mesh<double> mesh = gelight::icosphere<double>(5);
  const ExactSolver solver(mesh);
  const auto asked_until = [&](int yes) {
    int asked = 0;
    try {
      (void)solver.solve(Index{0}, {.cancelled = [&] { return ++asked == yes; }});
    } catch (const gelight::Cancelled&) {
      CHECK(asked == yes);
    }
    return asked;
  };
  const int all = asked_until(-1);
  CHECK(all >= count(mesh) / 300);  // every 256 vertices, some of which are taken up twice
  for (const int yes : {1, 2, all}) CHECK(asked_until(yes) == yes);
  CHECK(solver.distance(0) == ExactSolver(mesh).distance(0));
}

TEST_CASE("several threads at once give what one gives") {
  const Mesh<double> mesh = gelight::icosphere<double>(3);
  const ExactSolver solver(mesh);
  const auto field = solver.solve(Index{0});
  std::vector<std::vector<double>> alone, together(8);
  for (Index v = 0; v < 8; ++v) alone.push_back(solver.distance(50 * v));
  std::vector<std::size_t> sizes(8);
  {
    std::vector<std::thread> threads;
    for (Index v = 0; v < 8; ++v) {
      threads.emplace_back([&, v] {
        together[at(v)] = solver.distance(50 * v);
        sizes[at(v)] = field.path(face_point<double>(100 * v, {0.2, 0.2, 0.6})).size();
      });
    }
    for (auto& thread : threads) thread.join();
  }
  CHECK(alone == together);
  for (Index v = 0; v < 8; ++v) {
    CHECK(sizes[at(v)] == field.path(face_point<double>(100 * v, {0.2, 0.2, 0.6})).size());
  }
}

TEST_CASE("a greatest distance: all within it exact, all beyond infinite") {
  for (int seed = 0; seed < 100; ++seed) {
    const RandomCase c(seed);
    const ExactSolver solver(c.mesh);
    const auto all = solver.distance(c.span());
    auto sorted = all;
    std::sort(sorted.begin(), sorted.end());
    const double limit = sorted[sorted.size() / 2];
    if (!(limit < infinity)) continue;
    const auto some = solver.solve(c.span(), {.max_distance = limit}).distances();
    for (std::size_t v = 0; v < all.size(); ++v) {
      if (all[v] <= limit * (1 - 1e-12))
        CHECK(some[v] == gelight::test::approx(all[v]).epsilon(1e-13));
      if (all[v] > limit * (1 + 1e-12)) CHECK(some[v] == infinity);
    }
  }
}

TEST_CASE("targets: exact there, with less work") {
  for (int seed = 0; seed < 100; ++seed) {
    RandomCase c(seed);
    const ExactSolver solver(c.mesh);
    const auto all = solver.solve(c.span(), {.keep_windows = true});
    ExactOptions<double> options;
    for (int i = 0; i < 2; ++i) {
      options.targets.push_back(gelight::test::random_point(c.mesh, c.random));
    }
    const auto some = solver.solve(c.span(), options);
    for (const auto& target : options.targets) {
      CHECK(some.distance(target) == gelight::test::approx(all.distance(target)).epsilon(1e-13));
    }
    const auto d = all.distances(), e = some.distances();
    for (std::size_t v = 0; v < d.size(); ++v) {
      if (e[v] < infinity) CHECK(e[v] == gelight::test::approx(d[v]).epsilon(1e-12));
    }
  }
  const Mesh<double> sphere = gelight::icosphere<double>(3);
  const auto near = ExactSolver(sphere).solve(Index{0}, {.targets = {vertex_point<double>(12)}});
  const auto d = near.distances();
  CHECK(std::count(d.begin(), d.end(), infinity) > 100);
}

TEST_CASE("a reset radius: real paths, between Dijkstra and exact") {
  for (int seed = 0; seed < 150; ++seed) {
    const RandomCase c(seed);
    const ExactSolver exact(c.mesh);
    const auto shortest = exact.distance(c.span());
    const auto edges = gelight::DijkstraSolver<double>(c.mesh).distance(c.span());
    for (const double radius : {0.1, 0.7, 1.5, 4.0}) {
      const ExactSolver solver(c.mesh, {.reset_radius = radius});
      const auto field = solver.solve(c.span());
      const auto d = field.distances();
      for (Index v = 0; v < count(c.mesh); ++v) {
        if (d[at(v)] == shortest[at(v)]) continue;
        const double size = std::max(1.0, std::fabs(shortest[at(v)]));
        CHECK(d[at(v)] >= shortest[at(v)] - 1e-12 * size);
        CHECK(d[at(v)] <= edges[at(v)] + 1e-12 * size);
        CHECK(path_error(exact.surface(), field, c.sources, vertex_point<double>(v)) < 1e-12);
      }
      CHECK(d == solver.distance(c.span()));
    }
    const auto whole = ExactSolver(c.mesh, {.reset_radius = 1e9}).distance(c.span());
    CHECK(worst_difference(whole, shortest) < 1e-13);
  }
}

TEST_CASE("a reset radius: the error falls faster than it grows") {
  for (const auto& mesh : {gelight::icosphere<double>(4), gelight::membrane<double>(1, 3, 0.1)}) {
    const auto exact = ExactSolver(mesh).distance(0);
    double before = 0;
    for (const double radius : {1.0, 4.0, 16.0}) {
      const auto d = ExactSolver(mesh, {.reset_radius = radius}).distance(0);
      double error = 0;
      for (std::size_t v = 1; v < d.size(); ++v) error += d[v] / exact[v] - 1;
      error /= static_cast<double>(d.size() - 1);
      MESSAGE("radius " << radius << ": " << error);
      if (before > 0) CHECK(std::log(before / error) / std::log(4.0) > 1.1);
      before = error;
    }
    CHECK(before < 3e-4);
  }
}

TEST_CASE("bad input is refused") {
  const Mesh<double> mesh = gelight::grid<double>(2, 2);
  const ExactSolver solver(mesh);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const Source<double>& source) {
    CHECK_THROWS_AS((void)solver.solve(std::span(&source, 1)), InvalidInput);
    CHECK_THROWS_AS((void)solver.distance(std::span(&source, 1)), InvalidInput);
  };
  refused({vertex_point<double>(9)});
  refused({vertex_point<double>(-1)});
  refused({edge_point<double>(0, 8, 0.5)});
  refused({edge_point<double>(0, 1, 1.5)});
  refused({face_point<double>(8, {1, 0, 0})});
  refused({face_point<double>(0, {0.5, 0.1, 0.1})});
  refused({face_point<double>(0, {nan, 0.1, 0.1})});
  refused({vertex_point<double>(0), nan});
  refused({vertex_point<double>(0), infinity});
  CHECK_THROWS_AS((void)solver.solve(std::span<const Index>{}), InvalidInput);
  CHECK_THROWS_AS((void)solver.solve(Index{0}, {.max_distance = nan}), InvalidInput);
  CHECK_THROWS_AS((void)solver.solve(Index{0}, {.targets = {vertex_point<double>(9)}}),
                  InvalidInput);
  for (const double radius : {0.0, -1.0, nan}) {
    CHECK_THROWS_AS((void)solver.solve(Index{0}, {.reset_radius = radius}), InvalidInput);
  }
  const auto field = solver.solve(Index{0});
  CHECK_THROWS_AS((void)field.distance(9), InvalidInput);
  CHECK_THROWS_AS((void)field.path(face_point<double>(8, {1, 0, 0})), InvalidInput);
  CHECK_THROWS_AS((void)field.arrivals(3, -1), InvalidInput);
  CHECK_THROWS_AS((void)ExactSolver(Mesh<double>{}), InvalidInput);
}

TEST_CASE("the source: no distance, no direction, a path of one point") {
  const ExactSolver solver(gelight::icosphere<double>(1));
  const auto face = solver.surface().face(0);
  for (const auto& p : {vertex_point<double>(3), edge_point<double>(face[0], face[1], 0.3),
                        face_point<double>(7, {0.3, 0.3, 0.4})}) {
    const auto field = solver.solve(p);
    CHECK(field.distance(p) == 0);
    CHECK(field.direction(p).isZero(0));
    CHECK(field.path(p).size() == 1);
    CHECK(field.arrivals(p).size() == 1);
    CHECK_THROWS_AS((void)field.departure(p), InvalidInput);
  }
}

TEST_CASE("the cut locus: all ways tell themselves, opposite ones are not averaged") {
  // The far side of a prism with an even number of sides: left and right round tie.
  const Index sides = 16, rows = 6;
  Mesh<double> mesh;
  for (Index r = 0; r <= rows; ++r) {
    for (Index j = 0; j < sides; ++j) {
      const double u = 2 * std::numbers::pi * j / sides;
      mesh.positions.push_back({std::cos(u), std::sin(u), 0.4 * r});
      if (r == rows) continue;
      const Index a = r * sides + j, b = r * sides + (j + 1) % sides;
      mesh.faces.push_back({a, b, b + sides});
      mesh.faces.push_back({a, b + sides, a + sides});
    }
  }
  const ExactSolver solver(mesh);
  for (const bool keep : {true, false}) {
    const auto field = solver.solve(Index{3 * sides}, {.keep_windows = keep});
    for (Index r = 0; r <= rows; ++r) {
      const auto far = field.arrivals(r * sides + sides / 2);
      REQUIRE(far.size() == 2);
      CHECK(far[0].distance == gelight::test::approx(far[1].distance).epsilon(1e-13));
      const double around = sides * std::sin(std::numbers::pi / sides);
      CHECK(far[0].distance ==
            gelight::test::approx(std::hypot(around, 0.4 * (r - 3))).epsilon(1e-13));
      CHECK(far[0].from == vertex_point<double>(3 * sides));
      // They come round from both sides, and rise alike.
      CHECK(far[0].direction.x() == gelight::test::approx(far[1].direction.x()));
      CHECK(far[0].direction.y() == gelight::test::approx(-far[1].direction.y()));
      CHECK(far[0].direction.z() == gelight::test::approx(far[1].direction.z()).scale(1));
      CHECK(field.arrivals(r * sides + 3).size() == 1);
    }
  }
}

TEST_CASE(
    "behind a corner light comes from the corner, also within the face where the path bends") {
  // A floor with a wall between (5, 4) and (6, 4): what (1, 2) does not see is reached round them.
  Mesh<double> floor = gelight::grid<double>(10, 7, 10, 7);
  std::erase_if(floor.faces, [](const auto& f) { return f[0] % 11 == 5 && f[0] / 11 < 4; });
  const ExactSolver solver(floor);
  const Surface<double>& surface = solver.surface();
  for (const bool keep : {true, false}) {
    const auto field = solver.solve(Index{11 * 2 + 1}, {.keep_windows = keep});
    double worst = 0;
    for (Index f = 0; f < surface.face_count(); ++f) {
      for (const double b : {0.11, 0.35, 0.78}) {
        for (const double c : {0.05, 0.17}) {
          const auto point = face_point<double>(f, {1 - b - c, b, c});
          const Vec3<double> p = surface.position(point);
          const bool is_seen = p.x() < 5 || p.y() > 2 + (p.x() - 1) / 2;
          const Vec3<double> from =
              is_seen ? Vec3<double>(1, 2, 0) : Vec3<double>(p.y() > 4 ? 5 : 6, 4, 0);
          const Vec3<double> direction = (p - from).normalized();
          worst = std::max(worst, (field.direction(point) - direction).norm());
          worst = std::max(worst, (field.arrivals(point).front().direction - direction).norm());
        }
      }
    }
    CHECK(worst < 1e-12);
  }
}

TEST_CASE(
    "arrivals name the source, or the last vertex where the path can bend, none passed flat") {
  const Mesh<double> sheet = gelight::grid<double>(6, 6, 6, 6);
  const auto on_line = edge_point<double>(3, 4, 0.25);  // of the border
  for (const bool keep : {true, false}) {
    const auto field = ExactSolver(sheet).solve(Index{0}, {.keep_windows = keep});
    for (Index v = 1; v < count(sheet); ++v) {
      const auto arrivals = field.arrivals(v);
      REQUIRE(arrivals.size() == 1);
      CHECK(arrivals[0].from == vertex_point<double>(0));
      CHECK((arrivals[0].direction - position(sheet, v).normalized()).norm() < 1e-14);
    }
    CHECK(field.arrivals(on_line)[0].from == vertex_point<double>(0));
  }
  // Round a re-entrant corner, at (3, 3), and past it.
  Mesh<double> bend = sheet;
  std::erase_if(bend.faces, [](const auto& f) { return f[0] % 7 >= 3 && f[0] / 7 >= 3; });
  const Index source = 6 * 7 + 1;  // at (1, 6)
  const auto field = ExactSolver(bend).solve(source);
  CHECK(field.arrivals(Index{1 * 7 + 6})[0].from == vertex_point<double>(3 * 7 + 3));  // at (6, 1)
  CHECK(field.arrivals(Index{3 * 7 + 6})[0].from == vertex_point<double>(3 * 7 + 3));  // at (6, 3)
  CHECK(field.arrivals(Index{2 * 7 + 2})[0].from == vertex_point<double>(source));     // at (2, 2)
}

TEST_CASE("arrivals are straight: traced back they pass where they begin, on needles too") {
  Random random(33);
  for (int i = 0; i < 200; ++i) {
    const int kinds[] = {0, 1, 2, 8};
    Mesh<double> mesh = gelight::test::small_random_mesh(kinds[i % 4], random);
    const double stretch = std::pow(10, i % 5);
    for (auto& p : mesh.positions) p[0] *= stretch;
    const ExactSolver solver(mesh);
    const Surface<double>& surface = solver.surface();
    double size = 0;
    for (const auto& p : mesh.positions) size = std::max(size, 2 * std::abs(p[0]));
    const auto inside = [&] {
      const double a = gelight::test::uniform(random, 0.1, 0.6);
      return face_point<double>(gelight::test::uniform_index(random, surface.face_count()),
                                {a, 0.3, 0.7 - a});
    };
    const auto source = inside();
    for (const bool keep : {true, false}) {
      const auto field = solver.solve(source, {.keep_windows = keep});
      for (int j = 0; j < 5; ++j) {
        const auto point = inside();
        for (const auto& arrival : field.arrivals(point, 0.03)) {
          const auto line = gelight::trace_geodesic(
              surface, point, Vec3<double>(-arrival.direction), arrival.distance);
          double gap = size;  // from where the line begins to that which was traced
          for (std::size_t k = 1; k < line.size(); ++k) {
            const Vec3<double> a = surface.difference(arrival.from, line[k - 1]);
            const Vec3<double> way = surface.difference(line[k - 1], line[k]);
            const double t =
                std::clamp(-a.dot(way) / std::max(way.squaredNorm(), 1e-300), 0.0, 1.0);
            gap = std::min(gap, (a + t * way).norm());
          }
          CAPTURE(i);
          CAPTURE(keep);
          CHECK(gap < 1e-6 * size);
        }
      }
    }
  }
}

TEST_CASE("a source that another reaches before it starts begins no lines") {
  const Mesh<double> sheet = gelight::grid<double>(6, 6, 6, 6);
  const ExactSolver solver(sheet);
  for (const double late : {0.5, 1.5, 100.0}) {
    const std::vector<Source<double>> sources{{vertex_point<double>(0), 0},
                                              {vertex_point<double>(1), late}};
    for (const bool keep : {true, false}) {
      const auto field =
          solver.solve(std::span<const Source<double>>(sources), {.keep_windows = keep});
      for (const Index v : {2, 3, 6}) {  // on the line from the one through the other
        const auto arrivals = field.arrivals(v);
        REQUIRE(arrivals.size() == 1);
        CHECK(arrivals[0].from == vertex_point<double>(late < 1 ? 1 : 0));
      }
    }
  }
}

TEST_CASE("two lines whose ways part at a bend behind the source are both found") {
  // A flat sheet with a hole, symmetric in y = 4, and behind its corner (0, 4) two vertices more.
  constexpr Index n = 8;
  const auto at = [](Index x, Index y) { return (n + 1) * y + x; };
  Mesh<double> mesh;
  for (Index y = 0; y <= n; ++y) {
    for (Index x = 0; x <= n; ++x) mesh.positions.push_back({1.0 * x, 1.0 * y, 0.0});
  }
  for (Index y = 0; y < n; ++y) {
    for (Index x = 0; x < n; ++x) {
      if ((x > 1 && x < 4 && y > 1 && y < 6) || (x < 1 && y != 3 && y != 4)) continue;
      mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  const auto behind = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back({-1, 3, 0});
  mesh.positions.push_back({-1, 5, 0});
  mesh.faces.push_back({at(0, 4), behind, behind + 1});
  const ExactSolver solver(mesh);
  const auto point = edge_point(at(7, 4), at(8, 4), 0.5);
  for (const bool keeps : {false, true}) {
    const auto field = solver.solve(behind, {.keep_windows = keeps});
    const auto arrivals = field.arrivals(point, 1e-12);
    REQUIRE(arrivals.size() == 2);
    // From the corners of the hole at (4, 2) and (4, 6), past which go lines from those at x = 2.
    const double length = std::sqrt(2.0) + std::hypot(2, 2) + 2 + std::hypot(3.5, 2);
    for (const auto& arrival : arrivals) {
      CHECK(arrival.distance == gelight::test::approx(length).epsilon(1e-14));
      CHECK(std::abs(arrival.direction[0]) == gelight::test::approx(3.5 / std::hypot(3.5, 2)));
    }
    CHECK(arrivals[0].direction[1] == gelight::test::approx(-arrivals[1].direction[1]));
    CHECK(arrivals[0].from.element[0] + arrivals[1].from.element[0] == at(4, 2) + at(4, 6));
  }
}

TEST_CASE("departures: on a flat sheet the angle is that of the straight line") {
  const Mesh<double> mesh = gelight::grid<double>(6, 6, 6, 6);
  const Surface surface(mesh);
  const ExactSolver solver(mesh);
  for (const auto& source : {vertex_point<double>(24), edge_point<double>(24, 25, 0.3),
                             face_point<double>(30, {0.2, 0.3, 0.5}), vertex_point<double>(0)}) {
    const auto field = solver.solve(source, {.keep_windows = true});
    for (Index v = 0; v < count(mesh); ++v) {
      const Vec3<double> way = position(mesh, v) - surface.position(source);
      if (way.norm() == 0) continue;
      const auto departure = field.departure(v);
      CHECK((departure.direction - way.normalized()).norm() < 1e-13);
      const Index h = departure.halfedge;
      const Vec3<double> x = position(mesh, surface.tip(h)) - position(mesh, surface.origin(h));
      const double angle = std::atan2(x.cross(way).z(), x.dot(way));
      CHECK(std::fabs(std::remainder(departure.angle - angle, 2 * std::numbers::pi)) < 1e-13);
    }
  }
}

TEST_CASE("an edge seen from 1e45 times its length away lets no line through on the wrong side") {
  const Mesh<double> mesh{{{0, -1e37, 0}, {0, 0, 0}, {0, 0, 1e25}, {1e-8, 1e-8, 0}, {0, -6e-3, 0}},
                          {{1, 4, 2}, {4, 3, 1}, {4, 3, 2}, {1, 3, 0}}};
  const auto distance = gelight::ExactSolver(mesh).distance(0);
  for (std::size_t v = 1; v < distance.size(); ++v) {
    CHECK(distance[v] == gelight::test::approx(1e37).epsilon(2e-12));  // 1e25 is on the way
  }
}

TEST_CASE("in float: as exact as the output can tell, far from the origin too") {
  const Mesh<double> sphere = gelight::icosphere<double>(3);
  Mesh<float> mesh;
  mesh.faces = sphere.faces;
  for (const auto& p : sphere.positions) {
    mesh.positions.push_back({float(p[0]), float(p[1]), float(p[2])});
  }
  Mesh<double> same;  // as double numbers
  same.faces = mesh.faces;
  for (const auto& p : mesh.positions) same.positions.push_back({p[0], p[1], p[2]});
  const std::vector<float> a = ExactSolver(mesh).distance(0);
  const std::vector<double> b = ExactSolver(same).distance(0);
  for (std::size_t v = 0; v < a.size(); ++v) CHECK(a[v] == static_cast<float>(b[v]));
  const auto field = ExactSolver(mesh).solve(face_point<float>(3, {0.1f, 0.2f, 0.7f}));
  CHECK(field.path(face_point<float>(500, {0.3f, 0.3f, 0.4f})).size() > 2);

  for (const float far : {1e3f, 1e6f}) {
    const Mesh<float> square{
        {{far, far, 0}, {far + 1, far, 0}, {far, far + 1, 0}, {far + 1, far + 1, 0}},
        {{0, 1, 2}, {1, 3, 2}}};
    CHECK(ExactSolver(square).distance(0)[3] == static_cast<float>(std::sqrt(2.0)));
  }
}

TEST_CASE("many faces of no area on few edges: ways round them come to an end") {
  Random random(41);
  for (int round = 0; round < 300; ++round) {
    const Index count = 8 + uniform_index(random, 6);
    const bool is_slanted = round % 2 == 1;  // whose lengths are rounded
    std::vector<double> places(static_cast<std::size_t>(count));
    std::iota(places.begin(), places.end(), 0);
    if (is_slanted)
      std::generate(places.begin(), places.end(), [&] { return uniform(random, 0, 4); });
    Mesh<double> mesh;
    for (const double x : places) mesh.positions.push_back({x, is_slanted ? x / 3 : 0, 0});
    std::set<std::array<Index, 3>> faces;
    while (faces.size() < 26) {
      std::array<Index, 3> face{uniform_index(random, count), uniform_index(random, count),
                                uniform_index(random, count)};
      std::sort(face.begin(), face.end());
      if (face[0] != face[1] && face[1] != face[2]) faces.insert(face);
    }
    mesh.faces.assign(faces.begin(), faces.end());
    std::shuffle(mesh.faces.begin(), mesh.faces.end(), random);
    const Index source = uniform_index(random, count);
    const auto exact = ExactSolver(mesh).distance(source);
    const auto along = distances_on_line(mesh.faces, places, source);
    const double stretch = is_slanted ? std::sqrt(1 + 1.0 / 9) : 1;
    CAPTURE(round);
    for (std::size_t v = 0; v < places.size(); ++v) {
      if (along[v] == infinity) {
        CHECK(exact[v] == infinity);
      } else {
        CHECK(std::abs(exact[v] - stretch * along[v]) <= 1e-11);
      }
    }
  }
}

TEST_CASE("a face of no area far off does not make fine edges any less exact") {
  auto mesh = gelight::grid<double>(10, 10, 1e-7);
  const Index n = count(mesh);
  mesh.positions.insert(mesh.positions.end(), {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  mesh.faces.push_back({n, n + 1, n + 2});
  const auto distance = ExactSolver(mesh).distance(0);
  for (Index v = 1; v < n; ++v) {
    const double straight = (position(mesh, v) - position(mesh, 0)).norm();
    CHECK(std::abs(distance[at(v)] - straight) <= 2e-13 * straight);
  }
}

TEST_CASE("through faces without area a way is as long as back") {
  // Of 4 and 6, which lie at one place, each is on the long side of such a face, and at 6 the
  // border turns a way from 2 into another direction.
  Mesh<double> mesh;
  mesh.positions = {{.5, .75, 0},  {0, .5, 0},  {0, .5, 0},    {-.25, .75, 0},
                    {.25, .75, 0}, {0, .75, 0}, {.25, .75, 0}, {.5, .25, 0},
                    {1, .5, 0},    {0, 0, 0},   {1, .75, 0},   {.5, .5, 0}};
  mesh.faces = {{1, 4, 3}, {0, 5, 4},  {3, 4, 5},  {0, 6, 5},   {0, 4, 8}, {1, 7, 4},
                {4, 7, 8}, {2, 6, 11}, {0, 10, 6}, {6, 10, 11}, {1, 9, 7}};
  const double straight = std::hypot(.25, .25) + std::hypot(.25, .75);
  CHECK(ExactSolver(mesh).distance(2)[9] == gelight::test::approx(straight).epsilon(1e-14));
  CHECK(ExactSolver(mesh).distance(9)[2] == gelight::test::approx(straight).epsilon(1e-14));

  Random random(77);
  for (int round = 0; round < 1500; ++round) {
    const Index n = 2 + uniform_index(random, 4);
    auto snapped = gelight::grid<double>(n, n, 1, 1);
    const double step = round % 2 == 0 ? 0.25 : 0.5, height = round % 3 == 0 ? 0 : 0.7;
    for (auto& p : snapped.positions) {
      p = {p[0] + uniform(random, -.18, .18), p[1] + uniform(random, -.18, .18),
           uniform(random, 0, height)};
      for (double& x : p) x = std::round(x / step) * step;
    }
    std::erase_if(snapped.faces, [&](const auto&) { return uniform(random, 0, 1) < 0.12; });
    if (snapped.faces.empty()) continue;
    const ExactSolver solver(snapped);
    std::vector<std::vector<double>> distances;
    for (Index v = 0; v < count(snapped); ++v) distances.push_back(solver.distance(v));
    CAPTURE(round);
    for (std::size_t a = 0; a < distances.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        if (distances[a][b] == distances[b][a]) continue;  // also where both are infinite
        CHECK(std::abs(distances[a][b] - distances[b][a]) < 1e-12);
      }
    }
  }
}

TEST_CASE("a path over faces without area is as long with kept windows") {
  // The way leads over the edge 4-1 from one such face to the next; 2, 3 and 4 lie at one place.
  const Mesh<double> mesh{{{0, 0, 0}, {.5, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}},
                          {{0, 1, 2}, {2, 1, 3}, {4, 3, 1}, {4, 1, 2}}};
  ExactOptions<double> options;
  for (const bool keeps : {false, true}) {
    options.keep_windows = keeps;
    const ExactSolver solver(mesh, options);
    const auto field = solver.solve(face_point<double>(2, {.5, .25, .25}));
    const auto to = face_point<double>(3, {.25, .5, .25});
    CHECK(field.distance(to) == gelight::test::approx(.125).epsilon(1e-14));
    CHECK(length(solver.surface(), field.path(to)) == gelight::test::approx(.125).epsilon(1e-14));
  }
}
