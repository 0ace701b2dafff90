#pragma once

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

// Numbers at pixels from how they change from a pixel to the next: right (0) and down (1).

/// Those whose steps between all neighbours come nearest to the slopes given, the means of both
/// pixels', in least squares: a Poisson equation. The first is 0.
[[nodiscard]] inline gelight::Image<double> from_slopes(
    const gelight::Image<gelight::Vec2<double>>& slopes) {
  using gelight::Index;
  const Index width = slopes.width(), height = slopes.height();
  std::vector<Eigen::Triplet<double>> laplacian{{0, 0, 1.0}};  // holds the first pixel
  Eigen::VectorXd divergence = Eigen::VectorXd::Zero(width * height);
  for (Index v = 0; v < height; ++v) {
    for (Index u = 0; u < width; ++u) {
      for (const int axis : {0, 1}) {
        const Index u1 = u + 1 - axis, v1 = v + axis;
        if (u1 == width || v1 == height) continue;
        const double step = 0.5 * (slopes(u, v)[axis] + slopes(u1, v1)[axis]);
        const Index a = v * width + u, b = v1 * width + u1;
        laplacian.insert(laplacian.end(), {{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}});
        divergence[a] -= step;
        divergence[b] += step;
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(width * height, width * height);
  matrix.setFromTriplets(laplacian.begin(), laplacian.end());
  const Eigen::VectorXd sums =
      Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(divergence);
  gelight::Image<double> result(width, height);
  for (Index i = 0; i < width * height; ++i) result(i % width, i / width) = sums[i] - sums[0];
  return result;
}

/// By walking: down the first column, then along each row, from 0.
[[nodiscard]] inline gelight::Image<double> walked_along(
    const gelight::Image<gelight::Vec2<double>>& slopes) {
  using gelight::Index;
  gelight::Image<double> result(slopes.width(), slopes.height(), 0);
  for (Index v = 0; v < slopes.height(); ++v) {
    if (v > 0) result(0, v) = result(0, v - 1) + slopes(0, v - 1)[1];
    for (Index u = 1; u < slopes.width(); ++u) {
      result(u, v) = result(u - 1, v) + slopes(u - 1, v)[0];
    }
  }
  return result;
}

/// How far two images are apart, as the root of the mean square.
[[nodiscard]] inline double rms(const gelight::Image<double>& a, const gelight::Image<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    sum += std::pow(a.pixels()[i] - b.pixels()[i], 2);
  }
  return std::sqrt(sum / static_cast<double>(a.pixels().size()));
}
