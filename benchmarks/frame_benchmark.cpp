// Whole tactile frames: what a frame costs by size and by number of lights, against the time to
// copy the bytes that it must move; what a small contact and a small change save; what it costs to
// rasterise an object of 100,000 triangles beside a frame; eight sensors on two threads; and, where
// the GelTip authors' data is there, against their recipe in NumPy (frame_numpy.py).
//
// Counters: ns_per_pixel; bytes_per_pixel and flops_per_pixel of the dense frame; times_copy, the
// frame's time over that of copying as many bytes as it reads and writes, measured in turns with
// it. Every image is checked: against double precision (one grey level), and changed-only against
// dense (bit for bit).

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/core/parallel.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/grey.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/io/image.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/run.hpp"
#include "support/timing.hpp"

using namespace gelight;

namespace {

using bench::median, bench::seconds;

// A membrane 30 mm away, curved like the wall of a cylinder of 60 mm.
Image<float> curved_rest(const Camera<double>& camera) {
  Image<float> rest(camera.width, camera.height);
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) {
      const double across = (x - camera.cx) / camera.fx;
      rest(x, y) = static_cast<float>(0.03 * (1 - 0.1 * across * across));
    }
  }
  return rest;
}

// A ball pressed into it that covers a share of the image's width, so far right of the middle.
Image<float> ball(const Image<float>& rest, double share, Index right = 0) {
  Image<float> contact = rest;
  const double radius = share * rest.width() / 2;
  for (Index y = 0; y < rest.height(); ++y) {
    for (Index x = 0; x < rest.width(); ++x) {
      const double dx = x - right - rest.width() / 2.0, dy = y - rest.height() / 2.0;
      const double inside = 1 - (dx * dx + dy * dy) / (radius * radius);
      if (inside > 0) contact(x, y) -= static_cast<float>(0.004 * inside);
    }
  }
  return contact;
}

template <class T>
std::vector<Light<T>> ring_of_lights(int count, Index width, Index height) {
  std::vector<Light<T>> lights;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    const Vec3<double> travel = Vec3<double>(std::cos(angle), std::sin(angle), 0.3).normalized();
    std::array<T, 3> rgb{};
    rgb[static_cast<std::size_t>(k % 3)] = T(3) / T(std::max(3, count));
    lights.push_back({Image<Vec3<T>>(width, height, travel.cast<T>()), rgb});
  }
  return lights;
}

template <class T>
TactileRenderer<T> synthetic(Index width, Index height, int lights, bool skip_unchanged) {
  const auto camera = Camera<T>::from_vertical_fov(T(1), width, height);
  return {camera, curved_rest(camera.template cast<double>()),
          ring_of_lights<T>(lights, width, height), Image<std::uint8_t>(width, height, 128),
          TactileOptions{.rectify = true, .skip_unchanged = skip_unchanged}};
}

// Read: depth, rest depth, ray length, grey background, and three numbers of 16 bits a light;
// written: 3 bytes.
double bytes_per_pixel(int lights) { return 4 * 4 + 6 * lights + 3; }

// Two passes of 21 products and 40 sums; normals; per light N.L, R.V, power of 100 and sum.
double flops_per_pixel(int lights) { return 2 * 61 + 52 + 31 * lights; }

int worst_level(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  int worst = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(a.pixels()[i][c] - b.pixels()[i][c]));
    }
  }
  return worst;
}

// Frames and copies of as many bytes, in turns.
void time_against_copy(benchmark::State& state, const TactileRenderer<float>& renderer,
                       const Image<float>& depth, int lights) {
  const double pixels = double{static_cast<double>(depth.width())} * depth.height();
  Image<Rgb8> out(depth.width(), depth.height());
  std::vector<char> from(static_cast<std::size_t>(pixels * bytes_per_pixel(lights)), 1),
      to(from.size());
  std::vector<double> frames, copies, ratios;
  for (auto _ : state) {
    frames.push_back(seconds([&] { renderer.render_into(out, depth); }));
    copies.push_back(seconds([&] { std::memcpy(to.data(), from.data(), from.size()); }));
    benchmark::DoNotOptimize(to.data());
    ratios.push_back(frames.back() / copies.back());
    state.SetIterationTime(frames.back());
  }
  state.counters["ns_per_pixel"] = 1e9 * median(frames) / pixels;
  state.counters["bytes_per_pixel"] = bytes_per_pixel(lights);
  state.counters["flops_per_pixel"] = flops_per_pixel(lights);
  state.counters["times_copy"] = median(ratios);
  state.counters["median_ms"] = 1e3 * median(frames);
}

