#include "figure.hpp"

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <stdexcept>

Figure::Figure(int width, int height, Colour paper)
    : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height),
               cairo_surface_destroy),
      cairo_(cairo_create(surface_.get()), cairo_destroy) {
  pen(paper, 1);
  cairo_paint(cairo_.get());
  pen(black, 1);
  cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cairo_.get(), CAIRO_LINE_JOIN_ROUND);
  cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
}

void Figure::image(const gelight::Image<gelight::Rgb8>& pixels, double x, double y, double scale) {
  const int width = pixels.width(), height = pixels.height();
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> copy(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), cairo_surface_destroy);
  unsigned char* rows = cairo_image_surface_get_data(copy.get());
  const auto step = cairo_image_surface_get_stride(copy.get());
  for (int v = 0; v < height; ++v) {
    auto* row = reinterpret_cast<std::uint32_t*>(rows + std::ptrdiff_t{v} * step);
    for (int u = 0; u < width; ++u) {
      const auto& [r, g, b] = pixels(u, v);
      row[u] = static_cast<std::uint32_t>(r << 16 | g << 8 | b);
    }
  }
  cairo_surface_mark_dirty(copy.get());
  cairo_save(cairo_.get());
  cairo_translate(cairo_.get(), x, y);
  cairo_scale(cairo_.get(), scale, scale);
  cairo_set_source_surface(cairo_.get(), copy.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cairo_.get()), CAIRO_FILTER_GOOD);
  cairo_paint(cairo_.get());
  cairo_restore(cairo_.get());
}

void Figure::clipped_image(const gelight::Image<gelight::Rgb8>& pixels, double x, double y,
                           double scale, const Box& box) {
  cairo_save(cairo_.get());
  cairo_rectangle(cairo_.get(), box.x, box.y, box.width, box.height);
  cairo_clip(cairo_.get());
  image(pixels, x, y, scale);
  cairo_restore(cairo_.get());
}

void Figure::pen(Colour colour, double width) {
  cairo_set_source_rgb(cairo_.get(), colour.red, colour.green, colour.blue);
  cairo_set_line_width(cairo_.get(), width);
}

void Figure::line(double x0, double y0, double x1, double y1) {
  cairo_move_to(cairo_.get(), x0, y0);
  cairo_line_to(cairo_.get(), x1, y1);
  cairo_stroke(cairo_.get());
}

void Figure::arrow(double x0, double y0, double x1, double y1, double head) {
  const double direction = std::atan2(y1 - y0, x1 - x0), half = std::numbers::pi / 7;
  line(x0, y0, x1 - head * 0.7 * std::cos(direction), y1 - head * 0.7 * std::sin(direction));
  cairo_move_to(cairo_.get(), x1, y1);
  for (const double side : {direction - half, direction + half}) {
    cairo_line_to(cairo_.get(), x1 - head * std::cos(side), y1 - head * std::sin(side));
  }
  cairo_close_path(cairo_.get());
  cairo_fill(cairo_.get());
}

void Figure::polyline(std::span<const gelight::Vec2<double>> points) {
  cairo_new_path(cairo_.get());
  for (const auto& p : points) cairo_line_to(cairo_.get(), p[0], p[1]);
  cairo_stroke(cairo_.get());
}

void Figure::area(std::span<const gelight::Vec2<double>> corners, Colour colour, double opacity) {
  cairo_set_source_rgba(cairo_.get(), colour.red, colour.green, colour.blue, opacity);
  cairo_new_path(cairo_.get());
  for (const auto& p : corners) cairo_line_to(cairo_.get(), p[0], p[1]);
  cairo_fill(cairo_.get());
}

void Figure::disc(double x, double y, double radius) {
  cairo_new_path(cairo_.get());
  cairo_arc(cairo_.get(), x, y, radius, 0, 2 * std::numbers::pi);
  cairo_fill(cairo_.get());
}

void Figure::text(const std::string& words, double x, double y, double size, bool upright) {
  cairo_set_font_size(cairo_.get(), size);
  cairo_text_extents_t box;
  cairo_text_extents(cairo_.get(), words.c_str(), &box);
  cairo_save(cairo_.get());
  cairo_translate(cairo_.get(), x, y);
  if (upright) cairo_rotate(cairo_.get(), -std::numbers::pi / 2);
  cairo_move_to(cairo_.get(), -box.x_bearing - box.width / 2, size * 0.35);
  cairo_show_text(cairo_.get(), words.c_str());
  cairo_restore(cairo_.get());
}

void Figure::text(const std::string& words, const gelight::Vec2<double>& at, double size) {
  text(words, at[0], at[1], size);
}

void Figure::text_from(const std::string& words, double x, double y, double size) {
  cairo_set_font_size(cairo_.get(), size);
  cairo_move_to(cairo_.get(), x, y + size * 0.35);
  cairo_show_text(cairo_.get(), words.c_str());
}

void Figure::text_before(const std::string& words, double x, double y, double size) {
  cairo_set_font_size(cairo_.get(), size);
  cairo_text_extents_t box;
  cairo_text_extents(cairo_.get(), words.c_str(), &box);
  text_from(words, x - box.x_advance, y, size);
}

gelight::Image<gelight::Rgb8> Figure::pixels() const {
  cairo_surface_flush(surface_.get());
  const unsigned char* rows = cairo_image_surface_get_data(surface_.get());
  const auto step = cairo_image_surface_get_stride(surface_.get());
  gelight::Image<gelight::Rgb8> image(cairo_image_surface_get_width(surface_.get()),
                                      cairo_image_surface_get_height(surface_.get()));
  for (int v = 0; v < image.height(); ++v) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(rows + std::ptrdiff_t{v} * step);
    for (int u = 0; u < image.width(); ++u) {
      const std::uint32_t c = row[u];
      image(u, v) = {static_cast<std::uint8_t>(c >> 16), static_cast<std::uint8_t>(c >> 8),
                     static_cast<std::uint8_t>(c)};
    }
  }
  return image;
}

std::string Figure::png() const {
  std::string bytes;
  const auto put = [](void* to, const unsigned char* from, unsigned count) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(from), count);
    return CAIRO_STATUS_SUCCESS;
  };
  const cairo_status_t status =
      cairo_surface_write_to_png_stream(surface_.get(), +put, static_cast<void*>(&bytes));
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(std::string("cannot make a PNG: ") + cairo_status_to_string(status));
  }
  return bytes;
}

void Figure::save(const std::string& path) const {
  const std::string bytes = png();
  errno = 0;
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  const bool is_written =
      file != nullptr && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  int why = errno;
  if (file != nullptr && std::fclose(file) != 0 && is_written) {
    why = errno;
  } else if (is_written) {
    return;
  }
  throw std::runtime_error("cannot write " + path + ": " + std::strerror(why));
}
