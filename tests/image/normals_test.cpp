#include "gelight/image/normals.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "gelight/image/plane_fit.hpp"
#include "reference.hpp"
#include "support/approx.hpp"

using namespace gelight;

namespace {

const Camera<double> camera{40, 44, 15.5, 11, 32, 24};

// Depth of the plane normal . p = distance.
Image<double> plane(const Vec3<double>& normal, double distance) {
  Image<double> depth(camera.width, camera.height);
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) depth(x, y) = distance / normal.dot(camera.ray(x, y));
  }
  return depth;
}

template <class T = double>
Image<T> rough(unsigned seed = 3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.02, 0.03);
  Image<T> depth(camera.width, camera.height);
  for (T& z : depth.pixels()) z = static_cast<T>(uniform(random));
  return depth;
}

// The same by its definition: the cross product of the point cloud's own derivatives.
Vec3<double> by_definition(const Gradient<Vec3<double>>& slope, Index x, Index y) {
  return -slope.x(x, y).cross(slope.y(x, y)).normalized();
}

}  // namespace

TEST_CASE("a plane's normal, everywhere and at any tilt") {
  for (const Vec3<double>& towards : {Vec3<double>(0, 0, -1), Vec3<double>(0.5, -0.2, -1),
                                      Vec3<double>(-0.8, 0.9, -1.5), Vec3<double>(0, 1.2, -1.0)}) {
    const Vec3<double> normal = towards.normalized();
    const auto normals = sobel_normals(plane(normal, -0.03), camera, BorderNormals::none);
    for (Index y = 1; y < 23; ++y) {
      for (Index x = 1; x < 31; ++x) CHECK((normals(x, y) - normal).norm() < 1e-13);
    }
  }
}

TEST_CASE("rough depth: the cross product of the point cloud's Sobel derivatives") {
  const auto depth = rough();
  const auto slope = sobel(unproject(depth, camera));
  const auto normals = sobel_normals(depth, camera);
  for (Index y = 1; y < 23; ++y) {
    for (Index x = 1; x < 31; ++x) {
      CHECK((normals(x, y) - by_definition(slope, x, y)).norm() < 1e-13);
    }
  }
}

TEST_CASE("float keeps a rough surface's normals to 1e-5 and a smooth one's to its own precision") {
  const auto coarse = sobel_normals(rough<float>(), camera.cast<float>());
  const auto fine = sobel_normals(rough(), camera);
  double worst = 0;
  for (Index y = 1; y < 23; ++y) {
    for (Index x = 1; x < 31; ++x) {
      worst = std::max(worst, (coarse(x, y).cast<double>() - fine(x, y)).norm());
    }
  }
  CHECK(worst < 1e-5);
}

TEST_CASE("a sphere: the error falls with the square of the pixel size") {
  const Vec3<double> centre(0, 0, 0.05);
  double worst[2] = {0, 0};
  for (const int level : {0, 1}) {
    const Index n = 64 << level;
    const Camera<double> eye{double(n), double(n), (n - 1) / 2.0, (n - 1) / 2.0, n, n};
    Image<double> depth(n, n);
    for (Index y = 0; y < n; ++y) {
      for (Index x = 0; x < n; ++x) {
        // The sphere of radius 0.04 around the centre, seen from outside.
        const Vec3<double> ray = eye.ray(x, y);
        const double a = ray.squaredNorm(), b = ray.dot(centre);
        depth(x, y) = (b - std::sqrt(b * b - a * (centre.squaredNorm() - 0.04 * 0.04))) / a;
      }
    }
    const auto normals = sobel_normals(depth, eye);
    for (Index y = n / 4; y < 3 * n / 4; ++y) {
      for (Index x = n / 4; x < 3 * n / 4; ++x) {
        const Vec3<double> outward = (eye.unproject(x, y, depth(x, y)) - centre).normalized();
        worst[level] = std::max(worst[level], (normals(x, y) - outward).norm());
      }
    }
  }
  CHECK(worst[0] < 0.002);
  CHECK(worst[0] / worst[1] > 3.5);
}

TEST_CASE("normals have unit length and face the camera, at grazing angles and any scale") {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Image<float> depth = rough<float>();
    for (float& z : depth.pixels()) z = static_cast<float>(z * scale);
    depth(9, 9) *= 20;  // a spike
    const auto normals = sobel_normals(depth, camera.cast<float>());
    for (Index y = 1; y < 23; ++y) {
      for (Index x = 1; x < 31; ++x) {
        CHECK(normals(x, y).norm() == gelight::test::approx(1).epsilon(1e-6));
        const Vec3<double> ray = camera.ray(x, y);
        CHECK(normals(x, y).cast<double>().dot(ray) < 0);
      }
    }
  }
}

