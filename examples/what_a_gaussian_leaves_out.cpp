// What a Gaussian leaves out: gel that is pressed aside has to go somewhere.
//
//          ball                      A blurred protrusion can only sink. Gel hardly changes its
//      ____ ( ) ____  Gaussian       volume, so that what is pressed in rises beside it: in a thin
//          \___/                     layer in a rim, in a thick one so far around that nobody sees
//       _         _                  it, and there the gel sinks much farther out. How far, linear
//     _/ \_( )__/ \_  elastic layer  elasticity tells: pressures that act where the two touch, and
//          \___/                     how a layer on a rigid base yields to each.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gelight/gelight.hpp"
#include "gelight/membrane/layer.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Rgb8;
using gelight::Vec2;
using gelight::Vec3;

namespace {

constexpr Index width = 200, height = 150;
constexpr double rest = 0.030, pixel = 1e-4, press = 5e-4;  // m
const gelight::Camera<double> eye{rest / pixel, rest / pixel, 99.5, 74.5, width, height};

// A surface in the light of three lamps that stand around it.
Image<Rgb8> photograph(const Image<double>& surface) {
  gelight::PhongLights<double> lamps{{}, gelight::Background<double>(Rgb8{50, 50, 50})};
  for (const std::size_t k : {0u, 1u, 2u}) {
    const double angle = 0.5 + 2.1 * static_cast<double>(k);
    gelight::Light<double> light{Image<Vec3<double>>(
        width, height, Vec3<double>(std::cos(angle), std::sin(angle), 0.4).normalized())};
    light.rgb = {0.15, 0.15, 0.15};
    light.rgb[k] = 1;
    light.diffuse = 1.3;
    lamps.lights.push_back(light);
  }
  // The surface is the membrane's already: follow it exactly, also where it rises.
  const gelight::TactileRenderer<double> renderer(eye, Image<double>(width, height, rest),
                                                  gelight::GaussianMembrane<double>(0, 0, false),
                                                  lamps);
  return renderer.render(surface);
}

// How far up the surface is along the middle row, in mm.
std::vector<Vec2<double>> cut(const Image<double>& surface) {
  std::vector<Vec2<double>> curve;
  for (Index x = 0; x < width; ++x) {
    curve.emplace_back((x - 99.5) * pixel * 1e3, (surface(x, 74) - rest) * 1e3);
  }
  return curve;
}

double highest(const std::vector<Vec2<double>>& curve) {
  double most = -1;
  for (const auto& p : curve) most = std::max(most, p.y());
  return most;
}

}  // namespace

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "what_a_gaussian_leaves_out");

  // A ball of 10 mm, half a millimetre deep.
  Image<double> ball(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double r = pixel * std::hypot(x - 99.5, y - 74.5), radius = 0.010;
      ball(x, y) = rest - press + radius - std::sqrt(std::max(0.0, radius * radius - r * r));
    }
  }
  const double contact = std::sqrt(0.010 * press);  // its radius on gel without end

  Figure figure(1000, 580);
  const std::vector<std::pair<double, std::string>> gels{{1e-3, "1 mm thick"},
                                                         {1e-2, "10 mm thick"}};
  std::vector<double> rims, beside;
  double x = 80;
  for (const auto& [thickness, name] : gels) {
    const gelight::Gel gel{1e5, 0.49, thickness};
    const auto layer = gelight::ElasticLayer(eye, rest, gel).press(ball);
    const double sigma = gelight::gaussian_sigma(gel, contact) / pixel;
    const gelight::GaussianMembrane<double> gaussian(sigma, static_cast<Index>(4 * sigma) + 1);
    const auto blurred = gelight::surface_depth(gaussian, ball, Image<double>(width, height, rest));

    // The camera is below: up here is towards what is pressed in.
    const auto elastic = cut(layer.depth), smooth = cut(blurred), object = cut(ball);
    const bool is_thin = thickness < 5e-3;
    Plot plot(figure, {x, 60, 400, 250},
              name + (is_thin ? ": a rim rises" : ": it sinks far around"), {"mm", -10, 10},
              {"surface, mm", -0.6, 0.4});
    plot.curve({{-10, 0}, {10, 0}}, grey, "", 1);
    plot.curve({object.begin() + 57, object.end() - 57}, pale, "", 6);
    plot.curve(smooth, blue, "");
    plot.curve(elastic, orange, "");
    plot.label({4.2, 0.33}, grey, "ball");
    plot.label({is_thin ? 4.2 : 2.2, is_thin ? 0.13 : 0.05}, is_thin ? orange : blue,
               is_thin ? "elastic layer" : "Gaussian");
    plot.label({is_thin ? 3.0 : 3.1, is_thin ? -0.06 : -0.22}, is_thin ? blue : orange,
               is_thin ? "Gaussian" : "elastic layer");
    figure.image(photograph(blurred), x, 405, 0.97);
    figure.image(photograph(layer.depth), x + 206, 405, 0.97);
    figure.pen(black, 1);
    figure.text("Gaussian", x + 97, 392, 14);
    figure.text("elastic layer", x + 303, 392, 14);

    rims.push_back(highest(elastic));
    beside.push_back(elastic[150].y() / smooth[150].y());  // 5 mm from the middle
    lesson.expect(highest(smooth) <= 1e-12, name + ": a Gaussian never rises");
    lesson.expect(layer.converged, name + ": the layer's contact is solved");
    x += 490;
  }
  lesson.expect(rims[0] > 0.2 * press * 1e3, "a thin gel rises by a fifth of the press or more");
  lesson.expect(rims[1] < 0.03 * press * 1e3, "a thick one by less than a thirtieth");
  lesson.expect(beside[1] > 2, "but 5 mm from the middle it sinks more than twice as far");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
