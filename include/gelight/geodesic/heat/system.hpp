#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/heat/flow.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/operators.hpp"
#include "gelight/mesh/sparse_factor.hpp"
#include "gelight/mesh/sparse_matrix.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight::detail {

/// Heat and Poisson systems of a surface, each factored when it is first solved; shared by the
/// solvers that use them.
template <std::floating_point Real>
struct HeatSystem {
  using Pattern = SymmetricPattern<Real>;
  using Dissection = detail::Dissection<Real>;

  Real time_factor = 1;
  bool is_delaunay = false;
  Real mean_edge = 0;
  Real unit = 1;         // of the lengths below: the mean edge, or 1 if that is zero
  Array<Index> origins;  // of each half-edge of the triangulation
  Array<PlanarFace> faces;
  Array<Index> component;  // of each vertex
  std::shared_ptr<const Pattern> pattern;
  SymmetricMatrix<Real> heat;

  HeatSystem(const Surface<Real>& surface, Real time, bool intrinsic,
             LinearBackend<Real> backend = nullptr, const CancelHook& cancelled = {})
      : time_factor(time), is_delaunay(intrinsic), surface_(surface) {
    require(time_factor > 0 && std::isfinite(time_factor), "the heat's time factor is ",
            time_factor, ", not a positive number");
    mean_edge = mean_edge_length(surface);
    unit = mean_edge > 0 ? mean_edge : 1;
    triangulate(cancelled.part(0, 0.1));
    const auto mass = vertex_areas<Real>(faces, origins, pattern->size());
    heat = laplacian();
    for (Real& x : heat.values) x *= time_factor;
    for (Index v = 0; v < pattern->size(); ++v) {
      // A vertex without faces has no area; it is its own component and never heated.
      heat.values[pattern->diagonal(v)] += mass[v] > 0 ? mass[v] : 1;
    }
    for (const Real x : heat.values) {
      require(std::isfinite(x), "the heat's time factor is ", time_factor,
              ", so large that products with it are not finite");
    }
    (void)dissection(cancelled.part(0.1, 0.2));
    if (backend != nullptr) analysis_ = backend(*pattern, dissection()->order());
  }

  /// How much heat a source at a vertex takes, so that it is felt as far as any other: the angle
  /// of the faces there, in which its heat spreads, as a share of a whole turn. 1 where there are
  /// no faces. At a tip sharper than a corner of a rectangle it is that corner's: heat that has
  /// left the tip spreads as from any other place.
  [[nodiscard]] Real share_of_turn(Index v) const {
    using namespace arithmetic;
    Real angle = 0;
    for (const Index h : surface_.corners(v)) {
      const Vec3<Real> a = surface_.position(surface_.tip(h)) - surface_.position(v);
      const Vec3<Real> b = surface_.position(surface_.apex(h)) - surface_.position(v);
      angle += std::atan2(norm(cross<Real>(a, b)), dot(a, b));
    }
    constexpr Real least = 0.25;
    return angle > 0 ? std::max(least, angle / (2 * std::numbers::pi_v<Real>)) : 1;
  }

  using Factor = std::shared_ptr<const LinearFactor<Real>>;

  /// Made when it is asked for: what needs it longer are factors.
  [[nodiscard]] SymmetricMatrix<Real> laplacian() const {
    return cotan_laplacian<Real>(faces, origins, pattern);
  }

  /// Of a matrix of the pattern.
  [[nodiscard]] Factor factor(SymmetricMatrix<Real> matrix,
                              const CancelHook& cancelled = {}) const {
    if (analysis_ == nullptr) {
      return std::make_shared<SparseFactor<Real>>(
          factored(dissection(), std::move(matrix), cancelled));
    }
    cancelled.check(0, "factoring a matrix");
    return factored(std::move(matrix),
                    [&](const auto& positive) { return analysis_->factor(positive); });
  }

