#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "gelight/concepts/image.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
/// How a search for the equilibrium of gel and object ended.
enum class Equilibrium : std::uint8_t {
  reached,    ///< also by no force on no object
  untouched,  ///< a force, but no object in the image
  pull,       ///< the force leads away from the gel, which does not hold the object
  /// the object would go through the gel, which bears less than the force: told is where it is as
  /// deep in as the gel is thick, as tilted as that force would tilt it on deeper gel (or one that
  /// presses all in twice as deep as the gel is, where it is greater)
  too_strong,
  tips_over,      ///< the force acts beside the object
  not_converged,  ///< the residuals tell how far it came; also where rounding loses 1 % of a force
};

/// A rigid object in the gel.
template <std::floating_point T>
struct SpringContact {
  Equilibrium equilibrium = Equilibrium::reached;  ///< whether the rest holds
  /// How far the object moves from where it was seen, towards the camera, where the camera's axis
  /// meets the gel, m; and how much more with every metre along x and y.
  double displacement = 0;
  Vec2<double> tilt{0, 0};    ///< see displacement
  double force = 0;           ///< what the springs bear, N
  double residual_force = 0;  ///< what they were asked to bear less what they do, N
  /// The moments of what they bear about the line that the force acts along, sum of x and y times
  /// force, N m; zero where the object may not tilt.
  Vec2<double> residual_moment{0, 0};
  Image<T> indentation;          ///< of the gel's surface, m; NaN where the depth is not known
  Image<std::uint8_t> touching;  ///< 1 where object and gel touch
  Index unknown = 0;             ///< pixels without a known depth: nothing touches there
};

/// The flat gel of a sensor as a bed of springs, one for each pixel, across the camera's axis:
/// finds how deep a force presses a rigid object in that the camera sees.
///
/// Each spring stands for its pixel's area of gel, and what the camera sees there moves straight
/// towards it; its sideways shift by perspective, a share of indentation / depth, is left out
/// (where it matters, see the object again at its new place: the next displacement is then nearly
/// none). Tilts are taken as small. (Hogan, Jenkin, Rezaei-Shoshtari, Girdhar, Meger, Dudek, Seeing
/// Through your Skin, 2021, doi:10.1109/WACV48630.2021.00126)
template <std::floating_point T>
class SpringBed {
  using Real = std::common_type_t<T, double>;  // so that nothing is compiled unused
  using Matrix3 = detail::DoubleMatrix3<T>;

 public:
  /// `rest_depth` is the untouched gel's, in m. Throws InvalidInput for a camera that is not valid,
  /// a depth, modulus or thickness that is not positive and finite, and a negative tension.
  SpringBed(const Camera<T>& camera, T rest_depth, const Gel& gel = {})
      : camera_(camera), rest_(rest_depth), gel_(gel) {
    camera.require_valid();
    require_positive(static_cast<double>(rest_depth), "rest depth");
    require_positive(gel.elastic_modulus, "elastic modulus");
    require_positive(gel.thickness, "gel thickness");
    detail::require(gel.tension >= 0 && std::isfinite(gel.tension), "tension ", gel.tension,
                    " is negative or not finite");
  }

  /// What the bed was made of.
  ///@{
  [[nodiscard]] const Camera<T>& camera() const { return camera_; }
  [[nodiscard]] const Gel& gel() const { return gel_; }
  [[nodiscard]] T rest_depth() const { return rest_; }
  ///@}

  /// The area of gel that each spring stands for, m^2.
  [[nodiscard]] double spring_area() const { return column() * row(); }

  /// The equilibrium of a force (N, towards the gel) on an object that moves straight towards it.
  ///
  /// The force is a convex, piecewise linear, increasing function of the displacement: Newton's
  /// method ends after a few steps, exactly but for rounding (with tension: to 1e-9 of the force).
  /// Depths mean what image/mask.hpp says: at +infinity there is no object.
  /// Throws InvalidInput for a depth image of another size than the camera's and a force that is
  /// not finite, and Cancelled where `cancelled` says so, which is asked at every step, in a gel
  /// with tension after every sweep; whatever else stands in the way is told by `equilibrium`.
  template <ImageOf<T> D>
  [[nodiscard]] SpringContact<T> press(const D& depth, double force,
                                       const CancelHook& cancelled = {}) const {
    SpringContact<T> contact;
    solve(contact, depth, {force, {0, 0}, false}, cancelled);
    return contact;
  }

  /// The same into a contact whose images are used again. (They are worked in: should memory run
  /// out in a gel with tension, they hold something unfinished. Cancelled, it leaves them alone.)
  template <ImageOf<T> D>
  void press_into(SpringContact<T>& contact, const D& depth, double force,
                  const CancelHook& cancelled = {}) const {
    solve_into(contact, depth, {force, {0, 0}, false}, cancelled);
  }

  /// The equilibrium of a force that acts along the line parallel to the camera's axis through
  /// `centre` (x and y in the camera's frame, m), on an object that moves and tilts: force and two
  /// moments for three unknowns, by a semismooth Newton's method, to 1e-9 of the force or to
  /// rounding. About a line that all springs that bear lie on it does not tilt unless it must.
  /// Throws as press does, and for a centre that is not finite.
  template <ImageOf<T> D>
  [[nodiscard]] SpringContact<T> press_tilting(const D& depth, double force,
                                               const Vec2<double>& centre,
                                               const CancelHook& cancelled = {}) const {
    SpringContact<T> contact;
    solve(contact, depth, tilting_load(force, centre), cancelled);
    return contact;
  }

  /// The same into a contact whose images are used again.
  template <ImageOf<T> D>
  void press_tilting_into(SpringContact<T>& contact, const D& depth, double force,
                          const Vec2<double>& centre, const CancelHook& cancelled = {}) const {
    solve_into(contact, depth, tilting_load(force, centre), cancelled);
  }

