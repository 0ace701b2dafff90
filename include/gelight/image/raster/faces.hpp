#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/raster/held_faces.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/triangle.hpp"

namespace gelight::detail {

/// A face of a mesh by its number there, with the points at its corners. Trivial.
struct SeenFace {
  std::array<Index, 3> corners;
  Index number;
};

/// Some faces of a mesh.
struct FaceBatch {
  static constexpr std::size_t size = PositionBatch::size / 3;
  const ImagePoint* points = nullptr;
  std::array<SeenFace, size> faces;
  std::size_t count = 0;
  bool are_usual = false;  // all points are near the image, at usual depths

  /// Whether the corners of a face are near the image.
  [[nodiscard]] bool is_near(std::size_t i) const {
    const auto is = [&](std::size_t k) { return points[faces[i].corners[k]].inverse_z > 0; };
    return is(0) && is(1) && is(2);
  }
  /// Whether they are so at usual depths.
  [[nodiscard]] bool is_usual(std::size_t i) const {
    const auto is = [&](std::size_t k) {
      const double inverse_z = points[faces[i].corners[k]].inverse_z;
      return inverse_z > least_usual && inverse_z < most_usual;
    };
    return is(0) && is(1) && is(2);
  }
};

#if defined(__GNUC__)
/// To the next whole number up or down, of numbers in reach of an Index.
///@{
template <Index lanes>
[[gnu::always_inline]] inline void round_up(Lanes<double, lanes>& x) {
  const auto whole = __builtin_convertvector(x, Lanes<Index, lanes>);
  const auto back = __builtin_convertvector(whole, Lanes<double, lanes>);
  x = back < x ? back + 1 : back;
}
template <Index lanes>
[[gnu::always_inline]] inline void round_down(Lanes<double, lanes>& x) {
  const auto whole = __builtin_convertvector(x, Lanes<Index, lanes>);
  const auto back = __builtin_convertvector(whole, Lanes<double, lanes>);
  x = back > x ? back - 1 : back;
}
///@}

/// As `first_pixel` and `last_pixel`, of several numbers.
///@{
template <Index lanes>
[[gnu::always_inline]] inline void find_first(Lanes<double, lanes>& x, double pixels) {
  const Lanes<double, lanes> none{}, end = none + pixels, from_0 = x < none ? none : x;
  x = end < from_0 ? end : from_0;
  round_up<lanes>(x);
}
template <Index lanes>
[[gnu::always_inline]] inline void find_last(Lanes<double, lanes>& x, double pixels) {
  const Lanes<double, lanes> before = Lanes<double, lanes>{} - 1, last = before + pixels;
  const Lanes<double, lanes> from = x < before ? before : x;
  x = last < from ? last : from;
  round_down<lanes>(x);
}
///@}

/// What is known of several triangles, a lane each, by the numbers of their corners. (No function
/// returns lanes alone: compilers warn that how depends on the processor.)
template <Index lanes>
struct TriangleLanes {
  using Doubles = Lanes<double, lanes>;
  std::array<Doubles, 3> x, y, z;

  /// The box and its area; the depths of the corners; and the area as that of an ImageTriangle.
  Doubles left, right, top, bottom, box_area, least, most, area;

  void measure() {
    const Range across = range(x), down = range(y), depth = range(z);
    left = across.least, right = across.most, top = down.least, bottom = down.most;
    least = depth.least, most = depth.most;
    box_area = (right - left) * (bottom - top);
    const Doubles none{};
    const Doubles rough = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    const Doubles absolute = rough < none ? -rough : rough;
    area = absolute > box_area / 16 ? rough : none;
  }

 private:
  struct Range {
    Doubles least, most;
  };
  [[nodiscard]] static Range range(const std::array<Doubles, 3>& of) {
    const auto& [a, b, c] = of;
    const Doubles lesser = b < a ? b : a, greater = a < b ? b : a;
    return {c < lesser ? c : lesser, greater < c ? c : greater};
  }
};

/// The corners of some faces, a row a number.
template <std::size_t size>
class CornerRows {
 public:
  void gather(const ImagePoint* points, const SeenFace* faces, std::size_t count) {
    const std::size_t end = (count + 7) / 8 * 8;  // of as many lanes as there may be
    for (std::size_t i = 0; i < end; i += 4) gather_four(points, faces, count - 1, i);
  }

