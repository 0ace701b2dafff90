#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

namespace gelight {

/// A mesh over two matrices of the caller's, which must outlive it: a row of V is a position, a row
/// of F the three vertices of a face (as libigl has them). Made by `eigen_mesh`.
template <class V, class F>
class EigenMesh {
 public:
  using Scalar = typename V::Scalar;

  EigenMesh(const V& positions, const F& faces) : positions_(positions), faces_(faces) {
    detail::require(positions.cols() == 3, "the matrix of positions has ", positions.cols(),
                    " columns, not 3");
    detail::require(faces.cols() == 3, "the matrix of faces has ", faces.cols(), " columns, not 3");
  }

  [[nodiscard]] Eigen::Index vertex_count() const { return positions_.rows(); }
  [[nodiscard]] Eigen::Index face_count() const { return faces_.rows(); }
  [[nodiscard]] std::array<Scalar, 3> position(Index v) const {
    return {positions_(v, 0), positions_(v, 1), positions_(v, 2)};
  }
  [[nodiscard]] std::array<Index, 3> face(Index f) const {
    return {vertex(f, 0), vertex(f, 1), vertex(f, 2)};
  }

 private:
  [[nodiscard]] Index vertex(Index f, Index k) const {
    const auto v = faces_(f, k);
    detail::require(std::in_range<Index>(v), "face ", f, " has vertex ", v);
    return static_cast<Index>(v);
  }

  const V& positions_;
  const F& faces_;
};

/// See EigenMesh. Throws InvalidInput unless both matrices have three columns.
template <class V, class F>
[[nodiscard]] EigenMesh<V, F> eigen_mesh(const Eigen::DenseBase<V>& positions,
                                         const Eigen::DenseBase<F>& faces) {
  return {positions.derived(), faces.derived()};
}

static_assert(TriangleMesh<EigenMesh<Eigen::MatrixXd, Eigen::MatrixXi>>);

}  // namespace gelight
