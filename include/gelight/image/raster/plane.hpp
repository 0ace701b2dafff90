#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/pose.hpp"
#include "gelight/image/raster/lanes.hpp"

namespace gelight::detail {

/// a b - c d to two units in the last place, so that its sign is always right, whether or not the
/// compiler fuses multiplications with additions (Kahan's algorithm; Jeannerod, Louvet and Muller
/// 2013, doi:10.1090/S0025-5718-2013-02679-8).
[[nodiscard]] inline double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

/// Keeps a sum as it was rounded where -fassociative-math (of -ffast-math) lets compilers take it
/// for what it would be without rounding. By reference, as registers of lanes have no ABI of their
/// own everywhere.
template <class Number>
[[gnu::always_inline]] inline void keep_rounded([[maybe_unused]] Number& sum) {
#if defined(__has_builtin)
#if __has_builtin(__builtin_assoc_barrier)
  sum = __builtin_assoc_barrier(sum);
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
  // GCC 12 loses the barriers of two numbers that it joins to lanes by itself.
  if constexpr (std::is_floating_point_v<Number>) asm("" : "+m"(sum));
#endif
#elif __has_builtin(__arithmetic_fence) && defined(__x86_64__)
  sum = __arithmetic_fence(sum);
#endif
#endif
}

/// Within these products and quotients of two focal lengths, coordinates or depths are numbers.
inline constexpr double least_drawn = 1e-150, most_drawn = 1e150;

/// A centre farther off leaves less than ten binary digits of a pixel to the places in the image.
inline constexpr double farthest_centre = 0x1p42;

/// Depths between these are held by any type, and so are their inverses.
inline constexpr double least_usual = 1e-30, most_usual = 1e30;

/// A point as it appears in the image. On the grid of its ImagePlane, so that differences of
/// coordinates have no rounding, and faces that share a vertex see it at the same place. Trivial,
/// so that room for many is not touched.
struct ImagePoint {
  double x, y;       // in pixels
  double z;          // its depth
  double inverse_z;  // 0: it is not near the image, and faces at it have to be cut first
};

/// Positions of some points, a row a coordinate.
struct PositionBatch {
  static constexpr std::size_t size = 360;
  std::array<double, size> x, y, z;
  std::size_t count = 0;

  void add(const Vec3<double>& p) {
    x[count] = p.coeff(0), y[count] = p.coeff(1), z[count] = p.coeff(2);
    ++count;
  }
  /// Behind the last point comes that again, up to a multiple of four.
  void fill_up() {
    for (std::size_t i = count; i % 4 != 0; ++i) x[i] = x[i - 1], y[i] = y[i - 1], z[i] = z[i - 1];
  }
};

/// A number for each side or corner of a triangle.
using Three = std::array<double, 3>;

/// A corner of a face that was cut.
struct CutCorner {
  Three point;  // column and row times z, and z
  ImagePoint seen;
  Three shares;  // its barycentric coordinates in the whole face
};

/// The corners of a face that was cut, without memory from the heap. Each of four cuts makes no
/// more than two corners of one.
class CutPolygon {
 public:
  void push_back(const CutCorner& corner) { corners_[size_++] = corner; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const CutCorner* data() const { return corners_.data(); }
  [[nodiscard]] CutCorner* begin() { return corners_.data(); }
  [[nodiscard]] CutCorner* end() { return corners_.data() + size_; }

 private:
  std::array<CutCorner, 13> corners_;
  std::size_t size_ = 0;
};

/// The plane of the image with what surrounds it up to three times the image's size. It carries a
/// grid of 2^-50 of that size, on which coordinates are exact.
///
/// A point behind the camera, or far beside the image, has no place on it. Faces at such a point
/// are cut by four planes through the camera. (No plane in front of it: what is inside all four
/// is.) All that faces share is computed in one way only, free of what a compiler may fuse.
class ImagePlane {
 public:
  explicit ImagePlane(const Camera<double>& camera) : camera_(camera) {
    for (const double f : {camera.fx, camera.fy}) {
      require(f >= least_drawn && f <= most_drawn, "the focal length ", f, " is not between ",
              least_drawn, " and ", most_drawn);
    }
    require(std::abs(camera.cx) <= farthest_centre && std::abs(camera.cy) <= farthest_centre,
            "the camera's centre (", camera.cx, ", ", camera.cy, ") is more than ", farthest_centre,
            " pixels off");
    while (size_ < std::max(camera.width, camera.height)) size_ *= 2;
  }

