// A GelTip sensor from nothing: membrane, light fields, objects pressed in, tactile images.
//
//        LED  o----------------------.             mesh, LEDs        once per sensor
//             |     membrane          \            -> four light fields, baked to pixels
//    camera  [>   sees all of this     )  <- object
//             |                       /            depth of the object   every frame
//        LED  o----------------------'             -> smooth, unproject, normals, Phong
//
// With options it runs on data of your own: --mesh, --rest, --contact, --background.

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/image/raster.hpp"
#include "gelight/io/image.hpp"
#include "gelight/io/npy.hpp"
#include "gelight/light/geodesic.hpp"
#include "gelight/light/linear.hpp"
#include "gelight/light/plane.hpp"
#include "gelight/light/transport.hpp"
#include "gelight/mesh/nearest.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/sensor/bake.hpp"
#include "gelight/sensor/presets.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/command_line.hpp"
#include "support/field_pictures.hpp"
#include "support/figure.hpp"
#include "support/mesh_file.hpp"
#include "support/press.hpp"

using gelight::Background;
using gelight::Light;
using gelight::Mesh;
using gelight::Raster;
using gelight::Surface;

namespace {

/// A number with as many digits as it has.
std::string in_words(double number) {
  std::array<char, 32> words{};
  std::snprintf(words.data(), words.size(), "%g", number);
  return words.data();
}

struct Settings {
  double radius = 0.01146, length = 0.0455, edge = 0.001, depth = 0.0025, fov = 90;
  std::optional<double> scale;
  Index width = 640, height = 480;
  std::string mesh, rest, background, out = "out";
  std::vector<std::string> contacts;
};

void name_options(CommandLine& line, Settings& settings) {
  line.add("--radius", settings.radius, "radius of the membrane, metres");
  line.add("--length", settings.length, "length from the camera to the tip, metres");
  line.add("--edge", settings.edge, "edge length of the mesh, metres");
  line.add("--depth", settings.depth, "how deep objects are pressed, metres");
  line.add("--fov", settings.fov, "field of view from top to bottom, degrees");
  line.add("--width", settings.width, "pixels");
  line.add("--height", settings.height, "pixels");
  line.add("--mesh", settings.mesh, "a membrane of your own (STL, OBJ, PLY, OFF); needs --contact");
  line.add("--rest", settings.rest, "its depth map without contact (.npy, 16-bit .png)");
  line.add("--contact", settings.contacts, "depth maps of what touches it (likewise)");
  line.add("--scale", settings.scale, "metres to a step of the depth maps in .png");
  line.add("--background", settings.background, "what the camera sees in ambient light");
  line.add("--out", settings.out, "folder for the pictures");
}

/// Throws InvalidInput for options that would change nothing beside others.
void require_meaning(const CommandLine& line, const Settings& settings) {
  if (settings.mesh.empty()) return;
  for (const std::string option : {"--radius", "--length", "--edge", "--depth"}) {
    if (!line.has(option)) continue;
    throw gelight::InvalidInput(option + " is for the GelTip that is made without --mesh; " +
                                settings.mesh + " has its own shape");
  }
  if (settings.contacts.empty()) {
    throw gelight::InvalidInput("nothing touches the membrane of " + settings.mesh +
                                ": give --contact, depth maps of what does");
  }
}

/// Throws InvalidInput where a length cannot be one in metres of a sensor for a fingertip; one that
/// is a thousand times too large will be in millimetres.
void require_metres(double length, const std::string& what) {
  constexpr double least = 1e-3, most = 1;
  const std::string says = what + " is " + in_words(length) + " m";
  if (length > most && length <= 1000 * most) {
    throw gelight::InvalidInput(says + ": is it in millimetres? Lengths are in metres");
  }
  if (!(length >= least && length <= most)) {
    throw gelight::InvalidInput(says + ", which is no sensor's; lengths are in metres");
  }
}

/// The largest depth of a surface in an image, in whatever unit; 0 if it shows none.
double largest_depth(const Image<double>& depth) {
  double largest = 0;
  for (const double z : depth.pixels()) {
    if (std::isfinite(z)) largest = std::max(largest, z);
  }
  return largest;
}

std::string wanted_size(const Settings& settings) {
  return "not --width x --height, which is " + std::to_string(settings.width) + " x " +
         std::to_string(settings.height);
}

std::string lower_case(std::string words) {
  for (char& c : words) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return words;
}

Image<double> read_depth(const std::string& path, const Settings& settings) {
  const bool is_png = lower_case(std::filesystem::path(path).extension().string()) == ".png";
  if (is_png && !settings.scale) {
    throw gelight::InvalidInput(path + " needs --scale, how many metres a step of its values is");
  }
  auto depth =
      is_png ? gelight::read_depth_png(path, *settings.scale) : gelight::read_npy<double>(path);
  if (depth.width() != settings.width || depth.height() != settings.height) {
    throw gelight::InvalidInput(path + " has " + std::to_string(depth.width()) + " x " +
                                std::to_string(depth.height()) + " pixels, " +
                                wanted_size(settings));
  }
  const double largest = largest_depth(depth);
  if (largest == 0)
    throw gelight::InvalidInput(path + " shows no surface: no depth in it is above 0 and finite");
  require_metres(largest, "the largest depth in " + path);
  return depth;
}

void require_plausible(const Settings& settings) {
  std::vector<std::string> files = settings.contacts;
  files.insert(files.end(), {settings.mesh, settings.rest, settings.background});
  for (const std::string& file : files) {
    if (file.empty() || std::filesystem::exists(file)) continue;
    throw gelight::InvalidInput("there is no file " + file);
  }
  if (!(settings.fov > 0 && settings.fov < 180)) {
    throw gelight::InvalidInput("--fov is " + in_words(settings.fov) +
                                " degrees, which is not between 0 and 180");
  }
  constexpr Index most_pixels = 8192;  // a side
  if (!(settings.width > 0 && settings.height > 0 && settings.width <= most_pixels &&
        settings.height <= most_pixels)) {
    throw gelight::InvalidInput("an image of " + std::to_string(settings.width) + " x " +
                                std::to_string(settings.height) + " pixels; each side has 1 to " +
                                std::to_string(most_pixels));
  }
  if (settings.scale && !(*settings.scale > 0 && std::isfinite(*settings.scale))) {
    throw gelight::InvalidInput("--scale is " + in_words(*settings.scale) +
                                "; a step of a depth map is more than 0 m");
  }
  require_metres(settings.radius, "--radius");
  require_metres(settings.length, "--length");
  if (settings.length < settings.radius) {
    throw gelight::InvalidInput("--length is " + in_words(settings.length) +
                                " m, less than the membrane's radius, " +
                                in_words(settings.radius) + " m");
  }
  if (!(settings.depth >= 0 && settings.depth < settings.radius)) {
    throw gelight::InvalidInput("--depth is " + in_words(settings.depth) +
                                " m; objects are pressed in by 0 m up to the membrane's radius, " +
                                in_words(settings.radius) + " m");
  }
  // Of equilateral triangles there are two to a vertex.
  constexpr double most_vertices = 5e6;
  const double area = 2 * std::numbers::pi * settings.radius * settings.length;
  const double least_edge = std::sqrt(area / (std::sqrt(0.75) * most_vertices));
  if (!(settings.edge > least_edge && settings.edge < settings.radius)) {
    throw gelight::InvalidInput(
        "--edge is " + in_words(settings.edge) + " m; edges are longer than " +
        in_words(least_edge) +
        " m, which makes five million vertices, and shorter than the radius");
  }
}

/// Runs a stage of the work, and prints its name before and its time after.
template <class Work>
auto timed(const std::string& name, const Work& work) {
  std::printf("  %-38s", name.c_str());
  std::fflush(stdout);
  const auto start = std::chrono::steady_clock::now();
  auto result = [&] {
    try {
      return work();
    } catch (...) {
      std::printf("\n");  // what is told of it has a line of its own
      throw;
    }
  }();
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  std::printf("%9.1f ms\n", time.count());
  return result;
}

Mesh<double> read_membrane(const std::string& path) {
  Mesh<double> mesh = mesh_of_file(path);
  double farthest = 0;
  for (const auto& p : mesh.positions) farthest = std::max(farthest, std::abs(p[2]));
  require_metres(farthest, "the farthest point of " + path);
  return mesh;
}

struct Contact {
  std::string name;
  Image<double> depth;
};

/// What is in files, read before anything is computed.
struct Given {
  std::optional<Mesh<double>> mesh;
  std::optional<Image<double>> rest;
  std::optional<Image<Rgb8>> background;
  std::vector<Contact> contacts;

