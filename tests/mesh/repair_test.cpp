#include "gelight/mesh/repair.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/seamed_sheet.hpp"

using namespace gelight;
using test::carries_vectors;
using test::is_taken;
using test::seamed_sheet;

namespace {

using Indices = std::vector<Index>;

}  // namespace

TEST_CASE("without options nothing is repaired") {
  Mesh<double> mesh = seamed_sheet();
  mesh.faces.push_back({0, 0, 77});
  mesh.positions[0][0] = std::numeric_limits<double>::infinity();
  const auto same = repair(mesh, {});
  CHECK(same.mesh.positions == mesh.positions);
  CHECK(same.mesh.faces == mesh.faces);
  CHECK(same.welded_vertices + same.dropped_faces + same.turned_faces + same.added_vertices +
            same.dropped_vertices ==
        0);
}

TEST_CASE("welding closes a seam, and paths cross it") {
  const auto welded = repair(seamed_sheet(), {.weld_distance = 0, .drop_unused_vertices = true});
  CHECK(welded.welded_vertices == 3);
  CHECK(welded.dropped_vertices == 3);
  CHECK(welded.dropped_faces == 0);
  CHECK(check(welded.mesh).components == 1);
  CHECK(welded.vertex_of == Indices{0, 1, 2, 3, 4, 5, 7, 9, 11});
  // From (0, 0) to (2, 1): vertex 9 before.
  CHECK(ExactSolver(welded.mesh).distance(Index{0})[7] == gelight::test::approx(std::sqrt(5.0)));
}

namespace {

// How many vertices are no farther than that from an earlier one that stands for itself.
Index welded_by_brute_force(const Mesh<double>& mesh, double near) {
  const auto distance = [&](std::size_t a, std::size_t b) {
    return std::hypot(mesh.positions[a][0] - mesh.positions[b][0],
                      mesh.positions[a][1] - mesh.positions[b][1],
                      mesh.positions[a][2] - mesh.positions[b][2]);
  };
  std::vector<std::size_t> kept;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    bool is_near = false;
    for (const std::size_t w : kept) is_near = is_near || distance(v, w) <= near;
    if (!is_near) kept.push_back(v);
  }
  return static_cast<Index>(mesh.positions.size() - kept.size());
}

}  // namespace

TEST_CASE("welding within a distance takes each vertex to an earlier one near enough") {
  test::Random random(3);
  Mesh<double> mesh;
  for (int i = 0; i < 2000; ++i) {
    mesh.positions.push_back({test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                              test::uniform(random, -0.1, 0.1)});
  }
  mesh.faces.push_back({0, 1, 2});
  CHECK(repair(mesh, {.weld_distance = 0.07}).welded_vertices == welded_by_brute_force(mesh, 0.07));
}

TEST_CASE("welding within distances of a few roundings, or less than one") {
  test::Random random(5);
  constexpr double eps = std::numeric_limits<double>::epsilon();
  for (const double size : {1.0, 1e60}) {
    Mesh<double> mesh;
    for (int i = 0; i < 600; ++i) {
      const auto near_one = [&] {
        return size * (1 + eps * std::floor(test::uniform(random, -4, 4)));
      };
      mesh.positions.push_back({near_one(), near_one(), near_one()});
    }
    mesh.faces.push_back({0, 1, 2});
    for (const double share : {0.1, 0.24, 0.26, 0.49, 0.51, 0.99, 1.01, 1.5, 3.0}) {
      CAPTURE(size);
      CAPTURE(share);
      const double near = share * eps * size;
      const auto welded = repair(mesh, {.drop_unusable_faces = true, .weld_distance = near});
      CHECK(welded.welded_vertices == welded_by_brute_force(mesh, near));
    }
  }
}

TEST_CASE("faces that welding collapses or makes equal go") {
  Mesh<double> mesh = grid<double>(1, 1);
  mesh.positions.insert(mesh.positions.end(), {{0, 0, 0}, {1, 1, 0}});
  mesh.faces.insert(mesh.faces.end(), {{0, 1, 4}, {4, 1, 5}});
  const auto welded = repair(mesh, {.weld_distance = 0});
  CHECK(welded.dropped_faces == 2);
  CHECK(welded.face_of == Indices{0, 1});
  CHECK(check(welded.mesh).is_accepted());
}

