#pragma once

#include <complex>
#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"

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

/// Elements of a matrix' column one below the other, as many as a register holds numbers. (What is
/// returned in such a register has no place that all compilers agree on: hence no function does.)
template <class Scalar, Index width>
struct Packet;

template <Index width>
struct Packet<double, width> {
  Numbers<width> values{};

  void load(const double* from) { detail::load(values, from); }
  /// Those from the first to the last, exclusive.
  void store(double* to, Index first, Index last) const {
    if (first <= 0 && last >= width) {
      detail::store(values, to);
    } else {
      for (Index k = first < 0 ? 0 : first; k < (last < width ? last : width); ++k)
        to[k] = values[k];
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

template <Index width>
struct Packet<std::complex<double>, width> {
  using Scalar = std::complex<double>;

  Numbers<width> real{}, imaginary{};

  void load(const Scalar* from) {
    for (Index k = 0; k < width; ++k) {
      real[k] = from[k].real();
      imaginary[k] = from[k].imag();
    }
  }
  void store(Scalar* to, Index first, Index last) const {
    for (Index k = first < 0 ? 0 : first; k < (last < width ? last : width); ++k) {
      to[k] = {real[k], imaginary[k]};
    }
  }
  void add_product(const Packet& x, const Scalar& y) {
    real += x.real * y.real() - x.imaginary * y.imag();
    imaginary += x.real * y.imag() + x.imaginary * y.real();
  }
  void subtract_product(const Packet& x, const Scalar& y) {
    real -= x.real * y.real() - x.imaginary * y.imag();
    imaginary -= x.real * y.imag() + x.imaginary * y.real();
  }
  void subtract(const Packet& x) {
    real -= x.real;
    imaginary -= x.imaginary;
  }
  void scale(double by) {
    real *= by;
    imaginary *= by;
  }
};

}  // namespace gelight::detail
