// A sensor of one's own, from photographs of a ball pressed into it.

#include "calibrated.hpp"
#include "gelight/membrane/tension.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/calibrated.hpp"
#include "hook.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::BallPress;
using gelight::CalibratedSensor;
using gelight::Calibration;
using gelight::Circle;
using gelight::PressReport;
using gelight::ReflectanceModel;
using gelight::RegionResidual;

bool is_calibrated_sensor(py::handle object) { return py::isinstance<CalibratedSensor>(object); }

std::unique_ptr<AnyRenderer> calibrated_renderer(const Camera& camera,
                                                 const ImageView<const float>& rest_depth,
                                                 py::handle sensor, const AnyMembrane* membrane,
                                                 const gelight::FrameOptions& options) {
  using Shine = gelight::CalibratedReflectance<float>;
  using Renderer = gelight::TactileRenderer<float, AnyMembrane, Shine>;
  const auto& calibrated = sensor.cast<const CalibratedSensor&>();
  return without_gil([&] {
    const AnyMembrane gel =
        membrane != nullptr ? *membrane
                            : AnyMembrane(gelight::TensionMembrane<float>(calibrated.bulge_length));
    return std::make_unique<RendererOf<Renderer>>(camera, rest_depth, gel, Shine(calibrated),
                                                  options);
  });
}

namespace {

py::tuple circle_of(const Circle& circle) {
  return py::make_tuple(circle.x, circle.y, circle.radius);
}

void bind_presses(py::module_& m) {
  py::enum_<ReflectanceModel>(m, "ReflectanceModel", "The reflectances that can be fitted.")
      .value("lights", ReflectanceModel::lights)
      .value("polynomial", ReflectanceModel::polynomial)
      .value("table", ReflectanceModel::table);
  py::class_<BallPress>(m, "BallPress", "A photograph of a ball that is pressed into the gel.")
      .def(py::init([](py::handle photograph, double ball_radius,
                       std::optional<std::array<double, 3>> contact, std::string name) {
             const auto c = contact.value_or(std::array<double, 3>{0, 0, 0});
             return BallPress{std::move(name),
                              PixelImage<Rgb8>(photograph, "the photograph").copy(),
                              Circle{c[0], c[1], c[2]}, ball_radius};
           }),
           "photograph"_a, "ball_radius"_a, "contact"_a = py::none(), "name"_a = "a press",
           "photograph: uint8 (h, w, 3). ball_radius: in pixels. contact: (x, y, radius) where "
           "ball and gel touch, in pixels; searched for where it is not given.")
      .def_readonly("name", &BallPress::name, "What messages call it.")
      .def_readonly("ball_radius", &BallPress::ball_radius, "In pixels.")
      .def_property_readonly(
          "contact", [](const BallPress& p) { return circle_of(p.contact); },
          "(x, y, radius), in pixels.")
      .def_property_readonly(
          "photograph",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const BallPress&>().photograph, self));
          },
          "uint8 (h, w, 3).");
}

void bind_reports(py::module_& m) {
  py::class_<PressReport>(m, "PressReport", "What a fit says of one press.")
      .def_readonly("name", &PressReport::name, "As the press is named.")
      .def_readonly("level", &PressReport::level,
                    "By how much the whole photograph is brighter, grey levels of each channel.")
      .def_property_readonly(
          "contact", [](const PressReport& p) { return circle_of(p.contact); },
          "(x, y, radius), in pixels, as refined.")
      .def_readonly("is_proposed", &PressReport::is_proposed, "The circle was searched for.")
      .def_readonly("fits", &PressReport::fits, "Otherwise left out of the fit.")
      .def_readonly("residual", &PressReport::residual,
                    "Mean absolute, inside of the contact, grey levels.");
  py::class_<RegionResidual>(m, "RegionResidual", "What is left in a part of the image.")
      .def_readonly("region", &RegionResidual::region, "Which pixels, in words.")
      .def_readonly("signal", &RegionResidual::signal, "Of the photographs and the background.")
      .def_readonly("residual", &RegionResidual::residual, "Of the photographs and the model.");
}