TEST_CASE("the outermost pixels: none, or the extrapolated surface's") {
  const auto depth = plane({0, 0, -1}, -0.03);
  CHECK(sobel_normals(depth, camera)(0, 5) == Vec3<double>::Zero());
  CHECK(sobel_normals(depth, camera)(7, 23) == Vec3<double>::Zero());
  const auto normals = sobel_normals(depth, camera, BorderNormals::extrapolated);
  for (const Vec3<double>& n : normals.pixels()) CHECK((n - Vec3<double>(0, 0, -1)).norm() < 1e-13);

  const Camera<double> pixel{1, 1, 0, 0, 1, 1};
  const auto alone = sobel_normals(Image<double>(1, 1, 0.03), pixel, BorderNormals::extrapolated);
  CHECK((alone(0, 0) - Vec3<double>(0, 0, -1)).norm() < 1e-13);
}

TEST_CASE_TEMPLATE("however steep a rim is, its normals face the camera", T, float, double) {
  std::mt19937 random(17);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  };
  int steep = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Camera<T> eye{static_cast<T>(between(0.5, 500)),    static_cast<T>(between(0.5, 500)),
                        static_cast<T>(between(0.1, 10)),     static_cast<T>(between(0.1, 10)),
                        static_cast<Index>(1 + random() % 6), static_cast<Index>(1 + random() % 6)};
    const double contrast = between(1.01, 300), scale = between(1e-6, 1e6);
    Image<T> depth(eye.width, eye.height);
    for (T& z : depth.pixels()) z = static_cast<T>(scale * between(1, contrast));
    const auto normals = sobel_normals(depth, eye, BorderNormals::extrapolated);
    for (Index y = 0; y < eye.height; ++y) {
      for (Index x = 0; x < eye.width; ++x) {
        const Vec3<double> n = normals(x, y).template cast<double>();
        const Vec3<double> ray =
            eye.ray(static_cast<T>(x), static_cast<T>(y)).template cast<double>();
        CHECK(std::abs(n.norm() - 1) < 1e-5);
        CHECK(n.dot(ray) < 1e-6 * ray.norm());
        if (eye.width > 1) steep += depth(0, y) < depth(1, y) / 2;
      }
    }
  }
  CHECK(steep > 100);
}

TEST_CASE("a depth that is not known leaves its eight neighbours and itself without a normal") {
  auto depth = rough();
  const auto whole = sobel_normals(depth, camera);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    depth(10, 10) = bad;
    const auto normals = sobel_normals(depth, camera);
    for (Index y = 1; y < 23; ++y) {
      for (Index x = 1; x < 31; ++x) {
        const bool beside = std::abs(x - 10) <= 1 && std::abs(y - 10) <= 1;
        if (!beside) CHECK(normals(x, y) == whole(x, y));
        if (beside && !(x == 10 && y == 10)) CHECK(normals(x, y) == Vec3<double>::Zero());
        CHECK(normals(x, y).allFinite());
      }
    }
    CHECK(normals(10, 10) == Vec3<double>::Zero());
  }
}

TEST_CASE(
    "central differences: a plane's normal, and the point cloud's differences on a rough one") {
  const Vec3<double> normal = Vec3<double>(-0.5, 0.3, -1).normalized();
  const auto flat = central_normals(plane(normal, -0.03), camera);
  const auto depth = rough();
  const auto points = unproject(depth, camera);
  const auto normals = central_normals(depth, camera);
  for (Index y = 1; y < 23; ++y) {
    for (Index x = 1; x < 31; ++x) {
      CHECK((flat(x, y) - normal).norm() < 1e-13);
      const Vec3<double> across = points(x + 1, y) - points(x - 1, y);
      const Vec3<double> down = points(x, y + 1) - points(x, y - 1);
      CHECK((normals(x, y) + across.cross(down).normalized()).norm() < 1e-13);
    }
  }
  CHECK(flat(0, 5) == Vec3<double>::Zero());
  auto holed = depth;
  holed(10, 10) = std::numeric_limits<double>::quiet_NaN();
  const auto around = central_normals(holed, camera);
  CHECK(around(10, 10) == Vec3<double>::Zero());
  CHECK(around(11, 10) == Vec3<double>::Zero());
  CHECK(around(11, 11) == normals(11, 11));
}

TEST_CASE("another size than the camera's is refused") {
  CHECK_THROWS_WITH_AS((void)sobel_normals(Image<double>(3, 4), camera),
                       "the depth image is 3 x 4 pixels, the camera's image 32 x 24", InvalidInput);
}

