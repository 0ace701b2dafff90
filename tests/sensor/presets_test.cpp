#include "gelight/sensor/presets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gelight/image/raster.hpp"
#include "gelight/mesh/shapes.hpp"
#include "support/approx.hpp"
#include "support/hard_meshes.hpp"
#include "support/refusal.hpp"

using namespace gelight;

TEST_CASE_TEMPLATE("the GelTip's parts fit together", T, float, double) {
  const auto sensor = geltip<T>(160, 120);
  const Surface<T> surface(sensor.membrane);

  // Three LEDs on the rim of the open end, a third of a turn apart, on edges or at vertices.
  REQUIRE(sensor.leds.size() == 3);
  const T radius = T(0.01146), sag = T(0.001 * 0.001) / (8 * radius);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3<T> p = surface.position(sensor.leds[k]);
    CHECK(p.z() == 0);
    CHECK(p.norm() <= radius * T(1.000001));
    CHECK(p.norm() >= radius - 2 * sag);
    const double turn = std::remainder(
        std::atan2(p.y(), p.x()) - 2 * std::numbers::pi / 3 * double(k), 2 * std::numbers::pi);
    CHECK(std::abs(turn) < 1e-5);
  }

  // The camera sees the tip in the middle of its image, and the membrane or its open end elsewhere.
  CHECK(sensor.camera.fy == gelight::test::approx(60));
  const auto rest = rasterize(sensor.membrane, sensor.camera);
  CHECK(rest.depth(80, 60) == gelight::test::approx(0.0455).epsilon(1e-3));
  for (Index u = 0; u < 160; ++u) {
    const T slope = std::hypot((T(u) - sensor.camera.cx) / 60, (60 - sensor.camera.cy) / 60);
    const T wall = radius / slope;  // where the ray meets the cylinder
    if (wall > T(0.034)) continue;
    CHECK(rest.depth(u, 60) == gelight::test::approx(wall).epsilon(5e-3));
  }
}

TEST_CASE("LEDs follow the mesh that they are put on") {
  const auto tip = geltip<double>(32, 24, 0.002);
  std::vector<double> angles;
  for (int k = 0; k < 8; ++k) angles.push_back(0.3 + 0.7 * k);
  const auto leds = leds_on_border(tip.membrane, angles);
  // The same membrane, thrice as large, somewhere else, its vertices in another order.
  Mesh<double> other = tip.membrane;
  std::reverse(other.positions.begin(), other.positions.end());
  const auto last = static_cast<Index>(other.positions.size()) - 1;
  for (auto& p : other.positions) p = {3 * p[0] + 1, 3 * p[1] - 2, 3 * p[2] + 5};
  for (auto& face : other.faces) {
    for (Index& v : face) v = last - v;
  }
  const auto moved = leds_on_border(other, angles);
  const Surface<double> surface(tip.membrane);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    CHECK(moved[k].element[0] == last - leds[k].element[0]);
    const Vec3<double> p = surface.position(leds[k]);
    CHECK(p.z() == 0);
    const double apart = std::remainder(std::atan2(p.y(), p.x()) - angles[k], 2 * std::numbers::pi);
    CHECK(std::abs(apart) <= 0.5001 * 0.002 / 0.01146);
  }
  CHECK_THROWS_WITH_AS((void)leds_on_border(icosphere<double>(1), angles),
                       "the membrane has no border to put LEDs on", InvalidInput);
}

