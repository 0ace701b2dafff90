#include "gelight/geodesic/distance_rows.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <span>
#include <stdexcept>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/hard_meshes.hpp"

using gelight::distance_matrix;
using gelight::distance_rows;
using gelight::Index;

namespace {

std::vector<Index> all_vertices(const auto& solver) {
  std::vector<Index> vertices(static_cast<std::size_t>(solver.surface().vertex_count()));
  std::iota(vertices.begin(), vertices.end(), 0);
  return vertices;
}

// Bit for bit, on any number of threads.
void check_rows(const auto& solver) {
  const auto sources = all_vertices(solver);
  const std::span<const Index> some = std::span<const Index>(sources).subspan(3, 40);
  for (const unsigned threads : {1U, 2U, 5U}) {
    const auto matrix = distance_matrix(solver, some, {.threads = threads});
    std::vector<int> seen(some.size(), 0);
    distance_rows(solver, some,
                  [&](Index row, const auto& distances) {
                    const auto i = static_cast<std::size_t>(row);
                    ++seen[i];
                    const auto alone = solver.distance(some[i]);
                    REQUIRE(distances.size() == alone.size());
                    for (std::size_t v = 0; v < alone.size(); ++v) {
                      CHECK(distances[v] == alone[v]);
                      CHECK(matrix[i * alone.size() + v] == alone[v]);
                    }
                  },
                  {.threads = threads});
    CHECK(seen == std::vector<int>(some.size(), 1));
  }
}

}  // namespace

TEST_CASE("each row is what the solver gives for its source alone") {
  gelight::test::Random random(3);
  const auto mesh = gelight::test::jittered_grid(9, 0.25, random);
  check_rows(gelight::ExactSolver(mesh));
  check_rows(gelight::FastMarchingSolver(mesh));
  check_rows(gelight::DijkstraSolver<float>(mesh));
  check_rows(gelight::HeatSolver(mesh));
}

TEST_CASE_TEMPLATE("sources that the heat method solves together have the bits they have alone", T,
                   double, float) {
  gelight::test::Random random(6);
  const std::vector<gelight::Mesh<double>> parts{gelight::test::jittered_grid(12, 0.25, random),
                                                 gelight::icosphere<double>(2),
                                                 gelight::grid<double>(1500, 2, 1500.0, 2.0)};
  const auto mesh = gelight::joined<double>(std::span(parts));
  for (const auto boundary : {gelight::HeatBoundary::neumann, gelight::HeatBoundary::averaged}) {
    const gelight::HeatSolver<T> solver(mesh, {.boundary = boundary, .refinements = 1});
    for (const std::size_t count : {0U, 1U, 3U, 4U, 5U, 8U, 9U, 17U}) {
      std::vector<gelight::Source<T>> sources;
      for (std::size_t i = 0; i < count; ++i) {
        const auto point = gelight::test::random_point(mesh, random).template cast<T>();
        sources.push_back({point, static_cast<T>(i % 3)});
      }
      for (const unsigned threads : {1U, 2U}) {
        const auto matrix = distance_matrix(solver, std::span<const gelight::Source<T>>(sources),
                                            {.threads = threads});
        REQUIRE(matrix.size() == count * mesh.positions.size());
        for (std::size_t i = 0; i < count; ++i) {
          const auto alone = solver.distance(std::span<const gelight::Source<T>>(&sources[i], 1));
          CHECK(std::memcmp(alone.data(), matrix.data() + i * alone.size(),
                            alone.size() * sizeof(T)) == 0);
        }
      }
    }
  }
}

TEST_CASE("sources that are solved together end one by one, where taking throws or is cancelled") {
  const gelight::HeatSolver solver(gelight::icosphere<double>(2));
  const auto sources = all_vertices(solver);
  const std::span<const Index> some = std::span<const Index>(sources).first(21);
  for (const unsigned threads : {1U, 2U, 7U}) {
    for (int last = 1; last <= 21; ++last) {
      int rows = 0;
      const auto fail = [&](Index, const auto&) {
        if (++rows >= last) throw rows;
      };
      CHECK_THROWS_AS(distance_rows(solver, some, fail, {.threads = threads}), int);
      CHECK(rows == last);
    }
  }
  for (int last = 0; last <= 21; ++last) {
    int asked = 0, rows = 0;
    const auto cancel = [&] { return asked++ == last; };
    const auto count = [&](Index, const auto&) { ++rows; };
    const auto solve = [&] { distance_rows(solver, some, count, {.cancelled = cancel}); };
    if (last < 21) {
      CHECK_THROWS_AS(solve(), gelight::Cancelled);
      CHECK(rows <= last);
    } else {
      solve();
      CHECK(asked == 21);
      CHECK(rows == 21);
    }
  }
  check_rows(solver);
}

