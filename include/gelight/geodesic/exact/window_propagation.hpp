#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/lane.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/shadow.hpp"
#include "gelight/geodesic/exact/window_crossing.hpp"
#include "gelight/geodesic/exact/window_filters.hpp"
#include "gelight/geodesic/exact/window_list.hpp"
#include "gelight/geodesic/marching/indexed_heap.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// From where windows come: a source, a vertex at which paths bend, the crossing of an edge of
/// three faces or more, or a segment that they leave at a right angle.
template <std::floating_point Real>
struct Origin {
  enum class Kind : unsigned char { source, vertex, crossing, front };
  Real start;  // the distance there
  Kind kind;
  Index index;     // of the source, the vertex, the front, or the half-edge by which the edge was
                   // reached
  Index previous;  // of a crossing: the origin of the windows that cross
};

/// The last straight piece of the shortest known way to a vertex.
template <std::floating_point Real>
struct Arrival {
  /// What `entry` is where the piece lies in one face or along an edge.
  static constexpr Index from_source = -1, from_vertex = -2, none = -3;
  /// What `bend` is where the piece is straight.
  static constexpr Real straight = -1;

  Vec2<Real> image{0, 0};  // where the piece begins, unfolded into the frame of `entry`
  Index entry = none;      // the half-edge by which it enters its last face
  Index origin = -1;       // its origin; from_source: the source; from_vertex: the vertex
  // Where on `entry` the piece bends, at the end of a window: rounding, or a vertex in the middle
  // of an edge.
  Real bend = straight;

  [[nodiscard]] bool is_straight() const { return bend < 0; }
};

template <std::floating_point Real>
struct PropagationLimits {
  /// A point to be reached: the corners of where it lies, and its distance from each.
  struct Target {
    std::array<Index, 3> corners;
    std::array<Real, 3> gaps;
  };

  /// A limit as distances at a vertex count, given what those count from. Rounded up, lest a
  /// target itself is beyond.
  [[nodiscard]] static Real counted_from(const Array<Real>& starts, Real limit, Index v) {
    if (starts.empty() || limit == unreachable<Real>) return limit;
    return limit - starts[v] + rounding * (std::fabs(limit) + std::fabs(starts[v]));
  }

  Real distance = unreachable<Real>;
  Array<SegmentFront<Real>> fronts;  // segments that waves leave at a right angle
  Real size = 0;                     // of the mesh, where there are any
  // What distances count from at each vertex, where that differs.
  const Array<Real>* starts = nullptr;
  Array<Target> targets;  // propagation ends when all of these are known
  CancelHook cancelled;
  std::size_t memory = std::numeric_limits<std::size_t>::max();  // that windows may take, in bytes
  bool keep_windows = false;                                     // of all faces, or
  Array<char> faces_to_keep;                                     // of those marked, where not empty
  Array<Real> rest;  // of each vertex, where not empty: the least way left from there
  // Where there is one, windows serve to reach it alone: the least way left is straight to it.
  const SurfacePoint<Real>* goal = nullptr;
  Real ring = unreachable<Real>;  // at every multiple of it paths go through a vertex
};

/// What propagation did, for benchmarks.
struct PropagationCounts {
  std::ptrdiff_t lists = 0, loaded = 0, propagated = 0, created = 0;
};

/// Propagates windows from sources over a surface, whole lists of a half-edge at once and in the
/// order of the vertices, as Qin, Han, Yu, Yu, Liu 2016 do (doi:10.1145/2897824.2925930). The
/// windows of a list are kept apart where one reaches the edge sooner than another, as in
/// Mitchell, Mount, Papadimitriou 1987 (doi:10.1137/0216045), so that few outlive their use; and
/// dropped where a vertex of the edge is the shorter way (Xin, Wang 2009,
/// doi:10.1145/1559755.1559761).
///
/// Distances only ever shrink towards the true ones, so that the order of propagation is a matter
/// of speed alone.
template <std::floating_point Real>
class WindowPropagation {
 public:
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;
  using Limits = PropagationLimits<Real>;
  using WindowStore = detail::WindowStore<Real>;
  using WindowColumns = detail::WindowColumns<Real>;

  Array<Real> distances;    // of each vertex
  Array<Arrival> arrivals;  // of each vertex
  Array<Origin> origins;
  WindowStore kept;  // windows that were propagated, by the half-edge by which they entered a face
  PropagationCounts counts;
  Array<typename Limits::Target> target_memory;  // for the limits of a later run

  /// Beyond this distance nothing was computed; and as it counts at a vertex.
  ///@{
  [[nodiscard]] Real bound() const { return bound_; }
  [[nodiscard]] Real bound_at(Index v) const {
    return limits_->starts ? Limits::counted_from(*limits_->starts, bound_, v) : bound_;
  }
  ///@}

