#pragma once

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
    look_from(turn, tilt);
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
    draw_bands(figure, band, step, most, least);
  }

  /// The same for one value per vertex, linear in between.
  void paint_bands(Figure& figure, const std::vector<double>& at_vertices, double step, double most,
                   double least = 0) const;

  /// A value of the vertices at a point, linear in between.
  [[nodiscard]] double interpolated(const std::vector<double>& at_vertices, const Point& p) const;

  /// The edges of the mesh that can be seen.
  void draw_edges(Figure& figure) const;

  /// A polyline on the surface, where it can be seen.
  void draw_path(Figure& figure, std::span<const Vec3> path) const;

  /// An arrow from a point of the surface along a vector, where the point can be seen.
  void draw_arrow(Figure& figure, const Vec3& from, const Vec3& along, double head = 6) const;

  /// A dot, with a name to its upper left.
  void draw_dot(Figure& figure, const Vec3& at, double radius = 5,
                const std::string& name = "") const;

  /// Where a point in space appears on the page.
  [[nodiscard]] Vec2 on_page(const Vec3& p) const;

  /// Whether nothing of the surface hides a point of it.
  [[nodiscard]] bool sees(const Vec3& p) const;

 private:
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  static constexpr int sharpness = 2;  // pixels of the picture per unit of the page

  [[nodiscard]] Point point(Index u, Index v) const;

  [[nodiscard]] gelight::Rgb8 shaded(const Colour& colour, Index u, Index v) const;

  void look_from(double turn, double tilt);
  // Bands that are given by their number at each pixel, NaN where nothing is seen.
  void draw_bands(Figure& figure, const gelight::Image<double>& band, double step, double most,
                  double least) const;
  // In short pieces, so that a line may pass behind something.
  void draw_line(Figure& figure, const Vec3& from, const Vec3& to) const;

  gelight::Surface<double> surface_;
  Figure::Box box_;
  gelight::Camera<double> camera_;
  Eigen::Matrix3d rotation_;
  Vec3 translation_;
  gelight::Raster<double> raster_;
};
