// A new sensor shape in thirty lines: a fingertip dome, a cat's paw, a flat pad.
//
//          camera            A shape is a depth over the sensor's round base, seen from inside:
//        \    |    /             mesh -> depth of the membrane at rest, and what each pixel shows
//     LED \___|___/ LED          LEDs -> light along the membrane to each of those points
//             ^                  both -> a renderer; then every frame is one call.
//          o o o o o         object, here the same knobs for all

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gelight/image/raster.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Vec3;
using Mesh = gelight::Mesh<double>;
constexpr double base_radius = 0.012;  // of the base, in metres like all lengths
constexpr double knob_radius = 0.0012;

// --- the shapes: how far the membrane is from the camera, (x, y) from the middle of the base -----

double dome(double x, double y) { return 0.012 + std::sqrt(0.014 * 0.014 - x * x - y * y); }

double paw(double x, double y) {
  const auto pad = [&](double at_x, double at_y, double size) {
    return 0.003 * std::exp(-(std::pow(x - at_x, 2) + std::pow(y - at_y, 2)) / (size * size));
  };
  return 0.019 + pad(0, -0.003, 0.0045) + pad(-0.007, 0.001, 0.0026) + pad(0.007, 0.001, 0.0026) +
         pad(-0.003, 0.0065, 0.0028) + pad(0.003, 0.0065, 0.0028);
}

double flat(double, double) { return 0.022; }

// --- a sensor of any shape -----------------------------------------------------------------------

Mesh membrane(double (*shape)(double, double)) {
  std::vector<gelight::ProfilePoint<double>> rings;
  for (int i = 30; i >= 0; --i) rings.push_back({base_radius * i / 30, 0});
  Mesh mesh = gelight::revolve<double>(rings, base_radius / 30);
  for (auto& [x, y, z] : mesh.positions) z = shape(x, y);
  return mesh;
}

std::vector<gelight::Light<double>> lights(const Mesh& mesh, const gelight::Raster<double>& rest) {
  const auto points = gelight::pixel_points(rest);
  const gelight::ExactSolver solver(mesh);
  std::vector<gelight::Light<double>> lights(3);
  for (gelight::Index k = 0; k < 3; ++k) {
    // The rim is the first ring of 188 vertices; the LEDs stand a third of it apart.
    const auto led = gelight::vertex_point<double>(63 * k);
    auto& light = lights[static_cast<std::size_t>(k)];
    light.direction = gelight::bake(gelight::geodesic_field<double>(solver, led, points), rest);
    light.rgb = {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
    light.diffuse = 0.7;
  }
  return lights;
}

// --- what presses: knobs in rows, 0.8 mm into the foremost of the membrane -----------------------

std::vector<Vec3<double>> knobs(const Mesh& mesh) {
  double front = 0;
  for (const auto& [x, y, z] : mesh.positions) front = std::max(front, z);
  std::vector<Vec3<double>> middles;
  for (int i = 0; i < 49; ++i) {
    const double x = 0.003 * (i % 7 - 3), y = 0.003 * (i / 7 - 3);
    if (std::hypot(x, y) < base_radius) {
      middles.emplace_back(x, y, front - 0.0008 + knob_radius);
    }
  }
  return middles;
}

// --- all three of them ---------------------------------------------------------------------------

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "sensor_shapes");
  const auto camera = gelight::Camera<double>::from_vertical_fov(0.95, 240, 240);
  const std::array<std::pair<const char*, double (*)(double, double)>, 3> shapes{
      {{"fingertip dome", dome}, {"cat's paw", paw}, {"flat pad", flat}}};

  Figure figure(1000, 612);
  double left = 20;
  bool is_still = true;
  std::vector<int> felt;
  double bend = 0;
  for (const auto& [name, shape] : shapes) {
    const Mesh mesh = membrane(shape);
    const auto rest = gelight::rasterize(mesh, camera);
    const auto leds = lights(mesh, rest);
    const gelight::TactileRenderer<double> sensor(
        camera, rest.depth, leds, std::array{0.5, 0.5, 0.5}, {.rectify = true, .ambient = 0.9});
    std::vector<Mesh> board;
    felt.push_back(0);
    for (const auto& middle : knobs(mesh)) {
      board.push_back(gelight::placed<double>(gelight::icosphere<double>(3, knob_radius),
                                              Eigen::Matrix3d::Identity(), middle));
      const double top = middle.z() - knob_radius;
      if (top < shape(middle.x(), middle.y())) ++felt.back();
    }
    const auto depth = gelight::rasterize(gelight::joined<double>(board), camera).depth;
    const auto image = sensor.render(depth);

    is_still = is_still && sensor.render(rest.depth) == sensor.rest_image();
    if (shape == flat) {
      const gelight::Surface<double> surface(mesh);
      const auto straight = gelight::bake(
          gelight::linear_field<double>(surface, surface.position(0), gelight::pixel_points(rest)),
          rest);
      for (std::size_t i = 0; i < straight.pixels().size(); ++i) {
        bend = std::max(bend, (straight.pixels()[i] - leds[0].direction.pixels()[i]).norm());
      }
    }

    const View view(mesh, {left, 50, 300, 210}, 0.5, 1.05);
    view.paint(figure, [](const auto&) { return Colour{0.93, 0.90, 0.80}; });
    figure.image(image, left + 30, 300);
    figure.text(name, left + 150, 24, 18);
    figure.text(
        "feels " + std::to_string(felt.back()) + " of " + std::to_string(board.size()) + " knobs",
        left + 150, 557, 14);
    left += 330;
  }
  lesson.expect(is_still, "without contact every sensor shows its image at rest");
  lesson.expect(bend < 1e-6, "in the flat pad light along the membrane is straight");
  lesson.expect(felt[2] == 45 && felt[0] < felt[2] && felt[1] < felt[0],
                "the pad feels every knob, the dome those around its tip, the paw fewer");
  figure.text(
      "Above: the membrane from outside. Below: the same knobs pressed in, seen from inside, three "
      "LEDs on the rim.",
      500, 590, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
