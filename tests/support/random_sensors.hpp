#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/plan.hpp"
#include "gelight/sensor/presets/pad.hpp"

// Sensors and requests for a planner at random, and what its plans are worth on contacts that it
// has not seen: by the public renderers, and by all that it might have chosen.

namespace gelight::test {

using SensorRandom = std::mt19937;
inline double between(SensorRandom& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

/// A finger, a flat pad or a bent one, of random size, seen by a small camera.
inline SensorAt random_sensor(SensorRandom& random) {
  const auto kind = random() % 3;
  const double size = between(random, 0.8, 1.25), turn = between(random, 0, 2);
  const double sigma = between(random, 1.2, 2.5), bend = between(random, 0.03, 0.2);
  const double width = random() % 2 == 0 ? 0 : between(random, 0.001, 0.003);
  return [=](double edge) {
    SensorPreset<double> sensor;
    if (kind == 0) {
      sensor = geltip<double>(96, 72, edge);
      sensor.membrane = membrane<double>(0.01146 * size, 0.0455 * size, edge);
    } else {
      sensor = digit<double>(72, 96, edge);
      sensor.membrane = detail::pad<double>(0.02 * size, 0.03 * size, 0.022,
                                            kind == 1 ? unreachable<double> : bend, edge);
    }
    const std::vector<double> angles{turn, turn + 2, turn + 4.1};
    sensor.leds = points_of_border(sensor.membrane, angles);
    sensor.options.smoothing_sigma = sigma;
    sensor.led_width = width;
    return sensor;
  };
}

inline SensorPlanRequest random_request(SensorRandom& random) {
  SensorPlanRequest request;
  request.tolerance = static_cast<double>(3 + random() % 8);
  request.share = between(random, 0.9, 0.98);
  request.contact_radius = between(random, 0.002, 0.004);
  request.press_depth = request.contact_radius * between(random, 0.15, 0.3);
  request.reference_edge = 0.0009;
  request.seed = random();
  return request;
}

/// How many pixels contacts change, and how many of them are off by no more than a tolerance.
struct SeenPixels {
  double good = 0, all = 0;
  [[nodiscard]] double share() const { return good / all; }
};

/// A ball, or a box whose axis is up to some 0.1 radians off, in a membrane seen along a ray.
inline Mesh<double> random_object(SensorRandom& random, bool is_ball, double a, double d,
                                  const Vec3<double>& place, const Vec3<double>& out) {
  if (is_ball) {
    const double radius = (a * a + d * d) / (2 * d);
    return placed<double>(icosphere<double>(4, radius), Eigen::Matrix3d::Identity(),
                          place + (radius - d) * out);
  }
  const Vec3<double> lean{between(random, -0.1, 0.1), between(random, -0.1, 0.1),
                          between(random, -0.1, 0.1)};  // in braces: drawn in this order
  const Vec3<double> z = detail::direction_of<double>(out + lean);
  const Vec3<double> u = detail::unit_orthogonal(z), v = cross(z, u);
  Eigen::Matrix3d frame;
  frame << u, v, z;
  const double side = 1.41 * a;
  const Mesh<double> box_of = placed<double>(box(side, side, side), frame, {0, 0, 0});
  double lowest = 0;
  for (const auto& p : box_of.positions) {
    lowest = std::min(lowest, Vec3<double>(p[0], p[1], p[2]).dot(out));
  }
  return placed<double>(box_of, Eigen::Matrix3d::Identity(), place - (d + lowest) * out);
}

/// Whole frames of a plan's renderer beside those of another one, which is right.
template <class Reference, std::floating_point T, class Membrane>
SeenPixels seen_beside(const SensorAt& sensor_at, const SensorPlanRequest& request,
                       const Reference& reference, const TactileRenderer<T, Membrane>& planned,
                       int contacts, SensorRandom& random) {
  const auto sensor = sensor_at(request.reference_edge);
  const auto rest = rasterize(sensor.membrane, sensor.camera);
  const Surface<double> surface(sensor.membrane);
  SeenPixels seen;
  for (int i = 0; i < contacts; ++i) {
    const auto x = static_cast<Index>(random() % static_cast<unsigned>(sensor.camera.width));
    const auto y = static_cast<Index>(random() % static_cast<unsigned>(sensor.camera.height));
    const Index face = rest.face(x, y);
    if (face < 0) continue;
    const Vec3<double> ray = sensor.camera.ray(x, y);
    Vec3<double> out = detail::direction_of(detail::face_normal(surface, face));
    if (out.dot(ray) < 0) out = -out;
    const auto object = random_object(random, i % 2 == 0, request.contact_radius,
                                      request.press_depth, rest.depth(x, y) * ray, out);
    const auto depth = rasterize(object, sensor.camera).depth;
    const auto truth = reference.render(depth);
    const auto ours = planned.render(detail::rounded<T>(depth));
    for (std::size_t k = 0; k < ours.pixels().size(); ++k) {
      const Rgb8 &one = ours.pixels()[k], &other = truth.pixels()[k];
      if (one == planned.rest_image().pixels()[k] && other == reference.rest_image().pixels()[k]) {
        continue;
      }
      int off = 0;
      for (std::size_t c = 0; c < 3; ++c)
        off = std::max(off, std::abs(int{one[c]} - int{other[c]}));
      seen.good += off <= request.tolerance ? 1 : 0;
      seen.all += 1;
    }
  }
  return seen;
}

/// Through the public renderers, whole frames, beside light along exact geodesics at every pixel of
/// the fine mesh, or light through the gel where that is asked for, and a Gaussian out to 8 sigma.
inline SeenPixels seen_by(const SensorAt& sensor_at, const SensorPlanRequest& request,
                          const SensorPlan& plan, int contacts, SensorRandom& random) {
  auto sensor = sensor_at(request.reference_edge);
  sensor.options.smoothing_radius =
      static_cast<Index>(std::ceil(8 * sensor.options.smoothing_sigma));
  const auto reference = request.light == PlannedLight::gel
                             ? tactile_renderer(sensor, gel_light(sensor))
                             : tactile_renderer(sensor);
  const auto beside = [&](const auto& planned) {
    return seen_beside(sensor_at, request, reference, planned, contacts, random);
  };
  return plan.single_precision ? beside(planned_renderer<float>(sensor_at, plan))
                               : beside(planned_renderer<double>(sensor_at, plan));
}

/// What the cheapest of all that a planner chooses among costs that keeps the request on other
/// contacts than the planner's, without a margin; looked for no farther than `most` and infinite
/// where there is none below.
inline double cheapest_in_hindsight(const SensorAt& sensor_at, const SensorPlanRequest& request,
                                    std::uint64_t seed, double most) {
  detail::SensorTrials trials(sensor_at, request.reference_edge,
                              {request.contact_radius, request.press_depth, 12, seed},
                              request.light, request.membrane, {});
  const detail::SensorCosts costs(trials.sizes());
  const auto cost = [&](const detail::SensorChoice& choice) {
    return costs.once(choice) + request.frames * costs.frame(choice);
  };
  std::vector<detail::SensorChoice> all{trials.most_exact()};
  for (const auto topic : detail::all_topics) {
    std::vector<detail::SensorChoice> grown;
    for (auto choice : all) {
      for (const auto& alone : trials.choices(topic)) {
        choice.take(topic, alone);
        grown.push_back(choice);
      }
    }
    all = grown;
  }
  std::sort(all.begin(), all.end(),
            [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
  const auto holds = [&](const detail::SensorChoice& choice) {
    return trials.errors(choice).within(request.tolerance) >= request.share;
  };
  for (const auto& choice : all) {
    if (cost(choice) >= most) break;
    // Only what holds alone can hold together: most fail at the first.
    const bool may_hold = std::all_of(detail::all_topics.begin(), detail::all_topics.end(),
                                      [&](const detail::SensorTopic topic) {
                                        auto alone = trials.most_exact();
                                        alone.take(topic, choice);
                                        return holds(alone);
                                      });
    if (may_hold && holds(choice)) return cost(choice);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace gelight::test
