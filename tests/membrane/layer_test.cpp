#include "gelight/membrane/layer.hpp"

#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::contains;
using test::refusal;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double pi = std::numbers::pi;
constexpr double rest = 0.03, pitch = 1e-4;

// A camera that looks at pixels `pitch` apart, counted from the middle.
Camera<double> camera(Index width, Index height, double scale = 1, double aspect = 1) {
  const double f = rest / pitch;
  return {f / scale, f / scale / aspect, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
}

// The depth of an object that stands `overlap(x, y)` past the gel, x and y in pixels' widths from
// the camera's axis; so far in pixels' widths, too.
template <class Overlap>
Image<double> object(const Camera<double>& eye, const Overlap& overlap) {
  Image<double> depth(eye.width, eye.height);
  const double width = rest / eye.fx;
  for (Index v = 0; v < eye.height; ++v) {
    for (Index u = 0; u < eye.width; ++u) {
      depth(u, v) = rest - width * overlap(u - eye.cx, (v - eye.cy) * eye.fx / eye.fy);
    }
  }
  return depth;
}

// A paraboloid that on a half-space touches a circle of a radius, pressed in by `press`.
auto ball(double radius, double press, double x0 = 0, double y0 = 0) {
  return [=](double x, double y) {
    const double r2 = (x - x0) * (x - x0) + (y - y0) * (y - y0);
    return press * (1 - r2 / (2 * radius * radius));
  };
}

auto punch(double radius, double press) {
  return [=](double x, double y) { return std::hypot(x, y) <= radius ? press : -inf; };
}

double largest(const Image<double>& image) {
  return *std::max_element(image.pixels().begin(), image.pixels().end());
}

double touched_pixels(const LayerContact<double>& contact) {
  const auto& p = contact.pressure.pixels();
  return static_cast<double>(std::count_if(p.begin(), p.end(), [](double v) { return v > 0; }));
}

double touched_radius(const LayerContact<double>& contact) {
  return std::sqrt(touched_pixels(contact) / pi);
}

double order(double coarse, double fine) { return std::log2(std::abs(coarse / fine)); }

// What a layer of shear modulus 1 yields to a pressure or traction cos(k x), sin(k x) on its
// surface z = 0, bonded at z = h: the general solution of the plane equations of elasticity,
// displacements (i U, W) exp(i k x) with W = (b0 + b1 z) exp(s k z), s = 1 and -1, from a 4 x 4
// system. Pressure moves it down and sideways, traction sideways and down.
Eigen::Matrix2d direct_response(double k, double h, double nu) {
  Eigen::Matrix4d system;
  Eigen::Matrix4d surface;
  for (int i = 0; i < 4; ++i) {
    const double s = i < 2 ? 1 : -1, b0 = i % 2 == 0 ? 1 : 0, b1 = 1 - b0;
    const double a0 = s * b0 + (3 - 4 * nu) * b1 / k, a1 = s * b1;
    const double at_base = std::exp(s * k * h);
    system.col(i) << (a0 + a1 * h) * at_base, (b0 + b1 * h) * at_base,  // no motion at the base
        -(-4 * nu * b1 + 2 * (b1 + s * k * b0)),                        // pressure
        -(a1 + s * k * a0 + k * b0);                                    // traction, over i
    surface.col(i) << b0, a0, 0, 0;                                     // W and U at the surface
  }
  const Eigen::Matrix4d unit = surface * system.inverse();
  return unit.topRightCorner<2, 2>();
}

}  // namespace

TEST_CASE("the layer's Green's functions against a direct solve of its equations") {
  for (const double nu : {0.0, 0.2, 0.45, 0.49, 0.5}) {
    for (const double c : {1e-3, 0.01, 0.049, 0.051, 0.3, 1.0, 2.7, 6.0}) {
      const double k = 1.7, h = c / k;
      const Eigen::Matrix2d direct = k * direct_response(k, h, nu);
      const auto response = detail::layer_response(c, nu);
      CAPTURE(nu);
      CAPTURE(c);
      // The direct system loses digits in a thin layer.
      const double digits = 1e-11 / (c * c * c);
      CHECK(std::abs(response.down_by_pressure / direct(0, 0) - 1) < std::max(digits, 1e-10));
      CHECK(std::abs(response.along_by_traction / direct(1, 1) - 1) < std::max(digits, 1e-10));
      CHECK(std::abs(response.coupling - direct(1, 0)) < 1e-10);
      CHECK(std::abs(response.coupling - direct(0, 1)) < 1e-10);
      CHECK(response.across_by_traction == gelight::test::approx(std::tanh(c)).epsilon(1e-14));
    }
    const auto thick = detail::layer_response(700, nu), half = detail::half_space_response(nu);
    CHECK(thick.down_by_pressure == gelight::test::approx(half.down_by_pressure).epsilon(1e-14));
    CHECK(thick.along_by_traction == gelight::test::approx(half.along_by_traction).epsilon(1e-14));
    CHECK(thick.coupling == gelight::test::approx(half.coupling).epsilon(1e-14));
    // Pressed all over, the layer gives way by the oedometer's modulus.
    const double thin = detail::layer_response(1e-7, nu).down_by_pressure / 1e-7;
    CHECK(thin == gelight::test::approx((1 - 2 * nu) / (2 * (1 - nu))).epsilon(1e-9).scale(1));
  }
}

