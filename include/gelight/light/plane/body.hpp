#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/plane/plane_cut.hpp"
#include "gelight/light/plane/plane_sides.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
LightField<T> plane_field(const Surface<T>& surface, const SurfacePoint<T>& led,
                          const Vec3<T>& normal, PointSpan<T> points, const CancelHook& cancelled) {
  detail::require(detail::is_finite(normal) && !normal.isZero(0), "the normal at the LED is (",
                  normal[0], ", ", normal[1], ", ", normal[2], ")");
  detail::PlaneCut<T> cut(surface, led, normal);
  const detail::PlaneSides<T> sides(surface, cut, cancelled.part(0, 0.5));
  const CancelHook of_points = cancelled.part(0.5, 1);
  LightField<T> field;
  field.reserve(points.size());
  for (const auto& point : points) {
    detail::check_points(of_points, field.size(), points.size(), "the plane field");
    const Vec3<T> place = cut.local(surface.position(point));
    // Inside as `faces_at` has it: so light comes by the same face here as in plane_rays.
    const bool is_inside =
        point.kind == SurfacePoint<T>::Kind::face &&
        *std::min_element(point.weights.begin(), point.weights.end()) > detail::faces_at_snap<T>;
    using Side = typename detail::PlaneSides<T>::Side;
    const Side side = is_inside ? sides.side(point.element[0]) : Side::mixed;
    if (side == Side::along || side == Side::against) {
      field.push_back(cut.in_space(sides.direction(point.element[0], place)));
      continue;
    }
    const auto& arrivals = cut.arrive(point, place);
    field.push_back(arrivals.empty() ? Vec3<T>(0, 0, 0) : cut.in_space(arrivals[0].direction));
  }
  of_points.check(1, "the plane field");
  return field;
}

namespace detail {

template <std::floating_point T>
Vec3<T> mean_normal(const Surface<T>& surface, const SurfacePoint<T>& point) {
  using namespace detail::arithmetic;
  surface.require_point(point);
  using Real = std::common_type_t<T, double>;  // products of floats may vanish or overflow
  Vec3<Real> normal(0, 0, 0);
  for (const Index f : faces_at(surface, point)) normal += face_normal<T, Real>(surface, f);
  return cast<T>(scaled(normal).first);
}

}  // namespace detail

template <std::floating_point T>
LightRays<T> plane_rays(const Surface<T>& surface, PointSpan<T> led, PointSpan<T> points,
                        std::type_identity_t<T> tie, const CancelHook& cancelled) {
  detail::require(!led.empty(), "the LED has no point");
  detail::require(tie >= 0, "a tie of ", tie);
  using Cut = detail::PlaneCut<T>;
  std::vector<Vec3<T>> directions(points.size(), Vec3<T>(0, 0, 0));
  std::vector<T> least(points.size(), unreachable<T>), next = least;
  std::size_t done = 0;
  for (const auto& source : led) {
    const Vec3<T> normal = detail::mean_normal(surface, source);
    detail::require(!normal.isZero(0), "the LED's faces have no normal");
    Cut cut(surface, source, normal);
    for (std::size_t i = 0; i < points.size(); ++i) {
      detail::check_points(cancelled, done++, led.size() * points.size(), "the plane field");
      for (const auto& arrival : cut.arrive(points[i], cut.local(surface.position(points[i])))) {
        const Vec3<T> direction = cut.in_space(arrival.direction);
        // From the same point again, as of a closed line, is no tie.
        if (arrival.length == least[i] && direction == directions[i]) continue;
        next[i] = std::min(next[i], std::max(least[i], arrival.length));
        if (!(arrival.length < least[i])) continue;
        least[i] = arrival.length;
        directions[i] = direction;
      }
    }
  }
  LightRays<T> rays;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Lighting how = !(least[i] < unreachable<T>)      ? Lighting::dark
                         : least[i] == 0                   ? Lighting::at_led
                         : next[i] <= (1 + tie) * least[i] ? Lighting::ambiguous
                                                           : Lighting::lit;
    rays.add(directions[i], least[i], how);
  }
  cancelled.check(1, "the plane field");
  return rays;
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template LightField<float> plane_field(const Surface<float>&, const SurfacePoint<float>&,
                                       const Vec3<float>&, PointSpan<float>, const CancelHook&);
template Vec3<float> detail::mean_normal(const Surface<float>&, const SurfacePoint<float>&);
template LightRays<float> plane_rays(const Surface<float>&, PointSpan<float>, PointSpan<float>,
                                     float, const CancelHook&);
template LightField<double> plane_field(const Surface<double>&, const SurfacePoint<double>&,
                                        const Vec3<double>&, PointSpan<double>, const CancelHook&);
template Vec3<double> detail::mean_normal(const Surface<double>&, const SurfacePoint<double>&);
template LightRays<double> plane_rays(const Surface<double>&, PointSpan<double>, PointSpan<double>,
                                      double, const CancelHook&);
}  // namespace gelight
#endif
