#include "gelight/image/plane_fit.hpp"

#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/refusal.hpp"

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
  int edge_on = 0;
  for (const Index radius : {1, 2, 5}) {
    const auto normals = plane_fit_normals(depth, camera, radius);
    for (Index y = 0; y < 24; ++y) {
      for (Index x = 0; x < 32; ++x) {
        if (std::isnan(depth(x, y))) {
          CHECK(normals(x, y) == Vec3<double>::Zero());
          continue;
        }
        const Vec3<double> least = fitted(depth, x, y, radius);
        if (least.dot(camera.ray(x, y).normalized()) > -0.011) {
          ++edge_on;
        } else {
          CHECK((normals(x, y) - least).norm() < 1e-7);
        }
      }
    }
  }
  CHECK(edge_on <= 1);
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

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// A rough surface of which a share of the pixels is known.
Image<double> scattered(std::mt19937& random, double share, double roughness) {
  std::uniform_real_distribution<double> one(0, 1);
  auto depth = plane(Vec3<double>(one(random) - 0.5, one(random) - 0.5, -1).normalized());
  for (double& z : depth.pixels()) {
    z = one(random) < share ? z * (1 + roughness * (one(random) - 0.5)) : unknown;
  }
  return depth;
}

// Whether the known pixels of a window lie on a line, or are none, in whole numbers.
bool is_on_a_line(const Image<double>& depth, Index u, Index v, Index radius) {
  std::vector<std::array<Index, 2>> known;
  for (Index y = std::max(0, v - radius); y <= std::min(camera.height - 1, v + radius); ++y) {
    for (Index x = std::max(0, u - radius); x <= std::min(camera.width - 1, u + radius); ++x) {
      if (std::isfinite(depth(x, y))) known.push_back({x, y});
    }
  }
  for (const auto& a : known) {
    for (const auto& b : known) {
      const auto& o = known.front();
      if ((a[0] - o[0]) * (b[1] - o[1]) != (a[1] - o[1]) * (b[0] - o[0])) return false;
    }
  }
  return true;
}

}  // namespace

TEST_CASE("around holes: a unit normal towards the camera, or none where pixels are on a line") {
  std::mt19937 random(8);
  int lines = 0, edges = 0;
  for (const double roughness : {0.0, 1e-6, 1e-3, 0.03, 0.3, 1.0}) {
    for (const double share : {0.1, 0.2, 0.4, 0.7}) {
      for (const Index radius : {1, 2, 3}) {
        const auto depth = scattered(random, share, roughness);
        const auto normals = plane_fit_normals(depth, camera, radius);
        for (Index y = 0; y < camera.height; ++y) {
          for (Index x = 0; x < camera.width; ++x) {
            const Vec3<double>& n = normals(x, y);
            CAPTURE(roughness);
            if (!std::isfinite(depth(x, y)) || is_on_a_line(depth, x, y, radius)) {
              lines += std::isfinite(depth(x, y));
              CHECK(n == Vec3<double>::Zero());
              continue;
            }
            CHECK(std::abs(n.norm() - 1) < 1e-12);
            const double facing = n.dot(camera.ray(x, y).normalized());
            CHECK(facing < 0);
            // That of least variance, but where this is seen edge-on.
            const Vec3<double> least = fitted(depth, x, y, radius);
            if (least.dot(camera.ray(x, y).normalized()) < -0.011 && roughness >= 1e-3) {
              CHECK((n - least).norm() < 1e-5);
            } else if (roughness >= 1e-3) {
              ++edges;
            }
          }
        }
      }
    }
  }
  CHECK(lines > 1000);
  CHECK(edges > 50);
}

TEST_CASE("normals do not turn round where a depth hardly changes, also beside holes") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> one(0, 1);
  for (const double roughness : {0.01, 0.1, 1.0}) {
    for (const double share : {0.2, 0.3, 0.6, 1.0}) {
      const auto depth = scattered(random, share, roughness);
      auto near = depth;
      for (double& z : near.pixels()) z *= 1 + 1e-13 * (one(random) - 0.5);
      for (const Index radius : {1, 2}) {
        const auto a = plane_fit_normals(depth, camera, radius);
        const auto b = plane_fit_normals(near, camera, radius);
        double worst = 0;
        for (std::size_t i = 0; i < a.pixels().size(); ++i) {
          worst = std::max(worst, (a.pixels()[i] - b.pixels()[i]).norm());
        }
        CHECK(worst < 1e-4);
      }
    }
  }
}

