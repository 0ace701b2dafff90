#include "gelight/transport/parallel.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using std::numbers::pi;
using test::refusal;
using Vec = Vec3<double>;

namespace {

// A cone of `count` equal faces round its apex, vertex 0, of slant length 1.
Mesh<double> cone(Index count, double angle) {
  const double chord = 2 * std::sin(angle / count / 2);
  const double radius = chord / (2 * std::sin(pi / count));
  Mesh<double> mesh{{{0, 0, std::sqrt(std::max(0.0, 1 - radius * radius))}}, {}};
  for (Index k = 0; k < count; ++k) {
    const double a = 2 * pi * k / count;
    mesh.positions.push_back({radius * std::cos(a), radius * std::sin(a), 0});
    mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % count});
  }
  return mesh;
}

// A saddle: 2 n faces round vertex 0 whose rim goes up and down.
Mesh<double> saddle(Index count) {
  Mesh<double> mesh{{{0, 0, 0}}, {}};
  for (Index k = 0; k < count; ++k) {
    const double a = 2 * pi * k / count;
    mesh.positions.push_back({std::cos(a), std::sin(a), 0.8 * std::cos(2 * a)});
    mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % count});
  }
  return mesh;
}

// Once round vertex 0 of a fan, from spoke to spoke, counter-clockwise.
Path<double> round_path(Index count, double share) {
  Path<double> path;
  for (Index k = 0; k <= count; ++k) path.push_back(edge_point<double>(0, 1 + k % count, share));
  return path;
}

double defect_of(const Surface<double>& surface, Index v) {
  double sum = 0;
  for (const Index h : surface.corners(v)) {
    const Vec a = surface.position(surface.tip(h)) - surface.position(v);
    const Vec b = surface.position(surface.apex(h)) - surface.position(v);
    sum += std::atan2(a.cross(b).norm(), a.dot(b));
  }
  return 2 * pi - sum;
}

