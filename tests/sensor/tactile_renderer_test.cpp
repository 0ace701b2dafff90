#include "gelight/sensor/tactile_renderer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "support/refusal.hpp"

using namespace gelight;
using test::contains;
using test::refusal;

namespace {

constexpr Index width = 72, height = 56;
const Camera<double> camera{40, 42, 35.5, 27.5, width, height};
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

// A slanted, slightly curved membrane about 30 mm away.
const Image<double>& rest_depth() {
  static const Image<double> depth = [] {
    Image<double> rest(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        rest(x, y) = 0.03 + 2e-5 * x - 1e-5 * y + 1e-6 * (x - 30) * (x - 30);
      }
    }
    return rest;
  }();
  return depth;
}

// The same with a ball pressed in by up to `depth` metres around a pixel.
Image<double> ball(double depth, Index u = 30, Index v = 25, double radius = 9) {
  Image<double> contact = rest_depth();
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double r2 = ((x - u) * (x - u) + (y - v) * (y - v)) / (radius * radius);
      if (r2 < 1) contact(x, y) -= depth * (1 - r2);
    }
  }
  return contact;
}

template <class T>
Light<T> light(const Vec3<double>& travel, std::array<T, 3> rgb, T shininess = 100) {
  return {Image<Vec3<T>>(width, height, travel.normalized().template cast<T>()), rgb, T(0.5),
          T(0.3), shininess};
}

template <class T = double>
std::vector<Light<T>> two_lights() {
  return {light<T>({1, 0.2, 0.1}, {1, T(0.4), 0}), light<T>({-0.3, -1, 0.4}, {0, T(0.2), 1}, 7)};
}

Image<std::array<double, 3>> picture() {
  Image<std::array<double, 3>> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) image(x, y) = {x / 100.0, y / 100.0, 0.3};
  }
  return image;
}

// The pipeline out of its published parts, a pixel at a time.
Image<Rgb8> step_by_step(const Image<double>& depth, const std::vector<Light<double>>& lights,
                         BorderNormals border) {
  const Image<double> rest = rest_depth();
  const auto background = picture();
  Image<double> protrusion(width, height), membrane(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) protrusion(x, y) = std::max(0.0, rest(x, y) - depth(x, y));
  }
  const auto spread = gaussian(protrusion, 5, 20);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      membrane(x, y) = std::min(depth(x, y), rest(x, y) - spread(x, y));
      membrane(x, y) = std::max(membrane(x, y), rest(x, y) / 128);
    }
  }
  const auto normals = sobel_normals(membrane, camera, border);
  const auto points = unproject(membrane, camera);
  Image<Rgb8> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0.5 * background(x, y)[c];
        for (const auto& l : lights) {
          sum += l.rgb[c] * phong<double>(normals(x, y), -l.direction(x, y),
                                          -points(x, y).normalized(), l.diffuse, l.specular,
                                          l.shininess);
        }
        image(x, y)[c] = static_cast<std::uint8_t>(std::min(255.0, 255 * sum));
      }
    }
  }
  return image;
}

int pixels_off(const Image<Rgb8>& a, const Image<Rgb8>& b, int by) {
  int count = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    int off = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      off = std::max(off, std::abs(a.pixels()[i][c] - b.pixels()[i][c]));
    }
    count += off >= by;
  }
  return count;
}

}  // namespace

TEST_CASE("the frame is its parts, one after the other") {
  for (const auto border : {BorderNormals::none, BorderNormals::extrapolated}) {
    for (const double shininess : {0.0, 1.0, 15.0, 16.0, 300.0, 12.5, 1e6}) {
      auto lights = two_lights();
      lights[1].shininess = shininess;
      const TactileRenderer renderer(camera, rest_depth(), lights, picture(),
                                     TactileOptions{.border_normals = border});
      const auto contact = ball(0.004);
      const auto image = renderer.render(contact);
      const auto expected = step_by_step(contact, lights, border);
      CHECK(pixels_off(image, expected, 2) == 0);
      CHECK(pixels_off(image, expected, 1) <= 4);  // sums that a rounding carries over a level
    }
  }
}

TEST_CASE("what is computed only where the contact changed something is the whole frame's") {
  for (const auto& contact : {ball(0.004), ball(0.001, 2, 54, 4), ball(0.002, 70, 0, 30),
                              ball(0.001, 36, 28, 0.5), rest_depth()}) {
    const TactileRenderer sparse(camera.cast<float>(), rest_depth(), two_lights<float>(),
                                 picture());
    const TactileRenderer dense(camera.cast<float>(), rest_depth(), two_lights<float>(), picture(),
                                TactileOptions{.skip_unchanged = false});
    CHECK(sparse.render(contact) == dense.render(contact));
    CHECK(sparse.rest_image() == dense.rest_image());
  }
}

