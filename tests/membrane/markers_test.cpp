#include "gelight/membrane/markers.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "gelight/membrane/layer.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::contains;
using test::refusal;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

// Markers of a photograph: where they were, and how far they moved, in pixels.
struct Markers {
  std::vector<Vec2<double>> pixels, moved;
};

std::string photograph(const char* name) {
  return std::string(GELIGHT_REAL_DIR) + "/markers/" + name + ".csv";
}

Markers read(const char* name) {
  Markers markers;
  std::ifstream file(photograph(name));
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    Vec2<double> pixel, moved;
    numbers >> pixel.x() >> pixel.y() >> moved.x() >> moved.y();
    markers.pixels.push_back(pixel);
    markers.moved.push_back(moved);
  }
  return markers;
}

// The root mean square of what is left, pixels a component, with a common offset fitted.
double left_over(const Markers& seen, const std::vector<Vec2<double>>& model) {
  const auto count = static_cast<double>(seen.moved.size());
  Vec2<double> mean(0, 0);
  double squares = 0;
  for (std::size_t i = 0; i < model.size(); ++i) mean += (seen.moved[i] - model[i]) / count;
  for (std::size_t i = 0; i < model.size(); ++i) {
    squares += (seen.moved[i] - model[i] - mean).squaredNorm();
  }
  return std::sqrt(squares / (2 * count));
}

template <class Field>
std::vector<Vec2<double>> at(const std::vector<Vec2<double>>& pixels, const Field& field) {
  std::vector<Vec2<double>> moved;
  for (const auto& pixel : pixels) moved.push_back(field(pixel));
  return moved;
}

}  // namespace

TEST_CASE("a marker moves as the projection of its point does") {
  const Camera<double> eye{300, 280, 20.5, 14, 40, 30};
  Image<double> rest(40, 30);
  Image<Vec3<double>> displacement(40, 30);
  for (Index y = 0; y < 30; ++y) {
    for (Index x = 0; x < 40; ++x) {
      rest(x, y) = 0.03 + 1e-4 * x;
      displacement(x, y) = {1e-4 * x, -2e-5 * y, -1e-5 * (x + y)};
    }
  }
  rest(3, 4) = inf;
  displacement(5, 6).y() = std::numeric_limits<double>::quiet_NaN();
  displacement(7, 8).x() = inf;
  const auto moved = marker_displacement(eye, rest, displacement);
  for (Index y = 0; y < 30; ++y) {
    for (Index x = 0; x < 40; ++x) {
      if ((x == 3 && y == 4) || (x == 5 && y == 6) || (x == 7 && y == 8)) {
        CHECK((std::isnan(moved(x, y).x()) && std::isnan(moved(x, y).y())));
        continue;
      }
      const Vec3<double> point = eye.unproject(x, y, rest(x, y));
      const Vec2<double> by = eye.project(point + displacement(x, y)) - Vec2<double>(x, y);
      CHECK((moved(x, y) - by).norm() < 1e-12);
    }
  }
  CHECK(
      contains(refusal([&] { (void)marker_displacement(eye, Image<double>(4, 4), displacement); }),
               "4 x 4"));
  CHECK(contains(refusal([&] { (void)marker_displacement(eye, rest, Image<Vec3<double>>(3, 4)); }),
                 "3 x 4"));
}

TEST_CASE("markers between pixels") {
  Image<Vec2<double>> moved(5, 4);
  for (Index y = 0; y < 4; ++y) {
    for (Index x = 0; x < 5; ++x) moved(x, y) = {2.0 * x - y, x * y};
  }
  const std::vector<Vec2<double>> pixels{{0, 0}, {4, 3}, {1.25, 2.5}, {4, 0.5}};
  const auto sampled = sample_markers<double>(moved, pixels);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double x = pixels[i].x(), y = pixels[i].y();
    CHECK((sampled[i] - Vec2<double>(2 * x - y, x * y)).norm() < 1e-14);
  }
  for (const Vec2<double>& bad : {Vec2<double>(4.1, 0), Vec2<double>(0, -0.1),
                                  Vec2<double>(std::numeric_limits<double>::quiet_NaN(), 0)}) {
    CHECK(contains(refusal([&] { (void)sample_markers<double>(moved, std::vector{bad}); }),
                   "marker 0"));
  }
}

