#include "gelight/mesh/sparse_factor.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/dense.hpp"

using namespace gelight;

namespace {

template <class Scalar>
Scalar random_scalar(std::mt19937& engine) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  if constexpr (std::is_floating_point_v<Scalar>) {
    return uniform(engine);
  } else {
    return {uniform(engine), uniform(engine)};
  }
}

// Random entries below, a diagonal that outweighs them.
template <class Scalar>
SymmetricMatrix<Scalar> random_matrix(
    const std::shared_ptr<const SymmetricPattern<double>>& pattern) {
  std::mt19937 engine(7);
  SymmetricMatrix<Scalar> matrix{pattern, {}};
  for (Index j = 0; j < pattern->size(); ++j) {
    matrix.values.push_back(30);
    for (Index e = pattern->begin(j) + 1; e < pattern->begin(j + 1); ++e) {
      matrix.values.push_back(random_scalar<Scalar>(engine));
    }
  }
  return matrix;
}

template <class Scalar>
Eigen::Matrix<Scalar, -1, -1> dense(const SymmetricMatrix<Scalar>& matrix) {
  const auto& pattern = *matrix.pattern;
  Eigen::Matrix<Scalar, -1, -1> result(pattern.size(), pattern.size());
  result.setZero();
  for (Index j = 0; j < pattern.size(); ++j) {
    for (Index e = pattern.begin(j); e < pattern.begin(j + 1); ++e) {
      result(pattern.row(e), j) = matrix.values[e];
    }
  }
  result = result.template selfadjointView<Eigen::Lower>();
  return result;
}

std::vector<Mesh<double>> meshes() {
  const std::vector<Mesh<double>> parts{icosphere<double>(2), grid<double>(9, 4)};
  auto scattered = joined<double>(parts);
  scattered.positions.insert(scattered.positions.begin(), {1, 2, 3});
  for (auto& face : scattered.faces) face = {face[0] + 1, face[1] + 1, face[2] + 1};
  auto one_place = icosphere<double>(2);  // points that tell nothing
  for (auto& p : one_place.positions) p = {0, 0, 0};
  return {grid<double>(1, 1), icosphere<double>(3),         torus(2.0, 0.5, 25, 9),    scattered,
          one_place,          grid<double>(400, 1, 400, 1), grid<double>(2, 250, 1, 1)};
}

std::vector<Vec3<double>> points_of(const Mesh<double>& mesh) {
  std::vector<Vec3<double>> points;
  for (const auto& p : mesh.positions) points.emplace_back(p[0], p[1], p[2]);
  return points;
}

}  // namespace

TEST_CASE("a dissection orders every unknown once, children before parents") {
  for (const auto& mesh : meshes()) {
    const SymmetricPattern<double> pattern(intrinsic_triangulation(Surface(mesh)));
    const detail::Dissection<double> dissection(pattern, points_of(mesh));
    auto order = dissection.order();
    std::sort(order.begin(), order.end());
    for (Index v = 0; v < pattern.size(); ++v) CHECK(order[v] == v);
    Index end = 0;
    const auto& nodes = dissection.nodes();
    for (Index n = 0; n < static_cast<Index>(nodes.size()); ++n) {
      CHECK(nodes[n].begin == end);
      end = nodes[n].end;
      CHECK((nodes[n].parent > n || nodes[n].parent == -1));
      // What is left of the whole pattern is empty at the root.
      if (nodes[n].parent == -1) CHECK(nodes[n].border() == 0);
    }
    CHECK(end == pattern.size());
  }
}

TEST_CASE("few numbers fill the factor of a strip, wherever its points are") {
  // Elimination from end to end would fill 4 numbers a column.
  const auto strip = grid<double>(2, 5000, 1, 1);  // 2500 times as dense along one axis
  const auto pattern = SymmetricPattern<double>(intrinsic_triangulation(Surface(strip), 1.0));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0, 1);
  for (int places = 0; places < 3; ++places) {
    auto points = points_of(strip);
    for (auto& p : points) {
      if (places == 1) p = {2, 3, 4};
      if (places == 2) p = {anywhere(random), anywhere(random), anywhere(random)};
    }
    CAPTURE(places);
    CHECK(detail::Dissection<double>(pattern, points).value_count() < 40 * pattern.size());
  }
}

