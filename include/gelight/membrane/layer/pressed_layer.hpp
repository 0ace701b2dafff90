#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/membrane/fourier.hpp"
#include "gelight/membrane/layer/contact.hpp"
#include "gelight/membrane/layer/convolution.hpp"
#include "gelight/membrane/layer/green.hpp"
#include "gelight/membrane/springs.hpp"

namespace gelight::detail {

/// A rigid object as it stands past the layer at rest. Lengths in pixels' widths.
struct RigidObject {
  static constexpr double nothing = -std::numeric_limits<double>::infinity();

  Array<double> overlap;  ///< row after row; `nothing` where no object is known
  double deepest = nothing;
  Index x = 0, y = 0;  ///< where it is deepest
  Vec2<double> shift;  ///< how far it has moved sideways
  double twist = 0;    ///< and turned, about `axis`
  Vec2<double> axis;   ///< column and row

  /// The same object as it was pressed in.
  [[nodiscard]] RigidObject still() const {
    RigidObject result = *this;
    result.shift = Vec2<double>(0, 0);
    result.twist = 0;
    return result;
  }

  /// The same object tilted about its axis, by so much for every pixel along x and y.
  [[nodiscard]] RigidObject tilted(const Vec2<double>& tilt, const LayerGrid& grid) const {
    RigidObject result = *this;
    result.deepest = nothing;
    for (Index row = 0; row < grid.height; ++row) {
      for (Index column = 0; column < grid.width; ++column) {
        double& here = result.overlap[std::ptrdiff_t{row} * grid.width + column];
        here += tilt.x() * (column - axis.x()) + tilt.y() * grid.aspect * (row - axis.y());
        if (!(here > result.deepest)) continue;
        result.deepest = here;
        result.x = column;
        result.y = row;
      }
    }
    return result;
  }
};

/// Loads on a layer, in shear moduli, in a box of pixels, row after row; and how they came about.
struct LayerState {
  Box box;
  Array<double> pressure;
  Array<double> traction;                  ///< all along x, then all along y; empty: none
  double travel = 0;                       ///< of the object towards the layer
  Vec2<double> tilt = Vec2<double>(0, 0);  ///< how much more for every pixel along x and y
  double residual = 0;                     ///< see LayerContact
  Array<double> down;  ///< by them, of the whole image's pixels; empty: not found yet
};

/// The contact of a layer and a rigid object, in pixels' widths and shear moduli.
class PressedLayer {
 public:
  PressedLayer(const LayerGrid& grid, double friction, FourierBackend fourier)
      : grid_(grid), friction_(friction), fourier_(fourier) {}

  /// The contact of the object moved by `travel`, from a state to start with.
  [[nodiscard]] LayerState settle(const RigidObject& object, double travel, const LayerState& start,
                                  Effort& effort) const {
    LayerState state = settled(object, travel, start, effort);
    if (state.residual > effort.tolerance) ++effort.unsettled;
    return state;
  }

  /// The contact at which the layer bears a force, the sum of all pressures, to within the
  /// tolerance. None where the object would have to come through the layer.
  [[nodiscard]] std::optional<LayerState> balance(const RigidObject& object, double force,
                                                  const LayerState& start, Effort& effort) const {
    // Contacts so exact that what they leave does not hide the force.
    const double tolerance = effort.tolerance;
    effort.tolerance /= 5;
    std::optional<Borne> found = search(object.still(), force, tolerance, {start}, effort);
    // Friction changes the force a little and makes contacts dear, so it comes last.
    if (found && is_held(object)) found = search(object, force, tolerance, *found, effort);
    if (!found) return {};
    return std::move(found->state);
  }

