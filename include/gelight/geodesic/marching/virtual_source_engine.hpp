#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/marching/bucket_queue.hpp"
#include "gelight/geodesic/marching/one_ring.hpp"
#include "gelight/geodesic/marching/prefetch_ring.hpp"
#include "gelight/geodesic/marching/waves.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What a VirtualSourceSolver works in.
template <std::floating_point Real>
class VirtualSourceEngine {
  using Mesh = Surface<Real>;

 public:
  VirtualSourceEngine(Surface<Real> surface, const VirtualSourceOptions& options)
      : surface_(std::move(surface)), cancelled_(options.cancelled) {
    step_ = short_edge_length(surface_);
    most_delay_ = Front::most_delay_in_edges * mean_edge_length(surface_);
    lay_out_fans();
    link_fans();
  }

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }

  void solve_vertices(DistanceQuery<double>& query) const;

 private:
  struct Front;

  // Whether there are several waves is known to the compiler: one wave pays nothing for others, nor
  // do several but where they meet.
  template <bool several>
  void march(Front& front) const {
    PeriodicCheck progress(cancelled_, surface_.vertex_count(), "a query of virtual sources");
    while (!front.queue.empty()) {
      const Index node = pop_and_prefetch(front.queue, begin_, spokes_, front.nodes, [&](Index n) {
        return several ? front.vertex_of(n) : n;
      });
      if (front.nodes[node].settled) continue;  // as often there as it came nearer
      progress.step();
      refine<several>(node, front);
      front.settle(node);
      if (several && !front.is_alone_round(node, begin_, spokes_)) {
        advance<true>(node, front);
      } else {
        advance<false>(node, front);
      }
    }
  }

  void keep_places(const Sources& sources, Front& front) const {
    front.places.clear();
    for (const auto& source : sources) {
      const bool in_face = source.point.kind == SurfacePoint<double>::Kind::face;
      const Index corner =
          in_face ? surface_.face(source.point.element[0])[0] : source.point.element[0];
      front.places.push_back({corner,
                              surface_.difference(vertex_point<double>(corner), source.point),
                              source.distance});
    }
  }

  // No way is shorter than the straight line through space.
  [[nodiscard]] double least_distance(Index v, Index wave, const Front& front) const {
    using namespace arithmetic;
    const auto& [corner, from_corner, start] = front.places[static_cast<std::size_t>(wave)];
    return start + stable_norm((surface_.position(v) - surface_.position(corner)) - from_corner);
  }

  void take_distances(Front& front, DistanceQuery<double>& query) const {
    Slice<double> distance = query.distance;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      for (Index n = v; n >= 0; n = front.nodes[n].next) {
        const Node& node = front.nodes[n];
        if (node.wave < 0) continue;
        const double d = std::max(node.distance, least_distance(v, node.wave, front));
        distance[v] = std::min(distance[v], query.starts.at(v) + d);
      }
    }
    relax_edges(distance, front.nearer);
  }

  // No vertex is farther than by way of a neighbour: an image that was taken for too near, before
  // the straight line said so, may have won over that way.
  void relax_edges(Slice<double> distance, Array<Index>& nearer) const {
    nearer.clear();
    const auto relax = [&](Index v) {
      for (Index s = begin_[v]; s < begin_[v + 1]; ++s) {
        double& other = distance[spokes_[s].end];
        const double over_edge = distance[v] + spokes_[s].length;
        if (!(over_edge < other)) continue;
        other = over_edge;
        nearer.push_back(spokes_[s].end);
      }
    };
    for (Index v = 0; v < surface_.vertex_count(); ++v) relax(v);
    // First come, first served: no vertex waits for others to be corrected over and over.
    for (Index i = 0; i < std::ssize(nearer); ++i) relax(nearer[i]);
  }

  // Rotations are unit complex numbers.
  using Turn = Vec2<Real>;
  static Turn turned(const Turn& a, const Turn& b) {
    return {a.x() * b.x() - a.y() * b.y(), a.x() * b.y() + a.y() * b.x()};
  }
  static Turn turned_back(const Turn& a, const Turn& b) {
    return {a.x() * b.x() + a.y() * b.y(), a.y() * b.x() - a.x() * b.y()};
  }

  /// An edge at a vertex, of its fan in order. `turn` and `angle` are what it is turned by from the
  /// fan's first edge, in the faces laid flat one after the other. `here` and `before` are, of the
  /// face between this edge and the one before, the spokes back to the vertex from the ends of
  /// this and of that edge: s where the third vertex comes after spoke s of its fan, else ~s.
  struct Spoke {
    Index end;
    float slack;
    double length;
    Turn turn;
    float angle;
    Index here, before;
  };
  // Added to the angles of one fan of a vertex after the other.
  static constexpr float between_fans = 1000;
  static constexpr float no_face = -unreachable<float>;  // no way over it is short enough

  /// A wave at a vertex, and where it sees its source: `distance` is `offset` and the straight line
  /// to the image, which leaves the vertex at `back`.
  struct Node {
    double distance = unreachable<double>;
    double offset = 0;
    Turn back = Turn::Zero();
    float angle = 0;  // about that of `back`
    Index place = 0;  // of `back` in the fan: 2 s on spoke s, 2 s - 1 in the face before
    float gain = 0;
    bool settled = false;  // not in the queue, having been there
    bool is_clear = true;  // both ends of the edge that the image came over see it: else a guess
    std::uint16_t passes = 0;  // how often it has left the queue, up to most_passes
    Index wave = -1;           // of which source
    Index next = -1;           // of the same vertex, of another wave
    // The least distance by an image that is hidden in part, tried when the vertex' turn comes;
    // over which place, negative where the owner is the end after it.
    Index promised = 0;
    bool leads = true;  // as Waves has it
    double promise = unreachable<double>;

    [[nodiscard]] bool is_bettered(double new_offset, double new_distance,
                                   bool new_is_clear = false) const {
      if (passes == most_passes) return new_distance < distance * (1 - gain);
      return new_distance < distance * (1 - (new_is_clear ? clear_gain : double{gain})) ||
             (new_is_clear && !is_clear && new_distance < limit()) ||
             (new_offset < offset / 2 && new_distance < limit());
    }
    [[nodiscard]] double limit() const { return distance * (1 + tie); }
  };

  /// All faces of a vertex round which one fan closes, or none such.
  struct Fan {
    Turn whole;
    float angle;
    bool has_shared_edge;  // several fans, or one twice, have an edge at their end
  };

  struct Front : Waves<Node> {
    using Waves<Node>::nodes;
    // A source, as a difference of positions, which is exact far from the origin, too.
    struct Place {
      Index corner;
      Vec3<Real> from_corner;
      double start;
    };
    Node unknown;  // in place of those that there are not
    BucketQueue<double> queue;
    std::vector<Place> places;  // of each wave
    Array<Index> nearer;        // vertices that came nearer at the end

    void reach(Index n, Index wave, double offset, double distance, const Turn& back, float angle,
               Index place, bool is_clear = true) {
      Node& node = nodes[n];
      const bool in_place = !node.settled && queue.are_together(node.distance, distance);
      node.distance = distance;
      node.wave = wave;
      node.offset = offset;
      node.back = back;
      node.angle = angle;
      node.place = place;
      node.settled = false;
      node.is_clear = is_clear;
      if (!in_place) queue.push(n, distance);
    }
    void settle(Index n) {
      Node& node = nodes[n];
      node.settled = true;
      node.promise = unreachable<double>;
      node.gain = std::clamp(2 * node.gain, least_gain, largest_gain);
      if (node.passes < most_passes) ++node.passes;
    }
  };

  // A vertex that was passed is reached again only by a way that is shorter by a share, rounding at
  // first, which doubles whenever the vertex leaves the queue: vertices of thin triangles that see
  // an image in part only go on improving each other by ever less.
  // Of an image that both ends of an edge see. It takes no part in that: what it improves it
  // settles.
  static constexpr float least_gain = 1e-10F, largest_gain = 3e-4F;
  static constexpr double clear_gain = 1e-14;
  // But rounding may have vertices in a circle better each other for ever: from so many passes on,
  // nothing but being shorter by that share betters one.
  static constexpr std::uint16_t most_passes = 10000;
  // Of two ways equally long but for `tie` the one that is straight for longer shows more of what
  // lies behind. It must bend less than half as far out, lest a vertex is reached anew from every
  // spoke of a fan. A way that bends by less than `straight` at a vertex (its sine) is straight
  // there: it is longer by half the square of that. A source nearer to a vertex than
  // `next_to_vertex` of an edge is seen from there along any of its edges.
  static constexpr double tie = 1e-12, straight = 1e-9, next_to_vertex = 1e-9, rounding = 1e-12;

  void start(const Source<double>& source, Index wave, Front& front) const {
    using namespace arithmetic;
    const auto point = simplified(surface_, source.point);
    if (point.kind == SurfacePoint<double>::Kind::vertex) {
      const Index n = front.place_for(point.element[0], source.distance, wave, true);
      if (source.distance < front.nodes[n].distance) {
        front.reach(n, wave, source.distance, source.distance, Turn::Zero(), 0, 0);
      }
      return;
    }
    for_each_face_at(surface_, point, [&](Index f) {
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        const Index v = surface_.origin(h), s = corner_spoke_[h];
        const double r = straight_distance(surface_, point, v);
        const Index n = front.place_for(v, source.distance + r, wave, true);
        if (!(source.distance + r < front.nodes[n].distance)) continue;
        const Vec3<Real> to = surface_.difference(vertex_point<double>(v), point);
        const Vec3<Real> first = surface_.position(spokes_[s - 1].end) - surface_.position(v);
        Turn opening(dot(first, to), norm(cross<double>(first, to)));
        const double norm = stable_norm(opening);
        if (norm > 0) opening /= norm;
        front.reach(n, wave, source.distance, source.distance + r,
                    norm > 0 ? turned(spokes_[s - 1].turn, opening) : Turn::Zero(),
                    (spokes_[s - 1].angle + spokes_[s].angle) / 2, 2 * s - 1);
      }
    });
  }

  // The node of a wave at a vertex.
  struct Seen {
    Index vertex;
    Index node;     // -1 where it has none
    bool may_come;  // whether it is kept here though another is nearer
  };
  template <bool several>
  [[nodiscard]] static Seen seen(Index v, Index wave, bool may_come, const Front& front) {
    return {v, several ? front.find(v, wave) : v, may_come};
  }
  template <bool several>
  [[nodiscard]] static const Node& at(const Seen& seen, const Front& front) {
    return several && seen.node < 0 ? front.unknown : front.nodes[seen.node];
  }
  template <bool several>
  [[nodiscard]] static Index place_for(const Seen& seen, double distance, Index wave,
                                       Front& front) {
    return several ? front.place_for(seen.vertex, distance, wave, seen.may_come) : seen.vertex;
  }

  // Reaches the neighbours of a vertex: along the edges, and over them with the images that their
  // two ends hold of one wave. Where another came first a wave is kept for that, one vertex beyond
  // those from where it leads on.
  template <bool several>
  void advance(Index node, Front& front) const {
    const Index v = several ? front.vertex_of(node) : node;
    if constexpr (several) front.reserve_more(begin_[v + 1] - begin_[v]);
    if constexpr (several) front.nodes[node].leads = front.may_lead(v, node, most_delay_);
    const Seen from{v, node, front.nodes[node].leads};
    for (Index s = begin_[v]; s < begin_[v + 1]; ++s) {
      const Spoke& here = spokes_[s];
      if (here.slack != no_face) {
        const Spoke& before = spokes_[s - 1];
        over<several>(from, s - 1, here.before, here, here.here, 1, here.slack, front);
        over<several>(from, s, here.here, before, here.before, -1, here.slack, front);
      }
      along<several>(from, s, front);
    }
  }

  template <bool several>
  void along(const Seen& vertex, Index s, Front& front) const {
    const Spoke& spoke = spokes_[s];
    const Node& from = front.nodes[vertex.node];
    const Seen end = seen<several>(spoke.end, from.wave, vertex.may_come, front);
    const double distance = from.distance + spoke.length;
    double offset = from.distance;
    const Turn u = turned_back(spoke.turn, from.back);
    const bool is_next = from.distance - from.offset <= next_to_vertex * spoke.length;
    const bool is_straight = std::fabs(u.y()) < straight && u.x() < 0 &&
                             std::fabs(spoke.angle - from.angle) < between_fans / 2;
    if (is_next || is_straight) offset = from.offset;
    if (!at<several>(end, front).is_bettered(offset, distance)) return;
    const Index n = place_for<several>(end, distance, from.wave, front);
    if (several && n < 0) return;
    const Index back = decoded(spoke.slack != no_face ? spoke.here : spokes_[s + 1].before);
    const Spoke& sight = spokes_[back];
    front.reach(n, from.wave, offset, distance, sight.turn, sight.angle, 2 * back);
  }
  static Index decoded(Index i) { return i < 0 ? ~i : i; }

  // Over spoke s of a vertex to the end of another spoke, beside it on `side` (1 after, -1 before).
  // `back_edge` is the edge as its other end has it, `sight` the edge from the target to the
  // vertex: both as in Spoke.
  template <bool several>
  [[gnu::always_inline]] void over(const Seen& from, Index s, Index back_edge, const Spoke& to,
                                   Index sight, int side, double slack, Front& front) const {
    using namespace arithmetic;
    const Spoke& edge = spokes_[s];
    const Node& first = front.nodes[from.node];
    const Seen beside = seen<several>(edge.end, first.wave, false, front);
    const Node& second = at<several>(beside, front);
    if (!second.settled) return;
    const bool may_come = from.may_come || second.leads;
    Seen target = seen<several>(to.end, first.wave, may_come, front);
    const double limit = at<several>(target, front).limit();
    if (!(limit > std::min(first.distance, second.distance) - slack)) return;
    // The target's place where the edge runs along x.
    const Vec2<double> corner =
        to.length * (side > 0 ? turned_back(to.turn, edge.turn) : turned_back(edge.turn, to.turn));
    if (first.distance < limit + slack) {
      through<several>(from.vertex, s, side, first, second, edge.length, corner, target, sight,
                       true, front);
    }
    if (second.distance < limit + slack) {
      if (several) target = seen<several>(to.end, first.wave, may_come, front);  // it may have come
      through<several>(edge.end, decoded(back_edge), back_edge < 0 ? -1 : 1, second, first,
                       edge.length, {edge.length - corner.x(), corner.y()}, target, sight, false,
                       front);
    }
  }

  // The largest angle between an edge and an image behind it, about three quarters of a turn; and
  // how many fans are looked at that may lie between, where edges have more than two faces.
  static constexpr float widest = 4.7F;
  static constexpr std::size_t most_steps = 64;

  // Whether the image of `owner` lies behind its spoke s for a face on the `side` of it, and by
  // what it is turned from the spoke. Angles of half a turn and of one and a half have the same
  // sine, so that of the fan is needed, roughly.
  [[nodiscard]] bool sees(Index v, Index s, int side, const Node& owner, Turn& u) const {
    const Spoke& spoke = spokes_[s];
    Index steps = side * (2 * s - owner.place);
    float angle = static_cast<float>(side) * (spoke.angle - owner.angle);
    const Fan& fan = fans_[v];
    if (fan.has_shared_edge) return sees_round(v, s, -side, owner, u) < widest;
    if (std::fabs(angle) > between_fans / 2) return false;
    u = side > 0 ? turned_back(spoke.turn, owner.back) : turned_back(owner.back, spoke.turn);
    if (steps < 0) {
      angle += fan.angle;
      u = turned(u, fan.whole);
    }
    return angle < widest && u.y() >= -1e-14;
  }

  // The same where an edge at the vertex has more than two faces: goes round it in one direction,
  // from the end of a fan on to all others that begin or end there. Returns by how much the nearest
  // image found is turned from spoke s, which is `u`.
  float sees_round(Index v, Index s, Index way, const Node& owner, Turn& u) const {
    struct Step {
      Index spoke, way;
      Turn turn;  // of the spoke from s
      float angle;
      Index end = -1;    // vertex of the edge at the end of the fan
      float to_end = 0;  // by how much that is turned from s
    };
    std::array<Step, most_steps> steps;
    steps[0] = {s, way, Turn(1, 0), 0};
    float least = unreachable<float>;
    for (std::size_t i = 0, count = 1; i < count; ++i) {
      Step& step = steps[i];
      const Spoke& spoke = spokes_[step.spoke];
      const auto turn_to = [&](const Turn& there) {
        return turned(step.turn, step.way > 0 ? turned_back(there, spoke.turn)
                                              : turned_back(spoke.turn, there));
      };
      const float away = static_cast<float>(step.way) * (owner.angle - spoke.angle);
      const bool is_in_fan = std::fabs(away) < between_fans / 2;
      if (is_in_fan && step.way * (owner.place - 2 * step.spoke) >= 0 &&
          step.angle + away < least) {
        const Turn seen = turn_to(owner.back);
        if (seen.y() >= -1e-14) {
          u = seen;
          least = step.angle + away;
        }
      }
      const Index end = end_of_fan(v, step.spoke, step.way);
      step.end = spokes_[end].end;
      step.to_end = step.angle + std::fabs(spokes_[end].angle - spoke.angle);
      const bool was_there = std::any_of(
          steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(i),
          [&](const Step& other) { return other.end == step.end && other.to_end <= step.to_end; });
      if (was_there || !(step.to_end < std::min(least, widest))) continue;
      for (Index t = begin_[v]; t < begin_[v + 1] && count < most_steps; ++t) {
        if (t == end || spokes_[t].end != step.end) continue;
        steps[count++] = {t, spokes_[t].slack == no_face ? 1 : -1, turn_to(spokes_[end].turn),
                          step.to_end};
      }
    }
    return least;
  }

  // The last spoke of a fan in one direction from spoke s.
  [[nodiscard]] Index end_of_fan(Index v, Index s, Index way) const {
    const auto is_in_fan = [&](Index t) {
      return t >= begin_[v] && t < begin_[v + 1] &&
             std::fabs(spokes_[t].angle - spokes_[s].angle) < between_fans / 2;
    };
    Index end = s;
    while (is_in_fan(end + way)) end += way;
    return end;
  }

  // An image in the plane of a face, in front of an edge of it: `x` along the edge from its owner,
  // `y` behind the edge.
  struct Image {
    double x, y;
  };

  // Where the circles about the ends of an edge meet.
  [[nodiscard]] static Image by_distances(double r, double known, double length) {
    const double x = (length + (r - known) * (r + known) / length) / 2;
    return {x, std::sqrt(std::max(0.0, (r - x) * (r + x)))};
  }

  // The nearer a way passes to the end that does not see the image, the more it is longer than from
  // the image: by about the square of the share of the edge, as behind a corner that hides it.
  [[nodiscard]] static Image dimmed(const Image& image, const Image& far, double r, double length,
                                    const Vec2<Real>& at) {
    const double share =
        std::clamp((image.x * at.y() + at.x() * image.y) / ((at.y() + image.y) * length), 0.0, 1.0);
    const double x = image.x + share * (far.x - image.x);
    return {x, std::sqrt(std::max(0.0, (r - x) * (r + x)))};
  }

  [[nodiscard]] static double distance_to(const Image& image, const Vec2<Real>& at) {
    const double aside = at.x() - image.x, total = at.y() + image.y;
    return std::sqrt(aside * aside + total * total);
  }

  [[nodiscard]] static bool crosses(const Image& image, const Vec2<Real>& at, double length) {
    const double at_edge = image.x * at.y() + at.x() * image.y;
    return (at_edge >= 0) & (at_edge <= (at.y() + image.y) * length);
  }

  // Hands on the image of `owner`, vertex v, over its spoke s. What the `other` end of the edge
  // says may be corrected later: until the target's turn comes, a way that the other end does not
  // see is as long as what both ends say makes it, which is never too short.
  template <bool several>
  void through(Index v, Index s, int side, const Node& owner, const Node& other, double length,
               const Vec2<Real>& corner, const Seen& seen, Index sight, bool owner_is_sighted,
               Front& front) const {
    const Node& target = at<several>(seen, front);
    Turn u;
    const double r = owner.distance - owner.offset;
    if (!(r > next_to_vertex * length)) return;
    if (!sees(v, s, side, owner, u)) return;
    const double x = r * u.x(), y = r * std::max(0.0, u.y());
    Image image{x, y};
    // What hides the image from the other end hides it in part from what lies behind the edge.
    const double known = other.distance - owner.offset;
    const double seen2 = (x - length) * (x - length) + y * y;
    // The spoke from the target to the owner, and whether the other end comes after it.
    const Index to_owner = owner_is_sighted ? decoded(sight) : sight >= 0 ? sight + 1 : ~sight - 1;
    const bool after = (sight >= 0) == owner_is_sighted;
    const Index place = after ? 2 * to_owner + 1 : 2 * to_owner - 1;
    bool is_clear = !(known > 0 && known * known * (1 - 1e-12) > seen2);
    if (!is_clear) {
      const Image far = by_distances(r, known, length);
      const Image between = dimmed(image, far, r, length, corner);
      if (target.settled) {
        image = between;
      } else {
        if (crosses(between, corner, length)) {
          const double d = owner.offset + distance_to(between, corner);
          if (d < target.promise) {
            promise<several>(seen, owner.wave, d, after ? place : -place, front);
          }
        }
        image = far;
      }
    }
    if (!crosses(image, corner, length)) return;
    const double straight_line = distance_to(image, corner);
    double distance = owner.offset + straight_line;
    if (!target.is_bettered(owner.offset, distance, is_clear)) return;
    const double least = least_distance(seen.vertex, owner.wave, front);
    if (distance < least) {
      is_clear &= distance > least - rounding * (r + length);
      distance = least;
      if (!target.is_bettered(owner.offset, distance, is_clear)) return;
    }
    const Index n = place_for<several>(seen, distance, owner.wave, front);
    if (several && n < 0) return;
    const Turn back = back_to(image, corner, straight_line, to_owner, after);
    const Index other_spoke = after ? to_owner + 1 : to_owner - 1;
    front.reach(n, owner.wave, owner.offset, distance, back,
                (spokes_[to_owner].angle + spokes_[other_spoke].angle) / 2, place, is_clear);
  }

  template <bool several>
  void promise(const Seen& seen, Index wave, double distance, Index place, Front& front) const {
    const Index n = place_for<several>(seen, distance, wave, front);
    if (several && n < 0) return;
    front.nodes[n].promise = distance;
    front.nodes[n].promised = place;
    if (several) front.nodes[n].wave = wave;
  }

  // The direction of an image at the target, from the spoke to its owner towards the other end.
  [[nodiscard]] Turn back_to(const Image& image, const Vec2<Real>& at, double distance,
                             Index to_owner, bool after) const {
    const double aside = at.x() - image.x, total = at.y() + image.y;
    const double inverse = 1 / (distance * spokes_[to_owner].length);
    Turn c((aside * at.x() + total * at.y()) * inverse,
           (total * at.x() - at.y() * aside) * inverse);
    if (!after) c.y() = -c.y();
    return turned(spokes_[to_owner].turn, c);
  }

  // Takes what was promised, as it is now.
  template <bool several>
  void refine(Index n, Front& front) const {
    Node& vertex = front.nodes[n];
    if (!(vertex.promise < vertex.distance)) return;
    const bool by_before = vertex.promised > 0;
    const Index place = by_before ? vertex.promised : -vertex.promised;
    const Index corner = (place + 1) / 2;
    const Spoke &here = spokes_[corner], &before = spokes_[corner - 1];
    const Spoke& to_owner = by_before ? before : here;
    const Spoke& to_other = by_before ? here : before;
    const Node& owner = front.nodes[several ? front.find(to_owner.end, vertex.wave) : to_owner.end];
    const Node& other = front.nodes[several ? front.find(to_other.end, vertex.wave) : to_other.end];
    const Index sight = by_before ? here.before : here.here;
    const Index s = sight >= 0 ? sight + 1 : ~sight - 1;
    Turn u;
    const double r = owner.distance - owner.offset;
    if (!(r > 0) || !sees(to_owner.end, s, sight >= 0 ? -1 : 1, owner, u)) return;
    const double length = spokes_[s].length;
    const double known = other.distance - owner.offset;
    Image image{r * u.x(), r * std::max(0.0, u.y())};
    const double seen2 = (image.x - length) * (image.x - length) + image.y * image.y;
    const Turn opening = turned_back(here.turn, before.turn);
    const double dot = to_owner.length * to_other.length * opening.x();
    const Vec2<Real> at((to_owner.length * to_owner.length - dot) / length,
                        to_owner.length * to_other.length * opening.y() / length);
    if (known > 0 && known * known > seen2) {
      image = dimmed(image, by_distances(r, known, length), r, length, at);
    }
    if (!crosses(image, at, length)) return;
    const double d = distance_to(image, at);
    const Index v = several ? front.vertex_of(n) : n;
    const double distance = std::max(owner.offset + d, least_distance(v, vertex.wave, front));
    if (!(distance < vertex.distance)) return;
    vertex.distance = distance;
    vertex.is_clear = false;
    vertex.offset = owner.offset;
    vertex.place = place;
    vertex.angle = (here.angle + before.angle) / 2;
    vertex.back = back_to(image, at, d, by_before ? corner - 1 : corner, by_before);
  }

  void lay_out_fans() {
    OneRing spokes(surface_);
    const PlanarFaces<double> faces(surface_);
    const auto count = static_cast<std::size_t>(surface_.vertex_count());
    begin_.reserve(count + 1);
    begin_.push_back(0);
    fans_.reserve(count);
    corner_spoke_.resize(static_cast<std::size_t>(surface_.halfedge_count()));
    PeriodicCheck progress(cancelled_, surface_.vertex_count(), "the set-up of virtual sources");
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      progress.step();
      int fans = 0;
      spokes.visit(v, [&](Index edge, Index corner) {
        const Index end = surface_.origin(edge) == v ? surface_.tip(edge) : surface_.origin(edge);
        Spoke spoke{end, no_face, surface_.length(edge), Turn(1, 0), 0, 0, 0};
        if (corner < 0) {
          spoke.angle = between_fans * static_cast<float>(fans++);
        } else {
          const Spoke& last = spokes_.back();
          const auto& apex = faces.apex(corner);
          const double norm = stable_norm(apex);
          const Turn opening = norm > 0 ? Turn(apex.x() / norm, apex.y() / norm) : Turn(1, 0);
          spoke.turn = turned(last.turn, opening);
          spoke.turn /= stable_norm(spoke.turn);
          spoke.angle = last.angle + static_cast<float>(std::atan2(opening.y(), opening.x()));
          spoke.slack = unevenness(corner);
          corner_spoke_[corner] = static_cast<Index>(spokes_.size());
        }
        spokes_.push_back(spoke);
      });
      begin_.push_back(static_cast<Index>(spokes_.size()));
      const Index first = begin_[v], last = begin_[v + 1] - 1;
      const bool closed = fans == 1 && last > first + 1 && spokes_[first].end == spokes_[last].end;
      const auto corners = surface_.corners(v);
      const bool has_shared_edge = std::any_of(corners.begin(), corners.end(), [&](Index h) {
        return !surface_.is_manifold(h) || !surface_.is_manifold(Mesh::previous(h));
      });
      fans_.push_back(closed ? Fan{spokes_[last].turn, spokes_[last].angle, false}
                             : Fan{Turn(1, 0), 1e6F, has_shared_edge});
    }
  }

  void link_fans() {
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      Spoke& spoke = spokes_[corner_spoke_[h]];
      const Index v = surface_.origin(h);
      const auto sight = [&](Index corner) {
        const Index s = corner_spoke_[corner];
        return spokes_[s].end == v ? ~s : s - 1;
      };
      const Index next = Mesh::next(h), previous = Mesh::previous(h);
      const bool tip_is_here = surface_.origin(next) == spoke.end;
      spoke.here = sight(tip_is_here ? next : previous);
      spoke.before = sight(tip_is_here ? previous : next);
    }
  }

  // The slack of a face. A way over its edge (a, b) at x to its third vertex t is longer than the
  // way to a by at least |x t| - |x a|, which is least where x = b.
  [[nodiscard]] float unevenness(Index h) const {
    const double a = surface_.length(h), b = surface_.length(surface_.next(h));
    const double c = surface_.length(surface_.previous(h));
    const double uneven = std::max({a, b, c}) - std::min({a, b, c});
    using Limits = std::numeric_limits<float>;  // rounded up, also where it is next to nothing
    return static_cast<float>(uneven) * (1 + Limits::epsilon()) + Limits::min();
  }

  Surface<Real> surface_;
  CancelHook cancelled_;
  double step_ = 0;
  double most_delay_ = 0;  // by which a wave may be late at a vertex and still be handed on
  Array<Index> begin_;     // of each vertex, and one more: where its spokes begin
  Array<Spoke> spokes_;
  Array<Fan> fans_;
  Array<Index> corner_spoke_;
  std::shared_ptr<Pool<Front>> pool_ = std::make_shared<Pool<Front>>();
};

template <std::floating_point Real>
void VirtualSourceEngine<Real>::solve_vertices(DistanceQuery<double>& query) const {
  auto& sources = query.sources;
  // Shares are of distances from 0 on, so that is where the earliest source starts.
  query.starts.move_to_zero(surface_, sources);
  const typename Pool<Front>::Borrowed borrowed(*pool_);
  Front& front = *borrowed;
  front.reset(surface_.vertex_count());
  front.queue.reset(step_);
  if (sources.size() > 1) keep_different(surface_, sources);
  Index wave = 0;
  keep_places(sources, front);
  for (const auto& source : sources) start(source, wave++, front);
  if (sources.size() > 1) {
    march<true>(front);
  } else {
    march<false>(front);
  }
  take_distances(front, query);
}

}  // namespace gelight::detail
