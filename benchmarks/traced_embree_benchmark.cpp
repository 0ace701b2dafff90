// Does light follow geodesics? The light fields of this library beside light traced ray by ray
// through the gel of five sensors, for thin and thick gel over air and coatings dark to bright.
//
// For each sensor, over its vertices but those at the border and within 2.5 mm of the LED:
//   angle_X    between the direction of field X and the mean one of the traced light, in degrees,
//              weighted by irradiance; azimuth_X the same, both laid into the tangent plane
//   levels_X   what a membrane tilted by 20 degrees (eight ways) changes in brightness, with light
//              from X instead of the traced light: mean difference in grey levels. One gain, the
//              best, for the whole sensor; 100 levels are the 99th percentile of the traced change
//   contact_X  the same of what balls change that are pressed in, pixel by pixel
//   given_X    the same as levels_X, were X everywhere as strong as the traced light: direction
//   alone counts levels_none  the same with no light at all: a model that is not below this is of
//   no use tilt, directed, falloff: of the traced light, weighted by irradiance; the 5th percentile
//   of the
//              irradiance over the 95th
//   seconds_X  to make the field, set-up and all (of the geodesic and `gel`)
// `linear_dimmed` and `geodesic_dimmed` fall off with distance (`Falloff`), `near` with its square
// and the LED's cosine, from the LED's place in the gel; `mirrored` is that and its image in the
// gel's inner side by Fresnel; `gel` is `gel_field`, which also knows of bends and of the hollow.
//
// Rows `directions/...`: what it takes to know the mean direction of one LED's light, first arrival
// (no light from the coating), to a standard error of 1 degree at 99 % of the pixels of 160 x 120
// whose irradiance is at least `threshold` of the 99th percentile of all pixels':
//   seconds        processor time of the trace that reached it; rays_a_second beside it
//   counted        share of the pixels that see the membrane and are as bright as that
//   within         share of these with no more than 1 degree, in that trace; `within_all` of all
//   vertices       of the membrane: light is gathered at these, and interpolated between them. A
//                  pixel's error is the mean of its corners' by irradiance and weight, as if they
//                  were all wrong the same way

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <initializer_list>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/gel.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/traced.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/run.hpp"

namespace {

using namespace gelight;
using Field = LightField<double>;
constexpr double pi = std::numbers::pi, degree = pi / 180;
constexpr double edge = 0.0013, near_led = 0.0025;

double seconds_of(const auto& work) {
  const std::clock_t before = std::clock();
  work();
  return static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
}

/// A membrane and where on its border an LED is.
struct Sensor {
  std::string name;
  Surface<double> surface;
  Index led;
  Vec3<double> axis;
  double camera_behind;  // the origin, where the camera looks along z
};

Surface<double> turned(double height, const auto& radius_at, int rings) {
  std::vector<ProfilePoint<double>> outline;
  for (int i = 0; i <= rings; ++i) {
    const double t = static_cast<double>(i) / rings;
    outline.push_back({radius_at(t), height * t});
  }
  return Surface<double>(revolve<double>(outline, edge));
}

Surface<double> dome(double radius) {
  std::vector<ProfilePoint<double>> outline;
  const int rings = static_cast<int>(radius * pi / 2 / (0.87 * edge));
  for (int i = 0; i < rings; ++i) {
    const double angle = pi / 2 * i / rings;
    outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  outline.push_back({0, radius});
  return Surface<double>(revolve<double>(outline, edge));
}

// A sheet of 24 mm about the origin, flat, or a saddle of this curvature either way.
Surface<double> sheet(double curvature) {
  constexpr double side = 0.024;
  auto mesh = placed<double>(grid<double>(19, 19, side, side), Eigen::Matrix3d::Identity(),
                             {-side / 2, -side / 2, 0});
  for (auto& [x, y, z] : mesh.positions) z = curvature / 2 * (x * x - y * y);
  return Surface<double>(mesh);
}

std::vector<Sensor> sensors() {
  constexpr double radius = 0.01146, half = 0.012, curvature = 50;
  const auto with_led = [](const char* name, const Surface<double>& surface,
                           const Vec3<double>& led, const Vec3<double>& axis,
                           double camera_behind = 0) {
    return Sensor{name, surface, nearest_vertex<double>(surface, led), axis.normalized(),
                  camera_behind};
  };
  return {with_led("fingertip", Surface<double>(membrane<double>(radius, 0.0455, edge)),
                   {radius, 0, 0}, {0, 0, 1}),
          with_led("dome", dome(radius), {radius, 0, 0}, {0, 0, 1}),
          with_led("flat pad", sheet(0), {0, -half, 0}, {0, 1, 0}, half),
          with_led("cylinder",
                   turned(
                       0.045, [](double) { return radius; }, 40),
                   {radius, 0, 0}, {0, 0, 1}),
          with_led("saddle", sheet(curvature), {0, -half, -curvature / 2 * half * half},
                   {0, 1, curvature * half}, half)};
}

std::vector<Vec3<double>> normals_of(const Surface<double>& surface) {
  std::vector<Vec3<double>> normals;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    normals.push_back(detail::direction_of(detail::mean_normal(surface, vertex_point<double>(v))));
  }
  return normals;
}

/// What shades a membrane: at each vertex a direction of light times its strength.
struct Model {
  std::string name;
  Field field;
  double seconds;
};

// Lambert's light from a place, as if nothing were in its way.
Vec3<double> lambert(const Vec3<double>& from, const Vec3<double>& axis, const Vec3<double>& to) {
  const Vec3<double> way = to - from;
  const double d = way.norm();
  return std::max(0.0, way.dot(axis)) / (d * d * d * d) * way;
}

Field near_light(const Surface<double>& surface, const TracedLed& led) {
  Field field;
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    field.push_back(lambert(led.place, led.axis, surface.position(v)));
  }
  return field;
}

