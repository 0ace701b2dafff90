// Calibrating a sensor from ten presses.
//
//     (  )  a ball of known radius, pressed ten times, here and there
//    ~~\/~~ gel: inside the circle its slope is the ball's, outside it bulges
//      ^    what each slope looks like, at each place, is all that a renderer needs
//
// The sensor here is made up, so that the truth is known; for your own, put background.png, ten
// photographs and presses.csv into a folder and run
//     sh cmake/demo.sh calibrate --fit FOLDER --test FOLDER_OF_OTHERS --out OUT
// How many presses are enough is asked by leaving some out.

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "gelight/sensor/calibrate.hpp"
#include "support/lesson.hpp"
#include "support/plot.hpp"

using gelight::BallPress;
using gelight::Circle;
using gelight::Image;
using gelight::Rgb8;

namespace {

constexpr int width = 160, height = 120;
constexpr double ball = 30;

// Three near lights, red, green and blue, whose light the camera sees with some noise.
gelight::CalibratedSensor made_up() {
  gelight::LightsReflectance lights;
  lights.height = 1.0 * height / width;
  lights.lights = {{{1.5, 0.2, 0.9}, {1.1, 0.1, 0.1}, {0.1, 0.1, 0.1}},
                   {{-0.9, 1.2, 0.8}, {0.1, 1.0, 0.2}, {0.1, 0.1, 0.1}},
                   {{-0.8, -1.3, 1.0}, {0.2, 0.1, 1.2}, {0.1, 0.1, 0.1}}};
  return {Image<Rgb8>(width, height, {120, 110, 125}), lights, 9, {}};
}

BallPress press(const gelight::CalibratedSensor& sensor, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  std::normal_distribution<double> noise(0, 2);
  const Circle circle{30 + 100 * share(random), 28 + 64 * share(random), 17 + 5 * share(random)};
  const auto seen = gelight::predict(sensor, circle, ball);
  BallPress result{"made up", Image<Rgb8>(width, height), circle, ball};
  for (std::size_t i = 0; i < seen.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double level = std::clamp(seen.pixels()[i][c] + noise(random), 0.0, 255.0);
      result.photograph.pixels()[i][c] = static_cast<std::uint8_t>(std::lround(level));
    }
  }
  return result;
}

Image<Rgb8> rounded(const Image<gelight::Change>& image) {
  Image<Rgb8> out(image.width(), image.height());
  for (std::size_t i = 0; i < out.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      out.pixels()[i][c] =
          static_cast<std::uint8_t>(std::lround(std::clamp(image.pixels()[i][c], 0.0, 255.0)));
    }
  }
  return out;
}

}  // namespace

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "ten_presses");
  std::mt19937 random(1);
  gelight::CalibratedSensor truth = made_up();
  truth.background(0, 0) = {121, 111, 126};  // no photograph is of one colour only
  std::vector<BallPress> presses;
  for (int i = 0; i < 20; ++i) presses.push_back(press(truth, random));

  // Fit to the first so many, ask of a circle that none of them has.
  const Circle unseen{70, 55, 19};
  const auto expected = gelight::predict(truth, unseen, ball);
  std::vector<gelight::Vec2<double>> errors;
  Image<Rgb8> after_ten;
  for (const std::size_t used : {1u, 3u, 5u, 10u, 20u}) {
    const auto fit = gelight::calibrate(truth.background, std::span(presses).first(used));
    const auto ours = gelight::predict(fit.sensor, unseen, ball);
    double off = 0, pixels = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (std::hypot(x - unseen.x, y - unseen.y) > 0.9 * unseen.radius) continue;
        for (std::size_t c = 0; c < 3; ++c) off += std::abs(ours(x, y)[c] - expected(x, y)[c]);
        pixels += 3;
      }
    }
    errors.emplace_back(static_cast<double>(used), off / pixels);
    if (used == 10) after_ten = rounded(ours);
    std::printf("%2zu presses: %.2f grey levels off\n", used, off / pixels);
  }
  lesson.expect(errors[3][1] < 2, "ten presses come below two grey levels, the camera's noise");
  lesson.expect(errors[3][1] < 0.5 * errors[0][1], "one press does not tell what ten do");
  lesson.expect(errors[3][1] - errors[4][1] < 1, "twenty gain less than a grey level over ten");

  Figure figure(1120, 300);
  figure.image(presses[0].photograph, 20, 60, 1.25);
  figure.image(after_ten, 240, 60, 1.25);
  figure.image(rounded(expected), 460, 60, 1.25);
  figure.text("one of ten photographs", 120, 40, 14);
  figure.text("a press of none of them, ours", 340, 40, 14);
  figure.text("the same press, the truth", 560, 40, 14);
  Plot plot(figure, {760, 50, 330, 180}, "how many presses", {"presses", 1, 20, true},
            {"grey levels off", 0, 1.2 * errors[0][1]});
  plot.curve(errors, blue, "table");
  plot.dots(errors, blue);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
