#include "gelight/membrane/springs.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "gelight/membrane/contact.hpp"
#include "gelight/membrane/spring_membrane.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/approx.hpp"
#include "support/dense.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::refusal;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double rest = 0.03;

// Springs `pixel` metres apart, counted from the middle of an image of odd size.
Camera<double> camera(Index width, Index height, double pixel) {
  const double f = rest / pixel;
  return {f, f, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
}

// The depth of an object whose lower side is `height(x, y)` above the gel, x and y in metres.
template <class Height>
Image<double> object(const Camera<double>& eye, const Height& height) {
  Image<double> depth(eye.width, eye.height);
  for (Index v = 0; v < eye.height; ++v) {
    for (Index u = 0; u < eye.width; ++u) {
      depth(u, v) = rest + height((u - eye.cx) * rest / eye.fx, (v - eye.cy) * rest / eye.fy);
    }
  }
  return depth;
}

double borne(const SpringBed<double>& bed, const SpringContact<double>& contact) {
  double sum = 0;
  for (const double u : contact.indentation.pixels()) sum += u;
  return bed.gel().stiffness() * bed.spring_area() * sum;
}

std::size_t touching(const SpringContact<double>& contact) {
  const auto& marks = contact.touching.pixels();
  return static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1));
}

// The displacement by another way: with the gaps sorted, the force is known at each of them.
double displacement_by_sorting(std::vector<double> gaps, double load) {
  std::sort(gaps.begin(), gaps.end());
  double sum = 0;
  for (std::size_t n = 1; n <= gaps.size(); ++n) {
    sum += gaps[n - 1];
    const double d = (load + sum) / static_cast<double>(n);
    if (n == gaps.size() || d <= gaps[n]) return d;
  }
  return unknown;
}

}  // namespace

TEST_CASE("a flat punch sinks in by force over stiffness and area") {
  const auto eye = camera(61, 41, 2e-4);
  const SpringBed bed(eye, rest, {.elastic_modulus = 2e5, .thickness = 0.004});
  const auto punch = object(eye, [](double x, double y) {
    return std::abs(x) < 2.9e-3 && std::abs(y) < 1.9e-3 ? 1e-3 : inf;
  });
  const auto contact = bed.press(punch, 0.8);
  const double area = 29 * 19 * 4e-8, sunk = 0.8 / (5e7 * area);
  CHECK(contact.equilibrium == Equilibrium::reached);
  CHECK(contact.displacement == gelight::test::approx(1e-3 + sunk).epsilon(1e-14));
  CHECK(touching(contact) == 29 * 19);
  CHECK(contact.indentation(30, 20) == gelight::test::approx(sunk).epsilon(1e-12));
  CHECK(contact.indentation(0, 0) == 0);
  CHECK(std::abs(contact.residual_force) < 1e-14);
  CHECK(bed.depth(contact)(30, 20) == gelight::test::approx(rest - sunk).epsilon(1e-14));
}

TEST_CASE("the depth of another bed's contact is refused by its size") {
  const SpringBed bed(camera(61, 41, 2e-4), rest), turned(camera(41, 61, 2e-4), rest);
  const auto punch = object(camera(41, 61, 2e-4), [](double, double) { return 1e-3; });
  CHECK_THROWS_WITH_AS((void)bed.depth(turned.press(punch, 0.8)),
                       doctest::Contains("the contact is 41 x 61 pixels, the camera's image 61"),
                       InvalidInput);
  CHECK_THROWS_WITH_AS((void)bed.depth({}), doctest::Contains("the contact is 0 x 0"),
                       InvalidInput);
}

TEST_CASE("a paraboloid on a Winkler foundation: force pi k R d^2, radius sqrt(2 R d)") {
  // The sum over pixels tends to the integral as they get smaller.
  const double radius = 0.02, force = 0.5;
  double last_error = inf;
  for (const double pixel : {4e-4, 2e-4, 1e-4, 5e-5}) {
    const auto size = static_cast<Index>(0.016 / pixel) + 1;
    const auto eye = camera(size, size, pixel);
    const SpringBed bed(eye, rest, {.elastic_modulus = 5e4});
    const auto ball =
        object(eye, [&](double x, double y) { return (x * x + y * y) / (2 * radius); });
    const auto contact = bed.press(ball, force);
    const double exact = std::sqrt(force / (std::numbers::pi * 1e7 * radius));
    const double error = std::abs(contact.displacement / exact - 1);
    CHECK(error < 0.05 * pixel / 4e-4);
    last_error = error;
    const double area = static_cast<double>(touching(contact)) * pixel * pixel;
    CHECK(area / (2 * std::numbers::pi * radius * exact) ==
          gelight::test::approx(1).epsilon(20 * pixel));
    CHECK(borne(bed, contact) == gelight::test::approx(force).epsilon(1e-12));
  }
  CHECK(last_error < 1e-4);
}

TEST_CASE("a wedge on a Winkler foundation: force k L d^2 / slope") {
  const double slope = 0.3, pixel = 5e-5, force = 0.4;
  const auto eye = camera(401, 21, pixel);
  const SpringBed bed(eye, rest, {.elastic_modulus = 1e5});
  const auto wedge = object(eye, [&](double x, double) { return slope * std::abs(x); });
  const auto contact = bed.press(wedge, force);
  const double length = 21 * pixel;
  const double exact = std::sqrt(force * slope / (2e7 * length));
  CHECK(contact.displacement == gelight::test::approx(exact).epsilon(1e-3));
  // Exactly, for the springs there are: n on either side of the middle one.
  const int n = static_cast<int>(contact.displacement / (slope * pixel));
  const double load = force / (2e7 * pixel * pixel * 21);
  CHECK(contact.displacement ==
        gelight::test::approx((load + slope * pixel * n * (n + 1)) / (2 * n + 1)).epsilon(1e-14));
}

