#include "gelight/concepts/mesh.hpp"

#include <doctest/doctest.h>

#include <array>
#include <string>
#include <vector>

#include "gelight/mesh/surface.hpp"
#include "gelight/views/mesh_view.hpp"

static_assert(gelight::TriangleMesh<gelight::Mesh<float>> &&
              gelight::TriangleMesh<gelight::MeshView<double>>);

using gelight::Index;
using gelight::Surface;
using gelight::TriangleMesh;

// Someone else's mesh, known only through its traits.
namespace elsewhere {
struct Corner {
  float x, y, z;
};
struct Model {
  std::vector<Corner> corners;
  std::vector<unsigned> triangles;
};
}  // namespace elsewhere

template <>
struct gelight::MeshTraits<elsewhere::Model> {
  using Scalar = float;
  static std::size_t vertex_count(const elsewhere::Model& m) { return m.corners.size(); }
  static std::size_t face_count(const elsewhere::Model& m) { return m.triangles.size() / 3; }
  static std::array<float, 3> position(const elsewhere::Model& m, Index v) {
    const auto& c = m.corners[static_cast<std::size_t>(v)];
    return {c.x, c.y, c.z};
  }
  static std::array<Index, 3> face(const elsewhere::Model& m, Index f) {
    const unsigned* t = m.triangles.data() + 3 * f;
    return {static_cast<Index>(t[0]), static_cast<Index>(t[1]), static_cast<Index>(t[2])};
  }
};

namespace {

struct OwnMembers {
  using Scalar = double;
  int vertex_count() const { return 3; }
  int face_count() const { return 1; }
  const double* position(Index v) const { return xyz[static_cast<std::size_t>(v)].data(); }
  std::array<Index, 3> face(Index) const { return {0, 1, 2}; }
  std::array<std::array<double, 3>, 3> xyz{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
};

struct WithoutFaces {
  using Scalar = double;
  int vertex_count() const { return 0; }
  std::array<double, 3> position(Index) const { return {}; }
};

struct IntegerScalar : OwnMembers {
  using Scalar = int;
};

struct WordsForPositions : OwnMembers {
  std::array<std::string, 3> position(Index) const { return {}; }
};

struct QuadFaces : OwnMembers {
  std::array<Index, 4> face(Index) const { return {}; }
};

static_assert(TriangleMesh<elsewhere::Model>);
static_assert(TriangleMesh<OwnMembers>);
static_assert(!TriangleMesh<int>);
static_assert(!TriangleMesh<std::vector<double>>);
static_assert(!TriangleMesh<WithoutFaces>);
static_assert(!TriangleMesh<IntegerScalar>);
static_assert(!TriangleMesh<WordsForPositions>);
static_assert(!TriangleMesh<QuadFaces>);

}  // namespace

TEST_CASE("a foreign mesh and one with the members both become a surface") {
  const elsewhere::Model model{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2}};
  const Surface foreign(model);
  static_assert(std::same_as<decltype(foreign), const Surface<float>>);
  const Surface own(OwnMembers{});
  static_assert(std::same_as<decltype(own), const Surface<double>>);
  CHECK(foreign.face(0) == own.face(0));
  CHECK(foreign.position(1).cast<double>() == own.position(1));
}
