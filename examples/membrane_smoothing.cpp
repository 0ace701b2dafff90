// Smoothing as a membrane: how gel bulges around what is pressed into it.
//
//      gel at rest  ________        ________      An object comes nearer than the membrane at rest
//                           \.    ./              by a protrusion p. Blurred by a Gaussian G it is
//      membrane               \__/                the bulge of the gel; but on the object
//                             |  |  object        the membrane lies:
//                                                     depth = min(object, rest - G * p)

#include <cmath>
#include <vector>

#include "gelight/image/filter.hpp"
#include "gelight/membrane/elastic.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Vec2;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "membrane_smoothing");

  // A cut across a rod and the edge of a broad block, both pressed in by 2 mm: one row of pixels.
  const Index width = 400;
  const double rest = 0.030, pressed = 0.002;
  const Image<double> gel(width, 1, rest);
  Image<double> object(width, 1, 1.0);  // metres: what does not touch is far away
  for (Index x = 0; x < width; ++x) {
    const double from_rod = x - 100;
    if (std::abs(from_rod) < 30) {
      object(x, 0) = rest - pressed * std::sqrt(1 - from_rod * from_rod / 900);
    }
    if (x >= 250) object(x, 0) = rest - pressed;
  }
  const auto indentation = [&](const Image<double>& depth) {
    std::vector<Vec2<double>> curve;
    for (Index x = 0; x < width; ++x)
      curve.emplace_back(x, 1000 * std::max(0.0, rest - depth(x, 0)));
    return curve;
  };

  Figure figure(1000, 420);
  Plot plot(figure, {80, 50, 880, 290}, "A rod and a block in gel, cut across",
            {"pixels", 0, width}, {"pressed in, mm", 0, 2.5});
  const auto contact = indentation(object);
  std::vector<Vec2<double>> outline{plot.on_page({0, 0})};
  for (const auto& p : contact) outline.push_back(plot.on_page(p));
  outline.push_back(plot.on_page({width, 0}));
  figure.area(outline, pale);
  figure.pen(grey, 1);
  figure.text("rod", plot.on_page({100, 0.5}), 15);
  figure.text("block", plot.on_page({325, 1}), 15);

  bool is_pressed = true, is_step = true, is_at_rest = true;
  const std::array<std::pair<double, Colour>, 3> widths{{{3, blue}, {10, green}, {25, orange}}};
  for (const auto& [sigma, colour] : widths) {
    const auto radius = static_cast<Index>(4 * sigma);
    const auto bulge = indentation(gelight::elastic_depth(object, gel, sigma, radius));
    plot.curve(bulge, colour, "sigma = " + std::to_string(static_cast<int>(sigma)) + " pixels");
    for (Index x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      is_pressed = is_pressed && bulge[i][1] >= contact[i][1];
      // Beside the block, out of the rod's reach, a blurred step: the error function.
      if (x > 130 + radius && x < 250) {
        const double step = 1000 * pressed * 0.5 * std::erfc((249.5 - x) / (sigma * std::sqrt(2)));
        is_step = is_step && std::abs(bulge[i][1] - step) < 0.005;
      }
      if (x > 130 + radius && x < 250 - radius) is_at_rest = is_at_rest && bulge[i][1] == 0;
    }
  }
  lesson.expect(is_pressed, "the gel is never less pressed in than the object is");
  lesson.expect(is_step, "beside a straight edge it bulges as the error function");
  lesson.expect(is_at_rest, "out of the Gaussian's reach it is at rest, exactly");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
