#pragma once

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/DefaultTriMesh.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>

#include "gelight/core/error.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/views/mesh_view.hpp"
#include "gelight/views/openmesh.hpp"

/// While it lives, what OpenMesh says goes here, not to standard error.
class OpenMeshWords {
 public:
  OpenMeshWords() {
    ::omerr().disconnect(std::cerr);
    ::omerr().connect(words_);
  }
  ~OpenMeshWords() {
    ::omerr().disconnect(words_);
    ::omerr().connect(std::cerr);
  }
  OpenMeshWords(const OpenMeshWords&) = delete;
  OpenMeshWords& operator=(const OpenMeshWords&) = delete;

  [[nodiscard]] bool have(const std::string& words) const {
    return words_.str().find(words) != std::string::npos;
  }

 private:
  std::ostringstream words_;
};

/// The mesh of a file that OpenMesh reads (STL, OBJ, PLY, OFF). Throws InvalidInput if there is
/// none in it, or one that OpenMesh would mend: faces that it leaves out or tears off.
[[nodiscard]] inline gelight::Mesh<double> mesh_of_file(const std::filesystem::path& path) {
  using gelight::detail::require;
  const std::string name = path.string();
  require(std::filesystem::exists(path), "there is no mesh ", name);
  OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble> file;
  file.request_vertex_status();
  const OpenMeshWords said;
  const bool is_read = OpenMesh::IO::read_mesh(file, name);
  require(!said.have("invalid") && !said.have("equal vertices"), name,
          " has a face with a vertex that is not in it, or with one twice; it would be left out");
  require(is_read && file.n_faces() > 0, "no mesh can be read from ", name);
  // Such faces are given vertices that the file has not.
  const auto torn = std::count_if(file.vertices_begin(), file.vertices_end(), [&](const auto& v) {
    return file.status(v).fixed_nonmanifold();
  });
  require(torn == 0, name, " has faces that meet others at an edge of more than two, the wrong ",
          "way round or in a vertex alone; they would be torn off");
  const gelight::Surface<double> surface(file);
  gelight::Mesh<double> mesh;
  for (gelight::Index v = 0; v < surface.vertex_count(); ++v) {
    const gelight::Vec3<double>& p = surface.position(v);
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (gelight::Index f = 0; f < surface.face_count(); ++f) mesh.faces.push_back(surface.face(f));
  return mesh;
}
