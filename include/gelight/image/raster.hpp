#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

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

/// A corner of a face that was cut.
struct CutCorner {
  Vec3<double> point;  // column and row times z, and z
  ImagePoint seen;
  Vec3<double> shares;  // its barycentric coordinates in the whole face
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

  /// Where points are seen, several at a time.
  void project(ImagePoint* out, const PositionBatch& points) const {
    vectorised([out, &points, plane = *this] {
      for (std::size_t i = 0; i < points.count; ++i) {
        out[i] = plane.project(points.x[i], points.y[i], points.z[i]);
      }
    });
  }

  /// Whether a face has nothing in front of the camera, or nothing in the image for lying beside
  /// it.
  [[nodiscard]] bool misses_image(const std::array<ImagePoint, 3>& corners) const {
    const auto all = [&](const auto& is) {
      return is(corners[0]) && is(corners[1]) && is(corners[2]);
    };
    if (all([](const ImagePoint& p) { return p.z <= 0; })) return true;
    if (!all([](const ImagePoint& p) { return p.z > 0; })) return false;
    return all([](const ImagePoint& p) { return p.x < 0; }) ||
           all([](const ImagePoint& p) { return p.y < 0; }) ||
           all([&](const ImagePoint& p) { return p.x > camera_.width - 1; }) ||
           all([&](const ImagePoint& p) { return p.y > camera_.height - 1; });
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
                             Vec3<double>(k == 0, k == 1, k == 2)};
      polygon.push_back(corner);
    }
    for (const Index axis : {0, 1}) {
      for (const double side : {-1, 1}) polygon = cut(polygon, axis, side * far_ * size_);
    }
    for (CutCorner& corner : polygon) {
      corner.seen.inverse_z = 1 / corner.seen.z;
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

  /// The part of a polygon on this side of a column or row. Its sides are cut from their end
  /// inside, so that both faces at a side find the same point.
  [[nodiscard]] CutPolygon cut(const CutPolygon& polygon, Index axis, double at) const {
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
      CutCorner corner = from_a > 0 ? between(a, b, from_a / (from_a - from_b))
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
    for (Index i = 0; i < 3; ++i) {
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

/// Whether T holds a depth, and double what is computed with it.
template <class T>
[[nodiscard]] bool is_drawn(double z) {
  using Limits = std::numeric_limits<T>;
  return z >= std::max(least_drawn, double{Limits::min()}) &&
         z <= std::min(most_drawn, double{Limits::max()});
}
template <class T>
void require_drawn(double z, Index face) {
  require(is_drawn<T>(z), "face ", face, " is seen at depth ", z,
          ", which is out of the range of depths");
}

/// What triangles are drawn into: depths, and the faces that are seen there if those are wanted; or
/// nothing, to see whether all can be drawn.
template <class T>
struct DepthTarget {
  static constexpr bool wants_shares = false;
  ImageView<T> depth;

  struct Row {
    T* depth;
    [[nodiscard]] bool is_nearer(Index x, T z) const {
      if (!(z < depth[x])) return false;
      depth[x] = z;
      return true;
    }
    void show(Index, Index, const auto&) const {}
  };
  [[nodiscard]] Row row(Index y) const { return {depth.row(y)}; }
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>&) { return true; }
};
template <class T>
struct FaceTarget {
  static constexpr bool wants_shares = true;
  Raster<T>& raster;

  struct Row : DepthTarget<T>::Row {
    Index* face;
    std::array<T, 3>* barycentric;
    void show(Index x, Index f, const auto& shares) const {
      face[x] = f;
      barycentric[x] = shares();
    }
  };
  [[nodiscard]] Row row(Index y) const {
    return {{raster.depth.row(y)}, raster.face.row(y), raster.barycentric.row(y)};
  }
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>&) { return true; }
};
template <class T>
struct NoTarget {
  struct Row {
    [[nodiscard]] bool is_nearer(Index, T) const { return false; }
    void show(Index, Index, const auto&) const {}
  };
  [[nodiscard]] Row row(Index) const { return {}; }
  /// All depths of a face lie between those of its corners.
  [[nodiscard]] static bool needs(const std::array<ImagePoint, 3>& corners) {
    const auto& [a, b, c] = corners;
    return !(is_drawn<T>(a.z) && is_drawn<T>(b.z) && is_drawn<T>(c.z));
  }
};

/// Areas up to this share of the box of a triangle, which is not thin, may have the wrong sign.
inline constexpr double doubtful_share = 0x1p-50;

/// Draws a triangle of the image: a face, or a part of one. Which pixel centres lie in it or on its
/// sides is told without rounding, so that triangles that share corners leave none between them;
/// one without area has none.
class ImageTriangle {
 public:
  explicit ImageTriangle(const std::array<ImagePoint, 3>& corners) : corners_(corners) {
    const auto& [a, b, c] = corners;
    left_ = std::min({a.x, b.x, c.x});
    right_ = std::max({a.x, b.x, c.x});
    top_ = std::min({a.y, b.y, c.y});
    bottom_ = std::max({a.y, b.y, c.y});
  }

  /// Each corner's barycentric coordinates in the face; null: the corners are those of the face.
  using Shares = std::array<Vec3<double>, 3>;

  template <template <class> class Target, class T>
  void draw(const Target<T>& target, Index width, Index height, Index face,
            const Shares* shares = nullptr) {
    const Index first_column = first_pixel(left_, width), last_column = last_pixel(right_, width);
    const Index first_row = first_pixel(top_, height), last_row = last_pixel(bottom_, height);
    if (first_column > last_column || first_row > last_row || !find_sides()) return;
    find_depths<T>();
    // Where there are few, to look at them all is less work than to choose.
    const bool is_wide = last_column - first_column > 3;
    if (is_wide) find_slopes();
    for (Index v = first_row; v <= last_row; ++v) {
      Index first = first_column, last = last_column;
      if (is_wide) {
        const auto [from, to] = span(v);
        first = std::max(first, first_pixel(from, width));
        last = std::min(last, last_pixel(to, width));
      }
      if (first <= last) draw_row(target, face, shares, v, first, last);
    }
  }

 private:
  using Three = std::array<double, 3>;  // a number for each side or corner

  /// A line through two corners, of which the inside is where dx down - dy across is positive.
  struct Side {
    double x, y, dx, dy;
    double slope = 0;
  };

  /// Whether the triangle has an inside.
  [[nodiscard]] bool find_sides() {
    const auto& [a, b, c] = corners_;
    const double box = (right_ - left_) * (bottom_ - top_);
    double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    const bool is_thin = !(std::abs(area) > box / 16);
    if (is_thin) area = difference_of_products(b.x - a.x, c.y - a.y, b.y - a.y, c.x - a.x);
    doubtful_ = is_thin ? std::numeric_limits<double>::infinity() : doubtful_share * box;
    const double sign = area < 0 ? -1 : 1;
    const auto side = [&](const ImagePoint& p, const ImagePoint& q) {
      return Side{p.x, p.y, sign * (q.x - p.x), sign * (q.y - p.y)};
    };
    sides_ = {side(b, c), side(c, a), side(a, b)};
    return area != 0;
  }

  template <class T>
  void find_depths() {
    const auto& [a, b, c] = corners_;
    least_ = std::min({a.z, b.z, c.z});
    most_ = std::max({a.z, b.z, c.z});
    may_leave_range_ = !(is_drawn<T>(least_) && is_drawn<T>(most_));
    inverse_depths_ = {a.inverse_z, b.inverse_z, c.inverse_z};
  }

  void find_slopes() {
    for (Side& side : sides_) side.slope = side.dy != 0 ? side.dx / side.dy : 0;
  }

  /// Between which columns a row can be covered; rounding is far less than what is added.
  [[nodiscard]] std::array<double, 2> span(Index v) const {
    constexpr double more = 0x1p-10;
    double from = left_, to = right_;
    for (const Side& side : sides_) {
      const double x = side.x + (v - side.y) * side.slope;
      if (side.dy < 0) from = std::max(from, x - more);
      if (side.dy > 0) to = std::min(to, x + more);
    }
    return {from, to};
  }

  template <template <class> class Target, class T>
  void draw_row(const Target<T>& target, Index face, const Shares* shares, Index v, Index first,
                Index last) const {
    const auto row = target.row(v);
    const auto area = [&](const Side& s) { return s.dx * (v - s.y) - s.dy * (first - s.x); };
    const Three start{area(sides_[0]), area(sides_[1]), area(sides_[2])};
    const Three step{-sides_[0].dy, -sides_[1].dy, -sides_[2].dy};
    const Three inverse_depths = inverse_depths_;
    const double doubtful = doubtful_, least = least_, most = most_;
    const bool may_leave_range = may_leave_range_;
    for (Index u = first; u <= last; ++u) {
      // The areas that the pixel's centre spans with the sides.
      const double steps = u - first;
      Three areas{start[0] + steps * step[0], start[1] + steps * step[1],
                  start[2] + steps * step[2]};
      const double smallest = std::min({areas[0], areas[1], areas[2]});
      if (smallest < -doubtful) continue;
      if (!(smallest > doubtful) && !settle(u, v, areas)) continue;
      // Linear in the image are 1 / z, and the barycentric coordinates divided by z.
      Three parts{areas[0] * inverse_depths[0], areas[1] * inverse_depths[1],
                  areas[2] * inverse_depths[2]};
      const double sum = parts[0] + parts[1] + parts[2];
      const double depth = (areas[0] + areas[1] + areas[2]) / sum;
      const double exact = std::min(std::max(depth, least), most);
      if (may_leave_range) require_drawn<T>(exact, face);
      if (!row.is_nearer(u, static_cast<T>(exact))) continue;
      row.show(u, face, [&]() -> std::array<T, 3> {
        if (shares) parts = in_whole(*shares, parts);
        return {static_cast<T>(parts[0] / sum), static_cast<T>(parts[1] / sum),
                static_cast<T>(parts[2] / sum)};
      });
    }
  }

  [[nodiscard]] static Three in_whole(const Shares& shares, const Three& parts) {
    const auto part = [&](Index k) {
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

  const std::array<ImagePoint, 3>& corners_;
  double left_, right_, top_, bottom_;
  double doubtful_ = 0;  // areas up to this may have the wrong sign: all those of a thin triangle
  double least_ = 0, most_ = 0;   // depth of the corners
  bool may_leave_range_ = false;  // a pixel's depth
  Three inverse_depths_;
  std::array<Side, 3> sides_;
};

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
    if (target.needs(corners)) ImageTriangle(corners).draw(target, width, height, face);
    return;
  }
  if (plane.misses_image(corners)) return;
  const auto polygon = plane.cut(positions, corners);
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const auto &a = polygon.data()[0], &b = polygon.data()[k - 1], &c = polygon.data()[k];
    const ImageTriangle::Shares shares{a.shares, b.shares, c.shares};
    const std::array seen{a.seen, b.seen, c.seen};
    if (target.needs(seen)) ImageTriangle(seen).draw(target, width, height, face, &shares);
  }
}

