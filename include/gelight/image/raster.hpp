#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// Where a rigid body is: a point p of it is seen at rotation p + translation, in the camera's
/// frame. An `Eigen::Isometry3d` or another of Eigen's transforms converts to it.
struct Pose {
  /// Or any other linear map, such as one with a size, which is then drawn as it is: nothing checks
  /// that it keeps lengths.
  Eigen::Matrix3d rotation{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3<double> translation{0, 0, 0};  ///< in the unit of the mesh

  Pose() = default;
  /// Of the two.
  Pose(const Eigen::Matrix3d& turned, const Vec3<double>& moved)
      : rotation(turned), translation(moved) {}
  /// Of what has a linear part and a translation.
  template <class Transform>
  requires requires(const Transform& t) {
    t.linear();
    t.translation();
  }
  Pose(const Transform& transform)
      : rotation(transform.linear().template cast<double>()),
        translation(transform.translation().template cast<double>()) {}

  /// Where a point of the body is.
  [[nodiscard]] Vec3<double> operator()(const Vec3<double>& p) const {
    const auto [x, y, z] = moved(p[0], p[1], p[2]);
    return {x, y, z};
  }
  /// The same of its coordinates.
  [[nodiscard]] std::array<double, 3> moved(double x, double y, double z) const {
    // Spelled out, with sums in Eigen's order: its product takes long to compile.
    const Eigen::Matrix3d& r = rotation;
    return {r(0, 0) * x + r(0, 1) * y + r(0, 2) * z + translation[0],
            r(1, 0) * x + r(1, 1) * y + r(1, 2) * z + translation[1],
            r(2, 0) * x + (r(2, 1) * y + r(2, 2) * z) + translation[2]};
  }
};

/// What the camera sees of a mesh, per pixel.
template <std::floating_point T>
struct Raster {
  Image<T> depth;                       ///< z, in the unit of the positions; +infinity: nothing
  Image<Index> face;                    ///< -1 where there is nothing
  Image<std::array<T, 3>> barycentric;  ///< of the pixel's point in its face
};

namespace detail {

/// a b - c d to two units in the last place, so that its sign is always right, whether or not the
/// compiler fuses multiplications with additions (Kahan's algorithm; Jeannerod, Louvet and Muller
/// 2013, doi:10.1090/S0025-5718-2013-02679-8).
[[nodiscard]] inline double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

/// Within these products and quotients of two focal lengths, coordinates or depths are numbers.
inline constexpr double least_drawn = 1e-150, most_drawn = 1e150;

/// A centre farther off leaves less than ten binary digits of a pixel to the places in the image.
inline constexpr double farthest_centre = 0x1p42;

/// Depths between these are held by any type, and so are their inverses.
inline constexpr double least_usual = 1e-30, most_usual = 1e30;

/// A point as it appears in the image. On the grid of its ImagePlane, so that differences of
/// coordinates have no rounding, and faces that share a vertex see it at the same place.
struct ImagePoint {
  double x = 0, y = 0;   // in pixels
  double z = 0;          // its depth
  double inverse_z = 0;  // 0: it is not near the image, and faces at it have to be cut first
};

/// Positions of some points, a row a coordinate.
struct PositionBatch {
  static constexpr std::size_t size = 360;
  std::array<double, size> x, y, z;
  std::size_t count = 0;

  void add(const Vec3<double>& p) {
    x[count] = p[0], y[count] = p[1], z[count] = p[2];
    ++count;
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
  bool project(ImagePoint* out, const PositionBatch& points, const Pose& pose = {}) const {
    return vectorised([out, &points, pose, plane = *this] {
      Index others = 0;
      for (std::size_t i = 0; i < points.count; ++i) {
        const auto [x, y, z] = pose.moved(points.x[i], points.y[i], points.z[i]);
        const ImagePoint seen = plane.project(x, y, z);
        out[i] = seen;
        others |= 1 - (Index{seen.inverse_z > least_usual} & Index{seen.inverse_z < most_usual});
      }
      return others == 0;
    });
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
      // At a depth without an inverse, it is to be refused rather than left out.
      corner.seen.inverse_z = std::min(1 / corner.seen.z, std::numeric_limits<double>::max());
      // But for rounding such a face goes through the camera, and is seen edge-on.
      if (!(corner.seen.z > 0) || !is_within(2 * size_, corner.seen)) return {};
    }
    return polygon;
  }

 private:
  // In sizes of the image, a power of two: vertices are near within the first, faces are cut at the
  // second, and the grid is exact within 2.
  static constexpr double near_ = 1.5, far_ = 1.75;

  /// Without branches, and without a quotient by zero.
  [[nodiscard]] ImagePoint project(double x, double y, double z) const {
    const bool is_before = z > 0;
    const double by = is_before ? z : 1;
    const ImagePoint seen{on_grid(camera_.fx * x / by + camera_.cx),
                          on_grid(camera_.fy * y / by + camera_.cy), z, 1 / by};
    const bool is_near = is_before & is_within(near_ * size_, seen);
    return {is_before ? seen.x : 0, is_before ? seen.y : 0, z, is_near ? seen.inverse_z : 0};
  }

