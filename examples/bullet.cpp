// The half-silvered sensor in a physics engine: things from a drawer fall onto it, are pressed down
// and pushed across it, in Bullet.
//
//    Bullet --- pose, contact force and its centre --.      every step
//       |                                            |
//       pose --> z-buffer --> depth --> springs: how deep, how tilted
//                                            |
//                                 depth of the gel --> tactile, visual, visuotactile image
//
// Checks at every step at which a thing lies still that the springs bear what Bullet says that they
// do, and that this is the known weight and the hand's pressure.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "gelight/image/raster.hpp"
#include "gelight/io/image.hpp"
#include "gelight/membrane/springs.hpp"
#include "gelight/sensor/see_through.hpp"
#include "support/bullet_world.hpp"
#include "support/command_line.hpp"
#include "support/household.hpp"
#include "support/scene.hpp"

using gelight::Camera;
using gelight::Equilibrium;
using gelight::Image;
using gelight::Index;
using gelight::LightLevels;
using gelight::Rgb8;
using gelight::Vec2;

namespace {

struct Settings {
  Index width = 640, height = 480;
  double seconds = 1.5;  // of each thing
  int every = 3;         // frames from one to the next that is written; 0: none
  std::string out = "out";
};

/// How far things were from what they should be, at steps at which they lay still.
struct Faults {
  int steps = 0, unsettled = 0;
  double springs = 0;  // springs against Bullet, largest share of the force
  double weight = 0;   // Bullet against the known weight and pressure
  double centre = 0;   // the force's centre against the centre of mass, m
  double slid = 1;     // the shortest way over the gel, m
};

/// Seconds of each part of the work, summed up.
struct Times {
  double engine = 0, raster = 0, springs = 0, render = 0;
  int steps = 0;
};

class Clock {
 public:
  /// Seconds since this was last asked.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double> passed = now - last_;
    last_ = now;
    return passed.count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The sensor and all that a step of it needs.
struct Sensor {
  Camera<float> camera;
  gelight::SpringBed<float> bed;
  gelight::SeeThroughRenderer<float> renderer;
  gelight::SpringContact<float> contact;
  Image<Rgb8> visual, image;

  explicit Sensor(const Settings& settings)
      : camera(Camera<float>::from_vertical_fov(0.9f, settings.width, settings.height)),
        bed(camera, static_cast<float>(BulletWorld::gel_depth), {.elastic_modulus = 5e4}),
        renderer(
            camera,
            Image<float>(camera.width, camera.height, static_cast<float>(BulletWorld::gel_depth)),
            gelight::edge_lights(camera, 0.1)),
        image(camera.width, camera.height) {}

