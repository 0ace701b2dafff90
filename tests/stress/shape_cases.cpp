#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"
#include "support/round_corners.hpp"
#include "support/unfolding_oracle.hpp"

// Rows 1 to 16: exactness and the shape of triangles.

namespace gelight::stress {

namespace {

using test::Random;

std::vector<Problem> random_diagonals(Precision) {
  std::vector<Problem> problems;
  Random random(1);
  for (const Index n : {4, 5, 7, 10, 20, 40}) {
    problems.push_back(flat("N = " + std::to_string(n), test::random_grid(n, random), from(0)));
  }
  return problems;
}

std::vector<Problem> jittered(Precision) {
  std::vector<Problem> problems;
  Random random(2);
  for (const double share : {0.05, 0.2}) {
    const auto mesh = test::jittered_grid(30, share, random);
    problems.push_back(flat("jitter " + std::to_string(share).substr(0, 4), mesh, from(0)));
    problems.push_back(flat("from the middle", mesh, from(31 * 15 + 15)));
  }
  return problems;
}

std::vector<Problem> cones(const std::vector<double>& angles, Index spokes) {
  const std::vector<double> radii{0.5, 1, 1.5, 2, 2.5, 3};
  std::vector<Problem> problems;
  for (const double angle : angles) {
    for (const std::size_t ring : {std::size_t{1}, std::size_t{5}}) {
      Problem problem{
          "angle " + std::to_string(angle).substr(0, 3) + ", ring " + std::to_string(ring),
          test::cone(angle, spokes, radii), from(1 + spokes * static_cast<Index>(ring))};
      problem.truth.push_back(radii[ring]);
      for (const double r : radii) {
        for (Index j = 0; j < spokes; ++j) {
          problem.truth.push_back(test::cone_distance(angle, radii[ring], r, j * angle / spokes));
        }
      }
      problems.push_back(std::move(problem));
    }
  }
  return problems;
}

// An open prism of `sides` faces round the z axis; vertex sides k + j is at height k.
std::vector<Problem> prisms(Precision) {
  std::vector<Problem> problems;
  for (const Index sides : {6, 16}) {
    const double radius = 2, side = 2 * radius * std::sin(pi / sides);
    const Index rings = 12;
    Problem problem{std::to_string(sides) + " sides", {}, from(0)};
    for (Index k = 0; k < rings; ++k) {
      for (Index j = 0; j < sides; ++j) {
        const double turn = 2 * pi * j / sides;
        problem.mesh.positions.push_back(
            {radius * std::cos(turn), radius * std::sin(turn), side * k});
        problem.truth.push_back(side * std::hypot(std::min(j, sides - j), k));
        if (k == 0) continue;
        const Index a = sides * (k - 1) + j, b = sides * (k - 1) + (j + 1) % sides;
        problem.mesh.faces.push_back({a, b, b + sides});
        problem.mesh.faces.push_back({a, b + sides, a + sides});
      }
    }
    problems.push_back(std::move(problem));
  }
  return problems;
}

using test::Point2, test::round_corners;

// Whether a segment passes through the inside of an axis-aligned box.
bool passes(const Point2& a, const Point2& b, const Point2& low, const Point2& high) {
  double enter = 0, leave = 1;
  for (std::size_t c = 0; c < 2; ++c) {
    const double d = b[c] - a[c];
    if (d == 0) {
      if (a[c] <= low[c] || a[c] >= high[c]) return false;
      continue;
    }
    const double s = (low[c] - a[c]) / d, t = (high[c] - a[c]) / d;
    enter = std::max(enter, std::min(s, t));
    leave = std::min(leave, std::max(s, t));
  }
  return enter < leave - 1e-12;
}

void drop_unused(Problem& problem) {
  std::vector<char> used(problem.mesh.positions.size(), 0);
  for (const auto& face : problem.mesh.faces) {
    for (const Index v : face) used[static_cast<std::size_t>(v)] = 1;
  }
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) problem.truth[v] = unreachable<double>;
  }
}