TEST_CASE("faces that cannot be used and faces without area go when asked") {
  Mesh<double> mesh = grid<double>(2, 2);
  const auto sound = mesh.faces;
  mesh.positions.push_back({0, std::numeric_limits<double>::quiet_NaN(), 0});
  mesh.faces.insert(mesh.faces.end(),
                    {{0, 1, 11}, {3, 3, 4}, {-1, 0, 1}, {4, 1, 0}, {9, 0, 1}, {0, 1, 2}});
  const auto usable = repair(mesh, {.drop_unusable_faces = true, .drop_unused_vertices = true});
  CHECK(usable.dropped_faces == 5);
  CHECK(usable.dropped_vertices == 1);
  CHECK(is_taken(usable.mesh));
  const auto areas = repair(usable.mesh, {.drop_degenerate_faces = true});
  CHECK(areas.mesh.faces == sound);
}

TEST_CASE("orienting turns faces until those that meet agree") {
  test::Random random(5);
  Mesh<double> mesh = torus<double>(2, 0.7, 12, 9);
  Index turned = 0;
  for (std::size_t f = 1; f < mesh.faces.size(); ++f) {
    if (test::uniform(random, 0, 1) < 0.5) continue;
    std::swap(mesh.faces[f][0], mesh.faces[f][1]);
    ++turned;
  }
  CHECK_FALSE(carries_vectors(mesh));
  const auto oriented = repair(mesh, {.orient = true});
  CHECK(oriented.turned_faces == turned);
  CHECK(carries_vectors(oriented.mesh));

  // A Moebius strip has no orientation: one seam is left, and told.
  Mesh<double> strip;
  for (int i = 0; i < 10; ++i) {
    strip.positions.insert(strip.positions.end(), {{double(i), 0, 0}, {double(i), 1, 0}});
    const Index a = 2 * i, b = a + 1, c = i < 9 ? a + 2 : 1, d = i < 9 ? a + 3 : 0;
    strip.faces.insert(strip.faces.end(), {{a, c, b}, {b, c, d}});
  }
  CHECK(check(repair(strip, {.orient = true}).mesh).misoriented_edges.count == 1);
}

// A Moebius strip of so many rows of squares, whose faces are turned at random.
namespace {

Mesh<double> turned_strip(Index rows, test::Random& random) {
  constexpr Index columns = 24;
  Mesh<double> strip;
  for (Index i = 0; i < columns; ++i) {
    const double angle = 2 * std::numbers::pi * i / columns;
    for (Index j = 0; j <= rows; ++j) {
      const double off = double(j) / rows - 0.5, radius = 2 + off * std::cos(angle / 2);
      strip.positions.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), off * std::sin(angle / 2)});
    }
  }
  const auto at = [&](Index i, Index j) { return i < columns ? i * (rows + 1) + j : rows - j; };
  for (Index i = 0; i < columns; ++i) {
    for (Index j = 0; j < rows; ++j) {
      strip.faces.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      strip.faces.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  for (auto& face : strip.faces) {
    if (test::uniform(random, 0, 1) < 0.5) std::swap(face[0], face[1]);
  }
  return strip;
}

}  // namespace

TEST_CASE("what repair turned once it does not turn again, also where there is no orientation") {
  test::Random random(3);
  for (const Index rows : {1, 2, 3, 8}) {
    CAPTURE(rows);
    const Mesh<double> strip = turned_strip(rows, random);
    const RepairOptions options{.orient = true, .order_in_space = true};
    const auto once = repair(strip, options), again = repair(once.mesh, options);
    CHECK(once.turned_faces > 0);
    CHECK(check(once.mesh).misoriented_edges.count > 0);
    CHECK(again.turned_faces == 0);
    CHECK(again.mesh.faces == once.mesh.faces);
  }
}

