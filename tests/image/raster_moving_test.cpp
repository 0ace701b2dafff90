#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/heap_count.hpp"

using namespace gelight;

namespace {

const Camera<double> camera{70, 66, 39.5, 30.2, 80, 60};
constexpr double nothing = std::numeric_limits<double>::infinity();

std::vector<Mesh<double>> objects() {
  return {icosphere<double>(3, 0.8), box<double>(1.0, 0.7, 1.3), torus<double>(0.9, 0.3, 40, 20)};
}

// In front of the camera, beside it, behind it, and around it.
Eigen::Isometry3d random_pose(std::mt19937& random, int kind) {
  std::normal_distribution<double> any;
  const Eigen::Quaterniond turn(any(random), any(random), any(random), any(random));
  Eigen::Isometry3d pose(turn.normalized());
  const double distance = kind % 4 == 3 ? 0.3 : 3;
  pose.translation() << any(random), any(random), kind % 4 == 2 ? any(random) : distance;
  return pose;
}

Mesh<double> moved(Mesh<double> mesh, const Eigen::Isometry3d& pose) {
  for (auto& p : mesh.positions) {
    const Eigen::Vector3d q =
        pose.linear() * Eigen::Vector3d(p[0], p[1], p[2]) + pose.translation();
    p = {q.x(), q.y(), q.z()};
  }
  return mesh;
}

// Whether all numbers of two images are the same: to the last bit, or, where the compiler may fuse
// multiplications with additions, here in this way and there in that, but for roundings.
bool are_same(double a, double b) {
#ifdef __FMA__
  return a == b || std::abs(a - b) <= 1e-9 * std::abs(a);
#else
  return a == b;
#endif
}
bool are_same(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return are_same(a[0], b[0]) && are_same(a[1], b[1]) && are_same(a[2], b[2]);
}
template <class Pixel>
bool are_same(const Image<Pixel>& a, const Image<Pixel>& b) {
  return std::ranges::equal(a.pixels(), b.pixels(),
                            [](const auto& x, const auto& y) { return are_same(x, y); });
}

}  // namespace

TEST_CASE("a mesh under a pose is seen as the moved mesh, with a workspace and without") {
  std::mt19937 random(3);
  RasterWorkspace work;
  int seen = 0;
  for (int kind = 0; kind < 40; ++kind) {
    for (const auto& mesh : objects()) {
      const Eigen::Isometry3d pose = random_pose(random, kind);
      const auto expected = rasterize(moved(mesh, pose), camera);
      Raster<double> with = empty_raster(camera), without = empty_raster(camera);
      rasterize_into(with, mesh, pose, camera, &work);
      rasterize_into(without, mesh, pose, camera);
      Image<double> depth(80, 60, nothing);
      rasterize_into(depth, mesh, pose, camera);
      CHECK(are_same(with.depth, expected.depth));
      CHECK(with.face == expected.face);
      CHECK(are_same(with.barycentric, expected.barycentric));
      CHECK(are_same(without.depth, expected.depth));
      CHECK(without.face == expected.face);
      CHECK(are_same(depth, expected.depth));
      const auto at_once = rasterize(mesh, Pose(pose), camera);
      CHECK(at_once.depth == with.depth);
      CHECK(at_once.face == with.face);
      CHECK(at_once.barycentric == with.barycentric);
      seen += *std::min_element(depth.pixels().begin(), depth.pixels().end()) < nothing ? 1 : 0;
    }
  }
  CHECK(seen > 60);
}