TEST_CASE_TEMPLATE("solves what dense elimination solves", Scalar, double, std::complex<double>) {
  for (const auto& mesh : meshes()) {
    const auto pattern =
        std::make_shared<SymmetricPattern<double>>(intrinsic_triangulation(Surface(mesh)));
    const auto matrix = random_matrix<Scalar>(pattern);
    const detail::SparseFactor<Scalar> factor(
        std::make_shared<detail::Dissection<double>>(*pattern, points_of(mesh)), matrix);
    std::mt19937 engine(3);
    detail::Array<Scalar> b(mesh.positions.size());
    for (auto& x : b) x = random_scalar<Scalar>(engine);
    auto x = b;
    factor.solve(x);
    using Vector = DenseVector<Scalar>;
    const auto size = static_cast<Eigen::Index>(b.size());
    const Vector expected =
        by_elimination<Scalar>(dense(matrix), Eigen::Map<Vector>(b.data(), size));
    const Vector found = Eigen::Map<const Vector>(x.data(), size);
    CHECK((found - expected).norm() < 1e-13 * expected.norm());
    const auto back = matrix * x;
    for (Index i = 0; i < pattern->size(); ++i) CHECK(std::abs(back[i] - b[i]) < 1e-12);
    // A load at one place, of which most nodes know nothing.
    for (int k = 0; k < 20; ++k) {
      detail::Array<Scalar> one(b.size(), Scalar(0));
      const auto at = static_cast<std::ptrdiff_t>(engine() % b.size());
      one[at] = b[at];
      auto found_of_one = one;
      factor.solve(found_of_one);
      const auto reached = matrix * found_of_one;
      for (Index i = 0; i < pattern->size(); ++i) CHECK(std::abs(reached[i] - one[i]) < 1e-12);
    }
  }
}

TEST_CASE("solves large systems, long ones, and ones with an unknown that all others depend on") {
  std::vector<Mesh<double>> some{grid<double>(180, 90), grid<double>(3000, 1, 3000, 1)};
  Mesh<double> fan;
  constexpr Index rim = 3000;
  fan.positions.push_back({0, 0, 0});
  for (Index k = 0; k < rim; ++k) {
    const double angle = 2 * std::numbers::pi * k / rim;
    fan.positions.push_back({std::cos(angle), std::sin(angle), 0});
    fan.faces.push_back({0, 1 + k, 1 + (k + 1) % rim});
  }
  some.push_back(fan);
  for (const auto& mesh : some) {
    const auto pattern =
        std::make_shared<SymmetricPattern<double>>(intrinsic_triangulation(Surface(mesh)));
    auto matrix = random_matrix<double>(pattern);
    for (double& x : matrix.values) x = std::abs(x) < 1 ? x / 200 : x;  // the fan's centre has 3000
    const detail::SparseFactor<double> factor(
        std::make_shared<detail::Dissection<double>>(*pattern, points_of(mesh)), matrix);
    std::mt19937 engine(5);
    detail::Array<double> b(mesh.positions.size());
    for (double& x : b) x = random_scalar<double>(engine);
    auto x = b;
    factor.solve(x);
    const auto back = matrix * x;
    double worst = 0;
    for (Index i = 0; i < pattern->size(); ++i) worst = std::max(worst, std::abs(back[i] - b[i]));
    CHECK(worst < 1e-13);
  }
}

TEST_CASE("several right-hand sides together have the bits that each has alone") {
  for (const auto& mesh : meshes()) {
    const auto pattern =
        std::make_shared<SymmetricPattern<double>>(intrinsic_triangulation(Surface(mesh)));
    const auto points = points_of(mesh);
    const auto dissection = std::make_shared<detail::Dissection<double>>(*pattern, points);
    const detail::SparseFactor<double> factor(dissection, random_matrix<double>(pattern));
    std::mt19937 engine(3);
    const std::size_t size = points.size();
    for (const std::size_t count : {0U, 1U, 4U, 5U, 7U, 8U, 9U, 16U, 23U}) {
      std::vector<std::vector<double>> sides(count, std::vector<double>(size, -0.0));
      for (std::size_t i = 0; i < count; ++i) {
        // None, one or all of the unknowns have a load.
        if (i % 3 == 1) sides[i][i * 7 % size] = 1;
        if (i % 3 == 2) {
          for (double& x : sides[i]) x = random_scalar<double>(engine);
        }
      }
      auto alone = sides;
      for (auto& side : alone) factor.solve(side);
      factor.solve_each(std::vector<std::span<double>>(sides.begin(), sides.end()));
      for (std::size_t i = 0; i < count; ++i) {
        CHECK(std::memcmp(alone[i].data(), sides[i].data(), size * sizeof(double)) == 0);
      }
    }
  }
}

TEST_CASE("a matrix that is not positive definite is refused") {
  const auto mesh = icosphere<double>(2);
  const auto pattern =
      std::make_shared<SymmetricPattern<double>>(intrinsic_triangulation(Surface(mesh)));
  auto matrix = random_matrix<double>(pattern);
  matrix.values[pattern->diagonal(50)] = -1;
  const auto dissection = std::make_shared<detail::Dissection<double>>(*pattern, points_of(mesh));
  CHECK_THROWS_AS(detail::SparseFactor<double>(dissection, matrix), std::runtime_error);
}
