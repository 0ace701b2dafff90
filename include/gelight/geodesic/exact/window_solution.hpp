#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/directions.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_list.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What an exact solve leaves behind: all that queries, searches and backtraces read.
template <std::floating_point Real>
struct WindowSolution {
  using Point = SurfacePoint<Real>;

  Surface<Real> surface;
  std::shared_ptr<const PlanarFaces<Real>> faces;
  Starts<Real> starts{};
  Array<Source<Real>> sources{};       // their distances less those
  Array<SegmentFront<Real>> fronts{};  // of segments, theirs likewise
  Real size = 0;                       // of the mesh, where there are any
  Real bound = unreachable<Real>;      // beyond it nothing was computed
  Array<Real> distances{};             // of each vertex, less its start
  Array<Arrival<Real>> arrivals{};     // of each vertex
  Array<Origin<Real>> origins{};
  std::shared_ptr<const WindowStore<Real>> windows{};  // where any were kept
  Array<char> kept_faces{};                            // which, or empty for all
  bool bends_anywhere = false;                         // with a reset radius
  CancelHook cancelled{};
  std::size_t max_memory = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] Real bound_at(Index v) const {
    return PropagationLimits<Real>::counted_from(starts.of_vertex, bound, v);
  }

  [[nodiscard]] bool keeps_all_windows() const { return windows && kept_faces.empty(); }
  [[nodiscard]] bool keeps_windows(Index face) const {
    return windows && (kept_faces.empty() || kept_faces[face] != 0);
  }

  [[nodiscard]] const Point& source_point(Index source) const {
    return sources[static_cast<std::size_t>(source)].point;
  }
  /// Whether a source lies at a vertex that no other has reached before it starts.
  [[nodiscard]] bool is_source(Index vertex) const {
    const Arrival<Real>& last = arrivals[vertex];
    return last.entry == Arrival<Real>::from_source &&
           source_point(last.origin) == vertex_point<Real>(vertex);
  }
  /// Whether a path can begin or bend at a vertex.
  [[nodiscard]] bool begins_lines(Index vertex) const {
    return faces->bends_at(vertex) || is_source(vertex);
  }

  /// The least start distance of the sources at a point, and of the segments.
  [[nodiscard]] Real start_at(const Point& p) const {
    Real least = unreachable<Real>;
    for (const auto& source : sources) {
      if (source.point == p) least = std::min(least, source.distance);
    }
    for (const auto& front : fronts) {
      if (lies_on(front, p)) least = std::min(least, front.start);
    }
    return least;
  }

  /// Whether a point lies on a segment, but for rounding.
  [[nodiscard]] bool lies_on(const SegmentFront<Real>& front, const Point& p) const {
    const Point begin = face_point(front.face, front.begin),
                end = face_point(front.face, front.end);
    if (!share_face(surface, p, begin)) return false;
    constexpr Real same_place = 64 * std::numeric_limits<Real>::epsilon();
    const Real around = straight(surface, p, begin) + straight(surface, p, end);
    return around - straight(surface, begin, end) <= same_place * longest_side_at(surface, p);
  }

  /// Takes what a propagation found, or gives it back.
  void exchange(WindowPropagation<Real>& propagation, WindowStore<Real>& store) {
    std::swap(distances, propagation.distances);
    std::swap(arrivals, propagation.arrivals);
    std::swap(origins, propagation.origins);
    std::swap(store, propagation.kept);
  }

  /// Copies what a propagation found, but for its windows, which it gives away.
  void adopt(WindowPropagation<Real>& propagation) {
    bound = propagation.bound();
    distances = propagation.distances;
    arrivals = propagation.arrivals;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      if (distances[v] <= bound_at(v)) continue;
      distances[v] = unreachable<Real>;
      arrivals[v] = {};
    }
    origins = propagation.origins;
    if (propagation.keeps_any()) {
      windows = std::make_shared<const WindowStore<Real>>(std::move(propagation.kept));
      propagation.kept = {};
    }
  }
};

}  // namespace gelight::detail
