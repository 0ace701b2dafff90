#include "gelight/sensor/see_through.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "gelight/image/plane_fit.hpp"
#include "support/approx.hpp"
#include "support/refusal.hpp"

using namespace gelight;
using test::refusal;

namespace {

constexpr Index width = 72, height = 56;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();
const Camera<double> camera{60, 62, 35.5, 27.5, width, height};
const Image<double> rest(width, height, 0.03);

// A ball pressed in by up to `depth` metres around a pixel.
Image<double> ball(double depth, Index u = 30, Index v = 25, double radius = 9) {
  Image<double> contact(width, height, inf);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double r2 = ((x - u) * (x - u) + (y - v) * (y - v)) / (radius * radius);
      contact(x, y) = r2 < 2 ? 0.03 - depth * (1 - r2) : inf;
    }
  }
  return contact;
}

Image<std::array<double, 3>> picture() {
  Image<std::array<double, 3>> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) image(x, y) = {x / 80.0, y / 60.0, 0.3};
  }
  return image;
}

Image<Rgb8> levels_of_grey() {
  Image<Rgb8> image(width, height);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const int i = y * width + x;
      image(x, y) = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i % 256),
                     static_cast<std::uint8_t>(7 * i)};
    }
  }
  return image;
}

int worst(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  int most = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(a.pixels()[i][c] - b.pixels()[i][c]));
    }
  }
  return most;
}

std::uint8_t to_level(double share) {
  return static_cast<std::uint8_t>(std::clamp(255 * share, 0.0, 255.0));
}

}  // namespace

TEST_CASE("the frame is its parts, one after the other") {
  const auto lights = edge_lights(camera, 0.3);
  const auto colours = picture(), visual = picture();
  for (const Index radius : {1, 3}) {
    const SeeThroughOptions options{.thickness = 0.004,
                                    .normal_radius = radius,
                                    .darkening = 0.3,
                                    .reflectance = 0.4,
                                    .transmittance = 0.25,
                                    .exposure = 1.5,
                                    .levels = {0.9, 0.6}};
    const SeeThroughRenderer renderer(camera, rest, lights, colours, options);
    const auto contact = ball(0.006);
    const auto image = renderer.render(contact, visual);

    Image<double> gel = contact;
    for (double& z : gel.pixels()) z = std::clamp(z, 0.03 - 0.004, 0.03);
    const auto normals = plane_fit_normals(gel, camera, radius);
    Image<Rgb8> expected(width, height);
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          double light = 0.8;
          for (const auto& l : lights) {
            light += l.rgb[c] * phong<double>(normals(x, y), -l.direction(x, y),
                                              -camera.ray(x, y).normalized(), 1.0, 0.5, 5);
          }
          const double pressed = std::clamp((rest(x, y) - gel(x, y)) / 0.002, 0.0, 1.0);
          const double inner = 0.4 * 0.9 * light * colours(x, y)[c] * (1 - 0.3 * pressed);
          const double outer = 0.25 * 0.6 * visual(x, y)[c];
          expected(x, y)[c] = to_level(1.5 * (inner + outer));
        }
      }
    }
    CHECK(worst(image, expected) <= 1);
    std::size_t off = 0;
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      off += image.pixels()[i] != expected.pixels()[i];
    }
    CHECK(off <= 4);  // sums that a rounding carries over a level
  }
}

TEST_CASE_TEMPLATE("lights straight along a flat gel do not light it, nor make it gloss", T, float,
                   double) {
  for (const T f : {T(40), T(333), T(4000)}) {
    for (const Index radius : {1, 2, 4}) {
      for (const T z : {T(0.03), T(1.7)}) {
        const Camera<T> seen{f, f, T(79.5), T(40), 160, 90};
        const Image<T> flat(160, 90, z), plate(160, 90, z * T(0.97));
        SeeThroughOptions options{.normal_radius = radius, .darkening = 0};
        options.levels = LightLevels::tactile();
        options.thickness = 1e-3;
        const SeeThroughRenderer<T> renderer(seen, flat, edge_lights(seen, 0.0),
                                             std::array<T, 3>{T(0.7), T(0.7), T(0.8)}, options);
        // Ambient light 0.8, reflectance 0.5, exposure 2: 255 0.8 0.7 and 255 0.8 0.8.
        const Image<Rgb8> expected(160, 90, Rgb8{142, 142, 163});
        CHECK(worst(renderer.rest_image(), expected) == 0);
        CHECK(worst(renderer.render(plate), expected) == 0);
      }
    }
  }
}

