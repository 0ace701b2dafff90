#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "gelight/light/models.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/sensor/presets.hpp"

// What the page lets its visitor choose. The order of each list is that of choices.js.

namespace page {

using gelight::Index;
using Mesh = gelight::Mesh<float>;
using Surface = gelight::Surface<float>;
using Sensor = gelight::SensorPreset<float>;
using Point = gelight::SurfacePoint<float>;
using Lights = std::vector<gelight::Light<float>>;

enum class SensorKind { geltip, dome, pad, paw };
enum class ObjectKind { ball, ring, cube, screw, bearing, braille };
enum class LightKind { linear, plane, geodesic, transport };
enum class SmoothingKind { none, gaussian, wide, layer };
enum class SolverKind { exact, virtual_source, fast_marching, heat, steiner, dijkstra };

Sensor make_sensor(SensorKind kind, Index width, Index height, float edge);

/// Its lowest point is the origin, and it stands on that along z.
Mesh make_object(ObjectKind kind);

/// Distances from a point to all vertices, by a solver that is set up here.
using Distances = std::function<std::vector<float>(const Point& from)>;
Distances make_solver(SolverKind kind, const Mesh& membrane);

/// A light model of any kind (concepts/light.hpp).
struct Light {
  std::function<gelight::LightField<float>(const gelight::Led<float>&, std::span<const Point>)> of;

  [[nodiscard]] gelight::LightField<float> field(const gelight::Led<float>& led,
                                                 std::span<const Point> points,
                                                 const gelight::CancelHook& = {}) const {
    return of(led, points);
  }
};

/// Geodesic light runs along shortest paths by the solver: exactly, or down the slope of the
/// distances at the vertices.
Light make_light(LightKind kind, SolverKind solver, const Mesh& membrane);
Light make_plane_light(const Mesh& membrane);
Light make_transport_light(const Mesh& membrane);

/// The light of a sensor's LEDs, each as its camera sees it.
Lights make_lights(const Sensor& sensor, const gelight::Raster<float>& rest, const Light& light);

/// What turns a depth image into a tactile image, of any smoothing.
class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual void render(gelight::TactileFrame<float>& frame,
                      const gelight::Image<float>& depth) const = 0;
  [[nodiscard]] virtual gelight::TactileFrame<float> rest() const = 0;
};
std::unique_ptr<Renderer> make_renderer(const Sensor& sensor, const gelight::Raster<float>& rest,
                                        const Lights& lights, LightKind light, SmoothingKind kind);

}  // namespace page
