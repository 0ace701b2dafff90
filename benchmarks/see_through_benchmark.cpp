// Frames of the half-silvered sensor and the springs under them, at 640 x 480.
//
// Frames, by how much of the image the contact covers: milliseconds; times_authors, 955 ms over it
// (the STS authors' simulator for a frame, of it 773 ms for covariance normals: measured once, on
// another day, see the sources of their simulator); and times_numpy, the same frame restated in
// NumPy (see_through_numpy.py), run right after. The image is checked against NumPy's (one grey
// level but for a few pixels) and against double precision.
//
// Springs: milliseconds for a force, for force and moments, and with a taut membrane; residual, the
// share of the force that is missing; the displacement is checked against a search by sorting.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "gelight/image/plane_fit.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/sensor/see_through.hpp"
#include "support/timing.hpp"

using namespace gelight;

namespace {

constexpr Index width = 640, height = 480, radius = 1;
constexpr double field_of_view = 0.9, tilt = 0.2, gel_depth = 0.07;
constexpr double authors_frame = 955, authors_normals = 773;  // milliseconds

using bench::median;

template <class Work>
double milliseconds(const Work& work) {
  return 1e3 * bench::seconds(work);
}

template <class T>
Camera<T> camera() {
  return Camera<T>::from_vertical_fov(static_cast<T>(field_of_view), width, height);
}

// A ball with dimples, pressed 3 mm into the gel over a share of the image's width; beyond it the
// gel at rest.
Image<float> dimpled_ball(double share) {
  Image<float> depth(width, height, static_cast<float>(gel_depth));
  const double size = share * width / 2;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double dx = (x - width / 2) / size, dy = (y - height / 2) / size;
      const double inside = 1 - dx * dx - dy * dy;
      if (inside > 0) {
        depth(x, y) -=
            static_cast<float>(inside * (0.003 + 1e-4 * std::sin(0.2 * x) * std::cos(0.17 * y)));
      }
    }
  }
  return depth;
}

template <class T>
SeeThroughRenderer<T> renderer() {
  return {camera<T>(), Image<T>(width, height, static_cast<T>(gel_depth)),
          edge_lights(camera<T>(), tilt), std::array<double, 3>{0.7, 0.7, 0.8},
          SeeThroughOptions{.normal_radius = radius, .levels = LightLevels::tactile()}};
}

struct Numpy {
  double frame = 0, normals = 0;  // milliseconds; 0 where it did not run
  Image<std::array<float, 3>> image;
};

Numpy numpy_frame(const Image<float>& depth) {
  const auto folder = std::filesystem::temp_directory_path();
  const std::string in = (folder / "see_through_depth.npy").string();
  const std::string out = (folder / "see_through_image.npy").string();
  write_npy(in, depth);
  const std::string command =
      "OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 " GELIGHT_PYTHON " " GELIGHT_SEE_THROUGH_NUMPY " " +
      in + " " + out + " " + std::to_string(field_of_view) + " " + std::to_string(radius) + " " +
      std::to_string(tilt) + " 3 2>/dev/null";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(popen(command.c_str(), "r"),
                                                               &pclose);
  Numpy result;
  double middle = 0;
  if (output == nullptr ||
      std::fscanf(output.get(), "frame best_ms %lf median_ms %lf normals_best_ms %lf",
                  &result.frame, &middle, &result.normals) != 3) {
    return {};
  }
  result.image = read_npy<std::array<float, 3>>(out);
  return result;
}

// How many pixels are more than `level` grey levels off.
template <class P>
std::size_t pixels_off(const Image<Rgb8>& image, const Image<P>& want, double level) {
  std::size_t off = 0;
  for (std::size_t i = 0; i < image.pixels().size(); ++i) {
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      worst = std::max(
          worst, std::abs(double{1} * image.pixels()[i][c] - double{1} * want.pixels()[i][c]));
    }
    off += worst > level;
  }
  return off;
}

