#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "figure.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/views/mesh_view.hpp"
#include "scale.hpp"

// Pictures of what is on a surface: values as bands of colour, paths, arrows.

/// A mesh as someone sees it from far away: turned about its z axis, then seen from above (tilt 0),
/// from the side (tilt pi/2) or from between. It fills the box of the page that it is given.
class View {
 public:
  using Point = gelight::SurfacePoint<double>;
  using Vec2 = gelight::Vec2<double>;
  using Vec3 = gelight::Vec3<double>;
  using Index = gelight::Index;

  template <gelight::TriangleMesh M>
  View(const M& mesh, const Figure::Box& box, double turn = 0, double tilt = 0)
      : surface_(mesh), box_(box) {
    const double c = std::cos(turn), s = std::sin(turn), up = std::cos(tilt), in = std::sin(tilt);
    Eigen::Matrix3d spin, look;
    spin << c, -s, 0, s, c, 0, 0, 0, 1;
    look << 1, 0, 0, 0, -up, -in, 0, in, -up;
    rotation_ = look * spin;
    Eigen::AlignedBox3d bounds;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      bounds.extend(rotation_ * surface_.position(v));
    }
    const Vec3 size = bounds.sizes();
    const double distance = 30 * size.maxCoeff();  // so far that parallels stay parallel
    translation_ = Vec3(0, 0, distance) - bounds.center();
    const double focus = sharpness * distance * std::min(box.width / size[0], box.height / size[1]);
    const auto width = static_cast<Index>(sharpness * box.width);
    const auto height = static_cast<Index>(sharpness * box.height);
    camera_ = {focus, focus, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
    gelight::Mesh<double> seen;
    for (Index v = 0; v < surface_.vertex_count(); ++v) {
      const Vec3 p = rotation_ * surface_.position(v) + translation_;
      seen.positions.push_back({p[0], p[1], p[2]});
    }
    for (Index f = 0; f < surface_.face_count(); ++f) seen.faces.push_back(surface_.face(f));
    raster_ = gelight::rasterize(seen, camera_);
  }

  [[nodiscard]] const gelight::Surface<double>& surface() const { return surface_; }

  /// Paints each visible point of the surface by `colour(point)`, darker where it leans away.
  template <class ColourOf>
  void paint(Figure& figure, const ColourOf& colour_of) const {
    gelight::Image<gelight::Rgb8> image(camera_.width, camera_.height, {255, 255, 255});
    for (Index v = 0; v < camera_.height; ++v) {
      for (Index u = 0; u < camera_.width; ++u) {
        if (raster_.face(u, v) >= 0) image(u, v) = shaded(colour_of(point(u, v)), u, v);
      }
    }
    figure.image(image, box_.x, box_.y, 1.0 / sharpness);
  }

  /// Paints values, `value(point)`, as bands `step` wide with a dark line between them, the colours
  /// from dark at `least` to light at `most`.
  template <class ValueOf>
  void paint_bands(Figure& figure, const ValueOf& value, double step, double most,
                   double least = 0) const {
    gelight::Image<double> band(camera_.width, camera_.height, none);
    for (Index v = 0; v < camera_.height; ++v) {
      for (Index u = 0; u < camera_.width; ++u) {
        if (raster_.face(u, v) >= 0) band(u, v) = std::floor(value(point(u, v)) / step);
      }
    }
    gelight::Image<gelight::Rgb8> image(camera_.width, camera_.height, {255, 255, 255});
    for (Index v = 0; v < camera_.height; ++v) {
      for (Index u = 0; u < camera_.width; ++u) {
        const double b = band(u, v);
        if (!std::isfinite(b)) continue;
        const double right = u + 1 < camera_.width ? band(u + 1, v) : b;
        const double below = v + 1 < camera_.height ? band(u, v + 1) : b;
        const bool is_line =
            (std::isfinite(right) && right != b) || (std::isfinite(below) && below != b);
        const double share = ((b + 0.5) * step - least) / (most - least);
        image(u, v) = shaded(is_line ? Colour{0.05, 0.1, 0.15} : band_colour(share), u, v);
      }
    }
    figure.image(image, box_.x, box_.y, 1.0 / sharpness);
  }

  /// The same for one value per vertex, linear in between.
  void paint_bands(Figure& figure, const std::vector<double>& at_vertices, double step, double most,
                   double least = 0) const {
    paint_bands(
        figure, [&](const Point& p) { return interpolated(at_vertices, p); }, step, most, least);
  }

