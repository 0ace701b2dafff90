#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "gelight/image/camera.hpp"
#include "gelight/image/fast_gaussian.hpp"
#include "gelight/image/filter.hpp"
#include "gelight/image/normals.hpp"
#include "gelight/image/smooth.hpp"
#include "gelight/sensor/tactile_renderer.hpp"
#include "gelight/shading/phong.hpp"
#include "gelight/views/image_view.hpp"
#include "stress/stress.hpp"

// The lines of the catalogue on images.

namespace gelight::stress {

namespace {

constexpr Index width = 40, height = 30;

template <class T>
Camera<T> camera() {
  return {30, 31, T(19.5), T(14.5), width, height};
}

template <class T>
Image<T> rest_depth() {
  Image<T> rest(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) rest(x, y) = T(0.03) + T(1e-5) * static_cast<T>(x - y);
  }
  return rest;
}

template <class T>
Image<T> pressed() {
  Image<T> depth = rest_depth<T>();
  for (Index y = 10; y < 20; ++y) {
    for (Index x = 12; x < 25; ++x) depth(x, y) -= T(0.001);
  }
  return depth;
}

template <class T>
std::vector<Light<T>> lights() {
  const Vec3<T> across = Vec3<T>(1, T(0.2), T(0.1)).normalized();
  const Vec3<T> down = Vec3<T>(T(-0.3), 1, T(0.4)).normalized();
  return {{Image<Vec3<T>>(width, height, across), {1, T(0.3), 0}},
          {Image<Vec3<T>>(width, height, down), {0, T(0.4), 1}, T(0.5), T(0.3), 7}};
}

// Runs a check with images of float or of double.
template <class Check>
auto both(Check check) {
  return [check](Findings& findings, Precision precision) {
    if (precision == Precision::in_float) {
      check(findings, float{});
    } else {
      check(findings, double{});
    }
  };
}

template <class T>
Image<T> waves(Index w, Index h) {
  Image<T> image(w, h);
  for (Index y = 0; y < h; ++y) {
    for (Index x = 0; x < w; ++x) {
      image(x, y) = static_cast<T>(std::sin(0.7 * x) + std::cos(1.3 * y + 0.2 * x));
    }
  }
  return image;
}

constexpr auto unknown_depths = []<class T>(Findings& findings, T) {
  const T not_a_number = std::numeric_limits<T>::quiet_NaN(),
          infinite = std::numeric_limits<T>::infinity();
  Image<T> image = waves<T>(width, height);
  image(5, 6) = not_a_number;
  image(20, 9) = infinite;
  const auto mean = gaussian_of_known(image, 2, 8);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const bool is_known = std::isfinite(image(x, y));
      findings.expect(is_known ? std::fabs(mean(x, y)) <= T(2.01) : !std::isfinite(mean(x, y)),
                      "an unknown pixel spreads, or becomes known");
    }
  }
  const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), lights<T>());
  for (const T bad : {not_a_number, infinite, -infinite, T(0), T(-1)}) {
    Image<T> depth = rest_depth<T>();
    depth(20, 15) = bad;
    const auto image_there = renderer.render(depth);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        if (std::abs(x - 20) <= 1 && std::abs(y - 15) <= 1) continue;
        findings.expect(image_there(x, y) == renderer.rest_image()(x, y),
                        "an unknown depth is seen beside its pixel");
      }
    }
  }
};

constexpr auto no_contact = []<class T>(Findings& findings, T) {
  for (const bool skip : {true, false}) {
    TactileOptions options;
    options.skip_unchanged = skip;
    const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), lights<T>(), {}, options);
    findings.expect(renderer.render(rest_depth<T>()) == renderer.rest_image(),
                    "the frame at rest is not the image at rest");
    Image<T> farther = rest_depth<T>();
    for (T& z : farther.pixels()) z += T(0.01);
    findings.expect(renderer.render(farther) == renderer.rest_image(),
                    "what does not touch changes the image");
  }
  const TactileRenderer<T> dark(camera<T>(), rest_depth<T>(), {}, Background<T>{},
                                TactileOptions{.ambient = 1});
  const auto image = dark.rest_image();
  findings.expect(dark.render(pressed<T>()) == image, "without lights a contact is seen");
};

