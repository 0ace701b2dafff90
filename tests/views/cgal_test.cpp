#include "gelight/views/cgal.hpp"

#include <CGAL/Simple_cartesian.h>
#include <doctest/doctest.h>

#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"

using gelight::Index;
using gelight::Surface;

namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;

static_assert(gelight::TriangleMesh<SurfaceMesh>);

SurfaceMesh to_cgal(const gelight::Mesh<double>& source) {
  SurfaceMesh mesh;
  for (const auto& [x, y, z] : source.positions) mesh.add_vertex(Point(x, y, z));
  const auto vertex = [](Index v) { return SurfaceMesh::Vertex_index(static_cast<unsigned>(v)); };
  for (const auto& [a, b, c] : source.faces) mesh.add_face(vertex(a), vertex(b), vertex(c));
  return mesh;
}

}  // namespace

TEST_CASE("a Surface_mesh is read vertex for vertex and face for face") {
  const auto source = gelight::icosphere(2, 1.0);
  const Surface expected(source), surface(to_cgal(source));
  REQUIRE(surface.vertex_count() == 162);
  REQUIRE(surface.face_count() == 320);
  for (Index v = 0; v < 162; ++v) CHECK(surface.position(v) == expected.position(v));
  for (Index f = 0; f < 320; ++f) {
    // A face may start at another of its vertices, but keeps the turn.
    auto face = expected.face(f);
    while (face[0] != surface.face(f)[0]) face = {face[1], face[2], face[0]};
    CHECK(face == surface.face(f));
  }
}

TEST_CASE("removed faces and faces with four sides are refused by name") {
  SurfaceMesh mesh = to_cgal(gelight::box(1.0, 1.0, 1.0));
  mesh.remove_face(SurfaceMesh::Face_index(3));
  CHECK_THROWS_WITH_AS(
      (void)Surface<double>(mesh),
      "the mesh has 1 removed faces and 0 removed vertices; call collect_garbage() first",
      gelight::InvalidInput);
  SurfaceMesh quad;
  std::vector<SurfaceMesh::Vertex_index> corners;
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    corners.push_back(quad.add_vertex(Point(x, y, 0)));
  }
  quad.add_face(corners);
  CHECK_THROWS_WITH_AS((void)Surface<double>(quad), "face 0 is not a triangle",
                       gelight::InvalidInput);
}
