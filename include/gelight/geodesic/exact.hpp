#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/path_backtrace.hpp"
#include "gelight/geodesic/exact/path_directions.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/search_back.hpp"
#include "gelight/geodesic/exact/window_list.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
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
class ExactField;

namespace detail {
template <std::floating_point T>
auto solution_of(const ExactField<T>& field)
    -> const WindowSolution<typename WorkingPrecision<T>::Real>&;
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
    solution_.surface.require_vertex(vertex);
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
  template <std::floating_point U>
  friend auto detail::solution_of(const ExactField<U>& field)
      -> const detail::WindowSolution<typename detail::WorkingPrecision<U>::Real>&;
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Point = SurfacePoint<Real>;
  using Solution = detail::WindowSolution<Real>;
  using Query = detail::PointQuery<Real>;
  using Search = detail::SearchBack<Real>;
  using Backtrace = detail::PathBacktrace<Real>;
  using Directions = detail::PathDirections<Real>;
  using End = detail::PathEnd<Real>;

  // Rounding of the unfolded images, with room: paths that differ by less are equally short.
  static constexpr T default_tolerance = std::max(T(1e-12), 16 * std::numeric_limits<T>::epsilon());
  static constexpr Real same_direction = 1e-6;

  explicit ExactField(Solution solution) : solution_(std::move(solution)) {}

  [[nodiscard]] T distance_of_vertex(Index v) const {
    return detail::distance_as<T>(solution_.distances[v] + solution_.starts.at(v), "vertex ", v);
  }
  [[nodiscard]] T distance_of(const End& end) const {
    const Index corner = Query(solution_).corner_of(end.point);
    return detail::distance_as<T>(end.distance + solution_.starts.at(corner), "a point at vertex ",
                                  corner);
  }

  [[nodiscard]] Point checked(const SurfacePoint<T>& point) const {
    solution_.surface.require_point(point);
    return detail::simplified(solution_.surface, point.template cast<Real>());
  }

  // The nearest end at a point: by what the solution knows, and what a search adds to it.
  [[nodiscard]] End nearest(const Point& p) const {
    const Query query(solution_);
    if (p.kind == Point::Kind::vertex) return query.at_vertex(p.element[0]);
    End best = query.known(p);
    if (!query.has_windows(p)) Search(solution_).shorten(best);
    return query.within_bound(std::move(best));
  }

  // All ends at a point within a limit.
  [[nodiscard]] std::vector<End> ends_at(const Point& p, Real limit) const {
    const Query query(solution_);
    return query.has_windows(p) ? query.ends_at(p, limit) : Search(solution_).ends_at(p, limit);
  }

  // The way from an end back to its source.
  [[nodiscard]] detail::Array<Point> trace(const End& end) const {
    const Backtrace backtrace(solution_);
    return backtrace.back(end, [&] {
      return solution_.keeps_all_windows() ? backtrace.by_windows(end)
                                           : Search(solution_).back(end);
    });
  }
  [[nodiscard]] Vec3<Real> direction_of(const End& end) const {
    return Directions(solution_).direction_of(end, [&](const End& e) { return trace(e); });
  }

  [[nodiscard]] std::vector<ExactArrival<T>> distinct(const std::vector<End>& ends) const;

  Solution solution_;
};

namespace detail {
/// What the solve behind a field found.
template <std::floating_point T>
[[nodiscard]] auto solution_of(const ExactField<T>& field)
    -> const WindowSolution<typename WorkingPrecision<T>::Real>& {
  return field.solution_;
}
}  // namespace detail

template <std::floating_point T>
auto ExactField<T>::distances() const -> std::vector<T> {
  std::vector<T> out;
  const Index count = solution_.surface.vertex_count();
  out.reserve(static_cast<std::size_t>(count));
  for (Index v = 0; v < count; ++v) out.push_back(distance_of_vertex(v));
  return out;
}

template <std::floating_point T>
auto ExactField<T>::distance(const SurfacePoint<T>& point) const -> T {
  return distance_of(nearest(checked(point)));
}

template <std::floating_point T>
auto ExactField<T>::path(const SurfacePoint<T>& point) const -> Path<T> {
  const detail::Array<Point> back = trace(nearest(checked(point)));
  Path<T> out;
  out.reserve(back.size());
  for (std::size_t i = back.size(); i-- > 0;) out.push_back(back[i].template cast<T>());
  return out;
}

template <std::floating_point T>
auto ExactField<T>::direction(const SurfacePoint<T>& point) const -> Vec3<T> {
  return cast<T>(direction_of(nearest(checked(point))));
}

template <std::floating_point T>
auto ExactField<T>::arrivals(const SurfacePoint<T>& point, T relative_tolerance) const
    -> std::vector<ExactArrival<T>> {
  detail::require(relative_tolerance >= 0, "a relative tolerance of ", relative_tolerance);
  const Point p = checked(point);
  const End shortest = nearest(p);
  if (!(shortest.distance < unreachable<Real>)) return {};
  const Real limit = shortest.distance * (1 + Real{relative_tolerance});
  std::vector<End> ends = ends_at(p, limit);
  ends.push_back(shortest);
  std::stable_sort(ends.begin(), ends.end(),
                   [](const End& a, const End& b) { return a.distance < b.distance; });
  return distinct(ends);
}

