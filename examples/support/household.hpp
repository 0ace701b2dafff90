#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "figure.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"

// Things from a drawer, to lay on a sensor: in metres and kilograms, as they lie, z upwards.

struct Thing {
  std::string name;
  gelight::Mesh<double> mesh;
  double mass;
  Colour colour;
};

namespace household_detail {

using gelight::Index;
using gelight::Mesh;
using gelight::Vec3;

/// A surface over a grid of two parameters in [0, 1], closed in the first.
inline Mesh<double> patch(Index around, Index along,
                          const std::function<Vec3<double>(double, double)>& point) {
  Mesh<double> mesh;
  for (Index j = 0; j <= along; ++j) {
    for (Index i = 0; i < around; ++i) {
      const Vec3<double> p = point(static_cast<double>(i) / around, static_cast<double>(j) / along);
      mesh.positions.push_back({p[0], p[1], p[2]});
      if (j == along) continue;
      const Index a = j * around + i, b = j * around + (i + 1) % around;
      mesh.faces.push_back({a, b, b + around});
      mesh.faces.push_back({a, b + around, a + around});
    }
  }
  return mesh;
}

/// A bar along a path in a plane, of elliptic section, `wide` in the plane and `thick` across it
/// (half axes); round at both ends.
inline Mesh<double> bar(const std::vector<Vec3<double>>& path, const Vec3<double>& across,
                        double wide, double thick) {
  const auto last = static_cast<Index>(path.size()) - 1;
  const Index cap = 4;  // rings of each end
  return patch(20, last + 2 * cap, [&](double turn, double share) {
    const double at = share * (last + 2 * cap) - cap;  // point of the path; beyond it at the ends
    const auto i = static_cast<std::size_t>(std::clamp(std::lround(at), 0L, long{last}));
    const Vec3<double> ahead = path[std::min(i + 1, path.size() - 1)];
    const Vec3<double> tangent = (ahead - path[i == 0 ? 0 : i - 1]).normalized();
    const double beyond = at < 0 ? at / cap : at > last ? (at - last) / cap : 0;
    const double round = std::sqrt(std::max(0.0, 1 - beyond * beyond));
    const double angle = 2 * std::numbers::pi * turn;
    return Vec3<double>(path[i] + beyond * std::min(wide, thick) * tangent +
                        round * (wide * std::cos(angle) * gelight::cross(across, tangent) +
                                 thick * std::sin(angle) * across));
  });
}

inline void arc(std::vector<Vec3<double>>& path, double x, double y, double radius, double from,
                double to) {
  const int steps = 24;
  for (int k = 0; k <= steps; ++k) {
    const double angle = std::numbers::pi * (from + (to - from) * k / steps);
    path.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle), path.front()[2]});
  }
}

inline Mesh<double> moved(const Mesh<double>& mesh, const Vec3<double>& by, double turn = 0) {
  Eigen::Matrix3d rotation;
  rotation << std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn), 0, 0, 0, 1;
  return gelight::placed<double>(mesh, rotation, by);
}

/// With its shadow's middle at the origin, standing on z = 0.
inline Mesh<double> centred(const Mesh<double>& mesh, double scale = 1) {
  Vec3<double> low(mesh.position(0).data()), high = low;
  for (const auto& p : mesh.positions) {
    low = low.cwiseMin(Vec3<double>(p.data()));
    high = high.cwiseMax(Vec3<double>(p.data()));
  }
  const Vec3<double> middle = 0.5 * (low + high);
  return gelight::placed<double>(mesh, scale * Eigen::Matrix3d::Identity(),
                                 scale * Vec3<double>(-middle.x(), -middle.y(), -low.z()));
}

/// The z axis becomes x.
inline Mesh<double> laid_down(const Mesh<double>& mesh) {
  Eigen::Matrix3d quarter;
  quarter << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  return gelight::placed<double>(mesh, quarter, {0, 0, 0});
}

inline Mesh<double> turned(std::initializer_list<gelight::ProfilePoint<double>> outline,
                           double edge) {
  return gelight::revolve<double>(std::vector(outline), edge);
}

