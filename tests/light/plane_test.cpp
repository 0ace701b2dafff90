#include "gelight/light/plane.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "gelight/light/plane/plane_cut.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"

using gelight::Index;
using gelight::plane_field;
using gelight::Surface;
using gelight::SurfacePoint;
using gelight::Vec3;
using gelight::vertex_point;
namespace test = gelight::test;

namespace {

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(gelight::cross(a, b).norm(), a.dot(b));
}

std::vector<SurfacePoint<double>> centroids(const Surface<double>& surface) {
  std::vector<SurfacePoint<double>> points;
  for (Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(gelight::face_point<double>(f, {1. / 3, 1. / 3, 1. / 3}));
  }
  return points;
}

// Largest angle to the great circle's tangent over the vertices of an icosphere.
double worst_on_sphere(int level) {
  const Surface surface(gelight::icosphere(level, 1.0));
  const Index led = 7;
  const Vec3<double> s = surface.position(led);
  const auto field =
      plane_field<double>(surface, vertex_point<double>(led), gelight::vertex_points(surface));
  double worst = 0;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const Vec3<double> p = surface.position(v);
    if (gelight::cross(s, p).norm() < 0.3) continue;  // at both poles the direction turns fast
    const Vec3<double> truth = (-s + s.dot(p) * p).normalized();
    worst = std::max(worst, angle(field[static_cast<std::size_t>(v)], truth));
  }
  return worst;
}

// A point as near to a corner or a side of its face as the share says.
template <class T>
SurfacePoint<T> point_near_corner_or_side(const Surface<T>& surface, double share,
                                          test::Random& random) {
  std::array<double, 3> weights{1 - share, 0.3 * share, 0.7 * share};
  if (test::uniform(random, 0, 1) < 0.3) weights = {0.4 * (1 - share), 0.6 * (1 - share), share};
  std::rotate(weights.begin(), weights.begin() + test::uniform_index(random, 3), weights.end());
  std::array<T, 3> w{T(weights[0]), T(weights[1]), T(weights[2])};
  const T sum = w[0] + w[1] + w[2];
  for (T& x : w) x /= sum;
  return gelight::face_point<T>(test::uniform_index(random, surface.face_count()), w);
}

