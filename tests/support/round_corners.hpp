#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::test {

using Point2 = std::array<double, 2>;

/// Shortest paths in the plane from `source` to every vertex, round corners, by way of what sees
/// what: `sees(p, q)` tells whether nothing lies between two points.
std::vector<double> round_corners(const Mesh<double>& mesh, const Point2& source,
                                  const std::vector<Point2>& corners, const auto& sees) {
  const auto apart = [](const Point2& a, const Point2& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1]);
  };
  std::vector<double> to_corner(corners.size(), unreachable<double>);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (sees(source, corners[i])) to_corner[i] = apart(source, corners[i]);
  }
  for (bool is_shorter = true; is_shorter;) {
    is_shorter = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t j = 0; j < corners.size(); ++j) {
        const double way = to_corner[i] + apart(corners[i], corners[j]);
        if (!(way < to_corner[j]) || !sees(corners[i], corners[j])) continue;
        to_corner[j] = way;
        is_shorter = true;
      }
    }
  }
  std::vector<double> truth;
  for (const auto& p : mesh.positions) {
    const Point2 q{p[0], p[1]};
    double best = sees(source, q) ? apart(source, q) : unreachable<double>;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double way = to_corner[i] + apart(corners[i], q);
      if (way < best && sees(corners[i], q)) best = way;
    }
    truth.push_back(best);
  }
  return truth;
}

/// Whether a segment passes through the inside of a convex polygon, given anticlockwise; along a
/// side is not inside.
inline bool passes(const Point2& p, const Point2& q, std::span<const Point2> polygon) {
  constexpr double inside = 1e-9;  // of a side of length one
  double enter = 0, leave = 1;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const auto depth = [&](const Point2& x) {
      return (b[0] - a[0]) * (x[1] - a[1]) - (b[1] - a[1]) * (x[0] - a[0]) - inside;
    };
    const double from = depth(p), to = depth(q);
    if (from <= 0 && to <= 0) return false;
    if (from > 0 && to > 0) continue;
    const double crossing = from / (from - to);
    if (from > 0) {
      leave = std::min(leave, crossing);
    } else {
      enter = std::max(enter, crossing);
    }
  }
  return enter < leave;
}

}  // namespace gelight::test
