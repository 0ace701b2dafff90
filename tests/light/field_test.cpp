#include "gelight/light/field.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "gelight/light/compact.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using gelight::CancelHook;
using gelight::dimmed;
using gelight::Falloff;
using gelight::InvalidInput;
using gelight::LightField;
using gelight::rectified;
using gelight::strength;
using gelight::Vec3;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

std::vector<double> strengths(std::vector<double> distances, Falloff<double> falloff) {
  return strength(std::span<const double>(distances), falloff);
}

}  // namespace

TEST_CASE("by default light does not fall off, out of reach there is none") {
  CHECK(strengths({0, 1e-9, 3, 1e9, inf}, {}) == std::vector<double>{1, 1, 1, 1, 0});
}

TEST_CASE("light spreads in inverse proportion to the distance and is absorbed exponentially") {
  CHECK(strengths({0, 0.5, 1, 2, 8}, {.full_within = 1}) ==
        std::vector<double>{1, 1, 1, 0.5, 0.125});
  const auto absorbed = strengths({0, 1, 2, inf}, {.absorption = 0.7});
  CHECK(absorbed[0] == 1);
  CHECK(absorbed[2] == gelight::test::approx(absorbed[1] * absorbed[1]).epsilon(1e-15));
  CHECK(absorbed[1] == gelight::test::approx(0.496585303791).epsilon(1e-12));
  CHECK(absorbed[3] == 0);
  const auto both = strengths({4}, {.full_within = 1, .absorption = 0.7});
  CHECK(both[0] == gelight::test::approx(std::exp(-2.8) / 4).epsilon(1e-15));
  CHECK_THROWS_AS(strengths({-1}, {}), InvalidInput);
  CHECK_THROWS_AS(strengths({not_a_number}, {}), InvalidInput);
  CHECK_THROWS_AS(strengths({1}, {.full_within = 0}), InvalidInput);
  CHECK_THROWS_AS(strengths({1}, {.absorption = -1}), InvalidInput);
  CHECK_THROWS_AS(strengths({1}, {.absorption = inf}), InvalidInput);
}

TEST_CASE("a dimmed field has the lengths of its strengths") {
  const LightField<double> field{{1, 0, 0}, {0, 0.6, 0.8}, {0, 0, 0}};
  const std::vector<double> shares{0.5, 0.25, 1};
  const auto weak = dimmed<double>(field, shares);
  CHECK(weak[0] == Vec3<double>(0.5, 0, 0));
  CHECK(weak[1].norm() == gelight::test::approx(0.25));
  CHECK(weak[2].isZero());
  CHECK_THROWS_AS((void)dimmed<double>(field, std::span(shares).first(2)), InvalidInput);
  for (const double bad : {-0.1, 1.5, not_a_number, inf}) {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      auto strengths = shares;
      strengths[i] = bad;
      CHECK_THROWS_AS((void)dimmed<double>(field, strengths), InvalidInput);
    }
  }
}

TEST_CASE("rectified directions are tangent, of unit length, nearest to what they were") {
  const LightField<double> field{{1, 0, 0}, {0.6, 0, 0.8}, {0, 0, 1}, {0, 0, 0}, {0, 0.5, -0.2}};
  const std::vector<Vec3<double>> normals{
      {0, 0, 1}, {0, 0, -3}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1e-200}};
  const auto flat = rectified<double>(field, normals);
  CHECK(flat[0] == Vec3<double>(1, 0, 0));
  CHECK((flat[1] - Vec3<double>(1, 0, 0)).norm() < 1e-15);
  CHECK(flat[2].isZero());  // along its normal
  CHECK(flat[3].isZero());
  CHECK((flat[4] - Vec3<double>(0, 1, 0)).norm() < 1e-15);
  const Vec3<double> slant = Vec3<double>(1, 2, -3).normalized();
  const auto along = rectified<double>({slant}, std::vector<Vec3<double>>{-7 * slant});
  CHECK(along[0].isZero());  // whatever rounding leaves
  CHECK_THROWS_AS((void)rectified<double>(field, std::span(normals).first(2)), InvalidInput);
  CHECK_THROWS_AS((void)rectified<double>({slant}, std::vector<Vec3<double>>{{0, 0, 0}}),
                  InvalidInput);
  CHECK_THROWS_AS((void)rectified<double>({slant}, std::vector<Vec3<double>>{{0, not_a_number, 0}}),
                  InvalidInput);
}

TEST_CASE_TEMPLATE("directions are rectified whatever their length", T, float, double) {
  const T least = std::numeric_limits<T>::min(), most = std::numeric_limits<T>::max() / 8;
  for (const T length : {least, std::sqrt(least) / 100, T(1), std::sqrt(most) * 100, most}) {
    const LightField<T> field{{3 * length, 0, 4 * length}, {0, 0, length}};
    const auto flat = rectified<T>(field, std::vector<Vec3<T>>(2, Vec3<T>(0, 0, 1)));
    CHECK(flat[0] == Vec3<T>(1, 0, 0));
    CHECK(flat[1].isZero(0));
  }
}

