#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/heat/flow.hpp"
#include "gelight/geodesic/sampled_error.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/linear_factor.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/operators.hpp"
#include "gelight/mesh/sparse_factor.hpp"
#include "gelight/mesh/surface.hpp"

namespace gelight {

/// What heat does at a surface's border: it is held back, let out, or the mean of both, which bends
/// the isolines least.
enum class HeatBoundary { neumann, dirichlet, averaged };

struct HeatOptions {
  /// Time of the heat flow, in squared mean edge lengths. More smooths the distance, less makes it
  /// follow the mesh's edges.
  double time_factor = 1;
  /// On a border vertex, and where a face has no vertex off the border, always neumann.
  HeatBoundary boundary = HeatBoundary::neumann;
  /// Within this many mean edge lengths of the sources the distance is exact (by ExactSolver), and
  /// the heat continues it, which removes the error beside the source. 0 leaves heat alone.
  double exact_radius = 3;
  /// How often the unit field is taken anew from the distance found, for one more solve each:
  /// the first takes the mean error from 0.31 to 0.15 % on spheres, from 1.43 to 1.22 % on
  /// scan-like meshes. Where fronts meet, gradients stay as short as they are found.
  Index refinements = 0;
  /// Works on the intrinsic Delaunay triangulation of the same surface, on which thin triangles do
  /// no harm; false takes the mesh's own triangles. Mean errors on scan-like meshes, of all and of
  /// the worst source: 1.4 and 4.8 % with it, 5.8 and 58 % without, for 4 to 5 % more set-up.
  bool intrinsic_delaunay = true;
  /// What factors the matrices: gelight's own, or another library (`cholmod_backend` of
  /// mesh/cholmod.hpp).
  LinearBackend<double> backend = nullptr;
  /// Asked while the solver is set up, and in each query by the thread that makes it. A matrix'
  /// last blocks, and another library's solves, are each one step.
  CancelHook cancelled{};
};

namespace detail {

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
    (void)dissection(cancelled.part(0.1, 0.2));
    if (backend != nullptr) analysis_ = backend(*pattern, dissection()->order());
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
  void integrate(std::span<Array<Real>> divergences, const CancelHook& cancelled) const {
    std::vector<std::span<Real>> sides;
    for (Array<Real>& divergence : divergences) {
      for (Index v = 0; v < pattern->size(); ++v) {
        if (component[v] == v) divergence[v] = 0;
      }
      sides.emplace_back(divergence);
    }
    poisson_factor().solve_each(sides, cancelled);
  }

  /// Throws InvalidInput unless the system was made of a surface that is the same number by number.
  void require_made_of(const Surface<Real>& surface) const {
    require(surface.vertex_count() == surface_.vertex_count() &&
                surface.face_count() == surface_.face_count(),
            "the system was made of another mesh, of ", surface_.vertex_count(), " vertices and ",
            surface_.face_count(), " faces, not ", surface.vertex_count(), " and ",
            surface.face_count());
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      require(surface.position(v) == surface_.position(v),
              "the system was made of another mesh: its vertex ", v, " lies elsewhere");
    }
    for (Index f = 0; f < surface.face_count(); ++f) {
      require(surface.face(f) == surface_.face(f), "the system was made of another mesh: its face ",
              f, " has other vertices");
    }
  }

  /// 1 for each vertex in the component of a vertex with a load.
  template <class Scalar>
  [[nodiscard]] Array<char> reached_from(const Array<Scalar>& load) const {
    Array<char> reached(load.size(), 0);
    for (Index v = 0; v < pattern->size(); ++v) {
      if (magnitude(load[v]) > 0) reached[component[v]] = 1;
    }
    for (Index v = 0; v < pattern->size(); ++v) reached[v] = reached[component[v]];
    return reached;
  }

 private:
  Surface<Real> surface_;
  std::shared_ptr<const LinearAnalysis<Real>> analysis_;  // by a backend, where there is one
  Lazy<std::shared_ptr<const Dissection>> lazy_dissection_;
  Lazy<Factor> lazy_heat_, lazy_poisson_;
};

}  // namespace detail