  /// What windows take, and the places from which they come, in bytes.
  [[nodiscard]] std::size_t bytes() const {
    return waiting_.bytes() + kept.bytes() + origins.size() * sizeof(Origin);
  }

  /// Whether windows are kept, all or some.
  [[nodiscard]] bool keeps_any() const {
    return limits_->keep_windows || !limits_->faces_to_keep.empty();
  }

  void run(const Surface<Real>& surface, const PlanarFaces<Real>& faces,
           const Array<Source<Real>>& sources, const Limits& limits) {
    // Making room for a million vertices takes as long as some thousand polls; so ask before it,
    // too.
    limits_ = &limits;
    ask(0);
    reset(surface, faces, sources, limits);
    propagate_sources(sources);
  }

  /// The same from further sources, where they are nearer than those of the run before: distances
  /// only ever fall, and arrivals are those of this run alone, so that `came_nearer` tells which
  /// vertices they reached.
  void run_further(const Array<Source<Real>>& sources, const Limits& limits) {
    limits_ = &limits;
    ask(0);
    for (const Index v : reached_) {
      arrivals[v] = {};
      settled_[v] = 0;
    }
    reached_.clear();
    is_done_ = false;
    is_further_ = true;
    prepare(sources, limits);
    propagate_sources(sources);
  }

  /// Vertices that had their turn in the last run; in a further one some only lie at the edge of
  /// it.
  [[nodiscard]] const Array<Index>& reached() const { return reached_; }
  /// Whether the last run brought a vertex nearer.
  [[nodiscard]] bool came_nearer(Index vertex) const {
    return arrivals[vertex].entry != Arrival::none;
  }

 private:
  void propagate_sources(const Array<Source<Real>>& sources) {
    for (std::size_t s = 0; s < sources.size(); ++s) add_source(sources[s], static_cast<Index>(s));
    for (std::size_t i = 0; i < limits_->fronts.size(); ++i) {
      add_front(limits_->fronts[i], static_cast<Index>(i));
    }
    const auto vertices = static_cast<double>(surface_->vertex_count());
    for (int pops = 0; !heap_.empty(); ++pops) {
      if (pops % pops_between_polls == 0) ask(static_cast<double>(reached_.size()) / vertices);
      const Index vertex = heap_.pop();
      expect_corners();
      settle(vertex);
      expect_faces();
      propagate_active();
    }
    update_bound();
    is_done_ = true;
  }

  using Mesh = Surface<Real>;
  using PlanarFaces = detail::PlanarFaces<Real>;
  static constexpr int pops_between_polls = 256;
  // Meshes of every kind take one or two lists per half-edge for a whole solve. What goes on after
  // so many in one turn, in which no vertex came nearer, goes round a tube of no girth, at no
  // length, and finds nothing more.
  static constexpr std::ptrdiff_t most_lists_per_halfedge = 2;
  static constexpr unsigned char most_times_nearer = 50;
  // What the radius of a segment's wave leaves in doubt, as a share of the mesh's size.
  static constexpr Real front_rounding = 0x1p-31;
  // What is not clearly shorter is by this share.
  static constexpr Real tie = 0.6 * (1 - clearly_shorter);
  // What unfolding leaves in doubt of a path's direction, in radians; where it is short in its last
  // face, as much more as that is shorter than the edge before.
  static constexpr Real angle_rounding = 1e-12;
  // A line that begins within this share of an edge from a vertex leaves gaps behind it that are
  // more than rounding of distances.
  static constexpr Real beside_vertex = 1e-5;
  // An image no farther than this share of the edge from a point of it is that point, but for
  // rounding.
  static constexpr Real on_edge = 16 * std::numeric_limits<Real>::epsilon();

  void ask(double done) const { limits_->cancelled.check(done, "the exact solve"); }

  void reset(const Mesh& surface, const PlanarFaces& faces, const Array<Source<Real>>& sources,
             const Limits& limits) {
    surface_ = &surface;
    faces_ = &faces;
    forget_vertices(surface.vertex_count(), std::exchange(is_further_, false));
    most_lists_ = most_lists_per_halfedge * surface.halfedge_count();
    longest_edge_ = faces.longest_edge();
    prepare(sources, limits);
  }

  void prepare(const Array<Source<Real>>& sources, const Limits& limits) {
    sources_ = &sources;
    bound_ = limits.distance;
    origins.clear();
    if (keeps_any() || kept.bytes() > 0) kept.reset(surface_->halfedge_count());
    counts = {};
    waiting_.reset(surface_->halfedge_count());
    if (counts_times()) times_nearer_.assign(distances.size(), 0);
    active_.clear();
    settled_since_bound_ = 0;
  }

