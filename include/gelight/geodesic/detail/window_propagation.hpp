#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/detail/indexed_heap.hpp"
#include "gelight/geodesic/detail/planar_faces.hpp"
#include "gelight/geodesic/detail/window_list.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// From where windows come: a source, a vertex at which paths bend, or the crossing of an edge of
/// three faces or more.
struct Origin {
  enum class Kind : unsigned char { source, vertex, crossing };
  Kind kind;
  Index index;     // of the source, the vertex, or the half-edge by which the edge was reached
  Index previous;  // of a crossing: the origin of the windows that cross
};

/// The shortest known way to a vertex: straight along an edge or inside a face from its origin, or
/// across half-edge `entry`, in whose frame the origin lies at `image`.
struct Arrival {
  double distance = unreachable<double>;
  Vec2<double> image{0, 0};
  Index entry = -1;
  Index origin = -1;
};

struct PropagationLimits {
  double distance = unreachable<double>;
  std::vector<Index> target_vertices;  // propagation ends when all of these are known
  std::function<bool()> cancelled;
  bool keep_windows = false;
};

/// What propagation did, for benchmarks.
struct PropagationCounts {
  std::ptrdiff_t lists = 0, loaded = 0, propagated = 0, created = 0;
};

/// Windows that were propagated, by the half-edge across which they entered a face.
struct KeptWindows {
  struct Window {
    double begin, end, x, y, start;
    Index halfedge, origin;
  };
  Array<Window> windows;
  Array<Index> first;  // of each half-edge, and one more
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
class WindowPropagation {
 public:
  Array<Arrival> arrivals;  // of each vertex
  Array<Origin> origins;
  KeptWindows kept;
  PropagationCounts counts;

  void run(const Surface<double>& surface, const PlanarFaces& faces, const Sources& sources,
           const PropagationLimits& limits) {
    reset(surface, faces, limits);
    sources_ = &sources;
    for (std::size_t s = 0; s < sources.size(); ++s) add_source(sources[s], static_cast<Index>(s));
    while (!heap_.empty()) {
      if (limits.cancelled && ++pops_ % pops_between_polls == 0 && limits.cancelled()) {
        was_cancelled = true;
        return;
      }
      settle(heap_.pop());
      while (!active_.empty()) propagate_active();
    }
    sort_kept();
  }

  bool was_cancelled = false;

  /// Beyond this distance nothing was computed.
  [[nodiscard]] double bound() const { return bound_; }

 private:
  using Mesh = Surface<double>;
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  // A window goes when something else is shorter by more than rounding can pretend.
  static constexpr double clearly = 1 - 1e-13;
  // Of two windows that differ by rounding only, one is enough.
  static constexpr double hardly = 1 + 4 * epsilon;
  static constexpr int pops_between_polls = 256;

  void reset(const Mesh& surface, const PlanarFaces& faces, const PropagationLimits& limits) {
    surface_ = &surface;
    faces_ = &faces;
    limits_ = &limits;
    bound_ = limits.distance;
    arrivals.assign(static_cast<std::size_t>(surface.vertex_count()), {});
    origins.clear();
    kept = {};
    counts = {};
    pops_ = 0;
    was_cancelled = false;
    heap_.reset(surface.vertex_count());
    settled_.assign(static_cast<std::size_t>(surface.vertex_count()), 0);
    waiting_.reset(surface.halfedge_count());
    is_active_.assign(static_cast<std::size_t>(surface.halfedge_count()), 0);
    active_.clear();
    kept_.clear();
  }

  // --- sources -------------------------------------------------------------------------------

  void add_source(const Source<double>& source, Index number) {
    using Kind = SurfacePoint<double>::Kind;
    const auto& [a, b] = source.point.element;
    const auto& w = source.point.weights;
    const Index origin = add_origin({Origin::Kind::source, number, -1});
    switch (source.point.kind) {
      case Kind::vertex:
        return arrive(a, {source.distance, {0, 0}, -1, origin});
      case Kind::edge: {
        const Index first = surface_->find_halfedge(a, b);
        const double t = surface_->origin(first) == a ? w[1] : w[0];
        Index h = first;
        do {
          const bool same = surface_->origin(h) == surface_->origin(first);
          add_source_in_face(h, {(same ? t : 1 - t) * surface_->length(h), 0}, source.distance,
                             origin);
          h = surface_->twin(h);
        } while (h != first);
        return;
      }
      case Kind::face: {
        const Index h = 3 * a;
        const Vec2<double> p = w[1] * Vec2<double>(surface_->length(h), 0) + w[2] * faces_->apex(h);
        return add_source_in_face(h, p, source.distance, origin);
      }
    }
  }

