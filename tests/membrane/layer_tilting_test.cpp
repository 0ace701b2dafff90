#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "gelight/membrane/layer.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::contains;
using test::refusal;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double rest = 0.03, pitch = 1e-4;

Camera<double> camera(Index width, Index height) {
  return {rest / pitch, rest / pitch, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
}

template <class Height>
Image<double> object(const Camera<double>& eye, const Height& height) {
  Image<double> depth(eye.width, eye.height);
  for (Index v = 0; v < eye.height; ++v) {
    for (Index u = 0; u < eye.width; ++u) {
      depth(u, v) = rest + height((u - eye.cx) * pitch, (v - eye.cy) * pitch);
    }
  }
  return depth;
}

}  // namespace

TEST_CASE("a round punch on a half-space under a force beside its middle") {
  // Johnson, Contact Mechanics, 1985, sections 3.8 and 5.5: with E* = E / (1 - nu^2) a force P
  // sinks the punch by P / (2 a E*), a moment M tilts it by 3 M / (4 E* a^3).
  const auto eye = camera(81, 71);
  const double a = 24 * pitch, modulus = 1e5, nu = 0.4, force = 0.05;
  const double plane = modulus / (1 - nu * nu);
  const ElasticLayer layer(eye, rest, {modulus, nu, inf}, {.sideways = false});
  // Seen tilted, which must not matter.
  const auto punch = object(eye, [&](double x, double y) {
    return std::hypot(x, y) <= a ? 2e-4 + 0.02 * x - 0.01 * y : inf;
  });
  const Vec2<double> centre(0.15 * a, -0.1 * a);
  const auto contact = layer.press(punch, {.force = force, .centre = centre});
  REQUIRE(contact.converged);
  CHECK(-contact.force.z() == gelight::test::approx(force).epsilon(1e-3));
  const double sunk = force / (2 * a * plane);
  CHECK(contact.travel - 2e-4 == gelight::test::approx(sunk).epsilon(0.03));
  const Vec2<double> tilt = 3 * force / (4 * plane * a * a * a) * centre;
  CHECK(contact.tilt.x() - 0.02 == gelight::test::approx(tilt.x()).epsilon(0.05));
  CHECK(contact.tilt.y() + 0.01 == gelight::test::approx(tilt.y()).epsilon(0.05));
  // The force is along -z: its moment about the axis is centre x force.
  CHECK(contact.moment.x() == gelight::test::approx(-centre.y() * force).epsilon(5e-3));
  CHECK(contact.moment.y() == gelight::test::approx(centre.x() * force).epsilon(5e-3));
}

TEST_CASE("a plate seen far from level comes to lie on the gel, however light the force") {
  // The same formulae: what it was seen at must not matter.
  const auto eye = camera(81, 71);
  const double a = 24 * pitch, modulus = 1e5, nu = 0.4, plane = modulus / (1 - nu * nu);
  const ElasticLayer layer(eye, rest, {modulus, nu, inf}, {.sideways = false});
  const auto punch = object(
      eye, [&](double x, double y) { return std::hypot(x, y) <= a ? 0.1 * x - 0.06 * y : inf; });
  const Vec2<double> centre(-0.1 * a, 0.15 * a);
  for (const double force : {1e-5, 1e-4, 1e-3, 1e-2}) {
    CAPTURE(force);
    const auto contact = layer.press(punch, {.force = force, .centre = centre});
    CHECK(contact.converged);
    CHECK(-contact.force.z() == gelight::test::approx(force).epsilon(2e-3));
    CHECK(contact.travel == gelight::test::approx(force / (2 * a * plane)).epsilon(0.03));
    const Vec2<double> tilt = 3 * force / (4 * plane * a * a * a) * centre;
    const Vec2<double> off = contact.tilt - Vec2<double>(0.1, -0.06) - tilt;
    CHECK(off.norm() <= 0.05 * tilt.norm());
  }
}

