// The sensors and the objects: presets of the library, and shapes in a few lines.

#include <cmath>
#include <numbers>

#include "choices.hpp"

namespace page {

using gelight::ProfilePoint;

namespace {

constexpr float base_radius = 0.012f;
constexpr float view = 0.95f;  // from top to bottom, in radians

float dome(float x, float y) { return 0.012f + std::sqrt(0.014f * 0.014f - x * x - y * y); }

float paw(float x, float y) {
  const auto pad = [&](float at_x, float at_y, float size) {
    const float away = (x - at_x) * (x - at_x) + (y - at_y) * (y - at_y);
    return size * std::exp(-away / (size * size));
  };
  return 0.019f + pad(0, -0.003f, 0.0045f) + pad(-0.007f, 0.001f, 0.0026f) +
         pad(0.007f, 0.001f, 0.0026f) + pad(-0.003f, 0.0065f, 0.0028f) +
         pad(0.003f, 0.0065f, 0.0028f);
}

// A round membrane whose depth is a function of the place, its LEDs a third of the rim apart.
Sensor round_sensor(float (*depth)(float, float), Index width, Index height, float edge) {
  const auto rings = static_cast<int>(std::ceil(base_radius / edge));
  std::vector<ProfilePoint<float>> outline;
  for (int i = rings; i >= 0; --i) {
    outline.push_back({base_radius * static_cast<float>(i) / static_cast<float>(rings), 0});
  }
  Sensor sensor;
  sensor.membrane = gelight::revolve<float>(outline, edge);
  for (auto& [x, y, z] : sensor.membrane.positions) z = depth(x, y);
  sensor.camera = gelight::Camera<float>::from_vertical_fov(view, width, height);
  constexpr float third = 2 * std::numbers::pi_v<float> / 3;
  const std::array<float, 3> angles{0.3f, 0.3f + third, 0.3f + 2 * third};
  sensor.leds = gelight::points_of_border<float>(sensor.membrane, angles);
  sensor.colours = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  sensor.falloff = {.absorption = 50};
  return sensor;
}

Mesh lifted(const Mesh& mesh, float height) {
  return gelight::placed<float>(mesh, Eigen::Matrix3f::Identity(), {0, 0, height});
}

Mesh ball(float radius, Index level, float x = 0, float y = 0) {
  return gelight::placed<float>(gelight::icosphere<float>(level, radius),
                                Eigen::Matrix3f::Identity(), {x, y, radius});
}

Mesh screw() {
  constexpr float length = 0.016f, radius = 0.0022f, depth = 0.0005f, pitch = 0.0016f;
  std::vector<ProfilePoint<float>> outline{{0, -length / 2}};
  for (float z = -length / 2; z <= length / 2; z += pitch / 8) {
    const float turn = 2 * std::numbers::pi_v<float> * z / pitch;
    outline.push_back({radius + depth * (std::abs(std::sin(turn / 2)) - 1), z});
  }
  outline.push_back({0, length / 2});
  Eigen::Matrix3f lying;
  lying << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  return gelight::placed<float>(gelight::revolve<float>(outline, 0.0004f), lying, {0, 0, radius});
}

Mesh bearing() {
  std::vector<Mesh> parts{lifted(gelight::torus<float>(0.0052f, 0.0008f, 96, 20), 0.0012f)};
  for (int i = 0; i < 6; ++i) {
    const float turn = std::numbers::pi_v<float> / 3 * static_cast<float>(i);
    parts.push_back(ball(0.0013f, 3, 0.003f * std::cos(turn), 0.003f * std::sin(turn)));
  }
  return gelight::joined<float>(parts);
}

// The word "gel" in braille, mirrored since it is felt from below.
Mesh braille() {
  constexpr float apart = 0.0019f, letter = 0.0048f;
  constexpr std::array<std::array<int, 6>, 3> letters{
      {{1, 1, 1, 1, 0, 0}, {1, 0, 0, 1, 0, 0}, {1, 0, 1, 0, 1, 0}}};  // rows of two
  std::vector<Mesh> parts{lifted(gelight::box<float>(0.0145f, 0.0075f, 0.001f), 0.0014f)};
  for (int i = 0; i < 3; ++i) {
    for (int dot = 0; dot < 6; ++dot) {
      if (letters[static_cast<std::size_t>(i)][static_cast<std::size_t>(dot)] == 0) continue;
      const float x =
          static_cast<float>(i - 1) * letter + (static_cast<float>(dot % 2) - 0.5f) * apart;
      const float y = (static_cast<float>(dot / 2) - 1) * apart;
      parts.push_back(ball(0.0008f, 2, x, y));
    }
  }
  return gelight::joined<float>(parts);
}

}  // namespace

Sensor make_sensor(SensorKind kind, Index width, Index height, float edge) {
  if (kind == SensorKind::dome) return round_sensor(dome, width, height, edge);
  if (kind == SensorKind::paw) return round_sensor(paw, width, height, edge);
  if (kind == SensorKind::pad) return gelight::gelsight_mini<float>(width, height, edge);
  gelight::detail::require(kind == SensorKind::geltip, "there is no sensor ",
                           static_cast<int>(kind));
  Sensor sensor = gelight::geltip<float>(width, height, edge);
  sensor.camera = gelight::Camera<float>::from_vertical_fov(0.64f, width, height);
  return sensor;
}

Mesh make_object(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::ball:
      return ball(0.004f, 4);
    case ObjectKind::ring:
      return lifted(gelight::torus<float>(0.004f, 0.0011f, 96, 24), 0.0011f);
    case ObjectKind::cube:
      return lifted(gelight::box<float>(0.006f, 0.006f, 0.006f), 0.003f);
    case ObjectKind::screw:
      return screw();
    case ObjectKind::bearing:
      return bearing();
    case ObjectKind::braille:
      return braille();
  }
  gelight::detail::require(false, "there is no object ", static_cast<int>(kind));
  return {};
}

}  // namespace page
