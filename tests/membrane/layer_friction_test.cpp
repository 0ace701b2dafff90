#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gelight/membrane/layer.hpp"
#include "support/approx.hpp"

using namespace gelight;

TEST_CASE("an object held by friction is as near to the surface as the residual tells") {
  constexpr double inf = std::numeric_limits<double>::infinity();
  constexpr double rest = 0.03, pitch = 1e-4, press = 3 * pitch, modulus = 1e5;
  const Camera<double> eye{300, 300 / 0.9, 48, 40, 97, 81};
  Image<double> depth(97, 81);
  for (Index v = 0; v < 81; ++v) {
    for (Index u = 0; u < 97; ++u) {
      const double x = u - 49.7, y = 0.9 * (v - 36.8);
      depth(u, v) = rest - press * (1 - (x * x + y * y) / 1800);
    }
  }
  for (const double friction : {0.3, 0.8}) {
    for (const double nu : {0.0, 0.3, 0.48}) {
      for (const double h : {8.0, 30.0, inf}) {
        const ElasticLayer layer(eye, rest, {modulus, nu, h * pitch, friction},
                                 {.sideways = false});
        const auto contact = layer.press(depth, {.shift = {1.5 * pitch, -pitch}, .twist = 0.02});
        const detail::LayerGrid grid{97, 81, 0.9, h, nu};
        const detail::PressureGreen green(grid, detail::layer_correction(grid));
        const double softness = green.down(0, 0) * (2 + 2 * nu) / modulus * pitch;
        CAPTURE(friction);
        CAPTURE(nu);
        CAPTURE(h);
        CHECK(contact.converged);
        double off = 0;
        for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
          const double through = contact.depth.pixels()[i] - depth.pixels()[i];
          // Where the gap is wider than that, the pressure is to close no more.
          const double closing = softness * contact.pressure.pixels()[i];
          off = std::max(off, through > 0 ? through : std::min(-through, closing));
        }
        CHECK(off <= (contact.residual + 1e-6) * press);
      }
    }
  }
}

namespace {

constexpr double wide = 0.02;  // m, from the camera to the gel

Camera<double> watching(Index size, double pixel) {
  const double f = wide / pixel, middle = (size - 1) / 2.0;
  return {f, f, middle, middle, size, size};
}

// A ball of 4 mm, 0.3 mm deep: it touches some 1 mm around.
Image<double> ball_in(Index size, double pixel) {
  Image<double> depth(size, size);
  for (Index y = 0; y < size; ++y) {
    for (Index x = 0; x < size; ++x) {
      const double u = (x - (size - 1) / 2.0) * pixel, v = (y - (size - 1) / 2.0) * pixel;
      depth(x, y) = wide - 3e-4 + (u * u + v * v) / 8e-3;
    }
  }
  return depth;
}

// Coulomb's law: traction is nowhere longer than friction times pressure, but for rounding.
void check_bound(const LayerContact<double>& contact, double friction) {
  double most = 0, over = 0;
  for (std::size_t i = 0; i < contact.traction.pixels().size(); ++i) {
    const double p = contact.pressure.pixels()[i], q = contact.traction.pixels()[i].norm();
    most = std::max(most, friction * p);
    over = std::max(over, p > 0 ? q - friction * p : q / 1e-12);
  }
  CHECK(over <= 1e-12 * most);
}

}  // namespace

