// What a sensor's gel does under contact.

#include "any_membrane.hpp"
#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/drape.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/spring_membrane.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/membrane/tension.hpp"
#include "hook.hpp"
#include "images.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::Equilibrium;
using gelight::Gel;
using Bed = gelight::SpringBed<float>;
using Contact = gelight::SpringContact<float>;

namespace {

void bind_gel(py::module_& m) {
  py::class_<Gel>(
      m, "Gel", "What a sensor's gel is made of: isotropic and linearly elastic, on a rigid base.")
      .def(py::init([](double elastic_modulus, double poisson_ratio, double thickness,
                       double friction, double tension) {
             return Gel{elastic_modulus, poisson_ratio, thickness, friction, tension};
           }),
           py::kw_only(), "elastic_modulus"_a = 1e5, "poisson_ratio"_a = 0.48,
           "thickness"_a = 0.005, "friction"_a = 0.0, "tension"_a = 0.0,
           "elastic_modulus in Pa; poisson_ratio 0 to 0.5; thickness in m; friction of gel and "
           "object; tension of the coating in N/m, of a bed of springs.")
      .def_readwrite("elastic_modulus", &Gel::elastic_modulus, "Pa.")
      .def_readwrite("poisson_ratio", &Gel::poisson_ratio, "From 0 to 0.5.")
      .def_readwrite("thickness", &Gel::thickness, "m.")
      .def_readwrite("friction", &Gel::friction, "Of gel and object, Coulomb's.")
      .def_readwrite("tension", &Gel::tension, "Of the coating, N/m.")
      .def_property_readonly("stiffness", &Gel::stiffness,
                             "Pressure over indentation of a bed of springs, N/m^3.")
      .def_property_readonly("shear_modulus", &Gel::shear_modulus, "Pa.");
  m.def("gaussian_sigma", &gelight::gaussian_sigma, "gel"_a, "contact_radius"_a,
        "The standard deviation, in m, of the Gaussian that comes nearest to an elastic layer, for "
        "a contact of that radius, in m.");
}

void bind_bed(py::module_& m) {
  py::enum_<Equilibrium>(m, "Equilibrium", "How a search for the equilibrium ended.")
      .value("reached", Equilibrium::reached)
      .value("untouched", Equilibrium::untouched)
      .value("pull", Equilibrium::pull)
      .value("too_strong", Equilibrium::too_strong)
      .value("tips_over", Equilibrium::tips_over)
      .value("not_converged", Equilibrium::not_converged);
  py::class_<Contact>(m, "SpringContact", "A rigid object in a bed of springs.")
      .def_readonly("equilibrium", &Contact::equilibrium, "Whether the rest holds.")
      .def_readonly("displacement", &Contact::displacement,
                    "How far the object moves from where it was seen, towards the camera, m.")
      .def_property_readonly(
          "tilt", [](const Contact& c) { return array_of(c.tilt); },
          "How much more with every metre along x and y, float64 (2,).")
      .def_readonly("force", &Contact::force, "What the springs bear, N.")
      .def_readonly("residual_force", &Contact::residual_force, "Of what was asked, N.")
      .def_readonly("unknown", &Contact::unknown, "Pixels without a known depth.")
      .def_property_readonly(
          "indentation",
          [](const py::object& self) {
            return view_of(self.cast<const Contact&>().indentation, self);
          },
          "Of the gel's surface, m, float32 (h, w); NaN where the depth is not known.")
      .def_property_readonly(
          "touching",
          [](const py::object& self) {
            return view_of(self.cast<const Contact&>().touching, self);
          },
          "1 where object and gel touch, uint8 (h, w).");
  py::class_<Bed>(
      m, "SpringBed",
      "The flat gel of a sensor as a bed of springs, one for each pixel: finds how deep "
      "a force presses a rigid object in that the camera sees (Hogan et al. 2021, "
      "doi:10.1109/WACV48630.2021.00126).")
      .def(py::init<const Camera&, float, const Gel&>(), "camera"_a, "rest_depth"_a,
           "gel"_a = Gel{}, "rest_depth: of the untouched gel, in m.")
      .def(
          "press",
          [](const Bed& self, py::handle depth, double force,
             std::optional<std::array<double, 2>> centre, py::object cancelled) {
            const DepthImage image(depth);
            const auto hook = hook_of(std::move(cancelled));
            return without_gil([&] {
              if (!centre) return self.press(image.view(), force, hook);
              return self.press_tilting(image.view(), force, {(*centre)[0], (*centre)[1]}, hook);
            });
          },
          "depth"_a, "force"_a, "centre"_a = py::none(), "cancelled"_a = py::none(),
          "The equilibrium of a force (N, towards the gel) on the object seen in a depth image "
          "(h, w), in m. With a centre (x, y in m) the object tilts about it.")
      .def(
          "depth",
          [](const Bed& self, const Contact& contact) { return array_of(self.depth(contact)); },
          "contact"_a,
          "The depth of the gel's surface under a contact, in m, float32 (h, w). Raises ValueError "
          "for a contact of another size than the bed's.");
}

template <class M>
py::class_<MembraneOf<M>, AnyMembrane> bind_membrane(py::module_& m, const char* name,
                                                     const char* doc) {
  return py::class_<MembraneOf<M>, AnyMembrane>(m, name, doc);
}

void bind_drape(py::module_& m) {
  m.def(
      "drape",
      [](py::handle depth, py::handle rest_depth, float fall) {
        const DepthImage image(depth), rest(rest_depth, "the rest depth image");
        return array_of(
            without_gil([&] { return gelight::drape(image.view(), rest.view(), fall); }));
      },
      "depth"_a, "rest_depth"_a, "fall"_a,
      "Lays gel over the outlines of what is pressed in past its widest place, where depth jumps: "
      "the depth image, float32 (h, w), with protrusions that fall by no more than `fall` from "
      "pixel to pixel, like a tent that hangs from the outline.\n\n"
      "depth, rest_depth: (h, w), of what touches the gel and of the untouched gel; all in one "
      "unit. A fall of 4 times a pixel's width on the membrane leaves alone what is not steeper "
      "than 76 degrees. Ways are measured in steps to a pixel's sixteen nearest neighbours "
      "(Borgefors 1986, doi:10.1016/S0734-189X(86)80047-0). Pixels that are not known stay so. "
      "Raises ValueError for images of different sizes and a fall that is not positive and "
      "finite.");
  m.def(
      "drape_into",
      [](py::handle out, py::handle depth, py::handle rest_depth, float fall) {
        const DepthImage image(depth), rest(rest_depth, "the rest depth image");
        OutputImage<float> to(out, "the output image");
        without_gil([&] {
          // Beside it: `out` may be the rest depth image, or lie across one of the two.
          const Image<float> draped = gelight::drape(image.view(), rest.view(), fall);
          gelight::detail::require_same_size(to.view(), rest.view(), "the output image",
                                             "the rest depth image");
          for (Index y = 0; y < draped.height(); ++y) {
            for (Index x = 0; x < draped.width(); ++x) to.view()(x, y) = draped(x, y);
          }
          return 0;
        });
        to.finish();
      },
      "out"_a, "depth"_a, "rest_depth"_a, "fall"_a,
      "The same into the caller's pixels, float32 (h, w), at any strides: those of `depth` or "
      "`rest_depth`, if you like.");
}

}  // namespace

