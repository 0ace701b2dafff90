// What each membrane model is off from the converged elastic layer, and what it takes: as JSON, a
// row for each shape, gel and model. Lengths are in pixels, errors of the surface in percent of the
// press, of normals in degrees, within 2.5 contact radii; milliseconds are the least of a few.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/pyramid.hpp"

namespace {

using namespace gelight;

constexpr double rest = 0.03, pitch = 1e-4, press_depth = 3;
constexpr double inf = std::numeric_limits<double>::infinity();

struct Shape {
  const char* name;
  double radius;  // of the contact, roughly
  std::function<double(double, double)> overlap;
};

struct Error {
  double surface = 0, mean = 0, most = 0;
};

Camera<double> camera() { return {rest / pitch, rest / pitch, 159.5, 119.5, 320, 240}; }

Vec3<double> normal(const Image<double>& z, Index x, Index y) {
  return Vec3<double>((z(x + 1, y) - z(x - 1, y)) / (2 * pitch),
                      (z(x, y + 1) - z(x, y - 1)) / (2 * pitch), 1)
      .normalized();
}

Error compare(const Image<double>& surface, const Image<double>& truth, double reach) {
  Error error;
  std::vector<double> angles;
  for (Index y = 1; y < 239; ++y) {
    for (Index x = 1; x < 319; ++x) {
      if (std::hypot(x - 159.5, y - 119.5) > reach) continue;
      const double off = (surface(x, y) - truth(x, y)) / (press_depth * pitch);
      error.surface += off * off;
      const double cosine = normal(surface, x, y).dot(normal(truth, x, y));
      angles.push_back(std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi);
      error.mean += angles.back();
    }
  }
  const auto count = static_cast<double>(angles.size());
  std::sort(angles.begin(), angles.end());
  error.surface = 100 * std::sqrt(error.surface / count);
  error.mean /= count;
  error.most = angles[angles.size() * 95 / 100];
  return error;
}

// What goes before a row.
const char* separator() {
  static bool is_first = true;
  return std::exchange(is_first, false) ? "" : ",\n";
}

template <class Make>
void print(const std::string& model, const Shape& shape, const Gel& gel, const Image<double>& truth,
           const Make& make) {
  Image<double> surface;
  double least = inf;
  for (int i = 0; i < 3; ++i) {
    const auto start = std::chrono::steady_clock::now();
    surface = make();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count());
  }
  const Error error = compare(surface, truth, std::min(115.0, 2.5 * shape.radius));
  std::printf(
      "%s  {\"shape\": \"%s\", \"nu\": %.2f, \"thickness\": %.4g, \"model\": \"%s\", \"ms\": %.3f,"
      " \"surface_percent\": %.3f, \"normals_degrees\": %.4f, \"normals_95_degrees\": %.3f}",
      separator(), shape.name, gel.poisson_ratio,
      std::isfinite(gel.thickness) ? gel.thickness / pitch : -1, model.c_str(), least,
      error.surface, error.mean, error.most);
}

// One frame after the first.
template <class Membrane>
auto frame(const Membrane& membrane, const Image<double>& depth, const Image<double>& gel) {
  return [&membrane, &depth, &gel, work = membrane.make_workspace(320, 240),
          out = Image<double>(320, 240)]() mutable {
    membrane.press_into(out, {depth.view(), gel.view(), {0, 0, 320, 240}}, work);
    return out;
  };
}

template <class Membrane>
void print_membrane(const char* model, const Shape& shape, const Gel& gel,
                    const Image<double>& truth, const Image<double>& depth,
                    const Membrane& membrane) {
  const Image<double> untouched(320, 240, rest);
  auto next = frame(membrane, depth, untouched);
  print(model, shape, gel, truth, [&] { return next(); });
}

void print_models(const Shape& shape, const Gel& gel) {
  Image<double> depth(320, 240);
  for (Index y = 0; y < 240; ++y) {
    for (Index x = 0; x < 320; ++x) {
      depth(x, y) = rest - pitch * shape.overlap(x - 159.7, y - 119.2);
    }
  }
  const auto layer = [&](double tolerance) {
    return ElasticLayer(camera(), rest, gel, {.tolerance = tolerance, .sideways = false});
  };
  const Image<double> truth = layer(2e-4).press(depth).depth;
  const double sigma = gaussian_sigma(gel, shape.radius * pitch) / pitch;
  const std::vector<double> taxim{15, 7, 3};
  print_membrane("gaussian of sigma 5", shape, gel, truth, depth, GaussianMembrane<double>());
  print_membrane("gaussian of the gel", shape, gel, truth, depth,
                 GaussianMembrane<double>(sigma, static_cast<Index>(std::ceil(4 * sigma))));
  print_membrane("pyramid", shape, gel, truth, depth, PyramidMembrane<double>(taxim));
  print_membrane("flat GelSight", shape, gel, truth, depth, FlatGelSightMembrane<double>());
  for (const int kernels : {2, 4}) {
    print_membrane(kernels == 2 ? "bulging, 2 kernels" : "bulging", shape, gel, truth, depth,
                   BulgingMembrane<double>(camera(), rest, gel, {.kernels = kernels}));
  }
  for (const double tolerance : {3e-2, 3e-3}) {
    print(tolerance > 0.01 ? "layer to 3 %" : "layer to 0.3 %", shape, gel, truth,
          [&] { return layer(tolerance).press(depth).depth; });
  }
}

}  // namespace

int main() {
  const auto ball = [](double radius, double x0) {
    return [=](double x, double y) {
      return press_depth * (1 - ((x - x0) * (x - x0) + y * y) / (2 * radius * radius));
    };
  };
  const std::vector<Shape> shapes{
      {"ball", 30, ball(30, 0)},
      {"edge", 30,
       [](double x, double y) {
         const double u = 0.955 * x + 0.296 * y, v = 0.955 * y - 0.296 * x;
         return std::abs(v) < 50 ? press_depth * (1 - std::abs(u) / 30) : -inf;
       }},
      {"grating", 30,
       [=](double x, double y) { return ball(30, 0)(x, y) + 0.4 * std::cos(x / 2.5); }},
      {"two points", 13,
       [=](double x, double y) { return std::max(ball(13, -20)(x, y), ball(13, 20)(x, y)); }}};
  std::printf("[\n");
  for (const double nu : {0.3, 0.45, 0.49, 0.5}) {
    for (const double share : {0.35, 1.0, 4.0, inf}) {
      for (const Shape& shape : shapes)
        print_models(shape, {1e5, nu, share * shape.radius * pitch});
    }
  }
  std::printf("\n]\n");
}