  explicit Given(const Settings& settings) {
    if (!settings.mesh.empty()) mesh = read_membrane(settings.mesh);
    if (!settings.background.empty()) {
      background = gelight::read_png(settings.background);
      if (background->width() != settings.width || background->height() != settings.height) {
        throw gelight::InvalidInput(
            settings.background + " has " + std::to_string(background->width()) + " x " +
            std::to_string(background->height()) + " pixels, " + wanted_size(settings));
      }
    }
    if (!settings.rest.empty()) rest = read_depth(settings.rest, settings);
    for (const std::string& path : settings.contacts) {
      contacts.push_back({std::filesystem::path(path).stem().string(), read_depth(path, settings)});
    }
  }
};

/// How far a mesh reaches from the camera's axis.
double widest(const Mesh<double>& mesh) {
  double radius = 0;
  for (const auto& p : mesh.positions) radius = std::max(radius, std::hypot(p[0], p[1]));
  return radius;
}

/// The sensor: what does not change from frame to frame.
struct Sensor {
  Mesh<double> mesh;
  Surface<double> surface;
  Camera<double> camera;
  Raster<double> raster;  // the membrane at rest, inside the lens
  Image<double> rest;
  std::vector<gelight::SurfacePoint<double>> points;  // that the pixels show
  std::array<Index, 3> leds;                          // vertices
  Background<double> background;

