#include "gelight/io/image.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "support/refusal.hpp"

using namespace gelight;

namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("gelight_image_" + name)).string();
}

Image<Rgb8> gradient() {
  Image<Rgb8> image(17, 9);
  for (Index y = 0; y < 9; ++y) {
    for (Index x = 0; x < 17; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(15 * x), static_cast<std::uint8_t>(28 * y),
                     static_cast<std::uint8_t>(x * y)};
    }
  }
  return image;
}

std::string refusal(const std::string& path) {
  return test::refusal([&] { (void)read_png(path); });
}

}  // namespace

TEST_CASE("a PNG comes back as it was written, also from a view of any stride") {
  const Image<Rgb8> image = gradient();
  const std::string path = temporary("roundtrip.png");
  write_png(path, image);
  CHECK(read_png(path) == image);

  const ImageView<const Rgb8> upside_down(image.row(8), 17, 9, -17);
  write_png(path, upside_down);
  const auto flipped = read_png(path);
  CHECK(flipped(3, 0) == image(3, 8));
  CHECK(flipped(16, 8) == image(16, 0));
}

TEST_CASE("files that are not whole PNG images are refused with their name") {
  CHECK(refusal("/no/such.png") == "/no/such.png cannot be opened");
  const std::string path = temporary("bad.png");
  std::ofstream(path) << "not a picture";
  CHECK(refusal(path).find(path + " is not a PNG image") != std::string::npos);

  write_png(path, gradient());
  std::ifstream whole(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(whole), {});
  for (const std::size_t length : {std::size_t{0}, std::size_t{20}, bytes.size() / 2}) {
    const std::string cut = temporary("cut.png");
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, length);
    CHECK(refusal(cut) != "accepted");
  }
}

TEST_CASE("what cannot be written is refused") {
  CHECK_THROWS_AS(write_png(temporary("empty.png"), Image<Rgb8>()), InvalidInput);
  CHECK_THROWS_AS(write_png("/no/such/folder/x.png", gradient()), InvalidInput);
}
