// How far images lie apart.

#include "gelight/image/similarity.hpp"

#include "images.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::LevelDifference;

namespace {

// Calls compare(a, b) with two images.
template <class Compare>
auto compared(py::handle a, py::handle b, const Compare& compare) {
  const PixelImage<Rgb8> one(a, "one image"), other(b, "the other image");
  return without_gil([&] { return compare(one.view(), other.view()); });
}

}  // namespace

void bind_similarity(py::module_& m) {
  py::class_<LevelDifference>(m, "LevelDifference",
                              "How far two 8-bit images lie apart. A pixel's difference is that of "
                              "its worst channel.")
      .def_property_readonly(
          "pixels",
          [](const py::object& self) {
            const auto& pixels = self.cast<const LevelDifference&>().pixels;
            return read_only(py::array_t<std::int64_t>(static_cast<py::ssize_t>(pixels.size()),
                                                       pixels.data(), self));
          },
          "How many pixels differ by so many levels, int64 (256,).")
      .def_readonly("worst", &LevelDifference::worst, "Levels.")
      .def_readonly("mean", &LevelDifference::mean, "Levels, over all pixels.")
      .def("beyond", &LevelDifference::beyond, "levels"_a,
           "How many pixels differ by more than so many levels.");
  m.def(
      "level_difference",
      [](py::handle a, py::handle b) {
        return compared(a, b, [](const auto& p, const auto& q) { return level_difference(p, q); });
      },
      "a"_a, "b"_a,
      "Counts by how many grey levels two images differ, both uint8 (h, w, 3). Raises ValueError "
      "for different sizes.");
  m.def(
      "psnr",
      [](py::handle a, py::handle b) {
        return compared(a, b, [](const auto& p, const auto& q) { return gelight::psnr(p, q); });
      },
      "a"_a, "b"_a,
      "The peak signal-to-noise ratio of two images, uint8 (h, w, 3), in decibels, over all "
      "channels; +inf where they are equal. Raises ValueError for different sizes.");
  m.def(
      "ssim",
      [](py::handle a, py::handle b) {
        return compared(a, b, [](const auto& p, const auto& q) { return gelight::ssim(p, q); });
      },
      "a"_a, "b"_a,
      "The mean structural similarity of two images, uint8 (h, w, 3), averaged over the channels: "
      "1 where they are equal. Window: a Gaussian of sigma 1.5 cut off at 5 pixels, K1 = 0.01, K2 "
      "= 0.03 (Wang, Bovik, Sheikh, Simoncelli 2004, doi:10.1109/TIP.2003.819861). Raises "
      "ValueError for different sizes and for images without pixels.");
}