  /// The contact at which the layer bears a force along a line through `centre`, in pixels' widths
  /// from the axis, by an object that tilts: the least value of a convex energy, whose slopes are
  /// force and two moments, by quasi-Newton steps (BFGS; Nocedal, Wright, Numerical Optimization,
  /// 2006, section 6.1, doi:10.1007/978-0-387-40065-5) from where springs would hold the object.
  /// None where it would have to come through the layer.
  [[nodiscard]] std::optional<LayerState> balance_tilting(const RigidObject& object, double force,
                                                          const Vec2<double>& centre,
                                                          const LayerState& start,
                                                          Effort& effort) const {
    constexpr int most_steps = 40;
    const double tolerance = effort.tolerance;
    const std::optional<LayerState> begin =
        is_held(object) ? balance_tilting(object.still(), force, centre, start, effort)
                        : near_balance(object, force, centre, start, effort);
    if (!begin) return {};
    effort.tolerance = tolerance / 20;
    const double press = object.tilted(begin->tilt, grid_).deepest + begin->travel;
    const double size = reach(*begin);
    // Motions from there in shares of the press, at the force's centre and at the contact's rim
    // around it.
    const auto at = [&](const Vec3<double>& place, const LayerState& from) {
      const Vec2<double> turned = Vec2<double>(place.y(), place.z()) * (press / size);
      const Vec2<double> tilt = begin->tilt + turned;
      const double travel = begin->travel + place.x() * press - dot(turned, centre);
      Balance there{place, {}, settle(object.tilted(tilt, grid_), travel, from, effort)};
      there.state.tilt = tilt;
      there.left = unbalanced(there.state, object, force, centre, size);
      return there;
    };
    Balance here = at(Vec3<double>(0, 0, 0), *begin);
    Eigen::Matrix3d yielding = first_yielding(here, at);
    for (int i = 0; i < most_steps && effort.goes_on(); ++i) {
      if (here.left.lpNorm<Eigen::Infinity>() <= tolerance) break;
      Vec3<double> step = -(yielding * here.left);
      if (!is_finite(step)) break;
      step *= std::min(1.0, 1 / step.lpNorm<Eigen::Infinity>());
      Balance next = at(here.place + step, here.state);
      if (!(norm(next.left) < 0.9 * norm(here.left))) next = descend(here, next, at, effort);
      yield_as(yielding, next.place - here.place, next.left - here.left);
      here = std::move(next);
    }
    effort.tolerance = tolerance;
    LayerState& state = here.state;
    if (object.tilted(state.tilt, grid_).deepest + state.travel >= grid_.thickness) return {};
    state.residual = std::max(state.residual, here.left.lpNorm<Eigen::Infinity>());
    return std::move(state);
  }

  /// The whole image's displacement: down, and where it is asked for along x, then along y.
  [[nodiscard]] Array<double> surface(const LayerState& state, bool sideways,
                                      Effort& effort) const {
    const std::size_t pixels = whole().area();
    Array<double> result((sideways ? 3 : 1) * pixels);
    if (state.box.area() == 0) return result;
    const bool is_held = !state.traction.empty(), is_found = !state.down.empty();
    if (is_found) std::copy(state.down.begin(), state.down.end(), result.begin());
    if (is_found && !sideways) return result;
    const Kernels k = kernels(state.box, whole(), !is_found, sideways || is_held);
    const Spectrum p = k.convolution.transform(state.pressure.data());
    Spectrum qx = k.convolution.zero(), qy = qx;
    if (is_held) {
      qx = k.convolution.transform(state.traction.data());
      qy = k.convolution.transform(state.traction.data() + state.box.area());
    }
    const auto add = [&](std::size_t component, const Term& pressed, const Term& x, const Term& y) {
      double* const to = result.data() + component * pixels;
      if (is_held) {
        sum_up(to, k.convolution, {pressed, x, y}, effort);
      } else {
        sum_up(to, k.convolution, {pressed}, effort);
      }
    };
    if (!is_found) add(0, {k.down, p}, {k.x, qx, -1}, {k.y, qy, -1});
    if (!sideways) return result;
    add(1, {k.x, p}, {k.xx, qx}, {k.xy, qy});
    add(2, {k.y, p}, {k.xy, qx}, {k.yy, qy});
    return result;
  }

