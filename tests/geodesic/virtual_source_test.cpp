#include "gelight/geodesic/virtual_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "support/approx.hpp"
#include "support/marching_cases.hpp"

using namespace gelight;

namespace {

using Solver = VirtualSourceSolver<double>;
static_assert(DistanceSolver<VirtualSourceSolver<double>, double>);
static_assert(DistanceSolver<VirtualSourceSolver<float>, float>);

double mean_edge(const Mesh<double>& mesh) {
  double sum = 0;
  for (const auto& face : mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double> a(mesh.position(face[k]).data());
      const Vec3<double> b(mesh.position(face[(k + 1) % 3]).data());
      sum += (b - a).norm();
    }
  }
  return sum / (3.0 * static_cast<double>(mesh.faces.size()));
}

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
  test::check_spheres<Solver>(1.8, {.mean = 2e-4, .max = 0.002});
}

TEST_CASE("thin and obtuse triangles: near the exact polyhedral distance") {
  test::check_stretched_spheres<Solver>();
}

// Ways that bend at a needle's corner are longer than the straight one by less than 1e-10, but show
// nothing of what the straight one shows.
TEST_CASE("needles of 1 : 1,000,000 on a flat sheet: straight lines") {
  auto mesh = test::random_sheet(40);
  for (auto& p : mesh.positions) p[0] *= 1e6;
  const Index from = 41 * 20 + 20;
  const auto distance = Solver(mesh).distance(from);
  const Vec3<double> source(mesh.positions[from].data());
  for (std::size_t v = 0; v < distance.size(); ++v) {
    const double straight = (Vec3<double>(mesh.positions[v].data()) - source).norm();
    CHECK(distance[v] == gelight::test::approx(straight).epsilon(1e-7));
  }
}

TEST_CASE("a query ends, also where rounding has vertices better each other in a circle") {
  // Cut from a grid that is slanted by 2765: found by random tests.
  const Mesh<double> mesh{
      {{525.62603051623262, -1759.2827488947614, 0}, {512.70141599059423, -1716.0238318896666, 0},
       {529.74041351979281, -1773.0538615568232, 0}, {601.45620237816411, -2013.0880007366695, 0},
       {581.88134068867225, -1947.5705808325322, 0}, {582.45996698510464, -1949.5073536514535, 0},
       {596.3235490078464, -1995.9091530333135, 0},  {594.01971958948616, -1988.19825296416, 0},
       {602.48792365663473, -2016.5416092562734, 0}, {587.45201054668348, -1966.2161491272, 0},
       {603.61631778007268, -2020.3185605332164, 0}, {601.50569717741621, -2013.2544279439248, 0},
       {587.19236307764606, -1965.3474416894771, 0}, {596.01282996849159, -1994.869844935939, 0},
       {592.99766278010884, -1984.7780797332407, 0}, {673.85073478693766, -2255.3942776312683, 0},
       {660.38541347348485, -2210.3256352058547, 0}, {667.08629616608266, -2232.7537103498794, 0},
       {668.21981017201256, -2236.5477096573741, 0}, {664.6234587907179, -2224.5107283024504, 0},
       {674.69237220645959, -2258.2116704571313, 0}, {664.06002520529637, -2222.6250351386557, 0},
       {655.66725337039452, -2194.5343315574837, 0}, {660.40104260905025, -2210.3785042062586, 0},
       {661.1790188985002, -2212.9824973934415, 0},  {675.23872658180255, -2260.0407763790772, 0},
       {669.64214740745069, -2241.3089528286623, 0}, {654.51701699188948, -2190.6849058607186, 0},
       {673.95434072476917, -2255.7421459118805, 0}, {715.50981601990588, -2394.8281976072631, 0},
       {730.40540573193198, -2444.684178709389, 0},  {727.50865768580297, -2434.9887547897902, 0},
       {718.48440146702035, -2404.7844509101642, 0}, {715.05895554094582, -2393.3194784744046, 0},
       {720.51525780330394, -2411.5819446691139, 0}, {727.24167490863772, -2434.0955243680878, 0},
       {738.95857339076133, -2473.3123409528575, 0}, {716.18493199805005, -2397.0885031523953, 0},
       {727.25704091764885, -2434.1472039784221, 0}, {718.71550546177116, -2405.5585407115432, 0},
       {735.0219231966505, -2460.1366117575285, 0},  {723.49215638013266, -2421.5463044414214, 0},
       {716.7337331890019, -2398.9257693251498, 0}},
      {{0, 4, 3},    {1, 5, 4},    {1, 2, 5},    {2, 6, 5},    {2, 7, 6},    {3, 4, 15},
       {4, 5, 15},   {5, 16, 15},  {5, 6, 16},   {6, 17, 16},  {6, 7, 17},   {7, 18, 17},
       {7, 8, 18},   {8, 19, 18},  {8, 9, 19},   {9, 20, 19},  {9, 21, 20},  {10, 22, 21},
       {11, 23, 22}, {11, 12, 24}, {11, 24, 23}, {12, 13, 25}, {12, 25, 24}, {13, 14, 25},
       {14, 26, 25}, {15, 16, 29}, {16, 30, 29}, {16, 17, 31}, {16, 31, 30}, {17, 32, 31},
       {18, 19, 33}, {18, 33, 32}, {19, 20, 34}, {19, 34, 33}, {20, 21, 35}, {20, 35, 34},
       {21, 22, 36}, {21, 36, 35}, {22, 23, 36}, {23, 37, 36}, {23, 24, 38}, {23, 38, 37},
       {24, 25, 38}, {25, 39, 38}, {25, 26, 39}, {26, 40, 39}, {26, 27, 40}, {27, 41, 40},
       {27, 28, 41}, {28, 42, 41}}};
  int asked = 0;
  const CancelHook stops_late = [&] { return ++asked > 1000; };  // after millions of vertices
  const VirtualSourceSolver solver(mesh, {.cancelled = stops_late});
  const Source<double> source{edge_point<double>(28, 42, 0.033766612058229409), 0};
  const auto found = solver.distance(source);
  const auto along_edges = DijkstraSolver(mesh).distance(source);
  const Vec3<double> from = solver.surface().position(source.point);
  for (std::size_t v = 0; v < found.size(); ++v) {
    CAPTURE(v);
    const Vec3<double> to = solver.surface().position(static_cast<Index>(v));
    CHECK(found[v] >= (to - from).norm() * (1 - 1e-12));
    CHECK(found[v] <= along_edges[v] * (1 + 1e-12));
  }
}

