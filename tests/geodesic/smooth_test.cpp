#include "gelight/geodesic/smooth.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"
#include "support/scan_meshes.hpp"
#include "support/smooth_surfaces.hpp"

using namespace gelight;
using test::mean_error;
using test::Random;

namespace {

static_assert(DistanceSolver<SmoothDistanceSolver<double>, double>);
static_assert(DistanceSolver<SmoothDistanceSolver<float>, float>);

using Normals = std::span<const std::array<double, 3>>;

Vec3<double> place(const Mesh<double>& mesh, std::size_t v) {
  const auto& [x, y, z] = mesh.positions[v];
  return {x, y, z};
}

double great_circle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(cross(a, b).norm(), a.dot(b));
}

double share(const std::vector<SmoothTrust>& trust, SmoothTrust of) {
  return static_cast<double>(std::ranges::count(trust, of)) / static_cast<double>(trust.size());
}

Mesh<double> radially_noisy(Mesh<double> sphere, double noise, unsigned seed) {
  Random random(seed);
  for (auto& p : sphere.positions) {
    const double radius = 1 + noise * std::normal_distribution<double>()(random);
    for (double& x : p) x *= radius;
  }
  return sphere;
}

template <class T>
Mesh<T> moved(const Mesh<double>& mesh, double by) {
  Mesh<T> out;
  out.faces = mesh.faces;
  for (const auto& [x, y, z] : mesh.positions) {
    out.positions.push_back({T(x + by), T(y + by), T(z + by)});
  }
  return out;
}

// Of coordinates that are multiples of a power of two, so that nothing is rounded by the move.
template <class T>
void check_that_a_move_changes_nothing(const Mesh<double>& smooth, double by) {
  const double unit = 4 * (std::nextafter(T(by), std::numeric_limits<T>::infinity()) - T(by));
  Mesh<double> mesh = smooth;
  for (auto& p : mesh.positions) {
    for (double& x : p) x = std::round(x * 4096) * unit;
  }
  const auto here = SmoothDistanceSolver(moved<T>(mesh, 0)).solve(3);
  const auto there = SmoothDistanceSolver(moved<T>(mesh, double(T(by)))).solve(3);
  CHECK(there.distance == here.distance);
  CHECK(there.trust == here.trust);
}

// However far coordinates are rounded: no path is shorter than the straight line through space.
template <class T>
void check_straight_lines(const Mesh<T>& mesh) {
  const auto distance = SmoothDistanceSolver(mesh).distance(0);
  Index shorter = 0;
  for (std::size_t v = 0; v < distance.size(); ++v) {
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double way = double(mesh.positions[v][k]) - double(mesh.positions[0][k]);
      square += way * way;
    }
    shorter += !(distance[v] >= std::sqrt(square) * (1 - 4 * std::numeric_limits<T>::epsilon()));
  }
  CHECK(shorter == 0);
}

}  // namespace

TEST_CASE("spheroids from a pole: hundreds of times nearer than the mesh, of higher order") {
  Random random(4);
  for (const double height : {1.0, 0.5, 3.0}) {
    for (const double jitter : {0.0, 0.2}) {
      CAPTURE(height);
      CAPTURE(jitter);
      double given_before = 0, fitted_before = 0;
      for (const int level : {3, 4}) {
        const test::SmoothCase c = test::spheroid(level, height, jitter, random);
        const double mesh = mean_error(ExactSolver(c.mesh).distance(0), c.truth);
        const double given =
            mean_error(SmoothDistanceSolver(c.mesh, Normals(c.normals)).distance(0), c.truth);
        const double fitted = mean_error(SmoothDistanceSolver(c.mesh).distance(0), c.truth);
        CHECK(given < mesh / (level == 3 ? 100 : 400));
        CHECK(fitted < mesh / (level == 3 ? 25 : 400));
        if (level == 4) {
          CHECK(given < given_before / std::pow(2, 3.5));
          CHECK(fitted < fitted_before / std::pow(2, 3));
        }
        given_before = given;
        fitted_before = fitted;
      }
    }
  }
}

