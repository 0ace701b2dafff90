#pragma once

#include <array>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Goes round the vertices of a surface, fan by fan, whatever way the faces run.
class OneRing {
 public:
  explicit OneRing(const Surface<double>& surface)
      : surface_(surface),
        is_visited_(static_cast<std::size_t>(surface.halfedge_count()), 0),
        ends_fans_(static_cast<std::size_t>(surface.vertex_count()), 0) {
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      if (!goes_on(h)) ends_fans_[surface.origin(h)] = ends_fans_[surface.tip(h)] = 1;
    }
  }

  /// Calls `visit(edge, corner)` for each edge at a vertex, in order: `edge` is a half-edge on it,
  /// `corner` the half-edge that starts at the vertex in the face between this edge and the one
  /// before, -1 at the first of a fan. A fan that closes ends with its first edge once more.
  void visit(Index vertex, auto&& visit) {
    for (const Index corner : surface_.corners(vertex)) {
      if (!ends_fans_[vertex]) break;
      for (const Index side : {corner, surface_.previous(corner)}) {
        if (!is_visited_[corner] && !goes_on(side)) walk(vertex, corner, side, visit);
      }
    }
    for (const Index corner : surface_.corners(vertex)) {
      if (!is_visited_[corner]) walk(vertex, corner, corner, visit);
    }
  }

 private:
  [[nodiscard]] bool goes_on(Index edge) const {
    return !surface_.is_border(edge) && surface_.is_manifold(edge);
  }

  void walk(Index vertex, Index corner, Index side, auto&& visit) {
    visit(side, Index{-1});
    while (!is_visited_[corner]) {
      is_visited_[corner] = 1;
      side = side == corner ? surface_.previous(corner) : corner;
      visit(side, corner);
      if (ends_fans_[vertex] && !goes_on(side)) return;
      side = surface_.twin(side);
      corner = surface_.origin(side) == vertex ? side : surface_.next(side);
    }
  }

  const Surface<double>& surface_;
  Array<char> is_visited_;  // of each half-edge: the corner it starts
  Array<char> ends_fans_;   // of each vertex: whether fans begin and end at an edge of it
};

}  // namespace gelight::detail