// A vertex that saw an image before the other end of an edge did must not keep what it guessed.
TEST_CASE("flat sheets whose triangles are thin or slanted: straight lines") {
  for (const double factor : {3.0, 10.0, 100.0, 1e3, 1e4}) {
    for (const bool is_slanted : {false, true}) {
      double worst = 0;  // in mean edges
      for (unsigned seed = 0; seed < 6; ++seed) {
        test::Random random(seed);
        auto mesh = test::jittered_grid(30, 0.2, random);
        for (auto& p : mesh.positions) p[0] = is_slanted ? p[0] + factor * p[1] : factor * p[0];
        const auto from = random() % mesh.positions.size();
        const auto distance = Solver(mesh).distance(static_cast<Index>(from));
        const Vec3<double> source(mesh.positions[from].data());
        const double edge = mean_edge(mesh);
        for (std::size_t v = 0; v < distance.size(); ++v) {
          const double straight = (Vec3<double>(mesh.positions[v].data()) - source).norm();
          worst = std::max(worst, std::abs(distance[v] - straight) / edge);
        }
      }
      CAPTURE(factor);
      CAPTURE(is_slanted);
      CHECK(worst < 1e-10);
    }
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

// Along the edges of a prism's open end every vertex has a bent way as long as the straight one.
TEST_CASE("of two ways equally long the straighter is kept: a prism of six sides is exact") {
  constexpr Index sides = 6, rings = 12;
  Mesh<double> prism;
  for (Index k = 0; k < rings; ++k) {
    for (Index j = 0; j < sides; ++j) {
      const double turn = 2 * std::numbers::pi * j / sides;
      prism.positions.push_back({std::cos(turn), std::sin(turn), 1.0 * k});
      if (k == 0) continue;
      const Index a = sides * (k - 1) + j, b = sides * (k - 1) + (j + 1) % sides;
      prism.faces.push_back({a, b, b + sides});
      prism.faces.push_back({a, b + sides, a + sides});
    }
  }
  const auto d = Solver(prism).distance(0);
  for (Index v = 0; v < sides * rings; ++v) {
    const Index j = v % sides, k = v / sides;
    const double unrolled = std::hypot(std::min(j, sides - j), k);
    CHECK(d[static_cast<std::size_t>(v)] == gelight::test::approx(unrolled).epsilon(1e-13));
  }
}

TEST_CASE("a source in the middle of an edge of a face without area sees through it") {
  auto mesh = grid<double>(8, 8, 8, 8);
  // Face 0 is (0, 1, 10): its edge from 10 to 0 gets a vertex in the middle and a flat face.
  const auto middle = static_cast<Index>(mesh.positions.size());
  const auto face = mesh.faces[0];
  const auto p = mesh.positions[static_cast<std::size_t>(face[2])];
  const auto q = mesh.positions[static_cast<std::size_t>(face[0])];
  mesh.positions.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, 0});
  mesh.faces[0] = {face[0], face[1], middle};
  mesh.faces.push_back({middle, face[1], face[2]});
  mesh.faces.push_back({face[2], face[0], middle});
  const auto d = Solver(mesh).distance(middle);
  for (std::size_t v = 0; v < d.size(); ++v) {
    const auto& at = mesh.positions[v];
    const auto& source = mesh.positions.back();
    const double straight = std::hypot(at[0] - source[0], at[1] - source[1]);
    CHECK(d[v] == gelight::test::approx(straight).epsilon(1e-13));
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

// The exact solver is the truth.
TEST_CASE("rough, creased and bordered meshes: nearer the truth than fast marching on each") {
  double mean = 0;
  const auto meshes = test::scan_meshes(3);
  for (const auto& named : meshes) {
    const auto& mesh = named.mesh;
    const auto middle = static_cast<Index>(mesh.positions.size() / 2);
    const std::vector<Source<double>> sources{{vertex_point<double>(middle), 0}};
    const auto error = test::polyhedral_error<Solver>(mesh, sources);
    CAPTURE(named.name);
    CHECK(error.mean <
          test::polyhedral_error<FastMarchingSolver<double>>(mesh, sources).mean * 1.25);
    CHECK(error.max < 0.1);
    mean += error.mean / static_cast<double>(meshes.size());
  }
  MESSAGE("mean " << mean);
  CHECK(mean < 2.5e-3);
}

TEST_CASE("never below the straight line through space") {
  for (const auto& [name, mesh] : test::many_meshes()) {
    const Solver solver(mesh);
    const auto count = static_cast<Index>(mesh.positions.size());
    for (const Index v : {Index{0}, count / 3, count - 1}) {
      const auto d = solver.distance(v);
      for (std::size_t w = 0; w < d.size(); ++w) {
        const double straight =
            (test::at(mesh, w) - test::at(mesh, static_cast<std::size_t>(v))).norm();
        CHECK(d[w] >= straight * (1 - 1e-14));
      }
    }
  }
}

TEST_CASE("a source next to a vertex: distances from the vertex") {
  test::Random random(7);
  for (const auto& named : test::many_meshes()) {
    const auto& mesh = named.mesh;
    const Solver solver(mesh);
    const double edge = test::scans::mean_edge(mesh);
    const Index face = test::uniform_index(random, static_cast<Index>(mesh.faces.size()));
    const auto d = solver.distance(mesh.faces[static_cast<std::size_t>(face)][0]);
    for (const double share : {1e-6, 1e-9, 1e-13, 1e-17, 1e-20}) {
      const std::vector<Source<double>> near{
          {face_point<double>(face, {1 - 2 * share, share, share}), 0}};
      const auto moved = solver.distance(near);
      CAPTURE(named.name);
      CAPTURE(share);
      for (std::size_t v = 0; v < d.size(); ++v) {
        if (std::isfinite(d[v])) CHECK(std::abs(moved[v] - d[v]) < 0.08 * edge);
      }
    }
  }
}

TEST_CASE("many sources: as near as the nearest alone") {
  const auto excess = test::excess_of_several<Solver>();
  MESSAGE(excess.beyond_a_twentieth << " of " << excess.trials << " trials beyond a twentieth of "
                                    << "the mean edge, " << excess.largest << " at most");
  CHECK(excess.beyond_a_twentieth <= excess.trials / 20);
  CHECK(excess.largest < 0.2);
}

TEST_CASE("sources side by side: as near as the nearest alone") { test::check_curves<Solver>(); }

TEST_CASE("a hook cancels and follows queries") {
  test::check_cancelling<Solver, VirtualSourceOptions>();
}

TEST_CASE("fins on inner edges lengthen no way over a flat sheet") {
  for (const Index one_in : {1, 2, 5, 40}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      CAPTURE(one_in);
      CAPTURE(seed);
      test::Random random(seed);
      auto mesh = test::jittered_grid(16, 0.2, random);
      const Surface sheet(mesh);
      for (Index h = 0; h < sheet.halfedge_count(); ++h) {
        const Index a = sheet.origin(h), b = sheet.tip(h);
        if (sheet.is_border(h) || sheet.twin(h) < h || test::uniform_index(random, one_in) > 0) {
          continue;
        }
        const Vec3<double> middle = (sheet.position(a) + sheet.position(b)) / 2;
        mesh.faces.push_back({a, b, static_cast<Index>(mesh.positions.size())});
        mesh.positions.push_back({middle[0], middle[1], test::uniform(random, -0.1, 0.1)});
      }
      std::shuffle(mesh.faces.begin(), mesh.faces.end(), random);
      for (auto& face : mesh.faces) {
        if (test::uniform_index(random, 2) == 0) std::swap(face[0], face[1]);
      }
      const Solver solver(mesh);
      for (const Index source : {Index{0}, Index{8}, Index{144}, Index{211}}) {
        const auto d = solver.distance(source);
        for (Index v = 0; v < sheet.vertex_count(); ++v) {
          const double straight = (sheet.position(v) - sheet.position(source)).norm();
          CHECK(std::abs(d[static_cast<std::size_t>(v)] - straight) <= 1e-6 * straight);
        }
      }
    }
  }
}