TEST_CASE("a torus, against geodesics integrated on it") {
  Random random(6);
  const auto c = test::jittered_torus(72, 36, 0.25, random);
  const ExactField<double> field = ExactSolver(c.mesh).solve(0);
  const std::vector<double> truth = test::torus_distances(c, field, 23);
  REQUIRE(std::ranges::count_if(truth, [](double d) { return d > 0; }) > 20);
  const double mesh = mean_error(field.distances(), truth);
  CHECK(mean_error(SmoothDistanceSolver(c.mesh, Normals(c.normals)).distance(0), truth) <
        mesh / 200);
  CHECK(mean_error(SmoothDistanceSolver(c.mesh).distance(0), truth) < mesh / 100);
}

TEST_CASE("sources and queries anywhere on a sphere; paths and directions") {
  Random random(8);
  const test::SmoothCase c = test::spheroid(4, 1, 0.2, random);
  const SmoothDistanceSolver solver(c.mesh, Normals(c.normals));
  for (int i = 0; i < 6; ++i) {
    const Index f = test::uniform_index(random, static_cast<Index>(c.mesh.faces.size()));
    const double a = test::uniform(random, 0, 0.5), b = test::uniform(random, 0, 0.5);
    const auto& corners = c.mesh.faces[static_cast<std::size_t>(f)];
    const std::vector<Source<double>> sources{
        {i % 2 == 0 ? face_point<double>(f, {a, b, 1 - a - b})
                    : edge_point<double>(corners[0], corners[1], a),
         0.3},
        {vertex_point<double>(test::uniform_index(random, 2562)), 0.4}};
    const auto solved = solver.solve(std::span<const Source<double>>(sources));
    std::array<Vec3<double>, 2> from{solver.position(sources[0].point),
                                     solver.position(sources[1].point)};
    for (auto& p : from) {
      CHECK(std::abs(p.norm() - 1) < 1e-6);
      p.normalize();
    }
    for (std::size_t v = 0; v < solved.distance.size(); v += 7) {
      CAPTURE(v);
      const Vec3<double> p = place(c.mesh, v);
      const double one = 0.3 + great_circle(from[0], p), two = 0.4 + great_circle(from[1], p);
      const double truth = std::min(one, two);
      // The mesh errs by 6e-4 of the distance; about the antipode Newton's step by 2e-6.
      CHECK(std::abs(solved.distance[v] - truth) < 4e-6);
      const auto vertex = static_cast<Index>(v);
      const SmoothPath<double> path = solver.path(solved, vertex);
      if (truth > 2 || path.positions.size() < 2 || solved.trust[v] != SmoothTrust::smooth)
        continue;
      const Vec3<double>& q = from[one < two ? 0 : 1];
      const Vec3<double> tangent = (p * p.dot(q) - q).normalized();
      CHECK((solved.direction[v] - tangent).norm() < 2e-3);
      CHECK(path.length == gelight::test::approx(truth - (one < two ? 0.3 : 0.4)).epsilon(1e-5));
      const Vec3<double> across = cross(q, p).normalized();
      for (const Vec3<double>& r : path.positions) {
        CHECK(std::abs(r.norm() - 1) < 2e-4);
        CHECK(std::abs(r.dot(across)) < 5e-4);  // a 150th of an edge
      }
    }
  }
}

