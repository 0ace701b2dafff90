#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "gelight/concepts/light.hpp"
#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/gel.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/led.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/transport/vector_heat.hpp"

// The light models, behind one door: each is made of a membrane once, and asked for the light
// of one LED after the other. `field` gives directions; `rays` also the length of the way and how
// the light comes. Both throw InvalidInput for an LED without a point and for points that are not
// of the membrane.
namespace gelight {

/// Where light enters a membrane: the one kind of source of all light models.
template <std::floating_point T>
struct Led {
  /// Where on the membrane: a point, or several along what is larger (`points_along` makes them of
  /// a path). Light comes from the nearest.
  std::vector<SurfacePoint<T>> points;
  /// Which way, for a model that keeps it (TransportLight): laid into the membrane's tangent plane,
  /// of any length. Zero: every way.
  Vec3<T> emission = Vec3<T>(0, 0, 0);
};

namespace detail {

template <std::floating_point T>
void require_led(const Led<T>& led) {
  require(!led.points.empty(), "the LED has no point");
  require(detail::is_finite(led.emission), "the LED's emission is (", led.emission.x(), ", ",
          led.emission.y(), ", ", led.emission.z(), "), not finite");
}

/// Six times the volume that a closed surface encloses, negative where its normals point into that;
/// 0 of one that has a border, which encloses none.
template <std::floating_point T>
[[nodiscard]] double enclosed_volume(const Surface<T>& surface) {
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    if (surface.is_border(h)) return 0;
  }
  // From a point of it, so that being far from the origin costs no digits; and in double, lest
  // products of floats vanish or overflow.
  const Vec3<double> from = cast<double>(surface.position(surface.face(0)[0]));
  const auto seen = [&](Index v) { return Vec3<double>(cast<double>(surface.position(v)) - from); };
  double volume = 0;
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = surface.face(f);
    volume += dot(seen(a), cross(seen(b), seen(c)));
  }
  return volume;
}

}  // namespace detail

/// Light that travels straight through space, whatever stands between: see `linear_field`.
template <std::floating_point T>
class LinearLight {
 public:
  /// Whether light runs in the membrane, so that at rest it is tangent to it.
  static constexpr bool is_tangent = false;

  /// Throws InvalidInput as Surface does.
  explicit LinearLight(const TriangleMesh auto& membrane) : surface_(membrane) {}

  /// See the top of the page.
  ///@{
  [[nodiscard]] LightField<T> field(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                    const CancelHook& cancelled = {}) const {
    return rays(led, points, cancelled).direction;
  }
  [[nodiscard]] LightRays<T> rays(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                  const CancelHook& cancelled = {}) const {
    detail::require_led(led);
    return linear_rays<T>(positions(led.points), positions(points), cancelled);
  }
  ///@}

 private:
  [[nodiscard]] std::vector<Vec3<T>> positions(std::span<const SurfacePoint<T>> points) const {
    std::vector<Vec3<T>> result;
    result.reserve(points.size());
    for (const auto& point : points) result.push_back(surface_.position(point));
    return result;
  }

  Surface<T> surface_;
};

/// Light that stays in a plane through the LED and its normal: see `plane_field`.
template <std::floating_point T>
class PlaneLight {
 public:
  /// Whether light runs in the membrane, so that at rest it is tangent to it.
  static constexpr bool is_tangent = true;

  /// Throws InvalidInput as Surface does.
  explicit PlaneLight(const TriangleMesh auto& membrane) : surface_(membrane) {}

  /// See the top of the page.
  ///@{
  [[nodiscard]] LightField<T> field(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                    const CancelHook& cancelled = {}) const {
    detail::require_led(led);
    if (led.points.size() == 1) return plane_field(surface_, led.points[0], points, cancelled);
    return rays(led, points, cancelled).direction;
  }
  [[nodiscard]] LightRays<T> rays(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                  const CancelHook& cancelled = {}) const {
    detail::require_led(led);
    return plane_rays(surface_, led.points, points, T(1e-6), cancelled);
  }
  ///@}

 private:
  Surface<T> surface_;
};

/// Light that follows the shortest paths on the membrane: see `geodesic_field`.
template <std::floating_point T>
class GeodesicLight {
 public:
  /// Whether light runs in the membrane, so that at rest it is tangent to it.
  static constexpr bool is_tangent = true;