// Light over flat sheets turned in space, at points next to corners and sides: how far it is at
// most from the straight line.
template <class T>
double worst_next_to_corners(double scale, unsigned seed) {
  test::Random random(seed);
  gelight::Mesh<T> sheet;
  const auto flat = test::jittered_grid(5, 0.2, random);
  const Eigen::AngleAxisd turn(test::uniform(random, 0, 3), Vec3<double>(1, 2, 3).normalized());
  for (const auto& p : flat.positions) {
    const Vec3<double> q = scale * (turn * Vec3<double>(p.data()));
    sheet.positions.push_back({T(q[0]), T(q[1]), T(q[2])});
  }
  sheet.faces = flat.faces;
  const Surface<T> surface(sheet);
  const auto led = gelight::face_point<T>(test::uniform_index(random, surface.face_count()),
                                          {T(0.5), T(0.25), T(0.25)});
  std::vector<SurfacePoint<T>> points;
  for (double share = 1e-2; share > 1e-18; share /= 3) {
    for (int i = 0; i < 6; ++i) points.push_back(point_near_corner_or_side(surface, share, random));
  }
  const auto field = plane_field(surface, led, points);
  const auto rays = gelight::plane_rays<T>(surface, {&led, 1}, points);
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<T> way = surface.position(points[i]) - surface.position(led);
    if (way.norm() < T(0.3 * scale)) continue;
    for (const Vec3<T>& direction : {field[i], rays.direction[i]}) {
      worst = std::max(worst, double{(direction - way.normalized()).norm()});
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("on a sphere the plane field follows great circles, better with every refinement") {
  const double coarse = worst_on_sphere(3), fine = worst_on_sphere(5);
  CHECK(fine < 0.05);
  CHECK(fine < coarse / 3);
}

TEST_CASE("on any surface it is a unit vector in the face and in the cutting plane") {
  const Surface surface(gelight::torus(2.0, 0.7, 60, 31));
  const Index led = 17;
  Vec3<double> normal = Vec3<double>::Zero();
  for (const Index h : surface.corners(led)) {
    normal += gelight::detail::face_normal(surface, surface.face_of(h));
  }
  const auto points = centroids(surface);
  const auto field = plane_field<double>(surface, vertex_point<double>(led), points);
  Index lit = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (field[i].isZero()) continue;
    ++lit;
    const Vec3<double> to_point = surface.position(points[i]) - surface.position(led);
    const Vec3<double> plane = gelight::cross<double>(normal, to_point).normalized();
    const Vec3<double> face =
        gelight::detail::face_normal(surface, static_cast<Index>(i)).normalized();
    CHECK(field[i].norm() == gelight::test::approx(1).epsilon(1e-14));
    CHECK(std::abs(field[i].dot(plane)) < 1e-12);
    CHECK(std::abs(field[i].dot(face)) < 1e-12);
  }
  // Every cut of a closed surface comes back to the LED. Where it is in two loops, some points
  // stand on the one that does not hold the LED.
  CHECK(lit > static_cast<Index>(points.size()) / 2);
}

TEST_CASE("of the two arcs round a cylinder the shorter one arrives") {
  // A prism of 100 sides and a height of 10 radii: cut at the LED's own height, the arcs run round
  // it on both sides; the light leaves the LED at angle 0 either way and meets at angle pi.
  const double radius = 1;
  std::vector<gelight::ProfilePoint<double>> wall;
  for (int i = 0; i <= 40; ++i) wall.push_back({radius, -5 + 0.25 * i});
  const auto mesh = gelight::revolve<double>(wall, 2 * std::numbers::pi / 100);
  const Surface surface(mesh);
  Index led = 0;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const Vec3<double> to_led(radius, 0, 0);
    if ((surface.position(v) - to_led).norm() < (surface.position(led) - to_led).norm()) led = v;
  }
  const auto points = centroids(surface);
  const auto field = plane_field<double>(surface, vertex_point<double>(led), points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> p = surface.position(points[i]);
    const double theta = std::atan2(p[1], p[0]);
    // Nearer to theta = pi the cut is so steep that both arcs leave the cylinder.
    if (std::abs(p[2]) > 1 || std::abs(theta) < 0.3 || std::abs(theta) > 2.5) continue;
    const double around = Vec3<double>(-std::sin(theta), std::cos(theta), 0).dot(field[i]);
    CHECK(around * theta > 0);
  }
}

TEST_CASE("inside the LED's own faces the light travels straight, and at the LED it has no way") {
  const Surface surface(gelight::grid(4, 4, 1.0, 1.0));
  const auto led = gelight::face_point<double>(10, {0.5, 0.25, 0.25});
  const std::vector<SurfacePoint<double>> points{
      led, gelight::face_point<double>(10, {0.25, 0.5, 0.25})};
  const auto field = plane_field<double>(surface, led, points);
  CHECK(field[0].isZero());
  const Vec3<double> straight = surface.position(points[1]) - surface.position(led);
  CHECK(angle(field[1], straight) < 1e-14);
}

TEST_CASE("on a flat sheet every field line is straight, whatever vertices the plane meets") {
  const Surface surface(gelight::grid(8, 8, 1.0, 1.0));
  const Index led = 4 * 9 + 4;  // many vertices lie exactly on the same lines through it
  const auto points = gelight::vertex_points(surface);
  const auto field = plane_field<double>(surface, vertex_point<double>(led), points);
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    if (v == led) continue;
    const Vec3<double> straight = surface.position(v) - surface.position(led);
    CAPTURE(v);
    CHECK(field[static_cast<std::size_t>(v)].norm() == gelight::test::approx(1));
    CHECK(angle(field[static_cast<std::size_t>(v)], straight) < 1e-12);
  }
}

