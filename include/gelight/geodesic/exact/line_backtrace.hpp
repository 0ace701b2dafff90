#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Follows shortest paths back to their sources, from what the vertices remember.
template <std::floating_point Real>
class LineBacktrace {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;

  LineBacktrace(const Mesh& surface, const PlanarFaces<Real>& faces,
                const std::vector<Source<Real>>& sources, const Array<Real>& distances,
                const Array<Arrival>& arrivals, const Array<Origin>& origins,
                const std::vector<SegmentFront<Real>>& fronts)
      : surface_(surface),
        faces_(faces),
        sources_(sources),
        distances_(distances),
        arrivals_(arrivals),
        origins_(origins),
        fronts_(fronts) {}

  /// The path from `from`, at `at` in the frame of half-edge `last.entry` (where there is one), to
  /// the source.
  [[nodiscard]] std::vector<Point> back(const Point& from, const Vec2<Real>& at,
                                        const Arrival& last) const {
    std::vector<Point> path{from};
    const Index vertex = last_piece(at, last, unreachable<Real>, path);
    return from_vertex(vertex, std::move(path));
  }

  /// The path from a vertex to the source, after what is there already.
  [[nodiscard]] std::vector<Point> from_vertex(Index vertex, std::vector<Point> path) const {
    // Every vertex on the way is nearer than the one before, or by rounding they would be endless.
    for (Index left = surface_.vertex_count(); vertex >= 0 && left > 0; --left) {
      append(path, vertex_point<Real>(vertex));
      const Arrival& last = arrivals_[vertex];
      const Vec2<Real> at = last.entry < 0 ? Vec2<Real>(0, 0) : faces_.apex(last.entry);
      const Index next = last_piece(at, last, distances_[vertex], path);
      if (next == vertex) break;
      vertex = next;
    }
    return path;
  }

 private:
  static constexpr Index arrived = -1;
  // A vertex beside the path is on it when the way by it is longer by rounding of the whole only.
  static constexpr Real rounding = 16 * std::numeric_limits<Real>::epsilon();

  static void append(std::vector<Point>& path, const Point& point) {
    if (!(path.back() == point)) path.push_back(point);
  }

  // Goes back over one straight piece, from a place at a distance; returns the vertex where it
  // begins, or `arrived`.
  Index last_piece(const Vec2<Real>& at, const Arrival& last, Real distance,
                   std::vector<Point>& path) const {
    if (last.entry == Arrival::from_vertex) return last.origin;
    if (last.entry == Arrival::from_source) return reach_source(last.origin, path);
    return cross_faces(at, last, distance, path);
  }

  Index reach_source(Index source, std::vector<Point>& path) const {
    append(path, sources_[static_cast<std::size_t>(source)].point);
    return arrived;
  }

  // To where the line from `at` to the image meets a segment in h's face.
  Index reach_front(Index number, Index h, const Vec2<Real>& at, const Vec2<Real>& image,
                    std::vector<Point>& path) const {
    const SegmentFront<Real>& front = fronts_[static_cast<std::size_t>(number)];
    const auto in_frame = [&](const std::array<Real, 3>& shares) -> Vec2<Real> {
      const Real at_tip = shares[static_cast<std::size_t>((h + 1) % 3)];
      const Real at_apex = shares[static_cast<std::size_t>((h + 2) % 3)];
      const Vec2<Real>& apex = faces_.apex(h);
      return {at_tip * surface_.length(h) + at_apex * apex.x(), at_apex * apex.y()};
    };
    const Vec2<Real> a = in_frame(front.begin), along = in_frame(front.end) - a;
    const Vec2<Real> line = stable_unit(image - at), from = at - a;
    const Real t =
        (from.x() * line.y() - from.y() * line.x()) / (along.x() * line.y() - along.y() * line.x());
    append(path,
           simplified(surface_, face_point(front.face, front.at(std::clamp(t, Real(0), Real(1))))));
    return arrived;
  }

  // Goes back straight through faces; returns the vertex at which the straight line ends. It is
  // nearer to the source, or at the place of the last one and new, or in needles and on edges of no
  // length the way could go in a circle.
  Index cross_faces(Vec2<Real> at, const Arrival& last, Real distance,
                    std::vector<Point>& path) const {
    Index h = last.entry, origin = last.origin;
    Vec2<Real> image = last.image;
    Real bend = last.bend;
    const Real start = origins_[last.origin].start;
    const Real tie = rounding * (start + (at - image).norm());
    // A shortest path crosses a face once; by rounding it may go round the tip of a needle.
    for (Index left = surface_.face_count(); left > 0; --left) {
      const Real length = surface_.length(h);
      if (length == 0) return nearer_end(h, 0, distance);
      const Real x = bend < 0 ? crossing(at, image, length) : bend;
      bend = Arrival::straight;
      const bool near_origin = 2 * x < length;
      const Index beside = near_origin ? surface_.origin(h) : surface_.tip(h);
      const Real gap = near_origin ? x : length - x;
      const Real rest = start + (Vec2<Real>(x, 0) - image).norm();
      const bool is_back =
          distances_[beside] < distance || (distances_[beside] == distance && !is_on(path, beside));
      if (is_back && distances_[beside] + gap <= rest + tie) return beside;
      append(path, edge_point<Real>(surface_.origin(h), surface_.tip(h), x / length));

      Index across = surface_.twin(h);
      if (origins_[origin].kind == Origin::Kind::crossing) {
        across = surface_.is_manifold(h) ? across : origins_[origin].index;
        if (!surface_.is_manifold(h)) origin = origins_[origin].previous;
      }
      if (across == h) return nearer_end(h, x, distance);
      if (surface_.origin(across) != surface_.origin(h)) {
        at = {length - x, 0};
        image = {length - image.x(), -image.y()};
      } else {
        at = {x, 0};
        image = {image.x(), -image.y()};
      }
      if (is_in_face(origin, across)) {
        const Origin& o = origins_[origin];
        if (o.kind == Origin::Kind::front) return reach_front(o.index, across, at, image, path);
        return o.kind == Origin::Kind::vertex ? o.index : reach_source(o.index, path);
      }
      h = step(across, at, image);
    }
    return arrived;
  }

