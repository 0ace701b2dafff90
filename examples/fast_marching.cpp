// Fast marching and virtual sources: how a front gets over a triangle.
//
//             c                   A vertex c is reached by way of an edge whose ends a and b know
//            / \                  their distances already. Where does the wave come from? From the
//           /   \                 point s beneath the edge that is as far from a and b as they say.
//          a-----b                Fast marching finds s anew from two numbers at every edge; a
//           \   .                 virtual source is handed on, laid flat, from vertex to vertex.
//             s      Round a corner the numbers at a and b belong to different sources, and no s
//                    fits both: there fast marching is off, behind the corner ever after.

#include "gelight/geodesic/fast_marching.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec2;

// A floor of 3 x 2, n cells to the unit, with a slit from (1, 0) up to the corner (1, 1).
gelight::Mesh<double> floor_with_slit(Index n) {
  auto floor = gelight::grid<double>(3 * n, 2 * n, 3, 2);
  std::erase_if(floor.faces, [&](const auto& face) {  // begins at its cell's lower left
    return face[0] % (3 * n + 1) == n && face[0] / (3 * n + 1) < n;
  });
  return floor;
}

// From (0.5, 0.5): straight to what it sees; the rest is reached round the slit's corners.
double truth(double x, double y, Index n) {
  const double right = 1 + 1.0 / n, to_left = std::hypot(0.5, 0.5);
  const bool is_seen = x <= 1 || y - 0.5 >= x - 0.5;
  if (is_seen) return std::hypot(x - 0.5, y - 0.5);
  if (y >= 1) return to_left + std::hypot(x - 1, y - 1);
  return to_left + 1.0 / n + std::hypot(x - right, y - 1);
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "fast_marching");

  // How far each is off, in %: at the vertices, and where it is most, in front of the slit and
  // behind.
  struct Errors {
    std::vector<double> at_vertices;
    double in_front = 0, behind = 0;
  };
  const auto errors_of = [](const auto& solver, const gelight::Mesh<double>& mesh, Index n) {
    const std::vector<double> distance = solver.distance(n / 2 * (3 * n + 1) + n / 2);
    Errors errors;
    for (std::size_t v = 0; v < distance.size(); ++v) {
      const auto [x, y, z] = mesh.positions[v];
      const double exact = truth(x, y, n);
      const double error = exact > 0 ? 100 * std::abs(distance[v] / exact - 1) : 0;
      errors.at_vertices.push_back(error);
      double& most = x > 1 && y < x ? errors.behind : errors.in_front;
      most = std::max(most, error);
    }
    return errors;
  };
  std::vector<Vec2<double>> by_marching;
  Errors marching, virtuals;
  const auto drawn = floor_with_slit(20);
  for (const Index n : {6, 10, 20, 40, 80}) {
    const auto floor = floor_with_slit(n);
    const auto fast = errors_of(gelight::FastMarchingSolver(floor), floor, n);
    by_marching.emplace_back(n, fast.behind);
    if (n != 20) continue;
    marching = fast;
    virtuals = errors_of(gelight::VirtualSourceSolver(floor), floor, n);
  }
  lesson.expect(marching.in_front < 0.01 && virtuals.in_front < 1e-9,
                "in sight of the source both are right, to a ten-thousandth and to rounding");
  lesson.expect(marching.behind > 1,
                "behind the corner fast marching is off by a percent and more");
  lesson.expect(virtuals.behind < 0.001, "virtual sources are not, to a hundred-thousandth");
  const double order = std::log(by_marching[1][1] / by_marching[4][1]) / std::log(8.0);
  lesson.expect(order > 0.4 && order < 0.75, "cells half as wide leave more than half of that");

  Figure figure(1000, 420);
  const auto draw = [&](double x, const Errors& errors, const std::string& name) {
    const View view(drawn, {x, 60, 460, 300});
    view.paint(figure, [&](const View::Point& p) -> Colour {
      const double share = std::floor(view.interpolated(errors.at_vertices, p) / 0.25) / 10;
      return {1 - 0.25 * share, 0.97 - 0.75 * share, 0.93 - 0.85 * share};
    });
    figure.area(std::array{view.on_page({1, 0, 0}), view.on_page({1, 1, 0}),
                           view.on_page({1.05, 1, 0}), view.on_page({1.05, 0, 0})},
                black);
    figure.pen(blue, 1);
    view.draw_dot(figure, {0.5, 0.5, 0}, 7);
    figure.pen(black, 1);
    figure.text(name, x + 230, 32, 17);
  };
  draw(25, marching, "Fast marching: off behind the corner");
  draw(515, virtuals, "Virtual sources: right");
  figure.text(
      "Blue: the source. Black: a slit. Palest: right; each band is off by a quarter of a percent "
      "more.",
      500, 392, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
