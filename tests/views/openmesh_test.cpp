#include "gelight/views/openmesh.hpp"

#include <doctest/doctest.h>

#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"

using gelight::Index;
using gelight::Surface;
using gelight::TriangleMesh;

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};
using DoubleMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;
using FloatMesh = OpenMesh::TriMesh_ArrayKernelT<>;

static_assert(TriangleMesh<DoubleMesh> && TriangleMesh<FloatMesh>);
static_assert(std::same_as<gelight::MeshScalar<DoubleMesh>, double>);
static_assert(std::same_as<gelight::MeshScalar<FloatMesh>, float>);

DoubleMesh open_mesh(const gelight::Mesh<double>& source) {
  DoubleMesh mesh;
  for (const auto& [x, y, z] : source.positions) mesh.add_vertex({x, y, z});
  for (const auto& [a, b, c] : source.faces) {
    mesh.add_face(OpenMesh::VertexHandle(a), OpenMesh::VertexHandle(b), OpenMesh::VertexHandle(c));
  }
  return mesh;
}

}  // namespace

TEST_CASE("an OpenMesh is read vertex for vertex and face for face") {
  const auto source = gelight::icosphere(2, 1.0);
  const Surface surface(open_mesh(source));
  REQUIRE(surface.vertex_count() == 162);
  REQUIRE(surface.face_count() == 320);
  const Surface expected(source);
  for (Index v = 0; v < 162; ++v) CHECK(surface.position(v) == expected.position(v));
  for (Index f = 0; f < 320; ++f) {
    // OpenMesh may start a face at another of its vertices, but keeps the turn.
    auto face = expected.face(f);
    while (face[0] != surface.face(f)[0]) face = {face[1], face[2], face[0]};
    CHECK(face == surface.face(f));
  }
}

TEST_CASE("a deleted face that still stands in the arrays is refused by name") {
  DoubleMesh mesh = open_mesh(gelight::box(1.0, 1.0, 1.0));
  mesh.request_face_status();
  mesh.request_edge_status();
  mesh.request_vertex_status();
  mesh.delete_face(OpenMesh::FaceHandle(3), false);
  CHECK_THROWS_WITH_AS((void)Surface<double>(mesh),
                       "face 3 is marked deleted; call garbage_collection() first",
                       gelight::InvalidInput);
  mesh.garbage_collection();
  CHECK(Surface<double>(mesh).face_count() == 11);
}
