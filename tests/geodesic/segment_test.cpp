#include "gelight/geodesic/segment.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/scan_meshes.hpp"

using namespace gelight;
using test::Random;
using Curve = std::vector<Segment<double>>;

namespace {

// In the plane.
double to_piece(const Vec3<double>& p, const Vec3<double>& a, const Vec3<double>& b) {
  const Vec3<double> way = b - a;
  const double square = way.squaredNorm();
  const double t = square > 0 ? std::clamp((p - a).dot(way) / square, 0.0, 1.0) : 0;
  return (p - a - t * way).norm();
}

// A piece of a straight line over several faces, as a chain.
Curve line(const Surface<double>& surface, Random& random, double longest) {
  const Index f = test::uniform_index(random, surface.face_count());
  const double a = test::uniform(random, 0.1, 0.5);
  const auto from = face_point<double>(f, {a, 0.3, 0.7 - a});
  const auto v = surface.face(f);
  const Vec3<double> d =
      surface.position(v[1]) - surface.position(v[0]) +
      test::uniform(random, -1, 1) * (surface.position(v[2]) - surface.position(v[0]));
  return segments(
      trace_geodesic(surface, from, Vec3<double>(d), test::uniform(random, 0, longest)));
}

}  // namespace

TEST_CASE("a flat sheet: the distance from straight pieces, at vertices and between, with paths") {
  Random random(3);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Mesh<double> mesh = test::jittered_grid(14, 0.25, random);
    for (auto& p : mesh.positions) {
      for (double& x : p) x *= scale;
    }
    const Surface<double> surface(mesh);
    const ExactSolver solver(mesh);
    for (int i = 0; i < 8; ++i) {
      Curve curve = line(surface, random, 6 * scale);
      const Curve more = line(surface, random, 2 * scale);
      if (i % 2 == 0) curve.insert(curve.end(), more.begin(), more.end());
      const double late = i % 3 == 0 ? scale * 0.7 : 0;
      for (auto& piece : curve) piece.distance = late;
      const auto truth = [&](const Vec3<double>& p) {
        double least = std::numeric_limits<double>::infinity();
        for (const auto& piece : curve) {
          least = std::min(least, late + to_piece(p, surface.position(piece.begin),
                                                  surface.position(piece.end)));
        }
        return least;
      };
      const auto field = solver.solve(std::span<const Segment<double>>(curve));
      const auto distance = solver.distance(std::span<const Segment<double>>(curve));
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        const double d = truth(surface.position(v));
        CHECK(std::abs(distance[static_cast<std::size_t>(v)] - d) < 4e-8 * scale);
        CHECK(field.distance(v) == distance[static_cast<std::size_t>(v)]);
        if (v % 5 != 0) continue;
        const auto path = field.path(v);
        CHECK(std::abs(length(surface, path) - (d - late)) < 4e-8 * scale);
        CHECK(std::abs(truth(surface.position(path.front())) - late) < 1e-9 * scale);
        const Vec3<double> way = surface.position(v) - surface.position(path.front());
        if (way.norm() > 0.1 * scale) {
          CHECK((field.direction(v) - way.normalized()).norm() < 1e-6);
        }
      }
      for (int j = 0; j < 30; ++j) {
        const Index f = test::uniform_index(random, surface.face_count());
        const double a = test::uniform(random, 0.1, 0.5);
        const auto p = face_point<double>(f, {a, 0.3, 0.7 - a});
        const double d = truth(surface.position(p));
        CHECK(std::abs(field.distance(p) - d) < 4e-8 * scale);
        CHECK(std::abs(length(surface, field.path(p)) - (d - late)) < 4e-8 * scale);
      }
    }
  }
}

