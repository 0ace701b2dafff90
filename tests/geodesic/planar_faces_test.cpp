#include "gelight/geodesic/exact/planar_faces.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact/faces_near.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "support/hard_meshes.hpp"

using namespace gelight;

namespace {

using Faces = detail::PlanarFaces<double>;
using Bend = Faces::Bend;

// How a vertex bends by the sum of its angles, each an arc tangent, where it is no rounding that
// decides.
Bend bend_of(long double sum, bool is_border) {
  const long double flat = (is_border ? 1 : 2) * std::numbers::pi_v<long double>;
  if (!is_border && sum < 1) return Bend::tip;
  return sum > flat ? Bend::saddle : Bend::none;
}

// A fan of so many faces round vertex 0, open or closed, whose ends go up and down.
Mesh<double> fan(int faces, bool is_closed, double turn, double rise, double scale) {
  Mesh<double> mesh;
  mesh.positions.push_back({0, 0, 0});
  const int ends = is_closed ? faces : faces + 1;
  for (int i = 0; i < ends; ++i) {
    const double angle = turn * i / faces, height = i % 2 == 0 ? rise : -rise;
    mesh.positions.push_back({scale * std::cos(angle), scale * std::sin(angle), scale * height});
  }
  for (int i = 0; i < faces; ++i) mesh.faces.push_back({0, 1 + i, 1 + (i + 1) % ends});
  return mesh;
}

}  // namespace

TEST_CASE("angles sum as their arc tangents do") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  int beyond = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    detail::AngleSum<double> sum;
    long double truth = 0;
    const int count = 1 + static_cast<int>(random() % 40);
    // All angles are near 0, a right one or pi in some trials.
    const auto kind = random() % 5;
    for (int i = 0; i < count; ++i) {
      const double size = std::pow(10.0, trial % 2 == 0 ? 0 : 150 * uniform(random) - 75);
      const double off = std::pow(10.0, -16 * uniform(random));
      const double angle = kind == 0   ? off
                           : kind == 1 ? std::numbers::pi - off
                           : kind == 2 ? std::numbers::pi / 2 + off - 0.5
                                       : std::numbers::pi * uniform(random);
      const Vec2<double> side(size * std::cos(angle), size * std::sin(angle));
      sum.add(side);
      truth += std::atan2(static_cast<long double>(side.y()), static_cast<long double>(side.x()));
    }
    const auto half_turns = static_cast<int>(truth / std::numbers::pi_v<long double>);
    const long double rest = truth - half_turns * std::numbers::pi_v<long double>;
    CAPTURE(trial);
    for (const double angle : {1e-11, 0.1, 1.0, 1.5}) {
      if (std::fabs(rest - angle) < 1e-13L || rest < 1e-13L) continue;
      CHECK(sum.exceeds(half_turns, std::tan(angle)) == (rest > angle));
      CHECK(sum.exceeds(half_turns - 1, std::tan(angle)));
      CHECK(!sum.exceeds(half_turns + 1, std::tan(angle)));
      beyond += rest > angle;
    }
  }
  CHECK(beyond > 10000);
}

TEST_CASE("sides at 0 and pi sum to whole half turns") {
  detail::AngleSum<double> sum;
  for (int i = 0; i < 5; ++i) {
    CHECK(!sum.exceeds(i, 1e-11));
    if (i > 0) CHECK(sum.exceeds(i - 1, 1e300));
    sum.add({1, 0});
    sum.add({-2, 0});
  }
  CHECK(!sum.exceeds(5, 1e-11));
}

