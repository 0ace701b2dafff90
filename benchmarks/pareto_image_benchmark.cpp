// Speed against accuracy beyond distances: vector transport and log maps on spheres (angle to the
// truth), depth smoothing (error in depth), normals of a noisy depth map (angle), whole tactile
// frames (grey levels, SSIM). Time and error come from the same run; a wrong answer is an error.

#include <Eigen/Geometry>
#include <complex>
#include <functional>
#include <limits>
#include <optional>

#include "gelight/image/camera.hpp"
#include "gelight/image/fast_gaussian.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/plane_fit.hpp"
#include "gelight/image/similarity.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/transport/log_map.hpp"
#include "gelight/transport/parallel.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/pareto.hpp"

namespace {

using namespace pareto;
using benchmark::State;

constexpr double degrees = 180 / std::numbers::pi;
constexpr Index source = 130;

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Angles in degrees, and what mean of them is wrong.
class Angles {
 public:
  void add(double radians) { degrees_.push_back(degrees * radians); }
  void report(State& state, double wrong_beyond) const {
    report_spread(state, "angle_", degrees_);
    if (!(state.counters["angle_mean"] < wrong_beyond)) {
      state.SkipWithError("the directions are wrong");
    }
  }

 private:
  std::vector<double> degrees_;
};

/// Time and memory of a method: its set-up, the first query, which makes what is made late, and
/// each further one.
class Meter {
 public:
  explicit Meter(State& state) : state_(state) {}

  template <class Make>
  [[nodiscard]] auto set_up(const Make& make) {
    std::optional<decltype(make())> made;
    state_.counters["setup_s"] = seconds([&] { made.emplace(make()); });
    return std::move(*made);
  }

  template <class Work>
  void query(const Work& work) {
    state_.counters["first_s"] = seconds(work);
    std::vector<double> times;
    for (auto _ : state_) {
      times.push_back(seconds(work));
      state_.SetIterationTime(times.back());
    }
    state_.counters["median_s"] = median(times);
    state_.counters["peak_MB"] = memory_.megabytes();
  }

 private:
  State& state_;
  PeakMemory memory_;
};

// --- vectors on spheres --------------------------------------------------------------------------

Vec3<double> tangent_at(const Vec3<double>& pole) {
  return pole.cross(Vec3<double>(0.3, 1, 0.2)).normalized();
}

// Against transport along great circles; `carry` gives the vectors at all vertices.
template <class Carry>
void transport(State& state, Meter& meter, const Surface<double>& surface, const Carry& carry) {
  std::vector<Vec3<double>> carried;
  meter.query([&] { carried = carry(); });
  const Vec3<double> pole = surface.position(source).normalized(), start = tangent_at(pole);
  Angles off;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const Vec3<double> at = surface.position(v).normalized();
    if (v == source || (at + pole).norm() < 1e-6) continue;  // any direction is right there
    const Vec3<double> truth = Eigen::Quaterniond::FromTwoVectors(pole, at) * start;
    off.add(angle(truth, carried[static_cast<std::size_t>(v)]));
  }
  off.report(state, 3);
}

void transport_by_heat(State& state, int level) {
  const Surface<double> surface(icosphere<double>(level));
  Meter meter(state);
  const auto solver = meter.set_up([&] { return VectorHeatSolver<double>(surface); });
  const Vec3<double> start = tangent_at(surface.position(source).normalized());
  transport(state, meter, surface, [&] { return solver.transport(source, start); });
}

// One exact path to each vertex, and the vector carried along it.
void transport_by_paths(State& state, int level) {
  const Surface<double> surface(icosphere<double>(level));
  Meter meter(state);
  const auto [solver, along] = meter.set_up(
      [&] { return std::pair(ExactSolver<double>(surface), ParallelTransport<double>(surface)); });
  const Vec3<double> start = tangent_at(surface.position(source).normalized());
  transport(state, meter, surface, [&, &exact = solver, &parallel = along] {
    const auto field = exact.solve(source);
    std::vector<Vec3<double>> carried;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      carried.push_back(parallel.along(field.path(v), start));
    }
    return carried;
  });
}