TEST_CASE("Bessel functions and the table of a layer's difference from a half-space") {
  for (const double x : {0.0, 0.1, 0.499, 0.501, 2.0, 17.0}) {
    for (int n = 0; n < 3; ++n) {
      // Bessel's integral, by the trapezoid rule, which is exact here.
      double sum = 0;
      for (int i = 0; i < 200; ++i) {
        const double t = pi * (i + 0.5) / 200;
        sum += std::cos(n * t - x * std::sin(t)) / 200;
      }
      CHECK(std::abs(detail::bessel(x)[static_cast<std::size_t>(n)] - sum) < 1e-9);
    }
  }
  for (const double nu : {0.0, 0.3, 0.5}) {
    const detail::LayerCorrection correction(nu, 20);
    double sum = 0;
    for (int i = 0; i < 20000; ++i) {
      const double r = (i + 0.5) / 1000;
      sum += (1 - nu + r * correction.at(decltype(correction)::pressure, r)) / 1000;
    }
    CHECK(std::abs(sum - (1 - 2 * nu) / (2 * (1 - nu))) < 1e-6);
    CHECK(std::abs((1 - nu) / 15 + correction.at(decltype(correction)::pressure, 15)) < 1e-6);
    // Between its nodes, in each of its ranges, the integral itself, by the trapezoid rule.
    for (const double r : {0.03, 0.97, 2.53, 3.97, 4.1, 5.6, 7.9, 8.15, 11.3, 19.6}) {
      const auto far = detail::half_space_response(nu);
      std::array<double, 4> integral{};
      constexpr double step = 1.0 / 2048;
      for (int i = 0; i <= 20 / step; ++i) {
        const double c = i * step, weight = i == 0 ? step / 2 : step;
        const auto [j0, j1, j2] = detail::bessel(c * r);
        const auto here = detail::layer_response(c, nu);
        const double along = here.along_by_traction - far.along_by_traction;
        const double across = here.across_by_traction - far.across_by_traction;
        integral[0] += weight * j0 * (here.down_by_pressure - far.down_by_pressure);
        integral[1] += weight * j0 * (along + across) / 2;
        integral[2] += weight * j2 * (along - across) / 2;
        integral[3] += weight * j1 * (here.coupling - far.coupling);
      }
      CAPTURE(nu);
      CAPTURE(r);
      for (std::size_t k = 0; k < 4; ++k) {
        const auto part = static_cast<decltype(correction)::Part>(k);
        CHECK(std::abs(correction.at(part, r) - integral[k]) < 1e-6);
      }
    }
  }
}

TEST_CASE("pixels' Green's functions have the spectrum that sampling gives them") {
  // The sum over all offsets of a function times a wave is the sum of its transform, times that of
  // a pixel, over all waves that look the same on the pixels.
  for (const double nu : {0.0, 0.3, 0.5}) {
    for (const double h : {1.0, 3.3, 12.0}) {
      for (const double aspect : {1.0, 1.3}) {
        const detail::LayerGrid grid{260, 260, aspect, h, nu};
        const auto correction = detail::layer_correction(grid);
        const detail::PressureGreen pressure(grid, correction);
        const detail::SidewaysGreen sideways(grid, correction);
        for (const double k : {0.0, 0.1, 0.7}) {
          double down = 0, along = 0, across = 0, coupling = 0, other = 0;
          for (Index y = -259; y < 260; ++y) {
            for (Index x = -259; x < 260; ++x) {
              down += pressure.down(x, y) * std::cos(k * x);
              along += sideways.xx(x, y) * std::cos(k * x);
              across += sideways.yy(x, y) * std::cos(k * x);
              coupling += sideways.x(x, y) * std::sin(k * x);
              other += sideways.xy(x, y) * std::cos(k * x);
            }
          }
          double want_down = 0, want_along = 0, want_across = 0, want_coupling = 0;
          for (int m = -2000; m <= 2000; ++m) {
            const double wave = k + 2 * pi * m, size = std::max(std::abs(wave), 1e-9);
            const double pixel = wave == 0 ? 1 : std::sin(wave / 2) / (wave / 2);
            const auto response = detail::layer_response(size * h, nu);
            want_down += pixel / size * response.down_by_pressure;
            want_along += pixel / size * response.along_by_traction;
            want_across += pixel / size * response.across_by_traction;
            want_coupling -= pixel / (wave < 0 ? -size : size) * response.coupling;
          }
          CAPTURE(nu);
          CAPTURE(h);
          CAPTURE(k);
          CHECK(std::abs(down - want_down) < 2e-5 * h);
          CHECK(std::abs(along - want_along) < 2e-5 * h);
          CHECK(std::abs(across - want_across) < 2e-5 * h);
          if (k > 0) CHECK(std::abs(coupling - want_coupling) < 2e-5 * h);
          CHECK(std::abs(other) < 1e-9);
        }
      }
    }
  }
}

