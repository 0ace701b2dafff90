// No more than a sensor's images need, chosen by trials.

#include <utility>

#include "by_value.hpp"
#include "gelight/sensor/plan.hpp"
#include "hook.hpp"
#include "images.hpp"
#include "renderer.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::PlannedLight;
using gelight::PlannedMembrane;
using gelight::SensorPlan;
using gelight::SensorPlanRequest;
using gelight::SensorPlanStep;
using Exact = gelight::SensorPreset<double>;
using Preset = gelight::SensorPreset<float>;

namespace {

template <std::size_t n>
std::array<double, n> widened(const std::array<float, n>& numbers) {
  std::array<double, n> wide;
  std::copy(numbers.begin(), numbers.end(), wide.begin());
  return wide;
}

Exact widened(const Preset& preset) {
  Exact wide;
  for (const auto& p : preset.membrane.positions) wide.membrane.positions.push_back(widened(p));
  wide.membrane.faces = preset.membrane.faces;
  wide.camera = preset.camera.cast<double>();
  for (const auto& led : preset.leds) wide.leds.push_back(led.cast<double>());
  for (const auto& colour : preset.colours) wide.colours.push_back(widened(colour));
  wide.coating = widened(preset.coating);
  wide.falloff = {preset.falloff.full_within, preset.falloff.absorption};
  wide.diffuse = preset.diffuse;
  wide.specular = preset.specular;
  wide.shininess = preset.shininess;
  wide.options = preset.options;
  wide.gel = preset.gel;
  if (preset.led_width) wide.led_width = *preset.led_width;
  wide.led_parts = preset.led_parts;
  return wide;
}

// The caller's sensor(edge_length). What gelight refused within it is refused here as well: coarse
// edges are tried until the sensor cannot be made of them.
gelight::SensorAt sensor_at(const py::function& make) {
  return [&make](double edge_length) {
    const py::gil_scoped_acquire acquire;
    try {
      const py::object made = make(edge_length);
      if (!py::isinstance<Preset>(made)) {
        throw py::type_error("sensor makes " + py::repr(made).cast<std::string>() +
                             ", not a SensorPreset");
      }
      return widened(made.cast<const Preset&>());
    } catch (py::error_already_set& error) {
      if (!error.matches(py::module_::import("gelight").attr("InvalidInput"))) throw;
      throw gelight::InvalidInput(py::str(error.value()).cast<std::string>());
    }
  };
}

py::function callable_in(const py::object& object) {
  if (PyCallable_Check(object.ptr()) == 0) {
    throw py::type_error("sensor is " + py::repr(object).cast<std::string>() +
                         ", which cannot be called");
  }
  return py::reinterpret_borrow<py::function>(object);
}

void bind_results(py::module_& m) {
  py::enum_<PlannedLight>(m, "PlannedLight", "The light models that a plan chooses among.")
      .value("linear", PlannedLight::linear)
      .value("gel", PlannedLight::gel)
      .value("plane", PlannedLight::plane)
      .value("transport", PlannedLight::transport)
      .value("geodesic", PlannedLight::geodesic);
  py::enum_<PlannedMembrane>(m, "PlannedMembrane", "The membrane models that a plan chooses among.")
      .value("gaussian", PlannedMembrane::gaussian)
      .value("bulging", PlannedMembrane::bulging)
      .value("layer", PlannedMembrane::layer);
  py::class_<SensorPlanStep>(m, "SensorPlanStep", "One of the things that a plan chooses, and why.")
      .def_readonly("topic", &SensorPlanStep::topic,
                    "Mesh edges, light model, light grid, smoothing or precision.")
      .def_readonly("choice", &SensorPlanStep::choice, "In words.")
      .def_readonly("error", &SensorPlanStep::error,
                    "Grey levels, that this choice alone is off in the share asked for.")
      .def_readonly("seconds", &SensorPlanStep::seconds,
                    "That it takes, once or, smoothing and precision, a frame; an estimate.")
      .def_readonly("reason", &SensorPlanStep::reason, "In words.");
  py::class_<SensorPlan>(m, "SensorPlan",
                         "A chain from mesh to image, no dearer than a request needs.")
      .def_readwrite("satisfies", &SensorPlan::satisfies,
                     "Whether the trials keep the request; what is chosen is the most exact, if "
                     "not.")
      .def_readonly("needed", &SensorPlan::needed,
                    "In words: what would satisfy, if that does not.")
      .def_readwrite("edge_length", &SensorPlan::edge_length, "Of the mesh, m.")
      .def_readwrite("light", &SensorPlan::light, "The light model, a PlannedLight.")
      .def_readwrite("light_grid", &SensorPlan::light_grid,
                     "Pixels between the places where light is computed.")
      .def_readwrite("membrane", &SensorPlan::membrane, "The membrane model, a PlannedMembrane.")
      .def_readwrite("smoothing_sigma", &SensorPlan::smoothing_sigma,
                     "Pixels, of the Gaussian membrane; 0: it follows the object.")
      .def_readwrite("smoothing_radius", &SensorPlan::smoothing_radius,
                     "Pixels: where the Gaussian is cut off.")
      .def_readwrite("single_precision", &SensorPlan::single_precision,
                     "Whether frames may be rendered in float32, as they are from Python.")
      .def_readonly("share", &SensorPlan::share,
                    "Of the pixels that the trials changed, within the tolerance.")
      .def_readonly("share_error", &SensorPlan::share_error, "Its standard error.")
      .def_readonly("error", &SensorPlan::error, "Grey levels within which the share asked for is.")
      .def_readonly("seconds_once", &SensorPlan::seconds_once,
                    "An estimate, for what is computed once.")
      .def_readonly("seconds_a_frame", &SensorPlan::seconds_a_frame, "An estimate.")
      .def_readonly("cost", &SensorPlan::cost,
                    "Operations, for what is computed once and the request's frames.")
      .def_readonly("steps", &SensorPlan::steps, "The choices one by one, SensorPlanSteps.")
      .def_readonly("reason", &SensorPlan::reason, "All of it in words.");
  keep_by_value(&SensorPlanStep::topic, &SensorPlanStep::choice, &SensorPlanStep::error,
                &SensorPlanStep::seconds, &SensorPlanStep::reason);
  keep_by_value(&SensorPlan::satisfies, &SensorPlan::needed, &SensorPlan::edge_length,
                &SensorPlan::light, &SensorPlan::light_grid, &SensorPlan::membrane,
                &SensorPlan::smoothing_sigma, &SensorPlan::smoothing_radius,
                &SensorPlan::single_precision, &SensorPlan::share, &SensorPlan::share_error,
                &SensorPlan::error, &SensorPlan::seconds_once, &SensorPlan::seconds_a_frame,
                &SensorPlan::cost, &SensorPlan::steps, &SensorPlan::reason);
}

SensorPlan planned(const py::object& sensor, double tolerance, double share, double contact_radius,
                   double press_depth, PlannedLight light, PlannedMembrane membrane,
                   double reference_edge, double frames_a_second, double frames, double slowness,
                   Index contacts, std::uint64_t seed, py::object cancelled) {
  const py::function make = callable_in(sensor);
  SensorPlanRequest request;
  request.tolerance = tolerance;
  request.share = share;
  request.contact_radius = contact_radius;
  request.press_depth = press_depth;
  request.light = light;
  request.membrane = membrane;
  request.reference_edge = reference_edge;
  request.frames_a_second = frames_a_second;
  request.frames = frames;
  request.slowness = slowness;
  request.contacts = contacts;
  request.seed = seed;
  request.cancelled = hook_of(std::move(cancelled));
  return without_gil([&] { return gelight::plan_sensor(sensor_at(make), request); });
}

std::unique_ptr<AnyRenderer> renderer_by(const py::object& sensor, const SensorPlan& plan,
                                         py::object cancelled) {
  using Gaussian = gelight::GaussianMembrane<float>;
  using Any = gelight::AnyPlannedMembrane<float>;
  const py::function make = callable_in(sensor);
  const auto hook = hook_of(std::move(cancelled));
  const auto made = [&]<class Membrane>() -> std::unique_ptr<AnyRenderer> {
    return std::make_unique<RendererOf<gelight::TactileRenderer<float, Membrane>>>(
        gelight::planned_renderer<float, Membrane>(sensor_at(make), plan, hook));
  };
  return without_gil([&]() -> std::unique_ptr<AnyRenderer> {
    return plan.membrane == PlannedMembrane::gaussian ? made.template operator()<Gaussian>()
                                                      : made.template operator()<Any>();
  });
}

}  // namespace

