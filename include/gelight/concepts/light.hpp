#pragma once

#include <concepts>
#include <span>
#include <vector>

#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"

// The seam between an LED and the light that it sends over a membrane. A light model of one's own
// is a class with one function:
//
//     struct Sunlight {  // comes from the same side everywhere
//       Vec3<float> way;
//       std::vector<Vec3<float>> field(const Led<float>&, std::span<const SurfacePoint<float>>
//       points,
//                                      const CancelHook& = {}) const {
//         return std::vector<Vec3<float>>(points.size(), way);
//       }
//     };
namespace gelight {

template <std::floating_point T>
struct SurfacePoint;
template <std::floating_point T>
struct Led;

/// A light model: the direction in which the light of an LED travels at each of some points of a
/// membrane, in the frame of the membrane's mesh, zero where it has none. In a renderer that is the
/// camera's frame: with a positive z light goes away from the camera, with a negative one towards
/// it; what meets a surface from behind does not light it. As long as 1, or shorter
/// where there is less light. Where the points are tells `Surface<T>(mesh).position(point)`, of the
/// mesh that they are of. The model asks the hook while it works, and throws Cancelled where that
/// answers yes. Calls may come from several threads. A `static constexpr bool is_tangent`, if there
/// is one, tells a renderer whether light runs in the membrane, so that at rest it is tangent.
template <class M, class T>
concept LightModel = std::floating_point<T> &&
    requires(const M& model, const Led<T>& led, std::span<const SurfacePoint<T>> points,
             const CancelHook& cancelled) {
  { model.field(led, points) } -> std::same_as<std::vector<Vec3<T>>>;
  { model.field(led, points, cancelled) } -> std::same_as<std::vector<Vec3<T>>>;
};

}  // namespace gelight