void bind_layer(py::module_& m);

void bind_membranes(py::module_& m) {
  bind_gel(m);
  bind_bed(m);
  py::class_<AnyMembrane>(m, "Membrane", "What a TactileRenderer's membrane does under contact.");
  using Gaussian = gelight::GaussianMembrane<float>;
  bind_membrane<Gaussian>(m, "GaussianMembrane", "A Gaussian of the protrusion.")
      .def(py::init([](double sigma, Index radius, bool clip_to_rest) {
             return MembraneOf(Gaussian(sigma, radius, clip_to_rest));
           }),
           "sigma"_a = 5.0, "radius"_a = 20, "clip_to_rest"_a = true,
           "Standard deviation and where it is cut off, in pixels.");
  using Bulging = gelight::BulgingMembrane<float>;
  bind_membrane<Bulging>(m, "BulgingMembrane",
                         "An elastic layer's surface for about the price of a Gaussian.")
      .def(py::init([](const Camera& camera, float rest_depth, const Gel& gel) {
             return MembraneOf(Bulging(camera, rest_depth, gel));
           }),
           "camera"_a, "rest_depth"_a, "gel"_a = Gel{}, "rest_depth: the gel's mean depth, in m.");
  using Springs = gelight::SpringMembrane<float>;
  bind_membrane<Springs>(m, "SpringMembrane",
                         "A bed of springs: whatever touches it is pressed in by a force.")
      .def(py::init([](const Bed& bed, double force) { return MembraneOf(Springs(bed, force)); }),
           "bed"_a, "force"_a, "force in N, towards the gel.");
  using Tension = gelight::TensionMembrane<float>;
  bind_membrane<Tension>(m, "TensionMembrane",
                         "A membrane under tension on springs, as calibrated sensors have it.")
      .def(py::init([](double length) { return MembraneOf(Tension(length)); }), "length"_a,
           "Over what length a bulge decays, in pixels.");
  bind_layer(m);
  bind_drape(m);
}
