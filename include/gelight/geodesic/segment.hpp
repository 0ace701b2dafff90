#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/neighbourhood.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {

/// A straight piece of one face, or of an edge, as a source: distances count from its nearest
/// point.
template <std::floating_point T>
struct Segment {
  SurfacePoint<T> begin;  ///< one end
  SurfacePoint<T> end;    ///< the other, in a face that holds both
  T distance = 0;         ///< with how much distances start, all along it
};

/// The pieces of a path, which is a chain of them; one point is a piece of no length.
template <std::floating_point T>
[[nodiscard]] std::vector<Segment<T>> segments(const Path<T>& path) {
  std::vector<Segment<T>> out;
  if (path.size() == 1) out.push_back({path[0], path[0]});
  for (std::size_t i = 1; i < path.size(); ++i) out.push_back({path[i - 1], path[i]});
  return out;
}

namespace detail {

/// A segment as one face has it: the shares of its ends.
template <std::floating_point T>
struct SegmentFront {
  Index face = -1;
  std::array<T, 3> begin{}, end{};
  T start = 0;

  /// The shares at a part of the way from its beginning.
  [[nodiscard]] std::array<T, 3> at(T t) const {
    std::array<T, 3> out;
    for (std::size_t k = 0; k < 3; ++k) out[k] = (1 - t) * begin[k] + t * end[k];
    const T sum = out[0] + out[1] + out[2];
    for (T& w : out) w /= sum;
    return out;
  }
};

/// The diagonal of the box about a surface.
template <std::floating_point Real>
[[nodiscard]] Real size_of(const Surface<Real>& surface) {
  Vec3<Real> low = surface.position(0), high = low;
  for (Index v = 1; v < surface.vertex_count(); ++v) {
    low = least_of(low, surface.position(v));
    high = greatest_of(high, surface.position(v));
  }
  return stable_norm(high - low);
}

/// A segment in each of the faces that hold it. Throws InvalidInput for points that are not of the
/// surface, where none holds both, and a start that is not finite.
template <std::floating_point Real, std::floating_point T>
[[nodiscard]] Array<SegmentFront<Real>> fronts_of(const Surface<Real>& surface,
                                                  const Segment<T>& segment, std::size_t number) {
  for (const auto& point : {segment.begin, segment.end}) surface.require_point(point);
  require(std::isfinite(segment.distance), "segment ", number, " starts with distance ",
          segment.distance, ", which is not finite");
  const auto begin = simplified(surface, segment.begin.template cast<Real>());
  const auto end = simplified(surface, segment.end.template cast<Real>());
  Array<SegmentFront<Real>> out;
  for_each_place(surface, begin, [&](Index f, const std::array<Real, 3>& a) {
    for_each_place(surface, end, [&](Index g, const std::array<Real, 3>& b) {
      if (f == g) out.push_back({f, a, b, static_cast<Real>(segment.distance)});
    });
  });
  require(!out.empty(), "no face holds both ends of segment ", number);
  return out;
}

}  // namespace detail

/// Points on segments no more than `spacing` apart, as sources of solvers that know no segments:
/// distances are too long by less than spacing^2 / (8 distance), and their own error. Throws
/// InvalidInput for a segment that leaves its face and a spacing that is not positive, not finite
/// or less than a millionth of a segment.
///@{
template <std::floating_point Real, std::floating_point T>
[[nodiscard]] std::vector<Source<T>> sources_along(const Surface<Real>& surface,
                                                   std::span<const Segment<T>> segments,
                                                   std::type_identity_t<T> spacing) {
  detail::require(spacing > 0 && std::isfinite(spacing), "the spacing is ", spacing,
                  ", not a positive number");
  std::vector<Source<T>> out;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto front = detail::fronts_of(surface, segments[i], i)[0];
    const Real length = detail::stable_norm(surface.difference(
        segments[i].begin.template cast<Real>(), segments[i].end.template cast<Real>()));
    // The narrower type may hold no such spacing.
    using Wide = std::common_type_t<Real, T>;
    const Wide step = spacing;
    detail::require(length <= Wide(1e6) * step, "the spacing is ", spacing,
                    ", less than a millionth of segment ", i);
    const auto pieces = static_cast<Index>(std::ceil(length / step));
    for (Index k = 0; k <= pieces; ++k) {
      const Real t = pieces > 0 ? static_cast<Real>(k) / static_cast<Real>(pieces) : Real(0);
      const auto point = detail::simplified(surface, face_point(front.face, front.at(t)));
      out.push_back({point.template cast<T>(), segments[i].distance});
    }
  }
  return out;
}
template <std::floating_point Real, std::floating_point T>
[[nodiscard]] std::vector<Source<T>> sources_along(const Surface<Real>& surface,
                                                   const std::vector<Segment<T>>& segments,
                                                   std::type_identity_t<T> spacing) {
  return sources_along(surface, std::span<const Segment<T>>(segments), spacing);
}
///@}

}  // namespace gelight
