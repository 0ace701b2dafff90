#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/marching/bucket_queue.hpp"
#include "gelight/geodesic/marching/face_list.hpp"
#include "gelight/geodesic/marching/fan_walk.hpp"
#include "gelight/geodesic/marching/prefetch_ring.hpp"
#include "gelight/geodesic/marching/waves.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// What FastMarchingSolver works with.
template <std::floating_point Real>
class FastMarchingEngine {
 public:
  /// Throws InvalidInput as Surface does. `surface` is that of the mesh, where there is one.
  FastMarchingEngine(MeshArrays<Real> mesh, const Surface<Real>* surface,
                     const FastMarchingOptions& options)
      : faces_(std::move(mesh)), cancelled_(options.cancelled) {
    if (surface != nullptr) (void)surface_.get([&] { return *surface; });
    if (!set_up()) faces_.refuse_faces();
  }

  [[nodiscard]] const Surface<Real>& surface() const {
    return surface_.get([&] { return Surface<Real>(faces_); });
  }
  [[nodiscard]] const FaceList<Real>& faces() const { return faces_; }

  void solve_vertices(DistanceQuery<double>& query) const {
    auto& [sources, starts, distance] = query;
    query.starts.move_to_zero(faces_, query.sources);
    const typename Pool<Front>::Borrowed borrowed(pool_);
    Front& front = *borrowed;
    front.reset(vertex_count(), step_);
    start(faces_, query.sources, front);
    const bool several = sources.size() > 1;
    if (several) {
      march<true>(front);
    } else {
      march<false>(front);
    }
    for (Index v = 0; v < std::ssize(distance); ++v) {
      distance[v] = starts.at(v) + (several ? front.best(v) : front.nodes[v].distance);
    }
  }

 private:
  using Faces = FaceList<Real>;

  struct Front;

  [[nodiscard]] Index vertex_count() const { return faces_.vertex_count(); }

  // False for a mesh that a Surface refuses.
  [[nodiscard]] bool set_up() {
    const auto halfedges = 3 * static_cast<std::size_t>(faces_.face_count());
    const auto vertices = static_cast<std::size_t>(vertex_count());
    begin_.reserve_for_all(vertices + 1);
    spokes_.reserve_for_all(halfedges + vertices);
    return add_spokes(faces_);
  }

  // Whether there are several waves is known to the compiler: one wave pays nothing for others, nor
  // do several but where they meet.
  template <bool several>
  void march(Front& front) const {
    PeriodicCheck progress(cancelled_, vertex_count(), "a query of fast marching");
    while (!front.queue.empty()) {
      const Index node = pop_and_prefetch(front.queue, begin_, spokes_, front.nodes, [&](Index n) {
        return several ? front.vertex_of(n) : n;
      });
      if (front.nodes[node].settled) continue;  // waited in two places
      progress.step();
      front.settle(node);
      if (several && !front.is_alone_round(node, begin_, spokes_)) {
        advance<true>(node, front);
      } else {
        advance<false>(node, front);
      }
    }
  }

  /// A corner of a face.
  struct Corner {
    double dot;          // of its two edges, or no_face
    double double_area;  // of the face
  };
  /// An edge as its vertex sees it, and the corner between it and the edge before.
  struct Spoke {
    Index end;
    bool is_obtuse;  // whether a face beside it has an obtuse angle at its end
    double length;
    Corner between;
  };
  static constexpr double no_face = unreachable<double>;

  // A vertex that was passed is reached again only by a way that is shorter by a share, which grows
  // whenever the vertex leaves the queue: circles in thin triangles go on improving each other by
  // ever less, since a wave that runs along an edge turns by the root of what its ends are off.
  static constexpr double least_gain = 1e-5, largest_gain = 3e-4, gain_growth = 1.1;

  // Right angles are not obtuse by rounding: the share by which a squared length may be less.
  static constexpr double right_angle = 1 + 1e-5;

  // Faces of less than this share of the longer edge's square may have no area, more may not.
  static constexpr double thin = 1e-3;

  // By how much, as a share of the edge's square, rounding may put a place on the edge before it.
  static constexpr double on_edge = 1e-14;

  /// A wave at a vertex.
  struct Node {
    double distance = unreachable<double>;
    double to_beat = unreachable<double>;  // what a distance must be less than to be taken
    float gain = 0;                        // asked for when it left the queue
    Index wave = -1;                       // the source it was reached from
    Index next = -1;                       // of the same vertex, of another wave
    bool settled = false;                  // not in the queue, having been there
    bool leads = true;                     // as Waves has it
  };

