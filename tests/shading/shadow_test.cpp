#include "gelight/shading/shadow.hpp"

#include <doctest/doctest.h>

#include <limits>

using namespace gelight;

namespace {

const Camera<double> camera{60, 60, 49.5, 39.5, 100, 80};

// A square of 11 pixels pressed in around a pixel.
Image<double> square(Index u, Index v, double depth) {
  Image<double> contact(100, 80, 0.03);
  for (Index y = v - 5; y <= v + 5; ++y) {
    for (Index x = u - 5; x <= u + 5; ++x) contact(x, y) -= depth;
  }
  return contact;
}

const Image<double> rest(100, 80, 0.03);

}  // namespace

TEST_CASE("darkening is in proportion to the penetration, and has an end") {
  auto contact = square(30, 30, 0.006);
  contact(0, 0) = 0.005;
  contact(1, 0) = 0.04;
  contact(2, 0) = std::numeric_limits<double>::quiet_NaN();
  contact(3, 0) = std::numeric_limits<double>::infinity();
  contact(4, 0) = 0;
  const auto darkening = penetration_darkening(contact, rest, 0.15, 0.02);
  CHECK(darkening(30, 30) == doctest::Approx(0.15 * 0.3));
  CHECK(darkening(0, 0) == 0.15);
  for (const Index x : {1, 2, 3, 4}) CHECK(darkening(x, 0) == 0);
  CHECK(darkening(60, 60) == 0);
}

TEST_CASE("without contact nothing is dark and nothing hidden: no 0/0") {
  CHECK(penetration_darkening(rest, rest) == Image<double>(100, 80));
  CHECK(contact_shadow(rest, rest, camera) == Image<float>(100, 80));
  const Image<double> unknown(100, 80, std::numeric_limits<double>::quiet_NaN());
  CHECK(contact_shadow(unknown, rest, camera) == Image<float>(100, 80));
}

TEST_CASE("a shadow lies within [0, 1], beside the contact and not on it") {
  const auto contact = square(75, 40, 0.004);
  const auto shadow = contact_shadow(contact, rest, camera);
  float most = 0;
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) {
      CHECK(shadow(x, y) >= 0);
      CHECK(shadow(x, y) <= 1);
      most = std::max(most, shadow(x, y));
      const bool around = std::abs(x - 75) <= 8 && std::abs(y - 40) <= 8;
      if (around) CHECK(shadow(x, y) == 0);
    }
  }
  CHECK(most > 0.1f);
  // To the right of the axis rays run to the right: the contact rises along them on its left side.
  CHECK(shadow(66, 40) > 2 * shadow(84, 40));
}

TEST_CASE("a contact and a camera mirrored left to right have a mirrored shadow") {
  const auto left = contact_shadow(square(24, 30, 0.004), rest, camera);
  const auto right = contact_shadow(square(99 - 24, 30, 0.004), rest, camera);
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) {
      CHECK(left(x, y) == doctest::Approx(right(99 - x, y)).epsilon(1e-4));
    }
  }
}

TEST_CASE("input that cannot be used is refused") {
  CHECK_THROWS_AS((void)penetration_darkening(Image<double>(3, 3), rest), InvalidInput);
  CHECK_THROWS_AS((void)penetration_darkening(rest, rest, 1.5), InvalidInput);
  CHECK_THROWS_AS((void)penetration_darkening(rest, rest, 0.1, 0), InvalidInput);
  CHECK_THROWS_AS((void)contact_shadow(Image<double>(3, 3), rest, camera), InvalidInput);
  CHECK_THROWS_AS((void)contact_shadow(rest, rest, camera, ContactShadow{.sigma = -1}),
                  InvalidInput);
}
