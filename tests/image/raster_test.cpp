#include "gelight/image/raster.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"

using gelight::Camera;
using gelight::Index;
using gelight::Mesh;
using gelight::Vec3;

namespace {

template <class T>
Camera<T> small_camera() {
  return {40, 40, T(31.5), T(23.5), 64, 48};
}

// The point that depth and camera tell, and the one that face and barycentric coordinates tell.
template <class T>
void check_points_agree(const Mesh<T>& mesh, const gelight::Raster<T>& raster,
                        const Camera<T>& camera, double tolerance) {
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Index f = raster.face(u, v);
      if (f < 0) {
        CHECK(raster.depth(u, v) == std::numeric_limits<T>::infinity());
        continue;
      }
      const Camera<double> exact = camera.template cast<double>();
      const Vec3<double> seen = exact.unproject(u, v, raster.depth(u, v));
      Vec3<double> on_face = Vec3<double>::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = mesh.position(mesh.face(f)[k]);
        on_face += double{raster.barycentric(u, v)[k]} * Vec3<double>(p[0], p[1], p[2]);
      }
      CHECK((seen - on_face).norm() < tolerance);
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("a tilted sheet is seen at its analytic depth", T, float, double) {
  // z = 2 + x / 2, so that a ray (x, y, 1) z meets it at z = 2 / (1 - x / 2).
  Mesh<T> sheet = gelight::grid<T>(7, 5, 20, 20);
  for (auto& [x, y, z] : sheet.positions) {
    x = x - 10;
    y = y - 10;
    z = 2 + x / 2;
  }
  const auto camera = small_camera<T>();
  const auto raster = gelight::rasterize(sheet, camera);
  const double eps = std::numeric_limits<T>::epsilon();
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const double x = (u - 31.5) / 40, y = (v - 23.5) / 40;
      const double z = 2 / (1 - x / 2);
      if (std::abs(x * z) > 9.99 || std::abs(y * z) > 9.99) continue;
      CHECK(raster.depth(u, v) == gelight::test::approx(z).epsilon(8 * eps));
    }
  }
  check_points_agree(sheet, raster, camera, 100 * eps);
}

TEST_CASE(
    "from inside a closed box every ray meets the nearest wall, also on edges and diagonals") {
  const Mesh<double> box = gelight::box(2.0, 3.0, 4.0);
  // Odd size and whole-numbered centre: rays run exactly through corners, edges and diagonals.
  const Camera<double> camera{16, 16, 32, 24, 65, 49};
  const auto raster = gelight::rasterize(box, camera);
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Vec3<double> d = camera.ray(u, v);
      const double z = std::min({1 / std::abs(d[0]), 1.5 / std::abs(d[1]), 2.0});
      CHECK(raster.face(u, v) >= 0);
      CHECK(raster.depth(u, v) == gelight::test::approx(z).epsilon(1e-14));
    }
  }
  check_points_agree(box, raster, camera, 1e-14);
}

TEST_CASE("of two surfaces the nearer is seen, and what is behind the camera is not") {
  Mesh<double> ball = gelight::icosphere(4, 1.0);
  for (auto& p : ball.positions) p[2] += 3;
  const auto camera = small_camera<double>();
  const auto raster = gelight::rasterize(ball, camera);
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Vec3<double> d = camera.ray(u, v);
      const double a = d.squaredNorm(), root = 9 - a * 8;  // |z d - (0, 0, 3)| = 1
      if (root < -0.2) {
        CHECK(raster.face(u, v) == -1);
      }
      if (root > 0.2) {
        const double z = (3 - std::sqrt(root)) / a;
        CHECK(raster.depth(u, v) == gelight::test::approx(z).epsilon(2e-3));
        CHECK(raster.depth(u, v) >= z);  // the faces are chords of the sphere
      }
    }
  }
  for (auto& p : ball.positions) p[2] -= 6;
  for (const Index face : gelight::rasterize(ball, camera).face.pixels()) CHECK(face == -1);
}

TEST_CASE("a triangle that passes beside the camera is seen only in front of it") {
  // A floor at y = 1, from far behind the camera to far before it.
  const Mesh<double> floor{{{-100, 1, -100}, {100, 1, -100}, {0, 1, 1000}}, {{0, 1, 2}}};
  const auto camera = small_camera<double>();
  const auto raster = gelight::rasterize(floor, camera);
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Vec3<double> d = camera.ray(u, v);
      const bool below = d[1] > 0;
      CHECK((raster.face(u, v) >= 0) == below);
      if (below) CHECK(raster.depth(u, v) == gelight::test::approx(1 / d[1]).epsilon(1e-13));
    }
  }
}

