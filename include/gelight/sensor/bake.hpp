#pragma once

#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// The surface points that the pixels show, row after row, without the pixels that show none.
/// Throws InvalidInput for a raster whose images of faces and of places in them are of different
/// sizes.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> pixel_points(const Raster<T>& raster) {
  detail::require_same_size(raster.face, raster.barycentric, "the image of faces",
                            "the image of places in faces");
  std::vector<SurfacePoint<T>> points;
  for (Index y = 0; y < raster.face.height(); ++y) {
    for (Index x = 0; x < raster.face.width(); ++x) {
      const Index face = raster.face(x, y);
      if (face >= 0) points.push_back(face_point<T>(face, raster.barycentric(x, y)));
    }
  }
  return points;
}

/// Puts a field of `pixel_points(raster)` back to its pixels; zero where the raster shows nothing.
/// Throws InvalidInput unless the field has a direction for each pixel that shows something.
template <std::floating_point T>
[[nodiscard]] Image<Vec3<T>> bake(std::span<const Vec3<T>> field, const Raster<T>& raster,
                                  const CancelHook& cancelled = {}) {
  std::size_t shown = 0;
  for (const Index face : raster.face.pixels()) shown += face >= 0;
  detail::require(shown == field.size(), "the field has ", field.size(), " directions, the raster ",
                  shown, " pixels that show a face");
  Image<Vec3<T>> baked(raster.face.width(), raster.face.height(), Vec3<T>(0, 0, 0));
  std::size_t next = 0;
  for (std::size_t i = 0; i < baked.pixels().size(); ++i) {
    if (raster.face.pixels()[i] >= 0) baked.pixels()[i] = field[next++];
    detail::check_points(cancelled, i + 1, baked.pixels().size(), "baking the field");
  }
  return baked;
}

/// The same of a field as the functions of light/ return it.
template <std::floating_point T>
[[nodiscard]] Image<Vec3<T>> bake(const LightField<T>& field, const Raster<T>& raster,
                                  const CancelHook& cancelled = {}) {
  return bake(std::span<const Vec3<T>>(field), raster, cancelled);
}

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template std::vector<SurfacePoint<float>> pixel_points<float>(const Raster<float>&);
GELIGHT_ONCE template Image<Vec3<float>> bake<float>(const LightField<float>&, const Raster<float>&,
                                                     const CancelHook&);
GELIGHT_ONCE template std::vector<SurfacePoint<double>> pixel_points<double>(const Raster<double>&);
GELIGHT_ONCE template Image<Vec3<double>> bake<double>(const LightField<double>&,
                                                       const Raster<double>&, const CancelHook&);
}  // namespace gelight
#endif