/// Distances by heat, and how far they are to be trusted.
template <std::floating_point T>
struct HeatResult {
  std::vector<T> distance;  ///< Of each vertex, +infinity where no path leads.
  /// Estimate of the mean of |distance / true distance - 1| over the vertices that are reached,
  /// both counted from the earliest source of their connected part: from up to 256 of them, paths
  /// are followed back through the distances and pulled taut, whose lengths do not depend on how
  /// long heat says they are. On scan_meshes(4), 30 sources each, none of the 98 answers off by
  /// more than a tenth that the meshes' own triangles give is missed; of 720 default answers, all
  /// off by less than a twentieth, none is flagged. With exact_radius = 0, 3 % of good answers are.
  double error = 0;
  /// Mean of | |gradient| - 1 |, by area, over the faces where heat decides: a distance has 0. It
  /// tells roughness and thin faces more than it tells errors.
  double residual = 0;
  /// The error is more than 0.07: distances may be off by more than a tenth on average. (Try a
  /// larger exact_radius, refinements, or another solver.)
  bool is_too_coarse = false;
  /// Some vertices are too far for the time of the flow: no heat arrived, however little. Their
  /// distances mean nothing. (Try a larger time_factor.)
  bool is_too_far = false;
  /// Neither of the two.
  bool is_reliable = true;
};

/// Distance by the heat method (Crane, Weischedel, Wardetzky 2013, doi:10.1145/2516971.2516977): a
/// smooth approximation by two sparse solves with matrices factored once.
///
/// Works on lengths alone: faces of any orientation, edges of any number of faces, faces without
/// area. Each connected part is on its own; one without a source is +infinity. Sources that start
/// at different distances cost a solve for each such distance.
///
/// Error, 30 sources each (benchmarks/heat_error_benchmark.cpp), mean and largest: icospheres of
/// 642 to 10,242 vertices 0.31 and 2.5 %, 0.15 and 2.0 % with one refinement, heat alone
/// (exact_radius = 0) 1.05 and 17 %; the rough, creased, bordered and thin meshes of
/// scan_meshes(4) 1.4 and 20 %, 1.2 and 17 %, 1.5 and 100 %. Graded meshes are worst, since the
/// time is that of the mean edge: `solve` tells. Heat alone improves as spheres are refined, with
/// order 0.4 to 0.7: in a time of one squared edge heat never forgets the mesh. Set-up takes about
/// n^1.5, a query n log n.
template <std::floating_point T>
class HeatSolver : public detail::DistanceQueries<HeatSolver<T>, T> {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does, and for a time factor that is not positive, an exact
  /// radius or a number of refinements that is negative.
  template <TriangleMesh M>
  explicit HeatSolver(const M& mesh, const HeatOptions& options = {})
      : HeatSolver(Surface<Real>(mesh, options.cancelled.part(0, 0)), options, nullptr) {}

  /// Shares the factored systems of another solver of the same surface, where there is one; their
  /// time factor, triangulation and backend then hold instead of the options'. Throws InvalidInput
  /// for systems of any other surface.
  HeatSolver(Surface<Real> surface, const HeatOptions& options,
             std::shared_ptr<const detail::HeatSystem<Real>> system)
      : surface_(std::move(surface)), options_(options), system_(std::move(system)) {
    set_up(options);
  }

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

  /// The same distances as `distance` gives, with an estimate of their error and flags where they
  /// are not to be trusted, which `distance` alone does not tell. Some 5 to 13 % more work
  /// than `distance` at 10,000 vertices, several times that where the estimate is close to the
  /// limit. Throws InvalidInput as `distance` does.
  ///@{
  [[nodiscard]] HeatResult<T> solve(Index vertex) const {
    return solve(std::span<const Index>(&vertex, 1));
  }
  [[nodiscard]] HeatResult<T> solve(std::span<const Index> vertices) const;
  [[nodiscard]] HeatResult<T> solve(std::span<const Source<T>> sources) const;
  ///@}