namespace {

// Without optimisation a tenth of the inputs has to do.
#ifdef __OPTIMIZE__
constexpr int effort = 10;
#else
constexpr int effort = 1;
#endif

using Generator = std::mt19937_64;

double uniform(Generator& random, double from, double to) {
  return std::uniform_real_distribution(from, to)(random);
}

std::int64_t integer(Generator& random, std::int64_t from, std::int64_t to) {
  return std::uniform_int_distribution(from, to)(random);
}

Eigen::Matrix3d rotation(Generator& random) {
  Eigen::Vector4d q;
  for (int i = 0; i < 4; ++i) q[i] = std::normal_distribution()(random);
  q.normalize();
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Eigen::Matrix3d turn;
  turn << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),      //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return turn;
}

// A triangle whose corners appear at eighths of a pixel, at a depth of 1, 2 or 4: all that is to be
// told of its pixels is a ratio of small whole numbers.
struct LatticeTriangle {
  std::array<std::array<std::int64_t, 2>, 3> corners;  // in eighths of a pixel
  std::array<std::int64_t, 3> depths;

  static constexpr int size = 32;

  static Camera<double> camera() { return {64, 64, 12, 20, size, size}; }

  // Twice the area that (x, y) spans with the side across a corner, positive inside.
  [[nodiscard]] std::int64_t area(std::size_t across, std::int64_t x, std::int64_t y) const {
    const auto &p = corners[(across + 1) % 3], &q = corners[(across + 2) % 3];
    const std::int64_t sign = whole() < 0 ? -1 : 1;
    return sign * ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]));
  }

  [[nodiscard]] std::int64_t whole() const {
    const auto &a = corners[0], &b = corners[1], &c = corners[2];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }

  // The corners in space. All numbers here have few digits.
  template <class T>
  void append_to(Mesh<T>& mesh) const {
    const auto first = static_cast<Index>(mesh.positions.size());
    for (std::size_t k = 0; k < 3; ++k) {
      const auto z = static_cast<double>(depths[k]);
      const double x = (static_cast<double>(corners[k][0]) / 8 - 12) / 64 * z;
      const double y = (static_cast<double>(corners[k][1]) / 8 - 20) / 64 * z;
      mesh.positions.push_back({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
    }
    mesh.faces.push_back({first, first + 1, first + 2});
  }
};

// So large that it has to be cut, where rounding comes in.
constexpr int far_out = 5;

LatticeTriangle random_lattice_triangle(Generator& random, int family) {
  const int reach = 8 * LatticeTriangle::size;
  const auto point = [&](std::int64_t from, std::int64_t to, std::int64_t step = 1) {
    return std::array{step * integer(random, from / step, to / step),
                      step * integer(random, from / step, to / step)};
  };
  LatticeTriangle t;
  for (auto& depth : t.depths) depth = std::int64_t{1} << integer(random, 0, 2);
  const auto a = point(0, reach), b = point(0, reach);
  if (family == 0) t.corners = {a, b, point(0, reach)};
  if (family == 1) t.corners = {point(0, reach, 8), point(0, reach, 8), point(0, reach, 8)};
  if (family == 2) t.corners = {point(-reach, reach), b, point(0, reach + reach / 2)};
  if (family == 3) {  // a sliver, an eighth of a pixel or less wide
    t.corners = {a, b, {b[0] + integer(random, -1, 1), b[1] + integer(random, -1, 1)}};
  }
  if (family == 4) {  // no area, along pixel centres or not
    const auto start = point(0, reach, 8), step = point(-12, 12);
    const auto along = [&](std::int64_t n) {
      return std::array{start[0] + n * step[0], start[1] + n * step[1]};
    };
    t.corners = {along(integer(random, -9, 9)), along(0), along(integer(random, -9, 9))};
  }
  if (family == far_out) {
    t.corners = {point(-9 * reach, 9 * reach), b, point(-9 * reach, 9 * reach)};
  }
  return t;
}

// Pixels of one triangle that are not what they have to be.
template <class T>
int wrong_pixels(const LatticeTriangle& t, bool is_cut) {
  Mesh<T> mesh;
  t.append_to(mesh);
  const auto raster = gelight::rasterize(mesh, LatticeTriangle::camera().cast<T>());
  const double tolerance = (is_cut ? 1000 : 4) * double{std::numeric_limits<T>::epsilon()};
  int wrong = 0;
  for (Index v = 0; v < LatticeTriangle::size; ++v) {
    for (Index u = 0; u < LatticeTriangle::size; ++u) {
      std::array<std::int64_t, 3> parts{};
      std::int64_t sum = 0, areas = 0;
      bool is_covered = t.whole() != 0, is_on_side = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int64_t area = t.area(k, 8 * u, 8 * v);
        is_covered = is_covered && area >= 0;
        is_on_side = is_on_side || area == 0;
        parts[k] = area * (4 / t.depths[k]);
        sum += parts[k];
        areas += 4 * area;
      }
      if (is_cut && is_on_side) continue;
      if ((raster.face(u, v) >= 0) != is_covered) {
        ++wrong;
      } else if (is_covered) {
        const double z = static_cast<double>(areas) / static_cast<double>(sum);
        wrong += !(std::abs(double{raster.depth(u, v)} - z) <= tolerance * z);
        for (std::size_t k = 0; k < 3; ++k) {
          const double share = static_cast<double>(parts[k]) / static_cast<double>(sum);
          wrong += !(std::abs(double{raster.barycentric(u, v)[k]} - share) <= tolerance);
        }
      }
    }
  }
  return wrong;
}