inline Mesh<double> paper_clip() {
  const double wire = 0.00065;
  std::vector<Vec3<double>> path{{-0.013, 0.005, wire}};
  arc(path, 0.018, 0, 0.005, 0.5, -0.5);
  arc(path, -0.020, -0.0008, 0.0042, 1.5, 0.5);
  arc(path, 0.011, 0.0002, 0.0032, 0.5, -0.5);
  path.push_back({-0.011, -0.003, wire});
  return centred(bar(path, {0, 0, 1}, wire, wire));
}

inline Mesh<double> spoon() {
  const auto bowl = [](double scale) {
    return patch(48, 20, [scale](double turn, double share) {
      const double out = std::sin(0.5 * std::numbers::pi * share), a = 2 * std::numbers::pi * turn;
      const double x = 0.017 * out * std::cos(a) * (1 - 0.15 * std::cos(a));
      return Vec3<double>(scale * x, scale * 0.0115 * out * std::sin(a),
                          0.0065 - scale * 0.0065 * std::cos(0.5 * std::numbers::pi * share));
    });
  };
  std::vector<Vec3<double>> path;
  for (int k = 0; k <= 40; ++k) {
    const double s = k / 40.0;
    path.push_back({0.0135 + 0.062 * s, 0, 0.0062 + 0.011 * s * (1 - s) - 0.0045 * s * s});
  }
  const std::array<Mesh<double>, 3> parts{bowl(1), bowl(0.93),
                                          bar(path, {0, 1, 0}, 0.0008, 0.0028)};
  return centred(gelight::joined<double>(parts), 0.85);
}

/// A threaded rod from the origin along x, 12,000 triangles.
inline Mesh<double> threaded_rod() {
  const double core = 0.0030, depth = 0.0008, pitch = 0.0022, length = 0.030;
  return patch(40, 150, [&](double turn, double share) {
    const double x = share * length, phase = x / pitch - turn;
    const double crest = std::abs(2 * (phase - std::floor(phase)) - 1);
    const double taper = std::min(1.0, 8 * (1 - share));
    const double radius = taper * (core + depth * crest), angle = 2 * std::numbers::pi * turn;
    return Vec3<double>(x, radius * std::cos(angle), radius * std::sin(angle));
  });
}

inline Mesh<double> screw() {
  const auto head = laid_down(
      turned({{0, -0.0045}, {0.0055, -0.0045}, {0.0064, -0.0036}, {0.0064, -0.0012}, {0.0030, 0.0}},
             0.0004));
  const std::array<Mesh<double>, 2> parts{threaded_rod(), head};
  return centred(gelight::joined<double>(parts));
}

inline Mesh<double> scissors() {
  std::vector<Mesh<double>> parts;
  for (const double side : {-1.0, 1.0}) {
    // From the tip to the ring, blade over blade, with rings thicker than both.
    const double low = side < 0 ? 0.0 : 0.0016, turn = side * 0.16;
    const std::vector<Vec3<double>> blade{{0.050, side * 0.0004, low + 0.0008},
                                          {0.044, side * 0.0009, low + 0.0008},
                                          {0.020, side * 0.0022, low + 0.0008},
                                          {0, 0, low + 0.0008}};
    std::vector<Vec3<double>> fine;
    for (std::size_t k = 0; k + 1 < blade.size(); ++k) {
      for (int i = 0; i < 12; ++i) fine.push_back(blade[k] + i / 12.0 * (blade[k + 1] - blade[k]));
    }
    parts.push_back(moved(bar(fine, {0, 0, 1}, 0.0024, 0.0008), {0, 0, 0}, -turn));
    std::vector<Vec3<double>> arm;
    for (int i = 0; i <= 20; ++i) arm.push_back({-0.0012 * i, 0.0002 * side * i, 0.0016});
    parts.push_back(moved(bar(arm, {0, 0, 1}, 0.0026, 0.0016), {0, 0, 0}, -turn));
    const auto ring =
        moved(gelight::torus<double>(0.0092, 0.0026, 56, 20), {-0.033, 0.0055 * side, 0.0016});
    parts.push_back(moved(ring, {0, 0, 0}, -turn));
  }
  parts.push_back(moved(turned({{0, -0.0006},
                                {0.0022, -0.0006},
                                {0.0028, 0},
                                {0.0028, 0.0032},
                                {0.0022, 0.0038},
                                {0, 0.0038}},
                               0.0003),
                        {0, 0, 0}));
  return centred(gelight::joined<double>(parts), 0.85);
}

