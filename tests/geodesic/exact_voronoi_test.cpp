#include "gelight/geodesic/exact_voronoi.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
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
using Edges = std::vector<VoronoiEdge<double>>;
using Sources = std::vector<Source<double>>;
constexpr double pi = std::numbers::pi;

ExactOptions<double> keeping() {
  ExactOptions<double> options;
  options.keep_windows = true;
  return options;
}

Edges edges_of(const ExactSolver<double>& solver, const Sources& sources) {
  return exact_voronoi_edges(solver.solve(std::span<const Source<double>>(sources)));
}

double length_of(const Surface<double>& surface, const Edges& edges) {
  double sum = 0;
  for (const auto& edge : edges) sum += length(surface, edge.points);
  return sum;
}

bool is_at_border(const Surface<double>& surface, const Point& point) {
  bool is_at = false;
  detail::for_each_face_at(surface, point, [&](Index f) {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      if (!surface.is_border(h)) continue;
      const Vec3<double> along =
          surface.position(surface.tip(h)) - surface.position(surface.origin(h));
      const Vec3<double> to = surface.position(point) - surface.position(surface.origin(h));
      is_at |= cross<double>(along, to).norm() <= 1e-9 * along.squaredNorm();
    }
  });
  return is_at;
}

// What holds of any lines: points are as far from both sources and from none nearer, as solves from
// each alone tell; and pieces lie in faces.
void check_edges(const ExactSolver<double>& solver, const Sources& sources, const Edges& edges,
                 double room) {
  const Surface<double>& surface = solver.surface();
  std::vector<ExactField<double>> alone;
  for (const auto& source : sources) {
    alone.push_back(solver.solve(std::span<const Source<double>>(&source, 1)));
  }
  for (const auto& edge : edges) {
    const auto [a, b] = edge.sources;
    REQUIRE(a >= 0);
    REQUIRE(a < b);
    REQUIRE(edge.points.size() >= 2);
    CHECK(faces_along(surface, edge.points).size() == edge.points.size() - 1);
    CHECK((edge.points.front() == edge.points.back()) == edge.is_closed);
    for (const auto& point : edge.points) {
      const double to_a = alone[std::size_t(a)].distance(point);
      const double to_b = alone[std::size_t(b)].distance(point);
      CHECK(std::abs(to_a - to_b) <= room);
      for (const auto& field : alone) CHECK(field.distance(point) >= to_a - room);
    }
    // It ends at a border or where a third cell is.
    for (const Point* end : {&edge.points.front(), &edge.points.back()}) {
      if (edge.is_closed || is_at_border(surface, *end)) continue;
      std::vector<double> distances;
      for (const auto& field : alone) distances.push_back(field.distance(*end));
      std::sort(distances.begin(), distances.end());
      REQUIRE(distances.size() >= 3);
      CHECK(distances[2] - distances[0] <= room);
    }
  }
}