TEST_CASE("several objects: the nearest is seen, whatever the order in which they are drawn") {
  std::mt19937 random(4);
  const auto meshes = objects();
  for (int round = 0; round < 20; ++round) {
    std::vector<Eigen::Isometry3d> poses;
    Image<double> nearest(80, 60, nothing);
    for (const auto& mesh : meshes) {
      poses.push_back(random_pose(random, round));
      const auto alone = rasterize(moved(mesh, poses.back()), camera);
      for (std::size_t i = 0; i < nearest.pixels().size(); ++i) {
        nearest.pixels()[i] = std::min(nearest.pixels()[i], alone.depth.pixels()[i]);
      }
    }
    std::array<std::size_t, 3> order{0, 1, 2};
    do {
      Image<double> depth(80, 60, nothing);
      for (const std::size_t k : order) rasterize_into(depth, meshes[k], poses[k], camera);
      CHECK(are_same(depth, nearest));
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

TEST_CASE("poses of any type, images within others, depths of float") {
  const auto mesh = icosphere<float>(2, 0.5f);
  const Camera<float> eye = camera.cast<float>();
  Image<float> whole(100, 90, -1.f);
  const ImageView<float> part(&whole(7, 11), 80, 60, 100);
  for (Index y = 0; y < 60; ++y)
    std::fill_n(part.row(y), 80, std::numeric_limits<float>::infinity());
  Eigen::Affine3f pose = Eigen::Affine3f::Identity();
  pose.translate(Eigen::Vector3f(0.25f, 0, 2)).scale(2);
  rasterize_into(part, mesh, pose, eye);
  Mesh<float> twice = mesh;
  for (auto& p : twice.positions) p = {2 * p[0] + 0.25f, 2 * p[1], 2 * p[2] + 2};
  const auto expected = rasterize(twice, eye);
  int outside = 0;
  for (Index y = 0; y < 90; ++y) {
    for (Index x = 0; x < 100; ++x) {
      const bool inside = x >= 7 && x < 87 && y >= 11 && y < 71;
      outside += inside ? 0 : whole(x, y) == -1;
    }
  }
  CHECK(outside == 100 * 90 - 80 * 60);
  int far = 0;
  for (Index y = 0; y < 60; ++y) {
    for (Index x = 0; x < 80; ++x) {
      const float a = part(x, y), b = expected.depth(x, y);
      far += a == b || std::abs(a - b) < 1e-5f ? 0 : 1;
    }
  }
  CHECK(far == 0);
}

TEST_CASE("frames take no memory; a workspace takes some once") {
  const auto meshes = objects();
  std::mt19937 random(5);
  Image<double> depth(80, 60, nothing);
  RasterWorkspace work;
  for (int frame = 0; frame < 12; ++frame) {
    for (const auto& mesh : meshes) {
      const Pose pose = random_pose(random, frame);
      const std::size_t before = test::bytes_taken;
      rasterize_into(depth, mesh, pose, camera);
      CHECK(test::bytes_taken == before);
      rasterize_into(depth, mesh, pose, camera, &work);
      if (frame > 0) CHECK(test::bytes_taken == before);
    }
  }
}

TEST_CASE("what cannot be drawn is refused before anything is drawn") {
  auto mesh = icosphere<double>(2, 0.8);
  const Pose ahead(Eigen::Matrix3d::Identity(), {0, 0, 3});
  Image<double> depth(80, 60, nothing);
  const auto refused = [&](const Mesh<double>& bad, const Pose& pose, const std::string& why) {
    CHECK_THROWS_WITH_AS(rasterize_into(depth, bad, pose, camera), doctest::Contains(why.c_str()),
                         InvalidInput);
    CHECK(depth == Image<double>(80, 60, nothing));
  };
  auto bad = mesh;
  bad.faces.back()[1] = 9999;
  refused(bad, ahead, "has vertex 9999");
  bad = mesh;
  bad.positions.back() = {0.5, std::nan(""), -0.25};
  const std::string last = "vertex " + std::to_string(bad.positions.size() - 1) + " at ";
  refused(bad, ahead, last + "(0.5, nan, -0.25) is not finite");
  // Of finite numbers, one that the pose takes out of range.
  bad.positions.back() = {0, 1e300, 0};
  refused(bad, {1e10 * Eigen::Matrix3d::Identity(), {0, 0, 3}},
          last + "(0, inf, 3) is farther off than ");
  refused(mesh, {Eigen::Matrix3d::Identity(), {0, nothing, 3}},
          "the pose's translation (0, inf, 3) is not finite");
  Pose turned_nowhere = ahead;
  turned_nowhere.rotation(0, 1) = std::nan("");
  refused(mesh, turned_nowhere, "the pose's rotation (0, 1) is nan, not finite");
  Image<double> small(79, 60);
  CHECK_THROWS_AS(rasterize_into(small, mesh, ahead, camera), InvalidInput);
  Image<double> turned(60, 80);
  CHECK_THROWS_WITH_AS(rasterize_into(turned.view().transposed(), mesh, ahead, camera),
                       "the pixels of the depth image's rows do not lie side by side",
                       InvalidInput);
}

TEST_CASE_TEMPLATE("a face that is cut is refused before anything is drawn, or seen by rasterize",
                   T, float, double) {
  // Before the last face, which reaches far beside the image and perhaps out of the range of
  // depths, others are drawn.
  const auto eye = camera.cast<T>();
  std::mt19937 random(8);
  std::uniform_real_distribution<double> any(-1, 1);
  int refused = 0, seen = 0;
  for (int i = 0; i < 1500; ++i) {
    const auto far = [&] {
      return std::pow(10.0, std::uniform_real_distribution<double>(
                                sizeof(T) == 4 ? 20 : 135, sizeof(T) == 4 ? 60 : 158)(random));
    };
    Mesh<double> mesh = box<double>(1, 1, 1);
    for (auto& p : mesh.positions) p[2] += 5;
    const auto first = static_cast<Index>(mesh.positions.size());
    for (int k = 0; k < 3; ++k) {
      const double size = i % 2 == 0 ? far() : 1 / far();
      mesh.positions.push_back({size * any(random), size * any(random), size * any(random)});
    }
    mesh.faces.push_back({first, first + 1, first + 2});
    Image<T> depth(80, 60, std::numeric_limits<T>::infinity());
    const Image<T> before = depth;
    std::string refusal;
    try {
      (void)rasterize(mesh, eye);
    } catch (const InvalidInput& error) {
      refusal = error.what();
    }
    RasterWorkspace work;
    for (RasterWorkspace* given : {static_cast<RasterWorkspace*>(nullptr), &work}) {
      depth = before;
      Raster<T> raster = empty_raster(eye);
      if (refusal.empty()) {
        rasterize_into(depth, mesh, Pose(), eye, given);
        rasterize_into(raster, mesh, Pose(), eye, given);
        CHECK(are_same(depth, rasterize(mesh, eye).depth));
        CHECK(are_same(depth, raster.depth));
      } else {
        CHECK_THROWS_WITH_AS(rasterize_into(depth, mesh, Pose(), eye, given), refusal.c_str(),
                             InvalidInput);
        CHECK_THROWS_AS(rasterize_into(raster, mesh, Pose(), eye, given), InvalidInput);
        CHECK(depth == before);
        CHECK(raster.depth == before);
      }
    }
    (refusal.empty() ? seen : refused) += 1;
  }
  CHECK(refused > 50);
  CHECK(seen > 50);
}

namespace {

// What is seen of some meshes drawn one after the other, by drawing each of their faces alone, in
// the order of the mesh: the first that is nearer than all before it is seen.
Raster<float> one_by_one(const std::vector<Mesh<double>>& meshes, const Camera<float>& eye) {
  Raster<float> raster = empty_raster(eye);
  for (const auto& mesh : meshes) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      Mesh<double> face;
      for (const Index v : mesh.faces[f]) {
        face.positions.push_back(mesh.positions[static_cast<std::size_t>(v)]);
      }
      face.faces = {{0, 1, 2}};
      const Image<float> before = raster.depth;
      rasterize_into(raster, face, Pose(), eye);
      for (std::size_t i = 0; i < before.pixels().size(); ++i) {
        if (raster.depth.pixels()[i] < before.pixels()[i]) {
          raster.face.pixels()[i] = static_cast<Index>(f);
        }
      }
    }
  }
  return raster;
}

Mesh<double> turned_inside_out(Mesh<double> mesh) {
  for (auto& face : mesh.faces) std::swap(face[1], face[2]);
  return mesh;
}

Mesh<double> both_of(const Mesh<double>& first, const Mesh<double>& second) {
  return joined<double>(std::vector{first, second});
}

}  // namespace

TEST_CASE("faces that look away are seen wherever nothing is before them") {
  // Closed meshes with holes in them, of faces large and small, through which their insides show.
  std::mt19937 random(11);
  RasterWorkspace work;
  const Camera<float> eye = Camera<double>{60, 60, 30.7, 25.1, 63, 50}.cast<float>();
  int from_inside = 0;
  for (int round = 0; round < 12; ++round) {
    std::vector<Mesh<double>> meshes;
    for (const auto& mesh : {icosphere<double>(round % 4, 0.8), torus<double>(0.8, 0.3, 30, 14)}) {
      Mesh<double> open = moved(mesh, random_pose(random, round % 3 == 0 ? 0 : 3));
      std::erase_if(open.faces, [&](const auto&) { return random() % 5 == 0; });
      meshes.push_back(round % 2 == 0 ? open : turned_inside_out(open));
    }
    const auto expected = one_by_one(meshes, eye);
    Raster<float> raster = empty_raster(eye);
    Image<float> depth = raster.depth;
    for (const auto& mesh : meshes) {
      rasterize_into(raster, mesh, Pose(), eye, &work);
      rasterize_into(depth, mesh, Pose(), eye, &work);
    }
    CHECK(depth == expected.depth);
    CHECK(raster.depth == expected.depth);
    CHECK(raster.face == expected.face);
    const auto& last = meshes.back();
    for (const Index f : raster.face.pixels()) {
      if (f < 0 || static_cast<std::size_t>(f) >= last.faces.size()) continue;
      const auto& [a, b, c] = last.faces[static_cast<std::size_t>(f)];
      const auto at = [&](Index v) {
        const auto& p = last.positions[static_cast<std::size_t>(v)];
        return Eigen::Vector3d(p[0], p[1], p[2]);
      };
      from_inside += (at(b) - at(a)).cross(at(c) - at(a)).dot(at(a)) > 0 ? 1 : 0;
    }
  }
  CHECK(from_inside > 1000);
}

TEST_CASE("of faces at the same place the first is seen, whichever way they look") {
  // Drawn by one call, or by several: then what was there before stays.
  const Camera<float> eye = Camera<double>{60, 60, 30.7, 25.1, 63, 50}.cast<float>();
  std::mt19937 random(12);
  RasterWorkspace work;
  for (int round = 0; round < 8; ++round) {
    const auto ball = moved(icosphere<double>(round % 4, 0.8), random_pose(random, 0));
    const auto other = turned_inside_out(ball);
    const auto both = both_of(ball, other), reversed = both_of(other, ball);
    const std::vector<std::vector<Mesh<double>>> scenes{
        {both}, {reversed}, {ball, both}, {other, reversed}, {both, other, ball}, {ball, ball}};
    for (const auto& meshes : scenes) {
      const auto expected = one_by_one(meshes, eye);
      Raster<float> raster = empty_raster(eye);
      for (const auto& mesh : meshes) rasterize_into(raster, mesh, Pose(), eye, &work);
      CHECK(raster.depth == expected.depth);
      CHECK(raster.face == expected.face);
    }
  }
}

// What is seen of faces that face the camera, with corners at whole half pixels: first those of
// the least depth, then those that are first in the mesh.
struct FlatFace {
  std::array<std::array<int, 2>, 3> corners;
  int depth;

  [[nodiscard]] bool covers(int u, int v) const {
    const auto& [a, b, c] = corners;
    const int p = area(a, b, {2 * u, 2 * v}), q = area(b, c, {2 * u, 2 * v}),
              r = area(c, a, {2 * u, 2 * v});
    if (area(a, b, c) == 0) return false;
    return (p >= 0 && q >= 0 && r >= 0) || (p <= 0 && q <= 0 && r <= 0);
  }
  [[nodiscard]] static int area(std::array<int, 2> a, std::array<int, 2> b, std::array<int, 2> c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }
};

TEST_CASE(
    "small faces with pixels on their sides are seen as whole numbers tell, first ones first") {
  std::mt19937 random(27);
  const auto any = [&](int from, int to) {
    return from + static_cast<int>(random() % static_cast<unsigned>(to - from + 1));
  };
  RasterWorkspace work;
  for (int view = 0; view < 300; ++view) {
    const Camera<double> eye{16, 16, 0, 0, any(1, 30), any(1, 30)};
    std::vector<FlatFace> faces(static_cast<std::size_t>(any(1, 120)));
    Mesh<double> mesh;
    for (auto& face : faces) {
      const int x = any(-2, 2 * eye.width), y = any(-2, 2 * eye.height), size = any(1, 24);
      face.depth = any(1, 2);
      for (auto& [column, row] : face.corners) {
        column = x + any(0, size), row = y + any(0, size);
        mesh.positions.push_back(
            {face.depth * column / 32.0, face.depth * row / 32.0, static_cast<double>(face.depth)});
      }
      const auto n = static_cast<Index>(mesh.positions.size());
      mesh.faces.push_back({n - 3, n - 2, n - 1});
    }
    auto with = empty_raster(eye), without = with;
    Image<double> depth(eye.width, eye.height, nothing);
    rasterize_into(with, mesh, Pose(), eye, &work);
    rasterize_into(without, mesh, Pose(), eye);
    rasterize_into<double>(depth, mesh, Pose(), eye, &work);
    int wrong = 0;
    for (int v = 0; v < eye.height; ++v) {
      for (int u = 0; u < eye.width; ++u) {
        Index first = -1;
        double z = nothing;
        for (std::size_t f = 0; f < faces.size(); ++f) {
          if (faces[f].covers(u, v) && faces[f].depth < z) {
            first = static_cast<Index>(f), z = faces[f].depth;
          }
        }
        wrong += with.face(u, v) != first || with.depth(u, v) != z;
        wrong += without.face(u, v) != first || without.depth(u, v) != z;
        wrong += depth(u, v) != z;
      }
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE(
    "what earlier calls drew stays in front of a face at the same depth, for any number of calls") {
  // More calls than a byte counts, into images of several sizes.
  RasterWorkspace work;
  const Mesh<double> sheet{{{-1, -1, 2}, {1, -1, 2}, {1, 1, 2}, {-1, 1, 2}},
                           {{0, 1, 2}, {0, 2, 3}}};
  const Mesh<double> two = both_of(turned_inside_out(sheet), sheet);
  for (int call = 0; call < 600; ++call) {
    const Index width = call % 7 == 0 ? 40 : 16;
    const Camera<float> eye = Camera<double>{8, 8, 8.3, 7.9, width, 17}.cast<float>();
    Raster<float> raster = empty_raster(eye);
    raster.depth.pixels()[5 * static_cast<std::size_t>(width) + 8] = 2;
    raster.face.pixels()[5 * static_cast<std::size_t>(width) + 8] = 77;
    rasterize_into(raster, two, Pose(), eye, &work);
    int wrong = 0;
    for (const Index f : raster.face.pixels()) wrong += f == 77 || f < 2 ? 0 : 1;
    CHECK(wrong == 0);
    CHECK(raster.face(8, 5) == 77);
    CHECK(raster.face(8, 8) >= 0);
  }
}

TEST_CASE("a longer type than double shows what double does") {
  // With faces that are cut, held back, wide and narrow.
  auto mesh = icosphere<double>(4, 0.9);
  for (auto& p : mesh.positions) p[2] += 1.2;
  const auto sheet = grid<double>(2, 2, 30, 30);
  for (const auto& p : sheet.positions)
    mesh.positions.push_back({p[0] - 15, p[1] - 15, 1.5 + p[1] / 9});
  const auto offset = static_cast<Index>(mesh.positions.size() - sheet.positions.size());
  for (const auto& f : sheet.faces) {
    mesh.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  }
  Mesh<long double> same;
  same.faces = mesh.faces;
  for (const auto& p : mesh.positions) same.positions.push_back({p[0], p[1], p[2]});

  const Camera<double> eye{40, 40, 31.5, 23.5, 64, 48};
  const auto longer = eye.cast<long double>();
  const auto expected = rasterize(mesh, eye);
  const auto raster = rasterize(same, longer);
  auto depth = empty_raster(longer).depth;
  auto expected_depth = empty_raster(eye).depth;
  RasterWorkspace work;
  rasterize_into<long double>(depth, same, {}, longer, &work);
  rasterize_into<double>(expected_depth, mesh, {}, eye, &work);
  // Pixels one by one and several at once: products need not be fused with sums alike.
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
#else
  constexpr double rounding = 0;
#endif
  const auto is_same = [](long double is, double was) {
    return is == was || (std::isfinite(was) && std::abs(is - was) <= rounding * was);
  };
  int seen = 0;
  for (Index v = 0; v < eye.height; ++v) {
    for (Index u = 0; u < eye.width; ++u) {
      seen += expected.face(u, v) >= 0;
      CHECK(is_same(depth(u, v), expected_depth(u, v)));
      CHECK(is_same(raster.depth(u, v), expected.depth(u, v)));
      CHECK(raster.face(u, v) == expected.face(u, v));
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(raster.barycentric(u, v)[k] == expected.barycentric(u, v)[k]);
      }
    }
  }
  CHECK(seen > 1000);
}