  /// The depth of the gel's surface under a contact, in m: what a renderer is to be given. Throws
  /// InvalidInput for a contact of another size than the camera's image.
  [[nodiscard]] Image<T> depth(const SpringContact<T>& contact) const {
    detail::require_camera_size(contact.indentation, camera_, "the contact");
    Image<T> result = contact.indentation;
    for (T& z : result.pixels()) z = rest_ - z;
    return result;
  }

 private:
  struct Load {
    double force;         // N
    Vec2<double> centre;  // pixels
    bool tilts;
  };

  // The load on the object in units of a spring's stiffness, and the sums over the springs that
  // bear it of the products of 1, column and row, which are counted from the load's centre, in half
  // images.
  struct Response {
    Vec3<Real> load = Vec3<Real>(0, 0, 0);
    Matrix3 spread = Matrix3::Zero();
  };

  struct Outcome {
    Equilibrium equilibrium = Equilibrium::reached;
    detail::RigidMotion motion;
    Response response;
  };

  static constexpr double acceptable = 1e-9;  // the residual, as a share of the force

  static void require_positive(double value, const char* name) {
    detail::require(value > 0 && std::isfinite(value), name, ' ', value,
                    " is not positive and finite");
  }

  // The distances between springs, m, and a spring's stiffness, N/m.
  [[nodiscard]] double column() const { return double{rest_} / double{camera_.fx}; }
  [[nodiscard]] double row() const { return double{rest_} / double{camera_.fy}; }
  [[nodiscard]] double spring() const { return gel_.stiffness() * spring_area(); }
  [[nodiscard]] double half_image() const { return 0.5 * std::max(camera_.width, camera_.height); }

  [[nodiscard]] Load tilting_load(double force, const Vec2<double>& centre) const {
    detail::require(detail::is_finite(centre), "the force's centre (", centre.x(), ", ", centre.y(),
                    ") is not finite");
    const double x = centre.x() / column(), y = centre.y() / row();
    return {force, {x + double{camera_.cx}, y + double{camera_.cy}}, true};
  }

  // Work that may be cancelled is done beside the contact.
  template <class D>
  void solve_into(SpringContact<T>& contact, const D& depth, const Load& load,
                  const CancelHook& cancelled) const {
    if (!cancelled) return solve(contact, depth, load, cancelled);
    SpringContact<T> fresh;
    solve(fresh, depth, load, cancelled);
    contact = std::move(fresh);
  }

  template <class D>
  void solve(SpringContact<T>& contact, const D& depth, const Load& load,
             const CancelHook& cancelled) const {
    detail::require_camera_size(depth, camera_, "the depth image");
    detail::require(std::isfinite(load.force), "force ", load.force, " is not finite");
    if (contact.indentation.width() != camera_.width ||
        contact.indentation.height() != camera_.height) {
      contact.indentation = Image<T>(camera_.width, camera_.height);
    }
    if (contact.touching.width() != camera_.width || contact.touching.height() != camera_.height) {
      contact.touching = Image<std::uint8_t>(camera_.width, camera_.height);
    }
    detail::LoneSprings<T> springs(contact.indentation, depth, rest_);
    balance(contact, springs, load, cancelled);
    contact.unknown = springs.unknown();
    if (contact.unknown > 0) clear_unknown(contact, depth);
  }

  // The equilibrium of springs whose gaps stand in the contact's indentation.
  void balance(SpringContact<T>& contact, detail::LoneSprings<T>& springs, const Load& load,
               const CancelHook& cancelled) const;
  // What stands in the way of an equilibrium from the start.
  [[nodiscard]] static Equilibrium hindrance(const Load& load,
                                             const detail::LoneSprings<T>& springs);
  [[nodiscard]] double first_guess(const detail::LoneSprings<T>& springs, const Load& load) const;
  [[nodiscard]] Response response(const detail::SpringSums& s, const Load& load) const;
  [[nodiscard]] detail::RigidMotion motion(const Vec3<Real>& p, const Load& load) const;
  template <class Springs>
  [[nodiscard]] double sought(const Springs& springs, const Load& load) const;
  template <class Springs>
  [[nodiscard]] Outcome equilibrate(Springs& springs, double displacement, const Load& load,
                                    const CancelHook& cancelled) const;

  struct Line {
    Vec3<Real> start, direction;
    double slope;  // of the energy at the start, which is negative
  };

  // Moves p and its response, from the end of a line, to where the energy still falls along it, but
  // no more than half as steeply as at the start: longer than the line where it has to be.
  template <class At>
  void descend(const At& at, Vec3<Real>& p, Response& r, const Vec3<Real>& target,
               const Line& line) const;
  template <class Springs>
  [[nodiscard]] Vec3<Real> newton_step(Springs& springs, const Response& r,
                                       const Vec3<Real>& target, const Load& load) const;
  void report(SpringContact<T>& contact, const Outcome& outcome, const Load& load) const;

  template <class D>
  void clear_unknown(SpringContact<T>& contact, const D& depth) const {
    for (Index y = 0; y < camera_.height; ++y) {
      for (Index x = 0; x < camera_.width; ++x) {
        if (static_cast<T>(ImageTraits<D>::pixel(depth, x, y)) > 0) continue;
        contact.indentation(x, y) = std::numeric_limits<T>::quiet_NaN();
      }
    }
  }

  Camera<T> camera_;
  T rest_;
  Gel gel_;
};

template <std::floating_point T, class... Rest>
SpringBed(const Camera<T>&, const Rest&...) -> SpringBed<T>;

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/membrane/springs/body.hpp"
#endif
