#include "gelight/concepts/image.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "gelight/image/filter.hpp"
#include "gelight/views/image_view.hpp"

using namespace gelight;

static_assert(ImageLike<Image<float>> && ImageLike<ImageView<const Rgb8>>);

namespace {

// Another library's matrix: data and step, no accessor of our kind.
struct Mat {
  int rows, cols;
  std::size_t step;  // bytes
  std::vector<unsigned char> data;
};

struct WithoutHeight {
  int width() const { return 1; }
  float operator()(Index, Index) const { return 0; }
};
struct FractionalSize {
  double width() const { return 1; }
  int height() const { return 1; }
  float operator()(Index, Index) const { return 0; }
};
struct WithoutPixels {
  int width() const { return 1; }
  int height() const { return 1; }
};

// Pixels that stand nowhere: computed when they are asked for.
struct Ramp {
  long width() const { return 4; }
  unsigned char height() const { return 3; }
  double operator()(Index x, Index y) const { return x + 10 * y; }
};

}  // namespace

template <>
struct gelight::ImageTraits<Mat> {
  static int width(const Mat& m) { return m.cols; }
  static int height(const Mat& m) { return m.rows; }
  static float pixel(const Mat& m, Index x, Index y) {
    float value = 0;
    std::memcpy(
        &value,
        m.data.data() + static_cast<std::size_t>(y) * m.step + 4 * static_cast<std::size_t>(x), 4);
    return value;
  }
};

static_assert(ImageLike<Ramp> && ImageLike<Mat> && ImageLike<Image<Rgb8>>);
static_assert(ImageLike<ImageView<float>> && ImageLike<ImageView<const double>>);
static_assert(!ImageLike<WithoutHeight> && !ImageLike<FractionalSize> && !ImageLike<WithoutPixels>);
static_assert(!ImageLike<int> && !ImageLike<std::string> && !ImageLike<std::vector<float>>);
static_assert(ImageOf<Mat, double> && ImageOf<Ramp, float> && ImageOf<Image<std::uint8_t>, float>);
static_assert(!ImageOf<Image<Rgb8>, float> && !ImageOf<Image<float>, Rgb8>);
static_assert(std::same_as<ImagePixel<Mat>, float> &&
              std::same_as<ImagePixel<ImageView<const Rgb8>>, Rgb8>);

TEST_CASE("an image of another library, and one that is computed, are read in place") {
  Mat mat{2, 3, 16, std::vector<unsigned char>(32)};
  for (std::size_t y = 0; y < 2; ++y) {
    for (std::size_t x = 0; x < 3; ++x) {
      const float value = static_cast<float>(x + 10 * y);
      std::memcpy(mat.data.data() + 16 * y + 4 * x, &value, 4);
    }
  }
  const auto same = gaussian(mat, 0);
  CHECK(same.width() == 3);
  CHECK(same.height() == 2);
  CHECK(same(2, 1) == 12);
  CHECK(gaussian(Ramp{}, 0)(3, 2) == 23);
}