TEST_CASE("a flat gel under lights from its edges, in closed form") {
  const auto lights = edge_lights(camera, 0.25);
  CHECK(lights.size() == 4);
  for (const auto& light : lights) {
    CHECK(light.diffuse == 1);
    CHECK(light.specular == 0.5);
    CHECK(light.shininess == 5);
    CHECK(light.direction(3, 4).norm() == gelight::test::approx(1).epsilon(1e-15));
    CHECK(light.direction(3, 4).z() == gelight::test::approx(std::sin(0.25)).epsilon(1e-15));
  }
  const Camera<double> odd{60, 60, 20, 20, 41, 41};
  const SeeThroughRenderer renderer(
      odd, Image<double>(41, 41, 0.03), edge_lights(odd, 0.25),
      std::array<double, 3>{0.5, 0.5, 0.5},
      SeeThroughOptions{
          .reflectance = 1, .transmittance = 0, .exposure = 1, .levels = LightLevels::tactile()});
  // On the axis N.L is the sine of the tilt, and so is R.V. A colour has its own light and white.
  const double one = std::sin(0.25) + 0.5 * std::pow(std::sin(0.25), 5);
  const auto level = to_level(0.5 * (0.8 + 2 * one));
  CHECK(renderer.rest_image()(20, 20) == Rgb8{level, level, level});
  // Off the axis red shines towards the left edge's eye ray, and away from the right one's.
  CHECK(renderer.rest_image()(0, 20)[0] != renderer.rest_image()(40, 20)[0]);
}

TEST_CASE("dark inside: the visual image, bit for bit; dark outside: it does not matter") {
  const SeeThroughRenderer renderer(camera, rest, edge_lights(camera, 0.2));
  const SeeThroughRenderer of_float(camera.cast<float>(), rest,
                                    edge_lights(camera.cast<float>(), 0.2));
  const auto visual = levels_of_grey();
  CHECK(renderer.render(ball(0.002), visual, LightLevels::visual()) == visual);
  CHECK(of_float.render(ball(0.002), visual, LightLevels::visual()) == visual);
  CHECK(renderer.render(ball(0.002), visual, {0.5, 0}) == renderer.render(ball(0.002)));
  CHECK(renderer.options().levels.inner == LightLevels::visuotactile().inner);
  CHECK(renderer.render(rest) == renderer.rest_image());
}

TEST_CASE("as the LEDs dim, the tactile image fades out of the visuotactile one") {
  const SeeThroughRenderer renderer(camera, rest, edge_lights(camera, 0.2),
                                    std::array<double, 3>{0.4, 0.4, 0.4});
  const Image<double> visual(width, height, 0.2);
  const auto contact = ball(0.003);
  const auto tactile = renderer.render(contact, visual, LightLevels::tactile());
  Image<Rgb8> before = renderer.render(contact, visual, {1, 1});
  for (int step = 19; step >= 0; --step) {
    const double inner = step / 20.0;
    const auto image = renderer.render(contact, visual, {inner, 1});
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const int level = image.pixels()[i][c];
        CHECK(level <= before.pixels()[i][c]);
        // Two levels: tactile was truncated, and the sum is.
        if (tactile.pixels()[i][c] < 255) {
          CHECK(std::abs(level - std::min(255.0, inner * tactile.pixels()[i][c] + 51)) <= 2);
        }
      }
    }
    before = image;
  }
  CHECK(before == renderer.render(contact, visual, LightLevels::visual()));
}