  /// Of some faces from one on.
  template <Index lanes>
  void load_points(TriangleLanes<lanes>& into, std::size_t i) const {
    for (std::size_t k = 0; k < 3; ++k) {
      load(into.x[k], &x_[k][i]), load(into.y[k], &y_[k][i]), load(into.z[k], &z_[k][i]);
    }
  }
  template <Index lanes>
  void load_inverse_z(std::array<Lanes<double, lanes>, 3>& into, std::size_t i) const {
    for (std::size_t k = 0; k < 3; ++k) load(into[k], &inverse_z_[k][i]);
  }

 private:
  using Rows = std::array<std::array<double, size>, 3>;

  /// Of four faces; behind the last face, of the last again.
  void gather_four(const ImagePoint* points, const SeenFace* faces, std::size_t last,
                   std::size_t i) {
    const std::array four{&faces[std::min(i, last)], &faces[std::min(i + 1, last)],
                          &faces[std::min(i + 2, last)], &faces[std::min(i + 3, last)]};
    for (std::size_t k = 0; k < 3; ++k) {
      Four<double> a, b, c, d;
      load(a, &points[four[0]->corners[k]]), load(b, &points[four[1]->corners[k]]);
      load(c, &points[four[2]->corners[k]]), load(d, &points[four[3]->corners[k]]);
      transpose(a, b, c, d);
      store(a, &x_[k][i]), store(b, &y_[k][i]), store(c, &z_[k][i]), store(d, &inverse_z_[k][i]);
    }
  }

  Rows x_, y_, z_, inverse_z_;
};

/// How the faces of a batch are drawn, and where, a row a number.
class FaceMeasures {
 public:
  static constexpr std::size_t size = FaceBatch::size;
  static_assert(size % 8 == 0);
  template <class T>
  using Row = std::array<T, size>;

  /// Small faces: rows and columns of the box, a number for both; or one of the others.
  static constexpr Index most_across = PixelBox::most_narrow,
                         small_kinds = most_across * most_across;
  /// Those that cover no pixel, may be held back, are large; and those to be drawn pixel by pixel,
  /// since they are thin, not near the image, or at unusual depths.
  static constexpr Index nothing = small_kinds, back = nothing + 1, large = back + 1,
                         exact = large + 1;
  Row<Index> kind;
  /// Of those that may be held back.
  Row<float> least;         // depth, or nearer
  Row<Index> across, down;  // from which tile to which

  void find(const FaceBatch& batch, Index width, Index height, bool holds_back) {
    if (!works_in_lanes()) return;
    vectorised_in_lanes([this, &batch, width, height, holds_back](auto lanes) {
      corners_.gather(batch.points, batch.faces.data(), batch.count);
      for (std::size_t i = 0; i < batch.count; i += lanes()) {
        measure<lanes()>(i, double(width), double(height), holds_back);
      }
      leave_unusual(batch);
    });
  }

 private:
  template <Index lanes>
  void measure(std::size_t i, double width, double height, bool holds_back) {
    using Doubles = Lanes<double, lanes>;
    using Whole = Lanes<Index, lanes>;
    TriangleLanes<lanes> of;
    corners_.load_points(of, i);
    of.measure();
    find_first<lanes>(of.left, width), find_last<lanes>(of.right, width);
    find_first<lanes>(of.top, height), find_last<lanes>(of.bottom, height);
    // No conditions that are joined: GCC computes those number by number.
    const Doubles none{}, columns = of.right - of.left, rows = of.bottom - of.top;
    const Doubles lesser = rows < columns ? rows : columns,
                  greater = columns < rows ? rows : columns;
    const Doubles small = rows * double(most_across) + columns;
    Doubles is = greater < none + most_across ? small : none + large;
    if (holds_back) is = none < of.area ? none + back : is;
    is = lesser < none ? none + nothing : is;
    is = of.area == none ? none + exact : is;
    store(__builtin_convertvector(is, Whole), &kind[i]);
    if (!holds_back) return;
    Whole from_x = __builtin_convertvector(of.left, Whole),
          from_y = __builtin_convertvector(of.top, Whole);
    HeldFaces::pack_tiles(from_x, __builtin_convertvector(of.right, Whole));
    HeldFaces::pack_tiles(from_y, __builtin_convertvector(of.bottom, Whole));
    store(from_x, &across[i]);
    store(from_y, &down[i]);
    store(__builtin_convertvector(of.least * HeldFaces::nearer, Lanes<float, lanes>), &least[i]);
  }

  void leave_unusual(const FaceBatch& batch) {
    if (batch.are_usual) return;
    for (std::size_t i = 0; i < batch.count; ++i) {
      if (!batch.is_usual(i)) kind[i] = exact;
    }
  }

  CornerRows<size> corners_;
};
#else
struct FaceMeasures {
  void find(const FaceBatch&, Index, Index, bool) {}
};
#endif

}  // namespace gelight::detail