template <std::floating_point T>
auto ExactField<T>::departure(const SurfacePoint<T>& point) const -> ExactDeparture<T> {
  detail::Array<Point> path = trace(nearest(checked(point)));
  detail::require(path.size() > 1, "no direction leads from a source to the point on ",
                  point.kind == SurfacePoint<T>::Kind::face ? "face " : "vertex ",
                  point.element[0]);
  std::reverse(path.begin(), path.end());
  const auto way = Directions(solution_).departure(path);
  return {cast<T>(way.direction), way.halfedge, static_cast<T>(way.angle)};
}

// Ends of another direction than those before.
template <std::floating_point T>
auto ExactField<T>::distinct(const std::vector<End>& ends) const -> std::vector<ExactArrival<T>> {
  using namespace detail::arithmetic;
  const Directions directions(solution_);
  std::vector<ExactArrival<T>> out;
  std::vector<Vec3<Real>> known;
  for (const End& end : ends) {
    const Vec3<Real> direction = direction_of(end);
    const bool is_known = std::any_of(known.begin(), known.end(), [&](const Vec3<Real>& d) {
      return detail::stable_norm(d - direction) < same_direction;
    });
    if (is_known) continue;
    known.push_back(direction);
    const Point from = directions.beginning(end, [&](const End& e) { return trace(e); });
    out.push_back({distance_of(end), cast<T>(direction), from.template cast<T>()});
  }
  return out;
}

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
    return solve(Source<T>{source, 0}, options);
  }
  [[nodiscard]] ExactField<T> solve(const Source<T>& source) const {
    return solve(source, options_);
  }
  [[nodiscard]] ExactField<T> solve(const Source<T>& source, const ExactOptions<T>& options) const {
    return solve(std::span<const Source<T>>(&source, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(std::initializer_list<Index> vertices) const {
    return solve(vertices, options_);
  }
  [[nodiscard]] ExactField<T> solve(std::initializer_list<Index> vertices,
                                    const ExactOptions<T>& options) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()), options);
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

  /// `distance_into` by other options than the solver's. Throws InvalidInput as `solve` does.
  void distance_into(std::span<T> out, std::span<const Source<T>> sources,
                     const ExactOptions<T>& options) const {
    require_options(options);
    this->put_distances(out, sources, [&](auto& query) { solve_vertices(query, options); });
  }
  using detail::DistanceQueries<ExactSolver<T>, T>::distance_into;

 private:
  friend class detail::DistanceQueries<ExactSolver<T>, T>;
  template <std::floating_point>
  friend class PathSolver;
  template <std::floating_point>
  friend class SmoothDistanceSolver;
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Point = SurfacePoint<Real>;
  using PlanarFaces = detail::PlanarFaces<Real>;
  using Sources = detail::Array<Source<Real>>;
  using Solution = detail::WindowSolution<Real>;
  using Workspace = detail::WindowPropagation<Real>;
  using Limits = detail::PropagationLimits<Real>;
  using Target = typename Limits::Target;
  using Pool = detail::Pool<Workspace>;
  using Borrowed = typename Pool::Borrowed;

  void set_up();

  void require_options(const ExactOptions<T>& options) const {
    detail::require(!std::isnan(options.max_distance), "the greatest distance is not a number");
    detail::require(options.reset_radius > 0, "the reset radius is ", options.reset_radius,
                    ", not a positive number");
    for (const auto& target : options.targets) surface_.require_point(target);
  }

  void solve_vertices(detail::DistanceQuery<Real>& query) const { solve_vertices(query, options_); }
  void solve_vertices(detail::DistanceQuery<Real>& query, const ExactOptions<T>& options) const;

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
    const Real square = squared_norm(way);
    const auto add = [&](Real t) {
      sources.push_back({face_point(front.face, front.at(t)), front.start});
    };
    add(0);
    if (!(square > 0)) return;
    add(1);
    for (const Index v : surface_.face(front.face)) {
      const Real t = dot(way, surface_.difference(begin, vertex_point<Real>(v))) / square;
      if (t > 0.0 && t < 1.0) add(t);
    }
  }

  [[nodiscard]] ExactField<T> solve_checked(
      Sources sources, const ExactOptions<T>& options,
      detail::Array<detail::SegmentFront<Real>> fronts = {}) const;

  [[nodiscard]] Solution empty_solution(const ExactOptions<T>& options) const {
    Solution solution{surface_, faces_};
    solution.cancelled = options.cancelled;
    solution.max_memory = options.max_memory;
    return solution;
  }
  // Solves from the solution's sources into its memory; of segments, from its fronts besides.
  void solve_into(Solution& solution, const ExactOptions<T>& options) const;

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

  // But for the windows to keep; `targets` are memory to use again.
  [[nodiscard]] Limits limits_of(const ExactOptions<T>& options, const detail::Starts<Real>& starts,
                                 detail::Array<Target> targets = {}) const {
    Limits limits;
    limits.distance = Real{options.max_distance} - starts.common;
    if (!starts.of_vertex.empty()) limits.starts = &starts.of_vertex;
    limits.cancelled = options.cancelled;
    limits.memory = options.max_memory;
    if (options.reset_radius < unreachable<T> && mean_edge_ > 0) {
      limits.ring = Real{options.reset_radius} * mean_edge_;
    }
    targets.clear();
    for (const auto& point : options.targets) {
      targets.push_back(target_at(detail::simplified(surface_, point.template cast<Real>())));
    }
    limits.targets = std::move(targets);
    return limits;
  }

  [[nodiscard]] Target target_at(const Point& p) const {
    std::array<Index, 3> corners{p.element[0], p.element[0], p.element[0]};
    if (p.kind == Point::Kind::edge) corners[1] = p.element[1];
    if (p.kind == Point::Kind::face) corners = surface_.face(p.element[0]);
    Target target{corners, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      target.gaps[k] = detail::straight(surface_, p, vertex_point<Real>(corners[k]));
    }
    return target;
  }

  // All windows, or those of the faces in which targets lie.
  void choose_windows_to_keep(const ExactOptions<T>& options, Limits& limits) const {
    limits.keep_windows = options.keep_windows || limits.ring < unreachable<Real>;
    if (limits.keep_windows) return;
    for (const auto& target : options.targets) {
      keep_windows_at(detail::simplified(surface_, target.template cast<Real>()), limits);
    }
  }
  void keep_windows_at(const Point& p, Limits& limits) const {
    if (p.kind == Point::Kind::vertex) return;
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
void ExactSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query,
                                    const ExactOptions<T>& options) const {
  auto& [sources, starts, distance] = query;
  normalise(sources, starts);
  const Borrowed workspace(*pool_);
  Limits limits = limits_of(options, starts, std::move((*workspace).target_memory));
  run(*workspace, sources, limits);
  (*workspace).target_memory = std::move(limits.targets);
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
  Solution solution = empty_solution(options);
  solution.sources = std::move(sources);
  solution.fronts = std::move(fronts);
  solve_into(solution, options);
  return ExactField<T>(std::move(solution));
}