TEST_CASE("what is not known at a pixel concerns markers that are nearer than one to it alone") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Camera<double> eye{300, 280, 3, 2, 7, 5};
  for (Index hole_y = 0; hole_y < 5; ++hole_y) {
    for (Index hole_x = 0; hole_x < 7; ++hole_x) {
      Image<double> rest(7, 5, 0.03);
      Image<Vec3<double>> displacement(7, 5, {1e-4, 2e-4, 0});
      displacement(hole_x, hole_y) = {nan, nan, nan};
      const auto moved = marker_displacement(eye, rest, displacement);
      for (double y = 0; y <= 4; y += 0.5) {
        for (double x = 0; x <= 6; x += 0.5) {
          const bool is_known = std::abs(x - hole_x) >= 1 || std::abs(y - hole_y) >= 1;
          const std::vector<Vec2<double>> pixel{{x, y}};
          CAPTURE(x);
          CAPTURE(y);
          CHECK(sample_markers<double>(moved, pixel)[0].allFinite() == is_known);
          CHECK(marker_displacement<double>(eye, rest, displacement, pixel)[0].allFinite() ==
                is_known);
        }
      }
    }
  }
}

TEST_CASE("the closed form of a disc that sticks, against Mindlin and against the layer") {
  const double nu = 0.5, radius = 12, pitch = 1e-4, rest = 0.03;
  const Vec2<double> centre(90, 70), shift(2, 1);
  const auto closed = DraggedMarkers::of_disc(centre, shift, radius, nu);
  CHECK((closed(centre) - shift).norm() < 1e-14);
  // Far away: a force of 8 mu a s / (2 - nu) in one point (Cerruti).
  for (const double angle : {0.0, 1.0, 2.0, 4.0}) {
    const Vec2<double> r = 1e4 * Vec2<double>(std::cos(angle), std::sin(angle));
    const Vec2<double> force = 8 * radius / (2 - nu) * shift;
    const Vec2<double> far = ((1 - nu) * force + nu * r.dot(force) / r.squaredNorm() * r) /
                             (2 * std::numbers::pi * r.norm());
    CHECK((closed(centre + r) - far).norm() < 1e-5 * far.norm());
  }
  const Camera<double> eye{rest / pitch, rest / pitch, 90, 70, 181, 141};
  const ElasticLayer layer(eye, rest, {1e5, nu, inf, inf}, {.tolerance = 1e-3});
  Image<double> depth(181, 141, inf);
  for (Index y = 0; y < 141; ++y) {
    for (Index x = 0; x < 181; ++x) {
      if ((Vec2<double>(x, y) - centre).norm() <= radius) depth(x, y) = rest - 0.5 * pitch;
    }
  }
  const auto before = layer.press(depth);
  auto after = layer.press(depth, {.shift = pitch * shift});
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    after.displacement.pixels()[i] -= before.displacement.pixels()[i];
  }
  const auto exact = marker_displacement(eye, layer.rest_depth(), after.displacement);
  const auto image = marker_displacement<double>(181, 141, closed);
  double largest = 0, beyond = 0;
  for (Index y = 0; y < 141; ++y) {
    for (Index x = 0; x < 181; ++x) {
      const double error = (image(x, y) - exact(x, y)).norm() / shift.norm();
      largest = std::max(largest, error);
      if ((Vec2<double>(x, y) - centre).norm() > 3 * radius) beyond = std::max(beyond, error);
    }
  }
  MESSAGE("closed form against the layer: ", 100 * largest, " % of the shift off at most, ",
          100 * beyond, " % beyond three radii");
  CHECK(beyond < 0.01);
  CHECK(contains(refusal([&] { (void)DraggedMarkers::of_disc(centre, shift, 0, nu); }), "radius"));
  CHECK(
      contains(refusal([&] { (void)DraggedMarkers::of_disc(centre, shift, 1, 0.6); }), "Poisson"));
  for (const double bad : {HUGE_VAL, std::nan("")}) {
    const Vec2<double> off(1, bad);
    CHECK(contains(refusal([&] { (void)DraggedMarkers::of_disc(off, shift, 1, nu); }), "centre"));
    CHECK(contains(refusal([&] { (void)DraggedMarkers::of_disc(centre, off, 1, nu); }), "shift"));
  }
}

