#include "gelight/geodesic/dijkstra.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"

using namespace gelight;

static_assert(gelight::DistanceSolver<DijkstraSolver<float>, float>);
static_assert(gelight::DistanceSolver<DijkstraSolver<double>, double>);

namespace {

// Distance along edges by Bellman-Ford: relax all edges until nothing changes.
std::vector<double> bellman_ford(const Mesh<double>& mesh, Index source) {
  const Surface surface(mesh);
  std::vector<double> d(mesh.positions.size(), unreachable<double>);
  d[static_cast<std::size_t>(source)] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      const auto a = static_cast<std::size_t>(surface.origin(h));
      const auto b = static_cast<std::size_t>(surface.tip(h));
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
        if (d[from] + surface.length(h) >= d[to]) continue;
        d[to] = d[from] + surface.length(h);
        changed = true;
      }
    }
  }
  return d;
}

// Distance along the graph of vertices and Steiner points, built in space from its definition: all
// pairs of points of a face are joined. By Bellman-Ford.
std::vector<double> steiner_bellman_ford(const Mesh<double>& mesh, Index source, int per_edge) {
  std::vector<Vec3<double>> points;
  for (const auto& p : mesh.positions) points.emplace_back(p[0], p[1], p[2]);
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> on_edge;
  std::vector<std::vector<std::size_t>> groups;
  for (const auto& face : mesh.faces) {
    groups.emplace_back(face.begin(), face.end());
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(face[k], face[(k + 1) % 3]);
      auto& numbers = on_edge[{a, b}];
      for (int i = 1; i <= per_edge && static_cast<int>(numbers.size()) < per_edge; ++i) {
        const double t = i / (per_edge + 1.0);
        numbers.push_back(points.size());
        points.push_back((1 - t) * points[static_cast<std::size_t>(a)] +
                         t * points[static_cast<std::size_t>(b)]);
      }
      groups.back().insert(groups.back().end(), numbers.begin(), numbers.end());
    }
  }
  std::vector<double> d(points.size(), unreachable<double>);
  d[static_cast<std::size_t>(source)] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& group : groups) {
      for (const auto a : group) {
        for (const auto b : group) {
          const double reach = d[a] + (points[a] - points[b]).norm();
          if (!(reach < d[b] * (1 - 1e-14))) continue;
          d[b] = reach;
          changed = true;
        }
      }
    }
  }
  d.resize(mesh.positions.size());
  return d;
}

double mean_excess(const std::vector<double>& d, const std::vector<double>& exact) {
  double sum = 0;
  for (std::size_t v = 0; v < d.size(); ++v) {
    if (exact[v] > 0) sum += (d[v] / exact[v] - 1) / static_cast<double>(d.size() - 1);
  }
  return sum;
}

Mesh<double> two_squares_and_a_stray() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {9, 9, 9}},
          {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}}};
}

}  // namespace

TEST_CASE("equals Bellman-Ford on every vertex") {
  for (const auto& mesh : {icosphere<double>(3), grid<double>(13, 7, 3.0, 1.0), box(1.0, 2.0, 3.0),
                           torus(2.0, 0.7, 40, 17)}) {
    const DijkstraSolver solver(mesh);
    CHECK(solver.distance(5) == bellman_ford(mesh, 5));
  }
}

TEST_CASE("parts without a source and stray vertices are infinitely far") {
  const DijkstraSolver solver(two_squares_and_a_stray());
  const double inf = unreachable<double>;
  CHECK(solver.distance(1) == std::vector<double>{1, 0, 1, 2, inf, inf, inf, inf});
  CHECK(solver.distance(7) == std::vector<double>{inf, inf, inf, inf, inf, inf, inf, 0});
}