  // A source at a point of half-edge h's frame, in h's face or on h itself.
  void add_source_in_face(Index h, const Vec2<double>& point, double start, Index origin) {
    const Vec2<double> tip(surface_->length(h), 0);
    const Vec2<double> apex = faces_->apex(h);
    arrive(surface_->origin(h), {start + point.norm(), {0, 0}, -1, origin});
    arrive(surface_->tip(h), {start + (point - tip).norm(), {0, 0}, -1, origin});
    arrive(surface_->apex(h), {start + (point - apex).norm(), {0, 0}, -1, origin});
    emit_window(Mesh::next(h), into_frame(point, tip, apex), start, origin);
    emit_window(Mesh::previous(h), into_frame(point, apex, {0, 0}), start, origin);
    // A source on h is seen from the other faces by their own call.
    if (point.y() > 0) emit_window(h, point, start, origin);
  }

  // A point in the frame with origin a and x towards b.
  static Vec2<double> into_frame(const Vec2<double>& p, const Vec2<double>& a,
                                 const Vec2<double>& b) {
    const Vec2<double> along = (b - a).stableNormalized();
    const Vec2<double> from = p - a;
    return {along.dot(from), along.x() * from.y() - along.y() * from.x()};
  }

  // A window over the whole of half-edge h, seen from a point of its own face.
  void emit_window(Index h, const Vec2<double>& point, double start, Index origin) {
    const double length = surface_->length(h);
    if (length == 0) return;
    right_.clear();
    right_.push(0, length, length - point.x(), std::min(-point.y(), 0.0), start, origin);
    deliver(h, right_);
  }

  Index add_origin(const Origin& origin) {
    origins.push_back(origin);
    return static_cast<Index>(origins.size() - 1);
  }

  // --- vertices ------------------------------------------------------------------------------

  void arrive(Index vertex, const Arrival& arrival) {
    // Improvements within rounding would only set neighbours off again.
    if (!(arrival.distance * hardly < arrivals[vertex].distance) &&
        !(arrival.distance < arrivals[vertex].distance && arrivals[vertex].origin < 0)) {
      return;
    }
    arrivals[vertex] = arrival;
    heap_.push(vertex, arrival.distance);
  }

  void settle(Index vertex) {
    const Arrival arrival = arrivals[vertex];
    const bool is_source = arrival.entry < 0 && is_at_source(vertex, origins[arrival.origin]);
    update_bound();
    if (arrival.distance <= bound_) leave(vertex, arrival, is_source);
    if (settled_[vertex]) return;
    settled_[vertex] = 1;
    for (const Index out : surface_->corners(vertex)) {
      activate_edge(out);
      activate_edge(Mesh::previous(out));
    }
  }

  [[nodiscard]] bool is_at_source(Index vertex, const Origin& origin) const {
    if (origin.kind != Origin::Kind::source) return false;
    const auto& point = (*sources_)[static_cast<std::size_t>(origin.index)].point;
    return point.kind == SurfacePoint<double>::Kind::vertex && point.element[0] == vertex;
  }

  // Along the edges from a vertex; and in all directions where paths can bend there.
  void leave(Index vertex, const Arrival& arrival, bool is_source) {
    Index origin = is_source ? arrival.origin : -1;
    const auto own = [&] {
      if (origin < 0) origin = add_origin({Origin::Kind::vertex, vertex, -1});
      return origin;
    };
    for (const Index out : surface_->corners(vertex)) {
      const Index in = Mesh::previous(out);
      for (const auto& [h, end] :
           {std::pair{out, surface_->tip(out)}, {in, surface_->origin(in)}}) {
        const double distance = arrival.distance + surface_->length(h);
        if (distance * hardly < arrivals[end].distance) {
          arrive(end, {distance, {0, 0}, -1, own()});
        }
      }
    }
    if (!is_source && !faces_->bends_paths(vertex)) return;
    for (const Index out : surface_->corners(vertex)) {
      const Index opposite = Mesh::next(out);
      emit_window(opposite, faces_->apex(opposite), arrival.distance, own());
    }
  }