TEST_CASE("a sequence in which each frame is computed where it differs from the last") {
  // Wide enough that most of it keeps out of a change's reach.
  const Camera<float> eye{100, 100, 124.5f, 74.5f, 250, 150};
  const auto flat = [&](float x, float y) { return 0.03f + 2e-5f * x - 1e-5f * y; };
  Image<float> rest(250, 150), masked(250, 150);
  for (Index y = 0; y < 150; ++y) {
    for (Index x = 0; x < 250; ++x) {
      rest(x, y) = flat(static_cast<float>(x), static_cast<float>(y));
      masked(x, y) = x < 230 ? rest(x, y) : 0;
    }
  }
  const auto dent = [&](Image<float> depth, Index u, Index v, Index size) {
    for (Index y = v; y < std::min(Index{150}, v + size); ++y) {
      for (Index x = u; x < std::min(Index{250}, u + size); ++x) depth(x, y) -= 0.001f;
    }
    return depth;
  };
  const auto resting = dent(rest, 30, 40, 25), two = dent(resting, 200, 100, 1);
  auto holed = two, far = two;
  for (Index x = 190; x < 205; ++x) holed(x, 98) = std::numeric_limits<float>::quiet_NaN();
  far(120, 10) += 0.5f;
  const std::vector<Image<float>> contacts{resting,
                                           resting,
                                           two,
                                           dent(resting, 201, 100, 1),
                                           dent(resting, 249, 149, 1),
                                           holed,
                                           holed,
                                           two,
                                           far,
                                           dent(two, 0, 0, 250),
                                           two,
                                           masked,
                                           rest,
                                           far,
                                           rest,
                                           dent(rest, 100, 70, 3)};
  std::vector<Light<float>> lights{
      {Image<Vec3<float>>(250, 150, Vec3<float>(0.8f, 0.6f, 0)), {1, 0.4f, 0}},
      {Image<Vec3<float>>(250, 150, Vec3<float>(0, -1, 0)), {0, 0.2f, 1}}};
  std::vector<TactileOptions> all(6);
  all[1].smoothing_sigma = 0;
  all[2] = TactileOptions::as_published(true);
  all[3].darkening = 0.5;
  all[4].smoothing_radius = 3;
  all[5].smoothing_radius = 200;
  for (const auto& membrane : {rest, masked}) {
    for (const auto& options : all) {
      const TactileRenderer renderer(eye, membrane, lights, {}, options);
      auto frame = renderer.rest_frame();
      CHECK(frame.image == renderer.rest_image());
      for (const auto& contact : contacts) {
        renderer.render_next_into(frame, contact);
        CHECK(frame.image == renderer.render(contact));
      }
    }
  }
}

TEST_CASE(
    "nothing that touches: the image at rest, bit for bit, and without lights the background") {
  const TactileRenderer renderer(camera.cast<float>(), rest_depth(), two_lights<float>(),
                                 picture());
  CHECK(renderer.render(rest_depth()) == renderer.rest_image());
  Image<double> deeper = rest_depth();
  for (double& z : deeper.pixels()) z += 1;
  CHECK(renderer.render(deeper) == renderer.rest_image());

  Image<Rgb8> colours(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      colours(x, y) = {static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(4 * y), 255};
    }
  }
  const TactileRenderer dark(camera.cast<float>(), rest_depth(), std::vector<Light<float>>{},
                             colours, TactileOptions{.ambient = 1});
  CHECK(dark.render(rest_depth()) == colours);
  CHECK(dark.render(ball(0.004)) == colours);
}

TEST_CASE("unknown depths show the background, and reach no further than the smoothing") {
  const auto lights = two_lights<float>();
  const TactileRenderer renderer(camera.cast<float>(), rest_depth(), lights, picture());
  const TactileRenderer unlit(camera.cast<float>(), rest_depth(), std::vector<Light<float>>{},
                              picture());
  const auto background = unlit.rest_image();
  const auto whole = renderer.render(ball(0.004));
  for (const double bad : {unknown, -inf, 0.0, -0.01}) {
    auto contact = ball(0.004);
    contact(32, 27) = contact(33, 27) = bad;
    const auto image = renderer.render(contact);
    CHECK(image(32, 27) == background(32, 27));
    CHECK(image(33, 27) == background(33, 27));
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const bool in_reach = x >= 32 - 21 && x <= 33 + 21 && std::abs(y - 27) <= 21;
        if (!in_reach) CHECK(image(x, y) == whole(x, y));
      }
    }
  }
}

TEST_CASE("unknown depths do not bias the membrane: a membrane pressed in evenly stays even") {
  Image<double> even = rest_depth();
  for (double& z : even.pixels()) z -= 0.002;
  const TactileRenderer renderer(camera, rest_depth(), two_lights(), picture());
  const auto whole = renderer.render(even);
  auto holed = even;
  for (Index y = 10; y < 30; ++y) {
    for (Index x = 20; x < 26; ++x) holed(x, y) = unknown;
  }
  holed(0, 0) = holed(60, 55) = 0;
  const auto image = renderer.render(holed);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if (std::isnan(holed(x, y)) || holed(x, y) == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(image(x, y)[c] - whole(x, y)[c]) <= 1);
    }
  }
  Image<double> nothing(width, height, unknown);
  CHECK(
      renderer.render(nothing) ==
      TactileRenderer(camera, rest_depth(), std::vector<Light<double>>{}, picture()).rest_image());
}

