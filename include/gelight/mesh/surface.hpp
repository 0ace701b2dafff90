#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/periodic_check.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

namespace detail {

/// For each vertex the smallest vertex that faces join it to, given the corners of all faces: one
/// number per connected part.
[[nodiscard]] inline Array<Index> component_of_vertices(Index vertex_count,
                                                        const Array<Index>& corners) {
  Array<Index> parent(static_cast<std::size_t>(vertex_count));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (Index h = 0; h < static_cast<Index>(corners.size()); h += 3) {
    for (const Index k : {1, 2}) {
      const Index a = root(corners[h]), b = root(corners[h + k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (Index v = 0; v < vertex_count; ++v) parent[v] = parent[parent[v]];
  return parent;
}

/// Where each vertex' half-edges end, grouped by their origins, given those of all; and one more.
[[nodiscard]] inline Array<Index> corner_ends(Index vertex_count, const Array<Index>& origins) {
  Array<Index> ends(static_cast<std::size_t>(vertex_count) + 1, 0);
  for (const Index v : origins) ++ends[v];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  return ends;
}

/// Groups half-edges by their origins, given those of all, into `corners`, which has room for them.
/// Returns where each vertex' half-edges begin, and one more.
[[nodiscard]] inline Array<Index> group_corners(Index vertex_count, const Array<Index>& origins,
                                                Index* corners) {
  Array<Index> begin = corner_ends(vertex_count, origins);
  // From each vertex' end down, so that what began as its end is left as its beginning.
  for (Index h = static_cast<Index>(origins.size()) - 1; h >= 0; --h) {
    corners[--begin[origins[h]]] = h;
  }
  return begin;
}

/// Throws InvalidInput for a vertex that a mesh with so many does not have.
inline void require_vertex_of(Index vertex_count, Index vertex) {
  require(vertex >= 0 && vertex < vertex_count, "vertex ", vertex,
          " is out of range, the mesh has ", vertex_count, " vertices");
}

/// Throws InvalidInput as Surface::require_point does, for a mesh whose `are_joined(a, b)` tells
/// whether there is an edge between two vertices.
template <std::floating_point U>
void require_point_of(Index vertex_count, Index face_count, const SurfacePoint<U>& point,
                      const auto& are_joined) {
  using Kind = typename SurfacePoint<U>::Kind;
  const auto& [a, b] = point.element;
  require(point.kind <= Kind::face, "a surface point of kind ", static_cast<int>(point.kind),
          " of 3");
  if (point.kind == Kind::face) {
    require(a >= 0 && a < face_count, "face ", a, " is out of range, the mesh has ", face_count,
            " faces");
  } else {
    require_vertex_of(vertex_count, a);
  }
  if (point.kind == Kind::edge) {
    require_vertex_of(vertex_count, b);
    require(are_joined(a, b), "there is no edge between vertices ", a, " and ", b);
  }
  const auto& w = point.weights;
  const U off = std::abs(w[0] + w[1] + w[2] - 1);
  require(w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && off <= share_rounding<U>, "weights (", w[0], ", ",
          w[1], ", ", w[2], ") of a point on ",
          point.kind == Kind::face ? "face " : "an edge at vertex ", a,
          " are negative or do not sum to 1");
  // No third corner, nor a second one, is there to have a share.
  require((point.kind == Kind::face || w[2] == 0) && (point.kind != Kind::vertex || w[1] == 0),
          "weights (", w[0], ", ", w[1], ", ", w[2], ") of a point ",
          point.kind == Kind::vertex ? "at" : "on an edge at", " vertex ", a,
          " are of more corners than that has");
}

/// What a hook is told that long work is while a mesh is read.
inline constexpr const char* reading_mesh = "the reading of a mesh";

/// Half-edges are numbered by Index, so `per` times the count must fit.
[[nodiscard]] Index checked_count(std::integral auto count, Index per, const char* what) {
  require(count > 0, "the mesh has no ", what);
  require(std::cmp_less_equal(count, std::numeric_limits<Index>::max() / per), "the mesh has ",
          count, ' ', what, ", too many for 32 bits");
  return static_cast<Index>(count);
}

template <std::floating_point T>
[[gnu::cold, gnu::noinline]] void require_in_reach(Index v, const Vec3<T>& q) {
  const auto [x, y, z] =
      std::array{static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2])};
  require(std::isfinite(x) && std::isfinite(y) && std::isfinite(z), "vertex ", v, " has position (",
          q[0], ", ", q[1], ", ", q[2], "), which is not finite");
  require(std::max({std::fabs(x), std::fabs(y), std::fabs(z)}) <= largest_coordinate, "vertex ", v,
          " has position (", q[0], ", ", q[1], ", ", q[2],
          "), too far out: products of lengths would overflow");
}

/// The positions of a mesh's vertices. Throws InvalidInput as Surface does.
template <std::floating_point T, TriangleMesh M>
[[nodiscard]] Array<Vec3<T>> read_positions(const M& mesh, const CancelHook& cancelled) {
  const auto count = checked_count(MeshTraits<M>::vertex_count(mesh), 1, "vertices");
  Array<Vec3<T>> positions(static_cast<std::size_t>(count));
  PeriodicCheck progress(cancelled, count, reading_mesh);
  for (Index v = 0; v < count; ++v) {
    const auto& p = MeshTraits<M>::position(mesh, v);
    const Vec3<T> q(static_cast<T>(p[0]), static_cast<T>(p[1]), static_cast<T>(p[2]));
    const double x = std::fabs(static_cast<double>(q[0])), y = std::fabs(static_cast<double>(q[1]));
    const double z = std::fabs(static_cast<double>(q[2]));
    if (!(x + y + z <= largest_coordinate)) require_in_reach(v, q);
    positions[v] = q;
    progress.step();
  }
  return positions;
}

[[noreturn, gnu::cold, gnu::noinline]] inline void refuse_face(Index f,
                                                               const std::array<Index, 3>& face,
                                                               Index vertices) {
  for (const Index v : face) {
    require(v >= 0 && v < vertices, "face ", f, " has vertex ", v, ", the mesh has vertices 0 to ",
            vertices - 1);
  }
  refuse({"face ", f, " has a vertex twice: (", face[0], ", ", face[1], ", ", face[2], ")"});
}

/// The vertices of a mesh's faces, three of each. Throws InvalidInput as Surface does.
template <TriangleMesh M>
[[nodiscard]] Array<Index> read_faces(const M& mesh, Index vertices, const CancelHook& cancelled) {
  const auto count = checked_count(MeshTraits<M>::face_count(mesh), 3, "faces");
  Array<Index> corners;
  corners.resize_for_writes(3 * static_cast<std::size_t>(count));
  Index* to = corners.data();
  PeriodicCheck progress(cancelled, count, reading_mesh);
  for (Index f = 0; f < count; ++f, to += 3) {
    const std::array<Index, 3> face = MeshTraits<M>::face(mesh, f);
    const auto [a, b, c] = face;
    const bool is_sound =
        std::min({a, b, c}) >= 0 && std::max({a, b, c}) < vertices && a != b && b != c && c != a;
    if (!is_sound) [[unlikely]] {
      refuse_face(f, face, vertices);
    }
    to[0] = a;
    to[1] = b;
    to[2] = c;
    progress.step();
  }
  return corners;
}

/// What a mesh is made of, for methods that need no half-edges.
template <std::floating_point T>
struct MeshArrays {
  Array<Vec3<T>> positions;
  Array<Index> vertices;  // of each face: three
};

/// Throws InvalidInput as Surface does, for what is seen vertex by vertex and face by face.
template <std::floating_point T, TriangleMesh M>
[[nodiscard]] auto read_mesh(const M& mesh, const CancelHook& cancelled) -> MeshArrays<T> {
  MeshArrays<T> made{read_positions<T>(mesh, cancelled), {}};
  made.vertices = read_faces(mesh, static_cast<Index>(made.positions.size()), cancelled);
  return made;
}

[[noreturn, gnu::cold, gnu::noinline]] inline void refuse_twin_faces(Index face, Index other) {
  refuse({"faces ", face, " and ", other, " have the same three vertices"});
}

[[noreturn, gnu::cold, gnu::noinline]] inline void refuse_short_edges(double longest) {
  refuse({"the longest edge is ", longest, " long: products of lengths would vanish"});
}

}  // namespace detail

/// An immutable snapshot of a triangle mesh in flat arrays, with its half-edges.
///
/// Half-edge h = 3 f + k runs from vertex k of face f to the next one, inside f. Edges may be
/// shared by any number of faces, oriented any way; vertices may be bow-ties or belong to no face.
/// Copies share the arrays, so a Surface is passed and kept by value.
template <std::floating_point T>
class Surface {
 public:
  using Scalar = T;  ///< what coordinates are made of

  /// Copies what it needs of any mesh, in O(vertices + faces).
  /// Throws InvalidInput for a mesh without faces, a coordinate that is not finite or beyond 1e75,
  /// an edge longer than a coordinate can be, a face with an index out of range or a vertex twice,
  /// and two faces with the same three vertices. An edge of less than 1e-75 counts as of no length;
  /// a mesh of such edges only is refused.
  template <TriangleMesh M>
  requires(!std::same_as<M, Surface>) explicit Surface(const M& mesh,
                                                       const CancelHook& cancelled = {})
      : data_(snapshot(mesh, cancelled)) {}

  /// A copy, which is no work to ask about: where a mesh may be a Surface.
  Surface(const Surface& surface, const CancelHook& /*cancelled*/) : Surface(surface) {}

  /// The parts of the mesh, numbered as they were in the mesh that it is a snapshot of.
  ///@{
  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(data_->positions.size()); }
  [[nodiscard]] Index face_count() const { return halfedge_count() / 3; }
  [[nodiscard]] Index halfedge_count() const { return static_cast<Index>(data_->vertices.size()); }
  [[nodiscard]] const Vec3<T>& position(Index vertex) const { return data_->positions[vertex]; }
  [[nodiscard]] std::array<Index, 3> face(Index f) const {
    const Index* v = data_->vertices.data() + 3 * std::ptrdiff_t{f};
    return {v[0], v[1], v[2]};
  }
  ///@}

  /// The face of a half-edge, and the half-edges after and before it round that face.
  ///@{
  [[nodiscard]] static Index face_of(Index h) { return h / 3; }
  [[nodiscard]] static Index next(Index h) { return h + 1 - 3 * Index{h % 3 == 2}; }
  [[nodiscard]] static Index previous(Index h) { return h - 1 + 3 * Index{h % 3 == 0}; }
  ///@}

  /// The vertex where h starts, where it ends, and the one across the face.
  ///@{
  [[nodiscard]] Index origin(Index h) const { return data_->vertices[h]; }
  [[nodiscard]] Index tip(Index h) const { return data_->vertices[next(h)]; }
  [[nodiscard]] Index apex(Index h) const { return data_->vertices[previous(h)]; }
  ///@}

  /// Length of h's edge, in the unit of the positions.
  [[nodiscard]] T length(Index h) const { return data_->lengths[h]; }

  /// Has the processor fetch where h starts and its length, which are soon to be asked for.
  /// (Always inlined, as detail::prefetch.)
  [[gnu::always_inline]] void expect(Index h) const {
    detail::prefetch(&data_->vertices[h], sizeof(Index));
    detail::prefetch(&data_->lengths[h], sizeof(T));
  }

  /// The next half-edge on the same edge: h itself on a border, the other one where two faces meet,
  /// a cycle where more do, in the order of their numbers: for one half-edge of each edge, the
  /// last, it is no later than h. It runs the same way as h where the two faces disagree in
  /// orientation.
  [[nodiscard]] Index twin(Index h) const { return data_->twins[h]; }

  /// Whether h is on a border (in one face), and whether it is in at most two faces.
  ///@{
  [[nodiscard]] bool is_border(Index h) const { return twin(h) == h; }
  [[nodiscard]] bool is_manifold(Index h) const { return twin(twin(h)) == h; }
  ///@}

  /// The half-edges that start at a vertex, one in each of its faces, in no particular order.
  [[nodiscard]] detail::Slice<const Index> corners(Index vertex) const {
    const Index begin = data_->corner_begin[vertex];
    const Index end = data_->corner_begin[vertex + 1];
    return {data_->corners.data() + begin, static_cast<std::size_t>(end - begin)};
  }

  /// A half-edge between two vertices, of either direction, or -1 where there is none.
  [[nodiscard]] Index find_halfedge(Index v0, Index v1) const {
    for (const Index h : corners(v0)) {
      if (tip(h) == v1) return h;
      if (apex(h) == v1) return previous(h);
    }
    return -1;
  }

  /// For each vertex the smallest vertex that faces join it to: one number per connected part.
  /// Linear time when first asked for, none from then on.
  [[nodiscard]] const detail::Array<Index>& components() const {
    return data_->components.get(
        [&] { return detail::component_of_vertices(vertex_count(), data_->vertices); });
  }

  /// Where a surface point is. Throws InvalidInput as `require_point` does.
  [[nodiscard]] Vec3<T> position(const SurfacePoint<T>& point) const {
    using namespace detail::arithmetic;
    require_point(point);
    const auto& [a, b] = point.element;
    const auto& w = point.weights;
    if (point.kind == SurfacePoint<T>::Kind::vertex) return position(a);
    if (point.kind == SurfacePoint<T>::Kind::edge) return w[0] * position(a) + w[1] * position(b);
    const auto v = face(a);
    return w[0] * position(v[0]) + w[1] * position(v[1]) + w[2] * position(v[2]);
  }

  /// The way through space from one surface point to another, as differences of positions, so that
  /// it is as exact far from the origin as near it. The points are of this surface.
  [[nodiscard]] Vec3<T> difference(const SurfacePoint<T>& from, const SurfacePoint<T>& to) const {
    using namespace detail::arithmetic;
    using Kind = typename SurfacePoint<T>::Kind;
    if (from.kind == Kind::vertex && to.kind == Kind::vertex) {
      return position(to.element[0]) - position(from.element[0]);
    }
    const std::array<Index, 3> a = corners_of(from), b = corners_of(to);
    // From the corner with the largest share, the only one that need not be small.
    const std::size_t i0 = largest(from), i1 = largest(to);
    const Vec3<T>& base = position(from.weights[i0] > to.weights[i1] ? a[i0] : b[i1]);
    Vec3<T> sum(0, 0, 0);
    for (std::size_t i = 0; i < 3; ++i) {
      if (b[i] < 0) continue;
      T share = to.weights[i];
      for (std::size_t j = 0; j < 3; ++j) share -= a[j] == b[i] ? from.weights[j] : T(0);
      sum += share * (position(b[i]) - base);
    }
    for (std::size_t j = 0; j < 3; ++j) {
      if (a[j] < 0 || a[j] == b[0] || a[j] == b[1] || a[j] == b[2]) continue;
      sum -= from.weights[j] * (position(a[j]) - base);
    }
    return sum;
  }

  /// Throws InvalidInput for a vertex that is not of this surface.
  void require_vertex(Index vertex) const { detail::require_vertex_of(vertex_count(), vertex); }

  /// Throws InvalidInput for a point whose vertex, edge or face is not of this surface, or whose
  /// weights are negative, not finite, or do not sum to 1 within 16 epsilon of the point's scalar;
  /// for a share of a third corner on an edge, or a second one at a vertex; and for no known kind.
  template <std::floating_point U>
  void require_point(const SurfacePoint<U>& point) const {
    detail::require_point_of(vertex_count(), face_count(), point,
                             [&](Index a, Index b) { return find_halfedge(a, b) >= 0; });
  }

 private:
  struct Data {
    detail::Array<Vec3<T>> positions;
    detail::Array<Index> vertices;      // of each half-edge: its origin
    detail::Array<Index> twins;         // of each half-edge
    detail::Array<T> lengths;           // of each half-edge
    detail::Array<Index> corner_begin;  // of each vertex, and one more: where its corners begin
    detail::Array<Index> corners;       // half-edges, grouped by origin
    detail::Lazy<detail::Array<Index>> components;
  };

  // The vertices to which a point's weights belong, or -1.
  [[nodiscard]] std::array<Index, 3> corners_of(const SurfacePoint<T>& p) const {
    if (p.kind == SurfacePoint<T>::Kind::face) return face(p.element[0]);
    return {p.element[0], p.kind == SurfacePoint<T>::Kind::edge ? p.element[1] : -1, -1};
  }
  static std::size_t largest(const SurfacePoint<T>& p) {
    std::size_t at = 0;
    for (std::size_t i = 1; i < 3; ++i) at = p.weights[i] > p.weights[at] ? i : at;
    return at;
  }

  template <TriangleMesh M>
  static std::shared_ptr<const Data> snapshot(const M& mesh, const CancelHook& cancelled);

  static void link_corners(Data& data) {
    data.corners.resize_for_writes(data.vertices.size());
    data.corner_begin = detail::group_corners(static_cast<Index>(data.positions.size()),
                                              data.vertices, data.corners.data());
  }

  // The last half-edge that was found between a vertex and a lower one.
  struct Latest {
    Index lower = -1, halfedge = -1;
  };

  // Meshes whose faces lie in no order wait for memory half of the time: about so many corners
  // pass while it answers.
  static constexpr Index corners_ahead = 24;
  static void prefetch_halfedge(const Data& data, Index h) {
    detail::prefetch(data.vertices.data() + h, sizeof(Index));
    detail::prefetch(data.twins.data() + h, sizeof(Index));
    detail::prefetch(data.lengths.data() + h, sizeof(T));
  }

  // Joins the half-edges of each edge into a cycle in the order of their numbers, at its lower
  // vertex, and measures it, once for all of them.
  static void link_edges(Data& data, const CancelHook& cancelled) {
    data.twins.resize_for_writes(data.vertices.size());
    data.lengths.resize_for_writes(data.vertices.size());
    detail::Array<Latest> latest(data.positions.size());
    const auto count = static_cast<Index>(data.positions.size());
    const auto half_edges = static_cast<Index>(data.vertices.size());
    double longest = 0;
    bool any_crowded = false;  // an edge of three faces or more
    detail::PeriodicCheck progress(cancelled, count, detail::reading_mesh);
    for (Index v = 0; v < count; ++v) {
      const auto join = [&](Index h, Index end, Index apex) {
        if (end < v) return;
        Latest& before = latest[end];
        if (before.lower != v) {
          before = {v, h};
          data.twins[h] = h;
          const double length = measured(data, v, end);
          longest = std::max(longest, length);
          data.lengths[h] = length < detail::shortest_length ? T(0) : static_cast<T>(length);
          return;
        }
        const Index other = before.halfedge;
        if (data.vertices[previous(other)] == apex) [[unlikely]] {
          detail::refuse_twin_faces(face_of(other), face_of(h));
        }
        any_crowded |= data.twins[other] != other;
        data.twins[h] = std::exchange(data.twins[other], h);
        data.lengths[h] = data.lengths[other];
        before.halfedge = h;
      };
      for (Index c = data.corner_begin[v]; c < data.corner_begin[v + 1]; ++c) {
        const Index out = data.corners[c], in = previous(out);
        prefetch_halfedge(data, data.corners[std::min(c + corners_ahead, half_edges - 1)]);
        const Index tip = data.vertices[next(out)], from = data.vertices[in];
        join(out, tip, from);
        join(in, from, tip);
      }
      progress.step();
    }
    if (any_crowded) require_different_faces(data);
    if (longest != 0 && longest < detail::shortest_length) detail::refuse_short_edges(longest);
  }

  [[nodiscard]] static double measured(const Data& data, Index a, Index b) {
    using namespace detail::arithmetic;
    const double length =
        detail::stable_norm(cast<double>(data.positions[b]) - cast<double>(data.positions[a]));
    if (!(length <= detail::largest_number<T>)) [[unlikely]] {
      detail::refuse({"the edge between vertices ", a, " and ", b, " is ", length,
                      " long, too long for the coordinates' type"});
    }
    return length;
  }

  // Two faces with the same vertices share an edge and the vertex across it. Where two faces in
  // turn do so it was seen; others are sought here.
  [[gnu::cold, gnu::noinline]] static void require_different_faces(const Data& data) {
    const auto apex = [&](Index h) { return data.vertices[previous(h)]; };
    detail::Array<Index> cycle;
    for (Index last = 0; last < static_cast<Index>(data.twins.size()); ++last) {
      if (data.twins[last] > last) continue;  // each cycle once
      cycle.clear();
      Index h = last;
      do {
        h = data.twins[h];
        cycle.push_back(h);
      } while (h != last);
      if (cycle.size() < 3) continue;
      const auto less = [&](Index a, Index b) {
        return apex(a) != apex(b) ? apex(a) < apex(b) : a < b;
      };
      std::make_heap(cycle.begin(), cycle.end(), less);
      std::sort_heap(cycle.begin(), cycle.end(), less);  // less to compile than std::sort
      const auto same = std::adjacent_find(cycle.begin(), cycle.end(),
                                           [&](Index a, Index b) { return apex(a) == apex(b); });
      if (same != cycle.end()) detail::refuse_twin_faces(face_of(*same), face_of(*(same + 1)));
    }
  }

  std::shared_ptr<const Data> data_;
};

namespace detail {

/// A mesh that is a Surface of such numbers, or none.
template <std::floating_point T, TriangleMesh M>
[[nodiscard]] const Surface<T>* as_surface(const M& mesh) {
  if constexpr (std::same_as<M, Surface<T>>) {
    return &mesh;
  } else {
    return nullptr;
  }
}

/// Throws InvalidInput unless what was made of a surface may be used with another: unless they are
/// the same number by number. At once where they share their arrays.
template <std::floating_point T>
void require_same_mesh(const Surface<T>& surface, const Surface<T>& made_of, const char* what) {
  if (&surface.position(0) == &made_of.position(0)) return;
  require(surface.vertex_count() == made_of.vertex_count() &&
              surface.face_count() == made_of.face_count(),
          what, " made of another mesh, of ", made_of.vertex_count(), " vertices and ",
          made_of.face_count(), " faces, not ", surface.vertex_count(), " and ",
          surface.face_count());
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    require(surface.position(v) == made_of.position(v), what, " made of another mesh: its vertex ",
            v, " lies elsewhere");
  }
  for (Index f = 0; f < surface.face_count(); ++f) {
    require(surface.face(f) == made_of.face(f), what, " made of another mesh: its face ", f,
            " has other vertices");
  }
}

}  // namespace detail

