// How far the dots that are printed on a gel move in the camera's image.

#include "gelight/membrane/markers.hpp"

#include "by_value.hpp"
#include "images.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::DraggedMarkers;
using gelight::GaussianMarkers;
using Touched = GaussianMarkers::Touched;

template <>
struct Kept<std::vector<Touched>> {
  using Numbers = Kept<std::vector<Vec3<double>>>;
  using State = Numbers::State;
  static State state(const std::vector<Touched>& dots) {
    std::vector<Vec3<double>> rows;
    for (const Touched& dot : dots) rows.emplace_back(dot.pixel.x(), dot.pixel.y(), dot.push);
    return Numbers::state(rows);
  }
  static std::vector<Touched> value(const State& state) {
    std::vector<Touched> dots;
    for (const auto& row : Numbers::value(state)) dots.push_back({{row[0], row[1]}, row[2]});
    return dots;
  }
};

namespace {

// Of pixels in an array of any shape (..., 2), one by one.
template <class Markers>
py::array_t<double> moved_by(const Markers& markers, py::handle object) {
  const py::array array = array_in(object, "fiu", "pixels");
  gelight::detail::require(array.ndim() >= 1 && array.shape(array.ndim() - 1) == 2,
                           "pixels has shape ", shape_text(array), ", not (..., 2)");
  const Packed<double> pixels(array);
  std::vector<Vec2<double>> moved(static_cast<std::size_t>(pixels.size() / 2));
  without_gil([&] {
    const double* at = pixels.data();
    for (Vec2<double>& by : moved) {
      by = markers(Vec2<double>(at[0], at[1]));
      at += 2;
    }
    return 0;
  });
  return array_of<double>(std::move(moved), {array.shape(), array.shape() + array.ndim()});
}

template <class Markers>
void bind_field(py::class_<Markers>& markers) {
  markers
      .def("__call__", &moved_by<Markers>, "pixels"_a,
           "How far markers move that were at some pixels, columns and rows, (..., 2): float64 "
           "(..., 2).")
      .def(
          "image",
          [](const Markers& self, Index width, Index height) {
            return array_of(without_gil(
                [&] { return gelight::marker_displacement<float>(width, height, self); }));
          },
          "width"_a, "height"_a,
          "How far every pixel's marker moves, float32 (h, w, 2), as PrintedDots.draw_into takes "
          "it. Raises ValueError for a negative size.");
}

void bind_dragged(py::module_& m) {
  py::class_<DraggedMarkers> dragged(
      m, "DraggedMarkers",
      "A dragged contact's markers in closed form: the far field of a sideways force on a "
      "half-space, made round at the centre (Johnson, Contact Mechanics, 1985, "
      "doi:10.1017/CBO9781139171731, section 3.6). Everything in pixels.");
  dragged
      .def(py::init([](py::handle centre, py::handle shift, double reach, double stretch) {
             const DraggedMarkers markers{pixel_in(centre, "centre"), pixel_in(shift, "shift"),
                                          reach, stretch};
             markers.require_valid();
             return markers;
           }),
           "centre"_a, "shift"_a, "reach"_a = 1.0, "stretch"_a = 0.0,
           "centre: column and row (2,); shift of what touches the gel (2,). Each dot r away moves "
           "by reach (shift / rho + stretch r (r . shift) / rho^3), rho^2 = |r|^2 + reach^2. "
           "Raises ValueError for a reach that is not positive, and for what is not finite.")
      .def_static(
          "of_disc",
          [](py::handle centre, py::handle shift, double radius, double poisson_ratio) {
            return DraggedMarkers::of_disc(pixel_in(centre, "centre"), pixel_in(shift, "shift"),
                                           radius, poisson_ratio);
          },
          "centre"_a, "shift"_a, "radius"_a, "poisson_ratio"_a,
          "Those of a disc of that radius in pixels that sticks to a half-space: far away the same "
          "as Mindlin's exact solution (1949, doi:10.1115/1.4009973). Raises ValueError for a "
          "radius that is not positive and a Poisson ratio outside of 0 to 0.5.")
      .def_property_readonly(
          "centre", [](const DraggedMarkers& d) { return array_of(d.centre); },
          "Column and row, float64 (2,).")
      .def_property_readonly(
          "shift", [](const DraggedMarkers& d) { return array_of(d.shift); },
          "Of what touches the gel, float64 (2,), pixels.")
      .def_readonly("reach", &DraggedMarkers::reach, "Pixels.")
      .def_readonly("stretch", &DraggedMarkers::stretch, "Of no unit.");
  bind_field(dragged);
  keep_by_value(&DraggedMarkers::centre, &DraggedMarkers::shift, &DraggedMarkers::reach,
                &DraggedMarkers::stretch);
}

void bind_gaussian(py::module_& m) {
  py::class_<GaussianMarkers> fitted(
      m, "GaussianMarkers",
      "Three Gaussians that are fitted to a sensor: dots that are touched push the others away, "
      "and drag and turn them along (Zhao, Qian, Duan, Luo 2024, "
      "doi:10.48550/arXiv.2404.19217). Everything in pixels.");
  fitted
      .def(py::init([](py::handle touched, py::handle centre, py::handle shift, double twist,
                       double push_decay, double shift_decay, double twist_decay) {
             return GaussianMarkers{
                 Kept<std::vector<Touched>>::value(rows_in<double, 3>(touched, "touched")),
                 pixel_in(centre, "centre"),
                 pixel_in(shift, "shift"),
                 twist,
                 push_decay,
                 shift_decay,
                 twist_decay};
           }),
           "touched"_a, "centre"_a, py::kw_only(), "shift"_a = py::make_tuple(0, 0),
           "twist"_a = 0.0, "push_decay"_a = 0.0, "shift_decay"_a = 0.0, "twist_decay"_a = 0.0,
           "touched: column, row and push of each dot that is touched, (n, 3); the push is how far "
           "each pixel away from it is pushed close by. centre, shift: of the object, (2,). twist "
           "in radians from x to y. Decays per square of pixels.")
      .def_property_readonly(
          "touched",
          [](const GaussianMarkers& g) { return Kept<std::vector<Touched>>::state(g.touched); },
          "Column, row and push of each dot that is touched, float64 (n, 3).")
      .def_property_readonly(
          "centre", [](const GaussianMarkers& g) { return array_of(g.centre); },
          "Column and row of the object, float64 (2,).")
      .def_property_readonly(
          "shift", [](const GaussianMarkers& g) { return array_of(g.shift); },
          "Of the object, float64 (2,), pixels.")
      .def_readonly("twist", &GaussianMarkers::twist, "Of the object, radians from x to y.")
      .def_readonly("push_decay", &GaussianMarkers::push_decay, "Per square of pixels.")
      .def_readonly("shift_decay", &GaussianMarkers::shift_decay, "Per square of pixels.")
      .def_readonly("twist_decay", &GaussianMarkers::twist_decay, "Per square of pixels.");
  bind_field(fitted);
  keep_by_value(&GaussianMarkers::touched, &GaussianMarkers::centre, &GaussianMarkers::shift,
                &GaussianMarkers::twist, &GaussianMarkers::push_decay,
                &GaussianMarkers::shift_decay, &GaussianMarkers::twist_decay);
}

std::vector<Vec2<float>> pixels_in(py::handle object) {
  const auto rows = rows_in<double, 2>(object, "pixels");
  std::vector<Vec2<float>> pixels;
  for (const auto& [x, y] : rows_of<2>(rows)) {
    pixels.emplace_back(static_cast<float>(x), static_cast<float>(y));
  }
  return pixels;
}

}  // namespace

