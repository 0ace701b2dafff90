#pragma once

// Points, sources and paths on a surface, as Python names them.

#include <array>
#include <utility>
#include <vector>

#include "arrays.hpp"

/// A path with the surface that it is on.
struct PathOn {
  Surface surface;
  gelight::Path<double> points;
};

/// A line between the cells of two sources.
struct BorderOn {
  std::array<Index, 2> sources;
  PathOn points;
  bool is_closed;
};

/// A vertex' number or a SurfacePoint.
Point point_in(py::handle object);
/// One or several vertices, SurfacePoints or Sources.
std::vector<gelight::Source<double>> sources_in(py::handle object);
/// Points inside of faces, from arrays (n,) and (n, 3). Throws ValueError for other shapes.
std::vector<Point> points_in(py::handle faces, py::handle barycentric);
/// The same, or one or several vertices and SurfacePoints where there is no second array.
std::vector<Point> points_or_places_in(py::handle points, py::handle barycentric);

template <class T>
std::vector<gelight::SurfacePoint<T>> cast_points(const std::vector<Point>& points) {
  std::vector<gelight::SurfacePoint<T>> out;
  out.reserve(points.size());
  for (const Point& p : points) out.push_back(p.template cast<T>());
  return out;
}
