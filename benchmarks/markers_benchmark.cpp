// How fast markers are: the field of 99 dots of a contact that is known, and their drawing.
//
// items_per_second counts fields, or images; largest_pixels is the farthest that a marker moves.
// The layer's field is an error where it is not the whole image's, sampled.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/markers.hpp"
#include "gelight/sensor/printed_dots.hpp"
#include "support/run.hpp"

namespace {

using namespace gelight;

constexpr double rest = 0.03, pitch = 6e-5;
const Camera<double> eye{rest / pitch, rest / pitch, 159.5, 119.5, 320, 240};

// A ball that sticks to the gel, pressed in and dragged.
const LayerContact<double>& contact() {
  static const LayerContact<double> dragged = [] {
    Image<double> depth(320, 240);
    for (Index y = 0; y < 240; ++y) {
      for (Index x = 0; x < 320; ++x) {
        const double r = std::hypot(x - 150, y - 125);
        depth(x, y) = rest - pitch * (6 - r * r / 250);
      }
    }
    const ElasticLayer layer(eye, rest, {1e5, 0.48, 80 * pitch, 1});
    return layer.press(depth, {.shift = {8 * pitch, 3 * pitch}});
  }();
  return dragged;
}

const std::vector<Vec2<double>>& dots() {
  static const auto pixels = dot_grid(11, 9, {20, 16}, {28, 26});
  return pixels;
}

void finish(benchmark::State& state, const std::vector<Vec2<double>>& moved) {
  double largest = 0;
  for (const auto& by : moved) largest = std::max(largest, by.norm());
  state.counters["largest_pixels"] = largest;
  state.SetItemsProcessed(state.iterations());
}

void layer_field(benchmark::State& state) {
  const Image<double> flat(320, 240, rest);
  const auto& displacement = contact().displacement;
  std::vector<Vec2<double>> moved;
  for (auto _ : state) {
    moved = marker_displacement(eye, flat, displacement, dots());
    benchmark::DoNotOptimize(moved.data());
  }
  const auto whole = sample_markers<double>(marker_displacement(eye, flat, displacement), dots());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if ((moved[i] - whole[i]).norm() > 1e-9) return state.SkipWithError("another field");
  }
  finish(state, moved);
}
BENCHMARK(layer_field)->Name("markers/field/layer");

template <class Field>
void closed_field(benchmark::State& state, const Field& field) {
  std::vector<Vec2<double>> moved(dots().size());
  for (auto _ : state) {
    std::transform(dots().begin(), dots().end(), moved.begin(), field);
    benchmark::DoNotOptimize(moved.data());
  }
  finish(state, moved);
}
void dragged_field(benchmark::State& state) {
  closed_field(state, DraggedMarkers::of_disc({150, 125}, {8, 3}, 38, 0.48));
}
BENCHMARK(dragged_field)->Name("markers/field/dragged");

void gaussian_field(benchmark::State& state) {
  GaussianMarkers gaussian{{}, {150, 125}, {8, 3}, 0, 1e-3, 3e-4, 3e-4};
  for (const auto& dot : dots()) {
    const double depth = 6 - (dot - gaussian.centre).squaredNorm() / 250;
    if (depth > 0) gaussian.touched.push_back({dot, 0.01 * depth});
  }
  closed_field(state, gaussian);
}
BENCHMARK(gaussian_field)->Name("markers/field/three Gaussians");

void drawing(benchmark::State& state) {
  const Image<double> flat(320, 240, rest);
  const auto moved = marker_displacement(eye, flat, contact().displacement);
  const PrintedDots printed(eye, flat, dots(), 4 * pitch);
  Image<Rgb8> image(320, 240);
  for (auto _ : state) {
    printed.draw_into(image, moved);
    benchmark::DoNotOptimize(image.row(0));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(drawing)->Name("markers/drawn")->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) { return gelight::bench::run(argc, argv); }
