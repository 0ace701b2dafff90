#pragma once

#include <cstddef>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::detail {

/// The vertices and faces of any mesh, whatever is wrong with them.
template <TriangleMesh M>
[[nodiscard]] Mesh<MeshScalar<M>> copied(const M& mesh) {
  using T = MeshScalar<M>;
  Mesh<T> copy;
  const auto vertices = static_cast<Index>(MeshTraits<M>::vertex_count(mesh));
  const auto faces = static_cast<Index>(MeshTraits<M>::face_count(mesh));
  copy.positions.reserve(static_cast<std::size_t>(vertices));
  copy.faces.reserve(static_cast<std::size_t>(faces));
  for (Index v = 0; v < vertices; ++v) {
    const auto& p = MeshTraits<M>::position(mesh, v);
    copy.positions.push_back({static_cast<T>(p[0]), static_cast<T>(p[1]), static_cast<T>(p[2])});
  }
  for (Index f = 0; f < faces; ++f) copy.faces.push_back(MeshTraits<M>::face(mesh, f));
  return copy;
}

}  // namespace gelight::detail
