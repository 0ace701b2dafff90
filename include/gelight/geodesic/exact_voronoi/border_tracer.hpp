#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <span>
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
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
template <std::floating_point T>
struct VoronoiEdge;
template <std::floating_point T>
struct VoronoiEdgeOptions;
}  // namespace gelight

namespace gelight::detail {

/// In each face sources are seen as images, places in its plane with a distance each, by the face's
/// windows. The points as far from two of them lie on a branch of a hyperbola, which is
///   1 / r = slope . u + constant
/// along the rays, of unit direction u, from the first. So is a straight line, and the condition
/// that such a point lies on one side of a line, or is nearer to a third image, is that u lies in
/// one arc of the circle. What is left of the whole turn are the pieces of the border.
template <std::floating_point T>
class BorderTracer {
 public:
  BorderTracer(const ExactField<T>& field, const VoronoiEdgeOptions<T>& options)
      : solution_(solution_of(field)), surface_(solution_.surface), options_(options) {
    require(solution_.keeps_all_windows(),
            "the field has not kept its windows: its solver needs the option keep_windows");
    require(solution_.fronts.empty(), "the field is of segments, not of points");
    require(!(solution_.bound < unreachable<Real>),
            "the field was solved up to a greatest distance or for some targets only");
    require(options.deviation > 0, "the deviation ", options.deviation, " is not positive");
    same_ = shortest * size_of(surface_);
    on_edge_ = nearest_to_edges * size_of(surface_);
    equal_ = rounding_of_distances * size_of(surface_);
  }

  [[nodiscard]] std::vector<VoronoiEdge<T>> lines() {
    find_sources();
    source_of_vertex_.assign(static_cast<std::size_t>(surface_.vertex_count()), not_known);
    for (Index f = 0; f < surface_.face_count(); ++f) {
      if (f % 1024 == 0) {
        options_.cancelled.check(static_cast<double>(f) / surface_.face_count(), "Voronoi edges");
      }
      if (is_thin(surface_, *solution_.faces, 3 * f) || !is_shared(f)) continue;
      flat_ = FlatFace<Real>(surface_, *solution_.faces, f);
      find_images();
      find_pieces();
    }
    return linked();
  }

 private:
  using Real = typename WorkingPrecision<T>::Real;
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;
  static constexpr Real turn = 2 * std::numbers::pi;
  static constexpr Index not_known = -2;
  // As shares of the mesh's size: pieces shorter than this are rounding of where borders cross.
  static constexpr Real shortest = 1e-11;
  // An image that is nearer than another by no more than this, wherever it is, is as near.
  static constexpr Real rounding_of_distances = 1e-12;
  // A point so near to an edge lies on it.
  static constexpr Real nearest_to_edges = 1e-12;
  // A piece is joined to one that begins within so many of the shortest of its end.
  static constexpr Real reach_of_joints = 1e3;
  // A piece is halved so often at most.
  static constexpr int most_halvings = 12;

  // A source or bend, as a face sees it: all of the face does, or what lies between two lines.
  struct Image {
    Vec2<Real> centre;
    Real start;  // the distance there
    Index source;
    bool is_seen_by_all = true;
    HalfPlane<Real> right{}, left{};
    Real from = 0, width = turn;         // the directions in which it is seen, as angles
    Vec2<Real> first{0, 0}, last{0, 0};  // and those at both ends, unit
  };
  // 1 / r = slope . u + constant, along rays of direction u.
  struct Polar {
    Vec2<Real> slope;
    Real constant;
    [[nodiscard]] Real at(const Vec2<Real>& u) const { return dot(slope, u) + constant; }
  };
  // The directions u with normal . u >= least.
  struct Condition {
    Vec2<Real> normal;
    Real least;
  };
  struct Interval {
    Real from, to;
  };
  // A source in a face.
  struct Place {
    Index face, source;
    std::array<Real, 3> shares;
  };
  struct Piece {
    std::array<Index, 2> sources;
    Index face;
    std::vector<Point> points;
    Vec3<Real> begin, end;
  };

