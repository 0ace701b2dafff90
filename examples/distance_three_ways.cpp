// Distance three ways: through space, along the edges of a mesh, over its surface.
//
//      .--.                  through space    a straight line that leaves the sheet
//     /    '   a             along edges      Dijkstra: the sheet, but only on its edges
//    b      \  |             over the surface the shortest path on the sheet
//            '-'
//
// The sheet is bent but not stretched. Rolled flat again, the shortest path on it is a straight
// line, so that we know how long it must be.

#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "distance_three_ways");

  // A flat sheet of unit cells, bent into an S whose arcs have a radius of one.
  const Index columns = 60, rows = 20;
  const double turn = 3 * std::numbers::pi / columns;  // of the sheet in a cell
  const double cell = 2 * std::sin(turn / 2);          // so that no edge changes its length
  gelight::Mesh<double> sheet = gelight::grid<double>(columns, rows, columns, rows * cell);
  const std::vector<std::array<double, 3>> flat = sheet.positions;
  for (auto& [x, y, z] : sheet.positions) {
    const double angle = turn * (x - columns / 2);
    x = std::sin(angle);
    z = angle < 0 ? 1 - std::cos(angle) : std::cos(angle) - 1;
  }

  const gelight::Surface<double> surface(sheet);
  const Index source = rows / 2 * (columns + 1);  // in the middle of the upper end
  const auto along_edges = gelight::DijkstraSolver(sheet).distance(source);
  const auto over_surface = gelight::ExactSolver(sheet).distance(source);
  std::vector<double> through_space;
  double worst = 0;
  bool in_order = true;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    through_space.push_back((surface.position(v) - surface.position(source)).norm());
    const auto &from = flat[static_cast<std::size_t>(source)], &to = flat[i];
    const double truth = std::hypot(cell * (to[0] - from[0]), to[1] - from[1]);
    worst = std::max(worst, std::abs(over_surface[i] - truth));
    const double slack = 1e-12;
    in_order = in_order && through_space[i] <= over_surface[i] + slack &&
               over_surface[i] <= along_edges[i] + slack;
  }
  lesson.expect(worst < 1e-12, "over the surface is as far as on the sheet rolled flat");
  lesson.expect(in_order, "through space <= over the surface <= along edges, at every vertex");

  Figure figure(990, 430);
  const double far = columns * cell;
  const std::pair<const char*, const std::vector<double>*> ways[] = {
      {"through space", &through_space},
      {"along edges", &along_edges},
      {"over the surface", &over_surface}};
  double x = 15;
  for (const auto& [name, distance] : ways) {
    const View view(sheet, {x, 50, 300, 340}, -0.4, 1.2);
    view.paint_bands(figure, *distance, 0.5, far);
    figure.pen(red, 1);
    view.draw_dot(figure, surface.position(source), 6);
    figure.pen(black, 1);
    figure.text(name, x + 150, 24, 18);
    x += 330;
  }
  figure.text("From the red dot. A new colour every half radius of the bend.", 495, 412, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
