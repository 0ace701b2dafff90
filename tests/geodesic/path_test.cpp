#include "gelight/geodesic/path.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/geodesic/shortest_path.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using gelight::edge_point;
using gelight::face_point;
using gelight::InvalidInput;
using gelight::Path;
using gelight::Surface;
using gelight::vertex_point;

TEST_CASE_TEMPLATE("positions and length of a path", T, float, double) {
  const Surface surface(gelight::grid<T>(2, 2, 2, 2));
  const Path<T> path{vertex_point<T>(0), edge_point<T>(0, 4, T(0.5)), vertex_point<T>(4),
                     face_point<T>(5, {T(0.5), T(0), T(0.5)})};
  const auto points = gelight::positions(surface, path);
  REQUIRE(points.size() == 4);
  CHECK(points[1].isApprox(gelight::Vec3<T>(T(0.5), T(0.5), 0)));
  CHECK(points[3].isApprox(surface.position(path[3])));
  T sum = 0;
  for (std::size_t i = 1; i < 4; ++i) sum += (points[i] - points[i - 1]).norm();
  CHECK(gelight::length(surface, path) == gelight::test::approx(double(sum)));
}

TEST_CASE("a path of one point or none has no length; a foreign point is refused") {
  const Surface surface(gelight::grid<double>(1, 1));
  CHECK(gelight::length(surface, Path<double>{}) == 0);
  CHECK(gelight::length(surface, Path<double>{vertex_point<double>(2)}) == 0);
  CHECK_THROWS_AS((void)gelight::length(
                      surface, Path<double>{vertex_point<double>(0), vertex_point<double>(4)}),
                  InvalidInput);
  CHECK_THROWS_AS((void)gelight::length(surface, Path<double>{vertex_point<double>(4)}),
                  InvalidInput);
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS((void)gelight::length(surface, Path<float>{face_point<float>(0, {0, 1, nan})}),
                  InvalidInput);
}

TEST_CASE("a path of floats on a surface of doubles, as of solvers on a mesh of floats") {
  const gelight::ExactSolver solver(gelight::grid<float>(3, 3, 3, 3));
  const auto field = solver.solve(face_point<float>(0, {0.1F, 0.2F, 0.7F}));
  const Path<float> path = field.path(15);
  const double length = gelight::length(solver.surface(), path);
  CHECK(length == gelight::test::approx(double{field.distance(15)}).epsilon(1e-6));
  const auto points = gelight::positions(solver.surface(), path);
  CHECK((points.back() - points.front()).norm() == gelight::test::approx(length).epsilon(1e-6));
  const auto faces = gelight::faces_along(solver.surface(), path);
  REQUIRE(faces.size() + 1 == path.size());
  CHECK(faces.front() == 0);
  CHECK_THROWS_AS((void)gelight::positions(solver.surface(), Path<float>{vertex_point<float>(16)}),
                  InvalidInput);
}

TEST_CASE("isolines, straight paths and sources along a path, of floats on a surface of doubles") {
  const auto mesh = gelight::grid<float>(4, 4, 4, 4);
  const gelight::ExactSolver solver(mesh);
  const auto field = solver.solve(0);
  // A straight path across the sheet, and a quarter of a circle about its end.
  const Path<float> path = gelight::trace_geodesic(solver.surface(), vertex_point<float>(0),
                                                   {1, 2, 0}, std::sqrt(20.0F));
  REQUIRE(path.size() > 2);
  CHECK(gelight::length(solver.surface(), path) ==
        gelight::test::approx(std::sqrt(20.0)).epsilon(1e-6));
  CHECK(field.distance(path.back()) == gelight::test::approx(std::sqrt(20.0)).epsilon(1e-6));
  const auto lines = gelight::isolines(solver.surface(), field.distances(), 2.5);
  REQUIRE(lines.size() == 1);
  CHECK(gelight::length(solver.surface(), lines[0].points) ==
        gelight::test::approx(2.5 * std::numbers::pi / 2).epsilon(0.03));
  CHECK(gelight::area_below(solver.surface(), field.distances(), 2.5) ==
        gelight::test::approx(2.5 * 2.5 * std::numbers::pi / 4).epsilon(0.06));
  const auto sources = gelight::sources_along(solver.surface(), gelight::segments(path), 0.1F);
  const auto from_path = solver.solve(sources);
  for (const auto& point : path) CHECK(from_path.distance(point) < 0.01);
  // The corner (4, 0) is nearest to (0.8, 1.6).
  CHECK(from_path.distance(4) == gelight::test::approx(4 * 2 / std::sqrt(5.0)).epsilon(1e-3));
}

TEST_CASE("the shortest path between two vertices of a mesh") {
  const auto mesh = gelight::grid<float>(3, 3, 3, 3);
  const auto path = gelight::shortest_path(mesh, 0, 7);
  CHECK(path == gelight::shortest_path(mesh, vertex_point<float>(0), vertex_point<float>(7)));
  CHECK(gelight::length(Surface(mesh), path) == gelight::test::approx(std::sqrt(10.0)));
  CHECK_THROWS_AS((void)gelight::shortest_path(mesh, 0, 16), InvalidInput);
}
