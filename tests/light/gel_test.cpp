#include "gelight/light/gel.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "gelight/light/models.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"

namespace {

using namespace gelight;
constexpr double pi = std::numbers::pi;

// Share that a pane of gel over air reflects, from Snell's angles.
double pane(double angle, double index) {
  const double sine = index * std::sin(angle);
  if (sine >= 1) return 1;
  if (angle < 1e-6) return std::pow((index - 1) / (index + 1), 2);
  const double beyond = std::asin(sine);
  const double s = std::sin(angle - beyond) / std::sin(angle + beyond);
  const double t = std::tan(angle - beyond) / std::tan(angle + beyond);
  return (s * s + t * t) / 2;
}

Eigen::Matrix3d turn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Vec3<double> x = Vec3<double>(normal(random), normal(random), normal(random)).normalized();
  const Vec3<double> y = detail::unit_orthogonal(x);
  Eigen::Matrix3d rotation;
  rotation << x, y, cross(x, y);
  return rotation;
}

TEST_CASE_TEMPLATE("flat gel over air: the LED and its mirror image", T, float, double) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share;
  for (const double scale : {1e-6, 0.01, 1.0, 1e6}) {
    for (int i = 0; i < 200; ++i) {
      const double index = 1.2 + share(random), h = scale * (0.1 + share(random));
      const double depth = h * share(random);
      const Vec3<double> to = scale * Vec3<double>(0.2 + 4 * share(random), share(random), 0);
      const Eigen::Matrix3d frame = turn(random);
      const Vec3<double> offset = scale * Vec3<double>(share(random), share(random), 0.5);
      // The membrane is z = 0, seen from beneath, the LED at (0, 0, -depth) shines along x, or up
      // or down from there. What is mirrored leaves it downwards.
      const double tilt = i % 2 == 0 ? 0 : 3 * share(random) - 1.5;
      const Vec3<double> axis(std::cos(tilt), 0, std::sin(tilt));
      Vec3<double> truth(0, 0, 0);
      for (const double z : {-depth, depth - 2 * h}) {
        const double d = std::hypot(to[0], to[1], z);
        const double left = z == -depth ? 1 : pane(std::acos(-z / d), index);
        const Vec3<double> leaves(to[0] / d, to[1] / d, (z == -depth ? -z : z) / d);
        const double shines = std::max(0.0, axis.dot(leaves));
        truth += left * 3 * shines / pi / (d * d) * Vec3<double>(to[0], to[1], -z) / d;
      }
      GelLed<T> led;
      led.place = (frame * Vec3<double>(0, 0, -depth) + offset).cast<T>();
      led.axis = (frame * axis * 7).cast<T>();
      led.normal = (frame.col(2) * 0.1).cast<T>();
      led.depth = static_cast<T>(depth);
      led.thickness = static_cast<T>(h);
      led.index = static_cast<T>(index);
      led.power = 3;
      const std::vector<Vec3<T>> at{(frame * to + offset).cast<T>()};
      const std::vector<Vec3<T>> normals{(frame.col(2) * 5).cast<T>()};
      const auto field = gel_field<T>(led, at, normals);
      const Vec3<double> found = field[0].template cast<double>();
      // Near the critical angle Fresnel's share has an infinite slope: a root of rounding.
      const double rounding = std::is_same_v<T, float> ? 3e-3 : 1e-6;
      // Along the axis' edge little is left of a cosine, with the rounding of the whole.
      const double whole = 3 / pi / to.squaredNorm();
      CHECK((found - frame * truth).norm() < rounding * (tilt == 0 ? truth.norm() : whole));
    }
  }
}

