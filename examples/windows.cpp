// Windows and pseudo-sources: how the exact solver knows every point of an edge at once.
//
//        .-----------------      From the source s straight lines reach what s can see. Where they
//       .     c|#|d              would go behind a corner the shortest path bends: the corner c is
//      s       |#|               a pseudo-source, whose lines begin with distance |sc|; so is d.
//              |#|               A window is the part of an edge that the lines of one of them
//                                reach, and all that the solver stores of its points.

#include <cmath>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec3;
using Point = gelight::SurfacePoint<double>;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "windows");

  // A floor of 10 x 7 cells, less four of them: a wall between c = (5, 4) and d = (6, 4).
  gelight::Mesh<double> floor = gelight::grid<double>(10, 7, 10, 7);
  const auto vertex = [](Index x, Index y) { return 11 * y + x; };
  std::erase_if(floor.faces, [](const auto& face) {
    return face[0] % 11 == 5 && face[0] / 11 < 4;  // a face begins at its cell's lower left
  });
  const Index s = vertex(1, 2), c = vertex(5, 4), d = vertex(6, 4);
  const gelight::ExactSolver solver(floor);
  const gelight::Surface<double>& surface = solver.surface();
  const auto field = solver.solve(s, {.keep_windows = true});
  // The last straight line to a point: where it begins is s, c or d.
  const auto arrival = [&](const Point& p) { return field.arrivals(p).front(); };

  // Behind the line from s through c a point is reached round c, below the wall's top round d too.
  double worst = 0;
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    const Point point = gelight::edge_point<double>(surface.origin(h), surface.tip(h), 0.3);
    const Vec3<double> p = surface.position(point);
    const auto from = [&](Index v) { return (p - surface.position(v)).norm(); };
    const bool is_seen = p[0] <= 5 || p[1] > 2 + (p[0] - 1) / 2;
    const double to_c = std::hypot(4, 2);
    const double truth = is_seen ? from(s) : p[1] >= 4 ? to_c + from(c) : to_c + 1 + from(d);
    worst = std::max(worst, std::abs(field.distance(point) - truth));
  }
  lesson.expect(worst < 1e-12,
                "points of edges are as far as the lines round the corners are long");

  // The line from s through c cuts this edge in the middle: two windows.
  const Index low = vertex(8, 5), high = vertex(8, 6);
  bool as_expected = true;
  for (const double t : {0.01, 0.25, 0.49, 0.51, 0.75, 0.99}) {
    const Index expected = t < 0.5 ? c : s;
    as_expected = as_expected && arrival(gelight::edge_point<double>(low, high, t)).from ==
                                     gelight::vertex_point<double>(expected);
  }
  lesson.expect(as_expected, "the lower half of the edge is a window of c, the upper one of s");

  Figure figure(760, 560);
  const View view(floor, {30, 50, 700, 460});
  view.paint(figure, [&](const Point& p) -> Colour {
    const auto line = arrival(p);
    const Index from = line.from.element[0];
    const double light = std::fmod(line.distance, 1) < 0.5 ? 1 : 0.92;
    if (from == s) return {0.72 * light, 0.83 * light, 0.97 * light};
    if (from == c) return {0.99 * light, 0.83 * light, 0.60 * light};
    return {0.80 * light, 0.93 * light, 0.75 * light};
  });
  figure.pen(grey, 0.5);
  view.draw_edges(figure);
  const auto window = [&](Index from, const Vec3<double>& begin, const Vec3<double>& end,
                          Colour colour) {
    const std::array corners{view.on_page(surface.position(from)), view.on_page(begin),
                             view.on_page(end)};
    figure.area(corners, colour, 0.3);
    figure.pen(colour, 6);
    figure.polyline(std::span(corners).last(2));
  };
  window(s, {8, 5.5, 0}, {8, 6, 0}, blue);
  window(c, {8, 5, 0}, {8, 5.5, 0}, orange);
  figure.pen(blue, 1);
  view.draw_dot(figure, surface.position(s), 6, "s");
  figure.pen(orange, 1);
  view.draw_dot(figure, surface.position(c), 6, "c");
  figure.pen(green, 1);
  view.draw_dot(figure, surface.position(d), 6, "d");
  figure.pen(black, 1);
  figure.text("What the lines of the source s and of the pseudo-sources c and d reach", 380, 26,
              17);
  figure.text("Two windows, from s and from c, share the edge on the right.", 380, 535, 15);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
