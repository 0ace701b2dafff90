#pragma once

#include <cmath>

#include "gelight/core/error.hpp"

namespace gelight {

/// What a sensor's gel is made of: isotropic and linearly elastic, on a rigid base.
///
/// A bed of springs (`SpringBed`) reads modulus, thickness and tension: under every pixel stands a
/// spring (a Winkler foundation); with `tension` the coating couples each to its neighbours, so
/// that the gel bends around a contact. A layer (`ElasticLayer`) reads all but the tension.
struct Gel {
  double elastic_modulus = 1e5;  ///< Pa
  double poisson_ratio = 0.48;   ///< from 0 to 0.5, which changes no volume
  /// m; no object comes further into the gel. Infinite for a layer: a half-space.
  double thickness = 0.005;
  double friction = 0;  ///< of gel and object, Coulomb's; infinity: they stick together
  double tension = 0;   ///< of the coating, N/m

  /// Pressure over indentation of a bed of springs, in N/m^3.
  [[nodiscard]] double stiffness() const { return elastic_modulus / thickness; }
  /// In Pa.
  [[nodiscard]] double shear_modulus() const { return elastic_modulus / (2 + 2 * poisson_ratio); }
};

/// The standard deviation, in m, of the Gaussian whose normals around a ball come nearest to those
/// of an elastic layer, for a contact as large as the ball would have on a half-space (radius a,
/// m):
///     0.82 a / (1 + (2.1 + 1.7 (2 nu)^4) a^2 / h^2),
/// h the gel's thickness and nu its Poisson ratio.
///
/// Its normals are at most 0.03 degrees farther off on average than the best Gaussian's, for
/// presses of a tenth of a. What even that one is off there: 0.05 to 0.3 degrees for nu = 0.3 and
/// for h of 2 a and more; but a Gaussian cannot rise, as a gel does that keeps its volume: 0.5
/// to 2.5 degrees for nu of 0.45 to 0.5 and h of a / 2 and less, where a BulgingMembrane is better.
/// Throws InvalidInput for a radius that is not positive and finite, a thickness that is not
/// positive, and a Poisson ratio outside of [0, 0.5].
[[nodiscard]] inline double gaussian_sigma(const Gel& gel, double contact_radius) {
  detail::require(contact_radius > 0 && std::isfinite(contact_radius), "contact radius ",
                  contact_radius, " is not positive and finite");
  detail::require(gel.thickness > 0, "gel thickness ", gel.thickness, " is not positive");
  detail::require(gel.poisson_ratio >= 0 && gel.poisson_ratio <= 0.5, "Poisson ratio ",
                  gel.poisson_ratio, " is not between 0 and 0.5");
  const double slender = contact_radius / gel.thickness;  // 0: a half-space
  const double hold = 2.1 + 1.7 * std::pow(2 * gel.poisson_ratio, 4);
  return 0.82 * contact_radius / (1 + hold * slender * slender);
}

}  // namespace gelight