  /// Distances of all vertices from each of a few sources alone, bit for bit those of `distance`:
  /// eight at once read the factors once. `distance_rows` asks so. Throws InvalidInput as
  /// `distance` does.
  ///@{
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::span<const Index> vertices) const {
    return solve_each(vertices);
  }
  [[nodiscard]] std::vector<std::vector<T>> distance_from_each(
      std::span<const Source<T>> sources) const {
    return solve_each(sources);
  }
  ///@}

  /// The factored systems, for solvers that share them.
  [[nodiscard]] const std::shared_ptr<const detail::HeatSystem<Real>>& system() const {
    return system_;
  }

 private:
  friend class detail::DistanceQueries<HeatSolver<T>, T>;
  template <std::floating_point>
  friend class VectorHeatSolver;
  using Points = std::vector<SurfacePoint<Real>>;

  struct Solution {
    detail::Array<Real> distance;  // from the start
    detail::Array<char> is_exact;  // of each vertex
    bool is_too_far = false;
    detail::Starts<Real> starts{};

    [[nodiscard]] Real distance_of(Index v) const { return starts.at(v) + distance[v]; }
  };

  // Above this estimate, a mean error of a tenth is possible: see HeatResult::error.
  static constexpr Real largest_error = 0.07;
  // Below it the error is much the same everywhere.
  static constexpr Real even_residual = 0.1;
  // A face whose gradient is shorter lies where fronts meet, and so does the true distance's.
  // Lengthening it would lift what lies beyond.
  static constexpr Real shortest_gradient = 0.97;

  void set_up(const HeatOptions& options);

  void solve_vertices(detail::DistanceQuery<Real>& query) const;

  template <class Place>
  [[nodiscard]] std::vector<std::vector<T>> solve_each(std::span<const Place> places) const {
    std::vector<detail::Sources> queries;
    for (std::size_t i = 0; i < places.size(); ++i) {
      queries.push_back(detail::checked_sources(surface_, places.subspan(i, 1)));
    }
    std::vector<std::vector<T>> result;
    for (const Solution& solution : solutions(std::move(queries), hook())) {
      result.push_back(distances_of(solution));
    }
    return result;
  }

  // Points that start at the same distance, of the sources of a query.
  struct Part {
    std::size_t query;
    Real start;
    Points points;
  };
  // So many are solved at once, for which the factors are read once.
  static constexpr std::size_t parts_at_once = 8;

  [[nodiscard]] Solution solution(detail::Sources sources) const {
    return solution(std::move(sources), hook());
  }
  [[nodiscard]] Solution solution(detail::Sources sources, const CancelHook& cancelled) const {
    return std::move(solutions({std::move(sources)}, cancelled).front());
  }
  [[nodiscard]] CancelHook hook() const {
    return detail::rising(options_.cancelled, "a query of the heat solver");
  }

  [[nodiscard]] std::vector<Solution> solutions(std::vector<detail::Sources> queries,
                                                const CancelHook& cancelled) const {
    std::vector<Solution> nearest;
    std::vector<Part> parts;
    for (detail::Sources& sources : queries) {
      nearest.push_back({{}, {}, false, detail::move_to_zero(surface_, sources)});
      add_parts(std::move(sources), nearest.size() - 1, parts);
    }
    for (std::size_t done = 0; done < parts.size();) {
      const auto some =
          std::span<const Part>(parts).subspan(done, std::min(parts.size() - done, parts_at_once));
      const double share = 1 / static_cast<double>(parts.size());
      const auto found =
          distances_from(some, cancelled.part(share * static_cast<double>(done),
                                              share * static_cast<double>(done + some.size())));
      for (std::size_t i = 0; i < some.size(); ++i) {
        take_nearer(nearest[some[i].query], some[i].start, found[i]);
      }
      done += some.size();
    }
    return nearest;
  }

  void add_parts(detail::Sources sources, std::size_t query, std::vector<Part>& parts) const {
    const auto later = [](const auto& a, const auto& b) { return a.distance < b.distance; };
    std::stable_sort(sources.begin(), sources.end(), later);
    for (auto first = sources.begin(); first != sources.end();) {
      const auto last = std::upper_bound(first, sources.end(), *first, later);
      Points points;
      for (auto s = first; s != last; ++s) {
        const auto point = detail::simplified(surface_, s->point);
        if (std::find(points.begin(), points.end(), point) == points.end()) points.push_back(point);
      }
      parts.push_back({query, first->distance, std::move(points)});
      first = last;
    }
  }

  void take_nearer(Solution& nearest, Real start, const Solution& part) const {
    nearest.distance.resize(part.distance.size(), unreachable<Real>);  // at the first
    nearest.is_exact.resize(part.is_exact.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const Real d = start + part.distance[v];
      if (!(d < nearest.distance[v])) continue;
      nearest.distance[v] = d;
      nearest.is_exact[v] = part.is_exact[v];
    }
    nearest.is_too_far |= part.is_too_far;
  }

  [[nodiscard]] std::vector<T> distances_of(const Solution& solution) const {
    std::vector<T> result;
    result.reserve(solution.distance.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      result.push_back(detail::distance_as<T>(solution.distance_of(v), "vertex ", v));
    }
    return result;
  }

  [[nodiscard]] HeatResult<T> result_of(const Solution& solution) const {
    HeatResult<T> result;
    result.distance = distances_of(solution);
    result.residual = residual_of(solution);
    // Where few vertices have most of the error, few paths miss it.
    const Index samples = result.residual < even_residual ? 16 : 64;
    result.error = detail::sampled_error(surface_, solution.distance, solution.is_exact,
                                         largest_error, samples);
    result.is_too_coarse = result.error > largest_error;
    result.is_too_far = solution.is_too_far;
    result.is_reliable = !result.is_too_coarse && !result.is_too_far;
    return result;
  }

  [[nodiscard]] Real residual_of(const Solution& solution) const {
    Real sum = 0, total = 0;
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto d = values_at(f, solution.distance);
      const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
      const auto& is_exact = solution.is_exact;
      if (!(d[0] < unreachable<Real>) || (is_exact[v[0]] && is_exact[v[1]] && is_exact[v[2]])) {
        continue;
      }
      const auto& face = system_->faces[f];
      const Real double_area = face.x1 * face.y2;
      const Real steepness = scaled_gradient(face, d).norm() / double_area / system_->unit;
      sum += double_area * std::abs(steepness - 1);
      total += double_area;
    }
    return total > 0 ? sum / total : 0;
  }

  using Flow = detail::HeatFlow<Real>;

  [[nodiscard]] std::vector<Solution> distances_from(std::span<const Part> parts,
                                                     const CancelHook& cancelled) const {
    std::vector<detail::Array<Real>> near;
    std::vector<detail::Array<char>> reached;
    std::vector<Flow> heats, held_heats;
    const auto whole = static_cast<double>(parts.size());
    for (const Part& part : parts) {
      const auto done = static_cast<double>(near.size());
      auto load = load_of(part.points);
      reached.push_back(system_->reached_from(load));
      near.push_back(
          near_distance(part.points, cancelled.part(0.2 * done / whole, 0.2 * (done + 1) / whole)));
      if (border_factor_) held_heats.push_back(held_flow(load));
      heats.emplace_back(system_->heat, std::move(load), reached.back());
    }
    detail::finish<Real>(heats, system_->heat_factor(), cancelled.part(0.2, 0.4));
    if (border_factor_) {
      detail::finish<Real>(held_heats, *border_factor_, cancelled.part(0.4, 0.6));
    }
    const auto first_field = [&](std::size_t i) {
      const auto* const held = border_factor_ ? &held_heats[i].result() : nullptr;
      return [this, held, &free = heats[i].result()](Index f) {
        return held != nullptr ? averaged_descent(f, *held, free) : descent(f, free);
      };
    };
    const double each = 0.4 / (1 + options_.refinements);  // of the work, from 0.6 on
    auto phi = continued(near, first_field, cancelled.part(0.6, 0.6 + each));
    for (Index k = 1; k <= options_.refinements; ++k) {
      const double done = 0.6 + k * each;
      const auto field = [&](std::size_t i) {
        return [this, &from = phi[i]](Index f) { return refined_field(f, from); };
      };
      phi = continued(near, field, cancelled.part(done, done + each));
    }
    std::vector<Solution> result;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      result.push_back(
          {placed(std::move(phi[i]), near[i], reached[i]), detail::Array<char>(near[i].size(), 0)});
      for (Index v = 0; v < surface_.vertex_count(); ++v) {
        result[i].is_exact[v] = near[i][v] < unreachable<Real>;
      }
      result[i].is_too_far = heats[i].result().unknown > 0;
    }
    return result;
  }

  // Distance, in units, of the vertices close to the points; infinite elsewhere.
  [[nodiscard]] detail::Array<Real> near_distance(const Points& points,
                                                  const CancelHook& cancelled) const {
    detail::Array<Real> near(static_cast<std::size_t>(surface_.vertex_count()), unreachable<Real>);
    if (exact_ && system_->mean_edge > 0) {
      detail::Array<Source<Real>> sources;
      for (const auto& point : points) sources.push_back({point, 0});
      ExactOptions<Real> options{.max_distance = options_.exact_radius * system_->mean_edge};
      if (cancelled) {
        options.cancelled = [&cancelled] {
          cancelled.check(0, "a query of the heat solver");
          return false;
        };
      }
      const auto field = exact_->solve(sources, options);
      for (Index v = 0; v < surface_.vertex_count(); ++v) near[v] = field.distance(v);
    }
    for (const auto& point : points) {
      detail::for_each_vertex_near(surface_, point,
                                   [&](Index v, Real d) { near[v] = std::min(near[v], d); });
    }
    for (Real& d : near) d /= system_->unit;
    return near;
  }

  // Functions, each with the gradient that is nearest to that of a near distance where that is
  // known at all vertices of a face, to `unit_field(number)(face)` elsewhere.
  [[nodiscard]] std::vector<detail::Array<Real>> continued(
      const std::vector<detail::Array<Real>>& near, const auto& unit_field,
      const CancelHook& cancelled) const {
    std::vector<detail::Array<Real>> result;
    for (std::size_t i = 0; i < near.size(); ++i) {
      result.push_back(divergence(near[i], unit_field(i)));
    }
    system_->integrate(result, cancelled);
    return result;
  }

  [[nodiscard]] detail::Array<Real> divergence(const detail::Array<Real>& near,
                                               const auto& unit_field) const {
    detail::Array<Real> sums(near.size(), 0);
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto d = values_at(f, near);
      const auto& face = system_->faces[f];
      const bool is_near = std::max({d[0], d[1], d[2]}) < unreachable<Real>;
      const Vec2<Real> field =
          is_near ? Vec2<Real>(scaled_gradient(face, d) / (face.x1 * face.y2)) : unit_field(f);
      const auto at = integrated_divergence(face, field);
      for (Index k = 0; k < 3; ++k) {
        sums[system_->origins[3 * f + k]] += at[static_cast<std::size_t>(k)];
      }
    }
    return sums;
  }

  [[nodiscard]] std::array<Real, 3> values_at(Index f, const detail::Array<Real>& u) const {
    const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
    return {u[v[0]], u[v[1]], u[v[2]]};
  }

  [[nodiscard]] detail::Array<Real> load_of(const Points& points) const {
    using Kind = typename SurfacePoint<Real>::Kind;
    detail::Array<Real> load(static_cast<std::size_t>(surface_.vertex_count()), 0);
    for (const auto& point : points) {
      std::array<Index, 3> vertices{point.element[0], point.element[1], 0};
      if (point.kind == Kind::face) vertices = surface_.face(point.element[0]);
      const std::size_t count = point.kind == Kind::vertex ? 1 : point.kind == Kind::edge ? 2 : 3;
      for (std::size_t k = 0; k < count; ++k) load[vertices[k]] += point.weights[k];
    }
    return load;
  }

  // Heat that is held at zero at the border.
  [[nodiscard]] Flow held_flow(detail::Array<Real> load) const {
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (is_border_[v]) load[v] = 0;
    }
    auto reached = system_->reached_from(load);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (is_border_[v]) reached[v] = 0;
    }
    return Flow(border_heat_, std::move(load), reached);
  }

  // Mean of the directions in which heat descends that is free at the border and that is held at
  // zero there (or the latter alone). Directions are averaged rather than heats: far from the
  // source one of the heats would outweigh the other.
  [[nodiscard]] Vec2<Real> averaged_descent(Index f, const detail::ScaledField<Real>& held,
                                            const detail::ScaledField<Real>& free) const {
    const Real share = options_.boundary == HeatBoundary::dirichlet ? 0 : 1;
    const Vec2<Real> a = descent(f, held), b = descent(f, free);
    const Vec2<Real> mixed = a + (a.isZero(0) ? 1 : share) * b;
    const Real norm = mixed.norm();
    return norm > 0 ? Vec2<Real>(mixed / norm) : mixed;
  }

  // Unit direction in which heat falls, or zero where it is the same at all three vertices.
  [[nodiscard]] Vec2<Real> descent(Index f, const detail::ScaledField<Real>& heat) const {
    const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
    const std::array<Index, 3> exponent{heat.exponent[v[0]], heat.exponent[v[1]],
                                        heat.exponent[v[2]]};
    const Index largest = std::max({exponent[0], exponent[1], exponent[2]});
    auto u = values_at(f, heat.value);
    for (std::size_t k = 0; k < 3; ++k) {
      if (exponent[k] != largest) u[k] = std::ldexp(u[k], exponent[k] - largest);
    }
    const Real most = std::max({std::abs(u[0]), std::abs(u[1]), std::abs(u[2])});
    if (most == 0) return Vec2<Real>::Zero();
    return unit_gradient(f, {-u[0] / most, -u[1] / most, -u[2] / most});
  }

  [[nodiscard]] Vec2<Real> refined_field(Index f, const detail::Array<Real>& phi) const {
    const auto& face = system_->faces[f];
    const Vec2<Real> g = scaled_gradient(face, values_at(f, phi)) / (face.x1 * face.y2);
    const Real norm = g.norm();
    return norm > 0 ? Vec2<Real>(g / std::max(norm, shortest_gradient)) : g;
  }

  [[nodiscard]] Vec2<Real> unit_gradient(Index f, const std::array<Real, 3>& u) const {
    const Vec2<Real> g = scaled_gradient(system_->faces[f], u);
    const Real norm = g.norm();
    return norm > 0 ? Vec2<Real>(g / norm) : g;
  }

  // Shifts each component so that it agrees with the near distance on average, and gives the near
  // vertices that distance.
  [[nodiscard]] detail::Array<Real> placed(detail::Array<Real> phi, const detail::Array<Real>& near,
                                           const detail::Array<char>& reached) const {
    detail::Array<Real> shift(phi.size(), 0), count(phi.size(), 0);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (near[v] == unreachable<Real>) continue;
      const Index c = system_->component[v];
      shift[c] += phi[v] - near[v];
      count[c] += 1;
    }
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const Index c = system_->component[v];
      if (!reached[v]) {
        phi[v] = unreachable<Real>;
      } else if (near[v] < unreachable<Real>) {
        phi[v] = system_->mean_edge * near[v];
      } else {
        phi[v] = system_->mean_edge * std::max(0.0, phi[v] - shift[c] / count[c]);
      }
    }
    return phi;
  }

  void hold_border(const CancelHook& cancelled) {
    is_border_.assign(static_cast<std::size_t>(surface_.vertex_count()), 0);
    bool any = false;
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      if (!surface_.is_border(h)) continue;
      is_border_[surface_.origin(h)] = is_border_[surface_.tip(h)] = 1;
      any = true;
    }
    if (!any) return;
    border_heat_ = detail::HeatSystem<Real>::with_held(system_->heat, is_border_);
    border_factor_ = system_->factor(border_heat_, cancelled);
  }

  Surface<Real> surface_;
  HeatOptions options_;
  std::shared_ptr<const detail::HeatSystem<Real>> system_;
  std::optional<ExactSolver<Real>> exact_;
  detail::Array<char> is_border_;  // of each vertex, where heat is held at zero there
  SymmetricMatrix<Real> border_heat_;
  typename detail::HeatSystem<Real>::Factor border_factor_;
};