TEST_CASE("points of the border are where they are, whatever the mesh") {
  const std::vector<double> angles{-3, -1.1, 0, 0.4, 2.5};
  for (const double edge : {0.0005, 0.0013, 0.004}) {
    const auto tip = membrane<double>(0.01146, 0.0455, edge);
    const Surface<double> surface(tip);
    const auto leds = points_of_border(tip, angles);
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const Vec3<double> p = surface.position(leds[k]);
      CHECK(std::atan2(p.y(), p.x()) == gelight::test::approx(angles[k]).epsilon(1e-9).scale(1));
      CHECK(std::abs(p.norm() - 0.01146) <= edge * edge / (8 * 0.01146) * 1.3);
      CHECK(p.z() == 0);
      // Parts of an LED, along the circle.
      const double width = 0.006;
      const auto parts = points_along_border(surface, leds[k], width, 4);
      REQUIRE(parts.size() == 4);
      std::vector<double> turns;
      for (const auto& part : parts) {
        const Vec3<double> q = surface.position(part);
        turns.push_back(std::remainder(std::atan2(q.y(), q.x()) - angles[k], 2 * std::numbers::pi));
      }
      std::sort(turns.begin(), turns.end());
      for (std::size_t i = 0; i < 4; ++i) {
        const double truth = ((double(i) + 0.5) / 4 - 0.5) * width / 0.01146;
        CHECK(std::abs(turns[i] - truth) < 0.02 * edge / 0.001);
      }
    }
  }
  CHECK(test::refusal([&] { (void)points_of_border(icosphere<double>(1), angles); }) ==
        "the membrane has no border to put LEDs on");
  const Surface<double> sheet(grid<double>(4, 4));
  CHECK(test::refusal([&] {
          (void)points_along_border<double>(sheet, vertex_point<double>(12), 0.1, 3);
        }) == "the LED's middle is not on the border of the membrane");
  CHECK(test::contains(test::refusal([&] {
                         (void)points_along_border<double>(sheet, vertex_point<double>(0), 3, 3);
                       }),
                       "an LED 3 wide"));
}

TEST_CASE("parts of an LED lie evenly along any border") {
  // Two sheets: of the first, which has a hole, the border is of edges long, short and of no
  // length; faces are oriented any way. Some corners of both are one vertex.
  test::Random random(4);
  for (int kind = 0; kind < 40; ++kind) {
    Mesh<double> mesh = grid<double>(6, 6, 6, 6);
    std::erase_if(mesh.faces, [](const auto& face) {
      return std::find(face.begin(), face.end(), 24) != face.end();
    });
    const Mesh<double> second = grid<double>(2, 2, 2, 2);
    std::vector<Index> now(second.positions.size());
    for (std::size_t v = 0; v < now.size(); ++v) {
      now[v] = v == 0 ? 48 : static_cast<Index>(mesh.positions.size());
      if (v == 0) continue;
      const auto [x, y, z] = second.positions[v];
      mesh.positions.push_back({x + 6, y + 6, z});
    }
    for (const auto& [a, b, c] : second.faces) {
      const auto of = [&](Index v) { return now[static_cast<std::size_t>(v)]; };
      mesh.faces.push_back({of(a), of(b), of(c)});
    }
    // Along the lower side, x of vertices 1 to 5 is at 0, 1e-9 or anywhere in order.
    std::vector<double> xs;
    for (int i = 1; i <= 5; ++i) xs.push_back(test::uniform(random, 0, 6));
    if (kind % 2 == 0) xs[0] = 0, xs[1] = kind % 4 == 0 ? 1e-9 : 0;
    std::sort(xs.begin(), xs.end());
    for (std::size_t i = 0; i < 5; ++i) mesh.positions[i + 1][0] = xs[i];
    for (auto& face : mesh.faces) {
      if (test::uniform(random, 0, 1) < 0.4) std::swap(face[0], face[1]);
    }
    const Surface<double> surface(mesh);
    const double width = test::uniform(random, 0, 10);
    const Index count = 1 + kind % 7;
    for (const auto& middle : {vertex_point<double>(0), edge_point<double>(0, 1, 0.3),
                               edge_point<double>(1, 0, 1), edge_point<double>(7, 0, 0.2)}) {
      const auto points = points_along_border(surface, middle, width, count);
      // Round the square, from its corner at the origin.
      const auto turns = [&](const SurfacePoint<double>& point) {
        const Vec3<double> p = surface.position(point);
        const auto is = [](double x, double y) { return std::abs(x - y) < 1e-12; };
        CHECK((is(p.x(), 0) || is(p.y(), 0) || is(p.x(), 6) || is(p.y(), 6)));
        if (is(p.y(), 0)) return p.x();
        if (is(p.x(), 6)) return 6 + p.y();
        return is(p.y(), 6) ? 18 - p.x() : 24 - p.y();
      };
      REQUIRE(std::ssize(points) == count);
      std::vector<double> along;
      for (const auto& point : points) {
        along.push_back(std::remainder(turns(point) - turns(middle), 24));
      }
      std::sort(along.begin(), along.end());
      for (std::size_t i = 0; i < along.size(); ++i) {
        const double truth = width * ((double(i) + 0.5) / count - 0.5);
        CHECK(std::abs(along[i] - truth) < 1e-12);
      }
    }
    // The hole's border is 6.8 long, by which its LEDs are bounded.
    CHECK(test::contains(test::refusal([&] {
                           (void)points_along_border<double>(surface, vertex_point<double>(23), 5,
                                                             2);
                         }),
                         "an LED 5 wide"));
  }
}

