#include "gelight/light/transport.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using gelight::face_point;
using gelight::Index;
using gelight::Surface;
using gelight::SurfacePoint;
using gelight::Vec3;

namespace {

std::vector<SurfacePoint<double>> centroids(const Surface<double>& surface) {
  std::vector<SurfacePoint<double>> points;
  for (Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(face_point<double>(f, {1. / 3, 1. / 3, 1. / 3}));
  }
  return points;
}

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(gelight::cross(a, b).norm(), a.dot(b));
}

}  // namespace

TEST_CASE("on a flat sheet every point gets the LED's direction, whatever its quadrant") {
  const Surface surface(gelight::grid(20, 20, 1.0, 1.0));
  const gelight::VectorHeatSolver<double> solver(surface);
  const auto points = centroids(surface);
  for (const double turn : {0.3, 1.9, 3.3, 5.1}) {
    const Vec3<double> emission(2 * std::cos(turn), 2 * std::sin(turn), 0);
    const auto field = gelight::transport_field<double>(solver, 220, emission, points);
    for (const Vec3<double>& direction : field) {
      CHECK((direction - emission / 2).norm() < 1e-9);
    }
  }
}

TEST_CASE("on a membrane's wall light sent towards the tip goes straight towards the tip") {
  const Surface surface(gelight::membrane(0.01, 0.04, 0.001));
  const gelight::VectorHeatSolver<double> solver(surface);
  const auto points = centroids(surface);
  const auto field = gelight::transport_field<double>(solver, 5, {0, 0, 1}, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> normal = gelight::detail::face_normal(surface, static_cast<Index>(i));
    CHECK(field[i].norm() == gelight::test::approx(1));
    CHECK(std::abs(field[i].dot(normal.normalized())) < 1e-12);
    if (surface.position(points[i]).z() < 0.02) CHECK(angle(field[i], {0, 0, 1}) < 0.02);
  }
}

TEST_CASE("radial light leaves the LED on all sides") {
  const Surface surface(gelight::grid(40, 40, 1.0, 1.0));
  const gelight::VectorHeatSolver<double> solver(surface);
  const Index led = 20 * 41 + 20;
  const auto points = centroids(surface);
  const auto field = gelight::radial_transport_field<double>(solver, led, points);
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> way = surface.position(points[i]) - surface.position(led);
    if (way.norm() > 0.1) worst = std::max(worst, angle(field[i], way));
  }
  CHECK(worst < 0.1);
}

TEST_CASE("an emission of any length gives light of unit length") {
  const Surface<float> surface(gelight::icosphere(2, 1.0F));
  const gelight::VectorHeatSolver<float> solver(surface);
  const auto points = gelight::vertex_points(surface);
  const auto light = [&](float length) {
    return transport_field(solver, 5, Vec3<float>(length, length / 2, 0), points);
  };
  const auto expected = light(1);
  // The squares of all but the first are beyond float.
  for (const int exponent : {10, 100, 120, -80, -100}) {
    CAPTURE(exponent);
    const auto field = light(std::ldexp(1.0F, exponent));
    for (std::size_t i = 0; i < field.size(); ++i) CHECK((field[i] - expected[i]).norm() < 1e-6F);
  }
}
