#include "gelight/geodesic/exact_isoline.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Random;
using test::uniform;

namespace {

using Point = SurfacePoint<double>;
constexpr double pi = std::numbers::pi;

ExactOptions<double> keeping() {
  ExactOptions<double> options;
  options.keep_windows = true;
  return options;
}

double length_of(const std::vector<ExactIsoline<double>>& lines) {
  double sum = 0;
  for (const auto& line : lines) sum += line.length();
  return sum;
}

// Arcs follow one on another, lie in their faces and at the level, and are as long as they say.
void check_arcs(const ExactField<double>& field, const Surface<double>& surface, double level,
                double rounding) {
  for (const auto& line : exact_isolines(field, level)) {
    REQUIRE(!line.arcs.empty());
    for (std::size_t i = 0; i < line.arcs.size(); ++i) {
      const auto& arc = line.arcs[i];
      if (i > 0) CHECK((line.arcs[i - 1].end - arc.begin).norm() <= rounding);
      CHECK((arc.begin - arc.centre).norm() == gelight::test::approx(arc.radius).epsilon(1e-9));
      // Half way along it.
      const auto v = surface.face(arc.face);
      const Vec3<double>&p = surface.position(v[0]), &q = surface.position(v[1]),
            &r = surface.position(v[2]);
      const Vec3<double> normal = cross<double>(q - p, r - p).normalized();
      const Vec3<double> from = arc.begin - arc.centre;
      const double half = arc.angle / 2;
      const Vec3<double> middle =
          arc.centre + std::cos(half) * from + std::sin(half) * cross<double>(normal, from);
      const double whole = cross<double>(q - p, r - p).norm();
      std::array<double, 3> shares{cross<double>(q - middle, r - middle).dot(normal) / whole,
                                   cross<double>(r - middle, p - middle).dot(normal) / whole, 0};
      shares[2] = 1 - shares[0] - shares[1];
      for (const double share : shares) CHECK(share >= -1e-7);
      for (double& share : shares) share = std::max(0.0, share);
      const double sum = shares[0] + shares[1] + shares[2];
      for (double& share : shares) share /= sum;
      CHECK(field.distance(face_point(arc.face, shares)) ==
            gelight::test::approx(level).epsilon(1e-7));
    }
    if (line.is_closed) {
      CHECK((line.arcs.back().end - line.arcs.front().begin).norm() <= rounding);
    }
  }
}

void check_closed(const ExactField<double>& field, Random& random) {
  for (int k = 0; k < 4; ++k) {
    const double level = uniform(random, 0.05, 2);
    CAPTURE(level);
    for (const auto& line : exact_isolines(field, level)) CHECK(line.is_closed);
  }
}

}  // namespace

