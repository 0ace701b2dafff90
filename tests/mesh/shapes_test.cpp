#include "gelight/mesh/shapes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/surface.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using gelight::Index;
using gelight::InvalidInput;
using gelight::Mesh;
using gelight::Surface;

namespace {

// Volume inside a closed mesh by the divergence theorem: positive where normals point outwards.
double volume(const Mesh<double>& mesh) {
  double sum = 0;
  const Surface surface(mesh);
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = surface.face(f);
    sum += surface.position(a).dot(gelight::cross(surface.position(b), surface.position(c))) / 6;
  }
  return sum;
}

Index count_borders(const Surface<double>& surface) {
  Index borders = 0;
  for (Index h = 0; h < surface.halfedge_count(); ++h) borders += surface.is_border(h);
  return borders;
}

// Manifold, and neighbours agree in orientation.
bool is_oriented(const Surface<double>& surface) {
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    if (!surface.is_manifold(h)) return false;
    if (!surface.is_border(h) && surface.origin(surface.twin(h)) != surface.tip(h)) return false;
  }
  return true;
}

Index euler(const Surface<double>& surface) {
  const Index edges = (surface.halfedge_count() + count_borders(surface)) / 2;
  return surface.vertex_count() - edges + surface.face_count();
}

}  // namespace

TEST_CASE("closed shapes enclose their volume with normals outwards") {
  const double pi = std::numbers::pi;
  const auto check = [](const Mesh<double>& mesh, double expected, double tolerance, Index chi) {
    const Surface surface(mesh);
    CHECK(is_oriented(surface));
    CHECK(count_borders(surface) == 0);
    CHECK(euler(surface) == chi);
    CHECK(volume(mesh) == gelight::test::approx(expected).epsilon(tolerance));
  };
  check(gelight::box(2.0, 3.0, 4.0), 24, 1e-14, 2);
  check(gelight::icosphere(5, 2.0), 4.0 / 3 * pi * 8, 2e-3, 2);
  check(gelight::torus(2.0, 0.5, 200, 100), 2 * pi * pi * 2 * 0.25, 2e-3, 0);
}

TEST_CASE("an icosphere has 10 4^n + 2 vertices, all on the sphere") {
  for (int level = 0; level < 5; ++level) {
    const auto mesh = gelight::icosphere(level, 3.0);
    CHECK(mesh.positions.size() == 10 * (std::size_t{1} << (2 * level)) + 2);
    for (const auto& p : mesh.positions) {
      CHECK(std::hypot(p[0], p[1], p[2]) == gelight::test::approx(3).epsilon(1e-15));
    }
  }
}

TEST_CASE("a grid covers its rectangle, facing +z") {
  const Surface surface(gelight::grid(4, 3, 2.0, 1.5));
  CHECK(surface.vertex_count() == 20);
  CHECK(count_borders(surface) == 14);
  CHECK(euler(surface) == 1);
  double area = 0;
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = surface.face(f);
    const gelight::Vec3<double> ab = surface.position(b) - surface.position(a);
    const gelight::Vec3<double> ac = surface.position(c) - surface.position(a);
    area += 0.5 * gelight::cross(ab, ac).z();
  }
  CHECK(area == gelight::test::approx(3));
}

TEST_CASE("a membrane is a cylinder with a hemisphere, open at its base") {
  const double radius = 0.01146, length = 0.0455, edge = 0.001;
  const auto mesh = gelight::membrane(radius, length, edge);
  const Surface surface(mesh);
  CHECK(is_oriented(surface));
  CHECK(euler(surface) == 1);
  CHECK(count_borders(surface) == std::lround(2 * std::numbers::pi * radius / edge));
  for (const auto& [x, y, z] : mesh.positions) {
    const double beyond = std::max(0.0, z - (length - radius));
    CHECK(std::hypot(x, y, beyond) == gelight::test::approx(radius).epsilon(1e-12));
  }
  const auto [low, high] =
      std::minmax_element(mesh.positions.begin(), mesh.positions.end(),
                          [](const auto& a, const auto& b) { return a[2] < b[2]; });
  CHECK((*low)[2] == 0);
  CHECK((*high)[2] == length);
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    CHECK(surface.length(h) < 1.6 * edge);
    CHECK(surface.length(h) > 0.4 * edge);
  }
  // Outwards: the base closes the volume with the plane z = 0, which adds nothing to the sum.
  const double pi = std::numbers::pi;
  const double expected =
      pi * radius * radius * (length - radius) + 2.0 / 3 * pi * radius * radius * radius;
  CHECK(volume(mesh) == gelight::test::approx(expected).epsilon(5e-3));
}

TEST_CASE("placed turns, then moves; joined keeps the parts apart") {
  const auto box = gelight::box(1.0, 1.0, 1.0);
  Eigen::Matrix3d quarter;  // about z: x becomes y
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const auto moved = gelight::placed(box, quarter, {10, 0, 0});
  const Mesh<double> both[] = {box, moved};
  const Surface surface(gelight::joined<double>(both));
  CHECK(gelight::joined({box, moved}).positions == gelight::joined<double>(both).positions);
  CHECK(gelight::joined(std::vector{box, moved}).faces == gelight::joined<double>(both).faces);
  CHECK(surface.vertex_count() == 16);
  CHECK(surface.face_count() == 24);
  const auto [x, y, z] = box.positions[1];
  CHECK(surface.position(9).isApprox(gelight::Vec3<double>(10 - y, x, z)));
  CHECK(surface.face(12)[0] == surface.face(0)[0] + 8);
  CHECK(gelight::nearest_vertex(surface, surface.position(11)) == 11);
}

