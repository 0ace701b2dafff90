#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// What every distance solver answers: the distance of each vertex from the nearest source, in the
/// unit of the positions, +infinity where no path leads.
template <class S, class T>
concept DistanceSolver = std::floating_point<T> &&
    requires(const S& solver, Index vertex, std::span<const Index> vertices,
             std::span<const Source<T>> sources, std::span<T> out) {
  { solver.distance(vertex) } -> std::same_as<std::vector<T>>;
  { solver.distance(vertices) } -> std::same_as<std::vector<T>>;
  { solver.distance(sources) } -> std::same_as<std::vector<T>>;
  solver.distance_into(out, vertex);
  solver.distance_into(out, vertices);
  solver.distance_into(out, sources);
};

namespace detail {

/// The precision in which a solver works inside: double, whatever T goes in and out. (Named by way
/// of T, so that what is made of it costs nothing to include.)
template <std::floating_point T>
struct WorkingPrecision {
  using Real = double;
};

using Sources = std::vector<Source<double>>;

template <std::floating_point Real, std::floating_point T>
[[nodiscard]] std::vector<Source<Real>> checked_sources(const Surface<Real>& surface,
                                                        std::span<const Source<T>> sources) {
  require(!sources.empty(), "there is no source");
  std::vector<Source<Real>> checked;
  checked.reserve(sources.size());
  for (const auto& source : sources) {
    surface.require_point(source.point);
    require(std::isfinite(source.distance), "source ", checked.size(), " starts with distance ",
            source.distance, ", which is not finite");
    checked.push_back({source.point.template cast<Real>(), Real{source.distance}});
  }
  return checked;
}

template <std::floating_point Real>
[[nodiscard]] std::vector<Source<Real>> checked_sources(const Surface<Real>& surface,
                                                        std::span<const Index> vertices) {
  require(!vertices.empty(), "there is no source");
  std::vector<Source<Real>> checked;
  checked.reserve(vertices.size());
  for (const Index vertex : vertices) {
    surface.require_vertex(vertex);
    checked.push_back({vertex_point<Real>(vertex), 0});
  }
  return checked;
}

/// Moves the start distances so that the earliest is 0, and returns what that was.
template <std::floating_point Real>
[[nodiscard]] Real move_to_zero(std::vector<Source<Real>>& sources) {
  Real earliest = unreachable<Real>;
  for (const auto& source : sources) earliest = std::min(earliest, source.distance);
  for (auto& source : sources) source.distance -= earliest;
  return earliest;
}

/// The overloads of DistanceSolver over one function of Solver,
/// `vector-like solve_vertices(const Sources&) const`: a distance per vertex.
template <class Solver, std::floating_point T>
class DistanceQueries {
 public:
  /// Distance of every vertex from a vertex.
  [[nodiscard]] std::vector<T> distance(Index vertex) const {
    return distance(std::span<const Index>(&vertex, 1));
  }
  /// Distance of every vertex from the nearest of several vertices.
  [[nodiscard]] std::vector<T> distance(std::span<const Index> vertices) const {
    return to_vector(solver().solve_vertices(checked_sources(surface(), vertices)));
  }
  /// Distance of every vertex from the nearest of several points, each with a start distance.
  [[nodiscard]] std::vector<T> distance(std::span<const Source<T>> sources) const {
    return to_vector(solver().solve_vertices(checked_sources(surface(), sources)));
  }

  /// The same, copied into the caller's memory: `out` has an element per vertex. What the solver
  /// works with is allocated as for `distance`; only the result is not.
  void distance_into(std::span<T> out, Index vertex) const {
    distance_into(out, std::span<const Index>(&vertex, 1));
  }
  void distance_into(std::span<T> out, std::span<const Index> vertices) const {
    require_size(out);
    copy(solver().solve_vertices(checked_sources(surface(), vertices)), out);
  }
  void distance_into(std::span<T> out, std::span<const Source<T>> sources) const {
    require_size(out);
    copy(solver().solve_vertices(checked_sources(surface(), sources)), out);
  }

 private:
  [[nodiscard]] const Solver& solver() const { return static_cast<const Solver&>(*this); }
  [[nodiscard]] const Surface<double>& surface() const { return solver().surface(); }

  void require_size(std::span<T> out) const {
    require(out.size() == static_cast<std::size_t>(surface().vertex_count()), "the output has ",
            out.size(), " elements, the mesh ", surface().vertex_count(), " vertices");
  }
  static void copy(const auto& distances, std::span<T> out) {
    std::size_t i = 0;
    for (const double d : distances) out[i++] = static_cast<T>(d);
  }
  static std::vector<T> to_vector(const auto& distances) {
    std::vector<T> out(distances.size());
    copy(distances, out);
    return out;
  }
};

}  // namespace detail
}  // namespace gelight
