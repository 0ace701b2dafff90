// A GelTip in MuJoCo: it presses on three things, harder and harder, rolls over them and slides.
//
//    MuJoCo --- poses, contact force --.                      every frame
//                                      |
//      pose in the camera's frame --> rasterize_into --> render_next_into --> tactile image
//
// mujoco [FOLDER [WIDTH]]. Checks that the image is that at rest while nothing touches, that things
// bear the finger's weight and push, and that what they change of the image grows with the force.

#include <cstdio>
#include <fstream>
#include <numbers>

#include "gelight/sensor/presets.hpp"
#include "support/animation.hpp"
#include "support/household.hpp"
#include "support/mujoco_world.hpp"
#include "support/plain_words.hpp"
#include "support/scene.hpp"

using namespace gelight;

namespace {

// A GelTip's, and of the world: metres, kilograms, seconds.
constexpr double tip_radius = 0.01146, tip_length = 0.0455, mass = 0.03, gravity = 9.81;
constexpr double lifted = 0.03, frame_time = 0.04, circle = 2 * std::numbers::pi;

struct Touched {
  std::string name;
  Body body;          // as a camera sees it
  std::string shape;  // for MuJoCo, which knows contacts of convex shapes
};

std::vector<Touched> things() {
  using household_detail::centred, household_detail::threaded_rod;
  const auto at = [](double x) { return Pose(Eigen::Matrix3d::Identity(), {x, 0, 0}); };
  return {
      {"ball", {icosphere(5, 0.007), orange, at(-0.032)}, "<geom size='0.007'/>"},
      {"ring", {centred(torus(0.006, 0.0015, 200, 40)), green, at(0)}, ring_of_bars(0.006, 0.0015)},
      {"rod", {centred(threaded_rod()), blue, at(0.032)}, "<geom type='mesh' mesh='rod'/>"}};
}

/// Writes what MuJoCo is told; its viewer opens it, too.
void write_model(const std::string& path, const std::vector<Touched>& touched) {
  std::ofstream xml(path);
  xml << "<mujoco><option timestep='0.0005' cone='elliptic'/><default><geom margin='0.0005' "
         "gap='0.0005' friction='0.4' solref='-4000 -130' solimp='0.8 0.8 0.001'/></default><asset>"
      << mesh_asset("rod", touched.back().body.mesh) << "</asset><worldbody>";
  for (const auto& [name, body, shape] : touched) {
    xml << "<body pos='" << body.pose.translation.x() << " 0 0'>" << shape << "</body>";
  }
  xml << "<body><joint name='along' type='slide' axis='1 0 0' damping='2'/>"
         "<joint name='up' type='slide' axis='0 0 1' damping='8'/>"
         "<joint name='roll' type='hinge' axis='0 1 0' damping='0.004' armature='1e-5'/>"
      << "<geom size='" << tip_radius << "' mass='" << mass << "'/></body></worldbody><actuator>"
      << "<position joint='along' kp='300'/><motor joint='up'/><position joint='roll' kp='0.5'/>"
      << "</actuator></mujoco>";
}

/// What the finger shall do, some seconds after it turned to a thing.
struct Wish {
  const char* does;
  double push = 0, along = 0, roll = 0;  // N, m, radians
};
Wish wish(double t) {
  const auto swing = [&](double from) { return std::sin(circle * (t - from) / 0.4); };
  if (t < 0.4 || t > 2.1) return {"lifted"};
  if (t < 1.3) return {"presses", 1 + std::floor((t - 0.4) / 0.3)};
  if (t < 1.7) return {"rolls", 3, tip_radius * 0.5 * swing(1.3), 0.5 * swing(1.3)};
  return {"slides", 2, 0.005 * swing(1.7)};
}

void move(MujocoWorld& world, const Wish& wish, double middle) {
  mjData& state = world.state();
  for (const double end = state.time + frame_time; state.time < end - 1e-9;) {
    const double lift = mass * gravity + 50 * (lifted - state.qpos[1]);
    const std::array wishes{middle + wish.along, wish.push > 0 ? -wish.push : lift, wish.roll};
    std::ranges::copy(wishes, state.ctrl);
    world.step();
  }
}

// Of the contact sheet (the first three with the 0.3 N that the finger weighs), and which frames of
// each thing it shows; at the first three all rests.
constexpr std::array rows{"1.3 N", "2.3 N", "3.3 N", "rolled", "slid"};
constexpr std::array<int, 5> row_frames{16, 24, 31, 35, 45};

}  // namespace