 private:
  // A contact, and with which power of the press force goes around it.
  struct Borne {
    LayerState state;
    double power = 1.5;
  };

  // Whether friction holds an object.
  [[nodiscard]] bool is_held(const RigidObject& object) const {
    return friction_ > 0 && (object.twist != 0 || object.shift != Vec2<double>(0, 0));
  }

  // The contact that bears a force, by a secant search on the logarithms of force and press, since
  // the one goes with a power of the other.
  [[nodiscard]] std::optional<Borne> search(const RigidObject& object, double force,
                                            double tolerance, const Borne& start,
                                            Effort& effort) const {
    constexpr int most_tries = 60;
    const double deepest = object.deepest, most = grid_.thickness * (1 - 1e-9);
    double press = start.state.travel + deepest;
    if (!(press > 0)) press = deepest > 0 ? deepest : 1;
    press = std::min(press, start.state.pressure.empty() ? most / 2 : most);
    double below = 0, above = most, last_press = 0, last_force = 0;
    Borne found = start;
    for (int i = 0; i < most_tries; ++i) {
      const bool is_last = i + 1 == most_tries || !effort.goes_on();
      found.state = settle(object, press - deepest, found.state, effort);
      double borne = 0;
      for (const double p : found.state.pressure) borne += p;
      const double missing = std::abs(borne / force - 1);
      if (missing <= tolerance) break;
      if (borne < force && press >= most) return {};
      (borne < force ? below : above) = press;
      if (last_press > 0 && borne != last_force && press != last_press) {
        found.power =
            std::clamp(std::log(borne / last_force) / std::log(press / last_press), 0.5, 10.0);
      }
      last_press = press;
      last_force = borne;
      double next = press * std::clamp(std::pow(force / borne, 1 / found.power), 0.1, 10.0);
      if (!(next > below)) next = (press + below) / 2;
      if (!(next < above))
        next = std::isfinite(above) && above < most ? (press + above) / 2 : above;
      press = next;
      if (!is_last) continue;
      found.state.residual = std::max(found.state.residual, missing);
      break;
    }
    return found;
  }

  // The same without a look at whether it converged.
  [[nodiscard]] LayerState settled(const RigidObject& object, double travel,
                                   const LayerState& start, Effort& effort) const {
    LayerState state;
    state.travel = travel;
    const double press = object.deepest + travel;
    if (!(press > 0)) return state;
    Box box = reach_of(object, travel, start, false), searched = box;
    state = moved(start, box);
    state.travel = travel;
    for (;;) {
      find_loads(state, object, effort);
      state = cropped(state);
      // Only a layer that bulges can touch where the object does not stand in it.
      if (!is_layer()) return state;
      state.down = surface(state, false, effort);
      const Box wider = touched(object, state, effort);
      if (wider == state.box) return state;
      if (box.contains(wider)) {
        // Nothing new: friction that did not converge brought the surface there.
        state.residual = larger(state.residual, deepest_in(object, state) / press);
        return state;
      }
      // No box is searched twice, however loads come and go.
      const Box all = united(searched, wider);
      box = all == searched ? all : wider;
      searched = all;
      state = moved(state, box);
    }
  }

  // The layer's Green's functions between the pixels of two boxes, transformed.
  struct Kernels {
    Convolution convolution;
    Spectrum down, x, y, xx, yy, xy;
  };

  struct Term {
    const Spectrum& kernel;
    const Spectrum& load;
    double sign = 1;
  };

  // A tilting object's place, the forces that are missing there, and the contact.
  struct Balance {
    Vec3<double> place, left;
    LayerState state;
  };