  [[nodiscard]] static bool is_within(double reach, const ImagePoint& p) {
    const Index in_columns = std::abs(p.x) <= reach ? 1 : 0;
    const Index in_rows = std::abs(p.y) <= reach ? 1 : 0;
    const Index has_depth = p.inverse_z <= std::numeric_limits<double>::max() ? 1 : 0;
    return (in_columns & in_rows & has_depth) != 0;
  }

  /// The nearest point of the grid: the sum has just as many digits as the grid.
  [[nodiscard]] double on_grid(double x) const { return (x + 6 * size_) - 6 * size_; }

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
      corner.seen = {on_grid(corner.point[0] / corner.point[2]),
                     on_grid(corner.point[1] / corner.point[2]), corner.point[2], 0};
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
///@}

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

/// A number for each of four pixels that lie side by side, with what C++ does with one number done
/// with each. GCC and Clang have such types for all processors; elsewhere pixels are drawn one by
/// one.
#if defined(__GNUC__)
inline constexpr Index pixels_at_once = 4;
template <class T>
struct FourType {
  using type [[gnu::vector_size(pixels_at_once * sizeof(T))]] = T;
};
template <class T>
using Four = typename FourType<T>::type;
using FourDoubles = Four<double>;

/// Four numbers that lie one after the other.
template <class T, class Source>
[[gnu::always_inline]] inline void load(T& into, const Source* from) {
  std::memcpy(&into, from, sizeof into);
}

/// A bit for each of four pixels that are covered.
[[nodiscard]] inline std::uint64_t bits_of(const Four<std::int64_t>& is_covered) {
  const Four<std::int64_t> bits = is_covered & Four<std::int64_t>{1, 2, 4, 8};
  return static_cast<std::uint64_t>((bits[0] | bits[2]) | (bits[1] | bits[3]));
}

#endif

/// What triangles are drawn into: depths, and the faces that are seen there if those are wanted; or
/// nothing, to see whether all can be drawn.
template <class T>
struct DepthTarget {
  static constexpr bool wants_shares = false;
  ImageView<T> depth;

  struct Row {
    T* depth;
    [[nodiscard]] bool is_nearer(Index x, T z, Index) const {
      if (!(z < depth[x])) return false;
      depth[x] = z;
      return true;
    }
    void show(Index, Index, const auto&) const {}
#if defined(__GNUC__)
    /// Pixels from x on, at depths of which those that are not covered are infinite.
    void show_four(Index x, const FourDoubles& z) const {
      if constexpr (sizeof(T) > sizeof(double)) {  // of which there are no vectors
        for (Index k = 0; k < pixels_at_once; ++k) (void)is_nearer(x + k, T{z[k]}, 0);
      } else {
        Four<T> was;
        load(was, depth + x);
        const Four<T> is = __builtin_convertvector(z, Four<T>);
        const Four<T> now = is < was ? is : was;
        std::memcpy(depth + x, &now, sizeof now);
      }
    }
#endif
  };
  [[nodiscard]] Row row(Index y) const { return {depth.row(y)}; }
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>&) { return true; }
};
template <class T>
struct FaceTarget {
  static constexpr bool wants_shares = true;
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

/// Areas up to this share of the box of a triangle may have the wrong sign; those of a thin one, if
/// the sign is right, few digits that are.
inline constexpr double doubtful_share = 0x1p-50;

#if defined(__GNUC__)
/// Pixels of one face, that are shown when there are several rows of them: how many there are in
/// one is hard to foretell.
class CoveredPixels {
 public:
  [[nodiscard]] bool is_full() const { return count_ == most_; }

  /// Some of the four pixels of a row from one on, and the areas that they span with the sides.
  void add(std::ptrdiff_t first, std::uint64_t bits, const FourDoubles& a, const FourDoubles& b,
           const FourDoubles& c) {
    bits_ |= bits << (pixels_at_once * count_);
    first_[count_] = first;
    a_[count_] = a, b_[count_] = b, c_[count_] = c;
    ++count_;
  }

  template <class T>
  void show(const FaceTarget<T>& target, Index face, const Three& inverse_depths, double least,
            double most) {
    const auto row = target.row(0);  // and all others behind it
    for (; bits_ != 0; bits_ &= bits_ - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(bits_));
      const std::size_t n = bit / pixels_at_once, k = bit % pixels_at_once;
      const double a = a_[n][k], b = b_[n][k], c = c_[n][k];
      // Linear in the image are 1 / z, and the barycentric coordinates divided by z.
      const double part_a = a * inverse_depths[0], part_b = b * inverse_depths[1],
                   part_c = c * inverse_depths[2];
      const double sum = part_a + part_b + part_c;
      const FourDoubles quotients = FourDoubles{part_a, part_b, part_c, a + b + c} / sum;
      const double depth = lesser(greater(quotients[3], least), most);
      const std::ptrdiff_t at = first_[n] + static_cast<std::ptrdiff_t>(k);
      if (!row.is_nearer(at, static_cast<T>(depth), face)) continue;
      const auto shares = __builtin_convertvector(quotients, Four<AtMostDouble<T>>);
      row.show(at, face, [&]() -> std::array<T, 3> { return {shares[0], shares[1], shares[2]}; });
    }
    count_ = 0;
  }

