#include "gelight/membrane/elastic.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>

#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "gelight/membrane/spring_membrane.hpp"
#include "reference.hpp"
#include "support/approx.hpp"
#include "support/dented_depth.hpp"

using namespace gelight;

static_assert(MembraneModel<GaussianMembrane<float>, float> &&
              MembraneModel<SpringMembrane<float>, float> &&
              MembraneModel<PyramidMembrane<float>, float> &&
              MembraneModel<FlatGelSightMembrane<float>, float> &&
              MembraneModel<BulgingMembrane<float>, float> &&
              MembraneModel<ShadowedMembrane<float>, float>);

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
  CHECK(surface_depth(FlatGelSightMembrane<double>(), rest, rest) == rest);
  CHECK(surface_depth(PyramidMembrane<double>(std::array{11.0, 5.0, 2.0}), rest, rest) == rest);
}

TEST_CASE("Taxim's gel lies on the object and rises smoothly beside it") {
  const auto rest = flat(80, 70, 0.03);
  const auto contact = dent(80, 70, 0.002);
  const auto gel = surface_depth(PyramidMembrane<double>(std::array{6.0, 3.0, 1.0}), contact, rest);
  for (Index x = 0; x < 80; ++x) {
    if (contact(x, 35) < 0.03)
      CHECK(gel(x, 35) == gelight::test::approx(contact(x, 35)).epsilon(1e-15));
    if (x > 44) CHECK(gel(x, 35) >= gel(x - 1, 35));
    CHECK(gel(x, 35) <= 0.03);
  }
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
  const Image<double> rest(contact.width(), contact.height(), 0.03);
  CHECK(worst_difference(surface_depth(FlatGelSightMembrane<double>(), contact, rest), published) <
        1e-6);
}

TEST_CASE("the flat GelSight's membrane of an image without columns or rows has none") {
  for (const Index rows : {0, 3}) {
    const Image<double> none(0, rows), flat(rows, 0);
    CHECK(surface_depth(FlatGelSightMembrane<double>(), none, none) == none);
    CHECK(surface_depth(FlatGelSightMembrane<double>(), flat, flat) == flat);
  }
}
