#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// How exact a press is to be, what it has cost so far, and the caller's way to end it.
struct Effort {
  const CancelHook& cancelled;
  double tolerance;     ///< see LayerOptions
  int most_iterations;  ///< see LayerOptions
  int iterations = 0;
  int convolutions = 0;
  int unsettled = 0;  ///< contacts that did not converge

  /// Whether to look for another contact. Friction that does not settle leaves no balance to be
  /// found: it would be sought for hours.
  [[nodiscard]] bool goes_on() const { return unsettled < 8; }

  void convolve() {
    ++convolutions;
    // How many there will be nobody knows.
    if (cancelled) cancelled.check(convolutions / (convolutions + 40.0), "the elastic layer");
  }
};

/// Loads on the pixels of a box, N a pixel, one component after the other.
template <int N>
using Load = Eigen::Matrix<double, N, 1>;

/// Where pressure may act: nowhere less than nothing.
struct Unilateral {
  static constexpr int components = 1;
  const Array<double>& wanted;  ///< -infinity: nothing to touch

  [[nodiscard]] Load<1> nearest(std::size_t i, const Load<1>& load) const {
    return Load<1>(std::isfinite(wanted.data()[i]) ? std::max(load[0], 0.0) : 0.0);
  }
  /// The part of a change that the bound lets through, where the gap drives the load.
  [[nodiscard]] Load<1> free_part(std::size_t i, const Load<1>& load, const Load<1>& gap,
                                  const Load<1>& change) const {
    const bool is_free = std::isfinite(wanted.data()[i]) && (load[0] > 0 || gap[0] < 0);
    return is_free ? change : Load<1>::Zero();
  }
  /// How much steeper the gap gets along the bound, because that is bent.
  [[nodiscard]] double bend(std::size_t, const Load<1>&, const Load<1>&) const { return 0; }
};

/// Coulomb's friction: no traction is longer than a share of the pressure.
struct Frictional {
  static constexpr int components = 2;
  const Array<double>& most;  ///< of a traction's length, at each pixel

  [[nodiscard]] Load<2> nearest(std::size_t i, const Load<2>& load) const {
    const double length = load.norm(), bound = most.data()[i];
    return length <= bound ? load : Load<2>(load * (bound / length));
  }
  [[nodiscard]] Load<2> free_part(std::size_t i, const Load<2>& load, const Load<2>& gap,
                                  const Load<2>& change) const {
    if (most.data()[i] == 0) return Load<2>::Zero();
    if (!is_held(i, load, gap)) return change;
    return change - change.dot(load) / load.squaredNorm() * load;
  }
  [[nodiscard]] double bend(std::size_t i, const Load<2>& load, const Load<2>& gap) const {
    return is_held(i, load, gap) ? -gap.dot(load) / load.squaredNorm() : 0;
  }

 private:
  // Whether the gap drives the load against its bound. What was put there stays there, whatever
  // rounding does.
  [[nodiscard]] bool is_held(std::size_t i, const Load<2>& load, const Load<2>& gap) const {
    constexpr double on_it = 1 - 1e-12;
    return most.data()[i] > 0 && load.norm() >= on_it * most.data()[i] && gap.dot(load) < 0;
  }
};

/// The larger of two, NaN where either is.
[[nodiscard]] inline double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

/// The largest of all pixels' gaps, or where it is less of the loads that they are closed with, as
/// a length.
struct LeftOpen {
  double before = 0;  ///< by the loads that were there
  double after = 0;   ///< by those that were found
};

