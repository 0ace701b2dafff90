#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "gelight/core/types.hpp"
#include "gelight/image/raster/faces.hpp"
#include "gelight/image/raster/lane_pixels.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/targets.hpp"
#include "gelight/image/raster/triangle.hpp"

#if defined(__GNUC__)
namespace gelight::detail {

/// Small faces that wait for each other to be drawn together.
class SmallFaces {
 public:
  static constexpr std::size_t size = 32;

  [[nodiscard]] bool is_empty() const { return count_ == 0; }
  [[nodiscard]] bool is_full() const { return count_ == size; }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const SeenFace* data() const { return faces_.data(); }

  /// As many as any of their boxes has, or more. (Bits that are joined are no less than the
  /// largest.)
  [[nodiscard]] Index columns() const { return kinds_ % FaceMeasures::most_across + 1; }
  [[nodiscard]] Index rows() const { return kinds_ / FaceMeasures::most_across + 1; }

  void add(const SeenFace& face, Index kind) {
    faces_[count_++] = face;
    kinds_ |= kind;
  }
  void clear() { count_ = 0, kinds_ = 0; }

 private:
  std::size_t count_ = 0;
  Index kinds_ = 0;
  std::array<SeenFace, size> faces_;
};

/// Those with boxes of the same columns and rows together, which may be drawn in any order; or all
/// together in theirs.
class WaitingFaces {
 public:
  explicit WaitingFaces(bool keep_order) : keep_order_(keep_order) {}

  [[nodiscard]] bool keep_order() const { return keep_order_; }
  [[nodiscard]] SmallFaces& of(Index kind) {
    return kinds_[static_cast<std::size_t>(keep_order_ ? 0 : kind)];
  }

 private:
  bool keep_order_;
  std::array<SmallFaces, FaceMeasures::small_kinds> kinds_;
};

/// Draws small faces, a face a lane, pixel after pixel of their boxes.
template <class T, Index lanes>
class SmallFaceDrawing {
 public:
  SmallFaceDrawing(const RasterTarget<T>& target, Index width, Index height)
      : target_(target), width_(width), height_(height) {}

  /// Calls `exactly(face)`, in their order, for those with pixels about which rounding leaves a
  /// doubt. The others get the bits that ImageTriangle gives them.
  template <class Exactly>
  void draw(const ImagePoint* points, const SmallFaces& small, const Exactly& exactly) {
    const Index columns = small.columns(), rows = small.rows();
    const SeenFace* const faces = small.data();
    corners_.gather(points, faces, small.count());
    for (std::size_t i = 0; i < small.count(); i += lanes) {
      const std::size_t some = std::min(small.count() - i, std::size_t{lanes});
      std::uint64_t doubtful = cover(i, columns, rows) & ((std::uint64_t{1} << some) - 1);
      std::size_t next = 0;
      for (; doubtful != 0; doubtful &= doubtful - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(doubtful));
        show(&faces[i], next, k, columns * rows);
        exactly(faces[i + k]);
        next = k + 1;
      }
      show(&faces[i], next, some, columns * rows);
    }
  }

 private:
  using Doubles = Lanes<double, lanes>;
  using Whole = Lanes<std::int64_t, lanes>;
  static constexpr std::size_t most = std::size_t{lanes} * FaceMeasures::small_kinds;

  /// A side by where it begins, and from there to the first column, times dy.
  struct Side {
    Doubles y, dx, dy, across;
  };

