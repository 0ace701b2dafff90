#include "gelight/membrane/tension.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/refusal.hpp"

using namespace gelight;

namespace {

template <class T>
Image<T> surface_of(const Image<T>& depth, const Image<T>& rest, double length) {
  const TensionMembrane<T> membrane(length);
  auto work = membrane.make_workspace(rest.width(), rest.height());
  Image<T> surface(rest.width(), rest.height());
  membrane.press_into(surface, {depth, rest, {0, 0, rest.width(), rest.height()}}, work);
  return surface;
}

}  // namespace

TEST_CASE("about a ball the slope goes on and decays as K1, and the contact is the known circle") {
  const double ball = 40, contact = 22;
  for (const double length : {5.0, 12.0}) {
    const double k1 = std::cyl_bessel_k(1.0, contact / length);
    const double rim_slope = contact / std::sqrt(ball * ball - contact * contact);
    const double rim = rim_slope * length * std::cyl_bessel_k(0.0, contact / length) / k1;
    const double deep = ball - std::sqrt(ball * ball - contact * contact) + rim;
    Image<double> depth(161, 161, std::numeric_limits<double>::infinity()), rest(161, 161, 100);
    for (Index y = 0; y < 161; ++y) {
      for (Index x = 0; x < 161; ++x) {
        const double left = ball * ball - (x - 80.0) * (x - 80) - (y - 80.0) * (y - 80);
        if (left > 0) depth(x, y) = 100 - (deep - ball + std::sqrt(left));
      }
    }
    const auto surface = surface_of(depth, rest, length);
    double worst = 0;
    for (Index x = 80; x < 160; ++x) {
      const double r = x - 80.0, w = 100 - surface(x, 80);
      if (r > contact + 1) {
        const double truth =
            rim * std::cyl_bessel_k(0.0, r / length) / std::cyl_bessel_k(0.0, contact / length);
        worst = std::max(worst, std::abs(w - truth));
      }
      if (r < contact - 1.5) CHECK(surface(x, 80) == depth(x, 80));
      if (r > contact + 1.5) CHECK(surface(x, 80) < rest(x, 80));
    }
    CAPTURE(length);
    CHECK(worst < 0.02 * rim);  // pixels are a fifth of the shorter length
  }
}

// Of a long bulge that an image cuts: the slope, which light goes by, is that of gel that goes on.
TEST_CASE("the image's border does not show in the bulge") {
  const double ball = 40, contact = 22, length = 30;
  const double rim_slope = contact / std::sqrt(ball * ball - contact * contact);
  const double k1 = std::cyl_bessel_k(1.0, contact / length);
  const double rim = rim_slope * length * std::cyl_bessel_k(0.0, contact / length) / k1;
  const double deep = ball - std::sqrt(ball * ball - contact * contact) + rim;
  const double cx = 45, cy = 60;
  Image<double> depth(121, 141, std::numeric_limits<double>::infinity()), rest(121, 141, 100);
  for (Index y = 0; y < 141; ++y) {
    for (Index x = 0; x < 121; ++x) {
      const double left = ball * ball - (x - cx) * (x - cx) - (y - cy) * (y - cy);
      if (left > 0) depth(x, y) = 100 - (deep - ball + std::sqrt(left));
    }
  }
  const auto surface = surface_of(depth, rest, length);
  double mean = 0, count = 0, worst = 0;
  for (Index y = 1; y < 140; ++y) {
    for (Index x = 1; x < 120; ++x) {
      const double r = std::hypot(x - cx, y - cy);
      if (r < contact + 2) continue;
      const double truth = rim_slope * std::cyl_bessel_k(1.0, r / length) / k1;
      const Vec2<double> slope((surface(x + 1, y) - surface(x - 1, y)) / 2,
                               (surface(x, y + 1) - surface(x, y - 1)) / 2);
      const double off = (slope - truth / r * Vec2<double>(x - cx, y - cy)).norm() / rim_slope;
      mean += off;
      worst = std::max(worst, off);
      ++count;
    }
  }
  MESSAGE("slopes off by " << mean / count << " of the rim's, at most " << worst);
  CHECK(mean / count < 0.015);
  CHECK(worst < 0.1);
}

TEST_CASE("objects are not gone through, nothing stays at rest, and any window is the same") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> high(-3, 2);
  Image<float> depth(61, 47, std::numeric_limits<float>::infinity()), rest(61, 47, 50);
  CHECK(surface_of(depth, rest, 6) == rest);
  for (Index y = 15; y < 30; ++y) {
    for (Index x = 20; x < 40; ++x) depth(x, y) = 50 + high(random);
  }
  depth(5, 5) = std::numeric_limits<float>::quiet_NaN();
  const auto whole = surface_of(depth, rest, 6);
  for (std::size_t i = 0; i < whole.pixels().size(); ++i) {
    CHECK(whole.pixels()[i] <= rest.pixels()[i]);
    if (depth.pixels()[i] > 0) CHECK(whole.pixels()[i] <= depth.pixels()[i]);
  }
  const TensionMembrane<float> membrane(6);
  auto work = membrane.make_workspace(61, 47);
  Image<float> part(61, 47, 7);
  membrane.press_into(part, {depth, rest, {10, 12, 33, 40}}, work);
  for (Index y = 0; y < 47; ++y) {
    for (Index x = 0; x < 61; ++x) {
      const bool is_asked = x >= 10 && x < 33 && y >= 12 && y < 40;
      CHECK(part(x, y) == (is_asked ? whole(x, y) : 7));
    }
  }
}

TEST_CASE("a length that cannot be is refused") {
  for (const double length : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(gelight::test::contains(
        gelight::test::refusal([&] { (void)TensionMembrane<float>(length); }), "tension length"));
  }
}