constexpr auto tiny_images = []<class T>(Findings& findings, T) {
  for (const auto& [w, h] :
       {std::array<Index, 2>{0, 0}, {0, 5}, {5, 0}, {1, 1}, {1, 9}, {9, 1}, {2, 2}, {3, 1}}) {
    const auto image = waves<T>(w, h);
    for (const double sigma : {0.0, 0.7, 3.0, 50.0}) {
      for (const auto& smooth : {gaussian(image, sigma), gaussian_pyramid(image, sigma)}) {
        findings.expect(smooth.width() == w && smooth.height() == h, "another size comes out");
        for (const T value : smooth.pixels()) {
          findings.expect(std::fabs(value) <= T(2.001), "out of the range that came in");
        }
      }
    }
    if (w == 0 || h == 0) {
      findings.expect_refusal("is not positive", [&, size = std::array{w, h}] {
        const Camera<T> none{10, 10, 0, 0, size[0], size[1]};
        (void)sobel_normals(Image<T>(size[0], size[1]), none);
      });
      continue;
    }
    const Camera<T> small{10, 10, 0, 0, w, h};
    const TactileRenderer<T> renderer(small, Image<T>(w, h, T(0.03)), {});
    findings.expect(renderer.render(Image<T>(w, h, T(0.02))).width() == w, "another width");
  }
};

constexpr auto sigmas = []<class T>(Findings& findings, T) {
  const auto image = waves<T>(width, height);
  findings.expect(gaussian(image, 0) == image, "sigma 0 is not the identity");
  for (const double tiny : {1e-300, 1e-30, 1e-3}) {
    findings.expect(gaussian(image, tiny) == image, "a tiny sigma changes pixels");
  }
  for (const double sigma : {1e3, 1e8, 1e300}) {
    for (const T value : gaussian(image, sigma).pixels()) {
      findings.expect(std::fabs(value) < T(0.3), "a huge sigma leaves more than the mean");
    }
  }
  for (const double bad : {-1.0, -1e-300, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    findings.expect_refusal("sigma", [&] { (void)gaussian(image, bad); });
    findings.expect_refusal("sigma", [&] { (void)gaussian_recursive(image, bad); });
    findings.expect_refusal("sigma", [&] { (void)gaussian_boxes(image, bad); });
    findings.expect_refusal("sigma", [&] { (void)gaussian_pyramid(image, bad); });
    findings.expect_refusal("sigma", [&] {
      TactileOptions options;
      options.smoothing_sigma = bad;
      const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), lights<T>(), {}, options);
    });
  }
};

constexpr auto constants = []<class T>(Findings& findings, T) {
  const T rounding = 40 * std::numeric_limits<T>::epsilon();
  const Image<T> even(width, height, T(0.37));
  for (const Border border : {Border::reflect101, Border::reflect, Border::replicate}) {
    for (const double sigma : {0.6, 2.0, 7.0}) {
      for (const T value : gaussian(even, sigma, static_cast<Index>(4 * sigma), border).pixels()) {
        findings.expect(std::fabs(value - T(0.37)) < rounding, "a constant does not stay");
      }
    }
  }
  // A border that reflects with its edge keeps the sum.
  const auto image = waves<T>(width, height);
  const auto smooth = gaussian(image, 2, 8, Border::reflect);
  double before = 0, after = 0;
  for (const T value : image.pixels()) before += double{value};
  for (const T value : smooth.pixels()) after += double{value};
  findings.expect(std::fabs(after - before) < double{rounding} * width * height,
                  "the sum is not kept");
};