inline Mesh<double> bottle() {
  std::vector<gelight::ProfilePoint<double>> outline{{0, 0}, {0.011, 0}};
  for (int k = 0; k <= 6; ++k) {  // the foot's rounded edge
    const double a = std::numbers::pi / 12 * k;
    outline.push_back({0.0135 + 0.0025 * std::sin(a), 0.0025 - 0.0025 * std::cos(a)});
  }
  for (int k = 0; k <= 40; ++k) {  // a belly with ribs
    const double s = k / 40.0;
    outline.push_back({0.016 + 0.0004 * std::cos(2 * std::numbers::pi * 4 * s), 0.004 + 0.036 * s});
  }
  for (int k = 1; k <= 16; ++k) {  // shoulder
    const double s = k / 16.0;
    outline.push_back({0.0115 + 0.0049 * std::cos(std::numbers::pi * s), 0.040 + 0.015 * s});
  }
  for (const auto& p :
       {std::pair{0.0066, 0.060}, {0.0080, 0.0605}, {0.0080, 0.0665}, {0.0, 0.0665}}) {
    outline.push_back({p.first, p.second});
  }
  const auto standing = gelight::revolve<double>(outline, 0.0014);
  return centred(laid_down(standing));
}

}  // namespace household_detail

inline std::vector<Thing> things_from_a_drawer() {
  using namespace household_detail;
  return {{"paper clip", paper_clip(), 0.0015, {0.75, 0.75, 0.80}},
          {"spoon", spoon(), 0.022, {0.80, 0.80, 0.78}},
          {"screw", screw(), 0.009, {0.80, 0.66, 0.35}},
          {"scissors", scissors(), 0.030, {0.75, 0.20, 0.18}},
          {"bottle", bottle(), 0.045, {0.20, 0.50, 0.30}}};
}

/// What a camera below sees of a thing in daylight, were there no membrane: matt, lit from all
/// sides and by a window to the right, under a bright ceiling.
inline gelight::Image<gelight::Rgb8> seen_in_daylight(const gelight::Raster<float>& raster,
                                                      const gelight::Mesh<double>& mesh,
                                                      const Colour& colour) {
  using gelight::Index;
  using gelight::Vec3;
  const Index width = raster.face.width(), height = raster.face.height();
  std::vector<gelight::Rgb8> shades;
  const auto level = [](double c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
  const Vec3<double> window = Vec3<double>(0.7, -0.4, -0.6).normalized();
  for (const auto& [a, b, c] : mesh.faces) {
    const auto at = [&](Index v) { return Vec3<double>(mesh.position(v).data()); };
    Vec3<double> n = gelight::cross<double>(at(b) - at(a), at(c) - at(a)).stableNormalized();
    if (n.z() > 0) n = -n;  // the side that is seen
    const double light = 0.25 + 0.15 * (1 + n.z()) + 0.6 * std::max(0.0, n.dot(window));
    shades.push_back(
        {level(colour.red * light), level(colour.green * light), level(colour.blue * light)});
  }
  gelight::Image<gelight::Rgb8> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const Index face = raster.face(x, y);
      const double ceiling = 0.62 + 0.12 * x / width - 0.10 * y / height;
      image(x, y) = face >= 0
                        ? shades[static_cast<std::size_t>(face)]
                        : gelight::Rgb8{level(ceiling), level(ceiling), level(0.95 * ceiling)};
    }
  }
  return image;
}