// Where a chord of a face goes from one cell to another, by the distances from each source alone,
// one of the lines passes.
void check_complete(const ExactSolver<double>& solver, const Sources& sources, const Edges& edges,
                    double room, int chords, Random& random) {
  const Surface<double>& surface = solver.surface();
  std::vector<ExactField<double>> alone;
  for (const auto& source : sources) {
    alone.push_back(solver.solve(std::span<const Source<double>>(&source, 1)));
  }
  // Pieces of lines, by their faces.
  std::vector<std::vector<std::array<Vec3<double>, 2>>> pieces(std::size_t(surface.face_count()));
  for (const auto& edge : edges) {
    for (std::size_t i = 0; i + 1 < edge.points.size(); ++i) {
      const std::array<Vec3<double>, 2> ends{surface.position(edge.points[i]),
                                             surface.position(edge.points[i + 1])};
      detail::for_each_face_at(surface, edge.points[i],
                               [&](Index f) { pieces[std::size_t(f)].push_back(ends); });
      detail::for_each_face_at(surface, edge.points[i + 1],
                               [&](Index f) { pieces[std::size_t(f)].push_back(ends); });
    }
  }
  const auto nearest = [&](const Point& p) {
    std::size_t best = 0;
    double least = alone[0].distance(p), second = std::numeric_limits<double>::infinity();
    for (std::size_t s = 1; s < alone.size(); ++s) {
      const double d = alone[s].distance(p);
      second = std::min(second, std::max(d, least));
      if (d < least) best = s;
      least = std::min(least, d);
    }
    return std::pair(best, second - least);
  };
  int crossings = 0;
  for (int i = 0; i < chords; ++i) {
    const Index f = test::uniform_index(random, surface.face_count());
    const auto any = [&] {
      std::array<double, 3> w{-std::log(uniform(random, 1e-9, 1)),
                              -std::log(uniform(random, 1e-9, 1)),
                              -std::log(uniform(random, 1e-9, 1))};
      const double sum = w[0] + w[1] + w[2];
      for (double& x : w) x /= sum;
      return w;
    };
    std::array<double, 3> from = any(), to = any();
    const auto [first, lead] = nearest(face_point(f, from));
    const auto [last, other_lead] = nearest(face_point(f, to));
    if (first == last || lead < room || other_lead < room) continue;
    std::array<double, 3> middle{};
    for (int k = 0; k < 40; ++k) {
      for (std::size_t c = 0; c < 3; ++c) middle[c] = (from[c] + to[c]) / 2;
      (nearest(face_point(f, middle)).first == first ? from : to) = middle;
    }
    ++crossings;
    const Vec3<double> p = surface.position(face_point(f, middle));
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : pieces[std::size_t(f)]) {
      const double square = (b - a).squaredNorm();
      const double t = square > 0 ? std::clamp((p - a).dot(b - a) / square, 0.0, 1.0) : 0.0;
      least = std::min(least, (p - a - t * (b - a)).norm());
    }
    const auto c = surface.face(f);
    const double longest = std::max({(surface.position(c[0]) - surface.position(c[1])).norm(),
                                     (surface.position(c[1]) - surface.position(c[2])).norm(),
                                     (surface.position(c[2]) - surface.position(c[0])).norm()});
    CHECK(least <= 4e-3 * longest + room);
  }
  CHECK(crossings > 0);
}

Sources vertices(std::initializer_list<Index> list) {
  Sources out;
  for (const Index v : list) out.push_back({vertex_point<double>(v), 0});
  return out;
}