  Sensor(const Settings& settings, const Given& given)
      : mesh(given.mesh ? *given.mesh
                        : gelight::membrane(settings.radius, settings.length, settings.edge)),
        surface(mesh),
        camera(Camera<double>::from_vertical_fov(settings.fov * std::numbers::pi / 180,
                                                 settings.width, settings.height)),
        raster(gelight::rasterize(mesh, camera)),
        rest(given.rest.value_or(raster.depth)) {
    for (Index v = 0; v < camera.height; ++v) {
      for (Index u = 0; u < camera.width; ++u) {
        if (!in_lens(u, v)) raster.face(u, v) = -1;
      }
    }
    points = gelight::pixel_points(raster);
    if (points.empty()) throw gelight::InvalidInput("the camera sees nothing of the membrane");
    const double third = 2 * std::numbers::pi / 3;
    const std::array angles{0.0, third, 2 * third};
    try {
      const auto rim = gelight::leds_on_border(mesh, angles);
      for (std::size_t k = 0; k < leds.size(); ++k) leds[k] = rim[k].element[0];
    } catch (const gelight::InvalidInput&) {  // a closed mesh: about the camera
      const double radius = widest(mesh);
      for (std::size_t k = 0; k < leds.size(); ++k) {
        leds[k] = gelight::nearest_vertex<double>(
            surface, {radius * std::cos(angles[k]), radius * std::sin(angles[k]), 0});
      }
    }
    background = given.background ? *given.background : round_background();
  }

  /// A round lens shows a disc as high as the image.
  [[nodiscard]] bool in_lens(Index u, Index v) const {
    return std::hypot(u - camera.cx, v - camera.cy) < 0.5 * camera.height;
  }

