#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pages.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// What every distance solver answers: the distance of each vertex from the nearest source, in the
/// unit of the positions, +infinity where no path leads.
///
/// Of sources in several connected parts each part's are on their own, however far apart they
/// start. Throws InvalidInput, naming the vertex, for a distance that T cannot hold, where it is
/// narrower than double: beyond its largest number, or not zero and below its smallest normal one.
template <class S, class T>
concept DistanceSolver = std::floating_point<T> &&
    requires(const S& solver, Index vertex, std::span<const Index> vertices,
             std::span<const Source<T>> sources, std::span<T> out) {
  { solver.distance(vertex) } -> std::same_as<std::vector<T>>;
  { solver.distance(vertices) } -> std::same_as<std::vector<T>>;
  { solver.distance(sources) } -> std::same_as<std::vector<T>>;
  solver.distance_into(out, vertex);
  solver.distance_into(out, vertices);
  solver.distance_into(out, sources);
};

namespace detail {

/// The precision in which a solver works inside: double, whatever T goes in and out. (Named by way
/// of T, so that what is made of it costs nothing to include.)
template <std::floating_point T>
struct WorkingPrecision {
  using Real = double;
};

using Sources = Array<Source<double>>;

/// Integers by which no vertices are named, such as std::vector<std::size_t>: those are given as
/// std::vector<gelight::Index>. Calls with them are deleted, for else compilers list all others.
template <class Integers>
concept OtherIntegers =
    std::integral<typename Integers::value_type> &&
    !std::same_as<typename Integers::value_type, Index> &&
    !std::convertible_to<const Integers&, Index>;  // one, such as std::integral_constant

// Of any mesh that can be asked as a Surface can: here and below.
template <class Mesh, std::floating_point T, class Real = typename Mesh::Scalar>
[[nodiscard]] Source<Real> checked_source(const Mesh& mesh, const Source<T>& source,
                                          std::size_t number) {
  mesh.require_point(source.point);
  require(std::isfinite(source.distance), "source ", number, " starts with distance ",
          source.distance, ", which is not finite");
  return {source.point.template cast<Real>(), static_cast<Real>(source.distance)};
}
template <class Mesh, std::floating_point T, class Real = typename Mesh::Scalar>
[[nodiscard]] Source<Real> checked_source(const Mesh& mesh, const SurfacePoint<T>& point,
                                          std::size_t) {
  mesh.require_point(point);
  return {point.template cast<Real>(), 0};
}
template <class Mesh, class Real = typename Mesh::Scalar>
[[nodiscard]] Source<Real> checked_source(const Mesh& mesh, Index vertex, std::size_t) {
  mesh.require_vertex(vertex);
  return {vertex_point<Real>(vertex), 0};
}

/// Sources in the precision that is worked in. They take the place of `old` ones, whose memory
/// serves again.
template <class Mesh, class Place, class Real = typename Mesh::Scalar>
[[nodiscard]] Array<Source<Real>> checked_sources(const Mesh& mesh, std::span<const Place> sources,
                                                  Array<Source<Real>> old = {}) {
  require(!sources.empty(), "there is no source");
  old.clear();
  old.reserve(sources.size());
  for (const Place& source : sources) old.push_back(checked_source(mesh, source, old.size()));
  return old;
}

/// What the distances of a query count from while it lasts: the start distance of the earliest
/// source, of each connected part where those differ. So numbers are no larger than the parts.
template <std::floating_point Real>
struct Starts {
  Real common = 0;        // of all parts, 0 where they differ
  Array<Real> of_vertex;  // where they differ
  Array<Index> left;      // the sources that are left, by number, where some were dropped

  [[nodiscard]] Real at(Index v) const { return of_vertex.empty() ? common : of_vertex[v]; }

