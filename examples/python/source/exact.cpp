// Exact distances and what is known of them between the vertices.

#include "gelight/geodesic/exact.hpp"

#include "distances.hpp"
#include "gelight/geodesic/exact_isoline.hpp"
#include "hook.hpp"
#include "topics.hpp"

using namespace py::literals;
using Solver = gelight::ExactSolver<double>;
using Field = gelight::ExactField<double>;
using Arrival = gelight::ExactArrival<double>;
using Departure = gelight::ExactDeparture<double>;

namespace {

// Of many points at once: `at` tells of one.
template <class T, class At>
py::array_t<double> at_points(py::handle faces, py::handle barycentric, const At& at) {
  const auto points = points_in(faces, barycentric);
  return array_of(without_gil([&] {
    std::vector<T> out;
    out.reserve(points.size());
    for (const Point& p : points) out.push_back(at(p));
    return out;
  }));
}

py::object distance_of(const Field& field, py::handle points, py::handle barycentric) {
  if (!barycentric.is_none()) {
    return at_points<double>(points, barycentric,
                             [&](const Point& p) { return field.distance(p); });
  }
  const Point p = point_in(points);
  if (p.kind == Point::Kind::vertex) return py::float_(field.distance(p.element[0]));
  return py::float_(without_gil([&] { return field.distance(p); }));
}

py::object direction_of(const Field& field, py::handle points, py::handle barycentric) {
  if (!barycentric.is_none()) {
    return at_points<Vec3<double>>(points, barycentric,
                                   [&](const Point& p) { return field.direction(p); });
  }
  const Point p = point_in(points);
  return array_of(without_gil([&] { return field.direction(p); }));
}

void bind_ways(py::module_& m) {
  py::class_<Arrival>(m, "ExactArrival", "One straight line by which a point is reached.")
      .def_readonly("distance", &Arrival::distance,
                    "Length of the path, with the source's start distance.")
      .def_property_readonly(
          "direction", [](const Arrival& a) { return array_of(a.direction); },
          "Unit tangent in the direction of travel, float64 (3,); zero at a source.")
      .def_readonly("origin", &Arrival::from,
                    "Where the line begins: the source, or the last vertex where the path can "
                    "bend. (C++ calls it `from`.)");
  py::class_<Departure>(m, "ExactDeparture", "How a path leaves its source.")
      .def_property_readonly(
          "direction", [](const Departure& d) { return array_of(d.direction); },
          "Unit tangent in the direction of travel, float64 (3,).")
      .def_readonly("halfedge", &Departure::halfedge,
                    "A half-edge of the face into which the path goes: 3 face + corner.")
      .def_readonly("angle", &Departure::angle,
                    "From that half-edge towards the inside of the face, in radians.");
}

// A path needs the surface, which a field does not tell.
struct FieldOn {
  Surface surface;
  Field field;
};

void bind_field(py::module_& m) {
  py::class_<FieldOn>(
      m, "ExactField",
      "Exact geodesic distances from the sources of one solve, with paths and directions of "
      "arrival, at the vertices and anywhere between them. May be asked from several threads.")
      .def(
          "distances",
          [](const FieldOn& self) {
            return array_of(without_gil([&] { return self.field.distances(); }));
          },
          "Distance of each vertex, float64 (n,); +inf where no path leads.")
      .def(
          "distance",
          [](const FieldOn& self, py::handle points, py::handle barycentric) {
            return distance_of(self.field, points, barycentric);
          },
          "points"_a, "barycentric"_a = py::none(),
          "Distance of a vertex or SurfacePoint; or of points inside of faces, given as arrays of "
          "faces (n,) and barycentric coordinates (n, 3): float64 (n,).")
      .def(
          "path",
          [](const FieldOn& self, py::handle point) {
            const Point p = point_in(point);
            return PathOn{self.surface, without_gil([&] { return self.field.path(p); })};
          },
          "point"_a,
          "The shortest path from the source to a point; empty where no path leads. Of several "
          "shortest paths one.")
      .def(
          "direction",
          [](const FieldOn& self, py::handle points, py::handle barycentric) {
            return direction_of(self.field, points, barycentric);
          },
          "points"_a, "barycentric"_a = py::none(),
          "The unit tangent in which the shortest path arrives, float64 (3,), zero where none "
          "does; of points inside of faces, as for `distance`, (n, 3).")
      .def(
          "arrivals",
          [](const FieldOn& self, py::handle point, double relative_tolerance) {
            const Point p = point_in(point);
            return without_gil([&] { return self.field.arrivals(p, relative_tolerance); });
          },
          "point"_a, "relative_tolerance"_a = 1e-12,
          "All straight lines by which a point is reached with at most (1 + relative_tolerance) "
          "times its distance, nearest first: more than one on the cut locus.")
      .def(
          "departure",
          [](const FieldOn& self, py::handle point) {
            const Point p = point_in(point);
            return without_gil([&] { return self.field.departure(p); });
          },
          "point"_a,
          "How the shortest path to a point leaves its source. Raises ValueError at a source and "
          "where no path leads.")
      .def(
          "isolines",
          [](const FieldOn& self, double level, py::object cancelled) {
            const auto hook = hook_of(std::move(cancelled));
            return without_gil([&] { return gelight::exact_isolines(self.field, level, hook); });
          },
          "level"_a, "cancelled"_a = py::none(),
          "The points at one distance as circular arcs, a list of ExactIsolines. Raises ValueError "
          "for a field that has not kept its windows (keep_windows=True).")
      .def(
          "area_within",
          [](const FieldOn& self, double level, py::object cancelled) {
            const auto hook = hook_of(std::move(cancelled));
            return without_gil([&] { return gelight::area_within(self.field, level, hook); });
          },
          "level"_a, "cancelled"_a = py::none(),
          "The area that is nearer than a level, in squared units of the positions. Raises as "
          "`isolines` does.");
}

void bind_arcs(py::module_& m) {
  using Arc = gelight::CircularArc<double>;
  using Line = gelight::ExactIsoline<double>;
  py::class_<Arc>(m, "CircularArc", "A piece of a circle in the plane of one face.")
      .def_readonly("face", &Arc::face, "In which it lies.")
      .def_property_readonly(
          "begin", [](const Arc& a) { return array_of(a.begin); }, "One end, float64 (3,).")
      .def_property_readonly(
          "end", [](const Arc& a) { return array_of(a.end); }, "The other end, float64 (3,).")
      .def_property_readonly(
          "centre", [](const Arc& a) { return array_of(a.centre); },
          "Of the circle, float64 (3,): the source laid flat into the face's plane.")
      .def_readonly("radius", &Arc::radius, "Of the circle; infinite where the arc is straight.")
      .def_readonly("angle", &Arc::angle, "By which it turns about the centre, in radians.")
      .def_readonly("length", &Arc::length, "How long it is.");
  py::class_<Line>(m, "ExactIsoline", "The points at one distance, as arcs one after the other.")
      .def_readonly("arcs", &Line::arcs, "Each begins where the one before ends.")
      .def_readonly("is_closed", &Line::is_closed, "Whether the first begins where the last ends.")
      .def_property_readonly("length", &Line::length, "How long it is.");
}

// A path is a curve to start from, as a chain of segments.
Field solved(const Solver& solver, py::handle sources) {
  if (py::isinstance<PathOn>(sources)) {
    const auto pieces = gelight::segments(sources.cast<const PathOn&>().points);
    return without_gil(
        [&] { return solver.solve(std::span<const gelight::Segment<double>>(pieces)); });
  }
  const auto from = sources_in(sources);
  return without_gil([&] { return solver.solve(std::span<const gelight::Source<double>>(from)); });
}

void bind_borders(py::module_& m) {
  py::class_<BorderOn>(m, "VoronoiEdge",
                       "A line between the cells of two sources: its points are as far from the "
                       "one as from the other.")
      .def_readonly("sources", &BorderOn::sources,
                    "Their numbers in the solve, the lesser first, whose cell lies to the left, as "
                    "seen from where the faces' vertices are counter-clockwise.")
      .def_readonly("points", &BorderOn::points,
                    "On it, a Path; of a closed one the first is the last.")
      .def_readonly("is_closed", &BorderOn::is_closed, "Whether it ends where it begins.");
  m.def(
      "exact_voronoi_edges",
      [](const FieldOn& field, double deviation, py::object cancelled) {
        const gelight::VoronoiEdgeOptions<double> options{deviation, hook_of(std::move(cancelled))};
        const auto lines =
            without_gil([&] { return gelight::exact_voronoi_edges(field.field, options); });
        std::vector<BorderOn> out;
        for (const auto& line : lines) {
          out.push_back({line.sources, {field.surface, line.points}, line.is_closed});
        }
        return out;
      },
      "field"_a, py::kw_only(), "deviation"_a = 1e-3, "cancelled"_a = py::none(),
      "The lines between the cells of an ExactField's sources, inside of faces, a list of "
      "VoronoiEdges: branches of hyperbolas, straight where sources start alike, whose points lie "
      "on them to rounding (Liu, Chen, Tang 2011, doi:10.1109/TPAMI.2010.221).\n\n"
      "deviation: how far the straight pieces between points may leave the line, about, as a share "
      "of the longest side of their face. Raises ValueError for a field that has not kept its "
      "windows (keep_windows=True), one of a Path, one solved up to a greatest distance or for "
      "targets, and a deviation that is not positive.");
}

}  // namespace

