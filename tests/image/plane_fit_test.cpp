#include "gelight/image/plane_fit.hpp"

#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <random>

using namespace gelight;

namespace {

const Camera<double> camera{40, 44, 15.5, 11, 32, 24};

Image<double> plane(const Vec3<double>& normal, double noise = 0) {
  std::mt19937 random(2);
  std::normal_distribution<double> error(0, 1);
  Image<double> depth(camera.width, camera.height);
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) {
      depth(x, y) = -0.03 / normal.dot(camera.ray(x, y)) + noise * error(random);
    }
  }
  return depth;
}

// The same, every window on its own.
Vec3<double> fitted(const Image<double>& depth, Index u, Index v, Index radius) {
  std::vector<Vec3<double>> points;
  Vec3<double> mean = Vec3<double>::Zero();
  for (Index y = std::max(0, v - radius); y <= std::min(camera.height - 1, v + radius); ++y) {
    for (Index x = std::max(0, u - radius); x <= std::min(camera.width - 1, u + radius); ++x) {
      if (!std::isfinite(depth(x, y))) continue;
      points.push_back(camera.unproject(x, y, depth(x, y)));
      mean += points.back();
    }
  }
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Vec3<double> n = solver.eigenvectors().col(0);
  return n.dot(camera.ray(u, v)) > 0 ? Vec3<double>(-n) : n;
}

}  // namespace

TEST_CASE("a plane's normal, at every pixel and for every window") {
  const Vec3<double> normal = Vec3<double>(-0.4, 0.3, -1).normalized();
  for (const Index radius : {1, 3, 40}) {
    const auto normals = plane_fit_normals(plane(normal), camera, radius);
    for (const Vec3<double>& n : normals.pixels()) CHECK((n - normal).norm() < 1e-9);
  }
}

TEST_CASE("shared sums give what each window gives on its own, also around unknown depths") {
  auto depth = plane(Vec3<double>(0.2, -0.1, -1).normalized(), 3e-4);
  depth(4, 4) = depth(5, 4) = depth(20, 23) = std::numeric_limits<double>::quiet_NaN();
  for (const Index radius : {1, 2, 5}) {
    const auto normals = plane_fit_normals(depth, camera, radius);
    for (Index y = 0; y < 24; ++y) {
      for (Index x = 0; x < 32; ++x) {
        if (std::isnan(depth(x, y))) {
          CHECK(normals(x, y) == Vec3<double>::Zero());
        } else {
          CHECK((normals(x, y) - fitted(depth, x, y, radius)).norm() < 1e-7);
        }
      }
    }
  }
}

TEST_CASE("a depth a million times as far leaves nothing behind in windows that do not see it") {
  const Vec3<double> normal = Vec3<double>(0.3, -0.2, -1).normalized();
  auto depth = plane(normal);
  depth(9, 8) = 3e4;
  for (const Index radius : {1, 2, 4}) {
    const auto normals = plane_fit_normals(depth, camera, radius);
    for (Index y = 0; y < 24; ++y) {
      for (Index x = 0; x < 32; ++x) {
        const bool sees_it = std::abs(x - 9) <= radius && std::abs(y - 8) <= radius;
        if (!sees_it) CHECK((normals(x, y) - normal).norm() < 1e-9);
      }
    }
  }
}

TEST_CASE("float depths: the normals of double, from depths rounded to float") {
  const auto exact = plane(Vec3<double>(0.2, 0.5, -1).normalized(), 2e-4);
  Image<float> depth(32, 24);
  Image<double> rounded(32, 24);
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    depth.pixels()[i] = static_cast<float>(exact.pixels()[i]);
    rounded.pixels()[i] = double{depth.pixels()[i]};
  }
  const auto eye = camera.cast<float>();
  const auto normals = plane_fit_normals(depth, eye, 2);
  const auto want = plane_fit_normals(rounded, eye.cast<double>(), 2);
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    CHECK((normals.pixels()[i].cast<double>() - want.pixels()[i]).norm() < 1e-6);
  }
}

TEST_CASE("a wider window is calmer under noise") {
  const Vec3<double> normal(0, 0, -1);
  double worst[2] = {0, 0};
  for (const int k : {0, 1}) {
    const auto normals = plane_fit_normals(plane(normal, 1e-4), camera, k == 0 ? 1 : 4);
    for (Index y = 4; y < 20; ++y) {
      for (Index x = 4; x < 28; ++x) worst[k] = std::max(worst[k], (normals(x, y) - normal).norm());
    }
  }
  CHECK(worst[1] < worst[0] / 4);
}

TEST_CASE("points that span no plane have no normal") {
  const Camera<double> row{40, 40, 3, 0, 7, 1};
  for (const Vec3<double>& n : plane_fit_normals(Image<double>(7, 1, 0.03), row, 2).pixels()) {
    CHECK(n == Vec3<double>::Zero());
  }
  CHECK_THROWS_AS((void)plane_fit_normals(Image<double>(7, 1, 0.03), row, 0), InvalidInput);
  CHECK_THROWS_AS((void)plane_fit_normals(Image<double>(7, 2, 0.03), row, 2), InvalidInput);
}
