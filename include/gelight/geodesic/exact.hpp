#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/line_backtrace.hpp"
#include "gelight/geodesic/exact/past_vertex.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/solved.hpp"
#include "gelight/geodesic/exact/window_backtrace.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
class PathSolver;
template <std::floating_point T>
class SmoothDistanceSolver;
template <std::floating_point T>
class ExactField;

namespace detail {
template <std::floating_point T>
[[nodiscard]] Vec3<T> kept_direction(const ExactField<T>& field, const SurfacePoint<T>& point);
template <std::floating_point T>
class ArcTracer;
template <std::floating_point T>
class BorderTracer;
}  // namespace detail

template <std::floating_point T>
struct ExactOptions {
  /// Distances beyond this one are not computed; they are reported as +infinity. In the unit of the
  /// positions, counted as the result is: with the sources' start distances.
  T max_distance = unreachable<T>;
  /// Where not empty, the search ends when the distances of all targets are certain. Vertices that
  /// it has not reached for certain by then are reported as +infinity; those beyond the farthest
  /// target that it has, with their distances. Windows are kept in the targets' own faces.
  std::vector<SurfacePoint<T>> targets{};
  /// Asked now and then while solving, and by queries of the field that search back to the sources;
  /// when it answers true, they throw Cancelled. The share done is that of the vertices reached; a
  /// query tells 0. The field keeps the hook, so what it refers to has to live as long.
  CancelHook cancelled{};
  /// Keeps all windows, about 50 bytes each and some dozens per edge, so that a query at a point
  /// that is no vertex looks at its own face only. Without, such a query searches its way back to
  /// the source, in O(vertices) and more; the answer is the same.
  bool keep_windows = false;
  /// What windows may take at once, in bytes, in a solve or a query that searches back; beyond it
  /// MemoryLimit is thrown. It is looked at after each list of windows, so that up to some
  /// megabytes more may be taken. About 100 bytes a vertex come on top.
  std::size_t max_memory = std::numeric_limits<std::size_t>::max();
  /// A dial between Dijkstra and exact (after Du, He, Fang, Meng, Xin 2021, hdl:10356/152296): at
  /// every multiple of so many mean edge lengths from the sources paths go through a vertex, where
  /// windows begin anew. The distances are lengths of real paths still, so never less than the
  /// exact ones. With radii of 1, 2, 4, 8, 16 and 32 they are 1.4, 0.66, 0.15, 0.041, 0.013 and
  /// 0.0041 % too long on average, 3.6, 2.6, 1.3, 0.53, 0.33 and 0.13 % at most on the GelTip
  /// membrane from four sources; on 24 meshes like a scanner's 9.6, 8.2, 4.2, 2, 1.1 and 0.43 % at
  /// most (benchmarks/claims.cpp); work is linear in the vertices, about half of exact at 40,000 of
  /// a sphere and an eighth at 655,362. Windows are kept.
  T reset_radius = unreachable<T>;
};

/// One straight line by which a point is reached.
template <std::floating_point T>
struct ExactArrival {
  T distance;            ///< Length of the path, with the source's start distance.
  Vec3<T> direction;     ///< Unit tangent in the direction of travel; zero at a source.
  SurfacePoint<T> from;  ///< Where the line begins: the source, or the last vertex where the path
                         ///< can bend, which is a saddle, a re-entrant corner of the border or a
                         ///< vertex that is not a plain one. Others may lie on the line.
};

/// How a path leaves its source.
template <std::floating_point T>
struct ExactDeparture {
  Vec3<T> direction;  ///< Unit tangent in the direction of travel.
  Index halfedge;     ///< A half-edge of the face into which the path goes: one that starts at a
                      ///< source vertex, lies on a source's edge, or the first of a source's face.
  T angle;            ///< From that half-edge towards the inside of the face, in radians.
};

/// Exact geodesic distances from the sources of one solve, with paths and directions of arrival, at
/// the vertices and anywhere between them. Made by ExactSolver::solve. Queries are const and safe
/// from several threads. A point that is not of the mesh is refused with InvalidInput.
///
/// A vertex answers from what it remembers, in constant time; paths take as many steps as faces.
/// Other points look at the windows of their face where those were kept (ExactOptions), and else
/// search back to the source through the faces where the path can lie.
template <std::floating_point T>
class ExactField {
 public:
  /// Distance of each vertex, +infinity where no path leads.
  [[nodiscard]] std::vector<T> distances() const;

  /// Distance of a point, +infinity where no path leads.
  ///@{
  [[nodiscard]] T distance(Index vertex) const {
    surface_.require_vertex(vertex);
    return distance_of_vertex(vertex);
  }
  [[nodiscard]] T distance(const SurfacePoint<T>& point) const;
  ///@}

  /// The shortest path from the source to a point; its length and the source's start distance sum
  /// to the point's distance. Empty where no path leads, the point alone at a source. Of several
  /// shortest paths one is returned.
  ///@{
  [[nodiscard]] Path<T> path(Index vertex) const { return path(vertex_point<T>(vertex)); }
  [[nodiscard]] Path<T> path(const SurfacePoint<T>& point) const;
  ///@}

  /// The unit tangent in which the shortest path travels on arrival. Zero at a source and where no
  /// path leads. Of several shortest paths one is taken; `arrivals` tells all.
  ///@{
  [[nodiscard]] Vec3<T> direction(Index vertex) const { return direction(vertex_point<T>(vertex)); }
  [[nodiscard]] Vec3<T> direction(const SurfacePoint<T>& point) const;
  ///@}

  /// All straight lines by which a point is reached with at most (1 + relative_tolerance) times its
  /// distance, nearest first: more than one on the cut locus, none where no path leads. Lines less
  /// than 1e-6 apart in direction count as one. A tolerance that is large against the size of the
  /// faces may miss lines longer than the shortest, since windows that serve no point are dropped.
  ///@{
  [[nodiscard]] std::vector<ExactArrival<T>> arrivals(
      Index vertex, T relative_tolerance = default_tolerance) const {
    return arrivals(vertex_point<T>(vertex), relative_tolerance);
  }
  [[nodiscard]] std::vector<ExactArrival<T>> arrivals(
      const SurfacePoint<T>& point, T relative_tolerance = default_tolerance) const;
  ///@}

