#include "gelight/geodesic/shortest_path.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "stress/kept_meshes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Random;
using test::uniform;
using test::uniform_index;

namespace {

using Point = SurfacePoint<double>;
constexpr double pi = std::numbers::pi;

// A walk along edges that goes where it likes, and some steps back, in the end to a vertex.
Path<double> wandering(const Surface<double>& surface, Index from, Index to, int steps,
                       Random& random) {
  Path<double> path{vertex_point<double>(from)};
  Index v = from;
  for (int i = 0; i < steps; ++i) {
    const auto corners = surface.corners(v);
    const Index out = corners[uniform_index(random, static_cast<Index>(std::ssize(corners)))];
    v = surface.tip(out);
    path.push_back(vertex_point<double>(v));
  }
  const Path<double> rest = PathSolver<double>(surface).straight_path(v, to);
  path.insert(path.end(), rest.begin() + 1, rest.end());
  return path;
}

// A prism of `sides` sides of 1 and `rows` rows of 1, open above and below: vertex sides k + j.
Mesh<double> prism(Index sides, Index rows, Random& random) {
  Mesh<double> mesh;
  const double radius = 0.5 / std::sin(pi / sides);
  for (Index k = 0; k <= rows; ++k) {
    for (Index j = 0; j < sides; ++j) {
      const double turn = 2 * pi * j / sides;
      mesh.positions.push_back({radius * std::cos(turn), radius * std::sin(turn), double(k)});
    }
  }
  for (Index k = 0; k < rows; ++k) {
    for (Index j = 0; j < sides; ++j) {
      const Index a = sides * k + j, b = sides * k + (j + 1) % sides, c = b + sides, d = a + sides;
      if (uniform(random, 0, 1) < 0.5) {
        mesh.faces.push_back({a, b, c});
        mesh.faces.push_back({a, c, d});
      } else {
        mesh.faces.push_back({a, b, d});
        mesh.faces.push_back({b, c, d});
      }
    }
  }
  return mesh;
}

double size_of(const Mesh<double>& mesh) { return detail::size_of(Surface<double>(mesh)); }

// Shortest paths of random pairs against a whole solve's distances. Both are lengths of real paths,
// off by rounding at the size of the mesh.
void check_pairs(const Mesh<double>& mesh, int pairs, double rounding, Random& random) {
  const PathSolver<double> paths(mesh);
  const Surface<double>& surface = paths.surface();
  const ExactSolver<double> solver(mesh);
  const double size = size_of(mesh);
  for (int i = 0; i < pairs; ++i) {
    const Point from = test::random_point(mesh, random);
    ExactOptions<double> options;
    options.keep_windows = true;
    const auto field = solver.solve(from, options);
    for (int j = 0; j < 6; ++j) {
      const Point to = test::random_point(mesh, random);
      const double truth = field.distance(to);
      const Path<double> path = paths.shortest_path(from, to);
      const Path<double> straight = paths.straight_path(from, to);
      REQUIRE(path.empty() == std::isinf(truth));
      REQUIRE(straight.empty() == std::isinf(truth));
      if (path.empty()) continue;
      CHECK(surface.difference(path.front(), from).norm() <= rounding * size);
      CHECK(surface.difference(path.back(), to).norm() <= rounding * size);
      CHECK(faces_along(surface, path).size() == path.size() - 1);
      CHECK(faces_along(surface, straight).size() == straight.size() - 1);
      CHECK(std::fabs(length(surface, path) - truth) <= rounding * size);
      CHECK(length(surface, straight) >= truth - rounding * size);
    }
  }
}

}  // namespace

TEST_CASE("shortest paths are as long as a whole solve says: meshes like a scanner's") {
  Random random(1);
  for (const auto& scan : test::scan_meshes(3)) {
    INFO(scan.name);
    const auto& mesh = scan.mesh;
    check_pairs(mesh, 4, 1e-14, random);
  }
}

TEST_CASE("shortest paths are as long as a whole solve says: small, hard, tiny, huge and far") {
  Random random(2);
  std::vector<Mesh<double>> meshes;
  for (const auto& [name, mesh] : stress::kept_meshes()) meshes.push_back(mesh);
  for (int kind = 0; kind < 40; ++kind) meshes.push_back(test::small_random_mesh(kind, random));
  std::erase_if(meshes, [](const auto& mesh) { return !check(mesh).is_accepted(); });
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    INFO("mesh " << i);
    for (const double scale : {1.0, 1e-6, 1e6}) {
      Mesh<double> mesh = meshes[i];
      for (auto& p : mesh.positions) {
        for (double& x : p) x *= scale;
      }
      // Of needles and edges of no length, whose paths a whole solve rounds by as much.
      check_pairs(mesh, 4, 1e-10, random);
    }
  }
  // Far from the origin: of meshes whose faces have area there still.
  for (const double offset : {1e3, 1e6}) {
    Mesh<double> mesh = icosphere<double>(2);
    for (auto& p : mesh.positions) {
      for (double& x : p) x += offset;
    }
    check_pairs(mesh, 10, 1e-14, random);
  }
}

