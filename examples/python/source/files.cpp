// Images and presses in files.

#include <tuple>

#include "gelight/io/image.hpp"
#include "gelight/io/presses.hpp"
#include "images.hpp"
#include "topics.hpp"

using namespace py::literals;

void bind_files(py::module_& m) {
  m.def(
      "read_png",
      [](const py::object& path) {
        const std::string name = path_in(path);
        return array_of(without_gil([&] { return gelight::read_png(name); }));
      },
      "path"_a,
      "Reads a PNG file as uint8 (h, w, 3); grey is repeated, opacity dropped. Raises ValueError "
      "where the file is missing or is not a whole PNG image.");
  m.def(
      "read_depth_png",
      [](const py::object& path, float unit) {
        const std::string name = path_in(path);
        return array_of(without_gil([&] { return gelight::read_depth_png(name, unit); }));
      },
      "path"_a, "unit"_a,
      "Reads a grey 16-bit PNG file as a depth map, float32 (h, w): each value times `unit`, the "
      "depth of one step; 0 stays 0, which is not known. Raises ValueError for a unit that is not "
      "positive and finite, and where the file is missing, is not a whole PNG image, or is in "
      "colour or in 8 bits.");
  m.def(
      "write_png",
      [](const py::object& path, py::handle image) {
        const std::string name = path_in(path);
        const PixelImage<Rgb8> pixels(image, "the image");
        without_gil([&] {
          gelight::write_png(name, pixels.view());
          return 0;
        });
      },
      "path"_a, "image"_a,
      "Writes an image, uint8 (h, w, 3), as a PNG file. Raises ValueError for an image without "
      "pixels, for a name with the ending of another image format, and where the file cannot be "
      "written.");
  m.def(
      "read_presses",
      [](const py::object& folder) {
        const std::string name = path_in(folder);
        auto read = without_gil([&] { return gelight::read_presses(name); });
        return std::make_tuple(array_of(std::move(read.background)), std::move(read.presses));
      },
      "folder"_a,
      "What `calibrate` takes, the photograph without contact and a list of BallPresses: of a "
      "folder with background.png, photographs, and presses.csv with a line of names and then, for "
      "each photograph, image, center_x_px, center_y_px, contact_radius_px, ball_radius_mm, "
      "mm_per_px; the three of the circle may be empty. Raises ValueError, naming file and line, "
      "for what is missing or not a number.");
}