  /// How the shortest path to a point leaves its source, for log maps: the length is the distance,
  /// the angle is here. Throws InvalidInput at a source and where no path leads, since there is no
  /// direction. As many steps as the path has faces.
  ///@{
  [[nodiscard]] ExactDeparture<T> departure(Index vertex) const {
    return departure(vertex_point<T>(vertex));
  }
  [[nodiscard]] ExactDeparture<T> departure(const SurfacePoint<T>& point) const;
  ///@}

 private:
  template <std::floating_point>
  friend class ExactSolver;
  template <std::floating_point>
  friend class SmoothDistanceSolver;
  template <std::floating_point>
  friend class detail::ArcTracer;
  template <std::floating_point>
  friend class detail::BorderTracer;
  friend Vec3<T> detail::kept_direction<T>(const ExactField<T>&, const SurfacePoint<T>&);
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Mesh = Surface<Real>;
  using Point = SurfacePoint<Real>;
  using PlanarFaces = detail::PlanarFaces<Real>;
  using Propagation = detail::WindowPropagation<Real>;
  using Limits = detail::PropagationLimits<Real>;
  using Origin = detail::Origin<Real>;
  using Arrival = detail::Arrival<Real>;
  using Weights = std::array<Real, 3>;
  using PastVertex = detail::PastVertex<Real>;
  using Way = detail::Way<Real>;

  // Rounding of the unfolded images, with room: paths that differ by less are equally short.
  static constexpr T default_tolerance = std::max(T(1e-12), 16 * std::numeric_limits<T>::epsilon());
  static constexpr Real same_direction = 1e-6;
  // Paths of plain meshes and needles are as long as their distances to 1e-14, relative.
  static constexpr Real most_path_error = 1e-13;
  // By how much distances of the two ways along one path may differ where they are not.
  static constexpr Real needle_rounding = 1e-9;

  // The end of a path at a point: its last straight piece, or all of it where a search found it.
  struct End {
    Real distance = unreachable<Real>;
    Point point;
    Arrival last;
    Vec2<Real> at{0, 0};        // the point in last.entry's frame
    std::vector<Point> back{};  // from the point to the source
  };

  explicit ExactField(const Mesh& surface) : surface_(surface) {}

  [[nodiscard]] T distance_of_vertex(Index v) const {
    return detail::distance_as<T>(distances_[v] + starts_.at(v), "vertex ", v);
  }
  [[nodiscard]] T distance_of(const End& end) const {
    return detail::distance_as<T>(end.distance + starts_.at(corner_of(end.point)),
                                  "a point at vertex ", corner_of(end.point));
  }
  // One of those by which a point is given.
  [[nodiscard]] Index corner_of(const Point& p) const {
    return p.kind == Point::Kind::face ? surface_.face(p.element[0])[0] : p.element[0];
  }
  [[nodiscard]] Real bound_at(Index v) const {
    return Limits::counted_from(starts_.of_vertex, bound_, v);
  }

  [[nodiscard]] Point checked(const SurfacePoint<T>& point) const {
    surface_.require_point(point);
    return detail::simplified(surface_, point.template cast<Real>());
  }

  [[nodiscard]] End nearest(const Point& p) const {
    if (p.kind == Point::Kind::vertex) return at_vertex(p);
    End best = nearest_known(p);
    from_fronts(p, best);
    if (!has_windows(p)) search_for_shorter(p, best);
    return is_certain(best) ? best : End{unreachable<Real>, p, {}};
  }

  // Of the ways that are known around a point.
  [[nodiscard]] End nearest_known(const Point& p) const {
    End best{unreachable<Real>, p, {}};
    for_each_end(p, best.distance, [&](Real distance, const Arrival& last, const Vec2<Real>& at) {
      if (!(distance < best.distance)) return;
      best.distance = distance;
      best.last = last;
      best.at = at;
    });
    return best;
  }

  [[nodiscard]] bool is_certain(const End& end) const {
    return end.distance <= bound_at(corner_of(end.point));
  }

  [[nodiscard]] End at_vertex(const Point& p) const {
    const Index v = p.element[0];
    End end{distances_[v], p, arrivals_[v]};
    if (end.last.entry >= 0) end.at = faces_->apex(end.last.entry);
    return end;
  }

  // --- what is known around a point ------------------------------------------------------------

