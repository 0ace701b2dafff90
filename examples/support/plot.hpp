#pragma once

#include <string>
#include <vector>

#include "figure.hpp"

// Curves over two axes.

struct Axis {
  std::string label;
  double from, to;
  bool is_logarithmic = false;

  /// Where a value lies between the axis' ends, from 0 to 1.
  [[nodiscard]] double share(double value) const;

  /// The values that are marked: powers of ten, or about five round numbers.
  [[nodiscard]] std::vector<double> marks() const;
};

class Plot {
 public:
  /// Axes around a box of the page; their labels stand outside it.
  Plot(Figure& figure, const Figure::Box& box, const std::string& title, Axis x, Axis y);

  /// A line through points, and its name among those of the other curves.
  void curve(const std::vector<gelight::Vec2<double>>& points, Colour colour,
             const std::string& name, double width = 2);

  void dots(const std::vector<gelight::Vec2<double>>& points, Colour colour, double radius = 4);

  /// Words to the right of a point.
  void label(const gelight::Vec2<double>& p, Colour colour, const std::string& words);

  [[nodiscard]] gelight::Vec2<double> on_page(const gelight::Vec2<double>& p) const;

 private:
  static std::string number(double value);

  Figure& figure_;
  Figure::Box box_;
  Axis x_, y_;
  double names_at_;
};
