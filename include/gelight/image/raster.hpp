#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>

#include "gelight/concepts/mesh.hpp"
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

/// A triangle as the camera at the origin sees it. The ray through (x, y, 1) meets its plane with
/// barycentric shares proportional to three functions linear in x and y; they need no division and
/// no clipping where the triangle reaches behind the camera (Olano and Greer 1997,
/// doi:10.1145/258694.258723).
struct SeenTriangle {
  std::array<Vec3<double>, 3> corners;
  std::array<Vec3<double>, 3> sides;  // sides[k] . (x, y, 1) vanishes on the side across corner k
  double volume = 0;

  SeenTriangle(const std::array<Vec3<double>, 3>& points, const std::array<Index, 3>& vertices)
      : corners(points) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
      // In the same order from both sides of an edge, so that no ray slips through between them.
      sides[k] = vertices[a] < vertices[b] ? cross(corners[a], corners[b])
                                           : Vec3<double>(-cross(corners[b], corners[a]));
    }
    volume = corners[0].dot(sides[0]);
  }
};

struct PixelRange {
  double left, right, top, bottom;
};

/// A box of pixel coordinates around the part of a triangle in front of the camera.
[[nodiscard]] inline PixelRange seen_range(const SeenTriangle& triangle,
                                           const Camera<double>& camera) {
  const double inf = std::numeric_limits<double>::infinity();
  PixelRange box{inf, -inf, inf, -inf};
  const auto include = [&](double x, double y) {
    box.left = std::min(box.left, camera.fx * x + camera.cx);
    box.right = std::max(box.right, camera.fx * x + camera.cx);
    box.top = std::min(box.top, camera.fy * y + camera.cy);
    box.bottom = std::max(box.bottom, camera.fy * y + camera.cy);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3<double>& p = triangle.corners[k];
    if (p[2] <= 0) continue;
    const double x = p[0] / p[2], y = p[1] / p[2];
    include(x, y);
    for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3}) {
      const Vec3<double>& q = triangle.corners[other];
      if (q[2] > 0) continue;
      // The side runs to infinity in the image, in the direction where it meets the plane z = 0.
      const Vec3<double> end = p[2] * q - q[2] * p;
      include(end[0] == 0 ? x : std::copysign(inf, end[0]),
              end[1] == 0 ? y : std::copysign(inf, end[1]));
    }
  }
  return box;
}

}  // namespace detail

/// The nearest face that each pixel's ray meets, seen from the origin along +z; both sides of a
/// face are seen. Nearer than z = 0 nothing is. Works in double whatever T is.
///
/// Throws InvalidInput for a bad camera, and for a face with an index out of range or a position
/// that is not finite. Cost: O(faces + pixels covered).
template <std::floating_point T, TriangleMesh M>
[[nodiscard]] Raster<T> rasterize(const M& mesh, const Camera<T>& camera) {
  using Traits = MeshTraits<M>;
  camera.require_valid();
  const Camera<double> exact = camera.template cast<double>();
  Raster<T> raster{Image<T>(camera.width, camera.height, std::numeric_limits<T>::infinity()),
                   Image<Index>(camera.width, camera.height, -1),
                   Image<std::array<T, 3>>(camera.width, camera.height)};
  const auto vertices = static_cast<Index>(Traits::vertex_count(mesh));
  const auto faces = static_cast<Index>(Traits::face_count(mesh));
  for (Index f = 0; f < faces; ++f) {
    const std::array<Index, 3> face = Traits::face(mesh, f);
    std::array<Vec3<double>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      detail::require(face[k] >= 0 && face[k] < vertices, "face ", f, " has vertex ", face[k],
                      ", the mesh has ", vertices, " vertices");
      const auto& p = Traits::position(mesh, face[k]);
      corners[k] = {double{p[0]}, double{p[1]}, double{p[2]}};
      detail::require(corners[k].allFinite(), "vertex ", face[k], " is not finite");
    }
    const detail::SeenTriangle triangle(corners, face);
    const detail::PixelRange box = detail::seen_range(triangle, exact);
    // A pixel more on each side, so that rounding of the box loses none.
    const auto first = [](double from, Index size) {
      return static_cast<Index>(std::clamp<double>(std::floor(from), 0, size));
    };
    const auto last = [](double to, Index size) {
      return static_cast<Index>(std::clamp<double>(std::ceil(to), -1, size - 1));
    };
    const Index left = first(box.left, camera.width), right = last(box.right, camera.width);
    const Index top = first(box.top, camera.height), bottom = last(box.bottom, camera.height);
    for (Index v = top; v <= bottom; ++v) {
      for (Index u = left; u <= right; ++u) {
        const Vec3<double> ray = exact.ray(u, v);
        const double a = triangle.sides[0].dot(ray);
        const double b = triangle.sides[1].dot(ray);
        const double c = triangle.sides[2].dot(ray);
        const bool inside = (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
        const double sum = a + b + c;
        if (!inside || sum == 0) continue;
        const double z = triangle.volume / sum;
        if (!(z > 0) || !(static_cast<T>(z) < raster.depth(u, v))) continue;
        raster.depth(u, v) = static_cast<T>(z);
        raster.face(u, v) = f;
        raster.barycentric(u, v) = {static_cast<T>(a / sum), static_cast<T>(b / sum),
                                    static_cast<T>(c / sum)};
      }
    }
  }
  return raster;
}

}  // namespace gelight
