#include "gelight/io/npy.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include "support/refusal.hpp"

using namespace gelight;
using test::contains;

namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("gelight_npy_" + name)).string();
}

// A version 1 file as NumPy's documentation lays it out.
std::string with_header(std::string dictionary, const std::string& data) {
  dictionary += '\n';
  std::string file = "\x93NUMPY";
  file += {'\1', '\0', static_cast<char>(dictionary.size()), '\0'};
  return file + dictionary + data;
}

std::string saved(const std::string& name, const std::string& bytes) {
  const std::string path = temporary(name);
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

template <class P>
std::string refusal(const std::string& path) {
  return test::refusal([&] { (void)read_npy<P>(path); });
}

}  // namespace

TEST_CASE("images come back as they were written, bit for bit") {
  Image<double> numbers(3, 2);
  Image<Vec3<float>> vectors(2, 2);
  Image<Rgb8> colours(1, 3, {1, 2, 255});
  for (Index y = 0; y < 2; ++y) {
    for (Index x = 0; x < 3; ++x) numbers(x, y) = 0.1 * x - 1e300 * y;
  }
  vectors(1, 0) = {1, -2, 0.5f};
  const std::string path = temporary("roundtrip.npy");
  write_npy(path, numbers);
  CHECK(read_npy<double>(path) == numbers);
  write_npy(path, vectors);
  CHECK(read_npy<Vec3<float>>(path) == vectors);
  CHECK(read_npy<std::array<float, 3>>(path)(1, 0) == std::array<float, 3>{1, -2, 0.5f});
  write_npy(path, colours);
  CHECK(read_npy<Rgb8>(path) == colours);
  write_npy(path, Image<float>(0, 4));
  CHECK(read_npy<float>(path).height() == 4);
}

TEST_CASE("rows are read in the order in which NumPy stores them") {
  const std::string data{1, 2, 3, 4, 5, 6};
  const auto path = saved(
      "rows.npy", with_header("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3), }", data));
  const auto image = read_npy<std::uint8_t>(path);
  CHECK(image.width() == 3);
  CHECK(image.height() == 2);
  CHECK(image(2, 0) == 3);
  CHECK(image(0, 1) == 4);
}

TEST_CASE("columns are read in the order in which Fortran stores them") {
  // As NumPy saves np.asfortranarray: the first index runs first, the last index last.
  const auto bytes_of = [](const auto& values) {
    return std::string(reinterpret_cast<const char*>(values.data()), sizeof(values));
  };
  const auto file = [](const std::string& type, const std::string& shape) {
    return "{'descr': '" + type + "', 'fortran_order': True, 'shape': " + shape + ", }";
  };
  const std::array<double, 6> wide{1, 4, 2, 5, 3, 6};  // rows 1 2 3 and 4 5 6
  const std::array<float, 6> narrow{1, 4, 2, 5, 3, 6};
  const auto doubles = saved("columns8.npy", with_header(file("<f8", "(2, 3)"), bytes_of(wide)));
  const auto floats = saved("columns4.npy", with_header(file("<f4", "(2, 3)"), bytes_of(narrow)));
  for (const auto& image : {read_npy<double>(doubles), read_npy<double>(floats)}) {
    REQUIRE(image.width() == 3);
    REQUIRE(image.height() == 2);
    for (Index y = 0; y < 2; ++y) {
      for (Index x = 0; x < 3; ++x) CHECK(image(x, y) == 1 + x + 3 * y);
    }
  }
  CHECK(read_npy<float>(floats)(2, 1) == 6);
  std::string data;  // 2 rows of 3 pixels of 2 channels
  for (int c = 0; c < 2; ++c) {
    for (int x = 0; x < 3; ++x) {
      for (int y = 0; y < 2; ++y) data += static_cast<char>(100 * c + 10 * x + y);
    }
  }
  const auto pairs = saved("pairs.npy", with_header(file("|u1", "(2, 3, 2)"), data));
  const auto image = read_npy<std::array<std::uint8_t, 2>>(pairs);
  for (Index y = 0; y < 2; ++y) {
    for (Index x = 0; x < 3; ++x) {
      CHECK(image(x, y)[0] == 10 * x + y);
      CHECK(image(x, y)[1] == 100 + 10 * x + y);
    }
  }
  CHECK(read_npy<float>(saved("none.npy", with_header(file("<f4", "(0, 3)"), ""))).width() == 3);
}

TEST_CASE("float32 widens to double, and nothing else converts") {
  Image<float> narrow(2, 1, 0.1f);
  const std::string path = temporary("narrow.npy");
  write_npy(path, narrow);
  CHECK(read_npy<double>(path)(1, 0) == double{0.1f});
  CHECK(contains(refusal<std::int32_t>(path), "<f4, not <i4"));
  write_npy(path, Image<double>(2, 1));
  CHECK(contains(refusal<float>(path), "<f8, not <f4"));
  for (const std::string type : {"<u2", "<f2", ">f4"}) {
    const std::string header =
        "{'descr': '" + type + "', 'fortran_order': False, 'shape': (1, 2), }";
    const std::string other = saved("other.npy", with_header(header, std::string(8, '\0')));
    CHECK(contains(refusal<double>(other), type + ", not <f8 or <f4"));
  }
}

