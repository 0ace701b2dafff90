// What the rasteriser owes to the grid that points of the image are put on. Compiled with
// -ffast-math -fno-finite-math-only, too.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "gelight/image/raster.hpp"

using namespace gelight;

namespace {

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

}  // namespace

TEST_CASE("a face that is seen edge-on shows no pixel") {
  std::mt19937 random(1);
  int shown = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Camera<double> camera{
        between(random, 20, 60), between(random, 20, 60), 15.5, 15.5, 32, 32};
    // In the plane through the camera and a row of pixels, or a column.
    const double line = static_cast<double>(random() % 32);
    Mesh<double> mesh;
    for (int k = 0; k < 3; ++k) {
      const double along = between(random, 0, 31), z = between(random, 0.5, 2);
      const Vec3<double> p =
          trial % 2 == 0 ? camera.unproject(along, line, z) : camera.unproject(line, along, z);
      mesh.positions.push_back({p[0], p[1], p[2]});
    }
    mesh.faces = {{0, 1, 2}};
    const auto raster = rasterize(mesh, camera);
    for (const Index face : raster.face.pixels()) shown += face >= 0;
  }
  CHECK(shown == 0);
}

TEST_CASE("a sheet whose corners are what pixels see has no holes, and their depths") {
  std::mt19937 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Index width = 40, height = 30;
    const Camera<double> camera{between(random, 12, 80),
                                between(random, 12, 80),
                                between(random, 18, 21),
                                between(random, 13, 16),
                                width,
                                height};
    Image<double> depth(width, height);
    for (double& z : depth.pixels()) z = between(random, 0.01, 0.02);
    Mesh<double> mesh;
    const auto points = unproject<double>(depth, camera);
    for (const auto& p : points.pixels()) mesh.positions.push_back({p[0], p[1], p[2]});
    for (Index y = 0; y + 1 < height; ++y) {
      for (Index x = 0; x + 1 < width; ++x) {
        const Index a = y * width + x;
        mesh.faces.push_back({a, a + 1, a + width});
        mesh.faces.push_back({a + 1, a + width + 1, a + width});
      }
    }
    const auto raster = rasterize(mesh, camera);
    int off = 0;
    for (Index y = 1; y + 1 < height; ++y) {
      for (Index x = 1; x + 1 < width; ++x) {
        off += !(std::abs(raster.depth(x, y) / depth(x, y) - 1) < 1e-12);
      }
    }
    CHECK(off == 0);
  }
}

TEST_CASE("faces so large that they are cut leave no pixel between them where their side goes") {
  std::mt19937 random(3);
  int holes = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double column = static_cast<double>(random() % 13);
    const double row = static_cast<double>(random() % 10);
    const Camera<double> camera{
        between(random, 50, 100), between(random, 50, 100), column, row, 13, 10};
    // A wall, each corner on a diagonal of the camera: the side between its faces goes through the
    // pixel on the optical axis.
    Mesh<double> wall;
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        const double z = between(random, 0.9, 1.1);
        wall.positions.push_back({x * z, y * z, z});
      }
    }
    wall.faces = {{0, 1, 3}, {0, 3, 2}};
    const auto raster = rasterize(wall, camera);
    for (const Index face : raster.face.pixels()) holes += face < 0;
  }
  CHECK(holes == 0);
}
