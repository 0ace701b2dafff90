#pragma once

#include <Eigen/Core>
#include <array>
#include <type_traits>
#include <utility>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// A mesh over two matrices of the caller's, which must outlive it: a row of V is a position, a row
/// of F the three vertices of a face (as libigl has them). Made by `eigen_mesh`. Blocks and casts
/// of such matrices need not, as `eigen_mesh(V.cast<double>(), F.topRows(n))`.
template <class V, class F>
class EigenMesh {
 public:
  /// See `eigen_mesh`.
  EigenMesh(const V& positions, const F& faces) : positions_(positions), faces_(faces) {
    detail::require(positions.cols() == 3, "the matrix of positions has ", positions.cols(),
                    " columns, not 3");
    detail::require(faces.cols() == 3, "the matrix of faces has ", faces.cols(), " columns, not 3");
  }

  /// What makes it a TriangleMesh.
  ///@{
  using Scalar = typename V::Scalar;
  [[nodiscard]] Eigen::Index vertex_count() const { return positions_.rows(); }
  [[nodiscard]] Eigen::Index face_count() const { return faces_.rows(); }
  [[nodiscard]] std::array<Scalar, 3> position(Index v) const {
    return {positions_(v, 0), positions_(v, 1), positions_(v, 2)};
  }
  [[nodiscard]] std::array<Index, 3> face(Index f) const {
    return {vertex(f, 0), vertex(f, 1), vertex(f, 2)};
  }
  ///@}

 private:
  [[nodiscard]] Index vertex(Index f, Index k) const {
    const auto v = faces_(f, k);
    detail::require(std::in_range<Index>(v), "face ", f, " has vertex ", v);
    return static_cast<Index>(v);
  }

  // A matrix by reference, an expression of matrices by value, as Eigen's own expressions.
  template <class M>
  using Kept =
      std::conditional_t<std::is_base_of_v<Eigen::PlainObjectBase<M>, M>, const M&, const M>;
  Kept<V> positions_;
  Kept<F> faces_;
};

/// See EigenMesh. Throws InvalidInput unless both matrices have three columns.
template <class V, class F>
[[nodiscard]] EigenMesh<V, F> eigen_mesh(const Eigen::DenseBase<V>& positions,
                                         const Eigen::DenseBase<F>& faces) {
  return {positions.derived(), faces.derived()};
}

namespace detail {

template <class P, class A>
[[nodiscard]] ImageView<P> eigen_image(A& array) {
  require(std::in_range<Index>(array.rows()) && std::in_range<Index>(array.cols()), "an array of ",
          array.rows(), " x ", array.cols(), " is too large for an image");
  return ImageView<P>(array.data(), static_cast<Index>(array.cols()),
                      static_cast<Index>(array.rows()), array.rowStride(), array.colStride());
}

}  // namespace detail

static_assert(TriangleMesh<EigenMesh<Eigen::MatrixXd, Eigen::MatrixXi>>);

/// The coefficients of an array or matrix as pixels: a row of it is a row of the image. No copy is
/// made, of blocks neither. Throws InvalidInput for more rows or columns than Index counts.
template <class D>
[[nodiscard]] auto eigen_image(Eigen::DenseBase<D>& array) {
  return detail::eigen_image<typename D::Scalar>(array.derived());
}
/// The same of an array that may not be written to.
template <class D>
[[nodiscard]] auto eigen_image(const Eigen::DenseBase<D>& array) {
  return detail::eigen_image<const typename D::Scalar>(array.derived());
}

}  // namespace gelight
