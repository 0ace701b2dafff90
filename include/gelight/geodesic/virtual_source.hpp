#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/detail/bucket_queue.hpp"
#include "gelight/geodesic/detail/near.hpp"
#include "gelight/geodesic/detail/pool.hpp"
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
/// Error, mean and largest: icospheres of 642 to 655,362 vertices 0.22 % and 0.37 % to 0.00013 %
/// and 0.012 %, falling with order 2; against exact distances on the GelTip membrane 0.17 % and 5.4
/// %, on a sphere stretched tenfold 0.002 % and 0.14 %. A query takes about linear time.
template <std::floating_point T>
class VirtualSourceSolver : public detail::DistanceQueries<VirtualSourceSolver<T>, T> {
 public:
  /// Throws InvalidInput as Surface does.
  template <TriangleMesh M>
  explicit VirtualSourceSolver(const M& mesh) : surface_(mesh) {
    step_ = detail::short_edge_length(surface_);
    corner_begin_.push_back(0);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      for (const Index h : surface_.corners(v)) {
        corners_.push_back({surface_.tip(h), surface_.apex(h)});
      }
      corner_begin_.push_back(static_cast<Index>(corners_.size()));
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
    front.images.assign(static_cast<std::size_t>(surface_.vertex_count()), {});
    front.settled.assign(front.images.size(), 0);
    front.queue.reset(step_);
    for (const auto& source : sources) {
      const double offset = source.distance;
      const auto point = detail::simplified(surface_, source.point);
      const Vec3<double> position = surface_.position(point);
      detail::for_each_vertex_near(surface_, point, [&](Index v, double d) {
        if (offset + d < front.images[v].distance) front.reach(v, {position, offset, offset + d});
      });
    }
    while (!front.queue.empty()) {
      const auto [v, d] = front.queue.pop();
      if (d > front.images[v].distance) continue;  // reached on a shorter way since
      front.settled[v] = 1;
      for (Index c = corner_begin_[v]; c < corner_begin_[v + 1]; ++c) {
        advance(v, corners_[c].tip, corners_[c].apex, front);
      }
    }
    detail::Array<double> distance(front.images.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      distance[v] = earliest + front.images[v].distance;
    }
    return distance;
  }

  /// The other two vertices of one of a vertex' faces.
  struct Corner {
    Index tip, apex;
  };

  /// Where a vertex sees its source: `distance` is `offset` and the straight line to it.
  struct Image {
    Vec3<double> position = Vec3<double>::Zero();
    double offset = 0;
    double distance = unreachable<double>;
  };

  struct Front {
    detail::Array<Image> images;  // of each vertex
    detail::Array<char> settled;  // of each vertex: not in the queue, having been there
    detail::BucketQueue queue;