TEST_CASE("a wide LED has a seam of so many steps as it has parts") {
  auto sensor = geltip<double>(16, 12, 0.001);
  const Surface<double> surface(sensor.membrane);
  // Beside the line opposite the LED, 0.01 radians to either side: light comes round either way.
  std::vector<SurfacePoint<double>> points;
  for (const double turn : {-0.02, 0.02}) {
    const double angle = std::numbers::pi + turn;
    points.push_back(nearest_point(
        surface, Vec3<double>(0.01146 * std::cos(angle), 0.01146 * std::sin(angle), 0.012)));
  }
  const GeodesicLight<double> model(surface);
  const auto jump = [&] {
    const auto field = led_field(sensor, surface, 0, model, points);
    return (field[0] - field[1]).y();
  };
  sensor.led_width = 0;
  const double of_point = std::abs(jump());
  // On a cylinder laid flat the light comes at atan(pi R / z) to the axis, from either side.
  const double truth = 2 * std::sin(std::atan(std::numbers::pi * 0.01146 / 0.012));
  CHECK(of_point == gelight::test::approx(truth).epsilon(0.02));
  sensor.led_width = 0.003;
  for (const Index parts : {3, 5}) {
    sensor.led_parts = parts;
    CHECK(std::abs(jump()) == gelight::test::approx(truth / parts).epsilon(0.1));
  }
}

