#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>

#include "gelight/core/array.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/tolerance.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/marching/fan_walk.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What there is for each corner of the faces, grouped by the corners' vertices.
template <class T>
struct GroupedByVertex {
  Array<T> values;
  Array<Index> begin;

  [[nodiscard]] Slice<const T> at(Index vertex) const {
    return {values.data() + begin[vertex],
            static_cast<std::size_t>(begin[vertex + 1] - begin[vertex])};
  }
};

/// The vertices and faces of a mesh, in 48 bytes a vertex, with what sources ask a Surface: for
/// methods that need no more of it. A mesh too.
template <std::floating_point Real>
class FaceList {
 public:
  using Scalar = Real;

  /// Of a mesh as `read_mesh` reads it. Its maker is to check what is not seen face by face: that
  /// no two have the same vertices, and that edges have a length.
  explicit FaceList(MeshArrays<Real> mesh)
      : positions_(std::move(mesh.positions)), vertices_(std::move(mesh.vertices)) {}

  /// Throws InvalidInput as Surface does for what its maker saw.
  [[noreturn, gnu::cold, gnu::noinline]] void refuse_faces() const {
    using namespace arithmetic;
    Array<std::array<Index, 4>> faces;  // vertices in ascending order, and the face's number
    double longest = 0;
    for (Index f = 0; f < face_count(); ++f) {
      const auto [a, b, c] = face(f);
      const Index least = std::min({a, b, c}), most = std::max({a, b, c});
      faces.push_back({least, a ^ b ^ c ^ least ^ most, most, f});
      for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
        const double length =
            stable_norm(cast<double>(positions_[to]) - cast<double>(positions_[from]));
        longest = std::max(longest, length);
      }
    }
    std::make_heap(faces.begin(), faces.end());
    std::sort_heap(faces.begin(), faces.end());  // less to compile than std::sort
    const auto same =
        std::adjacent_find(faces.begin(), faces.end(), [](const auto& one, const auto& other) {
          return one[0] == other[0] && one[1] == other[1] && one[2] == other[2];
        });
    if (same != faces.end()) refuse_twin_faces((*same)[3], (*(same + 1))[3]);
    refuse_short_edges(longest);
  }

  /// The parts of the mesh, numbered as they were there.
  ///@{
  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(positions_.size()); }
  [[nodiscard]] Index face_count() const { return static_cast<Index>(vertices_.size() / 3); }
  [[nodiscard]] const Vec3<Real>& position(Index vertex) const { return positions_[vertex]; }
  [[nodiscard]] std::array<Index, 3> face(Index f) const {
    const Index* v = vertices_.data() + 3 * std::ptrdiff_t{f};
    return {v[0], v[1], v[2]};
  }
  ///@}

  /// The vertex where a half-edge starts, numbered as in Surface, where it ends, and the one across
  /// the face.
  ///@{
  [[nodiscard]] Index origin(Index h) const { return vertices_[h]; }
  [[nodiscard]] Index tip(Index h) const { return vertices_[Surface<Real>::next(h)]; }
  [[nodiscard]] Index apex(Index h) const { return vertices_[Surface<Real>::previous(h)]; }
  ///@}

  /// The half-edges that start at each vertex, numbered as Surface's are, in that order.
  [[nodiscard]] GroupedByVertex<Index> all_corners() const {
    GroupedByVertex<Index> made{Array<Index>(vertices_.size()), {}};
    made.begin = group_corners(vertex_count(), vertices_, made.values.data());
    return made;
  }

  /// The edges across from each vertex, in the order of their faces' numbers.
  [[nodiscard]] GroupedByVertex<Rim> all_rims() const {
    GroupedByVertex<Rim> made{Array<Rim>(vertices_.size()), corner_ends(vertex_count(), vertices_)};
    // From each vertex' end down, so that what began as its end is left as its beginning.
    for (Index f = face_count() - 1; f >= 0; --f) {
      const auto [a, b, c] = face(f);
      made.values[--made.begin[a]] = {b, c};
      made.values[--made.begin[b]] = {c, a};
      made.values[--made.begin[c]] = {a, b};
    }
    return made;
  }

  /// As Surface has them.
  ///@{
  [[nodiscard]] const Array<Index>& components() const {
    return components_.get([&] { return component_of_vertices(vertex_count(), vertices_); });
  }
  void require_vertex(Index vertex) const { require_vertex_of(vertex_count(), vertex); }
  template <std::floating_point U>
  void require_point(const SurfacePoint<U>& point) const {
    require_point_of(vertex_count(), face_count(), point,
                     [&](Index a, Index b) { return are_joined(a, b); });
  }
  ///@}

  /// Length of the edge between two vertices, and its square.
  ///@{
  [[nodiscard]] Real length(Index a, Index b) const { return root(squared_length(a, b)); }
  [[nodiscard]] Real squared_length(Index a, Index b) const {
    return sum_of_squares(positions_[b] - positions_[a]);
  }
  ///@}

  /// What Surface measures: a square vanishes or rounds for lengths only that count as none.
  [[nodiscard]] static Real root(Real squared_length) {
    const Real length = std::sqrt(squared_length);
    return length < shortest_length ? Real(0) : length;
  }

  /// Calls `visit(vertex, distance)` for the vertices that a point reaches by a straight line:
  /// itself if it is a vertex, else those of the faces that hold it, some perhaps twice.
  void for_each_vertex_near(const SurfacePoint<Real>& point, auto&& visit) const {
    using Kind = typename SurfacePoint<Real>::Kind;
    const Index a = point.element[0], b = point.element[1];
    if (point.kind == Kind::vertex) return visit(a, Real(0));
    const auto visit_face = [&](Index f, const std::array<Index, 3>& corners) {
      for (const Index v : face(f)) visit(v, straight_distance(corners, point.weights, v));
    };
    if (point.kind == Kind::face) return visit_face(a, face(a));
    for (const Index h : corners_at(a)) {
      const Index next = Mesh::next(h), previous = Mesh::previous(h);
      if (vertices_[next] == b || vertices_[previous] == b) visit_face(h / 3, {a, b, -1});
    }
  }

  /// Whether the ends of an edge are not at one place, however near they are.
  [[nodiscard, gnu::cold, gnu::noinline]] bool any_edge_is_long() const {
    for (Index h = 0; h < static_cast<Index>(vertices_.size()); ++h) {
      if (largest_part(positions_[tip(h)] - positions_[origin(h)]) != 0) return true;
    }
    return false;
  }

  /// Whether two of a vertex' faces, given by their half-edges from it or by the edges across, have
  /// the same vertices.
  ///@{
  [[nodiscard, gnu::cold, gnu::noinline]] bool has_twins(Slice<const Index> corners) const {
    Array<std::pair<Index, Index>> others;
    for (const Index h : corners) others.push_back(std::minmax(tip(h), apex(h)));
    return has_any_twice(others);
  }
  [[nodiscard, gnu::cold, gnu::noinline]] static bool has_twins(Slice<const Rim> rims) {
    Array<std::pair<Index, Index>> others;
    for (const Rim& rim : rims) others.push_back(std::minmax(rim.tip, rim.apex));
    return has_any_twice(others);
  }
  ///@}

 protected:
  Array<Vec3<Real>> positions_;
  Array<Index> vertices_;  // of each face: three

 private:
  using Mesh = Surface<Real>;

  [[nodiscard]] static bool has_any_twice(Array<std::pair<Index, Index>>& pairs) {
    std::make_heap(pairs.begin(), pairs.end());
    std::sort_heap(pairs.begin(), pairs.end());  // less to compile than std::sort
    return std::adjacent_find(pairs.begin(), pairs.end()) != pairs.end();
  }

  // Sources are on edges less often than at vertices, so that corners are kept from then on only.
  [[nodiscard]] bool are_joined(Index a, Index b) const {
    for (const Index h : corners_at(a)) {
      if (tip(h) == b || apex(h) == b) return true;
    }
    return false;
  }

  // From a vertex to the point with these shares of the corners of a face or an edge: as Surface
  // tells the difference, to the last bit.
  [[nodiscard]] Real straight_distance(const std::array<Index, 3>& corners,
                                       const std::array<Real, 3>& shares, Index vertex) const {
    Vec3<Real> way(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      if (corners[k] < 0 || corners[k] == vertex) continue;
      way += shares[k] * (positions_[corners[k]] - positions_[vertex]);
    }
    return stable_norm(way);
  }

  [[nodiscard]] Slice<const Index> corners_at(Index vertex) const {
    return corners_.get([&] { return all_corners(); }).at(vertex);
  }

  Lazy<Array<Index>> components_;
  Lazy<GroupedByVertex<Index>> corners_;  // for points on edges
};

/// As of a Surface.
template <std::floating_point Real>
void for_each_vertex_near(const FaceList<Real>& mesh, const SurfacePoint<Real>& point,
                          auto&& visit) {
  mesh.for_each_vertex_near(point, visit);
}

/// A number no less than the length of any shortest path, as of a Surface.
template <std::floating_point Real>
[[nodiscard]] Real longest_way(const FaceList<Real>& mesh) {
  Real sum = 0;
  for (Index h = 0; h < 3 * mesh.face_count(); ++h) sum += mesh.length(mesh.origin(h), mesh.tip(h));
  return 2 * sum;
}

}  // namespace gelight::detail
