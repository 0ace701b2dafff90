#include "gelight/views/eigen.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include "gelight/mesh/surface.hpp"

using gelight::eigen_mesh;
using gelight::InvalidInput;
using gelight::Surface;

TEST_CASE("V and F of any storage order and integer type make the same surface") {
  Eigen::MatrixXd v(4, 3);
  v << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  Eigen::MatrixXi f(2, 3);
  f << 0, 1, 2, 0, 3, 1;
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> v_rows = v.cast<float>();
  const Eigen::Matrix<std::int64_t, Eigen::Dynamic, 3> f_long = f.cast<std::int64_t>();

  const Surface columns(eigen_mesh(v, f));
  const Surface rows(eigen_mesh(v_rows, f_long));
  static_assert(std::same_as<decltype(rows), const Surface<float>>);
  CHECK(columns.face(1) == rows.face(1));
  CHECK(columns.position(3).cast<float>() == rows.position(3));
}

TEST_CASE("casts and blocks of matrices are kept with the mesh that is made of them") {
  const Eigen::MatrixXf positions = Eigen::MatrixXf::Random(5, 3);
  const Eigen::MatrixXi faces{{0, 1, 2}, {1, 3, 2}, {3, 4, 2}};
  const auto of_parts = [&] { return eigen_mesh(positions.cast<double>(), faces.topRows(2)); };
  const auto mesh = of_parts();  // what it was made of there is gone
  const Surface surface(mesh);
  CHECK(surface.vertex_count() == 5);
  CHECK(surface.face_count() == 2);
  CHECK(mesh.position(4)[1] == double{positions(4, 1)});
  CHECK(mesh.face(1) == std::array<gelight::Index, 3>{1, 3, 2});
}

TEST_CASE("matrices of another shape, and indices that do not fit, are refused") {
  const Eigen::MatrixXd flat = Eigen::MatrixXd::Zero(4, 2);
  const Eigen::MatrixXd v = Eigen::MatrixXd::Zero(4, 3);
  const Eigen::MatrixXi quads = Eigen::MatrixXi::Zero(1, 4);
  Eigen::Matrix<std::int64_t, 1, 3> f(0, 1, std::int64_t{1} << 32);
  CHECK_THROWS_AS((void)eigen_mesh(flat, f), InvalidInput);
  CHECK_THROWS_AS((void)eigen_mesh(v, quads), InvalidInput);
  CHECK_THROWS_WITH_AS((void)Surface<double>(eigen_mesh(v, f)), "face 0 has vertex 4294967296",
                       InvalidInput);
}

TEST_CASE("an array of any storage order is an image: rows are rows, blocks included") {
  Eigen::ArrayXXf columns(2, 3);
  columns << 1, 2, 3, 4, 5, 6;
  const Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = columns;
  CHECK(gelight::eigen_image(columns)(2, 1) == 6);
  CHECK(gelight::eigen_image(rows)(2, 1) == 6);
  auto block = columns.rightCols(2);
  const auto view = gelight::eigen_image(block);
  REQUIRE(view.width() == 2);
  REQUIRE(view.height() == 2);
  view(0, 1) = 50;
  CHECK(columns(1, 1) == 50);
  static_assert(
      std::same_as<decltype(gelight::eigen_image(rows)), gelight::ImageView<const float>>);
}
