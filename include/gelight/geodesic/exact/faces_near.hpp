#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The faces that paths from a point come to within a distance, and some more: from face to face
/// over what is so near through space, for no path is shorter than the straight way. In time
/// proportional to the faces and the corners of their vertices.
template <std::floating_point Real>
class FacesNear {
 public:
  using Point = SurfacePoint<Real>;

  /// Of a surface that has as many faces and vertices each time.
  void find(const Surface<Real>& surface, const Point& point, Real distance) {
    for (const Index f : faces_) is_found_[f] = 0;
    for (const Index v : vertices_) is_passed_[v] = 0;
    faces_.clear();
    vertices_.clear();
    is_found_.resize(static_cast<std::size_t>(surface.face_count()));
    is_passed_.resize(static_cast<std::size_t>(surface.vertex_count()));
    const Real limit = distance * (1 + rounding);
    for_each_place(surface, point, [&](Index f, const std::array<Real, 3>&) { add(f); });
    for (std::ptrdiff_t i = 0; i < std::ssize(faces_); ++i) {
      spread(surface, point, faces_[i], limit);
    }
  }

  [[nodiscard]] const Array<Index>& faces() const { return faces_; }

 private:
  // Ways are found to be shorter or longer by less than this share of them and of the faces' sides.
  static constexpr Real rounding = 1e-9;

  // Marks come last, or where memory ends they would stay and leave faces out the next time.
  void add(Index face) {
    if (is_found_[face]) return;
    faces_.push_back(face);
    is_found_[face] = 1;
  }

  void spread(const Surface<Real>& surface, const Point& from, Index face, Real limit) {
    for (Index h = 3 * face; h < 3 * face + 3; ++h) {
      const Index v = surface.origin(h);
      const Real length = surface.length(h), room = limit + rounding * length;
      const Vec3<Real> way = surface.difference(from, vertex_point<Real>(v));
      if (stable_norm(way) <= room) pass(surface, v);
      if (surface.is_border(h)) continue;
      Vec3<Real> along = surface.position(surface.tip(h)) - surface.position(v);
      if (length > 0) along /= length;
      const Real foot = std::clamp(-dot(way, along), Real(0), length);
      if (stable_norm(way + foot * along) <= room) add(Surface<Real>::face_of(surface.twin(h)));
    }
  }

  void pass(const Surface<Real>& surface, Index vertex) {
    if (is_passed_[vertex]) return;
    vertices_.push_back(vertex);
    is_passed_[vertex] = 1;
    for (const Index h : surface.corners(vertex)) add(Surface<Real>::face_of(h));
  }

  Array<Index> faces_, vertices_;     // that are found, and gone round
  Array<char> is_found_, is_passed_;  // of each face, and of each vertex
};

}  // namespace gelight::detail
