#include "gelight/light/compact.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <vector>

using namespace gelight;

namespace {

template <class T>
Vec3<T> random_direction(std::mt19937& random) {
  std::normal_distribution<T> normal;
  return Vec3<T>(normal(random), normal(random), normal(random)).normalized();
}

template <class T>
double worst_angle() {
  std::mt19937 random(7);
  std::vector<Vec3<T>> normals;
  LightField<T> field;
  for (int i = 0; i < 200000; ++i) {
    const Vec3<double> n = random_direction<double>(random), d = random_direction<double>(random);
    normals.push_back(n.cast<T>());
    field.push_back((d - d.dot(n) * n).normalized().template cast<T>());
  }
  const auto compact = packed<T>(field, normals);
  const auto back = unpacked<T>(std::span<const CompactDirection>(compact), normals);
  double worst = 0;
  for (std::size_t i = 0; i < field.size(); ++i) {
    const Vec3<double> a = field[i].template cast<double>(), b = back[i].template cast<double>();
    CHECK(std::abs(b.norm() - 1) < 2.3e-5);
    CHECK(std::abs(double{back[i].dot(normals[i])}) <
          4 * double{std::numeric_limits<T>::epsilon()});
    worst = std::max(worst, std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  return worst * 180 / std::numbers::pi;
}

}  // namespace

static_assert(sizeof(CompactDirection) == 4);

TEST_CASE(
    "bases of planes are orthonormal and right-handed, on the poles and where z is zero too") {
  std::mt19937 random(3);
  std::vector<Vec3<double>> normals{{0, 0, 1},  {0, 0, -1},   {1, 0, 0},     {0, 1, 0},
                                    {-1, 0, 0}, {1, 0, -0.0}, {1e-9, 0, -1}, {0, 1e-9, 1}};
  for (int i = 0; i < 10000; ++i) normals.push_back(random_direction<double>(random));
  for (const auto& n : normals) {
    const auto [x, y] = plane_basis<double>(n);
    CHECK(std::abs(x.norm() - 1) < 1e-14);
    CHECK(std::abs(y.norm() - 1) < 1e-14);
    CHECK((x.cross(y) - n).norm() < 1e-14);
  }
}

TEST_CASE("a unit tangent direction comes back within half a step of each component") {
  const double in_double = worst_angle<double>(), in_float = worst_angle<float>();
  MESSAGE("largest angle " << in_double << " degrees, in float " << in_float);
  CHECK(in_double < 0.0013);
  CHECK(in_float < 0.0013);
}

TEST_CASE("normals that are all but of unit length serve as well") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> off(-0.9e-4, 0.9e-4);
  for (int i = 0; i < 20000; ++i) {
    const Vec3<double> n = random_direction<double>(random);
    const Vec3<double> d = n.cross(random_direction<double>(random)).normalized();
    const std::vector<Vec3<double>> normals{(1 + off(random)) * n};
    const auto compact = packed<double>(LightField<double>{d}, normals);
    const Vec3<double> back =
        unpacked<double>(std::span<const CompactDirection>(compact), normals)[0];
    CHECK(std::abs(back.norm() - 1) < 2.3e-5);
    CHECK(std::atan2(back.cross(d).norm(), back.dot(d)) * 180 / std::numbers::pi < 0.0013);
  }
}

TEST_CASE("lengths are kept, zero is zero, the part along the normal is dropped") {
  const std::vector<Vec3<double>> normals(4, {0.36, 0.48, 0.8});
  const Vec3<double> tangent = normals[0].cross(Vec3<double>(1, 0, 0)).normalized();
  const LightField<double> field{
      0.3 * tangent, {0, 0, 0}, 0.5 * tangent + 0.7 * normals[0], normals[0]};
  const auto compact = packed<double>(field, normals);
  const auto back = unpacked<double>(std::span<const CompactDirection>(compact), normals);
  CHECK((back[0] - field[0]).norm() < 2.2e-5);
  CHECK(back[1].isZero());
  CHECK((back[2] - 0.5 * tangent).norm() < 2.2e-5);
  CHECK(back[3].isZero());
}

TEST_CASE("bad input is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Vec3<double>> up{{0, 0, 1}}, none, leaning{{0, 0, 1.1}};
  CHECK_THROWS_AS((void)packed<double>(LightField<double>{{1, 0, 0}}, none), InvalidInput);
  CHECK_THROWS_AS((void)packed<double>(LightField<double>{{1, 0, 0}}, leaning), InvalidInput);
  CHECK_THROWS_AS((void)packed<double>(LightField<double>{{2, 0, 0}}, up), InvalidInput);
  CHECK_THROWS_AS((void)packed<double>(LightField<double>{{0.9, 0.9, 0}}, up), InvalidInput);
  CHECK_THROWS_AS((void)packed<double>(LightField<double>{{0, 0, 5}}, up), InvalidInput);
  CHECK_THROWS_AS((void)packed<double>(LightField<double>{{nan, 0, 0}}, up), InvalidInput);
  CHECK_THROWS_AS((void)unpacked<double>(std::vector<CompactDirection>(2), up), InvalidInput);
  const std::vector<CompactDirection> compact(1);
  CHECK_THROWS_AS((void)unpacked<double>(compact, leaning), InvalidInput);
  for (int i = 0; i < 3; ++i) {
    for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
      std::vector<Vec3<double>> normals = up;
      normals[0][i] = bad;
      CHECK_THROWS_AS((void)unpacked<double>(compact, normals), InvalidInput);
    }
  }
}