void bind_markers(py::module_& m) {
  bind_dragged(m);
  bind_gaussian(m);
  m.def(
      "marker_displacement",
      [](const Camera& camera, py::handle rest_depth, py::handle displacement,
         py::handle pixels) -> py::array {
        const DepthImage rest(rest_depth, "the rest depth");
        const PixelImage<Vec3<float>> by(displacement, "the displacement");
        if (pixels.is_none()) {
          return array_of(without_gil(
              [&] { return gelight::marker_displacement(camera, rest.view(), by.view()); }));
        }
        const auto at = pixels_in(pixels);
        return array_of(without_gil([&] {
          return gelight::marker_displacement<float>(camera, rest.view(), by.view(), at);
        }));
      },
      "camera"_a, "rest_depth"_a, "displacement"_a, "pixels"_a = py::none(),
      "How far every pixel's marker moves in the image, float32 (h, w, 2), in pixels, when the "
      "point of the gel that it marks moves; NaN where that is not known.\n\n"
      "rest_depth (h, w), m; displacement (h, w, 3) of the gel's points in the camera's frame, m, "
      "as a LayerContact has it. pixels: of markers at these columns and rows alone, (n, 2), "
      "between pixels, too: float32 (n, 2), a few operations a marker. Raises ValueError for "
      "images "
      "of other sizes than the camera's and a marker outside of the image.");
  m.def(
      "sample_markers",
      [](py::handle displacement, py::handle pixels) {
        const PixelImage<Vec2<float>> image(displacement, "the displacement");
        const auto at = pixels_in(pixels);
        return array_of(without_gil([&] {
          return gelight::sample_markers<float>(image.copy(), std::span<const Vec2<float>>(at));
        }));
      },
      "displacement"_a, "pixels"_a,
      "How far markers move that were at the given columns and rows (n, 2), between pixels, too: "
      "an image's values (h, w, 2), interpolated bilinearly, float32 (n, 2). Raises ValueError for "
      "a marker outside of the image.");
}
