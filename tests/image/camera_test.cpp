#include "gelight/image/camera.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "reference.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;

namespace {

std::string refusal(const Camera<double>& camera) {
  return test::refusal(
      [&] { (void)unproject(Image<double>(camera.width, camera.height, 1.0), camera); });
}

}  // namespace

TEST_CASE("a field of view of 90 degrees: the edges are seen at 45 degrees") {
  const auto camera = Camera<double>::from_vertical_fov(std::numbers::pi / 2, 640, 480);
  CHECK(camera.fx == gelight::test::approx(240).epsilon(1e-14));
  CHECK(camera.cx == 319.5);
  CHECK(camera.cy == 239.5);
  // The image's lower edge is half a pixel below the last centre.
  CHECK(camera.ray(319.5, 479.5).y() == gelight::test::approx(1).epsilon(1e-14));
}

TEST_CASE("x to the right, y down, z forward; projecting undoes unprojecting") {
  const Camera<double> camera{100, 50, 30, 20, 64, 48};
  CHECK(camera.unproject(30, 20, 2) == Vec3<double>(0, 0, 2));
  CHECK(camera.unproject(130, 20, 2) == Vec3<double>(2, 0, 2));
  CHECK(camera.unproject(30, 70, 2) == Vec3<double>(0, 2, 2));
  const auto seen = camera.project(camera.unproject(7, 45, 0.3));
  CHECK(seen.x() == gelight::test::approx(7).epsilon(1e-14));
  CHECK(seen.y() == gelight::test::approx(45).epsilon(1e-14));
}

TEST_CASE("the depth of an unprojected point is z, and what is not a number stays so") {
  const Camera<float> camera{10, 10, 1, 1, 3, 2};
  Image<float> depth(3, 2, 5.f);
  depth(2, 1) = std::numeric_limits<float>::quiet_NaN();
  const auto points = unproject(depth, camera);
  CHECK(points(0, 0) == Vec3<float>(-0.5f, -0.5f, 5));
  CHECK(points(2, 0).z() == 5);
  CHECK(std::isnan(points(2, 1).z()));
}

TEST_CASE("cameras that see nothing are refused by name") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(refusal({1, 1, 0, 0, 2, 2}) == "accepted");
  CHECK(refusal({0, 1, 0, 0, 2, 2}).find("focal lengths (0, 1)") != std::string::npos);
  CHECK(refusal({1, -3, 0, 0, 2, 2}).find("focal lengths (1, -3)") != std::string::npos);
  CHECK(refusal({nan, 1, 0, 0, 2, 2}).find("focal lengths (nan, 1)") != std::string::npos);
  CHECK(refusal({1, 1, nan, 0, 2, 2}).find("centre (nan, 0)") != std::string::npos);
  const double tiny = std::numeric_limits<double>::denorm_min();
  CHECK(refusal({tiny, 1, 0, 0, 1, 1}) == "accepted");  // its one pixel is on the axis
  CHECK(refusal({tiny, 1, 0, 0, 3, 2}) ==
        "the camera's ray through pixel (2, 1) is (inf, 1, 1), not finite");
  CHECK(refusal({1, 0.1, 0, 1e308, 3, 2}) ==
        "the camera's ray through pixel (0, 0) is (0, -inf, 1), not finite");
  CHECK(refusal({1, 1, 0, 0, 0, 2}).find("size 0 x 2") != std::string::npos);
  CHECK_THROWS_AS((void)Camera<double>::from_vertical_fov(0, 4, 4), InvalidInput);
  CHECK_THROWS_AS((void)Camera<double>::from_vertical_fov(3.2, 4, 4), InvalidInput);
  CHECK_THROWS_AS((void)Camera<double>::from_vertical_fov(nan, 4, 4), InvalidInput);
  CHECK_THROWS_AS((void)Camera<double>::from_vertical_fov(1, 0, 4), InvalidInput);
  // The focal length follows from the height: that is what was wrong.
  CHECK_THROWS_WITH_AS((void)Camera<double>::from_vertical_fov(1, 4, 0),
                       "the camera's image size 4 x 0 is not positive", InvalidInput);
  CHECK_THROWS_WITH_AS((void)unproject(Image<double>(3, 2), Camera<double>{1, 1, 0, 0, 2, 2}),
                       "the depth image is 3 x 2 pixels, the camera's image 2 x 2", InvalidInput);
}

TEST_CASE("the published points of contact 2") {
  if (reference::is_absent()) return;
  const auto published = reference::stage<Vec3<float>>("points_contact_2");
  const auto depth = reference::stage<float>("deformed_depth_contact_2");
  const auto points = unproject(depth, reference::camera<double>());
  double worst = 0;
  for (Index y = 0; y < 480; ++y) {
    for (Index x = 0; x < 640; ++x) {
      const Vec3<double> want = published(x, y).cast<double>();
      worst = std::max(worst, (points(x, y) - want).norm() / want.norm());
    }
  }
  CHECK(worst < 6e-8);  // half a unit in the last place of a float
}
