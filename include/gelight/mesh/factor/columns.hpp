#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>

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
/// solves. Systems that are solved at once get the bits that each gets alone.
template <class Scalar>
struct Columns {
  static constexpr Index most = 4;

  const Scalar* values;
  Index count, rows;

  [[nodiscard]] const Scalar* operator[](Index j) const {
    return values + std::ptrdiff_t{j} * rows;
  }
  [[nodiscard]] const Scalar* end() const { return (*this)[count]; }

  /// Solves for the first rows of x, and takes what they are out of those below.
  ///@{
  void eliminate(Scalar* x) const {
    for (Index j = 0; j < count; ++j) {
      x[j] /= (*this)[j][j];
      for (Index i = j + 1; i < count; ++i) x[i] -= x[j] * (*this)[j][i];
    }
    Eigen::Map<Vector> rest(x + count, below());
    if (count == most) {
      rest = rest - x[0] * under(0) - x[1] * under(1) - x[2] * under(2) - x[3] * under(3);
    } else {
      for (Index j = 0; j < count; ++j) rest -= x[j] * under(j);
    }
  }
  void eliminate(SystemLanes* x) const {
    for (Index j = 0; j < count; ++j) {
      divide(x[j], (*this)[j][j]);
      for (Index i = j + 1; i < count; ++i) subtract(x[i], x[j], (*this)[j][i]);
    }
    if (count == most) return subtract_columns(x);
    for (Index j = 0; j < count; ++j) {
      for (Index i = count; i < rows; ++i) subtract(x[i], x[j], (*this)[j][i]);
    }
  }
  ///@}

  /// Solves for the first rows of x with those below known. `line` has room for those.
  ///@{
  void substitute(Scalar* x, Scalar* /*line*/) const {
    if (count == most) {
      subtract_dots(x);
    } else {
      const Eigen::Map<const Vector> rest(x + count, below());
      for (Index j = 0; j < count; ++j) x[j] -= under(j).dot(rest);
    }
    for (Index j = count - 1; j >= 0; --j) {
      for (Index i = j + 1; i < count; ++i) x[j] -= conjugate((*this)[j][i]) * x[i];
      x[j] /= (*this)[j][j];
    }
  }
  void substitute(SystemLanes* x, Scalar* line) const {
    if (count == most) {
      subtract_dots(x);
    } else {
      const Eigen::Map<const Vector> rest(line, below());
      for (Index lane = 0; lane < SystemLanes::count; ++lane) {
        for (Index i = 0; i < below(); ++i) line[i] = x[count + i][lane];
        for (Index j = 0; j < count; ++j) x[j].set(lane, x[j][lane] - under(j).dot(rest));
      }
    }
    for (Index j = count - 1; j >= 0; --j) {
      for (Index i = j + 1; i < count; ++i) subtract(x[j], x[i], (*this)[j][i]);
      divide(x[j], (*this)[j][j]);
    }
  }
  ///@}

 private:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  static constexpr Index width = register_width;

  [[nodiscard]] Index below() const { return rows - count; }
  [[nodiscard]] auto under(Index j) const {
    return Eigen::Map<const Vector>((*this)[j] + count, below());
  }

  // Of all the columns with what lies below them.
  void subtract_dots(double* x) const {
    using Packet = detail::Packet<double>;
    const double *const a = under(0).data(), *const b = under(1).data();
    const double *const c = under(2).data(), *const d = under(3).data();
    const double* const rest = x + most;
    Packet sum_a, sum_b, sum_c, sum_d;
    Index i = 0;
    for (; i + width <= below(); i += width) {
      const Packet y = Packet::load(rest + i);
      sum_a.add_product(Packet::load(a + i), y);
      sum_b.add_product(Packet::load(b + i), y);
      sum_c.add_product(Packet::load(c + i), y);
      sum_d.add_product(Packet::load(d + i), y);
    }
    x[0] -= sum_a.sum();
    x[1] -= sum_b.sum();
    x[2] -= sum_c.sum();
    x[3] -= sum_d.sum();
    for (; i < below(); ++i) {
      x[0] -= a[i] * rest[i];
      x[1] -= b[i] * rest[i];
      x[2] -= c[i] * rest[i];
      x[3] -= d[i] * rest[i];
    }
  }
  void subtract_dots(std::complex<double>* x) const {
    ColumnPair ab{}, cd{};
    for (Index i = most; i < rows; ++i) {
      ab.add_products((*this)[0][i], (*this)[1][i], x[i]);
      cd.add_products((*this)[2][i], (*this)[3][i], x[i]);
    }
    for (Index j = 0; j < 2; ++j) {
      x[j] -= Scalar(ab.real[j], ab.imaginary[j]);
      x[2 + j] -= Scalar(cd.real[j], cd.imaginary[j]);
    }
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

  static void divide(SystemLanes& x, double by) {
    x.low /= by;
    x.high /= by;
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
  void subtract_columns(SystemLanes* x) const {
    const Scalar *const a = (*this)[0], *const b = (*this)[1];
    const Scalar *const c = (*this)[2], *const d = (*this)[3];
    const SystemLanes at_a = x[0], at_b = x[1], at_c = x[2], at_d = x[3];
    for (Index i = most; i < rows; ++i) {
      SystemLanes rest = x[i];
      subtract(rest, at_a, a[i]);
      subtract(rest, at_b, b[i]);
      subtract(rest, at_c, c[i]);
      subtract(rest, at_d, d[i]);
      x[i] = rest;
    }
  }

  // Sums are of every width-th row and then put together, as packets of one system's rows are.
  void subtract_dots(SystemLanes* x) const {
    std::array<std::array<SystemLanes, most>, width> sums;
    const Index whole = most + below() / width * width;
    for (Index k = 0; k < width; ++k) sums[std::size_t(k)] = dots(x, most + k, whole);
    for (std::size_t j = 0; j < most; ++j) {
      for (std::size_t half = width / 2; half > 0; half /= 2) {
        for (std::size_t k = 0; k < half; ++k) sums[k][j] += sums[half + k][j];
      }
      x[j] -= sums[0][j];
      for (Index i = whole; i < rows; ++i) {
        subtract(x[j], x[i], (*this)[static_cast<Index>(j)][i]);
      }
    }
  }
  // Of all the columns, over every width-th row.
  [[nodiscard]] std::array<SystemLanes, most> dots(const SystemLanes* x, Index begin,
                                                   Index end) const {
    const Scalar *const a = (*this)[0], *const b = (*this)[1];
    const Scalar *const c = (*this)[2], *const d = (*this)[3];
    SystemLanes of_a, of_b, of_c, of_d;
    for (Index i = begin; i < end; i += width) {
      const SystemLanes y = x[i];
      add(of_a, y, a[i]);
      add(of_b, y, b[i]);
      add(of_c, y, c[i]);
      add(of_d, y, d[i]);
    }
    return {of_a, of_b, of_c, of_d};
  }
};

}  // namespace gelight::detail
