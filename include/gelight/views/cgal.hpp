#pragma once

#include <CGAL/Surface_mesh.h>

#include <array>
#include <concepts>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

namespace gelight {

/// CGAL's Surface_mesh with points of any kernel; positions are read as double. Reading a mesh with
/// removed elements or a face that is not a triangle throws InvalidInput.
template <class Point>
struct MeshTraits<CGAL::Surface_mesh<Point>> {
  /// See MeshTraits.
  ///@{
  using M = CGAL::Surface_mesh<Point>;
  using Scalar = double;
  static auto vertex_count(const M& mesh) {
    detail::require(!mesh.has_garbage(), "the mesh has ", mesh.number_of_removed_faces(),
                    " removed faces and ", mesh.number_of_removed_vertices(),
                    " removed vertices; call collect_garbage() first");
    return mesh.number_of_vertices();
  }
  static auto face_count(const M& mesh) { return mesh.number_of_faces(); }
  static std::array<double, 3> position(const M& mesh, Index v) {
    const Point& p = mesh.point(typename M::Vertex_index(static_cast<typename M::size_type>(v)));
    return {CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())};
  }
  static std::array<Index, 3> face(const M& mesh, Index f) {
    const auto a = mesh.halfedge(typename M::Face_index(static_cast<typename M::size_type>(f)));
    const auto b = mesh.next(a), c = mesh.next(b);
    detail::require(mesh.next(c) == a, "face ", f, " is not a triangle");
    return {vertex(mesh, a), vertex(mesh, b), vertex(mesh, c)};
  }
  ///@}

 private:
  static Index vertex(const M& mesh, typename M::Halfedge_index h) {
    return static_cast<Index>(mesh.source(h).idx());
  }
};

}  // namespace gelight