double angle_between(const Vec& a, const Vec& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

TEST_CASE(
    "a tangent plane whose first edge is at a right angle to it has a basis of unit vectors") {
  const ParallelTransport carry(
      Mesh<double>{{{0, -1, -1}, {-1, 0, -1}, {1, 0, 0}, {0, -1, -1}, {-1, -1, 0}},
                   {{0, 3, 2}, {0, 1, 3}, {1, 4, 3}}});
  const auto [x, y] = carry.tangent_basis(vertex_point<double>(3));
  CHECK(x.norm() == test::approx(1));
  CHECK(y.norm() == test::approx(1));
  CHECK(std::abs(x.dot(y)) < 1e-12);
  CHECK((x.cross(y) - Vec(1, 1, 1) / std::sqrt(3.0)).norm() < 1e-12);
}

TEST_CASE("on sides of no length there is a tangent plane, and no vector is lost") {
  for (const double side : {1.0, 0.0}) {
    const ParallelTransport carry(
        Mesh<double>{{{0, 0, 0}, {0, 0, 0}, {side, 0, 0}, {0, side, 0}}, {{0, 1, 2}, {1, 0, 3}}});
    for (const auto& point : {edge_point(0, 1, 0.5), face_point<double>(0, {0.25, 0.25, 0.5})}) {
      const auto [x, y] = carry.tangent_basis(point);
      CHECK(x.norm() == test::approx(1));
      CHECK(y.norm() == test::approx(1));
      CHECK(std::abs(x.dot(y)) < 1e-12);
      const Path<double> path{point, vertex_point<double>(2)}, back{path[1], point};
      const Vec there = carry.along(path, x);
      CHECK(there.norm() == test::approx(1));
      CHECK((carry.along(back, there) - x).norm() < 1e-12);
      // The other side's direction stays along it.
      if (side > 0) CHECK((carry.along(path, Vec(1, 0, 0)) - Vec(1, 0, 0)).norm() < 1e-6);
    }
  }
}

TEST_CASE("holonomy round an apex is its angle defect, whatever the way round") {
  for (const double angle : {1.0, 3.0, 5.0}) {
    const Surface surface(cone(9, angle));
    const ParallelTransport transport(surface);
    const double expected = std::remainder(2 * pi - angle, 2 * pi);
    for (const double share : {0.1, 0.5, 1.0}) {
      auto path = round_path(9, share);
      CHECK(transport.holonomy(path) == gelight::test::approx(expected).epsilon(1e-12));
      std::reverse(path.begin(), path.end());
      CHECK(transport.holonomy(path) == gelight::test::approx(-expected).epsilon(1e-12));
    }
    // Through points inside the faces too.
    Path<double> inner;
    for (Index k = 0; k <= 9; ++k) {
      inner.push_back(edge_point<double>(0, 1 + k % 9, 0.3 + 0.05 * (k % 9)));
      if (k < 9) inner.push_back(face_point<double>(k, {0.4, 0.1, 0.5}));
    }
    CHECK(transport.holonomy(inner) == gelight::test::approx(expected).epsilon(1e-12));
  }
  const Surface surface(saddle(12));
  const double defect = defect_of(surface, 0);
  CHECK(defect < -0.5);
  CHECK(ParallelTransport(surface).holonomy(round_path(12, 0.4)) ==
        gelight::test::approx(std::remainder(defect, 2 * pi)).epsilon(1e-12));
}

TEST_CASE("a path through the apex shares the defect between its sides") {
  const Surface surface(cone(8, 5.0));
  const ParallelTransport transport(surface);
  // Straight through, and along either side; the two sides together go once round.
  const Path<double> through{vertex_point<double>(1), vertex_point<double>(0),
                             vertex_point<double>(5)};
  const Path<double> left{vertex_point<double>(1), vertex_point<double>(2), vertex_point<double>(3),
                          vertex_point<double>(4), vertex_point<double>(5)};
  const Path<double> right{vertex_point<double>(1), vertex_point<double>(8),
                           vertex_point<double>(7), vertex_point<double>(6),
                           vertex_point<double>(5)};
  const auto [x, y] = transport.tangent_basis(vertex_point<double>(1));
  const Vec a = transport.along(left, x), b = transport.along(right, x);
  const Vec c = transport.along(through, x);
  CHECK(angle_between(a, b) == gelight::test::approx(2 * pi - 5.0).epsilon(1e-12));
  CHECK(angle_between(a, c) == gelight::test::approx((2 * pi - 5.0) / 2).epsilon(1e-12));
  CHECK(angle_between(b, c) == gelight::test::approx((2 * pi - 5.0) / 2).epsilon(1e-12));
}

TEST_CASE("round an octant of a sphere it is a right angle, on any symmetric mesh of it") {
  // The icosphere is its own mirror image in the three planes, whose traces bound octants. Half the
  // defects on them lies inside, and an eighth of all defects is pi / 2.
  for (const int level : {0, 1, 3, 4}) {
    const Surface surface(icosphere<double>(level));
    // The trace of plane p[axis] = 0 from axis + 1 to axis + 2.
    const auto side = [&](int axis) {
      std::vector<std::pair<double, SurfacePoint<double>>> points;
      const auto add = [&](const SurfacePoint<double>& point) {
        const Vec p = surface.position(point);
        const double along = std::atan2(p[(axis + 2) % 3], p[(axis + 1) % 3]);
        if (along > -1e-9 && along < pi / 2 + 1e-9) points.emplace_back(along, point);
      };
      const auto height = [&](Index v) {
        return std::abs(surface.position(v)[axis]) < 1e-12 ? 0.0 : surface.position(v)[axis];
      };
      for (Index v = 0; v < surface.vertex_count(); ++v) {
        if (height(v) == 0) add(vertex_point<double>(v));
      }
      for (Index h = 0; h < surface.halfedge_count(); ++h) {
        const double a = height(surface.origin(h)), b = height(surface.tip(h));
        if (a < 0 && b > 0) {
          add(edge_point<double>(surface.origin(h), surface.tip(h), a / (a - b)));
        }
      }
      std::sort(points.begin(), points.end(),
                [](const auto& a, const auto& b) { return a.first < b.first; });
      return points;
    };
    Path<double> path;
    for (const int axis : {2, 0, 1}) {
      for (const auto& [along, point] : side(axis)) path.push_back(point);
    }
    path.push_back(path.front());
    CHECK(ParallelTransport(surface).holonomy(path) ==
          gelight::test::approx(pi / 2).epsilon(1e-11));
  }
}

TEST_CASE("in a flat sheet and on an unrolled cylinder a vector stays what it is") {
  const Surface sheet(grid<double>(7, 5, 1.4, 1.0));
  const ParallelTransport flat(sheet);
  const ExactSolver<double> solver(sheet);
  const auto field = solver.solve(face_point<double>(31, {.2, .7, .1}));
  for (const Vec& v : {Vec(1, 2, 0), Vec(-1, 2, 0), Vec(-3, -0.1, 0), Vec(0, -5, 0)}) {
    for (Index to = 0; to < sheet.vertex_count(); ++to) {
      CHECK((flat.along(field.path(to), v) - v).norm() < 1e-13);
    }
  }
  // Along a prism's wall the angle to its axis stays.
  std::vector<ProfilePoint<double>> wall;
  for (int i = 0; i <= 8; ++i) wall.push_back({1, 0.25 * i});
  const Surface prism(revolve<double>(wall, 2 * pi / 24));
  const ParallelTransport round(prism);
  const ExactSolver<double> exact(prism);
  const auto paths = exact.solve(face_point<double>(5, {.3, .3, .4}));
  const Vec n = Vec(prism.position(prism.face(5)[1]) - prism.position(prism.face(5)[0]))
                    .cross(prism.position(prism.face(5)[2]) - prism.position(prism.face(5)[0]))
                    .normalized();
  for (Index f = 0; f < prism.face_count(); ++f) {
    const auto to = face_point<double>(f, {.2, .2, .6});
    const Path<double> path = paths.path(to);
    const Vec along = (prism.position(path[1]) - prism.position(path[0])).normalized();
    const Vec end = round.along(path, along);
    const Vec arrives =
        (prism.position(path.back()) - prism.position(path[path.size() - 2])).normalized();
    CHECK((end - arrives).norm() < 1e-12);  // a geodesic carries its own direction
    CHECK(round.along(path, 3 * along + n.cross(along)).norm() ==
          gelight::test::approx(std::sqrt(10.0)).epsilon(1e-13));
  }
}

TEST_CASE("there and back is the identity; rigid motion, scale and faces' numbers change nothing") {
  const auto mesh = torus(2.0, 0.7, 30, 14);
  const Surface surface(mesh);
  const ParallelTransport transport(surface);
  const auto field = ExactSolver<double>(surface).solve(33);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2, Vec(1, 2, -3).normalized()).toRotationMatrix();
  const ParallelTransport turned(placed(mesh, turn, Vec(5, 6, 7)));
  auto small = mesh;
  for (auto& p : small.positions) p = {1e-6 * p[0], 1e-6 * p[1], 1e-6 * p[2]};
  const ParallelTransport scaled(small);
  for (Index v = 0; v < surface.vertex_count(); v += 7) {
    auto path = field.path(v);
    const auto [x, y] = transport.tangent_basis(path.front());
    const Vec start = 0.3 * x - 2 * y;
    const Vec end = transport.along(path, start);
    CHECK(end.norm() == gelight::test::approx(start.norm()).epsilon(1e-13));
    CHECK((turned.along(path, turn * start) - turn * end).norm() < 1e-10);
    CHECK((scaled.along(path, start) - end).norm() < 1e-10);
    std::reverse(path.begin(), path.end());
    CHECK((transport.along(path, end) - start).norm() < 1e-12);
  }
}

