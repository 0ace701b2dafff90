#include "gelight/image/filter.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "reference.hpp"
#include "support/approx.hpp"

using namespace gelight;

namespace {

constexpr std::array borders{Border::reflect101, Border::reflect, Border::replicate, Border::zero,
                             Border::normalised};

template <class T = double>
Image<T> noise(Index width, Index height, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<T> uniform(-1, 1);
  Image<T> image(width, height);
  for (T& pixel : image.pixels()) pixel = uniform(random);
  return image;
}

double sum(const Image<double>& image) {
  return std::accumulate(image.pixels().begin(), image.pixels().end(), 0.0);
}

std::string seen_beyond(Border border, const std::string& pixels) {
  std::string seen;
  const Index size = static_cast<Index>(pixels.size());
  for (Index i = -5; i < size + 5; ++i) {
    const Index from = detail::inside(i, size, border);
    seen += from < 0 ? '0' : pixels[static_cast<std::size_t>(from)];
  }
  return seen;
}

}  // namespace

TEST_CASE("what lies beyond the border") {
  CHECK(seen_beyond(Border::reflect101, "abcd") == "bcdcbabcdcbabc");
  CHECK(seen_beyond(Border::reflect, "abcd") == "ddcbaabcddcbaa");
  CHECK(seen_beyond(Border::replicate, "abcd") == "aaaaaabcdddddd");
  CHECK(seen_beyond(Border::zero, "abcd") == "00000abcd00000");
  CHECK(seen_beyond(Border::reflect101, "a") == "aaaaaaaaaaa");
  CHECK(seen_beyond(Border::reflect, "a") == "aaaaaaaaaaa");
}

TEST_CASE("a pulse becomes the Gaussian, cut off and scaled to sum 1") {
  Image<double> pulse(21, 21);
  pulse(10, 10) = 1;
  const auto image = gaussian(pulse, 1.7, 6);
  double total = 0;
  for (Index k = -6; k <= 6; ++k) total += std::exp(-k * k / (2 * 1.7 * 1.7));
  for (Index y = 0; y < 21; ++y) {
    for (Index x = 0; x < 21; ++x) {
      const double dx = x - 10, dy = y - 10;
      const bool in_reach = std::abs(dx) <= 6 && std::abs(dy) <= 6;
      const double want =
          in_reach ? std::exp(-(dx * dx + dy * dy) / (2 * 1.7 * 1.7)) / (total * total) : 0;
      CHECK(image(x, y) == gelight::test::approx(want).epsilon(1e-13));
    }
  }
}

TEST_CASE("cosines that fit the border are only scaled, by the kernel's transform") {
  const Index n = 37, radius = 11;
  const double sigma = 3.2;
  const auto weights = gaussian_weights<double>(sigma, radius);
  for (const bool edge_repeated : {false, true}) {
    for (const int frequency : {1, 4, 9}) {
      const double step = std::numbers::pi * frequency / (edge_repeated ? n : n - 1);
      const double shift = edge_repeated ? 0.5 : 0;
      double scale = weights[0];
      for (Index k = 1; k <= radius; ++k) {
        scale += 2 * weights[static_cast<std::size_t>(k)] * std::cos(step * k);
      }
      Image<double> wave(n, 5);
      for (Index y = 0; y < 5; ++y) {
        for (Index x = 0; x < n; ++x) wave(x, y) = std::cos(step * (x + shift));
      }
      const auto border = edge_repeated ? Border::reflect : Border::reflect101;
      const auto image = gaussian(wave, sigma, radius, border);
      for (Index x = 0; x < n; ++x) {
        CHECK(image(x, 2) == gelight::test::approx(scale * wave(x, 2)).epsilon(1e-12).scale(1));
      }
    }
  }
}

TEST_CASE("a constant stays constant, where the border rule has no zeros") {
  for (const Border border : borders) {
    const auto image = gaussian(Image<double>(9, 6, 2.5), 4.0, 16, border);
    if (border == Border::zero) continue;
    for (const double pixel : image.pixels())
      CHECK(pixel == gelight::test::approx(2.5).epsilon(1e-14));
  }
}

