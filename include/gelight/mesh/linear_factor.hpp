#pragma once

#include <concepts>
#include <memory>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

// How another library may factor a solver's sparse matrices instead of gelight's own
// factorisation: mesh/cholmod.hpp is an example.

namespace gelight {

namespace detail {
template <std::floating_point Real>
class SymmetricPatternOf;
using SymmetricPattern = SymmetricPatternOf<double>;
template <class Scalar>
struct SymmetricMatrix;
}  // namespace detail

/// A factored sparse matrix A, symmetric positive definite (Hermitian for complex scalars).
template <class Scalar>
class LinearFactor {
 public:
  virtual ~LinearFactor() = default;
  /// The x with A x = b. May be called by several threads.
  [[nodiscard]] virtual detail::Array<Scalar> solve(const detail::Array<Scalar>& b) const = 0;
};

/// What is known of all matrices of one pattern: an order in which to eliminate, and its fill.
template <class Scalar>
class LinearAnalysis {
 public:
  virtual ~LinearAnalysis() = default;
  /// The factor of a matrix of the pattern. Throws std::runtime_error where a pivot is not
  /// positive. May be called by several threads.
  [[nodiscard]] virtual std::shared_ptr<const LinearFactor<Scalar>> factor(
      const detail::SymmetricMatrix<Scalar>& matrix) const = 0;
};

/// A function that analyses a pattern: the choice of a backend. Null stands for gelight's own. It
/// may make use of an order of the unknowns, by nested dissection, in which elimination fills
/// little.
template <class Scalar>
using LinearBackend = std::shared_ptr<const LinearAnalysis<Scalar>> (*)(
    const detail::SymmetricPattern& pattern, const detail::Array<Index>& order);

}  // namespace gelight