TEST_CASE("every preset shows a lit and coloured membrane, and where something touches it") {
  struct Shown {
    const char* name;
    SensorPreset<float> sensor;
    Vec3<double> ball;  // of 4 mm, where it is pressed in
  };
  const std::vector<Shown> all{{"geltip", geltip(160, 120, 0.002f), {-0.0138, -0.003, 0.026}},
                               {"mini", gelsight_mini(160, 120, 0.002f), {0.002, 0.001, 0.023}},
                               {"digit", digit(120, 160, 0.002f), {0.002, 0.001, 0.025}},
                               {"sts", sts(160, 120, 0.002f), {0.002, 0.001, 0.033}}};
  const auto ball = icosphere<float>(3, 0.004f);
  for (const Shown& shown : all) {
    CAPTURE(shown.name);
    const auto& sensor = shown.sensor;
    const auto renderer = tactile_renderer(sensor);
    const Image<Rgb8>& rest = renderer.rest_image();
    // Neither black nor white nor grey.
    std::size_t lit = 0, coloured = 0;
    for (const Rgb8& p : rest.pixels()) {
      const auto [least, most] = std::minmax({p[0], p[1], p[2]});
      lit += most > 40 && most < 255 ? 1 : 0;
      coloured += most - least > 20 ? 1 : 0;
    }
    const std::size_t count = rest.pixels().size();
    CHECK(lit > count * 9 / 10);
    CHECK(coloured > count / 2);
    // An object as the camera sees it, nothing else in the image: it is where it touches.
    Mesh<float> moved = ball;
    for (auto& p : moved.positions) {
      for (std::size_t c = 0; c < 3; ++c)
        p[c] += static_cast<float>(shown.ball[static_cast<Index>(c)]);
    }
    const auto seen = rasterize(moved, sensor.camera);
    const auto image = renderer.render(seen.depth);
    const auto depth = rasterize(sensor.membrane, sensor.camera).depth;
    std::size_t brighter = 0;
    for (Index y = 0; y < rest.height(); ++y) {
      for (Index x = 0; x < rest.width(); ++x) {
        int change = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          change = std::max(change, std::abs(image(x, y)[c] - rest(x, y)[c]));
        }
        brighter += change > 40 ? 1 : 0;
        bool near = false;  // within the Gaussian's reach and the normals' pixel
        for (Index v = std::max(0, y - 21); v <= std::min(rest.height() - 1, y + 21); ++v) {
          for (Index u = std::max(0, x - 21); u <= std::min(rest.width() - 1, x + 21); ++u) {
            near = near || seen.depth(u, v) < depth(u, v);
          }
        }
        if (!near) REQUIRE(change == 0);
      }
    }
    CHECK(brighter > 10);
  }
}

TEST_CASE_TEMPLATE("light straight along a flat pad lights nothing at rest, whatever its rounding",
                   T, float, double) {
  // It arrives in the pad's plane, where the gloss begins at once: of the sign of rounding it would
  // make specks.
  for (const auto& sensor : {sts<T>(320, 240), gelsight_mini<T>(320, 240)}) {
    const auto straight = tactile_renderer(sensor, LinearLight<T>(sensor.membrane)).rest_image();
    const auto tangent = tactile_renderer(sensor).rest_image();
    int worst = 0;
    for (std::size_t i = 0; i < tangent.pixels().size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const int level = straight.pixels()[i][c], of_coating = tangent.pixels()[i][c];
        worst = std::max(worst, std::abs(level - of_coating));
      }
    }
    CHECK(worst <= 1);
  }
}

TEST_CASE("light through the gel has no hard edge and no frame") {
  auto tip = geltip<float>(160, 120, 0.002f);
  auto pad = digit<float>(72, 96, 0.001f);
  // With nothing but their light.
  tip.coating = pad.coating = {0, 0, 0};
  const auto largest_step = [](const Image<Rgb8>& image) {
    int most = 0;
    for (Index y = 0; y < image.height(); ++y) {
      for (Index x = 1; x < image.width(); ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          most = std::max(most, std::abs(int{image(x, y)[c]} - int{image(x - 1, y)[c]}));
        }
      }
    }
    return most;
  };
  const auto rest = [](const SensorPreset<float>& sensor) {
    const GelLight<float> light(sensor.membrane, {.thickness = 0.004f, .full_within = 0.02f});
    return tactile_renderer(sensor, light).rest_image();
  };
  // A point's shadow begins within a pixel; that of an LED with a width nowhere half so hard.
  auto points = tip;
  points.led_width = 0;
  CHECK(2 * largest_step(rest(tip)) < largest_step(rest(points)));
  // Light of the outermost columns, as a share of those beside them.
  const auto at_border = [](const Image<Rgb8>& image) {
    double outer = 0, inner = 0;
    for (Index y = 0; y < image.height(); ++y) {
      for (std::size_t c = 0; c < 3; ++c) {
        outer += image(0, y)[c] + image(image.width() - 1, y)[c];
        inner += image(1, y)[c] + image(image.width() - 2, y)[c];
      }
    }
    return outer / inner;
  };
  CHECK(at_border(rest(pad)) == gelight::test::approx(1).epsilon(0.05));
  pad.options.border_normals = BorderNormals::none;
  CHECK(at_border(rest(pad)) < 0.8);
}

