#pragma once

#include <cholmod.h>

#include <algorithm>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>

#include "gelight/core/types.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/sparse_matrix.hpp"

// Opt-in: needs SuiteSparse's CHOLMOD (doi:10.1145/1391989.1391995), and linking with it
// (-lcholmod).

namespace gelight {

namespace detail {

/// CHOLMOD's settings and workspace: one for each call, since threads must not share them.
class CholmodSession {
 public:
  CholmodSession() {
    cholmod_start(&common_);
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.quick_return_if_not_posdef = 1;
    common_.print = 0;
  }
  ~CholmodSession() { cholmod_finish(&common_); }
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;

  [[nodiscard]] cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_{};
};

struct CholmodDeleter {
  void operator()(cholmod_factor* factor) const {
    cholmod_free_factor(&factor, CholmodSession().get());
  }
  void operator()(cholmod_dense* vector) const {
    cholmod_free_dense(&vector, CholmodSession().get());
  }
};

template <class Object>
using CholmodPointer = std::unique_ptr<Object, CholmodDeleter>;

/// What CHOLMOD made, null where memory ran out.
template <class Object>
[[nodiscard]] CholmodPointer<Object> owned(Object* object) {
  if (object == nullptr) throw std::bad_alloc();
  return CholmodPointer<Object>(object);
}

/// CHOLMOD's view of a pattern, with or without values. CHOLMOD reads what it takes by pointers to
/// what could be written.
[[nodiscard]] inline cholmod_sparse cholmod_view(const SymmetricPattern<double>& pattern,
                                                 const double* values) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(pattern.size());
  view.nzmax = static_cast<std::size_t>(pattern.entry_count());
  view.p = const_cast<Index*>(pattern.begins());
  view.i = const_cast<Index*>(pattern.rows());
  view.x = const_cast<double*>(values);
  view.stype = -1;  // the lower triangle
  view.itype = CHOLMOD_INT;
  view.xtype = values == nullptr ? CHOLMOD_PATTERN : CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

class CholmodFactor : public LinearFactor<double> {
 public:
  explicit CholmodFactor(CholmodPointer<cholmod_factor> factor) : factor_(std::move(factor)) {}

  using LinearFactor<double>::solve;

  void solve(std::span<double> b) const override {
    CholmodSession session;
    cholmod_dense right{};
    right.nrow = right.nzmax = right.d = b.size();
    right.ncol = 1;
    right.x = b.data();
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    const auto solution = owned(cholmod_solve(CHOLMOD_A, factor_.get(), &right, session.get()));
    const auto* const x = static_cast<const double*>(solution->x);
    std::copy(x, x + b.size(), b.begin());
  }

 private:
  CholmodPointer<cholmod_factor> factor_;
};

class CholmodAnalysis : public LinearAnalysis<double> {
 public:
  CholmodAnalysis(const SymmetricPattern<double>& pattern, std::span<const Index> order) {
    CholmodSession session;
    session.get()->nmethods = 1;
    session.get()->method[0].ordering = CHOLMOD_GIVEN;
    cholmod_sparse view = cholmod_view(pattern, nullptr);
    auto* const given = const_cast<Index*>(order.data());
    analysed_ = owned(cholmod_analyze_p(&view, given, nullptr, 0, session.get()));
  }

  [[nodiscard]] std::shared_ptr<const LinearFactor<double>> factor(
      const SymmetricMatrix<double>& matrix) const override {
    CholmodSession session;
    cholmod_sparse view = cholmod_view(*matrix.pattern, matrix.values.data());
    auto factor = owned(cholmod_copy_factor(analysed_.get(), session.get()));
    cholmod_factorize(&view, factor.get(), session.get());
    if (session.get()->status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
    if (session.get()->status != CHOLMOD_OK || factor->minor < factor->n) {
      throw std::runtime_error("CHOLMOD met a pivot that is not positive");
    }
    return std::make_shared<CholmodFactor>(std::move(factor));
  }

 private:
  CholmodPointer<cholmod_factor> analysed_;
};

}  // namespace detail

/// SuiteSparse's supernodal Cholesky factorisation as a solver's backend:
/// `HeatSolver solver(mesh, {.backend = cholmod_backend});`. The same answers to rounding. What it
/// costs depends on the BLAS that CHOLMOD is linked with. Throws std::bad_alloc where memory runs
/// out.
[[nodiscard]] inline std::shared_ptr<const LinearAnalysis<double>> cholmod_backend(
    const SymmetricPattern<double>& pattern, std::span<const Index> order) {
  return std::make_shared<detail::CholmodAnalysis>(pattern, order);
}

}  // namespace gelight
