#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/tangent.hpp"
#include "stress/kept_meshes.hpp"
#include "stress/shrinking.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"

// Properties of random meshes. MESHES=100000 SEED=7 stress.random_meshes makes a long run; a mesh
// that fails is shrunk to a few triangles and printed, to be kept in kept_meshes.hpp.

using namespace gelight;
using stress::Findings;
using stress::Precision;
using test::Random;
using test::uniform;
using test::uniform_index;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

/// Says what is wrong with what solvers answer on a mesh that Surface takes, or nothing. The source
/// is the first vertex of the first face, so that a mesh can be shrunk without losing it.
using Property = std::function<std::string(const Mesh<double>&)>;

Index source_of(const Mesh<double>& mesh) { return mesh.faces.front()[0]; }
Index other_of(const Mesh<double>& mesh) { return mesh.faces.back()[2]; }
Index third_of(const Mesh<double>& mesh) { return mesh.faces[mesh.faces.size() / 2][1]; }

std::string first_fault(const Findings& findings, const std::string& who) {
  return findings.faults().empty() ? "" : who + ": " + findings.faults().front();
}

double extent(const Mesh<double>& mesh) {
  double most = 0;
  for (const auto& p : mesh.positions) {
    most = std::max(most, stress::gap(p, mesh.position(source_of(mesh))));
  }
  return most;
}

bool differ(double a, double b, double tolerance) {
  return (a == inf) != (b == inf) || (a != inf && !(std::fabs(a - b) <= tolerance));
}

// --- the properties ------------------------------------------------------------------------------

// I1 to I5, of every solver.
std::string keeps_invariants(const Mesh<double>& mesh) {
  for (const auto& method : stress::methods()) {
    const stress::Problem problem{"", mesh, stress::from(source_of(mesh))};
    const auto distance = method.make(mesh, Precision::in_double)->distance(problem.sources);
    Findings findings;
    findings.expect(distance[static_cast<std::size_t>(source_of(mesh))] == 0,
                    "no zero at the source");
    stress::check_invariants(method, problem, distance, Precision::in_double, findings);
    if (const auto fault = first_fault(findings, method.name); !fault.empty()) return fault;
  }
  return "";
}

// I6 and I7, of the solvers that measure paths.
std::string is_a_metric(const Mesh<double>& mesh) {
  for (const auto& method : stress::methods()) {
    if (!method.keeps_edges || !method.keeps_space) continue;
    const auto query = method.make(mesh, Precision::in_double);
    const auto a = static_cast<std::size_t>(source_of(mesh));
    const auto b = static_cast<std::size_t>(other_of(mesh));
    const auto c = static_cast<std::size_t>(third_of(mesh));
    const auto from_a = query->distance(stress::from(source_of(mesh)));
    const auto from_b = query->distance(stress::from(other_of(mesh)));
    const double rounding = 1e-9 * extent(mesh);
    if (differ(from_a[b], from_b[a], rounding)) return method.name + " is not symmetric";
    if (from_a[c] > from_a[b] + from_b[c] + rounding) {
      return method.name + " breaks the triangle inequality";
    }
  }
  return "";
}

// I8: another numbering, other orientations, turned and moved, half the size.
std::string is_intrinsic(const Mesh<double>& mesh) {
  Random random(mesh.faces.size());
  std::vector<Index> now(mesh.positions.size());
  std::iota(now.begin(), now.end(), 0);
  std::shuffle(now.begin(), now.end(), random);
  Mesh<double> other;
  other.positions.resize(now.size());
  for (std::size_t v = 0; v < now.size(); ++v) {
    other.positions[static_cast<std::size_t>(now[v])] = mesh.positions[v];
  }
  for (auto face : mesh.faces) {
    for (Index& v : face) v = now[static_cast<std::size_t>(v)];
    std::rotate(face.begin(), face.begin() + uniform_index(random, 3), face.end());
    if (uniform(random, 0, 1) < 0.5) std::swap(face[0], face[1]);
    other.faces.push_back(face);
  }
  const Index source = now[static_cast<std::size_t>(source_of(mesh))];
  std::shuffle(other.faces.begin(), other.faces.end(), random);
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(1, uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1))
          .normalized()
          .toRotationMatrix();
  const double size = extent(mesh);
  other = placed<double>(other, rotation, Vec3<double>(size, -2 * size, size / 3));
  for (auto& p : other.positions) {
    for (double& x : p) x /= 2;
  }
  const auto before = ExactSolver(mesh).distance(source_of(mesh));
  const auto after = ExactSolver(other).distance(source);
  // Turning rounds positions: needles lose the more of their height.
  const double rounding = 1e-6 * size;
  for (std::size_t v = 0; v < before.size(); ++v) {
    const double there = 2 * after[static_cast<std::size_t>(now[v])];
    if (differ(before[v], there, rounding)) {
      return "the exact distance depends on where and how the mesh lies: " +
             std::to_string(before[v]) + ", " + std::to_string(there);
    }
  }
  return "";
}

