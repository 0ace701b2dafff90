#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/triangle.hpp"

namespace gelight::detail {

/// Some faces of a mesh.
struct FaceBatch {
  static constexpr std::size_t size = PositionBatch::size / 3;
  const ImagePoint* points = nullptr;
  std::array<std::array<Index, 3>, size> corners;  // which of the points
  std::array<Index, size> faces;                   // in the mesh
  std::size_t count = 0;
  bool are_usual = false;  // all points are near the image, at usual depths

  /// Whether the corners of a face are near the image.
  [[nodiscard]] bool is_near(std::size_t i) const {
    const auto is = [&](std::size_t k) { return points[corners[i][k]].inverse_z > 0; };
    return is(0) && is(1) && is(2);
  }
  /// Whether they are so at usual depths.
  [[nodiscard]] bool is_usual(std::size_t i) const {
    const auto is = [&](std::size_t k) {
      const double inverse_z = points[corners[i][k]].inverse_z;
      return inverse_z > least_usual && inverse_z < most_usual;
    };
    return is(0) && is(1) && is(2);
  }
};

#if defined(__GNUC__)
/// What is known of the faces of a batch before they are drawn, a row a number. Those that are not
/// near the image, are at unusual depths or thin are left to others.
class FaceMeasures {
 public:
  static constexpr std::size_t size = FaceBatch::size;
  template <class T>
  using Row = std::array<T, size>;

  /// The sides opposite to the corners, as those of an ImageTriangle; and from where a side begins
  /// to the first pixel of the box, times dy.
  struct Sides {
    Row<double> x, y, dx, dy, across;
  };
  std::array<Sides, 3> sides;
  /// Of the corners.
  std::array<Row<double>, 3> inverse_z;
  /// Twice the areas, but for rounding, positive where the corners go round with the clock; zero:
  /// the face is left to others.
  Row<double> areas;
  Row<double> doubtful;                 // areas up to this
  Row<double> least, most;              // depths
  Row<Index> left, right, top, bottom;  // pixels in the box

  [[nodiscard]] PixelBox box(std::size_t i) const { return {left[i], right[i], top[i], bottom[i]}; }

  void find(const FaceBatch& batch, Index width, Index height, bool holds_back) {
    if (!works_in_lanes()) return;
    vectorised_in_lanes([this, &batch, width, height, holds_back](auto lanes) {
      for (std::size_t i = 0; i < batch.count; i += 4) gather_four(batch, i);
      for (std::size_t i = 0; i < batch.count; i += lanes()) {
        find_boxes<lanes()>(i, double(width), double(height));
        if (holds_back && are_back<lanes()>(i)) continue;
        find_side<lanes()>(i, sides[0], sides[1]);
        find_side<lanes()>(i, sides[1], sides[2]);
        find_side<lanes()>(i, sides[2], sides[0]);
      }
      leave_unusual(batch);
    });
  }

 private:
  /// The corners of four faces; behind the last face, of the last again.
  void gather_four(const FaceBatch& batch, std::size_t i) {
    const std::size_t end = batch.count - 1;
    const std::array faces{&batch.corners[i], &batch.corners[std::min(i + 1, end)],
                           &batch.corners[std::min(i + 2, end)],
                           &batch.corners[std::min(i + 3, end)]};
    gather_corner<0>(batch.points, faces, i, sides[2]);
    gather_corner<1>(batch.points, faces, i, sides[0]);
    gather_corner<2>(batch.points, faces, i, sides[1]);
  }

  template <std::size_t k, class Faces>
  void gather_corner(const ImagePoint* points, const Faces& faces, std::size_t i, Sides& begun) {
    Four<double> a, b, c, d;
    load(a, &points[(*faces[0])[k]]), load(b, &points[(*faces[1])[k]]);
    load(c, &points[(*faces[2])[k]]), load(d, &points[(*faces[3])[k]]);
    transpose(a, b, c, d);
    store(begun.x, i, a), store(begun.y, i, b);
    store(z_[k], i, c), store(inverse_z[k], i, d);
  }

  /// Whether all of some faces are held back or left to others, so that nobody asks for their
  /// sides.
  template <Index lanes>
  [[nodiscard]] bool are_back(std::size_t i) const {
    return std::all_of(&areas[i], &areas[i] + lanes, [](double area) { return area >= 0; });
  }

  void leave_unusual(const FaceBatch& batch) {
    if (batch.are_usual) return;
    for (std::size_t i = 0; i < batch.count; ++i) {
      if (!batch.is_usual(i)) areas[i] = 0;
    }
  }

