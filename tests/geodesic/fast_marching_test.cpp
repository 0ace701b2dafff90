#include "gelight/geodesic/fast_marching.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>

#include "support/approx.hpp"
#include "support/marching_cases.hpp"

using namespace gelight;

namespace {

using Solver = FastMarchingSolver<double>;
static_assert(DistanceSolver<FastMarchingSolver<double>, double>);
static_assert(DistanceSolver<FastMarchingSolver<float>, float>);

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
  test::check_spheres<Solver>(1.0, {.mean = 8e-4, .max = 0.006});
}

TEST_CASE("thin and obtuse triangles: near the exact polyhedral distance") {
  test::check_stretched_spheres<Solver>();
}

// Behind the corner a front of order one half starts anew: there edges alone lead on at first.
TEST_CASE("behind a corner of the border the error falls with order one half") {
  test::Error first, last;
  for (const Index n : {10, 20, 40, 80}) {
    last = test::corner_error<Solver>(n);
    MESSAGE(n << " cells: mean " << last.mean << ", max " << last.max);
    if (n == 10) first = last;
  }
  CHECK(std::log2(first.mean / last.mean) / 3 > 0.5);
  CHECK(std::log2(first.max / last.max) / 3 > 0.5);
  CHECK(last.mean < 1e-3);
  CHECK(last.max < 7e-3);
}

// Where waves meet, 6 or more from the sources, the last edge, of length sqrt(2), is taken for a
// straight line, which loses 2/sqrt(3) - 1 of it at most.
TEST_CASE("several sources: waves of two never make one, so only edges lead where they meet") {
  test::Random random(3);
  const auto mesh = test::jittered_grid(16, 0.2, random);
  using Point = std::vector<Source<double>>;
  const auto at = [](Index v, double d) { return Source<double>{vertex_point<double>(v), d}; };
  for (const auto& sources :
       {Point{at(3, 0), at(150, 0), at(260, 0)}, Point{at(3, 5), at(150, 2), at(260, 3.5)},
        Point{at(150, 0), at(3, 0)}}) {
    const auto error = test::polyhedral_error<Solver>(mesh, sources);
    CHECK(error.mean < 1e-3);
    CHECK(error.max < (2 / std::sqrt(3.0) - 1) * std::sqrt(2.0) / 6);
  }
  // There every vertex is beside a place where waves meet.
  for (const int per_edge : {1, 16}) {
    const auto error = test::polyhedral_error<Solver>(mesh, test::border_sources(mesh, per_edge));
    MESSAGE("a whole border: mean " << error.mean << ", max " << error.max);
    CHECK(error.mean < 0.01);
    CHECK(error.max < 2 / std::sqrt(3.0) - 1);
  }
}

TEST_CASE("repeated sources, and start distances that are all less by a number") {
  test::check_equal_sources<Solver>();
}

TEST_CASE("many sources: as near as the nearest alone") {
  const auto excess = test::excess_of_several<Solver>();
  MESSAGE(excess.beyond_a_twentieth << " of " << excess.trials << " trials beyond a twentieth of "
                                    << "the mean edge, " << excess.largest << " at most");
  CHECK(excess.beyond_a_twentieth <= excess.trials / 20);
  CHECK(excess.largest < 0.5);
}

TEST_CASE("sources side by side: as near as the nearest alone") { test::check_curves<Solver>(); }

TEST_CASE("a hook cancels and follows queries") {
  test::check_cancelling<Solver, FastMarchingOptions>();
}

TEST_CASE("below the straight line by rounding alone, which grows with the length of needles") {
  for (const auto& [stretch, most] : {std::pair{1.0, 1e-12}, {100.0, 2e-10}, {1e4, 1e-6}}) {
    double below = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
      test::Random random(seed);
      const auto mesh = test::scans::stretched(test::jittered_grid(20, 0.2, random), stretch);
      const Surface surface(mesh);
      const Solver solver(mesh);
      for (int i = 0; i < 12; ++i) {
        const auto point = i % 3 == 0 ? vertex_point<double>(test::uniform_index(random, 441))
                                      : test::random_point(mesh, random);
        const std::vector<Source<double>> sources{{point, 0}};
        const auto d = solver.distance(std::span<const Source<double>>(sources));
        const auto from = surface.position(point);
        for (std::size_t v = 0; v < d.size(); ++v) {
          const double straight = (test::at(mesh, v) - from).norm();
          if (straight > 0) below = std::max(below, 1 - d[v] / straight);
        }
      }
    }
    MESSAGE("stretched " << stretch << ": " << below << " below");
    CHECK(below < most);
  }
}

