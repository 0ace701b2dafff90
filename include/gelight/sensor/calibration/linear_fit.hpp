#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/sensor/calibration/smoothness.hpp"
#include "gelight/shading/fitted.hpp"

namespace gelight::detail {

/// A pixel that a reflectance is fitted to.
struct FitSample {
  GelPoint point;
  Change change;  ///< the photograph's share over the background
  double weight;
  int press;
};

/// A row of a linear model: factors of the normal, ascending, times the terms of the place.
struct TermRow {
  struct Factor {
    int index;
    double share;
  };
  std::vector<Factor> factors;
  std::array<double, place_terms> place{};

  template <class Model>
  void fill(const Model& model, const GelPoint& p) {
    factors.clear();
    place = terms_of_place(p.x, p.y);
    model.for_factors(p, [&](int index, double share) { factors.push_back({index, share}); });
  }
};

/// The normal equations of a linear model; the same matrix for all three channels.
struct NormalEquations {
  Eigen::MatrixXd matrix;  // its lower triangle
  Eigen::MatrixXd right;
  double squares = 0, weight = 0;

  explicit NormalEquations(int size)
      : matrix(Eigen::MatrixXd::Zero(size, size)), right(Eigen::MatrixXd::Zero(size, 3)) {}

  void add(const TermRow& row, const Change& change, double w) {
    weight += w;
    constexpr std::ptrdiff_t n = place_terms;
    std::array<double, static_cast<std::size_t>(n * n)> products;
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) products[a * n + b] = w * row.place[a] * row.place[b];
    }
    const std::ptrdiff_t rows = matrix.rows();
    const TermRow::Factor* const end = row.factors.data() + row.factors.size();
    for (const TermRow::Factor* a = row.factors.data(); a != end; ++a) {
      for (std::size_t c = 0; c < 3; ++c) {
        double* const entries = right.data() + static_cast<std::ptrdiff_t>(c) * rows + n * a->index;
        for (std::size_t k = 0; k < n; ++k) entries[k] += w * change[c] * a->share * row.place[k];
      }
      for (const TermRow::Factor* b = a; b != end; ++b) {
        const double share = a->share * b->share;
        double* const block = matrix.data() + n * (a->index * rows + b->index);
        for (std::ptrdiff_t i = 0; i < n; ++i) {
          double* __restrict const column = block + i * rows;
          const double* __restrict const product = products.data() + i * n;
          for (std::ptrdiff_t k = 0; k < n; ++k) column[k] += share * product[k];
        }
      }
    }
    for (const double value : change) squares += w * value * value;
  }
  void add(const NormalEquations& other, double sign = 1) {
    matrix += sign * other.matrix;
    right += sign * other.right;
    squares += sign * other.squares;
    weight += sign * other.weight;
  }
  /// The sum of squares that a solution leaves.
  [[nodiscard]] double residual(const Eigen::MatrixXd& solution) const {
    double left = squares - 2 * right.cwiseProduct(solution).sum();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      for (Eigen::Index i = j; i < matrix.rows(); ++i) {
        double product = 0;
        for (Eigen::Index c = 0; c < 3; ++c) product += solution(i, c) * solution(j, c);
        left += (i == j ? 1 : 2) * matrix(i, j) * product;
      }
    }
    return left;
  }
};

/// Solves with the lower triangle of a positive definite matrix, which is overwritten. (One
/// function for all sizes, as its templates take long to compile.)
[[nodiscard]] inline Eigen::MatrixXd solve_in_place(Eigen::MatrixXd& matrix,
                                                    const Eigen::MatrixXd& right) {
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(matrix);
  require(factor.info() == Eigen::Success, "the presses do not determine the reflectance");
  return factor.solve(right);
}

// Of a pixel's weight, so that a table's node that no pixel tells anything of is a number.
inline constexpr double least_penalty = 1e-3;

[[nodiscard]] inline double place_penalty(const Smoothness& s, int term) {
  return term == 0 ? 1 : term < 3 ? s.place : s.place * s.place;
}

inline void add_penalty(Eigen::MatrixXd& matrix, const TableReflectance& table,
                        const Smoothness& smoothness, double weight) {
  const int n = table.nodes;
  for (int k = 0; k < place_terms; ++k) {
    const double w = weight * smoothness.normal * place_penalty(smoothness, k);
    const auto at = [&](int i, int j) { return (j * n + i) * place_terms + k; };
    const auto bend = [&](int a, int b, int c) {
      const std::array<int, 3> index{a, b, c};
      const std::array<double, 3> difference{1, -2, 1};
      for (std::size_t p = 0; p < 3; ++p) {
        for (std::size_t q = 0; q <= p; ++q) {
          matrix(index[p], index[q]) += w * difference[p] * difference[q];
        }
      }
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        if (i > 0 && i < n - 1) bend(at(i - 1, j), at(i, j), at(i + 1, j));
        if (j > 0 && j < n - 1) bend(at(i, j - 1), at(i, j), at(i, j + 1));
        matrix(at(i, j), at(i, j)) += least_penalty * w;
      }
    }
  }
}

inline void add_penalty(Eigen::MatrixXd& matrix, const PolynomialReflectance& polynomial,
                        const Smoothness& smoothness, double weight) {
  int power = 0;
  for (int total = 0; total <= polynomial.degree; ++total) {
    for (int of_v = 0; of_v <= total; ++of_v, ++power) {
      for (int k = 0; k < place_terms; ++k) {
        const int i = power * place_terms + k;
        matrix(i, i) += least_penalty * weight * smoothness.normal * (1 + total * total) *
                        place_penalty(smoothness, k);
      }
    }
  }
}

/// Which of a model's coefficients tell of the level normal: 0 in free gel.
[[nodiscard]] inline int level_block(const TableReflectance& table) {
  return table.nodes * table.nodes / 2;
}
[[nodiscard]] inline int level_block(const PolynomialReflectance&) { return 0; }

/// The coefficients of least squares, with second differences penalised.
template <class Model>
[[nodiscard]] Eigen::MatrixXd solve_smooth(const Model& model, const NormalEquations& equations,
                                           const Smoothness& smoothness, bool is_free) {
  // The weight of a press of some three thousand pixels is what penalties are measured in.
  constexpr double pixels_of_penalty = 3000;
  Eigen::MatrixXd matrix = equations.matrix;
  add_penalty(matrix, model, smoothness, equations.weight / pixels_of_penalty);
  if (is_free) {
    const int first = level_block(model) * place_terms;
    for (int k = first; k < first + place_terms; ++k) matrix(k, k) += 1e6 * (1 + equations.weight);
  }
  return solve_in_place(matrix, equations.right);
}

[[nodiscard]] inline std::vector<double> flat(const Eigen::MatrixXd& solution) {
  std::vector<double> numbers;
  numbers.reserve(static_cast<std::size_t>(solution.size()));
  for (Eigen::Index i = 0; i < solution.rows(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) numbers.push_back(solution(i, c));
  }
  return numbers;
}

}  // namespace gelight::detail
