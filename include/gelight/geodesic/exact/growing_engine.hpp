#pragma once

#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What GrowingDistances work in.
template <std::floating_point T>
class GrowingEngine {
  using Real = typename WorkingPrecision<T>::Real;

 public:
  GrowingEngine(const Surface<double>& surface, const ExactOptions<T>& options)
      : surface_(surface),
        faces_(surface_),
        longest_way_(longest_way(surface_)),
        max_distance_(options.max_distance),
        cancelled_(options.cancelled),
        starts_(static_cast<std::size_t>(surface_.vertex_count()), unreachable<Real>) {
    limits_.memory = options.max_memory;
  }

  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

  std::vector<Index> add(const Source<T>& source, const CancelHook& cancelled) {
    sources_ = checked_sources(surface_, std::span<const Source<T>>(&source, 1));
    sources_[0].point = simplified(surface_, sources_[0].point);
    limits_.cancelled = [solvers = cancelled_, callers = cancelled](double done) {
      for (const CancelHook& hook : {solvers, callers}) hook.check(done, "adding a source");
      return false;
    };
    const Real start = start_of_part(sources_[0]);
    sources_[0].distance -= start;
    limits_.distance = max_distance_ - start;
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
      const bool is_within = propagation_.distances[v] <= limits_.distance;
      if (is_within && propagation_.came_nearer(v)) nearer.push_back(v);
    }
    return nearer;
  }

  [[nodiscard]] T distance(Index vertex) const {
    surface_.require_vertex(vertex);
    if (is_first_) return unreachable<T>;
    const Real start = starts_[surface_.components()[vertex]], way = propagation_.distances[vertex];
    if (!(way <= max_distance_ - start)) return unreachable<T>;
    return distance_as<T>(start + way, "vertex ", vertex);
  }

 private:
  // What the distances of a source's part count from: its earliest source, this one with it. So
  // none is negative, and numbers are no larger than the part.
  [[nodiscard]] Real start_of_part(const Source<Real>& source) {
    const Index part = part_of(surface_, source.point);
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
  PlanarFaces<Real> faces_;
  Real longest_way_;
  Real max_distance_;
  CancelHook cancelled_;
  Array<Real> starts_;  // of each part, at its number
  WindowPropagation<Real> propagation_;
  PropagationLimits<Real> limits_;
  Array<Source<Real>> sources_;
  bool is_first_ = true;
};

}  // namespace gelight::detail
