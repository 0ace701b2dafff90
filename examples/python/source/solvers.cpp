// Distances at the vertices: by edges, fast marching, virtual sources.

#include "distances.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "hook.hpp"
#include "topics.hpp"

using namespace py::literals;

void bind_solvers(py::module_& m) {
  using Dijkstra = gelight::DijkstraSolver<double>;
  auto dijkstra = py::class_<Dijkstra>(
      m, "DijkstraSolver",
      "Length of the shortest path along edges (Dijkstra 1959, doi:10.1007/BF01386390): an upper "
      "bound of the geodesic distance, 7 to 9 % too long on average on icospheres.");
  dijkstra.def(py::init([](const Surface& surface, Index steiner_points, py::object cancelled) {
                 return Dijkstra(surface, {steiner_points, hook_of(std::move(cancelled))});
               }),
               "surface"_a, py::kw_only(), "steiner_points"_a = 0, "cancelled"_a = py::none(),
               "steiner_points: on each edge, by which paths may cross it.");
  bind_distances(dijkstra);

  using FastMarching = gelight::FastMarchingSolver<double>;
  auto marching = py::class_<FastMarching>(
      m, "FastMarchingSolver",
      "Distance by a front that marches over the vertices (Kimmel and Sethian 1998, "
      "doi:10.1073/pnas.95.15.8431). On icospheres of 642 vertices 0.62 % off on average, 0.015 % "
      "on those of 655,362.");
  marching.def(py::init([](const Surface& surface, py::object cancelled) {
                 const auto hook = hook_of(std::move(cancelled));
                 return without_gil([&] { return FastMarching(surface, {hook}); });
               }),
               "surface"_a, py::kw_only(), "cancelled"_a = py::none());
  bind_distances(marching);

  using VirtualSource = gelight::VirtualSourceSolver<double>;
  auto virtual_source = py::class_<VirtualSource>(
      m, "VirtualSourceSolver",
      "Distance by virtual sources (after Trettner, Bommes, Kobbelt 2021, doi:10.1111/cgf.14371). "
      "On icospheres of 642 vertices 0.17 % off on average, 0.0001 % on those of 655,362.");
  virtual_source.def(py::init([](const Surface& surface, py::object cancelled) {
                       const auto hook = hook_of(std::move(cancelled));
                       return without_gil([&] { return VirtualSource(surface, {hook}); });
                     }),
                     "surface"_a, py::kw_only(), "cancelled"_a = py::none());
  bind_distances(virtual_source);
}
