// Vectors over a surface: by heat, along paths, and log maps.

#include "gelight/transport/log_map.hpp"
#include "gelight/transport/parallel.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "hook.hpp"
#include "points.hpp"
#include "topics.hpp"

using namespace py::literals;
using VectorHeat = gelight::VectorHeatSolver<double>;
using LogMap = gelight::ExactLogMap<double>;
using LogMapSolver = gelight::ExactLogMapSolver<double>;
using Parallel = gelight::ParallelTransport<double>;
using VectorSources = std::vector<gelight::VectorSource<double>>;

namespace {

py::array_t<double> basis_of(const std::array<Vec3<double>, 2>& basis) {
  return array_of(std::vector<Vec3<double>>{basis[0], basis[1]});
}

// One point and one vector, or as many of each.
VectorSources vector_sources_in(py::handle points, py::handle vectors) {
  const auto places = sources_in(points);
  const auto array = Packed<double>(array_in(vectors, "fiu", "vectors"));
  gelight::detail::require(array.size() == 3 * static_cast<py::ssize_t>(places.size()) &&
                               array.ndim() <= 2 && array.shape(array.ndim() - 1) == 3,
                           "there are ", places.size(), " points, vectors has shape ",
                           shape_text(array));
  VectorSources sources;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double* const v = array.data() + 3 * i;
    sources.push_back({places[i].point, {v[0], v[1], v[2]}});
  }
  return sources;
}

template <class Result, class Numbers>
void bind_result(py::module_& m, const char* name, const char* doc, const char* field,
                 const char* words, const Numbers& numbers) {
  py::class_<Result>(m, name, doc)
      .def_property_readonly(
          field, [numbers](const Result& r) { return array_of(std::vector(numbers(r))); }, words)
      .def_readonly("error", &Result::error, "Estimate of the mean relative error.")
      .def_readonly("is_reliable", &Result::is_reliable, "The error is at most 0.07.");
}

void bind_vector_heat(py::module_& m) {
  bind_result<gelight::TransportResult<double>>(
      m, "TransportResult", "Transported vectors, and how far they are to be trusted.", "vectors",
      "Of each vertex, float64 (n, 3), in the mesh's space.",
      [](const auto& r) { return r.vectors; });
  bind_result<gelight::LogMapResult<double>>(
      m, "LogMapResult", "A log map, and how far it is to be trusted.", "coordinates",
      "Of each vertex, float64 (n, 2).", [](const auto& r) { return r.coordinates; });
  py::class_<VectorHeat>(
      m, "VectorHeatSolver",
      "Carries tangent vectors over a surface along its shortest paths by the vector heat method "
      "(Sharp, Soliman, Crane 2019, doi:10.1145/3243651). Vectors go in and come out in the mesh's "
      "own space, one per vertex. Mean errors: 0.5 and 0.2 degrees on icospheres of 2,562 and "
      "10,242 vertices.")
      .def(py::init([](const Surface& surface, double time_factor, bool intrinsic_delaunay,
                       py::object cancelled) {
             const auto hook = hook_of(std::move(cancelled));
             return without_gil([&] {
               return VectorHeat(surface, {time_factor, intrinsic_delaunay, hook});
             });
           }),
           "surface"_a, py::kw_only(), "time_factor"_a = 1.0, "intrinsic_delaunay"_a = true,
           "cancelled"_a = py::none(), "time_factor: in squared mean edge lengths.")
      .def(
          "tangent_basis",
          [](const VectorHeat& self, py::handle vertex) {
            return basis_of(self.tangent_basis(index_in(vertex, "vertex")));
          },
          "vertex"_a,
          "Two unit vectors that span the tangent plane at a vertex, float64 (2, 3); their cross "
          "product is the normal.")
      .def(
          "transport",
          [](const VectorHeat& self, py::handle points, py::handle vectors) {
            const auto sources = vector_sources_in(points, vectors);
            return array_of(without_gil([&] { return self.transport(sources); }));
          },
          "points"_a, "vectors"_a,
          "Carries a vector (3,) from a vertex or SurfacePoint to all vertices, float64 (n, 3); or "
          "several (k, 3), each over the region nearest to its point.")
      .def(
          "solve",
          [](const VectorHeat& self, py::handle points, py::handle vectors) {
            const auto sources = vector_sources_in(points, vectors);
            return without_gil([&] { return self.solve(sources); });
          },
          "points"_a, "vectors"_a, "The same vectors, with an estimate of their error.")
      .def(
          "radial",
          [](const VectorHeat& self, py::handle vertex) {
            const Index v = index_in(vertex, "vertex");
            return array_of(without_gil([&] { return self.radial(v); }));
          },
          "vertex"_a,
          "Unit vectors that point away from a vertex along the shortest paths, float64 (n, 3).")
      .def(
          "log_map",
          [](const VectorHeat& self, py::handle vertex) {
            const Index v = index_in(vertex, "vertex");
            return array_of(without_gil([&] { return self.log_map(v); }));
          },
          "vertex"_a,
          "Coordinates of each vertex in the tangent plane of another, along its tangent_basis, "
          "float64 (n, 2); +inf where no path leads.")
      .def(
          "solve_log_map",
          [](const VectorHeat& self, py::handle vertex) {
            const Index v = index_in(vertex, "vertex");
            return without_gil([&] { return self.solve_log_map(v); });
          },
          "vertex"_a, "The same coordinates, with an estimate of their error.")
      .def(
          "extend",
          [](const VectorHeat& self, py::handle vertices, py::handle values) {
            const auto v = index_row_in(vertices, "vertices");
            const auto numbers = numbers_in<double>(values, "values");
            return array_of(without_gil([&] { return self.extend(span_of(v), span_of(numbers)); }));
          },
          "vertices"_a, "values"_a,
          "Continues values (k,) given at some vertices (k,) to all others, float64 (n,).");
}

