#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <span>
#include <utility>

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
  Index unknown = 0;             // how many vertices that are reached have no value
  bool has_one_exponent = true;  // all that are not zero
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
  /// Begins with a load. The matrix lives as long as the flow; memory of an earlier flow serves
  /// again.
  void begin(const SymmetricMatrix<Scalar>& matrix, const Array<Scalar>& load,
             const Array<char>& reached);

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

  const SymmetricMatrix<Scalar>* matrix_ = nullptr;
  Array<Scalar> u_, everywhere_;
  ScaledField<Scalar> result_;
  Array<char> open_, inside_;
  Index exponent_ = 0;
  double done_ = 0;
};

template <class Scalar>
void HeatFlow<Scalar>::begin(const SymmetricMatrix<Scalar>& matrix, const Array<Scalar>& load,
                             const Array<char>& reached) {
  matrix_ = &matrix;
  u_ = load;
  // From a larger load no higher, so that the sums of a solve have room.
  double largest = 1;
  for (const Scalar& x : load) largest = std::max(largest, magnitude(x));
  const Index lift = top - std::ilogb(largest);
  for (Scalar& x : u_) {
    if (x != Scalar(0)) x = scaled(x, lift);
  }
  result_.value.assign(load.size(), Scalar(0));
  result_.exponent.assign(load.size(), -lift);
  result_.unknown = 0;
  result_.has_one_exponent = true;
  open_ = reached;
  inside_.clear();
  exponent_ = -lift;
  done_ = 0;
}

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
    if (!result_.has_one_exponent) result_.exponent[v] = exponent_;
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
  inside_.resize(u_.size(), 0);  // at the first
  for (Index v = 0; v < size; ++v) {
    inside_[v] = inside_[v] || magnitude(u_[v]) >= isoline;
    if (inside_[v]) u_[v] = 0;
  }
  matrix_->multiply_into(everywhere_, u_);
  double largest = 0;
  std::fill(u_.begin(), u_.end(), Scalar(0));
  const auto& pattern = *matrix_->pattern;
  const auto start_at = [&](Index v) {
    u_[v] = everywhere_[v];
    largest = std::max(largest, magnitude(u_[v]));
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
  for (Scalar& x : u_) x = scaled(x, lift);
  exponent_ -= lift;
  result_.has_one_exponent = false;
  return true;
}

/// How many flows are solved together at most.
inline constexpr std::size_t flows_at_once = 8;

/// Solves flows by the same factor together. The hook is told what share of the vertices has a
/// value.
template <class Scalar>
void finish(std::span<HeatFlow<Scalar>* const> flows, const LinearFactor<Scalar>& factor,
            const CancelHook& cancelled = {}) {
  std::array<HeatFlow<Scalar>*, flows_at_once> open{};
  auto end = std::copy(flows.begin(), flows.end(), open.begin());
  while (end != open.begin()) {
    double done = 1;
    std::array<std::span<Scalar>, flows_at_once> sides;
    auto side = sides.begin();
    for (auto flow = open.begin(); flow != end; ++flow) {
      done = std::min(done, (*flow)->done());
      *side++ = (*flow)->right_hand_side();
    }
    factor.solve_each({sides.begin(), side}, cancelled.part(done, 1));
    end = std::remove_if(open.begin(), end, [](auto* flow) { return !flow->goes_on(); });
  }
}

/// What one flow finds.
template <class Scalar>
[[nodiscard]] ScaledField<Scalar> heat_flow(const SymmetricMatrix<Scalar>& matrix,
                                            const LinearFactor<Scalar>& factor,
                                            const Array<Scalar>& load, const Array<char>& reached,
                                            const CancelHook& cancelled = {}) {
  HeatFlow<Scalar> flow;
  flow.begin(matrix, load, reached);
  HeatFlow<Scalar>* const one = &flow;
  finish<Scalar>({&one, 1}, factor, cancelled);
  return std::move(flow).result();
}

}  // namespace gelight::detail