TEST_CASE("any heap of gaps: what sorting them says, to rounding") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> gap(-1e-3, 2e-3);
  const auto eye = camera(83, 37, 1e-4);
  const SpringBed bed(eye, rest, {.elastic_modulus = 1e5});
  for (int round = 0; round < 20; ++round) {
    const auto depth = object(
        eye, [&](double, double) { return round % 2 == 0 || gap(random) > 0 ? gap(random) : inf; });
    std::vector<double> gaps;
    for (const double z : depth.pixels()) {
      if (z != inf) gaps.push_back(z - rest);
    }
    double last = -inf;
    for (const double force : {1e-9, 1e-4, 0.02, 0.3, 1.0}) {
      const auto contact = bed.press(depth, force);
      CHECK(contact.equilibrium == Equilibrium::reached);
      const double exact = displacement_by_sorting(gaps, force / (2e7 * bed.spring_area()));
      CHECK(std::abs(contact.displacement - exact) < 1e-17);
      CHECK(std::abs(contact.residual_force) <= 1e-12 * force + 1e-16);
      CHECK(contact.displacement > last);
      last = contact.displacement;
    }
  }
}

TEST_CASE("more force never lifts a spring") {
  const auto eye = camera(41, 41, 2e-4);
  const SpringBed bed(eye, rest, {});
  const SpringBed taut(eye, rest, {.tension = 2});
  const auto bumps = object(eye, [](double x, double y) {
    return 2e-4 * (2 + std::sin(3e3 * x) * std::cos(2e3 * y)) + 3 * x * x;
  });
  for (const auto* springs : {&bed, &taut}) {
    auto before = springs->press(bumps, 0.01);
    for (const double force : {0.02, 0.1, 0.5, 2.0}) {
      const auto contact = springs->press(bumps, force);
      REQUIRE(contact.equilibrium == Equilibrium::reached);
      CHECK(contact.displacement > before.displacement);
      CHECK(touching(contact) >= touching(before));
      for (Index v = 0; v < 41; ++v) {
        for (Index u = 0; u < 41; ++u) {
          CHECK(contact.indentation(u, v) >= before.indentation(u, v) - 1e-15);
        }
      }
      before = contact;
    }
  }
}

TEST_CASE("a block loaded off its middle, within its kern: it tilts by moment over k I") {
  const double pixel = 1e-4;
  const auto eye = camera(121, 91, pixel);
  const SpringBed bed(eye, rest, {.elastic_modulus = 1e5});
  // 81 x 51 springs, lifted and tilted before it is let down: that must not matter.
  const auto block = object(eye, [](double x, double y) {
    return std::abs(x) < 4.05e-3 && std::abs(y) < 2.55e-3 ? 3e-4 + 0.02 * x - 0.03 * y : inf;
  });
  const double force = 1.5;
  const Vec2<double> centre(3e-4, -2e-4);
  const auto contact = bed.press_tilting(block, force, centre);
  REQUIRE(contact.equilibrium == Equilibrium::reached);
  const double k = 2e7 * pixel * pixel;
  const double n = 81 * 51, xx = n * (81 * 81 - 1) / 12 * pixel * pixel,
               yy = n * (51 * 51 - 1) / 12 * pixel * pixel;
  CHECK(contact.displacement == gelight::test::approx(3e-4 + force / (k * n)).epsilon(1e-10));
  CHECK(contact.tilt.x() ==
        gelight::test::approx(0.02 + force * centre.x() / (k * xx)).epsilon(1e-9));
  CHECK(contact.tilt.y() ==
        gelight::test::approx(-0.03 + force * centre.y() / (k * yy)).epsilon(1e-9));
  CHECK(std::abs(contact.residual_force) < 1e-9 * force);
  CHECK(contact.residual_moment.norm() < 1e-9 * force * 6e-3);
  double mx = 0, my = 0;
  for (Index v = 0; v < eye.height; ++v) {
    for (Index u = 0; u < eye.width; ++u) {
      mx += k * contact.indentation(u, v) * (u - eye.cx) * pixel;
      my += k * contact.indentation(u, v) * (v - eye.cy) * pixel;
    }
  }
  CHECK(mx == gelight::test::approx(force * centre.x()).epsilon(1e-9));
  CHECK(my == gelight::test::approx(force * centre.y()).epsilon(1e-9));
}

TEST_CASE("a block loaded outside its kern lifts: it bears over three times the edge's distance") {
  const double pixel = 2e-5, half = 201 * pixel / 2;
  const auto eye = camera(301, 9, pixel);
  const SpringBed bed(eye, rest, {.elastic_modulus = 1e5});
  const auto block = object(eye, [&](double x, double) { return std::abs(x) < half ? 0.0 : inf; });
  for (const double off : {0.4, 0.6, 0.8}) {  // of half its length; the kern ends at a third
    const double force = 0.002, to_edge = half * (1 - off), width = 9 * pixel;
    const auto contact = bed.press_tilting(block, force, {off * half, 0});
    REQUIRE(contact.equilibrium == Equilibrium::reached);
    CHECK(static_cast<double>(touching(contact)) * pixel / 9 ==
          gelight::test::approx(3 * to_edge).epsilon(0.02));
    // A triangle of pressure, highest at the edge, half a pixel beyond the last spring.
    const double edge = 2 * force / (width * 3 * to_edge) / 2e7;
    const double slope = edge / (3 * to_edge);
    CHECK(contact.tilt.x() == gelight::test::approx(slope).epsilon(0.02));
    CHECK(contact.indentation(250, 4) ==
          gelight::test::approx(edge - slope * pixel / 2).epsilon(0.01));
  }
}

