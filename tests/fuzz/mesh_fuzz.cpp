#include <cstddef>
#include <cstdint>
#include <sstream>

#include "fuzz/bytes.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/tangent.hpp"

// Construction, check and repair of any mesh: what check foretells happens, and a mesh of which all
// is repaired is taken.

using namespace gelight;

namespace {

bool is_taken(const Mesh<double>& mesh) {
  try {
    const Surface surface(mesh);
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      fuzz::expect(surface.length(h) == surface.length(surface.twin(h)), "twins differ in length");
    }
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

bool is_oriented(const Mesh<double>& mesh) {
  try {
    require_oriented(Surface(mesh));
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const auto choice = bytes.take<std::uint8_t>();
  const Mesh<double> mesh = fuzz::take_mesh(bytes, 24, 40);
  const MeshReport report = check(mesh);
  std::ostringstream text;
  text << report;
  fuzz::expect(report.is_accepted() == is_taken(mesh), "check and Surface disagree");
  fuzz::expect(report.is_oriented() == is_oriented(mesh), "check and require_oriented disagree");

  RepairOptions some;
  some.drop_unusable_faces = (choice & 1) != 0;
  if ((choice & 2) != 0) some.weld_distance = choice / 64.0;
  some.drop_degenerate_faces = (choice & 4) != 0;
  some.orient = (choice & 8) != 0;
  some.split_vertices = (choice & 16) != 0;
  some.drop_unused_vertices = (choice & 32) != 0;
  some.order_in_space = (choice & 64) != 0;
  const auto mended = repair(mesh, some);
  fuzz::expect(mended.vertex_of.size() == mended.mesh.positions.size() &&
                   mended.face_of.size() == mended.mesh.faces.size(),
               "the maps do not fit the mesh");
  if (some.drop_unusable_faces && some.drop_unused_vertices && !mended.mesh.faces.empty()) {
    fuzz::expect(is_taken(mended.mesh) || check(mended.mesh).is_too_small, "repaired, but refused");
  }
  return 0;
}
