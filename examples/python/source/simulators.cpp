// The membranes of other simulators, to compare with.

#include "any_membrane.hpp"
#include "arrays.hpp"
#include "gelight/membrane/flat_gelsight.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/pyramid.hpp"
#include "gelight/membrane/shadowed.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::ContactShadow;
using Camera = gelight::Camera<float>;
using Flat = gelight::FlatGelSightMembrane<float>;
using Gaussian = gelight::GaussianMembrane<float>;
using Pyramid = gelight::PyramidMembrane<float>;
using Shadowed = gelight::ShadowedMembrane<float>;

namespace {

void bind_shadowed(py::module_& m) {
  const ContactShadow d;
  py::class_<ContactShadow>(m, "ContactShadow", "How a contact's shadow is cast.")
      .def(py::init([](double contact, double sigma, Index radius, Index gap) {
             return ContactShadow{contact, sigma, radius, gap};
           }),
           py::kw_only(), "contact"_a = d.contact, "sigma"_a = d.sigma, "radius"_a = d.radius,
           "gap"_a = d.gap)
      .def_readwrite("contact", &ContactShadow::contact,
                     "How far an object is pressed in to count, in the unit of the depth.")
      .def_readwrite("sigma", &ContactShadow::sigma, "How soft the shadow is, in pixels.")
      .def_readwrite("radius", &ContactShadow::radius, "Where that is cut off, in pixels.")
      .def_readwrite("gap", &ContactShadow::gap,
                     "How far around the object there is none, in pixels.");
  py::class_<MembraneOf<Shadowed>, AnyMembrane>(
      m, "ShadowedMembrane",
      "A GaussianMembrane whose bulge is the lower where the object hides it from the camera, "
      "after the GelTip authors' later code.")
      .def(py::init([](const Camera& camera, double sigma, Index radius, bool clip_to_rest,
                       const ContactShadow& shadow) {
             return MembraneOf(Shadowed(camera, Gaussian(sigma, radius, clip_to_rest), shadow));
           }),
           "camera"_a, "sigma"_a = 5.0, "radius"_a = 20, "clip_to_rest"_a = true,
           "shadow"_a = ContactShadow{},
           "sigma, radius, clip_to_rest: of the GaussianMembrane. A renderer of another camera's "
           "size refuses it.");
}

}  // namespace

void bind_simulators(py::module_& m) {
  py::class_<MembraneOf<Pyramid>, AnyMembrane>(
      m, "PyramidMembrane",
      "Taxim's: the protrusion blurred by one Gaussian after the other, and put back after each "
      "wherever the object is (Si, Yuan 2022, doi:10.1109/LRA.2022.3142412).")
      .def(py::init([](py::handle sigmas) {
             return MembraneOf(Pyramid(span_of(numbers_in<double>(sigmas, "sigmas"))));
           }),
           "sigmas"_a, "Standard deviations in pixels, in the order in which they are applied.");
  bind_shadowed(m);
  py::class_<MembraneOf<Flat>, AnyMembrane>(
      m, "FlatGelSightMembrane",
      "Of the flat GelSight simulator that the GelTip's came from: twice a narrow spread of the "
      "protrusion less a wide one (Gomes, Wilson, Luo 2019).")
      .def(py::init([] { return MembraneOf(Flat()); }));
}
