#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

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

  [[nodiscard]] static bool is_within(double reach, const ImagePoint& p) {
    return std::abs(p.x) <= reach && std::abs(p.y) <= reach &&
           p.inverse_z <= std::numeric_limits<double>::max();
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

/// Draws what the target needs of a mesh whose vertices are at `position(v)`, of which `point(v)`
/// is the image.
template <TriangleMesh M, class Position, class Point, class Target>
void draw_mesh(const Target& target, const M& mesh, const ImagePlane& plane, Index width,
               Index height, const Position& position, const Point& point) {
  using Traits = MeshTraits<M>;
  const auto vertices = static_cast<Index>(Traits::vertex_count(mesh));
  const auto faces = static_cast<Index>(Traits::face_count(mesh));
  for (Index f = 0; f < faces; ++f) {
    const std::array<Index, 3> face = Traits::face(mesh, f);
    for (const Index v : face) require_vertex(f, v, vertices);
    const std::array<ImagePoint, 3> corners{point(face[0]), point(face[1]), point(face[2])};
    if (corners[0].inverse_z > 0 && corners[1].inverse_z > 0 && corners[2].inverse_z > 0) {
      if (target.needs(corners)) ImageTriangle(corners).draw(target, width, height, f);
      continue;
    }
    const std::array<Vec3<double>, 3> positions{position(face[0]), position(face[1]),
                                                position(face[2])};
    for (std::size_t k = 0; k < 3; ++k) require_in_range(positions[k], face[k]);
    if (plane.misses_image(corners)) continue;
    const auto polygon = plane.cut(positions, corners);
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      const auto &a = polygon.data()[0], &b = polygon.data()[k - 1], &c = polygon.data()[k];
      const ImageTriangle::Shares shares{a.shares, b.shares, c.shares};
      const std::array seen{a.seen, b.seen, c.seen};
      if (target.needs(seen)) ImageTriangle(seen).draw(target, width, height, f, &shares);
    }
  }
}

template <TriangleMesh M>
[[nodiscard]] Vec3<double> vertex_position(const M& mesh, Index v) {
  const auto& p = MeshTraits<M>::position(mesh, v);
  return {double{p[0]}, double{p[1]}, double{p[2]}};
}

}  // namespace detail

/// Where a rigid body is: a point p of it is seen at rotation p + translation, in the camera's
/// frame. An `Eigen::Isometry3d` or another of Eigen's transforms converts to it.
struct Pose {
  Eigen::Matrix3d rotation{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< or any linear map
  Vec3<double> translation{0, 0, 0};                          ///< in the unit of the mesh

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
  for (Index v = 0; points != nullptr && v < vertices; ++v) points[v] = plane.project(position(v));
  const auto point = [&](Index v) {
    return points != nullptr ? points[v] : plane.project(position(v));
  };
  // All that may be wrong with the mesh, before anything is drawn.
  draw_mesh(NoTarget<T>{}, mesh, plane, camera.width, camera.height, position, point);
  draw_mesh(target, mesh, plane, camera.width, camera.height, position, point);
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
  const auto vertices = static_cast<Index>(MeshTraits<M>::vertex_count(mesh));
  detail::Array<detail::ImagePoint> points;
  points.reserve(static_cast<std::size_t>(vertices));
  for (Index v = 0; v < vertices; ++v) points.push_back(plane.project(position(v)));
  detail::draw_mesh(detail::FaceTarget<T>{raster}, mesh, plane, camera.width, camera.height,
                    position, [&](Index v) { return points[v]; });
  return raster;
}

}  // namespace gelight
