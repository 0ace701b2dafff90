#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/concepts/light.hpp"
#include "gelight/core/array.hpp"
#include "gelight/core/compiled.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/light/field.hpp"
#include "gelight/light/models.hpp"
#include "gelight/membrane/gel.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/mesh/simplified.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"
#include "gelight/mesh/tangent.hpp"
#include "gelight/sensor/background.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/presets.hpp"
#include "gelight/sensor/presets/pad.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/views/mesh_view.hpp"

namespace gelight {

template <std::floating_point T>
std::vector<SurfacePoint<T>> leds_on_border(const Mesh<T>& membrane,
                                            std::type_identity_t<std::span<const T>> angles) {
  const Surface<T> surface(membrane);
  std::vector<Index> border;
  Vec3<T> middle = Vec3<T>(0, 0, 0);
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

template <std::floating_point T>
std::vector<SurfacePoint<T>> points_of_border(const Mesh<T>& membrane,
                                              std::type_identity_t<std::span<const T>> angles) {
  using namespace detail::arithmetic;
  const Surface<T> surface(membrane);
  Vec3<T> middle = Vec3<T>(0, 0, 0);
  T length = 0;
  std::vector<Index> border;
  for (Index h = 0; h < surface.halfedge_count(); ++h) {
    if (!surface.is_border(h)) continue;
    border.push_back(h);
    middle += surface.length(h) / 2 *
              (surface.position(surface.origin(h)) + surface.position(surface.tip(h)));
    length += surface.length(h);
  }
  detail::require(!border.empty(), "the membrane has no border to put LEDs on");
  middle /= length;
  std::vector<SurfacePoint<T>> leds;
  for (const T angle : angles) {
    detail::require(std::isfinite(angle), "an LED at the angle ", angle);
    const T x = std::cos(angle), y = std::sin(angle);
    T farthest = 0;
    std::optional<SurfacePoint<T>> led;
    for (const Index h : border) {
      const Vec3<T> from = surface.position(surface.origin(h)) - middle;
      const Vec3<T> to = surface.position(surface.tip(h)) - middle;
      const T before = x * from.y() - y * from.x(), after = x * to.y() - y * to.x();
      if ((before < 0) == (after < 0)) continue;
      const T share = before / (before - after);
      const T along =
          (1 - share) * (x * from.x() + y * from.y()) + share * (x * to.x() + y * to.y());
      if (along <= farthest) continue;
      farthest = along;
      led = edge_point<T>(surface.origin(h), surface.tip(h), share);
    }
    detail::require(led.has_value(), "no border of the membrane is at the angle ", angle);
    leds.push_back(*led);
  }
  return leds;
}

namespace detail {

/// An edge of a border, as a walk along it passes it.
template <std::floating_point T>
struct BorderEdge {
  Index from, to;
  T length;
};

/// The border on which a half-edge lies, once round, from the half-edge's beginning. Faces may be
/// oriented any way. Throws InvalidInput where the border meets an edge of three faces or more.
template <std::floating_point T>
[[nodiscard]] Array<BorderEdge<T>> border_round(const Surface<T>& surface, Index first) {
  Array<BorderEdge<T>> edges;
  Index h = first, from = surface.origin(first);
  do {
    const Index to = surface.origin(h) == from ? surface.tip(h) : surface.origin(h);
    edges.push_back({from, to, surface.length(h)});
    const auto other_at_end = [&](Index g) {
      return surface.tip(g) == to ? surface.next(g) : surface.previous(g);
    };
    for (h = other_at_end(h); !surface.is_border(h); h = other_at_end(surface.twin(h))) {
      require(surface.is_manifold(h), "the border meets an edge of more than two faces at vertex ",
              to);
    }
    from = to;
  } while (h != first);
  return edges;
}

/// A half-edge of the border on which a simplified point lies; -1 where it is on none.
template <std::floating_point T>
[[nodiscard]] Index border_at(const Surface<T>& surface, const SurfacePoint<T>& at) {
  using Kind = typename SurfacePoint<T>::Kind;
  Index first = -1;
  if (at.kind == Kind::edge) {
    const Index h = surface.find_halfedge(at.element[0], at.element[1]);
    if (surface.is_border(h)) first = h;
  } else if (at.kind == Kind::vertex) {
    for (const Index h : surface.corners(at.element[0])) {
      if (surface.is_border(h)) first = h;
      if (first < 0 && surface.is_border(surface.previous(h))) first = surface.previous(h);
    }
  }
  return first;
}

}  // namespace detail

template <std::floating_point T>
std::vector<SurfacePoint<T>> points_along_border(const Surface<T>& surface,
                                                 const SurfacePoint<T>& middle,
                                                 std::type_identity_t<T> width, Index count) {
  detail::require(count > 0, count, " parts of an LED");
  surface.require_point(middle);
  const SurfacePoint<T> at_middle = detail::simplified(surface, middle);
  const Index first = detail::border_at(surface, at_middle);
  detail::require(first >= 0, "the LED's middle is not on the border of the membrane");
  const auto edges = detail::border_round(surface, first);
  T length = 0;
  for (const auto& edge : edges) length += edge.length;
  detail::require(width >= 0 && width <= length / 2, "an LED ", width, " wide on a border ", length,
                  " long");
  const T start =
      detail::stable_norm(surface.difference(vertex_point<T>(edges[0].from), at_middle));
  std::vector<SurfacePoint<T>> points;
  for (Index k = 0; k < count; ++k) {
    T at = start + width * ((T(k) + T(0.5)) / T(count) - T(0.5));
    std::size_t i = 0;
    while (at < 0) {
      i = (i > 0 ? i : edges.size()) - 1;
      at += edges[i].length;
    }
    while (at > edges[i].length) {
      at -= edges[i].length;
      i = (i + 1) % edges.size();
    }
    const auto& edge = edges[i];
    points.push_back(edge_point<T>(edge.from, edge.to, edge.length > 0 ? at / edge.length : T(0)));
  }
  return points;
}

namespace detail {

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

template <std::floating_point T>
SensorPreset<T> geltip(Index width, Index height, std::type_identity_t<T> edge_length) {
  constexpr T radius = T(0.01146), length = T(0.0455);
  SensorPreset<T> sensor;
  sensor.membrane = membrane<T>(radius, length, edge_length);
  sensor.camera = Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 2, width, height);
  sensor.leds = points_of_border(sensor.membrane, detail::turns<T>({0, 120, 240}));
  sensor.colours = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  sensor.falloff = {.absorption = T(30)};
  sensor.full_within = T(0.015);
  return sensor;
}

template <std::floating_point T>
SensorPreset<T> gelsight_mini(Index width, Index height, std::type_identity_t<T> edge_length) {
  constexpr T down = T(0.0143), distance = T(0.020);
  // (At 4:3 its camera sees a little more across than the 18.6 mm that the maker tells.)
  const T across = std::max(T(0.0186), down * T(width) / T(height));
  SensorPreset<T> sensor;
  sensor.membrane =
      detail::pad<T>(T(1.02) * across, T(1.02) * down, distance, unreachable<T>, edge_length);
  sensor.camera = detail::facing_pad<T>(down, distance, width, height);
  sensor.leds = points_of_border(sensor.membrane, detail::turns<T>({90, 180, 0}));
  sensor.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  sensor.falloff = {.absorption = T(100)};
  sensor.gel = {.thickness = 0.004};
  return sensor;
}

template <std::floating_point T>
SensorPreset<T> digit(Index width, Index height, std::type_identity_t<T> edge_length) {
  SensorPreset<T> sensor;
  sensor.membrane = detail::pad<T>(T(0.020), T(0.030), T(0.022), T(0.1), edge_length);
  sensor.camera = Camera<T>::from_vertical_fov(std::numbers::pi_v<T> / 3, width, height);
  sensor.leds = points_of_border(sensor.membrane, detail::turns<T>({30, 150, 270}));
  sensor.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  sensor.falloff = {.absorption = T(80)};
  sensor.gel = {.thickness = 0.005};
  return sensor;
}

template <std::floating_point T>
SensorPreset<T> sts(Index width, Index height, std::type_identity_t<T> edge_length) {
  constexpr T across = T(0.040), down = T(0.030), distance = T(0.030);
  SensorPreset<T> sensor;
  sensor.membrane =
      detail::pad<T>(T(1.02) * across, T(1.02) * down, distance, unreachable<T>, edge_length);
  sensor.camera = detail::facing_pad<T>(down, distance, width, height);
  sensor.leds = points_of_border(sensor.membrane, detail::turns<T>({0, 180, 90, 270}));
  sensor.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {T(0.6), T(0.6), T(0.6)}};
  sensor.falloff = {.absorption = T(60)};
  sensor.diffuse = 1;
  sensor.specular = T(0.5);
  sensor.shininess = 5;
  return sensor;
}

namespace detail {

/// What a camera sees of a sensor's coating: the sensor's own, or a part of its image. The surface
/// is that of the sensor's membrane.
template <std::floating_point T>
[[nodiscard]] Image<std::array<T, 3>> seen_coating(const SensorPreset<T>& sensor,
                                                   const Surface<T>& surface,
                                                   const Camera<T>& camera, const Raster<T>& rest) {
  require(sensor.leds.size() == sensor.colours.size(), "there are ", sensor.leds.size(),
          " LEDs and ", sensor.colours.size(), " colours");
  for (const T share : sensor.coating) {
    require(share >= 0 && share <= 1, "the coating reflects ", share,
            ", which is not a share of light from 0 to 1");
  }
  for (std::size_t k = 0; k < sensor.colours.size(); ++k) {
    for (const T share : sensor.colours[k]) {
      require(share >= 0 && share <= 1, "LED ", k, " has colour ", share,
              ", which is not in shares of full light from 0 to 1");
    }
  }
  require_camera_size(rest.face, camera, "the image of faces");
  require_camera_size(rest.depth, camera, "the depth image");
  Image<std::array<T, 3>> seen(camera.width, camera.height);
  std::vector<T> distances;
  std::vector<std::array<T, 3>*> pixels;
  for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
    distances.clear();
    pixels.clear();
    const Vec3<T> led = surface.position(sensor.leds[k]);
    for (Index y = 0; y < seen.height(); ++y) {
      for (Index x = 0; x < seen.width(); ++x) {
        if (rest.face(x, y) < 0) continue;
        const Vec3<T> place =
            camera.unproject(static_cast<T>(x), static_cast<T>(y), rest.depth(x, y));
        distances.push_back(norm(place - led));
        pixels.push_back(&seen(x, y));
      }
    }
    const std::vector<T> shares = strength(std::span<const T>(distances), sensor.falloff);
    // In millimetres all of it would be black, without a word.
    constexpr T least_seen = T(1) / 512;
    const T most = shares.empty() ? T(1) : *std::max_element(shares.begin(), shares.end());
    require(most >= least_seen, "of the light of LED ", k, " at most the share ", most,
            " comes to where the camera sees: lengths are in metres, the falloff per metre");
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        (*pixels[i])[c] += sensor.coating[c] * shares[i] * sensor.colours[k][c];
      }
    }
  }
  for (auto& colour : seen.pixels()) {
    for (T& channel : colour) channel = std::min(channel, T(1));
  }
  return seen;
}

}  // namespace detail