TEST_CASE_TEMPLATE("nor where the Gaussian is so narrow that a hole's neighbours hardly count", T,
                   float, double) {
  // Pressed in by 1 mm, but for holes of one pixel and more, and a part without membrane.
  const auto eye = camera.cast<T>();
  Image<T> rest(width, height, T(0.03));
  for (Index y = 30; y < 50; ++y) std::fill_n(rest.row(y) + 50, 12, T(0));
  Image<T> even(width, height, T(0.029));
  auto holed = even;
  for (Index y = 10; y < 20; ++y) {
    for (Index x = 20; x < 26; ++x) holed(x, y) = std::numeric_limits<T>::quiet_NaN();
  }
  for (Index k = 0; k < 9; ++k) holed(40 + k, 5 + k) = holed(49, 30 + 2 * k) = 0;
  for (const double sigma : {0.12, 0.17, 0.2, 0.25, 0.3, 0.4}) {
    for (const Index radius : {1, 4, 20}) {
      TactileOptions options;
      options.smoothing_sigma = sigma;
      options.smoothing_radius = radius;
      const TactileRenderer renderer(eye, rest, two_lights<T>(), picture(), options);
      const auto whole = renderer.render(even), image = renderer.render(holed);
      const GaussianMembrane<T> membrane(sigma, radius);
      auto work = membrane.make_workspace(width, height);
      Image<T> surface(width, height);
      membrane.press_into(surface, {holed, rest, {0, 0, width, height}}, work);
      for (Index y = 0; y < height; ++y) {
        for (Index x = 0; x < width; ++x) {
          const bool is_deep = x > 20 && x < 25 && y > 10 && y < 19;  // no neighbour is known
          // Of float's digits the share that is known may lose ten bits.
          if (!is_deep && rest(x, y) > 0) CHECK(std::abs(surface(x, y) - T(0.029)) < 3e-7);
          if (!(holed(x, y) > 0)) continue;
          for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(image(x, y)[c] - whole(x, y)[c]) <= 1);
        }
      }
    }
  }
}

TEST_CASE("a rest depth with a mask: the background outside, no light one pixel from the edge") {
  auto masked = rest_depth();
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if ((x - 36) * (x - 36) + (y - 28) * (y - 28) > 26 * 26) masked(x, y) = unknown;
    }
  }
  auto even = masked;
  for (double& z : even.pixels()) z -= 0.002;
  const TactileRenderer renderer(camera, masked, two_lights(), picture());
  const TactileRenderer free(camera, rest_depth(), two_lights(), picture());
  auto free_even = rest_depth();
  for (double& z : free_even.pixels()) z -= 0.002;
  const auto want = free.render(free_even), image = renderer.render(even);
  const auto unlit =
      TactileRenderer(camera, masked, std::vector<Light<double>>{}, picture()).rest_image();
  for (Index y = 1; y < height - 1; ++y) {
    for (Index x = 1; x < width - 1; ++x) {
      bool inside = true;
      for (const Index dy : {-1, 0, 1}) {
        for (const Index dx : {-1, 0, 1}) inside = inside && !std::isnan(masked(x + dx, y + dy));
      }
      if (!inside) CHECK(image(x, y) == unlit(x, y));
      if (!inside) continue;
      for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(image(x, y)[c] - want(x, y)[c]) <= 1);
    }
  }
  // The mask in the contact's depth alone is holes, and gives the same.
  CHECK(renderer.render(free_even) == image);
}

TEST_CASE("a rigid membrane follows the contact; sigma 0 and a radius of 0 are the same") {
  const auto contact = ball(0.003);
  const TactileRenderer rigid(camera, rest_depth(), two_lights(), picture(),
                              TactileOptions{.smoothing_sigma = 0});
  const TactileRenderer narrow(camera, rest_depth(), two_lights(), picture(),
                               TactileOptions{.smoothing_sigma = 5, .smoothing_radius = 0});
  const TactileRenderer of_contact(camera, contact, two_lights(), picture());
  CHECK(rigid.render(contact) == of_contact.rest_image());
  CHECK(narrow.render(contact) == of_contact.rest_image());
}

TEST_CASE("without clipping a rigid membrane follows what lies deeper than rest, too") {
  Image<double> deeper = ball(-0.003);
  for (double& z : deeper.pixels()) z += 0.001;
  const TactileRenderer of_contact(camera, deeper, two_lights(), picture());
  for (const TactileOptions options :
       {TactileOptions{.smoothing_sigma = 0, .clip_to_rest = false},
        TactileOptions{.smoothing_radius = 0, .clip_to_rest = false}}) {
    const TactileRenderer pulled(camera, rest_depth(), two_lights(), picture(), options);
    CHECK(pulled.render(deeper) == of_contact.rest_image());
  }
  const TactileRenderer clipped(camera, rest_depth(), two_lights(), picture(),
                                TactileOptions{.smoothing_sigma = 0});
  CHECK(clipped.render(deeper) == clipped.rest_image());
}

TEST_CASE("pressed gel darkens the background, and nothing else does") {
  const TactileOptions options{.ambient = 1, .darkening = 0.4, .darkening_depth = 0.005};
  const Image<double> background(width, height, 0.8);
  const TactileRenderer renderer(camera, rest_depth(), std::vector<Light<double>>{}, background,
                                 options);
  const auto contact = ball(0.008);
  const auto image = renderer.render(contact);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double pressed = std::max(0.0, rest_depth()(x, y) - contact(x, y));
      const double want = 204 * (1 - 0.4 * std::min(1.0, pressed / 0.005));
      CHECK(std::abs(image(x, y)[1] - std::floor(want + 1e-9)) <= (pressed > 0 ? 1 : 0));
    }
  }
  const TactileRenderer lit(camera, rest_depth(), two_lights(), picture(),
                            TactileOptions{.darkening = 0.4});
  const TactileRenderer whole(camera, rest_depth(), two_lights(), picture(),
                              TactileOptions{.darkening = 0.4, .skip_unchanged = false});
  CHECK(lit.render(contact) == whole.render(contact));
  CHECK(lit.rest_image() ==
        TactileRenderer(camera, rest_depth(), two_lights(), picture()).rest_image());
  CHECK(contains(refusal([&] {
                   TactileRenderer(camera, rest_depth(), two_lights(), picture(),
                                   TactileOptions{.darkening = 1.1});
                 }),
                 "darkening 1.1"));
}

