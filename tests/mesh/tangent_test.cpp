#include "gelight/mesh/tangent.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "gelight/mesh/shapes.hpp"
#include "gelight/views/mesh_view.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using std::numbers::pi;

namespace {

// A cone of `count` equal faces with total angle `angle`, apex vertex 0, built from its slant
// length 1: the ring's radius and height follow. Angles up to 2 pi.
Mesh<double> cone(Index count, double angle) {
  const double chord = 2 * std::sin(angle / count / 2);
  const double radius = chord / (2 * std::sin(pi / count));
  const double height = std::sqrt(std::max(0.0, 1 - radius * radius));
  Mesh<double> mesh{{{0, 0, height}}, {}};
  for (Index k = 0; k < count; ++k) {
    const double a = 2 * pi * k / count;
    mesh.positions.push_back({radius * std::cos(a), radius * std::sin(a), 0});
    mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % count});
  }
  return mesh;
}

}  // namespace

TEST_CASE("frames are orthonormal, right-handed and tangent") {
  const auto mesh = icosphere<double>(3);
  const TangentFrames<double> frames{Surface(mesh)};
  for (Index v = 0; v < 642; ++v) {
    const auto& basis = frames.basis(v);
    const auto& p = mesh.positions[static_cast<std::size_t>(v)];
    CHECK(basis.x.norm() == gelight::test::approx(1));
    CHECK(basis.y.norm() == gelight::test::approx(1));
    CHECK(std::abs(basis.x.dot(basis.y)) < 1e-15);
    CHECK(basis.normal().dot(Vec3<double>(p[0], p[1], p[2])) > 0.999);
  }
}

TEST_CASE("an edge and its twin transport inversely") {
  const Surface surface(torus(2.0, 0.7, 20, 9));
  const TangentFrames<double> frames(surface);
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    CHECK(std::abs(frames.transport(h) * frames.transport(surface.twin(h)) - 1.0) < 1e-12);
    CHECK(std::abs(std::polar(1.0, frames.angle_back(h) - frames.angle(surface.twin(h))) - 1.0) <
          1e-12);
  }
}

TEST_CASE("in a flat sheet, angles are those of space and transport does nothing") {
  const auto mesh = grid<double>(4, 3, 2.0, 1.0);
  const Surface surface(mesh);
  const TangentFrames<double> frames(surface);
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    const Index from = surface.origin(h), to = surface.tip(h);
    const Vec3<double> edge = surface.position(to) - surface.position(from);
    const auto& basis = frames.basis(from);
    const double angle = frames.angle(h);
    const Vec3<double> direction = basis.embed(std::polar(1.0, angle));
    CHECK((direction - edge.normalized()).norm() < 1e-14);
    const auto carried = frames.transport(h) * basis.project(edge);
    CHECK((frames.basis(to).embed(carried) - edge).norm() < 1e-14);
  }
}

TEST_CASE("holonomy round a cone's apex is its angle defect") {
  for (const double angle : {1.0, 3.0, 5.0, 2 * pi}) {
    const Surface surface(cone(12, angle));
    const TangentFrames<double> frames(surface);
    std::complex<double> round = 1;
    for (Index f = 0; f < 12; ++f) round *= frames.transport(3 * f + 1);  // the rim, once round
    CHECK(std::abs(round - std::polar(1.0, 2 * pi - angle)) < 1e-12);
  }
}

TEST_CASE("faces without an orientation in common are refused, and so are fins") {
  const auto message = [](const Mesh<double>& mesh) {
    return test::refusal([&] { require_oriented(Surface(mesh)); });
  };
  auto mesh = icosphere<double>(1);
  CHECK(message(mesh) == "accepted");
  std::swap(mesh.faces[7][0], mesh.faces[7][1]);
  CHECK(message(mesh).find("face") != std::string::npos);
  CHECK(message(mesh).find("orientation") != std::string::npos);
  const Mesh<double> fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}},
                         {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}};
  CHECK(message(fin) ==
        "the edge between vertices 0 and 1 has more than two faces; vectors need "
        "an oriented manifold");
  // A Moebius strip of five quads has no orientation at all.
  Mesh<double> moebius;
  for (Index k = 0; k < 5; ++k) {
    const double a = 2 * pi * k / 5;
    for (const double s : {-0.3, 0.3}) {
      const double r = 1 + s * std::cos(a / 2);
      moebius.positions.push_back({r * std::cos(a), r * std::sin(a), s * std::sin(a / 2)});
    }
    const Index p = 2 * k, q = p + 1;
    const Index r = k == 4 ? 1 : p + 2, s = k == 4 ? 0 : p + 3;
    moebius.faces.push_back({p, r, q});
    moebius.faces.push_back({q, r, s});
  }
  CHECK(message(moebius).find("orientation") != std::string::npos);
}