/// Finds the loads within bounds under which a surface goes where it is wanted, or as near as the
/// bounds let it: pressure is positive where the gap is none and no gap is negative; or traction is
/// below friction where nothing slips, and where it slips the two are opposed.
///
/// By conjugate gradients (Polak and Ribiere's) on what of the loads the bounds leave free, also
/// along a bound that is bent; at the start and after each step loads are put back to their bounds.
/// (After Polonsky and Keer, A numerical method for solving rough contact problems based on the
/// multi-level multi-summation and conjugate gradient techniques, 1999,
/// doi:10.1016/S0043-1648(99)00113-1.)
///
/// `respond(load)` gives the surface's displacement, `softness` is a pixel's by its own load,
/// `gain` the most by which responding makes any load longer. Ends where each pixel's gap, or where
/// it is less the load that it closes it with, is below `accuracy`, a length.
template <class Bounds, class Respond>
[[nodiscard]] LeftOpen solve_bounded(Array<double>& load, const Array<double>& wanted,
                                     const Bounds& bounds, const Respond& respond, double softness,
                                     double gain, double accuracy, Effort& effort) {
  constexpr int N = Bounds::components;
  const std::size_t pixels = load.size() / N;
  const auto get = [&](const Array<double>& of, std::size_t i) {
    Load<N> value;
    for (std::size_t k = 0; k < N; ++k) value[static_cast<int>(k)] = of.data()[k * pixels + i];
    return value;
  };
  const auto set = [&](Array<double>& of, std::size_t i, const Load<N>& value) {
    for (std::size_t k = 0; k < N; ++k) of.data()[k * pixels + i] = value[static_cast<int>(k)];
  };
  Array<double> gap, step(load.size()), slope(load.size());
  const auto measure = [&] {
    const bool is_loaded = std::any_of(load.begin(), load.end(), [](double q) { return q != 0; });
    gap = is_loaded ? respond(load) : load;
    for (std::size_t k = 0; k < gap.size(); ++k) gap.data()[k] -= wanted.data()[k];
  };
  for (std::size_t i = 0; i < pixels; ++i) set(load, i, bounds.nearest(i, get(load, i)));
  measure();
  LeftOpen open_by;
  double last_square = 0, last_energy = std::numeric_limits<double>::infinity();
  for (int iteration = 0;; ++iteration) {
    double square = 0, change = 0, energy = 0, left = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const Load<N> here = get(load, i), open = get(gap, i);
      const Load<N> better = bounds.nearest(i, here - open / softness);
      left = larger(left, softness * (here - better).norm());
      const Load<N> free = bounds.free_part(i, here, open, open);
      const double stiff = 1 / (softness + bounds.bend(i, here, open));
      square += stiff * free.squaredNorm();
      change += stiff * free.dot(free - get(slope, i));
      set(slope, i, free);
      if (here != Load<N>::Zero()) energy += here.dot(open - get(wanted, i));
    }
    if (iteration == 0) open_by.before = left;
    open_by.after = left;
    if (left <= accuracy || std::isnan(left)) return open_by;
    if (iteration == effort.most_iterations) return open_by;
    ++effort.iterations;
    // A step after which the energy did not fall is followed by one after which it must.
    const bool is_careful = !(energy < last_energy);
    const double keep = last_square > 0 && !is_careful ? std::max(0.0, change / last_square) : 0;
    last_square = is_careful ? 0 : square;
    last_energy = energy;
    double along = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const Load<N> here = get(load, i), open = get(gap, i);
      const double stiff = 1 / (softness + bounds.bend(i, here, open));
      const Load<N> next =
          stiff * get(slope, i) + keep * bounds.free_part(i, here, open, get(step, i));
      set(step, i, next);
      along += next.dot(get(slope, i));
    }
    const Array<double> yielding = respond(step);
    double bending = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const Load<N> by = get(step, i);
      bending +=
          by.dot(get(yielding, i)) + bounds.bend(i, get(load, i), get(gap, i)) * by.squaredNorm();
    }
    double length = bending > 0 ? along / bending : softness / gain;
    if (is_careful) length = std::min(length, softness / gain);
    bool is_straight = true;
    for (std::size_t i = 0; i < pixels; ++i) {
      const Load<N> there = get(load, i) - length * get(step, i);
      const Load<N> next = bounds.nearest(i, there);
      is_straight = is_straight && next == there;
      set(load, i, next);
    }
    if (is_straight) {
      for (std::size_t k = 0; k < gap.size(); ++k) gap.data()[k] -= length * yielding.data()[k];
    } else {
      measure();
    }
  }
}

}  // namespace gelight::detail
