#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/bits.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/heat/flow.hpp"
#include "gelight/geodesic/heat/system.hpp"
#include "gelight/geodesic/sampled_error.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/operators.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/sparse_matrix.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What a HeatSolver works in, whatever the type of its answers.
template <std::floating_point Real>
class HeatEngine {
 public:
  struct Solution {
    Array<Real> distance;  // from the start
    Array<char> is_exact;  // of each vertex
    bool is_too_far = false;
    Starts<Real> starts;

    [[nodiscard]] Real distance_of(Index v) const { return starts.at(v) + distance[v]; }
  };

  HeatEngine(Surface<Real> surface, const HeatOptions& options,
             std::shared_ptr<const HeatSystem<Real>> system)
      : surface_(std::move(surface)), options_(options), system_(std::move(system)) {
    require(options.exact_radius >= 0, "the exact radius is ", options.exact_radius,
            ", less than 0");
    require(options.refinements >= 0, "the number of refinements is ", options.refinements,
            ", less than 0");
    const auto boundary = static_cast<int>(options.boundary);
    require(boundary >= 0 && boundary <= static_cast<int>(HeatBoundary::averaged), "boundary ",
            boundary, " of 3");
    const CancelHook cancelled = rising(options.cancelled, "the heat solver's set-up");
    if (system_ != nullptr) {
      system_->require_made_of(surface_);
    } else {
      system_ = std::make_shared<HeatSystem<Real>>(
          surface_, options.time_factor, options.intrinsic_delaunay, options.backend, cancelled);
    }
    if (options.boundary != HeatBoundary::neumann) hold_border(cancelled.part(0.2, 0.5));
    (void)system_->heat_factor(cancelled.part(0.5, 0.75));
    (void)system_->poisson_factor(cancelled.part(0.75, 1));
  }

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }
  [[nodiscard]] const std::shared_ptr<const HeatSystem<Real>>& system() const { return system_; }

  void solve_vertices(DistanceQuery<Real>& query) const {
    const typename Pool::Borrowed borrowed(*pool_);
    solve_alone(query.sources, *borrowed, hook());
    const Solution& result = (*borrowed).solution[0];
    for (Index v = 0; v < surface_.vertex_count(); ++v) query.distance[v] = result.distance_of(v);
  }

  [[nodiscard]] Solution solution(Sources sources) const {
    return solution(std::move(sources), hook());
  }
  [[nodiscard]] Solution solution(Sources sources, const CancelHook& cancelled) const {
    const typename Pool::Borrowed borrowed(*pool_);
    solve_alone(sources, *borrowed, cancelled);
    return std::move((*borrowed).solution[0]);
  }
  /// Of several queries at once.
  [[nodiscard]] std::vector<Solution> solutions(std::span<Sources> queries) const {
    const typename Pool::Borrowed borrowed(*pool_);
    begin(*borrowed);
    std::vector<Solution> found(queries.size());
    for (std::size_t i = 0; i < queries.size(); ++i) {
      add_query(queries[i], i, found[i], *borrowed);
    }
    solve_parts(*borrowed, found, hook());
    return found;
  }

  template <std::floating_point T>
  [[nodiscard]] std::vector<T> distances_of(const Solution& solution) const {
    std::vector<T> result;
    result.reserve(solution.distance.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      result.push_back(distance_as<T>(solution.distance_of(v), "vertex ", v));
    }
    return result;
  }

  template <std::floating_point T>
  [[nodiscard]] HeatResult<T> result_of(const Solution& solution) const {
    HeatResult<T> result;
    result.distance = distances_of<T>(solution);
    result.residual = residual_of(solution);
    // Where few vertices have most of the error, few paths miss it.
    const Index samples = result.residual < even_residual ? 16 : 64;
    result.error =
        sampled_error(surface_, solution.distance, solution.is_exact, largest_error, samples);
    result.is_too_coarse = result.error > largest_error;
    result.is_too_far = solution.is_too_far;
    result.is_reliable = !result.is_too_coarse && !result.is_too_far;
    return result;
  }

 private:
  using Point = SurfacePoint<Real>;
  using Flow = HeatFlow<Real>;

  // Above this estimate, a mean error of a tenth is possible: see HeatResult::error.
  static constexpr Real largest_error = 0.07;
  // Below it the error is much the same everywhere.
  static constexpr Real even_residual = 0.1;
  // A face whose gradient is shorter lies where fronts meet, and so does the true distance's.
  // Lengthening it would lift what lies beyond.
  static constexpr Real shortest_gradient = 0.97;

  // Points that start at the same distance, of the sources of a query.
  struct Part {
    std::size_t query;
    Real start;
    std::size_t first_point, point_count;
  };
  // So many are solved at once, for which the factors are read once.
  static constexpr std::size_t parts_at_once = flows_at_once;

  // What is found for a part.
  struct PartWork {
    Sources sources;
    Array<Real> load;
    Array<char> reached;  // of each vertex, whether heat may come there
    Array<Real> near;     // distance, in units, of vertices close to the points
    Flow heat, held_heat;
    Array<Real> distance, before;  // and what a refinement begins with
    bool is_too_far = false;
  };
  // What a query works in; its memory serves the next one.
  struct Workspace {
    Array<Index> order;  // of sources, by their start
    Array<Point> points;
    Array<Part> parts;
    Array<PartWork> found;             // of the parts that are solved at once
    Array<Real> shift, count;          // of each component
    Array<char> reached_inside;        // of each vertex, where the border is held
    std::array<Solution, 1> solution;  // of a query alone
    // Of the distance close to the sources:
    PlanarFaces<Real> flat;
    WindowPropagation<Real> waves;
  };
  using Pool = detail::Pool<Workspace>;

  void solve_alone(Sources& sources, Workspace& work, const CancelHook& cancelled) const {
    begin(work);
    add_query(sources, 0, work.solution[0], work);
    solve_parts(work, work.solution, cancelled);
  }
  [[nodiscard]] CancelHook hook() const {
    return rising(options_.cancelled, "a query of the heat solver");
  }

  static void begin(Workspace& work) {
    work.parts.clear();
    work.points.clear();
  }

  // Parts the sources of a query.
  void add_query(Sources& sources, std::size_t query, Solution& solution, Workspace& work) const {
    solution.distance.clear();
    solution.is_exact.clear();
    solution.is_too_far = false;
    solution.starts.move_to_zero(surface_, sources);
    Array<Index>& order = work.order;
    Array<Point>& points = work.points;
    order.clear();
    for (Index i = 0; i < std::ssize(sources); ++i) order.push_back(i);
    const auto start = [&](Index i) { return sources[i].distance; };
    std::sort(order.begin(), order.end(),
              [&](Index i, Index j) { return std::pair(start(i), i) < std::pair(start(j), j); });
    for (auto i = order.begin(); i != order.end();) {
      Part part{query, start(*i), points.size(), 0};
      for (; i != order.end() && start(*i) == part.start; ++i) {
        const auto point = simplified(surface_, sources[*i].point);
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
    finish<Real>({heats.data(), parts.size()}, system_->heat_factor(), cancelled.part(0.2, 0.4));
    if (border_factor_) {
      finish<Real>({held_heats.data(), parts.size()}, *border_factor_, cancelled.part(0.4, 0.6));
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
    Array<Real>& near = part.near;
    near.assign(size, unreachable<Real>);
    if (options_.exact_radius > 0 && system_->mean_edge > 0) {
      PropagationLimits<Real> limits;
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
      for_each_vertex_near(surface_, point,
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

  void put_divergence(const Array<Real>& near, const auto& unit_field, Array<Real>& sums) const {
    sums.assign(near.size(), 0);
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const Vec2<Real> field = is_near(f, near) ? near_gradient(f, near) : unit_field(f);
      add_divergence(f, integrated_divergence(system_->faces[f], field), sums);
    }
  }
  [[nodiscard]] bool is_near(Index f, const Array<Real>& near) const {
    const auto d = values_at(f, near);
    return std::max({d[0], d[1], d[2]}) < unreachable<Real>;
  }
  [[nodiscard]] Vec2<Real> near_gradient(Index f, const Array<Real>& near) const {
    using namespace arithmetic;
    const auto& face = system_->faces[f];
    return scaled_gradient(face, values_at(f, near)) / (face.x1 * face.y2);
  }
  void add_divergence(Index f, const std::array<Real, 3>& at, Array<Real>& sums) const {
    const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
    for (std::size_t k = 0; k < 3; ++k) sums[v[k]] += at[k];
  }

  // The same of the direction in which heat descends that has one exponent: several faces at once.
  void put_divergence(const Array<Real>& near, const Array<Real>& heat, Array<Real>& sums) const {
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
      const std::uint64_t exponent_bits = bit_cast<std::uint64_t>(x) & all_bits;
      return bit_cast<double>(twice_bias - std::min(exponent_bits, most_bits));
    }

    Numbers x1_ = Numbers::Ones(), x2_ = Numbers::Zero(), y2_ = Numbers::Ones();
    Numbers du1_ = Numbers::Zero(), du2_ = Numbers::Zero();
  };

  [[nodiscard]] std::array<Real, 3> values_at(Index f, const Array<Real>& u) const {
    const Index* v = system_->origins.data() + 3 * std::ptrdiff_t{f};
    return {u[v[0]], u[v[1]], u[v[2]]};
  }

  // Fronts meet halfway where as much heat arrives from one point as from another.
  void put_load(std::span<const Point> points, Array<Real>& load) const {
    using Kind = typename Point::Kind;
    load.assign(static_cast<std::size_t>(surface_.vertex_count()), 0);
    for (const auto& point : points) {
      std::array<Index, 3> vertices{point.element[0], point.element[1], 0};
      if (point.kind == Kind::face) vertices = surface_.face(point.element[0]);
      const std::size_t count = point.kind == Kind::vertex ? 1 : point.kind == Kind::edge ? 2 : 3;
      for (std::size_t k = 0; k < count; ++k) {
        load[vertices[k]] += point.weights[k] * system_->share_of_turn(vertices[k]);
      }
    }
  }

  // Heat that is held at zero at the border.
  void begin_held(PartWork& part, Array<char>& reached) const {
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
  [[nodiscard]] Vec2<Real> averaged_descent(Index f, const ScaledField<Real>& held,
                                            const ScaledField<Real>& free) const {
    using namespace arithmetic;
    const Real share = options_.boundary == HeatBoundary::dirichlet ? 0 : 1;
    const Vec2<Real> a = descent(f, held), b = descent(f, free);
    const Vec2<Real> mixed = a + (a.isZero(0) ? 1 : share) * b;
    const Real length = norm(mixed);
    return length > 0 ? Vec2<Real>(mixed / length) : mixed;
  }

  // Unit direction in which heat falls, or zero where it is the same at all three vertices.
  [[nodiscard]] Vec2<Real> descent(Index f, const ScaledField<Real>& heat) const {
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

  [[nodiscard]] Vec2<Real> refined_field(Index f, const Array<Real>& phi) const {
    using namespace arithmetic;
    const auto& face = system_->faces[f];
    const Vec2<Real> g = scaled_gradient(face, values_at(f, phi)) / (face.x1 * face.y2);
    const Real length = norm(g);
    return length > 0 ? Vec2<Real>(g / std::max(length, shortest_gradient)) : g;
  }

  [[nodiscard]] Vec2<Real> unit_gradient(Index f, const std::array<Real, 3>& u) const {
    using namespace arithmetic;
    const Vec2<Real> g = scaled_gradient(system_->faces[f], u);
    const Real length = norm(g);
    return length > 0 ? Vec2<Real>(g / length) : g;
  }

  // Shifts each component so that it agrees with the near distance on average, and gives the near
  // vertices that distance.
  void place(PartWork& part, Workspace& work) const {
    Array<Real>&phi = part.distance, &shift = work.shift, &count = work.count;
    const Array<Real>& near = part.near;
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
    border_heat_ = HeatSystem<Real>::with_held(system_->heat, is_border_);
    border_factor_ = system_->factor(border_heat_, cancelled);
  }

  Surface<Real> surface_;
  HeatOptions options_;
  std::shared_ptr<const HeatSystem<Real>> system_;
  Array<char> is_border_;  // of each vertex, where heat is held at zero there
  SymmetricMatrix<Real> border_heat_;
  typename HeatSystem<Real>::Factor border_factor_;
  std::shared_ptr<Pool> pool_ = std::make_shared<Pool>();
};

}  // namespace gelight::detail
