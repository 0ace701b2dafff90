#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "gelight/mesh/shapes.hpp"

namespace gelight::bench {

/// A unit sphere on meridians and parallels, with needles about the poles where meridians are many.
inline Mesh<double> needle_sphere(Index meridians, Index parallels) {
  Mesh<double> mesh{{{0, 0, 1}, {0, 0, -1}}, {}};
  const auto vertex = [&](Index row, Index column) {
    return 2 + row * meridians + column % meridians;
  };
  for (Index row = 0; row < parallels; ++row) {
    for (Index column = 0; column < meridians; ++column) {
      const double u = std::numbers::pi * (row + 1) / (parallels + 1);
      const double v = 2 * std::numbers::pi * column / meridians;
      mesh.positions.push_back({std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u)});
      const Index a = vertex(row, column), b = vertex(row, column + 1);
      if (row == 0) mesh.faces.push_back({0, a, b});
      if (row + 1 == parallels) {
        mesh.faces.push_back({a, 1, b});
      } else {
        mesh.faces.push_back({a, a + meridians, b + meridians});
        mesh.faces.push_back({a, b + meridians, b});
      }
    }
  }
  return mesh;
}

/// A unit sphere with bumps and noise: half of the vertices are saddles.
inline Mesh<double> noisy_sphere(int level) {
  Mesh<double> mesh = icosphere<double>(level);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.1 * std::pow(0.5, level));
  for (auto& p : mesh.positions) {
    const double bumps = std::sin(6 * p[0] + 1) * std::sin(7 * p[1]) * std::sin(5 * p[2] + 2);
    for (double& x : p) x = (1 + 0.15 * bumps) * x + noise(random);
  }
  return mesh;
}

}  // namespace gelight::bench
