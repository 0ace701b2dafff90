// Transport and holonomy: carried once round the tip of a cone, an arrow comes home turned.
//
//            /\            The cone is flat but for its tip: cut open it is a disc that lacks a
//           /  \           sector. In the flat disc an arrow that is carried parallel to itself
//          / -> \          keeps its direction; but the two cut edges are one line of the cone,
//         /______\         and along it the arrow that comes home differs from the one that left
//        `--------'        by the angle of the sector that lacks: the tip's angle defect.

#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/parallel.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec2;
using gelight::Vec3;

using Point = gelight::SurfacePoint<double>;

// Straight ways from each stop to the next, and from the last to the first.
gelight::Path<double> round_trip(const gelight::ExactSolver<double>& solver,
                                 const std::vector<Point>& stops) {
  gelight::Path<double> trip;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const auto way = solver.solve(stops[i]).path(stops[(i + 1) % stops.size()]);
    trip.insert(trip.end(), way.begin(), way.end());
  }
  return trip;
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "holonomy");

  // A cone of 36 triangles round its tip, as high as its radius.
  const Index sides = 36, tip = sides;
  const std::array<gelight::ProfilePoint<double>, 2> slope{{{1, 0}, {0, 1}}};
  const auto cone = gelight::revolve<double>(slope, 2 * std::numbers::pi / sides);
  const gelight::Surface<double> surface(cone);
  const auto on_slope = [&](Index side) { return gelight::edge_point<double>(tip, side, 0.7); };
  const gelight::ExactSolver solver(cone);
  const auto around = round_trip(solver, {on_slope(0), on_slope(12), on_slope(24)});
  const auto beside =
      round_trip(solver, {on_slope(0), on_slope(5), gelight::vertex_point<double>(2)});

  // The triangles' angles at the tip sum to less than a full turn: what lacks is the angle defect.
  const double side_length = std::sqrt(2), base = 2 * std::sin(std::numbers::pi / sides);
  const double angle = 2 * std::asin(base / 2 / side_length);
  const double defect = 2 * std::numbers::pi - sides * angle;
  const gelight::ParallelTransport transport(cone);
  lesson.expect(std::abs(transport.holonomy(around) - defect) < 1e-12,
                "round the tip the arrow turns by the tip's angle defect, 106 degrees");
  lesson.expect(std::abs(transport.holonomy(beside)) < 1e-12, "beside the tip it does not turn");

  Figure figure(1000, 580);
  const View view(cone, {10, 60, 460, 440}, -1.9, 0.62);
  view.paint(figure, [](const Point&) { return Colour{0.93, 0.90, 0.80}; });
  // Cut open along the edge on which the trip begins: side k of the cone is at k times the angle.
  const auto on_flat = [&](double sides_on, double from_tip) -> Vec2<double> {
    const double turn = angle * sides_on;
    return {760 + 160 * from_tip * std::cos(turn), 290 - 160 * from_tip * std::sin(turn)};
  };
  for (Index k = 0; k < sides; ++k) {
    const std::array triangle{on_flat(0, 0), on_flat(k, side_length), on_flat(k + 1, side_length)};
    figure.area(triangle, {0.93, 0.90, 0.80});
  }
  const auto points = gelight::positions(surface, around);
  const Vec3<double> start = (points[0] - surface.position(tip)).normalized();
  figure.pen(blue, 2.5);
  view.draw_path(figure, points);
  std::vector<Vec2<double>> flat;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Stops stand twice in the trip.
    flat.push_back(
        on_flat(static_cast<double>(i - i / 13), (points[i] - surface.position(tip)).norm()));
  }
  figure.polyline(flat);
  gelight::Path<double> so_far;
  for (std::size_t i = 0; i < points.size(); ++i) {
    so_far.push_back(around[i]);
    const bool is_last = i + 1 == points.size();
    figure.pen(i == 0 ? green : is_last ? orange : red, i == 0 || is_last ? 4 : 1.6);
    view.draw_arrow(figure, points[i], 0.25 * transport.along(so_far, start), 10);
    figure.arrow(flat[i][0], flat[i][1], flat[i][0] + 40, flat[i][1], 10);
  }
  figure.pen(black, 1);
  figure.text("Round the tip of a cone", 240, 26, 17);
  figure.text("The cone cut open and laid flat", 760, 26, 17);
  figure.text("106°", 800, 325, 16);
  figure.text(
      "Parallel in the flat disc; on the cone the arrow that leaves (green) comes home turned "
      "by 106° (orange).",
      500, 560, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