TEST_CASE("images of one row, one column and one pixel; a radius beyond the image") {
  for (const auto& [w, h] :
       {std::array{1, 1}, std::array{9, 1}, std::array{1, 9}, std::array{3, 2}}) {
    const Camera<float> small{4, 4, 0, 0, w, h};
    std::vector<Light<float>> lights{{Image<Vec3<float>>(w, h, Vec3<float>(0, 0, 1)), {1, 1, 1}}};
    for (const auto border : {BorderNormals::none, BorderNormals::extrapolated}) {
      const TactileRenderer renderer(small, Image<float>(w, h, 0.03f), lights,
                                     std::array{0.5f, 0.5f, 0.5f},
                                     TactileOptions{.border_normals = border});
      const auto image = renderer.render(Image<float>(w, h, 0.028f));
      CHECK(image.width() == w);
      const bool lit = border == BorderNormals::extrapolated;
      // Ambient 63; light from the camera on a flat membrane adds at least half of 255.
      CHECK((image(0, 0)[0] > 63 + 127) == lit);
      CHECK((image(0, 0)[0] == 63) == !lit);
    }
  }
}

TEST_CASE("every kind of background and of depth image") {
  const auto lights = two_lights<float>();
  const auto eye = camera.cast<float>();
  const auto contact = ball(0.003);
  const auto image_on = [&](const auto& background) {
    return TactileRenderer(eye, rest_depth(), lights, background).render(contact);
  };
  const Image<std::uint8_t> grey(width, height, 51);
  CHECK(image_on(grey) == image_on(std::array{0.2f, 0.2f, 0.2f}));
  CHECK(image_on(grey) == image_on(Image<Rgb8>(width, height, {51, 51, 51})));
  CHECK(image_on(grey) == image_on(Image<float>(width, height, 0.2f)));
  CHECK(image_on(grey) == image_on(Image<Vec3<float>>(width, height, Vec3<float>::Constant(0.2f))));
  CHECK(image_on(Background<float>{}) ==
        TactileRenderer(eye, rest_depth(), lights).render(contact));

  const TactileRenderer renderer(eye, rest_depth(), lights, picture());
  const auto want = renderer.render(contact);
  std::vector<double> padded(static_cast<std::size_t>((width + 5) * height), unknown);
  std::vector<double> upside_down(static_cast<std::size_t>(width * height));
  Image<double> columns(height, width);
  Image<float> floats(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      padded[static_cast<std::size_t>((width + 5) * y + x)] = contact(x, y);
      upside_down[static_cast<std::size_t>(width * (height - 1 - y) + x)] = contact(x, y);
      columns(y, x) = contact(x, y);
      floats(x, y) = static_cast<float>(contact(x, y));
    }
  }
  CHECK(renderer.render(ImageView<double>(padded.data(), width, height, width + 5)) == want);
  CHECK(renderer.render(ImageView<double>(upside_down.data() + width * (height - 1), width, height,
                                          -width)) == want);
  CHECK(renderer.render(columns.view().transposed()) == want);
  CHECK(renderer.render(floats) == want);
}

// A depth image that cannot be read beyond a row, as it comes over a wire.
struct BrokenDepth {
  const Image<double>* depth;
  Index last;
  [[nodiscard]] Index width() const { return depth->width(); }
  [[nodiscard]] Index height() const { return depth->height(); }
  [[nodiscard]] double operator()(Index x, Index y) const {
    if (y > last) throw std::runtime_error("gone");
    return (*depth)(x, y);
  }
};

TEST_CASE("a frame whose depth image throws half-way is at rest") {
  TactileOptions options;
  options.smoothing_sigma = 1;
  options.smoothing_radius = 2;
  const TactileRenderer<double> sensor(camera, rest_depth(), two_lights(), {}, options);
  auto frame = sensor.rest_frame();
  sensor.render_next_into(frame, ball(3e-3, 50, 40));
  const Image<double> depth = ball(3e-3);
  CHECK_THROWS_AS(sensor.render_next_into(frame, BrokenDepth{&depth, 27}), std::runtime_error);
  CHECK(frame.image == sensor.rest_image());
  CHECK(frame.depth == rest_depth());
  sensor.render_next_into(frame, depth);
  CHECK(frame.image == sensor.render(depth));
}

TEST_CASE("output of any stride is the packed image, and nothing beside its pixels is touched") {
  const TactileRenderer renderer(camera.cast<float>(), rest_depth(), two_lights<float>(),
                                 picture());
  const auto contact = ball(0.003);
  const auto want = renderer.render(contact);
  const Rgb8 untouched{1, 2, 3};
  Image<Rgb8> large(width + 3, height + 1, untouched), columns(height, width),
      apart(2 * width, height, untouched);
  renderer.render_into({large.data(), width, height, width + 3}, contact);
  renderer.render_into(columns.view().transposed(), contact);
  renderer.render_into({apart.data(), width, height, 2 * width, 2}, contact);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      CHECK(large(x, y) == want(x, y));
      CHECK(columns(y, x) == want(x, y));
      CHECK(apart(2 * x, y) == want(x, y));
      CHECK(apart(2 * x + 1, y) == untouched);
    }
    for (Index x = width; x < width + 3; ++x) CHECK(large(x, y) == untouched);
  }
  for (Index x = 0; x < width + 3; ++x) CHECK(large(x, height) == untouched);
}

