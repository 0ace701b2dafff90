#include "gelight/membrane/shadowed.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "support/approx.hpp"
#include "support/refusal.hpp"

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
const Window whole{0, 0, 100, 80};

Image<double> shadow_of(const Image<double>& contact) {
  const ShadowedMembrane<double> membrane(camera, GaussianMembrane<double>());
  auto work = membrane.make_workspace(100, 80);
  return membrane.shadow_into(work, {contact, rest, whole});
}

}  // namespace

TEST_CASE("without contact nothing is dark and nothing hidden: no 0/0") {
  CHECK(shadow_of(rest) == Image<double>(100, 80));
  const Image<double> unknown(100, 80, std::numeric_limits<double>::quiet_NaN());
  CHECK(shadow_of(unknown) == Image<double>(100, 80));
}

TEST_CASE("a shadow lies within [0, 1], beside the contact and not on it") {
  const auto contact = square(75, 40, 0.004);
  const auto shadow = shadow_of(contact);
  double most = 0;
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) {
      CHECK(shadow(x, y) >= 0);
      CHECK(shadow(x, y) <= 1);
      most = std::max(most, shadow(x, y));
      const bool around = std::abs(x - 75) <= 8 && std::abs(y - 40) <= 8;
      if (around) CHECK(shadow(x, y) == 0);
    }
  }
  CHECK(most > 0.1);
  // To the right of the axis rays run to the right: the contact rises along them on its left side.
  CHECK(shadow(66, 40) > 2 * shadow(84, 40));
}

TEST_CASE("a contact and a camera mirrored left to right have a mirrored shadow") {
  const auto left = shadow_of(square(24, 30, 0.004));
  const auto right = shadow_of(square(99 - 24, 30, 0.004));
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) {
      CHECK(left(x, y) == gelight::test::approx(right(99 - x, y)).epsilon(1e-4));
    }
  }
}

TEST_CASE("the surface is the Gaussian's, but for what of the bulge lies in the shadow") {
  const auto contact = square(75, 40, 0.004);
  const GaussianMembrane<double> plain;
  const auto bulge = surface_depth(plain, contact, rest);
  const auto surface = surface_depth(ShadowedMembrane<double>(camera, plain), contact, rest);
  const auto shadow = shadow_of(contact);
  for (Index y = 0; y < 80; ++y) {
    for (Index x = 0; x < 100; ++x) {
      CHECK(0.03 - surface(x, y) == gelight::test::approx((1 - shadow(x, y)) * (0.03 - bulge(x, y)))
                                        .epsilon(1e-12)
                                        .scale(0.03));
      if (contact(x, y) < 0.03) CHECK(surface(x, y) == gelight::test::approx(contact(x, y)));
    }
  }
}

TEST_CASE("a gap of any size beyond the image's leaves no shadow") {
  const Camera<double> small{6, 6, 4, 3, 9, 7};
  const Image<double> sheet(9, 7, 0.03);
  Image<double> contact = sheet;
  contact(2, 3) = 0.026;
  const auto shadow_beyond = [&](Index gap) {
    const ShadowedMembrane<double> membrane(small, GaussianMembrane<double>(), {.gap = gap});
    auto work = membrane.make_workspace(9, 7);
    return membrane.shadow_into(work, {contact, sheet, Window{0, 0, 9, 7}});
  };
  CHECK(shadow_beyond(0) != Image<double>(9, 7));
  CHECK(shadow_beyond(1000) == Image<double>(9, 7));
  CHECK(shadow_beyond(std::numeric_limits<Index>::max()) == shadow_beyond(1000));
}

namespace {

// A corner of a few pixels pressed into a small image, and its shadow.
template <class T>
Image<T> shadow_of_corner(Index size, const ContactShadow& shadow) {
  const T middle = static_cast<T>(size - 1) / 2;
  const Camera<T> small{T(6), T(6), middle, middle, size, size};
  const Image<T> sheet(size, size, T(0.03));
  Image<T> contact = sheet;
  for (Index y = 0; y < 2; ++y) {
    for (Index x = 1; x < size - 1; ++x) contact(x, y) = T(0.028);
  }
  const ShadowedMembrane<T> membrane(small, GaussianMembrane<T>(), shadow);
  auto work = membrane.make_workspace(size, size);
  return membrane.shadow_into(work, {contact, sheet, Window{0, 0, size, size}});
}

}  // namespace

TEST_CASE("on an image smaller than its softening a shadow is the same in float and in double") {
  // What is left there of a wave as long as twice the image is its share exp(-(pi sigma / n)^2 /
  // 2), n = size - 1 pixels: less than float's rounding, and more than double's.
  for (const Index size : {4, 5, 6, 7}) {
    for (const double sigma : {5.0, 1.7 * (size - 1)}) {
      CAPTURE(size);
      CAPTURE(sigma);
      const ContactShadow shadow{.sigma = sigma, .radius = 60, .gap = 0};
      const auto single = shadow_of_corner<float>(size, shadow);
      const auto exact = shadow_of_corner<double>(size, shadow);
      double most = 0;
      for (std::size_t i = 0; i < exact.pixels().size(); ++i) {
        CHECK(std::abs(double{single.pixels()[i]} - exact.pixels()[i]) < 1e-6);
        most = std::max(most, exact.pixels()[i]);
      }
      CHECK(most > 0.1);
    }
  }
}

TEST_CASE("where softening leaves nothing but rounding of the marks, there is no shadow") {
  const ContactShadow even{.sigma = 40, .radius = 400, .gap = 0};
  CHECK(shadow_of_corner<float>(6, even) == Image<float>(6, 6));
  CHECK(shadow_of_corner<double>(6, even) == Image<double>(6, 6));
}

TEST_CASE("input that cannot be used is refused") {
  const GaussianMembrane<double> plain;
  const auto make = [&](const ContactShadow& shadow) {
    (void)ShadowedMembrane<double>(camera, plain, shadow);
  };
  CHECK_THROWS_AS(make({.sigma = -1}), InvalidInput);
  CHECK_THROWS_AS(make({.radius = -1}), InvalidInput);
  CHECK_THROWS_AS(make({.gap = -1}), InvalidInput);
  CHECK_THROWS_AS(make({.contact = std::numeric_limits<double>::infinity()}), InvalidInput);
  CHECK_THROWS_AS((void)surface_depth(plain, Image<double>(3, 3), rest), InvalidInput);
  const Image<double> small(8, 8, 0.03);
  const ShadowedMembrane<double> shadowed(camera, plain);
  CHECK(test::refusal([&] { (void)surface_depth(shadowed, small, small); }) ==
        "images of 8 x 8 pixels are not of the membrane's 100 x 80");
}
