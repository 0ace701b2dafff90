#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/pose.hpp"
#include "gelight/image/raster/held_faces.hpp"
#include "gelight/image/raster/mesh_image.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/targets.hpp"
#include "gelight/views/image_view.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// What the camera sees of a mesh, per pixel.
template <std::floating_point T>
struct Raster {
  Image<T> depth;                       ///< z, in the unit of the positions; +infinity: nothing
  Image<Index> face;                    ///< -1 where there is nothing
  Image<std::array<T, 3>> barycentric;  ///< of the pixel's point in its face
};

/// Memory that `rasterize_into` works in: with one kept from frame to frame, each vertex is
/// projected once rather than in each of its faces, faces behind others are not drawn where that is
/// easily told, and nothing comes from the heap after the first frame of the largest mesh and
/// image.
class RasterWorkspace {
 public:
  /// Room for the vertices of a mesh.
  [[nodiscard]] detail::Array<detail::ImagePoint>& points(Index vertices) {
    points_.resize_for_writes(static_cast<std::size_t>(vertices));
    return points_;
  }

  /// Room for the faces that are drawn last.
  [[nodiscard]] detail::HeldFaces& held() { return held_; }

  /// Makes a target of faces tell what one call draws from what others drew.
  template <class T>
  void begin_call(detail::RasterTarget<T>& target, std::size_t pixels) {
    if (!target.wants_faces()) return;
    if (calls_.size() < pixels || call_ == std::numeric_limits<std::uint8_t>::max()) {
      calls_.assign(std::max(pixels, calls_.size()), 0);
      call_ = 0;
    }
    target.remember_call(calls_.data(), ++call_);
  }

 private:
  detail::Array<detail::ImagePoint> points_;
  detail::HeldFaces held_;
  detail::Array<std::uint8_t> calls_;  // of each pixel, which of the last calls drew there
  std::uint8_t call_ = 0;
};

namespace detail {

template <std::floating_point T, TriangleMesh M>
void draw_moved(RasterTarget<T> target, const M& mesh, const Pose& pose, const Camera<T>& camera,
                RasterWorkspace* work) {
  pose.require_valid();
  const ImagePlane plane(camera.template cast<double>());
  const auto vertices = static_cast<Index>(MeshTraits<M>::vertex_count(mesh));
  ImagePoint* const points = work == nullptr ? nullptr : work->points(vertices).data();
  const MeshImage image(mesh, pose, plane, camera.width, camera.height, points);
  image.template check<T>();
  if (work != nullptr) {
    const auto columns = static_cast<std::size_t>(camera.width);
    work->begin_call(target, columns * static_cast<std::size_t>(camera.height));
  }
  image.draw(target, work == nullptr ? nullptr : &work->held());
}

}  // namespace detail

/// Draws a moved mesh over what a depth image shows already, wherever it is nearer: so one call
/// after the other, in any order, gives the nearest of several objects. Begin with +infinity
/// everywhere.
///
/// It is seen as `rasterize` sees the mesh with its vertices moved (in double), but for rounding in
/// depths where the compiler may fuse multiplications with additions. Nothing is taken from the
/// heap; with a workspace, see there. Throws InvalidInput, before anything is drawn, as
/// `rasterize` does, for a pose that is not finite, and for a depth image of another size than the
/// camera's. Cost: O(faces + rows and pixels covered).
template <std::floating_point T, TriangleMesh M>
void rasterize_into(std::type_identity_t<ImageView<T>> depth, const M& mesh, const Pose& pose,
                    const Camera<T>& camera, RasterWorkspace* work = nullptr) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  detail::require(depth.rows_are_packed(),
                  "the pixels of the depth image's rows do not lie side by side");
  detail::draw_moved(detail::RasterTarget<T>(depth), mesh, pose, camera, work);
}

/// The same, with the faces that are seen, by their numbers in the mesh drawn there, and where.
template <std::floating_point T, TriangleMesh M>
void rasterize_into(Raster<T>& raster, const M& mesh, const Pose& pose, const Camera<T>& camera,
                    RasterWorkspace* work = nullptr) {
  camera.require_valid();
  detail::require_camera_size(raster.depth, camera, "the depth image");
  detail::require_camera_size(raster.face, camera, "the image of faces");
  detail::require_camera_size(raster.barycentric, camera, "the image of places in faces");
  detail::draw_moved(detail::RasterTarget<T>(raster), mesh, pose, camera, work);
}