TEST_CASE("a force straight through a body's middle does not tilt it; one beside it tips it over") {
  const auto eye = camera(61, 61, 2e-4);
  const SpringBed bed(eye, rest, {.elastic_modulus = 5e4});
  const auto ball = object(
      eye, [](double x, double y) { return x * x + y * y < 2e-5 ? (x * x + y * y) / 0.02 : inf; });
  const auto straight = bed.press(ball, 0.2), tilting = bed.press_tilting(ball, 0.2, {0, 0});
  CHECK(tilting.displacement == gelight::test::approx(straight.displacement).epsilon(1e-12));
  CHECK(tilting.tilt.norm() < 1e-12);
  // A ring has no spring under the middle of its hull, and stands.
  const auto ring = object(eye, [](double x, double y) {
    const double r = std::hypot(x, y);
    return r > 3e-3 && r < 5e-3 ? 0.0 : inf;
  });
  CHECK(bed.press_tilting(ring, 0.2, {1e-3, 0}).equilibrium == Equilibrium::reached);
  const auto off = bed.press_tilting(ring, 0.2, {5.1e-3, 0});
  CHECK(off.equilibrium == Equilibrium::tips_over);
  CHECK(off.residual_force == 0.2);
  CHECK(touching(off) == 0);
  // Three feet: the hull is the triangle between them.
  Image<double> feet(61, 61, inf);
  feet(10, 10) = feet(50, 10) = feet(30, 50) = rest;
  const SpringBed stiff(eye, rest, {.elastic_modulus = 5e6});
  const auto at = [&](double column, double row) {
    return stiff.press_tilting(feet, 1e-3, {(column - 30) * 2e-4, (row - 30) * 2e-4});
  };
  const auto inside = at(25, 20);
  CHECK(inside.equilibrium == Equilibrium::reached);
  // Each foot bears its barycentric share.
  const double one = 1e-3 / (1e9 * stiff.spring_area());
  CHECK(inside.indentation(10, 10) == gelight::test::approx(0.5 * one).epsilon(1e-8));
  CHECK(inside.indentation(50, 10) == gelight::test::approx(0.25 * one).epsilon(1e-8));
  CHECK(inside.indentation(30, 50) == gelight::test::approx(0.25 * one).epsilon(1e-8));
  CHECK(at(15, 30).equilibrium == Equilibrium::tips_over);
  CHECK(at(30, 51).equilibrium == Equilibrium::tips_over);
}

TEST_CASE("a row of springs bears a force on it, and tips under one beside it") {
  const auto eye = camera(41, 11, 2e-4);
  const SpringBed bed(eye, rest, {});
  const auto edge = object(eye, [](double x, double y) {
    return std::abs(y) < 1e-4 && std::abs(x) < 2.1e-3 ? 0.0 : inf;
  });
  const auto on = bed.press_tilting(edge, 0.01, {2e-4, 0});
  CHECK(on.equilibrium == Equilibrium::reached);
  const double xx = 21.0 * (21 * 21 - 1) / 12 * 4e-8;
  CHECK(on.tilt.x() == gelight::test::approx(0.01 * 2e-4 / (2e7 * 4e-8 * xx)).epsilon(1e-8));
  CHECK(bed.press_tilting(edge, 0.01, {2e-4, 2e-4}).equilibrium == Equilibrium::tips_over);
}

namespace {

// The membrane's displacement under forces (over the springs' stiffness) on some of its pixels, by
// elimination.
Eigen::VectorXd displacement_by_elimination(Index width, Index height, double coupling,
                                            const Eigen::VectorXd& forces) {
  Eigen::MatrixXd equations = Eigen::MatrixXd::Identity(width * height, width * height);
  const auto couple = [&](Index a, Index b) {
    equations(a, a) += coupling;
    equations(b, b) += coupling;
    equations(a, b) -= coupling;
    equations(b, a) -= coupling;
  };
  for (Index v = 0; v < height; ++v) {
    for (Index u = 0; u < width; ++u) {
      if (u + 1 < width) couple(v * width + u, v * width + u + 1);
      if (v + 1 < height) couple(v * width + u, (v + 1) * width + u);
    }
  }
  return by_elimination<double>(equations, forces);
}

}  // namespace