void bind_sensor_plan(py::module_& m) {
  bind_results(m);
  const SensorPlanRequest d;
  m.def(
      "plan_sensor", &planned, "sensor"_a, py::kw_only(), "tolerance"_a = d.tolerance,
      "share"_a = d.share, "contact_radius"_a = d.contact_radius, "press_depth"_a = d.press_depth,
      "light"_a = d.light, "membrane"_a = d.membrane, "reference_edge"_a = d.reference_edge,
      "frames_a_second"_a = d.frames_a_second, "frames"_a = d.frames, "slowness"_a = d.slowness,
      "contacts"_a = d.contacts, "seed"_a = d.seed, "cancelled"_a = py::none(),
      "Chooses the cheapest chain from mesh to image whose images are as good as asked for, a "
      "SensorPlan: how fine a mesh, which light model and on how coarse a grid, which membrane "
      "model, or how the protrusion is smoothed, and in which precision.\n\n"
      "sensor(edge_length) makes the SensorPreset, with edges of so many m: `lambda edge: "
      "gelight.geltip(320, 240, edge)`. tolerance: grey levels, of 255, that a colour may be off, "
      "in `share` of the pixels that contacts of that radius and depth (m) change. light, "
      "membrane: those that are right. reference_edge: of the mesh of the images that others are "
      "compared with, m. "
      "frames_a_second: needed at least; frames: over which the work that is done once is spread. "
      "slowness: against a machine of 2e9 operations a second. contacts, seed: tried at random.\n\n"
      "Raises ValueError as the sensor does at the reference's edges, for a number that cannot be, "
      "and where contacts of that size show in fewer than 16 pixels. What cannot be satisfied is "
      "no "
      "error: the plan says so.");
  m.def(
      "planned_renderer", &renderer_by, "sensor"_a, "plan"_a, "cancelled"_a = py::none(),
      "The TactileRenderer of a plan, for the same sensor. Raises ValueError for a plan that does "
      "not satisfy its request, and for one that wants double precision, which renderers in "
      "Python have not: who takes float32 all the same sets `single_precision`.");
}