// A tube of six sides of length 1 and rows of 1, laid flat 6 x rows.
Mesh<double> tube(Index rows) {
  Mesh<double> mesh;
  for (Index k = 0; k <= rows; ++k) {
    for (Index j = 0; j < 6; ++j) {
      mesh.positions.push_back({std::cos(pi / 3 * j), std::sin(pi / 3 * j), double(k)});
    }
  }
  for (Index k = 0; k < rows; ++k) {
    for (Index j = 0; j < 6; ++j) {
      const Index a = 6 * k + j, b = 6 * k + (j + 1) % 6;
      mesh.faces.push_back({a, b, b + 6});
      mesh.faces.push_back({a, b + 6, a + 6});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("a flat sheet: two sources have one straight line, or a branch of a hyperbola") {
  Random random(1);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Mesh<double> mesh = test::jittered_grid(12, 0.2, random);
    for (auto& p : mesh.positions) {
      for (double& x : p) x *= scale;
    }
    const ExactSolver solver(mesh, keeping());
    const Surface<double>& surface = solver.surface();
    for (int i = 0; i < 8; ++i) {
      const Vec3<double> p(uniform(random, 1, 5) * scale, uniform(random, 4, 8) * scale, 0);
      const Vec3<double> q(uniform(random, 6, 11) * scale, uniform(random, 4, 8) * scale, 0);
      const double later = i < 3 ? 0 : uniform(random, -0.95, 0.95) * (p - q).norm();
      const Sources sources{{nearest_point(surface, p), 7 * scale},
                            {nearest_point(surface, q), 7 * scale + later}};
      const Edges edges = edges_of(solver, sources);
      REQUIRE(edges.size() == 1);
      CHECK(!edges[0].is_closed);
      double turned = 0;
      for (std::size_t k = 0; k < edges[0].points.size(); ++k) {
        const Vec3<double> x = surface.position(edges[0].points[k]);
        CHECK(std::abs((x - p).norm() - (x - q).norm() - later) <= 1e-11 * scale);
        // The first source's cell lies to the left.
        if (k == 0) continue;
        const Vec3<double> way = x - surface.position(edges[0].points[k - 1]);
        turned = std::max(turned, cross<double>(way, p - x)[2] < 0 ? 1.0 : 0.0);
      }
      CHECK(turned == 0);
      for (const auto* end : {&edges[0].points.front(), &edges[0].points.back()}) {
        const Vec3<double> x = surface.position(*end) / scale;
        CHECK(std::min({x[0], x[1], 12 - x[0], 12 - x[1]}) <= 1e-9);
      }
      check_edges(solver, sources, edges, 1e-11 * scale);
    }
  }
}

TEST_CASE("a flat sheet: three cells meet in the middle of their circle, and islands are whole") {
  Random random(2);
  const Mesh<double> mesh = test::jittered_grid(12, 0.2, random);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  for (int i = 0; i < 6; ++i) {
    const Vec3<double> middle(uniform(random, 5, 7), uniform(random, 5, 7), 0);
    Sources sources;
    for (const double turn : {0.2, 2.1, 4.4}) {
      const Vec3<double> at = middle + 3 * Vec3<double>(std::cos(turn + i), std::sin(turn + i), 0);
      sources.push_back({nearest_point(surface, at), 0});
    }
    const Edges edges = edges_of(solver, sources);
    REQUIRE(edges.size() == 3);
    for (const auto& edge : edges) {
      const double begin = (surface.position(edge.points.front()) - middle).norm();
      const double end = (surface.position(edge.points.back()) - middle).norm();
      CHECK(std::min(begin, end) <= 1e-11);
      CHECK(std::max(begin, end) > 4);
    }
    check_edges(solver, sources, edges, 1e-11);
  }
  // One source among twelve that stand round it: all inside of one face of a coarse sheet.
  const auto coarse = grid<double>(1, 1, 1, 1);
  const ExactSolver of_coarse(coarse, keeping());
  Sources ring{{face_point<double>(0, {0.4, 0.3, 0.3}), 0}};
  const Vec3<double> centre = of_coarse.surface().position(ring[0].point);
  for (int k = 0; k < 12; ++k) {
    const double turn = 2 * pi * k / 12;
    ring.push_back(
        {nearest_point<double>(of_coarse.surface(),
                               centre + 0.02 * Vec3<double>(std::cos(turn), std::sin(turn), 0)),
         k % 2 * 0.001});
  }
  const Edges edges = edges_of(of_coarse, ring);
  check_edges(of_coarse, ring, edges, 1e-12);
  double round = 0;
  Index sides = 0;
  for (const auto& edge : edges) {
    if (edge.sources[0] != 0) continue;
    ++sides;
    round += length(of_coarse.surface(), edge.points);
  }
  CHECK(sides == 12);
  CHECK(round > 2 * pi * 0.01);
  CHECK(round < 2 * pi * 0.012);
}

TEST_CASE("a flat sheet: between sources close together no line leaves its place") {
  Random random(3);
  const Mesh<double> mesh = test::jittered_grid(6, 0.2, random);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  for (int i = 0; i < 60; ++i) {
    const Vec3<double> x(uniform(random, 1, 5), uniform(random, 1, 5), 0);
    const double turn = uniform(random, 0, 2 * pi), apart = i % 2 == 0 ? 1e-3 : 1e-5;
    const Vec3<double> y = x + apart * Vec3<double>(std::cos(turn), std::sin(turn), 0);
    const Sources close{{nearest_point(surface, x), 0}, {nearest_point(surface, y), 0}};
    for (const auto& edge : edges_of(solver, close)) {
      CHECK(faces_along(surface, edge.points).size() == edge.points.size() - 1);
      for (const auto& point : edge.points) {
        const Vec3<double> p = surface.position(point);
        CHECK(std::abs((p - x).norm() - (p - y).norm()) <= 1e-10);
      }
    }
  }
}

// The length of the part in the square from 0 to `side` of the line as far from two points.
double bisector_length(const Vec3<double>& x, const Vec3<double>& y, double side) {
  const Vec3<double> middle = (x + y) / 2, way = (y - x).normalized();
  const std::array<double, 2> along{-way[1], way[0]};
  double from = -2 * side, to = 2 * side;
  for (std::size_t k = 0; k < 2; ++k) {
    if (along[k] == 0) continue;
    const double a = -middle[Eigen::Index(k)] / along[k];
    const double b = (side - middle[Eigen::Index(k)]) / along[k];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return to - from;
}

TEST_CASE("a flat sheet: between sources close together the line is whole") {
  Random random(7);
  const Mesh<double> mesh = test::jittered_grid(6, 0.2, random);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  for (const double apart : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
    for (int i = 0; i < 60; ++i) {
      const auto aside = [&] {
        const double turn = uniform(random, 0, 2 * pi);
        return Vec3<double>(apart * Vec3<double>(std::cos(turn), std::sin(turn), 0));
      };
      // Anywhere, beside a vertex, on an edge.
      const Index h = test::uniform_index(random, surface.halfedge_count());
      const Vec3<double> corner = surface.position(surface.origin(h)),
                         other = surface.position(surface.tip(h));
      if (std::min(corner.head(2).minCoeff(), other.head(2).minCoeff()) < 0.5) continue;
      if (std::max(corner.head(2).maxCoeff(), other.head(2).maxCoeff()) > 5.5) continue;
      Vec3<double> x(uniform(random, 1, 5), uniform(random, 1, 5), 0), y = x + aside();
      if (i % 3 == 1) std::tie(x, y) = std::pair(corner + aside(), corner + aside());
      if (i % 3 == 2) x = 0.4 * corner + 0.6 * other, y = x + aside();
      const Sources close{{nearest_point(surface, x), 0}, {nearest_point(surface, y), 0}};
      x = surface.position(close[0].point);
      y = surface.position(close[1].point);
      const Edges edges = edges_of(solver, close);
      CHECK(edges.size() == 1);
      for (const auto& edge : edges) {
        CHECK(is_at_border(surface, edge.points.front()));
        CHECK(is_at_border(surface, edge.points.back()));
      }
      // Where it lies is rounding of its distances over that by which they differ.
      CHECK(std::abs(length_of(surface, edges) - bisector_length(x, y, 6)) <=
            4e-13 / (x - y).norm());
      for (const auto& edge : edges) {
        for (const auto& point : edge.points) {
          const Vec3<double> p = surface.position(point);
          CHECK(std::abs((p - x).norm() - (p - y).norm()) <= 5e-14);
        }
      }
    }
  }
}

TEST_CASE("a flat sheet: a source beside an edge, by less than positions are rounded by") {
  Random random(5);
  const Mesh<double> mesh = test::jittered_grid(6, 0.2, random);
  const ExactSolver solver(mesh, keeping());
  for (int i = 0; i < 60; ++i) {
    const Index f = test::uniform_index(random, solver.surface().face_count());
    const double t = std::pow(10, uniform(random, -4, -1)), off = 5e-15 * t;
    const Sources beside{{face_point<double>(f, {t, off, 1 - t - off}), 0},
                         {test::random_point(mesh, random), 0}};
    const Edges edges = edges_of(solver, beside);
    CHECK(edges.size() == 1);
    check_edges(solver, beside, edges, 1e-9);
  }
}

TEST_CASE("a tube: two sources behind each other have two straight rings or one way round") {
  const auto mesh = tube(20);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  // At one height, opposite: two lines along the tube.
  const Edges along = edges_of(solver, vertices({60, 63}));
  REQUIRE(along.size() == 2);
  CHECK(length_of(surface, along) == gelight::test::approx(40).epsilon(1e-12));
  // On one line, six apart: a ring, straight where neither goes round.
  const Sources apart = vertices({6 * 7, 6 * 13});
  const Edges ring = edges_of(solver, apart);
  REQUIRE(ring.size() == 1);
  CHECK(ring[0].is_closed);
  CHECK(length_of(surface, ring) == gelight::test::approx(6).epsilon(1e-12));
  // A later one: the branch of a hyperbola, which meets itself on the far side.
  Sources later = apart;
  later[1].distance = 2;
  const Edges curved = edges_of(solver, later);
  REQUIRE(curved.size() == 1);
  CHECK(curved[0].is_closed);
  for (const auto& point : curved[0].points) {
    const Vec3<double> x = surface.position(point);
    // Laid flat: how far round from the line of both.
    const double corner = std::atan2(x[1], x[0]) / (pi / 3);
    const double side = std::floor(corner);
    const Vec3<double> a(std::cos(pi / 3 * side), std::sin(pi / 3 * side), x[2]);
    const double round = std::abs(side + (x - a).norm());
    const double aside = std::min(round, 6 - round);
    const double to_first = std::hypot(aside, x[2] - 7), to_second = std::hypot(aside, x[2] - 13);
    CHECK(std::abs(to_first - to_second - 2) <= 1e-12);
  }
}

TEST_CASE("a ball: the cells of its poles are halves, by a line on the mesh's own equator") {
  // An octahedron, split twice: symmetric to its equator, on which edges lie.
  const Mesh<double> octahedron{
      {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}}};
  const ExactSolver plain(octahedron, keeping());
  const Edges equator = edges_of(plain, vertices({4, 5}));
  CHECK(length_of(plain.surface(), equator) ==
        gelight::test::approx(4 * std::sqrt(2.0)).epsilon(1e-12));
  // Of two neighbouring corners the plane between them.
  const Edges between = edges_of(plain, vertices({0, 1}));
  for (const auto& edge : between) {
    for (const auto& point : edge.points) {
      const Vec3<double> x = plain.surface().position(point);
      CHECK(std::abs(x[0] - x[1]) <= 1e-12);
    }
  }
  CHECK(!between.empty());
}

TEST_CASE("next to a corner: a source that is seen twice behind it has whole lines") {
  const Mesh<double> mesh = icosphere<double>(0);
  const ExactSolver solver(mesh, keeping());
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    const double beside = std::pow(10.0, -uniform(random, 9, 13)), share = uniform(random, 0, 1);
    const Index f = test::uniform_index(random, solver.surface().face_count());
    const std::array<double, 3> corner{1 - beside, share * beside, (1 - share) * beside};
    const Sources sources{{face_point(f, corner), 0}, {test::random_point(mesh, random), 0}};
    if (solver.solve(sources[0]).distance(sources[1].point) < 0.1) continue;
    const Edges edges = edges_of(solver, sources);
    for (const auto& edge : edges) CHECK(edge.is_closed);
    check_edges(solver, sources, edges, 1e-9);
  }
}

// Two polygons on each other, joined along their border, each a fan about its middle whose faces
// are split in three.
Mesh<double> doubled_polygon(Index corners) {
  Mesh<double> mesh;
  for (Index i = 0; i < corners; ++i) {
    mesh.positions.push_back({std::cos(2 * pi * i / corners), std::sin(2 * pi * i / corners), 0});
  }
  for (const bool is_below : {false, true}) {
    const auto middle = Index(mesh.positions.size());
    mesh.positions.push_back({0.1, 0.05, 0});
    for (Index i = 0; i < corners; ++i) {
      Index a = i, b = (i + 1) % corners;
      const auto p = mesh.positions[std::size_t(a)], q = mesh.positions[std::size_t(b)];
      if (is_below) std::swap(a, b);
      const auto v = Index(mesh.positions.size());
      mesh.positions.push_back({(p[0] + q[0] + 0.1) / 3, (p[1] + q[1] + 0.05) / 3, 0});
      mesh.faces.insert(mesh.faces.end(), {{a, b, v}, {b, middle, v}, {middle, a, v}});
    }
  }
  return mesh;
}

TEST_CASE("sheets that lie on each other: lines keep to their own") {
  Random random(6);
  for (const Index corners : {3, 4, 5}) {
    const Mesh<double> mesh = doubled_polygon(corners);
    const ExactSolver solver(mesh, keeping());
    for (int i = 0; i < 20; ++i) {
      Sources sources;
      for (int k = 0; k < 3; ++k) {
        // On the border, so that both sheets have the same lines.
        const Index a = test::uniform_index(random, corners);
        sources.push_back({edge_point(a, (a + 1) % corners, uniform(random, 0, 1)), 0});
      }
      check_edges(solver, sources, edges_of(solver, sources), 1e-9);
    }
  }
}

TEST_CASE("lines end at an edge of three faces") {
  // Three pages on one spine, of vertices 0 and 1.
  Mesh<double> mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}};
  for (const double turn : {0.0, 2.0, 4.0}) {
    const auto a = Index(mesh.positions.size());
    mesh.positions.push_back({std::cos(turn), std::sin(turn), 0});
    mesh.positions.push_back({std::cos(turn), std::sin(turn), 1});
    mesh.faces.push_back({0, a, a + 1});
    mesh.faces.push_back({0, a + 1, 1});
  }
  std::swap(mesh.faces[0][1], mesh.faces[0][2]);
  std::swap(mesh.faces[1][1], mesh.faces[1][2]);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  Random random(2);
  for (int i = 0; i < 40; ++i) {
    const Sources sources{{test::random_point(mesh, random), 0},
                          {test::random_point(mesh, random), 0}};
    if (solver.solve(sources[0]).distance(sources[1].point) < 0.05) continue;
    for (const auto& edge : edges_of(solver, sources)) {
      const std::vector<Index> faces = faces_along(surface, edge.points);
      for (std::size_t k = 1; k < faces.size(); ++k) CHECK(faces[k] / 2 == faces[k - 1] / 2);
    }
  }
}

