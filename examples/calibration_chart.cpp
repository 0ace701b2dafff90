// How many presses are enough, and which model: calibration_chart PHOTOGRAPHS OUT.json [COMMIT]
//
// PHOTOGRAPHS holds gelsight_mini and gelsight, folders as gelight/io/presses.hpp reads them. Every
// third press is held out in turn; each fit is to others only. About two minutes on one core.
// benchmarks/plot/charts.py draws calibration.json.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
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
#include "support/plain_words.hpp"

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

struct Error {
  double mean = 0, spread = 0;  // over the presses held out
};

// Levelled grey levels inside of contacts that a fit to `used` other presses has not seen.
Error held_out_error(const PressFolder& all, ReflectanceModel model, std::size_t used) {
  std::vector<double> errors;
  for (std::size_t unseen = 0; unseen < all.presses.size(); unseen += 3) {
    std::vector<std::size_t> order(all.presses.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    order.erase(order.begin() + static_cast<std::ptrdiff_t>(unseen));
    std::mt19937 random(static_cast<unsigned>(unseen));
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
    errors.push_back(held_out(test, all.background, ours).levelled);
  }
  Error error;
  const auto count = static_cast<double>(errors.size());
  for (const double e : errors) error.mean += e / count;
  for (const double e : errors) error.spread += (e - error.mean) * (e - error.mean) / (count - 1);
  error.spread = std::sqrt(error.spread);
  return error;
}

// By how much untouched gel differs from the background, levelled: beyond 2.5 contact radii.
double untouched_difference(const PressFolder& all) {
  double mean = 0;
  for (const BallPress& press : all.presses) {
    const auto level = far_offset(press, all.background, press.photograph);
    double sum = 0, count = 0;
    for (int y = 0; y < press.photograph.height(); ++y) {
      for (int x = 0; x < press.photograph.width(); ++x) {
        const auto& [cx, cy, radius] = press.contact;
        if (std::hypot(x - cx, y - cy) <= 2.5 * radius) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          sum += std::abs(press.photograph(x, y)[c] - all.background(x, y)[c] - level[c]);
        }
        count += 3;
      }
    }
    mean += sum / count / static_cast<double>(all.presses.size());
  }
  return mean;
}

// Milliseconds of this process's time for a frame of which every pixel is computed, calibrated and
// by Phong's equation with three lights: the least of each, in turn.
struct FrameTimes {
  double calibrated = 1e9, phong = 1e9;
};

FrameTimes frame_times(const PressFolder& all, ReflectanceModel model) {
  gelight::CalibrationOptions options;
  options.model = model;
  const auto sensor = gelight::calibrate(all.background, all.presses, options).sensor;
  gelight::Camera<float> camera;
  camera.width = sensor.background.width();
  camera.height = sensor.background.height();
  camera.fx = camera.fy = 4000;
  camera.cx = static_cast<float>(camera.width) / 2;
  camera.cy = static_cast<float>(camera.height) / 2;
  const Image<float> rest(camera.width, camera.height, 1);
  gelight::FrameOptions every;
  every.skip_unchanged = false;
  const gelight::TactileRenderer calibrated(camera, rest, gelight::GaussianMembrane<float>(5, 20),
                                            gelight::CalibratedReflectance<float>(sensor), every);
  std::vector<gelight::Light<float>> lights(3);
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const float angle = 2.0944F * static_cast<float>(k);
    lights[k].direction = Image<gelight::Vec3<float>>(
        camera.width, camera.height, gelight::Vec3<float>(std::cos(angle), std::sin(angle), 0));
    lights[k].rgb[k] = 1;
  }
  gelight::TactileOptions everything;
  everything.skip_unchanged = false;
  const gelight::TactileRenderer<float> phong(camera, rest, lights, {}, everything);
  const BallRenderer ball(sensor);
  const auto depth = ball.depth(all.presses[0].contact, all.presses[0].ball_radius);
  Image<gelight::Rgb8> out(camera.width, camera.height);
  const auto least = [&](double& time, const auto& renderer) {
    const std::clock_t start = std::clock();
    renderer.render_into(out, depth);
    const auto took = static_cast<double>(std::clock() - start);
    time = std::min(time, 1e3 * took / CLOCKS_PER_SEC);
  };
  FrameTimes times;
  for (int i = 0; i < 100; ++i) {
    least(times.calibrated, calibrated);
    least(times.phong, phong);
  }
  return times;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count != 3 && count != 4) {
    std::fprintf(stderr, "calibration_chart PHOTOGRAPHS OUT.json [COMMIT]\n");
    return 2;
  }
  require_writable(arguments[2]);
  const std::array<std::string, 2> names{"gelsight_mini", "gelsight"};
  std::vector<PressFolder> folders;
  for (const std::string& name : names) {
    folders.push_back(gelight::read_presses(std::string(arguments[1]) + "/" + name));
  }
  const std::time_t now = std::time(nullptr);
  std::array<char, 40> date{};
  std::strftime(date.data(), date.size(), "%Y-%m-%d", std::gmtime(&now));
  std::ofstream out(arguments[2]);
  out << "{\n \"context\": {\"date\": \"" << date.data() << "\", \"commit\": \""
      << (count > 3 ? arguments[3] : "unknown") << "\", \"compiler\": \"g++ " << __VERSION__
      << "\"},\n \"benchmarks\": [";
  const char* separator = "\n";
  const auto write = [&](const std::string& name, const Error& error, const std::string& more) {
    out << separator << "  {\"name\": \"calibration/" << name << "\", \"error\": " << error.mean
        << ", \"spread\": " << error.spread << more << "}" << std::flush;
    separator = ",\n";
    std::printf("%s: %.2f grey levels%s\n", name.c_str(), error.mean, more.c_str());
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    const PressFolder& all = folders[i];
    write(name + "/untouched", {untouched_difference(all), 0}, "");
    for (const auto& [word, model] : {std::pair{"table", ReflectanceModel::table},
                                      std::pair{"polynomial", ReflectanceModel::polynomial},
                                      std::pair{"lights", ReflectanceModel::lights}}) {
      for (const std::size_t used : {1u, 3u, 5u, 10u, 20u}) {
        const bool is_last = used == 20;
        if (!is_last && model != ReflectanceModel::table) continue;
        std::string time;
        if (is_last) {
          const FrameTimes frame = frame_times(all, model);
          time = ", \"frame_ms\": " + std::to_string(frame.calibrated) +
                 ", \"phong_frame_ms\": " + std::to_string(frame.phong);
        }
        write(name + "/" + word + "/" + std::to_string(used), held_out_error(all, model, used),
              time);
      }
    }
  }
  out << "\n ]\n}\n";
  out.flush();
  return out.good() ? 0 : 1;
} catch (...) {
  return told();
}