  /// Throws InvalidInput as ExactSolver does.
  explicit GeodesicLight(const TriangleMesh auto& membrane) : solver_(membrane) {}

  /// See the top of the page.
  ///@{
  [[nodiscard]] LightField<T> field(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                    const CancelHook& cancelled = {}) const {
    detail::require_led(led);
    return geodesic_field(solver_, as_sources(led.points), points, cancelled);
  }
  [[nodiscard]] LightRays<T> rays(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                  const CancelHook& cancelled = {}) const {
    detail::require_led(led);
    return geodesic_rays(solver_, as_sources(led.points), points, T(1e-6), cancelled);
  }
  ///@}

 private:
  ExactSolver<T> solver_;
};

/// Light that keeps its direction as far as the membrane lets it: see `transport_field`. Without an
/// emission it leaves the LED, which is one point then, in all directions, as GeodesicLight has
/// them exactly.
template <std::floating_point T>
class TransportLight {
 public:
  /// Whether light runs in the membrane, so that at rest it is tangent to it.
  static constexpr bool is_tangent = true;
  /// Whether light without an emission leaves vertices only.
  static constexpr bool leaves_vertices = true;

  /// Throws InvalidInput as VectorHeatSolver does.
  explicit TransportLight(const TriangleMesh auto& membrane) : solver_(membrane) {}

  /// See the top of the page. Throws InvalidInput also for several points without an emission, and
  /// for one that is not a vertex.
  [[nodiscard]] LightField<T> field(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                    const CancelHook& cancelled = {}) const {
    detail::require_led(led);
    if (!led.emission.isZero(0)) {
      std::vector<VectorSource<T>> sources;
      for (const auto& point : led.points) sources.push_back({point, led.emission});
      return transport_field(solver_, sources, points, cancelled);
    }
    const auto& point = led.points[0];
    detail::require(led.points.size() == 1 && point.kind == SurfacePoint<T>::Kind::vertex,
                    "light that is carried every way needs an LED that is one vertex");
    return radial_transport_field(solver_, point.element[0], points, cancelled);
  }

 private:
  VectorHeatSolver<T> solver_;
};

/// The gel of a sensor, as its light sees it.
template <std::floating_point T>
struct GelSheet {
  T thickness = T(0.003);   ///< in the unit of the positions; air is behind it
  T full_within = T(0.01);  ///< the distance on an LED's axis within which its light is full
  T index = T(1.41);        ///< refractive
  /// Whether the membrane's normals point into the gel, rather than out of it.
  bool has_normals_inwards = false;
};

/// Light that goes straight through gel with air behind it, and across the hollow: see `gel_field`.
/// Its directions are shortened to the strength of the light, which falls off with the square of
/// the distance. An LED is in the middle of the gel beneath its points, shines along its emission,
/// and gives what its points give on average. Within faces and edges the membrane's normals are
/// those of the vertices (means by area) interpolated, so that light shows no facets.
template <std::floating_point T>
class GelLight {
 public:
  /// Whether light runs in the membrane, so that at rest it is tangent to it.
  static constexpr bool is_tangent = false;
  /// Whether an LED has to have an emission.
  static constexpr bool needs_emission = true;

