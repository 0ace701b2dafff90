// A layer around a rigid ball, solved exactly by Legendre series, against ElasticLayer in the
// tangent plane: depth along the normal, places by arc length.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "gelight/membrane/layer.hpp"
#include "support/approx.hpp"
#include "support/dense.hpp"

using namespace gelight;

namespace {

constexpr double pi = std::numbers::pi;

// A layer of unit shear modulus on a ball of radius R - h.
struct BallLayer {
  double radius, thickness, nu;
};

// Radial and tangential displacement, and the tractions on a sphere, of one of the solutions
//     r^m: u = grad phi, and u = r^2 grad phi + a r phi, with phi = (r / scale)^m P_n
// of Navier's equations (Love, A Treatise on the Mathematical Theory of Elasticity, 1927, chapter
// XI); sideways components are those of the derivative of P_n by the angle.
struct Mode {
  double out, sideways, pull, shear;
};

Mode mode(double m, bool is_second, double r, double scale, double nu) {
  const double power = std::pow(r / scale, m);
  if (!is_second) {
    const double u = m * power / r, v = power / r;
    const double du = u * (m - 1) / r, dv = v * (m - 1) / r;
    return {u, v, 2 * du, dv - v / r + u / r};
  }
  const double a = -2 * (3 * m + 1 - 2 * nu * (2 * m + 1)) / (m + 5 - 4 * nu);
  const double u = (m + a) * power * r, v = power * r;
  const double du = u * (m + 1) / r, dv = v * (m + 1) / r;
  const double swelling = (2 * m + a * (m + 3)) * power;
  return {u, v, 2 * nu / (1 - 2 * nu) * swelling + 2 * du, dv - v / r + u / r};
}

// How far the surface sinks under a pressure P_n(cos angle).
double response(const BallLayer& layer, int n) {
  const double R = layer.radius, base = R - layer.thickness, nu = layer.nu;
  if (n == 0) {
    // u = A r + B / r^2
    const double stiff = 2 * (1 + nu) / (1 - 2 * nu), ratio = std::pow(base / R, 3);
    return R * (1 - ratio) / (stiff + 4 * ratio);
  }
  Eigen::Matrix4d equations;
  Eigen::Vector4d surface;
  int column = 0;
  for (const double m : {n + 0.0, -n - 1.0}) {
    const double scale = m > 0 ? R : base;
    for (const bool is_second : {false, true}) {
      const Mode at_base = mode(m, is_second, base, scale, nu);
      const Mode at_top = mode(m, is_second, R, scale, nu);
      equations.col(column) << at_base.out, at_base.sideways, at_top.pull, at_top.shear;
      surface[column++] = at_top.out;
    }
  }
  // Columns and rows differ by many orders.
  const Eigen::Vector4d size = equations.colwise().norm();
  equations = equations * size.cwiseInverse().asDiagonal();
  const Eigen::Vector4d amount =
      by_elimination<double>(equations, Eigen::Vector4d(0, 0, -1, 0)).cwiseQuotient(size);
  return -surface.dot(amount);
}

std::vector<double> legendre(int degree, double x) {
  std::vector<double> p{1, x};
  for (int n = 1; n <= degree; ++n) {
    p.push_back(((2 * n + 1) * x * p[static_cast<std::size_t>(n)] -
                 n * p[static_cast<std::size_t>(n) - 1]) /
                (n + 1));
  }
  return p;
}

// The layer's contact with a ball that is pressed in from outside.
struct BallContact {
  std::vector<double> arc, sunk;  // of rings
  double radius = 0, force = 0;
};

// How far a ball of a radius, pressed in by `press`, stands in the layer's rest, along the normal.
double overlap(double R, double ball, double press, double angle) {
  const double far = R + ball - press, side = far * std::sin(angle);
  if (std::abs(side) > ball || std::cos(angle) <= 0) {
    return -std::numeric_limits<double>::infinity();
  }
  return R - (far * std::cos(angle) - std::sqrt(ball * ball - side * side));
}

// How far rings sink under pressures on others, of equal width along the arc.
Eigen::MatrixXd ring_response(const BallLayer& layer, double ring, int count) {
  constexpr int degree = 700;
  const double step = ring / layer.radius;
  std::vector<double> by_degree;
  for (int n = 0; n <= degree; ++n) by_degree.push_back(response(layer, n));
  std::vector<std::vector<double>> middle, edge;
  for (int i = 0; i <= count; ++i) {
    edge.push_back(legendre(degree + 1, std::cos(i * step)));
    middle.push_back(legendre(degree, std::cos((i + 0.5) * step)));
  }
  Eigen::MatrixXd sinks(count, count);
  for (int j = 0; j < count; ++j) {
    const auto &inner = edge[static_cast<std::size_t>(j)],
               &outer = edge[static_cast<std::size_t>(j) + 1];
    std::vector<double> share(degree + 1);
    for (std::size_t n = 0; n <= degree; ++n) {
      const double in = inner[n + 1] - (n > 0 ? inner[n - 1] : 1);
      const double out = outer[n + 1] - (n > 0 ? outer[n - 1] : 1);
      share[n] = by_degree[n] * (in - out) / 2;
    }
    for (int i = 0; i < count; ++i) {
      double sum = 0;
      for (std::size_t n = 0; n <= degree; ++n)
        sum += share[n] * middle[static_cast<std::size_t>(i)][n];
      sinks(i, j) = sum;
    }
  }
  return sinks;
}

BallContact touch(const BallLayer& layer, const Eigen::MatrixXd& sinks, double ball, double press,
                  double ring) {
  const double step = ring / layer.radius;
  const auto count = static_cast<int>(sinks.rows());
  // Rings that bear, until none pulls and none is penetrated.
  Eigen::VectorXd wanted(count), pressure = Eigen::VectorXd::Zero(count);
  std::vector<char> bears(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    wanted[i] = overlap(layer.radius, ball, press, (i + 0.5) * step);
    bears[static_cast<std::size_t>(i)] = wanted[i] > 0;
  }
  for (int round = 0;; ++round) {
    REQUIRE(round < 100);
    std::vector<int> touching;
    for (int i = 0; i < count; ++i) {
      if (bears[static_cast<std::size_t>(i)]) touching.push_back(i);
    }
    const auto size = static_cast<Eigen::Index>(touching.size());
    Eigen::MatrixXd part(size, size);
    Eigen::VectorXd sought(size);
    for (Eigen::Index a = 0; a < size; ++a) {
      sought[a] = wanted[touching[static_cast<std::size_t>(a)]];
      for (Eigen::Index b = 0; b < size; ++b) {
        part(a, b) =
            sinks(touching[static_cast<std::size_t>(a)], touching[static_cast<std::size_t>(b)]);
      }
    }
    const Eigen::VectorXd solved = by_elimination<double>(part, sought);
    pressure.setZero();
    for (Eigen::Index a = 0; a < size; ++a)
      pressure[touching[static_cast<std::size_t>(a)]] = solved[a];
    const Eigen::VectorXd down = sinks * pressure;
    bool is_done = true;
    for (int i = 0; i < count; ++i) {
      char& here = bears[static_cast<std::size_t>(i)];
      const bool next = here ? pressure[i] > 0 : wanted[i] > down[i] + 1e-9 * press;
      is_done = is_done && next == static_cast<bool>(here);
      here = next;
    }
    if (!is_done) continue;
    BallContact contact;
    const double R = layer.radius;
    for (int i = 0; i < count; ++i) {
      contact.arc.push_back((i + 0.5) * ring);
      contact.sunk.push_back(down[i]);
      const double from = std::cos(i * step), to = std::cos((i + 1) * step);
      contact.force += pressure[i] * pi * R * R * (from * from - to * to);
      if (pressure[i] > 0) contact.radius = (i + 1) * ring;
    }
    return contact;
  }
}

}  // namespace