TEST_CASE("too bright is white, and eight lights are the sum of their parts") {
  std::vector<Light<float>> lights(8, light<float>({0, 0, 1}, {1, 0.1f, 0}));
  const TactileRenderer renderer(camera.cast<float>(), rest_depth(), lights);
  const auto image = renderer.render(ball(0.002));
  CHECK(image(30, 25)[0] == 255);
  lights[0].rgb = {0, 0.8f, 0};
  lights.resize(1);
  const auto one = TactileRenderer(camera.cast<float>(), rest_depth(), lights).render(ball(0.002));
  for (std::size_t i = 0; i < image.pixels().size(); ++i) {
    CHECK(std::abs(image.pixels()[i][1] - one.pixels()[i][1]) <= 1);
  }
}

TEST_CASE("a renderer used from two threads and used again gives the same image") {
  const TactileRenderer renderer(camera.cast<float>(), rest_depth(), two_lights<float>(),
                                 picture());
  const TactileRenderer copy = renderer;
  const std::array contacts{ball(0.004), ball(0.002, 50, 40, 12)};
  const std::array want{renderer.render(contacts[0]), renderer.render(contacts[1])};
  std::array<int, 2> wrong{};
  std::vector<std::thread> threads;
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
    threads.emplace_back([&, k] {
      for (int i = 0; i < 50; ++i) wrong[k] += renderer.render(contacts[k]) != want[k];
    });
  }
  for (auto& thread : threads) thread.join();
  CHECK(wrong == std::array{0, 0});
  CHECK(copy.render(contacts[0]) == want[0]);
}

TEST_CASE("input that cannot be used is refused by name, before anything is written") {
  const auto rest = rest_depth();
  const auto make =
      [&](const Camera<double>& eye, const auto& depth, const std::vector<Light<double>>& lights,
          const Background<double>& background = {}, const TactileOptions& options = {}) {
        return refusal([&] { TactileRenderer<double>(eye, depth, lights, background, options); });
      };
  CHECK(make(camera, rest, two_lights(), picture()) == "accepted");
  auto blind = camera;
  blind.fx = 0;
  CHECK(contains(make(blind, rest, two_lights()), "focal lengths (0, 42)"));
  CHECK(make(camera, Image<double>(3, 4), {}) ==
        "the rest depth image is 3 x 4 pixels, the camera's image 72 x 56");
  CHECK(make(camera, rest, {}, Image<float>(72, 55)) ==
        "the background image is 72 x 55 pixels, the camera's image 72 x 56");
  auto lights = two_lights();
  lights[1].direction = Image<Vec3<double>>(56, 72);
  CHECK(make(camera, rest, lights) ==
        "the direction image of light 1 is 56 x 72 pixels, the camera's image 72 x 56");
  lights = two_lights();
  lights[1].direction(5, 6).y() = unknown;
  CHECK(contains(make(camera, rest, lights), "light 1 has direction"));
  CHECK(contains(make(camera, rest, lights), "at pixel (5, 6)"));
  lights = two_lights();
  lights[0].shininess = -1;
  CHECK(contains(make(camera, rest, lights), "light 0 has shininess -1"));
  lights[0].shininess = 2.5;
  CHECK(make(camera, rest, lights) == "accepted");
  CHECK(contains(make(camera, rest, lights, {}, TactileOptions{.specular = Specular::unclamped}),
                 "shininess 2.5"));
  lights = two_lights();
  lights[0].rgb[2] = inf;
  CHECK(contains(make(camera, rest, lights), ", inf), which is not in shares of full light"));
  lights = two_lights();
  lights[1].specular = unknown;
  CHECK(make(camera, rest, lights) == "light 1 has specular coefficient nan, which is not finite");
  CHECK(contains(make(camera, rest, {}, {}, TactileOptions{.smoothing_sigma = unknown}),
                 "sigma nan"));
  CHECK(contains(make(camera, rest, {}, {}, TactileOptions{.smoothing_sigma = -2}), "sigma -2"));
  CHECK(contains(make(camera, rest, {}, {}, TactileOptions{.smoothing_radius = -1}), "radius -1"));
  CHECK(contains(make(camera, rest, {}, {}, TactileOptions{.ambient = unknown}), "ambient nan"));
  auto bad = picture();
  bad(7, 8)[1] = unknown;
  CHECK(contains(refusal([&] { Background<double> background(bad); }), "background pixel (7, 8)"));

  const TactileRenderer renderer(camera, rest, two_lights());
  Image<Rgb8> out(width, height, {9, 9, 9});
  CHECK(refusal([&] { renderer.render_into(out, Image<double>(72, 57)); }) ==
        "the depth image is 72 x 57 pixels, the camera's image 72 x 56");
  Image<Rgb8> small(2, 2, {9, 9, 9});
  CHECK(refusal([&] { renderer.render_into(small, rest); }) ==
        "the output image is 2 x 2 pixels, the camera's image 72 x 56");
  Image<double> depth = rest;
  const ImageView<Rgb8> within(reinterpret_cast<Rgb8*>(depth.data()) + 10, width, height);
  CHECK(refusal([&] { renderer.render_into(within, depth); }) ==
        "the output image lies in the memory of the depth image");
  CHECK(refusal([&] { renderer.render_into(within, ImageView<const double>(depth)); }) !=
        "accepted");
  auto own = renderer.rest_frame();
  CHECK(refusal([&] { renderer.render_next_into(own, own.depth); }) ==
        "the output image lies in the memory of the depth image");
  TactileFrame<double> frame{Image<double>(2, 2), out};
  CHECK(refusal([&] { renderer.render_next_into(frame, rest); }) ==
        "the frame's depth image is 2 x 2 pixels, the camera's image 72 x 56");
  frame = {rest, small};
  CHECK(refusal([&] { renderer.render_next_into(frame, depth); }) ==
        "the frame's image is 2 x 2 pixels, the camera's image 72 x 56");
  CHECK(frame.image == small);
  CHECK(out == Image<Rgb8>(width, height, {9, 9, 9}));
  CHECK(small == Image<Rgb8>(2, 2, {9, 9, 9}));
  CHECK(depth == rest);
}

