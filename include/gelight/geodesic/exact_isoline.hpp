#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// A piece of a circle in the plane of one face, counter-clockwise as seen from the side from which
/// the face's vertices are.
template <std::floating_point T>
struct CircularArc {
  Index face = -1;                ///< in which it lies
  Vec3<T> begin{0, 0, 0};         ///< its ends, in space
  Vec3<T> end{0, 0, 0};           ///< its ends, in space
  Vec3<T> centre{0, 0, 0};        ///< of the circle, in the face's plane: the source laid flat into it
  T radius = 0;                   ///< of the circle
  T angle = 0;                    ///< by which it turns about the centre, in radians, at most 2 pi

  /// How long it is.
  [[nodiscard]] T length() const { return radius * angle; }
};

/// The points at one distance, as arcs that follow one on another.
template <std::floating_point T>
struct ExactIsoline {
  std::vector<CircularArc<T>> arcs;  ///< each begins where the one before ends
  bool is_closed = false;            ///< whether the first begins where the last ends

  /// How long it is.
  [[nodiscard]] T length() const {
    T sum = 0;
    for (const auto& arc : arcs) sum += arc.length();
    return sum;
  }
};

namespace detail {

/// In each face the points nearer than a level are the union of discs, one about each image of a
/// source or bend that the face's windows see, as far as they see it. Its border's arcs are the
/// isoline's.
template <std::floating_point T>
class ArcTracer {
 public:
  ArcTracer(const ExactField<T>& field, T level, const CancelHook& cancelled)
      : field_(field), surface_(field.surface_), level_(level), cancelled_(cancelled) {
    require(field.windows_ && field.kept_faces_.empty(),
            "the field has not kept its windows: see ExactOptions::keep_windows");
    require(std::isfinite(level), "the level ", level, " is not finite");
    size_ = size_of(surface_);
    // Sources that are lines are circles about points far away, which are rounded by more.
    same_ = (field.fronts_.empty() ? 1e-11 : 1e-9) * size_;
  }

  [[nodiscard]] std::vector<ExactIsoline<T>> lines() {
    for_each_face([&](Index) { find_arcs(); });
    return linked();
  }

  [[nodiscard]] T area() {
    Real sum = 0;
    for_each_face([&](Index f) {
      const auto first = pieces_.size();
      find_arcs();
      for (auto i = first; i < pieces_.size(); ++i) sum += area_beside(pieces_[i]);
      pieces_.resize(first);
      for (Index h = 3 * f; h < 3 * f + 3; ++h) sum += area_beside_edge(h);
    });
    return static_cast<T>(sum);
  }

 private:
  using Real = double;
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  static constexpr Real turn = 2 * std::numbers::pi;

  /// The points p of the plane with normal . p >= offset.
  struct HalfPlane {
    Vec2<Real> normal;
    Real offset;
    [[nodiscard]] Real height(const Vec2<Real>& p) const { return normal.dot(p) - offset; }
  };
  /// A disc, seen in part of the face only.
  struct Disc {
    Vec2<Real> centre;
    Real radius;
    std::vector<HalfPlane> seen{};

    [[nodiscard]] Vec2<Real> at(Real angle) const {
      return centre + radius * Vec2<Real>(std::cos(angle), std::sin(angle));
    }
    [[nodiscard]] bool sees(const Vec2<Real>& p) const {
      return std::all_of(seen.begin(), seen.end(),
                         [&](const HalfPlane& half) { return half.height(p) >= 0; });
    }
  };
  struct Piece {
    Index face;
    Vec2<Real> centre;
    Real radius, from, angle;
    Vec2<Real> begin, end;  // in the frame of the face's first half-edge
    Vec3<Real> begin_in_space, end_in_space;
  };

  // --- the discs of a face -----------------------------------------------------------------------

  void for_each_face(const auto& visit) {
    for (Index f = 0; f < surface_.face_count(); ++f) {
      if (f % 1024 == 0) {
        cancelled_.check(static_cast<double>(f) / surface_.face_count(), "exact isolines");
      }
      if (is_thin(surface_, *field_.faces_, 3 * f)) continue;
      lay_flat(f);
      find_discs();
      if (!discs_.empty()) visit(f);
    }
  }