  /// Where moved points are seen, several at a time; whether all are near the image, at depths far
  /// within what any type holds.
  bool project(ImagePoint* out, PositionBatch& points, const Pose& pose = {}) const {
#if defined(__GNUC__)
    if (works_in_lanes()) {
      points.fill_up();
      return vectorised_by_four([this, out, &points, &pose] {
        Four<std::int64_t> others{};
        const std::size_t whole = points.count / 4 * 4;
        std::array<ImagePoint, 4> last;
        for (std::size_t i = 0; i < points.count; i += 4) {
          Four<double> x, y, z, inverse_z;
          load(x, &points.x[i]), load(y, &points.y[i]), load(z, &points.z[i]);
          project(pose, x, y, z, inverse_z);
          others |= (inverse_z <= least_usual) | (inverse_z >= most_usual);
          transpose(x, y, z, inverse_z);
          ImagePoint* const into = i < whole ? out + i : last.data();
          store(x, into), store(y, into + 1), store(z, into + 2), store(inverse_z, into + 3);
        }
        std::copy(last.data(), last.data() + points.count % 4, out + whole);
        return (others[0] | others[1] | others[2] | others[3]) == 0;
      });
    }
#endif
    bool are_usual = true;
    for (std::size_t i = 0; i < points.count; ++i) {
      ImagePoint& seen = out[i];
      seen = {points.x[i], points.y[i], points.z[i], 0};
      project(pose, seen.x, seen.y, seen.z, seen.inverse_z);
      are_usual &= seen.inverse_z > least_usual && seen.inverse_z < most_usual;
    }
    return are_usual;
  }

  /// Whether a face has nothing in front of the camera, or nothing in the image for lying beside
  /// it.
  [[nodiscard]] bool misses_image(const std::array<ImagePoint, 3>& corners) const {
    const auto& [a, b, c] = corners;
    if (a.z <= 0 && b.z <= 0 && c.z <= 0) return true;
    if (!(a.z > 0 && b.z > 0 && c.z > 0)) return false;
    const double right = camera_.width - 1, bottom = camera_.height - 1;
    return (a.x < 0 && b.x < 0 && c.x < 0) || (a.y < 0 && b.y < 0 && c.y < 0) ||
           (a.x > right && b.x > right && c.x > right) ||
           (a.y > bottom && b.y > bottom && c.y > bottom);
  }

  /// The part of a face that has a place on the plane: a convex polygon, perhaps of no corners.
  [[nodiscard]] CutPolygon cut(const std::array<Vec3<double>, 3>& positions,
                               const std::array<ImagePoint, 3>& seen) const {
    CutPolygon polygon;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double>& p = positions[k];
      const CutCorner corner{{std::fma(camera_.fx, p[0], camera_.cx * p[2]),
                              std::fma(camera_.fy, p[1], camera_.cy * p[2]), p[2]},
                             seen[k],
                             {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0}};
      polygon.push_back(corner);
    }
    for (const std::size_t axis : {0U, 1U}) {
      for (const double side : {-1, 1}) polygon = cut(polygon, axis, side * far_ * size_);
    }
    for (CutCorner& corner : polygon) {
      // But for rounding such a face goes through the camera, and is seen edge-on.
      if (!(corner.seen.z > 0)) return {};
      // At a depth without an inverse, it is to be refused rather than left out.
      corner.seen.inverse_z = std::min(1 / corner.seen.z, std::numeric_limits<double>::max());
      if (!is_within(2 * size_, corner.seen)) return {};
    }
    return polygon;
  }

 private:
  // In sizes of the image, a power of two: vertices are near within the first, faces are cut at the
  // second, and the grid is exact within 2.
  static constexpr double near_ = 1.5, far_ = 1.75;

