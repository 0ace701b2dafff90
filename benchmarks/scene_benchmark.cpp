// No more than the scene needs: what each choice of a simulator's author changes in the images of a
// fingertip sensor, in grey levels, and what it costs.
//
// scene_benchmark [--tolerance=LEVELS] [--width=W] [--height=H] [--fov=DEGREES] [--leds=N]
// [--sensors=N] [--seed=S] prints,
// after the benchmarks, a table and for each topic the cheapest choice that leaves 99 % of the
// pixels that a contact changes within the tolerance (default 1) of the reference: edges of 0.4 mm,
// exact geodesic light at every pixel, Gaussian cut off at 8 sigma. Other light models are no
// approximations of that one; their rows say how much the choice of the model matters.
//
// Rows `scene/planned/...` are plan_sensor's, for sensors and contacts at random (--sensors=N,
// --seed=S; tests/support/random_sensors.hpp):
//   asked, kept   share of the pixels that contacts change to be within the request's `tolerance`,
//                 and that of 40 contacts that the planner had not tried
//   dearer        what the plan costs over what the cheapest costs of all that it might have
//                 chosen, among those that keep the share over 12 other contacts; 1: none is
//                 cheaper
//   plan_seconds  processor time to plan
// A sensor that could not be planned for has `refused`, 1.

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <span>
#include <stdexcept>

#include "../examples/support/press.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/fast_gaussian.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/image/similarity.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/pareto.hpp"
#include "support/random_sensors.hpp"

namespace {

using namespace pareto;
using Depth = Image<double>;
using Field = Image<Vec3<double>>;

constexpr double radius = 0.01146, length = 0.0455, press_depth = 0.002, sigma = 5;

struct Settings {
  double tolerance = 1, width = 640, height = 480, fov = 90, leds = 3;
  double sensors = 30, seed = 1;  // to plan for
};

enum class LightModel { geodesic, plane, transport, linear };
using Smoothing = std::function<Depth(const Depth&)>;

Smoothing cut_off_at(double sigmas) {
  return [=](const Depth& image) {
    return gaussian(image, sigma, static_cast<Index>(std::lround(sigmas * sigma)));
  };
}

/// Everything a simulator's author chooses.
struct Choice {
  double edge = 0.0004;
  LightModel light = LightModel::geodesic;
  Index coarser = 1;  // by how much the light field's grid is coarser than the image
  Smoothing smoothing = cut_off_at(8);
};

Field field_of(const Surface<double>& surface, const Vec3<double>& led, LightModel model,
               const Raster<double>& raster) {
  const auto points = pixel_points(raster);
  const Index vertex = nearest_vertex(surface, led);
  const auto source = vertex_point<double>(vertex);
  switch (model) {
    case LightModel::geodesic:
      return bake(geodesic_field<double>(ExactSolver<double>(surface), source, points), raster);
    case LightModel::plane:
      return bake(plane_field<double>(surface, source, points), raster);
    case LightModel::transport:
      return bake(radial_transport_field<double>(VectorHeatSolver<double>(surface), vertex, points),
                  raster);
    default:
      return bake(linear_field<double>(surface, led, points), raster);
  }
}

struct Frames {
  std::vector<Image<Rgb8>> images;
  std::vector<Image<Rgb8>> at_rest;
  double offline = 0, smoothing = 0;  // seconds
};

// Presses two objects into the sensor and takes its images.
Frames frames_of(const Settings& settings, const Choice& choice) {
  const auto camera = Camera<double>::from_vertical_fov(settings.fov * std::numbers::pi / 180,
                                                        static_cast<Index>(settings.width),
                                                        static_cast<Index>(settings.height));
  const auto coarse_camera = Camera<double>::from_vertical_fov(
      settings.fov * std::numbers::pi / 180, camera.width / choice.coarser,
      camera.height / choice.coarser);
  Frames frames;
  std::vector<Light<double>> lights;
  Depth rest;
  frames.offline = seconds([&] {
    const Surface<double> surface(membrane<double>(radius, length, choice.edge));
    rest = rasterize(surface, camera).depth;
    const auto raster = rasterize(surface, coarse_camera);
    const auto count = static_cast<int>(settings.leds);
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / count;
      const Vec3<double> led(radius * std::cos(angle), radius * std::sin(angle), 0);
      Field field = field_of(surface, led, choice.light, raster);
      if (choice.coarser > 1) field = resize_bilinear(field, camera.width, camera.height);
      Light<double> light{.direction = std::move(field), .rgb = {0, 0, 0}};
      light.rgb[static_cast<std::size_t>(k % 3)] = 1;
      lights.push_back(std::move(light));
    }
  });
  const TactileRenderer<double> renderer(
      camera, rest, lights, Background<double>(std::array<double, 3>{0.5, 0.5, 0.5}),
      {.smoothing_sigma = 0, .rectify = choice.light != LightModel::linear});
  const auto objects = objects_to_press();
  for (const std::size_t which : {std::size_t{0}, std::size_t{1}}) {
    const auto object =
        pressed(objects[which].object, radius, length, press_depth, 1.1, 2.1 * double(which));
    Depth depth = rasterize(object, camera).depth;
    frames.smoothing += seconds([&] {
      Depth protrusion(camera.width, camera.height);
      for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
        const double r = rest.pixels()[i];
        depth.pixels()[i] = std::min(depth.pixels()[i], r);
        protrusion.pixels()[i] = std::isfinite(r) ? r - depth.pixels()[i] : 0;
      }
      const Depth spread = choice.smoothing(protrusion);
      for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
        const double r = rest.pixels()[i];
        if (std::isfinite(r))
          depth.pixels()[i] = std::min(depth.pixels()[i], r - spread.pixels()[i]);
      }
    });
    frames.images.push_back(renderer.render(depth));
    frames.at_rest.push_back(renderer.rest_image());
  }
  frames.smoothing /= 2;
  return frames;
}

