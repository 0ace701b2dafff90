#include "gelight/light/led.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using namespace gelight;

namespace {

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::vector<SurfacePoint<double>> centroids(const Surface<double>& surface) {
  std::vector<SurfacePoint<double>> points;
  for (Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(face_point<double>(f, {1. / 3, 1. / 3, 1. / 3}));
  }
  return points;
}

Vec3<double> nearest_on_segment(const Vec3<double>& p, const Vec3<double>& a,
                                const Vec3<double>& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return a + t * (b - a);
}

}  // namespace

TEST_CASE("points along a path are on it, evenly, its ends among them") {
  const Surface<double> surface(grid(8, 8, 1.0, 1.0));
  const auto from = face_point<double>(3, {0.2, 0.3, 0.5});
  const auto to = face_point<double>(100, {0.5, 0.3, 0.2});
  const auto path = ExactSolver<double>(surface).solve(from).path(to);
  const double whole = length(surface, path);
  const auto points = points_along(surface, path, whole / 50);
  const Vec3<double> a = surface.position(from), b = surface.position(to);
  CHECK((surface.position(points.front()) - a).norm() < 1e-15);
  CHECK((surface.position(points.back()) - b).norm() < 1e-15);
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vec3<double> p = surface.position(points[i]);
    const double step = (p - surface.position(points[i - 1])).norm();
    CHECK(step <= whole / 50 * (1 + 1e-12));
    CHECK((p - nearest_on_segment(p, a, b)).norm() < 1e-14);
    sum += step;
  }
  CHECK(sum == gelight::test::approx(whole).epsilon(1e-13));
  CHECK_THROWS_AS((void)points_along(surface, path, 0.0), InvalidInput);
  CHECK_THROWS_AS((void)points_along(surface, path, 1e-300), InvalidInput);
  CHECK_THROWS_AS((void)points_along(surface, {}, 1.0), InvalidInput);
  CHECK_THROWS_AS((void)points_along(surface, {from, to}, 1.0), InvalidInput);
}

TEST_CASE("in a flat sheet a line of light shines at right angles to itself, round at its ends") {
  const Surface<double> surface(grid(16, 16, 1.0, 1.0));
  const ExactSolver<double> solver(surface);
  const auto from = vertex_point<double>(4 * 17 + 5), to = vertex_point<double>(11 * 17 + 8);
  const double spacing = 0.002;
  const auto led = points_along(surface, solver.solve(from).path(to), spacing);
  const auto points = centroids(surface);
  const auto sources = as_sources(led);
  const auto by_geodesic =
      geodesic_field<double>(solver, std::span<const Source<double>>(sources), points);
  const auto by_plane = plane_rays<double>(surface, led, points);
  LightField<double> places, targets;
  for (const auto& p : led) places.push_back(surface.position(p));
  for (const auto& p : points) targets.push_back(surface.position(p));
  const auto by_line = linear_rays<double>(places, targets);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> p = targets[i];
    const Vec3<double> near = nearest_on_segment(p, surface.position(from), surface.position(to));
    const double d = (p - near).norm();
    if (d < 0.01) continue;
    // The bound that the docstring gives.
    const double allowed = std::atan(spacing / (2 * d)) + 1e-9;
    CHECK(angle(by_geodesic[i], p - near) < allowed);
    CHECK(angle(by_plane.direction[i], p - near) < allowed);
    CHECK(angle(by_line.direction[i], p - near) < allowed);
    for (const double found : {by_plane.distance[i], by_line.distance[i]}) {
      CHECK(found >= d - 1e-14);
      CHECK(found <= d + spacing * spacing / (8 * d) + 1e-14);
    }
  }
}

TEST_CASE("an LED that is a closed line has no ties where its ends meet") {
  const Surface<double> surface(grid(8, 8, 1.0, 1.0));
  const auto corner = [](Index i, Index j) { return vertex_point<double>(9 * j + i); };
  Path<double> ring;
  for (Index k = 2; k < 6; ++k) ring.push_back(corner(k, 2));
  for (Index k = 2; k < 6; ++k) ring.push_back(corner(6, k));
  for (Index k = 6; k > 2; --k) ring.push_back(corner(k, 6));
  for (Index k = 6; k > 1; --k) ring.push_back(corner(2, k));
  const auto led = points_along(surface, ring, 0.011);
  const auto points = centroids(surface);
  LightField<double> places, targets;
  for (const auto& p : led) places.push_back(surface.position(p));
  for (const auto& p : points) targets.push_back(surface.position(p));
  REQUIRE(places.front() == places.back());
  const auto sources = as_sources(led);
  const auto by_geodesic = geodesic_rays<double>(ExactSolver<double>(surface), sources, points);
  const auto by_plane = plane_rays<double>(surface, led, points);
  const auto by_line = linear_rays<double>(places, targets);
  int nearest_to_ends = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // How far the nearest point of the LED is, and the next that is elsewhere.
    std::vector<double> distances;
    for (std::size_t k = 1; k < places.size(); ++k) {
      distances.push_back((places[k] - targets[i]).norm());
    }
    nearest_to_ends += distances.back() == *std::min_element(distances.begin(), distances.end());
    std::nth_element(distances.begin(), distances.begin() + 1, distances.end());
    if (distances[1] < (1 + 1e-5) * distances[0]) continue;
    CHECK(by_geodesic.lighting[i] == Lighting::lit);
    CHECK(by_plane.lighting[i] == Lighting::lit);
    CHECK(by_line.lighting[i] == Lighting::lit);
  }
  CHECK(nearest_to_ends > 5);
}

TEST_CASE("several points with directions of their own are blended by transport") {
  const Surface<double> surface(grid(20, 20, 1.0, 1.0));
  const VectorHeatSolver<double> solver(surface);
  const std::array<VectorSource<double>, 2> led{{{vertex_point<double>(10 * 21), {1, 0, 0}},
                                                 {vertex_point<double>(10 * 21 + 20), {0, 1, 0}}}};
  const auto points = centroids(surface);
  const auto field =
      transport_field<double>(solver, std::span<const VectorSource<double>>(led), points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = surface.position(points[i])[0];
    CHECK(field[i].norm() == gelight::test::approx(1));
    if (x < 0.3) CHECK(angle(field[i], {1, 0, 0}) < 0.1);
    if (x > 0.7) CHECK(angle(field[i], {0, 1, 0}) < 0.1);
  }
}
