// Where heat fails: needles, and beside the source; what repairs it.
//
//      ____________________      Heat crosses edges in proportion to the cotangents of the angles
//     /____---------______/      opposite them. In a needle's flat angle the cotangent is far below
//                                zero: there heat runs from cold to hot, and distance with it.
//
//     exact                 needs no repair: it unfolds triangles, whatever their angles
//     heat                  is wrong everywhere
//     heat, flipped edges   works on triangles without flat angles of the same surface
//                           (intrinsic Delaunay), and is wrong beside the source alone
//     and exact near it      starts from exact distances there

#include <cmath>
#include <cstdio>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "where_heat_fails");

  // A disc of well-shaped triangles, stretched ten times.
  std::vector<gelight::ProfilePoint<double>> rings;
  for (int i = 0; i <= 12; ++i) rings.push_back({i / 12.0, 0});
  gelight::Mesh<double> disc = gelight::revolve<double>(rings, 1 / 10.5);
  for (auto& [x, y, z] : disc.positions) x *= 10;
  const gelight::Index source = 0;

  using gelight::HeatSolver;
  struct Method {
    const char* name;
    std::vector<double> distance;
    double mean = 0, largest = 0;  // error, as a share of the true distance
  };
  std::array<Method, 4> methods{
      {{"exact", gelight::ExactSolver(disc).distance(source)},
       {"heat", HeatSolver<double>(disc, {.exact_radius = 0, .intrinsic_delaunay = false})
                    .distance(source)},
       {"heat, flipped edges", HeatSolver<double>(disc, {.exact_radius = 0}).distance(source)},
       {"and exact near the source", HeatSolver<double>(disc).distance(source)}}};
  for (Method& method : methods) {
    for (std::size_t v = 1; v < method.distance.size(); ++v) {
      const double truth = std::hypot(disc.positions[v][0], disc.positions[v][1]);
      const double error = std::abs(method.distance[v] / truth - 1);
      method.mean += error / static_cast<double>(method.distance.size() - 1);
      method.largest = std::max(method.largest, error);
    }
  }
  const auto& [exact, heat, flipped, begun] = methods;
  lesson.expect(exact.largest < 1e-12, "exact distances do not mind needles");
  lesson.expect(heat.mean > 0.3, "heat is more than 30 % wrong on average");
  lesson.expect(flipped.mean < 0.04, "with flipped edges it is less than 4 % wrong");
  lesson.expect(begun.largest < flipped.largest / 2,
                "what is left beside the source can be halved");

  Figure figure(1000, 600);
  double y = 20;
  for (const Method& method : methods) {
    const View view(disc, {20, y, 700, 120});
    view.paint_bands(figure, method.distance, 0.5, 10);
    figure.pen(white, 0.4);
    if (&method == &exact) view.draw_edges(figure);
    figure.pen(black, 1);
    figure.text_from(method.name, 745, y + 45, 17);
    std::array<char, 64> errors;
    std::snprintf(errors.data(), errors.size(), "error %.1f %%, at most %.0f %%", 100 * method.mean,
                  100 * method.largest);
    figure.text_from(errors.data(), 745, y + 72, 14);
    y += 140;
  }
  figure.text(
      "Distance from the middle of a flat disc stretched ten times. White: its triangles, needles.",
      500, 582, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
