#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/transport/tangent_planes.hpp"

namespace gelight {

struct ExactLogMapOptions {
  /// Asked in every query of the solver and of its maps, by the thread that called; not by two at
  /// once if the callable is not made for it. A map keeps it, so what it refers to has to live as
  /// long. A query at one point tells 0.
  CancelHook cancelled = {};
};

/// The exact log map of one source: where points lie in its tangent plane, as far as and in the
/// direction in which the shortest path to each leaves. Made by ExactLogMapSolver.
template <std::floating_point T>
class ExactLogMap {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Two unit vectors, x and y, along which coordinates are counted.
  [[nodiscard]] const std::array<Vec3<T>, 2>& tangent_basis() const { return basis_; }

  /// Coordinates of a point, in the unit of the positions; infinite where no path leads. Throws
  /// InvalidInput for a point that is not of the surface. As many steps as the path has faces.
  ///@{
  [[nodiscard]] Vec2<T> operator()(Index vertex) const { return (*this)(vertex_point<T>(vertex)); }
  [[nodiscard]] Vec2<T> operator()(const SurfacePoint<T>& point) const {
    const T distance = field_.distance(point);
    if (!(distance < unreachable<T>)) return {unreachable<T>, unreachable<T>};
    if (!(distance > 0)) return {0, 0};
    const ExactDeparture<T> way = field_.departure(point);
    const Index face = Surface<Real>::face_of(way.halfedge);
    const Real angle = planes_->angle_at(
        source_, face, planes_->side_angle(way.halfedge) + static_cast<Real>(way.angle));
    return {distance * static_cast<T>(std::cos(angle)), distance * static_cast<T>(std::sin(angle))};
  }
  ///@}

  /// Coordinates of all vertices. Throws Cancelled where the solver's hook says so.
  [[nodiscard]] std::vector<Vec2<T>> at_vertices() const { return at_vertices(cancelled_); }

  /// Whether a point is on the cut locus: reached by two paths from different sides of which the
  /// longer has at most (1 + relative_tolerance) times the length of the shorter. Its coordinates
  /// are then those of one of the two.
  ///@{
  [[nodiscard]] bool is_on_cut_locus(Index vertex, T relative_tolerance) const {
    return is_on_cut_locus(vertex_point<T>(vertex), relative_tolerance);
  }
  [[nodiscard]] bool is_on_cut_locus(const SurfacePoint<T>& point, T relative_tolerance) const {
    return field_.arrivals(point, relative_tolerance).size() > 1;
  }
  ///@}

  /// The distances and paths that the map is made of.
  [[nodiscard]] const ExactField<T>& field() const { return field_; }

 private:
  template <std::floating_point>
  friend class ExactLogMapSolver;

  // A path to a vertex takes some microseconds.
  static constexpr Index vertices_between_polls = 256;

  ExactLogMap(std::shared_ptr<const detail::TangentPlanes<Real>> planes, SurfacePoint<Real> source,
              ExactField<T> field, CancelHook cancelled)
      : planes_(std::move(planes)),
        source_(source),
        field_(std::move(field)),
        cancelled_(std::move(cancelled)) {
    const TangentBasis<Real> basis = planes_->basis(source_);
    basis_ = {cast<T>(basis.x), cast<T>(basis.y)};
  }

  [[nodiscard]] std::vector<Vec2<T>> at_vertices(const CancelHook& cancelled) const {
    const Index count = planes_->surface().vertex_count();
    std::vector<Vec2<T>> out;
    out.reserve(static_cast<std::size_t>(count));
    for (Index v = 0; v < count; ++v) {
      if (v % vertices_between_polls == 0) {
        cancelled.check(static_cast<double>(v) / count, "an exact log map");
      }
      out.push_back((*this)(v));
    }
    return out;
  }

  std::shared_ptr<const detail::TangentPlanes<Real>> planes_;
  SurfacePoint<Real> source_;
  ExactField<T> field_;
  CancelHook cancelled_;
  std::array<Vec3<T>, 2> basis_;
};

/// Exact log maps: distances by ExactSolver, directions by following each path back to its source.
///
/// Angles at a source vertex are those of `TangentFrames`, scaled to sum to 2 pi round it. Error:
/// rounding alone, but for sources and points nearer to a vertex than a millionth of the edges
/// there: up to about how far they are from it. On the GelTip membrane a map of all 14,124 vertices
/// takes about three times as long as their distances.
template <std::floating_point T>
class ExactLogMapSolver {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does, for faces that are not oriented alike, and for edges of
  /// more than two faces.
  template <TriangleMesh M>
  explicit ExactLogMapSolver(const M& mesh, const ExactLogMapOptions& options = {})
      : planes_(std::make_shared<const detail::TangentPlanes<Real>>(
            Surface<Real>(mesh, options.cancelled.part(0, 0)), options.cancelled.part(0, 0))),
        solver_(planes_->surface()),
        cancelled_(options.cancelled) {}

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return planes_->surface(); }

  /// The map of a source. Throws InvalidInput for a point that is not of the surface or a vertex
  /// without faces, Cancelled where the hook says so.
  ///@{
  [[nodiscard]] ExactLogMap<T> solve(Index source) const { return solve(vertex_point<T>(source)); }
  [[nodiscard]] ExactLogMap<T> solve(const SurfacePoint<T>& source) const {
    return solve(source, cancelled_);
  }
  ///@}

  /// Coordinates of all vertices in a vertex' tangent plane, along its `tangent_basis`; infinite
  /// where no path leads. Throws as `solve` does.
  [[nodiscard]] std::vector<Vec2<T>> log_map(Index source) const {
    const CancelHook cancelled = detail::rising(cancelled_, "an exact log map");
    return solve(vertex_point<T>(source), cancelled.part(0, distances_share))
        .at_vertices(cancelled.part(distances_share, 1));
  }

  /// Two unit vectors, x and y, along which a vertex' coordinates are counted. Throws InvalidInput
  /// for a vertex that is not of the surface.
  [[nodiscard]] std::array<Vec3<T>, 2> tangent_basis(Index vertex) const {
    surface().require_vertex(vertex);
    const TangentBasis<Real>& basis = planes_->frames().basis(vertex);
    return {cast<T>(basis.x), cast<T>(basis.y)};
  }

 private:
  // Of the work on a map of all vertices.
  static constexpr double distances_share = 0.3;

  [[nodiscard]] ExactLogMap<T> solve(const SurfacePoint<T>& source,
                                     const CancelHook& cancelled) const {
    surface().require_point(source);
    const auto point = detail::simplified(surface(), source.template cast<Real>());
    if (point.kind == SurfacePoint<Real>::Kind::vertex) {
      detail::require(!surface().corners(point.element[0]).empty(), "vertex ", point.element[0],
                      " is in no face, it has no tangent plane");
    }
    return {planes_, point, solver_.solve(source, {.cancelled = cancelled}), cancelled};
  }

  std::shared_ptr<const detail::TangentPlanes<Real>> planes_;
  ExactSolver<T> solver_;
  CancelHook cancelled_;
};

template <TriangleMesh M>
explicit ExactLogMapSolver(const M&) -> ExactLogMapSolver<MeshScalar<M>>;
template <TriangleMesh M>
ExactLogMapSolver(const M&, const ExactLogMapOptions&) -> ExactLogMapSolver<MeshScalar<M>>;

}  // namespace gelight