// And from its image in the gel's inner side, taken as flat.
Field mirrored_light(const Surface<double>& surface, const TracedLed& led,
                     const Vec3<double>& normal, double thickness, double index) {
  const Vec3<double> image = led.place - thickness * normal;
  Field field = near_light(surface, led);
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    const Vec3<double> way = detail::direction_of(Vec3<double>(surface.position(v) - image));
    const double reflected = detail::fresnel(std::abs(way.dot(normal)), index).reflected;
    field[static_cast<std::size_t>(v)] += reflected * lambert(image, led.axis, surface.position(v));
  }
  return field;
}

// Those that do not depend on the gel.
std::vector<Model> models_of(const Sensor& sensor) {
  const auto& surface = sensor.surface;
  const auto points = vertex_points(surface);
  const auto led = vertex_point<double>(sensor.led);
  const std::vector<Vec3<double>> normals = normals_of(surface);
  std::vector<Model> models;
  const auto add = [&](const char* name, const auto& make) {
    Model model{name, {}, 0};
    model.seconds = seconds_of([&] { model.field = make(); });
    models.push_back(std::move(model));
  };
  const Falloff<double> falloff{.full_within = near_led};
  add("linear",
      [&] { return linear_field<double>(surface, surface.position(sensor.led), points); });
  add("rectified", [&] {
    return rectified<double>(linear_field<double>(surface, surface.position(sensor.led), points),
                             normals);
  });
  add("plane", [&] { return plane_field<double>(surface, led, points); });
  add("geodesic",
      [&] { return geodesic_field<double>(ExactSolver<double>(surface), led, points); });
  add("transport", [&] {
    return transport_field<double>(VectorHeatSolver<double>(surface), sensor.led, sensor.axis,
                                   points);
  });
  add("radial", [&] {
    return radial_transport_field<double>(VectorHeatSolver<double>(surface), sensor.led, points);
  });
  add("linear_dimmed", [&] {
    std::vector<double> distance;
    for (Index v = 0; v < surface.vertex_count(); ++v) {
      distance.push_back((surface.position(v) - surface.position(sensor.led)).norm());
    }
    return dimmed<double>(linear_field<double>(surface, surface.position(sensor.led), points),
                          strength<double>(distance, falloff));
  });
  add("geodesic_dimmed", [&] {
    const Source<double> source{led, 0};
    const auto rays =
        geodesic_rays<double>(ExactSolver<double>(surface), std::span(&source, 1), points);
    return dimmed<double>(rays.direction, strength<double>(rays.distance, falloff));
  });
  return models;
}