  // Calls visit(distance, last piece, the point in its frame) for the ways through the windows that
  // were kept, from the corners of the point's faces and from sources there; but for some that are
  // longer than a limit, which `visit` may lower.
  template <class Visit>
  void for_each_end(const Point& p, const Real& limit, const Visit& visit) const {
    const auto gap = [&](const Point& from) { return detail::straight(surface_, from, p); };
    for_each_face(p, [&](Index f, const Weights& weights) {
      if (keeps_windows(f)) through_windows(f, weights, limit, visit);
      for (const Index v : surface_.face(f)) {
        if (distances_[v] > limit) continue;
        visit(distances_[v] + gap(vertex_point<Real>(v)), Arrival{{0, 0}, Arrival::from_vertex, v},
              Vec2<Real>(0, 0));
      }
    });
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      const auto& source = sources_[s];
      if (source.point.kind == Point::Kind::vertex) continue;  // a corner, visited above
      if (!share_face(p, source.point)) continue;
      visit(source.distance + gap(source.point),
            Arrival{{0, 0}, Arrival::from_source, static_cast<Index>(s)}, Vec2<Real>(0, 0));
    }
  }

  // Calls visit(face, the point's shares of its corners) for each face that holds the point.
  template <class Visit>
  void for_each_face(const Point& p, const Visit& visit) const {
    if (p.kind == Point::Kind::face) return visit(p.element[0], p.weights);
    if (p.kind == Point::Kind::vertex) {
      for (const Index h : surface_.corners(p.element[0])) visit(Mesh::face_of(h), shares(h, 1, 0));
      return;
    }
    const Index first = surface_.find_halfedge(p.element[0], p.element[1]);
    Index h = first;
    do {
      const bool same = surface_.origin(h) == p.element[0];
      visit(Mesh::face_of(h), shares(h, p.weights[same ? 0 : 1], p.weights[same ? 1 : 0]));
      h = surface_.twin(h);
    } while (h != first);
  }

  static Weights shares(Index h, Real at_origin, Real at_tip) {
    Weights weights{0, 0, 0};
    weights[static_cast<std::size_t>(h % 3)] = at_origin;
    weights[static_cast<std::size_t>((h + 1) % 3)] = at_tip;
    return weights;
  }

  [[nodiscard]] bool share_face(const Point& p, const Point& q) const {
    bool shared = false;
    for_each_face(p, [&](Index f, const Weights&) {
      for_each_face(q, [&](Index g, const Weights&) { shared |= f == g; });
    });
    return shared;
  }

  // Windows on a side where the point itself lies are left out: such paths arrive in other faces.
  // So are lines that would miss the side: those bend at a corner, as the way from there does.
  template <class Visit>
  void through_windows(Index f, const Weights& weights, const Real& limit,
                       const Visit& visit) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      if (weights[static_cast<std::size_t>((h + 2) % 3)] == 0) continue;
      const Vec2<Real> at = in_frame(h, weights);
      windows_->for_each(h, [&](const detail::WindowColumns<Real>& w, std::ptrdiff_t count) {
        for (std::ptrdiff_t i = 0; i < count; ++i) {
          const Real start = origins_[w.origin[i]].start, rest = limit - start;
          const Real dx = at.x() - w.x[i], dy = at.y() - w.y[i];
          if (rest < 0 || dx * dx + dy * dy > rest * rest) continue;
          const Real crossing = detail::straight_crossing(w.x[i], w.y[i], at);
          const Real outside = std::max(-crossing, crossing - surface_.length(h));
          if (outside > detail::rounding * surface_.length(h)) continue;
          const Real d = start + detail::distance_through(w.begin[i], w.end[i], w.x[i], w.y[i], at);
          visit(d, Arrival{{w.x[i], w.y[i]}, h, w.origin[i]}, at);
        }
      });
    }
  }

  [[nodiscard]] bool keeps_windows(Index face) const {
    return windows_ && (kept_faces_.empty() || kept_faces_[face] != 0);
  }

  [[nodiscard]] bool has_windows(const Point& p) const {
    bool all = true;
    for_each_face(p, [&](Index f, const Weights&) { all &= keeps_windows(f); });
    return all;
  }

  // Straight from the nearest point of a segment in a face of the point.
  void from_fronts(const Point& p, End& best) const {
    for (const auto& front : fronts_) {
      const Point begin = face_point(front.face, front.begin),
                  end = face_point(front.face, front.end);
      if (!share_face(p, begin)) continue;
      const Vec3<Real> way = surface_.difference(begin, end), to = surface_.difference(begin, p);
      const Real square = way.squaredNorm();
      const Real t = square > 0 ? std::clamp(way.dot(to) / square, Real(0), Real(1)) : 0;
      const Point foot = detail::simplified(surface_, face_point(front.face, front.at(t)));
      const Real distance = front.start + detail::straight(surface_, foot, p);
      if (!(distance < best.distance)) continue;
      best = {distance, p, {}, {0, 0}, {p}};
      if (!(foot == p)) best.back.push_back(foot);
    }
  }

  // --- search back to the sources --------------------------------------------------------------

  // Finds what comes by windows, where none were kept.
  void search_for_shorter(const Point& p, End& best) const {
    const ExactField back = search_back(p, best.distance);
    for (const auto& source : sources_) {
      const End end = back.nearest(source.point);
      if (end.distance + source.distance < best.distance) best = back.turned(end, source, p);
    }
  }

  [[nodiscard]] std::vector<End> ends_of_search(const Point& p, Real limit) const {
    const ExactField back = search_back(p, limit);
    std::vector<End> ends;
    for (const auto& source : sources_) {
      for (const End& end : back.ends_at(source.point, limit - source.distance)) {
        ends.push_back(back.turned(end, source, p));
      }
    }
    return ends;
  }

  // The way to a source, as found from p, as the way from there to p.
  [[nodiscard]] End turned(const End& end, const Source<Real>& source, const Point& p) const {
    std::vector<Point> path = trace(end);
    std::reverse(path.begin(), path.end());
    return {end.distance + source.distance, p, {}, {0, 0}, std::move(path)};
  }

  // Solves from the point to the sources, leaving out what the known distances of the vertices show
  // to be a detour beyond `limit`.
  [[nodiscard]] ExactField search_back(const Point& p, Real limit) const {
    Limits limits;
    limits.cancelled = cancelled_.part(0, 0);
    limits.memory = max_memory_;
    limits.distance = limit * (1 + detail::rounding);
    limits.keep_windows = true;
    limits.rest.reserve(distances_.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      limits.rest.push_back(std::min(distances_[v], bound_at(v)));
    }
    Propagation propagation;
    ExactField back(surface_);
    back.faces_ = faces_;
    back.cancelled_ = cancelled_;
    back.max_memory_ = max_memory_;
    back.sources_ = {{p, 0}};
    propagation.run(surface_, *faces_, back.sources_, limits);
    back.adopt(propagation);
    return back;
  }

  // Takes what a propagation found, or gives it back.
  void exchange(Propagation& propagation, detail::WindowStore<Real>& windows) {
    std::swap(distances_, propagation.distances);
    std::swap(arrivals_, propagation.arrivals);
    std::swap(origins_, propagation.origins);
    std::swap(windows, propagation.kept);
  }

  void adopt(Propagation& propagation) {
    bound_ = propagation.bound();
    distances_ = propagation.distances;
    arrivals_ = propagation.arrivals;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (distances_[v] <= bound_at(v)) continue;
      distances_[v] = unreachable<Real>;
      arrivals_[v] = {};
    }
    origins_ = propagation.origins;
    if (propagation.keeps_any()) {
      windows_ = std::make_shared<const detail::WindowStore<Real>>(std::move(propagation.kept));
      propagation.kept = {};
    }
  }

  // --- directions --------------------------------------------------------------------------------

  // Straight ends within a limit: by windows through which the line to the point goes, and from
  // vertices of the point's faces where paths begin or bend.
  [[nodiscard]] std::vector<End> ends_at(const Point& p, Real limit) const {
    std::vector<End> ends;
    if (p.kind == Point::Kind::vertex && distances_[p.element[0]] <= limit) {
      ends.push_back(at_vertex(p));
    }
    for_each_end(p, limit, [&](Real distance, const Arrival& last, const Vec2<Real>& at) {
      if (!(distance <= limit)) return;
      if (last.entry == Arrival::from_vertex && !begins_lines(last.origin)) return;
      if (p.kind == Point::Kind::vertex && last.entry == Arrival::from_vertex &&
          last.origin == p.element[0]) {
        return;
      }
      ends.push_back({distance, p, last, at});
    });
    return ends;
  }

  [[nodiscard]] bool begins_lines(Index vertex) const {
    return faces_->bends_at(vertex) || is_source(vertex);
  }

  [[nodiscard]] bool is_source(Index vertex) const {
    return std::any_of(sources_.begin(), sources_.end(), [&](const auto& source) {
      return source.point == vertex_point<Real>(vertex);
    });
  }

  [[nodiscard]] std::vector<ExactArrival<T>> distinct(const std::vector<End>& ends) const {
    std::vector<ExactArrival<T>> out;
    std::vector<Vec3<Real>> directions;
    for (const End& end : ends) {
      const Vec3<Real> direction = direction_of(end);
      const bool known = std::any_of(
          directions.begin(), directions.end(),
          [&](const Vec3<Real>& d) { return detail::stable_norm(d - direction) < same_direction; });
      if (known) continue;
      directions.push_back(direction);
      out.push_back(
          {distance_of(end), direction.template cast<T>(), beginning(end).template cast<T>()});
    }
    return out;
  }

  // Next to a corner the way by it is as short as the straight line past it, but for rounding, and
  // over no length there is no direction: there the path tells it.
  [[nodiscard]] Vec3<Real> direction_of(const End& end) const {
    if (end.back.size() > 1) return -first_way(end.back).direction;
    return direction_by(end, [&] { return trace(end); });
  }
  [[nodiscard]] Vec3<Real> direction_by(const End& end, const auto& trace_back) const {
    if (end.last.entry == Arrival::none) return Vec3<Real>::Zero();
    Vec3<Real> direction = last_direction(end);
    const bool is_past = end.last.entry == Arrival::from_vertex && !is_source(end.last.origin) &&
                         is_next_to(end.point, end.last.origin);
    if (!is_past && !direction.isZero(0)) return direction;
    const std::vector<Point> back = trace_back();
    return back.size() > 1 ? Vec3<Real>(-first_way(back).direction) : direction;
  }

  // `direction` in faces whose windows were kept, from sources that are points. A caller that asks
  // for nothing else, as a light field, does without the searches, which are half of the code.
  [[nodiscard]] Vec3<T> kept_direction(const SurfacePoint<T>& point) const;

  // The direction of the last piece of the way to an end.
  [[nodiscard]] Vec3<Real> last_direction(const End& end) const {
    if (end.last.entry == Arrival::from_vertex) {
      return detail::unit_way(surface_, vertex_point<Real>(end.last.origin), end.point);
    }
    if (end.last.entry == Arrival::from_source) {
      return detail::unit_way(surface_, source_point(end.last.origin), end.point);
    }
    return detail::unit_way(surface_, end.last.entry, line_start(end.last, end.at), end.at);
  }

  // --- next to a vertex ----------------------------------------------------------------------

  // Whether a point that is no vertex lies so near to a corner of its faces that its place is lost
  // in the frames of their sides.
  [[nodiscard]] bool is_next_to(const Point& p, Index vertex) const {
    if (p.kind == Point::Kind::vertex) return false;
    return detail::straight(surface_, vertex_point<Real>(vertex), p) <= nearby(p);
  }

  [[nodiscard]] Real nearby(const Point& p) const {
    Real longest = 0;
    for_each_face(p, [&](Index f, const Weights&) {
      for (Index h = 3 * f; h < 3 * f + 3; ++h) longest = std::max(longest, surface_.length(h));
    });
    return detail::next_to_vertex * longest;
  }

  // The corner that a point is next to, or -1.
  [[nodiscard]] Index vertex_next_to(const Point& p) const {
    if (p.kind == Point::Kind::vertex) return -1;
    const auto k = static_cast<std::size_t>(std::max_element(p.weights.begin(), p.weights.end()) -
                                            p.weights.begin());
    const Index v = p.kind == Point::Kind::face ? surface_.face(p.element[0])[k] : p.element[k];
    return is_next_to(p, v) ? v : -1;
  }

  // A point of the faces at a vertex, as each of them sees it.
  [[nodiscard]] detail::Array<typename PastVertex::Place> places_at(Index vertex,
                                                                    const Point& p) const {
    const PastVertex past(surface_, *faces_, vertex);
    detail::Array<typename PastVertex::Place> places;
    for_each_face(p, [&](Index f, const Weights& weights) {
      if (has_corner(f, vertex)) places.push_back(past.place(f, weights));
    });
    return places;
  }
  [[nodiscard]] bool has_corner(Index f, Index vertex) const {
    const auto corners = surface_.face(f);
    return std::find(corners.begin(), corners.end(), vertex) != corners.end();
  }

  // The direction in which a path begins. Its first points may lie so near that they do not tell:
  // then it is that of the straight line to the first that does, past the vertex or over the edge
  // that lies between. The face is told where that is so.
  [[nodiscard]] Way first_way(const std::vector<Point>& path) const {
    const Point& p = path[0];
    const Real near = nearby(p);
    std::size_t k = 1;
    while (k + 1 < path.size() && detail::straight(surface_, p, path[k]) <= near) ++k;
    if (k == 1) return {detail::unit_way(surface_, p, path[1])};
    const Index v = vertex_next_to(p);
    Way way;
    if (v >= 0) {
      way = way_past(v, path[k - 1], path[k], p);
    } else if (k == 2 && p.kind == Point::Kind::face && path[1].kind == Point::Kind::edge) {
      way = way_over(path[1], path[2], p);
    }
    if (!way.direction.isZero(0)) return way;
    const bool tells = detail::straight(surface_, p, path[1]) > detail::next_to_vertex * near;
    return {detail::unit_way(surface_, p, path[tells ? 1 : k])};
  }

  // From a point past a vertex to the end of a piece of a path that begins at the vertex or next to
  // it; zero where the piece is not in a face of the vertex.
  [[nodiscard]] Way way_past(Index vertex, const Point& begin, const Point& end,
                             const Point& p) const {
    const PastVertex past(surface_, *faces_, vertex);
    Way way;
    for_each_face(end, [&](Index f, const Weights& weights) {
      const auto in_face = face_point<Real>(f, {1.0 / 3, 1.0 / 3, 1.0 / 3});
      if (way.face >= 0 || !has_corner(f, vertex) || !share_face(begin, in_face)) return;
      way = past.way(places_at(vertex, p), past.place(f, weights));
    });
    return way;
  }

  // From a point inside a face straight over a point of one of its edges to one in the face beyond.
  [[nodiscard]] Way way_over(const Point& edge, const Point& end, const Point& p) const {
    const Index f = p.element[0];
    Index h = 3 * f;
    for (Index side = 3 * f; side < 3 * f + 3; ++side) {
      const Index a = surface_.origin(side), b = surface_.tip(side);
      if (std::minmax(a, b) == std::minmax(edge.element[0], edge.element[1])) h = side;
    }
    Way way;
    if (detail::is_thin(surface_, *faces_, h)) return way;
    for_each_face(end, [&](Index g, const Weights& weights) {
      for (Index across = surface_.twin(h); across != h; across = surface_.twin(across)) {
        if (Mesh::face_of(across) != g || way.face >= 0) continue;
        Vec2<Real> to = in_frame(across, weights);
        if (surface_.origin(across) != surface_.origin(h)) to.x() = surface_.length(h) - to.x();
        way = {detail::unit_way(surface_, h, in_frame(h, p.weights), {to.x(), -to.y()}), f};
      }
    });
    return way;
  }

  // The place of a point in a half-edge's face, by its shares of the face's corners.
  [[nodiscard]] Vec2<Real> in_frame(Index h, const Weights& weights) const {
    const Real at_tip = weights[static_cast<std::size_t>((h + 1) % 3)];
    const Real at_apex = weights[static_cast<std::size_t>((h + 2) % 3)];
    const Vec2<Real>& apex = faces_->apex(h);
    return {at_tip * surface_.length(h) + at_apex * apex.x(), at_apex * apex.y()};
  }

  // Where the last straight line to a place begins, in the frame of the half-edge it crosses. A
  // bend that lengthens it by rounding only is rounding of a window's end.
  static Vec2<Real> line_start(const Arrival& last, const Vec2<Real>& at) {
    if (last.is_straight()) return last.image;
    const Vec2<Real> bend(last.bend, 0);
    const Real length = (last.image - bend).norm() + (bend - at).norm();
    const Real straight = (last.image - at).norm();
    return length - straight > detail::rounding * length ? bend : last.image;
  }

  // Where the last straight line to an end begins.
  [[nodiscard]] Point beginning(const End& end) const {
    if (!end.back.empty()) return first_bend(end.back);
    if (end.last.entry == Arrival::none) return end.point;
    const Arrival last = last_bend(end.last);
    if (last.entry == Arrival::from_vertex) return vertex_point<Real>(last.origin);
    if (last.entry == Arrival::from_source) return source_point(last.origin);
    Index origin = last.origin;
    while (origins_[origin].kind == Origin::Kind::crossing) {
      origin = origins_[origin].previous;
    }
    const Origin& o = origins_[origin];
    if (o.kind == Origin::Kind::front) return first_bend(trace(end));
    return o.kind == Origin::Kind::vertex ? vertex_point<Real>(o.index) : source_point(o.index);
  }

  // The arrival by a vertex where the path cannot bend goes on with the arrival there.
  [[nodiscard]] Arrival last_bend(Arrival last) const {
    while (last.entry == Arrival::from_vertex && !bends_anywhere_ && !begins_lines(last.origin)) {
      last = arrivals_[last.origin];
    }
    return last;
  }

  [[nodiscard]] Point first_bend(const std::vector<Point>& back) const {
    const auto bends = [&](const Point& p) {
      return p.kind == Point::Kind::vertex && begins_lines(p.element[0]);
    };
    const auto bend = std::find_if(back.begin() + 1, back.end(), bends);
    return bend == back.end() ? back.back() : *bend;
  }

  [[nodiscard]] const Point& source_point(Index source) const {
    return sources_[static_cast<std::size_t>(source)].point;
  }

  [[nodiscard]] std::vector<Point> trace_lines(const End& end) const {
    detail::PointTrail<Real> trail(surface_, end.point);
    const detail::Solved<Real> known = solved();
    detail::LineBacktrace<Real>(known, fronts_).back(end.at, end.last, trail);
    return std::move(trail).points();
  }

  // The way back to the source. Where faces are so thin that the straight line of a vertex's last
  // piece loses its way to rounding, the path is not as long as the distance, and found again.
  [[nodiscard]] std::vector<Point> trace(const End& end) const {
    if (!end.back.empty()) return end.back;
    if (!(end.distance < unreachable<Real>)) return {};
    std::vector<Point> path = trace_lines(end);
    if (!fronts_.empty()) return path;
    const Real error = path_error(path, end.distance);
    if (error <= most_path_error * end.distance) return path;
    std::vector<Point> again = backtrace_by_windows(end);
    return path_error(again, end.distance) < error ? again : path;
  }

  // Writes down the way from a vertex back to its source; nothing where none leads. It is not told
  // whether it lost its way: `is_shortest` does.
  void follow(Index vertex, auto& trail) const {
    trail.clear();
    const End end = at_vertex(vertex_point<Real>(vertex));
    if (!(end.distance < unreachable<Real>)) return;
    trail.to_vertex(vertex);
    const detail::Solved<Real> known = solved();
    detail::LineBacktrace<Real>(known, fronts_).back(end.at, end.last, trail);
  }
  // Whether a way of some length from a source to a vertex is as long as the shortest one.
  [[nodiscard]] bool is_shortest(const Point& source, Real length, Index vertex) const {
    const Real distance = distances_[vertex];
    return std::fabs(start_at(source) + length - distance) <= most_path_error * distance;
  }

  // By how much a path to a source is longer or shorter than a distance.
  [[nodiscard]] Real path_error(const std::vector<Point>& path, Real distance) const {
    if (path.empty()) return unreachable<Real>;
    Real sum = start_at(path.back());
    for (std::size_t i = 1; i < path.size(); ++i) {
      sum += detail::straight(surface_, path[i - 1], path[i]);
    }
    return std::fabs(sum - distance);
  }

  // The least start distance of the sources at a point.
  [[nodiscard]] Real start_at(const Point& p) const {
    Real least = unreachable<Real>;
    for (const auto& source : sources_) {
      if (source.point == p) least = std::min(least, source.distance);
    }
    return least;
  }

  // The way back to the source by windows, which are found anew where they were not kept.
  [[nodiscard]] std::vector<Point> backtrace_by_windows(const End& end) const {
    if (windows_ && kept_faces_.empty()) return backtrace_by_windows(end.point, end.distance);
    Real longest = 0;
    for_each_face(end.point, [&](Index f, const Weights&) {
      for (Index h = 3 * f; h < 3 * f + 3; ++h) longest = std::max(longest, surface_.length(h));
    });
    const Real limit = end.distance * (1 + needle_rounding) + detail::rounding * longest;
    const ExactField back = search_back(end.point, limit);
    End nearest;
    Real least = unreachable<Real>;
    for (const auto& source : sources_) {
      const End from = back.nearest(source.point);
      if (!(from.distance + source.distance < least)) continue;
      least = from.distance + source.distance;
      nearest = from;
    }
    if (!(least < unreachable<Real>)) return {};
    std::vector<Point> path = back.backtrace_by_windows(nearest.point, nearest.distance);
    std::reverse(path.begin(), path.end());
    return path;
  }

  [[nodiscard]] std::vector<Point> backtrace_by_windows(const Point& p, Real distance) const {
    const detail::Solved<Real> known = solved();
    return detail::WindowBacktrace<Real>(known, *windows_).back(p, distance);
  }

  [[nodiscard]] detail::Solved<Real> solved() const {
    return {surface_, *faces_, sources_, distances_, arrivals_, origins_};
  }

  [[nodiscard]] ExactDeparture<T> departure_along(const std::vector<Point>& path) const {
    ExactDeparture<T> out{};
    const Way way = first_way(path);
    out.direction = way.direction.template cast<T>();
    for_each_face(path[0], [&](Index f, const Weights& weights) {
      if (way.face >= 0 && f != way.face) return;
      const auto in_face = face_point<Real>(f, {1.0 / 3, 1.0 / 3, 1.0 / 3});
      if (way.face < 0 && !share_face(path[1], in_face)) return;
      Index h = 3 * f;
      while (path[0].kind != Point::Kind::face && !starts_at(h, weights)) ++h;
      out.halfedge = h;
      out.angle = static_cast<T>(detail::angle_from(surface_, h, way.direction));
    });
    return out;
  }

  // Whether a half-edge starts at a source vertex or lies on a source's edge.
  static bool starts_at(Index h, const Weights& weights) {
    const auto k = static_cast<std::size_t>(h % 3);
    return weights[k] > 0 && weights[(k + 2) % 3] == 0;
  }

  Mesh surface_;
  std::shared_ptr<const PlanarFaces> faces_;
  detail::Starts<Real> starts_;
  detail::Array<Source<Real>> sources_;               // their distances less those
  detail::Array<detail::SegmentFront<Real>> fronts_;  // of segments, theirs likewise
  Real bound_ = unreachable<Real>;
  detail::Array<Real> distances_;    // of each vertex, less its start
  detail::Array<Arrival> arrivals_;  // of each vertex
  detail::Array<Origin> origins_;
  std::shared_ptr<const detail::WindowStore<Real>> windows_;  // where any were kept
  detail::Array<char> kept_faces_;                            // which, or empty for all
  bool bends_anywhere_ = false;                               // with a reset radius
  CancelHook cancelled_;
  std::size_t max_memory_ = std::numeric_limits<std::size_t>::max();
};

