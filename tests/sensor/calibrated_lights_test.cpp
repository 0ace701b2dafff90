#include "gelight/sensor/calibrated_lights.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "gelight/image/normals.hpp"
#include "gelight/sensor/calibrated.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using gelight::test::contains;
using gelight::test::refusal;

namespace {

constexpr Index width = 96, height = 72;
using Field = Image<Vec3<double>>;

const Image<Rgb8>& gradient() {
  static const Image<Rgb8> made = [] {
    Image<Rgb8> image(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        image(x, y) = {static_cast<std::uint8_t>(110 + x / 4),
                       static_cast<std::uint8_t>(120 - y / 3), 104};
      }
    }
    return image;
  }();
  return made;
}

LightsReflectance fitted() {
  LightsReflectance lights;
  lights.height = double{height} / width;
  lights.softness = 0.3;
  lights.falloff = 0.8;
  lights.shininess = 6;
  lights.ambient = {-0.1, 0.05, 0.02};
  lights.contact = {0.02, -0.03, 0.01};
  lights.free_share = {0.8, 0.9, 1.1};
  lights.lights = {{{1.5, 0.2, 0.9}, {0.5, 0.1, 0}, {0.1, 0.1, 0.1}},
                   {{-1, 1.2, 0.8}, {0, 0.4, 0.2}, {0, 0.05, 0}},
                   {{-0.8, -1.4, 1}, {0.1, 0, 0.5}, {0, 0, 0.1}}};
  return lights;
}

// Flat gel seen from so far that rays are parallel; lights' places are in half images.
Camera<double> far_camera() {
  return {4e5, 4e5, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
}

std::vector<Field> straight(const LightsReflectance& model) {
  std::vector<Field> all;
  for (const NearLight& light : model.lights) {
    Field field(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const Vec3<double> way(light.place.x() - (2.0 * x / (width - 1) - 1),
                               light.place.y() - (2.0 * y / (height - 1) - 1) * model.height,
                               light.place.z());
        // The camera's z goes away from it.
        const Vec3<double> travels = Vec3<double>(-way.x(), -way.y(), way.z()).normalized();
        field(x, y) = std::pow(way.norm(), -model.falloff) * travels;
      }
    }
    all.push_back(std::move(field));
  }
  return all;
}

// Gel that takes an object's shape, and no more.
struct Yielding {
  struct Workspace {};
  [[nodiscard]] Index reach() const { return 0; }
  [[nodiscard]] Workspace make_workspace(Index, Index) const { return {}; }
  void press_into(ImageView<double> surface, const Press<double>& press, Workspace&) const {
    for (Index y = press.window.top; y < press.window.bottom; ++y) {
      for (Index x = press.window.left; x < press.window.right; ++x) {
        surface(x, y) = std::min(press.depth(x, y), press.rest(x, y));
      }
    }
  }
};

// A row of one pixel.
Change shaded(const CalibratedLights<double>& model, Index x, Index y, const Vec3<double>& n,
              bool touched) {
  Change out{};
  const double flag = touched ? 1 : 0;
  SurfaceRow<double> row{x, y, 1, &n.x(), &n.y(), &n.z(), nullptr};
  row.touched = &flag;
  model.shade_row({&out[0], &out[1], &out[2]}, row);
  return out;
}

}  // namespace

TEST_CASE("on flat gel with straight light the fitted lights are what was fitted") {
  const LightsReflectance model = fitted();
  const Field rest(width, height, Vec3<double>(0, 0, -1));
  const CalibratedLights<double> lights(model, gradient(), far_camera(), rest, straight(model));
  for (Index y = 0; y < height; y += 5) {
    for (Index x = 0; x < width; x += 7) {
      for (const bool touched : {false, true}) {
        const double nx = 0.5 * std::sin(3.0 * x + y), ny = 0.5 * std::cos(2.0 * y - x);
        const double nz = std::sqrt(1 - nx * nx - ny * ny);
        const Change seen = shaded(lights, x, y, {nx, ny, -nz}, touched);
        const Change by =
            change(model, {nx, ny, 2.0 * x / (width - 1) - 1, 2.0 * y / (height - 1) - 1, touched});
        for (std::size_t c = 0; c < 3; ++c) {
          const double wanted = gradient()(x, y)[c] / 255.0 * (1 + by[c]) + 0.5 / 255;
          CHECK(std::abs(seen[c] - wanted) < 1e-3);  // rays lean by 1e-4
        }
      }
    }
  }
}