TEST_CASE("a header may end without a comma") {
  const std::string data(24, '\0');
  CHECK(read_npy<float>(saved("last.npy", with_header("{'descr': '<f4', 'shape': (2, 3), "
                                                      "'fortran_order': False}",
                                                      data))) == Image<float>(3, 2));
}

TEST_CASE("files that cannot be used are refused with their name and fault") {
  const std::string dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
  const std::string data(24, '\0');
  CHECK(refusal<float>(saved("good.npy", with_header(dictionary, data))) == "accepted");

  CHECK(contains(refusal<float>("/no/such.npy"), "/no/such.npy cannot be opened"));
  CHECK(contains(refusal<float>(saved("text.npy", "hello, world")), "not a .npy file"));
  CHECK(contains(refusal<float>(saved("empty.npy", "")), "not a .npy file"));
  CHECK(contains(refusal<float>(saved("cut.npy", with_header(dictionary, data).substr(0, 40))),
                 "ends within its .npy header"));
  CHECK(contains(refusal<float>(saved("short.npy", with_header(dictionary, data.substr(1)))),
                 "23 bytes of data where its shape (2, 3) needs 24"));
  CHECK(
      contains(refusal<float>(saved("long.npy", with_header(dictionary, data + "x"))), "25 bytes"));
  CHECK(contains(
      refusal<float>(
          saved("big.npy",
                with_header("{'descr': '>f4', 'fortran_order': False, 'shape': (2, 3), }", data))),
      ">f4, not <f4"));
  CHECK(
      contains(refusal<float>(saved(
                   "flat.npy",
                   with_header("{'descr': '<f4', 'fortran_order': False, 'shape': (6,), }", data))),
               "shape (6), not (height, width)"));
  CHECK(contains(
      refusal<float>(
          saved("huge.npy",
                with_header(
                    "{'descr': '<f4', 'fortran_order': False, 'shape': (2000000000, 2000000000), }",
                    data))),
      "which is too large"));
  CHECK(contains(refusal<float>(saved("nokey.npy", with_header("{'descr': '<f4', }", data))),
                 "'fortran_order'"));
  CHECK(contains(
      refusal<Rgb8>(saved(
          "rgba.npy",
          with_header("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 4), }", data))),
      "shape (2, 3, 4), not (height, width, 3)"));
  for (const std::string shape : {"(2, 3, 99999999999999999999)", "(2, 3, -)", "(2, 3x)"}) {
    CHECK(
        contains(refusal<float>(saved("shape.npy", with_header("{'descr': '<f4', 'fortran_order': "
                                                               "False, 'shape': " +
                                                                   shape + ", }",
                                                               data))),
                 "has a dimension of"));
  }
  CHECK(contains(
      refusal<float>(
          saved("order.npy",
                with_header("{'descr': '<f4', 'fortran_order': Bogus, 'shape': (2, 3), }", data))),
      "'fortran_order' that is not understood"));
  // What Python does not read, or not so.
  for (const std::string rest :
       {"False, 'shape': (2,,3)", "False, 'shape': (2 3)", "False, 'shape': 2, 3)",
        "False, 'shape': (2, 3), 'shape': (3, 2)", "FalseTrue, 'shape': (2, 3)"}) {
    CAPTURE(rest);
    const std::string whole = "{'descr': '<f4', 'fortran_order': " + rest + ", }";
    CHECK(refusal<float>(saved("damaged.npy", with_header(whole, data))) != "accepted");
  }
  CHECK_THROWS_AS(write_npy("/no/such/folder/x.npy", Image<float>(1, 1)), InvalidInput);
  if (std::filesystem::exists("/dev/full")) {
    CHECK_THROWS_AS(write_npy("/dev/full", Image<float>(1, 1)), InvalidInput);
  }
}

namespace {

// An image that says it is of a size, and has no pixels.
struct Sized {
  std::int64_t columns = 0, rows = 0;
  [[nodiscard]] std::int64_t width() const { return columns; }
  [[nodiscard]] std::int64_t height() const { return rows; }
  float operator()(Index, Index) const { return 0; }
};

}  // namespace

TEST_CASE("an image of a size that is none is not written") {
  const std::string path = saved("sized.npy", "as it was");
  const std::int64_t beyond = std::int64_t{std::numeric_limits<Index>::max()} + 1;
  for (const auto& [columns, rows] : {std::pair<std::int64_t, std::int64_t>{-1, 2},
                                      {2, -1},
                                      {beyond, 0},
                                      {0, beyond},
                                      {2 * beyond, 1}}) {
    const std::string size = std::to_string(columns) + " x " + std::to_string(rows);
    const Sized image{columns, rows};
    CHECK(contains(gelight::test::refusal([&] { write_npy(path, image); }), size));
    CHECK(std::filesystem::file_size(path) == 9);
  }
  write_npy(path, Sized{3, 2});
  CHECK(read_npy<float>(path) == Image<float>(3, 2));
}