  void update_bound() {
    if (limits_->target_vertices.empty()) return;
    double farthest = 0;
    for (const Index v : limits_->target_vertices) {
      farthest = std::max(farthest, arrivals[v].distance);
    }
    bound_ = std::min(limits_->distance, farthest);
  }

  // --- the queue of half-edges -----------------------------------------------------------------

  void activate_edge(Index first) {
    Index h = first;
    do {
      activate(h);
      h = surface_->twin(h);
    } while (h != first);
  }

  void activate(Index h) {
    if (waiting_.empty(h) || is_active_[h]) return;
    is_active_[h] = 1;
    active_.push_back(h);
  }

  void propagate_active() {
    for (std::size_t i = 0; i < active_.size(); ++i) {
      const Index h = active_.data()[i];
      is_active_[h] = 0;
      propagate(h);
    }
    active_.clear();
  }

  // Windows that leave a face across its half-edge h, given in the frame of a half-edge that runs
  // the other way along the same edge, go to the other faces on the edge.
  void deliver(Index h, WindowList& list) {
    if (list.size() == 0 || surface_->is_border(h)) return;
    const bool forks = !surface_->is_manifold(h);
    if (forks) mark_crossing(h, list);
    const bool active = settled_[surface_->origin(h)] || settled_[surface_->tip(h)];
    for (Index t = surface_->twin(h); t != h; t = surface_->twin(t)) {
      if (surface_->origin(t) == surface_->origin(h)) {
        mirrored_ = list;
        mirror(mirrored_, surface_->length(h));
        waiting_.add(t, mirrored_);
      } else {
        waiting_.add(t, list);
      }
      counts.created += list.size();
      if (active) activate(t);
    }
  }

  void mark_crossing(Index h, WindowList& list) {
    Index from = -1, marked = -1;
    for (Index& origin : list.origin) {
      if (origin != from) {
        from = origin;
        marked = add_origin({Origin::Kind::crossing, h, from});
      }
      origin = marked;
    }
  }

  static void mirror(WindowList& list, double length) {
    for (std::ptrdiff_t i = 0; i < list.size(); ++i) {
      const double begin = list.begin[i];
      list.begin[i] = length - list.end[i];
      list.end[i] = length - begin;
      list.x[i] = length - list.x[i];
    }
    for (auto* column : {&list.begin, &list.end, &list.x, &list.y, &list.start}) {
      std::reverse(column->begin(), column->end());
    }
    std::reverse(list.origin.begin(), list.origin.end());
  }

  // --- one list across one face ----------------------------------------------------------------

  void propagate(Index h) {
    list_.clear();
    waiting_.take_all(h, list_);
    ++counts.lists;
    counts.loaded += list_.size();
    drop_useless(h);
    if (list_.size() > 1) {
      sort_list();
      trim_list();
    }
    if (list_.size() == 0) return;
    counts.propagated += list_.size();
    if (limits_->keep_windows) keep(h);
    reach_apex(h);
    cross_left(h);
    cross_right(h);
  }

  // Drops windows all of whose points are reached sooner by way of one of the edge's ends (it is
  // enough to look at the far end of the window: the detour by way of a vertex grows no faster
  // than the distance does), or not within the bound.
  void drop_useless(Index h) {
    const double length = surface_->length(h);
    const double from_origin = arrivals[surface_->origin(h)].distance;
    const double from_tip = arrivals[surface_->tip(h)].distance;
    std::ptrdiff_t kept_count = 0;
    for (std::ptrdiff_t i = 0; i < list_.size(); ++i) {
      const double b = list_.begin[i], e = list_.end[i], x = list_.x[i], y = list_.y[i];
      const double at_begin = list_.start[i] + distance(b - x, y);
      const double at_end = list_.start[i] + distance(e - x, y);
      const double nearest = x > b && x < e ? list_.start[i] - y : std::min(at_begin, at_end);
      // From a point of the edge's line outside the window, only the line itself is seen.
      const bool sees = y < 0 || (b < x && x < e);
      if (sees && !(from_origin + e < at_end * clearly) &&
          !(from_tip + (length - b) < at_begin * clearly) && nearest <= bound_) {
        list_.move(kept_count++, i);
      }
    }
    list_.resize(kept_count);
  }

