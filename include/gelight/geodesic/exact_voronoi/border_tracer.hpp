#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <optional>
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
///   middle + cosh(s) ahead + sinh(s) aside.
/// So is a straight line, and the condition that such a point lies on one side of a line, or is
/// nearer to a third image, is linear in cosh(s) and sinh(s): e^s lies between two roots. What is
/// left of the whole branch are the pieces of the border. Angles about an image would not do: next
/// to one nearly as far they hardly change along the branch.
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
    size_ = size_of(surface_);
    same_ = shortest * size_;
    on_edge_ = nearest_to_edges * size_;
    equal_ = rounding_of_distances * size_;
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
      find_views();
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
  static constexpr Index not_known = -2;
  // As shares of the mesh's size: pieces shorter than this are rounding of where borders cross.
  static constexpr Real shortest = 1e-11;
  // An image that is nearer than another by no more than this, wherever it is, is as near.
  static constexpr Real rounding_of_distances = 1e-12;
  // The frames of two faces tell where a place is but for this.
  static constexpr Real rounding_of_places = 1e-13;
  // A point so near to an edge lies on it.
  static constexpr Real nearest_to_edges = 1e-12;
  // A piece is joined to one that begins within so many of the shortest of its end: where a line
  // goes through a vertex, pieces end where the vertex is nearer by rounding, which may be farther
  // from it by the root of that.
  static constexpr Real reach_of_joints = 1e3;
  // A piece is halved so often at most.
  static constexpr int most_halvings = 12;

  // A source or bend, as a face sees it.
  struct Image {
    Vec2<Real> centre;
    Real start;  // the distance there
    Index source;
  };
  // What lies between two lines.
  struct Wedge {
    HalfPlane<Real> right, left;
  };
  // An image, and where it is seen: in all of the face, or by way of some windows.
  struct View {
    Image image;
    bool is_seen_by_all = true;
    std::vector<Wedge> wedges{};
  };
  // The points as far from two images, by e = exp(s).
  struct Branch {
    Vec2<Real> middle, ahead, aside;
    Real half_gap, later;  // of the images, and half of what the second starts later by
    [[nodiscard]] Vec2<Real> at(Real e) const {
      return middle + (e + 1 / e) / 2 * ahead + (e - 1 / e) / 2 * aside;
    }
  };
  // The points of a branch with along . (cosh(s), sinh(s)) >= least.
  struct Condition {
    Vec2<Real> along;
    Real least;
  };
  struct Interval {
    Real from, to;  // of e, above zero
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
    Real doubt;         // how far from its end it may have to go on,
    Real doubt_beside;  // and how far along the edge on which that is
  };

  // A face at a piece's end, and the number of that from which it was come to.
  struct FaceAtEnd {
    Index face;
    std::size_t before;
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
    // (By pointers: of a vector's iterators not every standard library makes a span.)
    const Place* const places = places_of_sources_.data();
    const auto [first, last] =
        std::equal_range(places, places + places_of_sources_.size(), Place{f, -1, {}}, is_before);
    return {first, static_cast<std::size_t>(last - first)};
  }

  void find_views() {
    views_.clear();
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
      views_.push_back(
          {{flat_.corners[k], solution_.distances[corners[k]], source_of(corners[k])}});
    }
    for (const Place& place : sources_in(flat_.face)) {
      const Real start = solution_.sources[static_cast<std::size_t>(place.source)].distance;
      views_.push_back({{flat_.place(place.shares), start, place.source}});
    }
    for (Index h = 3 * flat_.face; h < 3 * flat_.face + 3; ++h) add_windows(h, farthest);
  }

  void add_windows(Index h, Real farthest) {
    const auto k = static_cast<std::size_t>(h % 3);
    const Vec2<Real>&along = flat_.ways[k], &up = flat_.sides[k].normal;
    solution_.windows->for_each(h, [&](const auto& w, std::ptrdiff_t count) {
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        const Real start = solution_.origins[w.origin[i]].start;
        const Real aside = std::clamp(w.x[i], w.begin[i], w.end[i]) - w.x[i];
        if (start + std::hypot(aside, w.y[i]) > farthest) continue;
        // Lines by the window's own numbers: in the face's the centre may lie on its end.
        const auto left = [&](Real by) {
          const Vec2<Real> way = stable_unit(Vec2<Real>((by - w.x[i]) * along - w.y[i] * up));
          const Vec2<Real> normal(-way.y(), way.x());
          return HalfPlane<Real>{normal, dot(normal, flat_.from_frame(h, {by, 0}))};
        };
        const HalfPlane<Real> not_right = left(w.begin[i]);
        add_wedge({flat_.from_frame(h, {w.x[i], w.y[i]}), start, source_of_origin(w.origin[i])},
                  {{-not_right.normal, -not_right.offset}, left(w.end[i])});
      }
    });
  }

  // Windows of one image are seen together, and a little wider: gaps between them are rounding.
  void add_wedge(const Image& image, Wedge wedge) {
    wedge.right.offset -= on_edge_;
    wedge.left.offset -= on_edge_;
    const auto same = std::find_if(views_.begin(), views_.end(), [&](const View& view) {
      return view.image.source == image.source &&
             std::fabs(view.image.start - image.start) <= equal_ &&
             stable_norm(view.image.centre - image.centre) <= equal_;
    });
    if (same == views_.end()) {
      views_.push_back({image, false, {wedge}});
    } else if (!same->is_seen_by_all) {
      same->wedges.push_back(wedge);
    }
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
    for (std::size_t i = 0; i < views_.size(); ++i) {
      for (std::size_t j = 0; j < views_.size(); ++j) {
        if (views_[i].image.source < views_[j].image.source) find_pieces(i, j);
      }
    }
  }

  // Between two images: where both are seen and no third one is nearer.
  void find_pieces(std::size_t i, std::size_t j) {
    if (covers(i, j) || covers(j, i)) return;
    const Image &first = views_[i].image, &second = views_[j].image;
    const Branch branch = branch_between(first, second);
    left_.assign(1, {0, unreachable<Real>});
    // A little beyond the face, lest a line along an edge is missed by the faces on both sides.
    keep_inside(branch, 2 * on_edge_);
    keep_seen(branch, views_[i]);
    keep_seen(branch, views_[j]);
    // That which left nothing the last time likely does so again.
    const auto drop = [&](std::size_t k) {
      if (left_.empty() || k == i || k == j || covers(i, k) || covers(j, k)) return;
      drop_nearer(i, j, k, branch);
      if (left_.empty()) nearest_ = k;
    };
    if (nearest_ < views_.size()) drop(nearest_);
    for (std::size_t k = 0; k < views_.size() && !left_.empty(); ++k) drop(k);
    if (left_.empty()) return;
    unite(left_);
    found_ = left_;
    for (const Interval& whole : found_) {
      const Index side = side_of(branch, whole);
      if (side >= 0 && !is_first_face_of(side)) continue;
      left_.assign(1, whole);
      if (side < 0) keep_inside(branch, 0);
      for (const Interval& piece : left_) add_piece(first, second, branch, piece);
    }
  }

  void keep_inside(const Branch& branch, Real beyond) {
    for (HalfPlane<Real> side : flat_.sides) {
      side.offset -= beyond;
      keep(beside(side, branch));
    }
  }

  // Leaves where an image is seen.
  void keep_seen(const Branch& branch, const View& view) {
    if (view.is_seen_by_all || left_.empty()) return;
    const std::vector<Interval> all = std::exchange(left_, {});
    for (const Wedge& wedge : view.wedges) {
      inside_ = all;
      std::vector<Interval> outside = std::exchange(left_, {});
      split(beside(wedge.right, branch));
      split(beside(wedge.left, branch));
      left_ = std::move(outside);
      left_.insert(left_.end(), inside_.begin(), inside_.end());
    }
    if (!left_.empty()) unite(left_);
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
    const Image &one = views_[a].image, &other = views_[b].image;
    const Real later = other.start - one.start;
    if (later < -equal_) return false;
    const Real gap = stable_norm(one.centre - other.centre);
    return gap <= later + equal_ && (a < b || !(gap <= equal_ - later));
  }

  // The cell of the first lies to the left of the direction in which s grows.
  [[nodiscard]] static Branch branch_between(const Image& first, const Image& second) {
    const Vec2<Real> way = second.centre - first.centre;
    const Real gap = stable_norm(way), later = second.start - first.start;
    const Vec2<Real> ahead = way / gap, aside(-ahead.y(), ahead.x());
    return {(first.centre + second.centre) / 2, later / 2 * ahead,
            std::sqrt(gap - later) * std::sqrt(gap + later) / 2 * aside, gap / 2, later / 2};
  }

  [[nodiscard]] static Condition beside(const HalfPlane<Real>& half, const Branch& branch) {
    return {{dot(half.normal, branch.ahead), dot(half.normal, branch.aside)},
            -half.height(branch.middle)};
  }

  // Where a third image is nearer than both, by the one to which it is closer: where it is hardly
  // anywhere else, it is rounding where they change places, but of what is left of both it is one
  // place. At a distance r from that one is a point p with
  //   way . p + sooner r >= (gap - sooner) (gap + sooner) / 2.
  [[nodiscard]] static Condition nearer(const Image& first, const Image& second, const Image& third,
                                        const Branch& branch) {
    const bool is_first =
        squared_norm(third.centre - first.centre) <= squared_norm(third.centre - second.centre);
    const Image& one = is_first ? first : second;
    const Real later = is_first ? branch.later : -branch.later;
    const Vec2<Real> way = third.centre - one.centre;
    const Real gap = stable_norm(way), sooner = (one.start - third.start) / gap;
    const Vec2<Real> ahead = way / gap;
    return {{dot(ahead, branch.ahead) + sooner * branch.half_gap, dot(ahead, branch.aside)},
            gap * (1 - sooner) * (1 + sooner) / 2 - dot(ahead, branch.middle - one.centre) -
                sooner * later};
  }

  void drop_nearer(std::size_t i, std::size_t j, std::size_t k, const Branch& branch) {
    const View& third = views_[k];
    inside_ = left_;
    left_.clear();
    if (!covers(k, i) && !covers(k, j)) {
      split(nearer(views_[i].image, views_[j].image, third.image, branch));
    }
    if (third.is_seen_by_all || inside_.empty()) return;
    std::vector<Interval> farther = std::exchange(left_, {});
    for (const Wedge& wedge : third.wedges) {
      split(beside(wedge.right, branch));
      split(beside(wedge.left, branch));
      inside_ = std::exchange(left_, {});
    }
    left_ = std::move(farther);
    left_.insert(left_.end(), inside_.begin(), inside_.end());
  }

  // Leaves what meets a condition.
  void keep(const Condition& condition) {
    inside_ = left_;
    split(condition);
    left_ = inside_;
  }

  // Of what is inside, what meets a condition stays; the rest is added to what is left.
  void split(const Condition& condition) {
    // With e = exp(s): rising e^2 - 2 least e + falling >= 0.
    const Vec2<Real>& along = condition.along;
    const Real size =
        std::max({std::fabs(along.x()), std::fabs(along.y()), std::fabs(condition.least)});
    if (!(size > 0)) return;
    const Real rising = (along.x() + along.y()) / size, falling = (along.x() - along.y()) / size;
    const Real least = condition.least / size, square = least * least - rising * falling;
    std::array<Real, 4> ends{0, unreachable<Real>, unreachable<Real>, unreachable<Real>};
    std::size_t roots = 0;
    const Real sum = least + std::copysign(std::sqrt(std::max(square, Real(0))), least);
    if (square > 0 && sum != 0) {
      for (const Real root : {sum / rising, falling / sum}) {
        if (root > 0 && root < unreachable<Real>) ends[++roots] = root;
      }
    }
    if (ends[2] < ends[1]) std::swap(ends[1], ends[2]);
    bool is_met =
        roots == 0 ? rising + falling >= 2 * least : falling > 0 || (falling == 0 && least < 0);
    scratch_.clear();
    for (std::size_t k = 0; k <= roots; ++k) {
      for (const Interval& interval : inside_) {
        const Interval both{std::max(interval.from, ends[k]), std::min(interval.to, ends[k + 1])};
        if (both.from < both.to) (is_met ? scratch_ : left_).push_back(both);
      }
      is_met = !is_met;
    }
    std::swap(inside_, scratch_);
  }

  // --- pieces ------------------------------------------------------------------------------------

  void add_piece(const Image& first, const Image& second, const Branch& branch,
                 const Interval& interval) {
    const Vec2<Real> begin = branch.at(interval.from), end = branch.at(interval.to);
    if (!(norm(end - begin) > same_)) return;
    const Real longest =
        std::max({surface_.length(3 * flat_.face), surface_.length(3 * flat_.face + 1),
                  surface_.length(3 * flat_.face + 2)});
    places_.assign(1, begin);
    add_places(branch, interval, begin, end, Real{options_.deviation} * longest, most_halvings);
    // Beside images close together a line is somewhere else at once, where they move by rounding.
    const Real slope = norm(stable_unit(end - first.centre) - stable_unit(end - second.centre));
    Piece piece{
        {first.source, second.source}, flat_.face, {}, {}, {}, equal_ / slope, doubt_beside(end)};
    piece.begin = flat_.in_space(surface_, begin);
    piece.end = flat_.in_space(surface_, end);
    for (const Vec2<Real>& p : places_) piece.points.push_back(point_at(p));
    pieces_.push_back(std::move(piece));
  }

  // How far from its end a piece may have to go on along the side at which that is. A line that
  // crosses it at a small angle is somewhere else on it at once by rounding; but not farther away
  // than it is long.
  [[nodiscard]] Real doubt_beside(const Vec2<Real>& end) const {
    const Vec2<Real> way = end - places_[places_.size() - 2];
    Real least = unreachable<Real>;  // how far it comes nearer to the side
    for (const HalfPlane<Real>& side : flat_.sides) {
      if (std::fabs(side.height(end)) <= on_edge_)
        least = std::min(least, std::fabs(dot(side.normal, way)));
    }
    return std::min(Real(1), rounding_of_places * size_ / least) * norm(way);
  }

  // The side of the face along which a piece lies, or -1.
  [[nodiscard]] Index side_of(const Branch& branch, const Interval& interval) const {
    const std::array<Vec2<Real>, 3> places{branch.at(interval.from), branch.at(middle_of(interval)),
                                           branch.at(interval.to)};
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

  [[nodiscard]] static Real middle_of(const Interval& interval) {
    return std::sqrt(interval.from) * std::sqrt(interval.to);
  }

  void add_places(const Branch& branch, const Interval& interval, const Vec2<Real>& begin,
                  const Vec2<Real>& end, Real deviation, int halvings) {
    const Real half = middle_of(interval);
    const Vec2<Real> middle = branch.at(half), way = end - begin;
    const Real beside = std::fabs(cross_of(way, middle - begin));
    if (halvings > 0 && beside > deviation * norm(way)) {
      add_places(branch, {interval.from, half}, begin, middle, deviation, halvings - 1);
      add_places(branch, {half, interval.to}, middle, end, deviation, halvings - 1);
    } else {
      places_.push_back(end);
    }
  }

  // What lies on a side or in a corner but for rounding is of it. The longest side tells where
  // along it a place is, however thin the face; the height over it is a share of the third corner.
  [[nodiscard]] Point point_at(const Vec2<Real>& p) const {
    std::size_t nearest = 0, longest = 0;
    std::array<Real, 3> heights{}, lengths{};
    for (std::size_t k = 0; k < 3; ++k) {
      heights[k] = flat_.sides[k].height(p);
      lengths[k] = surface_.length(3 * flat_.face + static_cast<Index>(k));
      if (heights[k] < heights[nearest]) nearest = k;
      if (lengths[k] > lengths[longest]) longest = k;
    }
    const bool is_on_side = heights[nearest] <= on_edge_;
    const std::size_t side = is_on_side ? nearest : longest, tip = (side + 1) % 3,
                      apex = (side + 2) % 3;
    std::array<Real, 3> shares{};
    if (is_on_side) {
      const Real along = dot(flat_.ways[side], p - flat_.corners[side]);
      const bool is_in_corner = std::min(along, lengths[side] - along) <= on_edge_;
      shares[tip] = is_in_corner ? Real(2 * along > lengths[side]) : along / lengths[side];
    } else {
      shares[apex] =
          std::min(Real(1), heights[side] / flat_.sides[side].height(flat_.corners[apex]));
      const Vec2<Real> foot = p - shares[apex] * (flat_.corners[apex] - flat_.corners[side]);
      const Real along = dot(flat_.ways[side], foot - flat_.corners[side]) / lengths[side];
      shares[tip] = std::clamp(along, Real(0), 1 - shares[apex]);
    }
    shares[side] = 1 - shares[tip] - shares[apex];
    return simplified(surface_, face_point(flat_.face, shares));
  }

  // --- from pieces to lines ----------------------------------------------------------------------

  [[nodiscard]] std::vector<VoronoiEdge<T>> linked() {
    first_piece_ = first_pieces(pieces_, surface_.face_count());
    const Array<Index> next = followers();
    const auto follower = [&](Index i, const Array<char>&) { return next[i]; };
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

  // One piece may follow on another, with a gap between.
  struct Joint {
    Index from, to;
    Real gap;
  };
  // A piece follows on another between the same sources if it begins where that ends, in the same
  // face or across the sides at which that is.
  [[nodiscard]] std::vector<Joint> joints() {
    std::vector<Joint> out;
    const auto count = static_cast<Index>(pieces_.size());
    for (Index number = 0; number < count; ++number) {
      const Piece& piece = pieces_[static_cast<std::size_t>(number)];
      const Point& end = piece.points.back();
      const Real reach = reach_of(piece);
      find_faces_at_end(piece);
      for (const auto& [f, before] : faces_at_end_) {
        for (Index i = first_piece_[f]; i < first_piece_[f + 1]; ++i) {
          const Piece& other = pieces_[static_cast<std::size_t>(i)];
          if (i == number || other.sources != piece.sources) continue;
          const bool is_beside =
              end.kind == Point::Kind::edge && is_of_same(end, other.points.front());
          const Real gap = norm(other.begin - piece.end);
          if (gap < (is_beside ? std::max(reach, piece.doubt_beside) : reach))
            out.push_back({number, i, gap});
        }
      }
    }
    return out;
  }
  // The piece that follows on each, or -1. Those with the least gap between them are joined first,
  // for pieces may be shorter than joints reach. What is left over beside a joint, such as one that
  // has been found twice at a vertex, goes in between.
  [[nodiscard]] Array<Index> followers() {
    std::vector<Joint> all = joints();
    std::stable_sort(all.begin(), all.end(),
                     [](const Joint& a, const Joint& b) { return a.gap < b.gap; });
    Array<Index> next(pieces_.size(), -1), last(pieces_.size(), -1);
    const auto join = [&](Index from, Index to) {
      next[from] = to;
      last[to] = from;
    };
    for (const Joint& joint : all) {
      if (next[joint.from] < 0 && last[joint.to] < 0) join(joint.from, joint.to);
    }
    for (const Joint& in : all) {
      const Index from = in.from, between = in.to, to = next[from];
      if (to < 0 || next[between] >= 0 || last[between] >= 0) continue;
      const bool goes_on = std::any_of(all.begin(), all.end(), [&](const Joint& out) {
        return out.from == between && out.to == to;
      });
      if (!goes_on) continue;
      join(from, between);
      join(between, to);
    }
    return next;
  }
  [[nodiscard]] Real reach_of(const Piece& piece) const {
    return std::max(reach_of_joints * same_, piece.doubt);
  }
  // A piece's face, and across sides that are within reach of its end those that share a corner
  // with it. (Sheets may lie on each other: where a face is in space does not tell.) Lines end at
  // edges of three faces and where orientation changes.
  void find_faces_at_end(const Piece& piece) {
    faces_at_end_.assign(1, {piece.face, 0});
    const auto add = [&](Index f, std::size_t before) {
      const auto is_f = [&](const FaceAtEnd& other) { return other.face == f; };
      if (std::none_of(faces_at_end_.begin(), faces_at_end_.end(), is_f) &&
          nearest_shared(piece.face, f, piece.end)) {
        faces_at_end_.push_back({f, before});
      }
    };
    const Real reach = reach_of(piece);
    for (std::size_t i = 0; i < faces_at_end_.size(); ++i) {
      const Index first = 3 * faces_at_end_[i].face;
      for (Index h = first; h < first + 3; ++h) {
        const Index t = surface_.twin(h);
        if (t == h || surface_.twin(t) != h || surface_.origin(t) == surface_.origin(h)) continue;
        const Point nearest = on_side(surface_.origin(h), surface_.tip(h), piece.end);
        if (norm(surface_.position(nearest) - piece.end) < reach) add(Mesh::face_of(t), i);
      }
    }
  }
  // Of the corner or side that two faces share the point that is nearest to a place.
  [[nodiscard]] std::optional<Point> nearest_shared(Index a, Index b,
                                                    const Vec3<Real>& near) const {
    const auto others = surface_.face(b);
    Index from = -1, to = -1;
    for (const Index v : surface_.face(a)) {
      if (std::find(others.begin(), others.end(), v) != others.end()) (from < 0 ? from : to) = v;
    }
    if (from < 0) return {};
    return to < 0 ? vertex_point<Real>(from) : on_side(from, to, near);
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
  // different faces points of the sides on the way are added.
  bool step_to(Index last, Index next) {
    const Piece &a = pieces_[static_cast<std::size_t>(last)],
                &b = pieces_[static_cast<std::size_t>(next)];
    const Point end = line_.back(), begin = b.points.front();
    if (is_of_same(end, begin)) return false;
    if (share_face(surface_, end, begin)) return true;
    find_faces_at_end(a);
    way_.clear();
    auto at = static_cast<std::size_t>(
        std::find_if(faces_at_end_.begin(), faces_at_end_.end(),
                     [&](const FaceAtEnd& other) { return other.face == b.face; }) -
        faces_at_end_.begin());
    for (; at > 0; at = faces_at_end_[at].before) way_.push_back(faces_at_end_[at].face);
    Index before = a.face;
    for (std::size_t i = way_.size(); i > 0; --i) {
      const Index face = way_[i - 1];
      const Point over = *nearest_shared(before, face, a.end);
      if (!is_of_same(line_.back(), over)) line_.push_back(over);
      before = face;
    }
    return true;
  }
  [[nodiscard]] static bool is_of_same(const Point& a, const Point& b) {
    return a.kind == b.kind && a.element == b.element;
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
  Real size_ = 0;
  // What counts as no length, as no way from an edge, and as no difference in distance.
  Real same_ = 0, on_edge_ = 0, equal_ = 0;
  FlatFace<Real> flat_;  // the face at hand
  std::vector<Place> places_of_sources_;
  std::vector<View> views_;
  std::size_t nearest_ = 0;  // of the views: that which was last nearer than two others
  std::vector<Interval> left_, inside_, scratch_, found_;
  std::vector<Vec2<Real>> places_;
  std::vector<Piece> pieces_;
  std::vector<Point> line_;
  std::vector<Index> way_;
  std::vector<FaceAtEnd> faces_at_end_;
  Array<Index> source_of_vertex_;
  Array<Index> first_piece_;  // of each face, and one more
};

}  // namespace gelight::detail
