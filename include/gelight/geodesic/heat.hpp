#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/bits.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
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
  /// Within this many mean edge lengths of the sources the distance is exact (as ExactSolver's),
  /// and the heat continues it, which removes the error beside the source. 0 leaves heat alone.
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
/// scan_meshes(4) 1.4 and 20 %, 1.2 and 17 %, 1.5 and 100 %. Where the fronts of several sources
/// meet, heat is off by a share of an edge, which counts for more where they are near: of 2 to 8 at
/// once 2.5 and 23 % on those icospheres, 3.3 and 50 % on the rough ones. (The least of
/// `distance_from_each` is as exact as one source alone, for a solve each.) Graded meshes are
/// worst, since the time is that of the mean edge: `solve` tells. Heat alone improves as spheres
/// are refined, with order 0.4 to 0.7: in a time of one squared edge heat never forgets the mesh.
/// Set-up takes about n^1.5, a query n log n; and what ExactSolver takes within the exact radius,
/// which is much where thousands of long faces meet at a vertex.
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
  [[nodiscard]] HeatResult<T> solve(std::initializer_list<Index> vertices) const {
    return solve(std::span<const Index>(vertices.begin(), vertices.size()));
  }
  [[nodiscard]] HeatResult<T> solve(const Source<T>& source) const {
    return solve(std::span<const Source<T>>(&source, 1));
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
  using Point = SurfacePoint<Real>;
  using Flow = detail::HeatFlow<Real>;

  struct Solution {
    detail::Array<Real> distance;  // from the start
    detail::Array<char> is_exact;  // of each vertex
    bool is_too_far = false;
    detail::Starts<Real> starts;

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
    const typename Pool::Borrowed borrowed(*pool_);
    begin(*borrowed);
    std::vector<Solution> solutions(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      auto sources = detail::checked_sources(surface_, places.subspan(i, 1));
      add_query(sources, i, solutions[i], *borrowed);
    }
    solve_parts(*borrowed, solutions, hook());
    std::vector<std::vector<T>> result;
    for (const Solution& solution : solutions) result.push_back(distances_of(solution));
    return result;
  }

  // Points that start at the same distance, of the sources of a query.
  struct Part {
    std::size_t query;
    Real start;
    std::size_t first_point, point_count;
  };
  // So many are solved at once, for which the factors are read once.
  static constexpr std::size_t parts_at_once = detail::flows_at_once;

  // What is found for a part.
  struct PartWork {
    detail::Sources sources;
    detail::Array<Real> load;
    detail::Array<char> reached;  // of each vertex, whether heat may come there
    detail::Array<Real> near;     // distance, in units, of vertices close to the points
    Flow heat, held_heat;
    detail::Array<Real> distance, before;  // and what a refinement begins with
    bool is_too_far = false;
  };
  // What a query works in; its memory serves the next one.
  struct Workspace {
    detail::Array<Index> order;  // of sources, by their start
    detail::Array<Point> points;
    detail::Array<Part> parts;
    detail::Array<PartWork> found;       // of the parts that are solved at once
    detail::Array<Real> shift, count;    // of each component
    detail::Array<char> reached_inside;  // of each vertex, where the border is held
    std::array<Solution, 1> solution;    // of a query alone
    // Of the distance close to the sources:
    detail::PlanarFaces<Real> flat;
    detail::WindowPropagation<Real> waves;
  };
  using Pool = detail::Pool<Workspace>;

  [[nodiscard]] Solution solution(detail::Sources sources) const {
    return solution(std::move(sources), hook());
  }
  [[nodiscard]] Solution solution(detail::Sources sources, const CancelHook& cancelled) const {
    const typename Pool::Borrowed borrowed(*pool_);
    solve_alone(sources, *borrowed, cancelled);
    return std::move((*borrowed).solution[0]);
  }
  void solve_alone(detail::Sources& sources, Workspace& work, const CancelHook& cancelled) const {
    begin(work);
    add_query(sources, 0, work.solution[0], work);
    solve_parts(work, work.solution, cancelled);
  }
  [[nodiscard]] CancelHook hook() const {
    return detail::rising(options_.cancelled, "a query of the heat solver");
  }

  static void begin(Workspace& work) {
    work.parts.clear();
    work.points.clear();
  }

  // Parts the sources of a query.
  void add_query(detail::Sources& sources, std::size_t query, Solution& solution,
                 Workspace& work) const {
    solution.distance.clear();
    solution.is_exact.clear();
    solution.is_too_far = false;
    solution.starts.move_to_zero(surface_, sources);
    detail::Array<Index>& order = work.order;
    detail::Array<Point>& points = work.points;
    order.clear();
    for (Index i = 0; i < std::ssize(sources); ++i) order.push_back(i);
    const auto start = [&](Index i) { return sources[i].distance; };
    std::sort(order.begin(), order.end(),
              [&](Index i, Index j) { return std::pair(start(i), i) < std::pair(start(j), j); });
    for (auto i = order.begin(); i != order.end();) {
      Part part{query, start(*i), points.size(), 0};
      for (; i != order.end() && start(*i) == part.start; ++i) {
        const auto point = detail::simplified(surface_, sources[*i].point);
        const auto first = points.begin() + part.first_point;
        if (std::find(first, points.end(), point) == points.end()) points.push_back(point);
      }
      part.point_count = points.size() - part.first_point;
      work.parts.push_back(part);
    }
  }

  // Puts the distances of all queries whose parts there are.
  void solve_parts(Workspace& work, std::span<Solution> nearest,
                   const CancelHook& cancelled) const {
    const std::span<const Part> parts(work.parts);
    for (std::size_t done = 0; done < parts.size();) {
      const auto some = parts.subspan(done, std::min(parts.size() - done, parts_at_once));
      const double share = 1 / static_cast<double>(parts.size());
      find_distances(some, work,
                     cancelled.part(share * static_cast<double>(done),
                                    share * static_cast<double>(done + some.size())));
      for (std::size_t i = 0; i < some.size(); ++i) {
        take_nearer(nearest[some[i].query], some[i].start, work.found[i]);
      }
      done += some.size();
    }
  }

  void take_nearer(Solution& nearest, Real start, const PartWork& part) const {
    nearest.distance.resize(part.distance.size(), unreachable<Real>);  // at the first
    nearest.is_exact.resize(part.distance.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const Real d = start + part.distance[v];
      if (!(d < nearest.distance[v])) continue;
      nearest.distance[v] = d;
      nearest.is_exact[v] = part.near[v] < unreachable<Real>;
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
      const Real steepness = norm(scaled_gradient(face, d)) / double_area / system_->unit;
      sum += double_area * std::abs(steepness - 1);
      total += double_area;
    }
    return total > 0 ? sum / total : 0;
  }

  // Distances from each part's points, from where they start.
  void find_distances(std::span<const Part> parts, Workspace& work,
                      const CancelHook& cancelled) const {
    if (work.found.size() < parts.size()) work.found.resize(parts.size());
    const std::span<PartWork> found(work.found.data(), parts.size());
    std::array<Flow*, parts_at_once> heats{}, held_heats{};
    const auto whole = static_cast<double>(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto done = static_cast<double>(i);
      PartWork& part = found[i];
      const std::span<const Point> points(work.points.data() + parts[i].first_point,
                                          parts[i].point_count);
      put_load(points, part.load);
      system_->mark_reached(part.load, part.reached);
      find_near(points, part, work, cancelled.part(0.2 * done / whole, 0.2 * (done + 1) / whole));
      part.heat.begin(system_->heat, part.load, part.reached);
      heats[i] = &part.heat;
      if (border_factor_) begin_held(part, work.reached_inside);
      held_heats[i] = &part.held_heat;
    }
    detail::finish<Real>({heats.data(), parts.size()}, system_->heat_factor(),
                         cancelled.part(0.2, 0.4));
    if (border_factor_) {
      detail::finish<Real>({held_heats.data(), parts.size()}, *border_factor_,
                           cancelled.part(0.4, 0.6));
    }
    const auto first_field = [&](const PartWork& part) {
      const auto* const held = border_factor_ ? &part.held_heat.result() : nullptr;
      return [this, held, &free = part.heat.result()](Index f) {
        return held != nullptr ? averaged_descent(f, *held, free) : descent(f, free);
      };
    };
    const double each = 0.4 / (1 + options_.refinements);  // of the work, from 0.6 on
    for (PartWork& part : found) {
      const auto& heat = part.heat.result();
      if (border_factor_ || !heat.has_one_exponent) {
        put_divergence(part.near, first_field(part), part.distance);
      } else {
        put_divergence(part.near, heat.value, part.distance);
      }
    }
    integrate(found, cancelled.part(0.6, 0.6 + each));
    const auto field = [this](const PartWork& part) {
      return [this, &from = part.before](Index f) { return refined_field(f, from); };
    };
    for (Index k = 1; k <= options_.refinements; ++k) {
      const double done = 0.6 + k * each;
      for (PartWork& part : found) part.before.swap(part.distance);
      continue_near(found, field, cancelled.part(done, done + each));
    }
    for (PartWork& part : found) {
      place(part, work);
      part.is_too_far = part.heat.result().unknown > 0;
    }
  }

  // Distance, in units, of the vertices close to the points; infinite elsewhere.
  void find_near(std::span<const Point> points, PartWork& part, Workspace& work,
                 const CancelHook& cancelled) const {
    const auto size = static_cast<std::size_t>(surface_.vertex_count());
    detail::Array<Real>& near = part.near;
    near.assign(size, unreachable<Real>);
    if (options_.exact_radius > 0 && system_->mean_edge > 0) {
      detail::PropagationLimits<Real> limits;
      limits.distance = options_.exact_radius * system_->mean_edge;
      if (cancelled) {
        limits.cancelled = [&cancelled] {
          cancelled.check(0, "a query of the heat solver");
          return false;
        };
      }
      auto& sources = part.sources;
      sources.clear();
      for (const auto& point : points) {
        sources.push_back({point, 0});
        work.flat.lay_flat_near(surface_, point, limits.distance);
      }
      work.waves.run(surface_, work.flat, sources, limits);
      for (const Index v : work.waves.reached()) {
        if (work.waves.distances[v] <= limits.distance) near[v] = work.waves.distances[v];
      }
    }
    for (const auto& point : points) {
      detail::for_each_vertex_near(surface_, point,
                                   [&](Index v, Real d) { near[v] = std::min(near[v], d); });
    }
    for (Real& d : near) d /= system_->unit;
  }

  // Puts functions, each with the gradient that is nearest to that of a near distance where that is
  // known at all vertices of a face, to `unit_field(part)(face)` elsewhere.
  void continue_near(std::span<PartWork> parts, const auto& unit_field,
                     const CancelHook& cancelled) const {
    for (PartWork& part : parts) put_divergence(part.near, unit_field(part), part.distance);
    integrate(parts, cancelled);
  }
  void integrate(std::span<PartWork> parts, const CancelHook& cancelled) const {
    std::array<std::span<Real>, parts_at_once> sides;
    for (std::size_t i = 0; i < parts.size(); ++i) sides[i] = parts[i].distance;
    system_->integrate({sides.data(), parts.size()}, cancelled);
  }

  void put_divergence(const detail::Array<Real>& near, const auto& unit_field,
                      detail::Array<Real>& sums) const {
    sums.assign(near.size(), 0);
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const Vec2<Real> field = is_near(f, near) ? near_gradient(f, near) : unit_field(f);
      add_divergence(f, integrated_divergence(system_->faces[f], field), sums);
    }
  }
  [[nodiscard]] bool is_near(Index f, const detail::Array<Real>& near) const {
    const auto d = values_at(f, near);
    return std::max({d[0], d[1], d[2]}) < unreachable<Real>;
  }
  [[nodiscard]] Vec2<Real> near_gradient(Index f, const detail::Array<Real>& near) const {
    using namespace detail::arithmetic;
    const auto& face = system_->faces[f];
    return scaled_gradient(face, values_at(f, near)) / (face.x1 * face.y2);
  }
  void add_divergence(Index f, const std::array<Real, 3>& at, detail::Array<Real>& sums) const {
    const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
    for (std::size_t k = 0; k < 3; ++k) sums[v[k]] += at[k];
  }

  // The same of the direction in which heat descends that has one exponent: several faces at once.
  void put_divergence(const detail::Array<Real>& near, const detail::Array<Real>& heat,
                      detail::Array<Real>& sums) const {
    sums.assign(near.size(), 0);
    const Index count = surface_.face_count();
    for (Index f = 0; f < count; f += Several::count) {
      const Index end = std::min(count, f + Several::count);
      Several faces;
      for (Index g = f; g < end; ++g) faces.set(g - f, system_->faces[g], values_at(g, heat));
      const auto at = faces.divergence_of_descent();
      for (Index g = f; g < end; ++g) {
        const auto k = g - f;
        add_divergence(g,
                       is_near(g, near)
                           ? integrated_divergence(system_->faces[g], near_gradient(g, near))
                           : std::array<Real, 3>{at[0][k], at[1][k], at[2][k]},
                       sums);
      }
    }
  }

  // Faces, and heat at their vertices.
  class Several {
   public:
    static constexpr Index count = 8;

    void set(Index k, const PlanarFace& face, const std::array<Real, 3>& u) {
      x1_[k] = face.x1;
      x2_[k] = face.x2;
      y2_[k] = face.y2;
      // A power of two, so that squares neither overflow nor vanish.
      const Real most = std::max({std::abs(u[0]), std::abs(u[1]), std::abs(u[2])});
      const Real scale = inverse_power_below(most);
      du1_[k] = (u[0] - u[1]) * scale;
      du2_[k] = (u[0] - u[2]) * scale;
    }
    // At the three vertices; no field where heat is the same at all of them.
    [[nodiscard]] auto divergence_of_descent() const {
      const Numbers g1 = y2_ * du1_;
      const Numbers g2 = x1_ * du2_ - x2_ * du1_;
      const Numbers norm = (g1 * g1 + g2 * g2).sqrt();
      const Numbers half = (norm > 0).select(0.5 / norm, 0);
      const Numbers at1 = (y2_ * g1 - x2_ * g2) * half;
      const Numbers at2 = x1_ * g2 * half;
      return std::array<Numbers, 3>{-at1 - at2, at1, at2};
    }

   private:
    using Numbers = Eigen::Array<Real, count, 1>;

    // 2^-k for numbers from 2^k to below 2^(k + 1), 2^-1022 for the largest, whose inverse would be
    // no normal number; finite for 0.
    static Real inverse_power_below(Real x) {
      static_assert(std::same_as<Real, double>);
      constexpr std::uint64_t all_bits = std::uint64_t{0x7ff} << 52;
      constexpr std::uint64_t twice_bias = std::uint64_t{0x7fe} << 52;
      constexpr std::uint64_t most_bits = std::uint64_t{0x7fd} << 52;
      const std::uint64_t exponent_bits = detail::bit_cast<std::uint64_t>(x) & all_bits;
      return detail::bit_cast<double>(twice_bias - std::min(exponent_bits, most_bits));
    }

    Numbers x1_ = Numbers::Ones(), x2_ = Numbers::Zero(), y2_ = Numbers::Ones();
    Numbers du1_ = Numbers::Zero(), du2_ = Numbers::Zero();
  };

  [[nodiscard]] std::array<Real, 3> values_at(Index f, const detail::Array<Real>& u) const {
    const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
    return {u[v[0]], u[v[1]], u[v[2]]};
  }

  // Fronts meet halfway where as much heat arrives from one point as from another. It spreads in
  // the angle that the faces make around a vertex: half a turn at a border takes half the heat.
  void put_load(std::span<const Point> points, detail::Array<Real>& load) const {
    using Kind = typename Point::Kind;
    load.assign(static_cast<std::size_t>(surface_.vertex_count()), 0);
    for (const auto& point : points) {
      std::array<Index, 3> vertices{point.element[0], point.element[1], 0};
      if (point.kind == Kind::face) vertices = surface_.face(point.element[0]);
      const std::size_t count = point.kind == Kind::vertex ? 1 : point.kind == Kind::edge ? 2 : 3;
      for (std::size_t k = 0; k < count; ++k) {
        load[vertices[k]] += point.weights[k] * share_of_turn(vertices[k]);
      }
    }
  }

  // The angle of the faces around a vertex as a share of a whole turn; 1 where there are none.
  [[nodiscard]] Real share_of_turn(Index v) const {
    using namespace detail::arithmetic;
    Real angle = 0;
    for (const Index h : surface_.corners(v)) {
      const Vec3<Real> a = surface_.position(surface_.tip(h)) - surface_.position(v);
      const Vec3<Real> b = surface_.position(surface_.apex(h)) - surface_.position(v);
      angle += std::atan2(norm(cross<Real>(a, b)), dot(a, b));
    }
    return angle > 0 ? angle / (2 * std::numbers::pi_v<Real>) : 1;
  }

  // Heat that is held at zero at the border.
  void begin_held(PartWork& part, detail::Array<char>& reached) const {
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (is_border_[v]) part.load[v] = 0;
    }
    system_->mark_reached(part.load, reached);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (is_border_[v]) reached[v] = 0;
    }
    part.held_heat.begin(border_heat_, part.load, reached);
  }

  // Mean of the directions in which heat descends that is free at the border and that is held at
  // zero there (or the latter alone). Directions are averaged rather than heats: far from the
  // source one of the heats would outweigh the other.
  [[nodiscard]] Vec2<Real> averaged_descent(Index f, const detail::ScaledField<Real>& held,
                                            const detail::ScaledField<Real>& free) const {
    using namespace detail::arithmetic;
    const Real share = options_.boundary == HeatBoundary::dirichlet ? 0 : 1;
    const Vec2<Real> a = descent(f, held), b = descent(f, free);
    const Vec2<Real> mixed = a + (a.isZero(0) ? 1 : share) * b;
    const Real length = norm(mixed);
    return length > 0 ? Vec2<Real>(mixed / length) : mixed;
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
    using namespace detail::arithmetic;
    const auto& face = system_->faces[f];
    const Vec2<Real> g = scaled_gradient(face, values_at(f, phi)) / (face.x1 * face.y2);
    const Real length = norm(g);
    return length > 0 ? Vec2<Real>(g / std::max(length, shortest_gradient)) : g;
  }

  [[nodiscard]] Vec2<Real> unit_gradient(Index f, const std::array<Real, 3>& u) const {
    using namespace detail::arithmetic;
    const Vec2<Real> g = scaled_gradient(system_->faces[f], u);
    const Real length = norm(g);
    return length > 0 ? Vec2<Real>(g / length) : g;
  }

  // Shifts each component so that it agrees with the near distance on average, and gives the near
  // vertices that distance.
  void place(PartWork& part, Workspace& work) const {
    detail::Array<Real>&phi = part.distance, &shift = work.shift, &count = work.count;
    const detail::Array<Real>& near = part.near;
    shift.assign(phi.size(), 0);
    count.assign(phi.size(), 0);
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (near[v] == unreachable<Real>) continue;
      const Index c = system_->component[v];
      shift[c] += phi[v] - near[v];
      count[c] += 1;
    }
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const Index c = system_->component[v];
      if (!part.reached[v]) {
        phi[v] = unreachable<Real>;
      } else if (near[v] < unreachable<Real>) {
        phi[v] = system_->mean_edge * near[v];
      } else {
        phi[v] = system_->mean_edge * std::max(0.0, phi[v] - shift[c] / count[c]);
      }
    }
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
  detail::Array<char> is_border_;  // of each vertex, where heat is held at zero there
  SymmetricMatrix<Real> border_heat_;
  typename detail::HeatSystem<Real>::Factor border_factor_;
  std::shared_ptr<Pool> pool_ = std::make_shared<Pool>();
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
  const typename Pool::Borrowed borrowed(*pool_);
  solve_alone(query.sources, *borrowed, hook());
  const Solution& result = (*borrowed).solution[0];
  for (Index v = 0; v < surface_.vertex_count(); ++v) query.distance[v] = result.distance_of(v);
}

template <TriangleMesh M>
explicit HeatSolver(const M&) -> HeatSolver<MeshScalar<M>>;
template <TriangleMesh M>
HeatSolver(const M&, const HeatOptions&) -> HeatSolver<MeshScalar<M>>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template struct detail::HeatSystem<double>;
GELIGHT_ONCE template class HeatSolver<float>;
GELIGHT_ONCE template class detail::DistanceQueries<HeatSolver<float>, float>;
GELIGHT_ONCE template class HeatSolver<double>;
GELIGHT_ONCE template class detail::DistanceQueries<HeatSolver<double>, double>;
}  // namespace gelight
#endif