TEST_CASE("a normalised border: the mean of the pixels that are there, by their weights") {
  const Index w = 11, h = 7, radius = 9;
  const double sigma = 3;
  const auto image = noise(w, h);
  const auto smooth = gaussian(image, sigma, radius, Border::normalised);
  for (Index y = 0; y < h; ++y) {
    for (Index x = 0; x < w; ++x) {
      double total = 0, weights = 0;
      for (Index v = std::max(Index{0}, y - radius); v <= std::min(h - 1, y + radius); ++v) {
        for (Index u = std::max(Index{0}, x - radius); u <= std::min(w - 1, x + radius); ++u) {
          const double r2 = (u - x) * (u - x) + (v - y) * (v - y);
          const double weight = std::exp(-r2 / (2 * sigma * sigma));
          total += weight * image(u, v);
          weights += weight;
        }
      }
      CHECK(smooth(x, y) == gelight::test::approx(total / weights).epsilon(1e-12));
    }
  }
  CHECK_THROWS_AS((void)sobel(image, Border::normalised), InvalidInput);
}

TEST_CASE("the sum is kept where the edge is repeated, and with zeros far from the edge") {
  const auto image = noise(23, 17);
  CHECK(sum(gaussian(image, 2.0, 8, Border::reflect)) ==
        gelight::test::approx(sum(image)).epsilon(1e-12));
  Image<double> dot(31, 31);
  dot(15, 15) = 3;
  CHECK(sum(gaussian(dot, 2.0, 8, Border::zero)) == gelight::test::approx(3).epsilon(1e-14));
}