  static double distance(double x, double y) { return std::sqrt(x * x + y * y); }

  void sort_list() {
    const auto before = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
      return list_.begin[i] + list_.end[i] < list_.begin[j] + list_.end[j];
    };
    bool sorted = true;
    for (std::ptrdiff_t i = 1; i < list_.size() && sorted; ++i) sorted = !before(i, i - 1);
    if (sorted) return;
    order_.resize(static_cast<std::size_t>(list_.size()));
    std::iota(order_.begin(), order_.end(), Index{0});
    std::stable_sort(order_.begin(), order_.end(), before);
    sorted_.resize(list_.size());
    for (std::ptrdiff_t i = 0; i < list_.size(); ++i) sorted_.copy(i, list_, order_[i]);
    std::swap(list_, sorted_);
  }

  enum class Verdict { keep, drop_left, drop_right };

  // Every window against its left neighbour, and against the one before where that goes.
  void trim_list() {
    std::ptrdiff_t top = 0;
    for (std::ptrdiff_t i = 1; i < list_.size(); ++i) {
      Verdict verdict = Verdict::keep;
      while (top >= 0) {
        verdict = trim(top, i);
        if (verdict != Verdict::drop_left) break;
        --top;
      }
      if (top < 0 || verdict == Verdict::keep) list_.move(++top, i);
    }
    list_.resize(top + 1);
  }

  [[nodiscard]] double distance_at(std::ptrdiff_t i, double x) const {
    return list_.start[i] + distance(x - list_.x[i], list_.y[i]);
  }

  // Takes from windows a and b, b not left of a, what the other reaches sooner.
  Verdict trim(std::ptrdiff_t a, std::ptrdiff_t b) {
    double &a0 = list_.begin[a], &a1 = list_.end[a], &b0 = list_.begin[b], &b1 = list_.end[b];
    const double low = std::max(a0, b0), high = std::min(a1, b1);
    if (!(low < high)) return Verdict::keep;
    const double a_low = distance_at(a, low), b_low = distance_at(b, low);
    const double a_high = distance_at(a, high), b_high = distance_at(b, high);
    const bool a_wins_low = a_low <= b_low * hardly, a_wins_high = a_high <= b_high * hardly;
    const bool b_wins_low = b_low <= a_low * hardly, b_wins_high = b_high <= a_high * hardly;
    if ((a_wins_low && a_wins_high) || (b_wins_low && b_wins_high)) {
      // The difference of the two distances has one extremum on the line, where both lie in the
      // same direction; with the same start it has the same sign everywhere between.
      const double turn = same_direction(a, b);
      const bool turns = list_.start[a] != list_.start[b] && turn > low && turn < high;
      const double a_turn = turns ? distance_at(a, turn) : a_low;
      const double b_turn = turns ? distance_at(b, turn) : b_low;
      const bool tie = a_wins_low && a_wins_high && b_wins_low && b_wins_high;
      // Of equals the one that covers the other stays.
      const bool prefer_b = tie && b0 <= a0 && b1 >= a1;
      if (a_wins_low && a_wins_high && !prefer_b && (!turns || a_turn <= b_turn * hardly)) {
        if (a0 <= b0 && b1 <= a1) return Verdict::drop_right;
        if (a0 <= b0)
          b0 = high;
        else if (b1 <= a1)
          b1 = low;
        return Verdict::keep;
      }
      if (b_wins_low && b_wins_high && (!turns || b_turn <= a_turn * hardly)) {
        if (b0 <= a0 && a1 <= b1) return Verdict::drop_left;
        if (a1 <= b1)
          a1 = low;
        else if (b0 <= a0)
          a0 = high;
        return Verdict::keep;
      }
      return Verdict::keep;
    }
    if (!(a_wins_low && b_wins_high)) return Verdict::keep;
    split(a, b, low, high);
    return Verdict::keep;
  }