TEST_CASE("float: the path's length is the distance, rounded") {
  Random random(3);
  const Mesh<float> mesh = icosphere<float>(3);
  const PathSolver paths(mesh);
  const ExactSolver solver(mesh);
  const Surface<float> surface(mesh);
  for (int i = 0; i < 20; ++i) {
    const Index from = uniform_index(random, 642), to = uniform_index(random, 642);
    const auto path = paths.shortest_path(from, to);
    CHECK(length(surface, path) ==
          gelight::test::approx(solver.solve(from).distance(to)).epsilon(1e-6));
  }
}

TEST_CASE("points of one face, one point, and parts that are not connected") {
  const Mesh<double> mesh = grid<double>(2, 2);
  const PathSolver paths(mesh);
  const Point a = face_point<double>(0, {0.2, 0.3, 0.5}),
              b = face_point<double>(0, {0.5, 0.3, 0.2});
  CHECK(paths.shortest_path(a, b) == Path<double>{a, b});
  CHECK(paths.shortest_path(3, 3) == Path<double>{vertex_point<double>(3)});
  // One place by two names.
  CHECK(
      paths.straight_path(vertex_point<double>(mesh.faces[0][0]), face_point<double>(0, {1, 0, 0}))
          .size() == 1);
  const std::vector<Mesh<double>> parts{mesh, mesh};
  const auto two = joined<double>(parts);
  CHECK(shortest_path(two, vertex_point<double>(0), vertex_point<double>(10)).empty());
  CHECK(PathSolver(two).straight_path(0, 10).empty());
}

TEST_CASE("a flat sheet: whatever wanders, straightened, is the straight line") {
  Random random(4);
  for (int i = 0; i < 30; ++i) {
    const auto mesh = test::jittered_grid(12, 0.2, random);
    const Surface<double> surface(mesh);
    const Index a = uniform_index(random, 169), b = uniform_index(random, 169);
    const auto path = straighten_path(mesh, wandering(surface, a, b, 30 * i, random));
    const double truth = (surface.position(a) - surface.position(b)).norm();
    CHECK(std::fabs(length(surface, path) - truth) <= 1e-13);
    CHECK(path.front() == vertex_point<double>(a));
    CHECK(path.back() == vertex_point<double>(b));
  }
}

TEST_CASE("a prism: a path that winds round it stays a helix of as many turns") {
  Random random(5);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Index sides = 3 + uniform_index(random, 8), rows = 12;
    Mesh<double> mesh = prism(sides, rows, random);
    for (auto& p : mesh.positions) {
      for (double& x : p) x *= scale;
    }
    const Surface<double> surface(mesh);
    for (const Index turns : {0, 1, 2, 5}) {
      const Index start = uniform_index(random, sides), sideways = uniform_index(random, sides);
      Path<double> path;
      Index k = 0;
      for (Index j = 0; j <= turns * sides + sideways; ++j) {
        path.push_back(vertex_point<double>(sides * k + (start + j) % sides));
        if (j % 4 == 3 && k < rows) {  // up, along an edge
          ++k;
          path.push_back(vertex_point<double>(sides * k + (start + j) % sides));
        }
      }
      const auto taut = straighten_path(mesh, path);
      const double round = scale * (turns * sides + sideways), up = scale * k;
      CHECK(length(surface, taut) == gelight::test::approx(std::hypot(round, up)).epsilon(1e-12));
    }
  }
}

TEST_CASE("a sheet with a square hole: taut round the side on which the path was") {
  Random random(6);
  const auto mesh = test::sheet_with_hole(
      9, random, [](double x, double y) { return x > 3 && x < 6 && y > 3 && y < 6; });
  const Surface<double> surface(mesh);
  const auto at = [](Index x, Index y) { return 10 * y + x; };
  // From (1, 4) to (8, 5), over the corners (3, 3) and (6, 3) or (3, 6) and (6, 6).
  const PathSolver paths(mesh);
  const auto by = [&](Index y) {
    Path<double> path = paths.straight_path(at(1, 4), at(4, y));
    const auto rest = paths.straight_path(at(4, y), at(8, 5));
    path.insert(path.end(), rest.begin() + 1, rest.end());
    return length(surface, paths.straightened(path));
  };
  CHECK(by(1) == gelight::test::approx(std::hypot(2, 1) + 3 + std::hypot(2, 2)).epsilon(1e-14));
  CHECK(by(8) == gelight::test::approx(std::hypot(2, 2) + 3 + std::hypot(2, 1)).epsilon(1e-14));
}

