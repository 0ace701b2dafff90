#include "points.hpp"

#include "gelight/geodesic/path.hpp"
#include "topics.hpp"

using Kind = Point::Kind;
using Sources = std::vector<gelight::Source<double>>;
using namespace py::literals;

Point point_in(py::handle object) {
  if (py::isinstance<Point>(object)) return object.cast<const Point&>();
  return gelight::vertex_point<double>(index_in(object, "vertex"));
}

namespace {

bool is_one(py::handle object) {
  return PyIndex_Check(object.ptr()) != 0 && !py::isinstance<py::array>(object);
}

gelight::Source<double> source_in(py::handle object) {
  if (py::isinstance<gelight::Source<double>>(object)) {
    return object.cast<const gelight::Source<double>&>();
  }
  return {point_in(object), 0};
}

bool is_place(py::handle object) {
  return is_one(object) || py::isinstance<Point>(object) ||
         py::isinstance<gelight::Source<double>>(object);
}

py::sequence sequence_in(py::handle object) {
  if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object) ||
      py::isinstance<py::bytes>(object) || PyByteArray_Check(object.ptr()) != 0) {
    throw py::type_error(py::repr(object).cast<std::string>() + " is neither a vertex nor a point");
  }
  return py::reinterpret_borrow<py::sequence>(object);
}

}  // namespace

Sources sources_in(py::handle object) {
  if (is_place(object)) return {source_in(object)};
  Sources sources;
  if (py::isinstance<py::array>(object)) {
    const auto vertices = indices_in(object, "sources");
    gelight::detail::require(vertices.ndim() <= 1, "sources has shape ", shape_text(vertices));
    for (const Index v : span_of(vertices)) sources.push_back({gelight::vertex_point<double>(v)});
    return sources;
  }
  for (const py::handle one : sequence_in(object)) sources.push_back(source_in(one));
  return sources;
}

std::vector<Point> points_in(py::handle faces, py::handle barycentric) {
  const auto f = indices_in(faces, "faces");
  const auto w = rows_in<double, 3>(barycentric, "barycentric");
  const auto weights = rows_of<3>(w);
  gelight::detail::require(f.ndim() == 1 && f.size() == static_cast<py::ssize_t>(weights.size()),
                           "faces has shape ", shape_text(f), ", barycentric ", shape_text(w));
  std::vector<Point> points;
  points.reserve(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    // Shares that are floats sum to 1 in their own rounding only.
    const double sum = weights[i][0] + weights[i][1] + weights[i][2];
    const bool is_rounded = std::abs(sum - 1) < 1e-6;
    std::array<double, 3> shares = weights[i];
    for (double& share : shares) share = is_rounded ? share / sum : share;
    points.push_back(gelight::face_point<double>(f.data()[i], shares));
  }
  return points;
}

std::vector<Point> points_or_places_in(py::handle points, py::handle barycentric) {
  if (!barycentric.is_none()) return points_in(points, barycentric);
  std::vector<Point> out;
  for (const auto& source : sources_in(points)) out.push_back(source.point);
  return out;
}

