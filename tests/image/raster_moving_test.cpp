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
      CHECK(with.depth == expected.depth);
      CHECK(with.face == expected.face);
      CHECK(with.barycentric == expected.barycentric);
      CHECK(without.depth == expected.depth);
      CHECK(without.face == expected.face);
      CHECK(depth == expected.depth);
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
      CHECK(depth == nearest);
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
  bad.positions.back()[1] = std::nan("");
  refused(bad, ahead, "is not finite");
  refused(mesh, {Eigen::Matrix3d::Identity(), {0, nothing, 3}}, "is not finite");
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
        CHECK(depth == rasterize(mesh, eye).depth);
        CHECK(depth == raster.depth);
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
