#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/faces_near.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// The sum of angles from 0 to pi, each that of a vector with the x axis: as a number of half turns
/// and a vector at the angle that is left, by products of complex numbers alone.
template <std::floating_point Real>
class AngleSum {
 public:
  /// The vector's y is not negative, and its numbers are those of lengths.
  void add(const Vec2<Real>& side) {
    const bool are_obtuse = (x_ < 0) & (side.x() < 0);
    const Real x = x_ * side.x() - y_ * side.y(), y = x_ * side.y() + y_ * side.x();
    // What two obtuse angles make is beyond pi, though it may be 2 pi but for rounding. (Bits are
    // joined by `&` and `|`, for which way it goes cannot be foreseen.)
    set(x, y, are_obtuse | is_beyond_half_turn(x, y));
    if (is_beyond_half_turn(x_, y_)) [[unlikely]]
      set(x_, y_, true);
    const Real size = std::fabs(x_) + y_;
    if (!(size > smallest && size < 1 / smallest)) [[unlikely]] {
      const Real scale = size < 1 ? 1 / smallest : smallest;
      set(scale * x_, scale * y_, false);
    }
  }

  /// Whether the angles sum to more than so many half turns and an angle less than a right one, of
  /// which the tangent is given.
  [[nodiscard]] bool exceeds(int half_turns, Real tangent) const {
    if (half_turns_ != half_turns) return half_turns_ > half_turns;
    return x_ <= 0 || y_ > tangent * x_;
  }

 private:
  static constexpr Real smallest = 0x1p-300;

  static bool is_beyond_half_turn(Real x, Real y) { return (y < 0) | ((y == 0) & (x < 0)); }
  void set(Real x, Real y, bool is_turned) {
    const Real sign = 1 - 2 * is_turned;
    half_turns_ += is_turned;
    x_ = sign * x;
    y_ = sign * y;
  }

  Real x_ = 1, y_ = 0;
  int half_turns_ = 0;
};

