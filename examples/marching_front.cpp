// The front as it marches: one frame after the other, by any two solvers.
//
//        . ' ' .  |         All points at one distance from the source are a front; as the distance
//       '   s   ' |  ..     grows it marches outwards, a circle on flat ground, and turns round the
//        . _ _ .  |.'       end of a wall into its shadow. Dijkstra's front keeps to the edges of
//                 '         the mesh: it is a polygon, however fine the mesh, and comes late.
//
// marching_front FOLDER [SOLVER SOLVER]: of dijkstra, fast_marching, virtual_source, exact and
// heat.

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/animation.hpp"
#include "support/lesson.hpp"
#include "support/scale.hpp"
#include "support/view.hpp"

using gelight::Index;
using Distances = std::vector<double>;

template <class Solver>
Distances from_source(const gelight::Mesh<double>& mesh, Index source) {
  return Solver(mesh).distance(source);
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "marching_front", "[FOLDER [LEFT RIGHT]]", 3);
  const std::map<std::string, std::function<Distances(const gelight::Mesh<double>&, Index)>>
      solvers{{"dijkstra", from_source<gelight::DijkstraSolver<double>>},
              {"fast_marching", from_source<gelight::FastMarchingSolver<double>>},
              {"virtual_source", from_source<gelight::VirtualSourceSolver<double>>},
              {"exact", from_source<gelight::ExactSolver<double>>},
              {"heat", from_source<gelight::HeatSolver<double>>}};
  if (count == 3) {
    throw std::runtime_error(
        "usage: marching_front [FOLDER [LEFT RIGHT]], each of dijkstra, fast_marching, "
        "virtual_source, exact, heat");
  }
  const std::string left = count > 3 ? arguments[2] : "dijkstra";
  const std::string right = count > 3 ? arguments[3] : "exact";
  if (!solvers.contains(left) || !solvers.contains(right)) {
    std::fprintf(stderr, "There is no solver %s or %s.\n", left.c_str(), right.c_str());
    return 2;
  }

  // A floor of 3 x 2 with a wall up from the middle of its lower side; the source is (0.75, 0.75).
  const Index n = 24;
  auto floor = gelight::grid<double>(3 * n, 2 * n, 3, 2);
  std::erase_if(floor.faces, [&](const auto& face) {
    return face[0] % (3 * n + 1) == 3 * n / 2 && face[0] / (3 * n + 1) < 5 * n / 4;
  });
  const Index source = 3 * n / 4 * (3 * n + 1) + 3 * n / 4;
  const Distances by_left = solvers.at(left)(floor, source),
                  by_right = solvers.at(right)(floor, source);

  // Before it meets a side the front of true distance is a circle. Along edges of one cell to the
  // right, upwards and the diagonal between, the farthest points are those of a hexagon.
  const gelight::Surface<double> surface(floor);
  const double reach = 0.7;
  for (const auto& [name, distance] : {std::pair(left, by_left), std::pair(right, by_right)}) {
    const bool is_hexagon = name == "dijkstra";
    const double expected = is_hexagon ? 1 + std::sqrt(2.0) : std::numbers::pi;
    const double ratio = gelight::area_below(surface, distance, reach) / (reach * reach);
    std::printf("%s: the front encloses %.3f times its squared distance\n", name.c_str(), ratio);
    lesson.expect(std::abs(ratio / expected - 1) < (name == "heat" ? 0.1 : 0.01),
                  name + (is_hexagon ? ": a hexagon, 1 + sqrt 2" : ": a circle, pi"));
  }

  Animation film(760, 330, 60);
  for (int frame = 0; frame <= 40; ++frame) {
    const double time = 0.075 * std::min(frame, 36);  // at rest for the last
    Figure figure(760, 330);
    double x = 10;
    for (const auto& [name, distance] : {std::pair(left, by_left), std::pair(right, by_right)}) {
      const Distances& reached = distance;  // clang 14 lets no lambda have it by its other name
      const View view(floor, {x, 50, 365, 244});
      view.paint(figure, [&](const View::Point& p) -> Colour {
        const double d = view.interpolated(reached, p);
        if (d > time) return {0.93, 0.93, 0.93};
        if (d > time - 0.03) return red;
        return band_colour(1 - std::floor(d / 0.3) * 0.3 / 3);
      });
      figure.pen(black, 1);
      view.draw_dot(figure, {0.75, 0.75, 0}, 4);
      figure.text(name, x + 182, 26, 17);
      x += 375;
    }
    char words[48];
    std::snprintf(words, sizeof words, "distance %.2f", time);
    figure.text(words, 380, 314, 14);
    film.add(figure.pixels(), 90);
    if (frame == 20) figure.save(lesson.picture());
  }
  const std::string path = lesson.picture().substr(0, lesson.picture().size() - 3) + "webp";
  film.save(path);
  std::printf("Animation: %s\n", path.c_str());
  return lesson.result();
} catch (...) {
  return told();
}
