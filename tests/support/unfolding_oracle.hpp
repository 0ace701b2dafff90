#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "gelight/mesh/surface_point.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight::test {

/// Exact distances by brute force, for small meshes: from every vertex the cone of sight is
/// unfolded over every sequence of faces that a straight line can cross, in long double and without
/// a queue; then Dijkstra over all pairs of vertices that see each other. It shares no code with
/// the solver.
class UnfoldingOracle {
 public:
  explicit UnfoldingOracle(const Mesh<double>& mesh) : mesh_(mesh) {
    const std::size_t n = mesh.positions.size();
    faces_of_vertex_.resize(n);
    visited_.assign(mesh.faces.size(), false);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
        faces_of_vertex_[at(a)].push_back(f);
        faces_of_edge_[std::minmax(a, b)].push_back(f);
      }
    }
    for (std::size_t v = 0; v < n; ++v) sight_.push_back(seen_from_vertex(static_cast<Index>(v)));
  }

  /// Distance of every vertex from the nearest of several points with start distances.
  [[nodiscard]] std::vector<double> distance(std::span<const Source<double>> sources) {
    const std::size_t n = sight_.size();
    std::vector<Real> best(n, infinity);
    for (const auto& source : sources) {
      const std::vector<Real> seen = seen_from(source.point);
      for (std::size_t v = 0; v < n; ++v) best[v] = std::min(best[v], source.distance + seen[v]);
    }
    std::vector<bool> done(n, false);
    for (std::size_t round = 0; round < n; ++round) {
      std::size_t u = n;
      for (std::size_t v = 0; v < n; ++v) {
        if (!done[v] && (u == n || best[v] < best[u])) u = v;
      }
      done[u] = true;
      for (std::size_t v = 0; v < n; ++v) best[v] = std::min(best[v], best[u] + sight_[u][v]);
    }
    return {best.begin(), best.end()};
  }

 private:
  using Real = long double;
  using Point2 = Eigen::Matrix<Real, 2, 1>;
  using Point3 = Eigen::Matrix<Real, 3, 1>;
  using Kind = SurfacePoint<double>::Kind;
  static constexpr Real infinity = std::numeric_limits<Real>::infinity();
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

  // A corner of a face, laid in a plane in which the viewpoint is at the origin.
  struct Corner {
    Index vertex;
    Point2 point;
  };

  [[nodiscard]] Point3 position(Index v) const {
    const auto& p = mesh_.positions[at(v)];
    return {p[0], p[1], p[2]};
  }

  [[nodiscard]] Point3 position(const SurfacePoint<double>& point) const {
    const auto& [a, b] = point.element;
    if (point.kind == Kind::vertex) return position(a);
    const auto corner = point.kind == Kind::face ? mesh_.faces[at(a)] : std::array<Index, 3>{a, b};
    Point3 sum(0, 0, 0);
    for (std::size_t k = 0; k < (point.kind == Kind::face ? 3 : 2); ++k) {
      sum += Real{point.weights[k]} * position(corner[k]);
    }
    return sum;
  }

  std::vector<Real> seen_from_vertex(Index v) {
    return seen_from({Kind::vertex, {v, -1}, {1, 0, 0}});
  }

  // Straight distance of every vertex in sight of a point.
  std::vector<Real> seen_from(const SurfacePoint<double>& point) {
    seen_.assign(mesh_.positions.size(), infinity);
    const auto& [a, b] = point.element;
    if (point.kind == Kind::vertex) {
      seen_[at(a)] = 0;
      for (const std::size_t f : faces_of_vertex_[at(a)]) look_out_of(f, position(point));
    } else if (point.kind == Kind::edge) {
      for (const std::size_t f : faces_of_edge_.at(std::minmax(a, b))) {
        look_out_of(f, position(point));
      }
    } else {
      look_out_of(at(a), position(point));
    }
    return seen_;
  }

  void look_out_of(std::size_t f, const Point3& from) {
    const auto& face = mesh_.faces[f];
    visited_[f] = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = face[k], b = face[(k + 1) % 3];
      const Point3 p = position(a) - from, q = position(b) - from;
      see(a, p.norm());
      const Real length = p.norm(), area = p.cross(q).norm();
      // Seen along its own line, an edge hides nothing: its ends are the bends of such paths.
      if (area <= 1e-15L * p.norm() * q.norm()) continue;
      const Corner right{a, {length, 0}}, left{b, {p.dot(q) / length, area / length}};
      cross_edge(right, left, right.point, left.point);
    }
    visited_[f] = false;
  }

  // Sight goes on over the edge between two corners, between two directions.
  void cross_edge(const Corner& right, const Corner& left, const Point2& right_sight,
                  const Point2& left_sight) {
    for (const std::size_t f : faces_of_edge_.at(std::minmax(right.vertex, left.vertex))) {
      if (visited_[f]) continue;  // a shortest path crosses a face once
      visited_[f] = true;
      const Corner apex = unfold(f, right, left);
      const Real to_left = cross(apex.point, left_sight), to_right = cross(right_sight, apex.point);
      const Real slack = 1e-17L * apex.point.norm();
      if (to_left >= -slack * left_sight.norm() && to_right >= -slack * right_sight.norm()) {
        see(apex.vertex, apex.point.norm());
      }
      if (to_right > 0) cross_edge(right, apex, right_sight, to_left > 0 ? apex.point : left_sight);
      if (to_left > 0) cross_edge(apex, left, to_right > 0 ? apex.point : right_sight, left_sight);
      visited_[f] = false;
    }
  }

  // The third corner of a face, on the far side of an edge.
  [[nodiscard]] Corner unfold(std::size_t f, const Corner& right, const Corner& left) const {
    Index apex = -1;
    for (const Index v : mesh_.faces[f]) {
      if (v != right.vertex && v != left.vertex) apex = v;
    }
    const Point3 e = position(left.vertex) - position(right.vertex);
    const Point3 a = position(apex) - position(right.vertex);
    const Real along = e.dot(a) / e.squaredNorm(), up = e.cross(a).norm() / e.squaredNorm();
    const Point2 d = left.point - right.point;
    return {apex, right.point + along * d + up * Point2(d.y(), -d.x())};
  }

  static Real cross(const Point2& a, const Point2& b) { return a.x() * b.y() - a.y() * b.x(); }

  void see(Index v, Real distance) { seen_[at(v)] = std::min(seen_[at(v)], distance); }

  const Mesh<double> mesh_;
  std::vector<std::vector<std::size_t>> faces_of_vertex_;
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> faces_of_edge_;
  std::vector<std::vector<Real>> sight_;  // straight distance of each pair of vertices
  std::vector<Real> seen_;
  std::vector<bool> visited_;
};

}  // namespace gelight::test
