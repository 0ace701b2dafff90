// Heat and its time step: distance from the way that heat spreads.
//
//     1  put heat on the source, let it spread for a time t      |\.__      u
//     2  keep only the direction in which it falls               > > > >    X = -grad u / |grad u|
//     3  find the function with that slope                       ./'/'      div grad d = div X
//
// The shorter the time the truer the direction, down to about the square of an edge's length: heat
// that has not crossed an edge knows nothing but the mesh. Longer, it smooths the distance.

#include <cmath>
#include <vector>

#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"
#include "support/view.hpp"

using gelight::Vec2;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "heat_time");

  const auto sheet = gelight::grid<double>(48, 32, 1.5, 1);
  const gelight::Index source = 49 * 10 + 12;
  std::vector<double> truth;
  for (const auto& [x, y, z] : sheet.positions) truth.push_back(std::hypot(x - 0.375, y - 0.3125));
  // exact_radius = 0: heat alone, without the exact distances that mend it beside the source.
  const auto heat_distance = [&](double time_factor) {
    return gelight::HeatSolver<double>(sheet, {.time_factor = time_factor, .exact_radius = 0})
        .distance(source);
  };
  const auto mean_error = [&](const std::vector<double>& distance) {
    double sum = 0;
    for (std::size_t v = 0; v < truth.size(); ++v) sum += std::abs(distance[v] - truth[v]);
    return sum / static_cast<double>(truth.size());
  };

  std::vector<Vec2<double>> errors;
  Vec2<double> best(0, 10);
  for (double time = 0.001; time < 1001; time *= std::sqrt(10)) {
    errors.emplace_back(time, mean_error(heat_distance(time)));
    if (errors.back()[1] < best[1]) best = errors.back();
  }
  lesson.expect(best[0] > 0.3 && best[0] < 3.2, "the best time is about a squared edge length");
  lesson.expect(best[1] < 0.01, "then the mean error is less than 1 % of the sheet's height");
  lesson.expect(errors.front()[1] > 5 * best[1], "much less time is worse");
  lesson.expect(errors.back()[1] > 5 * best[1], "much more time is worse");

  Figure figure(1000, 560);
  double x = 15;
  for (const auto& [time, name] :
       {std::pair(0.001, "too short: t = 0.001 h²"), std::pair(1.0, "t = h²"),
        std::pair(300.0, "too long: t = 300 h²")}) {
    const View view(sheet, {x, 45, 300, 200});
    view.paint_bands(figure, heat_distance(time), 0.1, 1.4);
    figure.pen(black, 1);
    figure.text(name, x + 150, 22, 16);
    x += 335;
  }
  Plot plot(figure, {110, 310, 800, 180}, "How far off the distances are",
            {"time t of the heat flow, in squared edge lengths h²", 0.001, 1000, true},
            {"mean error", 0.001, 1, true});
  plot.curve(errors, blue, "");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