TEST_CASE(
    "no preset is burnt out by any light, at rest it looks the same by all, and presses show") {
  const std::vector sensors{geltip<float>(80, 60, 0.003f), gelsight_mini<float>(80, 60, 0.001f),
                            digit<float>(60, 80, 0.0015f), sts<float>(80, 60, 0.002f)};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    CAPTURE(i);
    const auto& sensor = sensors[i];
    const auto raster = rasterize(sensor.membrane, sensor.camera);
    const auto tangent = tactile_renderer(sensor).rest_image();
    const auto check = [&](const auto& renderer, bool is_gel) {
      const auto rest = renderer.rest_image();
      Index clipped = 0, brighter = 0;
      for (std::size_t k = 0; k < rest.pixels().size(); ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          const int of_coating = tangent.pixels()[k][c], level = rest.pixels()[k][c];
          if (is_gel) CHECK(level >= of_coating - 1);  // both are truncated
          brighter += Index{level > of_coating + 1};
          clipped += Index{level == 255};
        }
      }
      const auto all = static_cast<Index>(3 * rest.pixels().size());
      CHECK(50 * clipped < all);
      if (is_gel) CHECK(5 * brighter < all);
      // A ball that comes 0.7 mm into the membrane, off the axis.
      const Index x = sensor.camera.width / 4, y = sensor.camera.height / 2;
      const Surface<float> surface(sensor.membrane);
      Vec3<float> out = detail::face_normal(surface, raster.face(x, y));
      const Vec3<float> ray = sensor.camera.ray(float(x), float(y));
      if (out.dot(ray) < 0) out = -out;
      const Vec3<float> middle = raster.depth(x, y) * ray + 0.0033f * out;
      const auto ball =
          placed<float>(icosphere<float>(4, 0.004f), Eigen::Matrix3f::Identity(), middle);
      const auto image = renderer.render(rasterize(ball, sensor.camera).depth);
      int most = 0;
      for (std::size_t k = 0; k < rest.pixels().size(); ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          most = std::max(most, std::abs(int{image.pixels()[k][c]} - int{rest.pixels()[k][c]}));
        }
      }
      CHECK(most > 20);
    };
    check(tactile_renderer(sensor, gel_light(sensor)), true);
    check(tactile_renderer(sensor, LinearLight(sensor.membrane)), false);
    check(tactile_renderer(sensor), false);
    auto bright = sensor;
    bright.full_within = 0.02f;
    check(tactile_renderer(bright, gel_light(bright)), true);
  }
}

TEST_CASE("light in gel does not depend on which way a membrane's normals point") {
  for (auto sensor : {geltip<double>(32, 24, 0.004), gelsight_mini<double>(32, 24, 0.002),
                      digit<double>(24, 32, 0.003), sts<double>(32, 24, 0.004)}) {
    const auto light_of = [](const SensorPreset<double>& of) {
      const Surface<double> membrane(of.membrane);
      const auto points = vertex_points(membrane);
      return led_field(of, membrane, 0, gel_light(of), points);
    };
    const auto light = light_of(sensor);
    auto turned = sensor;
    for (auto& face : turned.membrane.faces) std::swap(face[0], face[1]);
    const auto by_turned = light_of(turned);
    double off = 0, most = 0;
    for (std::size_t v = 0; v < light.size(); ++v) {
      off = std::max(off, norm(by_turned[v] - light[v]));
      most = std::max(most, norm(light[v]));
    }
    CHECK(most > 0.5);
    CHECK(off < 1e-12);
    // Those that point this way and that say nothing.
    std::swap(sensor.membrane.faces[3][0], sensor.membrane.faces[3][1]);
    CHECK(test::refusal([&] { (void)gel_light(sensor); }).find("against each other") !=
          std::string::npos);
  }
}

