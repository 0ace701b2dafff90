#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/image/raster/plane.hpp"

namespace gelight::detail {

/// As std::min and std::max, but by value: so they are vectorised.
///@{
[[nodiscard]] constexpr double lesser(double a, double b) { return b < a ? b : a; }
[[nodiscard]] constexpr double greater(double a, double b) { return a < b ? b : a; }
///@}

/// The first pixel of a row or column that is not before x, and the last that is not beyond it. The
/// x in reach of an image is clamped to what may differ.
///@{
[[nodiscard]] inline Index first_from(double in_reach) {
  const auto i = static_cast<Index>(in_reach);
  return i + (i < in_reach);
}
[[nodiscard]] inline Index last_to(double in_reach) {
  const auto i = static_cast<Index>(in_reach);
  return i - (i > in_reach);
}
[[nodiscard]] inline Index first_pixel(double x, Index size) {
  return first_from(lesser(greater(x, 0), size));
}
[[nodiscard]] inline Index last_pixel(double x, Index size) {
  return last_to(lesser(greater(x, -1), size - 1));
}

/// Areas up to this share of the box of a triangle may have the wrong sign; those of a thin one, if
/// the sign is right, few digits that are.
inline constexpr double doubtful_share = 0x1p-50;

/// The pixels whose centres lie in the box of a triangle.
struct PixelBox {
  /// Boxes of no more columns are looked at as a whole.
  static constexpr Index most_narrow = 8;

  Index first_column = 0, last_column = 0, first_row = 0, last_row = 0;
  [[nodiscard]] bool is_empty() const {
    return (first_column > last_column) | (first_row > last_row);
  }
  [[nodiscard]] bool is_wide() const { return last_column - first_column >= most_narrow; }
};

/// Draws a triangle of the image: a face, or a part of one. Which pixel centres lie in it or on its
/// sides is told without rounding, so that triangles that share corners leave none between them;
/// one without area has none.
class ImageTriangle {
 public:
  /// A line through two corners, of which the inside is where dx down - dy across is positive.
  struct Side {
    double x, y, dx, dy, slope;
  };
  [[nodiscard]] static Side side(double sign, const ImagePoint& p, const ImagePoint& q) {
    return {p.x, p.y, sign * (q.x - p.x), sign * (q.y - p.y), 0};
  }

  ImageTriangle(const ImagePoint& a, const ImagePoint& b, const ImagePoint& c)
      : a_(a),
        b_(b),
        c_(c),
        left_(lesser(lesser(a.x, b.x), c.x)),
        right_(greater(greater(a.x, b.x), c.x)),
        top_(lesser(lesser(a.y, b.y), c.y)),
        bottom_(greater(greater(a.y, b.y), c.y)),
        least_(lesser(lesser(a.z, b.z), c.z)),
        most_(greater(greater(a.z, b.z), c.z)) {}

  [[nodiscard]] PixelBox box(Index width, Index height) const {
    return {first_pixel(left_, width), last_pixel(right_, width), first_pixel(top_, height),
            last_pixel(bottom_, height)};
  }

  /// Twice the area, but for rounding, positive where the corners go round with the clock; zero for
  /// a thin triangle, for which that may have the wrong sign.
  [[nodiscard]] double rough_area() const {
    const double area = (b_.x - a_.x) * (c_.y - a_.y) - (b_.y - a_.y) * (c_.x - a_.x);
    return std::abs(area) > box_area() / 16 ? area : 0;
  }

  /// How far beside its sides a row is looked at: rounding is far less.
  static constexpr double more_reach = 0x1p-10;

  /// Each corner's barycentric coordinates in the face; null: the corners are those of the face.
  using Shares = std::array<Three, 3>;

  template <template <class> class Target, class T>
  void draw(const Target<T>& target, Index width, Index height, Index face, const Shares* shares) {
    const PixelBox pixels = box(width, height);
    if (pixels.is_empty() || !find_sides()) return;
    const bool may_leave_range = !(is_drawn<T>(least_) && is_drawn<T>(most_));
    const auto [first_column, last_column, first_row, last_row] = pixels;
    const bool is_wide = pixels.is_wide();
    if (is_wide) find_slopes();
    for (Index v = first_row; v <= last_row; ++v) {
      // The part of the row that can be covered, where that is less work than to look at all.
      const auto [first, last] =
          is_wide ? reach(v, pixels, width) : std::array{first_column, last_column};
      draw_row(target, face, shares, may_leave_range, v, first, last);
    }
  }

  /// The areas that the centre of a pixel spans with the sides.
  [[nodiscard]] Three areas_at(Index u, Index v) const {
    const auto area = [&](const Side& s) { return s.dx * (v - s.y) - s.dy * (u - s.x); };
    return {area(sides_[0]), area(sides_[1]), area(sides_[2])};
  }