// Corners of a face that lies on a line say nothing of where a wave crosses it.
TEST_CASE("caps without area, on both sides of a flat sheet's edges, take no distance away") {
  std::mt19937 random(5);
  int caps = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const double height = trial % 3 == 0 ? 0 : std::pow(10.0, -1.0 - trial % 14);
    auto mesh = grid<double>(7, 7, 1.0, 1.0);
    const auto faces = std::exchange(mesh.faces, {});
    for (const auto& face : faces) {
      if (random() % 3 != 0) {
        mesh.faces.push_back(face);
        continue;
      }
      // A vertex on the first edge, or but a little inside the face.
      const double t = 0.25 * (1 + static_cast<double>(random() % 3));
      const auto middle = static_cast<Index>(mesh.positions.size());
      std::array<double, 3> p{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto at = [&](std::size_t c) {
          return mesh.positions[static_cast<std::size_t>(face[c])][k];
        };
        p[k] = (1 - height) * ((1 - t) * at(0) + t * at(1)) + height * at(2);
      }
      mesh.positions.push_back(p);
      mesh.faces.push_back({face[0], middle, face[2]});
      mesh.faces.push_back({middle, face[1], face[2]});
      mesh.faces.push_back({face[0], face[1], middle});
      ++caps;
    }
    CAPTURE(trial);
    const auto source = static_cast<Index>(random() % mesh.positions.size());
    const auto& s = mesh.positions[static_cast<std::size_t>(source)];
    const auto found = FastMarchingSolver(mesh).distance(source);
    for (std::size_t v = 0; v < found.size(); ++v) {
      const auto& p = mesh.positions[v];
      const double straight = std::hypot(p[0] - s[0], p[1] - s[1]);
      CHECK(found[v] >= straight * (1 - 1e-6));
      CHECK(found[v] <= straight * (1 + 1e-3) + 1e-12);
    }
  }
  CHECK(caps > 1000);
}

TEST_CASE("a cap without area at the border: ways go round it by its edges") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 300; ++trial) {
    // Turned and moved, so that rounding makes the area what it likes; of whole numbers, too.
    Eigen::Matrix3d axes;
    Eigen::Vector3d origin;
    for (int i = 0; i < 3; ++i) {
      origin[i] = trial % 2 == 0 ? static_cast<double>(random() % 5) : uniform(random);
      for (int k = 0; k < 3; ++k) {
        axes(i, k) = trial % 2 == 0 ? static_cast<double>(random() % 5) - 2 : uniform(random);
      }
    }
    const double middle = 0.25 * (1 + static_cast<double>(random() % 3));
    const auto at = [&](double x, double y) -> std::array<double, 3> {
      const Eigen::Vector3d p = origin + axes * Eigen::Vector3d(x, y, 0);
      return {p[0], p[1], p[2]};
    };
    Mesh<double> mesh;
    mesh.positions = {at(0, 0), at(1, 0), at(0.5 * middle, 1), at(middle, 0)};
    mesh.faces = {{0, 1, 3}, {0, 3, 2}};
    const auto length = [&](std::size_t a, std::size_t b) {
      const auto &p = mesh.positions[a], &q = mesh.positions[b];
      return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    };
    if (length(0, 1) == 0 || length(0, 2) == 0 || length(2, 3) == 0) continue;
    CAPTURE(trial);
    const auto found = FastMarchingSolver(mesh).distance(2);
    // (Where all is on one line ways are along it.)
    CHECK(found[0] == gelight::test::approx(length(2, 0)).epsilon(1e-6));
    CHECK(found[3] == gelight::test::approx(length(2, 3)).epsilon(1e-6));
    CHECK(found[1] == gelight::test::approx(length(2, 3) + length(3, 1)).epsilon(1e-6));
  }
}

TEST_CASE("ways far longer than the mesh is wide scale with it, as far as coordinates may go") {
  // A strip in so many folds that the square of a way times that of an edge is beyond all numbers.
  test::Random random(3);
  Mesh<double> mesh;
  constexpr Index folds = 10000;
  for (Index i = 0; i <= folds; ++i) {
    for (Index j = 0; j < 3; ++j) {
      mesh.positions.push_back({(i % 2 == 0 ? -1 : 1) * test::uniform(random, 0.6, 1),
                                (j - 1) * test::uniform(random, 0.5, 0.9),
                                test::uniform(random, -1, 1)});
    }
  }
  for (Index i = 0; i < folds; ++i) {
    for (const Index a : {3 * i, 3 * i + 1}) {
      mesh.faces.push_back({a, a + 3, a + 4});
      mesh.faces.push_back({a, a + 4, a + 1});
    }
  }
  const auto expected = FastMarchingSolver(mesh).distance(1);
  for (const double scale : {0x1p249, 0x1p-240}) {
    Mesh<double> scaled = mesh;
    for (auto& position : scaled.positions) {
      for (double& x : position) x *= scale;
    }
    auto distance = FastMarchingSolver(scaled).distance(1);
    for (double& d : distance) d /= scale;
    CHECK(distance == expected);
  }
}