  /// Of some faces from one on.
  template <Index lanes>
  void find_boxes(std::size_t i, double columns, double rows) {
    using Doubles = Lanes<double, lanes>;
    Doubles ax, ay, az, bx, by, bz, cx, cy, cz;
    load(ax, &sides[2].x[i]), load(ay, &sides[2].y[i]), load(az, &z_[0][i]);
    load(bx, &sides[0].x[i]), load(by, &sides[0].y[i]), load(bz, &z_[1][i]);
    load(cx, &sides[1].x[i]), load(cy, &sides[1].y[i]), load(cz, &z_[2][i]);
    const Doubles z0_ab = bz < az ? bz : az, z0 = cz < z0_ab ? cz : z0_ab;
    const Doubles z1_ab = az < bz ? bz : az, z1 = z1_ab < cz ? cz : z1_ab;
    const Doubles x0_ab = bx < ax ? bx : ax, x0 = cx < x0_ab ? cx : x0_ab;
    const Doubles x1_ab = ax < bx ? bx : ax, x1 = x1_ab < cx ? cx : x1_ab;
    const Doubles y0_ab = by < ay ? by : ay, y0 = cy < y0_ab ? cy : y0_ab;
    const Doubles y1_ab = ay < by ? by : ay, y1 = y1_ab < cy ? cy : y1_ab;
    const Doubles none{}, box = (x1 - x0) * (y1 - y0);
    const Doubles area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    const Doubles absolute = area < none ? -area : area;
    store(least, i, z0);
    store(most, i, z1);
    store(areas, i, absolute > box / 16 ? area : none);
    store(doubtful, i, doubtful_share * box);
    store_first<lanes>(left, i, x0, columns);
    store_first<lanes>(top, i, y0, rows);
    store_last<lanes>(right, i, x1, columns);
    store_last<lanes>(bottom, i, y1, rows);
  }

  template <Index lanes>
  void find_side(std::size_t i, Sides& from, const Sides& to) const {
    using Doubles = Lanes<double, lanes>;
    Doubles x, y, to_x, to_y, area;
    load(x, &from.x[i]), load(y, &from.y[i]), load(to_x, &to.x[i]), load(to_y, &to.y[i]);
    load(area, &areas[i]);
    Lanes<Index, lanes> first;
    load(first, &left[i]);
    const Doubles none{}, dx = to_x - x, dy = to_y - y;
    const Doubles inside_dx = area < none ? -dx : dx, inside_dy = area < none ? -dy : dy;
    store(from.dx, i, inside_dx);
    store(from.dy, i, inside_dy);
    store(from.across, i, inside_dy * (__builtin_convertvector(first, Doubles) - x));
  }

  /// As `first_pixel` and `last_pixel`.
  ///@{
  template <Index lanes>
  static void store_first(Row<Index>& into, std::size_t i, const Lanes<double, lanes>& x,
                          double pixels) {
    using Doubles = Lanes<double, lanes>;
    const Doubles none{}, end = none + pixels;
    const Doubles from_0 = x < none ? none : x, in_reach = end < from_0 ? end : from_0;
    const auto whole = __builtin_convertvector(in_reach, Lanes<Index, lanes>);
    const Doubles back = __builtin_convertvector(whole, Doubles);
    store(into, i, __builtin_convertvector(back < in_reach ? back + 1 : back, Lanes<Index, lanes>));
  }
  template <Index lanes>
  static void store_last(Row<Index>& into, std::size_t i, const Lanes<double, lanes>& x,
                         double pixels) {
    using Doubles = Lanes<double, lanes>;
    const Doubles before = Doubles{} - 1, last = before + pixels;
    const Doubles from = x < before ? before : x, in_reach = last < from ? last : from;
    const auto whole = __builtin_convertvector(in_reach, Lanes<Index, lanes>);
    const Doubles back = __builtin_convertvector(whole, Doubles);
    store(into, i, __builtin_convertvector(back > in_reach ? back - 1 : back, Lanes<Index, lanes>));
  }
  ///@}

  template <class T, class Numbers>
  static void store(Row<T>& into, std::size_t i, const Numbers& numbers) {
    std::memcpy(&into[i], &numbers, sizeof numbers);
  }

  std::array<Row<double>, 3> z_;
};
#else
struct FaceMeasures {
  void find(const FaceBatch&, Index, Index, bool) {}
};
#endif

}  // namespace gelight::detail
