// Distances on the smooth surface that a mesh stands for.

#include "gelight/geodesic/smooth.hpp"

#include "distances.hpp"
#include "hook.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::SmoothTrust;
using Solver = gelight::SmoothDistanceSolver<double>;
using Distances = gelight::SmoothDistances<double>;
using SmoothPath = gelight::SmoothPath<double>;

namespace {

void bind_results(py::module_& m) {
  py::class_<Distances>(m, "SmoothDistances", "Distances on the smooth surface of a mesh.")
      .def_property_readonly(
          "distance",
          [](const py::object& self) {
            const auto& d = self.cast<const Distances&>().distance;
            return py::array_t<double>(static_cast<py::ssize_t>(d.size()), d.data(), self);
          },
          "Of each vertex, float64 (n,); +inf where no path leads.")
      .def_property_readonly(
          "direction",
          [](const py::object& self) {
            const auto& d = self.cast<const Distances&>().direction;
            return py::array_t<double>({static_cast<py::ssize_t>(d.size()), py::ssize_t{3}},
                                       reinterpret_cast<const double*>(d.data()), self);
          },
          "Unit tangent in which the path arrives, float64 (n, 3); zero where none does.")
      .def_property_readonly(
          "trust",
          [](const py::object& self) {
            const auto& d = self.cast<const Distances&>().trust;
            return py::array_t<std::uint8_t>(static_cast<py::ssize_t>(d.size()),
                                             reinterpret_cast<const std::uint8_t*>(d.data()), self);
          },
          "What each distance is worth, uint8 (n,): numbers of SmoothTrust.");
  py::class_<SmoothPath>(m, "SmoothPath", "A path on the smooth surface.")
      .def_property_readonly(
          "positions", [](const SmoothPath& p) { return array_of(std::vector(p.positions)); },
          "Where it runs, beginning at the source, float64 (k, 3).")
      .def_readonly("length", &SmoothPath::length, "On the smooth surface.")
      .def_property_readonly(
          "direction", [](const SmoothPath& p) { return array_of(p.direction); },
          "Unit tangent on arrival, float64 (3,).")
      .def_readonly("trust", &SmoothPath::trust, "What the length is worth.");
}

gelight::SmoothOptions<double> options_of(double crease_angle, py::handle creases,
                                          double most_roughness, py::object cancelled) {
  gelight::SmoothOptions<double> options;
  options.crease_angle = crease_angle;
  options.most_roughness = most_roughness;
  options.cancelled = hook_of(std::move(cancelled));
  if (creases.is_none()) return options;
  const auto pairs = indices_in(creases, "creases");
  gelight::detail::require(pairs.ndim() == 2 && pairs.shape(1) == 2, "creases has shape ",
                           shape_text(pairs), ", not (any, 2)");
  for (const auto& pair : rows_of<2>(pairs)) options.creases.push_back(pair);
  return options;
}

}  // namespace

void bind_smooth(py::module_& m) {
  py::enum_<SmoothTrust>(m, "SmoothTrust", "What a distance on the smooth surface is worth.")
      .value("smooth", SmoothTrust::smooth, "The length of the straightest path there.")
      .value("bound", SmoothTrust::bound, "The length of a path with which another competes.")
      .value("rough", SmoothTrust::rough, "The distance on the mesh.");
  bind_results(m);
  auto solver = py::class_<Solver>(
      m, "SmoothDistanceSolver",
      "Geodesic distance on the smooth surface of which a mesh has the vertices: the exact paths "
      "of the mesh, lifted to a surface curved as normals say, straightened there and measured.");
  solver.def(
      py::init([](const Surface& surface, py::handle normals, double crease_angle,
                  py::handle creases, double most_roughness, py::object cancelled) {
        const auto options =
            options_of(crease_angle, creases, most_roughness, std::move(cancelled));
        if (normals.is_none()) return without_gil([&] { return Solver(surface, options); });
        const auto n = rows_in<double, 3>(normals, "normals");
        return without_gil([&] { return Solver(surface, rows_of<3>(n), options); });
      }),
      "surface"_a, "normals"_a = py::none(), py::kw_only(), "crease_angle"_a = 0.7,
      "creases"_a = py::none(), "most_roughness"_a = 0.3, "cancelled"_a = py::none(),
      "normals: unit, of the vertices (n, 3); fitted where none are given. crease_angle: edges at "
      "which the mesh turns by more stay sharp, in radians, but where it is noise. creases: "
      "further ones, pairs of vertices (k, 2). most_roughness: beyond it distances are those on "
      "the mesh.");
  bind_distances(solver);
  solver
      .def(
          "solve",
          [](const Solver& self, py::handle sources) {
            const auto from = sources_in(sources);
            return without_gil(
                [&] { return self.solve(std::span<const gelight::Source<double>>(from)); });
          },
          "sources"_a, "Distances, directions and what they are worth.")
      .def(
          "path",
          [](const Solver& self, const Distances& distances, py::handle point) {
            const Point p = point_in(point);
            return without_gil([&] { return self.path(distances, p); });
          },
          "distances"_a, "point"_a, "The path on the smooth surface from the source to a point.")
      .def(
          "position",
          [](const Solver& self, py::handle point) {
            return array_of(self.position(point_in(point)));
          },
          "point"_a, "The point of the smooth surface over a point of the mesh, float64 (3,).");
}