std::vector<Problem> rooms(Precision) {
  Random random(6);
  std::vector<Problem> problems;
  const Index n = 12;
  const Point2 low{4, 4}, high{8, 13};  // of the U's gap; an L's is one of its corners
  const auto box = [&](std::string name, const Point2& a, const Point2& b,
                       const std::vector<Point2>& corners, Index source) {
    Problem problem{std::move(name),
                    test::sheet_with_hole(n, random,
                                          [&](double x, double y) {
                                            return x > a[0] && x < b[0] && y > a[1] && y < b[1];
                                          }),
                    from(source)};
    const auto at = problem.mesh.position(source);
    problem.truth =
        round_corners(problem.mesh, {at[0], at[1]}, corners,
                      [&](const Point2& p, const Point2& q) { return !passes(p, q, a, b); });
    drop_unused(problem);
    problems.push_back(std::move(problem));
  };
  box("L", {6, 6}, {13, 13}, {{6, 6}}, 13 * 12 + 1);
  box("U", low, high, {{4, 4}, {8, 4}}, 13 * 12 + 2);
  box("a hole", {4, 4}, {8, 8}, {{4, 4}, {8, 4}, {4, 8}, {8, 8}}, 13 * 6);

  Problem slit{"a slit", test::slit_sheet(n, random), from(13 * 10 + 3)};
  const auto at = slit.mesh.position(13 * 10 + 3);
  slit.truth =
      round_corners(slit.mesh, {at[0], at[1]}, {{6, 6}}, [&](const Point2& p, const Point2& q) {
        if ((p[0] - 6) * (q[0] - 6) >= 0) return true;
        const double share = (6 - p[0]) / (q[0] - p[0]);
        return p[1] + share * (q[1] - p[1]) <= 6;
      });
  // On the slit both copies lie at x = 6: those of the far side are beyond the corner.
  for (std::size_t v = 13 * 13; v < slit.truth.size(); ++v) {
    const auto& p = slit.mesh.positions[v];
    slit.truth[v] = std::hypot(at[0] - 6, at[1] - 6) + (p[1] - 6);
  }
  problems.push_back(std::move(slit));
  return problems;
}

// From a corner of a box the farthest corner is where the shortest unfolding puts it.
std::vector<Problem> boxes(Precision) {
  std::vector<Problem> problems;
  for (const auto& [x, y, z] :
       {std::array{1.0, 1.0, 1.0}, std::array{1.0, 2.0, 3.0}, std::array{0.1, 1.0, 1.0}}) {
    Problem problem{"", box<double>(x, y, z), from(0)};
    problem.truth.assign(8, nan);
    problem.truth[0] = 0;
    problem.truth[1] = x, problem.truth[2] = y, problem.truth[4] = z;
    problem.truth[3] = std::hypot(x, y), problem.truth[5] = std::hypot(x, z);
    problem.truth[6] = std::hypot(y, z);
    problem.truth[7] = std::min({std::hypot(x, y + z), std::hypot(y, x + z), std::hypot(z, x + y)});
    problem.name = "box, opposite corner " + std::to_string(problem.truth[7]).substr(0, 4);
    problems.push_back(std::move(problem));
  }
  return problems;
}

std::vector<Problem> spheres(Precision) {
  std::vector<Problem> problems;
  for (int level = 2; level <= 4; ++level) {
    Problem problem{"level " + std::to_string(level), icosphere<double>(level), from(0)};
    const Vec3<double> pole(problem.mesh.positions[0].data());
    for (const auto& p : problem.mesh.positions) {
      const Vec3<double> q(p.data());
      problem.truth.push_back(std::atan2(cross<double>(pole, q).norm(), pole.dot(q)));
    }
    problems.push_back(std::move(problem));
  }
  return problems;
}

// The mean error of exact polyhedral distance is that of the polyhedron: 0.10 (edge / radius)^2.
void sphere_order(Findings& findings, Precision) {
  std::vector<double> mean;
  for (int level = 3; level <= 5; ++level) {
    const auto mesh = icosphere<double>(level);
    const auto distance = ExactSolver(mesh).distance(Index{0});
    const Vec3<double> pole(mesh.positions[0].data());
    double sum = 0;
    for (std::size_t v = 1; v < distance.size(); ++v) {
      const Vec3<double> q(mesh.positions[v].data());
      const double truth = std::atan2(cross<double>(pole, q).norm(), pole.dot(q));
      sum += std::fabs(distance[v] - truth) / truth;
    }
    mean.push_back(sum / static_cast<double>(distance.size() - 1));
    if (mean.size() < 2) continue;
    const double order = std::log2(mean[mean.size() - 2] / mean.back());
    findings.expect(order >= 1.9,
                    "order " + std::to_string(order) + " at level " + std::to_string(level));
  }
}