  // The contact under a force at a tilt near that at which the layer bears it along a line: that of
  // springs which are together as stiff. From no tilt at all the search would be lost where an
  // object touches at a corner that is to turn it onto all of its face.
  [[nodiscard]] std::optional<LayerState> near_balance(const RigidObject& object, double force,
                                                       const Vec2<double>& centre,
                                                       const LayerState& start,
                                                       Effort& effort) const {
    constexpr int rounds = 2;
    const double exact = effort.tolerance, rough = std::max(0.1, exact);
    const auto at = [&](const Vec2<double>& tilt, const LayerState& from) {
      effort.tolerance = rough;
      std::optional<LayerState> state = balance(object.tilted(tilt, grid_), force, from, effort);
      if (state) state->tilt = tilt;
      return state;
    };
    std::optional<LayerState> state = at(Vec2<double>(0, 0), start);
    const double width = std::max(grid_.width, grid_.height);
    double stiffness = 2 / std::min(grid_.thickness, width);
    for (int round = 0; round < rounds; ++round) {
      const double down = state ? sunk(*state, object.tilted(state->tilt, grid_)) : 0;
      if (down > 0) stiffness = force / down;
      const Vec2<double> tilt = tilt_on_springs(object, force, centre, stiffness);
      std::optional<LayerState> next = at(tilt, state ? *state : start);
      if (!next) break;
      state = std::move(next);
    }
    effort.tolerance = exact;
    return state;
  }

  // The sum of how far a layer's pixels that bear are pressed in by the object.
  [[nodiscard]] double sunk(const LayerState& state, const RigidObject& object) const {
    double sum = 0;
    for_each(state, [&](Index column, Index row, double pressure) {
      if (pressure > 0) sum += object.overlap[whole().place(column, row)] + state.travel;
    });
    return sum;
  }

  // How an object tilts on springs of a stiffness, one under each pixel.
  [[nodiscard]] Vec2<double> tilt_on_springs(const RigidObject& object, double force,
                                             const Vec2<double>& centre, double stiffness) const {
    double highest = object.deepest;
    for (const double here : object.overlap) {
      if (std::isfinite(here)) highest = std::min(highest, here);
    }
    // So deep that nothing comes through, and so far away that all of the object is in view.
    const double depth = object.deepest - highest + 2 * force / stiffness;
    const double rest = 1 + std::abs(object.deepest) + std::abs(highest);
    const Camera<double> camera{rest,        rest / grid_.aspect, object.axis.x(), object.axis.y(),
                                grid_.width, grid_.height};
    Image<double> seen(grid_.width, grid_.height);
    std::transform(object.overlap.begin(), object.overlap.end(), seen.pixels().begin(),
                   [&](double here) { return rest - here; });
    const SpringBed<double> bed(camera, rest,
                                {.elastic_modulus = stiffness * depth, .thickness = depth});
    return bed.press_tilting(seen, force * grid_.aspect, centre).tilt;
  }

  // Half a contact's box, or a pixel.
  [[nodiscard]] double reach(const LayerState& state) const {
    return std::max(1.0, 0.5 * std::max<double>(state.box.width, grid_.aspect * state.box.height));
  }

  // Calls work(column, row, pressure) for the pixels of a state's box.
  template <class Work>
  static void for_each(const LayerState& state, const Work& work) {
    if (state.pressure.empty()) return;
    for (Index row = state.box.top; row < state.box.top + state.box.height; ++row) {
      for (Index column = state.box.left; column < state.box.left + state.box.width; ++column) {
        work(column, row, state.pressure[state.box.place(column, row)]);
      }
    }
  }

  // How much more than a force a contact bears, and its moments about the line, as shares of the
  // force and of its moment at the rim.
  [[nodiscard]] Vec3<double> unbalanced(const LayerState& state, const RigidObject& object,
                                        double force, const Vec2<double>& centre,
                                        double size) const {
    Vec3<double> sum = Vec3<double>(0, 0, 0);
    for_each(state, [&](Index column, Index row, double pressure) {
      sum += pressure * Vec3<double>(1, (column - object.axis.x() - centre.x()) / size,
                                     (grid_.aspect * (row - object.axis.y()) - centre.y()) / size);
    });
    return sum / force - Vec3<double>(1, 0, 0);
  }

