// Choosing a method by tolerance: say how wrong a distance may be, not how to compute it.
//
//      tolerance ---> plan ---> the cheapest method whose error is expected to be smaller
//                      |
//                      '------> and where asked for, bounds proved for every vertex
//
//      Where the mesh stands for a smooth surface it is itself wrong. Then a finer method is false
//      precision: the plan measures on the surface that was meant, or says how fine the mesh must
//      be.

#include <cmath>
#include <map>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/plan.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"

using gelight::Assurance;
using gelight::DistancePlanner;
using gelight::DistanceTruth;
using gelight::Vec2;
using gelight::Vec3;

double mean_error(const std::vector<double>& distance, const std::vector<double>& truth) {
  double sum = 0;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (truth[v] > 0) sum += std::abs(distance[v] / truth[v] - 1);
  }
  return sum / static_cast<double>(truth.size() - 1);
}

// From the first vertex of a unit sphere.
std::vector<double> great_circles(const gelight::Mesh<double>& sphere) {
  std::vector<double> distance;
  const Vec3<double> source(sphere.positions[0].data());
  for (const auto& p : sphere.positions) {
    const double chord = (Vec3<double>(p.data()) - source).norm();
    distance.push_back(2 * std::asin(std::min(1.0, chord / 2)));
  }
  return distance;
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "choosing_a_method");

  Figure figure(900, 480);
  constexpr double least_drawn = 0.001;  // in %: the exact solver's errors are all rounding
  Plot errors(figure, {100, 60, 620, 340},
              "On a fingertip: the cheapest method that is as near as asked for answers",
              {"mean error allowed, %", 0.01, 100, true},
              {"mean error that comes out, %", least_drawn, 100, true});
  figure.area(std::array{errors.on_page({0.01, 0.01}), errors.on_page({100, 100}),
                         errors.on_page({0.01, 100})},
              red, 0.1);
  figure.pen(red, 1);
  figure.text("more wrong than allowed", errors.on_page({0.15, 12}), 15);
  const std::map<std::string, std::pair<const char*, Colour>> methods{
      {"dijkstra", {"Dijkstra", orange}},
      {"virtual_source", {"virtual sources", green}},
      {"fast_marching", {"fast marching", violet}},
      {"exact", {"exact, but for rounding", blue}}};
  const auto membrane = gelight::membrane<double>();
  const auto exact = gelight::ExactSolver(membrane).distance(0);
  bool all_within = true;
  // Of each method, where its dots begin, and its expected times: nearer takes longer.
  struct Use {
    Vec2<double> at;
    double least, most;
  };
  std::map<std::string, Use> uses;
  for (double tolerance = 2e-4; tolerance < 0.5; tolerance *= std::pow(10, 0.25)) {
    const DistancePlanner planner(membrane,
                                  {.tolerance = tolerance, .assurance = Assurance::expected});
    const auto answer = planner.solve(0);
    const double error = mean_error(answer.distance, exact);
    all_within = all_within && error <= tolerance;
    const Colour colour = methods.at(answer.method).second;
    const Vec2<double> at(100 * tolerance, std::max(100 * error, least_drawn));
    errors.dots({at}, colour, 6);
    const double cost = 1000 * planner.plan().seconds;
    Use& use = uses.try_emplace(answer.method, Use{at, cost, cost}).first->second;
    use.least = std::min(use.least, cost);
    use.most = std::max(use.most, cost);
  }
  for (const auto& [method, use] : uses) {
    const auto& [name, colour] = methods.at(method);
    char cost[40];
    const bool is_one = use.most - use.least < 0.1;
    std::snprintf(cost, sizeof cost, is_one ? ", %.1f ms" : ", %.1f to %.1f ms", use.least,
                  use.most);
    errors.label({std::min(0.9 * use.at[0], 8.0), 1.9 * use.at[1]}, colour,
                 name + std::string(cost));
  }
  lesson.expect(all_within, "at every tolerance the answer is within it");

  const DistancePlanner careful(membrane, {.tolerance = 0.02, .assurance = Assurance::certified});
  const auto proved = careful.solve(0);
  lesson.expect(proved.achieved == Assurance::certified &&
                    proved.error >= mean_error(proved.distance, exact) && proved.satisfies,
                proved.reason + ", and it is");

  const auto coarse = gelight::icosphere<double>(3), fine = gelight::icosphere<double>(4);
  const gelight::PlanRequest smooth{.tolerance = 0.001, .truth = DistanceTruth::smooth};
  const DistancePlanner for_coarse(coarse, smooth), for_fine(fine, smooth);
  const double coarse_error =
      mean_error(gelight::ExactSolver(coarse).distance(0), great_circles(coarse));
  const double fine_error = mean_error(for_fine.solve(0).distance, great_circles(fine));
  const double lifted_error = mean_error(for_coarse.solve(0).distance, great_circles(coarse));
  lesson.expect(coarse_error > 0.001 && lifted_error < 0.001,
                "on a coarse sphere even exact distances are off: the plan is method " +
                    for_coarse.plan().method);
  lesson.expect(for_fine.plan().refine_to == 0 && fine_error < 0.001,
                "on a finer one " + for_fine.plan().method + " is enough");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
