#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Every face laid flat, once per half-edge: the half-edge's origin at (0, 0), its tip at
/// (length, 0) and the apex at `apex(h)`, whose y is not negative.
template <std::floating_point Real>
class PlanarFaces {
 public:
  explicit PlanarFaces(const Surface<Real>& surface) {
    const Index faces = surface.face_count();
    apex_.resize(static_cast<std::size_t>(surface.halfedge_count()));
    for (Index f = 0; f < faces; ++f) lay_flat(surface, 3 * f);
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      longest_edge_ = std::max(longest_edge_, surface.length(h));
    }
    classify_vertices(surface);
  }

  [[nodiscard]] const Vec2<Real>& apex(Index h) const { return apex_[h]; }

  /// The apex as seen from h's tip: how far back along h, and how high. Exact by itself, where the
  /// apex is so near to the tip that its place as counted from the origin does not tell.
  [[nodiscard]] Vec2<Real> apex_from_tip(const Surface<Real>& surface, Index h) const {
    const Real length = surface.length(h);
    if (length == 0) return {-apex_[h].x(), 0};
    const Index next = Surface<Real>::next(h);
    return surface.length(next) / length * apex_[next];
  }

  /// The place in h's frame of a point with these shares of the corners of h's face.
  [[nodiscard]] Vec2<Real> place(const Surface<Real>& surface, Index h,
                                 const std::array<Real, 3>& shares) const {
    const Real at_tip = shares[static_cast<std::size_t>((h + 1) % 3)];
    const Real at_apex = shares[static_cast<std::size_t>((h + 2) % 3)];
    const Vec2<Real>& apex = apex_[h];
    return {at_tip * surface.length(h) + at_apex * apex.x(), at_apex * apex.y()};
  }

  /// The angle of h's face at h's origin, in radians.
  [[nodiscard]] Real angle(Index h) const { return std::atan2(apex_[h].y(), apex_[h].x()); }

  /// Length of the longest edge of all.
  [[nodiscard]] Real longest_edge() const { return longest_edge_; }

  /// How shortest paths can pass a vertex: not at all (or straight on, where it is flat), nor near
  /// it at a tip; bending at a saddle or a re-entrant corner of the border; or in any direction, at
  /// a vertex that is not a plain one: on a zero-length edge, on an edge of three faces or more,
  /// where several fans meet.
  enum class Bend : unsigned char { none, tip, saddle, any };
  [[nodiscard]] Bend bend(Index vertex) const { return bends_[vertex]; }
  [[nodiscard]] bool bends_at(Index vertex) const { return bends_[vertex] >= Bend::saddle; }

 private:
  // Paths round a saddle of less excess angle than this are found without windows of its own: they
  // are longer than those of the neighbouring windows by half its square at most, relative.
  static constexpr Real smallest_excess = 1e-11;
  // A tip's angles sum to less than this, in radians; much less than pi.
  static constexpr Real sharpest = 1;

  void lay_flat(const Surface<Real>& surface, Index first) {
    // The area from the two shorter edges: its rounding error is proportional to their product.
    std::array<Index, 3> by_length{first, first + 1, first + 2};
    const auto order = [&](Index& a, Index& b) {
      if (surface.length(b) < surface.length(a)) std::swap(a, b);
    };
    order(by_length[0], by_length[1]);
    order(by_length[1], by_length[2]);
    order(by_length[0], by_length[1]);
    const Real doubled_area =
        stable_norm(cross(vector(surface, by_length[0]), vector(surface, by_length[1])));
    for (Index h = first; h < first + 3; ++h) {
      const Real length = surface.length(h);
      if (length == 0) {
        apex_[h] = {surface.length(Surface<Real>::previous(h)), 0};
        continue;
      }
      const Vec3<Real> along = vector(surface, h) / length;
      const Index next = Surface<Real>::next(h), previous = Surface<Real>::previous(h);
      // From the nearer end, so that the error is proportional to the distance from there.
      const Real x = surface.length(previous) < surface.length(next)
                         ? -dot(along, vector(surface, previous))
                         : length + dot(along, vector(surface, next));
      apex_[h] = {x, doubled_area / length};
    }
  }

  static Vec3<Real> vector(const Surface<Real>& surface, Index h) {
    const Vec3<Real>& origin = surface.position(surface.origin(h));
    const Vec3<Real>& tip = surface.position(surface.tip(h));
    return tip - origin;
  }

  void classify_vertices(const Surface<Real>& surface) {
    const Index count = surface.vertex_count();
    bends_.resize(static_cast<std::size_t>(count));
    for (Index v = 0; v < count; ++v) bends_[v] = classify(surface, v);
  }

  [[nodiscard]] Bend classify(const Surface<Real>& surface, Index vertex) const {
    const auto corners = surface.corners(vertex);
    if (corners.empty()) return Bend::none;
    Real sum = 0;
    Index border_edges = 0;
    for (const Index out : corners) {
      for (const Index h : {out, Surface<Real>::previous(out)}) {
        if (surface.length(h) == 0 || !surface.is_manifold(h)) return Bend::any;
        border_edges += surface.is_border(h);
      }
      sum += angle(out);
    }
    if (border_edges > 2 || fan_size(surface, vertex) < std::ssize(corners)) return Bend::any;
    const Real flat = border_edges > 0 ? std::numbers::pi : 2 * std::numbers::pi;
    if (border_edges == 0 && sum < sharpest) return Bend::tip;
    return sum > flat + smallest_excess ? Bend::saddle : Bend::none;
  }

  // Faces reached from a vertex's first corner by turning round the vertex both ways.
  static std::ptrdiff_t fan_size(const Surface<Real>& surface, Index vertex) {
    const Index start = surface.corners(vertex)[0];
    std::ptrdiff_t count = 1;
    for (const Index side : {start, Surface<Real>::previous(start)}) {
      Index h = side;
      while (!surface.is_border(h)) {
        const Index across = surface.twin(h);
        if (Surface<Real>::face_of(across) == Surface<Real>::face_of(start)) return count;
        ++count;
        h = surface.origin(across) == vertex ? Surface<Real>::previous(across)
                                             : Surface<Real>::next(across);
      }
    }
    return count;
  }

  Array<Vec2<Real>> apex_;
  Array<Bend> bends_;
  Real longest_edge_ = 0;
};

/// Whether the face of h is so thin that the plane it lies in is rounding.
template <std::floating_point Real>
[[nodiscard]] inline bool is_thin(const Surface<Real>& surface, const PlanarFaces<Real>& faces,
                                  Index h) {
  constexpr Real thinnest = 1e-12;
  const Vec2<Real>& apex = faces.apex(h);
  return apex.y() <= thinnest * std::max(surface.length(h), std::fabs(apex.x()));
}

}  // namespace gelight::detail
