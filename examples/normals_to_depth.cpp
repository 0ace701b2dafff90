// Normals back to depth: what shading tells of a surface, added up.
//
//      /|\  /  __ \ /|\      A tactile image tells which way the gel faces at each pixel, not how
//       | _/  /  \ \_|       far away it is. A normal n says how the depth changes from a pixel to
//     --'`---'    `--'--     the next: along the surface n . dP = 0, and with P = z ray that is a
//                            slope of log z. Walking along a row adds up its errors; least squares
//     over all neighbours at once, a Poisson equation, spreads them. One depth has to be known:
//     twice as far and twice as large, everything looks the same.

#include <Eigen/SparseCholesky>
#include <cmath>
#include <random>
#include <vector>

#include "gelight/image/camera.hpp"
#include "gelight/image/normals.hpp"
#include "support/lesson.hpp"
#include "support/relief.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Vec2;
using gelight::Vec3;

constexpr Index width = 160, height = 120;

// By how much log z grows from a pixel to the next, right and down: n . d(z ray) = 0.
Vec2<double> slope(const Vec3<double>& n, const gelight::Camera<double>& camera, Index u, Index v) {
  const double towards = n.dot(camera.ray(u, v));
  return {-n[0] / camera.fx / towards, -n[1] / camera.fy / towards};
}

// The depth whose steps between neighbours come nearest to what the normals say of them.
Image<double> from_normals(const Image<Vec3<double>>& normals,
                           const gelight::Camera<double>& camera, double depth_of_first) {
  const auto at = [](Index u, Index v) { return v * width + u; };
  std::vector<Eigen::Triplet<double>> laplacian{{0, 0, 1.0}};  // holds the first pixel
  Eigen::VectorXd divergence = Eigen::VectorXd::Zero(width * height);
  for (Index v = 0; v < height; ++v) {
    for (Index u = 0; u < width; ++u) {
      for (const int axis : {0, 1}) {
        const Index u1 = u + 1 - axis, v1 = v + axis;
        if (u1 == width || v1 == height) continue;
        const double step = 0.5 * (slope(normals(u, v), camera, u, v)[axis] +
                                   slope(normals(u1, v1), camera, u1, v1)[axis]);
        const Index a = at(u, v), b = at(u1, v1);
        laplacian.insert(laplacian.end(), {{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}});
        divergence[a] -= step;
        divergence[b] += step;
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(width * height, width * height);
  matrix.setFromTriplets(laplacian.begin(), laplacian.end());
  const Eigen::VectorXd logs =
      Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(divergence);
  Image<double> depth(width, height);
  for (Index i = 0; i < width * height; ++i) {
    depth(i % width, i / width) = depth_of_first * std::exp(logs[i] - logs[0]);
  }
  return depth;
}

// The same by walking: down the first column, then along each row.
Image<double> by_walking(const Image<Vec3<double>>& normals, const gelight::Camera<double>& camera,
                         double depth_of_first) {
  Image<double> depth(width, height, depth_of_first);
  for (Index v = 0; v < height; ++v) {
    if (v > 0)
      depth(0, v) = depth(0, v - 1) * std::exp(slope(normals(0, v - 1), camera, 0, v - 1)[1]);
    for (Index u = 1; u < width; ++u) {
      depth(u, v) = depth(u - 1, v) * std::exp(slope(normals(u - 1, v), camera, u - 1, v)[0]);
    }
  }
  return depth;
}

double rms(const Image<double>& a, const Image<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i)
    sum += std::pow(a.pixels()[i] - b.pixels()[i], 2);
  return std::sqrt(sum / static_cast<double>(a.pixels().size()));
}

int main(int count, char** arguments) {
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
  const double clean = rms(from_normals(normals, camera, depth(0, 0)), depth);
  lesson.expect(clean < 5e-6,
                "true normals give back the depth, to five thousandths of a millimetre");

  // What is read off an image is not true: each normal tilts by some 3 degrees at random.
  auto noisy = normals;
  std::mt19937 random(1);
  std::normal_distribution<double> tilt(0, 0.04);
  for (auto& n : noisy.pixels()) n = (n + Vec3<double>(tilt(random), tilt(random), 0)).normalized();
  const auto walked = by_walking(noisy, camera, depth(0, 0));
  const auto fitted = from_normals(noisy, camera, depth(0, 0));
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
}
