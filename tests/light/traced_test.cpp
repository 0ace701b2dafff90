#include "gelight/light/traced.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

namespace {

using namespace gelight;
constexpr double pi = std::numbers::pi;

// A square sheet about the z axis, normals upwards.
Surface<double> sheet(double side, double z, Index cells = 40) {
  return Surface<double>(placed<double>(grid<double>(cells, cells, side, side),
                                        Eigen::Matrix3d::Identity(), {-side / 2, -side / 2, z}));
}

double sum_of_shares(const LightBalance& b) { return b.coating + b.gel + b.lost + b.cut; }

// Share of light that a pane between two indices reflects, from Snell's angles.
double pane(double angle, double from, double to) {
  const double sine = from * std::sin(angle) / to;
  if (sine >= 1) return 1;
  const double beyond = std::asin(sine);
  if (angle == 0) return std::pow((from - to) / (from + to), 2);
  const double s = std::sin(angle - beyond) / std::sin(angle + beyond);
  const double t = std::tan(angle - beyond) / std::tan(angle + beyond);
  return (s * s + t * t) / 2;
}

// Shares of the vertices whose value is within one and two standard errors of the truth.
struct Within {
  int one = 0, two = 0, of = 0;
  double worst = 0;  // in standard errors
  void add(double value, double truth, double error) {
    const double off = std::abs(value - truth) / error;
    ++of, one += off < 1, two += off < 2;
    worst = std::max(worst, off);
  }
  // Normal errors would be 68 % and 95 %, never beyond 4.5 in this many.
  void check() const {
    REQUIRE(of > 100);
    CHECK(one > 0.6 * of);
    CHECK(one < 0.76 * of);
    CHECK(two > 0.91 * of);
    CHECK(worst < 6);
  }
};

// By far more points than a mesh has: the mean of a function over the faces at a vertex, weighted
// by its barycentric coordinate.
template <class F>
auto mean_around(const Surface<double>& surface, Index vertex, const F& f) {
  constexpr int n = 24;
  decltype(f(Vec3<double>())) sum = f(surface.position(vertex)) * 0;
  double weights = 0;
  for (const Index h : surface.corners(vertex)) {
    const double area = detail::face_normal(surface, h / 3).norm();
    const Vec3<double>&a = surface.position(vertex), &b = surface.position(surface.tip(h)),
          &c = surface.position(surface.apex(h));
    // The middles of n^2 equal triangles, those upside down among them.
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        for (const double third : {1.0, 2.0}) {
          if (third > 1 && i + j + 1 == n) continue;
          const double u = (i + third / 3) / n, v = (j + third / 3) / n;
          const double w = area * (1 - u - v);
          sum = sum + w * f((1 - u - v) * a + u * b + v * c);
          weights += w;
        }
      }
    }
  }
  return decltype(sum)(sum * (1 / weights));  // not an expression of what ends here
}