TEST_CASE("sources on edges and in faces reach their faces' vertices by straight lines") {
  const DijkstraSolver solver(two_squares_and_a_stray());
  const auto from = [&](SurfacePoint<double> p) {
    const std::vector<Source<double>> sources{{p, 0}};
    return solver.distance(sources);
  };
  const auto middle = from(edge_point<double>(2, 0, 0.5));
  for (std::size_t v = 0; v < 4; ++v) CHECK(middle[v] == gelight::test::approx(std::sqrt(0.5)));
  const auto face = from(face_point<double>(0, {0.25, 0.5, 0.25}));  // at (0.75, 0.25)
  CHECK(face[0] == gelight::test::approx(std::hypot(0.75, 0.25)));
  CHECK(face[2] == gelight::test::approx(std::hypot(0.25, 0.75)));
  CHECK(face[3] == gelight::test::approx(1 + std::hypot(0.25, 0.75)));
  CHECK(from(edge_point<double>(0, 1, 1.0)) == solver.distance(1));
  CHECK(from(face_point<double>(1, {0, 1, 0})) == solver.distance(2));
}

TEST_CASE("Steiner points: edges of next to no length elsewhere do not keep a query from its end") {
  Mesh<double> mesh = icosphere<double>(3);
  const auto count = mesh.positions.size();
  DijkstraOptions options;
  options.steiner_points = 2;
  const auto alone = DijkstraSolver(mesh, options).distance(Index{0});
  for (std::size_t i = 0; i < count; ++i) {
    const auto a = static_cast<Index>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {1e-30, 0, 0}, {0, 1e-30, 0}});
    mesh.faces.push_back({a, a + 1, a + 2});
  }
  const auto beside = DijkstraSolver(mesh, options).distance(Index{0});
  CHECK(std::equal(alone.begin(), alone.end(), beside.begin()));
}

TEST_CASE("several sources: the smallest of the single answers, start distances added") {
  const auto mesh = icosphere<double>(3);
  const DijkstraSolver solver(mesh);
  const auto a = solver.distance(3), b = solver.distance(100);
  const std::vector<Source<double>> sources{{vertex_point<double>(3), 0.5},
                                            {vertex_point<double>(100), -0.25},
                                            {vertex_point<double>(100), 7}};
  const auto both = solver.distance(sources);
  for (std::size_t v = 0; v < both.size(); ++v) {
    CHECK(both[v] == gelight::test::approx(std::min(a[v] + 0.5, b[v] - 0.25)));
  }
  const std::vector<Index> twice{3, 3};
  CHECK(solver.distance(twice) == a);
}

TEST_CASE("scales with the mesh; flipped, finned and flattened faces change nothing") {
  auto mesh = icosphere<double>(3);
  const auto expected = DijkstraSolver(mesh).distance(0);
  for (const double scale : {1e-20, 1e-6, 1e6}) {
    auto scaled = mesh;
    for (auto& p : scaled.positions) p = {scale * p[0], scale * p[1], scale * p[2]};
    const auto d = DijkstraSolver(scaled).distance(0);
    for (std::size_t v = 0; v < d.size(); ++v) {
      CHECK(std::abs(d[v] - scale * expected[v]) <= 1e-13 * scale * expected[v]);
    }
  }
  for (std::size_t f = 0; f < mesh.faces.size(); f += 2)
    std::swap(mesh.faces[f][0], mesh.faces[f][1]);
  CHECK(DijkstraSolver(mesh).distance(0) == expected);

  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 5, 2}}};
  const auto d = DijkstraSolver(fin).distance(4);
  CHECK(d[2] == 2);
  CHECK(d[1] == d[5]);
}

TEST_CASE("mean error on icospheres stays at 8 %: edges alone do not converge") {
  for (const int level : {3, 5}) {
    const auto mesh = icosphere<double>(level);
    const auto d = DijkstraSolver(mesh).distance(0);
    double mean = 0;
    for (std::size_t v = 1; v < d.size(); ++v) {
      double dot = 0;
      for (std::size_t k = 0; k < 3; ++k) dot += mesh.positions[0][k] * mesh.positions[v][k];
      const double truth = std::acos(std::clamp(dot, -1.0, 1.0));
      CHECK(d[v] >= truth * (1 - 2e-2));  // chords are a little shorter than arcs
      mean += std::abs(d[v] / truth - 1) / static_cast<double>(d.size() - 1);
    }
    CHECK(mean > 0.06);
    CHECK(mean < 0.09);
  }
}