TEST_CASE("a bent gel: dark between where the gel ends and where light crosses the hollow") {
  // Round a circle, from an LED in its skin: a chord of incidence a comes R sin a near the middle.
  const double R = 2;
  for (const double h : {0.05, 0.3, 0.8}) {
    for (const double index : {1.2, 1.41, 1.7}) {
      const GelLed<double> led{.place = {R, 0, 0},
                               .axis = {-0.3, 0, 1},
                               .normal = {1, 0, 0},
                               .thickness = h,
                               .index = index};
      for (int step = 1; step < 314; ++step) {
        const double turn = 0.01 * step;
        const Vec3<double> normal(std::cos(turn), std::sin(turn), 0);
        const std::vector<Vec3<double>> at{R * normal}, normals{normal};
        // Straight light lies in the plane of the circle, at right angles to z: the axis leans.
        const auto field = gel_field<double>(led, at, normals);
        const double near_middle = R * std::cos(turn / 2);   // of the chord
        const double on_inner_side = near_middle / (R - h);  // sine of its incidence there
        const Vec3<double> way = R * normal - led.place;
        const Vec3<double> whole = std::max(0.0, way.dot(led.axis.normalized())) /
                                   (pi * way.squaredNorm() * way.squaredNorm()) * way;
        CAPTURE(turn);
        if (near_middle < 0.999 * (R - h)) {
          if (on_inner_side * index > 1.001) {
            CHECK(field[0].norm() == 0);
          } else if (on_inner_side * index < 0.999) {
            const double passes = 1 - pane(std::asin(on_inner_side), index);
            CHECK((field[0] - passes * passes * whole).norm() < 1e-9 * whole.norm());
          }
        } else if (near_middle > 1.001 * (R - h)) {
          // Within the gel nothing is lost; a mirror image may add to it.
          CHECK(field[0].dot(way) >= (1 - 1e-9) * whole.dot(way));
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("light that just touches the hollow of a bent gel is a number", T, float,
                   double) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const double lean : {0.0, 1e-20, 1e-16, 1e-12, 1e-8, 1e-7, 1e-4, 0.1, 0.7, 1.5}) {
      // The chord of a circle, as deep in its middle as the gel is thick, but for rounding.
      const double d = 2 * scale, cosine = std::cos(lean);
      const double middle = d / 2 * cosine / (1 + std::sin(lean));
      for (const double off : {-1e-7, -1e-15, -2e-16, 0.0, 2e-16, 1e-15, 1e-7}) {
        GelLed<T> led;
        led.axis = led.normal = Vec3<T>(0, 0, 1);
        led.place = Vec3<T>(0, 0, 0);
        led.thickness = static_cast<T>(middle * (1 + off));
        led.depth = 0;
        led.power = 1;
        led.index = T(1.4);
        const std::vector<Vec3<T>> at{Vec3<T>(0, 0, static_cast<T>(d))};
        const std::vector<Vec3<T>> normal{
            Vec3<T>(static_cast<T>(std::sin(lean)), 0, static_cast<T>(cosine))};
        const double seen = double{gel_field<T>(led, at, normal)[0].norm()} * pi * d * d;
        CAPTURE(lean);
        CAPTURE(off);
        // Straight through the hollow, or beside it; mirrored light adds its part.
        const double through = std::pow(1 - pane(0, 1.4), 2);
        CHECK(seen >= (lean == 0 ? through * 0.99 : 0.0));
        CHECK(seen <= 2);
      }
    }
  }
}

TEST_CASE("behind the LED, beneath its horizon and at its place nothing is lit") {
  const GelLed<double> led{
      .place = {0, 0, 0}, .axis = {1, 0, 0}, .normal = {0, 0, 1}, .thickness = 1};
  const std::vector<Vec3<double>> at{{-1, 0, 0.2}, {1, 0, -0.5}, {0, 0, 0}};
  const std::vector<Vec3<double>> normals(3, Vec3<double>(0, 0, 1));
  const auto field = gel_field<double>(led, at, normals);
  CHECK(field[0].isZero(0));
  CHECK(field[2].allFinite());
  // From below the membrane's plane only the mirror image reaches it.
  CHECK(field[1][2] > 0);
}

TEST_CASE_TEMPLATE("the light model of a gel: an LED of several points in flat gel", T, float,
                   double) {
  const auto sheet = grid<T>(40, 40, 4, 4);
  const Surface<T> surface(sheet);
  constexpr double h = 0.5, full = 0.6;
  const GelLight<T> model(sheet, {.thickness = T(h), .full_within = T(full)});
  const auto points = vertex_points(surface);
  Led<T> led{.points = {}, .emission = {0, 3, 0}};
  for (const T x : {T(1), T(1.5), T(2)}) {
    led.points.push_back(vertex_point<T>(nearest_vertex<T>(surface, {x, 0, 0})));
  }
  const auto field = model.field(led, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> to = surface.position(points[i]).template cast<double>();
    Vec3<double> truth(0, 0, 0);
    for (const double x : {1.0, 1.5, 2.0}) {
      for (const double z : {-h / 2, -3 * h / 2}) {
        const Vec3<double> way = to - Vec3<double>(x, 0, z);
        const double d = way.norm(), left = z == -h / 2 ? 1 : pane(std::acos(-z / d), T(1.41));
        truth += full * full / 3 * left * std::max(0.0, way[1]) / std::pow(d, 4) * way;
      }
    }
    if (truth.norm() > 1) truth.normalize();
    CHECK((field[i].template cast<double>() - truth).norm() < 1e-3 * truth.norm() + 1e-12);
  }
  led.emission.setZero();
  CHECK_THROWS_AS((void)model.field(led, points), InvalidInput);
  led.emission = {0, 1, 0};
  CHECK_THROWS_AS((void)model.field(led, points, [] { return true; }), Cancelled);
  led.points.clear();
  CHECK_THROWS_AS((void)model.field(led, points), InvalidInput);
  CHECK_THROWS_AS(GelLight<T>(sheet, {.thickness = 0}), InvalidInput);
}

TEST_CASE("what is no LED is refused, and the hook cancels") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Vec3<double>> at{{1, 0, 0}}, up{{0, 0, 1}}, none{{0, 0, 0}}, two(2, up[0]);
  const GelLed<double> good{.thickness = 1};
  CHECK_NOTHROW((void)gel_field<double>(good, at, up));
  const auto refuses = [&](auto change) {
    GelLed<double> led = good;
    change(led);
    CHECK_THROWS_AS((void)gel_field<double>(led, at, up), InvalidInput);
  };
  for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    refuses([&](auto& led) { led.thickness = bad; });
    refuses([&](auto& led) { led.index = bad; });
    refuses([&](auto& led) { led.power = bad; });
  }
  // Of no gel, and squares that are no numbers.
  for (const double bad : {1e-3, 1e3, 1e200}) {
    refuses([&](auto& led) { led.index = bad; });
    CHECK_THROWS_AS(GelLight<double>(grid(2, 2, 1.0, 1.0), {.index = bad}), InvalidInput);
  }
  refuses([&](auto& led) { led.depth = -0.1; });
  refuses([&](auto& led) { led.depth = 1.1; });
  refuses([&](auto& led) { led.depth = nan; });
  refuses([&](auto& led) { led.axis = {0, 0, 0}; });
  refuses([&](auto& led) { led.normal = {nan, 0, 0}; });
  refuses([&](auto& led) { led.place = {nan, 0, 0}; });
  CHECK_THROWS_AS((void)gel_field<double>(good, at, none), InvalidInput);
  CHECK_THROWS_AS((void)gel_field<double>(good, at, two), InvalidInput);
  for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
    const std::vector<Vec3<double>> nowhere{{0, bad, 0}};
    CHECK_THROWS_AS((void)gel_field<double>(good, nowhere, up), InvalidInput);
  }
  CHECK_THROWS_AS((void)gel_field<double>(good, at, up, [] { return true; }), Cancelled);
}

}  // namespace

