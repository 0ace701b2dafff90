#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/pool.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/distance_solver.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/exact/path_backtrace.hpp"
#include "gelight/geodesic/exact/planar_faces.hpp"
#include "gelight/geodesic/exact/point_query.hpp"
#include "gelight/geodesic/exact/window_list.hpp"
#include "gelight/geodesic/exact/window_propagation.hpp"
#include "gelight/geodesic/exact/window_solution.hpp"
#include "gelight/geodesic/segment.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight::detail {

/// What an ExactSolver works in.
template <std::floating_point T>
class ExactEngine {
  using Real = typename WorkingPrecision<T>::Real;
  using Point = SurfacePoint<Real>;
  using PlanarFaces = detail::PlanarFaces<Real>;
  using Sources = detail::Array<Source<Real>>;
  using Solution = WindowSolution<Real>;
  using Workspace = WindowPropagation<Real>;
  using Limits = PropagationLimits<Real>;
  using Target = typename Limits::Target;
  using Pool = detail::Pool<Workspace>;
  using Borrowed = typename Pool::Borrowed;

 public:
  ExactEngine(Surface<Real> surface, ExactOptions<T> options)
      : surface_(std::move(surface)), options_(std::move(options)) {
    require_options(options_);
    faces_ = std::make_shared<const PlanarFaces>(surface_);
    mean_edge_ = mean_edge_length(surface_);
    pool_ = std::make_shared<Pool>();
  }

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }
  [[nodiscard]] const PlanarFaces& faces() const { return *faces_; }
  [[nodiscard]] const ExactOptions<T>& options() const { return options_; }

  void require_options(const ExactOptions<T>& options) const {
    require(!std::isnan(options.max_distance), "the greatest distance is not a number");
    require(options.reset_radius > 0, "the reset radius is ", options.reset_radius,
            ", not a positive number");
    for (const auto& target : options.targets) surface_.require_point(target);
  }

  void solve_vertices(DistanceQuery<Real>& query) const { solve_vertices(query, options_); }
  void solve_vertices(DistanceQuery<Real>& query, const ExactOptions<T>& options) const;

  // Segments, and the points of them from which their ends and the corners of their faces are
  // reached.
  struct Curves {
    Array<SegmentFront<Real>> fronts;
    Sources sources;
  };
  [[nodiscard]] Curves curves_of(std::span<const Segment<T>> segments) const {
    require(!segments.empty(), "there is no segment");
    Curves out;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const auto fronts = fronts_of(surface_, segments[i], i);
      for (const auto& front : fronts) add_points(front, out.sources);
      out.fronts.append(fronts.begin(), fronts.end());
    }
    return out;
  }

  [[nodiscard]] std::shared_ptr<const Solution> solve_checked(
      Sources sources, const ExactOptions<T>& options, Array<SegmentFront<Real>> fronts = {}) const;

  [[nodiscard]] Solution empty_solution(const ExactOptions<T>& options) const {
    Solution solution{surface_, faces_};
    solution.cancelled = options.cancelled;
    solution.max_memory = options.max_memory;
    return solution;
  }

  // Solves from the solution's sources into its memory; of segments, from its fronts besides.
  void solve_into(Solution& solution, const ExactOptions<T>& options) const;

  // The shortest path between two points, if it is no longer than `longest`, by windows that can be
  // part of such a path alone; empty else.
  [[nodiscard]] std::vector<Point> path_within(const Point& from, const Point& to,
                                               Real longest) const;

 private:
  void add_points(const SegmentFront<Real>& front, Sources& sources) const {
    const Point begin = face_point(front.face, front.begin),
                end = face_point(front.face, front.end);
    const Vec3<Real> way = surface_.difference(begin, end);
    const Real square = squared_norm(way);
    const auto add = [&](Real t) {
      sources.push_back({face_point(front.face, front.at(t)), front.start});
    };
    add(0);
    if (!(square > 0)) return;
    add(1);
    for (const Index v : surface_.face(front.face)) {
      const Real t = dot(way, surface_.difference(begin, vertex_point<Real>(v))) / square;
      if (t > 0.0 && t < 1.0) add(t);
    }
  }

  void run(Workspace& workspace, const Sources& sources, const Limits& limits) const {
    workspace.run(surface_, *faces_, sources, limits);
  }

  void normalise(Sources& sources, Starts<Real>& starts) const {
    for (auto& source : sources) source.point = simplified(surface_, source.point);
    starts.move_to_zero(surface_, sources);
  }

  // But for the windows to keep; `targets` are memory to use again.
  [[nodiscard]] Limits limits_of(const ExactOptions<T>& options, const Starts<Real>& starts,
                                 Array<Target> targets = {}) const {
    Limits limits;
    limits.distance = static_cast<Real>(options.max_distance) - starts.common;
    if (!starts.of_vertex.empty()) limits.starts = &starts.of_vertex;
    limits.cancelled = options.cancelled;
    limits.memory = options.max_memory;
    if (options.reset_radius < unreachable<T> && mean_edge_ > 0) {
      limits.ring = static_cast<Real>(options.reset_radius) * mean_edge_;
    }
    targets.clear();
    for (const auto& point : options.targets) {
      targets.push_back(target_at(simplified(surface_, point.template cast<Real>())));
    }
    limits.targets = std::move(targets);
    return limits;
  }

  [[nodiscard]] Target target_at(const Point& p) const {
    std::array<Index, 3> corners{p.element[0], p.element[0], p.element[0]};
    if (p.kind == Point::Kind::edge) corners[1] = p.element[1];
    if (p.kind == Point::Kind::face) corners = surface_.face(p.element[0]);
    Target target{corners, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      target.gaps[k] = straight(surface_, p, vertex_point<Real>(corners[k]));
    }
    return target;
  }

  // All windows, or those of the faces in which targets lie.
  void choose_windows_to_keep(const ExactOptions<T>& options, Limits& limits) const {
    limits.keep_windows = options.keep_windows || limits.ring < unreachable<Real>;
    if (limits.keep_windows) return;
    for (const auto& target : options.targets) {
      keep_windows_at(simplified(surface_, target.template cast<Real>()), limits);
    }
  }
  void keep_windows_at(const Point& p, Limits& limits) const {
    if (p.kind == Point::Kind::vertex) return;
    limits.faces_to_keep.resize(static_cast<std::size_t>(surface_.face_count()), 0);
    if (p.kind == Point::Kind::face) {
      limits.faces_to_keep[p.element[0]] = 1;
      return;
    }
    const Index first = surface_.find_halfedge(p.element[0], p.element[1]);
    Index h = first;
    do {
      limits.faces_to_keep[Surface<Real>::face_of(h)] = 1;
      h = surface_.twin(h);
    } while (h != first);
  }

  Surface<Real> surface_;
  std::shared_ptr<const PlanarFaces> faces_;
  ExactOptions<T> options_;
  Real mean_edge_ = 0;
  std::shared_ptr<Pool> pool_;
};
template <std::floating_point T>
void ExactEngine<T>::solve_vertices(DistanceQuery<Real>& query,
                                    const ExactOptions<T>& options) const {
  auto& [sources, starts, distance] = query;
  normalise(sources, starts);
  const Borrowed workspace(*pool_);
  Limits limits = limits_of(options, starts, std::move((*workspace).target_memory));
  run(*workspace, sources, limits);
  (*workspace).target_memory = std::move(limits.targets);
  for (Index v = 0; v < surface_.vertex_count(); ++v) {
    const Real d = (*workspace).distances[v];
    distance[v] = d <= (*workspace).bound_at(v) ? d + starts.at(v) : unreachable<Real>;
  }
}