TEST_CASE("two feet, or a row of them, do not tilt about the line that they stand on") {
  constexpr Index width = 23, height = 19;
  constexpr double pixel = 2e-4;
  const auto eye = camera(width, height, pixel);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> one(0, 1);
  for (int round = 0; round < 60; ++round) {
    const double tension = std::array{0.0, 0.1, 3.0, 30.0, 300.0}[random() % 5];
    const double force = std::pow(10, -9 + 6 * one(random));
    const SpringBed bed(eye, rest,
                        {.elastic_modulus = 1e6, .thickness = 0.005, .tension = tension});
    const auto column = [&] { return static_cast<Index>(random() % width); };
    const auto row = [&] { return static_cast<Index>(random() % height); };
    const std::array<Index, 2> x{column(), column()}, y{row(), row()};
    if (std::abs(x[0] - x[1]) + std::abs(y[0] - y[1]) < 2) continue;
    const std::array gaps{1e-3 * one(random), 1e-3 * one(random)};
    Image<double> feet(width, height, inf);
    Eigen::VectorXd borne = Eigen::VectorXd::Zero(width * height);
    const double share = 0.1 + 0.8 * one(random);  // of the force, on the second foot
    const double stiffness = bed.gel().stiffness() * bed.spring_area();
    for (std::size_t k = 0; k < 2; ++k) {
      feet(x[k], y[k]) = rest + gaps[k];
      borne[y[k] * width + x[k]] = force / stiffness * (k == 1 ? share : 1 - share);
    }
    const auto place = [&](std::size_t k) {
      return Vec2<double>((x[k] - eye.cx) * pixel, (y[k] - eye.cy) * pixel);
    };
    const Vec2<double> centre = (1 - share) * place(0) + share * place(1);
    int sweeps = 0;
    const auto contact = bed.press_tilting(feet, force, centre, [&] { return ++sweeps > 20000; });
    CAPTURE(round);
    CAPTURE(tension);
    CAPTURE(force);
    REQUIRE(contact.equilibrium == Equilibrium::reached);
    const auto want = displacement_by_elimination(
        width, height, tension / bed.gel().stiffness() / (pixel * pixel), borne);
    const double scale = want.maxCoeff();
    double worst = 0;
    for (Index i = 0; i < width * height; ++i) {
      const double got = contact.indentation(i % width, i / width);
      worst = std::max(worst, std::abs(got - want[i]));
    }
    // Places of a millimetre are rounded by 2e-19 m, and tilted over the whole image by more.
    CHECK(worst < 1e-7 * scale + 1e-17);
    // The object goes down by the gap and the indentation at each foot, and tilts along their line
    // alone.
    const Vec2<double> apart = place(1) - place(0);
    const double rise = gaps[1] + want[y[1] * width + x[1]] - gaps[0] - want[y[0] * width + x[0]];
    const Vec2<double> tilt = rise / apart.squaredNorm() * apart;
    CHECK((contact.tilt - tilt).norm() < 1e-7 * tilt.norm() + 1e-12);
  }
}

TEST_CASE("a row of springs at any angle bears what acts on it, with tension or without") {
  constexpr Index width = 41, height = 37;
  constexpr double pixel = 2e-4;
  const auto eye = camera(width, height, pixel);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> one(0, 1);
  constexpr std::array<std::array<Index, 2>, 6> steps{
      {{1, 0}, {0, 1}, {1, 1}, {2, 1}, {-1, 3}, {-1, 1}}};
  for (const auto& step : steps) {
    for (const double tension : {0.0, 0.5, 30.0}) {
      for (const double force : {1e-8, 1e-4, 1e-2}) {
        const auto reach = static_cast<Index>(1 + random() % 4);
        Image<double> edge(width, height, inf);
        for (Index i = -reach; i <= reach; ++i) {
          edge(20 + i * step[0], 18 + i * step[1]) = rest + 1e-4;
        }
        // Within the middle third all of them bear.
        const double at = 0.3 * reach * (2 * one(random) - 1);
        const Vec2<double> centre(at * step[0] * pixel, at * step[1] * pixel);
        const SpringBed bed(eye, rest, {.elastic_modulus = 1e6, .tension = tension});
        int sweeps = 0;
        const auto contact =
            bed.press_tilting(edge, force, centre, [&] { return ++sweeps > 20000; });
        CAPTURE(tension);
        CAPTURE(force);
        CAPTURE(sweeps);
        REQUIRE(contact.equilibrium == Equilibrium::reached);
        CHECK(borne(bed, contact) == gelight::test::approx(force).epsilon(1e-8));
        const Vec2<double> across(-step[1], step[0]);
        CHECK(std::abs(contact.tilt.dot(across)) < 1e-9 * contact.tilt.norm() + 1e-14);
        CHECK(std::abs(contact.residual_moment.norm()) < 1e-8 * force * width * pixel);
      }
    }
  }
}