TEST_CASE("shapes that cannot be are refused") {
  CHECK_THROWS_AS((void)gelight::grid(0, 1, 1.0, 1.0), InvalidInput);
  CHECK_THROWS_AS((void)gelight::grid(1, 1, 1.0, -1.0), InvalidInput);
  CHECK_THROWS_AS((void)gelight::icosphere(-1, 1.0), InvalidInput);
  CHECK_THROWS_AS((void)gelight::icosphere(1, 0.0), InvalidInput);
  CHECK_THROWS_AS((void)gelight::box(1.0, 0.0, 1.0), InvalidInput);
  CHECK_THROWS_AS((void)gelight::membrane(0.01, 0.005, 0.001), InvalidInput);
  CHECK_THROWS_AS((void)gelight::membrane(0.01, 0.05, 0.0), InvalidInput);
  // More vertices than can be counted: in a ring, of rings.
  CHECK_THROWS_AS((void)gelight::membrane(0.01, 0.05, 1e-300), InvalidInput);
  CHECK_THROWS_AS((void)gelight::membrane(1e-3, 1e6, 1e-3), InvalidInput);
  // In all of them together: said before the memory is full of them.
  CHECK_THROWS_AS((void)gelight::membrane(0.01f, 0.05f, 1e-9f), InvalidInput);
  CHECK_THROWS_AS((void)gelight::membrane(0.01, 0.05, 1e-6), InvalidInput);
  CHECK_THROWS_AS((void)gelight::grid(1 << 16, 1 << 16, 1.0, 1.0), InvalidInput);
  CHECK_THROWS_AS((void)gelight::torus(2.0, 1.0, 1 << 16, 1 << 16), InvalidInput);
  const std::vector<gelight::ProfilePoint<double>> wall(1000, {1, 0});
  CHECK_THROWS_AS((void)gelight::revolve<double>(wall, 1e-6), InvalidInput);
  CHECK_THROWS_AS((void)gelight::torus(1.0, 2.0, 10, 10), InvalidInput);
  const gelight::ProfilePoint<double> axis[] = {{0, 0}, {0, 1}};
  CHECK_THROWS_AS((void)gelight::revolve<double>(axis, 0.1), InvalidInput);
}

TEST_CASE("shapes without an end are refused") {
  for (const double none :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_THROWS_AS((void)gelight::grid(1, 1, none, 1.0), InvalidInput);
    CHECK_THROWS_AS((void)gelight::grid(1, 1, 1.0, none), InvalidInput);
    CHECK_THROWS_AS((void)gelight::icosphere(1, none), InvalidInput);
    CHECK_THROWS_AS((void)gelight::box(1.0, none, 1.0), InvalidInput);
    CHECK_THROWS_AS((void)gelight::box(1.0, 1.0, none), InvalidInput);
    CHECK_THROWS_AS((void)gelight::membrane(none, 0.05, 0.001), InvalidInput);
    CHECK_THROWS_AS((void)gelight::membrane(0.01, none, 0.01), InvalidInput);
    CHECK_THROWS_AS((void)gelight::membrane(none, none, none), InvalidInput);
    CHECK_THROWS_AS((void)gelight::torus(none, 1.0, 10, 10), InvalidInput);
    const gelight::ProfilePoint<double> wide[] = {{1, 0}, {none, 1}}, high[] = {{1, 0}, {1, none}};
    CHECK_THROWS_AS((void)gelight::revolve<double>(wide, 0.1), InvalidInput);
    CHECK_THROWS_AS((void)gelight::revolve<double>(high, 0.1), InvalidInput);
    CHECK_THROWS_AS((void)gelight::revolve<double>(wide, none), InvalidInput);
  }
}

TEST_CASE("shapes beyond the numbers of their type are refused, and those within are whole") {
  const float most = std::numeric_limits<float>::max();
  CHECK_THROWS_AS((void)gelight::torus(3e38f, 2e38f, 8, 8), InvalidInput);
  CHECK_THROWS_AS((void)gelight::torus(1.7e308, 1.6e308, 8, 8), InvalidInput);
  CHECK_THROWS_AS((void)gelight::membrane(3e38f, most, 1e38f), InvalidInput);
  CHECK_THROWS_AS((void)gelight::membrane(1.7e308, 1.75e308, 1e308), InvalidInput);
  for (const float width : {1e37f, most}) {
    const auto sheet = gelight::grid(100, 100, width, 1.0f);
    for (Index i = 0; i <= 100; ++i) {
      const double x = double{sheet.position(i)[0]};
      CHECK(x == gelight::test::approx(double{width} * i / 100).epsilon(1e-6));
    }
    CHECK(sheet.position(100)[0] == width);
  }
}

TEST_CASE("parts that are joined share nothing, also where a face names a vertex of none") {
  const Mesh<double> sheet = gelight::grid(1, 1, 1.0, 1.0);
  for (const Index stray : {4, 7, -1, std::numeric_limits<Index>::max()}) {
    Mesh<double> torn = sheet;
    torn.faces.push_back({0, 1, stray});
    const std::string said = gelight::test::refusal([&] {
      (void)gelight::joined({sheet, torn, sheet});
    });
    CHECK(said ==
          "face 2 of part 1 has vertex " + std::to_string(stray) + ", the part has 4 vertices");
  }
}

TEST_CASE("a mesh is placed by finite numbers only") {
  const Mesh<double> sheet = gelight::grid(1, 1, 1.0, 1.0);
  const double none = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  CHECK_THROWS_AS((void)gelight::placed(sheet, turn, {0, none, 0}), InvalidInput);
  turn(1, 2) = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS((void)gelight::placed(sheet, turn, {0, 0, 0}), InvalidInput);
}
