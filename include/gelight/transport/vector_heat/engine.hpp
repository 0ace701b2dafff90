#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <concepts>
#include <limits>
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
#include "gelight/geodesic/backtrace.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat_engine.hpp"
#include "gelight/geodesic/sampled_error.hpp"
#include "gelight/mesh/intrinsic.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/operators.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/sparse_factor.hpp"
#include "gelight/mesh/sparse_matrix.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/transport/tangent_planes.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "gelight/transport/vector_heat/signposts.hpp"

namespace gelight::detail {

/// What a VectorHeatSolver works in.
template <std::floating_point T>
class VectorHeatEngine {
  using Real = typename WorkingPrecision<T>::Real;

 public:
  VectorHeatEngine(Surface<Real> surface, std::shared_ptr<const HeatSystem<Real>> system,
                   const VectorHeatOptions& options)
      : surface_(std::move(surface)),
        cancelled_(options.cancelled),
        planes_(surface_,
                options.intrinsic_delaunay ? mollified_triangulation(surface_, 1)
                                           : intrinsic_triangulation(surface_),
                cancelled_.part(0, 0)),
        system_(system ? std::move(system)
                       : std::make_shared<HeatSystem<Real>>(surface_, options.time_factor,
                                                            options.intrinsic_delaunay, nullptr,
                                                            asked_in_set_up().part(0, 0.5))),
        signposts_(signposts(asked_in_set_up().part(0.5, 1))),
        connection_(connection_matrix()),
        lazy_(std::make_shared<SetUpLater>()) {}

  [[nodiscard]] const Surface<Real>& surface() const { return surface_; }

  [[nodiscard]] std::array<Vec3<T>, 2> tangent_basis(Index vertex) const {
    surface_.require_vertex(vertex);
    const auto& basis = planes_.frames().basis(vertex);
    return {cast<T>(basis.x), cast<T>(basis.y)};
  }

  [[nodiscard]] std::vector<Vec3<T>> transport(Index vertex, const Vec3<T>& vector) const {
    surface_.require_vertex(vertex);
    const VectorSource<T> source{vertex_point<T>(vertex), vector};
    return transport(std::span<const VectorSource<T>>(&source, 1));
  }

  [[nodiscard]] std::vector<Vec3<T>> transport(std::span<const VectorSource<T>> sources) const {
    require(!sources.empty(), "there is no source");
    const CancelHook cancelled = asked_in_query();
    Field load(vertex_count(), 0);
    Array<Real> lengths(vertex_count(), 0), counts(vertex_count(), 0);
    Real length = 0, least = unreachable<Real>, most = 0;
    for (std::size_t s = 0; s < sources.size(); ++s) {
      length = add_source(sources[s], s, load, lengths, counts);
      least = std::min(least, length), most = std::max(most, length);
    }
    auto carried = unit_directions(flow(load, cancelled.part(0, 0.6)));
    if (sources.size() == 1) {
      for (auto& z : carried) z *= length;
    } else {
      const auto means = carried_mean(lengths, counts, least, most, cancelled.part(0.6, 1));
      for (Index v = 0; v < surface_.vertex_count(); ++v) {
        if (carried[v] != 0.0) carried[v] *= means[v];
      }
    }
    return embedded(carried);
  }

  [[nodiscard]] TransportResult<T> solve(Index vertex, const Vec3<T>& vector) const {
    surface_.require_vertex(vertex);
    const VectorSource<T> source{vertex_point<T>(vertex), vector};
    return solve(std::span<const VectorSource<T>>(&source, 1));
  }
  [[nodiscard]] TransportResult<T> solve(std::span<const VectorSource<T>> sources) const {
    TransportResult<T> result{transport(sources)};
    result.error = transport_error(sources, result.vectors);
    result.is_reliable = result.error <= largest_error;
    return result;
  }

