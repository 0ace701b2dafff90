#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/detail/bucket_queue.hpp"
#include "gelight/geodesic/detail/fetch_ahead.hpp"
#include "gelight/geodesic/detail/near.hpp"
#include "gelight/geodesic/detail/pool.hpp"
#include "gelight/geodesic/detail/spokes.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// Distance by virtual sources (after Trettner, Bommes, Kobbelt 2021, doi:10.1111/cgf.14371): each
/// vertex keeps one image of the source, unfolded into the plane of the face it was reached
/// through, and hands it on to the vertices it shows in the faces around.
///
/// Label-correcting: a vertex hands on its image again when it gets a better one, so obtuse and
/// thin triangles cost no accuracy; of two ways equally long it keeps the straighter. Exact on flat
/// sheets without holes, through faces without area too, but for what needles make of rounding: on
/// sheets of 40 x 40 to 100 x 100 cells, stretched or graded up to 1e6 times or sheared up to 1e4
/// times, 2e-5 (mean) and 1.5 % (at a vertex) where it was most, mostly below 1e-8. Where a
/// border's corner or a saddle hides an image from one end of an edge, it is not handed through
/// that edge: behind a square hole in a sheet 0.1 % on average, 4 % at a vertex. Where faces turn
/// sharply, a vertex' one image is less right in the planes of its other faces: a prism of 16 sides
/// 0.02 %, 0.2 % at most.
///
/// Error, mean and largest: icospheres of 642 to 655,362 vertices 0.23 % and 0.40 % to 0.00014 %
/// and 0.012 %, falling with order 2; against exact distances on the GelTip membrane 0.17 % and 5.4
/// %, on a sphere stretched tenfold 0.002 % and 0.09 %. A query takes about linear time.
template <std::floating_point T>
class VirtualSourceSolver : public detail::DistanceQueries<VirtualSourceSolver<T>, T> {
 public:
  /// Throws InvalidInput as Surface does.
  template <TriangleMesh M>
  explicit VirtualSourceSolver(const M& mesh) : surface_(mesh) {
    step_ = detail::short_edge_length(surface_);
    detail::Spokes spokes(surface_);
    begin_.reserve(static_cast<std::size_t>(surface_.vertex_count()) + 1);
    begin_.push_back(0);
    spokes_.reserve(static_cast<std::size_t>(surface_.halfedge_count()) +
                    static_cast<std::size_t>(surface_.vertex_count()));
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      spokes.visit(v, [&](Index edge, Index corner) {
        const Index end = surface_.origin(edge) == v ? surface_.tip(edge) : surface_.origin(edge);
        spokes_.push_back({end, corner < 0 ? no_face : unevenness(corner)});
      });
      begin_.push_back(static_cast<Index>(spokes_.size()));
      most_spokes_ = std::max(most_spokes_, begin_[v + 1] - begin_[v]);
    }
  }

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

 private:
  friend class detail::DistanceQueries<VirtualSourceSolver<T>, T>;

  [[nodiscard]] detail::Array<double> solve_vertices(detail::Sources sources) const {
    // Shares are of distances from 0 on, so that is where the earliest source starts.
    const double earliest = detail::move_to_zero(sources);
    const typename detail::Pool<Front>::Borrowed borrowed(*pool_);
    Front& front = *borrowed;
    clear(front);
    for (const auto& source : sources) {
      const double offset = source.distance;
      const auto point = detail::simplified(surface_, source.point);
      const Vec3<double> position = surface_.position(point);
      detail::for_each_vertex_near(surface_, point, [&](Index v, double d) {
        if (offset + d < front.vertices[v].distance) front.reach(v, position, offset, offset + d);
      });
    }
    while (!front.queue.empty()) {
      const Index v = detail::pop_and_fetch(front.queue, begin_, spokes_, front.vertices);
      if (front.settled[v]) continue;  // it is in the queue for every time that it came nearer
      front.settled[v] = 1;
      advance(v, front);
    }
    detail::Array<double> distance(front.vertices.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      distance[v] = earliest + front.vertices[v].distance;
    }
    return distance;
  }

  /// An edge at a vertex, of its fan in order: the other end, and by how much a way over an edge of
  /// the face between this one and the one before may be shorter than to an end of that edge.
  struct Spoke {
    Index end;
    float slack;
  };
  static constexpr float no_face = -unreachable<float>;  // no way over it is short enough

  /// A vertex, and where it sees its source: `distance` is `offset` and the straight line to
  /// `image`. All that its neighbours ask for is in one line of the cache.
  struct alignas(64) Vertex {
    Vec3<double> position = Vec3<double>::Zero();
    Vec3<double> image = Vec3<double>::Zero();
    double offset = 0;
    double distance = unreachable<double>;

    [[nodiscard]] bool is_bettered(double new_offset, double new_distance) const {
      return new_distance < distance * (1 - least_gain) ||
             (new_offset < offset / 2 && new_distance < limit());
    }
    // Ways as long as this, or longer, are of no use.
    [[nodiscard]] double limit() const { return distance * (1 + tie); }
  };

  /// An edge as seen from one of its ends.
  struct Neighbour {
    Vec3<double> edge;
    double squared_length;
    double limit;  // of the vertex at the other end
    double least;  // no way over this edge is shorter by more than the slack of the face
    double slack;  // of the face between this edge and the one before
    Index vertex;
  };

  struct Front {
    detail::Array<Vertex> vertices;
    detail::Array<char> settled;   // of each vertex: not in the queue, having been there
    detail::Array<Neighbour> fan;  // of the vertex in turn
    detail::BucketQueue queue;

    void reach(Index v, const Vec3<double>& image, double offset, double distance) {
      Vertex& vertex = vertices[v];
      const bool in_place = !settled[v] && queue.are_together(vertex.distance, distance);
      vertex.image = image;
      vertex.offset = offset;
      vertex.distance = distance;
      settled[v] = 0;
      if (!in_place) queue.push(v, distance);
    }
  };

  // A vertex is reached again only by a way that is shorter by more than rounding, as a share. Of
  // two ways nearly equally long, the one that is straight for longer shows more of what lies
  // behind: needles bend ways by less than rounding. It must bend less than half as far out, lest
  // a vertex is reached anew from every spoke of a fan.
  static constexpr double least_gain = 1e-10, tie = 1e-12;

  // An image that shows a vertex nearer than it is, by more than this share, is hidden from it by
  // something in between, and is not handed on beside it.
  static constexpr double largest_disagreement = 3e-3;

  void clear(Front& front) const {
    const auto count = static_cast<std::size_t>(surface_.vertex_count());
    if (front.vertices.empty()) {
      front.vertices.resize(count);
      for (Index v = 0; v < surface_.vertex_count(); ++v) {
        front.vertices[v].position = surface_.position(v);
      }
      front.fan.resize(static_cast<std::size_t>(most_spokes_));
    }
    for (Vertex& vertex : front.vertices) vertex.distance = unreachable<double>;
    front.settled.assign(count, 0);
    front.queue.reset(step_);
  }

  // Reaches the neighbours of a vertex: along the edges, and over them with the images that their
  // two ends hold. Here and below, conditions that nobody can foresee are joined by `&`, which
  // makes one branch of them.
  void advance(Index v, Front& front) const {
    const Vertex& vertex = front.vertices[v];
    const Index count = begin_[v + 1] - begin_[v];
    look_round(v, front);
    const Neighbour* fan = front.fan.data();
    for (Index i = 1; i < count; ++i) {
      const Neighbour &before = fan[i - 1], &here = fan[i];
      if (here.limit > before.least - here.slack) over(vertex, before, here, here.slack, front);
      if (before.limit > here.least - here.slack) over(vertex, here, before, here.slack, front);
      along(vertex, before, front);
    }
    if (count > 0) along(vertex, fan[count - 1], front);
  }

  // Fills the fan of a vertex.
  void look_round(Index v, Front& front) const {
    const Vec3<double> at = front.vertices[v].position;
    const double distance = front.vertices[v].distance;
    Neighbour* neighbour = front.fan.data();
    const Vertex* vertices = front.vertices.data();
    const char* settled = front.settled.data();
    const Spoke* last = spokes_.data() + begin_[v + 1];
    const double seen = distance * (1 - largest_disagreement);
    for (const Spoke* spoke = spokes_.data() + begin_[v]; spoke != last; ++spoke, ++neighbour) {
      const Index end = spoke->end;
      const Vertex& other = vertices[end];
      neighbour->vertex = end;
      neighbour->slack = spoke->slack;
      neighbour->edge = other.position - at;
      neighbour->squared_length = neighbour->edge.squaredNorm();
      neighbour->limit = other.limit();
      // An edge is crossed when the second of its ends comes out of the queue, from either end, and
      // with no image that shows the other too near.
      neighbour->least =
          settled[end] ? std::max(std::min(distance, other.distance), seen) : unreachable<double>;
    }
  }

  void along(const Vertex& from, const Neighbour& to, Front& front) const {
    const Vertex& target = front.vertices[to.vertex];
    const double room = target.limit() - from.distance;
    if (!((room > 0) & (to.squared_length < room * room))) return;
    const double distance = from.distance + std::sqrt(to.squared_length);
    if (!target.is_bettered(from.distance, distance)) return;
    front.reach(to.vertex, from.position, from.distance, distance);
  }

  /// A vertex as seen across an edge of its face, from the edge's first end; `foot` is how far
  /// along the edge it lies, in shares of the edge.
  struct Crossing {
    const Vertex& first;
    const Neighbour& edge;
    const Neighbour& to;
    double inverse_square, foot, squared_height;
  };

  void over(const Vertex& first, const Neighbour& edge, const Neighbour& to, double slack,
            Front& front) const {
    const Vertex& second = front.vertices[edge.vertex];
    // A way over an edge is not shorter, but for the slack, than to either of its ends.
    const double limit = to.limit + slack;
    const double rest = limit - second.offset;
    const bool with_first = first.distance < limit;
    const bool with_second =
        (second.distance < limit) & ((second.image - first.position).squaredNorm() < rest * rest);
    if (!(with_first | with_second) || edge.squared_length == 0) return;
    const double inverse = 1 / edge.squared_length;
    const Crossing c{first,
                     edge,
                     to,
                     inverse,
                     edge.edge.dot(to.edge) * inverse,
                     cross<double>(edge.edge, to.edge).squaredNorm() * inverse};
    if (with_first) through(c, first, second, front);
    if (with_second) through(c, second, first, front);
  }

  // Hands on the image of `owner`, one end of the edge, that is seen from the `other` end too.
  void through(const Crossing& c, const Vertex& owner, const Vertex& other, Front& front) const {
    const Vertex& target = front.vertices[c.to.vertex];
    const double square = c.edge.squared_length;
    const double room = target.limit() - owner.offset;
    const Vec3<double> to_image = owner.image - c.first.position;
    const double foot = to_image.dot(c.edge.edge) * c.inverse_square;
    const double squared_depth = (to_image - foot * c.edge.edge).squaredNorm();
    // Most are not shorter, which is seen before any root: with depth and height on one line,
    // (depth + height)^2 + aside^2 < room^2.
    const double aside = c.foot - foot;
    const double squared_aside = aside * aside * square;
    const double rest = room * room - c.squared_height - squared_depth - squared_aside;
    if (!((room > 0) & (rest > 0) & (4 * c.squared_height * squared_depth < rest * rest))) return;
    const double least = other.distance * (1 - largest_disagreement) - owner.offset;
    const double share = &other == &c.first ? foot : 1 - foot;
    if ((least > 0) & (share * share * square + squared_depth < least * least)) return;

    const double depth = std::sqrt(squared_depth), height = std::sqrt(c.squared_height);
    const double at_edge = foot * height + c.foot * depth;
    const double total = height + depth;
    if (!((at_edge >= 0) & (at_edge <= total))) return;
    const double distance = owner.offset + std::sqrt(squared_aside + total * total);
    if (!target.is_bettered(owner.offset, distance)) return;
    front.reach(c.to.vertex, unfolded(owner.image, c, foot, depth), owner.offset, distance);
  }

  // An image turned about the edge into the plane of the target's face, on the side away from it. A
  // face without area has no plane; as a way over the edge the image is right where it is.
  [[nodiscard]] static Vec3<double> unfolded(const Vec3<double>& image, const Crossing& c,
                                             double foot, double depth) {
    // Made orthogonal twice: in a face of hardly any area the first time leaves rounding's part.
    const Vec3<double>& edge = c.edge.edge;
    Vec3<double> upright = c.to.edge - c.foot * edge;
    upright -= upright.dot(edge) * c.inverse_square * edge;
    const double height = upright.norm();
    if (height == 0) return image;
    return c.first.position + foot * edge - depth / height * upright;
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

  Surface<double> surface_;
  double step_ = 0;
  Index most_spokes_ = 0;       // of any vertex
  detail::Array<Index> begin_;  // of each vertex, and one more: where its spokes begin
  detail::Array<Spoke> spokes_;
  std::shared_ptr<detail::Pool<Front>> pool_ = std::make_shared<detail::Pool<Front>>();
};

template <TriangleMesh M>
explicit VirtualSourceSolver(const M&) -> VirtualSourceSolver<MeshScalar<M>>;

}  // namespace gelight
