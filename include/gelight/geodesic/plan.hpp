#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/late.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/detail/mesh_statistics.hpp"
#include "gelight/geodesic/detail/method_models.hpp"
#include "gelight/geodesic/detail/target_search.hpp"
#include "gelight/geodesic/detail/traced_error.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// Which error is meant: the mean or the largest over the vertices, as a share of the distance.
enum class ErrorNorm {
  mean,  ///< The mean.
  max    ///< The largest.
};

/// What the distances are compared with: the mesh as it is, or the smooth surface it stands for.
enum class DistanceTruth {
  polyhedral,  ///< The mesh.
  smooth       ///< The surface that it approximates.
};

/// How an error is known: from experience with such meshes, or the lengths of some paths; from
/// targets whose exact distance was computed; by bounds that were proved at every vertex.
enum class Assurance {
  expected,  ///< Experience; nothing was checked exactly.
  sampled,   ///< Checked exactly at some targets.
  certified  ///< Proved at every vertex, or target.
};

/// What a caller wants of distances, and what they may cost.
struct PlanRequest {
  double tolerance = 0.01;           ///< Largest relative error allowed, in the norm below.
  ErrorNorm norm = ErrorNorm::mean;  ///< Which error the tolerance is for.
  DistanceTruth truth = DistanceTruth::polyhedral;  ///< What the distances are compared with.
  Assurance assurance = Assurance::certified;       ///< How the error shall be known, at least.
  Index sources = 1;                                ///< How many queries will share the set-up.
  Index samples = 4;  ///< Targets to check where the assurance is sampled.
  /// Where not empty, only these vertices' distances matter; others may be reported as +infinity.
  std::vector<Index> targets{};
  double time_limit = unreachable<double>;    ///< Seconds for all queries, as estimated.
  double memory_limit = unreachable<double>;  ///< Bytes beyond the mesh, as estimated.
  /// By how much the machine is slower than the one of the estimates (benchmarks/results).
  double slowness = 1;
};

/// What was chosen, and why.
struct DistancePlan {
  std::string method;  ///< The solver: dijkstra, fast_marching, virtual_source or exact.
  bool expected_to_satisfy = true;  ///< Whether tolerance, assurance and limits can all be met.
  /// In the norm and against the truth asked for. Where it is more than the tolerance though that
  /// is expected to be satisfied, experience says too little: the method is tried first.
  double expected_error = 0;
  double seconds = 0;  ///< Estimate for all queries, with checks.
  double bytes = 0;    ///< Estimate beyond the mesh.
  /// Where the smooth surface is meant and the mesh is too coarse for the tolerance: the mean edge
  /// length that would do, in the unit of the positions. 0 otherwise.
  double refine_to = 0;
  std::string reason;  ///< The choice in words.
};

/// Distances with what is known about them.
template <std::floating_point T>
struct PlannedDistances {
  std::vector<T> distances;  ///< Of each vertex, +infinity where no path leads.
  std::string method;        ///< The one whose distances these are, after any escalation.
  Assurance achieved = Assurance::expected;  ///< How the error is known.
  double error = 0;   ///< In the norm asked for; certified: a bound; sampled: the largest seen.
  Index checked = 0;  ///< Targets whose exact distance was computed.
  /// Whether the error meets the tolerance, with the assurance asked for; exact distances that were
  /// sampled satisfy one who asked for a certificate, too.
  bool satisfies = false;
  std::string reason;  ///< What was done and found, in words.
};

namespace detail {

/// Solvers of a mesh, made when they are first needed.
template <std::floating_point Real>
class PlannedSolvers {
 public:
  PlannedSolvers(const Surface<Real>& surface, const std::vector<Index>& targets)
      : surface_(surface) {
    for (const Index v : targets) options_.targets.push_back(vertex_point<Real>(v));
  }

  [[nodiscard]] std::vector<Real> distance(Method method, const Sources& sources) const {
    const std::span<const Source<Real>> from(sources);
    switch (method) {
      case Method::dijkstra:
        return dijkstra_.get([&] { return DijkstraSolver<Real>(surface_); }).distance(from);
      case Method::virtual_source:
        return virtual_source_.get([&] { return VirtualSourceSolver<Real>(surface_); })
            .distance(from);
      case Method::fast_marching:
        return fast_marching_.get([&] { return FastMarchingSolver<Real>(surface_); })
            .distance(from);
      default:
        return exact_.get([&] { return ExactSolver<Real>(surface_, options_); }).distance(from);
    }
  }

