// What the page calls: plain functions with numbers in and out. Each answers how many numbers it
// left at `answer()`, or -1 with the reason in `reason()`.

#include "page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "choices.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/isoline.hpp"
#include "gelight/image/raster.hpp"

namespace page {

namespace {

using gelight::Vec3;

/// One finger, what touches it, and what is known of them so far.
struct State {
  Sensor sensor;
  std::optional<Surface> surface;
  gelight::Raster<float> rest;
  std::vector<Vec3<float>> normals;  // of the vertices, away from the camera
  std::optional<gelight::ExactSolver<float>> exact;
  std::map<std::size_t, gelight::ExactField<float>> fields;  // of an LED
  std::map<SolverKind, Distances> solvers;
  std::map<std::pair<LightKind, SolverKind>, Lights> lights;
  std::unique_ptr<Renderer> renderer;
  gelight::TactileFrame<float> frame;

  Mesh object;
  gelight::RasterWorkspace work;
  gelight::Image<float> depth;
  std::vector<std::uint8_t> rgba;
  std::vector<float> values;  // the distances asked for last

  std::vector<float> answer;
  std::string reason;
};

State& state() {
  static State the_state;
  return the_state;
}

template <class Work>
int answered(const Work& work) {
  State& s = state();
  try {
    s.answer.clear();
    s.reason.clear();
    work(s);
    return static_cast<int>(s.answer.size());
  } catch (const std::exception& error) {
    s.reason = error.what();
    return -1;
  }
}

void add(std::vector<float>& answer, const Vec3<float>& p) {
  answer.insert(answer.end(), {p[0], p[1], p[2]});
}

std::vector<Vec3<float>> outward_normals(const Surface& surface) {
  std::vector<Vec3<float>> normals(static_cast<std::size_t>(surface.vertex_count()),
                                   Vec3<float>::Zero());
  for (Index f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    const Vec3<float> a = surface.position(face[0]);
    Vec3<float> normal =
        gelight::cross<float>(surface.position(face[1]) - a, surface.position(face[2]) - a);
    if (normal.dot(a) < 0) normal = -normal;
    for (const Index v : face) normals[static_cast<std::size_t>(v)] += normal;
  }
  return normals;
}

void copy_image(State& s) {
  const auto& pixels = s.frame.image.pixels();
  s.rgba.resize(4 * pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) s.rgba[4 * i + c] = pixels[i][c];
    s.rgba[4 * i + 3] = 255;
  }
}

/// The pixel nearest to this one, on the way to the middle, that shows the membrane.
std::pair<Index, Index> shown_pixel(const State& s, float u, float v) {
  const auto& camera = s.sensor.camera;
  gelight::detail::require(std::isfinite(u) && std::isfinite(v), "the pixel (", u, ", ", v, ")");
  for (int step = 0; step <= 100; ++step) {
    const float t = static_cast<float>(step) / 100;
    const auto x = static_cast<Index>(std::clamp(std::round(u + t * (camera.cx - u)), 0.0f,
                                                 static_cast<float>(camera.width - 1)));
    const auto y = static_cast<Index>(std::clamp(std::round(v + t * (camera.cy - v)), 0.0f,
                                                 static_cast<float>(camera.height - 1)));
    if (s.rest.face(x, y) >= 0) return {x, y};
  }
  gelight::detail::require(false, "the camera sees no membrane");
  return {};
}

Point point_at(const State& s, float u, float v) {
  const auto [x, y] = shown_pixel(s, u, v);
  return gelight::face_point<float>(s.rest.face(x, y), s.rest.barycentric(x, y));
}

Vec3<float> normal_at(const State& s, const Point& point) {
  const auto face = s.surface->face(point.element[0]);
  Vec3<float> sum = Vec3<float>::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    sum += point.weights[k] * s.normals[static_cast<std::size_t>(face[k])];
  }
  return gelight::detail::stable_unit(sum);
}

/// An object that stands on the membrane along its normal, turned about it, and pressed in.
gelight::Pose pose_at(const State& s, float u, float v, float depth, float turn) {
  const Point point = point_at(s, u, v);
  const Vec3<double> z = normal_at(s, point).cast<double>();
  const Vec3<double> across{std::cos(turn), std::sin(turn), 0};
  const Vec3<double> x = (across - across.dot(z) * z).normalized();
  gelight::Pose pose;
  pose.rotation.col(0) = x;
  pose.rotation.col(1) = gelight::cross<double>(z, x);
  pose.rotation.col(2) = z;
  pose.translation = s.surface->position(point).cast<double>() - double{depth} * z;
  return pose;
}

const gelight::ExactField<float>& field_of(State& s, int led) {
  const auto k = static_cast<std::size_t>(led);
  gelight::detail::require(k < s.sensor.leds.size(), "there is no LED ", led);
  if (!s.exact) s.exact.emplace(s.sensor.membrane);
  const auto found = s.fields.find(k);
  if (found != s.fields.end()) return found->second;
  gelight::ExactOptions<float> options;
  options.keep_windows = true;
  return s.fields.emplace(k, s.exact->solve(s.sensor.leds[k], options)).first->second;
}

/// A path as pieces of two points each.
void add_pieces(State& s, const gelight::Path<float>& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    add(s.answer, s.surface->position(path[i - 1]));
    add(s.answer, s.surface->position(path[i]));
  }
}

}  // namespace

