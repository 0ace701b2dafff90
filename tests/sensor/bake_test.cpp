#include "gelight/sensor/bake.hpp"

#include <doctest/doctest.h>

#include <array>

#include "gelight/light/linear.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"

using gelight::Camera;
using gelight::Index;
using gelight::Vec3;

TEST_CASE("each pixel gets the direction of the surface point that it shows, the rest gets none") {
  auto ball = gelight::icosphere(3, 1.0);
  for (auto& p : ball.positions) p[2] += 3;
  const Camera<double> camera{20, 20, 15.5, 11.5, 32, 24};
  const auto raster = gelight::rasterize(ball, camera);
  const auto points = gelight::pixel_points(raster);
  const gelight::Surface surface(ball);
  const Vec3<double> led(0, 5, 0);
  const auto field = gelight::linear_field<double>(surface, led, points);
  const auto baked = gelight::bake(field, raster);
  Index shown = 0;
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      if (raster.face(u, v) < 0) {
        CHECK(baked(u, v).isZero());
        continue;
      }
      ++shown;
      const Vec3<double> seen = camera.unproject(u, v, raster.depth(u, v));
      CHECK(baked(u, v).isApprox((seen - led).normalized(), 1e-12));
    }
  }
  CHECK(shown == static_cast<Index>(points.size()));
  CHECK(shown > 100);
  double done = 0;
  CHECK(gelight::bake(field, raster, [&](double share) {
          CHECK(share >= done);
          done = share;
          return false;
        }) == baked);
  CHECK(done == 1);
  CHECK_THROWS_AS((void)gelight::bake(field, raster, [] { return true; }), gelight::Cancelled);
  CHECK_THROWS_AS((void)gelight::bake(gelight::LightField<double>(3), raster),
                  gelight::InvalidInput);
  auto cut = raster;
  cut.barycentric = gelight::Image<std::array<double, 3>>(32, 23);
  CHECK_THROWS_AS((void)gelight::pixel_points(cut), gelight::InvalidInput);
}