TEST_CASE("Hertz: a sphere on a half-space") {
  const double nu = 0.3, modulus = 1e5, reduced = modulus / (1 - nu * nu);
  std::array<double, 3> radius_error{}, pressure_error{}, force_error{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = 10 * std::pow(2.0, i), press = a / 10;
    const auto size = static_cast<Index>(3.2 * a);
    // Centred on a pixel, on a corner, and beside both.
    for (const double beside : {0.0, 0.5, 0.3}) {
      const auto eye = camera(size | 1, size | 1);
      const ElasticLayer layer(eye, rest, {modulus, nu, inf},
                               {.tolerance = 1e-6, .sideways = false});
      const auto contact = layer.press(object(eye, ball(a, press, beside, beside)));
      // Press d = a^2 / R, largest pressure 2 a E* / (pi R), force 4 a^3 E* / (3 R).
      const double most = 2 * reduced * press / (pi * a);
      const double force = 4.0 / 3 * reduced * a * press * pitch * pitch;
      CHECK(contact.converged);
      const auto worst = [](double& error, double now) {
        if (std::abs(now) > std::abs(error)) error = now;
      };
      worst(radius_error[i], touched_radius(contact) / a - 1);
      worst(pressure_error[i], largest(contact.pressure) / most - 1);
      worst(force_error[i], -contact.force.z() / force - 1);
      // The pixels nearest to the middle are that far beside it.
      const double deepest = press * (1 - beside * beside / (a * a));
      CHECK(largest(contact.indentation) == gelight::test::approx(deepest * pitch).epsilon(2e-6));
      // Beyond the contact the surface is Hertz's: press over pi times ...
      const double x = 1.5 * a - beside, y = -beside, s = std::hypot(x, y) / a;
      const double sunk = press / pi * ((2 - s * s) * std::asin(1 / s) + std::sqrt(s * s - 1));
      const auto at = static_cast<Index>(eye.cx + 1.5 * a), row = static_cast<Index>(eye.cy);
      const double there = contact.indentation(at, row) / pitch;
      if (i == 2) CHECK(there == gelight::test::approx(sunk).epsilon(0.002));
    }
  }
  MESSAGE("contact radius ", 100 * radius_error[2], " %, largest pressure ",
          100 * pressure_error[2], " %, force ", 100 * force_error[2],
          " % off at 40 pixels; orders ", order(radius_error[1], radius_error[2]), ", ",
          order(pressure_error[1], pressure_error[2]), ", ", order(force_error[1], force_error[2]));
  CHECK(std::abs(radius_error[2]) < 0.005);
  CHECK(std::abs(pressure_error[2]) < 0.0005);
  CHECK(std::abs(force_error[2]) < 0.0001);
  CHECK(order(radius_error[0], radius_error[2]) > 2 * 0.8);
  CHECK(order(force_error[0], force_error[2]) > 2 * 1.5);
}

TEST_CASE("Hertz: crossed cylinders touch in an ellipse") {
  // Semi-axes a and b, u = (L - M x^2 - N y^2) / (pi E*): Johnson, Contact Mechanics, section 4.2.
  const double nu = 0.45, modulus = 2e5, reduced = modulus / (1 - nu * nu);
  for (const double aspect : {1.0, 1.25}) {  // of the pixels
    const double a = 36, b = 20, e2 = 1 - b * b / (a * a), e = std::sqrt(e2);
    const double k = std::comp_ellint_1(e), l = std::comp_ellint_2(e), p0 = 0.05 * reduced;
    const double unit = p0 * b / reduced, m = unit / (e2 * a * a) * (k - l);
    const double n = unit / (e2 * a * a) * (a * a / (b * b) * l - k), press = unit * k;
    const auto eye = camera(121, 81, 1, aspect);
    const ElasticLayer layer(eye, rest, {modulus, nu, inf}, {.tolerance = 1e-5});
    const auto contact =
        layer.press(object(eye, [&](double x, double y) { return press - m * x * x - n * y * y; }));
    CHECK(largest(contact.pressure) == gelight::test::approx(p0).epsilon(0.001));
    CHECK(touched_pixels(contact) * aspect == gelight::test::approx(pi * a * b).epsilon(0.015));
    CHECK(-contact.force.z() ==
          gelight::test::approx(2.0 / 3 * p0 * pi * a * b * pitch * pitch).epsilon(0.0005));
  }
}

TEST_CASE("Boussinesq's flat punch and Sneddon's cone") {
  const double nu = 0.25, modulus = 1e5, reduced = modulus / (1 - nu * nu);
  std::vector<double> punch_error, cone_error;
  for (const double a : {10.0, 20.0, 40.0}) {
    const auto size = static_cast<Index>(2.8 * a) | 1;
    const auto eye = camera(size, size);
    const ElasticLayer layer(eye, rest, {modulus, nu, inf}, {.tolerance = 1e-5, .sideways = false});
    const double press = 1, unit = reduced * pitch * pitch;
    const auto flat = layer.press(object(eye, punch(a, press)));
    punch_error.push_back(-flat.force.z() / (2 * a * press * unit) - 1);
    const double slope = 0.05;
    const auto cone = layer.press(
        object(eye, [&](double x, double y) { return slope * (pi / 2 * a - std::hypot(x, y)); }));
    cone_error.push_back(-cone.force.z() / (pi / 2 * slope * a * a * unit) - 1);
    CHECK(std::abs(touched_radius(cone) - a) < 0.3);
  }
  MESSAGE("flat punch's force ", 100 * punch_error[2], " %, cone's ", 100 * cone_error[2],
          " % off at 40 pixels; orders ", order(punch_error[0], punch_error[2]) / 2, ", ",
          order(cone_error[0], cone_error[2]) / 2);
  CHECK(std::abs(punch_error[2]) < 0.005);
  CHECK(std::abs(cone_error[2]) < 0.0005);
  CHECK(order(cone_error[0], cone_error[2]) / 2 > 1.5);
}

TEST_CASE("a disc that sticks: Mindlin's force, and Reissner and Sagoci's moment") {
  // At a Poisson ratio of 0.5 pressure and traction do not act on each other, and the two are
  // exact.
  for (const double a : {10.0, 20.0, 40.0}) {
    const double modulus = 1e5, mu = modulus / 3, shift = 0.5 * pitch, turn = 0.01;
    const auto size = static_cast<Index>(2.4 * a) | 1;
    const auto eye = camera(size, size);
    const ElasticLayer layer(eye, rest, {modulus, 0.5, inf, inf}, {.tolerance = 1e-4});
    const auto depth = object(eye, punch(a, 1));
    const auto moved = layer.press(depth, {.shift = {0.6 * shift, 0.8 * shift}});
    const double radius = a * pitch, force = 8 * mu * radius * shift / 1.5;
    CHECK(moved.converged);
    CHECK(moved.force.x() == gelight::test::approx(0.6 * force).epsilon(0.01));
    CHECK(moved.force.y() == gelight::test::approx(0.8 * force).epsilon(0.01));
    const Vec3<double> under = moved.displacement(size / 2, size / 2);
    CHECK(under.x() == gelight::test::approx(0.6 * shift).epsilon(1e-3));
    CHECK(under.y() == gelight::test::approx(0.8 * shift).epsilon(1e-3));
    const auto turned = layer.press(depth, {.twist = turn});
    const double moment = 16.0 / 3 * mu * std::pow(radius, 3) * turn;
    CHECK(turned.moment.z() == gelight::test::approx(moment).epsilon(0.02));
    CHECK(std::abs(turned.force.x()) < 1e-4 * force);
    MESSAGE("sticking disc of ", a, " pixels: force ",
            100 * (moved.force.head<2>().norm() / force - 1), " %, moment ",
            100 * (turned.moment.z() / moment - 1), " % off");
  }
}

