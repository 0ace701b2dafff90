#include "gelight/mesh/factor/front.hpp"

#include <doctest/doctest.h>

#include <complex>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "support/dense.hpp"

using namespace gelight;

namespace {

template <class Scalar>
using Matrix = DenseMatrix<Scalar>;

template <class Scalar>
Matrix<Scalar> positive_definite(Index size) {
  const Matrix<Scalar> a = Matrix<Scalar>::Random(size, size);
  return a.lazyProduct(a.adjoint()) + Matrix<Scalar>::Identity(size, size);
}

// Values of a matrix, and what a front may read behind them.
template <class Scalar>
std::vector<Scalar> with_overhang(const Matrix<Scalar>& matrix) {
  std::vector<Scalar> values(matrix.data(), matrix.data() + matrix.size());
  values.resize(values.size() + detail::Front<Scalar>::overhang,
                Scalar(std::numeric_limits<double>::quiet_NaN()));
  return values;
}

template <class Scalar>
void check_against_dense_elimination(Index own, Index height) {
  CAPTURE(own);
  CAPTURE(height);
  const Index border = height - own;
  const auto matrix = positive_definite<Scalar>(height);
  auto block = with_overhang<Scalar>(matrix.leftCols(own));
  auto update = with_overhang<Scalar>(matrix.bottomRightCorner(border, border));
  detail::Front<Scalar>(block.data(), own, height, update.data()).eliminate();

  const Matrix<Scalar> factor = cholesky<Scalar>(matrix);
  const Eigen::Map<const Matrix<Scalar>> found(block.data(), height, own);
  const Matrix<Scalar> off = (found - factor.leftCols(own)).template triangularView<Eigen::Lower>();
  CHECK(off.norm() <= 1e-13 * height * factor.norm());

  const Matrix<Scalar> below = factor.bottomLeftCorner(border, own);
  const Matrix<Scalar> rest =
      matrix.bottomRightCorner(border, border) - below.lazyProduct(below.adjoint());
  const Eigen::Map<const Matrix<Scalar>> left(update.data(), border, border);
  const Matrix<Scalar> rest_off = (left - rest).template triangularView<Eigen::Lower>();
  CHECK(rest_off.norm() <= 1e-13 * height * matrix.norm());
}

}  // namespace

// Sizes about those of the registers, about four columns, and about where Eigen's kernels take
// over.
TEST_CASE_TEMPLATE("a front is eliminated as the dense matrix is", Scalar, double,
                   std::complex<double>) {
  for (Index own = 1; own <= 9; ++own) {
    for (Index border = 0; border <= 35; ++border) {
      check_against_dense_elimination<Scalar>(own, own + border);
    }
  }
  for (const Index height : {127, 128, 129, 150}) {
    for (const Index own : {1, 6, 63, 127}) check_against_dense_elimination<Scalar>(own, height);
  }
}

TEST_CASE("nothing to eliminate changes nothing") {
  std::vector<double> update{1, 2, 3, 4};
  detail::Front<double>(nullptr, 0, 2, update.data()).eliminate();
  CHECK(update == std::vector<double>{1, 2, 3, 4});
}

TEST_CASE_TEMPLATE("a pivot that is not positive is refused", Scalar, double,
                   std::complex<double>) {
  for (const Index size : {3, 20, 140}) {
    for (const double pivot : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
      Matrix<Scalar> matrix = Matrix<Scalar>::Identity(size, size);
      matrix(size - 1, size - 1) = pivot;
      auto block = with_overhang<Scalar>(matrix);
      Scalar none(0);
      const detail::Front<Scalar> front(block.data(), size, size, &none);
      CHECK_THROWS_AS(front.eliminate(), std::runtime_error);
    }
  }
}
