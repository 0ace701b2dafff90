#include "gelight/geodesic/marching/fan_walk.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/marching/face_list.hpp"
#include "gelight/geodesic/marching/one_ring.hpp"
#include "gelight/mesh/shapes.hpp"

using namespace gelight;

namespace {

// A grid or sphere with faces turned round, left out, and put in between any vertices: borders,
// fins, bow-ties, edges of many faces, faces that are there twice, and strays.
Mesh<double> soup(unsigned seed) {
  std::mt19937 random(seed);
  auto mesh = seed % 2 == 0 ? grid<double>(5, 6, 1.0, 2.0) : icosphere<double>(1);
  const auto below = [&](std::size_t count) { return static_cast<Index>(random() % count); };
  const auto any_face = [&]() -> auto& {
    return mesh.faces[static_cast<std::size_t>(below(mesh.faces.size()))];
  };
  for (auto& face : mesh.faces) {
    if (random() % 5 == 0) std::swap(face[0], face[1]);
  }
  for (int i = below(6); i > 0; --i) mesh.faces.erase(mesh.faces.begin() + below(9));
  for (int i = below(8); i > 0; --i) {
    const Index a = below(7), b = a + 1 + below(4), c = b + 1 + below(4);
    mesh.faces.push_back({b, a, c});
  }
  if (seed % 7 == 0) mesh.faces.push_back({any_face()[1], any_face()[2], any_face()[0]});
  if (seed % 11 == 0) any_face()[1] = seed % 2 == 0 ? -1 : 1000;
  if (seed % 13 == 0) mesh.positions[3][1] = seed % 2 == 0 ? 1e80 : std::nan("");
  for (auto& p : mesh.positions) {
    if (seed % 17 == 0) p = {1, 1, 1};
    if (seed % 19 == 0) p = {1e-78 * p[0], 1e-78 * p[1], 1e-78 * p[2]};
    if (seed % 23 == 0) p = {1e-200 * p[0], 1e-200 * p[1], 1e-200 * p[2]};
  }
  return mesh;
}

std::string refusal_of(const auto& make) {
  try {
    make();
  } catch (const InvalidInput& refusal) {
    return refusal.what();
  }
  return {};
}

using Ring = std::vector<std::pair<Index, Index>>;

}  // namespace

TEST_CASE("fans go round vertices in the order of the one-ring, and see faces that are twice") {
  int sound = 0, twice = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    CAPTURE(seed);
    const auto mesh = soup(seed);
    const auto refusal = refusal_of([&] { (void)Surface(mesh); });
    const bool any_twice = refusal.find("same three vertices") != std::string::npos;
    if (!refusal.empty() && !any_twice) continue;
    const detail::FaceList<double> faces(detail::read_mesh<double>(mesh, {}));
    const auto corners = faces.all_corners();
    const auto rims = faces.all_rims();
    detail::FanWalk fans(faces.vertex_count());
    std::vector<Ring> rings;
    bool is_sound = true;
    for (Index v = 0; v < faces.vertex_count(); ++v) {
      Ring ring;
      is_sound &= fans.visit(v, rims.at(v));
      for (const auto& [end, corner] : fans.steps()) {
        ring.emplace_back(end, corner < 0 ? corner : corners.at(v)[corner]);
      }
      const bool has_twins = faces.has_twins(rims.at(v));
      CHECK(has_twins == faces.has_twins(corners.at(v)));
      is_sound &= !(fans.are_crowded() && has_twins);
      rings.push_back(ring);
    }
    CHECK(is_sound == !any_twice);
    ++(any_twice ? twice : sound);
    if (any_twice) continue;
    const Surface surface(mesh);
    detail::OneRing one_ring(surface);
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      Ring ring;
      one_ring.visit(v, [&](Index edge, Index corner) {
        const bool leaves = surface.origin(edge) == v;
        ring.emplace_back(leaves ? surface.tip(edge) : surface.origin(edge), corner);
      });
      CHECK(rings[static_cast<std::size_t>(v)] == ring);
    }
  }
  CHECK(sound > 300);
  CHECK(twice > 50);
}

TEST_CASE("solvers that make no surface refuse what it refuses, in its words") {
  int refused = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    CAPTURE(seed);
    const auto mesh = soup(seed);
    const auto refusal = refusal_of([&] { (void)Surface(mesh); });
    CHECK(refusal_of([&] { (void)FastMarchingSolver(mesh); }) == refusal);
    CHECK(refusal_of([&] { (void)DijkstraSolver(mesh); }) == refusal);
    refused += !refusal.empty();
    if (!refusal.empty()) continue;
    // Of a surface or without: the same.
    const std::vector<Source<double>> sources{
        {edge_point<double>(mesh.faces[0][0], mesh.faces[0][1], 0.25), 0.5},
        {face_point<double>(2, {0.5, 0.25, 0.25}), -0.25}};
    const FastMarchingSolver without(mesh), with(Surface<double>{mesh});
    CHECK(without.distance(sources) == with.distance(sources));
    CHECK(without.distance(3) == with.distance(3));
  }
  CHECK(refused > 100);
}