  struct Front : Waves<Node> {
    using Waves<Node>::nodes;
    Array<double> starts;  // of each wave
    BucketQueue<double> queue;

    void reset(Index vertices, double step) {
      Waves<Node>::reset(vertices);
      starts.clear();
      queue.reset(step);
    }

    template <bool several>
    [[gnu::always_inline]] void reach(Index v, double d, Index wave, bool may_be_late) {
      Index n = v;
      if constexpr (several) {
        n = this->place_for(v, d, wave, may_be_late);
        if (n < 0) return;
      }
      Node& node = nodes[n];
      if (!(d < node.to_beat)) return;
      const bool in_place = !node.settled && queue.are_together(node.distance, d);
      node.distance = node.to_beat = d;
      node.wave = wave;
      node.settled = false;
      if (!in_place) queue.push(n, d);
    }
    void settle(Index n) {
      Node& node = nodes[n];
      node.settled = true;
      node.gain =
          static_cast<float>(std::clamp(gain_growth * double{node.gain}, least_gain, largest_gain));
      node.to_beat = node.distance * (1 - double{node.gain});
    }
  };

  // Reaches the neighbours of a vertex: along the edges, and across the edge to a neighbour that
  // has left the queue too. No circle has the distances of waves from different sources: an edge is
  // crossed by a wave that both ends know. Where another came first a wave is kept for that, one
  // vertex beyond those from where it leads on.
  template <bool several>
  void advance(Index node, Front& front) const {
    const Index v = several ? front.vertex_of(node) : node;
    const double d = front.nodes[node].distance;
    const Index wave = front.nodes[node].wave;
    const double start = front.starts[wave];
    if constexpr (several) front.nodes[node].leads = front.may_lead(v, node, most_delay_);
    const bool leads = front.nodes[node].leads;
    static constexpr Node unknown{};
    const auto at = [&](Index end) -> const Node& {
      if constexpr (several) {
        const Index n = front.find(end, wave);
        return n < 0 ? unknown : front.nodes[n];
      } else {
        return front.nodes[end];
      }
    };
    // A way across an edge at this vertex comes to an end at an angle with the edge from here no
    // wider than the face's own. Where that is not obtuse, the squared distance found is less than
    // this vertex' by the squared edge at most, and many ends are nearer already. The bits are
    // joined by `&` and `|` for one branch in place of several that cannot be foreseen.
    const auto may_gain = [&](const Node& end, const Spoke& spoke) {
      const double less = (d - end.to_beat) * (d - start + end.to_beat - start);
      return spoke.is_obtuse | (less < right_angle * spoke.length * spoke.length);
    };
    for (Index s = begin_[v]; s < begin_[v + 1]; ++s) {
      const Spoke& spoke = spokes_[s];
      const Node& end = at(spoke.end);
      double nearest = d + spoke.length;
      bool late = leads;
      if (spoke.between.dot != no_face) {
        const Spoke& before = spokes_[s - 1];
        const Node& other = at(before.end);
        const auto over = [&](double length, const Node& second, double known) {
          return start +
                 across(length, spoke.between, d - start, second.distance - start, known - start);
        };
        if (other.settled & may_gain(end, spoke)) {
          nearest = std::min(nearest, over(before.length, other, std::min(nearest, end.to_beat)));
          late = late || other.leads;
        }
        if (end.settled & may_gain(other, before)) {
          const double reached = over(spoke.length, end, other.to_beat);
          front.template reach<several>(before.end, reached, wave, leads || end.leads);
        }
      }
      front.template reach<several>(spoke.end, nearest, wave, late);
    }
  }

  static void start(const Faces& mesh, Sources& sources, Front& front) {
    if (sources.size() > 1) keep_different(mesh, sources);
    for (const auto& source : sources) {
      const auto wave = static_cast<Index>(front.starts.size());
      front.starts.push_back(source.distance);
      for_each_vertex_near(mesh, simplified(mesh, source.point), [&](Index v, double d) {
        front.template reach<true>(v, source.distance + d, wave, true);
      });
    }
  }