TEST_CASE("what is repaired stays as it is when it is repaired again") {
  test::Random random(11);
  for (int i = 0; i < 60; ++i) {
    Mesh<double> mesh = test::small_random_mesh(i, random);
    const auto count = static_cast<Index>(mesh.positions.size());
    for (auto& p : mesh.positions) {
      for (double& x : p) x = i % 3 == 0 ? std::round(x * 2) / 2 : x;  // many at one place
    }
    for (auto& face : mesh.faces) {
      if (test::uniform(random, 0, 1) > (i % 2 == 0 ? 0.05 : 0.5)) continue;
      face[0] = test::uniform_index(random, count + 3) - 1;
      if (i % 4 == 1) face[1] = face[2];
    }
    for (int bits = 0; bits < 256; ++bits) {
      const auto has = [&](int bit) { return (bits >> bit & 1) != 0; };
      RepairOptions options{.drop_unusable_faces = has(0),
                            .drop_degenerate_faces = has(1),
                            .orient = has(2),
                            .split_vertices = has(3),
                            .drop_unused_vertices = has(4),
                            .order_in_space = has(5)};
      if (has(6)) options.weld_distance = has(7) ? 0.3 : 0;
      const bool takes_more = has(6) && (has(3) || (has(7) && (has(4) || has(5))));
      const bool is_promised = (has(6) || !has(7)) && (!takes_more || (has(0) && has(4)));
      if (!is_promised) continue;
      CAPTURE(i);
      CAPTURE(bits);
      const auto once = repair(mesh, options), again = repair(once.mesh, options);
      CHECK(again.mesh.faces == once.mesh.faces);
      CHECK(again.mesh.positions == once.mesh.positions);
    }
  }
}

TEST_CASE("a face is degenerate or not, however it is turned, and not where it is not finite") {
  test::Random random(5);
  Mesh<double> slivers, turned;
  for (Index i = 0; i < 1000; ++i) {
    const auto part = [&](double size) { return test::uniform(random, -size, size); };
    const std::array<double, 3> a{part(1), part(1), part(1)}, b{part(1), part(1), part(1)};
    std::array<double, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = a[k] + 0.3 * (b[k] - a[k]);  // to rounding
    slivers.positions.insert(slivers.positions.end(), {a, b, c});
    slivers.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    turned.faces.push_back({3 * i, 3 * i + 2, 3 * i + 1});
  }
  turned.positions = slivers.positions;
  const RepairOptions options{.drop_degenerate_faces = true, .flat = 3e-17};
  const auto once = repair(slivers, options);
  CHECK(once.dropped_faces > 100);
  CHECK(once.dropped_faces < 900);
  CHECK(repair(turned, options).face_of == once.face_of);

  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Mesh<double> broken{{{0, 0, nan}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}}};
  CHECK(repair(broken, options).dropped_faces == 0);
}

TEST_CASE("copies of a vertex are numbered behind it where vertices are ordered in space") {
  Mesh<double> bows;
  for (Index i = 0; i < 9; ++i) {
    const double x = 3 * i;
    const auto v = static_cast<Index>(bows.positions.size());
    for (const auto& [a, b] : {std::array{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {-1., 0.}, {-1., -1.}})
      bows.positions.push_back({x + a, b, 0});
    bows.faces.insert(bows.faces.end(), {{v, v + 1, v + 2}, {v, v + 3, v + 4}});
  }
  for (const std::optional<double> weld : {std::optional<double>{}, {0.0}}) {
    const auto ordered =
        repair(bows, {.weld_distance = weld, .split_vertices = true, .order_in_space = true});
    CHECK(ordered.added_vertices == 9);
    CHECK(check(ordered.mesh).components == 18);
    int beside = 0;
    for (std::size_t v = 1; v < ordered.vertex_of.size(); ++v) {
      beside += ordered.vertex_of[v] == ordered.vertex_of[v - 1];
    }
    CHECK(beside == 9);
  }
}

TEST_CASE("splitting parts the fans of a vertex, and a fin from its surface") {
  const Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  const auto parted = repair(bow, {.split_vertices = true});
  CHECK(parted.added_vertices == 1);
  CHECK(parted.vertex_of == Indices{0, 1, 2, 3, 4, 0});
  CHECK(check(parted.mesh).components == 2);
  CHECK(check(parted.mesh).nonmanifold_vertices.count == 0);

  Mesh<double> fin = icosphere<double>(1);
  const auto [a, b, c] = fin.faces[7];
  fin.faces.push_back({a, b, static_cast<Index>(fin.positions.size())});
  fin.positions.push_back({2, 2, 2});
  const auto cut = repair(fin, {.split_vertices = true});
  CHECK(cut.added_vertices == 2);
  CHECK(check(cut.mesh).is_oriented());
  CHECK(check(cut.mesh).components == 2);
}

TEST_CASE("all repairs together make of any random mesh one that carries vectors or says why not") {
  test::Random random(11);
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    Mesh<double> mesh = test::small_random_mesh(i, random);
    const auto count = static_cast<Index>(mesh.positions.size());
    for (auto& face : mesh.faces) {
      if (test::uniform(random, 0, 1) > (i % 2 == 0 ? 0.05 : 0.5)) continue;
      face[0] = test::uniform_index(random, count + 3) - 1;
      if (i % 4 == 1) face[1] = face[2];
    }
    const auto mended = repair(mesh, {.drop_unusable_faces = true,
                                      .weld_distance = 0,
                                      .drop_degenerate_faces = true,
                                      .orient = true,
                                      .split_vertices = true,
                                      .drop_unused_vertices = true,
                                      .order_in_space = i % 2 == 0});
    const MeshReport report = check(mended.mesh);
    CHECK(report.is_accepted());
    CHECK(report.degenerate_faces.count == 0);
    CHECK(report.unused_vertices.count == 0);
    CHECK(report.nonmanifold_vertices.count == 0);
    for (std::size_t v = 0; v < mended.vertex_of.size(); ++v) {
      CHECK(mended.mesh.positions[v] ==
            mesh.positions[static_cast<std::size_t>(mended.vertex_of[v])]);
    }
  }
}