  // As nothing is known of any vertex; in time proportional to those that the last run reached,
  // where it came to its end on a mesh of this size.
  void forget_vertices(Index count, bool was_further) {
    if (is_done_ && !was_further && std::ssize(distances) == count) {
      for (const Index v : reached_) {
        distances[v] = unreachable<Real>;
        arrivals[v] = {};
        settled_[v] = 0;
      }
    } else {
      const auto vertices = static_cast<std::size_t>(count);
      distances.assign(vertices, unreachable<Real>);
      arrivals.assign(vertices, {});
      settled_.assign(vertices, 0);
      heap_.reset(count);
      is_active_.assign(static_cast<std::size_t>(surface_->halfedge_count()), 0);
    }
    reached_.clear();
    is_done_ = false;
  }

  // --- sources -------------------------------------------------------------------------------

  void add_source(const Source<Real>& source, Index number) {
    using Kind = typename SurfacePoint<Real>::Kind;
    const auto& [a, b] = source.point.element;
    const auto& w = source.point.weights;
    if (source.point.kind == Kind::vertex) {
      return arrive(a, source.distance, {{0, 0}, Arrival::from_source, number});
    }
    const Index origin = add_origin({source.distance, Origin::Kind::source, number, -1});
    if (source.point.kind == Kind::face) return add_source_in_face(3 * a, w, origin);
    const Index first = surface_->find_halfedge(a, b);
    Index h = first;
    do {
      const bool same = surface_->origin(h) == a;
      add_source_in_face(h, {w[same ? 0 : 1], w[same ? 1 : 0], 0}, origin);
      h = surface_->twin(h);
    } while (h != first);
  }

  // A source in h's face with these shares of h's origin, tip and apex. Its places are counted from
  // each of the corners, so that those of a corner next to it lose nothing.
  void add_source_in_face(Index h, std::array<Real, 3> shares, Index origin) {
    const Arrival arrival{{0, 0}, Arrival::from_source, origins[origin].index};
    const Real start = origins[origin].start;
    for (int side = 0; side < 3; ++side) {
      const Real length = surface_->length(h);
      const Vec2<Real>& apex = faces_->apex(h);
      const auto [at_origin, at_tip, at_apex] = shares;
      const Real y = at_apex * apex.y();
      arrive(surface_->origin(h), start + std::hypot(at_tip * length + at_apex * apex.x(), y),
             arrival);
      // A source on h is seen from the other faces by their own call.
      if (at_apex > 0) {
        const Vec2<Real> apex_from_tip = faces_->apex_from_tip(*surface_, h);
        emit(h, {at_origin * length + at_apex * apex_from_tip.x(), y}, 0, length, origin);
      }
      h = Mesh::next(h);
      std::rotate(shares.begin(), shares.begin() + 1, shares.end());
    }
  }

  // A wave that leaves a segment at a right angle, as circles about centres so far away that they
  // are straight but for 2^-31 of the mesh's size, a few side by side where the segment is long.
  // Its corners and ends are reached from points of the segment, which are sources. The wave starts
  // late by what rounding can take off so large a radius: else it would seem to be before its own
  // ends, and their windows, which hold the ways beside the wave, would be dropped.
  void add_front(const SegmentFront<Real>& front, Index number) {
    constexpr Real far = 1 << 19, widest = 0.04, late = 4 * std::numeric_limits<Real>::epsilon();
    const Real away = far * limits_->size;
    const Index origin =
        add_origin({front.start - away * (1 - late), Origin::Kind::front, number, -1});
    for (Index h = 3 * front.face; h < 3 * front.face + 3; ++h) {
      const Vec2<Real> a = faces_->place(*surface_, h, front.begin);
      const Vec2<Real> b = faces_->place(*surface_, h, front.end);
      const Vec2<Real> way = b - a;
      const Real width = stable_norm(way);
      if (!(width > 0) || way.x() == 0 || (a.y() == 0 && b.y() == 0)) continue;
      // Towards the side.
      const Vec2<Real> across = Vec2<Real>(way.y(), -way.x()) / (way.x() > 0 ? width : -width);
      const auto pieces = static_cast<int>(std::ceil(width / (widest * limits_->size)));
      for (int i = 0; i < pieces; ++i) {
        const Vec2<Real> from = a + way * (static_cast<Real>(i) / pieces);
        const Vec2<Real> to = a + way * (static_cast<Real>(i + 1) / pieces);
        const Vec2<Real> centre = (from + to) / 2 - away * across;
        // So nearly along the side that no more than rays from the piece's ends reach it.
        if (!(centre.y() > std::max(from.y(), to.y()))) continue;
        const Real length = surface_->length(h);
        const Real first = std::clamp(crossing_from(from, centre), Real(0), length);
        const Real last = std::clamp(crossing_from(to, centre), Real(0), length);
        if (first == last) continue;
        emit(h, {length - centre.x(), centre.y()}, std::min(first, last), std::max(first, last),
             origin);
      }
    }
  }