  [[nodiscard]] double same_direction(std::ptrdiff_t a, std::ptrdiff_t b) const {
    return (list_.x[a] * list_.y[b] - list_.x[b] * list_.y[a]) / (list_.y[b] - list_.y[a]);
  }

  // Window a is the nearer at low, b at high: each gives up its part beyond the point between where
  // they are equal, as far as the other covers it.
  void split(std::ptrdiff_t a, std::ptrdiff_t b, double low, double high) {
    const auto [a_end, b_begin] = equal_point(a, b, low, high);
    const bool a_covers = list_.begin[a] <= list_.begin[b];
    const bool b_covers = list_.end[b] >= list_.end[a];
    if (b_covers) list_.end[a] = a_end;
    if (a_covers) list_.begin[b] = b_begin;
  }

  // An interval within which both distances are equal: at its first number b is not nearer, at its
  // second a is not nearer. Parting there leaves an overlap rather than a gap.
  [[nodiscard]] std::pair<double, double> equal_point(std::ptrdiff_t a, std::ptrdiff_t b,
                                                      double low, double high) const {
    const double ax = list_.x[a], ay = list_.y[a], bx = list_.x[b], by = list_.y[b];
    if (list_.start[a] == list_.start[b]) {
      // The bisector of the two images.
      const double p =
          std::clamp(((bx - ax) * (bx + ax) + (by - ay) * (by + ay)) / (2 * (bx - ax)), low, high);
      return {p, p};
    }
    // The branch of a hyperbola: bisection made fast by the secant (Illinois).
    double f_low = distance_at(a, low) - distance_at(b, low);
    double f_high = distance_at(a, high) - distance_at(b, high);
    for (int step = 0; step < secant_steps && f_low < 0 && f_high > 0; ++step) {
      const double p = low - f_low * (high - low) / (f_high - f_low);
      if (!(p > low && p < high)) break;
      const double f = distance_at(a, p) - distance_at(b, p);
      if (f <= 0) {
        low = p;
        f_low = f;
        f_high /= 2;
      } else {
        high = p;
        f_high = f;
        f_low /= 2;
      }
    }
    return {high, low};
  }
  static constexpr int secant_steps = 5;

  void keep(Index h) {
    for (std::ptrdiff_t i = 0; i < list_.size(); ++i) {
      kept_.push_back({list_.begin[i], list_.end[i], list_.x[i], list_.y[i], list_.start[i], h,
                       list_.origin[i]});
    }
  }

  void sort_kept() {
    if (!limits_->keep_windows) return;
    kept.first.assign(static_cast<std::size_t>(surface_->halfedge_count()) + 1, 0);
    for (const auto& w : kept_) ++kept.first[w.halfedge + 1];
    std::partial_sum(kept.first.begin(), kept.first.end(), kept.first.begin());
    Array<Index> fill(kept.first.begin(), kept.first.end() - 1);
    kept.windows.resize(kept_.size());
    for (const auto& w : kept_) kept.windows[fill[w.halfedge]++] = w;
  }

  // The distance of the vertex across the face: straight through a window, or bent at the end of
  // one that passes it by.
  void reach_apex(Index h) {
    const Vec2<double> apex = faces_->apex(h);
    double least = unreachable<double>;
    std::ptrdiff_t best = -1;
    for (std::ptrdiff_t i = 0; i < list_.size(); ++i) {
      const double d = through(list_.begin[i], list_.end[i], list_.x[i], list_.y[i], apex);
      if (list_.start[i] + d < least) {
        least = list_.start[i] + d;
        best = i;
      }
    }
    arrive(surface_->apex(h), {least, {list_.x[best], list_.y[best]}, h, list_.origin[best]});
  }