TEST_CASE("a flat sheet: circles, whole and cut off by the border") {
  Random random(1);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Mesh<double> mesh = test::jittered_grid(12, 0.2, random);
    for (auto& p : mesh.positions) {
      for (double& x : p) x *= scale;
    }
    const Surface<double> surface(mesh);
    const ExactSolver solver(mesh, keeping());
    for (int i = 0; i < 6; ++i) {
      const double x = uniform(random, 4, 8), y = uniform(random, 4, 8);
      const Point source = nearest_point<double>(surface, {x * scale, y * scale, 0});
      const auto field = solver.solve(source);
      const double r = uniform(random, 0.01, 4) * scale;
      const auto lines = exact_isolines(field, r);
      REQUIRE(lines.size() == 1);
      CHECK(lines[0].is_closed);
      CHECK(lines[0].length() == gelight::test::approx(2 * pi * r).epsilon(1e-10));
      CHECK(area_within(field, r) == gelight::test::approx(pi * r * r).epsilon(1e-10));
      check_arcs(field, surface, r, 1e-10 * 12 * scale);
    }
    // Half a circle about the middle of the lower side, and what is left of a circle about a
    // corner.
    const auto half = solver.solve(Index{6});
    CHECK(length_of(exact_isolines(half, 3.5 * scale)) ==
          gelight::test::approx(3.5 * pi * scale).epsilon(1e-10));
    CHECK(area_within(half, 3.5 * scale) ==
          gelight::test::approx(3.5 * 3.5 / 2 * pi * scale * scale).epsilon(1e-10));
    const auto corner = solver.solve(Index{0});
    const double r = 13 * scale, beyond = std::acos(12.0 / 13);
    const auto lines = exact_isolines(corner, r);
    REQUIRE(lines.size() == 1);
    CHECK(!lines[0].is_closed);
    CHECK(lines[0].length() == gelight::test::approx(r * (pi / 2 - 2 * beyond)).epsilon(1e-10));
    CHECK(area_within(corner, r) ==
          gelight::test::approx(12 * 5 * scale * scale + r * r * (pi / 2 - 2 * beyond) / 2)
              .epsilon(1e-10));
    // Beyond all there is.
    CHECK(exact_isolines(corner, 18 * scale).empty());
    CHECK(area_within(corner, 18 * scale) ==
          gelight::test::approx(144 * scale * scale).epsilon(1e-12));
    CHECK(exact_isolines(corner, 0.0).empty());
    CHECK(area_within(corner, -1.0) == 0);
  }
}

TEST_CASE("a flat sheet: from beside a vertex nothing but the circle") {
  test::Random random(11);
  const auto mesh = test::jittered_grid(6, 0.25, random);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  double off = 0;
  for (int i = 0; i < 3000; ++i) {
    const double aside = std::pow(10, test::uniform(random, -6, -4.5));
    const double turn = test::uniform(random, 0, 2 * std::numbers::pi);
    const Index v = test::uniform_index(random, surface.vertex_count());
    const Vec3<double> at =
        surface.position(v) + aside * Vec3<double>(std::cos(turn), std::sin(turn), 0);
    const auto source = nearest_point(surface, at);
    const Vec3<double> centre = surface.position(source);
    const double level = test::uniform(random, 2, 6);
    for (const auto& line : exact_isolines(solver.solve(source), level)) {
      for (const auto& arc : line.arcs) {
        off = std::max(off, std::abs((arc.begin - centre).norm() - level));
      }
    }
  }
  CHECK(off <= 1e-9);
}

TEST_CASE("a flat sheet: circles go on over faces so thin that they hold none of them") {
  test::Random random(4);
  for (int i = 0; i < 60; ++i) {
    Mesh<double> mesh = grid<double>(3, 3, 3, 3);
    for (int k = 0; k < 12; ++k) {
      // A new vertex next to an edge.
      const Index f = test::uniform_index(random, Index(mesh.faces.size()));
      const double thin = std::pow(10.0, -test::uniform(random, 9, 12));
      const double t = test::uniform(random, 0.3, 0.7);
      test::split_face(mesh, f, t, thin);
    }
    const ExactSolver solver(mesh, keeping());
    const auto lines = exact_isolines(solver.solve(Index(5 + i % 2)), 0.83);
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].is_closed);
    CHECK(lines[0].length() == gelight::test::approx(2 * std::numbers::pi * 0.83).epsilon(1e-9));
  }
}

