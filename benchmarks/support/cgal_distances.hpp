#pragma once

// CGAL's exact and heat distances.

#include <CGAL/Heat_method_3/Surface_mesh_geodesic_distances_3.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <vector>

#include "gelight/mesh/shapes.hpp"

namespace gelight::bench::cgal {

using Kernel = CGAL::Simple_cartesian<double>;
using CgalMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = CgalMesh::Vertex_index;
using Number = CgalMesh::size_type;
using ShortestPath =
    CGAL::Surface_mesh_shortest_path<CGAL::Surface_mesh_shortest_path_traits<Kernel, CgalMesh>>;
using Heat = CGAL::Heat_method_3::Surface_mesh_geodesic_distances_3<CgalMesh>;
using Distances = std::vector<double>;

inline CgalMesh to_cgal(const Mesh<double>& mesh) {
  CgalMesh out;
  for (const auto& p : mesh.positions) out.add_vertex({p[0], p[1], p[2]});
  for (const auto& [a, b, c] : mesh.faces) {
    out.add_face(Vertex(static_cast<Number>(a)), Vertex(static_cast<Number>(b)),
                 Vertex(static_cast<Number>(c)));
  }
  return out;
}

inline Distances exact_distances(const CgalMesh& mesh, ShortestPath& paths, Index source) {
  paths.remove_all_source_points();
  paths.add_source_point(Vertex(static_cast<Number>(source)));
  paths.build_sequence_tree();
  Distances out;
  for (const auto v : mesh.vertices()) {
    out.push_back(paths.shortest_distance_to_source_points(v).first);
  }
  return out;
}

inline Distances heat_distances(const CgalMesh& mesh, CgalMesh::Property_map<Vertex, double> map,
                                Heat& heat, Index source) {
  heat.clear_sources();
  heat.add_source(Vertex(static_cast<Number>(source)));
  heat.estimate_geodesic_distances(map);
  Distances out;
  for (const auto v : mesh.vertices()) out.push_back(map[v]);
  return out;
}

}  // namespace gelight::bench::cgal
