#include "gelight/mesh/check.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/hard_meshes.hpp"
#include "support/seamed_sheet.hpp"

using namespace gelight;
using test::carries_vectors;
using test::is_taken;
using test::seamed_sheet;

namespace {

using Indices = std::vector<Index>;

}  // namespace

TEST_CASE("nothing is wrong with a sphere, and a sheet has but a border") {
  const MeshReport sphere = check(icosphere<double>(1));
  CHECK(sphere.is_oriented());
  CHECK(sphere.vertices == 42);
  CHECK(sphere.faces == 80);
  CHECK(sphere.components == 1);
  std::ostringstream text;
  text << sphere;
  CHECK(text.str() == "42 vertices, 80 faces, 1 components");
  const MeshReport sheet = check(grid<float>(3, 2));
  CHECK(sheet.is_oriented());
  CHECK(sheet.border_edges.count == 10);
}

TEST_CASE("everything that Surface refuses is told at once, with its places") {
  Mesh<double> mesh = grid<double>(2, 2);
  mesh.positions.push_back({0, std::numeric_limits<double>::quiet_NaN(), 0});
  mesh.positions.push_back({std::numeric_limits<double>::infinity(), 0, 0});
  mesh.faces.insert(mesh.faces.end(),
                    {{0, 1, 11}, {3, 3, 4}, {-1, 0, 1}, {4, 1, 0}, {4, 3, 4}, {9, 0, 1}});
  const MeshReport report = check(mesh);
  CHECK_FALSE(report.is_accepted());
  CHECK(report.not_finite.first == Indices{9, 10});
  CHECK(report.out_of_range.first == Indices{8, 10});
  CHECK(report.repeated_vertices.first == Indices{9, 12});
  CHECK(report.repeated_faces.first == Indices{11});
  std::ostringstream text;
  text << report;
  CHECK(text.str().find("\n2 faces with a vertex twice: 9, 12 (refused)") != std::string::npos);
  CHECK_FALSE(check(Mesh<double>{}).is_accepted());
  CHECK_FALSE(check(Mesh<double>{{{0, 0, 0}}, {}}).is_accepted());
}

TEST_CASE("what is too large or too small to be computed with is told as it is refused") {
  Mesh<double> mesh = grid<double>(2, 2);
  mesh.positions[4] = {0, 2e75, 0};
  CHECK(check(mesh).too_far.first == Indices{4});
  CHECK_FALSE(check(mesh).is_accepted());
  CHECK_FALSE(is_taken(mesh));
  for (const double scale : {1e-80, 1e-70, 1e70}) {
    CAPTURE(scale);
    mesh = grid<double>(2, 2, scale, scale);
    CHECK(check(mesh).is_too_small == (scale == 1e-80));
    CHECK(check(mesh).is_accepted() == (scale > 1e-80));
    CHECK(is_taken(mesh) == (scale > 1e-80));
  }
}

TEST_CASE("no more indices than asked for, but all are counted") {
  Mesh<double> mesh = grid<double>(1, 1);
  for (int i = 0; i < 20; ++i) mesh.positions.push_back({1.0 + i, 5, 5});
  CHECK(check(mesh).unused_vertices.count == 20);
  CHECK(check(mesh).unused_vertices.first.size() == 8);
  CHECK(check(mesh, {.listed = 2}).unused_vertices.first == Indices{4, 5});
  CHECK(check(mesh, {.listed = 0}).unused_vertices.first.empty());
}

