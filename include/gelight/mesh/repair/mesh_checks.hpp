#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair/faults.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::detail {

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

}  // namespace gelight::detail