  [[nodiscard]] Image<Rgb8> round_background() const {
    Image<Rgb8> image(camera.width, camera.height);
    for (Index v = 0; v < camera.height; ++v) {
      for (Index u = 0; u < camera.width; ++u) {
        if (in_lens(u, v)) image(u, v) = {130, 130, 130};
      }
    }
    return image;
  }
};

struct NamedField {
  std::string name;
  bool along_surface = true;
  std::array<Image<Vec3<double>>, 3> leds;
};

std::vector<NamedField> light_fields(const Sensor& sensor) {
  using gelight::vertex_point;
  using Field = gelight::LightField<double>;
  const auto exact =
      timed("exact solver, set-up", [&] { return gelight::ExactSolver<double>(sensor.surface); });
  const auto heat = timed("vector heat solver, set-up",
                          [&] { return gelight::VectorHeatSolver<double>(sensor.surface); });
  const auto field = [&](const std::string& name, bool along_surface,
                         const std::function<Field(Index)>& of_led) {
    return timed(name + " field, 3 LEDs", [&] {
      NamedField result{name, along_surface, {}};
      for (std::size_t k = 0; k < 3; ++k) {
        result.leds[k] = gelight::bake(of_led(sensor.leds[k]), sensor.raster);
      }
      return result;
    });
  };
  Vec3<double> middle = Vec3<double>::Zero();
  for (const auto& [x, y, z] : sensor.mesh.positions) middle += Vec3<double>(x, y, z);
  middle /= static_cast<double>(sensor.mesh.positions.size());
  const gelight::Surface<double>& surface = sensor.surface;
  const auto& points = sensor.points;
  return {field("linear", false,
                [&](Index led) {
                  return gelight::linear_field<double>(surface, surface.position(led), points);
                }),
          field("plane", true,
                [&](Index led) {
                  return gelight::plane_field<double>(surface, vertex_point<double>(led), points);
                }),
          field("geodesic", true,
                [&](Index led) {
                  return gelight::geodesic_field<double>(exact, vertex_point<double>(led), points);
                }),
          field("transport", true, [&](Index led) {
            const Vec3<double> inwards = middle - surface.position(led);
            try {
              return gelight::transport_field<double>(heat, led, inwards, points);
            } catch (const gelight::InvalidInput& wrong) {
              throw gelight::InvalidInput(
                  "the LED at vertex " + std::to_string(led) +
                  " does not shine along the membrane (" + wrong.what() +
                  "): LEDs are wanted in an open rim, and a closed mesh has none");
            }
          })};
}

/// How far from the tip things are pressed in, radians about the middle of its cap: to its side, or
/// where the camera sees less, to half of what the panel shows of the image.
double press_tilt(const Settings& settings) {
  const double middle = settings.length - settings.radius;
  const double shown = std::tan(settings.fov * std::numbers::pi / 360) / 1.5;
  double tilt = 1.1;
  const auto seen = [&] {
    return settings.radius * std::sin(tilt) / (middle + settings.radius * std::cos(tilt));
  };
  while (tilt > 0.01 && seen() > 0.5 * shown) tilt *= 0.9;
  return tilt;
}

std::vector<Contact> pressed_objects(const Settings& settings, const Sensor& sensor) {
  std::vector<Contact> result;
  const auto presses = objects_to_press();
  for (std::size_t i = 0; i < presses.size(); ++i) {
    const double tilt = press_tilt(settings), turn = -0.5 + 1.05 * static_cast<double>(i);
    const auto object =
        pressed(presses[i].object, settings.radius, settings.length, settings.depth, tilt, turn);
    result.push_back({presses[i].name, gelight::rasterize(object, sensor.camera).depth});
  }
  return result;
}

/// Of how many pixels of the membrane in the lens a depth map is in front.
std::size_t touched(const Sensor& sensor, const Image<double>& depth) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
    const double z = depth.pixels()[i];
    if (sensor.raster.face.pixels()[i] >= 0 && z > 0 && z < sensor.rest.pixels()[i]) ++count;
  }
  return count;
}

/// Notes where a --rest that is given is not the depth of the membrane that the light runs on.
void tell_other_rest(const Settings& settings, const Sensor& sensor) {
  if (settings.rest.empty()) return;
  std::size_t seen = 0, known = 0;
  double off = 0;  // as shares of the membrane's depth
  for (std::size_t i = 0; i < sensor.rest.pixels().size(); ++i) {
    if (sensor.raster.face.pixels()[i] < 0) continue;
    ++seen;
    const double z = sensor.rest.pixels()[i], membrane = sensor.raster.depth.pixels()[i];
    if (!(z > 0 && std::isfinite(z))) continue;
    ++known;
    off += std::abs(z - membrane) / membrane;
  }
  std::fflush(stdout);
  if (known < seen) {
    std::fprintf(stderr,
                 "Note: --rest has no depth at %zu of the %zu pixels that show the membrane; are "
                 "--rest and --contact the wrong way round?\n",
                 seen - known, seen);
  }
  if (known > 0 && off > 0.1 * static_cast<double>(known)) {
    std::fprintf(stderr,
                 "Note: --rest is %.0f %% off the depth of the membrane that light runs along, in "
                 "the mean; --mesh gives another\n",
                 100 * off / static_cast<double>(known));
  }
}

