#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <concepts>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/lazy.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/backtrace.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/sampled_error.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/transport/tangent_planes.hpp"
#include "gelight/transport/vector_heat/signposts.hpp"

namespace gelight {

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
/// a scanner's (the median of 24), up to 51, since what a path passes between counts: `solve`
/// tells, and ParallelTransport along ExactField::path is exact. Within an edge or two of the
/// antipode of a source without symmetry the carried vector is up to 17 degrees off on spheres.
template <std::floating_point T>
class VectorHeatSolver {
  using Real = typename detail::WorkingPrecision<T>::Real;

 public:
  /// Throws InvalidInput as Surface does, for faces that are not oriented alike, for edges of more
  /// than two faces, and for a time factor that is not positive. Each matrix is factored when it is
  /// first needed: one to transport from a single source, one more for several sources and to
  /// extend, one more for the log map.
  template <TriangleMesh M>
  explicit VectorHeatSolver(const M& mesh, const VectorHeatOptions& options = {})
      : VectorHeatSolver(Surface<double>(mesh, options.cancelled.part(0, 0)), nullptr, options) {}

  /// Shares the matrices of a HeatSolver, and its time factor and triangulation. Throws
  /// InvalidInput as above for its surface.
  explicit VectorHeatSolver(const HeatSolver<T>& heat, const CancelHook& cancelled = {})
      : VectorHeatSolver(heat.surface(), heat.system(),
                         {heat.system()->time_factor, heat.system()->is_delaunay, cancelled}) {}

  /// The surface that the solver works on.
  [[nodiscard]] const Surface<double>& surface() const { return surface_; }

  /// Two unit vectors, x and y, that span the tangent plane at a vertex; x cross y is the normal.
  /// They are those of ExactLogMapSolver (see TangentFrames).
  [[nodiscard]] std::array<Vec3<T>, 2> tangent_basis(Index vertex) const {
    surface_.require_vertex(vertex);
    const auto& basis = planes_.frames().basis(vertex);
    return {cast<T>(basis.x), cast<T>(basis.y)};
  }

  /// Carries a vector from a vertex to all others. Its part in the vertex' tangent plane is what is
  /// carried, with its length. Throws InvalidInput for a vector that is not finite or normal to the
  /// surface, and a vertex out of range or without faces.
  [[nodiscard]] std::vector<Vec3<T>> transport(Index vertex, const Vec3<T>& vector) const {
    surface_.require_vertex(vertex);
    const VectorSource<T> source{vertex_point<T>(vertex), vector};
    return transport(std::span<const VectorSource<T>>(&source, 1));
  }

  /// Carries each vector over the region nearest to its source, blended between them.
  [[nodiscard]] std::vector<Vec3<T>> transport(std::span<const VectorSource<T>> sources) const {
    detail::require(!sources.empty(), "there is no source");
    const CancelHook cancelled = asked_in_query();
    Field load(vertex_count(), 0);
    detail::Array<Real> length_load(vertex_count(), 0), share_load(vertex_count(), 0);
    for (std::size_t s = 0; s < sources.size(); ++s) {
      add_source(sources[s], s, load, length_load, share_load);
    }
    auto carried = unit_directions(flow(load, cancelled.part(0, 0.6)));
    if (sources.size() == 1) {
      const Real length = std::accumulate(length_load.begin(), length_load.end(), 0.0);
      for (auto& z : carried) z *= length;
    } else {
      const auto lengths = ratio(length_load, share_load, cancelled.part(0.6, 1));
      for (Index v = 0; v < surface_.vertex_count(); ++v) {
        if (carried[v] != 0.0) carried[v] *= lengths[v];
      }
    }
    return embedded(carried);
  }

  /// The same vectors as `transport` gives, with an estimate of their error, which `transport`
  /// alone does not tell. It costs a query of FastMarchingSolver besides. Throws InvalidInput as
  /// `transport` does.
  ///@{
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
  ///@}

  /// Unit vectors that point away from a vertex, along the shortest paths from it; zero at itself
  /// and where no path leads. Along an edge from the vertex they are exact.
  [[nodiscard]] std::vector<Vec3<T>> radial(Index vertex) const {
    surface_.require_vertex(vertex);
    require_faces(vertex);
    return embedded(radial_directions(vertex, asked_in_query()));
  }

