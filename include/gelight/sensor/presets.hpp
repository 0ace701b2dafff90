#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/light.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/models.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

/// A sensor in metres and in the frame of its camera.
template <std::floating_point T>
struct SensorPreset {
  /// At rest, seen from inside; light runs over it where faces share vertices.
  Mesh<T> membrane;
  Camera<T> camera;                                  ///< inside it
  std::vector<SurfacePoint<T>> leds;                 ///< where on the membrane light enters
  std::vector<std::array<T, 3>> colours;             ///< of each LED, in shares of full light
  std::array<T, 3> coating{T(0.9), T(0.9), T(0.9)};  ///< what the coating reflects of each colour
  Falloff<T> falloff = {};  ///< how the light that the coating scatters fades with the distance
  T diffuse = T(0.5);       ///< Phong's k_d
  T specular = T(0.1);      ///< Phong's k_s
  T shininess = 100;        ///< Phong's exponent
  /// But for `rectify`, which follows from the light model.
  TactileOptions options = {.ambient = 0.9, .border_normals = BorderNormals::extrapolated};
  Gel gel = {};  ///< what the membrane is made of
  /// How far from an LED its light is full, in m, for a model whose light falls off (`gel_light`).
  T full_within = T(0.01);
  /// Of each LED, m along the border, its place in the middle; 0: a point. Unset: a point for light
  /// that runs in the membrane, as the GelTip's authors have it; for light that leaves an LED one
  /// way (`GelLight`), whose shadows are as hard as the LED is small, 3 mm in 24 parts.
  std::optional<T> led_width = {};
  Index led_parts = 3;  ///< points that stand for an LED with a width, their light averaged
};

/// The vertices of a membrane's border that are nearest to some directions from its middle, angles
/// about the camera's axis in radians from x towards y: where LEDs are. Throws InvalidInput as
/// Surface does, for a membrane without a border and for an angle that is not finite.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> leds_on_border(
    const Mesh<T>& membrane, std::type_identity_t<std::span<const T>> angles);

/// The points of a membrane's border that are seen from its middle in some directions, angles about
/// the camera's axis in radians from x towards y: where LEDs are, whatever the mesh. The farthest,
/// where there are several. Throws InvalidInput as Surface does, for a membrane without a border
/// that is seen there and for an angle that is not finite.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> points_of_border(
    const Mesh<T>& membrane, std::type_identity_t<std::span<const T>> angles);

/// Points of an LED that lies along a membrane's border, the middles of `count` parts as long as
/// each other, about the LED's middle. Throws InvalidInput for a middle that is not on the border,
/// a width that is negative or longer than half of that border, no parts, and a border that meets
/// an edge of three faces or more.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> points_along_border(const Surface<T>& surface,
                                                               const SurfacePoint<T>& middle,
                                                               std::type_identity_t<T> width,
                                                               Index count);

/// The GelTip: a finger with a camera in the middle of its open end that looks at the tip, and
/// three LEDs on the rim. Radius, length, field of view (90 degrees from top to bottom)
/// and the LEDs' places and colours are those of Gomes, Paoletti, Luo 2023,
/// doi:10.15607/RSS.2023.XIX.035; the falloff and `full_within` are estimates. Throws InvalidInput
/// for a size that is not positive and as `membrane` does for the mesh's edge length.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> geltip(Index width = 640, Index height = 480,
                                     std::type_identity_t<T> edge_length = T(0.001));

/// GelSight Mini: a flat gel of which the camera sees 18.6 x 14.3 mm, with red, green and blue
/// light from three sides. That size is what users of the sensor quote from the data sheet of its
/// maker, GelSight Inc.; it was not checked on a sensor. The gel's thickness, the camera's
/// distance, 20 mm, the sides and the falloff are estimates. Throws InvalidInput as `geltip` does.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> gelsight_mini(Index width = 640, Index height = 480,
                                            std::type_identity_t<T> edge_length = T(0.0005));

/// DIGIT: a pad of 20 x 30 mm, bent with a radius of 100 mm, 22 mm before a camera that sees 60
/// degrees from top to bottom, with red, green and blue LEDs around it: the numbers of TACTO's
/// model of it (Wang, Lambeta, Chou, Calandra, 2022, doi:10.1109/LRA.2022.3146945), of the sensor
/// of Lambeta et al., 2020, doi:10.1109/LRA.2020.2977257. The falloff is an estimate. Throws
/// InvalidInput as `geltip` does.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> digit(Index width = 240, Index height = 320,
                                    std::type_identity_t<T> edge_length = T(0.0005));

/// The see-through sensor, lit inside: a flat gel with light from four sides, red, green, blue and
/// white, Phong's coefficients those of Hogan, Jenkin, Rezaei-Shoshtari, Girdhar, Meger, Dudek,
/// Seeing Through your Skin, 2021, doi:10.1109/WACV48630.2021.00126. Its size, 40 x 30 mm, 30 mm
/// before the camera, and the falloff are estimates. (SeeThroughRenderer is the sensor in all its
/// light.) Throws InvalidInput as `geltip` does.
template <std::floating_point T = float>
[[nodiscard]] SensorPreset<T> sts(Index width = 640, Index height = 480,
                                  std::type_identity_t<T> edge_length = T(0.001));