  // Where the line to a place from a centre beyond it meets the axis.
  static Real crossing_from(const Vec2<Real>& at, const Vec2<Real>& centre) {
    return at.x() + (at.x() - centre.x()) * (at.y() / (centre.y() - at.y()));
  }

  [[nodiscard]] Vec2<Real> tip(Index h) const { return {surface_->length(h), 0}; }

  // A point in the frame with origin a and x towards b.
  static Vec2<Real> into_frame(const Vec2<Real>& p, const Vec2<Real>& a, const Vec2<Real>& b) {
    const Vec2<Real> along = stable_unit(b - a), from = p - a;
    return {dot(along, from), along.x() * from.y() - along.y() * from.x()};
  }

  // A window over part of half-edge h, seen from a point of its own face; that counts from h's tip
  // back along it, as the faces across see it.
  void emit(Index h, const Vec2<Real>& from_tip, Real begin, Real end, Index origin) {
    const Real length = surface_->length(h);
    if (length == 0 || surface_->is_border(h)) return;
    const typename WindowStore::Batch batch = waiting_.allocate(1);
    const WindowColumns& w = batch.windows;
    w.begin[0] = length - end;
    w.end[0] = length - begin;
    w.x[0] = from_tip.x();
    w.y[0] = std::min(-from_tip.y(), -on_line * length);
    w.origin[0] = origin;
    deliver(h, batch, 1);
  }

  Index add_origin(const Origin& origin) {
    origins.push_back(origin);
    return static_cast<Index>(origins.size() - 1);
  }

  // --- vertices ------------------------------------------------------------------------------

  // Improvements within rounding are left: they would only set the neighbours off again.
  [[nodiscard]] bool improves(Index vertex, Real distance) const {
    const Real known = distances[vertex];
    return distance * (1 + rounding) < known || (distance < known && known == unreachable<Real>);
  }

  void arrive(Index vertex, Real distance, const Arrival& last) {
    if (improves(vertex, distance)) set(vertex, distance, last);
  }

  void set(Index vertex, Real distance, const Arrival& last) {
    lists_in_turn_ = 0;
    distances[vertex] = distance;
    arrivals[vertex] = last;
    heap_.push(vertex, distance);
  }

  // The vertex whose turn is likely to be next: where its corners lie, and what is looked at of
  // each of its faces. Each fetch needs what the one before it fetched, so other work is between.
  [[gnu::always_inline]] void expect_corners() const {
    if (heap_.empty()) return;
    const auto corners = surface_->corners(heap_.top());
    prefetch(corners.data(), corners.size() * sizeof(Index));
  }
  [[gnu::always_inline]] void expect_faces() const {
    if (heap_.empty()) return;
    for (const Index out : surface_->corners(heap_.top())) {
      surface_->expect(out);
      faces_->expect(out);
      waiting_.expect(out);
    }
  }

  void settle(Index vertex) {
    lists_in_turn_ = 0;
    // Looking at all targets costs as much as they are many.
    if (++settled_since_bound_ > std::ssize(limits_->targets)) update_bound();
    const bool is_passed_by = is_further_ && !came_nearer(vertex);
    if (!is_passed_by && distances[vertex] + rest_at_vertex(vertex) <= bound_at(vertex)) {
      leave(vertex);
    }
    if (settled_[vertex]) return;
    settled_[vertex] = 1;
    reached_.push_back(vertex);
    for (const Index out : surface_->corners(vertex)) {
      activate(out);
      activate(Mesh::previous(out));
    }
  }

  // Along the edges from a vertex; and in all directions where paths can bend there.
  void leave(Index vertex) {
    const Real distance = distances[vertex];
    for (const Index out : surface_->corners(vertex)) {
      const Index in = Mesh::previous(out);
      go_along(out, vertex, surface_->tip(out));
      go_along(in, vertex, surface_->origin(in));
    }
    if (is_at_source(vertex)) {
      emit_everywhere(vertex, {distance, Origin::Kind::source, arrivals[vertex].origin, -1});
    } else if (is_behind_ring(vertex) || begins_next_to(vertex)) {
      emit_everywhere(vertex, {distance, Origin::Kind::vertex, vertex, -1});
    } else if (faces_->bends_at(vertex)) {
      bend(vertex, {distance, Origin::Kind::vertex, vertex, -1});
    }
  }