/// Some faces, of which those are drawn together whose images are no more than four pixels wide and
/// high: the same is done with several at a time. What is drawn has the bits of ImageTriangle's.
class FaceBatch {
 public:
  static constexpr std::size_t size = PositionBatch::size / 3;

  void clear() { count_ = 0; }
  void add(const ImagePoint& a, const ImagePoint& b, const ImagePoint& c) {
    const std::size_t i = count_++;
    const bool is_whole = a.inverse_z > 0 && b.inverse_z > 0 && c.inverse_z > 0;
    set(0, i, is_whole ? a : ImagePoint{});
    set(1, i, is_whole ? b : ImagePoint{});
    set(2, i, is_whole ? c : ImagePoint{});
  }

  /// What is to be done with a face.
  enum Kind : Index { draw_alone, draw_together, draw_none };
  [[nodiscard]] Index kind(std::size_t i) const { return kind_[i]; }

  void measure(Index width, Index height) {
    vectorised([this, width, height] {
      // What is clamped is kept first: else branches would be made of it.
      for (std::size_t i = 0; i < count_; ++i) find_box(i, width, height);
      for (std::size_t i = 0; i < count_; ++i) measure(i);
      Index columns = 0, rows = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        const Index if_together = -Index{kind_[i] == draw_together};
        columns = std::max(columns, if_together & columns_[i]);
        rows = std::max(rows, if_together & rows_[i]);
      }
      for (Index row = 0; row < rows; ++row) cover(row, columns);
      for (std::size_t i = 0; i < count_; ++i) {
        kind_[i] = doubts_[i] != 0 ? draw_alone : Kind{kind_[i]};
      }
    });
  }

  /// Adds the pixels of a face that is drawn together with others; whether there is room for those
  /// of one more.
  [[nodiscard]] bool add_pixels(std::size_t i) {
    std::size_t n = pixels_;
    for (auto rest = static_cast<unsigned>(covered_[i]); rest != 0; rest &= rest - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
      const std::size_t row = bit / reach, column = bit % reach;
      for (std::size_t k = 0; k < 3; ++k) {
        areas_[k][n] = start_[row][k][i] - static_cast<double>(column) * dy_[k][i];
        inverse_[k][n] = inverse_z_[k][i];
      }
      least_[n] = least_z_[i];
      most_[n] = most_z_[i];
      column_[n] = first_column_[i] + static_cast<Index>(column);
      row_[n] = first_row_[i] + static_cast<Index>(row);
      face_[n] = static_cast<Index>(i);
      ++n;
    }
    pixels_ = n;
    return n + std::size_t{reach} * reach <= room;
  }

  /// Draws the pixels that were found, as pixels of the faces from `first_face` on.
  template <class Target>
  void draw(const Target& target, Index first_face) {
    interpolate(Target::wants_shares);
    for (std::size_t n = 0; n < pixels_; ++n) {
      const auto row = target.row(row_[n]);
      using T = std::remove_pointer_t<decltype(row.depth)>;
      if (!row.is_nearer(column_[n], static_cast<T>(depth_[n]))) continue;
      row.show(column_[n], first_face + face_[n], [&]() -> std::array<T, 3> {
        return {static_cast<T>(areas_[0][n]), static_cast<T>(areas_[1][n]),
                static_cast<T>(areas_[2][n])};
      });
    }
    pixels_ = 0;
  }

 private:
  static constexpr Index reach = 4;  // of faces that are drawn together, pixels
  static constexpr std::size_t room = 456;
  using Three = std::array<double, 3>;
  using Doubles = std::array<double, size>;
  using Indices = std::array<Index, size>;

  void set(std::size_t k, std::size_t i, const ImagePoint& corner) {
    x_[k][i] = corner.x;
    y_[k][i] = corner.y;
    z_[k][i] = corner.z;
    inverse_z_[k][i] = corner.inverse_z;
  }

  void find_box(std::size_t i, double width, double height) {
    const double ax = x_[0][i], bx = x_[1][i], cx = x_[2][i];
    const double ay = y_[0][i], by = y_[1][i], cy = y_[2][i];
    const double left = lesser(lesser(ax, bx), cx), right = greater(greater(ax, bx), cx);
    const double top = lesser(lesser(ay, by), cy), bottom = greater(greater(ay, by), cy);
    box_[i] = (right - left) * (bottom - top);
    left_[i] = lesser(greater(left, 0), width);
    right_[i] = lesser(greater(right, -1), width - 1);
    top_[i] = lesser(greater(top, 0), height);
    bottom_[i] = lesser(greater(bottom, -1), height - 1);
    least_z_[i] = lesser(lesser(z_[0][i], z_[1][i]), z_[2][i]);
    most_z_[i] = greater(greater(z_[0][i], z_[1][i]), z_[2][i]);
  }

  void measure(std::size_t i) {
    const double ax = x_[0][i], bx = x_[1][i], cx = x_[2][i];
    const double ay = y_[0][i], by = y_[1][i], cy = y_[2][i];
    const Index first_column = first_from(left_[i]), first_row = first_from(top_[i]);
    const Index columns = last_to(right_[i]) - first_column + 1;
    const Index rows = last_to(bottom_[i]) - first_row + 1;
    const double box = box_[i];
    const double area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    const bool is_whole = inverse_z_[0][i] > 0;
    const bool is_thin = !(std::abs(area) > box / 16);
    const bool is_small = (columns <= reach) & (rows <= reach) & !is_thin;
    const bool is_empty = is_whole & ((columns <= 0) | (rows <= 0));
    kind_[i] = draw_none * Index{is_empty} + draw_together * Index{is_whole & is_small & !is_empty};
    const double sign = area < 0 ? -1 : 1;
    dx_[0][i] = sign * (cx - bx), dy_[0][i] = sign * (cy - by);
    dx_[1][i] = sign * (ax - cx), dy_[1][i] = sign * (ay - cy);
    dx_[2][i] = sign * (bx - ax), dy_[2][i] = sign * (by - ay);
    doubtful_[i] = doubtful_share * box;
    first_column_[i] = first_column;
    columns_[i] = columns;
    first_row_[i] = first_row;
    rows_[i] = rows;
    covered_[i] = 0;
    doubts_[i] = 0;
  }

  /// Which pixels of a row lie in the faces, and whether rounding leaves a doubt about one.
  void cover(Index row, Index columns) {
    auto& start = start_[static_cast<std::size_t>(row)];
    for (std::size_t k = 0; k < 3; ++k) {
      const Doubles &x = x_[(k + 1) % 3], &y = y_[(k + 1) % 3], &dx = dx_[k], &dy = dy_[k];
      for (std::size_t i = 0; i < count_; ++i) {
        start[k][i] = dx[i] * (first_row_[i] + row - y[i]) - dy[i] * (first_column_[i] - x[i]);
      }
    }
    for (Index column = 0; column < columns; ++column) {
      const double steps = column;
      const Index bit = Index{1} << (reach * row + column);
      for (std::size_t i = 0; i < count_; ++i) {
        const double a = start[0][i] - steps * dy_[0][i], b = start[1][i] - steps * dy_[1][i],
                     c = start[2][i] - steps * dy_[2][i];
        const double smallest = lesser(lesser(a, b), c), doubtful = doubtful_[i];
        const Index is_in_box = Index{column < columns_[i]} & Index{row < rows_[i]};
        covered_[i] |= bit & -(is_in_box & Index{smallest > doubtful});
        doubts_[i] |= is_in_box & Index{smallest <= doubtful} & Index{smallest >= -doubtful};
      }
    }
  }

  /// Depths of pixels, and barycentric coordinates in the place of areas.
  void interpolate(bool wants_shares) {
    vectorised([this, wants_shares, pixels = pixels_] {
      for (std::size_t n = 0; n < pixels; ++n) {
        const double a = areas_[0][n], b = areas_[1][n], c = areas_[2][n];
        const double part_a = a * inverse_[0][n], part_b = b * inverse_[1][n],
                     part_c = c * inverse_[2][n];
        const double sum = part_a + part_b + part_c;
        depth_[n] = lesser(greater((a + b + c) / sum, least_[n]), most_[n]);
        areas_[0][n] = part_a;
        areas_[1][n] = part_b;
        areas_[2][n] = part_c;
        sum_[n] = sum;
      }
      if (!wants_shares) return;
      for (std::size_t n = 0; n < pixels; ++n) {
        areas_[0][n] /= sum_[n];
        areas_[1][n] /= sum_[n];
        areas_[2][n] /= sum_[n];
      }
    });
  }

  // Of each face: its corners, sides and box.
  std::array<Doubles, 3> x_, y_, z_, inverse_z_, dx_, dy_;
  Doubles left_, right_, top_, bottom_, box_, doubtful_, least_z_, most_z_;
  Indices kind_, first_column_, columns_, first_row_, rows_;
  Indices covered_, doubts_;  // a bit for each pixel of the box; not 0: ImageTriangle tells
  std::array<std::array<Doubles, 3>, reach> start_;  // areas at the first pixel of each row
  std::size_t count_ = 0;

  // Of each pixel: the areas that its centre spans with the sides of its face.
  std::array<std::array<double, room>, 3> areas_;
  std::array<std::array<double, room>, 3> inverse_;
  std::array<double, room> depth_, least_, most_, sum_;
  std::array<Index, room> column_, row_, face_;
  std::size_t pixels_ = 0;
};