TEST_CASE("sigma from nothing to far more than the image") {
  const auto image = noise(12, 7);
  CHECK(gaussian(image, 0) == image);
  CHECK(gaussian(image, 0, 5) == image);
  CHECK(gaussian(image, 1e-300, 5) == image);
  CHECK(gaussian(image, 1e-3) == image);  // exp(-500000) is 0
  const double mean = sum(image) / 84;
  const auto flat = gaussian(image, 1e6);
  for (const double pixel : flat.pixels()) CHECK(std::abs(pixel - mean) < 0.1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS((void)gaussian(image, -1), "sigma -1 is negative or not finite",
                       InvalidInput);
  CHECK_THROWS_WITH_AS((void)gaussian(image, nan), "sigma nan is negative or not finite",
                       InvalidInput);
  CHECK_THROWS_AS((void)gaussian(image, std::numeric_limits<double>::infinity()), InvalidInput);
  CHECK_THROWS_WITH_AS((void)gaussian(image, 1, -2), "radius -2 is negative", InvalidInput);
  CHECK_THROWS_WITH_AS((void)gaussian(image, 1, std::numeric_limits<Index>::max()),
                       "radius 2147483647 is beyond 2^26 pixels", InvalidInput);
}

TEST_CASE("images of one pixel, one row, one column and none") {
  for (const Border border : {Border::reflect101, Border::reflect, Border::replicate}) {
    CHECK(gaussian(Image<double>(1, 1, 4.0), 2, 8, border)(0, 0) == gelight::test::approx(4));
    const auto row = noise(9, 1), column = noise(1, 9);
    const auto smooth_row = gaussian(row, 1.5, 6, border);
    const auto smooth_column = gaussian(column, 1.5, 6, border);
    for (Index i = 0; i < 9; ++i) {
      CHECK(smooth_row(i, 0) == gelight::test::approx(smooth_column(0, i)).epsilon(1e-14));
    }
    CHECK(gaussian(Image<double>(), 2, 8, border).width() == 0);
    CHECK(gaussian(Image<double>(0, 3), 2, 8, border).height() == 3);
  }
}

TEST_CASE("padded, mirrored and transposed views give what their packed copies give, bit for bit") {
  const auto image = noise<float>(24, 20);
  const ImageView<const float> part(image.data() + 3, 17, 11, 24);
  const ImageView<const float> mirrored(image.row(19) + 23, 24, 20, -24, -1);
  for (const auto& view : {part, mirrored, part.transposed()}) {
    Image<float> packed(view.width(), view.height());
    for (Index y = 0; y < view.height(); ++y) {
      for (Index x = 0; x < view.width(); ++x) packed(x, y) = view(x, y);
    }
    CHECK(gaussian(view, 2.5) == gaussian(packed, 2.5));
    CHECK(resize_bilinear(view, 31, 7) == resize_bilinear(packed, 31, 7));
    CHECK(sobel(view).x == sobel(packed).x);
    CHECK(sobel(view).y == sobel(packed).y);
  }
}

TEST_CASE("vectors are smoothed coefficient by coefficient") {
  const auto image = noise(13, 8);
  Image<Vec3<double>> vectors(13, 8);
  for (Index y = 0; y < 8; ++y) {
    for (Index x = 0; x < 13; ++x) vectors(x, y) = {image(x, y), 1, -2 * image(x, y)};
  }
  const auto smooth = gaussian(image, 1.5);
  const auto smooth_vectors = gaussian(vectors, 1.5);
  for (Index y = 0; y < 8; ++y) {
    for (Index x = 0; x < 13; ++x) {
      CHECK(smooth_vectors(x, y).x() == smooth(x, y));
      CHECK(smooth_vectors(x, y).z() == gelight::test::approx(-2 * smooth(x, y)).epsilon(1e-13));
    }
  }
}

TEST_CASE("resizing keeps a plane between the outermost pixel centres") {
  Image<double> plane(16, 12);
  for (Index y = 0; y < 12; ++y) {
    for (Index x = 0; x < 16; ++x) plane(x, y) = 3 + 0.5 * x - 0.25 * y;
  }
  for (const auto& [width, height] : {std::array{64, 48}, std::array{16, 12}, std::array{5, 7}}) {
    const auto image = resize_bilinear(plane, width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double u = std::clamp((x + 0.5) * 16 / width - 0.5, 0.0, 15.0);
        const double v = std::clamp((y + 0.5) * 12 / height - 0.5, 0.0, 11.0);
        CHECK(image(x, y) == gelight::test::approx(3 + 0.5 * u - 0.25 * v).epsilon(1e-14));
      }
    }
  }
  CHECK(resize_bilinear(plane, 16, 12) == plane);

  // What is no number stays where it is.
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Image<float> depth(4, 3, 1.0F);
  depth(2, 1) = depth(3, 1) = depth(3, 2) = inf;
  depth(0, 1) = nan;
  const auto same = resize_bilinear(depth, 4, 3);
  for (Index y = 0; y < 3; ++y) {
    for (Index x = 0; x < 4; ++x) {
      CHECK(std::isnan(same(x, y)) == std::isnan(depth(x, y)));
      if (!std::isnan(depth(x, y))) CHECK(same(x, y) == depth(x, y));
    }
  }
  CHECK(resize_bilinear(Image<double>(1, 1, 2.0), 3, 2)(2, 1) == 2);
  CHECK(resize_bilinear(plane, 0, 5).height() == 5);
  CHECK_THROWS_AS((void)resize_bilinear(Image<double>(), 2, 2), InvalidInput);
  CHECK_THROWS_AS((void)resize_bilinear(plane, -1, 2), InvalidInput);
}

TEST_CASE("Sobel derivatives of a plane are eight times its slopes; an even border has none") {
  Image<double> plane(6, 5);
  for (Index y = 0; y < 5; ++y) {
    for (Index x = 0; x < 6; ++x) plane(x, y) = 0.5 * x - 2 * y;
  }
  const auto slope = sobel(plane);
  CHECK(slope.x(3, 2) == 4);
  CHECK(slope.y(3, 2) == -16);
  CHECK(slope.x(0, 2) == 0);
  CHECK(slope.y(3, 4) == 0);
  const auto one_sided = sobel(plane, Border::replicate);
  CHECK(one_sided.x(0, 2) == 2);
  CHECK(one_sided.y(3, 0) == -8);
}

TEST_CASE("the published light field of LED 1, smoothed and resized") {
  if (reference::is_absent()) return;
  const auto published = reference::stage<Vec3<float>>("field_geodesic_led1_640x480");
  const auto field = reference::field<double>("geodesic", 1);
  double worst = 0;
  for (Index y = 0; y < 480; ++y) {
    for (Index x = 0; x < 640; ++x) {
      worst = std::max(worst, (field(x, y) - published(x, y).cast<double>()).cwiseAbs().maxCoeff());
    }
  }
  CHECK(worst < 6e-8);  // values up to 1, stored as floats
}
