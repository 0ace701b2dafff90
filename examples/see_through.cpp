// A sensor one can see through: a half-silvered membrane, and things that press it in.
//
//          things      o==O    /\/\     daylight: the outer light
//     ~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~  coating: throws back a half, lets a half through
//     LED >     gel, a bed of springs < LED    the inner light
//               [ camera ]
//
// Bright inside and dark outside it is a tactile sensor; the other way round a camera; and with
// both lights on both at once.

#include "gelight/sensor/see_through.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "gelight/membrane/springs.hpp"
#include "support/household.hpp"
#include "support/lesson.hpp"

using gelight::Camera;
using gelight::Equilibrium;
using gelight::Image;
using gelight::Index;
using gelight::LightLevels;
using gelight::Rgb8;

namespace {

constexpr float gel_depth = 0.07f;  // metres from the camera

struct Laid {
  Image<float> gel;      // the depth of the gel's surface
  Image<Rgb8> daylight;  // what a camera would see without the membrane
};

double mean(const Image<Rgb8>& image) {
  double sum = 0;
  for (const Rgb8& pixel : image.pixels()) sum += pixel[0] + pixel[1] + pixel[2];
  return sum / (3 * static_cast<double>(image.pixels().size()));
}

}  // namespace

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "see_through");
  const auto camera = Camera<float>::from_vertical_fov(0.9f, 480, 360);
  const gelight::SpringBed<float> bed(camera, gel_depth, {.elastic_modulus = 5e4});
  const Image<float> rest(camera.width, camera.height, gel_depth);
  const gelight::SeeThroughRenderer sensor(camera, rest, gelight::edge_lights(camera, 0.1));

  // Things laid onto the gel and pressed down by a force.
  std::vector<Laid> scenes;
  const auto things = things_from_a_drawer();
  for (const Thing& thing : things) {
    const auto place = [&](double height) {
      return household_detail::moved(thing.mesh, {0, 0, height}, -0.5);
    };
    const double force = 0.2 + 40 * thing.mass;
    const auto above = gelight::rasterize(place(double{gel_depth}), camera);
    const auto contact = bed.press(above.depth, force);
    double borne = 0;
    for (const float u : contact.indentation.pixels()) borne += double{u};
    borne *= bed.gel().stiffness() * bed.spring_area();
    lesson.expect(
        contact.equilibrium == Equilibrium::reached && std::abs(borne - force) < 1e-5 * force,
        "the springs bear the force on the " + thing.name);
    const auto mesh = place(double{gel_depth} - contact.displacement);
    const auto pressed = gelight::rasterize(mesh, camera);
    scenes.push_back({bed.depth(contact), seen_in_daylight(pressed, mesh, thing.colour)});
  }

  const double cell = 240, gap = 8, margin = 34, high = cell * camera.height / camera.width;
  const double scale = cell / camera.width;
  const std::vector<std::pair<std::string, LightLevels>> lights{
      {"tactile", LightLevels::tactile()},
      {"visual", LightLevels::visual()},
      {"visuotactile", LightLevels::visuotactile()}};
  Figure figure(static_cast<int>(margin + 5 * (cell + gap)),
                static_cast<int>(2 * margin + 4 * (high + gap)));
  for (std::size_t column = 0; column < scenes.size(); ++column) {
    const double x = margin + static_cast<double>(column) * (cell + gap);
    for (std::size_t row = 0; row < lights.size(); ++row) {
      const auto& [name, levels] = lights[row];
      const double y = margin + static_cast<double>(row) * (high + gap);
      figure.image(sensor.render(scenes[column].gel, scenes[column].daylight, levels), x, y, scale);
      figure.pen({0, 0, 0}, 1);
      if (column == 0) figure.text(name, margin / 2, y + high / 2, 16, true);
    }
    figure.text(things[column].name, x + cell / 2, margin / 2, 16);
  }

  // The LEDs dim, and the membrane turns into a window.
  double before = 256;
  for (std::size_t column = 0; column < 5; ++column) {
    const double inner = 1 - 0.25 * static_cast<double>(column);
    const auto image = sensor.render(scenes[1].gel, scenes[1].daylight, {inner, 1 - inner});
    const double x = margin + static_cast<double>(column) * (cell + gap);
    const double y = 2 * margin + 3 * (high + gap);
    figure.image(image, x, y, scale);
    figure.text("LEDs " + std::to_string(static_cast<int>(100 * inner)) + " %, daylight " +
                    std::to_string(static_cast<int>(100 * (1 - inner))) + " %",
                x + cell / 2, y - margin / 2, 14);
    const double now = mean(sensor.render(scenes[1].gel, scenes[1].daylight, {inner, 1}));
    lesson.expect(now < before, "with dimmer LEDs the image is darker");
    before = now;
  }
  const auto& window = scenes[1];
  lesson.expect(
      sensor.render(window.gel, window.daylight, LightLevels::visual()) == window.daylight,
      "without LEDs it shows what is beyond, bit for bit");
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