TEST_CASE("vector heat draws near transport along the geodesics as the mesh is refined") {
  std::vector<double> means;
  for (const int level : {2, 3, 4, 5}) {
    auto mesh = icosphere<double>(level);
    for (auto& p : mesh.positions) p[2] *= 0.6;  // an ellipsoid: no symmetry helps
    const Surface surface(mesh);
    const VectorHeatSolver<double> heat(surface);
    const ParallelTransport<double> transport(surface);
    const auto field = ExactSolver<double>(surface).solve(7);
    const Vec start = heat.tangent_basis(7)[0];
    const auto carried = heat.transport(7, start);
    double farthest = 0;
    for (const double d : field.distances()) farthest = std::max(farthest, d);
    double mean = 0;
    int count = 0;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      // Near the cut locus neighbours get vectors by other ways.
      if (field.distance(v) > 0.6 * farthest) continue;
      mean += angle_between(transport.along(field.path(v), start),
                            carried[static_cast<std::size_t>(v)]);
      ++count;
    }
    means.push_back(mean / count * 180 / pi);
  }
  MESSAGE("mean angle, degrees: " << means[0] << ", " << means[1] << ", " << means[2] << ", "
                                  << means[3]);
  CHECK(means[1] < means[0]);
  CHECK(means[2] < means[1]);
  CHECK(means[3] < 0.5);
}

