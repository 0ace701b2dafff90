#include "gelight/geodesic/distance_solver.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_rows.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/geodesic/voronoi.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/scan_meshes.hpp"

// What all distance solvers hold where start distances or the mesh are so large or so small that
// numbers do not hold every sum.

using namespace gelight;
using gelight::test::Random;

namespace {

// Two meshes that do not touch, of edges about 1 and of needles.
struct TwoParts {
  Mesh<double> first, second, both;
};

TwoParts two_parts(Random& random) {
  TwoParts parts;
  parts.first = icosphere<double>(2);
  for (auto& p : parts.first.positions) p[0] *= test::uniform(random, 2.0, 4.0);
  parts.second = test::scans::stretched(test::jittered_grid(9, 0.2, random), 5);
  parts.both = joined<double>(std::vector<Mesh<double>>{parts.first, parts.second});
  return parts;
}

// Calls visit(name, a function that makes a solver of a mesh).
void for_each_solver(const auto& visit) {
  visit("Dijkstra", [](const auto& mesh) { return DijkstraSolver(mesh); });
  visit("Steiner points",
        [](const auto& mesh) { return DijkstraSolver(mesh, {.steiner_points = 2}); });
  visit("fast marching", [](const auto& mesh) { return FastMarchingSolver(mesh); });
  visit("virtual source", [](const auto& mesh) { return VirtualSourceSolver(mesh); });
  visit("exact", [](const auto& mesh) { return ExactSolver(mesh); });
}

std::vector<double> distances(const auto& solver, const std::vector<Source<double>>& sources) {
  return solver.distance(std::span<const Source<double>>(sources));
}

// By how much distances differ from others that start later, as a share of their size.
double off(std::span<const double> found, std::span<const double> expected, double start) {
  double largest = 0;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    const double sum = start + expected[v];
    largest = std::max(largest, std::abs(found[v] - sum) / std::max(expected[v], std::abs(sum)));
    if (std::isnan(found[v])) return unreachable<double>;
  }
  return largest;
}

// Powers of ten, of either sign, to beyond what sums of two can hold.
const std::vector<double> starts{1e3,   -1e3,  1e8,    -1e8,  1e11,   -1e11,   1e16,
                                 -1e16, 1e100, -1e100, 1e300, -1e300, 1.7e308, -1.7e308};

}  // namespace

TEST_CASE("sources of parts that do not touch are on their own, however far apart they start") {
  Random random(3);
  const TwoParts parts = two_parts(random);
  const std::size_t split = parts.first.positions.size();
  for_each_solver([&](const char* name, const auto& make) {
    CAPTURE(std::string(name));
    const auto solver = make(parts.both);
    for (const double start : starts) {
      CAPTURE(start);
      const Index a = test::uniform_index(random, static_cast<Index>(split));
      const Index other = static_cast<Index>(split) + test::uniform_index(random, 100);
      const std::vector<Source<double>> near{{vertex_point<double>(a), -0.5},
                                             {face_point<double>(17, {0.2, 0.3, 0.5}), 0.25}};
      auto sources = near;
      sources.push_back({vertex_point<double>(other), start});
      // One that is overtaken before it starts changes nothing.
      sources.push_back({vertex_point<double>(3), std::max(1e16, std::abs(start))});
      const auto d = distances(solver, sources);
      const std::span<const double> all(d);
      const auto a_alone = distances(solver, near), b_alone = solver.distance(other);
      CHECK(off(all.first(split), std::span<const double>(a_alone).first(split), 0) < 1e-13);
      CHECK(off(all.subspan(split), std::span<const double>(b_alone).subspan(split), start) <
            1e-13);
    }
  });
}

TEST_CASE("so are their certificates") {
  Random random(4);
  const TwoParts parts = two_parts(random);
  const std::size_t split = parts.first.positions.size();
  const Certifier certifier(parts.both), alone(parts.first);
  const ExactSolver exact(parts.both);
  for (const double start : starts) {
    CAPTURE(start);
    const std::vector<Source<double>> sources{
        {vertex_point<double>(7), 0.25},
        {vertex_point<double>(static_cast<Index>(split)), start},
        {vertex_point<double>(9), std::max(1e16, std::abs(start))}};
    const auto d = distances(exact, sources);
    const auto bounds = certifier.bounds(std::span<const Source<double>>(sources), d);
    const auto expected =
        alone.bounds(std::span(sources).first(1), std::span<const double>(d).first(split));
    for (std::size_t v = 0; v < d.size(); ++v) {
      CHECK(bounds.lower[v] <= d[v]);
      CHECK(d[v] <= bounds.upper[v]);
      CHECK(std::isfinite(bounds.upper[v]));
      if (v >= split) continue;
      // Given distances that are nothing but rounding, as beyond, loosen the other part's too.
      if (std::abs(start) < 1e12) CHECK(bounds.lower[v] >= 0.5 * expected.lower[v]);
      CHECK(bounds.upper[v] <= expected.upper[v] * (1 + 1e-12));
    }
  }
}

