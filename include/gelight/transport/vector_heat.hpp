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
#include "gelight/geodesic/heat.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

namespace detail {
template <std::floating_point T>
class VectorHeatEngine;
}  // namespace detail

struct VectorHeatOptions {
  /// Time of the heat flow, in squared mean edge lengths.
  double time_factor = 1;
  /// Works on the intrinsic Delaunay triangulation of the same surface, on which thin triangles do
  /// no harm; false takes the mesh's own triangles.
  bool intrinsic_delaunay = true;
  /// Asked while the solver is set up, and in each query by the thread that makes it, which may
  /// have to factor a matrix first.
  CancelHook cancelled{};
};

/// Transported vectors, and how far they are to be trusted.
template <std::floating_point T>
struct TransportResult {
  std::vector<Vec3<T>> vectors;  ///< Of each vertex, in the mesh's space.
  /// Estimate of the mean of |vector - true vector| / |true vector| over the vertices reached, the
  /// true one being parallel along the shortest path from the nearest source: from up to 256 of
  /// them, paths that fast marching leads along, on which the vector is carried exactly.
  double error = 0;
  /// The error is at most 0.07; above, vectors may be off by more than a tenth on average.
  bool is_reliable = true;
};

/// A log map, and how far it is to be trusted.
template <std::floating_point T>
struct LogMapResult {
  std::vector<Vec2<T>> coordinates;  ///< Of each vertex; infinite where no path leads.
  /// Estimate of the mean of |coordinates - true coordinates| / distance over the vertices reached,
  /// at most 2 each: from up to 256 of them, paths that fast marching leads along.
  double error = 0;
  /// The error is at most 0.07; above, coordinates may be off by more than a tenth on average.
  bool is_reliable = true;
};

/// A vector to transport, and where it starts.
template <std::floating_point T>
struct VectorSource {
  SurfacePoint<T> point;  ///< where it starts
  Vec3<T> vector;         ///< in the mesh's space; its part along the normal is left out
};

/// Carries tangent vectors over a surface along its shortest paths by the vector heat method
/// (Sharp, Soliman, Crane 2019, doi:10.1145/3243651): sparse solves with matrices factored once.
///
/// Vectors go in and come out in the mesh's own space, one per vertex, tangent there. A vertex in a
/// part without a source, or in no face, gets the zero vector. At a vertex that shortest paths
/// reach with opposite vectors, such as the antipode on a sphere, the direction is arbitrary.
///
/// Mean errors by benchmarks/claims.cpp, against parallel transport along exact shortest paths: 0.5
/// and 0.2 degrees on icospheres of 2,562 and 10,242 vertices, 0.5 on the GelTip membrane, where a
/// hundredth of the vertices, at which paths fork, are off by more than 6; 9 on rough meshes like
/// a scanner's (the median of 24), up to 52, since what a path passes between counts: `solve`
/// tells, and ParallelTransport along ExactField::path is exact. Within an edge or two of the
/// antipode of a source without symmetry the carried vector is up to 17 degrees off on spheres.
template <std::floating_point T>
class VectorHeatSolver {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does, for faces that are not oriented alike, for edges of more
  /// than two faces, and for a time factor that is not positive or so large that products with it
  /// are not finite. Each matrix is factored when it is first needed: one to transport from a
  /// single source, one more for several sources and to extend, one more for the log map and for
  /// directions from a border.
  template <TriangleMesh M>
  explicit VectorHeatSolver(const M& mesh, const VectorHeatOptions& options = {})
      : VectorHeatSolver(Surface<double>(mesh, options.cancelled.part(0, 0)), nullptr, options) {}

  /// Shares the matrices of a HeatSolver, and its time factor and triangulation. Throws
  /// InvalidInput as above for its surface.
  explicit VectorHeatSolver(const HeatSolver<T>& heat, const CancelHook& cancelled = {});

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const;

  /// Two unit vectors, x and y, that span the tangent plane at a vertex; x cross y is the normal.
  /// They are those of ExactLogMapSolver (see TangentFrames).
  [[nodiscard]] std::array<Vec3<T>, 2> tangent_basis(Index vertex) const;

  /// Carries a vector from a vertex to all others. Its part in the vertex' tangent plane is what is
  /// carried, with its length. Throws InvalidInput for a vector that is not finite or normal to the
  /// surface, and a vertex out of range or without faces.
  [[nodiscard]] std::vector<Vec3<T>> transport(Index vertex, const Vec3<T>& vector) const;

