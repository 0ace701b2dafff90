#include "gelight/geodesic/voronoi.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <vector>

#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/hard_meshes.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Random;

namespace {

std::vector<test::NamedMesh> meshes() {
  std::vector<test::NamedMesh> all = test::scan_meshes(2);
  Random random(4);
  all.push_back({"sheet", test::jittered_grid(15, 0.25, random)});
  all.push_back({"grid with ties", grid<double>(9, 9, 9, 9)});
  all.push_back({"box", box<double>(1, 2, 3)});
  Mesh<double> book = grid<double>(6, 6, 6, 6);
  const auto sheet = static_cast<Index>(book.positions.size());
  for (Index v = 0; v < sheet; ++v) {  // a third page on the middle line, upright
    const auto [x, y, z] = book.positions[static_cast<std::size_t>(v)];
    if (x == 3) book.positions.push_back({x, y, 1});
  }
  std::vector<Index> line;
  for (Index v = 0; v < sheet; ++v) {
    if (book.positions[static_cast<std::size_t>(v)][0] == 3) line.push_back(v);
  }
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const auto up = static_cast<Index>(sheet + static_cast<Index>(i));
    book.faces.push_back({line[i], line[i + 1], up});
    book.faces.push_back({line[i + 1], up + 1, up});
  }
  all.push_back({"three pages", book});
  const std::vector<Mesh<double>> parts{icosphere<double>(2), torus(1.0, 0.4, 20, 12)};
  all.push_back({"two parts", joined<double>(parts)});
  return all;
}

}  // namespace

TEST_CASE("sources added one by one are as good as all at once") {
  Random random(5);
  for (const test::NamedMesh& named : meshes()) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const ExactSolver solver(mesh);
    const auto& components = solver.surface().components();
    GrowingDistances<double> growing(solver);
    std::vector<Source<double>> sources;
    std::vector<double> before(mesh.positions.size(), std::numeric_limits<double>::infinity());
    for (int i = 0; i < 12; ++i) {
      const Index f = test::uniform_index(random, static_cast<Index>(mesh.faces.size()));
      const double a = test::uniform(random, 0.1, 0.5);
      // Later than the others or earlier than all of them; those of another part at another time.
      double start = i % 4 == 3 ? test::uniform(random, -0.4, 0.2) : 0;
      if (components[mesh.faces[std::size_t(f)][0]] != 0) start += i < 6 ? 1e9 : -1e9;
      sources.push_back({i % 2 == 0 ? vertex_point<double>(mesh.faces[std::size_t(f)][0])
                                    : face_point<double>(f, {a, 0.3, 0.7 - a}),
                         start});
      const std::vector<Index> nearer = growing.add(sources.back());
      const auto all = solver.distance(std::span<const Source<double>>(sources));
      const auto alone = solver.distance(std::span<const Source<double>>(&sources.back(), 1));
      const std::set<Index> is_nearer(nearer.begin(), nearer.end());
      for (std::size_t v = 0; v < all.size(); ++v) {
        const auto vertex = static_cast<Index>(v);
        const double room = 1e-12 + 2.3e-16 * std::abs(all[v]);
        if (std::isinf(all[v])) {
          CHECK(growing.distance(vertex) == all[v]);
          continue;
        }
        CHECK(std::abs(growing.distance(vertex) - all[v]) <= room);
        if (alone[v] < before[v] - room) CHECK(is_nearer.count(vertex) == 1);
        if (alone[v] > before[v] + room) CHECK(is_nearer.count(vertex) == 0);
        before[v] = std::min(before[v], alone[v]);
      }
    }
  }
}

TEST_CASE("each farthest point is the farthest there is") {
  for (const test::NamedMesh& named : meshes()) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const ExactSolver solver(mesh);
    const Index count = std::min<Index>(20, static_cast<Index>(mesh.positions.size()));
    const std::vector<Index> points = farthest_points(solver, count, 3);
    REQUIRE(std::ssize(points) == count);
    CHECK(points[0] == 3);
    CHECK(std::set<Index>(points.begin(), points.end()).size() == points.size());
    for (std::size_t i = 1; i < points.size(); ++i) {
      const auto distance = solver.distance(std::span<const Index>(points.data(), i));
      const double farthest = *std::max_element(distance.begin(), distance.end());
      const double d = distance[static_cast<std::size_t>(points[i])];
      CHECK((d == farthest || d >= farthest * (1 - 1e-12)));
    }
  }
}

