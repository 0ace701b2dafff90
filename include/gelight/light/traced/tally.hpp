#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gelight/core/types.hpp"

// A room of light/traced.hpp: what is counted, and how sure it is.

namespace gelight::detail {

/// What rays bring to a vertex: power, power times direction, and power times direction over the
/// cosine of incidence.
struct Arrived {
  double power = 0;
  Vec3<double> way{0, 0, 0}, vector{0, 0, 0};
};

/// Where the power of a batch of paths ended.
struct Ends {
  double coating = 0, gel = 0, lost = 0, cut = 0;
};

/// What one batch of paths brought.
struct Batch {
  std::vector<Arrived> arrived;  // of each vertex
  Ends ends;
  double segments = 0;
};

/// Sums over batches of equally many paths, and of their products, from which the covariance of the
/// mean follows.
struct VertexSums {
  static constexpr std::size_t products = 10;
  Arrived sum;
  // Of (power, way) with itself, the upper triangle row by row.
  std::array<double, products> product{};
  double vector_squares = 0;
  int lit = 0;  // batches that brought anything

  void add(const Arrived& batch) {
    lit += batch.power > 0;
    sum.power += batch.power;
    sum.way += batch.way;
    sum.vector += batch.vector;
    const std::array<double, 4> x{batch.power, batch.way[0], batch.way[1], batch.way[2]};
    for (std::size_t i = 0, k = 0; i < 4; ++i) {
      for (std::size_t j = i; j < 4; ++j) product[k++] += x[i] * x[j];
    }
    vector_squares += squared_norm(batch.vector);
  }

  /// Covariance of the sums of (power, way) over `batches` batches.
  [[nodiscard]] Eigen::Matrix4d covariance(double batches) const {
    const Eigen::Vector4d s(sum.power, sum.way[0], sum.way[1], sum.way[2]);
    Eigen::Matrix4d c;
    for (int i = 0, k = 0; i < 4; ++i) {
      for (int j = i; j < 4; ++j) {
        const double central = product[static_cast<std::size_t>(k++)] - s[i] * s[j] / batches;
        c(i, j) = c(j, i) = central * batches / (batches - 1);
      }
    }
    return c;
  }

  /// Standard error of the vector's sum: the root of the summed variances of its three numbers.
  [[nodiscard]] double vector_error(double batches) const {
    const double central = vector_squares - squared_norm(sum.vector) / batches;
    return std::sqrt(std::max(0.0, central * batches / (batches - 1)));
  }
};

}  // namespace gelight::detail
