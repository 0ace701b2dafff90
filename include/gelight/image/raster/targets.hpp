#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gelight/core/prefetch.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

template <std::floating_point T>
struct Raster;

namespace detail {

/// What triangles are drawn into: depths, and the faces that are seen there if those are wanted.
/// One type for both, for the loops that draw are long and compiled for several processors.
template <class T>
class RasterTarget {
 public:
  explicit RasterTarget(const ImageView<T>& depth) : depth_(depth) {}
  explicit RasterTarget(Raster<T>& raster)
      : depth_(ImageView<T>(raster.depth.data(), raster.depth.width(), raster.depth.height())),
        face_(raster.face.data()),
        barycentric_(raster.barycentric.data()) {}

  /// Has pixels remember the last call that drew there; else faces are drawn in their order.
  void remember_call(std::uint8_t* calls, std::uint8_t call) { calls_ = calls, call_ = call; }

  [[nodiscard]] bool wants_faces() const { return face_ != nullptr; }
  /// Whether the same is seen whichever face is drawn first.
  [[nodiscard]] bool order_is_free() const { return face_ == nullptr || calls_ != nullptr; }
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>&) { return true; }

  [[nodiscard]] T* depth(Index x, Index y) const { return depth_.row(y) + x; }
  [[nodiscard]] std::ptrdiff_t row_bytes() const { return depth_.row_bytes(); }
  /// Which pixel that is, in the images of faces and of places in them: all are packed alike.
  [[nodiscard]] std::ptrdiff_t place(const T* depth) const { return depth - depth_.data(); }

  /// Draws the depth of a face if it is nearer than what is there; whether the face is to be shown.
  [[nodiscard]] bool draw_depth(T* row, Index x, T z, Index f) const {
    if (!(z < row[x] || (z == row[x] && settles_ties() && is_first(place(row + x), f))))
      return false;
    row[x] = z;
    return wants_faces();
  }
  void show(std::ptrdiff_t at, Index f, const std::array<T, 3>& shares) const {
    face_[at] = f;
    barycentric_[at] = shares;
    if (calls_ != nullptr) calls_[at] = call_;
  }

  /// Of faces at the same depth the first in the mesh is seen, however they are ordered: whether
  /// that is still to be told, and whether a face comes before the one that is seen.
  ///@{
  [[nodiscard]] bool settles_ties() const { return calls_ != nullptr; }
  [[nodiscard]] bool is_first(std::ptrdiff_t at, Index f) const {
    return calls_[at] == call_ && f < face_[at];
  }
  ///@}

  void prefetch_pixel(const T* depth) const {
    prefetch(depth, 1);
    if (wants_faces()) prefetch_faces(place(depth));
  }
  void prefetch_faces(std::ptrdiff_t at) const {
    prefetch(barycentric_ + at, 1);
    prefetch(face_ + at, 1);
  }

 private:
  ImageView<T> depth_;
  Index* face_ = nullptr;
  std::array<T, 3>* barycentric_ = nullptr;
  std::uint8_t* calls_ = nullptr;  // of each pixel, the last call that drew there
  std::uint8_t call_ = 0;          // this one
};

/// Nothing, to see whether all can be drawn.
template <class T>
struct NoTarget {
  [[nodiscard]] static T* depth(Index, Index) { return nullptr; }
  [[nodiscard]] static bool draw_depth(const T*, Index, T, Index) { return false; }
  [[nodiscard]] static std::ptrdiff_t place(const T*) { return 0; }
  static void show(std::ptrdiff_t, Index, const std::array<T, 3>&) {}
  /// All depths of a face lie between those of its corners.
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>& corners) {
    const auto& [a, b, c] = corners;
    return !(is_drawn<T>(a.z) && is_drawn<T>(b.z) && is_drawn<T>(c.z));
  }
};

}  // namespace detail

}  // namespace gelight