  /// Of a membrane with normals outwards, unless `gel` says otherwise; where it has a border, that
  /// is taken on trust. Throws InvalidInput as Surface does, for one that is not an oriented
  /// manifold, for a closed one whose normals point the other way, for a size that is not positive
  /// and finite, and for an index that is not from 0.01 to 100.
  explicit GelLight(const TriangleMesh auto& membrane, const GelSheet<T>& gel = {})
      : surface_(membrane), gel_(gel) {
    for (const T value : {gel.thickness, gel.full_within}) {
      detail::require(value > 0 && std::isfinite(value), "a gel of thickness ", gel.thickness,
                      ", lit fully within ", gel.full_within);
    }
    detail::require_index(double{gel.index}, "the gel");
    require_oriented(surface_);
    // Gel fills a closed membrane: the other way, its light would be dark or come from behind.
    const double volume = detail::enclosed_volume(surface_);
    detail::require(gel.has_normals_inwards ? volume <= 0 : volume >= 0,
                    "a closed membrane has its normals ", volume < 0 ? "inwards" : "outwards",
                    ", and GelSheet::has_normals_inwards says otherwise");
    normals_.reserve(static_cast<std::size_t>(surface_.vertex_count()));
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      normals_.push_back(detail::direction_of(out_of_gel(vertex_point<double>(v))));
    }
  }

  /// See the top of the page. Throws InvalidInput also for an LED without an emission.
  [[nodiscard]] LightField<T> field(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                    const CancelHook& cancelled = {}) const {
    using namespace detail::arithmetic;
    detail::require_led(led);
    detail::require(!led.emission.isZero(0), "light in a gel needs an LED with an emission");
    std::vector<Vec3<double>> positions, normals;
    positions.reserve(points.size());
    normals.reserve(points.size());
    for (const auto& point : points) {
      const Point p = checked(point);
      positions.push_back(surface_.position(p));
      normals.push_back(normal(p));
    }
    LightField<double> sum(points.size(), Vec3<double>(0, 0, 0));
    const auto count = static_cast<double>(led.points.size());
    for (std::size_t k = 0; k < led.points.size(); ++k) {
      const auto done = static_cast<double>(k) / count;
      const auto one = gel_field<double>(source(led, checked(led.points[k])), positions, normals,
                                         cancelled.part(done, done + 1 / count));
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
    }
    const double full = double{gel_.full_within};
    LightField<T> field;
    field.reserve(sum.size());
    for (const Vec3<double>& light : sum) {
      const double strength = std::numbers::pi * full * full / count * detail::stable_norm(light);
      field.push_back(cast<T>(std::min(1.0, strength) * detail::direction_of(light)));
    }
    cancelled.check(1, "the gel field");
    return field;
  }

 private:
  // In double from the start: far from the origin, places in float have few digits left.
  using Point = SurfacePoint<double>;

  [[nodiscard]] Point checked(const SurfacePoint<T>& point) const {
    surface_.require_point(point);
    return point.template cast<double>();
  }

  [[nodiscard]] GelLed<double> source(const Led<T>& led, const Point& point) const {
    using namespace detail::arithmetic;
    const Vec3<double> normal = detail::direction_of(out_of_gel(point));
    const double thickness = double{gel_.thickness}, depth = thickness / 2;
    return {.place = surface_.position(point) - depth * normal,
            .axis = cast<double>(led.emission),
            .normal = normal,
            .depth = depth,
            .thickness = thickness,
            .index = double{gel_.index}};
  }

  [[nodiscard]] Vec3<double> normal(const Point& point) const {
    using namespace detail::arithmetic;
    Vec3<double> sum = Vec3<double>(0, 0, 0);
    std::array<Index, 3> vertices{point.element[0], point.element[1], -1};
    if (point.kind == Point::Kind::face) vertices = surface_.face(point.element[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      if (vertices[k] >= 0)
        sum += point.weights[k] * normals_[static_cast<std::size_t>(vertices[k])];
    }
    // Opposite normals, of a fold, say nothing between them.
    return sum.isZero(0) ? out_of_gel(point) : sum;
  }

  [[nodiscard]] Vec3<double> out_of_gel(const Point& point) const {
    const Vec3<double> normal = detail::mean_normal(surface_, point);
    return gel_.has_normals_inwards ? Vec3<double>(-normal) : normal;
  }

  Surface<double> surface_;
  GelSheet<T> gel_;
  std::vector<Vec3<double>> normals_;  // of the vertices, of unit length or zero
};

template <TriangleMesh M>
explicit LinearLight(const M&) -> LinearLight<MeshScalar<M>>;
template <TriangleMesh M>
explicit PlaneLight(const M&) -> PlaneLight<MeshScalar<M>>;
template <TriangleMesh M>
explicit GeodesicLight(const M&) -> GeodesicLight<MeshScalar<M>>;
template <TriangleMesh M>
explicit TransportLight(const M&) -> TransportLight<MeshScalar<M>>;
template <TriangleMesh M>
explicit GelLight(const M&) -> GelLight<MeshScalar<M>>;
template <TriangleMesh M, std::floating_point T>
explicit GelLight(const M&, GelSheet<T>) -> GelLight<MeshScalar<M>>;

}  // namespace gelight
