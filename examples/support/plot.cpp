#include "plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

double Axis::share(double value) const {
  if (is_logarithmic) return std::log(value / from) / std::log(to / from);
  return (value - from) / (to - from);
}

std::vector<double> Axis::marks() const {
  std::vector<double> marks;
  if (is_logarithmic) {
    for (double e = std::ceil(std::log10(from) - 1e-9); e <= std::log10(to) + 1e-9; ++e) {
      marks.push_back(std::pow(10, e));
    }
    return marks;
  }
  const double rough = (to - from) / 5, power = std::pow(10, std::floor(std::log10(rough)));
  const double digit = rough / power;
  const double step = power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
  const double first = std::ceil(from / step - 1e-9), last = std::floor(to / step + 1e-9);
  for (double k = first; k <= last; ++k) marks.push_back(k == 0 ? 0 : k * step);  // never -0
  return marks;
}

Plot::Plot(Figure& figure, const Figure::Box& box, const std::string& title, Axis x, Axis y)
    : figure_(figure), box_(box), x_(std::move(x)), y_(std::move(y)), names_at_(box.y + 16) {
  const double bottom = box.y + box.height;
  for (const double mark : x_.marks()) {
    const double at = box.x + x_.share(mark) * box.width;
    figure.pen(pale, 1);
    figure.line(at, box.y, at, bottom);
    figure.pen(black, 1);
    figure.text(number(mark), at, bottom + 13, 12);
  }
  std::size_t longest = 0;
  for (const double mark : y_.marks()) {
    longest = std::max(longest, number(mark).size());
    const double at = bottom - y_.share(mark) * box.height;
    figure.pen(pale, 1);
    figure.line(box.x, at, box.x + box.width, at);
    figure.pen(black, 1);
    figure.text_before(number(mark), box.x - 6, at, 12);
  }
  figure.pen(black, 1);
  figure.line(box.x, bottom, box.x + box.width, bottom);
  figure.line(box.x, box.y, box.x, bottom);
  figure.text(x_.label, box.x + box.width / 2, bottom + 33, 14);
  figure.text(y_.label, box.x - std::max(46.0, 20 + 8.0 * static_cast<double>(longest)),
              box.y + box.height / 2, 14, true);
  figure.text(title, box.x + box.width / 2, box.y - 16, 16);
}

void Plot::curve(const std::vector<gelight::Vec2<double>>& points, Colour colour,
                 const std::string& name, double width) {
  std::vector<gelight::Vec2<double>> line;
  for (const auto& p : points) line.push_back(on_page(p));
  figure_.pen(colour, width);
  figure_.polyline(line);
  if (name.empty()) return;
  figure_.line(box_.x + 12, names_at_, box_.x + 34, names_at_);
  figure_.text_from(name, box_.x + 40, names_at_, 13);
  names_at_ += 19;
}

void Plot::dots(const std::vector<gelight::Vec2<double>>& points, Colour colour, double radius) {
  figure_.pen(colour, 1);
  for (const auto& p : points) figure_.disc(on_page(p)[0], on_page(p)[1], radius);
}

void Plot::label(const gelight::Vec2<double>& p, Colour colour, const std::string& words) {
  figure_.pen(colour, 1);
  figure_.text_from(words, on_page(p)[0] + 8, on_page(p)[1], 14);
}

gelight::Vec2<double> Plot::on_page(const gelight::Vec2<double>& p) const {
  const double x = std::clamp(x_.share(p[0]), 0.0, 1.0);
  const double y = std::clamp(y_.share(p[1]), 0.0, 1.0);
  return {box_.x + x * box_.width, box_.y + (1 - y) * box_.height};
}

std::string Plot::number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}