TEST_CASE("a flat sheet with needles and caps: the line is as true and as whole as without") {
  Random random(8);
  for (int i = 0; i < 40; ++i) {
    Mesh<double> mesh = grid<double>(3, 3);
    for (int k = 0; k < 12; ++k) {
      // A new vertex next to an edge or a corner of a face.
      const Index f = test::uniform_index(random, Index(mesh.faces.size()));
      const double thin = std::pow(10.0, -uniform(random, 3, 9));
      const double t = k % 2 == 0 ? uniform(random, 0.2, 0.8) : thin;
      test::split_face(mesh, f, t, thin);
    }
    const ExactSolver solver(mesh, keeping());
    const Surface<double>& surface = solver.surface();
    const Sources sources{{test::random_point(mesh, random), 0},
                          {test::random_point(mesh, random), 0}};
    const Vec3<double> x = surface.position(sources[0].point);
    const Vec3<double> y = surface.position(sources[1].point);
    if ((x - y).norm() < 0.05) continue;
    const Edges edges = edges_of(solver, sources);
    CHECK(edges.size() == 1);
    CHECK(length_of(surface, edges) ==
          gelight::test::approx(bisector_length(x, y, 1)).epsilon(1e-9));
    for (const auto& edge : edges) {
      for (const auto& point : edge.points) {
        const Vec3<double> p = surface.position(point);
        CHECK(std::abs((p - x).norm() - (p - y).norm()) <= 1e-10);
      }
    }
  }
}