  // The distance at the beginning of the last piece of a way.
  [[nodiscard]] Real start_of(const Arrival& last) const {
    if (last.entry >= 0) return origins[last.origin].start;
    if (last.entry == Arrival::from_vertex) return distances[last.origin];
    return (*sources_)[static_cast<std::size_t>(last.origin)].distance;
  }

  // Whether the last piece of a vertex' path begins next to it. How the lines from there pass the
  // vertex on its two sides is then rounding, and a gap between them may be left; ways by the
  // vertex close it, and are no longer.
  [[nodiscard]] bool begins_next_to(Index vertex) const {
    const Real piece = distances[vertex] - start_of(arrivals[vertex]);
    if (piece > beside_vertex * longest_edge_) return false;
    const auto corners = surface_->corners(vertex);
    return std::any_of(corners.begin(), corners.end(), [&](Index out) {
      const Index in = Mesh::previous(out);
      return piece <= beside_vertex * std::max(surface_->length(out), surface_->length(in));
    });
  }

  // Whether a ring lies between a vertex and the beginning of the last piece of its path.
  [[nodiscard]] bool is_behind_ring(Index vertex) const {
    const Arrival& last = arrivals[vertex];
    if (limits_->ring == unreachable<Real>) return false;
    return distances[vertex] >= next_ring(start_of(last));
  }

  [[nodiscard]] Real next_ring(Real distance) const {
    return (std::floor(distance / limits_->ring) + 1) * limits_->ring;
  }

  void go_along(Index h, Index from, Index to) {
    const Real length = surface_->length(h), distance = distances[from] + length;
    // Vertices at one place have one distance, to the last bit.
    const bool is_less = length == 0 ? distance < distances[to] : improves(to, distance);
    if (is_less) set(to, distance, {{0, 0}, Arrival::from_vertex, from});
  }

  void emit_everywhere(Index vertex, const Origin& from) {
    const Index origin = add_origin(from);
    for (const Index out : surface_->corners(vertex)) {
      const Index h = Mesh::next(out);
      emit_from_apex(h, 0, surface_->length(h), origin);
    }
  }

  // Into the shadow of a vertex where the path's last piece is known, else in all directions.
  void bend(Index vertex, const Origin& from) {
    const Arrival& last = arrivals[vertex];
    const bool is_plain = faces_->bend(vertex) == PlanarFaces::Bend::saddle;
    if (!is_plain || !last.is_straight() || last.entry == Arrival::from_source) {
      return emit_everywhere(vertex, from);
    }
    Index corner = -1;
    Vec2<Real> back;
    Real doubt = angle_rounding;
    if (last.entry >= 0) {
      const Vec2<Real>&image = last.image, &apex = faces_->apex(last.entry);
      const Vec2<Real> entry(straight_crossing(image.x(), image.y(), apex.x(), apex.y()), 0);
      corner = Mesh::previous(last.entry);
      back = into_frame(image, apex, {0, 0});
      doubt += angle_rounding * surface_->length(last.entry) / stable_norm(apex - entry);
      back = stable_unit(back);
    } else {
      std::tie(corner, back) = edge_from(vertex, last.origin);
    }
    // Arriving over no way, as in a face without area, a path may have bent at the same place.
    if (!(doubt < 1)) return emit_everywhere(vertex, from);
    const Index origin = add_origin(from);
    Shadow<Real>(*surface_, *faces_, vertex, doubt)
        .cast(corner, back,
              [&](Index h, Real begin, Real end) { emit_from_apex(h, begin, end, origin); });
  }

  // The edge between two vertices, as a direction at the first.
  [[nodiscard]] std::pair<Index, Vec2<Real>> edge_from(Index vertex, Index other) const {
    for (const Index out : surface_->corners(vertex)) {
      if (surface_->tip(out) == other) return {out, {1, 0}};
      if (surface_->apex(out) == other) return {out, normalized(faces_->apex(out))};
    }
    return {-1, {0, 0}};
  }

  // A window over part of h, seen from the vertex across h's own face, unless it is of no use.
  void emit_from_apex(Index h, Real begin, Real end, Index origin) {
    if (is_useless(h, origins[origin].start)) return;
    emit(h, faces_->apex_from_tip(*surface_, h), begin, end, origin);
  }

  [[nodiscard]] bool is_at_source(Index vertex) const {
    if (arrivals[vertex].entry != Arrival::from_source) return false;
    const auto& point = (*sources_)[static_cast<std::size_t>(arrivals[vertex].origin)].point;
    return point.kind == SurfacePoint<Real>::Kind::vertex && point.element[0] == vertex;
  }