namespace {

/// The same mesh with its vertices and faces in another order.
Mesh<double> shuffled(const Mesh<double>& mesh, unsigned seed) {
  test::Random random(seed);
  const auto count = mesh.positions.size();
  Indices now(count);
  std::iota(now.begin(), now.end(), 0);
  for (std::size_t v = count; v > 1; --v) {
    std::swap(now[v - 1],
              now[static_cast<std::size_t>(test::uniform_index(random, static_cast<Index>(v)))]);
  }
  Mesh<double> result = mesh;
  for (std::size_t v = 0; v < count; ++v) {
    result.positions[static_cast<std::size_t>(now[v])] = mesh.positions[v];
  }
  for (auto& face : result.faces) {
    for (Index& v : face) v = now[static_cast<std::size_t>(v)];
  }
  for (std::size_t f = result.faces.size(); f > 1; --f) {
    std::swap(
        result.faces[f - 1],
        result.faces[static_cast<std::size_t>(test::uniform_index(random, static_cast<Index>(f)))]);
  }
  return result;
}

/// How far apart the ends of the mean edge are numbered.
double mean_step(const Mesh<double>& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.faces) {
    sum += std::abs(a - b) + std::abs(b - c) + std::abs(c - a);
  }
  return sum / (3 * static_cast<double>(mesh.faces.size()));
}

/// Whether a mesh has the vertices and faces of another, each once, as its maps say.
bool is_renumbered(const Repaired<double>& now, const Mesh<double>& before) {
  std::set<Index> vertices(now.vertex_of.begin(), now.vertex_of.end());
  std::set<Index> faces(now.face_of.begin(), now.face_of.end());
  bool is_same = vertices.size() == before.positions.size() &&
                 now.vertex_of.size() == before.positions.size() &&
                 now.mesh.positions.size() == before.positions.size() &&
                 faces.size() == before.faces.size() && now.face_of.size() == before.faces.size() &&
                 now.mesh.faces.size() == before.faces.size();
  for (std::size_t v = 0; is_same && v < now.vertex_of.size(); ++v) {
    const auto& was = before.position(now.vertex_of[v]);
    is_same = std::memcmp(&now.mesh.positions[v], &was, sizeof was) == 0;  // NaN is NaN
  }
  for (std::size_t f = 0; is_same && f < now.face_of.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = now.mesh.faces[f][k];
      const Index was = before.face(now.face_of[f])[k];
      const bool is_vertex = was >= 0 && was < static_cast<Index>(before.positions.size());
      is_same &= (is_vertex ? now.vertex_of[static_cast<std::size_t>(v)] : v) == was;
    }
  }
  return is_same;
}

}  // namespace

