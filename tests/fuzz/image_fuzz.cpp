#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fuzz/bytes.hpp"
#include "gelight/core/error.hpp"
#include "gelight/image/fast_gaussian.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/plane_fit.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

// Image stages on any size, stride and bit pattern.

using namespace gelight;

namespace {

/// A view of any strides onto `memory`, which it makes large enough.
template <class P>
ImageView<P> take_view(fuzz::Bytes& bytes, std::vector<P>& memory, Index width, Index height) {
  const Index across = bytes.below(3) + 1, down = width * across + bytes.below(4);
  const auto column_first = bytes.below(2) == 1;
  const Index row = column_first ? across : down;
  const Index pixel = column_first ? height * across : across;
  const bool mirrored = bytes.below(2) == 1;
  memory.resize(
      static_cast<std::size_t>(std::max(Index{1}, (std::max(width, Index{1}) - 1) * pixel +
                                                      (std::max(height, Index{1}) - 1) * row + 1)));
  P* const first = memory.data() + (mirrored ? (std::max(width, Index{1}) - 1) * pixel : 0);
  return ImageView<P>(first, width, height, row, mirrored ? -pixel : pixel);
}

template <class T>
void run(fuzz::Bytes& bytes) {
  const Index width = bytes.below(20), height = bytes.below(12);
  const double sigma =
      bytes.below(2) == 0 ? bytes.take<std::uint8_t>() / 16.0 : bytes.take<double>();
  std::vector<T> memory;
  const auto depth = take_view(bytes, memory, width, height);
  const bool any_bits = bytes.below(2) == 0;
  bool is_moderate = true;  // of others squares overflow or vanish
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      depth(x, y) = any_bits ? bytes.take<T>() : T(0.03) + T(1e-4) * bytes.take<std::int8_t>();
      const T size = std::fabs(depth(x, y));
      is_moderate &= size == 0 || (size > T(1e-12) && size < T(1e12));
    }
  }
  const ImageView<const T> in = depth;
  for (const auto border : {Border::reflect101, Border::reflect, Border::replicate, Border::zero}) {
    (void)gaussian(in, sigma, 5, border);
  }
  (void)gaussian_pyramid(in, sigma);
  const auto known = gaussian_of_known(in, sigma, 5);
  if (sigma >= 0.5) (void)gaussian_recursive(in, sigma);
  if (sigma > 0) (void)gaussian_boxes(in, sigma);
  const Camera<T> camera{20, 21, 5, 5, width, height};
  for (const auto& n : sobel_normals(in, camera, BorderNormals::extrapolated).pixels()) {
    const T norm = n.norm();
    fuzz::expect(!is_moderate || norm == 0 || std::fabs(norm - 1) < T(1e-3),
                 "a normal that is not unit");
  }
  for (const auto& n : central_normals(in, camera).pixels()) {
    const T norm = n.norm();
    fuzz::expect(!is_moderate || norm == 0 || std::fabs(norm - 1) < T(1e-3),
                 "a normal that is not unit");
  }
  const std::vector<Light<T>> lights{
      {Image<Vec3<T>>(width, height, Vec3<T>(1, 0, T(0.1)).normalized()), {1, T(0.5), 0}}};
  TactileOptions options;
  options.smoothing_radius = bytes.below(8);
  options.rectify = bytes.below(2) == 1;
  const TactileRenderer<T> renderer(camera, Image<T>(width, height, T(0.03)), lights, {}, options);
  std::vector<Rgb8> out_memory;
  const auto out = take_view(bytes, out_memory, width, height);
  renderer.render_into(out, in);
  const auto packed = renderer.render(in);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      fuzz::expect(out(x, y) == packed(x, y), "the output's strides change the image");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  try {
    if (bytes.below(2) == 0) {
      run<float>(bytes);
    } else {
      run<double>(bytes);
    }
  } catch (const InvalidInput&) {
    // A refusal, by name.
  }
  return 0;
}