  // Whether every point of h is reached sooner along h than from the apex at a distance; see
  // drop_useless.
  [[nodiscard]] bool is_useless(Index h, Real distance) const {
    const Real to_origin = distance + surface_->length(Mesh::previous(h));
    const Real to_tip = distance + surface_->length(Mesh::next(h));
    const Real length = surface_->length(h);
    return distances[surface_->origin(h)] + length < to_tip * clearly_shorter ||
           distances[surface_->tip(h)] + length < to_origin * clearly_shorter;
  }

  // No target is farther than by way of one of its corners.
  void update_bound() {
    settled_since_bound_ = 0;
    if (limits_->targets.empty()) return;
    Real farthest = 0;
    for (const auto& target : limits_->targets) {
      Real nearest = unreachable<Real>;
      for (std::size_t k = 0; k < 3; ++k) {
        const Index corner = target.corners[k];
        const Real start = limits_->starts ? (*limits_->starts)[corner] : 0;
        nearest = std::min(nearest, start + distances[corner] + target.gaps[k]);
      }
      farthest = std::max(farthest, nearest);
    }
    bound_ = std::min(limits_->distance, farthest);
  }

  // --- the queue of half-edges -----------------------------------------------------------------

  void activate(Index h) {
    if (waiting_.empty(h) || is_active_[h]) return;
    is_active_[h] = 1;
    active_.push_back(h);
  }

  void propagate_active() {
    for (std::ptrdiff_t i = 0; i < std::ssize(active_); ++i) {
      const Index h = active_[i];
      is_active_[h] = 0;
      if (i + 1 < std::ssize(active_)) expect_list(active_[i + 1]);
      propagate(h);
      if (bytes() > limits_->memory) [[unlikely]]
        refuse_memory();
    }
    active_.clear();
  }

  [[gnu::always_inline]] void expect_list(Index h) const {
    waiting_.expect_windows(h);
    faces_->expect(h);
  }

  [[noreturn]] void refuse_memory() const {
    throw MemoryLimit(
        joined_text({"the windows of an exact solve take more than ", limits_->memory, " bytes"}));
  }

  // Windows that leave a face across its half-edge h, given in the frame of a half-edge that runs
  // the other way along the same edge, go to the other faces on the edge.
  void deliver(Index h, const typename WindowStore::Batch& batch, std::ptrdiff_t count) {
    const Index first = surface_->twin(h);
    if (count == 0) return waiting_.release(batch);
    if (surface_->twin(first) != h) return deliver_to_many(h, batch, count);
    if (surface_->origin(first) == surface_->origin(h)) {
      mirror(batch.windows, count, surface_->length(h));
    }
    wait(first, batch, count);
  }

  void deliver_to_many(Index h, const typename WindowStore::Batch& batch, std::ptrdiff_t count) {
    mark_crossing(h, batch.windows, count);
    for (Index t = surface_->twin(h); t != h; t = surface_->twin(t)) {
      const typename WindowStore::Batch copy = waiting_.allocate(count);
      copy.windows.copy(0, batch.windows, 0, count);
      if (surface_->origin(t) == surface_->origin(h)) {
        mirror(copy.windows, count, surface_->length(h));
      }
      wait(t, copy, count);
    }
    waiting_.release(batch);
  }

  void wait(Index h, const typename WindowStore::Batch& batch, std::ptrdiff_t count) {
    if (lists_in_turn_ > most_lists_) return waiting_.release(batch);
    counts.created += count;
    waiting_.add(h, batch, count);
    if (settled_[surface_->origin(h)] || settled_[surface_->tip(h)]) return activate(h);
    if (!is_further_) return;
    // Its ends may be nearer to other sources and never have a turn; then that is when they are.
    for (const Index v : {surface_->origin(h), surface_->tip(h)}) {
      if (distances[v] < unreachable<Real>) heap_.push(v, distances[v]);
    }
  }