TEST_CASE("Cattaneo and Mindlin: a sphere that slips at its rim") {
  const double a = 30, press = 2, friction = 0.4, modulus = 1e5, nu = 0.5, mu = modulus / 3;
  const auto eye = camera(97, 97);
  const ElasticLayer layer(eye, rest, {modulus, nu, inf, friction}, {.tolerance = 1e-3});
  const auto depth = object(eye, ball(a, press));
  const double normal = 4.0 / 3 * modulus / (1 - nu * nu) * a * press * pitch * pitch;
  const double all_slips = 3 * friction * normal * (2 - nu) / (16 * mu * a * pitch);
  for (const double share : {0.3, 0.6, 0.9, 1.3}) {
    const auto contact = layer.press(depth, {.shift = {0, -share * all_slips}});
    const double held = share < 1 ? 1 - std::pow(1 - share, 1.5) : 1;
    CAPTURE(share);
    CHECK(contact.converged);
    CHECK(-contact.force.y() == gelight::test::approx(held * friction * normal).epsilon(0.003));
    double sticking = 0;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      const double p = contact.pressure.pixels()[i], q = contact.traction.pixels()[i].norm();
      CHECK(q <= friction * p * (1 + 1e-9));
      if (q < friction * p * (1 - 1e-6)) ++sticking;
    }
    const double stuck = share < 1 ? a * std::sqrt(1 - share) : 0;
    CHECK(std::sqrt(sticking / pi) == gelight::test::approx(stuck).epsilon(0.02));
  }
}

TEST_CASE("friction's law, in a layer that couples pressure and traction") {
  const double friction = 0.5, press = 3;
  const auto eye = camera(81, 61);
  for (const double nu : {0.0, 0.3, 0.48}) {
    const ElasticLayer layer(eye, rest, {1e5, nu, 20 * pitch, friction}, {.tolerance = 1e-3});
    const auto depth = object(eye, ball(14, press, 3.2, -2.1));
    const auto before = layer.press(depth);
    const Vec2<double> shift(0.8 * pitch, 0.3 * pitch);
    const auto after = layer.press(depth, {.shift = shift});
    CHECK(after.converged);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      const double p = after.pressure.pixels()[i];
      const Vec2<double> q = after.traction.pixels()[i];
      // How far the object has slipped ahead of the surface.
      const Vec2<double> slip =
          shift - (after.displacement.pixels()[i] - before.displacement.pixels()[i]).head<2>();
      if (p == 0) {
        CHECK(q.norm() == 0);
        continue;
      }
      CHECK(q.norm() <= friction * p * (1 + 1e-9));
      const double tolerance = 3e-3 * shift.norm();
      if (q.norm() < friction * p * (1 - 1e-6)) {
        CHECK(slip.norm() < tolerance);
      } else {
        CHECK((slip - q.normalized() * slip.norm()).norm() < tolerance + 0.03 * slip.norm());
      }
    }
  }
}

TEST_CASE("friction converges as the tolerance does") {
  const auto eye = camera(65, 65);
  const auto depth = object(eye, ball(20, 2, 0.2, 0.4));
  for (const double nu : {0.3, 0.5}) {
    for (const double h : {20.0, inf}) {
      const auto press = [&](double tolerance) {
        const ElasticLayer layer(eye, rest, {1e5, nu, h * pitch, 0.3}, {.tolerance = tolerance});
        return layer.press(depth, {.shift = {0.5 * pitch, 0}});
      };
      const auto exact = press(1e-5);
      CHECK(exact.converged);
      CHECK(exact.convolutions < 800);
      for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const auto contact = press(tolerance);
        CHECK(contact.converged);
        CHECK(contact.force.x() == gelight::test::approx(exact.force.x()).epsilon(4 * tolerance));
      }
    }
  }
}

TEST_CASE("a thin layer that keeps its volume: the radius is twice the root of press and radius") {
  // Bonded, frictionless, nu = 1/2: p = 3 mu (a^2 - r^2)^2 / (32 R h^3), a^2 = 4 R d, from
  // u = -h^3 / (3 mu) laplace(p); Johnson, Contact Mechanics, section 5.8.
  std::vector<double> radius, force;
  for (const double h : {16.0, 8.0, 4.0}) {
    const double a = 64, press = 1, ball_radius = a * a / (4 * press);
    const auto eye = camera(161, 161);
    const ElasticLayer layer(eye, rest, {3e5, 0.5, h * pitch}, {.tolerance = 1e-4});
    const auto contact = layer.press(object(
        eye, [&](double x, double y) { return press - (x * x + y * y) / (2 * ball_radius); }));
    CHECK(contact.converged);
    radius.push_back(touched_radius(contact) / a - 1);
    const double mu = 1e5, exact = pi * mu * std::pow(a, 6) / (32 * ball_radius * h * h * h);
    force.push_back(-contact.force.z() / (exact * pitch * pitch) - 1);
    // Farther than where the object stands in the layer: the layer bulges towards it.
    CHECK(touched_radius(contact) > 1.05 * std::sqrt(2 * ball_radius * press));
  }
  MESSAGE("thin layer, contact 4, 8 and 16 times as wide as thick: radius ", 100 * radius[0], ", ",
          100 * radius[1], ", ", 100 * radius[2], " %; force ", 100 * force[0], ", ",
          100 * force[1], ", ", 100 * force[2], " % from the limit");
  CHECK(std::abs(radius[1]) < 0.7 * std::abs(radius[0]));
  CHECK(std::abs(radius[2]) < 0.7 * std::abs(radius[1]));
  CHECK(std::abs(radius[2]) < 0.08);
  CHECK(std::abs(force[2]) < 0.7 * std::abs(force[1]));
}

