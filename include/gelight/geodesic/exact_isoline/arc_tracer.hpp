#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/chains.hpp"
#include "gelight/geodesic/exact/flat_face.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {
template <std::floating_point T>
struct ExactIsoline;
template <std::floating_point T>
struct CircularArc;
}  // namespace gelight

namespace gelight::detail {

/// In each face the points nearer than a level are the union of discs, one about each image of a
/// source or bend that the face's windows see, as far as they see it; and of half-planes, from
/// segments. The border's arcs are the isoline's.
template <std::floating_point T>
class ArcTracer {
 public:
  ArcTracer(const ExactField<T>& field, T level, const CancelHook& cancelled)
      : solution_(solution_of(field)),
        surface_(solution_.surface),
        level_(level),
        cancelled_(cancelled) {
    require(solution_.keeps_all_windows(),
            "the field has not kept its windows: its solver needs the option keep_windows");
    require(std::isfinite(level), "the level ", level, " is not finite");
    size_ = size_of(surface_);
    same_ = (solution_.fronts.empty() ? shortest : shortest_from_segments) * size_;
    tangent_ = touching * size_;
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
      // From a place on the border or near by: what is left out of that counts by its distance from
      // there, and of a small disc far from the face's corner it would be more than all.
      const Vec2<Real> from = pieces_.size() > first ? pieces_[first].begin : discs_[0].centre;
      for (auto i = first; i < pieces_.size(); ++i) sum += area_beside(pieces_[i], from);
      pieces_.resize(first);
      for (Index h = 3 * f; h < 3 * f + 3; ++h) sum += area_beside_edge(h, from);
    });
    require(sum <= largest_number<T>, "the area is ", sum, ", more than its type can hold");
    return static_cast<T>(sum);
  }

 private:
  using Real = typename WorkingPrecision<T>::Real;
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  static constexpr Real turn = 2 * std::numbers::pi;
  // As shares of the mesh's size: arcs shorter than this are rounding of where borders cross.
  // Windows of segments have images far away, which are rounded by more.
  static constexpr Real shortest = 1e-11, shortest_from_segments = 1e-8;
  // Lines that are open and shorter are left out.
  static constexpr Real shortest_line = 1e-8;
  // Borders that go this near to each other touch: whether they cross is rounding of the windows.
  static constexpr Real touching = 1e-13;
  // An arc is joined to one that begins within so many of the shortest of its end; or within a
  // share of the mesh's size, the chord of what a circle cuts off by going beyond a side that it
  // touches.
  static constexpr Real reach_of_joints = 1e3, reach_over_touching = 1e-6;
  // Straight borders of one segment differ in direction by less.
  static constexpr Real same_direction = 1e-6;

  /// A disc, seen in part of the face only; or a half-plane, whose border goes through `centre` and
  /// which lies against `up`. On its border are angles, or lengths.
  struct Disc {
    Vec2<Real> centre;
    Real radius;
    std::vector<HalfPlane<Real>> seen{};
    bool is_straight = false;
    Vec2<Real> up{0, 0};
    // The half-edge over which it is seen, from where to where along it. (Where the centre lies
    // beside that, lines from it do not tell.)
    Index over = -1;
    Real over_begin = 0, over_end = 0;

    [[nodiscard]] Vec2<Real> along() const { return {-up.y(), up.x()}; }
    [[nodiscard]] Vec2<Real> at(Real place) const {
      if (is_straight) return centre + place * along();
      return centre + radius * Vec2<Real>(std::cos(place), std::sin(place));
    }
    // How far inside a point is.
    [[nodiscard]] Real depth(const Vec2<Real>& p) const {
      return is_straight ? dot(up, centre - p) : radius - norm(p - centre);
    }
    [[nodiscard]] bool sees(const Vec2<Real>& p) const {
      return std::all_of(seen.begin(), seen.end(),
                         [&](const HalfPlane<Real>& half) { return half.height(p) >= 0; });
    }
  };
  struct Piece {
    Index face;
    Disc disc;
    Real from, width;       // where on the disc's border it begins, and how far it goes
    Vec2<Real> begin, end;  // in the frame of the face's first half-edge
    Vec3<Real> begin_in_space, end_in_space;
  };

  // --- the discs of a face -----------------------------------------------------------------------

  void for_each_face(const auto& visit) {
    for (Index f = 0; f < surface_.face_count(); ++f) {
      if (f % 1024 == 0) {
        cancelled_.check(static_cast<double>(f) / surface_.face_count(), "exact isolines");
      }
      if (is_thin(surface_, *solution_.faces, 3 * f)) continue;
      flat_ = FlatFace<Real>(surface_, *solution_.faces, f);
      find_discs();
      if (!discs_.empty()) visit(f);
    }
  }

  void find_discs() {
    discs_.clear();
    const Index v = surface_.face(flat_.face)[0];
    const Real level = static_cast<Real>(level_) - solution_.starts.at(v);
    require(level <= solution_.bound_at(v), "the level ", level_,
            " is beyond the greatest distance that was solved for");
    for (std::size_t k = 0; k < 3; ++k) {
      const Real radius = level - solution_.distances[surface_.face(flat_.face)[k]];
      if (radius > 0) discs_.push_back({flat_.corners[k], radius});
    }
    for (const auto& source : solution_.sources) add_source(source, level);
    for (const auto& front : solution_.fronts) {
      if (front.face == flat_.face) add_front(front, level);
    }
    for (Index h = 3 * flat_.face; h < 3 * flat_.face + 3; ++h) add_windows(h, level);
    unite_same();
  }

  // Circles that are the same but for rounding become so to the last bit, as the one that counts.
  // Else arcs of one would end on a side that another covers: where they just cross that, apart by
  // a root of rounding.
  void unite_same() {
    std::stable_sort(discs_.begin(), discs_.end(),
                     [](const Disc& a, const Disc& b) { return a.radius > b.radius; });
    for (std::size_t i = 1; i < discs_.size(); ++i) {
      Disc& disc = discs_[i];
      for (std::size_t k = 0; k < i && !disc.is_straight; ++k) {
        if (!is_same(discs_[k], disc)) continue;
        disc.centre = discs_[k].centre;
        disc.radius = discs_[k].radius;
        break;
      }
    }
  }

  void add_source(const Source<Real>& source, Real level) {
    const Real radius = level - source.distance;
    if (source.point.kind == Point::Kind::vertex || !(radius > 0)) return;
    for_each_place(surface_, source.point, [&](Index f, const std::array<Real, 3>& shares) {
      if (f == flat_.face) discs_.push_back({flat_.place(shares), radius});
    });
  }

  // Straight from a segment, on both sides.
  void add_front(const SegmentFront<Real>& front, Real level) {
    const Vec2<Real> a = flat_.place(front.begin), b = flat_.place(front.end),
                     way = stable_unit(b - a);
    const Real away = level - front.start;
    if (way.isZero(0) || !(away > 0)) return;
    for (const Real sign : {-1.0, 1.0}) {
      const Vec2<Real> up = sign * Vec2<Real>(-way.y(), way.x());
      Disc side{a + away * up, away, {}, true, up};
      side.seen = {{way, dot(way, a)}, {-way, -dot(way, b)}, {up, dot(up, a)}};
      discs_.push_back(std::move(side));
    }
  }

  [[nodiscard]] bool is_from_front(Index origin) const {
    using Kind = typename Origin<Real>::Kind;
    while (solution_.origins[origin].kind == Kind::crossing) {
      origin = solution_.origins[origin].previous;
    }
    return solution_.origins[origin].kind == Kind::front;
  }

  void add_windows(Index h, Real level) {
    solution_.windows->for_each(h, [&](const auto& w, std::ptrdiff_t count) {
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        const Real radius = level - solution_.origins[w.origin[i]].start;
        const Real gap = std::clamp(w.x[i], w.begin[i], w.end[i]) - w.x[i];
        if (!(radius > 0) || gap * gap + w.y[i] * w.y[i] >= radius * radius) continue;
        const Vec2<Real> centre = flat_.from_frame(h, {w.x[i], w.y[i]});
        Disc disc{centre, radius};
        // What only touches the side stays before it, as cut_by_side has it there.
        const bool is_straight = is_from_front(w.origin[i]);
        if (!is_straight && std::hypot(gap, w.y[i]) > radius - tangent_) continue;
        if (is_straight) {
          disc.is_straight = true;
          disc.up = stable_unit(flat_.from_frame(h, {(w.begin[i] + w.end[i]) / 2, 0}) - centre);
          disc.centre += radius * disc.up;
        }
        disc.seen = {right_of(centre, flat_.from_frame(h, {w.begin[i], 0})),
                     left_of(centre, flat_.from_frame(h, {w.end[i], 0}))};
        disc.over = h;
        disc.over_begin = w.begin[i];
        disc.over_end = w.end[i];
        discs_.push_back(disc);
      }
    });
  }

  // --- the arcs of a face ------------------------------------------------------------------------

  void find_arcs() {
    for (std::size_t i = 0; i < discs_.size(); ++i) find_arcs(i);
  }

  // Of what one disc's border is cut into by all others, what lies in no other disc.
  void find_arcs(std::size_t number) {
    const Disc& disc = discs_[number];
    const Real begin = disc.is_straight ? -4 * size_ : 0, end = disc.is_straight ? 4 * size_ : turn;
    cuts_.assign({begin, end});
    for (const HalfPlane<Real>& side : flat_.sides) cut_by_side(disc, side);
    for (const Disc& other : discs_) {
      for (const HalfPlane<Real>& half : other.seen) cut(disc, half.normal, half.offset);
      cut(disc, other);
    }
    std::sort(cuts_.begin(), cuts_.end());
    const Real least = disc.is_straight ? same_ : same_ / disc.radius;  // what is rounding
    const auto first = pieces_.size();
    // (Not `begin - 1`, which is `begin` on a mesh of 1e16.)
    constexpr Real none = -unreachable<Real>;
    Real from = 0, to = none;
    const auto finish = [&] {
      if (to > none) add_piece(disc, from, to - from);
      to = none;
    };
    for (std::size_t i = 0; i + 1 < cuts_.size(); ++i) {
      if (cuts_[i + 1] - cuts_[i] <= least) continue;
      if (!is_border(number, disc.at((cuts_[i] + cuts_[i + 1]) / 2))) {
        finish();
        continue;
      }
      if (to == none) from = cuts_[i];
      to = cuts_[i + 1];
    }
    finish();
    if (!disc.is_straight) join_over_zero(disc, first, least);
  }

  void cut(const Disc& disc, const Vec2<Real>& normal, Real offset) {
    const Real height = offset - dot(normal, disc.centre);
    if (disc.is_straight) {
      const Real slope = dot(normal, disc.along());
      if (slope != 0) add_cut(disc, height / slope);
      return;
    }
    const Real cosine = height / disc.radius;
    if (!(std::fabs(cosine) < 1)) return;
    const Real middle = std::atan2(normal.y(), normal.x()), half = std::acos(cosine);
    add_cut(disc, middle - half);
    add_cut(disc, middle + half);
  }

  // Whether a circle only touches a line at some height from its centre.
  [[nodiscard]] bool touches(const Disc& disc, Real height) const {
    return std::fabs(disc.radius - std::fabs(height)) < tangent_;
  }

  // By a side of the face. A circle that touches one stays on its side of it: how far it goes
  // beyond is rounding, whose root would be the length of an arc.
  void cut_by_side(const Disc& disc, const HalfPlane<Real>& side) {
    const Real height = side.offset - dot(side.normal, disc.centre);
    if (disc.is_straight || !touches(disc, height)) return cut(disc, side.normal, side.offset);
    const Vec2<Real> way = height > 0 ? side.normal : -side.normal;
    add_cut(disc, std::atan2(way.y(), way.x()));
  }

  // By another's border, unless it only touches.
  void cut(const Disc& disc, const Disc& other) {
    const Vec2<Real> way = other.centre - disc.centre;
    if (other.is_straight) {
      const Real height = dot(other.up, way);
      if (!disc.is_straight && std::fabs(std::fabs(height) - disc.radius) < tangent_) return;
      return cut(disc, other.up, dot(other.up, other.centre));
    }
    if (disc.is_straight) {
      const Real middle = dot(disc.along(), way), height = std::fabs(dot(disc.up, way));
      if (!(other.radius - height > tangent_)) return;
      const Real half = std::sqrt((other.radius - height) * (other.radius + height));
      add_cut(disc, middle - half);
      add_cut(disc, middle + half);
      return;
    }
    const Real gap = stable_norm(way), a = disc.radius, b = other.radius;
    const Real least =
        std::min({std::fabs(gap + a - b), std::fabs(gap + b - a), std::fabs(gap - a - b)});
    if (gap <= shortest * size_ || least < tangent_) return;
    const HalfPlane<Real> line = crossing(disc, other);
    cut(disc, line.normal, line.offset);
  }

  // The line on which two circles cross, up where the other lies farther out.
  [[nodiscard]] static HalfPlane<Real> crossing(const Disc& disc, const Disc& other) {
    const Vec2<Real> way = other.centre - disc.centre;
    const Real gap = stable_norm(way), a = disc.radius, b = other.radius;
    const Vec2<Real> normal = way / gap;
    // From the middle of this one along the line to the other.
    const Real along = (gap + (a - b) * (a + b) / gap) / 2;
    return {normal, along + dot(normal, disc.centre)};
  }

  void add_cut(const Disc& disc, Real place) {
    if (!disc.is_straight && place < 0) place += turn;
    if (!disc.is_straight && place >= turn) place -= turn;
    cuts_.push_back(place);
  }

  [[nodiscard]] bool is_same(const Disc& a, const Disc& b) const {
    if (a.is_straight != b.is_straight) return false;
    if (a.is_straight)
      return norm(a.up - b.up) < same_direction && std::fabs(a.depth(b.centre)) <= same_;
    const Real same = shortest * size_;
    return norm(a.centre - b.centre) <= same && std::fabs(a.radius - b.radius) <= same;
  }

  // Whether a disc lies in another or in a half-plane, touching it or not.
  [[nodiscard]] bool lies_in(const Disc& disc, const Disc& other) const {
    if (disc.is_straight) return false;
    if (other.is_straight) return disc.radius - other.depth(disc.centre) < tangent_;
    return norm(other.centre - disc.centre) + disc.radius - other.radius < tangent_;
  }

  // Whether a point of a disc's border is in another disc. Where depths are rounding the two touch
  // from within, which is the same at all points, or cross as flatly as that: then the line tells
  // that goes through where they cross.
  [[nodiscard]] bool is_hidden(const Disc& disc, const Disc& other, const Vec2<Real>& p) const {
    const Real depth = other.depth(p);
    if (std::fabs(depth) >= tangent_) return depth > 0;
    if (lies_in(disc, other)) return true;
    if (lies_in(other, disc)) return false;
    const bool are_circles = !disc.is_straight && !other.is_straight;
    return are_circles ? crossing(disc, other).height(p) > 0 : depth > 0;
  }

  [[nodiscard]] bool is_border(std::size_t number, const Vec2<Real>& p) const {
    const Disc& disc = discs_[number];
    if (!flat_.contains(p) || !disc.sees(p)) return false;
    for (std::size_t i = 0; i < discs_.size(); ++i) {
      if (i == number || !discs_[i].sees(p)) continue;
      if (is_same(discs_[i], disc) ? counts_before(i, number) : is_hidden(disc, discs_[i], p))
        return false;
    }
    return true;
  }

  // Of one border that is there twice the larger disc's counts, which is the one that lies outside
  // where they touch; of equal ones the first. One order for all, else none of three might count.
  [[nodiscard]] bool counts_before(std::size_t a, std::size_t b) const {
    const Disc &first = discs_[a], &second = discs_[b];
    if (first.is_straight || first.radius == second.radius) return a < b;
    return first.radius > second.radius;
  }

  void add_piece(const Disc& disc, Real from, Real width) {
    const Vec2<Real> begin = disc.at(from), end = disc.at(from + width);
    pieces_.push_back({flat_.face, disc, from, width, begin, end, flat_.in_space(surface_, begin),
                       flat_.in_space(surface_, end)});
  }

  // What ends at a whole turn goes on where it began.
  void join_over_zero(const Disc& disc, std::size_t first, Real least) {
    if (pieces_.size() < first + 2) return;
    const Piece head = pieces_[first], tail = pieces_.back();
    if (head.from > least || tail.from + tail.width < turn - least) return;
    pieces_.pop_back();
    pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(first));
    add_piece(disc, tail.from, turn - tail.from + head.from + head.width);
  }

  // --- the area within ---------------------------------------------------------------------------

  // Half of what x dy - y dx sums up to along the area's border, seen from some point: along its
  // arcs, and
  static Real area_beside(const Piece& piece, const Vec2<Real>& from) {
    const Real chord = cross_of(piece.begin - from, piece.end - from), a = piece.width;
    if (piece.disc.is_straight) return chord / 2;
    return (chord + piece.disc.radius * piece.disc.radius * (a - std::sin(a))) / 2;
  }

  // along the parts of the face's sides that are nearer than the level.
  [[nodiscard]] Real area_beside_edge(Index h, const Vec2<Real>& seen_from) {
    const auto k = static_cast<std::size_t>(h % 3);
    spans_.clear();
    for (const Disc& disc : discs_) {
      const Vec2<Real> from = flat_.corners[k] - disc.centre;
      Real begin = 0, end = surface_.length(h);
      const auto bound = [&](const HalfPlane<Real>& half) {
        const Real slope = dot(half.normal, flat_.ways[k]), at_zero = half.height(flat_.corners[k]);
        if (slope > 0) begin = std::max(begin, -at_zero / slope);
        if (slope < 0) end = std::min(end, -at_zero / slope);
        if (slope == 0 && at_zero < 0) end = begin;
      };
      if (disc.is_straight) {
        bound({-disc.up, -dot(disc.up, disc.centre)});
      } else {
        const Real middle = -dot(from, flat_.ways[k]), height = dot(flat_.sides[k].normal, from);
        const Real square = (disc.radius - height) * (disc.radius + height);
        if (!(square > 0) || touches(disc, height)) continue;
        begin = std::max(begin, middle - std::sqrt(square));
        end = std::min(end, middle + std::sqrt(square));
      }
      if (disc.over == h) {
        begin = std::max(begin, disc.over_begin);
        end = std::min(end, disc.over_end);
      } else {
        for (const HalfPlane<Real>& half : disc.seen) bound(half);
      }
      if (end > begin) spans_.emplace_back(begin, end);
    }
    std::sort(spans_.begin(), spans_.end());
    Real covered = 0, length = 0;
    for (const auto& [begin, end] : spans_) {
      length += std::max(Real(0), end - std::max(begin, covered));
      covered = std::max(covered, end);
    }
    return cross_of(flat_.corners[k] - seen_from, flat_.ways[k]) * length / 2;
  }

  // --- from arcs to lines ------------------------------------------------------------------------

  [[nodiscard]] std::vector<ExactIsoline<T>> linked() {
    first_piece_ = first_pieces(pieces_, surface_.face_count());
    const auto follower = [&](Index i, const Array<char>& is_taken) { return after(i, is_taken); };
    std::vector<ExactIsoline<T>> out;
    for (const Chain& chain : chains_of(static_cast<Index>(pieces_.size()), follower)) {
      ExactIsoline<T> line{{}, chain.is_closed};
      for (const Index k : chain.pieces) {
        line.arcs.push_back(arc_of(pieces_[static_cast<std::size_t>(k)]));
      }
      // Where a level is that of a vertex, what cuts off a corner is rounding, and in one face
      // only.
      if (line.is_closed || line.length() >= shortest_line * size_) out.push_back(std::move(line));
    }
    return out;
  }

  // The piece that begins nearest to where another ends: in the same face, or across the sides and
  // corners at which that is; -1 where there is none.
  [[nodiscard]] Index after(Index number, const Array<char>& is_taken) {
    const Piece& piece = pieces_[static_cast<std::size_t>(number)];
    const Real reach = std::max(reach_of_joints * same_, reach_over_touching * size_);
    flat_ = FlatFace<Real>(surface_, *solution_.faces, piece.face);
    Index best = -1;
    Real least = reach;
    const auto look = [&](Index f) {
      for (Index i = first_piece_[f]; i < first_piece_[f + 1]; ++i) {
        const Real gap =
            norm(pieces_[static_cast<std::size_t>(i)].begin_in_space - piece.end_in_space);
        // (A whole circle goes on with itself; a short arc only ends near where it begins.)
        if (is_taken[i] || !(gap < (i == number ? std::min(same_, least) : least))) continue;
        least = gap;
        best = i;
      }
    };
    look(piece.face);
    bool is_in_corner = false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(norm(piece.end - flat_.corners[k]) < reach)) continue;
      is_in_corner = true;
      for (const Index out : surface_.corners(surface_.face(piece.face)[k]))
        look(Mesh::face_of(out));
    }
    if (is_in_corner) return best;
    // Over sides; and over faces so thin that they hold no arc.
    faces_.assign(1, piece.face);
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const Index first = 3 * faces_[i];
      for (Index h = first; h < first + 3; ++h) {
        const Index f = Mesh::face_of(surface_.twin(h));
        if (!surface_.is_manifold(h) || std::find(faces_.begin(), faces_.end(), f) != faces_.end())
          continue;
        if (!(norm(from_side(h, piece.end_in_space)) < reach)) continue;
        look(f);
        faces_.push_back(f);
      }
    }
    return best;
  }

  // The way to a place from the nearest of a side.
  [[nodiscard]] Vec3<Real> from_side(Index h, const Vec3<Real>& place) const {
    const Vec3<Real>& begin = surface_.position(surface_.origin(h));
    const Vec3<Real> side = surface_.position(surface_.tip(h)) - begin, way = place - begin;
    const Real square = squared_norm(side);
    const Real share = square > 0 ? dot(way, side) / square : 0;
    return way - std::clamp(share, Real(0), Real(1)) * side;
  }

  [[nodiscard]] CircularArc<T> arc_of(const Piece& piece) {
    flat_ = FlatFace<Real>(surface_, *solution_.faces, piece.face);
    const bool is_straight = piece.disc.is_straight;
    const Real length = is_straight ? piece.width : piece.disc.radius * piece.width;
    return {piece.face,
            cast<T>(piece.begin_in_space),
            cast<T>(piece.end_in_space),
            cast<T>(flat_.in_space(surface_, piece.disc.centre)),
            is_straight ? unreachable<T> : static_cast<T>(piece.disc.radius),
            is_straight ? T(0) : static_cast<T>(piece.width),
            static_cast<T>(length)};
  }

  const WindowSolution<Real>& solution_;
  const Mesh& surface_;
  T level_;
  const CancelHook& cancelled_;
  Real size_ = 0;
  Real same_ = 0, tangent_ = 0;  // how long the shortest arcs are, and how near borders touch
  FlatFace<Real> flat_;          // the face at hand
  std::vector<Disc> discs_;
  std::vector<Real> cuts_;
  std::vector<std::pair<Real, Real>> spans_;
  std::vector<Piece> pieces_;
  std::vector<Index> faces_;
  Array<Index> first_piece_;  // of each face, and one more
};

}  // namespace gelight::detail
