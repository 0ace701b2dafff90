// The four light fields of a fingertip sensor, three LEDs, for each of 640 x 480 pixels: from the
// mesh to the baked images, set-up and all, and each field by itself. On a membrane of about 14,000
// vertices made here, and on the GelTip's own mesh where the reference data is. The GelTip authors'
// scripts take 2 to 3 hours an LED at 160 x 120 pixels; one propagation of windows by Mitchell,
// Mount and Papadimitriou an LED, with a trace to each of these pixels, takes about 1 s.
//
// Every run is checked: directions have unit length, and at some pixels are those of other ways to
// the same answer. A wrong answer is an error.

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/transport/parallel.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "gelight/views/openmesh.hpp"
#include "support/run.hpp"

namespace {

using namespace gelight;

constexpr int pixels_wide = 640, pixels_high = 480;
const std::string geltip_mesh = std::string(GELIGHT_REFERENCE_DIR) + "/geltip/membrane.stl";

// Argument 0 of each benchmark: a membrane made here, or the GelTip's.
bool is_absent(benchmark::State& state) {
  if (state.range(0) == 0 || std::filesystem::exists(geltip_mesh)) return false;
  gelight::bench::leave_out(state, "there is no reference data");
  return true;
}

Surface<double> membrane_of(const benchmark::State& state) {
  if (state.range(0) == 0) return Surface<double>(membrane<double>(0.01146, 0.0455, 0.00052));
  OpenMesh::TriMesh_ArrayKernelT<> mesh;
  OpenMesh::IO::read_mesh(mesh, geltip_mesh);
  return Surface<double>(mesh);
}

Camera<double> camera() {
  return Camera<double>::from_vertical_fov(std::numbers::pi / 2, pixels_wide, pixels_high);
}

std::array<Index, 3> led_vertices(const Surface<double>& surface) {
  std::array<Index, 3> leds{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double turn = 2 * std::numbers::pi / 3 * static_cast<double>(k);
    leds[k] = nearest_vertex<double>(surface, {0.012 * std::cos(turn), 0.012 * std::sin(turn), 0});
  }
  return leds;
}

using Points = std::vector<SurfacePoint<double>>;
const Vec3<double> towards_tip(0, 0, 1);

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

bool is_unit(const LightField<double>& field) {
  return std::all_of(field.begin(), field.end(),
                     [](const Vec3<double>& d) { return std::abs(d.norm() - 1) < 1e-9; });
}

// The geodesic field's largest angle to searches back to the LED that keep no windows.
double geodesic_error(const ExactSolver<double>& solver, Index led, const Points& points,
                      const LightField<double>& field) {
  const auto by_search = solver.solve(led);
  double worst = 0;
  for (std::size_t i = 11; i < points.size(); i += points.size() / 20) {
    worst = std::max(worst, angle(field[i], by_search.direction(points[i])));
  }
  return worst;
}

// The plane field's, to each point's own plane.
double plane_error(const Surface<double>& surface, Index led, const Points& points,
                   const LightField<double>& field) {
  const SurfacePoint<double> source = vertex_point<double>(led);
  Points some;
  LightField<double> found;
  for (std::size_t i = 11; i < points.size(); i += points.size() / 20) {
    some.push_back(points[i]);
    found.push_back(field[i]);
  }
  const auto rays = plane_rays<double>(surface, std::span(&source, 1), some);
  double worst = 0;
  for (std::size_t i = 0; i < some.size(); ++i) {
    worst = std::max(worst, angle(found[i], rays.direction[i]));
  }
  return worst;
}

// The transport field's mean angle, to exact transport along geodesics.
double transport_error(const ExactSolver<double>& solver, Index led, const Points& points,
                       const LightField<double>& field) {
  const ParallelTransport<double> exact(solver.surface());
  const auto paths = solver.solve(led, {.keep_windows = true});
  double mean = 0;
  int count = 0;
  for (std::size_t i = 11; i < points.size(); i += points.size() / 100, ++count) {
    mean += angle(field[i], exact.along(paths.path(points[i]), towards_tip));
  }
  return mean / count;
}

void four_fields(benchmark::State& state) {
  if (is_absent(state)) return;
  const auto surface = membrane_of(state);
  const auto leds = led_vertices(surface);
  Points points;
  std::array<LightField<double>, 12> fields;
  std::array<Image<Vec3<double>>, 12> baked;
  for (auto _ : state) {
    const auto raster = rasterize(surface, camera());
    points = pixel_points(raster);
    const ExactSolver<double> exact(surface);
    const VectorHeatSolver<double> heat(surface);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto led = vertex_point<double>(leds[k]);
      fields[k] = linear_field<double>(surface, surface.position(leds[k]), points);
      fields[3 + k] = plane_field<double>(surface, led, points);
      fields[6 + k] = geodesic_field<double>(exact, led, points);
      fields[9 + k] = transport_field<double>(heat, leds[k], towards_tip, points);
    }
    for (std::size_t k = 0; k < 12; ++k) baked[k] = bake(fields[k], raster);
    benchmark::DoNotOptimize(baked);
  }
  state.counters["vertices"] = surface.vertex_count();
  state.counters["pixels"] = static_cast<double>(points.size());
  const ExactSolver<double> exact(surface);
  const double off = geodesic_error(exact, leds[0], points, fields[6]);
  const double plane_off = plane_error(surface, leds[0], points, fields[3]);
  const double degrees =
      transport_error(exact, leds[0], points, fields[9]) * 180 / std::numbers::pi;
  state.counters["geodesic_max_rad"] = off;
  state.counters["plane_max_rad"] = plane_off;
  state.counters["transport_mean_deg"] = degrees;
  const bool all_unit = std::all_of(fields.begin(), fields.end(), is_unit);
  if (!all_unit || !(off < 1e-6) || !(plane_off < 1e-6) || !(degrees < 1)) {
    state.SkipWithError("a field is wrong");
  }
}
BENCHMARK(four_fields)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

// One field for one LED, with the solvers made already.
template <class MakeField>
void one_field(benchmark::State& state, const MakeField& make) {
  if (is_absent(state)) return;
  const auto surface = membrane_of(state);
  const auto led = led_vertices(surface)[0];
  const auto points = pixel_points(rasterize(surface, camera()));
  const auto field_of = make(surface, led, points);
  LightField<double> field;
  for (auto _ : state) {
    field = field_of();
    benchmark::DoNotOptimize(field);
  }
  state.counters["a_pixel"] = benchmark::Counter(
      static_cast<double>(points.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  if (!is_unit(field)) state.SkipWithError("the field is wrong");
}

void linear(benchmark::State& state) {
  one_field(state, [](const auto& surface, Index led, const Points& points) {
    return [&, led] { return linear_field<double>(surface, surface.position(led), points); };
  });
}
BENCHMARK(linear)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

void plane(benchmark::State& state) {
  one_field(state, [](const auto& surface, Index led, const Points& points) {
    return [&, led] { return plane_field<double>(surface, vertex_point<double>(led), points); };
  });
}
BENCHMARK(plane)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

void geodesic(benchmark::State& state) {
  one_field(state, [](const auto& surface, Index led, const Points& points) {
    return [&, led, solver = ExactSolver<double>(surface)] {
      return geodesic_field<double>(solver, vertex_point<double>(led), points);
    };
  });
}
BENCHMARK(geodesic)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

void transport(benchmark::State& state) {
  one_field(state, [](const auto& surface, Index led, const Points& points) {
    return [&, led, solver = VectorHeatSolver<double>(surface)] {
      return transport_field<double>(solver, led, towards_tip, points);
    };
  });
}
BENCHMARK(transport)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

}  // namespace