TEST_CASE("exact fields of such sources: points, paths, arrivals, and limits of distance") {
  Random random(5);
  const TwoParts parts = two_parts(random);
  const Surface surface(parts.both);
  const auto split = static_cast<Index>(parts.first.positions.size());
  const ExactSolver solver(parts.both), first(parts.first), second(parts.second);
  const auto near = first.solve(7);
  const auto far = second.solve(0);
  const auto points = static_cast<Index>(parts.first.faces.size());
  for (const double start : starts) {
    CAPTURE(start);
    const std::vector<Source<double>> sources{{vertex_point<double>(7), 0},
                                              {vertex_point<double>(split), start}};
    const std::span<const Source<double>> both(sources);
    const auto field = solver.solve(both), kept = solver.solve(both, {.keep_windows = true});
    for (Index f = 0; f < surface.face_count(); f += 37) {
      const auto here = face_point<double>(f, {0.2, 0.3, 0.5});
      const auto there = face_point<double>(f - points, {0.2, 0.3, 0.5});
      const double expected = f < points ? near.distance(here) : start + far.distance(there);
      CHECK(field.distance(here) == gelight::test::approx(expected).epsilon(1e-13));
      CHECK(kept.distance(here) == gelight::test::approx(expected).epsilon(1e-13));
      CHECK(field.arrivals(here).front().distance ==
            gelight::test::approx(expected).epsilon(1e-13));
      const double path = f < points ? near.distance(here) : far.distance(there);
      CHECK(length(surface, field.path(here)) == gelight::test::approx(path).epsilon(1e-13));
    }
    // Beyond what limits say nothing is known; the limits themselves are, and all before.
    const Index target = 100;
    const std::vector<double> d = near.distances();
    const double most = near.distance(target);
    for (const auto& limited : {solver.solve(both, {.max_distance = most}),
                                solver.solve(both, {.targets = {vertex_point<double>(target)}})}) {
      for (Index v = 0; v < split; ++v) {
        CHECK(limited.distance(v) ==
              (d[static_cast<std::size_t>(v)] <= most ? field.distance(v) : unreachable<double>));
      }
      for (Index v = split; v < surface.vertex_count(); ++v) {
        const bool is_within = start + far.distance(v - split) <= most;
        CHECK(limited.distance(v) == (is_within ? field.distance(v) : unreachable<double>));
      }
    }
    const auto beyond = solver.solve(both, {.targets = {vertex_point<double>(split + 99)}});
    CHECK(beyond.distance(split + 99) == field.distance(split + 99));
  }
}

