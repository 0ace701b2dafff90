// The gel as a linearly elastic layer.

#include "gelight/membrane/layer.hpp"

#include "any_membrane.hpp"
#include "gelight/membrane/layer_membrane.hpp"
#include "hook.hpp"
#include "images.hpp"

using namespace py::literals;
using gelight::Gel;
using gelight::LayerLoad;
using Contact = gelight::LayerContact<float>;
using Layer = gelight::ElasticLayer<float>;
using LayerMembrane = gelight::LayerMembrane<float>;

namespace {

using Pair = std::array<double, 2>;

LayerLoad load_of(std::optional<double> force, std::optional<Pair> centre, const Pair& shift,
                  double twist) {
  LayerLoad load;
  load.force = force;
  if (centre) load.centre = Vec2<double>((*centre)[0], (*centre)[1]);
  load.shift = {shift[0], shift[1]};
  load.twist = twist;
  return load;
}

template <class P>
py::object image_of(const py::object& self, Image<P> Contact::*image) {
  return view_of(self.cast<const Contact&>().*image, self);
}

void bind_contact(py::module_& m) {
  py::class_<Contact>(m, "LayerContact",
                      "A rigid object in an elastic layer. Images are of the camera's size; x, y "
                      "and z are the camera's.")
      .def_property_readonly(
          "indentation",
          [](const py::object& self) { return image_of(self, &Contact::indentation); },
          "Of the surface, m, float32 (h, w); negative where it bulges.")
      .def_property_readonly(
          "depth", [](const py::object& self) { return image_of(self, &Contact::depth); },
          "Of the surface, m, float32 (h, w): what a renderer is to be given.")
      .def_property_readonly(
          "pressure", [](const py::object& self) { return image_of(self, &Contact::pressure); },
          "Of the object on the gel, Pa, float32 (h, w).")
      .def_property_readonly(
          "traction", [](const py::object& self) { return image_of(self, &Contact::traction); },
          "Sideways, Pa, float32 (h, w, 2); (0, 0, 2): none.")
      .def_property_readonly(
          "displacement",
          [](const py::object& self) { return image_of(self, &Contact::displacement); },
          "Of the surface, m, float32 (h, w, 3); (0, 0, 3) where options leave it out.")
      .def_readonly("travel", &Contact::travel,
                    "How far the object is from where it was seen, towards the camera, m.")
      .def_property_readonly(
          "tilt", [](const Contact& c) { return array_of(c.tilt); },
          "How much more with every metre along x and y, float64 (2,).")
      .def_property_readonly(
          "force", [](const Contact& c) { return array_of(c.force); },
          "Of the object on the gel, N, float64 (3,).")
      .def_property_readonly(
          "moment", [](const Contact& c) { return array_of(c.moment); },
          "About the point of the gel on the camera's axis, N m, float64 (3,).")
      .def_readonly("bend", &Contact::bend,
                    "How far the gel at rest is bent where it is touched, in radians.")
      .def_readonly("is_bent_too_far", &Contact::is_bent_too_far, "Too far for a flat layer.")
      .def_readonly("converged", &Contact::converged, "Whether the rest is as exact as asked.")
      .def_readonly("residual", &Contact::residual, "As a share of the deepest press.")
      .def_readonly("iterations", &Contact::iterations, "Of conjugate gradients.")
      .def_readonly("convolutions", &Contact::convolutions, "With a Green's function.")
      .def_readonly("unknown", &Contact::unknown, "Pixels without a known depth.");
}

Layer layer_of(const Camera& camera, py::handle rest_depth, const Gel& gel,
               const gelight::LayerOptions& options) {
  if (PyFloat_Check(rest_depth.ptr()) != 0) {
    return Layer(camera, rest_depth.cast<float>(), gel, options);
  }
  return Layer(camera, DepthImage(rest_depth, "the rest depth").view(), gel, options);
}

}  // namespace

void bind_layer(py::module_& m);

void bind_layer(py::module_& m) {
  bind_contact(m);
  py::class_<Layer>(
      m, "ElasticLayer",
      "The gel of a sensor as a linearly elastic layer on a rigid base, and how a "
      "rigid object presses it: pressure, force and displacement. Against Hertz, at a "
      "contact radius of 40 pixels, the force is 0.005 % off.")
      .def(py::init([](const Camera& camera, py::handle rest_depth, const Gel& gel,
                       double tolerance, int most_iterations, bool sideways, py::object cancelled) {
             gelight::LayerOptions options;
             options.tolerance = tolerance;
             options.most_iterations = most_iterations;
             options.sideways = sideways;
             options.cancelled = hook_of(std::move(cancelled));
             return layer_of(camera, rest_depth, gel, options);
           }),
           "camera"_a, "rest_depth"_a, "gel"_a = Gel{}, py::kw_only(), "tolerance"_a = 1e-3,
           "most_iterations"_a = 500, "sideways"_a = true, "cancelled"_a = py::none(),
           "rest_depth: of the untouched gel, in m, an image (h, w) or a float. tolerance: a share "
           "of the deepest press. sideways: whether to find the displacement along x and y.")
      .def(
          "press",
          [](const Layer& self, py::handle depth, std::optional<double> force,
             std::optional<Pair> centre, const Pair& shift, double twist, const Contact* previous) {
            const DepthImage image(depth);
            const LayerLoad load = load_of(force, centre, shift, twist);
            return without_gil([&] { return self.press(image.view(), load, previous); });
          },
          "depth"_a, "force"_a = py::none(), "centre"_a = py::none(), "shift"_a = Pair{0, 0},
          "twist"_a = 0.0, "previous"_a = py::none(),
          "The contact with an object, given as a depth image (h, w), in m. force: in N, towards "
          "the camera; without it the object stays where it is seen. centre: of the force, x and y "
          "in m; the object then tilts. shift (m) and twist (radians): how the object has moved "
          "sideways since. previous: a contact to start from.");
  py::class_<MembraneOf<LayerMembrane>, AnyMembrane>(m, "LayerMembrane",
                                                     "An elastic layer as a renderer's membrane.")
      .def(py::init([](const Layer& layer, std::optional<double> force, std::optional<Pair> centre,
                       bool warm) {
             return MembraneOf(LayerMembrane(layer, load_of(force, centre, {0, 0}, 0), warm));
           }),
           "layer"_a, "force"_a = py::none(), "centre"_a = py::none(), "warm"_a = false,
           "force and centre as for ElasticLayer.press. warm: starts each contact from the last.");
}
