#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Walks straight on over the faces of a surface.
template <std::floating_point T>
class StraightWalk {
 public:
  StraightWalk(const Surface<T>& surface, const SurfacePoint<T>& from, double length,
               const CancelHook& cancelled)
      : surface_(surface), cancelled_(cancelled), left_(length), length_(length), path_{from} {}

  /// The path from the point at which the walk was begun.
  Path<T> run(const Vec3<T>& direction) {
    const SurfacePoint<T> from = path_[0];
    const Vec3<double> way = stable_unit(cast<double>(direction));
    if (from.kind == Kind::vertex) {
      leave_vertex(from.element[0], way);
    } else if (from.kind == Kind::edge) {
      leave_edge(from, way);
    } else {
      leave_face(from, way);
    }
    while (halfedge_ >= 0 || corner_ >= 0) {
      while (halfedge_ >= 0) cross_face();
      if (corner_ >= 0) pass_corner();
    }
    return std::move(path_);
  }

 private:
  using Mesh = Surface<T>;
  using Kind = typename SurfacePoint<T>::Kind;
  static constexpr double pi = std::numbers::pi;
  // A line that passes a vertex or runs beside an edge by no more than this, as a share of the edge
  // or as an angle, meets it.
  static constexpr double on_it = share_rounding<double>;
  // A direction no farther than this from a face's plane, as a sine, was given as one of the face.
  static constexpr double in_plane = std::is_same_v<T, float> ? 1e-5 : 1e-10;

  // --- faces laid flat ---------------------------------------------------------------------------

  [[nodiscard]] Vec3<double> place(Index vertex) const {
    return cast<double>(surface_.position(vertex));
  }
  [[nodiscard]] double length(Index h) const { return static_cast<double>(surface_.length(h)); }

  // The frame of a half-edge's face: x along it, y into the face.
  struct Frame {
    Vec3<double> x, y;
    double length;
    Vec2<double> apex;
  };
  [[nodiscard]] Frame frame(Index h) const {
    const Vec3<double> origin = place(surface_.origin(h));
    const Vec3<double> along = place(surface_.tip(h)) - origin;
    const Vec3<double> to_apex = place(surface_.apex(h)) - origin;
    Frame out;
    out.length = stable_norm(along);
    out.x = out.length > 0 ? Vec3<double>(along / out.length) : stable_unit(to_apex);
    const double x = dot(out.x, to_apex);
    const Vec3<double> up = to_apex - x * out.x;
    const double y = stable_norm(up);
    const bool is_flat = !(y > on_it * std::max(out.length, stable_norm(to_apex)));
    out.y = is_flat ? Vec3<double>(0, 0, 0) : Vec3<double>(up / y);
    out.apex = {x, is_flat ? 0 : y};
    return out;
  }
  // What a direction has at a right angle to a frame's face; where that has no area, to its line.
  [[nodiscard]] static double off_plane(const Frame& face, const Vec3<double>& way) {
    return norm(way - dot(way, face.x) * face.x - dot(way, face.y) * face.y);
  }
  // By how much a direction between two places of h's face may be off its plane: positions are
  // rounded by what they are from the origin.
  [[nodiscard]] double in_plane_of(Index h) const {
    const double longest = std::max({length(h), length(Mesh::next(h)), length(Mesh::previous(h))});
    double farthest = 0;
    for (const Index g : {h, Mesh::next(h), Mesh::previous(h)}) {
      farthest = std::max(farthest, detail::largest_part(place(surface_.origin(g))));
    }
    return in_plane + double{share_rounding<T>} * farthest / std::max(longest, shortest_length);
  }
  // Angle of h's face at h's origin.
  [[nodiscard]] double corner(Index h) const {
    const Vec3<double> origin = place(surface_.origin(h));
    const Vec3<double> a = place(surface_.tip(h)) - origin;
    const Vec3<double> b = place(surface_.apex(h)) - origin;
    return std::atan2(stable_norm(gelight::cross(a, b)), dot(a, b));
  }

  // Corners round a place, in order, by their half-edges; over edges of no length those of the
  // vertices at their other ends belong to it.
  struct Ring {
    std::vector<Index> halfedges;
    std::vector<double> angles;
    double total = 0;
    bool is_closed = false;
  };

