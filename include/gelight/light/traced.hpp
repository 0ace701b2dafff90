#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/parallel.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/optics/boundary.hpp"
#include "gelight/light/traced/philox.hpp"
#include "gelight/light/traced/ray_scene.hpp"
#include "gelight/light/traced/tally.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/views/mesh_view.hpp"

// Opt-in: needs Embree 3 (doi:10.1145/2601097.2601199), and linking with it (-lembree3).
//
//         coating, albedo        ^ normals
//     ~~~~~~~~~~~~~~~~~~~~~~~~~~~~ membrane
//  LED>   gel, index, absorption
//     ---------------------------- layers[0].surface: Fresnel
//         layers[0].index
//     ---------------------------- layers[1].surface, and so on
//
// Light is traced from an LED through what a sensor is made of until it is absorbed or leaves.

namespace gelight {

/// What light meets in a gel and on its coating. The defaults are those of clear silicone under a
/// grey coating.
struct GelOptics {
  double index = 1.41;    ///< refractive, of the gel
  double absorption = 0;  ///< in the gel, per unit of the positions
  double albedo = 0.5;    ///< share of light that the coating reflects, diffusely (Lambert)
};

/// What lies beneath a gel, or beneath the layer above this one: a solid core, a tube, air.
struct InnerLayer {
  Surface<double> surface;  ///< where it begins, with normals towards the gel
  double index = 1;         ///< refractive, of what lies beyond: 1 is air
  double absorption = 0;    ///< there, per unit of the positions
};

/// The surface that lies `thickness` beneath each vertex of a membrane, along the mean normal of
/// its faces by area, numbered as the membrane is. Throws InvalidInput for a thickness that is not
/// positive and finite, a membrane that is not an oriented manifold, and where the membrane is
/// curved so much that a face would be turned over. Linear in the faces.
[[nodiscard]] inline Surface<double> beneath(const Surface<double>& membrane, double thickness) {
  using namespace detail::arithmetic;
  detail::require(thickness > 0 && std::isfinite(thickness), "a gel ", thickness, " thick");
  require_oriented(membrane);
  Mesh<double> mesh;
  for (Index v = 0; v < membrane.vertex_count(); ++v) {
    Vec3<double> sum(0, 0, 0);
    for (const Index h : membrane.corners(v)) sum += detail::face_normal(membrane, h / 3);
    const Vec3<double> p = membrane.position(v) - thickness * detail::direction_of(sum);
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (Index f = 0; f < membrane.face_count(); ++f) mesh.faces.push_back(membrane.face(f));
  Surface<double> inner(mesh);
  for (Index f = 0; f < membrane.face_count(); ++f) {
    const Vec3<double> above = detail::face_normal(membrane, f);
    detail::require(above.isZero(0) || dot(detail::face_normal(inner, f), above) > 0, "a gel ",
                    thickness, " thick is thicker than face ", f, " of the membrane is curved");
  }
  return inner;
}

/// A round LED that shines into a gel through its rim, or from anywhere inside a sensor.
struct TracedLed {
  Vec3<double> place{0, 0, 0};  ///< its middle
  Vec3<double> axis{0, 0, 1};   ///< where it shines, of any length
  double radius = 0;            ///< of its disc, which is at right angles to the axis
  double power = 1;             ///< W, or any other unit
  /// Its radiant intensity is that along the axis times the cosine of the angle to it to this
  /// power: 1 is Lambert's, 0 is the same all over the half-space, larger ones are narrow.
  double narrowness = 1;
  /// Whether air is between it and what it shines into, so that its light is refracted and partly
  /// reflected on entering, by a plane at right angles to the axis.
  bool behind_air = false;
  Index layer = 0;  ///< into which it shines: 0 is the gel, k is beneath layer k
};

/// How light is traced.
struct TraceOptions {
  std::int64_t paths = 1 << 20;  ///< from the LED; shared out evenly among 64 batches, rounded up
  std::uint64_t seed = 1;        ///< the same seed draws the same paths
  int longest = 1000;            ///< boundaries that a path meets before it is cut off
  unsigned threads = 1;    ///< 0: as many as the machine has; no bit of the answer depends on it
  CancelHook cancelled{};  ///< asked while rays are traced
};

/// Where light ended, as shares of the LED's power; they sum to 1 but for the error of chance.
struct LightBalance {
  double coating = 0;  ///< absorbed by the coating
  double gel = 0;      ///< absorbed in the gel and the layers
  /// Reflected on entering, gone through an open rim, the base or the open end of the hollow.
  double lost = 0;
  double cut = 0;       ///< still under way when cut off
  double segments = 0;  ///< straight pieces traced in all; no share
};

/// The light of one LED on the membrane, at each vertex as the mean over its faces weighted by its
/// barycentric coordinate, with standard errors beside (one sigma, by comparing 64 batches).
struct TracedLight {
  std::vector<double> irradiance;        ///< power that arrives over area
  std::vector<double> irradiance_error;  ///< its standard error
  /// Mean direction in which the arriving power travels: unit, or zero where none arrives.
  LightField<double> direction;
  std::vector<double> direction_error;  ///< radians; infinite where fewer than 8 batches came
  /// Length of that mean before it is made a unit: 1 is a single ray, 0 light from all sides.
  std::vector<double> directed;
  std::vector<double> directed_error;  ///< infinite where fewer than 8 batches came
  /// Radiance times the direction of travel, over all directions: its scalar product with a unit
  /// normal is the irradiance there, and with a slightly tilted one that of a tilted membrane, so
  /// that diffuse shading by it is right. (Within 0.06 degrees of grazing it counts short.)
  LightField<double> vector;
  std::vector<double> vector_error;  ///< root of the sum of its numbers' variances
  LightBalance balance;              ///< where the light ended
  LightBalance balance_error;        ///< its standard error
};

/// The way that light takes from an LED, from boundary to boundary.
struct TracedPath {
  std::vector<Vec3<double>> places;  ///< where it starts and what it meets, to within 1e-5 of all
  std::vector<Index> layers;  ///< of each straight piece: 0 through the gel, k beneath layer k
  /// Whether it left in the end; its last piece, into the open, has no end and is left out.
  bool is_lost = false;
};

/// Traces the light of LEDs through the gel of a sensor: refraction and total reflection where
/// layers meet (Fresnel, unpolarised), absorption, and a coating that reflects diffusely, so that
/// light also crosses a hollow and comes in again. What the light fields approximate, by brute
/// force.
///
/// Where layers meet their normals are taken as smooth across edges of less than 37 degrees;
/// where the coating reflects, faces are flat. Light that reaches the border of a surface leaves.
/// Rays start 2e-6 of the extent of all surfaces off the face that they leave: gel that is not
/// several times thicker lets its light out.
/// Const calls from several threads are fine.
class LightTracer {
 public:
  /// Of a membrane with normals outwards, away from the gel, and what lies beneath the gel, from
  /// outside to inside; without a layer, gel fills all. Throws InvalidInput for surfaces that are
  /// not oriented manifolds, indices that are not from 0.01 to 100, absorptions that are
  /// negative or not finite and an albedo outside 0 to 1; std::runtime_error and std::bad_alloc as
  /// Embree fails. O(n log n) in the faces.
  LightTracer(const Surface<double>& membrane, const GelOptics& gel,
              std::span<const InnerLayer> layers = {})
      : membrane_(membrane),
        albedo_(gel.albedo),
        media_(checked_media(gel, layers)),
        scene_(surfaces_of(membrane, layers)) {
    areas_.assign(static_cast<std::size_t>(membrane.vertex_count()), 0.0);
    for (Index f = 0; f < membrane.face_count(); ++f) {
      const double third = detail::stable_norm(detail::face_normal(membrane, f)) / 6;
      for (const Index v : membrane.face(f)) areas_[v] += third;
    }
  }

  /// The membrane that it was made of.
  [[nodiscard]] const Surface<double>& surface() const { return membrane_; }

  /// The light of an LED at every vertex of the membrane. An LED that is not in the layer it is
  /// said to shine into loses its light (`balance.lost`). Throws InvalidInput for an LED whose
  /// place is not finite or farther off than 1e4 times the extent of all surfaces, that has no
  /// axis, a negative size or power, a narrowness that is not from 0 to 1e100 or an unknown layer,
  /// and for no paths. Some 1e6 straight pieces a second and core; memory: 16 times 7 numbers a
  /// vertex.
  [[nodiscard]] TracedLight trace(const TracedLed& led, const TraceOptions& options = {}) const {
    check(led, options);
    const Emitter emitter = emitter_of(led);
    const std::int64_t each = (options.paths - 1) / batches + 1;
    const auto vertices = static_cast<std::size_t>(membrane_.vertex_count());
    std::vector<detail::VertexSums> sums(vertices);
    std::array<detail::Batch, at_once> round;
    std::vector<detail::Batch> ended;
    Watch watch{options.cancelled, batches * each};
    for (int first = 0; first < batches; first += at_once) {
      parallel_for(at_once, options.threads, [&](Index i) {
        auto& batch = round[static_cast<std::size_t>(i)];
        batch = {};
        batch.arrived.resize(vertices);
        run(emitter, options, (first + i) * each, each, batch, watch);
      });
      // In the order of the batches, whichever thread made them.
      for (const auto& batch : round) {
        for (std::size_t v = 0; v < vertices; ++v) sums[v].add(batch.arrived[v]);
        ended.push_back({{}, batch.ends, batch.segments});
      }
    }
    options.cancelled.check(1, what);
    return result(sums, ended, static_cast<double>(batches * each), led.power);
  }

  /// The first `options.paths` of those that `trace` follows, one by one: for pictures, and to see
  /// how light gets somewhere. On one thread. Throws InvalidInput as `trace` does. Memory: 28 bytes
  /// a straight piece.
  [[nodiscard]] std::vector<TracedPath> paths(const TracedLed& led,
                                              const TraceOptions& options = {}) const {
    check(led, options);
    const Emitter emitter = emitter_of(led);
    detail::Batch batch;
    batch.arrived.resize(static_cast<std::size_t>(membrane_.vertex_count()));
    std::vector<TracedPath> all;
    for (std::int64_t i = 0; i < options.paths; ++i) {
      options.cancelled.check(static_cast<double>(i) / static_cast<double>(options.paths), what);
      const auto number = static_cast<std::uint64_t>(i);
      Path path = emitted(emitter, options.seed, number, batch);
      batch.ends.lost = 0;  // not what is reflected on entering
      TracedPath way{{scene_.from_scene(path.place)}, {}};
      std::size_t medium = path.medium;
      follow(path, options, number, batch, [&] {
        way.is_lost = batch.ends.lost > 0;
        if (way.is_lost) return;
        way.places.push_back(scene_.from_scene(path.place));
        way.layers.push_back(static_cast<Index>(std::exchange(medium, path.medium)));
      });
      all.push_back(std::move(way));
    }
    return all;
  }

 private:
  static constexpr int batches = 64, at_once = 16;
  static constexpr const char* what = "tracing light";

  struct Medium {
    double index, absorption;
  };

  // An LED in the scene's coordinates, of unit power.
  struct Emitter {
    Vec3<double> place, axis, across, along;  // the last two as long as the disc's radius
    double exponent;                          // of a random number, to become a cosine
    double air_ratio;                         // of the indices before and beyond an air gap, or 0
    std::size_t medium;
  };

  // Whom to ask while tracing: the caller's thread does, the others follow.
  struct Watch {
    const CancelHook& hook;
    std::int64_t of;
    std::atomic<std::int64_t> done = 0;
    std::atomic<bool> ended = false;
    std::thread::id caller = std::this_thread::get_id();

    void add(std::int64_t paths) {
      const auto so_far = done += paths;
      if (!hook) return;
      if (ended) throw Cancelled("tracing light was cancelled");
      if (std::this_thread::get_id() != caller) return;
      try {
        hook.check(static_cast<double>(so_far) / static_cast<double>(of), what);
      } catch (...) {
        ended = true;
        throw;
      }
    }
  };

  struct Path {
    Vec3<double> place, way;
    double weight;
    std::size_t medium;
  };

  // A ray starts where single precision has a thousandth of the extent, or better.
  static constexpr double farthest_led = 1e4, narrowest = 1e100;

  static std::vector<Medium> checked_media(const GelOptics& gel,
                                           std::span<const InnerLayer> layers) {
    detail::require(gel.albedo >= 0 && gel.albedo <= 1, "albedo ", gel.albedo);
    std::vector<Medium> media{{gel.index, gel.absorption}};
    for (const auto& layer : layers) media.push_back({layer.index, layer.absorption});
    for (std::size_t k = 0; k < media.size(); ++k) {
      detail::require_index(media[k].index, detail::joined("layer ", k).c_str());
      detail::require(media[k].absorption >= 0 && std::isfinite(media[k].absorption), "layer ", k,
                      " has absorption ", media[k].absorption);
    }
    return media;
  }

  static std::vector<Surface<double>> surfaces_of(const Surface<double>& membrane,
                                                  std::span<const InnerLayer> layers) {
    std::vector<Surface<double>> surfaces{membrane};
    for (const auto& layer : layers) surfaces.push_back(layer.surface);
    for (const auto& surface : surfaces) require_oriented(surface);
    return surfaces;
  }

  void check(const TracedLed& led, const TraceOptions& options) const {
    detail::require(options.paths > 0, options.paths, " paths to trace");
    detail::require(options.longest > 0, "paths that are cut off after ", options.longest,
                    " boundaries");
    detail::require(detail::is_finite(led.place), "the LED is at (", led.place[0], ", ",
                    led.place[1], ", ", led.place[2], ")");
    detail::require(detail::is_finite(led.axis) && !led.axis.isZero(0), "the LED shines along (",
                    led.axis[0], ", ", led.axis[1], ", ", led.axis[2], ")");
    detail::require(led.radius >= 0 && std::isfinite(led.radius), "the LED has radius ",
                    led.radius);
    detail::require(led.power >= 0 && std::isfinite(led.power), "the LED has power ", led.power);
    detail::require(led.narrowness >= 0 && led.narrowness <= narrowest, "the LED has narrowness ",
                    led.narrowness, ", not from 0 to ", narrowest);
    const double off =
        scene_.to_scene(led.place).cwiseAbs().maxCoeff() + led.radius / scene_.scale();
    detail::require(off <= farthest_led || scene_.scale() == 0, "the LED at (", led.place[0], ", ",
                    led.place[1], ", ", led.place[2], ") is farther off than ", farthest_led,
                    " times the extent of all surfaces");
    detail::require(led.layer >= 0 && std::cmp_less(led.layer, media_.size()),
                    "the LED shines into layer ", led.layer, " of ", media_.size());
  }

  [[nodiscard]] Emitter emitter_of(const TracedLed& led) const {
    using namespace detail::arithmetic;
    const Vec3<double> axis = detail::stable_unit(led.axis);
    const Vec3<double> across = detail::unit_orthogonal(axis);
    const double radius = led.radius / scene_.scale();
    const auto medium = static_cast<std::size_t>(led.layer);
    return {scene_.to_scene(led.place),
            axis,
            radius * across,
            radius * cross(axis, across),
            1 / (led.narrowness + 1),
            led.behind_air ? 1 / media_[medium].index : 0,
            medium};
  }

  void run(const Emitter& emitter, const TraceOptions& options, std::int64_t first,
           std::int64_t count, detail::Batch& batch, Watch& watch) const {
    constexpr std::int64_t between_checks = 1024;
    for (std::int64_t i = 0; i < count; ++i) {
      const auto number = static_cast<std::uint64_t>(first + i);
      Path path = emitted(emitter, options.seed, number, batch);
      follow(path, options, number, batch, [] {});
      if ((i + 1) % between_checks == 0) watch.add(between_checks);
    }
    watch.add(count % between_checks);
  }

  // To its end, with a word after each straight piece.
  void follow(Path& path, const TraceOptions& options, std::uint64_t number, detail::Batch& batch,
              const auto& after_piece) const {
    for (int step = 0; path.weight > 0; ++step) {
      if (step == options.longest) {
        batch.ends.cut += path.weight;
        break;
      }
      advance(path, detail::uniforms(options.seed, number, static_cast<std::uint32_t>(step + 2)),
              batch);
      after_piece();
    }
  }

  // A path as it leaves the LED.
  static Path emitted(const Emitter& led, std::uint64_t seed, std::uint64_t number,
                      detail::Batch& batch) {
    using namespace detail::arithmetic;
    const auto where = detail::uniforms(seed, number, 0), way = detail::uniforms(seed, number, 1);
    const double radius = std::sqrt(where[0]), angle = 2 * std::numbers::pi * where[1];
    Path path{led.place + radius * (std::cos(angle) * led.across + std::sin(angle) * led.along),
              Vec3<double>(0, 0, 0), 1, led.medium};
    double cosine = std::pow(way[0], led.exponent);
    if (led.air_ratio > 0) {
      const auto at = detail::fresnel(cosine, led.air_ratio);
      batch.ends.lost += at.reflected;
      path.weight -= at.reflected;
      cosine = at.cosine_beyond;
    }
    path.way = detail::around_axis(led.axis, cosine, way[1]);
    return path;
  }

  // To the next boundary and what becomes of it there; weight 0 where the path ends.
  void advance(Path& path, const std::array<double, 4>& random, detail::Batch& batch) const {
    detail::RayScene::Hit hit;
    ++batch.segments;
    const bool is_hit = scene_.first_hit(path.place, path.way, hit);
    const bool outwards = is_hit && dot(path.way, scene_.normal(hit.surface, hit.face)) > 0;
    // A surface seen from the wrong side: the path left through an open border.
    if (!is_hit || path.medium + (outwards ? 0 : 1) != hit.surface) {
      batch.ends.lost += std::exchange(path.weight, 0);
      return;
    }
    const double absorption = media_[path.medium].absorption;
    if (absorption > 0) {
      const double taken = -path.weight * std::expm1(-absorption * hit.distance);
      batch.ends.gel += taken;
      path.weight = std::max(0.0, path.weight - taken);
    }
    if (hit.surface == 0) {
      coat(path, hit, random, batch);
    } else {
      cross_boundary(path, hit, outwards, random[0]);
    }
  }

  // Arrives at the coating, and is reflected diffusely.
  void coat(Path& path, const detail::RayScene::Hit& hit, const std::array<double, 4>& random,
            detail::Batch& batch) const {
    using namespace detail::arithmetic;
    const Vec3<double>& normal = scene_.normal(0, hit.face);
    constexpr double least_cosine = 1e-3;
    const double slant = 1 / std::max(least_cosine, dot(path.way, normal));
    const std::array<double, 3> shares{1 - hit.u - hit.v, hit.u, hit.v};
    const auto corners = membrane_.face(hit.face);
    for (std::size_t k = 0; k < 3; ++k) {
      auto& at = batch.arrived[static_cast<std::size_t>(corners[k])];
      const double power = path.weight * shares[k];
      at.power += power;
      at.way += power * path.way;
      at.vector += power * slant * path.way;
    }
    batch.ends.coating += (1 - albedo_) * path.weight;
    path.weight *= albedo_;
    // What is hardly worth following goes on at full weight now and then.
    constexpr double worth_following = 0.1;
    if (path.weight < worth_following) {
      path.weight = random[2] * worth_following < path.weight ? worth_following : 0;
    }
    path.way = detail::around_axis(-normal, std::sqrt(random[0]), random[1]);
    path.place = scene_.start(hit, path.way);
  }

  // Is reflected or refracted where two layers meet, by chance.
  void cross_boundary(Path& path, const detail::RayScene::Hit& hit, bool outwards,
                      double random) const {
    using namespace detail::arithmetic;
    const std::size_t beyond = outwards ? hit.surface - 1 : hit.surface;
    const double ratio = media_[path.medium].index / media_[beyond].index;
    const double sign = outwards ? -1 : 1;
    const Vec3<double> flat = sign * scene_.normal(hit.surface, hit.face);
    Vec3<double> way = path.way;
    bool passes = false;
    // A smooth normal may send a grazing ray to the wrong side of its flat face.
    const Vec3<double> smooth = sign * scene_.smooth_normal(hit);
    for (const Vec3<double>& normal : {smooth, flat}) {
      const double cosine = -dot(path.way, normal);
      if (cosine <= 0) continue;
      const auto at = detail::fresnel(std::min(1.0, cosine), ratio);
      passes = random >= at.reflected;
      way =
          passes ? detail::refract(path.way, normal, ratio, at) : detail::reflect(path.way, normal);
      if ((dot(way, flat) < 0) == passes) break;
    }
    path.way = way;
    path.place = scene_.start(hit, path.way);
    if (passes) path.medium = beyond;
  }

  [[nodiscard]] TracedLight result(const std::vector<detail::VertexSums>& sums,
                                   const std::vector<detail::Batch>& ended, double paths,
                                   double power) const {
    TracedLight light;
    for (Index v = 0; v < membrane_.vertex_count(); ++v) {
      const double area = areas_[v];
      add_vertex(sums[static_cast<std::size_t>(v)], area > 0 ? power / (paths * area) : 0, light);
    }
    const auto share = [&](double detail::Ends::*end, double LightBalance::*to) {
      double sum = 0, squares = 0;
      for (const auto& batch : ended) {
        sum += batch.ends.*end;
        squares += (batch.ends.*end) * (batch.ends.*end);
      }
      light.balance.*to = sum / paths;
      const double central = std::max(0.0, squares - sum * sum / batches);
      light.balance_error.*to = std::sqrt(central * batches / (batches - 1)) / paths;
    };
    share(&detail::Ends::coating, &LightBalance::coating);
    share(&detail::Ends::gel, &LightBalance::gel);
    share(&detail::Ends::lost, &LightBalance::lost);
    share(&detail::Ends::cut, &LightBalance::cut);
    for (const auto& batch : ended) light.balance.segments += batch.segments;
    return light;
  }

  // By the delta method from the covariance of power and direction.
  static void add_vertex(const detail::VertexSums& sums, double unit, TracedLight& light) {
    using namespace detail::arithmetic;
    const Eigen::Matrix4d covariance = sums.covariance(batches);
    const double power = sums.sum.power, length = norm(sums.sum.way);
    const Vec3<double> way = detail::direction_of(sums.sum.way);
    const Eigen::Matrix3d spread = covariance.bottomRightCorner<3, 3>();
    const double along = dot(way, spread * way);
    const double across = std::max(0.0, spread.trace() - along);
    light.irradiance.push_back(unit * power);
    light.irradiance_error.push_back(unit * std::sqrt(std::max(0.0, covariance(0, 0))));
    light.direction.push_back(way);
    // From fewer rays their spread is not known.
    constexpr int enough = 8;
    const bool is_known = sums.lit >= enough && length > 0;
    light.direction_error.push_back(is_known ? std::sqrt(across) / length : unreachable<double>);
    const double directed = power > 0 ? length / power : 0;
    const double with_power = dot(way, Vec3<double>(covariance.bottomLeftCorner<3, 1>()));
    const double variance =
        along - 2 * directed * with_power + directed * directed * covariance(0, 0);
    light.directed.push_back(directed);
    light.directed_error.push_back(is_known ? std::sqrt(std::max(0.0, variance)) / power
                                            : unreachable<double>);
    light.vector.push_back(unit * sums.sum.vector);
    light.vector_error.push_back(unit * sums.vector_error(batches));
  }

  Surface<double> membrane_;
  double albedo_;
  std::vector<Medium> media_;
  detail::RayScene scene_;
  detail::Array<double> areas_;  // of each vertex: the integral of its barycentric coordinate
};

}  // namespace gelight
