#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/hard_meshes.hpp"

// Meshes with vertices on smooth surfaces, anywhere there, and distances on those surfaces.

namespace gelight::test {

struct SmoothCase {
  Mesh<double> mesh;
  std::vector<std::array<double, 3>> normals;
  std::vector<double> truth;  // from vertex 0, or -1 where it is not known
};

/// Mean relative error of distances where the truth is known and not zero.
inline double mean_error(const std::vector<double>& distance, const std::vector<double>& truth) {
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (!(truth[v] > 0)) continue;
    sum += std::abs(distance[v] / truth[v] - 1);
    ++count;
  }
  return sum / count;
}

/// Integral of f from 0 to `end` by Gauss' rule of five points on pieces.
template <class F>
double integral(const F& f, double end, int pieces = 200) {
  constexpr std::array<double, 5> at{0, .5384693101056831, -.5384693101056831, .9061798459386640,
                                     -.9061798459386640};
  constexpr std::array<double, 5> weight{.5688888888888889, .4786286704993665, .4786286704993665,
                                         .2369268850561891, .2369268850561891};
  const double step = end / pieces;
  double sum = 0;
  for (int i = 0; i < pieces; ++i) {
    for (std::size_t k = 0; k < 5; ++k) sum += weight[k] * f((i + .5 + at[k] / 2) * step);
  }
  return sum * step / 2;
}

/// A sphere stretched along its axis, from a pole: the arc of an ellipse. Vertices are moved by up
/// to `jitter` edges.
inline SmoothCase spheroid(int level, double height, double jitter, Random& random) {
  SmoothCase out;
  out.mesh = icosphere<double>(level);
  const double edge =
      std::sqrt(4 * std::numbers::pi / static_cast<double>(out.mesh.positions.size()) * 1.1547);
  const auto vector = [](const std::array<double, 3>& p) { return Vec3<double>(p[0], p[1], p[2]); };
  const Vec3<double> pole = vector(out.mesh.positions[0]);
  const Vec3<double> x = detail::unit_orthogonal(pole), y = cross(pole, x);
  for (std::size_t v = 0; v < out.mesh.positions.size(); ++v) {
    Vec3<double> p = vector(out.mesh.positions[v]);
    for (int i = 0; v > 0 && i < 3; ++i) p[i] += uniform(random, -jitter, jitter) * edge;
    const Vec3<double> q = Vec3<double>(p.dot(x), p.dot(y), p.dot(pole)).normalized();
    const auto speed = [&](double t) { return std::hypot(std::cos(t), height * std::sin(t)); };
    out.truth.push_back(integral(speed, std::atan2(std::hypot(q[0], q[1]), q[2])));
    out.mesh.positions[v] = {q[0], q[1], height * q[2]};
    const Vec3<double> n = Vec3<double>(q[0], q[1], q[2] / height).normalized();
    out.normals.push_back({n[0], n[1], n[2]});
  }
  return out;
}

/// The end of a geodesic on a torus, begun at its outermost circle: places round the axis and round
/// the tube, direction, and how far one begun beside it is from it.
struct TorusShot {
  double u, v, direction, spread;
};

inline TorusShot shoot_on_torus(double major, double minor, double direction, double length) {
  using State = std::array<double, 5>;
  const auto rate = [&](const State& s) {
    const double radius = major + minor * std::cos(s[1]);
    const double curvature = std::cos(s[1]) / (minor * radius);
    return State{std::sin(s[2]) / radius, std::cos(s[2]) / minor,
                 std::sin(s[1]) * std::sin(s[2]) / radius, s[4], -curvature * s[3]};
  };
  const auto moved = [](const State& s, double h, const State& by) {
    State out = s;
    for (std::size_t i = 0; i < 5; ++i) out[i] += h * by[i];
    return out;
  };
  constexpr int steps = 300;
  const double h = length / steps;
  State s{0, 0, direction, 0, 1};
  for (int i = 0; i < steps; ++i) {  // Runge and Kutta's
    const State a = rate(s), b = rate(moved(s, h / 2, a)), c = rate(moved(s, h / 2, b));
    const State d = rate(moved(s, h, c));
    for (std::size_t k = 0; k < 5; ++k) s[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
  }
  return {s[0], s[1], s[2], s[3]};
}

/// Length of the geodesic to (u, v) near a direction and length, or -1 where none was found.
inline double torus_geodesic(double major, double minor, double u, double v, double direction,
                             double length) {
  for (int i = 0; i < 20; ++i) {
    const TorusShot end = shoot_on_torus(major, minor, direction, length);
    const double du = (u - end.u) * (major + minor * std::cos(end.v)), dv = (v - end.v) * minor;
    const double along = dv * std::cos(end.direction) + du * std::sin(end.direction);
    const double across = du * std::cos(end.direction) - dv * std::sin(end.direction);
    if (std::hypot(along, across) < 1e-12) return length;
    if (std::abs(end.spread) < 0.05) return -1;
    length += along;
    direction += std::clamp(across / end.spread, -0.3, 0.3);
    if (!(length > 0 && length < 10 * major)) return -1;
  }
  return -1;
}

/// A torus of radii 1 and 0.4; places (u, v) of its vertices are moved by up to `jitter` cells.
struct TorusCase {
  Mesh<double> mesh;
  std::vector<std::array<double, 3>> normals;
  std::vector<std::array<double, 2>> places;
};

inline TorusCase jittered_torus(Index around, Index across, double jitter, Random& random) {
  TorusCase out;
  out.mesh = torus<double>(1, 0.4, around, across);
  for (Index i = 0; i < around; ++i) {
    for (Index j = 0; j < across; ++j) {
      const bool moves = i > 0 || j > 0;
      const double du = moves ? uniform(random, -jitter, jitter) : 0;
      const double dv = moves ? uniform(random, -jitter, jitter) : 0;
      const double u = 2 * std::numbers::pi * (i + du) / around;
      const double v = 2 * std::numbers::pi * (j + dv) / across;
      const double r = 1 + 0.4 * std::cos(v);
      out.mesh.positions[static_cast<std::size_t>(i * across + j)] = {
          r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)};
      out.normals.push_back({std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)});
      out.places.push_back({u, v});
    }
  }
  return out;
}

/// Distances on a torus from vertex 0 to one vertex in so many, where a geodesic beside the mesh's
/// shortest path was found well before its cut locus; -1 elsewhere.
inline std::vector<double> torus_distances(const TorusCase& c, const ExactField<double>& field,
                                           std::size_t one_in) {
  std::vector<double> truth(c.places.size(), -1);
  for (std::size_t v = 5; v < truth.size(); v += one_in) {
    const double length = field.distance(static_cast<Index>(v));
    if (length > 1.5) continue;
    const Vec3<double> leaves = field.departure(static_cast<Index>(v)).direction;
    auto [x, y] = c.places[v];
    x = std::remainder(x, 2 * std::numbers::pi);
    y = std::remainder(y, 2 * std::numbers::pi);
    if (std::abs(y) > 2) continue;
    truth[v] = torus_geodesic(1, 0.4, x, y, std::atan2(leaves[1], leaves[2]), length);
  }
  return truth;
}

}  // namespace gelight::test