template <std::floating_point T>
void ExactSolver<T>::solve_into(Solution& solution, const ExactOptions<T>& options) const {
  normalise(solution.sources, solution.starts);
  for (auto& front : solution.fronts) {
    front.start -= solution.starts.at(surface_.face(front.face)[0]);
  }
  Limits limits = limits_of(options, solution.starts);
  choose_windows_to_keep(options, limits);
  limits.fronts = solution.fronts;
  limits.size = solution.fronts.empty() ? 0 : detail::size_of(surface_);
  const Borrowed workspace(*pool_);
  run(*workspace, solution.sources, limits);
  solution.adopt(*workspace);
  solution.bends_anywhere = limits.ring < unreachable<Real>;
  solution.kept_faces = limits.keep_windows ? detail::Array<char>{} : limits.faces_to_keep;
}

template <std::floating_point T>
auto ExactSolver<T>::path_within(const Point& from, const Point& to, Real longest) const
    -> std::vector<Point> {
  Solution solution = empty_solution(options_);
  solution.sources = {{from, 0}};
  Limits limits;
  limits.distance = longest;
  limits.goal = &to;
  limits.cancelled = options_.cancelled;
  limits.memory = options_.max_memory;
  limits.keep_windows = true;
  limits.targets.push_back(target_at(to));
  const Borrowed workspace(*pool_);
  run(*workspace, solution.sources, limits);
  solution.bound = (*workspace).bound();
  const auto windows = std::make_shared<detail::WindowStore<Real>>();
  solution.windows = windows;
  solution.exchange(*workspace, *windows);
  const auto end = detail::PointQuery<Real>(solution).nearest(to);
  detail::Array<Point> path = detail::PathBacktrace<Real>(solution).back(end);
  std::reverse(path.begin(), path.end());
  solution.exchange(*workspace, *windows);
  return path;
}

template <TriangleMesh M>
explicit ExactSolver(const M&) -> ExactSolver<MeshScalar<M>>;
template <TriangleMesh M>
ExactSolver(const M&, ExactOptions<MeshScalar<M>>) -> ExactSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class ExactSolver<float>;
GELIGHT_ONCE template class ExactField<float>;
GELIGHT_ONCE template class detail::DistanceQueries<ExactSolver<float>, float>;
GELIGHT_ONCE template class ExactSolver<double>;
GELIGHT_ONCE template class ExactField<double>;
GELIGHT_ONCE template class detail::DistanceQueries<ExactSolver<double>, double>;
}  // namespace gelight
#endif
