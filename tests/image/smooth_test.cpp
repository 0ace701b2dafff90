#include "gelight/image/smooth.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "reference.hpp"

using namespace gelight;

namespace {

Image<double> flat(Index width, Index height, double depth) { return {width, height, depth}; }

Image<double> dent(Index width, Index height, double depth) {
  Image<double> contact = flat(width, height, 0.03);
  for (Index y = height / 2 - 3; y <= height / 2 + 3; ++y) {
    for (Index x = width / 2 - 3; x <= width / 2 + 3; ++x) contact(x, y) -= depth;
  }
  return contact;
}

double worst_difference(const auto& a, const auto& b) {
  double worst = 0;
  for (Index y = 0; y < a.height(); ++y) {
    for (Index x = 0; x < a.width(); ++x) {
      worst = std::max(worst, std::abs(double{a(x, y)} - double{b(x, y)}));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("correlation shifts by the anchor, and is the Gaussian with its weights") {
  Image<double> pulse(9, 7);
  pulse(4, 3) = 1;
  const std::array<double, 4> kernel{1, 2, 3, 4};
  const auto image = correlate<double>(pulse, kernel, 1);
  for (Index j = 0; j < 4; ++j) {
    CHECK(image(4 - (j - 1), 3) == 2 * kernel[static_cast<std::size_t>(j)]);
  }
  const auto half = gaussian_weights<double>(1.5, 3);
  const std::array<double, 7> whole{half[3], half[2], half[1], half[0], half[1], half[2], half[3]};
  for (const Border border :
       {Border::reflect101, Border::reflect, Border::replicate, Border::zero}) {
    CHECK(worst_difference(correlate<double>(dent(20, 20, 1), whole, 3, border),
                           gaussian(dent(20, 20, 1), 1.5, 3, border)) < 1e-15);
  }
  CHECK_THROWS_AS((void)correlate<double>(pulse, kernel, 4), InvalidInput);
}

TEST_CASE("an elastic membrane: at rest without contact, on the object, never above rest") {
  const auto rest = flat(60, 50, 0.03);
  CHECK(elastic_depth(rest, rest) == rest);
  CHECK(elastic_depth(flat(60, 50, 5.0), rest) == rest);
  const auto contact = dent(60, 50, 0.004);
  const auto membrane = elastic_depth(contact, rest);
  for (Index y = 0; y < 50; ++y) {
    for (Index x = 0; x < 60; ++x) {
      CHECK(membrane(x, y) <= contact(x, y));
      if (contact(x, y) < 0.03) CHECK(membrane(x, y) == contact(x, y));
    }
  }
  CHECK(membrane(30, 32) < 0.03);
  CHECK(elastic_depth(contact, rest, 0) == contact);
  CHECK_THROWS_WITH_AS((void)elastic_depth(flat(3, 2, 1), rest),
                       "the depth image is 3 x 2 pixels, the rest depth image 60 x 50",
                       InvalidInput);
}

TEST_CASE("models without contact stay at rest: no 0/0") {
  const auto rest = flat(70, 60, 0.03);
  CHECK(gelsight_flat_depth(rest) == rest);
  CHECK(taxim_depth(rest, rest, std::array{11.0, 5.0, 2.0}) == rest);
}

TEST_CASE("Taxim's gel lies on the object and rises smoothly beside it") {
  const auto rest = flat(80, 70, 0.03);
  const auto contact = dent(80, 70, 0.002);
  const auto gel = taxim_depth(contact, rest, std::array{6.0, 3.0, 1.0});
  for (Index x = 0; x < 80; ++x) {
    if (contact(x, 35) < 0.03) CHECK(gel(x, 35) == doctest::Approx(contact(x, 35)).epsilon(1e-15));
    if (x > 44) CHECK(gel(x, 35) >= gel(x - 1, 35));
    CHECK(gel(x, 35) <= 0.03);
  }
}

TEST_CASE("a mean of the known pixels: a plane's even part stays, unknown pixels stay unknown") {
  Image<double> image(30, 20, 2.5);
  std::mt19937 random(5);
  for (int i = 0; i < 150; ++i) {
    image(static_cast<Index>(random() % 30), static_cast<Index>(random() % 20)) =
        i % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                   : std::numeric_limits<double>::infinity();
  }
  const auto mean = gaussian_of_known(image, 2, 8);
  for (Index y = 0; y < 20; ++y) {
    for (Index x = 0; x < 30; ++x) {
      CHECK(std::isnan(mean(x, y)) == !std::isfinite(image(x, y)));
      if (std::isfinite(image(x, y))) CHECK(mean(x, y) == doctest::Approx(2.5).epsilon(1e-12));
    }
  }
  const auto whole = dent(30, 20, 0.01);
  CHECK(gaussian_of_known(whole, 2, 8) == gaussian(whole, 2, 8));
  auto holed = whole;
  holed(3, 3) = std::numeric_limits<double>::quiet_NaN();
  const auto smooth = gaussian(whole, 2, 5), around = gaussian_of_known(holed, 2, 5);
  for (Index y = 0; y < 20; ++y) {
    for (Index x = 0; x < 30; ++x) {
      if (x > 8 || y > 8) CHECK(around(x, y) == smooth(x, y));
    }
  }
  const auto lost =
      gaussian_of_known(Image<double>(4, 4, std::numeric_limits<double>::quiet_NaN()), 1, 4);
  for (const double pixel : lost.pixels()) CHECK(std::isnan(pixel));
}

TEST_CASE("the published membrane of contact 2") {
  if (reference::is_absent()) return;
  const auto published = reference::stage<float>("deformed_depth_contact_2");
  Image<double> rest(640, 480);
  const auto narrow = reference::depth("rest");
  std::copy(narrow.pixels().begin(), narrow.pixels().end(), rest.pixels().begin());
  const auto membrane = elastic_depth(reference::depth("contact_2"), rest);
  // Depths of 45 mm stored as floats; clipping moves the noise above rest, 1.3e-6 at most.
  CHECK(worst_difference(membrane, published) < 1.4e-6);
}

TEST_CASE("the published membrane of the flat GelSight") {
  if (reference::is_absent()) return;
  const auto contact = read_npy<float>(reference::path("gelsight_flat/contact_depth.npy"));
  const auto published = read_npy<float>(reference::path("gelsight_flat/membrane_depth.npy"));
  CHECK(worst_difference(gelsight_flat_depth(contact), published) < 1e-6);
}
