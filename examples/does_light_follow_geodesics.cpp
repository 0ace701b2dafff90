// Does light follow geodesics? Traced ray by ray through the gel of a tube, it does not.
//
//       .-~~~~~-.       The membrane's inner side is dark: light that meets it is gone. So what
//     .'  .---.  `.     lights a place came there straight, off the gel's inner side, or across
//    (   ( air )   )    the hollow. Within the gel it gets round as far as a straight line does
//     `.  `-+-' .-'     that just touches the hollow, twice over; a geodesic gets all the way
//     round.
//       `-~LED~-`

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/traced.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/lesson.hpp"
#include "support/view.hpp"

using gelight::Index;
using gelight::Vec2;
using gelight::Vec3;

namespace {

constexpr double radius = 0.01146, length = 0.03, degree = std::numbers::pi / 180;

double round_to(const Vec3<double>& p) { return std::atan2(p[1], p[0]) / degree; }
Vec3<double> outwards(const Vec3<double>& p) { return Vec3<double>(p[0], p[1], 0).normalized(); }

/// Light of an LED in the rim of a tube of gel this thick, black outside, air inside.
struct Tube {
  double thickness;
  double farthest = 0;  // degrees that a straight line goes round, which touches the hollow
  gelight::TracedLight light;
  std::vector<gelight::TracedPath> paths;

  [[nodiscard]] std::string name() const {
    return std::to_string(static_cast<int>(1e3 * thickness)) + " mm";
  }

  Tube(const gelight::Surface<double>& membrane, double thick) : thickness(thick) {
    farthest = 2 * std::acos(1 - thickness / radius) / degree;
    const std::vector<gelight::InnerLayer> hollow{{gelight::beneath(membrane, thickness)}};
    const gelight::LightTracer tracer(membrane, {.albedo = 0}, hollow);
    const gelight::TracedLed led{.place = {radius - thickness / 2, 0, 1e-5},
                                 .radius = 0.4 * thickness};
    light = tracer.trace(led, {.paths = 1'000'000});
    paths = tracer.paths(led, {.paths = 20'000});
  }
};

bool is_through_hollow(const gelight::TracedPath& path) {
  return std::find(path.layers.begin(), path.layers.end(), 1) != path.layers.end();
}

/// Means over the light that arrives between two angles round from the LED, in degrees.
struct Means {
  double turned = 0, tilt = 0, irradiance = 0;
};
Means means(const gelight::Surface<double>& membrane, const gelight::TracedLight& light,
            const gelight::LightField<double>& geodesic, double from, double to) {
  Means sum;
  double weights = 0, count = 0;
  for (Index v = 0; v < membrane.vertex_count(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    const Vec3<double>& p = membrane.position(v);
    const double at = std::abs(round_to(p));
    if (at < from || at > to || p[2] < 0.002 || p[2] > length / 2) continue;
    const Vec3<double> out = outwards(p), way = light.direction[i];
    const Vec3<double> laid = way - way.dot(out) * out;
    const double turn = std::atan2(gelight::cross(laid, geodesic[i]).norm(), laid.dot(geodesic[i]));
    sum.turned += light.irradiance[i] * turn / degree;
    sum.tilt += light.irradiance[i] * std::asin(std::min(1.0, way.dot(out))) / degree;
    weights += light.irradiance[i], count += 1;
  }
  return {sum.turned / weights, sum.tilt / weights, weights / count};
}

constexpr double enlarged = 11500;  // pixels a metre, of the end

// The end of a tube, and how light gets on from the LED.
void draw_end(Figure& figure, double x, const Tube* tube) {
  const double y = 185;
  const auto on_page = [&](const Vec3<double>& p) {
    return Vec2<double>(x + enlarged * p[0], y - enlarged * p[1]);
  };
  figure.pen({0.93, 0.90, 0.80}, 1);
  figure.disc(x, y, enlarged * radius);
  if (tube == nullptr) {  // along the membrane, either way round
    figure.pen(white, 1);
    figure.disc(x, y, enlarged * radius - 3);
    std::vector<Vec2<double>> circle;
    for (int i = 0; i <= 120; ++i) {
      const double angle = 3 * i * degree;
      circle.push_back(on_page(radius * Vec3<double>(std::cos(angle), std::sin(angle), 0)));
    }
    figure.pen(red, 2);
    figure.polyline(circle);
    figure.disc(x + enlarged * radius, y, 5);
    return;
  }
  figure.pen(white, 1);
  figure.disc(x, y, enlarged * (radius - tube->thickness));
  for (std::size_t i = 0; i < 160; ++i) {
    const auto& path = tube->paths[i];
    if (path.is_lost) continue;
    std::vector<Vec2<double>> line;
    for (const auto& place : path.places) line.push_back(on_page(place));
    figure.pen(is_through_hollow(path) ? orange : blue, 0.7);
    figure.polyline(line);
  }
  figure.pen(red, 1);
  figure.disc(x + enlarged * (radius - tube->thickness / 2), y, 5);
}

// The wall laid flat, and which way light goes along it.
void draw_wall(Figure& figure, double x, const gelight::Surface<double>& membrane,
               const gelight::LightField<double>& field, Colour colour) {
  constexpr double width = 290, bottom = 480, a_metre = width / (360 * degree * radius);
  figure.pen(pale, 1);
  for (const double turn : {-180, -90, 0, 90, 180}) {
    const double at = x + width / 2 + turn * width / 360;
    figure.line(at, bottom, at, bottom - 0.022 * a_metre);
  }
  figure.line(x, bottom, x + width, bottom);
  for (double z = 0.002; z < 0.022; z += 0.003) {
    for (double turn = -168; turn <= 168; turn += 14) {
      const Vec3<double> place(radius * std::cos(turn * degree), radius * std::sin(turn * degree),
                               z);
      const Vec3<double> way =
          field[static_cast<std::size_t>(gelight::nearest_vertex<double>(membrane, place))];
      const Vec3<double> around(-std::sin(turn * degree), std::cos(turn * degree), 0);
      const double u = x + width / 2 + turn * width / 360, v = bottom - z * a_metre;
      const double along = 13 * way.dot(around), up = 13 * way[2];
      figure.pen(colour, 1.2);
      figure.arrow(u, v, u + along, v - up, std::min(5.0, 0.6 * std::hypot(along, up)));
    }
  }
  figure.pen(red, 1);
  figure.disc(x + width / 2, bottom, 5);
}

}  // namespace

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "does_light_follow_geodesics");
  std::vector<gelight::ProfilePoint<double>> outline;
  for (int i = 0; i <= 30; ++i) outline.push_back({radius, length * i / 30});
  const gelight::Surface<double> membrane(gelight::revolve<double>(outline, 0.001));
  const auto led =
      gelight::vertex_point<double>(gelight::nearest_vertex<double>(membrane, {radius, 0, 0}));
  const auto geodesic = gelight::geodesic_field<double>(gelight::ExactSolver<double>(membrane), led,
                                                        gelight::vertex_points(membrane));
  const std::vector<Tube> tubes{{membrane, 0.001}, {membrane, 0.005}};

