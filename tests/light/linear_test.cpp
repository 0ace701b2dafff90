#include "gelight/light/linear.hpp"

#include <doctest/doctest.h>

#include <array>

#include "gelight/mesh/shapes.hpp"

using gelight::Surface;
using gelight::Vec3;

TEST_CASE_TEMPLATE("linear light travels straight from the LED, and not at the LED", T, float,
                   double) {
  const Surface<T> surface(gelight::grid<T>(2, 2, 2, 2));
  const auto field =
      gelight::linear_field<T>(surface, Vec3<T>(0, 0, 1), gelight::vertex_points(surface));
  const T half = 1 / std::sqrt(T(2));
  CHECK(field[0].isApprox(Vec3<T>(0, 0, -1)));
  CHECK(field[1].isApprox(Vec3<T>(half, 0, -half)));
  CHECK(field[3].isApprox(Vec3<T>(0, half, -half)));

  const auto at_led =
      gelight::linear_field<T>(surface, surface.position(4), gelight::vertex_points(surface));
  CHECK(at_led[4].isZero());
}