/// Every face laid flat, once per half-edge: the half-edge's origin at (0, 0), its tip at
/// (length, 0) and the apex at `apex(h)`, whose y is not negative.
template <std::floating_point Real>
class PlanarFaces {
 public:
  /// Lays none flat yet: `lay_flat_near` does those that are needed.
  PlanarFaces() = default;
  /// Lays all flat.
  explicit PlanarFaces(const Surface<Real>& surface)
      : apex_(static_cast<std::size_t>(surface.halfedge_count())) {
    Array<Neighbourhood> around(static_cast<std::size_t>(surface.vertex_count()));
    for (Index f = 0; f < surface.face_count(); ++f) {
      for (const Index v : surface.face(std::min(f + faces_ahead, surface.face_count() - 1))) {
        prefetch(&around[v], sizeof(Neighbourhood));
        prefetch(&surface.position(v), sizeof(Vec3<Real>));
      }
      lay_flat(surface, 3 * f);
      for (Index h = 3 * f; h < 3 * f + 3; ++h) count(surface, h, around);
    }
    bends_.reserve_for_all(around.size());
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      bends_.push_back(classified(surface, v, around[v]));
    }
  }

  /// Lays all faces flat that paths from a point come to within a distance, and those round them;
  /// of a surface that has to be the same each time. Takes as long as there are such faces, and
  /// touches no memory of others but for two bytes of each.
  void lay_flat_near(const Surface<Real>& surface, const SurfacePoint<Real>& point, Real distance) {
    apex_.resize_unwritten(static_cast<std::size_t>(surface.halfedge_count()));
    bends_.resize_unwritten(static_cast<std::size_t>(surface.vertex_count()));
    is_flat_.resize(static_cast<std::size_t>(surface.face_count()));
    is_classified_.resize(static_cast<std::size_t>(surface.vertex_count()));
    patch_.find(surface, point, distance);
    for (const Index f : patch_.faces()) {
      for (const Index v : surface.face(f)) {
        if (!std::exchange(is_classified_[v], true)) classify(surface, v);
      }
    }
  }

  [[nodiscard]] const Vec2<Real>& apex(Index h) const { return apex_[h]; }

  /// Has the processor fetch the apexes of h's face. (Always inlined, as prefetch.)
  [[gnu::always_inline]] void expect(Index h) const {
    prefetch(&apex_[h / 3 * 3], 3 * sizeof(Vec2<Real>));
  }

  /// Whether h's face has its apex on h, but for rounding, and so no area; and whether any that is
  /// laid flat has.
  ///@{
  [[nodiscard]] bool is_line(const Surface<Real>& surface, Index h) const {
    constexpr Real lowest = 16 * std::numeric_limits<Real>::epsilon();
    return apex_[h].y() <= lowest * (surface.length(h) + std::fabs(apex_[h].x()));
  }
  [[nodiscard]] bool has_lines() const { return has_lines_; }
  ///@}

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

  /// Length of the longest edge of all that are laid flat.
  [[nodiscard]] Real longest_edge() const { return longest_edge_; }

  /// How shortest paths can pass a vertex: not at all (or straight on, where it is flat), nor near
  /// it at a tip; bending at a saddle or a re-entrant corner of the border; or in any direction, at
  /// a vertex that is not a plain one: on a zero-length edge, on an edge of three faces or more, on
  /// the opposite side of a face without area, where several fans meet.
  enum class Bend : unsigned char { none, tip, saddle, any };
  [[nodiscard]] Bend bend(Index vertex) const { return bends_[vertex]; }
  [[nodiscard]] bool bends_at(Index vertex) const { return bends_[vertex] >= Bend::saddle; }

 private:
  // About so many faces pass while memory answers.
  static constexpr Index faces_ahead = 8;

  // Paths round a saddle of less excess angle than this are found without windows of its own: they
  // are longer than those of the neighbouring windows by half its square at most, relative.
  static constexpr Real smallest_excess = 1e-11;
  // A tip's angles sum to less than that of this tangent, 1 radian: much less than pi.
  static constexpr Real sharpest = 1.557;

  void lay_flat(const Surface<Real>& surface, Index first) {
    const auto [a, b, c] = surface.face(Surface<Real>::face_of(first));
    const Vec3<Real>&p = surface.position(a), &q = surface.position(b), &r = surface.position(c);
    const std::array<Vec3<Real>, 3> ways{q - p, r - q, p - r};
    const std::array<Real, 3> lengths{surface.length(first), surface.length(first + 1),
                                      surface.length(first + 2)};
    // The area from the two shorter edges: its rounding error is proportional to their product.
    const auto longest = static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) -
                                                  lengths.begin());
    const Real doubled_area = stable_norm(cross(ways[(longest + 1) % 3], ways[(longest + 2) % 3]));
    longest_edge_ = std::max(longest_edge_, lengths[longest]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3, previous = (k + 2) % 3;
      Vec2<Real>& apex = apex_[first + static_cast<Index>(k)];
      const Real length = lengths[k];
      if (length == 0) {
        apex = {lengths[previous], 0};
        has_lines_ = true;
        continue;
      }
      const Vec3<Real> along = ways[k] / length;
      // From the nearer end, so that the error is proportional to the distance from there.
      const Real x = lengths[previous] < lengths[next] ? -dot(along, ways[previous])
                                                       : length + dot(along, ways[next]);
      apex = {x, doubled_area / length};
      has_lines_ |= is_line(surface, first + static_cast<Index>(k));
    }
  }

  // What is round a vertex.
  struct Neighbourhood {
    AngleSum<Real> angles;
    Index border_edges = 0;
    bool is_odd = false;  // on an edge without length, or of three faces or more; or is_on_side
  };

  void classify(const Surface<Real>& surface, Index vertex) {
    Neighbourhood around;
    for (const Index h : surface.corners(vertex)) {
      const Index f = Surface<Real>::face_of(h);
      if (!std::exchange(is_flat_[f], true)) lay_flat(surface, 3 * f);
      around.angles.add(apex_[h]);
      for (const Index side : {h, Surface<Real>::previous(h)}) {
        around.border_edges += surface.is_border(side) ? 1 : 0;
        around.is_odd |= is_odd(surface, side);
      }
      around.is_odd |= is_on_side(surface, h);
    }
    bends_[vertex] = classified(surface, vertex, around);
  }

  static bool is_odd(const Surface<Real>& surface, Index h) {
    return surface.length(h) == 0 || !surface.is_manifold(h);
  }

  /// Whether h's origin lies on the opposite side of h's face, between its ends. There a path may
  /// come through that side just where another bends on it, over no way and so from no direction.
  [[nodiscard]] bool is_on_side(const Surface<Real>& surface, Index h) const {
    return apex_[h].x() < 0 && is_line(surface, h);
  }

  void count(const Surface<Real>& surface, Index h, Array<Neighbourhood>& around) const {
    Neighbourhood &origin = around[surface.origin(h)], &tip = around[surface.tip(h)];
    origin.angles.add(apex_[h]);
    if (surface.is_border(h)) {
      ++origin.border_edges;
      ++tip.border_edges;
    }
    if (is_odd(surface, h)) origin.is_odd = tip.is_odd = true;
    origin.is_odd |= is_on_side(surface, h);
  }

  static Bend classified(const Surface<Real>& surface, Index vertex, const Neighbourhood& around) {
    const auto corners = std::ssize(surface.corners(vertex));
    if (corners == 0) return Bend::none;
    const bool is_plain = !around.is_odd && around.border_edges <= 2;
    if (!is_plain || fan_size(surface, vertex) < corners) return Bend::any;
    const bool is_inner = around.border_edges == 0;
    if (is_inner && !around.angles.exceeds(0, sharpest)) return Bend::tip;
    return around.angles.exceeds(is_inner ? 2 : 1, smallest_excess) ? Bend::saddle : Bend::none;
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
  bool has_lines_ = false;
  // Where not all were laid flat at once: which are, and which vertices' bends are known.
  Array<char> is_flat_, is_classified_;
  FacesNear<Real> patch_;
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

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::PlanarFaces<double>;
}  // namespace gelight
#endif