// A plate with a front, of which the inverse depth is linear in the image (a plane), a back, and a
// rim between: a closed surface. The corners of its cells appear at pixel centres.
struct PlateShape {
  Index first = 4;             // column and row where it begins
  Index cell = 1, cells = 40;  // width of a cell in pixels, cells in a row
  std::array<double, 3> inverse_depth{1, 0, 0};
  double thickness = 0.3;

  [[nodiscard]] double depth(double u, double v) const {
    return 1 / (inverse_depth[0] + inverse_depth[1] * u + inverse_depth[2] * v);
  }
};

template <class T>
Mesh<T> plate(const Camera<double>& camera, const PlateShape& shape, Generator& random) {
  Mesh<T> mesh;
  // Turned there and back, so that the corners are where they should be but for rounding.
  const Eigen::Matrix3d turn = rotation(random);
  const Index side = shape.cells + 1;
  for (const double behind : {0.0, shape.thickness}) {
    for (Index j = 0; j < side; ++j) {
      for (Index i = 0; i < side; ++i) {
        const Index u = shape.first + shape.cell * i, v = shape.first + shape.cell * j;
        const Vec3<double> point = (shape.depth(u, v) + behind) * camera.ray(u, v);
        const Vec3<double> seen = turn.transpose() * (turn * point);
        mesh.positions.push_back(
            {static_cast<T>(seen[0]), static_cast<T>(seen[1]), static_cast<T>(seen[2])});
      }
    }
  }
  const auto quad = [&](Index a, Index b, Index c, Index d) {
    const bool turned = integer(random, 0, 1) == 1;
    mesh.faces.push_back(turned ? std::array{b, c, d} : std::array{a, b, c});
    mesh.faces.push_back(turned ? std::array{b, d, a} : std::array{a, c, d});
  };
  const Index back = side * side;
  const auto at = [&](Index i, Index j) { return j * side + i; };
  for (Index j = 0; j < shape.cells; ++j) {
    for (Index i = 0; i < shape.cells; ++i) {
      const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      quad(a, b, c, d);
      quad(back + d, back + c, back + b, back + a);
    }
  }
  for (Index i = 0; i < shape.cells; ++i) {
    for (const auto& [a, b] :
         {std::pair{at(i, 0), at(i + 1, 0)}, std::pair{at(i, side - 1), at(i + 1, side - 1)},
          std::pair{at(0, i), at(0, i + 1)}, std::pair{at(side - 1, i), at(side - 1, i + 1)}}) {
      quad(a, b, back + b, back + a);
    }
  }
  return mesh;
}

template <class T>
Vec3<double> position(const Mesh<T>& mesh, Index v) {
  const auto& p = mesh.position(v);
  return {double{p[0]}, double{p[1]}, double{p[2]}};
}