TEST_CASE("round a prism and over a box's edges, unfolded") {
  constexpr Index around = 12, up = 10;
  const double side = 2 * std::sin(std::numbers::pi / around);
  Mesh<double> tube;
  for (Index i = 0; i <= up; ++i) {
    for (Index j = 0; j < around; ++j) {
      const double a = 2 * std::numbers::pi * j / around;
      tube.positions.push_back({std::cos(a), std::sin(a), i * 0.4});
      const Index v = i * around + j, w = i * around + (j + 1) % around;
      if (i == up) continue;
      tube.faces.push_back({v, w, v + around});
      tube.faces.push_back({w, w + around, v + around});
    }
  }
  // The lowest ring is a closed curve; one upright edge is a line.
  Curve ring, edge;
  for (Index j = 0; j < around; ++j) {
    ring.push_back({vertex_point<double>(j), vertex_point<double>((j + 1) % around)});
  }
  for (Index i = 3; i < 6; ++i) {
    edge.push_back({vertex_point<double>(i * around), vertex_point<double>((i + 1) * around)});
  }
  const ExactSolver solver(tube);
  const auto from_ring = solver.distance(std::span<const Segment<double>>(ring));
  const auto from_edge = solver.distance(std::span<const Segment<double>>(edge));
  for (Index v = 0; v < std::ssize(tube.positions); ++v) {
    const Index i = v / around, j = std::min(v % around, around - v % around);
    CHECK(from_ring[static_cast<std::size_t>(v)] == gelight::test::approx(0.4 * i).epsilon(1e-8));
    const double beyond = 0.4 * std::max({3 - i, i - 6, 0});
    CHECK(from_edge[static_cast<std::size_t>(v)] ==
          gelight::test::approx(std::hypot(side * j, beyond)).epsilon(1e-8));
  }
  const auto cube = box<double>(2, 2, 2);
  // An edge of the top, from which the floor's farthest edge is two sides away.
  const Surface<double> surface(cube);
  const Curve top{{vertex_point<double>(4), vertex_point<double>(5)}};
  const auto distance = ExactSolver(cube).distance(std::span<const Segment<double>>(top));
  const Vec3<double> a = surface.position(4), b = surface.position(5);
  for (Index v = 0; v < 8; ++v) {
    const Vec3<double> p = surface.position(v);
    const double wanted = std::min((p - a).norm(), (p - b).norm());  // over one side each
    CHECK(distance[static_cast<std::size_t>(v)] == gelight::test::approx(wanted).epsilon(1e-8));
  }
}

TEST_CASE("curves on rough meshes: as many points of them tell, but for their spacing") {
  Random random(12);
  for (const test::NamedMesh& named : test::scan_meshes(2)) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const Surface<double> surface(mesh);
    const ExactSolver solver(mesh);
    double size = detail::size_of(surface);
    for (int i = 0; i < 2; ++i) {
      const Curve curve = line(surface, random, 0.3 * size);
      const double spacing = 0.002 * size;
      const auto points = sources_along<double>(surface, curve, spacing);
      const auto by_points = solver.distance(std::span<const Source<double>>(points));
      const auto field = solver.solve(std::span<const Segment<double>>(curve));
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        const double upper = by_points[static_cast<std::size_t>(v)];
        const double d = field.distance(v);
        if (std::isinf(upper)) {
          CHECK(std::isinf(d));
          continue;
        }
        CHECK(d <= upper + 1e-8 * size);
        const Path<double> path = field.path(v);
        CHECK(std::abs(length(surface, path) - d) < 1e-8 * size);
        // From points beside the nearest the way is longer by the first straight piece's turn.
        Path<double> first{path[0]};
        for (std::size_t k = 1; k < path.size(); ++k) {
          first.push_back(path[k]);
          if (path[k].kind == SurfacePoint<double>::Kind::vertex) break;
        }
        const double piece = std::max(length(surface, first), 1e-9 * size);
        const double detour = std::min(spacing / 2, spacing * spacing / (8 * piece));
        CHECK(d >= upper - 1.01 * detour - 1e-8 * size);
      }
    }
  }
}

TEST_CASE("other solvers take points along a curve") {
  const auto mesh = grid<double>(20, 20, 20, 20);
  const Surface<double> surface(mesh);
  const Curve curve{{vertex_point<double>(0), vertex_point<double>(1)}};
  const auto points = sources_along<double>(surface, curve, 0.1);
  CHECK(points.size() == 11);
  const auto marched = FastMarchingSolver(mesh).distance(std::span<const Source<double>>(points));
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const double d = to_piece(surface.position(v), surface.position(0), surface.position(1));
    CHECK(std::abs(marched[static_cast<std::size_t>(v)] - d) < 0.03);
  }
}