  // How a tilting object moves by what is missing, from what is missing beside a place. A contact
  // along a line or at a pixel does not resist every motion: for these it is as good as soft.
  template <class At>
  [[nodiscard]] static Eigen::Matrix3d first_yielding(const Balance& here, const At& at) {
    constexpr double step = 0.02, soft = 1e-3;
    Eigen::Matrix3d rate;
    for (int k = 0; k < 3; ++k) {
      Vec3<double> place = here.place;
      place[k] += step;
      rate.col(k) = (at(place, here.state).left - here.left) / step;
    }
    const Eigen::Matrix3d even = 0.5 * (rate + rate.transpose());
    const PrincipalAxes<double> principal = principal_axes(even);
    Eigen::Matrix3d result = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double least = std::max(soft * principal.values[2], soft);
      const Vec3<double>& axis = principal.axes[k];
      result += axis * axis.transpose() / std::max(principal.values[k], least);
    }
    return result;
  }

  // The same after a step, and the change of what is missing by it.
  static void yield_as(Eigen::Matrix3d& yielding, const Vec3<double>& step,
                       const Vec3<double>& change) {
    constexpr double least_share = 1e-10;
    const double along = dot(step, change);
    if (!(along > least_share * norm(step) * norm(change))) return;
    const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - change * step.transpose() / along;
    yielding = (rest.transpose() * yielding * rest + step * step.transpose() / along).eval();
  }

  // Where the energy still falls along a step to `next`, but no more than half as steeply as at its
  // start: beyond it where it has to be.
  template <class At>
  [[nodiscard]] static Balance descend(const Balance& start, Balance next, const At& at,
                                       const Effort& effort) {
    constexpr int most_tries = 20;
    const Vec3<double> step = next.place - start.place;
    const double first = dot(start.left, step);
    double low = 0, high = std::numeric_limits<double>::infinity(), share = 1;
    double slope_low = first, slope_high = 0;
    for (int i = 0; i < most_tries && effort.goes_on(); ++i) {
      const double slope = dot(next.left, step);
      if (slope <= 0 && slope >= 0.5 * first) return next;
      (slope > 0 ? high : low) = share;
      (slope > 0 ? slope_high : slope_low) = slope;
      if (std::isinf(high)) {
        share *= 4;
      } else if (i % 2 == 0) {
        const double between = (0.25 * first - slope_low) / (slope_high - slope_low);
        share = low + std::clamp(between, 0.01, 0.99) * (high - low);
      } else {
        share = low + 0.5 * (high - low);
      }
      next = at(start.place + share * step, start.state);
    }
    return next;
  }

  [[nodiscard]] bool is_layer() const { return std::isfinite(grid_.thickness); }
  [[nodiscard]] Box whole() const { return {0, 0, grid_.width, grid_.height}; }

  [[nodiscard]] const std::optional<LayerCorrection<>>& correction() const {
    return correction_.get([&] { return layer_correction(grid_); });
  }
  [[nodiscard]] const PressureGreen<double>& by_pressure() const {
    return by_pressure_.get([&] { return PressureGreen(grid_, correction()); });
  }
  [[nodiscard]] const SidewaysGreen<double>& sideways() const {
    return sideways_.get([&] { return SidewaysGreen(grid_, correction()); });
  }

  [[nodiscard]] Kernels kernels(const Box& from, const Box& to, bool has_down,
                                bool has_sideways) const {
    Kernels k{Convolution(fourier_, from, to), {}, {}, {}, {}, {}, {}};
    const PressureGreen<double>& down = by_pressure();
    if (has_down) k.down = k.convolution.kernel([&](Index x, Index y) { return down.down(x, y); });
    if (!has_sideways) return k;
    const SidewaysGreen<double>& green = sideways();
    k.x = k.convolution.kernel([&](Index x, Index y) { return green.x(x, y); });
    k.y = k.convolution.kernel([&](Index x, Index y) { return green.y(x, y); });
    k.xx = k.convolution.kernel([&](Index x, Index y) { return green.xx(x, y); });
    k.yy = k.convolution.kernel([&](Index x, Index y) { return green.yy(x, y); });
    k.xy = k.convolution.kernel([&](Index x, Index y) { return green.xy(x, y); });
    return k;
  }

