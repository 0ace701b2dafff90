// The stages of a frame one at a time, 640 x 480 floats, and the family of Gaussians: time against
// the error to the exact one, which is given as a share of the image's range. A result beyond the
// error that its header states is a failure.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "gelight/image/camera.hpp"
#include "gelight/image/fast_gaussian.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/plane_fit.hpp"
#include "gelight/image/similarity.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/sensor/noise.hpp"
#include "gelight/shading/shadow.hpp"

using namespace gelight;

namespace {

constexpr Index width = 640, height = 480;
const auto camera = Camera<float>::from_vertical_fov(std::numbers::pi_v<float> / 2, width, height);

// Edges and noise between 0 and 1.
const Image<float>& scene() {
  static const Image<float> image = [] {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    Image<float> pixels(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        pixels(x, y) = x < width / 3 ? uniform(random) : static_cast<float>((x / 20 + y / 15) % 2);
      }
    }
    return pixels;
  }();
  return image;
}

// A ball of 4 mm pressed into a plane 30 mm away.
Image<float> contact() {
  Image<float> depth(width, height, 0.03f);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const float dx = static_cast<float>(x - 300) / 90, dy = static_cast<float>(y - 250) / 90;
      depth(x, y) -= 0.004f * std::max(0.f, 1 - dx * dx - dy * dy);
    }
  }
  return depth;
}

template <class T>
const Image<double>& exact(T sigma) {
  static double of = 0;
  static Image<double> result;
  if (of == sigma) return result;
  of = sigma;
  Image<double> image(width, height);
  std::copy(scene().pixels().begin(), scene().pixels().end(), image.pixels().begin());
  return result = gaussian(image, sigma, static_cast<Index>(std::ceil(9 * sigma)));
}

template <class Smooth>
void smoothing(benchmark::State& state, const Smooth& smooth, double stated) {
  const double sigma = 0.1 * static_cast<double>(state.range(0));
  Image<float> result;
  for (auto _ : state) {
    result = smooth(scene(), sigma);
    benchmark::DoNotOptimize(result.data());
  }
  double worst = 0;
  for (std::size_t i = 0; i < result.pixels().size(); ++i) {
    worst = std::max(worst, std::abs(result.pixels()[i] - exact(sigma).pixels()[i]));
  }
  if (worst > stated) return state.SkipWithError("further from the exact Gaussian than stated");
  state.counters["sigma"] = sigma;
  state.counters["error"] = worst;
}

void sigmas(benchmark::internal::Benchmark* b) {
  b->ArgName("tenths")->Arg(20)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(
    smoothing, exact_to_4_sigma, [](const auto& i, double s) { return gaussian(i, s); }, 3e-4)
    -> Apply(sigmas);
BENCHMARK_CAPTURE(
    smoothing, exact_to_3_sigma,
    [](const auto& i, double s) { return gaussian(i, s, static_cast<Index>(std::ceil(3 * s))); },
    6e-3) -> Apply(sigmas);
BENCHMARK_CAPTURE(
    smoothing, recursive, [](const auto& i, double s) { return gaussian_recursive(i, s); }, 3.5e-4)
    -> Apply(sigmas);
BENCHMARK_CAPTURE(
    smoothing, boxes_3, [](const auto& i, double s) { return gaussian_boxes(i, s, 3); }, 3e-2)
    -> Apply(sigmas);
BENCHMARK_CAPTURE(
    smoothing, boxes_5, [](const auto& i, double s) { return gaussian_boxes(i, s, 5); }, 2e-2)
    -> Apply(sigmas);
BENCHMARK_CAPTURE(
    smoothing, pyramid, [](const auto& i, double s) { return gaussian_pyramid(i, s); }, 1e-4)
    -> Apply(sigmas);

// Stages: bytes are those of the images read and written, once each.
template <class Stage>
void stage(benchmark::State& state, const Stage& work, double bytes_per_pixel) {
  for (auto _ : state) {
    auto result = work();
    benchmark::DoNotOptimize(&result);
  }
  state.counters["bytes_per_pixel"] = bytes_per_pixel;
  state.SetItemsProcessed(state.iterations() * width * height);
}

const Image<float> depth = contact(), rest(width, height, 0.03f);

#define GELIGHT_STAGE(name, bytes, ...)               \
  BENCHMARK_CAPTURE(                                  \
      stage, name, [] { return __VA_ARGS__; }, bytes) \
      ->Unit(benchmark::kMillisecond)

GELIGHT_STAGE(unproject, 16, unproject(depth, camera));
GELIGHT_STAGE(sobel_normals, 16, sobel_normals(depth, camera));
GELIGHT_STAGE(central_normals, 16, central_normals(depth, camera));
GELIGHT_STAGE(plane_fit_normals_radius_2, 16, plane_fit_normals(depth, camera, 2));
GELIGHT_STAGE(plane_fit_normals_radius_10, 16, plane_fit_normals(depth, camera, 10));
GELIGHT_STAGE(sobel, 12, sobel(depth));
GELIGHT_STAGE(resize_from_quarter, 5, resize_bilinear(Image<float>(160, 120, 1.f), width, height));
GELIGHT_STAGE(elastic_depth, 12, elastic_depth(depth, rest));
GELIGHT_STAGE(gelsight_flat_depth, 12, gelsight_flat_depth(depth));
GELIGHT_STAGE(contact_shadow, 12, contact_shadow(depth, rest, camera));
GELIGHT_STAGE(penetration_darkening, 12, penetration_darkening(depth, rest));
GELIGHT_STAGE(similarity, 6, ssim(Image<Rgb8>(width, height), Image<Rgb8>(width, height)));

void noise(benchmark::State& state) {
  Image<Rgb8> image(width, height, {128, 128, 128});
  for (auto _ : state) add_noise(image, 2, 1, static_cast<std::uint64_t>(state.iterations()));
  state.SetItemsProcessed(state.iterations() * width * height);
}
BENCHMARK(noise)->Unit(benchmark::kMillisecond);

}  // namespace