 private:
  static constexpr std::size_t most_ = 64 / pixels_at_once;
  std::uint64_t bits_ = 0;
  std::size_t count_ = 0;
  std::array<std::ptrdiff_t, most_> first_;
  std::array<FourDoubles, most_> a_, b_, c_;
};
#endif

/// The pixels whose centres lie in the box of a triangle.
struct PixelBox {
  Index first_column = 0, last_column = 0, first_row = 0, last_row = 0;
  [[nodiscard]] bool is_empty() const {
    return (first_column > last_column) | (first_row > last_row);
  }
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

  /// Each corner's barycentric coordinates in the face; null: the corners are those of the face.
  using Shares = std::array<Three, 3>;

  template <template <class> class Target, class T>
  void draw(const Target<T>& target, Index width, Index height, Index face, const Shares* shares) {
    const PixelBox pixels = box(width, height);
    if (pixels.is_empty() || !find_sides()) return;
    const bool may_leave_range = !(is_drawn<T>(least_) && is_drawn<T>(most_));
    each_row(pixels, width, [&](Index v, Index first, Index last) {
      draw_row(target, face, shares, may_leave_range, v, first, last);
    });
  }

  /// Calls `work(v, first, last)` with the rows of pixels, and the part of each that can be covered
  /// where that is less work than to look at all.
  template <class Work>
  void each_row(const PixelBox& pixels, Index width, const Work& work) {
    const auto [first_column, last_column, first_row, last_row] = pixels;
    const bool is_wide = last_column - first_column > 3;
    if (is_wide) find_slopes();
    for (Index v = first_row; v <= last_row; ++v) {
      const auto [first, last] =
          is_wide ? reach(v, pixels, width) : std::array{first_column, last_column};
      if (first <= last) work(v, first, last);
    }
  }

  /// The areas that the centre of a pixel spans with the sides.
  [[nodiscard]] Three areas_at(Index u, Index v) const {
    const auto area = [&](const Side& s) { return s.dx * (v - s.y) - s.dy * (u - s.x); };
    return {area(sides_[0]), area(sides_[1]), area(sides_[2])};
  }

  /// Of a triangle with an area whose sign is known.
  void set_sides(double area, double doubtful) {
    doubtful_ = doubtful;
    const double sign = area < 0 ? -1 : 1;
    sides_ = {side(sign, b_, c_), side(sign, c_, a_), side(sign, a_, b_)};
  }

 private:
  [[nodiscard]] double box_area() const { return (right_ - left_) * (bottom_ - top_); }

  /// Whether the triangle has an inside.
  [[nodiscard]] bool find_sides() {
    double area = rough_area();
    const bool is_thin = area == 0;
    if (is_thin) area = difference_of_products(b_.x - a_.x, c_.y - a_.y, b_.y - a_.y, c_.x - a_.x);
    set_sides(area,
              is_thin ? std::numeric_limits<double>::infinity() : doubtful_share * box_area());
    return area != 0;
  }

  void find_slopes() {
    for (Side& side : sides_) side.slope = side.dy != 0 ? side.dx / side.dy : 0;
  }

  /// The first and the last pixel of a row that can be covered.
  [[nodiscard]] std::array<Index, 2> reach(Index v, const PixelBox& pixels, Index width) const {
    const auto [from, to] = span(v);
    return {std::max(pixels.first_column, first_pixel(from, width)),
            std::min(pixels.last_column, last_pixel(to, width))};
  }

  /// Between which columns a row can be covered; rounding is far less than what is added.
  [[nodiscard]] std::array<double, 2> span(Index v) const {
    constexpr double more = 0x1p-10;
    double from = left_, to = right_;
    for (const Side& side : sides_) {
      const double x = side.x + (v - side.y) * side.slope;
      from = side.dy < 0 ? greater(from, x - more) : from;
      to = side.dy > 0 ? lesser(to, x + more) : to;
    }
    return {from, to};
  }

  template <template <class> class Target, class T>
  void draw_row(const Target<T>& target, Index face, const Shares* shares, bool may_leave_range,
                Index v, Index first, Index last) const {
    const auto row = target.row(v);
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
      const double sum = parts[0] + parts[1] + parts[2];
      const double depth = (areas[0] + areas[1] + areas[2]) / sum;
      const double exact = lesser(greater(depth, least_), most_);
      if (may_leave_range) require_drawn<T>(exact, face);
      if (!row.is_nearer(u, static_cast<T>(exact), face)) continue;
      row.show(u, face, [&]() -> std::array<T, 3> {
        if (shares) parts = in_whole(*shares, parts);
        return {static_cast<T>(parts[0] / sum), static_cast<T>(parts[1] / sum),
                static_cast<T>(parts[2] / sum)};
      });
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

inline void require_vertex(Index face, Index vertex, Index vertices) {
  require(vertex >= 0 && vertex < vertices, "face ", face, " has vertex ", vertex,
          ", the mesh has ", vertices, " vertices");
}
inline void require_in_range(const Vec3<double>& position, Index vertex) {
  double farthest = 0;
  for (Index i = 0; i < 3; ++i) {
    require(std::isfinite(position[i]), "vertex ", vertex, " is not finite");
    farthest = std::max(farthest, std::abs(position[i]));
  }
  require(farthest <= most_drawn, "vertex ", vertex, " at (", position.x(), ", ", position.y(),
          ", ", position.z(), ") is farther off than ", most_drawn);
}

/// Draws what the target needs of a face, or of the part of it that has a place on the plane.
template <class Target>
void draw_face(const Target& target, const ImagePlane& plane, Index width, Index height, Index face,
               const std::array<ImagePoint, 3>& corners,
               const std::array<Vec3<double>, 3>& positions) {
  if (corners[0].inverse_z > 0 && corners[1].inverse_z > 0 && corners[2].inverse_z > 0) {
    if (target.needs(corners)) {
      draw_exactly(target, width, height, face, corners[0], corners[1], corners[2]);
    }
    return;
  }
  if (plane.misses_image(corners)) return;
  const auto polygon = plane.cut(positions, corners);
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const auto &a = polygon.data()[0], &b = polygon.data()[k - 1], &c = polygon.data()[k];
    const ImageTriangle::Shares shares{a.shares, b.shares, c.shares};
    const std::array seen{a.seen, b.seen, c.seen};
    if (target.needs(seen)) {
      draw_exactly(target, width, height, face, a.seen, b.seen, c.seen, &shares);
    }
  }
}

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
};

/// Faces that look away from the camera, and so are behind others if the mesh is closed: they are
/// drawn after all the others, but for those that are farther off than all that is seen around
/// them.
class HeldFaces {
 public:
  /// Room for the faces of a mesh, and a target of some size; whether faces can be held back.
  [[nodiscard]] bool begin(Index faces, Index width, Index height) {
    count_ = 0;
    columns_ = (width + tile - 1) / tile;
    if (std::min(width, height) < tile || std::max(width, height) > most_pixels) return false;
    grow(held_, faces);
    grow(farthest_, columns_ * ((height + tile - 1) / tile));
    return true;
  }