TEST_CASE("a flat sheet: from all but on an edge and another place the area is both circles'") {
  test::Random random(9);
  const auto mesh = test::jittered_grid(6, 0.25, random);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  for (int i = 0; i < 1000; ++i) {
    const double aside = std::pow(10, test::uniform(random, -14, -11));
    const double share = test::uniform(random, 0.1, 0.9);
    const Index f = test::uniform_index(random, surface.face_count());
    const SurfacePoint<double> beside = face_point<double>(f, {share, 1 - share - aside, aside});
    const double turn = test::uniform(random, 0, 2 * std::numbers::pi);
    const Vec3<double> near =
        surface.position(beside) +
        test::uniform(random, 0.2, 0.8) * Vec3<double>(std::cos(turn), std::sin(turn), 0);
    const std::vector<Source<double>> sources{{beside, 0}, {nearest_point(surface, near), 0}};
    double room = 6;
    for (const auto& source : sources) {
      const Vec3<double> at = surface.position(source.point);
      room = std::min({room, at[0], at[1], 6 - at[0], 6 - at[1]});
    }
    const double r = test::uniform(random, 0, room);
    const double apart =
        (surface.position(sources[0].point) - surface.position(sources[1].point)).norm();
    const double half = apart < 2 * r ? std::acos(apart / (2 * r)) : 0;
    const double both = r * r * (2 * half - std::sin(2 * half));
    CHECK(area_within(solver.solve(std::span<const Source<double>>(sources)), r) ==
          gelight::test::approx(2 * std::numbers::pi * r * r - both).epsilon(1e-10).scale(0.02));
  }
}

TEST_CASE("circles that touch edges of a lattice at vertices, or all but touch them") {
  for (const Index cells : {10, 30}) {
    const auto mesh = grid<double>(cells, cells, 2.0, 2.0);
    const auto field = ExactSolver(mesh).solve((cells + 2) * cells / 2, keeping());
    const double spacing = 2.0 / cells;
    for (const double of_diagonal : {1.0, std::sqrt(0.5), std::sqrt(2.0)}) {
      for (const double off : {0.0, -1e-15, 1e-15, -3e-13, 3e-13, -1e-9, 1e-9}) {
        for (int k = 1; k * spacing * of_diagonal < 0.99; ++k) {
          const double level = k * spacing * of_diagonal * (1 + off);
          CAPTURE(level);
          const auto lines = exact_isolines(field, level);
          REQUIRE(lines.size() == 1);
          CHECK(lines[0].is_closed);
          // Where a circle goes a little beyond a side, it is rounding over the root of that little
          // that the ends of arcs are off by.
          const double rounding = off == 0 ? 1e-12 : 5e-9;
          CHECK(std::abs(length_of(lines) - 2 * pi * level) < rounding);
          CHECK(std::abs(area_within(field, level) - pi * level * level) < 1e-10);
        }
      }
    }
  }
}

TEST_CASE("a cone and a saddle: about the apex, and about a point before it") {
  for (const double angle : {1.0, 3.0, 5.0, 7.0, 9.0}) {
    const std::vector<double> radii{0.5, 1, 1.6, 2};
    const auto mesh = test::cone(angle, 24, radii);
    const ExactSolver solver(mesh, keeping());
    // The cone's border is a polygon: inside of it only.
    const double r = 1.9 * std::cos(angle / 48);
    const auto about_apex = solver.solve(Index{0});
    CHECK(length_of(exact_isolines(about_apex, r)) ==
          gelight::test::approx(angle * r).epsilon(1e-10));
    CHECK(area_within(about_apex, r) == gelight::test::approx(angle * r * r / 2).epsilon(1e-10));
    if (angle < 2 * pi) continue;
    // From distance 0.5 the rest beyond the apex is seen by way of it alone: two sectors of a
    // circle that end at the lines past the apex, and between them one about the apex.
    const auto field = solver.solve(Index{1});
    const double s = 0.5, t = 1.2;
    // About the apex lies angle - 2 pi; the whole circle about the source lacks nothing else.
    const double length = 2 * pi * t + (angle - 2 * pi) * (t - s);
    CHECK(length_of(exact_isolines(field, t)) == gelight::test::approx(length).epsilon(1e-10));
    const double area = pi * t * t + (angle - 2 * pi) * (t - s) * (t - s) / 2;
    CHECK(area_within(field, t) == gelight::test::approx(area).epsilon(1e-10));
    check_arcs(field, solver.surface(), t, 1e-10);
  }
}