// Directions against those of great circles in the plane that touches the sphere; the turn between
// the two planes' axes, which the mesh leaves open, is taken out.
template <class Map>
void log_map(State& state, Meter& meter, const Surface<double>& surface,
             const std::array<Vec3<double>, 2>& basis, const Map& map) {
  std::vector<Vec2<double>> places;
  meter.query([&] { places = map(); });
  const Vec3<double> pole = surface.position(source).normalized();
  std::vector<std::complex<double>> turns;
  std::complex<double> sum = 0;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const Vec3<double> at = surface.position(v).normalized();
    if (v == source || (at + pole).norm() < 1e-6) continue;
    const Vec3<double> way = (at - at.dot(pole) * pole).normalized();
    const std::complex<double> truth(way.dot(basis[0]), way.dot(basis[1]));
    const auto& p = places[static_cast<std::size_t>(v)];
    turns.push_back(std::complex<double>(p[0], p[1]) / (p.norm() * truth));
    sum += turns.back() / std::abs(turns.back());
  }
  Angles off;
  for (const auto& turn : turns) off.add(std::abs(std::arg(turn * std::conj(sum))));
  off.report(state, 5);
}

void log_map_by_heat(State& state, int level) {
  const Surface<double> surface(icosphere<double>(level));
  Meter meter(state);
  const auto solver = meter.set_up([&] { return VectorHeatSolver<double>(surface); });
  log_map(state, meter, surface, solver.tangent_basis(source),
          [&] { return solver.log_map(source); });
}

void log_map_exact(State& state, int level) {
  const Surface<double> surface(icosphere<double>(level));
  Meter meter(state);
  const auto solver = meter.set_up([&] { return ExactLogMapSolver<double>(surface); });
  log_map(state, meter, surface, solver.tangent_basis(source),
          [&] { return solver.log_map(source); });
}

// --- images --------------------------------------------------------------------------------------

constexpr Index width = 640, height = 480;

template <class T>
Camera<T> camera() {
  return Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 2, width, height);
}

// A ball pressed into a plane 30 mm away.
template <class T>
Image<T> contact() {
  Image<T> depth(width, height, T(0.03));
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double dx = (x - 300) / 90.0, dy = (y - 250) / 90.0;
      depth(x, y) -= static_cast<T>(0.004 * std::max(0.0, 1 - dx * dx - dy * dy));
    }
  }
  return depth;
}

template <class Smooth>
void smoothing(State& state, double sigma, const Smooth& smooth) {
  const Image<float> depth = contact<float>();
  Image<float> smoothed(width, height);
  Meter(state).query([&] { smoothed = smooth(depth); });
  const auto truth = gaussian(contact<double>(), sigma, static_cast<Index>(std::ceil(9 * sigma)));
  std::vector<double> off;  // as shares of the depth's range
  for (std::size_t i = 0; i < truth.pixels().size(); ++i) {
    off.push_back(std::abs(double{smoothed.pixels()[i]} - truth.pixels()[i]) / 0.004);
  }
  report_spread(state, "depth_", off);
  if (!(state.counters["depth_max"] < 0.04)) state.SkipWithError("the depth is wrong");
}

// A ball of 20 mm at 40 mm, seen with noise of 10 micrometres.
template <class Find>
void normals(State& state, const Find& find) {
  const auto view = camera<float>();
  const Vec3<double> centre(0, 0, 0.04);
  constexpr double radius = 0.02;
  Image<float> depth(width, height, std::numeric_limits<float>::quiet_NaN());
  Image<Vec3<double>> truth(width, height, Vec3<double>::Zero());
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1e-5);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const Vec3<double> ray = camera<double>().ray(x, y);
      const double b = ray.dot(centre), a = ray.squaredNorm();
      const double inside = b * b - a * (centre.squaredNorm() - radius * radius);
      if (inside < 0.05 * b * b) continue;  // and none too slanting
      const double z = (b - std::sqrt(inside)) / a;
      depth(x, y) = static_cast<float>(z + noise(random));
      truth(x, y) = (z * ray - centre).normalized();
    }
  }
  Image<Vec3<float>> found;
  Meter(state).query([&] { found = find(depth, view); });
  Angles off;
  for (std::size_t i = 0; i < truth.pixels().size(); ++i) {
    const Vec3<double> n = found.pixels()[i].template cast<double>();
    if (!truth.pixels()[i].isZero(0) && !n.isZero(0)) off.add(angle(truth.pixels()[i], n));
  }
  off.report(state, 20);
}