TEST_CASE(
    "a specular term that takes light away has the coating make up for it, up to full light") {
  auto sensor = sts<double>(53, 41, 0.003);
  sensor.options.specular = Specular::unclamped;
  sensor.options.ambient = 0.6;
  sensor.options.border_normals = BorderNormals::none;
  const auto coating = coating_light(sensor, rasterize(sensor.membrane, sensor.camera));
  const auto rest = tactile_renderer(sensor, gel_light(sensor)).rest_image();
  Index full = 0;
  for (Index y = 0; y < 41; ++y) {
    for (Index x = 0; x < 53; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double wanted = 255 * 0.6 * coating.image()(x, y)[c], level = rest(x, y)[c];
        if (level >= wanted - 1.001) continue;
        // Full light is all that a coating has: as bright as that, less what is taken away.
        CHECK(wanted > 120);
        CHECK(level > 0.8 * wanted);
        ++full;
      }
    }
  }
  CHECK(full > 0);
  CHECK(full < 200);
}

TEST_CASE("a GelSight Mini's camera sees its pad everywhere, whatever the image's shape") {
  for (const auto& [width, height] :
       std::vector<std::array<Index, 2>>{{640, 480}, {160, 120}, {320, 180}, {96, 96}, {60, 80}}) {
    const auto sensor = gelsight_mini(width, height, 0.002f);
    const auto& faces = rasterize(sensor.membrane, sensor.camera).face.pixels();
    CHECK(std::ranges::count(faces, -1) == 0);
  }
}

TEST_CASE("in millimetres no light would arrive: that is said") {
  auto sensor = geltip(40, 30, 0.003f);
  for (auto& p : sensor.membrane.positions) {
    for (float& x : p) x *= 1000;
  }
  CHECK(test::refusal([&] { (void)tactile_renderer(sensor); }).find("metres") != std::string::npos);
}

TEST_CASE("a sensor without a colour for each LED is refused") {
  auto sensor = gelsight_mini(32, 24, 0.002f);
  sensor.colours.pop_back();
  CHECK_THROWS_WITH_AS((void)tactile_renderer(sensor), "there are 3 LEDs and 2 colours",
                       InvalidInput);
}

