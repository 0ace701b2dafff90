// Sensors as somebody built them.

#include "gelight/sensor/presets.hpp"

#include "gelight/light/models.hpp"
#include "points.hpp"
#include "renderer.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::Falloff;
using gelight::Gel;
using gelight::TactileOptions;
using Preset = gelight::SensorPreset<float>;
using Colour = std::array<float, 3>;

namespace {

gelight::Mesh<float> mesh_of(const Surface& surface) {
  gelight::Mesh<float> mesh;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const auto p = surface.position(v).cast<float>();
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (Index f = 0; f < surface.face_count(); ++f) mesh.faces.push_back(surface.face(f));
  return mesh;
}

template <class T>
std::vector<gelight::SurfacePoint<T>> leds_in(py::handle leds) {
  return cast_points<T>(points_or_places_in(leds, py::none()));
}

std::vector<Point> leds_of(const Preset& preset) {
  std::vector<Point> out;
  for (const auto& led : preset.leds) out.push_back(led.cast<double>());
  return out;
}

void bind_preset(py::module_& m) {
  py::class_<Falloff<float>>(m, "Falloff", "How light grows weaker on its way.")
      .def(py::init([](float full_within, float absorption) {
             return Falloff<float>{full_within, absorption};
           }),
           "full_within"_a = gelight::unreachable<float>, "absorption"_a = 0.0f,
           "full_within: a distance, beyond which light spreads; absorption: per unit of it.")
      .def_readwrite("full_within", &Falloff<float>::full_within, "In the unit of the positions.")
      .def_readwrite("absorption", &Falloff<float>::absorption, "Per unit of the positions.");
  const Preset d;
  py::class_<Preset>(m, "SensorPreset", "A sensor in metres and in the frame of its camera.")
      .def(py::init([](const Surface& membrane, const Camera& camera, py::handle leds,
                       const std::vector<Colour>& colours) {
             Preset preset;
             preset.membrane = mesh_of(membrane);
             preset.camera = camera;
             preset.leds = leds_in<float>(leds);
             preset.colours = colours;
             return preset;
           }),
           "membrane"_a, "camera"_a, "leds"_a, "colours"_a,
           "One of your own: its membrane at rest, the camera inside it, where on the membrane "
           "light enters (vertices or SurfacePoints), and each LED's colour in shares of full "
           "light.")
      .def_property(
          "membrane", [](const Preset& p) { return Surface(p.membrane); },
          [](Preset& p, const Surface& surface) { p.membrane = mesh_of(surface); },
          "At rest, seen from inside.")
      .def_readwrite("camera", &Preset::camera, "Inside it.")
      .def_property(
          "leds", &leds_of, [](Preset& p, py::handle leds) { p.leds = leds_in<float>(leds); },
          "Where on the membrane light enters, a list of SurfacePoints.")
      .def_readwrite("colours", &Preset::colours, "Of each LED, in shares of full light.")
      .def_readwrite("coating", &Preset::coating, "What the coating reflects of each colour.")
      .def_readwrite("falloff", &Preset::falloff, "How scattered light fades.")
      .def_readwrite("diffuse", &Preset::diffuse, "Phong's k_d.")
      .def_readwrite("specular", &Preset::specular, "Phong's k_s.")
      .def_readwrite("shininess", &Preset::shininess, "Phong's exponent.")
      .def_readwrite("options", &Preset::options, "But for `rectify`, which follows the light.")
      .def_readwrite("gel", &Preset::gel, "What the membrane is made of.")
      .def_readwrite("led_width", &Preset::led_width,
                     "Of each LED, m along the border; 0: a point; None: what suits the light.")
      .def_readwrite("led_parts", &Preset::led_parts, "Points that stand for a wide LED.")
      .def_readwrite("full_within", &Preset::full_within,
                     "How far from an LED its light is full, in m, for a gel_light.");
}

using Made = gelight::TactileRenderer<float>;

template <class Model>
bool render_by(std::unique_ptr<AnyRenderer>& out, const Preset& preset, py::handle light) {
  if (!py::isinstance<Model>(light)) return false;
  const auto& model = light.cast<const Model&>();
  out = without_gil(
      [&] { return std::make_unique<RendererOf<Made>>(gelight::tactile_renderer(preset, model)); });
  return true;
}

std::unique_ptr<AnyRenderer> renderer_of(const Preset& preset, py::handle light) {
  if (light.is_none()) {
    return without_gil(
        [&] { return std::make_unique<RendererOf<Made>>(gelight::tactile_renderer(preset)); });
  }
  std::unique_ptr<AnyRenderer> out;
  if (render_by<gelight::LinearLight<float>>(out, preset, light) ||
      render_by<gelight::PlaneLight<float>>(out, preset, light) ||
      render_by<gelight::GeodesicLight<float>>(out, preset, light) ||
      render_by<gelight::TransportLight<float>>(out, preset, light) ||
      render_by<gelight::GelLight<float>>(out, preset, light)) {
    return out;
  }
  throw py::type_error(py::repr(light).cast<std::string>() + " is no light model");
}

}  // namespace

void bind_presets(py::module_& m) {
  bind_preset(m);
  m.def("geltip", &gelight::geltip<float>, "width"_a = 640, "height"_a = 480,
        "edge_length"_a = 0.001f,
        "The GelTip: a finger with a camera in the middle of its open end that looks at the tip, "
        "and three LEDs on the rim. Image size in pixels, the mesh's edges in m.");
  m.def("gelsight_mini", &gelight::gelsight_mini<float>, "width"_a = 640, "height"_a = 480,
        "edge_length"_a = 0.0005f,
        "GelSight Mini: a flat gel of which the camera sees 18.6 x 14.3 mm.");
  m.def("digit", &gelight::digit<float>, "width"_a = 240, "height"_a = 320,
        "edge_length"_a = 0.0005f, "DIGIT: a pad of 20 x 30 mm, bent with a radius of 100 mm.");
  m.def("sts", &gelight::sts<float>, "width"_a = 640, "height"_a = 480, "edge_length"_a = 0.001f,
        "The see-through sensor, lit inside: a flat gel with light from four sides.");
  m.def("gel_light", &gelight::gel_light<float>, "sensor"_a,
        "A GelLight of a sensor's gel, exposed as the preset is.",
        py::call_guard<py::gil_scoped_release>());
  m.def("tactile_renderer", &renderer_of, "sensor"_a, "light"_a = py::none(),
        "The TactileRenderer of a sensor, its light by any light model of its membrane; by default "
        "a GeodesicLight.");
}
