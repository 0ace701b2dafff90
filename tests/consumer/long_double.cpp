// A mesh of long double, by the headers alone: all that takes one compiles, and answers.

#include <array>
#include <cmath>
#include <cstdio>
#include <gelight/gelight.hpp>
#include <span>
#include <vector>

using namespace gelight;
using T = long double;

namespace {

const Mesh<T> mesh = grid<T>(8, 6, 4, 3);
const Surface<T> surface(mesh);
const auto last = static_cast<Index>(mesh.positions.size()) - 1;
bool is_right = true;

void expect_five(const char* what, T number) {
  if (std::fabs(number - 5) < T(1e-9)) return;
  is_right = false;
  std::printf("%s: %.9Lf\n", what, number);
}

void distances() {
  const ExactSolver<T> exact(mesh, {.keep_windows = true});
  const auto field = exact.solve(0);
  const std::vector<T> found = field.distances();
  expect_five("exact", found.back());
  expect_five("arrival", field.arrivals(last).front().distance);
  expect_five("exact isolines", 5 * static_cast<T>(exact_isolines(field, T(2)).size()));
  const std::vector<Source<T>> sources{{vertex_point<T>(0), T(0.5)}};
  expect_five("start", exact.distance(sources).back() - T(0.5));
  const std::vector<Segment<T>> curve{{vertex_point<T>(0), vertex_point<T>(0), T(0)}};
  expect_five("segment", exact.distance(std::span<const Segment<T>>(curve)).back());
  expect_five("fast marching", FastMarchingSolver(mesh).distance(sources).back() - T(0.5));
  expect_five("virtual sources", VirtualSourceSolver(mesh).distance(sources).back() - T(0.5));
  expect_five("smooth", SmoothDistanceSolver(mesh).distance(0).back());
  const bool is_near = std::fabs(HeatSolver(mesh).distance(0).back() - 5) < T(0.2) &&
                       DijkstraSolver(mesh).distance(0).back() >= 5;
  expect_five("heat and Dijkstra", is_near ? 5 : 0);
  expect_five("planner", DistancePlanner(mesh, {.tolerance = 1e-12}).distance(0).back());
  const auto bounds = Certifier(mesh).bounds(0, found);
  expect_five("bounds", bounds.lower.back() <= 5 && bounds.upper.back() < T(5.0001) ? 5 : 0);
  expect_five("isolines", 5 * static_cast<T>(isolines(surface, found, T(2)).size()));
  expect_five("area", area_below(surface, found, T(9)) - 7);
}

void lines() {
  const PathSolver solver(mesh);
  const Path<T> path = solver.shortest_path(0, last);
  expect_five("path", length(surface, path));
  expect_five("straightened", length(surface, solver.straightened(path)));
  const auto here = face_point<T>(0, {T(0.25), T(0.25), T(0.5)});
  const auto traced = trace_geodesic(mesh, vertex_point<T>(0), Vec3<T>(4, 3, 0), T(5));
  expect_five("traced", surface.position(traced.back()).norm());
  const Path<T> on = trace_geodesic(mesh, here, Vec3<T>(1, 0, 0), T(9));  // as far as the border
  expect_five("traced from a face", surface.position(on.back()).x() + 1);
  const Vec3<T> along(0, 5, 0);
  expect_five("transport", ParallelTransport(mesh).along(path, along).y());
  expect_five("log map", ExactLogMapSolver(mesh).log_map(0).back().norm());
  const std::vector<VectorSource<T>> sources{{vertex_point<T>(0), along}, {here, along}};
  const VectorHeatSolver<T> heat(mesh);
  expect_five("vector heat", heat.transport(sources).back().norm());
  expect_five("extended", heat.extend({0, last}, {T(5), T(5)})[1]);
}

void meshes() {
  expect_five("nearest", T(5) * static_cast<T>(nearest_vertex(surface, {9, 9, 0}) == last));
  expect_five("nearest point", surface.position(nearest_point(surface, {9, 9, 0})).norm());
  const auto repaired = repair(mesh, {.drop_unusable_faces = true, .weld_distance = 0});
  expect_five("repaired", 5 + static_cast<T>(repaired.dropped_faces));
  expect_five("Delaunay", 5 * static_cast<T>(intrinsic_delaunay(surface).face_count() == 96));
  expect_five("frames", 5 * TangentFrames<T>(surface).basis(0).normal().z());
}

}  // namespace

int main() {
  distances();
  lines();
  meshes();
  if (is_right) std::puts("across a sheet of 4 x 3: 5.000000000");
}