TEST_CASE("what keeps its volume bulges by as much as is pressed in") {
  for (const double h : {6.0, 8.0}) {
    const auto eye = camera(241, 241);  // beyond it nothing moves
    const ElasticLayer layer(eye, rest, {1e5, 0.5, h * pitch}, {.tolerance = 1e-4});
    const auto contact = layer.press(object(eye, ball(16, 3, 1.3, 0.4)));
    double sum = 0, pressed_in = 0;
    for (const double u : contact.indentation.pixels()) {
      sum += u;
      pressed_in += std::max(u, 0.0);
    }
    MESSAGE("volume kept to ", 100 * sum / pressed_in, " %");
    CHECK(std::abs(sum / pressed_in) < 0.001);
    CHECK(*std::min_element(contact.indentation.pixels().begin(),
                            contact.indentation.pixels().end()) < -0.05 * 3 * pitch);
  }
}

TEST_CASE("no pressure pulls, nothing penetrates, and one of the two is none") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 12; ++trial) {
    const double nu = trial % 3 == 0 ? 0.5 : 0.5 * uniform(random);
    const double h = trial % 4 == 0 ? inf : (4 + 40 * uniform(random)) * pitch;
    const double aspect = 0.7 + 0.6 * uniform(random), tolerance = 1e-3;
    const auto eye = camera(70, 50, 1, aspect);
    const ElasticLayer layer(eye, rest, {1e5, nu, h}, {.tolerance = tolerance});
    // Waves and a slope, and a hole without an object.
    const double kx = uniform(random), ky = uniform(random), phase = 6 * uniform(random);
    const double slope = 0.1 * (uniform(random) - 0.5), deep = 0.5 + 2 * uniform(random);
    const auto depth = object(eye, [&](double x, double y) {
      if (std::hypot(x - 5, y - 3) < 6) return -inf;
      return deep * std::cos(kx * x + phase) * std::cos(ky * y) + slope * x -
             0.01 * std::hypot(x, y);
    });
    const auto contact = layer.press(depth);
    CHECK(contact.converged);
    double press = 0;
    for (const double z : depth.pixels()) press = std::max(press, rest - z);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      const double p = contact.pressure.pixels()[i];
      const double gap = contact.indentation.pixels()[i] - (rest - depth.pixels()[i]);
      CHECK(p >= 0);
      CHECK(gap >= -1.01 * tolerance * press);
      // Where a gap is wider, there is hardly a pressure: less than closes that gap.
      if (gap > 1.01 * tolerance * press) CHECK(p / 1e5 * pitch < 5 * tolerance * press);
      CHECK(contact.depth.pixels()[i] == rest - contact.indentation.pixels()[i]);
    }
  }
}

TEST_CASE("superposition: the surface is the sum over all loads, and nothing wraps") {
  const auto eye = camera(60, 40, 1, 1.1);
  for (const double h : {9.0, inf}) {
    const double nu = 0.35, mu = 1e5 / (2 + 2 * nu);
    const ElasticLayer layer(eye, rest, {1e5, nu, h * pitch, 0.6}, {.tolerance = 1e-2});
    const auto contact = layer.press(object(eye, ball(11, 2, -12, 3)), {.shift = {3e-5, -2e-5}});
    const detail::LayerGrid grid{60, 40, 1.1, h, nu};
    const auto correction = detail::layer_correction(grid);
    const detail::PressureGreen pressure(grid, correction);
    const detail::SidewaysGreen sideways(grid, correction);
    for (const auto& [u, v] : {std::pair{0, 0}, {59, 39}, {59, 0}, {18, 22}, {40, 10}}) {
      Vec3<double> sum(0, 0, 0);
      for (Index y = 0; y < 40; ++y) {
        for (Index x = 0; x < 60; ++x) {
          const double p = contact.pressure(x, y) / mu;
          const Vec2<double> q = contact.traction(x, y) / mu;
          const Index i = u - x, j = v - y;
          sum.x() += sideways.x(i, j) * p + sideways.xx(i, j) * q.x() + sideways.xy(i, j) * q.y();
          sum.y() += sideways.y(i, j) * p + sideways.xy(i, j) * q.x() + sideways.yy(i, j) * q.y();
          sum.z() -= pressure.down(i, j) * p - sideways.x(i, j) * q.x() - sideways.y(i, j) * q.y();
        }
      }
      CHECK((contact.displacement(u, v) - sum * pitch).norm() < 1e-12 * pitch);
    }
  }
}