// How many pixels show a depth that their face has nowhere, weights that are no shares, or a point
// beside their ray by more than 1e-14 of the image's size, and rounding.
template <class T>
int invented_pixels(const Mesh<T>& mesh, const Camera<T>& of_mesh,
                    const gelight::Raster<T>& raster) {
  const auto camera = of_mesh.template cast<double>();
  const double eps = double{std::numeric_limits<T>::epsilon()};
  const double beside =
      1e-14 * std::max(camera.width, camera.height) / std::min(camera.fx, camera.fy);
  int invented = 0;
  for (Index v = 0; v < camera.height; ++v) {
    for (Index u = 0; u < camera.width; ++u) {
      const Index f = raster.face(u, v);
      if (f < 0) continue;
      const double z = double{raster.depth(u, v)};
      Vec3<double> point = Vec3<double>::Zero();
      double least = std::numeric_limits<double>::infinity(), most = 0, sum = 0, farthest = 0;
      bool are_shares = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3<double> p = position(mesh, mesh.face(f)[k]);
        const double share = double{raster.barycentric(u, v)[k]};
        least = std::min(least, p[2]);
        most = std::max(most, p[2]);
        farthest = std::max(farthest, p.norm());
        are_shares = are_shares && share >= 0;
        sum += share;
        point += share * p;
      }
      const bool is_depth = z > 0 && z >= least && z <= most;
      const double off = (point - z * camera.ray(u, v)).norm();
      const bool is_seen = off <= beside * z + 16 * eps * farthest;
      invented += !(is_depth && is_seen && are_shares && std::abs(sum - 1) <= 4 * eps);
    }
  }
  return invented;
}

// With its centre anywhere between two columns, and the same rows.
template <class T>
Camera<T> any_camera(Generator& random, double from, double to, Index width, Index height) {
  const double fx = uniform(random, 20, 90), fy = uniform(random, 20, 90);
  const double cx = uniform(random, from, to), cy = uniform(random, from, to);
  return Camera<double>{fx, fy, cx, cy, width, height}.template cast<T>();
}

}  // namespace

TEST_CASE_TEMPLATE("a triangle covers the pixels whose centres lie in it or on its sides", T, float,
                   double) {
  // In whole numbers, on whatever way the compiler takes.
  Generator random(1);
  for (int family = 0; family <= far_out; ++family) {
    int wrong = 0;
    for (int i = 0; i < 20 * effort; ++i) {
      wrong += wrong_pixels<T>(random_lattice_triangle(random, family), family == far_out);
    }
    CAPTURE(family);
    CHECK(wrong == 0);
  }
}

TEST_CASE_TEMPLATE("no ray slips through a closed plate, also where it passes through corners", T,
                   float, double) {
  Generator random(2);
  const double eps = double{std::numeric_limits<T>::epsilon()};
  int holes = 0, invented = 0, off = 0;
  for (int view = 0; view < 40 * effort; ++view) {
    const double scale = std::exp2(integer(random, -20, 20));
    const auto camera = any_camera<T>(random, 10, 40, 48, 50);
    PlateShape shape;
    shape.cell = static_cast<Index>(integer(random, 1, 3));
    shape.cells = 40 / shape.cell;
    shape.inverse_depth = {uniform(random, 0.5, 1) / scale, uniform(random, -0.005, 0.005) / scale,
                           uniform(random, -0.005, 0.005) / scale};
    shape.thickness = 0.3 * scale;
    const auto mesh = plate<T>(camera.template cast<double>(), shape, random);
    const auto raster = gelight::rasterize(mesh, camera);
    const Index last = shape.first + shape.cell * shape.cells;
    for (Index v = shape.first + 1; v < last; ++v) {
      for (Index u = shape.first + 1; u < last; ++u) {
        const double z = shape.depth(u, v);
        holes += raster.face(u, v) < 0;
        off += !(std::abs(double{raster.depth(u, v)} - z) <= 400 * eps * z);
      }
    }
    invented += invented_pixels(mesh, camera, raster);
  }
  CHECK(holes == 0);
  CHECK(off == 0);
  CHECK(invented == 0);
}