  static void sum_up(double* result, const Convolution& convolution,
                     std::initializer_list<Term> terms, Effort& effort) {
    Spectrum sum = convolution.zero();
    for (const Term& term : terms) add_product(sum, term.kernel, term.load, term.sign);
    convolution.restore(result, sum);
    effort.convolve();
  }

  // The same loads in another box.
  [[nodiscard]] static LayerState moved(const LayerState& state, const Box& box) {
    LayerState result = state;
    result.box = box;
    result.pressure = moved(state.pressure.data(), state.pressure.size(), state.box, box);
    result.traction.clear();
    result.down.clear();
    const std::size_t area = state.box.area();
    if (state.traction.size() != 2 * area) return result;
    for (const std::size_t k : {0u, 1u}) {
      const Array<double> part = moved(state.traction.data() + k * area, area, state.box, box);
      result.traction.append(part.begin(), part.end());
    }
    return result;
  }

  // The same loads in the smallest box that holds them.
  [[nodiscard]] static LayerState cropped(const LayerState& state) {
    const Box& box = state.box;
    Index left = box.width, right = -1, top = box.height, bottom = -1;
    for (Index y = 0; y < box.height; ++y) {
      for (Index x = 0; x < box.width; ++x) {
        if (!(state.pressure[std::ptrdiff_t{y} * box.width + x] > 0)) continue;
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = y;
      }
    }
    if (right < 0) return state;
    return moved(state, {box.left + left, box.top + top, right - left + 1, bottom - top + 1});
  }

  [[nodiscard]] static Array<double> moved(const double* values, std::size_t count, const Box& from,
                                           const Box& to) {
    Array<double> result(to.area());
    if (count == 0) return result;
    const Index left = std::max(from.left, to.left);
    const Index right = std::min(from.left + from.width, to.left + to.width);
    for (Index y = to.top; y < to.top + to.height; ++y) {
      if (left >= right || y < from.top || y >= from.top + from.height) continue;
      std::copy_n(values + from.place(left, y), right - left, &result[to.place(left, y)]);
    }
    return result;
  }

  // The box of the pixels where the object, moved, stands in the layer, or that were loaded before.
  // Half as much again where asked for, and for a thin layer that keeps its volume: it bulges.
  [[nodiscard]] Box reach_of(const RigidObject& object, double travel, const LayerState& before,
                             bool is_wide) const {
    Index left = grid_.width, right = -1, top = grid_.height, bottom = -1;
    for (Index y = 0; y < grid_.height; ++y) {
      for (Index x = 0; x < grid_.width; ++x) {
        const bool is_loaded = !before.pressure.empty() && before.box.contains(x, y) &&
                               before.pressure[before.box.place(x, y)] > 0;
        if (!is_loaded && !(object.overlap[whole().place(x, y)] + travel > 0)) continue;
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
    }
    is_wide = is_wide || (grid_.poisson_ratio > 0.4 && grid_.thickness < (right - left) / 2.0);
    const Index more_x = is_wide ? (right - left) / 4 + 1 : 0;
    const Index more_y = is_wide ? (bottom - top) / 4 + 1 : 0;
    left = std::max(left - more_x, 0);
    top = std::max(top - more_y, 0);
    right = std::min(right + more_x, grid_.width - 1);
    bottom = std::min(bottom + more_y, grid_.height - 1);
    return {left, top, right - left + 1, bottom - top + 1};
  }

  // The state's box, grown around what comes through the surface outside of it.
  [[nodiscard]] Box touched(const RigidObject& object, const LayerState& state,
                            const Effort& effort) const {
    const double accuracy = effort.tolerance * (object.deepest + state.travel);
    LayerState through;
    through.box = whole();
    through.pressure.resize(whole().area());
    bool is_wider = false;
    for (Index y = 0; y < grid_.height; ++y) {
      for (Index x = 0; x < grid_.width; ++x) {
        const std::ptrdiff_t i = whole().place(x, y);
        const bool is_inside = state.box.contains(x, y);
        const bool is_through = object.overlap[i] + state.travel - state.down[i] > accuracy;
        is_wider = is_wider || (is_through && !is_inside);
        through.pressure[i] = is_inside || is_through ? 1 : 0;
      }
    }
    return is_wider ? reach_of(object, state.travel, through, true) : state.box;
  }

  // How far the surface is in the object where it is farthest.
  [[nodiscard]] double deepest_in(const RigidObject& object, const LayerState& state) const {
    double most = 0;
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(whole().area()); ++i) {
      most = std::max(most, object.overlap[i] + state.travel - state.down[i]);
    }
    return most;
  }