/// A mesh whose vertices are at `position(v)`, as it is seen.
template <TriangleMesh M, class Position>
class MeshImage {
 public:
  /// The points of all vertices are kept in `points`; null: they are projected face by face.
  MeshImage(const M& mesh, const ImagePlane& plane, Index width, Index height,
            const Position& position, ImagePoint* points)
      : mesh_(mesh),
        plane_(plane),
        width_(width),
        height_(height),
        position_(position),
        vertices_(static_cast<Index>(Traits::vertex_count(mesh))),
        faces_(static_cast<Index>(Traits::face_count(mesh))),
        points_(points) {
    PositionBatch batch;
    for (Index v = 0; points != nullptr && v < vertices_;) {
      const Index first = v, end = std::min(vertices_, v + Index{PositionBatch::size});
      batch.count = 0;
      while (v < end) batch.add(position(v++));
      plane.project(points + first, batch);
      for (const ImagePoint& p : std::span(points + first, batch.count)) {
        all_are_near_ &= p.inverse_z > 0;
        least_z_ = lesser(least_z_, p.z);
        most_z_ = greater(most_z_, p.z);
      }
    }
  }

  /// Throws for all that may be wrong with the mesh.
  template <class T>
  void check() const {
    for (Index f = 0; f < faces_; ++f) {
      const Face face = Traits::face(mesh_, f);
      for (const Index v : face) require_vertex(f, v, vertices_);
    }
    const bool all_are_drawn = is_drawn<T>(least_z_) && is_drawn<T>(most_z_);
    if (points_ != nullptr && all_are_near_ && all_are_drawn) return;
    each_batch([&](Index first, Index count, const auto& faces, const ImagePoint* const* corners) {
      for (Index i = 0; i < count; ++i) {
        const ImagePoint* const* const c = corners + std::ptrdiff_t{3} * i;
        const auto is_fine = [](const ImagePoint& p) {
          return p.inverse_z > 0 && is_drawn<T>(p.z);
        };
        if (is_fine(*c[0]) && is_fine(*c[1]) && is_fine(*c[2])) continue;
        draw_alone(NoTarget<T>{}, first + i, faces[static_cast<std::size_t>(i)], c, true);
      }
    });
  }