TEST_CASE("Steiner points: equals Bellman-Ford on the graph built from its definition") {
  for (int kind = 0; kind < 40; ++kind) {
    test::Random random(static_cast<std::uint64_t>(kind));
    const auto mesh = test::small_random_mesh(kind, random);
    for (const int per_edge : {1, 2, 5}) {
      const auto d = DijkstraSolver(mesh, {.steiner_points = per_edge}).distance(mesh.faces[0][0]);
      const auto expected = steiner_bellman_ford(mesh, mesh.faces[0][0], per_edge);
      for (std::size_t v = 0; v < d.size(); ++v) {
        CHECK((d[v] == expected[v] || std::abs(d[v] - expected[v]) <= 1e-12 * expected[v]));
      }
    }
  }
}

TEST_CASE(
    "Steiner points: never shorter than exact; finer graphs that hold coarser ones are no worse") {
  for (int kind = 0; kind < 60; ++kind) {
    test::Random random(static_cast<std::uint64_t>(kind));
    const auto mesh = test::small_random_mesh(kind, random);
    const std::vector<Source<double>> sources{{test::random_point(mesh, random), 0},
                                              {test::random_point(mesh, random), -0.2}};
    const std::span<const Source<double>> span(sources);
    const auto exact = ExactSolver(mesh).distance(span);
    auto coarser = DijkstraSolver(mesh).distance(span);
    for (const Index per_edge : {1, 3, 7}) {
      const auto d = DijkstraSolver(mesh, {.steiner_points = per_edge}).distance(span);
      for (std::size_t v = 0; v < d.size(); ++v) {
        if (d[v] == exact[v]) continue;
        const double size = 1 + std::abs(exact[v]);
        CHECK(d[v] >= exact[v] - 1e-12 * size);
        CHECK(d[v] <= coarser[v] + 1e-12 * size);
      }
      coarser = d;
    }
  }
}

TEST_CASE("Steiner points: the error falls with their number, with order 1.3 at least") {
  for (const auto& mesh : {icosphere<double>(3), membrane<double>(1, 3, 0.2)}) {
    const auto exact = ExactSolver(mesh).distance(0);
    double before = mean_excess(DijkstraSolver(mesh).distance(0), exact);
    for (const Index per_edge : {1, 3, 7}) {
      const auto d = DijkstraSolver(mesh, {.steiner_points = per_edge}).distance(0);
      const double error = mean_excess(d, exact);
      MESSAGE(per_edge << " on an edge: mean " << error);
      CHECK(std::log2(before / error) > 1.3);
      before = error;
    }
    CHECK(before < 3e-3);
  }
}

TEST_CASE("bad queries are refused before anything is written") {
  const DijkstraSolver solver(two_squares_and_a_stray());
  CHECK_THROWS_AS(DijkstraSolver(icosphere<double>(0), {.steiner_points = -1}), InvalidInput);
  CHECK_THROWS_AS(DijkstraSolver(icosphere<double>(3), {.steiner_points = 1 << 24}), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance(8), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance(-1), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance(std::vector<Index>{}), InvalidInput);
  std::vector<double> small(3, 7);
  CHECK_THROWS_AS(solver.distance_into(small, 0), InvalidInput);
  CHECK(small == std::vector<double>{7, 7, 7});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Source<double>> sources{{vertex_point<double>(0), nan}};
  CHECK_THROWS_AS((void)solver.distance(sources), InvalidInput);
}

TEST_CASE("a hook cancels and follows queries, also by Steiner points") {
  const auto mesh = icosphere<double>(5);
  for (const Index points : {0, 2}) {
    bool ends = false;
    double last = 0;
    int asked = 0;
    const auto hook = [&](double done) {
      CHECK(done >= last);
      last = done;
      ++asked;
      return ends;
    };
    const DijkstraSolver solver(mesh, {.steiner_points = points, .cancelled = hook});
    const auto d = solver.distance(5);
    CHECK(asked > 0);
    CHECK(last <= 1);
    ends = true, last = 0;
    std::vector<double> out(d.size(), -1);
    CHECK_THROWS_AS(solver.distance_into(out, 5), Cancelled);
    CHECK(out == std::vector<double>(d.size(), -1));
    ends = false, last = 0;
    CHECK(solver.distance(5) == d);
  }
}
