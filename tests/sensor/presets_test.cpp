#include "gelight/sensor/presets.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "gelight/image/raster.hpp"
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

TEST_CASE("a sensor that cannot be is refused") {
  CHECK(test::refusal([] { (void)geltip<double>(0, 480); }) != "accepted");
  CHECK(test::refusal([] { (void)geltip<double>(640, 480, 0.02); }) != "accepted");
}
