#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/light.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/models.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/views/mesh_view.hpp"

// Sensors as somebody built them, ready to render: `tactile_renderer(geltip())`.
namespace gelight {

/// A sensor in metres and in the frame of its camera.
template <std::floating_point T>
struct SensorPreset {
  Mesh<T> membrane;                                  ///< at rest, seen from inside
  Camera<T> camera;                                  ///< inside it
  std::vector<SurfacePoint<T>> leds;                 ///< where on the membrane light enters
  std::vector<std::array<T, 3>> colours;             ///< of each LED, in shares of full light
  std::array<T, 3> coating{T(0.9), T(0.9), T(0.9)};  ///< what the coating reflects of each colour
  Falloff<T> falloff = {};  ///< how the light that the coating scatters fades with the distance
  T diffuse = T(0.5);       ///< Phong's k_d
  T specular = T(0.1);      ///< Phong's k_s
  T shininess = 100;        ///< Phong's exponent
  TactileOptions options = {.ambient =
                                0.9};  ///< but for `rectify`, which follows from the light model
  Gel gel = {};                        ///< what the membrane is made of
};

/// The vertices of a membrane's border that are nearest to some directions from its middle, angles
/// about the camera's axis in radians from x towards y: where LEDs are. Throws InvalidInput as
/// Surface does, for a membrane without a border and for an angle that is not finite.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> leds_on_border(
    const Mesh<T>& membrane, std::type_identity_t<std::span<const T>> angles) {
  const Surface<T> surface(membrane);
  std::vector<Index> border;
  Vec3<T> middle = Vec3<T>::Zero();
  for (Index h = 0; h < 3 * surface.face_count(); ++h) {
    if (surface.twin(h) != h) continue;
    border.push_back(surface.face(h / 3)[static_cast<std::size_t>(h % 3)]);
    middle += surface.position(border.back());
  }
  detail::require(!border.empty(), "the membrane has no border to put LEDs on");
  middle /= static_cast<T>(border.size());
  std::vector<SurfacePoint<T>> leds;
  for (const T angle : angles) {
    detail::require(std::isfinite(angle), "an LED at the angle ", angle);
    Index nearest = border[0];
    T most = -2;
    for (const Index v : border) {
      const Vec3<T> from = surface.position(v) - middle;
      const T along = std::hypot(from.x(), from.y());
      const T cosine = (std::cos(angle) * from.x() + std::sin(angle) * from.y()) / along;
      if (cosine > most) nearest = v;
      most = std::max(most, cosine);
    }
    leds.push_back(vertex_point<T>(nearest));
  }
  return leds;
}

namespace detail {

/// A rectangular pad across the camera's axis, its middle at `distance`; bent away from the camera
/// with a radius, if that is finite.
template <std::floating_point T>
[[nodiscard]] Mesh<T> pad(T width, T height, T distance, T radius, T edge_length) {
  require(edge_length > 0 && edge_length <= std::min(width, height), "a pad of ", width, " x ",
          height, " with edge length ", edge_length);
  const auto cells = [&](T side) { return static_cast<Index>(std::ceil(side / edge_length)); };
  Mesh<T> mesh = grid<T>(cells(width), cells(height), width, height);
  for (auto& [x, y, z] : mesh.positions) {
    x -= width / 2;
    y -= height / 2;
    const T square = x * x + y * y;
    z = distance;
    if (std::isfinite(radius)) z -= square / (radius + std::sqrt(radius * radius - square));
  }
  return mesh;
}

template <std::floating_point T>
[[nodiscard]] std::vector<T> turns(std::initializer_list<double> degrees) {
  std::vector<T> angles;
  for (const double angle : degrees) {
    angles.push_back(static_cast<T>(angle * std::numbers::pi / 180));
  }
  return angles;
}

/// A camera that just sees all of a pad.
template <std::floating_point T>
[[nodiscard]] Camera<T> facing_pad(T height, T distance, Index columns, Index rows) {
  return Camera<T>::from_vertical_fov(2 * std::atan(height / (2 * distance)), columns, rows);
}

}  // namespace detail

/// The GelTip: a finger with a camera in the middle of its open end that looks at the tip, and
/// three LEDs at vertices of the rim. Radius, length, field of view (90 degrees from top to bottom)
/// and the LEDs' places and colours are those of Gomes, Paoletti, Luo, Simulation of Curved
/// GelSight Sensors for Sim2Real Learning; the falloff is an estimate. Throws InvalidInput for a
/// size that is not positive and as `membrane` does for the mesh's edge length.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> geltip(Index width = 640, Index height = 480,
                                     std::type_identity_t<T> edge_length = T(0.001)) {
  constexpr T radius = T(0.01146), length = T(0.0455);
  SensorPreset<T> sensor;
  sensor.membrane = membrane<T>(radius, length, edge_length);
  sensor.camera = Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 2, width, height);
  sensor.leds = leds_on_border(sensor.membrane, detail::turns<T>({0, 120, 240}));
  sensor.colours = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  sensor.falloff = {.absorption = T(30)};
  return sensor;
}

/// GelSight Mini: a flat gel of which the camera sees 18.6 x 14.3 mm, with red, green and blue
/// light from three sides. That size is what users of the sensor quote from the data sheet of its
/// maker, GelSight Inc.; it was not checked on a sensor. The gel's thickness, the camera's
/// distance, 20 mm, the sides and the falloff are estimates. Throws InvalidInput as `geltip` does.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> gelsight_mini(Index width = 640, Index height = 480,
                                            std::type_identity_t<T> edge_length = T(0.0005)) {
  constexpr T across = T(0.0186), down = T(0.0143), distance = T(0.020);
  SensorPreset<T> sensor;
  sensor.membrane =
      detail::pad<T>(T(1.02) * across, T(1.02) * down, distance, unreachable<T>, edge_length);
  sensor.camera = detail::facing_pad<T>(down, distance, width, height);
  sensor.leds = leds_on_border(sensor.membrane, detail::turns<T>({90, 180, 0}));
  sensor.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  sensor.falloff = {.absorption = T(100)};
  sensor.gel = {.thickness = 0.004};
  return sensor;
}

