#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/geodesic/certify.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "stress/kept_meshes.hpp"
#include "stress/stress.hpp"

// Certified bounds on every mesh of the catalogue: between them lies the exact solver's distance,
// and the true one where it is known.

using namespace gelight;

namespace {

// Rounding of the numbers compared with, as a share: bounds that allow for their own need none.
constexpr double rounding = 1e-14;

// The exact solver's own rounding grows on needles; the catalogue states by how much.
void check(const DistanceBounds<double>& bounds, const std::vector<double>& between, double slack) {
  for (std::size_t v = 0; v < between.size(); ++v) {
    if (std::isnan(between[v])) continue;  // not known
    CAPTURE(v);
    const double room = std::isfinite(between[v]) ? slack * rounding * std::abs(between[v]) : 0.0;
    CHECK(bounds.lower[v] <= between[v] + room);
    CHECK(bounds.upper[v] >= between[v] - room);
    CHECK(bounds.lower[v] <= bounds.upper[v]);
    CHECK(std::isinf(bounds.upper[v]) == std::isinf(between[v]));
  }
}

void check(const Mesh<double>& mesh, const std::vector<Source<double>>& list,
           const std::vector<double>& truth, double slack) {
  const std::span<const Source<double>> sources(list);
  const auto exact = ExactSolver(mesh).distance(sources);
  const Certifier certifier(mesh);
  std::vector<double> twice = exact;
  for (double& d : twice) d *= 2;
  for (const auto& given : {exact, FastMarchingSolver(mesh).distance(sources), twice}) {
    const auto bounds = certifier.bounds(sources, given);
    check(bounds, exact, slack);
    check(bounds, truth, slack);
  }
}

}  // namespace

TEST_CASE("bounds hold on every mesh of the catalogue") {
  auto cases = stress::shape_cases();
  for (auto& one : stress::topology_cases()) cases.push_back(std::move(one));
  for (const auto& one : cases) {
    if (!one.problems) continue;
    CAPTURE(one.name);
    const bool is_of_mesh = stress::claims_of(one.name)[3].most < 1e-9;  // else of a smooth surface
    for (const auto& problem : one.problems(stress::Precision::in_double)) {
      CAPTURE(problem.name);
      check(problem.mesh, problem.sources, is_of_mesh ? problem.truth : std::vector<double>{},
            problem.slack);
    }
  }
}

TEST_CASE("bounds hold on meshes where something once failed") {
  for (const auto& kept : stress::kept_meshes()) {
    CAPTURE(kept.first);
    for (Index v = 0; v < static_cast<Index>(kept.second.positions.size()); ++v) {
      check(kept.second, stress::from(v), {}, 1);
    }
  }
}
