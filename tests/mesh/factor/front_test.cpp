#include "gelight/mesh/factor/front.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <complex>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>
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
  detail::Front<Scalar>{block.data(), own, height, update.data()}.eliminate();

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

// Whether this is compiled so that multiplications and additions are fused, which each loop may be
// in its own way.
bool are_products_fused() {
  volatile double x = 1 + 0x1p-30, minus_square = -(1 + 0x1p-29);
  return x * x + minus_square != 0;
}

}  // namespace

// Sizes about those of the registers, about four columns, about where panels are copied, and of two
// and three panels.
TEST_CASE_TEMPLATE("a front is eliminated as the dense matrix is", Scalar, double,
                   std::complex<double>) {
  for (Index own = 1; own <= 9; ++own) {
    for (Index border = 0; border <= 35; ++border) {
      check_against_dense_elimination<Scalar>(own, own + border);
    }
  }
  for (const Index height : {127, 128, 129, 150}) {
    for (const Index own : {1, 6, 63, 64, 65, 127}) {
      check_against_dense_elimination<Scalar>(own, height);
    }
  }
  check_against_dense_elimination<Scalar>(131, 131);
  check_against_dense_elimination<Scalar>(130, 203);
}

// What the registers hold must not show, nor what lies above the diagonals be touched.
TEST_CASE_TEMPLATE("a front has the same bits by registers of any size", Scalar, double,
                   std::complex<double>) {
  if (are_products_fused()) return;
  const Scalar mark(-7);
  const auto at = [](Index i) { return static_cast<std::size_t>(i); };
  // Four columns are written from the first one's diagonal on.
  const auto check_marks = [&](const Scalar* column, Index j) {
    for (Index i = 0; i < j / 4 * 4; ++i) CHECK(column[i] == mark);
  };
  const auto eliminated = [&](auto width, Index own, Index height) {
    std::srand(static_cast<unsigned>(1000 * own + height));
    const auto matrix = positive_definite<Scalar>(height);
    const Index border = height - own;
    std::vector<Scalar> values[2] = {
        with_overhang<Scalar>(matrix.leftCols(own)),
        with_overhang<Scalar>(matrix.bottomRightCorner(border, border))};
    for (Index j = 0; j < own; ++j) std::fill_n(&values[0][at(j * height)], j, mark);
    for (Index j = 0; j < border; ++j) std::fill_n(&values[1][at(j * border)], j, mark);
    const detail::Front<Scalar> front{values[0].data(), own, height, values[1].data()};
    // (Not by `eliminate`, which chooses: by instructions that every processor has.)
    detail::run_plain([&] { detail::FrontElimination<Scalar, width>(front).run(); });
    for (Index j = 0; j < own; ++j) check_marks(&values[0][at(j * height)], j);
    for (Index j = 0; j < border; ++j) check_marks(&values[1][at(j * border)], j);
    values[0].resize(at(own * height));
    values[1].resize(at(border * border));
    values[0].insert(values[0].end(), values[1].begin(), values[1].end());
    return values[0];
  };
  const std::pair<Index, Index> sizes[] = {{1, 1},    {3, 9},    {5, 23},   {17, 41},
                                           {64, 100}, {70, 127}, {66, 150}, {150, 161}};
  for (const auto& size : sizes) {
    const Index own = size.first, height = size.second;
    CAPTURE(own);
    CAPTURE(height);
    const auto two = eliminated(std::integral_constant<Index, 2>(), own, height);
    CHECK(two == eliminated(std::integral_constant<Index, 4>(), own, height));
    CHECK(two == eliminated(std::integral_constant<Index, 8>(), own, height));
  }
}

TEST_CASE("nothing to eliminate changes nothing") {
  std::vector<double> update{1, 2, 3, 4};
  detail::Front<double>{nullptr, 0, 2, update.data()}.eliminate();
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
      const detail::Front<Scalar> front{block.data(), size, size, &none};
      CHECK_THROWS_AS(front.eliminate(), std::runtime_error);
    }
  }
}