  static bool is_on(const std::vector<Point>& path, Index vertex) {
    return std::find(path.begin(), path.end(), vertex_point<Real>(vertex)) != path.end();
  }

  static Real crossing(const Vec2<Real>& at, const Vec2<Real>& image, Real length) {
    const Real height = at.y() - image.y();
    if (!(height > 0)) return std::clamp(at.x(), 0.0, length);
    return std::clamp(image.x() + (at.x() - image.x()) * (-image.y() / height), 0.0, length);
  }

  // The line from `at` on half-edge h to the image beyond h's face: returns the half-edge by which
  // it leaves the face, with both points in its frame.
  Index step(Index h, Vec2<Real>& at, Vec2<Real>& image) const {
    const Vec2<Real> apex = faces_.apex(h), tip(surface_.length(h), 0);
    const Vec2<Real> from_tip = faces_.apex_from_tip(surface_, h);
    const Vec2<Real> to_image = image - at, to_apex = apex - at;
    const bool is_right = to_image.x() * to_apex.y() - to_image.y() * to_apex.x() > 0;
    const auto by = [&](bool right) {
      return right ? side(Mesh::next(h), tip, {-from_tip.x(), from_tip.y()}, at, image)
                   : side(Mesh::previous(h), apex, -apex, at, image);
    };
    Side out = by(is_right);
    if (!out.is_straight) {
      // Where the image lies on a side, or the line runs along one, its direction is rounding.
      const Side other = by(!is_right);
      const bool misses = other.way + rounding * (other.way + surface_.length(h)) < out.way;
      if (misses) out = other;
    }
    at = out.at;
    image = out.image;
    return out.halfedge;
  }

  struct Side {
    Index halfedge;
    Vec2<Real> at, image;  // in its frame
    Real way;              // from one to the other through it
    bool is_straight;      // the line crosses it between its ends: no way is shorter
  };

  [[nodiscard]] Side side(Index h, const Vec2<Real>& from, const Vec2<Real>& way,
                          const Vec2<Real>& at, const Vec2<Real>& image) const {
    const Real length = surface_.length(h);
    if (length == 0) return {h, at, image, unreachable<Real>, false};
    const Vec2<Real> along = stable_unit(way);
    const auto turned = [&](const Vec2<Real>& p) -> Vec2<Real> {
      const Vec2<Real> d = p - from;
      return {along.dot(d), along.x() * d.y() - along.y() * d.x()};
    };
    Side out{h, turned(at), turned(image), 0, false};
    const Vec2<Real> bend(crossing(out.at, out.image, length), 0);
    out.way = (out.at - bend).norm() + (bend - out.image).norm();
    out.is_straight = out.at.y() > 0 && out.image.y() < 0 && bend.x() > 0 && bend.x() < length;
    return out;
  }

  // The end of h by which a point x along it is reached, if it is not farther than `distance`.
  [[nodiscard]] Index nearer_end(Index h, Real x, Real distance) const {
    const Real by_origin = distances_[surface_.origin(h)] + x;
    const Real by_tip = distances_[surface_.tip(h)] + surface_.length(h) - x;
    const Index end = by_origin < by_tip ? surface_.origin(h) : surface_.tip(h);
    const Index other = by_origin < by_tip ? surface_.tip(h) : surface_.origin(h);
    if (distances_[end] < distance) return end;
    if (distances_[other] < distance) return other;
    // Vertices at one place are equally far; the way to one of them may lead by another.
    return distances_[end] <= distance ? end : arrived;
  }

  [[nodiscard]] bool is_in_face(Index origin, Index h) const {
    const Origin& o = origins_[origin];
    if (o.kind == Origin::Kind::crossing) return false;
    if (o.kind == Origin::Kind::front) {
      return fronts_[static_cast<std::size_t>(o.index)].face == Mesh::face_of(h);
    }
    const auto has = [&](Index v) {
      return surface_.origin(h) == v || surface_.tip(h) == v || surface_.apex(h) == v;
    };
    if (o.kind == Origin::Kind::vertex) return has(o.index);
    const Point& point = sources_[static_cast<std::size_t>(o.index)].point;
    const auto [a, b] = point.element;
    if (point.kind == Point::Kind::vertex) return has(a);
    if (point.kind == Point::Kind::edge) return has(a) && has(b);
    return Mesh::face_of(h) == a;
  }

  const Mesh& surface_;
  const PlanarFaces<Real>& faces_;
  const std::vector<Source<Real>>& sources_;
  const Array<Real>& distances_;
  const Array<Arrival>& arrivals_;
  const Array<Origin>& origins_;
  const std::vector<SegmentFront<Real>>& fronts_;
};

}  // namespace gelight::detail
