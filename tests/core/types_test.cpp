#include "gelight/core/types.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gelight/core/bits.hpp"

using namespace gelight;

TEST_CASE_TEMPLATE("a vector's length neither overflows nor underflows", T, float, double) {
  using Limits = std::numeric_limits<T>;
  for (int e = Limits::min_exponent - Limits::digits + 1; e < Limits::max_exponent - 3; ++e) {
    const T unit = std::ldexp(T(1), e);  // from the least number that there is
    CAPTURE(e);
    CHECK(detail::stable_norm(Vec3<T>(2 * unit, -3 * unit, 6 * unit)) == 7 * unit);
    CHECK(detail::stable_norm(Vec2<T>(-3 * unit, 4 * unit)) == 5 * unit);
    const Vec2<T> direction = detail::stable_unit(Vec2<T>(-3 * unit, 4 * unit));
    CHECK(direction.x() == T(-0.6));
    CHECK(direction.y() == T(0.8));
  }
}

TEST_CASE_TEMPLATE("lengths of zero and of what is not finite", T, float, double) {
  constexpr T inf = std::numeric_limits<T>::infinity();
  CHECK(detail::stable_norm(Vec3<T>(0, 0, 0)) == 0);
  CHECK(detail::stable_unit(Vec3<T>(0, -T(0), 0)) == Vec3<T>(0, 0, 0));
  CHECK(detail::stable_norm(Vec3<T>(1, -inf, 0)) == inf);
  CHECK(std::isnan(detail::stable_norm(Vec3<T>(0, std::numeric_limits<T>::quiet_NaN(), 0))));
  CHECK(std::isnan(detail::stable_norm(Vec3<T>(inf, 1, std::numeric_limits<T>::quiet_NaN()))));
}

TEST_CASE("bits of numbers, there and back") {
  // IEEE 754: sign, exponent plus bias, and what follows the leading one.
  CHECK(detail::bit_cast<std::uint32_t>(1.0f) == 0x3f800000u);
  CHECK(detail::bit_cast<std::uint32_t>(-0.0f) == 0x80000000u);
  CHECK(detail::bit_cast<std::uint64_t>(-2.5) == 0xc004000000000000u);
  static_assert(detail::bit_cast<double>(std::uint64_t{0x7ff0000000000000u}) ==
                std::numeric_limits<double>::infinity());
  for (const float x : {1e-45f, 0.1f, -3e38f}) {
    CHECK(detail::bit_cast<float>(detail::bit_cast<std::int32_t>(x)) == x);
  }
}

TEST_CASE("expressions of Eigen stay what they are beside this library's names") {
  const Eigen::Vector3d a(1, -2, 3), b(4, 5, 6);
  const Eigen::Vector2f p(3, 4), q(0, 1);
  // Kept by value in what follows: no operator of ours may make it a vector that is gone by then.
  static_assert(!std::is_same_v<decltype(a - b), Eigen::Vector3d>);
  static_assert(!std::is_same_v<decltype(2.0 * q), Eigen::Vector2f>);
  const auto amounts = (a - b).cwiseAbs();
  CHECK(Eigen::Vector3d(amounts) == Eigen::Vector3d(3, 7, 3));
  CHECK(norm(2 * p) == 10);
  CHECK(squared_norm(p - q) == 18);
  CHECK(dot(a - b, a) == 2);
  CHECK(dot(p, q - p) == -21);
  CHECK(cross(a + b, b) == cross(a, b));
  CHECK(normalized(p + p) == normalized(p));
  CHECK(cast<float>(a - b) == Eigen::Vector3f(-3, -7, -3));
}