template <std::floating_point T>
Background<T> coating_light(const SensorPreset<T>& sensor, const Raster<T>& rest) {
  return detail::seen_coating(sensor, Surface<T>(sensor.membrane), sensor.camera, rest);
}

namespace detail {

template <std::floating_point T>
void require_seen(const Raster<T>& rest) {
  const auto& faces = rest.face.pixels();
  const bool is_seen = std::any_of(faces.begin(), faces.end(), [](Index f) { return f >= 0; });
  require(is_seen, "the camera sees nothing of the membrane");
}

/// Across an edge of a face, into it: unit, in its plane; zero at an edge without length.
template <std::floating_point T>
[[nodiscard]] Vec3<T> into_face(const Surface<T>& surface, Index h) {
  const auto from = vertex_point<T>(surface.origin(h));
  const Vec3<T> along = direction_of<T>(surface.difference(from, vertex_point<T>(surface.tip(h))));
  const Vec3<T> to_apex = surface.difference(from, vertex_point<T>(surface.apex(h)));
  return direction_of<T>(to_apex - dot(along, to_apex) * along);
}

/// Where an LED of a membrane shines: along it, across its border; at a vertex of the border, where
/// that turns, halfway. Beside the border it is towards the middle of the faces there.
template <std::floating_point T>
[[nodiscard]] Vec3<T> inwards(const Surface<T>& surface, const SurfacePoint<T>& led) {
  using Kind = typename SurfacePoint<T>::Kind;
  const SurfacePoint<T> at = simplified(surface, led);
  Vec3<T> sum = Vec3<T>(0, 0, 0);
  const auto add = [&](Index h) {
    if (surface.is_border(h)) sum += into_face(surface, h);
  };
  if (at.kind == Kind::edge) add(surface.find_halfedge(at.element[0], at.element[1]));
  if (at.kind == Kind::vertex) {
    for (const Index h : surface.corners(at.element[0])) {
      add(h);
      add(surface.previous(h));
    }
  }
  if (!(squared_norm(sum) > 0)) {
    const Vec3<T> from = surface.position(led);
    for (const Index f : faces_at(surface, led)) {
      const auto [a, b, c] = surface.face(f);
      sum += direction_of<T>((surface.position(a) + surface.position(b) + surface.position(c)) / 3 -
                             from);
    }
  }
  const Vec3<T> normal = direction_of<T>(mean_normal(surface, led));
  return direction_of<T>(sum - dot(sum, normal) * normal);
}

/// The points that stand for an LED whose width is not set, for light that leaves it one way: 3 mm
/// of the border, as wide as LEDs commonly are, or half of a border that is shorter than twice
/// that. As each part's shadow has an edge, so many that no edge is seen. Off the border: a point.
template <std::floating_point T>
[[nodiscard]] std::vector<SurfacePoint<T>> usual_led(const Surface<T>& surface,
                                                     const SurfacePoint<T>& led) {
  surface.require_point(led);
  const Index first = border_at(surface, simplified(surface, led));
  if (first < 0) return {led};
  T length = 0;
  for (const auto& edge : border_round(surface, first)) length += edge.length;
  return points_along_border(surface, led, std::min(T(0.003), length / 2), 24);
}

/// What is left of a coating's light when what some lights throw on the membrane at rest is taken
/// off: for an ambient share, so that nothing counts twice.
template <std::floating_point T>
[[nodiscard]] Image<std::array<T, 3>> beside_lights(Image<std::array<T, 3>> coating,
                                                    const Camera<T>& camera, const Image<T>& rest,
                                                    const std::vector<Light<T>>& lights,
                                                    const TactileOptions& options) {
  if (!(options.ambient > 0)) return coating;
  const auto normals = sobel_normals(rest, camera.template cast<double>(), options.border_normals);
  const bool is_gated = options.specular == Specular::gated;
  const double least_seen = is_gated ? double{facing_rounding(camera)} : -2;  // as it is rendered
  for (Index y = 0; y < coating.height(); ++y) {
    for (Index x = 0; x < coating.width(); ++x) {
      const Vec3<double> eye =
          -direction_of<double>(camera.template cast<double>().ray(double(x), double(y)));
      for (const Light<T>& light : lights) {
        const Vec3<double> to_light = -cast<double>(light.direction(x, y));
        if (dot(normals(x, y), to_light) <= least_seen) continue;
        const double shares = phong<double>(normals(x, y), to_light, eye, light.diffuse,
                                            light.specular, light.shininess, options.specular);
        for (std::size_t c = 0; c < 3; ++c) {
          coating(x, y)[c] -= static_cast<T>(shares * light.rgb[c] / options.ambient);
        }
      }
      // An unclamped specular term may take light away, too.
      for (T& left : coating(x, y)) left = std::clamp(left, T(0), T(1));
    }
  }
  return coating;
}

/// Whether a membrane's normals point towards the camera, which is at the origin: where the volume
/// between the two is negative.
template <std::floating_point T>
[[nodiscard]] bool has_normals_inwards(const Surface<T>& membrane) {
  double volume = 0;  // six times that
  for (Index f = 0; f < membrane.face_count(); ++f) {
    const Vec3<double> normal = cast<double>(face_normal(membrane, f));
    volume += dot(normal, cast<double>(membrane.position(membrane.face(f)[0])));
  }
  return volume < 0;
}

}  // namespace detail

