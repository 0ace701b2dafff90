#pragma once

// Any distance solver as one type, so that what takes one is compiled once for all of them.

#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "gelight/geodesic/distance_solver.hpp"

class AnySolver : public gelight::detail::DistanceQueries<AnySolver, double> {
 public:
  using From = std::span<const gelight::Source<double>>;
  using Solve = std::function<std::vector<double>(From)>;

  /// Solves by a function of the sources.
  AnySolver(Surface surface, Solve solve)
      : surface_(std::move(surface)), solve_(std::move(solve)) {}
  /// Of a solver that lives longer.
  template <class Solver>
  explicit AnySolver(const Solver& solver)
      : AnySolver(solver.surface(), [&solver](From from) { return solver.distance(from); }) {}

  [[nodiscard]] const Surface& surface() const { return surface_; }
  void solve_vertices(gelight::detail::DistanceQuery<double>& query) const {
    const std::vector<double> found = solve_(query.sources);
    std::copy(found.begin(), found.end(), query.distance.begin());
  }

 private:
  Surface surface_;
  Solve solve_;
};

static_assert(gelight::DistanceSolver<AnySolver, double>);

/// The solver that an object of Python is. Throws TypeError for another object.
AnySolver any_solver(py::handle object);