  [[nodiscard]] const PlanarFacesOf<Real>& faces() const {
    return faces_.get([&] { return PlanarFacesOf<Real>(surface_); });
  }

 private:
  Surface<Real> surface_;
  ExactOptions<Real> options_;
  Late<DijkstraSolver<Real>> dijkstra_;
  Late<VirtualSourceSolver<Real>> virtual_source_;
  Late<FastMarchingSolver<Real>> fast_marching_;
  Late<ExactSolver<Real>> exact_;
  Late<PlanarFacesOf<Real>> faces_;
};

}  // namespace detail

/// Distances to a given error rather than by a given method: chooses the cheapest method expected
/// to satisfy a request, runs it, checks what it was asked to check, and escalates to the exact
/// solver where that fails. What it reports as certified was proved for every vertex (or target) of
/// that very answer, as Certifier does; as sampled, computed exactly for so many targets; all else
/// is expected, which is no more than experience. Exact distances are sampled, not certified.
///
/// What a method is expected to be off is for the worst source of the mesh, since the planner
/// chooses before it knows any, and meshes that look alike differ tenfold. So where fast marching
/// may or may not keep a mean error it is tried: paths traced back through its distances tell how
/// far these are off, for about a tenth of what they cost. A certificate that is in doubt is tried
/// too, and given up as soon as its lower bounds show that it fails: that costs about a quarter of
/// an exact solve.
///
/// Against the smooth surface nothing can be checked: the error of the mesh itself is taken for 0.3
/// times the mean squared angle between faces, which is 0.10 (kappa h)^2 on a sphere of curvature
/// kappa and edges h, and the assurance is never more than expected. Where it exceeds the tolerance
/// the plan says to what edge length to refine.
///
/// HeatSolver is not among the methods: on every mesh of benchmarks/results, and on spheres of
/// 163,842 vertices, fast marching takes about as long for a further source, a tenth to a fifth of
/// the set-up, and is more accurate by a factor of two to a thousand than HeatSolver as it comes.
///
/// Construction is linear in the mesh; solvers are made when first needed. Queries are const and
/// safe from several threads.
template <std::floating_point T>
class DistancePlanner {
 public:
  /// Throws InvalidInput as Surface does, for a tolerance that is not positive, fewer than one
  /// source or sample, a limit or slowness that is not positive, a target out of range.
  template <TriangleMesh M>
  explicit DistancePlanner(const M& mesh, PlanRequest request = {})
      : surface_(mesh), request_(std::move(request)), statistics_(surface_) {
    require_request();
    solvers_ = std::make_shared<const Solvers>(surface_, request_.targets);
    choose();
  }

  /// What was chosen for the request, and why.
  [[nodiscard]] const DistancePlan& plan() const { return plan_; }

  /// Distances of all vertices from a vertex, several, or points with start distances. Throws
  /// InvalidInput as a solver does.
  ///@{
  [[nodiscard]] PlannedDistances<T> distance(Index vertex) const {
    return distance(std::span<const Index>(&vertex, 1));
  }
  [[nodiscard]] PlannedDistances<T> distance(std::span<const Index> vertices) const {
    return run(detail::checked_sources(surface_, vertices));
  }
  [[nodiscard]] PlannedDistances<T> distance(std::span<const Source<T>> sources) const {
    return run(detail::checked_sources(surface_, sources));
  }
  ///@}

 private:
  using Method = detail::Method;
  using Real = std::common_type_t<T, double>;  // double; by T, so that nothing is compiled unused
  using Solvers = detail::PlannedSolvers<Real>;
  // How far beyond the given distance a target is searched for: in tolerances, and as a share; and
  // beyond one that should be exact.
  static constexpr double search_width = 4, widest_search = 0.05, exact_search = 1e-9;
  // A certificate is tried where about so many tolerances should be provable.
  static constexpr double worth_trying = 1.5;
  // Where fast marching is expected to be off by more than this share of the mean error allowed,
  // paths tell: few at first, more until they are so many standard errors sure. Of 2,124 fields on
  // 354 meshes one was off by more than four times what was expected; and about `failing` times
  // what is expected over what is allowed were beyond that.
  static constexpr double doubtful = 0.25, failing = 0.1, sureness = 2.5;
  static constexpr Index few_paths = 64, many_paths = 256;