TEST_CASE("vertices are told apart as the sums of their angles are") {
  int tips = 0, saddles = 0;
  for (const double scale : {1.0, 1e-70, 1e70}) {
    for (int faces = 3; faces < 12; ++faces) {
      for (const bool is_closed : {false, true}) {
        for (const double turn : {2 * std::numbers::pi, 3.3, 2.9}) {
          if (is_closed && turn < 6) continue;
          // Of an odd number, the first and last end of a closed fan are both up.
          for (const double rise : {0.0, 0.05, 0.7, -1.0, 30.0}) {
            auto mesh = fan(faces, is_closed, turn, rise, scale);
            if (is_closed && rise == -1.0) {  // a cone
              for (std::size_t i = 1; i < mesh.positions.size(); ++i)
                mesh.positions[i][2] = 9 * scale;
            }
            const Surface<double> surface(mesh);
            const Faces planar(surface);
            long double sum = 0;
            for (const Index h : surface.corners(0)) sum += planar.angle(h);
            const long double flat = (is_closed ? 2 : 1) * std::numbers::pi_v<long double>;
            if (std::fabs(sum - flat) < 1e-10L) {
              CHECK(planar.bend(0) == Bend::none);
              continue;
            }
            CAPTURE(faces);
            CAPTURE(rise);
            CHECK(planar.bend(0) == bend_of(sum, !is_closed));
            tips += planar.bend(0) == Bend::tip;
            saddles += planar.bend(0) == Bend::saddle;
          }
        }
      }
    }
  }
  CHECK(tips > 10);
  CHECK(saddles > 50);
}

TEST_CASE("two fans at a vertex bend paths, however many faces they have") {
  for (const int faces : {3, 4, 7}) {
    auto mesh = fan(faces, true, 2 * std::numbers::pi, 0.1, 1);
    const auto other = fan(faces + 1, true, 2 * std::numbers::pi, 0.1, 2);
    const auto first = static_cast<Index>(mesh.positions.size()) - 1;
    for (std::size_t i = 1; i < other.positions.size(); ++i) {
      mesh.positions.push_back(other.positions[i]);
      mesh.positions.back()[2] += 1;
    }
    for (auto face : other.faces) mesh.faces.push_back({0, face[1] + first, face[2] + first});
    CHECK(Faces(Surface<double>(mesh)).bend(0) == Bend::any);
    mesh.faces.resize(static_cast<std::size_t>(faces));
    CHECK(Faces(Surface<double>(mesh)).bend(0) != Bend::any);
  }
}

TEST_CASE("near a point nothing differs from where all faces are laid flat") {
  test::Random random(11);
  int compared = 0, left_out = 0;
  for (int seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    auto mesh = test::small_random_mesh(seed % 10, random);
    if (seed % 3 == 0) {
      for (auto& p : mesh.positions) {
        for (double& x : p) x = std::round(4 * x) / 4;
      }
    }
    if (seed % 4 == 0) {
      for (auto& p : mesh.positions) p[2] *= 300;
    }
    const Surface<double> surface(mesh);
    const Faces all(surface);
    Faces some;
    detail::WindowPropagation<double> by_all, by_some;
    // One after the other, for what is laid flat stays so.
    for (int query = 0; query < 6; ++query) {
      detail::PropagationLimits<double> limits;
      limits.distance = all.longest_edge() * std::pow(10, test::uniform(random, -2, 0.5));
      detail::Array<Source<double>> sources;
      for (int k = 0; k <= query % 2; ++k) {
        const auto point = detail::simplified(surface, test::random_point(mesh, random));
        sources.push_back({point, 0});
        some.lay_flat_near(surface, point, limits.distance);
      }
      by_all.run(surface, all, sources, limits);
      by_some.run(surface, some, sources, limits);
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        if (!(by_all.distances[v] <= limits.distance)) {
          CHECK(!(by_some.distances[v] <= limits.distance));
          ++left_out;
          continue;
        }
        CHECK(by_some.distances[v] == by_all.distances[v]);
        ++compared;
      }
    }
  }
  CHECK(compared > 10000);
  CHECK(left_out > 10000);
}

TEST_CASE("faces near a point are few") {
  const auto mesh = icosphere(6, 1.0);
  const Surface<double> surface(mesh);
  detail::FacesNear<double> near;
  const double edge = surface.length(0);
  for (const Index v : {0, 77, 40000}) {
    near.find(surface, vertex_point<double>(v), 3 * edge);
    // A disc of equilateral faces, as wide again by one on either side.
    const double disc = std::numbers::pi * 16 * edge * edge;
    CHECK(static_cast<double>(near.faces().size()) < 1.5 * disc / (std::sqrt(3) / 4 * edge * edge));
    CHECK(static_cast<double>(near.faces().size()) > std::numbers::pi * 9 / (std::sqrt(3) / 4));
  }
}
