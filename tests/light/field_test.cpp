#include "gelight/light/field.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <span>
#include <vector>

using gelight::dimmed;
using gelight::Falloff;
using gelight::InvalidInput;
using gelight::LightField;
using gelight::rectified;
using gelight::strength;
using gelight::Vec3;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

std::vector<double> strengths(std::vector<double> distances, Falloff<double> falloff) {
  return strength(std::span<const double>(distances), falloff);
}

}  // namespace

TEST_CASE("by default light does not fall off, out of reach there is none") {
  CHECK(strengths({0, 1e-9, 3, 1e9, inf}, {}) == std::vector<double>{1, 1, 1, 1, 0});
}

TEST_CASE("light spreads in inverse proportion to the distance and is absorbed exponentially") {
  CHECK(strengths({0, 0.5, 1, 2, 8}, {.full_within = 1}) ==
        std::vector<double>{1, 1, 1, 0.5, 0.125});
  const auto absorbed = strengths({0, 1, 2, inf}, {.absorption = 0.7});
  CHECK(absorbed[0] == 1);
  CHECK(absorbed[2] == doctest::Approx(absorbed[1] * absorbed[1]).epsilon(1e-15));
  CHECK(absorbed[1] == doctest::Approx(0.496585303791).epsilon(1e-12));
  CHECK(absorbed[3] == 0);
  const auto both = strengths({4}, {.full_within = 1, .absorption = 0.7});
  CHECK(both[0] == doctest::Approx(std::exp(-2.8) / 4).epsilon(1e-15));
  CHECK_THROWS_AS(strengths({-1}, {}), InvalidInput);
  CHECK_THROWS_AS(strengths({not_a_number}, {}), InvalidInput);
  CHECK_THROWS_AS(strengths({1}, {.full_within = 0}), InvalidInput);
  CHECK_THROWS_AS(strengths({1}, {.absorption = -1}), InvalidInput);
  CHECK_THROWS_AS(strengths({1}, {.absorption = inf}), InvalidInput);
}

TEST_CASE("a dimmed field has the lengths of its strengths") {
  const LightField<double> field{{1, 0, 0}, {0, 0.6, 0.8}, {0, 0, 0}};
  const std::vector<double> shares{0.5, 0.25, 1};
  const auto weak = dimmed<double>(field, shares);
  CHECK(weak[0] == Vec3<double>(0.5, 0, 0));
  CHECK(weak[1].norm() == doctest::Approx(0.25));
  CHECK(weak[2].isZero());
  CHECK_THROWS_AS((void)dimmed<double>(field, std::span(shares).first(2)), InvalidInput);
}

TEST_CASE("rectified directions are tangent, of unit length, nearest to what they were") {
  const LightField<double> field{{1, 0, 0}, {0.6, 0, 0.8}, {0, 0, 1}, {0, 0, 0}, {0, 0.5, -0.2}};
  const std::vector<Vec3<double>> normals{
      {0, 0, 1}, {0, 0, -3}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1e-200}};
  const auto flat = rectified<double>(field, normals);
  CHECK(flat[0] == Vec3<double>(1, 0, 0));
  CHECK((flat[1] - Vec3<double>(1, 0, 0)).norm() < 1e-15);
  CHECK(flat[2].isZero());  // along its normal
  CHECK(flat[3].isZero());
  CHECK((flat[4] - Vec3<double>(0, 1, 0)).norm() < 1e-15);
  const Vec3<double> slant = Vec3<double>(1, 2, -3).normalized();
  const auto along = rectified<double>({slant}, std::vector<Vec3<double>>{-7 * slant});
  CHECK(along[0].isZero());  // whatever rounding leaves
  CHECK_THROWS_AS((void)rectified<double>(field, std::span(normals).first(2)), InvalidInput);
  CHECK_THROWS_AS((void)rectified<double>({slant}, std::vector<Vec3<double>>{{0, 0, 0}}),
                  InvalidInput);
  CHECK_THROWS_AS((void)rectified<double>({slant}, std::vector<Vec3<double>>{{0, not_a_number, 0}}),
                  InvalidInput);
}
