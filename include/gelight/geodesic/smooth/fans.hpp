#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// The corners of each vertex in groups between which the surface is sharp: at creases, borders and
/// edges of three faces or more. Within a group, a fan, it is smooth and has one normal.
template <std::floating_point Real>
class Fans {
 public:
  using Mesh = Surface<Real>;

  /// Edges at which faces turn by more than `crease_angle` are creases, but not where it is noise
  /// that turns them, and those given as pairs of vertices. Throws InvalidInput for a pair that is
  /// no edge.
  Fans(const Mesh& surface, Real crease_angle, const std::vector<std::array<Index, 2>>& creases)
      : surface_(surface) {
    find_face_normals();
    find_sharp_edges(std::cos(crease_angle));
    smooth_noise(most_noise * crease_angle);
    add_creases(creases);
    join_corners();
  }

  [[nodiscard]] const Mesh& surface() const { return surface_; }
  [[nodiscard]] Index count() const { return static_cast<Index>(begin_.size()) - 1; }
  /// The fan of the corner at a half-edge's origin.
  [[nodiscard]] Index at(Index h) const { return fan_[h]; }
  /// The half-edges that start at a fan's vertex, one in each of its faces.
  [[nodiscard]] Slice<const Index> corners(Index fan) const {
    return {
        std::span<const Index>(corners_.data() + begin_[fan], corners_.data() + begin_[fan + 1])};
  }
  [[nodiscard]] Index vertex(Index fan) const { return surface_.origin(corners_[begin_[fan]]); }
  /// Whether the surface is not smooth across a half-edge's edge.
  [[nodiscard]] bool is_sharp(Index h) const { return is_sharp_[h] != 0; }
  /// Whether it is smooth all round a vertex: a single fan without an end.
  [[nodiscard]] bool is_smooth(Index vertex) const { return is_smooth_[vertex] != 0; }
  /// Unit normal of a face; zero where it has no area.
  [[nodiscard]] const Vec3<Real>& face_normal(Index f) const { return face_normals_[f]; }

  /// Sum of the normals of a fan's faces, weighted by their angles, unit; zero where all are.
  [[nodiscard]] Vec3<Real> mean_normal(Index fan) const {
    Vec3<Real> sum(0, 0, 0);
    for (const Index h : corners(fan)) {
      const Vec3<Real> a = side(h), b = -side(Mesh::previous(h));
      sum += std::atan2(stable_norm(cross(a, b)), dot(a, b)) * face_normals_[Mesh::face_of(h)];
    }
    return stable_unit(sum);
  }

 private:
  [[nodiscard]] Vec3<Real> side(Index h) const {
    return surface_.position(surface_.tip(h)) - surface_.position(surface_.origin(h));
  }