TEST_CASE_TEMPLATE("a face without area, and one seen edge-on, invents no depth", T, float,
                   double) {
  Generator random(3);
  const double eps = double{std::numeric_limits<T>::epsilon()};
  int shown = 0, off = 0, invented = 0;
  for (int i = 0; i < 200 * effort; ++i) {
    const double scale = std::exp2(integer(random, -20, 20));
    const auto camera = any_camera<T>(random, 0, 31, 32, 32);
    const auto exact = camera.template cast<double>();
    const auto point = [&](double u, double v) {
      return Vec3<double>(uniform(random, 0.5, 2) * scale * exact.ray(u, v));
    };
    // Along a row, a column, a diagonal or any line through a pixel's centre.
    const double u = static_cast<double>(integer(random, 0, 31)),
                 v = static_cast<double>(integer(random, 0, 31));
    const std::array<std::array<double, 2>, 4> ways{
        {{1, 0}, {0, 1}, {1, -1}, {uniform(random, -1, 1), uniform(random, -1, 1)}}};
    const auto& way = ways[static_cast<std::size_t>(i % 4)];
    const double from = uniform(random, -20, 0), to = uniform(random, 0, 20);
    const Vec3<double> a = point(u + from * way[0], v + from * way[1]);
    const Vec3<double> b = point(u + to * way[0], v + to * way[1]);
    // The third corner between the two, or anywhere in the plane through them and the camera.
    const double share = uniform(random, 0, 1);
    const bool is_edge_on = i % 3 == 0;
    const Vec3<double> c =
        (1 - share) * a + share * (is_edge_on ? uniform(random, 0.5, 2) : 1.0) * b;
    Mesh<T> mesh;
    for (const Vec3<double>& p : {a, b, c}) {
      mesh.positions.push_back({static_cast<T>(p[0]), static_cast<T>(p[1]), static_cast<T>(p[2])});
    }
    mesh.faces = {{0, 1, 2}};
    const auto raster = gelight::rasterize(mesh, camera);
    invented += invented_pixels(mesh, camera, raster);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        if (raster.face(x, y) < 0) continue;
        ++shown;
        if (is_edge_on) continue;
        // Where the plane through the ray, across the image of a b, cuts a b.
        const Vec3<double> ray = exact.ray(x, y), along = b / b[2] - a / a[2];
        const Vec3<double> across = ray * ray.dot(along) - along * ray.dot(ray);
        const double at_a = a.dot(across), at_b = b.dot(across);
        const double z = (a + at_a / (at_a - at_b) * (b - a))[2];
        off += !(std::abs(double{raster.depth(x, y)} - z) <= 1e4 * eps * z);
      }
    }
  }
  CHECK(invented == 0);
  CHECK(off == 0);
  CHECK(shown > 0);
}

TEST_CASE_TEMPLATE(
    "from inside a closed surface every ray meets it, also with corners beside and behind", T,
    float, double) {
  Generator random(4);
  int holes = 0, off = 0, invented = 0;
  for (int view = 0; view < 6 * effort; ++view) {
    const double scale = std::exp2(integer(random, -20, 20));
    const Index across = view % 20 == 0 ? 300 : 40;
    const auto camera = Camera<double>{uniform(random, 5, 90),
                                       uniform(random, 5, 90),
                                       uniform(random, -60, 90),
                                       uniform(random, -60, 90),
                                       across,
                                       30}
                            .cast<T>();
    // A ball with bumps that are seen from everywhere inside, turned and moved so that faces pass
    // close to the camera.
    auto ball = gelight::icosphere(static_cast<int>(integer(random, 0, 3)), 1.0);
    const Eigen::Matrix3d turn = rotation(random);
    const Vec3<double> shift =
        turn.col(0) * std::exp2(uniform(random, -3, 0)) * uniform(random, 0, 0.78);
    Mesh<T> mesh;
    double least = 1;
    for (const auto& p : ball.positions) {
      const double r = uniform(random, 0.99, 1);
      const Vec3<double> moved = scale * (r * (turn * Vec3<double>(p[0], p[1], p[2])) + shift);
      mesh.positions.push_back(
          {static_cast<T>(moved[0]), static_cast<T>(moved[1]), static_cast<T>(moved[2])});
    }
    mesh.faces = ball.faces;
    for (const auto& face : mesh.faces) {
      const Vec3<double> a = position(mesh, face[0]), b = position(mesh, face[1]),
                         c = position(mesh, face[2]);
      const Vec3<double> normal = gelight::cross<double>(b - a, c - a).normalized();
      least = std::min(least, std::abs(normal.dot(a - scale * shift)) / scale);
    }
    const auto raster = gelight::rasterize(mesh, camera);
    invented += invented_pixels(mesh, camera, raster);
    const auto exact = camera.template cast<double>();
    for (Index v = 0; v < camera.height; ++v) {
      for (Index u = 0; u < camera.width; ++u) {
        if (raster.face(u, v) < 0) {
          ++holes;
          continue;
        }
        // Between the spheres inside and outside.
        const double r = (double{raster.depth(u, v)} * exact.ray(u, v) / scale - shift).norm();
        off += !(r > least - 1e-5 && r < 1 + 1e-5);
      }
    }
  }
  CHECK(holes == 0);
  CHECK(off == 0);
  CHECK(invented == 0);
}