TEST_CASE("on a huge ball the series is the flat layer's") {
  // Hannah's response of a flat layer to a pressure of wave number k (1951,
  // doi:10.1093/qjmam/4.1.94)
  for (const double nu : {0.0, 0.3, 0.48}) {
    for (const double c : {0.5, 1.0, 3.0}) {
      const double h = 1, R = 1000, k = c / h;
      const double cosh = std::cosh(c), sinh = std::sinh(c);
      const double flat = (1 - nu) / k * ((3 - 4 * nu) * sinh * cosh - c) /
                          ((3 - 4 * nu) * cosh * cosh + (1 - 2 * nu) * (1 - 2 * nu) + c * c);
      const int n = static_cast<int>(std::lround(k * R));
      CHECK(response({R, h, nu}, n) == gelight::test::approx(flat).epsilon(0.005));
    }
  }
}

TEST_CASE("in the tangent plane a layer on a ball of 11.5 mm is nearly flat, up to a few mm") {
  constexpr double mm = 1e-3, rest = 0.03, pitch = 1.2e-4, R = 11.5 * mm;
  const Camera<double> eye{rest / pitch, rest / pitch, 80, 80, 161, 161};
  for (const double nu : {0.3, 0.48}) {
    for (const double thickness : {2 * mm, 4 * mm}) {
      const Eigen::MatrixXd sinks = ring_response({R, thickness, nu}, pitch, 78);
      for (const double press : {0.2 * mm, 0.7 * mm, 1.5 * mm}) {
        const double ball = 20 * mm;
        const BallContact exact = touch({R, thickness, nu}, sinks, ball, press, pitch);
        Image<double> depth(161, 161);
        for (Index y = 0; y < 161; ++y) {
          for (Index x = 0; x < 161; ++x) {
            depth(x, y) = rest - overlap(R, ball, press, pitch * std::hypot(x - 80, y - 80) / R);
          }
        }
        const Gel gel{2 * (1 + nu), nu, thickness};  // of unit shear modulus
        const auto flat = ElasticLayer(eye, rest, gel, {.sideways = false}).press(depth);
        CHECK(flat.bend == 0);
        double worst = 0;
        for (std::size_t i = 0; i < 78; ++i) {
          const auto x = static_cast<Index>(80 + i);
          const double here = 0.5 * (flat.indentation(x, 80) + flat.indentation(x + 1, 80));
          worst = std::max(worst, std::abs(here - exact.sunk[i]) / press);
        }
        const double more = -flat.force.z() / exact.force - 1;
        MESSAGE("nu ", nu, ", thickness ", thickness / mm, " mm, contact radius ",
                exact.radius / mm, " mm: ", 100 * worst, " % of the press off, force ", 100 * more,
                " %");
        CHECK(worst < 0.05);
        CHECK(more > 0);
        CHECK(more < (exact.radius < 3 * mm ? 0.25 : 0.4));
      }
    }
  }
}