/// One row of the table: a choice, what it costs offline or per frame, and what it changes.
struct Row {
  std::string topic, name;
  Choice choice;
  bool is_model = false;  // another light model, no approximation of the reference's
  double milliseconds = 0, p99 = 0, worst = 0, ssim = 0;
};

std::vector<Row> rows() {
  std::vector<Row> all;
  for (const double mm : {4.0, 2.0, 1.0, 0.57}) {
    char name[32];
    std::snprintf(name, sizeof name, "%g mm", mm);
    all.push_back({"mesh edges", name, {.edge = 1e-3 * mm}});
  }
  for (const Index coarser : {32, 16, 8, 4, 2}) {
    all.push_back({"light field's grid", "1:" + std::to_string(coarser), {.coarser = coarser}});
  }
  const std::vector<std::pair<std::string, Smoothing>> smoothings{
      {"none", [](const Depth& image) { return Depth(image.width(), image.height(), 0.0); }},
      {"3 boxes", [](const Depth& image) { return gaussian_boxes(image, sigma, 3); }},
      {"5 boxes", [](const Depth& image) { return gaussian_boxes(image, sigma, 5); }},
      {"cut off at 2 sigma", cut_off_at(2)},
      {"cut off at 3 sigma", cut_off_at(3)},
      {"cut off at 4 sigma", cut_off_at(4)},
      {"recursive", [](const Depth& image) { return gaussian_recursive(image, sigma); }},
      {"pyramid", [](const Depth& image) { return gaussian_pyramid(image, sigma); }}};
  for (const auto& [name, smoothing] : smoothings) {
    all.push_back({"smoothing", name, {.smoothing = smoothing}});
  }
  all.push_back({"light model", "plane", {.light = LightModel::plane}, true});
  all.push_back({"light model", "transport", {.light = LightModel::transport}, true});
  all.push_back({"light model", "linear", {.light = LightModel::linear}, true});
  return all;
}

void measure(benchmark::State& state, const Settings& settings, const Frames& reference, Row& row) {
  Frames frames;
  std::vector<double> times;
  for (auto _ : state) {
    frames = frames_of(settings, row.choice);
    times.push_back(row.topic == "smoothing" ? frames.smoothing : frames.offline);
    state.SetIterationTime(times.back());
  }
  // Light along the membrane shows where something touches it: those pixels count.
  std::vector<int> levels;
  double sum = 0;
  row.ssim = 0;
  for (std::size_t i = 0; i < frames.images.size(); ++i) {
    const auto &ours = frames.images[i].pixels(), &best = reference.images[i].pixels();
    for (std::size_t p = 0; p < best.size(); ++p) {
      if (best[p] == reference.at_rest[i].pixels()[p]) continue;
      int off = 0;
      for (std::size_t c = 0; c < 3; ++c) off = std::max(off, std::abs(ours[p][c] - best[p][c]));
      levels.push_back(off);
      sum += off;
    }
    row.ssim += ssim(frames.images[i], reference.images[i]) / double(frames.images.size());
  }
  std::sort(levels.begin(), levels.end());
  row.p99 = levels[levels.size() * 99 / 100];
  row.worst = levels.back();
  row.milliseconds = 1e3 * median(times);
  state.counters["levels_p99"] = row.p99;
  state.counters["levels_mean"] = sum / double(levels.size());
  state.counters["levels_worst"] = row.worst;
  state.counters["ssim"] = row.ssim;
  state.counters["median_s"] = median(times);
  if (!(row.ssim > 0.3)) state.SkipWithError("the image is another one");
}