TEST_CASE("pieces of no length are points; bad input") {
  const auto mesh = icosphere<float>(2);
  const ExactSolver solver(mesh);
  const std::vector<Segment<float>> point{{vertex_point<float>(7), vertex_point<float>(7)}};
  const auto a = solver.distance(std::span<const Segment<float>>(point)), b = solver.distance(7);
  for (std::size_t v = 0; v < a.size(); ++v)
    CHECK(a[v] == gelight::test::approx(b[v]).epsilon(1e-6));
  const auto refuse = [&](const Segment<float>& s) {
    CHECK_THROWS_AS((void)solver.solve(std::span<const Segment<float>>(&s, 1)), InvalidInput);
  };
  refuse({vertex_point<float>(0), vertex_point<float>(3)});  // far apart
  refuse({face_point<float>(0, {0.2F, 0.3F, 0.5F}), face_point<float>(1, {0.2F, 0.3F, 0.5F})});
  refuse({vertex_point<float>(0), vertex_point<float>(999)});
  refuse({vertex_point<float>(0), vertex_point<float>(0), std::numeric_limits<float>::infinity()});
  CHECK_THROWS_AS((void)solver.solve(std::span<const Segment<float>>()), InvalidInput);
  const std::vector<Segment<float>> side{
      {vertex_point<float>(mesh.faces[0][0]), vertex_point<float>(mesh.faces[0][1])}};
  for (const float spacing : {0.0F, 1e-9F, std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN()}) {
    CHECK_THROWS_AS(
        (void)sources_along(Surface<float>(mesh), std::span<const Segment<float>>(side), spacing),
        InvalidInput);
  }
}

TEST_CASE("a spacing that the surface's type does not hold leaves out no segment") {
  const auto mesh = icosphere<float>(2);
  const Surface<float> surface(mesh);
  const auto ends = [&](std::size_t k) { return vertex_point<double>(mesh.faces[0][k]); };
  const std::vector<Segment<double>> point{{ends(0), ends(0)}}, side{{ends(0), ends(1)}};
  CHECK(sources_along(surface, point, 1e-60).size() == 1);
  CHECK(sources_along(surface, side, 1e60).size() == 2);
  CHECK_THROWS_AS((void)sources_along(surface, side, 1e-60), InvalidInput);
}

TEST_CASE(
    "a segment at a right angle to a side, but for rounding, is no nearer than through space") {
  Random random(31);
  const Mesh<double> mesh = grid<double>(5, 5, 5, 5);
  const Surface<double> surface(mesh);
  const ExactSolver solver(mesh);
  for (const double share : {1e-3, 5e-6, 1e-9, 1e-12, 1e-16, 1e-20, 0.0}) {
    for (int i = 0; i < 60; ++i) {
      // Along a side of the face but for this share, to a corner or somewhere before it.
      const auto f = test::uniform_index(random, surface.face_count());
      const auto k = static_cast<std::size_t>(test::uniform_index(random, 3));
      const auto end = [&](double t) {
        const double off = share * test::uniform(random, 0, 1);
        std::array<double, 3> weights{};
        weights[k] = (1 - t) * (1 - off);
        weights[(k + 1) % 3] = t * (1 - off);
        weights[(k + 2) % 3] = off;
        return face_point<double>(f, weights);
      };
      const double near = share * test::uniform(random, 0, 1);
      const Segment<double> segment{end(i % 2 == 0 ? near : 0.05), end(1 - near)};
      const Vec3<double> a = surface.position(segment.begin), b = surface.position(segment.end);
      const auto distance = solver.distance(std::span<const Segment<double>>(&segment, 1));
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        const Vec3<double> p = surface.position(v);
        const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
        const double straight = (p - a - t * (b - a)).norm();
        CAPTURE(share);
        CHECK(distance[static_cast<std::size_t>(v)] >= straight - 1e-8);
      }
    }
  }
}

TEST_CASE("ends a rounding from an edge or a corner hide nothing that is seen from them alone") {
  Random random(32);
  // Shares of a face's corners, one of them or two next to nothing.
  const auto place = [&] {
    const double tiny[] = {5e-21, 1e-16, 5e-15, 1e-12, 1e-10, 1e-9, 1e-8, 1e-6, 1e-3, 0};
    const auto k = static_cast<std::size_t>(test::uniform_index(random, 3));
    const auto share = [&] { return tiny[test::uniform_index(random, 10)]; };
    const double off = share();
    const double t = test::uniform_index(random, 3) == 0 ? share() : test::uniform(random, 0, 1);
    std::array<double, 3> weights{};
    weights[k] = off;
    weights[(k + 1) % 3] = t * (1 - off);
    weights[(k + 2) % 3] = std::max(0.0, 1 - off - weights[(k + 1) % 3]);
    return weights;
  };
  std::vector<Mesh<double>> meshes{grid<double>(5, 5, 5, 5), grid<double>(5, 5, 5e6, 5e6)};
  for (auto& scan : test::scan_meshes(2)) meshes.push_back(std::move(scan.mesh));
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Surface<double> surface(meshes[m]);
    const ExactSolver solver(meshes[m]);
    const double size = detail::size_of(surface);
    for (int i = 0; i < (m < 2 ? 500 : 10); ++i) {
      const auto f = test::uniform_index(random, surface.face_count());
      const Segment<double> segment{face_point<double>(f, place()), face_point<double>(f, place())};
      const auto distance = solver.distance(std::span<const Segment<double>>(&segment, 1));
      const Source<double> ends[]{{segment.begin}, {segment.end}};
      const auto from_ends = solver.distance(std::span<const Source<double>>(ends));
      const Vec3<double> a = surface.position(segment.begin), b = surface.position(segment.end);
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        CAPTURE(m);
        CAPTURE(i);
        CAPTURE(v);
        const double d = distance[static_cast<std::size_t>(v)];
        CHECK(d <= from_ends[static_cast<std::size_t>(v)] + 4e-9 * size);
        if (m < 2) CHECK(std::abs(d - to_piece(surface.position(v), a, b)) <= 4e-9 * size);
      }
    }
  }
}