void dense_frame(benchmark::State& state) {
  const auto width = static_cast<Index>(state.range(0)), height = width * 3 / 4;
  const int lights = static_cast<int>(state.range(1));
  const auto renderer = synthetic<float>(width, height, lights, false);
  const auto depth = ball(curved_rest(renderer.camera().cast<double>()), 0.5);
  const auto truth = synthetic<double>(width, height, lights, false).render(depth);
  if (worst_level(renderer.render(depth), truth) > 1) return state.SkipWithError("wrong image");
  time_against_copy(state, renderer, depth, lights);
}
BENCHMARK(dense_frame)
    ->ArgNames({"width", "lights"})
    ->ArgsProduct({{160, 320, 640, 1280}, {3}})
    ->ArgsProduct({{640}, {1, 2, 4, 8}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);

// What a contact saves that covers a share of the image's width, with the membrane around it as a
// camera sees it, or with nothing there, as `rasterize` tells of an object.
void changed_frame(benchmark::State& state) {
  const auto sparse = synthetic<float>(640, 480, 3, true),
             dense = synthetic<float>(640, 480, 3, false);
  const auto rest = curved_rest(sparse.camera().cast<double>());
  auto depth = ball(rest, 0.01 * static_cast<double>(state.range(0)));
  for (std::size_t i = 0; i < rest.pixels().size() && state.range(1) != 0; ++i) {
    float& z = depth.pixels()[i];
    if (z == rest.pixels()[i]) z = std::numeric_limits<float>::infinity();
  }
  Image<Rgb8> out(640, 480), whole(640, 480);
  std::vector<double> times, dense_times;
  for (auto _ : state) {
    for (int i = 0; i < 5; ++i) times.push_back(seconds([&] { sparse.render_into(out, depth); }));
    for (int i = 0; i < 5; ++i) {
      dense_times.push_back(seconds([&] { dense.render_into(whole, depth); }));
    }
    state.SetIterationTime(times.back());
  }
  if (out != whole) return state.SkipWithError("differs from the dense frame");
  state.counters["times_faster_than_dense"] = median(dense_times) / median(times);
}
BENCHMARK(changed_frame)
    ->ArgNames({"percent", "nothing_around"})
    ->ArgsProduct({{0, 5, 10, 20, 50}, {0, 1}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);

// The same contact in a sequence, where it slides by two pixels a frame.
void sliding_frame(benchmark::State& state) {
  const auto sparse = synthetic<float>(640, 480, 3, true),
             dense = synthetic<float>(640, 480, 3, false);
  const auto rest = curved_rest(sparse.camera().cast<double>());
  std::vector<Image<float>> depths;
  for (const Index right : {-4, -2, 0, 2, 4, 2, 0, -2}) {
    depths.push_back(ball(rest, 0.01 * static_cast<double>(state.range(0)), right));
  }
  auto frame = sparse.rest_frame();
  Image<Rgb8> whole(640, 480);
  std::vector<double> times, dense_times;
  for (auto _ : state) {
    for (const auto& depth : depths) {
      times.push_back(seconds([&] { sparse.render_next_into(frame, depth); }));
    }
    for (int i = 0; i < 5; ++i) {
      dense_times.push_back(seconds([&] { dense.render_into(whole, depths.back()); }));
    }
    if (frame.image != whole) return state.SkipWithError("differs from the dense frame");
    state.SetIterationTime(times.back());
  }
  state.counters["times_faster_than_dense"] = median(dense_times) / median(times);
}
BENCHMARK(sliding_frame)
    ->ArgName("percent")
    ->Arg(1)
    ->Arg(5)
    ->Arg(10)
    ->Arg(20)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);

// A ball over half of the width that lies still while a smaller thing slides over it: what it saves
// to compute only what differs from the last frame.
void next_frame(benchmark::State& state) {
  const auto renderer = synthetic<float>(640, 480, 3, true);
  const auto still = ball(curved_rest(renderer.camera().cast<double>()), 0.5);
  const auto step = static_cast<Index>(state.range(0));  // pixels a frame; 0: nothing moves
  Image<Rgb8> whole(640, 480);
  auto frame = renderer.rest_frame();
  Index at = 200;
  std::vector<double> times, whole_times;
  for (auto _ : state) {
    at = at + step < 400 ? at + step : 200;
    auto depth = still;
    for (Index y = 220; y < 240; ++y) {
      for (Index x = at; x < at + 20; ++x) depth(x, y) -= 5e-4f;
    }
    times.push_back(seconds([&] { renderer.render_next_into(frame, depth); }));
    whole_times.push_back(seconds([&] { renderer.render_into(whole, depth); }));
    if (frame.image != whole) return state.SkipWithError("differs from the whole frame");
    state.SetIterationTime(times.back());
  }
  state.counters["median_ms"] = 1e3 * median(times);
  state.counters["times_faster_than_whole"] = median(whole_times) / median(times);
}
BENCHMARK(next_frame)
    ->ArgName("step")
    ->Arg(0)
    ->Arg(2)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.1);