  // The trace back must know from which of the other faces the windows came.
  void mark_crossing(Index h, const WindowColumns& windows, std::ptrdiff_t count) {
    Index from = -1, marked = -1;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      if (windows.origin[i] != from) {
        from = windows.origin[i];
        marked = add_origin({origins[from].start, Origin::Kind::crossing, h, from});
      }
      windows.origin[i] = marked;
    }
  }

  static void mirror(const WindowColumns& windows, std::ptrdiff_t count, Real length) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const Real begin = windows.begin[i];
      windows.begin[i] = length - windows.end[i];
      windows.end[i] = length - begin;
      windows.x[i] = length - windows.x[i];
    }
    for (Real* column : {windows.begin, windows.end, windows.x, windows.y}) {
      std::reverse(column, column + count);
    }
    std::reverse(windows.origin, windows.origin + count);
  }

  // --- one list across one face ----------------------------------------------------------------

  void propagate(Index h) {
    waiting_.take_all(h, list_);
    list_.fill_lane();
    for (std::ptrdiff_t i = 0; i < list_.size; i += lane_size) {
      const auto start = [&](std::ptrdiff_t k) { return origins[list_.origin[i + k]].start; };
      Lane(start(0), start(1), start(2), start(3)).store(list_.start + i);
    }
    ++counts.lists;
    ++lists_in_turn_;
    counts.loaded += list_.size;
    const Real length = surface_->length(h);
    const bool sees_through_a_point = snap_images(h);
    const bool is_line = faces_->is_line(*surface_, h);
    drop_useless({length, reach_of(surface_->origin(h), length, is_line),
                  reach_of(surface_->tip(h), length, is_line)},
                 list_);
    if (bound_ < unreachable<Real>) drop_beyond(bound_at(surface_->origin(h)), rest_at(h), list_);
    if (limits_->ring < unreachable<Real>) drop_behind_rings(length);
    if (list_.size > 1) {
      sort_windows(list_);
      if (sees_through_a_point) {
        drop_repeated(on_edge * length, list_);
      } else {
        WindowTrimmer(list_).trim();
      }
    }
    if (list_.size == 0) return;
    counts.propagated += list_.size;
    const auto nearest = crossing_.aim(list_, length, faces_->apex(h));
    if (nearest.window < 0) return;  // all lengths were lost, being of less than 1e-150
    if (keeps(Mesh::face_of(h))) keep(h);
    reach_apex(h, nearest);
    cross(h);
  }

  // Behind a face without area an image may be a point of its window, but for rounding; and is so
  // then without, so that lines go from it in all directions, not along the edge only. Returns
  // whether there is one: all that lies beyond is seen through that one point, where its distance
  // ties with others.
  bool snap_images(Index h) {
    if (!faces_->has_lines()) return false;
    bool is_behind_line = false;
    for (Index t = surface_->twin(h); t != h; t = surface_->twin(t)) {
      is_behind_line |= faces_->is_line(*surface_, t);
    }
    return is_behind_line && snap_images(surface_->length(h));
  }

  bool snap_images(Real length) {
    const Real slack = on_edge * length;
    bool any = false;
    for (std::ptrdiff_t i = 0; i < list_.size; ++i) {
      const Real x = std::clamp(list_.x[i], list_.begin[i], list_.end[i]);
      if (list_.y[i] < -slack || std::fabs(list_.x[i] - x) > slack) continue;
      list_.x[i] = x;
      list_.y[i] = -on_line * length;
      any = true;
    }
    return any;
  }

  // Windows go on for one edge behind the ring, to reach all vertices there.
  void drop_behind_rings(Real length) {
    std::ptrdiff_t count = 0;
    for (std::ptrdiff_t i = 0; i < list_.size; ++i) {
      const Real p = std::clamp(list_.x[i], list_.begin[i], list_.end[i]);
      const Real nearest = list_.start[i] + std::hypot(p - list_.x[i], list_.y[i]);
      if (nearest <= next_ring(list_.start[i]) + length) list_.move(count++, i);
    }
    list_.size = count;
  }

  // The distance of an edge's end. Of two that tie the window goes where the end serves all that it
  // does, since from there paths go on in all directions; where no shortest path passes so near to
  // the end; and where the window enters a face without area, into which it looks along the edge.
  // Else windows would circle for ever round vertices whose angles sum to nothing, as where edges
  // have no length, at the tips of needles, and round what is a line.
  [[nodiscard]] Real reach_of(Index vertex, Real length, bool is_line) const {
    const Real distance = distances[vertex];
    const auto bend = faces_->bend(vertex);
    const bool is_enough =
        is_line || bend == PlanarFaces::Bend::any || bend == PlanarFaces::Bend::tip;
    return is_enough ? distance - tie * (distance + length) : distance;
  }

  void reach_apex(Index h, const typename FaceCrossing<Real>::Nearest& nearest) {
    const std::ptrdiff_t n = nearest.window;
    Arrival last{{list_.x[n], list_.y[n]}, h, list_.origin[n]};
    if (!nearest.is_straight) last.bend = nearest.crossing;
    // Bent at an end of the half-edge, the last piece is the side of the face from there. Where it
    // has no length, its ends must not be each other's way to the source.
    if (last.bend == 0 && surface_->length(Mesh::previous(h)) > 0) {
      last = {{0, 0}, Arrival::from_vertex, surface_->origin(h)};
    } else if (last.bend == surface_->length(h) && surface_->length(Mesh::next(h)) > 0) {
      last = {{0, 0}, Arrival::from_vertex, surface_->tip(h)};
    }
    if (!counts_times() || may_come_nearer(h, list_.origin[n], nearest.distance)) {
      arrive(surface_->apex(h), nearest.distance, last);
    }
  }

  // Round faces without area rounding makes the way to a vertex a little shorter every time: it
  // must do so clearly, if it did many times even for the longest edge that it may have come by.
  // So it does round needles where the way begins on a segment, as much as its wave's radius takes.
  [[nodiscard]] bool may_come_nearer(Index h, Index origin, Real distance) {
    const Index apex = surface_->apex(h);
    unsigned char& times = times_nearer_[apex];
    const bool is_often = times >= most_times_nearer;
    const Real edge = is_often ? longest_edge_ : surface_->length(h);
    Real clearly = (1 - clearly_shorter) * (distance + edge);
    if (is_of_front(origin)) clearly += (is_often ? 8 : 1) * front_rounding * limits_->size;
    if (!(distance + clearly < distances[apex])) return false;
    times = std::min<unsigned char>(times + 1, most_times_nearer);
    return true;
  }
  [[nodiscard]] bool counts_times() const {
    return faces_->has_lines() || !limits_->fronts.empty();
  }
  [[nodiscard]] bool is_of_front(Index origin) const {
    if (limits_->fronts.empty()) return false;
    while (origins[origin].kind == Origin::Kind::crossing) origin = origins[origin].previous;
    return origins[origin].kind == Origin::Kind::front;
  }

  void cross(Index h) {
    const Index left = Mesh::previous(h), right = Mesh::next(h);
    const auto sides = crossing_.sides(list_);
    const std::ptrdiff_t left_count = can_cross(left) ? sides.left_count : 0;
    if (left_count > 0) {
      const typename WindowStore::Batch batch = waiting_.allocate(left_count);
      deliver(left, batch,
              crossing_.cross_left(list_, left_count, surface_->length(left), batch.windows));
    }
    const std::ptrdiff_t first = can_cross(right) ? sides.right_begin : list_.size;
    if (first < list_.size) {
      const typename WindowStore::Batch batch = waiting_.allocate(list_.size - first);
      deliver(right, batch,
              crossing_.cross_right(list_, first, surface_->length(right),
                                    faces_->apex_from_tip(*surface_, h), batch.windows));
    }
  }

  [[nodiscard]] bool can_cross(Index h) const {
    return !surface_->is_border(h) && surface_->length(h) > 0;
  }

  [[nodiscard]] Real rest_at_vertex(Index vertex) const {
    if (limits_->goal) return straight_distance(*surface_, *limits_->goal, vertex);
    return limits_->rest.empty() ? 0 : limits_->rest[vertex];
  }

  [[nodiscard]] EdgeBounds rest_at(Index h) const {
    return {surface_->length(h), rest_at_vertex(surface_->origin(h)),
            rest_at_vertex(surface_->tip(h))};
  }

  [[nodiscard]] bool keeps(Index face) const {
    return limits_->keep_windows ||
           (!limits_->faces_to_keep.empty() && limits_->faces_to_keep[face] != 0);
  }

  void keep(Index h) {
    const typename WindowStore::Batch batch = kept.allocate(list_.size);
    // Whole lanes, so that what is read beside windows are numbers, too.
    const std::ptrdiff_t lanes = (list_.size + lane_size - 1) / lane_size;
    batch.windows.copy(0, list_, 0, lanes * lane_size);
    kept.add(h, batch, list_.size);
  }

  const Mesh* surface_ = nullptr;
  const PlanarFaces* faces_ = nullptr;
  const Array<Source<Real>>* sources_ = nullptr;
  const Limits* limits_ = nullptr;
  Real bound_ = unreachable<Real>;
  IndexedHeap<Real> heap_;
  Array<char> settled_;                // of each vertex: whether it was ever the nearest one
  Array<unsigned char> times_nearer_;  // of each vertex, where those are counted
  Array<Index> reached_;               // vertices with a distance
  bool is_further_ = false;
  bool is_done_ = false;  // the last run came to its end: nothing waits to be settled
  WindowStore waiting_;
  Array<char> is_active_;  // of each half-edge: whether it is in the queue
  Array<Index> active_;
  WindowList<Real> list_;
  FaceCrossing<Real> crossing_;
  std::ptrdiff_t settled_since_bound_ = 0;
  std::ptrdiff_t most_lists_ = 0;
  Real longest_edge_ = 0;
  std::ptrdiff_t lists_in_turn_ = 0;  // since a vertex was settled or came nearer
};

}  // namespace gelight::detail
