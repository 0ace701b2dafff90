// Dots that are printed on a gel.

#include "gelight/sensor/printed_dots.hpp"
#include "images.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::PrintedDots;
using Pixels = std::vector<Vec2<double>>;

namespace {

void draw(const PrintedDots& dots, py::handle image, py::handle displacement) {
  OutputImage<Rgb8> out(image, "the image");
  if (displacement.is_none()) {
    without_gil([&] { dots.draw_into(out.view()); });
  } else {
    const PixelImage<Vec2<float>> moved(displacement, "the displacement");
    without_gil([&] { dots.draw_into(out.view(), moved.copy()); });
  }
  out.finish();
}

}  // namespace

void bind_dots(py::module_& m) {
  m.def(
      "dot_grid",
      [](Index columns, Index rows, py::handle first, py::handle step) {
        return array_of(
            gelight::dot_grid(columns, rows, pixel_in(first, "first"), pixel_in(step, "step")));
      },
      "columns"_a, "rows"_a, "first"_a, "step"_a,
      "Pixels on a grid, row after row, float64 (columns * rows, 2): `first` is the column and row "
      "of the first (2,), `step` how far the next is along each (2,). Raises ValueError for a "
      "negative count and for more than 2^24 dots.");
  py::class_<PrintedDots>(m, "PrintedDots",
                          "The dots that are printed on a sensor's gel, drawn into its image where "
                          "the gel takes them: foreshortened, stretched and bent as its surface.")
      .def(py::init([](const Camera& camera, py::handle rest_depth, py::handle centres,
                       double radius, const std::array<double, 3>& ink) {
             const DepthImage depth(rest_depth, "the rest depth");
             const auto rows = rows_in<double, 2>(centres, "centres");
             Pixels pixels;
             for (const auto& [x, y] : rows_of<2>(rows)) pixels.emplace_back(x, y);
             return without_gil(
                 [&] { return PrintedDots(camera, depth.view(), pixels, radius, ink); });
           }),
           "camera"_a, "rest_depth"_a, "centres"_a, "radius"_a,
           "ink"_a = std::array<double, 3>{0.1, 0.1, 0.1},
           "rest_depth: (h, w), m. centres: columns and rows at rest, (n, 2), between pixels, too. "
           "radius: m. ink: the share of each channel's light that a dot leaves, 0 to 1.")
      .def_property_readonly(
          "centres", [](const PrintedDots& dots) { return array_of(Pixels(dots.centres())); },
          "Where the dots are at rest: columns and rows, float64 (n, 2).")
      .def("draw_into", &draw, "image"_a, "displacement"_a = py::none(),
           "Draws the dots on the image of a gel, uint8 (h, w, 3). displacement: how many columns "
           "and rows each pixel's marker moves, (h, w, 2), NaN where unknown; by default none "
           "does.");
}