TEST_CASE("reciprocity: each of two loads does the same work on the other's displacement") {
  const auto eye = camera(90, 60, 1, 0.9);
  for (const double nu : {0.0, 0.3, 0.5}) {
    for (const double h : {7.0, 40.0, inf}) {
      const ElasticLayer layer(eye, rest, {1e5, nu, h * pitch, 0.7}, {.tolerance = 1e-2});
      const auto a = layer.press(object(eye, ball(9, 1.5, -20, 8)), {.shift = {5e-5, 1e-5}});
      const auto b = layer.press(object(eye, punch(6, 1)), {.shift = {-2e-5, 4e-5}, .twist = 0.01});
      const auto work = [](const LayerContact<double>& load, const LayerContact<double>& surface) {
        double sum = 0;
        for (std::size_t i = 0; i < load.pressure.pixels().size(); ++i) {
          const Vec3<double> u = surface.displacement.pixels()[i];
          sum += load.traction.pixels()[i].dot(u.head<2>()) - load.pressure.pixels()[i] * u.z();
        }
        return sum;
      };
      CHECK(work(a, b) == gelight::test::approx(work(b, a)).epsilon(1e-10));
    }
  }
}

TEST_CASE("a force is borne to within the tolerance, wherever the object was seen") {
  const double nu = 0.3, modulus = 1e5, a = 20, press = 2;
  const auto eye = camera(65, 65);
  const double force = 4.0 / 3 * modulus / (1 - nu * nu) * a * press * pitch * pitch;
  const ElasticLayer layer(eye, rest, {modulus, nu, inf}, {.tolerance = 1e-4});
  for (const double away : {-1.0, 0.0, 0.7, 5.0}) {
    const auto depth = object(eye, [&](double x, double y) { return ball(a, press)(x, y) - away; });
    const auto contact = layer.press(depth, {.force = force});
    CHECK(contact.converged);
    CHECK(-contact.force.z() == gelight::test::approx(force).epsilon(1e-4));
    CHECK(std::abs(contact.travel / pitch - away) < 1e-3 * press);
    const auto again = layer.press(depth, {.force = 1.05 * force}, &contact);
    const auto cold = layer.press(depth, {.force = 1.05 * force});
    CHECK(again.travel == gelight::test::approx(cold.travel).epsilon(1e-3));
    CHECK(again.convolutions < cold.convolutions);
  }
  const auto depth = object(eye, ball(a, press));
  const auto none = layer.press(depth, {.force = 0});
  CHECK(none.force.norm() == 0);
  CHECK(none.travel == gelight::test::approx(-press * pitch));
  const ElasticLayer thin(eye, rest, {modulus, nu, 5 * pitch});
  for (const double some : {1e-6, 1e-3, 0.1}) {
    const auto contact = thin.press(depth, {.force = some});
    CHECK(contact.converged);
    CHECK(-contact.force.z() == gelight::test::approx(some).epsilon(1.1e-3));
  }
  CHECK(contains(refusal([&] { (void)thin.press(depth, {.force = 1e6}); }), "through the gel"));
}

TEST_CASE("scale, place and mirror change nothing else") {
  const auto eye = camera(61, 49);
  const Gel gel{1e5, 0.45, 15 * pitch, 0.5};
  const auto shape = [](double x, double y) {
    return 2 - 0.02 * x * x - 0.01 * y * y + 0.3 * std::sin(0.7 * x + 0.2 * y);
  };
  const LayerOptions options{.tolerance = 1e-4};
  const auto contact = ElasticLayer(eye, rest, gel, options).press(object(eye, shape));
  const double most = largest(contact.pressure);
  for (const double scale : {1e-6, 1e6}) {
    Camera<double> far = eye;
    const double there = rest * scale;
    Image<double> depth = object(eye, shape);
    for (double& z : depth.pixels()) z *= scale;
    const Gel large{1e5 * scale, 0.45, 15 * pitch * scale, 0.5};
    const auto other = ElasticLayer(far, there, large, options).press(depth);
    CHECK(other.pressure(30, 24) / scale ==
          gelight::test::approx(contact.pressure(30, 24)).epsilon(1e-3));
    CHECK(other.force.z() / (scale * scale * scale) ==
          gelight::test::approx(contact.force.z()).epsilon(1e-4));
  }
  const auto mirrored =
      ElasticLayer(eye, rest, gel, options).press(object(eye, [&](double x, double y) {
        return shape(-x, y);
      }));
  const auto turned =
      ElasticLayer(camera(49, 61), rest, gel, options)
          .press(object(camera(49, 61), [&](double x, double y) { return shape(y, x); }));
  for (Index y = 0; y < 49; ++y) {
    for (Index x = 0; x < 61; ++x) {
      CHECK(std::abs(mirrored.pressure(60 - x, y) - contact.pressure(x, y)) < 1e-3 * most);
      CHECK(std::abs(turned.pressure(y, x) - contact.pressure(x, y)) < 1e-3 * most);
      CHECK(std::abs(mirrored.displacement(60 - x, y).x() + contact.displacement(x, y).x()) <
            1e-3 * pitch);
    }
  }
}

TEST_CASE("a moment is that of the forces about the gel on the camera's axis") {
  const auto eye = camera(81, 61);
  const ElasticLayer layer(eye, rest, {1e5, 0.4, inf}, {.tolerance = 1e-5});
  const auto contact = layer.press(object(eye, ball(10, 1, 12, -7)));
  // The object pushes towards the camera, at (12, -7) pixels.
  CHECK(contact.moment.x() / contact.force.z() == gelight::test::approx(-7 * pitch).epsilon(1e-4));
  CHECK(contact.moment.y() / contact.force.z() == gelight::test::approx(-12 * pitch).epsilon(1e-4));
  CHECK(contact.moment.z() == 0);
}

