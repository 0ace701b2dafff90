#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/backtrace.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// The mean of `error_at(vertex)` over some vertices: of so many, spread evenly, and of up to 256
/// until the mean is on one side of `bound` by three standard errors.
[[nodiscard]] double sampled_mean(const Array<Index>& vertices, Index samples, double bound,
                                  auto&& error_at) {
  constexpr Index most_samples = 256;
  constexpr double sureness = 3, golden_share = 0.6180339887498949;
  if (vertices.empty()) return 0;
  const auto size = static_cast<double>(vertices.size());
  double sum = 0, squares = 0, mean = 0;
  Index count = 0;
  for (; samples <= most_samples; samples *= 4) {
    for (; count < samples; ++count) {
      const double turns = (count + 0.5) * golden_share;
      const auto which = static_cast<std::ptrdiff_t>((turns - std::floor(turns)) * size);
      const double error = error_at(vertices[std::min(which, std::ssize(vertices) - 1)]);
      sum += error;
      squares += error * error;
    }
    mean = sum / count;
    const double spread = std::sqrt(std::max(0.0, squares / count - mean * mean) / count);
    if (std::abs(mean - bound) > sureness * spread) break;
  }
  return mean;
}

/// Estimates the mean relative error of distances, some of which are exact, by the lengths of taut
/// paths that they lead along from at least `samples` vertices. The distances of each connected
/// part count from its earliest source.
///
/// By how much a path was pulled shorter is counted as error, too: about so much it is still too
/// long. Where a path ends before what is exact, half of what the distances say is left counts.
template <std::floating_point Real>
[[nodiscard]] Real sampled_error(const Surface<Real>& surface, const Array<Real>& distance,
                                 const Array<char>& is_exact, Real bound, Index samples) {
  Sources known;
  Array<Index> targets;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    if (is_exact[v]) {
      known.push_back({vertex_point<Real>(v), distance[v]});
    } else if (distance[v] < unreachable<Real>) {
      targets.push_back(v);
    }
  }
  if (targets.empty()) return 0;
  const auto reached = static_cast<Real>(targets.size() + known.size());
  const Real share = static_cast<Real>(targets.size()) / reached;
  Backtrace<Real> way(surface, std::move(known), distance);
  const auto error_at = [&](Index v) {
    const auto [length, left, has_arrived] = way.walk(v);
    const Real d = std::max(0.0, distance[v]);
    if (!has_arrived) {
      const Real off = std::abs(d - length.walked - left) + left / 2;
      return d > 0 ? std::min(1.0, off / d) : 1.0;
    }
    const Real taut = length.taut;
    if (!(taut > 0)) return 0.0;
    return (std::abs(d - taut) + std::max(0.0, length.walked - length.taut)) / taut;
  };
  return share * sampled_mean(targets, samples, bound / share, error_at);
}

}  // namespace gelight::detail
