// Light that is traced through a gel, where Embree was found.

#include "gelight/light/traced.hpp"

#include "arrays.hpp"
#include "hook.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::InnerLayer;
using gelight::LightBalance;
using gelight::LightTracer;
using gelight::TracedLight;

namespace {

void bind_balance(py::module_& m) {
  py::class_<LightBalance>(m, "LightBalance", "Where light ended, as shares of the LED's power.")
      .def_readonly("coating", &LightBalance::coating, "Absorbed by the coating.")
      .def_readonly("gel", &LightBalance::gel, "Absorbed in the gel and the layers.")
      .def_readonly("lost", &LightBalance::lost,
                    "Reflected on entering, gone through an open rim, the base or the open end.")
      .def_readonly("cut", &LightBalance::cut, "Still under way when cut off.")
      .def_readonly("segments", &LightBalance::segments, "Straight pieces traced; no share.");
}

using Numbers = std::vector<double> TracedLight::*;
using Vectors = gelight::LightField<double> TracedLight::*;

auto numbers_of(Numbers field) {
  return [field](const py::object& self) {
    const auto& numbers = self.cast<const TracedLight&>().*field;
    return read_only(
        py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data(), self));
  };
}

auto vectors_of(Vectors field) {
  return [field](const TracedLight& self) {
    const auto& vectors = self.*field;
    return array_of(std::vector<Vec3<double>>(vectors.begin(), vectors.end()));
  };
}

void bind_result(py::module_& m) {
  py::class_<TracedLight>(m, "TracedLight",
                          "The light of one LED at each vertex of the membrane, with standard "
                          "errors beside.")
      .def_property_readonly("irradiance", numbers_of(&TracedLight::irradiance),
                             "Power that arrives over area, float64 (n,).")
      .def_property_readonly("irradiance_error", numbers_of(&TracedLight::irradiance_error),
                             "Its standard error, float64 (n,).")
      .def_property_readonly("direction", vectors_of(&TracedLight::direction),
                             "Mean direction in which the power travels, float64 (n, 3): unit, or "
                             "zero where none arrives.")
      .def_property_readonly("direction_error", numbers_of(&TracedLight::direction_error),
                             "Radians, float64 (n,).")
      .def_property_readonly("directed", numbers_of(&TracedLight::directed),
                             "Length of that mean before it is made a unit, float64 (n,): 1 is a "
                             "single ray, 0 light from all sides.")
      .def_property_readonly("directed_error", numbers_of(&TracedLight::directed_error),
                             "Its standard error, float64 (n,).")
      .def_property_readonly("vector", vectors_of(&TracedLight::vector),
                             "Radiance times the direction of travel, over all directions, float64 "
                             "(n, 3): its product with a normal is the irradiance there.")
      .def_property_readonly("vector_error", numbers_of(&TracedLight::vector_error),
                             "Root of the sum of its numbers' variances, float64 (n,).")
      .def_readonly("balance", &TracedLight::balance, "Where the light ended.")
      .def_readonly("balance_error", &TracedLight::balance_error, "Its standard error.");
}

TracedLight traced(const LightTracer& tracer, py::handle place, py::handle axis, double radius,
                   double power, double narrowness, bool behind_air, Index layer,
                   std::int64_t paths, std::uint64_t seed, int longest, unsigned threads,
                   py::object cancelled) {
  const gelight::TracedLed led{vector_in(place, "place"),
                               vector_in(axis, "axis"),
                               radius,
                               power,
                               narrowness,
                               behind_air,
                               layer};
  const gelight::TraceOptions options{paths, seed, longest, threads, hook_of(std::move(cancelled))};
  return without_gil([&] { return tracer.trace(led, options); });
}

void bind_tracer(py::module_& m) {
  py::class_<InnerLayer>(m, "InnerLayer",
                         "What lies beneath a gel, or beneath the layer above this one.")
      .def(py::init([](const Surface& surface, double index, double absorption) {
             return InnerLayer{surface, index, absorption};
           }),
           "surface"_a, "index"_a = 1.0, "absorption"_a = 0.0,
           "surface: where it begins, with normals towards the gel. Refractive index beyond, 1 is "
           "air; absorption there, per unit of the positions.");
  m.def(
      "beneath",
      [](const Surface& membrane, double thickness) {
        return without_gil([&] { return gelight::beneath(membrane, thickness); });
      },
      "membrane"_a, "thickness"_a,
      "The Surface that lies `thickness` beneath each vertex of a membrane.");
  py::class_<LightTracer>(m, "LightTracer",
                          "Traces the light of LEDs through the gel of a sensor by brute force: "
                          "refraction, total reflection, absorption, a coating that reflects "
                          "diffusely. Only where the module was built with Embree 3.")
      .def(py::init([](const Surface& membrane, double index, double absorption, double albedo,
                       const std::vector<InnerLayer>& layers) {
             return without_gil([&] {
               return LightTracer(membrane, {index, absorption, albedo}, layers);
             });
           }),
           "membrane"_a, py::kw_only(), "index"_a = 1.41, "absorption"_a = 0.0, "albedo"_a = 0.5,
           "layers"_a = std::vector<InnerLayer>{},
           "membrane: with normals outwards. index and absorption, per unit of the positions, of "
           "the gel; albedo of its coating; InnerLayers beneath the gel, from outside to inside.")
      .def_property_readonly(
          "surface", [](const LightTracer& tracer) { return tracer.surface(); }, "The membrane.")
      .def("trace", &traced, "place"_a, "axis"_a, py::kw_only(), "radius"_a = 0.0, "power"_a = 1.0,
           "narrowness"_a = 1.0, "behind_air"_a = false, "layer"_a = 0, "paths"_a = 1 << 20,
           "seed"_a = 1, "longest"_a = 1000, "threads"_a = 1, "cancelled"_a = py::none(),
           "The TracedLight of a round LED: its middle (3,), where it shines (3,), radius, power, "
           "and how narrowly (1: Lambert). layer: into which it shines, 0 is the gel. paths: from "
           "the LED, cut off after `longest` boundaries; the same seed draws the same, on any "
           "number of threads (0: as many as the machine has).");
}

}  // namespace

void bind_traced(py::module_& m) {
  bind_balance(m);
  bind_result(m);
  bind_tracer(m);
}
