#pragma once

#include <cmath>
#include <concepts>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/geodesic/trace/straight_walk.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// `trace_geodesic` on a surface.
template <std::floating_point T>
auto traced_on(const Surface<T>& surface, const SurfacePoint<T>& point, const Vec3<T>& direction,
               T length, const CancelHook& cancelled) -> Path<T> {
  surface.require_point(point);
  require(is_finite(direction) && !direction.isZero(0), "the direction (", direction[0], ", ",
          direction[1], ", ", direction[2], ") is zero or not finite");
  require(length >= 0 && std::isfinite(length), "the length ", length,
          " is negative or not finite");
  cancelled.check(0, "tracing a geodesic");
  const SurfacePoint<T> from = simplified(surface, point);
  if (length == 0) return {from};
  return StraightWalk<T>(surface, from, static_cast<double>(length), cancelled).run(direction);
}

}  // namespace gelight::detail

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template Path<float> detail::traced_on(const Surface<float>&, const SurfacePoint<float>&,
                                       const Vec3<float>&, float, const CancelHook&);
template Path<double> detail::traced_on(const Surface<double>&, const SurfacePoint<double>&,
                                        const Vec3<double>&, double, const CancelHook&);
}  // namespace gelight
#endif
