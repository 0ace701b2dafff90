#include "gelight/light/linear.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "gelight/mesh/shapes.hpp"

using gelight::InvalidInput;
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

TEST_CASE_TEMPLATE("linear light is one unit long between places of any size", T, float, double) {
  const T least = std::numeric_limits<T>::denorm_min(), most = std::numeric_limits<T>::max();
  const T third = 1 / std::sqrt(T(3));
  for (const T size : {least, 3 * least, T(1), most / 2, most}) {
    const std::vector<Vec3<T>> at{{size, -size, size}}, led{{0, 0, 0}};
    const auto field = gelight::linear_field<T>(led[0], at);
    CHECK(field[0].isApprox(Vec3<T>(third, -third, third)));
    if (size < most) CHECK(gelight::linear_rays<T>(led, at).direction[0].isApprox(field[0]));
  }
}

TEST_CASE_TEMPLATE("linear light has no way between places too far apart for a number", T, float,
                   double) {
  const T most = std::numeric_limits<T>::max();
  const std::vector<Vec3<T>> at{{1, 1, 1}, {-most, 1, 1}}, led{{most, 0, 0}};
  CHECK_THROWS_AS((void)gelight::linear_field<T>(led[0], at), InvalidInput);
  CHECK_THROWS_AS((void)gelight::linear_rays<T>(led, at), InvalidInput);
  // But from the nearest of several points there may be one.
  std::vector<Vec3<T>> near_one{led[0], Vec3<T>(0, 0, 0)};
  const auto rays = gelight::linear_rays<T>(near_one, at);
  CHECK(rays.direction[1].isApprox(Vec3<T>(-1, 0, 0)));
  CHECK(rays.lighting[1] == gelight::Lighting::lit);
}