/// DIGIT: a pad of 20 x 30 mm, bent with a radius of 100 mm, 22 mm before a camera that sees 60
/// degrees from top to bottom, with red, green and blue LEDs around it: the numbers of TACTO's
/// model of it (Wang, Lambeta, Chou, Calandra, 2022, doi:10.1109/LRA.2022.3146945), of the sensor
/// of Lambeta et al., 2020, doi:10.1109/LRA.2020.2977257. The falloff is an estimate. Throws
/// InvalidInput as `geltip` does.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> digit(Index width = 240, Index height = 320,
                                    std::type_identity_t<T> edge_length = T(0.0005)) {
  SensorPreset<T> sensor;
  sensor.membrane = detail::pad<T>(T(0.020), T(0.030), T(0.022), T(0.1), edge_length);
  sensor.camera = Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 3, width, height);
  sensor.leds = leds_on_border(sensor.membrane, detail::turns<T>({30, 150, 270}));
  sensor.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  sensor.falloff = {.absorption = T(80)};
  sensor.gel = {.thickness = 0.005};
  return sensor;
}

/// The see-through sensor, lit inside: a flat gel with light from four sides, red, green, blue and
/// white, Phong's coefficients those of Hogan, Jenkin, Rezaei-Shoshtari, Girdhar, Meger, Dudek,
/// Seeing Through your Skin, 2021, doi:10.1109/WACV48630.2021.00126. Its size, 40 x 30 mm, 30 mm
/// before the camera, and the falloff are estimates. (SeeThroughRenderer is the sensor in all its
/// light.) Throws InvalidInput as `geltip` does.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> sts(Index width = 640, Index height = 480,
                                  std::type_identity_t<T> edge_length = T(0.001)) {
  constexpr T across = T(0.040), down = T(0.030), distance = T(0.030);
  SensorPreset<T> sensor;
  sensor.membrane =
      detail::pad<T>(T(1.02) * across, T(1.02) * down, distance, unreachable<T>, edge_length);
  sensor.camera = detail::facing_pad<T>(down, distance, width, height);
  sensor.leds = leds_on_border(sensor.membrane, detail::turns<T>({0, 180, 90, 270}));
  sensor.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {T(0.6), T(0.6), T(0.6)}};
  sensor.falloff = {.absorption = T(60)};
  sensor.diffuse = 1;
  sensor.specular = T(0.5);
  sensor.shininess = 5;
  return sensor;
}

/// What the camera of a sensor sees of its coating by the light that this scatters: each LED's
/// colour, faded with the straight distance, in shares of full light; black beside the membrane.
/// Throws InvalidInput unless there is a colour for each LED, and as `strength` does.
template <std::floating_point T>
[[nodiscard]] Background<T> coating_light(const SensorPreset<T>& sensor, const Raster<T>& rest) {
  detail::require(sensor.leds.size() == sensor.colours.size(), "there are ", sensor.leds.size(),
                  " LEDs and ", sensor.colours.size(), " colours");
  const Surface<T> surface(sensor.membrane);
  Image<std::array<T, 3>> seen(sensor.camera.width, sensor.camera.height);
  for (Index y = 0; y < seen.height(); ++y) {
    for (Index x = 0; x < seen.width(); ++x) {
      if (rest.face(x, y) < 0) continue;
      const Vec3<T> place =
          sensor.camera.unproject(static_cast<T>(x), static_cast<T>(y), rest.depth(x, y));
      for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
        const T distance = (place - surface.position(sensor.leds[k])).norm();
        const T share = strength(std::span(&distance, 1), sensor.falloff)[0];
        for (std::size_t c = 0; c < 3; ++c) {
          seen(x, y)[c] += sensor.coating[c] * share * sensor.colours[k][c];
        }
      }
      for (T& channel : seen(x, y)) channel = std::min(channel, T(1));
    }
  }
  return seen;
}

/// The renderer of a sensor, its light by any light model: the GelTip's by default, along the
/// shortest paths on the membrane. Takes as long as the model's fields. Throws InvalidInput unless
/// there is a colour for each LED, and as the parts do.
///@{
template <std::floating_point T, LightModel<T> Model>
[[nodiscard]] TactileRenderer<T> tactile_renderer(const SensorPreset<T>& sensor,
                                                  const Model& model) {
  const Raster<T> rest = rasterize(sensor.membrane, sensor.camera);
  const Background<T> background = coating_light(sensor, rest);
  const auto points = pixel_points(rest);
  std::vector<Light<T>> lights;
  for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
    const Led<T> led{{sensor.leds[k]}};
    lights.push_back({bake(model.field(led, points), rest), sensor.colours[k], sensor.diffuse,
                      sensor.specular, sensor.shininess});
  }
  TactileOptions options = sensor.options;
  if constexpr (requires { Model::is_tangent; }) options.rectify = Model::is_tangent;
  return {sensor.camera, rest.depth, lights, background, options};
}
template <std::floating_point T>
[[nodiscard]] TactileRenderer<T> tactile_renderer(const SensorPreset<T>& sensor) {
  return tactile_renderer(sensor, GeodesicLight<T>(sensor.membrane));
}
///@}

}  // namespace gelight
