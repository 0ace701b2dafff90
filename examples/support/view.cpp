#include "view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "scale.hpp"

void View::look_from(double turn, double tilt) {
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
  const double focus = sharpness * distance * std::min(box_.width / size[0], box_.height / size[1]);
  const auto width = static_cast<Index>(sharpness * box_.width);
  const auto height = static_cast<Index>(sharpness * box_.height);
  camera_ = {focus, focus, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
  gelight::Mesh<double> seen;
  for (Index v = 0; v < surface_.vertex_count(); ++v) {
    const Vec3 p = rotation_ * surface_.position(v) + translation_;
    seen.positions.push_back({p[0], p[1], p[2]});
  }
  for (Index f = 0; f < surface_.face_count(); ++f) seen.faces.push_back(surface_.face(f));
  raster_ = gelight::rasterize(seen, camera_);
}

void View::draw_bands(Figure& figure, const gelight::Image<double>& band, double step, double most,
                      double least) const {
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

void View::paint_bands(Figure& figure, const std::vector<double>& at_vertices, double step,
                       double most, double least) const {
  paint_bands(
      figure, [&](const Point& p) { return interpolated(at_vertices, p); }, step, most, least);
}

double View::interpolated(const std::vector<double>& at_vertices, const Point& p) const {
  const auto corners = surface_.face(p.element[0]);
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += p.weights[k] * at_vertices[static_cast<std::size_t>(corners[k])];
  }
  return sum;
}

void View::draw_edges(Figure& figure) const {
  for (Index h = 0; h < surface_.halfedge_count(); ++h) {
    if (surface_.twin(h) > h) continue;
    draw_line(figure, surface_.position(surface_.origin(h)), surface_.position(surface_.tip(h)));
  }
}

void View::draw_path(Figure& figure, std::span<const Vec3> path) const {
  for (std::size_t i = 1; i < path.size(); ++i) draw_line(figure, path[i - 1], path[i]);
}

void View::draw_arrow(Figure& figure, const Vec3& from, const Vec3& along, double head) const {
  if (!sees(from)) return;
  const Vec2 a = on_page(from), b = on_page(from + along);
  figure.arrow(a[0], a[1], b[0], b[1], std::min(head, 0.6 * (b - a).norm()));
}

void View::draw_dot(Figure& figure, const Vec3& at, double radius, const std::string& name) const {
  if (!sees(at)) return;
  const Vec2 p = on_page(at);
  figure.disc(p[0], p[1], radius);
  if (!name.empty()) figure.text(name, p[0] - 2 * radius, p[1] - 2 * radius, 18);
}

auto View::on_page(const Vec3& p) const -> Vec2 {
  const Vec2 pixel = camera_.project(rotation_ * p + translation_);
  return {box_.x + (pixel[0] + 0.5) / sharpness, box_.y + (pixel[1] + 0.5) / sharpness};
}

bool View::sees(const Vec3& p) const {
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

auto View::point(Index u, Index v) const -> Point {
  return gelight::face_point<double>(raster_.face(u, v), raster_.barycentric(u, v));
}

gelight::Rgb8 View::shaded(const Colour& colour, Index u, Index v) const {
  const auto [a, b, c] = surface_.face(raster_.face(u, v));
  const Vec3 normal = gelight::cross<double>(surface_.position(b) - surface_.position(a),
                                             surface_.position(c) - surface_.position(a));
  const double light = 0.5 + 0.5 * std::abs((rotation_ * normal.stableNormalized())[2]);
  const auto channel = [&](double x) { return static_cast<std::uint8_t>(255 * light * x); };
  return {channel(colour.red), channel(colour.green), channel(colour.blue)};
}

void View::draw_line(Figure& figure, const Vec3& from, const Vec3& to) const {
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