  // --- the images of a face ----------------------------------------------------------------------

  // Those that are no vertices, by the faces that hold them.
  void find_sources() {
    for (std::size_t s = 0; s < solution_.sources.size(); ++s) {
      const Point& point = solution_.sources[s].point;
      if (point.kind == Point::Kind::vertex) continue;
      for_each_place(surface_, point, [&](Index f, const std::array<Real, 3>& shares) {
        places_of_sources_.push_back({f, static_cast<Index>(s), shares});
      });
    }
    std::stable_sort(places_of_sources_.begin(), places_of_sources_.end(),
                     [](const Place& a, const Place& b) { return a.face < b.face; });
  }

  // Whether a face may lie in more than one cell.
  [[nodiscard]] bool is_shared(Index f) {
    const Index source = source_of(surface_.face(f)[0]);
    bool is_shared = false;
    for (const Index v : surface_.face(f)) is_shared |= source_of(v) != source;
    for (const Place& place : sources_in(f)) is_shared |= place.source != source;
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      solution_.windows->for_each(h, [&](const auto& w, std::ptrdiff_t count) {
        for (std::ptrdiff_t i = 0; i < count && !is_shared; ++i) {
          is_shared = source_of_origin(w.origin[i]) != source;
        }
      });
    }
    return is_shared;
  }

  [[nodiscard]] std::span<const Place> sources_in(Index f) const {
    const auto is_before = [](const Place& a, const Place& b) { return a.face < b.face; };
    const auto [first, last] = std::equal_range(
        places_of_sources_.begin(), places_of_sources_.end(), Place{f, -1, {}}, is_before);
    return {first, last};
  }

  void find_images() {
    images_.clear();
    const auto corners = surface_.face(flat_.face);
    Real farthest = unreachable<Real>;  // no point of the face is farther
    for (std::size_t k = 0; k < 3; ++k) {
      const Real distance = solution_.distances[corners[k]];
      const Real longest = std::max(stable_norm(flat_.corners[(k + 1) % 3] - flat_.corners[k]),
                                    stable_norm(flat_.corners[(k + 2) % 3] - flat_.corners[k]));
      farthest = std::min(farthest, distance + longest);
    }
    if (!(farthest < unreachable<Real>)) return;
    for (std::size_t k = 0; k < 3; ++k) {
      images_.push_back(
          {flat_.corners[k], solution_.distances[corners[k]], source_of(corners[k]), true, {}, {}});
    }
    for (const Place& place : sources_in(flat_.face)) {
      const Real start = solution_.sources[static_cast<std::size_t>(place.source)].distance;
      images_.push_back({flat_.place(place.shares), start, place.source, true, {}, {}});
    }
    for (Index h = 3 * flat_.face; h < 3 * flat_.face + 3; ++h) add_windows(h, farthest);
  }