extern "C" {

const char* reason() { return state().reason.c_str(); }
const float* answer() { return state().answer.data(); }
const unsigned char* image() { return state().rgba.data(); }

int set_sensor(int kind, int width, int height, float edge) {
  return answered([&](State& s) {
    const Mesh object = s.object;
    Sensor sensor = make_sensor(static_cast<SensorKind>(kind), width, height, edge);
    Surface surface(sensor.membrane);
    auto rest = gelight::rasterize(sensor.membrane, sensor.camera);
    s = State();
    s.object = object;
    s.sensor = std::move(sensor);
    s.surface.emplace(std::move(surface));
    s.normals = outward_normals(*s.surface);
    s.rest = std::move(rest);
    s.depth = gelight::Image<float>(width, height);
    const auto& camera = s.sensor.camera;
    s.answer = {camera.fx, camera.fy, camera.cx, camera.cy};
  });
}

int set_object(int kind) {
  return answered([&](State& s) { s.object = make_object(static_cast<ObjectKind>(kind)); });
}

int set_renderer(int light, int smoothing, int solver) {
  return answered([&](State& s) {
    const auto which = static_cast<LightKind>(light);
    const auto by =
        which == LightKind::geodesic ? static_cast<SolverKind>(solver) : SolverKind::exact;
    auto found = s.lights.find({which, by});
    if (found == s.lights.end()) {
      found = s.lights
                  .emplace(std::pair(which, by),
                           make_lights(s.sensor, s.rest, make_light(which, by, s.sensor.membrane)))
                  .first;
    }
    s.renderer = make_renderer(s.sensor, s.rest, found->second, which,
                               static_cast<SmoothingKind>(smoothing));
    s.frame = s.renderer->rest();
    copy_image(s);
  });
}

int lift() {
  return answered([&](State& s) {
    s.frame = s.renderer->rest();
    copy_image(s);
  });
}

int press(float u, float v, float depth, float turn) {
  return answered([&](State& s) {
    gelight::detail::require(s.renderer != nullptr, "there is no renderer yet");
    const gelight::Pose pose = pose_at(s, u, v, depth, turn);
    std::fill(s.depth.pixels().begin(), s.depth.pixels().end(),
              std::numeric_limits<float>::infinity());
    gelight::rasterize_into(s.depth, s.object, pose, s.sensor.camera, &s.work);
    s.renderer->render(s.frame, s.depth);
    copy_image(s);
    for (int k = 0; k < 3; ++k) add(s.answer, pose.rotation.col(k).cast<float>());
    add(s.answer, pose.translation.cast<float>());
  });
}

int mesh_positions(int of_object) {
  return answered([&](State& s) {
    for (const auto& p : (of_object != 0 ? s.object : s.sensor.membrane).positions) {
      s.answer.insert(s.answer.end(), p.begin(), p.end());
    }
  });
}

int mesh_faces(int of_object) {
  return answered([&](State& s) {
    for (const auto& face : (of_object != 0 ? s.object : s.sensor.membrane).faces) {
      for (const Index v : face) s.answer.push_back(static_cast<float>(v));
    }
  });
}

int leds() {
  return answered([&](State& s) {
    for (std::size_t k = 0; k < s.sensor.leds.size(); ++k) {
      add(s.answer, s.surface->position(s.sensor.leds[k]));
      for (const float share : s.sensor.colours[k]) s.answer.push_back(share);
    }
  });
}

int set_solver(int solver) {
  return answered([&](State& s) {
    const auto kind = static_cast<SolverKind>(solver);
    s.solvers[kind] = make_solver(kind, s.sensor.membrane);
  });
}

int distances(int solver, int led) {
  return answered([&](State& s) {
    const auto kind = static_cast<SolverKind>(solver);
    const auto k = static_cast<std::size_t>(led);
    gelight::detail::require(k < s.sensor.leds.size(), "there is no LED ", led);
    if (!s.solvers.contains(kind)) s.solvers[kind] = make_solver(kind, s.sensor.membrane);
    s.values = s.solvers[kind](s.sensor.leds[k]);
    s.answer = s.values;
  });
}

int isolines(float step) {
  return answered([&](State& s) {
    gelight::detail::require(step > 0, "isolines ", step, " apart");
    float farthest = 0;
    for (const float value : s.values) {
      if (value < gelight::unreachable<float>) farthest = std::max(farthest, value);
    }
    for (float level = step; level < farthest; level += step) {
      for (const auto& line : gelight::isolines<float>(*s.surface, s.values, level)) {
        add_pieces(s, line.points);
      }
    }
  });
}

int path(int led, float u, float v) {
  return answered([&](State& s) { add_pieces(s, field_of(s, led).path(point_at(s, u, v))); });
}

int fan(int led, int count) {
  return answered([&](State& s) {
    gelight::detail::require(count > 0, count, " paths");
    const auto& field = field_of(s, led);
    const Index vertices = s.surface->vertex_count();
    for (int k = 0; k < count; ++k) {
      const auto v = static_cast<Index>((k + 0.5) * vertices / count);
      if (field.distance(v) < gelight::unreachable<float>) add_pieces(s, field.path(v));
    }
  });
}
}

}  // namespace page