  void add(Index face, double least, const PixelBox& box) {
    // Rounded down, whatever float makes of it.
    held_[count_] = {face,
                     static_cast<float>(least * (1 - 0x1p-22)),
                     tile_of(box.first_column),
                     tile_of(box.last_column),
                     tile_of(box.first_row),
                     tile_of(box.last_row)};
    ++count_;
  }

  [[nodiscard]] Index count() const { return static_cast<Index>(count_); }
  [[nodiscard]] Index face(Index i) const { return held_[static_cast<std::size_t>(i)].face; }

  /// Keeps those of which something may be seen in the target, or be at just the depth of what is.
  template <class Target>
  void drop_hidden(const Target& target, Index width, Index height) {
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
  static constexpr Index tile = 4;  // pixels, both ways
  static constexpr Index most_pixels = tile << 16;

  struct Held {
    Index face = 0;
    float least = 0;
    std::uint16_t left = 0, right = 0, top = 0, bottom = 0;  // tiles
  };

  template <class Element>
  static void grow(Array<Element>& elements, Index count) {
    const auto n = static_cast<std::size_t>(count);
    if (elements.size() < n) elements.resize(n);
  }
  [[nodiscard]] static std::uint16_t tile_of(Index pixel) {
    return static_cast<std::uint16_t>(static_cast<std::uint32_t>(pixel) / tile);
  }

  /// The largest depth in each tile around the faces. A tile at the end of a row or column begins
  /// where it is whole.
  template <class Target>
  void find_farthest(const Target& target, Index width, Index height) {
    Index left = columns_, right = 0, top = height, bottom = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      left = std::min(left, Index{held_[i].left});
      right = std::max(right, Index{held_[i].right});
      top = std::min(top, Index{held_[i].top});
      bottom = std::max(bottom, Index{held_[i].bottom});
    }
    for (Index y = top; y <= bottom; ++y) {
      for (Index x = left; x <= right; ++x) {
        farthest_[place(x, y)] = farthest_in(target, std::min(tile * x, width - tile),
                                             std::min(tile * y, height - tile));
      }
    }
  }

