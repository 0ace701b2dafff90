#pragma once

#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/planning/method_models.hpp"
#include "gelight/geodesic/smooth.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
struct PlanMethod;
}  // namespace gelight

namespace gelight::detail {

/// Solvers of a mesh, made when they are first needed.
template <std::floating_point Real>
class PlannedSolvers {
 public:
  using Own = Deferred<PlanMethod, Real>;

  PlannedSolvers(const Surface<Real>& surface, const std::vector<Index>& targets,
                 const std::vector<Own>& own)
      : surface_(surface), own_(own.size()) {
    for (const Index v : targets) options_.targets.push_back(vertex_point<Real>(v));
  }

  [[nodiscard]] std::vector<Real> distance(const Own& method, std::size_t number,
                                           const Array<Source<Real>>& sources,
                                           const CancelHook& cancelled) const {
    cancelled.check(0, "the planned query");
    const typename Own::Query& query = own_[number].get([&] { return method.make(surface_); });
    require(query != nullptr, "the method ", method.name, " made nothing to ask");
    auto distances = query(sources);
    require(distances.size() == static_cast<std::size_t>(surface_.vertex_count()), "the method ",
            method.name, " gave ", distances.size(), " distances of ", surface_.vertex_count(),
            " vertices");
    for (std::size_t v = 0; v < distances.size(); ++v) {
      require(distances[v] >= 0, "the method ", method.name, " gave ", distances[v], " at vertex ",
              v);
    }
    return distances;
  }

  [[nodiscard]] std::vector<Real> distance(Method method, const Array<Source<Real>>& sources,
                                           const CancelHook& cancelled) const {
    const std::span<const Source<Real>> from(sources);
    cancelled.check(0, "the planned query");
    switch (method) {
      case Method::dijkstra:
        return made(dijkstra_, DijkstraOptions{.cancelled = cancelled.part(0, 0)}).distance(from);
      case Method::virtual_source:
        return made(virtual_source_, VirtualSourceOptions{.cancelled = cancelled.part(0, 0)})
            .distance(from);
      case Method::fast_marching:
        return made(fast_marching_, FastMarchingOptions{.cancelled = cancelled.part(0, 0)})
            .distance(from);
      default:
        return exact(from, cancelled);
    }
  }

  [[nodiscard]] SmoothDistances<Real> smooth(const Array<Source<Real>>& sources,
                                             const CancelHook& cancelled) const {
    cancelled.check(0, "the planned query");
    const std::span<const Source<Real>> from(sources);
    const auto& solver = smooth_.get([&] { return SmoothDistanceSolver<Real>(surface_); });
    if (!cancelled) return solver.solve(from);
    return SmoothDistanceSolver<Real>(surface_, {.cancelled = cancelled}).solve(from);
  }

  [[nodiscard]] const PlanarFaces<Real>& faces() const {
    return faces_.get([&] { return PlanarFaces<Real>(surface_); });
  }

 private:
  // A planner has one hook, and asks its first method with the same part of it every time. That is
  // asked in a set-up and in queries, each of which would tell of its own progress.
  template <class Solver>
  [[nodiscard]] const Solver& made(const Lazy<Solver>& solver, const auto& options) const {
    return solver.get([&] { return Solver(surface_, options); });
  }

  [[nodiscard]] std::vector<Real> exact(std::span<const Source<Real>> from,
                                        const CancelHook& cancelled) const {
    const auto& solver = exact_.get([&] { return ExactSolver<Real>(surface_, options_); });
    if (!cancelled) return solver.distance(from);
    ExactOptions<Real> options = options_;
    options.cancelled = cancelled;
    return solver.solve(from, options).distances();
  }

  Surface<Real> surface_;
  ExactOptions<Real> options_;
  Lazy<DijkstraSolver<Real>> dijkstra_;
  Lazy<VirtualSourceSolver<Real>> virtual_source_;
  Lazy<FastMarchingSolver<Real>> fast_marching_;
  Lazy<ExactSolver<Real>> exact_;
  Lazy<SmoothDistanceSolver<Real>> smooth_;
  Lazy<PlanarFaces<Real>> faces_;
  std::vector<Lazy<typename Own::Query>> own_;
};

}  // namespace gelight::detail
