// The image that the camera inside a tactile sensor takes.

#include "any_membrane.hpp"
#include "calibrated.hpp"
#include "gelight/membrane/gel.hpp"
#include "one_at_a_time.hpp"
#include "renderer.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::BorderNormals;
using gelight::FrameOptions;
using gelight::Specular;
using gelight::TactileOptions;
using Light = gelight::Light<float>;
using Phong = gelight::PhongLights<float>;

namespace {

void bind_options(py::module_& m) {
  const TactileOptions d;
  py::class_<TactileOptions>(m, "TactileOptions",
                             "How a TactileRenderer turns a depth map into an image.")
      .def(py::init([](double smoothing_sigma, Index smoothing_radius, bool rectify,
                       bool keep_strength, bool clip_to_rest, double ambient, Specular specular,
                       double darkening, double darkening_depth, BorderNormals border_normals,
                       bool skip_unchanged) {
             return TactileOptions{smoothing_sigma, smoothing_radius, rectify,       keep_strength,
                                   clip_to_rest,    ambient,          specular,      darkening,
                                   darkening_depth, border_normals,   skip_unchanged};
           }),
           py::kw_only(), "smoothing_sigma"_a = d.smoothing_sigma,
           "smoothing_radius"_a = d.smoothing_radius, "rectify"_a = d.rectify,
           "keep_strength"_a = d.keep_strength, "clip_to_rest"_a = d.clip_to_rest,
           "ambient"_a = d.ambient, "specular"_a = d.specular, "darkening"_a = d.darkening,
           "darkening_depth"_a = d.darkening_depth, "border_normals"_a = d.border_normals,
           "skip_unchanged"_a = d.skip_unchanged)
      .def_static("for_gel", &TactileOptions::for_gel, "gel"_a, "contact_radius"_a, "pixel"_a,
                  "With the Gaussian that is nearest to a gel, for contacts of a radius, on pixels "
                  "of a width, both in m.")
      .def_readwrite("smoothing_sigma", &TactileOptions::smoothing_sigma,
                     "Standard deviation of the Gaussian, in pixels.")
      .def_readwrite("smoothing_radius", &TactileOptions::smoothing_radius,
                     "Where it is cut off, in pixels.")
      .def_readwrite("rectify", &TactileOptions::rectify,
                     "Make the lights' directions tangent to the membrane at rest.")
      .def_readwrite("keep_strength", &TactileOptions::keep_strength,
                     "Rectified directions keep their lengths.")
      .def_readwrite("clip_to_rest", &TactileOptions::clip_to_rest,
                     "What lies deeper than the membrane at rest does not pull it.")
      .def_readwrite("ambient", &TactileOptions::ambient,
                     "The share of the background that is seen without any light.")
      .def_readwrite("specular", &TactileOptions::specular, "The form of Phong's specular term.")
      .def_readwrite("darkening", &TactileOptions::darkening,
                     "The share of ambient light that gel loses which is pressed in.")
      .def_readwrite("darkening_depth", &TactileOptions::darkening_depth,
                     "Where that is full, in the unit of the depth.")
      .def_readwrite("border_normals", &TactileOptions::border_normals, "Of the outermost pixels.")
      .def_readwrite("skip_unchanged", &TactileOptions::skip_unchanged,
                     "Compute only what the contact can have changed; the image is the same.");
}

/// A frame and the number of the renderer that made it: where nothing changes another would leave
/// that one's image.
struct OwnFrame {
  Frame frame;
  std::uint64_t renderer;
};

void bind_frame(py::module_& m) {
  py::class_<OwnFrame>(
      m, "TactileFrame",
      "A depth map of what touches the membrane, and the image that a TactileRenderer "
      "made of it. Of one thread at a time.")
      .def_property_readonly(
          "depth",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const OwnFrame&>().frame.depth, self));
          },
          "float32 (h, w): the frame's own memory, which the next frame changes.")
      .def_property_readonly(
          "image",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const OwnFrame&>().frame.image, self));
          },
          "uint8 (h, w, 3): the frame's own memory, which the next frame changes.");
}