namespace {

// A sphere with bumps, on whose side away from the LED curves part and join.
Surface<double> bumpy(int level) {
  auto mesh = gelight::icosphere(level, 1.0);
  for (auto& p : mesh.positions) {
    const double r = 1 + 0.15 * std::sin(7 * p[0]) * std::sin(6 * p[1] + 1) * std::cos(5 * p[2]);
    p = {r * p[0], r * p[1], r * p[2]};
  }
  return Surface(mesh);
}

std::vector<SurfacePoint<double>> points_in_faces(const Surface<double>& surface) {
  std::vector<SurfacePoint<double>> points;
  for (Index f = 0; f < surface.face_count(); ++f) {
    points.push_back(gelight::face_point<double>(f, {1. / 3, 1. / 3, 1. / 3}));
    points.push_back(gelight::face_point<double>(f, {0.9, 0.04, 0.06}));
    points.push_back(gelight::face_point<double>(f, {0.02, 0.5, 0.48}));
  }
  return points;
}

Vec3<double> normal_at(const Surface<double>& surface, Index v) {
  Vec3<double> normal = Vec3<double>::Zero();
  for (const Index h : surface.corners(v)) {
    normal += gelight::detail::face_normal(surface, Surface<double>::face_of(h));
  }
  return normal;
}

}  // namespace

// A plane cuts but a corner off there, of a length whose ends rounding moves as much.
TEST_CASE("light next to corners and sides of faces has the direction of light in them") {
  for (const double scale : {1e-5, 1.0, 1e4}) {
    for (unsigned seed = 0; seed < 8; ++seed) {
      CAPTURE(scale);
      CAPTURE(seed);
      CHECK(worst_next_to_corners<double>(scale, seed) < 1e-9);
      CHECK(worst_next_to_corners<float>(scale, seed) < 8e-4);
    }
  }
}

