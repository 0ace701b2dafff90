// The cut locus: where two shortest paths meet.
//
//        ________          From s run shortest paths in all directions. On the far side of a
//      /    s     \        cylinder those that went round the left meet those that went round the
//     |  <--+-->   |       right: there are two shortest ways, and none goes on to be the shortest.
//     |            |       There distance has a crease, so that it has no direction, a light field
//      \ ___||___ /        jumps, and a log map is torn. All such points are the cut locus.
//           ||
//        cut locus

#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/scale.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec3;
using Point = gelight::SurfacePoint<double>;
using Field = gelight::ExactField<double>;

// The sine of half the angle between the first two ways to arrive; 0 where there is but one.
double crease(const Field& field, const Point& point, double tolerance) {
  const auto ways = field.arrivals(point, tolerance);
  double most = 0;
  for (const auto& way : ways) {
    most = std::max(most, (way.direction - ways.front().direction).norm() / 2);
  }
  return most;
}

// A pipe of radius 1 along z, of flat sides: laid flat, it is a sheet as wide as it is round.
gelight::Mesh<double> pipe_of(Index sides, double half_length) {
  gelight::Mesh<double> pipe = gelight::grid<double>(sides, 8, sides, 2);
  for (auto& [x, y, z] : pipe.positions) {
    const double angle = 2 * std::numbers::pi * std::round(x) / sides;
    z = (y - 1) * half_length, x = std::cos(angle), y = std::sin(angle);
  }
  for (auto& face : pipe.faces) {  // the last column of vertices is the first
    for (Index& v : face) v = v % (sides + 1) == sides ? v - sides : v;
  }
  return pipe;
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "cut_locus");

  const Index sides = 48;
  const auto pipe = pipe_of(sides, 1.2);
  const gelight::ExactSolver pipe_solver(pipe);
  const Field on_pipe = pipe_solver.solve(4 * (sides + 1), {.keep_windows = true});  // (1, 0, 0)
  const double half_round = sides * std::sin(std::numbers::pi / sides);
  double off = 0;
  bool are_two = true, are_mirrored = true;
  for (Index row = 0; row <= 8; ++row) {
    const auto ways = on_pipe.arrivals(row * (sides + 1) + sides / 2);
    off = std::max(off, std::abs(ways.front().distance - std::hypot(half_round, 0.3 * (row - 4))));
    are_two = are_two && ways.size() == 2;
    are_mirrored =
        are_mirrored && std::abs(ways.front().direction[1] + ways.back().direction[1]) < 1e-9;
  }
  lesson.expect(off < 1e-12,
                "opposite of the source it is half round the pipe, as on a flat sheet");
  lesson.expect(are_two && are_mirrored, "two ways lead there, one the mirror image of the other");
  lesson.expect(on_pipe.arrivals(4 * (sides + 1) + sides / 2 - 1).size() == 1,
                "beside it there is but one");

  // An egg's: three different axes. On a ball it would be the one point opposite.
  auto egg = gelight::icosphere<double>(4);
  for (auto& [x, y, z] : egg.positions) x *= 1.5, z *= 0.7;
  const gelight::ExactSolver egg_solver(egg);
  const Field on_egg = egg_solver.solve(
      gelight::nearest_point<double>(egg_solver.surface(), {0, 1, 0}), {.keep_windows = true});

  Figure figure(1000, 520);
  const auto draw = [&](const View& view, const Field& field, double farthest) {
    view.paint(figure, [&](const Point& p) -> Colour {
      const double d = field.distance(p);
      if (d > 0.7 * farthest && crease(field, p, 0.004) > 0.3) return red;
      return band_colour(std::floor(12 * d / farthest) / 12);
    });
  };
  draw(View(pipe, {40, 70, 400, 380}, std::numbers::pi / 2, 1.05), on_pipe, 3.5);
  draw(View(egg, {500, 70, 470, 380}, 0, 1.3), on_egg, 3);
  figure.pen(black, 1);
  figure.text("Behind a pipe: a line", 240, 32, 17);
  figure.text("Behind an egg: an arc", 735, 32, 17);
  figure.text(
      "The source is on the far side. Red: two shortest ways meet. Bands: distance from the "
      "source.",
      500, 490, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