// How far the seen points of a torus lie off it, at most, in its smaller radii; 1 where few are
// seen.
double off_torus(const Image<float>& depth, const Camera<float>& camera, const Vec3<double>& centre,
                 double major, double minor) {
  double worst = 0;
  Index seen = 0;
  for (Index y = 0; y < depth.height(); ++y) {
    for (Index x = 0; x < depth.width(); ++x) {
      if (!std::isfinite(depth(x, y))) continue;
      const Vec3<double> p = camera.cast<double>().unproject(x, y, double{depth(x, y)}) - centre;
      const double off = std::hypot(std::hypot(p[0], p[1]) - major, p[2]) / minor - 1;
      worst = std::max(worst, std::abs(off));
      ++seen;
    }
  }
  return 3 * seen > depth.width() * depth.height() ? worst : 1;
}

// An object of 100,480 triangles that fills half of the image, in how many dense frames it is
// drawn: into a depth image, into one with faces and places in them, and as `rasterize` does.
void rasterized_object(benchmark::State& state) {
  const auto renderer = synthetic<float>(640, 480, 3, false);
  const auto contact = ball(curved_rest(renderer.camera().cast<double>()), 0.5);
  const auto mesh = torus<float>(0.9f, 0.35f, 320, 157);
  const auto camera = Camera<float>::from_vertical_fov(0.9f, 640, 480);
  const Vec3<double> ahead(0, 0, 2.6);
  const Pose pose(Eigen::Matrix3d::Identity(), ahead);
  auto moved = mesh;
  for (auto& p : moved.positions) p[2] += 2.6f;
  RasterWorkspace work;
  Image<Rgb8> out(640, 480);
  Image<float> depth(640, 480);
  Raster<float> raster = empty_raster(camera), whole = raster;
  const auto clear = [](Image<float>& image) {
    std::fill(image.pixels().begin(), image.pixels().end(), std::numeric_limits<float>::infinity());
  };
  std::vector<double> frames, depths, rasters, wholes;
  for (auto _ : state) {
    frames.push_back(seconds([&] { renderer.render_into(out, contact); }));
    depths.push_back(seconds([&] {
      clear(depth);
      rasterize_into<float>(depth, mesh, pose, camera, &work);
    }));
    rasters.push_back(seconds([&] {
      clear(raster.depth);
      rasterize_into(raster, mesh, pose, camera, &work);
    }));
    wholes.push_back(seconds([&] { whole = rasterize(moved, camera); }));
    state.SetIterationTime(depths.back());
  }
  // Chords between 157 and 320 corners round lie up to 2e-4 and 1.7e-4 of the smaller radius
  // within.
  const bool is_torus = off_torus(depth, camera, ahead, 0.9, 0.35) < 5e-4 &&
                        off_torus(whole.depth, camera, ahead, 0.9, 0.35) < 5e-4;
  if (!is_torus || raster.depth != depth) return state.SkipWithError("another object");
  state.counters["triangles"] = static_cast<double>(mesh.faces.size());
  state.counters["median_ms"] = 1e3 * median(depths);
  state.counters["depth_frames"] = median(depths) / median(frames);
  state.counters["raster_frames"] = median(rasters) / median(frames);
  state.counters["rasterize_frames"] = median(wholes) / median(frames);
}
BENCHMARK(rasterized_object)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.3);

// Eight sensors, one after the other and on two threads, in turns.
void eight_sensors(benchmark::State& state) {
  std::vector<TactileRenderer<float>> sensors;
  for (int k = 0; k < 8; ++k) sensors.push_back(synthetic<float>(320, 240, 3, false));
  const auto depth = ball(curved_rest(sensors[0].camera().cast<double>()), 0.5);
  std::vector<Image<Rgb8>> out(8, Image<Rgb8>(320, 240));
  const auto all = [&](unsigned threads) {
    parallel_for(8, threads, [&](Index k) {
      const auto i = static_cast<std::size_t>(k);
      // Ten frames, as many as a batch of observations may ask for.
      for (int frame = 0; frame < 10; ++frame) sensors[i].render_into(out[i], depth);
    });
  };
  std::vector<double> ratios;
  for (auto _ : state) {
    const double one = seconds([&] { all(1); }), two = seconds([&] { all(2); });
    ratios.push_back(one / two);
    state.SetIterationTime(two);
  }
  for (const auto& image : out) {
    if (image != out[0]) return state.SkipWithError("threads disturb one another");
  }
  state.counters["times_faster_than_one"] = median(ratios);
}
BENCHMARK(eight_sensors)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.5);