double angle(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(cross(a, b).norm(), a.dot(b)) / degree;
}

Vec3<double> laid(const Vec3<double>& way, const Vec3<double>& normal) {
  return way - way.dot(normal) * normal;
}

/// The vertices that count, their normals and areas.
struct Places {
  std::vector<std::size_t> vertices;
  std::vector<Vec3<double>> normals;
  std::vector<double> areas;
};

Places places_of(const Sensor& sensor) {
  const auto& surface = sensor.surface;
  Places places;
  places.normals = normals_of(surface);
  for (Index v = 0; v < surface.vertex_count(); ++v) {
    bool counts = (surface.position(v) - surface.position(sensor.led)).norm() > near_led;
    double area = 0;
    for (const Index h : surface.corners(v)) {
      counts = counts && !surface.is_border(h) && !surface.is_border(surface.previous(h));
      area += detail::face_normal(surface, h / 3).norm() / 6;
    }
    places.areas.push_back(area);
    if (counts) places.vertices.push_back(static_cast<std::size_t>(v));
  }
  return places;
}

// By how much tilting the membrane changes its irradiance, place after place.
std::vector<double> changes(const Field& light, const Places& places) {
  constexpr double tilt = 20 * degree;
  std::vector<double> all;
  for (const std::size_t v : places.vertices) {
    const Vec3<double>& n = places.normals[v];
    const double flat = std::max(0.0, light[v].dot(n));
    for (int k = 0; k < 8; ++k) {
      const Vec3<double> tilted = detail::around_axis(n, std::cos(tilt), k / 8.0);
      all.push_back(std::max(0.0, light[v].dot(tilted)) - flat);
    }
  }
  return all;
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// Mean difference in grey levels, with the gain that makes it least.
double levels(const std::vector<double>& truth, const std::vector<double>& model,
              const std::vector<double>& areas) {
  std::vector<double> sizes;
  for (const double t : truth) sizes.push_back(std::abs(t));
  const double unit = 100 / percentile(sizes, 0.99);
  const auto off = [&](double gain) {
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += areas[i] * std::abs(truth[i] - gain * model[i]), weights += areas[i];
    }
    return unit * sum / weights;
  };
  double most = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) most = std::max(most, std::abs(model[i]));
  if (most == 0) return off(0);
  // The difference is convex in the gain.
  double low = 0, high = 4 * percentile(sizes, 1) / most;
  for (int i = 0; i < 60; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (off(a) <= off(b) ? high : low) = off(a) <= off(b) ? b : a;
  }
  return off((low + high) / 2);
}

// The area of each place, as often as it is tilted.
std::vector<double> areas_of(const Places& places) {
  std::vector<double> all;
  for (const std::size_t v : places.vertices) all.insert(all.end(), 8, places.areas[v]);
  return all;
}

/// Pixels that balls change which are pressed into a membrane, seen from within.
struct Contacts {
  struct Pixel {
    std::array<Index, 3> corners;         // vertices of the face that it sees
    Vec3<double> weights, rest, pressed;  // barycentric; normals outwards
  };
  std::vector<Pixel> pixels;
};

// Towards where light comes to, as the membrane's are.
Image<Vec3<double>> outward_normals(const Image<double>& depth, const Camera<double>& camera) {
  auto normals = sobel_normals(depth, camera);
  for (Index y = 0; y < camera.height; ++y) {
    for (Index x = 0; x < camera.width; ++x) {
      if (normals(x, y).dot(camera.ray(x, y)) < 0) normals(x, y) = -normals(x, y);
    }
  }
  return normals;
}

Camera<double> camera_inside() { return Camera<double>::from_vertical_fov(pi / 2, 160, 120); }

// What that camera sees of the membrane.
Raster<double> seen_at_rest(const Sensor& sensor) {
  Mesh<double> mesh;
  for (Index v = 0; v < sensor.surface.vertex_count(); ++v) {
    const Vec3<double> p = sensor.surface.position(v) + Vec3<double>(0, 0, sensor.camera_behind);
    mesh.positions.push_back({p[0], p[1], p[2]});
  }
  for (Index f = 0; f < sensor.surface.face_count(); ++f)
    mesh.faces.push_back(sensor.surface.face(f));
  return rasterize(mesh, camera_inside());
}

