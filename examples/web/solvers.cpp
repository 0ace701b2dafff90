// Distances by every solver, and the light that follows them.

#include <cmath>

#include "choices.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/light/models.hpp"

namespace page {

using gelight::Vec3;

namespace {

template <class Model>
Light light_of(Model model) {
  const auto shared = std::make_shared<Model>(std::move(model));
  return {[shared](const gelight::Led<float>& led, std::span<const Point> points) {
    return shared->field(led, points);
  }};
}

template <class Solver>
Distances distances_of(Solver solver) {
  const auto shared = std::make_shared<Solver>(std::move(solver));
  return [shared](const Point& from) {
    const gelight::Source<float> source{from, 0};
    return shared->distance(std::span(&source, 1));
  };
}

// A light model of one's own (concepts/light.hpp): down the slope of a solver's distances.
class SlopeLight {
 public:
  SlopeLight(const Mesh& membrane, SolverKind kind)
      : surface_(membrane), distances_(make_solver(kind, membrane)) {}

  [[nodiscard]] std::vector<Vec3<float>> field(const gelight::Led<float>& led,
                                               std::span<const Point> points,
                                               const gelight::CancelHook& = {}) const {
    const std::vector<Vec3<float>> slopes = slopes_at_vertices(distances_(led.points.at(0)));
    std::vector<Vec3<float>> directions;
    directions.reserve(points.size());
    for (const Point& point : points) {
      const auto corners = surface_.face(point.element[0]);  // pixels show points in faces
      Vec3<float> sum = Vec3<float>::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        sum += point.weights[k] * slopes[static_cast<std::size_t>(corners[k])];
      }
      directions.push_back(gelight::detail::stable_unit(sum));
    }
    return directions;
  }

 private:
  [[nodiscard]] std::vector<Vec3<float>> slopes_at_vertices(const std::vector<float>& value) const {
    std::vector<Vec3<float>> slopes(value.size(), Vec3<float>::Zero());
    for (Index f = 0; f < surface_.face_count(); ++f) {
      const auto corners = surface_.face(f);
      const Vec3<float> a = surface_.position(corners[0]), b = surface_.position(corners[1]),
                        c = surface_.position(corners[2]);
      const Vec3<float> normal = gelight::detail::stable_unit(gelight::cross<float>(b - a, c - a));
      // Of each corner, the value times the opposite edge turned by a right angle.
      Vec3<float> slope = Vec3<float>::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3<float> edge =
            surface_.position(corners[(k + 2) % 3]) - surface_.position(corners[(k + 1) % 3]);
        slope += value[static_cast<std::size_t>(corners[k])] * gelight::cross<float>(normal, edge);
      }
      // Each face counts by its area: the slope times twice the area is this sum.
      for (const Index v : corners) slopes[static_cast<std::size_t>(v)] += slope;
    }
    for (Vec3<float>& slope : slopes) slope = gelight::detail::stable_unit(slope);
    return slopes;
  }

  Surface surface_;
  Distances distances_;
};

}  // namespace

Distances make_solver(SolverKind kind, const Mesh& membrane) {
  switch (kind) {
    case SolverKind::exact:
      return distances_of(gelight::ExactSolver<float>(membrane));
    case SolverKind::virtual_source:
      return distances_of(gelight::VirtualSourceSolver<float>(membrane));
    case SolverKind::fast_marching:
      return distances_of(gelight::FastMarchingSolver<float>(membrane));
    case SolverKind::heat:
      return distances_of(gelight::HeatSolver<float>(membrane));
    case SolverKind::steiner:
      return distances_of(gelight::DijkstraSolver<float>(membrane, {.steiner_points = 3}));
    case SolverKind::dijkstra:
      return distances_of(gelight::DijkstraSolver<float>(membrane));
  }
  gelight::detail::require(false, "there is no solver ", static_cast<int>(kind));
  return {};
}

Light make_light(LightKind kind, SolverKind solver, const Mesh& membrane) {
  switch (kind) {
    case LightKind::linear:
      return light_of(gelight::LinearLight<float>(membrane));
    case LightKind::plane:
      return make_plane_light(membrane);
    case LightKind::transport:
      return make_transport_light(membrane);
    case LightKind::geodesic:
      if (solver != SolverKind::exact) return light_of(SlopeLight(membrane, solver));
      return light_of(gelight::GeodesicLight<float>(membrane));
  }
  gelight::detail::require(false, "there is no light model ", static_cast<int>(kind));
  return {};
}

Lights make_lights(const Sensor& sensor, const gelight::Raster<float>& rest, const Light& light) {
  const Surface membrane(sensor.membrane);
  const auto points = gelight::pixel_points(rest);
  Lights lights;
  for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
    lights.push_back({gelight::bake(gelight::led_field(sensor, membrane, k, light, points), rest),
                      sensor.colours[k], sensor.diffuse, sensor.specular, sensor.shininess});
  }
  return lights;
}

}  // namespace page
