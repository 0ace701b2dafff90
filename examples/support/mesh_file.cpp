#include "mesh_file.hpp"

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/DefaultTriMesh.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <clocale>
#include <iostream>
#include <locale>
#include <new>
#include <sstream>
#include <streambuf>
#include <utility>

#include "gelight/mesh/surface.hpp"
#include "gelight/views/openmesh.hpp"
#include "mesh_text.hpp"

namespace {

// While it lives, what OpenMesh says on standard error goes here. (Its own way to have that loses
// memory whenever a stream is disconnected.)
class OpenMeshWords {
 public:
  OpenMeshWords() : before_(std::cerr.rdbuf(words_.rdbuf())) {}
  ~OpenMeshWords() { std::cerr.rdbuf(before_); }
  OpenMeshWords(const OpenMeshWords&) = delete;
  OpenMeshWords& operator=(const OpenMeshWords&) = delete;

  [[nodiscard]] bool have(const std::string& words) const {
    return words_.str().find(words) != std::string::npos;
  }

 private:
  std::ostringstream words_;
  std::streambuf* before_;
};

// While it lives, streams read numbers as all programs write them, whatever locale is set:
// OpenMesh misreads numbers in another, and never ends with the head of a PLY file.
class PlainNumbers {
 public:
  PlainNumbers() = default;
  ~PlainNumbers() {
    std::locale::global(cpp_);
    std::setlocale(LC_ALL, c_.c_str());  // which the line above may not have set
  }
  PlainNumbers(const PlainNumbers&) = delete;
  PlainNumbers& operator=(const PlainNumbers&) = delete;

 private:
  std::string c_ = std::setlocale(LC_ALL, nullptr);
  std::locale cpp_ = std::locale::global(std::locale::classic());
};

// Whether the points of some face do not lie on a line.
[[nodiscard]] bool has_area(const gelight::Mesh<double>& mesh) {
  return std::any_of(mesh.faces.begin(), mesh.faces.end(), [&](const auto& face) {
    const auto at = [&](std::size_t corner) {
      return gelight::Vec3<double>(mesh.position(face[corner]).data());
    };
    return !gelight::cross<double>(at(1) - at(0), at(2) - at(0)).isZero(0);
  });
}

}  // namespace

gelight::Mesh<double> mesh_of_file(const std::filesystem::path& path) {
  using gelight::detail::require;
  const std::string name = path.string();
  require(std::filesystem::exists(path), "there is no mesh ", name);
  require(!std::filesystem::is_directory(path), name, " is a folder, not a mesh");
  auto [points, obj_lines] = checked_text(path);
  OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble> file;
  file.request_vertex_status();
  const OpenMeshWords said;
  const PlainNumbers plain;
  bool is_read = false;
  try {
    const bool is_obj = !obj_lines.empty();
    std::istringstream obj(std::move(obj_lines));
    OpenMesh::IO::Options options;
    is_read = is_obj ? OpenMesh::IO::read_mesh(file, obj, ".obj", options)
                     : OpenMesh::IO::read_mesh(file, name);
  } catch (const std::bad_alloc&) {
    gelight::detail::refuse({name, " tells of more than there is memory for"});
  }
  require(!said.have("invalid") && !said.have("equal vertices"), name,
          " has a face with a vertex that is not in it, or with one twice; it would be left out");
  require(is_read && file.n_faces() > 0, "no mesh can be read from ", name);
  const auto bad = std::count_if(
      file.vertices_begin(), file.vertices_end(), [&](const OpenMesh::VertexHandle& v) {
        const auto& p = file.point(v);
        return !(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
      });
  require(bad == 0, name, " has ", bad, " points that are not finite");
  // Such faces are given vertices that the file has not.
  const auto torn = std::count_if(
      file.vertices_begin(), file.vertices_end(),
      [&](const OpenMesh::VertexHandle& v) { return file.status(v).fixed_nonmanifold(); });
  require(torn == 0, name, " has faces that meet others at an edge of more than two, the wrong ",
          "way round or in a vertex alone; they would be torn off");
  require(points.empty() || points.size() == file.n_vertices(), name, " has ", points.size(),
          " points, of which ", file.n_vertices(), " can be read");
  const gelight::Surface<double> surface(file);
  gelight::Mesh<double> mesh{points, {}};
  for (gelight::Index v = 0; points.empty() && v < surface.vertex_count(); ++v) {
    const gelight::Vec3<double>& p = surface.position(v);
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (gelight::Index f = 0; f < surface.face_count(); ++f) mesh.faces.push_back(surface.face(f));
  require(has_area(mesh), name, " has no area: the points of each face lie on a line");
  points.empty() ? require_precision<float>(mesh, name) : require_precision<double>(mesh, name);
  return mesh;
}
