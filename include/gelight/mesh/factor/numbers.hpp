#pragma once

#include <complex>
#include <cstddef>
#include <cstring>

#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Several numbers that are worked on at once, with what C++ does with one number done with each.
/// GCC and Clang have such types for all processors.
#if defined(__GNUC__)
template <Index count>
struct NumbersType {
  using type [[gnu::vector_size(count * sizeof(double))]] = double;
};
template <Index count>
using Numbers = typename NumbersType<count>::type;
#else
template <Index count>
struct Numbers {
  double at[count];

  double& operator[](Index k) { return at[k]; }
  const double& operator[](Index k) const { return at[k]; }
  Numbers& operator+=(const Numbers& b) { return *this = *this + b; }
  Numbers& operator-=(const Numbers& b) { return *this = *this - b; }
  Numbers& operator*=(double b) { return *this = *this * b; }
  friend Numbers operator+(Numbers a, const Numbers& b) {
    for (Index k = 0; k < count; ++k) a[k] += b[k];
    return a;
  }
  friend Numbers operator-(Numbers a, const Numbers& b) {
    for (Index k = 0; k < count; ++k) a[k] -= b[k];
    return a;
  }
  friend Numbers operator*(Numbers a, const Numbers& b) {
    for (Index k = 0; k < count; ++k) a[k] *= b[k];
    return a;
  }
  friend Numbers operator*(Numbers a, double b) {
    for (double& x : a.at) x *= b;
    return a;
  }
};
#endif

/// How many numbers a register holds, of the processor that is compiled for.
#if defined(__AVX512F__)
inline constexpr Index register_width = 8;
#elif defined(__AVX__)
inline constexpr Index register_width = 4;
#else
inline constexpr Index register_width = 2;
#endif

/// Elements of a matrix' column one below the other, as many as a register holds numbers.
template <class Scalar>
struct Packet;

template <>
struct Packet<double> {
  static constexpr Index width = register_width;

  Numbers<width> values{};

  [[nodiscard]] static Packet load(const double* from) {
    Packet packet;
    std::memcpy(&packet.values, from, sizeof packet.values);
    return packet;
  }
  /// As many as there is room for.
  void store(double* to, Index room) const {
    if (room >= width) {
      std::memcpy(to, &values, sizeof values);
    } else {
      for (Index k = 0; k < room; ++k) to[k] = values[k];
    }
  }
  void add_product(const Packet& x, double y) { values += x.values * y; }
  /// Of the product as it is rounded by itself.
  void subtract_product(const Packet& x, double y) {
    const Numbers<width> product = x.values * y;
    values -= product;
  }
  void subtract(const Packet& x) { values -= x.values; }
  void scale(double by) { values *= by; }
};

template <>
struct Packet<std::complex<double>> {
  using Scalar = std::complex<double>;
  static constexpr Index width = register_width;

  Numbers<width> real{}, imaginary{};

  [[nodiscard]] static Packet load(const Scalar* from) {
    Packet packet;
    for (Index k = 0; k < width; ++k) {
      packet.real[k] = from[k].real();
      packet.imaginary[k] = from[k].imag();
    }
    return packet;
  }
  void store(Scalar* to, Index room) const {
    if (room >= width) {
      for (Index k = 0; k < width; ++k) to[k] = {real[k], imaginary[k]};
    } else {
      for (Index k = 0; k < room; ++k) to[k] = {real[k], imaginary[k]};
    }
  }
  void add_product(const Packet& x, const Scalar& y) { add(times(x, y)); }
  void subtract_product(const Packet& x, const Scalar& y) { subtract(times(x, y)); }
  void subtract(const Packet& x) {
    real -= x.real;
    imaginary -= x.imaginary;
  }
  void scale(double by) {
    real *= by;
    imaginary *= by;
  }

 private:
  void add(const Packet& x) {
    real += x.real;
    imaginary += x.imaginary;
  }
  static Packet times(const Packet& x, const Scalar& y) {
    return {x.real * y.real() - x.imaginary * y.imag(), x.real * y.imag() + x.imaginary * y.real()};
  }
};

}  // namespace gelight::detail
