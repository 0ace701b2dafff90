#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/bound_finder.hpp"
#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

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

/// What a Certifier works in.
template <std::floating_point T>
class CertifierEngine {
  using Real = typename WorkingPrecision<T>::Real;
  using Faces = PlanarFaces<Real>;
  using Sources = Array<Source<Real>>;
  using Values = Array<Real>;
  // Of the work, about: what the march to the upper bounds takes.
  static constexpr double march_share = 0.6;

 public:
  explicit CertifierEngine(Surface<Real> surface)
      : surface_(std::move(surface)), faces_(std::make_shared<const Faces>(surface_)) {}

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }

  [[nodiscard]] DistanceBounds<T> bounds_of(Sources sources, std::span<const T> distances,
                                            const CancelHook& cancelled) const;

 private:
  void require_distances(std::span<const T> distances) const {
    require(distances.size() == static_cast<std::size_t>(surface_.vertex_count()), "there are ",
            distances.size(), " distances, the mesh has ", surface_.vertex_count(), " vertices");
    for (std::size_t v = 0; v < distances.size(); ++v) {
      require(!std::isnan(distances[v]), "the distance of vertex ", v, " is not a number");
    }
  }

  Surface<Real> surface_;
  std::shared_ptr<const Faces> faces_;
};

template <std::floating_point T>
auto CertifierEngine<T>::bounds_of(Sources sources, std::span<const T> distances,
                                   const CancelHook& cancelled) const -> DistanceBounds<T> {
  require_distances(distances);
  const auto starts = move_to_zero(surface_, sources);
  const BoundFinder<Real> finder(surface_, *faces_);
  const Values upper = finder.upper(sources, cancelled.part(0, march_share));
  Values potential = upper;
  for (Index v = 0; v < surface_.vertex_count(); ++v) {
    const double given = static_cast<double>(distances[static_cast<std::size_t>(v)]) - starts.at(v);
    if (upper[v] < unreachable<double>) potential[v] = std::clamp(given, 0.0, upper[v]);
  }
  const Values lower = finder.lower(sources, std::move(potential), cancelled.part(march_share, 1));
  return moved<T>(lower, upper, starts);
}

}  // namespace gelight::detail
