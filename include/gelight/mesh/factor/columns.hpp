#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/front.hpp"
#include "gelight/mesh/factor/numbers.hpp"

namespace gelight::detail {

/// Whether several systems can be solved at once: in types that GCC and Clang have, and where no
/// compiler fuses multiply-adds, which it need not do alike in one system and in several.
#if defined(__GNUC__) && !defined(__FMA__) && !defined(__FP_FAST_FMA) && !defined(__ARM_FEATURE_FMA)
inline constexpr bool has_lanes = true;
#else
inline constexpr bool has_lanes = false;
#endif

/// The same unknown of several systems of equations that are solved at once. (GCC takes the type of
/// each half for aligned to its size, but does not say so.)
struct alignas(64) SystemLanes {
  static constexpr Index count = 8;
  static constexpr Index half = count / 2;

  Numbers<half> low{}, high{};

  SystemLanes& operator+=(const SystemLanes& b) {
    low += b.low;
    high += b.high;
    return *this;
  }
  SystemLanes& operator-=(const SystemLanes& b) {
    low -= b.low;
    high -= b.high;
    return *this;
  }
  [[nodiscard]] double operator[](Index lane) const {
    return lane < half ? low[lane] : high[lane - half];
  }
  void set(Index lane, double value) {
    if (lane < half) {
      low[lane] = value;
    } else {
      high[lane - half] = value;
    }
  }
};

/// A few columns of a factor, from the first one's diagonal on down: a step of the triangular
/// solves. Instead of each pivot there is its inverse. Systems that are solved at once get the bits
/// that each gets alone.
template <class Scalar>
struct Columns {
  static constexpr Index most = 4;
  /// How many values beyond the last column are read, and rows beyond the last written (by
  /// `eliminate`) or read and to be zero (by `substitute`).
  static constexpr Index overhang = 4;

  const Scalar* values;
  Index count, rows;

  [[nodiscard]] const Scalar* operator[](Index j) const {
    return values + std::ptrdiff_t{j} * rows;
  }
  [[nodiscard]] const Scalar* end() const { return (*this)[count]; }

  /// Solves for the first rows of x, and takes what they are out of those below.
  template <class Value>
  void eliminate(Value* x) const {
    with_count([&](auto columns) { eliminate<columns>(x); });
  }
  /// Solves for the first rows of x with those below known.
  template <class Value>
  void substitute(Value* x) const {
    with_count([&](auto columns) { substitute<columns>(x); });
  }

 private:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  template <Index number>
  using Number = std::integral_constant<Index, number>;
  // Few rows fill no wider register.
  static constexpr Index width = std::min(register_width, Index{4});
  static_assert(width <= overhang);

  void with_count(const auto& work) const {
    switch (count) {
      case 4:
        return work(Number<4>());
      case 3:
        return work(Number<3>());
      case 2:
        return work(Number<2>());
      default:
        return work(Number<1>());
    }
  }

  template <Index columns, class Value>
  void eliminate(Value* x) const {
    for (Index j = 0; j < columns; ++j) {
      multiply(x[j], std::real((*this)[j][j]));
      for (Index i = j + 1; i < columns; ++i) subtract(x[i], x[j], (*this)[j][i]);
    }
    subtract_columns<columns>(x);
  }

  template <Index columns, class Value>
  void substitute(Value* x) const {
    subtract_dots<columns>(x);
    for (Index j = columns - 1; j >= 0; --j) {
      for (Index i = j + 1; i < columns; ++i) subtract(x[j], x[i], conjugate((*this)[j][i]));
      multiply(x[j], std::real((*this)[j][j]));
    }
  }

  static void multiply(Scalar& x, double by) { x *= by; }
  static void subtract(Scalar& from, const Scalar& x, const Scalar& factor) { from -= x * factor; }
  static void multiply(SystemLanes& x, double by) {
    x.low *= by;
    x.high *= by;
  }
  static void subtract(SystemLanes& from, const SystemLanes& x, double factor) {
    from.low -= x.low * factor;
    from.high -= x.high * factor;
  }
  static void add(SystemLanes& to, const SystemLanes& x, double factor) {
    to.low += x.low * factor;
    to.high += x.high * factor;
  }

