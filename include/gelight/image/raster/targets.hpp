#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gelight/core/types.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

template <std::floating_point T>
struct Raster;

namespace detail {

/// What triangles are drawn into: depths, and the faces that are seen there if those are wanted; or
/// nothing, to see whether all can be drawn.
template <class T>
struct DepthTarget {
  ImageView<T> depth;

  struct Row {
    T* depth;
    [[nodiscard]] bool is_nearer(Index x, T z, Index) const {
      if (!(z < depth[x])) return false;
      depth[x] = z;
      return true;
    }
    void show(Index, Index, const auto&) const {}
  };
  [[nodiscard]] T* place(Index x, Index y) const { return depth.row(y) + x; }
  [[nodiscard]] Row row(Index y) const { return {depth.row(y)}; }
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>&) { return true; }
  /// The nearest face is seen, whichever is drawn first.
  [[nodiscard]] static bool order_is_free() { return true; }
};
template <class T>
struct FaceTarget {
  Raster<T>& raster;
  /// Of each pixel, the last call that drew there; null: faces are drawn in their order.
  std::uint8_t* calls = nullptr;
  std::uint8_t call = 0;  // this one

  struct Row {
    T* depth;
    Index* face;
    std::array<T, 3>* barycentric;
    std::uint8_t* calls;
    std::uint8_t call;

    /// Of faces at the same depth the first in the mesh is seen, however they are ordered.
    [[nodiscard]] bool is_nearer(std::ptrdiff_t x, T z, Index f) const {
      if (!(z < depth[x])) {
        if (!(z == depth[x] && calls != nullptr && calls[x] == call && f < face[x])) return false;
      }
      depth[x] = z;
      return true;
    }
    void show(std::ptrdiff_t x, Index f, const auto& shares) const {
      face[x] = f;
      barycentric[x] = shares();
      if (calls != nullptr) calls[x] = call;
    }
  };
  [[nodiscard]] std::ptrdiff_t place(Index x, Index y) const {
    return std::ptrdiff_t{y} * raster.face.width() + x;
  }
  [[nodiscard]] Row row(Index y) const {
    std::uint8_t* const of_row = calls == nullptr ? nullptr : calls + place(0, y);
    return {raster.depth.row(y), raster.face.row(y), raster.barycentric.row(y), of_row, call};
  }
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>&) { return true; }
  [[nodiscard]] bool order_is_free() const { return calls != nullptr; }
};
template <class T>
struct NoTarget {
  struct Row {
    [[nodiscard]] bool is_nearer(Index, T, Index) const { return false; }
    void show(Index, Index, const auto&) const {}
  };
  [[nodiscard]] Row row(Index) const { return {}; }
  /// All depths of a face lie between those of its corners.
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>& corners) {
    const auto& [a, b, c] = corners;
    return !(is_drawn<T>(a.z) && is_drawn<T>(b.z) && is_drawn<T>(c.z));
  }
};

}  // namespace detail

}  // namespace gelight