TEST_CASE("the coating gives no more light than it gets") {
  const Image<std::array<double, 3>> white(width, height, {1, 1, 1});
  const auto options = [](double r, double t) {
    return SeeThroughOptions{.ambient = 1,
                             .darkening = 0,
                             .reflectance = r,
                             .transmittance = t,
                             .exposure = 1,
                             .levels = {1, 1}};
  };
  for (const auto& [r, t] : {std::pair{0.5, 0.5}, {0.3, 0.6}, {0.0, 1.0}, {1.0, 0.0}, {0.2, 0.1}}) {
    const SeeThroughRenderer renderer(camera, rest, std::vector<Light<double>>{}, white,
                                      options(r, t));
    // Full and even light on either side: all that leaves the coating for the camera is r + t.
    const int level = renderer.render(ball(0.003), white)(30, 25)[1];
    CHECK(std::abs(level - 255 * (r + t)) <= 1);
    CHECK(level <= 255 * (r + t));
  }
  const auto message = [&](double r, double t) {
    return refusal([&] {
      SeeThroughRenderer(camera, rest, std::vector<Light<double>>{}, white, options(r, t));
    });
  };
  CHECK(message(0.6, 0.5) == "reflectance 0.6 and transmittance 0.5 are more than 1");
  CHECK(message(-0.5, 0.5) == "reflectance -0.5 is not in [0, 1]");
  CHECK(message(0.5, 1.5) == "transmittance 1.5 is not in [0, 1]");
}

TEST_CASE("the depth is clipped to the gel") {
  const SeeThroughRenderer renderer(camera, rest, edge_lights(camera, 0.2));
  auto deep = ball(0.005), deeper = ball(0.005);
  for (Index x = 28; x < 33; ++x) {
    deep(x, 25) = 0.03 - 0.005;
    deeper(x, 25) = 0.001;
  }
  CHECK(renderer.render(deep) == renderer.render(deeper));
  CHECK(renderer.render(deep) != renderer.rest_image());
  CHECK(renderer.render(Image<double>(width, height, inf)) == renderer.rest_image());
  CHECK(renderer.render(Image<double>(width, height, 0.5)) == renderer.rest_image());
  // Pressed in evenly to its end the gel is flat, and darker.
  const SeeThroughRenderer plain(camera, rest, edge_lights(camera, 0.2),
                                 std::array<double, 3>{0.5, 0.5, 0.5},
                                 SeeThroughOptions{.darkening = 0, .levels = {1, 1}});
  CHECK(worst(plain.render(Image<double>(width, height, 0.01)), plain.rest_image()) <= 1);
}

TEST_CASE("pressed gel loses a share of its light, and that only") {
  const std::array<double, 3> grey{0.6, 0.6, 0.6};
  const auto make = [&](double darkening) {
    return SeeThroughRenderer(
        camera, rest, std::vector<Light<double>>{}, grey,
        SeeThroughOptions{.ambient = 1, .darkening = darkening, .levels = {1, 1}});
  };
  const Image<double> visual(width, height, 0.25);
  const auto contact = ball(0.003);
  const auto image = make(0.4).render(contact, visual);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      const double pressed = std::max(0.0, 0.03 - contact(x, y));
      const double want = 0.6 * (1 - 0.4 * std::min(1.0, pressed / 0.002)) + 0.25;
      CHECK(std::abs(image(x, y)[0] - (255 * want - 0.5)) <= 1);
    }
  }
  CHECK(make(0.4).rest_image() == make(0).rest_image());
}

TEST_CASE("unknown depths show ambient light, and disturb no normals but their neighbours'") {
  const SeeThroughOptions options{.levels = LightLevels::tactile()};
  const std::array<double, 3> grey{0.5, 0.5, 0.5};
  const SeeThroughRenderer renderer(camera, rest, edge_lights(camera, 0.2), grey, options);
  const auto whole = renderer.render(ball(0.003));
  for (const double bad : {unknown, -inf, 0.0, -0.01}) {
    auto contact = ball(0.003);
    contact(32, 27) = contact(33, 27) = contact(60, 50) = bad;
    const auto image = renderer.render(contact);
    const auto ambient = to_level(0.8 * 0.5);
    CHECK(image(32, 27) == Rgb8{ambient, ambient, ambient});
    CHECK(image(60, 50) == Rgb8{ambient, ambient, ambient});
    for (Index y = 0; y < height; ++y) {
      for (Index x = 0; x < width; ++x) {
        const bool near_ball = x >= 30 && x <= 35 && std::abs(y - 27) <= 2;
        const bool near_rest = std::abs(x - 60) <= 2 && std::abs(y - 50) <= 2;
        if (near_ball || (x == 60 && y == 50)) continue;
        // A plane with a hole is the same plane.
        for (std::size_t c = 0; c < 3; ++c) {
          CHECK(std::abs(image(x, y)[c] - whole(x, y)[c]) <= (near_rest ? 1 : 0));
        }
      }
    }
  }
}