  /// What all springs together bear, added up from what they are pressed in by.
  [[nodiscard]] double borne() const {
    double sum = 0;
    for (const float u : contact.indentation.pixels()) sum += double{u};
    return sum * bed.gel().stiffness() * bed.spring_area();
  }
};

constexpr std::array<const char*, 3> view_names{"tactile", "visual", "visuotactile"};

/// A thing's images in three lights, for the contact sheet.
Column views_of(const std::string& name, const Sensor& sensor, const Image<float>& gel) {
  Column views{name, {}};
  for (const LightLevels& levels :
       {LightLevels::tactile(), LightLevels::visual(), LightLevels::visuotactile()}) {
    views.images.push_back(sensor.renderer.render(gel, sensor.visual, levels));
  }
  return views;
}

/// Lets a thing fall, presses it down by a hand and pushes it across the gel.
Column let_fall(const Thing& thing, Sensor& sensor, const Settings& settings, Times& times,
                Faults& faults) {
  BulletWorld world(thing);
  const double weight = BulletWorld::gravity * thing.mass, press = 0.15 + 3 * weight;
  const int steps = static_cast<int>(settings.seconds * BulletWorld::frames_a_second);
  double sunk = 0;  // in the last step: a good guess for the next
  int still = 0, settled_steps = 0;
  Vec2<double> lay = Vec2<double>::Zero();  // before it was pushed
  Column views;
  for (int step = 0; step < steps; ++step) {
    const double share = static_cast<double>(step) / steps;
    if (share < 0.75) lay = world.centre_of_mass();
    const double down = share > 0.4 ? press : 0;
    const bool pushes = share > 0.75 && share < 0.9;
    const double side = pushes && world.speed() < 0.08 ? 0.4 : 0;  // a bit more than holds it
    Clock clock;
    world.step({0.88 * side * (weight + down), -0.48 * side * (weight + down), -down});
    times.engine += clock.lap();
    const BulletContact reaction = world.contact();
    const auto mesh = world.placed(thing.mesh, sunk);
    const auto seen = gelight::rasterize<float>(mesh, sensor.camera);
    times.raster += clock.lap();
    sensor.bed.press_tilting_into(sensor.contact, seen.depth, reaction.force, reaction.centre);
    const Image<float> gel = sensor.bed.depth(sensor.contact);
    times.springs += clock.lap();
    sensor.visual = seen_in_daylight(seen, mesh, thing.colour);
    clock.lap();
    sensor.renderer.render_into(sensor.image, gel, sensor.visual);
    times.render += clock.lap();
    ++times.steps;
    if (sensor.contact.equilibrium == Equilibrium::reached && reaction.force > 0) {
      sunk += sensor.contact.displacement + sensor.contact.tilt.dot(reaction.centre);
    }

    still = world.is_still() ? still + 1 : 0;
    if (still > 3 && !pushes) {
      ++settled_steps;
      const double known = weight + down;
      faults.springs = std::max(faults.springs, std::abs(sensor.borne() / reaction.force - 1));
      faults.weight = std::max(faults.weight, std::abs(reaction.force / known - 1));
      faults.centre = std::max(faults.centre, (reaction.centre - world.centre_of_mass()).norm());
      if (sensor.contact.equilibrium != Equilibrium::reached) ++faults.unsettled;
    }
    if (share < 0.74) views = views_of(thing.name, sensor, gel);
    if (settings.every > 0 && step % settings.every == 0) {
      std::string number = std::to_string(step / settings.every);
      number.insert(0, 3 - std::min<std::size_t>(3, number.size()), '0');
      std::string name = thing.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      gelight::write_png(settings.out + "/bullet_" + name + "_" + number + ".png", sensor.image);
    }
  }
  faults.steps += settled_steps;
  const double slid = (world.centre_of_mass() - lay).norm();
  faults.slid = std::min(faults.slid, slid);
  std::printf("  %-11s %4.1f g  pressed in %4.2f mm  slid %4.1f mm  settled in %d of %d steps\n",
              thing.name.c_str(), 1e3 * thing.mass, 1e3 * sunk, 1e3 * slid, settled_steps, steps);
  return views;
}

void require_plausible(const Settings& settings) {
  const auto require = [](bool holds, const std::string& words) {
    if (!holds) throw gelight::InvalidInput(words);
  };
  const auto size = std::to_string(settings.width) + " x " + std::to_string(settings.height);
  require(std::min(settings.width, settings.height) >= 16 &&
              std::max(settings.width, settings.height) <= 8192,
          "an image of " + size + " pixels; each side has 16 to 8192");
  require(settings.seconds > 0 && settings.seconds <= 600,
          "--seconds is " + std::to_string(settings.seconds) + ", not between 0 and 600");
  require(settings.every >= 0,
          "--every is " + std::to_string(settings.every) + "; it counts frames, and 0 writes none");
}

int run(const Settings& settings) {
  require_plausible(settings);
  make_folder(settings.out);
  Sensor sensor(settings);
  Times times;
  Faults faults;
  std::vector<Column> all;
  for (const Thing& thing : things_from_a_drawer()) {
    all.push_back(let_fall(thing, sensor, settings, times, faults));
  }
  const std::string sheet = settings.out + "/bullet.png";
  save_sheet(sheet, all, view_names);

  std::printf("\nSteps a second (%d x %d):\n", settings.width, settings.height);
  for (const auto& [part, seconds] : {std::pair{"Bullet", times.engine},
                                      {"z-buffer", times.raster},
                                      {"springs", times.springs},
                                      {"image", times.render}}) {
    std::printf("  %-10s %8.0f\n", part, times.steps / seconds);
  }
  std::printf("At %d steps at which a thing lay still, at most:\n", faults.steps);
  std::printf("  springs against Bullet's force     %.1e of it\n", faults.springs);
  std::printf("  Bullet's force against the weight  %.1e of it\n", faults.weight);
  std::printf("  its centre beside the mass's       %.2f mm\n", 1e3 * faults.centre);
  std::printf("  without an equilibrium             %d steps\n", faults.unsettled);
  std::printf("Picture: %s\n", sheet.c_str());

  const bool right = faults.steps >= 50 && faults.unsettled == 0 && faults.springs < 1e-5 &&
                     faults.weight < 0.01 && faults.centre < 5e-4 && faults.slid > 5e-4;
  if (!right) std::fprintf(stderr, "Springs and engine are not in equilibrium, or nothing slid.\n");
  return right ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  CommandLine line("A half-silvered sensor under things that Bullet lets fall");
  Settings settings;
  line.add("--width", settings.width, "pixels");
  line.add("--height", settings.height, "pixels");
  line.add("--seconds", settings.seconds, "how long each thing moves");
  line.add("--every", settings.every, "frames from one to the next that is written; 0: none");
  line.add("--out", settings.out, "folder for the pictures");
  line.read(argc, argv);
  return run(settings);
} catch (...) {
  return told();
}
