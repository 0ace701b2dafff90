#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/raster/targets.hpp"
#include "gelight/image/raster/triangle.hpp"

namespace gelight::detail {

/// Faces that look away from the camera, and so are behind others if the mesh is closed: they are
/// drawn after all the others, but for those that are farther off than all that is seen around
/// them.
class HeldFaces {
 public:
  /// Room for the faces of a mesh, and a target of some size; whether faces can be held back.
  [[nodiscard]] bool begin(Index faces, Index width, Index height) {
    count_ = 0;
    if (!works_in_lanes()) return false;
    columns_ = (width + tile - 1) / tile;
    if (std::min(width, height) < tile || std::max(width, height) > most_pixels) return false;
    grow(held_, faces);
    const Index tiles = columns_ * ((height + tile - 1) / tile);
    grow(farthest_, tiles);
    grow(farthest_around_, tiles);
    return true;
  }

  /// From which tile to which that is, of lanes of numbers, packed.
  template <class Numbers>
  [[gnu::always_inline]] static inline void pack_tiles(Numbers& first, const Numbers& last) {
    // (There are none below 0, where a shift would be no division.)
    first = (first >> tile_bits) + ((last >> tile_bits) << 16);
  }
  /// What makes a depth one that is not farther off, whatever float makes of it.
  static constexpr double nearer = 1 - 0x1p-22;

  void add(Index face, float least, Index across, Index down) {
    held_[count_] = {face, least, across, down};
    ++count_;
  }

  [[nodiscard]] Index count() const { return static_cast<Index>(count_); }
  [[nodiscard]] Index face(Index i) const { return held_[static_cast<std::size_t>(i)].face; }

  /// Keeps those of which something may be seen in the target, or be at just the depth of what is.
  template <class T>
  void drop_hidden(const RasterTarget<T>& target, Index width, Index height) {
    if (count_ == 0) return;
    vectorised_by_four([this, &target, width, height] {
      find_farthest(target, width, height);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        const Held held = held_[i];
        held_[kept] = held;
        kept += is_hidden(held) ? 0 : 1;
      }
      count_ = kept;
    });
  }

 private:
  static constexpr Index tile_bits = 2, tile = 1 << tile_bits;  // pixels, both ways
  static constexpr Index last_tile = (1 << 15) - 1, most_pixels = tile << 15;

  /// Trivial, so that room for many is not touched.
  struct Held {
    Index face;
    float least;
    Index across, down;

    [[nodiscard]] Index left() const { return across & last_tile; }
    [[nodiscard]] Index right() const { return across >> 16; }
    [[nodiscard]] Index top() const { return down & last_tile; }
    [[nodiscard]] Index bottom() const { return down >> 16; }
  };

  template <class Element>
  static void grow(Array<Element>& elements, Index count) {
    const auto n = static_cast<std::size_t>(count);
    if (elements.size() < n) elements.resize_unwritten(n);
  }
  /// The largest depth in each tile around the faces. A tile at the end of a row or column begins
  /// where it is whole.
  template <class T>
  void find_farthest(const RasterTarget<T>& target, Index width, Index height) {
    Index left = columns_, right = 0, top = height, bottom = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      left = std::min(left, held_[i].left());
      right = std::max(right, held_[i].right());
      top = std::min(top, held_[i].top());
      bottom = std::max(bottom, held_[i].bottom());
    }
    for (Index y = top; y <= bottom; ++y) {
      for (Index x = left; x <= right; ++x) {
        farthest_[place(x, y)] = farthest_in(target, std::min(tile * x, width - tile),
                                             std::min(tile * y, height - tile));
      }
    }
    for (Index y = top; y <= bottom; ++y) {
      for (Index x = left; x <= right; ++x) {
        const Index across = std::min(x + 1, right), down = std::min(y + 1, bottom);
        farthest_around_[place(x, y)] =
            greater(greater(farthest_[place(x, y)], farthest_[place(across, y)]),
                    greater(farthest_[place(x, down)], farthest_[place(across, down)]));
      }
    }
  }

  template <class T>
  [[nodiscard]] static double farthest_in(const RasterTarget<T>& target, Index x, Index y) {
    // In front of a depth that is not a number, nothing is drawn.
    std::array<T, tile> most{};
    for (Index v = 0; v < tile; ++v) {
      const T* const row = target.depth(x, y + v);
      for (std::size_t k = 0; k < tile; ++k) most[k] = row[k] > most[k] ? row[k] : most[k];
    }
    T all{};
    for (const T one : most) all = std::max(all, one);
    return static_cast<double>(all);
  }

  [[nodiscard]] std::size_t place(Index x, Index y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  }

  [[nodiscard]] bool is_hidden(const Held& held) const {
    const Index left = held.left(), right = held.right(), top = held.top(), bottom = held.bottom();
    const double least = double{held.least};
    // Most faces are as small.
    if (right - left < 2 && bottom - top < 2) return least > farthest_around_[place(left, top)];
    const double at_corners =
        greater(greater(farthest_[place(left, top)], farthest_[place(right, top)]),
                greater(farthest_[place(left, bottom)], farthest_[place(right, bottom)]));
    if (!(least > at_corners)) return false;
    for (Index y = top; y <= bottom; ++y) {
      for (Index x = left + 1; x < right; ++x) {
        if (!(least > farthest_[place(x, y)])) return false;
      }
    }
    for (Index y = top + 1; y < bottom; ++y) {
      if (!(least > greater(farthest_[place(left, y)], farthest_[place(right, y)]))) return false;
    }
    return true;
  }

  Array<Held> held_;
  std::size_t count_ = 0;
  Array<double> farthest_;         // depth in a tile
  Array<double> farthest_around_;  // in it, and in those to the right and below
  Index columns_ = 0;
};

}  // namespace gelight::detail
