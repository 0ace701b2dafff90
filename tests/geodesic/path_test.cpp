#include "gelight/geodesic/path.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "gelight/core/error.hpp"
#include "gelight/mesh/shapes.hpp"

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
  CHECK(gelight::length(surface, path) == doctest::Approx(double(sum)));
}

TEST_CASE("a path of one point or none has no length; a foreign point is refused") {
  const Surface surface(gelight::grid<double>(1, 1));
  CHECK(gelight::length(surface, Path<double>{}) == 0);
  CHECK(gelight::length(surface, Path<double>{vertex_point<double>(2)}) == 0);
  CHECK_THROWS_AS((void)gelight::length(
                      surface, Path<double>{vertex_point<double>(0), vertex_point<double>(4)}),
                  InvalidInput);
}