TEST_CASE("a cylinder's rim is a crease and stays one; its sides become round") {
  constexpr Index around = 48, up = 16, rings = 7;
  std::vector<ProfilePoint<double>> profile;
  for (Index i = 0; i <= rings; ++i) profile.push_back({double(i) / rings, -1});
  for (Index i = 1; i <= up; ++i) profile.push_back({1, -1 + 2.0 * i / up});
  for (Index i = rings; i-- > 0;) profile.push_back({double(i) / rings, 1});
  const auto mesh = revolve<double>(profile, 2 * std::numbers::pi / around);
  Index source = 0;
  while (std::abs(place(mesh, std::size_t(source))[2]) > 1e-9 ||
         std::hypot(place(mesh, std::size_t(source))[0], place(mesh, std::size_t(source))[1]) <
             0.99)
    ++source;
  const Vec3<double> s = place(mesh, std::size_t(source));
  std::vector<double> truth(mesh.positions.size(), -1);
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const Vec3<double> p = place(mesh, v);
    const double angle = std::abs(
        std::remainder(std::atan2(p[1], p[0]) - std::atan2(s[1], s[0]), 2 * std::numbers::pi));
    const double r = std::hypot(p[0], p[1]);
    if (r > 1 - 1e-9) {
      if (angle < 1.2) truth[v] = std::hypot(angle, p[2]);  // a helix
      continue;
    }
    if (angle > 0.6 || r < 0.3) continue;
    // Over the rim, at the angle where that is shortest.
    double low = -1, high = 1;
    const auto over = [&](double t) {
      return std::hypot(t, 1) +
             std::hypot(std::cos(t) - r * std::cos(angle), std::sin(t) - r * std::sin(angle));
    };
    for (int i = 0; i < 100; ++i) {
      const double a = low + (high - low) / 3, b = high - (high - low) / 3;
      (over(a) < over(b) ? high : low) = over(a) < over(b) ? b : a;
    }
    truth[v] = over(low);
  }
  truth[std::size_t(source)] = 0;
  const double on_mesh = mean_error(ExactSolver(mesh).distance(source), truth);
  CHECK(mean_error(SmoothDistanceSolver(mesh).distance(source), truth) < on_mesh / 50);
  CHECK(SmoothDistanceSolver(mesh).normals(source).size() == 1);
}

TEST_CASE("what is flat or has creases everywhere is as exact as the mesh") {
  Random random(3);
  for (const auto& mesh : {box<double>(1, 2, 3), test::jittered_grid(12, 0.25, random)}) {
    const auto exact = ExactSolver(mesh).distance(1);
    const auto smooth = SmoothDistanceSolver(mesh).solve(1);
    for (std::size_t v = 0; v < exact.size(); ++v) {
      CHECK(smooth.distance[v] == gelight::test::approx(exact[v]).epsilon(1e-12));
      CHECK(smooth.trust[v] != SmoothTrust::rough);
    }
  }
  // As creases are given, so they are found.
  const auto sphere = icosphere<double>(3);
  SmoothOptions<double> options;
  for (const auto& [a, b, c] : sphere.faces) {
    options.creases.insert(options.creases.end(), {{a, b}, {b, c}, {c, a}});
  }
  const auto exact = ExactSolver(sphere).distance(5);
  const auto all_creases = SmoothDistanceSolver(sphere, options).distance(5);
  for (std::size_t v = 0; v < exact.size(); ++v) {
    // Faces stay flat, and edges are curved along the ridge between their planes: straight.
    CHECK(all_creases[v] == gelight::test::approx(exact[v]).epsilon(1e-12));
  }
}

TEST_CASE("noise: never worse than the mesh by more than a tenth, and it says so") {
  for (const double height : {1.0, 0.5, 3.0}) {
    for (const double noise : {0.001, 0.01, 0.03, 0.1, 0.3}) {
      CAPTURE(height);
      CAPTURE(noise);
      Random random(11);
      test::SmoothCase c = test::spheroid(4, height, 0.2, random);
      c.mesh = test::scans::noisy(c.mesh, noise, random);
      const auto exact = ExactSolver(c.mesh).distance(0);
      const auto smooth = SmoothDistanceSolver(c.mesh).solve(0);
      const double on_mesh = mean_error(exact, c.truth);
      CHECK(mean_error(smooth.distance, c.truth) < 1.1 * on_mesh);
      std::size_t rough = 0;
      for (std::size_t v = 0; v < exact.size(); ++v) {
        if (smooth.trust[v] != SmoothTrust::rough) continue;
        ++rough;
        CHECK(smooth.distance[v] == exact[v]);
      }
      if (noise < 0.01) CHECK(rough == 0);
      if (noise >= 0.1) CHECK(rough > exact.size() * 8 / 10);
    }
  }
}