/// The data of a mesh, checked.
template <std::floating_point T>
template <TriangleMesh M>
auto Surface<T>::snapshot(const M& mesh, const CancelHook& cancelled)
    -> std::shared_ptr<const Data> {
  auto data = std::make_shared<Data>();
  data->positions = detail::read_positions<T>(mesh, cancelled.part(0, 0.1));
  const auto vertices = static_cast<Index>(data->positions.size());
  data->vertices = detail::read_faces(mesh, vertices, cancelled.part(0.1, 0.4));
  link_corners(*data);
  link_edges(*data, cancelled.part(0.4, 1));
  return data;
}

template <TriangleMesh M>
explicit Surface(const M&) -> Surface<MeshScalar<M>>;
template <TriangleMesh M>
Surface(const M&, const CancelHook&) -> Surface<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template auto detail::read_mesh(const Mesh<float>&, const CancelHook&)
    -> detail::MeshArrays<double>;
GELIGHT_ONCE template auto detail::read_mesh(const MeshView<float>&, const CancelHook&)
    -> detail::MeshArrays<double>;
GELIGHT_ONCE template auto detail::read_mesh(const Mesh<double>&, const CancelHook&)
    -> detail::MeshArrays<double>;
GELIGHT_ONCE template auto detail::read_mesh(const MeshView<double>&, const CancelHook&)
    -> detail::MeshArrays<double>;