void see_through_frame(benchmark::State& state) {
  const auto depth = dimpled_ball(0.01 * static_cast<double>(state.range(0)));
  const auto sensor = renderer<float>();
  const Image<Rgb8> visual(width, height, {90, 120, 60});
  Image<Rgb8> out(width, height);
  std::vector<double> times;
  for (auto _ : state) {
    times.push_back(
        milliseconds([&] { sensor.render_into(out, depth, visual, LightLevels::visuotactile()); }));
    state.SetIterationTime(1e-3 * times.back());
  }
  if (pixels_off(sensor.render(depth), renderer<double>().render(depth), 1) > 0) {
    return state.SkipWithError("differs from double precision");
  }
  const Numpy numpy = numpy_frame(depth);
  if (numpy.frame > 0 && pixels_off(sensor.render(depth), numpy.image, 1) > 0) {
    return state.SkipWithError("differs from NumPy");
  }
  const double own = median(times);
  state.counters["median_ms"] = own;
  state.counters["times_authors"] = authors_frame / own;
  state.counters["numpy_ms"] = numpy.frame;
  state.counters["times_numpy"] = numpy.frame / own;
}
BENCHMARK(see_through_frame)
    ->ArgName("percent")
    ->Arg(0)
    ->Arg(20)
    ->Arg(50)
    ->Arg(124)  // all of the image but its corners
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);

void covariance_normals(benchmark::State& state) {
  const auto depth = dimpled_ball(1.24);
  std::vector<double> times;
  for (auto _ : state) {
    times.push_back(milliseconds([&] {
      benchmark::DoNotOptimize(plane_fit_normals(depth, camera<float>(), radius).data());
    }));
    state.SetIterationTime(1e-3 * times.back());
  }
  const double own = median(times), numpy = numpy_frame(depth).normals;
  state.counters["median_ms"] = own;
  state.counters["times_authors"] = authors_normals / own;
  state.counters["numpy_ms"] = numpy;
  state.counters["times_numpy"] = numpy / own;
}
BENCHMARK(covariance_normals)->UseManualTime()->Unit(benchmark::kMillisecond)->MinTime(0.3);

// Springs

// A ball of 20 mm that touches, seen where it is above the gel.
Image<float> ball_above() {
  const auto eye = camera<double>();
  const double ball = 0.02;
  Image<float> depth(width, height, std::numeric_limits<float>::infinity());
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double r2 = gel_depth * gel_depth * (eye.ray(x, y).squaredNorm() - 1);
      if (r2 < ball * ball) {
        depth(x, y) = static_cast<float>(gel_depth + ball - std::sqrt(ball * ball - r2));
      }
    }
  }
  return depth;
}

// The displacement at which springs over sorted gaps bear a load, in units of a spring's stiffness.
double displacement_by_sorting(const Image<float>& depth, double load) {
  std::vector<double> gaps;
  for (const float z : depth.pixels()) {
    if (std::isfinite(z)) gaps.push_back(double{z - static_cast<float>(gel_depth)});
  }
  std::sort(gaps.begin(), gaps.end());
  double sum = 0, d = 0;
  for (std::size_t n = 1; n <= gaps.size(); ++n) {
    sum += gaps[n - 1];
    d = (load + sum) / static_cast<double>(n);
    if (n == gaps.size() || d <= gaps[n]) break;
  }
  return d;
}

enum class Solve { straight, tilting, taut };

void springs(benchmark::State& state, Solve solve) {
  const auto depth = ball_above();
  const Gel gel{.elastic_modulus = 5e4, .tension = solve == Solve::taut ? 5.0 : 0.0};
  const SpringBed<float> bed(camera<float>(), static_cast<float>(gel_depth), gel);
  constexpr double force = 2;
  SpringContact<float> contact;
  std::vector<double> times;
  for (auto _ : state) {
    times.push_back(milliseconds([&] {
      if (solve == Solve::tilting) {
        bed.press_tilting_into(contact, depth, force, {0.001, -0.002});
      } else {
        bed.press_into(contact, depth, force);
      }
    }));
    state.SetIterationTime(1e-3 * times.back());
  }
  const double residual = std::abs(contact.residual_force) / force;
  if (contact.equilibrium != Equilibrium::reached) return state.SkipWithError("no equilibrium");
  if (!(residual < (solve == Solve::taut ? 1e-9 : 1e-12))) return state.SkipWithError("residual");
  if (solve == Solve::straight) {
    const double load = force / (gel.stiffness() * bed.spring_area());
    const double error = std::abs(contact.displacement / displacement_by_sorting(depth, load) - 1);
    if (!(error < 1e-13)) return state.SkipWithError("wrong displacement");
    state.counters["error"] = error;
  }
  state.counters["median_ms"] = median(times);
  state.counters["residual"] = residual;
}
BENCHMARK_CAPTURE(springs, straight, Solve::straight)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);
BENCHMARK_CAPTURE(springs, tilting, Solve::tilting)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);
BENCHMARK_CAPTURE(springs, taut, Solve::taut)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(2);

}  // namespace
