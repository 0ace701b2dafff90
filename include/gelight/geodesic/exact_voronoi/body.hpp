#pragma once

#include <concepts>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact_voronoi.hpp"
#include "gelight/geodesic/exact_voronoi/border_tracer.hpp"

namespace gelight {

template <std::floating_point T>
auto exact_voronoi_edges(const ExactField<T>& field, const VoronoiEdgeOptions<T>& options)
    -> std::vector<VoronoiEdge<T>> {
  return detail::BorderTracer<T>(field, options).lines();
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template std::vector<VoronoiEdge<float>> exact_voronoi_edges(const ExactField<float>&,
                                                             const VoronoiEdgeOptions<float>&);
template std::vector<VoronoiEdge<double>> exact_voronoi_edges(const ExactField<double>&,
                                                              const VoronoiEdgeOptions<double>&);
}  // namespace gelight
#endif