  void lay_flat(Index f) {
    face_ = f;
    corners_ = {Vec2<Real>(0, 0), Vec2<Real>(surface_.length(3 * f), 0),
                field_.faces_->apex(3 * f)};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2<Real> way = stable_unit(corners_[(k + 1) % 3] - corners_[k]);
      ways_[k] = way;
      sides_[k].normal = {-way.y(), way.x()};
      sides_[k].offset = sides_[k].normal.dot(corners_[k]);
    }
  }

  // A place of half-edge h's frame in that of the face.
  [[nodiscard]] Vec2<Real> from_frame(Index h, const Vec2<Real>& p) const {
    const auto k = static_cast<std::size_t>(h % 3);
    return corners_[k] + p.x() * ways_[k] + p.y() * sides_[k].normal;
  }

  void find_discs() {
    discs_.clear();
    const Index v = surface_.face(face_)[0];
    const Real level = Real{level_} - field_.starts_.at(v);
    require(level <= field_.bound_at(v), "the level ", level_,
            " is beyond the greatest distance that was solved for");
    for (std::size_t k = 0; k < 3; ++k) {
      const Real radius = level - field_.distances_[surface_.face(face_)[k]];
      if (radius > 0) discs_.push_back({corners_[k], radius});
    }
    for (const auto& source : field_.sources_) add_source(source, level);
    for (const auto& front : field_.fronts_) {
      if (front.face == face_) add_front(front, level);
    }
    for (Index h = 3 * face_; h < 3 * face_ + 3; ++h) add_windows(h, level);
  }

  void add_source(const Source<Real>& source, Real level) {
    const Real radius = level - source.distance;
    if (source.point.kind == Point::Kind::vertex || !(radius > 0)) return;
    for_each_place(surface_, source.point, [&](Index f, const std::array<Real, 3>& shares) {
      if (f == face_) discs_.push_back({place(shares), radius});
    });
  }

  [[nodiscard]] Vec2<Real> place(const std::array<Real, 3>& shares) const {
    return shares[0] * corners_[0] + shares[1] * corners_[1] + shares[2] * corners_[2];
  }

  // On both sides of a segment, as the windows are that leave it.
  void add_front(const FrontOf<Real>& front, Real level) {
    constexpr Real far = 1 << 20, widest = 0.04;
    const Vec2<Real> a = place(front.begin), way = place(front.end) - a;
    const Real width = stable_norm(way), away = far * size_;
    if (!(width > 0) || !(level > front.start)) return;
    const auto count = static_cast<int>(std::ceil(width / (widest * size_)));
    for (const Real sign : {-1.0, 1.0}) {
      const Vec2<Real> up = sign * Vec2<Real>(-way.y(), way.x()) / width;
      for (int i = 0; i < count; ++i) {
        const Vec2<Real> begin = a + way * (static_cast<Real>(i) / count);
        const Vec2<Real> end = a + way * (static_cast<Real>(i + 1) / count);
        const Vec2<Real> centre = (begin + end) / 2 - away * up;
        Disc disc{centre, level - front.start + away};
        const bool is_left = sign > 0;
        disc.seen = {right_of(centre, is_left ? begin : end), left_of(centre, is_left ? end : begin),
                     {up, up.dot(a)}};
        discs_.push_back(disc);
      }
    }
  }

