#include <doctest/doctest.h>

#include <cfenv>
#include <cmath>
#include <string>
#include <vector>

#include "gelight/geodesic/heat.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"

// No operation makes a NaN where the input has none, not even one that is thrown away later: the
// processor's flag for it stays down. The preset `trap` compiles this so that the compiler makes no
// such operation of its own. The exact solver computes on lanes that hold nothing; it is left out,
// and so are heat's part of it and log maps.

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

TEST_CASE("distances along edges and by fronts") {
  for (const auto& input : inputs()) {
    for (const auto& method : stress::graph_methods()) {
      for (const auto precision : {stress::Precision::in_double, stress::Precision::in_float}) {
        check_no_nan(method.name + ", " + input.name, [&] {
          (void)method.make(input.mesh, precision)->distance(stress::from(input.mesh.faces[0][0]));
        });
      }
    }
  }
}

TEST_CASE("distances by heat") {
  for (const auto& input : inputs()) {
    for (const bool delaunay : {false, true}) {
      check_no_nan(input.name, [&] {
        const HeatSolver solver(input.mesh, {.exact_radius = 0, .intrinsic_delaunay = delaunay});
        (void)solver.distance(input.mesh.faces[0][0]);
      });
    }
  }
}

TEST_CASE("vectors") {
  const VectorHeatSolver solver(icosphere<double>(2));
  check_no_nan("transport", [&] { (void)solver.transport(3, Vec3<double>(1, 2, 3)); });
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
