#include "gelight/light/geodesic.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using gelight::edge_point;
using gelight::face_point;
using gelight::Index;
using gelight::Source;
using gelight::Surface;
using gelight::SurfacePoint;
using gelight::Vec3;
using gelight::vertex_point;

namespace {

// Two points in every face, one of them near a side.
std::vector<SurfacePoint<double>> points_in_faces(const Surface<double>& surface) {
  std::vector<SurfacePoint<double>> points;
  for (Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(face_point<double>(f, {0.2, 0.3, 0.5}));
    points.push_back(face_point<double>(f, {0.001, 0.6, 0.399}));
  }
  return points;
}

}  // namespace

TEST_CASE("on a flat sheet the light is straight at vertices, on edges and inside faces") {
  const Surface surface(gelight::grid(7, 5, 1.4, 1.0));
  const gelight::ExactSolver<double> solver(surface);
  std::vector<SurfacePoint<double>> points = points_in_faces(surface);
  for (Index v = 0; v < surface.vertex_count(); ++v) points.push_back(vertex_point<double>(v));
  points.push_back(edge_point<double>(0, 1, 0.3));
  const std::array<SurfacePoint<double>, 3> leds{vertex_point<double>(19),
                                                 edge_point<double>(0, 9, 0.4),
                                                 face_point<double>(31, {.2, .7, .1})};
  for (const auto& led : leds) {
    const auto field = gelight::geodesic_field<double>(solver, led, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3<double> way = surface.position(points[i]) - surface.position(led);
      const Vec3<double> expected = way.norm() > 0 ? way.normalized() : Vec3<double>::Zero();
      CHECK((field[i] - expected).norm() < 1e-12);
    }
  }
}

TEST_CASE("on an open prism the light follows the unrolled straight line, the shorter way round") {
  const int sides = 40;
  std::vector<gelight::ProfilePoint<double>> wall;
  for (int i = 0; i <= 12; ++i) wall.push_back({1, 0.2 * i});
  const Surface surface(gelight::revolve<double>(wall, 2 * std::numbers::pi / sides));
  const gelight::ExactSolver<double> solver(surface);
  // Every other ring is turned by half a side, so the faces are chords between the rings; only the
  // rings' vertices lie on the cylinder. Unrolled by face, the net is flat: the faces of each band
  // are all alike, so their heights and bases give its width and height.
  const double half = std::sin(std::numbers::pi / sides);  // half a side
  const double side = 2 * half;
  const double slant = std::sqrt(surface.length(surface.find_halfedge(0, sides)) *
                                     surface.length(surface.find_halfedge(0, sides)) -
                                 half * half);  // height of a band's triangles
  const auto unrolled = [&](Index v) {
    const Index ring = v / sides;
    const Vec3<double> p = surface.position(v);
    const double turn = std::atan2(p[1], p[0]) / (2 * std::numbers::pi);
    return std::array<double, 2>{turn * sides * side, ring * slant};
  };
  const Index led = 6 * sides;
  const auto points = gelight::vertex_points(surface);
  const auto field = gelight::geodesic_field<double>(solver, vertex_point<double>(led), points);
  const auto from = unrolled(led);
  const double perimeter = sides * side;
  // The cut runs opposite the LED; the bands bend along the rings, but a straight line in the net
  // stays straight, whichever bands it crosses.
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    if (v == led) continue;
    const auto to = unrolled(v);
    double across = to[0] - from[0];
    across -= perimeter * std::round(across / perimeter);
    if (std::abs(std::abs(across) - perimeter / 2) < 0.01) continue;  // both ways are equally long
    const double along = to[1] - from[1], length = std::hypot(across, along);
    // The arriving direction rises as the line in the net does: a band's height is 0.2 in z.
    CAPTURE(v);
    CHECK(field[static_cast<std::size_t>(v)].z() ==
          gelight::test::approx(along / length * 0.2 / slant).epsilon(1e-9));
  }
}

TEST_CASE("an LED of several points lights each place from the nearest of them") {
  const Surface surface(gelight::grid(10, 10, 1.0, 1.0));
  const gelight::ExactSolver<double> solver(surface);
  const std::array<Source<double>, 2> led{
      {{vertex_point<double>(0), 0}, {vertex_point<double>(120), 0}}};
  const auto points = points_in_faces(surface);
  const auto field =
      gelight::geodesic_field<double>(solver, std::span<const Source<double>>(led), points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> p = surface.position(points[i]);
    const Vec3<double> one = p, other = p - Vec3<double>(1, 1, 0);
    if (std::abs(one.norm() - other.norm()) < 1e-9) continue;
    CHECK((field[i] - (one.norm() < other.norm() ? one : other).normalized()).norm() < 1e-12);
  }
}

TEST_CASE("a part of the surface that no path reaches is dark") {
  const gelight::Mesh<double> parts[] = {
      gelight::box(1.0, 1.0, 1.0),
      gelight::placed<double>(gelight::box(1.0, 1.0, 1.0), Eigen::Matrix3d::Identity(), {5, 0, 0})};
  const Surface surface(gelight::joined<double>(parts));
  const gelight::ExactSolver<double> solver(surface);
  const auto points = gelight::vertex_points(surface);
  const auto field = gelight::geodesic_field<double>(solver, vertex_point<double>(0), points);
  for (std::size_t v = 0; v < 16; ++v) CHECK(field[v].isZero() == (v == 0 || v >= 8));
}

TEST_CASE("the light comes as the exact field says, next to corners and edges and on needles too") {
  gelight::Mesh<double> needles = gelight::torus(1.0, 0.4, 24, 12);
  for (auto& p : needles.positions) p[2] *= 1e-3;
  for (const gelight::Mesh<double>& mesh :
       {gelight::torus(1.0, 0.4, 24, 12), gelight::icosphere(2, 1.0), needles}) {
    const Surface surface(mesh);
    const gelight::ExactSolver<double> solver(surface);
    std::vector<SurfacePoint<double>> points = gelight::vertex_points(surface);
    for (Index f = 0; f < surface.face_count(); ++f) {
      for (const double near : {1e-3, 1e-7, 1e-10, 1e-12}) {
        points.push_back(face_point<double>(f, {1 - 2 * near, near, near}));
        points.push_back(face_point<double>(f, {0.3, 0.7 - near, near}));
      }
    }
    // With more points than faces all windows are kept, with fewer those of the points' faces.
    const std::size_t few = points.size() / 16;
    for (const auto& led : {vertex_point<double>(7), face_point<double>(31, {.2, .7, .1})}) {
      const auto field = gelight::geodesic_field<double>(solver, led, points);
      const auto of_few = gelight::geodesic_field<double>(solver, led, std::span(points).last(few));
      gelight::ExactOptions<double> options;
      options.keep_windows = true;
      const gelight::ExactField<double> kept = solver.solve(led, options);
      for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(field[i] == kept.direction(points[i]));
      }
      for (std::size_t i = 0; i < few; ++i) {
        const auto& point = points[points.size() - few + i];
        CHECK(of_few[i].norm() == gelight::test::approx(1));
        CHECK(of_few[i] == kept.direction(point));
      }
    }
  }
}
