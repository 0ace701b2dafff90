#include "gelight/mesh/intrinsic.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gelight/mesh/operators.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;

namespace {

double area_of(const IntrinsicTriangulation<double>& mesh) {
  double area = 0;
  for (const auto& face : planar_faces(mesh)) area += face.x1 * face.y2 / 2;
  return area;
}

// Twins agree in length and ends, and no angles opposite an edge sum to more than pi.
void check_delaunay(const IntrinsicTriangulation<double>& mesh) {
  const auto faces = planar_faces(mesh);
  const auto weight = [&](Index h) {
    return half_cotangents(faces[h / 3])[static_cast<std::size_t>(h % 3)];
  };
  const auto tip = [&](Index h) { return mesh.origins[h % 3 == 2 ? h - 2 : h + 1]; };
  for (Index h = 0; h < static_cast<Index>(mesh.origins.size()); ++h) {
    const Index t = mesh.twins[h];
    if (t < 0) continue;
    CHECK(mesh.twins[t] == h);
    CHECK(mesh.origins[t] == tip(h));
    CHECK(mesh.lengths[t] == gelight::test::approx(mesh.lengths[h]).epsilon(1e-12));
    if (t / 3 == h / 3) continue;
    CHECK(weight(h) + weight(t) > -1e-9 * (1 + std::abs(weight(h)) + std::abs(weight(t))));
  }
}

Mesh<double> stretched(Mesh<double> mesh, double factor) {
  for (auto& p : mesh.positions) p[0] *= factor;
  return mesh;
}

}  // namespace

TEST_CASE("flips make a mesh Delaunay and keep its area") {
  for (const auto& mesh :
       {stretched(icosphere<double>(3), 10), stretched(grid<double>(9, 9), 50),
        stretched(torus(2.0, 0.7, 24, 11), 7), box(1.0, 8.0, 0.1), icosphere<double>(2)}) {
    const Surface surface(mesh);
    const auto before = intrinsic_triangulation(surface);
    const auto after = intrinsic_delaunay(surface);
    check_delaunay(after);
    CHECK(area_of(after) == gelight::test::approx(area_of(before)).epsilon(1e-9));
    CHECK(after.face_count() == before.face_count());
  }
}

TEST_CASE("flat sheet: new edges are as long as the plane says") {
  const auto mesh = stretched(grid<double>(6, 6), 20);
  const auto flat = intrinsic_delaunay(Surface(mesh));
  for (Index h = 0; h < static_cast<Index>(flat.origins.size()); ++h) {
    const auto& a = mesh.positions[static_cast<std::size_t>(flat.origins[h])];
    const Index tip = flat.origins[h % 3 == 2 ? h - 2 : h + 1];
    const auto& b = mesh.positions[static_cast<std::size_t>(tip)];
    CHECK(flat.lengths[h] ==
          gelight::test::approx(std::hypot(a[0] - b[0], a[1] - b[1])).epsilon(1e-9));
  }
}

TEST_CASE("faces without area: it ends, and every face has an area") {
  // A fan whose middle vertices lie on the long edge, and a pair at one place.
  const Mesh<double> caps{
      {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0.25, 0, 0}, {0.5, 1, 0}, {0.5, 0, 0}},
      {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}, {1, 2, 5}}};
  const auto mesh = intrinsic_delaunay(Surface(caps));
  for (const auto& face : planar_faces(mesh)) {
    CHECK(face.x1 > 0);
    CHECK(face.y2 > 0);
    CHECK(std::isfinite(face.x2));
  }
  check_delaunay(mesh);
}

TEST_CASE("edges of three faces, or of faces oriented against each other, stay") {
  const Mesh<double> fin{{{0, 0, 0}, {9, 0, 0}, {4, 1, 0}, {4, -1, 0}, {4, 0, 1}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  const auto kept = intrinsic_delaunay(Surface(fin));
  CHECK(kept.lengths[0] == gelight::test::approx(9));
  const Mesh<double> opposed{{{0, 0, 0}, {9, 0, 0}, {4, 1, 0}, {4, -1, 0}}, {{0, 1, 2}, {0, 1, 3}}};
  CHECK(intrinsic_delaunay(Surface(opposed)).lengths[0] == gelight::test::approx(9));
  const Mesh<double> agreed{{{0, 0, 0}, {9, 0, 0}, {4, 1, 0}, {4, -1, 0}}, {{0, 1, 2}, {1, 0, 3}}};
  CHECK(intrinsic_delaunay(Surface(agreed)).lengths[0] == gelight::test::approx(2));
}

TEST_CASE("a unit of lengths that is no positive number is refused") {
  const Surface surface(grid<double>(2, 2));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double unit : {0.0, -0.0, -1.0, infinity, -infinity, std::nan("")}) {
    CHECK(test::contains(test::refusal([&] { (void)intrinsic_triangulation(surface, unit); }),
                         "the unit of lengths"));
    CHECK_THROWS_AS((void)intrinsic_delaunay(surface, unit), InvalidInput);
  }
  CHECK(intrinsic_triangulation(surface, 0.25).lengths[0] == 4 * surface.length(0));
}