/// Notes what touches nothing. Throws InvalidInput where that is all that files give.
void tell_untouched(const Settings& settings, const Sensor& sensor,
                    const std::vector<Contact>& contacts) {
  std::size_t all = 0;
  std::fflush(stdout);  // for the notes to stand beneath what was printed
  for (const Contact& contact : contacts) {
    const std::size_t count = touched(sensor, contact.depth);
    all += count;
    if (count > 0) continue;
    std::fprintf(stderr, "Note: %s touches no pixel of the membrane that the camera shows\n",
                 contact.name.c_str());
  }
  if (all == 0 && !settings.contacts.empty()) {
    throw gelight::InvalidInput(
        "no --contact is nearer to the camera than the membrane at rest, at any pixel; are --rest "
        "and --contact the wrong way round?");
  }
}

gelight::TactileRenderer<double> renderer(const Sensor& sensor, const NamedField& field) {
  // The light on each side of the membrane has its own colour.
  constexpr std::array<std::array<double, 3>, 3> colours{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}};
  std::vector<Light<double>> lights(3);
  for (std::size_t k = 0; k < 3; ++k) {
    lights[k] = {.direction = field.leds[k],
                 .rgb = colours[k],
                 .diffuse = 0.5,
                 .specular = 0.1,
                 .shininess = 100};
  }
  return {sensor.camera, sensor.rest, lights, sensor.background, {.rectify = field.along_surface}};
}

std::string draw_panel(const std::string& path, const Sensor& sensor,
                       const std::vector<NamedField>& fields, const std::vector<Contact>& touches) {
  const int cell = 300, gap = 6, margin = 40;
  // The middle of each image, where the tip is and all contacts are.
  const double scale = 1.5 * cell / sensor.camera.height;
  const double beside = 0.5 * (scale * sensor.camera.width - cell);
  const double above = 0.5 * (scale * sensor.camera.height - cell);
  Figure figure(margin + static_cast<int>(touches.size()) * (cell + gap),
                margin + static_cast<int>(fields.size()) * (cell + gap), {0, 0, 0});
  for (std::size_t row = 0; row < fields.size(); ++row) {
    const auto render = renderer(sensor, fields[row]);
    const double y = margin + static_cast<double>(row) * (cell + gap);
    for (std::size_t column = 0; column < touches.size(); ++column) {
      const double x = margin + static_cast<double>(column) * (cell + gap);
      figure.clipped_image(render.render(touches[column].depth), x - beside, y - above, scale,
                           {x, y, double{cell}, double{cell}});
      figure.pen({1, 1, 1}, 1);
      if (row == 0) figure.text(touches[column].name, x + cell / 2.0, margin / 2.0, 18);
    }
    figure.text(fields[row].name, margin / 2.0, y + cell / 2.0, 18, true);
  }
  figure.save(path);
  return path;
}

std::string draw_isolines(const std::string& path, const Sensor& sensor) {
  const gelight::ExactSolver<double> solver(sensor.surface);
  const Index led = sensor.leds[0];
  const gelight::Source<double> source{gelight::vertex_point<double>(led), 0};
  const auto field = solver.solve(std::span(&source, 1), {.keep_windows = true});
  const auto distances = field.distances();
  const double farthest = *std::max_element(distances.begin(), distances.end());

  const Index columns = 800, rows = 1200;
  const double scale = 0.5, width = scale * columns;
  Figure figure(static_cast<int>(2 * width), static_cast<int>(scale * rows) + 40);
  const std::array<std::pair<const char*, double>, 2> sides{
      {{"the LED's side", -std::numbers::pi / 2}, {"the far side", std::numbers::pi / 2}}};
  for (std::size_t side = 0; side < 2; ++side) {
    const double x = width * static_cast<double>(side), y = 40;
    const OutsideView view(sensor.mesh, sides[side].second, columns, rows);
    figure.image(view.isolines(sensor.surface, field, 0.002, farthest), x, y, scale);
    figure.pen({0.85, 0.1, 0.1}, 1.6);
    const Index step = std::max<Index>(1, sensor.surface.vertex_count() / 50);
    for (Index v = 0; v < sensor.surface.vertex_count(); v += step) {
      std::vector<Vec3<double>> line;
      for (const auto& p : field.path(v)) line.push_back(sensor.surface.position(p));
      view.draw_path(figure, line, x, y, scale);
    }
    figure.pen({0, 0, 0}, 1);
    figure.text(sides[side].first, x + width / 2, 24, 18);
  }
  figure.save(path);
  return path;
}

