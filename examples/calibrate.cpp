// A sensor of one's own: from photographs of a ball pressed into it to its simulation.
//
//     background.png  presses.csv        o  <- the ball, at a known place
//       photographs, circles         ~~~~_~~~~   the gel bulges around it
//              |
//        calibrate()  ->  sensor file  ->  TactileRenderer  ->  photographs it has not seen
//
// sh cmake/demo.sh calibrate --fit DIR --test DIR --out DIR

#include "gelight/sensor/calibrate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "gelight/image/similarity.hpp"
#include "gelight/io/presses.hpp"
#include "gelight/membrane/tension.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/calibration_measure.hpp"
#include "support/command_line.hpp"
#include "support/figure.hpp"

using gelight::BallPress;
using gelight::CalibratedSensor;
using gelight::Calibration;
using gelight::Image;
using gelight::PressFolder;
using gelight::ReflectanceModel;
using gelight::Rgb8;

namespace {

void tell(const Calibration& fit, double seconds) {
  std::printf("  fitted in %.2f s; bulge %.1f +- %.1f pixels; smoothness %g, in the place %g\n",
              seconds, fit.sensor.bulge_length, fit.bulge_doubt, fit.smoothness.normal,
              fit.smoothness.place);
  std::printf("  level of the photographs (red, green, blue): %.1f %.1f %.1f\n",
              fit.sensor.level[0], fit.sensor.level[1], fit.sensor.level[2]);
  for (const auto& region : fit.regions) {
    std::printf("  %-6s signal %5.2f, left %5.2f grey levels\n", region.region.c_str(),
                region.signal, region.residual);
  }
  for (const auto& press : fit.presses) {
    std::printf("  %s: level %.1f %.1f %.1f, centre (%.1f +- %.1f, %.1f +- %.1f), left %.2f\n",
                press.name.c_str(), press.level[0], press.level[1], press.level[2], press.contact.x,
                press.doubt.x(), press.contact.y, press.doubt.y(), press.residual);
  }
  if (!fit.spread.empty()) {
    std::vector<double> spread = fit.spread;
    std::nth_element(spread.begin(), spread.begin() + std::ssize(spread) / 2, spread.end());
    std::printf("  spread of the coefficients when presses are left out: median %.4f\n",
                spread[spread.size() / 2]);
  }
  for (const std::string& warning : fit.warnings) std::printf("  warning: %s\n", warning.c_str());
}

// Photograph, ours and their difference about grey, a press a row.
void draw(const std::string& path, const std::vector<BallPress>& tests,
          const std::vector<Image<Rgb8>>& ours) {
  const int columns = 3;
  const auto width = tests[0].photograph.width(), height = tests[0].photograph.height();
  const double scale = 150.0 / width, cell = 150, high = height * scale, gap = 6;
  const int across = columns * 3;
  const auto rows = (static_cast<int>(tests.size()) + columns - 1) / columns;
  Figure figure(static_cast<int>(across * (cell + gap) + gap),
                static_cast<int>(rows * (high + gap) + 34));
  const char* const names[] = {"photograph", "ours", "difference"};
  for (int c = 0; c < across; ++c) {
    figure.text(names[c % 3], gap + (c + 0.5) * (cell + gap), 16, 14);
  }
  for (std::size_t i = 0; i < tests.size(); ++i) {
    Image<Rgb8> difference(width, height);
    for (std::size_t k = 0; k < difference.pixels().size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        const int off = tests[i].photograph.pixels()[k][c] - ours[i].pixels()[k][c];
        difference.pixels()[k][c] = static_cast<std::uint8_t>(std::clamp(128 + 2 * off, 0, 255));
      }
    }
    const double x = gap + static_cast<double>(i % columns) * 3 * (cell + gap);
    const double y = 28 + static_cast<double>(i / columns) * (high + gap);
    figure.image(tests[i].photograph, x, y, scale);
    figure.image(ours[i], x + cell + gap, y, scale);
    figure.image(difference, x + 2 * (cell + gap), y, scale);
  }
  figure.save(path);
}

int run(const std::string& fit_folder, const std::string& test_folder, const std::string& out) {
  const PressFolder known = gelight::read_presses(fit_folder);
  const PressFolder tests = gelight::read_presses(test_folder);
  require_comparable(tests.background, tests.presses, known.background);
  make_folder(out);
  std::vector<std::string> lines;
  const struct {
    const char* name;
    ReflectanceModel model;
  } models[] = {{"lights", ReflectanceModel::lights},
                {"polynomial", ReflectanceModel::polynomial},
                {"table", ReflectanceModel::table}};
  for (const auto& [name, model] : models) {
    std::printf("%s\n", name);
    const auto start = std::chrono::steady_clock::now();
    gelight::CalibrationOptions options;
    options.model = model;
    const Calibration fit = gelight::calibrate(known.background, known.presses, options);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    tell(fit, seconds.count());
    const std::string path = out + "/" + name + ".sensor";
    gelight::write_sensor(path, fit.sensor);
    const CalibratedSensor sensor = gelight::read_sensor(path);
    const BallRenderer render(sensor);
    std::vector<Image<Rgb8>> pictures;
    HeldOut mean;
    for (const BallPress& test : tests.presses) {
      pictures.push_back(with_level(render(test), sensor.level));
      mean.add(held_out(test, tests.background, pictures.back()));
    }
    mean.divide(static_cast<double>(tests.presses.size()));
    draw(out + "/" + name + ".png", tests.presses, pictures);
    char line[256];
    std::snprintf(line, sizeof line,
                  "model: %s (whole image as it is: MAE %.2f, SSIM %.3f; below levelled)", name,
                  mean.whole_as_it_is, mean.ssim_as_it_is);
    lines.emplace_back(line);
    std::snprintf(line, sizeof line, "inside the contact: %.2f of %.2f grey levels, levelled %.2f",
                  mean.inside, mean.signal, mean.levelled);
    lines.emplace_back(line);
    std::snprintf(line, sizeof line, "whole image: MAE %.2f, SSIM %.3f", mean.whole, mean.ssim);
    lines.emplace_back(line);
  }
  std::printf("\nThe sensor, %s/table.sensor, and contact sheets are in %s.\n", out.c_str(),
              out.c_str());
  for (const std::string& line : lines) std::printf("%s\n", line.c_str());
  return 0;
}

}  // namespace

int main(int count, char** arguments) try {
  CommandLine line("Fits a sensor to photographs of ball presses and renders others");
  std::string fit, test, out = "out";
  line.add_required("--fit", fit, "folder of background.png, presses.csv and photographs");
  line.add_required("--test", test, "the same, of presses to compare with; none is fitted");
  line.add("--out", out, "folder for the sensor and the contact sheets");
  line.read(count, arguments);
  return run(fit, test, out);
} catch (...) {
  return told();
}