TEST_CASE("a box: round an edge circles stay circles, and a corner takes a quarter of the turn") {
  const auto mesh = box<double>(2, 2, 2);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  const auto top = solver.solve(nearest_point<double>(surface, {0, 0, 1}));
  for (const double r : {0.5, 1.2, 1.4}) {
    CHECK(length_of(exact_isolines(top, r)) == gelight::test::approx(2 * pi * r).epsilon(1e-10));
    CHECK(area_within(top, r) == gelight::test::approx(pi * r * r).epsilon(1e-10));
  }
  const auto corner = solver.solve(Index{0});
  for (const double r : {0.3, 1.0, 1.9}) {
    CHECK(length_of(exact_isolines(corner, r)) ==
          gelight::test::approx(1.5 * pi * r).epsilon(1e-10));
    CHECK(area_within(corner, r) == gelight::test::approx(0.75 * pi * r * r).epsilon(1e-10));
    check_arcs(corner, surface, r, 1e-10);
  }
}

TEST_CASE_TEMPLATE("a box: lines are closed where circles touch edges at vertices, or all but do",
                   T, float, double) {
  for (const auto& mesh : {box<T>(1, 1, 1), box<T>(1, 2, 3)}) {
    const ExactSolver<T> solver(mesh, {.keep_windows = true});
    const auto& surface = solver.surface();
    std::vector<SurfacePoint<T>> sources;
    for (Index f = 0; f < surface.face_count(); ++f) {
      const auto v = surface.face(f);
      for (std::size_t k = 0; k < 3; ++k) {
        sources.push_back(vertex_point<T>(v[k]));
        sources.push_back(edge_point<T>(v[k], v[(k + 1) % 3], T(0.5)));
      }
      sources.push_back(face_point<T>(f, {T(0.5), T(0.25), T(0.25)}));
    }
    for (const auto& source : sources) {
      const auto field = solver.solve(source);
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        for (const double off : {0.0, -1e-15, 1e-15, -1e-13, 1e-13}) {
          const T level = field.distance(v) * T(1 + off);
          CAPTURE(level);
          for (const auto& line : exact_isolines(field, level)) CHECK(line.is_closed);
        }
      }
    }
  }
  // A level of one digit more than that of three corners.
  const ExactSolver<T> solver(box<T>(1, 1, 1), {.keep_windows = true});
  const T level = 1 + 4 * std::numeric_limits<T>::epsilon();
  const auto lines = exact_isolines(solver.solve(Index{0}), level);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].is_closed);
  CHECK(lines[0].length() == gelight::test::approx(1.5 * pi).epsilon(1e-6));
}

TEST_CASE("a tube: circles that meet themselves on the far side") {
  // Six sides of 1, twenty rows of 1.
  Mesh<double> mesh;
  const Index sides = 6, rows = 20;
  for (Index k = 0; k <= rows; ++k) {
    for (Index j = 0; j < sides; ++j) {
      mesh.positions.push_back({std::cos(pi / 3 * j), std::sin(pi / 3 * j), double(k)});
    }
  }
  for (Index k = 0; k < rows; ++k) {
    for (Index j = 0; j < sides; ++j) {
      const Index a = sides * k + j, b = sides * k + (j + 1) % sides;
      mesh.faces.push_back({a, b, b + sides});
      mesh.faces.push_back({a, b + sides, a + sides});
    }
  }
  const ExactSolver solver(mesh, keeping());
  const auto field = solver.solve(face_point<double>(12 * 10, {0.5, 0.25, 0.25}));
  const double once = sides;
  for (const double r : {1.0, 2.9, 3.5, 6.0, 8.5}) {
    // Where it is wider than the tube what lies beyond half a turn is not its border.
    const double half = std::asin(std::min(1.0, once / (2 * r)));
    const double length = 4 * r * half;
    const double area = r * r * (2 * half + std::sin(2 * half));
    const auto lines = exact_isolines(field, r);
    CHECK(lines.size() == (r < 3 ? 1 : 2));
    for (const auto& line : lines) CHECK(line.is_closed);
    CHECK(length_of(lines) == gelight::test::approx(length).epsilon(1e-10));
    CHECK(area_within(field, r) == gelight::test::approx(area).epsilon(1e-10));
    check_arcs(field, solver.surface(), r, 1e-10);
  }
}