namespace {

py::object element_of(const Point& p) {
  if (p.kind == Kind::edge) return py::make_tuple(p.element[0], p.element[1]);
  return py::int_(p.element[0]);
}

py::tuple weights_of(const Point& p) {
  if (p.kind == Kind::vertex) return py::make_tuple(p.weights[0]);
  if (p.kind == Kind::edge) return py::make_tuple(p.weights[0], p.weights[1]);
  return py::make_tuple(p.weights[0], p.weights[1], p.weights[2]);
}

std::string name_of(const Point& p) {
  const char* const kinds[] = {"vertex", "edge", "face"};
  return std::string("<gelight.SurfacePoint: ") + kinds[static_cast<int>(p.kind)] + " " +
         py::str(element_of(p)).cast<std::string>() + ", " +
         py::str(weights_of(p)).cast<std::string>() + ">";
}

void bind_point(py::module_& m) {
  py::class_<Point>(m, "SurfacePoint",
                    "A point of a surface: a vertex, or on an edge, or in a face.")
      .def_property_readonly(
          "kind",
          [](const Point& p) {
            return p.kind == Kind::vertex ? "vertex" : p.kind == Kind::edge ? "edge" : "face";
          },
          "What it lies on: 'vertex', 'edge' or 'face'.")
      .def_property_readonly("element", element_of,
                             "The vertex, the edge's two vertices, or the face.")
      .def_property_readonly("weights", weights_of,
                             "Its shares of the vertex, of the edge's vertices or of the face's.")
      .def(
          "__eq__", [](const Point& a, const Point& b) { return a == b; }, py::is_operator(),
          "other"_a, "Whether element and weights are equal.")
      .def("__repr__", name_of);
  m.def(
      "vertex_point",
      [](py::handle vertex) { return gelight::vertex_point<double>(index_in(vertex, "vertex")); },
      "vertex"_a, "A vertex as a point.");
  m.def(
      "edge_point",
      [](py::handle v0, py::handle v1, double t) {
        return gelight::edge_point<double>(index_in(v0, "vertex"), index_in(v1, "vertex"), t);
      },
      "v0"_a, "v1"_a, "t"_a,
      "The point (1 - t) v0 + t v1 of the edge between two vertices, 0 <= t <= 1.");
  m.def(
      "face_point",
      [](py::handle face, const std::array<double, 3>& barycentric) {
        return gelight::face_point<double>(index_in(face, "face"), barycentric);
      },
      "face"_a, "barycentric"_a,
      "The point of a face with these barycentric coordinates, which are not negative and sum to "
      "1.");
  py::class_<gelight::Source<double>>(
      m, "Source",
      "Where a distance starts, and the distance it starts with (in the unit of the positions).")
      .def(py::init([](py::handle point, double distance) {
             return gelight::Source<double>{point_in(point), distance};
           }),
           "point"_a, "distance"_a = 0.0, "A vertex or a SurfacePoint, and a start distance.")
      .def_readonly("point", &gelight::Source<double>::point, "Where.")
      .def_readonly("distance", &gelight::Source<double>::distance, "With how much.");
}

void bind_path(py::module_& m) {
  py::class_<PathOn>(
      m, "Path",
      "A polyline on a surface; each piece lies in one face or along one edge. A sequence of "
      "SurfacePoints.")
      .def(py::init([](const Surface& surface, py::handle points) {
             PathOn path{surface, {}};
             for (const auto& source : sources_in(points)) path.points.push_back(source.point);
             for (const Point& p : path.points) surface.require_point(p);
             return path;
           }),
           "surface"_a, "points"_a,
           "Of vertices and SurfacePoints in a row. Raises ValueError for one that is not of the "
           "surface.")
      .def_property_readonly(
          "positions",
          [](const PathOn& path) { return array_of(positions(path.surface, path.points)); },
          "The positions of its points, float64 (n, 3).")
      .def_property_readonly(
          "faces",
          [](const PathOn& path) { return array_of(faces_along(path.surface, path.points)); },
          "A face that holds each piece, int32 (n - 1,); of several the least.")
      .def_property_readonly(
          "length", [](const PathOn& path) { return length(path.surface, path.points); },
          "Its length, in the unit of the positions.")
      .def("__len__", [](const PathOn& path) { return path.points.size(); })
      .def(
          "__getitem__",
          [](const PathOn& path, py::ssize_t i) {
            const auto count = static_cast<py::ssize_t>(path.points.size());
            if (i < 0) i += count;
            if (i < 0 || i >= count)
              throw py::index_error("a path of " + std::to_string(count) + " points has no point " +
                                    std::to_string(i));
            return path.points[static_cast<std::size_t>(i)];
          },
          "index"_a);
}

}  // namespace

void bind_points(py::module_& m) { bind_point(m); }

// After the surface, which their signatures name.
void bind_paths_on(py::module_& m) { bind_path(m); }
