#pragma once

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

}  // namespace gelight