  template <class Target>
  void draw(const Target& target) const {
    FaceBatch batch;
    each_batch([&](Index first, Index count, const auto& faces, const ImagePoint* const* corners) {
      batch.clear();
      for (Index i = 0; i < count; ++i) {
        const ImagePoint* const* const c = corners + std::ptrdiff_t{3} * i;
        batch.add(*c[0], *c[1], *c[2]);
      }
      batch.measure(width_, height_);
      for (Index i = 0; i < count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const Index kind = batch.kind(n);
        if (kind == FaceBatch::draw_none) continue;
        if (kind == FaceBatch::draw_together && batch.add_pixels(n)) continue;
        batch.draw(target, first);
        if (kind == FaceBatch::draw_alone) {
          draw_alone(target, first + i, faces[n], corners + std::ptrdiff_t{3} * i, false);
        }
      }
      batch.draw(target, first);
    });
  }

 private:
  using Traits = MeshTraits<M>;
  using Face = std::array<Index, 3>;

  /// Calls `work(first, count, faces, corners)` with some faces after the other.
  template <class Work>
  void each_batch(const Work& work) const {
    std::array<Face, FaceBatch::size> faces;
    std::array<const ImagePoint*, 3 * FaceBatch::size> corners;
    PositionBatch positions;
    std::array<ImagePoint, PositionBatch::size> own;
    for (Index first = 0; first < faces_; first += Index{FaceBatch::size}) {
      const Index count = std::min(faces_ - first, Index{FaceBatch::size});
      positions.count = 0;
      for (Index i = 0; i < count; ++i) {
        const Face face = Traits::face(mesh_, first + i);
        faces[static_cast<std::size_t>(i)] = face;
        for (std::size_t k = 0; k < 3; ++k) {
          const auto at = 3 * static_cast<std::size_t>(i) + k;
          corners[at] = points_ != nullptr ? points_ + face[k] : own.data() + at;
          if (points_ == nullptr) positions.add(position_(face[k]));
        }
      }
      plane_.project(own.data(), positions);
      work(first, count, faces, corners.data());
    }
  }