// Of these no direction was known, which is not the same as none.
TEST_CASE("places and directions that are not finite are refused") {
  const Vec3<double> good(1, 2, 3);
  const std::vector<Vec3<double>> fine(3, good);
  for (const double bad : {not_a_number, inf, -inf}) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3<double>> spoiled = fine;
      spoiled[2][axis] = bad;
      CHECK_THROWS_AS((void)gelight::linear_field<double>(good, spoiled), InvalidInput);
      CHECK_THROWS_AS((void)gelight::linear_field<double>(spoiled[2], fine), InvalidInput);
      CHECK_THROWS_AS((void)gelight::linear_rays<double>(fine, spoiled), InvalidInput);
      CHECK_THROWS_AS((void)gelight::linear_rays<double>(spoiled, fine), InvalidInput);
      CHECK_THROWS_AS((void)rectified<double>(spoiled, fine), InvalidInput);
    }
  }
}

TEST_CASE("between vertices without a direction or a distance that can be there is no light") {
  const gelight::Surface<double> face(
      gelight::Mesh<double>{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  const std::vector<gelight::SurfacePoint<double>> points{
      gelight::face_point<double>(0, {0.25, 0.25, 0.5})};
  const std::vector<Vec3<double>> directions(3, Vec3<double>(0, 1, 0));
  const std::vector<double> distances{0, 1, 2};
  const auto rays = gelight::rays_between_vertices<double>(face, directions, distances, points);
  CHECK(rays.direction[0] == Vec3<double>(0, 1, 0));
  CHECK(rays.distance[0] == 1.25);
  for (const double bad : {not_a_number, inf, -inf}) {
    auto spoiled = directions;
    spoiled[1][2] = bad;
    CHECK_THROWS_AS((void)gelight::rays_between_vertices<double>(face, spoiled, distances, points),
                    InvalidInput);
  }
  for (const double bad : {not_a_number, -1.0, -inf}) {
    auto spoiled = distances;
    spoiled[1] = bad;
    CHECK_THROWS_AS((void)gelight::rays_between_vertices<double>(face, directions, spoiled, points),
                    InvalidInput);
  }
  const std::vector<double> partly{0, 1, inf};
  const auto dark = gelight::rays_between_vertices<double>(face, directions, partly, points);
  CHECK(dark.lighting[0] == gelight::Lighting::dark);
}

namespace {

// What `work` computes must not depend on a hook; it tells a share that never decreases, up to 1,
// and it ends wherever the hook says so.
void check_hook(const auto& work) {
  const auto expected = work(CancelHook());
  std::vector<double> shares;
  const auto told = work(CancelHook([&](double done) {
    shares.push_back(done);
    return false;
  }));
  CHECK(told == expected);
  REQUIRE(shares.size() > 10);
  CHECK(std::is_sorted(shares.begin(), shares.end()));
  CHECK(shares.front() < 0.1);
  CHECK(shares.back() == 1);
  for (const std::size_t end : {std::size_t{1}, shares.size() / 2, shares.size()}) {
    std::size_t asked = 0;
    CHECK_THROWS_AS((void)work(CancelHook([&] { return ++asked == end; })), gelight::Cancelled);
    CHECK(asked == end);
  }
  CHECK(work(CancelHook()) == expected);
}

}  // namespace

TEST_CASE("whatever makes a field can be followed and cancelled") {
  const gelight::Surface surface(gelight::icosphere(3, 1.0));
  const auto led = gelight::vertex_point<double>(0), other = gelight::vertex_point<double>(5);
  const gelight::Source<double> source{led, 0};
  const std::vector leds{led, other};
  std::vector<gelight::SurfacePoint<double>> points = gelight::vertex_points(surface);
  LightField<double> positions;
  for (gelight::Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(gelight::face_point<double>(f, {0.2, 0.3, 0.5}));
  }
  for (const auto& point : points) positions.push_back(surface.position(point));
  const Vec3<double> place(0, 5, 0);
  const std::span<const Vec3<double>> places(positions);

  check_hook(
      [&](const CancelHook& hook) { return gelight::linear_field<double>(place, places, hook); });
  check_hook([&](const CancelHook& hook) {
    return gelight::linear_field<double>(surface, place, points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::linear_rays<double>(places.first(2), places, hook).direction;
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::plane_field<double>(surface, led, points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::plane_field<double>(surface, led, place, points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::plane_rays<double>(surface, leds, points, 1e-6, hook).direction;
  });

  const gelight::ExactSolver exact(surface);
  check_hook([&](const CancelHook& hook) {
    return gelight::geodesic_field<double>(exact, led, points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::geodesic_field<double>(exact, std::span(&source, 1), points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::geodesic_rays<double>(exact, led, points, 1e-6, hook).direction;
  });

  const gelight::VectorHeatSolver<double> heat(surface);
  const gelight::VectorSource<double> emission{led, place};
  check_hook([&](const CancelHook& hook) {
    return gelight::transport_field<double>(heat, 0, place, points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::transport_field<double>(heat, std::span(&emission, 1), points, hook);
  });
  check_hook([&](const CancelHook& hook) {
    return gelight::radial_transport_field<double>(heat, 0, points, hook);
  });
  const std::vector<double> distances = exact.distance(0);
  check_hook([&](const CancelHook& hook) {
    return gelight::rays_between_vertices<double>(surface, heat.radial(0), distances, points, hook)
        .direction;
  });

  const LightField<double> packable(positions.size(), Vec3<double>::UnitX());
  const LightField<double> normals(positions.size(), Vec3<double>::UnitZ());
  const auto compact = gelight::packed<double>(packable, normals);
  check_hook(
      [&](const CancelHook& hook) { return gelight::packed<double>(packable, normals, hook); });
  check_hook(
      [&](const CancelHook& hook) { return gelight::unpacked<double>(compact, normals, hook); });
}