  // What of the contact's equations does not change while they are solved.
  struct Task {
    Kernels kernels;
    Array<double> overlap;  // pressure's own, without what traction moves
    double press;
    Effort& effort;
  };

  [[nodiscard]] static Array<double> down(Task& task, const Array<double>& pressure) {
    Array<double> result(pressure.size());
    task.kernels.convolution.apply(result.data(), pressure.data(), task.kernels.down);
    task.effort.convolve();
    return result;
  }

  // Pressure, and traction where friction holds the object, in the state's box.
  void find_loads(LayerState& state, const RigidObject& object, Effort& effort) const {
    Task task{kernels(state.box, state.box, true, is_held(object)), Array<double>(state.box.area()),
              object.deepest + state.travel, effort};
    for (Index y = 0; y < state.box.height; ++y) {
      for (Index x = 0; x < state.box.width; ++x) {
        task.overlap[std::ptrdiff_t{y} * state.box.width + x] =
            object.overlap[whole().place(state.box.left + x, state.box.top + y)] + state.travel;
      }
    }
    state.residual = press_down(state, task, task.overlap).after;
    if (is_held(object)) {
      hold(state, task, object);
    } else {
      state.traction.clear();
    }
  }

  // The pressure under which the surface is where the object wants it. What is left is told as a
  // share of the press.
  LeftOpen press_down(LayerState& state, Task& task, const Array<double>& wanted) const {
    const auto respond = [&](const Array<double>& pressure) { return down(task, pressure); };
    const LeftOpen open =
        solve_bounded(state.pressure, wanted, Unilateral{wanted}, respond, by_pressure().down(0, 0),
                      task.kernels.convolution.gain(task.kernels.down),
                      task.effort.tolerance * task.press, task.effort);
    return {open.before / task.press, open.after / task.press};
  }