TEST_CASE("what is told of whole faces is what each point's own plane says") {
  std::vector<Surface<double>> surfaces{Surface(gelight::icosphere(4, 1.0)),
                                        bumpy(4),
                                        Surface(gelight::torus(2.0, 0.7, 60, 31)),
                                        Surface(gelight::membrane(0.01146, 0.0455, 0.0015)),
                                        Surface(gelight::box(1.0, 2.0, 3.0)),
                                        Surface(gelight::grid(20, 30, 1.0, 2.0))};
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    const auto& surface = surfaces[s];
    const auto points = points_in_faces(surface);
    for (const Index led : {Index{3}, surface.vertex_count() / 2, surface.vertex_count() - 1}) {
      CAPTURE(s);
      CAPTURE(led);
      const auto at = vertex_point<double>(led);
      const auto field = plane_field<double>(surface, at, points);
      gelight::detail::PlaneCut<double> cut(surface, at, normal_at(surface, led));
      int wrong = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& arrivals = cut.arrive(points[i], cut.local(surface.position(points[i])));
        if (arrivals.empty()) {
          wrong += !field[i].isZero();
          continue;
        }
        const bool is_tie =
            arrivals.size() > 1 && arrivals[1].length < (1 + 1e-12) * arrivals[0].length;
        // A cut that grazes its face in a corner has few digits.
        if (!is_tie) wrong += !(angle(field[i], cut.in_space(arrivals[0].direction)) < 1e-6);
      }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("a flipped face changes nothing") {
  auto flipped = gelight::icosphere(2, 1.0);
  std::swap(flipped.faces[100][0], flipped.faces[100][1]);
  const Surface surface(flipped), sound(gelight::icosphere(2, 1.0));
  const auto points = centroids(surface);
  const auto led = vertex_point<double>(7);
  const auto field = plane_field<double>(surface, led, points);
  const auto expected = plane_field<double>(sound, led, points);
  for (std::size_t i = 0; i < points.size(); ++i) CHECK(angle(field[i], expected[i]) < 1e-9);
}

TEST_CASE(
    "on a cylinder the field is tangent to the ellipses that the planes cut, to first order") {
  std::array<double, 2> worst{};
  for (const int level : {0, 1}) {
    const int sides = 60 << level;
    std::vector<gelight::ProfilePoint<double>> wall;
    for (int i = 0; i <= sides; ++i) wall.push_back({1, 6.0 * i / sides - 3});
    const Surface surface(gelight::revolve<double>(wall, 2 * std::numbers::pi / sides));
    const Index led = gelight::nearest_vertex<double>(surface, {1, 0, 0});
    const Vec3<double> s = surface.position(led);
    const auto points = centroids(surface);
    // The normal is the cylinder's; the mean of the faces' need not be quite that.
    const auto field = plane_field<double>(surface, vertex_point<double>(led), {1, 0, 0}, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3<double> p = surface.position(points[i]);
      const double turn = std::atan2(p[1], p[0]);
      // Steeper planes leave the cylinder before they have come round.
      if (std::abs(turn) < 0.3 || std::abs(turn) > 2.8 || std::abs(p[2] - s[2]) > 0.9) continue;
      const Vec3<double> out(std::cos(turn), std::sin(turn), 0);
      const Vec3<double> plane = gelight::cross<double>(p - s, {1, 0, 0});
      Vec3<double> truth = gelight::cross(out, plane).normalized();
      if (truth.dot(Vec3<double>(-std::sin(turn), std::cos(turn), 0)) * turn < 0) truth = -truth;
      auto& most = worst[static_cast<std::size_t>(level)];
      most = std::max(most, angle(field[i], truth));
    }
  }
  MESSAGE("largest angle " << worst[0] << ", with half the edges " << worst[1] << " radians");
  CHECK(worst[0] < 0.1);
  CHECK(worst[1] < 0.55 * worst[0]);
}

namespace {

// A sheet of n x m cells, folded up along x = `crease`, turned, scaled and moved; its LED stands in
// front of the crease. Light comes along y = const and along the crease, whatever the fold.
template <class T>
struct FoldedSheet {
  Surface<T> surface;
  Eigen::Matrix3d turn;
  double crease, slope, edge, far;  // the last: by how much rounding may turn a direction

  FoldedSheet(Index n, Index m, double fold, test::Random& random)
      : FoldedSheet(n, m, fold, test::uniform(random, -1, 1), random) {}
  FoldedSheet(Index n, Index m, double fold, double size, test::Random& random)
      : surface(gelight::Mesh<T>{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}) {
    gelight::Mesh<double> mesh = gelight::grid<double>(n, m, 1.0, double(m) / n);
    crease = std::ceil(n / 2.0) / n;
    slope = fold;
    const double scale = std::pow(10, 6 * size);
    edge = scale / n;
    Eigen::Vector4d q;
    for (int k = 0; k < 4; ++k) q[k] = test::uniform(random, -1, 1);
    turn = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
    if (test::uniform(random, 0, 1) < 0.3) turn.setIdentity();
    const double offset =
        test::uniform(random, 0, 1) < 0.5
            ? 0
            : edge * std::pow(10, test::uniform(random, 0, sizeof(T) == 4 ? 2 : 6));
    gelight::Mesh<T> moved;
    moved.faces = mesh.faces;
    for (const auto& [x, y, z] : mesh.positions) {
      const double beyond = std::max(0.0, x - crease);
      const Eigen::Vector3d flat(x - beyond + beyond * std::cos(fold), y, beyond * std::sin(fold));
      const Eigen::Vector3d at = scale * (turn * flat) + Eigen::Vector3d::Constant(offset);
      moved.positions.push_back(
          {static_cast<T>(at[0]), static_cast<T>(at[1]), static_cast<T>(at[2])});
    }
    surface = Surface<T>(moved);
    far = 200 * double{std::numeric_limits<T>::epsilon()} * (n + m + offset / edge);
  }

  // The direction in which x or y grows.
  [[nodiscard]] Vec3<double> along(bool x, bool is_beyond) const {
    const double fold = is_beyond ? slope : 0;
    return turn * (x ? Vec3<double>(std::cos(fold), 0, std::sin(fold)) : Vec3<double>(0, 1, 0));
  }
};

template <class T>
void check_borders(int seed) {
  test::Random random(static_cast<std::uint64_t>(seed));
  Index checked = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Index n = 2 + test::uniform_index(random, 24), m = 2 + test::uniform_index(random, 24);
    const double fold = trial % 2 == 0 ? 0 : test::uniform(random, -1.2, 1.2);
    const FoldedSheet<T> sheet(n, m, fold, random);
    const Surface<T>& surface = sheet.surface;
    const auto vertex = [&](Index i, Index j) { return j * (n + 1) + i; };
    const Index in_crease = (n + 1) / 2;
    CAPTURE(trial);
    // Corners, a place on each border, and the crease, from its end and within.
    const std::array<std::array<Index, 2>, 9> leds{{{0, 0},
                                                    {n, 0},
                                                    {0, m},
                                                    {n, m},
                                                    {test::uniform_index(random, n), 0},
                                                    {test::uniform_index(random, n), m},
                                                    {0, test::uniform_index(random, m)},
                                                    {n, test::uniform_index(random, m)},
                                                    {in_crease, test::uniform_index(random, m)}}};
    for (const auto& [i, j] : leds) {
      const Vec3<T> normal = sheet.turn.col(2).template cast<T>();
      // The vertex, and next to it along the line.
      for (const bool x : {true, false}) {
        const bool is_straight = x ? j == 0 || j == m : i == 0 || i == n || i == in_crease;
        if (!is_straight) continue;
        std::vector<SurfacePoint<T>> starts{vertex_point<T>(vertex(i, j))};
        const Index end = x ? vertex(i < n ? i + 1 : i - 1, j) : vertex(i, j < m ? j + 1 : j - 1);
        for (const double share : {0.3, 1e-4, 1e-7, 1e-12, 1e-17}) {
          starts.push_back(gelight::edge_point<T>(vertex(i, j), end, static_cast<T>(share)));
        }
        std::vector<SurfacePoint<T>> points;
        std::vector<double> places;
        for (Index k = 0; k <= (x ? n : m); ++k) {
          const Index v = x ? vertex(k, j) : vertex(i, k);
          points.push_back(vertex_point<T>(v));
          places.push_back(k);
          if (k == (x ? n : m)) break;
          points.push_back(
              gelight::edge_point<T>(v, x ? vertex(k + 1, j) : vertex(i, k + 1), T(0.4)));
          places.push_back(k + 0.4);
        }
        for (std::size_t s = 0; s < starts.size(); ++s) {
          const double led_place =
              (x ? i : j) +
              (end > vertex(i, j) ? 1 : -1) * std::array{0., .3, 1e-4, 1e-7, 1e-12, 1e-17}[s];
          const auto field = plane_field<T>(surface, starts[s], normal, points);
          for (std::size_t p = 0; p < points.size(); ++p) {
            // Beside the LED and at the crease the direction is that of a face, or of none.
            if (std::abs(places[p] - led_place) < 1.5) continue;
            if (x && std::abs(places[p] - in_crease) < 0.1) continue;
            const bool is_beyond = x && places[p] > in_crease;
            // The normal is that in front of the crease: farther on it is above the LED.
            if (x && fold != 0 && led_place > in_crease) continue;
            const double sign = places[p] > led_place ? 1 : -1;
            const Vec3<double> light = field[p].template cast<double>();
            CAPTURE(s);
            CAPTURE(places[p]);
            CAPTURE(led_place);
            CHECK(angle(light, sign * sheet.along(x, is_beyond)) < sheet.far);
            CHECK_FALSE(light.isZero());
            ++checked;
          }
        }
      }
    }
  }
  CHECK(checked > 5000);
}

}  // namespace

