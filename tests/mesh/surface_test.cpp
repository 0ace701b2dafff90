#include "gelight/mesh/surface.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <ranges>
#include <set>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"

using gelight::Index;
using gelight::InvalidInput;
using gelight::Mesh;
using gelight::Surface;
using gelight::test::contains;

static_assert(gelight::TriangleMesh<Surface<float>> && gelight::TriangleMesh<Surface<double>>);

namespace {

Mesh<double> tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

std::string message_of(const Mesh<double>& mesh) {
  return gelight::test::refusal([&] { Surface surface(mesh); });
}

}  // namespace

TEST_CASE("a closed manifold: every twin runs the other way along the same edge") {
  const Surface surface(tetrahedron());
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    CHECK(surface.is_manifold(h));
    CHECK_FALSE(surface.is_border(h));
    CHECK(surface.origin(surface.twin(h)) == surface.tip(h));
    CHECK(surface.length(surface.twin(h)) == surface.length(h));
    CHECK(surface.apex(h) == surface.tip(Surface<double>::next(h)));
  }
  CHECK(surface.length(surface.find_halfedge(1, 3)) == gelight::test::approx(std::sqrt(2.0)));
  CHECK(surface.find_halfedge(1, 1) == -1);
}

TEST_CASE("corners of a vertex: one half-edge out of it in each of its faces") {
  const Surface surface(tetrahedron());
  for (Index v = 0; v < 4; ++v) {
    std::set<Index> faces;
    for (const Index h : surface.corners(v)) {
      CHECK(surface.origin(h) == v);
      faces.insert(Surface<double>::face_of(h));
    }
    CHECK(faces.size() == 3);
  }
}

TEST_CASE("what is found in a vertex' corners outlives the slice in which it was found") {
  const Surface surface(tetrahedron());
  for (Index v = 0; v < 4; ++v) {
    const Index last = surface.corners(v).back();
    CHECK(*std::ranges::find(surface.corners(v), last) == last);
    CHECK(std::ranges::find(surface.corners(v), -1) == surface.corners(v).end());
  }
  static_assert(std::ranges::view<decltype(surface.corners(0))>);
}

TEST_CASE("borders, fins, flipped faces and unused vertices are held") {
  // Three faces share the edge 0-1, one of them turned over; vertex 5 is in none.
  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {9, 9, 9}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  const Surface surface(fin);
  std::set<Index> around;
  Index h = 0;
  do {
    around.insert(h);
    h = surface.twin(h);
  } while (h != 0);
  CHECK(around == std::set<Index>{0, 3, 6});
  CHECK_FALSE(surface.is_manifold(0));
  CHECK(surface.is_border(1));
  CHECK(surface.corners(5).empty());
}

TEST_CASE("half-edges of an edge are a cycle in the order of their numbers, however many faces") {
  gelight::test::Random random(21);
  for (int i = 0; i < 200; ++i) {
    // Few vertices, so that many edges have three faces and more.
    const Index vertices = 5 + i % 8;
    Mesh<double> mesh;
    for (Index v = 0; v < vertices; ++v) {
      mesh.positions.push_back({gelight::test::uniform(random, -1, 1),
                                gelight::test::uniform(random, -1, 1),
                                gelight::test::uniform(random, -1, 1)});
    }
    std::set<std::set<Index>> known;
    for (int k = 0; k < 3 * vertices; ++k) {
      const std::array<Index, 3> face{gelight::test::uniform_index(random, vertices),
                                      gelight::test::uniform_index(random, vertices),
                                      gelight::test::uniform_index(random, vertices)};
      const std::set<Index> corners(face.begin(), face.end());
      if (corners.size() == 3 && known.insert(corners).second) mesh.faces.push_back(face);
    }
    const Surface surface(mesh);
    std::map<std::set<Index>, std::vector<Index>> edges;
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      edges[{surface.origin(h), surface.tip(h)}].push_back(h);
    }
    for (const auto& [ends, of_edge] : edges) {
      for (std::size_t k = 0; k < of_edge.size(); ++k) {
        CHECK(surface.twin(of_edge[k]) == of_edge[(k + 1) % of_edge.size()]);
        CHECK(surface.length(of_edge[k]) == surface.length(of_edge[0]));
      }
    }
    // A face once more, turned: whatever lies between the two.
    const Index again = gelight::test::uniform_index(random, surface.face_count());
    const std::array<Index, 3> face = surface.face(again);
    mesh.faces.push_back({face[1], face[0], face[2]});
    CHECK(message_of(mesh) == "faces " + std::to_string(again) + " and " +
                                  std::to_string(surface.face_count()) +
                                  " have the same three vertices");
  }
}

TEST_CASE("the short edge's length is that which a tenth of the half-edges fall short of") {
  gelight::test::Random random(22);
  for (const double scale : {1e-60, 1e-6, 1.0, 1e6, 1e60}) {
    for (int i = 0; i < 20; ++i) {
      auto mesh = gelight::test::small_random_mesh(i, random);
      for (auto& p : mesh.positions) {
        for (double& x : p) x *= scale;
      }
      if (i % 4 == 0) mesh.positions[1] = mesh.positions[0];
      const Surface surface(mesh);
      std::vector<double> lengths;
      for (Index h = 0; h < surface.halfedge_count(); ++h) {
        if (surface.length(h) > 0) lengths.push_back(surface.length(h));
      }
      std::sort(lengths.begin(), lengths.end());
      CHECK(gelight::detail::short_edge_length(surface) == lengths[lengths.size() / 10]);
    }
  }
}