  void require_request() const {
    const PlanRequest& r = request_;
    detail::require(r.tolerance > 0, "the tolerance is ", r.tolerance, ", not positive");
    detail::require(r.sources > 0, "the number of sources is ", r.sources, ", less than 1");
    detail::require(r.samples > 0, "the number of samples is ", r.samples, ", less than 1");
    detail::require(r.time_limit > 0 && r.memory_limit > 0 && r.slowness > 0, "the limits ",
                    r.time_limit, " s, ", r.memory_limit, " bytes and the slowness ", r.slowness,
                    " are not all positive");
    for (const Index v : r.targets) surface_.require_vertex(v);
  }

  // --- choosing ----------------------------------------------------------------------------------

  [[nodiscard]] double in_norm(const RelativeError& error) const {
    return request_.norm == ErrorNorm::mean ? error.mean : error.max;
  }
  // Of the mesh against the smooth surface; its largest error is some three times the mean.
  [[nodiscard]] double floor() const {
    if (request_.truth == DistanceTruth::polyhedral) return 0;
    const double mean = 0.3 * statistics_.turn * statistics_.turn;
    return request_.norm == ErrorNorm::mean ? mean : 3 * mean;
  }
  // What is left of the tolerance for the method. A mesh too coarse leaves none; then an error as
  // small as its own is enough.
  [[nodiscard]] double share_of_method() const {
    return floor() < request_.tolerance ? request_.tolerance - floor() : floor();
  }
  [[nodiscard]] Assurance asked() const {
    return request_.truth == DistanceTruth::smooth ? Assurance::expected : request_.assurance;
  }

  [[nodiscard]] double expected_error(Method method) const {
    return in_norm(detail::MethodErrors(statistics_).of(method));
  }
  [[nodiscard]] double provable(Method method) const {
    return in_norm(detail::MethodErrors(statistics_).provable(method));
  }
  // Exact distances need none: where one reaches the tolerance, it does so for others too.
  [[nodiscard]] bool needs_certificate(Method method) const {
    return asked() == Assurance::certified && method != Method::exact;
  }
  [[nodiscard]] bool needs_samples(Method method) const {
    return asked() != Assurance::expected && !needs_certificate(method);
  }
  [[nodiscard]] bool needs_paths(Method method) const {
    return method == Method::fast_marching && request_.norm == ErrorNorm::mean &&
           !needs_certificate(method) && expected_error(method) > doubtful * share_of_method();
  }
  [[nodiscard]] double seconds(const detail::MethodCost& cost) const {
    return request_.slowness * cost.seconds(surface_.vertex_count(), request_.sources);
  }
  // With what it costs on average that the exact solver has to be called where paths tell so.
  [[nodiscard]] double seconds_with_checks(Method method) const {
    double sum = seconds(detail::cost_of(method));
    if (needs_certificate(method)) sum += seconds(detail::certificate_cost);
    if (needs_paths(method)) {
      const double share = failing * expected_error(method) / share_of_method();
      sum += seconds(detail::paths_cost);
      sum += std::min(1.0, share) * seconds(detail::cost_of(Method::exact));
    }
    if (needs_samples(method)) {
      sum += request_.samples * detail::sample_share * seconds(detail::cost_of(Method::exact));
    }
    return sum;
  }
  [[nodiscard]] double bytes(Method method) const {
    const double checks = needs_certificate(method) ? detail::certificate_cost.bytes : 0;
    return surface_.vertex_count() * std::max(detail::cost_of(method).bytes, checks);
  }

  [[nodiscard]] bool satisfies(Method method) const {
    if (expected_error(method) > share_of_method()) {
      return needs_paths(method) && floor() < request_.tolerance && within_limits(Method::exact);
    }
    return !needs_certificate(method) || provable(method) <= worth_trying * share_of_method();
  }
  [[nodiscard]] bool within_limits(Method method) const {
    return seconds_with_checks(method) <= request_.time_limit &&
           bytes(method) <= request_.memory_limit;
  }

  // The cheapest of the methods that satisfy and keep the limits; else, of those that keep the
  // limits, the most accurate; else the one that takes least memory.
  void choose() {
    std::optional<Method> cheapest, best;
    Method smallest = Method::dijkstra;
    for (const Method method : detail::all_methods) {
      if (bytes(method) < bytes(smallest)) smallest = method;
      if (!within_limits(method)) continue;
      if (satisfies(method) &&
          (!cheapest || seconds_with_checks(method) < seconds_with_checks(*cheapest))) {
        cheapest = method;
      }
      if (!best || expected_error(method) < expected_error(*best)) best = method;
    }
    chosen_ = cheapest ? *cheapest : best ? *best : smallest;
    plan_.method = detail::cost_of(chosen_).name;
    plan_.expected_to_satisfy = cheapest.has_value() && floor() < request_.tolerance;
    plan_.expected_error = expected_error(chosen_) + floor();
    plan_.seconds = seconds_with_checks(chosen_);
    plan_.bytes = bytes(chosen_);
    if (floor() >= request_.tolerance) {
      plan_.refine_to = statistics_.mean_edge * std::sqrt(request_.tolerance / (2 * floor()));
    }
    plan_.reason = reason(cheapest.has_value(), best.has_value());
  }