TEST_CASE("the offset of a straight curve: two straight lines and two half circles") {
  Random random(3);
  const auto mesh = test::jittered_grid(12, 0.2, random);
  const Surface<double> surface(mesh);
  const ExactSolver solver(mesh);
  for (int i = 0; i < 5; ++i) {
    const Point from =
        nearest_point<double>(surface, {uniform(random, 4, 5), uniform(random, 4, 8), 0});
    const double length = uniform(random, 0.5, 3), r = uniform(random, 0.2, 3.5);
    const auto curve = segments(trace_geodesic(surface, from, Vec3<double>(1, 0.1, 0), length));
    const auto field = solver.solve(std::span<const Segment<double>>(curve));
    const auto lines = exact_isolines(field, r);
    CHECK(length_of(lines) == gelight::test::approx(2 * length + 2 * pi * r).epsilon(1e-7));
    CHECK(area_within(field, r) ==
          gelight::test::approx(2 * length * r + pi * r * r).epsilon(1e-7));
    CHECK(lines.size() == 1);
    CHECK(lines[0].is_closed);
  }
}

TEST_CASE("the offset of one segment: along each edge, and from next to an edge or a vertex") {
  const auto mesh = grid<double>(6, 6, 6, 6);
  const Surface<double> surface(mesh);
  const ExactSolver solver(mesh);
  const auto check = [&](const Segment<double>& segment) {
    const Vec3<double> a = surface.position(segment.begin), b = surface.position(segment.end);
    const double length = (b - a).norm();
    const auto field = solver.solve(std::span<const Segment<double>>(&segment, 1));
    for (const double r : {0.2737, 0.5, 0.98, 1.3}) {
      const auto lines = exact_isolines(field, r);
      CAPTURE(a);
      CAPTURE(b);
      CAPTURE(r);
      CHECK(length_of(lines) == gelight::test::approx(2 * length + 2 * pi * r).epsilon(1e-6));
      CHECK(area_within(field, r) ==
            gelight::test::approx(2 * length * r + pi * r * r).epsilon(1e-6));
      REQUIRE(lines.size() == 1);
      CHECK(lines[0].is_closed);
    }
  };
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto v = surface.face(f);
    const auto is_inside = [&](Index u) {
      const Vec3<double> p = surface.position(u);
      return p.x() > 1.5 && p.x() < 4.5 && p.y() > 1.5 && p.y() < 4.5;
    };
    if (!is_inside(v[0]) || !is_inside(v[1]) || !is_inside(v[2])) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index from = v[k], to = v[(k + 1) % 3];
      check({vertex_point<double>(from), vertex_point<double>(to)});
      check({edge_point<double>(from, to, 0.1), edge_point<double>(from, to, 0.8)});
      for (const double off : {1e-12, 1e-10, 1e-9, 7.65e-9, 1e-7}) {
        std::array<double, 3> begin{}, end{};
        begin[k] = 1 - off;
        begin[(k + 1) % 3] = off;
        end[(k + 1) % 3] = 1 - 200 * off;
        end[(k + 2) % 3] = 200 * off;
        check({face_point<double>(f, begin), face_point<double>(f, end)});
      }
    }
  }
}

TEST_CASE("round a segment that begins next to a vertex of a jittered ball lines are closed") {
  Random random(71);
  for (int world = 0; world < 300; ++world) {
    CAPTURE(world);
    auto mesh = icosphere<double>(1, 1 + world % 2);
    for (auto& p : mesh.positions) {
      for (double& x : p) x += uniform(random, -0.6, 0.6);
      p[2] *= 0.05;
    }
    const Surface<double> surface(mesh);
    const auto f = test::uniform_index(random, surface.face_count());
    const double off = std::array{1e-13, 1e-12, 1e-11}[static_cast<std::size_t>(world % 3)];
    const Segment<double> segment{face_point<double>(f, {1 - off, off, 0}),
                                  face_point<double>(f, {off / 3, 1 - off, off - off / 3})};
    const auto field = ExactSolver(mesh).solve(std::span<const Segment<double>>(&segment, 1));
    check_closed(field, random);
  }
}

