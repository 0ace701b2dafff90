#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <ostream>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/repair/faults.hpp"
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
  Finding too_far;            ///< vertices with a coordinate beyond 1e75
  bool is_too_small = false;  ///< whether no edge is as long as 1e-75, though some have length
  Finding out_of_range;       ///< faces with an index that is no vertex
  Finding repeated_vertices;  ///< faces with a vertex twice
  Finding repeated_faces;     ///< faces with the three vertices of an earlier one
  Finding too_long;           ///< faces with an edge longer than the coordinates' type holds

  // Refused where vectors are carried, by name; distances take them.
  Finding nonmanifold_edges;  ///< first vertices of edges with more than two faces
  Finding misoriented_edges;  ///< first vertices of edges whose two faces are oriented against each
                              ///< other

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
    return vertices > 0 && faces > 0 && not_finite.count == 0 && too_far.count == 0 &&
           !is_too_small && out_of_range.count == 0 && repeated_vertices.count == 0 &&
           repeated_faces.count == 0 && too_long.count == 0;
  }
  /// Whether VectorHeatSolver takes it too.
  [[nodiscard]] bool is_oriented() const {
    return is_accepted() && nonmanifold_edges.count == 0 && misoriented_edges.count == 0;
  }
};

namespace detail {

/// The checks of one mesh, one after the other, into a report.
template <std::floating_point T>
class MeshChecks {
 public:
  MeshChecks(const Mesh<T>& mesh, const CheckOptions& options) : mesh_(mesh), options_(options) {
    report_.vertices = static_cast<Index>(mesh.positions.size());
    report_.faces = static_cast<Index>(mesh.faces.size());
  }

  [[nodiscard]] MeshReport run(const CancelHook& cancelled) {
    const char* const what = "the check of the mesh";
    cancelled.check(0, what);
    look_at_faces();
    cancelled.check(0.2, what);
    look_at_vertices();
    cancelled.check(0.4, what);
    const auto sides = sorted_sides(mesh_.faces, is_usable_);
    cancelled.check(0.6, what);
    look_at_edges(sides);
    cancelled.check(0.8, what);
    look_at_fans(sides);
    cancelled.check(1, what);
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
      if (is_finite && !has_edges_in_reach(position(a), position(b), position(c))) {
        add(report_.too_long, f);
      }
      if (is_finite && is_flat(position(a), position(b), position(c), options_.flat)) {
        add(report_.degenerate_faces, f);
      }
    }
  }

  void look_at_vertices() {
    const auto nearest = nearest_earlier(mesh_.positions, 0);
    for (Index v = 0; v < report_.vertices; ++v) {
      if (!all_finite(position(v))) {
        add(report_.not_finite, v);
      } else if (!is_in_reach(position(v))) {
        add(report_.too_far, v);
      }
      if (nearest[v] != v) add(report_.duplicate_vertices, v);
    }
  }

  void look_at_edges(const Array<FaceSide>& sides) {
    double longest = 0;
    for_each_edge(sides, [&](auto first, auto last) {
      const Index v = first->low;
      if (last - first == 1) add(report_.border_edges, v);
      if (last - first > 2) add(report_.nonmanifold_edges, v);
      if (last - first == 2 && first->ascends == (first + 1)->ascends)
        add(report_.misoriented_edges, v);
      const double length = stable_norm(difference(position(v), position(first->high)));
      if (length < shortest_length) add(report_.zero_edges, v);
      if (length > longest) longest = length;
    });
    report_.is_too_small = longest > 0 && longest < shortest_length;
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
/// Faces that Surface refuses are left out of what concerns edges, fans and components. The hook is
/// asked between the steps. Cost: O(vertices + faces log faces).
template <TriangleMesh M>
[[nodiscard]] MeshReport check(const M& mesh, const CheckOptions& options = {},
                               const CancelHook& cancelled = {}) {
  const auto copy = detail::copied(mesh);
  return detail::MeshChecks(copy, options).run(cancelled);
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
  line(report.too_far, "vertices farther out than 1e75", "refused");
  if (report.is_too_small) out << "\nno edge is as long as 1e-75 (refused)";
  line(report.out_of_range, "faces with an index out of range", "refused");
  line(report.repeated_vertices, "faces with a vertex twice", "refused");
  line(report.repeated_faces, "faces with the vertices of an earlier one", "refused");
  line(report.too_long, "faces with an edge too long for the coordinates' type", "refused");
  line(report.nonmanifold_edges, "edges of more than two faces, at vertices",
       "refused for vectors");
  line(report.misoriented_edges, "edges between faces oriented against each other, at vertices",
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

}  // namespace gelight
