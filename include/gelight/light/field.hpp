#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

// A light field is, for each of a list of surface points, the unit direction in which the light of
// one LED travels there, or zero where it has none: at the LED, where no light arrives, and where
// it arrives from opposite sides.
//
// What makes a field asks the hook that it takes last while it works, and throws Cancelled where
// that answers yes.

namespace gelight {

/// Of each of some surface points: the unit direction in which the light of one LED travels there,
/// zero where it has none.
template <std::floating_point T>
using LightField = std::vector<Vec3<T>>;

/// Some points of a surface. Their type is known from another argument, so that a vector of points
/// serves as it is.
template <std::floating_point T>
using PointSpan = std::type_identity_t<std::span<const SurfacePoint<T>>>;

/// How the light of an LED comes to a point: in one direction; by several paths equally short, of
/// which one is taken (the cut locus); from the LED, which is the point itself; or not at all.
enum class Lighting : std::uint8_t { lit, ambiguous, at_led, dark };

/// A light field with what else is known of each point.
template <std::floating_point T>
struct LightRays {
  LightField<T> direction;  ///< unit, or zero where `at_led` and where `dark`
  std::vector<T> distance;  ///< travelled, in the unit of the positions; +infinity where dark
  std::vector<Lighting> lighting;  ///< how the light comes

  /// Appends a point.
  void add(const Vec3<T>& way, T length, std::same_as<Lighting> auto how) {
    direction.push_back(way);
    distance.push_back(length);
    lighting.push_back(how);
  }
};

/// How light grows weaker on its way: by spreading, in inverse proportion to the distance beyond
/// `full_within`, and by absorption in the gel, exponentially. By default it does neither.
template <std::floating_point T>
struct Falloff {
  T full_within = unreachable<T>;  ///< a distance, in the unit of the positions
  T absorption = 0;                ///< per unit of the positions
};

/// The share of an LED's light that is left at each distance, from 0 (out of reach) to 1. Throws
/// InvalidInput for a distance that is negative or not a number, a `full_within` that is not
/// positive, and an absorption that is negative or not finite.
template <std::floating_point T>
[[nodiscard]] std::vector<T> strength(std::type_identity_t<std::span<const T>> distance,
                                      const Falloff<T>& falloff) {
  detail::require(falloff.full_within > 0, "light is full within ", falloff.full_within,
                  ", which is not positive");
  detail::require(falloff.absorption >= 0 && std::isfinite(falloff.absorption), "absorption ",
                  falloff.absorption, " is negative or not finite");
  std::vector<T> shares;
  shares.reserve(distance.size());
  for (const T d : distance) {
    detail::require(d >= 0, "distance ", shares.size(), " is ", d);
    const bool is_reached = d < unreachable<T>;
    shares.push_back(is_reached ? std::min(T(1), falloff.full_within / d) *
                                      std::exp(-falloff.absorption * d)
                                : T(0));
  }
  return shares;
}

/// Directions shortened to the strength of the light, as `Light::direction` takes them. Throws
/// InvalidInput for another number of strengths, and for one that is not from 0 to 1.
template <std::floating_point T>
[[nodiscard]] LightField<T> dimmed(LightField<T> field,
                                   std::type_identity_t<std::span<const T>> strengths) {
  detail::require(field.size() == strengths.size(), "the field has ", field.size(),
                  " directions, there are ", strengths.size(), " strengths");
  for (std::size_t i = 0; i < field.size(); ++i) {
    detail::require(strengths[i] >= 0 && strengths[i] <= 1, "strength ", i, " is ", strengths[i],
                    ", not from 0 to 1");
    field[i] *= strengths[i];
  }
  return field;
}

/// The surface points of all vertices.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> vertex_points(const Surface<T>& surface) {
  std::vector<SurfacePoint<T>> points;
  points.reserve(static_cast<std::size_t>(surface.vertex_count()));
  for (Index v = 0; v < surface.vertex_count(); ++v) points.push_back(vertex_point<T>(v));
  return points;
}