TEST_CASE("any force that is too strong is told, with the object as deep in as the gel is thick") {
  constexpr double pixel = 2e-4, thickness = 0.004;
  const auto eye = camera(31, 27, pixel);
  std::mt19937 random(29);
  std::uniform_real_distribution<double> one(0, 1);
  for (int shape = 0; shape < 6; ++shape) {
    const double tilt_x = one(random) - 0.5, tilt_y = one(random) - 0.5;
    const auto thing = object(eye, [&](double x, double y) {
      const double above = 5e-4 + 0.1 * (tilt_x * x + tilt_y * y);
      if (shape % 3 == 0) return std::abs(y) < 0.5 * pixel && std::abs(x) < 2e-3 ? 5e-4 : inf;
      if (shape % 3 == 1) return std::max(std::abs(x), std::abs(y)) < 1.5e-3 ? above : inf;
      return above + (x * x + y * y) / 0.01;
    });
    const double nearest = *std::min_element(thing.pixels().begin(), thing.pixels().end()) - rest;
    for (const double tension : {0.0, 0.2, 20.0}) {
      const SpringBed bed(eye, rest, {.thickness = thickness, .tension = tension});
      for (const double force : {1e3, 1e20, 1e150, 1e300, std::numeric_limits<double>::max()}) {
        const Vec2<double> centre(1e-3 * (one(random) - 0.5), 0);
        for (const bool tilts : {false, true}) {
          int sweeps = 0;
          const auto enough = [&] { return ++sweeps > 30000; };
          const auto contact = tilts ? bed.press_tilting(thing, force, centre, enough)
                                     : bed.press(thing, force, enough);
          CAPTURE(shape);
          CAPTURE(tension);
          CAPTURE(force);
          CAPTURE(tilts);
          CHECK(contact.equilibrium == Equilibrium::too_strong);
          const auto& w = contact.indentation.pixels();
          CHECK(*std::max_element(w.begin(), w.end()) ==
                gelight::test::approx(thickness).epsilon(1e-9));
          // What is told of the force is that of the indentation that is told.
          CHECK(borne(bed, contact) == gelight::test::approx(contact.force).epsilon(1e-7));
          CHECK(contact.force + contact.residual_force ==
                gelight::test::approx(force).epsilon(1e-12));
          CHECK(contact.force > 0);
          if (!tilts) {
            CHECK(contact.displacement ==
                  gelight::test::approx(nearest + thickness).epsilon(1e-12));
          }
        }
      }
    }
  }
}

TEST_CASE("a taut membrane round a long punch falls off as the discrete equation's root") {
  const double pixel = 2e-4;
  const auto eye = camera(301, 5, pixel);
  const Gel gel{.elastic_modulus = 1e5, .thickness = 0.005, .tension = 8};
  const SpringBed bed(eye, rest, gel);
  const int half = 10;  // springs on either side of the middle
  const auto punch =
      object(eye, [&](double x, double) { return std::abs(x) < (half + 0.5) * pixel ? 0.0 : inf; });
  const double force = 0.5;
  const auto contact = bed.press(punch, force);
  REQUIRE(contact.equilibrium == Equilibrium::reached);
  // w_i - c (w_(i-1) - 2 w_i + w_(i+1)) = 0 beside the punch: w falls by `root` with every spring.
  const double c = gel.tension / gel.stiffness() / (pixel * pixel);
  const double b = (1 + 2 * c) / (2 * c), root = b - std::sqrt(b * b - 1);
  const double all = 2 * half + 1 + 2 * root / (1 - root);
  const double deep = force / (gel.stiffness() * pixel * pixel * 5 * all);
  CHECK(contact.displacement == gelight::test::approx(deep).epsilon(1e-8));
  for (const Index i : {1, 3, 20}) {
    CHECK(contact.indentation(150 + half + i, 2) ==
          gelight::test::approx(deep * std::pow(root, i)).epsilon(1e-7));
  }
  CHECK(touching(contact) == (2 * half + 1) * 5);
  CHECK(borne(bed, contact) == gelight::test::approx(force).epsilon(1e-9));
}

TEST_CASE("a taut membrane: nothing pulls at the object, nothing goes through it") {
  const double pixel = 2e-4;
  const auto eye = camera(61, 51, pixel);
  const Gel gel{.elastic_modulus = 5e4, .thickness = 0.005, .tension = 3};
  const SpringBed bed(eye, rest, gel);
  const auto shape = object(eye, [](double x, double y) {
    const double dx = x - 1e-3;
    return std::min(dx * dx + y * y, (x + 2e-3) * (x + 2e-3) + 2 * y * y) / 0.01;
  });
  const Vec2<double> centre(2e-4, 1e-4);
  const double force = 0.3, c = gel.tension / gel.stiffness() / (pixel * pixel);
  for (const bool tilts : {false, true}) {
    const auto contact = tilts ? bed.press_tilting(shape, force, centre) : bed.press(shape, force);
    REQUIRE(contact.equilibrium == Equilibrium::reached);
    const auto& w = contact.indentation;
    double sum = 0, mx = 0, my = 0;
    for (Index v = 0; v < eye.height; ++v) {
      for (Index u = 0; u < eye.width; ++u) {
        const double x = (u - eye.cx) * pixel, y = (v - eye.cy) * pixel;
        const double past =
            contact.displacement + contact.tilt.dot(Vec2<double>(x, y)) - (shape(u, v) - rest);
        CHECK(w(u, v) >= past - 1e-14);
        double pressure = w(u, v);
        for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const Index a = u + du, b = v + dv;
          if (a < 0 || b < 0 || a >= eye.width || b >= eye.height) continue;
          pressure += c * (w(u, v) - w(a, b));
        }
        if (contact.touching(u, v) == 1) {
          CHECK(pressure > -1e-13);
          CHECK(w(u, v) == gelight::test::approx(past).epsilon(1e-9));
          sum += pressure, mx += pressure * x, my += pressure * y;
        } else {
          CHECK(std::abs(pressure) < 1e-13);
        }
      }
    }
    const double k = gel.stiffness() * bed.spring_area();
    CHECK(k * sum == gelight::test::approx(force).epsilon(1e-8));
    CHECK(borne(bed, contact) == gelight::test::approx(force).epsilon(1e-8));
    if (!tilts) continue;
    CHECK(k * mx == gelight::test::approx(force * centre.x()).epsilon(1e-6));
    CHECK(k * my == gelight::test::approx(force * centre.y()).epsilon(1e-6));
  }
}

