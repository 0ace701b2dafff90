#pragma once

// Any distance solver as one type, so that what takes one is compiled once for all of them.

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "gelight/geodesic/distance_solver.hpp"

class AnySolver : public gelight::detail::DistanceQueries<AnySolver, double> {
 public:
  using From = std::span<const gelight::Source<double>>;

  /// Of a solver that lives longer.
  template <class Solver>
  explicit AnySolver(const Solver& solver)
      : surface_(solver.surface()),
        solve_([&solver](From from) { return solver.distance(from); }) {}

  [[nodiscard]] const Surface& surface() const { return surface_; }
  [[nodiscard]] std::vector<double> solve_vertices(
      const std::vector<gelight::Source<double>>& sources) const {
    return solve_(sources);
  }

 private:
  Surface surface_;
  std::function<std::vector<double>(From)> solve_;
};

static_assert(gelight::DistanceSolver<AnySolver, double>);

/// The solver that an object of Python is. Throws TypeError for another object.
AnySolver any_solver(py::handle object);