TEST_CASE("outside the membrane there is ambient light; its own depth there does not matter") {
  auto masked = rest;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if ((x - 36) * (x - 36) + (y - 28) * (y - 28) > 26 * 26) masked(x, y) = unknown;
    }
  }
  const SeeThroughRenderer renderer(camera, masked, edge_lights(camera, 0.2),
                                    std::array<double, 3>{0.5, 0.5, 0.5},
                                    SeeThroughOptions{.levels = LightLevels::tactile()});
  const auto contact = ball(0.003, 15, 20);
  auto garbage = contact;
  for (std::size_t i = 0; i < garbage.pixels().size(); ++i) {
    if (std::isnan(masked.pixels()[i])) garbage.pixels()[i] = 0.001;
  }
  CHECK(renderer.render(contact) == renderer.render(garbage));
  const auto ambient = to_level(0.8 * 0.5);
  CHECK(renderer.render(contact)(0, 0) == Rgb8{ambient, ambient, ambient});
}

TEST_CASE("float is within a level of double; grey, byte and foreign images; a strided output") {
  const SeeThroughRenderer exact(camera, rest, edge_lights(camera, 0.2), picture());
  const auto eye = camera.cast<float>();
  const SeeThroughRenderer renderer(eye, rest, edge_lights(eye, 0.2), picture());
  const auto contact = ball(0.003);
  CHECK(worst(renderer.render(contact, picture()), exact.render(contact, picture())) <= 1);
  const Image<std::uint8_t> bytes(width, height, 51);
  const Image<float> shares(width, height, 0.2f);
  CHECK(worst(renderer.render(contact, bytes), renderer.render(contact, shares)) <= 1);

  Image<Rgb8> tall(height, width);
  renderer.render_into(tall.view().transposed(), contact, bytes);
  const auto packed = renderer.render(contact, bytes);
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) CHECK(tall(y, x) == packed(x, y));
  }
}

TEST_CASE("several threads share a renderer") {
  const SeeThroughRenderer renderer(camera, rest, edge_lights(camera, 0.2));
  const auto visual = picture();
  std::vector<Image<Rgb8>> images(4);
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < 4; ++k) {
      threads.emplace_back([&, k] {
        images[static_cast<std::size_t>(k)] = renderer.render(ball(0.001 * k), visual);
      });
    }
  }
  const auto copy = renderer;
  for (int k = 0; k < 4; ++k) {
    CHECK(images[static_cast<std::size_t>(k)] == copy.render(ball(0.001 * k), visual));
  }
}

TEST_CASE("an image of one pixel, and without lights") {
  const Camera<double> eye{50, 50, 0, 0, 1, 1};
  const Image<double> one(1, 1, 0.03);
  const SeeThroughRenderer renderer(eye, one, edge_lights(eye, 0.2),
                                    std::array<double, 3>{0.5, 0.5, 0.5},
                                    SeeThroughOptions{.levels = {1, 0}});
  // One point has no plane: ambient light.
  CHECK(renderer.render(Image<double>(1, 1, 0.02))(0, 0)[0] == to_level(0.8 * 0.8 * 0.5));
}

