// The log map: a flat map round one point, true to distance and direction from it.
//
//          p               The shortest path from s to p leaves s at some angle a in the tangent
//         /                plane there, and has some length d. The log map puts p at this angle and
//        / d               this length: it is the surface, unrolled along its shortest paths. Of a
//       /) a               sphere it is a map of old atlases, the azimuthal equidistant one.
//      s------> x          Only where paths from both sides meet must it be torn.

#include "gelight/transport/log_map.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Vec2;
using gelight::Vec3;
constexpr double pi = std::numbers::pi;

// A globe: fields of 15 degrees, paler in turn, and a hue for each sixth of the way round.
Colour on_globe(const Vec3<double>& p) {
  const double latitude = std::asin(p[2] / p.norm()), longitude = std::atan2(p[1], p[0]) + pi;
  const int row = static_cast<int>(std::floor(12 * latitude / pi));
  const int column = static_cast<int>(std::floor(12 * longitude / pi));
  constexpr std::array<Colour, 6> hues{red, orange, green, blue, violet, grey};
  const Colour& hue = hues[static_cast<std::size_t>(column / 4) % 6];
  const double ink = (row + column) % 2 == 0 ? 0.75 : 0.5;
  return {1 - ink * (1 - hue.red), 1 - ink * (1 - hue.green), 1 - ink * (1 - hue.blue)};
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "log_map");

  const auto sphere = gelight::icosphere<double>(4);
  const gelight::ExactLogMapSolver solver(sphere);
  const gelight::Surface<double>& surface = solver.surface();
  const auto source = gelight::nearest_vertex<double>(surface, {0.3, -0.7, 0.65});
  const auto map = solver.solve(source);
  const auto basis = map.tangent_basis();
  const Vec3<double>&x = basis[0], &y = basis[1];
  const Vec3<double>& s = surface.position(source);

  // On the sphere the path to p is the great circle: its plane holds s and p.
  gelight::Mesh<double> flat;
  double worst_length = 0, sum_of_errors = 0, near = 0;
  for (gelight::Index v = 0; v < surface.vertex_count(); ++v) {
    const Vec2<double> mapped = map(v);
    const Vec3<double>& p = surface.position(v);
    const double length = std::acos(std::clamp(p.dot(s), -1.0, 1.0));
    const Vec2<double> truth = length * Vec2<double>(p.dot(x), p.dot(y)).stableNormalized();
    flat.positions.push_back({mapped[0], mapped[1], 0});
    worst_length = std::max(worst_length, std::abs(mapped.norm() - map.field().distance(v)));
    if (length > pi / 2) continue;
    sum_of_errors += (mapped - truth).norm();
    near += 1;
  }
  lesson.expect(worst_length < 1e-12, "points lie as far from the middle as they are");
  lesson.expect(
      sum_of_errors / near < 0.005,
      "of this half of the sphere it is the azimuthal equidistant map, to half a percent");

  // Where paths from both sides meet, opposite the source, the map is torn.
  for (const auto& face : sphere.faces) {
    const bool is_torn = std::any_of(
        face.begin(), face.end(), [&](gelight::Index v) { return map.field().distance(v) > 2.95; });
    if (!is_torn) flat.faces.push_back(face);
  }

  Figure figure(1000, 560);
  const View globe(sphere, {20, 60, 430, 430}, 0, 1.1);
  globe.paint(figure, [&](const auto& p) { return on_globe(surface.position(p)); });
  const double north = std::atan2(y[2], x[2]);  // in the tangent plane; up on the page
  const View chart(flat, {530, 60, 430, 430}, pi / 2 - north);
  chart.paint(figure, [&](auto p) {
    Vec3<double> on_sphere = Vec3<double>::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      on_sphere += p.weights[k] * surface.position(chart.surface().face(p.element[0])[k]);
    }
    return on_globe(on_sphere);
  });
  figure.pen(black, 1.5);
  // Paths from the source, and what is equally far from it.
  const auto ring = [&](double length, double angle) {
    const Vec3<double> direction = std::cos(angle) * x + std::sin(angle) * y;
    return Vec3<double>(std::cos(length) * s + std::sin(length) * direction);
  };
  for (int k = 0; k < 12; ++k) {
    std::vector<Vec3<double>> on_sphere, on_chart;
    for (double r = 0; r < 2.9; r += 0.05) {
      on_sphere.push_back(ring(r, k * pi / 6));
      on_chart.push_back({r * std::cos(k * pi / 6), r * std::sin(k * pi / 6), 0});
    }
    globe.draw_path(figure, on_sphere);
    chart.draw_path(figure, on_chart);
  }
  figure.text("A globe, and shortest paths from a point", 235, 28, 17);
  figure.text("Its log map at that point", 745, 28, 17);
  figure.text(
      "Straight lines from the middle of the map are the shortest paths, as long as they are.", 500,
      535, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
