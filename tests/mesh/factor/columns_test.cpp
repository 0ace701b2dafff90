#include "gelight/mesh/factor/columns.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <complex>
#include <vector>

#include "support/dense.hpp"

using namespace gelight;

namespace {

template <class Scalar>
using Matrix = DenseMatrix<Scalar>;

/// Columns of a factor with the right-hand side's rows, some values into their memory.
template <class Scalar>
class System {
 public:
  using Columns = detail::Columns<Scalar>;

  System(const Matrix<Scalar>& factor, const Matrix<Scalar>& side, Index offset)
      : factor_(copy(factor, offset)),
        side_(copy(side, offset)),
        columns_{factor_.data() + offset, static_cast<Index>(factor.cols()),
                 static_cast<Index>(factor.rows())},
        offset_(offset) {
    for (Index j = 0; j < columns_.count; ++j) {
      Scalar& pivot = factor_[static_cast<std::size_t>(offset + j * columns_.rows + j)];
      pivot = Scalar(1) / pivot;
    }
  }

  [[nodiscard]] Matrix<Scalar> eliminated() {
    columns_.eliminate(side_.data() + offset_);
    return rows();
  }
  [[nodiscard]] Matrix<Scalar> substituted() {
    columns_.substitute(side_.data() + offset_);
    return rows();
  }

 private:
  static std::vector<Scalar> copy(const Matrix<Scalar>& matrix, Index offset) {
    std::vector<Scalar> values(static_cast<std::size_t>(offset + matrix.size() + Columns::overhang),
                               Scalar(0));
    std::copy(matrix.data(), matrix.data() + matrix.size(), values.begin() + offset);
    return values;
  }
  [[nodiscard]] Matrix<Scalar> rows() const {
    return Eigen::Map<const Matrix<Scalar>>(side_.data() + offset_, columns_.rows, 1);
  }

  std::vector<Scalar> factor_, side_;
  Columns columns_;
  Index offset_;
};

}  // namespace

// The same to the last bit wherever they lie: Eigen's loops are not where the compiler fuses
// multiply-adds, for how many rows they take alone depends on the address.
TEST_CASE_TEMPLATE("columns are solved as the dense matrix is, wherever they lie", Scalar, double,
                   std::complex<double>) {
  for (Index count = 1; count <= 4; ++count) {
    for (Index height = count; height <= count + 11; ++height) {
      CAPTURE(count);
      CAPTURE(height);
      Matrix<Scalar> factor = Matrix<Scalar>::Random(height, count);
      for (Index j = 0; j < count; ++j) factor(j, j) = 2 + std::abs(factor(j, j));
      const Matrix<Scalar> side = Matrix<Scalar>::Random(height, 1);

      const Index below = height - count;
      Matrix<Scalar> top = factor.topRows(count);
      for (Index j = 0; j < count; ++j) top.col(j).head(j).setZero();
      const Matrix<Scalar> bottom = factor.bottomRows(below);
      Matrix<Scalar> down = side, up = side;
      down.topRows(count) = by_elimination<Scalar>(top, side.topRows(count));
      down.bottomRows(below) -= bottom.lazyProduct(down.topRows(count));
      up.topRows(count) -= bottom.adjoint().lazyProduct(side.bottomRows(below));
      up.topRows(count) = by_elimination<Scalar>(top.adjoint(), up.topRows(count));

      std::vector<Matrix<Scalar>> eliminated, substituted;
      for (Index offset = 0; offset < 8; ++offset) {
        eliminated.push_back(System(factor, side, offset).eliminated());
        substituted.push_back(System(factor, side, offset).substituted());
        CHECK(eliminated.back() == eliminated.front());
        CHECK(substituted.back() == substituted.front());
      }
      CHECK((eliminated.front() - down).norm() <= 1e-13 * down.norm());
      CHECK((substituted.front() - up).norm() <= 1e-13 * up.norm());
    }
  }
}
