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
  static constexpr bool turns = false;  // whether a load can go along its bound
  const Array<double>& wanted;          ///< -infinity: nothing to touch

  [[nodiscard]] Load<1> nearest(std::size_t i, const Load<1>& load) const {
    return Load<1>(may_touch(i) ? std::max(load[0], 0.0) : 0.0);
  }
  [[nodiscard]] bool is_inside(std::size_t i, const Load<1>& load) const {
    return load[0] > 0 && may_touch(i);
  }
  [[nodiscard]] bool may_touch(std::size_t i) const { return std::isfinite(wanted.data()[i]); }
};

/// Coulomb's friction: no traction is longer than a share of the pressure.
struct Frictional {
  static constexpr int components = 2;
  static constexpr bool turns = true;
  const Array<double>& most;  ///< of a traction's length, at each pixel

  [[nodiscard]] Load<2> nearest(std::size_t i, const Load<2>& load) const {
    const double length = load.norm(), bound = most.data()[i];
    return length <= bound ? load : Load<2>(load * (bound / length));
  }
  [[nodiscard]] bool is_inside(std::size_t i, const Load<2>& load) const {
    // What was put on the bound stays there, whatever rounding does.
    constexpr double on_it = 1 - 1e-12;
    return load.norm() < on_it * most.data()[i];
  }
};

/// Finds the loads within bounds under which a surface goes where it is wanted, or as near as the
/// bounds let it: pressure is positive where the gap is none and no gap is negative; or traction is
/// below friction where nothing slips, and where it slips the two are opposed.
///
/// By conjugate gradients on the loads that are free of their bounds, which are put back to them
/// after each step; a load on its bound steps downhill (Polonsky and Keer, A numerical method for
/// solving rough contact problems based on the multi-level multi-summation and conjugate gradient
/// techniques, 1999, doi:10.1016/S0043-1648(99)00113-1, for pressure; the same for traction).
///
/// `respond(load)` gives the surface's displacement, `softness` is a pixel's by its own load,
/// `gain` the most by which responding makes any load longer. Ends where each pixel's gap, or where
/// it is less the load that it closes it with, is below `accuracy`, a length. Returns the largest
/// that is left.
template <class Bounds, class Respond>
[[nodiscard]] double solve_bounded(Array<double>& load, const Array<double>& wanted,
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
  Array<double> gap(load.size()), step(load.size());
  Array<char> free(pixels);
  const auto measure = [&] {
    gap = respond(load);
    for (std::size_t k = 0; k < gap.size(); ++k) gap.data()[k] -= wanted.data()[k];
  };
  measure();
  double squares = 0, left = 0;
  bool goes_on = false;  // the last step was one of the same conjugate gradients
  for (int iteration = 0;; ++iteration) {
    double sum = 0;
    left = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const Load<N> here = get(load, i), slope = get(gap, i);
      free.data()[i] = bounds.is_inside(i, here) ? 1 : 0;
      if (free.data()[i] != 0) sum += slope.squaredNorm();
      const Load<N> better = bounds.nearest(i, here - slope / softness);
      left = std::max(left, softness * (here - better).norm());
    }
    if (left <= accuracy || iteration == effort.most_iterations) return left;
    ++effort.iterations;
    const double keep = goes_on && squares > 0 ? sum / squares : 0;
    squares = sum;
    for (std::size_t i = 0; i < pixels; ++i) {
      set(step, i,
          free.data()[i] != 0 ? Load<N>(get(gap, i) + keep * get(step, i)) : Load<N>::Zero());
    }
    const Array<double> yielding = respond(step);
    double along = 0, bending = 0;
    for (std::size_t k = 0; k < step.size(); ++k) {
      along += step.data()[k] * (step.data()[k] != 0 ? gap.data()[k] : 0);
      bending += step.data()[k] * yielding.data()[k];
    }
    const double length = bending > 0 ? along / bending : 1 / gain;
    const double downhill = Bounds::turns ? std::min(length, 1 / gain) : length;
    goes_on = true;
    bool is_straight = true;
    for (std::size_t i = 0; i < pixels; ++i) {
      const Load<N> here = get(load, i);
      const bool is_free = free.data()[i] != 0;
      const Load<N> there =
          is_free ? Load<N>(here - length * get(step, i)) : Load<N>(here - downhill * get(gap, i));
      const Load<N> next = bounds.nearest(i, there);
      if (is_free) {
        if (next != there) is_straight = false;
      } else if (next != here) {
        is_straight = false;
        if (bounds.is_inside(i, next)) goes_on = false;
      }
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
