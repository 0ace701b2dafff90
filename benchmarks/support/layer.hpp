#pragma once

// Presses of an elastic layer with one Fourier backend: a ball whose contact on a half-space is 40
// pixels in radius, at 320 x 240.
//
// Milliseconds with the set-up and without; convolutions; surface_percent, the largest difference
// from the same press to a hundredth of the tolerance, as a share of the press, which is an error
// beyond 0.2; for the half-space the differences from Hertz of force, largest pressure and the
// contact's radius (by its area), and finer_*, the same to a hundredth of the tolerance.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "gelight/membrane/layer.hpp"

namespace gelight::bench {

struct LayerCase {
  const char* name;
  double poisson_ratio, thickness;  // in pixels
  bool sets_up, sideways;
  double friction = 0, shift = 0;  // in pixels
  bool by_force = false;
};

// How far a contact of no friction on a half-space is from Hertz's, in per cent.
inline void compare_with_hertz(benchmark::State& state, const std::string& how,
                               const LayerContact<double>& contact, double force, double radius,
                               double pixel) {
  double largest = 0, area = 0;
  for (const double p : contact.pressure.pixels()) {
    largest = std::max(largest, p);
    area += p > 0;
  }
  const double most = 1.5 * force / (std::numbers::pi * std::pow(radius * pixel, 2));
  state.counters[how + "convolutions"] = contact.convolutions;
  state.counters[how + "force_percent"] = 100 * (-contact.force.z() / force - 1);
  state.counters[how + "pressure_percent"] = 100 * (largest / most - 1);
  state.counters[how + "radius_percent"] = 100 * (std::sqrt(area / std::numbers::pi) / radius - 1);
}

inline void press_layer(benchmark::State& state, const LayerCase& what, FourierBackend backend) {
  constexpr double pitch = 6e-5, rest = 0.03, radius = 40, press = 4, modulus = 1e5;
  const Camera<double> eye{rest / pitch, rest / pitch, 159.5, 119.5, 320, 240};
  Image<double> depth(320, 240);
  for (Index v = 0; v < 240; ++v) {
    for (Index u = 0; u < 320; ++u) {
      const double x = u - 160.2, y = v - 120.4;
      depth(u, v) = rest - press * pitch * (1 - (x * x + y * y) / (2 * radius * radius));
    }
  }
  const double nu = what.poisson_ratio;
  const double hertz = 4.0 / 3 * modulus / (1 - nu * nu) * radius * press * pitch * pitch;
  const Gel gel{modulus, nu, what.thickness * pitch, what.friction};
  LayerLoad load;
  load.shift.x() = what.shift * pitch;
  if (what.by_force) load.force = 1.1 * hertz;
  const LayerOptions options{.sideways = what.sideways, .fourier = backend};
  const ElasticLayer layer(eye, rest, gel, options);
  auto contact = layer.press(depth, load);
  for (auto _ : state) {
    contact = what.sets_up ? ElasticLayer(eye, rest, gel, options).press(depth, load)
                           : layer.press(depth, load);
  }
  auto exact_options = options;
  exact_options.tolerance /= 100;
  const auto exact = ElasticLayer(eye, rest, gel, exact_options).press(depth, load);
  double off = 0;
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    off = std::max(off, std::abs(contact.indentation.pixels()[i] - exact.indentation.pixels()[i]));
  }
  off *= 100 / (press * pitch);
  state.counters["convolutions"] = contact.convolutions;
  state.counters["surface_percent"] = off;
  if (std::isinf(what.thickness) && !what.by_force) {
    compare_with_hertz(state, "", contact, hertz, radius, pitch);
    compare_with_hertz(state, "finer_", exact, hertz, radius, pitch);
  }
  if (!contact.converged || off > 0.2) state.SkipWithError("not as exact as asked");
}

inline void register_layer(const std::string& name, FourierBackend backend) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const LayerCase& what : {LayerCase{"half_space/with_setup", 0.3, inf, true, false},
                                {"half_space", 0.3, inf, false, false},
                                {"half_space/three_components", 0.3, inf, false, true},
                                {"layer/with_setup", 0.48, 40, true, false},
                                {"layer", 0.48, 40, false, false},
                                {"thin_layer", 0.5, 10, false, false},
                                {"layer/by_force", 0.48, 40, false, false, 0, 0, true},
                                {"layer/sticks", 0.48, 40, false, true, inf, 3},
                                {"layer/slips_in_part", 0.48, 40, false, true, 0.5, 3},
                                {"layer/slips", 0.48, 40, false, true, 0.1, 1000},
                                {"layer/slips_and_couples", 0, 40, false, true, 1, 1000}}) {
    benchmark::RegisterBenchmark((name + "/" + what.name).c_str(), [=](benchmark::State& state) {
      press_layer(state, what, backend);
    })->Unit(benchmark::kMillisecond);
  }
}

}  // namespace gelight::bench