TEST_CASE("a flat sheet's matrix is that of straight lines, a sphere's is symmetric") {
  gelight::test::Random random(4);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    auto sheet = gelight::test::jittered_grid(6, 0.25, random);
    for (auto& p : sheet.positions) {
      for (double& x : p) x *= scale;
    }
    const gelight::ExactSolver solver(sheet);
    const auto sources = all_vertices(solver);
    const auto matrix = distance_matrix(solver, std::span<const Index>(sources), {.threads = 2});
    const std::size_t n = sources.size();
    REQUIRE(matrix.size() == n * n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t v = 0; v < n; ++v) {
        const auto &a = sheet.positions[i], &b = sheet.positions[v];
        const double straight = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        CHECK(std::abs(matrix[i * n + v] - straight) <= 1e-13 * 9 * scale);
      }
    }
  }
  const gelight::ExactSolver solver(gelight::icosphere<double>(2));
  const auto sources = all_vertices(solver);
  const auto matrix = distance_matrix(solver, std::span<const Index>(sources), {.threads = 2});
  for (std::size_t i = 0; i < sources.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      CHECK(std::abs(matrix[i * sources.size() + j] - matrix[j * sources.size() + i]) <= 1e-13);
    }
  }
}

TEST_CASE("sources anywhere on the surface, each with its start") {
  gelight::test::Random random(5);
  const auto mesh = gelight::test::jittered_grid(6, 0.25, random);
  const gelight::ExactSolver solver(mesh);
  std::vector<gelight::Source<double>> sources;
  for (int i = 0; i < 20; ++i) {
    sources.push_back({gelight::test::random_point(mesh, random), i - 10.0});
  }
  const std::span<const gelight::Source<double>> list(sources);
  const auto matrix = distance_matrix(solver, list, {.threads = 2});
  const std::size_t n = mesh.positions.size();
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const gelight::Vec3<double> from = solver.surface().position(sources[i].point);
    for (std::size_t v = 0; v < n; ++v) {
      const auto& p = mesh.positions[v];
      const double straight = std::hypot(p[0] - from[0], p[1] - from[1], p[2] - from[2]);
      CHECK(std::abs(matrix[i * n + v] - (sources[i].distance + straight)) <= 1e-12);
    }
  }
}

TEST_CASE(
    "rows are taken one at a time; what is thrown passes through, and leaves the solver good") {
  const gelight::FastMarchingSolver solver(gelight::icosphere<double>(3));
  const auto sources = all_vertices(solver);
  const std::span<const Index> all(sources);
  std::atomic<int> inside = 0;
  int rows = 0;
  bool overlap = false;
  distance_rows(solver, all,
                [&](Index, const auto&) {
                  overlap |= ++inside > 1;
                  ++rows;
                  --inside;
                },
                {.threads = 4});
  CHECK_FALSE(overlap);
  CHECK(rows == 642);

  rows = 0;
  const auto fail = [&](Index, const auto&) {
    if (++rows == 5) throw std::runtime_error("full");
  };
  CHECK_THROWS_WITH(distance_rows(solver, all, fail, {.threads = 3}), "full");
  CHECK(rows < 642);

  double before = 0;
  bool rises = true;
  const auto cancel = [&](double done) {
    rises &= done >= before && done <= 1;
    before = done;
    return done > 0.1;
  };
  rows = 0;
  const auto count = [&](Index, const auto&) { ++rows; };
  CHECK_THROWS_AS(distance_rows(solver, all, count, {.threads = 2, .cancelled = cancel}),
                  gelight::Cancelled);
  CHECK(rises);
  CHECK(rows < 642);
  check_rows(solver);
}

TEST_CASE(
    "after a row has thrown, or the work was cancelled, no row is taken; the first is thrown") {
  const gelight::FastMarchingSolver solver(gelight::icosphere<double>(3));
  const auto sources = all_vertices(solver);
  const std::span<const Index> some = std::span<const Index>(sources).first(40);
  for (const unsigned threads : {1U, 2U, 7U, 64U}) {
    for (int last = 1; last <= 40; last += 3) {
      CAPTURE(threads);
      CAPTURE(last);
      int rows = 0, thrown = 0;
      const auto fail = [&](Index, const auto&) {
        if (++rows >= last) throw rows;
      };
      try {
        distance_rows(solver, some, fail, {.threads = threads});
      } catch (const int row) {
        thrown = row;
      }
      CHECK(rows == last);
      CHECK(thrown == last);
    }
  }
}

TEST_CASE("a source that is not of the mesh is refused before any row; no sources are no rows") {
  const gelight::DijkstraSolver solver(gelight::icosphere<double>(1));
  int rows = 0;
  const auto count = [&](Index, const auto&) { ++rows; };
  for (const Index bad : {-1, 42}) {
    const std::vector<Index> sources{0, 1, bad, 2};
    CHECK_THROWS_AS(distance_rows(solver, std::span<const Index>(sources), count),
                    gelight::InvalidInput);
    CHECK_THROWS_AS((void)distance_matrix(solver, std::span<const Index>(sources)),
                    gelight::InvalidInput);
  }
  CHECK(rows == 0);
  CHECK(distance_matrix(solver, std::span<const Index>{}).empty());
  distance_rows(solver, std::span<const Index>{}, count);
  CHECK(rows == 0);
}