int main(int count, char** arguments) try {
  const std::string out = folder_argument(count, arguments, "mujoco [FOLDER [WIDTH]]", 2);
  // Of fewer pixels too few change for the press to be told from one of a newton more.
  const Index width = whole_number(count > 2 ? arguments[2] : "320", "the width", 40, 4096);
  const auto touched = things();
  write_model(out + "/mujoco.xml", touched);
  MujocoWorld world(out + "/mujoco.xml");
  world.state().qpos[1] = lifted;

  // The camera is behind the tip and looks at it; x is to the right in both frames.
  const Pose camera_in_finger(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(),
                              {0, 0, tip_length - tip_radius});
  auto preset = geltip(width, width * 3 / 4);
  preset.camera = Camera<float>::from_vertical_fov(0.7f, width, width * 3 / 4);
  const auto sensor = tactile_renderer(preset);
  auto frame = sensor.rest_frame();
  Image<float> depth(preset.camera.width, preset.camera.height);
  const Pose eye = looking({-0.02, -0.22, 0.10}, {0, 0, 0.024});
  const auto view = Camera<float>::from_vertical_fov(0.37f, width, width * 3 / 4);
  std::vector<Body> bodies{{box(0.1, 0.04, 0.001), pale}};
  for (const Touched& thing : touched) bodies.push_back(thing.body);
  bodies.push_back({membrane<double>(), {0.45, 0.5, 0.6}});
  Animation animation(2 * width, depth.height());
  std::vector<Column> sheet;
  bool is_right = true;
  for (const Touched& thing : touched) {
    sheet.push_back({thing.name, {}});
    std::ptrdiff_t area = 0;
    for (int i = 0; i < 60; ++i) {
      const Wish now = wish(i * frame_time);
      move(world, now, thing.body.pose.translation.x());
      const double force = std::abs(world.contact_force().z());
      const Pose camera = bodies.back().pose = moved(world.last_body(), camera_in_finger);
      std::ranges::fill(depth.pixels(), std::numeric_limits<float>::infinity());
      for (const Touched& near : touched) {
        rasterize_into(depth, near.body.mesh, seen_from(camera, near.body.pose), preset.camera);
      }
      sensor.render_next_into(frame, depth);
      if (force == 0) is_right &= frame.image == sensor.rest_image();
      const std::string words = now.does + (", " + in_newtons(force));
      animation.add(side_by_side(photograph(bodies, eye, view), frame.image, words), 60);

      const auto row = std::ranges::find(row_frames, i) - row_frames.begin();
      if (row == std::ssize(row_frames)) continue;
      sheet.back().images.push_back(frame.image);
      const auto before = std::exchange(area, changed_pixels(frame.image, sensor.rest_image()));
      std::printf("%-12s  %-6s  contact force %4.2f N, %5td pixels changed\n", thing.name.c_str(),
                  rows[static_cast<std::size_t>(row)], force, area);
      const bool is_balanced = std::abs(force / (now.push + mass * gravity) - 1) < 0.01;
      if (row < 3) is_right &= is_balanced && area > before;
    }
  }
  animation.save(out + "/mujoco.webp");
  save_sheet(out + "/mujoco.png", sheet, rows);
  std::printf("Pictures: %s/mujoco.webp, %s/mujoco.png\n", out.c_str(), out.c_str());
  if (!is_right) std::fprintf(stderr, "An image or a force is not what it has to be.\n");
  return is_right ? 0 : 1;
} catch (...) {
  return told();
}
