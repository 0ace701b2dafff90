#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <span>
#include <utility>
#include <vector>

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
/// `reached`, by one solve after another: heat falls by a factor of about e per edge and underflows
/// some 1300 edges from its source; beyond, it is started anew: with w equal to u outside an
/// isoline and 0 inside, A w differs from 0 at the isoline only and can be scaled up before w is
/// solved for.
template <class Scalar>
class HeatFlow {
 public:
  HeatFlow(const SymmetricMatrix<Scalar>& matrix, Array<Scalar> load, const Array<char>& reached)
      : matrix_(matrix),
        load_(std::move(load)),
        result_{Array<Scalar>(load_.size()), Array<Index>(load_.size(), 0)},
        open_(reached),
        inside_(load_.size(), 0) {
    for (Scalar& x : load_) x = scaled(x, top);
    u_ = load_;
  }

  /// What is to be solved for next, where the solution is to be.
  [[nodiscard]] Array<Scalar>& right_hand_side() { return u_; }
  /// The share of the vertices that have a value.
  [[nodiscard]] double done() const { return done_; }
  /// Takes the solution, and says whether there is more to solve for.
  [[nodiscard]] bool goes_on();
  /// What was found.
  [[nodiscard]] const ScaledField<Scalar>& result() const& { return result_; }
  [[nodiscard]] ScaledField<Scalar> result() && { return std::move(result_); }

 private:
  static constexpr Index top = 900;  // start from 2^top, to decay the further

  [[nodiscard]] bool start_anew();

  const SymmetricMatrix<Scalar>& matrix_;
  Array<Scalar> load_, u_;
  ScaledField<Scalar> result_;
  Array<char> open_, inside_;
  Index exponent_ = -top;
  double done_ = 0;
};

template <class Scalar>
bool HeatFlow<Scalar>::goes_on() {
  const double least = std::ldexp(1.0, -900);  // below, accuracy fades into underflow
  const auto size = static_cast<Index>(u_.size());
  Index settled = 0, left = 0;
  for (Index v = 0; v < size; ++v) {
    if (!open_[v]) continue;
    if (magnitude(u_[v]) < least) {
      ++left;
      continue;
    }
    result_.value[v] = u_[v];
    result_.exponent[v] = exponent_;
    open_[v] = 0;
    ++settled;
  }
  result_.unknown = left;
  done_ = 1 - static_cast<double>(left) / size;
  return left > 0 && settled > 0 && start_anew();
}

template <class Scalar>
bool HeatFlow<Scalar>::start_anew() {
  const double isoline = std::ldexp(1.0, -900 + 64);  // some edges before the last, as an overlap
  const auto size = static_cast<Index>(u_.size());
  for (Index v = 0; v < size; ++v) {
    inside_[v] = inside_[v] || magnitude(u_[v]) >= isoline;
    if (inside_[v]) u_[v] = 0;
  }
  const Array<Scalar> everywhere = matrix_ * u_;
  double largest = 0;
  std::fill(load_.begin(), load_.end(), Scalar(0));
  const auto& pattern = *matrix_.pattern;
  const auto start_at = [&](Index v) {
    load_[v] = everywhere[v];
    largest = std::max(largest, magnitude(load_[v]));
  };
  for (Index j = 0; j < size; ++j) {
    for (Index e = pattern.begin(j) + 1; e < pattern.begin(j + 1); ++e) {
      const Index i = pattern.row(e);
      if (inside_[i] == inside_[j]) continue;
      start_at(i);
      start_at(j);
    }
  }
  if (largest == 0) return false;
  const Index lift = top - std::ilogb(largest);
  for (Scalar& x : load_) x = scaled(x, lift);
  exponent_ -= lift;
  u_ = load_;
  return true;
}

/// Solves several flows by the same factor together. The hook is told what share of the vertices
/// has a value.
template <class Scalar>
void finish(std::span<HeatFlow<Scalar>> flows, const LinearFactor<Scalar>& factor,
            const CancelHook& cancelled = {}) {
  std::vector<HeatFlow<Scalar>*> open;
  for (auto& flow : flows) open.push_back(&flow);
  while (!open.empty()) {
    double done = 1;
    std::vector<std::span<Scalar>> sides;
    for (HeatFlow<Scalar>* flow : open) {
      done = std::min(done, flow->done());
      sides.emplace_back(flow->right_hand_side());
    }
    factor.solve_each(sides, cancelled.part(done, 1));
    std::erase_if(open, [](HeatFlow<Scalar>* flow) { return !flow->goes_on(); });
  }
}

/// What one flow finds.
template <class Scalar>
[[nodiscard]] ScaledField<Scalar> heat_flow(const SymmetricMatrix<Scalar>& matrix,
                                            const LinearFactor<Scalar>& factor, Array<Scalar> load,
                                            const Array<char>& reached,
                                            const CancelHook& cancelled = {}) {
  HeatFlow<Scalar> flow(matrix, std::move(load), reached);
  finish(std::span(&flow, 1), factor, cancelled);
  return std::move(flow).result();
}

}  // namespace gelight::detail
