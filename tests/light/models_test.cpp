#include "gelight/light/models.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "gelight/views/mesh_view.hpp"

using namespace gelight;

namespace {

// As the concept's own page has it.
struct Sunlight {
  Vec3<float> way;
  std::vector<Vec3<float>> field(const Led<float>&, std::span<const SurfacePoint<float>> points,
                                 const CancelHook& = {}) const {
    return std::vector<Vec3<float>>(points.size(), way);
  }
};
static_assert(LightModel<Sunlight, float> && !LightModel<Sunlight, double> &&
              !LightModel<int, float>);
static_assert(LightModel<LinearLight<float>, float> && LightModel<PlaneLight<float>, float> &&
              LightModel<GeodesicLight<float>, float> && LightModel<TransportLight<float>, float> &&
              LightModel<GelLight<float>, float>);

constexpr Index cells = 12;

// A square plate in z = 0.02, turned and shifted from the grid's own axes by its diagonals alone.
template <class T>
Mesh<T> plate() {
  Mesh<T> mesh;
  for (Index y = 0; y <= cells; ++y) {
    for (Index x = 0; x <= cells; ++x) mesh.positions.push_back({T(x), T(y), T(20)});
  }
  const auto at = [](Index x, Index y) { return y * (cells + 1) + x; };
  for (Index y = 0; y < cells; ++y) {
    for (Index x = 0; x < cells; ++x) {
      if ((x + y) % 2 == 0) {
        mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
        mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
      } else {
        mesh.faces.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
        mesh.faces.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
      }
    }
  }
  return mesh;
}

template <class T>
std::vector<SurfacePoint<T>> random_points(std::mt19937& random, const Mesh<T>& mesh) {
  std::uniform_real_distribution<T> share(T(0.05), 1);
  std::vector<SurfacePoint<T>> points;
  for (int i = 0; i < 60; ++i) {
    const T a = share(random), b = share(random), c = share(random), sum = a + b + c;
    const auto face = static_cast<Index>(random() % mesh.faces.size());
    points.push_back(face_point<T>(face, {a / sum, b / sum, c / sum}));
  }
  return points;
}

}  // namespace

TEST_CASE("on a plate every model's light leaves the nearest point of the LED straight") {
  using T = double;
  const auto mesh = plate<T>();
  const Surface<T> surface(mesh);
  const LinearLight linear(mesh);
  const PlaneLight plane(mesh);
  const GeodesicLight geodesic(mesh);
  std::mt19937 random(5);
  for (int round = 0; round < 8; ++round) {
    const auto points = random_points(random, mesh);
    Led<T> led{random_points(random, mesh)};
    led.points.resize(round < 4 ? 1 : 3);
    const auto check = [&](const auto& model) {
      const auto field = model.field(led, points);
      const auto rays = model.rays(led, points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        Vec3<T> way = Vec3<T>::Constant(std::numeric_limits<T>::infinity());
        T next = way.x();
        for (const auto& point : led.points) {
          const Vec3<T> from = surface.position(points[i]) - surface.position(point);
          next = std::min(next, std::max(way.norm(), from.norm()));
          if (from.norm() < way.norm()) way = from;
        }
        CHECK(std::abs(rays.distance[i] - way.norm()) < T(1e-5));
        if (next - way.norm() < T(1e-4) || way.norm() < T(1e-2)) continue;
        CHECK((field[i] - way.normalized()).norm() < 1e-9);
        CHECK((rays.direction[i] - way.normalized()).norm() < 1e-9);
      }
    };
    check(linear);
    check(plane);
    check(geodesic);
  }
}

TEST_CASE("carried light keeps its emission on a plate, from any number of points") {
  using T = double;
  const auto mesh = plate<T>();
  const TransportLight model(mesh);
  std::mt19937 random(6);
  const auto points = random_points(random, mesh);
  Led<T> led{random_points(random, mesh), Vec3<T>(3, -4, 7)};
  for (const std::size_t count : {std::size_t{1}, std::size_t{4}}) {
    led.points.resize(count == 1 ? 1 : led.points.size());
    for (const Vec3<T>& way : model.field(led, points)) {
      CHECK((way - Vec3<T>(T(0.6), T(-0.8), 0)).norm() < T(1e-4));
    }
  }
  // Every way: the vector heat method is near the truth, away from the LED.
  const Surface<T> surface(mesh);
  const Led<T> middle{{vertex_point<T>((cells + 1) * (cells / 2) + cells / 2)}};
  const auto field = model.field(middle, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<T> way = surface.position(points[i]) - surface.position(middle.points[0]);
    if (way.norm() > 2) CHECK(field[i].dot(way.normalized()) > T(0.97));
  }
}

TEST_CASE("fields of points in a vector need no word about their type") {
  const auto mesh = plate<double>();
  const Surface<double> surface(mesh);
  std::mt19937 random(7);
  const auto points = random_points(random, mesh);
  const auto led = vertex_point<double>(20);
  CHECK(linear_field(surface, surface.position(led), points) ==
        LinearLight(mesh).field({{led}}, points));
  CHECK(plane_field(surface, led, points) == PlaneLight(mesh).field({{led}}, points));
  CHECK(geodesic_field(ExactSolver(mesh), led, points) ==
        GeodesicLight(mesh).field({{led}}, points));
  CHECK(transport_field(VectorHeatSolver(mesh), 20, Vec3<double>(1, 0, 0), points) ==
        TransportLight(mesh).field({{led}, Vec3<double>(1, 0, 0)}, points));
}

TEST_CASE("an LED that is none is refused by every model") {
  const auto mesh = plate<double>();
  std::mt19937 random(8);
  const auto points = random_points(random, mesh);
  const auto check = [&](const auto& model) {
    CHECK_THROWS_AS((void)model.field({}, points), InvalidInput);
    CHECK_THROWS_AS((void)model.field({{vertex_point<double>(9999)}}, points), InvalidInput);
    CHECK_THROWS_AS((void)model.field({{points[0]}, Vec3<double>(1, std::nan(""), 0)}, points),
                    InvalidInput);
  };
  check(LinearLight(mesh));
  check(PlaneLight(mesh));
  check(GeodesicLight(mesh));
  check(TransportLight(mesh));
  CHECK_THROWS_AS((void)TransportLight(mesh).field({{points[0]}}, points), InvalidInput);
}
