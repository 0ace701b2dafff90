#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/bound_finder.hpp"
#include "gelight/geodesic/bounds/certifier_engine.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/geodesic/plan_costs.hpp"
#include "gelight/geodesic/planning/measured_costs.hpp"
#include "gelight/geodesic/planning/mesh_statistics.hpp"
#include "gelight/geodesic/planning/method_models.hpp"
#include "gelight/geodesic/planning/path_error.hpp"
#include "gelight/geodesic/planning/planned_solvers.hpp"
#include "gelight/geodesic/planning/target_search.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What a DistancePlanner works in.
template <std::floating_point T>
class PlanEngine {
  using Method = detail::Method;
  using Real = typename WorkingPrecision<T>::Real;  // by T, so that nothing is compiled unused
  template <class Type>
  using Deferred = detail::Deferred<Type, T>;
  using Solvers = PlannedSolvers<Real>;
  using Models = MethodErrors<Real>;

 public:
  PlanEngine(Surface<Real> surface, PlanRequest request)
      : surface_(std::move(surface)), request_(std::move(request)), statistics_(surface_) {
    require_request();
    solvers_ = std::make_shared<const Solvers>(surface_, request_.targets, request_.methods);
    choose();
  }

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }
  [[nodiscard]] const DistancePlan& plan() const { return plan_; }

  [[nodiscard]] PlannedDistances<T> run(Array<Source<Real>> sources) const;
  void solve_vertices(DistanceQuery<double>& query) const {
    const auto found = run(std::move(query.sources)).distance;
    std::copy(found.begin(), found.end(), query.distance.begin());
  }

 private:
  /// How an answer's error is found.
  enum class Check { none, paths, samples, paths_and_samples, certificate };

  // How far beyond the given distance a target is searched for: in tolerances, and as a share; and
  // beyond one that should be exact.
  static constexpr double search_width = 4, widest_search = 0.05, exact_search = 1e-9;
  // A certificate is tried where about so many tolerances should be provable.
  static constexpr double worth_trying = 1.5;
  // Where a march is expected to be off by more than this share of the mean error allowed, paths
  // tell: few at first, more until they are so many standard errors sure. About `failing` times
  // what is expected over what is allowed are beyond that, on meshes that are unfamiliar all.
  static constexpr double doubtful = 0.25, failing = 0.1, sureness = 2.5;
  static constexpr Index few_paths = 64, many_paths = 256;
  // How many times nearer to the smooth surface its own solver is at least, as measured on
  // spheroids, a torus and a cylinder of 600 vertices and more; and what it costs, to exact.
  static constexpr double mean_gain = 25, max_gain = 8, lifted_cost = 7;
  // What comparing numbers takes.
  static constexpr double arithmetic = 8 * std::numeric_limits<double>::epsilon();
  static constexpr std::size_t own = static_cast<std::size_t>(Method::own);  // how many are ours
  // The shares of a query after which a method, and the next, and all of their checks are done,
  // where others may have to follow; and of one method that the solver takes.
  static constexpr double first_method = 0.3, second_method = 0.6, solving = 0.6;
  // And of a certificate its lower bounds.
  static constexpr double lower_bounds = 0.4;

  void require_request() const {
    const PlanRequest& r = request_;
    require(r.tolerance > 0, "the tolerance is ", r.tolerance, ", not positive");
    require(r.sources > 0, "the number of sources is ", r.sources, ", less than 1");
    require(r.samples > 0, "the number of samples is ", r.samples, ", less than 1");
    require(r.time_limit > 0 && r.memory_limit > 0 && r.slowness > 0, "the limits ", r.time_limit,
            " s, ", r.memory_limit, " bytes and the slowness ", r.slowness,
            " are not all positive");
    require(std::isfinite(r.slowness), "the slowness is ", r.slowness, ", not finite");
    require_choice("error norm", static_cast<int>(r.norm), 2);
    require_choice("truth", static_cast<int>(r.truth), 2);
    require_choice("assurance", static_cast<int>(r.assurance), 3);
    for (const Index v : r.targets) surface_.require_vertex(v);
    for (std::size_t i = 0; i < r.methods.size(); ++i) {
      const PlanMethod& method = r.methods[i];
      require(!method.name.empty(), "method ", i, " of the caller's own has no name");
      const auto& [mean, max] = method.error;
      require(mean >= 0 && max >= mean, "the method ", method.name, " has a mean error of ", mean,
              " and a largest one of ", max);
      require(method.make != nullptr, "the method ", method.name, " has nothing to make it");
      require_cost(method.name, method.cost);
    }
    const PlanCosts& c = r.costs;
    for (std::size_t i = 0; i < own; ++i) {
      const auto method = static_cast<Method>(i);
      require_cost(detail::name_of(method), detail::cost_of(method, c));
    }
    require_cost("certificate", c.certificate);
    require_cost("paths", c.paths);
    require(c.sample_share >= 0 && std::isfinite(c.sample_share), "the share of a sample is ",
            c.sample_share);
  }
  static void require_choice(const char* what, int number, int count) {
    require(number >= 0 && number < count, what, " ", number, " of ", count);
  }
  static void require_cost(std::string_view name, const MethodCost& cost) {
    for (const double number : {cost.setup_ns, cost.query_ns, cost.bytes}) {
      require(number >= 0 && std::isfinite(number), "a cost of ", name, " is ", number);
    }
    require(std::isfinite(cost.growth), "the growth of ", name, " is ", cost.growth);
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
  // Whether only distances on the smooth surface may keep the tolerance, and what they are off.
  [[nodiscard]] bool is_lifted() const { return floor() >= request_.tolerance; }
  [[nodiscard]] double lifted_error() const {
    return floor() / (request_.norm == ErrorNorm::mean ? mean_gain : max_gain);
  }
  // What is left of the tolerance for the method. A mesh too coarse leaves none; then an error as
  // small as its own is enough.
  [[nodiscard]] double share_of_method() const {
    return floor() < request_.tolerance ? request_.tolerance - floor() : floor();
  }
  [[nodiscard]] Assurance asked() const {
    return request_.truth == DistanceTruth::smooth ? Assurance::expected : request_.assurance;
  }

  // The caller's own that a method is, if it is one.
  [[nodiscard]] const PlanMethod* own_method(Method method) const {
    return method < Method::own ? nullptr : &request_.methods[number_of(method)];
  }
  void for_each_method(auto&& visit) const {
    for (std::size_t i = 0; i < own + request_.methods.size(); ++i) visit(static_cast<Method>(i));
  }
  static std::size_t number_of(Method method) { return static_cast<std::size_t>(method) - own; }
  [[nodiscard]] std::string name_of(Method method) const {
    return method < Method::own ? detail::name_of(method) : own_method(method)->name;
  }
  [[nodiscard]] const MethodCost& cost_of(Method method) const {
    return method < Method::own ? detail::cost_of(method, request_.costs)
                                : own_method(method)->cost;
  }
  [[nodiscard]] RelativeError error_of(Method method) const {
    return method < Method::own ? Models(statistics_).of(method) : own_method(method)->error;
  }

  // Of the method, and of what T cannot hold: of ways from the start, or as found of distances.
  [[nodiscard]] double expected_error(Method method) const {
    constexpr double of_type = std::numeric_limits<T>::epsilon() / 2;
    return expected_error(method, in_norm({of_type / 2, of_type}));
  }
  [[nodiscard]] double expected_error(Method method, double of_type) const {
    return in_norm(error_of(method)) + of_type;
  }
  [[nodiscard]] double provable(Method method) const {
    return in_norm(Models(statistics_).provable(error_of(method)));
  }
  [[nodiscard]] bool is_familiar() const { return *Models(statistics_).unfamiliar() == 0; }

  // Whether a method's error is known to be small enough without a look at its distances.
  [[nodiscard]] bool is_sure(Method method, std::size_t sources) const {
    if (!is_familiar()) return false;
    if (method == Method::dijkstra) return expected_error(method) <= share_of_method();
    const bool is_tried = method == Method::fast_marching && request_.norm == ErrorNorm::mean;
    return sources == 1 && expected_error(method) <= (is_tried ? doubtful : 1) * share_of_method();
  }

  [[nodiscard]] Check check_of(Method method, std::size_t sources) const {
    const bool is_sampled = asked() != Assurance::expected;
    // Exact distances need no certificate: where one reaches the tolerance, it does so for others.
    if (method == Method::exact) return is_sampled ? Check::samples : Check::none;
    if (asked() == Assurance::certified) return Check::certificate;
    if (is_sampled && checks_all()) return Check::samples;
    const bool is_mean = request_.norm == ErrorNorm::mean;
    if (is_sampled && !is_mean) return Check::certificate;
    if (is_sure(method, sources) || is_beyond(method)) {
      return is_sampled ? Check::samples : Check::none;
    }
    if (!is_mean || !Models(statistics_).paths_tell(method, sources)) return Check::certificate;
    return is_sampled ? Check::paths_and_samples : Check::paths;
  }
  // Whether a method is only run because what would do is beyond the limits.
  [[nodiscard]] bool is_beyond(Method method) const {
    return expected_error(method) > share_of_method() && !may_be_tried(method);
  }
  // Whether a method is worth a look though more is expected of it than is allowed.
  [[nodiscard]] bool may_be_tried(Method method) const {
    if (method != Method::fast_marching || request_.norm != ErrorNorm::mean) return false;
    const double in_vain = seconds(cost_of(method)) + seconds(request_.costs.paths);
    return floor() < request_.tolerance && is_allowed(Method::exact, 0) &&
           is_allowed(fallback(1), in_vain);
  }
  // Whether a method keeps the limits after some seconds, checks apart.
  [[nodiscard]] bool is_allowed(Method method, double after) const {
    return after + seconds(cost_of(method)) <= request_.time_limit &&
           surface_.vertex_count() * cost_of(method).bytes <= request_.memory_limit;
  }
  // What follows where a method's error is found to be too large: the cheapest that is sure.
  [[nodiscard]] Method fallback(std::size_t sources) const {
    Method cheapest = Method::exact;
    const bool is_mean = request_.norm == ErrorNorm::mean;
    if (asked() == Assurance::certified) return cheapest;
    if (asked() == Assurance::sampled && !is_mean && !checks_all()) return cheapest;
    for_each_method([&](Method method) {
      if (!is_sure(method, sources) || !is_allowed(method, 0)) return;
      if (seconds(cost_of(method)) < seconds(cost_of(cheapest))) cheapest = method;
    });
    return cheapest;
  }
  // Whether all that matters is checked exactly.
  [[nodiscard]] bool checks_all() const {
    return !request_.targets.empty() && std::ssize(request_.targets) <= request_.samples;
  }
  static bool has_paths(Check check) {
    return check == Check::paths || check == Check::paths_and_samples;
  }
  static bool has_samples(Check check) {
    return check == Check::samples || check == Check::paths_and_samples;
  }

  [[nodiscard]] double seconds(const MethodCost& cost) const {
    return request_.slowness * cost.seconds(surface_.vertex_count(), request_.sources);
  }
  // With what it costs on average that another method has to follow where paths tell so.
  [[nodiscard]] double seconds_with_checks(Method method) const {
    const Check check = check_of(method, 1);
    double sum = seconds(cost_of(method));
    if (check == Check::certificate) sum += seconds(request_.costs.certificate);
    if (has_paths(check)) {
      const double share = expected_error(method) / share_of_method();
      sum += seconds(request_.costs.paths);
      sum += std::min(1.0, (is_familiar() ? failing : 1) * share) * seconds(cost_of(fallback(1)));
    }
    if (has_samples(check)) {
      sum += request_.samples * request_.costs.sample_share * seconds(cost_of(Method::exact));
    }
    return sum;
  }
  [[nodiscard]] double bytes(Method method) const {
    const bool is_proved = check_of(method, 1) == Check::certificate;
    const double checks = is_proved ? request_.costs.certificate.bytes : 0;
    return surface_.vertex_count() * std::max(cost_of(method).bytes, checks);
  }

  [[nodiscard]] bool satisfies(Method method) const {
    const Check check = check_of(method, 1);
    if (expected_error(method) > share_of_method()) {
      return has_paths(check) && may_be_tried(method);
    }
    return check != Check::certificate || provable(method) <= worth_trying * share_of_method();
  }
  [[nodiscard]] bool within_limits(Method method) const {
    return seconds_with_checks(method) <= request_.time_limit &&
           bytes(method) <= request_.memory_limit;
  }

  // The cheapest of the methods that satisfy and keep the limits; else, of those that keep the
  // limits, the most accurate; else, of those that keep that of memory, the quickest; else the one
  // that takes least memory.
  void choose() {
    std::optional<Deferred<Method>> cheapest, best, quickest;
    Method smallest = Method::dijkstra;
    const auto is_quicker = [&](Method method, const auto& than) {
      return !than || seconds_with_checks(method) < seconds_with_checks(*than);
    };
    for_each_method([&](Method method) {
      if (bytes(method) < bytes(smallest)) smallest = method;
      if (bytes(method) <= request_.memory_limit && is_quicker(method, quickest)) quickest = method;
      if (!within_limits(method)) return;
      if (satisfies(method) && is_quicker(method, cheapest)) cheapest = method;
      if (!best || expected_error(method) < expected_error(*best)) best = method;
    });
    chosen_ = cheapest ? *cheapest : best ? *best : quickest ? *quickest : smallest;
    plan_.method = name_of(chosen_);
    plan_.expected_to_satisfy = cheapest.has_value() && floor() < request_.tolerance;
    plan_.expected_error = expected_error(chosen_) + floor();
    plan_.unfamiliar = Models(statistics_).unfamiliar();
    plan_.seconds = seconds_with_checks(chosen_);
    plan_.bytes = bytes(chosen_);
    if (is_lifted()) return lift();
    plan_.reason = plan_.method + ": ";
    plan_.reason += best       ? reason(cheapest.has_value())
                    : quickest ? "no method keeps the limits; of those that keep the memory's this "
                                 "one is the quickest"
                               : "no method keeps the limits; this one needs the least memory";
    plan_.reason += how_checked();
  }

  // The mesh itself is too coarse.
  void lift() {
    const double exact = seconds(cost_of(Method::exact));
    plan_.method = "smooth";
    plan_.expected_error = lifted_error();
    plan_.seconds = lifted_cost * exact;
    plan_.bytes = 2 * bytes(Method::exact);
    const bool is_near = lifted_error() <= request_.tolerance;
    const bool is_allowed =
        plan_.seconds <= request_.time_limit && plan_.bytes <= request_.memory_limit;
    plan_.expected_to_satisfy = is_near && is_allowed;
    const std::string off = two_digits(floor()), tolerance = in_words(request_.tolerance);
    if (!is_near) {
      plan_.refine_to =
          statistics_.mean_edge * std::sqrt(request_.tolerance / (2 * lifted_error()));
      plan_.reason = joined("refine to edges of ", two_digits(plan_.refine_to), ". ");
    }
    plan_.reason +=
        joined("smooth: the mesh itself is off the smooth surface by about ", off,
               ", more than the tolerance ", tolerance,
               "; distances there are expected to be within ", in_words(lifted_error()));
    if (!is_allowed) plan_.reason += "; beyond the limits";
  }
  [[nodiscard]] std::string reason(bool has_satisfying) const {
    const std::string error = two_digits(plan_.expected_error);
    const std::string tolerance = two_digits(request_.tolerance);
    if (has_satisfying && expected_error(chosen_) > share_of_method()) {
      return joined("tried first, since it is cheap; its expected ", norm(), " error, ", error,
                    ", does not show that ", tolerance, " is kept, but paths will tell what it is");
    }
    if (has_satisfying) {
      return joined("the cheapest whose expected ", norm(), " error, ", error, ", is within ",
                    tolerance);
    }
    return joined("the most accurate within the limits; its expected ", norm(), " error is ",
                  error);
  }
  [[nodiscard]] std::string how_checked() const {
    std::string text;
    const Check check = check_of(chosen_, 1);
    if (check == Check::certificate) {
      text = "; of that " + two_digits(provable(chosen_)) + " should be provable";
    } else if (asked() == Assurance::certified) {
      text = "; bounds as close cannot be expected, so targets are checked exactly instead";
    }
    if (!is_familiar() && chosen_ != Method::exact) {
      text += joined("; the mesh is beyond experience, since ", plan_.unfamiliar,
                     ", so nothing is trusted unchecked");
    }
    return text;
  }

  // --- running -----------------------------------------------------------------------------------

  /// Sources whose start distances count from the earliest of them, and what that is.
  struct Query {
    Array<Source<Real>> sources;
    Starts<Real> starts;
  };
  /// What a method says: ways from the earliest start distance, and the distances that are
  /// returned.
  struct Answer {
    std::vector<Real> ways;
    std::vector<T> distances;
    const Starts<Real>& starts;

    // As the distances have it, which were rounded.
    [[nodiscard]] double way(Index v) const {
      return static_cast<double>(distances[static_cast<std::size_t>(v)]) - starts.at(v);
    }
  };
  /// How an answer's error against the mesh is known, what it is in the norm asked for, how many
  /// targets were checked for it and by how much the worst of them is off, in words.
  struct Finding {
    Assurance achieved;
    double error;
    std::string words;
    Index checked = 0;
    double worst_checked = 0;
  };

  [[nodiscard]] bool may_escalate() const {
    return chosen_ != Method::exact && plan_.expected_to_satisfy && within_limits(Method::exact);
  }

  [[nodiscard]] PlannedDistances<T> lifted(const Query& query) const {
    const SmoothDistances<Real> found = solvers_->smooth(query.sources, request_.cancelled);
    PlannedDistances<T> result;
    result.method = plan_.method;
    result.distance.reserve(found.distance.size());
    double not_smooth = 0;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const auto i = static_cast<std::size_t>(v);
      result.distance.push_back(
          distance_as<T>(query.starts.at(v) + found.distance[i], "vertex ", v));
      not_smooth += found.trust[i] == SmoothTrust::rough;
    }
    not_smooth /= surface_.vertex_count();
    if (request_.norm == ErrorNorm::max && not_smooth > 0) not_smooth = 1;
    result.error = lifted_error() + not_smooth * floor();
    result.satisfies = result.error <= request_.tolerance;
    result.reason =
        joined("smooth: expected to be within ", in_words(result.error), ", not checked");
    return result;
  }

  [[nodiscard]] PlannedDistances<T> attempt(Method method, const Query& query,
                                            const CancelHook& hook) const {
    const CancelHook part = hook.part(0, solving);
    Answer answer{method < Method::own ? solvers_->distance(method, query.sources, part)
                                       : solvers_->distance(*own_method(method), number_of(method),
                                                            query.sources, part),
                  {},
                  query.starts};
    answer.distances.reserve(answer.ways.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const double way = answer.ways[static_cast<std::size_t>(v)];
      answer.distances.push_back(distance_as<T>(query.starts.at(v) + way, "vertex ", v));
    }
    Finding found = find_error(method, query, answer, hook.part(solving, 1));
    if (const double zeros = error_of_zeros(query, answer); zeros > found.error) {
      found.error = zeros;
      found.worst_checked = std::max(found.worst_checked, 1.0);
      found.words += ", but targets that are no sources are said to be at no distance";
    }
    if (method >= Method::own && are_sources_away(query, answer)) {
      found.error = found.worst_checked = unreachable<double>;
      found.words += ", but targets that are sources are said to be at a distance";
    }
    PlannedDistances<T> result;
    result.method = name_of(method);
    result.distance = std::move(answer.distances);
    result.achieved =
        request_.truth == DistanceTruth::smooth ? Assurance::expected : found.achieved;
    result.error = found.checked > 0 ? found.worst_checked : found.error + floor();
    result.checked = found.checked;
    // No tolerance allows what has no bound, as where a target is missed.
    result.satisfies = found.error < unreachable<double> &&
                       found.error + floor() <= request_.tolerance &&
                       result.achieved >= least(method);
    result.reason = result.method + ": " + found.words;
    // A few targets that happen to be right say nothing against what is expected of the others.
    const bool may_be_luck = method != Method::exact && result.achieved == Assurance::sampled &&
                             is_beyond(method) &&
                             found.checked < std::ssize(reached_targets(query, answer));
    if (result.satisfies && may_be_luck) {
      result.satisfies = false;
      result.reason += "; of the others " + in_words(expected_error(method)) + " is expected";
    }
    if (method == Method::exact && expected_error(method) > share_of_method()) {
      result.satisfies = false;
      result.reason += "; rounding may leave " + in_words(expected_error(method));
    }
    return result;
  }

  // Exact distances are not known better by a certificate than they are: samples are enough.
  [[nodiscard]] Assurance least(Method method) const {
    return method == Method::exact ? std::min(asked(), Assurance::sampled) : asked();
  }

  [[nodiscard]] Finding find_error(Method method, const Query& query, const Answer& answer,
                                   const CancelHook& hook) const {
    hook.check(0, "the planned query");
    const Check check = check_of(method, query.sources.size());
    const std::vector<Real> ways = ways_of(method, query, answer);
    if (check == Check::certificate) return certify(query, answer, ways, hook);
    const double of_answer = rounding_of(answer);
    if (is_reach_wrong(method, query, answer)) {
      return {Assurance::expected, unreachable<double>,
              "a target is missed to which a path leads, or reached where none does"};
    }
    if (check == Check::none) {
      const double error = expected_error(method, of_answer);
      return {Assurance::expected, error,
              "expected to be within " + in_words(error + floor()) + ", not checked"};
    }
    const std::vector<Index> targets = reached_targets(query, answer);
    if (targets.empty()) {
      return {Assurance::certified, 0,
              "no target but the sources can be reached, so that there is nothing to be off"};
    }
    Finding traced{Assurance::expected, 0, ""};
    if (has_paths(check)) {
      traced = trace(query, answer, targets, hook.part(0, 0.5));
      traced.error += of_answer;
      const bool is_beyond = traced.error > share_of_method();
      if (check == Check::paths || (is_beyond && may_escalate())) return traced;
      traced.words += ", ";
    }
    const double width = std::min(widest_search, search_width * request_.tolerance);
    Finding sampled = sample(query, answer, ways, targets,
                             method == Method::exact ? exact_search : width, hook.part(0.5, 1));
    sampled.words = traced.words + sampled.words;
    if (sampled.checked == std::ssize(targets)) return sampled;
    // The others are off by what the method is expected to be, and rounding besides.
    const double others = has_paths(check) ? traced.error : expected_error(method, of_answer);
    sampled.error = std::max(sampled.error, others);
    return sampled;
  }

  // As Certifier, but lower bounds first: upper ones are needed only where those are enough.
  [[nodiscard]] Finding certify(const Query& query, const Answer& answer,
                                const std::vector<Real>& ways, const CancelHook& hook) const {
    const BoundFinder<Real> finder(surface_, solvers_->faces());
    Array<Real> potential(ways.size());
    std::copy(ways.begin(), ways.end(), potential.begin());
    const auto lower = finder.lower(query.sources, potential, hook.part(0, lower_bounds));
    const double least_error = error_between(lower, potential, answer);
    if (least_error > share_of_method() && may_escalate()) {
      return {Assurance::expected, least_error,
              "no more can be proved than to be within " + in_words(least_error)};
    }
    const double error =
        error_between(lower, finder.upper(query.sources, hook.part(lower_bounds, 1)), answer);
    return {Assurance::certified, error, "proved to be within " + in_words(error)};
  }

  // Of the distances as they are returned.
  [[nodiscard]] double error_between(const Array<Real>& lower, const Array<Real>& upper,
                                     const Answer& answer) const {
    const auto bounds = moved<Real>(lower, upper, Starts<Real>{});
    DistanceBounds<Real> at_targets;
    std::vector<Real> there;
    for_each_target([&](Index target) {
      const auto v = static_cast<std::size_t>(target);
      at_targets.lower.push_back(bounds.lower[v]);
      at_targets.upper.push_back(bounds.upper[v]);
      there.push_back(answer.way(target));
    });
    const double error = in_norm(at_targets.error_of(there));
    return error == 0 ? 0 : error + arithmetic;
  }

  // All vertices that matter.
  void for_each_target(auto&& visit) const {
    for (const Index v : request_.targets) visit(v);
    if (!request_.targets.empty()) return;
    for (Index v = 0; v < surface_.vertex_count(); ++v) visit(v);
  }

  // Those that are reached and no sources: where a relative error means something. (How far from 0
  // sources are said to be is measured by the edges beside them: are_sources_away.)
  [[nodiscard]] std::vector<Index> reached_targets(const Query& query, const Answer& answer) const {
    const auto is_source = vertices_at_sources(query);
    std::vector<Index> targets;
    targets.reserve(answer.ways.size());
    for_each_target([&](Index v) {
      const double way = answer.ways[static_cast<std::size_t>(v)];
      if (std::isfinite(way) && is_source[v] == 0) targets.push_back(v);
    });
    return targets;
  }

  // Of each vertex, whether it is where a way starts, but for rounding.
  [[nodiscard]] Array<char> vertices_at_sources(const Query& query) const {
    Array<char> is_source(static_cast<std::size_t>(surface_.vertex_count()), 0);
    std::vector<Index> front;
    const auto add = [&](Index v, double way, double edge) {
      if (way > share_rounding<double> * edge) return;
      if (std::exchange(is_source[v], char{1}) == 0) front.push_back(v);
    };
    for (const auto& source : query.sources) {
      for_each_vertex_near(surface_, source.point, [&](Index v, double way) {
        add(v, source.distance + way, longest_edge(v));
      });
    }
    while (!front.empty()) {  // over edges without length
      const Index v = front.back();
      front.pop_back();
      for (const Index h : surface_.corners(v)) {
        add(surface_.tip(h), surface_.length(h), 0);
        add(surface_.apex(h), surface_.length(Surface<Real>::previous(h)), 0);
      }
    }
    return is_source;
  }

  [[nodiscard]] double longest_edge(Index v) const {
    double edge = 0;
    for (const Index h : surface_.corners(v)) edge = std::max(edge, surface_.length(h));
    return edge;
  }

  // Whether targets that are sources are said to be farther than vertices beside them may be off.
  [[nodiscard]] bool are_sources_away(const Query& query, const Answer& answer) const {
    const auto is_source = vertices_at_sources(query);
    const double share = std::min(1.0, request_.tolerance);
    bool are_away = false;
    for_each_target([&](Index v) {
      const double way = answer.ways[static_cast<std::size_t>(v)];
      are_away |= is_source[v] != 0 && way > share * longest_edge(v);
    });
    return are_away;
  }

  // The least that the error can be for targets at no distance that are no sources.
  [[nodiscard]] double error_of_zeros(const Query& query, const Answer& answer) const {
    const std::vector<Index> targets = reached_targets(query, answer);
    const auto zeros = std::count_if(targets.begin(), targets.end(), [&](Index v) {
      return answer.ways[static_cast<std::size_t>(v)] == 0;
    });
    if (zeros == 0) return 0;
    return in_norm({static_cast<double>(zeros) / static_cast<double>(targets.size()), 1});
  }

  // Of each vertex, whether a path leads there.
  [[nodiscard]] Array<char> reached(const Query& query) const {
    const auto& parts = surface_.components();
    Array<char> of_part(parts.size(), 0), is_reached;
    for (const auto& source : query.sources) of_part[part_of(surface_, source.point)] = 1;
    is_reached.reserve(parts.size());
    for (const Index part : parts) is_reached.push_back(of_part[part]);
    return is_reached;
  }

  // Whether targets are said to be out of reach that are not, or the other way round; or farther
  // than any shortest path.
  [[nodiscard]] bool is_reach_wrong(Method method, const Query& query, const Answer& answer) const {
    const auto way = [&](Index v) { return answer.ways[static_cast<std::size_t>(v)]; };
    const double longest =
        method < Method::own ? std::numeric_limits<double>::max() : longest_way(surface_);
    bool misses = false, is_wrong = false;
    for_each_target([&](Index v) { misses |= !(way(v) < unreachable<double>); });
    if (!misses && method < Method::own) return false;
    const auto is_reached = reached(query);
    for_each_target([&](Index v) {
      is_wrong |= is_reached[v] != 0 ? !(way(v) <= longest) : way(v) < unreachable<double>;
    });
    return is_wrong;
  }

  // The ways that bounds start from: of a method of the caller's own any may be wrong, or missing
  // beside the targets.
  [[nodiscard]] std::vector<Real> ways_of(Method method, const Query& query,
                                          const Answer& answer) const {
    std::vector<Real> ways = answer.ways;
    if (method < Method::own) return ways;
    const double longest = longest_way(surface_);
    const auto is_reached = reached(query);
    for (std::size_t v = 0; v < ways.size(); ++v) {
      ways[v] =
          is_reached[static_cast<Index>(v)] != 0 ? std::min(ways[v], longest) : unreachable<double>;
    }
    return ways;
  }

  // What of the ways is lost in distances of type T, which count from the start.
  [[nodiscard]] double rounding_of(const Answer& answer) const {
    const bool is_moved = answer.starts.common != 0 || !answer.starts.of_vertex.empty();
    if (std::is_same_v<T, double> && !is_moved) return 0;
    RelativeError error;
    double count = 0;
    for_each_target([&](Index v) {
      const double way = answer.ways[static_cast<std::size_t>(v)];
      if (!(way > 0 && std::isfinite(way))) return;
      const double off = std::abs(answer.way(v) - way) / way;
      error.mean += off;
      error.max = std::max(error.max, off);
      ++count;
    });
    error.mean /= std::max(1.0, count);
    return in_norm(error);
  }

  // Follows paths back through the distances: more where few do not tell on which side of what is
  // allowed these are.
  [[nodiscard]] Finding trace(const Query& query, const Answer& answer,
                              const std::vector<Index>& targets, const CancelHook& hook) const {
    PathError<Real> traced(surface_, query.sources, answer.ways, targets);
    const double share = share_of_method();
    double error = unreachable<double>;
    // Where waves of several sources meet, few vertices have most of the error.
    const Index first = query.sources.size() > 1 ? many_paths : few_paths;
    for (Index count = first; count <= many_paths; count += few_paths) {
      const double done = count == first ? 0 : double(count - few_paths) / many_paths;
      traced.trace(count, hook.part(done, double(count) / many_paths));
      error = traced.at_most(sureness);
      if (error <= share || traced.at_least(sureness) > share) break;
    }
    return {Assurance::expected, error,
            joined(traced.count(), " paths tell that they are within ", in_words(error + floor()))};
  }

  // Computes some targets' distances exactly, spread over all that there are.
  [[nodiscard]] Finding sample(const Query& query, const Answer& answer,
                               const std::vector<Real>& ways, const std::vector<Index>& targets,
                               double width, const CancelHook& hook) const {
    const TargetSearch<Real> search(surface_, solvers_->faces(), query.sources, ways, hook);
    const auto count = std::min(static_cast<std::size_t>(request_.samples), targets.size());
    double sum = 0, worst = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Index v = targets[(2 * i + 1) * targets.size() / (2 * count)];
      const double way = search.exact(v, ways[static_cast<std::size_t>(v)], width);
      // Farther than was searched for: so much too small that no more than all of it can be off.
      const bool is_found = way < unreachable<double>;
      const double off = is_found ? std::abs(answer.way(v) - way) / way : 1;
      sum += off;
      worst = std::max(worst, off);
    }
    const double mean = sum / static_cast<double>(count);
    const char* const which = count == targets.size() ? " targets, all there are," : " targets";
    return {Assurance::sampled, request_.norm == ErrorNorm::mean ? mean : worst,
            joined(count, which, " were checked exactly, error ", two_digits(mean), " on average, ",
                   two_digits(worst), " at most"),
            static_cast<Index>(count), worst};
  }

  [[nodiscard]] const char* norm() const {
    return request_.norm == ErrorNorm::mean ? "mean" : "largest";
  }
  [[nodiscard]] std::string in_words(double error) const {
    return two_digits(error) + " (" + norm() + ")";
  }

  Surface<Real> surface_;
  Deferred<PlanRequest> request_;
  MeshStatistics<Real> statistics_;
  Method chosen_ = Method::exact;
  Deferred<DistancePlan> plan_;
  std::shared_ptr<const Solvers> solvers_;
};

template <std::floating_point T>
auto PlanEngine<T>::run(Array<Source<Real>> sources) const -> PlannedDistances<T> {
  Starts<Real> starts = move_to_zero(surface_, sources);
  const Query query{std::move(sources), std::move(starts)};
  if (is_lifted()) return lifted(query);
  const bool is_last = !may_escalate();
  const CancelHook& hook = request_.cancelled;
  PlannedDistances<T> result = attempt(chosen_, query, is_last ? hook : hook.part(0, first_method));
  if (result.satisfies || is_last) return result;
  const auto escalate = [&](Method method, const CancelHook& part) {
    PlannedDistances<T> next = attempt(method, query, part);
    next.reason = result.reason + "; escalated: " + next.reason;
    result = std::move(next);
  };
  double done = first_method;
  const Method next = fallback(query.sources.size());
  if (next != Method::exact && next != chosen_) {
    escalate(next, hook.part(done, second_method));
    if (result.satisfies) return result;
    done = second_method;
  }
  escalate(Method::exact, hook.part(done, 1));
  return result;
}

}  // namespace gelight::detail