TEST_CASE("bad meshes are refused with the value and its place") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Mesh<double> mesh = tetrahedron();
  CHECK(message_of({}) == "the mesh has no vertices");
  CHECK(message_of({mesh.positions, {}}) == "the mesh has no faces");
  mesh.faces[2] = {1, 4, 3};
  CHECK(message_of(mesh) == "face 2 has vertex 4, the mesh has vertices 0 to 3");
  mesh.faces[2] = {1, -1, 3};
  CHECK(message_of(mesh) == "face 2 has vertex -1, the mesh has vertices 0 to 3");
  mesh.faces[2] = {1, 3, 1};
  CHECK(message_of(mesh) == "face 2 has a vertex twice: (1, 3, 1)");
  mesh.faces[2] = {1, 3, 0};
  CHECK(message_of(mesh) == "faces 1 and 2 have the same three vertices");
  mesh = tetrahedron();
  mesh.positions[3][1] = nan;
  CHECK(message_of(mesh) == "vertex 3 has position (0, nan, 1), which is not finite");
  mesh.positions[3][1] = -0x1p300;
  CHECK(contains(message_of(mesh), "vertex 3 has position (0, -2.03"));
  CHECK(contains(message_of(mesh), "too far out: products of lengths would overflow"));
  mesh.positions = {{0, 0, 0}, {1e-80, 0, 0}, {0, 1e-80, 0}, {0, 0, 0}};
  CHECK(contains(message_of(mesh), "long: products of lengths would vanish"));
  mesh.positions[3] = {0, 1, 0};
  CHECK(Surface<double>(mesh).length(0) == 0);
}

TEST_CASE("whichever coordinate is no number, its vertex is named") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {nan, -nan, infinity, -infinity, 1.01e75, -1.01e75}) {
    for (std::size_t v = 0; v < 5; ++v) {  // the fifth is in no face
      for (std::size_t k = 0; k < 3; ++k) {
        Mesh<double> mesh = tetrahedron();
        mesh.positions.push_back({1, 1, 1});
        mesh.positions[v][k] = wrong;
        CAPTURE(wrong);
        CHECK(contains(message_of(mesh), "vertex " + std::to_string(v) + " has position ("));
      }
    }
  }
}

TEST_CASE("of no size at all is a mesh too") {
  const Mesh<double> mesh{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}};
  CHECK(Surface<double>(mesh).length(0) == 0);
}

TEST_CASE("surface points are found where their weights say, or refused") {
  const Surface surface(tetrahedron());
  using gelight::edge_point, gelight::face_point, gelight::vertex_point;
  CHECK(surface.position(edge_point<double>(0, 1, 0.25))[0] == gelight::test::approx(0.25));
  CHECK(surface.position(face_point<double>(0, {0.5, 0.25, 0.25}))[1] ==
        gelight::test::approx(0.25));
  CHECK_THROWS_AS((void)surface.position(vertex_point<double>(4)), InvalidInput);
  CHECK_THROWS_AS((void)surface.position(edge_point<double>(0, 0, 0.5)), InvalidInput);
  CHECK_THROWS_AS((void)surface.position(edge_point<double>(0, 1, 1.5)), InvalidInput);
  CHECK_THROWS_AS((void)surface.position(face_point<double>(4, {1, 0, 0})), InvalidInput);
  CHECK_THROWS_AS((void)surface.position(face_point<double>(0, {1, 1, 0})), InvalidInput);
}

TEST_CASE("surface points with shares of corners that they do not have are refused") {
  using Point = gelight::SurfacePoint<double>;
  const auto mesh = tetrahedron();
  const Surface surface(mesh);
  const Point points[] = {{Point::Kind::edge, {0, 1}, {0.3, 0.3, 0.4}},
                          {Point::Kind::edge, {0, 1}, {0, 0, 1}},
                          {Point::Kind::vertex, {0, -1}, {0, 1, 0}},
                          {Point::Kind::vertex, {0, -1}, {0.5, 0, 0.5}},
                          {Point::Kind{9}, {0, -1}, {1, 0, 0}}};
  for (const Point& point : points) {
    CHECK_THROWS_AS((void)surface.position(point), InvalidInput);
    const gelight::Source<double> source{point, 0};
    CHECK_THROWS_AS((void)gelight::DijkstraSolver(mesh).distance(source), InvalidInput);
    CHECK_THROWS_AS((void)gelight::FastMarchingSolver(mesh).distance(source), InvalidInput);
  }
}

TEST_CASE_TEMPLATE("lengths survive a mesh far from the origin", T, float, double) {
  const T far = static_cast<T>(1e6);
  const Mesh<T> mesh{{{far, 0, 0}, {far + 1, 0, 0}, {far, 1, 0}}, {{0, 1, 2}}};
  CHECK(Surface<T>(mesh).length(0) == T{1});
}

TEST_CASE("the way between two points is as exact far from the origin as near it") {
  gelight::test::Random random(11);
  for (int i = 0; i < 300; ++i) {
    gelight::Mesh<double> mesh = gelight::test::small_random_mesh(i, random);
    for (auto& p : mesh.positions) {
      for (double& x : p) x = std::round(x * 1024) / 1024;
    }
    gelight::Mesh<double> far = mesh;
    for (auto& p : far.positions) p = {p[0] + 1e6, p[1] - 3e6, p[2] + 7e5};
    const gelight::Surface<double> surface(mesh), moved(far);
    const auto p = gelight::test::random_point(mesh, random);
    const auto q = gelight::test::random_point(mesh, random);
    const gelight::Vec3<double> way = surface.difference(p, q);
    CHECK(moved.difference(p, q) == way);
    CHECK((way - (surface.position(q) - surface.position(p))).norm() <= 1e-12 * way.norm() + 1e-13);
    CHECK(surface.difference(p, p).norm() == 0);
  }
}
