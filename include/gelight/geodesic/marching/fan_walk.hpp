#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// What a face is to one of its vertices: the edge across, from the tip of the half-edge that
/// starts at the vertex to the face's third vertex.
struct Rim {
  Index tip, apex;
};

/// Goes round the vertices of a mesh, fan by fan, as OneRing does, in the same order, but finds by
/// itself which faces share an edge: in 8 bytes a vertex.
class FanWalk {
 public:
  explicit FanWalk(Index vertex_count) : latest_(static_cast<std::size_t>(vertex_count)) {}

  /// An edge of a vertex: the vertex at its other end, and the number of the face between this edge
  /// and the one before among those of the vertex; -1 at the first edge of a fan.
  struct Step {
    Index end, corner;
  };

  /// Goes round a vertex, whose rims are given. False where two faces have the same three vertices,
  /// but for edges of three faces and more: those `are_crowded` then.
  [[nodiscard, gnu::always_inline]] bool visit(Index vertex, Slice<const Rim> rims) {
    step_count_ = 0;
    if (steps_.size() < 2 * rims.size()) steps_.resize(4 * rims.size());
    if (!follow(vertex, rims)) return walk_fans(vertex, rims);
    are_crowded_ = false;
    return true;
  }

  /// The edges of the vertex visited last, in order. A fan that closes ends with its first edge
  /// once more.
  [[nodiscard]] Slice<const Step> steps() const { return {steps_.data(), step_count_}; }

  /// Whether an edge of that vertex is in three faces or more.
  [[nodiscard]] bool are_crowded() const { return are_crowded_; }

 private:
  // The corner or the side of a vertex that was found last to begin or end at another.
  struct Latest {
    Index stamp = std::numeric_limits<Index>::min(), at = -1;
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

  // Where each face ends where the next begins, in one fan that closes, as at most vertices.
  [[nodiscard, gnu::always_inline]] bool follow(Index vertex, Slice<const Rim> rims) {
    const auto count = static_cast<Index>(rims.size());
    if (count < 3) return false;
    Latest* const latest_at = latest_.data();
    Step* const steps = steps_.data();
    for (Index c = 0; c < count; ++c) latest_at[rims[c].tip] = {vertex, c};
    steps[0] = {rims[0].tip, -1};
    Index corner = 0, followed = 0;
    do {
      const Index end = rims[corner].apex;
      steps[++followed] = {end, corner};
      const Latest& next = latest_at[end];
      if (next.stamp != vertex) return false;
      corner = next.at;
    } while (corner != 0 && followed < count);
    step_count_ = static_cast<std::size_t>(count) + 1;
    return corner == 0 && followed == count;
  }

  // The same for fans of any kind.
  [[nodiscard, gnu::noinline]] bool walk_fans(Index vertex, Slice<const Rim> rims) {
    link(vertex, rims);
    step_count_ = 0;
    const auto count = static_cast<Index>(rims.size());
    const Side* const sides = sides_.data();
    Corner* const corners = corners_.data();
    const auto walk = [&](Index corner, Index side) {
      steps_[step_count_++] = {sides[side].end, -1};
      while (!corners[corner].is_visited) {
        corners[corner].is_visited = true;
        const Index before = side;
        side = corners[corner].across(side);
        steps_[step_count_++] = {sides[side].end, corner};
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

  void link(Index vertex, Slice<const Rim> rims) {
    const auto count = static_cast<Index>(rims.size());
    if (corners_.size() < rims.size()) {
      corners_.resize(2 * rims.size());
      sides_.resize(2 * corners_.size());
    }
    Latest* const latest_at = latest_.data();
    Side* const sides = sides_.data();
    const Index stamp = ~vertex;  // another than that of `follow`
    Index side_count = 0, inner = 0, crowded = 0;
    const auto join = [&](Index end, Index corner) {
      Latest& latest = latest_at[end];
      if (latest.stamp != stamp) {
        latest = {stamp, side_count};
        sides[side_count] = {end, {corner, -1}, 1};
        return side_count++;
      }
      Side& side = sides[latest.at];
      side.corners[1] = corner;
      ++side.count;
      inner += side.count == 2;
      crowded += side.count > 2;
      return latest.at;
    };
    for (Index c = 0; c < count; ++c) {
      const Index to_tip = join(rims[c].tip, c);
      corners_[c] = {{to_tip, join(rims[c].apex, c)}, false};
    }
    are_crowded_ = crowded > 0;
    ends_fans_ = are_crowded_ || inner < side_count;
  }

  Array<Latest> latest_;  // of each vertex
  Array<Step> steps_;     // round the vertex in turn, the first so many
  std::size_t step_count_ = 0;
  Array<Corner> corners_;   // of the vertex in turn: as many as it has faces
  Array<Side> sides_;       // and its edges
  bool ends_fans_ = false;  // whether fans begin and end at an edge of it
  bool are_crowded_ = false;
};

}  // namespace gelight::detail