  /// Of a triangle with an area whose sign is known.
  void set_sides(double area) {
    const double sign = area < 0 ? -1 : 1;
    sides_ = {side(sign, b_, c_), side(sign, c_, a_), side(sign, a_, b_)};
    doubtful_ = doubtful_share * box_area();
  }
  void find_slopes() {
    for (Side& side : sides_) side.slope = side.dy != 0 ? side.dx / side.dy : 0;
  }
  [[nodiscard]] const std::array<Side, 3>& sides() const { return sides_; }
  [[nodiscard]] double doubtful() const { return doubtful_; }
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double most() const { return most_; }

 private:
  [[nodiscard]] double box_area() const { return (right_ - left_) * (bottom_ - top_); }

  /// Whether the triangle has an inside.
  [[nodiscard]] bool find_sides() {
    double area = rough_area();
    const bool is_thin = area == 0;
    if (is_thin) area = difference_of_products(b_.x - a_.x, c_.y - a_.y, b_.y - a_.y, c_.x - a_.x);
    set_sides(area);
    if (is_thin) doubtful_ = std::numeric_limits<double>::infinity();
    return area != 0;
  }

  /// The first and the last pixel of a row that can be covered.
  [[nodiscard]] std::array<Index, 2> reach(Index v, const PixelBox& pixels, Index width) const {
    const auto [from, to] = span(v);
    return {std::max(pixels.first_column, first_pixel(from, width)),
            std::min(pixels.last_column, last_pixel(to, width))};
  }

  /// Between which columns a row can be covered.
  [[nodiscard]] std::array<double, 2> span(Index v) const {
    double from = left_, to = right_;
    for (const Side& side : sides_) {
      const double x = side.x + (v - side.y) * side.slope;
      from = side.dy < 0 ? greater(from, x - more_reach) : from;
      to = side.dy > 0 ? lesser(to, x + more_reach) : to;
    }
    return {from, to};
  }

  template <template <class> class Target, class T>
  void draw_row(const Target<T>& target, Index face, const Shares* shares, bool may_leave_range,
                Index v, Index first, Index last) const {
    T* const row = target.depth(0, v);
    const double outside = doubtful_share * box_area();
    const Three start = areas_at(first, v);
    for (Index u = first; u <= last; ++u) {
      const double steps = u - first;
      const auto area = [&](std::size_t k) { return start[k] + steps * -sides_[k].dy; };
      Three areas{area(0), area(1), area(2)};
      const double smallest = lesser(lesser(areas[0], areas[1]), areas[2]);
      if (smallest < -outside) continue;
      if (!(smallest > doubtful_) && !settle(u, v, areas)) continue;
      // Linear in the image are 1 / z, and the barycentric coordinates divided by z.
      Three parts{areas[0] * a_.inverse_z, areas[1] * b_.inverse_z, areas[2] * c_.inverse_z};
      const double inverse = 1 / (parts[0] + parts[1] + parts[2]);
      const double depth = (areas[0] + areas[1] + areas[2]) * inverse;
      const double exact = lesser(greater(depth, least_), most_);
      if (may_leave_range) require_drawn<T>(exact, face);
      if (!target.draw_depth(row, u, static_cast<T>(exact), face)) continue;
      if (shares) parts = in_whole(*shares, parts);
      target.show(target.place(row + u), face,
                  {static_cast<T>(parts[0] * inverse), static_cast<T>(parts[1] * inverse),
                   static_cast<T>(parts[2] * inverse)});
    }
  }

  [[nodiscard]] static Three in_whole(const Shares& shares, const Three& parts) {
    const auto part = [&](std::size_t k) {
      return shares[0][k] * parts[0] + shares[1][k] * parts[1] + shares[2][k] * parts[2];
    };
    return {part(0), part(1), part(2)};
  }

  /// Replaces areas that rounding may have spoilt; whether none is negative.
  [[nodiscard]] bool settle(Index u, Index v, Three& areas) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Side& side = sides_[k];
      if (!(std::abs(areas[k]) > doubtful_)) {
        areas[k] = difference_of_products(side.dx, v - side.y, side.dy, u - side.x);
      }
      if (areas[k] < 0) return false;
    }
    return true;
  }

  const ImagePoint &a_, &b_, &c_;
  double left_, right_, top_, bottom_;
  double least_, most_;  // depth of the corners
  double doubtful_ = 0;  // areas up to this are not good enough: none of a thin triangle is
  std::array<Side, 3> sides_;
};

/// Draws a triangle pixel by pixel. Apart from what is compiled for loops over several.
template <class Target>
[[gnu::noinline]] void draw_exactly(const Target& target, Index width, Index height, Index face,
                                    const ImagePoint& a, const ImagePoint& b, const ImagePoint& c,
                                    const ImageTriangle::Shares* shares = nullptr) {
  ImageTriangle(a, b, c).draw(target, width, height, face, shares);
}

}  // namespace gelight::detail