// Of the distances that a solver gives in double those that float holds, else a refusal.
TEST_CASE("a distance that float cannot hold is refused by name, and nothing written") {
  for (const double scale : {1e-60, 1e-39, 1e-30, 1e30, 3e36, 3e38, 1e60}) {
    CAPTURE(scale);
    auto mesh = icosphere<double>(2);
    for (auto& p : mesh.positions) p = {scale * p[0], 1.5 * scale * p[1], scale * p[2]};
    const auto check = [&](const auto& wide, const auto& narrow) {
      const auto expected = wide.distance(7);
      const bool fits = std::all_of(expected.begin(), expected.end(), [](double d) {
        return d == 0 || (d <= double{std::numeric_limits<float>::max()} &&
                          d >= double{std::numeric_limits<float>::min()});
      });
      std::vector<float> out(expected.size(), -1);
      if (fits) {
        narrow.distance_into(out, 7);
        CHECK(out == std::vector<float>(expected.begin(), expected.end()));
        return;
      }
      CHECK_THROWS_WITH_AS((void)narrow.distance(7), doctest::Contains("vertex "), InvalidInput);
      CHECK_THROWS_AS(narrow.distance_into(out, 7), InvalidInput);
      CHECK(out == std::vector<float>(expected.size(), -1));
    };
    check(DijkstraSolver(mesh), DijkstraSolver<float>(mesh));
    check(FastMarchingSolver(mesh), FastMarchingSolver<float>(mesh));
    check(VirtualSourceSolver(mesh), VirtualSourceSolver<float>(mesh));
    check(ExactSolver(mesh), ExactSolver<float>(mesh));

    // The farthest vertex, and a point of a face beside it.
    const auto d = ExactSolver(mesh).distance(7);
    const auto far = static_cast<Index>(std::max_element(d.begin(), d.end()) - d.begin());
    const Surface surface(mesh);
    const auto point =
        face_point<float>(surface.face_of(surface.corners(far).front()), {0.25F, 0.25F, 0.5F});
    const bool is_held = scale > 1e-38 && scale < 1e38;
    const auto field = ExactSolver<float>(mesh).solve(7);
    const Certifier<float> certifier(mesh);
    const std::vector<float> none(mesh.positions.size(), 0);
    if (is_held) {
      CHECK(std::isfinite(field.distance(far)));
    } else {
      CHECK_THROWS_AS((void)field.distance(far), InvalidInput);
      CHECK_THROWS_AS((void)field.distance(point), InvalidInput);
      CHECK_THROWS_AS((void)field.distances(), InvalidInput);
      CHECK_THROWS_AS((void)field.arrivals(far), InvalidInput);
      CHECK(field.path(far).size() > 2);  // shares are of the same size at any scale
    }
    // Bounds stay bounds where they are rounded to 0, but not to +infinity.
    if (scale < 1e38) {
      const auto bounds = certifier.bounds(7, none);
      const auto exact = ExactSolver(mesh).distance(7);
      for (std::size_t v = 0; v < exact.size(); ++v) {
        CHECK(double{bounds.lower[v]} <= exact[v]);
        CHECK(double{bounds.upper[v]} >= exact[v]);
      }
    } else {
      CHECK_THROWS_AS((void)certifier.bounds(7, none), InvalidInput);
    }
  }
}

TEST_CASE("a start distance and a way that float holds, but not their sum") {
  const auto mesh = grid<float>(4, 4, 3e37F, 3e37F);
  const ExactSolver solver(mesh);
  const std::vector<Source<float>> sources{{vertex_point<float>(0), 3.2e38F}};
  std::vector<float> out(25, -1);
  CHECK_THROWS_AS(solver.distance_into(out, std::span<const Source<float>>(sources)), InvalidInput);
  CHECK(out == std::vector<float>(25, -1));
}

namespace {

// A method of a caller's own, as CONTRIBUTING tells to write one: straight through space, to what
// is nearer than some distance. It replaces what it reaches, and nothing else.
class NearSolver : public detail::DistanceQueries<NearSolver, double> {
 public:
  NearSolver(const Mesh<double>& mesh, double reach) : surface_(mesh), reach_(reach) {}
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

 private:
  friend class detail::DistanceQueries<NearSolver, double>;

  void solve_vertices(detail::DistanceQuery<double>& query) const {
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      for (const auto& [point, start] : query.sources) {
        const double way = start + (surface_.position(v) - surface_.position(point)).norm();
        if (way < reach_) query.distance[v] = std::min(query.distance[v], way);
      }
    }
  }

  Surface<double> surface_;
  double reach_;
};

}  // namespace

TEST_CASE("a solver of a caller's own replaces distances that are infinite before, each time") {
  const auto mesh = grid<double>(8, 8, 8.0, 8.0);
  const NearSolver solver(mesh, 3.5);
  for (const Index source : {Index{0}, Index{80}, Index{40}}) {
    const auto distance = solver.distance(source);
    REQUIRE(distance.size() == 81);
    for (Index v = 0; v < 81; ++v) {
      // Of a grid whose vertices stand in rows of nine.
      const double way = std::hypot(v % 9 - source % 9, v / 9 - source / 9);
      const double d = distance[static_cast<std::size_t>(v)];
      if (way < 3.5) {
        CHECK(d == gelight::test::approx(way));
      } else {
        CHECK(d == std::numeric_limits<double>::infinity());
      }
    }
  }
}

TEST_CASE("what converts to a vertex names one, whatever integer it is made of") {
  const ExactSolver solver(icosphere<double>(1));
  const std::integral_constant<std::size_t, 7> seven;
  CHECK(solver.distance(seven) == solver.distance(7));
  CHECK(solver.solve(seven).distances() == solver.distance(7));
}

