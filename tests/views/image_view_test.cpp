#include "gelight/views/image_view.hpp"

#include <doctest/doctest.h>

#include <array>
#include <string>
#include <vector>

#include "support/refusal.hpp"

using namespace gelight;
using test::refusal;

namespace {

Image<int> numbered(Index width, Index height) {
  Image<int> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) image(x, y) = 100 * y + x;
  }
  return image;
}

}  // namespace

TEST_CASE("strides of any sign and size reach the pixels they should") {
  Image<int> image = numbered(5, 4);
  const ImageView<int> packed(image.data(), 5, 4);
  const ImageView<int> upside_down(image.row(3), 5, 4, -5);
  const ImageView<int> mirrored(image.data() + 4, 5, 4, 5, -1);
  const ImageView<int> transposed = packed.transposed();
  const ImageView<int> even(image.data(), 3, 2, 10, 2);
  for (Index y = 0; y < 4; ++y) {
    for (Index x = 0; x < 5; ++x) {
      CHECK(packed(x, y) == image(x, y));
      CHECK(upside_down(x, y) == image(x, 3 - y));
      CHECK(mirrored(x, y) == image(4 - x, y));
      CHECK(transposed(y, x) == image(x, y));
    }
  }
  CHECK(even(2, 1) == image(4, 2));
  CHECK(transposed.width() == 4);
  CHECK(transposed.height() == 5);
}

TEST_CASE("one plane of interleaved pixels, rows padded by any number of bytes") {
  std::vector<std::uint8_t> bytes(2 * 11);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  const auto green = ImageView<const std::uint8_t>::from_bytes(bytes.data() + 1, 3, 2, 11, 3);
  CHECK(green(0, 0) == 1);
  CHECK(green(2, 1) == 11 + 7);
  CHECK_FALSE(green.rows_are_packed());
  const auto rgb = ImageView<Rgb8>::from_bytes(reinterpret_cast<Rgb8*>(bytes.data()), 3, 2, 11);
  CHECK(rgb(2, 1) == Rgb8{17, 18, 19});
  CHECK(rgb.rows_are_packed());
}

TEST_CASE("a view writes through, and gives a view that cannot") {
  Image<int> image(2, 2);
  const ImageView<int> view = image;
  view(1, 0) = 7;
  const ImageView<const int> constant = view;
  CHECK(constant(1, 0) == 7);
  CHECK(image(1, 0) == 7);
  static_assert(!std::is_convertible_v<ImageView<const int>, ImageView<int>>);
  static_assert(!std::is_convertible_v<const Image<int>&, ImageView<int>>);
}

TEST_CASE("images without pixels") {
  const Image<float> none;
  CHECK(none.width() == 0);
  CHECK(Image<float>(0, 7).height() == 7);
  CHECK(Image<float>(0, 7).pixels().empty());
  CHECK(ImageView<float>(nullptr, 0, 3).height() == 3);
  CHECK(ImageView<float>().width() == 0);
}

TEST_CASE("vectors start as zeros") {
  CHECK(Image<Vec3<float>>(2, 2)(1, 1) == Vec3<float>::Zero());
}

TEST_CASE("sizes that cannot be are refused") {
  float pixel = 0;
  CHECK(refusal([] { Image<float>(-1, 2); }) == "image size -1 x 2 is negative");
  CHECK(refusal([&] { ImageView<float>(&pixel, 1, -2); }) == "image size 1 x -2 is negative");
  CHECK(refusal([] { ImageView<float>(nullptr, 2, 3); }) == "image of size 2 x 3 has no data");
}
