// The camera behind a half-silvered membrane.

#include "gelight/sensor/see_through.hpp"

#include "images.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::LightLevels;
using gelight::SeeThroughOptions;
using Light = gelight::Light<float>;
using Renderer = gelight::SeeThroughRenderer<float>;

namespace {

void bind_options(py::module_& m) {
  py::class_<LightLevels>(
      m, "LightLevels",
      "How bright it is on the two sides of a half-silvered membrane, as shares "
      "of full light.")
      .def(py::init([](double inner, double outer) {
             return LightLevels{inner, outer};
           }),
           "inner"_a = 0.5, "outer"_a = 0.5)
      .def_static("tactile", &LightLevels::tactile, "LEDs on, dark outside.")
      .def_static("visual", &LightLevels::visual, "LEDs off: a camera.")
      .def_static("visuotactile", &LightLevels::visuotactile, "Both at once.")
      .def_readwrite("inner", &LightLevels::inner, "The LEDs.")
      .def_readwrite("outer", &LightLevels::outer, "What lies beyond the membrane.");
  const SeeThroughOptions d;
  py::class_<SeeThroughOptions>(m, "SeeThroughOptions",
                                "How a SeeThroughRenderer turns a depth map into an image.")
      .def(py::init([](double thickness, Index normal_radius, double ambient, double darkening,
                       double darkening_depth, double reflectance, double transmittance,
                       double exposure, const LightLevels& levels) {
             return SeeThroughOptions{thickness,     normal_radius,   ambient,
                                      darkening,     darkening_depth, reflectance,
                                      transmittance, exposure,        levels};
           }),
           py::kw_only(), "thickness"_a = d.thickness, "normal_radius"_a = d.normal_radius,
           "ambient"_a = d.ambient, "darkening"_a = d.darkening,
           "darkening_depth"_a = d.darkening_depth, "reflectance"_a = d.reflectance,
           "transmittance"_a = d.transmittance, "exposure"_a = d.exposure, "levels"_a = d.levels)
      .def_readwrite("thickness", &SeeThroughOptions::thickness,
                     "How far the gel can be pressed in, in the unit of the depth.")
      .def_readwrite("normal_radius", &SeeThroughOptions::normal_radius,
                     "Normals are fitted to (2 radius + 1)^2 neighbours.")
      .def_readwrite("ambient", &SeeThroughOptions::ambient, "Of Phong's equation.")
      .def_readwrite("darkening", &SeeThroughOptions::darkening,
                     "The share of its light that gel loses which is pressed in.")
      .def_readwrite("darkening_depth", &SeeThroughOptions::darkening_depth,
                     "Where that is full, in the unit of the depth.")
      .def_readwrite("reflectance", &SeeThroughOptions::reflectance,
                     "The share of light that the coating throws back.")
      .def_readwrite("transmittance", &SeeThroughOptions::transmittance,
                     "The share of light that it lets through.")
      .def_readwrite("exposure", &SeeThroughOptions::exposure, "The camera's gain.")
      .def_readwrite("levels", &SeeThroughOptions::levels, "Where `render` is not told.");
}

void render_visible(const Renderer& self, ImageView<Rgb8> out, const DepthImage& depth,
                    py::handle visual, const LightLevels& levels) {
  const auto render = [&](const auto& seen) {
    without_gil([&] {
      self.render_into(out, depth.view(), seen.view(), levels);
      return 0;
    });
  };
  const py::array array = array_in(visual, "fu", "the visual image");
  if (has_type<std::uint8_t>(array)) {
    render(PixelImage<Rgb8>(array, "the visual image"));
  } else {
    render(PixelImage<std::array<float, 3>>(array, "the visual image"));
  }
}

void render_into(const Renderer& self, ImageView<Rgb8> out, py::handle depth, py::handle visual,
                 const std::optional<LightLevels>& levels) {
  const DepthImage image(depth);
  if (!visual.is_none()) {
    return render_visible(self, out, image, visual, levels.value_or(self.options().levels));
  }
  gelight::detail::require(!levels, "there are light levels, but nothing to be seen beyond");
  without_gil([&] {
    self.render_into(out, image.view());
    return 0;
  });
}

}  // namespace

void bind_see_through(py::module_& m) {
  bind_options(m);
  m.def("edge_lights", &gelight::edge_lights<float>, "camera"_a, "tilt"_a,
        "Four lights at the image's edges, each shining straight across the gel and `tilt` radians "
        "towards it, a list of Lights.");
  py::class_<Renderer>(
      m, "SeeThroughRenderer",
      "Renders the image of a camera behind a half-silvered membrane: a tactile sensor where it is "
      "lit inside, a camera where it is bright outside (Hogan et al., Seeing Through your Skin, "
      "2021, doi:10.1109/WACV48630.2021.00126). May be used from several threads.")
      .def(
          py::init([](const Camera& camera, py::handle rest_depth, const std::vector<Light>& lights,
                      py::handle background, const SeeThroughOptions& options) {
            const DepthImage rest(rest_depth, "the rest depth image");
            const Background seen = background_in(background);
            return without_gil([&] {
              return std::make_unique<Renderer>(camera, rest.view(), lights, seen, options);
            });
          }),
          "camera"_a, "rest_depth"_a, "lights"_a,
          "background"_a = std::array<float, 3>{0.7f, 0.7f, 0.8f},
          "options"_a = SeeThroughOptions{})
      .def_property_readonly(
          "camera", [](const Renderer& self) { return self.camera(); },
          "The camera that it was built with.")
      .def_property_readonly(
          "rest_image",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const Renderer&>().rest_image(), self));
          },
          "The image of the membrane that nothing touches, uint8 (h, w, 3).")
      .def(
          "render",
          [](const Renderer& self, py::handle depth, py::handle visual,
             const std::optional<LightLevels>& levels) {
            Image<Rgb8> out(self.camera().width, self.camera().height);
            render_into(self, out, depth, visual, levels);
            return array_of(std::move(out));
          },
          "depth"_a, "visual"_a = py::none(), "levels"_a = py::none(),
          "The image uint8 (h, w, 3) of a depth map (h, w). visual: what a camera would see "
          "without "
          "the membrane, (h, w, 3), uint8 or float32 in shares of full light.")
      .def(
          "render_into",
          [](const Renderer& self, py::handle out, py::handle depth, py::handle visual,
             const std::optional<LightLevels>& levels) {
            OutputImage<Rgb8> to(out, "the output image");
            render_into(self, to.view(), depth, visual, levels);
            to.finish();
          },
          "out"_a, "depth"_a, "visual"_a = py::none(), "levels"_a = py::none(),
          "The same into the caller's pixels, uint8 (h, w, 3), at any strides.");
}
