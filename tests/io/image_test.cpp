#include "gelight/io/image.hpp"

#include <doctest/doctest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <thread>
#include <utility>

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
  const std::string endless = "/dev/zero";
  if (std::filesystem::exists(endless)) {
    CHECK(refusal(endless).find(endless + " is not a PNG image") != std::string::npos);
  }

  write_png(path, gradient());
  std::ifstream whole(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(whole), {});
  for (const std::size_t length : {std::size_t{0}, std::size_t{20}, bytes.size() / 2}) {
    const std::string cut = temporary("cut.png");
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, length);
    CHECK(refusal(cut) != "accepted");
  }
  // Also where nothing is missing but the last chunk, or a byte of it.
  for (const std::size_t missing : {5u, 6u, 7u, 9u, 11u, 12u, 13u, 40u}) {
    const std::string cut = temporary("cut.png");
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() - missing);
    CHECK(refusal(cut) ==
          cut + " is not a PNG image that can be read: it ends before its chunk IEND");
  }
  for (const std::size_t missing : {1u, 2u, 3u, 4u}) {  // of the last checksum
    const std::string cut = temporary("cut.png");
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() - missing);
    CHECK(refusal(cut) ==
          cut + " is not a PNG image that can be read: it ends within its chunk IEND");
  }
}

TEST_CASE("a PNG whose data begin as none do is refused, though stb does not say why") {
  const std::string path = temporary("unpacked.png");
  write_png(path, gradient());
  std::ifstream whole(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(whole), {});
  const std::size_t block = bytes.find("IDAT") + 6;
  bytes[block] = 7;  // the last block, of the kind that is none
  std::ofstream(path, std::ios::binary) << bytes;
  std::string colours;
  // A thread of its own, for which stb has said nothing yet.
  std::thread([&] { colours = refusal(path); }).join();
  CHECK(colours == path + " is not a PNG image that can be read: its data are damaged");
}

const char listed_bytes[] =
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x03"
    "\x00\x00\x00\x01\x02\x03\x00\x00\x00\x66\x8e\xfc\x27\x00\x00\x00\x09\x50\x4c\x54"
    "\x45\xff\x00\x00\x00\xff\x00\x00\x00\xff\x2d\x4a\xcd\x8a\x00\x00\x00\x01\x74\x52"
    "\x4e\x53\x80\xad\x5e\x5b\x46\x00\x00\x00\x0d\x49\x44\x41\x54\x78\x01\x01\x02\x00"
    "\xfd\xff\x00\x18\x00\x1a\x00\x19\x2f\xcc\xbb\x0f\x00\x00\x00\x00\x49\x45\x4e\x44"
    "\xae\x42\x60\x82";

