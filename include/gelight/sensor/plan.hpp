#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/planning/contacts.hpp"
#include "gelight/sensor/planning/costs.hpp"
#include "gelight/sensor/planning/membrane_lights.hpp"
#include "gelight/sensor/planning/membranes.hpp"
#include "gelight/sensor/planning/trials.hpp"
#include "gelight/sensor/presets.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

// Opt-in: compiles all light models and renderers.
//
// No more than the scene needs, as a call:
//
//     const SensorAt sensor = [](double edge) { return geltip<double>(640, 480, edge); };
//     const SensorPlan plan = plan_sensor(sensor, {.tolerance = 2, .share = 0.99});
//     if (!plan.satisfies) throw std::runtime_error(plan.needed);
//     const auto renderer = planned_renderer<double>(sensor, plan);  // float: where it says so
namespace gelight {

/// What a caller wants of a sensor's images, and of what contacts.
struct SensorPlanRequest {
  double tolerance = 1;           ///< grey levels, of 255, that a colour may be off
  double share = 0.99;            ///< of the pixels that contacts change, for which that must hold
  double contact_radius = 0.003;  ///< m: of the contacts, where the membrane is flat
  double press_depth = 0.0008;    ///< m
  /// The light that is right; the planner takes another only where that makes no difference.
  PlannedLight light = PlannedLight::geodesic;
  /// The membrane that is right, likewise: the preset's Gaussian, or what its `gel` does, of which
  /// an elastic layer is the truth where the membrane lies about across the camera's axis.
  PlannedMembrane membrane = PlannedMembrane::gaussian;
  /// m: the mesh edges of the images that others are compared with. Meshes with edges of twice as
  /// much and more are chosen among.
  double reference_edge = 0.0004;
  double frames_a_second = 0;  ///< needed at least; 0: any number
  double frames = 1000;        ///< over which the work that is done once is spread
  /// By how much the machine is slower than one of 2 thousand million operations a second.
  double slowness = 1;
  Index contacts = 8;         ///< to try, at random
  std::uint64_t seed = 1;     ///< of what is random
  CancelHook cancelled = {};  ///< asked between one trial and the next, and while light is computed
};

/// One of the things that a plan chooses, and why.
struct SensorPlanStep {
  std::string topic;   ///< mesh edges, light model, light grid, smoothing or precision
  std::string choice;  ///< in words
  /// Grey levels, that this choice alone is off in the share of the pixels asked for.
  int error = 0;
  double seconds = 0;  ///< that it takes, once or, smoothing and precision, a frame; an estimate
  std::string reason;  ///< in words
};

/// A chain from mesh to image, no dearer than a request needs.
struct SensorPlan {
  /// Whether the trials keep the request; what is chosen below is the most exact, if not.
  bool satisfies = false;
  std::string needed;  ///< in words: what would satisfy; empty where that is satisfied

  double edge_length = 0;                       ///< of the mesh, m
  PlannedLight light = PlannedLight::geodesic;  ///< the light model
  Index light_grid = 1;  ///< pixels between the places where light is computed
  PlannedMembrane membrane = PlannedMembrane::gaussian;  ///< the membrane model
  double smoothing_sigma = 0;    ///< pixels, of the Gaussian membrane; 0: it follows the object
  Index smoothing_radius = 0;    ///< pixels: where the Gaussian is cut off
  bool single_precision = true;  ///< whether frames are rendered in float

  double share = 0;            ///< of the pixels that the trials changed, within the tolerance
  double share_error = 0;      ///< its standard error, by comparing contacts
  int error = 0;               ///< grey levels within which the share asked for is
  double seconds_once = 0;     ///< an estimate, for what is computed once
  double seconds_a_frame = 0;  ///< an estimate
  /// Operations, as estimated from sizes, for what is computed once and the request's frames.
  double cost = 0;
  std::vector<SensorPlanStep> steps;  ///< the choices one by one
  std::string reason;                 ///< all of it in words
};

namespace detail {

inline void require_models(PlannedLight light, PlannedMembrane membrane) {
  require(light <= PlannedLight::geodesic, "light model ", int(light), " of 5");
  require(membrane <= PlannedMembrane::layer, "membrane model ", int(membrane), " of 3");
}

/// Chooses the cheapest chain that holds.
class SensorPlanner {
 public:
  SensorPlanner(const SensorAt& sensor_at, const SensorPlanRequest& request)
      : request_(checked(request)),
        trials_(sensor_at, request.reference_edge,
                {request.contact_radius, request.press_depth, request.contacts, request.seed},
                request.light, request.membrane, request.cancelled),
        costs_(trials_.sizes()) {}