TEST_CASE(
    "arrivals from segments: from the nearest point of each, and no other, whatever tolerance") {
  Random random(14);
  const Mesh<double> mesh = test::random_grid(5, random);
  const Surface<double> surface(mesh);
  const ExactSolver solver(mesh);
  // Inside of a face, along an edge, from a vertex, of no length.
  for (int i = 0; i < 80; ++i) {
    const Index f = test::uniform_index(random, surface.face_count());
    const auto v = surface.face(f);
    const auto inside = [&] {
      const double a = test::uniform(random, 0.1, 0.6);
      return face_point<double>(f, {a, 0.3, 0.7 - a});
    };
    const auto on_edge = [&] {
      return edge_point<double>(v[0], v[1], test::uniform(random, 0.1, 0.9));
    };
    Segment<double> segment{inside(), inside()};
    if (i % 4 == 1) segment = {on_edge(), on_edge()};
    if (i % 4 == 2) segment = {vertex_point<double>(v[1]), inside()};
    if (i % 4 == 3) segment = {on_edge(), inside()};
    if (i % 20 == 0) segment.end = segment.begin;
    const auto field = solver.solve(std::span<const Segment<double>>(&segment, 1));
    const Vec3<double> a = surface.position(segment.begin), b = surface.position(segment.end);
    const auto tell = [&](const SurfacePoint<double>& point) {
      const Vec3<double> p = surface.position(point);
      const double truth = to_piece(p, a, b);
      if (truth < 1e-2) return;
      const auto arrivals = field.arrivals(point, 0.3);
      CAPTURE(i);
      REQUIRE(arrivals.size() == 1);
      CHECK(arrivals[0].distance == gelight::test::approx(truth).epsilon(1e-6));
      CHECK((surface.position(arrivals[0].from) - p).norm() == gelight::test::approx(truth));
    };
    for (Index u = 0; u < surface.vertex_count(); ++u) tell(vertex_point<double>(u));
    for (Index g = 0; g < surface.face_count(); ++g) tell(face_point<double>(g, {0.2, 0.5, 0.3}));
  }
  // Two in a face, as far from the points between them; both ways count.
  const Curve both{
      {face_point<double>(0, {0.6, 0.3, 0.1}), face_point<double>(0, {0.3, 0.6, 0.1})},
      {face_point<double>(0, {0.5, 0.2, 0.3}), face_point<double>(0, {0.2, 0.5, 0.3})}};
  const auto arrivals = solver.solve(std::span<const Segment<double>>(both))
                            .arrivals(face_point<double>(0, {0.4, 0.4, 0.2}), 1e-9);
  REQUIRE(arrivals.size() == 2);
  CHECK((arrivals[0].direction + arrivals[1].direction).norm() < 1e-9);
}

TEST_CASE("needles: paths to points next to vertices begin on the segment, too") {
  Random random(15);
  for (int i = 0; i < 3000; ++i) {
    Mesh<double> mesh = test::small_random_mesh(i % 2, random);
    const double stretch = std::pow(10, test::uniform(random, 3, 4));
    for (auto& p : mesh.positions) p[0] *= stretch;
    const Surface<double> surface(mesh);
    const double size = detail::size_of(surface);
    const Index f = test::uniform_index(random, surface.face_count());
    const Segment<double> segment{face_point<double>(f, {0.2, 0.3, 0.5}),
                                  face_point<double>(f, {0.6, 0.3, 0.1})};
    const auto field = ExactSolver(mesh).solve(std::span<const Segment<double>>(&segment, 1));
    const Vec3<double> a = surface.position(segment.begin), b = surface.position(segment.end);
    for (Index g = 0; g < surface.face_count(); ++g) {
      const double off = std::pow(10, test::uniform(random, -14, -10));
      const auto point = face_point<double>(g, {off, 1 - 1.1 * off, 0.1 * off});
      const double d = field.distance(point);
      if (std::isinf(d)) continue;
      const Path<double> path = field.path(point);
      CAPTURE(i);
      CAPTURE(g);
      CHECK(std::abs(length(surface, path) - d) < 8e-9 * size);
      CHECK(to_piece(surface.position(path.front()), a, b) < 1e-9 * size);
    }
  }
}