/// What a camera sees of nothing: what to draw objects into.
template <std::floating_point T>
[[nodiscard]] Raster<T> empty_raster(const Camera<T>& camera) {
  camera.require_valid();
  return {Image<T>(camera.width, camera.height, std::numeric_limits<T>::infinity()),
          Image<Index>(camera.width, camera.height, -1),
          Image<std::array<T, 3>>(camera.width, camera.height)};
}

/// The nearest face that each pixel's ray meets, seen from the origin along +z; both sides of a
/// face are seen. Nearer than z = 0 nothing is. Works in double whatever T is.
///
/// A ray through a side or a corner of a face meets it, and none slips through between faces that
/// have sides and corners in common or at the same place, however the compiler rounds. Where a
/// corner appears is rounded to 2^-50 of the image's longer side, made a power of two. A face whose
/// image has no area is not seen; the depth of a pixel is one that its face has.
///
/// Throws InvalidInput for a bad camera, one whose focal lengths are not from 1e-150 to 1e150 or
/// whose centre is more than 2^42 pixels off, for a face with an index out of range or a position
/// that is not finite, and for one that is seen at a depth that T does not hold, or not from 1e-150
/// to 1e150. Cost: O(vertices + faces + rows and pixels covered).
template <std::floating_point T, TriangleMesh M>
[[nodiscard]] Raster<T> rasterize(const M& mesh, const Camera<T>& camera) {
  Raster<T> raster = empty_raster(camera);
  RasterWorkspace work;
  detail::draw_moved(detail::RasterTarget<T>(raster), mesh, Pose(), camera, &work);
  return raster;
}

/// The same of a moved mesh; refuses a pose that is not finite, too. `rasterize_into` draws
/// several, and keeps its memory.
template <std::floating_point T, TriangleMesh M>
[[nodiscard]] Raster<T> rasterize(const M& mesh, const Pose& pose, const Camera<T>& camera) {
  Raster<T> raster = empty_raster(camera);
  RasterWorkspace work;
  rasterize_into(raster, mesh, pose, camera, &work);
  return raster;
}

}  // namespace gelight

#if defined(GELIGHT_COMPILED)
namespace gelight {
GELIGHT_ONCE template std::size_t detail::draw_batch<float>(const detail::RasterTarget<float>&,
                                                            Index, Index, const detail::FaceBatch&,
                                                            const detail::FaceMeasures&,
                                                            std::size_t, detail::HeldFaces*,
                                                            detail::WaitingFaces&, bool);
GELIGHT_ONCE template std::size_t detail::draw_batch<double>(const detail::RasterTarget<double>&,
                                                             Index, Index, const detail::FaceBatch&,
                                                             const detail::FaceMeasures&,
                                                             std::size_t, detail::HeldFaces*,
                                                             detail::WaitingFaces&, bool);
GELIGHT_ONCE template Raster<float> rasterize<float, Mesh<float>>(const Mesh<float>&,
                                                                  const Camera<float>&);
GELIGHT_ONCE template Raster<float> rasterize<float, MeshView<float>>(const MeshView<float>&,
                                                                      const Camera<float>&);
GELIGHT_ONCE template void rasterize_into<float, Mesh<float>>(ImageView<float>, const Mesh<float>&,
                                                              const Pose&, const Camera<float>&,
                                                              RasterWorkspace*);
GELIGHT_ONCE template Raster<double> rasterize<double, Mesh<double>>(const Mesh<double>&,
                                                                     const Camera<double>&);
GELIGHT_ONCE template Raster<double> rasterize<double, MeshView<double>>(const MeshView<double>&,
                                                                         const Camera<double>&);
GELIGHT_ONCE template void rasterize_into<double, Mesh<double>>(ImageView<double>,
                                                                const Mesh<double>&, const Pose&,
                                                                const Camera<double>&,
                                                                RasterWorkspace*);
}  // namespace gelight
#endif
