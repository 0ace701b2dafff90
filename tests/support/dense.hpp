#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <utility>
#include <vector>

// Dense linear algebra in plain loops: a truth that shares nothing with what is tested, and that
// compiles in a fraction of the time that Eigen's factorisations take.

template <class Scalar>
using DenseMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
template <class Scalar>
using DenseVector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

/// Solves a x = b by elimination, with the largest number that is left for a pivot.
template <class Scalar>
[[nodiscard]] DenseVector<Scalar> by_elimination(DenseMatrix<Scalar> a, DenseVector<Scalar> b) {
  const Eigen::Index n = a.rows();
  const auto column = [&](Eigen::Index j) { return a.data() + j * n; };
  std::vector<Eigen::Index> unknown;
  for (Eigen::Index j = 0; j < n; ++j) unknown.push_back(j);
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index row = k, place = k;
    double most = -1;
    for (Eigen::Index j = k; j < n; ++j) {
      const Scalar* const values = column(j);
      for (Eigen::Index i = k; i < n; ++i) {
        const double size = std::norm(values[i]);
        if (size <= most) continue;
        most = size;
        row = i;
        place = j;
      }
    }
    for (Eigen::Index j = 0; j < n; ++j) std::swap(column(j)[k], column(j)[row]);
    std::swap(b[k], b[row]);
    std::swap_ranges(column(k), column(k) + n, column(place));
    std::swap(unknown[static_cast<std::size_t>(k)], unknown[static_cast<std::size_t>(place)]);
    Scalar* const pivots = column(k);
    for (Eigen::Index i = k + 1; i < n; ++i) {
      pivots[i] /= pivots[k];
      b[i] -= pivots[i] * b[k];
    }
    for (Eigen::Index j = k + 1; j < n; ++j) {
      Scalar* const values = column(j);
      const Scalar factor = values[k];
      if (factor == Scalar(0)) continue;
      for (Eigen::Index i = k + 1; i < n; ++i) values[i] -= pivots[i] * factor;
    }
  }
  DenseVector<Scalar> x(n);
  for (Eigen::Index k = n - 1; k >= 0; --k) {
    const Scalar value = b[k] / column(k)[k];
    for (Eigen::Index i = 0; i < k; ++i) b[i] -= column(k)[i] * value;
    x[unknown[static_cast<std::size_t>(k)]] = value;
  }
  return x;
}

/// The lower triangle of a positive definite matrix' Cholesky factor, with nothing above it.
template <class Scalar>
[[nodiscard]] DenseMatrix<Scalar> cholesky(const DenseMatrix<Scalar>& a) {
  const Eigen::Index n = a.rows();
  DenseMatrix<Scalar> factor = DenseMatrix<Scalar>::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) {
      Scalar sum = a(i, j);
      for (Eigen::Index k = 0; k < j; ++k) {
        sum -= factor(i, k) * Eigen::numext::conj(factor(j, k));
      }
      factor(i, j) = i == j ? std::sqrt(sum) : sum / factor(j, j);
    }
  }
  return factor;
}

/// The singular values of a matrix, the largest first, by Jacobi's rotations of its columns.
[[nodiscard]] inline DenseVector<double> singular_values(const DenseMatrix<double>& matrix) {
  DenseMatrix<double> a =
      matrix.rows() < matrix.cols() ? DenseMatrix<double>(matrix.transpose()) : matrix;
  double turned = 1;
  for (int sweep = 0; sweep < 60 && turned > 1e-15; ++sweep) {
    turned = 0;
    for (Eigen::Index p = 0; p < a.cols(); ++p) {
      for (Eigen::Index q = p + 1; q < a.cols(); ++q) {
        double pp = 0, qq = 0, pq = 0;
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
          pp += a(i, p) * a(i, p);
          qq += a(i, q) * a(i, q);
          pq += a(i, p) * a(i, q);
        }
        if (pq == 0) continue;
        turned = std::max(turned, std::abs(pq) / std::sqrt(pp * qq));
        const double angle = 0.5 * std::atan2(2 * pq, pp - qq);
        const double c = std::cos(angle), s = std::sin(angle);
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
          const double x = a(i, p), y = a(i, q);
          a(i, p) = c * x + s * y;
          a(i, q) = c * y - s * x;
        }
      }
    }
  }
  DenseVector<double> values(a.cols());
  for (Eigen::Index j = 0; j < a.cols(); ++j) values[j] = a.col(j).norm();
  std::sort(values.data(), values.data() + values.size(), std::greater<>());
  return values;
}
