// Paths between two points, straight on from one, and the lines and regions of distances.

#include "any_solver.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/geodesic/shortest_path.hpp"
#include "gelight/geodesic/trace.hpp"
#include "gelight/geodesic/voronoi.hpp"
#include "hook.hpp"
#include "points.hpp"
#include "topics.hpp"

using namespace py::literals;
using Solver = gelight::PathSolver<double>;
using Exact = gelight::ExactSolver<double>;

namespace {

template <class Find>
PathOn path_by(const Solver& solver, py::handle from, py::handle to, const Find& find) {
  const Point a = point_in(from), b = point_in(to);
  return {solver.surface(), without_gil([&] { return find(a, b); })};
}

void bind_solver(py::module_& m) {
  py::class_<Solver>(
      m, "PathSolver",
      "Paths between pairs of points, without distances of the whole mesh. May be asked from "
      "several threads.")
      .def(py::init([](const Surface& surface, py::object cancelled) {
             const auto hook = hook_of(std::move(cancelled));
             return without_gil([&] { return Solver(surface, hook); });
           }),
           "surface"_a, py::kw_only(), "cancelled"_a = py::none())
      .def(
          "shortest_path",
          [](const Solver& self, py::handle from, py::handle to) {
            return path_by(self, from, to, [&](const Point& a, const Point& b) {
              return self.shortest_path(a, b);
            });
          },
          "start"_a, "end"_a,
          "The shortest path between two vertices or SurfacePoints; empty where none leads.")
      .def(
          "straight_path",
          [](const Solver& self, py::handle from, py::handle to) {
            return path_by(self, from, to, [&](const Point& a, const Point& b) {
              return self.straight_path(a, b);
            });
          },
          "start"_a, "end"_a,
          "A locally shortest path: the shortest one along edges, straightened. The cheap door.")
      .def(
          "straightened",
          [](const Solver& self, const PathOn& path) {
            return PathOn{self.surface(),
                          without_gil([&] { return self.straightened(path.points); })};
          },
          "path"_a, "A path made locally shortest, between its own ends.")
      .def_property_readonly(
          "surface", [](const Solver& self) { return self.surface(); },
          "The surface that the solver works on.");
}

void bind_lines(py::module_& m) {
  m.def(
      "isolines",
      [](const Surface& surface, py::handle values, double level) {
        const auto numbers = numbers_in<double>(values, "values");
        const auto lines =
            without_gil([&] { return gelight::isolines(surface, span_of(numbers), level); });
        std::vector<PathOn> paths;
        for (const auto& line : lines) paths.push_back({surface, line.points});
        return paths;
      },
      "surface"_a, "values"_a, "level"_a,
      "The lines on which a value of the vertices (n,), linear over each face, equals a level: a "
      "list of Paths, of closed ones the first point is the last, lower values to their left.");
  m.def(
      "area_below",
      [](const Surface& surface, py::handle values, double level) {
        const auto numbers = numbers_in<double>(values, "values");
        return gelight::area_below(surface, span_of(numbers), level);
      },
      "surface"_a, "values"_a, "level"_a,
      "The area on which a value of the vertices, linear over each face, is below a level.");
}

// By the exact solver each site is solved where it is nearest alone, by others everywhere.
template <class Ask>
auto ask_solver(py::handle solver, const Ask& ask) {
  if (py::isinstance<Exact>(solver)) {
    const auto& exact = solver.cast<const Exact&>();
    return array_of(without_gil([&] { return ask(exact); }));
  }
  const AnySolver any = any_solver(solver);
  return array_of(without_gil([&] { return ask(any); }));
}

void bind_regions(py::module_& m) {
  m.def(
      "farthest_points",
      [](py::handle solver, Index count, py::handle first, py::object cancelled) {
        const Index begin = index_in(first, "vertex");
        const auto hook = hook_of(std::move(cancelled));
        return ask_solver(solver, [&](const auto& by) {
          return gelight::farthest_points(by, count, begin, hook);
        });
      },
      "solver"_a, "count"_a, "first"_a = 0, "cancelled"_a = py::none(),
      "Vertices spread as far apart as they come, int32 (count,): each the one farthest from all "
      "before it (Gonzalez 1985, doi:10.1016/0304-3975(85)90224-5). By any distance solver; by "
      "ExactSolver each point is solved where it is nearest alone.");
  m.def(
      "voronoi",
      [](py::handle solver, py::handle sites, py::object cancelled) {
        const auto vertices = index_row_in(sites, "sites");
        const auto hook = hook_of(std::move(cancelled));
        return ask_solver(
            solver, [&](const auto& by) { return gelight::voronoi(by, span_of(vertices), hook); });
      },
      "solver"_a, "sites"_a, "cancelled"_a = py::none(),
      "The nearest site of each vertex, int32 (n,), one of `sites`; -1 where no path leads to "
      "any. By any distance solver; by ExactSolver each site is solved where it is nearest "
      "alone.");
}

}  // namespace

void bind_paths(py::module_& m) {
  bind_solver(m);
  m.def(
      "trace_geodesic",
      [](const Surface& surface, py::handle point, py::handle direction, double length,
         py::object cancelled) {
        const Point from = point_in(point);
        const Vec3<double> way = vector_in(direction, "direction");
        const auto hook = hook_of(std::move(cancelled));
        return PathOn{surface, without_gil([&] {
                        return gelight::trace_geodesic(surface, from, way, length, hook);
                      })};
      },
      "surface"_a, "point"_a, "direction"_a, "length"_a, "cancelled"_a = py::none(),
      "The straightest geodesic from a point in a direction (3,) for a length: the exponential map "
      "(Polthier, Schmies 1998, doi:10.1007/978-3-662-03567-2_11). It ends earlier at a border.");
  bind_lines(m);
  bind_regions(m);
}
