#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <ostream>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// How many there are of something, and the first of them in ascending order.
struct Finding {
  Index count = 0;             ///< how many
  std::vector<Index> first{};  ///< as many as CheckOptions list
};

struct CheckOptions {
  /// How many indices a Finding names at most.
  Index listed = 8;
  /// A face counts as degenerate if its height is at most this share of its longest edge.
  double flat = 1e-12;
};

/// What is unusual about a mesh. Made by `check`.
struct MeshReport {
  Index vertices = 0;  ///< how many the mesh has
  Index faces = 0;     ///< how many the mesh has

  // Refused by Surface, and so by every solver.
  Finding not_finite;         ///< vertices with a coordinate that is not finite
  Finding out_of_range;       ///< faces with an index that is no vertex
  Finding repeated_vertices;  ///< faces with a vertex twice
  Finding repeated_faces;     ///< faces with the three vertices of an earlier one

  // Refused where vectors are carried, by name; distances take them.
  Finding fins;     ///< first vertices of edges with more than two faces
  Finding against;  ///< first vertices of edges whose two faces are oriented against each other

  // Taken by every solver, but perhaps not what was meant.
  Finding degenerate_faces;      ///< faces of (almost) no area, also with edges of no length
  Finding zero_edges;            ///< first vertices of edges of no length
  Finding duplicate_vertices;    ///< vertices at the position of an earlier one: a seam, uncrossed
  Finding unused_vertices;       ///< vertices in no face: infinitely far
  Finding nonmanifold_vertices;  ///< vertices whose faces form more than one fan
  Finding border_edges;          ///< first vertices of edges with one face
  Index components = 0;          ///< parts with no path between them, unused vertices not counted

  /// Whether a Surface, and so every distance solver, can be made of it.
  [[nodiscard]] bool is_accepted() const {
    return vertices > 0 && faces > 0 && not_finite.count == 0 && out_of_range.count == 0 &&
           repeated_vertices.count == 0 && repeated_faces.count == 0;
  }
  /// Whether VectorHeatSolver takes it too.
  [[nodiscard]] bool is_oriented() const {
    return is_accepted() && fins.count == 0 && against.count == 0;
  }
};

namespace detail {

/// One side of a face, under the edge's two vertices in ascending order.
struct FaceSide {
  Index low, high, face;
  bool ascends;  // the face runs it from low to high