TEST_CASE("a bent rest, float, and a start from the last contact") {
  const auto eye = camera(65, 65);
  Image<double> bent(65, 65), depth(65, 65);
  const auto over = object(eye, ball(15, 2));
  for (Index y = 0; y < 65; ++y) {
    for (Index x = 0; x < 65; ++x) {
      bent(x, y) = rest + 1e-3 * std::cos(0.05 * x) + 1e-5 * y;
      depth(x, y) = bent(x, y) + over(x, y) - rest;
    }
  }
  double mean = 0;
  for (const double z : bent.pixels()) mean += z / (65 * 65);
  Camera<double> same = eye;
  same.fx = same.fy = mean / pitch;
  const Gel gel{1e5, 0.48, 20 * pitch, 0.5};
  const auto flat = ElasticLayer(eye, rest, gel, {.tolerance = 1e-5}).press(over);
  const auto curved = ElasticLayer(same, bent, gel, {.tolerance = 1e-5}).press(depth);
  CHECK(curved.force.z() == gelight::test::approx(flat.force.z()).epsilon(1e-5));
  CHECK(curved.depth(32, 32) == gelight::test::approx(bent(32, 32) - 2 * pitch).epsilon(1e-6));

  const Camera<float> eye_float = eye.cast<float>();
  Image<float> depth_float(65, 65);
  std::copy(over.pixels().begin(), over.pixels().end(), depth_float.pixels().begin());
  const ElasticLayer layer_float(eye_float, static_cast<float>(rest), gel, {.tolerance = 1e-5});
  const auto contact_float = layer_float.press(depth_float);
  CHECK(contact_float.force.z() == gelight::test::approx(flat.force.z()).epsilon(1e-4));

  const ElasticLayer layer(eye, rest, gel);
  const auto first = layer.press(over);
  const auto second = layer.press(over, {}, &first);
  CHECK(second.iterations == 0);
  CHECK(second.convolutions < first.convolutions / 2);
  const auto held = layer.press(over, {.shift = {1e-5, 0}}, &first);
  const auto back = layer.press(over, {}, &held);
  CHECK(back.traction.pixels().empty());
  CHECK(back.force.x() == 0);
}

TEST_CASE("where nothing touches, nothing moves; what is not known stays so") {
  const auto eye = camera(40, 30);
  const ElasticLayer layer(eye, rest, {1e5, 0.48, 30 * pitch}, {.tolerance = 1e-6});
  const auto away = layer.press(Image<double>(40, 30, inf));
  CHECK(away.converged);
  CHECK(away.indentation == Image<double>(40, 30, 0));
  CHECK(away.depth == Image<double>(40, 30, rest));
  CHECK(away.force.norm() == 0);
  auto depth = object(eye, ball(8, 1));
  const auto all = layer.press(depth);
  depth(20, 15) = unknown;
  depth(3, 3) = 0;
  depth(4, 3) = -1;
  const auto some = layer.press(depth);
  CHECK(some.unknown == 3);
  CHECK(std::isnan(some.indentation(20, 15)));
  CHECK(std::isnan(some.depth(3, 3)));
  CHECK(std::isnan(some.displacement(4, 3).x()));
  CHECK(std::isfinite(some.indentation(19, 15)));
  CHECK(-some.force.z() < -all.force.z());
  Image<double> partly(40, 30, rest);
  partly(20, 15) = inf;
  const auto there = ElasticLayer(eye, partly, {1e5, 0.48, 30 * pitch}, {.tolerance = 1e-6})
                         .press(object(eye, ball(8, 1)));
  CHECK(there.unknown == 1);
  CHECK(there.force.z() == gelight::test::approx(some.force.z()).epsilon(1e-9));
  const auto warm = layer.press(depth, {}, &some);
  CHECK(warm.force.z() == gelight::test::approx(some.force.z()).epsilon(1e-3));
}

TEST_CASE("where there is no gel, it does not matter how the rest depth says so") {
  const auto eye = camera(31, 27);
  const auto depth = object(eye, ball(8, 0.5));
  Image<double> bent(31, 27, rest);
  bent(0, 0) = bent(15, 12) = unknown;
  const auto expected = ElasticLayer<double>(eye, bent).press(depth);
  CHECK(expected.unknown == 2);
  CHECK(-expected.force.z() > 0);
  const auto same = [](const Image<double>& a, const Image<double>& b) {
    return std::equal(
        a.pixels().begin(), a.pixels().end(), b.pixels().begin(),
        [](double u, double v) { return u == v || (std::isnan(u) && std::isnan(v)); });
  };
  for (const double none : {0.0, -1.0, -inf, inf}) {
    CAPTURE(none);
    bent(0, 0) = bent(15, 12) = none;
    const auto contact = ElasticLayer<double>(eye, bent).press(depth);
    CHECK(contact.unknown == 2);
    CHECK(same(contact.depth, expected.depth));
    CHECK(same(contact.pressure, expected.pressure));
    CHECK(contact.force == expected.force);
  }
}

TEST_CASE("a single pixel, and a copy") {
  const Camera<double> eye{300, 300, 0, 0, 1, 1};
  const ElasticLayer layer(eye, rest, {1e5, 0.3, inf, inf});
  const Image<double> depth(1, 1, rest - pitch);
  const auto copy = layer;
  for (const LayerLoad& load :
       {LayerLoad{}, {.shift = {1e-5, 0}}, {.twist = 0.1}, {.force = 1e-3}}) {
    const auto contact = copy.press(depth, load);
    CHECK(contact.converged);
    CHECK(contact.pressure(0, 0) > 0);
    CHECK(contact.force == layer.press(depth, load).force);
  }
}

TEST_CASE("a search that ends too soon says so") {
  const auto eye = camera(65, 65);
  const ElasticLayer layer(eye, rest, {1e5, 0.3, inf}, {.tolerance = 1e-6, .most_iterations = 3});
  const auto contact = layer.press(object(eye, ball(20, 2)));
  CHECK_FALSE(contact.converged);
  CHECK(contact.residual > 1e-6);
  CHECK(contact.iterations == 3);
}

