#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "gelight/image/similarity.hpp"
#include "gelight/membrane/tension.hpp"
#include "gelight/sensor/calibrate.hpp"
#include "gelight/sensor/tactile_renderer.hpp"

// How far a calibrated sensor's images are from photographs that it was not fitted to.

/// Renders presses of a ball: the camera looks at flat gel from so far that its rays are nearly
/// parallel.
class BallRenderer {
 public:
  explicit BallRenderer(const gelight::CalibratedSensor& sensor)
      : length_(sensor.bulge_length),
        camera_(camera_of(sensor)),
        renderer_(camera_, gelight::Image<float>(camera_.width, camera_.height, 1),
                  gelight::TensionMembrane<float>(sensor.bulge_length),
                  gelight::CalibratedReflectance<float>(sensor)) {}

  /// The depth of the ball where the gel, pressed in, touches it in just that circle.
  [[nodiscard]] gelight::Image<float> depth(const gelight::Circle& circle, double ball) const {
    const double cap = std::sqrt(ball * ball - circle.radius * circle.radius);
    const double deep = ball - cap + gelight::rim_height(circle.radius, ball, length_);
    gelight::Image<float> out(camera_.width, camera_.height,
                              std::numeric_limits<float>::infinity());
    for (int y = 0; y < out.height(); ++y) {
      for (int x = 0; x < out.width(); ++x) {
        const double dx = x - circle.x, dy = y - circle.y, rest = ball * ball - dx * dx - dy * dy;
        if (rest <= 0) continue;
        out(x, y) = static_cast<float>(1 - (deep - ball + std::sqrt(rest)) / double{camera_.fx});
      }
    }
    return out;
  }

  [[nodiscard]] gelight::Image<gelight::Rgb8> operator()(const gelight::BallPress& press) const {
    return renderer_.render(depth(press.contact, press.ball_radius));
  }

 private:
  [[nodiscard]] static gelight::Camera<float> camera_of(const gelight::CalibratedSensor& sensor) {
    gelight::Camera<float> camera;
    camera.width = sensor.background.width();
    camera.height = sensor.background.height();
    camera.fx = camera.fy = 4000;
    camera.cx = static_cast<float>(camera.width - 1) / 2;
    camera.cy = static_cast<float>(camera.height - 1) / 2;
    return camera;
  }

  double length_;
  gelight::Camera<float> camera_;
  gelight::TactileRenderer<float, gelight::TensionMembrane<float>,
                           gelight::CalibratedReflectance<float>>
      renderer_;
};

/// Throws InvalidInput, naming the press, unless a sensor with that background can be compared with
/// each: of its size, with a circle of the ball's.
inline void require_comparable(const gelight::Image<gelight::Rgb8>& untouched,
                               const std::vector<gelight::BallPress>& tests,
                               const gelight::Image<gelight::Rgb8>& background) {
  gelight::detail::require(!tests.empty(), "no presses to compare with");
  gelight::detail::require(
      untouched.width() == background.width() && untouched.height() == background.height(),
      "the background to compare with has ", untouched.width(), " x ", untouched.height(),
      " pixels, the sensor's ", background.width(), " x ", background.height());
  for (const gelight::BallPress& test : tests) {
    gelight::detail::require_press(test, background);
    gelight::detail::require(!gelight::detail::has_no_circle(test), test.name,
                             " has no circle: it cannot be compared with");
  }
}

/// An image so many grey levels brighter.
[[nodiscard]] inline gelight::Image<gelight::Rgb8> with_level(gelight::Image<gelight::Rgb8> image,
                                                              const std::array<double, 3>& level) {
  for (gelight::Rgb8& pixel : image.pixels()) {
    for (std::size_t c = 0; c < 3; ++c) {
      pixel[c] = static_cast<std::uint8_t>(std::clamp(std::lround(pixel[c] + level[c]), 0L, 255L));
    }
  }
  return image;
}

/// Mean absolute differences in grey levels: within 0.9 of the contact's radius and over the whole
/// image; levelled: less each image's mean offset from the background beyond 2.5 radii.
struct HeldOut {
  double signal = 0, inside = 0, levelled = 0, whole = 0, ssim = 0, whole_as_it_is = 0,
         ssim_as_it_is = 0;

  void add(const HeldOut& o) {
    signal += o.signal;
    inside += o.inside;
    levelled += o.levelled;
    whole += o.whole;
    ssim += o.ssim;
    whole_as_it_is += o.whole_as_it_is;
    ssim_as_it_is += o.ssim_as_it_is;
  }
  void divide(double by) {
    for (double* value :
         {&signal, &inside, &levelled, &whole, &ssim, &whole_as_it_is, &ssim_as_it_is}) {
      *value /= by;
    }
  }
};

[[nodiscard]] inline std::array<double, 3> far_offset(
    const gelight::BallPress& press, const gelight::Image<gelight::Rgb8>& background,
    const gelight::Image<gelight::Rgb8>& image) {
  std::array<double, 3> sum{};
  double count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const auto& [cx, cy, radius] = press.contact;
      if (std::hypot(x - cx, y - cy) <= 2.5 * radius) continue;
      ++count;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += image(x, y)[c] - background(x, y)[c];
    }
  }
  for (double& value : sum) value /= std::max(1.0, count);
  return sum;
}

[[nodiscard]] inline HeldOut held_out(const gelight::BallPress& press,
                                      const gelight::Image<gelight::Rgb8>& background,
                                      const gelight::Image<gelight::Rgb8>& ours) {
  HeldOut mean;
  const auto of_photograph = far_offset(press, background, press.photograph);
  const auto of_ours = far_offset(press, background, ours);
  gelight::Image<gelight::Rgb8> photograph = press.photograph, levelled = ours;
  double inside = 0;
  for (int y = 0; y < ours.height(); ++y) {
    for (int x = 0; x < ours.width(); ++x) {
      const bool is_inside =
          std::hypot(x - press.contact.x, y - press.contact.y) <= 0.9 * press.contact.radius;
      for (std::size_t c = 0; c < 3; ++c) {
        const double off = press.photograph(x, y)[c] - ours(x, y)[c];
        const double off_levelled = off - of_photograph[c] + of_ours[c];
        mean.whole_as_it_is += std::abs(off);
        mean.whole += std::abs(off_levelled);
        if (!is_inside) continue;
        ++inside;
        mean.signal += std::abs(press.photograph(x, y)[c] - background(x, y)[c]);
        mean.inside += std::abs(off);
        mean.levelled += std::abs(off_levelled);
      }
    }
  }
  const auto all = 3.0 * static_cast<double>(ours.pixels().size());
  mean.whole_as_it_is /= all;
  mean.whole /= all;
  for (double* value : {&mean.signal, &mean.inside, &mean.levelled})
    *value /= std::max(1.0, inside);
  const auto less = [](const std::array<double, 3>& level) {
    return std::array<double, 3>{-level[0], -level[1], -level[2]};
  };
  mean.ssim_as_it_is = gelight::ssim(press.photograph, ours);
  mean.ssim = gelight::ssim(with_level(photograph, less(of_photograph)),
                            with_level(levelled, less(of_ours)));
  return mean;
}