TEST_CASE("noise that looks like creases is none, and paths over it are rough") {
  for (const int level : {3, 4}) {
    for (const double noise : {0.04, 0.08, 0.16}) {
      CAPTURE(level);
      CAPTURE(noise);
      std::vector<SmoothTrust> trust;
      for (const unsigned seed : {5u, 6u, 7u}) {
        const SmoothDistanceSolver solver(radially_noisy(icosphere<double>(level), noise, seed));
        for (const Index source : {5, 70, 500}) {
          const auto solved = solver.solve(source);
          trust.insert(trust.end(), solved.trust.begin(), solved.trust.end());
        }
      }
      CHECK(share(trust, SmoothTrust::smooth) < 0.01);
      CHECK(share(trust, SmoothTrust::rough) > 0.97);
    }
  }
}

TEST_CASE("noise on one side of a sphere is rough, the other side smooth") {
  const auto sphere = icosphere<double>(4);
  for (const double noise : {0.02, 0.04, 0.08}) {
    CAPTURE(noise);
    auto mesh = radially_noisy(sphere, noise, 3);
    std::vector<std::size_t> smooth, noisy;  // farther from the border than a path there bends
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      if (sphere.positions[v][2] > 0) mesh.positions[v] = sphere.positions[v];
      if (sphere.positions[v][2] > 0.3) smooth.push_back(v);
      if (sphere.positions[v][2] < -0.3) noisy.push_back(v);
    }
    const auto solved = SmoothDistanceSolver(mesh).solve(static_cast<Index>(smooth[0]));
    for (const std::size_t v : smooth) {
      CHECK(solved.trust[v] == SmoothTrust::smooth);
      CHECK(std::abs(solved.distance[v] - great_circle(place(mesh, smooth[0]), place(mesh, v))) <
            1e-5);
    }
    const auto rough = std::ranges::count_if(
        noisy, [&](std::size_t v) { return solved.trust[v] == SmoothTrust::rough; });
    CHECK(static_cast<double>(rough) > 0.97 * static_cast<double>(noisy.size()));
  }
}

TEST_CASE("creases of coarse surfaces stay creases, and creases that are given, in noise") {
  for (const Index around : {9, 12, 24, 48}) {
    CAPTURE(around);
    // With a chamfer, which meets the cap and the side at 45 degrees, at one end.
    const std::vector<ProfilePoint<double>> profile{{0, -1}, {0.5, -1}, {1, -1}, {1, -.3}, {1, .3},
                                                    {1, .8}, {.8, 1},   {.4, 1}, {0, 1}};
    const auto mesh = revolve<double>(profile, 2 * std::numbers::pi / around);
    const SmoothDistanceSolver solver(mesh);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3<double> p = place(mesh, v);
      const double r = std::hypot(p[0], p[1]);
      const bool is_rim = r > 0.99 && p[2] < -0.99;
      const bool is_chamfers = (r > 0.99 && p[2] > 0.75) || (r > 0.75 && p[2] > 0.99);
      // A coarse chamfer's faces lean, so that they turn by less than 45 degrees.
      if (is_chamfers && around < 24) continue;
      CHECK(solver.normals(static_cast<Index>(v)).size() == (is_rim || is_chamfers ? 2 : 1));
    }
  }

  // Stairs, of which each step has an edge up and one down.
  auto stairs = grid<double>(12, 4, 12, 4);
  for (auto& [x, y, z] : stairs.positions) {
    const double half = std::floor(x / 2);
    z = half + std::max(x - 2 * half - 1, 0.0);
    x = half + std::min(x - 2 * half, 1.0);
  }
  const auto exact = ExactSolver(stairs).distance(0);
  const auto on_stairs = SmoothDistanceSolver(stairs).solve(0);
  CHECK(share(on_stairs.trust, SmoothTrust::smooth) == 1);
  for (std::size_t v = 0; v < exact.size(); ++v) {
    CHECK(on_stairs.distance[v] == gelight::test::approx(exact[v]).epsilon(1e-12));
  }

  const auto noisy = radially_noisy(icosphere<double>(3), 0.1, 4);
  SmoothOptions<double> options;
  for (const auto& [a, b, c] : noisy.faces) {
    options.creases.insert(options.creases.end(), {{a, b}, {b, c}, {c, a}});
  }
  const SmoothDistanceSolver all_creases(noisy, options);
  for (Index v = 0; v < 642; ++v) {
    CHECK(std::ssize(all_creases.normals(v)) == std::ssize(all_creases.surface().corners(v)));
  }
}