TEST_CASE(
    "an object bears a force wherever that acts between its outermost pixels, and no farther") {
  const auto eye = camera(61, 51);
  for (const double thickness : {2e-3, inf}) {
    const ElasticLayer layer(eye, rest, {1e5, 0.45, thickness}, {.sideways = false});
    // Three feet: those at (-15, -10) and (15, -10) and (0, 15) pixels, seen a little tilted.
    const auto feet = object(eye, [](double x, double y) {
      const auto foot = [&](double u, double v) {
        return std::max(std::abs(x / pitch - u), std::abs(y / pitch - v)) < 1.5;
      };
      const bool is_there = foot(-15, -10) || foot(15, -10) || foot(0, 15);
      return is_there ? 0.03 * x - 0.02 * y : inf;
    });
    const auto press = [&](double x, double y) {
      const Vec2<double> centre(x * pitch, y * pitch);
      return layer.press(feet, {.force = 1e-3, .centre = centre});
    };
    // Between feet, over nothing; and in a foot's corner, the last place there is.
    for (const auto& at : {std::pair{0.0, -10.0}, {0.0, 0.0}, {3.0, -9.0}, {16.0, -11.0}}) {
      const double x = at.first, y = at.second;
      CAPTURE(x);
      CAPTURE(y);
      const auto contact = press(x, y);
      CHECK(contact.converged);
      CHECK(-contact.force.z() == gelight::test::approx(1e-3).epsilon(2e-3));
      CHECK(std::abs(contact.moment.y() - x * pitch * 1e-3) < 2e-3 * 15 * pitch * 1e-3);
      CHECK(std::abs(contact.moment.x() + y * pitch * 1e-3) < 2e-3 * 15 * pitch * 1e-3);
    }
    for (const auto& at : {std::pair{16.01, -11.0}, {0.0, -11.01}, {-12.0, 5.0}, {1e3, 1e3}}) {
      const double x = at.first, y = at.second;
      CAPTURE(x);
      CAPTURE(y);
      const std::string said = refusal([&] { (void)press(x, y); });
      CHECK(contains(said, "the force's centre ("));
      CHECK(contains(said, "beside the object"));
    }
    CHECK(contains(refusal([&] { (void)press(16.5, -11.0); }), "(0.00165, -0.0011)"));
    CHECK(contains(refusal([&] { (void)press(16.5, -11.0); }), "at pixel (46."));
  }
}

TEST_CASE("through its middle a body does not tilt; a ball rolls to where the force is") {
  const auto eye = camera(91, 81);
  const ElasticLayer layer(eye, rest, {1e5, 0.48, 3e-3}, {.sideways = false});
  const auto ball = object(eye, [](double x, double y) { return (x * x + y * y) / 0.02; });
  const auto straight = layer.press(ball, {.force = 0.05});
  const auto middle = layer.press(ball, {.force = 0.05, .centre = Vec2<double>(0, 0)});
  CHECK(middle.travel == gelight::test::approx(straight.travel).epsilon(2e-3));
  CHECK(middle.tilt.norm() < 2e-3 * straight.travel / 1e-3);
  // Tilting moves a paraboloid x^2 / (2 R) sideways by R times the tilt.
  const Vec2<double> centre(3e-4, -2e-4);
  const auto beside = layer.press(ball, {.force = 0.05, .centre = centre});
  REQUIRE(beside.converged);
  CHECK(beside.tilt.x() == gelight::test::approx(centre.x() / 0.01).epsilon(0.03));
  CHECK(beside.tilt.y() == gelight::test::approx(centre.y() / 0.01).epsilon(0.03));
}

TEST_CASE("bad input is named") {
  const auto eye = camera(21, 21);
  const ElasticLayer layer(eye, rest, {});
  const auto flat = object(eye, [](double, double) { return -1e-4; });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto says = [&](const LayerLoad& load) {
    return refusal([&] { (void)layer.press(flat, load); });
  };
  CHECK(contains(says({.centre = Vec2<double>(0, 0)}), "there is no force"));
  CHECK(contains(says({.force = 0.1, .centre = Vec2<double>(nan, 0)}), "centre"));
}

TEST_CASE("a force on what sticks and does not settle is given up, not sought for hours") {
  const Camera<double> eye{100, 100, 6, 8, 13, 17};
  const double width = 0.03 / 100;
  Image<double> depth(13, 17);
  for (Index y = 0; y < 17; ++y) {
    for (Index x = 0; x < 13; ++x) {
      const double r2 = (x - 5) * (x - 5) + (y - 8.3) * (y - 8.3);
      depth(x, y) = 0.03 - 0.02 * width * (1 - r2 / 36);
    }
  }
  const ElasticLayer<double> layer(
      eye, 0.03, {.poisson_ratio = 0.33, .thickness = inf, .friction = inf}, {.tolerance = 1e-3});
  LayerLoad load{.force = 0.003, .centre = Vec2<double>(-width, 0.3 * width)};
  load.shift = {0.45 * width, 0.1 * width};
  const auto pressed = layer.press(depth, load);
  CHECK(!pressed.converged);  // before it was given up it took 272,222 convolutions
  CHECK(pressed.convolutions < 20000);
}
