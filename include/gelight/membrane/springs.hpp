#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
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
#include "gelight/membrane/springs/principal_axes.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/membrane/springs/taut_membrane.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// Solves a x = b for a symmetric, positive definite a, by elimination.
template <std::floating_point Real>
[[nodiscard]] Vec3<Real> solve_positive(const Eigen::Matrix<Real, 3, 3>& a, const Vec3<Real>& b) {
  const double p = a(1, 0) / a(0, 0), q = a(2, 0) / a(0, 0);
  const double middle = a(1, 1) - p * a(1, 0), side = a(2, 1) - p * a(2, 0), r = side / middle;
  const double last = a(2, 2) - q * a(2, 0) - r * side;
  const double y = b[1] - p * b[0], z = (b[2] - q * b[0] - r * y) / last;
  const double second = (y - side * z) / middle;
  return {(b[0] - a(1, 0) * second - a(2, 0) * z) / a(0, 0), second, z};
}

}  // namespace detail

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
  not_converged,  ///< the residuals tell how far it came
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
    Outcome outcome;
    outcome.equilibrium = hindrance(load, springs);
    if (outcome.equilibrium != Equilibrium::reached || load.force == 0) {
      // Where the object begins to touch.
      if (std::isfinite(springs.least_gap())) outcome.motion.offset = springs.least_gap();
      springs.press(contact.touching, outcome.motion);
    } else if (gel_.tension == 0) {
      outcome = equilibrate(springs, first_guess(springs, load), load, cancelled);
      springs.press(contact.touching, outcome.motion);
    } else {
      const double reach = std::sqrt(gel_.tension / gel_.stiffness());
      detail::TautMembrane membrane(springs, camera_.width, camera_.height, reach / column(),
                                    reach / row(), cancelled);
      const double guess = membrane.approach(sought(membrane, load), first_guess(springs, load));
      outcome = equilibrate(membrane, guess, load, {});
      membrane.write(contact.indentation, contact.touching);
    }
    report(contact, outcome, load);
    contact.unknown = springs.unknown();
    if (contact.unknown > 0) clear_unknown(contact, depth);
  }

  // What stands in the way of an equilibrium from the start.
  [[nodiscard]] static Equilibrium hindrance(const Load& load,
                                             const detail::LoneSprings<T>& springs) {
    if (load.force < 0) return Equilibrium::pull;
    if (load.force == 0) return Equilibrium::reached;
    if (!std::isfinite(springs.least_gap())) return Equilibrium::untouched;
    if (load.tilts && !detail::is_under_object(springs.rows(), load.centre.x(), load.centre.y())) {
      return Equilibrium::tips_over;
    }
    return Equilibrium::reached;
  }

  // The displacement without tilt under every eighth row and an eighth of the force: close to that
  // of all for an eighth of the work. From the deepest there can be, Newton's method comes down
  // step by step.
  [[nodiscard]] double first_guess(const detail::LoneSprings<T>& springs, const Load& load) const {
    constexpr Index step = 8;
    constexpr int most_steps = 50;
    const double wanted = load.force / spring() / step,
                 deepest = springs.least_gap() + gel_.thickness;
    double d = deepest;
    for (int i = 0; i < most_steps; ++i) {
      const auto s = springs.sums({d, 0, 0}, false, step);
      if (s.count == 0) return deepest;
      const double next = d + (wanted - s.load) / s.count;
      if (!(next < d)) break;
      d = next;
    }
    return d;
  }

  [[nodiscard]] Response response(const detail::SpringSums& s, const Load& load) const {
    Response r;
    r.load[0] = s.load;
    r.spread(0, 0) = s.count;
    if (!load.tilts) return r;
    const double size = half_image(), cx = load.centre.x(), cy = load.centre.y();
    r.load[1] = (s.x_load - cx * s.load) / size;
    r.load[2] = (s.y_load - cy * s.load) / size;
    const double x = s.x - cx * s.count, y = s.y - cy * s.count;
    r.spread(0, 1) = r.spread(1, 0) = x / size;
    r.spread(0, 2) = r.spread(2, 0) = y / size;
    r.spread(1, 1) = (s.xx - cx * s.x - cx * x) / (size * size);
    r.spread(2, 2) = (s.yy - cy * s.y - cy * y) / (size * size);
    r.spread(1, 2) = r.spread(2, 1) = (s.xy - cy * s.x - cx * y) / (size * size);
    return r;
  }

  [[nodiscard]] detail::RigidMotion motion(const Vec3<Real>& p, const Load& load) const {
    const double per_column = p[1] / half_image(), per_row = p[2] / half_image();
    return {p[0] - per_column * load.centre.x() - per_row * load.centre.y(), per_column, per_row};
  }

  // The load in units of a spring's stiffness. A force that presses everything in twice as far as
  // the gel is thick is as good as any more.
  template <class Springs>
  [[nodiscard]] double sought(const Springs& springs, const Load& load) const {
    return std::min(load.force / spring(), 2 * gel_.thickness * springs.most());
  }

  // Newton's method on the object's motion, from a displacement without tilt. The load less the
  // force is the slope of a convex, piecewise quadratic energy, which has a least value wherever
  // the force acts within the object. Full steps are taken while each leaves less than 0.9 of the
  // least residual so far, which cannot go on for ever; all others lower the energy by a share of
  // what their slope promises, so that they lead to the least energy on their own. (Nocedal,
  // Wright, Numerical Optimization, 2006, theorem 3.2, doi:10.1007/978-0-387-40065-5)
  template <class Springs>
  [[nodiscard]] Outcome equilibrate(Springs& springs, double displacement, const Load& load,
                                    const CancelHook& cancelled) const {
    using namespace detail::arithmetic;
    constexpr int most_steps = 200;
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
    const double wanted = sought(springs, load);
    const Vec3<Real> target(wanted, 0, 0);
    // Of a tilting object the moments, too, tell how near it is.
    springs.expect(load.tilts ? 0 : wanted);
    const auto at = [&](const Vec3<Real>& p) {
      return response(springs.sums(motion(p, load), load.tilts), load);
    };
    // Light loads are lost in the rounding of the places of the springs that bear them.
    const auto is_enough = [&](double residual, const Vec3<Real>& place, const Response& there) {
      const double stiffness = springs.stiffest() * std::max(1.0, there.spread(0, 0));
      return residual <=
             std::max(acceptable * wanted, rounding * place.template lpNorm<1>() * stiffness);
    };
    Vec3<Real> p(displacement, 0, 0), best = p;
    Response r = at(p), best_response = r;
    double least = norm(r.load - target);
    for (int step = 0; step < most_steps && least > Springs::accuracy * wanted; ++step) {
      cancelled.check(step / (step + 10.0), "pressing into springs");
      if (!springs.is_settled()) break;
      const bool is_near = is_enough(least, best, best_response);
      const Vec3<Real> start = p, direction = newton_step(springs, r, target, load);
      const double slope = dot(r.load - target, direction);
      p = start + direction;
      r = at(p);
      const bool is_shorter = norm(r.load - target) < 0.9 * least;
      if (!is_near && !is_shorter) descend(at, p, r, target, {start, direction, slope});
      const double residual = norm(r.load - target);
      if (is_near && residual >= least) break;  // by rounding
      if (residual >= least) continue;
      least = residual;
      best = p;
      best_response = r;
    }
    if (p != best) best_response = at(best);  // which leaves the springs there
    const bool is_there = springs.is_settled() && is_enough(least, best, best_response);
    Outcome outcome;
    outcome.equilibrium = is_there ? Equilibrium::reached : Equilibrium::not_converged;
    outcome.motion = motion(best, load);
    outcome.response = best_response;
    const double through = springs.deepest(outcome.motion) - gel_.thickness;
    if (through > acceptable * gel_.thickness) {
      outcome.equilibrium = Equilibrium::too_strong;
      outcome.motion.offset -= through;
      springs.expect(0);
      outcome.response = response(springs.sums(outcome.motion, load.tilts), load);
    }
    return outcome;
  }

  struct Line {
    Vec3<Real> start, direction;
    double slope;  // of the energy at the start, which is negative
  };

  // Moves p and its response, from the end of a line, to where the energy still falls along it, but
  // no more than half as steeply as at the start: longer than the line where it has to be.
  template <class At>
  void descend(const At& at, Vec3<Real>& p, Response& r, const Vec3<Real>& target,
               const Line& line) const {
    constexpr int most_tries = 120;
    constexpr double narrow = 1e-15;  // of a bracket: nothing is left between its ends
    double low = 0, high = std::numeric_limits<double>::infinity(), share = 1;
    double slope_low = line.slope, slope_high = 0;
    for (int i = 0; i < most_tries; ++i) {
      const double slope = dot(r.load - target, line.direction);
      if (slope <= 0 && slope >= 0.5 * line.slope) return;
      (slope > 0 ? high : low) = share;
      (slope > 0 ? slope_high : slope_low) = slope;
      if (std::isfinite(high) && high - low <= narrow * high) return;
      if (std::isinf(high)) {
        share *= 4;
      } else if (i % 2 == 0) {
        // To a quarter of the slope at the start, were it straight in between.
        const double between = (0.25 * line.slope - slope_low) / (slope_high - slope_low);
        share = low + std::clamp(between, 0.01, 0.99) * (high - low);
      } else {
        // The slope rises little before a spring is met, and much behind it: then halves are
        // faster.
        share = low + 0.5 * (high - low);
      }
      p = line.start + share * line.direction;
      r = at(p);
    }
  }

  // The step to where the load would be the target if no spring came or went. Motions that the
  // springs that bear do not resist, as where these stand on a line, need no step, or a long one:
  // till others bear. Neither is longer than the gel is thick.
  template <class Springs>
  [[nodiscard]] Vec3<Real> newton_step(Springs& springs, const Response& r,
                                       const Vec3<Real>& target, const Load& load) const {
    constexpr double share_of_resistance = 1e-12;
    const Vec3<Real> residual = r.load - target;
    const detail::PrincipalAxes<Real> principal = detail::principal_axes(r.spread);
    Matrix3 modes = Matrix3::Zero();
    std::array<detail::RigidMotion, 3> motions;
    Vec3<Real> free = Vec3<Real>(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<Real>& axis = principal.axes[k];
      const double spread = principal.values[k];
      if (spread > share_of_resistance * principal.values[2]) {
        const auto column = static_cast<Index>(k);
        modes.col(column) = axis / std::sqrt(spread);
        motions[k] = motion(modes.col(column), load);
      } else {
        free -= dot(axis, residual) * axis;
      }
    }
    const double unresisted = norm(free);
    const bool is_rounding = unresisted <= 0.5 * acceptable * std::max(target[0], r.load[0]);
    free *= is_rounding ? 0 : gel_.thickness / unresisted;
    // To move by a mode takes at least as much load along it: the matrix is far from singular.
    const Vec3<Real> shares =
        detail::solve_positive<Real>(springs.resistance(motions), modes.transpose() * residual);
    Vec3<Real> resisted = -(modes * shares);
    const double longest = resisted.template lpNorm<1>();
    if (longest > gel_.thickness) resisted *= gel_.thickness / longest;
    return resisted + free;
  }

  void report(SpringContact<T>& contact, const Outcome& outcome, const Load& load) const {
    using namespace detail::arithmetic;
    const detail::RigidMotion& motion = outcome.motion;
    const Vec3<Real> borne = spring() * outcome.response.load;
    contact.equilibrium = outcome.equilibrium;
    contact.force = borne[0];
    contact.residual_force = load.force - borne[0];
    contact.residual_moment = {half_image() * column() * borne[1], half_image() * row() * borne[2]};
    contact.tilt = {motion.per_column / column(), motion.per_row / row()};
    contact.displacement = motion.offset + motion.per_column * double{camera_.cx} +
                           motion.per_row * double{camera_.cy};
  }

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

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class SpringBed<float>;
GELIGHT_ONCE template class SpringBed<double>;
}  // namespace gelight
#endif
