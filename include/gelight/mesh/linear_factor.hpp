#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>

#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"

// How another library may factor a solver's sparse matrices instead of gelight's own
// factorisation: mesh/cholmod.hpp is an example.

namespace gelight {

template <std::floating_point Real>
class SymmetricPattern;
template <class Scalar>
struct SymmetricMatrix;

namespace detail {
/// A hook for work whose parts may begin anew: what the caller's hook hears never decreases. `what`
/// is under way, in words. (A template so that it costs nothing to include.)
template <std::same_as<CancelHook> Hook>
[[nodiscard]] Hook rising(const Hook& cancelled, const char* what) {
  if (!cancelled) return {};
  return [cancelled, what, most = std::make_shared<double>(0)](double done) {
    *most = std::max(*most, done);
    cancelled.check(*most, what);
    return false;
  };
}
}  // namespace detail

/// A factored sparse matrix A, symmetric positive definite (Hermitian for complex scalars).
template <class Scalar>
class LinearFactor {
 public:
  virtual ~LinearFactor() = default;
  /// Puts the x with A x = b where b is. May be called by several threads.
  virtual void solve(std::span<Scalar> b) const = 0;
  /// The same, asking a hook; a factor that does not override it asks once.
  virtual void solve(std::span<Scalar> b, const CancelHook& cancelled) const {
    cancelled.check(0, "solving a linear system");
    solve(b);
  }
  /// The same for several right-hand sides, each with the bits that it has alone: a factor may
  /// override it to be read once for several of them.
  virtual void solve_each(std::span<const std::span<Scalar>> sides,
                          const CancelHook& cancelled = {}) const {
    const auto share = [&](std::size_t done) {
      return static_cast<double>(done) / static_cast<double>(sides.size());
    };
    for (std::size_t i = 0; i < sides.size(); ++i) {
      solve(sides[i], cancelled.part(share(i), share(i + 1)));
    }
  }
};

/// What is known of all matrices of one pattern: an order in which to eliminate, and its fill.
template <class Scalar>
class LinearAnalysis {
 public:
  virtual ~LinearAnalysis() = default;
  /// The factor of a matrix of the pattern. Throws std::runtime_error where a pivot is not
  /// positive. May be called by several threads.
  [[nodiscard]] virtual std::shared_ptr<const LinearFactor<Scalar>> factor(
      const SymmetricMatrix<Scalar>& matrix) const = 0;
};

/// A function that analyses a pattern: the choice of a backend. Null stands for gelight's own. It
/// may make use of an order of the unknowns, by nested dissection, in which elimination fills
/// little.
template <class Scalar>
using LinearBackend = std::shared_ptr<const LinearAnalysis<Scalar>> (*)(
    const SymmetricPattern<double>& pattern, std::span<const Index> order);

}  // namespace gelight
