#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/backtrace/funnel.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Makes a path locally shortest. Between the vertices at which it bends it is pulled taut through
/// the faces that it crosses, laid flat; where it bends at a vertex and less than pi lies on one
/// side, it goes round there from then on. Both only ever shorten it, and go on until neither does.
template <std::floating_point Real>
class Straightener {
 public:
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;

  Straightener(const Mesh& surface, const PlanarFaces<Real>& faces)
      : surface_(surface), faces_(faces) {}

  /// The path straightened, by its ends; each of its pieces lies in one face, its points are named
  /// as `simplified` does.
  [[nodiscard]] std::vector<Point> operator()(const std::vector<Point>& path,
                                              const CancelHook& cancelled) {
    std::vector<Stop> stops = taut(stops_of(path));
    Real length = length_of(stops);
    while (go_round_vertices(stops)) {
      cancelled.check(0, "straightening a path");
      std::vector<Stop> next = taut(round_);
      const Real shorter = length_of(next);
      if (!(shorter < length)) break;
      stops = std::move(next);
      length = shorter;
    }
    std::vector<Point> out;
    out.reserve(stops.size());
    for (const Stop& stop : stops) out.push_back(stop.point);
    return out;
  }

 private:
  // A bend of less than this is longer than the straight line by rounding only.
  static constexpr Real least_bend = 1e-8;

  /// A point of the path: a crossing of an edge, from the face of half-edge `out` into that of
  /// `in`; or a vertex or an end of the path, at which it may bend.
  struct Stop {
    Point point;
    Index out = -1, in = -1;
    bool is_settled = false;  // no shorter way round it was found, and nothing has changed since
    bool is_loose = false;    // what lies between the last bend and this one has to be pulled taut

    [[nodiscard]] bool is_crossing() const { return out >= 0; }
  };

  [[nodiscard]] Real length_of(const std::vector<Stop>& stops) const {
    Real sum = 0;
    for (std::size_t i = 1; i < stops.size(); ++i) {
      sum += straight(surface_, stops[i - 1].point, stops[i].point);
    }
    return sum;
  }

  // --- from points to stops ----------------------------------------------------------------------

  [[nodiscard]] std::vector<Index> faces_with(const Point& p, const Point& q) const {
    std::vector<Index> out;
    for_each_place(surface_, p, [&](Index f, const auto&) {
      for_each_place(surface_, q, [&](Index g, const auto&) {
        if (f == g) out.push_back(f);
      });
    });
    return out;
  }

