#include "gelight/geodesic/isoline.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Random;

TEST_CASE("a linear function on a sheet: straight lines and what they cut off, to rounding") {
  Random random(4);
  const auto mesh = test::jittered_grid(12, 0.25, random);
  const Surface<double> surface(mesh);
  for (int i = 0; i < 30; ++i) {
    const double angle = test::uniform(random, -3, 3), level = test::uniform(random, -4, 4);
    const Vec3<double> d(std::cos(angle), std::sin(angle), 0), middle(6, 6, 0);
    std::vector<double> values;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      values.push_back(d.dot(surface.position(v) - middle));
    }
    const auto lines = isolines(surface, values, level);
    REQUIRE(lines.size() == 1);
    CHECK_FALSE(lines[0].is_closed);
    const auto places = positions(surface, lines[0].points);
    for (const auto& p : places)
      CHECK(d.dot(p - middle) == gelight::test::approx(level).epsilon(1e-11));
    const Vec3<double> way = places.back() - places.front();
    CHECK(length(surface, lines[0].points) == gelight::test::approx(way.norm()).epsilon(1e-12));
    // Low values to the left.
    CHECK(cross(way, d)[2] < 0);
    // Both sides of the line are the sheet; by symmetry the other side is that below the negative.
    std::vector<double> negative(values);
    for (double& x : negative) x = -x;
    CHECK(area_below(surface, values, level) + area_below(surface, negative, -level) ==
          gelight::test::approx(144).epsilon(1e-12));
    if (std::abs(angle) < 0.4) {  // a trapezium
      CHECK(area_below(surface, values, level) ==
            gelight::test::approx(12 * (6 + level / std::cos(angle))).epsilon(1e-11));
    }
  }
}

TEST_CASE("circles round a point of a sphere: length, area, order") {
  double before_length = 0, before_area = 0;
  for (const int level : {3, 4, 5}) {
    const auto mesh = icosphere<double>(level);
    const Surface<double> surface(mesh);
    const auto distance = ExactSolver(mesh).distance(7);
    double off_length = 0, off_area = 0;
    for (const double r : {0.6, 1.1, 1.9, 2.4}) {
      const auto lines = isolines(surface, distance, r);
      REQUIRE(lines.size() == 1);
      CHECK(lines[0].is_closed);
      CHECK(lines[0].points.front() == lines[0].points.back());
      const double circle = 2 * std::numbers::pi * std::sin(r);
      const double cap = 2 * std::numbers::pi * (1 - std::cos(r));
      off_length = std::max(off_length, std::abs(length(surface, lines[0].points) / circle - 1));
      off_area = std::max(off_area, std::abs(area_below(surface, distance, r) / cap - 1));
    }
    if (level > 3) {
      CHECK(off_length < before_length / 3);
      CHECK(off_area < before_area / 3);
    }
    before_length = off_length;
    before_area = off_area;
  }
  CHECK(before_length < 2e-3);
  CHECK(before_area < 2e-3);
}

TEST_CASE("every crossed edge is on a line once a side, on rough and open meshes") {
  for (const test::NamedMesh& named : test::scan_meshes(2)) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const Surface<double> surface(mesh);
    const auto distance = ExactSolver(mesh).distance(0);
    double most = 0;
    for (const double d : distance) most = std::isfinite(d) ? std::max(most, d) : most;
    for (const double share : {0.2, 0.5, 0.8}) {
      const double level = share * most;
      Index crossed = 0;
      for (Index f = 0; f < surface.face_count(); ++f) {
        int low = 0;
        for (const Index v : surface.face(f)) low += distance[static_cast<std::size_t>(v)] < level;
        crossed += low == 1 || low == 2;
      }
      const auto lines = isolines(surface, distance, level);
      std::size_t pieces = 0;
      bool meets_vertex = false;  // which faces there are touched in, at no length
      for (const auto& line : lines) {
        pieces += line.points.size() - 1;
        for (const auto& p : line.points) {
          meets_vertex |= p.kind == SurfacePoint<double>::Kind::vertex;
          if (p.kind != SurfacePoint<double>::Kind::edge) continue;
          const double a = distance[static_cast<std::size_t>(p.element[0])];
          const double b = distance[static_cast<std::size_t>(p.element[1])];
          CHECK(p.weights[0] * a + p.weights[1] * b == gelight::test::approx(level).epsilon(1e-12));
        }
        if (line.is_closed) continue;
        // An open line ends at borders.
        for (const auto& p : {line.points.front(), line.points.back()}) {
          CHECK(surface.is_border(surface.find_halfedge(p.element[0], p.element[1])));
        }
      }
      CHECK(pieces <= static_cast<std::size_t>(crossed));
      if (!meets_vertex) CHECK(pieces == static_cast<std::size_t>(crossed));
    }
  }
}