TEST_CASE("light from an LED on a straight border or crease comes along it") {
  check_borders<double>(5);
  check_borders<float>(6);
}

TEST_CASE("an LED on a flat sheet's border lights all of it, straight") {
  test::Random random(12);
  for (int trial = 0; trial < 30; ++trial) {
    const Index n = 2 + test::uniform_index(random, 18), m = 2 + test::uniform_index(random, 18);
    const FoldedSheet<double> sheet(n, m, 0, random);
    const Surface<double>& surface = sheet.surface;
    const Index i = test::uniform_index(random, n + 1), corner = trial % 3 == 0 ? 0 : i;
    const double off = trial % 2 == 0 ? 0 : std::pow(10, test::uniform(random, -16, -1));
    // In the first row of faces, on the border or a hair from it.
    auto led = vertex_point<double>(corner);
    if (off > 0) led = gelight::edge_point<double>(corner, corner + n + 1, off);
    const auto points = gelight::vertex_points(surface);
    const auto field = plane_field<double>(surface, led, points);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Vec3<double> way = surface.position(points[p]) - surface.position(led);
      if (way.norm() < 1.5 * sheet.edge) continue;
      CAPTURE(trial);
      CAPTURE(p);
      CHECK(angle(field[p], way) < 100 * sheet.far);
      CHECK_FALSE(field[p].isZero());
    }
  }
}

