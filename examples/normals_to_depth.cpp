// Normals back to depth: what shading tells of a surface, added up.
//
//      /|\  /  __ \ /|\      A tactile image tells which way the gel faces at each pixel, not how
//       | _/  /  \ \_|       far away it is. A normal n says how the depth changes from a pixel to
//     --'`---'    `--'--     the next: along the surface n . dP = 0, and with P = z ray that is a
//                            slope of log z. Walking along a row adds up its errors; least squares
//     over all neighbours at once, a Poisson equation, spreads them. One depth has to be known:
//     twice as far and twice as large, everything looks the same.

#include <cmath>
#include <random>

#include "gelight/image/camera.hpp"
#include "gelight/image/normals.hpp"
#include "support/lesson.hpp"
#include "support/relief.hpp"
#include "support/steps.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Vec2;
using gelight::Vec3;

constexpr Index width = 160, height = 120;

// By how much log z grows from each pixel to the next, right and down: n . d(z ray) = 0.
Image<Vec2<double>> slopes(const Image<Vec3<double>>& normals,
                           const gelight::Camera<double>& camera) {
  Image<Vec2<double>> result(width, height);
  for (Index v = 0; v < height; ++v) {
    for (Index u = 0; u < width; ++u) {
      const Vec3<double>& n = normals(u, v);
      const double towards = n.dot(camera.ray(u, v));
      result(u, v) = {-n[0] / camera.fx / towards, -n[1] / camera.fy / towards};
    }
  }
  return result;
}

// A depth from its logarithm, of which the first pixel's is known.
Image<double> depth_of(Image<double> logarithm, double first) {
  for (double& z : logarithm.pixels()) z = first * std::exp(z);
  return logarithm;
}

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "normals_to_depth");

  // Gel 30 mm away with two dents of a millimetre, 0.1 mm to the pixel.
  const gelight::Camera<double> camera{300, 300, 79.5, 59.5, width, height};
  Image<double> depth(width, height), farther(width, height);
  for (Index v = 0; v < height; ++v) {
    for (Index u = 0; u < width; ++u) {
      const auto dent = [&](double x, double y, double s) {
        return 1e-3 * std::exp(-(std::pow(u - x, 2) + std::pow(v - y, 2)) / (2 * s * s));
      };
      depth(u, v) = 0.030 - dent(60, 60, 16) - dent(115, 50, 9);
      farther(u, v) = 2 * depth(u, v);
    }
  }
  const auto border = gelight::BorderNormals::extrapolated;
  const auto normals = gelight::sobel_normals(depth, camera, border);
  const auto normals_farther = gelight::sobel_normals(farther, camera, border);
  double unlike = 0;
  for (std::size_t i = 0; i < normals.pixels().size(); ++i) {
    unlike = std::max(unlike, (normals.pixels()[i] - normals_farther.pixels()[i]).norm());
  }
  lesson.expect(unlike < 1e-9, "twice as far and twice as large has the same normals");
  const double clean = rms(depth_of(from_slopes(slopes(normals, camera)), depth(0, 0)), depth);
  lesson.expect(clean < 5e-6,
                "true normals give back the depth, to five thousandths of a millimetre");

  // What is read off an image is not true: each normal tilts by some 3 degrees at random.
  auto noisy = normals;
  std::mt19937 random(1);
  std::normal_distribution<double> tilt(0, 0.04);
  for (auto& n : noisy.pixels()) n = (n + Vec3<double>(tilt(random), tilt(random), 0)).normalized();
  const auto tilted = slopes(noisy, camera);
  const auto walked = depth_of(walked_along(tilted), depth(0, 0));
  const auto fitted = depth_of(from_slopes(tilted), depth(0, 0));
  std::printf("Off by %.4f mm (true normals), %.4f mm (fitted), %.4f mm (walked)\n", 1e3 * clean,
              1e3 * rms(fitted, depth), 1e3 * rms(walked, depth));
  lesson.expect(rms(fitted, depth) < 1.5e-5,
                "tilted ones, fitted to all neighbours, to a hundredth and a half");
  lesson.expect(rms(walked, depth) > 2.5 * rms(fitted, depth),
                "walking along rows is off several times as far");

  Figure figure(1020, 330);
  const auto panel = [&](double x, const Image<gelight::Rgb8>& image, const std::string& name) {
    figure.image(image, x, 50, 2);
    figure.pen(black, 1);
    figure.text(name, x + 160, 26, 16);
  };
  panel(15, normal_colours(noisy, 2), "Given: noisy normals");
  panel(350, depth_bands(walked, 0.0290, 0.0301), "Depth, walked row by row");
  panel(685, depth_bands(fitted, 0.0290, 0.0301), "Depth, fitted to all neighbours");
  figure.text("Two dents in flat gel. Dark: nearer to the camera.", 510, 312, 14);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