    // How long a new line may be at most to serve a vertex, given what precedes it.
    [[nodiscard]] double room(Index v, double offset) const {
      const Image& held = images[v];
      return held.distance * (offset < held.offset ? 1 + tie : 1 - least_gain) - offset;
    }
    [[nodiscard]] bool is_better(Index v, double offset, double distance) const {
      const Image& held = images[v];
      return distance < held.distance * (1 - least_gain) ||
             (offset < held.offset / 2 && distance < held.distance * (1 + tie));
    }
    void reach(Index v, const Image& image) {
      images[v] = image;
      settled[v] = 0;
      queue.push(v, image.distance);
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

  // Reaches the other two vertices of a face of v: along the edges from v, and through them with
  // the images that both ends of the edge hold.
  void advance(Index v, Index tip, Index apex, Front& front) const {
    const Vec3<double>& at = surface_.position(v);
    const Vec3<double> to_tip = surface_.position(tip) - at;
    const Vec3<double> to_apex = surface_.position(apex) - at;
    const double tip2 = to_tip.squaredNorm(), apex2 = to_apex.squaredNorm();
    along(v, tip, tip2, front);
    along(v, apex, apex2, front);
    // An edge is crossed when the second of its ends comes out of the queue.
    if (!front.settled[tip] && !front.settled[apex]) return;
    const double dot = to_tip.dot(to_apex);
    const double area2 = cross<double>(to_tip, to_apex).squaredNorm();
    if (front.settled[tip]) {
      const Crossing c{v, tip, apex, to_tip, to_apex, tip2, dot / tip2, area2 / tip2};
      through(c, v, tip, front);
      through(c, tip, v, front);
    }
    if (front.settled[apex]) {
      const Crossing c{v, apex, tip, to_apex, to_tip, apex2, dot / apex2, area2 / apex2};
      through(c, v, apex, front);
      through(c, apex, v, front);
    }
  }

  void along(Index v, Index w, double squared_length, Front& front) const {
    const double d = front.images[v].distance;
    const double room = front.room(w, d);
    if (!(room > 0 && squared_length < room * room)) return;
    const double distance = d + std::sqrt(squared_length);
    if (front.is_better(w, d, distance)) front.reach(w, {surface_.position(v), d, distance});
  }

  /// A vertex as seen across an edge of its face, from the edge's first end; `foot` is how far
  /// along the edge it lies, in shares of the edge.
  struct Crossing {
    Index first, second, target;
    Vec3<double> edge, to_target;
    double squared_length, foot, squared_height;
  };

  // Hands on the image of `owner`, one end of the edge, that is seen from the `other` end too.
  void through(const Crossing& c, Index owner, Index other, Front& front) const {
    const Image& image = front.images[owner];
    const double room = front.room(c.target, image.offset);
    const Vec3<double> to_image = image.position - surface_.position(c.first);
    const double foot = to_image.dot(c.edge) / c.squared_length;
    const double squared_depth = (to_image - foot * c.edge).squaredNorm();
    // Most are not shorter, which is seen before any root: with depth and height on one line,
    // (depth + height)^2 + aside^2 < room^2.
    const double aside = c.foot - foot;
    const double squared_aside = aside * aside * c.squared_length;
    const double rest = room * room - c.squared_height - squared_depth - squared_aside;
    if (!(room > 0 && rest > 0 && 4 * c.squared_height * squared_depth < rest * rest)) return;
    const double least = front.images[other].distance * (1 - largest_disagreement) - image.offset;
    const double share = other == c.first ? foot : 1 - foot;
    if (least > 0 && share * share * c.squared_length + squared_depth < least * least) return;

    const double depth = std::sqrt(squared_depth), height = std::sqrt(c.squared_height);
    const double at_edge = foot * height + c.foot * depth;
    if (!(at_edge >= 0 && at_edge <= height + depth)) return;
    const double total = height + depth;
    const double distance = image.offset + std::sqrt(squared_aside + total * total);
    if (!front.is_better(c.target, image.offset, distance)) return;
    front.reach(c.target, {unfolded(image.position, c, foot, depth), image.offset, distance});
  }

  // An image turned about the edge into the plane of the target's face, on the side away from it. A
  // face without area has no plane; as a way over the edge the image is right where it is.
  [[nodiscard]] Vec3<double> unfolded(const Vec3<double>& image, const Crossing& c, double foot,
                                      double depth) const {
    // Made orthogonal twice: in a face of hardly any area the first time leaves rounding's part.
    Vec3<double> upright = c.to_target - c.foot * c.edge;
    upright -= upright.dot(c.edge) / c.squared_length * c.edge;
    const double height = upright.norm();
    if (height == 0) return image;
    return surface_.position(c.first) + foot * c.edge - depth / height * upright;
  }

  Surface<double> surface_;
  double step_ = 0;
  detail::Array<Index> corner_begin_;  // of each vertex, and one more
  detail::Array<Corner> corners_;
  std::shared_ptr<detail::Pool<Front>> pool_ = std::make_shared<detail::Pool<Front>>();
};

template <TriangleMesh M>
explicit VirtualSourceSolver(const M&) -> VirtualSourceSolver<MeshScalar<M>>;

static_assert(DistanceSolver<VirtualSourceSolver<double>, double>);

}  // namespace gelight