template <class T>
TactileRenderer<T> renderer(Index radius) {
  std::vector<Light<T>> lights;
  for (int k = 0; k < 3; ++k) {
    const double turn = 2 * std::numbers::pi * k / 3;
    const Vec3<double> travel = Vec3<double>(std::cos(turn), std::sin(turn), 0.3).normalized();
    Light<T> light{.direction = Image<Vec3<T>>(width, height, travel.cast<T>()), .rgb = {0, 0, 0}};
    light.rgb[static_cast<std::size_t>(k)] = 1;
    lights.push_back(std::move(light));
  }
  return {camera<T>(), Image<T>(width, height, T(0.03)), lights,
          Background<T>(std::array<double, 3>{0.5, 0.5, 0.5}),
          TactileOptions{.smoothing_radius = radius, .skip_unchanged = false}};
}

// Against double precision with a Gaussian cut off at 8 sigma.
template <class T>
void frame(State& state, Index radius) {
  Meter meter(state);
  const auto render = meter.set_up([&] { return renderer<T>(radius); });
  const Image<T> depth = contact<T>();
  Image<Rgb8> out(width, height);
  meter.query([&] { render.render_into(out, depth); });
  const auto truth = renderer<double>(40).render(contact<double>());
  std::vector<double> levels;
  for (std::size_t i = 0; i < truth.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      levels.push_back(std::abs(out.pixels()[i][c] - truth.pixels()[i][c]));
    }
  }
  report_spread(state, "levels_", levels);
  state.counters["ssim"] = ssim(out, truth);
  if (state.counters["levels_max"] > 40) state.SkipWithError("the image is wrong");
}

void add(const std::string& name, const std::function<void(State&)>& body) {
  benchmark::RegisterBenchmark(name.c_str(), body)->UseManualTime()->Unit(benchmark::kMillisecond);
}

void add_vectors() {
  for (const int level : {4, 5, 6}) {
    const std::string vertices = std::to_string(10 * (1 << (2 * level)) + 2) + " vertices";
    add("transport/vector heat/" + vertices, [=](State& s) { transport_by_heat(s, level); });
    add("log_map/vector heat/" + vertices, [=](State& s) { log_map_by_heat(s, level); });
    if (level == 6) continue;
    add("transport/exact paths/" + vertices, [=](State& s) { transport_by_paths(s, level); });
    add("log_map/exact/" + vertices, [=](State& s) { log_map_exact(s, level); });
  }
}

void add_smoothing(double sigma) {
  const auto add_one = [&](const std::string& method, auto smooth) {
    add("smoothing/" + method + "/sigma " + std::to_string(std::lround(sigma)),
        [=](State& s) { smoothing(s, sigma, smooth); });
  };
  for (const int sigmas : {2, 3, 4}) {
    add_one("cut off at " + std::to_string(sigmas) + " sigma", [=](const Image<float>& image) {
      return gaussian(image, sigma, static_cast<Index>(std::lround(sigmas * sigma)));
    });
  }
  add_one("recursive", [=](const Image<float>& i) { return gaussian_recursive(i, sigma); });
  add_one("3 boxes", [=](const Image<float>& i) { return gaussian_boxes(i, sigma, 3); });
  add_one("5 boxes", [=](const Image<float>& i) { return gaussian_boxes(i, sigma, 5); });
  add_one("pyramid", [=](const Image<float>& i) { return gaussian_pyramid(i, sigma); });
}

void add_normals() {
  using Depth = Image<float>;
  using View = Camera<float>;
  const auto add_one = [](const std::string& name, auto find) {
    add("normals/" + name, [=](State& s) { normals(s, find); });
  };
  add_one("central/3 x 3", [](const Depth& d, const View& c) { return central_normals(d, c); });
  add_one("Sobel/3 x 3", [](const Depth& d, const View& c) { return sobel_normals(d, c); });
  for (const Index r : {1, 2, 4, 8}) {
    const std::string side = std::to_string(2 * r + 1);
    add_one("plane fit/" + side + " x " + side,
            [=](const Depth& d, const View& c) { return plane_fit_normals(d, c, r); });
  }
}

void add_frames() {
  for (const Index radius : {5, 10, 15, 20}) {
    const std::string cut = "cut off at " + std::to_string(radius / 5) + " sigma";
    add("frame/float/" + cut, [=](State& s) { frame<float>(s, radius); });
    add("frame/double/" + cut, [=](State& s) { frame<double>(s, radius); });
  }
}

}  // namespace

int main(int argc, char** argv) try {
  add_vectors();
  for (const double sigma : {5.0, 20.0}) add_smoothing(sigma);
  add_normals();
  add_frames();
  return run(argc, argv);
} catch (...) {
  return told();
}