GELIGHT_ONCE template class Surface<float>;
GELIGHT_ONCE template auto Surface<float>::snapshot<Mesh<float>>(const Mesh<float>&,
                                                                 const CancelHook&)
    -> std::shared_ptr<const Data>;
GELIGHT_ONCE template auto Surface<float>::snapshot<MeshView<float>>(const MeshView<float>&,
                                                                     const CancelHook&)
    -> std::shared_ptr<const Data>;
GELIGHT_ONCE template class Surface<double>;
GELIGHT_ONCE template auto Surface<double>::snapshot<Mesh<float>>(const Mesh<float>&,
                                                                  const CancelHook&)
    -> std::shared_ptr<const Data>;
GELIGHT_ONCE template auto Surface<double>::snapshot<MeshView<float>>(const MeshView<float>&,
                                                                      const CancelHook&)
    -> std::shared_ptr<const Data>;
GELIGHT_ONCE template auto Surface<double>::snapshot<Mesh<double>>(const Mesh<double>&,
                                                                   const CancelHook&)
    -> std::shared_ptr<const Data>;
GELIGHT_ONCE template auto Surface<double>::snapshot<MeshView<double>>(const MeshView<double>&,
                                                                       const CancelHook&)
    -> std::shared_ptr<const Data>;
}  // namespace gelight
#endif
