#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numeric>

#include "gelight/core/types.hpp"

namespace gelight::detail {

/// The eigenvalues of a symmetric matrix, ascending, and the unit vectors that belong to them.
template <std::floating_point Real>
struct PrincipalAxes {
  std::array<Real, 3> values;
  std::array<Vec3<Real>, 3> axes;
};

/// By rotations that clear one entry after the other (Jacobi, Über ein leichtes Verfahren, 1846,
/// doi:10.1515/crll.1846.30.51). Eigen's own solver would take as long to include as Eigen/Core.
template <std::floating_point Real>
[[nodiscard]] PrincipalAxes<Real> principal_axes(Eigen::Matrix<Real, 3, 3> a) {
  constexpr int most_sweeps = 32;  // four or five are enough
  Eigen::Matrix<Real, 3, 3> v;
  for (int i = 0; i < 9; ++i) v(i / 3, i % 3) = i % 4 == 0 ? 1 : 0;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    if (a(0, 1) == 0 && a(0, 2) == 0 && a(1, 2) == 0) break;
    for (const auto& [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      if (a(p, q) == 0) continue;
      const Real cot = (a(q, q) - a(p, p)) / (2 * a(p, q));  // of twice the angle
      const Real tan = (cot < 0 ? -1 : 1) / (std::abs(cot) + std::hypot(cot, Real{1}));
      const Real cos = 1 / std::sqrt(tan * tan + 1), sin = tan * cos;
      const int other = 3 - p - q;
      const Real at_p = a(p, other), at_q = a(q, other);
      a(p, p) -= tan * a(p, q);
      a(q, q) += tan * a(p, q);
      a(p, q) = a(q, p) = 0;
      a(p, other) = a(other, p) = cos * at_p - sin * at_q;
      a(q, other) = a(other, q) = sin * at_p + cos * at_q;
      for (int i = 0; i < 3; ++i) {
        const Real x = v(i, p), y = v(i, q);
        v(i, p) = cos * x - sin * y;
        v(i, q) = sin * x + cos * y;
      }
    }
  }
  std::array order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int j) { return a(i, i) < a(j, j); });
  PrincipalAxes<Real> result;
  for (std::size_t k = 0; k < 3; ++k) {
    const int i = order[k];
    result.values[k] = a(i, i);
    result.axes[k] = {v(0, i), v(1, i), v(2, i)};
  }
  return result;
}

}  // namespace gelight::detail
