// Isolines: how long a circle is tells what it encloses.
//
//      flat         ball         saddle     All points at one distance from s are a circle, an
//     ______        .---.        \     /     isoline of distance. On paper it is 2 pi r long. On a
//    /  o   \      /  o  \        \ o /      ball it is less, since the surface closes; on a saddle
//    \__s___/      \__s__/        / s \      it is more. Who cannot see a surface from outside can
//                                /     \     measure its curvature so.
//    2 pi r         less          more
//
// The exact distance of an ExactField has circles of true arcs. Distances at the vertices alone
// have polygons through the edges, which are a little shorter.

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact_isoline.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"
#include "support/view.hpp"

using gelight::Vec2;
using gelight::Vec3;
using Field = gelight::ExactField<double>;
constexpr double pi = std::numbers::pi;

// A square sheet, 3 wide, bent to height(x, y).
gelight::Mesh<double> sheet(auto&& height) {
  gelight::Mesh<double> mesh = gelight::grid<double>(48, 48, 3, 3);
  for (auto& [x, y, z] : mesh.positions) {
    x -= 1.5, y -= 1.5;
    z = height(x, y);
  }
  return mesh;
}

double length_of_circle(const Field& field, double radius) {
  double sum = 0;
  for (const auto& line : gelight::exact_isolines(field, radius)) sum += line.length();
  return sum;
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "circles_and_curvature");

  struct Shape {
    std::string name;
    gelight::Mesh<double> mesh;
    Vec3<double> source;
    double curvature;  // at the source
    Colour ink;
  };
  const std::vector<Shape> shapes{
      {"flat", sheet([](double, double) { return 0.0; }), {0, 0, 0}, 0, black},
      {"a ball", gelight::icosphere<double>(4), {0, 0, 1}, 1, red},
      {"a saddle",
       sheet([](double x, double y) { return (x * x - y * y) / 2; }),
       {0, 0, 0},
       -1,
       blue}};

  Figure figure(1000, 700);
  Plot plot(figure, {330, 390, 380, 240}, "", {"radius", 0, 1.4},
            {"length / 2 pi radius", 0.7, 1.3});
  double left = 20;
  for (const auto& [name, mesh, from, curvature, ink] : shapes) {
    const gelight::ExactSolver solver(mesh);
    const auto& surface = solver.surface();
    const Field field = solver.solve(gelight::nearest_point(surface, from), {.keep_windows = true});
    std::vector<Vec2<double>> ratios;
    for (double r = 0.05; r < 1.4; r += 0.05) {
      ratios.emplace_back(r, length_of_circle(field, r) / (2 * pi * r));
    }
    plot.curve(ratios, ink, name);

    const double small = 0.4, ratio = length_of_circle(field, small) / (2 * pi * small);
    if (curvature == 0) {
      lesson.expect(std::abs(ratio - 1) < 1e-12, "flat: a circle is 2 pi r long");
      lesson.expect(std::abs(gelight::area_within(field, 1.0) - pi) < 1e-11,
                    "and encloses pi r squared");
      double polygon = 0;
      for (const auto& line : gelight::isolines(surface, field.distances(), small)) {
        polygon += gelight::length(surface, line.points);
      }
      lesson.expect(polygon < 2 * pi * small,
                    "the polygon that the distances of the vertices tell is shorter");
    } else {
      // What lacks to 2 pi r is pi r cubed / 3 times the curvature.
      const double measured = 6 * (1 - ratio) / (small * small);
      lesson.expect(
          std::abs(measured - curvature) < 0.15,
          name + ": a small circle's length tells the curvature, " + (curvature > 0 ? "1" : "-1"));
    }
    if (curvature > 0) {
      const double r = 1.2, length = length_of_circle(field, r);
      lesson.expect(std::abs(length / (2 * pi * std::sin(r)) - 1) < 2e-3,
                    "on a ball of radius 1 a circle is 2 pi sin r long");
    }

    const View view(mesh, {left, 50, 310, 270}, 0.5, 0.8);
    view.paint_bands(
        figure, [&](const auto& p) { return field.distance(p); }, 0.2, 2);
    figure.pen(red, 2);
    view.draw_dot(figure, surface.position(gelight::nearest_point(surface, from)));
    figure.pen(black, 1);
    figure.text(name, left + 155, 24, 17);
    left += 325;
  }
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