  // --- how it begins -----------------------------------------------------------------------------

  void leave_face(const SurfacePoint<T>& from, const Vec3<double>& way) {
    const Index f = from.element[0];
    Index out = -1;
    double least = unreachable<double>, x_out = 0;
    Vec2<double> direction;
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      const Frame face = frame(h);
      require(face.apex.y() > 0, "face ", f, " has no area and no directions");
      const auto k = static_cast<std::size_t>(h % 3);
      const double at_tip = static_cast<double>(from.weights[(k + 1) % 3]);
      const double at_apex = static_cast<double>(from.weights[(k + 2) % 3]);
      const Vec2<double> at(at_tip * face.length + at_apex * face.apex.x(),
                            at_apex * face.apex.y());
      const Vec2<double> flat(dot(way, face.x), dot(way, face.y));
      require(norm(flat) > in_plane, "the direction is at a right angle to face ", f);
      const Vec2<double> d = stable_unit(flat);
      if (!(d.y() < 0)) continue;
      const double t = at.y() / -d.y();
      if (!(t < least)) continue;
      least = t;
      out = h;
      x_out = at.x() + t * d.x();
      direction = d;
    }
    // Of a face so thin, the three edges' frames disagree on what is out.
    require(out >= 0, "face ", f, " has too little area for a direction");
    if (least >= left_) {
      const double rest = least - left_;
      return end_in(out, {x_out - rest * direction.x(), -rest * direction.y()});
    }
    left_ -= least;
    leave_by(out, x_out, {direction.x(), direction.y()});
  }

  void leave_edge(const SurfacePoint<T>& from, const Vec3<double>& way) {
    const Index first = surface_.find_halfedge(from.element[0], from.element[1]);
    if (!(length(first) > 0)) return leave_vertex(from.element[0], way);
    // The face in which the direction lies; else that on which side of the edge it points, in the
    // plane that halves the angle between two faces, which is unfolded.
    Index best = first;
    double most = -1;
    Vec3<double> across(0, 0, 0);
    Index h = first;
    do {
      const Frame face = frame(h);
      const double side = dot(way, face.y);
      if (off_plane(face, way) <= in_plane_of(h) && side >= 0) most = unreachable<double>, best = h;
      if (side > most) most = side, best = h;
      across = h == first ? face.y : Vec3<double>(across - face.y);
      h = surface_.twin(h);
    } while (h != first);
    const Frame face = frame(best);
    if (surface_.is_border(first) && dot(way, face.y) < -in_plane_of(best)) return;  // out over it
    require(most == unreachable<double> || surface_.is_manifold(first),
            "the edge between vertices ", from.element[0], " and ", from.element[1],
            " has more than two faces, and the direction is in the plane of none");
    Vec2<double> d(dot(way, face.x), dot(way, face.y));
    if (most < unreachable<double> && !surface_.is_border(first)) {
      d.y() = std::abs(dot(way, stable_unit(across)));
    }
    require(norm(d) > in_plane, "the direction is at a right angle to the edge between vertices ",
            from.element[0], " and ", from.element[1]);
    d.y() = std::max(0.0, d.y());
    d = stable_unit(d);
    const bool same = surface_.origin(best) == from.element[0];
    const double x = static_cast<double>(from.weights[same ? 1 : 0]) * face.length;
    if (d.y() <= on_it) return go_along(best, x, d.x() > 0);
    halfedge_ = best;
    x_ = x;
    direction_ = d;
  }

  void leave_vertex(Index vertex, const Vec3<double>& way) {
    require(!surface_.corners(vertex).empty(), "vertex ", vertex,
            " is in no face, no way leads from it");
    const std::vector<Joined> place = joined(vertex);
    std::vector<Index> faces;
    for (const auto& [other, before] : place) {
      for (const Index h : surface_.corners(other)) {
        faces.push_back(Mesh::face_of(h));
        if (!(length(h) > 0)) continue;
        const Frame face = frame(h);
        const double x = dot(way, face.x), y = dot(way, face.y), tolerance = in_plane_of(h);
        const double angle = std::atan2(y, x), opening = std::atan2(face.apex.y(), face.apex.x());
        if (off_plane(face, way) <= tolerance && angle >= -tolerance &&
            angle <= opening + tolerance) {
          return leave_corner(h, std::clamp(angle, 0.0, opening), opening);
        }
      }
    }
    const Ring ring = ring_of(first_of(surface_.corners(vertex)[0]));
    require(has_all(ring, faces), "the faces at vertex ", vertex,
            " are no single fan of one orientation, and the direction is in the plane of none");
    const auto [h, angle] = in_tangent_plane(vertex, ring, way);
    if (h >= 0) leave_corner(h, angle, corner(h));
  }

  // Whether a ring has each of these faces that is more than a point.
  [[nodiscard]] bool has_all(const Ring& ring, const std::vector<Index>& faces) const {
    return std::all_of(faces.begin(), faces.end(), [&](Index f) {
      const bool is_point = !(std::max({length(3 * f), length(3 * f + 1), length(3 * f + 2)}) > 0);
      return is_point || std::any_of(ring.halfedges.begin(), ring.halfedges.end(),
                                     [&](Index h) { return Mesh::face_of(h) == f; });
    });
  }

  // The corner into which a direction of a vertex' tangent plane leads, with angles scaled as in
  // TangentFrames.
  [[nodiscard]] std::pair<Index, double> in_tangent_plane(Index vertex, const Ring& ring,
                                                          const Vec3<double>& way) const {
    Vec3<double> normal(0, 0, 0);
    for (std::size_t i = 0; i < ring.halfedges.size(); ++i) {
      const Frame face = frame(ring.halfedges[i]);
      normal += ring.angles[i] * gelight::cross(face.x, face.y);
    }
    require(norm(normal) > in_plane * ring.total, "the faces at vertex ", vertex,
            " have no common tangent plane, and the direction is in the plane of none");
    normal = stable_unit(normal);
    const Vec3<double> part = way - dot(way, normal) * normal;
    require(norm(part) > in_plane, "the direction is at a right angle to the surface at vertex ",
            vertex);
    const Vec3<double> x = stable_unit(part);
    const Vec3<double> y = gelight::cross(normal, x);
    const auto flat = [&](Index other) {
      const Vec3<double> to = place(other) - place(vertex);
      return std::complex<double>(dot(to, x), dot(to, y));
    };
    const double scale = ring.is_closed ? 2 * pi / ring.total : 1;
    std::complex<double> turn = 0;
    double sum = 0;
    for (std::size_t i = 0; i < ring.halfedges.size(); ++i) {
      turn += flat(surface_.tip(ring.halfedges[i])) * std::polar(1.0, -scale * sum);
      sum += ring.angles[i];
    }
    if (!ring.is_closed) {
      turn += flat(surface_.apex(ring.halfedges.back())) * std::polar(1.0, -sum);
    }
    // The direction is along x, and the first half-edge at arg(turn).
    double angle = turn == 0.0 ? 0 : -std::arg(turn);
    if (angle < 0) angle += 2 * pi;
    return at_angle(ring, angle / scale);
  }

  // --- round a vertex ----------------------------------------------------------------------------

  // A vertex at a place, and which of those before it an edge of no length joins it to.
  struct Joined {
    Index vertex;
    std::size_t before;
  };
  // The vertices at a vertex' place, itself first.
  [[nodiscard]] std::vector<Joined> joined(Index vertex) const {
    std::vector<Joined> out{{vertex, 0}};
    const auto reach = [&](Index v, std::size_t before) {
      const auto is_v = [&](const Joined& other) { return other.vertex == v; };
      if (std::none_of(out.begin(), out.end(), is_v)) out.push_back({v, before});
    };
    for (std::size_t i = 0; i < out.size(); ++i) {
      for (const Index h : surface_.corners(out[i].vertex)) {
        if (!(length(h) > 0)) reach(surface_.tip(h), i);
        if (!(length(Mesh::previous(h)) > 0)) reach(surface_.apex(h), i);
      }
    }
    return out;
  }
  // To a vertex; from one at the same place along the edges of no length between them.
  void go_to(Index vertex) {
    if (path_.back().kind == Kind::edge) {
      // From a point of an edge of no length, at which all those vertices are.
      const auto [a, b] = path_.back().element;
      const bool is_end = vertex == a || vertex == b;
      if (!is_end && !(length(surface_.find_halfedge(a, b)) > 0)) append(vertex_point<T>(a));
    }
    if (path_.back().kind == Kind::vertex && path_.back().element[0] != vertex) {
      const std::vector<Joined> place = joined(vertex);
      const auto at = std::find_if(place.begin(), place.end(), [&](const Joined& other) {
        return other.vertex == path_.back().element[0];
      });
      if (at != place.end()) {
        for (std::size_t i = at->before; i > 0; i = place[i].before) {
          append(vertex_point<T>(place[i].vertex));
        }
      }
    }
    append(vertex_point<T>(vertex));
  }

  // The half-edge from the place after that of a corner, or -1 at a border or where faces are
  // turned over.
  [[nodiscard]] Index after(Index h) const {
    const Index before = Mesh::previous(h);
    // To the left of h lies an edge of no length: the next leads from its other end.
    return across(surface_.length(before) > 0 ? before : Mesh::next(h));
  }
  [[nodiscard]] Index before(Index h) const {
    const Index t = across(h);
    if (t < 0) return -1;
    return surface_.length(Mesh::next(t)) > 0 ? Mesh::next(t) : Mesh::previous(t);
  }
  [[nodiscard]] Index across(Index h) const {
    const Index t = surface_.twin(h);
    const bool goes_on =
        t != h && surface_.twin(t) == h && surface_.origin(t) != surface_.origin(h);
    return goes_on ? t : -1;
  }
  [[nodiscard]] Index first_of(Index h) const {
    Index first = surface_.length(h) > 0 ? h : Mesh::next(h);
    const Index start = first;
    for (Index left = surface_.halfedge_count(); left > 0; --left) {
      const Index other = before(first);
      if (other < 0 || other == start) break;
      first = other;
    }
    return first;
  }
  [[nodiscard]] Ring ring_of(Index first) const {
    Ring ring;
    Index h = first;
    for (Index left = surface_.halfedge_count(); h >= 0 && left > 0; --left) {
      const bool has_angle = surface_.length(h) > 0 && surface_.length(Mesh::previous(h)) > 0;
      ring.halfedges.push_back(h);
      ring.angles.push_back(has_angle ? corner(h) : 0);
      ring.total += ring.angles.back();
      h = after(h);
      if (h != first) continue;
      ring.is_closed = true;
      break;
    }
    return ring;
  }
  // The corner of a ring at an angle from its first half-edge, and the angle there.
  [[nodiscard]] std::pair<Index, double> at_angle(const Ring& ring, double angle) const {
    if (!ring.is_closed && (angle < 0 || angle > ring.total)) {
      // Beside the surface: along the nearer border, if that is near.
      const double beyond = angle < 0 ? -angle : std::min(angle - ring.total, 2 * pi - angle);
      if (beyond > in_plane) return {-1, 0};
      angle = angle - ring.total > pi - ring.total / 2 ? 0 : std::clamp(angle, 0.0, ring.total);
    }
    for (std::size_t i = 0; i < ring.halfedges.size(); ++i) {
      if (angle <= ring.angles[i]) return {ring.halfedges[i], std::max(0.0, angle)};
      angle -= ring.angles[i];
    }
    return {ring.halfedges.back(), ring.angles.back()};
  }

  // Goes on from a vertex that was reached in h's face, h's origin, with the way back at an angle
  // from h.
  void pass_vertex(Index h, double back) {
    go_to(surface_.origin(h));
    if (!(left_ > 0)) return finish();
    const Ring ring = ring_of(first_of(h));
    double from = back;
    for (std::size_t i = 0; i < ring.halfedges.size() && ring.halfedges[i] != h; ++i) {
      from += ring.angles[i];
    }
    double onward = 0;
    if (ring.is_closed) {
      onward = std::fmod(std::fmod(from, ring.total) + 1.5 * ring.total, ring.total);
    } else if (from < -in_plane || from > ring.total + in_plane) {
      // Begun next to the vertex, and the way back leads off the surface: straight on as laid flat.
      onward = from + (from < 0 ? pi : -pi);
      if (onward < 0 || onward > ring.total) return finish();
    } else {
      from = std::clamp(from, 0.0, ring.total);
      // At a border there is a straight way on where one side is at least half a turn.
      const bool left = from >= pi - in_plane, right = ring.total - from >= pi - in_plane;
      if (!left && !right) return finish();
      onward = left && right ? from + (from > ring.total / 2 ? -1 : 1) * ring.total / 2
               : left        ? std::max(0.0, from - pi)
                             : std::min(ring.total, from + pi);
    }
    const auto [corner_out, angle] = at_angle(ring, onward);
    if (corner_out < 0) return finish();
    leave_corner(corner_out, angle, corner(corner_out));
  }

  // From h's origin into its face, at an angle of the corner's.
  void leave_corner(Index h, double angle, double opening) {
    go_to(surface_.origin(h));
    if (angle <= on_it) return go_along(h, 0, true);
    if (angle >= opening - on_it) {
      const Index in = Mesh::previous(h);
      return go_along(in, length(in), false);
    }
    halfedge_ = h;
    x_ = 0;
    direction_ = {std::cos(angle), std::sin(angle)};
  }

  // Along a half-edge, from a place on it to one of its ends. From there it goes on in its turn: a
  // long way along short edges would be as many calls deep.
  void go_along(Index h, double x, bool to_tip) {
    halfedge_ = -1;
    const double rest = to_tip ? length(h) - x : x;
    if (left_ < rest) return end_in(h, {to_tip ? x + left_ : x - left_, 0});
    left_ -= rest;
    corner_ = to_tip ? Mesh::next(h) : h;
    back_ = to_tip ? corner(corner_) : 0;
  }
  void pass_corner() {
    const Index h = std::exchange(corner_, -1);
    if ((++crossings_ & 4095) == 0 && !gets_on()) return finish();
    pass_vertex(h, back_);
  }

  // --- across a face -----------------------------------------------------------------------------

  void cross_face() {
    if ((++crossings_ & 4095) == 0 && !gets_on()) return finish();
    const Index h = halfedge_;
    const Vec3<double> origin = place(surface_.origin(h));
    const Vec3<double> to_apex = place(surface_.apex(h)) - origin;
    const double base = length(h);
    const Vec3<double> x = (place(surface_.tip(h)) - origin) * (1 / base);
    const double apex_x = dot(x, to_apex);
    const double apex_y = norm(to_apex - apex_x * x);
    const double dx = direction_.x(), dy = direction_.y();
    // On which side of the line the apex lies, as a length.
    const double beside = (apex_x - x_) * dy - apex_y * dx;
    // No way leads out over a side of no length: then it is the other one, which lies on h.
    const bool has_left = length(Mesh::previous(h)) > 0, has_right = length(Mesh::next(h)) > 0;
    const bool is_right = has_left && has_right ? beside < 0 || (beside == 0 && dx > 0) : has_right;
    const Index out = is_right ? Mesh::next(h) : Mesh::previous(h);
    const double side = length(out);
    // Of the side: from the end on h, how far along it goes, x and y.
    const double start = is_right ? base : 0;
    const double sx = apex_x - start, sy = apex_y;
    // The ends of the side lie on either side of the line. Of one that runs along the side where
    // it is crossed is rounding: so the way is told from the place that is taken for it.
    const double start_beside = (start - x_) * dy, apart = start_beside - beside;
    const double crossed = apart == 0 ? 1 : start_beside / apart;
    const bool meets_apex = std::abs(beside) <= on_it * side || crossed >= 1 - on_it;
    const double share = meets_apex ? 1 : crossed;
    const double way = (start + share * sx - x_) * dx + share * sy * dy;
    if (way >= left_) return end_in(h, {x_ + left_ * dx, left_ * dy});
    left_ -= std::max(0.0, way);
    if (meets_apex) {
      if (!has_left) {  // the apex is where h begins
        halfedge_ = -1;
        return pass_vertex(h, std::atan2(-dy, -dx));
      }
      const double along_x = -dx, along_y = -dy;  // the way back, from the apex
      const Vec2<double> to_origin(-apex_x, -apex_y);
      const double back = std::atan2(to_origin.x() * along_y - to_origin.y() * along_x,
                                     to_origin.x() * along_x + to_origin.y() * along_y);
      halfedge_ = -1;
      return pass_vertex(Mesh::previous(h), back);
    }
    // The direction in the frame of `out`: to the right side runs up, the left one down.
    const double ux = (is_right ? sx : -sx) / side, uy = (is_right ? sy : -sy) / side;
    leave_by(out, is_right ? share * side : (1 - share) * side,
             {ux * dx + uy * dy, ux * dy - uy * dx});
  }

  // Over half-edge `out` at x along it, with a direction in its frame that points out of the face.
  void leave_by(Index out, double x, const Vec2<double>& d) {
    const double side = length(out), share = side > 0 ? std::clamp(x / side, 0.0, 1.0) : 0;
    if (share <= on_it || share >= 1 - on_it) {
      halfedge_ = -1;
      const Index at = share <= on_it ? out : Mesh::next(out);
      const double back =
          share <= on_it ? std::atan2(-d.y(), -d.x()) : corner(at) - std::atan2(-d.y(), d.x());
      return pass_vertex(at, back);
    }
    // Another edge than that of the point before, so that they need not be compared.
    path_.push_back(edge_point<T>(surface_.origin(out), surface_.tip(out), static_cast<T>(share)));
    const Index t = surface_.twin(out);
    if (t == out || surface_.twin(t) != out) return finish();  // a border, or three faces and more
    const bool is_turned = surface_.origin(t) == surface_.origin(out);
    halfedge_ = t;
    x_ = is_turned ? share * side : (1 - share) * side;
    // Kept unit to first order.
    const double unit = 1.5 - 0.5 * squared_norm(d);
    direction_ = {(is_turned ? d.x() : -d.x()) * unit, -d.y() * unit};
  }

  // --- how it ends -------------------------------------------------------------------------------

  void end_in(Index h, const Vec2<double>& at) {
    const Frame face = frame(h);
    const double at_apex = face.apex.y() > 0 ? std::clamp(at.y() / face.apex.y(), 0.0, 1.0) : 0;
    const double at_tip =
        std::clamp((at.x() - at_apex * face.apex.x()) / face.length, 0.0, 1 - at_apex);
    std::array<T, 3> weights;
    const auto k = static_cast<std::size_t>(h % 3);
    weights[(k + 1) % 3] = static_cast<T>(at_tip);
    weights[(k + 2) % 3] = static_cast<T>(at_apex);
    weights[k] = std::max(T(0), 1 - weights[(k + 1) % 3] - weights[(k + 2) % 3]);
    append(simplified(surface_, face_point<T>(Mesh::face_of(h), weights)));
    finish();
  }
  void append(const SurfacePoint<T>& point) {
    if (!(path_.back() == point)) path_.push_back(point);
  }
  void finish() {
    halfedge_ = -1;
    left_ = 0;
  }

  // Asks the hook, and tells whether it has come any farther since it was last looked at: round a
  // needle's tip of no girth it would go for ever.
  [[nodiscard]] bool gets_on() {
    cancelled_.check(1 - left_ / length_, "tracing a geodesic");
    if ((crossings_ >> 12) % (1 + surface_.face_count() / 1024) != 0) return true;
    return std::exchange(left_before_, left_) != left_;
  }

  const Surface<T>& surface_;
  const CancelHook& cancelled_;
  double left_, length_;
  double left_before_ = -1;
  std::int64_t crossings_ = 0;
  Path<T> path_;
  // Where it has come along an edge to its end: a half-edge from there, and the way back from it.
  Index corner_ = -1;
  double back_ = 0;
  // Where it enters a face: by which half-edge, how far along it, and which way in its frame.
  Index halfedge_ = -1;
  double x_ = 0;
  Vec2<double> direction_{0, 0};
};

}  // namespace gelight::detail