TEST_CASE("what solvers take is told too: seams, strays, parts, fins, bow-ties, flat faces") {
  const MeshReport seam = check(seamed_sheet());
  CHECK(seam.is_oriented());
  CHECK(seam.components == 2);
  CHECK(seam.duplicate_vertices.first == Indices{6, 8, 10});

  Mesh<double> fin = grid<double>(1, 1);
  fin.positions.push_back({0.5, 0.5, 1});
  fin.faces.push_back({0, 3, 4});
  CHECK(check(fin).nonmanifold_edges.first == Indices{0});
  CHECK_FALSE(check(fin).is_oriented());
  CHECK(check(fin).is_accepted());

  const Mesh<double> bow{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  CHECK(check(bow).nonmanifold_vertices.first == Indices{0});
  CHECK(check(bow).components == 1);

  Mesh<double> turned = grid<double>(1, 1);
  std::swap(turned.faces[1][0], turned.faces[1][1]);
  CHECK(check(turned).misoriented_edges.first == Indices{0});

  Mesh<double> flat = grid<double>(1, 1);
  flat.positions.insert(flat.positions.end(), {{0.5, 0, 0}, {0, 0, 0}});
  flat.faces.insert(flat.faces.end(), {{0, 4, 1}, {0, 2, 5}});
  CHECK(check(flat).degenerate_faces.first == Indices{2, 3});
  CHECK(check(flat).zero_edges.first == Indices{0});
  CHECK(check(flat).duplicate_vertices.first == Indices{5});
}

TEST_CASE("a face is degenerate by its shape, at any scale and place") {
  for (const double scale : {1e-20, 1.0, 1e20}) {
    const Mesh<double> cap{{{0, 0, 0}, {scale, 0, 0}, {scale / 2, 1e-10 * scale, 0}}, {{0, 1, 2}}};
    CHECK(check(cap).degenerate_faces.count == 0);
    CHECK(check(cap, {.flat = 1e-9}).degenerate_faces.count == 1);
  }
}

TEST_CASE("on random meshes the report foretells who refuses") {
  test::Random random(8);
  for (int i = 0; i < 300; ++i) {
    Mesh<double> mesh = test::small_random_mesh(i, random);
    const auto count = static_cast<Index>(mesh.positions.size());
    for (auto& face : mesh.faces) {
      if (test::uniform(random, 0, 1) > 0.02) continue;
      face[static_cast<std::size_t>(test::uniform_index(random, 3))] =
          test::uniform_index(random, count + 1);
    }
    CAPTURE(i);
    const MeshReport report = check(mesh);
    CHECK(report.is_accepted() == is_taken(mesh));
    CHECK(report.is_oriented() == carries_vectors(mesh));
  }
}

// Coordinates that T and 1e75 hold, edges that they may not: shares of the limit in all directions.
template <class T>
void check_near_the_limit() {
  const double limit = std::min(1e75, double{std::numeric_limits<T>::max()});
  test::Random random(31);
  Index refused = 0, taken = 0;
  for (int i = 0; i < 200; ++i) {
    const Mesh<double> drawn = test::small_random_mesh(i, random);
    const double share = test::uniform(random, 0, 1);
    double most = 0;
    for (const auto& p : drawn.positions) {
      for (const double x : p) most = std::max(most, std::abs(x));
    }
    Mesh<T> mesh;
    mesh.faces = drawn.faces;
    for (const auto& p : drawn.positions) {
      auto& q = mesh.positions.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        // Some to the far side, so that edges become twice as long as coordinates.
        const double side = test::uniform(random, 0, 1) < 0.1 ? -1 : 1;
        q[k] = static_cast<T>(side * p[k] / most * share * limit);
      }
    }
    CAPTURE(i);
    CHECK(check(mesh).is_accepted() == is_taken(mesh));
    const auto repaired =
        repair(mesh, {.drop_unusable_faces = true, .drop_unused_vertices = true}).mesh;
    CHECK(check(repaired).too_long.count == 0);
    CHECK((repaired.faces.empty() || is_taken(repaired)));
    // Nothing else went.
    if (is_taken(mesh)) CHECK(repaired.faces.size() == mesh.faces.size());
    ++(is_taken(mesh) ? taken : refused);
  }
  CHECK(taken > 20);
  if (std::is_same_v<T, float>) CHECK(refused > 20);
}

TEST_CASE("an edge longer than its type's largest number is found, and its faces dropped") {
  check_near_the_limit<float>();
  check_near_the_limit<double>();

  const float far = 3e38F;
  const Mesh<float> mesh{{{-far, 0, 0}, {far, 0, 0}, {0, 1, 0}, {0, -1e30F, 0}, {1e30F, 0, 0}},
                         {{0, 1, 2}, {2, 3, 4}}};
  const MeshReport report = check(mesh);
  CHECK(report.too_long.first == Indices{0});
  CHECK_FALSE(report.is_accepted());
  std::ostringstream text;
  text << report;
  CHECK(text.str().find("too long for the coordinates' type: 0 (refused)") != std::string::npos);
  CHECK(repair(mesh, {.drop_unusable_faces = true}).mesh.faces ==
        std::vector<std::array<Index, 3>>{{2, 3, 4}});
}

TEST_CASE("a check can be followed and cancelled") {
  const auto mesh = gelight::icosphere(2, 1.0);
  double done = 0;
  Index asked = 0;
  const auto report = gelight::check(mesh, {}, [&](double share) {
    CHECK(share >= done);
    done = share;
    ++asked;
    return false;
  });
  CHECK(report.faces == 320);
  CHECK(done == 1);
  for (Index end = 1; end <= asked; ++end) {
    Index left = end;
    CHECK_THROWS_AS((void)gelight::check(mesh, {}, [&] { return --left == 0; }),
                    gelight::Cancelled);
    CHECK(left == 0);
  }
}

TEST_CASE("options of a check that mean nothing are refused") {
  const auto mesh = grid<double>(1, 1);
  for (const double flat : {-1e-12, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS((void)check(mesh, {.flat = flat}), InvalidInput);
  }
  CHECK_THROWS_AS((void)check(mesh, {.listed = -1}), InvalidInput);
}
