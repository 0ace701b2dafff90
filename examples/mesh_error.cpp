// The error of the mesh itself: an exact distance on a mesh is not the distance on what it stands
// for.
//
//         .--~~--.         A mesh of a ball is a polyhedron inside of it: shorter ways. Twice as
//       .'/------\'.       fine, it is four times as near, and no method for polyhedra is nearer.
//      / /        \ \      Below that line of its own error a cheaper method is as good as an exact
//      |/          \|      one; beyond it, only knowing the smooth surface helps.

#include <cmath>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"

using gelight::Vec2;
using gelight::Vec3;

// The mean of |distance / great circle - 1| from the first vertex of a unit sphere, in %.
double percent_off(const gelight::Mesh<double>& sphere, const std::vector<double>& distance) {
  const Vec3<double> source(sphere.positions[0].data());
  double sum = 0;
  for (std::size_t v = 1; v < distance.size(); ++v) {
    const Vec3<double> p(sphere.positions[v].data());
    const double truth = std::atan2(gelight::cross<double>(source, p).norm(), source.dot(p));
    sum += std::abs(distance[v] / truth - 1);
  }
  return 100 * sum / static_cast<double>(distance.size() - 1);
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "mesh_error");

  std::vector<Vec2<double>> exact, marching, smooth;  // edge / radius, % off
  for (int level = 1; level <= 5; ++level) {
    const auto sphere = gelight::icosphere<double>(level);
    const auto &a = sphere.positions[static_cast<std::size_t>(sphere.faces[0][0])],
               &b = sphere.positions[static_cast<std::size_t>(sphere.faces[0][1])];
    const double edge = (Vec3<double>(a.data()) - Vec3<double>(b.data())).norm();
    exact.emplace_back(edge, percent_off(sphere, gelight::ExactSolver(sphere).distance(0)));
    marching.emplace_back(edge,
                          percent_off(sphere, gelight::FastMarchingSolver(sphere).distance(0)));
    smooth.emplace_back(
        edge, percent_off(sphere, gelight::SmoothDistanceSolver<double>(sphere).distance(0)));
  }
  const auto order = [](const std::vector<Vec2<double>>& errors) {
    const auto &coarse = errors[1], &fine = errors.back();
    return std::log(coarse[1] / fine[1]) / std::log(coarse[0] / fine[0]);
  };
  lesson.expect(order(exact) > 1.9 && order(exact) < 2.1,
                "half the edges, a quarter of the mesh's own error");
  const auto [edge, off] = std::pair(exact.back()[0], exact.back()[1]);
  lesson.expect(std::abs(off / (100 * 0.10 * edge * edge) - 1) < 0.25,
                "it is a tenth of (edge / radius)²");
  lesson.expect(order(marching) > 0.8 && order(marching) < 1.5,
                "fast marching is ever farther above it, for its order is but about one");
  lesson.expect(smooth.back()[1] < 1e-3 * off,
                "knowing the smooth surface is a thousand times nearer");

  Figure figure(860, 520);
  Plot plot(figure, {110, 60, 560, 380}, "Exact on the mesh, and yet off: the mesh is not the ball",
            {"length of an edge, in radii", 0.03, 1, true}, {"mean error, %", 1e-8, 10, true});
  const auto draw = [&](const std::vector<Vec2<double>>& errors, Colour colour, const char* name) {
    plot.curve(errors, colour, "");
    plot.dots(errors, colour);
    plot.label(errors.front(), colour, name);
  };
  draw(marching, violet, "");
  draw(exact, black, "");
  draw(smooth, blue, "on the smooth surface");
  plot.label({0.55, 4.5}, violet, "fast marching");
  plot.label({0.55, 1}, black, "exact on the mesh");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
