#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/lower_potential.hpp"
#include "gelight/geodesic/bounds/upper_march.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// How far distances can be from the exact ones, as a share of these, where those are not zero.
struct RelativeError {
  double mean = 0;  ///< Over the vertices that are reached and no sources.
  double max = 0;   ///< The largest of all.
};

/// Two numbers between which the exact polyhedral distance of each vertex lies.
template <std::floating_point T>
struct DistanceBounds {
  std::vector<T> lower;  ///< Of each vertex; +infinity where no path leads.
  std::vector<T> upper;  ///< Of each vertex; +infinity where no path leads.

  /// The largest error that distances can have, given the bounds: infinite where a lower bound is
  /// zero, where a distance is not finite but the bounds are, and the other way round. Throws
  /// InvalidInput for another number of distances.
  [[nodiscard]] RelativeError error_of(std::span<const T> distances) const {
    detail::require(distances.size() == upper.size(), "there are ", distances.size(),
                    " distances for ", upper.size(), " vertices");
    RelativeError error;
    std::size_t count = 0;
    for (std::size_t v = 0; v < upper.size(); ++v) {
      const double d{distances[v]}, low{lower[v]}, high{upper[v]};
      if (d == low && d == high && (d == 0 || std::isinf(d)))
        continue;  // a source, or out of reach
      const bool is_bounded = low > 0 && std::isfinite(high) && std::isfinite(d);
      const double off = is_bounded ? std::max(std::abs(d / low - 1), std::abs(d / high - 1))
                                    : unreachable<double>;
      error.mean += off;
      error.max = std::max(error.max, off);
      ++count;
    }
    error.mean /= static_cast<double>(std::max<std::size_t>(1, count));
    return error;
  }
};

namespace detail {

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

/// To the next number in this direction, but for zero and infinity.
template <std::floating_point T>
[[nodiscard]] T rounded(double value, T direction) {
  if (value == 0 || std::isinf(value)) return static_cast<T>(value);
  return std::nextafter(static_cast<T>(value), direction);
}

/// Bounds that count from where the sources start, from such that count from zero.
template <std::floating_point T, std::floating_point Real>
[[nodiscard]] DistanceBounds<T> moved(const Array<Real>& lower, const Array<Real>& upper,
                                      const Starts<Real>& starts) {
  DistanceBounds<T> out;
  out.lower.reserve(upper.size());
  out.upper.reserve(upper.size());
  for (Index v = 0; v < std::ssize(upper); ++v) {
    const double low = starts.at(v) + std::min(lower[v], upper[v]), high = starts.at(v) + upper[v];
    out.lower.push_back(rounded(low, -unreachable<T>));
    out.upper.push_back(rounded(high, unreachable<T>));
    require(std::isinf(out.upper.back()) == std::isinf(high), "the distance of vertex ", v,
            " may be ", high, ", beyond the numbers of the type it is asked in");
  }
  return out;
}

}  // namespace detail

/// Bounds on the exact polyhedral distance of every vertex, from approximate distances of any
/// origin. They are proved; sums are rounded to the safe side, and what the faces' shapes are
/// rounded by is left: some 1e-15 of the distances, at any distance from the origin.
///
/// Upper bounds are lengths of real paths, found by a march of their own (detail::UpperMarch); they
/// do not depend on what is given. Lower bounds take the given distances for a potential whose
/// gradient is at most 1 but for what is taken off (detail::LowerPotential); the better the
/// distances, the tighter they are, and never wrong.
///
/// Set-up is linear in the mesh, a query about n log n: some 0.4 of an exact solve at 40,000
/// vertices, less beyond. Between the bounds lie, as a share, on average 0.4 % on icospheres of
/// 40,962 vertices, 0.04 % on a GelTip membrane, given fast marching.
template <std::floating_point T>
class Certifier {
 public:
  /// Throws InvalidInput as Surface does.
  template <TriangleMesh M>
  explicit Certifier(const M& mesh)
      : surface_(mesh), faces_(std::make_shared<const Faces>(surface_)) {}

  /// Bounds on the distance from a vertex, from the nearest of several, or of several points with
  /// start distances, given distances from there: one for each vertex. Any number may be wrong.
  /// Throws InvalidInput for sources as a solver does, another number of distances than vertices,
  /// NaN, and an upper bound that T cannot hold; Cancelled where the hook says so.
  ///@{
  [[nodiscard]] DistanceBounds<T> bounds(Index vertex, std::span<const T> distances,
                                         const CancelHook& cancelled = {}) const {
    return bounds(std::span<const Index>(&vertex, 1), distances, cancelled);
  }
  [[nodiscard]] DistanceBounds<T> bounds(std::span<const Index> vertices,
                                         std::span<const T> distances,
                                         const CancelHook& cancelled = {}) const {
    return bounds_of(detail::checked_sources(surface_, vertices), distances, cancelled);
  }
  [[nodiscard]] DistanceBounds<T> bounds(std::span<const Source<T>> sources,
                                         std::span<const T> distances,
                                         const CancelHook& cancelled = {}) const {
    return bounds_of(detail::checked_sources(surface_, sources), distances, cancelled);
  }
  ///@}

 private:
  using Real = typename detail::WorkingPrecision<T>::Real;
  using Faces = detail::PlanarFaces<Real>;
  using Sources = detail::Array<Source<Real>>;
  using Values = detail::Array<Real>;
  // Of the work, about: what the march to the upper bounds takes.
  static constexpr double march_share = 0.6;

  [[nodiscard]] DistanceBounds<T> bounds_of(Sources sources, std::span<const T> distances,
                                            const CancelHook& cancelled) const;

  void require_distances(std::span<const T> distances) const {
    detail::require(distances.size() == static_cast<std::size_t>(surface_.vertex_count()),
                    "there are ", distances.size(), " distances, the mesh has ",
                    surface_.vertex_count(), " vertices");
    for (std::size_t v = 0; v < distances.size(); ++v) {
      detail::require(!std::isnan(distances[v]), "the distance of vertex ", v, " is not a number");
    }
  }

  Surface<Real> surface_;
  std::shared_ptr<const Faces> faces_;
};

template <std::floating_point T>
auto Certifier<T>::bounds_of(Sources sources, std::span<const T> distances,
                             const CancelHook& cancelled) const -> DistanceBounds<T> {
  require_distances(distances);
  const auto starts = detail::move_to_zero(surface_, sources);
  const detail::BoundFinder<Real> finder(surface_, *faces_);
  const Values upper = finder.upper(sources, cancelled.part(0, march_share));
  Values potential = upper;
  for (Index v = 0; v < surface_.vertex_count(); ++v) {
    const double given = double{distances[static_cast<std::size_t>(v)]} - starts.at(v);
    if (upper[v] < unreachable<double>) potential[v] = std::clamp(given, 0.0, upper[v]);
  }
  const Values lower = finder.lower(sources, std::move(potential), cancelled.part(march_share, 1));
  return detail::moved<T>(lower, upper, starts);
}

template <TriangleMesh M>
explicit Certifier(const M&) -> Certifier<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class Certifier<float>;
GELIGHT_ONCE template class Certifier<double>;
}  // namespace gelight
#endif