TEST_CASE_TEMPLATE("a vertex without a face, wherever it is, darkens no border", T, float, double) {
  test::Random random(4);
  for (const double far : {0.0, 1e3, 1e6, 1e15}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Eigen::AngleAxisd turn(test::uniform(random, 0, 3), Vec3<double>(1, 2, 3).normalized());
      gelight::Mesh<T> mesh;
      const auto flat = gelight::grid<double>(6, 7, 1.0, 1.2);
      for (const auto& p : flat.positions) {
        const Vec3<double> q = turn * Vec3<double>(p.data());
        mesh.positions.push_back({T(q[0]), T(q[1]), T(q[2])});
      }
      mesh.faces = flat.faces;
      mesh.positions.push_back({T(far), T(-far), T(far / 2)});
      const Surface<T> surface(mesh);
      const auto led = vertex_point<T>(test::uniform_index(random, 7));  // on the border
      auto points = gelight::vertex_points(surface);
      points.pop_back();
      const auto field = plane_field<T>(surface, led, points);
      for (std::size_t p = 0; p < points.size(); ++p) {
        const Vec3<T> way = surface.position(points[p]) - surface.position(led);
        CAPTURE(far);
        CHECK((field[p] - gelight::detail::direction_of(way)).norm() < T(1e-4));
      }
    }
  }
}

namespace {

// The largest angle between the light of plane_field and that of plane_rays, over rough meshes, at
// points as near to corners and sides of their faces as can be.
template <class T>
double worst_between_field_and_rays(unsigned seed) {
  test::Random random(seed);
  double worst = 0;
  for (int trial = 0; trial < 12; ++trial) {
    gelight::Mesh<double> smooth = trial % 3 == 0   ? gelight::icosphere<double>(2)
                                   : trial % 3 == 1 ? gelight::torus<double>(2, 0.7, 11, 7)
                                                    : gelight::grid<double>(7, 9, 1, 1);
    gelight::Mesh<T> rough;
    rough.faces = smooth.faces;
    for (auto& p : smooth.positions) {
      for (double& x : p) x += test::uniform(random, -0.04, 0.04);
      rough.positions.push_back({T(p[0]), T(p[1]), T(p[2])});
    }
    const Surface<T> surface(rough);
    auto led = vertex_point<T>(test::uniform_index(random, surface.vertex_count()));
    if (trial % 2 == 0) {
      led = gelight::face_point<T>(test::uniform_index(random, surface.face_count()),
                                   {T(0.5), T(0.25), T(0.25)});
    }
    std::vector<SurfacePoint<T>> points;
    for (double share = 1e-3; share > 1e-18; share /= 5) {
      for (int i = 0; i < 50; ++i) {
        points.push_back(point_near_corner_or_side(surface, share, random));
      }
    }
    const auto field = plane_field(surface, led, points);
    const auto rays = gelight::plane_rays<T>(surface, {&led, 1}, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (rays.lighting[i] == gelight::Lighting::ambiguous) continue;
      worst = std::max(worst, double{(field[i] - rays.direction[i]).norm()});
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the field and the rays of a plane light a point by the same face, however near a side") {
  CHECK(worst_between_field_and_rays<double>(21) < 1e-8);
  CHECK(worst_between_field_and_rays<float>(22) < 1e-3);
}

TEST_CASE_TEMPLATE("plane light is the same whatever the surface's unit", T, float, double) {
  const auto light = [](int exponent) {
    auto mesh = gelight::membrane<T>(T(0.5), T(2), T(0.25));
    for (auto& p : mesh.positions) {
      for (T& x : p) x = std::ldexp(x, exponent);
    }
    const Surface<T> surface(mesh);
    std::vector<SurfacePoint<T>> points = gelight::vertex_points(surface);
    for (Index f = 0; f < surface.face_count(); ++f) {
      points.push_back(gelight::face_point<T>(f, {T(0.25), T(0.25), T(0.5)}));
    }
    const std::vector<SurfacePoint<T>> led{vertex_point<T>(3), points.back()};
    auto rays = gelight::plane_rays<T>(surface, led, points);
    for (T& distance : rays.distance) distance = std::ldexp(distance, -exponent);
    return std::tuple{plane_field(surface, led[1], points), rays.direction, rays.distance,
                      rays.lighting};
  };
  const auto expected = light(0);
  // Products of four lengths of these no float holds, of two of the last.
  for (const int exponent : {-100, -60, -45, 45, 60, 100}) {
    CAPTURE(exponent);
    CHECK(light(exponent) == expected);
  }
}
