#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/repair/faults.hpp"
#include "gelight/mesh/repair/space_order.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::detail {

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

  [[nodiscard]] Repaired<T> run(const RepairOptions& options, const CancelHook& cancelled) {
    const char* const what = "the repair of the mesh";
    cancelled.check(0, what);
    if (options.drop_unusable_faces) drop_unusable();
    cancelled.check(0.1, what);
    if (options.weld_distance) weld(*options.weld_distance);
    cancelled.check(0.4, what);
    if (options.drop_degenerate_faces) drop_degenerate(options.flat);
    cancelled.check(0.5, what);
    if (options.orient) orient();
    cancelled.check(0.7, what);
    // Welding takes copies back: made last, they are made alike when the result is repaired again.
    const bool is_split_last = options.weld_distance.has_value();
    if (options.split_vertices && !is_split_last) split();
    cancelled.check(0.9, what);
    if (options.drop_unused_vertices) drop_unused();
    cancelled.check(0.95, what);
    if (options.order_in_space) order_in_space();
    if (options.split_vertices && is_split_last) {
      const auto copied = split();
      if (options.order_in_space) put_beside(copied);
    }
    cancelled.check(1, what);
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
      const auto& [a, b, c] = mesh().face(f);
      const auto &p = mesh().position(a), &q = mesh().position(b), &r = mesh().position(c);
      is_kept[f] =
          is_in_reach(p) && is_in_reach(q) && is_in_reach(r) && has_edges_in_reach(p, q, r);
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

  // Faces that cannot be used stay as they are.
  void drop_degenerate(double flat) {
    const auto is_sound = sound_faces();
    Array<char> is_kept(mesh().faces.size(), 1);
    for (Index f = 0; f < face_count(); ++f) {
      if (!is_sound[f]) continue;
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
    const auto reach = [&](Index f, char as) {
      if (state[f] != unseen) return;
      state[f] = as;
      waiting.push_back(f);
    };
    // Faces that agree already are reached first: so where a surface has no orientation, what has
    // been turned once stays as it is the next time, whatever the order of the faces is then.
    Array<Neighbour> opposed;
    for (Index f = 0; f < face_count(); ++f) {
      reach(f, as_it_is);
      while (!waiting.empty()) {
        const Index g = waiting.back();
        waiting.pop_back();
        auto n = std::lower_bound(neighbours.begin(), neighbours.end(), g,
                                  [](const Neighbour& a, Index face) { return a.face < face; });
        for (; n != neighbours.end() && n->face == g; ++n) {
          if (n->agrees) reach(n->other, state[g]);
          if (!n->agrees) opposed.push_back(*n);
        }
        while (waiting.empty() && !opposed.empty()) {
          const Neighbour last = opposed.back();
          opposed.pop_back();
          reach(last.other, state[last.face] == turned ? as_it_is : turned);
        }
      }
    }
    for (Index f = 0; f < face_count(); ++f) {
      if (state[f] != turned) continue;
      std::swap(face(f)[1], face(f)[2]);
      ++result_.turned_faces;
    }
  }

  // Of each copy: of which vertex it is. An index out of range stays out of range.
  Array<Index> split() {
    const auto count = static_cast<Index>(mesh().positions.size());
    const auto is_sound = sound_faces();
    auto fan = fans(mesh().faces, sorted_sides(mesh().faces, is_sound));
    Array<Index> owner(mesh().positions.size(), -1);     // of each vertex: the fan that keeps it
    Array<Index> copy_for(3 * mesh().faces.size(), -1);  // of each other fan: its copy
    Array<Index> copied;
    for (Index f = 0; f < face_count(); ++f) {
      if (!is_sound[f]) continue;
      for (Index k = 0; k < 3; ++k) {
        Index& v = face(f)[static_cast<std::size_t>(k)];
        const Index own = fan.find(3 * f + k);
        if (owner[v] < 0) owner[v] = own;
        if (owner[v] == own) continue;
        if (copy_for[own] < 0) {
          copy_for[own] = copy_of(v);
          copied.push_back(v);
        }
        v = copy_for[own];
      }
    }
    for (Index f = 0; f < face_count(); ++f) {
      if (is_sound[f]) continue;
      for (Index& v : face(f)) v = v < count ? v : std::max(v, count + result_.added_vertices);
    }
    return copied;
  }

  // Numbers copies, which are behind all else, behind the vertices that they are of.
  void put_beside(const Array<Index>& copied) {
    const auto count = static_cast<Index>(mesh().positions.size() - copied.size());
    Array<std::pair<Index, Index>> keyed;
    for (Index v = 0; v < count; ++v) keyed.push_back({v, v});
    for (const Index v : copied) keyed.push_back({v, static_cast<Index>(keyed.size())});
    std::sort(keyed.begin(), keyed.end());
    Array<Index> vertices;
    for (const auto& [of, v] : keyed) vertices.push_back(v);
    number_vertices(vertices);
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

  void order_in_space() {
    number_vertices(space_order(mesh().positions));
    // Faces follow the first of their vertices.
    Array<std::pair<Index, Index>> first;
    for (Index f = 0; f < face_count(); ++f) {
      first.push_back({*std::min_element(face(f).begin(), face(f).end()), f});
    }
    std::sort(first.begin(), first.end());
    Array<Index> faces;
    for (const auto& [vertex, f] : first) faces.push_back(f);
    result_.mesh.faces = picked(mesh().faces, faces);
    result_.face_of = picked(result_.face_of, faces);
  }

  // Vertices in this order. An index out of range stays as it is.
  void number_vertices(const Array<Index>& vertices) {
    Array<Index> now(vertices.size());
    for (Index v = 0; v < static_cast<Index>(vertices.size()); ++v) now[vertices[v]] = v;
    const auto is_vertex = [&](Index v) { return v >= 0 && v < static_cast<Index>(now.size()); };
    for (auto& face : result_.mesh.faces) {
      for (Index& v : face) v = is_vertex(v) ? now[v] : v;
    }
    result_.mesh.positions = picked(mesh().positions, vertices);
    result_.vertex_of = picked(result_.vertex_of, vertices);
  }

  template <class Value>
  [[nodiscard]] static std::vector<Value> picked(const std::vector<Value>& values,
                                                 const Array<Index>& which) {
    std::vector<Value> result;
    result.reserve(which.size());
    for (const Index i : which) result.push_back(values[static_cast<std::size_t>(i)]);
    return result;
  }

  Repaired<T> result_;
};

}  // namespace gelight::detail
