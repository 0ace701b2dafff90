#pragma once

#include <algorithm>
#include <cmath>
#include <complex>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

namespace gelight::detail {

/// Numbers value(v) 2^exponent(v), whose range a double alone does not have.
template <class Scalar>
struct ScaledField {
  Array<Scalar> value;
  Array<Index> exponent;
  Index unknown = 0;  // how many vertices that are reached have no value
};

inline double magnitude(double x) { return std::abs(x); }
inline double magnitude(std::complex<double> x) {
  return std::max(std::abs(x.real()), std::abs(x.imag()));
}
inline double scaled(double x, Index exponent) { return std::ldexp(x, exponent); }
inline std::complex<double> scaled(std::complex<double> x, Index exponent) {
  return {std::ldexp(x.real(), exponent), std::ldexp(x.imag(), exponent)};
}

/// Solves A u = load to full relative accuracy however far u decays, at every vertex that is
/// `reached`. Heat falls by a factor of about e per edge and underflows some 1300 edges from its
/// source; beyond, it is started anew: with w equal to u outside an isoline and 0 inside, A w
/// differs from 0 at the isoline only and can be scaled up before w is solved for. The hook is told
/// what share of the vertices has a value.
template <class Scalar>
ScaledField<Scalar> heat_flow(const SymmetricMatrix<Scalar>& matrix,
                              const LinearFactor<Scalar>& factor, Array<Scalar> load,
                              const Array<char>& reached, const CancelHook& cancelled = {}) {
  constexpr Index top = 900;                          // start from 2^top, to decay the further
  const double least = std::ldexp(1.0, -900);         // below, accuracy fades into underflow
  const double isoline = std::ldexp(1.0, -900 + 64);  // some edges before, as an overlap
  const auto size = static_cast<Index>(load.size());
  ScaledField<Scalar> result{Array<Scalar>(load.size()), Array<Index>(load.size(), 0)};
  Array<char> open = reached;
  Array<char> inside(load.size(), 0);
  Index exponent = -top;
  double done = 0;  // of all vertices
  for (Scalar& x : load) x = scaled(x, top);
  while (true) {
    Array<Scalar> u = load;
    factor.solve(u, cancelled.part(done, 1));
    Index settled = 0, left = 0;
    for (Index v = 0; v < size; ++v) {
      if (!open[v]) continue;
      if (magnitude(u[v]) < least) {
        ++left;
        continue;
      }
      result.value[v] = u[v];
      result.exponent[v] = exponent;
      open[v] = 0;
      ++settled;
    }
    result.unknown = left;
    done = 1 - static_cast<double>(left) / size;
    if (left == 0 || settled == 0) return result;

    for (Index v = 0; v < size; ++v) {
      inside[v] = inside[v] || magnitude(u[v]) >= isoline;
      if (inside[v]) u[v] = 0;
    }
    const Array<Scalar> everywhere = matrix * u;
    double largest = 0;
    std::fill(load.begin(), load.end(), Scalar(0));
    const auto& pattern = *matrix.pattern;
    const auto start_at = [&](Index v) {
      load[v] = everywhere[v];
      largest = std::max(largest, magnitude(load[v]));
    };
    for (Index j = 0; j < size; ++j) {
      for (Index e = pattern.begin(j) + 1; e < pattern.begin(j + 1); ++e) {
        const Index i = pattern.row(e);
        if (inside[i] == inside[j]) continue;
        start_at(i);
        start_at(j);
      }
    }
    if (largest == 0) return result;
    const Index lift = top - std::ilogb(largest);
    for (Scalar& x : load) x = scaled(x, lift);
    exponent -= lift;
  }
}

}  // namespace gelight::detail