TEST_CASE("a window of two rows turns steadily as its surface is turned through edge-on") {
  // A bent row of pixels, and one more beside it that moves through where the plane of least
  // variance passes the camera.
  const Camera<double> eye{600, 600, 2, 1, 5, 3};
  for (const double bend : {0.003, 0.03, 0.3}) {
    for (const Index beside : {0, 1, 3, 4}) {
      Image<double> depth(5, 3, unknown);
      for (Index x = 0; x < 5; ++x) depth(x, 1) = 1 + bend * (x - 2) * (x - 2);
      Vec3<double> last = Vec3<double>::Zero();
      double turned = 0;
      constexpr int steps = 20000;
      for (int i = 0; i <= steps; ++i) {
        depth(beside, 0) = depth(beside, 1) + 2.0 * bend * (2.0 * i / steps - 1);
        const Vec3<double> n = plane_fit_normals(depth, eye, 2)(2, 1);
        CHECK(n.dot(eye.ray(2, 1)) < 0);
        if (i > 0) turned = std::max(turned, (n - last).norm());
        last = n;
      }
      CAPTURE(bend);
      CAPTURE(beside);
      CHECK(turned < 0.3);
    }
  }
}

TEST_CASE("depths of any unit have the same normals, or are refused by place") {
  std::mt19937 random(6);
  const auto depth = scattered(random, 0.8, 0.01);
  const auto normals = plane_fit_normals(depth, camera, 2);
  for (const double scale : {1e-135, 1e-100, 1e-80, 1e-30, 1e-6, 1e6, 1e60, 1e135}) {
    auto scaled = depth;
    for (double& z : scaled.pixels()) z *= scale;
    const auto same = plane_fit_normals(scaled, camera, 2);
    double worst = 0;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      worst = std::max(worst, (normals.pixels()[i] - same.pixels()[i]).norm());
    }
    CAPTURE(scale);
    CHECK(worst < 1e-8);
  }
  const auto tiny = plane(Vec3<double>(0.2, 0.1, -1).normalized());
  Image<float> floats(camera.width, camera.height);
  for (const double scale : {1e-30, 1e-12, 1e12, 1e35}) {
    for (std::size_t i = 0; i < tiny.pixels().size(); ++i) {
      floats.pixels()[i] = static_cast<float>(tiny.pixels()[i] * scale);
    }
    for (const auto& n : plane_fit_normals(floats, camera.cast<float>(), 1).pixels()) {
      CHECK((n.cast<double>() - Vec3<double>(0.2, 0.1, -1).normalized()).norm() < 1e-4);
    }
  }
  for (const double bad : {1e-160, 5e-324, 1e150}) {
    auto far = depth;
    far(7, 9) = bad;
    CHECK(test::contains(test::refusal([&] { (void)plane_fit_normals(far, camera, 2); }),
                         "at pixel (7, 9) is not between"));
  }
  // At whatever depth, such rays lead to where squares are no numbers.
  Camera<double> wide = camera, off = camera;
  wide.fx = 1e-150;
  off.cy = -1e150;
  for (const Camera<double>& eye : {wide, off}) {
    CHECK(test::contains(test::refusal([&] { (void)plane_fit_normals(depth, eye, 2); }),
                         "at pixel (0, 0) is not between"));
  }
}

TEST_CASE("points that span no plane have no normal") {
  const Camera<double> row{40, 40, 3, 0, 7, 1};
  for (const Vec3<double>& n : plane_fit_normals(Image<double>(7, 1, 0.03), row, 2).pixels()) {
    CHECK(n == Vec3<double>::Zero());
  }
  CHECK_THROWS_AS((void)plane_fit_normals(Image<double>(7, 1, 0.03), row, 0), InvalidInput);
  CHECK_THROWS_AS((void)plane_fit_normals(Image<double>(7, 2, 0.03), row, 2), InvalidInput);
}
