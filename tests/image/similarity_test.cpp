#include "gelight/image/similarity.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/approx.hpp"

using namespace gelight;

namespace {

Image<Rgb8> texture(Index width = 40, Index height = 30) {
  Image<Rgb8> image(width, height);
  std::mt19937 random(4);
  for (Rgb8& p : image.pixels()) {
    for (auto& c : p) c = static_cast<std::uint8_t>(60 + random() % 100);
  }
  return image;
}

Image<Rgb8> brighter(Image<Rgb8> image, int by) {
  for (Rgb8& p : image.pixels()) {
    for (auto& c : p) c = static_cast<std::uint8_t>(c + by);
  }
  return image;
}

}  // namespace

TEST_CASE("equal images") {
  const auto image = texture();
  CHECK(level_difference(image, image).worst == 0);
  CHECK(level_difference(image, image).beyond(0) == 0);
  CHECK(level_difference(image, image).beyond(-1) == 40 * 30);
  CHECK(level_difference(image, image).beyond(std::numeric_limits<int>::min()) == 40 * 30);
  CHECK(level_difference(image, image).beyond(std::numeric_limits<int>::max()) == 0);
  CHECK(psnr(image, image) == std::numeric_limits<double>::infinity());
  CHECK(ssim(image, image) == gelight::test::approx(1).epsilon(1e-12));
}

TEST_CASE("levels and decibels of a known difference") {
  const auto image = texture();
  auto other = brighter(image, 5);
  const auto even = level_difference(image, other);
  CHECK(even.worst == 5);
  CHECK(even.mean == gelight::test::approx(5));
  CHECK(even.pixels[5] == 1200);
  CHECK(even.beyond(4) == 1200);
  CHECK(even.beyond(5) == 0);
  CHECK(psnr(image, other) == gelight::test::approx(20 * std::log10(255.0 / 5)).epsilon(1e-12));
  other = image;
  other(3, 3)[1] = static_cast<std::uint8_t>(other(3, 3)[1] + 30);
  CHECK(level_difference(image, other).beyond(0) == 1);
  CHECK(psnr(image, other) ==
        gelight::test::approx(10 * std::log10(255.0 * 255 * 3600 / 900)).epsilon(1e-12));
}

TEST_CASE("structural similarity of flat images is that of their brightness") {
  const Image<Rgb8> dark(20, 20, {50, 50, 50}), light(20, 20, {100, 100, 100});
  const double c1 = 2.55 * 2.55;
  const double want = (2 * 50.0 * 100 + c1) / (50.0 * 50 + 100.0 * 100 + c1);
  CHECK(ssim(dark, light) == gelight::test::approx(want).epsilon(1e-9));
  CHECK(ssim(texture(), brighter(texture(), 2)) > 0.99);
  auto negative = texture();
  for (Rgb8& p : negative.pixels()) {
    for (auto& c : p) c = static_cast<std::uint8_t>(220 - c);
  }
  CHECK(ssim(texture(), negative) < 0);
  CHECK(ssim(texture(), negative) ==
        gelight::test::approx(ssim(negative, texture())).epsilon(1e-12));
}

TEST_CASE("different sizes and empty images are refused") {
  CHECK_THROWS_WITH_AS((void)psnr(texture(), texture(40, 29)),
                       "one image is 40 x 30 pixels, the other 40 x 29", InvalidInput);
  CHECK_THROWS_AS((void)ssim(texture(), texture(39, 30)), InvalidInput);
  CHECK_THROWS_AS((void)level_difference(texture(), texture(39, 30)), InvalidInput);
  CHECK_THROWS_AS((void)ssim(Image<Rgb8>(), Image<Rgb8>()), InvalidInput);
}
