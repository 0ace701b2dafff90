#include "gelight/sensor/tactile_renderer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "reference.hpp"

using namespace gelight;

namespace {

struct Difference {
  int worst = 0, worst_inside = 0, pixels = 0;
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
      const bool rim = x == 0 || y == 0 || x == image.width() - 1 || y == image.height() - 1;
      d.worst = std::max(d.worst, off);
      if (!rim) d.worst_inside = std::max(d.worst_inside, off);
      d.pixels += off > 0;
    }
  }
  return d;
}

const std::array<std::string, 4> methods{"linear", "plane", "geodesic", "transport"};

}  // namespace

TEST_CASE("the published images: float is within a grey level of them off the border") {
  if (reference::is_absent()) return;
  for (const auto& method : methods) {
    const TactileRenderer renderer(reference::camera<float>(), reference::depth("rest"),
                                   reference::lights<float>(method), reference::background(),
                                   TactileOptions::as_published(method != "linear"));
    const auto published = read_png(reference::path("geltip/image/expected_" + method + ".png"));
    for (Index k = 0; k < 6; ++k) {
      const auto image = renderer.render(reference::depth("contact_" + std::to_string(k)));
      CHECK(compare(image, published, k).worst_inside <= 1);
    }
  }
}

TEST_CASE("the published images: double differs in at most 20 pixels of 307,200, by 1") {
  if (reference::is_absent()) return;
  for (const auto& method : methods) {
    const TactileRenderer renderer(reference::camera<double>(), reference::depth("rest"),
                                   reference::lights<double>(method), reference::background(),
                                   TactileOptions::as_published(method != "linear"));
    const auto published = read_png(reference::path("geltip/image/expected_" + method + ".png"));
    for (Index k = 0; k < 6; ++k) {
      const auto image = renderer.render(reference::depth("contact_" + std::to_string(k)));
      const Difference d = compare(image, published, k);
      CHECK(d.worst <= 1);
      CHECK(d.pixels <= 20);
    }
  }
}

TEST_CASE("the published images: the gated specular term and clipping move them by one level") {
  if (reference::is_absent()) return;
  for (const auto& method : methods) {
    const TactileRenderer renderer(reference::camera<double>(), reference::depth("rest"),
                                   reference::lights<double>(method), reference::background(),
                                   TactileOptions{.rectify = method != "linear"});
    const auto published = read_png(reference::path("geltip/image/expected_" + method + ".png"));
    for (Index k = 0; k < 6; ++k) {
      const auto image = renderer.render(reference::depth("contact_" + std::to_string(k)));
      CHECK(compare(image, published, k).worst <= 1);
    }
  }
}