void bind_sensor(py::module_& m) {
  py::class_<CalibratedSensor>(m, "CalibratedSensor",
                               "A sensor as it was calibrated: what a file keeps and a "
                               "TactileRenderer takes for its reflectance.")
      .def_property_readonly(
          "background",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const CalibratedSensor&>().background, self));
          },
          "The photograph of the untouched gel, uint8 (h, w, 3).")
      .def_readonly("bulge_length", &CalibratedSensor::bulge_length,
                    "Of a TensionMembrane, pixels.")
      .def_readonly("level", &CalibratedSensor::level,
                    "By how many grey levels photographs of presses are brighter all over.");
  m.def(
      "write_sensor",
      [](const py::object& path, const CalibratedSensor& sensor) {
        gelight::write_sensor(path_in(path), sensor);
      },
      "path"_a, "sensor"_a, "Writes a calibrated sensor to one file.");
  m.def(
      "read_sensor", [](const py::object& path) { return gelight::read_sensor(path_in(path)); },
      "path"_a, "Reads a sensor that write_sensor wrote, a CalibratedSensor.");
  m.def("rim_height", &gelight::rim_height, "contact_radius"_a, "ball_radius"_a, "length"_a,
        "How high above rest the gel stands at the rim of a ball's contact, in pixels as all of "
        "it: so much deeper than its cap a ball goes into a TensionMembrane of that length.");
  m.def(
      "predict",
      [](const CalibratedSensor& sensor, const std::array<double, 3>& contact, double ball_radius) {
        return array_of(without_gil([&] {
          return gelight::predict(sensor, {contact[0], contact[1], contact[2]}, ball_radius);
        }));
      },
      "sensor"_a, "contact"_a, "ball_radius"_a,
      "The photograph, float64 (h, w, 3) in grey levels, that a sensor would take of a ball "
      "pressed "
      "in at (x, y, radius), in pixels.");
}

Calibration calibrated(py::handle background, const std::vector<BallPress>& presses,
                       ReflectanceModel model, int lights, int polynomial_degree, int table_nodes,
                       double bulge_length, bool refine_circles, py::object cancelled) {
  const Image<Rgb8> untouched = PixelImage<Rgb8>(background, "the background").copy();
  gelight::CalibrationOptions options;
  options.model = model;
  options.lights = lights;
  options.polynomial_degree = polynomial_degree;
  options.table_nodes = table_nodes;
  options.bulge_length = bulge_length;
  options.refine_circles = refine_circles;
  options.cancelled = hook_of(std::move(cancelled));
  return without_gil([&] { return gelight::calibrate(untouched, presses, options); });
}

}  // namespace

void bind_calibration(py::module_& m) {
  bind_presses(m);
  bind_reports(m);
  bind_sensor(m);
  py::class_<Calibration>(m, "Calibration", "A calibrated sensor, and how sure it is.")
      .def_readonly("sensor", &Calibration::sensor, "What a renderer takes.")
      .def_readonly("bulge_doubt", &Calibration::bulge_doubt,
                    "Standard deviation of the bulge's length, pixels.")
      .def_readonly("held_out", &Calibration::held_out,
                    "Root mean square of presses left out, in the contact, grey levels.")
      .def_property_readonly(
          "spread", [](const Calibration& c) { return array_of(std::vector(c.spread)); },
          "Standard deviation of each coefficient, float64 (k,).")
      .def_readonly("presses", &Calibration::presses, "What was found of each press.")
      .def_readonly("regions", &Calibration::regions, "What is left unexplained, by region.")
      .def_readonly("warnings", &Calibration::warnings, "What a reader should know, in words.");
  const gelight::CalibrationOptions d;
  m.def("calibrate", &calibrated, "background"_a, "presses"_a, py::kw_only(), "model"_a = d.model,
        "lights"_a = d.lights, "polynomial_degree"_a = d.polynomial_degree,
        "table_nodes"_a = d.table_nodes, "bulge_length"_a = d.bulge_length,
        "refine_circles"_a = d.refine_circles, "cancelled"_a = py::none(),
        "Fits a reflectance and the gel's bulge to photographs, a list of BallPresses, of a ball "
        "pressed into a flat sensor; background: uint8 (h, w, 3), untouched. Raises ValueError, "
        "naming the photograph, for what cannot be used.");
}