template <std::floating_point T>
GelLight<T> gel_light(const SensorPreset<T>& sensor) {
  const Surface<T> membrane(sensor.membrane);
  require_oriented(membrane);
  return GelLight<T>(membrane, {.thickness = static_cast<T>(sensor.gel.thickness),
                                .full_within = sensor.full_within,
                                .has_normals_inwards = detail::has_normals_inwards(membrane)});
}

template <std::floating_point T>
TactileRenderer<T> tactile_renderer(const SensorPreset<T>& sensor) {
  return tactile_renderer(sensor, GeodesicLight<T>(sensor.membrane));
}

}  // namespace gelight

#if defined(GELIGHT_MAKES_COMPILED)
namespace gelight {
template std::vector<SurfacePoint<float>> leds_on_border(const Mesh<float>&,
                                                         std::span<const float>);
template std::vector<SurfacePoint<float>> points_of_border(const Mesh<float>&,
                                                           std::span<const float>);
template std::vector<SurfacePoint<float>> points_along_border(const Surface<float>&,
                                                              const SurfacePoint<float>&, float,
                                                              Index);
template SensorPreset<float> geltip<float>(Index, Index, float);
template SensorPreset<float> gelsight_mini<float>(Index, Index, float);
template SensorPreset<float> digit<float>(Index, Index, float);
template SensorPreset<float> sts<float>(Index, Index, float);
template Background<float> coating_light(const SensorPreset<float>&, const Raster<float>&);
template Image<std::array<float, 3>> detail::seen_coating(const SensorPreset<float>&,
                                                          const Surface<float>&,
                                                          const Camera<float>&,
                                                          const Raster<float>&);
template void detail::require_seen(const Raster<float>&);
template Vec3<float> detail::inwards(const Surface<float>&, const SurfacePoint<float>&);
template std::vector<SurfacePoint<float>> detail::usual_led(const Surface<float>&,
                                                            const SurfacePoint<float>&);
template Image<std::array<float, 3>> detail::beside_lights(Image<std::array<float, 3>>,
                                                           const Camera<float>&,
                                                           const Image<float>&,
                                                           const std::vector<Light<float>>&,
                                                           const TactileOptions&);
template GelLight<float> gel_light(const SensorPreset<float>&);
template TactileRenderer<float> tactile_renderer(const SensorPreset<float>&);
template std::vector<SurfacePoint<double>> leds_on_border(const Mesh<double>&,
                                                          std::span<const double>);
template std::vector<SurfacePoint<double>> points_of_border(const Mesh<double>&,
                                                            std::span<const double>);
template std::vector<SurfacePoint<double>> points_along_border(const Surface<double>&,
                                                               const SurfacePoint<double>&, double,
                                                               Index);
template SensorPreset<double> geltip<double>(Index, Index, double);
template SensorPreset<double> gelsight_mini<double>(Index, Index, double);
template SensorPreset<double> digit<double>(Index, Index, double);
template SensorPreset<double> sts<double>(Index, Index, double);
template Background<double> coating_light(const SensorPreset<double>&, const Raster<double>&);
template Image<std::array<double, 3>> detail::seen_coating(const SensorPreset<double>&,
                                                           const Surface<double>&,
                                                           const Camera<double>&,
                                                           const Raster<double>&);
template void detail::require_seen(const Raster<double>&);
template Vec3<double> detail::inwards(const Surface<double>&, const SurfacePoint<double>&);
template std::vector<SurfacePoint<double>> detail::usual_led(const Surface<double>&,
                                                             const SurfacePoint<double>&);
template Image<std::array<double, 3>> detail::beside_lights(Image<std::array<double, 3>>,
                                                            const Camera<double>&,
                                                            const Image<double>&,
                                                            const std::vector<Light<double>>&,
                                                            const TactileOptions&);
template GelLight<double> gel_light(const SensorPreset<double>&);
template TactileRenderer<double> tactile_renderer(const SensorPreset<double>&);
}  // namespace gelight
#endif