TEST_CASE("a rough welded floor from behind the camera to far before it has no hole") {
  Generator random(5);
  int holes = 0;
  for (int view = 0; view < 4 * effort; ++view) {
    auto floor = gelight::grid<double>(30, 30, 60, 60);
    const double roll = uniform(random, -3.1, 3.1);
    for (auto& [x, y, z] : floor.positions) {
      const double east = x - 30 + uniform(random, -0.3, 0.3);
      const double ahead = y - 30 + uniform(random, -0.3, 0.3);
      // Lower where it is far, so that no bump hides its border.
      const double down = 1 + uniform(random, 0, 0.05);
      x = std::cos(roll) * east - std::sin(roll) * down;
      y = std::sin(roll) * east + std::cos(roll) * down;
      z = ahead;
    }
    const auto camera = small_camera<double>();
    const auto raster = gelight::rasterize(floor, camera);
    for (Index v = 0; v < camera.height; ++v) {
      for (Index u = 0; u < camera.width; ++u) {
        const Vec3<double> ray = camera.ray(u, v);
        const double down = std::cos(roll) * ray[1] - std::sin(roll) * ray[0];
        const double east = std::cos(roll) * ray[0] + std::sin(roll) * ray[1];
        // It is met between 1 and 1.05 below, there within the floor.
        const bool meets = down > 0 && 1.05 / down < 29 && 1.05 / down * std::abs(east) < 29;
        if (!meets) continue;
        holes += raster.face(u, v) < 0;
        const double z = raster.depth(u, v) * down;
        CHECK((z > 1 - 1e-9 && z < 1.05 + 1e-9));
      }
    }
  }
  CHECK(holes == 0);
}

TEST_CASE(
    "the order of the faces changes no depth, nor does the way round in which they are named") {
  Generator random(6);
  for (int view = 0; view < 3 * effort; ++view) {
    const Camera<double> camera{40, 50, uniform(random, 10, 40), uniform(random, 10, 40), 48, 50};
    PlateShape shape;
    shape.cell = static_cast<Index>(integer(random, 1, 3));
    shape.cells = 40 / shape.cell;
    auto mesh = plate<double>(camera, shape, random);
    for (int k = 0; k < 20; ++k) {
      const auto first = static_cast<Index>(mesh.positions.size());
      for (int corner = 0; corner < 3; ++corner) {
        mesh.positions.push_back(
            {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -0.5, 3)});
      }
      mesh.faces.push_back({first, first + 1, first + 2});
    }
    const auto before = gelight::rasterize(mesh, camera);
    std::shuffle(mesh.faces.begin(), mesh.faces.end(), random);
    CHECK(gelight::rasterize(mesh, camera).depth == before.depth);
    for (auto& face : mesh.faces)
      std::swap(face[0], face[static_cast<std::size_t>(integer(random, 1, 2))]);
    const auto turned = gelight::rasterize(mesh, camera);
    double worst = 0;
    for (std::size_t i = 0; i < before.depth.pixels().size(); ++i) {
      const double was = before.depth.pixels()[i], is = turned.depth.pixels()[i];
      if (was != is) worst = std::max(worst, std::abs(is - was) / std::min(is, was));
    }
    CHECK(worst < 1e-11);  // rounding, where a face is steep
  }
}

TEST_CASE("the mesh of a depth image shows each pixel, the border's too, at its depth") {
  Generator random(7);
  for (const auto& [width, height] :
       {std::pair{64, 48}, std::pair{33, 65}, std::pair{2, 2}, std::pair{4097, 3}}) {
    const Camera<double> camera{uniform(random, 0.3, 2) * width,
                                uniform(random, 0.3, 2) * width,
                                (width - 1) / 2.0 + uniform(random, -0.2, 0.2),
                                (height - 1) / 2.0 + uniform(random, -0.2, 0.2),
                                width,
                                height};
    gelight::Image<double> depth(width, height);
    for (double& z : depth.pixels()) z = uniform(random, 0.01, 0.02);
    Mesh<double> mesh;
    for (const auto& p : gelight::unproject<double>(depth, camera).pixels())
      mesh.positions.push_back({p[0], p[1], p[2]});
    for (Index y = 0; y + 1 < height; ++y) {
      for (Index x = 0; x + 1 < width; ++x) {
        const Index a = y * width + x;
        mesh.faces.push_back({a, a + 1, a + width});
        mesh.faces.push_back({a + 1, a + width + 1, a + width});
      }
    }
    const auto raster = gelight::rasterize(mesh, camera);
    int off = 0;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      off += !(std::abs(raster.depth.pixels()[i] - depth.pixels()[i]) <= 1e-15 * depth.pixels()[i]);
    }
    CHECK(off == 0);
  }
}