TEST_CASE_TEMPLATE("however strong the light, black stays black, or the light is refused", T, float,
                   double) {
  const auto eye = camera.cast<T>();
  const auto lights = edge_lights(eye, 0.2);
  const std::array<T, 3> blue{0, 0, T(0.5)};
  const Image<float> black(width, height, 0);
  const auto dark = SeeThroughRenderer(eye, rest, lights, blue).render(rest, black, {0.5, 0});
  int answered = 0;
  for (const double much : {1e3, 1e30, 1e35, 1e36, 1e38, 1e39, 1e300, 1e305, 1e306, 1e308}) {
    CAPTURE(much);
    const SeeThroughRenderer renderer(eye, rest, lights, blue);
    Image<Rgb8> out(width, height, {1, 2, 3});
    const auto before = out;
    const auto beyond = refusal([&] {
      renderer.render_into(out, rest, black, LightLevels{0.5, much});
    });
    if (beyond == "accepted") {
      CHECK(out == dark);
      ++answered;
    } else {
      CHECK(out == before);
      CHECK(test::contains(beyond, "more than the images' type can hold"));
    }
    for (const auto& options : {SeeThroughOptions{.exposure = much}, {.levels = {much, 0}}}) {
      const auto inside = refusal([&] {
        out = SeeThroughRenderer(eye, rest, lights, blue, options).render(rest, black);
        for (const Rgb8& pixel : out.pixels()) REQUIRE(pixel == Rgb8{0, 0, 255});
      });
      CHECK(
          (inside == "accepted" || test::contains(inside, "more than the images' type can hold")));
    }
    if (much > double{std::numeric_limits<T>::max()}) continue;
    auto strong = lights;
    for (auto& light : strong) light.diffuse = light.specular = static_cast<T>(much);
    const auto lit = refusal([&] {
      out = SeeThroughRenderer(eye, rest, strong, blue).render(rest, black);
      for (const Rgb8& pixel : out.pixels()) REQUIRE((pixel[0] == 0 && pixel[1] == 0));
      const Image<float> white(width, height, 1);
      out = SeeThroughRenderer(eye, rest, strong, blue).render(rest, white);
      for (const Rgb8& pixel : out.pixels()) REQUIRE((pixel[0] > 0 && pixel[1] > 0));
    });
    CHECK((lit == "accepted" || test::contains(lit, "more than the images' type can hold")));
  }
  CHECK(answered >= 3);
}

TEST_CASE("normals are fitted to the whole image, however much larger a radius is") {
  const auto pressed = ball(0.004);
  const auto with = [&](Index radius) {
    return SeeThroughRenderer(camera, rest, edge_lights(camera, 0.2),
                              std::array<double, 3>{0.7, 0.7, 0.8},
                              SeeThroughOptions{.normal_radius = radius})
        .render(pressed);
  };
  const auto whole = with(std::max(width, height));
  for (const Index radius :
       {1000, std::numeric_limits<Index>::max() - width / 2, std::numeric_limits<Index>::max()}) {
    CHECK(with(radius) == whole);
  }
}

TEST_CASE("input that cannot be used is refused before anything is written") {
  const auto lights = edge_lights(camera, 0.2);
  const std::array<double, 3> grey{0.5, 0.5, 0.5};
  const auto message = [&](const SeeThroughOptions& options) {
    return refusal([&] { SeeThroughRenderer(camera, rest, lights, grey, options); });
  };
  CHECK(message({.thickness = -0.5}) == "thickness -0.5 is not positive");
  CHECK(message({.thickness = unknown}) == "thickness nan is not positive");
  CHECK(message({.normal_radius = 0}) == "normal radius 0 is not at least 1");
  CHECK(message({.ambient = inf}) == "ambient inf is not finite");
  CHECK(message({.darkening = 1.5}) == "darkening 1.5 is not in [0, 1]");
  CHECK(message({.darkening_depth = 0}) == "darkening depth 0 is not positive");
  CHECK(message({.darkening_depth = 5e-324}).find("is not large enough to divide by") !=
        std::string::npos);
  CHECK(message({.exposure = -1}) == "exposure -1 is not positive and finite");
  CHECK(message({.levels = {-1, 0}}) == "inner light level -1 is negative or not finite");
  CHECK_THROWS_AS(SeeThroughRenderer(camera, Image<double>(3, 3, 0.03), lights), InvalidInput);
  CHECK_THROWS_AS(
      SeeThroughRenderer(camera, rest, edge_lights(Camera<double>{1, 1, 0, 0, 3, 3}, 0)),
      InvalidInput);
  CHECK_THROWS_AS(SeeThroughRenderer(Camera<double>{0, 1, 0, 0, 4, 4}, rest, lights), InvalidInput);
  CHECK_THROWS_AS((void)edge_lights(camera, -0.1), InvalidInput);
  auto dim = lights;
  dim[1].diffuse = unknown;
  CHECK(refusal([&] { SeeThroughRenderer(camera, rest, dim); }) ==
        "light 1 has diffuse coefficient nan, which is not finite");

  const SeeThroughRenderer renderer(camera, rest, lights);
  Image<Rgb8> out(width, height, {1, 2, 3}), before = out;
  const Image<double> small(3, 3, 0.03);
  CHECK_THROWS_AS(renderer.render_into(out, small), InvalidInput);
  CHECK_THROWS_AS(renderer.render_into(out, rest, Image<Rgb8>(3, 3)), InvalidInput);
  CHECK_THROWS_AS(renderer.render_into(out, rest, picture(), {1, unknown}), InvalidInput);
  CHECK(refusal([&] { renderer.render_into(out, rest, out); }) ==
        "the output image lies in the memory of the visual image");
  CHECK(out == before);
  Image<Rgb8> narrow(width - 1, height);
  CHECK_THROWS_AS(renderer.render_into(narrow, rest), InvalidInput);
}