TEST_CASE_TEMPLATE("light that is made tangent lights nothing at rest, whatever its rounding", T,
                   float, double) {
  const Camera<T> eye{T(300), T(280), T(77.3), T(61.8), 160, 120};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> one(-1, 1);
  for (int round = 0; round < 24; ++round) {
    // A wavy membrane, tilted, of any scale; in every third round rough, too.
    const double scale = std::pow(10, 3 * one(random)), tilt = 0.003 * one(random);
    const double wave = 0.05 * one(random), length = 10 + 40 * std::abs(one(random));
    Image<double> rest(160, 120);
    for (Index y = 0; y < 120; ++y) {
      for (Index x = 0; x < 160; ++x) {
        const double rough = round % 3 == 0 ? 0.003 * one(random) : 0;
        rest(x, y) =
            scale * (1 + tilt * (x - y) + wave * std::sin(x / length) * std::cos(y / 9.0) + rough);
        if (round % 4 == 0 && std::hypot(x - 80, y - 60) > 50) rest(x, y) = 0;
      }
    }
    std::vector<Light<T>> lights;
    for (int k = 0; k < 3; ++k) {
      Image<Vec3<T>> direction(160, 120);
      const Vec3<double> middle(one(random), one(random), one(random));
      for (auto& d : direction.pixels()) {
        const Vec3<double> jitter(one(random), one(random), one(random));
        d = (middle + 0.2 * (k + 1) * jitter).normalized().cast<T>();
      }
      lights.push_back({direction, {1, 1, 1}, T(0.5), T(0.5), T(k == 0 ? 0 : 5)});
    }
    for (const auto border : {BorderNormals::none, BorderNormals::extrapolated}) {
      const TactileOptions options{.rectify = true, .border_normals = border};
      const Background<T> grey(std::array{T(0.4), T(0.6), T(0.8)});
      const TactileRenderer renderer(eye, rest, lights, grey, options);
      const TactileRenderer unlit(eye, rest, std::vector<Light<T>>{}, grey, options);
      CHECK(pixels_off(renderer.rest_image(), unlit.rest_image(), 1) == 0);
      // Where it is pressed in it is lit.
      auto contact = rest;
      for (Index y = 40; y < 80; ++y) {
        for (Index x = 60; x < 100; ++x) contact(x, y) -= 0.02 * scale;
      }
      CHECK(pixels_off(renderer.render(contact), unlit.rest_image(), 20) > 50);
    }
  }
}