TEST_CASE("a dragged contact that says nothing is refused by name") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto asked = [](const DraggedMarkers& markers) {
    return refusal([&] { (void)markers({0, 0}); });
  };
  for (const double bad : {0.0, -0.0, -1.0, nan, inf, 1e-200, 1e200}) {
    CAPTURE(bad);
    CHECK(contains(asked({{0, 0}, {1, 0}, bad, 0}), "reach"));
  }
  for (const double bad : {nan, inf}) {
    CHECK(contains(asked({{bad, 0}, {1, 0}, 1, 0}), "centre"));
    CHECK(contains(asked({{0, 0}, {0, bad}, 1, 0}), "shift"));
    CHECK(contains(asked({{0, 0}, {1, 0}, 1, bad}), "stretch"));
  }
  const DraggedMarkers none{{0, 0}, {1, 0}, 0, 0};
  CHECK(contains(refusal([&] { (void)marker_displacement<double>(4, 4, none); }), "reach 0"));
  // The least that is taken is still a number at its centre.
  CHECK((DraggedMarkers{{0, 0}, {1, 2}, 1e-150, 0}({0, 0}) - Vec2<double>(1, 2)).norm() < 1e-14);
}

TEST_CASE("three Gaussians: each does what it says") {
  GaussianMarkers markers;
  markers.centre = {10, 5};
  markers.shift = {2, -1};
  markers.shift_decay = 0.01;
  CHECK((markers({10, 5}) - markers.shift).norm() < 1e-15);
  CHECK((markers({20, 5}) - std::exp(-1) * markers.shift).norm() < 1e-15);
  markers.shift = {0, 0};
  markers.twist = 0.2;
  markers.twist_decay = 0.01;
  // From x to y.
  const Vec2<double> turned = markers({20, 5});
  CHECK(turned.x() == gelight::test::approx(10 * std::exp(-1) * (std::cos(0.2) - 1)));
  CHECK(turned.y() == gelight::test::approx(10 * std::exp(-1) * std::sin(0.2)));
  markers.twist = 0;
  markers.touched = {{{10, 5}, 0.1}, {{12, 5}, 0.2}};
  markers.push_decay = 0.02;
  CHECK(markers({11, 5}).x() == gelight::test::approx(std::exp(-0.02) * (0.1 - 0.2)));
}