  void find_face_normals() {
    face_normals_.resize(static_cast<std::size_t>(surface_.face_count()));
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const Vec3<Real> a = stable_unit(side(3 * f)), b = stable_unit(side(3 * f + 1));
      face_normals_[f] = stable_unit(cross(a, b));
    }
  }

  void find_sharp_edges(Real least_cosine) {
    is_sharp_.assign(static_cast<std::size_t>(surface_.halfedge_count()), 0);
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      is_sharp_[h] = !(can_be_smooth(h) && cosine(h) >= least_cosine);
    }
  }
  // Between two faces of one orientation that have an area.
  [[nodiscard]] bool can_be_smooth(Index h) const {
    const Index t = surface_.twin(h);
    const bool is_oriented =
        t != h && surface_.twin(t) == h && surface_.origin(t) != surface_.origin(h);
    return is_oriented && cosine(h) != 0;
  }
  [[nodiscard]] Real cosine(Index h) const {
    return dot(face_normals_[Mesh::face_of(h)], face_normals_[Mesh::face_of(surface_.twin(h))]);
  }

  // The share of the crease angle by which, in the mean, edges about a crease may turn to both
  // sides: less than they do in noise that looks like creases, and more than about creases of
  // cylinders, cones and the like of 9 faces around or more.
  static constexpr Real most_noise = 0.35;

  // Sums over edges that are not sharp, of the squares by which they turn out and in.
  struct Turns {
    Real out = 0, in = 0;
    Index count = 0;

    void operator+=(const Turns& other) {
      out += other.out;
      in += other.in;
      count += other.count;
    }
    // The mean square, were they to turn to both sides as to that to which they turn less.
    [[nodiscard]] Real to_both_sides() const {
      return count > 0 ? 2 * std::min(out, in) / static_cast<Real>(count) : 0;
    }
  };

  // About a crease surfaces are flat, or turn to one side, or to both a little. Noise turns all
  // edges to both sides, some of them by more than the crease angle. These become smooth again:
  // were they sharp, each face between them would count as flat, and no path over them as rough.
  void smooth_noise(Real most_turn) {
    Array<Turns> turns(static_cast<std::size_t>(surface_.vertex_count()));
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      if (!is_sharp_[h]) turns[surface_.origin(h)] += turn(h);
    }
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      const Index t = surface_.twin(h);
      // Once for both sides of an edge, so that they agree.
      if (t < h || !is_sharp_[h] || !can_be_smooth(h)) continue;
      Turns around;
      for (const Index end : {surface_.origin(h), surface_.tip(h)}) {
        for (const Index g : surface_.corners(end)) around += turns[surface_.tip(g)];
      }
      is_sharp_[h] = is_sharp_[t] = around.to_both_sides() <= most_turn * most_turn;
    }
  }
  [[nodiscard]] Turns turn(Index h) const {
    const Index t = surface_.twin(h);
    const Vec3<Real>& normal = face_normals_[Mesh::face_of(h)];
    const Real square = squared_norm(Vec3<Real>(face_normals_[Mesh::face_of(t)] - normal));
    if (dot(normal, side(Mesh::next(t))) > 0) return {0, square, 1};
    return {square, 0, 1};
  }

  void add_creases(const std::vector<std::array<Index, 2>>& creases) {
    for (std::size_t i = 0; i < creases.size(); ++i) {
      const auto [a, b] = creases[i];
      surface_.require_vertex(a);
      surface_.require_vertex(b);
      const Index first = surface_.find_halfedge(a, b);
      require(first >= 0, "crease ", i, " is no edge: there is none between vertices ", a, " and ",
              b);
      Index h = first;
      do {
        is_sharp_[h] = 1;
        h = surface_.twin(h);
      } while (h != first);
    }
  }

  void join_corners() {
    const auto halfedges = static_cast<std::size_t>(surface_.halfedge_count());
    fan_.assign(halfedges, -1);
    corners_.reserve(halfedges);
    is_smooth_.assign(static_cast<std::size_t>(surface_.vertex_count()), 0);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const auto begin = begin_.size();
      for (const Index h : surface_.corners(v)) {
        if (fan_[h] < 0) collect(h);
      }
      const auto sharp = [&](Index h) { return is_sharp_[h] || is_sharp_[Mesh::previous(h)]; };
      const auto corners = surface_.corners(v);
      is_smooth_[v] =
          begin_.size() == begin + 1 && std::none_of(corners.begin(), corners.end(), sharp);
    }
    begin_.push_back(static_cast<Index>(corners_.size()));
  }

  // All corners that are joined to one without crossing a sharp edge, turning both ways.
  void collect(Index first) {
    const auto fan = static_cast<Index>(begin_.size());
    begin_.push_back(static_cast<Index>(corners_.size()));
    const auto add = [&](Index h) {
      fan_[h] = fan;
      corners_.push_back(h);
    };
    add(first);
    for (Index h = first; !is_sharp_[Mesh::previous(h)];) {
      h = surface_.twin(Mesh::previous(h));
      if (fan_[h] >= 0) return;
      add(h);
    }
    for (Index h = first; !is_sharp_[h];) {
      h = Mesh::next(surface_.twin(h));
      if (fan_[h] >= 0) return;
      add(h);
    }
  }

  Mesh surface_;
  Array<Vec3<Real>> face_normals_;
  Array<char> is_sharp_;   // of each half-edge
  Array<char> is_smooth_;  // of each vertex
  Array<Index> fan_;       // of each half-edge: that of the corner at its origin
  Array<Index> begin_;     // of each fan, and one more: where its corners begin
  Array<Index> corners_;
};

}  // namespace gelight::detail