void bind_log_map(py::module_& m) {
  py::class_<LogMap>(m, "ExactLogMap",
                     "The exact log map of one source: where points lie in its tangent plane.")
      .def_property_readonly(
          "tangent_basis", [](const LogMap& self) { return basis_of(self.tangent_basis()); },
          "Two unit vectors along which coordinates are counted, float64 (2, 3).")
      .def(
          "__call__",
          [](const LogMap& self, py::handle point) {
            const Point p = point_in(point);
            return array_of(without_gil([&] { return self(p); }));
          },
          "point"_a, "Coordinates of a point, float64 (2,); +inf where no path leads.")
      .def(
          "at_vertices",
          [](const LogMap& self) {
            return array_of(without_gil([&] { return self.at_vertices(); }));
          },
          "Coordinates of all vertices, float64 (n, 2).")
      .def(
          "is_on_cut_locus",
          [](const LogMap& self, py::handle point, double relative_tolerance) {
            const Point p = point_in(point);
            return without_gil([&] { return self.is_on_cut_locus(p, relative_tolerance); });
          },
          "point"_a, "relative_tolerance"_a,
          "Whether two paths from different sides are as long but for a share.");
  py::class_<LogMapSolver>(m, "ExactLogMapSolver",
                           "Exact log maps: distances by ExactSolver, directions by following each "
                           "path back to its source.")
      .def(py::init([](const Surface& surface, py::object cancelled) {
             const auto hook = hook_of(std::move(cancelled));
             return without_gil([&] { return LogMapSolver(surface, {hook}); });
           }),
           "surface"_a, py::kw_only(), "cancelled"_a = py::none())
      .def(
          "solve",
          [](const LogMapSolver& self, py::handle source) {
            const Point p = point_in(source);
            return without_gil([&] { return self.solve(p); });
          },
          "source"_a, "The map of a vertex or SurfacePoint.")
      .def(
          "log_map",
          [](const LogMapSolver& self, py::handle source) {
            const Index v = index_in(source, "vertex");
            return array_of(without_gil([&] { return self.log_map(v); }));
          },
          "source"_a, "Coordinates of all vertices in a vertex' tangent plane, float64 (n, 2).")
      .def(
          "tangent_basis",
          [](const LogMapSolver& self, py::handle vertex) {
            return basis_of(self.tangent_basis(index_in(vertex, "vertex")));
          },
          "vertex"_a, "Two unit vectors along which its coordinates are counted, float64 (2, 3).");
}

void bind_parallel(py::module_& m) {
  py::class_<Parallel>(m, "ParallelTransport",
                       "Carries tangent vectors along paths, parallel to themselves: exact on the "
                       "polyhedron.")
      .def(py::init<const Surface&>(), "surface"_a)
      .def(
          "tangent_basis",
          [](const Parallel& self, py::handle point) {
            return basis_of(self.tangent_basis(point_in(point)));
          },
          "point"_a, "Two unit vectors that span the tangent plane at a point, float64 (2, 3).")
      .def(
          "along",
          [](const Parallel& self, const PathOn& path, py::handle vector) {
            return array_of(self.along(path.points, vector_in(vector, "vector")));
          },
          "path"_a, "vector"_a,
          "The vector at the end of a path that is parallel to one at its start, float64 (3,).")
      .def(
          "holonomy",
          [](const Parallel& self, const PathOn& path) { return self.holonomy(path.points); },
          "path"_a,
          "The angle from a vector to itself carried once round a closed path, in radians.");
}

}  // namespace

void bind_transport(py::module_& m) {
  bind_vector_heat(m);
  bind_log_map(m);
  bind_parallel(m);
}