TEST_CASE("cameras and triangles of any size") {
  // A wall at z = 2 far beyond the image, seen by cameras large and small, also far beside the
  // axis.
  for (const double size : {1e-100, 1.0, 1e100}) {
    for (const auto& [reach, centre] :
         {std::pair{3.0, 0.5}, std::pair{1e12, 0.0}, std::pair{1e30, -0.4}}) {
      for (const auto& [width, height] :
           {std::pair{1, 1}, std::pair{3, 4096}, std::pair{70000, 1}}) {
        const double f = std::max(width, height);
        const Camera<double> camera{f, f, centre * width, centre * height, width, height};
        const double z = 2 * size, far = z * reach;
        const Mesh<double> wall{{{-far, -far, z}, {2 * far, -far, z}, {-far, 2 * far, z}},
                                {{0, 1, 2}}};
        const auto raster = gelight::rasterize(wall, camera);
        const auto off =
            std::count_if(raster.depth.pixels().begin(), raster.depth.pixels().end(),
                          [&](double seen) { return !(std::abs(seen - z) <= 1e-13 * z); });
        CHECK(off == 0);
      }
    }
  }
}

TEST_CASE_TEMPLATE("what is seen at any scale is right or refused, never missing", T, float,
                   double) {
  // A wall that fills a turned image's lower left half, with coordinates in double.
  const auto seen = [](const Camera<T>& camera, double size) {
    const auto exact = camera.template cast<double>();
    Mesh<double> wall;
    for (const auto& [u, v] : {std::pair{-9.0, -9.0}, {99.0, 99.0}, {-9.0, 99.0}}) {
      const Vec3<double> p = 2 * size * exact.ray(u, v);
      wall.positions.push_back({p[0], p[1], p[2]});
    }
    wall.faces = {{0, 1, 2}};
    const auto raster = gelight::rasterize(wall, camera);
    Index wrong = 0;
    for (Index v = 0; v < camera.height; ++v) {
      for (Index u = 0; u < camera.width; ++u) {
        if (u == v) continue;  // on the wall's side but for rounding
        const bool is_right =
            u < v ? std::abs(raster.depth(u, v) / size - 2) < 1e-6 : raster.face(u, v) < 0;
        wrong += is_right ? 0 : 1;
      }
    }
    return wrong;
  };
  int right = 0, refused = 0;
  const auto check = [&](const Camera<T>& camera, double size) {
    CAPTURE(camera.fx);
    CAPTURE(camera.cx);
    CAPTURE(size);
    try {
      const Index wrong = seen(camera, size);
      CHECK(wrong == 0);
      ++right;
    } catch (const gelight::InvalidInput&) {
      ++refused;
    }
  };
  const Camera<T> usual{20, 20, T(15.5), T(11.5), 32, 24};
  for (int exponent = -307; exponent <= 307; ++exponent) {
    check(usual, 1.5 * std::pow(10.0, exponent));
  }
  CHECK(right >= (sizeof(T) == 4 ? 70 : 290));
  for (int exponent = 0; exponent <= 30; ++exponent) {
    for (const double sign : {-1, 1}) {
      auto far = usual;
      far.cx = static_cast<T>(sign * 1.3 * std::pow(10.0, exponent));
      check(far, 0.1);
    }
  }
  CHECK(right >= (sizeof(T) == 4 ? 94 : 314));
  for (const int exponent : {-300, -200, -30, -6, 6, 30, 200, 300}) {
    auto zoomed = usual;
    zoomed.fx = static_cast<T>(std::pow(10.0, exponent));
    if (!(zoomed.fx > 0) || std::isinf(zoomed.fx)) continue;
    check(zoomed, 1);
  }
  CHECK(refused > 100);
}

TEST_CASE_TEMPLATE("a face from beside the camera to far before it is seen where it is", T, float,
                   double) {
  // From (0, 0, far) to x + y = 1 at z = near: a ray (x, y, 1) with x, y > 0 meets it at
  // z = far / ((x + y) (far - near) + 1).
  const Camera<T> camera{16, 16, T(3.5), T(3.25), 16, 16};
  for (const double near : {0.0, -1.0, -7.5}) {
    for (int exponent = 0; exponent <= 37; ++exponent) {
      const double far = 3 * std::pow(10.0, exponent);
      CAPTURE(near);
      CAPTURE(far);
      Mesh<double> face;
      face.positions = {{0, 0, far}, {1, 0, near}, {0, 1, near}};
      face.faces = {{0, 1, 2}};
      const auto raster = gelight::rasterize(face, camera);
      double error = 0;
      for (Index v = 0; v < 16; ++v) {
        for (Index u = 0; u < 16; ++u) {
          const double x = (u - 3.5) / 16, y = (v - 3.25) / 16;
          REQUIRE((raster.face(u, v) == 0) == (x > 0 && y > 0));
          if (raster.face(u, v) < 0) continue;
          const double expected = 1 / ((x + y) * (1 - near / far) + 1 / far);
          error = std::max(error, std::abs(raster.depth(u, v) / expected - 1));
        }
      }
      CHECK(error < 16 * double{std::numeric_limits<T>::epsilon()});
    }
  }
}

