#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Two zero bits before each of the lowest 21 bits.
[[nodiscard]] constexpr std::uint64_t spread_bits(std::uint64_t bits) {
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

/// The numbers of points in their order along Morton's curve through the box of them all, which
/// mostly goes from a cell to one beside it; those that are not finite come last.
template <std::floating_point T>
[[nodiscard]] Array<Index> space_order(const std::vector<std::array<T, 3>>& points) {
  // Halves, lest the size of the box be infinite.
  const auto half = [](const std::array<T, 3>& p, std::size_t k) {
    return static_cast<double>(p[k]) / 2;
  };
  const auto is_finite = [&](const std::array<T, 3>& p) {
    return std::isfinite(half(p, 0)) && std::isfinite(half(p, 1)) && std::isfinite(half(p, 2));
  };
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{infinity, infinity, infinity};
  for (const auto& p : points) {
    if (!is_finite(p)) continue;
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], half(p, k));
  }
  double size = 0;
  for (const auto& p : points) {
    if (!is_finite(p)) continue;
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, half(p, k) - low[k]);
  }
  const auto key = [&](const std::array<T, 3>& p) {
    if (!is_finite(p)) return std::numeric_limits<std::uint64_t>::max();
    constexpr double last_cell = 0x1fffff;
    std::uint64_t all = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double cell = size > 0 ? (half(p, k) - low[k]) / size * last_cell : 0;
      all |= spread_bits(static_cast<std::uint64_t>(cell)) << k;
    }
    return all;
  };
  Array<std::pair<std::uint64_t, Index>> keyed;
  keyed.reserve(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    keyed.push_back({key(points[v]), static_cast<Index>(v)});
  }
  std::sort(keyed.begin(), keyed.end());
  Array<Index> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order.data()[i] = keyed.data()[i].second;
  return order;
}

}  // namespace gelight::detail
