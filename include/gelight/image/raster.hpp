#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>

#include "gelight/concepts/mesh.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
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

/// A corner of a face that was cut.
struct CutCorner {
  Vec3<double> point;  // column and row times z, and z
  ImagePoint seen;
  Vec3<double> shares;  // its barycentric coordinates in the whole face
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

  [[nodiscard]] ImagePoint project(const Vec3<double>& p) const {
    if (!(p[2] > 0)) return {0, 0, p[2], 0};
    ImagePoint point{on_grid(camera_.fx * p[0] / p[2] + camera_.cx),
                     on_grid(camera_.fy * p[1] / p[2] + camera_.cy), p[2], 1 / p[2]};
    if (!is_within(near_ * size_, point)) point.inverse_z = 0;
    return point;
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
  [[nodiscard]] Array<CutCorner> cut(const std::array<Vec3<double>, 3>& positions,
                                     const std::array<ImagePoint, 3>& seen) const {
    Array<CutCorner> polygon;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double>& p = positions[k];
      const CutCorner corner{{std::fma(camera_.fx, p[0], camera_.cx * p[2]),
                              std::fma(camera_.fy, p[1], camera_.cy * p[2]), p[2]},
                             seen[k],
                             Vec3<double>::Unit(static_cast<Index>(k))};
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

  [[nodiscard]] static bool is_within(double reach, const ImagePoint& p) {
    return std::abs(p.x) <= reach && std::abs(p.y) <= reach &&
           p.inverse_z <= std::numeric_limits<double>::max();
  }

  /// The nearest point of the grid: the sum has just as many digits as the grid.
  [[nodiscard]] double on_grid(double x) const { return (x + 6 * size_) - 6 * size_; }

  /// The part of a polygon on this side of a column or row. Its sides are cut from their end
  /// inside, so that both faces at a side find the same point.
  [[nodiscard]] Array<CutCorner> cut(const Array<CutCorner>& polygon, Index axis, double at) const {
    const double sign = at < 0 ? 1 : -1;
    const auto distance = [&](const CutCorner& corner) {
      return std::fma(std::abs(at), corner.point[2], sign * corner.point[axis]);
    };
    Array<CutCorner> inside;
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
    }
    corner.shares = (a.shares + t * (b.shares - a.shares)).cwiseMax(0);
    return corner;
  }

  Camera<double> camera_;
  double size_ = 1;  // of the image: a power of two
};

/// The first pixel of a row or column that is not before x, and the last that is not beyond it.
///@{
[[nodiscard]] inline Index first_pixel(double x, Index size) {
  x = std::clamp(x, 0.0, static_cast<double>(size));
  const auto i = static_cast<Index>(x);
  return i + (i < x);
}
[[nodiscard]] inline Index last_pixel(double x, Index size) {
  x = std::clamp(x, -1.0, static_cast<double>(size - 1));
  const auto i = static_cast<Index>(x);
  return i - (i > x);
}
///@}

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

