#pragma once

#include <algorithm>
#include <concepts>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/lower_potential.hpp"
#include "gelight/geodesic/bounds/upper_march.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Bounds of the distance from sources whose start distances count from the least of them.
template <std::floating_point Real>
class BoundFinder {
 public:
  BoundFinder(const Surface<Real>& surface, const PlanarFaces<Real>& faces)
      : surface_(surface), faces_(faces) {}

  [[nodiscard]] Array<Real> upper(const Array<Source<Real>>& sources,
                                  const CancelHook& cancelled = {}) const {
    return UpperMarch<Real>(surface_, faces_)(sources, cancelled);
  }

  /// From distances that are infinite where no path leads, and finite and not negative elsewhere:
  /// the better at each vertex of those from the distances as they are, and lowered where too
  /// steep.
  [[nodiscard]] Array<Real> lower(const Array<Source<Real>>& sources, Array<Real> distances,
                                  const CancelHook& cancelled = {}) const {
    const LowerPotential<Real> potential(surface_, faces_);
    const auto check = [&](double done) { cancelled.check(done, "the lower bounds"); };
    check(0);
    const Array<Real> as_given = potential.bounds(distances, sources);
    check(0.3);
    const Array<Real> lowered = potential.lowered(std::move(distances));
    check(0.7);
    Array<Real> best = potential.bounds(lowered, sources);
    check(1);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      best[v] = std::max({best[v], as_given[v], Real{0}});
    }
    return best;
  }

 private:
  const Surface<Real>& surface_;
  const PlanarFaces<Real>& faces_;
};

}  // namespace gelight::detail
