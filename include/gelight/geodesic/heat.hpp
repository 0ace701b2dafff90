#pragma once

#include <concepts>
#include <initializer_list>
#include <memory>
#include <span>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// What heat does at a surface's border: it is held back, let out, or the mean of both, which bends
/// the isolines least.
enum class HeatBoundary { neumann, dirichlet, averaged };

struct HeatOptions {
  /// Time of the heat flow, in squared mean edge lengths. More smooths the distance, less makes it
  /// follow the mesh's edges.
  double time_factor = 1;
  /// On a border vertex, and where a face has no vertex off the border, always neumann.
  HeatBoundary boundary = HeatBoundary::neumann;
  /// Within this many mean edge lengths of the sources the distance is exact (as ExactSolver's),
  /// and the heat continues it, which removes the error beside the source. 0 leaves heat alone.
  double exact_radius = 3;
  /// How often the unit field is taken anew from the distance found, for one more solve each:
  /// the first takes the mean error from 0.31 to 0.15 % on spheres, from 1.43 to 1.22 % on
  /// scan-like meshes. Where fronts meet, gradients stay as short as they are found.
  Index refinements = 0;
  /// Works on the intrinsic Delaunay triangulation of the same surface, on which thin triangles do
  /// no harm; false takes the mesh's own triangles. Mean errors on scan-like meshes, of all and of
  /// the worst source: 1.4 and 4.8 % with it, 5.8 and 58 % without, for 4 to 5 % more set-up.
  bool intrinsic_delaunay = true;
  /// What factors the matrices: gelight's own, or another library (`cholmod_backend` of
  /// mesh/cholmod.hpp).
  LinearBackend<double> backend = nullptr;
  /// Asked while the solver is set up, and in each query by the thread that makes it. A matrix'
  /// last blocks, and another library's solves, are each one step.
  CancelHook cancelled{};
};

namespace detail {
template <std::floating_point Real>
struct HeatSystem;
template <std::floating_point Real>
class HeatEngine;
}  // namespace detail

/// Distances by heat, and how far they are to be trusted.
template <std::floating_point T>
struct HeatResult {
  std::vector<T> distance;  ///< Of each vertex, +infinity where no path leads.
  /// Estimate of the mean of |distance / true distance - 1| over the vertices that are reached,
  /// both counted from the earliest source of their connected part: from up to 256 of them, paths
  /// are followed back through the distances and pulled taut, whose lengths do not depend on how
  /// long heat says they are. On scan_meshes(4), 30 sources each, none of the 98 answers off by
  /// more than a tenth that the meshes' own triangles give is missed; of 720 default answers, all
  /// off by less than a twentieth, none is flagged. With exact_radius = 0, 3 % of good answers are.
  double error = 0;
  /// Mean of | |gradient| - 1 |, by area, over the faces where heat decides: a distance has 0. It
  /// tells roughness and thin faces more than it tells errors.
  double residual = 0;
  /// The error is more than 0.07: distances may be off by more than a tenth on average. (Try a
  /// larger exact_radius, refinements, or another solver.)
  bool is_too_coarse = false;
  /// Some vertices are too far for the time of the flow: no heat arrived, however little. Their
  /// distances mean nothing. (Try a larger time_factor.)
  bool is_too_far = false;
  /// Neither of the two.
  bool is_reliable = true;
};

/// Distance by the heat method (Crane, Weischedel, Wardetzky 2013, doi:10.1145/2516971.2516977): a
/// smooth approximation by two sparse solves with matrices factored once.
///
/// Works on lengths alone: faces of any orientation, edges of any number of faces, faces without
/// area. Each connected part is on its own; one without a source is +infinity. Sources that start
/// at different distances cost a solve for each such distance.
///
/// Error, 30 sources each (benchmarks/heat_error_benchmark.cpp), mean and largest: icospheres of
/// 642 to 10,242 vertices 0.31 and 2.5 %, 0.15 and 2.0 % with one refinement, heat alone
/// (exact_radius = 0) 1.05 and 17 %; the rough, creased, bordered and thin meshes of
/// scan_meshes(4) 1.4 and 20 %, 1.2 and 17 %, 1.5 and 100 %. Where the fronts of several sources
/// meet, heat is off by a share of an edge, which counts for more where they are near: of 2 to 8 at
/// once 2.5 and 23 % on those icospheres, 3.3 and 50 % on the rough ones. (The least of
/// `distance_from_each` is as exact as one source alone, for a solve each.) Graded meshes are
/// worst, since the time is that of the mean edge: `solve` tells. Heat alone improves as spheres
/// are refined, with order 0.4 to 0.7: in a time of one squared edge heat never forgets the mesh.
/// Set-up takes about n^1.5, a query n log n; and what ExactSolver takes within the exact radius,
/// which is much where thousands of long faces meet at a vertex.
template <std::floating_point T>
class HeatSolver : public detail::DistanceQueries<HeatSolver<T>, T> {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does, and for a time factor that is not positive or so
  /// large that products with it are not finite, an exact radius or a number of refinements that is
  /// negative, a boundary that is none.
  template <TriangleMesh M>
  explicit HeatSolver(const M& mesh, const HeatOptions& options = {})
      : HeatSolver(Surface<Real>(mesh, options.cancelled.part(0, 0)), options, nullptr) {}