void bind_exact(py::module_& m) {
  bind_ways(m);
  bind_arcs(m);
  bind_field(m);
  bind_borders(m);
  auto solver = py::class_<Solver>(
      m, "ExactSolver",
      "Exact geodesic distances on the polyhedron, by windows on its edges (Mitchell, Mount, "
      "Papadimitriou 1987, doi:10.1137/0216045), with paths and directions.");
  solver.def(
      py::init([](const Surface& surface, double max_distance, py::object targets,
                  bool keep_windows, std::size_t max_memory, double reset_radius,
                  py::object cancelled) {
        gelight::ExactOptions<double> options;
        options.max_distance = max_distance;
        if (!targets.is_none()) options.targets = points_or_places_in(targets, py::none());
        options.keep_windows = keep_windows;
        options.max_memory = max_memory;
        options.reset_radius = reset_radius;
        options.cancelled = hook_of(std::move(cancelled));
        return without_gil([&] { return Solver(surface, options); });
      }),
      "surface"_a, py::kw_only(), "max_distance"_a = gelight::unreachable<double>,
      "targets"_a = py::none(), "keep_windows"_a = false,
      "max_memory"_a = std::numeric_limits<std::size_t>::max(),
      "reset_radius"_a = gelight::unreachable<double>, "cancelled"_a = py::none(),
      "max_distance: farther vertices are +inf. targets: so are those beyond the farthest of these "
      "vertices or SurfacePoints. keep_windows: queries at points that are no vertices look at "
      "their own face only; about 50 bytes each, some dozens per edge. max_memory: of windows, in "
      "bytes; beyond it MemoryLimit is raised. reset_radius: a dial between Dijkstra and exact, in "
      "mean edge lengths.");
  bind_distances(solver);
  solver.def(
      "solve",
      [](const Solver& self, py::handle sources) {
        return FieldOn{self.surface(), solved(self, sources)};
      },
      "sources"_a,
      "Solves from a vertex, a SurfacePoint or a Source, from several of them, or from a Path, "
      "from the nearest point of which distances then count.");
}