  [[nodiscard]] std::string reason(bool has_satisfying, bool within_limits) const {
    std::ostringstream text;
    text.precision(2);
    if (plan_.refine_to > 0) {
      text << "refine to edges of " << plan_.refine_to << ": the mesh itself is off the smooth "
           << "surface by about " << floor() << ", more than the tolerance " << request_.tolerance
           << "; until then finer methods are false precision. ";
    }
    text << plan_.method << ": ";
    if (has_satisfying && expected_error(chosen_) > share_of_method()) {
      text << "tried first, since it is cheap; its expected " << norm() << " error, "
           << plan_.expected_error << ", is beyond " << request_.tolerance
           << ", but paths will tell what it is";
    } else if (has_satisfying) {
      text << "the cheapest whose expected " << norm() << " error, " << plan_.expected_error
           << ", is within " << request_.tolerance;
    } else if (within_limits) {
      text << "the most accurate within the limits; its expected " << norm() << " error is "
           << plan_.expected_error;
    } else {
      text << "no method keeps the limits; this one needs the least memory";
    }
    if (needs_certificate(chosen_)) {
      text << "; of that " << provable(chosen_) << " should be provable";
    } else if (asked() == Assurance::certified) {
      text << "; bounds as close cannot be expected, so targets are checked exactly instead";
    }
    return text.str();
  }

  // --- running -----------------------------------------------------------------------------------

  [[nodiscard]] PlannedDistances<T> run(const detail::Sources& sources) const {
    PlannedDistances<T> result = attempt(chosen_, sources);
    if (result.satisfies || !may_escalate()) return result;
    PlannedDistances<T> exact = attempt(Method::exact, sources);
    exact.reason = result.reason + "; escalated: " + exact.reason;
    return exact;
  }
  [[nodiscard]] bool may_escalate() const {
    return chosen_ != Method::exact && plan_.expected_to_satisfy && within_limits(Method::exact);
  }

  /// How an answer's error is known, what it is, how many targets were checked for it, in words.
  struct Finding {
    Assurance achieved;
    double error;
    Index checked;
    std::string words;
  };

  [[nodiscard]] PlannedDistances<T> attempt(Method method, const detail::Sources& sources) const {
    const std::vector<double> distances = solvers_->distance(method, sources);
    const Finding found = find_error(method, sources, distances);
    PlannedDistances<T> result;
    result.method = detail::cost_of(method).name;
    result.distances.assign(distances.begin(), distances.end());
    result.achieved = found.achieved;
    result.error = found.error;
    result.checked = found.checked;
    result.satisfies = result.error <= request_.tolerance && result.achieved >= least(method);
    result.reason = result.method + ": " + found.words;
    return result;
  }

  // Exact distances are not known better by a certificate than they are: samples are enough.
  [[nodiscard]] Assurance least(Method method) const {
    return method == Method::exact ? std::min(asked(), Assurance::sampled) : asked();
  }

  [[nodiscard]] Finding find_error(Method method, const detail::Sources& sources,
                                   const std::vector<double>& distances) const {
    if (needs_certificate(method)) return certify(sources, distances);
    if (needs_paths(method)) {
      Finding traced = trace(sources, distances);
      const bool is_beyond = traced.error > request_.tolerance;
      if (!needs_samples(method) || (is_beyond && may_escalate())) return traced;
    }
    if (needs_samples(method)) {
      const double width = std::min(widest_search, search_width * request_.tolerance);
      return sample(sources, distances, method == Method::exact ? exact_search : width);
    }
    const double error = expected_error(method) + floor();
    return {Assurance::expected, error, 0,
            "expected to be within " + in_words(error) + ", not checked"};
  }