  void add_windows(Index h, Real farthest) {
    solution_.windows->for_each(h, [&](const auto& w, std::ptrdiff_t count) {
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        const Real start = solution_.origins[w.origin[i]].start;
        const Real aside = std::clamp(w.x[i], w.begin[i], w.end[i]) - w.x[i];
        if (start + std::hypot(aside, w.y[i]) > farthest) continue;
        const Vec2<Real> centre = flat_.from_frame(h, {w.x[i], w.y[i]});
        const Vec2<Real> begin = flat_.from_frame(h, {w.begin[i], 0});
        const Vec2<Real> end = flat_.from_frame(h, {w.end[i], 0});
        const Vec2<Real> first = end - centre, last = begin - centre;
        // From the window's own numbers: in the face's the centre may lie on the edge, or past it.
        const Real width =
            std::atan2(std::fabs(w.y[i]) * (w.end[i] - w.begin[i]),
                       (w.begin[i] - w.x[i]) * (w.end[i] - w.x[i]) + w.y[i] * w.y[i]);
        if (!(width > 0)) continue;
        images_.push_back({centre, start, source_of_origin(w.origin[i]), false,
                           right_of(centre, begin), left_of(centre, end),
                           std::atan2(first.y(), first.x()), width, stable_unit(first),
                           stable_unit(last)});
      }
    });
  }

  [[nodiscard]] Index source_of_origin(Index origin) {
    while (solution_.origins[origin].kind == Origin::Kind::crossing) {
      origin = solution_.origins[origin].previous;
    }
    const Origin& o = solution_.origins[origin];
    return o.kind == Origin::Kind::vertex ? source_of(o.index) : o.index;
  }

  // Of a vertex, by way of those at which its path bends.
  [[nodiscard]] Index source_of(Index vertex) {
    way_.clear();
    Index source = -1;
    // Every vertex on the way is nearer than the one before.
    for (Index left = surface_.vertex_count(); left > 0; --left) {
      if (source_of_vertex_[vertex] != not_known) {
        source = source_of_vertex_[vertex];
        break;
      }
      way_.push_back(vertex);
      const Arrival& last = solution_.arrivals[vertex];
      if (last.entry == Arrival::none) break;
      Index next = last.origin;
      if (last.entry >= 0) {
        Index origin = last.origin;
        while (solution_.origins[origin].kind == Origin::Kind::crossing) {
          origin = solution_.origins[origin].previous;
        }
        next = solution_.origins[origin].index;
        source = solution_.origins[origin].kind == Origin::Kind::source ? next : -1;
      } else if (last.entry == Arrival::from_source) {
        source = next;
      }
      if (source >= 0) break;
      vertex = next;
    }
    for (const Index v : way_) source_of_vertex_[v] = source;
    return source;
  }

  // --- the borders in a face ---------------------------------------------------------------------

  void find_pieces() {
    for (std::size_t i = 0; i < images_.size(); ++i) {
      for (std::size_t j = 0; j < images_.size(); ++j) {
        if (images_[i].source < images_[j].source) find_pieces(i, j);
      }
    }
  }

  // Between two images, seen from the first: where both are seen and no third one is nearer.
  void find_pieces(std::size_t i, std::size_t j) {
    const Image &first = images_[i], &second = images_[j];
    if (covers(i, j) || covers(j, i)) return;
    const Polar border = border_between(first, second);
    left_.assign(1, {first.from, first.from + first.width});
    keep({border.slope, -border.constant}, first);
    // And a little beyond the face, lest a line along an edge is missed by the faces on both sides.
    keep_inside(first, border, 2 * on_edge_);
    if (!second.is_seen_by_all) {
      keep(beside(second.right, first.centre, border), first);
      keep(beside(second.left, first.centre, border), first);
    }
    // That which left nothing the last time likely does so again.
    const auto drop = [&](std::size_t k) {
      if (left_.empty() || k == i || k == j || covers(i, k) || covers(j, k)) return;
      drop_nearer(i, j, k, border);
      if (left_.empty()) nearest_ = k;
    };
    if (nearest_ < images_.size()) drop(nearest_);
    for (std::size_t k = 0; k < images_.size() && !left_.empty(); ++k) drop(k);
    if (left_.empty()) return;
    unite(left_);
    found_ = left_;
    for (const Interval& whole : found_) {
      const Index side = side_of(first, border, whole);
      if (side >= 0 && !is_first_face_of(side)) continue;
      left_.assign(1, whole);
      if (side < 0) keep_inside(first, border, 0);
      for (const Interval& piece : left_) add_piece(first, second, border, piece);
    }
  }

  void keep_inside(const Image& first, const Polar& border, Real beyond) {
    for (HalfPlane<Real> side : flat_.sides) {
      side.offset -= beyond;
      keep(beside(side, first.centre, border), first);
    }
  }

  static void unite(std::vector<Interval>& intervals) {
    std::sort(intervals.begin(), intervals.end(),
              [](const Interval& a, const Interval& b) { return a.from < b.from; });
    std::size_t last = 0;
    for (std::size_t i = 1; i < intervals.size(); ++i) {
      if (intervals[i].from <= intervals[last].to) {
        intervals[last].to = std::max(intervals[last].to, intervals[i].to);
      } else {
        intervals[++last] = intervals[i];
      }
    }
    intervals.resize(last + 1);
  }

  // Whether an image is at least as near as another wherever both are seen. Of two that are the
  // same the first is.
  [[nodiscard]] bool covers(std::size_t a, std::size_t b) const {
    const Real later = images_[b].start - images_[a].start;
    if (later < -equal_) return false;
    const Real gap = stable_norm(images_[a].centre - images_[b].centre);
    return gap <= later + equal_ && (a < b || !(gap <= equal_ - later));
  }

  [[nodiscard]] static Polar border_between(const Image& a, const Image& b) {
    const Vec2<Real> way = b.centre - a.centre;
    const Real gap = stable_norm(way), ahead = a.start - b.start;
    const Real scale = 2 / ((gap - ahead) * (gap + ahead));
    return {scale * way, scale * ahead};
  }

  // Where a line's points, on rays from a centre, lie in a half-plane.
  [[nodiscard]] static Condition beside(const HalfPlane<Real>& half, const Vec2<Real>& centre,
                                        const Polar& line) {
    const Real height = half.height(centre);
    return {half.normal + height * line.slope, -height * line.constant};
  }

  void drop_nearer(std::size_t i, std::size_t j, std::size_t k, const Polar& border) {
    const Image &first = images_[i], &third = images_[k];
    inside_ = left_;
    left_.clear();
    if (!covers(k, i) && !covers(k, j)) {
      const Polar other = border_between(first, third);
      split({other.slope - border.slope, border.constant - other.constant}, first);
    }
    if (third.is_seen_by_all) return;
    split(beside(third.right, first.centre, border), first);
    split(beside(third.left, first.centre, border), first);
  }

  // Leaves what meets a condition.
  void keep(const Condition& condition, const Image& image) {
    inside_ = left_;
    split(condition, image);
    left_ = inside_;
  }

  // Of what is inside, what meets a condition stays; the rest is added to what is left. Angles are
  // those in which an image is seen.
  void split(const Condition& condition, const Image& image) {
    const auto [least, greatest] = range_of(condition.normal, image);
    if (condition.least <= least) return;
    if (condition.least >= greatest) {
      left_.insert(left_.end(), inside_.begin(), inside_.end());
      inside_.clear();
      return;
    }
    const Real size = stable_norm(condition.normal), begin = image.from;
    const Real half = std::acos(std::clamp(condition.least / size, Real(-1), Real(1)));
    Real from = std::atan2(condition.normal.y(), condition.normal.x()) - half;
    from -= turn * std::floor((from - begin) / turn);
    const Real to = from + 2 * half;
    scratch_.clear();
    for (const Interval& interval : inside_) {
      // The arc, and what of it goes on beyond a whole turn.
      Real rest = interval.from;
      for (const Interval& arc : {Interval{from - turn, to - turn}, Interval{from, to}}) {
        const Interval both{std::max(rest, arc.from), std::min(interval.to, arc.to)};
        if (!(both.from < both.to)) continue;
        if (rest < both.from) left_.push_back({rest, both.from});
        scratch_.push_back(both);
        rest = both.to;
      }
      if (rest < interval.to) left_.push_back({rest, interval.to});
    }
    std::swap(inside_, scratch_);
  }

  // The least and greatest of normal . u among the directions in which an image is seen.
  [[nodiscard]] static std::pair<Real, Real> range_of(const Vec2<Real>& normal,
                                                      const Image& image) {
    const Real size = stable_norm(normal);
    if (image.is_seen_by_all) return {-size, size};
    const Real a = dot(normal, image.first), b = dot(normal, image.last);
    const Real after_first = cross_of(image.first, normal),
               before_last = cross_of(normal, image.last);
    return {after_first < 0 && before_last < 0 ? -size : std::min(a, b),
            after_first > 0 && before_last > 0 ? size : std::max(a, b)};
  }

  // --- pieces ------------------------------------------------------------------------------------

  void add_piece(const Image& first, const Image& second, const Polar& border,
                 const Interval& angles) {
    const auto place = [&](Real angle) { return place_at(first, border, angle); };
    const Vec2<Real> begin = place(angles.from), end = place(angles.to);
    if (!(norm(end - begin) > same_)) return;
    const Real longest =
        std::max({surface_.length(3 * flat_.face), surface_.length(3 * flat_.face + 1),
                  surface_.length(3 * flat_.face + 2)});
    places_.assign(1, begin);
    add_places(place, angles, begin, end, Real{options_.deviation} * longest, most_halvings);
    Piece piece{{first.source, second.source}, flat_.face, {}, {}, {}};
    piece.begin = flat_.in_space(surface_, begin);
    piece.end = flat_.in_space(surface_, end);
    for (const Vec2<Real>& p : places_) piece.points.push_back(point_at(p));
    pieces_.push_back(std::move(piece));
  }

  [[nodiscard]] static Vec2<Real> place_at(const Image& first, const Polar& border, Real angle) {
    const Vec2<Real> u(std::cos(angle), std::sin(angle));
    return first.centre + u / border.at(u);
  }

  // The side of the face along which a piece lies, or -1.
  [[nodiscard]] Index side_of(const Image& first, const Polar& border,
                              const Interval& angles) const {
    const std::array<Vec2<Real>, 3> places{place_at(first, border, angles.from),
                                           place_at(first, border, (angles.from + angles.to) / 2),
                                           place_at(first, border, angles.to)};
    for (Index k = 0; k < 3; ++k) {
      const HalfPlane<Real>& side = flat_.sides[static_cast<std::size_t>(k)];
      const bool is_along = std::all_of(places.begin(), places.end(), [&](const Vec2<Real>& p) {
        return std::fabs(side.height(p)) <= on_edge_;
      });
      if (is_along) return 3 * flat_.face + k;
    }
    return -1;
  }
  [[nodiscard]] bool is_first_face_of(Index h) const {
    for (Index t = surface_.twin(h); t != h; t = surface_.twin(t)) {
      if (t < h && !is_thin(surface_, *solution_.faces, t)) return false;
    }
    return true;
  }

  void add_places(const auto& place, const Interval& angles, const Vec2<Real>& begin,
                  const Vec2<Real>& end, Real deviation, int halvings) {
    const Real half = (angles.from + angles.to) / 2;
    const Vec2<Real> middle = place(half), way = end - begin;
    const Real beside = std::fabs(cross_of(way, middle - begin));
    if (halvings > 0 && beside > deviation * norm(way)) {
      add_places(place, {angles.from, half}, begin, middle, deviation, halvings - 1);
      add_places(place, {half, angles.to}, middle, end, deviation, halvings - 1);
    } else {
      places_.push_back(end);
    }
  }

  // What lies on a side or in a corner but for rounding is of it.
  [[nodiscard]] Point point_at(const Vec2<Real>& p) const {
    std::array<Real, 3> shares{};
    Real sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const HalfPlane<Real>& opposite = flat_.sides[(k + 1) % 3];
      const Real height = opposite.height(p);
      shares[k] = height > on_edge_ ? height / opposite.height(flat_.corners[k]) : 0;
      sum += shares[k];
    }
    for (Real& share : shares) share /= sum;
    return simplified(surface_, face_point(flat_.face, shares));
  }

  // --- from pieces to lines ----------------------------------------------------------------------

  [[nodiscard]] std::vector<VoronoiEdge<T>> linked() {
    first_piece_ = first_pieces(pieces_, surface_.face_count());
    const auto follower = [&](Index i, const Array<char>& is_taken) { return after(i, is_taken); };
    std::vector<VoronoiEdge<T>> out;
    for (const Chain& chain : chains_of(static_cast<Index>(pieces_.size()), follower)) {
      const Index first = chain.pieces.front();
      line_.clear();
      Index last = -1;
      for (const Index k : chain.pieces) {
        add_to_line(last, k);
        last = k;
      }
      if (chain.is_closed) close_line(last, first);
      out.push_back(
          line_between(pieces_[static_cast<std::size_t>(first)].sources, chain.is_closed));
    }
    return out;
  }

  [[nodiscard]] VoronoiEdge<T> line_between(const std::array<Index, 2>& sources,
                                            bool is_closed) const {
    VoronoiEdge<T> line;
    line.is_closed = is_closed;
    for (std::size_t k = 0; k < 2; ++k) {
      const Array<Index>& left = solution_.starts.left;
      line.sources[k] = left.empty() ? sources[k] : left[sources[k]];
    }
    for (const Point& p : line_) line.points.push_back(p.template cast<T>());
    return line;
  }

  // The piece between the same sources that begins nearest to where another ends: in the same face,
  // or across the sides and corners at which that is; -1 where there is none.
  [[nodiscard]] Index after(Index number, const Array<char>& is_taken) const {
    const Piece& piece = pieces_[static_cast<std::size_t>(number)];
    Index best = -1;
    Real least = reach_of_joints * same_;
    const auto look = [&](Index f) {
      for (Index i = first_piece_[f]; i < first_piece_[f + 1]; ++i) {
        const Piece& other = pieces_[static_cast<std::size_t>(i)];
        const Real gap = norm(other.begin - piece.end);
        if (i == number || is_taken[i] || other.sources != piece.sources || !(gap < least))
          continue;
        least = gap;
        best = i;
      }
    };
    for (const Index v : surface_.face(piece.face)) {
      for (const Index h : surface_.corners(v)) look(Mesh::face_of(h));
    }
    return best;
  }

  // Adds a piece to the line, which ends with the one before.
  void add_to_line(Index before, Index number) {
    const std::vector<Point>& points = pieces_[static_cast<std::size_t>(number)].points;
    if (before >= 0 && !step_to(before, number)) line_.pop_back();
    line_.insert(line_.end(), points.begin(), points.end());
  }
  void close_line(Index last, Index first) {
    if (!step_to(last, first)) line_.pop_back();
    line_.push_back(line_.front());
  }

  // Whether the line's end and the beginning of the next piece are two points. Between two in
  // different faces a point of both is added: their corner, or where their side is nearest.
  bool step_to(Index last, Index next) {
    const Piece &a = pieces_[static_cast<std::size_t>(last)],
                &b = pieces_[static_cast<std::size_t>(next)];
    const Point end = line_.back(), begin = b.points.front();
    if (end.kind == begin.kind && end.element == begin.element) return false;
    if (share_face(surface_, end, begin)) return true;
    const auto corners = surface_.face(a.face), others = surface_.face(b.face);
    const auto is_shared = [&](Index v) {
      return std::find(others.begin(), others.end(), v) != others.end();
    };
    Index from = -1, to = -1;
    for (const Index v : corners) {
      if (is_shared(v)) (from < 0 ? from : to) = v;
    }
    if (from >= 0) line_.push_back(to < 0 ? vertex_point<Real>(from) : on_side(from, to, a.end));
    return true;
  }
  [[nodiscard]] Point on_side(Index from, Index to, const Vec3<Real>& near) const {
    const Vec3<Real> begin = surface_.position(from), way = surface_.position(to) - begin;
    const Real square = squared_norm(way);
    const Real share = square > 0 ? dot(near - begin, way) / square : 0;
    return simplified(surface_, edge_point(from, to, std::clamp(share, Real(0), Real(1))));
  }

  const WindowSolution<Real>& solution_;
  const Mesh& surface_;
  const VoronoiEdgeOptions<T>& options_;
  // What counts as no length, as no way from an edge, and as no difference in distance.
  Real same_ = 0, on_edge_ = 0, equal_ = 0;
  FlatFace<Real> flat_;  // the face at hand
  std::vector<Place> places_of_sources_;
  std::vector<Image> images_;
  std::size_t nearest_ = 0;  // of the images: that which was last nearer than two others
  std::vector<Interval> left_, inside_, scratch_, found_;
  std::vector<Vec2<Real>> places_;
  std::vector<Piece> pieces_;
  std::vector<Point> line_;
  std::vector<Index> way_;
  Array<Index> source_of_vertex_;
  Array<Index> first_piece_;  // of each face, and one more
};

}  // namespace gelight::detail
