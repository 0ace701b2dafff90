#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/mesh/shapes.hpp"

// Objects to press into a fingertip membrane, in metres. Each is made with the point that touches
// first at the origin and its body towards +z.

struct Press {
  std::string name;
  gelight::Mesh<double> object;
};

namespace press_detail {

using gelight::Mesh;
using gelight::Vec3;

inline Mesh<double> lifted(const Mesh<double>& mesh, double x, double y, double z) {
  return gelight::placed<double>(mesh, Eigen::Matrix3d::Identity(), {x, y, z});
}

inline Mesh<double> edge_of_cube(double side) {
  Eigen::Matrix3d eighth;  // about y, an edge down
  const double c = std::sqrt(0.5);
  eighth << c, 0, c, 0, 1, 0, -c, 0, c;
  return gelight::placed<double>(gelight::box(side, side, side), eighth, {0, 0, side * c});
}

// A cylinder that lies along x.
inline Mesh<double> lying_cylinder(double radius, double length) {
  const std::array<gelight::ProfilePoint<double>, 4> outline{
      {{0, -length / 2}, {radius, -length / 2}, {radius, length / 2}, {0, length / 2}}};
  Eigen::Matrix3d quarter;  // z becomes x
  quarter << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  return gelight::placed<double>(gelight::revolve<double>(outline, radius / 10), quarter,
                                 {0, 0, radius});
}

inline Mesh<double> grating(int bars, double pitch, double length) {
  std::vector<Mesh<double>> parts;
  for (int i = 0; i < bars; ++i) {
    const double x = (i - 0.5 * (bars - 1)) * pitch;
    parts.push_back(lifted(gelight::box(pitch / 2, length, pitch), x, 0, pitch / 2));
  }
  return gelight::joined<double>(parts);
}

inline Mesh<double> two_points(double gap, double radius) {
  const std::array<Mesh<double>, 2> parts{
      lifted(gelight::icosphere(4, radius), -gap / 2, 0, radius),
      lifted(gelight::icosphere(4, radius), gap / 2, 0, radius)};
  return gelight::joined<double>(parts);
}

}  // namespace press_detail

inline std::vector<Press> objects_to_press() {
  using namespace press_detail;
  return {{"sphere", lifted(gelight::icosphere(5, 0.008), 0, 0, 0.008)},
          {"cube edge", edge_of_cube(0.016)},
          {"cylinder", lying_cylinder(0.005, 0.020)},
          {"grating", grating(11, 0.0018, 0.016)},
          {"ring", lifted(gelight::torus(0.005, 0.0012, 200, 40), 0, 0, 0.0012)},
          {"two points", two_points(0.008, 0.002)}};
}

/// The object pressed `depth` into the hemisphere of a membrane, `tilt` away from its axis and
/// `turn` about it (radians).
inline gelight::Mesh<double> pressed(const gelight::Mesh<double>& object, double radius,
                                     double length, double depth, double tilt, double turn) {
  const gelight::Vec3<double> out(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn),
                                  std::cos(tilt));
  const gelight::Vec3<double> across(-std::sin(turn), std::cos(turn), 0);
  Eigen::Matrix3d frame;
  frame << across, gelight::cross(out, across), out;
  const gelight::Vec3<double> centre(0, 0, length - radius);
  return gelight::placed<double>(object, frame, centre + (radius - depth) * out);
}