template <std::floating_point T>
auto ExactField<T>::distances() const -> std::vector<T> {
  std::vector<T> out;
  out.reserve(distances_.size());
  for (Index v = 0; v < surface_.vertex_count(); ++v) out.push_back(distance_of_vertex(v));
  return out;
}

template <std::floating_point T>
auto ExactField<T>::distance(const SurfacePoint<T>& point) const -> T {
  return distance_of(nearest(checked(point)));
}

template <std::floating_point T>
auto ExactField<T>::path(const SurfacePoint<T>& point) const -> Path<T> {
  const std::vector<Point> back = trace(nearest(checked(point)));
  Path<T> out;
  out.reserve(back.size());
  for (auto p = back.rbegin(); p != back.rend(); ++p) out.push_back(p->template cast<T>());
  return out;
}

template <std::floating_point T>
auto ExactField<T>::direction(const SurfacePoint<T>& point) const -> Vec3<T> {
  return direction_of(nearest(checked(point))).template cast<T>();
}

template <std::floating_point T>
auto ExactField<T>::kept_direction(const SurfacePoint<T>& point) const -> Vec3<T> {
  const Point p = checked(point);
  const bool is_vertex = p.kind == Point::Kind::vertex;
  const End end = is_vertex ? at_vertex(p) : nearest_known(p);
  if (!is_certain(end)) return Vec3<T>::Zero();
  return direction_by(end, [&] { return trace_lines(end); }).template cast<T>();
}