// Diffuse light tells no direction of sight: gel turned with its lights looks as before.
TEST_CASE("a membrane turned with its light field shows the same") {
  LightsReflectance model = fitted();
  for (NearLight& light : model.lights) light.specular = {};
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.7, Vec3<double>(1, 2, 0.5).normalized())).toRotationMatrix();
  Field rest(width, height, Vec3<double>(0, 0, -1));
  std::vector<Field> field = straight(model);
  const CalibratedLights<double> flat(model, gradient(), far_camera(), rest, field);
  for (auto& n : rest.pixels()) n = turn * n;
  for (Field& one : field) {
    for (auto& d : one.pixels()) d = turn * d;
  }
  const CalibratedLights<double> turned(model, gradient(), far_camera(), rest, field);
  double most = 0;
  for (const double lean : {0.0, 0.2, 0.6}) {
    for (const bool touched : {false, true}) {
      const Vec3<double> n = Vec3<double>(lean, -0.5 * lean, -1).normalized();
      const Change one = shaded(flat, 30, 50, n, touched);
      const Change other = shaded(turned, 30, 50, turn * n, touched);
      for (std::size_t c = 0; c < 3; ++c) {
        CHECK(one[c] == gelight::test::approx(other[c]).epsilon(1e-12));
        most = std::max(most, std::abs(one[c] - gradient()(30, 50)[c] / 255.0));
      }
    }
  }
  CHECK(most > 0.02);  // there was something to see
}