TEST_CASE("an object that is dragged far slips, with all of friction and no more") {
  for (const Index size : {33, 65}) {
    const double pixel = 3.2e-3 / (size - 1);
    const auto depth = ball_in(size, pixel);
    for (const double nu : {0.0, 0.48}) {
      for (const double friction : {0.01, 0.1, 1.0}) {
        const ElasticLayer layer(watching(size, pixel), wide, {1e5, nu, 2e-3, friction},
                                 {.sideways = false});
        for (const double far : {1.0, 10.0, 1000.0}) {  // in contacts' radii
          CAPTURE(size);
          CAPTURE(nu);
          CAPTURE(friction);
          CAPTURE(far);
          const auto contact = layer.press(depth, {.shift = {0.8e-3 * far, -0.6e-3 * far}});
          CHECK(contact.converged);
          check_bound(contact, friction);
          // (To the tolerance of 1e-3 pixels at the rim come and go after their last round.)
          const double all = -friction * contact.force.z();
          CHECK(0.8 * contact.force.x() - 0.6 * contact.force.y() ==
                gelight::test::approx(all).epsilon(0.005));
        }
        // About an axis so far away that it is the same as a shift along y.
        Camera<double> aside = watching(size, pixel);
        aside.cx -= 100 * size;
        const auto turned =
            ElasticLayer(aside, wide, {1e5, nu, 2e-3, friction}, {.sideways = false})
                .press(depth, {.twist = 0.01});
        check_bound(turned, friction);
        CHECK(turned.force.y() ==
              gelight::test::approx(-friction * turned.force.z()).epsilon(0.005));
      }
    }
  }
}

TEST_CASE(
    "a force on an object that moves sideways is that of the press it tells, at little more") {
  const ElasticLayer layer(watching(61, 1e-4), wide, {1e5, 0.48, 3e-3, 0.5});
  const Image<double> depth = ball_in(61, 1e-4);
  const LayerLoad moved{.shift = {2e-5, -1e-5}, .twist = 0.01};
  for (const double force : {0.05, 0.3}) {
    CAPTURE(force);
    LayerLoad pressed = moved;
    pressed.force = force;
    const auto contact = layer.press(depth, pressed);
    CHECK(contact.converged);
    CHECK(-contact.force.z() == gelight::test::approx(force).epsilon(2e-3));
    Image<double> nearer = depth;
    for (double& z : nearer.pixels()) z -= contact.travel;
    const auto same = layer.press(nearer, moved);
    CHECK((same.force - contact.force).norm() < 3e-3 * force);
    const auto alone = layer.press(depth, {.force = force});
    CHECK(contact.convolutions <= alone.convolutions + 4 * same.convolutions);
  }
}

TEST_CASE("friction's bound holds at every tolerance") {
  const auto depth = ball_in(33, 1e-4);
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
    for (const double nu : {0.0, 0.3, 0.5}) {
      for (const double friction : {0.2, 1.0}) {
        const ElasticLayer layer(watching(33, 1e-4), wide, {1e5, nu, 2e-3, friction},
                                 {.tolerance = tolerance, .sideways = false});
        for (const double shift : {1e-5, 1e-4, 1e-3}) {
          CAPTURE(tolerance);
          CAPTURE(nu);
          CAPTURE(friction);
          CAPTURE(shift);
          check_bound(layer.press(depth, {.shift = {shift, 0}}), friction);
        }
      }
    }
  }
}

TEST_CASE("a contact whose pixels come and go at its rim ends, and says how far off it is") {
  constexpr double inf = std::numeric_limits<double>::infinity();
  constexpr double deep = 1.77e-4;  // of a tilted block's deepest corner
  const Camera<double> eye{300, 300, 30, 25, 61, 51};
  Image<double> depth(61, 51, inf);
  for (Index y = 10; y < 40; ++y) {
    for (Index x = 10; x < 50; ++x) depth(x, y) = 0.03 + 5e-6 * (x - 30) - 3e-6 * (y - 20) - 2e-5;
  }
  for (const double tolerance : {1e-3, 5e-5}) {
    CAPTURE(tolerance);
    int asked = 0;  // once a convolution
    const ElasticLayer layer(
        eye, 0.03, {.poisson_ratio = 0.3, .friction = inf},
        {.tolerance = tolerance, .sideways = false, .cancelled = [&] { return ++asked > 20000; }});
    const auto contact = layer.press(depth, {.shift = {1e-4, 5e-5}});
    double off = 0;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      off = std::max(off, contact.depth.pixels()[i] - depth.pixels()[i]);
    }
    CHECK(off <= (contact.residual + 1e-6) * deep);
    CHECK(contact.converged == (contact.residual <= tolerance));
  }
}