// The GelTip authors' data.

const std::filesystem::path reference_folder =
    std::filesystem::path(GELIGHT_REFERENCE_DIR) / "geltip";

Image<float> reference_depth(const std::string& name) {
  return read_npy<float>((reference_folder / "depth" / (name + ".npy")).string());
}

TactileRenderer<float> reference_renderer(bool skip_unchanged) {
  std::vector<Light<float>> lights;
  for (const int led : {1, 2, 0}) {
    const auto path = reference_folder / "field" / ("geodesic_led" + std::to_string(led) + ".npy");
    const auto field =
        resize_bilinear(gaussian(read_npy<Vec3<double>>(path.string()), 4.1, 12), 640, 480);
    Light<float> light{Image<Vec3<float>>(640, 480), {0, 0, 0}};
    for (Index y = 0; y < 480; ++y) {
      for (Index x = 0; x < 640; ++x) light.direction(x, y) = field(x, y).cast<float>();
    }
    light.rgb[lights.size()] = 1;
    lights.push_back(light);
  }
  TactileOptions options{.rectify = true, .skip_unchanged = skip_unchanged};
  return {Camera<float>::from_vertical_fov(std::numbers::pi_v<float> / 2, 640, 480),
          reference_depth("rest"), lights,
          grey(read_png((reference_folder / "image" / "background.png").string())), options};
}

// The milliseconds of the recipe in NumPy for one contact, the best of three; 0 where it fails.
double numpy_milliseconds(int contact) {
  const std::string command = "OMP_NUM_THREADS=1 " GELIGHT_PYTHON " " GELIGHT_FRAME_NUMPY
                              " " GELIGHT_REFERENCE_DIR " 3 2>/dev/null";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(popen(command.c_str(), "r"),
                                                               &pclose);
  double best = 0;
  int k = 0;
  std::array<char, 256> line{};
  while (output != nullptr && std::fgets(line.data(), line.size(), output.get()) != nullptr) {
    double found = 0;
    if (std::sscanf(line.data(), "contact_%d best_ms %lf", &k, &found) == 2 && k == contact)
      best = found;
  }
  return best;
}

void published_frame(benchmark::State& state) {
  if (!std::filesystem::exists(reference_folder))
    return gelight::bench::leave_out(state, "there is no reference data");
  const int contact = static_cast<int>(state.range(0));
  const auto depth = reference_depth("contact_" + std::to_string(contact));
  const auto sparse = reference_renderer(true), dense = reference_renderer(false);
  const auto published = read_png((reference_folder / "image" / "expected_geodesic.png").string());
  Image<Rgb8> out(640, 480), whole(640, 480), want(640, 480);
  for (Index y = 0; y < 480; ++y) {
    for (Index x = 0; x < 640; ++x) want(x, y) = published(640 * contact + x, y);
  }
  std::vector<double> times, dense_times;
  for (auto _ : state) {
    // A few of either in a row, as a simulation has them: what they need is in cache, or is not.
    for (int i = 0; i < 5; ++i) times.push_back(seconds([&] { sparse.render_into(out, depth); }));
    for (int i = 0; i < 5; ++i) {
      dense_times.push_back(seconds([&] { dense.render_into(whole, depth); }));
    }
    state.SetIterationTime(times.back());
  }
  if (worst_level(whole, want) > 1) return state.SkipWithError("not the published image");
  if (out != whole) return state.SkipWithError("differs from the dense frame");
  const double numpy = numpy_milliseconds(contact);
  state.counters["dense_ms"] = 1e3 * median(dense_times);
  state.counters["times_faster_than_dense"] = median(dense_times) / median(times);
  state.counters["numpy_ms"] = numpy;
  state.counters["dense_times_numpy"] = 1e-3 * numpy / median(dense_times);
  state.counters["times_numpy"] = 1e-3 * numpy / median(times);
}
BENCHMARK(published_frame)
    ->ArgName("contact")
    ->DenseRange(0, 5)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);

}  // namespace