// A dome of gel, lit along its great circles, as light goes that stays within it.
TEST_CASE("on a dome lit along geodesics what is at rest is the background, and dents are shaded") {
  const Camera<double> camera{120, 120, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
  const Vec3<double> centre(0, 0, 4);
  Image<double> rest(width, height), pressed(width, height);
  const auto dome = [&](Index x, Index y, double radius) {
    const Vec3<double> ray = camera.ray(x, y);
    const double along = ray.dot(centre) / ray.squaredNorm();
    const double left = radius * radius - (along * ray - centre).squaredNorm();
    return along + std::sqrt(left / ray.squaredNorm());  // the far side: it is seen from within
  };
  LightsReflectance model = fitted();
  const std::vector<Vec3<double>> leds{{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}};
  std::vector<Field> field(3, Field(width, height));
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      rest(x, y) = dome(x, y, 3);
      const double dent = 0.4 * std::exp(-(std::pow(x - 40.0, 2) + std::pow(y - 30.0, 2)) / 60);
      pressed(x, y) = dent > 1e-6 ? dome(x, y, 3 - dent) : rest(x, y);
      const Vec3<double> up = (camera.unproject(x, y, rest(x, y)) - centre).normalized();
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3<double> led = leds[k].normalized();
        const double angle = std::acos(std::clamp(led.dot(up), -1.0, 1.0));
        // Along the great circle away from the LED, fainter as it goes.
        const Vec3<double> travels = (up * std::cos(angle) - led) / std::sin(angle);
        field[k](x, y) = travels.normalized() / (1 + angle);
      }
    }
  }
  const Field normals = sobel_normals(rest, camera);
  const CalibratedLights<double> lights(model, gradient(), camera, normals, field);
  const TactileRenderer renderer(camera, rest, Yielding{}, lights);
  CHECK(renderer.rest_image() == gradient());
  const Image<Rgb8> image = renderer.render(pressed);
  const Field leaning = sobel_normals(pressed, camera);
  double changed = 0;
  int wrong = 0;
  for (Index y = 2; y < height - 2; ++y) {
    for (Index x = 2; x < width - 2; ++x) {
      const bool touched = pressed(x, y) < rest(x, y);
      const Vec3<double>&n = leaning(x, y), &m = normals(x, y);
      const Vec3<double> eye = -camera.ray(x, y).normalized();
      for (std::size_t c = 0; c < 3; ++c) {
        double by = model.ambient[c] * (1 - n.dot(m));
        for (std::size_t k = 0; k < 3; ++k) {
          const double strength = field[k](x, y).norm();
          const Vec3<double> l = -field[k](x, y) / strength;
          const auto soft = [&](const Vec3<double>& v) {
            return 0.3 * std::log(1 + std::exp(v.dot(l) / 0.3));
          };
          const auto mirrored = [&](const Vec3<double>& v) {
            const Vec3<double> out = 2 * std::max(0.0, v.dot(l)) * v - l;
            return std::pow(std::max(0.0, out.dot(eye)), 6);
          };
          by += strength * (model.lights[k].diffuse[c] * (soft(n) - soft(m)) +
                            model.lights[k].specular[c] * (mirrored(n) - mirrored(m)));
        }
        by = touched ? by + model.contact[c] : by * model.free_share[c];
        const double wanted = std::clamp(gradient()(x, y)[c] * (1 + by), 0.0, 255.0);
        if (std::abs(image(x, y)[c] - wanted) > 0.51) ++wrong;
        changed = std::max(changed, std::abs(wanted - gradient()(x, y)[c]));
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(changed > 15);
}

TEST_CASE("fitted lights without their directions, or images of other sizes, are refused") {
  const LightsReflectance model = fitted();
  const Field rest(width, height, Vec3<double>(0, 0, -1));
  const auto said = [&](auto&& spoil) {
    LightsReflectance m = model;
    Field normals = rest;
    std::vector<Field> directions = straight(model);
    Image<Rgb8> background = gradient();
    spoil(m, normals, directions, background);
    return refusal(
        [&] { (void)CalibratedLights<double>(m, background, far_camera(), normals, directions); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(said([](auto&...) {}) == "accepted");
  CHECK(contains(said([](auto&, auto&, auto& d, auto&) { d.pop_back(); }), "2 images"));
  CHECK(contains(said([](auto&, auto&, auto& d, auto&) { d[1] = Field(3, 4); }), "3 x 4"));
  CHECK(contains(said([&](auto&, auto&, auto& d, auto&) { d[1](5, 5).x() = nan; }),
                 "the direction of light 1 at pixel (5, 5) is (nan, "));
  CHECK(contains(said([](auto&, auto& n, auto&, auto&) { n = Field(3, 4); }), "normals"));
  CHECK(contains(said([&](auto&, auto& n, auto&, auto&) { n(2, 2).z() = nan; }),
                 "the normal at rest at pixel (2, 2) is (0, 0, nan)"));
  CHECK(contains(said([&](auto&, auto& n, auto&, auto&) { n(2, 2) *= 3; }), "normal at rest"));
  CHECK(contains(said([&](auto&, auto& n, auto&, auto&) { n(2, 2) *= 1e-14; }), "normal at rest"));
  CHECK(said([&](auto&, auto& n, auto&, auto&) { n(2, 2) *= 0; }) == "accepted");
  // In float, where it would count as a normal of that length.
  const std::vector<Image<Vec3<float>>> along(model.lights.size(),
                                              {width, height, Vec3<float>(1, 0, 0)});
  CHECK(contains(refusal([&] {
                   (void)CalibratedLights<float>(
                       model, gradient(), far_camera().cast<float>(),
                       Image<Vec3<float>>(width, height, Vec3<float>(0, 0, -1e-6f)), along);
                 }),
                 "normal at rest at pixel (0, 0)"));
  CHECK(contains(said([](auto&, auto&, auto&, auto& b) { b = Image<Rgb8>(7, 8); }), "background"));
  for (const double bad : {nan, 0.0, std::numeric_limits<double>::infinity()}) {
    Camera<double> camera = far_camera();
    camera.fx = bad;
    CHECK(refusal([&] {
            (void)CalibratedLights<double>(model, gradient(), camera, rest, straight(model));
          }) != "accepted");
  }
  CHECK(contains(said([](auto& m, auto&, auto&, auto&) { m.softness = 0; }), "softness"));
}