TEST_CASE("half a cylinder that stands on a plane unrolls to a plane") {
  for (const Index half : {9, 12, 24}) {
    CAPTURE(half);
    const double length = std::numbers::pi;
    auto mesh = grid<double>(3 * half, half, 3 * length, length);
    const auto flat = mesh;
    const double first = flat.positions[0][0];
    for (auto& [x, y, z] : mesh.positions) {
      const double arc = x - first - length;
      if (arc <= 0) x = arc - 1;
      if (arc > 0 && arc < length) std::tie(x, z) = std::pair(-std::cos(arc), std::sin(arc));
      if (arc >= length) x = arc - length + 1;
    }
    for (const std::size_t source : {std::size_t{1}, mesh.positions.size() / 2}) {
      const auto solved = SmoothDistanceSolver(mesh).solve(static_cast<Index>(source));
      const auto on_mesh = ExactSolver(mesh).distance(static_cast<Index>(source));
      std::vector<double> truth;
      for (std::size_t v = 0; v < flat.positions.size(); ++v) {
        truth.push_back((place(flat, v) - place(flat, source)).norm());
      }
      CHECK(share(solved.trust, SmoothTrust::rough) == 0);
      CHECK(share(solved.trust, SmoothTrust::smooth) > 0.85);
      CHECK(mean_error(solved.distance, truth) < mean_error(on_mesh, truth) / 12);
    }
  }
}

TEST_CASE("a path is as long as its distance says, rough or smooth, and runs where it says") {
  for (const double noise : {0.0, 0.03, 0.1, 0.3}) {
    Random random(12);
    test::SmoothCase c = test::spheroid(3, 0.5, 0.2, random);
    c.mesh = test::scans::noisy(c.mesh, noise, random);
    const SmoothDistanceSolver solver(c.mesh);
    for (const double start : {0.0, 2.0, -2.0}) {
      const Source<double> source{face_point<double>(11, {0.2, 0.5, 0.3}), start};
      const auto solved = solver.solve(std::span<const Source<double>>(&source, 1));
      Index rough = 0;
      for (Index v = 0; v < std::ssize(c.mesh.positions); ++v) {
        const auto path = solver.path(solved, v);
        const auto i = static_cast<std::size_t>(v);
        CHECK(start + path.length ==
              gelight::test::approx(solved.distance[i]).epsilon(1e-12).scale(1));
        if (path.trust != SmoothTrust::rough) continue;
        ++rough;
        double chords = 0;
        for (std::size_t k = 1; k < path.positions.size(); ++k) {
          chords += (path.positions[k] - path.positions[k - 1]).norm();
        }
        CHECK(chords == gelight::test::approx(path.length).epsilon(1e-12));
      }
      CHECK((rough > 0) == (noise > 0.02));
    }
  }
}

