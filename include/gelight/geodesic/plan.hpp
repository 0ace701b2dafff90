#pragma once

#include <concepts>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/plan_costs.hpp"
#include "gelight/geodesic/planning/measured_costs.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {
template <std::floating_point T>
class PlanEngine;
}  // namespace detail

/// Which error is meant: the mean or the largest over the vertices, as a share of the distance
/// counted from the earliest start distance in the connected part, where that is not zero. So
/// nothing changes where all start distances grow by the same.
enum class ErrorNorm {
  mean,  ///< The mean.
  max    ///< The largest.
};

/// What the distances are compared with: the mesh as it is, or the smooth surface it stands for.
enum class DistanceTruth {
  polyhedral,  ///< The mesh.
  smooth       ///< The surface that it approximates.
};

/// How an error is known; each promises more than the one before.
enum class Assurance {
  /// From experience with such meshes, or the lengths of some paths. Nothing was checked exactly.
  expected,
  /// So many targets' distances were computed exactly besides, all where there are fewer. Targets
  /// that are sources or out of reach are none. That tells of a mean error; of the largest one only
  /// where all targets were checked, or the distances are exact.
  sampled,
  /// Proved by bounds on the exact distance at every vertex, or target, for the very numbers that
  /// are returned.
  certified
};

/// A method of the caller's own for DistancePlanner to choose from.
struct PlanMethod {
  /// Distance of every vertex from the nearest of points with start distances.
  using Query = std::function<std::vector<double>(std::span<const Source<double>>)>;

  std::string name;     ///< What plans and answers call it.
  MethodCost cost;      ///< As measured on the machine of the request's costs.
  RelativeError error;  ///< What it is off at most from one source, on meshes as the planned one.
  /// Sets the method up. What it returns is const and safe from several threads. Distances are
  /// refused that are negative or NaN, or not one per vertex; of wrong ones that are none of these
  /// a plan finds what the assurance asked for would show, zeros, sources at a distance and
  /// vertices out of reach.
  std::function<Query(const Surface<double>&)> make;
};

/// What a caller wants of distances, and what they may cost.
struct PlanRequest {
  /// Largest relative error allowed, in the norm below; +infinity allows any that has a bound.
  double tolerance = 0.01;
  ErrorNorm norm = ErrorNorm::mean;                 ///< Which error the tolerance is for.
  DistanceTruth truth = DistanceTruth::polyhedral;  ///< What the distances are compared with.
  Assurance assurance = Assurance::certified;       ///< How the error shall be known, at least.
  Index sources = 1;                                ///< How many queries will share the set-up.
  Index samples = 4;  ///< Targets to check exactly where the assurance is sampled, or all.
  /// Where not empty, only these vertices' distances matter; others may be reported as +infinity.
  std::vector<Index> targets{};
  double time_limit = unreachable<double>;    ///< Seconds for all queries, as estimated.
  double memory_limit = unreachable<double>;  ///< Bytes beyond the mesh, as estimated.
  /// By how much the machine is slower than the one of the estimates (benchmarks/results).
  double slowness = 1;
  /// What the methods cost; measured_plan_costs() measures the machine that runs it.
  PlanCosts costs = detail::measured_costs;
  std::vector<PlanMethod> methods{};  ///< Others to choose from.
  /// Asked now and then during a query, by its thread; where it answers true, that ends with
  /// Cancelled.
  CancelHook cancelled{};
};

/// What was chosen, and why.
struct DistancePlan {
  std::string method;  ///< The solver: dijkstra, fast_marching, virtual_source, exact, smooth
                       ///< or one of the caller's own.
  bool expected_to_satisfy = true;  ///< Whether tolerance, assurance and limits can all be met.
  /// In the norm and against the truth asked for, from one source; with what rounding to the
  /// caller's type takes. Where it is more than the tolerance though that is expected to be
  /// satisfied, experience says too little: the method is tried first. A guess where `unfamiliar`.
  double expected_error = 0;
  /// What of the mesh is beyond the experience that `expected_error` is, in words; empty where the
  /// mesh is familiar. Nothing rests on expectation alone then.
  std::string unfamiliar;
  double seconds = 0;  ///< Estimate for all queries, with checks.
  double bytes = 0;    ///< Estimate beyond the mesh.
  /// Where the smooth surface is meant and the mesh is too coarse for the tolerance, even for
  /// SmoothDistanceSolver: the mean edge length that would do, in the unit of the positions. 0
  /// otherwise.
  double refine_to = 0;
  std::string reason;  ///< The choice in words.
};

/// Distances with what is known about them.
template <std::floating_point T>
struct PlannedDistances {
  std::vector<T> distance;  ///< Of each vertex, +infinity where no path leads.
  std::string method;       ///< The one whose distances these are, after any escalation.
  Assurance achieved = Assurance::expected;  ///< How the error is known.
  /// Of `distance` as it is, rounding included. Certified: a bound, in the norm asked for.
  /// Sampled: the largest of the targets that were checked, which may be beyond a tolerance of the
  /// mean where their mean is not. Else what is expected, in that norm.
  double error = 0;
  Index checked = 0;  ///< Targets whose exact distance was computed.
  /// Whether the error asked for keeps the tolerance, with the assurance asked for; exact distances
  /// that were sampled satisfy one who asked for a certificate, too.
  bool satisfies = false;
  std::string reason;  ///< What was done and found, in words.
};