  [[nodiscard]] bool same_edge(const FaceSide& other) const {
    return low == other.low && high == other.high;
  }
};

[[nodiscard]] inline Array<FaceSide> sorted_sides(const std::vector<std::array<Index, 3>>& faces,
                                                  const Array<char>& is_usable) {
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
[[nodiscard]] inline DisjointSets fans(const std::vector<std::array<Index, 3>>& faces,
                                       const Array<FaceSide>& sides) {
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

template <std::floating_point T>
[[nodiscard]] Vec3<double> difference(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return {double{a[0]} - double{b[0]}, double{a[1]} - double{b[1]}, double{a[2]} - double{b[2]}};
}

/// Whether a triangle's height is at most a share of its longest edge.
template <std::floating_point T>
[[nodiscard]] bool is_flat(const std::array<T, 3>& a, const std::array<T, 3>& b,
                           const std::array<T, 3>& c, double share) {
  const std::array<Vec3<double>, 3> edges{difference(b, a), difference(c, b), difference(a, c)};
  const double longest = std::max({detail::stable_norm(edges[0]), detail::stable_norm(edges[1]),
                                   detail::stable_norm(edges[2])});
  if (!(longest > 0)) return true;
  return cross<double>(edges[0] / longest, edges[1] / longest).norm() <= share;
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
[[nodiscard]] inline Array<Index> repeated_faces(const std::vector<std::array<Index, 3>>& faces,
                                                 const Array<char>& is_usable) {
  Array<std::pair<std::array<Index, 3>, Index>> keys;
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
    Cell cell{double{p[0]}, double{p[1]}, double{p[2]}};
    for (double& x : cell) x = distance > 0 ? std::floor(x / distance) : x + 0.0;  // -0 is 0
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
        if (detail::stable_norm(gap) <= distance) nearest[v] = std::min(nearest[v], w);
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

/// The checks of one mesh, one after the other, into a report.
template <std::floating_point T>
class MeshChecks {
 public:
  MeshChecks(const Mesh<T>& mesh, const CheckOptions& options) : mesh_(mesh), options_(options) {
    report_.vertices = static_cast<Index>(mesh.positions.size());
    report_.faces = static_cast<Index>(mesh.faces.size());
  }

  [[nodiscard]] MeshReport run() {
    look_at_faces();
    look_at_vertices();
    const auto sides = sorted_sides(mesh_.faces, is_usable_);
    look_at_edges(sides);
    look_at_fans(sides);
    return std::move(report_);
  }

 private:
  [[nodiscard]] const std::array<T, 3>& position(Index v) const { return mesh_.position(v); }

  void add(Finding& finding, Index index) const {
    ++finding.count;
    if (std::ssize(finding.first) < options_.listed) finding.first.push_back(index);
  }

  void look_at_faces() {
    is_usable_.assign(mesh_.faces.size(), 1);
    for (Index f = 0; f < report_.faces; ++f) {
      const auto fault = fault_of(mesh_.face(f), mesh_.positions.size());
      if (fault == FaceFault::out_of_range) add(report_.out_of_range, f);
      if (fault == FaceFault::repeated_vertex) add(report_.repeated_vertices, f);
      is_usable_[f] = fault == FaceFault::none;
    }
    for (const Index f : repeated_faces(mesh_.faces, is_usable_)) {
      add(report_.repeated_faces, f);
      is_usable_[f] = 0;
    }
    for (Index f = 0; f < report_.faces; ++f) {
      if (!is_usable_[f]) continue;
      const auto [a, b, c] = mesh_.face(f);
      const bool is_finite =
          all_finite(position(a)) && all_finite(position(b)) && all_finite(position(c));
      if (is_finite && is_flat(position(a), position(b), position(c), options_.flat)) {
        add(report_.degenerate_faces, f);
      }
    }
  }

  void look_at_vertices() {
    const auto nearest = nearest_earlier(mesh_.positions, 0);
    for (Index v = 0; v < report_.vertices; ++v) {
      if (!all_finite(position(v))) add(report_.not_finite, v);
      if (nearest[v] != v) add(report_.duplicate_vertices, v);
    }
  }

  void look_at_edges(const Array<FaceSide>& sides) {
    for_each_edge(sides, [&](auto first, auto last) {
      const Index v = first->low;
      if (last - first == 1) add(report_.border_edges, v);
      if (last - first > 2) add(report_.fins, v);
      if (last - first == 2 && first->ascends == (first + 1)->ascends) add(report_.against, v);
      if (position(v) == position(first->high)) add(report_.zero_edges, v);
    });
  }

  void look_at_fans(const Array<FaceSide>& sides) {
    auto fan = fans(mesh_.faces, sides);
    DisjointSets parts(mesh_.positions.size());
    Array<Index> fan_of(mesh_.positions.size(), -1);
    Array<char> has_several(mesh_.positions.size(), 0);
    for (Index f = 0; f < report_.faces; ++f) {
      if (!is_usable_[f]) continue;
      const auto& face = mesh_.face(f);
      for (Index k = 0; k < 3; ++k) {
        const Index v = face[static_cast<std::size_t>(k)], own = fan.find(3 * f + k);
        if (fan_of[v] >= 0 && fan_of[v] != own) has_several[v] = 1;
        fan_of[v] = own;
        parts.join(face[0], v);
      }
    }
    for (Index v = 0; v < report_.vertices; ++v) {
      if (fan_of[v] < 0) add(report_.unused_vertices, v);
      if (has_several[v]) add(report_.nonmanifold_vertices, v);
      if (fan_of[v] >= 0 && parts.find(v) == v) ++report_.components;
    }
  }

  const Mesh<T>& mesh_;
  CheckOptions options_;
  MeshReport report_;
  Array<char> is_usable_;  // of each face: has three vertices, and is the first that has them
};

}  // namespace detail

/// Tells everything about a mesh that a solver refuses or that may not be what was meant, in one
/// pass, with counts and the first indices; changes nothing and takes any mesh.
///
/// Faces that Surface refuses are left out of what concerns edges, fans and components. Cost:
/// O(vertices + faces log faces).
template <TriangleMesh M>
[[nodiscard]] MeshReport check(const M& mesh, const CheckOptions& options = {}) {
  const auto copy = detail::copied(mesh);
  return detail::MeshChecks(copy, options).run();
}

/// One line for each finding, such as "2 faces with a vertex twice: 4, 9 (refused)".
inline std::ostream& operator<<(std::ostream& out, const MeshReport& report) {
  const auto line = [&](const Finding& finding, const char* what, const char* then) {
    if (finding.count == 0) return;
    out << '\n' << finding.count << ' ' << what << ": ";
    for (std::size_t i = 0; i < finding.first.size(); ++i) {
      out << (i > 0 ? ", " : "") << finding.first[i];
    }
    out << (std::ssize(finding.first) < finding.count ? ", ..." : "") << " (" << then << ')';
  };
  out << report.vertices << " vertices, " << report.faces << " faces, " << report.components
      << " components";
  line(report.not_finite, "vertices that are not finite", "refused");
  line(report.out_of_range, "faces with an index out of range", "refused");
  line(report.repeated_vertices, "faces with a vertex twice", "refused");
  line(report.repeated_faces, "faces with the vertices of an earlier one", "refused");
  line(report.fins, "edges of more than two faces, at vertices", "refused for vectors");
  line(report.against, "edges between faces oriented against each other, at vertices",
       "refused for vectors");
  line(report.degenerate_faces, "faces without area", "taken");
  line(report.zero_edges, "edges without length, at vertices", "taken");
  line(report.duplicate_vertices, "vertices at the place of an earlier one",
       "taken; no path crosses such a seam");
  line(report.unused_vertices, "vertices in no face", "taken; infinitely far");
  line(report.nonmanifold_vertices, "vertices of several fans", "taken; paths pass through");
  line(report.border_edges, "border edges, at vertices", "taken");
  return out;
}

/// What `repair` does; by default nothing.
struct RepairOptions {
  /// Drops faces that Surface refuses: with an index out of range, a vertex that is not finite or
  /// twice, or the three vertices of an earlier face.
  bool drop_unusable_faces = false;
  /// Where given, each vertex at most this far from an earlier one becomes that one, in the unit of
  /// the positions (0: only vertices at the same place). Faces that collapse or become equal by
  /// this are dropped.
  std::optional<double> weld_distance{};
  /// Drops faces whose height is at most `flat` times their longest edge. The area stays, but where
  /// such a face was all that joined two others, they part.
  bool drop_degenerate_faces = false;
  double flat = 1e-12;  ///< see drop_degenerate_faces
  /// Turns faces so that those that meet in an edge of two faces agree with the first of their part
  /// wherever the surface has an orientation.
  bool orient = false;
  /// Gives each fan of a vertex its own copy, so that paths no longer pass through the vertex.
  /// Edges of more than two faces part too, unless their faces join again around both ends.
  bool split_vertices = false;
  /// Drops vertices in no face, also those that are not finite.
  bool drop_unused_vertices = false;
};

/// A repaired mesh, and what was done to it.
template <std::floating_point T>
struct Repaired {
  Mesh<T> mesh;                    ///< as repaired
  Index welded_vertices = 0;       ///< vertices that became an earlier one
  Index dropped_faces = 0;         ///< unusable, equal, collapsed or degenerate
  Index turned_faces = 0;          ///< to agree with their neighbours
  Index added_vertices = 0;        ///< copies made by splitting
  Index dropped_vertices = 0;      ///< in no face
  std::vector<Index> vertex_of{};  ///< of each vertex of `mesh`: which it was
  std::vector<Index> face_of{};    ///< of each face of `mesh`: which it was
};

namespace detail {

/// The repairs of one mesh, one after the other.
template <std::floating_point T>
class MeshRepairs {
 public:
  explicit MeshRepairs(Mesh<T> mesh) {
    result_.vertex_of.resize(mesh.positions.size());
    result_.face_of.resize(mesh.faces.size());
    std::iota(result_.vertex_of.begin(), result_.vertex_of.end(), 0);
    std::iota(result_.face_of.begin(), result_.face_of.end(), 0);
    result_.mesh = std::move(mesh);
  }

  [[nodiscard]] Repaired<T> run(const RepairOptions& options) {
    if (options.drop_unusable_faces) drop_unusable();
    if (options.weld_distance) weld(*options.weld_distance);
    if (options.drop_degenerate_faces) drop_degenerate(options.flat);
    if (options.orient) orient();
    if (options.split_vertices) split();
    if (options.drop_unused_vertices) drop_unused();
    return std::move(result_);
  }

 private:
  [[nodiscard]] Index face_count() const { return static_cast<Index>(mesh().faces.size()); }
  [[nodiscard]] const Mesh<T>& mesh() const { return result_.mesh; }
  [[nodiscard]] std::array<Index, 3>& face(Index f) {
    return result_.mesh.faces[static_cast<std::size_t>(f)];
  }

  [[nodiscard]] Array<char> sound_faces() const {
    Array<char> is_sound(mesh().faces.size());
    for (Index f = 0; f < face_count(); ++f) {
      is_sound[f] = fault_of(mesh().face(f), mesh().positions.size()) == FaceFault::none;
    }
    return is_sound;
  }

  void keep(const Array<char>& is_kept) {
    std::size_t kept = 0;
    for (std::size_t f = 0; f < mesh().faces.size(); ++f) {
      if (!is_kept.data()[f]) continue;
      result_.mesh.faces[kept] = result_.mesh.faces[f];
      result_.face_of[kept++] = result_.face_of[f];
    }
    result_.dropped_faces += static_cast<Index>(mesh().faces.size() - kept);
    result_.mesh.faces.resize(kept);
    result_.face_of.resize(kept);
  }

  void drop_unusable() {
    auto is_kept = sound_faces();
    for (Index f = 0; f < face_count(); ++f) {
      if (!is_kept[f]) continue;
      for (const Index v : mesh().face(f)) is_kept[f] &= all_finite(mesh().position(v));
    }
    for (const Index f : repeated_faces(mesh().faces, is_kept)) is_kept[f] = 0;
    keep(is_kept);
  }

  // Faces that could not be used before stay as they are.
  void weld(double distance) {
    const auto before = sound_faces();
    const auto repeated_before = repeated_faces(mesh().faces, before);
    const auto nearest = nearest_earlier(mesh().positions, distance);
    for (Index v = 0; v < static_cast<Index>(mesh().positions.size()); ++v) {
      result_.welded_vertices += nearest[v] != v;
    }
    for (Index f = 0; f < face_count(); ++f) {
      if (!before[f]) continue;
      for (Index& v : face(f)) v = nearest[v];
    }
    const auto after = sound_faces();
    Array<char> is_kept(mesh().faces.size());
    for (Index f = 0; f < face_count(); ++f) is_kept[f] = !before[f] || after[f];
    for (const Index f : repeated_faces(mesh().faces, after)) {
      is_kept[f] = std::binary_search(repeated_before.begin(), repeated_before.end(), f);
    }
    keep(is_kept);
  }

  void drop_degenerate(double flat) {
    auto is_kept = sound_faces();
    for (Index f = 0; f < face_count(); ++f) {
      if (!is_kept[f]) {
        is_kept[f] = 1;
        continue;
      }
      const auto [a, b, c] = mesh().face(f);
      is_kept[f] = !is_flat(mesh().position(a), mesh().position(b), mesh().position(c), flat);
    }
    keep(is_kept);
  }

  void orient() {
    struct Neighbour {
      Index face, other;
      bool agrees;
    };
    Array<Neighbour> neighbours;
    for_each_edge(sorted_sides(mesh().faces, sound_faces()), [&](auto first, auto last) {
      if (last - first != 2) return;
      const auto& [a, b] = std::pair(*first, *(first + 1));
      neighbours.push_back({a.face, b.face, a.ascends != b.ascends});
      neighbours.push_back({b.face, a.face, a.ascends != b.ascends});
    });
    std::sort(neighbours.begin(), neighbours.end(),
              [](const Neighbour& a, const Neighbour& b) { return a.face < b.face; });
    enum : char { unseen, as_it_is, turned };
    Array<char> state(mesh().faces.size(), unseen);
    Array<Index> waiting;
    for (Index f = 0; f < face_count(); ++f) {
      if (state[f] != unseen) continue;
      state[f] = as_it_is;
      waiting.push_back(f);
      while (!waiting.empty()) {
        const Index g = waiting.back();
        waiting.pop_back();
        auto n = std::lower_bound(neighbours.begin(), neighbours.end(), g,
                                  [](const Neighbour& a, Index face) { return a.face < face; });
        for (; n != neighbours.end() && n->face == g; ++n) {
          if (state[n->other] != unseen) continue;
          state[n->other] = n->agrees == (state[g] == as_it_is) ? as_it_is : turned;
          waiting.push_back(n->other);
        }
      }
    }
    for (Index f = 0; f < face_count(); ++f) {
      if (state[f] != turned) continue;
      std::swap(face(f)[1], face(f)[2]);
      ++result_.turned_faces;
    }
  }

  void split() {
    const auto is_sound = sound_faces();
    auto fan = fans(mesh().faces, sorted_sides(mesh().faces, is_sound));
    Array<Index> owner(mesh().positions.size(), -1);     // of each vertex: the fan that keeps it
    Array<Index> copy_for(3 * mesh().faces.size(), -1);  // of each other fan: its copy
    for (Index f = 0; f < face_count(); ++f) {
      if (!is_sound[f]) continue;
      for (Index k = 0; k < 3; ++k) {
        Index& v = face(f)[static_cast<std::size_t>(k)];
        const Index own = fan.find(3 * f + k);
        if (owner[v] < 0) owner[v] = own;
        if (owner[v] == own) continue;
        if (copy_for[own] < 0) copy_for[own] = copy_of(v);
        v = copy_for[own];
      }
    }
  }

  [[nodiscard]] Index copy_of(Index v) {
    const auto at = static_cast<std::size_t>(v);
    result_.mesh.positions.push_back(result_.mesh.positions[at]);
    result_.vertex_of.push_back(result_.vertex_of[at]);
    ++result_.added_vertices;
    return static_cast<Index>(result_.mesh.positions.size()) - 1;
  }

  // An index out of range stays out of range.
  void drop_unused() {
    const auto count = static_cast<Index>(mesh().positions.size());
    const auto is_vertex = [&](Index v) { return v >= 0 && v < count; };
    Array<Index> now(mesh().positions.size(), -1);
    for (const auto& face : mesh().faces) {
      for (const Index v : face) {
        if (is_vertex(v)) now[v] = 0;
      }
    }
    std::size_t kept = 0;
    for (std::size_t v = 0; v < now.size(); ++v) {
      if (now.data()[v] < 0) continue;
      result_.mesh.positions[kept] = result_.mesh.positions[v];
      result_.vertex_of[kept] = result_.vertex_of[v];
      now.data()[v] = static_cast<Index>(kept++);
    }
    result_.dropped_vertices = count - static_cast<Index>(kept);
    result_.mesh.positions.resize(kept);
    result_.vertex_of.resize(kept);
    for (auto& face : result_.mesh.faces) {
      for (Index& v : face) v = is_vertex(v) ? now[v] : v;
    }
  }

  Repaired<T> result_;
};

}  // namespace detail

/// Copies a mesh and mends what the options name, in the order in which they stand there; tells
/// what it did. The mesh itself stays as it is, and nothing is mended that was not asked for.
///
/// Throws InvalidInput for a weld distance or a flatness that is negative or not finite. Cost:
/// O(vertices + faces log faces).
template <TriangleMesh M>
[[nodiscard]] Repaired<MeshScalar<M>> repair(const M& mesh, const RepairOptions& options) {
  const double weld = options.weld_distance.value_or(0);
  detail::require(weld >= 0 && std::isfinite(weld), "the weld distance is ", weld);
  detail::require(options.flat >= 0 && std::isfinite(options.flat), "the flatness is ",
                  options.flat);
  return detail::MeshRepairs(detail::copied(mesh)).run(options);
}

}  // namespace gelight
