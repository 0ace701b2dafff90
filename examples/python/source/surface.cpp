// Meshes: their snapshot, what is wrong with them, and shapes to begin with.

#include <sstream>

#include "arrays.hpp"
#include "gelight/mesh/check.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/shapes.hpp"
#include "hook.hpp"
#include "points.hpp"
#include "topics.hpp"

using namespace py::literals;
using Mesh = gelight::Mesh<double>;

namespace {

// Calls work(mesh) with a view of the caller's arrays, in their own precision where that is known.
template <class Work>
auto with_mesh(py::handle vertices, py::handle faces, const Work& work) {
  const py::array array = array_in(vertices, "fiu", "vertices");
  const Packed<Index> f = faces_in(faces);
  const auto view = [&]<class T>(const Packed<T>& v) {
    return without_gil([&] { return work(gelight::MeshView<T>(rows_of<3>(v), rows_of<3>(f))); });
  };
  if (has_type<float>(array)) {
    return view(rows_in<float, 3>(array, "vertices"));
  }
  return view(rows_in<double, 3>(array, "vertices"));
}

Surface surface_of(py::handle vertices, py::handle faces) {
  return with_mesh(vertices, faces, [](const auto& mesh) { return Surface(mesh); });
}

py::array_t<double> positions_of(const py::object& self) {
  const auto& surface = self.cast<const Surface&>();
  return read_only(py::array_t<double>({py::ssize_t{surface.vertex_count()}, py::ssize_t{3}},
                                       surface.position(0).data(), self));
}

py::array_t<Index> faces_of(const Surface& surface) {
  std::vector<std::array<Index, 3>> faces;
  faces.reserve(static_cast<std::size_t>(surface.face_count()));
  for (Index f = 0; f < surface.face_count(); ++f) faces.push_back(surface.face(f));
  return array_of(std::move(faces));
}

void bind_snapshot(py::module_& m) {
  py::class_<Surface>(
      m, "Surface",
      "An immutable snapshot of a triangle mesh, with its half-edges: what every solver takes.\n\n"
      "Edges may be shared by any number of faces, oriented any way; vertices may be bow-ties or "
      "belong to no face. Copies share their memory.")
      .def(py::init(&surface_of), "vertices"_a, "faces"_a,
           "Of positions (n, 3), float32 or float64, and faces (m, 3), whole numbers.\n\n"
           "Raises ValueError for a mesh without faces, a coordinate that is not finite or beyond "
           "1e75, a face with an index out of range or a vertex twice, and two faces with the same "
           "three vertices. `check` tells all of that at once, `repair` mends it.")
      .def_property_readonly("vertices", &positions_of,
                             "Positions, float64 (n, 3): the surface's own memory, read-only.")
      .def_property_readonly("faces", &faces_of, "The vertices of each face, int32 (m, 3).")
      .def_property_readonly("vertex_count", &Surface::vertex_count, "How many vertices there are.")
      .def_property_readonly("face_count", &Surface::face_count, "How many faces there are.")
      .def_property_readonly(
          "components",
          [](const Surface& surface) { return array_of(std::vector<Index>(surface.components())); },
          "For each vertex the smallest vertex that faces join it to, int32 (n,).")
      .def(
          "position",
          [](const Surface& surface, py::handle point) {
            return array_of(surface.position(point_in(point)));
          },
          "point"_a, "Where a vertex or SurfacePoint is, float64 (3,).")
      .def("__repr__", [](const Surface& surface) {
        return "<gelight.Surface: " + std::to_string(surface.vertex_count()) + " vertices, " +
               std::to_string(surface.face_count()) + " faces>";
      });
  m.def(
      "nearest_vertex",
      [](const Surface& surface, py::handle position) {
        return gelight::nearest_vertex(surface, vector_in(position, "position"));
      },
      "surface"_a, "position"_a, "The vertex nearest to a position in space. Cost: O(vertices).");
  m.def(
      "nearest_point",
      [](const Surface& surface, py::handle position) {
        return gelight::nearest_point(surface, vector_in(position, "position"));
      },
      "surface"_a, "position"_a,
      "The point of the surface nearest to a position in space. Cost: O(faces).");
}

py::tuple finding_of(const gelight::Finding& finding) {
  return py::make_tuple(finding.count, finding.first);
}

void bind_check(py::module_& m) {
  using gelight::MeshReport;
  auto report = py::class_<MeshReport>(
      m, "MeshReport",
      "What is unusual about a mesh. Each finding is (how many, the first of them).");
  report.def_readonly("vertices", &MeshReport::vertices, "How many the mesh has.")
      .def_readonly("faces", &MeshReport::faces, "How many the mesh has.")
      .def_readonly("components", &MeshReport::components, "Parts with no path between them.")
      .def_readonly("is_too_small", &MeshReport::is_too_small,
                    "Whether no edge is as long as 1e-75, though some have length.")
      .def_property_readonly("is_accepted", &MeshReport::is_accepted,
                             "Whether a Surface, and so every distance solver, can be made of it.")
      .def_property_readonly("is_oriented", &MeshReport::is_oriented,
                             "Whether VectorHeatSolver takes it too.")
      .def("__str__", [](const MeshReport& found) {
        std::ostringstream text;
        text << found;
        return text.str();
      });
  const auto add = [&](const char* name, auto member, const char* doc) {
    report.def_property_readonly(
        name, [member](const MeshReport& found) { return finding_of(found.*member); }, doc);
  };
  add("not_finite", &MeshReport::not_finite, "Vertices with a coordinate that is not finite.");
  add("too_far", &MeshReport::too_far, "Vertices with a coordinate beyond 1e75.");
  add("out_of_range", &MeshReport::out_of_range, "Faces with an index that is no vertex.");
  add("repeated_vertices", &MeshReport::repeated_vertices, "Faces with a vertex twice.");
  add("repeated_faces", &MeshReport::repeated_faces,
      "Faces with the three vertices of an earlier one.");
  add("too_long", &MeshReport::too_long,
      "Faces with an edge longer than the coordinates' type holds.");
  add("nonmanifold_edges", &MeshReport::nonmanifold_edges,
      "First vertices of edges with more than two faces.");
  add("misoriented_edges", &MeshReport::misoriented_edges,
      "First vertices of edges whose two faces are oriented against each other.");
  add("degenerate_faces", &MeshReport::degenerate_faces, "Faces of (almost) no area.");
  add("zero_edges", &MeshReport::zero_edges, "First vertices of edges of no length.");
  add("duplicate_vertices", &MeshReport::duplicate_vertices,
      "Vertices at the position of an earlier one: a seam, uncrossed.");
  add("unused_vertices", &MeshReport::unused_vertices, "Vertices in no face: infinitely far.");
  add("nonmanifold_vertices", &MeshReport::nonmanifold_vertices,
      "Vertices whose faces form more than one fan.");
  add("border_edges", &MeshReport::border_edges, "First vertices of edges with one face.");
  m.def(
      "check",
      [](py::handle vertices, py::handle faces, py::object cancelled) {
        const auto hook = hook_of(std::move(cancelled));
        return with_mesh(vertices, faces,
                         [&](const auto& mesh) { return gelight::check(mesh, {}, hook); });
      },
      "vertices"_a, "faces"_a, py::kw_only(), "cancelled"_a = py::none(),
      "Tells everything about a mesh that a solver refuses or that may not be what was meant; "
      "changes nothing and takes any mesh. Cost: O(vertices + faces log faces).");
}

void bind_repair(py::module_& m) {
  using Repaired = gelight::Repaired<double>;
  py::class_<Repaired>(m, "Repaired", "A repaired mesh, and what was done to it.")
      .def_property_readonly(
          "vertices", [](const Repaired& r) { return array_of(std::vector(r.mesh.positions)); },
          "Positions, float64 (n, 3).")
      .def_property_readonly(
          "faces", [](const Repaired& r) { return array_of(std::vector(r.mesh.faces)); },
          "The vertices of each face, int32 (m, 3).")
      .def_property_readonly(
          "vertex_of", [](const Repaired& r) { return array_of(std::vector(r.vertex_of)); },
          "Of each vertex: which it was, int32 (n,).")
      .def_property_readonly(
          "face_of", [](const Repaired& r) { return array_of(std::vector(r.face_of)); },
          "Of each face: which it was, int32 (m,).")
      .def_readonly("welded_vertices", &Repaired::welded_vertices, "That became an earlier one.")
      .def_readonly("dropped_faces", &Repaired::dropped_faces,
                    "Unusable, equal, collapsed or degenerate.")
      .def_readonly("turned_faces", &Repaired::turned_faces, "To agree with their neighbours.")
      .def_readonly("added_vertices", &Repaired::added_vertices, "Copies made by splitting.")
      .def_readonly("dropped_vertices", &Repaired::dropped_vertices, "In no face.");
  m.def(
      "repair",
      [](py::handle vertices, py::handle faces, bool drop_unusable_faces,
         std::optional<double> weld_distance, bool drop_degenerate_faces, double flat, bool orient,
         bool split_vertices, bool drop_unused_vertices, bool order_in_space,
         py::object cancelled) {
        const gelight::RepairOptions options{
            drop_unusable_faces, weld_distance,        drop_degenerate_faces, flat, orient,
            split_vertices,      drop_unused_vertices, order_in_space};
        const auto hook = hook_of(std::move(cancelled));
        const Packed<double> v = rows_in<double, 3>(vertices, "vertices");
        const Packed<Index> f = faces_in(faces);
        return without_gil([&] {
          return gelight::repair(gelight::MeshView<double>(rows_of<3>(v), rows_of<3>(f)), options,
                                 hook);
        });
      },
      "vertices"_a, "faces"_a, py::kw_only(), "drop_unusable_faces"_a = false,
      "weld_distance"_a = py::none(), "drop_degenerate_faces"_a = false, "flat"_a = 1e-12,
      "orient"_a = false, "split_vertices"_a = false, "drop_unused_vertices"_a = false,
      "order_in_space"_a = false, "cancelled"_a = py::none(),
      "Copies a mesh and mends what is named, in this order; nothing that was not asked for.\n\n"
      "drop_unusable_faces: what Surface refuses. weld_distance: each vertex at most so far from "
      "an earlier one becomes that one, in the unit of the positions. drop_degenerate_faces: whose "
      "height is at most `flat` times their longest edge. orient: turns faces to agree. "
      "split_vertices: each fan gets its own copy of a vertex. drop_unused_vertices: in no face. "
      "order_in_space: numbers vertices and faces along a curve that fills space, which makes "
      "solvers quicker on large meshes that came in no such order.");
}

void bind_shapes(py::module_& m) {
  m.def(
      "grid",
      [](Index columns, Index rows, double width, double height) {
        return Surface(gelight::grid<double>(columns, rows, width, height));
      },
      "columns"_a, "rows"_a, "width"_a = 1.0, "height"_a = 1.0,
      "A flat sheet over [0, width] x [0, height], of columns x rows cells of two triangles.");
  m.def(
      "icosphere",
      [](int level, double radius) { return Surface(gelight::icosphere<double>(level, radius)); },
      "level"_a, "radius"_a = 1.0,
      "A sphere about the origin, an icosahedron split `level` times: 10 4^level + 2 vertices.");
  m.def(
      "box", [](double x, double y, double z) { return Surface(gelight::box<double>(x, y, z)); },
      "x"_a, "y"_a, "z"_a, "An axis-aligned box about the origin, of 8 vertices.");
  m.def(
      "torus",
      [](double major_radius, double minor_radius, Index around, Index across) {
        return Surface(gelight::torus<double>(major_radius, minor_radius, around, across));
      },
      "major_radius"_a, "minor_radius"_a, "around"_a, "across"_a, "A ring about the z axis.");
  m.def(
      "membrane",
      [](double radius, double length, double edge_length) {
        return Surface(gelight::membrane<double>(radius, length, edge_length));
      },
      "radius"_a = 0.01146, "length"_a = 0.0455, "edge_length"_a = 0.001,
      "The membrane of a fingertip sensor: an open cylinder about the z axis from z = 0, closed by "
      "a hemisphere whose tip is at z = length. The defaults are the GelTip's, in m.");
  m.def(
      "revolve",
      [](py::handle profile, double edge_length) {
        const auto rows = rows_in<double, 2>(profile, "profile");
        std::vector<gelight::ProfilePoint<double>> points;
        for (const auto& [radius, z] : rows_of<2>(rows)) points.push_back({radius, z});
        return Surface(gelight::revolve<double>(points, edge_length));
      },
      "profile"_a, "edge_length"_a,
      "The surface that an outline sweeps when it turns about the z axis: each point (distance "
      "from "
      "the axis, height) of the profile (n, 2) becomes a ring of vertices about `edge_length` "
      "apart, or one vertex on the axis. Upwards on the outside has its normals outwards.\n\n"
      "Raises ValueError for fewer than two points, a negative radius, two neighbours on the axis, "
      "or an edge length that is not positive or makes more vertices than can be counted.");
  m.def(
      "joined",
      [](const std::vector<Surface>& parts) {
        Mesh whole;
        for (const Surface& part : parts) {
          const auto first = static_cast<Index>(whole.positions.size());
          for (Index v = 0; v < part.vertex_count(); ++v) {
            const auto& p = part.position(v);
            whole.positions.push_back({p[0], p[1], p[2]});
          }
          for (Index f = 0; f < part.face_count(); ++f) {
            const auto [a, b, c] = part.face(f);
            whole.faces.push_back({first + a, first + b, first + c});
          }
        }
        return Surface(whole);
      },
      "parts"_a, "Several meshes as one, in the order given, sharing nothing.");
}

}  // namespace

void bind_surface(py::module_& m) {
  bind_snapshot(m);
  bind_check(m);
  bind_repair(m);
  bind_shapes(m);
}