 public:
  /// Length of the shortest path from (x, y) through the window to a point above it.
  static double through(double begin, double end, double x, double y, const Vec2<double>& point) {
    const double px = point.x(), py = point.y();
    const double left = cross(begin - x, -y, px - x, py - y);
    const double right = cross(end - x, -y, px - x, py - y);
    if (left > 0) return distance(begin - x, y) + distance(px - begin, py);
    if (right < 0) return distance(end - x, y) + distance(px - end, py);
    return distance(px - x, py - y);
  }

 private:
  // Positive where the second vector points to the left of the first.
  static double cross(double ax, double ay, double bx, double by) { return ax * by - ay * bx; }

  // Windows that pass left of the apex, into the frame from the half-edge's origin to the apex.
  void cross_left(Index h) {
    const Vec2<double> apex = faces_->apex(h);
    const double length = surface_->length(Mesh::previous(h));
    if (length == 0) return;
    const double norm = apex.norm(), ux = apex.x() / norm, uy = apex.y() / norm;
    left_.clear();
    for (std::ptrdiff_t i = 0; i < list_.size(); ++i) {
      const double x = list_.x[i], y = list_.y[i];
      if (!(side(list_.begin[i], x, y, apex) < 0)) continue;
      const bool to_apex = side(list_.end[i], x, y, apex) >= 0;
      const double b =
          length * clamp_share(-y * list_.begin[i], apex.y() * (x - list_.begin[i]) - apex.x() * y);
      const double e = to_apex ? length
                               : length * clamp_share(-y * list_.end[i],
                                                      apex.y() * (x - list_.end[i]) - apex.x() * y);
      if (e - b > 4 * epsilon * length) {
        left_.push(b, e, ux * x + uy * y, std::min(ux * y - uy * x, 0.0), list_.start[i],
                   list_.origin[i]);
      }
    }
    deliver(Mesh::previous(h), left_);
  }

  // Windows that pass right of the apex, into the frame from the apex to the half-edge's tip.
  void cross_right(Index h) {
    const Vec2<double> apex = faces_->apex(h);
    const double base = surface_->length(h), length = surface_->length(Mesh::next(h));
    if (length == 0) return;
    const Vec2<double> rest(base - apex.x(), apex.y());
    const double norm = rest.norm(), ux = rest.x() / norm, uy = -rest.y() / norm;
    right_.clear();
    for (std::ptrdiff_t i = 0; i < list_.size(); ++i) {
      const double x = list_.x[i], y = list_.y[i];
      if (!(side(list_.end[i], x, y, apex) > 0)) continue;
      const bool from_apex = side(list_.begin[i], x, y, apex) <= 0;
      const auto from_tip = [&](double p) {
        return length * clamp_share(-y * (base - p), apex.y() * (p - x) - rest.x() * y);
      };
      const double b = from_apex ? 0 : length - from_tip(list_.begin[i]);
      const double e = length - from_tip(list_.end[i]);
      if (e - b > 4 * epsilon * length) {
        const double dx = x - base, dy = y;
        right_.push(b, e, length + ux * dx + uy * dy, std::min(ux * dy - uy * dx, 0.0),
                    list_.start[i], list_.origin[i]);
      }
    }
    deliver(Mesh::next(h), right_);
  }

  // Positive where the apex lies left of the line from (x, y) through (p, 0).
  static double side(double p, double x, double y, const Vec2<double>& apex) {
    return cross(p - x, -y, apex.x() - x, apex.y() - y);
  }

  static double clamp_share(double numerator, double denominator) {
    return numerator < denominator ? std::max(numerator / denominator, 0.0) : 1.0;
  }

  const Mesh* surface_ = nullptr;
  const PlanarFaces* faces_ = nullptr;
  const Sources* sources_ = nullptr;
  const PropagationLimits* limits_ = nullptr;
  double bound_ = unreachable<double>;
  int pops_ = 0;
  IndexedHeap heap_;
  Array<char> settled_;  // of each vertex: whether it was ever the nearest one
  WindowStore waiting_;
  Array<char> is_active_;
  Array<Index> active_, order_;
  WindowList list_, sorted_, left_, right_, mirrored_;
  Array<KeptWindows::Window> kept_;
};

}  // namespace gelight::detail