TEST_CASE("a vertex' site is as near as any") {
  Random random(8);
  for (const test::NamedMesh& named : meshes()) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const ExactSolver solver(mesh);
    const FastMarchingSolver marching(mesh);
    std::vector<Index> sites;
    for (int i = 0; i < 9; ++i) {
      sites.push_back(test::uniform_index(random, static_cast<Index>(mesh.positions.size())));
    }
    const auto check = [&](const auto& by, const std::vector<Index>& nearest) {
      std::vector<double> least(mesh.positions.size(), std::numeric_limits<double>::infinity());
      std::vector<double> own(mesh.positions.size(), std::numeric_limits<double>::infinity());
      for (const Index site : sites) {
        const auto distance = by.distance(site);
        for (std::size_t v = 0; v < least.size(); ++v) {
          least[v] = std::min(least[v], distance[v]);
          if (nearest[v] == site) own[v] = distance[v];
        }
      }
      for (std::size_t v = 0; v < least.size(); ++v) {
        CHECK((nearest[v] == -1) == std::isinf(least[v]));
        if (nearest[v] >= 0) CHECK(own[v] <= least[v] * (1 + 1e-12));
      }
    };
    check(solver, voronoi(solver, sites));
    check(marching, voronoi(marching, sites));
  }
}

TEST_CASE("beyond the solver's greatest distance no source and no site is near") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Random random(9);
  for (const test::NamedMesh& named : meshes()) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const ExactSolver whole(mesh);
    const auto far = whole.distance(Index{0});
    double farthest = 0;
    for (const double d : far) farthest = std::isinf(d) ? farthest : std::max(farthest, d);
    const double most = 0.3 * farthest, room = 1e-9 * farthest;
    const ExactSolver solver(mesh, ExactOptions<double>{.max_distance = most});
    const auto is_as_within = [&](double d, double truth) {
      if (std::abs(truth - most) <= room) return true;
      return truth < most ? std::abs(d - truth) <= room : d == infinity;
    };
    GrowingDistances<double> growing(solver);
    std::vector<double> least(mesh.positions.size(), infinity), nearest = least;
    std::vector<Index> sites;
    for (int i = 0; i < 6; ++i) {
      sites.push_back(test::uniform_index(random, static_cast<Index>(mesh.positions.size())));
      const double start = i % 2 == 0 ? 0 : test::uniform(random, -0.2, 0.4) * farthest;
      const std::vector<Index> nearer = growing.add({vertex_point<double>(sites.back()), start});
      const auto alone = whole.distance(sites.back());
      for (std::size_t v = 0; v < least.size(); ++v) {
        least[v] = std::min(least[v], start + alone[v]);
        nearest[v] = std::min(nearest[v], alone[v]);
        CHECK(is_as_within(growing.distance(static_cast<Index>(v)), least[v]));
      }
      for (const Index v : nearer) CHECK(growing.distance(v) < infinity);
    }
    const std::vector<Index> cells = voronoi(solver, sites);
    for (std::size_t v = 0; v < cells.size(); ++v) {
      if (std::abs(nearest[v] - most) > room) CHECK((cells[v] == -1) == (nearest[v] > most));
    }
  }
}

TEST_CASE("the solver's limit of memory and its hook hold where sources are added") {
  const auto mesh = icosphere<double>(4);
  ExactOptions<double> options;
  options.max_memory = 1000;
  CHECK_THROWS_AS((void)voronoi(ExactSolver(mesh, options), {0, 1}), MemoryLimit);
  CHECK_THROWS_AS((void)farthest_points(ExactSolver(mesh, options), 3), MemoryLimit);
  bool is_over = false;
  int asked = 0;
  ExactOptions<double> hooked;
  hooked.cancelled = [&] { return is_over; };
  const ExactSolver solver(mesh, hooked);
  const auto both = [&] { return ++asked < 0; };
  CHECK(voronoi(solver, {0, 1}, both) == voronoi(ExactSolver(mesh), {0, 1}));
  CHECK(asked > 1);
  is_over = true;
  CHECK_THROWS_AS((void)voronoi(solver, {0, 1}, both), Cancelled);
}

TEST_CASE("bad input and cancelling") {
  const auto mesh = icosphere<float>(1);
  const ExactSolver solver(mesh);
  CHECK_THROWS_AS((void)farthest_points(solver, 0), InvalidInput);
  CHECK_THROWS_AS((void)farthest_points(solver, 43), InvalidInput);
  CHECK_THROWS_AS((void)farthest_points(solver, 3, 42), InvalidInput);
  CHECK(farthest_points(solver, 42).size() == 42);
  CHECK_THROWS_AS((void)voronoi(solver, std::vector<Index>{}), InvalidInput);
  CHECK_THROWS_AS((void)voronoi(solver, std::vector<Index>{1, -1}), InvalidInput);
  CHECK_THROWS_AS((void)farthest_points(solver, 9, 0, [] { return true; }), Cancelled);
  // A vertex in no face is far from everything and no point.
  Mesh<float> more = mesh;
  more.positions.push_back({5, 5, 5});
  for (const Index p : farthest_points(ExactSolver(more), 42)) CHECK(p != 42);
}