TEST_CASE("a very taut membrane: the contact's equations hold, and few cycles find it") {
  // Sweeps alone would take thousands.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> wave(500, 4000), height(2e-6, 4e-5);
  const double pixel = 6e-5;
  const auto eye = camera(201, 150, pixel);
  for (const double tension : {30.0, 300.0, 3000.0}) {
    const double a = wave(random), b = wave(random), rough = height(random);
    const auto shape = object(eye, [&](double x, double y) {
      return (x * x + 2 * y * y) / 0.01 + rough * std::sin(a * x) * std::cos(b * y);
    });
    const Gel gel{.elastic_modulus = 1e5, .thickness = 0.005, .tension = tension};
    const SpringBed bed(eye, rest, gel);
    int cycles = 0;
    const CancelHook count([&] {
      ++cycles;
      return false;
    });
    const auto contact = bed.press(shape, 1.0, count);
    REQUIRE(contact.equilibrium == Equilibrium::reached);
    CHECK(cycles < 500);
    const auto& w = contact.indentation;
    const double c = tension / gel.stiffness() / (pixel * pixel);
    const double deep = *std::max_element(w.pixels().begin(), w.pixels().end());
    double sum = 0;
    for (Index v = 0; v < eye.height; ++v) {
      for (Index u = 0; u < eye.width; ++u) {
        double pressure = w(u, v);
        for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const Index x = u + du, y = v + dv;
          if (x < 0 || y < 0 || x >= eye.width || y >= eye.height) continue;
          pressure += c * (w(u, v) - w(x, y));
        }
        sum += pressure;
        const double past = contact.displacement - (shape(u, v) - rest);
        CHECK(w(u, v) >= past - 1e-12 * deep);
        const double rounding = 1e-11 * (1 + 4 * c) * deep;
        if (contact.touching(u, v) == 1) {
          CHECK(pressure > -rounding);
          CHECK(std::abs(w(u, v) - past) < 1e-11 * deep);
        } else {
          CHECK(std::abs(pressure) < rounding);
        }
      }
    }
    CHECK(gel.stiffness() * bed.spring_area() * sum == gelight::test::approx(1).epsilon(1e-9));
  }
}

TEST_CASE("hardly any tension: the lone springs; more tension: less deep") {
  const auto eye = camera(41, 41, 2e-4);
  const auto ball = object(eye, [](double x, double y) { return (x * x + y * y) / 0.02; });
  const auto deep = [&](double tension) {
    return SpringBed(eye, rest, {.tension = tension}).press(ball, 0.3).displacement;
  };
  CHECK(deep(1e-9) == gelight::test::approx(deep(0)).epsilon(1e-8));
  CHECK(deep(1) < deep(0));
  CHECK(deep(10) < deep(1));
}

TEST_CASE("what the gel cannot bear, and what does not press, is told") {
  const auto eye = camera(41, 41, 2e-4);
  const SpringBed bed(eye, rest, {.elastic_modulus = 1e5, .thickness = 0.002});
  const auto punch = object(eye, [](double x, double y) {
    return std::max(std::abs(x), std::abs(y)) < 1e-3 ? 0.0 : inf;
  });
  const double most = 5e7 * 9 * 9 * 4e-8 * 0.002;
  CHECK(bed.press(punch, 0.999 * most).equilibrium == Equilibrium::reached);
  const auto through = bed.press(punch, 1.5 * most);
  CHECK(through.equilibrium == Equilibrium::too_strong);
  CHECK(through.displacement == gelight::test::approx(0.002).epsilon(1e-12));
  CHECK(through.force == gelight::test::approx(most).epsilon(1e-12));
  CHECK(through.residual_force == gelight::test::approx(0.5 * most).epsilon(1e-10));
  const auto tilted = bed.press_tilting(punch, 0.9 * most, {5e-4, 0});
  CHECK(tilted.equilibrium == Equilibrium::too_strong);
  CHECK(*std::max_element(tilted.indentation.pixels().begin(), tilted.indentation.pixels().end()) <=
        0.002 * (1 + 1e-12));

  const auto pull = bed.press(punch, -0.1);
  CHECK(pull.equilibrium == Equilibrium::pull);
  CHECK(pull.force == 0);
  CHECK(pull.residual_force == -0.1);
  CHECK(touching(pull) == 0);

  const auto nothing = bed.press(Image<double>(41, 41, inf), 0.1);
  CHECK(nothing.equilibrium == Equilibrium::untouched);
  CHECK(nothing.residual_force == 0.1);
  CHECK(touching(nothing) == 0);
  const auto all_unknown = bed.press(Image<double>(41, 41, unknown), 0.1);
  CHECK(all_unknown.equilibrium == Equilibrium::untouched);
  CHECK(all_unknown.unknown == 41 * 41);

  const auto hover = object(eye, [](double x, double) { return 3e-4 + x * x; });
  const auto resting = bed.press(hover, 0);
  CHECK(resting.equilibrium == Equilibrium::reached);
  CHECK(resting.displacement == gelight::test::approx(3e-4).epsilon(1e-12));
  CHECK(touching(resting) == 0);
}