TEST_CASE("what is left by a search that ends too soon is what its residual tells") {
  const auto eye = camera(65, 65);
  const auto depth = object(eye, ball(18, 2, 1.3, -0.4));
  for (const Gel& gel : {Gel{1e5, 0.3, inf}, Gel{1e5, 0.5, 8 * pitch}}) {
    for (const int most : {1, 2, 4, 8}) {
      const ElasticLayer layer(eye, rest, gel, {.tolerance = 1e-9, .most_iterations = most});
      const auto contact = layer.press(depth);
      CHECK_FALSE(contact.converged);
      double through = 0;
      for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
        through = std::max(through, contact.depth.pixels()[i] - depth.pixels()[i]);
      }
      CHECK(through / (2 * pitch) < contact.residual * (1 + 1e-6));
    }
    const ElasticLayer layer(eye, rest, gel, {.tolerance = 1e-9, .most_iterations = 2});
    const auto borne = layer.press(depth, {.force = 1});
    CHECK_FALSE(borne.converged);
    CHECK(std::abs(-borne.force.z() - 1) <= borne.residual * (1 + 1e-6));
  }
}

TEST_CASE("a hook ends the press, and is told how far it is") {
  const auto eye = camera(65, 65);
  const auto depth = object(eye, ball(20, 2));
  double last = 0;
  int asked = 0;
  const LayerOptions options{.tolerance = 1e-5, .cancelled = [&](double done) {
                               CHECK(done >= last);
                               last = done;
                               return ++asked == 10;
                             }};
  const ElasticLayer layer(eye, rest, {1e5, 0.3, inf}, options);
  CHECK_THROWS_AS((void)layer.press(depth), Cancelled);
  CHECK(asked == 10);
  last = 0;
  CHECK(layer.press(depth).converged);
}

TEST_CASE("bad input is refused by name") {
  const auto eye = camera(20, 16);
  const auto says = [&](const Gel& gel, const LayerOptions& options = {}) {
    return refusal([&] { (void)ElasticLayer(eye, rest, gel, options); });
  };
  CHECK(says({}) == "accepted");
  for (const double bad : {0.0, -1.0, inf, unknown}) {
    CHECK(contains(says({.elastic_modulus = bad}), "elastic modulus"));
  }
  for (const double bad : {-0.01, 0.51, unknown}) {
    CHECK(contains(says({.poisson_ratio = bad}), "Poisson ratio"));
  }
  for (const double bad : {0.0, -1.0, 1e-6, unknown}) {
    CHECK(contains(says({.thickness = bad}), "gel thickness"));
  }
  for (const double bad : {-0.01, unknown}) {
    CHECK(contains(says({.friction = bad}), "friction"));
  }
  for (const double bad : {0.0, 1.0, unknown}) {
    CHECK(contains(says({}, {.tolerance = bad}), "tolerance"));
  }
  CHECK(contains(says({}, {.most_iterations = 0}), "iterations"));
  CHECK(contains(refusal([&] { (void)ElasticLayer(eye, 0.0); }), "rest depth"));
  CHECK(
      contains(refusal([&] { (void)ElasticLayer(eye, Image<double>(20, 15, rest)); }), "20 x 15"));
  CHECK(contains(refusal([&] { (void)ElasticLayer(eye, Image<double>(20, 16, inf)); }),
                 "known nowhere"));
  CHECK(contains(refusal([&] { (void)ElasticLayer(Camera<double>{}, rest); }), "camera"));

  const ElasticLayer layer(eye, rest, {1e5, 0.4, 10 * pitch});
  const auto depth = object(eye, ball(5, 1));
  const auto press = [&](const Image<double>& image, const LayerLoad& load) {
    return refusal([&] { (void)layer.press(image, load); });
  };
  CHECK(press(depth, {}) == "accepted");
  CHECK(contains(press(Image<double>(20, 17, rest), {}), "20 x 17"));
  for (const double bad : {-1.0, inf, unknown}) {
    CHECK(contains(press(depth, {.force = bad}), "force"));
  }
  CHECK(contains(press(depth, {.shift = {unknown, 0}}), "sideways motion"));
  CHECK(contains(press(depth, {.twist = inf}), "sideways motion"));
  CHECK(contains(press(depth, {.shift = {0, 1e150}}), "sideways motion"));
  CHECK(contains(press(Image<double>(20, 16, inf), {.force = 1}), "no object"));
  auto deep = depth;
  deep(3, 7) = rest - 11 * pitch;
  CHECK(contains(press(deep, {}), "(3, 7)"));
  auto infinite = layer.press(depth);
  infinite.pressure(3, 3) = inf;
  CHECK(
      contains(refusal([&] { (void)layer.press(depth, {}, &infinite); }), "pressure is infinite"));
  const ElasticLayer rough(eye, rest, {1e5, 0.4, 10 * pitch, 0.5});
  infinite = rough.press(depth, {.shift = {pitch, 0}});
  infinite.traction(3, 3).y() = -inf;
  CHECK(
      contains(refusal([&] { (void)rough.press(depth, {}, &infinite); }), "traction is infinite"));
  for (const double bad : {inf, unknown}) {
    auto nowhere = layer.press(depth);
    nowhere.travel = bad;
    CHECK(contains(refusal([&] { (void)layer.press(depth, {.force = 0.1}, &nowhere); }),
                   "previous contact's travel"));
  }
  for (const double bad : {-5.0, inf, unknown}) {
    CHECK(contains(refusal([&] { (void)ElasticLayer(eye, rest, {.tension = bad}); }), "tension"));
  }
  const LayerContact<double> none;
  CHECK(contains(refusal([&] { (void)layer.press(depth, {}, &none); }), "previous contact"));
}