  /// Moves the start distances so that the earliest of each connected part is 0, and keeps what
  /// those were. Sources that others have overtaken before they start are dropped.
  template <class Mesh>
  void move_to_zero(const Mesh& mesh, Array<Source<Real>>& sources);
};

/// A number no less than the length of any shortest path.
template <std::floating_point Real>
[[nodiscard]] Real longest_way(const Surface<Real>& surface) {
  Real sum = 0;
  for (Index h = 0; h < surface.halfedge_count(); ++h) sum += surface.length(h);
  return 2 * sum;  // a straight line to an edge's end, edges once each, and a straight line
}

/// The connected part in which a point lies, by the number that Surface::components gives it.
template <class Mesh, std::floating_point Real>
[[nodiscard]] Index part_of(const Mesh& mesh, const SurfacePoint<Real>& point) {
  const Index element = point.element[0];
  const bool is_face = point.kind == SurfacePoint<Real>::Kind::face;
  return mesh.components()[is_face ? mesh.face(element)[0] : element];
}

template <std::floating_point Real>
template <class Mesh>
void Starts<Real>::move_to_zero(const Mesh& mesh, Array<Source<Real>>& sources) {
  of_vertex.clear();
  left.clear();
  const auto is_earlier = [](const auto& a, const auto& b) { return a.distance < b.distance; };
  const auto [first, last] = std::minmax_element(sources.begin(), sources.end(), is_earlier);
  const Real earliest = first->distance;
  common = earliest;
  if (earliest == last->distance) {
    for (auto& source : sources) source.distance = 0;
    return;
  }
  // The earliest of each part, where its number is.
  const Array<Index>& components = mesh.components();
  Array<Real>& starts = of_vertex;
  starts.assign(components.size(), unreachable<Real>);
  for (const auto& source : sources) {
    Real& start = starts[part_of(mesh, source.point)];
    start = std::min(start, source.distance);
  }
  bool parts_differ = false;
  for (auto& source : sources) {
    const Real start = starts[part_of(mesh, source.point)];
    parts_differ |= start != earliest;
    source.distance -= start;
  }
  const Real overtaken = longest_way(mesh);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (!(sources[i].distance > overtaken)) left.push_back(static_cast<Index>(i));
  }
  if (left.size() == sources.size()) left.clear();
  sources.keep_until(std::remove_if(sources.begin(), sources.end(), [&](const auto& source) {
    return source.distance > overtaken;
  }));

  if (!parts_differ) return starts.clear();
  common = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Real start = starts[components[v]];  // a part's least vertex comes first
    starts[v] = start < unreachable<Real> ? start : 0;
  }
}

template <std::floating_point Real>
[[nodiscard]] Starts<Real> move_to_zero(const Surface<Real>& surface,
                                        Array<Source<Real>>& sources) {
  Starts<Real> starts;
  starts.move_to_zero(surface, sources);
  return starts;
}

/// What a query asks and finds, in memory that serves the next one again.
template <std::floating_point Real>
struct DistanceQuery {
  Array<Source<Real>> sources;
  Starts<Real> starts;
  Slice<Real> distance;  // of each vertex; +infinity before it is solved
};

/// Whether T holds a distance: +infinity means unreachable and 0 no way at all, so that a number
/// must not become one of them by being too large or too small, nor lose its digits.
template <std::floating_point T>
[[nodiscard]] bool holds(double distance) {
  using Limits = std::numeric_limits<T>;
  if constexpr (Limits::max() >= std::numeric_limits<double>::max()) {
    return true;
  } else {
    const double size = std::abs(distance);
    return size == 0 || std::isinf(size) ||
           (size >= double{Limits::min()} && size <= double{Limits::max()});
  }
}

/// A distance of type T. Throws InvalidInput where T does not hold it; `of` says what it is of.
template <std::floating_point T>
[[nodiscard]] T distance_as(double distance, const auto&... of) {
  require(holds<T>(distance), "the distance of ", of..., " is ", distance,
          ", beyond the numbers of the type it is asked in");
  return static_cast<T>(distance);
}

