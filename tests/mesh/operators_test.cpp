#include "gelight/mesh/operators.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"

using namespace gelight;

namespace {

struct Operators {
  explicit Operators(const Mesh<double>& mesh)
      : triangulation(intrinsic_triangulation(Surface(mesh))),
        laplacian(cotan_laplacian(triangulation,
                                  std::make_shared<SymmetricPattern<double>>(triangulation))) {}
  IntrinsicTriangulation<double> triangulation;
  SymmetricMatrix<double> laplacian;
};

detail::Array<double> sampled(const Mesh<double>& mesh, auto&& function) {
  detail::Array<double> u;
  for (const auto& p : mesh.positions) u.push_back(function(p));
  return u;
}

}  // namespace

TEST_CASE("the Laplacian of a constant is zero, of a linear function zero off the border") {
  const auto mesh = grid<double>(9, 6, 2.0, 1.0);
  const Operators op(mesh);
  for (const double x : op.laplacian* sampled(mesh, [](const auto&) { return 3.0; })) {
    CHECK(std::abs(x) < 1e-13);
  }
  const auto linear =
      op.laplacian * sampled(mesh, [](const auto& p) { return 2 * p[0] - 5 * p[1]; });
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto& p = mesh.positions[v];
    const bool inner = p[0] > 0.1 && p[0] < 1.9 && p[1] > 0.1 && p[1] < 0.9;
    if (inner) CHECK(std::abs(linear.data()[v]) < 1e-12);
  }
}

TEST_CASE("Dirichlet energy of a linear function is its slope squared times the area") {
  const auto mesh = grid<double>(7, 5, 3.0, 2.0);
  const Operators op(mesh);
  const auto u = sampled(mesh, [](const auto& p) { return 2 * p[0] - 5 * p[1]; });
  const auto lu = op.laplacian * u;
  double energy = 0;
  for (Index v = 0; v < static_cast<Index>(u.size()); ++v) energy += u[v] * lu[v];
  CHECK(energy == gelight::test::approx(29.0 * 6.0));
}

TEST_CASE("vertex areas sum to the area of the surface") {
  const auto areas = vertex_areas(intrinsic_triangulation(Surface(box(1.0, 2.0, 3.0))));
  CHECK(std::accumulate(areas.begin(), areas.end(), 0.0) == gelight::test::approx(22));
}

TEST_CASE("gradient and divergence: div grad is the Laplacian") {
  const auto mesh = icosphere<double>(2);
  const Operators op(mesh);
  const auto u = sampled(mesh, [](const auto& p) { return p[0] * p[1] + std::sin(3 * p[2]); });
  const auto expected = op.laplacian * u;
  detail::Array<double> found(u.size(), 0);
  const auto faces = planar_faces(op.triangulation);
  for (Index f = 0; f < op.triangulation.face_count(); ++f) {
    const Index* v = op.triangulation.origins.data() + 3 * f;
    const double twice_area = faces[f].x1 * faces[f].y2;
    const Vec2<double> gradient =
        scaled_gradient(faces[f], {u[v[0]], u[v[1]], u[v[2]]}) / twice_area;
    const auto divergence = integrated_divergence(faces[f], gradient);
    for (std::size_t k = 0; k < 3; ++k) found[v[k]] += divergence[k];
  }
  for (Index v = 0; v < static_cast<Index>(u.size()); ++v) {
    CHECK(found[v] == gelight::test::approx(expected[v]).epsilon(1e-10).scale(1));
  }
}

TEST_CASE("triangles without area get one, others keep their lengths") {
  const auto sound = detail::mollified({3, 4, 5}, 1);
  CHECK(sound == std::array<double, 3>{3, 4, 5});
  for (const auto& flat : {std::array<double, 3>{1, 1, 2}, std::array<double, 3>{0, 1, 1},
                           std::array<double, 3>{0, 0, 0}, std::array<double, 3>{1, 1, 2.001}}) {
    CHECK(detail::triangle_area(flat) == 0);
    const auto lengths = detail::mollified(flat, 1);
    CHECK(detail::triangle_area(lengths) > 0);
    for (std::size_t k = 0; k < 3; ++k) CHECK(lengths[k] >= flat[k]);
    for (const double weight : half_cotangents(detail::laid_out(lengths))) {
      CHECK(std::isfinite(weight));
    }
  }
}

TEST_CASE("components are named by their first vertex") {
  const std::vector<Mesh<double>> parts{grid<double>(1, 1), box(1.0, 1.0, 1.0)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({7, 7, 7});
  const auto component = component_of_vertices(intrinsic_triangulation(Surface(mesh)));
  for (Index v = 0; v < 13; ++v) CHECK(component[v] == (v < 4 ? 0 : v < 12 ? 4 : 12));
}

TEST_CASE("a pattern has each edge once, in ascending rows, and each half-edge its entry") {
  test::Random random(3);
  for (int kind = 0; kind < 40; ++kind) {
    CAPTURE(kind);
    // Of every kind; two have edges of three faces.
    const auto mesh = test::small_random_mesh(kind % 10, random);
    const Surface<double> surface(mesh);
    const auto triangulation = intrinsic_triangulation(surface, 1.0);
    const SymmetricPattern<double> pattern(triangulation);
    std::set<std::pair<Index, Index>> edges;  // column, row
    for (Index v = 0; v < surface.vertex_count(); ++v) edges.emplace(v, v);
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      edges.insert(std::minmax(surface.origin(h), surface.tip(h)));
    }
    REQUIRE(pattern.size() == surface.vertex_count());
    CHECK(pattern.entry_count() == std::ssize(edges));
    auto expected = edges.begin();
    for (Index column = 0; column < pattern.size(); ++column) {
      CHECK(pattern.diagonal(column) == pattern.begin(column));
      for (Index e = pattern.begin(column); e < pattern.begin(column + 1); ++e, ++expected) {
        CHECK(std::pair(column, pattern.row(e)) == *expected);
      }
    }
    for (Index h = 0; h < surface.halfedge_count(); ++h) {
      const std::pair<Index, Index> ends = std::minmax(surface.origin(h), surface.tip(h));
      const auto [low, high] = ends;
      const Index e = pattern.entry(h);
      CHECK(pattern.row(e) == high);
      CHECK(pattern.begin(low) <= e);
      CHECK(e < pattern.begin(low + 1));
    }
  }
}
