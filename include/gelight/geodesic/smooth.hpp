#pragma once

#include <array>
#include <concepts>
#include <initializer_list>
#include <memory>
#include <span>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {
template <std::floating_point T>
class SmoothEngine;
}  // namespace detail

template <std::floating_point T>
struct SmoothOptions {
  /// Edges at which the mesh turns by more than this are creases, across which nothing is smoothed.
  /// In radians. But where those around that turn by less do so to both sides, by more than 0.35 of
  /// this in the mean, it is noise, and no creases; distances over it are rough. On spheres of 642
  /// and 2,562 vertices whose radii are off by 4 to 16 % more than 98 % of the distances are, and
  /// less than 1 % are called smooth.
  T crease_angle = T(0.7);
  /// Further creases, as pairs of vertices, which stay creases in noise, too.
  std::vector<std::array<Index, 2>> creases{};
  /// Where the surface along a path is less smooth than this, distances on the mesh are taken. It
  /// is the mean square of how unevenly normals turn along the path, over that of how they turn: 0
  /// on a smooth surface of fine faces, about 1 on noise.
  T most_roughness = T(0.3);
  /// Asked now and then while solving; when it answers true, Cancelled is thrown.
  CancelHook cancelled{};
};

/// What a distance on the smooth surface is worth.
enum class SmoothTrust : unsigned char {
  smooth,  ///< The length of the straightest path there.
  /// The length of a path there, with which another competes: on the cut locus, where fronts meet,
  /// that which is shorter on the mesh may be the longer one, and about a focal point none is
  /// straightest. An upper bound, but for what smooth distances are off.
  bound,
  rough  ///< The distance on the mesh: a path over it runs along no smooth surface.
};

/// Distances on the smooth surface that a mesh stands for.
template <std::floating_point T>
struct SmoothDistances {
  std::vector<T> distance;  ///< Of each vertex, +infinity where no path leads.
  std::vector<Vec3<T>>
      direction;  ///< Unit tangent in which the path arrives; zero where none does.
  std::vector<SmoothTrust> trust;  ///< Of each vertex.
  ExactField<double> mesh;         ///< The distances on the mesh that they are made of.
};

/// A path on the smooth surface; where trust is rough, on the mesh. Its length and the source's
/// start distance sum to the distance.
///
/// The length is that of the straightest path beside the one on the mesh, which may pass a vertex
/// on its other side. Positions are where that path crosses the edges that the one on the mesh
/// does, or those edges drawn out by a quarter; where their order along the path would be reversed
/// they are one point. Straight lines between them cut the arcs: on ellipsoids of 162 to 2,562
/// vertices with axes of 1 to 0.3, normals given, they were shorter than the length by 0.2 to 0.004
/// % on average, longer by 0.6 % at most, 4 % in one path; positions were off the surface by 2e-3
/// to 1e-4.
template <std::floating_point T>
struct SmoothPath {
  std::vector<Vec3<T>> positions;  ///< About where it runs, beginning at the source.
  Path<T> on_mesh;  ///< The shortest path on the mesh, above which it was begun: as many points.
  T length = 0;     ///< On the smooth surface, an arc between every two positions.
  Vec3<T> direction{0, 0, 0};               ///< Unit tangent on arrival.
  SmoothTrust trust = SmoothTrust::smooth;  ///< What the length is worth.
};

/// Geodesic distance on the smooth surface of which a mesh has the vertices.
///
/// The shortest paths of the mesh are found exactly, lifted to a surface that is curved over each
/// edge as the normals at its ends say, moved sideways until they are straight there (one Newton
/// step), and measured. What is left of the mesh's error is by the fourth power of edge times
/// curvature where normals are given, by the third or so where they are fitted to the vertices.
///
/// Creases and borders stay sharp; the curve of a crease is smooth where both its sides are. Where
/// a mesh is noisy, so that normals do not turn evenly along a path, the distance on the mesh is
/// returned, and `trust` says so. A point of an edge or face means the point of the smooth surface
/// over it, which `position` tells.
///
/// Construction is linear in the mesh. A solve takes an exact one and a step for each face that
/// each vertex's path crosses: 4.4 to 7 times the exact one's time on 10,242 vertices of a sphere
/// and of needles, as benchmarks/pareto_benchmark.cpp prints, and more on larger meshes, whose
/// paths cross more faces. Queries are const and safe from several threads.
///
/// Distances that are not exact are no shorter way to the same: it is the paths that take the time.
/// On smooth meshes of 2,562 to 10,368 vertices, paths to which those of fast marching or virtual
/// sources lead were off by 2 to 2,500 times as much; (4 d1 - d0) / 3, d1 on the mesh with each
/// face split in four, was off by 0.03 to 0.12 % from fast marching, 0.002 to 0.01 % from virtual
/// sources. VirtualSourceSolver by itself takes a hundredth of the time, and is off by half to five
/// sixths of what exact distances on the mesh are. benchmarks/claims.cpp prints these errors.
template <std::floating_point T>
class SmoothDistanceSolver : public detail::DistanceQueries<SmoothDistanceSolver<T>, T> {
 public:
  /// With normals fitted to the vertices around each. Throws InvalidInput as Surface does, for a
  /// crease angle that is not between 0 and pi, a crease that is no edge.
  explicit SmoothDistanceSolver(const TriangleMesh auto& mesh, SmoothOptions<T> options = {})
      : SmoothDistanceSolver(Surface<double>(mesh, options.cancelled.part(0, 0)),
                             std::span<const std::array<T, 3>>(), false, options) {}