  /// Shares the factored systems of another solver of the same surface, where there is one; their
  /// time factor, triangulation and backend then hold instead of the options'. Throws InvalidInput
  /// for systems of any other surface.
  HeatSolver(Surface<Real> surface, const HeatOptions& options,
             std::shared_ptr<const detail::HeatSystem<Real>> system);

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const;

  /// The same distances as `distance` gives, with an estimate of their error and flags where they
  /// are not to be trusted, which `distance` alone does not tell. Some 5 to 13 % more work
  /// than `distance` at 10,000 vertices, several times that where the estimate is close to the
  /// limit. Throws InvalidInput as `distance` does.
  ///@{
  [[nodiscard]] HeatResult<T> solve(Index vertex) const {
    return solve(std::span<const Index>(&vertex, 1));
  }
  [[nodiscard]] HeatResult<T> solve(std::initializer_list<Index> vertices) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  template <detail::OtherIntegers NotOfIndex>
  [[nodiscard]] HeatResult<T> solve(const NotOfIndex& vertices) const = delete;
  [[nodiscard]] HeatResult<T> solve(const Source<T>& source) const {
    return solve(std::span<const Source<T>>(&source, 1));
  }
  [[nodiscard]] HeatResult<T> solve(const SurfacePoint<T>& point) const {
    return solve(std::span<const SurfacePoint<T>>(&point, 1));
  }
  [[nodiscard]] HeatResult<T> solve(std::span<const Index> vertices) const;
  [[nodiscard]] HeatResult<T> solve(std::span<const Source<T>> sources) const;
  [[nodiscard]] HeatResult<T> solve(std::span<const SurfacePoint<T>> points) const;
  // A template, so that braces with nothing in them stand for vertices.
  template <detail::PointOf<T> Point = Source<T>>
  [[nodiscard]] HeatResult<T> solve(std::initializer_list<Point> points) const {
    return solve(std::span<const Point>(points.begin(), points.size()));
  }
  ///@}

  /// Distances of all vertices from each of a few sources alone, bit for bit those of `distance`:
  /// eight at once read the factors once. `distance_rows` asks so. Throws InvalidInput as
  /// `distance` does.
  ///@{
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::span<const Index> vertices) const;
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::span<const Source<T>> sources) const;
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::span<const SurfacePoint<T>> points) const;
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::initializer_list<Index> vertices) const {
    return distance_from_each(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  template <detail::PointOf<T> Point = Source<T>>
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::initializer_list<Point> points) const {
    return distance_from_each(std::span<const Point>(points.begin(), points.size()));
  }
  ///@}

  /// The factored systems, for solvers that share them.
  [[nodiscard]] const std::shared_ptr<const detail::HeatSystem<Real>>& system() const;

 private:
  friend class detail::DistanceQueries<HeatSolver<T>, T>;
  template <std::floating_point>
  friend class VectorHeatSolver;
  using Engine = detail::HeatEngine<Real>;

  void solve_vertices(detail::DistanceQuery<Real>& query) const;
  template <class Place>
  [[nodiscard]] std::vector<std::vector<T>> solve_each(std::span<const Place> places) const;

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit HeatSolver(const M&) -> HeatSolver<MeshScalar<M>>;
template <TriangleMesh M>
HeatSolver(const M&, const HeatOptions&) -> HeatSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<HeatSolver<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<HeatSolver<double>, double>;
}  // namespace gelight
#endif
#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/heat/body.hpp"
#endif