  /// `shares` has a column for each corner, its barycentric coordinates in the face; null: the
  /// corners are those of the face.
  template <class T>
  void draw(Raster<T>& raster, Index face, const Eigen::Matrix3d* shares = nullptr) {
    const Index width = raster.depth.width(), height = raster.depth.height();
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
      if (first <= last) draw_row(raster, face, shares, v, first, last);
    }
  }

 private:
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
    doubtful_ = is_thin ? std::numeric_limits<double>::infinity() : 0x1p-50 * box;
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

  /// Whether T holds a depth, and double what is computed with it.
  template <class T>
  [[nodiscard]] static bool is_drawn(double z) {
    using Limits = std::numeric_limits<T>;
    return z >= std::max(least_drawn, double{Limits::min()}) &&
           z <= std::min(most_drawn, double{Limits::max()});
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

  template <class T>
  void draw_row(Raster<T>& raster, Index face, const Eigen::Matrix3d* shares, Index v, Index first,
                Index last) const {
    T* const depths = raster.depth.row(v);
    Index* const faces = raster.face.row(v);
    std::array<T, 3>* const barycentrics = raster.barycentric.row(v);
    const auto area = [&](const Side& s) { return s.dx * (v - s.y) - s.dy * (first - s.x); };
    const Vec3<double> start(area(sides_[0]), area(sides_[1]), area(sides_[2]));
    const Vec3<double> step(-sides_[0].dy, -sides_[1].dy, -sides_[2].dy);
    const Vec3<double> inverse_depths = inverse_depths_;
    const double doubtful = doubtful_, least = least_, most = most_;
    const bool may_leave_range = may_leave_range_;
    for (Index u = first; u <= last; ++u) {
      // The areas that the pixel's centre spans with the sides.
      Vec3<double> areas = start + (u - first) * step;
      const double smallest = areas.minCoeff();
      if (smallest < -doubtful) continue;
      if (!(smallest > doubtful) && !settle(u, v, areas)) continue;
      // Linear in the image are 1 / z, and the barycentric coordinates divided by z.
      Vec3<double> parts = areas.cwiseProduct(inverse_depths);
      const double sum = parts.sum();
      const double exact = std::min(std::max(areas.sum() / sum, least), most);
      if (may_leave_range) {
        require(is_drawn<T>(exact), "face ", face, " is seen at pixel (", u, ", ", v, ") at depth ",
                exact, ", which is out of the range of depths");
      }
      const auto z = static_cast<T>(exact);
      if (!(z < depths[u])) continue;
      depths[u] = z;
      faces[u] = face;
      if (shares) parts = in_whole(*shares, parts);
      barycentrics[u] = {static_cast<T>(parts[0] / sum), static_cast<T>(parts[1] / sum),
                         static_cast<T>(parts[2] / sum)};
    }
  }

  // Written out: the compiler does not inline Eigen's product here.
  [[nodiscard]] static Vec3<double> in_whole(const Eigen::Matrix3d& shares,
                                             const Vec3<double>& parts) {
    const auto part = [&](Index k) {
      return shares(k, 0) * parts[0] + shares(k, 1) * parts[1] + shares(k, 2) * parts[2];
    };
    return {part(0), part(1), part(2)};
  }

  /// Replaces areas that rounding may have spoilt; whether none is negative.
  [[nodiscard]] bool settle(Index u, Index v, Vec3<double>& areas) const {
    for (Index k = 0; k < 3; ++k) {
      const Side& side = sides_[static_cast<std::size_t>(k)];
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
  Vec3<double> inverse_depths_;
  std::array<Side, 3> sides_;
};

}  // namespace detail

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
  using Traits = MeshTraits<M>;
  camera.require_valid();
  const detail::ImagePlane plane(camera.template cast<double>());
  Raster<T> raster{Image<T>(camera.width, camera.height, std::numeric_limits<T>::infinity()),
                   Image<Index>(camera.width, camera.height, -1),
                   Image<std::array<T, 3>>(camera.width, camera.height)};
  const auto vertices = static_cast<Index>(Traits::vertex_count(mesh));
  const auto faces = static_cast<Index>(Traits::face_count(mesh));
  const auto position = [&](Index v) {
    const auto& p = Traits::position(mesh, v);
    return Vec3<double>(double{p[0]}, double{p[1]}, double{p[2]});
  };
  detail::Array<detail::ImagePoint> points;
  points.reserve(static_cast<std::size_t>(vertices));
  for (Index v = 0; v < vertices; ++v) points.push_back(plane.project(position(v)));

  for (Index f = 0; f < faces; ++f) {
    const std::array<Index, 3> face = Traits::face(mesh, f);
    for (const Index v : face) {
      detail::require(v >= 0 && v < vertices, "face ", f, " has vertex ", v, ", the mesh has ",
                      vertices, " vertices");
    }
    const std::array<detail::ImagePoint, 3> corners{points[face[0]], points[face[1]],
                                                    points[face[2]]};
    if (corners[0].inverse_z > 0 && corners[1].inverse_z > 0 && corners[2].inverse_z > 0) {
      detail::ImageTriangle(corners).draw(raster, f);
      continue;
    }
    std::array<Vec3<double>, 3> positions;
    for (std::size_t k = 0; k < 3; ++k) {
      positions[k] = position(face[k]);
      const Vec3<double>& p = positions[k];
      detail::require(p.allFinite(), "vertex ", face[k], " is not finite");
      detail::require(p.cwiseAbs().maxCoeff() <= detail::most_drawn, "vertex ", face[k], " at (",
                      p.x(), ", ", p.y(), ", ", p.z(), ") is farther off than ",
                      detail::most_drawn);
    }
    if (plane.misses_image(corners)) continue;
    const auto polygon = plane.cut(positions, corners);
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      const auto &a = polygon.data()[0], &b = polygon.data()[k - 1], &c = polygon.data()[k];
      Eigen::Matrix3d shares;
      shares << a.shares, b.shares, c.shares;
      const std::array seen{a.seen, b.seen, c.seen};
      detail::ImageTriangle(seen).draw(raster, f, &shares);
    }
  }
  return raster;
}

}  // namespace gelight