  /// Carries each vector over the region nearest to its source, blended between them: directions
  /// over an edge or two, whatever the lengths; lengths as means of all, weighted by heat, so that
  /// one k times as long as its neighbour is felt some ln(k) mean edges beyond halfway.
  ///@{
  [[nodiscard]] std::vector<Vec3<T>> transport(std::span<const VectorSource<T>> sources) const;
  [[nodiscard]] std::vector<Vec3<T>> transport(
      std::initializer_list<VectorSource<T>> sources) const {
    return transport(std::span<const VectorSource<T>>(sources.begin(), sources.size()));
  }
  ///@}

  /// The same vectors as `transport` gives, with an estimate of their error, which `transport`
  /// alone does not tell. It costs a query of FastMarchingSolver besides. Throws InvalidInput as
  /// `transport` does.
  ///@{
  [[nodiscard]] TransportResult<T> solve(Index vertex, const Vec3<T>& vector) const;
  [[nodiscard]] TransportResult<T> solve(std::span<const VectorSource<T>> sources) const;
  [[nodiscard]] TransportResult<T> solve(std::initializer_list<VectorSource<T>> sources) const {
    return solve(std::span<const VectorSource<T>>(sources.begin(), sources.size()));
  }
  ///@}

  /// Unit vectors that point away from a vertex, along the shortest paths from it; zero at itself
  /// and where no path leads. Along an edge from the vertex they are exact. From a vertex on a
  /// border or beside one they are the gradient of HeatSolver's distance, which is less exact: 5 to
  /// 8 degrees off on average on a flat sheet of 16 x 16 cells, and a fifth less or better with
  /// twice as many each way, as a test holds. ExactField::direction is exact.
  [[nodiscard]] std::vector<Vec3<T>> radial(Index vertex) const;

  /// Coordinates of each vertex in the tangent plane of another, along its `tangent_basis`: as far
  /// as, and in the direction in which, the shortest path leaves. Infinite where no path leads.
  ///
  /// Exact within three mean edges of the vertex. Over all vertices, by benchmarks/claims.cpp,
  /// radius and direction are 0.3 to 0.4 % and 0.3 to 0.5 degrees off on average on icospheres of
  /// 2,562 and 10,242 vertices, 0.35 % and 1 degree on the GelTip membrane (at most 4.1 % and, at
  /// the cut locus, any angle), 1.3 % and 9 degrees on rough meshes like a scanner's (the median of
  /// 24), less exact from a vertex on a border (see `radial`), and far off on thin triangles with
  /// obtuse corners at the border: `solve_log_map` tells. ExactLogMapSolver is exact everywhere, in
  /// some thirty times the time.
  [[nodiscard]] std::vector<Vec2<T>> log_map(Index vertex) const;

  /// The same coordinates as `log_map` gives, with an estimate of their error, which `log_map`
  /// alone does not tell. It costs a query of FastMarchingSolver besides. Throws InvalidInput as
  /// `log_map` does.
  [[nodiscard]] LogMapResult<T> solve_log_map(Index vertex) const;

  /// Continues values given at some vertices to all others: about that of the nearest one, smoothly
  /// in between, never outside their range. NaN where no path leads. Throws InvalidInput for no
  /// vertices, another number of values, a value that is not finite, values of one vertex whose sum
  /// is not, a vertex out of range.
  ///@{
  [[nodiscard]] std::vector<T> extend(std::span<const Index> vertices,
                                      std::span<const T> values) const;
  [[nodiscard]] std::vector<T> extend(std::initializer_list<Index> vertices,
                                      std::span<const T> values) const {
    return extend(std::span<const Index>(vertices.begin(), vertices.size()), values);
  }
  [[nodiscard]] std::vector<T> extend(std::initializer_list<Index> vertices,
                                      std::initializer_list<T> values) const {
    return extend(vertices, std::span<const T>(values.begin(), values.size()));
  }
  ///@}

 private:
  using Engine = detail::VectorHeatEngine<T>;

  VectorHeatSolver(Surface<Real> surface, std::shared_ptr<const detail::HeatSystem<Real>> system,
                   const VectorHeatOptions& options);

  std::shared_ptr<const Engine> engine_;
};

template <TriangleMesh M>
explicit VectorHeatSolver(const M&) -> VectorHeatSolver<MeshScalar<M>>;
template <TriangleMesh M>
VectorHeatSolver(const M&, const VectorHeatOptions&) -> VectorHeatSolver<MeshScalar<M>>;
template <std::floating_point T>
explicit VectorHeatSolver(const HeatSolver<T>&) -> VectorHeatSolver<T>;

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/transport/vector_heat/body.hpp"
#endif