namespace detail {

/// Throws InvalidInput, naming the first vector that is not finite and its place.
template <class Vectors>
void require_finite(const Vectors& vectors, const char* what) {
  std::size_t i = 0;
  for (const auto& v : vectors) {
    require(detail::is_finite(v), what, " ", i++, " is (", v[0], ", ", v[1], ", ", v[2], ")");
  }
}

/// Asks a hook at every 64th of many points, and after the last.
inline void check_points(const CancelHook& cancelled, std::size_t done, std::size_t count,
                         const char* what) {
  if (cancelled && (done % 64 == 0 || done == count)) {
    cancelled.check(count > 0 ? static_cast<double>(done) / static_cast<double>(count) : 1, what);
  }
}

/// Unit vector, or zero for a vector without direction.
template <class T>
[[nodiscard]] Vec3<T> direction_of(const Vec3<T>& v) {
  return detail::stable_unit(v);
}

/// Twice the area of a face times its unit normal; in another precision if asked.
template <std::floating_point T, std::floating_point Real = T>
[[nodiscard]] Vec3<Real> face_normal(const Surface<T>& surface, Index f) {
  using namespace detail::arithmetic;
  const auto [a, b, c] = surface.face(f);
  const Vec3<Real> from = cast<Real>(surface.position(a));
  return cross<Real>(cast<Real>(surface.position(b)) - from,
                     cast<Real>(surface.position(c)) - from);
}

/// A point nearer to a side of its face than this share of the face's height is taken to be on it.
template <std::floating_point T>
inline constexpr T faces_at_snap = std::max(T(1e-9), 64 * std::numeric_limits<T>::epsilon());

/// The faces that hold a point. One that is almost on a side of its face also counts for the
/// neighbour, so that rounding cannot lose it between the two.
template <std::floating_point T>
[[nodiscard]] Array<Index> faces_at(const Surface<T>& surface, const SurfacePoint<T>& point) {
  constexpr T snap = faces_at_snap<T>;
  using Kind = typename SurfacePoint<T>::Kind;
  const auto around_vertex = [&](Index v) {
    Array<Index> faces;
    for (const Index h : surface.corners(v)) faces.push_back(Surface<T>::face_of(h));
    return faces;
  };
  const auto around_edge = [&](Index first) {
    Array<Index> faces;
    Index h = first;
    do {
      faces.push_back(Surface<T>::face_of(h));
      h = surface.twin(h);
    } while (h != first);
    return faces;
  };
  const auto [a, b] = point.element;
  const auto& w = point.weights;
  if (point.kind == Kind::vertex) return around_vertex(a);
  if (point.kind == Kind::edge) {
    if (w[0] <= snap) return around_vertex(b);
    if (w[1] <= snap) return around_vertex(a);
    return around_edge(surface.find_halfedge(a, b));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3, previous = (k + 2) % 3;
    if (w[next] <= snap && w[previous] <= snap) return around_vertex(surface.face(a)[k]);
  }
  for (Index k = 0; k < 3; ++k) {
    if (w[static_cast<std::size_t>(k)] <= snap) return around_edge(3 * a + (k + 1) % 3);
  }
  return {a};
}

}  // namespace detail

/// The same directions, laid into the planes at right angles to the normals (of the membrane at
/// rest, say) and of unit length again; zero where a direction runs along its normal. A normal need
/// not be of unit length. Throws InvalidInput for another number of normals, one that is zero or
/// not finite, and a direction that is not finite.
template <std::floating_point T>
[[nodiscard]] LightField<T> rectified(LightField<T> field,
                                      std::type_identity_t<std::span<const Vec3<T>>> normals) {
  using namespace detail::arithmetic;
  detail::require(field.size() == normals.size(), "the field has ", field.size(),
                  " directions, there are ", normals.size(), " normals");
  detail::require_finite(field, "direction");
  for (std::size_t i = 0; i < field.size(); ++i) {
    detail::require(normals[i].allFinite() && !normals[i].isZero(0), "normal ", i, " is (",
                    normals[i][0], ", ", normals[i][1], ", ", normals[i][2], ")");
    const Vec3<T> normal = detail::direction_of(normals[i]);
    const Vec3<T> tangent = field[i] - dot(field[i], normal) * normal;
    // What rounding leaves of a direction along the normal has none.
    const T rounding = 16 * std::numeric_limits<T>::epsilon() * detail::stable_norm(field[i]);
    field[i] =
        detail::stable_norm(tangent) > rounding ? detail::direction_of(tangent) : Vec3<T>(0, 0, 0);
  }
  return field;
}

}  // namespace gelight