TEST_CASE("order in space depends on places alone, and keeps neighbours together") {
  const auto ball = icosphere<double>(5, 1);
  const auto first = shuffled(ball, 1), second = shuffled(ball, 2);
  const auto a = repair(first, {.order_in_space = true});
  const auto b = repair(second, {.order_in_space = true});
  CHECK(is_renumbered(a, first));
  CHECK(is_renumbered(b, second));
  CHECK(a.mesh.positions == b.mesh.positions);
  // Numbers of neighbours differ by a third of all at random; along a line of rows they would by
  // some square root.
  const auto count = static_cast<double>(ball.positions.size());
  CHECK(mean_step(first) > 0.3 * count);
  CHECK(mean_step(a.mesh) < 2 * std::sqrt(count));
  CHECK(a.dropped_faces + a.dropped_vertices + a.turned_faces + a.welded_vertices == 0);
  // The surface is the same.
  const auto before = ExactSolver(first).distance(a.vertex_of[17]);
  const auto after = ExactSolver(a.mesh).distance(Index{17});
  for (std::size_t v = 0; v < after.size(); ++v) {
    const double was = before[static_cast<std::size_t>(a.vertex_of[v])];
    CHECK(std::abs(after[v] - was) <= 1e-12 * was);
  }
}

TEST_CASE("any places can be ordered, and faces with indices out of range") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const double large = std::numeric_limits<double>::max();
  const double small = std::numeric_limits<double>::denorm_min();
  const std::vector<Mesh<double>> meshes{
      {},
      {{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{2, 1, 0}}},
      {{{nan, 0, 0}, {1, 0, 0}, {0, -infinity, 0}, {0, 0, 0}}, {{3, 2, 1}, {0, 1, 3}}},
      {{{large, 0, 0}, {-large, 0, 0}, {0, large, -large}, {0, 0, 0}}, {{0, 1, 2}, {1, 2, 3}}},
      {{{small, 0, 0}, {-small, 0, 0}, {0, small, 0}}, {{0, 1, 2}}},
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 99}, {-5, 2, 1}, {2, 1, 0}}},
  };
  for (const auto& mesh : meshes) {
    const auto now = repair(mesh, {.order_in_space = true});
    CHECK(is_renumbered(now, mesh));
    // What has no place is behind what has.
    bool was_placed = true;
    for (const auto& p : now.mesh.positions) {
      const bool is_placed = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
      CHECK((was_placed || !is_placed));
      was_placed = is_placed;
    }
  }
}

TEST_CASE("an index out of range is none of the vertices that splitting adds") {
  Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                   {{0, 1, 2}, {0, 3, 4}, {1, 2, 5}, {1, 2, 9}}};
  const auto parted = repair(bow, {.split_vertices = true});
  CHECK(parted.added_vertices == 1);
  CHECK(parted.mesh.faces[2] == std::array<Index, 3>{1, 2, 6});
  CHECK(parted.mesh.faces[3] == std::array<Index, 3>{1, 2, 9});
  CHECK(check(parted.mesh).out_of_range.count == 2);
  CHECK(!is_taken(parted.mesh));
}

TEST_CASE("a weld distance or flatness that cannot be is refused") {
  const Mesh<double> mesh = grid<double>(1, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS((void)repair(mesh, {.weld_distance = -1}), "the weld distance is -1",
                       InvalidInput);
  CHECK_THROWS_AS((void)repair(mesh, {.weld_distance = nan}), InvalidInput);
  CHECK_THROWS_AS((void)repair(mesh, {.flat = nan}), InvalidInput);
}

TEST_CASE("a repair can be followed and cancelled") {
  const auto mesh = gelight::icosphere(2, 1.0);
  const gelight::RepairOptions options{.weld_distance = 0, .orient = true};
  double done = 0;
  Index asked = 0;
  const auto repaired = gelight::repair(mesh, options, [&](double share) {
    CHECK(share >= done);
    done = share;
    ++asked;
    return false;
  });
  CHECK(repaired.mesh.faces == mesh.faces);
  CHECK(done == 1);
  for (Index end = 1; end <= asked; ++end) {
    Index left = end;
    CHECK_THROWS_AS((void)gelight::repair(mesh, options, [&] { return --left == 0; }),
                    gelight::Cancelled);
    CHECK(left == 0);
  }
}