TEST_CASE("a contact on a bent rest tells how far that is bent, and whether too far") {
  constexpr double mm = 1e-3, R = 11.5 * mm, far = 30 * mm;
  // A ball's inner side, the camera on its axis.
  const Camera<double> eye{300, 300, 70.3, 59.8, 141, 121};
  const auto shell = [&](double radius) {
    Image<double> depth(141, 121);
    for (Index y = 0; y < 121; ++y) {
      for (Index x = 0; x < 141; ++x) {
        // z ray is at a distance `radius` from (0, 0, far - R).
        const auto ray = eye.ray(x, y);
        const double a = ray.squaredNorm(), b = far - R;
        const double inside = b * b - a * (b * b - radius * radius);
        depth(x, y) =
            inside > 0 ? (b + std::sqrt(inside)) / a : std::numeric_limits<double>::quiet_NaN();
      }
    }
    return depth;
  };
  const Image<double> rest = shell(R);
  for (const double touched : {2 * mm, 4 * mm, 5.5 * mm}) {
    // Pressed in evenly, within so much of the axis along the arc.
    Image<double> depth(141, 121, std::numeric_limits<double>::infinity());
    for (Index y = 0; y < 121; ++y) {
      for (Index x = 0; x < 141; ++x) {
        const Vec3<double> point = eye.unproject(x, y, rest(x, y));
        const double angle = std::atan2(std::hypot(point.x(), point.y()), point.z() - far + R);
        if (R * angle < touched) depth(x, y) = rest(x, y) - 0.1 * mm;
      }
    }
    const ElasticLayer layer(eye, rest, {1e5, 0.3, 2 * mm}, {.sideways = false});
    const auto contact = layer.press(depth);
    CHECK(contact.bend == gelight::test::approx(touched / R).epsilon(0.05));
    CHECK(contact.is_bent_too_far == (touched > 5 * mm));
  }
}