template <std::floating_point T>
auto ExactField<T>::arrivals(const SurfacePoint<T>& point, T relative_tolerance) const
    -> std::vector<ExactArrival<T>> {
  detail::require(relative_tolerance >= 0, "a relative tolerance of ", relative_tolerance);
  const Point p = checked(point);
  const End shortest = nearest(p);
  if (!(shortest.distance < unreachable<Real>)) return {};
  const Real limit = shortest.distance * (1 + Real{relative_tolerance});
  std::vector<End> ends = has_windows(p) ? ends_at(p, limit) : ends_of_search(p, limit);
  ends.push_back(shortest);
  std::stable_sort(ends.begin(), ends.end(),
                   [](const End& a, const End& b) { return a.distance < b.distance; });
  return distinct(ends);
}

template <std::floating_point T>
auto ExactField<T>::departure(const SurfacePoint<T>& point) const -> ExactDeparture<T> {
  std::vector<Point> path = trace(nearest(checked(point)));
  detail::require(path.size() > 1, "no direction leads from a source to the point on ",
                  point.kind == SurfacePoint<T>::Kind::face ? "face " : "vertex ",
                  point.element[0]);
  std::reverse(path.begin(), path.end());
  return departure_along(path);
}

namespace detail {

/// The same as `field.direction(point)`, with less to compile: at a vertex, or where windows were
/// kept in the point's faces, from sources that are points.
template <std::floating_point T>
Vec3<T> kept_direction(const ExactField<T>& field, const SurfacePoint<T>& point) {
  return field.kept_direction(point);
}

}  // namespace detail

