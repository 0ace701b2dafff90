#include "gelight/mesh/cholmod.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using namespace gelight;

namespace {

SymmetricMatrix<double> laplacian_and_one(const Mesh<double>& mesh) {
  const auto triangulation = intrinsic_triangulation(Surface(mesh));
  const auto pattern = std::make_shared<SymmetricPattern<double>>(triangulation);
  auto matrix = cotan_laplacian(triangulation, pattern);
  for (Index v = 0; v < pattern->size(); ++v) matrix.values[pattern->diagonal(v)] += 1;
  return matrix;
}

std::shared_ptr<const LinearAnalysis<double>> analysed(const SymmetricMatrix<double>& matrix) {
  detail::Array<Index> order(static_cast<std::size_t>(matrix.pattern->size()));
  std::iota(order.begin(), order.end(), 0);
  return cholmod_backend(*matrix.pattern, order);
}

std::vector<Mesh<double>> meshes() {
  const std::vector<Mesh<double>> parts{icosphere<double>(2), grid<double>(9, 4)};
  auto scattered = joined<double>(parts);
  scattered.positions.insert(scattered.positions.begin(), {1, 2, 3});  // in no face
  for (auto& face : scattered.faces) face = {face[0] + 1, face[1] + 1, face[2] + 1};
  return {grid<double>(1, 1), icosphere<double>(4), membrane<double>(0.01, 0.04, 0.001), scattered};
}

}  // namespace

TEST_CASE("CHOLMOD's factor solves the system") {
  for (const auto& mesh : meshes()) {
    const auto matrix = laplacian_and_one(mesh);
    const auto factor = analysed(matrix)->factor(matrix);
    detail::Array<double> expected;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      expected.push_back(std::sin(static_cast<double>(v)));
    }
    auto found = matrix * expected;
    factor->solve(found);
    for (Index v = 0; v < matrix.pattern->size(); ++v) {
      CHECK(found[v] == gelight::test::approx(expected[v]).epsilon(1e-11).scale(1));
    }
  }
}

TEST_CASE("one analysis serves several matrices") {
  auto matrix = laplacian_and_one(icosphere<double>(3));
  const auto analysis = analysed(matrix);
  const auto first = analysis->factor(matrix);
  const detail::Array<double> ones(static_cast<std::size_t>(matrix.pattern->size()), 1);
  for (double& x : matrix.values) x *= 4;
  const auto second = analysis->factor(matrix);
  // Of constants the Laplacian is zero, so what is left is the 1 added to the diagonal.
  auto a = ones, b = ones;
  first->solve(a);
  second->solve(b);
  for (Index v = 0; v < matrix.pattern->size(); ++v) {
    CHECK(a[v] == gelight::test::approx(1).epsilon(1e-12));
    CHECK(b[v] == gelight::test::approx(0.25).epsilon(1e-12));
  }
}

TEST_CASE("a matrix that is not positive definite is refused") {
  auto matrix = laplacian_and_one(icosphere<double>(2));
  matrix.values[matrix.pattern->diagonal(50)] = -1;
  CHECK_THROWS_AS((void)analysed(matrix)->factor(matrix), std::runtime_error);
}

// Both are right to rounding, so they agree whatever each is made of.
TEST_CASE("heat by CHOLMOD gives the distances of heat by our own factor") {
  for (const auto& mesh : meshes()) {
    for (const auto boundary : {HeatBoundary::neumann, HeatBoundary::averaged}) {
      const HeatSolver own(mesh, {.boundary = boundary});
      const HeatSolver other(mesh, {.boundary = boundary, .backend = cholmod_backend});
      const auto source = static_cast<Index>(mesh.positions.size()) - 1;
      const auto expected = own.distance(source), found = other.distance(source);
      for (std::size_t v = 0; v < expected.size(); ++v) {
        CAPTURE(v);
        if (std::isinf(expected[v])) {
          CHECK(std::isinf(found[v]));
        } else {
          CHECK(found[v] == gelight::test::approx(expected[v]).epsilon(1e-9));
        }
      }
    }
  }
}

TEST_CASE("needles, whose matrices are positive but for rounding, are solved") {
  auto mesh = icosphere<double>(3);
  for (auto& p : mesh.positions) p[2] *= 1e7;
  const HeatSolver solver(mesh, {.intrinsic_delaunay = true, .backend = cholmod_backend});
  for (const double d : solver.distance(0)) CHECK(std::isfinite(d));
}

TEST_CASE("several threads may ask at once") {
  const auto mesh = icosphere<double>(4);
  const HeatSolver solver(mesh, {.backend = cholmod_backend});
  const auto expected = solver.distance(7);
  std::vector<std::vector<double>> found(4);
  std::vector<std::thread> threads;
  for (auto& distances : found) {
    threads.emplace_back([&] { distances = solver.distance(7); });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& distances : found) CHECK(distances == expected);
}
