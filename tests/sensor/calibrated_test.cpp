#include "gelight/sensor/calibrated.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "gelight/membrane/tension.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using gelight::test::contains;
using gelight::test::refusal;

namespace {

constexpr Index width = 160, height = 120;
constexpr double ball = 30;

Image<Rgb8> gradient() {
  Image<Rgb8> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(110 + x / 8), static_cast<std::uint8_t>(120 - y / 6),
                     104};
    }
  }
  return image;
}

// One of each kind, without light at rest.
std::vector<FittedReflectance> reflectances() {
  LightsReflectance lights;
  lights.height = 0.75;
  lights.softness = 0.4;
  lights.contact = {0.02, -0.03, 0.01};
  lights.lights = {{{1.5, 0.2, 0.9}, {0.5, 0.1, 0}, {0.1, 0.1, 0.1}},
                   {{-1, 1.2, 0.8}, {0, 0.4, 0.2}, {0, 0, 0}},
                   {{-0.8, -1.4, 1}, {0.1, 0, 0.5}, {0, 0, 0}}};
  PolynomialReflectance polynomial{2, 0.9, std::vector<double>(108), std::vector<double>(108)};
  for (std::size_t i = 18; i < 108; ++i) {
    polynomial.touched[i] = 0.2 * std::sin(static_cast<double>(i));
    polynomial.free[i] = 0.2 * std::cos(static_cast<double>(i));
  }
  TableReflectance table{5, 0.9, std::vector<double>(450), std::vector<double>(450)};
  for (std::size_t i = 0; i < 450; ++i) {
    table.touched[i] = 0.1 * std::sin(static_cast<double>(i));
    if (i < 12 * 18 || i >= 13 * 18) table.free[i] = 0.1 * std::cos(static_cast<double>(i));
  }
  return {lights, polynomial, table};
}

// What each pixel shows of a ball by the normals' own formulas.
Image<std::array<double, 3>> predicted(const CalibratedSensor& sensor, double cx, double cy,
                                       double contact) {
  Image<std::array<double, 3>> out(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double dx = x - cx, dy = y - cy, r = std::max(1e-9, std::hypot(dx, dy));
      const double rim = contact / std::sqrt(ball * ball - contact * contact);
      const double slope =
          r <= contact ? r / std::sqrt(ball * ball - r * r)
                       : rim * std::cyl_bessel_k(1.0, r / 9) / std::cyl_bessel_k(1.0, contact / 9);
      const double tilt = slope / std::sqrt(1 + slope * slope) / r;
      const Change by = change(sensor.reflectance, {tilt * dx, tilt * dy, 2.0 * x / (width - 1) - 1,
                                                    2.0 * y / (height - 1) - 1, r <= contact});
      for (std::size_t c = 0; c < 3; ++c) {
        out(x, y)[c] = std::clamp(sensor.background(x, y)[c] * (1 + by[c]), 0.0, 255.0);
      }
    }
  }
  return out;
}

}  // namespace

TEST_CASE("the renderer makes of a sensor's file what the fit predicts") {
  const std::string path =
      (std::filesystem::temp_directory_path() / "calibrated_test.sensor").string();
  for (const FittedReflectance& reflectance : reflectances()) {
    const CalibratedSensor made{gradient(), reflectance, 9, {1, -2, 3}};
    write_sensor(path, made);
    const CalibratedSensor sensor = read_sensor(path);
    CHECK(sensor.background == made.background);
    CHECK(sensor.bulge_length == 9);
    CHECK(sensor.level == made.level);

    const Camera<double> camera{8000, 8000, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
    const TactileRenderer renderer(camera, Image<double>(width, height, 1),
                                   TensionMembrane<double>(sensor.bulge_length),
                                   CalibratedReflectance<double>(sensor));
    CHECK(renderer.rest_image() == sensor.background);
    const double deep = ball - std::sqrt(ball * ball - 19 * 19) +
                        19 / std::sqrt(ball * ball - 19 * 19) * 9 *
                            std::cyl_bessel_k(0.0, 19 / 9.0) / std::cyl_bessel_k(1.0, 19 / 9.0);
    Image<double> depth(width, height, std::numeric_limits<double>::infinity());
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const double left = ball * ball - (x - 70.0) * (x - 70) - (y - 55.0) * (y - 55);
        if (left > 0) depth(x, y) = 1 - (deep - ball + std::sqrt(left)) / 8000;
      }
    }
    const Image<Rgb8> image = renderer.render(depth);
    const auto expected = predicted(sensor, 70, 55, 19);
    double sum = 0;
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum += std::abs(image.pixels()[i][c] - expected.pixels()[i][c]);
      }
    }
    CHECK(sum / (3.0 * width * height) < 0.5);  // rounding is a quarter
  }

  std::ifstream whole(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  for (const double share : {0.0, 0.001, 0.1, 0.5, 0.999}) {
    std::ofstream(path, std::ios::binary)
        << bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size())));
    CHECK(contains(refusal([&] { (void)read_sensor(path); }), path));
  }
  std::filesystem::remove(path);
  CHECK(contains(refusal([&] { (void)read_sensor(path); }), "cannot be opened"));
}