// Every pixel's light comes as the plate before the camera mirrors it into the eye: R.V is 1, and
// N.L the cosine of the eye's own ray.
TEST_CASE_TEMPLATE("what is mirrored straight into the eye is as bright as the light is glossy", T,
                   float, double) {
  for (const double focal : {40.0, 400.0, 2000.0}) {
    const Camera<T> eye{T(focal), T(focal), T(59.5), T(39.5), 120, 80};
    Light<T> light{Image<Vec3<T>>(120, 80)};
    light.specular = T(0.4);
    for (Index y = 0; y < 80; ++y) {
      for (Index x = 0; x < 120; ++x) {
        const Vec3<double> ray = eye.template cast<double>().ray(x, y).normalized();
        light.direction(x, y) = Vec3<double>(-ray.x(), -ray.y(), ray.z()).template cast<T>();
      }
    }
    // Directions in codes of 16 bits round R.V by up to 1e-5, of which the powers make 1 %.
    for (const double shininess : {5.0, 100.0, 1000.0, 1000.5}) {
      light.shininess = T(shininess);
      const TactileRenderer renderer(eye, Image<T>(120, 80, T(0.03)), std::vector{light});
      for (Index y = 1; y < 79; ++y) {
        for (Index x = 1; x < 119; ++x) {
          const double cosine = 1 / norm(eye.template cast<double>().ray(x, y));
          const double seen = renderer.rest_image()(x, y)[0];
          CHECK(std::abs(seen + 0.5 - 255 * (0.5 * cosine + 0.4)) < 2);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("however strong a light, black stays black, or the light is refused", T, float,
                   double) {
  const auto eye = camera.cast<T>();
  const Image<T> flat(width, height, T(0.03));
  // A membrane that the lights run along: by the ambient share of black it is black.
  std::vector<Light<T>> lights{{Image<Vec3<T>>(width, height, Vec3<T>(1, 0, 0)), {1, 1, 0}}};
  int answered = 0;
  for (const double much : {1e3, 1e30, 1e35, 1e36, 1e38, 1e39, 1e300, 1e305, 1e306, 1e308}) {
    CAPTURE(much);
    if (much > double{std::numeric_limits<T>::max()}) continue;
    for (const int which : {0, 1, 2}) {
      TactileOptions options{.rectify = true};
      auto strong = lights;
      (which == 0 ? strong[0].diffuse : strong[0].specular) = static_cast<T>(which < 2 ? much : 1);
      if (which == 2) options.ambient = much;
      const auto answer = refusal([&] {
        const TactileRenderer<T> renderer(eye, flat, strong, {}, options);
        for (const Rgb8& pixel : renderer.rest_image().pixels()) REQUIRE(pixel == Rgb8{0, 0, 0});
        const Background<T> blue(std::array<T, 3>{0, 0, T(0.5)});
        const TactileRenderer<T> bright(eye, flat, strong, blue, options);
        const auto level = static_cast<std::uint8_t>(which == 2 ? 255 : 63);
        for (const Rgb8& pixel : bright.rest_image().pixels()) {
          REQUIRE(pixel == Rgb8{0, 0, level});
        }
      });
      answered += answer == "accepted" ? 1 : 0;
      CHECK((answer == "accepted" || contains(answer, "more than the images' type can hold")));
    }
  }
  CHECK(answered >= 9);
  const auto most = std::numeric_limits<T>::max();
  lights[0].diffuse = -most;
  CHECK(contains(refusal([&] { TactileRenderer<T>(eye, flat, lights); }),
                 "light 0 has coefficient -"));
  const TactileOptions options{.ambient = double{most}};
  CHECK(contains(refusal([&] { TactileRenderer<T>(eye, flat, {}, {}, options); }),
                 " is more than the images' type can hold"));
}

TEST_CASE_TEMPLATE("the smaller sigma, the closer the membrane to the contact", T, float, double) {
  const auto eye = camera.cast<T>();
  // Pressed in on one side, pulled on the other.
  auto contact = ball(0.003, 20, 20);
  const auto pulled = ball(-0.003, 50, 35);
  for (std::size_t i = 0; i < contact.pixels().size(); ++i) {
    contact.pixels()[i] = std::min(contact.pixels()[i], pulled.pixels()[i]);
    if (pulled.pixels()[i] > rest_depth().pixels()[i]) contact.pixels()[i] = pulled.pixels()[i];
  }
  for (const bool clip : {true, false}) {
    const auto at = [&](double sigma, Index radius) {
      TactileOptions options;
      options.smoothing_sigma = sigma;
      options.smoothing_radius = radius;
      options.clip_to_rest = clip;
      return TactileRenderer(eye, rest_depth(), two_lights<T>(), picture(), options)
          .render(contact);
    };
    const auto rigid = at(0, 20);
    CHECK(at(0, 0) == rigid);
    CHECK(at(5, 0) == rigid);
    for (const double sigma : {1e-300, 1e-30, 1e-6, 1e-3, 0.05, 0.1}) {
      CHECK(pixels_off(at(sigma, 20), rigid, 2) == 0);
    }
    // And by its parts: the normals of the contact, where that is not clipped.
    auto membrane = contact;
    for (std::size_t i = 0; clip && i < membrane.pixels().size(); ++i) {
      membrane.pixels()[i] = std::min(membrane.pixels()[i], rest_depth().pixels()[i]);
    }
    const auto as_rest = TactileRenderer(eye, membrane, two_lights<T>(), picture()).rest_image();
    CHECK(pixels_off(rigid, as_rest, 2) == 0);
  }
}

TEST_CASE("a light in another unit is refused by name and place") {
  auto lights = two_lights();
  const auto said = [&](const TactileOptions& options = {}) {
    return refusal([&] { TactileRenderer(camera, rest_depth(), lights, picture(), options); });
  };
  lights[1].rgb = {0, 255, 0};
  CHECK(said() ==
        "light 1 has colour (0, 255, 0), which is not in shares of full light from 0 to 1");
  lights[1].rgb = {0, -0.5, 0};
  CHECK(contains(said(), "light 1 has colour (0, -0.5, 0)"));
  lights = two_lights();
  lights[0].direction(3, 4) = {0, 2, 0};
  CHECK(said() == "light 0 has direction (0, 2, 0) at pixel (3, 4), which is longer than 1");
  CHECK(said({.rectify = true}) == "accepted");  // makes it of unit length
  lights[0].direction(3, 4) = {0, unknown, 0};
  CHECK(contains(said(), "not finite"));
  // By rounding, or where it is dimmer or dark.
  lights[0].direction(3, 4) = {0, 1.0001, 0};
  lights[0].direction(4, 4) = {0, 0.3, 0};
  lights[0].direction(5, 4) = {0, 0, 0};
  lights[0].rgb = {1.0000001, 0, 1};
  CHECK(said() == "accepted");
}

TEST_CASE_TEMPLATE("depths of any size beside the rest depth give the image of a membrane", T,
                   float, double) {
  // Depths and lights that both types hold, so that both renderers are shown the same.
  const auto rest = rest_depth();
  std::vector<Light<double>> lights = two_lights();
  std::vector<Light<T>> same;
  for (const Light<double>& l : lights) {
    Light<T> light{Image<Vec3<T>>(width, height), {}, T(l.diffuse), T(l.specular), T(l.shininess)};
    for (std::size_t c = 0; c < 3; ++c) light.rgb[c] = static_cast<T>(l.rgb[c]);
    light.direction = Image<Vec3<T>>(width, height, l.direction(0, 0).template cast<T>());
    same.push_back(light);
  }
  std::mt19937 random(5);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Image<T> scaled_rest(width, height);
    for (std::size_t i = 0; i < rest.pixels().size(); ++i) {
      scaled_rest.pixels()[i] = static_cast<T>(scale * rest.pixels()[i]);
    }
    for (const BorderNormals border : {BorderNormals::none, BorderNormals::extrapolated}) {
      TactileOptions options;
      options.border_normals = border;
      const TactileRenderer<T> renderer(camera.cast<T>(), scaled_rest, same, picture(), options);
      for (int power = 1; power < 40; power += 6) {
        CAPTURE(scale);
        CAPTURE(power);
        const double share = std::pow(10.0, -power);
        // A block pressed to a share of the rest depth, away from the border.
        const auto u = static_cast<Index>(3 + random() % 20),
                   v = static_cast<Index>(3 + random() % 20);
        Image<double> depth = rest;
        Image<T> contact = scaled_rest;
        for (Index y = v; y < v + 30; ++y) {
          for (Index x = u; x < u + 40; ++x) {
            depth(x, y) *= share;
            contact(x, y) = static_cast<T>(share * scale * rest(x, y));
          }
        }
        // What is smaller than any number is not a depth.
        if (!(contact(u, v) > 0)) continue;
        const auto image = renderer.render(contact);
        CHECK(pixels_off(image, step_by_step(depth, lights, border), 4) <= 8);
        CHECK(pixels_off(image, renderer.rest_image(), 4) > 100);
      }
    }
  }
}

TEST_CASE_TEMPLATE("what pulls a membrane out of the range of depths does not pull it", T, float,
                   double) {
  TactileOptions options;
  options.clip_to_rest = false;
  const auto background = picture();
  const TactileRenderer<T> renderer(camera.cast<T>(), rest_depth(), two_lights<T>(), background,
                                    options);
  for (int power = 1; power < 300; power += power < 40 ? 1 : 37) {
    Image<T> contact(width, height);
    for (std::size_t i = 0; i < contact.pixels().size(); ++i) {
      contact.pixels()[i] = static_cast<T>(rest_depth().pixels()[i]);
    }
    for (Index x = 10; x < 60; ++x) contact(x, x % 40 + 8) *= static_cast<T>(std::pow(10.0, power));
    const bool pulls = double{contact(10, 18)} < (sizeof(T) == 4 ? 4e7 : 1e74);
    CAPTURE(power);
    if (!pulls) CHECK(renderer.render(contact) == renderer.rest_image());
    // Ambient light is left of every pixel.
    const auto image = renderer.render(contact);
    int darker = 0;
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          darker += image(x, y)[c] + 1 < static_cast<int>(127.5 * background(x, y)[c]);
        }
      }
    }
    CHECK(darker == 0);
  }
}

TEST_CASE("a rest depth whose fourth power float does not hold is refused by place") {
  const auto said = [](auto t, double scale) {
    using T = decltype(t);
    auto rest = rest_depth();
    for (double& z : rest.pixels()) z *= scale;
    return refusal([&] { TactileRenderer(camera.cast<T>(), rest, two_lights<T>(), picture()); });
  };
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    CHECK(said(float{}, scale) == "accepted");
    CHECK(said(double{}, scale * scale * scale) == "accepted");
  }
  CHECK(contains(said(float{}, 1e-8), "at pixel (0, 0) is not between "));
  CHECK(contains(said(float{}, 1e10), "is not between"));
  CHECK(contains(said(double{}, 1e-80), "is not between"));
}