/// What the camera of a sensor sees of its coating by the light that this scatters: each LED's
/// colour, faded with the straight distance, in shares of full light; black beside the membrane.
/// Throws InvalidInput unless there is a colour for each LED, for a coating that does not reflect
/// shares of the light, for a raster of another size than the camera's image, and as `strength`
/// does.
template <std::floating_point T>
[[nodiscard]] Background<T> coating_light(const SensorPreset<T>& sensor, const Raster<T>& rest);

namespace detail {
template <std::floating_point T>
auto seen_coating(const SensorPreset<T>& sensor, const Surface<T>& surface, const Camera<T>& camera,
                  const Raster<T>& rest) -> Image<std::array<T, 3>>;
template <std::floating_point T>
void require_seen(const Raster<T>& rest);
template <std::floating_point T>
auto inwards(const Surface<T>& surface, const SurfacePoint<T>& led) -> Vec3<T>;
template <std::floating_point T>
auto usual_led(const Surface<T>& surface, const SurfacePoint<T>& led)
    -> std::vector<SurfacePoint<T>>;
template <std::floating_point T>
auto beside_lights(Image<std::array<T, 3>> coating, const Camera<T>& camera, const Image<T>& rest,
                   const std::vector<Light<T>>& lights, const TactileOptions& options)
    -> Image<std::array<T, 3>>;
}  // namespace detail

/// The light of a sensor's LED at some points of its membrane, by any light model: of each of the
/// LED's parts, their mean. Where the parts' light comes from different sides, as at the cut locus,
/// directions are shorter than 1. Throws InvalidInput for an LED that the sensor has not, for a
/// model that gives another number of directions, and as the model does.
template <std::floating_point T, LightModel<T> Model>
[[nodiscard]] LightField<T> led_field(const SensorPreset<T>& sensor, const Surface<T>& membrane,
                                      std::size_t led, const Model& model,
                                      std::type_identity_t<std::span<const SurfacePoint<T>>> points,
                                      const CancelHook& cancelled = {}) {
  using namespace detail::arithmetic;
  detail::require(led < sensor.leds.size(), "LED ", led, " of a sensor with ", sensor.leds.size());
  const T width = sensor.led_width.value_or(0);
  detail::require(width >= 0, "an LED ", width, " wide");
  std::vector<SurfacePoint<T>> parts{sensor.leds[led]};
  if (width > 0) {
    parts = points_along_border(membrane, sensor.leds[led], width, sensor.led_parts);
  } else if constexpr (requires { Model::needs_emission; }) {
    if (!sensor.led_width.has_value()) parts = detail::usual_led(membrane, sensor.leds[led]);
  }
  if constexpr (requires { Model::leaves_vertices; }) {
    for (auto& part : parts)
      part = vertex_point<T>(nearest_vertex(membrane, membrane.position(part)));
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  }
  LightField<T> sum(points.size(), Vec3<T>(0, 0, 0));
  const auto count = static_cast<double>(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const auto done = static_cast<double>(k);
    Led<T> part{{parts[k]}};
    if constexpr (requires { Model::needs_emission; }) {
      part.emission = detail::inwards(membrane, parts[k]);
    }
    const auto one = model.field(part, points, cancelled.part(done / count, (done + 1) / count));
    detail::require(one.size() == sum.size(), "the light model gives ", one.size(),
                    " directions for ", sum.size(), " points");
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i] / static_cast<T>(count);
  }
  return sum;
}

/// A model of the light in a sensor's gel, as thick as `sensor.gel` says, exposed as the preset is.
/// The gel is on the camera's side of the membrane, whichever way normals point. Throws
/// InvalidInput as GelLight does, and for a membrane that is not an oriented manifold.
template <std::floating_point T>
[[nodiscard]] GelLight<T> gel_light(const SensorPreset<T>& sensor);

/// The renderer of a sensor, its light by any light model: the GelTip's by default, along the
/// shortest paths on the membrane. Light that is not tangent to the membrane lights it at rest too:
/// so much is taken off the coating's light. Takes as long as the model's fields. Throws
/// InvalidInput unless
/// there is a colour for each LED and a coating that reflects shares of it, where the camera sees
/// nothing of the membrane, and as the parts do.
///@{
template <std::floating_point T, LightModel<T> Model>
[[nodiscard]] TactileRenderer<T> tactile_renderer(const SensorPreset<T>& sensor,
                                                  const Model& model) {
  const Raster<T> rest = rasterize(sensor.membrane, sensor.camera);
  detail::require_seen(rest);
  const Surface<T> surface(sensor.membrane);
  auto coating = detail::seen_coating(sensor, surface, sensor.camera, rest);
  const auto points = pixel_points(rest);
  std::vector<Light<T>> lights;
  for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
    lights.push_back({bake(led_field(sensor, surface, k, model, points), rest), sensor.colours[k],
                      sensor.diffuse, sensor.specular, sensor.shininess});
  }
  TactileOptions options = sensor.options;
  if constexpr (requires { Model::is_tangent; }) options.rectify = Model::is_tangent;
  options.keep_strength = sensor.led_width.value_or(0) > 0;
  if constexpr (!requires { requires Model::is_tangent; }) {
    if (!options.rectify) {
      coating =
          detail::beside_lights(std::move(coating), sensor.camera, rest.depth, lights, options);
    }
  }
  return {sensor.camera, rest.depth, lights, Background<T>(coating), options};
}
template <std::floating_point T>
[[nodiscard]] TactileRenderer<T> tactile_renderer(const SensorPreset<T>& sensor);
///@}

}  // namespace gelight

#if defined(GELIGHT_BODIES)
#include "gelight/sensor/presets/body.hpp"
#endif