  [[nodiscard]] SensorPlan plan() {
    const SensorChoice best = trials_.most_exact();
    if (!holds(best)) return refused(best, too_coarse(best));
    SensorChoice chosen = best;
    // From cheap to dear: the first that holds. Where one does not, nor does what is coarser in
    // all.
    std::vector<SensorChoice> failed;
    for (const SensorChoice& choice : by_cost(candidates(best))) {
      const auto is_no_better = [&](const SensorChoice& other) {
        return choice.is_no_more_exact_than(other);
      };
      if (std::any_of(failed.begin(), failed.end(), is_no_better)) continue;
      if (is_promising(choice, best) && holds(choice)) {
        chosen = choice;
        break;
      }
      failed.push_back(choice);
    }
    return is_too_slow(chosen) ? refused(chosen, too_slow(chosen)) : described(chosen, true);
  }

 private:
  static constexpr double operations_a_second = 2e9;
  // By how many standard errors the trials' share is to be beyond the one asked for.
  static constexpr double sureness = 2.5;

  [[nodiscard]] static const SensorPlanRequest& checked(const SensorPlanRequest& r) {
    require(r.tolerance >= 0 && std::isfinite(r.tolerance), "a tolerance of ", r.tolerance,
            " grey levels");
    require(r.share > 0 && r.share <= 1, "a share of ", r.share, " of the pixels");
    for (const double length : {r.contact_radius, r.press_depth, r.reference_edge}) {
      require(length > 0 && std::isfinite(length), "contacts of radius ", r.contact_radius,
              " and depth ", r.press_depth, ", with edges of ", r.reference_edge, " for reference");
    }
    require(r.frames_a_second >= 0 && std::isfinite(r.frames_a_second), r.frames_a_second,
            " frames a second");
    require(r.frames >= 0 && std::isfinite(r.frames), r.frames, " frames");
    require(r.slowness > 0 && std::isfinite(r.slowness), "a slowness of ", r.slowness);
    require(r.contacts >= 2, r.contacts, " contacts to try");
    require_models(r.light, r.membrane);
    return r;
  }

  [[nodiscard]] bool holds(const SensorChoice& choice) {
    const TrialErrors& errors = trials_.errors(choice);
    return errors.within(request_.tolerance) -
               sureness * errors.standard_error(request_.tolerance) >=
           request_.share;
  }
  // Whether the shares of the pixels that each choice alone loses may be lost together.
  [[nodiscard]] bool is_promising(const SensorChoice& choice, const SensorChoice& best) {
    const double of_best = trials_.errors(best).within(request_.tolerance);
    double left = of_best;
    for (const SensorTopic topic : all_topics) {
      SensorChoice alone = best;
      alone.take(topic, choice);
      left -= std::max(0.0, of_best - trials_.errors(alone).within(request_.tolerance));
      if (left < request_.share) return false;
    }
    return true;
  }
  [[nodiscard]] double seconds(double operations) const {
    return operations / operations_a_second * request_.slowness;
  }
  [[nodiscard]] double cost(const SensorChoice& choice) const {
    return costs_.once(choice) + request_.frames * costs_.frame(choice);
  }

  // What may be chosen: of each topic, what holds where all else is most exact.
  [[nodiscard]] std::vector<SensorChoice> candidates(const SensorChoice& best) {
    std::vector<SensorChoice> all{best};
    for (const SensorTopic topic : all_topics) {
      std::vector<SensorChoice> grown;
      for (const SensorChoice& alone : enough(topic, best)) {
        for (SensorChoice choice : all) {
          choice.take(topic, alone);
          grown.push_back(choice);
        }
      }
      all = std::move(grown);
    }
    return all;
  }