  // Goes round all vertices and measures what is round them. False where two faces have the same
  // three vertices, or edges have a length, but none that counts as one.
  [[nodiscard]] bool add_spokes(const Faces& mesh) {
    using namespace arithmetic;
    const auto all = mesh.all_rims();
    FanWalk fans(mesh.vertex_count());
    PeriodicCheck progress(cancelled_, mesh.vertex_count(), "the set-up of fast marching");
    ShortLength<double> short_length;
    double sum = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      progress.step();
      const Slice<const Rim> rims = all.at(v);
      begin_.push_back(static_cast<Index>(spokes_.size()));
      const Vec3<Real> from = mesh.position(v);
      Vec3<Real> way_before(0, 0, 0);
      const bool is_sound = fans.visit(v, rims);
      if (!is_sound || (fans.are_crowded() && mesh.has_twins(rims))) return false;
      for (const auto& [end, corner] : fans.steps()) {
        const Vec3<Real> way = mesh.position(end) - from;
        // Written where it stays: to copy what was just written in parts waits for all of them.
        Spoke& spoke = spokes_.emplace_back();
        spoke.end = end;
        spoke.between.dot = no_face;
        spoke.length = Faces::root(sum_of_squares(way));
        if (corner >= 0) {
          Spoke& before = *(&spoke - 1);
          spoke.between = corner_between(way_before, before.length, way, spoke.length);
          before.is_obtuse |= is_obtuse_at_end(before, spoke.between);
          spoke.is_obtuse = is_obtuse_at_end(spoke, spoke.between);
          sum += spoke.length;
          if (before.end > v) short_length.count(before.length);
          if (end > v) short_length.count(spoke.length);
        }
        way_before = way;
      }
    }
    begin_.push_back(static_cast<Index>(spokes_.size()));
    most_delay_ = Front::most_delay_in_edges * sum / (3.0 * mesh.face_count());
    if (sum == 0 && mesh.any_edge_is_long()) return false;
    collect(short_length);
    step_ = short_length.length();
    return true;
  }

  // Each edge for each of its faces, of the vertex of lower number.
  void collect(ShortLength<double>& short_length) const {
    for (Index v = 0; v + 1 < std::ssize(begin_); ++v) {
      for (Index s = begin_[v]; s < begin_[v + 1]; ++s) {
        if (spokes_[s].end < v || !short_length.seeks(spokes_[s].length)) continue;
        if (spokes_[s].between.dot != no_face) short_length.collect(spokes_[s].length);
        const bool is_last = s + 1 == begin_[v + 1];
        if (!is_last && spokes_[s + 1].between.dot != no_face) {
          short_length.collect(spokes_[s].length);
        }
      }
    }
  }

  // The corner between two edges that go such ways. What a face without area tells is rounding's:
  // it is given some.
  static Corner corner_between(const Vec3<Real>& one, double one_length, const Vec3<Real>& other,
                               double other_length) {
    const double double_area = norm(cross(one, other));
    const double longer = std::max(one_length, other_length);
    if (double_area > thin * longer * longer) return {dot(one, other), double_area};
    const double third = Faces::root(sum_of_squares(other - one));
    const auto [x1, x2, y2] = laid_out(mollified({one_length, third, other_length}, 1));
    return {x1 * x2, x1 * y2};
  }

  static bool is_obtuse_at_end(const Spoke& side, const Corner& corner) {
    return right_angle * side.length * side.length < corner.dot;
  }

  // Distance of the third vertex of a face from an edge at whose ends it is `a` and `b`, the first
  // of them where the face's dot product was taken: by the straight line through the edge from the
  // place that has those distances. Infinite where there is none, or none shorter than `known`.
  [[nodiscard]] static double across(double length, const Corner& face, double a, double b,
                                     double known) {
    // In the plane, with the edge from (0, 0) to (length, 0).
    const double inverse = 1 / length;
    const double x = (length + (a - b) * (a + b) * inverse) / 2;
    const double squared_depth = (a - x) * (a + x);  // 0 but for rounding where it lies on the edge
    const double foot = face.dot * inverse, height = face.double_area * inverse;
    // Most are not shorter, which is seen before any root: with depth and height on one line,
    // (depth + height)^2 + aside^2 < known^2. Equal counts too, as what overflows or vanishes is.
    const double aside = foot - x;
    const double rest = known * known - height * height - squared_depth - aside * aside;
    if (!(squared_depth > -on_edge * length * length && known > height && rest > 0 &&
          4 * height * height * squared_depth <= rest * rest)) {
      return unreachable<double>;
    }
    const double depth = std::sqrt(std::max(0.0, squared_depth));
    const double total = depth + height;
    const double crossing = x * height + foot * depth;
    if (!(crossing >= 0 && crossing <= length * total)) return unreachable<double>;
    return std::sqrt(aside * aside + total * total);
  }

  Faces faces_;
  Lazy<Surface<Real>> surface_;
  CancelHook cancelled_;
  double step_ = 0;
  double most_delay_ = 0;  // by which a wave may be late at a vertex and still be handed on
  Array<Index> begin_;     // of each vertex, and one more: where its spokes begin
  Array<Spoke> spokes_;
  mutable Pool<Front> pool_;
};

}  // namespace gelight::detail