// Powers of two as scale change no bit but the exponent, whatever the solver.
std::string scales(const Mesh<double>& mesh) {
  auto half = mesh;
  for (auto& p : half.positions) {
    for (double& x : p) x /= 2;
  }
  for (const auto& method : stress::methods()) {
    const auto before =
        method.make(mesh, Precision::in_double)->distance(stress::from(source_of(mesh)));
    const auto after =
        method.make(half, Precision::in_double)->distance(stress::from(source_of(mesh)));
    for (std::size_t v = 0; v < before.size(); ++v) {
      if (differ(before[v], 2 * after[v], 1e-9 * extent(mesh))) {
        return method.name + " does not scale with the mesh";
      }
    }
  }
  return "";
}

// A path is as long as its distance says, each piece lies in one face, and its ends are right.
std::string has_paths(const Mesh<double>& mesh) {
  const Surface<double> surface(mesh);
  int asked = 0;  // once in 256 vertices: a small mesh that asks on and on does not end
  const auto never_ends = [&] { return ++asked > 1000; };
  const auto field = ExactSolver(surface).solve(source_of(mesh), {.cancelled = never_ends});
  // Of planar coordinates, where two vertices are one place.
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * extent(mesh);
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const double distance = field.distance(v);
    const auto path = field.path(v);
    if (path.empty() != (distance == inf)) return "a path where none leads, or none";
    if (path.empty()) continue;
    if (differ(length(surface, path), distance, 1e-9 * distance + rounding)) {
      return "a path of length " + std::to_string(length(surface, path)) + " for a distance of " +
             std::to_string(distance);
    }
    const auto arrival = field.direction(v);
    if (!arrival.allFinite()) return "a direction that is not finite";
  }
  return "";
}

// Round each face the connection turns a vector by what the face's corners sum to beyond pi, where
// those round a vertex are scaled to a whole turn.
std::string has_holonomy(const Mesh<double>& mesh) {
  if (!check(mesh).is_oriented() || check(mesh, {.flat = 1e-3}).degenerate_faces.count > 0) {
    return "";
  }
  const Surface<double> surface(mesh);
  const TangentFrames<double> frames(surface);
  const auto corner = [&](Index h) {
    const double a = surface.length(h), b = surface.length(Surface<double>::previous(h));
    const double c = surface.length(Surface<double>::next(h));
    return std::acos(std::clamp((a * a + b * b - c * c) / (2 * a * b), -1.0, 1.0));
  };
  const auto scaled_corner = [&](Index h) {
    double sum = 0;
    Index g = h;
    do {
      sum += corner(g);
      const Index before = Surface<double>::previous(g);
      if (surface.is_border(before)) return corner(h);
      g = surface.twin(before);
    } while (g != h);
    return corner(h) * 2 * std::numbers::pi / sum;
  };
  for (Index f = 0; f < surface.face_count(); ++f) {
    std::complex<double> round = 1;
    double angles = -std::numbers::pi;
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      round *= frames.transport(h);
      angles += scaled_corner(h);
    }
    const double off = std::min(std::abs(round - std::polar(1.0, angles)),
                                std::abs(round - std::polar(1.0, -angles)));
    if (!(off < 1e-6)) return "round face " + std::to_string(f) + " a vector turns otherwise";
  }
  return "";
}

// An exception is a fault too, and where memory runs out a loop that does not end.
Property guarded(const Property& property) {
  return [property](const Mesh<double>& mesh) -> std::string {
    try {
      return property(mesh);
    } catch (const std::exception& error) {
      return std::string("an exception: ") + error.what();
    }
  };
}

struct Named {
  std::string name;
  Property property;
};
const std::vector<Named>& properties() {
  static const std::vector<Named> all{
      {"paths", guarded(has_paths)},    {"invariants", guarded(keeps_invariants)},
      {"metric", guarded(is_a_metric)}, {"intrinsic", guarded(is_intrinsic)},
      {"scale", guarded(scales)},       {"holonomy", guarded(has_holonomy)}};
  return all;
}

// --- random meshes -------------------------------------------------------------------------------

