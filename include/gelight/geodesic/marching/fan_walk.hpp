#pragma once

#include <array>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Goes round the vertices of a mesh, fan by fan, as OneRing does, in the same order, but finds by
/// itself which faces share an edge: in 8 bytes a vertex.
class FanWalk {
 public:
  explicit FanWalk(Index vertex_count) : latest_(static_cast<std::size_t>(vertex_count)) {}

  /// Calls `visit(end, corner)` for each edge at a vertex, in order: `end` is the vertex at its
  /// other end, `corner` the half-edge that starts at the vertex in the face between this edge and
  /// the one before, -1 at the first of a fan. A fan that closes ends with its first edge once
  /// more. The half-edges from the vertex are given. False where two faces have the same three
  /// vertices, but for edges of three faces and more: those `are_crowded` then.
  template <class Mesh>
  [[nodiscard]] bool visit(const Mesh& mesh, Index vertex, Slice<const Index> halfedges,
                           auto&& visit) {
    link(mesh, vertex, halfedges);
    const auto count = static_cast<Index>(halfedges.size());
    const Side* const sides = sides_.data();
    Corner* const corners = corners_.data();
    const auto walk = [&](Index corner, Index side) {
      visit(sides[side].end, Index{-1});
      while (!corners[corner].is_visited) {
        corners[corner].is_visited = true;
        const Index before = side;
        side = corners[corner].across(side);
        visit(sides[side].end, halfedges[corner]);
        if (!sides[side].goes_on()) return true;
        corner = sides[side].across(corner);
        if (corners[corner].across(side) == before) return false;
      }
      return true;
    };
    for (Index c = 0; ends_fans_ && c < count; ++c) {
      for (const Index side : corners[c].sides) {
        if (!corners[c].is_visited && !sides[side].goes_on() && !walk(c, side)) return false;
      }
    }
    for (Index c = 0; c < count; ++c) {
      if (!corners[c].is_visited && !walk(c, corners[c].sides[0])) return false;
    }
    return true;
  }

  /// Whether an edge of the vertex visited last is in three faces or more.
  [[nodiscard]] bool are_crowded() const { return are_crowded_; }

 private:
  // The side of a vertex that was found last to end at another.
  struct Latest {
    Index vertex = -1, side = -1;
  };
  // An edge at the vertex: its other end, and the first two of its corners, of `count`.
  struct Side {
    Index end;
    std::array<Index, 2> corners;
    Index count;
    [[nodiscard]] bool goes_on() const { return count == 2; }
    [[nodiscard]] Index across(Index corner) const { return corners[0] ^ corners[1] ^ corner; }
  };
  // A face at the vertex: towards the tip of its half-edge, and towards the vertex before.
  struct Corner {
    std::array<Index, 2> sides;
    bool is_visited;
    [[nodiscard]] Index across(Index side) const { return sides[0] ^ sides[1] ^ side; }
  };

  template <class Mesh>
  void link(const Mesh& mesh, Index vertex, Slice<const Index> halfedges) {
    const auto count = static_cast<Index>(halfedges.size());
    if (corners_.size() < halfedges.size()) {
      corners_.resize(2 * halfedges.size());
      sides_.resize(2 * corners_.size());
    }
    Latest* const latest_at = latest_.data();
    Side* const sides = sides_.data();
    Index side_count = 0, inner = 0, crowded = 0;
    const auto join = [&](Index end, Index corner) {
      Latest& latest = latest_at[end];
      if (latest.vertex != vertex) {
        latest = {vertex, side_count};
        sides[side_count] = {end, {corner, -1}, 1};
        return side_count++;
      }
      Side& side = sides[latest.side];
      side.corners[1] = corner;
      ++side.count;
      inner += side.count == 2;
      crowded += side.count > 2;
      return latest.side;
    };
    for (Index c = 0; c < count; ++c) {
      const Index h = halfedges[c], to_tip = join(mesh.tip(h), c);
      corners_[c] = {{to_tip, join(mesh.apex(h), c)}, false};
    }
    are_crowded_ = crowded > 0;
    ends_fans_ = are_crowded_ || inner < side_count;
  }

  Array<Latest> latest_;    // of each vertex
  Array<Corner> corners_;   // of the vertex in turn: as many as it has faces
  Array<Side> sides_;       // and its edges
  bool ends_fans_ = false;  // whether fans begin and end at an edge of it
  bool are_crowded_ = false;
};

}  // namespace gelight::detail
