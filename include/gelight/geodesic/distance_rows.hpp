#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/parallel.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

struct RowOptions {
  /// On how many threads rows are solved, the caller's among them; 0: as many as the machine has.
  unsigned threads = 1;
  /// Asked before each row that the calling thread solves, and told the share of rows that are
  /// done. The solver's own hook, where it has one, is asked within rows, by every thread.
  CancelHook cancelled = {};
};

namespace detail {

/// What the distances of a solver are made of.
template <class Solver>
using DistanceScalar =
    typename decltype(std::declval<const Solver&>().distance(Index{}))::value_type;

/// Throws InvalidInput for a source that is not of the solver's surface, where that is known.
template <class Solver, class Place>
void require_sources(const Solver& solver, std::span<const Place> sources) {
  if (sources.empty()) return;
  if constexpr (requires { solver.require_sources(sources); }) {
    solver.require_sources(sources);
  } else if constexpr (requires { checked_sources(solver.surface(), sources); }) {
    (void)checked_sources(solver.surface(), sources);
  }
}

/// Whether a solver answers several sources together, each alone.
template <class Solver, class Place>
concept SolvesTogether = requires(const Solver& solver, std::span<const Place> sources) {
  solver.distance_from_each(sources);
};

/// The distances from each of a few sources alone.
template <class Solver, class Place>
[[nodiscard]] auto rows_of(const Solver& solver, std::span<const Place> sources) {
  if constexpr (SolvesTogether<Solver, Place>) {
    return solver.distance_from_each(sources);
  } else {
    return std::array{solver.distance(sources)};
  }
}

/// How many sources a thread takes at once.
template <class Solver, class Place>
[[nodiscard]] std::size_t rows_at_once(std::size_t rows, unsigned threads) {
  if (!SolvesTogether<Solver, Place>) return 1;
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  return std::clamp<std::size_t>((rows + threads - 1) / threads, 1, 8);
}

template <class Solver, class Place>
void solve_rows(const Solver& solver, std::span<const Place> sources, auto&& take,
                const RowOptions& options) {
  require_sources(solver, sources);
  std::mutex taking;
  std::size_t taken = 0;
  bool is_over = false;  // by an exception: rows that other threads still solve are not taken
  const auto caller = std::this_thread::get_id();
  const std::size_t at_once = rows_at_once<Solver, Place>(sources.size(), options.threads);
  const auto ask = [&] {
    const double done = [&] {
      const std::lock_guard lock(taking);
      return static_cast<double>(taken) / static_cast<double>(sources.size());
    }();
    options.cancelled.check(done, "solving rows of distances");
  };
  const auto solve = [&](Index block) {
    const std::size_t first = static_cast<std::size_t>(block) * at_once;
    const auto some = sources.subspan(first, std::min(at_once, sources.size() - first));
    if (std::this_thread::get_id() == caller) {
      for (std::size_t i = 0; i < some.size(); ++i) ask();
    }
    auto row = static_cast<Index>(first);
    for (const auto& distances : rows_of(solver, some)) {
      const std::lock_guard lock(taking);
      if (is_over) return;
      is_over = true;  // unless `take` returns
      take(row++, std::span(distances));
      is_over = false;
      ++taken;
    }
  };
  const auto solve_or_end = [&](Index block) {
    try {
      solve(block);
    } catch (...) {
      const std::lock_guard lock(taking);
      is_over = true;
      throw;
    }
  };
  const std::size_t blocks = (sources.size() + at_once - 1) / at_once;
  parallel_for(static_cast<Index>(blocks), options.threads, solve_or_end);
}

template <class Solver, class Place>
[[nodiscard]] auto matrix_of_rows(const Solver& solver, std::span<const Place> sources,
                                  const RowOptions& options) {
  std::vector<DistanceScalar<Solver>> matrix;
  const auto take = [&](Index row, const auto& distances) {
    matrix.resize(sources.size() * distances.size());  // at the first row
    std::copy(distances.begin(), distances.end(),
              matrix.begin() + std::ptrdiff_t{row} * std::ssize(distances));
  };
  solve_rows(solver, sources, take, options);
  return matrix;
}

}  // namespace detail

/// Distances of all vertices from each of many sources: `take(row, distances)` is called with the
/// number of a source and a span of one distance per vertex, which lasts as long as the call.
///
/// Rows come in any order, on any of the threads, never two at once; they are bit for bit what
/// `solver.distance` gives for that source alone. All share the solver's factors, and each thread
/// its workspace. HeatSolver's threads take up to eight sources at once, so that their factors are
/// read once, in two thirds of the time. Memory: a row and a workspace for each source
/// that is being solved. Throws InvalidInput, before any row is solved, for a source that is not of
/// the solver's surface, and in a row as the solver does; Cancelled as the hook says; what `take`
/// throws passes through. Rows that were taken before stay taken; none is from then on.
///@{
template <class Solver, class Take>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
void distance_rows(const Solver& solver, std::span<const Index> sources, const Take& take,
                   const RowOptions& options = {}) {
  detail::solve_rows(solver, sources, take, options);
}
template <class Solver, class Take>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
void distance_rows(const Solver& solver, std::initializer_list<Index> sources, const Take& take,
                   const RowOptions& options = {}) {
  distance_rows(solver, std::span<const Index>(sources.begin(), sources.size()), take, options);
}
template <class Solver, class Take>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
void distance_rows(const Solver& solver,
                   std::span<const Source<detail::DistanceScalar<Solver>>> sources,
                   const Take& take, const RowOptions& options = {}) {
  detail::solve_rows(solver, sources, take, options);
}
template <class Solver, class Take,
          std::same_as<Source<detail::DistanceScalar<Solver>>> Point =
              Source<detail::DistanceScalar<Solver>>>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
void distance_rows(const Solver& solver, std::initializer_list<Point> sources, const Take& take,
                   const RowOptions& options = {}) {
  distance_rows(solver, std::span<const Point>(sources.begin(), sources.size()), take, options);
}
///@}

/// The same rows as one matrix, row by row: element [i n + v] of the result is the distance of
/// vertex v of n from source i. No sources give no rows.
///@{
template <class Solver>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
[[nodiscard]] auto distance_matrix(const Solver& solver, std::span<const Index> sources,
                                   const RowOptions& options = {}) {
  return detail::matrix_of_rows(solver, sources, options);
}
template <class Solver>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
[[nodiscard]] auto distance_matrix(const Solver& solver, std::initializer_list<Index> sources,
                                   const RowOptions& options = {}) {
  const std::span<const Index> vertices(sources.begin(), sources.size());
  return detail::matrix_of_rows(solver, vertices, options);
}
template <class Solver>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
[[nodiscard]] auto distance_matrix(const Solver& solver,
                                   std::span<const Source<detail::DistanceScalar<Solver>>> sources,
                                   const RowOptions& options = {}) {
  return detail::matrix_of_rows(solver, sources, options);
}
template <class Solver, std::same_as<Source<detail::DistanceScalar<Solver>>> Point =
                            Source<detail::DistanceScalar<Solver>>>
requires DistanceSolver<Solver, detail::DistanceScalar<Solver>>
[[nodiscard]] auto distance_matrix(const Solver& solver, std::initializer_list<Point> sources,
                                   const RowOptions& options = {}) {
  const std::span<const Point> points(sources.begin(), sources.size());
  return detail::matrix_of_rows(solver, points, options);
}
///@}

}  // namespace gelight