/// Exact geodesic distance on a triangle mesh: the length of the shortest path over its faces.
///
/// Constructed once from a mesh, in O(vertices + faces log valence); queries are const and safe
/// from several threads, and memory is used again. A mesh may have borders, any genus, several
/// components, edges of three faces or more (paths turn into each of them), vertices where several
/// fans meet (paths pass through), flipped faces, zero-length edges and zero-area faces.
///
/// Exact up to rounding: some 1e-15 relative, times the aspect ratio of needles; at any distance
/// from the origin, and for sources and queries as near to a vertex or an edge as you like. A solve
/// makes about vertices^1.5 windows on a smooth closed surface, less on a rough one, and holds
/// those of the wavefront only, unless told to keep them. Where many faces meet on each edge it is
/// more, since paths turn into each: vertices^1.6, rising to 1.7, on grids of tetrahedra with all
/// their faces, of 216 to 2,744 vertices, and 43 kB a vertex at the end. ExactOptions::max_memory
/// bounds that.
///
/// J. S. B. Mitchell, D. M. Mount, C. H. Papadimitriou, "The discrete geodesic problem", 1987,
/// doi:10.1137/0216045; Y. Qin, X. Han, H. Yu, Y. Yu, J. Zhang, "Fast and exact discrete geodesic
/// computation based on triangle-oriented wavefront propagation", 2016,
/// doi:10.1145/2897824.2925930.
template <std::floating_point T>
class ExactSolver : public detail::DistanceQueries<ExactSolver<T>, T> {
 public:
  /// Throws InvalidInput as Surface does, and for options that do not fit the mesh. The options
  /// hold for every query that is not given its own.
  explicit ExactSolver(const TriangleMesh auto& mesh, ExactOptions<T> options = {})
      : surface_(mesh, options.cancelled.part(0, 0)), options_(std::move(options)) {
    set_up();
  }

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