  /// Coordinates of each vertex in the tangent plane of another, along its `tangent_basis`: as far
  /// as, and in the direction in which, the shortest path leaves. Infinite where no path leads.
  ///
  /// Exact within three mean edges of the vertex. Over all vertices, by benchmarks/claims.cpp,
  /// radius and direction are 0.3 to 0.4 % and 0.3 to 0.5 degrees off on average on icospheres of
  /// 2,562 and 10,242 vertices, 0.35 % and 1 degree on the GelTip membrane (at most 4.1 % and, at
  /// the cut locus, any angle), 1.3 % and 7 degrees on rough meshes like a scanner's (the median of
  /// 24), and far off on thin triangles with obtuse corners at the border: `solve_log_map`
  /// tells. ExactLogMapSolver is exact everywhere, in some thirty times the time.
  [[nodiscard]] std::vector<Vec2<T>> log_map(Index vertex) const {
    return mapped(vertex).coordinates;
  }

  /// The same coordinates as `log_map` gives, with an estimate of their error, which `log_map`
  /// alone does not tell. It costs a query of FastMarchingSolver besides. Throws InvalidInput as
  /// `log_map` does.
  [[nodiscard]] LogMapResult<T> solve_log_map(Index vertex) const {
    const Map map = mapped(vertex);
    LogMapResult<T> result{map.coordinates};
    result.error = log_map_error(vertex, map);
    result.is_reliable = result.error <= largest_error;
    return result;
  }

  /// Continues values given at some vertices to all others: about that of the nearest one, smoothly
  /// in between, never outside their range. NaN where no path leads. Throws InvalidInput for no
  /// vertices, another number of values, a value that is not finite, values of one vertex whose sum
  /// is not, a vertex out of range.
  [[nodiscard]] std::vector<T> extend(std::span<const Index> vertices,
                                      std::span<const T> values) const {
    detail::require(!vertices.empty(), "there is no vertex to extend from");
    detail::require(vertices.size() == values.size(), "there are ", vertices.size(),
                    " vertices and ", values.size(), " values");
    detail::Array<Real> value_load(vertex_count(), 0), share_load(vertex_count(), 0);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      surface_.require_vertex(vertices[k]);
      detail::require(std::isfinite(values[k]), "value ", k, " is ", values[k],
                      ", which is not finite");
      value_load[vertices[k]] += Real{values[k]};
      share_load[vertices[k]] += 1;
      detail::require(std::isfinite(value_load[vertices[k]]), "the values of vertex ", vertices[k],
                      " sum to ", value_load[vertices[k]]);
    }
    const auto extended = ratio(value_load, share_load, asked_in_query());
    std::vector<T> result(extended.size());
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = static_cast<T>(extended.data()[i]);
    return result;
  }

 private:
  using Field = detail::Array<std::complex<Real>>;
  using Point = SurfacePoint<Real>;
  using Signposts = detail::Signposts<Real>;

  // Made when first asked for.
  struct SetUpLater {
    detail::Lazy<detail::SparseFactor<std::complex<Real>>> factor;
    detail::Lazy<HeatSolver<Real>> heat;
    detail::Lazy<ExactSolver<Real>> exact;
    detail::Lazy<FastMarchingSolver<Real>> marching;
  };

  struct Map {
    std::vector<Vec2<T>> coordinates;
    detail::Array<char> is_exact;  // of each vertex
  };

  VectorHeatSolver(Surface<Real> surface, std::shared_ptr<const detail::HeatSystem<Real>> system,
                   const VectorHeatOptions& options)
      : surface_(std::move(surface)),
        cancelled_(options.cancelled),
        planes_(surface_,
                options.intrinsic_delaunay ? detail::mollified_triangulation(surface_, 1)
                                           : intrinsic_triangulation(surface_),
                cancelled_.part(0, 0)),
        system_(system ? std::move(system)
                       : std::make_shared<detail::HeatSystem<Real>>(
                             surface_, options.time_factor, options.intrinsic_delaunay, nullptr,
                             asked_in_set_up().part(0, 0.5))),
        signposts_(signposts(asked_in_set_up().part(0.5, 1))),
        connection_(connection_matrix()),
        lazy_(std::make_shared<SetUpLater>()) {}

  [[nodiscard]] std::size_t vertex_count() const {
    return static_cast<std::size_t>(surface_.vertex_count());
  }

  void require_faces(Index vertex) const {
    detail::require(!surface_.corners(vertex).empty(), "vertex ", vertex,
                    " is in no face, it has no tangent plane");
  }

  [[nodiscard]] CancelHook asked_in_set_up() const {
    return detail::rising(cancelled_, "the vector heat solver's set-up");
  }
  [[nodiscard]] CancelHook asked_in_query() const {
    return detail::rising(cancelled_, "a query of the vector heat solver");
  }

