// How many presses are enough, and which model: calibration_chart PHOTOGRAPHS OUT
//
// PHOTOGRAPHS holds gelsight_mini and gelsight, folders as gelight/io/presses.hpp reads them. Five
// presses of each are held out in turn; each fit is to others only. Writes calibration.png and
// calibration.md to OUT.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "gelight/io/presses.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/calibration_measure.hpp"
#include "support/plot.hpp"

using gelight::BallPress;
using gelight::Image;
using gelight::PressFolder;
using gelight::ReflectanceModel;

namespace {

Image<gelight::Rgb8> rounded(const Image<gelight::Change>& image) {
  Image<gelight::Rgb8> out(image.width(), image.height());
  for (std::size_t i = 0; i < out.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double level = std::clamp(image.pixels()[i][c], 0.0, 255.0);
      out.pixels()[i][c] = static_cast<std::uint8_t>(std::lround(level));
    }
  }
  return out;
}

// Levelled grey levels inside of contacts that a fit to `used` other presses has not seen.
double held_out_error(const PressFolder& all, ReflectanceModel model, std::size_t used) {
  double sum = 0;
  constexpr std::size_t folds = 5;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    const std::size_t unseen = (2 + 4 * fold) % all.presses.size();
    std::vector<std::size_t> order(all.presses.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    order.erase(order.begin() + static_cast<std::ptrdiff_t>(unseen));
    std::mt19937 random(static_cast<unsigned>(fold));
    std::shuffle(order.begin(), order.end(), random);
    std::vector<BallPress> presses;
    for (std::size_t i = 0; i < std::min(used, order.size()); ++i) {
      presses.push_back(all.presses[order[i]]);
    }
    gelight::CalibrationOptions options;
    options.model = model;
    const auto sensor = gelight::calibrate(all.background, presses, options).sensor;
    const BallPress& test = all.presses[unseen];
    const auto ours = rounded(gelight::predict(sensor, test.contact, test.ball_radius));
    sum += held_out(test, all.background, ours).levelled / folds;
  }
  return sum;
}

// Milliseconds of a frame of which every pixel is computed.
template <class Renderer>
double frame_time(const Renderer& renderer, const Image<float>& depth) {
  Image<gelight::Rgb8> out(depth.width(), depth.height());
  double least = 1e9;
  for (int i = 0; i < 40; ++i) {
    const auto start = std::chrono::steady_clock::now();
    renderer.render_into(out, depth);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count());
  }
  return least;
}

double frame_time(const PressFolder& all, ReflectanceModel model) {
  gelight::CalibrationOptions options;
  options.model = model;
  const auto sensor = gelight::calibrate(all.background, all.presses, options).sensor;
  gelight::Camera<float> camera;
  camera.width = sensor.background.width();
  camera.height = sensor.background.height();
  camera.fx = camera.fy = 4000;
  camera.cx = static_cast<float>(camera.width) / 2;
  camera.cy = static_cast<float>(camera.height) / 2;
  gelight::FrameOptions every;
  every.skip_unchanged = false;
  const gelight::TactileRenderer renderer(camera, Image<float>(camera.width, camera.height, 1),
                                          gelight::GaussianMembrane<float>(5, 20),
                                          gelight::CalibratedReflectance<float>(sensor), every);
  const BallRenderer ball(sensor);
  return frame_time(renderer, ball.depth(all.presses[0].contact, all.presses[0].ball_radius));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "calibration_chart PHOTOGRAPHS OUT\n");
    return 2;
  }
  const std::string out = arguments[2];
  std::filesystem::create_directories(out);
  std::ofstream words(out + "/calibration.md");
  words
      << "# Calibration: error on photographs that were not fitted\n\nLevelled grey levels inside "
         "of the contact, five presses held out in turn, each fit to others.\n\n";
  Figure figure(1000, 420);
  Plot by_count(figure, {70, 50, 390, 300}, "presses that are enough (table)",
                {"presses fitted", 1, 20, true}, {"grey levels off, held out", 0, 15});
  Plot by_time(figure, {580, 50, 390, 300}, "error against time a frame",
               {"ms a frame, all pixels", 0, 6}, {"grey levels off, held out", 0, 15});
  const Colour colours[] = {blue, orange};
  int sensor_index = 0;
  for (const std::string name : {"gelsight_mini", "gelsight"}) {
    const PressFolder all = gelight::read_presses(std::string(arguments[1]) + "/" + name);
    const Colour colour = colours[sensor_index++];
    std::vector<gelight::Vec2<double>> points;
    words << "## " << name << "\n\n| presses | table |\n|---|---|\n";
    for (const std::size_t used : {1u, 3u, 5u, 10u, 20u}) {
      const double error = held_out_error(all, ReflectanceModel::table, used);
      points.emplace_back(static_cast<double>(used), error);
      words << "| " << used << " | " << std::round(100 * error) / 100 << " |\n";
    }
    const double best = points.back()[1];
    const auto enough = std::find_if(points.begin(), points.end(),
                                     [&](const auto& p) { return p[1] <= 1.1 * best; });
    by_count.curve(points, colour, name);
    by_count.dots(points, colour);
    words << "\n"
          << (*enough)[0] << " presses come within a tenth of twenty.\n\n"
          << "| model, 20 presses | grey levels | ms a frame |\n|---|---|---|\n";
    std::string chosen;
    double least = 1e9;
    for (const auto& [word, model] : {std::pair{"lights", ReflectanceModel::lights},
                                      std::pair{"polynomial", ReflectanceModel::polynomial},
                                      std::pair{"table", ReflectanceModel::table}}) {
      const double error = model == ReflectanceModel::table ? best : held_out_error(all, model, 20);
      const double time = frame_time(all, model);
      by_time.dots({{time, error}}, colour);
      by_time.label({time, error}, colour, std::string(word) + ", " + name);
      words << "| " << word << " | " << std::round(100 * error) / 100 << " | "
            << std::round(100 * time) / 100 << " |\n";
      if (error >= least) continue;
      least = error;
      chosen = word;
    }
    words << "\nThe model for this sensor: " << chosen << ".\n\n" << std::flush;
  }
  words << "Two photographs of one state of the GelSight Mini differ by 1.7: no model comes below."
           "\n";
  figure.save(out + "/calibration.png");
  return 0;
}