/// Distances to a given error rather than by a given method: chooses the cheapest method expected
/// to satisfy a request, runs it, checks what it was asked to check, and where that fails escalates
/// to the cheapest method that is sure, in the end the exact one. Exact distances are sampled, not
/// certified.
///
/// What each promise means, for mean errors:
/// - expected: what experience says is within the tolerance (of fast marching: within a quarter),
///   the mesh is like those that it is of, and there is one source; or paths traced back through
///   the distances tell so, two and a half standard errors sure; or, where these would not tell, a
///   certificate.
/// - sampled: the same, and `samples` targets besides that were computed exactly and keep the
///   tolerance on average.
/// - certified: a proof at every vertex.
///
/// A largest error is not to be known from samples nor paths, since a single vertex may have it:
/// where that is asked for, distances are proved or exact, unless `samples` targets are all that
/// matter, or no more than an expectation is asked for on a familiar mesh from one source.
///
/// Not every promise need hold, least of all an expectation in float that rounding alone nearly
/// takes. Of 3,000 requests at random, half of them in float, for meshes of all kinds of
/// tests/support/plan_requests.hpp, with tolerances down to 1e-12 and start distances of both
/// signs, against ExactSolver<double>, all held that were said to be satisfied: 133 certified,
/// 1,364 sampled, 1,240 expected, 668 of them by an approximate method (benchmarks/claims.cpp).
///
/// What a method is expected to be off is for the worst source of the mesh, since the planner
/// chooses before it knows any, and meshes that look alike differ tenfold. So where fast
/// marching may or may not keep a mean error it is tried: paths tell how far it is off, for
/// about a tenth of what it costs. A certificate that is in doubt is tried too, and given up as
/// soon as its lower bounds show that it fails: that costs about a quarter of an exact solve.
///
/// Against the smooth surface nothing can be checked: the error of the mesh itself is taken for
/// 0.3 times the mean squared angle between faces, which is 0.10 (kappa h)^2 on a sphere of
/// curvature kappa and edges h, and the assurance is never more than expected. Where it exceeds
/// the tolerance, SmoothDistanceSolver is chosen, whose error is taken for a 25th of that (the
/// largest: an 8th), and where the surface is rough for all of it; and where that exceeds the
/// tolerance the plan says to what edge length to refine.
///
/// HeatSolver is not among the methods: on every mesh of benchmarks/results, and on spheres of
/// 163,842 vertices, fast marching takes about as long for a further source, a tenth to a fifth
/// of the set-up, and is more accurate by a factor of two to a thousand than HeatSolver as it
/// comes.
///
/// Construction is linear in the mesh; solvers are made when first needed. Queries are const
/// and safe from several threads.
template <std::floating_point T>
class DistancePlanner : public detail::DistanceQueries<DistancePlanner<T>, T> {
 public:
  /// Throws InvalidInput as Surface does, for a tolerance that is not positive, fewer than one
  /// source or sample, a limit or slowness that is not positive, a slowness that is not finite, a
  /// norm, truth or assurance that is none, a target out of range, a cost or error that is negative
  /// or NaN, a method that has no name or that nothing makes.
  template <TriangleMesh M>
  explicit DistancePlanner(const M& mesh, PlanRequest request = {})
      : engine_(new_engine(Surface<double>(mesh, request.cancelled.part(0, 0)), request)) {}

  /// What was chosen for the request, and why.
  [[nodiscard]] const DistancePlan& plan() const;

  /// Distances of all vertices from a vertex, several, or points with start distances, and how
  /// far they are to be trusted (`distance` gives the distances alone). Throws InvalidInput as a
  /// solver does, Cancelled where the request's hook says so.
  ///@{
  [[nodiscard]] PlannedDistances<T> solve(Index vertex) const {
    return solve(std::span<const Index>(&vertex, 1));
  }
  [[nodiscard]] PlannedDistances<T> solve(std::initializer_list<Index> vertices) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  template <detail::OtherIntegers NotOfIndex>
  [[nodiscard]] PlannedDistances<T> solve(const NotOfIndex& vertices) const = delete;
  [[nodiscard]] PlannedDistances<T> solve(const Source<T>& source) const {
    return solve(std::span<const Source<T>>(&source, 1));
  }
  [[nodiscard]] PlannedDistances<T> solve(const SurfacePoint<T>& point) const {
    return solve(std::span<const SurfacePoint<T>>(&point, 1));
  }
  [[nodiscard]] PlannedDistances<T> solve(std::span<const Index> vertices) const;
  [[nodiscard]] PlannedDistances<T> solve(std::span<const Source<T>> sources) const;
  [[nodiscard]] PlannedDistances<T> solve(std::span<const SurfacePoint<T>> points) const;
  // A template, so that braces with nothing in them stand for vertices.
  template <detail::PointOf<T> Point = Source<T>>
  [[nodiscard]] PlannedDistances<T> solve(std::initializer_list<Point> points) const {
    return solve(std::span<const Point>(points.begin(), points.size()));
  }
  ///@}

  /// The mesh's surface.
  [[nodiscard]] const Surface<double>& surface() const;

 private:
  friend class detail::DistanceQueries<DistancePlanner<T>, T>;
  using Engine = detail::PlanEngine<T>;

  [[nodiscard]] static std::shared_ptr<const Engine> new_engine(Surface<double> surface,
                                                                const PlanRequest& request);
  void solve_vertices(detail::DistanceQuery<double>& query) const;

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit DistancePlanner(const M&) -> DistancePlanner<MeshScalar<M>>;
template <TriangleMesh M>
DistancePlanner(const M&, PlanRequest) -> DistancePlanner<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<DistancePlanner<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<DistancePlanner<double>, double>;
}  // namespace gelight
#endif
#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/plan/body.hpp"
#endif
