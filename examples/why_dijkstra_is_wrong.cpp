// Why Dijkstra is wrong: a finer mesh makes its answer no better.
//
//    +---+---+---+ b      Edges run in three directions only. Towards b, between two of them, the
//    | / | / | / |        way along edges turns again and again; twice as fine it turns twice as
//    +---+---+---+        often and is as long as before:
//    | / | / | / |            sqrt(2) min(x, y) + |x - y|     for x, y > 0,
//    a---+---+---+        and not sqrt(x^2 + y^2).

#include <cmath>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec2;
using gelight::Vec3;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "why_dijkstra_is_wrong");

  // The largest error of distances from a corner, in percent of the true one, as cells get smaller.
  std::vector<Vec2<double>> dijkstra_errors, exact_errors;
  double unlike_formula = 0;
  for (const Index cells : {4, 8, 16, 32, 64, 128}) {
    const auto sheet = gelight::grid<double>(cells, cells);
    const auto along_edges = gelight::DijkstraSolver(sheet).distance(0);
    const auto exact = gelight::ExactSolver(sheet).distance(0);
    double dijkstra_error = 0, exact_error = 0;
    for (std::size_t v = 1; v < exact.size(); ++v) {
      const auto [x, y, z] = sheet.positions[v];
      const double truth = std::hypot(x, y);
      const double formula = std::sqrt(2) * std::min(x, y) + std::abs(x - y);
      unlike_formula = std::max(unlike_formula, std::abs(along_edges[v] - formula));
      dijkstra_error = std::max(dijkstra_error, 100 * std::abs(along_edges[v] / truth - 1));
      exact_error = std::max(exact_error, 100 * std::abs(exact[v] / truth - 1));
    }
    dijkstra_errors.emplace_back(cells, dijkstra_error);
    exact_errors.emplace_back(cells, exact_error);
  }
  const double at_worst = 100 * (std::sqrt(4 - 2 * std::sqrt(2)) - 1);  // half-way between edges
  lesson.expect(unlike_formula < 1e-12, "along edges it is sqrt(2) min(x, y) + |x - y|");
  lesson.expect(std::abs(dijkstra_errors.back()[1] - at_worst) < 0.01,
                "on 128 x 128 cells Dijkstra is still 8.2 % too long");
  lesson.expect(exact_errors.back()[1] < 1e-11, "the exact distance is the true one");

  Figure figure(1000, 430);
  const auto sheet = gelight::grid<double>(8, 8);
  const View view(sheet, {60, 55, 300, 300});
  view.paint_bands(figure, gelight::DijkstraSolver(sheet).distance(0), 0.125, 1.6);
  figure.pen(white, 0.6);
  view.draw_edges(figure);
  const Vec3<double> b(1, 0.5, 0), along(0.125, 0, 0), across(0.125, 0.125, 0);
  std::vector<Vec3<double>> straight{{0, 0, 0}, b}, stairs{{0, 0, 0}};
  for (int i = 0; i < 4; ++i) {
    stairs.push_back(stairs.back() + along);
    stairs.push_back(stairs.back() + across);
  }
  figure.pen(orange, 3);
  view.draw_path(figure, stairs);
  figure.text_from("along edges: 1.207, however fine", 60, 400, 14);
  figure.pen(red, 3);
  view.draw_path(figure, straight);
  figure.text_from("straight: 1.118", 60, 378, 14);
  figure.pen(black, 1);
  figure.text("Distance along edges from a corner", 210, 30, 16);

  Plot plot(figure, {470, 55, 420, 300}, "A finer mesh does not help Dijkstra",
            {"cells per side", 4, 128, true}, {"largest error, %", 0, 10});
  plot.curve(dijkstra_errors, orange, "");
  plot.label(dijkstra_errors.back(), orange, "Dijkstra");
  plot.curve(exact_errors, blue, "");
  plot.label(exact_errors.back(), blue, "exact");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