TEST_CASE("several vertices are named in braces") {
  const auto mesh = icosphere<double>(2);
  const ExactSolver solver(mesh);
  const std::vector<Index> vertices{3, 60};
  const std::vector<double> expected = solver.distance(std::span<const Index>(vertices));
  CHECK(solver.distance({3, 60}) == expected);
  CHECK(solver.distance({60}) == solver.distance(60));
  std::vector<double> out(mesh.positions.size());
  solver.distance_into(out, {3, 60});
  CHECK(out == expected);
  CHECK_THROWS_AS((void)solver.distance({3, 162}), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance(std::initializer_list<Index>{}), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance({}), InvalidInput);
}

TEST_CASE_TEMPLATE("several points are named in braces", T, float, double) {
  const auto mesh = icosphere<T>(2);
  const auto held = [&](const auto& solver) {
    const Source<T> a{vertex_point<T>(3), T(0.25)}, b{vertex_point<T>(60), 0};
    const std::vector<Source<T>> both{a, b};
    const std::vector<T> expected = solver.distance(both);
    CHECK(solver.distance({a, b}) == expected);
    CHECK(solver.distance({{vertex_point<T>(3), T(0.25)}, {vertex_point<T>(60)}}) == expected);
    CHECK(solver.distance({a}) == solver.distance(a));
    CHECK(solver.distance({vertex_point<T>(3), T(0.25)}) == solver.distance(a));
    std::vector<T> out(expected.size());
    solver.distance_into(out, {a, b});
    CHECK(out == expected);
    CHECK(solver.distance({3, 60}) == solver.distance(std::vector<Index>{3, 60}));
  };
  held(DijkstraSolver(mesh));
  held(FastMarchingSolver(mesh));
  held(VirtualSourceSolver(mesh));
  held(ExactSolver(mesh));
  held(HeatSolver(mesh));
  held(SmoothDistanceSolver(mesh));
  held(DistancePlanner(mesh));
}

TEST_CASE_TEMPLATE("solve, rows and the certificate take points in braces", T, float, double) {
  const auto mesh = icosphere<T>(2);
  const Source<T> a{vertex_point<T>(3), T(0.25)}, b{vertex_point<T>(60), 0};
  const std::vector<Source<T>> both{a, b};
  const auto held = [&](const auto& solver, const auto& distances_of) {
    const std::vector<T> expected = solver.distance(both);
    CHECK(distances_of(solver.solve({a, b})) == expected);
    CHECK(distances_of(solver.solve({{vertex_point<T>(3), T(0.25)}, {vertex_point<T>(60)}})) ==
          expected);
    CHECK(distances_of(solver.solve({a})) == solver.distance(a));
    CHECK(distances_of(solver.solve({3, 60})) == solver.distance({3, 60}));
    CHECK_THROWS_AS((void)solver.solve({}), InvalidInput);
    CHECK(distance_matrix(solver, {a, b}) == distance_matrix(solver, both));
    CHECK(distance_matrix(solver, {}).empty());
    std::vector<std::vector<T>> rows(2);
    distance_rows(solver, {a, b}, [&](Index row, std::span<const T> d) {
      rows[static_cast<std::size_t>(row)].assign(d.begin(), d.end());
    });
    CHECK(rows == std::vector{solver.distance(a), solver.distance(b)});
  };
  const ExactSolver exact(mesh);
  held(exact, [](const auto& field) { return field.distances(); });
  held(HeatSolver(mesh), [](const auto& result) { return result.distance; });
  held(DistancePlanner(mesh), [](const auto& result) { return result.distance; });
  held(SmoothDistanceSolver(mesh), [](const auto& result) { return result.distance; });
  CHECK(exact.solve({a, b}, {.keep_windows = true}).distances() == exact.distance(both));

  const Certifier certifier(mesh);
  const std::vector<T> distances = exact.distance(both);
  CHECK(certifier.bounds({a, b}, distances).upper == certifier.bounds(both, distances).upper);
  const std::vector<Index> vertices{3, 60};
  CHECK(certifier.bounds({3, 60}, distances).lower == certifier.bounds(vertices, distances).lower);
  CHECK_THROWS_AS((void)certifier.bounds({}, distances), InvalidInput);
}

