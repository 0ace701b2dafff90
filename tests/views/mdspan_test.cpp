#include "gelight/views/mdspan.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <vector>

namespace {

// What of std::mdspan is used; the standard library here may be older than it.
struct Span2 {
  using reference = float&;
  float* data;
  std::array<std::size_t, 2> extents, strides;
  static constexpr std::size_t rank() { return 2; }
  std::size_t extent(std::size_t r) const { return extents[r]; }
  std::size_t stride(std::size_t r) const { return strides[r]; }
  float* data_handle() const { return data; }
};

struct Span3 : Span2 {
  static constexpr std::size_t rank() { return 3; }
};

static_assert(gelight::MdspanLike<Span2>);
static_assert(!gelight::MdspanLike<Span3> && !gelight::MdspanLike<std::vector<float>>);

}  // namespace

TEST_CASE("an mdspan of any layout is an image, its first index the row") {
  std::vector<float> values{0, 1, 2, 3, 4, 5};
  const auto right = gelight::mdspan_image(Span2{values.data(), {2, 3}, {3, 1}});
  REQUIRE(right.width() == 3);
  REQUIRE(right.height() == 2);
  CHECK(right(2, 1) == 5);
  const auto left = gelight::mdspan_image(Span2{values.data(), {2, 3}, {1, 2}});
  CHECK(left(2, 0) == 4);
  left(2, 0) = -1;
  CHECK(values[4] == -1);
}

TEST_CASE("more columns than an image can have are refused") {
  float value = 0;
  const Span2 wide{&value, {1, std::size_t{1} << 40}, {std::size_t{1} << 40, 1}};
  CHECK_THROWS_AS((void)gelight::mdspan_image(wide), gelight::InvalidInput);
}