TEST_CASE("a face that is seen next to the camera is refused, however near it is") {
  // Before the camera it is seen at depths less than twice that of its first corner, behind it
  // beyond its other side.
  const Camera<double> camera{8, 8, 0.25, 0.25, 8, 8};
  for (const double z : {1e-151, 1e-308, 1e-309, 1e-320, -1e-151, -1e-200, -1e-309}) {
    CAPTURE(z);
    Mesh<double> face;
    face.positions = {{0, 0, z}, {1, 0, 1}, {0, 1, 1}};
    face.faces = {{0, 1, 2}};
    CHECK_THROWS_AS((void)gelight::rasterize(face, camera), gelight::InvalidInput);
    auto depth = gelight::empty_raster(camera).depth;
    CHECK_THROWS_AS(gelight::rasterize_into(depth, face, {}, camera), gelight::InvalidInput);
  }
}

TEST_CASE("small faces among others are seen as each drawn alone") {
  // From a tenth of a pixel to the whole image, of any shape, some behind the camera or beside it.
  Generator random(8);
  const Camera<double> camera{40, 50, 30.3, 23.6, 64, 48};
  for (int view = 0; view < 2 * effort; ++view) {
    Mesh<double> mesh;
    for (Index f = 0; f < 700; ++f) {
      const double size = 0.002 * std::pow(2, uniform(random, 0, f % 7 == 0 ? 12 : 6));
      const double x = uniform(random, -1, 1), y = uniform(random, -1, 1);
      const double z = f % 50 == 0 ? uniform(random, -0.2, 0.2) : uniform(random, 0.5, 2);
      for (int corner = 0; corner < 3; ++corner) {
        mesh.positions.push_back({x + uniform(random, -size, size),
                                  y + uniform(random, -size, size),
                                  z + uniform(random, -size, size)});
      }
      mesh.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
    }
    const auto together = gelight::rasterize(mesh, camera);

    auto alone = gelight::empty_raster(camera);
    const gelight::detail::ImagePlane plane(camera);
    gelight::detail::PositionBatch batch;
    std::array<gelight::detail::ImagePoint, 3> corners;
    for (Index f = 0; f < 700; ++f) {
      std::array<Vec3<double>, 3> positions;
      batch.count = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = mesh.position(mesh.faces[static_cast<std::size_t>(f)][k]);
        positions[k] = Vec3<double>(p[0], p[1], p[2]);
        batch.add(positions[k]);
      }
      plane.project(corners.data(), batch);
      gelight::detail::draw_face(gelight::detail::RasterTarget<double>(alone), plane, camera.width,
                                 camera.height, f, corners, positions);
    }
    CHECK(together.face == alone.face);
    int off = 0;
    for (std::size_t i = 0; i < alone.depth.pixels().size(); ++i) {
      const double is = together.depth.pixels()[i], was = alone.depth.pixels()[i];
      off += !(is == was || std::abs(is - was) <= 1e-12 * was);  // fused sums round otherwise
    }
    CHECK(off == 0);
  }
}

TEST_CASE("bad cameras and bad meshes are refused") {
  using gelight::InvalidInput;
  const Mesh<double> box = gelight::box(1.0, 1.0, 1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS((void)gelight::rasterize(box, Camera<double>{0, 1, 0, 0, 4, 4}), InvalidInput);
  CHECK_THROWS_AS((void)gelight::rasterize(box, Camera<double>{1, nan, 0, 0, 4, 4}), InvalidInput);
  CHECK_THROWS_AS((void)gelight::rasterize(box, Camera<double>{1, 1, 0, 0, -4, 4}), InvalidInput);
  Mesh<double> broken = box;
  broken.faces[5][1] = 8;
  CHECK_THROWS_WITH_AS((void)gelight::rasterize(broken, small_camera<double>()),
                       "face 5 has vertex 8, the mesh has 8 vertices", InvalidInput);
}
