// Phong term by term: what makes up the colour of a pixel.
//
//       N    R             ambient    a share of what is seen without the sensor's own light
//     L  \   |  / V        diffuse    how squarely the light L meets the surface: N.L
//      \  \  | /           specular   how nearly its mirror image R runs to the eye V: (R.V)^n
//       \  \ |/
//     ___\__\/_____        A pixel is their sum, for every light; N, L, R and V have unit length.

#include <cmath>
#include <vector>

#include "gelight/image/camera.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "support/figure.hpp"
#include "support/lesson.hpp"

using gelight::Image;
using gelight::Index;
using gelight::Rgb8;
using gelight::Vec3;

int main(int count, char** arguments) try {
  Lesson lesson(count, arguments, "phong_terms");

  // Flat gel 30 mm before the camera, a ball of 6 mm radius pressed in 4 mm deep, no smoothing.
  const auto camera = gelight::Camera<double>::from_vertical_fov(0.5, 240, 240);
  const double rest = 0.030, radius = 0.006;
  const Vec3<double> centre(0, 0, rest - 0.004 + radius);
  const Image<double> gel(240, 240, rest);
  Image<double> depth = gel, ball = gel;
  for (Index v = 0; v < 240; ++v) {
    for (Index u = 0; u < 240; ++u) {
      // Where the pixel's ray meets the ball: |depth ray - centre| = radius.
      const Vec3<double> ray = camera.ray(u, v);
      const double a = ray.squaredNorm(), b = ray.dot(centre);
      const double root = b * b - a * (centre.squaredNorm() - radius * radius);
      ball(u, v) = (b - std::sqrt(std::max(0.0, root))) / a;
      if (root > 0) depth(u, v) = std::min(rest, ball(u, v));
    }
  }

  // Light from the left, on its way to the right and into the gel.
  const Vec3<double> travel = Vec3<double>(1, 0.3, 0.6).normalized();
  const auto rendered = [&](double ambient, double diffuse, double specular) {
    const gelight::Light<double> light{.direction = Image<Vec3<double>>(240, 240, travel),
                                       .diffuse = diffuse,
                                       .specular = specular,
                                       .shininess = 20};
    const gelight::Background<double> background(std::array{0.6, 0.7, 0.85});
    const gelight::TactileOptions options{.smoothing_sigma = 0,
                                          .ambient = ambient,
                                          .border_normals = gelight::BorderNormals::extrapolated};
    const gelight::TactileRenderer<double> renderer(camera, gel, {light}, background, options);
    // Normals are differences of depth, and one across the ball's outline is neither surface's:
    // ball and gel are rendered each by itself, and a pixel shows the nearer.
    Image<Rgb8> nearer = renderer.render(gel);
    const Image<Rgb8> of_ball = renderer.render(ball);
    for (Index v = 0; v < 240; ++v) {
      for (Index u = 0; u < 240; ++u) {
        if (depth(u, v) < rest) nearer(u, v) = of_ball(u, v);
      }
    }
    return nearer;
  };
  const std::array<std::pair<const char*, Image<Rgb8>>, 4> panels{
      {{"ambient", rendered(0.5, 0, 0)},
       {"+ diffuse", rendered(0, 0.6, 0)},
       {"+ specular", rendered(0, 0, 0.5)},
       {"= Phong", rendered(0.5, 0.6, 0.5)}}};

  double at_outline = 0;  // the highlight's light on the pixels about the ball's outline
  for (Index v = 1; v < 239; ++v) {
    for (Index u = 1; u < 239; ++u) {
      const bool is_rim = depth(u, v) < rest && depth(u, v) > rest - 0.001;
      if (is_rim) at_outline = std::max<double>(at_outline, panels[2].second(u, v)[0]);
    }
  }
  lesson.expect(at_outline < 3, "no highlight on the ball's outline, far from the bright spot");

  // Each term loses less than one step of 255 when it is rounded down.
  int unlike_sum = 0;
  double unlike_formula = 0;
  for (Index v = 1; v < 239; ++v) {
    for (Index u = 1; u < 239; ++u) {
      int sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += panels[k].second(u, v)[0];
      const int all = panels[3].second(u, v)[0];
      unlike_sum = std::max(unlike_sum, std::abs(all - std::min(sum, 255)));
      // On the ball, away from its rim, the normal is known.
      const Vec3<double> point = camera.unproject(u, v, depth(u, v));
      const Vec3<double> normal = (point - centre).normalized();
      if (depth(u, v) > rest - 0.001) continue;
      const double facing = normal.dot(-travel);
      const double diffuse = 255 * 0.6 * std::max(0.0, facing);
      const Vec3<double> mirrored = 2 * facing * normal + travel, to_eye = -point.normalized();
      const double specular =
          facing > 0 ? 255 * 0.5 * std::pow(std::max(0.0, mirrored.dot(to_eye)), 20) : 0;
      unlike_formula = std::max({unlike_formula, std::abs(panels[1].second(u, v)[0] - diffuse),
                                 std::abs(panels[2].second(u, v)[0] - specular)});
    }
  }
  lesson.expect(unlike_sum <= 3, "the pixel is the sum of the terms");
  lesson.expect(unlike_formula < 3,
                "on the ball the terms are as Phong's equation has them, to 3 of 255");

  // Below each image how bright it is along its middle row.
  Figure figure(1020, 420);
  double x = 12;
  const std::array<Colour, 4> inks{blue, green, red, black};
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const auto& [name, image] = panels[k];
    figure.image(image, x, 40);
    figure.pen(black, 1);
    figure.text(name, x + 120, 20, 17);
    figure.pen(grey, 1);
    figure.line(x, 400, x + 240, 400);
    figure.pen(inks[k], 2.5);
    std::vector<gelight::Vec2<double>> row;
    for (Index u = 0; u < 240; ++u) {
      row.emplace_back(x + u, 400 - 100.0 / 255 * image(u, 106)[0]);
    }
    figure.polyline(row);
    x += 252;
  }
  figure.pen(black, 1);
  figure.text_from("red along the bright spot's row, 0 to 255", 14, 306, 12);
  figure.save(lesson.picture());
  return lesson.result();
} catch (...) {
  return told();
}
