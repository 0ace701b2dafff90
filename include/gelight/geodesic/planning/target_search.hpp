#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/lower_potential.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Exact distances of single vertices, searched for where approximate distances of all say that
/// they are: from the target back to the sources through what lower bounds do not show to be a
/// detour.
template <std::floating_point Real>
class TargetSearch {
 public:
  TargetSearch(const Surface<Real>& surface, const PlanarFaces<Real>& faces,
               Array<Source<Real>> sources, const std::vector<Real>& distances,
               CancelHook cancelled = {})
      : surface_(surface),
        faces_(faces),
        sources_(std::move(sources)),
        cancelled_(std::move(cancelled)) {
    starts_ = move_to_zero(surface_, sources_);
    find_least_ways(distances);
  }

  /// The exact distance, if it is at most `guess` and a share `width` of the way there more;
  /// infinite else. A narrow search takes less time, so that several are tried.
  [[nodiscard]] Real exact(Index target, Real guess, Real width) const {
    Real distance = unreachable<Real>;
    for (Real tried = std::min(width, narrowest); !(distance < unreachable<Real>);
         tried = std::min(width, tried * widening)) {
      distance = within((guess - starts_.at(target)) * (1 + tried + rounding), target);
      if (tried == width) break;
    }
    return distance;
  }

 private:
  static constexpr Real rounding = 1e-12;  // by which a search is wider than the bounds
  static constexpr Real narrowest = 2e-4, widening = 8;

  // The exact distance if it is at most `limit`. From vertices the search runs back from the
  // target, where the bounds keep it narrow; from other points forward, where straight distances
  // do.
  [[nodiscard]] Real within(Real limit, Index target) const {
    PropagationLimits<Real> limits;
    limits.distance = limit;
    limits.rest = least_ways_;
    if (cancelled_) limits.cancelled = [this] { return is_cancelled(); };
    WindowPropagation<Real> propagation;
    if (!are_vertices()) {
      for (Index v = 0; v < surface_.vertex_count(); ++v) {
        const Vec3<Real> way = surface_.position(v) - surface_.position(target);
        limits.rest[v] = stable_norm(way) * (1 - rounding);
      }
      propagation.run(surface_, faces_, sources_, limits);
      return starts_.at(target) + propagation.distances[target];
    }
    propagation.run(surface_, faces_, {{vertex_point<Real>(target), 0}}, limits);
    Real distance = unreachable<Real>;
    for (const auto& source : sources_) {
      const Real way = propagation.distances[source.point.element[0]];
      distance = std::min(distance, source.distance + way);
    }
    return starts_.at(target) + distance;
  }

  // Lower bounds of what is left from each vertex to the sources.
  void find_least_ways(const std::vector<Real>& distances) {
    Array<Real> potential;
    potential.reserve(distances.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      potential.push_back(
          std::max(Real{0}, distances[static_cast<std::size_t>(v)] - starts_.at(v)));
    }
    least_ways_ = LowerPotential<Real>(surface_, faces_).bounds(potential, sources_);
    for (Real& way : least_ways_) way = std::max(Real{0}, way * (1 - rounding));
  }

  [[nodiscard]] bool is_cancelled() const {
    cancelled_.check(0, "the search for a target");
    return false;
  }

  [[nodiscard]] bool are_vertices() const {
    return std::all_of(sources_.begin(), sources_.end(), [](const Source<Real>& source) {
      return source.point.kind == SurfacePoint<Real>::Kind::vertex;
    });
  }

  const Surface<Real>& surface_;
  const PlanarFaces<Real>& faces_;
  Array<Source<Real>> sources_;
  CancelHook cancelled_;
  Starts<Real> starts_;
  Array<Real> least_ways_;
};

}  // namespace gelight::detail