  for (const Tube& tube : tubes) {
    const std::string gel = tube.name() + " of gel: ";
    double within = 0, through = 0;  // how far round the farthest path gets
    for (const auto& path : tube.paths) {
      double& most = is_through_hollow(path) ? through : within;
      if (!path.is_lost) most = std::max(most, std::abs(round_to(path.places.back())));
    }
    lesson.expect(within < tube.farthest + 4 && within > tube.farthest - 4,
                  gel + "within it light gets as far round as a line that touches the hollow");
    lesson.expect(through > 175, gel + "what lights the far side comes through the hollow");
    const Means near = means(membrane, tube.light, geodesic, 0, 30);
    const Means far = means(membrane, tube.light, geodesic, 150, 180);
    lesson.expect(near.turned < 12,
                  gel + "near the LED the geodesic tells which way round it goes");
    lesson.expect(near.tilt > 15 && far.tilt > 60,
                  gel + "but light leans out of the membrane, on the far side most of all");
    lesson.expect(far.turned > 45, gel + "there it goes another way than the geodesic");
    lesson.expect(far.irradiance < near.irradiance / 30, gel + "and is a thirtieth as bright");
  }

  Figure figure(1020, 535);
  draw_end(figure, 175, nullptr);
  draw_wall(figure, 30, membrane, geodesic, red);
  double x = 365;
  for (const Tube& tube : tubes) {
    draw_end(figure, x + 145, &tube);
    draw_wall(figure, x, membrane, tube.light.direction, blue);
    x += 335;
  }
  figure.pen(black, 1);
  figure.text("Geodesics", 175, 24, 18);
  figure.text("Traced, 1 mm of gel", 510, 24, 18);
  figure.text("Traced, 5 mm of gel", 845, 24, 18);
  figure.text(
      "Above: a tube from its end, the LED on the right. Blue: paths in the gel. Orange: through "
      "the hollow.",
      510, 345, 14);
  figure.text(
      "Below: its wall laid flat, the LED at the bottom. Arrows: the mean way of the light; the "
      "shorter, the more it leans out.",
      510, 517, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