  void add_windows(Index h, Real level) {
    field_.windows_->for_each(h, [&](const auto& w, std::ptrdiff_t count) {
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        const Real radius = level - field_.origins_[w.origin[i]].start;
        const Real gap = std::clamp(w.x[i], w.begin[i], w.end[i]) - w.x[i];
        if (!(radius > 0) || gap * gap + w.y[i] * w.y[i] >= radius * radius) continue;
        const Vec2<Real> centre = from_frame(h, {w.x[i], w.y[i]});
        Disc disc{centre, radius};
        disc.seen = {right_of(centre, from_frame(h, {w.begin[i], 0})),
                     left_of(centre, from_frame(h, {w.end[i], 0}))};
        discs_.push_back(disc);
      }
    });
  }

  // What lies beside the line from one place by another.
  static HalfPlane left_of(const Vec2<Real>& from, const Vec2<Real>& by) {
    const Vec2<Real> way = stable_unit(by - from), normal(-way.y(), way.x());
    return {normal, normal.dot(by)};
  }
  static HalfPlane right_of(const Vec2<Real>& from, const Vec2<Real>& by) {
    const HalfPlane left = left_of(from, by);
    return {-left.normal, -left.offset};
  }

  // --- the arcs of a face ------------------------------------------------------------------------

  void find_arcs() {
    for (std::size_t i = 0; i < discs_.size(); ++i) find_arcs(i);
  }

  // Of what one disc's circle is cut into by all borders, what lies in no other disc.
  void find_arcs(std::size_t number) {
    const Disc& disc = discs_[number];
    cuts_.assign(1, 0);
    for (const HalfPlane& side : sides_) cut(disc, side.normal, side.offset);
    for (const Disc& other : discs_) {
      for (const HalfPlane& half : other.seen) cut(disc, half.normal, half.offset);
      const Vec2<Real> way = other.centre - disc.centre;
      const Real gap = stable_norm(way);
      if (gap <= same_) continue;
      // Where both circles cross, measured from the middle of this one along the line to the other.
      const Real along =
          (gap + (disc.radius - other.radius) * (disc.radius + other.radius) / gap) / 2;
      cut(disc, way / gap, along + (way / gap).dot(disc.centre));
    }
    std::sort(cuts_.begin(), cuts_.end());
    cuts_.push_back(turn);
    const Real least = same_ / disc.radius;  // an angle that is rounding
    const auto first = pieces_.size();
    Real from = 0, to = -1;
    const auto finish = [&] {
      if (to > from) add_piece(disc, from, to - from);
      to = -1;
    };
    for (std::size_t i = 0; i + 1 < cuts_.size(); ++i) {
      if (cuts_[i + 1] - cuts_[i] <= least) continue;
      if (!is_border(number, disc.at((cuts_[i] + cuts_[i + 1]) / 2))) {
        finish();
        continue;
      }
      if (to < 0) from = cuts_[i];
      to = cuts_[i + 1];
    }
    finish();
    join_over_zero(disc, first, least);
  }

  void cut(const Disc& disc, const Vec2<Real>& normal, Real offset) {
    const Real cosine = (offset - normal.dot(disc.centre)) / disc.radius;
    if (!(std::fabs(cosine) < 1)) return;
    const Real middle = std::atan2(normal.y(), normal.x()), half = std::acos(cosine);
    for (const Real angle : {middle - half, middle + half}) {
      cuts_.push_back(angle < 0 ? angle + turn : angle >= turn ? angle - turn : angle);
    }
  }

  [[nodiscard]] bool is_border(std::size_t number, const Vec2<Real>& p) const {
    for (const HalfPlane& side : sides_) {
      if (side.height(p) < 0) return false;
    }
    if (!discs_[number].sees(p)) return false;
    for (std::size_t i = 0; i < discs_.size(); ++i) {
      if (i == number || !discs_[i].sees(p)) continue;
      const Real inside = discs_[i].radius - (p - discs_[i].centre).norm();
      // Of one circle that is there twice the first counts.
      if (inside > same_ || (i < number && inside >= -same_)) return false;
    }
    return true;
  }

  void add_piece(const Disc& disc, Real from, Real angle) {
    const Vec2<Real> begin = disc.at(from), end = disc.at(from + angle);
    pieces_.push_back({face_, disc.centre, disc.radius, from, angle, begin, end, in_space(begin),
                       in_space(end)});
  }

  // What ends at a whole turn goes on where it began.
  void join_over_zero(const Disc& disc, std::size_t first, Real least) {
    if (pieces_.size() < first + 2) return;
    const Piece head = pieces_[first], tail = pieces_.back();
    if (head.from > least || tail.from + tail.angle < turn - least) return;
    pieces_.pop_back();
    pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(first));
    add_piece(disc, tail.from, turn - tail.from + head.from + head.angle);
  }

  [[nodiscard]] Vec3<Real> in_space(const Vec2<Real>& p) const {
    const Index h = 3 * face_;
    const Vec3<Real>& o = surface_.position(surface_.origin(h));
    const Vec3<Real> x = stable_unit(surface_.position(surface_.tip(h)) - o);
    const Vec3<Real> to_apex = surface_.position(surface_.apex(h)) - o;
    const Vec3<Real> y = stable_unit(to_apex - x.dot(to_apex) * x);
    return o + p.x() * x + p.y() * y;
  }

  // --- the area within ---------------------------------------------------------------------------

  // Half of what x dy - y dx sums up to along the area's border: along its arcs, and
  static Real area_beside(const Piece& piece) {
    const Real a = piece.angle;
    const Real cap = a < 1e-2 ? a * a * a / 6 * (1 - a * a / 20) : a - std::sin(a);
    return (cross_of(piece.begin, piece.end) + piece.radius * piece.radius * cap) / 2;
  }

  // along the parts of the face's sides that are nearer than the level.
  [[nodiscard]] Real area_beside_edge(Index h) {
    const auto k = static_cast<std::size_t>(h % 3);
    spans_.clear();
    for (const Disc& disc : discs_) {
      const Vec2<Real> from = corners_[k] - disc.centre;
      const Real middle = -from.dot(ways_[k]), height = sides_[k].normal.dot(from);
      const Real square = (disc.radius - height) * (disc.radius + height);
      if (!(square > 0)) continue;
      Real begin = std::max(Real(0), middle - std::sqrt(square));
      Real end = std::min(surface_.length(h), middle + std::sqrt(square));
      for (const HalfPlane& half : disc.seen) {
        const Real slope = half.normal.dot(ways_[k]), at_zero = half.height(corners_[k]);
        if (slope > 0) begin = std::max(begin, -at_zero / slope);
        if (slope < 0) end = std::min(end, -at_zero / slope);
        if (slope == 0 && at_zero < 0) end = begin;
      }
      if (end > begin) spans_.emplace_back(begin, end);
    }
    std::sort(spans_.begin(), spans_.end());
    Real covered = 0, length = 0;
    for (const auto& [begin, end] : spans_) {
      length += std::max(Real(0), end - std::max(begin, covered));
      covered = std::max(covered, end);
    }
    return cross_of(corners_[k], ways_[k]) * length / 2;
  }

  static Real cross_of(const Vec2<Real>& a, const Vec2<Real>& b) {
    return a.x() * b.y() - a.y() * b.x();
  }

  // --- from arcs to lines ------------------------------------------------------------------------

  [[nodiscard]] std::vector<ExactIsoline<T>> linked() {
    first_piece_.assign(static_cast<std::size_t>(surface_.face_count()) + 1, 0);
    for (const Piece& piece : pieces_) ++first_piece_[piece.face + 1];
    for (Index f = 0; f < surface_.face_count(); ++f) first_piece_[f + 1] += first_piece_[f];
    const auto count = static_cast<Index>(pieces_.size());
    Array<Index> next(pieces_.size(), -1);
    Array<char> has_before(pieces_.size(), 0), is_done(pieces_.size(), 0);
    for (Index i = 0; i < count; ++i) {
      next[i] = after(i, has_before);
      if (next[i] >= 0) has_before[next[i]] = 1;
    }
    std::vector<ExactIsoline<T>> out;
    // Those with ends first, from where they begin; what is left goes round.
    for (const bool is_closed : {false, true}) {
      for (Index i = 0; i < count; ++i) {
        if (is_done[i] || (!is_closed && has_before[i])) continue;
        ExactIsoline<T> line;
        line.is_closed = is_closed;
        for (Index k = i; k >= 0 && !is_done[k]; k = next[k]) {
          is_done[k] = 1;
          line.arcs.push_back(arc_of(pieces_[static_cast<std::size_t>(k)]));
        }
        out.push_back(std::move(line));
      }
    }
    return out;
  }

  // The piece that begins nearest to where another ends: in the same face, or across the sides and
  // corners at which that is; -1 where there is none.
  [[nodiscard]] Index after(Index number, const Array<char>& is_taken) {
    const Piece& piece = pieces_[static_cast<std::size_t>(number)];
    const Real reach = 1e3 * same_;
    lay_flat(piece.face);
    Index best = -1;
    Real least = reach;
    const auto look = [&](Index f) {
      for (Index i = first_piece_[f]; i < first_piece_[f + 1]; ++i) {
        const Real gap =
            (pieces_[static_cast<std::size_t>(i)].begin_in_space - piece.end_in_space).norm();
        if (is_taken[i] || !(gap < least)) continue;
        least = gap;
        best = i;
      }
    };
    look(piece.face);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index h = 3 * piece.face + static_cast<Index>(k);
      if ((piece.end - corners_[k]).norm() < reach) {
        for (const Index out : surface_.corners(surface_.origin(h))) look(Mesh::face_of(out));
      } else if (std::fabs(sides_[k].height(piece.end)) < reach && surface_.is_manifold(h)) {
        look(Mesh::face_of(surface_.twin(h)));
      }
    }
    return best;
  }

  [[nodiscard]] CircularArc<T> arc_of(const Piece& piece) {
    face_ = piece.face;
    return {piece.face,
            piece.begin_in_space.template cast<T>(),
            piece.end_in_space.template cast<T>(),
            in_space(piece.centre).template cast<T>(),
            static_cast<T>(piece.radius),
            static_cast<T>(piece.angle)};
  }

  const ExactField<T>& field_;
  const Mesh& surface_;
  T level_;
  const CancelHook& cancelled_;
  Real size_ = 0, same_ = 0;
  // The face at hand, laid flat: its corners; the directions of its sides, and what lies inside.
  Index face_ = -1;
  std::array<Vec2<Real>, 3> corners_, ways_;
  std::array<HalfPlane, 3> sides_;
  std::vector<Disc> discs_;
  std::vector<Real> cuts_;
  std::vector<std::pair<Real, Real>> spans_;
  std::vector<Piece> pieces_;
  Array<Index> first_piece_;  // of each face, and one more
};

}  // namespace detail

