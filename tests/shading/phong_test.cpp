#include "gelight/shading/phong.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "gelight/image/camera.hpp"
#include "reference.hpp"
#include "support/approx.hpp"

using namespace gelight;

namespace {

using V = Vec3<double>;

V at_angle(double radians) { return {std::sin(radians), 0, std::cos(radians)}; }

}  // namespace

TEST_CASE("light, normal and eye in one plane: cosines of their angles") {
  const V normal(0, 0, 1);
  for (const double light : {-1.2, -0.3, 0.0, 0.7, 1.5}) {
    for (const double eye : {-1.0, 0.0, 0.4}) {
      // The mirrored light is at -light from the normal.
      const double mirrored = std::max(0.0, std::cos(eye + light));
      const double want = 0.5 * std::cos(light) + 0.1 * std::pow(mirrored, 7);
      CHECK(phong(normal, at_angle(light), at_angle(eye), 0.5, 0.1, 7.0) ==
            gelight::test::approx(want).epsilon(1e-13));
    }
  }
}

TEST_CASE("a light behind the surface gives nothing, but in the unclamped form a mirrored shine") {
  const V normal(0, 0, 1), eye = at_angle(0.1), behind = at_angle(std::numbers::pi - 0.2);
  CHECK(phong(normal, behind, eye, 0.5, 0.1, 100.0) == 0);
  // N.L is clamped, so R = -L.
  const double backwards = -behind.dot(eye);
  CHECK(phong(normal, behind, eye, 0.5, 0.1, 100.0, Specular::unclamped) ==
        gelight::test::approx(0.1 * std::pow(backwards, 100)));
  CHECK(phong(normal, at_angle(0.5), at_angle(1.5), 0.0, 1.0, 3.0) == 0);  // R.V < 0
  CHECK(phong(normal, at_angle(0.5), at_angle(1.5), 0.0, 1.0, 3.0, Specular::unclamped) < 0);
}

TEST_CASE("shininess of zero, of a fraction, and huge") {
  const V normal(0, 0, 1);
  CHECK(phong(normal, at_angle(0.3), at_angle(0.9), 0.0, 1.0, 0.0) == 1);
  CHECK(phong(normal, at_angle(0.3), at_angle(0), 0.0, 1.0, 0.5) ==
        gelight::test::approx(std::sqrt(std::cos(0.3))));
  CHECK(phong(normal, at_angle(0.3), at_angle(0), 0.0, 1.0, 1e9) == 0);
  CHECK(phong(normal, normal, normal, 0.0, 1.0, 1e9) == 1);
  CHECK(phong(normal, at_angle(2), at_angle(0), 1.0, 1.0, 0.0) == 0);
}

TEST_CASE("a pixel without a normal or without light is dark") {
  const V zero = V::Zero(), up(0, 0, 1);
  CHECK(phong(zero, up, up, 0.5, 0.1, 100.0) == 0);
  CHECK(phong(up, zero, up, 0.5, 0.1, 100.0) == 0);
}

TEST_CASE("the published light of LED 1 on contact 2") {
  if (reference::is_absent()) return;
  const auto published = reference::stage<Vec3<float>>("phong_light0_contact_2");
  const auto normals = reference::stage<Vec3<float>>("normals_contact_2");
  const auto to_light = reference::stage<Vec3<float>>("to_light_rectified_light0_contact_2");
  const auto points = reference::stage<Vec3<float>>("points_contact_2");
  double worst = 0;
  for (Index y = 0; y < 480; ++y) {
    for (Index x = 0; x < 640; ++x) {
      const V n = normals(x, y).cast<double>(), l = to_light(x, y).cast<double>();
      const V eye = -points(x, y).cast<double>().normalized();
      const double red = phong(n, l, eye, 0.5, 0.1, 100.0, Specular::unclamped);
      worst = std::max(worst, (V(red, 0, 0) - published(x, y).cast<double>()).norm());
    }
  }
  CHECK(worst < 1e-7);  // everything stored as floats
}
