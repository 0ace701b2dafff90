#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
class PathSolver;
template <std::floating_point T>
class GrowingDistances;
template <std::floating_point T>
class ExactField;

namespace detail {
template <std::floating_point Real>
struct WindowSolution;
template <std::floating_point T>
class ExactQueries;
template <std::floating_point T>
class ExactEngine;
template <std::floating_point T>
class SmoothEngine;
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
  Vec3<T> direction;  ///< Unit tangent in the direction of travel; zero where the path begins
                      ///< with a piece of no length, between vertices at one place.
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
  [[nodiscard]] T distance(Index vertex) const;
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
  /// From segments come those lines that leave them at no less than a right angle; since distances
  /// from them are off by 4e-9 of the mesh's size, ties take a tolerance of as much.
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
  friend class detail::SmoothEngine;
  template <std::floating_point U>
  friend auto detail::solution_of(const ExactField<U>& field)
      -> const detail::WindowSolution<typename detail::WorkingPrecision<U>::Real>&;
  using Solution = detail::WindowSolution<typename detail::WorkingPrecision<T>::Real>;
  using Queries = detail::ExactQueries<T>;

  // Rounding of the unfolded images, with room: paths that differ by less are equally short.
  static constexpr T default_tolerance = std::max(T(1e-12), 16 * std::numeric_limits<T>::epsilon());

  explicit ExactField(std::shared_ptr<const Solution> solution) : solution_(std::move(solution)) {}

  std::shared_ptr<const Solution> solution_;
};

namespace detail {
/// What the solve behind a field found.
template <std::floating_point T>
[[nodiscard]] auto solution_of(const ExactField<T>& field)
    -> const WindowSolution<typename WorkingPrecision<T>::Real>& {
  return *field.solution_;
}
}  // namespace detail

/// Exact geodesic distance on a triangle mesh: the length of the shortest path over its faces.
///
/// Constructed once from a mesh, in O(vertices + faces log valence); queries are const and safe
/// from several threads, and memory is used again. A mesh may have borders, any genus, several
/// components, edges of three faces or more (paths turn into each of them), vertices where several
/// fans meet (paths pass through), flipped faces, zero-length edges and zero-area faces.
///
/// Exact up to rounding: some 1e-15 relative, times the aspect ratio of needles; on a mesh with
/// zero-area faces vertices may be 1e-13 of the way and an edge too far; at any distance
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
      : engine_(new_engine(Surface<double>(mesh, options.cancelled.part(0, 0)), options)) {}

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const;

  /// Solves from a vertex or another point, from several of either, or from points with start
  /// distances. Throws InvalidInput for no source, a source that is not of the mesh or starts
  /// with a distance that is not finite, and for options that do not fit the mesh; Cancelled where
  /// the options' hook says so, MemoryLimit where windows take more than the options allow. The
  /// solver can be used again after each.
  ///@{
  [[nodiscard]] ExactField<T> solve(Index vertex) const { return solve(vertex, options()); }
  [[nodiscard]] ExactField<T> solve(Index vertex, const ExactOptions<T>& options) const {
    return solve(std::span<const Index>(&vertex, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(const SurfacePoint<T>& point) const {
    return solve(point, options());
  }
  [[nodiscard]] ExactField<T> solve(const SurfacePoint<T>& point,
                                    const ExactOptions<T>& options) const {
    return solve(std::span<const SurfacePoint<T>>(&point, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(const Source<T>& source) const {
    return solve(source, options());
  }
  [[nodiscard]] ExactField<T> solve(const Source<T>& source, const ExactOptions<T>& options) const {
    return solve(std::span<const Source<T>>(&source, 1), options);
  }
  [[nodiscard]] ExactField<T> solve(std::initializer_list<Index> vertices) const {
    return solve(vertices, options());
  }
  [[nodiscard]] ExactField<T> solve(std::initializer_list<Index> vertices,
                                    const ExactOptions<T>& options) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()), options);
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Index> vertices) const {
    return solve(vertices, options());
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Index> vertices,
                                    const ExactOptions<T>& options) const;
  template <detail::OtherIntegers NotOfIndex>
  [[nodiscard]] ExactField<T> solve(const NotOfIndex& vertices) const = delete;
  [[nodiscard]] ExactField<T> solve(std::span<const Source<T>> sources) const {
    return solve(sources, options());
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Source<T>> sources,
                                    const ExactOptions<T>& options) const;
  [[nodiscard]] ExactField<T> solve(std::span<const SurfacePoint<T>> points) const {
    return solve(points, options());
  }
  [[nodiscard]] ExactField<T> solve(std::span<const SurfacePoint<T>> points,
                                    const ExactOptions<T>& options) const;
  // Templates, so that braces with nothing in them stand for vertices.
  template <detail::PointOf<T> Point = Source<T>>
  [[nodiscard]] ExactField<T> solve(std::initializer_list<Point> points) const {
    return solve(points, options());
  }
  template <detail::PointOf<T> Point = Source<T>>
  [[nodiscard]] ExactField<T> solve(std::initializer_list<Point> points,
                                    const ExactOptions<T>& options) const {
    return solve(std::span<const Point>(points.begin(), points.size()), options);
  }
  ///@}

  /// Distances from the nearest points of segments: of curves, as chains of them. They are those of
  /// straight lines at a right angle to a segment, but for 4e-9 of the mesh's size. Paths and
  /// directions begin at the nearest point. Throws InvalidInput as above, for no segment and for
  /// one whose ends no face holds both.
  ///@{
  [[nodiscard]] ExactField<T> solve(std::span<const Segment<T>> segments) const {
    return solve(segments, options());
  }
  [[nodiscard]] ExactField<T> solve(std::span<const Segment<T>> segments,
                                    const ExactOptions<T>& options) const;
  [[nodiscard]] std::vector<T> distance(std::span<const Segment<T>> segments) const;
  using detail::DistanceQueries<ExactSolver<T>, T>::distance;
  ///@}

  /// `distance_into` by other options than the solver's. Throws InvalidInput as `solve` does.
  void distance_into(std::span<T> out, std::span<const Source<T>> sources,
                     const ExactOptions<T>& options) const;
  using detail::DistanceQueries<ExactSolver<T>, T>::distance_into;

 private:
  friend class detail::DistanceQueries<ExactSolver<T>, T>;
  template <std::floating_point>
  friend class PathSolver;
  template <std::floating_point>
  friend class GrowingDistances;
  template <std::floating_point>
  friend class detail::SmoothEngine;
  using Engine = detail::ExactEngine<T>;

  [[nodiscard]] static std::shared_ptr<const Engine> new_engine(Surface<double> surface,
                                                                const ExactOptions<T>& options);

  [[nodiscard]] const ExactOptions<T>& options() const;
  void solve_vertices(detail::DistanceQuery<double>& query) const;

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit ExactSolver(const M&) -> ExactSolver<MeshScalar<M>>;
template <TriangleMesh M>
ExactSolver(const M&, ExactOptions<MeshScalar<M>>) -> ExactSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<ExactSolver<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<ExactSolver<double>, double>;
}  // namespace gelight
#endif
#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/exact/body.hpp"
#endif