TEST_CASE("meshes like a scanner's: as far from both, none nearer, and none is missed") {
  Random random(4);
  int lines = 0;
  for (const auto& scan : test::scan_meshes(2)) {
    INFO(scan.name);
    const auto& mesh = scan.mesh;
    const ExactSolver solver(mesh, keeping());
    const Surface<double>& surface = solver.surface();
    Sources sources;
    const auto size = detail::size_of(surface);
    for (int i = 0; i < 6; ++i) {
      sources.push_back({test::random_point(mesh, random), i % 2 * uniform(random, 0, 0.1) * size});
    }
    const Edges edges = edges_of(solver, sources);
    lines += static_cast<int>(edges.size());
    check_edges(solver, sources, edges, 1e-9 * size);
    check_complete(solver, sources, edges, 1e-7 * size, 400, random);
  }
  CHECK(lines > 200);
}

TEST_CASE("lines along edges and through vertices are there once") {
  // Of a regular grid, by sources at the same distance from a row or a diagonal of vertices.
  const auto mesh = grid<double>(8, 8, 8, 8);
  const ExactSolver solver(mesh, keeping());
  const Surface<double>& surface = solver.surface();
  const auto vertex = [](Index x, Index y) { return 9 * y + x; };
  const auto once = [&](Index a, Index b, double expected) {
    const Sources sources = vertices({a, b});
    const Edges edges = edges_of(solver, sources);
    CHECK(edges.size() == 1);
    CHECK(length_of(surface, edges) == gelight::test::approx(expected).epsilon(1e-10));
    check_edges(solver, sources, edges, 1e-11);
  };
  once(vertex(2, 4), vertex(6, 4), 8);
  once(vertex(4, 1), vertex(4, 7), 8);
  once(vertex(1, 0), vertex(3, 8), std::sqrt(68.0));
  once(vertex(2, 2), vertex(6, 6), 8 * std::sqrt(2.0));
  once(vertex(2, 6), vertex(6, 2), 8 * std::sqrt(2.0));
}