  // Traction under which what does not slip goes with the object, from where pressure without
  // friction left it. Traction moves the surface down and pressure moves it sideways, both little:
  // the two are found in turns until neither changes (Panagiotopoulos, A nonlinear programming
  // approach to the unilateral contact- and friction-boundary value problem in the theory of
  // elasticity, 1975).
  void hold(LayerState& state, Task& task, const RigidObject& object) const {
    constexpr int most_rounds = 20;
    const Kernels& k = task.kernels;
    const std::size_t pixels = state.box.area();
    state.traction.resize(2 * pixels);
    const Array<double> dragged = motion(object, state.box), before = state.pressure;
    const double softness = std::max(sideways().xx(0, 0), sideways().yy(0, 0));
    const double gain =
        std::max(k.convolution.gain(k.xx), k.convolution.gain(k.yy)) + k.convolution.gain(k.xy);
    const auto respond = [&](const Array<double>& traction) {
      Array<double> result(traction.size());
      const Spectrum qx = k.convolution.transform(traction.data());
      const Spectrum qy = k.convolution.transform(traction.data() + pixels);
      sum_up(result.data(), k.convolution, {{k.xx, qx}, {k.xy, qy}}, task.effort);
      sum_up(result.data() + pixels, k.convolution, {{k.xy, qx}, {k.yy, qy}}, task.effort);
      return result;
    };
    // An object that goes on slipping moves the surface no farther than all of friction does.
    double farthest = longest(dragged);
    if (std::isfinite(friction_)) {
      farthest = std::min(farthest, longest(respond(slipping(state.pressure, dragged))));
    }
    if (farthest == 0) return;  // one pixel that turns, or nothing touches
    Array<double> wanted = dragged, most(pixels);
    for (int round = 0; round < most_rounds; ++round) {
      Array<double> change(pixels);
      double largest = 0;
      for (std::size_t i = 0; i < pixels; ++i) {
        const double p = state.pressure.data()[i];
        most.data()[i] = p > 0 ? friction_ * p : 0;
        change.data()[i] = p - before.data()[i];
        largest = larger(largest, std::abs(change.data()[i]));
      }
      if (largest > 0) {
        const Spectrum p = k.convolution.transform(change.data());
        sum_up(wanted.data(), k.convolution, {{k.x, p}}, task.effort);
        sum_up(wanted.data() + pixels, k.convolution, {{k.y, p}}, task.effort);
        for (std::size_t i = 0; i < wanted.size(); ++i) {
          wanted.data()[i] = dragged.data()[i] - wanted.data()[i];
        }
      }
      const double slack =
          solve_bounded(state.traction, wanted, Frictional{most}, respond, softness, gain,
                        task.effort.tolerance * farthest, task.effort)
              .after /
          farthest;
      Array<double> lifted(pixels);
      const Spectrum qx = k.convolution.transform(state.traction.data());
      const Spectrum qy = k.convolution.transform(state.traction.data() + pixels);
      sum_up(lifted.data(), k.convolution, {{k.x, qx}, {k.y, qy}}, task.effort);
      for (std::size_t i = 0; i < pixels; ++i) lifted.data()[i] += task.overlap.data()[i];
      Array<double> last = state.pressure;
      const double gap = press_down(state, task, lifted).before;
      if (gap > task.effort.tolerance && round + 1 < most_rounds) continue;
      // The pressure that bounds the traction, so that the two keep to friction's law.
      state.pressure = std::move(last);
      state.residual = larger(slack, gap);
      return;
    }
  }

  [[nodiscard]] static double longest(const Array<double>& values) {
    double result = 0;
    for (const double value : values) result = std::max(result, std::abs(value));
    return result;
  }

  // The traction of an object that slips everywhere the way that it is dragged.
  [[nodiscard]] Array<double> slipping(const Array<double>& pressure,
                                       const Array<double>& dragged) const {
    const std::size_t pixels = pressure.size();
    Array<double> result(2 * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      const Vec2<double> way(dragged.data()[i], dragged.data()[pixels + i]);
      if (!(pressure.data()[i] > 0) || way == Vec2<double>(0, 0)) continue;
      const Vec2<double> q = friction_ * pressure.data()[i] * normalized(way);
      result.data()[i] = q.x();
      result.data()[pixels + i] = q.y();
    }
    return result;
  }

  // How far the object has moved each pixel of a box sideways: all along x, then all along y.
  [[nodiscard]] Array<double> motion(const RigidObject& object, const Box& box) const {
    Array<double> result(2 * box.area());
    const double cos = std::cos(object.twist) - 1, sin = std::sin(object.twist);
    std::size_t i = 0;
    for (Index row = box.top; row < box.top + box.height; ++row) {
      for (Index column = box.left; column < box.left + box.width; ++column, ++i) {
        const double x = column - object.axis.x(), y = grid_.aspect * (row - object.axis.y());
        result.data()[i] = object.shift.x() + cos * x - sin * y;
        result.data()[box.area() + i] = object.shift.y() + sin * x + cos * y;
      }
    }
    return result;
  }

  LayerGrid grid_;
  double friction_;
  FourierBackend fourier_;
  Lazy<std::optional<LayerCorrection<>>> correction_;
  Lazy<PressureGreen<double>> by_pressure_;
  Lazy<SidewaysGreen<double>> sideways_;
};

}  // namespace gelight::detail