TEST_CASE("round two points next to one vertex lines are closed") {
  Random random(5);
  for (int world = 0; world < 1500; ++world) {
    CAPTURE(world);
    auto mesh = world % 2 == 0 ? icosphere<double>(1) : box<double>(1, 2, 3);
    for (auto& p : mesh.positions) {
      for (double& x : p) x += uniform(random, -1e-3, 1e-3);
    }
    const ExactSolver solver(mesh, keeping());
    const Index v = test::uniform_index(random, solver.surface().vertex_count());
    std::vector<Source<double>> sources;
    for (const Index h : solver.surface().corners(v)) {
      const double off = std::pow(10, uniform(random, -13, -10));
      if (sources.size() < 2) sources.push_back({edge_point(v, solver.surface().tip(h), off), 0});
    }
    const auto field = solver.solve(std::span<const Source<double>>(sources));
    check_closed(field, random);
  }
}

TEST_CASE("the area of a small disc that an edge or a vertex cuts") {
  Random random(3);
  const ExactSolver solver(grid<double>(3, 3), keeping());
  for (const double r : {1e-3, 1e-5, 1e-7, 1e-8}) {
    // Arcs may lack 1e-11 of the mesh's size at their ends.
    const double rounding = std::max(1e-10, 1e-15 / r);
    for (int i = 0; i < 200; ++i) {
      const double a = r * std::pow(10, uniform(random, -2, 0.2));
      const double b = i % 2 == 0 ? 0.3 : r * std::pow(10, uniform(random, -2, 0.2));
      std::array<double, 3> shares{a, b, 1 - a - b};
      std::rotate(shares.begin(), shares.begin() + i % 3, shares.end());
      const auto field = solver.solve(face_point<double>(8 + i % 2, shares));
      CHECK(area_within(field, r) / (pi * r * r) ==
            gelight::test::approx(1).epsilon(10 * rounding));
    }
  }
}

TEST_CASE(
    "at a vertex's level, where circles just cross sides, the area is that of levels beside") {
  Random random(6);
  for (int world = 0; world < 300; ++world) {
    CAPTURE(world);
    auto mesh = box<double>(1, 2, 3);
    for (auto& p : mesh.positions) {
      for (double& x : p) x += uniform(random, -1e-3, 1e-3);
    }
    const ExactSolver solver(mesh, keeping());
    const Index v = test::uniform_index(random, 8);
    std::vector<Source<double>> sources;
    for (const Index h : solver.surface().corners(v)) {
      const double off = std::pow(10, uniform(random, -12.5, -10.5));
      if (sources.size() < 2) sources.push_back({edge_point(v, solver.surface().tip(h), off), 0});
    }
    const auto field = solver.solve(std::span<const Source<double>>(sources));
    const double level = field.distance(test::uniform_index(random, 8));
    if (level < 1e-3) continue;
    const double beside =
        (area_within(field, level * (1 - 1e-8)) + area_within(field, level * (1 + 1e-8))) / 2;
    CHECK(area_within(field, level) == gelight::test::approx(beside).epsilon(1e-9));
  }
}

TEST_CASE("the offset of a side of the border is one line from border to border") {
  for (const Index n : {1, 2, 3}) {
    const auto mesh = grid<double>(n, n, 1, 1);
    const ExactSolver solver(mesh);
    std::vector<Segment<double>> side;
    for (Index i = 0; i < n; ++i) {
      side.push_back({vertex_point<double>(i), vertex_point<double>(i + 1)});
    }
    const auto field = solver.solve(std::span<const Segment<double>>(side));
    for (const double r : {0.0837, 0.217, 0.6}) {
      const auto lines = exact_isolines(field, r);
      REQUIRE(lines.size() == 1);
      CHECK(!lines[0].is_closed);
      CHECK(length_of(lines) == gelight::test::approx(1).epsilon(1e-6));
      CHECK(area_within(field, r) == gelight::test::approx(r).epsilon(1e-6));
    }
  }
}

