#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <stdexcept>
#include <type_traits>

#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
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

/// A dense positive definite matrix of which the first unknowns are eliminated: the step of which a
/// multifrontal factorisation is made. Matrices lie column by column, of squares the lower
/// triangle.
template <class Scalar>
struct Front {
  /// How many values beyond its last one a block or an update is read; what is there has no effect.
  static constexpr Index overhang = 64;

  Scalar* block;  // the first `own` columns, of `height` rows
  Index own, height;
  Scalar* update;  // the square left over

  /// Turns the block into the columns of the Cholesky factor, and subtracts from the update what
  /// they change there. Throws std::runtime_error where a pivot is not positive.
  void eliminate() const;
};

/// The same by registers that hold so many numbers; the results do not depend on how many.
template <class Scalar, Index width>
class FrontElimination {
 public:
  explicit FrontElimination(const Front<Scalar>& front) : front_(front) {}

  void run() {
    const Index own = front_.own, height = front_.height, border = height - own;
    for (Index begin = 0; begin < own; begin += panel_columns) {
      const Index end = std::min(begin + panel_columns, own), left = own - end;
      factor(begin, end);
      const Rows inner = rows(begin, end, end, left, inner_copy_);
      const Rows outer = rows(begin, end, own, border, outer_copy_);
      Scalar* const rest = column(end);
      subtract_square({rest + end, height, left, left}, inner);
      subtract_rectangle({rest + own, height, border, left}, outer, inner);
      subtract_square({front_.update, border, border, border}, outer);
    }
  }

 private:
  static constexpr Index tile_columns = 4;
  // So many columns are eliminated before what they change in all others is subtracted at once.
  static constexpr Index panel_columns = 64;
  // Of higher blocks a panel is copied for that, so that what is read in turn lies in turn.
  static constexpr Index low = 128;

  using Packet = detail::Packet<Scalar, width>;
  // In a column of a tile, of which the sums are kept in registers.
  static constexpr Index packets = std::is_floating_point_v<Scalar> ? 2 : 1;
  static constexpr Index tile_rows = packets * width;
  static constexpr Index group_rows = std::max(tile_rows, tile_columns);
  static_assert(tile_rows + tile_columns <= Front<Scalar>::overhang);

  // Columns that products are subtracted from.
  struct Target {
    Scalar* values;
    Index stride, rows, columns;

    [[nodiscard]] Scalar* operator[](Index j) const { return values + std::ptrdiff_t{j} * stride; }
  };

  // Some rows of a panel of columns.
  struct Rows {
    const Scalar* values;
    Index stride;  // from a column to the next
    Index columns;
    bool are_copied;  // in groups, one after the other
  };

  [[nodiscard]] Scalar* column(Index j) const {
    return front_.block + std::ptrdiff_t{j} * front_.height;
  }

  [[nodiscard]] static Index tile_with(const Rows& rows, Index i) {
    return rows.are_copied ? i - i % tile_rows : i;
  }
  [[nodiscard]] static const Scalar* at(const Rows& rows, Index i) {
    if (!rows.are_copied) return rows.values + i;
    return rows.values + std::ptrdiff_t{i - i % group_rows} * rows.columns + i % group_rows;
  }

  // Rows of columns; copied where columns lie far apart.
  [[nodiscard]] Rows rows(Index begin, Index end, Index first, Index count,
                          Array<Scalar>& copy) const {
    const Scalar* const from = column(begin) + first;
    const Index columns = end - begin;
    if (front_.height <= low || count == 0) return {from, front_.height, columns, false};
    const Index groups = (count + group_rows - 1) / group_rows;
    copy.resize(static_cast<std::size_t>(groups) * group_rows * static_cast<std::size_t>(columns));
    Scalar* to = copy.data();
    for (Index i = 0; i < count; i += group_rows) {
      const Index here = std::min(group_rows, count - i);
      for (Index k = 0; k < columns; ++k, to += group_rows) {
        std::copy_n(from + std::ptrdiff_t{k} * front_.height + i, here, to);
        std::fill(to + here, to + group_rows, Scalar(0));
      }
    }
    return {copy.data(), group_rows, columns, true};
  }

  // Turns columns that lack each other's products only into those of the factor, a few at a time.
  void factor(Index begin, Index end) const {
    for (Index j = begin; j < end; j += tile_columns) {
      const Target target{column(j) + j, front_.height, front_.height - j,
                          std::min(tile_columns, end - j)};
      const Rows known{column(begin) + j, front_.height, j - begin, false};
      subtract_tiles(target, 0, known, known.values);
      finish(target);
    }
  }

