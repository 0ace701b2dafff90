#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <stdexcept>
#include <type_traits>

#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/numbers.hpp"

namespace gelight::detail {

/// A complex number's conjugate, a real number itself.
template <class Scalar>
[[nodiscard]] Scalar conjugate(const Scalar& x) {
  if constexpr (std::is_floating_point_v<Scalar>) {
    return x;
  } else {
    return std::conj(x);
  }
}

/// Elimination of the first unknowns of a dense positive definite matrix: the step of which a
/// multifrontal factorisation is made. Matrices lie column by column, of squares the lower
/// triangle.
template <class Scalar>
class Front {
 public:
  /// How many values beyond its last one a block or an update is read; what is there has no effect.
  static constexpr Index overhang = 64;

  /// `block` is the first `own` columns, of `height` rows; `update` the square left over.
  Front(Scalar* block, Index own, Index height, Scalar* update)
      : block_(block), own_(own), height_(height), border_(height - own), update_(update) {}

  /// Turns the block into the columns of the Cholesky factor, and subtracts from the update what
  /// they change there. Throws std::runtime_error where a pivot is not positive.
  void eliminate() const;

 private:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Packet = detail::Packet<Scalar>;
  static constexpr Index width = Packet::width;
  static constexpr Index tile_columns = 4;
  static constexpr Index small_height = 128;
  static_assert(2 * width + tile_columns <= overhang);

  void eliminate_large() const;

  // A few columns at a time, from the left: for blocks too small to repay Eigen's preparations.
  void eliminate_small() const {
    for (Index j = 0; j < own_; j += tile_columns) {
      const Index columns = std::min(tile_columns, own_ - j);
      Scalar* const pivots = block_ + std::ptrdiff_t{j} * height_ + j;
      subtract_products({pivots, height_, height_ - j, columns}, block_ + j, j);
      finish({pivots, height_, height_ - j, columns});
    }
    for (Index j = 0; j < border_; j += tile_columns) {
      subtract_products({update_ + std::ptrdiff_t{j} * border_ + j, border_, border_ - j,
                         std::min(tile_columns, border_ - j)},
                        block_ + own_ + j, own_);
    }
  }

  /// At most tile_columns columns, the first row of each on the first one's diagonal.
  struct Columns {
    Scalar* values;
    Index stride, rows, count;

    [[nodiscard]] Scalar* operator[](Index j) const { return values + std::ptrdiff_t{j} * stride; }
  };

  // target(i, j) -= sum over k < count of row(i, k) conj(row(j, k)), where `row` is the block from
  // the target's first row on.
  void subtract_products(const Columns& target, const Scalar* row, Index count) const {
    if (count == 0) return;
    constexpr Index most = std::is_floating_point_v<Scalar> ? 2 : 1;  // packets
    Index i = 0;
    for (; target.rows - i > (most - 1) * width; i += most * width) {
      subtract_tile<most>(target, i, row, count);
    }
    if (i < target.rows) subtract_tile<1>(target, i, row, count);
  }

  // The same for the rows from the i-th on that fit in some packets, with the sums in registers.
  template <Index packets>
  void subtract_tile(const Columns& target, Index i, const Scalar* right, Index count) const {
    const Scalar* left = right + i;
    Packet sum[tile_columns][packets];
    for (Index k = 0; k < count; ++k, left += height_, right += height_) {
      Packet x[packets];
      for (Index p = 0; p < packets; ++p) x[p] = Packet::load(left + p * width);
      for (Index j = 0; j < tile_columns; ++j) {
        const Scalar y = conjugate(right[j]);
        for (Index p = 0; p < packets; ++p) sum[j][p].add_product(x[p], y);
      }
    }
    for (Index j = 0; j < target.count; ++j) {
      Index row = i;
      for (const Packet& packet : sum[j]) {
        if (row >= target.rows) break;
        Scalar* const at = target[j] + row;
        Packet rest = Packet::load(at);
        rest.subtract(packet);
        rest.store(at, target.rows - row);
        row += width;
      }
    }
  }

  // Turns columns that lack only each other's products into those of the factor.
  static void finish(const Columns& columns) {
    std::array<double, tile_columns> inverses{};
    double* const inverse = inverses.data();
    for (Index j = 0; j < columns.count; ++j) {
      Scalar* const column = columns[j];
      for (Index k = 0; k < j; ++k) {
        const Scalar factor = conjugate(columns[k][j]);
        for (Index i = j; i < columns.count; ++i) column[i] -= columns[k][i] * factor;
      }
      const double pivot = std::real(column[j]);
      require_positive(pivot > 0);
      const double root = std::sqrt(pivot);
      inverse[j] = 1 / root;
      column[j] = root;
      for (Index i = j + 1; i < columns.count; ++i) column[i] *= inverse[j];
    }
    for (Index i = columns.count; i < columns.rows; i += width) {
      Packet packets[tile_columns];
      for (Index j = 0; j < columns.count; ++j) {
        Packet& x = packets[j];
        x = Packet::load(columns[j] + i);
        for (Index k = 0; k < j; ++k) x.subtract_product(packets[k], conjugate(columns[k][j]));
        x.scale(inverse[j]);
        x.store(columns[j] + i, columns.rows - i);
      }
    }
  }

  static void require_positive(bool is_positive) {
    if (is_positive) return;
    throw std::runtime_error("the Cholesky factorisation met a pivot that is not positive");
  }

  Scalar* block_;
  Index own_, height_, border_;
  Scalar* update_;
};

template <class Scalar>
void Front<Scalar>::eliminate() const {
  if (own_ == 0) return;
  if (height_ <= small_height) {
    eliminate_small();
  } else {
    eliminate_large();
  }
}

template <class Scalar>
void Front<Scalar>::eliminate_large() const {
  Eigen::Map<Matrix> block(block_, height_, own_);
  using Pivots = Eigen::Ref<Matrix, 0, Eigen::OuterStride<>>;
  Pivots pivots = block.topRows(own_);
  const Eigen::LLT<Pivots> factor(pivots);
  // Eigen lets a pivot pass that is not a number; all that follow are none then.
  require_positive(factor.info() == Eigen::Success && std::real(pivots(own_ - 1, own_ - 1)) > 0);
  if (border_ == 0) return;
  auto below = block.bottomRows(border_);
  pivots.template triangularView<Eigen::Lower>().adjoint().template solveInPlace<Eigen::OnTheRight>(
      below);
  Eigen::Map<Matrix> rest(update_, border_, border_);
  rest.template selfadjointView<Eigen::Lower>().rankUpdate(below, Scalar(-1));
}

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::Front<double>;
GELIGHT_ONCE template class detail::Front<std::complex<double>>;
}  // namespace gelight
#endif
