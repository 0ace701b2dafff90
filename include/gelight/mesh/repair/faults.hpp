#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

// What check finds and repair mends, on the vertices and faces of any mesh. (Templates where that
// keeps them from being compiled for who does not call them.)

namespace gelight::detail {

/// One side of a face, under the edge's two vertices in ascending order.
struct FaceSide {
  Index low, high, face;
  bool ascends;  // the face runs it from low to high

  [[nodiscard]] bool same_edge(const FaceSide& other) const {
    return low == other.low && high == other.high;
  }
};

[[nodiscard]] inline Array<FaceSide> sorted_sides(const auto& faces, const Array<char>& is_usable) {
  Array<FaceSide> sides;
  sides.reserve(3 * faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!is_usable.data()[f]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = faces[f][k], b = faces[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(f), a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const FaceSide& a, const FaceSide& b) {
    return std::array{a.low, a.high, a.face} < std::array{b.low, b.high, b.face};
  });
  return sides;
}

/// Calls `visit(first, last)` for the sides of each edge.
inline void for_each_edge(const Array<FaceSide>& sides, auto&& visit) {
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last =
        std::find_if(first, sides.end(), [&](const FaceSide& s) { return !s.same_edge(*first); });
    visit(first, last);
    first = last;
  }
}

/// Sets that grow together; each is named by its least member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  [[nodiscard]] Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index a, Index b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  Array<Index> parent_;
};

/// The fan of each corner 3 f + k: corners at one vertex whose faces meet in an edge of two faces.
[[nodiscard]] inline DisjointSets fans(const auto& faces, const Array<FaceSide>& sides) {
  DisjointSets sets(3 * faces.size());
  const auto corner = [&](Index f, Index v) {
    const auto& face = faces[static_cast<std::size_t>(f)];
    return 3 * f + static_cast<Index>(std::find(face.begin(), face.end(), v) - face.begin());
  };
  for_each_edge(sides, [&](auto first, auto last) {
    if (last - first != 2) return;
    for (const Index v : {first->low, first->high}) {
      sets.join(corner(first->face, v), corner((first + 1)->face, v));
    }
  });
  return sets;
}

template <std::floating_point T>
[[nodiscard]] bool all_finite(const std::array<T, 3>& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// Whether Surface takes a position: false for what is not finite, too.
template <std::floating_point T>
[[nodiscard]] bool is_in_reach(const std::array<T, 3>& p) {
  return std::all_of(p.begin(), p.end(), [](T x) { return std::abs(x) <= largest_coordinate; });
}

template <std::floating_point T>
[[nodiscard]] Vec3<double> difference(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  const auto part = [&](std::size_t k) {
    return static_cast<double>(a[k]) - static_cast<double>(b[k]);
  };
  return {part(0), part(1), part(2)};
}

/// How long an edge is, as Surface measures it.
template <std::floating_point T>
[[nodiscard]] double edge_length(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return stable_norm(difference(a, b));
}

/// Whether Surface takes a face's edges: lengths that T holds. All that are finite in double.
template <std::floating_point T>
[[nodiscard]] bool has_edges_in_reach(const std::array<T, 3>& a, const std::array<T, 3>& b,
                                      const std::array<T, 3>& c) {
  return std::max({edge_length(a, b), edge_length(b, c), edge_length(c, a)}) <= largest_number<T>;
}

/// Whether a triangle's height is at most a share of its longest edge; not where one is infinite or
/// NaN.
template <std::floating_point T>
[[nodiscard]] bool is_flat(const std::array<T, 3>& a, const std::array<T, 3>& b,
                           const std::array<T, 3>& c, double share) {
  if (!all_finite(a) || !all_finite(b) || !all_finite(c)) return false;
  // Sorted, so that rounding is the same once a face is turned.
  std::array<std::array<T, 3>, 3> p{a, b, c};
  std::sort(p.begin(), p.end());
  const std::array<Vec3<double>, 3> edges{difference(p[1], p[0]), difference(p[2], p[1]),
                                          difference(p[0], p[2])};
  const double longest =
      std::max({stable_norm(edges[0]), stable_norm(edges[1]), stable_norm(edges[2])});
  if (!(longest > 0)) return true;
  const auto unit = [&](const Vec3<double>& edge) {
    return Vec3<double>(edge[0] / longest, edge[1] / longest, edge[2] / longest);
  };
  return stable_norm(cross<double>(unit(edges[0]), unit(edges[1]))) <= share;
}

/// What Surface refuses in a face, if anything.
enum class FaceFault { none, out_of_range, repeated_vertex };

[[nodiscard]] inline FaceFault fault_of(const std::array<Index, 3>& face, std::size_t vertices) {
  for (const Index v : face) {
    if (v < 0 || static_cast<std::size_t>(v) >= vertices) return FaceFault::out_of_range;
  }
  const bool repeats = face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
  return repeats ? FaceFault::repeated_vertex : FaceFault::none;
}

/// Faces, ascending, with the same three vertices as an earlier one among the usable.
[[nodiscard]] inline Array<Index> repeated_faces(const auto& faces, const Array<char>& is_usable) {
  using Face = typename std::remove_cvref_t<decltype(faces)>::value_type;
  Array<std::pair<Face, Index>> keys;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!is_usable.data()[f]) continue;
    auto key = faces[f];
    std::sort(key.begin(), key.end());
    keys.emplace_back(key, static_cast<Index>(f));
  }
  std::sort(keys.begin(), keys.end());
  Array<Index> repeated;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys.data()[i].first == keys.data()[i - 1].first) {
      repeated.push_back(keys.data()[i].second);
    }
  }
  std::sort(repeated.begin(), repeated.end());
  return repeated;
}