TEST_CASE("bad input is refused by name") {
  const auto mesh = icosphere<double>(1);
  const ParallelTransport transport(mesh);
  const auto a = vertex_point<double>(mesh.faces[0][0]), b = vertex_point<double>(mesh.faces[0][1]);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS((void)transport.along({}, Vec(1, 0, 0)), InvalidInput);
  CHECK_THROWS_AS((void)transport.along({a, b}, Vec(nan, 0, 0)), InvalidInput);
  CHECK_THROWS_AS((void)transport.along({a, vertex_point<double>(99)}, Vec(1, 0, 0)), InvalidInput);
  CHECK(refusal([&] {
          (void)transport.along({a, b, vertex_point<double>(3)}, Vec(1, 0, 0));
        }) == "no face holds both points 1 and 2 of the path");
  CHECK(refusal([&] {
          (void)transport.holonomy({a, b});
        }).find("does not end") != std::string::npos);
  auto flipped = mesh;
  std::swap(flipped.faces[3][0], flipped.faces[3][1]);
  CHECK_THROWS_AS(ParallelTransport{flipped}, InvalidInput);
  auto lonely = mesh;
  lonely.positions.push_back({5, 5, 5});
  const ParallelTransport with_lonely(lonely);
  CHECK_THROWS_AS((void)with_lonely.tangent_basis(vertex_point<double>(42)), InvalidInput);
}

TEST_CASE_TEMPLATE("a vector longer than its parts can be is refused, one as long comes back", T,
                   float, double) {
  const ParallelTransport transport(icosphere<T>(1));
  const T most = std::numeric_limits<T>::max();
  for (Index v = 0; v < transport.surface().vertex_count(); ++v) {
    const gelight::Path<T> path{vertex_point<T>(v)};
    const auto [x, y] = transport.tangent_basis(vertex_point<T>(v));
    const Vec3<T> inside = most / 2 * x + most / 2 * y;
    CHECK((transport.along(path, inside) / most - inside / most).norm() < 1e-6);
    // Its part along x + y is as long as their coordinates' amounts, times the most.
    Vec3<T> beyond;
    for (int k = 0; k < 3; ++k) beyond[k] = std::copysign(most, x[k] + y[k]);
    CHECK(refusal([&] { (void)transport.along(path, beyond); }).find("longer than one of its") !=
          std::string::npos);
  }
}
