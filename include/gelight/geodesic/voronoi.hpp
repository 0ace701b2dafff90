#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// Exact distances from sources that are added one by one: each is solved only where it is nearer
/// than those before.
template <std::floating_point T>
class GrowingDistances {
 public:
  /// On the surface of a solver, with no source yet.
  explicit GrowingDistances(const ExactSolver<T>& solver)
      : surface_(solver.surface()),
        faces_(surface_),
        longest_way_(detail::longest_way(surface_)),
        starts_(static_cast<std::size_t>(surface_.vertex_count()), unreachable<Real>) {}
  /// Not copied: what it works with refers to its own surface.
  ///@{
  GrowingDistances(const GrowingDistances&) = delete;
  GrowingDistances& operator=(const GrowingDistances&) = delete;
  ///@}

  /// Adds a source and returns the vertices that came nearer by it. Throws InvalidInput for a
  /// source that is not of the surface or starts with a distance that is not finite; Cancelled
  /// where the hook says so, after which distances are of no use.
  ///@{
  std::vector<Index> add(Index vertex, const CancelHook& cancelled = {}) {
    return add(Source<T>{vertex_point<T>(vertex), 0}, cancelled);
  }
  std::vector<Index> add(const Source<T>& source, const CancelHook& cancelled = {}) {
    sources_ = detail::checked_sources(surface_, std::span<const Source<T>>(&source, 1));
    sources_[0].point = detail::simplified(surface_, sources_[0].point);
    limits_.cancelled = cancelled;
    sources_[0].distance -= start_of_part(sources_[0]);
    // So late that others have been everywhere.
    if (sources_[0].distance > longest_way_) return {};
    if (is_first_) {
      propagation_.run(surface_, faces_, sources_, limits_);
    } else {
      propagation_.run_further(sources_, limits_);
    }
    is_first_ = false;
    std::vector<Index> nearer;
    for (const Index v : propagation_.reached()) {
      if (propagation_.came_nearer(v)) nearer.push_back(v);
    }
    return nearer;
  }
  ///@}

  /// Distance of a vertex from the nearest source so far, +infinity where there is none. Throws
  /// InvalidInput for a vertex that is not of the surface, and a distance that T cannot hold.
  [[nodiscard]] T distance(Index vertex) const {
    surface_.require_vertex(vertex);
    if (is_first_) return unreachable<T>;
    const Real start = starts_[surface_.components()[vertex]];
    return detail::distance_as<T>(start + propagation_.distances[vertex], "vertex ", vertex);
  }

  /// The surface.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

 private:
  using Real = typename detail::WorkingPrecision<T>::Real;

  // What the distances of a source's part count from: its earliest source, this one with it. So
  // none is negative, and numbers are no larger than the part.
  [[nodiscard]] Real start_of_part(const Source<Real>& source) {
    const Index part = detail::part_of(surface_, source.point);
    Real& start = starts_[part];
    if (!(source.distance < start)) return start;
    const bool is_first_there = start == unreachable<Real>;
    const Real later = start - source.distance;
    start = source.distance;
    if (is_first_there) return start;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (surface_.components()[v] == part) propagation_.distances[v] += later;
    }
    return start;
  }

  Surface<Real> surface_;
  detail::PlanarFaces<Real> faces_;
  Real longest_way_;
  detail::Array<Real> starts_;  // of each part, at its number
  detail::WindowPropagation<Real> propagation_;
  detail::PropagationLimits<Real> limits_;
  detail::Array<Source<Real>> sources_;
  bool is_first_ = true;
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

/// The nearest site of each vertex, one of `sites`; -1 where no path leads to any. Of several as
/// near the first of `sites`, but for rounding.
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
