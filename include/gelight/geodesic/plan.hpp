#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/late.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/detail/mesh_statistics.hpp"
#include "gelight/geodesic/detail/window_propagation.hpp"
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

/// How an error is known: from experience with such meshes; from targets whose exact distance was
/// computed; by bounds that were proved at every vertex.
enum class Assurance {
  expected,  ///< Experience; nothing was checked.
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
  double expected_error = 0;        ///< In the norm and against the truth asked for.
  double seconds = 0;               ///< Estimate for all queries, with checks.
  double bytes = 0;                 ///< Estimate beyond the mesh.
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
  bool satisfies = false;  ///< Whether the error meets the tolerance, with the assurance asked for.
  std::string reason;      ///< What was done and found, in words.
};

namespace detail {

using DistanceFunction = std::function<std::vector<double>(const Sources&)>;

/// What is known beforehand about a method: nanoseconds a vertex of set-up and of a query at 10,000
/// vertices, the power of the number of vertices (beyond linear) by which a query grows, bytes a
/// vertex, the error expected on a mesh, and how to make it.
struct MethodModel {
  const char* name;
  double setup_ns, query_ns, growth, bytes;
  RelativeError (*error)(const MeshStatistics&);
  DistanceFunction (*make)(const Surface<double>&, const std::vector<Index>& targets);
};

template <class Solver>
DistanceFunction distances_by(const Surface<double>& surface, const std::vector<Index>&) {
  auto solver = std::make_shared<const Solver>(surface);
  return [solver](const Sources& sources) {
    return solver->distance(std::span<const Source<double>>(sources));
  };
}

inline DistanceFunction exact_distances(const Surface<double>& surface,
                                        const std::vector<Index>& targets) {
  ExactOptions<double> options;
  for (const Index v : targets) options.targets.push_back(vertex_point<double>(v));
  auto solver = std::make_shared<const ExactSolver<double>>(surface, std::move(options));
  return [solver](const Sources& sources) {
    return solver->distance(std::span<const Source<double>>(sources));
  };
}

/// From the cheapest to the exact one. Times on one core of an AMD EPYC; errors are such that the
/// meshes of benchmarks/pareto and of the tests stay below them.
inline constexpr std::array<MethodModel, 4> distance_methods{{
    {"dijkstra", 45, 45, 0.1, 400,
     [](const MeshStatistics& s) {
       return RelativeError{0.12 * s.aspect, 0.8 * s.aspect};
     },
     distances_by<DijkstraSolver<double>>},
    {"virtual_source", 10, 300, 0.25, 450,
     [](const MeshStatistics& s) {
       const bool is_regular = s.aspect < 3 && s.obtuse < 0.02 && !s.has_corners;
       if (is_regular && s.is_flat) return RelativeError{1e-9, 1e-8};
       if (is_regular && s.is_convex) return RelativeError{0.2 * s.turn * s.turn, 0.1 * s.turn};
       return RelativeError{0.02, 0.3};
     },
     distances_by<VirtualSourceSolver<double>>},
    {"fast_marching", 140, 110, 0.3, 600,
     [](const MeshStatistics& s) {
       const double bend = s.bend / (1 + 3.5 * s.bend);
       const double mean = 2e-5 + 0.005 * s.obtuse +
                           0.055 * bend * (0.45 + std::sqrt(s.aspect) / 2) +
                           (s.has_corners ? 0.004 : 0);
       return RelativeError{std::min(0.02, mean), std::min(0.1, 20 * mean)};
     },
     distances_by<FastMarchingSolver<double>>},
    {"exact", 120, 1400, 0.5, 600,
     [](const MeshStatistics& s) {
       return RelativeError{1e-14 * s.aspect, 1e-14 * s.aspect * s.aspect};
     },
     exact_distances},
}};

/// The certificate, as such a model; its error is what it typically proves of fast marching's
/// distances: nothing is lost but time where it proves less.
inline constexpr MethodModel certificate_model{
    "certificate",
    110,
    680,
    0.1,
    1100,
    [](const MeshStatistics& s) {
      const double mean = 1e-5 + 0.1 * s.obtuse + 0.2 * s.bend * (1 + 0.1 * s.aspect);
      return RelativeError{mean, 20 * mean};
    },
    nullptr};

/// What checking one target exactly costs, as a share of an exact query.
inline constexpr double sample_share = 0.1;

}  // namespace detail