std::vector<Problem> stretched(const std::vector<double>& factors) {
  std::vector<Problem> problems;
  Random random(9);
  for (const double factor : factors) {
    auto mesh = test::jittered_grid(16, 0.2, random);
    for (auto& p : mesh.positions) p[0] *= factor;
    std::string name = "stretched " + std::to_string(factor).substr(0, 5);
    problems.push_back(flat(name, mesh, from(17 * 8 + 8)));
    problems.back().slack = factor;
    problems.push_back(flat(name + ", from a corner", mesh, from(0)));
    problems.back().slack = factor;
  }
  return problems;
}

// Faces without area along the border and inside: the sheet is still the sheet.
std::vector<Problem> caps(Precision) {
  Random random(11);
  auto mesh = test::random_grid(8, random);
  // On the border: a vertex in the middle of an edge, joined to it by a face without area.
  mesh.faces.push_back({0, static_cast<Index>(mesh.positions.size()), 1});
  mesh.positions.push_back({0.5, 0, 0});
  // Inside: an edge of two faces becomes a face without area; one of the two is halved.
  const auto face = mesh.faces[70];
  const Index middle = static_cast<Index>(mesh.positions.size());
  const auto p = mesh.position(face[0]), q = mesh.position(face[1]);
  mesh.positions.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, 0});
  mesh.faces[70] = {face[0], middle, face[2]};
  mesh.faces.push_back({middle, face[1], face[2]});
  mesh.faces.push_back({face[0], face[1], middle});
  return {flat("from a corner", mesh, from(0)), flat("from the cap", mesh, from(middle)),
          flat("from beside it", mesh, from(face[2]))};
}

// A vertex of a sheet drawn apart into two at one place, joined by an edge of no length.
std::vector<Problem> zero_edges(Precision) {
  Random random(12);
  auto mesh = test::random_grid(8, random);
  const Index v = 9 * 4 + 4, twin = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back(mesh.position(v));
  for (auto& face : mesh.faces) {
    double y = 0;
    for (const Index w : face) y += mesh.position(w)[1] / 3;
    if (y > 4) std::replace(face.begin(), face.end(), v, twin);
  }
  mesh.faces.push_back({v - 1, v, twin});
  mesh.faces.push_back({v, v + 1, twin});
  return {flat("from a corner", mesh, from(0)), flat("from the edge", mesh, from(twin))};
}

Mesh<double> fan(Index spokes) {
  Mesh<double> mesh{{{0, 0, 0}}, {}};
  for (Index k = 0; k < spokes; ++k) {
    const double turn = 2 * pi * k / spokes;
    mesh.positions.push_back({std::cos(turn), std::sin(turn), 0});
    mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % spokes});
  }
  return mesh;
}

std::vector<Problem> fans(Precision) {
  return {flat("from the hub", fan(10000), from(0)), flat("from the rim", fan(10000), from(1))};
}

void fan_time(Findings& findings, Precision precision) {
  // Rounded to float, 30,000 spokes are no fan any more.
  if (precision == Precision::in_float) return;
  // Quadratic in the valence, the larger would take a hundred times longer; linear, ten times, and
  // several times that where only the smaller fits into a cache. A limit between tells them apart
  // and is no statement of speed.
  for (const Method& method : methods()) {
    std::array<double, 2> seconds{};
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
      const auto mesh = fan(i == 0 ? 3000 : 30000);
      seconds[i] = 1e9;
      for (int round = 0; round < 3; ++round) {
        // The processor's time: other programs at work do not count.
        const std::clock_t start = std::clock();
        (void)method.make(mesh, precision)->distance(from(1));
        seconds[i] =
            std::min(seconds[i], static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
      }
    }
    findings.expect(seconds[1] < 60 * seconds[0] + 0.1,
                    method.name + " takes " + std::to_string(seconds[0]) + " s for 3,000 spokes, " +
                        std::to_string(seconds[1]) + " s for ten times as many");
  }
}