TEST_CASE("a photographed gel that a ball drags: the layer against Gaussians") {
  if (!std::filesystem::exists(photograph("shear"))) {
    MESSAGE("skipped: no photographs at " << GELIGHT_REAL_DIR);
    return;
  }
  // The ball is pressed in in one photograph, and dragged in the other.
  Markers seen = read("shear");
  const Markers pressed = read("dilation");
  REQUIRE(seen.pixels.size() == 99);
  REQUIRE(seen.pixels == pressed.pixels);
  for (std::size_t i = 0; i < 99; ++i) seen.moved[i] -= pressed.moved[i];
  // Models with parameters that were fitted to these markers, by least squares.
  const auto nothing = at(seen.pixels, [](const Vec2<double>&) { return Vec2<double>(0, 0); });
  GaussianMarkers gaussian;
  gaussian.centre = {143.967, 128.761};
  gaussian.shift = {-1.961, 9.408};
  gaussian.shift_decay = 1 / (2 * 42.79 * 42.79);
  const DraggedMarkers dragged{{145.922, 127.824}, {-2.925, 13.191}, 28.5, 0.345};

  // A ball of 83 pixels' radius, 17 deep in a gel 108 thick, nearly incompressible; it sticks.
  const double pitch = 1 / 19580.0, rest = 0.03;
  const Camera<double> eye{rest / pitch, rest / pitch, 159.5, 119.5, 320, 240};
  const ElasticLayer layer(eye, rest, {1e5, 0.481, 107.6 * pitch, inf}, {.tolerance = 1e-2});
  const double radius = 82.85 * pitch, press = 16.99 * pitch;
  Image<double> depth(320, 240, inf);
  for (Index v = 0; v < 240; ++v) {
    for (Index u = 0; u < 320; ++u) {
      const double r = std::hypot(u - 145.364, v - 125.088) * pitch;
      if (r < radius) depth(u, v) = rest - press + radius - std::sqrt(radius * radius - r * r);
    }
  }
  const auto before = layer.press(depth);
  auto after = layer.press(depth, {.shift = pitch * Vec2<double>(-1.804, 8.317)}, &before);
  CHECK(after.converged);
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    after.displacement.pixels()[i] -= before.displacement.pixels()[i];
  }
  const auto moved = marker_displacement(eye, layer.rest_depth(), after.displacement);
  std::vector<Vec2<double>> inside;
  for (const auto& p : seen.pixels) inside.push_back({p.x(), std::min(p.y(), 239.0)});

  const double by_nothing = left_over(seen, nothing);
  const double by_gaussian = left_over(seen, at(seen.pixels, gaussian));
  const double by_closed_form = left_over(seen, at(seen.pixels, dragged));
  const double by_layer = left_over(seen, sample_markers<double>(moved, inside));
  MESSAGE("left of the markers' motion, pixels: nothing ", by_nothing, ", Gaussian ", by_gaussian,
          ", closed form ", by_closed_form, ", layer ", by_layer);
  CHECK(by_layer < 0.52);
  CHECK(by_closed_form < 0.61);
  CHECK(by_gaussian > 0.73);
  CHECK(by_nothing > 1.7);
}

TEST_CASE("three Gaussians with what is no number are refused by name") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const GaussianMarkers good{{{{10, 5}, 0.1}, {{12, 5}, 0.2}}, {9, 5}, {2, -1}, 0.2, 0, 0.1, 0.3};
  const auto asked = [&](const char* what, auto&& spoil) {
    for (const double bad : {nan, inf, -inf}) {
      CAPTURE(bad);
      GaussianMarkers markers = good;
      spoil(markers, bad);
      CHECK(contains(refusal([&] { (void)markers({0, 0}); }), what));
      CHECK(contains(refusal([&] { (void)marker_displacement<double>(4, 4, markers); }), what));
    }
  };
  CHECK(refusal([&] { (void)good({0, 0}); }) == "accepted");
  for (int i = 0; i < 2; ++i) {
    asked("centre", [&](auto& m, double bad) { m.centre[i] = bad; });
    asked("shift", [&](auto& m, double bad) { m.shift[i] = bad; });
    asked("touched dot 1 at", [&](auto& m, double bad) { m.touched[1].pixel[i] = bad; });
  }
  asked("touched dot 0 at", [&](auto& m, double bad) { m.touched[0].push = bad; });
  asked("twist", [](auto& m, double bad) { m.twist = bad; });
  asked("decays", [](auto& m, double bad) { m.push_decay = bad; });
  asked("decays", [](auto& m, double bad) { m.shift_decay = bad; });
  asked("decays", [](auto& m, double bad) { m.twist_decay = bad; });
  GaussianMarkers grows = good;
  grows.twist_decay = -0.1;
  CHECK(contains(refusal([&] { (void)grows({0, 0}); }), "-0.1 is negative"));
}
