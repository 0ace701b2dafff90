#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <ctime>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/bounds/bound_finder.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/plan_costs.hpp"
#include "gelight/geodesic/planning/measured_costs.hpp"
#include "gelight/geodesic/planning/path_error.hpp"
#include "gelight/geodesic/planning/target_search.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// Times what DistancePlanner chooses from on a rough ball, at two sizes.
template <std::floating_point Real>
class CostMeasurement {
 public:
  explicit CostMeasurement(CancelHook cancelled) : cancelled_(std::move(cancelled)) {}

  [[nodiscard]] PlanCosts all() const {
    PlanCosts costs = measured_costs;  // for the bytes
    fill(costs.dijkstra, 0, [](const auto& surface) { return DijkstraSolver<Real>(surface); });
    fill(costs.virtual_source, 0.1,
         [](const auto& surface) { return VirtualSourceSolver<Real>(surface); });
    fill(costs.fast_marching, 0.2,
         [](const auto& surface) { return FastMarchingSolver<Real>(surface); });
    fill(costs.exact, 0.3, [](const auto& surface) { return ExactSolver<Real>(surface); });
    fill_check(costs.certificate, 0.6, [](const Surface<Real>& surface, const Answer& answer) {
      const PlanarFaces<Real> faces(surface);
      const BoundFinder<Real> finder(surface, faces);
      Array<Real> ways(answer.ways.size());
      std::copy(answer.ways.begin(), answer.ways.end(), ways.begin());
      return finder.lower(answer.from, ways)[0] + finder.upper(answer.from)[0];
    });
    fill_check(costs.paths, 0.8, [](const Surface<Real>& surface, const Answer& answer) {
      PathError<Real> error(surface, answer.from, answer.ways, answer.targets);
      error.trace(64);
      return error.at_most(0);
    });
    cancelled_.check(0.9, "measuring what methods cost");
    costs.sample_share = sample_seconds() / costs.exact.seconds(small_.vertex_count(), 1);
    return costs;
  }

 private:
  struct Answer {
    Sources from;
    std::vector<Real> ways;
    std::vector<Index> targets;  // all but the source
  };

  static constexpr Index times = 5;

  static Surface<Real> rough_ball(int level) {
    auto mesh = icosphere<Real>(level);
    const Real bump = Real{0.05} / static_cast<Real>(1 << level);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      // Equidistributed heights: noise that is the same everywhere.
      const Real noise = std::fmod(static_cast<Real>(v) * Real{0.6180339887498949}, Real{1});
      for (Real& x : mesh.positions[v]) x *= 1 + bump * noise;
    }
    return Surface<Real>(mesh);
  }

  // The least processor time of some calls with another source each, so that what else the
  // machine does is not in it.
  static double least_seconds(const Surface<Real>& surface, auto&& work) {
    double least = unreachable<double>;
    for (Index i = 0; i < times; ++i) {
      const std::clock_t start = std::clock();
      work((surface.vertex_count() / times) * i + i);
      least = std::min(least, double(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return std::max(least, 1e-6);
  }

  void fill(MethodCost& cost, double done, auto&& make) const {
    cancelled_.check(done, "measuring what methods cost");
    const double vertices = small_.vertex_count(), more = large_.vertex_count();
    cost.setup_ns = 1e9 / vertices * least_seconds(small_, [&](Index) { keep(make(small_)); });
    const auto small = make(small_), large = make(large_);
    set_query(cost, least_seconds(small_, [&](Index v) { keep(small.distance(v)); }) / vertices,
              least_seconds(large_, [&](Index v) { keep(large.distance(v)); }) / more);
  }

  void fill_check(MethodCost& cost, double done, auto&& check) const {
    cancelled_.check(done, "measuring what checks cost");
    const auto a_vertex = [&](const Surface<Real>& surface) {
      const Answer answer = marched(surface);
      return least_seconds(surface, [&](Index) { keep(check(surface, answer)); }) /
             surface.vertex_count();
    };
    cost.setup_ns = 0;
    set_query(cost, a_vertex(small_), a_vertex(large_));
  }

  void set_query(MethodCost& cost, double small, double large) const {
    const double ratio = double(large_.vertex_count()) / small_.vertex_count();
    cost.growth = std::log(large / small) / std::log(ratio);
    cost.query_ns = 1e9 * small * std::pow(1e4 / small_.vertex_count(), cost.growth);
  }

  [[nodiscard]] double sample_seconds() const {
    const PlanarFaces<Real> faces(small_);
    const Answer answer = marched(small_);
    const TargetSearch<Real> search(small_, faces, answer.from, answer.ways);
    return least_seconds(small_, [&](Index v) {
      const Index target = v == 0 ? 1 : v;
      keep(search.exact(target, answer.ways[static_cast<std::size_t>(target)], Real{0.04}));
    });
  }

  static Answer marched(const Surface<Real>& surface) {
    Answer answer{{{vertex_point<Real>(0)}}, FastMarchingSolver<Real>(surface).distance(0), {}};
    for (Index v = 1; v < surface.vertex_count(); ++v) answer.targets.push_back(v);
    return answer;
  }

  // So that nothing is left out whose result nobody asks for.
  static void keep(const auto& result) {
    const volatile auto* const there = reinterpret_cast<const volatile char*>(&result);
    (void)*there;
  }

  CancelHook cancelled_;
  Surface<Real> small_ = rough_ball(5), large_ = rough_ball(6);
};

}  // namespace gelight::detail
