#pragma once

#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/smooth/engine.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

template <std::floating_point T>
SmoothDistanceSolver<T>::SmoothDistanceSolver(const Surface<double>& surface,
                                              std::span<const std::array<T, 3>> normals,
                                              bool has_normals, const SmoothOptions<T>& options)
    : engine_(std::make_shared<const Engine>(surface, normals, has_normals, options)) {}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::surface() const -> const Surface<double>& {
  return engine_->surface();
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::position(const SurfacePoint<T>& point) const -> Vec3<T> {
  return engine_->position(point);
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::normals(Index vertex) const -> std::vector<Vec3<T>> {
  return engine_->normals(vertex);
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::path(const SmoothDistances<T>& distances,
                                   const SurfacePoint<T>& point) const -> SmoothPath<T> {
  return engine_->path(distances, point);
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::solve_vertices(detail::DistanceQuery<double>& query) const -> void {
  engine_->solve_vertices(query);
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::solve(std::span<const Index> vertices) const -> SmoothDistances<T> {
  return engine_->solve_checked(detail::checked_sources(surface(), vertices));
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::solve(std::span<const Source<T>> sources) const
    -> SmoothDistances<T> {
  return engine_->solve_checked(detail::checked_sources(surface(), sources));
}

template <std::floating_point T>
auto SmoothDistanceSolver<T>::solve(std::span<const SurfacePoint<T>> points) const
    -> SmoothDistances<T> {
  return engine_->solve_checked(detail::checked_sources(surface(), points));
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template class SmoothDistanceSolver<float>;
template class SmoothDistanceSolver<double>;
}  // namespace gelight
#endif