// Cells that grow from one side to the other until they are 1e4 times longer.
std::vector<Problem> graded(Precision) {
  const Index n = 40;
  Mesh<double> mesh = grid<double>(n, n, n, n);
  std::vector<double> at{0};
  for (Index i = 0; i < n; ++i) at.push_back(at.back() + std::pow(1e4, double(i) / (n - 1)));
  for (auto& [x, y, z] : mesh.positions) {
    x = at[static_cast<std::size_t>(x)];
    y = at[static_cast<std::size_t>(y)];
  }
  std::vector<Problem> problems{flat("from the fine corner", mesh, from(0)),
                                flat("from the coarse corner", mesh, from(41 * 41 - 1))};
  for (Problem& problem : problems) problem.slack = 1e4;  // cells as thin as that lie on two sides
  return problems;
}

std::vector<Problem> few_triangles(Precision) {
  const Mesh<double> one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const Mesh<double> two{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 3}, {1, 2, 3}}};
  return {flat("one triangle", one, from(0)), flat("two, over their edge", two, from(0)),
          flat("two, from an edge", two, {{edge_point(1, 3, 0.25), 0}})};
}

std::vector<Problem> strips(Precision) {
  std::vector<Problem> problems;
  for (const Index n : {300, 1000, 10000}) {
    Problem problem = flat("2 x " + std::to_string(n), grid<double>(n, 1, n, 1), from(0));
    problem.float_rounding = 1e-6;
    problems.push_back(std::move(problem));
  }
  return problems;
}

}  // namespace

// Bounds of approximations are half as much again as was measured; a claim of "exact" is for
// rounding alone.
std::vector<Case> shape_cases() {
  std::vector<Case> cases;
  cases.push_back({"1", "regular grid, random diagonals, corner source, N = 4..40",
                   "edges alone turn at 45 degrees", random_diagonals});
  cases.push_back({"2", "jittered grid", "edges alone turn at 45 degrees", jittered});
  cases.push_back(
      {"3", "cone of total angle 1, 3, 5", "rounding of the spokes' positions", [](Precision) {
         return cones({1, 3, 5}, 12);
       }});
  cases.push_back({"4", "open prism of 6 and 16 sides", "edges alone turn at 45 degrees", prisms});
  cases.push_back({"5", "saddle cone of angle 7 and 9",
                   "rounding of the spokes' positions; heat smooths over the apex", [](Precision) {
                     return cones({7, 9}, 16);
                   }});
  cases.push_back({"6", "L, U, a hole, a slit", "marching solvers round the corners", rooms});
  cases.push_back({"7", "cube and boxes, corner to corner",
                   "so small that heat's exact part reaches everywhere", boxes});
  cases.push_back({"8", "icosphere levels 2-4 against great circles",
                   "exact: the polyhedron's own error, 0.10 (edge / radius)² on average", spheres,
                   "exact converges with order >= 1.9", sphere_order});
  cases.push_back(
      {"9", "needles: jittered grid stretched 1e2, 1e3, 1e4",
       "rounding grows with the aspect ratio; heat on the mesh as it is loses its way in needles",
       [](Precision) {
         return stretched({1e2, 1e3, 1e4});
       }});
  cases.push_back({"10", "the same stretched 2 to 100",
                   "fast marching forgoes ways that are shorter by less than 1e-5 to 3e-4; heat on "
                   "the mesh as it is loses its way in needles",
                   [](Precision) {
                     return stretched({2, 5, 10, 30, 100});
                   }});
  cases.push_back({"11", "faces without area, on the border and inside",
                   "fast marching lengthens such a face's edges by 1e-8", caps});
  cases.push_back(
      {"12", "an edge of no length", "rounding; edges alone turn at 45 degrees", zero_edges});
  cases.push_back({"13", "fan of 10,000 spokes",
                   "rounding grows with the aspect ratio, about 1,600; fast marching forgoes up to "
                   "3e-4 in each of 10,000 steps",
                   fans, "time linear in the valence", fan_time});
  cases.push_back({"14", "graded grid, edges 1 to 1e4",
                   "heat's time is that of the mean edge, which smooths the fine part", graded});
  cases.push_back(
      {"15", "one and two triangles", "rounding; edges alone turn at 45 degrees", few_triangles});
  cases.push_back({"16", "strip 2 x 300 to 2 x 10,000",
                   "exact: rounding, which sums up over the strip's cells", strips});
  return cases;
}

}  // namespace gelight::stress