  template <template <class> class Target, class T>
  [[nodiscard]] static double farthest_in(const Target<T>& target, Index x, Index y) {
    // In front of a depth that is not a number, nothing is drawn.
    std::array<T, tile> most{};
    for (Index v = 0; v < tile; ++v) {
      const T* const row = target.row(y + v).depth + x;
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
    const Index left = held.left, right = held.right, top = held.top, bottom = held.bottom;
    const double least = double{held.least};
    const double at_corners =
        greater(greater(farthest_[place(left, top)], farthest_[place(right, top)]),
                greater(farthest_[place(left, bottom)], farthest_[place(right, bottom)]));
    if (!(least > at_corners)) return false;
    if (right - left < 2 && bottom - top < 2) return true;
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
  Array<double> farthest_;
  Index columns_ = 0;
};

#if defined(__GNUC__)
/// What is known of the faces of a batch before they are drawn. Those that are not near the image,
/// are at unusual depths or thin are left to others.
class FaceMeasures {
 public:
  static constexpr std::size_t size = FaceBatch::size;
  /// Twice the areas, but for rounding, positive where the corners go round with the clock; zero:
  /// the face is left to others.
  alignas(FourDoubles) std::array<double, size> areas;
  alignas(FourDoubles) std::array<double, size> doubtful;                 // areas up to this
  alignas(FourDoubles) std::array<double, size> least, most;              // depths
  alignas(Four<Index>) std::array<Index, size> left, right, top, bottom;  // pixels in the box

  void find(const FaceBatch& batch, Index width, Index height) {
    vectorised_by_four([this, &batch, columns = double(width), rows = double(height)] {
      for (std::size_t i = 0; i < batch.count; i += std::size_t{pixels_at_once}) {
        find_four(batch, i, columns, rows);
      }
    });
  }

 private:
  /// The corners of a face, or of one without area in its place.
  [[nodiscard]] static std::array<const ImagePoint*, 3> corners(const FaceBatch& batch,
                                                                std::size_t i) {
    static constexpr ImagePoint nowhere;
    const auto& [a, b, c] = batch.corners[i];
    const ImagePoint* const p = batch.points;
    const auto is_usual = [&](Index v) {
      return p[v].inverse_z > least_usual && p[v].inverse_z < most_usual;
    };
    if (batch.are_usual || (is_usual(a) && is_usual(b) && is_usual(c))) {
      return {p + a, p + b, p + c};
    }
    return {&nowhere, &nowhere, &nowhere};
  }

  void find_four(const FaceBatch& batch, std::size_t i, double columns, double rows) {
    // Behind the last face, the last again.
    const std::size_t end = batch.count - 1;
    const auto [a0, b0, c0] = corners(batch, i);
    const auto [a1, b1, c1] = corners(batch, std::min(i + 1, end));
    const auto [a2, b2, c2] = corners(batch, std::min(i + 2, end));
    const auto [a3, b3, c3] = corners(batch, std::min(i + 3, end));
    const FourDoubles ax{a0->x, a1->x, a2->x, a3->x}, ay{a0->y, a1->y, a2->y, a3->y};
    const FourDoubles bx{b0->x, b1->x, b2->x, b3->x}, by{b0->y, b1->y, b2->y, b3->y};
    const FourDoubles cx{c0->x, c1->x, c2->x, c3->x}, cy{c0->y, c1->y, c2->y, c3->y};
    const FourDoubles az{a0->z, a1->z, a2->z, a3->z}, bz{b0->z, b1->z, b2->z, b3->z},
        cz{c0->z, c1->z, c2->z, c3->z};
    const FourDoubles z_ab = bz < az ? bz : az, z_abc = cz < z_ab ? cz : z_ab;
    const FourDoubles z_most_ab = az < bz ? bz : az, z_most = z_most_ab < cz ? cz : z_most_ab;
    const FourDoubles x_ab = bx < ax ? bx : ax, x0 = cx < x_ab ? cx : x_ab;
    const FourDoubles x1_ab = ax < bx ? bx : ax, x1 = x1_ab < cx ? cx : x1_ab;
    const FourDoubles y_ab = by < ay ? by : ay, y0 = cy < y_ab ? cy : y_ab;
    const FourDoubles y1_ab = ay < by ? by : ay, y1 = y1_ab < cy ? cy : y1_ab;
    const FourDoubles none{}, box = (x1 - x0) * (y1 - y0);
    const FourDoubles area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    const FourDoubles absolute = area < none ? -area : area;
    keep(least, i, z_abc);
    keep(most, i, z_most);
    keep(areas, i, absolute > box / 16 ? area : none);
    keep(doubtful, i, doubtful_share * box);
    keep_first(left, i, x0, columns);
    keep_first(top, i, y0, rows);
    keep_last(right, i, x1, columns);
    keep_last(bottom, i, y1, rows);
  }

  /// As `first_pixel` and `last_pixel`.
  ///@{
  static void keep_first(std::array<Index, size>& into, std::size_t i, const FourDoubles& x,
                         double pixels) {
    const FourDoubles none{}, end = none + pixels;
    const FourDoubles from_0 = x < none ? none : x, in_reach = end < from_0 ? end : from_0;
    const auto whole = __builtin_convertvector(in_reach, Four<Index>);
    const FourDoubles back = __builtin_convertvector(whole, FourDoubles);
    keep(into, i, back < in_reach ? back + 1 : back);
  }
  static void keep_last(std::array<Index, size>& into, std::size_t i, const FourDoubles& x,
                        double pixels) {
    const FourDoubles before{-1, -1, -1, -1}, last = before + pixels;
    const FourDoubles from = x < before ? before : x, in_reach = last < from ? last : from;
    const auto whole = __builtin_convertvector(in_reach, Four<Index>);
    const FourDoubles back = __builtin_convertvector(whole, FourDoubles);
    keep(into, i, back > in_reach ? back - 1 : back);
  }
  ///@}

  static void keep(std::array<double, size>& into, std::size_t i, const FourDoubles& numbers) {
    std::memcpy(&into[i], &numbers, sizeof numbers);
  }
  static void keep(std::array<Index, size>& into, std::size_t i, const FourDoubles& numbers) {
    const auto whole = __builtin_convertvector(numbers, Four<Index>);
    std::memcpy(&into[i], &whole, sizeof whole);
  }
};

/// Draws a face of a batch, several pixels at a time; whether that is all of it: pixels about which
/// rounding leaves a doubt are left out. The others get the bits that ImageTriangle gives them.
template <class Target>
[[nodiscard]] bool draw_sure(const Target& target, Index width, const FaceBatch& batch,
                             const FaceMeasures& measures, std::size_t i) {
  constexpr double in = std::numeric_limits<double>::infinity();
  constexpr FourDoubles none{}, inside{in, in, in, in}, outside{-in, -in, -in, -in};
  const Index face = batch.faces[i];
  const ImagePoint& corner_a = batch.points[batch.corners[i][0]];
  const ImagePoint& corner_b = batch.points[batch.corners[i][1]];
  const ImagePoint& corner_c = batch.points[batch.corners[i][2]];
  const double sign = measures.areas[i] < 0 ? -1 : 1, doubtful_area = measures.doubtful[i];
  const auto p = ImageTriangle::side(sign, corner_b, corner_c);
  const auto q = ImageTriangle::side(sign, corner_c, corner_a);
  const auto r = ImageTriangle::side(sign, corner_a, corner_b);
  const FourDoubles least = none + measures.least[i], most = none + measures.most[i];
  const FourDoubles doubtful = none + doubtful_area;
  const FourDoubles inverse_a = none + corner_a.inverse_z, inverse_b = none + corner_b.inverse_z,
                    inverse_c = none + corner_c.inverse_z;
  // The largest of what makes pixels doubtful: the smallest areas of those that are not drawn.
  FourDoubles doubts = outside;
  CoveredPixels pixels;
  const auto show_pixels = [&] {
    if constexpr (Target::wants_shares) {
      pixels.show(target, face, {corner_a.inverse_z, corner_b.inverse_z, corner_c.inverse_z},
                  measures.least[i], measures.most[i]);
    }
  };

  const auto draw_lanes = [&](Index x, Index v, const FourDoubles& a, const FourDoubles& b,
                              const FourDoubles& c, const FourDoubles& limit) {
    const FourDoubles a_or_b = b < a ? b : a, one = c < a_or_b ? c : a_or_b;
    const FourDoubles smallest = limit < one ? limit : one;
    const auto is_covered = smallest > doubtful;
    const FourDoubles doubt = is_covered ? outside : smallest;
    doubts = doubts < doubt ? doubt : doubts;
    if constexpr (Target::wants_shares) {
      if (pixels.is_full()) show_pixels();
      const std::ptrdiff_t at = target.place(x, v);
      prefetch(target.raster.barycentric.data() + at, 1);
      prefetch(target.raster.face.data() + at, 1);
      pixels.add(at, bits_of(is_covered), a, b, c);
    } else {
      // Linear in the image is 1 / z.
      const FourDoubles parts = a * inverse_a + b * inverse_b + c * inverse_c;
      const FourDoubles depth = (a + b + c) / (is_covered ? parts : none + 1);
      const FourDoubles from_least = depth < least ? least : depth;
      const FourDoubles exact = most < from_least ? most : from_least;
      target.row(v).show_four(x, is_covered ? exact : inside);
    }
  };

  const Index left = measures.left[i], right = measures.right[i];
  const Index top = measures.top[i], bottom = measures.bottom[i];
  const FourDoubles from_0{0, 1, 2, 3};
  if (right - left < pixels_at_once) {
    const Index x = std::min(left, width - pixels_at_once);
    const double first = left;
    const FourDoubles steps = from_0 - static_cast<double>(left - x);
    const FourDoubles within = steps > none + (right - left) ? outside : inside;
    const FourDoubles limit = steps < none ? outside : within;
    const FourDoubles step_p = steps * p.dy, step_q = steps * q.dy, step_r = steps * r.dy;
    const double across_p = p.dy * (first - p.x), across_q = q.dy * (first - q.x),
                 across_r = r.dy * (first - r.x);
    for (Index v = top; v <= bottom; ++v) {
      const double y = v;
      const FourDoubles a = (p.dx * (y - p.y) - across_p) - step_p;
      const FourDoubles b = (q.dx * (y - q.y) - across_q) - step_q;
      const FourDoubles c = (r.dx * (y - r.y) - across_r) - step_r;
      draw_lanes(x, v, a, b, c, limit);
    }
  } else {
    ImageTriangle triangle(corner_a, corner_b, corner_c);
    triangle.set_sides(sign, doubtful_area);
    triangle.each_row({left, right, top, bottom}, width, [&](Index v, Index first, Index last) {
      const auto start = triangle.areas_at(first, v);
      for (Index u = first; u <= last; u += pixels_at_once) {
        const Index x = std::min(u, width - pixels_at_once);
        const FourDoubles steps = from_0 - static_cast<double>(first - x);
        const FourDoubles within = steps > none + (last - first) ? outside : inside;
        const FourDoubles limit = steps < none ? outside : within;
        const FourDoubles a = start[0] - steps * p.dy, b = start[1] - steps * q.dy,
                          c = start[2] - steps * r.dy;
        draw_lanes(x, v, a, b, c, limit);
      }
    });
  }
  show_pixels();
  const double doubt = greater(greater(doubts[0], doubts[1]), greater(doubts[2], doubts[3]));
  return doubt < -doubtful_area;
}

/// Draws the faces of a batch from one on, but for those that may be held back; which is the first
/// that has to be cut before it is drawn.
template <class Target>
[[nodiscard]] std::size_t draw_batch(const Target& target, Index width, Index height,
                                     const FaceBatch& batch, const FaceMeasures& measures,
                                     std::size_t from, HeldFaces* held) {
  return vectorised_by_four([&target, width, height, &batch, &measures, from, held] {
    for (std::size_t i = from; i < batch.count; ++i) {
      const double area = measures.areas[i];
      if (area != 0 && width >= pixels_at_once) {
        const PixelBox box{measures.left[i], measures.right[i], measures.top[i],
                           measures.bottom[i]};
        if (box.is_empty()) continue;
        if (area > 0 && held != nullptr) {
          held->add(batch.faces[i], measures.least[i], box);
          continue;
        }
        if (draw_sure(target, width, batch, measures, i)) continue;
      } else if (!batch.is_near(i)) {
        return i;
      }
      const auto& [a, b, c] = batch.corners[i];
      draw_exactly(target, width, height, batch.faces[i], batch.points[a], batch.points[b],
                   batch.points[c]);
    }
    return batch.count;
  });
}
#else
struct FaceMeasures {
  void find(const FaceBatch&, Index, Index) {}
};
template <class Target>
[[nodiscard]] std::size_t draw_batch(const Target& target, Index width, Index height,
                                     const FaceBatch& batch, const FaceMeasures&, std::size_t from,
                                     HeldFaces*) {
  for (std::size_t i = from; i < batch.count; ++i) {
    if (!batch.is_near(i)) return i;
    const auto& [a, b, c] = batch.corners[i];
    draw_exactly(target, width, height, batch.faces[i], batch.points[a], batch.points[b],
                 batch.points[c]);
  }
  return batch.count;
}
#endif

template <TriangleMesh M>
[[nodiscard]] Vec3<double> vertex_position(const M& mesh, Index v) {
  const auto& p = MeshTraits<M>::position(mesh, v);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/// A moved mesh, as it is seen.
template <TriangleMesh M>
class MeshImage {
 public:
  /// The points of all vertices are kept in `points`; null: they are projected face by face.
  MeshImage(const M& mesh, const Pose& pose, const ImagePlane& plane, Index width, Index height,
            ImagePoint* points)
      : mesh_(mesh),
        pose_(pose),
        plane_(plane),
        width_(width),
        height_(height),
        vertices_(static_cast<Index>(Traits::vertex_count(mesh))),
        faces_(static_cast<Index>(Traits::face_count(mesh))),
        points_(points) {
    PositionBatch batch;
    std::array<ImagePoint, PositionBatch::size> own;
    for (Index v = 0; v < vertices_;) {
      ImagePoint* const out = points != nullptr ? points + v : own.data();
      const Index end = std::min(vertices_, v + Index{PositionBatch::size});
      batch.count = 0;
      while (v < end) batch.add(vertex_position(mesh_, v++));
      all_are_usual_ &= plane.project(out, batch, pose_);
    }
  }

  /// Throws for all that may be wrong with the mesh.
  template <class T>
  void check() const {
    const auto end = static_cast<std::uint32_t>(vertices_);
    const auto is_there = [&](Index v) { return static_cast<std::uint32_t>(v) < end; };
    for (Index f = 0; f < faces_; ++f) {
      const Face face = Traits::face(mesh_, f);
      if (is_there(face[0]) && is_there(face[1]) && is_there(face[2])) continue;
      for (const Index v : face) require_vertex(f, v, vertices_);
    }
    if (all_are_usual_) return;
    each_batch(nullptr, [&](const FaceBatch& batch) {
      for (std::size_t i = 0; i < batch.count; ++i) {
        const auto is_fine = [&](std::size_t k) {
          const ImagePoint& p = batch.points[batch.corners[i][k]];
          return p.inverse_z > 0 && is_drawn<T>(p.z);
        };
        if (!(is_fine(0) && is_fine(1) && is_fine(2))) draw_cut(NoTarget<T>{}, batch, i, true);
      }
    });
  }

  /// Null: no faces are held back.
  template <class Target>
  void draw(const Target& target, HeldFaces* held) const {
    if (held != nullptr && !held->begin(faces_, width_, height_)) held = nullptr;
    draw(target, nullptr, held);
    if (held == nullptr) return;
    held->drop_hidden(target, width_, height_);
    draw(target, held, nullptr);
  }

 private:
  using Traits = MeshTraits<M>;
  using Face = std::array<Index, 3>;

  [[nodiscard]] Vec3<double> position(Index v) const { return pose_(vertex_position(mesh_, v)); }

  template <class Target>
  void draw(const Target& target, const HeldFaces* some, HeldFaces* held) const {
    FaceMeasures measures;
    each_batch(some, [&](const FaceBatch& batch) {
      measures.find(batch, width_, height_);
      for (std::size_t i = 0;; ++i) {
        i = draw_batch(target, width_, height_, batch, measures, i, held);
        if (i == batch.count) break;
        draw_cut(target, batch, i, false);
      }
    });
  }

  /// Calls `work(batch)` with some faces after the other, of those given or of all.
  template <class Work>
  void each_batch(const HeldFaces* some, const Work& work) const {
    FaceBatch batch;
    PositionBatch positions;
    std::array<ImagePoint, PositionBatch::size> own;
    batch.points = points_ != nullptr ? points_ : own.data();
    batch.are_usual = all_are_usual_;
    const Index count = some != nullptr ? some->count() : faces_;
    for (Index first = 0; first < count; first += Index{FaceBatch::size}) {
      const auto size = static_cast<std::size_t>(std::min(count - first, Index{FaceBatch::size}));
      batch.count = size;
      for (std::size_t i = 0; i < size; ++i) {
        const Index n = first + static_cast<Index>(i), f = some != nullptr ? some->face(n) : n;
        const Face face = Traits::face(mesh_, f);
        auto& corners = batch.corners[i];
        batch.faces[i] = f;
        corners[0] = face[0], corners[1] = face[1], corners[2] = face[2];
      }
      if (points_ == nullptr) batch.are_usual = project_corners(own.data(), positions, batch);
      work(batch);
    }
  }

  /// Projects the corners of the faces one by one.
  [[nodiscard]] bool project_corners(ImagePoint* out, PositionBatch& positions,
                                     FaceBatch& batch) const {
    positions.count = 0;
    for (std::size_t i = 0; i < batch.count; ++i) {
      for (Index& v : batch.corners[i]) {
        const auto at = static_cast<Index>(positions.count);
        positions.add(vertex_position(mesh_, v));
        v = at;
      }
    }
    return plane_.project(out, positions, pose_);
  }

  /// Draws a face of a batch, or the part of it that has a place on the plane.
  template <class Target>
  void draw_cut(const Target& target, const FaceBatch& batch, std::size_t i,
                bool is_checked) const {
    const auto& [a, b, c] = batch.corners[i];
    const std::array seen{batch.points[a], batch.points[b], batch.points[c]};
    const Index f = batch.faces[i];
    std::array<Vec3<double>, 3> positions;
    if (!(seen[0].inverse_z > 0 && seen[1].inverse_z > 0 && seen[2].inverse_z > 0)) {
      const Face face = Traits::face(mesh_, f);
      for (std::size_t k = 0; k < 3; ++k) {
        positions[k] = position(face[k]);
        if (is_checked) require_in_range(positions[k], face[k]);
      }
    }
    draw_face(target, plane_, width_, height_, f, seen, positions);
  }

  const M& mesh_;
  const Pose& pose_;
  const ImagePlane& plane_;
  Index width_, height_;
  Index vertices_, faces_;
  const ImagePoint* points_;
  bool all_are_usual_ = true;  // of the points of vertices
};

}  // namespace detail

/// Memory that `rasterize_into` works in: with one kept from frame to frame, each vertex is
/// projected once rather than in each of its faces, faces behind others are not drawn where that is
/// easily told, and nothing comes from the heap after the first frame of the largest mesh and
/// image.
class RasterWorkspace {
 public:
  /// Room for the vertices of a mesh.
  [[nodiscard]] detail::Array<detail::ImagePoint>& points(Index vertices) {
    points_.resize(static_cast<std::size_t>(vertices));
    return points_;
  }

  /// Room for the faces that are drawn last.
  [[nodiscard]] detail::HeldFaces& held() { return held_; }

  /// Makes a target tell what one call draws from what others drew.
  ///@{
  template <class T>
  void begin_call(detail::DepthTarget<T>&) {}
  template <class T>
  void begin_call(detail::FaceTarget<T>& target) {
    const std::size_t pixels = target.raster.face.pixels().size();
    if (calls_.size() < pixels || call_ == std::numeric_limits<std::uint8_t>::max()) {
      calls_.assign(std::max(pixels, calls_.size()), 0);
      call_ = 0;
    }
    target.calls = calls_.data();
    target.call = ++call_;
  }
  ///@}

 private:
  detail::Array<detail::ImagePoint> points_;
  detail::HeldFaces held_;
  detail::Array<std::uint8_t> calls_;  // of each pixel, which of the last calls drew there
  std::uint8_t call_ = 0;
};

namespace detail {

template <template <class> class Target, std::floating_point T, TriangleMesh M>
void draw_moved(Target<T> target, const M& mesh, const Pose& pose, const Camera<T>& camera,
                RasterWorkspace* work) {
  const ImagePlane plane(camera.template cast<double>());
  const auto vertices = static_cast<Index>(MeshTraits<M>::vertex_count(mesh));
  ImagePoint* const points = work == nullptr ? nullptr : work->points(vertices).data();
  const MeshImage image(mesh, pose, plane, camera.width, camera.height, points);
  image.template check<T>();
  if (work != nullptr) work->begin_call(target);
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
/// `rasterize` does and for a depth image of another size than the camera's. Cost: O(faces + rows
/// and pixels covered).
template <std::floating_point T, TriangleMesh M>
void rasterize_into(std::type_identity_t<ImageView<T>> depth, const M& mesh, const Pose& pose,
                    const Camera<T>& camera, RasterWorkspace* work = nullptr) {
  camera.require_valid();
  detail::require_camera_size(depth, camera, "the depth image");
  detail::require(depth.rows_are_packed(),
                  "the pixels of the depth image's rows do not lie side by side");
  detail::draw_moved(detail::DepthTarget<T>{depth}, mesh, pose, camera, work);
}

/// The same, with the faces that are seen, by their numbers in the mesh drawn there, and where.
template <std::floating_point T, TriangleMesh M>
void rasterize_into(Raster<T>& raster, const M& mesh, const Pose& pose, const Camera<T>& camera,
                    RasterWorkspace* work = nullptr) {
  camera.require_valid();
  detail::require_camera_size(raster.depth, camera, "the depth image");
  detail::require_camera_size(raster.face, camera, "the image of faces");
  detail::require_camera_size(raster.barycentric, camera, "the image of places in faces");
  detail::draw_moved(detail::FaceTarget<T>{raster}, mesh, pose, camera, work);
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
  detail::draw_moved(detail::FaceTarget<T>{raster}, mesh, Pose(), camera, &work);
  return raster;
}

}  // namespace gelight