TEST_CASE("unknown depths bear nothing, stay unknown and are counted") {
  const auto eye = camera(41, 31, 2e-4);
  const auto ball = object(eye, [](double x, double y) { return (x * x + y * y) / 0.02; });
  for (const double tension : {0.0, 2.0}) {
    const SpringBed bed(eye, rest, {.tension = tension});
    auto holed = ball, without = ball;
    for (Index u = 18; u < 23; ++u) {
      holed(u, 15) = u % 2 == 0 ? unknown : 0.0;
      holed(u, 3) = -0.01;
      without(u, 15) = without(u, 3) = inf;
    }
    const auto contact = bed.press(holed, 0.2), want = bed.press(without, 0.2);
    CHECK(contact.unknown == 10);
    CHECK(want.unknown == 0);
    CHECK(contact.displacement == want.displacement);
    for (Index v = 0; v < 31; ++v) {
      for (Index u = 0; u < 41; ++u) {
        const bool hole = u >= 18 && u < 23 && (v == 15 || v == 3);
        CHECK(std::isnan(contact.indentation(u, v)) == hole);
        if (!hole) CHECK(contact.indentation(u, v) == want.indentation(u, v));
      }
    }
  }
}

TEST_CASE("float depths: the same displacement; a contact's images are used again") {
  const auto eye = camera(101, 81, 1e-4);
  const auto ball = object(eye, [](double x, double y) { return (x * x + y * y) / 0.02; });
  const SpringBed exact(eye, rest, {});
  const SpringBed<float> bed(eye.cast<float>(), static_cast<float>(rest), {});
  SpringContact<float> contact;
  for (const double force : {0.05, 0.4}) {
    bed.press_into(contact, ball, force);
    CHECK(contact.displacement ==
          gelight::test::approx(exact.press(ball, force).displacement).epsilon(1e-5));
    CHECK(std::abs(contact.residual_force) < 1e-12 * force);
    const float* const pixels = contact.indentation.data();
    bed.press_tilting_into(contact, ball, force, {1e-4, 1e-4});
    CHECK(contact.equilibrium == Equilibrium::reached);
    CHECK(contact.indentation.data() == pixels);
  }
  const auto transposed = exact.press(ball.view(), 0.3);
  CHECK(transposed.displacement == exact.press(ball, 0.3).displacement);
}

TEST_CASE("input that cannot be used is refused") {
  const auto eye = camera(21, 21, 2e-4);
  CHECK(refusal([&] { SpringBed(eye, rest, {.elastic_modulus = -1}); }) ==
        "elastic modulus -1 is not positive and finite");
  CHECK(refusal([&] { SpringBed(eye, rest, {.thickness = -0.5}); }) ==
        "gel thickness -0.5 is not positive and finite");
  CHECK(refusal([&] { SpringBed(eye, rest, {.thickness = unknown}); }) != "accepted");
  CHECK(refusal([&] { SpringBed(eye, rest, {.tension = -2}); }) ==
        "tension -2 is negative or not finite");
  CHECK(refusal([&] { SpringBed(eye, -1.0); }) == "rest depth -1 is not positive and finite");
  CHECK_THROWS_AS(SpringBed(Camera<double>{0, 1, 0, 0, 4, 4}, rest), InvalidInput);
  const SpringBed bed(eye, rest);
  CHECK(refusal([&] { (void)bed.press(Image<double>(20, 21, rest), 1); }) ==
        "the depth image is 20 x 21 pixels, the camera's image 21 x 21");
  CHECK(refusal([&] { (void)bed.press(Image<double>(21, 21, rest), unknown); }) ==
        "force nan is not finite");
  CHECK(refusal([&] {
          (void)bed.press_tilting(Image<double>(21, 21, rest), 1, {unknown, 0});
        }) == "the force's centre (nan, 0) is not finite");
}

TEST_CASE("tilting: an equilibrium wherever there is one, from light to heavy, on any object") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> one(0, 1);
  int reached = 0, tipped = 0, through = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto size = [&] { return static_cast<Index>(11 + 2 * (random() % 20)); };
    const auto eye = camera(size(), size(), 1e-4);
    const double a = one(random), b = one(random), c = one(random);
    const double tilt_x = 0.3 * (one(random) - 0.5), tilt_y = 0.3 * (one(random) - 0.5);
    // A ball, a rough block, a tilted one, a wavy one, a few feet.
    const auto shape = object(eye, [&](double x, double y) {
      const double above = 1e-3 * a;
      if (i % 5 == 0) return above + (x * x + y * y) / (2e-3 + 2e-2 * a);
      if (i % 5 == 1) return above + 1e-5 * one(random);
      if (i % 5 == 2) return above + tilt_x * x + tilt_y * y;
      if (i % 5 == 3) {
        return above + 1e-4 * a * std::sin(2000 * b * x + 1) * std::cos(1500 * c * y) + tilt_x * x;
      }
      return above + (one(random) < 0.02 ? 1e-6 * one(random) : inf);
    });
    const Vec2<double> centre((one(random) - 0.5) * 0.8 * eye.width * 1e-4,
                              (one(random) - 0.5) * 0.8 * eye.height * 1e-4);
    const double force = std::pow(10, -13 + 14 * one(random));
    const SpringBed<double> bed(eye, rest, {.elastic_modulus = 1e5, .thickness = 0.005});
    const auto contact = bed.press_tilting(shape, force, centre);
    if (contact.equilibrium == Equilibrium::tips_over) {
      ++tipped;
      CHECK(i % 5 == 4);  // all others are under the force wherever it acts
      continue;
    }
    if (contact.equilibrium == Equilibrium::untouched) continue;
    if (contact.equilibrium == Equilibrium::too_strong) {
      ++through;
      CHECK(force > 1e-3);
      continue;
    }
    CAPTURE(i);
    CAPTURE(force);
    REQUIRE(contact.equilibrium == Equilibrium::reached);
    ++reached;
    // The springs' force and moments again, from the indentation alone.
    const double spring = bed.gel().stiffness() * bed.spring_area();
    double sum = 0, x_sum = 0, y_sum = 0;
    for (Index v = 0; v < eye.height; ++v) {
      for (Index u = 0; u < eye.width; ++u) {
        const double f = spring * contact.indentation(u, v);
        sum += f;
        x_sum += f * ((u - eye.cx) * 1e-4 - centre.x());
        y_sum += f * ((v - eye.cy) * 1e-4 - centre.y());
      }
    }
    // Places of millimetres are rounded by 1e-18 m.
    const double rounding = 1e-16 * spring * static_cast<double>(touching(contact));
    CHECK(std::abs(sum - force) <= 1e-8 * force + rounding);
    CHECK(std::hypot(x_sum, y_sum) <= (1e-8 * force + rounding) * 1e-4 * (eye.width + eye.height));
  }
  CHECK(reached > 2200);
  CHECK(tipped > 50);
  CHECK(through > 50);
}