std::unique_ptr<AnyRenderer> phong_renderer(const Camera& camera,
                                            const ImageView<const float>& rest_depth,
                                            const std::vector<Light>& lights,
                                            const Background& background,
                                            const TactileOptions& options,
                                            const AnyMembrane* membrane) {
  using Plain = gelight::TactileRenderer<float>;
  using Any = gelight::TactileRenderer<float, AnyMembrane, Phong>;
  if (membrane == nullptr) {
    return std::make_unique<RendererOf<Plain>>(camera, rest_depth, lights, background, options);
  }
  return std::make_unique<RendererOf<Any>>(
      camera, rest_depth, *membrane,
      Phong{lights, background, options.ambient, options.specular, options.rectify,
            options.keep_strength},
      FrameOptions{options.darkening, options.darkening_depth, options.border_normals,
                   options.skip_unchanged});
}

std::unique_ptr<AnyRenderer> renderer_of(const Camera& camera, py::handle rest_depth,
                                         py::handle reflectance, py::handle background,
                                         const TactileOptions& options,
                                         const AnyMembrane* membrane) {
  const DepthImage rest(rest_depth, "the rest depth image");
  if (is_calibrated_sensor(reflectance)) {
    return calibrated_renderer(camera, rest.view(), reflectance, membrane,
                               {options.darkening, options.darkening_depth, options.border_normals,
                                options.skip_unchanged});
  }
  const auto lights = reflectance.cast<std::vector<Light>>();
  const Background seen = background_in(background);
  return without_gil(
      [&] { return phong_renderer(camera, rest.view(), lights, seen, options, membrane); });
}

void render_into(const AnyRenderer& self, py::handle out, py::handle depth) {
  const DepthImage image(depth);
  OutputImage<Rgb8> to(out, "the output image");
  without_gil([&] {
    self.render_into(to.view(), image.view());
    return 0;
  });
  to.finish();
}

void bind_renderer(py::module_& m) {
  py::class_<AnyRenderer>(
      m, "TactileRenderer",
      "Renders the image that the camera inside an optical tactile sensor takes of its lit "
      "membrane "
      "(Gomes, Paoletti, Luo 2023, doi:10.15607/RSS.2023.XIX.035).\n\n"
      "Depths: positive and finite is a surface, +inf is nothing, NaN, zero and negative are not "
      "known. May be used from several threads.")
      .def(py::init(&renderer_of), "camera"_a, "rest_depth"_a, "reflectance"_a,
           "background"_a = py::none(), "options"_a = TactileOptions{}, "membrane"_a = py::none(),
           "rest_depth: of the untouched membrane (h, w). reflectance: a list of Lights, or a "
           "CalibratedSensor. background: what is seen by ambient light, None (black), a colour "
           "(3,) or an image, in shares of full light or uint8. membrane: what the gel does; by "
           "default the Gaussian of the options, or as calibrated.")
      .def_property_readonly(
          "camera", [](const AnyRenderer& self) { return self.camera(); },
          "The camera that it was built with.")
      .def_property_readonly(
          "rest_image",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const AnyRenderer&>().rest_image(), self));
          },
          "The image of the membrane that nothing touches, uint8 (h, w, 3).")
      .def(
          "render",
          [](const AnyRenderer& self, py::handle depth) {
            const DepthImage image(depth);
            return array_of(without_gil([&] {
              Image<Rgb8> out(self.camera().width, self.camera().height);
              self.render_into(out, image.view());
              return out;
            }));
          },
          "depth"_a,
          "The image uint8 (h, w, 3) of a depth map (h, w) of what touches the membrane, in the "
          "unit of the rest depth.")
      .def("render_into", &render_into, "out"_a, "depth"_a,
           "The same into the caller's pixels, uint8 (h, w, 3), at any strides.")
      .def(
          "rest_frame",
          [](const AnyRenderer& self) {
            return OwnFrame{self.rest_frame(), self.number()};
          },
          "The frame of the membrane that nothing touches, to begin a sequence with.")
      .def(
          "render_next_into",
          [](const AnyRenderer& self, OwnFrame& frame, py::handle depth) {
            gelight::detail::require(frame.renderer == self.number(),
                                     "the frame is of another renderer");
            const DepthImage image(depth);
            const OneAtATime alone(&frame, "the frame");
            without_gil([&] {
              self.render_next_into(frame.frame, image.view());
              return 0;
            });
          },
          "frame"_a, "depth"_a,
          "Makes a frame of this renderer the next one of a sequence, that of `depth`: computes "
          "only "
          "what differs from before. Its image is what `render` gives, bit for bit. Raises "
          "ValueError for another renderer's.");
}

}  // namespace

void bind_renderers(py::module_& m) {
  bind_options(m);
  bind_frame(m);
  bind_renderer(m);
}