template <std::floating_point T>
void HeatSolver<T>::set_up(const HeatOptions& options) {
  detail::require(options.exact_radius >= 0, "the exact radius is ", options.exact_radius,
                  ", less than 0");
  detail::require(options.refinements >= 0, "the number of refinements is ", options.refinements,
                  ", less than 0");
  const CancelHook cancelled = detail::rising(options.cancelled, "the heat solver's set-up");
  if (system_ != nullptr) {
    system_->require_made_of(surface_);
  } else {
    system_ = std::make_shared<detail::HeatSystem<Real>>(
        surface_, options.time_factor, options.intrinsic_delaunay, options.backend, cancelled);
  }
  if (options.boundary != HeatBoundary::neumann) hold_border(cancelled.part(0.2, 0.5));
  (void)system_->heat_factor(cancelled.part(0.5, 0.75));
  (void)system_->poisson_factor(cancelled.part(0.75, 1));
  // Last, for there the peak of memory is past.
  if (options.exact_radius > 0) exact_.emplace(surface_);
}

template <std::floating_point T>
auto HeatSolver<T>::solve(std::span<const Index> vertices) const -> HeatResult<T> {
  return result_of(solution(detail::checked_sources(surface_, vertices)));
}

template <std::floating_point T>
auto HeatSolver<T>::solve(std::span<const Source<T>> sources) const -> HeatResult<T> {
  return result_of(solution(detail::checked_sources(surface_, sources)));
}

template <std::floating_point T>
void HeatSolver<T>::solve_vertices(detail::DistanceQuery<Real>& query) const {
  const Solution result = solution(std::move(query.sources));
  for (Index v = 0; v < surface_.vertex_count(); ++v) query.distance[v] = result.distance_of(v);
}

template <TriangleMesh M>
explicit HeatSolver(const M&) -> HeatSolver<MeshScalar<M>>;
template <TriangleMesh M>
HeatSolver(const M&, const HeatOptions&) -> HeatSolver<MeshScalar<M>>;

}  // namespace gelight