TEST_CASE(
    "a line past a corner within rounding: the path to the vertex behind it goes by the corner") {
  // Behind a face that is flat but for 1e-15, a vertex next to the corner that hides it.
  Mesh<double> mesh;
  mesh.positions = {{0.9999999, -2e-7, 1},
                    {2.0000002, -1e-7, 1},
                    {-4e-7, -3e-7, 1},
                    {0.9999999, 1, 1},
                    {2.0000002, -4e-7, 1}};
  mesh.faces = {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}};
  const Segment<double> segment{face_point<double>(0, {0.25, 0.09375, 0.65625}),
                                face_point<double>(0, {0.375, 0.234375, 0.390625})};
  const Surface<double> surface(mesh);
  const auto field = ExactSolver(mesh).solve(std::span<const Segment<double>>(&segment, 1));
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    CAPTURE(v);
    CHECK(std::abs(length(surface, field.path(v)) - field.distance(v)) < 1e-9);
  }
}

TEST_CASE("needles round an edge of three faces: a wave that goes round them comes to an end") {
  Mesh<double> mesh;
  mesh.positions = {
      {101.000004, 98.999996, 100}, {100.000004, 98.999996, 100},  {98.999996, 101.000002, 100},
      {98.999996, 101.000003, 100}, {101.000004, 101.000001, 100}, {101.000004, 99, 100},
      {101.000004, 98.999997, 100}, {101.000001, 98.999996, 100},  {101, 99.999996, 100}};
  mesh.faces = {{7, 0, 1}, {8, 1, 0}, {7, 1, 2}, {8, 2, 1}, {7, 2, 3}, {8, 3, 2},
                {7, 3, 4}, {8, 4, 3}, {7, 4, 5}, {8, 5, 4}, {7, 5, 6}, {8, 6, 5},
                {7, 6, 0}, {8, 0, 6}, {4, 5, 3}, {5, 0, 8}};
  const Surface<double> surface(mesh);
  const double size = detail::size_of(surface);
  const Segment<double> segment{vertex_point<double>(7),
                                face_point<double>(6, {0.625, 0.140625, 0.234375})};
  const auto field = ExactSolver(mesh).solve(std::span<const Segment<double>>(&segment, 1));
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    CAPTURE(v);
    CHECK(std::abs(length(surface, field.path(v)) - field.distance(v)) < 4e-9 * size);
  }
  const Vec3<double> a = surface.position(segment.begin), b = surface.position(segment.end);
  CHECK(std::abs(field.distance(5) - to_piece(surface.position(5), a, b)) < 4e-9 * size);
}

TEST_CASE("corners at one place, behind faces of no area: paths are as long as distances, too") {
  Mesh<double> mesh;
  mesh.positions = {{0, 0, 0}, {1, -1, 0}, {0, 0, 0},  {0, 0, 0},
                    {1, 1, 0}, {0, 0, 0},  {-1, 1, 0}, {0, -1, 0}};
  mesh.faces = {{6, 0, 1}, {7, 1, 0}, {6, 1, 2}, {7, 2, 1}, {6, 2, 3}, {7, 3, 2}, {6, 3, 4},
                {7, 4, 3}, {6, 4, 5}, {7, 5, 4}, {6, 5, 0}, {7, 0, 5}, {5, 6, 7}};
  const Surface<double> surface(mesh);
  const Segment<double> segment{face_point<double>(10, {0.25, 0.1875, 0.5625}),
                                face_point<double>(10, {0.375, 0.078125, 0.546875})};
  for (const bool keep_windows : {false, true}) {
    ExactOptions<double> options;
    options.keep_windows = keep_windows;
    const auto field =
        ExactSolver(mesh, options).solve(std::span<const Segment<double>>(&segment, 1));
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      CAPTURE(v);
      CHECK(std::abs(length(surface, field.path(v)) - field.distance(v)) < 1e-9);
    }
  }
}
