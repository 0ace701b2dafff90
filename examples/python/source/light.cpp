// The light of an LED at points of a membrane.

#include "gelight/light/field.hpp"
#include "gelight/light/models.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/presets.hpp"
#include "hook.hpp"
#include "images.hpp"
#include "points.hpp"
#include "topics.hpp"

using namespace py::literals;
using gelight::Lighting;
using gelight::Specular;
using FloatPoints = std::vector<gelight::SurfacePoint<float>>;
using Led = gelight::Led<float>;
using Light = gelight::Light<float>;
using Rays = gelight::LightRays<float>;

namespace {

Led led_in(py::handle object) {
  if (py::isinstance<Led>(object)) return object.cast<const Led&>();
  return {cast_points<float>(points_or_places_in(object, py::none()))};
}

// The pixels of a raster that show something, or points as elsewhere.
FloatPoints lit_points_in(py::handle points, py::handle barycentric) {
  if (py::isinstance<Raster>(points)) return gelight::pixel_points(points.cast<const Raster&>());
  return cast_points<float>(points_or_places_in(points, barycentric));
}

constexpr const char* field_words =
    "The unit direction in which the light of an LED travels at each point, float32 (n, 3), zero "
    "where it has none.\n\nled: a Led, or vertices and SurfacePoints of it. points: a Raster, at "
    "whose pixels that show something; or vertices and SurfacePoints; or faces (n,), with "
    "barycentric coordinates (n, 3).";

template <class Model>
py::class_<Model> bind_model(py::module_& m, const char* name, const char* doc) {
  auto model = py::class_<Model>(m, name, doc);
  model.def(
      "field",
      [](const Model& self, py::handle led, py::handle points, py::handle barycentric,
         py::object cancelled) {
        const Led from = led_in(led);
        const FloatPoints at = lit_points_in(points, barycentric);
        const auto hook = hook_of(std::move(cancelled));
        return array_of(without_gil([&] { return self.field(from, at, hook); }));
      },
      "led"_a, "points"_a, "barycentric"_a = py::none(), "cancelled"_a = py::none(), field_words);
  if constexpr (requires { &Model::rays; }) {
    model.def(
        "rays",
        [](const Model& self, py::handle led, py::handle points, py::handle barycentric,
           py::object cancelled) {
          const Led from = led_in(led);
          const FloatPoints at = lit_points_in(points, barycentric);
          const auto hook = hook_of(std::move(cancelled));
          return without_gil([&] { return self.rays(from, at, hook); });
        },
        "led"_a, "points"_a, "barycentric"_a = py::none(), "cancelled"_a = py::none(),
        "The same with the length of the way and how the light comes.");
  }
  return model;
}

template <class Model>
void bind_plain_model(py::module_& m, const char* name, const char* doc) {
  bind_model<Model>(m, name, doc)
      .def(py::init([](const Surface& membrane) {
             return without_gil([&] { return Model(membrane); });
           }),
           "membrane"_a);
}

void bind_models(py::module_& m) {
  bind_plain_model<gelight::LinearLight<float>>(
      m, "LinearLight", "Light that travels straight through space, whatever stands between.");
  bind_plain_model<gelight::PlaneLight<float>>(
      m, "PlaneLight", "Light that stays in a plane through the LED and its normal.");
  bind_plain_model<gelight::GeodesicLight<float>>(
      m, "GeodesicLight", "Light that follows the shortest paths on the membrane.");
  bind_plain_model<gelight::TransportLight<float>>(
      m, "TransportLight",
      "Light that keeps its direction as far as the membrane lets it: parallel transport. Without "
      "an emission it leaves the LED, which is one vertex then, in all directions.");
  bind_model<gelight::GelLight<float>>(
      m, "GelLight",
      "Light that goes straight through gel with air behind it, and across the hollow, shortened "
      "to its strength. An LED needs an emission.")
      .def(py::init([](const Surface& membrane, float thickness, float full_within, float index,
                       bool has_normals_inwards) {
             return without_gil([&] {
               return gelight::GelLight<float>(membrane,
                                               {.thickness = thickness,
                                                .full_within = full_within,
                                                .index = index,
                                                .has_normals_inwards = has_normals_inwards});
             });
           }),
           "membrane"_a, py::kw_only(), "thickness"_a = 0.003f, "full_within"_a = 0.01f,
           "index"_a = 1.41f, "has_normals_inwards"_a = false,
           "thickness of the gel and the distance within which light is full, in the unit of the "
           "positions; refractive index; whether its normals point into the gel.");
}

void bind_lights(py::module_& m) {
  py::class_<Light>(m, "Light", "A light that shines on every pixel of a sensor's membrane.")
      .def(py::init([](py::handle direction, const std::array<float, 3>& rgb, float diffuse,
                       float specular, float shininess) {
             return Light{PixelImage<Vec3<float>>(direction, "direction").copy(), rgb, diffuse,
                          specular, shininess};
           }),
           "direction"_a, "rgb"_a = std::array<float, 3>{1, 1, 1}, "diffuse"_a = 0.5f,
           "specular"_a = 0.1f, "shininess"_a = 100.0f,
           "direction: in which the light travels when it arrives, (h, w, 3), of unit length or "
           "shorter where it is dimmer. rgb: in shares of full light, 0 to 1. Phong's k_d, k_s and "
           "exponent.")
      .def_property_readonly(
          "direction",
          [](const py::object& self) {
            return read_only(view_of(self.cast<const Light&>().direction, self));
          },
          "float32 (h, w, 3).")
      .def_readwrite("rgb", &Light::rgb, "Colour and intensity, in shares of full light.")
      .def_readwrite("diffuse", &Light::diffuse, "Phong's k_d.")
      .def_readwrite("specular", &Light::specular, "Phong's k_s.")
      .def_readwrite("shininess", &Light::shininess, "Phong's exponent.");
}

void bind_fields(py::module_& m) {
  py::class_<Led>(m, "Led", "Where light enters a membrane.")
      .def(py::init([](py::handle points, py::handle emission) {
             Led led{cast_points<float>(points_or_places_in(points, py::none()))};
             if (!emission.is_none()) led.emission = vector_in(emission, "emission").cast<float>();
             return led;
           }),
           "points"_a, "emission"_a = py::none(),
           "points: vertices or SurfacePoints, light comes from the nearest. emission: which way "
           "(3,), for a model that keeps it; by default every way.");
  py::enum_<Lighting>(m, "Lighting", "How the light of an LED comes to a point.")
      .value("lit", Lighting::lit, "In one direction.")
      .value("ambiguous", Lighting::ambiguous, "By several paths equally short.")
      .value("at_led", Lighting::at_led, "The point is the LED.")
      .value("dark", Lighting::dark, "Not at all.");
  py::class_<Rays>(m, "LightRays", "A light field with what else is known of each point.")
      .def_property_readonly(
          "direction", [](const Rays& rays) { return array_of(std::vector(rays.direction)); },
          "Unit, float32 (n, 3), or zero.")
      .def_property_readonly(
          "distance", [](const Rays& rays) { return array_of(std::vector(rays.distance)); },
          "Travelled, float32 (n,), in the unit of the positions; +inf where dark.")
      .def_property_readonly(
          "lighting",
          [](const Rays& rays) {
            std::vector<std::uint8_t> how;
            for (const Lighting one : rays.lighting) how.push_back(static_cast<std::uint8_t>(one));
            return array_of(std::move(how));
          },
          "How the light comes, uint8 (n,): numbers of Lighting.");
  m.def(
      "strength",
      [](py::handle distance, float full_within, float absorption) {
        const auto numbers = numbers_in<float>(distance, "distance");
        return array_of(
            gelight::strength(span_of(numbers), gelight::Falloff<float>{full_within, absorption}));
      },
      "distance"_a, "full_within"_a = gelight::unreachable<float>, "absorption"_a = 0.0f,
      "The share of an LED's light that is left at each distance (n,), float32 (n,): it spreads "
      "beyond `full_within` and is absorbed, per unit of the positions.");
  m.def(
      "pixel_points",
      [](const Raster& raster) {
        std::vector<Index> faces;
        std::vector<std::array<float, 3>> barycentric;
        for (const auto& point : gelight::pixel_points(raster)) {
          faces.push_back(point.element[0]);
          barycentric.push_back(point.weights);
        }
        return py::make_tuple(array_of(std::move(faces)), array_of(std::move(barycentric)));
      },
      "raster"_a,
      "The surface points that the pixels show, row after row, without the pixels that show none: "
      "faces int32 (n,), barycentric float32 (n, 3).");
  m.def(
      "bake",
      [](py::handle field, const Raster& raster, py::object cancelled) {
        const auto rows = rows_in<float, 3>(field, "the field");
        const std::span<const Vec3<float>> directions(
            reinterpret_cast<const Vec3<float>*>(rows.data()),
            static_cast<std::size_t>(rows.shape(0)));
        const auto hook = hook_of(std::move(cancelled));
        return array_of(without_gil([&] { return gelight::bake(directions, raster, hook); }));
      },
      "field"_a, "raster"_a, "cancelled"_a = py::none(),
      "Puts a field of `pixel_points(raster)`, (n, 3), back to its pixels, float32 (h, w, 3); zero "
      "where the raster shows nothing.");
  m.def(
      "points_of_border",
      [](const Surface& membrane, py::handle angles) {
        gelight::Mesh<double> mesh;
        for (Index v = 0; v < membrane.vertex_count(); ++v) {
          const auto& p = membrane.position(v);
          mesh.positions.push_back({p[0], p[1], p[2]});
        }
        for (Index f = 0; f < membrane.face_count(); ++f) mesh.faces.push_back(membrane.face(f));
        const auto turns = numbers_in<double>(angles, "angles");
        return gelight::points_of_border(mesh, span_of(turns));
      },
      "membrane"_a, "angles"_a,
      "The points of a membrane's border that are seen from its middle at some angles (k,), in "
      "radians from x towards y, a list of SurfacePoints: where LEDs are.");
}

}  // namespace

void bind_light(py::module_& m) {
  py::enum_<Specular>(m, "Specular", "The form of Phong's specular term.")
      .value("gated", Specular::gated)
      .value("unclamped", Specular::unclamped);
  bind_fields(m);
  bind_models(m);
  bind_lights(m);
}