  /// The order in which our own factors eliminate.
  [[nodiscard]] const std::shared_ptr<const Dissection>& dissection(
      const CancelHook& cancelled = {}) const {
    return lazy_dissection_.get([&] { return dissected(surface_, *pattern, cancelled); });
  }

  [[nodiscard]] const LinearFactor<Real>& heat_factor(const CancelHook& cancelled = {}) const {
    return *lazy_heat_.get([&] { return factor(heat, cancelled); });
  }

  /// Of the Laplacian. A constant per component is free: it is taken out by holding one vertex at
  /// zero.
  [[nodiscard]] const LinearFactor<Real>& poisson_factor(const CancelHook& cancelled = {}) const {
    return *lazy_poisson_.get([&] {
      Array<char> held(component.size(), 0);
      for (Index v = 0; v < pattern->size(); ++v) held[v] = component[v] == v;
      return factor(with_held(laplacian(), held), cancelled);
    });
  }

  void triangulate(const CancelHook& cancelled) {
    auto mesh = is_delaunay ? intrinsic_delaunay(surface_, unit, cancelled)
                            : intrinsic_triangulation(surface_, unit);
    faces = planar_faces(mesh);
    component = component_of_vertices(mesh);
    pattern = std::make_shared<Pattern>(mesh);
    origins = std::move(mesh.origins);
  }

  static std::shared_ptr<const Dissection> dissected(const Surface<Real>& surface,
                                                     const Pattern& pattern,
                                                     const CancelHook& cancelled) {
    std::vector<Vec3<Real>> points;
    points.reserve(static_cast<std::size_t>(surface.vertex_count()));
    for (Index v = 0; v < surface.vertex_count(); ++v) points.push_back(surface.position(v));
    return std::make_shared<Dissection>(pattern, points, cancelled);
  }

  /// The matrix with the rows and columns of some vertices replaced by the identity's.
  static SymmetricMatrix<Real> with_held(SymmetricMatrix<Real> matrix, const Array<char>& held) {
    const auto& pattern = *matrix.pattern;
    for (Index j = 0; j < pattern.size(); ++j) {
      for (Index e = pattern.begin(j); e < pattern.begin(j + 1); ++e) {
        if (held[j] || held[pattern.row(e)]) matrix.values[e] = pattern.row(e) == j ? 1 : 0;
      }
    }
    return matrix;
  }

  /// Puts where each unit field's integrated divergence is the function, up to a constant per
  /// component, whose gradient is nearest to the field.
  void integrate(std::span<const std::span<Real>> divergences, const CancelHook& cancelled) const {
    for (const Slice<Real> divergence : divergences) {
      for (Index v = 0; v < pattern->size(); ++v) {
        if (component[v] == v) divergence[v] = 0;
      }
    }
    poisson_factor().solve_each(divergences, cancelled);
  }

  /// Throws InvalidInput unless the system was made of a surface that is the same number by number.
  void require_made_of(const Surface<Real>& surface) const {
    require_same_mesh(surface, surface_, "the system was");
  }

  /// 1 for each vertex in the component of a vertex with a load.
  ///@{
  template <class Scalar>
  [[nodiscard]] Array<char> reached_from(const Array<Scalar>& load) const {
    Array<char> reached;
    mark_reached(load, reached);
    return reached;
  }
  template <class Scalar>
  void mark_reached(const Array<Scalar>& load, Array<char>& reached) const {
    reached.assign(load.size(), 0);
    for (Index v = 0; v < pattern->size(); ++v) {
      if (magnitude(load[v]) > 0) reached[component[v]] = 1;
    }
    for (Index v = 0; v < pattern->size(); ++v) reached[v] = reached[component[v]];
  }
  ///@}

 private:
  Surface<Real> surface_;
  std::shared_ptr<const LinearAnalysis<Real>> analysis_;  // by a backend, where there is one
  Lazy<std::shared_ptr<const Dissection>> lazy_dissection_;
  Lazy<Factor> lazy_heat_, lazy_poisson_;
};

}  // namespace gelight::detail

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template struct detail::HeatSystem<double>;
}  // namespace gelight
#endif
