// The family of Gaussians at 640 x 480: time against the error to the exact one, which is given as
// a share of the image's range; a result beyond the error that its header states is a failure. And
// the stages of a frame one at a time, from 160 x 120 to 1280 x 960.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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
#include "gelight/membrane/elastic.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "gelight/sensor/noise.hpp"
#include "gelight/sensor/rows/shaded_rows.hpp"

using namespace gelight;

namespace {

constexpr Index width = 640, height = 480;

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

// Stages, at the sizes of frames. Bytes a pixel are those of the images read and written, once
// each; flops a pixel are the additions and multiplications as they are written, and what Newton's
// method commonly takes.

struct Inputs {
  Camera<float> camera;
  Image<float> depth, rest;

  explicit Inputs(Index image_width)
      : camera(Camera<float>::from_vertical_fov(std::numbers::pi_v<float> / 2, image_width,
                                                image_width * 3 / 4)),
        depth(camera.width, camera.height, 0.03f),
        rest(depth) {
    // A ball of 4 mm pressed into a plane 30 mm away.
    const auto size = static_cast<float>(0.14 * image_width);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        const float dx = (static_cast<float>(x) - camera.cx) / size,
                    dy = (static_cast<float>(y) - camera.cy) / size;
        depth(x, y) -= 0.004f * std::max(0.f, 1 - dx * dx - dy * dy);
      }
    }
  }
};

void say_work(benchmark::State& state, Index pixels, double bytes, double flops) {
  state.counters["bytes_per_pixel"] = bytes;
  state.counters["flops_per_pixel"] = flops;
  state.SetItemsProcessed(state.iterations() * pixels);
}

template <class Stage>
void stage(benchmark::State& state, const Stage& work, double bytes, double flops) {
  const Inputs in(static_cast<Index>(state.range(0)));
  for (auto _ : state) {
    auto result = work(in);
    benchmark::DoNotOptimize(&result);
  }
  say_work(state, in.camera.width * in.camera.height, bytes, flops);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgName("width")->Arg(160)->Arg(320)->Arg(640)->Arg(1280)->Unit(benchmark::kMillisecond);
}

#define GELIGHT_STAGE(name, bytes, flops, ...)                                 \
  BENCHMARK_CAPTURE(                                                           \
      stage, name, [](const Inputs& in) { return __VA_ARGS__; }, bytes, flops) \
      ->Apply(sizes)

GELIGHT_STAGE(elastic_depth, 12, 2 * 61 + 3, elastic_depth(in.depth, in.rest));
GELIGHT_STAGE(flat_gelsight_membrane, 12, 1480,
              surface_depth(FlatGelSightMembrane<float>(), in.depth, in.rest));
GELIGHT_STAGE(unproject, 16, 2, unproject(in.depth, in.camera));
GELIGHT_STAGE(sobel, 12, 12, sobel(in.depth));
GELIGHT_STAGE(sobel_normals, 16, 52, sobel_normals(in.depth, in.camera));
GELIGHT_STAGE(central_normals, 16, 24, central_normals(in.depth, in.camera));
GELIGHT_STAGE(plane_fit_normals_radius_2, 16, 270, plane_fit_normals(in.depth, in.camera, 2));
GELIGHT_STAGE(plane_fit_normals_radius_10, 16, 300, plane_fit_normals(in.depth, in.camera, 10));
GELIGHT_STAGE(shadowed_membrane, 12, 320,
              surface_depth(ShadowedMembrane<float>(in.camera, GaussianMembrane<float>()), in.depth,
                            in.rest));
GELIGHT_STAGE(resize_from_quarter, 4.25, 9,
              resize_bilinear(Image<float>(in.camera.width / 4, in.camera.height / 4, 1.f),
                              in.camera.width, in.camera.height));

// Phong's equation, as a frame has it: the lights of normals that are there, clamped and packed.
void phong(benchmark::State& state) {
  const Inputs in(static_cast<Index>(state.range(0)));
  const Index columns = in.camera.width, rows = in.camera.height;
  const auto count = static_cast<int>(state.range(1));
  std::vector<Light<float>> lights;
  for (int k = 0; k < count; ++k) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / 8;
    lights.push_back({Image<Vec3<float>>(
        columns, rows, Vec3<float>(std::cos(angle), std::sin(angle), 0.3f).normalized())});
  }
  const detail::ShadedRows<float> shading(in.camera, Image<std::uint8_t>(columns, rows, 128), 0.5,
                                          lights, Specular::gated, nullptr);
  auto work = shading.make_workspace();
  std::array<float, detail::tile_width> x{}, y{}, z{};
  z.fill(-1);
  for (auto _ : state) {
    for (Index row = 0; row < rows; ++row) {
      detail::for_each_tile({0, columns}, [&](const detail::Run& run) {
        shading.shade(work, row, run, {x.data(), y.data(), z.data()}, nullptr);
      });
      benchmark::DoNotOptimize(work.packed.data());
    }
  }
  // Of each light three numbers of 16 bits; the grey background; four packed bytes.
  say_work(state, columns * rows, 4 + 6 * count + 4, 31 * count);
}
BENCHMARK(phong)
    ->ArgNames({"width", "lights"})
    ->ArgsProduct({{160, 320, 640, 1280}, {3}})
    ->ArgsProduct({{640}, {1, 2, 4, 8}})
    ->Unit(benchmark::kMillisecond);

void noise(benchmark::State& state) {
  const auto columns = static_cast<Index>(state.range(0)), rows = columns * 3 / 4;
  Image<Rgb8> image(columns, rows, {128, 128, 128});
  for (auto _ : state) add_noise(image, 2, 1, static_cast<std::uint64_t>(state.iterations()));
  state.counters["bytes_per_pixel"] = 6;
  state.SetItemsProcessed(state.iterations() * columns * rows);
}
BENCHMARK(noise)->Apply(sizes);

void similarity(benchmark::State& state) {
  const auto columns = static_cast<Index>(state.range(0)), rows = columns * 3 / 4;
  const Image<Rgb8> image(columns, rows);
  for (auto _ : state) benchmark::DoNotOptimize(ssim(image, image));
  state.counters["bytes_per_pixel"] = 6;
  state.SetItemsProcessed(state.iterations() * columns * rows);
}
BENCHMARK(similarity)->Apply(sizes);

}  // namespace