TEST_CASE("a press into taut gel is followed and cancelled, and leaves what it was to write") {
  const auto eye = camera(61, 61, 1e-4);
  const auto ball = object(eye, [](double x, double y) { return (x * x + y * y) / 8e-3; });
  const SpringBed<double> bed(eye, rest,
                              {.elastic_modulus = 1e5, .thickness = 0.005, .tension = 30});
  const auto want = bed.press(ball, 0.2);
  double last = 0;
  int asked = 0;
  const auto follow = [&](double done) {
    CHECK(done >= last);
    CHECK(done <= 1);
    last = done;
    ++asked;
    return false;
  };
  CHECK(bed.press(ball, 0.2, follow).indentation == want.indentation);
  CHECK(asked > 10);
  const int all = asked;
  for (const int after : {0, 1, all / 2, all - 1}) {
    auto contact = bed.press(ball, 0.1);
    const auto before = contact;
    int count = 0;
    CHECK_THROWS_AS(bed.press_into(contact, ball, 0.2, [&] { return count++ == after; }),
                    Cancelled);
    CHECK(contact.indentation == before.indentation);
    CHECK(contact.touching == before.touching);
    CHECK(contact.displacement == before.displacement);
    bed.press_into(contact, ball, 0.2);
    CHECK(contact.indentation == want.indentation);
  }
  CHECK_THROWS_AS((void)bed.press_tilting(ball, 0.2, {0, 0}, [] { return true; }), Cancelled);
  const SpringBed<double> loose(eye, rest, {.elastic_modulus = 1e5, .thickness = 0.005});
  CHECK_THROWS_AS((void)loose.press_tilting(ball, 0.2, {0, 0}, [] { return true; }), Cancelled);
  last = 0;
  CHECK(loose.press_tilting(ball, 0.2, {1e-4, 0}, follow).equilibrium == Equilibrium::reached);
}

TEST_CASE("a bed of springs of another rest depth or size than the renderer's is refused") {
  const double at_rest = 0.03, pixel = at_rest / 40;
  const Camera<double> eye{40, 20, 7.5, 5.5, 16, 12};
  const SpringMembrane<double> membrane(SpringBed<double>(eye, at_rest), 0.5);
  Image<double> depth(16, 12, std::numeric_limits<double>::infinity());
  for (Index y = 4; y < 8; ++y) {
    for (Index x = 4; x < 8; ++x) depth(x, y) = 0.028;
  }
  for (const double other : {0.9 * at_rest, at_rest + 0.02 * pixel, at_rest - 0.02 * pixel}) {
    CHECK(test::contains(
        test::refusal([&] { (void)surface_depth(membrane, depth, Image<double>(16, 12, other)); }),
        "the renderer's rest depth is "));
  }
  const Image<double> same(16, 12, at_rest + 0.005 * pixel);
  CHECK(surface_depth(membrane, depth, same)(5, 5) < at_rest);
  const std::string words = "images of 8 x 8 pixels are not of the membrane's 16 x 12";
  const Image<double> small(8, 8, at_rest);
  CHECK(test::refusal([&] { (void)surface_depth(membrane, small, small); }) == words);
  const Camera<double> narrow{40, 20, 3.5, 3.5, 8, 8};
  CHECK(test::refusal([&] {
          (void)TactileRenderer(narrow, small, membrane, PhongLights<double>{});
        }) == words);
}

TEST_CASE("a force that rounding loses is not reached") {
  const Camera<double> eye{40, 40, 16, 10, 33, 21};
  Image<double> depth(33, 21, inf);
  for (Index y = 8; y < 13; ++y) std::fill_n(depth.row(y) + 12, 8, 0.0295);
  for (const double tension : {0.0, 1.0, 1e6, 1e9, 1e12, 1e15}) {
    const SpringBed<double> bed(eye, 0.03, {.tension = tension});
    for (const double force : {1e-12, 0.1, 1.0, 1e3}) {
      const auto contact = bed.press(depth, force);
      CAPTURE(tension);
      CAPTURE(force);
      CHECK(contact.residual_force == gelight::test::approx(force - contact.force));
      if (contact.equilibrium != Equilibrium::reached) continue;
      CHECK(std::abs(contact.force - force) <= 0.01 * force);
    }
    if (tension > 1) continue;
    CHECK(bed.press(depth, 0.1).equilibrium == Equilibrium::reached);
  }
}