  /// Computes what the pixels of faces from one on show; which faces have doubtful ones.
  [[nodiscard]] std::uint64_t cover(std::size_t i, Index columns, Index rows) {
    TriangleLanes<lanes> of;
    corners_.load_points(of, i);
    std::array<Doubles, 3> inverse_z;
    corners_.template load_inverse_z<lanes>(inverse_z, i);
    of.measure();
    Cover<lanes> cover(doubtful_share * of.box_area, of.least, of.most, inverse_z);
    const Doubles none{};
    find_first<lanes>(of.left, static_cast<double>(width_));
    find_first<lanes>(of.top, static_cast<double>(height_));
    // Not beyond the image, where a box has fewer columns or rows than others.
    const Doubles last_left = none + double(width_ - columns),
                  last_top = none + double(height_ - rows);
    const Doubles left = last_left < of.left ? last_left : of.left,
                  top = last_top < of.top ? last_top : of.top, before = of.left - left;
    place(left, top, rows);
    const Side p = side(of, 1, 2), q = side(of, 2, 0), r = side(of, 0, 1);
    Whole pixels{};
    std::uint64_t bit = 1;
    std::size_t n = 0;
    for (Index row = 0; row < rows; ++row) {
      const Doubles y = top + static_cast<double>(row);
      const Doubles start_p = p.dx * (y - p.y) - p.across, start_q = q.dx * (y - q.y) - q.across,
                    start_r = r.dx * (y - r.y) - r.across;
      for (Index column = 0; column < columns; ++column) {
        const Doubles steps = static_cast<double>(column) - before;
        const Areas<lanes> areas{start_p - steps * p.dy, start_q - steps * q.dy,
                                 start_r - steps * r.dy};
        const auto covered = cover.at(areas);
        pixels |= covered.is & static_cast<std::int64_t>(bit);
        store(__builtin_convertvector(covered.depth, Lanes<T, lanes>), &depth_[n * lanes]);
        if (target_.wants_faces()) shares_.template keep<lanes>(n * lanes, covered.shares);
        offsets_[n] = row * target_.row_bytes() + column * static_cast<std::ptrdiff_t>(sizeof(T));
        bit *= 2;
        ++n;
      }
    }
    store(pixels, &covered_);
    return cover.doubts();
  }

  static Side side(const TriangleLanes<lanes>& of, std::size_t from, std::size_t to) {
    const Doubles none{}, dx = of.x[to] - of.x[from], dy = of.y[to] - of.y[from];
    const Doubles inside_dx = of.area < none ? -dx : dx, inside_dy = of.area < none ? -dy : dy;
    return {of.y[from], inside_dx, inside_dy, inside_dy * (of.left - of.x[from])};
  }

  /// Where boxes begin. Their pixels come from memory while it is told which are covered.
  void place(const Doubles& left, const Doubles& top, Index rows) {
    using Numbers = Lanes<Index, lanes>;
    const auto x = __builtin_convertvector(left, Numbers),
               y = __builtin_convertvector(top, Numbers);
    for (std::size_t k = 0; k < lanes; ++k) {
      first_[k] = target_.depth(x[k], y[k]);
      for (Index row = 0; row < rows; ++row) {
        target_.prefetch_pixel(target_.depth(x[k], y[k] + row));
      }
    }
  }

  /// Shows the pixels of some of the faces in the lanes that are covered, and nearer than what is
  /// there. Those of several faces in one loop, for how many a face has is hard to foretell.
  void show(const SeenFace* faces, std::size_t from, std::size_t to, Index pixels) {
    const int shift = pixels <= 16 ? 4 : pixels <= 32 ? 5 : 6;
    const std::size_t faces_each = 64U >> shift;
    for (std::size_t first = from; first < to; first += faces_each) {
      std::uint64_t bits = 0;
      const std::size_t end = std::min(to, first + faces_each);
      for (std::size_t k = first; k < end; ++k) bits |= covered_[k] << ((k - first) << shift);
      for (; bits != 0; bits &= bits - 1) {
        const auto at = static_cast<std::size_t>(std::countr_zero(bits));
        const std::size_t k = first + (at >> shift), n = at & ((std::size_t{1} << shift) - 1);
        T* const pixel =
            reinterpret_cast<T*>(reinterpret_cast<std::byte*>(first_[k]) + offsets_[n]);
        if (!target_.draw_depth(pixel, 0, depth_[n * lanes + k], faces[k].number)) continue;
        target_.show(target_.place(pixel), faces[k].number, shares_.of(n * lanes + k));
      }
    }
  }

  const RasterTarget<T>& target_;
  Index width_, height_;
  CornerRows<SmallFaces::size> corners_;
  std::array<T*, lanes> first_;               // the first pixel of each box
  std::array<std::uint64_t, lanes> covered_;  // a bit for each pixel of the box
  std::array<std::ptrdiff_t, FaceMeasures::small_kinds> offsets_;
  alignas(64) std::array<T, most> depth_;  // of a pixel in all lanes, after the other
  ShareRows<T, most> shares_;
};

}  // namespace gelight::detail
#endif
