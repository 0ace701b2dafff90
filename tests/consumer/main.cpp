// What a stranger's program may look like. It prints what must not depend on how gelight came in.

#include <cstdio>
#include <gelight/gelight.hpp>

#include "second.hpp"

int main() {
  // On a flat sheet the shortest path from corner to corner is the straight line.
  const auto sheet = gelight::grid<double>(8, 6, 4, 3);
  const gelight::ExactSolver solver(sheet);
  std::printf("across a sheet of 4 x 3: %.12f\n", solver.distance(gelight::Index{0}).back());
  std::printf("the same by fast marching, in the second file: %.9f\n", by_fronts(sheet));

  const auto membrane = gelight::membrane<float>(0.01f, 0.04f, 0.002f);
  const auto camera = gelight::Camera<float>::from_vertical_fov(1.5f, 32, 24);
  const auto rest = gelight::rasterize(membrane, camera);
  const gelight::TactileRenderer<float> sensor(camera, rest.depth, {});
  const bool same = sensor.render(rest.depth) == sensor.rest_image();
  std::printf("untouched, the image is %s\n", same ? "the image at rest" : "WRONG");
}