/// Distances to a given error rather than by a given method: chooses the cheapest method expected
/// to satisfy a request, runs it, checks what it was asked to check, and escalates to the exact
/// solver where that fails. What it reports as certified was proved for every vertex (or target) of
/// that very answer, by Certifier; as sampled, computed exactly for so many targets; all else is
/// expected, which is no more than experience.
///
/// Against the smooth surface nothing can be checked: the error of the mesh itself is taken for 0.3
/// times the mean squared angle between faces, which is 0.10 (kappa h)^2 on a sphere of curvature
/// kappa and edges h, and the assurance is never more than expected. Where it exceeds the tolerance
/// the plan says to what edge length to refine.
///
/// HeatSolver is not among the methods: on every mesh of benchmarks/results, and on spheres of
/// 163,842 vertices, fast marching takes no longer for a further source, a tenth to a fifth of the
/// set-up, and is more accurate by a factor of two to a thousand.
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
      : surface_(mesh),
        request_(std::move(request)),
        statistics_(surface_),
        solvers_(std::make_shared<Solvers>()) {
    require_request();
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
  using Model = detail::MethodModel;
  static constexpr std::size_t exact_index = detail::distance_methods.size() - 1;
  static constexpr double rounding = 1e-12;  // by which a search is wider than the bounds
  // How far beyond the given distance a target is searched for: in tolerances, and as a share; and
  // beyond one that should be exact.
  static constexpr double search_width = 4, widest_search = 0.05, exact_search = 1e-9;
  // How often an error of the distances shows in the bounds: those are taken from them.
  static constexpr double errors_in_bounds = 3;

  struct Solvers {
    std::array<detail::Late<detail::DistanceFunction>, detail::distance_methods.size()> methods;
    detail::Late<Certifier<double>> certifier;
    detail::Late<detail::PlanarFaces> faces;
  };

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

  [[nodiscard]] double seconds(const Model& model) const {
    const double n = surface_.vertex_count();
    const double query = model.query_ns * std::pow(n / 1e4, model.growth);
    return 1e-9 * request_.slowness * n * (model.setup_ns + request_.sources * query);
  }
  // What a certificate is expected to prove of a method's distances.
  [[nodiscard]] double provable(const Model& model) const {
    return std::max(in_norm(detail::certificate_model.error(statistics_)),
                    errors_in_bounds * in_norm(model.error(statistics_)));
  }
  [[nodiscard]] bool is_exact(const Model& model) const {
    return &model == &detail::distance_methods[exact_index];
  }
  // Exact distances need none: where one reaches the tolerance, it does so for others too.
  [[nodiscard]] bool needs_certificate(const Model& model) const {
    return asked() == Assurance::certified && !is_exact(model);
  }
  [[nodiscard]] bool needs_samples(const Model& model) const {
    return asked() != Assurance::expected && !needs_certificate(model);
  }
  [[nodiscard]] double seconds_with_checks(const Model& model) const {
    double sum = seconds(model);
    if (needs_certificate(model)) sum += seconds(detail::certificate_model);
    if (needs_samples(model)) {
      sum +=
          request_.samples * detail::sample_share * seconds(detail::distance_methods[exact_index]);
    }
    return sum;
  }
  [[nodiscard]] double bytes(const Model& model) const {
    return surface_.vertex_count() *
           std::max(model.bytes, needs_certificate(model) ? detail::certificate_model.bytes : 0.0);
  }

  [[nodiscard]] bool satisfies(const Model& model) const {
    const double error =
        needs_certificate(model) ? provable(model) : in_norm(model.error(statistics_));
    return error <= share_of_method();
  }
  [[nodiscard]] bool within_limits(const Model& model) const {
    return seconds_with_checks(model) <= request_.time_limit &&
           bytes(model) <= request_.memory_limit;
  }

  // The cheapest of the methods that satisfy and keep the limits; else, of those that keep the
  // limits, the most accurate; else the one that takes least memory.
  void choose() {
    const auto& methods = detail::distance_methods;
    std::optional<std::size_t> cheapest, best;
    std::size_t smallest = 0;
    for (std::size_t i = 0; i < methods.size(); ++i) {
      if (bytes(methods[i]) < bytes(methods[smallest])) smallest = i;
      if (!within_limits(methods[i])) continue;
      const bool satisfied = satisfies(methods[i]);
      if (satisfied && (!cheapest || seconds_with_checks(methods[i]) <
                                         seconds_with_checks(methods[*cheapest]))) {
        cheapest = i;
      }
      if (!best ||
          in_norm(methods[i].error(statistics_)) < in_norm(methods[*best].error(statistics_))) {
        best = i;
      }
    }
    chosen_ = cheapest ? *cheapest : best ? *best : smallest;
    const Model& model = methods[chosen_];
    plan_.method = model.name;
    plan_.expected_to_satisfy = cheapest.has_value() && floor() < request_.tolerance;
    plan_.expected_error = in_norm(model.error(statistics_)) + floor();
    plan_.seconds = seconds_with_checks(model);
    plan_.bytes = bytes(model);
    if (floor() >= request_.tolerance) {
      plan_.refine_to = statistics_.mean_edge * std::sqrt(request_.tolerance / (2 * floor()));
    }
    plan_.reason = reason(cheapest.has_value(), best.has_value());
  }

  [[nodiscard]] std::string reason(bool has_satisfying, bool within_limits) const {
    std::ostringstream text;
    const char* norm = request_.norm == ErrorNorm::mean ? "mean" : "largest";
    text.precision(2);
    if (plan_.refine_to > 0) {
      text << "refine to edges of " << plan_.refine_to << ": the mesh itself is off the smooth "
           << "surface by about " << floor() << ", more than the tolerance " << request_.tolerance
           << "; until then finer methods are false precision. ";
    }
    text << plan_.method << ": ";
    if (has_satisfying) {
      text << "the cheapest whose expected " << norm << " error, " << plan_.expected_error
           << ", is within " << request_.tolerance;
    } else if (within_limits) {
      text << "the most accurate within the limits; its expected " << norm << " error is "
           << plan_.expected_error;
    } else {
      text << "no method keeps the limits; this one needs the least memory";
    }
    const Model& model = detail::distance_methods[chosen_];
    if (needs_certificate(model)) {
      text << "; of that " << provable(model) << " should be provable";
    } else if (asked() == Assurance::certified) {
      text << "; bounds as close cannot be expected, so targets are checked exactly instead";
    }
    return text.str();
  }

  // --- running -----------------------------------------------------------------------------------

  [[nodiscard]] PlannedDistances<T> run(const detail::Sources& sources) const {
    PlannedDistances<T> result = attempt(chosen_, sources);
    if (!result.satisfies && chosen_ != exact_index && plan_.expected_to_satisfy &&
        within_limits(detail::distance_methods[exact_index])) {
      PlannedDistances<T> exact = attempt(exact_index, sources);
      exact.reason = result.reason + "; escalated: " + exact.reason;
      return exact;
    }
    return result;
  }

  [[nodiscard]] PlannedDistances<T> attempt(std::size_t method,
                                            const detail::Sources& sources) const {
    const Model& model = detail::distance_methods[method];
    const auto& solve =
        solvers_->methods[method].get([&] { return model.make(surface_, request_.targets); });
    const std::vector<double> distances = solve(sources);
    PlannedDistances<T> result;
    result.method = model.name;
    for (const double d : distances) result.distances.push_back(static_cast<T>(d));
    const Finding found = find_error(model, sources, distances);
    result.achieved = found.achieved;
    result.error = found.error;
    result.checked = found.checked;
    result.satisfies = result.error <= request_.tolerance && result.achieved >= least(method);
    result.reason = describe(result);
    return result;
  }

  // Exact distances are not known better by a certificate than they are: samples are enough.
  [[nodiscard]] Assurance least(std::size_t method) const {
    return method == exact_index ? std::min(asked(), Assurance::sampled) : asked();
  }

  /// How an answer's error is known, what it is, and how many targets were checked for it.
  struct Finding {
    Assurance achieved;
    double error;
    Index checked;
  };

  [[nodiscard]] Finding find_error(const Model& model, const detail::Sources& sources,
                                   const std::vector<double>& distances) const {
    if (asked() == Assurance::expected) {
      return {Assurance::expected, in_norm(model.error(statistics_)) + floor(), 0};
    }
    if (needs_samples(model)) {
      const double width = std::min(widest_search, search_width * request_.tolerance);
      return sample(sources, distances, is_exact(model) ? exact_search : width);
    }
    const auto& certifier = solvers_->certifier.get([&] { return Certifier<double>(surface_); });
    const DistanceBounds<double> bounds =
        certifier.bounds(std::span<const Source<double>>(sources), distances);
    return {Assurance::certified, in_norm(at_targets(bounds).error_of(at_targets(distances))), 0};
  }

  template <class Values>
  [[nodiscard]] std::vector<double> at_targets(const Values& values) const {
    if (request_.targets.empty()) return {values.begin(), values.end()};
    std::vector<double> out;
    for (const Index v : request_.targets) out.push_back(values[static_cast<std::size_t>(v)]);
    return out;
  }
  [[nodiscard]] DistanceBounds<double> at_targets(const DistanceBounds<double>& bounds) const {
    return {at_targets(bounds.lower), at_targets(bounds.upper)};
  }

  // Computes some targets' distances exactly, from the target back to the sources through what
  // lower bounds do not show to be a detour, up to a share beyond the given distance.
  [[nodiscard]] Finding sample(const detail::Sources& sources, const std::vector<double>& distances,
                               double width) const {
    std::vector<Index> targets;
    const auto add = [&](Index v) {
      const double d = distances[static_cast<std::size_t>(v)];
      if (d > 0 && std::isfinite(d)) targets.push_back(v);
    };
    for (const Index v : request_.targets) add(v);
    for (Index v = 0; request_.targets.empty() && v < surface_.vertex_count(); ++v) add(v);
    const detail::Array<double> rest = least_ways(sources, distances);
    const double start = least_start(sources);
    double sum = 0, largest = 0;
    const auto count = std::min(static_cast<std::size_t>(request_.samples), targets.size());
    for (std::size_t i = 0; i < count; ++i) {
      const Index v = targets[(2 * i + 1) * targets.size() / (2 * count)];
      const double d = distances[static_cast<std::size_t>(v)];
      const double limit = start + (d - start) * (1 + width + rounding);
      const double error = std::abs(d / exact_distance(v, limit, sources, rest) - 1);
      sum += error;
      largest = std::max(largest, error);
    }
    const double mean = sum / static_cast<double>(std::max<std::size_t>(1, count));
    return {Assurance::sampled, request_.norm == ErrorNorm::max ? largest : mean,
            static_cast<Index>(count)};
  }

  static double least_start(const detail::Sources& sources) {
    double start = unreachable<double>;
    for (const auto& source : sources) start = std::min(start, source.distance);
    return start;
  }

  [[nodiscard]] const detail::PlanarFaces& faces() const {
    return solvers_->faces.get([&] { return detail::PlanarFaces(surface_); });
  }

  // Lower bounds of what is left from each vertex to the sources, counted from the least start.
  [[nodiscard]] detail::Array<double> least_ways(detail::Sources sources,
                                                 const std::vector<double>& distances) const {
    const double start = least_start(sources);
    detail::Array<double> potential;
    for (auto& source : sources) source.distance -= start;
    potential.reserve(distances.size());
    for (const double d : distances) potential.push_back(std::max(0.0, d - start));
    auto rest = detail::LowerPotential(surface_, faces()).bounds(potential, sources);
    for (double& d : rest) d = std::max(0.0, d * (1 - rounding));
    return rest;
  }

  // The exact distance of a target, infinite where it is beyond the limit. From vertices the search
  // runs back from the target, where the bounds keep it narrow; from other points forward, where
  // straight distances do.
  [[nodiscard]] double exact_distance(Index target, double limit, detail::Sources sources,
                                      const detail::Array<double>& rest) const {
    const double start = least_start(sources);
    bool from_vertices = true;
    for (auto& source : sources) {
      source.distance -= start;
      from_vertices &= source.point.kind == SurfacePoint<double>::Kind::vertex;
    }
    detail::PropagationLimits limits;
    limits.distance = limit - start;
    limits.rest = rest;
    detail::WindowPropagation propagation;
    if (!from_vertices) {
      for (Index v = 0; v < surface_.vertex_count(); ++v) {
        const Vec3<double> way = surface_.position(v) - surface_.position(target);
        limits.rest[v] = detail::stable_norm(way) * (1 - rounding);
      }
      propagation.run(surface_, faces(), sources, limits);
      return start + propagation.distances[target];
    }
    propagation.run(surface_, faces(), {{vertex_point<double>(target), 0}}, limits);
    double distance = unreachable<double>;
    for (const auto& source : sources) {
      const double way = propagation.distances[source.point.element[0]];
      distance = std::min(distance, source.distance + way);
    }
    return start + distance;
  }

  [[nodiscard]] std::string describe(const PlannedDistances<T>& result) const {
    std::ostringstream text;
    text.precision(2);
    const char* norm = request_.norm == ErrorNorm::mean ? "mean" : "largest";
    text << result.method << ": ";
    if (result.achieved == Assurance::certified) {
      text << "proved to be within " << result.error << " (" << norm << ")";
    } else if (result.achieved == Assurance::sampled) {
      text << result.checked << " targets were checked exactly, " << norm << " error "
           << result.error;
    } else {
      text << "expected to be within " << result.error << " (" << norm << "), not checked";
    }
    return text.str();
  }

  Surface<double> surface_;
  PlanRequest request_;
  detail::MeshStatistics statistics_;
  std::size_t chosen_ = 0;
  DistancePlan plan_;
  std::shared_ptr<Solvers> solvers_;
};

template <TriangleMesh M>
explicit DistancePlanner(const M&) -> DistancePlanner<MeshScalar<M>>;
template <TriangleMesh M>
DistancePlanner(const M&, PlanRequest) -> DistancePlanner<MeshScalar<M>>;

}  // namespace gelight