TEST_CASE("Philox is the published generator") {
  // The first and last of the answers that its authors give for testing.
  CHECK(detail::philox({0, 0, 0, 0}, {0, 0}) ==
        std::array<std::uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(
      detail::philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
      std::array<std::uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("gel that fills all: light goes straight and falls off with the square") {
  // At scales and offsets far from one.
  for (const auto& [scale, narrowness] : {std::pair{1e-6, 0.0}, {0.01, 1.0}, {1e6, 4.0}}) {
    const Vec3<double> offset = 30 * scale * Vec3<double>(1, -2, 3);
    const Surface<double> ceiling(placed<double>(grid<double>(16, 16, 4 * scale, 4 * scale),
                                                 Eigen::Matrix3d::Identity(),
                                                 offset + scale * Vec3<double>(-2, -2, 1)));
    const TracedLed led{
        .place = offset, .axis = Vec3<double>(0.3, 0.1, 1), .power = 7, .narrowness = narrowness};
    const LightTracer tracer(ceiling, {.albedo = 0});
    const auto light = tracer.trace(led, {.paths = 200'000, .seed = 5});
    const Vec3<double> axis = led.axis.normalized();
    const auto arriving = [&](const Vec3<double>& p) {
      const Vec3<double> way = p - offset, unit = way.normalized();
      const double cosine = std::max(0.0, unit.dot(axis));
      const double intensity =
          led.power * (led.narrowness + 1) / (2 * pi) * std::pow(cosine, led.narrowness);
      return Eigen::Vector4d(intensity * unit[2] / way.squaredNorm() *
                             Eigen::Vector4d(1, unit[0], unit[1], unit[2]));
    };
    Within irradiance, directed;
    for (Index v = 0; v < ceiling.vertex_count(); ++v) {
      const auto i = static_cast<std::size_t>(v);
      if (!(light.irradiance_error[i] < 0.1 * light.irradiance[i])) continue;
      const Eigen::Vector4d truth = mean_around(ceiling, v, arriving);
      const Vec3<double> way = truth.tail<3>();
      irradiance.add(light.irradiance[i], truth[0], light.irradiance_error[i]);
      directed.add(light.directed[i], way.norm() / truth[0], light.directed_error[i]);
      CHECK(light.direction[i].norm() == gelight::test::approx(1));
      const double angle = std::acos(std::min(1.0, light.direction[i].dot(way.normalized())));
      CHECK(angle < 5 * light.direction_error[i]);
      // The vector through the sheet is what the sheet gets.
      CHECK(light.vector[i][2] == gelight::test::approx(light.irradiance[i]).epsilon(1e-9));
    }
    irradiance.check();
    directed.check();
  }
}

TEST_CASE("a beam is reflected and let through by Fresnel, and totally beyond the critical angle") {
  const Surface<double> top = sheet(200, 1, 4);
  for (const double beneath_gel : {1.0, 1.33, 1.6}) {
    const std::vector<InnerLayer> layers{{sheet(200, 0, 4), beneath_gel}};
    const LightTracer tracer(top, {.index = 1.41, .albedo = 0}, layers);
    for (const double degrees : {0.0, 20.0, 40.0, 44.0, 46.0, 60.0, 80.0, 86.0}) {
      const double angle = degrees * pi / 180;
      const TracedLed led{
          .place = {0, 0, 0.5}, .axis = {std::sin(angle), 0, -std::cos(angle)}, .narrowness = 1e12};
      const auto light = tracer.trace(led, {.paths = 10'000});
      const double truth = pane(angle, 1.41, beneath_gel);
      CAPTURE(beneath_gel);
      CAPTURE(degrees);
      // Four standard errors of so many coins; the beam is a few millionths wide.
      const double chance = 4 * std::sqrt(truth * (1 - truth) / 10'000) + 1e-4;
      CHECK(std::abs(light.balance.coating - truth) <= chance);
      CHECK(std::abs(light.balance.lost - (1 - truth)) <= chance);
      CHECK(sum_of_shares(light.balance) == gelight::test::approx(1).epsilon(1e-12));
    }
  }
}

TEST_CASE("light leaves a layer at the angle of Snell's law, and comes in again behind it") {
  // Gel, a gap of air, and gel: the beam that crosses arrives displaced, not turned.
  const double angle = 0.5;
  const Surface<double> top = sheet(10, 3, 200);
  const std::vector<InnerLayer> layers{{sheet(10, 2), 1.0}, {sheet(10, 1), 1.6}};
  const LightTracer tracer(top, {.index = 1.41, .albedo = 0}, layers);
  const TracedLed led{.place = {0, 0, 0},
                      .axis = {std::sin(angle), 0, std::cos(angle)},
                      .narrowness = 1e12,
                      .layer = 2};
  const auto light = tracer.trace(led, {.paths = 4000});
  const double in_air = std::asin(1.6 * std::sin(angle));
  const double in_gel = std::asin(std::sin(in_air) / 1.41);
  const double x = std::tan(angle) + std::tan(in_air) + std::tan(in_gel);
  const auto middle = static_cast<std::size_t>(nearest_vertex<double>(top, {x, 0, 3}));
  REQUIRE(light.irradiance[middle] > 0);
  const Vec3<double> truth(std::sin(in_gel), 0, std::cos(in_gel));
  // Every ray is parallel, also those that went to and fro in the gap.
  CHECK((light.direction[middle] - truth).norm() < 1e-5);
  CHECK(light.directed[middle] == gelight::test::approx(1).epsilon(1e-9));
  Vec3<double> centre(0, 0, 0);
  double power = 0;
  for (const Index v : {nearest_vertex<double>(top, {x, 0, 3})}) {
    for (const Index h : top.corners(v)) {
      const Index w = top.tip(h);
      centre += light.irradiance[static_cast<std::size_t>(w)] * top.position(w);
      power += light.irradiance[static_cast<std::size_t>(w)];
    }
    centre += light.irradiance[middle] * top.position(v);
    power += light.irradiance[middle];
  }
  CHECK(centre[0] / power == gelight::test::approx(x).epsilon(2e-3));
}

TEST_CASE("a flat slab over air: the LED and its mirror image") {
  constexpr double h = 1, index = 1.41;
  const Surface<double> top = sheet(12, h, 24);
  const std::vector<InnerLayer> layers{{sheet(40, 0, 4), 1.0}};
  const LightTracer tracer(top, {.index = index, .absorption = 0.1, .albedo = 0}, layers);
  const TracedLed led{.place = {0, 0, 0.4}, .axis = {1, 0, 0}};
  const auto light = tracer.trace(led, {.paths = 200'000});
  Within within;
  for (Index v = 0; v < top.vertex_count(); ++v) {
    const Vec3<double>& at = top.position(v);
    if (std::abs(at[0]) > 5.6 || at[0] < 0.9 || std::abs(at[1]) > 5.6) continue;
    const auto arriving = [&](const Vec3<double>& p) {
      double sum = 0;
      for (const double z : {0.4, -0.4}) {
        const Vec3<double> way = p - Vec3<double>(0, 0, z);
        const double d = way.norm(), cosine = way[2] / d;
        const double left = z > 0 ? 1 : pane(std::acos(cosine), index, 1);
        sum += left * std::exp(-0.1 * d) * way[0] / d / pi * cosine / (d * d);
      }
      return sum;
    };
    const auto i = static_cast<std::size_t>(v);
    within.add(light.irradiance[i], mean_around(top, v, arriving), light.irradiance_error[i]);
  }
  within.check();
}

TEST_CASE("an integrating sphere: the same light everywhere, 1 / (1 - albedo) times the first") {
  constexpr double radius = 0.02;
  const Surface<double> ball(icosphere<double>(3, radius));
  const double wall = 4 * pi * radius * radius;
  for (const double albedo : {0.0, 0.5, 0.9}) {
    const LightTracer tracer(ball, {.albedo = albedo});
    const TracedLed led{.place = {0, 0, -0.9995 * radius}, .axis = {0, 0, 1}, .power = 3};
    const auto light = tracer.trace(led, {.paths = 20'000});
    Within within;
    for (Index v = 0; v < ball.vertex_count(); ++v) {
      const auto i = static_cast<std::size_t>(v);
      if (ball.position(v)[2] < -0.8 * radius) continue;  // the LED is not quite in the wall
      within.add(light.irradiance[i], 3 / wall / (1 - albedo), light.irradiance_error[i]);
    }
    within.check();
    CHECK(std::abs(sum_of_shares(light.balance) - 1) < 5e-3);
    CHECK(light.balance.lost < 1e-4);
  }
}

TEST_CASE("what one spot of an integrating sphere reflects lights all of it alike") {
  const Surface<double> ball(icosphere<double>(3, 1.0));
  for (const double albedo : {0.3, 0.8}) {
    const LightTracer tracer(ball, {.albedo = albedo});
    // A beam from the middle into the middle of a face, which is not quite on the sphere.
    const auto light = tracer.trace({.axis = {0.1, 0.2, 1}, .narrowness = 1e12}, {.paths = 40'000});
    Within within;
    for (Index v = 0; v < ball.vertex_count(); ++v) {
      const auto i = static_cast<std::size_t>(v);
      if (ball.position(v)[2] > 0.7) continue;
      within.add(light.irradiance[i], albedo / (1 - albedo) / (4 * pi), light.irradiance_error[i]);
    }
    within.check();
  }
}

TEST_CASE("absorption along the chords of a sphere") {
  // A Lambertian point hardly off the wall sends rays at a cosine c to its axis with density 2 c.
  const double place = 0.998;
  const auto way = [&](double c) { return place * c + std::sqrt(1 - place * place * (1 - c * c)); };
  const Surface<double> ball(icosphere<double>(5, 1.0));
  for (const double absorption : {0.1, 1.0, 5.0}) {
    const LightTracer tracer(ball, {.absorption = absorption, .albedo = 0});
    const auto light =
        tracer.trace({.place = {0, 0, -place}, .axis = {0, 0, 1}}, {.paths = 40'000});
    double left = 0;
    for (int i = 0; i < 10'000; ++i) {
      const double c = (i + 0.5) / 10'000;
      left += 2 * c * std::exp(-absorption * way(c)) / 10'000;
    }
    const double deviation = std::sqrt(left * (1 - left) / 40'000);  // of so many paths
    CHECK(std::abs(light.balance.coating - left) < 3 * deviation);
    CHECK(light.balance.coating + light.balance.gel == gelight::test::approx(1).epsilon(1e-4));
  }
}

TEST_CASE("paths one by one: the corners of Snell's law, and the very ones that are traced") {
  const double angle = 0.5;
  const std::vector<InnerLayer> layers{{sheet(10, 2), 1.0}, {sheet(10, 1), 1.6}};
  const LightTracer tracer(sheet(10, 3), {.index = 1.41, .albedo = 0}, layers);
  const TracedLed led{.place = {0, 0, 0},
                      .axis = {std::sin(angle), 0, std::cos(angle)},
                      .narrowness = 1e12,
                      .layer = 2};
  const TraceOptions options{.paths = 640, .seed = 7};
  const auto paths = tracer.paths(led, options);
  REQUIRE(paths.size() == 640);
  const double in_air = std::asin(1.6 * std::sin(angle));
  const double in_gel = std::asin(std::sin(in_air) / 1.41);
  const std::vector<double> to_x{0, std::tan(angle), std::tan(in_air), std::tan(in_gel)};
  double lost = 0, pieces = 0;
  int direct = 0;
  for (const auto& path : paths) {
    REQUIRE(path.places.size() == path.layers.size() + 1);
    lost += path.is_lost, pieces += double(path.layers.size()) + path.is_lost;
    CHECK(path.is_lost == (path.places.back()[2] < 2.5));  // or it ended on the coating
    if (path.layers != std::vector<Index>{2, 1, 0}) continue;
    ++direct;
    double x = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      x += to_x[k];
      CHECK((path.places[k] - Vec3<double>(x, 0, double(k))).norm() < 1e-4);
    }
  }
  CHECK(direct > 400);  // the first two panes let 0.92 and 0.89 of it through
  const auto light = tracer.trace(led, options);
  CHECK(light.balance.lost == gelight::test::approx(lost / 640).epsilon(1e-12));
  CHECK(light.balance.segments == pieces);
}

TEST_CASE("closed gel without absorption: all light ends in the coating, whatever is inside") {
  const Surface<double> ball(icosphere<double>(4, 1.0));
  for (const double inside : {1.0, 1.41, 1.6}) {
    for (const double albedo : {0.0, 0.7}) {
      const std::vector<InnerLayer> layers{{beneath(ball, 0.2), inside}};
      const LightTracer tracer(ball, {.albedo = albedo}, layers);
      const auto light = tracer.trace({.place = {0, 0, -0.9}, .axis = {1, 0, 0.2}, .radius = 0.05},
                                      {.paths = 10'000});
      CAPTURE(inside);
      CHECK(light.balance.lost < 2e-4);
      CHECK(light.balance.cut < 1e-3);
      CHECK(std::abs(light.balance.coating - 1) < 5 * light.balance_error.coating + 1e-3);
      // What the coating absorbs is a share 1 - albedo of what arrives.
      double arriving = 0;
      for (Index v = 0; v < ball.vertex_count(); ++v) {
        double area = 0;
        for (const Index h : ball.corners(v)) {
          area += detail::face_normal(ball, h / 3).norm() / 6;
        }
        arriving += area * light.irradiance[static_cast<std::size_t>(v)];
      }
      CHECK((1 - albedo) * arriving == gelight::test::approx(light.balance.coating).epsilon(1e-9));
    }
  }
}

TEST_CASE("reciprocity: two small Lambertian discs light each other alike") {
  const Surface<double> tip(membrane<double>(1, 3, 0.3));
  // Flat discs on two faces of a shell, with air inside or a core.
  const auto on_face = [&](const Vec3<double>& near) {
    Index best = 0;
    for (Index f = 0; f < tip.face_count(); ++f) {
      const auto distance = [&](Index g) {
        const auto [a, b, c] = tip.face(g);
        return (tip.position(a) + tip.position(b) + tip.position(c) - 3 * near).norm();
      };
      if (distance(f) < distance(best)) best = f;
    }
    return best;
  };
  const Index a = on_face({1, 0, 1}), b = on_face({-0.6, 0.5, 1.9}), c = on_face({0, 1, 0.4});
  // The power that arrives at a face, from a mesh in which the face's corners are its own: a share
  // of what its vertices get would be of its neighbours, too.
  const auto arriving = [&](Index from, Index to, const GelOptics& gel, double inside) {
    Mesh<double> mesh;
    for (Index v = 0; v < tip.vertex_count(); ++v) {
      const auto& p = tip.position(v);
      mesh.positions.push_back({p[0], p[1], p[2]});
    }
    for (Index f = 0; f < tip.face_count(); ++f) mesh.faces.push_back(tip.face(f));
    for (Index& v : mesh.faces[static_cast<std::size_t>(to)]) {
      mesh.positions.push_back(mesh.positions[static_cast<std::size_t>(v)]);
      v = static_cast<Index>(mesh.positions.size()) - 1;
    }
    const std::vector<InnerLayer> layers{{beneath(tip, 0.2), inside}};
    const LightTracer tracer(Surface<double>(mesh), gel, layers);
    const auto [i, j, k] = tip.face(from);
    const Vec3<double> normal = detail::face_normal(tip, from);
    const TracedLed led{.place = (tip.position(i) + tip.position(j) + tip.position(k)) / 3 -
                                 1e-4 * normal.normalized(),
                        .axis = -normal,
                        .radius = 0.08};
    const auto light = tracer.trace(led, {.paths = 40'000});
    double power = 0, variance = 0;
    for (std::size_t v = mesh.positions.size() - 3; v < mesh.positions.size(); ++v) {
      power += light.irradiance[v] / 3, variance += std::pow(light.irradiance_error[v] / 3, 2);
    }
    return std::pair{power, std::sqrt(3 * variance)};  // neighbours' errors are not independent
  };
  for (const double inside : {1.0, 1.6}) {
    for (const auto& [from, to] : {std::pair{a, b}, {a, c}}) {
      const GelOptics gel{.absorption = 0.3, .albedo = 0.6};
      const auto there = arriving(from, to, gel, inside), back = arriving(to, from, gel, inside);
      CHECK(there.first > 5 * there.second);
      CHECK(std::abs(there.first - back.first) < 4 * std::hypot(there.second, back.second));
    }
  }
}

TEST_CASE("vertices without a face, wherever they are, change nothing") {
  const auto ball = icosphere<double>(2, 1.0), core = icosphere<double>(2, 0.5);
  const TracedLed led{.place = {0, 0, 0.7}};
  const TraceOptions options{.paths = 2000};
  const auto truth =
      LightTracer(Surface<double>(ball), {}, std::vector<InnerLayer>{{Surface<double>(core)}})
          .trace(led, options);
  for (const double far : {2.0, 1e6, -1e20}) {
    auto ball_and_point = ball, core_and_point = core;
    ball_and_point.positions.push_back({far, 0, 0});
    core_and_point.positions.push_back({0, far, 0});
    const std::vector<InnerLayer> layers{{Surface<double>(core_and_point)}};
    auto light = LightTracer(Surface<double>(ball_and_point), {}, layers).trace(led, options);
    CHECK(light.irradiance.back() == 0);
    light.irradiance.pop_back();
    CHECK(light.irradiance == truth.irradiance);
    CHECK(light.balance.lost == truth.balance.lost);
  }
}

TEST_CASE("the air before a rim narrows light to the critical angle") {
  // A wall far away, all of which is lit within asin(1 / index) only.
  const Surface<double> wall = sheet(4, 1, 40);
  const LightTracer tracer(wall, {.index = 1.41, .albedo = 0});
  const auto light = tracer.trace({.axis = {0, 0, 1}, .behind_air = true}, {.paths = 200'000});
  const double edge = std::tan(std::asin(1 / 1.41));
  for (Index v = 0; v < wall.vertex_count(); ++v) {
    const double r = wall.position(v).head<2>().norm();
    if (r > edge + 0.15) CHECK(light.irradiance[static_cast<std::size_t>(v)] == 0);
  }
  // Lambertian light through a pane: the mean of Fresnel's share, weighted by the cosine.
  double reflected = 0;
  constexpr int steps = 100'000;
  for (int i = 0; i < steps; ++i) {
    reflected += pane(std::asin(std::sqrt((i + 0.5) / steps)), 1, 1.41) / steps;
  }
  CHECK(light.balance.lost == gelight::test::approx(reflected).epsilon(0.01));
  CHECK(light.balance.coating == gelight::test::approx(1 - reflected).epsilon(0.001));
}

TEST_CASE("the same bits on any number of threads, others with another seed") {
  const Surface<double> tip(membrane<double>(1, 3, 0.2));
  const std::vector<InnerLayer> layers{{beneath(tip, 0.2)}};
  const LightTracer tracer(tip, {}, layers);
  const TracedLed led{.place = {0.9, 0, 0.01}, .axis = {0, 0, 1}, .radius = 0.05};
  const auto one = tracer.trace(led, {.paths = 4'000, .threads = 1});
  for (const unsigned threads : {2u, 3u, 7u, 40u}) {
    const auto other =
        LightTracer(tip, {}, layers).trace(led, {.paths = 4'000, .threads = threads});
    CHECK(other.irradiance == one.irradiance);
    CHECK(other.direction == one.direction);
    CHECK(other.vector == one.vector);
    CHECK(other.directed_error == one.directed_error);
    CHECK(other.balance.lost == one.balance.lost);
  }
  const auto other = tracer.trace(led, {.paths = 4'000, .seed = 2});
  CHECK(other.irradiance != one.irradiance);
}

TEST_CASE("standard errors are those of many seeds") {
  const Surface<double> tip(membrane<double>(1, 3, 0.4));
  const std::vector<InnerLayer> layers{{beneath(tip, 0.2)}};
  const LightTracer tracer(tip, {}, layers);
  const TracedLed led{.place = {0.9, 0, 0.01}, .axis = {0, 0, 1}, .radius = 0.05};
  const auto best = tracer.trace(led, {.paths = 200'000, .seed = 77});
  Within irradiance, directed, balance;
  int direction = 0, directions = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const auto light = tracer.trace(led, {.paths = 2'500, .seed = seed});
    balance.add(light.balance.coating, best.balance.coating, light.balance_error.coating);
    for (std::size_t v = 0; v < light.irradiance.size(); v += 7) {
      if (best.irradiance_error[v] > 0.02 * best.irradiance[v]) continue;
      irradiance.add(light.irradiance[v], best.irradiance[v], light.irradiance_error[v]);
      directed.add(light.directed[v], best.directed[v], light.directed_error[v]);
      const double angle = std::acos(std::min(1.0, light.direction[v].dot(best.direction[v])));
      // Two numbers err, so that 63 % are within one.
      direction += angle < light.direction_error[v];
      ++directions;
    }
  }
  irradiance.check();
  CHECK(directed.one > 0.6 * directed.of);
  CHECK(directed.one < 0.76 * directed.of);
  CHECK(direction > 0.55 * directions);
  CHECK(direction < 0.72 * directions);
  CHECK(balance.worst < 4.5);
}

TEST_CASE("what is no sensor is refused") {
  const Surface<double> tip(membrane<double>(1, 3, 0.2));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {-0.1, 1.1, nan}) {
    CHECK_THROWS_AS(LightTracer(tip, {.albedo = bad}), InvalidInput);
  }
  for (const double bad : {0.0, -1.0, nan, unreachable<double>}) {
    CHECK_THROWS_AS(LightTracer(tip, {.index = bad}), InvalidInput);
    const std::vector<InnerLayer> layers{{tip, bad}};
    CHECK_THROWS_AS(LightTracer(tip, {}, layers), InvalidInput);
    CHECK_THROWS_AS((void)beneath(tip, bad), InvalidInput);
  }
  CHECK_THROWS_AS(LightTracer(tip, {.absorption = -1}), InvalidInput);
  CHECK_THROWS_AS((void)beneath(tip, 1.05), InvalidInput);  // beyond the axis
  const LightTracer tracer(tip, {});
  CHECK_THROWS_AS((void)tracer.trace({.place = {nan, 0, 0}}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.trace({.axis = {0, 0, 0}}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.trace({.radius = -1}), InvalidInput);
  for (const double far : {1e6, 1e39, 1e300}) {
    CHECK_THROWS_AS((void)tracer.trace({.place = {0, far, 0}}), InvalidInput);
    CHECK_THROWS_AS((void)tracer.paths({.place = {-far, 0, 0}}), InvalidInput);
    CHECK_THROWS_AS((void)tracer.trace({.radius = far}), InvalidInput);
  }
  // Nothing is hit of surfaces without an extent, wherever the LED is.
  const Surface<double> point(Mesh<double>{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}}});
  CHECK(LightTracer(point, {}).trace({.place = {0, 0, 1}}, {.paths = 100}).balance.lost == 1);
  CHECK(tracer.trace({.place = {0, 0, 1e3}, .axis = {0, 0, 1}}, {.paths = 100}).balance.lost == 1);
  CHECK_THROWS_AS((void)tracer.trace({.narrowness = 1e300, .behind_air = true}), InvalidInput);
  CHECK_THROWS_AS(LightTracer(tip, {.index = 1e-300}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.trace({.power = nan}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.trace({.narrowness = -1}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.trace({.layer = 1}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.trace({}, {.paths = 0}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.paths({}, {.paths = 0}), InvalidInput);
  CHECK_THROWS_AS((void)tracer.paths({.place = {nan, 0, 0}}), InvalidInput);
}

TEST_CASE("the hook cancels, and follows in shares that never decrease") {
  const Surface<double> tip(membrane<double>(1, 3, 0.2));
  const LightTracer tracer(tip, {});
  const TracedLed led{.place = {0, 0, 0.5}};
  for (const unsigned threads : {1u, 4u}) {
    double last = 0;
    int asked = 0;
    (void)tracer.trace(led, {.paths = 50'000, .threads = threads, .cancelled = [&](double done) {
                               CHECK(done >= last);
                               last = done, ++asked;
                               return false;
                             }});
    CHECK(last == 1);
    CHECK(asked > 10);
    asked = 0;
    CHECK_THROWS_AS(
        (void)tracer.trace(
            led, {.paths = 1 << 30, .threads = threads, .cancelled = [&] { return ++asked == 5; }}),
        Cancelled);
    CHECK(asked == 5);
  }
}

}  // namespace
