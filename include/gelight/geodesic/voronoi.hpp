#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <span>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {
template <std::floating_point T>
class GrowingEngine;
}  // namespace detail

/// Exact distances from sources that are added one by one: each is solved only where it is nearer
/// than those before. The solver's `max_distance`, `max_memory` and hook hold for each; its targets
/// and reset radius do not count.
template <std::floating_point T>
class GrowingDistances {
 public:
  /// On the surface of a solver, with no source yet.
  explicit GrowingDistances(const ExactSolver<T>& solver);

  /// Not copied: what it works with refers to its own surface.
  ///@{
  GrowingDistances(const GrowingDistances&) = delete;
  GrowingDistances& operator=(const GrowingDistances&) = delete;
  ///@}

  /// Adds a source and returns the vertices that came nearer by it. Throws InvalidInput for a
  /// source that is not of the surface or starts with a distance that is not finite; Cancelled
  /// where this hook or the solver's says so, and MemoryLimit, after either of which distances are
  /// of no use.
  ///@{
  std::vector<Index> add(Index vertex, const CancelHook& cancelled = {}) {
    return add(Source<T>{vertex_point<T>(vertex), 0}, cancelled);
  }
  std::vector<Index> add(const Source<T>& source, const CancelHook& cancelled = {});
  ///@}

  /// Distance of a vertex from the nearest source so far, +infinity where there is none or it is
  /// beyond the solver's greatest. Throws InvalidInput for a vertex that is not of the surface, and
  /// a distance that T cannot hold.
  [[nodiscard]] T distance(Index vertex) const;

  /// The surface.
  [[nodiscard]] const Surface<double>& surface() const;

 private:
  std::shared_ptr<detail::GrowingEngine<T>> engine_;
};

namespace detail {

/// The same interface for a solver that knows no better than to solve from each source.
template <class Solver>
class RepeatedDistances {
 public:
  explicit RepeatedDistances(const Solver& solver) : solver_(solver) {}

  std::vector<Index> add(Index vertex, const CancelHook& cancelled) {
    cancelled.check(0, "adding a source");
    const auto further = solver_.distance(vertex);
    if (distances_.empty()) distances_.assign(further.size(), unreachable<double>);
    std::vector<Index> nearer;
    for (Index v = 0; v < std::ssize(further); ++v) {
      const auto d = static_cast<double>(further[static_cast<std::size_t>(v)]);
      if (!(d < distances_[v])) continue;
      distances_[v] = d;
      nearer.push_back(v);
    }
    return nearer;
  }
  [[nodiscard]] double distance(Index vertex) const { return distances_[vertex]; }
  [[nodiscard]] const Surface<double>& surface() const { return solver_.surface(); }

 private:
  const Solver& solver_;
  Array<double> distances_;
};

template <class Solver>
[[nodiscard]] RepeatedDistances<Solver> growing(const Solver& solver) {
  return RepeatedDistances<Solver>(solver);
}
template <std::floating_point T>
[[nodiscard]] GrowingDistances<T> growing(const ExactSolver<T>& solver) {
  return GrowingDistances<T>(solver);
}

}  // namespace detail

/// Vertices spread as far apart as they come: from the first on, each the one farthest from all
/// before it (T. F. Gonzalez 1985, doi:10.1016/0304-3975(85)90224-5). Of several as far the first;
/// where parts of the mesh are not connected, each gets a point before any gets its second.
/// Vertices for which the solver tells no distance, as beyond its greatest, count as not connected.
/// Vertices in no face are left out but for `first`.
///
/// By ExactSolver each point is solved where it is nearest alone; any other solver solves from each
/// anew. Throws InvalidInput for a first vertex that is not of the mesh and a count below 1 or
/// above that of the vertices with faces; Cancelled where the hook says so.
template <class Solver>
[[nodiscard]] std::vector<Index> farthest_points(const Solver& solver, Index count, Index first = 0,
                                                 const CancelHook& cancelled = {}) {
  const Surface<double>& surface = solver.surface();
  surface.require_vertex(first);
  detail::Array<Index> candidates;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    if (v != first && !surface.corners(v).empty()) candidates.push_back(v);
  }
  detail::require(count >= 1 && count <= std::ssize(candidates) + 1, count,
                  " farthest points are asked for, there are ", candidates.size() + 1, " vertices");
  std::vector<Index> points{first};
  auto growing = detail::growing(solver);
  while (std::ssize(points) < count) {
    const double done = static_cast<double>(points.size()) / count;
    growing.add(points.back(), cancelled.part(done, done));
    const auto farther = [&](Index a, Index b) {
      return growing.distance(a) < growing.distance(b);
    };
    const auto farthest = std::max_element(candidates.begin(), candidates.end(), farther);
    points.push_back(*farthest);
    std::copy(farthest + 1, candidates.end(), farthest);
    candidates.pop_back();
  }
  return points;
}

/// The nearest site of each vertex, one of `sites`; -1 where no path leads to any, or all are
/// beyond the solver's greatest distance. Of several as near the first of `sites`, but for
/// rounding.
///
/// By ExactSolver each site is solved where it is nearest alone; any other solver solves from each
/// anew. Throws InvalidInput for no site and one that is not of the mesh; Cancelled where the hook
/// says so.
///@{
template <class Solver>
[[nodiscard]] std::vector<Index> voronoi(const Solver& solver, std::span<const Index> sites,
                                         const CancelHook& cancelled = {}) {
  const Surface<double>& surface = solver.surface();
  detail::require(!sites.empty(), "there is no site");
  for (const Index site : sites) surface.require_vertex(site);
  std::vector<Index> nearest(static_cast<std::size_t>(surface.vertex_count()), -1);
  auto growing = detail::growing(solver);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const double done = static_cast<double>(i) / static_cast<double>(sites.size());
    for (const Index v : growing.add(sites[i], cancelled.part(done, done))) {
      nearest[static_cast<std::size_t>(v)] = sites[i];
    }
  }
  return nearest;
}
template <class Solver>
[[nodiscard]] std::vector<Index> voronoi(const Solver& solver, std::initializer_list<Index> sites,
                                         const CancelHook& cancelled = {}) {
  return voronoi(solver, std::span<const Index>(sites.begin(), sites.size()), cancelled);
}
///@}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/voronoi/body.hpp"
#endif
