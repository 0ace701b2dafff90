#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>

#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/membrane/springs/principal_axes.hpp"
#include "gelight/membrane/springs/spring_sums.hpp"
#include "gelight/membrane/springs/taut_membrane.hpp"

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

template <std::floating_point T>
void SpringBed<T>::balance(SpringContact<T>& contact, detail::LoneSprings<T>& springs,
                           const Load& load, const CancelHook& cancelled) const {
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
}

// What stands in the way of an equilibrium from the start.
template <std::floating_point T>
Equilibrium SpringBed<T>::hindrance(const Load& load, const detail::LoneSprings<T>& springs) {
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
template <std::floating_point T>
double SpringBed<T>::first_guess(const detail::LoneSprings<T>& springs, const Load& load) const {
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

template <std::floating_point T>
auto SpringBed<T>::response(const detail::SpringSums& s, const Load& load) const -> Response {
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

template <std::floating_point T>
detail::RigidMotion SpringBed<T>::motion(const Vec3<Real>& p, const Load& load) const {
  const double per_column = p[1] / half_image(), per_row = p[2] / half_image();
  return {p[0] - per_column * load.centre.x() - per_row * load.centre.y(), per_column, per_row};
}

// The load in units of a spring's stiffness. A force that presses everything in twice as far as
// the gel is thick is as good as any more.
template <std::floating_point T>
template <class Springs>
double SpringBed<T>::sought(const Springs& springs, const Load& load) const {
  return std::min(load.force / spring(), 2 * gel_.thickness * springs.most());
}

// Newton's method on the object's motion, from a displacement without tilt. The load less the
// force is the slope of a convex, piecewise quadratic energy, which has a least value wherever
// the force acts within the object. Full steps are taken while each leaves less than 0.9 of the
// least residual so far, which cannot go on for ever; all others lower the energy by a share of
// what their slope promises, so that they lead to the least energy on their own. (Nocedal,
// Wright, Numerical Optimization, 2006, theorem 3.2, doi:10.1007/978-0-387-40065-5)
template <std::floating_point T>
template <class Springs>
auto SpringBed<T>::equilibrate(Springs& springs, double displacement, const Load& load,
                               const CancelHook& cancelled) const -> Outcome {
  using namespace detail::arithmetic;
  constexpr int most_steps = 200;
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  constexpr double most_lost = 0.01;  // by rounding, a share of the force
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
  // A residual that is rounding may still be all of a light load, in a coating that hardly bends;
  // the springs may have come to bear another than they did there before.
  const bool is_borne = norm(best_response.load - target) <= most_lost * wanted;
  const bool is_there = springs.is_settled() && is_enough(least, best, best_response) && is_borne;
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

// Moves p and its response, from the end of a line, to where the energy still falls along it, but
// no more than half as steeply as at the start: longer than the line where it has to be.
template <std::floating_point T>
template <class At>
void SpringBed<T>::descend(const At& at, Vec3<Real>& p, Response& r, const Vec3<Real>& target,
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
template <std::floating_point T>
template <class Springs>
auto SpringBed<T>::newton_step(Springs& springs, const Response& r, const Vec3<Real>& target,
                               const Load& load) const -> Vec3<Real> {
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

template <std::floating_point T>
void SpringBed<T>::report(SpringContact<T>& contact, const Outcome& outcome,
                          const Load& load) const {
  using namespace detail::arithmetic;
  const detail::RigidMotion& motion = outcome.motion;
  const Vec3<Real> borne = spring() * outcome.response.load;
  contact.equilibrium = outcome.equilibrium;
  contact.force = borne[0];
  contact.residual_force = load.force - borne[0];
  contact.residual_moment = {half_image() * column() * borne[1], half_image() * row() * borne[2]};
  contact.tilt = {motion.per_column / column(), motion.per_row / row()};
  contact.displacement =
      motion.offset + motion.per_column * double{camera_.cx} + motion.per_row * double{camera_.cy};
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class SpringBed<float>;
template class SpringBed<double>;
}  // namespace gelight
#endif
