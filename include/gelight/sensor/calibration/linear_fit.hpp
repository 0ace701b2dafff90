#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/shading/fitted.hpp"

namespace gelight::detail {

/// A pixel that a reflectance is fitted to.
struct FitSample {
  GelPoint point;
  Change change;  ///< the photograph's share over the background
  double weight;
  int press;
};

/// The normal equations of a linear model; the same matrix for all three channels.
struct NormalEquations {
  Eigen::MatrixXd matrix;  // its lower triangle
  Eigen::MatrixX3d right;
  double squares = 0, weight = 0;

  explicit NormalEquations(int size)
      : matrix(Eigen::MatrixXd::Zero(size, size)), right(Eigen::MatrixX3d::Zero(size, 3)) {}

  void add(const TermRow& row, const Change& change, double w) {
    weight += w;
    for (std::size_t a = 0; a < row.index.size(); ++a) {
      const int i = row.index[a];
      const double scaled = w * row.value[a];
      for (std::size_t c = 0; c < 3; ++c) right(i, static_cast<int>(c)) += scaled * change[c];
      double* const column = matrix.data() + std::ptrdiff_t{i} * matrix.rows();
      // A row's indices ascend.
      for (std::size_t b = a; b < row.index.size(); ++b)
        column[row.index[b]] += scaled * row.value[b];
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
  [[nodiscard]] double residual(const Eigen::MatrixX3d& solution) const {
    const Eigen::MatrixX3d product = matrix.selfadjointView<Eigen::Lower>() * solution;
    return squares - 2 * right.cwiseProduct(solution).sum() + solution.cwiseProduct(product).sum();
  }
};

/// How a linear model is kept smooth: weights of the squares of its second differences along the
/// normal, for the constant term of the place; a power of `place` more for each degree in it.
struct Smoothness {
  double normal = 1, place = 3;
};

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
[[nodiscard]] Eigen::MatrixX3d solve_smooth(const Model& model, const NormalEquations& equations,
                                            const Smoothness& smoothness, bool is_free,
                                            const Eigen::MatrixX3d* towards = nullptr) {
  // The weight of a press of some three thousand pixels is what penalties are measured in.
  constexpr double pixels_of_penalty = 3000;
  const double unit = equations.weight / pixels_of_penalty;
  Eigen::MatrixXd matrix = equations.matrix;
  add_penalty(matrix, model, smoothness, unit);
  Eigen::MatrixX3d right = equations.right;
  if (towards != nullptr) right -= equations.matrix.selfadjointView<Eigen::Lower>() * *towards;
  if (is_free) {
    const int first = level_block(model) * place_terms;
    for (int k = first; k < first + place_terms; ++k) matrix(k, k) += 1e6 * (1 + equations.weight);
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(matrix);
  require(factor.info() == Eigen::Success, "the presses do not determine the reflectance");
  Eigen::MatrixX3d solution = factor.solve(right);
  if (towards != nullptr) solution += *towards;
  return solution;
}

[[nodiscard]] inline std::vector<double> flat(const Eigen::MatrixX3d& solution) {
  std::vector<double> numbers;
  numbers.reserve(static_cast<std::size_t>(solution.size()));
  for (Eigen::Index i = 0; i < solution.rows(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) numbers.push_back(solution(i, c));
  }
  return numbers;
}

}  // namespace gelight::detail