  [[nodiscard]] std::vector<Vec3<T>> radial(Index vertex) const {
    surface_.require_vertex(vertex);
    require_faces(vertex);
    const CancelHook cancelled = asked_in_query();
    if (!is_beside_border(vertex)) return embedded(radial_directions(vertex, cancelled));
    const auto distance = distance_from(vertex, cancelled.part(0, 0.5));
    return embedded(gradient_directions(vertex, distance, cancelled.part(0.5, 1)));
  }

  [[nodiscard]] std::vector<Vec2<T>> log_map(Index vertex) const {
    return mapped(vertex).coordinates;
  }

  [[nodiscard]] LogMapResult<T> solve_log_map(Index vertex) const {
    const Map map = mapped(vertex);
    LogMapResult<T> result{map.coordinates};
    result.error = log_map_error(vertex, map);
    result.is_reliable = result.error <= largest_error;
    return result;
  }

  [[nodiscard]] std::vector<T> extend(std::span<const Index> vertices,
                                      std::span<const T> values) const {
    require(!vertices.empty(), "there is no vertex to extend from");
    require(vertices.size() == values.size(), "there are ", vertices.size(), " vertices and ",
            values.size(), " values");
    Array<Real> sums(vertex_count(), 0), counts(vertex_count(), 0);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      surface_.require_vertex(vertices[k]);
      require(std::isfinite(values[k]), "value ", k, " is ", values[k], ", which is not finite");
      sums[vertices[k]] += static_cast<Real>(values[k]);
      counts[vertices[k]] += 1;
      require(std::isfinite(sums[vertices[k]]), "the values of vertex ", vertices[k], " sum to ",
              sums[vertices[k]]);
    }
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const auto extended = carried_mean(sums, counts, static_cast<Real>(*least),
                                       static_cast<Real>(*most), asked_in_query());
    std::vector<T> result(extended.size());
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = static_cast<T>(extended.data()[i]);
    return result;
  }

 private:
  using Field = Array<std::complex<Real>>;
  using Point = SurfacePoint<Real>;
  using Signposts = detail::Signposts<Real>;

  // Made when first asked for.
  struct SetUpLater {
    Lazy<SparseFactor<std::complex<Real>>> factor;
    Lazy<HeatEngine<Real>> heat;
    Lazy<ExactSolver<Real>> exact;
    Lazy<FastMarchingSolver<Real>> marching;
  };

  struct Map {
    std::vector<Vec2<T>> coordinates;
    Array<char> is_exact;  // of each vertex
  };

  [[nodiscard]] std::size_t vertex_count() const {
    return static_cast<std::size_t>(surface_.vertex_count());
  }

  void require_faces(Index vertex) const {
    require(!surface_.corners(vertex).empty(), "vertex ", vertex,
            " is in no face, it has no tangent plane");
  }

  [[nodiscard]] CancelHook asked_in_set_up() const {
    return rising(cancelled_, "the vector heat solver's set-up");
  }
  [[nodiscard]] CancelHook asked_in_query() const {
    return rising(cancelled_, "a query of the vector heat solver");
  }

  [[nodiscard]] Signposts signposts(const CancelHook& cancelled) const {
    if (!system_->is_delaunay) {
      return {intrinsic_triangulation(surface_, system_->unit), planes_.frames()};
    }
    // The same flips as the system's, with the directions kept.
    Signposts posts(mollified_triangulation(surface_, system_->unit), planes_.frames());
    flip_to_delaunay(
        posts.mesh, [&](Index h, Real length) { posts.flip_edge(h, length); }, cancelled);
    return posts;
  }