Contacts contacts_of(const Sensor& sensor) {
  constexpr double radius = 0.004, pressed_by = 0.0008;
  const auto camera = camera_inside();
  const auto rest = seen_at_rest(sensor);
  const auto at_rest = outward_normals(rest.depth, camera);
  const GaussianMembrane<double> membrane(2, 8);
  auto work = membrane.make_workspace(camera.width, camera.height);
  Contacts contacts;
  // Three by three over the image.
  for (Index i = 0; i < 9; ++i) {
    const Index u = (2 * (i % 3) + 1) * camera.width / 6, v = (2 * (i / 3) + 1) * camera.height / 6;
    if (rest.face(u, v) < 0 || !at_rest(u, v).allFinite()) continue;
    const Vec3<double> centre =
        rest.depth(u, v) * camera.ray(u, v) + (radius - pressed_by) * at_rest(u, v);
    const auto ball =
        placed<double>(icosphere<double>(5, radius), Eigen::Matrix3d::Identity(), centre);
    const Image<double> object = rasterize(ball, camera).depth;
    Image<double> surface(camera.width, camera.height);
    membrane.press_into(surface, {object, rest.depth, {0, 0, camera.width, camera.height}}, work);
    const auto pressed = outward_normals(surface, camera);
    for (Index y = 0; y < camera.height; ++y) {
      for (Index x = 0; x < camera.width; ++x) {
        const Vec3<double>&before = at_rest(x, y), &after = pressed(x, y);
        if (rest.face(x, y) < 0 || !before.allFinite() || !after.allFinite()) continue;
        if ((after - before).norm() < 0.02) continue;
        const auto& [a, b, c] = rest.barycentric(x, y);
        contacts.pixels.push_back({sensor.surface.face(rest.face(x, y)), {a, b, c}, before, after});
      }
    }
  }
  return contacts;
}

// By how much the contacts change the light on each pixel.
std::vector<double> changes(const Field& light, const Contacts& contacts) {
  std::vector<double> all;
  for (const auto& pixel : contacts.pixels) {
    Vec3<double> here(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      here +=
          pixel.weights[static_cast<int>(k)] * light[static_cast<std::size_t>(pixel.corners[k])];
    }
    all.push_back(std::max(0.0, here.dot(pixel.pressed)) - std::max(0.0, here.dot(pixel.rest)));
  }
  return all;
}

// In the middle of the gel's rim, as large as fits.
TracedLed rim_led(const Sensor& sensor, const Vec3<double>& normal, double thickness) {
  return {
      .place = sensor.surface.position(sensor.led) - thickness / 2 * normal + 1e-5 * sensor.axis,
      .axis = sensor.axis,
      .radius = 0.4 * thickness};
}

/// Irradiance at a pixel, and the standard error of its direction in degrees.
struct PixelLight {
  double irradiance, error;
};

std::vector<PixelLight> light_at_pixels(const Sensor& sensor, const TracedLight& light,
                                        const Raster<double>& seen) {
  std::vector<PixelLight> pixels;
  for (std::size_t i = 0; i < seen.face.pixels().size(); ++i) {
    if (seen.face.pixels()[i] < 0) continue;
    const auto corners = sensor.surface.face(seen.face.pixels()[i]);
    double irradiance = 0, error = 0;
    Vec3<double> way(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(corners[k]);
      const double power = seen.barycentric.pixels()[i][k] * light.irradiance[v];
      if (!(power > 0)) continue;
      irradiance += power;
      way += power * light.directed[v] * light.direction[v];
      error += power * light.directed[v] * std::min(pi, light.direction_error[v]);
    }
    pixels.push_back({irradiance, irradiance > 0 ? error / way.norm() / degree : 180});
  }
  return pixels;
}