  // What holds of a topic, and may be worth it.
  [[nodiscard]] std::vector<SensorChoice> enough(SensorTopic topic, const SensorChoice& best) {
    if (topic == SensorTopic::light) return enough_lights(best);
    std::vector<SensorChoice> all;
    const std::vector<SensorChoice> choices = trials_.choices(topic);
    // One membrane model after the other.
    for (auto begin = choices.begin(), end = begin; begin != choices.end(); begin = end) {
      end = std::find_if(begin, choices.end(),
                         [&](const SensorChoice& other) { return !begin->has_same_model(other); });
      const std::vector<SensorChoice> some = fine_enough({begin, end});
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }

  // Of choices from coarse to fine, the first that holds and all that is finer: by halving.
  [[nodiscard]] std::vector<SensorChoice> fine_enough(std::vector<SensorChoice> choices) {
    if (!holds(choices.back())) return {};
    auto low = choices.begin(), high = choices.end() - 1;
    while (low != high) {
      const auto middle = low + (high - low) / 2;
      if (holds(*middle)) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    choices.erase(choices.begin(), low);
    return choices;
  }

  // Light models that hold and are cheaper than the right one, and that.
  [[nodiscard]] std::vector<SensorChoice> enough_lights(const SensorChoice& best) {
    std::vector<SensorChoice> choices;
    for (const SensorChoice& alone : trials_.choices(SensorTopic::light)) {
      const bool is_cheaper = costs_.once(alone) < costs_.once(best);
      if (alone == best || (is_cheaper && holds(alone))) choices.push_back(alone);
    }
    return choices;
  }

  // Those that are too slow come last, the fastest of them first.
  [[nodiscard]] std::vector<SensorChoice> by_cost(std::vector<SensorChoice> choices) const {
    std::stable_sort(choices.begin(), choices.end(),
                     [&](const SensorChoice& a, const SensorChoice& b) {
                       const bool slow_a = is_too_slow(a), slow_b = is_too_slow(b);
                       if (slow_a != slow_b) return slow_b;
                       return slow_a ? costs_.frame(a) < costs_.frame(b) : cost(a) < cost(b);
                     });
    return choices;
  }
  [[nodiscard]] bool is_too_slow(const SensorChoice& choice) const {
    return seconds(costs_.frame(choice)) * request_.frames_a_second > 1;
  }

  // --- words -------------------------------------------------------------------------------------

  [[nodiscard]] std::string too_coarse(const SensorChoice& best) {
    const TrialErrors& errors = trials_.errors(best);
    const int least = errors.level_of(request_.share, sureness);
    // A mesh's error falls with the square of its edges; that of rounding stays.
    const double edge =
        trials_.edge(best) * std::sqrt(std::max(0.5, request_.tolerance) / std::max(1, least)) / 2;
    return joined("even edges of ", two_digits(1e3 * trials_.edge(best)), " mm, light at every ",
                  "pixel and double keep ", two_digits(request_.tolerance), " grey levels for ",
                  percent(errors.within(request_.tolerance)),
                  " of the pixels only, not surely for ", percent(request_.share),
                  ": a tolerance of ", least, " is needed, or a reference with edges of ",
                  two_digits(1e3 * edge), " mm");
  }
  [[nodiscard]] std::string too_slow(const SensorChoice& chosen) const {
    const double takes = seconds(costs_.frame(chosen));
    return joined("the fastest that keeps ", two_digits(request_.tolerance),
                  " grey levels is estimated at ", two_digits(1 / takes), " frames a second, not ",
                  two_digits(request_.frames_a_second), ": a processor ",
                  two_digits(takes * request_.frames_a_second),
                  " times as fast is needed, or as many times fewer pixels");
  }
  [[nodiscard]] static std::string percent(double share) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.2f %%", 100 * share);
    return digits;
  }

  [[nodiscard]] SensorPlan refused(const SensorChoice& choice, std::string needed) {
    SensorPlan plan = described(choice, false);
    plan.needed = std::move(needed);
    plan.reason = plan.needed;
    return plan;
  }

  [[nodiscard]] SensorPlan described(const SensorChoice& choice, bool satisfies) {
    const TrialErrors& errors = trials_.errors(choice);
    SensorPlan plan;
    plan.satisfies = satisfies;
    plan.edge_length = trials_.edge(choice);
    plan.light = choice.light;
    plan.light_grid = choice.grid;
    plan.membrane = choice.membrane;
    plan.smoothing_sigma = choice.radius > 0 ? choice.sigma : 0;
    plan.smoothing_radius = choice.radius;
    plan.single_precision = choice.is_single;
    plan.share = errors.within(request_.tolerance);
    plan.share_error = errors.standard_error(request_.tolerance);
    plan.error = errors.level_of(request_.share, 0);
    plan.seconds_once = seconds(costs_.once(choice));
    plan.seconds_a_frame = seconds(costs_.frame(choice));
    plan.cost = cost(choice);
    for (const SensorTopic topic : all_topics) plan.steps.push_back(step(topic, choice));
    plan.reason =
        joined("of the pixels that ", request_.contacts, " contacts changed, ", percent(plan.share),
               " are within ", two_digits(request_.tolerance), " grey levels");
    for (const SensorPlanStep& one : plan.steps) plan.reason += "; " + one.reason;
    return plan;
  }

  [[nodiscard]] SensorPlanStep step(SensorTopic topic, const SensorChoice& chosen) {
    SensorChoice alone = trials_.most_exact();
    alone.take(topic, chosen);
    SensorPlanStep result;
    result.topic = name_of(topic);
    result.choice = trials_.words(topic, chosen);
    result.error = trials_.errors(alone).level_of(request_.share, 0);
    result.seconds = seconds(costs_.of(topic, chosen));
    result.reason =
        joined(result.topic, ": ", result.choice, ", off by ", result.error, " grey levels alone");
    if (topic == SensorTopic::smoothing) result.reason += beside(request_.membrane);
    // What is next cheaper, and how far that is off.
    std::optional<SensorChoice> cheaper;
    for (const SensorChoice& other : trials_.choices(topic)) {
      if (other.has_same(topic, chosen)) break;
      cheaper = other;
    }
    if (cheaper && trials_.is_known(*cheaper)) {
      result.reason += joined("; ", trials_.words(topic, *cheaper), " by ",
                              trials_.errors(*cheaper).level_of(request_.share, 0));
    }
    return result;
  }

  // What a membrane's error is against.
  [[nodiscard]] static std::string beside(PlannedMembrane right) {
    if (right != PlannedMembrane::gaussian) return joined(" from the ", name_of(right));
    return " from the preset's Gaussian (how far that is from the gel's elastic layer, a request "
           "with that membrane tells)";
  }

  SensorPlanRequest request_;
  SensorTrials trials_;
  SensorCosts costs_;
};

}  // namespace detail

/// Chooses the cheapest chain from mesh to image whose images are as good as asked for: how fine a
/// mesh, which light model and on how coarse a grid, which membrane model, or how the protrusion is
/// smoothed, and float or double.
///
/// Nothing is guessed: balls and boxes of the contacts' size are pressed in at places drawn by lot,
/// and rendered with each choice beside the reference: edges of `reference_edge`, the request's
/// light at every pixel, a Gaussian out to 6 sigma, double. Of all combinations of what holds
/// alone and is fast enough, by estimated cost, the first is taken that holds with 2.5 standard
/// errors to spare over the contacts.
///
/// As measured by `scene_benchmark --sensors=30 --seed=101` and 202, 303, 404 and 505 (fingers,
/// flat and bent pads of 96 x 72 pixels): of 150 sensors at random 143 could be planned for, the
/// share held in 136 over 40 contacts each that the planner had not tried; the other seven lost
/// less than twice the pixels that they may. None cost more than 1.5 times the cheapest choice in
/// hindsight, the dearest 1.41 times; with contacts drawn in another order three of 140 did,
/// the dearest 2.1 times. A GelTip of 640 x 480 takes 0.4 to 0.6 s to plan, 1.3 s where
/// light through the gel is the right one; a GelSight Mini of that size 1.3 s where the elastic
/// layer is the right membrane, a sensor that is not flat more, since there each contact is pressed
/// anew on each mesh that is tried.
///
/// Throws InvalidInput for no sensor, as the sensor does at `reference_edge`, for a request with a
/// number or model that cannot be, where contacts of that size show in fewer than 16 pixels, and
/// for contacts that would reach behind the camera; Cancelled where the hook says so. What cannot
/// be satisfied is no error: the plan says so, and what is needed.
[[nodiscard]] inline SensorPlan plan_sensor(const SensorAt& sensor_at,
                                            const SensorPlanRequest& request = {}) {
  detail::require(sensor_at != nullptr, "there is no sensor to plan");
  return detail::SensorPlanner(sensor_at, request).plan();
}

namespace detail {

/// The membrane that a plan has chosen, for what the camera sees of it at rest.
template <std::floating_point T>
[[nodiscard]] AnyPlannedMembrane<T> planned_membrane(const SensorPreset<double>& sensor,
                                                     const Raster<double>& rest,
                                                     const SensorPlan& plan) {
  if (plan.membrane == PlannedMembrane::gaussian) {
    return AnyPlannedMembrane<T>(
        GaussianMembrane<T>(plan.smoothing_radius == 0 ? 0 : plan.smoothing_sigma,
                            plan.smoothing_radius, sensor.options.clip_to_rest));
  }
  return gel_membrane<T>(plan.membrane, sensor.camera, rest_of<T>(rest),
                         mean_rest(rest_of<double>(rest)), sensor.gel, {});
}

/// The same as the type asked for.
template <std::floating_point T, class Membrane>
[[nodiscard]] Membrane membrane_as(AnyPlannedMembrane<T> membrane, const SensorPlan& plan) {
  if constexpr (std::same_as<Membrane, AnyPlannedMembrane<T>>) {
    return membrane;
  } else {
    const auto* const chosen = std::get_if<Membrane>(&membrane.model());
    require(chosen != nullptr, "the plan's membrane is the ", name_of(plan.membrane),
            ", the renderer's another: ask for one of AnyPlannedMembrane");
    return *chosen;
  }
}

}  // namespace detail

/// The renderer of a plan, for the same sensor: with T double, or float where the plan says
/// `single_precision`. Light is computed in double in either case. Its membrane is a Gaussian, with
/// which frames are fastest; where a request asked for another one than that,
///
///     planned_renderer<float, AnyPlannedMembrane<float>>(sensor, plan)
///
/// is right whatever the plan has chosen.
///
/// Throws InvalidInput for no sensor, for a plan that does not satisfy its request, with what
/// would, for float where the plan wants double, for another membrane than the plan's, for a light
/// grid or model that cannot be, and as the sensor's parts do. (Who wants what a plan chose in
/// spite of all says so by setting its `satisfies`.)
template <std::floating_point T, MembraneModel<T> Membrane = GaussianMembrane<T>>
[[nodiscard]] TactileRenderer<T, Membrane> planned_renderer(const SensorAt& sensor_at,
                                                            const SensorPlan& plan,
                                                            const CancelHook& cancelled = {}) {
  detail::require(sensor_at != nullptr, "there is no sensor to render");
  detail::require(plan.satisfies, "the plan does not satisfy its request: ",
                  plan.needed.empty() ? "it is none of plan_sensor's" : plan.needed);
  detail::require(plan.single_precision || sizeof(T) >= sizeof(double),
                  "the plan wants double, the renderer is of float");
  detail::require(plan.light_grid > 0, "the plan has light at every ", plan.light_grid, " pixels");
  detail::require_models(plan.light, plan.membrane);
  const SensorPreset<double> sensor = sensor_at(plan.edge_length);
  const Raster<double> rest = rasterize(sensor.membrane, sensor.camera);
  detail::require_seen(rest);
  auto membrane =
      detail::membrane_as<T, Membrane>(detail::planned_membrane<T>(sensor, rest, plan), plan);
  const detail::MembraneLights model(sensor);
  const Window whole{0, 0, sensor.camera.width, sensor.camera.height};
  std::vector<Image<Vec3<double>>> fields;
  for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
    const auto done = static_cast<double>(k), of = static_cast<double>(sensor.leds.size());
    const Raster<double> coarse =
        plan.light_grid == 1
            ? rest
            : rasterize(sensor.membrane, detail::coarse_camera(sensor.camera, plan.light_grid));
    const auto field = bake(model.field(plan.light, k, pixel_points(coarse),
                                        cancelled.part(done / of, (done + 1) / of)),
                            coarse);
    fields.push_back(plan.light_grid == 1 ? field
                                          : detail::resized_window(field, sensor.camera, whole));
  }
  const detail::SensorChoice choice{0, plan.light, plan.light_grid, plan.smoothing_radius,
                                    plan.single_precision};
  const auto background = detail::seen_coating(sensor, model.surface(), sensor.camera, rest);
  return detail::renderer_of<T>(sensor, {sensor.camera, rest.depth, background}, fields, choice,
                                std::move(membrane));
}

}  // namespace gelight