TEST_CASE("a path's positions are on the surface, and lines between them about as long as it") {
  // The positions of a path that is bent beside a vertex do not turn back there.
  for (const std::array<double, 3> axes : {std::array<double, 3>{1, 1, 1},
                                           {1, 1, 0.6},
                                           {1, 0.7, 0.5},
                                           {1, 1, 2},
                                           {1, 0.5, 0.3},
                                           {1, 1, 0.3}}) {
    Mesh<double> mesh = icosphere<double>(3);
    std::vector<std::array<double, 3>> normals;
    for (auto& p : mesh.positions) {
      Vec3<double> normal;
      for (std::size_t k = 0; k < 3; ++k) {
        normal[static_cast<Eigen::Index>(k)] = p[k] / axes[k];
        p[k] *= axes[k];
      }
      normal.normalize();
      normals.push_back({normal[0], normal[1], normal[2]});
    }
    const SmoothDistanceSolver<double> solver(mesh,
                                              std::span<const std::array<double, 3>>(normals));
    for (const Index source : {0, 5, 400}) {
      const auto solved = solver.solve(source);
      double most = 0, off = 0, sum = 0;
      for (Index v = 0; v < std::ssize(mesh.positions); ++v) {
        const auto path = solver.path(solved, v);
        if (path.positions.size() < 2 || path.trust != SmoothTrust::smooth) continue;
        CHECK(path.positions.size() == path.on_mesh.size());
        double chords = 0;
        for (std::size_t k = 1; k < path.positions.size(); ++k) {
          chords += (path.positions[k] - path.positions[k - 1]).norm();
        }
        most = std::max(most, chords / path.length - 1);
        sum += std::abs(chords / path.length - 1);
        for (const auto& p : path.positions) {
          const Vec3<double> unit(p[0] / axes[0], p[1] / axes[1], p[2] / axes[2]);
          off = std::max(off, std::abs(unit.norm() - 1));
        }
      }
      CHECK(most < 0.01);
      CHECK(sum < 1e-3 * static_cast<double>(mesh.positions.size()));
      CHECK(off < 1e-3);
    }
  }
}

TEST_CASE("scale, float, parts, cancelling and the mesh's orientation") {
  Random random(2);
  const test::SmoothCase c = test::spheroid(3, 0.5, 0.2, random);
  const auto once = SmoothDistanceSolver(c.mesh, Normals(c.normals)).distance(7);
  for (const double scale : {1e-6, 1e6}) {
    Mesh<double> mesh = c.mesh;
    for (auto& p : mesh.positions) {
      for (double& x : p) x *= scale;
    }
    const auto scaled = SmoothDistanceSolver(mesh, Normals(c.normals)).distance(7);
    for (std::size_t v = 0; v < once.size(); ++v) {
      CHECK(scaled[v] == gelight::test::approx(scale * once[v]).epsilon(1e-9));
    }
  }
  Mesh<double> flipped = c.mesh;
  for (auto& f : flipped.faces) std::swap(f[0], f[1]);
  const auto inside_out = SmoothDistanceSolver(flipped, Normals(c.normals)).distance(7);
  for (std::size_t v = 0; v < once.size(); ++v) {
    CHECK(inside_out[v] == gelight::test::approx(once[v]).epsilon(1e-6));
  }
  const auto narrow = SmoothDistanceSolver(icosphere<float>(4)).distance(0);
  const auto sphere = icosphere<float>(4);
  for (std::size_t v = 0; v < narrow.size(); ++v) {
    const auto& [x, y, z] = sphere.positions[v];
    const auto& [a, b, d] = sphere.positions[0];
    CHECK(narrow[v] == gelight::test::approx(great_circle({x, y, z}, {a, b, d})).epsilon(3e-6));
  }
  const auto parts = joined<double>(std::vector<Mesh<double>>{c.mesh, box<double>(1, 1, 1)});
  const auto solved = SmoothDistanceSolver(parts).solve(0);
  CHECK(std::isinf(solved.distance.back()));
  CHECK(solved.direction.back().isZero(0));

  SmoothOptions<double> options;
  bool stop = false;
  options.cancelled = [&stop] { return stop; };
  const SmoothDistanceSolver solver(c.mesh, options);
  std::vector<double> out(once.size(), -1);
  stop = true;
  CHECK_THROWS_AS(solver.distance_into(out, 0), Cancelled);
  CHECK(out == std::vector<double>(once.size(), -1));
  stop = false;
  CHECK(solver.distance(0) == SmoothDistanceSolver(c.mesh).distance(0));
}

TEST_CASE("far from the origin nothing is lost but what rounding of the coordinates loses") {
  Random random(9);
  const Mesh<double> meshes[] = {test::spheroid(3, 0.5, 0.2, random).mesh,
                                 test::jittered_torus(60, 30, 0.2, random).mesh,
                                 test::jittered_grid(12, 0.25, random)};
  for (const Mesh<double>& mesh : meshes) {
    for (const double offset : {1e3, 1e5, 1e7, 1e9, 1e11, 1e13, 1e14, 1e15}) {
      CAPTURE(offset);
      check_that_a_move_changes_nothing<double>(mesh, offset);
      check_that_a_move_changes_nothing<float>(mesh, offset);
      check_straight_lines(moved<double>(mesh, offset));
      check_straight_lines(moved<float>(mesh, offset));
    }
  }
}

