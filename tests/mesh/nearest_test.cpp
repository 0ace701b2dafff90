#include "gelight/mesh/nearest.hpp"

#include <doctest/doctest.h>

#include <limits>

#include "gelight/mesh/shapes.hpp"

using gelight::Index;
using gelight::nearest_point;
using gelight::nearest_vertex;
using gelight::Surface;
using gelight::Vec3;

TEST_CASE(
    "over a sheet the nearest point is below, beside it on the border, beyond a corner there") {
  const Surface sheet(gelight::grid<double>(5, 4, 5, 4));
  const auto at = [&](const Vec3<double>& p) {
    return Vec3<double>(sheet.position(nearest_point(sheet, p)));
  };
  for (const double height : {0.0, 1e-9, 3.0}) {
    CHECK((at({2.3, 1.9, height}) - Vec3<double>(2.3, 1.9, 0)).norm() < 1e-14);
    CHECK((at({2.3, 5.0, height}) - Vec3<double>(2.3, 4, 0)).norm() < 1e-14);
    CHECK((at({7.0, -2.0, height}) - Vec3<double>(5, 0, 0)).norm() < 1e-14);
  }
}

TEST_CASE("no point of the surface is nearer, and vertices are nearest to themselves") {
  const Surface ball(gelight::icosphere<double>(2));
  for (const Vec3<double>& p : {Vec3<double>(0.1, 0.2, -0.1), Vec3<double>(3, -1, 2)}) {
    const auto nearest = nearest_point(ball, p);
    const double distance = (ball.position(nearest) - p).norm();
    for (Index f = 0; f < ball.face_count(); ++f) {
      for (int i = 0; i <= 8; ++i) {
        for (int j = 0; i + j <= 8; ++j) {
          const auto other = gelight::face_point<double>(f, {i / 8.0, j / 8.0, (8 - i - j) / 8.0});
          CHECK((ball.position(other) - p).norm() >= distance - 1e-15);
        }
      }
    }
  }
  for (Index v = 0; v < ball.vertex_count(); ++v) {
    CHECK(nearest_vertex(ball, ball.position(v)) == v);
    const auto point = nearest_point(ball, ball.position(v));
    CHECK((ball.position(point) - ball.position(v)).norm() < 1e-15);
  }
}

TEST_CASE("faces without area are their sides, and positions that are not finite are refused") {
  gelight::Mesh<double> mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, 0, 0}};
  mesh.faces = {{0, 1, 2}};
  const Surface line(mesh);
  const auto point = nearest_point<double>(line, {1.5, 1, 0});
  CHECK((line.position(point) - Vec3<double>(1.5, 0, 0)).norm() < 1e-15);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS((void)nearest_point<double>(line, {0, nan, 0}),
                       "the position (0, nan, 0) is not finite", gelight::InvalidInput);
  CHECK_THROWS_AS((void)nearest_vertex<double>(line, {0, nan, 0}), gelight::InvalidInput);
}