  // Takes from the rows below what the first ones change there.
  ///@{
  template <Index columns>
  void subtract_columns(double* x) const {
    for (Index i = columns; i < rows; i += width) {
      auto rest = load(x + i);
      for (Index j = 0; j < columns; ++j) rest -= load((*this)[j] + i) * x[j];
      std::memcpy(x + i, &rest, sizeof rest);
    }
  }
  template <Index columns>
  void subtract_columns(std::complex<double>* x) const {
    Eigen::Map<Vector> rest(x + columns, rows - columns);
    const auto under = [&](Index j) {
      return Eigen::Map<const Vector>((*this)[j] + columns, rows - columns);
    };
    if constexpr (columns == 4) {
      rest = rest - x[0] * under(0) - x[1] * under(1) - x[2] * under(2) - x[3] * under(3);
    } else {
      for (Index j = 0; j < columns; ++j) rest -= x[j] * under(j);
    }
  }
  template <Index columns>
  void subtract_columns(SystemLanes* x) const {
    std::array<SystemLanes, columns> first;
    std::copy(x, x + columns, first.begin());
    for (Index i = columns; i < rows; ++i) {
      SystemLanes rest = x[i];
      for (Index j = 0; j < columns; ++j) {
        subtract(rest, first[static_cast<std::size_t>(j)], (*this)[j][i]);
      }
      x[i] = rest;
    }
  }
  ///@}

  // Takes from the first rows each column's product with what lies below.
  ///@{
  template <Index columns>
  void subtract_dots(double* x) const {
    Numbers<width> sums[columns] = {};
    for (Index i = columns; i < rows; i += width) {
      const auto y = load(x + i);
      for (Index j = 0; j < columns; ++j) sums[j] += load((*this)[j] + i) * y;
    }
    for (Index j = 0; j < columns; ++j) {
      for (Index half = width / 2; half > 0; half /= 2) {
        for (Index k = 0; k < half; ++k) sums[j][k] += sums[j][half + k];
      }
      x[j] -= sums[j][0];
    }
  }
  template <Index columns>
  void subtract_dots(std::complex<double>* x) const {
    Scalar sums[columns] = {};
    Index j = 0;
    for (; j + 2 <= columns; j += 2) {
      ColumnPair pair{};
      for (Index i = columns; i < rows; ++i) {
        pair.add_products((*this)[j][i], (*this)[j + 1][i], x[i]);
      }
      for (Index k = 0; k < 2; ++k) sums[j + k] = Scalar(pair.real[k], pair.imaginary[k]);
    }
    for (; j < columns; ++j) {
      for (Index i = columns; i < rows; ++i) sums[j] += std::conj((*this)[j][i]) * x[i];
    }
    for (j = 0; j < columns; ++j) x[j] -= sums[j];
  }
  // Sums are of every width-th row and then put together, as those of one system's rows are.
  template <Index columns>
  void subtract_dots(SystemLanes* x) const {
    std::array<std::array<SystemLanes, columns>, width> sums;
    for (Index k = 0; k < width; ++k) {
      sums[static_cast<std::size_t>(k)] = dots<columns>(x, columns + k);
    }
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t half = width / 2; half > 0; half /= 2) {
        for (std::size_t k = 0; k < half; ++k) sums[k][j] += sums[half + k][j];
      }
      x[j] -= sums[0][j];
    }
  }
  ///@}

  // Of the columns, over every width-th row.
  template <Index columns>
  [[nodiscard]] std::array<SystemLanes, columns> dots(const SystemLanes* x, Index begin) const {
    std::array<SystemLanes, columns> sums;
    for (Index i = begin; i < rows; i += width) {
      const SystemLanes y = x[i];
      for (Index j = 0; j < columns; ++j) add(sums[static_cast<std::size_t>(j)], y, (*this)[j][i]);
    }
    return sums;
  }

  // Sums of two columns.
  struct ColumnPair {
    Numbers<2> real, imaginary;

    // Of the conjugates.
    void add_products(const Scalar& first, const Scalar& second, const Scalar& y) {
      const Numbers<2> re{first.real(), second.real()}, im{first.imag(), second.imag()};
      real += re * y.real() + im * y.imag();
      imaginary += re * y.imag() - im * y.real();
    }
  };

  static Numbers<width> load(const double* from) {
    Numbers<width> numbers;
    std::memcpy(&numbers, from, sizeof numbers);
    return numbers;
  }
};

}  // namespace gelight::detail