TEST_CASE(
    "every mesh of a scanner's kind is answered, and no longer than along its edges' curves") {
  for (const test::NamedMesh& named : test::scan_meshes(2)) {
    CAPTURE(named.name);
    const Mesh<double>& mesh = named.mesh;
    const auto exact = ExactSolver(mesh).distance(0);
    const auto smooth = SmoothDistanceSolver(mesh).solve(0);
    for (std::size_t v = 0; v < exact.size(); ++v) {
      CHECK(std::isfinite(smooth.distance[v]) == std::isfinite(exact[v]));
      if (!std::isfinite(exact[v])) continue;
      CHECK(smooth.distance[v] < 1.5 * exact[v] + 1e-12);
      CHECK(smooth.distance[v] > 0.7 * exact[v] - 1e-12);
    }
  }
}

TEST_CASE("bad input") {
  using test::refusal;
  Random random(2);
  const test::SmoothCase c = test::spheroid(2, 1, 0, random);
  auto normals = c.normals;
  normals.pop_back();
  CHECK_THROWS_AS(SmoothDistanceSolver(c.mesh, Normals(normals)), InvalidInput);
  normals = c.normals;
  normals[17] = {0, 0, 2};
  CHECK_THROWS_AS(SmoothDistanceSolver(c.mesh, Normals(normals)), InvalidInput);
  normals[17] = {std::numeric_limits<double>::quiet_NaN(), 0, 1};
  CHECK_THROWS_AS(SmoothDistanceSolver(c.mesh, Normals(normals)), InvalidInput);
  normals = c.normals;
  for (double& x : normals[17]) x = -x;
  CHECK_THROWS_WITH_AS(
      SmoothDistanceSolver(c.mesh, Normals(normals)),
      "the normal of vertex 17 points to the other side of its faces than those of most vertices",
      InvalidInput);
  CHECK_THROWS_AS(SmoothDistanceSolver(c.mesh, SmoothOptions<double>{.crease_angle = 0}),
                  InvalidInput);
  CHECK_THROWS_AS(SmoothDistanceSolver(c.mesh, SmoothOptions<double>{.creases = {{0, 1}}}),
                  InvalidInput);
  const SmoothDistanceSolver solver(c.mesh);
  CHECK_THROWS_AS((void)solver.distance(-1), InvalidInput);
  CHECK_THROWS_AS((void)solver.distance(std::span<const Index>()), InvalidInput);
}

TEST_CASE(
    "a path by distances on another mesh is refused, by those on an equal one it is the same") {
  const SmoothDistanceSolver solver(icosphere<double>(2)), equal(icosphere<double>(2));
  const auto own = solver.path(solver.solve(3), 100);
  const auto same = solver.path(equal.solve(3), 100);
  CHECK(same.length == own.length);
  CHECK(same.on_mesh == own.on_mesh);
  for (const auto& mesh : {icosphere<double>(1), icosphere<double>(3), icosphere<double>(2, 1.5),
                           grid<double>(8, 17)}) {
    const auto distances = SmoothDistanceSolver(mesh).solve(0);
    CHECK(test::contains(test::refusal([&] { (void)solver.path(distances, 7); }),
                         "the distances were made of another mesh"));
  }
}

TEST_CASE("no smooth distance is below its start by rounding") {
  // 1 and 3 lie at one place. The way from the one to the other crosses 0-2 where both are.
  const Mesh<double> mesh{
      {{-0.025, 0.05, 0}, {-0.0125, 0.05, 0}, {0.0125, 0.05, 0}, {-0.0125, 0.05, 0}},
      {{0, 1, 2}, {0, 2, 3}}};
  const auto distance = SmoothDistanceSolver(mesh).solve(1).distance;
  CHECK(distance[3] >= 0);
  CHECK(distance[3] < 1e-16);
}