  [[nodiscard]] Signposts signposts(const CancelHook& cancelled) const {
    if (!system_->is_delaunay) {
      return {intrinsic_triangulation(surface_, system_->unit), planes_.frames()};
    }
    // The same flips as the system's, with the directions kept.
    Signposts posts(detail::mollified_triangulation(surface_, system_->unit), planes_.frames());
    detail::flip_to_delaunay(
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

  [[nodiscard]] const detail::SparseFactor<std::complex<Real>>& factor(
      const CancelHook& cancelled) const {
    return lazy_->factor.get(
        [&] { return detail::factored(system_->dissection(), connection_, cancelled); });
  }

  [[nodiscard]] HeatSolver<Real> shared_heat(const CancelHook& cancelled) const {
    return {surface_, HeatOptions{.time_factor = system_->time_factor, .cancelled = cancelled},
            system_};
  }

  [[nodiscard]] detail::ScaledField<std::complex<Real>> flow(const Field& load,
                                                             const CancelHook& cancelled) const {
    return detail::heat_flow(connection_, factor(cancelled.part(0, 0.5)), load,
                             system_->reached_from(load), cancelled.part(0.5, 1));
  }

  // Coordinates, exact near the vertex.
  [[nodiscard]] Map mapped(Index vertex) const {
    surface_.require_vertex(vertex);
    require_faces(vertex);
    const CancelHook cancelled = asked_in_query();
    Field load(vertex_count(), 0);
    load[vertex] = 1;
    const auto axis = unit_directions(flow(load, cancelled.part(0, 0.4)));
    const auto radial = radial_directions(vertex, cancelled.part(0.4, 0.6));
    const auto& heat = lazy_->heat.get([&] { return shared_heat(cancelled.part(0.6, 0.8)); });
    const auto distance =
        heat.solution({{vertex_point<Real>(vertex), 0}}, cancelled.part(0.8, 1)).distance;
    Map map{std::vector<Vec2<T>>(vertex_count()), detail::Array<char>(vertex_count(), 0)};
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const std::complex<Real> direction = radial[v] * std::conj(axis[v]);
      const bool is_reached = distance[v] < unreachable<Real>;
      (void)detail::distance_as<T>(distance[v], "vertex ", v);
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

  using Path = std::vector<Point>;

  // The vertices to be asked: those that are reached, but for some.
  [[nodiscard]] detail::Array<Index> reached_but(const detail::Array<Real>& distance,
                                                 auto&& is_left_out) const {
    detail::Array<Index> targets;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (distance[v] > 0 && distance[v] < unreachable<Real> && !is_left_out(v)) {
        targets.push_back(v);
      }
    }
    return targets;
  }

  [[nodiscard]] double transport_error(std::span<const VectorSource<T>> sources,
                                       const std::vector<Vec3<T>>& vectors) const {
    detail::Sources points;
    for (const auto& source : sources) {
      points.push_back({detail::simplified(surface_, source.point.template cast<Real>()), Real(0)});
    }
    const auto& marching = lazy_->marching.get([&] { return FastMarchingSolver<Real>(surface_); });
    detail::Array<Real> distance(vertex_count());
    marching.distance_into(distance, std::span<const Source<Real>>(points));
    const auto targets = reached_but(distance, [](Index) { return false; });
    detail::Backtrace<Real> way(surface_, points, distance, true);
    return detail::sampled_mean(targets, samples, largest_error, [&](Index v) {
      if (!way.walk(v).has_arrived) return 1.0;
      Path path = simplified_path(way.path());
      const std::size_t from = nearest_source(points, path);
      Real turn = 0;
      for (std::size_t i = path.size(); --i > 0;) {
        const Index face = detail::shared_face(surface_, path[i], path[i - 1]);
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
      const Point point = detail::simplified(surface_, p);
      if (result.empty() || !(result.back() == point)) result.push_back(point);
    }
    return result;
  }

  // Which source the path ends at; added to a path that ends at a vertex of the source's face.
  [[nodiscard]] std::size_t nearest_source(const detail::Sources& sources, Path& path) const {
    using namespace detail::arithmetic;
    std::size_t nearest = 0;
    Real least = unreachable<Real>;
    for (std::size_t s = 0; s < sources.size(); ++s) {
      const Point& point = sources[s].point;
      if (detail::shared_face(surface_, path.back(), point) < 0) continue;
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
    detail::Array<Real> distance(vertex_count());
    marching.distance_into(distance, vertex);
    const auto targets = reached_but(distance, [&](Index v) { return map.is_exact[v] != 0; });
    const auto reached = reached_but(distance, [](Index) { return false; });
    if (targets.empty()) return 0;
    const double share = static_cast<double>(targets.size()) / static_cast<double>(reached.size());
    detail::Backtrace<Real> way(surface_, {{vertex_point<Real>(vertex), 0}}, distance, true);
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
    return share * detail::sampled_mean(targets, samples, largest_error / share, error_at);
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

  [[nodiscard]] static Field unit_directions(detail::ScaledField<std::complex<Real>> heat) {
    for (auto& z : heat.value) {
      const Real most = detail::magnitude(z);
      if (most == 0) continue;
      z /= most;
      z /= std::sqrt(z.real() * z.real() + z.imag() * z.imag());
    }
    return std::move(heat.value);
  }

  // Quotient of two heat flows: a mean of value / share, weighted by nearness. NaN where no heat.
  // Never outside the range of what it is a mean of, where obtuse corners of the border, whose
  // weights are negative, would take it.
  [[nodiscard]] detail::Array<Real> ratio(const detail::Array<Real>& values,
                                          const detail::Array<Real>& shares,
                                          const CancelHook& cancelled) const {
    const auto& system = *system_;
    const auto reached = system.reached_from(shares);
    const auto& factor = system.heat_factor(cancelled.part(0, 0.5));
    const auto above =
        detail::heat_flow(system.heat, factor, values, reached, cancelled.part(0.5, 0.75));
    const auto below =
        detail::heat_flow(system.heat, factor, shares, reached, cancelled.part(0.75, 1));
    Real least = unreachable<Real>, most = -unreachable<Real>;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      if (shares[v] == 0) continue;
      least = std::min(least, values[v] / shares[v]);
      most = std::max(most, values[v] / shares[v]);
    }
    detail::Array<Real> result(values.size(), std::numeric_limits<Real>::quiet_NaN());
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

  void add_source(const VectorSource<T>& source, std::size_t number, Field& load,
                  detail::Array<Real>& lengths, detail::Array<Real>& shares) const {
    surface_.require_point(source.point);
    const auto point = detail::simplified(surface_, source.point.template cast<Real>());
    const Vec3<Real> vector = cast<Real>(source.vector);
    detail::require(detail::is_finite(vector), "the vector of source ", number, " is (", vector[0],
                    ", ", vector[1], ", ", vector[2], "), which is not finite");
    if (point.kind == Point::Kind::vertex) require_faces(point.element[0]);
    const auto basis = planes_.basis(point);
    const auto tangent = basis.project(vector);
    const Real length = std::abs(tangent);
    detail::require(length <= Real{std::numeric_limits<T>::max()}, "the vector of source ", number,
                    " is ", length, " long, longer than one of its parts can be");
    detail::require(length > normal_share * detail::stable_norm(vector), "the vector of source ",
                    number, ", (", vector[0], ", ", vector[1], ", ", vector[2],
                    "), has no part tangent to the surface");
    const auto add = [&](Index v, Real weight, Real turn) {
      load[v] += weight * tangent * std::polar(1.0, turn);
      lengths[v] += weight * length;
      shares[v] += weight;
      detail::require(std::isfinite(lengths[v]), "with that of source ", number,
                      ", the vectors' lengths at vertex ", v, " sum to ", lengths[v]);
    };
    for_each_vertex_of(point, add);
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
    field[vertex] = 0;
    const auto& frames = planes_.frames();
    for (const Index h : surface_.corners(vertex)) {
      const Index back = surface_.previous(h);
      field[surface_.tip(h)] = std::polar(1.0, frames.angle_back(h) + std::numbers::pi);
      field[surface_.origin(back)] = std::polar(1.0, frames.angle(back) + std::numbers::pi);
    }
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
  detail::TangentPlanes<Real> planes_;
  std::shared_ptr<const detail::HeatSystem<Real>> system_;
  Signposts signposts_;
  SymmetricMatrix<std::complex<Real>> connection_;
  std::shared_ptr<const SetUpLater> lazy_;
};

template <TriangleMesh M>
explicit VectorHeatSolver(const M&) -> VectorHeatSolver<MeshScalar<M>>;
template <TriangleMesh M>
VectorHeatSolver(const M&, const VectorHeatOptions&) -> VectorHeatSolver<MeshScalar<M>>;
template <std::floating_point T>
explicit VectorHeatSolver(const HeatSolver<T>&) -> VectorHeatSolver<T>;

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template class VectorHeatSolver<float>;
GELIGHT_ONCE template class VectorHeatSolver<double>;
}  // namespace gelight
#endif
