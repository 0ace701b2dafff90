#include "gelight/mesh/nearest.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "gelight/mesh/shapes.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"

using gelight::Index;
using gelight::nearest_point;
using gelight::nearest_vertex;
using gelight::Surface;
using gelight::Vec3;
namespace test = gelight::test;

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
    CHECK(nearest_vertex(ball, 1.5 * ball.position(v)) == v);
    const auto point = nearest_point(ball, ball.position(v));
    CHECK((ball.position(point) - ball.position(v)).norm() < 1e-15);
  }
}

TEST_CASE("shares of what lies on a side, but for rounding, are never negative") {
  test::Random random(7);
  for (int i = 0; i < 20000; ++i) {
    gelight::Mesh<double> triangle{{}, {{0, 1, 2}}};
    for (int k = 0; k < 3; ++k) {
      triangle.positions.push_back({test::uniform(random, -1, 1), test::uniform(random, -1, 1), 0});
    }
    const Surface<double> surface(triangle);
    const double t = test::uniform(random, 0, 1);
    const Vec3<double> at = (1 - t) * surface.position(1) + t * surface.position(2);
    const auto point = nearest_point(surface, at);
    CHECK_NOTHROW(surface.require_point(point));
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

namespace {

// Sheets of any size and turn, and positions over them as high as you like: what is below is known.
template <class T>
void check_feet(double scale, test::Random& random) {
  const Eigen::Quaterniond turn(test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                                test::uniform(random, -1, 1), test::uniform(random, 0.1, 1));
  const Eigen::Matrix3d axes = scale * turn.normalized().toRotationMatrix();
  gelight::Mesh<double> flat = gelight::grid<double>(4, 3, 4, 3);
  gelight::Mesh<T> mesh;
  mesh.faces = flat.faces;
  for (const auto& [x, y, z] : flat.positions) {
    const Vec3<T> p = (axes * Vec3<double>(x, y, z)).cast<T>();
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  const Surface<T> sheet(mesh);
  const double rounding = 64 * double{std::numeric_limits<T>::epsilon()};
  for (int i = 0; i < 60; ++i) {
    const double height = std::pow(10, test::uniform(random, -3, 4)) * (i % 2 == 0 ? 1 : -1);
    const Vec3<double> foot(test::uniform(random, 0, 4), test::uniform(random, 0, 3), 0);
    const Vec3<T> over = (axes * (foot + Vec3<double>(0, 0, height))).cast<T>();
    const auto point = nearest_point(sheet, over);
    CHECK(test::refusal([&] { sheet.require_point(point); }) == "accepted");
    const double off = (sheet.position(point).template cast<double>() - axes * foot).norm();
    // Distances that differ by rounding alone are of places as far apart as the root of that.
    const double root = std::sqrt(std::numeric_limits<double>::epsilon());
    CHECK(off <= scale * (rounding * (4 + std::abs(height)) + 4 * root * std::abs(height)));
    const Index v = nearest_vertex(sheet, sheet.position(point));
    const double to_v = double{(sheet.position(v) - sheet.position(point)).stableNorm()};
    CHECK(to_v <= scale * std::sqrt(0.5) * (1 + rounding));
  }
}

}  // namespace

TEST_CASE("what is nearest is a point of the surface, however far and however large that is") {
  test::Random random(3);
  for (const double scale : {1e-15, 1e-6, 1.0, 1e6, 1e15}) {
    check_feet<double>(scale, random);
    check_feet<float>(scale, random);
  }
  for (const double scale : {1e-60, 1e60}) check_feet<double>(scale, random);
  const Surface sheet(gelight::grid<double>(2, 2));
  CHECK(test::contains(test::refusal([&] {
                         (void)nearest_point<double>(sheet, {0, 1e80, 0});
                       }),
                       "too far out"));
}