TEST_CASE_TEMPLATE("solve, rows and Voronoi take vertices in braces, and one source", T, float,
                   double) {
  const auto mesh = icosphere<T>(3);
  const Source<T> source{edge_point<T>(mesh.faces[9][0], mesh.faces[9][1], T(0.25)), T(0.5)};
  const std::vector<Source<T>> sources{source};
  const std::vector<Index> vertices{0, 5};
  const std::span<const Source<T>> one(sources);
  const auto holds = [&](const auto& solver, const auto& distances_of) {
    CHECK(distances_of(solver.solve({0, 5})) == solver.distance(vertices));
    CHECK(distances_of(solver.solve(source)) == solver.distance(one));
    CHECK(solver.distance(source) == solver.distance(one));
    std::vector<T> out(mesh.positions.size());
    solver.distance_into(out, source);
    CHECK(out == solver.distance(one));
    CHECK(distance_matrix(solver, {0, 5}) == distance_matrix(solver, vertices));
    std::vector<T> row;
    distance_rows(solver, {5},
                  [&](Index, std::span<const T> d) { row.assign(d.begin(), d.end()); });
    CHECK(row == solver.distance(5));
  };
  const ExactSolver exact(mesh);
  holds(exact, [](const auto& field) { return field.distances(); });
  holds(HeatSolver(mesh), [](const auto& result) { return result.distance; });
  holds(DistancePlanner(mesh), [](const auto& result) { return result.distance; });
  holds(SmoothDistanceSolver(mesh), [](const auto& result) { return result.distance; });
  CHECK(exact.solve({0, 5}, {.keep_windows = true}).distances() == exact.distance(vertices));
  CHECK(voronoi(exact, {0, 5}) == voronoi(exact, vertices));
}

TEST_CASE_TEMPLATE("points without a start distance are sources that start at 0", T, float,
                   double) {
  const auto mesh = icosphere<T>(2);
  const auto a = edge_point<T>(mesh.faces[9][0], mesh.faces[9][1], T(0.25));
  const auto b = face_point<T>(40, {T(0.5), T(0.25), T(0.25)});
  const std::vector<SurfacePoint<T>> points{a, b}, none, wrong{a, vertex_point<T>(162)};
  const std::vector<Source<T>> sources{{a}, {b}};
  const auto held = [&](const auto& solver) {
    const std::vector<T> expected = solver.distance(sources);
    CHECK(solver.distance(points) == expected);
    CHECK(solver.distance({a, b}) == expected);
    CHECK(solver.distance({b}) == solver.distance(b));
    CHECK(solver.distance(b) == solver.distance(Source<T>{b, 0}));
    std::vector<T> out(expected.size());
    solver.distance_into(out, points);
    CHECK(out == expected);
    solver.distance_into(out, b);
    CHECK(out == solver.distance(b));
    solver.distance_into(out, {a, b});
    CHECK(out == expected);
    CHECK_THROWS_AS((void)solver.distance(none), InvalidInput);
    CHECK_THROWS_AS(solver.distance_into(out, wrong), InvalidInput);
    CHECK(out == expected);
  };
  const auto solved = [&](const auto& solver, const auto& distances_of) {
    held(solver);
    CHECK(distances_of(solver.solve(points)) == solver.distance(sources));
    CHECK(distances_of(solver.solve({a, b})) == solver.distance(sources));
    CHECK(distances_of(solver.solve(a)) == solver.distance(Source<T>{a, 0}));
    CHECK_THROWS_AS((void)solver.solve(none), InvalidInput);
    CHECK_THROWS_AS((void)solver.solve(wrong), InvalidInput);
  };
  held(DijkstraSolver(mesh));
  held(FastMarchingSolver(mesh));
  held(VirtualSourceSolver(mesh));
  const ExactSolver exact(mesh);
  solved(exact, [](const auto& field) { return field.distances(); });
  solved(HeatSolver(mesh), [](const auto& result) { return result.distance; });
  solved(DistancePlanner(mesh), [](const auto& result) { return result.distance; });
  solved(SmoothDistanceSolver(mesh), [](const auto& result) { return result.distance; });
  const HeatSolver heat(mesh);
  const std::vector rows{heat.distance(a), heat.distance(b)};
  CHECK(heat.distance_from_each(points) == rows);
  CHECK(heat.distance_from_each({a, b}) == rows);
  CHECK(heat.distance_from_each({Source<T>{a}, Source<T>{b}}) == rows);
  CHECK(heat.distance_from_each({3, 60}) == std::vector{heat.distance(3), heat.distance(60)});
  CHECK(exact.solve(points, {.keep_windows = true}).distances() == exact.distance(sources));
  CHECK(exact.solve({a, b}, {.keep_windows = true}).distances() == exact.distance(sources));

  const Certifier certifier(mesh);
  const std::vector<T> d = exact.distance(sources), one = exact.distance(a);
  CHECK(certifier.bounds(points, d).lower == certifier.bounds(sources, d).lower);
  CHECK(certifier.bounds({a, b}, d).upper == certifier.bounds(sources, d).upper);
  CHECK(certifier.bounds(a, one).lower == certifier.bounds(Source<T>{a, 0}, one).lower);
}