Mesh<double> random_mesh(Random& random) {
  Mesh<double> mesh = test::small_random_mesh(uniform_index(random, 10), random);
  const auto happens = [&](double chance) { return uniform(random, 0, 1) < chance; };
  const auto random_face = [&]() -> std::size_t {
    return static_cast<std::size_t>(uniform_index(random, static_cast<Index>(mesh.faces.size())));
  };
  if (happens(0.2)) {  // another part
    const std::vector<Mesh<double>> two{mesh,
                                        test::small_random_mesh(uniform_index(random, 10), random)};
    mesh = joined<double>(two);
  }
  if (happens(0.2)) {  // faces cut off along a seam of duplicates
    const std::size_t f = random_face();
    for (Index& v : mesh.faces[f]) {
      const auto p = mesh.position(v);
      v = static_cast<Index>(mesh.positions.size());
      mesh.positions.push_back(p);
    }
  }
  for (int faces = 0; faces < 3 && happens(0.3); ++faces) {  // without area, on an edge
    const auto face = mesh.faces[random_face()];
    const auto p = mesh.position(face[0]), q = mesh.position(face[1]);
    const double t = happens(0.3) ? 0 : 0.5;  // also with an edge of no length
    mesh.faces.push_back({face[0], face[1], static_cast<Index>(mesh.positions.size())});
    mesh.positions.push_back(
        {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])});
  }
  if (happens(0.2)) {  // places that fall together, or on one line
    const double step = happens(0.3) ? 1.0 : happens(0.5) ? 0.5 : 0.25;
    for (auto& p : mesh.positions) {
      for (double& x : p) x = std::round(x / step) * step;
    }
  }
  if (happens(0.1)) mesh.positions.push_back({1, 2, 3});
  const double scale = happens(0.3) ? std::pow(10, uniform(random, -15, 15)) : 1;
  const double away = happens(0.2) ? scale * std::pow(10, uniform(random, 0, 4)) : 0;
  for (auto& p : mesh.positions) {
    for (double& x : p) x = x * scale + away;
  }
  return mesh;
}

Mesh<double> shrunk(const Mesh<double>& mesh, const Property& property) {
  const auto fails = [&](const Mesh<double>& candidate) { return !property(candidate).empty(); };
  const auto small = stress::shrunk(mesh, fails);
  const auto tidy = repair(small, {.drop_unused_vertices = true}).mesh;
  return fails(tidy) ? tidy : small;
}

}  // namespace

TEST_CASE("every property holds on random meshes") {
  const int meshes = stress::from_environment("MESHES", 400),
            seed = stress::from_environment("SEED", 1);
  for (int i = 0; i < meshes; ++i) {
    Random random(static_cast<std::uint64_t>(seed) * 1000003 + static_cast<std::uint64_t>(i));
    const Mesh<double> mesh = random_mesh(random);
    if (!check(mesh).is_accepted()) continue;
    for (const auto& [name, property] : properties()) {
      const std::string fault = property(mesh);
      if (fault.empty()) continue;
      const auto small = shrunk(mesh, property);
      FAIL_CHECK("seed " << seed << ", mesh " << i << ", " << name << ": " << fault
                         << "\nsmall: " << property(small) << "\n"
                         << stress::literal(small));
    }
  }
}

TEST_CASE("every property holds on the meshes that once failed") {
  for (const auto& kept : stress::kept_meshes()) {
    CAPTURE(kept.first);
    REQUIRE(check(kept.second).is_accepted());
    for (const auto& property : properties()) {
      CAPTURE(property.name);
      CHECK(property.property(kept.second) == "");
    }
  }
}

TEST_CASE("no solver takes a mesh with a coordinate that is no number") {
  for (const auto& method : stress::methods()) {
    for (std::size_t v = 0; v < 5; ++v) {  // the fifth is in no face
      for (std::size_t k = 0; k < 3; ++k) {
        Mesh<double> mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 2, 0}},
                          {{0, 1, 2}, {2, 1, 3}}};
        mesh.positions[v][k] = std::numeric_limits<double>::quiet_NaN();
        CAPTURE(method.name);
        CHECK_THROWS_AS((void)method.make(mesh, Precision::in_double)->distance(stress::from(0)),
                        gelight::InvalidInput);
      }
    }
  }
}

TEST_CASE("shrinking finds the few faces that matter") {
  Random random(4);
  const Mesh<double> mesh = test::random_grid(6, random);
  // "Fails" while three faces of the sheet's corner are there.
  const Property property = [](const Mesh<double>& candidate) -> std::string {
    int near = 0;
    for (const auto& face : candidate.faces) {
      near += candidate.position(face[0])[0] + candidate.position(face[0])[1] < 2.5;
    }
    return near >= 3 ? "three" : "";
  };
  CHECK(shrunk(mesh, property).faces.size() == 3);
}