  // As Certifier, but lower bounds first: upper ones are needed only where those are enough.
  [[nodiscard]] Finding certify(detail::Sources sources, const std::vector<double>& given) const {
    const double start = detail::move_to_zero(sources);
    const detail::BoundFinder<Real> finder(surface_, solvers_->faces());
    detail::Array<double> distances;
    distances.reserve(given.size());
    for (const double d : given) distances.push_back(std::max(0.0, d - start));
    const auto lower = finder.lower(sources, distances);
    const double least_error = error_between(lower, distances, given, start);
    if (least_error > request_.tolerance && may_escalate()) {
      return {Assurance::expected, least_error, 0,
              "no more can be proved than to be within " + in_words(least_error)};
    }
    const double error = error_between(lower, finder.upper(sources), given, start);
    return {Assurance::certified, error, 0, "proved to be within " + in_words(error)};
  }

  [[nodiscard]] double error_between(const detail::Array<double>& lower,
                                     const detail::Array<double>& upper,
                                     const std::vector<double>& distances, double start) const {
    const auto bounds = detail::moved<Real>(lower, upper, start);
    if (request_.targets.empty()) return in_norm(bounds.error_of(distances));
    DistanceBounds<Real> at_targets;
    std::vector<double> there;
    for (const Index target : request_.targets) {
      const auto v = static_cast<std::size_t>(target);
      at_targets.lower.push_back(bounds.lower[v]);
      at_targets.upper.push_back(bounds.upper[v]);
      there.push_back(distances[v]);
    }
    return in_norm(at_targets.error_of(there));
  }

  // All vertices that matter, where a relative error means something.
  [[nodiscard]] std::vector<Index> reached_targets(const std::vector<double>& distances) const {
    std::vector<Index> targets;
    targets.reserve(distances.size());
    const auto add = [&](Index v) {
      const double d = distances[static_cast<std::size_t>(v)];
      if (d > 0 && std::isfinite(d)) targets.push_back(v);
    };
    for (const Index v : request_.targets) add(v);
    for (Index v = 0; request_.targets.empty() && v < surface_.vertex_count(); ++v) add(v);
    return targets;
  }

  // Follows paths back through the distances: more where few do not tell on which side of what is
  // allowed these are.
  [[nodiscard]] Finding trace(const detail::Sources& sources,
                              const std::vector<double>& distances) const {
    const std::vector<Index> targets = reached_targets(distances);
    if (targets.empty()) return {Assurance::expected, floor(), 0, "there are no targets"};
    detail::TracedErrorOf<Real> traced(surface_, sources, distances, targets);
    const double share = share_of_method();
    double error = unreachable<double>;
    for (Index count = few_paths; count <= many_paths; count += few_paths) {
      traced.trace(count);
      error = traced.at_most(sureness);
      if (error <= share || traced.at_least(sureness) > share) break;
    }
    error += floor();
    return {Assurance::expected, error, 0,
            std::to_string(traced.count()) + " paths tell that they are within " + in_words(error)};
  }

  // Computes some targets' distances exactly, spread over all that there are.
  [[nodiscard]] Finding sample(const detail::Sources& sources, const std::vector<double>& distances,
                               double width) const {
    const std::vector<Index> targets = reached_targets(distances);
    const detail::TargetSearch<Real> search(surface_, solvers_->faces(), sources, distances);
    double sum = 0, largest = 0;
    const auto count = std::min(static_cast<std::size_t>(request_.samples), targets.size());
    for (std::size_t i = 0; i < count; ++i) {
      const Index v = targets[(2 * i + 1) * targets.size() / (2 * count)];
      const double d = distances[static_cast<std::size_t>(v)];
      const double error = std::abs(d / search.exact(v, d, width) - 1);
      sum += error;
      largest = std::max(largest, error);
    }
    const double mean = sum / static_cast<double>(std::max<std::size_t>(1, count));
    const double error = request_.norm == ErrorNorm::max ? largest : mean;
    return {Assurance::sampled, error, static_cast<Index>(count),
            std::to_string(count) + " targets were checked exactly, error " + in_words(error)};
  }

  [[nodiscard]] const char* norm() const {
    return request_.norm == ErrorNorm::mean ? "mean" : "largest";
  }
  [[nodiscard]] std::string in_words(double error) const {
    std::ostringstream text;
    text.precision(2);
    text << error << " (" << norm() << ")";
    return text.str();
  }

  Surface<double> surface_;
  PlanRequest request_;
  detail::MeshStatisticsOf<Real> statistics_;
  Method chosen_ = Method::exact;
  DistancePlan plan_;
  std::shared_ptr<const Solvers> solvers_;
};

template <TriangleMesh M>
explicit DistancePlanner(const M&) -> DistancePlanner<MeshScalar<M>>;
template <TriangleMesh M>
DistancePlanner(const M&, PlanRequest) -> DistancePlanner<MeshScalar<M>>;

}  // namespace gelight