/// The points at one distance of an exact field: true circular arcs, joined. Of a solve from
/// Segments they are the offset of a curve by the distance, whose straight parts are arcs of a
/// radius of some 1e6 sizes of the mesh.
///
/// Nearer points lie to the left, as seen from the side from which the faces' vertices are counter-
/// clockwise. A line ends at a border, at an edge of three faces or more, where orientation changes
/// and at faces without area. Arcs shorter than 1e-11 of the mesh's size (1e-9 from segments) are
/// left out. Throws InvalidInput for a field that has not kept all windows
/// (ExactOptions::keep_windows; a solve from segments always does), a level that is not finite, and
/// one beyond the distance that was solved for; Cancelled where the hook says so. Linear in the
/// windows of faces that the line does not cross, quadratic in those of each that it may.
template <std::floating_point T>
[[nodiscard]] std::vector<ExactIsoline<T>> exact_isolines(const ExactField<T>& field,
                                                          std::type_identity_t<T> level,
                                                          const CancelHook& cancelled = {}) {
  return detail::ArcTracer<T>(field, level, cancelled).lines();
}

/// The area that is nearer than a level, which its exact isolines enclose; faces without area count
/// as none. Throws as `exact_isolines` does.
template <std::floating_point T>
[[nodiscard]] T area_within(const ExactField<T>& field, std::type_identity_t<T> level,
                            const CancelHook& cancelled = {}) {
  return detail::ArcTracer<T>(field, level, cancelled).area();
}

}  // namespace gelight