  // target(i, j) -= sum over k of row i, k times the conjugate of row j, k; where i >= j.
  static void subtract_square(const Target& target, const Rows& rows) {
    for (Index j = 0; j < target.columns; j += tile_columns) {
      const Target some{target[j], target.stride, target.rows,
                        std::min(tile_columns, target.columns - j)};
      subtract_tiles(some, j, rows, at(rows, j));
    }
  }
  // The same with other rows for its columns, for all i.
  static void subtract_rectangle(const Target& target, const Rows& rows, const Rows& others) {
    for (Index j = 0; j < target.columns; j += tile_columns) {
      const Target some{target[j], target.stride, target.rows,
                        std::min(tile_columns, target.columns - j)};
      subtract_tiles(some, 0, rows, at(others, j));
    }
  }

  // For a few columns, and rows from `first` on.
  static void subtract_tiles(const Target& target, Index first, const Rows& rows,
                             const Scalar* right) {
    if (rows.columns == 0) return;
    Index i = tile_with(rows, first);
    for (; target.rows - i > (packets - 1) * width; i += tile_rows) {
      subtract_tile<packets>(target, first, i, rows, right);
    }
    if (i < target.rows) subtract_tile<1>(target, first, i, rows, right);
  }

  // For the rows from the i-th on that fit in some packets.
  template <Index count>
  static void subtract_tile(const Target& target, Index first, Index i, const Rows& rows,
                            const Scalar* right) {
    const Scalar* left = at(rows, i);
    Packet sum[tile_columns][count];
    for (Index k = 0; k < rows.columns; ++k, left += rows.stride, right += rows.stride) {
      Packet x[count];
#pragma GCC unroll 4
      for (Index p = 0; p < count; ++p) x[p].load(left + p * width);
#pragma GCC unroll 4
      for (Index j = 0; j < tile_columns; ++j) {
        const Scalar y = conjugate(right[j]);
#pragma GCC unroll 4
        for (Index p = 0; p < count; ++p) sum[j][p].add_product(x[p], y);
      }
    }
    for (Index j = 0; j < target.columns; ++j) {
      for (Index p = 0; p < count; ++p) {
        const Index row = i + p * width;
        if (row >= target.rows) break;
        Packet rest;
        rest.load(target[j] + row);
        rest.subtract(sum[j][p]);
        rest.store(target[j] + row, first - row, target.rows - row);
      }
    }
  }

  // The square on top and then, a packet at a time, what is below it.
  static void finish(const Target& columns) {
    std::array<double, tile_columns> inverses{};
    double* const inverse = inverses.data();
    for (Index j = 0; j < columns.columns; ++j) {
      Scalar* const column = columns[j];
      for (Index k = 0; k < j; ++k) {
        const Scalar factor = conjugate(columns[k][j]);
        for (Index i = j; i < columns.columns; ++i) column[i] -= columns[k][i] * factor;
      }
      const double pivot = std::real(column[j]);
      require_positive(pivot > 0);
      const double root = std::sqrt(pivot);
      inverse[j] = 1 / root;
      column[j] = root;
      for (Index i = j + 1; i < columns.columns; ++i) column[i] *= inverse[j];
    }
    for (Index i = columns.columns; i < columns.rows; i += width) {
      Packet packets_of_row[tile_columns];
      for (Index j = 0; j < columns.columns; ++j) {
        Packet& x = packets_of_row[j];
        x.load(columns[j] + i);
        for (Index k = 0; k < j; ++k) {
          x.subtract_product(packets_of_row[k], conjugate(columns[k][j]));
        }
        x.scale(inverse[j]);
        x.store(columns[j] + i, 0, columns.rows - i);
      }
    }
  }

  static void require_positive(bool is_positive) {
    if (is_positive) return;
    throw std::runtime_error("the Cholesky factorisation met a pivot that is not positive");
  }

  const Front<Scalar> front_;
  Array<Scalar> inner_copy_, outer_copy_;
};

template <class Scalar>
void Front<Scalar>::eliminate() const {
  if (own == 0) return;
  vectorised_by_register([this](auto width) { FrontElimination<Scalar, width>(*this).run(); });
}

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template struct detail::Front<double>;
GELIGHT_ONCE template struct detail::Front<std::complex<double>>;
}  // namespace gelight
#endif