  // Mass and connection Laplacian: the heat matrix with each edge's entry turned by its transport.
  [[nodiscard]] SymmetricMatrix<std::complex<Real>> connection_matrix() const {
    const auto& pattern = *system_->pattern;
    const auto& origins = system_->origins;
    SymmetricMatrix<std::complex<Real>> matrix{system_->pattern, {}};
    matrix.values.assign(system_->heat.values.begin(), system_->heat.values.end());
    for (Index v = 0; v < pattern.size(); ++v) {
      for (Index e = pattern.diagonal(v) + 1; e < pattern.begin(v + 1); ++e) matrix.values[e] = 0;
    }
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto weights = half_cotangents(system_->faces[f]);
      for (Index k = 0; k < 3; ++k) {
        const Index h = 3 * f + k;
        const Index from = origins[h], to = origins[Signposts::next(h)];
        const Real weight = system_->time_factor * weights[static_cast<std::size_t>(k)];
        const auto turn =
            std::polar(1.0, signposts_.angle_back(h) + std::numbers::pi - signposts_.angle[h]);
        if (from == to) {
          // A loop, which the scalar matrix does without, carries its vertex' vector to itself.
          matrix.values[pattern.diagonal(from)] += 2 * weight * (1 - turn.real());
        } else {
          matrix.values[pattern.entry(h)] -= weight * (from < to ? turn : std::conj(turn));
        }
      }
    }
    drop_negative_weights(matrix);
    return matrix;
  }

  // Edges whose weight is negative, as obtuse corners of the border make it, would have heat
  // become negative, and vectors that go with it opposite: they carry nothing.
  void drop_negative_weights(SymmetricMatrix<std::complex<Real>>& matrix) const {
    const auto& pattern = *matrix.pattern;
    for (Index v = 0; v < pattern.size(); ++v) {
      for (Index e = pattern.begin(v) + 1; e < pattern.begin(v + 1); ++e) {
        const Real entry = system_->heat.values[e];
        if (!(entry > 0)) continue;
        matrix.values[e] = 0;
        matrix.values[pattern.diagonal(v)] += entry;
        matrix.values[pattern.diagonal(pattern.row(e))] += entry;
      }
    }
  }

  [[nodiscard]] const SparseFactor<std::complex<Real>>& factor(const CancelHook& cancelled) const {
    return lazy_->factor.get(
        [&] { return factored(system_->dissection(), connection_, cancelled); });
  }

  [[nodiscard]] HeatEngine<Real> shared_heat(const CancelHook& cancelled) const {
    return {surface_, HeatOptions{.time_factor = system_->time_factor, .cancelled = cancelled},
            system_};
  }

  [[nodiscard]] ScaledField<std::complex<Real>> flow(const Field& load,
                                                     const CancelHook& cancelled) const {
    return heat_flow(connection_, factor(cancelled.part(0, 0.5)), load, system_->reached_from(load),
                     cancelled.part(0.5, 1));
  }

  [[nodiscard]] Array<Real> distance_from(Index vertex, const CancelHook& cancelled) const {
    const auto& heat = lazy_->heat.get([&] { return shared_heat(cancelled.part(0, 0.5)); });
    return heat.solution({{vertex_point<Real>(vertex), 0}}, cancelled.part(0.5, 1)).distance;
  }

  // Coordinates, exact near the vertex.
  [[nodiscard]] Map mapped(Index vertex) const {
    surface_.require_vertex(vertex);
    require_faces(vertex);
    const CancelHook cancelled = asked_in_query();
    Field load(vertex_count(), 0);
    load[vertex] = 1;
    const auto axis = unit_directions(flow(load, cancelled.part(0, 0.4)));
    const auto distance = distance_from(vertex, cancelled.part(0.4, 0.8));
    const auto radial = is_beside_border(vertex)
                            ? gradient_directions(vertex, distance, cancelled.part(0.8, 1))
                            : radial_directions(vertex, cancelled.part(0.8, 1));
    Map map{std::vector<Vec2<T>>(vertex_count()), Array<char>(vertex_count(), 0)};
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const std::complex<Real> direction = radial[v] * std::conj(axis[v]);
      const bool is_reached = distance[v] < unreachable<Real>;
      (void)distance_as<T>(distance[v], "vertex ", v);
      map.coordinates[static_cast<std::size_t>(v)] =
          is_reached ? Vec2<T>(static_cast<T>(distance[v] * direction.real()),
                               static_cast<T>(distance[v] * direction.imag()))
                     : Vec2<T>(unreachable<T>, unreachable<T>);
    }
    set_near(vertex, map);
    return map;
  }

  // Above it, as estimated, a mean error of a tenth is possible: see TransportResult::error.
  static constexpr double largest_error = 0.07;
  static constexpr Index samples = 64;
  // Of a distance's gradient, which is 1 long where it tells a direction.
  static constexpr Real next_to_level = 1e-6;

  using Path = std::vector<Point>;

  // The vertices to be asked: those that are reached, but for some.
  [[nodiscard]] Array<Index> reached_but(const Array<Real>& distance, auto&& is_left_out) const {
    Array<Index> targets;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (distance[v] > 0 && distance[v] < unreachable<Real> && !is_left_out(v)) {
        targets.push_back(v);
      }
    }
    return targets;
  }

  [[nodiscard]] double transport_error(std::span<const VectorSource<T>> sources,
                                       const std::vector<Vec3<T>>& vectors) const {
    Sources points;
    for (const auto& source : sources) {
      points.push_back({simplified(surface_, source.point.template cast<Real>()), Real(0)});
    }
    const auto& marching = lazy_->marching.get([&] { return FastMarchingSolver<Real>(surface_); });
    Array<Real> distance(vertex_count());
    marching.distance_into(distance, std::span<const Source<Real>>(points));
    const auto targets = reached_but(distance, [](Index) { return false; });
    Backtrace<Real> way(surface_, points, distance, true);
    return sampled_mean(targets, samples, largest_error, [&](Index v) {
      if (!way.walk(v).has_arrived) return 1.0;
      Path path = simplified_path(way.path());
      const std::size_t from = nearest_source(points, path);
      Real turn = 0;
      for (std::size_t i = path.size(); --i > 0;) {
        const Index face = shared_face(surface_, path[i], path[i - 1]);
        if (face < 0) return 1.0;
        turn += planes_.leg(path[i], path[i - 1], face).turn;
      }
      const auto given = planes_.basis(path.back()).project(cast<Real>(sources[from].vector));
      const auto true_one = given * std::polar(1.0, turn);
      const auto found =
          planes_.frames().basis(v).project(cast<Real>(vectors[static_cast<std::size_t>(v)]));
      return std::abs(found - true_one) / std::abs(true_one);
    });
  }

  [[nodiscard]] Path simplified_path(const Path& path) const {
    Path result;
    for (const auto& p : path) {
      const Point point = simplified(surface_, p);
      if (result.empty() || !(result.back() == point)) result.push_back(point);
    }
    return result;
  }

  // Which source the path ends at; added to a path that ends at a vertex of the source's face.
  [[nodiscard]] std::size_t nearest_source(const Sources& sources, Path& path) const {
    using namespace arithmetic;
    std::size_t nearest = 0;
    Real least = unreachable<Real>;
    for (std::size_t s = 0; s < sources.size(); ++s) {
      const Point& point = sources[s].point;
      if (shared_face(surface_, path.back(), point) < 0) continue;
      const Real d = norm(surface_.position(path.back()) - surface_.position(point));
      if (!(d < least)) continue;
      least = d;
      nearest = s;
    }
    if (!(path.back() == sources[nearest].point)) path.push_back(sources[nearest].point);
    return nearest;
  }

  [[nodiscard]] double log_map_error(Index vertex, const Map& map) const {
    const auto& marching = lazy_->marching.get([&] { return FastMarchingSolver<Real>(surface_); });
    Array<Real> distance(vertex_count());
    marching.distance_into(distance, vertex);
    const auto targets = reached_but(distance, [&](Index v) { return map.is_exact[v] != 0; });
    const auto reached = reached_but(distance, [](Index) { return false; });
    if (targets.empty()) return 0;
    const double share = static_cast<double>(targets.size()) / static_cast<double>(reached.size());
    Backtrace<Real> way(surface_, {{vertex_point<Real>(vertex), 0}}, distance, true);
    const auto at = [&](Index v) {
      return std::complex<Real>(map.coordinates[static_cast<std::size_t>(v)][0],
                                map.coordinates[static_cast<std::size_t>(v)][1]);
    };
    const auto error_at = [&](Index v) {
      const auto walk = way.walk(v);
      const auto entry = walk.has_arrived ? entry_of(way.path(), map, at) : 0.0;
      if (entry == 0.0) return 1.0;
      const auto true_one = walk.length.taut * entry / std::abs(entry);
      return std::min(2.0, std::abs(at(v) - true_one) / std::abs(true_one));
    };
    return share * sampled_mean(targets, samples, largest_error / share, error_at);
  }

  // Where a path from afar first meets what is exact, in the map; zero if only at its end.
  [[nodiscard]] std::complex<Real> entry_of(const Path& path, const Map& map, auto&& at) const {
    for (const Point& p : path) {
      const auto& [a, b] = p.element;
      const bool is_vertex = p.kind == Point::Kind::vertex;
      if (!map.is_exact[a] || (!is_vertex && !map.is_exact[b])) continue;
      return is_vertex ? at(a) : p.weights[0] * at(a) + p.weights[1] * at(b);
    }
    return 0;
  }

  [[nodiscard]] static Field unit_directions(ScaledField<std::complex<Real>> heat) {
    make_unit(heat.value);
    return std::move(heat.value);
  }
  static void make_unit(Field& field) {
    for (auto& z : field) {
      const Real most = magnitude(z);
      if (most == 0) continue;
      z /= most;
      z /= std::sqrt(z.real() * z.real() + z.imag() * z.imag());
    }
  }

  // The mean of what sums to `sums` at some vertices, where there are `counts` of it, weighted by
  // nearness: quotient of two heat flows. NaN where no heat. Never outside the range of what it is
  // a mean of, where obtuse corners of the border, whose weights are negative, would take it.
  [[nodiscard]] Array<Real> carried_mean(Array<Real> sums, Array<Real> counts, Real least,
                                         Real most, const CancelHook& cancelled) const {
    Real widest = 0;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (counts[v] != 0) widest = std::max(widest, system_->share_of_turn(v));
    }
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (counts[v] == 0) continue;
      // At most 1, with which the largest number there is is not too large.
      const Real weight = system_->share_of_turn(v) / widest;
      sums[v] *= weight;
      counts[v] *= weight;
    }
    const auto& system = *system_;
    const auto reached = system.reached_from(counts);
    const auto& factor = system.heat_factor(cancelled.part(0, 0.5));
    const auto above = heat_flow(system.heat, factor, sums, reached, cancelled.part(0.5, 0.75));
    const auto below = heat_flow(system.heat, factor, counts, reached, cancelled.part(0.75, 1));
    Array<Real> result(sums.size(), std::numeric_limits<Real>::quiet_NaN());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (below.value[v] == 0) continue;
      const Real mean =
          std::ldexp(above.value[v] / below.value[v], above.exponent[v] - below.exponent[v]);
      result[v] = std::clamp(mean, least, most);
    }
    return result;
  }

  [[nodiscard]] std::vector<Vec3<T>> embedded(const Field& field) const {
    std::vector<Vec3<T>> result(field.size());
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      result[static_cast<std::size_t>(v)] = cast<T>(planes_.frames().basis(v).embed(field[v]));
    }
    return result;
  }

  // As far as HeatSolver's distances are exact, the map is so too.
  void set_near(Index source, Map& map) const {
    const Real radius = HeatOptions{}.exact_radius * system_->mean_edge;
    const auto& exact = lazy_->exact.get([&] { return ExactSolver<Real>(surface_); });
    const auto field = exact.solve(source, {.max_distance = radius});
    const auto distances = field.distances();
    for (std::size_t v = 0; v < vertex_count(); ++v) {
      const Real d = distances[v];
      if (!(d < unreachable<Real>)) continue;
      map.is_exact[static_cast<Index>(v)] = 1;
      if (!(d > 0)) continue;
      const auto way = field.departure(static_cast<Index>(v));
      const Real angle =
          planes_.angle_at(vertex_point<Real>(source), Surface<Real>::face_of(way.halfedge),
                           planes_.side_angle(way.halfedge) + way.angle);
      map.coordinates[v] = {static_cast<T>(d * std::cos(angle)),
                            static_cast<T>(d * std::sin(angle))};
    }
  }

  // Returns the length of the vector that is carried.
  Real add_source(const VectorSource<T>& source, std::size_t number, Field& load,
                  Array<Real>& lengths, Array<Real>& counts) const {
    surface_.require_point(source.point);
    const auto point = simplified(surface_, source.point.template cast<Real>());
    const Vec3<Real> vector = cast<Real>(source.vector);
    require(is_finite(vector), "the vector of source ", number, " is (", vector[0], ", ", vector[1],
            ", ", vector[2], "), which is not finite");
    if (point.kind == Point::Kind::vertex) require_faces(point.element[0]);
    const auto basis = planes_.basis(point);
    const auto tangent = basis.project(vector);
    const Real length = std::abs(tangent);
    require(length <= largest_number<T>, "the vector of source ", number, " is ", length,
            " long, longer than one of its parts can be");
    require(length > normal_share * stable_norm(vector), "the vector of source ", number, ", (",
            vector[0], ", ", vector[1], ", ", vector[2], "), has no part tangent to the surface");
    // Of length 1: a longer one would be carried far into the regions of shorter ones.
    const auto unit = tangent / length;
    const auto add = [&](Index v, Real share, Real turn) {
      load[v] += system_->share_of_turn(v) * share * unit * std::polar(1.0, turn);
      lengths[v] += share * length;
      counts[v] += share;
      require(std::isfinite(lengths[v]), "with that of source ", number,
              ", the vectors' lengths at vertex ", v, " sum to ", lengths[v]);
    };
    for_each_vertex_of(point, add);
    return length;
  }

  // Calls `visit(vertex, weight, turn)` for the vertices of a point's element: turning a vector
  // from the point's basis by `turn` gives the parallel one in the vertex' basis.
  void for_each_vertex_of(const Point& point, auto&& visit) const {
    if (point.kind == Point::Kind::vertex) return visit(point.element[0], 1.0, 0.0);
    const Index h = planes_.first_halfedge(point);
    const auto& frames = planes_.frames();
    if (point.kind == Point::Kind::edge) {
      const bool same_way = surface_.origin(h) == point.element[0];
      visit(surface_.origin(h), point.weights[same_way ? 0 : 1], frames.angle(h));
      visit(surface_.tip(h), point.weights[same_way ? 1 : 0],
            frames.angle_back(h) + std::numbers::pi);
      return;
    }
    for (Index k = 0; k < 3; ++k) {
      // The middle of the vertex' corner in its own plane lies on the middle of the face's corner.
      const Real middle = planes_.side_angle(h + k) + frames.corner(h + k) / 2;
      const Index v = surface_.origin(h + k);
      visit(v, point.weights[static_cast<std::size_t>(k)],
            planes_.angle_at(vertex_point<Real>(v), point.element[0], middle) - middle);
    }
  }

  [[nodiscard]] Field radial_directions(Index vertex, const CancelHook& cancelled) const {
    Field load(vertex_count(), 0);
    for (Index h = 0; h < static_cast<Index>(system_->origins.size()); ++h) {
      if (system_->origins[h] == vertex) add_radial_load(h, load);
    }
    auto field = unit_directions(flow(load, cancelled));
    set_round(vertex, field);
    return field;
  }

  // Exact along the edges from the vertex.
  void set_round(Index vertex, Field& field) const {
    field[vertex] = 0;
    const auto& frames = planes_.frames();
    for (const Index h : surface_.corners(vertex)) {
      const Index back = surface_.previous(h);
      field[surface_.tip(h)] = std::polar(1.0, frames.angle_back(h) + std::numbers::pi);
      field[surface_.origin(back)] = std::polar(1.0, frames.angle(back) + std::numbers::pi);
    }
  }

  // Whether a vertex or a neighbour lies on a border. What runs against the border is held there in
  // the heat's gradient, and is not in a field that is carried, so that the flow of such a source's
  // load would not be that gradient.
  [[nodiscard]] bool is_beside_border(Index vertex) const {
    const auto is_at_border = [&](Index v) {
      const auto corners = surface_.corners(v);
      return std::any_of(corners.begin(), corners.end(), [&](Index h) {
        return surface_.is_border(h) || surface_.is_border(surface_.previous(h));
      });
    };
    const auto corners = surface_.corners(vertex);
    return is_at_border(vertex) || std::any_of(corners.begin(), corners.end(), [&](Index h) {
             return is_at_border(surface_.tip(h)) || is_at_border(surface_.apex(h));
           });
  }

  // The directions of the distance's gradient, the mean of the faces at each vertex, by area. Where
  // that has none, as in a face whose corners are equally far, they are those of the flow.
  [[nodiscard]] Field gradient_directions(Index vertex, const Array<Real>& distance,
                                          const CancelHook& cancelled) const {
    Field field(vertex_count(), 0);
    Array<Real> area(vertex_count(), 0);
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto corners = surface_.face(f);
      if (!(distance[corners[0]] < unreachable<Real>)) continue;
      const Index h = 3 * f;
      const auto [x1, x2, y2] = laid_out(
          mollified({surface_.length(h), surface_.length(h + 1), surface_.length(h + 2)}, 1));
      const Real rise1 = distance[corners[1]] - distance[corners[0]];
      const Real rise2 = distance[corners[2]] - distance[corners[0]];
      const Real x = y2 * rise1, y = x1 * rise2 - x2 * rise1;  // times twice the area
      for (const Index v : corners) {
        field[v] += std::polar(std::hypot(x, y),
                               planes_.angle_at(vertex_point<Real>(v), f, std::atan2(y, x)));
        area[v] += x1 * y2;
      }
    }
    const auto is_level = [&](Index v) {
      return area[v] > 0 && magnitude(field[v]) < next_to_level * area[v];
    };
    Field flow;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (!is_level(v)) continue;
      if (flow.empty()) flow = radial_directions(vertex, cancelled);
      field[v] = flow[v];
    }
    make_unit(field);
    set_round(vertex, field);
    return field;
  }

  // The load is a derivative of the point source: the integral of each hat function's gradient over
  // the faces at the vertex. Its field is minus the gradient of the heat, so it runs radially on
  // any mesh of a plane, while loads that follow the unit field itself lean with the mesh's edges.
  void add_radial_load(Index h, Field& load) const {
    const auto& mesh = signposts_.mesh;
    const Index next = Signposts::next(h), back = Signposts::previous(h);
    const Real corner = signposts_.corner(h);
    const std::complex<Real> to_tip = mesh.lengths[h];
    const std::complex<Real> to_apex = std::polar(mesh.lengths[back], corner);
    const std::complex<Real> quarter_turn(0, 1);
    // Twice the integrals, in the face with h along x.
    const auto at_tip = -quarter_turn * to_apex;
    const auto at_apex = quarter_turn * to_tip;
    const Real middle = (signposts_.angle[h] + signposts_.far[h]) / 2;
    load[mesh.origins[h]] -= (at_tip + at_apex) * std::polar(1.0, middle - corner / 2);
    load[mesh.origins[next]] +=
        at_tip * std::polar(1.0, signposts_.angle_back(h) + std::numbers::pi);
    load[mesh.origins[back]] +=
        at_apex * std::polar(1.0, signposts_.angle[back] + std::numbers::pi - corner);
  }

  // A vector whose tangent part is less than this share of it has no direction beyond round-off.
  static constexpr Real normal_share = 16.0 * Real{std::numeric_limits<T>::epsilon()};

  Surface<Real> surface_;
  CancelHook cancelled_;
  TangentPlanes<Real> planes_;
  std::shared_ptr<const HeatSystem<Real>> system_;
  Signposts signposts_;
  SymmetricMatrix<std::complex<Real>> connection_;
  std::shared_ptr<const SetUpLater> lazy_;
};

}  // namespace gelight::detail
