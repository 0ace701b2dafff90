#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/calibrated.hpp"
#include "gelight/sensor/calibration/circle.hpp"
#include "gelight/sensor/calibration/smoothness.hpp"
#include "gelight/shading/fitted.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A photograph of a ball that is pressed into the gel.
struct BallPress {
  std::string name;        ///< what messages call it
  Image<Rgb8> photograph;  ///< of the background's size
  /// Where ball and gel touch, in pixels; all three 0: not known, to be searched for.
  Circle contact;
  double ball_radius = 0;  ///< in pixels
};

/// The reflectances that can be fitted.
enum class ReflectanceModel : std::uint8_t { lights, polynomial, table };

/// How a sensor is calibrated.
struct CalibrationOptions {
  /// Which reflectance to fit.
  ReflectanceModel model = ReflectanceModel::table;
  int lights = 5;             ///< how many near lights, 3 to 8
  int polynomial_degree = 3;  ///< in the normal
  int table_nodes = 9;        ///< along each coordinate of the normal, odd
  double bulge_length = 0;    ///< over which the slope decays around the contact, pixels; 0: fitted
  bool refine_circles = true;  ///< fit the circles, too, where they are marked
  CancelHook cancelled;        ///< asked some milliseconds apart
};

/// What a fit says of one press.
struct PressReport {
  /// As the press is named.
  std::string name;
  Change level{};  ///< by how much the whole photograph is brighter, grey levels
  Circle contact;  ///< as refined
  /// Standard deviations of its centre by the photograph's noise, pixels; 0: not refined.
  Vec2<double> doubt{0, 0};
  bool is_proposed = false;  ///< the circle was searched for
  bool fits = true;          ///< otherwise left out of the fit
  double residual = 0;       ///< mean absolute, out to 0.9 of the contact's radius, grey levels
};

/// The mean absolute difference of photographs and model in a part of the image, grey levels: of
/// the photographs that show some of it, and 0 where none does.
struct RegionResidual {
  /// Which pixels, in words.
  std::string region;
  double signal = 0;    ///< of the photographs and the background
  double residual = 0;  ///< of the photographs and the model
};

/// A calibrated sensor, and how sure it is.
struct Calibration {
  /// What a renderer takes.
  CalibratedSensor sensor;
  /// Standard deviation of the bulge's length in pixels by the noise of the photographs, from how
  /// fast the residual grows beside it, as though one residual in thirty were free; infinity where
  /// it does not, 0 for a given length. Circles that are marked beside their places, and light that
  /// is not as the model has it, put the length off by several times as much.
  double bulge_doubt = 0;
  detail::Smoothness smoothness;  ///< as chosen by cross-validation
  double held_out = 0;            ///< root mean square there, in the contact, grey levels
  /// Standard deviation of each coefficient of a table's or polynomial's touched gel, by leaving a
  /// third of the presses out in turn (the jackknife); empty for lights and for fewer than five.
  std::vector<double> spread;
  /// What was found of each press.
  std::vector<PressReport> presses;
  /// What is left unexplained, by region.
  std::vector<RegionResidual> regions;
  /// What a reader should know, in words.
  std::vector<std::string> warnings;
};

namespace detail {

/// Whether a press comes without its circle.
[[nodiscard]] inline bool has_no_circle(const BallPress& press) {
  return press.contact.x == 0 && press.contact.y == 0 && press.contact.radius == 0;
}

/// Throws InvalidInput, naming the press, unless it can be fitted or compared with.
GELIGHT_INLINE void require_press(const BallPress& press, const Image<Rgb8>& background);

}  // namespace detail

/// Fits a reflectance and the gel's bulge to photographs of a ball pressed into a flat sensor.
///
/// Inside its circle the gel has the ball's slope, outside of it that of a membrane under tension.
/// Touched and free gel are fitted apart, as they shine differently. Each photograph's level of
/// colour is taken off; how smooth a table or polynomial is, is chosen by leaving presses out; the
/// circles' centres are refined (from five presses on, their mean kept); what does not fit the
/// others is left out and named (from five presses on). Radii stay as they are marked.
///
/// Throws InvalidInput, naming the photograph, where there are no presses, sizes differ, a circle
/// lies outside of the image, is larger than its ball or leaves no gel far from it in the image, an
/// image is constant or a fifth of it saturated, a photograph differs from the background no more
/// inside of its circle than far from it, and for options out of range; Cancelled where the hook
/// says so. For a table some 1.2 seconds of work for 21 presses of 320 x 240 pixels, for lights 4
/// (g++ -O2). (The idea: Si, Yuan, Taxim: An Example-based Simulation Model for GelSight Tactile
/// Sensors, 2022, doi:10.1109/LRA.2022.3142412)
[[nodiscard]] GELIGHT_INLINE Calibration calibrate(const Image<Rgb8>& background,
                                                   std::span<const BallPress> presses,
                                                   const CalibrationOptions& options = {});

/// The photograph that a calibrated sensor would take of a ball pressed in: `level` grey levels
/// brighter. Throws InvalidInput for a sensor that write_sensor refuses, a circle that is none of
/// the ball's or has no place, a level that is not finite, a bulge longer than 1e4 pixels, and a
/// reflectance that is infinite or none at a pixel.
[[nodiscard]] GELIGHT_INLINE Image<std::array<double, 3>> predict(const CalibratedSensor& sensor,
                                                                  const Circle& contact,
                                                                  double ball_radius,
                                                                  const Change& level = {});

/// How high above rest the gel stands at the rim of a ball's contact, in pixels as all of it: so
/// much deeper than its cap a ball goes into a TensionMembrane of that length. Throws InvalidInput
/// for a circle that is none of the ball's, and a length that is negative or above 1e4.
[[nodiscard]] GELIGHT_INLINE double rim_height(double contact_radius, double ball_radius,
                                               double length);

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/sensor/calibration/body.hpp"
#endif
