#pragma once

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <array>
#include <concepts>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

namespace gelight {

/// Any triangle mesh of OpenMesh, with any traits. Reading a face that is marked deleted throws
/// InvalidInput: collect garbage first.
template <std::derived_from<OpenMesh::TriConnectivity> M>
struct MeshTraits<M> {
  /// See MeshTraits.
  ///@{
  using Scalar = typename M::Scalar;
  static auto vertex_count(const M& mesh) { return mesh.n_vertices(); }
  static auto face_count(const M& mesh) { return mesh.n_faces(); }
  static auto position(const M& mesh, Index v) { return mesh.point(OpenMesh::VertexHandle(v)); }
  static std::array<Index, 3> face(const M& mesh, Index f) {
    const OpenMesh::FaceHandle handle(f);
    detail::require(!mesh.has_face_status() || !mesh.status(handle).deleted(), "face ", f,
                    " is marked deleted; call garbage_collection() first");
    const auto a = mesh.halfedge_handle(handle);
    const auto b = mesh.next_halfedge_handle(a);
    return {mesh.from_vertex_handle(a).idx(), mesh.to_vertex_handle(a).idx(),
            mesh.to_vertex_handle(b).idx()};
  }
  ///@}
};

}  // namespace gelight
