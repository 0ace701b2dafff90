#include "gelight/mesh/simplified.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "gelight/mesh/shapes.hpp"
#include "support/hard_meshes.hpp"

using gelight::edge_point;
using gelight::face_point;
using gelight::Index;
using gelight::Mesh;
using gelight::Surface;
using gelight::SurfacePoint;
using gelight::vertex_point;
using gelight::detail::simplified;
using gelight::test::Random;
using gelight::test::uniform;
using gelight::test::uniform_index;

TEST_CASE("a point is named by the smallest element that holds it, but for rounding") {
  const Surface<double> surface(gelight::grid<double>(3, 3, 3, 3));
  const auto [a, b, c] = surface.face(4);
  const auto edge = [&](Index u, Index v, double t) {
    return simplified(surface, edge_point<double>(u, v, t));
  };
  for (const double little : {0.0, 1e-300, 1e-20, 1e-17, 8e-16}) {
    CHECK(edge(a, b, little) == vertex_point<double>(a));
    CHECK(edge(a, b, 1 - little) == vertex_point<double>(b));
    CHECK(simplified(surface, face_point<double>(4, {little, 1 - little, 0})) ==
          vertex_point<double>(b));
    CHECK(simplified(surface, face_point<double>(4, {little, little, 1 - 2 * little})) ==
          vertex_point<double>(c));
    const auto on_edge = simplified(surface, face_point<double>(4, {0.25, little, 0.75 - little}));
    CHECK(on_edge.kind == SurfacePoint<double>::Kind::edge);
    CHECK(on_edge.element == std::array<Index, 2>{std::min(a, c), std::max(a, c)});
  }
  for (const double more : {1e-14, 1e-10, 0.5}) {
    CHECK(edge(a, b, more).kind == SurfacePoint<double>::Kind::edge);
    CHECK(edge(a, b, more).element == edge(b, a, more).element);
    const auto inside = face_point<double>(4, {more / 2, more / 2, 1 - more});
    CHECK(simplified(surface, inside) == inside);
  }
}

TEST_CASE("moved to where it counts as, a point moves by rounding of its edges") {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const Mesh<double> mesh = gelight::test::small_random_mesh(i, random);
    const Surface<double> surface(mesh);
    const Index f = uniform_index(random, surface.face_count());
    std::array<double, 3> w{};
    for (double& x : w) x = std::pow(10, uniform(random, -20, 0));
    const double sum = w[0] + w[1] + w[2];
    for (double& x : w) x /= sum;
    const auto point = face_point<double>(f, w);
    double longest = 0;
    for (Index h = 3 * f; h < 3 * f + 3; ++h) longest = std::max(longest, surface.length(h));
    const double moved = surface.difference(point, simplified(surface, point)).norm();
    CHECK(moved <= 1e-14 * longest);
  }
}
