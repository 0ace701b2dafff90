#include "gelight/geodesic/virtual_source.hpp"

#include "support/marching_cases.hpp"

using namespace gelight;

namespace {

using Solver = VirtualSourceSolver<double>;

}  // namespace

TEST_CASE("flat sheets: straight lines, from any kind of point") {
  test::check_flat_sheets<Solver>();
}

TEST_CASE("parts, strays, fins, bow-ties, flat faces and flipped ones") {
  test::check_topology<Solver>();
}

TEST_CASE("scales with the mesh, at any distance from the origin") { test::check_scales<Solver>(); }

TEST_CASE("never longer than along edges; a query leaves no trace") {
  test::check_bounds_and_traces<Solver>();
}

TEST_CASE("a fan of 10,000 spokes") { test::check_fan<Solver>(); }

TEST_CASE("spheres: mean and largest error, and the order at which they fall") {
  test::Error before, first;
  for (const int level : {3, 4, 5, 6}) {
    const test::Error error = test::sphere_error<Solver>(level, 130);
    MESSAGE("level " << level << ": mean " << error.mean << ", max " << error.max);
    if (level == 3) first = error;
    before = error;
  }
  CHECK(std::log2(first.mean / before.mean) / 3 > 1.8);
  CHECK(before.mean < 2e-4);
  CHECK(before.max < 0.002);
}

TEST_CASE("thin and obtuse triangles: near the exact polyhedral distance") {
  for (const double stretch : {5.0, 20.0}) {
    auto mesh = icosphere<double>(4);
    for (auto& p : mesh.positions) p[2] *= stretch;
    const std::vector<Source<double>> sources{{vertex_point<double>(100), 0}};
    const auto error = test::polyhedral_error<Solver>(mesh, sources);
    MESSAGE("stretched x" << stretch << ": mean " << error.mean << ", max " << error.max);
    CHECK(error.mean < 2e-3);
    CHECK(error.max < 0.02);
  }
}

// The image of the corner is exact; images of the source that look past it are off by a share that
// is allowed for.
TEST_CASE("behind a corner of the border") {
  for (const Index n : {10, 20, 40, 80}) {
    const auto error = test::corner_error<Solver>(n);
    MESSAGE(n << " cells: mean " << error.mean << ", max " << error.max);
    CHECK(error.max < 3e-3);
  }
}

TEST_CASE("several sources") {
  test::Random random(3);
  const auto mesh = test::jittered_grid(16, 0.2, random);
  using Point = std::vector<Source<double>>;
  const auto at = [](Index v, double d) { return Source<double>{vertex_point<double>(v), d}; };
  for (const auto& sources :
       {Point{at(3, 0), at(150, 0), at(260, 0)}, Point{at(3, 5), at(150, 2), at(260, 3.5)},
        Point{at(150, 0), at(3, 0)}}) {
    CHECK(test::polyhedral_error<Solver>(mesh, sources).max < 1e-3);
  }
  for (const int per_edge : {1, 16}) {
    const auto error = test::polyhedral_error<Solver>(mesh, test::border_sources(mesh, per_edge));
    MESSAGE("a whole border: mean " << error.mean << ", max " << error.max);
    CHECK(error.mean < 5e-3);
    CHECK(error.max < 0.02);
  }
}

TEST_CASE("repeated sources, and start distances that are all less by a number") {
  test::check_equal_sources<Solver>();
}