TEST_CASE(
    "meshes like a scanner's: arcs at the level, lines closed but at borders, and the area "
    "is the integral of the length") {
  Random random(4);
  for (const auto& scan : test::scan_meshes(2)) {
    INFO(scan.name);
    const auto& mesh = scan.mesh;
    const ExactSolver solver(mesh, keeping());
    const Surface<double>& surface = solver.surface();
    const auto field = solver.solve(test::random_point(mesh, random));
    const auto distances = field.distances();
    double farthest = 0;
    for (const double d : distances) farthest = std::isfinite(d) ? std::max(farthest, d) : farthest;
    const double level = uniform(random, 0.2, 0.7) * farthest;
    check_arcs(field, surface, level, 1e-8 * farthest);
    // The co-area formula: the distance grows by 1 for each unit of way.
    const int steps = 64;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      sum += length_of(exact_isolines(field, level * (i + 0.5) / steps)) * level / steps;
    }
    CHECK(area_within(field, level) == gelight::test::approx(sum).epsilon(2e-3));
    // Polylines through the edges are chords of the arcs, and a little off.
    CHECK(area_within(field, level) ==
          gelight::test::approx(area_below(surface, distances, level)).epsilon(0.1));
  }
}

TEST_CASE("the offset of a segment grows with the mesh, whatever its unit") {
  const auto offset = [](double unit) {
    const ExactSolver solver(grid<double>(6, 6, 6 * unit, 6 * unit));
    const Segment<double> segment{face_point<double>(30, {0.2, 0.3, 0.5}),
                                  face_point<double>(30, {0.6, 0.3, 0.1})};
    const auto field = solver.solve(std::span<const Segment<double>>(&segment, 1));
    const auto lines = exact_isolines(field, unit);
    CHECK(lines.size() == 1);
    return std::array{length_of(lines) / unit, area_within(field, unit) / unit / unit};
  };
  const auto expected = offset(1);
  // To 1e16 and more 1 may be added without changing them.
  for (const int exponent : {-200, -60, 52, 54, 60, 200}) {
    CAPTURE(exponent);
    CHECK(offset(std::ldexp(1, exponent)) == expected);
  }
}

TEST_CASE("what cannot be answered is refused") {
  const auto mesh = icosphere<double>(2);
  const ExactSolver solver(mesh);
  const auto bare = solver.solve(Index{0});
  CHECK(test::contains(test::refusal([&] { (void)exact_isolines(bare, 1.0); }), "keep_windows"));
  ExactOptions<double> options = keeping();
  const auto whole = solver.solve(Index{0}, options);
  CHECK(test::contains(test::refusal([&] { (void)area_within(whole, std::nan("")); }), "level"));
  options.max_distance = 1;
  const auto near = solver.solve(Index{0}, options);
  CHECK(test::contains(test::refusal([&] { (void)exact_isolines(near, 1.5); }), "1.5"));
  CHECK(exact_isolines(near, 0.9).size() == 1);
  CHECK_THROWS_AS((void)exact_isolines(whole, 1.0, [] { return true; }), Cancelled);
}

TEST_CASE("an area within a level that float cannot hold is refused") {
  const auto area = [](float size) {
    const ExactSolver solver(grid<float>(2, 2, size, size));
    ExactOptions<float> options;
    options.keep_windows = true;
    return area_within(solver.solve(0, options), 10 * size);
  };
  CHECK(area(1.8e19F) == test::approx(3.24e38).epsilon(1e-6));
  for (const float size : {1.9e19F, 1e25F}) {
    CHECK(test::contains(test::refusal([&] { (void)area(size); }), "more than its type can hold"));
  }
}
