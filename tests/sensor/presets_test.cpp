#include "gelight/sensor/presets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/refusal.hpp"

using namespace gelight;

TEST_CASE_TEMPLATE("the GelTip's parts fit together", T, float, double) {
  const auto sensor = geltip<T>(160, 120);
  const Surface<T> surface(sensor.membrane);

  // Three LEDs on the rim of the open end, a third of a turn apart to half an edge.
  REQUIRE(sensor.leds.size() == 3);
  const T radius = T(0.01146), apart = 2 * radius * std::sin(std::numbers::pi_v<T> / 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3<T> p = surface.position(sensor.leds[k]);
    CHECK(p.z() == 0);
    CHECK(p.norm() == doctest::Approx(radius).epsilon(1e-6));
    const Vec3<T> q = surface.position(sensor.leds[(k + 1) % 3]);
    CHECK(std::abs((p - q).norm() - apart) < T(0.001));
  }
  CHECK(std::abs(surface.position(sensor.leds[0]).y()) <= T(0.0005));

  // The camera sees the tip in the middle of its image, and the membrane or its open end elsewhere.
  CHECK(sensor.camera.fy == doctest::Approx(60));
  const auto rest = rasterize(sensor.membrane, sensor.camera);
  CHECK(rest.depth(80, 60) == doctest::Approx(0.0455).epsilon(1e-3));
  for (Index u = 0; u < 160; ++u) {
    const T slope = std::hypot((T(u) - sensor.camera.cx) / 60, (60 - sensor.camera.cy) / 60);
    const T wall = radius / slope;  // where the ray meets the cylinder
    if (wall > T(0.034)) continue;
    CHECK(rest.depth(u, 60) == doctest::Approx(wall).epsilon(5e-3));
  }
}

TEST_CASE("LEDs follow the mesh that they are put on") {
  const auto tip = geltip<double>(32, 24, 0.002);
  std::vector<double> angles;
  for (int k = 0; k < 8; ++k) angles.push_back(0.3 + 0.7 * k);
  const auto leds = leds_on_border(tip.membrane, angles);
  // The same membrane, thrice as large, somewhere else, its vertices in another order.
  Mesh<double> other = tip.membrane;
  std::reverse(other.positions.begin(), other.positions.end());
  const auto last = static_cast<Index>(other.positions.size()) - 1;
  for (auto& p : other.positions) p = {3 * p[0] + 1, 3 * p[1] - 2, 3 * p[2] + 5};
  for (auto& face : other.faces) {
    for (Index& v : face) v = last - v;
  }
  const auto moved = leds_on_border(other, angles);
  const Surface<double> surface(tip.membrane);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    CHECK(moved[k].element[0] == last - leds[k].element[0]);
    const Vec3<double> p = surface.position(leds[k]);
    CHECK(p.z() == 0);
    const double apart = std::remainder(std::atan2(p.y(), p.x()) - angles[k], 2 * std::numbers::pi);
    CHECK(std::abs(apart) <= 0.5001 * 0.002 / 0.01146);
  }
  CHECK_THROWS_WITH_AS((void)leds_on_border(icosphere<double>(1), angles),
                       "the membrane has no border to put LEDs on", InvalidInput);
}

TEST_CASE("every preset shows a lit and coloured membrane, and where something touches it") {
  struct Shown {
    const char* name;
    SensorPreset<float> sensor;
    Vec3<double> ball;  // of 4 mm, where it is pressed in
  };
  const std::vector<Shown> all{{"geltip", geltip(160, 120, 0.002f), {-0.0138, -0.003, 0.026}},
                               {"mini", gelsight_mini(160, 120, 0.002f), {0.002, 0.001, 0.023}},
                               {"digit", digit(120, 160, 0.002f), {0.002, 0.001, 0.025}},
                               {"sts", sts(160, 120, 0.002f), {0.002, 0.001, 0.033}}};
  const auto ball = icosphere<float>(3, 0.004f);
  for (const auto& [name, sensor, at] : all) {
    CAPTURE(name);
    const auto renderer = tactile_renderer(sensor);
    const Image<Rgb8>& rest = renderer.rest_image();
    // Neither black nor white nor grey.
    std::size_t lit = 0, coloured = 0;
    for (const Rgb8& p : rest.pixels()) {
      const auto [least, most] = std::minmax({p[0], p[1], p[2]});
      lit += most > 40 && most < 255 ? 1 : 0;
      coloured += most - least > 20 ? 1 : 0;
    }
    const std::size_t count = rest.pixels().size();
    CHECK(lit > count * 9 / 10);
    CHECK(coloured > count / 2);
    // An object as the camera sees it, nothing else in the image: it is where it touches.
    Mesh<float> moved = ball;
    for (auto& p : moved.positions) {
      for (std::size_t c = 0; c < 3; ++c) p[c] += static_cast<float>(at[static_cast<Index>(c)]);
    }
    const auto seen = rasterize(moved, sensor.camera);
    const auto image = renderer.render(seen.depth);
    const auto depth = rasterize(sensor.membrane, sensor.camera).depth;
    std::size_t brighter = 0;
    for (Index y = 0; y < rest.height(); ++y) {
      for (Index x = 0; x < rest.width(); ++x) {
        int change = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          change = std::max(change, std::abs(image(x, y)[c] - rest(x, y)[c]));
        }
        brighter += change > 40 ? 1 : 0;
        bool near = false;  // within the Gaussian's reach and the normals' pixel
        for (Index v = std::max(0, y - 21); v <= std::min(rest.height() - 1, y + 21); ++v) {
          for (Index u = std::max(0, x - 21); u <= std::min(rest.width() - 1, x + 21); ++u) {
            near = near || seen.depth(u, v) < depth(u, v);
          }
        }
        if (!near) REQUIRE(change == 0);
      }
    }
    CHECK(brighter > 10);
  }
}

TEST_CASE("a sensor without a colour for each LED is refused") {
  auto sensor = gelsight_mini(32, 24, 0.002f);
  sensor.colours.pop_back();
  CHECK_THROWS_WITH_AS((void)tactile_renderer(sensor), "there are 3 LEDs and 2 colours",
                       InvalidInput);
}

TEST_CASE("a sensor that cannot be is refused") {
  CHECK(test::refusal([] { (void)geltip<double>(0, 480); }) != "accepted");
  CHECK(test::refusal([] { (void)geltip<double>(640, 480, 0.02); }) != "accepted");
}
