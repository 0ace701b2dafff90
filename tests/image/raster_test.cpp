#include "gelight/image/raster.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gelight/mesh/shapes.hpp"

using gelight::Camera;
using gelight::Index;
using gelight::Mesh;
using gelight::Vec3;

namespace {

template <class T>
Camera<T> small_camera() {
  return {40, 40, T(31.5), T(23.5), 64, 48};
}

// The point that depth and camera tell, and the one that face and barycentric coordinates tell.
template <class T>
void check_points_agree(const Mesh<T>& mesh, const gelight::Raster<T>& raster,
                        const Camera<T>& camera, double tolerance) {
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Index f = raster.face(u, v);
      if (f < 0) {
        CHECK(raster.depth(u, v) == std::numeric_limits<T>::infinity());
        continue;
      }
      const Camera<double> exact = camera.template cast<double>();
      const Vec3<double> seen = exact.unproject(u, v, raster.depth(u, v));
      Vec3<double> on_face = Vec3<double>::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = mesh.position(mesh.face(f)[k]);
        on_face += double{raster.barycentric(u, v)[k]} * Vec3<double>(p[0], p[1], p[2]);
      }
      CHECK((seen - on_face).norm() < tolerance);
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("a tilted sheet is seen at its analytic depth", T, float, double) {
  // z = 2 + x / 2, so that a ray (x, y, 1) z meets it at z = 2 / (1 - x / 2).
  Mesh<T> sheet = gelight::grid<T>(7, 5, 20, 20);
  for (auto& [x, y, z] : sheet.positions) {
    x = x - 10;
    y = y - 10;
    z = 2 + x / 2;
  }
  const auto camera = small_camera<T>();
  const auto raster = gelight::rasterize(sheet, camera);
  const double eps = std::numeric_limits<T>::epsilon();
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const double x = (u - 31.5) / 40, y = (v - 23.5) / 40;
      const double z = 2 / (1 - x / 2);
      if (std::abs(x * z) > 9.99 || std::abs(y * z) > 9.99) continue;
      CHECK(raster.depth(u, v) == doctest::Approx(z).epsilon(8 * eps));
    }
  }
  check_points_agree(sheet, raster, camera, 100 * eps);
}

TEST_CASE(
    "from inside a closed box every ray meets the nearest wall, also on edges and diagonals") {
  const Mesh<double> box = gelight::box(2.0, 3.0, 4.0);
  // Odd size and whole-numbered centre: rays run exactly through corners, edges and diagonals.
  const Camera<double> camera{16, 16, 32, 24, 65, 49};
  const auto raster = gelight::rasterize(box, camera);
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Vec3<double> d = camera.ray(u, v);
      const double z = std::min({1 / std::abs(d[0]), 1.5 / std::abs(d[1]), 2.0});
      CHECK(raster.face(u, v) >= 0);
      CHECK(raster.depth(u, v) == doctest::Approx(z).epsilon(1e-14));
    }
  }
  check_points_agree(box, raster, camera, 1e-14);
}

TEST_CASE("of two surfaces the nearer is seen, and what is behind the camera is not") {
  Mesh<double> ball = gelight::icosphere(4, 1.0);
  for (auto& p : ball.positions) p[2] += 3;
  const auto camera = small_camera<double>();
  const auto raster = gelight::rasterize(ball, camera);
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Vec3<double> d = camera.ray(u, v);
      const double a = d.squaredNorm(), root = 9 - a * 8;  // |z d - (0, 0, 3)| = 1
      if (root < -0.2) {
        CHECK(raster.face(u, v) == -1);
      }
      if (root > 0.2) {
        const double z = (3 - std::sqrt(root)) / a;
        CHECK(raster.depth(u, v) == doctest::Approx(z).epsilon(2e-3));
        CHECK(raster.depth(u, v) >= z);  // the faces are chords of the sphere
      }
    }
  }
  for (auto& p : ball.positions) p[2] -= 6;
  for (const Index face : gelight::rasterize(ball, camera).face.pixels()) CHECK(face == -1);
}

TEST_CASE("a triangle that passes beside the camera is seen only in front of it") {
  // A floor at y = 1, from far behind the camera to far before it.
  const Mesh<double> floor{{{-100, 1, -100}, {100, 1, -100}, {0, 1, 1000}}, {{0, 1, 2}}};
  const auto camera = small_camera<double>();
  const auto raster = gelight::rasterize(floor, camera);
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Vec3<double> d = camera.ray(u, v);
      const bool below = d[1] > 0;
      CHECK((raster.face(u, v) >= 0) == below);
      if (below) CHECK(raster.depth(u, v) == doctest::Approx(1 / d[1]).epsilon(1e-13));
    }
  }
}

TEST_CASE("bad cameras and bad meshes are refused") {
  using gelight::InvalidInput;
  const Mesh<double> box = gelight::box(1.0, 1.0, 1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS((void)gelight::rasterize(box, Camera<double>{0, 1, 0, 0, 4, 4}), InvalidInput);
  CHECK_THROWS_AS((void)gelight::rasterize(box, Camera<double>{1, nan, 0, 0, 4, 4}), InvalidInput);
  CHECK_THROWS_AS((void)gelight::rasterize(box, Camera<double>{1, 1, 0, 0, -4, 4}), InvalidInput);
  Mesh<double> broken = box;
  broken.faces[5][1] = 8;
  CHECK_THROWS_WITH_AS((void)gelight::rasterize(broken, small_camera<double>()),
                       "face 5 has vertex 8, the mesh has 8 vertices", InvalidInput);
}