constexpr auto strides = []<class T>(Findings& findings, T) {
  const auto packed = waves<T>(width, height);
  const auto expect_same = [&](ImageView<const T> view, const std::string& what) {
    Image<T> copy(view.width(), view.height());
    for (Index y = 0; y < view.height(); ++y) {
      for (Index x = 0; x < view.width(); ++x) copy(x, y) = view(x, y);
    }
    findings.expect(gaussian(view, 1.5) == gaussian(copy, 1.5), what + ": gaussian differs");
    findings.expect(gaussian_pyramid(view, 4) == gaussian_pyramid(copy, 4),
                    what + ": pyramid differs");
    const Camera<T> own{30, 30, 20, 15, view.width(), view.height()};
    findings.expect(sobel_normals(view, own) == sobel_normals(copy, own),
                    what + ": normals differ");
  };
  expect_same(packed.view().transposed(), "transposed");
  expect_same(ImageView<const T>(packed.data() + width - 1, width, height, width, -1), "mirrored");
  expect_same(ImageView<const T>(packed.row(height - 1), width, height, -width), "upside down");
  expect_same(ImageView<const T>(packed.data(), width / 2, height, width), "padded");
  expect_same(ImageView<const T>(packed.data(), width / 2, height, width, 2), "every other pixel");
  // The renderer: input and output of any stride.
  const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), lights<T>());
  const auto depth = pressed<T>();
  const auto wanted = renderer.render(depth);
  Image<Rgb8> out(width + 3, height, Rgb8{1, 2, 3});
  renderer.render_into(ImageView<Rgb8>(out.data(), width, height, width + 3), depth);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width + 3; ++x) {
      findings.expect(out(x, y) == (x < width ? wanted(x, y) : Rgb8{1, 2, 3}),
                      "a padded output differs, or its padding was written");
    }
  }
};

constexpr auto specular = []<class T>(Findings& findings, T) {
  const Vec3<T> normal(0, 0, 1), behind = Vec3<T>(T(0.1), 0, -1).normalized();
  const Vec3<T> eye = Vec3<T>(T(-0.1), 0, 1).normalized();
  for (const T shininess : {T(2), T(3), T(100)}) {
    findings.expect(phong<T>(normal, behind, eye, 1, 1, shininess) == 0,
                    "a light behind the surface is seen");
  }
  // The named compatible form lights the back with an even exponent.
  findings.expect(phong<T>(normal, behind, eye, 1, 1, 2, Specular::unclamped) > 0,
                  "the compatible form is not compatible");
  const Vec3<T> grazing = Vec3<T>(1, 0, T(0.2)).normalized();
  findings.expect(phong<T>(normal, grazing, grazing, 0, 1, 2) == 0,
                  "a negative cosine is raised to an even power");
};

constexpr auto shininess = []<class T>(Findings& findings, T) {
  const Vec3<T> normal(0, 0, 1), light = Vec3<T>(T(0.6), 0, T(0.8)), eye(T(-0.6), 0, T(0.8));
  const Vec3<T> aside(0, T(0.6), T(0.8));
  for (const T n : {T(0), T(0.5), T(1.7), T(1e3), T(1e30)}) {
    const T at_mirror = phong<T>(normal, light, eye, 0, 1, n);
    findings.expect(std::isfinite(at_mirror), "not finite at the mirror");
    const T off = phong<T>(normal, light, aside, 0, 1, n);
    findings.expect(off >= 0 && off <= 1, "not in [0, 1] aside");
  }
  findings.expect(phong<T>(normal, light, aside, 0, 1, 0) == 1, "x to the 0 is not 1");
  for (const T bad :
       {T(-1), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity()}) {
    findings.expect_refusal("shininess", [&] {
      auto own = lights<T>();
      own[1].shininess = bad;
      const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), own);
    });
  }
};

constexpr auto grazing = []<class T>(Findings& findings, T) {
  // Depths that rise ever more steeply, and one that is a wall.
  for (const T slope : {T(0), T(1e-6), T(1), T(1e4), T(1e9)}) {
    Image<T> depth(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) depth(x, y) = T(0.1) + slope * static_cast<T>(x);
    }
    for (const auto& normals : {sobel_normals(depth, camera<T>()),
                                sobel_normals(depth, camera<T>(), BorderNormals::extrapolated),
                                central_normals(depth, camera<T>())}) {
      for (const auto& n : normals.pixels()) {
        const T norm = n.norm();
        findings.expect(norm == 0 || std::fabs(norm - 1) < T(1e-5),
                        "a normal of length " + std::to_string(norm));
      }
    }
  }
  findings.expect(phong<T>(Vec3<T>::Zero(), Vec3<T>(0, 0, 1), Vec3<T>(0, 0, 1), 1, 1, 2) == 0,
                  "a pixel without a normal is lit");
};