void print(const Settings& settings, const std::vector<Row>& all) {
  if (std::any_of(all.begin(), all.end(), [](const Row& row) { return row.ssim == 0; })) return;
  std::printf("\n%-20s %-22s %10s %9s %9s %8s\n", "topic", "choice", "ms", "99 %", "worst", "SSIM");
  for (const Row& row : all) {
    std::printf("%-20s %-22s %10.1f %9.0f %9.0f %8.4f\n", row.topic.c_str(), row.name.c_str(),
                row.milliseconds, row.p99, row.worst, row.ssim);
  }
  std::printf("\nEnough for %g grey levels (99 %% of the pixels that a contact changes):\n",
              settings.tolerance);
  for (const char* topic : {"mesh edges", "light field's grid", "smoothing"}) {
    const Row* enough = nullptr;
    for (const Row& row : all) {
      if (row.topic != topic || !(row.p99 <= settings.tolerance)) continue;
      if (enough == nullptr || row.milliseconds < enough->milliseconds) enough = &row;
    }
    std::printf("  %-20s %s\n", topic,
                enough != nullptr ? enough->name.c_str() : "none of these: finer is needed");
  }
  std::printf("Times: the light fields of all LEDs, once a sensor; smoothing: once a frame.\n");
}

/// What became of one sensor's plan.
struct Planned {
  bool is_refused = false;
  double asked = 0, kept = 0, dearer = 1, seconds = 0;
};

void plan(benchmark::State& state, std::uint32_t seed, int sensor, Planned& result) {
  test::SensorRandom random(1000 * seed + static_cast<std::uint32_t>(sensor));
  const SensorAt sensor_at = test::random_sensor(random);
  const SensorPlanRequest request = test::random_request(random);
  SensorPlan made;
  for (auto _ : state) {
    const std::clock_t before = std::clock();
    made = plan_sensor(sensor_at, request);
    result.seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    state.SetIterationTime(result.seconds);
  }
  result.asked = request.share;
  result.is_refused = !made.satisfies;
  state.counters["tolerance"] = request.tolerance;
  state.counters["asked"] = request.share;
  state.counters["plan_seconds"] = result.seconds;
  if (result.is_refused) {
    state.counters["refused"] = 1;
    return;
  }
  result.kept = test::seen_by(sensor_at, request, made, 40, random).share();
  const double cheapest = test::cheapest_in_hindsight(sensor_at, request, random(), made.cost);
  result.dearer = std::max(1.0, made.cost / cheapest);
  state.counters["kept"] = result.kept;
  state.counters["dearer"] = result.dearer;
  // What the tests hold it to.
  if (1 - result.kept > 2 * (1 - result.asked)) {
    state.SkipWithError("more than twice the pixels are off that may be");
  }
}

void print(const std::vector<Planned>& plans) {
  int planned = 0, kept = 0, cheap = 0;
  double most_lost = 0, dearest = 1, longest = 0;
  for (const Planned& one : plans) {
    longest = std::max(longest, one.seconds);
    if (one.is_refused || one.asked == 0) continue;  // not run
    ++planned;
    kept += one.kept >= one.asked ? 1 : 0;
    cheap += one.dearer <= 1.5 ? 1 : 0;
    most_lost = std::max(most_lost, (1 - one.kept) / (1 - one.asked));
    dearest = std::max(dearest, one.dearer);
  }
  if (planned == 0) return;
  std::printf(
      "\nPlanned for %d sensors of %zu at random: %d keep the share asked for (of the pixels that "
      "may\nbe off, at most %.2f times as many are); %d cost no more than 1.5 times the cheapest "
      "in\nhindsight, the dearest %.2f times; planned in %.2f s at most.\n",
      planned, plans.size(), kept, most_lost, cheap, dearest, longest);
}

double* setting(Settings& settings, const std::string& name) {
  if (name == "--tolerance") return &settings.tolerance;
  if (name == "--width") return &settings.width;
  if (name == "--height") return &settings.height;
  if (name == "--fov") return &settings.fov;
  if (name == "--leds") return &settings.leds;
  if (name == "--sensors") return &settings.sensors;
  if (name == "--seed") return &settings.seed;
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) try {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto equals = argument.find('=');
    double* value = setting(settings, argument.substr(0, equals));
    if (value == nullptr || equals == std::string::npos) continue;
    char* end = nullptr;
    *value = std::strtod(argument.c_str() + equals + 1, &end);
    if (*end != '\0' || end == argument.c_str() + equals + 1 || !(*value > 0 && *value <= 8192)) {
      throw std::runtime_error(argument + ": not a number above 0, to 8192");
    }
    std::copy(argv + i + 1, argv + argc, argv + i);
    --argc, --i;
  }
  const Frames reference = frames_of(settings, {});
  std::vector<Row> all = rows();
  for (Row& row : all) {
    benchmark::RegisterBenchmark(
        ("scene/" + row.topic + "/" + row.name).c_str(),
        [&](benchmark::State& state) { measure(state, settings, reference, row); })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  }
  std::vector<Planned> plans(static_cast<std::size_t>(settings.sensors));
  for (std::size_t i = 0; i < plans.size(); ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "scene/planned/seed %g, sensor %zu", settings.seed, i + 1);
    benchmark::RegisterBenchmark(name,
                                 [&, i](benchmark::State& state) {
                                   plan(state, static_cast<std::uint32_t>(settings.seed),
                                        static_cast<int>(i), plans[i]);
                                 })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  }
  const int result = run(argc, argv);
  print(settings, all);
  print(plans);
  return result;
} catch (...) {
  return told();
}