  /// With the surface's unit normals at the vertices, all on one side of it. At creases, where a
  /// vertex has several, they are fitted. Throws InvalidInput besides for normals that are not as
  /// many as vertices, not unit by more than 0.005, or against the faces where most are along them.
  SmoothDistanceSolver(const TriangleMesh auto& mesh, std::span<const std::array<T, 3>> normals,
                       SmoothOptions<T> options = {})
      : SmoothDistanceSolver(Surface<double>(mesh, options.cancelled.part(0, 0)), normals, true,
                             options) {}

  /// The mesh.
  [[nodiscard]] const Surface<double>& surface() const;

  /// The point of the smooth surface over a point of the mesh. Throws InvalidInput for a point that
  /// is not of the mesh.
  [[nodiscard]] Vec3<T> position(const SurfacePoint<T>& point) const;

  /// The unit normals at a vertex: one, and more where creases meet.
  [[nodiscard]] std::vector<Vec3<T>> normals(Index vertex) const;

  /// Solves from a vertex, several, or points with start distances. Throws InvalidInput as every
  /// solver does, Cancelled where the options' hook says so.
  ///@{
  [[nodiscard]] SmoothDistances<T> solve(Index vertex) const {
    return solve(std::span<const Index>(&vertex, 1));
  }
  [[nodiscard]] SmoothDistances<T> solve(std::initializer_list<Index> vertices) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  template <detail::OtherIntegers NotOfIndex>
  [[nodiscard]] SmoothDistances<T> solve(const NotOfIndex& vertices) const = delete;
  [[nodiscard]] SmoothDistances<T> solve(const Source<T>& source) const {
    return solve(std::span<const Source<T>>(&source, 1));
  }
  [[nodiscard]] SmoothDistances<T> solve(const SurfacePoint<T>& point) const {
    return solve(std::span<const SurfacePoint<T>>(&point, 1));
  }
  [[nodiscard]] SmoothDistances<T> solve(std::span<const Index> vertices) const;
  [[nodiscard]] SmoothDistances<T> solve(std::span<const Source<T>> sources) const;
  [[nodiscard]] SmoothDistances<T> solve(std::span<const SurfacePoint<T>> points) const;
  // A template, so that braces with nothing in them stand for vertices.
  template <detail::PointOf<T> Point = Source<T>>
  [[nodiscard]] SmoothDistances<T> solve(std::initializer_list<Point> points) const {
    return solve(std::span<const Point>(points.begin(), points.size()));
  }
  ///@}

  /// The path on the smooth surface from the source to a point; empty where none leads. Throws
  /// InvalidInput for a point that is not of the mesh, and distances on another mesh. The distances
  /// are those of this solver.
  ///@{
  [[nodiscard]] SmoothPath<T> path(const SmoothDistances<T>& distances, Index vertex) const {
    return path(distances, vertex_point<T>(vertex));
  }
  [[nodiscard]] SmoothPath<T> path(const SmoothDistances<T>& distances,
                                   const SurfacePoint<T>& point) const;
  ///@}

 private:
  friend class detail::DistanceQueries<SmoothDistanceSolver<T>, T>;
  using Engine = detail::SmoothEngine<T>;

  SmoothDistanceSolver(const Surface<double>& surface, std::span<const std::array<T, 3>> normals,
                       bool has_normals, const SmoothOptions<T>& options);

  void solve_vertices(detail::DistanceQuery<double>& query) const;

  std::shared_ptr<const Engine> engine_;
};

/// Deduces the type from the mesh.
template <TriangleMesh M>
explicit SmoothDistanceSolver(const M&) -> SmoothDistanceSolver<MeshScalar<M>>;
template <TriangleMesh M>
SmoothDistanceSolver(const M&, SmoothOptions<MeshScalar<M>>) -> SmoothDistanceSolver<MeshScalar<M>>;
template <TriangleMesh M, class Normals>
SmoothDistanceSolver(const M&, const Normals&) -> SmoothDistanceSolver<MeshScalar<M>>;
template <TriangleMesh M, class Normals>
SmoothDistanceSolver(const M&, const Normals&, SmoothOptions<MeshScalar<M>>)
    -> SmoothDistanceSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class detail::DistanceQueries<SmoothDistanceSolver<float>, float>;
GELIGHT_ONCE template class detail::DistanceQueries<SmoothDistanceSolver<double>, double>;
}  // namespace gelight
#endif
#if defined(GELIGHT_BODIES)
#include "gelight/geodesic/smooth/body.hpp"
#endif