TEST_CASE_TEMPLATE("what is seen beyond is refused by pixel where it is no share of full light", T,
                   float, double) {
  const auto eye = camera.cast<T>();
  const SeeThroughRenderer renderer(eye, rest, edge_lights(eye, T(0.2)));
  std::mt19937 random(7);
  Image<Rgb8> out(width, height, {1, 2, 3});
  const auto before = out;
  for (const double bad : {unknown, inf, -inf, -1e-6, 1.01, 255.0, 1e30}) {
    const auto u = static_cast<Index>(random() % width), v = static_cast<Index>(random() % height);
    const auto place = "at pixel (" + std::to_string(u) + ", " + std::to_string(v) + ") is (";
    const auto said = [&](const auto& visual, const LightLevels& levels) {
      return refusal([&] { renderer.render_into(out, rest, visual, levels); });
    };
    CAPTURE(bad);
    auto rgb = picture();
    rgb(u, v)[random() % 3] = bad;
    CHECK(test::contains(said(rgb, {0.5, 0.5}), place));
    CHECK(test::contains(said(rgb, LightLevels::visual()), "not in shares of full light"));
    Image<float> grey(width, height, 0.5F);
    grey(u, v) = static_cast<float>(bad);
    CHECK(test::contains(said(grey, {0.1, 1}), place));
    CHECK(out == before);
    // What the dark hides does no harm.
    CHECK(said(rgb, LightLevels::tactile()) == "accepted");
    out = before;
  }
  // White that went through a resizing, and black with a sign.
  auto rounded = picture();
  rounded(3, 4) = {1.001, -0.0, 1};
  CHECK(refusal([&] { renderer.render_into(out, rest, rounded); }) == "accepted");
}

TEST_CASE_TEMPLATE("beside holes no pixel's light hangs on a rounding", T, float, double) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> one(0, 1);
  const auto eye = camera.cast<T>();
  for (const double known : {0.15, 0.3, 0.6, 0.9}) {
    for (const Index radius : {1, 2}) {
      const SeeThroughOptions options{.thickness = 0.02, .normal_radius = radius};
      const std::array<T, 3> colour{T(0.7), T(0.7), T(0.8)};
      const SeeThroughRenderer renderer(eye, rest, edge_lights(eye, T(0.3)), colour, options);
      auto contact = ball(0.01, 35, 27, 20);
      for (double& z : contact.pixels()) {
        z = one(random) < known ? z - 1e-4 * one(random) : unknown;
      }
      auto beside = contact;
      for (double& z : beside.pixels()) {
        z *= 1 + 4 * double{std::numeric_limits<T>::epsilon()} * (one(random) - 0.5);
      }
      CHECK(worst(renderer.render(contact), renderer.render(beside)) <= 1);
    }
  }
}