TEST_CASE("sources that came too late have no cell, and the others keep their numbers") {
  const auto mesh = grid<double>(6, 6, 6, 6);
  const ExactSolver solver(mesh, keeping());
  Sources sources = vertices({0, 8, 48});
  sources[0].distance = 1e6;
  const Edges edges = edges_of(solver, sources);
  REQUIRE(edges.size() == 1);
  CHECK(edges[0].sources == std::array<Index, 2>{1, 2});
  CHECK(edges_of(solver, vertices({3})).empty());
  // Twice the same source: the first has it all.
  for (const auto& edge : edges_of(solver, vertices({8, 8, 48}))) {
    CHECK(edge.sources == std::array<Index, 2>{0, 2});
  }
}

TEST_CASE("float, and what cannot be answered") {
  const auto mesh = icosphere<float>(2);
  ExactOptions<float> options;
  options.keep_windows = true;
  const ExactSolver solver(mesh, options);
  const std::vector<Index> pair{0, 40};
  const auto field = solver.solve(pair);
  for (const auto& edge : exact_voronoi_edges(field)) {
    for (const auto& point : edge.points) {
      CHECK(solver.solve(Index{0}).distance(point) ==
            gelight::test::approx(solver.solve(Index{40}).distance(point)).epsilon(1e-5));
    }
  }
  const auto refused = [&](const auto& f, const VoronoiEdgeOptions<float>& how) {
    return test::refusal([&] { (void)exact_voronoi_edges(f, how); });
  };
  ExactOptions<float> bare;
  CHECK(test::contains(refused(solver.solve(pair, bare), {}), "keep_windows"));
  options.max_distance = 1;
  CHECK(test::contains(refused(solver.solve(pair, options), {}), "greatest distance"));
  CHECK(test::contains(refused(field, {-1.0F, {}}), "deviation"));
  const std::vector<Segment<float>> curve{{vertex_point<float>(0), vertex_point<float>(0)}};
  CHECK(test::contains(refused(solver.solve(std::span<const Segment<float>>(curve)), {}),
                       "segments"));
  CHECK_THROWS_AS((void)exact_voronoi_edges(field, {1e-3F, [] { return true; }}), Cancelled);
}