  template <class Target>
  void draw_alone(const Target& target, Index f, const Face& face, const ImagePoint* const* corners,
                  bool is_checked) const {
    const std::array seen{*corners[0], *corners[1], *corners[2]};
    std::array<Vec3<double>, 3> positions;
    if (!(seen[0].inverse_z > 0 && seen[1].inverse_z > 0 && seen[2].inverse_z > 0)) {
      for (std::size_t k = 0; k < 3; ++k) {
        positions[k] = position_(face[k]);
        if (is_checked) require_in_range(positions[k], face[k]);
      }
    }
    draw_face(target, plane_, width_, height_, f, seen, positions);
  }

  const M& mesh_;
  const ImagePlane& plane_;
  Index width_, height_;
  const Position& position_;
  Index vertices_, faces_;
  const ImagePoint* points_;
  bool all_are_near_ = true;  // of the points that are kept, and between which depths they are
  double least_z_ = most_drawn, most_z_ = least_drawn;
};

template <TriangleMesh M>
[[nodiscard]] Vec3<double> vertex_position(const M& mesh, Index v) {
  const auto& p = MeshTraits<M>::position(mesh, v);
  return {double{p[0]}, double{p[1]}, double{p[2]}};
}

}  // namespace detail

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
    // Spelled out, with sums in Eigen's order: its product takes long to compile.
    const Eigen::Matrix3d& r = rotation;
    return {r(0, 0) * p[0] + r(0, 1) * p[1] + r(0, 2) * p[2] + translation[0],
            r(1, 0) * p[0] + r(1, 1) * p[1] + r(1, 2) * p[2] + translation[1],
            r(2, 0) * p[0] + (r(2, 1) * p[1] + r(2, 2) * p[2]) + translation[2]};
  }
};

