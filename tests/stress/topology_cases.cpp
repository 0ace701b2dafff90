#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/shapes.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"
#include "support/round_corners.hpp"
#include "support/unfolding_oracle.hpp"

// Rows 17 to 35: topology, broken input, sources, scale.

namespace gelight::stress {

namespace {

using test::Random;

Mesh<double> moved(Mesh<double> mesh, double x, double y, double z) {
  return placed<double>(std::move(mesh), Eigen::Matrix3d::Identity(), {x, y, z});
}

std::vector<Problem> strays(Precision) {
  Random random(17);
  Problem problem = flat("a vertex in no face", test::jittered_grid(8, 0.2, random), from(0));
  problem.mesh.positions.push_back({4, 4, 0});
  problem.truth.push_back(inf);
  return {problem};
}

std::vector<Problem> parts(Precision) {
  Random random(18);
  const auto sheet = test::jittered_grid(8, 0.2, random);
  const std::vector<Mesh<double>> two{sheet, moved(sheet, 0, 0, 1)};
  Problem one_lit{"a source in one part", joined<double>(two), from(0)};
  one_lit.truth = euclidean(sheet, one_lit.sources);
  one_lit.truth.resize(2 * one_lit.truth.size(), inf);
  Problem both_lit = one_lit;
  both_lit.name = "in both";
  both_lit.sources.push_back({vertex_point<double>(81 + 40), 0.5});
  for (std::size_t v = 81; v < 162; ++v) {
    both_lit.truth[v] = 0.5 + gap(both_lit.mesh.positions[v], both_lit.mesh.positions[81 + 40]);
  }
  return {one_lit, both_lit};
}

// Two sheets side by side whose common side is doubled: nothing crosses.
Mesh<double> seamed() {
  const std::vector<Mesh<double>> two{grid<double>(4, 8, 4, 8),
                                      moved(grid<double>(4, 8, 4, 8), 4, 0, 0)};
  return joined<double>(two);
}

std::vector<Problem> seams(Precision) {
  Problem open{"as it is", seamed(), from(0)};
  open.truth = euclidean(open.mesh, open.sources);
  std::fill(open.truth.begin() + 45, open.truth.end(), inf);
  auto mended = repair(open.mesh, {.weld_distance = 0, .drop_unused_vertices = true}).mesh;
  return {open, flat("welded", std::move(mended), from(0))};
}

void seam_is_named(Findings& findings, Precision) {
  const auto report = check(seamed());
  findings.expect(report.duplicate_vertices.count == 9 && report.components == 2,
                  "the seam's 9 vertices are not named");
}

// Sheets that share one side, like the pages of a book: any two of them unfold to one sheet.
std::vector<Problem> books(Precision) {
  std::vector<Problem> problems;
  for (const int pages : {3, 5}) {
    const Index n = 8;
    Mesh<double> mesh;
    std::vector<double> along;  // distance from the spine
    std::vector<int> page_of;
    for (int page = 0; page < pages; ++page) {
      const auto sheet = grid<double>(n, n, n, n);
      std::vector<Index> now;
      const double turn = 2 * pi * page / pages + 0.3;
      for (const auto& [x, y, z] : sheet.positions) {
        if (x == 0 && page > 0) {
          now.push_back(static_cast<Index>(y) * (n + 1));
          continue;
        }
        now.push_back(static_cast<Index>(mesh.positions.size()));
        mesh.positions.push_back({x * std::cos(turn), x * std::sin(turn), y});
        along.push_back(x);
        page_of.push_back(page);
      }
      for (const auto& face : sheet.faces) {
        mesh.faces.push_back({now[static_cast<std::size_t>(face[0])],
                              now[static_cast<std::size_t>(face[1])],
                              now[static_cast<std::size_t>(face[2])]});
      }
    }
    Problem problem{std::to_string(pages) + " pages", mesh, from(13)};
    for (std::size_t v = 0; v < along.size(); ++v) {
      const bool is_same = page_of[v] == 0;
      const double across = is_same ? along[v] - along[13] : along[v] + along[13];
      problem.truth.push_back(std::hypot(across, mesh.positions[v][2] - mesh.positions[13][2]));
    }
    problems.push_back(std::move(problem));
  }
  return problems;
}

// Two sheets that share a corner.
std::vector<Problem> bow_ties(Precision) {
  const auto sheet = grid<double>(6, 6, 6, 6);
  const std::vector<Mesh<double>> two{sheet, moved(sheet, 6, 6, 0)};
  auto mesh = joined<double>(two);
  const Index corner = 48, twin = 49;
  for (auto& face : mesh.faces) std::replace(face.begin(), face.end(), twin, corner);
  Problem problem{"corner to corner", mesh, from(0)};
  for (std::size_t v = 0; v < 98; ++v) {
    const auto& p = mesh.positions[v];
    const double bend = std::hypot(6, 6);
    problem.truth.push_back(v < 49 ? std::hypot(p[0], p[1])
                                   : bend + std::hypot(p[0] - 6, p[1] - 6));
  }
  problem.truth[twin] = inf;  // in no face any more
  return {problem};
}

Mesh<double> half_turned(Mesh<double> mesh) {
  for (std::size_t f = 0; f < mesh.faces.size(); f += 2) {
    std::swap(mesh.faces[f][0], mesh.faces[f][1]);
  }
  return mesh;
}

std::vector<Problem> turned(Precision) {
  Random random(22);
  return {flat("half the faces", half_turned(test::jittered_grid(12, 0.2, random)), from(14))};
}

// What Surface says of a mesh is what every solver says.
void refuses(Findings& findings, Precision precision, const Mesh<double>& mesh,
             const std::string& part) {
  for (const Method& method : methods()) {
    findings.expect_refusal(part, [&] { (void)method.make(mesh, precision); });
  }
  findings.expect(!check(mesh).is_accepted(), "check does not foretell: " + part);
}

void twice(Findings& findings, Precision precision) {
  auto mesh = grid<double>(2, 2);
  mesh.faces[5] = {1, 1, 4};
  refuses(findings, precision, mesh, "face 5 has a vertex twice: (1, 1, 4)");
  mesh = grid<double>(2, 2);
  mesh.faces.push_back({4, 0, 1});
  refuses(findings, precision, mesh, "have the same three vertices");
}

void out_of_range(Findings& findings, Precision precision) {
  auto mesh = grid<double>(2, 2);
  mesh.faces[3][1] = 9;
  refuses(findings, precision, mesh, "face 3 has vertex 9, the mesh has vertices 0 to 8");
  mesh.faces[3][1] = -1;
  refuses(findings, precision, mesh, "face 3 has vertex -1");
  mesh.faces[3][1] = std::numeric_limits<Index>::min();
  refuses(findings, precision, mesh, "face 3 has vertex -2147483648");
}

void not_finite(Findings& findings, Precision precision) {
  for (const double bad : {nan, inf, -inf}) {
    auto mesh = grid<double>(2, 2);
    mesh.positions[4][1] = bad;
    refuses(findings, precision, mesh, "vertex 4 has position (");
  }
}

void nothing(Findings& findings, Precision precision) {
  refuses(findings, precision, {}, "the mesh has no vertices");
  refuses(findings, precision, {{{0, 0, 0}}, {}}, "the mesh has no faces");
  const auto mesh = grid<double>(2, 2);
  for (const Method& method : methods()) {
    const auto query = method.make(mesh, precision);
    const auto refused = [&](const std::string& part, const Sources& sources) {
      std::vector<double> out(9, -7);
      findings.expect_refusal(part, [&] { query->distance_into(out, sources); });
      findings.expect(out == std::vector<double>(9, -7), method.name + " wrote before it refused");
    };
    refused("there is no source", {});
    refused("vertex 9 is out of range", from(9));
    refused("vertex -1 is out of range",
            {{vertex_point<double>(0), 0}, {vertex_point<double>(-1), 0}});
    refused("no edge between vertices 0 and 8", {{edge_point(0, 8, 0.5), 0}});
    refused("face 8 is out of range", {{face_point<double>(8, {1, 0, 0}), 0}});
    refused("negative or do not sum to 1", {{face_point<double>(0, {0.5, 0.6, -0.1}), 0}});
    refused("negative or do not sum to 1", {{edge_point(0, 1, nan), 0}});
    refused("starts with distance", {{vertex_point<double>(0), nan}});
    refused("starts with distance", {{vertex_point<double>(0), -inf}});
    std::vector<double> out(8, -7);
    findings.expect_refusal("the output has 8 elements, the mesh 9 vertices",
                            [&] { query->distance_into(out, from(0)); });
    findings.expect(out == std::vector<double>(8, -7), method.name + " wrote before it refused");
  }
}

// A flat torus of x (even) times y cells: folded flat in x, a prism in y, so that every edge has
// the length that it has on the torus. Places coincide where the fold lies upon itself.
Mesh<double> flat_torus(Index nx, Index ny) {
  Mesh<double> mesh;
  const double radius = 0.5 / std::sin(pi / ny);
  for (Index i = 0; i < nx; ++i) {
    for (Index j = 0; j < ny; ++j) {
      const double turn = 2 * pi * j / ny;
      mesh.positions.push_back({radius * std::cos(turn), radius * std::sin(turn),
                                static_cast<double>(std::min(i, nx - i))});
      const Index a = i * ny + j, b = (i + 1) % nx * ny + j;
      const Index c = (i + 1) % nx * ny + (j + 1) % ny, d = i * ny + (j + 1) % ny;
      mesh.faces.push_back({a, b, c});
      mesh.faces.push_back({a, c, d});
    }
  }
  return mesh;
}

std::vector<Problem> tori(Precision) {
  std::vector<Problem> problems;
  for (const auto& [nx, ny] : {std::array<Index, 2>{8, 6}, {12, 5}, {20, 15}}) {
    Problem problem{std::to_string(nx) + " x " + std::to_string(ny), flat_torus(nx, ny), from(0)};
    for (Index i = 0; i < nx; ++i) {
      for (Index j = 0; j < ny; ++j) {
        problem.truth.push_back(std::hypot(std::min(i, nx - i), std::min(j, ny - j)));
      }
    }
    problems.push_back(std::move(problem));
  }
  // Genus 2: two such tori, joined crosswise through a slit of two edges each.
  Problem two{"genus 2", {}, from(9)};
  const auto one = flat_torus(6, 3);
  const std::vector<Mesh<double>> both{one, one};
  two.mesh = joined<double>(both);
  const Index shift = 18, begin = 0, middle = 3, end = 6;
  for (std::size_t f = 0; f < two.mesh.faces.size(); ++f) {
    const bool is_second = f >= 36, is_above = f / 2 % 3 == 0;
    for (Index& v : two.mesh.faces[f]) {
      if (v == begin + shift || v == end + shift) v -= shift;
      // What lies above the slit sees the other torus below it.
      if (is_above && !is_second && v == middle) {
        v += shift;
      } else if (is_above && is_second && v == middle + shift) {
        v -= shift;
      }
    }
  }
  two.truth = test::UnfoldingOracle(two.mesh).distance(two.sources);
  problems.push_back(std::move(two));
  return problems;
}

// A ring of four times as large outer as inner radius, in the plane.
std::vector<Problem> annuli(Precision) {
  const Index around = 48, rings = 12;
  Mesh<double> mesh;
  for (Index k = 0; k <= rings; ++k) {
    const double radius = 1 + 3.0 * k / rings;
    for (Index j = 0; j < around; ++j) {
      const double turn = 2 * pi * (j + 0.5 * k) / around;
      mesh.positions.push_back({radius * std::cos(turn), radius * std::sin(turn), 0});
      if (k == 0) continue;
      const Index a = (k - 1) * around + j, b = (k - 1) * around + (j + 1) % around;
      mesh.faces.push_back({a, b, a + around});
      mesh.faces.push_back({b, b + around, a + around});
    }
  }
  Problem problem{"from the middle ring", mesh, from(6 * around)};
  std::vector<test::Point2> hole;
  for (Index j = 0; j < around; ++j) hole.push_back({mesh.position(j)[0], mesh.position(j)[1]});
  const auto& source = mesh.position(6 * around);
  problem.truth =
      test::round_corners(mesh, {source[0], source[1]}, hole,
                          [&](const auto& p, const auto& q) { return !test::passes(p, q, hole); });
  return {problem};
}

// How far the isolines bend, by distance from the border: mean relative error of each ring.
void border_rings(Findings& findings, Precision precision) {
  const Problem problem = annuli(precision)[0];
  struct Rule {
    HeatBoundary boundary;
    double at_border, inside;
  };
  for (const auto& [boundary, at_border, inside] :
       {Rule{HeatBoundary::neumann, 0.11, 0.11}, Rule{HeatBoundary::dirichlet, 0.19, 0.11},
        Rule{HeatBoundary::averaged, 0.19, 0.11}}) {
    const HeatSolver solver(problem.mesh, HeatOptions{.boundary = boundary});
    const auto distance = solver.distance(std::span<const Source<double>>(problem.sources));
    for (std::size_t ring = 0; ring < 13; ++ring) {
      double sum = 0;
      for (std::size_t v = 48 * ring; v < 48 * (ring + 1); ++v) {
        if (problem.truth[v] > 0) {
          sum += std::fabs(distance[v] - problem.truth[v]) / problem.truth[v] / 48;
        }
      }
      const double most = ring == 0 || ring == 12 ? at_border : inside;
      findings.expect(sum <= most, "ring " + std::to_string(ring) + " of rule " +
                                       std::to_string(static_cast<int>(boundary)) + " is " +
                                       std::to_string(sum) + " off");
    }
  }
}

std::vector<Problem> points(Precision) {
  Random random(29);
  const auto mesh = test::jittered_grid(10, 0.2, random);
  const auto at = [&](std::string name, const SurfacePoint<double>& point) {
    return flat(std::move(name), mesh, {{point, 0}});
  };
  const auto& [a, b, c] = mesh.faces[93];
  return {at("in a face", face_point<double>(93, {0.2, 0.5, 0.3})),
          at("nearly at a corner", face_point<double>(93, {1 - 1e-9, 5e-10, 5e-10})),
          at("on an edge", edge_point(a, b, 0.3)),
          at("on the border", edge_point<double>(4, 5, 0.9)),
          at("a corner, called a face's", face_point<double>(93, {0, 1, 0})),
          at("an edge's end", edge_point(b, c, 1.0))};
}

// From everywhere to a point on a neighbour's own edge, and back.
void symmetric(Findings& findings, Precision) {
  Random random(6681);
  const auto mesh = test::jittered_grid(6, 0.2, random);
  const ExactSolver solver(mesh, {.keep_windows = true});
  for (int i = 0; i < 40; ++i) {
    const auto p = test::random_point(mesh, random), q = test::random_point(mesh, random);
    const double there = solver.solve(p).distance(q), back = solver.solve(q).distance(p);
    const double truth = gap(position(mesh, p), position(mesh, q));
    findings.expect(std::fabs(there - truth) < 1e-13 * 6 && std::fabs(back - truth) < 1e-13 * 6,
                    std::to_string(there) + " there, " + std::to_string(back) + " back, for " +
                        std::to_string(truth));
  }
}

std::vector<Problem> several(Precision) {
  Random random(30);
  const auto mesh = test::jittered_grid(16, 0.2, random);
  Sources border;
  for (Index i = 0; i <= 16; ++i) {
    for (const Index v : {i, 16 * 17 + i, 17 * i, 17 * i + 16}) {
      border.push_back({vertex_point<double>(v), 0});
    }
  }
  // Between the border's vertices the nearest point may lie on an edge: straight to the side.
  Problem sides{"the whole border", mesh, border};
  for (std::size_t i = 0; i < 16; ++i) {
    const auto k = static_cast<Index>(i);
    for (const auto& [a, b] : {std::array{k, k + 1},
                               {16 * 17 + k, 16 * 17 + k + 1},
                               {17 * k, 17 * k + 17},
                               {17 * k + 16, 17 * k + 33}}) {
      for (int s = 1; s < 16; ++s) sides.sources.push_back({edge_point(a, b, s / 16.0), 0});
    }
  }
  sides.truth = euclidean(mesh, sides.sources);
  return {flat("three", mesh,
               {{vertex_point<double>(20), 0},
                {vertex_point<double>(200), 0},
                {vertex_point<double>(280), 0}}),
          sides};
}

std::vector<Problem> starts(Precision) {
  Random random(31);
  const auto mesh = test::jittered_grid(16, 0.2, random);
  return {flat("repeated", mesh,
               {{vertex_point<double>(40), 0},
                {vertex_point<double>(40), 0},
                {vertex_point<double>(40), 1},
                {vertex_point<double>(250), 0}}),
          flat("start distances", mesh,
               {{vertex_point<double>(40), 5},
                {vertex_point<double>(250), 2},
                {face_point<double>(100, {0.25, 0.25, 0.5}), 3.5}}),
          flat("one hidden behind another's", mesh,
               {{vertex_point<double>(40), 0}, {vertex_point<double>(41), 9}})};
}

void repeated_change_nothing(Findings& findings, Precision precision) {
  Random random(31);
  const auto mesh = test::jittered_grid(12, 0.2, random);
  const Sources once{{vertex_point<double>(3), 1}, {vertex_point<double>(99), 0}};
  const Sources more{once[0], once[1], once[0], once[1], once[1]};
  for (const Method& method : methods()) {
    const auto query = method.make(mesh, precision);
    findings.expect(query->distance(once) == query->distance(more),
                    method.name + ": repeated sources change bits");
  }
}

void used_again(Findings& findings, Precision precision) {
  Random random(32);
  const auto mesh = test::jittered_grid(12, 0.2, random);
  for (const Method& method : methods()) {
    const auto used = method.make(mesh, precision);
    (void)used->distance(from(100));
    try {
      (void)used->distance(from(-1));
    } catch (const InvalidInput&) {
      // A refused query must leave no trace either.
    }
    (void)used->distance({{face_point<double>(7, {0.5, 0.25, 0.25}), 2}});
    findings.expect(used->distance(from(5)) == method.make(mesh, precision)->distance(from(5)),
                    method.name + ": a used solver and a fresh one differ");
  }
}

std::vector<Problem> scales(Precision precision) {
  Random random(33);
  const auto mesh = test::jittered_grid(12, 0.2, random);
  std::vector<Problem> problems;
  for (const double scale : {1e-20, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e15}) {
    auto scaled = mesh;
    for (auto& p : scaled.positions) {
      for (double& x : p) x *= scale;
    }
    if (precision == Precision::in_float) scaled = rounded_to_float(scaled);
    problems.push_back(flat("times 1e" + std::to_string(std::lround(std::log10(scale))),
                            std::move(scaled), from(0)));
    problems.back().float_rounding = 1e-6;
  }
  return problems;
}

// Where positions are as coarse as cells can bear, the truth is that of the rounded positions.
std::vector<Problem> far_away(Precision precision) {
  Random random(34);
  const auto mesh = test::jittered_grid(12, 0.2, random);
  std::vector<Problem> problems;
  for (const double away : {1e3, 1e6, 1e8}) {
    const double eps = precision == Precision::in_float
                           ? double{std::numeric_limits<float>::epsilon()}
                           : std::numeric_limits<double>::epsilon();
    const double cell = std::max(1.0, 100 * eps * away);
    auto placed_far = mesh;
    for (auto& p : placed_far.positions) {
      for (double& x : p) x = x * cell + away;
    }
    if (precision == Precision::in_float) placed_far = rounded_to_float(placed_far);
    problems.push_back(flat(std::to_string(std::lround(away)) + " away", placed_far, from(0)));
    problems.back().float_rounding = 1e-6;
  }
  return problems;
}

// On a mesh that is large for a test: what does not lie within the bound is not computed.
void large(Findings& findings, Precision) {
  const auto mesh = icosphere<double>(6);  // 40,962 vertices
  const ExactSolver solver(mesh);
  const auto whole = solver.distance(Index{0});
  const auto disc = solver.solve(Index{0}, {.max_distance = 0.2}).distances();
  const auto target =
      solver.solve(Index{0}, {.targets = {vertex_point<double>(777)}}).distance(Index{777});
  findings.expect(target == whole[777], "a target's distance is not that of the whole solve");
  for (std::size_t v = 0; v < whole.size(); ++v) {
    findings.expect(disc[v] == (whole[v] <= 0.2 ? whole[v] : inf),
                    "within the greatest distance not that of the whole solve");
  }
  int asked = 0;
  bool was_cancelled = false;
  try {
    (void)solver.solve(Index{0}, {.cancelled = [&] { return ++asked == 3; }});
  } catch (const Cancelled&) {
    was_cancelled = true;
  }
  findings.expect(was_cancelled && asked == 3, "not cancelled when asked to");
}

}  // namespace

std::vector<Case> topology_cases() {
  std::vector<Case> cases;
  cases.push_back({"17", "a vertex in no face", "+infinity there", strays});
  cases.push_back({"18", "disconnected parts, in one of them a start distance",
                   "+infinity where no source is", parts});
  cases.push_back({"19", "duplicate vertices along a seam", "+infinity beyond, until welded", seams,
                   "check names the seam, repair welds it", seam_is_named});
  cases.push_back(
      {"20", "three and five sheets on one edge", "heat crosses the spine smoothly", books});
  cases.push_back(
      {"21", "bow-tie: two sheets share a corner", "fast marching rounds the corner", bow_ties});
  cases.push_back({"22", "half the faces flipped", "lengths know no orientation", turned,
                   "vectors refuse by name (row 22 of vectors below)"});
  cases.push_back({"23",
                   "a vertex twice in a face, a face twice",
                   "",
                   {},
                   "all refuse, naming the face",
                   twice,
                   "refuses"});
  cases.push_back({"24",
                   "an index out of range or negative",
                   "",
                   {},
                   "all refuse, naming face and index",
                   out_of_range,
                   "refuses"});
  cases.push_back({"25",
                   "NaN or infinite coordinate",
                   "",
                   {},
                   "all refuse, naming the vertex",
                   not_finite,
                   "refuses"});
  cases.push_back({"26",
                   "an empty mesh, no sources, sources that are not of the mesh",
                   "",
                   {},
                   "all refuse and leave the output as it was",
                   nothing,
                   "refuses"});
  cases.push_back({"27", "flat torus, genus 2",
                   "fast marching where fronts of one source meet; two cone points of 4 pi", tori});
  cases.push_back({"28", "annulus", "heat bends at the border", annuli,
                   "Neumann, Dirichlet, averaged heat: mean error by ring", border_rings});
  cases.push_back({"29", "source on an edge, in a face, on the border",
                   "virtual sources take a shorter way only if it gains 1e-10", points,
                   "exact: symmetric between any two points, also of one edge", symmetric});
  cases.push_back({"30", "several sources; a whole border",
                   "heat and virtual sources where waves of several sources meet", several});
  cases.push_back({"31", "repeated sources, start distances",
                   "heat where waves of several sources meet", starts,
                   "repeated sources change no bit", repeated_change_nothing});
  cases.push_back({"32",
                   "the solver used again, also after a refusal",
                   "",
                   {},
                   "each bitwise equal to a fresh solver",
                   used_again,
                   "holds"});
  cases.push_back({"33", "scale 1e-20 to 1e15", "rounding", scales});
  cases.push_back({"34", "1e3, 1e6, 1e8 from the origin",
                   "the truth is that of the positions as rounded", far_away});
  cases.push_back({"35",
                   "40,962 vertices; a million with `stress_load long`",
                   "",
                   {},
                   "exact: greatest distance, targets and cancelling",
                   large});
  return cases;
}

}  // namespace gelight::stress