// Red, green and blue as a list, and three pixels of two bits with these colours, in one byte.
TEST_CASE("a colour that a PNG does not list is refused") {
  std::string bytes(listed_bytes, sizeof(listed_bytes) - 1);
  const std::string path = temporary("listed.png");
  const auto save = [&](char row) {
    bytes[83] = row;
    std::ofstream(path, std::ios::binary) << bytes;
  };
  save(0b00'01'10'00);
  const Image<Rgb8> image = read_png(path);
  REQUIRE(image.width() == 3);
  CHECK(image(0, 0) == Rgb8{255, 0, 0});
  CHECK(image(1, 0) == Rgb8{0, 255, 0});
  CHECK(image(2, 0) == Rgb8{0, 0, 255});
  save(0b00'11'10'00);
  CHECK(refusal(path) == path + " has colour 3 of 3 at pixel 1, 0");
}

TEST_CASE("what cannot be written is refused") {
  CHECK_THROWS_AS(write_png(temporary("empty.png"), Image<Rgb8>()), InvalidInput);
  for (const char* ending : {"jpg", "JPEG", "bmp", "gif", "tif", "Tiff", "webp", "ppm"}) {
    const std::string name = temporary("other.") + ending;
    CHECK_THROWS_AS(write_png(name, gradient()), InvalidInput);
    CHECK(!std::filesystem::exists(name));
  }
  CHECK_THROWS_AS(write_png("/no/such/folder/x.png", gradient()), InvalidInput);
  // As large as fits no int, its bytes or those of a row, all of them one pixel in memory.
  const Rgb8 grey{9, 9, 9};
  for (const auto& [width, height] : {std::pair<Index, Index>{40000, 40000}, {800000000, 1}}) {
    const ImageView<const Rgb8> large(&grey, width, height, 0, 0);
    CHECK(test::contains(test::refusal([&] { write_png(temporary("large.png"), large); }),
                         "pixels is too large to be written to"));
    CHECK(!std::filesystem::exists(temporary("large.png")));
  }
  if (std::filesystem::exists("/dev/full")) {
    CHECK(test::refusal([] { write_png("/dev/full", gradient()); }) ==
          "/dev/full cannot be written");
  }
}

// 16-bit PNGs as Python's zlib and struct make them: grey, 3 x 2 pixels with the values 0, 1, 256
// and 4550, 65534, 65535; and one pixel in colour.
const char grey_bytes[] =
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x03"
    "\x00\x00\x00\x02\x10\x00\x00\x00\x00\xe8\x8f\xe5\x85\x00\x00\x00\x16\x49\x44\x41"
    "\x54\x78\xda\x63\x60\x60\x60\x60\x64\x64\x60\x10\x3c\xf6\xff\xdf\xff\xff\x00\x0e"
    "\x58\x04\xd5\xf2\xfb\x50\xf1\x00\x00\x00\x00\x49\x45\x4e\x44\xae\x42\x60\x82";
const char colour_bytes[] =
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x01"
    "\x00\x00\x00\x01\x10\x02\x00\x00\x00\xc0\xe7\x8f\x9d\x00\x00\x00\x0f\x49\x44\x41"
    "\x54\x78\xda\x63\x60\x60\x64\x60\x62\x60\x06\x00\x00\x15\x00\x07\x85\x0c\x48\x6f"
    "\x00\x00\x00\x00\x49\x45\x4e\x44\xae\x42\x60\x82";

const char eight_bytes[] =
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x02"
    "\x00\x00\x00\x01\x08\x00\x00\x00\x00\xd1\x49\x20\x56\x00\x00\x00\x0b\x49\x44\x41"
    "\x54\x78\xda\x63\x60\x64\x02\x00\x00\x07\x00\x04\xe5\xed\x94\xcf\x00\x00\x00\x00"
    "\x49\x45\x4e\x44\xae\x42\x60\x82";

std::string saved(const std::string& name, const std::string& bytes) {
  const std::string path = temporary(name);
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

TEST_CASE("a 16-bit grey PNG is a depth map, each value times a unit") {
  const std::string path = saved("depth.png", {grey_bytes, sizeof(grey_bytes) - 1});
  const std::array<double, 6> values{0, 1, 256, 4550, 65534, 65535};
  for (const double unit : {1e-5, 1e-3, 1.0, 0.3}) {
    const Image<double> wide = read_depth_png<double>(path, unit);
    const Image<float> narrow = read_depth_png<float>(path, static_cast<float>(unit));
    REQUIRE(wide.width() == 3);
    REQUIRE(wide.height() == 2);
    for (std::size_t i = 0; i < values.size(); ++i) {
      CHECK(wide.pixels()[i] == values[i] * unit);
      CHECK(narrow.pixels()[i] == static_cast<float>(values[i]) * static_cast<float>(unit));
    }
  }
}

TEST_CASE("what is no 16-bit grey PNG, or has no unit, is no depth map") {
  const auto refused = [](const std::string& path, double unit) {
    return test::refusal([&] { (void)read_depth_png<double>(path, unit); });
  };
  const std::string grey = saved("depth.png", {grey_bytes, sizeof(grey_bytes) - 1});
  const std::string colour = saved("colour.png", {colour_bytes, sizeof(colour_bytes) - 1});
  const std::string eight = saved("eight.png", {eight_bytes, sizeof(eight_bytes) - 1});
  CHECK(test::contains(refused(eight, 1e-5), eight + " has 8 bits"));
  CHECK(test::contains(refused(colour, 1e-5), colour + " has 3 channels"));
  CHECK(test::contains(refused("/no/such.png", 1e-5), "/no/such.png cannot be opened"));
  CHECK(test::contains(refused(saved("text.png", "hello"), 1e-5), "is not a PNG image"));
  for (std::size_t length = 8; length + 1 < sizeof(grey_bytes); ++length) {
    const std::string cut = saved("cut.png", std::string(grey_bytes, length));
    const bool is_last = length + 5 >= sizeof(grey_bytes);  // in the last checksum
    CHECK(refused(cut, 1e-5) == cut + " is not a PNG image that can be read: it ends " +
                                    (is_last ? "within" : "before") + " its chunk IEND");
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double unit : {0.0, -1e-5, nan, std::numeric_limits<double>::infinity()}) {
    CHECK(test::contains(refused(grey, unit), "unit"));
  }
  // Larger than float's numbers, which would say that nothing is there.
  for (const float unit : {6e33f, 1e38f}) {
    CHECK(test::contains(test::refusal([&] { (void)read_depth_png<float>(grey, unit); }),
                         "makes inf"));
  }
}