constexpr auto at_the_light = []<class T>(Findings& findings, T) {
  auto own = lights<T>();
  own[0].direction(7, 8) = Vec3<T>::Zero();
  const TactileRenderer<T> with(camera<T>(), rest_depth<T>(), own);
  own[0].direction = Image<Vec3<T>>(width, height, Vec3<T>::Zero());
  const TactileRenderer<T> without(camera<T>(), rest_depth<T>(), own);
  findings.expect(with.rest_image()(7, 8) == without.rest_image()(7, 8),
                  "a light without direction is seen at its own pixel");
};

constexpr auto saturation = []<class T>(Findings& findings, T) {
  auto own = lights<T>();
  own[0].rgb = {1, 0, 1};
  own[0].diffuse = own[0].specular = T(1e30);
  own[1].rgb = {0, 1, 0};
  own[1].diffuse = own[1].specular = T(-1e30);
  const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), own);
  for (const auto& image : {renderer.rest_image(), renderer.render(pressed<T>())}) {
    for (Index y = 1; y < height - 1; ++y) {
      for (Index x = 1; x < width - 1; ++x) {
        const Rgb8 p = image(x, y);
        findings.expect(p[0] % 255 == 0 || p[0] == 127 || p[0] == 128, "not saturated");
        findings.expect(p[1] <= 128, "too dark is not black");
      }
    }
  }
  own[1].rgb = {0, T(255), 0};
  findings.expect_refusal("light 1 has colour (0, 255, 0)", [&] {
    const TactileRenderer<T> refused(camera<T>(), rest_depth<T>(), own);
  });
  own[0].rgb[0] = std::numeric_limits<T>::quiet_NaN();
  findings.expect_refusal("light 0 has colour (nan, 0, 1)", [&] {
    const TactileRenderer<T> refused(camera<T>(), rest_depth<T>(), own);
  });
};

constexpr auto overlap = []<class T>(Findings& findings, T) {
  const TactileRenderer<T> renderer(camera<T>(), rest_depth<T>(), lights<T>());
  Image<T> depth = pressed<T>();
  const auto before = depth.pixels();
  const ImageView<Rgb8> out(reinterpret_cast<Rgb8*>(depth.data() + 5), width, height);
  findings.expect_refusal("in the memory of the depth image",
                          [&] { renderer.render_into(out, depth); });
  findings.expect(depth.pixels() == before, "written before it was refused");
  Image<Rgb8> small(width - 1, height, Rgb8{9, 9, 9});
  findings.expect_refusal("the output image", [&] { renderer.render_into(small, depth); });
  for (const Rgb8& p : small.pixels()) {
    findings.expect(p == Rgb8{9, 9, 9}, "written before it was refused");
  }
};

}  // namespace

std::vector<Case> image_cases() {
  const auto one = [](std::string name, std::string input, std::string others, auto check) {
    return Case{std::move(name), std::move(input), "", {}, std::move(others), both(check)};
  };
  return {one("image 1", "NaN, infinite, zero and negative depth",
              "an unknown pixel stays so and never spreads", unknown_depths),
          one("image 2", "a frame without contact", "the image at rest, bit for bit", no_contact),
          one("image 3", "1 x 1, 1 x N, 0 x 0", "right size and range; a camera of no size refused",
              tiny_images),
          one("image 4", "sigma 0, tiny, huge, negative, NaN",
              "identity, identity, bounded mean, refused", sigmas),
          one("image 5", "a constant image", "stays; the sum is kept where the border reflects",
              constants),
          one("image 6", "transposed, mirrored, padded views",
              "equal to the packed copy bit for bit", strides),
          one("image 7", "a light behind the surface, an even exponent",
              "dark; the compatible form is an option", specular),
          one("image 8", "shininess zero, of a fraction, huge, negative, NaN",
              "finite and in range; refused", shininess),
          one("image 9", "grazing and zero normals", "unit or zero, never NaN", grazing),
          one("image 10", "the pixel at the light", "not lit by it", at_the_light),
          one("image 11", "far too bright, far too dark, NaN", "saturated; refused", saturation),
          one("image 12", "overlapping input and output", "refused before anything is written",
              overlap)};
}

}  // namespace gelight::stress
