#pragma once

#include <cairo/cairo.h>

#include <memory>
#include <span>
#include <string>

#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

// A page to put images, lines, arrows and words on: the examples' pictures, drawn by cairo.

struct Colour {
  double red = 0, green = 0, blue = 0;
};

// Inks that differ in lightness as well as in hue.
inline constexpr Colour black{0, 0, 0}, grey{0.55, 0.55, 0.55}, pale{0.86, 0.86, 0.86},
    white{1, 1, 1}, red{0.80, 0.10, 0.10}, blue{0.10, 0.30, 0.75}, green{0.05, 0.50, 0.20},
    orange{0.93, 0.50, 0.05}, violet{0.50, 0.20, 0.60};

class Figure {
 public:
  Figure(int width, int height, Colour paper = {1, 1, 1});

  /// An image with its top left at (x, y), enlarged by `scale`.
  void image(const gelight::Image<gelight::Rgb8>& pixels, double x, double y, double scale = 1);

  struct Box {
    double x, y, width, height;
  };

  /// The same, but only what falls into the box.
  void clipped_image(const gelight::Image<gelight::Rgb8>& pixels, double x, double y, double scale,
                     const Box& box);

  void pen(Colour colour, double width);

  void line(double x0, double y0, double x1, double y1);

  /// A line with a filled head at its end, of the given length.
  void arrow(double x0, double y0, double x1, double y1, double head);

  /// Lines from each point to the next.
  void polyline(std::span<const gelight::Vec2<double>> points);

  /// The inside of a polygon, its colour mixed with what is there.
  void area(std::span<const gelight::Vec2<double>> corners, Colour colour, double opacity = 1);

  void disc(double x, double y, double radius);

  /// Words centred about (x, y), turned a quarter to the left if `upright`.
  void text(const std::string& words, double x, double y, double size, bool upright = false);

  void text(const std::string& words, const gelight::Vec2<double>& at, double size);

  /// Words that begin at x.
  void text_from(const std::string& words, double x, double y, double size);

  /// Words that end at x.
  void text_before(const std::string& words, double x, double y, double size);

  /// All that is on the page.
  [[nodiscard]] gelight::Image<gelight::Rgb8> pixels() const;

  /// The picture as a PNG file.
  [[nodiscard]] std::string png() const;

  /// Throws std::runtime_error with the system's reason, such as a full disk.
  void save(const std::string& path) const;

 private:
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
};
