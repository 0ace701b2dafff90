// Four models of light in a curved sensor: which way does the light of an LED travel at each point?
//
//        .--^--.        linear      straight through space, whatever stands between
//       /   |   \       plane       along the cut of the membrane with the plane through
//      |  ^ | ^  |                  LED, point, and normal at the LED
//      |   \|/   |      geodesic    along the shortest path on the membrane
//      '----o----'      transport   as emitted, carried over the membrane parallel to itself
//          LED
//
// On the cylindrical wall, which can be rolled flat, three of them are known in closed form.

#include <cmath>
#include <numbers>
#include <vector>

#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Vec3;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "light_fields");

  // A GelTip's membrane, an LED on its rim that shines towards the tip, and where we ask: near the
  // vertices of a coarser membrane.
  const double radius = 0.01146, length = 0.0455;
  const auto membrane = gelight::membrane<double>(radius, length, 0.001);
  const gelight::Surface<double> surface(membrane);
  const Vec3<double> upwards(0, 0, 1);
  const auto led = gelight::nearest_vertex<double>(surface, {radius, 0, 0});
  const Vec3<double> at_led =
      surface.position(led) / radius;  // the normal there; the rim is at z = 0
  const auto led_point = gelight::vertex_point<double>(led);
  std::vector<gelight::SurfacePoint<double>> points;
  for (const auto& [x, y, z] : gelight::membrane<double>(radius, length, 0.0028).positions) {
    points.push_back(
        gelight::vertex_point<double>(gelight::nearest_vertex<double>(surface, {x, y, z})));
  }

  const gelight::ExactSolver solver(surface);
  const gelight::VectorHeatSolver heat(surface);
  const std::array<std::pair<const char*, gelight::LightField<double>>, 4> fields{
      {{"linear", gelight::linear_field<double>(surface, surface.position(led), points)},
       {"plane", gelight::plane_field<double>(surface, led_point, at_led, points)},
       {"geodesic", gelight::geodesic_field<double>(solver, led_point, points)},
       {"transport", gelight::transport_field<double>(heat, led, upwards, points)}}};

  // What they must be on the near half of the wall, but for what lies across it in the triangles.
  std::array<double, 4> off{};
  double near = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double> p = surface.position(points[i]), from_led = p - surface.position(led);
    if (p.dot(at_led) < 0 || p[2] > length - 2 * radius || p[2] < 0.002) continue;
    near += 1;
    const Vec3<double> outwards = Vec3<double>(p[0], p[1], 0) / radius;
    const Vec3<double> around = gelight::cross(upwards, outwards);
    const double turn = std::asin(gelight::cross(at_led, outwards)[2]);
    const Vec3<double> across_plane = gelight::cross(at_led, from_led);
    const std::array<Vec3<double>, 4> truth{from_led, gelight::cross(across_plane, outwards),
                                            radius * turn * around + p[2] * upwards, upwards};
    for (std::size_t k = 0; k < 4; ++k) {
      Vec3<double> direction = fields[k].second[i];
      if (k > 0) direction -= direction.dot(outwards) * outwards;
      off[k] += (direction.normalized() - truth[k].normalized()).norm();
    }
  }
  lesson.expect(off[0] / near < 1e-12, "linear: straight from the LED");
  lesson.expect(off[1] / near < 0.02, "plane: along an ellipse, the plane's cut with the cylinder");
  lesson.expect(off[2] / near < 0.001, "geodesic: straight on the wall rolled flat");
  lesson.expect(off[3] / near < 0.001, "transport: up the wall, as emitted");

  Figure figure(1000, 520);
  double x = 10;
  for (const auto& [name, field] : fields) {
    const View view(membrane, {x, 50, 235, 440}, -2.5, 1.25);
    view.paint(figure, [](const auto&) { return Colour{0.93, 0.90, 0.80}; });
    figure.pen(blue, 1.3);
    for (std::size_t i = 0; i < points.size(); ++i) {
      view.draw_arrow(figure, surface.position(points[i]), 0.002 * field[i], 5);
    }
    figure.pen(red, 1);
    view.draw_dot(figure, surface.position(led), 6);
    figure.pen(black, 1);
    figure.text(name, x + 117, 24, 18);
    x += 248;
  }
  figure.text(
      "Red: the LED, on the rim. Arrows: the way its light travels at each point of the membrane.",
      500, 508, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