  // Leaves out what lies between points of one face, but for vertices.
  [[nodiscard]] std::vector<Stop> stops_of(const std::vector<Point>& path) const {
    std::vector<Stop> out{{path[0]}};
    std::vector<Index> behind;  // faces that hold all since the last stop
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Point& last = path[i - 1];
      std::vector<Index> ahead = faces_with(last, path[i]), both;
      for (const Index f : behind) {
        if (std::find(ahead.begin(), ahead.end(), f) != ahead.end()) both.push_back(f);
      }
      const bool is_vertex = last.kind == Point::Kind::vertex;
      if (i > 1 && (is_vertex || both.empty())) {
        Stop stop{last};
        if (!is_vertex) {
          stop.out = side_with(behind[0], last);
          stop.in = side_with(ahead[0], last);
        }
        stop.is_loose = is_vertex;
        if (is_vertex) {
          out.push_back(stop);
        } else {
          cross(stop, out);
        }
        both.clear();
      }
      behind = both.empty() ? std::move(ahead) : std::move(both);
    }
    out.push_back({path.back()});
    out.back().is_loose = true;
    return out;
  }

  // Adds the crossing of an edge; crossed back at once it is not crossed at all.
  static void cross(const Stop& stop, std::vector<Stop>& out) {
    if (!out.back().is_crossing() || out.back().in != stop.out) return out.push_back(stop);
    if (out.back().out == stop.in) return out.pop_back();
    out.back().in = stop.in;
  }

  // The half-edge of a face on which a point of an edge lies.
  [[nodiscard]] Index side_with(Index face, const Point& p) const {
    Index h = 3 * face;
    while (surface_.apex(h) == p.element[0] || surface_.apex(h) == p.element[1]) ++h;
    return h;
  }

  // --- taut between vertices ---------------------------------------------------------------------

  [[nodiscard]] std::vector<Stop> taut(const std::vector<Stop>& stops) {
    std::vector<Stop> out{stops[0]};
    for (std::size_t from = 0; from + 1 < stops.size();) {
      std::size_t to = from + 1;
      while (stops[to].is_crossing()) ++to;
      if (to > from + 1 && stops[to].is_loose) {
        pull(stops, from, to, out);
      } else {
        out.insert(out.end(), stops.begin() + static_cast<std::ptrdiff_t>(from) + 1,
                   stops.begin() + static_cast<std::ptrdiff_t>(to));
      }
      append(stops[to], out);
      from = to;
    }
    for (Stop& stop : out) stop.is_loose = false;
    return out;
  }

  // Adds a stop at which the path may bend; what crosses edges between two of one place is left
  // out.
  static void append(const Stop& stop, std::vector<Stop>& out) {
    auto last = out.end() - 1;
    while (last->is_crossing()) --last;
    if (last->point == stop.point) {
      out.erase(last + 1, out.end());
    } else {
      out.push_back(stop);
    }
  }

  // Lays the faces between two stops flat, upwards, and draws the shortest line through them.
  void pull(const std::vector<Stop>& stops, std::size_t from, std::size_t to,
            std::vector<Stop>& out) {
    const Index first = stops[from + 1].out;
    Vec2<Real> begin = place(stops[from].point, first);
    begin = surface_.origin(first) == surface_.origin(stops[from + 1].in)
                ? Vec2<Real>(begin.x(), -begin.y())
                : Vec2<Real>(surface_.length(first) - begin.x(), -begin.y());
    line_.begin(begin);
    lefts_.clear();
    // The edge that is crossed: the places of its ends, which stay what they are as long as the
    // edges turn about one, and the direction from the left one to the right.
    Vec2<Real> left(0, 0), right(surface_.length(first), 0), way(1, 0);
    Index left_vertex = surface_.origin(stops[from + 1].in);
    for (std::size_t i = from + 1;; ++i) {
      const Index in = stops[i].in;
      const Real length = surface_.length(in);
      line_.pass(left, right);
      lefts_.push_back(left_vertex);
      // The face beyond, in its half-edge's frame or the mirror image.
      const bool is_same = surface_.origin(in) == left_vertex;
      const auto laid = [&](const Vec2<Real>& at) -> Vec2<Real> {
        const Real x = is_same ? at.x() : length - at.x();
        return left + turned({x, at.y()}, way);
      };
      if (i + 1 == to) {
        (void)line_.length_to(laid(place(stops[to].point, in)));
        break;
      }
      // From the left end to the apex, and from there to the right end.
      const Vec2<Real> apex = faces_.apex(in), from_tip = faces_.apex_from_tip(surface_, in);
      const Vec2<Real> up = is_same ? apex : from_tip, back = is_same ? from_tip : apex;
      const Index next = stops[i + 1].out;
      if (surface_.origin(next) == left_vertex || surface_.tip(next) == left_vertex) {
        right = laid(apex);
        way = turned(stable_unit(up), way);
      } else {
        left = laid(apex);
        left_vertex = surface_.apex(in);
        way = turned(stable_unit(Vec2<Real>(back.x(), -back.y())), way);
      }
    }
    keep_crossings(stops, from, out);
  }

  static Vec2<Real> turned(const Vec2<Real>& at, const Vec2<Real>& way) {
    return {at.x() * way.x() - at.y() * way.y(), at.x() * way.y() + at.y() * way.x()};
  }

  void keep_crossings(const std::vector<Stop>& stops, std::size_t from, std::vector<Stop>& out) {
    const Array<Real> shares = line_.crossings();
    for (std::ptrdiff_t i = 0; i < std::ssize(shares); ++i) {
      Stop stop = stops[from + 1 + static_cast<std::size_t>(i)];
      const Index a = surface_.origin(stop.in), b = surface_.tip(stop.in);
      const Index left = lefts_[i], right = left == a ? b : a;
      const Real share = shares[i];
      if (share <= share_rounding<Real> || share >= 1 - share_rounding<Real>) {
        append({vertex_point<Real>(share < Real(0.5) ? left : right)}, out);
      } else {
        stop.point = edge_point<Real>(left, right, share);
        out.push_back(stop);
      }
    }
  }

  // The place of a point of h's face in h's frame.
  [[nodiscard]] Vec2<Real> place(const Point& p, Index h) const {
    Vec2<Real> out(0, 0);
    for_each_place(surface_, p, [&](Index f, const std::array<Real, 3>& shares) {
      if (f == Mesh::face_of(h)) out = faces_.place(surface_, h, shares);
    });
    return out;
  }

  // --- round vertices ----------------------------------------------------------------------------

  // Goes round vertices at which the path bends, where that is shorter, into `round_`. Returns
  // whether there are any.
  [[nodiscard]] bool go_round_vertices(std::vector<Stop>& stops) {
    bool any = false, is_loose = false;
    Index face = -1;  // in which it went round the vertex before, where that was the last stop
    round_.assign(1, stops[0]);
    std::size_t last_bend = 0;
    for (std::size_t i = 1; i < stops.size(); ++i) {
      Stop& stop = stops[i];
      if (!stop.is_crossing()) {
        if (i + 1 < stops.size() && !stop.is_settled && find_way_round(stops, i, face)) {
          any = is_loose = true;
          for (const Spoke& spoke : way_) cross(crossing(spoke), round_);
          face = last_face_;
          continue;
        }
        stop.is_settled = !is_loose;
        stop.is_loose = is_loose;
        if (is_loose) round_[last_bend].is_settled = false;
        last_bend = round_.size();
        is_loose = false;
      }
      if (stop.is_crossing()) {
        cross(stop, round_);
      } else {
        round_.push_back(stop);
      }
      face = -1;
    }
    return any;
  }

  /// An edge at a vertex, crossed at an angle from where the way round it begins.
  struct Spoke {
    Real angle;
    Index out, in;
    std::ptrdiff_t before;  // the spoke before it, or -1
  };
  [[nodiscard]] Stop crossing(const Spoke& spoke) const {
    return {edge_point<Real>(surface_.origin(spoke.in), surface_.tip(spoke.in), Real(0.5)),
            spoke.out, spoke.in};
  }

  /// A point of a face at the vertex.
  struct Place {
    Index corner;  // the face's half-edge that starts at the vertex
    Real angle;    // from there
    Index side;    // the half-edge at the vertex on which it lies, or -1
  };

  // Finds the spokes that the least turn from the stop before to the one after crosses, if it is
  // less than pi. With a face, from there.
  [[nodiscard]] bool find_way_round(const std::vector<Stop>& stops, std::size_t i, Index face) {
    const Index vertex = stops[i].point.element[0];
    const Stop &before = stops[i - 1], &after = stops[i + 1];
    if (before.is_crossing()) face = Mesh::face_of(before.in);
    const auto from = places_at(vertex, before.point, face);
    const auto to =
        places_at(vertex, after.point, after.is_crossing() ? Mesh::face_of(after.out) : -1);
    const bool is_bound = face >= 0;  // to one face, and may cross the edge on which it begins
    Real best = std::numbers::pi_v<Real> - least_bend;
    std::ptrdiff_t last = none;
    spokes_.clear();
    heap_.clear();
    passed_.clear();
    const auto meet = [&](Index corner, Real angle, std::ptrdiff_t spoke) {
      if (!(angle < best)) return;
      best = angle;
      last = spoke;
      last_face_ = Mesh::face_of(corner);
    };
    for (const Place& p : from) {
      for (const Place& q : to) {
        if (p.corner == q.corner) meet(p.corner, std::fabs(p.angle - q.angle), -1);
      }
      const Index across = Mesh::previous(p.corner);
      if (is_bound || p.side != p.corner) push(p.angle, p.corner, -1);
      if (is_bound || p.side != across) push(faces_.angle(p.corner) - p.angle, across, -1);
    }
    while (!heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end(), is_farther);
      const Next next = heap_.back();
      heap_.pop_back();
      if (!(next.angle < best)) break;
      if (std::find(passed_.begin(), passed_.end(), next.side) != passed_.end()) continue;
      passed_.push_back(next.side);
      for (Index h = surface_.twin(next.side); h != next.side; h = surface_.twin(h)) {
        passed_.push_back(h);
        const bool is_out = surface_.origin(h) == vertex;
        const Index corner = is_out ? h : Mesh::next(h);
        const Real opening = faces_.angle(corner);
        spokes_.push_back({next.angle, next.side, h, next.spoke});
        const std::ptrdiff_t spoke = std::ssize(spokes_) - 1;
        for (const Place& q : to) {
          if (q.corner != corner) continue;
          meet(corner, next.angle + (is_out ? q.angle : opening - q.angle), spoke);
        }
        push(next.angle + opening, is_out ? Mesh::previous(corner) : corner, spoke);
      }
    }
    if (last == none) return false;
    way_.clear();
    for (std::ptrdiff_t s = last; s >= 0; s = spokes_[static_cast<std::size_t>(s)].before) {
      way_.push_back(spokes_[static_cast<std::size_t>(s)]);
    }
    std::reverse(way_.begin(), way_.end());
    return true;
  }

  struct Next {
    Real angle;
    Index side;
    std::ptrdiff_t spoke;
  };
  static bool is_farther(const Next& a, const Next& b) { return a.angle > b.angle; }
  void push(Real angle, Index side, std::ptrdiff_t spoke) {
    heap_.push_back({angle, side, spoke});
    std::push_heap(heap_.begin(), heap_.end(), is_farther);
  }

  // A point as the faces at a vertex have it, or as one of them does.
  [[nodiscard]] std::vector<Place> places_at(Index vertex, const Point& p, Index face) const {
    std::vector<Place> out;
    for_each_place(surface_, p, [&](Index f, const std::array<Real, 3>& shares) {
      if (face >= 0 && f != face) return;
      for (Index h = 3 * f; h < 3 * f + 3; ++h) {
        if (surface_.origin(h) != vertex) continue;
        const Real at_tip = shares[static_cast<std::size_t>((h + 1) % 3)];
        const Real at_apex = shares[static_cast<std::size_t>((h + 2) % 3)];
        const Vec2<Real> at = faces_.place(surface_, h, shares);
        const Real angle = std::atan2(at.y(), at.x());
        out.push_back({h, angle, at_apex == 0 ? h : at_tip == 0 ? Mesh::previous(h) : -1});
      }
    });
    return out;
  }

  static constexpr std::ptrdiff_t none = -2;

  const Mesh& surface_;
  const PlanarFaces<Real>& faces_;
  Funnel<Real> line_;
  Array<Index> lefts_;  // of each portal of the line: the vertex at its left
  std::vector<Stop> round_;
  std::vector<Spoke> spokes_, way_;
  std::vector<Next> heap_;
  std::vector<Index> passed_;
  Index last_face_ = -1;
};

}  // namespace gelight::detail
