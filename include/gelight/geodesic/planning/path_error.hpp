#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/backtrace.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// The mean relative error of distances, as paths back from some targets tell it.
///
/// Over 2,124 fields of fast marching on 354 meshes of 15 kinds, 2,000 to 10,000 vertices, 256
/// paths told 1.00 times the error in the median; the error was beyond `at_most(2)` in 0.5 % of
/// all, never by more than a fifteenth. For 64 paths and `at_most(3)` it was in 1 %, by up to a
/// half, where few vertices had most of the error.
template <std::floating_point Real>
class PathError {
 public:
  /// Targets are reached, and at distances that are not zero. Keeps references.
  PathError(const Surface<Real>& surface, Array<Source<Real>> sources,
            const std::vector<Real>& distances, const std::vector<Index>& targets)
      : distances_(distances), targets_(targets), way_(surface, std::move(sources), distances) {
    const std::size_t count = targets_.size();
    step_ = static_cast<std::size_t>(golden_share * static_cast<double>(count)) + 1;
    while (std::gcd(step_, count) != 1) ++step_;
  }

  /// Follows paths until there are so many, or one from every target.
  void trace(Index count, const CancelHook& cancelled = {}) {
    count = std::min(count, static_cast<Index>(std::ssize(targets_)));
    const Index first = count_;
    for (; count_ < count; ++count_) {
      if (count_ % paths_between_polls == 0) {
        cancelled.check(double(count_ - first) / (count - first), "following paths");
      }
      const Index v = targets_[which(count_)];
      const double d = distances_[static_cast<std::size_t>(v)];
      const auto [walked, taut] = way_.from(v);
      const double off = taut < unreachable<double> ? std::abs(d / taut - 1) : largest_error;
      sum_ += off;
      squares_ += off * off;
      pulled_ += taut < unreachable<double> ? std::max(0.0, walked / taut - 1) : 0;
    }
  }

  [[nodiscard]] Index count() const { return count_; }

  /// Bounds that are sure by so many standard errors. The upper one has besides by how much the
  /// paths were pulled shorter: about what they are still too long.
  ///@{
  [[nodiscard]] double at_least(double sureness) const { return mean() - sureness * spread(); }
  [[nodiscard]] double at_most(double sureness) const {
    return mean() + sureness * spread() + pulled_ / count_;
  }
  ///@}

 private:
  // Where no path was found.
  static constexpr double largest_error = 1;
  static constexpr double golden_share = 0.6180339887498949;
  static constexpr Index paths_between_polls = 8;

  // Each target once, those before any spread evenly over all.
  [[nodiscard]] std::size_t which(Index i) const {
    return (static_cast<std::size_t>(i) * step_ + step_ / 2) % targets_.size();
  }
  [[nodiscard]] double mean() const { return sum_ / count_; }
  [[nodiscard]] double spread() const {
    return std::sqrt(std::max(0.0, squares_ / count_ - mean() * mean()) / count_);
  }

  const std::vector<Real>& distances_;
  const std::vector<Index>& targets_;
  Backtrace<Real> way_;
  std::size_t step_ = 1;  // from one target to the next: no divisor of how many there are
  Index count_ = 0;
  double sum_ = 0, squares_ = 0, pulled_ = 0;
};

}  // namespace gelight::detail
