// Whole frames against those that the authors of the GelTip paper published: six objects under each
// of four light fields. What each file holds is told in the reference data's README.

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdlib>
#include <string>

#include "gelight/sensor/tactile_renderer.hpp"
#include "reference.hpp"

using namespace gelight;

namespace {

struct Difference {
  int worst = 0;         // grey levels, of all pixels and channels
  int worst_inside = 0;  // of the pixels off the image's border
  int pixels = 0;        // that differ
};

// Against frame `k` of a strip of six.
Difference compare(const Image<Rgb8>& image, const Image<Rgb8>& strip, Index k) {
  Difference d;
  for (Index y = 0; y < image.height(); ++y) {
    for (Index x = 0; x < image.width(); ++x) {
      int off = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        off = std::max(off, std::abs(image(x, y)[c] - strip(k * image.width() + x, y)[c]));
      }
      const bool is_rim = x == 0 || y == 0 || x == image.width() - 1 || y == image.height() - 1;
      d.worst = std::max(d.worst, off);
      if (!is_rim) d.worst_inside = std::max(d.worst_inside, off);
      d.pixels += off > 0;
    }
  }
  return d;
}

// The largest differences of the 24 published images, rendered with options that depend on whether
// the light is to be laid into the membrane.
template <std::floating_point T>
Difference worst_of_published(auto&& options) {
  Difference worst;
  for (const std::string method : {"linear", "plane", "geodesic", "transport"}) {
    const TactileRenderer renderer(reference::camera<T>(), reference::depth("rest"),
                                   reference::lights<T>(method), reference::background(),
                                   options(method != "linear"));
    const auto published = read_png(reference::path("geltip/image/expected_" + method + ".png"));
    for (Index k = 0; k < 6; ++k) {
      const auto image = renderer.render(reference::depth("contact_" + std::to_string(k)));
      const Difference d = compare(image, published, k);
      worst = {std::max(worst.worst, d.worst), std::max(worst.worst_inside, d.worst_inside),
               std::max(worst.pixels, d.pixels)};
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the published images: float is within a grey level of them off the border") {
  if (reference::is_absent()) return;
  CHECK(worst_of_published<float>(TactileOptions::as_published).worst_inside <= 1);
}

TEST_CASE("the published images: double differs in at most 20 pixels of 307,200, by 1") {
  if (reference::is_absent()) return;
  const Difference d = worst_of_published<double>(TactileOptions::as_published);
  CHECK(d.worst <= 1);
  CHECK(d.pixels <= 20);
}

TEST_CASE("the published images: the gated specular term and clipping move them by one level") {
  if (reference::is_absent()) return;
  const auto options = [](bool rectify) { return TactileOptions{.rectify = rectify}; };
  CHECK(worst_of_published<double>(options).worst <= 1);
}

TEST_CASE("the authors' tangent light lights nothing at rest, however strong its gloss") {
  if (reference::is_absent()) return;
  const TactileRenderer unlit(reference::camera<float>(), reference::depth("rest"),
                              std::vector<Light<float>>{}, reference::background());
  for (const std::string method : {"plane", "geodesic", "transport"}) {
    auto lights = reference::lights<float>(method);
    for (auto& light : lights) {
      light.specular = 0.5f;
      light.shininess = 5;
    }
    const TactileRenderer renderer(reference::camera<float>(), reference::depth("rest"), lights,
                                   reference::background(), TactileOptions{.rectify = true});
    CHECK(renderer.rest_image() == unlit.rest_image());
  }
}
