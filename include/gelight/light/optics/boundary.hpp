#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

// A room of light/traced.hpp and light/gel.hpp: what becomes of a ray at a boundary. (Templates so
// that they cost nothing to include.)

namespace gelight::detail {

/// A direction at a cosine from a unit axis, turned about it by a share of a whole turn.
template <std::same_as<double> Real>
[[nodiscard]] Vec3<Real> around_axis(const Vec3<Real>& axis, Real cosine, double turn) {
  const Vec3<Real> x = unit_orthogonal(axis), y = cross(axis, x);
  const double angle = 2 * std::numbers::pi * turn;
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return cosine * axis + sine * (std::cos(angle) * x + std::sin(angle) * y);
}

/// Throws InvalidInput for a refractive index whose square and inverse say nothing, as that of no
/// gel does; `what` has it.
inline void require_index(double index, const char* what) {
  require(index >= 0.01 && index <= 100, what, " has refractive index ", index,
          ", not from 0.01 to 100");
}

/// What an unpolarised ray meets at a boundary between two media.
struct Boundary {
  double reflected = 1;                  ///< share of the light, by Fresnel; 1 in total reflection
  double cosine = 0, cosine_beyond = 0;  ///< of the angles to the normal, on both sides
};

/// For the cosine of incidence (0 to 1) and the index before over that beyond.
[[nodiscard]] inline Boundary fresnel(double cosine, double ratio) {
  const double sine_beyond_squared = ratio * ratio * (1 - cosine * cosine);
  if (sine_beyond_squared >= 1) return {1, cosine, 0};
  const double beyond = std::sqrt(1 - sine_beyond_squared);
  const double across = (ratio * cosine - beyond) / (ratio * cosine + beyond);
  const double along = (cosine - ratio * beyond) / (cosine + ratio * beyond);
  return {(across * across + along * along) / 2, cosine, beyond};
}

/// A unit direction reflected by a plane of this unit normal.
template <std::same_as<double> Real>
[[nodiscard]] Vec3<Real> reflect(const Vec3<Real>& way, const Vec3<Real>& normal) {
  return way - 2 * dot(way, normal) * normal;
}

/// A unit direction refracted; the normal is that on whose side the ray arrives.
template <std::same_as<double> Real>
[[nodiscard]] Vec3<Real> refract(const Vec3<Real>& way, const Vec3<Real>& normal, Real ratio,
                                 const Boundary& at) {
  return stable_unit(Vec3<Real>(ratio * way + (ratio * at.cosine - at.cosine_beyond) * normal));
}

}  // namespace gelight::detail