template <std::floating_point T>
auto ExactEngine<T>::solve_checked(Sources sources, const ExactOptions<T>& options,
                                   Array<SegmentFront<Real>> fronts) const
    -> std::shared_ptr<const Solution> {
  require_options(options);
  Solution solution = empty_solution(options);
  solution.sources = std::move(sources);
  solution.fronts = std::move(fronts);
  solve_into(solution, options);
  return std::make_shared<const Solution>(std::move(solution));
}

template <std::floating_point T>
void ExactEngine<T>::solve_into(Solution& solution, const ExactOptions<T>& options) const {
  normalise(solution.sources, solution.starts);
  for (auto& front : solution.fronts) {
    front.start -= solution.starts.at(surface_.face(front.face)[0]);
  }
  Limits limits = limits_of(options, solution.starts);
  choose_windows_to_keep(options, limits);
  limits.fronts = solution.fronts;
  solution.size = limits.size = solution.fronts.empty() ? 0 : size_of(surface_);
  const Borrowed workspace(*pool_);
  run(*workspace, solution.sources, limits);
  solution.adopt(*workspace);
  solution.bends_anywhere = limits.ring < unreachable<Real>;
  solution.kept_faces = limits.keep_windows ? Array<char>{} : limits.faces_to_keep;
}

template <std::floating_point T>
auto ExactEngine<T>::path_within(const Point& from, const Point& to, Real longest) const
    -> std::vector<Point> {
  Solution solution = empty_solution(options_);
  solution.sources = {{from, 0}};
  Limits limits;
  limits.distance = longest;
  limits.goal = &to;
  limits.cancelled = options_.cancelled;
  limits.memory = options_.max_memory;
  limits.keep_windows = true;
  limits.targets.push_back(target_at(to));
  const Borrowed workspace(*pool_);
  run(*workspace, solution.sources, limits);
  solution.bound = (*workspace).bound();
  const auto windows = std::make_shared<WindowStore<Real>>();
  solution.windows = windows;
  solution.exchange(*workspace, *windows);
  const auto end = PointQuery<Real>(solution).nearest(to);
  Array<Point> path = PathBacktrace<Real>(solution).back(end);
  std::reverse(path.begin(), path.end());
  solution.exchange(*workspace, *windows);
  return path;
}

}  // namespace gelight::detail