std::string draw_field(const std::string& path, const Sensor& sensor, const NamedField& field) {
  const double scale = 480.0 / sensor.camera.height;
  const double width = scale * sensor.camera.width;
  Figure figure(static_cast<int>(3 * width), 520);
  const std::array<Colour, 3> pens{{{0.1, 0.2, 0.8}, {0.8, 0.1, 0.1}, {0.0, 0.5, 0.15}}};
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = width * static_cast<double>(k);
    figure.pen(pens[k], 1.2);
    draw_arrows(figure, field.leds[k], sensor.raster.depth, sensor.camera, x, 40, scale,
                std::max<Index>(1, sensor.camera.height / 24));
    figure.pen({0, 0, 0}, 1);
    figure.text(field.name + ", LED " + std::to_string(k), x + width / 2, 22, 20);
  }
  figure.save(path);
  return path;
}

/// What must hold of the result whatever the options were; says what does not.
std::optional<std::string> fault(const Sensor& sensor, const std::vector<NamedField>& fields) {
  for (const NamedField& field : fields) {
    for (const auto& led : field.leds) {
      std::size_t dark = 0;
      for (const Vec3<double>& direction : led.pixels()) {
        dark += direction.isZero();
        if (!direction.isZero() && std::abs(direction.norm() - 1) > 1e-9) {
          return "the " + field.name + " field has a direction that is not of unit length";
        }
      }
      const std::size_t shown = sensor.points.size(), pixels = led.pixels().size();
      if (dark > pixels - shown + shown / 50) {
        return "the " + field.name + " field is dark at " + std::to_string(dark) + " pixels";
      }
    }
    const auto render = renderer(sensor, field);
    if (!(render.render(sensor.rest) == render.rest_image())) {
      return "without contact the " + field.name + " image is not the image at rest";
    }
  }
  return std::nullopt;
}

int run(const Settings& settings) {
  require_plausible(settings);
  const Given given(settings);
  make_folder(settings.out);
  const auto file = [&](const std::string& name) { return settings.out + "/" + name + ".png"; };
  const Sensor sensor = timed("membrane, camera, LEDs", [&] { return Sensor(settings, given); });
  std::printf("  (%d vertices, %d faces, %zu pixels of membrane)\n", sensor.surface.vertex_count(),
              sensor.surface.face_count(), sensor.points.size());
  const auto fields = light_fields(sensor);
  const auto touches = timed("contacts", [&] {
    return given.contacts.empty() ? pressed_objects(settings, sensor) : given.contacts;
  });
  tell_other_rest(settings, sensor);
  tell_untouched(settings, sensor, touches);
  std::vector<std::string> pictures;
  pictures.push_back(timed(std::to_string(fields.size() * touches.size()) + " tactile images",
                           [&] { return draw_panel(file("panel"), sensor, fields, touches); }));
  pictures.push_back(timed("geodesic distance, drawn",
                           [&] { return draw_isolines(file("geodesic_distance"), sensor); }));
  for (const NamedField& field : fields) {
    pictures.push_back(timed(field.name + " field, drawn", [&] {
      return draw_field(file("field_" + field.name), sensor, field);
    }));
  }
  const auto wrong = timed("checks", [&] { return fault(sensor, fields); });
  if (wrong) {
    std::fprintf(stderr, "Wrong result: %s\n", wrong->c_str());
    return 1;
  }
  std::printf("\nPictures:\n");
  for (const std::string& path : pictures) {
    std::printf("  %s\n", std::filesystem::absolute(path).lexically_normal().c_str());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  CommandLine line("Tactile images of a GelTip sensor");
  Settings settings;
  name_options(line, settings);
  line.read(argc, argv);
  require_meaning(line, settings);
  return run(settings);
} catch (...) {
  return told();
}