/// The overloads of DistanceSolver over one function of Solver,
/// `void solve_vertices(DistanceQuery<double>&) const`, which replaces the distance of each vertex
/// that it reaches, +infinity before.
template <class Solver, std::floating_point T>
class DistanceQueries {
 public:
  /// Distance of every vertex from a vertex.
  [[nodiscard]] std::vector<T> distance(Index vertex) const {
    return distance(std::span<const Index>(&vertex, 1));
  }
  /// Distance of every vertex from the nearest of several vertices.
  ///@{
  [[nodiscard]] std::vector<T> distance(std::span<const Index> vertices) const;
  [[nodiscard]] std::vector<T> distance(std::initializer_list<Index> vertices) const {
    return distance(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  template <OtherIntegers NotOfIndex>
  [[nodiscard]] std::vector<T> distance(const NotOfIndex& vertices) const = delete;
  ///@}
  /// Distance of every vertex from a point, or the nearest of several, with start distances.
  ///@{
  [[nodiscard]] std::vector<T> distance(const Source<T>& source) const {
    return distance(std::span<const Source<T>>(&source, 1));
  }
  [[nodiscard]] std::vector<T> distance(const SurfacePoint<T>& point) const {
    return distance(std::span<const SurfacePoint<T>>(&point, 1));
  }
  [[nodiscard]] std::vector<T> distance(std::span<const Source<T>> sources) const;
  [[nodiscard]] std::vector<T> distance(std::span<const SurfacePoint<T>> points) const;
  // A template, so that braces with nothing in them stand for vertices.
  template <PointOf<T> Point = Source<T>>
  [[nodiscard]] std::vector<T> distance(std::initializer_list<Point> points) const {
    return distance(std::span<const Point>(points.begin(), points.size()));
  }
  ///@}

  /// The same in the caller's memory: `out` has an element per vertex, and is as it was where the
  /// query throws. Nothing is allocated once a query like it has been answered, but by the planner
  /// and by smooth distances where a path has to be searched.
  void distance_into(std::span<T> out, Index vertex) const {
    distance_into(out, std::span<const Index>(&vertex, 1));
  }
  void distance_into(std::span<T> out, std::span<const Index> vertices) const;
  void distance_into(std::span<T> out, std::initializer_list<Index> vertices) const {
    distance_into(out, std::span<const Index>(vertices.begin(), vertices.size()));
  }
  template <OtherIntegers NotOfIndex>
  void distance_into(std::span<T> out, const NotOfIndex& vertices) const = delete;
  void distance_into(std::span<T> out, const Source<T>& source) const {
    distance_into(out, std::span<const Source<T>>(&source, 1));
  }
  void distance_into(std::span<T> out, const SurfacePoint<T>& point) const {
    distance_into(out, std::span<const SurfacePoint<T>>(&point, 1));
  }
  void distance_into(std::span<T> out, std::span<const Source<T>> sources) const;
  void distance_into(std::span<T> out, std::span<const SurfacePoint<T>> points) const;
  template <PointOf<T> Point = Source<T>>
  void distance_into(std::span<T> out, std::initializer_list<Point> points) const {
    distance_into(out, std::span<const Point>(points.begin(), points.size()));
  }

  /// Throws InvalidInput for sources that queries refuse.
  ///@{
  void require_sources(std::span<const Index> vertices) const;
  void require_sources(std::span<const Source<T>> sources) const;
  void require_sources(std::span<const SurfacePoint<T>> points) const;
  ///@}

 protected:
  /// The same as `solve(query)` does it.
  template <class Place>
  void put_distances(std::span<T> out, std::span<const Place> sources, const auto& solve) const;

 private:
  // What is used again by later queries.
  using Real = typename WorkingPrecision<T>::Real;
  struct Memory {
    DistanceQuery<Real> query;
    Array<Real> distances;
  };

  [[nodiscard]] const Solver& solver() const { return static_cast<const Solver&>(*this); }

  // The answer of the mesh that sources are of: the surface, if the solver knows none that is
  // smaller.
  [[nodiscard]] auto of_mesh(const auto& ask) const {
    if constexpr (requires { solver().of_mesh(ask); }) {
      return solver().of_mesh(ask);
    } else {
      return ask(solver().surface());
    }
  }
  [[nodiscard]] std::size_t vertex_count() const {
    return of_mesh([](const auto& mesh) { return static_cast<std::size_t>(mesh.vertex_count()); });
  }
  template <class Place>
  [[nodiscard]] Array<Source<Real>> checked(std::span<const Place> sources,
                                            Array<Source<Real>> old = {}) const {
    return of_mesh(
        [&](const auto& mesh) { return checked_sources(mesh, sources, std::move(old)); });
  }

  void require_size(std::span<T> out) const {
    require(out.size() == vertex_count(), "the output has ", out.size(), " elements, the mesh ",
            vertex_count(), " vertices");
  }
  static void copy(const Array<Real>& distances, std::span<T> out) {
    Index v = 0;
    for (const Real d : distances) (void)distance_as<T>(d, "vertex ", v++);
    std::size_t i = 0;
    for (const Real d : distances) out[i++] = static_cast<T>(d);
  }

  template <class Place>
  [[nodiscard]] std::vector<T> answer(std::span<const Place> sources) const;
  template <class Place>
  void answer_into(std::span<T> out, std::span<const Place> sources, const auto& solve) const;
  [[nodiscard]] auto by_solver() const {
    return [this](DistanceQuery<Real>& query) { solver().solve_vertices(query); };
  }

  std::shared_ptr<Pool<Memory>> memories_ = std::make_shared<Pool<Memory>>();
};

// Where the result is made of what is worked with, in its own memory.
template <class Solver, std::floating_point T>
template <class Place>
auto DistanceQueries<Solver, T>::answer(std::span<const Place> sources) const -> std::vector<T> {
  if constexpr (std::same_as<T, double>) {
    const typename Pool<Memory>::Borrowed borrowed(*memories_);
    DistanceQuery<Real>& query = (*borrowed).query;
    query.sources = checked(sources, std::move(query.sources));
    std::vector<T> out;
    out.reserve(vertex_count());
    expect_writes(out.data(), vertex_count() * sizeof(T));
    out.assign(vertex_count(), unreachable<Real>);  // less to compile than resize
    query.distance = out;
    solver().solve_vertices(query);
    return out;
  } else {
    std::vector<T> out(vertex_count());
    answer_into(std::span(out), sources, by_solver());
    return out;
  }
}

template <class Solver, std::floating_point T>
template <class Place>
void DistanceQueries<Solver, T>::answer_into(std::span<T> out, std::span<const Place> sources,
                                             const auto& solve) const {
  const typename Pool<Memory>::Borrowed borrowed(*memories_);
  auto& [query, distances] = *borrowed;
  query.sources = checked(sources, std::move(query.sources));
  distances.assign(out.size(), unreachable<Real>);
  query.distance = distances;
  solve(query);
  copy(distances, out);
}

template <class Solver, std::floating_point T>
template <class Place>
void DistanceQueries<Solver, T>::put_distances(std::span<T> out, std::span<const Place> sources,
                                               const auto& solve) const {
  require_size(out);
  answer_into(out, sources, solve);
}

template <class Solver, std::floating_point T>
auto DistanceQueries<Solver, T>::distance(std::span<const Index> vertices) const -> std::vector<T> {
  return answer(vertices);
}

template <class Solver, std::floating_point T>
auto DistanceQueries<Solver, T>::distance(std::span<const Source<T>> sources) const
    -> std::vector<T> {
  return answer(sources);
}

template <class Solver, std::floating_point T>
auto DistanceQueries<Solver, T>::distance(std::span<const SurfacePoint<T>> points) const
    -> std::vector<T> {
  return answer(points);
}

template <class Solver, std::floating_point T>
void DistanceQueries<Solver, T>::require_sources(std::span<const Index> vertices) const {
  (void)checked(vertices);
}

template <class Solver, std::floating_point T>
void DistanceQueries<Solver, T>::require_sources(std::span<const Source<T>> sources) const {
  (void)checked(sources);
}

template <class Solver, std::floating_point T>
void DistanceQueries<Solver, T>::require_sources(std::span<const SurfacePoint<T>> points) const {
  (void)checked(points);
}

template <class Solver, std::floating_point T>
void DistanceQueries<Solver, T>::distance_into(std::span<T> out,
                                               std::span<const Index> vertices) const {
  put_distances(out, vertices, by_solver());
}

template <class Solver, std::floating_point T>
void DistanceQueries<Solver, T>::distance_into(std::span<T> out,
                                               std::span<const Source<T>> sources) const {
  put_distances(out, sources, by_solver());
}

template <class Solver, std::floating_point T>
void DistanceQueries<Solver, T>::distance_into(std::span<T> out,
                                               std::span<const SurfacePoint<T>> points) const {
  put_distances(out, points, by_solver());
}

}  // namespace detail
}  // namespace gelight