TEST_CASE("on a sphere no straight path meets a vertex on its way, and none is much too long") {
  Random random(7);
  const auto mesh = icosphere<double>(4);
  const PathSolver paths(mesh);
  const Surface<double>& surface = paths.surface();
  for (int i = 0; i < 200; ++i) {
    const Index a = uniform_index(random, 2562), b = uniform_index(random, 2562);
    const auto path = paths.straight_path(a, b);
    // Less than 2 pi about every vertex leaves less than pi on one side.
    for (std::size_t k = 1; k + 1 < path.size(); ++k) {
      CHECK(path[k].kind != Point::Kind::vertex);
    }
    const double half_turn = pi - 0.3;
    const double great_circle =
        std::acos(std::clamp(surface.position(a).dot(surface.position(b)), -1.0, 1.0));
    if (great_circle < half_turn && a != b) {
      CHECK(length(surface, path) <= 1.001 * great_circle);
    }
  }
}

TEST_CASE("never longer than before, and straight stays straight") {
  Random random(8);
  for (const auto& scan : test::scan_meshes(3)) {
    INFO(scan.name);
    const auto& mesh = scan.mesh;
    const PathSolver paths(mesh);
    const Surface<double>& surface = paths.surface();
    for (int i = 0; i < 4; ++i) {
      const Index a = uniform_index(random, surface.vertex_count());
      Index b = a;
      for (int k = 0; k < 20; ++k) b = surface.tip(surface.corners(b)[0]);
      const auto guess = wandering(surface, a, b, 40, random);
      if (guess.size() < 2) continue;
      const auto once = paths.straightened(guess), twice = paths.straightened(once);
      CHECK(length(surface, once) <= length(surface, guess));
      CHECK(length(surface, twice) <= length(surface, once) * (1 + 1e-14));
      CHECK(length(surface, twice) >= length(surface, once) * (1 - 1e-12));
      const auto exact = paths.shortest_path(a, b), kept = paths.straightened(exact);
      CHECK(std::fabs(length(surface, kept) - length(surface, exact)) <= 1e-13);
    }
  }
}

TEST_CASE("never longer than before, over faces without area either") {
  // A fan over a cap: vertex 0 lies on the cap's side from 5 to 7.
  const Mesh<double> mesh{
      {{-0.5, 0.75, 0},
       {0, 0.75, 0},
       {-0.75, 0.5, 0},
       {-0.25, 0.75, 0},
       {0, 1, 0},
       {-0.25, 0.75, 0},
       {-0.5, 0.25, 0},
       {-1, 0.75, 0},
       {0, 0, 0}},
      {{0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 7}, {1, 6, 5}, {5, 6, 7}, {1, 8, 6}}};
  const PathSolver paths(mesh);
  const auto a = face_point<double>(0, {0.258, 0.45, 0.292}), b = edge_point<double>(1, 8, 0.523);
  const auto direct = paths.straight_path(a, b);
  CHECK(length(paths.surface(), paths.straightened(direct)) <=
        length(paths.surface(), direct) * (1 + 1e-12));
  const Path<double> by_the_cap{a,
                                vertex_point<double>(0),
                                edge_point<double>(5, 7, 1.0 / 3),
                                edge_point<double>(5, 6, 0.28),
                                edge_point<double>(1, 6, 0.44),
                                b};
  CHECK(length(paths.surface(), paths.straightened(by_the_cap)) <=
        length(paths.surface(), by_the_cap) * (1 + 1e-12));
}

TEST_CASE("what is not of the mesh is refused") {
  const Mesh<double> mesh = grid<double>(2, 2);
  const PathSolver paths(mesh);
  const auto refusal = [&](const auto& act) { return test::refusal(act); };
  CHECK(test::contains(refusal([&] { (void)paths.shortest_path(0, 9); }), "vertex 9"));
  CHECK(test::contains(refusal([&] { (void)paths.straight_path(-1, 0); }), "vertex -1"));
  CHECK(test::contains(
      refusal([&] {
        (void)paths.shortest_path(face_point<double>(8, {1, 0, 0}), vertex_point<double>(0));
      }),
      "face 8"));
  CHECK(test::contains(refusal([&] { (void)paths.straightened({}); }), "no points"));
  const Path<double> jump{vertex_point<double>(0), vertex_point<double>(1),
                          vertex_point<double>(8)};
  CHECK(test::contains(refusal([&] { (void)paths.straightened(jump); }), "point 1"));
  CHECK(
      test::contains(refusal([&] { (void)faces_along(Surface<double>(mesh), jump); }), "point 1"));
  const Path<double> after_repeats{jump[0], jump[0], jump[0], jump[1], jump[1], jump[2]};
  CHECK(test::contains(refusal([&] { (void)paths.straightened(after_repeats); }), "point 4"));
}

TEST_CASE("a query is cancelled, and the next one is as if it had not been") {
  bool stop = false;
  const auto mesh = icosphere<double>(4);
  const PathSolver paths(mesh, [&] { return stop; });
  const auto before = paths.shortest_path(0, 77);
  stop = true;
  CHECK_THROWS_AS((void)paths.shortest_path(0, 77), Cancelled);
  CHECK_THROWS_AS((void)paths.straight_path(0, 77), Cancelled);
  stop = false;
  CHECK(paths.shortest_path(0, 77) == before);
}