TEST_CASE("the published normals of the membrane at rest and of contact 2") {
  if (reference::is_absent()) return;
  // Those at rest are published as they come out of the cross product, away from the camera.
  const auto contact = reference::stage<float>("deformed_depth_contact_2");
  for (const bool at_rest : {true, false}) {
    const auto published =
        reference::stage<Vec3<float>>(at_rest ? "rest_normals" : "normals_contact_2");
    const auto normals =
        sobel_normals(at_rest ? reference::depth("rest") : contact, reference::camera<double>());
    const double sign = at_rest ? -1 : 1;
    double worst = 0;
    for (Index y = 1; y < 479; ++y) {
      for (Index x = 1; x < 639; ++x) {
        worst = std::max(worst, (normals(x, y) - sign * published(x, y).cast<double>()).norm());
      }
    }
    CHECK(worst < 1e-6);
  }
}

TEST_CASE_TEMPLATE("a normal is of unit length or zero, and the same whatever the depths' unit", T,
                   float, double) {
  const auto eye = camera.cast<T>();
  const auto whole = rough<T>();
  const auto truth = sobel_normals(rough<double>(), camera);
  const double rounding = 40.0 * static_cast<double>(std::numeric_limits<T>::epsilon());
  for (int exponent = -35; exponent <= 36; ++exponent) {
    CAPTURE(exponent);
    auto depth = whole;
    for (T& z : depth.pixels()) z = static_cast<T>(double{z} * std::pow(10.0, exponent));
    double sobel_off = 0, central_off = 0, fit_off = 0;
    const auto sobel = sobel_normals(depth, eye), central = central_normals(depth, eye),
               fit = plane_fit_normals(depth, eye, 2);
    const auto central_truth = central_normals(rough<double>(), camera);
    const auto fit_truth = plane_fit_normals(rough<double>(), camera, 2);
    const auto off = [](const Vec3<T>& a, const Vec3<double>& b) {
      return (a.template cast<double>() - b).norm();
    };
    for (Index y = 1; y < 23; ++y) {
      for (Index x = 1; x < 31; ++x) {
        sobel_off = std::max(sobel_off, off(sobel(x, y), truth(x, y)));
        central_off = std::max(central_off, off(central(x, y), central_truth(x, y)));
        fit_off = std::max(fit_off, off(fit(x, y), fit_truth(x, y)));
      }
    }
    // Depths themselves are rounded, more below the normal numbers.
    const double of_depths =
        static_cast<double>(std::numeric_limits<T>::denorm_min()) / std::pow(10.0, exponent - 3.0);
    CHECK(sobel_off < 20 * (rounding + of_depths));
    CHECK(central_off < 20 * (rounding + of_depths));
    // Small differences of large sums in double, and where two variances are close.
    CHECK(fit_off < 1e-9 + 100 * (rounding + of_depths));
  }
}

TEST_CASE_TEMPLATE("depths of very different sizes beside each other: unit length or zero", T,
                   float, double) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(-40, 30), one(0, 1);
  const Camera<T> eye{T(40), T(44), T(2), T(1), 5, 3};
  for (int round = 0; round < 20000; ++round) {
    Image<T> depth(5, 3);
    const double middle = exponent(random), spread = 10 * one(random);
    for (T& z : depth.pixels()) {
      z = static_cast<T>(std::pow(10.0, middle + spread * (one(random) - 0.5)));
      if (one(random) < 0.05) z = 0;
    }
    const auto check = [](const Image<Vec3<T>>& normals) {
      for (const Vec3<T>& n : normals.pixels()) {
        const double length = n.template cast<double>().norm();
        if (length != 0 && !(std::abs(length - 1) < 1e-5)) return false;
      }
      return true;
    };
    CHECK(check(sobel_normals(depth, eye)));
    CHECK(check(sobel_normals(depth, eye, BorderNormals::extrapolated)));
    CHECK(check(central_normals(depth, eye)));
    CHECK(check(plane_fit_normals(depth, eye, 1)));
  }
}

TEST_CASE("a lone known depth, as tiny as may be, has no normal that is not one") {
  for (const float tiny : {7.2e-12f, 1e-20f, 1e-38f, 1e-45f}) {
    Image<float> depth(5, 3);
    depth(2, 1) = tiny;
    const Camera<float> eye{4, 4, 2, 1, 5, 3};
    for (const auto& n : sobel_normals(depth, eye).pixels()) CHECK(n == Vec3<float>::Zero());
  }
}