/// For each vertex the first one at most `distance` away that stands for itself, or the vertex.
/// Those that stand for themselves lie further apart. Vertices that are not finite keep to
/// themselves. About linear: vertices are looked up in cells of that size.
template <std::floating_point T>
[[nodiscard]] Array<Index> nearest_earlier(const std::vector<std::array<T, 3>>& positions,
                                           double distance) {
  using Cell = std::array<double, 3>;
  const auto hash = [](const Cell& cell) {
    std::size_t sum = 0;
    for (const double x : cell) sum = sum * 0x9E3779B97F4A7C15u + std::hash<double>()(x);
    return sum;
  };
  const auto cell_of = [&](const std::array<T, 3>& p) {
    Cell cell{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
    for (double& x : cell) {
      // So far out the next number is farther away: what is near is at the same place.
      const bool is_alone = !(std::fabs(x) / distance < 0x1p54);
      x = is_alone ? x + 0.0 : std::floor(x / distance);  // -0 is 0
    }
    return cell;
  };
  std::unordered_map<Cell, Index, decltype(hash)> last_in(positions.size(), hash);
  Array<Index> before(positions.size(), -1);  // the one before in the same cell
  Array<Index> nearest(positions.size());
  const double reach = distance > 0 ? 1 : 0;
  const auto count = static_cast<Index>(positions.size());
  for (Index v = 0; v < count; ++v) {
    const auto& p = positions[static_cast<std::size_t>(v)];
    nearest[v] = v;
    if (!all_finite(p)) continue;
    const Cell home = cell_of(p);
    const auto look_into = [&](const Cell& cell) {
      const auto entry = last_in.find(cell);
      for (Index w = entry == last_in.end() ? -1 : entry->second; w >= 0; w = before[w]) {
        const auto gap = difference(p, positions[static_cast<std::size_t>(w)]);
        if (stable_norm(gap) <= distance) nearest[v] = std::min(nearest[v], w);
      }
    };
    for (double x = -reach; x <= reach; ++x) {
      for (double y = -reach; y <= reach; ++y) {
        for (double z = -reach; z <= reach; ++z) {
          look_into({home[0] + x, home[1] + y, home[2] + z});
        }
      }
    }
    if (nearest[v] != v) continue;
    const auto [entry, is_new] = last_in.try_emplace(home, v);
    if (!is_new) before[v] = std::exchange(entry->second, v);
  }
  return nearest;
}

}  // namespace gelight::detail
