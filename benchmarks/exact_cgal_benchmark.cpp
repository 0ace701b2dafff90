// Exact solves beside CGAL's Surface_mesh_shortest_path, in turn on the same mesh.

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using CgalMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using ShortestPath =
    CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, CgalMesh>>;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

CgalMesh to_cgal(const gelight::Mesh<double>& mesh) {
  CgalMesh out;
  for (const auto& p : mesh.positions) out.add_vertex({p[0], p[1], p[2]});
  for (const auto& [a, b, c] : mesh.faces) {
    using Vertex = CgalMesh::Vertex_index;
    using Number = CgalMesh::size_type;
    out.add_face(Vertex(static_cast<Number>(a)), Vertex(static_cast<Number>(b)),
                 Vertex(static_cast<Number>(c)));
  }
  return out;
}

void sphere(benchmark::State& state) {
  const auto mesh = gelight::icosphere<double>(static_cast<int>(state.range(0)));
  const CgalMesh cgal = to_cgal(mesh);
  const gelight::ExactSolver solver(mesh);
  double ours = 0, theirs = 0, worst = 0;
  for (auto _ : state) {
    auto start = Clock::now();
    const std::vector<double> distance = solver.distance(0);
    ours += seconds_since(start);
    start = Clock::now();
    ShortestPath paths(cgal);
    paths.add_source_point(*cgal.vertices().begin());
    paths.build_sequence_tree();
    const double solve = seconds_since(start);
    theirs += solve;
    state.SetIterationTime(solve);
    for (const auto v : cgal.vertices()) {
      const double d = paths.shortest_distance_to_source_points(v).first;
      worst = std::max(worst, std::fabs(d - distance[v]) / std::max(d, 1e-3));
    }
  }
  state.counters["CGAL_s"] = benchmark::Counter(theirs, benchmark::Counter::kAvgIterations);
  state.counters["gelight_s"] = benchmark::Counter(ours, benchmark::Counter::kAvgIterations);
  state.counters["ratio"] = theirs / ours;
  state.counters["difference"] = worst;
  if (!(worst < 1e-11)) state.SkipWithError("the two disagree");
}
BENCHMARK(sphere)->Arg(4)->Arg(5)->Arg(6)->Iterations(1)->UseManualTime()->Unit(
    benchmark::kMillisecond);

}  // namespace
