#pragma once

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
    Numbers<width> signs{};
    for (Index k = 0; k < width; ++k) signs[k] = k % 2 == 0 ? -1 : 1;
    for (Index i = columns; i < rows; i += width / 2) {
      Numbers<width> by_real{}, by_imaginary{};
      for (Index j = 0; j < columns; ++j) {
        const Numbers<width> value = load((*this)[j] + i);
        by_real += value * x[j].real();
        by_imaginary += value * x[j].imag();
      }
      Numbers<width> rest = load(x + i);
      rest -= by_real + exchanged(by_imaginary) * signs;
      std::memcpy(static_cast<void*>(x + i), &rest, sizeof rest);
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
  // Of the conjugate of u with v, the real part is the sum of what u times v is part by part, the
  // imaginary one the difference of what u times v with its parts exchanged is.
  template <Index columns>
  void subtract_dots(std::complex<double>* x) const {
    Numbers<width> straight[columns] = {}, crossed[columns] = {};
    for (Index i = columns; i < rows; i += width / 2) {
      const Numbers<width> y = load(x + i), turned = exchanged(y);
      for (Index j = 0; j < columns; ++j) {
        const Numbers<width> value = load((*this)[j] + i);
        straight[j] += value * y;
        crossed[j] += value * turned;
      }
    }
    for (Index j = 0; j < columns; ++j) {
      for (Index k = 2; k < width; ++k) {
        straight[j][k % 2] += straight[j][k];
        crossed[j][k % 2] += crossed[j][k];
      }
      x[j] -= Scalar(straight[j][0] + straight[j][1], crossed[j][0] - crossed[j][1]);
    }
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

  // As many numbers, or complex ones' parts, as are worked on at once.
  static Numbers<width> load(const Scalar* from) {
    Numbers<width> numbers;
    std::memcpy(&numbers, from, sizeof numbers);
    return numbers;
  }
  // The parts of complex numbers in the other order.
  static Numbers<width> exchanged(const Numbers<width>& parts) {
    static_assert(width % 2 == 0);
    Numbers<width> result{};
    for (Index k = 0; k < width; ++k) result[k] = parts[k ^ 1];
    return result;
  }
};

}  // namespace gelight::detail