TEST_CASE_TEMPLATE("a background in another unit is refused by name and place", T, float, double) {
  std::mt19937 random(3);
  for (const double bad : {unknown, inf, -inf, -1e-6, -1.0, 1.01, 255.0, 1e30}) {
    CAPTURE(bad);
    std::array<T, 3> rgb{T(0.5), T(0.25), T(1)};
    rgb[random() % 3] = static_cast<T>(bad);
    CHECK(contains(refusal([&] { Background<T> background(rgb); }), "the background colour is ("));
    Image<std::array<T, 3>> colours(5, 4, {T(0.5), T(0.5), T(0.5)});
    colours(3, 1) = rgb;
    CHECK(contains(refusal([&] { Background<T> background(colours); }),
                   "background pixel (3, 1) is ("));
    Image<T> grey(5, 4, T(0.5));
    grey(4, 2) = static_cast<T>(bad);
    CHECK(contains(refusal([&] { Background<T> background(grey); }), "background pixel (4, 2)"));
  }
  const std::array<T, 3> rounded{T(1.001), T(0), T(-0.0)};
  CHECK(refusal([&] { Background<T> background(rounded); }) == "accepted");
  // Levels are shares of their type's largest value; of other integers nobody knows that.
  CHECK(Background<T>(Rgb8{255, 0, 51}).solid() == std::array{T(1), T(0), T(0.2)});
  CHECK(Background<T>(std::array<std::uint16_t, 3>{65535, 0, 13107}).solid() ==
        std::array{T(1), T(0), T(0.2)});
  static_assert(!std::constructible_from<Background<T>, std::array<int, 3>>);
  static_assert(!std::constructible_from<Background<T>, std::array<unsigned, 3>>);
  static_assert(!std::constructible_from<Background<T>, std::array<signed char, 3>>);
  static_assert(!std::constructible_from<Background<T>, Image<int>>);
  static_assert(!std::constructible_from<Background<T>, Image<std::array<int, 3>>>);
}