TEST_CASE("a coating that reflects no share of the light is refused, by any light") {
  for (const float bad :
       {-0.1f, 1.1f, std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    for (std::size_t c = 0; c < 3; ++c) {
      auto sensor = gelsight_mini(32, 24, 0.002f);
      sensor.coating[c] = bad;
      CAPTURE(bad);
      CHECK(test::contains(test::refusal([&] { (void)tactile_renderer(sensor); }),
                           "the coating reflects "));
      CHECK(
          test::contains(test::refusal([&] { (void)tactile_renderer(sensor, gel_light(sensor)); }),
                         "the coating reflects "));
    }
  }
}

TEST_CASE(
    "a sensor whose camera sees nothing of its membrane is refused, and an LED that it has not") {
  for (const float away : {-0.1f, 5.0f}) {
    auto sensor = gelsight_mini(32, 24, 0.002f);
    for (auto& p : sensor.membrane.positions) p[away < 0 ? 2 : 0] += away;
    CHECK(test::refusal([&] { (void)tactile_renderer(sensor, LinearLight(sensor.membrane)); }) ==
          "the camera sees nothing of the membrane");
  }
  const auto sensor = gelsight_mini(32, 24, 0.002f);
  const Surface<float> surface(sensor.membrane);
  const LinearLight light(sensor.membrane);
  CHECK(test::refusal([&] { (void)led_field(sensor, surface, 3, light, {}); }) ==
        "LED 3 of a sensor with 3");
  // A light model of one's own that forgets a point.
  struct Forgetful {
    std::vector<Vec3<float>> field(const Led<float>&, std::span<const SurfacePoint<float>> points,
                                   const CancelHook& = {}) const {
      return std::vector<Vec3<float>>(points.size() - 1, Vec3<float>(0, 0, 1));
    }
  };
  const std::vector points(4, vertex_point<float>(0));
  CHECK(test::refusal([&] { (void)led_field(sensor, surface, 0, Forgetful{}, points); }) ==
        "the light model gives 3 directions for 4 points");
}

TEST_CASE("the coating's light is of a raster of the camera's size") {
  const auto sensor = gelsight_mini(32, 24, 0.002f);
  const auto rest = rasterize(sensor.membrane, sensor.camera);
  auto faces = rest, depths = rest;
  faces.face = Image<Index>(32, 23, 0);
  depths.depth = Image<float>(31, 24, 0.02f);
  CHECK(test::refusal([&] { (void)coating_light(sensor, rest); }) == "accepted");
  CHECK(test::refusal([&] { (void)coating_light(sensor, faces); }) ==
        "the image of faces is 32 x 23 pixels, the camera's image 32 x 24");
  CHECK(test::refusal([&] { (void)coating_light(sensor, depths); }) ==
        "the depth image is 31 x 24 pixels, the camera's image 32 x 24");
}

TEST_CASE("a sensor that cannot be is refused") {
  CHECK(test::refusal([] { (void)geltip<double>(0, 480); }) != "accepted");
  CHECK(test::refusal([] { (void)geltip<double>(640, 480, 0.02); }) != "accepted");
}

namespace {

/// A light model that keeps where LEDs shine.
template <class T>
struct KeepsEmission {
  static constexpr bool needs_emission = true;
  std::vector<Vec3<T>>* kept;

  [[nodiscard]] LightField<T> field(const Led<T>& led, std::span<const SurfacePoint<T>> points,
                                    const CancelHook& /*cancelled*/ = {}) const {
    kept->push_back(led.emission);
    return LightField<T>(points.size(), Vec3<T>::UnitX());
  }
};

}  // namespace

TEST_CASE_TEMPLATE("LEDs shine across the border, whatever the triangles there", T, float, double) {
  for (const std::size_t flipped : {0U, 1U, 2U}) {  // no diagonals, all, or every other
    for (const Index cells : {1, 2, 5, 16}) {
      CAPTURE(flipped);
      CAPTURE(cells);
      SensorPreset<T> sensor;
      sensor.membrane = grid<T>(cells, cells + 1, 2, 3);
      auto& faces = sensor.membrane.faces;
      for (std::size_t f = 0; f < faces.size() && flipped > 0; f += 2 * flipped) {
        const auto [a, b, c] = faces[f];
        const Index d = faces[f + 1][2];
        faces[f] = {a, b, d};
        faces[f + 1] = {b, c, d};
      }
      const Surface<T> surface(sensor.membrane);
      std::vector<Vec3<T>> expected;
      const auto add = [&](const SurfacePoint<T>& led) {
        const Vec3<T> p = surface.position(led);
        const Vec3<T> inwards(T(p.x() < T(1e-5)) - T(p.x() > T(2 - 1e-5)),
                              T(p.y() < T(1e-5)) - T(p.y() > T(3 - 1e-5)), 0);
        sensor.leds.push_back(led);
        expected.push_back(inwards.normalized());  // at a corner the diagonal
      };
      for (Index h = 0; h < surface.halfedge_count(); ++h) {
        if (!surface.is_border(h)) continue;
        for (const T share : {T(0.01), T(0.5), T(0.9)}) {
          add(edge_point<T>(surface.origin(h), surface.tip(h), share));
        }
        add(vertex_point<T>(surface.origin(h)));
      }
      sensor.led_width = 0;
      std::vector<Vec3<T>> kept;
      const std::vector<SurfacePoint<T>> points{vertex_point<T>(0)};
      for (std::size_t k = 0; k < sensor.leds.size(); ++k) {
        (void)led_field(sensor, surface, k, KeepsEmission<T>{&kept}, points);
        CHECK((kept.back() - expected[k]).norm() < T(1e-5));
      }
    }
  }
}
