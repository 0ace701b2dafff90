#pragma once

#include <concepts>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What a solve leaves behind, by which paths are followed back.
template <std::floating_point Real>
struct Solved {
  const Surface<Real>& surface;
  const PlanarFaces<Real>& faces;
  const Array<Source<Real>>& sources;
  const Array<Real>& distances;          // of each vertex
  const Array<Arrival<Real>>& arrivals;  // of each vertex
  const Array<Origin<Real>>& origins;
};

}  // namespace gelight::detail
