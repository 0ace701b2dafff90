#include <doctest/doctest.h>

#include <Eigen/Core>
#include <cfenv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/presets.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "stress/stress.hpp"
#include "support/floating_flags.hpp"
#include "support/hard_meshes.hpp"

// No operation makes a NaN where the input has none, not even one that is thrown away later: the
// processor's flag for it stays down, so that a program may trap it. The preset `trap` compiles
// this so that the compiler makes no such operation of its own.

using namespace gelight;

namespace {

template <class Act>
void check_no_nan(const std::string& what, const Act& act) {
  CAPTURE(what);
  std::feclearexcept(FE_ALL_EXCEPT);
  act();
  CHECK(std::fetestexcept(FE_INVALID) == 0);
}

struct Input {
  std::string name;
  Mesh<double> mesh;
};
std::vector<Input> inputs() {
  test::Random random(1);
  const std::vector<Mesh<double>> parts{icosphere<double>(2), test::jittered_grid(6, 0.2, random)};
  return {{"sphere", icosphere<double>(2)},
          {"sheet", test::jittered_grid(8, 0.2, random)},
          {"two parts", joined<double>(parts)},
          {"random", test::small_random_mesh(3, random)}};
}

}  // namespace

TEST_CASE("distances by every method") {
  for (const auto& input : inputs()) {
    for (const auto& method : stress::methods()) {
      for (const auto precision : {stress::Precision::in_double, stress::Precision::in_float}) {
        check_no_nan(method.name + ", " + input.name, [&] {
          (void)method.make(input.mesh, precision)->distance(stress::from(input.mesh.faces[0][0]));
        });
      }
    }
  }
}

TEST_CASE("distances by heat alone") {
  for (const auto& input : inputs()) {
    for (const bool delaunay : {false, true}) {
      check_no_nan(input.name, [&] {
        const HeatSolver solver(input.mesh, {.exact_radius = 0, .intrinsic_delaunay = delaunay});
        (void)solver.distance(input.mesh.faces[0][0]);
      });
    }
  }
}

TEST_CASE("exact ways: to points, from points, to targets, back with and without windows") {
  test::Random random(2);
  for (const auto& input : inputs()) {
    for (int k = 0; k < 20; ++k) {
      const auto source = test::random_point(input.mesh, random);
      const auto target = test::random_point(input.mesh, random);
      CAPTURE(k);
      for (const bool keeps : {false, true}) {
        check_no_nan(input.name, [&] {
          const ExactSolver solver(input.mesh);
          const auto field = solver.solve(Source<double>{source, 0.25}, {.keep_windows = keeps});
          (void)field.distance(target);
          if (field.distance(target) == unreachable<double>) return;
          (void)field.path(target);
          (void)field.direction(target);
          (void)field.arrivals(target);
        });
      }
      check_no_nan(input.name + ", to a target", [&] {
        (void)ExactSolver(input.mesh).solve(Source<double>{source, 0}, {.targets = {target}});
      });
    }
  }
}

TEST_CASE("vectors") {
  const VectorHeatSolver solver(icosphere<double>(2));
  check_no_nan("transport", [&] { (void)solver.transport(3, Vec3<double>(1, 2, 3)); });
  check_no_nan("log map", [&] { (void)solver.log_map(3); });
}

TEST_CASE("a mesh around the camera" * doctest::skip(!test::keeps_floating_flags)) {
  const Camera<double> camera{60, 60, 31.5, 23.5, 64, 48};
  const auto around = icosphere<double>(2);
  for (const double z : {0.0, 0.5, 1.0}) {
    CAPTURE(z);
    check_no_nan("drawn", [&] {
      Image<double> depth(64, 48, std::numeric_limits<double>::infinity());
      rasterize_into(depth, around, Pose(Eigen::Matrix3d::Identity(), {0, 0, z}), camera);
    });
  }
}

TEST_CASE("sensors at rest and touched, where the camera sees the membrane in all pixels" *
          doctest::skip(!test::keeps_floating_flags)) {
  for (auto preset : {geltip(), gelsight_mini(), digit()}) {
    Camera<float>& c = preset.camera;
    c = {c.fx / 8,    c.fy / 8,    (c.cx + 0.5f) / 8 - 0.5f, (c.cy + 0.5f) / 8 - 0.5f,
         c.width / 8, c.height / 8};
    check_no_nan("frames", [&] {
      const auto sensor = tactile_renderer(preset);
      Image<float> depth(c.width, c.height, std::numeric_limits<float>::infinity());
      const Pose pose(Eigen::Matrix3d::Identity(), {0, 0, 0.03});
      rasterize_into(depth, icosphere(2, 0.01f), pose, preset.camera);
      (void)sensor.render(depth);
    });
  }
}

TEST_CASE("images") {
  const Camera<float> camera{60, 60, 31.5f, 23.5f, 64, 48};
  Image<float> depth(64, 48, 0.03f);
  for (Index x = 20; x < 30; ++x) depth(x, 20) = 0.028f;
  check_no_nan("smoothing", [&] { (void)gaussian(depth, 2.0, 5); });
  check_no_nan("normals", [&] { (void)sobel_normals(depth, camera); });
  check_no_nan("frame", [&] {
    const std::vector<Light<float>> lights{
        {Image<Vec3<float>>(64, 48, Vec3<float>(1, 0, 0.2f).normalized()), {1, 0.5f, 0}}};
    const TactileRenderer<float> renderer(camera, Image<float>(64, 48, 0.03f), lights);
    (void)renderer.render(depth);
  });
}