// What a trace that leaves 99 % of the bright pixels within a degree takes.
void measure_directions(benchmark::State& state, double edge_length) {
  constexpr double thickness = 0.0025, threshold = 0.01, share = 0.99, radius = 0.01146;
  const Surface<double> surface(membrane<double>(radius, 0.0455, edge_length));
  const Sensor sensor{"fingertip",
                      surface,
                      nearest_vertex<double>(surface, Vec3<double>(radius, 0, 0)),
                      {0, 0, 1},
                      0};
  const auto seen = seen_at_rest(sensor);
  const std::vector<InnerLayer> layers{{beneath(surface, thickness)}};
  const LightTracer tracer(surface, {.albedo = 0}, layers);
  const TracedLed led =
      rim_led(sensor, normals_of(surface)[static_cast<std::size_t>(sensor.led)], thickness);
  std::int64_t paths = 1 << 20;
  std::vector<PixelLight> pixels, bright;
  double seconds = 0;
  TracedLight light;
  const auto trace = [&] {
    seconds = seconds_of([&] { light = tracer.trace(led, {.paths = paths}); });
    pixels = light_at_pixels(sensor, light, seen);
    std::vector<double> irradiance;
    for (const auto& one : pixels) irradiance.push_back(one.irradiance);
    const double least = threshold * percentile(irradiance, 0.99);
    bright.clear();
    for (const auto& one : pixels) {
      if (one.irradiance >= least) bright.push_back(one);
    }
    std::vector<double> errors;
    for (const auto& one : bright) errors.push_back(one.error);
    return percentile(errors, share);
  };
  const auto within = [](const std::vector<PixelLight>& of) {
    return static_cast<double>(std::count_if(of.begin(), of.end(),
                                             [](const auto& one) { return one.error <= 1; })) /
           static_cast<double>(of.size());
  };
  for (auto _ : state) {
    // Errors fall with the root of the paths: a first trace tells how many will do.
    for (double error = trace(); error > 1; error = trace()) {
      const double more =
          std::min(8.0, 1.05 * error * error);  // where few rays came it is not known
      paths = static_cast<std::int64_t>(more * static_cast<double>(paths));
    }
    state.SetIterationTime(seconds);
  }
  state.counters["seconds"] = seconds;
  state.counters["rays_a_second"] = light.balance.segments / seconds;
  state.counters["paths"] = static_cast<double>(paths);
  state.counters["vertices"] = static_cast<double>(surface.vertex_count());
  state.counters["threshold"] = threshold;
  state.counters["counted"] =
      static_cast<double>(bright.size()) / static_cast<double>(pixels.size());
  state.counters["within"] = within(bright);
  state.counters["within_all"] = within(pixels);
}

