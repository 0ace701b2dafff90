#pragma once

#include <algorithm>
#include <concepts>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// About what a vertex adds to the distance of the last, on a mesh of edges long and short too: the
/// length that a tenth of the edges fall short of.
template <std::floating_point T>
T short_edge_length(const Surface<T>& surface) {
  std::vector<T> lengths;
  lengths.reserve(static_cast<std::size_t>(surface.halfedge_count()));
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    if (surface.length(h) > 0) lengths.push_back(surface.length(h));
  }
  if (lengths.empty()) return 0;
  const auto tenth = lengths.begin() + std::ssize(lengths) / 10;
  std::nth_element(lengths.begin(), tenth, lengths.end());
  return *tenth;
}

/// Calls `visit(face)` for each face that holds the point.
template <std::floating_point T>
inline void for_each_face_at(const Surface<T>& surface, const SurfacePoint<T>& point,
                             auto&& visit) {
  using Kind = typename SurfacePoint<T>::Kind;
  if (point.kind == Kind::face) return visit(point.element[0]);
  if (point.kind == Kind::vertex) {
    for (const Index h : surface.corners(point.element[0])) visit(surface.face_of(h));
    return;
  }
  const Index first = surface.find_halfedge(point.element[0], point.element[1]);
  Index h = first;
  do {
    visit(surface.face_of(h));
    h = surface.twin(h);
  } while (h != first);
}

/// Length of the straight line from a point to a vertex of a face that holds both.
template <std::floating_point T>
T straight_distance(const Surface<T>& surface, const SurfacePoint<T>& point, Index vertex) {
  return stable_norm(surface.difference(vertex_point<T>(vertex), point));
}

/// Calls `visit(vertex, distance)` for the vertices that a point reaches by a straight line: itself
/// if it is a vertex, else those of the faces that hold it, some perhaps twice.
template <std::floating_point T>
inline void for_each_vertex_near(const Surface<T>& surface, const SurfacePoint<T>& point,
                                 auto&& visit) {
  if (point.kind == SurfacePoint<T>::Kind::vertex) return visit(point.element[0], T(0));
  for_each_face_at(surface, point, [&](Index f) {
    for (const Index v : surface.face(f)) visit(v, straight_distance(surface, point, v));
  });
}

}  // namespace gelight::detail