  /// A value of the vertices at a point, linear in between.
  [[nodiscard]] double interpolated(const std::vector<double>& at_vertices, const Point& p) const {
    const auto corners = surface_.face(p.element[0]);
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      sum += p.weights[k] * at_vertices[static_cast<std::size_t>(corners[k])];
    }
    return sum;
  }

  /// The edges of the mesh that can be seen.
  void draw_edges(Figure& figure) const {
    for (Index h = 0; h < surface_.halfedge_count(); ++h) {
      if (surface_.twin(h) > h) continue;
      draw_line(figure, surface_.position(surface_.origin(h)), surface_.position(surface_.tip(h)));
    }
  }

  /// A polyline on the surface, where it can be seen.
  void draw_path(Figure& figure, std::span<const Vec3> path) const {
    for (std::size_t i = 1; i < path.size(); ++i) draw_line(figure, path[i - 1], path[i]);
  }

  /// An arrow from a point of the surface along a vector, where the point can be seen.
  void draw_arrow(Figure& figure, const Vec3& from, const Vec3& along, double head = 6) const {
    if (!sees(from)) return;
    const Vec2 a = on_page(from), b = on_page(from + along);
    figure.arrow(a[0], a[1], b[0], b[1], std::min(head, 0.6 * (b - a).norm()));
  }

  /// A dot, with a name to its upper left.
  void draw_dot(Figure& figure, const Vec3& at, double radius = 5,
                const std::string& name = "") const {
    if (!sees(at)) return;
    const Vec2 p = on_page(at);
    figure.disc(p[0], p[1], radius);
    if (!name.empty()) figure.text(name, p[0] - 2 * radius, p[1] - 2 * radius, 18);
  }

  /// Where a point in space appears on the page.
  [[nodiscard]] Vec2 on_page(const Vec3& p) const {
    const Vec2 pixel = camera_.project(rotation_ * p + translation_);
    return {box_.x + (pixel[0] + 0.5) / sharpness, box_.y + (pixel[1] + 0.5) / sharpness};
  }

  /// Whether nothing of the surface hides a point of it.
  [[nodiscard]] bool sees(const Vec3& p) const {
    const Vec3 q = rotation_ * p + translation_;
    const Vec2 pixel = camera_.project(q);
    // The surface runs on between pixels: beside the point it may be nearer by its slope.
    double deepest = 0;
    for (const Index dv : {-1, 0, 1}) {
      for (const Index du : {-1, 0, 1}) {
        const auto u = static_cast<Index>(std::lround(pixel[0])) + du;
        const auto v = static_cast<Index>(std::lround(pixel[1])) + dv;
        if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) continue;
        deepest = std::max(deepest, raster_.depth(u, v));
      }
    }
    return q[2] <= deepest * (1 + 1e-4);
  }

 private:
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  static constexpr int sharpness = 2;  // pixels of the picture per unit of the page

  [[nodiscard]] Point point(Index u, Index v) const {
    return gelight::face_point<double>(raster_.face(u, v), raster_.barycentric(u, v));
  }

  [[nodiscard]] gelight::Rgb8 shaded(const Colour& colour, Index u, Index v) const {
    const auto [a, b, c] = surface_.face(raster_.face(u, v));
    const Vec3 normal = gelight::cross<double>(surface_.position(b) - surface_.position(a),
                                               surface_.position(c) - surface_.position(a));
    const double light = 0.5 + 0.5 * std::abs((rotation_ * normal.stableNormalized())[2]);
    const auto channel = [&](double x) { return static_cast<std::uint8_t>(255 * light * x); };
    return {channel(colour.red), channel(colour.green), channel(colour.blue)};
  }

  // In short pieces, so that a line may pass behind something.
  void draw_line(Figure& figure, const Vec3& from, const Vec3& to) const {
    const double pixels = (on_page(to) - on_page(from)).norm();
    const int pieces = std::max(1, static_cast<int>(pixels / 4));
    Vec3 a = from;
    for (int i = 1; i <= pieces; ++i) {
      const Vec3 b = from + (to - from) * i / pieces;
      if (sees(a) && sees(b)) {
        const Vec2 p = on_page(a), q = on_page(b);
        figure.line(p[0], p[1], q[0], q[1]);
      }
      a = b;
    }
  }

  gelight::Surface<double> surface_;
  Figure::Box box_;
  gelight::Camera<double> camera_;
  Eigen::Matrix3d rotation_;
  Vec3 translation_;
  gelight::Raster<double> raster_;
};