// Whatever unit values are in, as far as a type holds it: differences may be more than it holds.
TEST_CASE_TEMPLATE("the least and the largest values there are cut as others do", T, float,
                   double) {
  const Mesh<T> mesh = grid<T>(3, 1, 3, 1);
  const Surface<T> surface(mesh);
  for (const T unit : {std::numeric_limits<T>::max(), T(1), std::numeric_limits<T>::min(),
                       8 * std::numeric_limits<T>::denorm_min()}) {
    CAPTURE(unit);
    // -1 at x = 0, 1 at x = 1, then down to -1 at x = 2 and up again: linear, so 0.5 is at x =
    // 0.75, 1.25 and 2.75.
    std::vector<T> values;
    for (const auto& p : mesh.positions) {
      values.push_back(std::fmod(p[0], T(2)) == T(0) ? -unit : unit);
    }
    const auto lines = isolines(surface, values, unit / 2);
    REQUIRE(lines.size() == 3);
    for (const auto& line : lines) {
      CHECK(length(surface, line.points) == gelight::test::approx(1));
      for (const auto& p : line.points) {
        const T x = surface.position(p)[0];
        CHECK(std::min({std::fabs(x - T(0.75)), std::fabs(x - T(1.25)), std::fabs(x - T(2.75))}) <
              T(1e-6));
      }
    }
    CHECK(area_below(surface, values, unit / 2) == gelight::test::approx(2.25));
  }
}

TEST_CASE("infinite values, no line, and bad input") {
  const std::vector<Mesh<double>> parts{icosphere<double>(2), box<double>(1, 1, 1)};
  const auto mesh = joined<double>(parts);
  const Surface<double> surface(mesh);
  auto distance = ExactSolver(mesh).distance(0);
  CHECK(isolines(surface, distance, 1.0).size() == 1);
  CHECK(isolines(surface, distance, 99.0).empty());
  CHECK(isolines(surface, distance, -1.0).empty());
  CHECK(area_below(surface, distance, -1.0) == 0);
  CHECK_THROWS_AS((void)isolines(surface, distance, std::numeric_limits<double>::infinity()),
                  InvalidInput);
  distance[3] = std::nan("");
  CHECK_THROWS_AS((void)isolines(surface, distance, 1.0), InvalidInput);
  distance.pop_back();
  CHECK_THROWS_AS((void)area_below(surface, distance, 1.0), InvalidInput);
}

TEST_CASE("an area that float cannot hold is refused; one that it holds comes out") {
  const auto area = [](float size) {
    const Surface<float> sheet(gelight::grid<float>(2, 3, size, size));
    return area_below(sheet, std::vector<float>(12, 0), 1.0F);
  };
  CHECK(area(1.8e19F) == gelight::test::approx(3.24e38).epsilon(1e-6));
  CHECK(area(1e-18F) == gelight::test::approx(1e-36).epsilon(1e-6));
  for (const float size : {1.9e19F, 1e25F, 1e38F}) {
    CHECK(gelight::test::contains(gelight::test::refusal([&] { (void)area(size); }),
                                  "more than its type can hold"));
  }
}