void measure(benchmark::State& state, const Sensor& sensor, const std::vector<Model>& cheap,
             double thickness, double albedo) {
  const auto& surface = sensor.surface;
  const Places places = places_of(sensor);
  const std::vector<InnerLayer> layers{{beneath(surface, thickness)}};
  const LightTracer tracer(surface, {.albedo = albedo}, layers);
  const auto at_led = static_cast<std::size_t>(sensor.led);
  const TracedLed led = rim_led(sensor, places.normals[at_led], thickness);
  TracedLight light;
  for (auto _ : state) {
    const double seconds = seconds_of([&] { light = tracer.trace(led, {.paths = 300'000}); });
    state.SetIterationTime(seconds);
    state.counters["rays_a_second"] = light.balance.segments / seconds;
  }
  std::vector<Model> models = cheap;
  Model near{"near", {}, 0};
  near.seconds = seconds_of([&] { near.field = near_light(surface, led); });
  models.push_back(near);
  Model mirrored{"mirrored", {}, 0};
  mirrored.seconds = seconds_of([&] {
    mirrored.field =
        mirrored_light(surface, led, places.normals[at_led], thickness, GelOptics{}.index);
  });
  models.push_back(mirrored);
  Model gel{"gel", {}, 0};
  gel.seconds = seconds_of([&] {
    std::vector<Vec3<double>> positions;
    for (Index v = 0; v < surface.vertex_count(); ++v) positions.push_back(surface.position(v));
    gel.field = gel_field<double>({.place = led.place,
                                   .axis = led.axis,
                                   .normal = places.normals[at_led],
                                   .depth = thickness / 2,
                                   .thickness = thickness},
                                  positions, places.normals);
  });
  models.push_back(gel);
  models.push_back({"none", Field(places.normals.size(), Vec3<double>(0, 0, 0)), 0});

  const auto truth = changes(light.vector, places);
  const auto areas = areas_of(places);
  const Contacts contacts = contacts_of(sensor);
  const auto pressed = changes(light.vector, contacts);
  const std::vector<double> alike(pressed.size(), 1);
  if (pressed.size() < 1000) state.SkipWithError("the camera sees no contacts");
  double weights = 0, tilt = 0, directed = 0, error = 0;
  std::vector<double> irradiance;
  for (const std::size_t v : places.vertices) {
    irradiance.push_back(light.irradiance[v]);
    const double weight = places.areas[v] * light.irradiance[v];
    weights += weight;
    tilt += weight * std::asin(std::clamp(light.direction[v].dot(places.normals[v]), -1.0, 1.0));
    directed += weight * light.directed[v];
    error += weight * std::min(pi, light.direction_error[v]);
  }
  state.counters["tilt"] = tilt / weights / degree;
  state.counters["directed"] = directed / weights;
  state.counters["direction_error"] = error / weights / degree;
  state.counters["falloff"] = percentile(irradiance, 0.05) / percentile(irradiance, 0.95);
  for (const Model& model : models) {
    double off = 0, azimuth = 0;
    for (const std::size_t v : places.vertices) {
      const double weight = places.areas[v] * light.irradiance[v] / weights;
      off += weight * angle(light.direction[v], model.field[v]);
      azimuth += weight * angle(laid(light.direction[v], places.normals[v]),
                                laid(model.field[v], places.normals[v]));
    }
    const auto is_one_of = [&](std::initializer_list<const char*> names) {
      return std::find(names.begin(), names.end(), model.name) != names.end();
    };
    state.counters["levels_" + model.name] = levels(truth, changes(model.field, places), areas);
    state.counters["contact_" + model.name] =
        levels(pressed, changes(model.field, contacts), alike);
    // Where a field differs from another by its strength alone, its direction is that one's.
    if (is_one_of({"none", "linear_dimmed", "geodesic_dimmed"})) continue;
    state.counters["angle_" + model.name] = off;
    if (is_one_of({"linear", "geodesic"})) state.counters["azimuth_" + model.name] = azimuth;
    if (is_one_of({"gel", "geodesic"})) state.counters["seconds_" + model.name] = model.seconds;
    Field as_strong = light.vector;
    for (std::size_t v = 0; v < as_strong.size(); ++v) {
      as_strong[v] = light.vector[v].norm() * detail::direction_of(model.field[v]);
    }
    state.counters["given_" + model.name] = levels(truth, changes(as_strong, places), areas);
  }
  const auto& b = light.balance;
  const double sum = b.coating + b.gel + b.lost + b.cut;
  if (!(std::abs(sum - 1) < 0.02)) state.SkipWithError("light was lost or made");
}

}  // namespace

int main(int argc, char** argv) try {
  static const auto all = sensors();
  static std::map<std::string, std::vector<Model>> models;
  for (const Sensor& sensor : all) {
    for (const double thickness : {0.001, 0.0025, 0.005}) {
      for (const double albedo : {0.0, 0.3, 0.7}) {
        char name[80];
        std::snprintf(name, sizeof name, "traced/%s/%g mm/albedo %g", sensor.name.c_str(),
                      1e3 * thickness, albedo);
        benchmark::RegisterBenchmark(name,
                                     [&sensor, thickness, albedo](benchmark::State& state) {
                                       auto& cheap = models[sensor.name];
                                       if (cheap.empty()) cheap = models_of(sensor);
                                       measure(state, sensor, cheap, thickness, albedo);
                                     })
            ->UseManualTime()
            ->Iterations(1)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  for (const double length : {edge, edge / 2}) {
    char name[80];
    std::snprintf(name, sizeof name, "directions/fingertip/edges of %.2g mm", 1e3 * length);
    benchmark::RegisterBenchmark(
        name, [length](benchmark::State& state) { measure_directions(state, length); })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
  }
  return gelight::bench::run(argc, argv);
} catch (...) {
  return told();
}