TEST_CASE_TEMPLATE("within faces light in a gel bends as on the surface that is meant", T, float,
                   double) {
  constexpr T thickness = T(0.2), full = T(0.5);
  const auto ball = icosphere<T>(3);
  const Surface<T> surface(ball);
  const Index source = 7;
  const Vec3<T> up = surface.position(source),
                along = up.cross(Vec3<T>(T(0.36), T(0.48), T(0.8))).normalized();
  std::vector<SurfacePoint<T>> points;
  std::vector<Vec3<T>> positions, flat, round;
  for (Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(face_point<T>(f, {T(0.6), T(0.3), T(0.1)}));
    positions.push_back(surface.position(points.back()));
    flat.push_back(detail::face_normal(surface, f));
    round.push_back(positions.back().normalized());
  }
  const GelLight<T> model(ball, {.thickness = thickness, .full_within = full});
  const auto field = model.field({.points = {vertex_point<T>(source)}, .emission = along}, points);
  const GelLed<T> led{.place = (1 - thickness / 2) * up,
                      .axis = along,
                      .normal = up,
                      .depth = thickness / 2,
                      .thickness = thickness};
  const auto off = [&](const std::vector<Vec3<T>>& normals) {
    const auto other = gel_field<T>(led, positions, normals);
    double sum = 0;
    for (std::size_t i = 0; i < other.size(); ++i) {
      const T strength = std::numbers::pi_v<T> * full * full * other[i].norm();
      sum += double{(field[i] - std::min(T(1), strength) * other[i].stableNormalized()).norm()};
    }
    return sum;
  };
  // What is left lies where the light of the gel ends, which moves a little with the mesh.
  CHECK(3 * off(round) < off(flat));
}

