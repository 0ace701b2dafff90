#include "gelight/transport/log_map.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/approx.hpp"

using namespace gelight;
using std::numbers::pi;
using Vec = Vec3<double>;

namespace {

Vec embedded(const std::array<Vec, 2>& basis, const Vec2<double>& at) {
  return at[0] * basis[0] + at[1] * basis[1];
}

double angle_between(const Vec& a, const Vec& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// A flat torus of 2 columns x 2 rows square cells of side 1, folded flat along two lines each way:
// cell (i, j) lies over the cell it is folded onto, every length is as in the sheet.
Mesh<double> folded_torus(Index columns, Index rows) {
  Mesh<double> mesh;
  const auto folded = [](Index k, Index half) { return double(k <= half ? k : 2 * half - k); };
  for (Index j = 0; j < 2 * rows; ++j) {
    for (Index i = 0; i < 2 * columns; ++i) {
      mesh.positions.push_back({folded(i, columns), folded(j, rows), 0});
    }
  }
  const auto at = [&](Index i, Index j) {
    return j % (2 * rows) * 2 * columns + i % (2 * columns);
  };
  for (Index j = 0; j < 2 * rows; ++j) {
    for (Index i = 0; i < 2 * columns; ++i) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("of a flat sheet it is the difference of positions, from any source to any point") {
  const Surface sheet(grid<double>(9, 7, 1.3, 1.0));
  const ExactLogMapSolver solver(sheet);
  for (const auto& source :
       {vertex_point<double>(0), vertex_point<double>(34), edge_point<double>(34, 35, 0.3),
        edge_point<double>(35, 34, 0.3), edge_point<double>(0, 1, 0.5),
        face_point<double>(57, {0.2, 0.5, 0.3})}) {
    const auto map = solver.solve(source);
    const Vec s = sheet.position(source);
    for (Index v = 0; v < sheet.vertex_count(); ++v) {
      CHECK((embedded(map.tangent_basis(), map(v)) - (sheet.position(v) - s)).norm() < 1e-13);
    }
    for (Index f = 0; f < sheet.face_count(); ++f) {
      const auto p = face_point<double>(f, {0.1, 0.3, 0.6});
      CHECK((embedded(map.tangent_basis(), map(p)) - (sheet.position(p) - s)).norm() < 1e-13);
    }
  }
}

TEST_CASE("radius is the exact distance; on a sphere the direction is the great circle's") {
  std::vector<double> means;
  for (const int level : {2, 3, 4}) {
    const auto mesh = icosphere<double>(level);
    const Surface surface(mesh);
    const ExactLogMapSolver solver(surface);
    const auto map = solver.solve(7);
    const Vec s = surface.position(7);
    double mean = 0;
    int count = 0;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      CHECK(map(v).norm() == gelight::test::approx(map.field().distance(v)).epsilon(1e-14));
      const Vec p = surface.position(v);
      if (v == 7 || (p + s).norm() < 1e-9) continue;
      mean += angle_between(embedded(map.tangent_basis(), map(v)), p - p.dot(s) * s);
      ++count;
    }
    means.push_back(mean / count * 180 / pi);
  }
  MESSAGE("mean angle to the great circle, degrees: " << means[0] << ", " << means[1] << ", "
                                                      << means[2]);
  CHECK(means[1] < 0.6 * means[0]);
  CHECK(means[2] < 0.6 * means[1]);
}

TEST_CASE("on a flat torus it is the least of the lattice's shifts, and ties are the cut locus") {
  const Index columns = 4, rows = 6, wide = 2 * columns, high = 2 * rows;
  const auto mesh = folded_torus(columns, rows);
  const ExactLogMapSolver solver(mesh);
  const VectorHeatSolver heat(mesh);
  // Off the folds, where two ways would arrive in one direction of space.
  for (const Index source : {3 * wide + 2, wide + columns + 1, 11 * wide + 5}) {
    const auto map = solver.solve(source);
    const auto by_heat = heat.log_map(source);
    const Index i0 = source % wide, j0 = source / wide;
    // The sheet's axes in the basis, told by the neighbours to the right and above.
    const auto neighbour = [&](Index di, Index dj) {
      return (j0 + dj) % high * wide + (i0 + di) % wide;
    };
    const Vec2<double> right = map(neighbour(1, 0)), up = map(neighbour(0, 1));
    CHECK(right.norm() == gelight::test::approx(1).epsilon(1e-14));
    CHECK(up.norm() == gelight::test::approx(1).epsilon(1e-14));
    CHECK(std::abs(right.dot(up)) < 1e-14);
    double heat_off = 0, heat_turn = 0;
    int count = 0;
    for (Index v = 0; v < wide * high; ++v) {
      const Vec2<double> found(map(v).dot(right), map(v).dot(up));
      Vec2<double> way(v % wide - i0, v / wide - j0);
      way -= Vec2<double>(wide * std::round(way[0] / wide), high * std::round(way[1] / high));
      const bool is_tie = 2 * std::abs(way[0]) == wide || 2 * std::abs(way[1]) == high;
      CHECK(map.is_on_cut_locus(v, 1e-9) == is_tie);
      // On the cut locus any of the ways is right.
      if (2 * std::abs(way[0]) == wide) way[0] = std::copysign(way[0], found[0]);
      if (2 * std::abs(way[1]) == high) way[1] = std::copysign(way[1], found[1]);
      CHECK((found - way).norm() < 1e-12);
      if (is_tie || v == source) continue;
      const Vec2<double> h = by_heat[static_cast<std::size_t>(v)];
      heat_off += std::abs(h.norm() / way.norm() - 1);
      heat_turn += angle_between({map(v)[0], map(v)[1], 0}, {h[0], h[1], 0});
      ++count;
    }
    MESSAGE("vector heat, source " << source << ": radius " << 100 * heat_off / count
                                   << " % off, direction " << heat_turn / count * 180 / pi
                                   << " degrees (mean)");
    CHECK(heat_off / count < 0.1);
    CHECK(heat_turn / count < 0.15);
  }
}

TEST_CASE("turning the mesh turns nothing: coordinates go with the basis") {
  const auto mesh = torus(2.0, 0.7, 24, 12);
  const ExactLogMapSolver solver(mesh);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2, Vec(1, 2, -3).normalized()).toRotationMatrix();
  const ExactLogMapSolver turned(placed(mesh, turn, Vec(5, 6, 7)));
  const auto a = solver.solve(33), b = turned.solve(33);
  for (Index v = 0; v < 24 * 12; ++v) {
    if (a.is_on_cut_locus(v, 1e-9)) continue;
    const Vec expected = turn * embedded(a.tangent_basis(), a(v));
    CHECK((embedded(b.tangent_basis(), b(v)) - expected).norm() < 1e-9);
  }
}

TEST_CASE("how far vector heat's log map is from the exact one") {
  for (const int level : {4, 5}) {
    auto mesh = icosphere<double>(level);
    for (auto& p : mesh.positions) p[2] *= 0.6;
    const ExactLogMapSolver exact(mesh);
    const VectorHeatSolver heat(mesh);
    const auto map = exact.solve(7);
    const auto found = heat.log_map(7);
    CHECK((heat.tangent_basis(7)[0] - map.tangent_basis()[0]).norm() < 1e-14);
    double farthest = 0, radius = 0, worst_radius = 0, direction = 0, worst_direction = 0;
    for (const double d : map.field().distances()) farthest = std::max(farthest, d);
    int count = 0;
    for (Index v = 0; v < static_cast<Index>(found.size()); ++v) {
      const double d = map.field().distance(v);
      if (v == 7 || d > 0.8 * farthest) continue;
      const Vec2<double> truth = map(v), at = found[static_cast<std::size_t>(v)];
      const double off = std::abs(at.norm() / d - 1);
      const double turn = std::abs(std::atan2(truth[0] * at[1] - truth[1] * at[0], truth.dot(at)));
      radius += off;
      direction += turn;
      worst_radius = std::max(worst_radius, off);
      worst_direction = std::max(worst_direction, turn);
      ++count;
    }
    MESSAGE("level " << level << ": radius " << 100 * radius / count << " % mean, "
                     << 100 * worst_radius << " % largest; direction "
                     << direction / count * 180 / pi << ", " << worst_direction * 180 / pi
                     << " degrees");
    CHECK(radius / count < 0.01);
    CHECK(worst_radius < 0.05);
    CHECK(direction / count < 2 * pi / 180);
  }
}

TEST_CASE("out of reach is infinite, the source is zero, bad input is refused") {
  const std::vector<Mesh<double>> parts{icosphere<double>(1), grid<double>(2, 2)};
  auto mesh = joined<double>(parts);
  mesh.positions.push_back({9, 9, 9});
  const ExactLogMapSolver solver(mesh);
  const auto map = solver.log_map(0);
  CHECK(map[0].norm() == 0);
  for (std::size_t v = 0; v < map.size(); ++v) CHECK(std::isfinite(map[v].norm()) == (v < 42));
  CHECK_THROWS_AS((void)solver.log_map(static_cast<Index>(mesh.positions.size()) - 1),
                  InvalidInput);
  CHECK_THROWS_AS((void)solver.log_map(-1), InvalidInput);
  CHECK_THROWS_AS((void)solver.solve(0)(1000), InvalidInput);
  std::swap(mesh.faces[3][0], mesh.faces[3][1]);
  CHECK_THROWS_AS(ExactLogMapSolver{mesh}, InvalidInput);
}

TEST_CASE("a map is cancelled wherever it asks, and says how far it is") {
  const auto mesh = icosphere<double>(3);
  int left = -1;
  double last = 0;
  bool falls = false;
  const CancelHook hook([&](double done) {
    falls |= done < last;
    last = done;
    return --left == 0;
  });
  const ExactLogMapSolver solver(mesh, {.cancelled = hook});
  const auto expected = ExactLogMapSolver(mesh).log_map(7);
  CHECK(solver.log_map(7) == expected);
  CHECK_FALSE(falls);
  CHECK(last > 0.7);
  const int asked = -1 - left;
  CHECK(asked > 4);
  for (int yes = 1; yes <= asked; ++yes) {
    left = yes;
    CHECK_THROWS_AS((void)solver.log_map(7), Cancelled);
    left = -1;
    CHECK(solver.log_map(7) == expected);
  }
  const auto map = solver.solve(7);
  left = 1;
  CHECK_THROWS_AS((void)map.at_vertices(), Cancelled);
  left = -1;
  CHECK(map.at_vertices() == expected);
}

namespace {

// A sheet of 8 x 8 cells, somewhere in space, of which some vertices are moved: those round one to
// its place or to a line through it, or a border vertex added to a cell's edge.
Mesh<double> degenerate_sheet(int kind, int seed) {
  auto mesh = grid<double>(8, 8);
  std::mt19937 engine(static_cast<unsigned>(seed));
  std::uniform_real_distribution<double> share(0.1, 0.9);
  const Index c = 30 + seed;
  for (const Index v : {c - 10, c - 9, c - 8, c - 1, c + 1, c + 8, c + 9, c + 10}) {
    auto& p = mesh.positions[static_cast<std::size_t>(v)];
    const auto& to = mesh.positions[static_cast<std::size_t>(c)];
    if (kind == 0) p = to;
    if (kind == 1) p[1] = to[1];
  }
  if (kind >= 2) {
    const auto a = mesh.positions[1], b = mesh.positions[2];
    const double t = kind == 2 ? share(engine) : 0;
    mesh.positions.push_back({a[0] + t * (b[0] - a[0]), 0, 0});
    mesh.faces.push_back({1, 81, 2});
  }
  if (kind == 3) {
    mesh.positions.push_back(mesh.positions.back());
    mesh.faces.push_back({1, 82, 81});
  }
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(share(engine) * 6, Vec(share(engine), share(engine), 1).normalized())
          .toRotationMatrix();
  const double scale = std::pow(10.0, 6 * share(engine) - 3);
  const Vec shift = 100 * scale * Vec(share(engine), -share(engine), share(engine));
  for (auto& p : mesh.positions) {
    const Vec moved = scale * (turn * Vec(p[0], p[1], p[2])) + shift;
    p = {moved[0], moved[1], moved[2]};
  }
  return mesh;
}

}  // namespace

TEST_CASE("where faces have no area there is a tangent plane, the same for both solvers") {
  for (int kind = 0; kind < 4; ++kind) {
    for (int seed = 0; seed < 3; ++seed) {
      CAPTURE(kind);
      CAPTURE(seed);
      const auto mesh = degenerate_sheet(kind, seed);
      const Surface surface(mesh);
      const ExactLogMapSolver exact(mesh);
      const VectorHeatSolver heat(mesh);
      const VectorHeatSolver plain(mesh, {.intrinsic_delaunay = false});
      const Vec vector = embedded(exact.tangent_basis(0), {0.6, 0.8});
      const auto carried = heat.transport(0, vector);
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        const auto basis = exact.tangent_basis(v);
        CHECK(heat.tangent_basis(v) == basis);
        CHECK(plain.tangent_basis(v) == basis);
        CHECK(basis[0].norm() == gelight::test::approx(1).epsilon(1e-13));
        CHECK(basis[1].norm() == gelight::test::approx(1).epsilon(1e-13));
        CHECK(std::abs(basis[0].dot(basis[1])) < 1e-13);
        CHECK(carried[static_cast<std::size_t>(v)].norm() ==
              gelight::test::approx(1).epsilon(1e-9));
        // Any plane through the edges, where a face tells none; that of the sheet elsewhere.
        const bool has_area =
            std::any_of(surface.corners(v).begin(), surface.corners(v).end(), [&](Index h) {
              const Vec a = surface.position(surface.tip(h)) - surface.position(v);
              const Vec b = surface.position(surface.apex(h)) - surface.position(v);
              return a.cross(b).norm() > 1e-6 * a.norm() * b.norm();
            });
        for (const Index h : surface.corners(v)) {
          const Vec edge = surface.position(surface.tip(h)) - surface.position(v);
          if (kind == 1 && has_area) continue;  // folded over
          CHECK(std::abs(edge.dot(basis[0].cross(basis[1]))) <= 1e-3 * edge.norm());
        }
      }
    }
  }
}