  /// Makes the coordinates of a point those where it is seen, or of several points, in lanes.
  /// Without branches, and without a quotient by zero.
  template <class Number>
  [[gnu::always_inline]] inline void project(const Pose& pose, Number& x, Number& y, Number& z,
                                             Number& inverse_z) const {
    const Number none{}, by_one = none + 1, reach = none + near_ * size_, grid = none + 6 * size_;
    const auto [moved_x, moved_y, moved_z] = pose.moved(x, y, z);
    const auto is_before = moved_z > none;
    const Number by = is_before ? moved_z : by_one, inverse = by_one / by;
    Number column = camera_.fx * moved_x / by + camera_.cx;
    Number row = camera_.fy * moved_y / by + camera_.cy;
    put_on_grid(column, grid);
    put_on_grid(row, grid);
    const auto is_near = is_before & (column <= reach) & (-column <= reach) & (row <= reach) &
                         (-row <= reach) & (inverse <= std::numeric_limits<double>::max());
    x = is_before ? column : none;
    y = is_before ? row : none;
    z = moved_z;
    inverse_z = is_near ? inverse : none;
  }

  [[nodiscard]] static bool is_within(double reach, const ImagePoint& p) {
    return std::abs(p.x) <= reach && std::abs(p.y) <= reach &&
           p.inverse_z <= std::numeric_limits<double>::max();
  }

  /// The nearest point of the grid: the sum has just as many digits as the grid.
  template <class Number>
  [[gnu::always_inline]] static inline void put_on_grid(Number& x, const Number& grid) {
    x = x + grid;
    keep_rounded(x);
    x = x - grid;
  }
  [[nodiscard]] double on_grid(double x) const {
    put_on_grid(x, 6 * size_);
    return x;
  }

  /// The part of a polygon on this side of a column or row. Its sides are cut from their end nearer
  /// to that, whose digits those of a far one would drown (of two as near from that inside), so
  /// that both faces at a side find the same point.
  [[nodiscard]] CutPolygon cut(const CutPolygon& polygon, std::size_t axis, double at) const {
    const double sign = at < 0 ? 1 : -1;
    const auto distance = [&](const CutCorner& corner) {
      return std::fma(std::abs(at), corner.point[2], sign * corner.point[axis]);
    };
    CutPolygon inside;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const CutCorner& a = polygon.data()[k];
      const CutCorner& b = polygon.data()[(k + 1) % polygon.size()];
      const double from_a = distance(a), from_b = distance(b);
      if (from_a > 0) inside.push_back(a);
      if ((from_a > 0) == (from_b > 0)) continue;
      const double to_a = std::abs(from_a), to_b = std::abs(from_b);
      const bool a_is_nearer = to_a < to_b || (to_a == to_b && from_a > 0);
      CutCorner corner = a_is_nearer ? between(a, b, from_a / (from_a - from_b))
                                     : between(b, a, from_b / (from_b - from_a));
      // Exactly: what is left of a face as large as can be would be lost in its rounding.
      corner.point[axis] = at * corner.point[2];
      const double z = corner.point[2], by = z != 0 ? z : 1;  // (no quotient by zero)
      corner.seen = {on_grid(corner.point[0] / by), on_grid(corner.point[1] / by), z, 0};
      inside.push_back(corner);
    }
    return inside;
  }

  [[nodiscard]] static CutCorner between(const CutCorner& a, const CutCorner& b, double t) {
    CutCorner corner;
    for (std::size_t i = 0; i < 3; ++i) {
      corner.point[i] = std::fma(t, b.point[i] - a.point[i], a.point[i]);
      corner.shares[i] = std::max(a.shares[i] + t * (b.shares[i] - a.shares[i]), 0.0);
    }
    return corner;
  }

  Camera<double> camera_;
  double size_ = 1;  // of the image: a power of two
};

/// T, or double where T is longer: what is drawn is computed in double.
template <class T>
using AtMostDouble = std::conditional_t<(sizeof(T) > sizeof(double)), double, T>;

/// Whether T holds a depth, and double what is computed with it.
template <class T>
[[nodiscard]] bool is_drawn(double z) {
  using Limits = std::numeric_limits<AtMostDouble<T>>;
  return z >= std::max(least_drawn, double{Limits::min()}) &&
         z <= std::min(most_drawn, double{Limits::max()});
}
template <class T>
void require_drawn(double z, Index face) {
  require(is_drawn<T>(z), "face ", face, " is seen at depth ", z,
          ", which is out of the range of depths");
}

}  // namespace gelight::detail
