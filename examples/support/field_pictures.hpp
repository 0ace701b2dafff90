#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "figure.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "scale.hpp"

// Pictures of distances and directions on a surface.

using gelight::Camera;
using gelight::Image;
using gelight::Index;
using gelight::Rgb8;
using gelight::Vec2;
using gelight::Vec3;

inline Rgb8 to_rgb8(const Colour& colour, double light) {
  const auto channel = [&](double c) {
    return static_cast<std::uint8_t>(std::clamp(255 * c * light, 0.0, 255.0));
  };
  return {channel(colour.red), channel(colour.green), channel(colour.blue)};
}

/// A membrane as someone sees it who stands beside it: its axis upright, turned by `turn` about it.
class OutsideView {
 public:
  OutsideView(const gelight::Mesh<double>& mesh, double turn, Index width, Index height)
      : camera_(Camera<double>::from_vertical_fov(0.36, width, height)) {
    double top = 0, around = 0;
    for (const auto& p : mesh.positions) {
      top = std::max(top, p[2]);
      around = std::max(around, std::hypot(p[0], p[1]));
    }
    // So far away that neither its height nor its width is cut off, with a little air.
    const double sideways = camera_.fx / (0.5 * width);
    const double away = std::max(3.2 * top, 1.05 * around * std::hypot(1.0, sideways));
    const double tip = 0.35;  // radians that the tip leans towards us
    Eigen::Matrix3d spin, upright;
    spin << std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn), 0, 0, 0, 1;
    upright << 1, 0, 0, 0, -std::sin(tip), -std::cos(tip), 0, std::cos(tip), -std::sin(tip);
    rotation_ = upright * spin;
    translation_ = {0, 0, away};
    translation_ -= rotation_ * Vec3<double>(0, 0, top / 2);
    raster_ = gelight::rasterize(gelight::placed<double>(mesh, rotation_, translation_), camera_);
  }

  [[nodiscard]] const gelight::Raster<double>& raster() const { return raster_; }

  /// Distance as bands of colour with a dark line between them, shaded by the tilt of the faces.
  [[nodiscard]] Image<Rgb8> isolines(const gelight::Surface<double>& surface,
                                     const gelight::ExactField<double>& field, double spacing,
                                     double farthest) const {
    const Index width = camera_.width, height = camera_.height;
    Image<double> distance(width, height, -1);
    Image<Rgb8> picture(width, height, {255, 255, 255});
    for (Index v = 0; v < height; ++v) {
      for (Index u = 0; u < width; ++u) {
        const Index face = raster_.face(u, v);
        if (face < 0) continue;
        const auto point = gelight::face_point<double>(face, raster_.barycentric(u, v));
        distance(u, v) = field.distance(point);
      }
    }
    for (Index v = 0; v + 1 < height; ++v) {
      for (Index u = 0; u + 1 < width; ++u) {
        const double d = distance(u, v), right = distance(u + 1, v), below = distance(u, v + 1);
        if (d < 0) continue;
        const auto band = [&](double x) { return std::floor(x / spacing); };
        const bool on_line =
            (right >= 0 && band(right) != band(d)) || (below >= 0 && band(below) != band(d));
        const Vec3<double> normal =
            rotation_ * gelight::detail::face_normal(surface, raster_.face(u, v)).normalized();
        const double light = 0.55 + 0.45 * std::abs(normal.z());
        picture(u, v) = to_rgb8(band_colour((band(d) + 0.5) * spacing / farthest),
                                on_line ? 0.35 * light : light);
      }
    }
    return picture;
  }

  /// Draws the parts of a line on the surface that are seen; the image stands at (x, y), scaled.
  void draw_path(Figure& figure, std::span<const Vec3<double>> path, double x, double y,
                 double scale) const {
    const double tolerance = 1.01;  // of the depth: a line on the surface is not behind it
    const auto seen = [&](const Vec3<double>& p, const Vec2<double>& pixel) {
      const auto u = static_cast<Index>(std::lround(pixel[0]));
      const auto v = static_cast<Index>(std::lround(pixel[1]));
      if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) return false;
      return p.z() < raster_.depth(u, v) * tolerance;
    };
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      const Vec3<double> a = rotation_ * path[i] + translation_;
      const Vec3<double> b = rotation_ * path[i + 1] + translation_;
      const Vec2<double> from = camera_.project(a), to = camera_.project(b);
      if (!seen(a, from) || !seen(b, to)) continue;
      figure.line(x + scale * from[0], y + scale * from[1], x + scale * to[0], y + scale * to[1]);
    }
  }

 private:
  Camera<double> camera_;
  Eigen::Matrix3d rotation_;
  Vec3<double> translation_;
  gelight::Raster<double> raster_;
};

/// Directions of a baked field as the sensor's camera sees them, an arrow every `step` pixels; all
/// arrows that lie across the view are equally long, those that run along it shrink.
inline void draw_arrows(Figure& figure, const Image<Vec3<double>>& field,
                        const Image<double>& depth, const Camera<double>& camera, double x,
                        double y, double scale, Index step) {
  for (Index v = step / 2; v < camera.height; v += step) {
    for (Index u = step / 2; u < camera.width; u += step) {
      const Vec3<double>& direction = field(u, v);
      if (direction.isZero()) continue;
      const Vec3<double> point = camera.unproject(u, v, depth(u, v));
      // How the pixel moves when the point moves along the direction.
      const double z = point.z();
      const Vec2<double> motion(camera.fx * (direction.x() - direction.z() * point.x() / z) / z,
                                camera.fy * (direction.y() - direction.z() * point.y() / z) / z);
      const double most = camera.fx * point.norm() / (z * z);  // the largest motion there can be
      const Vec2<double> half = motion / most * (0.45 * step);
      const double x0 = x + scale * (u - half[0]), y0 = y + scale * (v - half[1]);
      const double x1 = x + scale * (u + half[0]), y1 = y + scale * (v + half[1]);
      figure.arrow(x0, y0, x1, y1, std::min(5.0, 0.5 * std::hypot(x1 - x0, y1 - y0)));
    }
  }
}