  /// Solves from a vertex or another point, from several vertices, or from several points with
  /// start distances. Throws InvalidInput for no source, a source that is not of the mesh or starts
  /// with a distance that is not finite, and for options that do not fit the mesh; Cancelled where
  /// the options' hook says so, MemoryLimit where windows take more than the options allow. The
  /// solver can be used again after each.
  ///@{
  [[nodiscard]] ExactField<T> solve(Index vertex) const { return solve(vertex, options_); }
  [[nodiscard]] ExactField<T> solve(Index vertex, const ExactOptions<T>& options) const {
    return solve(std::span<const Index>(&vertex, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(const SurfacePoint<T>& source) const {
    return solve(source, options_);
  }
  [[nodiscard]] ExactField<T> solve(const SurfacePoint<T>& source,
                                    const ExactOptions<T>& options) const {
    const Source<T> one{source, 0};
    return solve(std::span<const Source<T>>(&one, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Index> vertices) const {
    return solve(vertices, options_);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Index> vertices,
                                    const ExactOptions<T>& options) const;
  [[nodiscard]] ExactField<T> solve(std::span<const Source<T>> sources) const {
    return solve(sources, options_);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Source<T>> sources,
                                    const ExactOptions<T>& options) const;
  ///@}

  /// Distances from the nearest points of segments: of curves, as chains of them. They are those of
  /// straight lines at a right angle to a segment, but for 4e-9 of the mesh's size. Paths and
  /// directions begin at the nearest point. Throws InvalidInput as above, for no segment and for
  /// one whose ends no face holds both.
  ///@{
  [[nodiscard]] ExactField<T> solve(std::span<const Segment<T>> segments) const {
    return solve(segments, options_);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Segment<T>> segments,
                                    const ExactOptions<T>& options) const {
    const Curves curves = curves_of(segments);
    // Queries at points that are no vertices cannot search back to a line.
    ExactOptions<T> with_windows = options;
    with_windows.keep_windows = true;
    return solve_checked(curves.sources, with_windows, curves.fronts);
  }
  [[nodiscard]] std::vector<T> distance(std::span<const Segment<T>> segments) const {
    const Curves curves = curves_of(segments);
    return solve_checked(curves.sources, options_, curves.fronts).distances();
  }
  using detail::DistanceQueries<ExactSolver<T>, T>::distance;
  ///@}

 private:
  friend class detail::DistanceQueries<ExactSolver<T>, T>;
  template <std::floating_point>
  friend class PathSolver;
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Point = SurfacePoint<Real>;
  using PlanarFaces = detail::PlanarFaces<Real>;
  using Sources = detail::Array<Source<Real>>;
  using Workspace = detail::WindowPropagation<Real>;
  using Limits = detail::PropagationLimits<Real>;
  using Pool = detail::Pool<Workspace>;
  using Borrowed = typename Pool::Borrowed;

  void set_up();

  void require_options(const ExactOptions<T>& options) const {
    detail::require(!std::isnan(options.max_distance), "the greatest distance is not a number");
    detail::require(options.reset_radius > 0, "the reset radius is ", options.reset_radius,
                    ", not a positive number");
    for (const auto& target : options.targets) surface_.require_point(target);
  }

  void solve_vertices(detail::DistanceQuery<Real>& query) const;

  // Segments, and the points of them from which their ends and the corners of their faces are
  // reached.
  struct Curves {
    detail::Array<detail::SegmentFront<Real>> fronts;
    Sources sources;
  };
  [[nodiscard]] Curves curves_of(std::span<const Segment<T>> segments) const {
    detail::require(!segments.empty(), "there is no segment");
    Curves out;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const auto fronts = detail::fronts_of(surface_, segments[i], i);
      for (const auto& front : fronts) add_points(front, out.sources);
      out.fronts.append(fronts.begin(), fronts.end());
    }
    return out;
  }
  void add_points(const detail::SegmentFront<Real>& front, Sources& sources) const {
    const Point begin = face_point(front.face, front.begin),
                end = face_point(front.face, front.end);
    const Vec3<Real> way = surface_.difference(begin, end);
    const Real square = way.squaredNorm();
    const auto add = [&](Real t) {
      sources.push_back({face_point(front.face, front.at(t)), front.start});
    };
    add(0);
    if (!(square > 0)) return;
    add(1);
    for (const Index v : surface_.face(front.face)) {
      const Real t = way.dot(surface_.difference(begin, vertex_point<Real>(v))) / square;
      if (t > 0.0 && t < 1.0) add(t);
    }
  }

  [[nodiscard]] ExactField<T> solve_checked(
      Sources sources, const ExactOptions<T>& options,
      detail::Array<detail::SegmentFront<Real>> fronts = {}) const;

  // The shortest path between two points, if it is no longer than `longest`, by windows that can be
  // part of such a path alone; empty else.
  [[nodiscard]] std::vector<Point> path_within(const Point& from, const Point& to,
                                               Real longest) const;

  void run(Workspace& workspace, const Sources& sources, const Limits& limits) const {
    workspace.run(surface_, *faces_, sources, limits);
  }

  void normalise(Sources& sources, detail::Starts<Real>& starts) const {
    for (auto& source : sources) source.point = detail::simplified(surface_, source.point);
    starts.move_to_zero(surface_, sources);
  }

  [[nodiscard]] Limits limits_of(const ExactOptions<T>& options,
                                 const detail::Starts<Real>& starts) const {
    Limits limits;
    limits.distance = Real{options.max_distance} - starts.common;
    if (!starts.of_vertex.empty()) limits.starts = &starts.of_vertex;
    limits.cancelled = options.cancelled;
    limits.memory = options.max_memory;
    limits.keep_windows = options.keep_windows;
    if (options.reset_radius < unreachable<T> && mean_edge_ > 0) {
      limits.ring = Real{options.reset_radius} * mean_edge_;
      limits.keep_windows = true;
    }
    for (const auto& target : options.targets) {
      add_target(detail::simplified(surface_, target.template cast<Real>()), limits);
    }
    return limits;
  }

  void add_target(const Point& p, Limits& limits) const {
    std::array<Index, 3> corners{p.element[0], p.element[0], p.element[0]};
    if (p.kind == Point::Kind::edge) corners[1] = p.element[1];
    if (p.kind == Point::Kind::face) corners = surface_.face(p.element[0]);
    typename Limits::Target target{corners, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      target.gaps[k] = detail::straight(surface_, p, vertex_point<Real>(corners[k]));
    }
    limits.targets.push_back(target);
    if (p.kind == Point::Kind::vertex || limits.keep_windows) return;
    limits.faces_to_keep.resize(static_cast<std::size_t>(surface_.face_count()), 0);
    if (p.kind == Point::Kind::face) {
      limits.faces_to_keep[p.element[0]] = 1;
      return;
    }
    const Index first = surface_.find_halfedge(p.element[0], p.element[1]);
    Index h = first;
    do {
      limits.faces_to_keep[Surface<Real>::face_of(h)] = 1;
      h = surface_.twin(h);
    } while (h != first);
  }

  Surface<Real> surface_;
  std::shared_ptr<const PlanarFaces> faces_;
  ExactOptions<T> options_;
  Real mean_edge_ = 0;
  std::shared_ptr<Pool> pool_;
};

template <std::floating_point T>
void ExactSolver<T>::set_up() {
  require_options(options_);
  faces_ = std::make_shared<const PlanarFaces>(surface_);
  mean_edge_ = detail::mean_edge_length(surface_);
  pool_ = std::make_shared<Pool>();
}

template <std::floating_point T>
auto ExactSolver<T>::solve(std::span<const Index> vertices, const ExactOptions<T>& options) const
    -> ExactField<T> {
  return solve_checked(detail::checked_sources(surface_, vertices), options);
}

template <std::floating_point T>
auto ExactSolver<T>::solve(std::span<const Source<T>> sources, const ExactOptions<T>& options) const
    -> ExactField<T> {
  return solve_checked(detail::checked_sources(surface_, sources), options);
}

template <std::floating_point T>
void ExactSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query) const {
  auto& [sources, starts, distance] = query;
  normalise(sources, starts);
  const Borrowed workspace(*pool_);
  Limits limits = limits_of(options_, starts);
  limits.keep_windows = false;
  limits.faces_to_keep.clear();
  run(*workspace, sources, limits);
  distance.resize((*workspace).distances.size());
  for (Index v = 0; v < surface_.vertex_count(); ++v) {
    const Real d = (*workspace).distances[v];
    distance[v] = d <= (*workspace).bound_at(v) ? d + starts.at(v) : unreachable<Real>;
  }
}

template <std::floating_point T>
auto ExactSolver<T>::solve_checked(Sources sources, const ExactOptions<T>& options,
                                   detail::Array<detail::SegmentFront<Real>> fronts) const
    -> ExactField<T> {
  require_options(options);
  ExactField<T> field(surface_);
  field.faces_ = faces_;
  field.cancelled_ = options.cancelled;
  field.max_memory_ = options.max_memory;
  normalise(sources, field.starts_);
  field.sources_ = std::move(sources);
  for (auto& front : fronts) front.start -= field.starts_.at(surface_.face(front.face)[0]);
  field.fronts_ = std::move(fronts);
  Limits limits = limits_of(options, field.starts_);
  limits.fronts = field.fronts_;
  limits.size = field.fronts_.empty() ? 0 : detail::size_of(surface_);
  const Borrowed workspace(*pool_);
  run(*workspace, field.sources_, limits);
  field.adopt(*workspace);
  field.bends_anywhere_ = limits.ring < unreachable<Real>;
  field.kept_faces_ = limits.keep_windows ? detail::Array<char>{} : limits.faces_to_keep;
  return field;
}

template <std::floating_point T>
auto ExactSolver<T>::path_within(const Point& from, const Point& to, Real longest) const
    -> std::vector<Point> {
  ExactField<T> field(surface_);
  field.faces_ = faces_;
  field.cancelled_ = options_.cancelled;
  field.max_memory_ = options_.max_memory;
  field.sources_ = {{from, 0}};
  Limits limits;
  limits.distance = longest;
  limits.goal = &to;
  limits.cancelled = options_.cancelled;
  limits.memory = options_.max_memory;
  limits.keep_windows = true;
  add_target(to, limits);
  const Borrowed workspace(*pool_);
  run(*workspace, field.sources_, limits);
  field.bound_ = (*workspace).bound();
  const auto windows = std::make_shared<detail::WindowStore<Real>>();
  field.windows_ = windows;
  field.exchange(*workspace, *windows);
  std::vector<Point> path = field.trace(field.nearest(to));
  std::reverse(path.begin(), path.end());
  field.exchange(*workspace, *windows);
  return path;
}

template <TriangleMesh M>
explicit ExactSolver(const M&) -> ExactSolver<MeshScalar<M>>;
template <TriangleMesh M>
ExactSolver(const M&, ExactOptions<MeshScalar<M>>) -> ExactSolver<MeshScalar<M>>;

}  // namespace gelight