/// Memory that `rasterize_into` works in: with one kept from frame to frame, each vertex is
/// projected once rather than in each of its faces, and nothing comes from the heap after the first
/// frame of the largest mesh.
class RasterWorkspace {
 public:
  /// Room for the vertices of a mesh.
  [[nodiscard]] std::vector<detail::ImagePoint>& points(Index vertices) {
    points_.resize(static_cast<std::size_t>(vertices));
    return points_;
  }

 private:
  std::vector<detail::ImagePoint> points_;
};

namespace detail {

template <template <class> class Target, std::floating_point T, TriangleMesh M>
void draw_moved(const Target<T>& target, const M& mesh, const Pose& pose, const Camera<T>& camera,
                RasterWorkspace* work) {
  const ImagePlane plane(camera.template cast<double>());
  const auto position = [&](Index v) { return pose(vertex_position(mesh, v)); };
  const auto vertices = static_cast<Index>(MeshTraits<M>::vertex_count(mesh));
  ImagePoint* const points = work == nullptr ? nullptr : work->points(vertices).data();
  const MeshImage image(mesh, plane, camera.width, camera.height, position, points);
  image.template check<T>();
  image.draw(target);
}

}  // namespace detail

/// Draws a moved mesh over what a depth image shows already, wherever it is nearer: so one call
/// after the other, in any order, gives the nearest of several objects. Begin with +infinity
/// everywhere.
///
/// It is seen as `rasterize` sees the mesh with its vertices moved (in double). Nothing is taken
/// from the heap; with a workspace, see there. Throws InvalidInput, before anything is drawn, as
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
  const detail::ImagePlane plane(camera.template cast<double>());
  const auto position = [&](Index v) { return detail::vertex_position(mesh, v); };
  std::vector<detail::ImagePoint> points(
      static_cast<std::size_t>(MeshTraits<M>::vertex_count(mesh)));
  const detail::MeshImage image(mesh, plane, camera.width, camera.height, position, points.data());
  image.template check<T>();
  image.draw(detail::FaceTarget<T>{raster});
  return raster;
}

}  // namespace gelight
