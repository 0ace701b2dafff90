#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/mesh/factor/front.hpp"

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
struct alignas(64) Lanes {
  static constexpr Index count = 8;
  static constexpr Index half = count / 2;
  using Half [[gnu::vector_size(half * sizeof(double))]] = double;

  Half low{}, high{};

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
  void eliminate(Lanes* x) const {
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
  void substitute(Lanes* x, Scalar* line) const {
    if (count == most) {
      subtract_dots(x);
    } else {
      const Eigen::Map<const Vector> rest(line, below());
      for (Index lane = 0; lane < Lanes::count; ++lane) {
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
  using Packet = typename Eigen::internal::packet_traits<Scalar>::type;
  static constexpr Index width = Eigen::internal::unpacket_traits<Packet>::size;
  static_assert(Lanes::count % width == 0);

  [[nodiscard]] Index below() const { return rows - count; }
  [[nodiscard]] auto under(Index j) const {
    return Eigen::Map<const Vector>((*this)[j] + count, below());
  }

  // Of all the columns with what lies below them.
  void subtract_dots(Scalar* x) const {
    namespace simd = Eigen::internal;
    const Scalar *const a = (*this)[0] + most, *const b = (*this)[1] + most;
    const Scalar *const c = (*this)[2] + most, *const d = (*this)[3] + most;
    const Scalar* const rest = x + most;
    Packet sum_a = simd::pset1<Packet>(Scalar(0)), sum_b = sum_a, sum_c = sum_a, sum_d = sum_a;
    const auto add = [](Packet& sum, const Scalar* column, const Packet& y) {
      sum = simd::pmadd(simd::pconj(simd::ploadu<Packet>(column)), y, sum);
    };
    Index i = 0;
    for (; i + width <= below(); i += width) {
      const Packet y = simd::ploadu<Packet>(rest + i);
      add(sum_a, a + i, y);
      add(sum_b, b + i, y);
      add(sum_c, c + i, y);
      add(sum_d, d + i, y);
    }
    x[0] -= simd::predux(sum_a);
    x[1] -= simd::predux(sum_b);
    x[2] -= simd::predux(sum_c);
    x[3] -= simd::predux(sum_d);
    for (; i < below(); ++i) {
      x[0] -= conjugate(a[i]) * rest[i];
      x[1] -= conjugate(b[i]) * rest[i];
      x[2] -= conjugate(c[i]) * rest[i];
      x[3] -= conjugate(d[i]) * rest[i];
    }
  }

  static void divide(Lanes& x, double by) {
    x.low /= by;
    x.high /= by;
  }
  static void subtract(Lanes& from, const Lanes& x, double factor) {
    from.low -= x.low * factor;
    from.high -= x.high * factor;
  }
  static void add(Lanes& to, const Lanes& x, double factor) {
    to.low += x.low * factor;
    to.high += x.high * factor;
  }

  // Takes from the rows below what the first ones change there.
  void subtract_columns(Lanes* x) const {
    const Scalar *const a = (*this)[0], *const b = (*this)[1];
    const Scalar *const c = (*this)[2], *const d = (*this)[3];
    const Lanes at_a = x[0], at_b = x[1], at_c = x[2], at_d = x[3];
    for (Index i = most; i < rows; ++i) {
      Lanes rest = x[i];
      subtract(rest, at_a, a[i]);
      subtract(rest, at_b, b[i]);
      subtract(rest, at_c, c[i]);
      subtract(rest, at_d, d[i]);
      x[i] = rest;
    }
  }

  // Sums are of every width-th row and then put together, as packets of one system's rows do.
  void subtract_dots(Lanes* x) const {
    std::array<std::array<Lanes, most>, static_cast<std::size_t>(width)> sums;
    const Index whole = most + below() / width * width;
    for (Index k = 0; k < width; ++k) sums[static_cast<std::size_t>(k)] = dots(x, most + k, whole);
    for (std::size_t j = 0; j < most; ++j) {
      for (Index lane = 0; lane < Lanes::count; ++lane) {
        std::array<Scalar, static_cast<std::size_t>(width)> parts;
        for (std::size_t k = 0; k < parts.size(); ++k) parts[k] = sums[k][j][lane];
        const auto sum = Eigen::internal::predux(Eigen::internal::ploadu<Packet>(parts.data()));
        x[j].set(lane, x[j][lane] - sum);
      }
      for (Index i = whole; i < rows; ++i) {
        subtract(x[j], x[i], (*this)[static_cast<Index>(j)][i]);
      }
    }
  }
  // Of all the columns, over every width-th row.
  [[nodiscard]] std::array<Lanes, most> dots(const Lanes* x, Index begin, Index end) const {
    const Scalar *const a = (*this)[0], *const b = (*this)[1];
    const Scalar *const c = (*this)[2], *const d = (*this)[3];
    Lanes of_a, of_b, of_c, of_d;
    for (Index i = begin; i < end; i += width) {
      const Lanes y = x[i];
      add(of_a, y, a[i]);
      add(of_b, y, b[i]);
      add(of_c, y, c[i]);
      add(of_d, y, d[i]);
    }
    return {of_a, of_b, of_c, of_d};
  }
};

}  // namespace gelight::detail
