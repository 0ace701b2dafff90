#include "gelight/mesh/linear_factor.hpp"

#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/sparse_matrix.hpp"
#include "support/approx.hpp"

using namespace gelight;

// A stranger's factorisation: dense, and made of public names alone.
namespace {

int factored = 0, solved = 0;

class DenseFactor : public LinearFactor<double> {
 public:
  explicit DenseFactor(const Eigen::MatrixXd& a) : llt_(a) {}

  void solve(std::span<double> b) const override {
    ++solved;
    Eigen::Map<Eigen::VectorXd> x(b.data(), static_cast<Eigen::Index>(b.size()));
    x = llt_.solve(Eigen::VectorXd(x));
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

class DenseAnalysis : public LinearAnalysis<double> {
 public:
  [[nodiscard]] std::shared_ptr<const LinearFactor<double>> factor(
      const SymmetricMatrix<double>& matrix) const override {
    ++factored;
    const auto& pattern = *matrix.pattern;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(pattern.size(), pattern.size());
    for (Index j = 0; j < pattern.size(); ++j) {
      for (Index e = pattern.begin(j); e < pattern.begin(j + 1); ++e) {
        a(pattern.row(e), j) = a(j, pattern.row(e)) = matrix.values[e];
      }
    }
    return std::make_shared<DenseFactor>(a);
  }
};

std::shared_ptr<const LinearAnalysis<double>> dense_backend(const SymmetricPattern<double>& pattern,
                                                            std::span<const Index> order) {
  // Every unknown once.
  std::vector<Index> sorted(order.begin(), order.end()), all(sorted.size());
  std::ranges::sort(sorted);
  std::iota(all.begin(), all.end(), 0);
  CHECK(sorted == all);
  CHECK(sorted.size() == static_cast<std::size_t>(pattern.size()));
  return std::make_shared<DenseAnalysis>();
}

}  // namespace

TEST_CASE("a factorisation of the caller's own serves the heat method") {
  for (const auto& mesh : {icosphere<double>(3), membrane<double>(0.01, 0.04, 0.003)}) {
    const HeatSolver own(mesh), theirs(mesh, {.backend = dense_backend});
    const auto expected = own.distance(Index{5}), found = theirs.distance(Index{5});
    for (std::size_t v = 0; v < expected.size(); ++v) {
      CHECK(found[v] == gelight::test::approx(expected[v]).epsilon(1e-9));
    }
    // Several sources, of whose right-hand sides the factor takes one after the other.
    const std::vector<Index> sources{9, 5, 4, 3, 2, 1};
    CHECK(theirs.distance_from_each(sources)[1] == found);
  }
  CHECK(factored >= 4);
  CHECK(solved >= 4);
}