TEST_CASE("in float, light in a gel is the same far from the origin") {
  // Coordinates of few bits, so that the mesh itself is the same there.
  auto near = icosphere<float>(2);
  for (auto& p : near.positions) {
    for (float& x : p) x = std::round(x * 1024) / 1024;
  }
  auto far = near;
  for (auto& p : far.positions) p = {p[0] + 4096, p[1] - 2048, p[2] + 1024};
  const GelSheet<float> gel{.thickness = 0.2f, .full_within = 0.5f};
  std::vector<SurfacePoint<float>> points;
  for (Index f = 0; f < 320; ++f) points.push_back(face_point<float>(f, {0.6f, 0.3f, 0.1f}));
  const Led<float> led{.points = {edge_point<float>(near.faces[7][0], near.faces[7][1], 0.3f)},
                       .emission = {0.36f, 0.48f, 0.8f}};
  const auto here = GelLight<float>(near, gel).field(led, points);
  const auto there = GelLight<float>(far, gel).field(led, points);
  float most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    most = std::max(most, here[i].norm());
    CHECK((here[i] - there[i]).norm() < 1e-6f);
  }
  CHECK(most > 0.5f);
}

TEST_CASE_TEMPLATE("the light model of a gel refuses a membrane that is inside out", T, float,
                   double) {
  auto ball = placed<T>(icosphere<T>(1), Eigen::Matrix<T, 3, 3>::Identity(), {100, -50, 20});
  CHECK_NOTHROW(GelLight<T>(ball, {}));
  CHECK_THROWS_AS(GelLight<T>(ball, {.has_normals_inwards = true}), InvalidInput);
  for (auto& face : ball.faces) std::swap(face[1], face[2]);
  CHECK_NOTHROW(GelLight<T>(ball, {.has_normals_inwards = true}));
  CHECK_THROWS_WITH_AS(GelLight<T>(ball, {}),
                       "a closed membrane has its normals inwards, and "
                       "GelSheet::has_normals_inwards says otherwise",
                       InvalidInput);
  // Of any size.
  for (const T size : {T(1e-25), T(1e21)}) {
    auto sized = icosphere<T>(1, size);
    CHECK_NOTHROW(GelLight<T>(sized, {}));
    CHECK_THROWS_AS(GelLight<T>(sized, {.has_normals_inwards = true}), InvalidInput);
    for (auto& face : sized.faces) std::swap(face[1], face[2]);
    CHECK_NOTHROW(GelLight<T>(sized, {.has_normals_inwards = true}));
    CHECK_THROWS_AS(GelLight<T>(sized, {}), InvalidInput);
  }
  // Of a sheet nobody knows; but this way and that it has no side.
  auto sheet = grid<T>(2, 1);
  CHECK_NOTHROW(GelLight<T>(sheet, {}));
  CHECK_NOTHROW(GelLight<T>(sheet, {.has_normals_inwards = true}));
  std::swap(sheet.faces[0][1], sheet.faces[0][2]);
  CHECK_THROWS_AS(GelLight<T>(sheet, {}), InvalidInput);
}
